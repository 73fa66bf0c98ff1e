//! First-order systems M v̇ = f(t, v).

use crate::linalg::{Jacobian, Structure};
use crate::mass::Mass;

/// A first-order system M v̇ = f(t, v) in n unknowns, with the derivatives that an exact Newton iteration needs.
///
/// Implement it by hand, or implement [`Rhs`](crate::Rhs) once and let [`AutoDiff`](crate::AutoDiff) differentiate.
/// Arguments have length n; times and states carry whatever units the problem has.
pub trait VectorField {
    /// Number of unknowns n.
    fn dim(&self) -> usize;

    /// Where the Jacobian, and M, may have entries.
    fn structure(&self) -> Structure {
        Structure::Dense
    }

    /// The constant matrix M.
    fn mass(&self) -> Mass {
        Mass::Identity
    }

    /// Whether f(t, v) = A v + g(t) with a constant matrix A. Methods may then factor once, and solve for the new value
    /// itself instead of for increments, which keeps digits that f(t, v) has lost.
    fn is_linear(&self) -> bool {
        false
    }

    /// Writes f(t, v) into `dv`.
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]);

    /// Adds `scale` · ∂f_i/∂v_j to `out` (i, j).
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian);

    /// Adds `scale` · Σ_i w_i ∂²f_i/∂v_j∂v_k to `out` (j, k); nothing where f is linear in v.
    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian);
}

impl<F: VectorField + ?Sized> VectorField for &F {
    fn dim(&self) -> usize {
        (**self).dim()
    }
    fn structure(&self) -> Structure {
        (**self).structure()
    }
    fn mass(&self) -> Mass {
        (**self).mass()
    }
    fn is_linear(&self) -> bool {
        (**self).is_linear()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        (**self).rhs(t, v, dv);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        (**self).add_jacobian(t, v, scale, out);
    }
    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        (**self).add_curvature(t, v, w, scale, out);
    }
}

impl<F: VectorField + ?Sized> VectorField for Box<F> {
    fn dim(&self) -> usize {
        (**self).dim()
    }
    fn structure(&self) -> Structure {
        (**self).structure()
    }
    fn mass(&self) -> Mass {
        (**self).mass()
    }
    fn is_linear(&self) -> bool {
        (**self).is_linear()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        (**self).rhs(t, v, dv);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        (**self).add_jacobian(t, v, scale, out);
    }
    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        (**self).add_curvature(t, v, w, scale, out);
    }
}
