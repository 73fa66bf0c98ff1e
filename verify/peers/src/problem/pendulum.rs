//! The mathematical pendulum, L = ½ v² + cos q.

use lsvi::{EulerLagrange, HessianWeights, Jacobian, Lagrangian, MotionWeights};

use super::{Problem, System, TruthError};

/// q̇ = p, ṗ = −sin q.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pendulum;

impl System<2> for Pendulum {
    fn rhs(&self, _t: f64, v: &[f64; 2], dv: &mut [f64; 2]) {
        *dv = [v[1], -v[0].sin()];
    }

    fn jacobian(&self, _t: f64, v: &[f64; 2], mut add: impl FnMut(usize, usize, f64)) {
        add(0, 1, 1.0);
        add(1, 0, -v[0].cos());
    }
}

impl Lagrangian for Pendulum {
    fn dim(&self) -> usize {
        1
    }
    fn is_separable(&self) -> bool {
        true
    }
    fn value(&self, _t: f64, q: &[f64], v: &[f64]) -> f64 {
        0.5 * v[0] * v[0] + q[0].cos()
    }
    fn gradient(&self, _t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
        dl_dq[0] = -q[0].sin();
        dl_dv[0] = v[0];
    }
    #[inline]
    fn gradient_q(&self, _t: f64, q: &[f64], _v: &[f64], dl_dq: &mut [f64], _work: &mut [f64]) {
        dl_dq[0] = -q[0].sin();
    }
    fn add_hessian(&self, _t: f64, q: &[f64], _v: &[f64], c: HessianWeights, out: &mut Jacobian) {
        out.add(0, 0, c.vv - c.qq * q[0].cos());
    }
}

impl EulerLagrange for Pendulum {
    fn residual(&self, _t: f64, q: &[f64], _v: &[f64], a: &[f64], out: &mut [f64]) {
        out[0] = -q[0].sin() - a[0];
    }
    fn add_residual_derivative(
        &self,
        _t: f64,
        q: &[f64],
        _v: &[f64],
        _a: &[f64],
        c: MotionWeights,
        out: &mut Jacobian,
    ) {
        out.add(0, 0, -c.q * q[0].cos() - c.a);
    }
}

impl Pendulum {
    /// From rest at 2 rad to t = 100, a dozen swings; exact by Jacobi's elliptic functions.
    ///
    /// # Errors
    /// [`TruthError`] if its solution is not known.
    pub(crate) fn problem() -> Result<Problem<2, Self>, TruthError> {
        Problem::known(Self, "pendulum", 100.0)
    }
}
