//! Linear drag, Eq. (16).

use lsvi::{AutoField, FieldFn, Scalar, VectorField};

use super::{Problem, Spec};
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "linear-drag",
    summary: "v̇ = −λ v, v(0) = v₀: the test equation of stability, Eq. (16)",
    parameters: &[
        Parameter { name: "lambda", default: "1", meaning: "drag λ" },
        Parameter { name: "v0", default: "1", meaning: "initial velocity" },
    ],
    build: |p| Ok(Box::new(LinearDrag { lambda: p.number("lambda")?, v0: p.number("v0")? })),
};

#[derive(Debug)]
struct LinearDrag {
    lambda: f64,
    v0: f64,
}

impl FieldFn for LinearDrag {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[0] * -self.lambda;
    }
    /// So that the evaluations that a method needs are counted, and none by which it would find out.
    fn is_linear(&self) -> bool {
        true
    }
}

impl Ode for LinearDrag {
    fn dim(&self) -> usize {
        1
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = -self.lambda * v[0];
    }
    fn jacobian(&self, _t: f64, _v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        add(0, 0, -self.lambda);
    }
}

impl Problem for LinearDrag {
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
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        Some(vec![self.v0 * (-self.lambda * t).exp()])
    }
    fn is_stiff(&self) -> bool {
        self.lambda > 100.0
    }
}
