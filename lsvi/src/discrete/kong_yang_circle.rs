//! The scheme of [KY21] (23) for motion on a circle, a documented failure.

use super::{DiscreteLegendre, Interval, MomentumWeights};
use crate::error::SolveError;
use crate::linalg::Jacobian;

/// A free particle of unit mass on the unit circle, or sphere: the path of degree 2 whose midpoint
/// η = (q₀ + q₁)/|q₀ + q₁| is on the circle, \[KY21\] (23), with square roots in its denominators where the text has none.
///
/// Nothing holds q₁ on the circle. Radial perturbations grow by −(3 + 2√2) per step in the limit of small angles, so that the scheme is
/// unusable; [`Constrained`](crate::Constrained) is the working form. With the position–momentum closure it is
///
/// q_{k−1} + 6 q_k + q_{k+1} = 4 (q_k + q_{k+1})/|q_k + q_{k+1}| + 4 (q_{k−1} + q_k)/|q_{k−1} + q_k|.
#[derive(Debug)]
pub struct KongYangCircle {
    middle: Vec<f64>,
}

impl KongYangCircle {
    /// The scheme in `dim` Cartesian coordinates, 2 for the circle.
    pub fn new(dim: usize) -> Self {
        Self { middle: vec![0.0; dim] }
    }

    /// Sets η and returns |q₀ + q₁|.
    fn place(&mut self, q0: &[f64], q1: &[f64]) -> f64 {
        for ((m, a), b) in self.middle.iter_mut().zip(q0).zip(q1) {
            *m = a + b;
        }
        let norm = self.middle.iter().map(|m| m * m).sum::<f64>().sqrt();
        self.middle.iter_mut().for_each(|m| *m /= norm);
        norm
    }

    /// Adds 4 (α − β) Dη/h + `own`/h to the derivative in either end; Dη = (I − ηηᵀ)/|q₀ + q₁|.
    fn add_end(&mut self, h: f64, q0: &[f64], q1: &[f64], w: MomentumWeights, own: f64, out: &mut Jacobian) {
        let scale = 4.0 * (w.alpha - w.beta) / (h * self.place(q0, q1));
        for (i, a) in self.middle.iter().enumerate() {
            for (j, b) in self.middle.iter().enumerate() {
                out.add(i, j, -scale * a * b);
            }
            out.add(i, i, scale + own / h);
        }
    }
}

impl DiscreteLegendre for KongYangCircle {
    fn dim(&self) -> usize {
        self.middle.len()
    }

    fn predict(&mut self, at: Interval, q0: &[f64], p0: &[f64], x: &mut [f64]) -> Result<(), SolveError> {
        for ((x, q), v) in x.iter_mut().zip(q0).zip(p0) {
            *x = q + at.h * v;
        }
        Ok(())
    }

    /// p₀ = (4η − 3q₀ − q₁)/h and p₁ = (3q₁ + q₀ − 4η)/h.
    fn momentum(&mut self, at: Interval, q0: &[f64], q1: &[f64], w: MomentumWeights, out: &mut [f64]) {
        self.place(q0, q1);
        for (((o, a), b), m) in out.iter_mut().zip(q0).zip(q1).zip(&self.middle) {
            let start = 3.0 * (m - a) + (m - b);
            let end = 3.0 * (b - m) + (a - m);
            *o = (w.alpha * start + w.beta * end) / at.h;
        }
    }

    fn add_derivative(&mut self, at: Interval, q0: &[f64], q1: &[f64], w: MomentumWeights, out: &mut Jacobian) {
        self.add_end(at.h, q0, q1, w, 3.0 * w.beta - w.alpha, out);
    }

    fn add_start_derivative(&mut self, at: Interval, q0: &[f64], q1: &[f64], w: MomentumWeights, out: &mut Jacobian) {
        self.add_end(at.h, q0, q1, w, w.beta - 3.0 * w.alpha, out);
    }
}
