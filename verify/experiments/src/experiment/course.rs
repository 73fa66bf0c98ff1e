//! The error after every step of a run, and the state in which it ends.

use super::work_error::solution;
use super::{Context, Experiment, StudyError};
use crate::kinds::Principle;
use crate::measure::norm::{Extremes, distance};
use crate::method;
use crate::problem;
use crate::run::run;

/// A run.
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
    /// A bound on the error of that solution.
    pub bound: f64,
    /// The state at the end.
    pub state: Vec<f64>,
    /// As it ought to be.
    pub exact: Vec<f64>,
    /// Evaluations of f: as many for each evaluation of its step equations as a method has stages.
    pub evaluations: u64,
}

impl Found {
    /// The largest error after a step.
    pub fn largest(&self) -> f64 {
        self.errors.iter().map(|(_, error)| *error).largest()
    }
}

impl Experiment for Course {
    const ID: &'static str = "course";
    type Found = Found;

    fn measure(&self, _: &Context) -> Result<Found, StudyError> {
        let Self { problem, method, h, t_end } = self;
        let (problem, method) = (problem::build_setting(problem)?, method::parse(method)?);
        let (mut times, mut states) = (Vec::new(), Vec::new());
        let run = run(&*problem, &*method, *h, *t_end, |state| {
            if state.t > 0.0 {
                times.push(state.t);
                states.push(state.q.clone());
            }
        })?;
        let truth = solution(&*problem, Principle::MomentumZero, &times)?;
        let errors = states.iter().zip(&truth.states).map(|(state, exact)| distance(state, exact));
        let errors = times.iter().copied().zip(errors).collect();
        let [.., exact] = &truth.states[..] else { return Err("a run has a step".into()) };
        let evaluations = u64::from(method.traits().stages) * run.work.residuals;
        Ok(Found { errors, bound: truth.bound, state: run.end.q, exact: exact.clone(), evaluations })
    }
}
