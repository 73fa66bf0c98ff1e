//! Kepler's problem.

use std::f64::consts::TAU;

use lsvi::{AutoField, AutoLagrangian, FieldFn, LagrangianFn, Scalar, VectorField};

use super::{Facts, Invariant, Mechanics, Problem, Singular, Spec, Window};
use crate::kinds::System;
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "kepler",
    summary: "L = ½ |v|² + 1/|q|, semi-axis 1, from pericentre: exact by Kepler's equation",
    parameters: &[Parameter { name: "eccentricity", default: "0.6", meaning: "eccentricity, 0 ≤ e < 1" }],
    build: |p| Ok(Box::new(Kepler { eccentricity: p.within("eccentricity", 0.0..1.0)? })),
};

#[derive(Debug)]
struct Kepler {
    eccentricity: f64,
}

impl LagrangianFn for Kepler {
    fn dim(&self) -> usize {
        2
    }
    fn is_separable(&self) -> bool {
        true
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        (v[0] * v[0] + v[1] * v[1]) * 0.5 + (q[0] * q[0] + q[1] * q[1]).sqrt().recip()
    }
}

impl FieldFn for Kepler {
    fn dim(&self) -> usize {
        4
    }
    fn rhs<T: Scalar>(&self, _t: f64, y: &[T], dy: &mut [T]) {
        let attraction = (y[0] * y[0] + y[1] * y[1]).sqrt().powi(-3);
        dy[0] = y[2];
        dy[1] = y[3];
        dy[2] = -attraction * y[0];
        dy[3] = -attraction * y[1];
    }
}

impl Ode for Kepler {
    fn dim(&self) -> usize {
        4
    }
    fn rhs(&self, _t: f64, y: &[f64], dy: &mut [f64]) {
        let cube = y[0].hypot(y[1]).powi(3);
        dy[0] = y[2];
        dy[1] = y[3];
        dy[2] = -y[0] / cube;
        dy[3] = -y[1] / cube;
    }
    fn jacobian(&self, _t: f64, y: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        let r = y[0].hypot(y[1]);
        for i in 0..2 {
            add(i, 2 + i, 1.0);
            add(2 + i, i, -r.powi(-3));
            for j in 0..2 {
                add(2 + i, j, 3.0 * y[i] * y[j] / r.powi(5));
            }
        }
    }
}

/// The E with E − e sin E = M, for 0 ≤ M ≤ π.
///
/// The left side is convex there and its slope positive, so that Newton's iteration from an end where it is too large
/// decreases to the root; it stops where rounding ends the decrease.
fn eccentric_anomaly(mean: f64, e: f64) -> f64 {
    let mut anomaly = (mean + e).min(std::f64::consts::PI);
    loop {
        let next = anomaly - (anomaly - e * anomaly.sin() - mean) / (1.0 - e * anomaly.cos());
        if next >= anomaly || next.is_nan() {
            return anomaly;
        }
        anomaly = next;
    }
}

impl Problem for Kepler {
    fn components(&self) -> &'static [&'static str] {
        &["x", "y", "px", "py"]
    }
    fn initial(&self) -> Vec<f64> {
        let e = self.eccentricity;
        vec![1.0 - e, 0.0, 0.0, ((1.0 + e) / (1.0 - e)).sqrt()]
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    /// Orders are told past the pericentre, whose singularities, at ± 0.3 i from it for e = 0.6, make the error: the terms of
    /// least-squares methods settle late near it, and the rest of the orbit adds roundoff to high orders. J has the eigenvalues
    /// ±√(2/r³).
    fn facts(&self) -> Facts {
        let window = Window { horizon: 0.5, coarsest: 0.025 };
        let reason = "as h → 0 the closure is (½λ − Jᵀ)(r₀ + r₁) = 0, which leaves the residual free where r³ = 8/λ²";
        Facts {
            high_order_horizon: 0.5,
            least_squares: Some(window),
            growing: Some(Singular { reason, from: 0.0, before: Some(window) }),
            ..Facts::default()
        }
    }
    /// A tenth of an orbit, past the pericentre, over which errors of first order can be resolved.
    fn horizon(&self) -> f64 {
        0.6
    }
    /// A whole orbit.
    fn far_horizon(&self) -> f64 {
        TAU
    }
    fn mechanics(&self) -> Option<Mechanics<'_>> {
        Some(Mechanics::new(System::ConstantMass, AutoLagrangian::new(self)))
    }
    /// Energy, angular momentum, and the direction of the pericentre: p × l − q/|q|.
    fn invariants(&self) -> Vec<Invariant<'_>> {
        fn angular(y: &[f64]) -> f64 {
            y[0] * y[3] - y[1] * y[2]
        }
        vec![
            Invariant::new("energy", |y| 0.5 * (y[2].powi(2) + y[3].powi(2)) - y[0].hypot(y[1]).recip()),
            Invariant::new("angular momentum", angular),
            Invariant::new("Runge–Lenz x", |y| y[3] * angular(y) - y[0] / y[0].hypot(y[1])),
            Invariant::new("Runge–Lenz y", |y| -y[2] * angular(y) - y[1] / y[0].hypot(y[1])),
        ]
    }
    /// q = (cos E − e, √(1−e²) sin E) and q̇ = (−sin E, √(1−e²) cos E)/(1 − e cos E) with E − e sin E = t.
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        let e = self.eccentricity;
        let mean = t - TAU * (t / TAU).round();
        let anomaly = eccentric_anomaly(mean.abs(), e).copysign(mean);
        let (sin, cos) = anomaly.sin_cos();
        let (minor, rate) = (((1.0 - e) * (1.0 + e)).sqrt(), (1.0 - e * cos).recip());
        Some(vec![cos - e, minor * sin, -sin * rate, minor * cos * rate])
    }
}
