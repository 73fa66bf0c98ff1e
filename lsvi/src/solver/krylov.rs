//! Krylov iterations on slices, in storage that is allocated once.
//!
//! Those of faer ask for operators that can be shared between threads and for Euclidean norms; the systems of a step are at
//! home in the norms of M and M⁻¹, which these take.

use crate::error::SolveError;
use crate::linalg::is_zero;

/// aᵀb, in several sums side by side: one would wait for each of its additions.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    const SUMS: usize = 4;
    let (a, b) = (a.chunks_exact(SUMS), b.chunks_exact(SUMS));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    let mut sums = [0.0; SUMS];
    for (a, b) in a.zip(b) {
        sums.iter_mut().zip(a.iter().zip(b)).for_each(|(sum, (a, b))| *sum += a * b);
    }
    sums.iter().sum::<f64>() + rest
}

/// y += a x.
pub(super) fn axpy(a: f64, x: &[f64], y: &mut [f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += a * x);
}

/// y = x + b y.
fn xpby(x: &[f64], b: f64, y: &mut [f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y = x + b * *y);
}

/// A matrix to multiply with, a preconditioner to solve with.
pub(super) trait System {
    /// Writes A x.
    fn multiply(&mut self, x: &[f64], out: &mut [f64]);

    /// Writes an approximation of A⁻¹ x.
    fn precondition(&mut self, x: &[f64], out: &mut [f64]);
}

/// Conjugate gradients for symmetric positive definite systems.
#[derive(Debug)]
pub(super) struct ConjugateGradients {
    residual: Vec<f64>,
    preconditioned: Vec<f64>,
    direction: Vec<f64>,
    product: Vec<f64>,
    /// The preconditioner's own matrix times the direction.
    image: Vec<f64>,
}

impl ConjugateGradients {
    pub(super) fn new(n: usize) -> Self {
        let zeros = vec![0.0; n];
        Self {
            residual: zeros.clone(),
            preconditioned: zeros.clone(),
            direction: zeros.clone(),
            product: zeros.clone(),
            image: zeros,
        }
    }

    /// Overwrites `b` with the solution and returns the number of iterations.
    ///
    /// `multiply` writes A p, given p and N p where N is the matrix of the preconditioner: N p = r + β N p along the
    /// directions p = z + β p of the iteration, because z = N⁻¹ r. `tolerance` is relative, in the norm of N⁻¹ of residuals.
    pub(super) fn solve(
        &mut self,
        mut multiply: impl FnMut(&[f64], &[f64], &mut [f64]),
        mut precondition: impl FnMut(&[f64], &mut [f64]),
        tolerance: f64,
        most: u32,
        b: &mut [f64],
    ) -> Result<u32, SolveError> {
        self.residual.copy_from_slice(b);
        b.fill(0.0);
        precondition(&self.residual, &mut self.preconditioned);
        let start = dot(&self.residual, &self.preconditioned);
        let mut rho = start;
        if !start.is_finite() {
            return Err(SolveError::NonFinite);
        }
        // What a preconditioner that is not positive definite makes of a residual does not measure it.
        if start < 0.0 || is_zero(&self.preconditioned) && !is_zero(&self.residual) {
            return Err(SolveError::Linear { iterations: 0, residual: 1.0 });
        }
        self.direction.copy_from_slice(&self.preconditioned);
        self.image.copy_from_slice(&self.residual);
        for iterations in 0..most {
            if rho <= tolerance * tolerance * start {
                return Ok(iterations);
            }
            multiply(&self.direction, &self.image, &mut self.product);
            let alpha = rho / dot(&self.direction, &self.product);
            if !alpha.is_finite() {
                return Err(SolveError::NonFinite);
            }
            axpy(alpha, &self.direction, b);
            axpy(-alpha, &self.product, &mut self.residual);
            precondition(&self.residual, &mut self.preconditioned);
            let next = dot(&self.residual, &self.preconditioned);
            if next < 0.0 {
                return Err(SolveError::Linear { iterations: iterations + 1, residual: (next.abs() / start).sqrt() });
            }
            let beta = next / rho;
            rho = next;
            xpby(&self.preconditioned, beta, &mut self.direction);
            xpby(&self.residual, beta, &mut self.image);
        }
        Err(SolveError::Linear { iterations: most, residual: (rho / start).sqrt() })
    }
}

/// Restarted GMRES with the preconditioner on the right, for any regular system.
#[derive(Debug)]
pub(super) struct Gmres {
    /// An orthonormal basis of the Krylov space, its images under the preconditioner not kept.
    basis: Vec<Vec<f64>>,
    /// The Hessenberg matrix by columns, made triangular by rotations.
    triangle: Vec<Vec<f64>>,
    rotations: Vec<(f64, f64)>,
    rhs: Vec<f64>,
    x: Vec<f64>,
    work: Vec<f64>,
}

/// Directions between restarts.
const RESTART: usize = 40;

impl Gmres {
    pub(super) fn new(n: usize) -> Self {
        let m = RESTART.min(n.max(1));
        Self {
            basis: vec![vec![0.0; n]; m + 1],
            triangle: vec![vec![0.0; m + 1]; m],
            rotations: vec![(1.0, 0.0); m],
            rhs: vec![0.0; m + 1],
            x: vec![0.0; n],
            work: vec![0.0; n],
        }
    }

    /// Overwrites `b` with the solution and returns the number of iterations; `tolerance` is that of the Euclidean residual,
    /// relative to `b`.
    pub(super) fn solve(
        &mut self,
        system: &mut dyn System,
        tolerance: f64,
        most: u32,
        b: &mut [f64],
    ) -> Result<u32, SolveError> {
        let start = dot(b, b).sqrt();
        self.x.fill(0.0);
        let (mut iterations, mut residual) = (0, start);
        while residual > tolerance * start {
            if iterations >= most {
                return Err(SolveError::Linear { iterations, residual: residual / start });
            }
            // The residual b − A x of a restart.
            if iterations > 0 {
                system.multiply(&self.x, &mut self.work);
                self.basis[0].copy_from_slice(b);
                axpy(-1.0, &self.work, &mut self.basis[0]);
            } else {
                self.basis[0].copy_from_slice(b);
            }
            let before = dot(&self.basis[0], &self.basis[0]).sqrt();
            if !before.is_finite() {
                return Err(SolveError::NonFinite);
            }
            if before <= tolerance * start {
                break;
            }
            self.basis[0].iter_mut().for_each(|x| *x /= before);
            self.rhs.fill(0.0);
            self.rhs[0] = before;
            let mut used = 0;
            while used < self.triangle.len() && self.rhs[used].abs() > tolerance * start {
                self.extend(used, system)?;
                used += 1;
            }
            iterations += used as u32;
            residual = self.rhs[used].abs();
            self.add_correction(used, system);
            // A restart that gains nothing has met the rounding of the products.
            if residual > 0.5 * before && used == self.triangle.len() {
                return Err(SolveError::Linear { iterations, residual: residual / start });
            }
        }
        b.copy_from_slice(&self.x);
        Ok(iterations)
    }

    /// Adds direction k + 1 to the basis and column k to the triangle.
    fn extend(&mut self, k: usize, system: &mut dyn System) -> Result<(), SolveError> {
        let (done, rest) = self.basis.split_at_mut(k + 1);
        let next = &mut rest[0];
        system.precondition(&done[k], &mut self.work);
        system.multiply(&self.work, next);
        let column = &mut self.triangle[k];
        column.fill(0.0);
        // Twice is enough (modified Gram–Schmidt).
        for _ in 0..2 {
            for (h, q) in column.iter_mut().zip(done.iter()) {
                let c = dot(q, next);
                *h += c;
                axpy(-c, q, next);
            }
        }
        let norm = dot(next, next).sqrt();
        if !norm.is_finite() {
            return Err(SolveError::NonFinite);
        }
        if norm > 0.0 {
            next.iter_mut().for_each(|x| *x /= norm);
        }
        for (i, &(c, s)) in self.rotations[..k].iter().enumerate() {
            (column[i], column[i + 1]) = (c * column[i] + s * column[i + 1], c * column[i + 1] - s * column[i]);
        }
        let r = column[k].hypot(norm);
        let (c, s) = if r > 0.0 { (column[k] / r, norm / r) } else { (1.0, 0.0) };
        column[k] = r;
        self.rotations[k] = (c, s);
        (self.rhs[k], self.rhs[k + 1]) = (c * self.rhs[k], -s * self.rhs[k]);
        if r > 0.0 { Ok(()) } else { Err(SolveError::Singular) }
    }

    fn add_correction(&mut self, used: usize, system: &mut dyn System) {
        for i in (0..used).rev() {
            let known: f64 = (i + 1..used).map(|j| self.triangle[j][i] * self.rhs[j]).sum();
            self.rhs[i] = (self.rhs[i] - known) / self.triangle[i][i];
        }
        let (sum, image) = self.basis.split_at_mut(used);
        let sum_of = &mut image[0];
        sum_of.fill(0.0);
        sum.iter().zip(&self.rhs).for_each(|(q, y)| axpy(*y, q, sum_of));
        system.precondition(sum_of, &mut self.work);
        axpy(1.0, &self.work, &mut self.x);
    }
}

/// A rectangular operator (x, B x) into a space with the norm of (μ' M, M⁻¹), for LSMR.
pub(super) trait LeastSquaresSystem {
    /// Sets (u, w) to (x − a u, B x − a w) and returns the norm of the result.
    fn forward(&mut self, x: &[f64], a: f64, u: &mut [f64], w: &mut [f64]) -> f64;

    /// Writes the adjoint of (u, w), μ' M u + BᵀM⁻¹ w.
    fn adjoint(&mut self, u: &[f64], w: &[f64], out: &mut [f64]);

    /// Writes N⁻¹ x.
    fn precondition(&mut self, x: &[f64], out: &mut [f64]);
}

/// LSMR (D. Fong, M. Saunders, SIAM J. Sci. Comput. 33, 2011) with a preconditioner in the space of solutions.
///
/// It solves the normal equations without forming them, so that rounding meets the condition number and not its square.
#[derive(Debug)]
pub(super) struct Lsmr {
    /// v and N v.
    v: Vec<f64>,
    nv: Vec<f64>,
    adjoint: Vec<f64>,
    h: Vec<f64>,
    hbar: Vec<f64>,
}

impl Lsmr {
    pub(super) fn new(n: usize) -> Self {
        let zeros = vec![0.0; n];
        Self { v: zeros.clone(), nv: zeros.clone(), adjoint: zeros.clone(), h: zeros.clone(), hbar: zeros }
    }

    /// Writes the x that minimises the norm of (u − x, w − B x) and returns the number of iterations; u and w, of the given
    /// norm, are overwritten. `tolerance` is that of the gradient, relative to the first, in the norm of N⁻¹.
    pub(super) fn solve(
        &mut self,
        system: &mut impl LeastSquaresSystem,
        (u, w, norm): (&mut [f64], &mut [f64], f64),
        tolerance: f64,
        most: u32,
        x: &mut [f64],
    ) -> Result<u32, SolveError> {
        x.fill(0.0);
        let mut beta = norm;
        if beta == 0.0 {
            return Ok(0);
        }
        scale(u, w, beta);
        self.nv.fill(0.0);
        let mut alpha = self.bidiagonalise(system, u, w, 0.0)?;
        self.h.copy_from_slice(&self.v);
        self.hbar.fill(0.0);
        let (mut alphabar, mut zetabar, start) = (alpha, alpha * beta, alpha * beta);
        let (mut rho, mut rhobar, mut cbar, mut sbar) = (1.0_f64, 1.0_f64, 1.0_f64, 0.0_f64);
        for iterations in 0..most {
            if zetabar.abs() <= tolerance * start {
                return Ok(iterations);
            }
            beta = system.forward(&self.v, alpha, u, w);
            if beta > 0.0 {
                scale(u, w, beta);
                alpha = self.bidiagonalise(system, u, w, beta)?;
            } else {
                alpha = 0.0;
            }
            let (rho_old, rhobar_old) = (rho, rhobar);
            rho = alphabar.hypot(beta);
            let (c, s) = (alphabar / rho, beta / rho);
            let theta = s * alpha;
            alphabar = c * alpha;
            let thetabar = sbar * rho;
            rhobar = (cbar * rho).hypot(theta);
            (cbar, sbar) = (cbar * rho / rhobar, theta / rhobar);
            let zeta = cbar * zetabar;
            zetabar *= -sbar;
            if !zeta.is_finite() {
                return Err(SolveError::NonFinite);
            }
            xpby(&self.h, -thetabar * rho / (rho_old * rhobar_old), &mut self.hbar);
            axpy(zeta / (rho * rhobar), &self.hbar, x);
            xpby(&self.v, -theta / rho, &mut self.h);
        }
        Err(SolveError::Linear { iterations: most, residual: zetabar.abs() / start })
    }

    /// Sets N v to the adjoint of (u, w) less β N v, normalised in the norm of N⁻¹, and returns that norm.
    fn bidiagonalise(
        &mut self,
        system: &mut impl LeastSquaresSystem,
        u: &[f64],
        w: &[f64],
        beta: f64,
    ) -> Result<f64, SolveError> {
        system.adjoint(u, w, &mut self.adjoint);
        xpby(&self.adjoint, -beta, &mut self.nv);
        system.precondition(&self.nv, &mut self.v);
        let alpha = dot(&self.v, &self.nv).max(0.0).sqrt();
        if !alpha.is_finite() {
            return Err(SolveError::NonFinite);
        }
        if alpha > 0.0 {
            scale(&mut self.v, &mut self.nv, alpha);
        }
        Ok(alpha)
    }
}

fn scale(a: &mut [f64], b: &mut [f64], by: f64) {
    a.iter_mut().chain(b).for_each(|x| *x /= by);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_preconditioner_that_is_not_positive_definite_is_no_solution() {
        let solve = |factor: f64| {
            let mut b = [1.0, 2.0];
            let multiply = |x: &[f64], _: &[f64], out: &mut [f64]| out.copy_from_slice(&[3.0 * x[0], 5.0 * x[1]]);
            let precondition = |x: &[f64], out: &mut [f64]| out.copy_from_slice(&[factor * x[0], factor * x[1]]);
            ConjugateGradients::new(2).solve(multiply, precondition, 1e-12, 50, &mut b).map(|_| b)
        };
        let [x, y] = solve(1.0).expect("positive definite");
        assert!((x - 1.0 / 3.0).abs() < 1e-12 && (y - 0.4).abs() < 1e-12);
        for factor in [0.0, -1.0] {
            assert!(matches!(solve(factor), Err(SolveError::Linear { iterations: 0, .. })), "{factor}");
        }
        for factor in [f64::INFINITY, f64::NAN] {
            assert_eq!(solve(factor), Err(SolveError::NonFinite), "{factor}");
        }
    }

    /// Conjugate gradients take an iteration for each eigenvalue.
    #[test]
    fn iterations_are_counted_as_they_are_made() {
        let solve = |diagonal: [f64; 2], factors: [f64; 2]| {
            let multiply = |x: &[f64], _: &[f64], out: &mut [f64]| (0..2).for_each(|i| out[i] = diagonal[i] * x[i]);
            let precondition = |x: &[f64], out: &mut [f64]| (0..2).for_each(|i| out[i] = factors[i] * x[i]);
            ConjugateGradients::new(2).solve(multiply, precondition, 1e-12, 50, &mut [1.0, 2.0])
        };
        assert_eq!(solve([3.0, 3.0], [1.0; 2]), Ok(1));
        assert_eq!(solve([3.0, 5.0], [1.0; 2]), Ok(2));
        // r = (1, 2) has r·z = 2, and after the first step r·z < 0.
        let error = solve([3.0, 5.0], [-2.0, 1.0]).expect_err("indefinite");
        assert!(matches!(error, SolveError::Linear { iterations: 1, .. }), "{error}");
    }

    /// Eigenvalues from 1 to 100 with a rotation between neighbours, of which 40 directions are not enough.
    struct Spread;

    impl System for Spread {
        fn multiply(&mut self, x: &[f64], out: &mut [f64]) {
            let n = x.len();
            for i in 0..n {
                let rotation = x[(i + 1) % n] - x[(i + n - 1) % n];
                out[i] = (1.0 + 99.0 * i as f64 / (n - 1) as f64) * x[i] + rotation;
            }
        }
        fn precondition(&mut self, x: &[f64], out: &mut [f64]) {
            out.copy_from_slice(x);
        }
    }

    #[test]
    fn gmres_goes_on_from_what_is_left_when_it_restarts() {
        let b: Vec<f64> = (0..300).map(|i| (i as f64 + 1.0).sin()).collect();
        let (mut x, mut residual) = (b.clone(), b.clone());
        let tolerance = 1e-9;
        let iterations = Gmres::new(300).solve(&mut Spread, tolerance, 500, &mut x).expect("regular");
        assert!(iterations > 2 * RESTART as u32, "{iterations} iterations");
        let mut product = vec![0.0; 300];
        Spread.multiply(&x, &mut product);
        axpy(-1.0, &product, &mut residual);
        // The products of a restart add their rounding, 100 ε |x|.
        let (left, size) = (dot(&residual, &residual).sqrt(), dot(&b, &b).sqrt());
        assert!(left <= (tolerance + 1e3 * f64::EPSILON) * size, "{:e}", left / size);
    }

    /// A cyclic shift, on which GMRES gains nothing before its last iteration.
    struct Shift;

    impl System for Shift {
        fn multiply(&mut self, x: &[f64], out: &mut [f64]) {
            let n = x.len();
            (0..n).for_each(|i| out[i] = x[(i + n - 1) % n]);
        }
        fn precondition(&mut self, x: &[f64], out: &mut [f64]) {
            out.copy_from_slice(x);
        }
    }

    #[test]
    fn what_is_left_where_iterations_end_is_relative() {
        for size in [0.125, 1.0, 1024.0] {
            let mut b = [0.0; 2 * RESTART];
            b[0] = size;
            let left = Gmres::new(2 * RESTART).solve(&mut Shift, 1e-12, 500, &mut b);
            assert_eq!(
                left,
                Err(SolveError::Linear { iterations: RESTART as u32, residual: 1.0 }),
                "nothing is gained"
            );
            let solve = |size: f64| {
                let mut b: Vec<f64> = (0..300).map(|i| size * (i as f64 + 1.0).sin()).collect();
                Gmres::new(300).solve(&mut Spread, 1e-9, RESTART as u32, &mut b)
            };
            let Err(SolveError::Linear { residual, .. }) = solve(1.0) else { panic!("{:?}", solve(1.0)) };
            assert!(residual > 1e-9 && residual < 0.5, "{residual}");
            assert_eq!(solve(size), solve(1.0));
            // One iteration of conjugate gradients on diag(1, 3) from (1, 1) leaves half of the residual.
            let multiply = |x: &[f64], _: &[f64], out: &mut [f64]| out.copy_from_slice(&[x[0], 3.0 * x[1]]);
            let precondition = |x: &[f64], out: &mut [f64]| out.copy_from_slice(x);
            let left = ConjugateGradients::new(2).solve(multiply, precondition, 1e-12, 1, &mut [size, size]);
            let Err(SolveError::Linear { iterations: 1, residual }) = left else { panic!("{left:?}") };
            assert!((residual - 0.5).abs() < 1e-12, "{residual}");
        }
    }
}
