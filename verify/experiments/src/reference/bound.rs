//! The error bound that every reference carries: the same problem solved at two tolerances.

use super::{Ode, Reference, ReferenceError, Sampled, Work};
use crate::measure::norm::{distance, larger, max_norm};

/// Factor on the difference between the two solves.
///
/// Let e_c and e_f be the errors of the coarse and of the fine solve and |e_f| ≤ ρ|e_c|. Then
/// |e_c − e_f| ≥ (1 − ρ)|e_c| ≥ (1/ρ − 1)|e_f|, so that |e_f| ≤ 2|e_c − e_f| for every ρ ≤ 2/3. From
/// tolerances a factor 100 apart a method of order p, whose local error is O(h^{p+1}), gains 100^{−p/(p+1)} ≤ 0.05 for p ≥ 2.
/// Where steps are as long as they may be, whatever the tolerance, those of the fine solve are half as long: ρ ≤ ½.
const SAFETY: f64 = 2.0;

/// Roundings, in units of ε max|v|, that one step may commit.
///
/// Adams of order twelve adds up to thirteen terms to v in its prediction and one in its correction, the other methods fewer;
/// each addition rounds by at most ε/2.
const ROUNDINGS_PER_STEP: f64 = 7.0;

/// The relative and the absolute tolerance of the finer of the two solves, unless another is asked for, and how much larger that
/// of the coarser is; both the same number, because states are of order one and the
/// bound is absolute. A factor of ten between them is not enough: the order selection of Adams' formulas then hides what is
/// gained. At 1e-13 roundoff in the Newton iterations begins to show.
const RATIO: f64 = 100.0;
pub(crate) const FINE: f64 = 1e-12;
/// The tolerance for a second try, where the bound of the first decides too little: rounding shows, and its bound says so.
pub(crate) const FINER: f64 = 1e-13;

/// Times between two samples at which the two solves are compared as well: the difference of two scalars changes sign where
/// neither of them is right, and a sample may hit that point.
const PROBES: usize = 4;

/// One solve at one tolerance.
#[derive(Debug, Clone)]
pub struct Run {
    /// The state at each time.
    pub states: Vec<Vec<f64>>,
    steps: Vec<u64>,
    /// Work of the whole solve.
    pub work: Work,
}

impl Run {
    /// No state so far of as many as there are `times`.
    #[must_use]
    pub fn with_capacity(times: usize) -> Self {
        Run { states: Vec::with_capacity(times), steps: Vec::with_capacity(times), work: Work::default() }
    }

    /// Records the state at the next time, reached after `steps` steps.
    pub fn push(&mut self, state: Vec<f64>, steps: u64) {
        self.states.push(state);
        self.steps.push(steps);
    }
}

/// Calls `solve(ode, tolerance, times)` at two tolerances and bounds the error of the finer answer.
///
/// The bound at time t is the largest of
/// - twice the largest max-norm difference between the two solves up to t;
/// - the fine tolerance times 1 + |v(t)|, which is all that the solver was asked for in one step;
/// - the roundoff of the steps taken, [`ROUNDINGS_PER_STEP`] · ε max|v| each. Amplification of roundoff by the problem itself is
///   in the difference, for the two solves round differently.
///
/// It needs solves whose error follows their tolerance; hence samples are to be interpolated rather than stepped to. Where a
/// step had to end at every sample, samples closer than the natural step would make both solves the same.
pub(super) fn solve_twice(
    ode: &dyn Ode,
    t0: f64,
    v0: &[f64],
    times: &[f64],
    finest: f64,
    solve: impl Fn(&dyn Ode, f64, &[f64]) -> Result<Run, ReferenceError>,
) -> Result<Sampled, ReferenceError> {
    check(ode, t0, v0, times)?;
    let probed = with_probes(t0, times);
    let coarse = solve(ode, RATIO * finest, &probed)?;
    let fine = solve(&Halved(ode), finest, &probed)?;

    let mut scale = max_norm(v0);
    let mut difference = 0.0_f64;
    let mut bound = Vec::with_capacity(probed.len());
    for ((c, f), &steps) in coarse.states.iter().zip(&fine.states).zip(&fine.steps) {
        difference = larger(difference, distance(c, f));
        scale = larger(scale, max_norm(f));
        let tolerance = finest * (1.0 + max_norm(f));
        let roundoff = ROUNDINGS_PER_STEP * f64::EPSILON * steps as f64 * scale;
        bound.push(larger(larger(SAFETY * difference, tolerance), roundoff));
    }
    let (states, bound) = fine.states.into_iter().zip(bound).skip(PROBES).step_by(PROBES + 1).unzip();
    Ok(Sampled { times: times.to_vec(), states, bound, work: fine.work })
}

/// The solution from `v0` at t = 0 as `reference` solves it in units of the start, where that is smaller than 1: the absolute tolerance, and
/// the bound with it, is then one of a small solution too.
pub(crate) fn solve_in_units(
    reference: &dyn Reference,
    ode: &dyn Ode,
    v0: &[f64],
    times: &[f64],
    finest: f64,
) -> Result<Sampled, ReferenceError> {
    let unit = Some(max_norm(v0)).filter(|size| size.is_normal()).map_or(1.0, |size| size.min(1.0));
    let ode = InUnits::new(ode, &vec![unit; v0.len()]);
    let mut sampled = reference.solve_within(&ode, 0.0, &ode.in_units(v0), times, finest)?;
    sampled.states.iter_mut().for_each(|state| *state = ode.states(state));
    let unit = ode.units.first().copied().unwrap_or(1.0);
    sampled.bound.iter_mut().for_each(|bound| *bound *= unit);
    Ok(sampled)
}

/// An equation v̇ = f(t, v) in units D of its components: ẇ = D⁻¹ f(t, D w) with v = D w, so that a solver's absolute tolerance is in units too.
/// D is diagonal, of powers of two.
pub struct InUnits<'a> {
    ode: &'a dyn Ode,
    units: Vec<f64>,
    longest: f64,
}

impl<'a> InUnits<'a> {
    /// In units of these sizes, which are positive, or half of that.
    pub fn new(ode: &'a dyn Ode, sizes: &[f64]) -> Self {
        // A power of two rounds nothing.
        Self { ode, units: sizes.iter().map(|size| size.log2().floor().exp2()).collect(), longest: f64::INFINITY }
    }

    /// The same, with no step longer than that.
    pub fn within(self, longest: f64) -> Self {
        Self { longest, ..self }
    }

    /// The state whose components are so many units.
    pub fn states(&self, v: &[f64]) -> Vec<f64> {
        v.iter().zip(&self.units).map(|(v, unit)| v * unit).collect()
    }

    /// How many units the components of a state are.
    pub fn in_units(&self, v: &[f64]) -> Vec<f64> {
        v.iter().zip(&self.units).map(|(v, unit)| v / unit).collect()
    }
}

impl Ode for InUnits<'_> {
    fn dim(&self) -> usize {
        self.ode.dim()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.ode.rhs(t, &self.states(v), dv);
        dv.iter_mut().zip(&self.units).for_each(|(rate, unit)| *rate /= unit);
    }
    fn jacobian(&self, t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        self.ode.jacobian(t, &self.states(v), &mut |i, j, x| add(i, j, x * self.units[j] / self.units[i]));
    }
    fn bandwidths(&self) -> Option<(usize, usize)> {
        self.ode.bandwidths()
    }
    fn is_sparse(&self) -> bool {
        self.ode.is_sparse()
    }
    fn product(&self, t: f64, v: &[f64], x: &[f64], out: &mut [f64]) {
        self.ode.product(t, &self.states(v), &self.states(x), out);
        out.iter_mut().zip(&self.units).for_each(|(rate, unit)| *rate /= unit);
    }
    fn is_matrix_free(&self) -> bool {
        self.ode.is_matrix_free()
    }
    fn longest_step(&self, span: f64) -> f64 {
        self.ode.longest_step(span).min(self.longest)
    }
}

/// An equation with steps half as long at most.
struct Halved<'a>(&'a dyn Ode);

impl Ode for Halved<'_> {
    fn dim(&self) -> usize {
        self.0.dim()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.0.rhs(t, v, dv);
    }
    fn jacobian(&self, t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        self.0.jacobian(t, v, add);
    }
    fn bandwidths(&self) -> Option<(usize, usize)> {
        self.0.bandwidths()
    }
    fn is_sparse(&self) -> bool {
        self.0.is_sparse()
    }
    fn product(&self, t: f64, v: &[f64], x: &[f64], out: &mut [f64]) {
        self.0.product(t, v, x, out);
    }
    fn is_matrix_free(&self) -> bool {
        self.0.is_matrix_free()
    }
    fn longest_step(&self, span: f64) -> f64 {
        0.5 * self.0.longest_step(span)
    }
}

/// Every sample time, preceded by [`PROBES`] evenly spaced times.
fn with_probes(t0: f64, times: &[f64]) -> Vec<f64> {
    let mut probed = Vec::with_capacity((PROBES + 1) * times.len());
    let mut last = t0;
    for &t in times {
        probed.extend((1..=PROBES).map(|k| last + (t - last) * (k as f64 / (PROBES + 1) as f64)));
        probed.push(t);
        last = t;
    }
    probed
}

/// Refuses what no solver may be given.
pub(super) fn check(ode: &dyn Ode, t0: f64, v0: &[f64], times: &[f64]) -> Result<(), ReferenceError> {
    let refuse = |reason: String| Err(ReferenceError::Input(reason));
    if ode.dim() == 0 {
        return refuse("the system has no unknowns".into());
    }
    if v0.len() != ode.dim() {
        return refuse(format!("the initial state has {} components, the system {}", v0.len(), ode.dim()));
    }
    if let Some((i, x)) = v0.iter().enumerate().find(|(_, x)| !x.is_finite()) {
        return refuse(format!("component {i} of the initial state is {x}"));
    }
    if !t0.is_finite() {
        return refuse(format!("the initial time is {t0}"));
    }
    let mut last = t0;
    for &t in times {
        if !t.is_finite() {
            return refuse(format!("a sample time is {t}"));
        }
        if t < last {
            return refuse(format!("sample times must not decrease: {t} follows {last}"));
        }
        last = t;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::tests::Still;

    /// Bounds at t = 1, 2 and 3 of two solves that differ by `apart` at t.
    fn bounds(apart: impl Fn(f64) -> f64) -> Vec<f64> {
        let solve = |_: &dyn Ode, tolerance: f64, times: &[f64]| {
            let mut run = Run::with_capacity(times.len());
            let coarse = if tolerance > 1e-9 { 1.0 } else { 0.0 };
            times.iter().for_each(|t| run.push(vec![1.0 + coarse * apart(*t)], 1));
            Ok(run)
        };
        solve_twice(&Still(f64::INFINITY), 0.0, &[1.0], &[1.0, 2.0, 3.0], 1e-9, solve).expect("solved").bound
    }

    /// A banded system whose Jacobian is known by its products.
    struct Structured;

    impl Ode for Structured {
        fn dim(&self) -> usize {
            3
        }
        fn rhs(&self, _t: f64, _v: &[f64], dv: &mut [f64]) {
            dv.fill(0.0);
        }
        fn jacobian(&self, _t: f64, _v: &[f64], _add: &mut dyn FnMut(usize, usize, f64)) {}
        fn bandwidths(&self) -> Option<(usize, usize)> {
            Some((2, 1))
        }
        fn is_sparse(&self) -> bool {
            false
        }
        fn is_matrix_free(&self) -> bool {
            true
        }
    }

    #[test]
    fn units_and_halved_steps_leave_the_structure_as_it_is() {
        let (units, halved) = (InUnits::new(&Structured, &[1.0, 2.0, 4.0]), Halved(&Structured));
        for ode in [&units as &dyn Ode, &halved] {
            assert_eq!((ode.dim(), ode.bandwidths()), (3, Some((2, 1))));
            assert_eq!((ode.is_sparse(), ode.is_matrix_free()), (false, true));
        }
    }

    /// Seven roundings of the largest state so far in each of a billion steps are above a tolerance of 1e-9.
    #[test]
    fn rounding_counts_by_the_largest_state_and_the_steps() {
        let growing = |_: &dyn Ode, _: f64, times: &[f64]| {
            let mut run = Run::with_capacity(times.len());
            let size = |t: f64| if t < 2.0 { 1.0 } else { 1e6 };
            times.iter().for_each(|t| run.push(vec![size(*t)], if *t < 3.0 { 1 } else { 1_000_000_000 }));
            Ok(run)
        };
        let bound =
            solve_twice(&Still(f64::INFINITY), 0.0, &[1.0], &[1.0, 2.0, 3.0], 1e-9, growing).expect("solved").bound;
        assert_eq!(bound, [2e-9, 1e-9 * (1.0 + 1e6), 7.0 * f64::EPSILON * 1e15]);
    }

    /// A difference stays in the bound of all later times, one between two samples too, and the tolerance is its least value.
    #[test]
    fn bounds_do_not_fall_where_two_solves_cross() {
        assert_eq!(bounds(|_| 0.0), [2e-9; 3]);
        let crossed = bounds(|t| if t == 1.0 { 0.25 } else { 0.0 });
        assert_eq!(crossed, [0.5; 3]);
        let between = bounds(|t| if t > 1.0 && t < 2.0 { 0.25 } else { 0.0 });
        assert_eq!(between, [2e-9, 0.5, 0.5]);
    }

    /// An absolute tolerance of 10⁻¹² would see nothing of what is below that.
    #[test]
    fn a_small_solution_is_known_relative_to_its_size() {
        struct Small;
        impl Ode for Small {
            fn dim(&self) -> usize {
                1
            }
            fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
                dv[0] = 1e12 * v[0] * v[0] - v[0];
            }
            fn jacobian(&self, _t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
                add(0, 0, 2e12 * v[0] - 1.0);
            }
        }
        // In units of 10⁻¹², v̇ = v² − v from a half: v = 1/(1 + e^t).
        let reference = crate::reference::by_name("diffsol-tsit45").expect("always built");
        let found = solve_in_units(reference, &Small, &[5e-13], &[1.0, 2.0], FINE).expect("solved");
        for ((t, state), bound) in found.times.iter().zip(&found.states).zip(&found.bound) {
            let error = (state[0] - 1e-12 / (1.0 + t.exp())).abs();
            assert!(error <= *bound && *bound < 1e-20, "{error:e} beside {bound:e}");
        }
    }

    /// ẋ = 0 from 10⁸ beside ẏ = −y from 1.
    #[test]
    fn a_large_component_leaves_the_others_their_tolerance() {
        struct Beside;
        impl Ode for Beside {
            fn dim(&self) -> usize {
                2
            }
            fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
                dv.copy_from_slice(&[0.0, -v[1]]);
            }
            fn jacobian(&self, _t: f64, _v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
                add(1, 1, -1.0);
            }
        }
        let reference = crate::reference::by_name("diffsol-tsit45").expect("always built");
        let found = solve_in_units(reference, &Beside, &[1e8, 1.0], &[1.0], FINE).expect("solved");
        let error = (found.states[0][1] - (-1.0_f64).exp()).abs();
        assert!(error < 1e-9, "{error:e}");
    }

    #[test]
    fn the_coarse_solve_is_asked_for_a_hundred_times_the_tolerance_of_the_fine_one() {
        let asked = std::cell::RefCell::new(Vec::new());
        let solve = |_: &dyn Ode, tolerance: f64, times: &[f64]| {
            asked.borrow_mut().push(tolerance);
            let mut run = Run::with_capacity(times.len());
            times.iter().for_each(|_| run.push(vec![1.0], 1));
            Ok(run)
        };
        solve_twice(&Still(f64::INFINITY), 0.0, &[1.0], &[1.0], 1e-9, solve).expect("solved");
        assert_eq!(asked.into_inner(), [100.0 * 1e-9, 1e-9]);
    }

    /// v̇ = 0 with steps of a thousandth at most.
    struct Short;

    impl Ode for Short {
        fn dim(&self) -> usize {
            1
        }
        fn rhs(&self, _t: f64, _v: &[f64], dv: &mut [f64]) {
            dv[0] = 0.0;
        }
        fn jacobian(&self, _t: f64, _v: &[f64], _add: &mut dyn FnMut(usize, usize, f64)) {}
        fn bandwidths(&self) -> Option<(usize, usize)> {
            Some((1, 2))
        }
        fn longest_step(&self, _span: f64) -> f64 {
            1e-3
        }
    }

    #[test]
    fn the_longest_steps_of_the_finer_solve_are_half_as_long() {
        let seen = std::cell::RefCell::new(Vec::new());
        let solve = |ode: &dyn Ode, _: f64, times: &[f64]| {
            seen.borrow_mut().push((ode.longest_step(1.0), ode.bandwidths()));
            let mut run = Run::with_capacity(times.len());
            times.iter().for_each(|_| run.push(vec![1.0], 1));
            Ok(run)
        };
        solve_twice(&Short, 0.0, &[1.0], &[1.0], FINE, solve).expect("solved");
        assert_eq!(seen.into_inner(), [(1e-3, Some((1, 2))), (5e-4, Some((1, 2)))]);
    }

    /// ẋ = 3y, ẏ = 0, with x in units of 2⁻¹⁰ and y in units of 4.
    #[test]
    fn an_equation_in_units_has_its_derivatives_and_its_steps() {
        struct Pair;
        impl Ode for Pair {
            fn dim(&self) -> usize {
                2
            }
            fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
                dv.copy_from_slice(&[3.0 * v[1], 0.0]);
            }
            fn jacobian(&self, _t: f64, _v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
                add(0, 1, 3.0);
            }
            fn product(&self, _t: f64, _v: &[f64], x: &[f64], out: &mut [f64]) {
                out.copy_from_slice(&[3.0 * x[1], 0.0]);
            }
            fn longest_step(&self, span: f64) -> f64 {
                span
            }
        }
        let ode = InUnits::new(&Pair, &[2.0_f64.powi(-10), 4.0]).within(0.25);
        let slope = 3.0 * 4.0 * 1024.0;
        ode.jacobian(0.0, &[1.0, 1.0], &mut |i, j, x| assert_eq!((i, j, x), (0, 1, slope)));
        let mut out = [0.0; 2];
        ode.product(0.0, &[1.0, 1.0], &[0.0, 1.0], &mut out);
        assert_eq!(out, [slope, 0.0]);
        assert_eq!([ode.longest_step(1.0), ode.longest_step(0.125)], [0.25, 0.125]);
    }
}
