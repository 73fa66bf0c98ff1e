//! Holonomic constraints.

use auto_impl::auto_impl;
use nalgebra::DMatrix;

use crate::linalg::Jacobian;

/// m holonomic constraints f(q) = 0 on n degrees of freedom, with their exact derivatives.
///
/// Implement it by hand, or implement [`ConstraintFn`](crate::ConstraintFn) once and let
/// [`AutoConstraint`](crate::AutoConstraint) differentiate.
#[auto_impl(Box)]
pub trait Constraint {
    /// Degrees of freedom n.
    fn dim(&self) -> usize;

    /// Number m of constraints.
    fn count(&self) -> usize;

    /// Writes f(q), length m.
    fn value(&self, q: &[f64], out: &mut [f64]);

    /// Writes ∂f_k/∂q_i into `out` (k, i), m × n.
    fn jacobian(&self, q: &[f64], out: &mut DMatrix<f64>);

    /// Adds `scale` · Σ_k λ_k ∂²f_k/∂q² to `out`, n × n.
    fn add_curvature(&self, q: &[f64], multipliers: &[f64], scale: f64, out: &mut Jacobian);
}
