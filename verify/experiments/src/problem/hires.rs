//! Schäfer's model of the high irradiance responses of photomorphogenesis ([HW96] IV.10).

use lsvi::{AutoField, FieldFn, Scalar, VectorField};

use super::{Facts, Problem, Singular, Spec, Stiffness, Window, tabulated};
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "hires",
    summary: "eight reactants of a plant's answer to light; published end value at t = 321.8122",
    parameters: &[],
    build: |_| Ok(Box::new(Hires)),
};

#[derive(Debug)]
struct Hires;

/// The linear reactions: row, column, rate.
const RATES: [(usize, usize, f64); 18] = [
    (0, 0, -1.71),
    (0, 1, 0.43),
    (0, 2, 8.32),
    (1, 0, 1.71),
    (1, 1, -8.75),
    (2, 2, -10.03),
    (2, 3, 0.43),
    (2, 4, 0.035),
    (3, 1, 8.32),
    (3, 2, 1.71),
    (3, 3, -1.12),
    (4, 4, -1.745),
    (4, 5, 0.43),
    (4, 6, 0.43),
    (5, 3, 0.69),
    (5, 4, 1.71),
    (5, 5, -0.43),
    (5, 6, 0.69),
];

impl FieldFn for Hires {
    fn dim(&self) -> usize {
        8
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        let bind = v[5] * v[7] * 280.0 - v[6] * 1.81;
        dv[0] = v[0] * -1.71 + v[1] * 0.43 + v[2] * 8.32 + 0.0007;
        dv[1] = v[0] * 1.71 - v[1] * 8.75;
        dv[2] = v[2] * -10.03 + v[3] * 0.43 + v[4] * 0.035;
        dv[3] = v[1] * 8.32 + v[2] * 1.71 - v[3] * 1.12;
        dv[4] = v[4] * -1.745 + (v[5] + v[6]) * 0.43;
        dv[5] = -v[5] * v[7] * 280.0 + v[3] * 0.69 + v[4] * 1.71 - v[5] * 0.43 + v[6] * 0.69;
        dv[6] = bind;
        dv[7] = -bind;
    }
}

impl Ode for Hires {
    fn dim(&self) -> usize {
        8
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv.fill(0.0);
        for (i, j, rate) in RATES {
            dv[i] += rate * v[j];
        }
        let (bound, freed) = (280.0 * v[5] * v[7], 1.81 * v[6]);
        dv[0] += 0.0007;
        dv[5] -= bound;
        dv[6] = bound - freed;
        dv[7] = freed - bound;
    }
    fn jacobian(&self, _t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        RATES.into_iter().for_each(|(i, j, rate)| add(i, j, rate));
        for (row, sign) in [(5, -1.0), (6, 1.0), (7, -1.0)] {
            add(row, 5, sign * 280.0 * v[7]);
            add(row, 7, sign * 280.0 * v[5]);
        }
        add(6, 6, -1.81);
        add(7, 6, 1.81);
    }
}

impl Problem for Hires {
    fn components(&self) -> &'static [&'static str] {
        &["y1", "y2", "y3", "y4", "y5", "y6", "y7", "y8"]
    }
    fn initial(&self) -> Vec<f64> {
        vec![1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0057]
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    fn tabulated(&self, t: f64) -> Option<Vec<f64>> {
        tabulated::lookup("hires", t)
    }
    /// Rates are the 10 of y₃ and up to 280 (y₆ + y₈), which stays of that size on the interval.
    fn facts(&self) -> Facts {
        let reason =
            "y₇ + y₈ is conserved: J is singular, and Jᵀr₀ + Jᵀr₁ = 0 leaves the residual free along its null vector";
        Facts {
            window: Window { horizon: 0.5, coarsest: 0.01 },
            stiffness: Stiffness::Transient(20.0),
            singular: Some(Singular { reason, from: 0.0, before: None }),
            ..Facts::default()
        }
    }
    fn is_stiff(&self) -> bool {
        true
    }
    fn horizon(&self) -> f64 {
        2.0
    }
}
