//! The heat equation on a square.

use std::f64::consts::PI;

use lsvi::{AutoField, FieldFn, Scalar, Structure, VectorField};

use super::{Facts, Limit, Problem, Spec};
use crate::kinds::Principle;
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "heat-2d",
    summary: "u_t = ν (u_xx + u_yy) on the unit square, five-point formula; exact: two modes that decay",
    parameters: &[
        Parameter { name: "cells", default: "8", meaning: "number of cells N along a side" },
        Parameter { name: "nu", default: "0.1", meaning: "diffusivity ν > 0" },
    ],
    build: |p| Ok(Box::new(Heat { cells: p.count("cells", 2..=256)?, nu: p.positive("nu")? })),
};

/// Amplitude and wave numbers of the initial state, Σ a sin kπx sin lπy.
const MODES: [(f64, f64, f64); 2] = [(1.0, 1.0, 1.0), (0.5, 2.0, 3.0)];

#[derive(Debug)]
struct Heat {
    cells: usize,
    nu: f64,
}

impl Heat {
    /// Interior points along a side.
    fn side(&self) -> usize {
        self.cells - 1
    }

    /// ν/Δx².
    fn weight(&self) -> f64 {
        self.nu * (self.cells as f64).powi(2)
    }

    /// The fastest rate of decay, 8ν/Δx².
    fn fastest(&self) -> f64 {
        8.0 * self.weight()
    }

    /// The modes with the rates of decay that `square` gives for kπ, row by row.
    fn decaying(&self, t: f64, square: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut u = vec![0.0; self.side() * self.side()];
        for (a, k, l) in MODES {
            let amplitude = a * (-self.nu * (square(k * PI) + square(l * PI)) * t).exp();
            let sine = |k: f64, i: usize| (k * PI * (i + 1) as f64 / self.cells as f64).sin();
            for (row, values) in u.chunks_mut(self.side()).enumerate() {
                for (column, u) in values.iter_mut().enumerate() {
                    *u += amplitude * sine(k, column) * sine(l, row);
                }
            }
        }
        u
    }

    /// The same modes are eigenvectors of the five-point formula, with (2/Δx)² sin²(kπΔx/2) for (kπ)².
    fn semi_discrete(&self, t: f64) -> Vec<f64> {
        let n = self.cells as f64;
        self.decaying(t, |k| (2.0 * n * (0.5 * k / n).sin()).powi(2))
    }
}

/// As the flow of heat between neighbours: what one loses the other gains, and the edges are at zero.
impl FieldFn for Heat {
    fn dim(&self) -> usize {
        self.side() * self.side()
    }
    fn structure(&self) -> Structure {
        let mut positions = Vec::with_capacity(5 * self.side() * self.side());
        self.jacobian(0.0, &[], &mut |i, j, _| positions.push((i, j)));
        Structure::sparse(self.side() * self.side(), positions).expect("all positions lie in the matrix")
    }
    fn is_linear(&self) -> bool {
        true
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        let (side, weight) = (self.side(), self.weight());
        for (p, dv) in dv.iter_mut().enumerate() {
            let edges = [p % side == 0, p % side + 1 == side, p < side, p + side >= v.len()];
            *dv = v[p] * (-weight * edges.iter().filter(|edge| **edge).count() as f64);
        }
        for p in 0..v.len() {
            let right = (p % side + 1 < side).then_some(p + 1);
            let above = (p + side < v.len()).then_some(p + side);
            for q in right.into_iter().chain(above) {
                let flow = (v[p] - v[q]) * weight;
                dv[p] -= flow;
                dv[q] += flow;
            }
        }
    }
}

impl Ode for Heat {
    fn dim(&self) -> usize {
        self.side() * self.side()
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        let (side, weight) = (self.side(), self.weight());
        for (p, dv) in dv.iter_mut().enumerate() {
            let (row, column) = (p / side, p % side);
            let mut sum = -4.0 * v[p];
            if column > 0 {
                sum += v[p - 1];
            }
            if column + 1 < side {
                sum += v[p + 1];
            }
            if row > 0 {
                sum += v[p - side];
            }
            if row + 1 < side {
                sum += v[p + side];
            }
            *dv = weight * sum;
        }
    }
    fn jacobian(&self, _t: f64, _v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        let (side, weight) = (self.side(), self.weight());
        for p in 0..side * side {
            add(p, p, -4.0 * weight);
            let right = (p % side + 1 < side).then_some(p + 1);
            let above = (p / side + 1 < side).then_some(p + side);
            for q in right.into_iter().chain(above) {
                add(p, q, weight);
                add(q, p, weight);
            }
        }
    }
    fn bandwidths(&self) -> Option<(usize, usize)> {
        Some((self.side(), self.side()))
    }
}

impl Problem for Heat {
    fn components(&self) -> &'static [&'static str] {
        &["u"]
    }
    fn initial(&self) -> Vec<f64> {
        self.semi_discrete(0.0)
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    /// The solution of the partial differential equation.
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        Some(self.decaying(t, |k| k * k))
    }
    fn limit(&self, _principle: Principle) -> Limit<'_> {
        Limit::semi_discrete(self, |t| Some(self.semi_discrete(t)))
    }
    fn facts(&self) -> Facts {
        Facts::semi_discrete(self.fastest())
    }
}
