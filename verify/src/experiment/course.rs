//! The error after every step of a run, and the state in which it ends.

use super::{Context, Experiment, StudyError};
use crate::kinds::Principle;
use crate::measure::norm::distance;
use crate::method;
use crate::problem;
use crate::run::run;

/// A run on a problem with a known solution.
#[derive(Debug, Clone)]
pub struct Course {
    /// The problem with its parameters: `channel-couette cells=64`.
    pub problem: String,
    /// The method.
    pub method: &'static str,
    /// The step size.
    pub h: f64,
    /// The end.
    pub t_end: f64,
}

/// What is found about it.
#[derive(Debug)]
pub struct Found {
    /// (t, largest error of a component) after each step, against the solution of the equations that the method steps.
    pub errors: Vec<(f64, f64)>,
    /// The state at the end.
    pub state: Vec<f64>,
    /// As it ought to be.
    pub exact: Vec<f64>,
}

impl Experiment for Course {
    const ID: &'static str = "course";
    type Found = Found;

    fn measure(&self, _: &Context) -> Result<Found, StudyError> {
        let Self { problem, method, h, t_end } = self;
        let problem = problem::build_setting(problem)?;
        let exact = problem.limit(Principle::MomentumZero).exact;
        let mut errors = Vec::new();
        let end = run(&*problem, &*method::parse(method)?, *h, *t_end, |state| {
            if state.t > 0.0 {
                errors.push((state.t, exact(state.t).map_or(f64::NAN, |exact| distance(&state.q, &exact))));
            }
        })?
        .end;
        Ok(Found { errors, exact: exact(end.t).ok_or("the solution is known")?, state: end.q })
    }
}
