//! Methods that choose their steps.

use lsvi::Integrator;
use lsvi::adaptive::{Options, Radau, Tolerances};

use super::{Build, BuildError, Method, Spec, Traits};
use crate::kinds::{Principle, Stability};
use crate::problem::Problem;

pub(super) const RADAU: Spec = Spec {
    form: "radau-adaptive",
    summary: "Radau IIA with adaptive steps and order 5, 9 or 13, L-stable; --rtol, --atol, and --h as the longest step",
    build: Build::Plain(|| Box::new(RadauMethod { tolerances: None, most_steps: MOST_STEPS })),
    examples: &["radau-adaptive"],
};

/// Relative and absolute tolerance where none are given.
pub const DEFAULT_RTOL: f64 = 1e-6;
/// See [`DEFAULT_RTOL`].
pub const DEFAULT_ATOL: f64 = 1e-9;

/// Steps that are tried where no other limit is given: seconds of a small system. Along a jump of f that the solution cannot leave, as of a
/// thermostat, they would be as many as there are times to double precision.
pub const MOST_STEPS: u64 = 1_000_000;

#[derive(Debug)]
struct RadauMethod {
    tolerances: Option<Tolerances>,
    most_steps: u64,
}

impl RadauMethod {
    fn tolerances(&self) -> Result<Tolerances, lsvi::InputError> {
        self.tolerances.clone().map_or_else(|| Tolerances::new(DEFAULT_RTOL, DEFAULT_ATOL), Ok)
    }
}

impl Method for RadauMethod {
    fn name(&self) -> String {
        "radau-adaptive".into()
    }

    fn traits(&self) -> Traits {
        let traits = Traits::new(5, Principle::Equation, Stability::Damping);
        // Of the three stages of order 5, its lowest.
        Traits { stiff_order: None, is_adaptive: true, highest_order: Some(13), stages: 3, ..traits }
    }

    fn with_tolerances(&self, tolerances: Tolerances) -> Option<Box<dyn Method>> {
        Some(Box::new(Self { tolerances: Some(tolerances), ..*self }))
    }

    fn tightened(&self, factor: f64) -> Option<Box<dyn Method>> {
        Some(Box::new(Self { tolerances: Some(self.tolerances().ok()?.tightened(factor)), ..*self }))
    }

    fn limited(&self, steps: u64) -> Option<Box<dyn Method>> {
        Some(Box::new(Self { tolerances: self.tolerances.clone(), most_steps: steps }))
    }

    fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
        let unfit = |error: lsvi::InputError| BuildError { method: self.name(), reason: error.to_string() };
        let tolerances = self.tolerances().map_err(unfit)?;
        let options = Options::from(tolerances).max_steps(self.most_steps).map_err(unfit)?;
        Ok(Box::new(Radau::new(problem.field(), options).map_err(unfit)?))
    }
}

#[cfg(test)]
mod tests {
    use crate::method;
    use crate::problem;
    use crate::run::run;

    /// A limit of steps leaves the tolerances.
    #[test]
    fn a_run_of_limited_steps_has_its_tolerances() {
        let problem = problem::build("logistic", &[]).expect("known");
        let strict = method::parse("radau-adaptive").expect("known").tightened(1e3).expect("it has tolerances");
        let limited = strict.limited(100_000).expect("it has a limit");
        let steps = |method: &dyn method::Method| run(&*problem, method, 0.1, 2.0, |_| {}).expect("it runs").work.steps;
        assert_eq!(steps(&*limited), steps(&*strict));
        assert!(steps(&*strict) > steps(&*method::parse("radau-adaptive").expect("known")));
    }
}
