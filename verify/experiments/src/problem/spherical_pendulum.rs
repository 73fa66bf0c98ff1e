//! The spherical pendulum in Cartesian coordinates.

use lsvi::{AutoConstraint, AutoField, AutoLagrangian, FieldFn, LagrangianFn, Scalar, VectorField};

use super::unit_sphere::UnitSphere;
use super::{Invariant, Mechanics, Problem, Spec, tabulated};
use crate::kinds::System;
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "spherical-pendulum",
    summary: "L = ½ |v|² − z with |q|² = 1 in space: nonlinear, with one momentum map",
    parameters: &[
        Parameter { name: "theta0", default: "1", meaning: "initial angle from the lowest point, in rad" },
        Parameter { name: "dtheta0", default: "0", meaning: "initial rate of that angle" },
        Parameter { name: "dphi0", default: "1", meaning: "initial angular velocity about the vertical" },
    ],
    build: |p| {
        let (theta, rates) = (p.number("theta0")?, [p.number("dtheta0")?, p.number("dphi0")?]);
        Ok(Box::new(SphericalPendulum { theta, rates }))
    },
};

#[derive(Debug, PartialEq)]
struct SphericalPendulum {
    theta: f64,
    rates: [f64; 2],
}

impl SphericalPendulum {
    const DEFAULT: Self = Self { theta: 1.0, rates: [0.0, 1.0] };
}

impl LagrangianFn for SphericalPendulum {
    fn dim(&self) -> usize {
        3
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) * 0.5 - q[2]
    }
}

/// q̈ = −e_z − μq with μ = (|p|² − z)/|q|² from d²|q|²/dt² = 0.
impl FieldFn for SphericalPendulum {
    fn dim(&self) -> usize {
        6
    }
    fn rhs<T: Scalar>(&self, _t: f64, y: &[T], dy: &mut [T]) {
        let (q, p) = y.split_at(3);
        let kinetic = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
        let mu = (kinetic - q[2]) / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
        for i in 0..3 {
            dy[i] = p[i];
            dy[3 + i] = -mu * q[i];
        }
        dy[5] -= 1.0;
    }
}

/// |q|² and μ.
fn multiplier(y: &[f64]) -> (f64, f64) {
    let dot = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
    let square = dot(&y[..3]);
    (square, (dot(&y[3..]) - y[2]) / square)
}

impl Ode for SphericalPendulum {
    fn dim(&self) -> usize {
        6
    }
    fn rhs(&self, _t: f64, y: &[f64], dy: &mut [f64]) {
        let (_, mu) = multiplier(y);
        dy[..3].copy_from_slice(&y[3..]);
        dy[3] = -mu * y[0];
        dy[4] = -mu * y[1];
        dy[5] = -mu * y[2] - 1.0;
    }
    fn jacobian(&self, _t: f64, y: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        let (square, mu) = multiplier(y);
        for i in 0..3 {
            add(i, 3 + i, 1.0);
            add(3 + i, i, -mu);
            add(3 + i, 2, y[i] / square);
            for j in 0..3 {
                add(3 + i, j, 2.0 * mu * y[i] * y[j] / square);
                add(3 + i, 3 + j, -2.0 * y[i] * y[3 + j] / square);
            }
        }
    }
}

impl Problem for SphericalPendulum {
    fn components(&self) -> &'static [&'static str] {
        &["x", "y", "z", "px", "py", "pz"]
    }
    fn initial(&self) -> Vec<f64> {
        let ((sin, cos), [dtheta, dphi]) = (self.theta.sin_cos(), self.rates);
        vec![sin, 0.0, -cos, dtheta * cos, dphi * sin, dtheta * sin]
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    fn tabulated(&self, t: f64) -> Option<Vec<f64>> {
        (*self == Self::DEFAULT).then(|| tabulated::lookup("spherical-pendulum", t)).flatten()
    }
    fn mechanics(&self) -> Option<Mechanics<'_>> {
        let sphere = AutoConstraint::new(UnitSphere { dim: 3 });
        Some(Mechanics::new(System::ConstantMass, AutoLagrangian::new(self)).constrained(sphere))
    }
    fn invariants(&self) -> Vec<Invariant<'_>> {
        vec![
            Invariant::new("energy", |y| 0.5 * (y[3].powi(2) + y[4].powi(2) + y[5].powi(2)) + y[2]),
            Invariant::new("angular momentum", |y| y[0] * y[4] - y[1] * y[3]),
        ]
    }
}
