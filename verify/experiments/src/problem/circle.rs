//! Uniform motion on a circle, as a constrained system.

use lsvi::{AutoConstraint, AutoField, AutoLagrangian, FieldFn, LagrangianFn, Scalar, VectorField};

use super::unit_sphere::UnitSphere;
use super::{Invariant, Mechanics, Problem, Spec};
use crate::kinds::System;
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "circle",
    summary: "L = ½ |v|² with |q|² = 1 in the plane, [KY21] 3.3: uniform motion on a circle",
    parameters: &[Parameter { name: "omega", default: "1", meaning: "angular velocity ω" }],
    build: |p| Ok(Box::new(Circle { omega: p.number("omega")? })),
};

#[derive(Debug)]
struct Circle {
    omega: f64,
}

impl LagrangianFn for Circle {
    fn dim(&self) -> usize {
        2
    }
    fn lagrangian<T: Scalar>(&self, _t: T, _q: &[T], v: &[T]) -> T {
        (v[0] * v[0] + v[1] * v[1]) * 0.5
    }
}

/// q̈ = −μq with μ = |p|²/|q|² from d²|q|²/dt² = 0.
impl FieldFn for Circle {
    fn dim(&self) -> usize {
        4
    }
    fn rhs<T: Scalar>(&self, _t: f64, y: &[T], dy: &mut [T]) {
        let mu = (y[2] * y[2] + y[3] * y[3]) / (y[0] * y[0] + y[1] * y[1]);
        dy[0] = y[2];
        dy[1] = y[3];
        dy[2] = -mu * y[0];
        dy[3] = -mu * y[1];
    }
}

impl Ode for Circle {
    fn dim(&self) -> usize {
        4
    }
    fn rhs(&self, _t: f64, y: &[f64], dy: &mut [f64]) {
        let mu = (y[2].powi(2) + y[3].powi(2)) / (y[0].powi(2) + y[1].powi(2));
        dy[..2].copy_from_slice(&y[2..]);
        dy[2] = -mu * y[0];
        dy[3] = -mu * y[1];
    }
    fn jacobian(&self, _t: f64, y: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        let square = y[0].powi(2) + y[1].powi(2);
        let mu = (y[2].powi(2) + y[3].powi(2)) / square;
        for i in 0..2 {
            add(i, 2 + i, 1.0);
            add(2 + i, i, -mu);
            for j in 0..2 {
                add(2 + i, j, 2.0 * mu * y[i] * y[j] / square);
                add(2 + i, 2 + j, -2.0 * y[i] * y[2 + j] / square);
            }
        }
    }
}

impl Problem for Circle {
    fn components(&self) -> &'static [&'static str] {
        &["x", "y", "px", "py"]
    }
    fn initial(&self) -> Vec<f64> {
        vec![1.0, 0.0, 0.0, self.omega]
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    fn mechanics(&self) -> Option<Mechanics<'_>> {
        let circle = AutoConstraint::new(UnitSphere { dim: 2 });
        Some(Mechanics::new(System::Circular, AutoLagrangian::new(self)).constrained(circle))
    }
    fn invariants(&self) -> Vec<Invariant<'_>> {
        vec![
            Invariant::new("energy", |y| 0.5 * (y[2].powi(2) + y[3].powi(2))),
            Invariant::new("angular momentum", |y| y[0] * y[3] - y[1] * y[2]),
        ]
    }
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        let (sin, cos) = (self.omega * t).sin_cos();
        Some(vec![cos, sin, -self.omega * sin, self.omega * cos])
    }
}
