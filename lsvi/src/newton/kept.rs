//! Steps by simplified Newton iterations with factors kept from an earlier step.
//!
//! Let A be ∂F/∂x at the end of an earlier step of the same size. The first increment, A⁻¹F(h, x₀) from the solution x₀ at h = 0,
//! leads to the root but for a rest, which is smooth along a trajectory and is extrapolated from the last steps. What is
//! needed for the root to be on the branch of x₀ comes with the iteration:
//!
//! - A differs from its limit for h → 0 by a matrix of norm [`CLOSE`] at most, which is measured where A is factored;
//! - the rest is at most [`SURE_CONTRACTION`] of the way from x₀ to the root, so that A is close to the mean of the derivative
//!   on that way;
//! - the increments contract by [`SURE_CONTRACTION`].
//!
//! So on the whole way the derivative acts as its limit does, and the root is the one in reach. Where this is not found, the
//! step is left to [`Newton::solve`].

use super::{CLOSE, Limit, LimitAtZero, Newton, SURE_CONTRACTION, System};
use crate::linalg::{Jacobian, Lu, Structure, by_size, larger, size};

/// Iterations after the first increment; an exact derivative needs no more.
const ITERATIONS: u32 = 6;
/// Iterations after which new factors pay, once the last ones have served for some steps: to make them costs several iterations.
const FAST: u32 = 2;
const LEAST_AGE: u32 = 8;
/// Increments of a few roundings may do as they like.
const ROUNDINGS: f64 = 16.0;
/// Steps to wait, at most, before factors are kept again after they did not serve.
const LONGEST_PAUSE: u32 = 64;

/// Kept factors and the rests of the last steps.
#[derive(Debug)]
pub(super) struct Kept {
    /// Step size of the factors.
    h: Option<f64>,
    lu: Lu,
    /// Steps that they served for.
    age: u32,
    /// A⁻¹ by columns, of few unknowns.
    inverse: Vec<f64>,
    /// What was left of each unknown after the first increment in the last steps, the last one first.
    rests: Vec<[f64; 3]>,
    known: usize,
    pause: u32,
    waited: u32,
}

impl Kept {
    pub(super) fn new(jacobian: &Jacobian) -> Self {
        Self {
            h: None,
            lu: Lu::of(jacobian),
            age: 0,
            inverse: by_size!(jacobian.dim(), N => vec![0.0; N * N]),
            rests: vec![[0.0; 3]; jacobian.dim()],
            known: 0,
            pause: 0,
            waited: 0,
        }
    }

    /// Takes over A; of few unknowns its inverse, whose product costs less than the factors.
    fn factor(&mut self, a: &Jacobian) -> bool {
        self.age = 0;
        let is_regular = self.lu.factor(a).is_ok();
        self.inverse.fill(0.0);
        for (j, column) in self.inverse.chunks_exact_mut(a.dim()).enumerate() {
            column[j] = 1.0;
            self.lu.solve(column);
        }
        is_regular
    }

    /// Overwrites `b` with A⁻¹ b.
    #[inline(always)]
    fn solve<const N: usize>(&mut self, b: &mut [f64]) {
        let Some(right) = b.first_chunk_mut::<N>().filter(|_| N > 0) else { return self.lu.solve(b) };
        let inverse = &self.inverse[..N * N];
        let mut product = [0.0; N];
        for j in 0..N {
            for i in 0..N {
                product[i] += inverse[j * N + i] * right[j];
            }
        }
        *right = product;
    }

    /// Adds the rest of the step to come, by the polynomial through those that are known.
    #[inline]
    fn add_expected<const N: usize>(&self, x: &mut [f64]) {
        const WEIGHTS: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, -1.0, 0.0], [3.0, -3.0, 1.0]];
        let [wa, wb, wc] = WEIGHTS[self.known];
        for (x, [a, b, c]) in x.iter_mut().zip(&self.rests[..size::<N>(self.rests.len())]) {
            *x += wa * a + wb * b + wc * c;
        }
    }

    fn drop_factors(&mut self) {
        self.h = None;
        self.known = 0;
        self.pause = (2 * self.pause).clamp(1, LONGEST_PAUSE);
        self.waited = 0;
    }
}

impl Limit {
    /// Whether A₀⁻¹ `a` differs from the unit matrix by [`CLOSE`] at most in the norm of column sums, A₀ the limit at scale 1.
    fn is_like(&mut self, a: &Jacobian, scale: f64, column: &mut [f64]) -> bool {
        let Some(a) = a.dense().filter(|_| self.is_regular) else { return false };
        let factor = self.scale / scale;
        a.column_iter().enumerate().all(|(j, entries)| {
            column.copy_from_slice(entries.as_slice());
            self.lu.solve(column);
            let difference = |(i, x): (usize, &f64)| (factor * x - if i == j { 1.0 } else { 0.0 }).abs();
            column.iter().enumerate().map(difference).sum::<f64>() <= CLOSE
        })
    }
}

impl Newton {
    /// Replaces `x`, the solution at h = 0, by the root with kept factors; otherwise leaves it as it is and returns false.
    #[inline]
    pub(crate) fn solve_with_kept(&mut self, system: &mut impl System, h: f64, x: &mut [f64]) -> bool {
        if self.kept.as_ref().is_none_or(|kept| kept.h != Some(h)) {
            return false;
        }
        // Where the dimension of a system is a constant, the other sizes are not compiled.
        match by_size!(system.dim(), N => self.contract::<N>(system, h, x)) {
            Some(iterations) => {
                if iterations > FAST && self.kept.as_ref().is_some_and(|kept| kept.age >= LEAST_AGE) {
                    self.keep(system, h, x);
                }
                true
            }
            None => {
                self.kept.iter_mut().for_each(|kept| kept.drop_factors());
                x.copy_from_slice(&self.origin);
                false
            }
        }
    }

    /// The iterations after the first increment, if they find a root on the branch.
    #[inline(always)]
    fn contract<const N: usize>(&mut self, system: &mut impl System, h: f64, x: &mut [f64]) -> Option<u32> {
        let n = size::<N>(x.len());
        let x = &mut x[..n];
        let Self { kept, origin, whole, increment, work, .. } = self;
        let kept = kept.as_deref_mut()?;
        let (origin, whole, increment) = (&mut origin[..n], &mut whole[..n], &mut increment[..n]);
        origin.iter_mut().zip(&*x).for_each(|(origin, x)| *origin = *x);
        system.residual_sized::<N>(h, x, whole);
        work.residuals += 1;
        kept.solve::<N>(whole);
        for i in 0..n {
            x[i] = origin[i] - whole[i];
        }
        kept.add_expected::<N>(x);
        let (scale, mut last) = (system.scale(h), f64::NAN);
        for iterations in 1..ITERATIONS + 1 {
            system.residual_sized::<N>(h, x, increment);
            work.residuals += 1;
            kept.solve::<N>(increment);
            let (mut delta, mut way, mut rest, mut largest, mut sum) = (0.0, 0.0, 0.0, 0.0, 0.0);
            for i in 0..n {
                x[i] -= increment[i];
                let moved = x[i] - origin[i];
                delta = larger(delta, increment[i]);
                way = larger(way, moved);
                rest = larger(rest, moved + whole[i]);
                largest = larger(larger(largest, x[i]), origin[i]);
                sum += x[i];
            }
            let roundoff = f64::EPSILON * largest;
            let noise = ROUNDINGS * roundoff;
            if rest > SURE_CONTRACTION * way + noise || !sum.is_finite() {
                return None;
            }
            let theta = delta / last;
            // What is left adds up along a trajectory: relative to q it is 1/h of that in a momentum.
            let allowed = if scale == 1.0 { roundoff } else { f64::EPSILON * way };
            if delta <= 4.0 * allowed || theta * delta <= (1.0 - theta) * allowed || last <= noise {
                for (i, rests) in kept.rests[..n].iter_mut().enumerate() {
                    *rests = [x[i] - origin[i] + whole[i], rests[0], rests[1]];
                }
                kept.known = (kept.known + 1).min(3);
                kept.pause = 0;
                kept.age = kept.age.saturating_add(1);
                return Some(iterations);
            }
            if theta > SURE_CONTRACTION {
                return None;
            }
            last = delta;
        }
        None
    }

    /// Keeps the factors of ∂F/∂x at a solution for steps of the same size, if they are like their limit for h → 0.
    #[cold]
    pub(crate) fn keep(&mut self, system: &mut impl System, h: f64, x: &[f64]) {
        if self.jacobian.structure() != Structure::Dense || system.limit() != LimitAtZero::Kept {
            return;
        }
        let kept = self.kept.get_or_insert_with(|| Box::new(Kept::new(&self.jacobian)));
        if kept.waited < kept.pause {
            kept.waited += 1;
            return;
        }
        system.residual(h, x, &mut self.part);
        self.jacobian.clear();
        system.derivative(h, x, &mut self.jacobian);
        self.work.residuals += 1;
        self.work.factorizations += 1;
        let is_like = self.limit.is_like(&self.jacobian, system.scale(h), &mut self.part);
        if is_like && kept.factor(&self.jacobian) {
            if kept.h != Some(h) {
                kept.known = 0;
            }
            kept.h = Some(h);
        } else {
            kept.drop_factors();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x = s g(x).
    struct Implicit<G>(G);

    impl<G: Fn(f64) -> f64> System for Implicit<G> {
        fn dim(&self) -> usize {
            1
        }
        fn residual(&mut self, s: f64, x: &[f64], out: &mut [f64]) {
            out[0] = x[0] - s * self.0(x[0]);
        }
        fn derivative(&mut self, s: f64, x: &[f64], out: &mut Jacobian) {
            const D: f64 = 1e-6;
            out.add(0, 0, 1.0 - s * (self.0(x[0] + D) - self.0(x[0] - D)) / (2.0 * D));
        }
        fn limit(&self) -> LimitAtZero {
            LimitAtZero::Kept
        }
    }

    /// The first increment leads to x = −0.05, beyond the root of the branch, and the next one to another root, x = 1, near
    /// which the iteration contracts.
    #[test]
    fn a_root_that_the_first_increment_does_not_lead_to_is_not_taken() {
        let mut newton = Newton::new(1);
        let (mut before, mut x) = ([0.0], [0.0]);
        newton.solve(&mut Implicit(|_| 0.5), 1.0, &mut before).expect("affine");
        newton.keep(&mut Implicit(|_| 0.5), 1.0, &before);
        let mut dip = Implicit(|x: f64| 1.0 - 1.05 * (-(x / 0.02).powi(2)).exp());
        assert!(!newton.solve_with_kept(&mut dip, 1.0, &mut x), "{x:?}");
        assert_eq!(x, [0.0]);
        // Without the dip it is.
        newton.solve(&mut Implicit(|_| 0.5), 1.0, &mut [0.0]).expect("affine");
        (0..=LONGEST_PAUSE).for_each(|_| newton.keep(&mut Implicit(|_| 0.5), 1.0, &before));
        assert!(newton.solve_with_kept(&mut Implicit(|_| 1.0), 1.0, &mut x));
        assert_eq!(x, [1.0]);
    }
}
