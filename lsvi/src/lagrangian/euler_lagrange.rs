//! The Euler–Lagrange equations, for methods that impose them at nodes.

use auto_impl::auto_impl;

use super::Lagrangian;
use crate::linalg::Jacobian;

/// How much of each derivative of the Euler–Lagrange expression to add; see [`EulerLagrange::add_residual_derivative`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct MotionWeights {
    /// Weight of the derivative in q.
    pub q: f64,
    /// Weight of the derivative in v.
    pub v: f64,
    /// Weight of the derivative in the acceleration a, −∂²L/∂v².
    pub a: f64,
}

/// The Euler–Lagrange expression E = ∂L/∂q − d/dt ∂L/∂v as a function of time, configuration, velocity and acceleration,
///
/// E(t, q, v, a) = L_q − L_vq v − L_vv a − L_vt, zero on a motion.
#[auto_impl(&, Box, Rc, Arc)]
pub trait EulerLagrange: Lagrangian {
    /// Writes E(t, q, v, a).
    fn residual(&self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: &mut [f64]);

    /// Adds `c.q` ∂E/∂q + `c.v` ∂E/∂v + `c.a` ∂E/∂a to `out`.
    fn add_residual_derivative(&self, t: f64, q: &[f64], v: &[f64], a: &[f64], c: MotionWeights, out: &mut Jacobian);
}
