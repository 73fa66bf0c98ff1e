//! What a solver of a problem answers at the sample times, and a bound on the error of that.

use std::cell::Cell;

use nalgebra::DMatrix;

use super::open::passed;
use super::{Guest, RESOLVED, SETTLED};
use crate::measure::decimal::{significant, trimmed};
use crate::measure::norm::{Extremes, common_distance, larger, max_norm};
use crate::measure::stability::spectral_radius;
use crate::method::{Method, roundoff};
use crate::problem::jumps::Jumps;
use crate::problem::{Limit, Problem, component_names};
use crate::program::Request;
use crate::reference::{Reference, ReferenceError};
use crate::run::{RunError, run};
use crate::theory::{Breakdown, breakdown};

/// Steps of the coarser of a method's two runs, a multiple of [`SAMPLES`]; doubled up to [`MOST_STEPS`] until the bound resolves
/// the solution.
pub(super) const STEPS: usize = 1024;
pub(super) const MOST_STEPS: usize = 8 * STEPS;
/// The same of a method whose own solutions grow.
const MOST_STEPS_AMID_GROWTH: usize = 64 * STEPS;

/// The same of a system of more than this many unknowns, whose steps are dear.
const FEW_STEPS: usize = 128;
pub(super) const LARGE: usize = 200;

/// Unknowns of all steps together up to which a solver is run that is not made for stiff problems, some seconds: its steps are not much longer
/// than the fastest rate of f allows.
const MOST_WORK: f64 = 1e6;

/// Unknowns up to which the fastest rate is that of an eigenvalue; of larger systems ‖∂f/∂v‖∞ stands for it.
pub(super) const DENSE: usize = 64;

/// Least order that a bound is taken with.
const MIN_ORDER: f64 = 1.0;

/// Least order by which the differences of further runs fall where those of the last three pairs did.
const LEAST_ORDER: f64 = 0.5;

/// States at the sample times, and a bound on their error.
pub(super) struct Answer {
    pub(super) states: Vec<Vec<f64>>,
    pub(super) bound: f64,
    /// Why it must be wrong, or may be, as the problem declares.
    pub(super) astray: Option<Breakdown>,
    /// Where the bound is from, if from runs with fixed steps.
    pub(super) runs: Option<Runs>,
}

/// What runs with steps of 2h and h, and of 4h where these were needed, show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Runs {
    pub(super) h: f64,
    /// The order that the bound is taken with.
    pub(super) order: f64,
    /// The order by which the differences of three runs fall, and that of the three before.
    pub(super) observed: Option<f64>,
    pub(super) earlier: Option<f64>,
    /// Whether the differences are those of errors of that order or of a higher one, or of roundings, or so small that the runs go
    /// elsewhere than the truth, whatever the order.
    pub(super) is_settled: bool,
    /// Why longer steps do not do, where that is known.
    pub(super) longer: Option<&'static str>,
}

impl Answer {
    fn refused_longer_steps(self) -> Self {
        let longer = Some("a step has no answer");
        Self { runs: self.runs.map(|runs| Runs { longer, ..runs }), ..self }
    }
}

/// Why a solver gave no answer.
pub(super) enum Gap {
    NotRun(String),
    Failed(String),
    /// It failed, as the problem declares that it must.
    BrokeDown(String),
}

impl From<ReferenceError> for Gap {
    fn from(error: ReferenceError) -> Self {
        match error {
            ReferenceError::Unavailable(_) => Self::NotRun(error.to_string()),
            _ => Self::Failed(error.to_string()),
        }
    }
}

/// A solver and what it gave.
pub(super) type Solved = (String, Result<Answer, Gap>);

pub(super) fn by_reference(
    reference: &dyn Reference,
    problem: &dyn Problem,
    limit: &Limit<'_>,
    times: &[f64],
) -> Result<Answer, Gap> {
    if problem.is_stiff() && !reference.stiff_ok() {
        let steps = lives(limit, times[times.len() - 1]);
        let unknowns = limit.ode.dim();
        if steps * unknowns as f64 > MOST_WORK {
            return Err(Gap::NotRun(format!(
                "the fastest rate of f times the horizon is {}: the solver takes a step for each or more, of {unknowns} unknowns, and {MOST_WORK:e} are \
                 the most that are found",
                significant(steps, 2)
            )));
        }
    }
    let sampled = reference.solve(limit.ode, 0.0, &limit.initial, times)?;
    let bound = max_norm(&sampled.bound);
    Ok(Answer { states: sampled.states, bound, astray: None, runs: None })
}

/// The fastest rate of f at the start times the horizon; 0 where it is not found.
fn lives(limit: &Limit<'_>, horizon: f64) -> f64 {
    let n = limit.ode.dim();
    let (mut rows, mut dense) = (vec![0.0; n], DMatrix::<f64>::zeros(n.min(DENSE), n.min(DENSE)));
    limit.ode.jacobian(0.0, &limit.initial, &mut |i, j, x| {
        rows[i] += x.abs();
        dense.get_mut((i, j)).into_iter().for_each(|entry| *entry += x);
    });
    let norm = rows.into_iter().largest();
    let is_known = n <= DENSE && norm.is_finite();
    let rate = if is_known { spectral_radius(&dense) } else { norm };
    // An eigenvalue that is not found is NaN.
    if rate.is_nan() { 0.0 } else { rate * horizon }
}

pub(super) fn by_method(
    problem: &dyn Problem,
    method: &dyn Method,
    times: &[f64],
    truth: Option<&Answer>,
) -> Result<Answer, Gap> {
    let reached = Cell::new(0.0_f64);
    let sampled = |steps: usize| -> Result<Vec<Vec<f64>>, RunError> {
        let (mut states, mut count) = (Vec::with_capacity(times.len()), 0);
        let horizon = times[times.len() - 1];
        reached.set(0.0);
        run(problem, method, horizon / steps as f64, horizon, |state| {
            reached.set(larger(reached.get(), max_norm(&state.q)));
            if count > 0 && count % (steps / times.len()) == 0 {
                states.push(state.q.clone());
            }
            count += 1;
        })?;
        Ok(states)
    };
    let breakdown = breakdown(problem, method, times[times.len() - 1]);
    let failed = |error: RunError| match (error, breakdown) {
        (RunError::Build(error), _) => Gap::NotRun(error.to_string()),
        // What else ends a run, as an iteration that does not converge, is not what was declared.
        (error, Some(Breakdown { reason, .. })) if error.in_place_of_a_number() == f64::INFINITY => {
            Gap::BrokeDown(format!("{error}; as declared: {reason}"))
        }
        // What has left the truth far behind has gone astray before, whatever ends it.
        (error, Some(Breakdown { reason, is_certain: true }))
            if truth.is_some_and(|truth| RESOLVED * reached.get() > largest(&truth.states)) =>
        {
            let grown = significant(reached.get(), 2);
            Gap::BrokeDown(format!("it grows to {grown}, as declared: {reason}; then {error}"))
        }
        (error, _) => Gap::Failed(error.to_string()),
    };
    if method.traits().is_adaptive {
        let answer = by_tolerance(problem, method, times).map_err(failed)?;
        return Ok(Answer { astray: breakdown, ..answer });
    }
    let cap = problem.limit(method.principle()).order.unwrap_or(f64::INFINITY);
    // What is inconsistent converges too, to something else.
    let order = f64::from(method.order()).min(cap).max(MIN_ORDER);
    let rounding = |size: f64, steps: usize| roundoff(method, size, steps as f64);
    let fewest = if problem.field().dim() > LARGE { FEW_STEPS } else { STEPS };
    let most = match breakdown {
        // What must go astray needs no shorter steps.
        Some(Breakdown { is_certain: true, .. }) => 0,
        // What may, shows in long ones first.
        Some(_) => MOST_STEPS_AMID_GROWTH,
        None => MOST_STEPS,
    };
    let refined =
        |first: usize| refined(first, |steps| sampled(steps).map_err(failed), order, rounding, times, truth, most);
    // Where long steps have no answer, shorter ones may.
    let refined_shorter = |found: Result<Answer, Gap>, times: usize| match found {
        Err(Gap::Failed(_)) => refined(times * fewest).map(Answer::refused_longer_steps),
        found => found,
    };
    let answer = [2, 4, 8].into_iter().fold(refined(fewest), refined_shorter)?;
    let answer = across_jumps(problem, times, answer);
    // A model declares nothing, and is looked at where an answer is in need of a reason.
    let is_off = truth.is_some_and(|truth| !is_near(&answer, truth));
    let passed = || passed(problem, method, times[times.len() - 1]);
    Ok(Answer { astray: breakdown.or_else(|| is_off.then(passed).flatten()), ..answer })
}

/// Runs of several step sizes may miss the same of a jump of f, a step at most, of which their bound does not know. The f of a problem that is
/// registered has none, and what is shown of it may be no state.
pub(super) fn across_jumps(problem: &dyn Problem, times: &[f64], answer: Answer) -> Answer {
    if problem.facts().model.is_none() {
        return answer;
    }
    let course = [&[problem.initial()], &answer.states[..]].concat();
    let jumps = Jumps::new(problem).map_or(0.0, |mut jumps| jumps.sum(&[&[0.0], times].concat(), &course));
    let jumped = jumps * answer.runs.map_or(0.0, |runs| runs.h);
    Answer { bound: answer.bound + jumped, ..answer }
}

/// The answer of an adaptive method with tolerances a hundredth of its own; its bound is the distance from the one with its own, which
/// is most of that one's error. Where no step may be long, those of the finer are half as long, so that the two differ.
pub(super) fn by_tolerance(problem: &dyn Problem, method: &dyn Method, times: &[f64]) -> Result<Answer, RunError> {
    let longest = problem.ode().longest_step(times[times.len() - 1]);
    // To each time by itself, as steps end where they like.
    let sampled = |method: &dyn Method, h: f64| -> Result<Vec<Vec<f64>>, RunError> {
        times.iter().map(|t| Ok(run(problem, method, h.min(*t), *t, |_| {})?.end.q)).collect()
    };
    let own = sampled(method, longest)?;
    let states = match method.tightened(100.0) {
        Some(finer) => sampled(&*finer, 0.5 * longest)?,
        None => own.clone(),
    };
    let bound = largest_distance(&own, &states) + roundoff(method, largest(&states), STEPS as f64);
    Ok(Answer { states, bound, astray: None, runs: None })
}

/// A program's bound is that of a method, with no roundings but its own last digits.
pub(super) fn by_program(
    problem: &dyn Problem,
    guest: &Guest,
    times: &[f64],
    truth: Option<&Answer>,
) -> Result<Answer, Gap> {
    let columns = component_names(problem);
    let horizon = times[times.len() - 1];
    let printed = Cell::new(0.0_f64);
    let sampled = |steps: usize| -> Result<Vec<Vec<f64>>, Gap> {
        let request = Request { h: Some(horizon / steps as f64), t_end: Some(horizon), ..guest.request.clone() };
        let answer = guest.program.run(&request, &columns).map_err(|error| Gap::Failed(error.to_string()))?;
        printed.set(answer.printed.resolution(largest(&answer.states)));
        let at = |t: &f64| answer.times.iter().position(|time| (time - t).abs() <= 1e-9 * horizon);
        let found = times.iter().map(|t| at(t).map(|k| answer.states[k].clone()).ok_or(*t));
        found.collect::<Result<_, f64>>().map_err(|t| {
            let h = trimmed(horizon / steps as f64, 9);
            Gap::Failed(format!("it has no row at t = {}, a multiple of its step h = {h}", trimmed(t, 9)))
        })
    };
    let rounding = |size: f64, steps: usize| f64::EPSILON * size * steps as f64 + printed.get();
    let answer = refined(STEPS, sampled, guest.order, rounding, times, truth, MOST_STEPS)?;
    Ok(across_jumps(problem, times, answer))
}

/// The answer of runs whose steps are halved until their bound resolves the solution and, where it does not hold `truth`, until
/// their differences fall as errors of `order` do: before, they predict nothing, and what falls by a lower order, as beside a jump of f,
/// has no bound that is known. With more than `most` steps a bound is all that is wanted.
pub(super) fn refined(
    first: usize,
    sampled: impl Fn(usize) -> Result<Vec<Vec<f64>>, Gap>,
    order: f64,
    rounding: impl Fn(f64, usize) -> f64,
    times: &[f64],
    truth: Option<&Answer>,
    most: usize,
) -> Result<Answer, Gap> {
    let horizon = times[times.len() - 1];
    let (mut steps, mut coarse) = (first, sampled(first)?);
    let (mut before, mut earlier) = (None, None);
    let mut resolved_before = false;
    loop {
        steps *= 2;
        let states = sampled(steps)?;
        let (difference, size) = (largest_distance(&coarse, &states), largest(&states));
        let floor = rounding(size, steps);
        let observed: Option<f64> = before.map(|before: f64| (before / difference).log2());
        // Once it may be by accident, as where a jump falls into a step; a higher order than the bound's makes that wider.
        let has_order =
            |(now, before): (f64, f64)| now.min(before) >= order - SETTLED && (now - before).abs() <= SETTLED;
        // So may two runs be one, where a jump falls into the same half of both steps.
        let rests = difference <= floor && before.is_some_and(|before: f64| before <= floor);
        let bound_by = |order: f64| 2.0 * difference / (order.exp2() - 1.0) + floor;
        let has_some_order =
            |(now, before): (f64, f64)| now.min(before) >= LEAST_ORDER && (now - before).abs() <= SETTLED;
        let goes_elsewhere = |truth: &Answer| {
            observed.zip(earlier).is_some_and(has_some_order)
                && largest_distance(&states, &truth.states) > bound_by(LEAST_ORDER) + truth.bound
        };
        let is_settled = rests || observed.zip(earlier).is_some_and(has_order) || truth.is_some_and(goes_elsewhere);
        let bound = bound_by(order);
        let longer = resolved_before.then_some("its errors are not yet those of its order");
        let runs = Runs { h: horizon / steps as f64, order, observed, earlier, is_settled, longer };
        let answer = Answer { states, bound, astray: None, runs: Some(runs) };
        let is_resolved = bound <= RESOLVED * size;
        let is_told = truth.is_none_or(|truth| is_near(&answer, truth)) || is_settled;
        if is_resolved && is_told || steps > most {
            return Ok(answer);
        }
        if is_resolved {
            resolved_before = true;
        }
        (before, earlier) = (Some(difference), observed);
        coarse = answer.states;
    }
}

/// The largest component of all states.
pub(super) fn largest(states: &[Vec<f64>]) -> f64 {
    states.iter().map(|v| max_norm(v)).largest()
}

/// What the problem shows of states, with a bound on the error of that: what is shown is an affine function of the state, so that its
/// error is at most that of the state times the largest sum of the sizes of what unit states add to a component.
pub(super) fn shown(problem: &dyn Problem, times: &[f64], answer: Answer) -> Answer {
    let states: Vec<_> = times.iter().zip(&answer.states).map(|(t, state)| problem.observe(*t, state)).collect();
    if states == answer.states {
        return answer;
    }
    let (t, mut unit) = (times[times.len() - 1], vec![0.0; answer.states[0].len()]);
    let without = problem.observe(t, &unit);
    let mut sums = vec![0.0; without.len()];
    for i in 0..unit.len() {
        unit[i] = 1.0;
        let with = problem.observe(t, &unit);
        sums.iter_mut().zip(with.iter().zip(&without)).for_each(|(sum, (a, b))| *sum += (a - b).abs());
        unit[i] = 0.0;
    }
    Answer { states, bound: answer.bound * max_norm(&sums), ..answer }
}

/// Whether an answer is within its bound and the truth's.
pub(super) fn is_near(answer: &Answer, truth: &Answer) -> bool {
    largest_distance(&answer.states, &truth.states) <= answer.bound + truth.bound
}

/// Of the momenta that an equation may have beside v closed forms know nothing.
pub(super) fn largest_distance(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| common_distance(a, b)).largest()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::Ode;

    /// v̇ = J v with a chain J of rates, each named in two parts.
    #[derive(Debug)]
    struct Chain {
        rates: Vec<f64>,
        coupling: f64,
    }

    impl Ode for Chain {
        fn dim(&self) -> usize {
            self.rates.len()
        }
        fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
            self.product(t, v, v, dv);
        }
        fn jacobian(&self, _t: f64, _v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
            for (i, rate) in self.rates.iter().enumerate() {
                add(i, i, -0.25 * rate);
                add(i, i, -0.75 * rate);
                if i > 0 {
                    add(i, i - 1, self.coupling);
                }
            }
        }
    }

    /// Of a few unknowns by its eigenvalues, 1 and 2 beside a coupling of 100, of many by its rows, 3 + 1.
    #[test]
    fn lives_are_those_of_the_fastest_rate() {
        let of = |rates: Vec<f64>, coupling: f64| {
            let chain = Chain { rates, coupling };
            let (initial, exact) = (vec![1.0; chain.dim()], Box::new(|_: f64| None));
            lives(&Limit { name: "", ode: &chain, initial, exact, order: None, reason: "" }, 10.0)
        };
        assert_eq!(of(vec![1.0, 2.0], 100.0), 20.0);
        assert_eq!(of(vec![3.0; DENSE], 1.0), 30.0);
        assert_eq!(of(vec![3.0; DENSE + 1], 1.0), 40.0);
        assert_eq!(of(vec![f64::NAN, 2.0], 1.0), 0.0, "it is not found");
    }
}
