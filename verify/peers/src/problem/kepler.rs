//! Kepler's problem, L = ½ |v|² + 1/|q|.

use std::f64::consts::TAU;

use lsvi::{EulerLagrange, HessianWeights, Jacobian, Lagrangian, MotionWeights};

use super::{Problem, System, TruthError};

/// q̇ = p, ṗ = −q/|q|³ in the plane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Kepler;

#[inline]
fn force(q: [f64; 2]) -> [f64; 2] {
    let square = q[0] * q[0] + q[1] * q[1];
    let factor = -1.0 / (square * square.sqrt());
    [factor * q[0], factor * q[1]]
}

/// ∂F_i/∂q_j = (3 q_i q_j/|q|² − δ_ij)/|q|³.
fn force_derivative(q: [f64; 2]) -> [[f64; 2]; 2] {
    let square = q[0] * q[0] + q[1] * q[1];
    let cube = 1.0 / (square * square.sqrt());
    let across = 3.0 * cube / square;
    let mixed = across * q[0] * q[1];
    [[across * q[0] * q[0] - cube, mixed], [mixed, across * q[1] * q[1] - cube]]
}

impl System<4> for Kepler {
    fn rhs(&self, _t: f64, v: &[f64; 4], dv: &mut [f64; 4]) {
        let force = force([v[0], v[1]]);
        *dv = [v[2], v[3], force[0], force[1]];
    }

    fn jacobian(&self, _t: f64, v: &[f64; 4], mut add: impl FnMut(usize, usize, f64)) {
        let derivative = force_derivative([v[0], v[1]]);
        for (i, row) in derivative.iter().enumerate() {
            add(i, 2 + i, 1.0);
            row.iter().enumerate().for_each(|(j, x)| add(2 + i, j, *x));
        }
    }
}

impl Lagrangian for Kepler {
    fn dim(&self) -> usize {
        2
    }
    fn is_separable(&self) -> bool {
        true
    }
    fn value(&self, _t: f64, q: &[f64], v: &[f64]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) + (q[0] * q[0] + q[1] * q[1]).sqrt().recip()
    }
    fn gradient(&self, t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
        self.gradient_q(t, q, v, dl_dq, &mut []);
        dl_dv.copy_from_slice(v);
    }
    #[inline]
    fn gradient_q(&self, _t: f64, q: &[f64], _v: &[f64], dl_dq: &mut [f64], _work: &mut [f64]) {
        dl_dq.copy_from_slice(&force([q[0], q[1]]));
    }
    fn add_hessian(&self, _t: f64, q: &[f64], _v: &[f64], c: HessianWeights, out: &mut Jacobian) {
        for (i, row) in force_derivative([q[0], q[1]]).iter().enumerate() {
            row.iter().enumerate().for_each(|(j, x)| out.add(i, j, c.qq * x));
            out.add(i, i, c.vv);
        }
    }
}

impl EulerLagrange for Kepler {
    fn residual(&self, _t: f64, q: &[f64], _v: &[f64], a: &[f64], out: &mut [f64]) {
        let force = force([q[0], q[1]]);
        out.iter_mut().zip(force.iter().zip(a)).for_each(|(out, (f, a))| *out = f - a);
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
        for (i, row) in force_derivative([q[0], q[1]]).iter().enumerate() {
            row.iter().enumerate().for_each(|(j, x)| out.add(i, j, c.q * x));
            out.add(i, i, -c.a);
        }
    }
}

impl Kepler {
    /// Eccentricity 0.6 from the pericentre over 100 periods; exact by Kepler's equation.
    ///
    /// # Errors
    /// [`TruthError`] if its solution is not known.
    pub(crate) fn problem() -> Result<Problem<4, Self>, TruthError> {
        Problem::known(Self, "kepler", 100.0 * TAU)
    }
}
