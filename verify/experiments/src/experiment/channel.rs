//! Errors of flows between two plates, in time and in space.

use super::{Context, Experiment, StudyError};
use crate::kinds::Principle;
use crate::measure::norm::{distance, larger};
use crate::measure::order::{OrderFit, Sample};
use crate::method;
use crate::order::{Source, measure};
use crate::problem;
use crate::problem::channel;
pub use crate::problem::channel::Remainder;
use crate::run::run;

/// The order of a method in h on a problem, against the exact solution of the equations that it steps.
#[derive(Debug)]
pub struct OrderInTime {
    /// The problem with its parameters.
    pub problem: String,
    /// The method.
    pub method: &'static str,
}

impl Experiment for OrderInTime {
    const ID: &'static str = "order-in-time";
    type Found = OrderFit;

    fn measure(&self, context: &Context) -> Result<OrderFit, StudyError> {
        context.announce(1);
        let (problem, method) = (problem::build_setting(&self.problem)?, method::parse(self.method)?);
        let fit = measure(&*problem, &*method, Source::Exact.truth(&*problem, &*method))?;
        context.tick();
        Ok(fit)
    }
}

/// The largest error of a method over all steps up to t = 1 on a flow that is discretised in space.
#[derive(Debug)]
pub struct LargestOverSteps {
    /// The flow with its parameters.
    pub problem: String,
    /// The method.
    pub method: &'static str,
    /// The step size.
    pub h: f64,
}

impl Experiment for LargestOverSteps {
    const ID: &'static str = "largest-over-steps";
    type Found = Sample;

    fn measure(&self, _: &Context) -> Result<Sample, StudyError> {
        let problem = problem::build_setting(&self.problem)?;
        let exact = problem.limit(Principle::Equation).exact;
        let (mut largest, n) = (0.0_f64, problem.initial().len() as f64);
        let observed = run(&*problem, &*method::parse(self.method)?, self.h, 1.0, |state| {
            let error = exact(state.t).map_or(f64::INFINITY, |exact| distance(&state.q, &exact));
            largest = larger(largest, error);
        });
        Ok(match observed {
            // The eigenvectors of n unknowns, each sum of which rounds n times.
            Ok(_) => Sample::new(self.h, largest, n * n * f64::EPSILON),
            Err(error) => Sample::failed(self.h, error.to_string()),
        })
    }
}

/// The error of the discretisation in space of a flow: the exact solution of the discretised system against the flow.
#[derive(Debug)]
pub struct SpaceError {
    /// The flow with its parameters.
    pub problem: String,
    /// The time.
    pub t: f64,
}

impl Experiment for SpaceError {
    const ID: &'static str = "space-error";
    type Found = f64;

    fn measure(&self, _: &Context) -> Result<f64, StudyError> {
        let (problem, t) = (problem::build_setting(&self.problem)?, self.t);
        let state = (problem.limit(Principle::Equation).exact)(t).ok_or("the system is small")?;
        Ok(distance(&problem.observe(t, &state), &problem.exact(t).ok_or("the flow is known")?))
    }
}

/// What the errors of cubic Hermite elements are beside their leading term.
#[derive(Debug)]
pub struct HermiteRemainder {
    /// The flow.
    pub flow: &'static str,
    /// Elements.
    pub cells: usize,
    /// The time.
    pub t: f64,
}

impl Experiment for HermiteRemainder {
    const ID: &'static str = "hermite-remainder";
    type Found = Remainder;

    fn measure(&self, _: &Context) -> Result<Remainder, StudyError> {
        Ok(channel::remainder(self.flow, self.cells, self.t)?)
    }
}
