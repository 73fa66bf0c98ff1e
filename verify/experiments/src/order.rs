//! The order of a method, or of a program, on a problem, measured against a reference.

mod program;
mod rough;

use std::f64::consts::SQRT_2;
use std::fmt;

use lsvi::State;
use rayon::prelude::*;

use crate::measure::decimal::{decimals, significant};
use crate::measure::norm::{distance, max_norm};
use crate::measure::order::{self, Measured, OrderFit, Reason, Sample, Verdict, fit};
use crate::method::{Method, roundoff};
use crate::problem::{Limit, Problem};
use crate::program::ProgramError;
use crate::reference::bound::{self, FINER};
use crate::reference::{Reference, ReferenceError, by_name};
use crate::run::run;
use crate::theory::{OrderPlan, order_plan};

pub use program::{Programs, measure_program};
use rough::{PARTS, Rough, roughness};

/// What the errors are measured against.
#[derive(Debug, Clone, Copy)]
pub enum Truth {
    /// The exact solution.
    Exact,
    /// The solution tabulated to double precision.
    Tabulated,
    /// A numerical reference with its own error bound.
    Numerical(&'static dyn Reference),
}

/// A kind of truth, by the name that the command line gives it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Source {
    /// The solution in closed form, or tabulated to double precision.
    Exact,
    /// SUNDIALS CVODE at tight tolerances.
    Cvode,
    /// diffsol at tight tolerances.
    Diffsol,
}

impl Source {
    /// The exact solution where one is known, else the first library that is compiled in.
    pub fn default_for(problem: &dyn Problem, method: &dyn Method) -> Self {
        Self::at_hand(problem, &problem.limit(method.principle()), order_plan(problem, method).horizon)
    }

    /// The exact solution where one is known at `horizon`, else the first library that is compiled in.
    fn at_hand(problem: &dyn Problem, limit: &Limit<'_>, horizon: f64) -> Self {
        if (limit.exact)(horizon).is_some() || problem.tabulated(horizon).is_some() {
            Self::Exact
        } else {
            Self::library()
        }
    }

    /// The first library that is compiled in.
    fn library() -> Self {
        if cfg!(feature = "cvode") { Self::Cvode } else { Self::Diffsol }
    }

    /// What this kind is for `method` on `problem`: the exact solution in its better form, or the most accurate solver.
    pub fn truth(self, problem: &dyn Problem, method: &dyn Method) -> Truth {
        self.of(problem, order_plan(problem, method).horizon)
    }

    /// What this kind is for `problem` at `horizon`.
    fn of(self, problem: &dyn Problem, horizon: f64) -> Truth {
        let is_tabulated = || problem.tabulated(horizon).is_some();
        let name = match (self, problem.is_stiff()) {
            (Self::Exact, _) if is_tabulated() => return Truth::Tabulated,
            (Self::Exact, _) => return Truth::Exact,
            (Self::Cvode, true) => "cvode-bdf",
            (Self::Cvode, false) => "cvode-adams",
            (Self::Diffsol, true) => "diffsol-bdf",
            (Self::Diffsol, false) => "diffsol-tsit45",
        };
        by_name(name).map_or(Truth::Exact, Truth::Numerical)
    }
}

impl fmt::Display for Truth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exact => f.write_str("exact"),
            Self::Tabulated => f.write_str("tabulated"),
            Self::Numerical(reference) => f.write_str(reference.name()),
        }
    }
}

/// Why an order could not be measured at all.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum OrderError {
    /// The problem has no exact solution.
    #[error("no exact solution is known; choose a numerical reference")]
    NoExact,
    /// The method chooses its steps itself.
    #[error("{0} chooses its steps itself: its errors follow the tolerance, not h")]
    Adaptive(String),
    /// No order can be told here, as theory has it and a trial confirms.
    #[error("no order is predicted: {because}; the run was made anyway: {found}")]
    Untold {
        /// Why not.
        because: &'static str,
        /// What the trial gave instead.
        found: String,
    },
    /// The coarsest step asked for is longer than the time.
    #[error("the coarsest step {coarsest} is longer than the time of a run, {horizon}")]
    Coarsest {
        /// The step.
        coarsest: f64,
        /// The time.
        horizon: f64,
    },
    /// The finest step asked for is too short.
    #[error(
        "the finest of these runs would take {count:.1e} steps, and {limit:.0e} is the most: ask for a longer coarsest step or fewer steps"
    )]
    TooManySteps {
        /// The number of steps.
        count: f64,
        /// The most.
        limit: f64,
    },
    /// The reference failed.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// The program does not do what it is asked for, whatever the step.
    #[error("the program{}: {source}", .problem.as_ref().map_or_else(String::new, |name| format!(" on {name}")))]
    Program {
        /// The problem that it was asked for.
        problem: Option<String>,
        /// What it does instead.
        source: ProgramError,
    },
}

/// What a user may ask for in place of the plan that theory has for a pair.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Ladder {
    /// The order to expect.
    pub expected: Option<f64>,
    /// Largest distance from it.
    pub band: Option<f64>,
    /// The coarsest step.
    pub coarsest: Option<f64>,
    /// Number of steps.
    pub points: Option<usize>,
    /// Tolerance of a numerical reference.
    pub tolerance: Option<f64>,
}

impl Ladder {
    /// Refuses a coarsest step that no run up to `horizon` takes.
    fn check(&self, horizon: f64) -> Result<(), OrderError> {
        match self.coarsest {
            // Half a unit of the last digit that a horizon is shown with is no difference.
            Some(coarsest) if coarsest > horizon * (1.0 + 1e-6) => Err(OrderError::Coarsest { coarsest, horizon }),
            _ => Ok(()),
        }
    }
}

/// Most steps of a run that is asked for: seconds of the fastest method.
const MOST_STEPS: f64 = 1e8;

/// Doublings of the coarsest step where errors turn out to be at their floor: a high order leaves it within a few.
const COARSER: u32 = 5;

/// Measures the order at the end of the plan's horizon.
///
/// The floor of each error is the bound of the reference plus the [`roundoff`] of the steps. Where theory says that no order
/// can be told, the steps are taken all the same: a pass is then a failure.
///
/// # Errors
/// [`OrderError`] if there is no truth to measure against, or no order as theory has it.
pub fn measure(problem: &dyn Problem, method: &dyn Method, truth: Truth) -> Result<OrderFit, OrderError> {
    measure_on(problem, method, truth, &Ladder::default())
}

/// The same with steps and expectations of one's own. Where no coarsest step is asked for and the fit is inconclusive with
/// errors at their floor, the ladder starts coarser, up to half the horizon.
///
/// # Errors
/// As for [`measure`].
pub fn measure_on(
    problem: &dyn Problem,
    method: &dyn Method,
    truth: Truth,
    ladder: &Ladder,
) -> Result<OrderFit, OrderError> {
    if method.traits().is_adaptive {
        return Err(OrderError::Adaptive(method.name()));
    }
    let mut plan = order_plan(problem, method);
    let limit = problem.limit(method.principle());
    if let Some(order) = limit.order.filter(|order| *order < plan.expectation.order) {
        plan = plan.declared(order, limit.reason);
    }
    let asks = ladder.coarsest.is_some() || ladder.points.is_some();
    let OrderPlan { mut expectation, horizon, mut steps, untold, unsettled } = plan;
    let (untold, unsettled) = if asks { (None, None) } else { (untold, unsettled) };
    ladder.check(horizon)?;
    expectation.order = ladder.expected.unwrap_or(expectation.order);
    expectation.band = ladder.band.unwrap_or(expectation.band);
    let ratio = steps.windows(2).next_back().map_or(SQRT_2, |pair| pair[0] / pair[1]);
    if asks {
        let coarsest = ladder.coarsest.unwrap_or_else(|| steps.first().copied().unwrap_or(horizon));
        steps = order::ladder(horizon, coarsest, ratio, ladder.points.unwrap_or(steps.len()));
        if let Some(finest) = steps.last().filter(|finest| horizon / **finest > MOST_STEPS) {
            return Err(OrderError::TooManySteps { count: horizon / finest, limit: MOST_STEPS });
        }
    }
    let solution = truth.solution(problem, &limit, &[horizon], ladder.tolerance)?;
    let (end, bound) = (&solution[0].0, solution[0].1);
    let size = max_norm(end).max(max_norm(&limit.initial));
    let sample = |h: f64| {
        let (mut last, mut length) = (Vec::new(), 0.0);
        let watch = |state: &State| {
            length += if last.is_empty() { 0.0 } else { distance(&state.q, &last) };
            last.clone_from(&state.q);
        };
        match run(problem, method, h, horizon, watch) {
            Ok(run) => {
                let digits = method.rounding_of_coefficients(size, length, horizon / h);
                let floor = bound + roundoff(method, size, horizon / h) + digits;
                (Sample::new(h, distance(&run.end.q, end), floor), digits)
            }
            Err(error) => (Sample::failed(h, error.to_string()), 0.0),
        }
    };
    let runs = |steps: &[f64]| -> (Vec<Sample>, Vec<f64>) { steps.par_iter().map(|h| sample(*h)).unzip() };
    let (mut samples, mut digits) = runs(&steps);
    let mut found = fit(&samples, &expectation);
    for _ in 0..COARSER {
        let floored = found.dropped.iter().filter(|(_, reason)| *reason == Reason::AtFloor).count();
        let coarser = 2.0 * steps[0];
        let given = asks || untold.or(unsettled).is_some();
        let tells = found.verdict != Verdict::Inconclusive || found.still_approaches();
        if given || tells || 2 * floored < samples.len() || coarser > 0.5 * horizon {
            break;
        }
        let added: Vec<f64> = order::ladder(horizon, coarser, ratio, steps.len());
        let added: Vec<f64> = added.into_iter().filter(|h| *h > steps[0] * (1.0 + 1e-9)).collect();
        let (more, of_them) = runs(&added);
        samples.extend(more);
        digits.extend(of_them);
        steps.splice(..0, added);
        found = fit(&samples, &expectation);
    }
    let is_lost = is_lost(bound, size);
    let model = problem.facts().model.filter(|_| !is_lost);
    let unexplored = model.and_then(|rate| unexplored(&found, method.order(), size, rate));
    let along = |times: &[f64]| truth.solution(problem, &limit, times, ladder.tolerance).ok();
    let unsmooth = model.and_then(|_| unsmooth(&found, method.order(), &limit, horizon, along));
    // A finer reference makes nothing smooth.
    let may_be_finer = unsmooth.is_none();
    if is_lost {
        found = found.left_open(format!(
            "the references part: the one taken is uncertain by {bound:.1e}, of a solution of size {size:.1e}, and an error is \
             no better known; a shorter time tells"
        ));
    } else if let Some(why) = unexplored.or(unsmooth) {
        found.reason += &format!("; {why}");
        found = found.clone().left_open(found.reason);
    }
    if found.verdict == Verdict::Inconclusive {
        let blame = blame_digits(samples.iter().zip(digits), expectation.band * ratio.ln());
        found.is_of_digits = blame.is_some();
        found.reason.extend(blame);
    }
    if may_be_finer
        && untold.or(unsettled).is_none()
        && truth.may_be_finer(&found, ladder)
        && let Ok(finer) = measure_on(problem, method, truth, &Ladder { tolerance: Some(FINER), ..*ladder })
    {
        return Ok(finer);
    }
    beside_theory(found, untold, unsettled)
}

/// Slopes that have not settled lie between those of two neighbouring terms of the error: one that is off by an order is another order.
fn may_be_unsettled(found: &OrderFit) -> bool {
    let off = |order: f64| found.line.is_some_and(|line| (line.slope - order).abs() > 1.0 - found.expected.band);
    found.verdict == Verdict::Inconclusive || !off(found.expected.order)
}

/// What follows from a fit where theory says why no order can be told, or that it may not be.
fn beside_theory(
    mut found: OrderFit,
    untold: Option<&'static str>,
    unsettled: Option<&'static str>,
) -> Result<OrderFit, OrderError> {
    match untold {
        _ if found.verdict != Verdict::Pass
            && let Some(because) = untold.or(unsettled.filter(|_| may_be_unsettled(&found))) =>
        {
            let measured = found.reason.strip_prefix("order ");
            let measured = measured.map(|rest| format!("it measured order {}", rest.replacen(" is not ", ", not ", 1)));
            Err(OrderError::Untold { because, found: measured.unwrap_or(found.reason) })
        }
        None => Ok(found),
        // What must not be told is told: the theory is wrong here.
        Some(because) => {
            found.verdict = Verdict::Fail;
            found.reason += &format!(", where no order should be told: {because}");
            Ok(found)
        }
    }
}

/// Errors above this part of the solution tell of no order.
const RESOLVED: f64 = 0.1;

/// Whether an error, or a bound, is above it.
fn is_lost(error: f64, size: f64) -> bool {
    error > RESOLVED * size
}

/// Why the errors of runs on a model, of which nothing is known but the size of its solution and a norm of J, decide nothing.
///
/// What has no `order` converges to nothing, and what has another one than is expected is not excused.
fn unexplored(found: &OrderFit, order: u32, size: f64, rate: f64) -> Option<String> {
    if found.verdict == Verdict::Inconclusive || order == 0 {
        return None;
    }
    let finest = found.kept.last()?;
    let error = finest.result.as_ref().ok()?.error;
    if is_lost(error, size) {
        return Some(format!(
            "at the finest step of the fit the error is {:.0} % of the solution, which no step resolves: a finer `--coarsest` or a \
             shorter time tells",
            100.0 * error / size
        ));
    }
    let reduced = found.line.is_some_and(|line| line.slope < found.expected.order);
    let is_its_own = found.expected.order == f64::from(order);
    (found.verdict == Verdict::Fail && reduced && is_its_own && finest.h * rate > 1.0).then(|| {
        format!(
            "h‖∂F/∂u‖ is {:.1e} at the finest step of the fit, where stiff equations may lower an order: steps below {:.1e} tell",
            finest.h * rate,
            rate.recip()
        )
    })
}

/// Local slopes at the fine end that tell by which order errors fall.
const FINEST: usize = 3;

/// Why errors decide nothing, or have not settled, where f is not smooth along the solution.
///
/// An order that is lower by half than what that leaves, or another one than the method's own, is not excused.
fn unsmooth(
    found: &OrderFit,
    order: u32,
    limit: &Limit<'_>,
    horizon: f64,
    along: impl Fn(&[f64]) -> Option<Vec<(Vec<f64>, f64)>>,
) -> Option<String> {
    let slope = found.line.map_or(f64::NAN, |line| line.slope);
    let least = found.expected.order - found.expected.band;
    let is_asked = match found.verdict {
        Verdict::Fail => slope < least && found.expected.order == f64::from(order),
        Verdict::Inconclusive => found.line.is_some(),
        Verdict::Pass | Verdict::Measured => false,
    };
    if !is_asked {
        return None;
    }
    let times: Vec<f64> = (0..=PARTS).map(|part| horizon * part as f64 / PARTS as f64).collect();
    let mut states = along(&times[1..])?;
    states.insert(0, (limit.initial.clone(), 0.0));
    let Rough { t, order } = roughness(limit.ode, &times, &states, order)?;
    // Errors that fall by more all the way have nothing of it: what looks rough is fast there. By one more they fall where steps always meet the
    // place in their middle.
    if found.local_slopes.iter().rev().take(FINEST).all(|local| local.slope > order + 1.5) {
        return None;
    }
    let place = format!(
        "f is not smooth along the solution near t = {}, or changes there within a thousandth of the time, and",
        significant(t, 2)
    );
    let tells = "shorter steps, `--coarsest`, tell, a time that ends before, or smooth data";
    let is_open = found.verdict == Verdict::Inconclusive;
    // Longer steps may pass over what is fast there alone.
    if order < least && found.local_slopes.windows(2).any(|two| two.iter().all(|local| local.slope > order + 1.5)) {
        return Some(format!(
            "{place} errors of steps about as long as what happens there fall by another order than those of longer ones: {tells}"
        ));
    }
    if order < least && (is_open || slope > order - 0.5) {
        return Some(format!(
            "{place} no order above {} is to be expected in longer steps: {tells}",
            decimals(order, 1)
        ));
    }
    // An error of the method's own order with another factor for each step size.
    (is_open && order < found.expected.order + 0.5).then(|| {
        let order = decimals(order, 1);
        format!("{place} the step across leaves an error of order {order} whose size depends on where it meets the place: {tells}")
    })
}

/// What is to be said where the digits of the coefficients are most of a floor that moves local slopes by half the band:
/// two floors in ln e, over ln r from a step to the next, where `band` stands for the product of the band and ln r.
fn blame_digits<'a>(samples: impl Iterator<Item = (&'a Sample, f64)>, band: f64) -> Option<String> {
    let open = samples.filter_map(|(sample, digits)| {
        let Measured { error, floor } = *sample.result.as_ref().ok()?;
        (digits > 0.5 * floor && 2.0 * floor > 0.5 * band * error).then_some(digits)
    });
    open.max_by(f64::total_cmp).map(|digits| {
        format!(
            "; the coefficients are rounded, and the digits printed leave {digits:.1e} of these errors open: more digits \
             would tell, or the line `digits = N` where zeros at the end are left out"
        )
    })
}

impl Truth {
    /// Whether a numerical reference with a smaller bound may decide what this fit does not.
    fn may_be_finer(self, found: &OrderFit, ladder: &Ladder) -> bool {
        let is_floored = found.dropped.iter().any(|(_, reason)| *reason == Reason::AtFloor);
        matches!(self, Self::Numerical(_))
            && ladder.tolerance.is_none()
            && is_floored
            && found.verdict == Verdict::Inconclusive
    }

    /// States with a bound on their errors at increasing `times`.
    fn solution(
        self,
        problem: &dyn Problem,
        limit: &Limit<'_>,
        times: &[f64],
        tolerance: Option<f64>,
    ) -> Result<Vec<(Vec<f64>, f64)>, OrderError> {
        // A handful of elementary functions, each to an ulp or two; tabulated ones are rounded from more digits.
        let (known, ulps): (&dyn Fn(f64) -> Option<Vec<f64>>, f64) = match self {
            Self::Exact => (&*limit.exact, 8.0),
            Self::Tabulated => (&|t| problem.tabulated(t), 1.0),
            Self::Numerical(reference) => {
                let solved = match tolerance {
                    Some(tolerance) => bound::solve_in_units(reference, limit.ode, &limit.initial, times, tolerance),
                    None => reference.solve(limit.ode, 0.0, &limit.initial, times),
                }?;
                return Ok(solved.states.into_iter().zip(solved.bound).collect());
            }
        };
        let at = |t: &f64| known(*t).map(|state| (ulps * f64::EPSILON * max_norm(&state), state));
        let states = times.iter().map(|t| at(t).map(|(bound, state)| (state, bound)));
        states.collect::<Option<_>>().ok_or(OrderError::NoExact)
    }
}

/// Whether f at the initial state depends on time, as far as a few times of the horizon tell.
#[must_use]
pub fn depends_on_time(problem: &dyn Problem) -> bool {
    let (ode, initial, horizon) = (problem.ode(), problem.initial(), problem.facts().window.horizon);
    let rate = |t: f64| {
        let mut rate = vec![0.0; initial.len()];
        ode.rhs(t, &initial, &mut rate);
        rate
    };
    let first = rate(0.0);
    [0.3, 0.7].into_iter().any(|part| rate(part * horizon) != first)
}

#[cfg(test)]
mod tests {
    use lsvi::Integrator;

    use super::*;
    use crate::method::BuildError;

    #[test]
    fn what_theory_rules_out_fails_where_it_is_found() {
        let of = |order: f64| {
            let samples: Vec<_> = (0..8).map(|k| 0.1 * 0.5_f64.powi(k)).map(|h| Sample::new(h, h * h, 0.0)).collect();
            fit(&samples, &order::Expectation::new(order, 0.1))
        };
        let verdict = |found: Result<OrderFit, OrderError>| found.map(|found| found.verdict);
        let untold = |found| matches!(found, Err(OrderError::Untold { because: "why", .. }));
        assert!(matches!(verdict(beside_theory(of(2.0), None, None)), Ok(Verdict::Pass)));
        assert!(matches!(verdict(beside_theory(of(3.0), None, None)), Ok(Verdict::Fail)));
        assert!(matches!(verdict(beside_theory(of(2.0), None, Some("why"))), Ok(Verdict::Pass)));
        assert!(untold(verdict(beside_theory(of(2.5), None, Some("why")))));
        // An order less is no order that has not settled.
        assert!(matches!(verdict(beside_theory(of(3.0), None, Some("why"))), Ok(Verdict::Fail)));
        assert!(untold(verdict(beside_theory(of(3.0), Some("why"), None))));
        let found = beside_theory(of(2.0), Some("why"), None).expect("told");
        assert!(found.verdict == Verdict::Fail && found.reason.ends_with("no order should be told: why"));
    }

    #[test]
    fn a_tenth_of_the_solution_is_the_most_that_tells_of_an_order() {
        for size in [1e-3, 1.0, 1e3] {
            assert_eq!(
                [0.09, 0.11, 10.0, f64::INFINITY].map(|part| is_lost(part * size, size)),
                [false, true, true, true]
            );
        }
    }

    #[test]
    fn errors_of_a_model_that_no_step_resolves_and_stiff_ones_decide_nothing() {
        let of = |order: f64, constant: f64| {
            let samples: Vec<_> =
                (0..8).map(|k| 0.1 * 0.5_f64.powi(k)).map(|h| Sample::new(h, constant * h, 0.0)).collect();
            fit(&samples, &order::Expectation::new(order, 0.1))
        };
        // The finest error is 1/1280 of the constant.
        let open = |order, constant, rate| unexplored(&of(f64::from(order), constant), order, 1.0, rate).is_some();
        assert!(!open(1, 100.0, 1.0) && open(1, 200.0, 1.0) && open(2, 200.0, 1.0));
        assert!(!open(2, 1.0, 1000.0) && open(2, 1.0, 2000.0) && !open(1, 1.0, 2000.0));
        // Of a solution of ten the error is a tenth.
        assert!(unexplored(&of(1.0, 200.0), 1, 10.0, 1.0).is_none());
        // No excuse for what has no order, or claims more than it has, and none is needed where an order is found or exceeded.
        assert!(unexplored(&of(1.0, 200.0), 0, 1.0, 1.0).is_none());
        assert!(unexplored(&of(2.0, 1.0), 1, 1.0, 2000.0).is_none());
        for (slope, verdict) in [(1.95, Verdict::Pass), (3.0, Verdict::Fail)] {
            let samples: Vec<_> =
                (0..8).map(|k| 0.1 * 0.5_f64.powi(k)).map(|h| Sample::new(h, h.powf(slope), 0.0)).collect();
            let found = fit(&samples, &order::Expectation::new(2.0, 0.1));
            assert_eq!((found.verdict, unexplored(&found, 2, 1.0, 2000.0)), (verdict, None), "{slope}");
        }
    }

    /// Across a kink of f = max(t − ½, 0) errors fall with h²: one of order 4 that has 2 is excused, and one that has 1 is not.
    #[test]
    fn a_kink_excuses_no_lower_order_than_it_leaves() {
        let model = crate::problem::model::Model::of_text("u_i { x = 0 } F_i { max(t - 0.503, 0) }", &[], Some(1.0))
            .expect("a model");
        let limit = model.limit(crate::kinds::Principle::Equation);
        let along = |times: &[f64]| {
            Some(times.iter().map(|t| (vec![0.5 * (t - 0.503).max(0.0).powi(2)], 0.0)).collect::<Vec<_>>())
        };
        let why_of = |slope: f64, order: u32| {
            let samples: Vec<_> =
                (0..8).map(|k| 0.1 * 0.5_f64.powi(k)).map(|h| Sample::new(h, h.powf(slope), 0.0)).collect();
            let found = fit(&samples, &order::Expectation::new(4.0, 0.1));
            assert_eq!(found.verdict, Verdict::Fail);
            unsmooth(&found, order, &limit, 1.0, along)
        };
        let why = |slope: f64| why_of(slope, 4);
        assert!(why(2.0).is_some_and(|why| why.contains("f is not smooth along the solution near t = 0.50")));
        assert_eq!(why(1.0), None);
        assert_eq!(why_of(2.0, 5), None, "another order is expected than the method's own");
        // Order 4 in longer steps, then 2.
        let samples: Vec<_> =
            (0..8).map(|k| 0.1 * 0.5_f64.powi(k)).map(|h| Sample::new(h, h.powi(4) + 1e-5 * h * h, 0.0)).collect();
        let found = fit(&samples, &order::Expectation::new(4.0, 0.1));
        let text = unsmooth(&found, 4, &limit, 1.0, along).expect("it is rough");
        assert!(
            text.contains("fall by another order than those of longer ones") && !text.contains("no order above"),
            "{text}"
        );
    }

    /// The classical method of order 4, as if its coefficients had digits that leave so much open, times a power of the number of steps.
    #[derive(Debug)]
    struct Rounded(Box<dyn Method>, f64, i32);

    impl Method for Rounded {
        fn name(&self) -> String {
            "rounded".into()
        }
        fn traits(&self) -> crate::method::Traits {
            self.0.traits()
        }
        fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
            self.0.build(problem)
        }
        fn rounding_of_coefficients(&self, _size: f64, _length: f64, steps: f64) -> f64 {
            self.1 * steps.powi(self.2)
        }
    }

    fn rounded(digits: f64, power: i32) -> Rounded {
        Rounded(crate::method::parse("rk4").expect("known"), digits, power)
    }

    /// Of errors e^{−T} T h⁴/120, of which the digits leave a twelfth open at each step: above their floors, with slopes that these may bend by more than
    /// the band.
    #[test]
    fn digits_are_blamed_for_what_they_leave_open_above_the_floor() {
        let problem = crate::problem::small("linear-drag").expect("a problem");
        let horizon = order_plan(&*problem, &rounded(0.0, 0)).horizon;
        let measured = |part: f64| {
            let method = rounded(part * (-horizon).exp() * horizon.powi(5) / 120.0, -4);
            measure_on(&*problem, &method, Truth::Exact, &Ladder { points: Some(4), ..Ladder::default() })
                .expect("a fit")
        };
        let found = measured(1.0 / 12.0);
        assert!(found.verdict == Verdict::Inconclusive && found.kept.len() == 4 && found.is_of_digits, "{found:?}");
        let found = measured(1e-3);
        assert!(found.verdict == Verdict::Pass && !found.is_of_digits, "{found:?}");
    }

    /// The ansatz leaves a remainder by which Method I, of order 2, has order 1, and Method II the one that it has anyway.
    #[test]
    fn an_order_is_declared_where_the_problem_lowers_it() {
        let problem = crate::problem::small("poiseuille-ansatz").expect("a problem");
        let declared = |name: &str| {
            let method = crate::method::parse(name).expect("known");
            let ladder = Ladder { points: Some(4), ..Ladder::default() };
            let found = measure_on(&*problem, &*method, Truth::Exact, &ladder).expect("a fit");
            (found.expected.order, found.expected.declared.map(|declared| declared.nominal))
        };
        assert_eq!([declared("method-i"), declared("method-ii")], [(1.0, Some(2.0)), (2.0, None)]);
    }

    /// Where all errors are at their floor, and up to half of the time.
    #[test]
    fn steps_start_coarser_where_that_may_tell_of_an_order() {
        let problem = crate::problem::small("linear-drag").expect("a problem");
        let OrderPlan { horizon, steps, .. } = order_plan(&*problem, &rounded(0.0, 1));
        let measured = |digits: f64, ladder: &Ladder| {
            let found = measure_on(&*problem, &rounded(digits, 1), Truth::Exact, ladder).expect("a fit");
            let coarsest = found.points()[0].0.h;
            (found, coarsest)
        };
        let (found, coarsest) = measured(1e-6, &Ladder::default());
        for sample in found.points().into_iter().map(|(sample, _)| sample) {
            let (floor, digits) = (sample.result.as_ref().expect("it ran").floor, 1e-6 * horizon / sample.h);
            assert!((floor / digits - 1.0).abs() < 1e-6, "{floor:e} for {digits:e}");
        }
        assert!(coarsest > steps[0] && coarsest <= 0.5 * horizon, "{coarsest}");
        let (found, coarsest) = measured(1e3, &Ladder::default());
        assert_eq!(found.verdict, Verdict::Inconclusive);
        assert!(coarsest > 0.25 * horizon && coarsest <= 0.5 * horizon, "{coarsest}");
        // Not where steps are asked for, nor for slopes that have not settled above the floors.
        let asked = Ladder { points: Some(steps.len()), ..Ladder::default() };
        let narrow = Ladder { band: Some(1e-6), ..Ladder::default() };
        for (digits, ladder) in [(1e3, asked), (0.0, narrow)] {
            let (found, coarsest) = measured(digits, &ladder);
            assert_eq!((found.verdict, coarsest), (Verdict::Inconclusive, steps[0]), "{digits}");
        }
    }

    /// Elsewhere the truth would be that of CVODE, which is less accurate.
    #[test]
    fn stiff_problems_are_tabulated_at_the_ends_of_all_runs() {
        for name in ["robertson", "oregonator", "hires"] {
            let problem = crate::problem::small(name).expect("a problem");
            let facts = problem.facts();
            let before = facts.singular.and_then(|singular| singular.before);
            for window in [Some(facts.window), before].into_iter().flatten() {
                assert!(problem.tabulated(window.horizon).is_some(), "{name} at {}", window.horizon);
            }
        }
    }

    /// With half of 0.2, floors above a twentieth of an error move its slopes that far.
    #[test]
    fn digits_are_blamed_where_they_are_most_of_a_floor_that_moves_slopes() {
        let blamed = |runs: &[[f64; 3]]| {
            let samples: Vec<_> = runs.iter().map(|[error, floor, _]| Sample::new(0.1, *error, *floor)).collect();
            blame_digits(samples.iter().zip(runs.iter().map(|[.., digits]| *digits)), 0.2)
        };
        assert!(blamed(&[[1.0, 0.06, 0.04]]).is_some_and(|text| text.contains(" leave 4.0e-2 of")));
        for run in [[1.0, 0.04, 0.03], [1.0, 0.0625, 0.03125], [1.0, 0.06, 0.01], [2.0, 0.06, 0.04]] {
            assert_eq!(blamed(&[run]), None, "{run:?}");
        }
        let runs = [[1.0, 0.06, 0.04], [1.0, 0.08, 0.05], [9.0, 0.1, 0.09]];
        assert!(blamed(&runs).is_some_and(|text| text.contains(" leave 5.0e-2 of")));
    }

    #[test]
    fn a_finer_reference_is_asked_for_where_the_present_one_leaves_errors_at_its_floor() {
        let of = |floor: f64| {
            let samples: Vec<_> = (0..8).map(|k| 0.1 * 0.5_f64.powi(k)).map(|h| Sample::new(h, h * h, floor)).collect();
            fit(&samples, &order::Expectation::new(2.0, 0.1))
        };
        let numerical = Source::Diffsol.of(&*crate::problem::small("logistic").expect("a problem"), 1.0);
        let (settled, floored) = (of(0.0), of(1e-2));
        assert_eq!((settled.verdict, floored.verdict), (Verdict::Pass, Verdict::Inconclusive));
        let asked = Ladder { tolerance: Some(1e-9), ..Ladder::default() };
        assert!(numerical.may_be_finer(&floored, &Ladder::default()));
        assert!(!numerical.may_be_finer(&settled, &Ladder::default()) && !numerical.may_be_finer(&floored, &asked));
        assert!(!Truth::Exact.may_be_finer(&floored, &Ladder::default()));
    }

    /// One period over the horizon: at its ends nothing shows.
    #[test]
    fn a_field_that_comes_back_at_the_horizon_depends_on_time() {
        let depends = |text: &str| {
            depends_on_time(&crate::problem::model::Model::of_text(text, &[], Some(1.0)).expect("a model"))
        };
        assert!(depends("u_i { x = 1 } F_i { -x + cos(2*3.141592653589793*t) }"));
        assert!(!depends("u_i { x = 1 } F_i { -x }"));
    }

    /// In whatever units of time.
    #[test]
    fn a_field_that_acts_for_a_part_of_the_horizon_depends_on_time() {
        for horizon in [0.01, 10.0] {
            let [on, off] = [0.2, 0.8].map(|part| part * horizon);
            let text = format!("u_i {{ x = 1 }} F_i {{ -x + heaviside(t - {on})*heaviside({off} - t) }}");
            let model = crate::problem::model::Model::of_text(&text, &[], Some(horizon)).expect("a model");
            assert!(depends_on_time(&model), "{horizon}");
        }
    }
}
