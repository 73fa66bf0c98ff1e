//! Trial runs, and what they cost.

use lsvi::{Structure, Work};

use super::worst;
use crate::measure::norm::{distance, max_norm};
use crate::method::Method;
use crate::problem::Problem;
use crate::run::{RunError, run, run_through};

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
    /// The number of these times, sixteen where the steps allow it: of an adaptive method the ends of its steps next to them.
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

/// Errors are measured at the sixteenths of the whole, so far as steps end there.
pub(super) const TIMES: usize = 16;

/// An accurate solution at the sixteenths.
pub(super) struct Truth {
    horizon: f64,
    states: Vec<Vec<f64>>,
}

impl Truth {
    /// By an adaptive method.
    pub(super) fn by(problem: &dyn Problem, method: &dyn Method, horizon: f64) -> Result<Self, RunError> {
        Ok(Self { horizon, states: run_through(problem, method, &sixteenths(horizon))? })
    }

    /// The largest component, or 1.
    pub(super) fn size(&self) -> f64 {
        worst(self.states.iter().map(|state| max_norm(state))).max(1.0)
    }

    /// Whether it stays within `least` of its start.
    pub(super) fn is_constant(&self, start: &[f64], least: f64) -> bool {
        (0..self.states.len()).all(|k| self.error(k, start) < least)
    }

    /// The error of a state at the k-th of the times.
    fn error(&self, k: usize, state: &[f64]) -> f64 {
        let truth = &self.states[k];
        let count = truth.len().min(state.len());
        distance(&state[..count], &truth[..count])
    }
}

pub(super) fn sixteenths(horizon: f64) -> Vec<f64> {
    (1..=TIMES).map(|k| horizon * k as f64 / TIMES as f64).collect()
}

/// A run with a number of steps: its errors at the times where a step ends, and its work.
struct Ran {
    steps: u32,
    /// Its errors at the times by their number.
    errors: Vec<(usize, f64)>,
    error: f64,
    work: Work,
}

impl Ran {
    fn new(problem: &dyn Problem, method: &dyn Method, steps: u32, truth: &Truth) -> Result<Self, RunError> {
        let (mut step, mut errors) = (0, Vec::new());
        let run = run(problem, method, truth.horizon / f64::from(steps), truth.horizon, |state| {
            // Step n ends at the time k with k/16 = n/N.
            let (k, rest) = (step * TIMES / steps as usize, step * TIMES % steps as usize);
            if rest == 0 && (1..=TIMES).contains(&k) {
                errors.push((k, truth.error(k - 1, &state.q)));
            }
            step += 1;
        })?;
        let error = worst(errors.iter().map(|(_, error)| *error));
        Ok(Self { steps, errors, error, work: run.work })
    }

    /// The largest error at the times of `other`.
    fn error_at_times_of(&self, other: &Self) -> f64 {
        let is_shared = |k: usize| other.errors.iter().any(|(other, _)| *other == k);
        worst(self.errors.iter().filter(|(k, _)| is_shared(*k)).map(|(_, error)| *error))
    }
}

/// The run of an adaptive method, if its error is within the target where its steps first pass the times. They are its own steps,
/// those of a run that a user makes; `accurate` follows the solution to where they end.
pub(super) fn with_tolerance(
    problem: &dyn Problem,
    method: &dyn Method,
    tolerance: f64,
    (accurate, horizon): (&dyn Method, f64),
    target: f64,
) -> Option<Trial> {
    let times = sixteenths(horizon);
    let mut passed = Vec::new();
    let mut next = 0;
    let run = run(problem, method, horizon, horizon, |state| {
        let behind = times[next..].iter().take_while(|t| **t <= state.t).count();
        next += behind;
        if behind > 0 {
            passed.push((state.t, state.q.clone()));
        }
    })
    .ok()?;
    let ends: Vec<f64> = passed.iter().map(|(t, _)| *t).collect();
    let truth = Truth { horizon, states: run_through(problem, accurate, &ends).ok()? };
    let error = worst(passed.iter().enumerate().map(|(k, (_, state))| truth.error(k, state)));
    let trial = Trial {
        method: method.name(),
        setting: tolerance,
        steps: run.work.steps,
        error,
        times: ends.len(),
        cost: cost(problem, method, run.work),
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
    let horizon = truth.horizon;
    let tried = |steps: u32| Ran::new(problem, method, steps, truth).ok();
    let mut before = None;
    let mut steps = LEAST;
    let (coarse, found) = loop {
        let now = tried(steps);
        match now {
            Some(found) if found.error <= target => break (before, found),
            _ if steps == MOST || now.as_ref().is_some_and(|ran| cost(problem, method, ran.work) > most) => {
                return (None, now.map_or(f64::INFINITY, |ran| ran.error));
            }
            _ => (before, steps) = (now, 2 * steps),
        }
    };
    // Twice the steps, for the order and for an error that is known.
    let Some(fine) = tried(2 * found.steps) else { return (None, found.error) };
    // Of a method that is exact here there is no order to see.
    let order = (found.error > 0.0).then(|| ((found.error / fine.error_at_times_of(&found)).log2(), method.order()));
    let nearer = coarse.and_then(|coarse| {
        // Between the two, where the error reaches the target; a multiple of four steps, or of sixteen where that is little more.
        let factor = (coarse.error / target).powf(1.0 / (coarse.error / found.error).log2().max(0.5));
        let steps = f64::from(coarse.steps) * factor;
        let unit = if steps < 64.0 { 4.0 } else { TIMES as f64 };
        let between = (unit * (steps / unit).ceil()) as u32;
        (between < found.steps).then(|| tried(between)).flatten()
    });
    let Ran { steps, errors, error, work } = nearer.filter(|ran| ran.error <= target).unwrap_or(found);
    let trial = Trial {
        method: method.name(),
        setting: horizon / f64::from(steps),
        steps: u64::from(steps),
        error,
        times: errors.len(),
        cost: cost(problem, method, work),
        order,
    };
    (Some(trial), fine.error.min(error))
}

/// Work in evaluations of f: an equation of the method takes as many as it has stages, a matrix those of its columns that differ.
pub(super) fn cost(problem: &dyn Problem, method: &dyn Method, work: Work) -> f64 {
    let field = problem.field();
    let columns = match field.structure() {
        Structure::Banded { lower, upper } => lower + upper + 1,
        Structure::Dense => field.dim(),
        // Few colours, or a product at a time.
        _ => 5,
    };
    let equations = work.residuals as f64 + columns as f64 * work.factorizations as f64;
    f64::from(method.traits().stages) * (equations + work.inner as f64)
}
