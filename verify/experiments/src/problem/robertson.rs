//! Robertson's reaction ([HW96] Eq. (IV.1.4)).

use lsvi::{AutoField, FieldFn, Scalar, VectorField};

use super::{Facts, Problem, Singular, Spec, Stiffness, Window, tabulated};
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "robertson",
    summary: "three reactions at rates 0.04, 10⁴ and 3·10⁷, from (1, 0, 0); published end value at t = 1e11",
    parameters: &[],
    build: |_| Ok(Box::new(Robertson)),
};

#[derive(Debug)]
struct Robertson;

impl FieldFn for Robertson {
    fn dim(&self) -> usize {
        3
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        let (decay, back, pair) = (v[0] * 0.04, v[1] * v[2] * 1e4, v[1] * v[1] * 3e7);
        dv[0] = back - decay;
        dv[1] = decay - back - pair;
        dv[2] = pair;
    }
}

impl Ode for Robertson {
    fn dim(&self) -> usize {
        3
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = -0.04 * v[0] + 1e4 * v[1] * v[2];
        dv[1] = 0.04 * v[0] - 1e4 * v[1] * v[2] - 3e7 * v[1].powi(2);
        dv[2] = 3e7 * v[1].powi(2);
    }
    fn jacobian(&self, _t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        add(0, 0, -0.04);
        add(0, 1, 1e4 * v[2]);
        add(0, 2, 1e4 * v[1]);
        add(1, 0, 0.04);
        add(1, 1, -1e4 * v[2] - 6e7 * v[1]);
        add(1, 2, -1e4 * v[1]);
        add(2, 1, 6e7 * v[1]);
    }
}

impl Problem for Robertson {
    fn components(&self) -> &'static [&'static str] {
        &["a", "b", "c"]
    }
    fn initial(&self) -> Vec<f64> {
        vec![1.0, 0.0, 0.0]
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    fn tabulated(&self, t: f64) -> Option<Vec<f64>> {
        tabulated::lookup("robertson", t)
    }
    /// b follows the others at the rate 6·10⁷ b, some 2·10³.
    fn facts(&self) -> Facts {
        let singular = "two columns of J vanish where b = c = 0, so that Jᵀr₀ + Jᵀr₁ = 0 lets b and c stay 0";
        Facts {
            window: Window { horizon: 0.2, coarsest: 0.002 },
            stiffness: Stiffness::Transient(2e3),
            singular: Some(Singular { reason: singular, from: 0.0, before: None }),
            ..Facts::default()
        }
    }
}
