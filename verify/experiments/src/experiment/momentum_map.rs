//! The derivative of a step as a map of (v, p), by implicit differentiation.

use lsvi::Variational;
use lsvi::closure::{Linear, LinearClosure, PositionMomentum};
use lsvi::discrete::Trapezoidal;

use super::{Context, Experiment, StudyError};
use crate::problem;

/// How the trapezoidal least-squares Lagrangian is closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Closed {
    /// With pₙ carried along, Eq. (8).
    Conventional,
    /// By pₙ₊₁ = 0.
    MethodI,
    /// By pₙ₊₁ = pₙ.
    MethodII,
}

/// One step from (1, 0).
#[derive(Debug)]
pub struct MomentumMap {
    /// A problem with one component.
    pub problem: &'static str,
    /// The closure.
    pub closure: Closed,
    /// Step size.
    pub h: f64,
}

/// What is found of the derivative.
#[derive(Debug)]
pub struct Found {
    /// Its determinant, the factor of areas in the (v, p) plane.
    pub determinant: f64,
    /// Its spectral radius.
    pub radius: f64,
}

impl Experiment for MomentumMap {
    const ID: &'static str = "momentum-map";
    type Found = Found;

    fn measure(&self, _: &Context) -> Result<Found, StudyError> {
        match self.closure {
            Closed::Conventional => self.closed_by(PositionMomentum),
            Closed::MethodI => self.closed_by(Linear::METHOD_I),
            Closed::MethodII => self.closed_by(Linear::METHOD_II),
        }
    }
}

impl MomentumMap {
    fn closed_by(&self, closure: impl LinearClosure) -> Result<Found, StudyError> {
        let problem = problem::build_setting(self.problem)?;
        let mut method = Variational::new(Trapezoidal::new(problem.lagrangian()?), closure);
        let map = method.step_with_tangent(0.0, self.h, &mut [1.0], &mut [0.0])?;
        let (trace, determinant) = (map.trace(), map.determinant());
        let discriminant = 0.25 * trace * trace - determinant;
        let radius = if discriminant < 0.0 { determinant.sqrt() } else { 0.5 * trace.abs() + discriminant.sqrt() };
        Ok(Found { determinant, radius })
    }
}
