//! Logistic growth: f_v changes sign on the way, where Method II has a spurious root.

use lsvi::{AutoField, FieldFn, Scalar, VectorField};

use super::{Problem, Spec};
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "logistic",
    summary: "v̇ = λ v (1 − v), v(0) = v₀: growth to the steady state 1",
    parameters: &[
        Parameter { name: "lambda", default: "1", meaning: "growth rate λ" },
        Parameter { name: "v0", default: "0.1", meaning: "initial population" },
    ],
    build: |p| Ok(Box::new(Logistic { lambda: p.number("lambda")?, v0: p.number("v0")? })),
};

#[derive(Debug)]
struct Logistic {
    lambda: f64,
    v0: f64,
}

impl FieldFn for Logistic {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[0] * (-v[0] + 1.0) * self.lambda;
    }
}

impl Ode for Logistic {
    fn dim(&self) -> usize {
        1
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = self.lambda * (v[0] - v[0] * v[0]);
    }
    fn jacobian(&self, _t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        add(0, 0, self.lambda * (1.0 - 2.0 * v[0]));
    }
}

impl Problem for Logistic {
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
    /// v₀/(v₀ + (1 − v₀) e^{−λt}), while the denominator has not changed sign.
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        // Written about v₀ so that t = 0 gives v₀ exactly.
        let growth = 1.0 + (1.0 - self.v0) * (-self.lambda * t).exp_m1();
        (growth > 0.0).then(|| vec![self.v0 / growth])
    }
}
