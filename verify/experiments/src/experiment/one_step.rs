//! One step of a method on a problem with one component.

use super::{Context, Experiment, ExperimentError, StudyError};
use crate::measure::search::{logarithmic, try_intervals};
use crate::method;
use crate::problem;
use crate::run::{RunError, run};

/// One step from the initial state.
#[derive(Debug, Clone, PartialEq)]
pub struct OneStep {
    /// The problem with its parameters.
    pub problem: &'static str,
    /// The method.
    pub method: String,
    /// The step size.
    pub h: f64,
}

impl OneStep {
    /// On v̇ = −v from 1: the growth factor R(h).
    pub fn growth(method: impl Into<String>, h: f64) -> Self {
        Self { problem: "linear-drag", method: method.into(), h }
    }

    /// On v̇ = −v² from 1.
    pub fn on_quadratic_drag(method: impl Into<String>, h: f64) -> Self {
        Self { problem: "quadratic-drag", ..Self::growth(method, h) }
    }

    /// The state after the step; where there is none, [`RunError::in_place_of_a_number`].
    ///
    /// # Errors
    /// If there is no such problem or method.
    pub fn or_infinity(self, context: &Context) -> Result<f64, ExperimentError> {
        Ok(Result::clone(&*context.get(self)?).unwrap_or_else(|error| error.in_place_of_a_number()))
    }
}

impl Experiment for OneStep {
    const ID: &'static str = "one-step";
    /// The state after it, or why there is none.
    type Found = Result<f64, RunError>;

    fn measure(&self, _: &Context) -> Result<Self::Found, StudyError> {
        let problem = problem::build_setting(self.problem)?;
        Ok(run(&*problem, &*method::parse(&self.method)?, self.h, self.h, |_| {}).map(|run| run.end.q[0]))
    }
}

/// The step size between `low` and `high` at which the result of a step leaves the interval from `least` to `most`, or has no
/// solution any more. Of the sizes that are looked at, a hundred in each decade, all smaller ones stay inside and no larger one does.
#[derive(Debug)]
pub struct LeavesAt {
    /// The step; its size is not used.
    pub step: OneStep,
    /// Least result.
    pub least: f64,
    /// Largest result.
    pub most: f64,
    /// Smallest step size.
    pub low: f64,
    /// Largest step size.
    pub high: f64,
}

impl LeavesAt {
    /// Where |R(h)| passes 1.
    pub fn unit_circle(method: &str, low: f64, high: f64) -> Self {
        Self { step: OneStep::growth(method, low), least: -1.0, most: 1.0, low, high }
    }
}

impl Experiment for LeavesAt {
    const ID: &'static str = "leaves-at";
    type Found = f64;

    fn measure(&self, context: &Context) -> Result<f64, StudyError> {
        let points = logarithmic([self.low, self.high], 100);
        let inside = try_intervals(&points, |h| -> Result<bool, StudyError> {
            let v = OneStep { h, ..self.step.clone() }.measure(context)?;
            let v = v.unwrap_or_else(|error| error.in_place_of_a_number());
            if v.is_nan() { Err("the step does not tell".into()) } else { Ok((self.least..=self.most).contains(&v)) }
        })?;
        match inside[..] {
            [[from, to]] if from == self.low && to < self.high => Ok(to),
            _ => Err(format!("{} does not leave once between {} and {}", self.step.method, self.low, self.high).into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_the_closed_form() {
        let context = Context::silent();
        // A handful of roundings on numbers of order 1.
        for (method, factor) in [("method-i", 1.0 / 1.625), ("method-ii", 0.75 / 1.25)] {
            let live = OneStep::growth(method, 0.5).or_infinity(&context).expect("linear");
            assert!((live - factor).abs() < 8.0 * f64::EPSILON, "{method}: {live} and {factor}");
        }
    }

    #[test]
    fn the_end_of_a_branch_is_found() {
        let context = Context::silent();
        let at = |step: OneStep| context.get(LeavesAt { step, least: -1.0, most: 1.0, low: 1.0, high: 4.0 });
        // 1 − h + h²/2 = 1 at h = 2.
        let end = at(OneStep::growth("explicit-momentum", 1.0)).expect("leaves");
        assert!((*end - 2.0).abs() < 1e-11, "{end}");
        assert!(at(OneStep::growth("method-i", 1.0)).is_err());
    }
}
