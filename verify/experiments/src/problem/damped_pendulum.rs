//! A pendulum with linear damping.

use lsvi::{AutoField, AutoForce, AutoLagrangian, FieldFn, ForceFn, Forced, LagrangianFn, Scalar, VectorField};

use super::{Mechanics, Problem, Spec, tabulated};
use crate::kinds::System;
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "damped-pendulum",
    summary: "θ̇ = ω, ω̇ = −sin θ − c ω: a nonlinear oscillator that comes to rest",
    parameters: &[
        Parameter { name: "damping", default: "0.2", meaning: "damping c" },
        Parameter { name: "theta0", default: "1", meaning: "initial angle in rad" },
        Parameter { name: "omega0", default: "0", meaning: "initial angular velocity" },
    ],
    build: |p| {
        let start = [p.number("theta0")?, p.number("omega0")?];
        Ok(Box::new(DampedPendulum { damping: p.number("damping")?, start }))
    },
};

#[derive(Debug, PartialEq)]
struct DampedPendulum {
    damping: f64,
    start: [f64; 2],
}

impl DampedPendulum {
    const DEFAULT: Self = Self { damping: 0.2, start: [1.0, 0.0] };
}

impl LagrangianFn for DampedPendulum {
    fn dim(&self) -> usize {
        1
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        v[0] * v[0] * 0.5 + q[0].cos()
    }
}

/// F = −c v.
struct Drag {
    damping: f64,
}

impl ForceFn for Drag {
    fn dim(&self) -> usize {
        1
    }
    fn force<T: Scalar>(&self, _t: f64, _q: &[T], v: &[T], out: &mut [T]) {
        out[0] = -v[0] * self.damping;
    }
}

impl FieldFn for DampedPendulum {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[1];
        dv[1] = -v[0].sin() - v[1] * self.damping;
    }
}

impl Ode for DampedPendulum {
    fn dim(&self) -> usize {
        2
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = v[1];
        dv[1] = -v[0].sin() - self.damping * v[1];
    }
    fn jacobian(&self, _t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        add(0, 1, 1.0);
        add(1, 0, -v[0].cos());
        add(1, 1, -self.damping);
    }
}

impl Problem for DampedPendulum {
    fn components(&self) -> &'static [&'static str] {
        &["theta", "omega"]
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
        (*self == Self::DEFAULT).then(|| tabulated::lookup("damped-pendulum", t)).flatten()
    }
    /// The momentum is ω.
    fn mechanics(&self) -> Option<Mechanics<'_>> {
        let drag = AutoForce::new(Drag { damping: self.damping });
        Forced::new(AutoLagrangian::new(self), drag).ok().map(|forced| Mechanics::new(System::Forced, forced))
    }
}
