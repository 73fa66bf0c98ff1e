//! The velocity that belongs to a momentum.

use crate::error::SolveError;
use crate::lagrangian::{HessianWeights, Lagrangian};
use crate::linalg::{FactorError, Jacobian, Lu, Structure, max_norm};

/// Roundings of its terms to which p = ∂L/∂v is solved: those of L_v, of v and of the linear solution.
const ROUNDINGS: f64 = 16.0;
/// Iterations; each at least halves the way to the end of a bounded domain, which doubles round in as many.
const ITERATIONS: u32 = 64;
/// Halvings of an increment; a momentum that takes more is off every scale of L.
const HALVINGS: u32 = 64;

/// The inverse of p = ∂L/∂v.
///
/// Newton's method from v = 0, whose first increment is the solution where L is quadratic in v. Increments are halved until L_v
/// is finite there and nearer to p, as in a domain that is bounded, |v| < c.
#[derive(Debug)]
pub(super) struct Velocity {
    dl_dq: Vec<f64>,
    velocity: Vec<f64>,
    trial: Vec<f64>,
    /// p − L_v at the velocity, and at the trial.
    residual: Vec<f64>,
    next: Vec<f64>,
    increment: Vec<f64>,
    /// |p| + |L_v(0)|, and with Σ_j |M_ij v_j| added, what the rounding of p − L_v is a part of.
    given: Vec<f64>,
    terms: Vec<f64>,
    mass: Jacobian,
    lu: Lu,
}

impl Velocity {
    pub(super) fn new(dim: usize, structure: &Structure) -> Self {
        let (zeros, mass) = (vec![0.0; dim], Jacobian::with_structure(dim, structure));
        Self {
            dl_dq: zeros.clone(),
            velocity: zeros.clone(),
            trial: zeros.clone(),
            residual: zeros.clone(),
            next: zeros.clone(),
            increment: zeros.clone(),
            given: zeros.clone(),
            terms: zeros,
            lu: Lu::of(&mass),
            mass,
        }
    }

    /// The velocity v with L_v(t, q, v) = p, to rounding.
    pub(super) fn of(&mut self, l: &impl Lagrangian, t: f64, q: &[f64], p: &[f64]) -> Result<&[f64], SolveError> {
        let Self { dl_dq, velocity, trial, residual, next, increment, given, terms, mass, lu } = self;
        velocity.fill(0.0);
        l.gradient(t, q, velocity, dl_dq, residual);
        for ((r, given), p) in residual.iter_mut().zip(&mut *given).zip(p) {
            *given = p.abs() + r.abs();
            *r = p - *r;
        }
        if !max_norm(residual).is_finite() {
            return Err(SolveError::NonFinite);
        }
        for _ in 0..ITERATIONS {
            mass.clear();
            l.add_hessian(t, q, velocity, HessianWeights { vv: 1.0, ..Default::default() }, mass);
            lu.factor(mass).map_err(|error| match error {
                FactorError::Singular => SolveError::SingularMass,
                other => other.into(),
            })?;
            increment.copy_from_slice(residual);
            lu.solve(increment);
            let (size, mut part, mut halvings) = (max_norm(residual), 1.0, 0);
            loop {
                trial.iter_mut().zip(&*velocity).zip(&*increment).for_each(|((x, v), d)| *x = v + part * d);
                l.gradient(t, q, trial, dl_dq, next);
                next.iter_mut().zip(p).for_each(|(r, p)| *r = p - *r);
                terms.copy_from_slice(given);
                mass.for_each(|i, j, m| terms[i] += (m * trial[j]).abs());
                if next.iter().zip(&*terms).all(|(r, term)| r.abs() <= ROUNDINGS * f64::EPSILON * term) {
                    std::mem::swap(velocity, trial);
                    return Ok(velocity);
                }
                // max_norm is NaN where a component is.
                if max_norm(next) < (1.0 - 0.25 * part) * size {
                    break;
                }
                // What is left to try is nothing but rounding, of an L_v that cancels more than its derivative tells.
                let is_rounding = part * max_norm(increment) <= f64::EPSILON * max_norm(velocity);
                if is_rounding && max_norm(increment) <= f64::EPSILON.sqrt() * max_norm(velocity) {
                    return Ok(velocity);
                }
                if is_rounding || halvings == HALVINGS {
                    return Err(SolveError::NoVelocity { difference: size });
                }
                part *= 0.5;
                halvings += 1;
            }
            std::mem::swap(velocity, trial);
            std::mem::swap(residual, next);
        }
        Err(SolveError::NoVelocity { difference: max_norm(residual) })
    }
}
