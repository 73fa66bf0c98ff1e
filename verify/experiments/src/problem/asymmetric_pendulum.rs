//! A pendulum in a potential without symmetry.

use lsvi::{AutoField, AutoLagrangian, FieldFn, LagrangianFn, Scalar, VectorField};

use super::{Facts, Invariant, Mechanics, Problem, Spec, tabulated};
use crate::kinds::System;
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "asymmetric-pendulum",
    summary: "L = ½ v² + cos q − 0.2 sin 2q: rotates, so that no symmetry hides a drift of energy",
    parameters: &[
        Parameter { name: "q0", default: "0", meaning: "initial angle in rad" },
        Parameter { name: "p0", default: "2.5", meaning: "initial angular momentum" },
    ],
    build: |p| Ok(Box::new(AsymmetricPendulum { start: [p.number("q0")?, p.number("p0")?] })),
};

#[derive(Debug, PartialEq)]
struct AsymmetricPendulum {
    start: [f64; 2],
}

impl AsymmetricPendulum {
    const DEFAULT: Self = Self { start: [0.0, 2.5] };
}

impl LagrangianFn for AsymmetricPendulum {
    fn dim(&self) -> usize {
        1
    }
    fn is_separable(&self) -> bool {
        true
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        v[0] * v[0] * 0.5 + q[0].cos() - (q[0] * 2.0).sin() * 0.2
    }
}

impl FieldFn for AsymmetricPendulum {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, _t: f64, y: &[T], dy: &mut [T]) {
        dy[0] = y[1];
        dy[1] = -y[0].sin() - (y[0] * 2.0).cos() * 0.4;
    }
}

impl Ode for AsymmetricPendulum {
    fn dim(&self) -> usize {
        2
    }
    fn rhs(&self, _t: f64, y: &[f64], dy: &mut [f64]) {
        dy[0] = y[1];
        dy[1] = -y[0].sin() - 0.4 * (2.0 * y[0]).cos();
    }
    fn jacobian(&self, _t: f64, y: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        add(0, 1, 1.0);
        add(1, 0, -y[0].cos() + 0.8 * (2.0 * y[0]).sin());
    }
}

impl Problem for AsymmetricPendulum {
    fn components(&self) -> &'static [&'static str] {
        &["q", "p"]
    }
    fn initial(&self) -> Vec<f64> {
        self.start.to_vec()
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    fn tabulated(&self, t: f64) -> Option<Vec<f64>> {
        (*self == Self::DEFAULT).then(|| tabulated::lookup("asymmetric-pendulum", t)).flatten()
    }
    /// By t = 2 the leading coefficient of a high-order error has been through zero, and the next one bends the slopes by a
    /// tenth.
    fn facts(&self) -> Facts {
        Facts { high_order_horizon: 0.5, ..Facts::default() }
    }
    fn mechanics(&self) -> Option<Mechanics<'_>> {
        Some(Mechanics::new(System::ConstantMass, AutoLagrangian::new(self)))
    }
    fn invariants(&self) -> Vec<Invariant<'_>> {
        vec![Invariant::new("energy", |y| 0.5 * y[1].powi(2) - y[0].cos() + 0.2 * (2.0 * y[0]).sin())]
    }
}
