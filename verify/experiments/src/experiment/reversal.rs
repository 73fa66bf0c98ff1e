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
        let step = |state: Vec<f64>| Ok(step_from(&*problem, state, &*method, self.h)?);
        returned(problem.initial(), step, method.momentum_roundoff(1.0), self.h)
    }
}

/// What is found of steps of `h` whose momenta are the less precise by a factor Λ, `magnified`.
fn returned(
    start: Vec<f64>,
    step: impl Fn(Vec<f64>) -> Result<Vec<f64>, StudyError>,
    magnified: f64,
    h: f64,
) -> Result<Returned, StudyError> {
    let step_and_turn = |state: Vec<f64>| -> Result<Vec<f64>, StudyError> {
        let mut state = step(state)?;
        let n = state.len() / 2;
        state[n..].iter_mut().for_each(|p| *p = -*p);
        Ok(state)
    };
    let back = step_and_turn(step_and_turn(start.clone())?)?;
    let rounding = 16.0 * f64::EPSILON * (1.0 + magnified) / h;
    Ok(Returned { defect: distance(&back, &start), rounding })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Free flight from (1, 1) in steps of 1, with numbers that are not rounded, which goes too far by some `roundings` either way.
    #[test]
    fn a_step_that_is_off_by_a_hundred_roundings_is_not_taken_back() {
        let back = |roundings: f64| {
            let step = |state: Vec<f64>| Ok(vec![state[0] + state[1] + roundings * f64::EPSILON, state[1]]);
            returned(vec![1.0, 1.0], step, 1.0, 1.0).expect("a step")
        };
        assert_eq!([0.0, 100.0].map(|roundings| back(roundings).defect), [0.0, 200.0 * f64::EPSILON]);
        assert!(back(100.0).defect > back(100.0).rounding, "{:?}", back(100.0));
    }
}
