//! Problems that state their derivatives by hand: automatic differentiation takes n sweeps for a Jacobian of order n.

use lsvi::{Jacobian, Structure, VectorField};

use crate::reference::Ode;

/// An [`Ode`] with its second derivatives.
pub(super) trait Curved: Ode {
    /// Calls `add(j, k, x)` with contributions x to Σ_i w_i ∂²f_i/∂v_j∂v_k; never where f is linear in v.
    fn curvature(&self, v: &[f64], w: &[f64], add: &mut dyn FnMut(usize, usize, f64));

    /// Where the Jacobian has entries.
    fn structure(&self) -> Structure {
        self.bandwidths().map_or(Structure::Dense, |(lower, upper)| Structure::Banded { lower, upper })
    }

    /// Whether f is linear in v, with constant coefficients.
    fn is_linear(&self) -> bool {
        false
    }
}

/// The field of such a problem.
pub(super) struct Analytic<'a, P>(pub(super) &'a P);

impl<P: Curved> VectorField for Analytic<'_, P> {
    fn dim(&self) -> usize {
        self.0.dim()
    }
    fn structure(&self) -> Structure {
        self.0.structure()
    }
    fn is_linear(&self) -> bool {
        self.0.is_linear()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.0.rhs(t, v, dv);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.0.jacobian(t, v, &mut |i, j, x| out.add(i, j, scale * x));
    }
    fn add_curvature(&self, _t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        self.0.curvature(v, w, &mut |j, k, x| out.add(j, k, scale * x));
    }
}
