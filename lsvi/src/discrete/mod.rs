//! Discrete Lagrangians and their discrete Legendre transforms.
//!
//! A discrete Lagrangian L_d(q₀, q₁) approximates the action over one step; its discrete Legendre transforms are the
//! momenta p₀ = −D₁L_d and p₁ = D₂L_d at the two ends (Eqs. (5), (6); \[MW01\]). That is all that a closure needs to know.

mod midpoint;
mod trapezoidal;

pub use midpoint::Midpoint;
pub use trapezoidal::Trapezoidal;

use crate::linalg::Jacobian;

/// The time interval [t, t + h] of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Beginning.
    pub t: f64,
    /// Length.
    pub h: f64,
}

/// Coefficients (α, β) of a combination α p₀ + β p₁ of the momenta at the ends of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MomentumWeights {
    /// Weight of p₀ = −D₁L_d.
    pub alpha: f64,
    /// Weight of p₁ = D₂L_d.
    pub beta: f64,
}

impl MomentumWeights {
    /// p₀ alone.
    pub const START: Self = Self { alpha: 1.0, beta: 0.0 };
    /// p₁ alone.
    pub const END: Self = Self { alpha: 0.0, beta: 1.0 };
}

/// The two discrete Legendre transforms of a step.
///
/// The unknowns of a step are x = (interior values, q₁): first [`interior`](Self::interior) values that the path has
/// inside the step, if any, then the n components of q₁.
pub trait DiscreteLegendre {
    /// Degrees of freedom n.
    fn dim(&self) -> usize;

    /// Number of interior unknowns, fixed by as many [`stationarity`](Self::stationarity) conditions.
    fn interior(&self) -> usize {
        0
    }

    /// Writes a first guess of the unknowns; the configuration itself unless overridden.
    fn predict(&mut self, _at: Interval, q0: &[f64], _p0: &[f64], x: &mut [f64]) {
        for values in x.chunks_exact_mut(q0.len()) {
            values.copy_from_slice(q0);
        }
    }

    /// Writes the conditions on the interior values, which vanish on a solution.
    fn stationarity(&mut self, _at: Interval, _q0: &[f64], _x: &[f64], _out: &mut [f64]) {}

    /// Writes α p₀ + β p₁, combined before rounding can cancel what the two have in common.
    fn momentum(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut [f64]);

    /// Adds the derivatives in x of (stationarity, α p₀ + β p₁), in this order, to `out`.
    fn add_derivative(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut Jacobian);
}

/// A discrete Legendre transform that comes from a discrete Lagrangian.
pub trait DiscreteLagrangian: DiscreteLegendre {
    /// L_d, the approximate action of the step with unknowns `x`.
    fn action(&mut self, at: Interval, q0: &[f64], x: &[f64]) -> f64;
}

/// Writes the velocity (q₁ − q₀)/h of the straight path.
fn secant(h: f64, q0: &[f64], q1: &[f64], out: &mut [f64]) {
    for ((d, a), b) in out.iter_mut().zip(q0).zip(q1) {
        *d = (b - a) / h;
    }
}
