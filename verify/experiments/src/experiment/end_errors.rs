//! Errors of a run after its first interval and at its end.

use super::{Context, Experiment, StudyError};
use crate::kinds::Principle;
use crate::measure::norm::distance;
use crate::method;
use crate::problem;
use crate::run::run;

/// A run on a problem with a known solution.
#[derive(Debug, Clone)]
pub struct EndErrors {
    /// The problem with its parameters: `channel-couette cells=64`.
    pub problem: String,
    /// The method.
    pub method: String,
    /// The interval after which the error is looked at for the first time.
    pub h: f64,
    /// The steps taken in it.
    pub pieces: u32,
    /// The end.
    pub t_end: f64,
    /// What the run is compared with.
    pub truth: Truth,
}

/// What a run is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Truth {
    /// The solution itself; of a flow, so that the error of the space grid counts.
    Solution,
    /// The solution of the equations that the method steps.
    Equations,
}

/// Largest errors over the components.
#[derive(Debug, Clone, Copy)]
pub struct Found {
    /// At t = h.
    pub first: f64,
    /// At the end.
    pub end: f64,
    /// Matrices that were factored.
    pub factorizations: u64,
    /// Evaluations of f: as many for each evaluation of its step equations as a method has stages.
    pub evaluations: u64,
}

impl Experiment for EndErrors {
    const ID: &'static str = "end-errors";
    type Found = Found;

    fn measure(&self, _: &Context) -> Result<Found, StudyError> {
        let problem = problem::build_setting(&self.problem)?;
        let exact = |t: f64| match self.truth {
            Truth::Solution => problem.exact(t),
            Truth::Equations => (problem.limit(Principle::MomentumZero).exact)(t).or_else(|| problem.tabulated(t)),
        };
        let error = |q: &[f64], t: f64| exact(t).map_or(f64::NAN, |exact| distance(q, &exact));
        let (mut first, mut count) = (f64::NAN, 0);
        let h = self.h / f64::from(self.pieces);
        let method = method::parse(&self.method)?;
        let run = run(&*problem, &*method, h, self.t_end, |state| {
            if count == self.pieces {
                first = error(&state.q, state.t);
            }
            count += 1;
        })?;
        let evaluations = u64::from(method.traits().stages) * run.work.residuals;
        Ok(Found { first, end: error(&run.end.q, run.end.t), factorizations: run.work.factorizations, evaluations })
    }
}

/// The state at the end of a run.
#[derive(Debug)]
pub struct EndState(pub EndErrors);

/// That of the run, and the exact one.
#[derive(Debug)]
pub struct States {
    /// As computed.
    pub state: Vec<f64>,
    /// As it ought to be.
    pub exact: Vec<f64>,
}

impl Experiment for EndState {
    const ID: &'static str = "end-state";
    type Found = States;

    fn measure(&self, _: &Context) -> Result<States, StudyError> {
        let EndErrors { problem, method, h, pieces, t_end, .. } = &self.0;
        let problem = problem::build_setting(problem)?;
        let end = run(&*problem, &*method::parse(method)?, h / f64::from(*pieces), *t_end, |_| {})?.end;
        Ok(States { exact: problem.exact(end.t).ok_or("the solution is known")?, state: end.q })
    }
}
