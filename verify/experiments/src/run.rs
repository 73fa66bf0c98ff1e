//! One run of one method on one problem: the only way to step a method.

mod passed_over;

use std::ops::ControlFlow;
use std::time::Instant;

use lsvi::{InputError, SolveError, State, StepError, Trajectory, Work};

use crate::method::{BuildError, Method};
use crate::problem::Problem;

pub use passed_over::passed_over;

/// What a run leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The last state.
    pub end: State,
    /// The work of all steps.
    pub work: Work,
    /// The time that the steps took, with what was done to observe them.
    pub seconds: f64,
}

/// Why a run gave no trajectory, or only part of one.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The method does not apply.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The step size or the end time is unusable.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A step failed, with its time in the message.
    #[error(transparent)]
    Step(#[from] StepError),
    /// The observer stopped the run: a result is not a number.
    #[error("the state is not finite at t = {0}")]
    NonFinite(f64),
}

impl RunError {
    /// What stands where the run would have a number: infinity if the equation of a step has no solution on the branch of its state, or
    /// determines none, or if the states grow beyond all numbers, for that is what the method does there; NaN, which decides nothing, if the run
    /// broke off for any other reason, in the solver or in what it was given.
    #[must_use]
    pub fn in_place_of_a_number(&self) -> f64 {
        match self {
            Self::Step(StepError::Solve { source: SolveError::BranchLost { .. } | SolveError::Singular, .. })
            | Self::NonFinite(_) => f64::INFINITY,
            _ => f64::NAN,
        }
    }
}

/// Integrates `problem` by `method` with steps of `h` from 0 to `t_end`, and shows every state to `observe`, the initial one
/// first.
///
/// # Errors
/// [`RunError`]; what has been observed until then stands.
pub fn run(
    problem: &dyn Problem,
    method: &dyn Method,
    h: f64,
    t_end: f64,
    mut observe: impl FnMut(&State),
) -> Result<Run, RunError> {
    run_while(problem, method, h, t_end, |state| {
        observe(state);
        ControlFlow::Continue(())
    })
}

/// The same, but ends early, without error, once `observe` breaks.
///
/// # Errors
/// As for [`run`].
pub fn run_while(
    problem: &dyn Problem,
    method: &dyn Method,
    h: f64,
    t_end: f64,
    mut observe: impl FnMut(&State) -> ControlFlow<()>,
) -> Result<Run, RunError> {
    run_from(problem, problem.initial(), method, h, t_end, |state, _| observe(state))
}

/// The same from another `start` than the problem's own; `observe` sees the work of all steps until then, too.
///
/// # Errors
/// As for [`run`].
pub fn run_from(
    problem: &dyn Problem,
    start: Vec<f64>,
    method: &dyn Method,
    h: f64,
    t_end: f64,
    mut observe: impl FnMut(&State, Work) -> ControlFlow<()>,
) -> Result<Run, RunError> {
    let mut trajectory = Trajectory::new(method.build(problem)?, State::new(0.0, start), h, t_end)?;
    let begun = Instant::now();
    let mut flow = observe(trajectory.state(), Work::default());
    while flow.is_continue()
        && let Some(state) = trajectory.step()?
    {
        if state.q.iter().any(|x| !x.is_finite()) {
            return Err(RunError::NonFinite(state.t));
        }
        flow = observe(trajectory.state(), trajectory.work());
    }
    Ok(Run { end: trajectory.state().clone(), work: trajectory.work(), seconds: begun.elapsed().as_secs_f64() })
}

/// The states at `times`, increasing and positive, each reached from the one before with steps that the method chooses, or in one.
///
/// # Errors
/// As for [`run`].
pub fn run_through(problem: &dyn Problem, method: &dyn Method, times: &[f64]) -> Result<Vec<Vec<f64>>, RunError> {
    run_through_from(problem, problem.initial(), method, times)
}

/// The states at `times`, increasing and within the run, between the steps of `h` at most that the method takes to `t_end` of its own.
///
/// # Errors
/// As for [`run`].
pub fn run_between(
    problem: &dyn Problem,
    method: &dyn Method,
    [h, t_end]: [f64; 2],
    times: &[f64],
) -> Result<Vec<Vec<f64>>, RunError> {
    let start = State::new(0.0, problem.initial());
    let mut trajectory = Trajectory::new(method.build(problem)?, start, h, t_end)?;
    let at = |t: &f64| {
        while trajectory.state().t < *t && trajectory.step()?.is_some() {}
        let mut between = vec![0.0; trajectory.state().q.len()];
        trajectory.interpolate(*t, &mut between)?;
        Ok(between)
    };
    times.iter().map(at).collect()
}

/// As [`run_through`], from another `start` than the problem's own.
///
/// # Errors
/// As for [`run`].
pub fn run_through_from(
    problem: &dyn Problem,
    start: Vec<f64>,
    method: &dyn Method,
    times: &[f64],
) -> Result<Vec<Vec<f64>>, RunError> {
    let Some(&first) = times.first() else { return Ok(Vec::new()) };
    let mut trajectory = Trajectory::new(method.build(problem)?, State::new(0.0, start), first, first)?;
    let reach = |t: &f64| {
        trajectory.resume(t - trajectory.state().t, *t)?;
        while trajectory.step()?.is_some() {}
        let state = &trajectory.state().q;
        if state.iter().all(|x| x.is_finite()) { Ok(state.clone()) } else { Err(RunError::NonFinite(*t)) }
    };
    times.iter().map(reach).collect()
}

/// Whether steps of `h` lead from a state, at its time, to `t_end`.
#[must_use]
pub fn leads_to(problem: &dyn Problem, method: &dyn Method, start: State, h: f64, t_end: f64) -> bool {
    let Ok(mut trajectory) =
        method.build(problem).map_err(RunError::from).and_then(|it| Ok(Trajectory::new(it, start, h, t_end)?))
    else {
        return false;
    };
    loop {
        match trajectory.step() {
            Ok(Some(state)) if state.q.iter().all(|x| x.is_finite()) => {}
            Ok(None) => return true,
            _ => return false,
        }
    }
}

/// One step of `h` from `start`.
///
/// # Errors
/// As for [`run`].
pub fn step_from(problem: &dyn Problem, start: Vec<f64>, method: &dyn Method, h: f64) -> Result<Vec<f64>, RunError> {
    Ok(run_from(problem, start, method, h, h, |_, _| ControlFlow::Continue(()))?.end.q)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// v̇ = v² of 10²⁰⁰ is beyond all numbers.
    #[test]
    fn a_run_that_has_no_finite_state_leads_nowhere() {
        let drag = crate::problem::build("quadratic-drag", &[("lambda".into(), "-1".into())]).expect("known");
        let rk4 = crate::method::parse("rk4").expect("known");
        let leads = |v: f64| leads_to(&*drag, &*rk4, State::new(0.0, vec![v]), 0.1, 0.2);
        assert_eq!([0.1, 1e200].map(leads), [true, false]);
    }
}
