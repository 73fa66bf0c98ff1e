//! Implicit stages of a linear field, whose matrix is the same in every step of a size.

use super::stage::InexactStage;
use crate::linalg::{Jacobian, Lu, Structure, max_norm};
use crate::newton::Work;
use crate::vector_field::VectorField;

/// Part of the first increment that the second one of an affine equation is at most, √ε, which leaves room for an ill-conditioned matrix.
const AFFINE: f64 = 1.0 / 67_108_864.0;
/// Roundings of a state that the second increment is at most where it is nothing else.
const ROUNDINGS: f64 = 8.0;

/// Factors of M − sA, kept while s is the same.
#[derive(Debug)]
pub(super) struct LinearStage {
    matrix: Jacobian,
    lu: Lu,
    /// The s of the factors; NaN before the first.
    s: f64,
    /// The largest component that a stage was solved for. Where terms of f cancel that are as large, their roundings stay when the solution
    /// has decayed.
    largest: f64,
    start: Vec<f64>,
    increment: Vec<f64>,
}

impl LinearStage {
    /// For a field that declares itself linear and has the entries of its matrix.
    pub(super) fn new(field: &dyn VectorField) -> Option<Self> {
        let (n, structure) = (field.dim(), field.structure());
        if !field.is_linear() || structure == Structure::MatrixFree {
            return None;
        }
        let matrix = Jacobian::with_structure(n, &structure);
        let zeros = vec![0.0; n];
        Some(Self { lu: Lu::of(&matrix), matrix, s: f64::NAN, largest: 0.0, start: zeros.clone(), increment: zeros })
    }

    /// Replaces `x`, a first guess, by the solution of the stage. False, and `x` as it was, where the matrix has no factors, or the equation
    /// is not affine with that matrix, whatever the field declares: a second increment tells.
    pub(super) fn solve(&mut self, stage: &mut dyn InexactStage, h: f64, x: &mut [f64], work: &mut Work) -> bool {
        let (_, _, _, s) = stage.at(h);
        self.start.copy_from_slice(x);
        let mut sizes = [f64::NAN; 2];
        for size in &mut sizes {
            stage.residual(h, x, &mut self.increment);
            work.residuals += 1;
            if self.s != s {
                self.s = f64::NAN;
                self.matrix.clear();
                stage.derivative(h, x, &mut self.matrix);
                work.factorizations += 1;
                if self.lu.factor(&self.matrix).is_err() {
                    return false;
                }
                self.s = s;
            }
            self.lu.solve(&mut self.increment);
            *size = max_norm(&self.increment);
            x.iter_mut().zip(&self.increment).for_each(|(x, increment)| *x -= increment);
        }
        let largest = self.largest.max(max_norm(x));
        let is_affine = sizes[1] <= AFFINE * sizes[0] || sizes[1] <= ROUNDINGS * f64::EPSILON * largest;
        if is_affine {
            self.largest = largest;
        } else {
            self.s = f64::NAN;
            x.copy_from_slice(&self.start);
        }
        is_affine
    }
}
