//! Field and Noyes's model of the oscillating reaction of Belousov and Zhabotinsky ([HW96] IV.10).

use lsvi::{AutoField, FieldFn, Scalar, VectorField};

use super::{Facts, Problem, Singular, Spec, Stiffness, Window, tabulated};
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "oregonator",
    summary: "an oscillating reaction over five powers of ten; published end value at t = 360",
    parameters: &[],
    build: |_| Ok(Box::new(Oregonator)),
};

#[derive(Debug)]
struct Oregonator;

const S: f64 = 77.27;
const W: f64 = 0.161;
const Q: f64 = 8.375e-6;

impl FieldFn for Oregonator {
    fn dim(&self) -> usize {
        3
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = (v[1] + v[0] * (-v[0] * Q - v[1] + 1.0)) * S;
        dv[1] = (v[2] - (v[0] + 1.0) * v[1]) / S;
        dv[2] = (v[0] - v[2]) * W;
    }
}

impl Ode for Oregonator {
    fn dim(&self) -> usize {
        3
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = S * (v[1] - v[0] * v[1] + v[0] - Q * v[0].powi(2));
        dv[1] = (v[2] - v[1] - v[0] * v[1]) / S;
        dv[2] = W * (v[0] - v[2]);
    }
    fn jacobian(&self, _t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        add(0, 0, S * (1.0 - 2.0 * Q * v[0] - v[1]));
        add(0, 1, S * (1.0 - v[0]));
        add(1, 0, -v[1] / S);
        add(1, 1, -(1.0 + v[0]) / S);
        add(1, 2, 1.0 / S);
        add(2, 0, W);
        add(2, 2, -W);
    }
}

impl Problem for Oregonator {
    fn components(&self) -> &'static [&'static str] {
        &["x", "y", "z"]
    }
    fn initial(&self) -> Vec<f64> {
        vec![1.0, 2.0, 3.0]
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    fn tabulated(&self, t: f64) -> Option<Vec<f64>> {
        tabulated::lookup("oregonator", t)
    }
    /// x follows the others at the rate s (y − 1).
    fn facts(&self) -> Facts {
        let reason =
            "Jᵀr₀ + Jᵀr₁ = 0 leaves the residual free where det J vanishes, from t = 20 on, and the branch ends there";
        Facts {
            window: Window { horizon: 0.5, coarsest: 0.01 },
            stiffness: Stiffness::Transient(S),
            singular: Some(Singular {
                reason,
                from: 20.0,
                before: Some(Window { horizon: 0.0625, coarsest: 1.5625e-4 }),
            }),
            ..Facts::default()
        }
    }
    fn is_stiff(&self) -> bool {
        true
    }
}
