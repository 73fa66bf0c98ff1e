//! Polynomial paths over a step.

use crate::discrete::Interval;
use crate::linalg::{by_size, size};
use crate::quadrature::Basis;

/// A basis of polynomial paths x(c) = q₀ + Σ_{j≥1} (x_j − q₀) φ_j(c), tabulated at some points of the step.
#[derive(Debug)]
pub(super) struct Path {
    /// The control values of the path x(c) = c.
    pub(super) abscissae: Vec<f64>,
    pub(super) points: Vec<Point>,
}

/// The basis at one point.
#[derive(Debug)]
pub(super) struct Point {
    /// The point, as a fraction of the step.
    pub(super) c: f64,
    /// φ_j(c).
    pub(super) value: Vec<f64>,
    /// φ_j′(c).
    pub(super) first: Vec<f64>,
    /// φ_j″(c).
    pub(super) second: Vec<f64>,
}

impl Path {
    pub(super) fn new(basis: &impl Basis, points: &[f64]) -> Self {
        let tabulate = |&c: &f64| Point { c, value: basis.values(c), first: basis.first(c), second: basis.second(c) };
        Self { abscissae: basis.abscissae(), points: points.iter().map(tabulate).collect() }
    }

    /// The number of control values after q₀.
    pub(super) fn degree(&self) -> usize {
        self.abscissae.len() - 1
    }

    /// Writes the control values of the straight path with velocity `v`.
    pub(super) fn straight(&self, h: f64, q0: &[f64], v: &[f64], x: &mut [f64]) {
        for (values, c) in x.chunks_exact_mut(q0.len()).zip(&self.abscissae[1..]) {
            for ((x, q), v) in values.iter_mut().zip(q0).zip(v) {
                *x = q + c * h * v;
            }
        }
    }
}

impl Point {
    /// Time of the point.
    pub(super) fn time(&self, at: Interval) -> f64 {
        at.start + self.c * at.h
    }

    /// Writes the position and the velocity of the path with control values (q₀, x).
    pub(super) fn place(&self, h: f64, q0: &[f64], x: &[f64], q: &mut [f64], v: &mut [f64]) {
        by_size!(q0.len(), N => self.place_sized::<N>(h, q0, x, q, v));
    }

    #[inline]
    fn place_sized<const N: usize>(&self, h: f64, q0: &[f64], x: &[f64], q: &mut [f64], v: &mut [f64]) {
        let (n, rate) = (size::<N>(q0.len()), h.recip());
        let (q0, q, v) = (&q0[..n], &mut q[..n], &mut v[..n]);
        q.copy_from_slice(q0);
        v.fill(0.0);
        for ((values, c), slope) in x.chunks_exact(n).zip(&self.value[1..]).zip(&self.first[1..]) {
            // Differences from q₀ keep the rounding of derivatives at that of the displacement.
            let slope = rate * slope;
            for i in 0..n {
                let difference = values[i] - q0[i];
                q[i] += c * difference;
                v[i] += slope * difference;
            }
        }
    }

    /// Writes the acceleration.
    pub(super) fn accelerate(&self, h: f64, q0: &[f64], x: &[f64], a: &mut [f64]) {
        a.fill(0.0);
        add_differences(&self.second, (h * h).recip(), q0, x, a);
    }
}

/// Differences from q₀ keep the rounding of derivatives at that of the displacement.
fn add_differences(coefficients: &[f64], scale: f64, q0: &[f64], x: &[f64], out: &mut [f64]) {
    for (values, c) in x.chunks_exact(q0.len()).zip(&coefficients[1..]) {
        for ((o, x), q) in out.iter_mut().zip(values).zip(q0) {
            *o += scale * c * (x - q);
        }
    }
}
