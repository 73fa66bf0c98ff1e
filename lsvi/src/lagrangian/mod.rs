//! Lagrangians L(t, q, v) of a configuration q and its velocity v = q̇.

mod euler_lagrange;
mod forced;
mod least_squares;

pub use euler_lagrange::{EulerLagrange, MotionWeights};
pub use forced::{Force, Forced};
pub use least_squares::{LeastSquares, ResidualForm};

use auto_impl::auto_impl;

use crate::linalg::{Jacobian, Structure};

/// Which blocks of second derivatives to add, and how much of each; see [`Lagrangian::add_hessian`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct HessianWeights {
    /// Weight of ∂²L/∂q_i∂q_j.
    pub qq: f64,
    /// Weight of ∂²L/∂q_i∂v_j.
    pub qv: f64,
    /// Weight of ∂²L/∂v_i∂q_j.
    pub vq: f64,
    /// Weight of ∂²L/∂v_i∂v_j.
    pub vv: f64,
}

/// A Lagrangian L(t, q, v) with n degrees of freedom and its exact derivatives.
///
/// In mechanics q are coordinates and v velocities. In the least-squares formulation of v̇ = f(t, v), [`LeastSquares`],
/// the unknown itself is the configuration q, and its rate of change is the velocity.
///
/// L need not be quadratic in v, nor finite for all v: where p = ∂L/∂v is wanted for v, it is solved by Newton's method from
/// v = 0, damped where L is not finite. So L must be so at v = 0, with a regular ∂²L/∂v² there and on the way; of several
/// velocities of one momentum, one is found or none ([`SolveError::NoVelocity`](crate::SolveError::NoVelocity)).
#[auto_impl(&, Box, Rc, Arc)]
pub trait Lagrangian {
    /// Degrees of freedom n.
    fn dim(&self) -> usize;

    /// Where the second derivatives, ∂²L/∂q², ∂²L/∂q∂v and ∂²L/∂v², may have entries.
    fn structure(&self) -> Structure {
        Structure::Dense
    }

    /// Whether L = ½ vᵀMv − V(t, q) with a constant M. Steps in position–momentum form then need ∂L/∂q alone, those of the
    /// trapezoidal rule once, and their additions are compensated, so that long runs lose no digits to h. It is checked in the first
    /// such step, and where steps start after 2, 4, 8, … more, and then after every 256:
    /// [`SolveError::NotSeparable`](crate::SolveError::NotSeparable),
    /// [`SolveError::LinearInVelocity`](crate::SolveError::LinearInVelocity). Between two of these a mass that is another one is not seen, and steps are
    /// those of a constant one.
    fn is_separable(&self) -> bool {
        false
    }

    /// What L is made of, if it is ½ rᵀWr of a residual r = M v̇ − f(t, v): [`LeastSquares`].
    fn residual_form(&self) -> Option<ResidualForm<'_>> {
        None
    }

    /// L(t, q, v).
    fn value(&self, t: f64, q: &[f64], v: &[f64]) -> f64;

    /// Writes ∂L/∂q and ∂L/∂v.
    fn gradient(&self, t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]);

    /// Writes ∂L/∂q; `work`, of the same length, is work space. Where this is a few operations, explicit steps are faster with
    /// `#[inline]` on it.
    fn gradient_q(&self, t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], work: &mut [f64]) {
        self.gradient(t, q, v, dl_dq, work);
    }

    /// Adds `c.qq` L_qq + `c.qv` L_qv + `c.vq` L_vq + `c.vv` L_vv to `out`, where (L_qv)_ij = ∂²L/∂q_i∂v_j.
    fn add_hessian(&self, t: f64, q: &[f64], v: &[f64], c: HessianWeights, out: &mut Jacobian);

    /// Adds L_qq, L_qv, L_vq and L_vv to matrices of their own, as [`add_hessian`](Self::add_hessian) adds each of them: what
    /// the four have in common may be evaluated once.
    fn add_blocks(&self, t: f64, q: &[f64], v: &[f64], blocks: [&mut Jacobian; 4]) {
        let [qq, qv, vq, vv] = blocks;
        let none = HessianWeights::default();
        self.add_hessian(t, q, v, HessianWeights { qq: 1.0, ..none }, qq);
        self.add_hessian(t, q, v, HessianWeights { qv: 1.0, ..none }, qv);
        self.add_hessian(t, q, v, HessianWeights { vq: 1.0, ..none }, vq);
        self.add_hessian(t, q, v, HessianWeights { vv: 1.0, ..none }, vv);
    }
}
