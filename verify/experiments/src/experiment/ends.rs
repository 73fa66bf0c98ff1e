//! Where runs end, and with which error.

use lsvi::StepError;

use super::{Context, Experiment, StudyError};
use crate::measure::norm::distance;
use crate::measure::order::{Sample, ladder};
use crate::method;
use crate::problem::{self, Problem};
use crate::run::{RunError, run};

/// A run on a problem with one component.
#[derive(Debug)]
pub struct End {
    /// The problem with its parameters.
    pub problem: String,
    /// Name of the method.
    pub method: String,
    /// Step size.
    pub h: f64,
    /// Number of steps.
    pub steps: u32,
}

impl Experiment for End {
    const ID: &'static str = "end";
    /// The state after the last step; NaN, which no check takes for a number, where a step has no solution.
    type Found = f64;

    fn measure(&self, _: &Context) -> Result<f64, StudyError> {
        let problem = problem::build_setting(&self.problem)?;
        match run(&*problem, &*method::parse(&self.method)?, self.h, f64::from(self.steps) * self.h, |_| {}) {
            Ok(run) => Ok(run.end.q[0]),
            Err(RunError::Step(StepError::Solve { .. })) => Ok(f64::NAN),
            Err(error) => Err(error.into()),
        }
    }
}

/// A run to the horizon of its problem.
#[derive(Debug)]
pub struct HorizonError {
    /// Name of the problem.
    pub problem: &'static str,
    /// Name of the method.
    pub method: &'static str,
    /// Step size.
    pub h: f64,
}

/// How it ended.
#[derive(Debug)]
pub struct Ended {
    /// End of the run.
    pub horizon: f64,
    /// Largest error over the components at the horizon, or the time from which there is no step.
    pub error: Result<f64, f64>,
}

impl Experiment for HorizonError {
    const ID: &'static str = "horizon-error";
    type Found = Ended;

    fn measure(&self, _: &Context) -> Result<Ended, StudyError> {
        let problem = problem::build(self.problem, &[])?;
        let horizon = problem.facts().window.horizon;
        let error = match run(&*problem, &*method::parse(self.method)?, self.h, horizon, |_| {}) {
            Ok(run) => Ok(distance(&run.end.q, &truth(&*problem, horizon)?)),
            Err(RunError::Step(StepError::Solve { t, .. })) => Err(t),
            Err(error) => return Err(error.into()),
        };
        Ok(Ended { horizon, error })
    }
}

/// The solution at t, exact or by a method of high order.
fn truth(problem: &dyn Problem, t: f64) -> Result<Vec<f64>, StudyError> {
    if let Some(exact) = problem.exact(t).or_else(|| problem.tabulated(t)) {
        return Ok(exact);
    }
    // Errors of h = 0.01 and more are compared; those of RK4 with h = 1e-4 are 1e-12 of them.
    Ok(run(problem, &*method::parse("rk4")?, 1e-4, t, |_| {})?.end.q)
}

/// Errors at t = 2 on v̇ = −v for steps from 0.2 down.
#[derive(Debug)]
pub struct DragErrors {
    /// Name of the method.
    pub method: &'static str,
}

impl Experiment for DragErrors {
    const ID: &'static str = "drag-errors";
    type Found = Vec<Sample>;

    fn measure(&self, _: &Context) -> Result<Vec<Sample>, StudyError> {
        let t_end = 2.0;
        let problem = problem::build("linear-drag", &[])?;
        let exact = problem.exact(t_end).ok_or("linear drag has an exact solution")?;
        let method = method::parse(self.method)?;
        let sample = |h: f64| match run(&*problem, &*method, h, t_end, |_| {}) {
            Ok(run) => Sample::new(h, distance(&run.end.q, &exact), f64::EPSILON * t_end / h),
            Err(error) => Sample::failed(h, error.to_string()),
        };
        Ok(ladder(t_end, 0.2, std::f64::consts::SQRT_2, 9).into_iter().map(sample).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_ends_at_its_last_step_and_a_lost_one_nowhere() {
        let end = |v0: f64, steps| {
            let problem = format!("quadratic-drag v0={v0}");
            *Context::silent().get(End { problem, method: "implicit-euler".into(), h: 1.0, steps }).expect("it runs")
        };
        // x + x² = 2 has the root 1, and x + x² = 1 the golden section.
        assert!((end(2.0, 1) - 1.0).abs() < 1e-15 && (end(2.0, 2) - 0.5 * (5.0_f64.sqrt() - 1.0)).abs() < 1e-15);
        assert!(end(-1.0, 1).is_nan(), "x + x² = −1 has no root");
    }

    #[test]
    fn a_run_that_loses_its_branch_says_when() {
        let ended = Context::silent().get(HorizonError { problem: "van-der-pol", method: "fitted(1)", h: 0.01 });
        let ended = ended.expect("known");
        assert!(ended.error.expect_err("the branch ends") < ended.horizon, "{ended:?}");
    }

    #[test]
    fn the_error_at_the_horizon_is_that_of_the_closed_form() {
        let ended = Context::silent().get(HorizonError { problem: "linear-drag", method: "trapezoidal", h: 0.1 });
        let ended = ended.expect("it runs");
        let steps = (ended.horizon / 0.1).round();
        let expected = ((0.95_f64 / 1.05).powf(steps) - (-ended.horizon).exp()).abs();
        assert!((ended.error.expect("linear") - expected).abs() < 1e-14 * steps);
    }
}
