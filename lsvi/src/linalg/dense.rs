//! LU factors of dense matrices.

use std::fmt;

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::perm::PermRef;
use faer::{Conj, MatMut, MatRef, Par};
use nalgebra::DMatrix;

use super::entry::Entry;
use super::{FactorError, by_size, is_usable, row_scale, size};

/// Largest order at which plain elimination is faster than the blocked one.
const SMALL: usize = 16;

/// P D A = L U of a dense matrix, D the row scaling.
pub(crate) struct DenseLu<T: Entry = f64> {
    /// By columns.
    factors: Vec<T>,
    /// The reciprocals of the pivots of a small matrix.
    reciprocals: Vec<T>,
    row_scale: Vec<f64>,
    /// The row permutation; for small matrices the row that was exchanged with row j, and no inverse.
    forward: Vec<usize>,
    inverse: Vec<usize>,
    /// Number of exchanges of rows.
    exchanges: usize,
    scratch: MemBuffer,
}

impl<T: Entry> fmt::Debug for DenseLu<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DenseLu").field("factors", &self.factors).finish_non_exhaustive()
    }
}

impl<T: Entry> DenseLu<T> {
    /// Entries of L and of U, the diagonal counted once.
    pub(super) fn entries(&self) -> usize {
        self.factors.len()
    }

    pub(super) fn new(dim: usize) -> Self {
        let blocked = || {
            factor::lu_in_place_scratch::<usize, T>(dim, dim, Par::Seq, Default::default())
                .or(solve::solve_in_place_scratch::<usize, T>(dim, 1, Par::Seq))
                .or(solve::solve_transpose_in_place_scratch::<usize, T>(dim, 1, Par::Seq))
        };
        let is_small = dim <= SMALL;
        Self {
            factors: vec![T::from(0.0); dim * dim],
            reciprocals: vec![T::from(1.0); dim],
            row_scale: vec![1.0; dim],
            forward: vec![0; dim],
            inverse: vec![0; if is_small { 0 } else { dim }],
            exchanges: 0,
            scratch: MemBuffer::new(if is_small { StackReq::EMPTY } else { blocked() }),
        }
    }

    /// The matrix of the images of the entries of `a`, to be factored.
    pub(super) fn assign(&mut self, a: &DMatrix<f64>, image: impl Fn(f64) -> T) {
        self.factors.iter_mut().zip(a.as_slice()).for_each(|(x, a)| *x = image(*a));
    }

    /// Adds `x` to the diagonal of a matrix that was assigned.
    pub(super) fn shift(&mut self, x: T) {
        let next = self.row_scale.len() + 1;
        self.factors.iter_mut().step_by(next).for_each(|entry| *entry += x);
    }

    pub(super) fn entry(&mut self, i: usize, j: usize) -> Option<&mut T> {
        let n = self.row_scale.len();
        if i < n && j < n { self.factors.get_mut(j * n + i) } else { None }
    }

    /// Factors the matrix in place.
    pub(super) fn decompose(&mut self) -> Result<(), FactorError> {
        by_size!([1 2 3 4 5 6 7 8] self.row_scale.len(), N => self.decompose_sized::<N>())
    }

    #[inline]
    fn decompose_sized<const N: usize>(&mut self) -> Result<(), FactorError> {
        let n = size::<N>(self.row_scale.len());
        let (factors, scale) = (&mut self.factors[..n * n], &mut self.row_scale[..n]);
        scale.fill(0.0);
        for column in factors.chunks_exact(n.max(1)) {
            scale.iter_mut().zip(column).for_each(|(s, x)| *s = s.max(x.magnitude()));
        }
        for s in scale.iter_mut() {
            *s = row_scale(*s)?;
        }
        for column in factors.chunks_exact_mut(n.max(1)) {
            column.iter_mut().zip(&*scale).for_each(|(x, s)| *x = x.scaled(*s));
        }
        if n <= SMALL {
            self.exchanges = eliminate::<T, N>(n, factors, &mut self.reciprocals, &mut self.forward[..n]);
        } else {
            let matrix = MatMut::from_column_major_slice_mut(factors, n, n);
            let stack = MemStack::new(&mut self.scratch);
            let (info, _) =
                factor::lu_in_place(matrix, &mut self.forward, &mut self.inverse, Par::Seq, stack, Default::default());
            self.exchanges = info.transposition_count;
        }
        let usable = (0..n).all(|j| is_usable(&self.factors[j * n..=j * n + j], n));
        if usable { Ok(()) } else { Err(FactorError::Singular) }
    }

    pub(super) fn solve(&mut self, b: &mut [T]) {
        let n = self.row_scale.len();
        if n <= SMALL {
            return by_size!([1 2 3 4 5 6 7 8] n, N => self.substitute::<N>(b));
        }
        for (x, s) in b.iter_mut().zip(&self.row_scale) {
            *x = x.scaled(*s);
        }
        let factors = MatRef::from_column_major_slice(&self.factors, n, n);
        let permutation = PermRef::new_checked(&self.forward, &self.inverse, n);
        let stack = MemStack::new(&mut self.scratch);
        let rhs = MatMut::from_column_major_slice_mut(b, n, 1);
        solve::solve_in_place_with_conj(factors, factors, permutation, Conj::No, rhs, Par::Seq, stack);
    }

    /// [`solve`](Self::solve) of small systems.
    #[inline]
    fn substitute<const N: usize>(&self, b: &mut [T]) {
        let n = size::<N>(self.row_scale.len());
        let (lu, reciprocals, b) = (&self.factors[..n * n], &self.reciprocals[..n], &mut b[..n]);
        for (x, s) in b.iter_mut().zip(&self.row_scale) {
            *x = x.scaled(*s);
        }
        for (k, &pivot) in self.forward[..n].iter().enumerate() {
            if pivot != k {
                b.swap(k, pivot);
            }
        }
        for k in 0..n {
            let (solved, rest) = b.split_at_mut(k + 1);
            subtract(&lu[k * n + k + 1..(k + 1) * n], solved[k], rest);
        }
        for k in (0..n).rev() {
            let (rest, solved) = b.split_at_mut(k);
            solved[0] *= reciprocals[k];
            subtract(&lu[k * n..k * n + k], solved[0], rest);
        }
    }

    pub(super) fn solve_transpose(&mut self, b: &mut [T]) {
        let n = self.row_scale.len();
        if n <= SMALL {
            substitute_transpose(n, &self.factors, &self.forward, b);
        } else {
            let factors = MatRef::from_column_major_slice(&self.factors, n, n);
            let permutation = PermRef::new_checked(&self.forward, &self.inverse, n);
            let stack = MemStack::new(&mut self.scratch);
            let rhs = MatMut::from_column_major_slice_mut(b, n, 1);
            solve::solve_transpose_in_place_with_conj(factors, factors, permutation, Conj::No, rhs, Par::Seq, stack);
        }
        for (x, s) in b.iter_mut().zip(&self.row_scale) {
            *x = x.scaled(*s);
        }
    }
}

impl DenseLu {
    pub(super) fn sign(&self) -> f64 {
        let n = self.row_scale.len();
        super::sign((0..n).map(|i| self.factors[i * n + i]), self.exchanges)
    }
}

/// Elimination in place by columns, with exchanges of whole rows; returns how many there were.
#[inline]
fn eliminate<T: Entry, const N: usize>(n: usize, a: &mut [T], reciprocals: &mut [T], rows: &mut [usize]) -> usize {
    let n = size::<N>(n);
    let (a, reciprocals, rows, mut exchanges) = (&mut a[..n * n], &mut reciprocals[..n], &mut rows[..n], 0);
    for k in 0..n {
        let (mut pivot, mut largest) = (k, a[k * n + k].magnitude());
        for (i, x) in (k + 1..n).zip(&a[k * n + k + 1..(k + 1) * n]) {
            if x.magnitude() > largest {
                (pivot, largest) = (i, x.magnitude());
            }
        }
        rows[k] = pivot;
        if pivot != k {
            exchanges += 1;
            (0..n).for_each(|j| a.swap(j * n + k, j * n + pivot));
        }
        let (done, rest) = a.split_at_mut((k + 1) * n);
        let column = &mut done[k * n + k..];
        let inverse = T::from(1.0) / column[0];
        reciprocals[k] = inverse;
        column[1..].iter_mut().for_each(|x| *x *= inverse);
        for target in rest.chunks_exact_mut(n) {
            let (head, tail) = target.split_at_mut(k + 1);
            subtract(&column[1..], head[k], tail);
        }
    }
    exchanges
}

/// Subtracts `factor` times `column` from `out`.
#[inline]
fn subtract<T: Entry>(column: &[T], factor: T, out: &mut [T]) {
    out.iter_mut().zip(column).for_each(|(x, l)| *x -= *l * factor);
}

fn substitute_transpose<T: Entry>(n: usize, lu: &[T], exchanges: &[usize], b: &mut [T]) {
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
