//! Runs whose states are kept.

use lsvi::TwoStep;

use super::errors::Ahead;
use super::step_map::discretise;
use super::{Context, Experiment, StudyError};
use crate::measure::norm::{distance, larger};
use crate::measure::search::{logarithmic, try_intervals};
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
    /// Why the end was not reached.
    pub broke_off: Option<RunError>,
}

impl States {
    /// Largest |change| of an invariant over the times in (`from`, `to`]; [`RunError::in_place_of_a_number`] if the run
    /// broke off, NaN if there is no such invariant.
    pub fn largest_change(&self, invariant: &str, from: f64, to: f64) -> f64 {
        let Some((_, changes)) = self.changes.iter().find(|(name, _)| *name == invariant) else { return f64::NAN };
        if let Some(error) = &self.broke_off {
            return error.in_place_of_a_number();
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
        let broke_off = match outcome {
            Ok(_) => None,
            Err(error @ (RunError::Step(_) | RunError::NonFinite(_))) => Some(error),
            Err(error) => return Err(error.into()),
        };
        let start = problem.initial();
        let changes = problem.invariants().into_iter().map(|invariant| {
            let start = invariant.value(&start);
            (invariant.name, states.iter().map(|(_, state)| invariant.value(state) - start).collect())
        });
        let changes = changes.collect();
        Ok(States { states, changes, broke_off })
    }
}

/// The largest error of a coordinate in a run on a problem of mechanics; [`RunError::in_place_of_a_number`] if it breaks off.
#[derive(Debug)]
pub struct LargestError(pub Motion);

impl Experiment for LargestError {
    const ID: &'static str = "largest-error";
    type Found = f64;

    fn measure(&self, context: &Context) -> Result<f64, StudyError> {
        largest_error(self.0.problem, &*context.get(self.0.clone())?)
    }
}

fn largest_error(problem: &str, found: &States) -> Result<f64, StudyError> {
    if let Some(error) = &found.broke_off {
        return Ok(error.in_place_of_a_number());
    }
    let problem = problem::build_setting(problem)?;
    found.states.iter().try_fold(0.0_f64, |worst, (t, state)| {
        let exact = problem.exact(*t).ok_or("no exact solution is known")?;
        let n = state.len() / 2;
        Ok(larger(worst, distance(&state[..n], &exact[..n])))
    })
}

/// The step sizes at which the largest error of a coordinate up to `t_end`, in whole steps, is smaller than that of another method:
/// scanned as by [`errors::Ahead`](super::errors::Ahead).
#[derive(Debug)]
pub struct AheadInMotion {
    /// The problem with its parameters.
    pub problem: &'static str,
    /// The method.
    pub method: &'static str,
    /// The other method.
    pub rival: &'static str,
    /// The end.
    pub t_end: f64,
    /// Smallest and largest step size.
    pub between: [f64; 2],
}

impl AheadInMotion {
    /// The time of the last whole step up to `t_end`.
    pub fn whole_steps(h: f64, t_end: f64) -> f64 {
        h * (t_end / h + 1e-9).floor()
    }
}

impl Experiment for AheadInMotion {
    const ID: &'static str = "ahead-in-motion";
    /// Intervals, in ascending order.
    type Found = Vec<[f64; 2]>;

    fn measure(&self, context: &Context) -> Result<Vec<[f64; 2]>, StudyError> {
        context.announce(1);
        let Self { problem, method, rival, t_end, between } = *self;
        // Not kept: nobody else will ask for these step sizes.
        let largest = |method: &str, h: f64| -> Result<f64, StudyError> {
            let t_end = Self::whole_steps(h, t_end);
            let found = Motion { problem, method: method.into(), h, t_end }.measure(context)?;
            largest_error(problem, &found)
        };
        let found = try_intervals(&logarithmic(between, Ahead::SCAN), |h| {
            let [own, theirs] = [largest(method, h)?, largest(rival, h)?];
            if own.is_nan() || theirs.is_nan() {
                return Err(StudyError::from(format!("the runs with h = {h} on {problem} do not tell")));
            }
            Ok(own < theirs)
        })?;
        context.tick();
        Ok(found)
    }
}

/// The error of one step of the two-step form x₀, x₁ → x₂, from exact positions at `t` and `t` + h: the Euclidean distance of x₂.
#[derive(Debug)]
pub struct LocalError {
    /// The problem with its parameters.
    pub problem: &'static str,
    /// The method.
    pub method: &'static str,
    /// The step size.
    pub h: f64,
    /// The time of x₀.
    pub t: f64,
}

impl Experiment for LocalError {
    const ID: &'static str = "local-error";
    type Found = f64;

    fn measure(&self, _: &Context) -> Result<f64, StudyError> {
        let Self { problem, method, h, t } = *self;
        let problem = problem::build_setting(problem)?;
        let exact = |t: f64| -> Result<Vec<f64>, StudyError> {
            let mut state = problem.exact(t).ok_or("no exact solution is known")?;
            state.truncate(state.len() / 2);
            Ok(state)
        };
        let (mut before, mut now, wanted) = (exact(t)?, exact(t + h)?, exact(t + 2.0 * h)?);
        let mut live = TwoStep::new(discretise(&*method::parse(method)?, &*problem)?);
        live.step(t + h, h, &mut before, &mut now)?;
        Ok(now.iter().zip(&wanted).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::BuildError;

    /// Though it was exact as far as it went.
    #[test]
    fn a_run_that_broke_off_has_no_error_that_a_rival_could_be_behind() {
        let start = problem::build_setting("harmonic-oscillator").expect("known").initial();
        let error = |broke_off: Option<RunError>| {
            let states = States { states: vec![(0.0, start.clone())], changes: Vec::new(), broke_off };
            largest_error("harmonic-oscillator", &states).expect("known")
        };
        assert_eq!(error(None), 0.0);
        assert_eq!(error(Some(RunError::NonFinite(1.0))), f64::INFINITY);
        let other = BuildError { method: "none".into(), reason: "none".into() };
        assert!(error(Some(RunError::Build(other))).is_nan());
    }
}
