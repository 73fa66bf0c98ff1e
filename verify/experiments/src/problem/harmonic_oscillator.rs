//! The harmonic oscillator.

use lsvi::{AutoField, AutoLagrangian, FieldFn, LagrangianFn, Scalar, VectorField};

use super::{Invariant, Mechanics, Problem, Spec};
use crate::kinds::System;
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "harmonic-oscillator",
    summary: "L = ½ v² − ½ ω² q², [KY21] 3.1: linear, with recurrences in closed form",
    parameters: &[
        Parameter { name: "omega", default: "1", meaning: "angular frequency ω > 0" },
        Parameter { name: "q0", default: "1", meaning: "initial displacement" },
        Parameter { name: "p0", default: "1", meaning: "initial momentum" },
    ],
    build: |p| {
        let start = [p.number("q0")?, p.number("p0")?];
        Ok(Box::new(HarmonicOscillator { omega: p.positive("omega")?, start }))
    },
};

#[derive(Debug)]
struct HarmonicOscillator {
    omega: f64,
    start: [f64; 2],
}

impl LagrangianFn for HarmonicOscillator {
    fn dim(&self) -> usize {
        1
    }
    fn is_separable(&self) -> bool {
        true
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        (v[0] * v[0] - q[0] * q[0] * self.omega.powi(2)) * 0.5
    }
}

impl FieldFn for HarmonicOscillator {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, _t: f64, y: &[T], dy: &mut [T]) {
        dy[0] = y[1];
        dy[1] = -y[0] * self.omega.powi(2);
    }
}

impl Ode for HarmonicOscillator {
    fn dim(&self) -> usize {
        2
    }
    fn rhs(&self, _t: f64, y: &[f64], dy: &mut [f64]) {
        dy[0] = y[1];
        dy[1] = -self.omega.powi(2) * y[0];
    }
    fn jacobian(&self, _t: f64, _y: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        add(0, 1, 1.0);
        add(1, 0, -self.omega.powi(2));
    }
}

impl Problem for HarmonicOscillator {
    fn components(&self) -> &'static [&'static str] {
        &["q", "p"]
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
    fn mechanics(&self) -> Option<Mechanics<'_>> {
        Some(Mechanics::new(System::ConstantMass, AutoLagrangian::new(self)))
    }
    fn invariants(&self) -> Vec<Invariant<'_>> {
        vec![Invariant::new("energy", |y| 0.5 * (y[1].powi(2) + (self.omega * y[0]).powi(2)))]
    }
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        let ([q0, p0], (sin, cos)) = (self.start, (self.omega * t).sin_cos());
        Some(vec![q0 * cos + p0 / self.omega * sin, p0 * cos - self.omega * q0 * sin])
    }
}
