//! Hénon and Heiles's system.

use lsvi::{AutoField, AutoLagrangian, FieldFn, LagrangianFn, Scalar, VectorField};

use super::{Facts, Invariant, Mechanics, Problem, Singular, Spec, Window, tabulated};
use crate::kinds::System;
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "henon-heiles",
    summary: "L = ½ |v|² − ½ |q|² − x²y + y³/3, [HLW06] I.3: energy is its only invariant",
    parameters: &[
        Parameter { name: "x0", default: "0.1", meaning: "initial x" },
        Parameter { name: "y0", default: "0", meaning: "initial y" },
        Parameter { name: "px0", default: "0", meaning: "initial momentum in x" },
        Parameter { name: "py0", default: "0.5", meaning: "initial momentum in y" },
    ],
    build: |p| {
        let start = [p.number("x0")?, p.number("y0")?, p.number("px0")?, p.number("py0")?];
        Ok(Box::new(HenonHeiles { start }))
    },
};

#[derive(Debug, PartialEq)]
struct HenonHeiles {
    start: [f64; 4],
}

impl HenonHeiles {
    const DEFAULT: Self = Self { start: [0.1, 0.0, 0.0, 0.5] };
}

impl LagrangianFn for HenonHeiles {
    fn dim(&self) -> usize {
        2
    }
    fn is_separable(&self) -> bool {
        true
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        let (x2, y2) = (q[0] * q[0], q[1] * q[1]);
        (v[0] * v[0] + v[1] * v[1] - x2 - y2) * 0.5 - x2 * q[1] + y2 * q[1] / 3.0
    }
}

impl FieldFn for HenonHeiles {
    fn dim(&self) -> usize {
        4
    }
    fn rhs<T: Scalar>(&self, _t: f64, y: &[T], dy: &mut [T]) {
        dy[0] = y[2];
        dy[1] = y[3];
        dy[2] = -y[0] - y[0] * y[1] * 2.0;
        dy[3] = -y[1] - y[0] * y[0] + y[1] * y[1];
    }
}

impl Ode for HenonHeiles {
    fn dim(&self) -> usize {
        4
    }
    fn rhs(&self, _t: f64, y: &[f64], dy: &mut [f64]) {
        dy[0] = y[2];
        dy[1] = y[3];
        dy[2] = -y[0] * (1.0 + 2.0 * y[1]);
        dy[3] = -y[1] - (y[0] - y[1]) * (y[0] + y[1]);
    }
    fn jacobian(&self, _t: f64, y: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        add(0, 2, 1.0);
        add(1, 3, 1.0);
        add(2, 0, -1.0 - 2.0 * y[1]);
        add(2, 1, -2.0 * y[0]);
        add(3, 0, -2.0 * y[0]);
        add(3, 1, -1.0 + 2.0 * y[1]);
    }
}

impl Problem for HenonHeiles {
    fn components(&self) -> &'static [&'static str] {
        &["x", "y", "px", "py"]
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
    fn facts(&self) -> Facts {
        let reason = "Jᵀr₀ + Jᵀr₁ = 0 leaves the residual free where det J = 1 − 4|q|² vanishes, at t = 1.2";
        let before = Some(Window { horizon: 0.5, coarsest: 0.05 });
        Facts {
            singular: (*self == Self::DEFAULT).then_some(Singular { reason, from: 1.2, before }),
            ..Facts::default()
        }
    }
    fn tabulated(&self, t: f64) -> Option<Vec<f64>> {
        (*self == Self::DEFAULT).then(|| tabulated::lookup("henon-heiles", t)).flatten()
    }
    fn mechanics(&self) -> Option<Mechanics<'_>> {
        Some(Mechanics::new(System::ConstantMass, AutoLagrangian::new(self)))
    }
    fn invariants(&self) -> Vec<Invariant<'_>> {
        vec![Invariant::new("energy", |s| {
            let [x, y, px, py] = [s[0], s[1], s[2], s[3]];
            0.5 * (px * px + py * py + x * x + y * y) + x * x * y - y.powi(3) / 3.0
        })]
    }
}
