//! Whether a step can be taken back by turning the momentum round.

use super::{Context, Experiment, StudyError};
use crate::measure::norm::distance;
use crate::method;
use crate::problem;
use crate::run::step_from;

/// ρ Φ ρ Φ = id on a problem of mechanics, where ρ turns the momentum round.
#[derive(Debug)]
pub struct Reversal {
    /// The problem.
    pub problem: &'static str,
    /// The method.
    pub method: String,
    /// The step size.
    pub h: f64,
}

/// What is found of it.
#[derive(Debug)]
pub struct Returned {
    /// The distance from where it started.
    pub defect: f64,
    /// The rounding of two steps, each with roundings of a state of order 1 magnified by Λ/h in the momentum.
    pub rounding: f64,
}

impl Experiment for Reversal {
    const ID: &'static str = "reversal";
    type Found = Returned;

    fn measure(&self, _: &Context) -> Result<Returned, StudyError> {
        let (problem, method) = (problem::build_setting(self.problem)?, method::parse(&self.method)?);
        let step_and_turn = |state: Vec<f64>| -> Result<Vec<f64>, StudyError> {
            let mut state = step_from(&*problem, state, &*method, self.h)?;
            let n = state.len() / 2;
            state[n..].iter_mut().for_each(|p| *p = -*p);
            Ok(state)
        };
        let back = step_and_turn(step_and_turn(problem.initial())?)?;
        let rounding = 16.0 * f64::EPSILON * (1.0 + method.momentum_roundoff(1.0)) / self.h;
        Ok(Returned { defect: distance(&back, &problem.initial()), rounding })
    }
}
