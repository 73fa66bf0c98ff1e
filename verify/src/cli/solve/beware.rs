//! What a run shows that its numbers do not say: where they cannot be right although every step was solved.

mod invariants;
mod past;
mod rest;
mod sign;
mod step;
mod total;

use verify::measure::norm::{Extremes, max_norm};
use verify::method::Method;
use verify::problem::Problem;

use super::equation::{abscissa_bound, jacobian};
use super::held::Held;
use crate::cli::layout::{number, plain};
use invariants::Rates;
use past::Past;
use sign::Signs;
use total::Total;

/// A change below this part of what f moves, or of the solution, is none.
const REST: f64 = 1e-6;

/// Growth beyond all values so far in a single step that no step resolves.
const LEAP: f64 = 10.0;

/// Rows over which a solution may find its scale, from the first on that is not zero.
const START: usize = 3;

/// Growth in a step, as the logarithm of a factor, half of which a method has to show.
const LEAVES: f64 = 1.0;

/// A component is lost where it is wrong by this part of its largest value.
const LOST: f64 = 1e-3;

/// Part of the largest value of a component by which a step on the linearised equation is off.
pub(super) const OFF: f64 = 0.1;

/// Times the estimate of the error that the estimate does not explain: across a jump, where errors halve with the step, it is half of the error,
/// and good to half as much again.
pub(super) const BEYOND: f64 = 3.0;

/// What a run comes to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row<'a> {
    pub(super) t: f64,
    pub(super) state: &'a [f64],
    /// Of the error, where there is one.
    pub(super) estimate: Option<f64>,
    /// Whether there is no exact solution any more.
    pub(super) has_ended: bool,
}

/// Follows a run.
#[derive(Debug, Default)]
pub(super) struct Watch {
    pub(super) past: Past,
    /// The first time at which there is no exact solution any more.
    ended: Option<f64>,
    /// Rows since the first that is not zero.
    rows: usize,
    rates: Rates,
    total: Total,
    signs: Signs,
    /// The first step across which the solution leaves its scale behind, by its end and the size before and after.
    leap: Option<(f64, [f64; 2])>,
    held: Held,
}

impl Watch {
    /// A row of a run of `method` on `problem`.
    pub(super) fn add(&mut self, problem: &dyn Problem, method: &dyn Method, row: Row) {
        let (ode, largest) = (problem.ode(), self.past.largest);
        self.past.add(&row);
        if ode.dim() == row.state.len() {
            if self.past.is_small() {
                self.rates.add(ode, row.t, row.state);
            } else {
                self.total.add(ode, row.t, row.state);
            }
        }
        if self.past.has_steps_of(ode) {
            if self.past.is_small() {
                self.signs.add(ode, &self.past);
            }
            self.held.add(problem, method, self.past.before.0, &row, largest);
        }
        self.rows += usize::from(self.past.largest > 0.0);
        let size = max_norm(row.state);
        // What starts at zero has no scale before it has grown to one, as the tail of a pulse has none.
        let has_scale = max_norm(&self.past.first).max(size) > f64::EPSILON;
        let leaps = self.rows > START && size > LEAP * largest && self.leap.is_none() && has_scale;
        if leaps && self.may_grow(problem) {
            self.leap = Some((row.t, [largest, size]));
        }
        if row.has_ended && self.ended.is_none() {
            self.ended = Some(row.t);
        }
    }

    /// Whether perturbations may leap in the last step, for all that a bound tells: what the equation lets grow by less grows by forcing, however
    /// fast.
    fn may_grow(&self, problem: &dyn Problem) -> bool {
        let Past { before: (start, _), last: (t, v), .. } = &self.past;
        let is_dense = self.past.is_small() && self.past.has_steps_of(problem.ode());
        let is_forced = is_dense && (t - start) * abscissa_bound(&jacobian(problem, *t, v)) <= LEAP.ln();
        !is_forced
    }

    /// A step in which the solution leaves all that was before behind, as beside a pole.
    pub(super) fn leap(&self) -> Option<String> {
        let (t, [before, after]) = self.leap?;
        Some(format!(
            "in the step to t = {} the solution grows from {} to {}: such a step resolves nothing, and the solution may end \
             before; a smaller `--h` tells",
            plain(t),
            number(before),
            number(after)
        ))
    }

    /// A solution no component of which comes to the absolute tolerance that it is held to, one for all or one for each.
    pub(super) fn below(&self, atol: &[f64]) -> Option<String> {
        let largest = |k: usize| atol.get(k).or(atol.first()).copied().unwrap_or(0.0);
        let is_below = self.past.sizes.iter().enumerate().all(|(k, size)| *size < largest(k));
        (self.past.largest > 0.0 && is_below).then(|| {
            format!(
                "no component comes to the absolute tolerance, {}, and the largest is {}: no digit of the solution is held to anything; a \
                 smaller `--atol`, or other units, tell",
                number(atol.iter().copied().largest()),
                number(self.past.largest)
            )
        })
    }

    /// What is to be said of the run on `problem`, and that it breaks a linear invariant, as right digits may.
    pub(super) fn warnings(&self, problem: &dyn Problem, method: &dyn Method) -> (Vec<String>, Option<String>) {
        let ended = self.ended.map(|t| {
            format!("the exact solution ends before t = {}; the rows from there on approximate nothing", plain(t))
        });
        let past = &self.past;
        if !past.has_steps_of(problem.ode()) {
            return (ended.into_iter().collect(), None);
        }
        let by_derivatives = || {
            past.rests_where_unstable(problem, method)
                .or_else(|| past.stuck(problem, method))
                .or_else(|| past.stays(problem, method))
                .or_else(|| self.held.told(method, past.largest))
                .or_else(|| past.lags(problem, method))
        };
        let stuck = past.rests_by_method_alone(problem).or_else(|| past.is_small().then(by_derivatives).flatten());
        let broken = match past.is_small() {
            true => self.rates.broken(past, problem, stuck.is_some()),
            false => self.total.broken(past, problem),
        };
        (ended.into_iter().chain(self.signs.told(problem)).chain(stuck).collect(), broken)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::solve::equation::{by, growing, model};
    use verify::problem;

    fn watch(problem: &dyn Problem, rows: &[(f64, &[f64])]) -> Watch {
        let (mut watch, method) = (Watch::default(), by("rk4"));
        for (t, state) in rows {
            watch.add(problem, &*method, Row { t: *t, state, estimate: None, has_ended: *t > 3.0 });
        }
        watch
    }

    fn leaps(h: f64, values: &[f64]) -> bool {
        let rows: Vec<_> =
            values.iter().enumerate().map(|(k, x)| (10.0 + h * k as f64, std::slice::from_ref(x))).collect();
        watch(&*growing(10.0), &rows).leap().is_some()
    }

    /// Of ẋ = 10x no step of 0.01 leaps, and one of 1 may; that of the last row counts, wherever the run is by then.
    #[test]
    fn what_grows_by_twenty_in_a_short_step_is_forced() {
        assert_eq!([0.01, 1.0].map(|h| leaps(h, &[1.0, 1.0, 1.0, 1.0, 20.0])), [false, true]);
    }

    #[test]
    fn a_solution_leaps_beyond_ten_times_a_scale_that_it_has_had_for_three_rows() {
        let leaps = |values: &[f64]| leaps(1.0, values);
        assert_eq!([leaps(&[1.0, 1.0, 1.0, 10.0]), leaps(&[1.0, 1.0, 1.0, 10.1])], [false, true]);
        assert!(!leaps(&[1.0, 1.0, 20.0]));
        assert!(!leaps(&[0.0, 0.0, 0.0, 0.0, 1.0, 20.0]), "as the rows of zeros are none");
        assert!(leaps(&[0.0, 0.0, 1.0, 1.0, 1.0, 20.0]));
        // Beyond the roundings of 1.
        assert_eq!([1e-17, 1e-16].map(|size| leaps(&[size, size, size, 20.0 * size])), [false, true]);
    }

    /// Of 64 decaying components nothing leaps that is not forced; more are not looked at.
    #[test]
    fn growth_is_bounded_in_small_systems_alone() {
        let may_grow = |n: usize| {
            let settings = [("cells".into(), n.to_string())];
            let channel = problem::build("channel-poiseuille", &settings).expect("registered");
            let n = channel.ode().dim();
            let rows = [vec![0.0; n], vec![1.0; n]];
            let watch = watch(&*channel, &[(0.0, &rows[0]), (1e-6, &rows[1])]);
            (n, watch.may_grow(&*channel), watch.rates.matrix().is_empty())
        };
        assert_eq!([may_grow(65), may_grow(66)], [(64, false, false), (65, true, true)]);
    }

    #[test]
    fn a_solution_below_its_absolute_tolerance_is_told() {
        let below = |sizes: [f64; 2], atol: &[f64]| {
            watch(&model("u_i { x = 1, y = 1 } F_i { 0*x, 0*y }"), &[(0.0, &sizes)]).below(atol).is_some()
        };
        assert_eq!([2e-7, 1e-7].map(|atol| below([1e-7, 1e-9], &[atol])), [true, false], "the largest comes to it");
        assert_eq!([2e-9, 1e-9].map(|atol| below([1e-7, 1e-9], &[1.0, atol])), [true, false]);
        assert!(!below([0.0; 2], &[1.0]), "of zero there are no digits");
    }

    /// The end of the exact solution is said of a run that has no step, too.
    #[test]
    fn the_first_row_beyond_the_solution_is_told() {
        let (still, method) = (growing(-1.0), by("rk4"));
        let told = |rows: &[(f64, &[f64])]| watch(&*still, rows).warnings(&*still, &*method).0;
        assert_eq!(told(&[(0.0, &[1.0])]), Vec::<String>::new());
        let ended = "the exact solution ends before t = 4; the rows from there on approximate nothing";
        assert_eq!(told(&[(4.0, &[1.0])]), [ended]);
        assert_eq!(told(&[(3.0, &[1.0]), (4.0, &[0.3]), (5.0, &[0.1])]), [ended]);
    }
}
