//! Derivative matrices and the solution of linear systems with them, without allocation once set up.

use std::fmt;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::perm::PermRef;
use faer::{Conj, MatMut, MatRef, Par};
use nalgebra::DMatrix;

/// A square matrix of derivatives, ∂F_i/∂x_j.
///
/// Fields and Lagrangians add their entries to it; what it is stored as is its own business.
#[derive(Debug, Clone, PartialEq)]
pub struct Jacobian {
    dense: DMatrix<f64>,
}

impl Jacobian {
    /// The zero matrix of order `dim`.
    pub fn zeros(dim: usize) -> Self {
        Self { dense: DMatrix::zeros(dim, dim) }
    }

    /// Order of the matrix.
    pub fn dim(&self) -> usize {
        self.dense.nrows()
    }

    /// Sets every entry to zero.
    pub fn clear(&mut self) {
        self.dense.fill(0.0);
    }

    /// Adds `x` to entry (i, j).
    ///
    /// # Panics
    /// If (i, j) lies outside the matrix.
    #[inline]
    pub fn add(&mut self, i: usize, j: usize, x: f64) {
        self.dense[(i, j)] += x;
    }

    /// Adds `scale` times `other`, as matrices of the same order.
    pub fn add_scaled(&mut self, scale: f64, other: &DMatrix<f64>) {
        self.dense.zip_apply(other, |a, b| *a += scale * b);
    }

    /// The entries.
    pub fn as_dense(&self) -> &DMatrix<f64> {
        &self.dense
    }

    /// The entries, to be written.
    pub fn as_dense_mut(&mut self) -> &mut DMatrix<f64> {
        &mut self.dense
    }
}

/// Adds `scale` times `block` to the entries of `out` from (row, column) on.
pub(crate) fn add_block(out: &mut DMatrix<f64>, (row, column): (usize, usize), scale: f64, block: &DMatrix<f64>) {
    for (j, entries) in block.column_iter().enumerate() {
        for (i, x) in entries.iter().enumerate() {
            out[(row + i, column + j)] += scale * x;
        }
    }
}

/// The matrix has a pivot that is zero, or lost in the rounding of its own row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SingularMatrix;

/// LU factors of a [`Jacobian`] with partial pivoting and row scaling, in storage that is allocated once.
pub(crate) struct Lu {
    factors: DMatrix<f64>,
    row_scale: Vec<f64>,
    forward: Vec<usize>,
    inverse: Vec<usize>,
    scratch: MemBuffer,
}

impl fmt::Debug for Lu {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Lu").field("factors", &self.factors).finish_non_exhaustive()
    }
}

impl Lu {
    pub(crate) fn new(dim: usize) -> Self {
        let requirement = factor::lu_in_place_scratch::<usize, f64>(dim, dim, Par::Seq, Default::default())
            .or(solve::solve_in_place_scratch::<usize, f64>(dim, 1, Par::Seq));
        Self {
            factors: DMatrix::zeros(dim, dim),
            row_scale: vec![1.0; dim],
            forward: vec![0; dim],
            inverse: vec![0; dim],
            scratch: MemBuffer::new(requirement),
        }
    }

    /// Factors a copy of `a`.
    ///
    /// Rows are scaled by powers of two to a largest entry near 1, so that a pivot at roundoff means linear
    /// dependence and not a small unit of measurement.
    pub(crate) fn factor(&mut self, a: &Jacobian) -> Result<(), SingularMatrix> {
        let n = self.row_scale.len();
        for i in 0..n {
            let largest = a.dense.row(i).iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            if largest == 0.0 || !largest.is_finite() {
                return Err(SingularMatrix);
            }
            self.row_scale[i] = largest.log2().round().exp2().recip();
        }
        for (j, mut column) in self.factors.column_iter_mut().enumerate() {
            for i in 0..n {
                column[i] = a.dense[(i, j)] * self.row_scale[i];
            }
        }
        if n > 1 {
            let matrix = MatMut::from_column_major_slice_mut(self.factors.as_mut_slice(), n, n);
            let stack = MemStack::new(&mut self.scratch);
            factor::lu_in_place(matrix, &mut self.forward, &mut self.inverse, Par::Seq, stack, Default::default());
        }
        // Backward error of elimination: each pivot is exact for a matrix perturbed by at most n ε of its scaled rows.
        let lost = n as f64 * f64::EPSILON;
        let usable = (0..n).all(|i| self.factors[(i, i)].abs() > lost);
        if usable { Ok(()) } else { Err(SingularMatrix) }
    }

    /// Overwrites `b` with the solution of A x = b.
    pub(crate) fn solve(&mut self, b: &mut [f64]) {
        let n = self.row_scale.len();
        for (x, s) in b.iter_mut().zip(&self.row_scale) {
            *x *= s;
        }
        if n == 1 {
            b[0] /= self.factors[(0, 0)];
            return;
        }
        let factors = MatRef::from_column_major_slice(self.factors.as_slice(), n, n);
        let permutation = PermRef::new_checked(&self.forward, &self.inverse, n);
        let stack = MemStack::new(&mut self.scratch);
        let rhs = MatMut::from_column_major_slice_mut(b, n, 1);
        solve::solve_in_place_with_conj(factors, factors, permutation, Conj::No, rhs, Par::Seq, stack);
    }
}

/// Largest absolute component; NaN if any component is NaN.
pub(crate) fn max_norm(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |m: f64, x| if x.is_nan() { f64::NAN } else { m.max(x.abs()) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jacobian(n: usize, entries: &[f64]) -> Jacobian {
        Jacobian { dense: DMatrix::from_row_slice(n, n, entries) }
    }

    #[test]
    fn solves_badly_scaled_rows() {
        let mut lu = Lu::new(3);
        let a = jacobian(3, &[2e-30, 1e-30, 0.0, 1.0, -3.0, 4.0, 0.0, 5e20, 1e20]);
        lu.factor(&a).expect("regular");
        let mut b = [4e-30, 7.0, 13e20];
        lu.solve(&mut b);
        for (x, exact) in b.iter().zip([1.0, 2.0, 3.0]) {
            approx::assert_relative_eq!(*x, exact, max_relative = 1e-14);
        }
    }

    #[test]
    fn refuses_singular_matrices() {
        assert_eq!(Lu::new(1).factor(&jacobian(1, &[0.0])), Err(SingularMatrix));
        assert_eq!(Lu::new(2).factor(&jacobian(2, &[0.1, 0.3, 0.2, 0.6])), Err(SingularMatrix));
        assert_eq!(Lu::new(2).factor(&jacobian(2, &[f64::NAN, 0.0, 0.0, 1.0])), Err(SingularMatrix));
    }
}
