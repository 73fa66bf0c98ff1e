//! The plane double pendulum: a mass that depends on the configuration.

use lsvi::{AutoField, AutoLagrangian, FieldFn, LagrangianFn, Scalar, VectorField};

use super::{Facts, Invariant, Mechanics, Problem, Singular, Spec, Window, tabulated};
use crate::kinds::System;
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "double-pendulum",
    summary: "L = v₁² + ½ v₂² + v₁v₂ cos(q₁−q₂) + 2 cos q₁ + cos q₂: masses, lengths and g one",
    parameters: &[
        Parameter { name: "q10", default: "1", meaning: "initial angle of the upper rod, in rad" },
        Parameter { name: "q20", default: "2", meaning: "initial angle of the lower rod, in rad" },
        Parameter { name: "p10", default: "0", meaning: "momentum conjugate to the first" },
        Parameter { name: "p20", default: "0", meaning: "momentum conjugate to the second" },
    ],
    build: |p| {
        let start = [p.number("q10")?, p.number("q20")?, p.number("p10")?, p.number("p20")?];
        Ok(Box::new(DoublePendulum { start }))
    },
};

#[derive(Debug, PartialEq)]
struct DoublePendulum {
    start: [f64; 4],
}

impl DoublePendulum {
    const DEFAULT: Self = Self { start: [1.0, 2.0, 0.0, 0.0] };
}

impl LagrangianFn for DoublePendulum {
    fn dim(&self) -> usize {
        2
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        let kinetic = v[0] * v[0] + v[1] * v[1] * 0.5 + v[0] * v[1] * (q[0] - q[1]).cos();
        kinetic + q[0].cos() * 2.0 + q[1].cos()
    }
}

/// v = M⁻¹p with M = [2 cos δ; cos δ 1], δ = q₁ − q₂, and ∂T/∂δ at constant p is v₁v₂ sin δ.
impl FieldFn for DoublePendulum {
    fn dim(&self) -> usize {
        4
    }
    fn rhs<T: Scalar>(&self, _t: f64, y: &[T], dy: &mut [T]) {
        let (s, c) = (y[0] - y[1]).sin_cos();
        let determinant = s * s + 1.0;
        dy[0] = (y[2] - c * y[3]) / determinant;
        dy[1] = (y[3] * 2.0 - c * y[2]) / determinant;
        let coupling = dy[0] * dy[1] * s;
        dy[2] = -coupling - y[0].sin() * 2.0;
        dy[3] = coupling - y[1].sin();
    }
}

/// sin δ, cos δ, det M, v₁ and v₂.
fn velocities(y: &[f64]) -> (f64, f64, f64, [f64; 2]) {
    let (s, c) = (y[0] - y[1]).sin_cos();
    let determinant = 2.0 - c * c;
    (s, c, determinant, [(y[2] - c * y[3]) / determinant, (2.0 * y[3] - c * y[2]) / determinant])
}

impl Ode for DoublePendulum {
    fn dim(&self) -> usize {
        4
    }
    fn rhs(&self, _t: f64, y: &[f64], dy: &mut [f64]) {
        let (s, _, _, [v1, v2]) = velocities(y);
        dy[0] = v1;
        dy[1] = v2;
        dy[2] = -s * v1 * v2 - 2.0 * y[0].sin();
        dy[3] = s * v1 * v2 - y[1].sin();
    }
    fn jacobian(&self, _t: f64, y: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        let (s, c, determinant, [v1, v2]) = velocities(y);
        let by_angle = |p: f64, v: f64| (s * p - 2.0 * s * c * v) / determinant;
        let (turn1, turn2, direct) = (by_angle(y[3], v1), by_angle(y[2], v2), c * v1 * v2);
        // ∂v₁, ∂v₂ and the part of ∂(v₁v₂ sin δ) from sin δ, in each component of the state.
        let columns = [
            [turn1, turn2, direct],
            [-turn1, -turn2, -direct],
            [1.0 / determinant, -c / determinant, 0.0],
            [-c / determinant, 2.0 / determinant, 0.0],
        ];
        for (j, [dv1, dv2, direct]) in columns.into_iter().enumerate() {
            let coupling = direct + s * (dv1 * v2 + v1 * dv2);
            add(0, j, dv1);
            add(1, j, dv2);
            add(2, j, -coupling);
            add(3, j, coupling);
        }
        add(2, 0, -2.0 * y[0].cos());
        add(3, 1, -y[1].cos());
    }
}

impl Problem for DoublePendulum {
    fn components(&self) -> &'static [&'static str] {
        &["q1", "q2", "p1", "p2"]
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
    /// By t = 2 the motion has magnified the next coefficients of the error more than the leading one.
    fn facts(&self) -> Facts {
        let reason = "Jᵀr₀ + Jᵀr₁ = 0 leaves the residual free where det J vanishes, at t = 0.9";
        let before = Some(Window { horizon: 0.5, coarsest: 0.05 });
        Facts {
            high_order_horizon: 0.5,
            singular: (*self == Self::DEFAULT).then_some(Singular { reason, from: 0.9, before }),
            ..Facts::default()
        }
    }
    fn tabulated(&self, t: f64) -> Option<Vec<f64>> {
        (*self == Self::DEFAULT).then(|| tabulated::lookup("double-pendulum", t)).flatten()
    }
    fn mechanics(&self) -> Option<Mechanics<'_>> {
        Some(Mechanics::new(System::General, AutoLagrangian::new(self)))
    }
    fn invariants(&self) -> Vec<Invariant<'_>> {
        vec![Invariant::new("energy", |y| {
            let (_, _, _, [v1, v2]) = velocities(y);
            0.5 * (y[2] * v1 + y[3] * v2) - 2.0 * y[0].cos() - y[1].cos()
        })]
    }
}
