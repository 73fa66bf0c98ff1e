//! Steps by simplified Newton iterations with factors kept from an earlier step.
//!
//! Let A be ∂F/∂x at the end of an earlier step of the same size. The first increment, A⁻¹F(h, x₀) from the solution x₀ at h = 0,
//! leads to the root but for a rest, which is smooth along a trajectory and is extrapolated from the last steps. One more
//! increment is enough where the extrapolation is good: how the next one would contract is known from the last steps, and from
//! the rest, which is the mean of 1 − A⁻¹ ∂F/∂x on the way from x₀ times that way. What is needed for the root to be on the
//! branch of x₀ comes with the iteration:
//!
//! - A differs from its limit for h → 0 by a matrix of norm [`CLOSE`] at most, which is measured where A is factored;
//! - the rest is at most [`SURE_CONTRACTION`] of the way from x₀ to the root, so that A is close to the mean of the derivative
//!   on that way;
//! - the increments contract by [`SURE_CONTRACTION`].
//!
//! So on the whole way the derivative acts as its limit does, and the root is the one in reach. Where this is not found, the
//! step is left to [`Newton::solve`].

use std::hint::select_unpredictable;

use super::{CLOSE, Limit, LimitAtZero, Newton, SURE_CONTRACTION, System};
use crate::linalg::{Jacobian, Lu, Structure, by_size, larger, size};

/// Iterations after the first increment; an exact derivative needs no more.
const ITERATIONS: u32 = 6;
/// Iterations after which new factors pay, once the last ones have served for some steps: to make them costs several iterations.
const FAST: u32 = 2;
const LEAST_AGE: u32 = 8;
/// Increments of a few roundings may do as they like.
const ROUNDINGS: f64 = 16.0;
/// The highest difference of rests, which tells how well the one below extrapolates.
const HIGHEST: usize = 5;
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
    /// Ratio of two increments when it was found last, infinite before.
    contraction: f64,
    /// A⁻¹ by columns, of few unknowns.
    inverse: Vec<f64>,
    rests: Vec<Rest>,
    pause: u32,
    waited: u32,
}

/// What the first increment leaves of an unknown.
#[derive(Debug, Clone, Copy, Default)]
struct Rest {
    /// Backward differences over the last steps, ∇⁰ the rest of the last one.
    differences: [f64; HIGHEST + 1],
    /// That of the step to come.
    expected: f64,
}

impl Rest {
    /// Takes over the rest of a step, and expects the next one by the polynomial that would have done best for this one: that
    /// through k + 1 rests was off by ∇ᵏ⁺¹. Of too few steps a difference is as large as the rest.
    #[inline(always)]
    fn push(&mut self, rest: f64) {
        let mut difference = rest;
        for known in &mut self.differences {
            difference -= std::mem::replace(known, difference);
        }
        let [rest, rise, higher @ ..] = self.differences;
        let (mut sum, mut last, mut least) = (rest, rise, rise.abs());
        self.expected = sum;
        for difference in higher {
            sum += last;
            last = difference;
            let is_better = last.abs() < least;
            self.expected = select_unpredictable(is_better, sum, self.expected);
            least = select_unpredictable(is_better, last.abs(), least);
        }
    }
}

impl Kept {
    pub(super) fn new(jacobian: &Jacobian) -> Self {
        Self {
            h: None,
            lu: Lu::of(jacobian),
            age: 0,
            contraction: f64::INFINITY,
            inverse: by_size!(jacobian.dim(), N => vec![0.0; N * N]),
            rests: vec![Rest::default(); jacobian.dim()],
            pause: 0,
            waited: 0,
        }
    }

    /// Takes over A; of few unknowns its inverse, whose product costs less than the factors.
    fn factor(&mut self, a: &Jacobian) -> bool {
        self.age = 0;
        self.contraction = f64::INFINITY;
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

    /// A bound on the contraction of the next increment, where the first one left `rest` of the way and before that `change` less
    /// or more: along the way the mean of what A lacks of the derivative, with twice its change to the end of the way, and across
    /// it twice the last ratio of increments. That grows with the age of the factors, and is found anew before it has doubled.
    #[inline(always)]
    fn expected_contraction(&self, rest: f64, change: f64, way: f64) -> f64 {
        let is_known = self.age >= LEAST_AGE && !self.age.is_multiple_of(LEAST_AGE);
        if is_known { larger((rest + change) / way, 2.0 * self.contraction) } else { f64::INFINITY }
    }

    fn drop_factors(&mut self) {
        self.h = None;
        self.rests.fill(Rest::default());
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
                false
            }
        }
    }

    /// The iterations after the first increment, if they find a root on the branch.
    #[inline(always)]
    fn contract<const N: usize>(&mut self, system: &mut impl System, h: f64, state: &mut [f64]) -> Option<u32> {
        let n = size::<N>(state.len());
        let Self { kept, point, whole, increment, work, .. } = self;
        let kept = kept.as_deref_mut()?;
        // Few numbers stay in registers.
        let mut few = [[0.0; N]; 4];
        let [origin, x, whole, increment] = match few.each_mut() {
            [origin, x, whole, increment] if N > 0 => [&mut origin[..], x, whole, increment],
            _ => [&mut self.origin[..n], &mut point[..n], &mut whole[..n], &mut increment[..n]],
        };
        origin.copy_from_slice(&state[..n]);
        system.residual_sized::<N>(h, origin, whole);
        work.residuals += 1;
        kept.solve::<N>(whole);
        for (i, rest) in kept.rests[..n].iter().enumerate() {
            x[i] = origin[i] - whole[i] + rest.expected;
        }
        let (scale, mut last) = (system.scale(h), f64::NAN);
        for iterations in 1..ITERATIONS + 1 {
            system.residual_sized::<N>(h, x, increment);
            work.residuals += 1;
            kept.solve::<N>(increment);
            let (mut delta, mut way, mut rest, mut change, mut largest, mut sum) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
            for (i, before) in kept.rests[..n].iter().enumerate() {
                x[i] -= increment[i];
                let moved = x[i] - origin[i];
                delta = larger(delta, increment[i]);
                way = larger(way, moved);
                rest = larger(rest, moved + whole[i]);
                change = larger(change, moved + whole[i] - before.differences[0]);
                largest = larger(larger(largest, x[i]), origin[i]);
                sum += x[i];
            }
            let roundoff = f64::EPSILON * largest;
            let noise = ROUNDINGS * roundoff;
            if rest > SURE_CONTRACTION * way + noise || !sum.is_finite() {
                return None;
            }
            let is_first = iterations == 1;
            let theta = if is_first { kept.expected_contraction(rest, change, way) } else { delta / last };
            if iterations == 2 && last > noise {
                kept.contraction = theta;
            }
            // What is left adds up along a trajectory: relative to q it is 1/h of that in a momentum.
            let allowed = if scale == 1.0 { roundoff } else { f64::EPSILON * way };
            let enough = is_first && theta <= SURE_CONTRACTION && delta <= ROUNDINGS * allowed;
            if delta <= 4.0 * allowed || theta * delta <= (1.0 - theta) * allowed || last <= noise || enough {
                for (i, rest) in kept.rests[..n].iter_mut().enumerate() {
                    rest.push(x[i] - origin[i] + whole[i]);
                }
                state[..n].copy_from_slice(x);
                kept.pause = 0;
                kept.age = kept.age.saturating_add(1);
                return Some(iterations);
            }
            if !is_first && theta > SURE_CONTRACTION {
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
                kept.rests.fill(Rest::default());
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

    #[test]
    fn a_rest_is_extrapolated_by_the_polynomial_that_did_best_for_the_last_one() {
        let expected = |steps: i32, rest: &dyn Fn(f64) -> f64| {
            let mut tail = Rest::default();
            (0..steps).for_each(|k| tail.push(rest(f64::from(k))));
            (tail.expected, rest(f64::from(steps)))
        };
        for degree in 0..HIGHEST as i32 {
            let polynomial = |t: f64| (t - 2.5).powi(degree);
            let (found, next) = expected(9, &polynomial);
            assert!((found - next).abs() <= 1e3 * f64::EPSILON * next.abs(), "degree {degree}: {found} for {next}");
        }
        let (found, _) = expected(9, &|t| 1.0 + 1e-3 * (-1.0_f64).powf(t));
        assert_eq!(found, 1.0 + 1e-3, "differences that grow are left out");
        assert_eq!(expected(1, &|_| 3.0).0, 3.0, "of one rest it is the next");
        assert_eq!(expected(2, &|t| 3.0 + 1e-3 * t).0, 3.0 + 1e-3, "and of two the last");
    }

    #[test]
    fn an_increment_is_the_last_one_where_its_contraction_is_known() {
        let mut kept = Kept::new(&Jacobian::zeros(1));
        for (age, contraction, expected) in [
            (0, 1e-3, f64::INFINITY),
            (LEAST_AGE - 1, 1e-3, f64::INFINITY),
            (LEAST_AGE, 1e-3, f64::INFINITY),
            (LEAST_AGE + 1, 1e-3, 0.03),
            (LEAST_AGE + 1, 0.03, 0.06),
            (LEAST_AGE + 1, f64::INFINITY, f64::INFINITY),
            (2 * LEAST_AGE, 1e-3, f64::INFINITY),
        ] {
            (kept.age, kept.contraction) = (age, contraction);
            let found = kept.expected_contraction(0.02, 0.01, 1.0);
            assert!(found == expected || (found - expected).abs() < 1e-15, "{age}, {contraction}: {found}");
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
