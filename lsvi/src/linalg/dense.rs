//! LU factors of dense matrices.

use std::fmt;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::perm::PermRef;
use faer::{Conj, MatMut, MatRef, Par};
use nalgebra::DMatrix;

use super::{FactorError, row_scale};

/// Largest order at which plain elimination is faster than the blocked one.
const SMALL: usize = 16;

/// P D A = L U of a dense matrix, D the row scaling.
pub(crate) struct DenseLu {
    factors: DMatrix<f64>,
    row_scale: Vec<f64>,
    /// The row permutation; for small matrices the row that was exchanged with row j.
    forward: Vec<usize>,
    inverse: Vec<usize>,
    /// Number of exchanges of rows.
    exchanges: usize,
    scratch: MemBuffer,
}

impl fmt::Debug for DenseLu {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DenseLu").field("factors", &self.factors).finish_non_exhaustive()
    }
}

impl DenseLu {
    pub(super) fn new(dim: usize) -> Self {
        let requirement = factor::lu_in_place_scratch::<usize, f64>(dim, dim, Par::Seq, Default::default())
            .or(solve::solve_in_place_scratch::<usize, f64>(dim, 1, Par::Seq))
            .or(solve::solve_transpose_in_place_scratch::<usize, f64>(dim, 1, Par::Seq));
        Self {
            factors: DMatrix::zeros(dim, dim),
            row_scale: vec![1.0; dim],
            forward: vec![0; dim],
            inverse: vec![0; dim],
            exchanges: 0,
            scratch: MemBuffer::new(requirement),
        }
    }

    pub(super) fn factor(&mut self, a: &DMatrix<f64>) -> Result<(), FactorError> {
        let n = self.row_scale.len();
        for (i, s) in self.row_scale.iter_mut().enumerate() {
            *s = row_scale((0..n).fold(0.0_f64, |m, j| m.max(a[(i, j)].abs())))?;
        }
        for (j, mut column) in self.factors.column_iter_mut().enumerate() {
            for (i, s) in self.row_scale.iter().enumerate() {
                column[i] = a[(i, j)] * s;
            }
        }
        if n <= SMALL {
            eliminate(n, self.factors.as_mut_slice(), &mut self.forward);
            self.exchanges = self.forward[..n].iter().enumerate().filter(|(k, pivot)| k != *pivot).count();
        } else {
            let matrix = MatMut::from_column_major_slice_mut(self.factors.as_mut_slice(), n, n);
            let stack = MemStack::new(&mut self.scratch);
            let (info, _) =
                factor::lu_in_place(matrix, &mut self.forward, &mut self.inverse, Par::Seq, stack, Default::default());
            self.exchanges = info.transposition_count;
        }
        // Backward error of elimination: each pivot is exact for a matrix perturbed by at most n ε of its scaled rows.
        let lost = n as f64 * f64::EPSILON;
        let usable = (0..n).all(|i| self.factors[(i, i)].abs() > lost);
        if usable { Ok(()) } else { Err(FactorError::Singular) }
    }

    pub(super) fn sign(&self) -> f64 {
        super::sign((0..self.row_scale.len()).map(|i| self.factors[(i, i)]), self.exchanges)
    }

    pub(super) fn solve(&mut self, b: &mut [f64]) {
        let n = self.row_scale.len();
        for (x, s) in b.iter_mut().zip(&self.row_scale) {
            *x *= s;
        }
        if n <= SMALL {
            return substitute(n, self.factors.as_slice(), &self.forward, b);
        }
        let factors = MatRef::from_column_major_slice(self.factors.as_slice(), n, n);
        let permutation = PermRef::new_checked(&self.forward, &self.inverse, n);
        let stack = MemStack::new(&mut self.scratch);
        let rhs = MatMut::from_column_major_slice_mut(b, n, 1);
        solve::solve_in_place_with_conj(factors, factors, permutation, Conj::No, rhs, Par::Seq, stack);
    }

    pub(super) fn solve_transpose(&mut self, b: &mut [f64]) {
        let n = self.row_scale.len();
        if n <= SMALL {
            substitute_transpose(n, self.factors.as_slice(), &self.forward, b);
        } else {
            let factors = MatRef::from_column_major_slice(self.factors.as_slice(), n, n);
            let permutation = PermRef::new_checked(&self.forward, &self.inverse, n);
            let stack = MemStack::new(&mut self.scratch);
            let rhs = MatMut::from_column_major_slice_mut(b, n, 1);
            solve::solve_transpose_in_place_with_conj(factors, factors, permutation, Conj::No, rhs, Par::Seq, stack);
        }
        for (x, s) in b.iter_mut().zip(&self.row_scale) {
            *x *= s;
        }
    }
}

/// Elimination in place by columns, with exchanges of whole rows.
fn eliminate(n: usize, a: &mut [f64], exchanges: &mut [usize]) {
    for k in 0..n {
        let mut pivot = k;
        for i in k + 1..n {
            if a[k * n + i].abs() > a[k * n + pivot].abs() {
                pivot = i;
            }
        }
        exchanges[k] = pivot;
        if pivot != k {
            (0..n).for_each(|j| a.swap(j * n + k, j * n + pivot));
        }
        let (done, rest) = a.split_at_mut((k + 1) * n);
        let column = &mut done[k * n + k..];
        let inverse = column[0].recip();
        column[1..].iter_mut().for_each(|x| *x *= inverse);
        for target in rest.chunks_exact_mut(n) {
            let factor = target[k];
            for (x, l) in target[k + 1..].iter_mut().zip(&column[1..]) {
                *x -= l * factor;
            }
        }
    }
}

fn substitute(n: usize, lu: &[f64], exchanges: &[usize], b: &mut [f64]) {
    for (k, &pivot) in exchanges.iter().enumerate() {
        b.swap(k, pivot);
    }
    for k in 0..n {
        for i in k + 1..n {
            b[i] -= lu[k * n + i] * b[k];
        }
    }
    for k in (0..n).rev() {
        b[k] /= lu[k * n + k];
        for i in 0..k {
            b[i] -= lu[k * n + i] * b[k];
        }
    }
}

fn substitute_transpose(n: usize, lu: &[f64], exchanges: &[usize], b: &mut [f64]) {
    for k in 0..n {
        for i in 0..k {
            b[k] -= lu[k * n + i] * b[i];
        }
        b[k] /= lu[k * n + k];
    }
    for k in (0..n).rev() {
        for i in k + 1..n {
            b[k] -= lu[k * n + i] * b[i];
        }
    }
    for (k, &pivot) in exchanges.iter().enumerate().rev() {
        b.swap(k, pivot);
    }
}
