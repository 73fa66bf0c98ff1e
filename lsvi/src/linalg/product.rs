//! Products of dense matrices.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::DMatrix;

/// Largest order at which nalgebra's product is faster; from the order 6 on it would allocate.
const SMALL: usize = 4;

/// Sets `out` = A B, square matrices of one order, without allocation after a thread's first call.
pub(crate) fn set_product(out: &mut DMatrix<f64>, a: &DMatrix<f64>, b: &DMatrix<f64>) {
    let n = out.nrows();
    if n <= SMALL {
        return out.gemm(1.0, a, b, 0.0);
    }
    let [a, b] = [a, b].map(|it| MatRef::from_column_major_slice(it.as_slice(), n, n));
    matmul(MatMut::from_column_major_slice_mut(out.as_mut_slice(), n, n), Accum::Replace, a, b, 1.0, Par::Seq);
}
