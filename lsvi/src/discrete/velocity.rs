//! The velocity that belongs to a momentum.

use crate::error::SolveError;
use crate::lagrangian::{HessianWeights, Lagrangian};
use crate::linalg::{FactorError, Jacobian, Lu, Structure};

/// The inverse of p = ∂L/∂v, for first guesses.
#[derive(Debug)]
pub(super) struct Velocity {
    rest: Vec<f64>,
    dl_dq: Vec<f64>,
    velocity: Vec<f64>,
    mass: Jacobian,
    lu: Lu,
}

impl Velocity {
    pub(super) fn new(dim: usize, structure: &Structure) -> Self {
        let (zeros, mass) = (vec![0.0; dim], Jacobian::with_structure(dim, structure));
        Self { rest: zeros.clone(), dl_dq: zeros.clone(), velocity: zeros, lu: Lu::of(&mass), mass }
    }

    /// L_vv⁻¹ (p − L_v) at v = 0: one Newton step, exact for Lagrangians quadratic in the velocity.
    pub(super) fn of(&mut self, l: &impl Lagrangian, t: f64, q: &[f64], p: &[f64]) -> Result<&[f64], SolveError> {
        l.gradient(t, q, &self.rest, &mut self.dl_dq, &mut self.velocity);
        self.velocity.iter_mut().zip(p).for_each(|(v, p)| *v = p - *v);
        self.mass.clear();
        l.add_hessian(t, q, &self.rest, HessianWeights { vv: 1.0, ..Default::default() }, &mut self.mass);
        self.lu.factor(&self.mass).map_err(|error| match error {
            FactorError::Singular => SolveError::SingularMass,
            other => other.into(),
        })?;
        self.lu.solve(&mut self.velocity);
        Ok(&self.velocity)
    }
}
