//! Quadratic drag, Eq. (30).

use lsvi::{AutoField, FieldFn, Scalar, VectorField};

use super::{Problem, Spec};
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "quadratic-drag",
    summary: "v̇ = −λ v², v(0) = v₀, Eq. (30)",
    parameters: &[
        Parameter { name: "lambda", default: "1", meaning: "drag λ" },
        Parameter { name: "v0", default: "1", meaning: "initial velocity" },
    ],
    build: |p| Ok(Box::new(QuadraticDrag { lambda: p.number("lambda")?, v0: p.number("v0")? })),
};

#[derive(Debug)]
struct QuadraticDrag {
    lambda: f64,
    v0: f64,
}

impl FieldFn for QuadraticDrag {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[0] * v[0] * -self.lambda;
    }
}

impl Ode for QuadraticDrag {
    fn dim(&self) -> usize {
        1
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = -self.lambda * v[0].powi(2);
    }
    fn jacobian(&self, _t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        add(0, 0, -2.0 * self.lambda * v[0]);
    }
}

impl Problem for QuadraticDrag {
    fn components(&self) -> &'static [&'static str] {
        &["v"]
    }
    fn initial(&self) -> Vec<f64> {
        vec![self.v0]
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    /// v₀/(1 + λ v₀ t), up to the time when it blows up for λ v₀ < 0.
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        let growth = 1.0 + self.lambda * self.v0 * t;
        (growth > 0.0).then(|| vec![self.v0 / growth])
    }
}
