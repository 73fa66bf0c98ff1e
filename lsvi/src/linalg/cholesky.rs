//! Cholesky factors of sparse symmetric positive definite matrices.

use std::fmt;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::{LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Conj, MatMut, Par, Side};

use super::Jacobian;
use crate::pool::Pool;

/// A = L Lᵀ with rows and columns ordered for little fill, by the entries of A that are not zero.
pub(crate) struct Cholesky {
    symbolic: SymbolicCholesky<usize>,
    values: Vec<f64>,
    scratch: Pool<MemBuffer>,
}

impl Cholesky {
    /// The factors of a symmetric `a`; `None` if it is not positive definite.
    pub(super) fn new(a: &Jacobian) -> Option<Self> {
        let (n, mut triplets) = (a.dim(), Vec::new());
        a.for_each(|i, j, x| {
            if x != 0.0 {
                triplets.push(Triplet::new(i, j, x));
            }
        });
        let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &triplets).ok()?;
        let (side, order) = (Side::Lower, SymmetricOrdering::Amd);
        let symbolic = factorize_symbolic_cholesky(matrix.symbolic(), side, order, Default::default()).ok()?;
        let mut values = vec![0.0; symbolic.len_val()];
        let (regularization, params) = (LltRegularization::default(), Default::default());
        let mut scratch = MemBuffer::new(symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, params));
        let stack = MemStack::new(&mut scratch);
        symbolic
            .factorize_numeric_llt(&mut values, matrix.as_ref(), side, regularization, Par::Seq, stack, params)
            .ok()?;
        let requirement = symbolic.solve_in_place_scratch::<f64>(1, Par::Seq);
        Some(Self { symbolic, values, scratch: Pool::new(move || MemBuffer::new(requirement)) })
    }

    /// Overwrites `b` with A⁻¹ b.
    pub(crate) fn solve(&self, b: &mut [f64]) {
        let (n, factors) = (b.len(), LltRef::new(&self.symbolic, &self.values));
        self.scratch.with(|scratch| {
            let b = MatMut::from_column_major_slice_mut(b, n, 1);
            factors.solve_in_place_with_conj(Conj::No, b, Par::Seq, MemStack::new(scratch));
        });
    }
}

impl fmt::Debug for Cholesky {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Cholesky").field("entries", &self.values.len()).finish_non_exhaustive()
    }
}
