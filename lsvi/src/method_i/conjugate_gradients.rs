//! The normal equations by preconditioned conjugate gradients.

use crate::error::SolveError;
use crate::linalg::{Jacobian, Lu, Structure};
use crate::mass::{Mass, MassInverse};

/// On dissipative systems the preconditioned condition number is at most 2 and the error of the energy norm falls by
/// (√2 − 1)/(√2 + 1) per iteration, to rounding in 20; others may need more.
const ITERATIONS: u32 = 500;

/// Conjugate gradients for ((1 + μ) M + P) x = b, P = BᵀM⁻¹B, preconditioned by P, from one LU of B.
///
/// P⁻¹ r = B⁻¹ M B⁻ᵀ r needs no inverse of M, and the product with P no P: along the directions p = z + β p of the
/// iteration, P p = r + β P p, because z = P⁻¹ r.
#[derive(Debug)]
pub(super) struct ConjugateGradients {
    tolerance: f64,
    damping: f64,
    /// Iterations of the last solution.
    iterations: u32,
    b: Lu,
    mass_inverse: MassInverse,
    residual: Vec<f64>,
    preconditioned: Vec<f64>,
    direction: Vec<f64>,
    /// P times the direction.
    image: Vec<f64>,
    /// ((1 + μ) M + P) times the direction, and before that work space.
    product: Vec<f64>,
}

impl ConjugateGradients {
    pub(super) fn new(dim: usize, structure: &Structure, mass: &Mass, tolerance: f64) -> Self {
        let zeros = vec![0.0; dim];
        Self {
            tolerance,
            damping: 0.0,
            iterations: 0,
            b: Lu::of(&Jacobian::with_structure(dim, structure)),
            mass_inverse: MassInverse::new(mass),
            residual: zeros.clone(),
            preconditioned: zeros.clone(),
            direction: zeros.clone(),
            image: zeros.clone(),
            product: zeros,
        }
    }

    pub(super) fn tolerance(&self) -> f64 {
        self.tolerance
    }

    pub(super) fn factor(&mut self, b: &Jacobian, damping: f64) -> Result<(), SolveError> {
        self.damping = damping;
        Ok(self.b.factor(b)?)
    }

    /// Overwrites `x` with M⁻¹ x.
    pub(super) fn mass_solve(&mut self, x: &mut [f64]) -> Result<(), SolveError> {
        self.mass_inverse.solve(x)
    }

    /// Sets z = P⁻¹ r and returns rᵀz.
    fn precondition(&mut self, mass: &Mass) -> f64 {
        self.product.copy_from_slice(&self.residual);
        self.b.solve_transpose(&mut self.product);
        self.preconditioned.fill(0.0);
        mass.mul_add(1.0, &self.product, &mut self.preconditioned);
        self.b.solve(&mut self.preconditioned);
        dot(&self.residual, &self.preconditioned)
    }

    /// Overwrites `b` with the solution.
    ///
    /// rᵀP⁻¹r bounds the squared energy norm of the error from above, and from below within the condition number 2.
    pub(super) fn solve(&mut self, mass: &Mass, b: &mut [f64]) -> Result<(), SolveError> {
        self.residual.copy_from_slice(b);
        b.fill(0.0);
        let mut rho = self.precondition(mass);
        let enough = self.tolerance * self.tolerance * rho;
        self.direction.copy_from_slice(&self.preconditioned);
        self.image.copy_from_slice(&self.residual);
        for iterations in 0..ITERATIONS {
            if rho <= enough {
                self.iterations = iterations;
                return Ok(());
            }
            self.product.copy_from_slice(&self.image);
            mass.mul_add(1.0 + self.damping, &self.direction, &mut self.product);
            let alpha = rho / dot(&self.direction, &self.product);
            if !alpha.is_finite() {
                return Err(SolveError::NonFinite);
            }
            for (x, p) in b.iter_mut().zip(&self.direction) {
                *x += alpha * p;
            }
            for (r, s) in self.residual.iter_mut().zip(&self.product) {
                *r -= alpha * s;
            }
            let next = self.precondition(mass);
            let beta = next / rho;
            rho = next;
            for (p, z) in self.direction.iter_mut().zip(&self.preconditioned) {
                *p = z + beta * *p;
            }
            for (p, r) in self.image.iter_mut().zip(&self.residual) {
                *p = r + beta * *p;
            }
        }
        Err(SolveError::Diverged { iterations: ITERATIONS, increment: rho.sqrt() })
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Heat on n cells, h |λ_max| up to 10⁸: the error falls by 2 (√2 − 1)^(2k) in k iterations, or faster where h |λ_min| > 1.
    #[test]
    fn iterations_do_not_depend_on_the_number_of_unknowns() {
        let structure = Structure::Banded { lower: 1, upper: 1 };
        for (tolerance, most) in [(1e-6, 9), (1e-10, 14), (1e-14, 19)] {
            for n in [20, 200, 2000] {
                for stiffness in [1.0, 1e2, 1e4, 1e8] {
                    let mut b = Jacobian::with_structure(n, &structure);
                    for i in 0..n {
                        b.add(i, i, 1.0 + 0.5 * stiffness);
                        if i > 0 {
                            b.add(i, i - 1, -0.25 * stiffness);
                            b.add(i - 1, i, -0.25 * stiffness);
                        }
                    }
                    let mut method = ConjugateGradients::new(n, &structure, &Mass::Identity, tolerance);
                    method.factor(&b, 0.0).expect("regular");
                    let mut x: Vec<f64> = (0..n).map(|i| 1.0 + (1.3 * i as f64).sin()).collect();
                    method.solve(&Mass::Identity, &mut x).expect("convergent");
                    let slow_mode = (0.5 * std::f64::consts::PI / (n + 1) as f64).sin().powi(2) * stiffness;
                    let most = if slow_mode > 10.0 { most / 2 } else { most };
                    assert!(method.iterations <= most, "n = {n}, {stiffness:e}: {}", method.iterations);
                    assert!(method.iterations > 0);
                }
            }
        }
    }
}
