//! A charged particle in a magnetic field that is not uniform: a potential that depends on the velocity.

use lsvi::{AutoField, AutoLagrangian, FieldFn, LagrangianFn, Scalar, VectorField};

use super::{Invariant, Mechanics, Problem, Spec, tabulated};
use crate::kinds::System;
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "charged-particle",
    summary: "L = ½ |v|² + (½ + ¼ r²)(x v_y − y v_x) − ¼ r⁴: B = 1 + r² and potential ¼ r⁴",
    parameters: &[
        Parameter { name: "x0", default: "0.8", meaning: "initial x" },
        Parameter { name: "y0", default: "0", meaning: "initial y" },
        Parameter { name: "vx0", default: "0", meaning: "initial velocity in x" },
        Parameter { name: "vy0", default: "1", meaning: "initial velocity in y" },
    ],
    build: |p| {
        let (position, velocity) = ([p.number("x0")?, p.number("y0")?], [p.number("vx0")?, p.number("vy0")?]);
        Ok(Box::new(ChargedParticle { position, velocity }))
    },
};

#[derive(Debug, PartialEq)]
struct ChargedParticle {
    position: [f64; 2],
    velocity: [f64; 2],
}

impl ChargedParticle {
    const DEFAULT: Self = Self { position: [0.8, 0.0], velocity: [0.0, 1.0] };
}

impl LagrangianFn for ChargedParticle {
    fn dim(&self) -> usize {
        2
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        let square = q[0] * q[0] + q[1] * q[1];
        let swirl = (q[0] * v[1] - q[1] * v[0]) * (square * 0.25 + 0.5);
        (v[0] * v[0] + v[1] * v[1]) * 0.5 + swirl - square * square * 0.25
    }
}

/// v = p − A with A = (½ + ¼ r²)(−y, x), and ṗ_i = Σ_j v_j ∂A_j/∂q_i − r² q_i.
impl FieldFn for ChargedParticle {
    fn dim(&self) -> usize {
        4
    }
    fn rhs<T: Scalar>(&self, _t: f64, s: &[T], ds: &mut [T]) {
        let [x, y] = [s[0], s[1]];
        let square = x * x + y * y;
        let a = square * 0.25 + 0.5;
        let (vx, vy) = (s[2] + a * y, s[3] - a * x);
        let swirl = (x * vy - y * vx) * 0.5;
        ds[0] = vx;
        ds[1] = vy;
        ds[2] = swirl * x + a * vy - square * x;
        ds[3] = swirl * y - a * vx - square * y;
    }
}

/// A_x, A_y at (x, y).
fn potential(x: f64, y: f64) -> [f64; 2] {
    let a = 0.5 + 0.25 * (x * x + y * y);
    [-a * y, a * x]
}

/// ∂A_i/∂q_j in row i.
fn potential_gradient(x: f64, y: f64) -> [[f64; 2]; 2] {
    let a = 0.5 + 0.25 * (x * x + y * y);
    [[-0.5 * x * y, -a - 0.5 * y * y], [a + 0.5 * x * x, 0.5 * x * y]]
}

impl Ode for ChargedParticle {
    fn dim(&self) -> usize {
        4
    }
    fn rhs(&self, _t: f64, s: &[f64], ds: &mut [f64]) {
        let [x, y] = [s[0], s[1]];
        let (a, gradient) = (potential(x, y), potential_gradient(x, y));
        let v = [s[2] - a[0], s[3] - a[1]];
        for i in 0..2 {
            ds[i] = v[i];
            ds[2 + i] = v[0] * gradient[0][i] + v[1] * gradient[1][i] - (x * x + y * y) * s[i];
        }
    }
    fn jacobian(&self, _t: f64, s: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        let [x, y] = [s[0], s[1]];
        let (a, gradient) = (potential(x, y), potential_gradient(x, y));
        let v = [s[2] - a[0], s[3] - a[1]];
        // Second derivatives of A_x and A_y in (xx, xy, yy).
        let curvature = [[-0.5 * y, -0.5 * x, -1.5 * y], [1.5 * x, 0.5 * y, 0.5 * x]];
        for i in 0..2 {
            add(i, 2 + i, 1.0);
            add(2 + i, i, -(x * x + y * y));
            for j in 0..2 {
                add(i, j, -gradient[i][j]);
                add(2 + i, 2 + j, gradient[j][i]);
                add(2 + i, j, -2.0 * s[i] * s[j]);
                for k in 0..2 {
                    add(2 + i, j, v[k] * curvature[k][i + j] - gradient[k][i] * gradient[k][j]);
                }
            }
        }
    }
}

impl Problem for ChargedParticle {
    fn components(&self) -> &'static [&'static str] {
        &["x", "y", "px", "py"]
    }
    fn initial(&self) -> Vec<f64> {
        let ([x, y], [vx, vy]) = (self.position, self.velocity);
        let a = potential(x, y);
        vec![x, y, vx + a[0], vy + a[1]]
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    fn tabulated(&self, t: f64) -> Option<Vec<f64>> {
        (*self == Self::DEFAULT).then(|| tabulated::lookup("charged-particle", t)).flatten()
    }
    fn mechanics(&self) -> Option<Mechanics<'_>> {
        Some(Mechanics::new(System::General, AutoLagrangian::new(self)))
    }
    fn invariants(&self) -> Vec<Invariant<'_>> {
        vec![
            Invariant::new("energy", |s| {
                let [x, y] = [s[0], s[1]];
                let a = potential(x, y);
                0.5 * ((s[2] - a[0]).powi(2) + (s[3] - a[1]).powi(2)) + 0.25 * (x * x + y * y).powi(2)
            }),
            Invariant::new("angular momentum", |s| s[0] * s[3] - s[1] * s[2]),
        ]
    }
}
