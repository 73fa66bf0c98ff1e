//! Errors of one run at the grid points t = nh ≤ 10, the horizon of the figures of \[S24\].

use rayon::prelude::*;

use super::{Context, Experiment, ExperimentError, StudyError, maps};
use crate::measure::norm::larger;
use crate::measure::search::{logarithmic, try_intervals};
use crate::method;
use crate::problem::{self, Problem};
pub use crate::run::RunError;
use crate::run::run;

/// The paper's horizon.
pub const HORIZON: f64 = 10.0;

/// Number of grid points t = nh ≤ 10, n ≥ 1, where h as a decimal fraction may divide 10.
pub fn points(h: f64) -> usize {
    points_to(HORIZON, h)
}

fn points_to(end: f64, h: f64) -> usize {
    (end / h * (1.0 + 4.0 * f64::EPSILON)).floor() as usize
}

/// What roundoff does to a run of values up to 1 + `size`: each step errs by a few ε of the value, and earlier errors decay
/// so that those of at most 1 + 1/h steps are left, as with e^{−t} or, on quadratic drag, v².
pub fn roundoff(h: f64, size: f64) -> f64 {
    8.0 * f64::EPSILON * (1.0 + h.recip()) * (1.0 + size)
}

/// One run of a method on a problem with one component and a known solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// The problem with its parameters: `linear-drag lambda=2.5`.
    pub problem: &'static str,
    /// The method.
    pub method: &'static str,
    /// The step size.
    pub h: f64,
}

impl Errors {
    /// A run of `method` on `problem`.
    pub fn of(problem: &'static str, method: &'static str, h: f64) -> Self {
        Self { problem, method, h }
    }

    /// The largest error in `context`; where the run fails, [`RunError::in_place_of_a_number`].
    ///
    /// # Errors
    /// If there is no such problem, solution or method.
    pub fn largest(self, context: &Context) -> Result<f64, ExperimentError> {
        let run = context.get(self)?;
        Ok(run.largest.as_ref().map_or_else(RunError::in_place_of_a_number, |largest| largest.error))
    }
}

/// What is found about a run.
#[derive(Debug)]
pub struct Run {
    /// The setting.
    pub of: Errors,
    /// The largest error, or why the run failed part-way.
    pub largest: Result<Largest, RunError>,
    /// The largest error of the run by the method's map in closed form, where there is one.
    pub predicted: Option<f64>,
    /// (t, error), thinned where there are many.
    pub errors: Vec<(f64, f64)>,
}

/// Largest errors over the grid points.
#[derive(Debug, Clone, Copy, Default)]
pub struct Largest {
    /// Over all of them.
    pub error: f64,
    /// Where it is.
    pub t: f64,
}

impl Largest {
    fn see(&mut self, t: f64, error: f64) {
        if error > self.error || error.is_nan() {
            (self.error, self.t) = (error, t);
        }
    }
}

impl Experiment for Errors {
    const ID: &'static str = "errors";
    type Found = Run;

    fn measure(&self, context: &Context) -> Result<Run, StudyError> {
        context.announce(1);
        let Self { problem, method, h } = *self;
        let exact = context.get(Exact { problem, h, end: HORIZON })?;
        let problem = problem::build_setting(problem)?;
        let mut largest = Largest::default();
        let mut errors = Vec::new();
        let mut keep = kept(exact.len()).into_iter().peekable();
        let mut n = 0_usize;
        let outcome = run(&*problem, &*method::parse(method)?, h, exact.len() as f64 * h, |state| {
            if let Some(exact) = n.checked_sub(1).and_then(|n| exact.get(n)) {
                let error = (state.q[0] - exact).abs();
                largest.see(state.t, error);
                if keep.next_if_eq(&n).is_some() {
                    errors.push((state.t, error));
                }
            }
            n += 1;
        });
        let predicted = self.predicted(&*problem, &exact);
        context.tick();
        Ok(Run { of: *self, largest: outcome.map(|_| largest), predicted, errors })
    }
}

impl Errors {
    fn predicted(&self, problem: &dyn Problem, exact: &[f64]) -> Option<f64> {
        let map = maps::of(self.problem)?;
        let mut v = problem.initial()[0];
        let mut largest = Largest::default();
        for exact in exact {
            v = map(self.method, self.h, v)?;
            largest.see(0.0, (v - exact).abs());
        }
        Some(largest.error)
    }
}

/// Whether the errors of a run decay to zero: the largest on (t, 2t] over the largest on (t/2, t], for the last t of 20, 10, 5, … at which
/// the earlier one is ten times the [`roundoff`] of the run; [`RunError::in_place_of_a_number`] if a step fails, and nothing where
/// there is no such t.
///
/// Roundoff need not decay. On quadratic drag a step at time s adds a few ε v(s), of which v(t)²/v(s)² is left at t: in all
/// ε v(t)² Σ 1/v(s) ≈ ε (t + t²/2)/(h (1 + t)²), which tends to ε/(2h) and grows on the way there.
///
/// They do if it is [`Decay::MOST`] or less. That is the one reading of "the errors decay to zero as t → ∞" in the report. A
/// factor of ½ as t doubles is a fall like 1/t; the errors on quadratic drag fall like ln t/t² and those on linear problems
/// exponentially, sooner or later.
#[derive(Debug)]
pub struct Decay {
    /// The problem.
    pub problem: &'static str,
    /// The method.
    pub method: &'static str,
    /// The step size.
    pub h: f64,
}

impl Decay {
    /// What decays falls at least by this factor.
    pub const MOST: f64 = 0.5;
    /// The end of the run.
    pub const END: f64 = 40.0;
    /// Spans of time (t, 2t] that are looked at, from the last one back.
    const SPANS: usize = 8;
    /// What is well above roundoff.
    const ABOVE: f64 = 10.0;
}

impl Experiment for Decay {
    const ID: &'static str = "decay";
    type Found = Option<f64>;

    fn measure(&self, context: &Context) -> Result<Option<f64>, StudyError> {
        context.announce(1);
        let problem = problem::build_setting(self.problem)?;
        let is_known = problem.exact(Self::END).is_some();
        let exact =
            is_known.then(|| context.get(Exact { problem: self.problem, h: self.h, end: Self::END })).transpose()?;
        let (mut errors, mut size, mut n) = ([0.0; Self::SPANS], 0.0, 0_usize);
        let outcome = run(&*problem, &*method::parse(self.method)?, self.h, Self::END, |state| {
            size = larger(size, state.q[0].abs());
            let is_in = |span: &usize| state.t > Self::END * 0.5_f64.powi(*span as i32 + 1);
            if let Some(span) = (0..Self::SPANS).find(is_in) {
                let of_grid = n.checked_sub(1).and_then(|n| exact.as_ref()?.get(n).copied());
                // The last step may be cut.
                let exact = of_grid.or_else(|| problem.exact(state.t).map(|exact| exact[0]));
                errors[span] = larger(errors[span], exact.map_or(f64::NAN, |exact| (state.q[0] - exact).abs()));
            }
            n += 1;
        });
        context.tick();
        if let Err(error) = outcome {
            return Ok(Some(error.in_place_of_a_number()));
        }
        // NaN is not roundoff.
        let is_roundoff = |error: f64| error <= Self::ABOVE * roundoff(self.h, size);
        Ok(errors.windows(2).find(|pair| !is_roundoff(pair[1])).map(|pair| pair[0] / pair[1]))
    }
}

/// Evaluations of f in a run to t = 10, in those of a step equation as many as the method has stages.
#[derive(Debug)]
pub struct Evaluations(pub Errors);

impl Experiment for Evaluations {
    const ID: &'static str = "evaluations";
    type Found = u64;

    fn measure(&self, _: &Context) -> Result<u64, StudyError> {
        let Errors { problem, method, h } = self.0;
        let problem = problem::build_setting(problem)?;
        let method = method::parse(method)?;
        let work = run(&*problem, &*method, h, HORIZON, |_| {})?.work;
        Ok(u64::from(method.traits().stages) * work.residuals)
    }
}

/// The exact solution at t = nh, n = 1 …, to the end, which the runs of all methods share.
#[derive(Debug)]
struct Exact {
    problem: &'static str,
    h: f64,
    end: f64,
}

impl Experiment for Exact {
    const ID: &'static str = "exact";
    type Found = Vec<f64>;

    fn measure(&self, _: &Context) -> Result<Vec<f64>, StudyError> {
        let problem = problem::build_setting(self.problem)?;
        let at = |n: usize| {
            let t = n as f64 * self.h;
            problem.exact(t).map(|v| v[0]).ok_or_else(|| format!("no exact solution at t = {t}").into())
        };
        (1..=points_to(self.end, self.h)).into_par_iter().map(at).collect()
    }
}

/// The indices of the grid points that the time series keep: all of up to a thousand, else 200 evenly and 200
/// logarithmically spaced in t.
fn kept(count: usize) -> Vec<usize> {
    const EACH: u32 = 200;
    if count <= 1000 {
        return (1..=count).collect();
    }
    let of = |k: u32| f64::from(k) / f64::from(EACH);
    let even = (1..=EACH).map(|k| (count as f64 * of(k)).round() as usize);
    let logarithmic = (0..=EACH).map(|k| (count as f64).powf(of(k)).round() as usize);
    let mut all: Vec<usize> = even.chain(logarithmic).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The step sizes between `low` and `high` at which the largest error of `method` is below `times` that of `rival`.
///
/// They are looked for at both ends and at a hundred steps in each decade between; where two neighbours differ, the step at which the
/// two change places is found by bisection. A run that has no solution errs infinitely.
#[derive(Debug, Clone, Copy)]
pub struct Ahead {
    /// The problem.
    pub problem: &'static str,
    /// The method.
    pub method: &'static str,
    /// The other method.
    pub rival: &'static str,
    /// Its error counts as often.
    pub times: f64,
    /// Smallest and largest step size.
    pub between: [f64; 2],
}

impl Ahead {
    /// Steps in a decade.
    pub const SCAN: u32 = 100;
}

impl Experiment for Ahead {
    const ID: &'static str = "ahead";
    /// Intervals, in ascending order.
    type Found = Vec<[f64; 2]>;

    fn measure(&self, context: &Context) -> Result<Vec<[f64; 2]>, StudyError> {
        context.announce(1);
        let Self { problem, method, rival, times, between } = *self;
        let found = try_intervals(&logarithmic(between, Self::SCAN), |h| {
            let largest = |method| context.get(Scanned(Errors { problem, method, h }));
            let [own, theirs] = [*largest(method)?, *largest(rival)?];
            if own.is_nan() || theirs.is_nan() {
                return Err(StudyError::from(format!("the runs with h = {h} on {problem} do not tell")));
            }
            Ok(own < times * theirs)
        })?;
        context.tick();
        Ok(found)
    }
}

/// The largest error of a run, infinite where it has no solution: all that is kept of the many of a scan, in which methods meet several
/// rivals at the same steps.
#[derive(Debug)]
struct Scanned(Errors);

impl Experiment for Scanned {
    const ID: &'static str = "scanned-error";
    type Found = f64;

    fn measure(&self, context: &Context) -> Result<f64, StudyError> {
        let Errors { problem, method, h } = self.0;
        // Not kept, as the figures have other steps.
        let exact = Exact { problem, h, end: HORIZON }.measure(context)?;
        let (mut largest, mut points) = (0.0, exact.iter());
        let end = exact.len() as f64 * h;
        let outcome = run(&*problem::build_setting(problem)?, &*method::parse(method)?, h, end, |state| {
            if state.t > 0.0 {
                largest = larger(largest, points.next().map_or(f64::NAN, |exact| (state.q[0] - exact).abs()));
            }
        });
        Ok(outcome.map_or_else(|error| error.in_place_of_a_number(), |_| largest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_that_is_not_a_number_stays_the_largest() {
        let mut largest = Largest::default();
        for (t, error, (most, at)) in [(1.0, 2.0, (2.0, 1.0)), (2.0, 1.0, (2.0, 1.0)), (3.0, 4.0, (4.0, 3.0))] {
            largest.see(t, error);
            assert_eq!((largest.error, largest.t), (most, at));
        }
        for (t, error) in [(4.0, f64::NAN), (5.0, 8.0), (6.0, f64::INFINITY)] {
            largest.see(t, error);
            assert!(largest.error.is_nan() && largest.t == 4.0, "{largest:?}");
        }
    }

    /// v̇ = −v with a step of 2, of which Method I leaves a fifth, and an equation without a solution in closed form, where no error is known.
    #[test]
    fn errors_that_are_not_known_do_not_decay() {
        let of = |problem, method, h| Decay { problem, method, h }.measure(&Context::quick()).expect("it runs");
        let known = of("linear-drag", "method-i", 2.0).expect("above roundoff");
        assert!(known > 0.0 && known <= Decay::MOST, "{known}");
        assert!(of("van-der-pol", "rk4", 0.05).is_some_and(f64::is_nan));
    }
}
