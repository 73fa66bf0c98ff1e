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
    /// Ratio of the first two increments of the last step that took two to find it.
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
            contraction: SURE_CONTRACTION,
            inverse: by_size!(jacobian.dim(), N => vec![0.0; N * N]),
            rests: vec![Rest::default(); jacobian.dim()],
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

    /// Whether a step takes two increments, to find their ratio: it grows with the age of the factors, and is found anew before it
    /// has doubled.
    #[inline(always)]
    fn is_to_find_contraction(&self) -> bool {
        self.age < LEAST_AGE || self.age.is_multiple_of(LEAST_AGE)
    }

    /// The ratio of the next increment to the last one that is to be expected. Of 1 − A⁻¹ ∂F/∂x the mean on the way is `rest`/`way`
    /// in its direction, and at the end of it more by half of `change`/`way`, what it is more than in the last step; in other
    /// directions there is the last ratio that was found.
    #[inline(always)]
    fn expected_contraction(&self, rest: f64, change: f64, way: f64) -> f64 {
        larger((rest + change) / way, 2.0 * self.contraction)
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
        match by_size!(system.dim(), N => self.contract::<N>(system, h, x), else self.contract_many(system, h, x)) {
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

    /// [`Self::contract`] of many unknowns, compiled once for all systems.
    fn contract_many(&mut self, mut system: &mut dyn System, h: f64, x: &mut [f64]) -> Option<u32> {
        self.contract::<0>(&mut system, h, x)
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
        let is_to_find = kept.is_to_find_contraction();
        if is_to_find {
            // Of increments that are lost in rounding no ratio is found: then the largest that is accepted, after it has doubled.
            kept.contraction = 0.5 * SURE_CONTRACTION;
        }
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
            let theta = match iterations {
                1 if is_to_find => f64::INFINITY,
                1 => kept.expected_contraction(rest, change, way),
                _ => delta / last,
            };
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
    pub(crate) fn keep(&mut self, system: &mut dyn System, h: f64, x: &[f64]) {
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
    use crate::{Integrator, OneStep, VectorField, field, method_i};

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
            // The next one is the largest, and the highest difference sums 2⁵ roundings of others; so do those below, twice.
            let rounding = 4.0 * f64::from(1 << HIGHEST) * f64::EPSILON * next.abs();
            assert!((found - next).abs() <= rounding, "degree {degree}: {found} for {next}");
        }
        let (found, _) = expected(9, &|t| 1.0 + 1e-3 * (-1.0_f64).powf(t));
        assert_eq!(found, 1.0 + 1e-3, "differences that grow are left out");
        assert_eq!(expected(1, &|_| 3.0).0, 3.0, "of one rest it is the next");
        assert_eq!(expected(2, &|t| 3.0 + 1e-3 * t).0, 3.0 + 1e-3, "and of two the last");
    }

    #[test]
    fn the_contraction_to_expect_is_the_larger_of_two_and_is_found_anew() {
        let mut kept = Kept::new(&Jacobian::zeros(1));
        for (contraction, expected) in [(1e-3, 0.03), (0.03, 0.06)] {
            kept.contraction = contraction;
            assert!((kept.expected_contraction(0.02, 0.01, 1.0) - expected).abs() < f64::EPSILON);
        }
        let is_to_find = [0, LEAST_AGE - 1, LEAST_AGE, LEAST_AGE + 1, 2 * LEAST_AGE - 1, 2 * LEAST_AGE].map(|age| {
            kept.age = age;
            kept.is_to_find_contraction()
        });
        assert_eq!(is_to_find, [true, true, true, false, false, true]);
    }

    /// The largest difference, in roundings of the state, of steps of Method I with kept factors from steps of the same state
    /// without any, and the evaluations of a step.
    fn kept_against_new<F: VectorField>(field: impl Fn() -> F, start: &[f64], h: f64) -> [f64; 2] {
        const STEPS: u32 = 400;
        let mut kept = method_i(field()).expect("a regular system");
        let (mut v, mut p, mut most) = (start.to_vec(), vec![0.0; start.len()], 0.0);
        for k in 0..STEPS {
            let (t, mut next) = (f64::from(k) * h, v.clone());
            method_i(field()).map(|mut new| new.step(t, h, &mut next, &mut p)).expect("a system").expect("a root");
            kept.step(t, h, &mut v, &mut p).expect("a root");
            let size = v.iter().fold(0.0, |most, x| larger(most, *x));
            v.iter().zip(&next).for_each(|(v, next)| most = larger(most, (v - next) / (f64::EPSILON * size)));
        }
        [most, kept.work().residuals as f64 / f64::from(STEPS)]
    }

    #[test]
    fn kept_factors_lead_to_the_root_that_new_ones_lead_to() {
        let drag = || field!(1, |_t, v, dv| dv[0] = -v[0] * v[0]);
        let pendulum = || {
            field!(2, |_t, v, dv| {
                dv[0] = v[1];
                dv[1] = -v[0].sin() - v[1] * 0.2;
            })
        };
        // The rate of what moves little changes along what moves much.
        let across = |rate: f64| {
            field!(2, rate = rate; |_t, v, dv| {
                dv[0] = T::from(1.0);
                dv[1] = (v[0].sin() * 0.5 + 1.0) * ((v[0] * 3.0).cos() * 1e-3 - v[1]) * rate;
            })
        };
        for (name, [apart, evaluations]) in [
            ("drag", kept_against_new(drag, &[1.0], 0.01)),
            ("pendulum", kept_against_new(pendulum, &[1.0, 0.0], 0.01)),
            ("pendulum, long steps", kept_against_new(pendulum, &[1.0, 0.0], 0.1)),
            ("across", kept_against_new(|| across(1.0), &[0.0, 0.0], 0.01)),
            ("across, stiff", kept_against_new(|| across(20.0), &[0.0, 0.0], 0.01)),
            ("across, long", kept_against_new(|| across(20.0), &[0.0, 0.0], 0.05)),
        ] {
            // What the last increment leaves: up to 16/7 of a rounding here and one there, and a rounding of each sum.
            assert!(apart <= 4.0, "{name}: {apart} roundings apart after {evaluations} evaluations a step");
            let is_smooth = !name.contains(", ");
            assert!(!is_smooth || evaluations < 2.75, "{name}: {evaluations} evaluations a step");
        }
    }

    #[test]
    fn factors_serve_steps_of_their_own_size_alone() {
        let pendulum = field!(2, |_t, v, dv| {
            dv[0] = v[1];
            dv[1] = -v[0].sin();
        });
        let mut method = method_i(pendulum).expect("usable");
        let (mut v, mut p) = ([1.0, 0.0], [0.0; 2]);
        let is_factored = [0.01, 0.01, 0.0105, 0.0105, 0.01, 0.01].map(|h| {
            let before = method.work().factorizations;
            method.step(0.0, h, &mut v, &mut p).expect("short");
            method.work().factorizations > before
        });
        assert_eq!(is_factored, [true, false, true, false, true, false]);
    }

    /// x − (1 + m x) = 0 by the factor 1 leaves the rest m x: nine hundredths of the way more than in the step before, which had −m x, are too much for
    /// an increment of ten roundings to be the last.
    #[test]
    fn a_rest_that_changes_asks_for_one_more_increment() {
        let m = 0.045;
        let root = 1.0 / (1.0 - m);
        let [as_before, changed] = [1.0, -1.0].map(|sign| {
            let mut newton = Newton::new(1);
            newton.solve(&mut Implicit(|_| 1.0), 1.0, &mut [0.0]).expect("affine");
            newton.keep(&mut Implicit(|_| 1.0), 1.0, &[1.0]);
            let kept = newton.kept.as_mut().expect("a derivative like its limit");
            (kept.age, kept.contraction) = (LEAST_AGE + 1, 1e-3);
            kept.rests[0].differences[0] = sign * (root - 1.0);
            kept.rests[0].expected = root - 1.0 + 10.0 * f64::EPSILON;
            let (before, mut x) = (newton.work.residuals, [0.0]);
            assert!(newton.solve_with_kept(&mut Implicit(|x| 1.0 + m * x), 1.0, &mut x));
            approx::assert_abs_diff_eq!(x[0], root, epsilon = 2.0 * f64::EPSILON);
            newton.work.residuals - before
        });
        assert_eq!([as_before, changed], [2, 3]);
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

    /// The first increment leads a part of the way to the root, and the next one to it: the more is left, the less the factor has to do with
    /// the derivative on the way.
    #[test]
    fn a_root_is_taken_where_the_first_increment_leads_most_of_the_way() {
        let found = [0.05, 0.3, 0.5, 0.8].map(|rest| {
            let mut newton = Newton::new(1);
            newton.solve(&mut Implicit(|_| 1.0), 1.0, &mut [0.0]).expect("affine");
            newton.keep(&mut Implicit(|_| 1.0), 1.0, &[1.0]);
            let mut dip = Implicit(|x: f64| 1.0 - rest * (-(x / 0.02).powi(2)).exp());
            newton.solve_with_kept(&mut dip, 1.0, &mut [0.0])
        });
        assert_eq!(found, [true, false, false, false]);
    }
}
