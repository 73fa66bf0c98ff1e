//! One run of one method on one problem.

use std::ops::ControlFlow;

use lsvi::{InputError, State, StepError, Trajectory};

use crate::method::{BuildError, Method};
use crate::problem::Problem;

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

/// Integrates `problem` by `method` with steps of `h` from 0 to `t_end`, shows every state to `observe`, the initial one
/// first, and returns the last.
///
/// # Errors
/// [`RunError`]; what has been observed until then stands.
pub fn run(
    problem: &dyn Problem,
    method: &dyn Method,
    h: f64,
    t_end: f64,
    mut observe: impl FnMut(&State),
) -> Result<State, RunError> {
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
) -> Result<State, RunError> {
    let initial = State::new(0.0, problem.initial());
    let mut trajectory = Trajectory::new(method.build(problem)?, initial, h, t_end)?;
    let mut flow = observe(trajectory.state());
    while flow.is_continue()
        && let Some(state) = trajectory.step()?
    {
        if state.q.iter().any(|x| !x.is_finite()) {
            return Err(RunError::NonFinite(state.t));
        }
        flow = observe(state);
    }
    Ok(trajectory.state().clone())
}

/// Largest absolute difference of two states over the components that both have; NaN if any of them is NaN.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, |m: f64, d| if d.is_nan() { d } else { m.max(d) })
}

/// Largest absolute component; NaN if any component is NaN.
pub fn max_norm(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |m: f64, x| if x.is_nan() { *x } else { m.max(x.abs()) })
}
