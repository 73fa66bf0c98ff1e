//! Prothero and Robinson's problem: a smooth solution that attracts its neighbours at rate λ ([HW96] IV.15).

use lsvi::{AutoField, FieldFn, Scalar, VectorField};

use super::{Facts, Problem, Spec, Stiffness, Window};
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "prothero-robinson",
    summary: "v̇ = −λ (v − cos t) − sin t, v(0) = v₀: stiff, with the smooth solution cos t",
    parameters: &[
        Parameter { name: "lambda", default: "1000", meaning: "stiffness λ" },
        Parameter { name: "v0", default: "1", meaning: "initial value; 1 is on the smooth solution" },
    ],
    build: |p| Ok(Box::new(ProtheroRobinson { lambda: p.number("lambda")?, v0: p.number("v0")? })),
};

#[derive(Debug)]
struct ProtheroRobinson {
    lambda: f64,
    v0: f64,
}

impl FieldFn for ProtheroRobinson {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = (v[0] - t.cos()) * -self.lambda - t.sin();
    }
}

impl Ode for ProtheroRobinson {
    fn dim(&self) -> usize {
        1
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = -self.lambda * (v[0] - t.cos()) - t.sin();
    }
    fn jacobian(&self, _t: f64, _v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        add(0, 0, -self.lambda);
    }
}

impl Problem for ProtheroRobinson {
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
    /// cos t + (v₀ − 1) e^{−λt}.
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        Some(vec![t.cos() + (self.v0 - 1.0) * (-self.lambda * t).exp()])
    }
    fn is_stiff(&self) -> bool {
        self.lambda > 100.0
    }
    fn facts(&self) -> Facts {
        if self.is_stiff() {
            return Facts { stiffness: Stiffness::Forced(self.lambda), ..Facts::default() };
        }
        let window = Window { horizon: 2.0, coarsest: 0.2 / self.lambda.abs().max(1.0) };
        Facts { window, ..Facts::default() }
    }
}
