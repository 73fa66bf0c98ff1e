//! Runs whose states are kept.

use super::{Context, Experiment, StudyError};
use crate::measure::norm::{distance, larger};
use crate::method::{self, Method};
use crate::problem;
use crate::run::{RunError, run};

/// A run.
#[derive(Debug, Clone)]
pub struct Motion {
    /// The problem with its parameters: `kepler eccentricity=0.3`.
    pub problem: &'static str,
    /// The method.
    pub method: String,
    /// The step size.
    pub h: f64,
    /// The end.
    pub t_end: f64,
}

/// Its states.
#[derive(Debug)]
pub struct States {
    /// Times and states, the initial one first, up to the first that fails or is not finite.
    pub states: Vec<(f64, Vec<f64>)>,
    /// The changes of every invariant since the beginning, by its name.
    pub changes: Vec<(&'static str, Vec<f64>)>,
    /// Whether the end was reached.
    pub is_complete: bool,
}

impl States {
    /// Largest |change| of an invariant over the times in (`from`, `to`]; infinite if the run broke off, NaN if there is no
    /// such invariant.
    pub fn largest_change(&self, invariant: &str, from: f64, to: f64) -> f64 {
        let Some((_, changes)) = self.changes.iter().find(|(name, _)| *name == invariant) else { return f64::NAN };
        if !self.is_complete {
            return f64::INFINITY;
        }
        // Times are multiples of the step size, rounded.
        let is_after = |t: f64, end: f64| t > end * (1.0 + 4.0 * f64::EPSILON);
        let within = self.states.iter().zip(changes).filter(|((t, _), _)| is_after(*t, from) && !is_after(*t, to));
        within.map(|(_, change)| change.abs()).fold(0.0, larger)
    }
}

impl Experiment for Motion {
    const ID: &'static str = "motion";
    type Found = States;

    fn measure(&self, _: &Context) -> Result<States, StudyError> {
        let problem = problem::build_setting(self.problem)?;
        let mut states = Vec::new();
        let outcome = run(&*problem, &*method::parse(&self.method)?, self.h, self.t_end, |state| {
            states.push((state.t, state.q.clone()));
        });
        let is_complete = match outcome {
            Ok(_) => true,
            Err(RunError::Step(_) | RunError::NonFinite(_)) => false,
            Err(error) => return Err(error.into()),
        };
        let start = problem.initial();
        let changes = problem.invariants().into_iter().map(|invariant| {
            let start = invariant.value(&start);
            (invariant.name, states.iter().map(|(_, state)| invariant.value(state) - start).collect())
        });
        let changes = changes.collect();
        Ok(States { states, changes, is_complete })
    }
}

/// The largest error of a coordinate in a run on a problem of mechanics; infinite if it breaks off.
#[derive(Debug)]
pub struct LargestError(pub Motion);

impl Experiment for LargestError {
    const ID: &'static str = "largest-error";
    type Found = f64;

    fn measure(&self, context: &Context) -> Result<f64, StudyError> {
        let found = context.get(self.0.clone())?;
        if !found.is_complete {
            return Ok(f64::INFINITY);
        }
        let problem = problem::build_setting(self.0.problem)?;
        found.states.iter().try_fold(0.0_f64, |worst, (t, state)| {
            let exact = problem.exact(*t).ok_or("no exact solution is known")?;
            let n = state.len() / 2;
            Ok(larger(worst, distance(&state[..n], &exact[..n])))
        })
    }
}

/// How far two methods that ought to be one in different coordinates are apart.
#[derive(Debug)]
pub struct Difference {
    /// The problem with its parameters.
    pub problem: &'static str,
    /// One method.
    pub one: String,
    /// The other.
    pub other: String,
    /// The step size.
    pub h: f64,
    /// Steps of either.
    pub steps: u64,
}

/// What is found of it.
#[derive(Debug)]
pub struct Apart {
    /// Largest distance of two states.
    pub largest: f64,
    /// What the roundings of numbers up to 2 add up to, independent in each step: four deviations. Those of N steps, Λ/h in the
    /// momentum each, are √N of that in the momentum and N^{3/2} Λ in the position.
    pub rounding: f64,
}

impl Experiment for Difference {
    const ID: &'static str = "difference";
    type Found = Apart;

    fn measure(&self, context: &Context) -> Result<Apart, StudyError> {
        context.announce(1);
        let problem = problem::build_setting(self.problem)?;
        let (one, other) = (method::parse(&self.one)?, method::parse(&self.other)?);
        let t_end = self.h * self.steps as f64;
        let mut states = Vec::new();
        run(&*problem, &*one, self.h, t_end, |state| states.push(state.q.clone()))?;
        let mut largest = 0.0;
        let mut rest = states.iter();
        run(&*problem, &*other, self.h, t_end, |state| {
            largest = larger(largest, rest.next().map_or(f64::NAN, |known| distance(known, &state.q)));
        })?;
        if rest.next().is_some() {
            return Err("the two took different steps".into());
        }
        let steps = self.steps as f64;
        let of = |method: &dyn Method| method.momentum_roundoff(steps) * (1.0 + 1.0 / (steps * self.h));
        let rounding = 2.0 * f64::EPSILON * (of(&*one) + of(&*other));
        context.tick();
        Ok(Apart { largest, rounding })
    }
}
