//! Prothero and Robinson's problem: a smooth solution that attracts its neighbours at rate λ ([HW96] IV.15).

use std::f64::consts::SQRT_2;

use lsvi::{AutoDiff, Rhs, Scalar, VectorField};

use super::{Problem, Spec};
use crate::method::{Method, OrderPlan, Stability};
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

/// The order at t = 4 in even numbers of steps: `coarsest` and on, `count` of them, finer by `ratio` each.
fn smooth(method: &dyn Method, coarsest: f64, ratio: f64, count: i32) -> OrderPlan {
    let pairs = 2.0 / coarsest;
    let steps = (0..count).map(|k| 4.0 / (2.0 * (pairs * ratio.powi(k)).round())).collect();
    OrderPlan { steps, ..OrderPlan::at(method, 4.0, coarsest) }
}

const REDUCTION: &str = "hλ ≫ 1: the error is the defect of cos t divided by λ, not by 1/h";

#[derive(Debug)]
struct ProtheroRobinson {
    lambda: f64,
    v0: f64,
}

impl Rhs for ProtheroRobinson {
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
        Box::new(AutoDiff::new(self))
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

    /// Methods with a stiff order are measured where h resolves cos t and not the transient, hλ ≫ 1; the others on the
    /// time scale 1/λ.
    fn order_plan(&self, method: &dyn Method) -> OrderPlan {
        let fast = |horizon: f64| OrderPlan::at(method, horizon / self.lambda, 0.25 / self.lambda);
        if !self.is_stiff() {
            return OrderPlan::at(method, 2.0, 0.2 / self.lambda.abs().max(1.0));
        }
        match (method.stability(), method.stiff_order()) {
            (Stability::Unstable, _) => fast(4.0),
            (Stability::Conditional, _) | (_, None) => fast(10.0),
            // Undamped errors alternate in sign, and a dozen step sizes let them die out at the fine end.
            (Stability::Neutral, Some(order)) if order == method.order() => smooth(method, 0.4, SQRT_2, 12),
            // High orders change over from one limit to the other early: they are taken well before hλ = 30.
            (_, Some(order)) if method.order() > 2 => {
                smooth(method, 0.2, SQRT_2.sqrt(), 8).declared(f64::from(order), REDUCTION)
            }
            (_, Some(order)) if order == method.order() => smooth(method, 0.4, SQRT_2, 8),
            (_, Some(order)) => smooth(method, 0.4, SQRT_2, 8).declared(f64::from(order), REDUCTION),
        }
    }
}
