//! Van der Pol's oscillator.

use lsvi::{AutoField, FieldFn, Scalar, VectorField};

use super::{Facts, Problem, Singular, Spec, Window, tabulated};
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "van-der-pol",
    summary: "ẋ = y, ẏ = μ (1 − x²) y − x: a limit cycle, stiff for large μ",
    parameters: &[
        Parameter { name: "mu", default: "1", meaning: "nonlinearity μ" },
        Parameter { name: "x0", default: "2", meaning: "initial x" },
        Parameter { name: "y0", default: "0", meaning: "initial y" },
    ],
    build: |p| Ok(Box::new(VanDerPol { mu: p.number("mu")?, start: [p.number("x0")?, p.number("y0")?] })),
};

#[derive(Debug, PartialEq)]
struct VanDerPol {
    mu: f64,
    start: [f64; 2],
}

impl VanDerPol {
    const DEFAULT: Self = Self { mu: 1.0, start: [2.0, 0.0] };
}

impl FieldFn for VanDerPol {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[1];
        dv[1] = (-v[0] * v[0] + 1.0) * v[1] * self.mu - v[0];
    }
}

impl Ode for VanDerPol {
    fn dim(&self) -> usize {
        2
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = v[1];
        dv[1] = self.mu * (1.0 - v[0].powi(2)) * v[1] - v[0];
    }
    fn jacobian(&self, _t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        add(0, 1, 1.0);
        add(1, 0, -2.0 * self.mu * v[0] * v[1] - 1.0);
        add(1, 1, self.mu * (1.0 - v[0].powi(2)));
    }
}

impl Problem for VanDerPol {
    fn components(&self) -> &'static [&'static str] {
        &["x", "y"]
    }
    fn initial(&self) -> Vec<f64> {
        self.start.to_vec()
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    fn tabulated(&self, t: f64) -> Option<Vec<f64>> {
        let name = match *self {
            Self::DEFAULT => "van-der-pol",
            Self { mu: 1000.0, start } if start == Self::DEFAULT.start => "van-der-pol mu=1000",
            _ => return None,
        };
        tabulated::lookup(name, t)
    }
    fn is_stiff(&self) -> bool {
        self.mu > 20.0
    }
    fn facts(&self) -> Facts {
        let reason = "Jᵀr₀ + Jᵀr₁ = 0 leaves the residual free where det J = 2μxy + 1 vanishes, at t = 0.16; the branch ends \
                      soon after";
        let before = Some(Window { horizon: 0.1, coarsest: 0.01 });
        Facts {
            singular: (*self == Self::DEFAULT).then_some(Singular { reason, from: 0.16, before }),
            ..Facts::default()
        }
    }
}
