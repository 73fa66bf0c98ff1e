//! Trial runs, and what they cost.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::rc::Rc;

use lsvi::{Structure, Work};

use super::changes::changes;
use super::worst;
use crate::measure::norm::{common_distance, larger, max_norm};
use crate::method::Method;
use crate::problem::Problem;
use crate::run::{RunError, run, run_between, run_from, run_through};

/// A run that reaches the accuracy.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// The method.
    pub method: String,
    /// Its step size, or tolerance.
    pub setting: f64,
    /// Its steps.
    pub steps: u64,
    /// Its largest error, at so many times.
    pub error: f64,
    /// The number of these times, ends of its steps.
    pub times: usize,
    /// Its work in evaluations of f.
    pub cost: f64,
    /// The order with which the errors fall here, and the nominal one; none for an adaptive method.
    pub order: Option<(f64, u32)>,
}

impl Trial {
    /// The order found and the nominal one, where errors fall so slowly that those of other steps cannot be told.
    pub fn unpredictable(&self) -> Option<(f64, u32)> {
        // NaN is no order.
        self.order.filter(|(found, nominal)| found.is_nan() || *found < f64::from(*nominal) - 0.5)
    }
}

/// Steps of the coarsest and finest trial.
const LEAST: u32 = 4;
pub(super) const MOST: u32 = 1 << 14;

/// Errors are measured at the ends of this many steps, or of all where there are fewer.
pub(super) const TIMES: usize = 64;

/// Steps of the run at whose times the size of the solution and its motion are told: many to each of the [`TIMES`].
const FINE: u32 = 1 << 10;

/// Times that differ by this part of the horizon are one.
const RESOLVED: f64 = 1e-9;

/// The part by which a time advances in each of the equal parts of a run over the one before: the golden ratio, to whose multiples no
/// period is near.
pub(super) const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// The numbers of those of `count` steps at whose ends errors are measured: each, or one in each of [`TIMES`] equal parts, the last of all
/// included. Where in its part is irregular, lest what is periodic shows one phase only.
pub(super) fn chosen(count: usize) -> Vec<usize> {
    if count <= TIMES {
        return (1..=count).collect();
    }
    let end = |part: usize| {
        let within = (part as f64 * GOLDEN).fract();
        let step = (count as f64 * (part as f64 - within) / TIMES as f64).ceil();
        (step as usize).clamp(1, count)
    };
    let mut chosen: Vec<usize> = (1..TIMES).map(end).chain([count]).collect();
    // Of few steps two parts may choose the same.
    chosen.dedup();
    chosen
}

/// An accurate solution at the chosen ends of the steps of runs, looked up by their number.
pub(super) struct Truth<'a> {
    problem: &'a dyn Problem,
    method: &'a dyn Method,
    horizon: f64,
    /// When f changes by itself.
    changes: Vec<f64>,
    known: RefCell<BTreeMap<u32, Rc<Vec<Vec<f64>>>>>,
    /// The largest component of the runs that were made, and how far they went from their start.
    extent: Cell<(f64, f64)>,
    /// Where they end.
    ends: RefCell<Vec<Vec<f64>>>,
}

impl<'a> Truth<'a> {
    /// By an adaptive method.
    pub(super) fn by(problem: &'a dyn Problem, method: &'a dyn Method, horizon: f64) -> Result<Self, RunError> {
        let (known, extent, ends) = Default::default();
        let mut truth = Self { problem, method, horizon, changes: Vec::new(), known, extent, ends };
        truth.changes = changes(problem, horizon, &truth.ends_of(FINE));
        truth.of_steps(FINE)?;
        Ok(truth)
    }

    /// The numbers of the steps that end at `ends` at which errors are measured: [`chosen`] ones, and those in which f changes.
    fn shown(&self, ends: &[f64]) -> Vec<usize> {
        let mut shown = chosen(ends.len());
        let after = |t: &f64| ends.partition_point(|end| end < t) + 1;
        shown.extend(self.changes.iter().map(after).filter(|step| *step <= ends.len()));
        shown.sort_unstable();
        shown.dedup();
        shown
    }

    /// The numbers of those of so many steps at whose ends errors are measured.
    fn steps(&self, steps: u32) -> Vec<usize> {
        let ends: Vec<f64> = (1..=steps).map(|step| self.horizon * f64::from(step) / f64::from(steps)).collect();
        self.shown(&ends)
    }

    /// The states at these ends.
    fn of_steps(&self, steps: u32) -> Result<Rc<Vec<Vec<f64>>>, RunError> {
        if let Some(states) = self.known.borrow().get(&steps) {
            return Ok(Rc::clone(states));
        }
        let states = Rc::new(self.at(&self.ends_of(steps))?);
        self.known.borrow_mut().insert(steps, Rc::clone(&states));
        Ok(states)
    }

    /// Those ends.
    fn ends_of(&self, steps: u32) -> Vec<f64> {
        let end = |step: usize| self.horizon * step as f64 / f64::from(steps);
        self.steps(steps).into_iter().map(end).collect()
    }

    /// The states at `times` up to the horizon, by a run that stops at those of many steps too: a run as long as it likes may pass
    /// over what the solution does.
    fn at(&self, times: &[f64]) -> Result<Vec<Vec<f64>>, RunError> {
        let is_asked = |t: &f64| times.iter().any(|time| (time - t).abs() <= RESOLVED * self.horizon);
        let stops = self.ends_of(FINE).into_iter().chain(self.changes.iter().copied());
        let stops = stops.filter(|t| !is_asked(t) && *t > 0.0).map(|t| (t, false));
        let mut stops: Vec<(f64, bool)> = times.iter().map(|t| (*t, true)).chain(stops).collect();
        stops.sort_by(|a, b| a.0.total_cmp(&b.0));
        stops.dedup_by(|next, stop| !next.1 && next.0 - stop.0 <= RESOLVED * self.horizon);
        let all = run_through(self.problem, self.method, &stops.iter().map(|(t, _)| *t).collect::<Vec<_>>())?;
        self.ends.borrow_mut().extend(all.last().cloned());
        let (start, (size, moved)) = (self.problem.initial(), self.extent.get());
        let size = all.iter().map(|state| max_norm(state)).fold(size, larger);
        self.extent.set((size, all.iter().map(|state| common_distance(state, &start)).fold(moved, larger)));
        Ok(all.into_iter().zip(&stops).filter_map(|(state, (_, is_asked))| is_asked.then_some(state)).collect())
    }

    /// How far the runs that were made end from the first one.
    pub(super) fn parts_by(&self) -> f64 {
        let ends = self.ends.borrow();
        worst(ends.iter().map(|end| common_distance(end, &ends[0])))
    }

    /// The largest component, or 1.
    pub(super) fn size(&self) -> f64 {
        larger(self.extent.get().0, 1.0)
    }

    /// How far it goes from its start, as far as any run has asked.
    pub(super) fn moves_by(&self) -> f64 {
        self.extent.get().1
    }
}

/// A run that takes so many times the work that is worth a trial is broken off. Its error might still have confirmed the solution.
const WORTH: f64 = 4.0;

/// A run with a number of steps: its largest error at the times chosen, infinite if it was broken off, and its work.
struct Ran {
    steps: u32,
    error: f64,
    work: Work,
}

impl Ran {
    /// With its error at the times of a run with `shown` steps, of which its own are a multiple; broken off after the work `most`.
    fn at_ends_of(
        shown: u32,
        (problem, method): (&dyn Problem, &dyn Method),
        steps: u32,
        truth: &Truth,
        most: f64,
    ) -> Result<Self, RunError> {
        let (states, times) = (truth.of_steps(shown)?, truth.steps(shown));
        let (every, mut step, mut next, mut worst) = ((steps / shown) as usize, 0, 0, 0.0);
        let (h, cost) = (truth.horizon / f64::from(steps), cost(problem, method));
        let run = run_from(problem, problem.initial(), method, h, truth.horizon, |state, work| {
            if times.get(next).is_some_and(|time| time * every == step) {
                worst = larger(worst, common_distance(&states[next], &state.q));
                next += 1;
            }
            step += 1;
            if cost(work) > most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })?;
        let error = if next < times.len() { f64::INFINITY } else { worst };
        Ok(Self { steps, error, work: run.work })
    }
}

/// The run of an adaptive method, if its error is within the target at the ends of its steps that are chosen, and between them where f
/// changes by itself, over which a step may pass. They are those of a run that a user makes; the truth is followed to where they end.
pub(super) fn with_tolerance(
    problem: &dyn Problem,
    method: &dyn Method,
    tolerance: f64,
    truth: &Truth,
    target: f64,
) -> Option<Trial> {
    let horizon = truth.horizon;
    let mut ends = Vec::new();
    let run = run(problem, method, horizon, horizon, |state| ends.push((state.t, state.q.clone()))).ok()?;
    // The first is the start.
    let all: Vec<f64> = ends[1..].iter().map(|(t, _)| *t).collect();
    let shown: Vec<_> = truth.shown(&all).into_iter().map(|step| &ends[step]).collect();
    let times: Vec<f64> = shown.iter().map(|(t, _)| *t).collect();
    let between = run_between(problem, method, horizon, &truth.changes).ok()?;
    let known = [truth.at(&times).ok()?, truth.at(&truth.changes).ok()?].concat();
    let found = shown.iter().map(|(_, state)| state).chain(&between);
    let error = worst(found.zip(&known).map(|(state, known)| common_distance(known, state)));
    let trial = Trial {
        method: method.name(),
        setting: tolerance,
        steps: run.work.steps,
        error,
        times: times.len(),
        cost: cost(problem, method)(run.work),
        order: None,
    };
    (error <= target).then_some(trial)
}

/// The fewest steps with which a method reaches the target, found by halving and by its order, and its smallest error. None where
/// a run takes more work than `most`.
pub(super) fn search(
    problem: &dyn Problem,
    method: &dyn Method,
    truth: &Truth,
    target: f64,
    most: f64,
) -> (Option<Trial>, f64) {
    let (horizon, cost) = (truth.horizon, cost(problem, method));
    let tried = |steps: u32| Ran::at_ends_of(steps, (problem, method), steps, truth, WORTH * most).ok();
    let mut before = None;
    let mut steps = LEAST;
    let (coarse, found) = loop {
        let now = tried(steps);
        match now {
            Some(found) if found.error <= target => break (before, found),
            _ if steps == MOST || now.as_ref().is_some_and(|ran| cost(ran.work) > most) => {
                return (None, now.map_or(f64::INFINITY, |ran| ran.error));
            }
            _ => (before, steps) = (now, 2 * steps),
        }
    };
    // Twice the steps, for the order and for an error that is known.
    let fine = Ran::at_ends_of(found.steps, (problem, method), 2 * found.steps, truth, f64::INFINITY).ok();
    let Some(fine) = fine else { return (None, found.error) };
    // Of a method that is exact here there is no order to see.
    let order = (found.error > 0.0).then(|| ((found.error / fine.error).log2(), method.order()));
    let nearer = coarse.and_then(|coarse| {
        // Between the two, where the error reaches the target; a multiple of four steps, or of sixteen where that is little more, so
        // that several methods have the same.
        let factor = (coarse.error / target).powf(1.0 / (coarse.error / found.error).log2().max(0.5));
        let steps = f64::from(coarse.steps) * factor;
        let unit = if steps < 64.0 { 4.0 } else { 16.0 };
        let between = (unit * (steps / unit).ceil()) as u32;
        (between < found.steps).then(|| tried(between)).flatten()
    });
    let Ran { steps, error, work } = nearer.filter(|ran| ran.error <= target).unwrap_or(found);
    let trial = Trial {
        method: method.name(),
        setting: horizon / f64::from(steps),
        steps: u64::from(steps),
        error,
        times: truth.steps(steps).len(),
        cost: cost(work),
        order,
    };
    (Some(trial), fine.error.min(error))
}

/// Work in evaluations of f: an equation of the method takes as many as it has stages, a matrix those of its columns that differ.
pub(super) fn cost(problem: &dyn Problem, method: &dyn Method) -> impl Fn(Work) -> f64 + use<> {
    let field = problem.field();
    let columns = match field.structure() {
        Structure::Banded { lower, upper } => lower + upper + 1,
        Structure::Dense => field.dim(),
        // Few colours, or a product at a time.
        _ => 5,
    };
    let stages = f64::from(method.traits().stages);
    move |work| {
        let equations = work.residuals as f64 + columns as f64 * work.factorizations as f64;
        stages * (equations + work.inner as f64)
    }
}
