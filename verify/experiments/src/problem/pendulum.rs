//! The mathematical pendulum, exact by Jacobi's elliptic functions.

use lsvi::{AutoField, AutoLagrangian, FieldFn, LagrangianFn, Scalar, VectorField};

use super::elliptic::Elliptic;
use super::{Invariant, Mechanics, Problem, Spec};
use crate::kinds::System;
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "pendulum",
    summary: "L = ½ v² + cos q, [KY21] (20): libration or rotation, by elliptic functions",
    parameters: &[
        Parameter { name: "q0", default: "2", meaning: "initial angle in rad" },
        Parameter { name: "p0", default: "0", meaning: "initial angular momentum" },
    ],
    build: |p| Ok(Box::new(Pendulum { q0: p.number("q0")?, p0: p.number("p0")? })),
};

#[derive(Debug)]
struct Pendulum {
    q0: f64,
    p0: f64,
}

impl LagrangianFn for Pendulum {
    fn dim(&self) -> usize {
        1
    }
    fn is_separable(&self) -> bool {
        true
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        v[0] * v[0] * 0.5 + q[0].cos()
    }
}

impl FieldFn for Pendulum {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, _t: f64, y: &[T], dy: &mut [T]) {
        dy[0] = y[1];
        dy[1] = -y[0].sin();
    }
}

impl Ode for Pendulum {
    fn dim(&self) -> usize {
        2
    }
    fn rhs(&self, _t: f64, y: &[f64], dy: &mut [f64]) {
        dy[0] = y[1];
        dy[1] = -y[0].sin();
    }
    fn jacobian(&self, _t: f64, y: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        add(0, 1, 1.0);
        add(1, 0, -y[0].cos());
    }
}

impl Pendulum {
    /// sin(q/2) = k sin φ and p = 2k cos φ with φ = am(t + F(φ₀, k), k), k² = sin²(q₀/2) + p₀²/4 < 1.
    fn libration(&self, t: f64, k: f64, complement: f64) -> [f64; 2] {
        let turns = (self.q0 / std::f64::consts::TAU).round() * std::f64::consts::TAU;
        let functions = Elliptic::new(k, complement);
        let phase = functions.integral(f64::atan2((0.5 * (self.q0 - turns)).sin(), 0.5 * self.p0));
        let (sin, cos) = functions.amplitude(t + phase).sin_cos();
        // cos(q/2) = dn ≥ 0 as a sum of squares; the arcsine alone would lose digits near the turning points.
        let half_cosine = (complement.powi(2) + (k * cos).powi(2)).sqrt();
        [turns + 2.0 * f64::atan2(k * sin, half_cosine), 2.0 * k * cos]
    }

    /// q/2 = φ = am(±kt + F(q₀/2, 1/k), 1/k) and p = ±2k dn, the sign that of p₀, k > 1.
    fn rotation(&self, t: f64, k: f64, complement: f64) -> [f64; 2] {
        let functions = Elliptic::new(1.0 / k, complement);
        let rate = k.copysign(self.p0);
        let phi = functions.amplitude(rate * t + functions.integral(0.5 * self.q0));
        [2.0 * phi, 2.0 * rate * (complement.powi(2) + (phi.cos() / k).powi(2)).sqrt()]
    }
}

impl Problem for Pendulum {
    fn components(&self) -> &'static [&'static str] {
        &["q", "p"]
    }
    fn initial(&self) -> Vec<f64> {
        vec![self.q0, self.p0]
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    fn mechanics(&self) -> Option<Mechanics<'_>> {
        Some(Mechanics::new(System::ConstantMass, AutoLagrangian::new(self)))
    }
    fn invariants(&self) -> Vec<Invariant<'_>> {
        vec![Invariant::new("energy", |y| 0.5 * y[1].powi(2) - y[0].cos())]
    }
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        let ((sin, cos), rate) = ((0.5 * self.q0).sin_cos(), 0.5 * self.p0);
        let k = sin.hypot(rate);
        // 1 − k², without the cancellation of k² itself.
        let below = (cos - rate) * (cos + rate);
        let state =
            if below >= 0.0 { self.libration(t, k, below.sqrt()) } else { self.rotation(t, k, (-below).sqrt() / k) };
        Some(state.to_vec())
    }
}
