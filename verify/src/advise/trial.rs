//! Trial runs, and what they cost.

use lsvi::{Structure, Work};

use super::worst;
use crate::measure::norm::{distance, max_norm};
use crate::method::Method;
use crate::problem::Problem;
use crate::run::{RunError, run};

/// A run that reaches the accuracy.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// The method.
    pub method: String,
    /// Its step size, or tolerance.
    pub setting: f64,
    /// Its steps.
    pub steps: u64,
    /// Its largest error.
    pub error: f64,
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

/// The times at which errors are measured, as quarters of the whole.
const QUARTERS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];

/// An accurate solution at the quarters.
pub(super) struct Truth {
    horizon: f64,
    states: Vec<Vec<f64>>,
}

impl Truth {
    /// By an adaptive method.
    pub(super) fn by(problem: &dyn Problem, method: &dyn Method, horizon: f64) -> Result<Self, RunError> {
        let at = |quarter: f64| Ok(run(problem, method, quarter * horizon, quarter * horizon, |_| {})?.end.q);
        Ok(Self { horizon, states: QUARTERS.into_iter().map(at).collect::<Result<_, RunError>>()? })
    }

    /// The largest component, or 1.
    pub(super) fn size(&self) -> f64 {
        worst(self.states.iter().map(|state| max_norm(state))).max(1.0)
    }

    /// Whether it stays within `least` of its start.
    pub(super) fn is_constant(&self, start: &[f64], least: f64) -> bool {
        (0..self.states.len()).all(|quarter| self.error(quarter, start) < least)
    }

    fn error(&self, quarter: usize, state: &[f64]) -> f64 {
        let truth = &self.states[quarter];
        let count = truth.len().min(state.len());
        distance(&state[..count], &truth[..count])
    }
}

/// The largest error at the quarters of a run with steps of `h`, and its work.
fn errors(problem: &dyn Problem, method: &dyn Method, h: f64, truth: &Truth) -> Result<(f64, Work), RunError> {
    let each = (0.25 * truth.horizon / h).round().max(1.0) as usize;
    let (mut step, mut found) = (0, Vec::new());
    let run = run(problem, method, h, truth.horizon, |state| {
        if step > 0 && step % each == 0 && step / each <= QUARTERS.len() {
            found.push(truth.error(step / each - 1, &state.q));
        }
        step += 1;
    })?;
    Ok((worst(found), run.work))
}

/// The run of an adaptive method, if its error at the quarters, at each of which a run ends, is within the target.
pub(super) fn with_tolerance(
    problem: &dyn Problem,
    method: &dyn Method,
    tolerance: f64,
    truth: &Truth,
    target: f64,
) -> Option<Trial> {
    let runs = QUARTERS.map(|quarter| {
        let horizon = quarter * truth.horizon;
        run(problem, method, horizon, horizon, |_| {}).ok()
    });
    let runs = runs.into_iter().collect::<Option<Vec<_>>>()?;
    let error = worst(runs.iter().enumerate().map(|(quarter, run)| truth.error(quarter, &run.end.q)));
    let work = runs.last()?.work;
    let trial = Trial {
        method: method.name(),
        setting: tolerance,
        steps: work.steps,
        error,
        cost: cost(problem, method, work),
        order: None,
    };
    (error <= target).then_some(trial)
}

/// The fewest steps with which a method reaches the target, found by halving and by its order, and its smallest error.
pub(super) fn search(problem: &dyn Problem, method: &dyn Method, truth: &Truth, target: f64) -> (Option<Trial>, f64) {
    let horizon = truth.horizon;
    let tried = |steps: u32| {
        let h = horizon / f64::from(steps);
        errors(problem, method, h, truth).ok().map(|(error, work)| (steps, error, work))
    };
    let mut before = None;
    let mut steps = LEAST;
    let (coarse, found) = loop {
        let now = tried(steps);
        match now {
            Some(found) if found.1 <= target => break (before, found),
            _ if steps == MOST => return (None, now.map_or(f64::INFINITY, |(_, error, _)| error)),
            _ => (before, steps) = (now, 2 * steps),
        }
    };
    // Twice the steps, for the order and for an error that is known.
    let Some(fine) = tried(2 * found.0) else { return (None, found.1) };
    // Of a method that is exact here there is no order to see.
    let order = (found.1 > 0.0).then(|| ((found.1 / fine.1).log2(), method.order()));
    let mut best = found;
    if let Some((few, error, _)) = coarse {
        // Between the two, where the error reaches the target; a multiple of four steps.
        let factor = (error / target).powf(1.0 / (error / found.1).log2().max(0.5));
        let between = 4 * (f64::from(few) * factor / 4.0).ceil() as u32;
        let nearer = (between < found.0).then(|| tried(between)).flatten();
        best = nearer.filter(|(_, error, _)| *error <= target).unwrap_or(found);
    }
    let (steps, error, work) = best;
    let trial = Trial {
        method: method.name(),
        setting: horizon / f64::from(steps),
        steps: u64::from(steps),
        error,
        cost: cost(problem, method, work),
        order,
    };
    (Some(trial), fine.1.min(error))
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
