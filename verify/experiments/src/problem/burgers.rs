//! Burgers' equation with viscosity: a front that travels.

use lsvi::{AutoField, FieldFn, Scalar, Structure, VectorField};

use super::{Facts, Limit, Problem, Spec, tabulated};
use crate::kinds::Principle;
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "burgers",
    summary: "u_t + (u²/2)_x = ν u_xx on 0 < x < 1, central differences; exact: a front that travels",
    parameters: &[
        Parameter { name: "cells", default: "64", meaning: "number of cells N" },
        Parameter { name: "nu", default: "0.1", meaning: "viscosity ν > 0" },
        Parameter {
            name: "speed",
            default: "0.5",
            meaning: "speed c of the front, the mean of u before and behind it",
        },
        Parameter { name: "jump", default: "0.5", meaning: "half the jump a of u across the front" },
        Parameter { name: "x0", default: "0.25", meaning: "place of the front at t = 0" },
    ],
    build: |p| {
        Ok(Box::new(Burgers {
            cells: p.count("cells", 2..=1 << 19)?,
            nu: p.positive("nu")?,
            speed: p.number("speed")?,
            jump: p.number("jump")?,
            x0: p.number("x0")?,
        }))
    },
};

#[derive(Debug)]
struct Burgers {
    cells: usize,
    nu: f64,
    speed: f64,
    jump: f64,
    x0: f64,
}

impl Burgers {
    /// u = c − a tanh(a (x − x₀ − ct)/2ν): the Cole–Hopf substitution u = −2ν φ_x/φ makes of it φ = e^{…} + e^{…}.
    fn front(&self, x: f64, t: f64) -> f64 {
        self.speed - self.jump * (0.5 * self.jump * (x - self.x0 - self.speed * t) / self.nu).tanh()
    }

    /// Interior grid points.
    fn points(&self) -> impl Iterator<Item = f64> {
        let n = self.cells;
        (1..n).map(move |i| i as f64 / n as f64)
    }

    /// 1/2Δx and ν/Δx².
    fn weights(&self) -> (f64, f64) {
        let n = self.cells as f64;
        (0.5 * n, self.nu * n * n)
    }

    /// The fastest rate of decay, 4ν/Δx².
    fn fastest(&self) -> f64 {
        4.0 * self.weights().1
    }
}

/// As a balance of fluxes ½u² − ν u_x between neighbouring points.
impl FieldFn for Burgers {
    fn dim(&self) -> usize {
        self.cells - 1
    }
    fn structure(&self) -> Structure {
        Structure::Banded { lower: 1, upper: 1 }
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        let n = self.cells as f64;
        let flux = |before: T, after: T| (before * before + after * after) * 0.25 - (after - before) * (self.nu * n);
        let mut before = T::from(self.front(0.0, t));
        let mut inflow = flux(before, v[0]);
        for i in 0..v.len() {
            before = v[i];
            let after = v.get(i + 1).copied().unwrap_or_else(|| T::from(self.front(1.0, t)));
            let outflow = flux(before, after);
            dv[i] = (inflow - outflow) * n;
            inflow = outflow;
        }
    }
}

impl Ode for Burgers {
    fn dim(&self) -> usize {
        self.cells - 1
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        let (half, nu) = self.weights();
        let (left, right) = (self.front(0.0, t), self.front(1.0, t));
        for i in 0..v.len() {
            let before = if i == 0 { left } else { v[i - 1] };
            let after = if i + 1 == v.len() { right } else { v[i + 1] };
            dv[i] = 0.5 * half * (before * before - after * after) + nu * (before - 2.0 * v[i] + after);
        }
    }
    fn jacobian(&self, _t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        let (half, nu) = self.weights();
        for i in 0..v.len() {
            add(i, i, -2.0 * nu);
            if i > 0 {
                add(i, i - 1, nu + half * v[i - 1]);
                add(i - 1, i, nu - half * v[i]);
            }
        }
    }
    fn bandwidths(&self) -> Option<(usize, usize)> {
        Some((1, 1))
    }
}

impl Problem for Burgers {
    fn components(&self) -> &'static [&'static str] {
        &["u"]
    }
    fn initial(&self) -> Vec<f64> {
        self.points().map(|x| self.front(x, 0.0)).collect()
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    /// The solution of the partial differential equation.
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        Some(self.points().map(|x| self.front(x, t)).collect())
    }
    /// Of the equation discretised in space, in the default problem with 8 cells.
    fn tabulated(&self, t: f64) -> Option<Vec<f64>> {
        let is_default = (self.nu, self.speed, self.jump, self.x0) == (0.1, 0.5, 0.5, 0.25);
        (is_default && self.cells == 8).then(|| tabulated::lookup("burgers cells=8", t)).flatten()
    }
    fn limit(&self, _principle: Principle) -> Limit<'_> {
        Limit::semi_discrete(self, |_| None)
    }
    fn facts(&self) -> Facts {
        Facts::semi_discrete(self.fastest())
    }
}
