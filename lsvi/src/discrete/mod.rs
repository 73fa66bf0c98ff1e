//! Discrete Lagrangians and their discrete Legendre transforms.
//!
//! A discrete Lagrangian L_d(q₀, q₁) approximates the action over one step; its discrete Legendre transforms are the
//! momenta p₀ = −D₁L_d and p₁ = D₂L_d at the two ends (Eqs. (5), (6); \[MW01\]). That is all that a closure needs to know.

mod broken_line;
mod galerkin;
mod kong_yang_circle;
mod leapfrog;
mod midpoint;
mod nystrom;
mod path;
mod path_fitted;
mod residuals;
mod separable;
mod trapezoidal;
mod velocity;

pub use broken_line::BrokenLine;
pub use galerkin::Galerkin;
pub use kong_yang_circle::KongYangCircle;
pub use midpoint::Midpoint;
pub use path_fitted::PathFitted;
pub use trapezoidal::Trapezoidal;

use auto_impl::auto_impl;

use crate::error::SolveError;
use crate::lagrangian::Lagrangian;
use crate::linalg::{Jacobian, Structure};

/// The time interval [t, t + h] of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Time at its beginning.
    pub start: f64,
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
    /// p₁ − p₀.
    pub(crate) const CHANGE: Self = Self { alpha: -1.0, beta: 1.0 };

    /// Whether α + β is rounding.
    #[inline]
    pub(crate) fn cancel(self) -> bool {
        (self.alpha + self.beta).abs() <= f64::EPSILON * (self.alpha.abs() + self.beta.abs())
    }
}

/// The two discrete Legendre transforms of a step.
///
/// The unknowns of a step are x = (interior values, q₁): first [`interior`](Self::interior) values that the path has
/// inside the step, if any, then the n components of q₁.
#[auto_impl(&mut, Box)]
pub trait DiscreteLegendre {
    /// Degrees of freedom n.
    fn dim(&self) -> usize;

    /// Number of interior unknowns, fixed by as many conditions of stationarity.
    fn interior(&self) -> usize {
        0
    }

    /// Where [`add_derivative`](Self::add_derivative) may have entries, in a matrix of order `interior` + n.
    fn structure(&self) -> Structure {
        Structure::Dense
    }

    /// Writes a first guess of the unknowns: the straight path with the velocity that belongs to the momentum p₀. It is also what
    /// [`Integrator::rate`](crate::Integrator::rate) and dense output know of velocities, and must be exact to rounding.
    ///
    /// # Errors
    /// [`SolveError::SingularMass`] or [`SolveError::NoVelocity`] if the momentum determines no velocity.
    fn predict(&mut self, at: Interval, q0: &[f64], p0: &[f64], x: &mut [f64]) -> Result<(), SolveError>;

    /// Writes p₁ − p₀ of a solution of a step in position–momentum form, h Σ b_i ∂L/∂q, where that is what it amounts to, and tells
    /// whether it did. In D₂L_d the rounding of velocities is multiplied by ∂²L/∂v²; in an impulse there is none.
    fn impulse(&mut self, _at: Interval, _q0: &[f64], _x: &[f64], _out: &mut [f64]) -> bool {
        false
    }

    /// Replaces (q₀, p₀) by (q₁, p₁) of the position–momentum form without solving the equations of a step, as is possible for
    /// a [separable](Lagrangian::is_separable) Lagrangian; writes the unknowns and returns the number of evaluations of all
    /// forces. `None`, with q and p as they were, where it is not possible.
    ///
    /// # Errors
    /// [`SolveError`]; q and p are then as they were.
    fn separable_step(
        &mut self,
        _at: Interval,
        _q: &mut [f64],
        _p: &mut [f64],
        _x: &mut [f64],
    ) -> Result<Option<u64>, SolveError> {
        Ok(None)
    }

    /// Writes α p₀ + β p₁, combined before rounding can cancel what the two have in common.
    fn momentum(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut [f64]);

    /// Writes the conditions of stationarity, which vanish on a solution, and after them α p₀ + β p₁.
    fn equations(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut [f64]) {
        self.momentum(at, q0, x, w, out);
    }

    /// Adds the derivatives of the [`equations`](Self::equations) in x to `out`.
    fn add_derivative(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut Jacobian);

    /// Number of further unknowns z with which the equations are as well conditioned as the residual that the Lagrangian is a square of;
    /// none, the default, where there is no such form.
    fn residuals(&self) -> usize {
        0
    }

    /// Whether the components of q are in unlike units at q₀, so that conditions in which a Jacobian is squared may lead nowhere.
    fn has_unlike_units(&mut self, _at: Interval, _q0: &[f64]) -> bool {
        false
    }

    /// Writes h times the [`equations`](Self::equations) by way of z, and after them what defines z, h W r_i − z_i at the nodes for
    /// L = ½ rᵀWr; `xz` is x and after it z, and so long is `out`.
    fn residual_equations(&mut self, _at: Interval, _q0: &[f64], _xz: &[f64], _w: MomentumWeights, _out: &mut [f64]) {}

    /// Adds the derivatives of [`residual_equations`](Self::residual_equations) in x and z to the dense matrix `out`.
    fn add_residual_derivative(
        &mut self,
        _at: Interval,
        _q0: &[f64],
        _xz: &[f64],
        _w: MomentumWeights,
        _out: &mut Jacobian,
    ) {
    }

    /// Adds the derivatives of the [`equations`](Self::equations) in q₀ to the first n columns of `out`, of the same
    /// structure.
    fn add_start_derivative(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut Jacobian);
}

/// A discrete Legendre transform that comes from a discrete Lagrangian.
pub trait DiscreteLagrangian: DiscreteLegendre {
    /// L_d, the approximate action of the step with unknowns `x`.
    fn action(&mut self, at: Interval, q0: &[f64], x: &[f64]) -> f64;
}

/// What [`Constrained`](crate::Constrained) needs to know of a discretisation of mechanics: where inside a step it holds
/// the constraints, and what their reactions there do to the momenta.
///
/// Nodes are counted from 1 to m − 1; each has a condition of stationarity, to which the reaction adds an impulse.
#[auto_impl(&mut, Box)]
pub trait Constrainable: DiscreteLegendre {
    /// The Lagrangian.
    fn mechanics(&self) -> &dyn Lagrangian;

    /// The weight of the control value `j`, 0 for q₀ and m for q₁, in the position of the path at `node`.
    fn position_weight(&self, node: usize, j: usize) -> f64 {
        if node == j { 1.0 } else { 0.0 }
    }

    /// The weight of an impulse at `node` in α p₀ + β p₁.
    fn reaction_weight(&self, _node: usize, _w: MomentumWeights) -> f64 {
        0.0
    }
}

/// Writes the velocity (q₁ − q₀)/h of the straight path.
fn secant(h: f64, q0: &[f64], q1: &[f64], out: &mut [f64]) {
    for ((d, a), b) in out.iter_mut().zip(q0).zip(q1) {
        *d = (b - a) / h;
    }
}

/// Writes the end q₀ + h v of the straight path.
fn straight(h: f64, q0: &[f64], v: &[f64], out: &mut [f64]) {
    for ((o, q), v) in out.iter_mut().zip(q0).zip(v) {
        *o = q + h * v;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_cancel_to_roundings_of_their_size() {
        let cancel = |size: f64, off: f64| MomentumWeights { alpha: -size, beta: size * (1.0 + off) }.cancel();
        for size in [3e-5, 1.0, 3e5] {
            assert!(cancel(size, 0.0) && cancel(size, f64::EPSILON), "{size}");
            assert!(!cancel(size, 1e-11) && !cancel(size, f64::NAN), "{size}");
        }
    }
}
