//! Derivative matrices and the solution of linear systems with them, without allocation once set up.

mod banded;
mod cholesky;
mod condition;
mod dense;
mod entry;
mod gram;
mod jacobian;
mod product;
mod rank;
mod size;
mod sparse;
mod structure;
mod tridiagonal;

pub use jacobian::Jacobian;
pub use structure::{Pattern, Structure};

pub(crate) use cholesky::Cholesky;
pub(crate) use condition::inverse_norm;
pub(crate) use entry::Entry;
pub(crate) use gram::{Rows, add_with_transpose};
pub(crate) use product::set_product;
pub(crate) use rank::{NumericalRank, ROUNDINGS};
pub(crate) use size::{by_size, size, vectors};

use nalgebra::DMatrix;

use crate::error::SolveError;
use banded::BandLu;
use dense::DenseLu;
use jacobian::Entries;
use sparse::SparseLu;
use tridiagonal::TridiagonalLu;

/// Why a matrix has no usable factors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FactorError {
    /// A pivot is zero, or lost in rounding.
    Singular,
    /// An entry is NaN or infinite.
    NonFinite { row: usize, column: usize },
    /// An entry was added where the declared structure has none.
    OutsideStructure { row: usize, column: usize },
    /// The matrix is known by its products only.
    NotAssembled,
}

impl From<FactorError> for SolveError {
    fn from(error: FactorError) -> Self {
        match error {
            FactorError::Singular => Self::Singular,
            FactorError::NonFinite { row, column } => Self::NonFiniteDerivative { row, column },
            FactorError::OutsideStructure { row, column } => Self::OutsideStructure { row, column },
            FactorError::NotAssembled => Self::NotAssembled,
        }
    }
}

/// LU factors of a [`Jacobian`] with partial pivoting and row scaling, in storage that is allocated once.
///
/// Rows are scaled by powers of two to a largest entry near 1, so that a pivot at roundoff means linear dependence and
/// not a small unit of measurement.
#[derive(Debug)]
pub(crate) enum Lu<T: Entry = f64> {
    Dense(DenseLu<T>),
    Tridiagonal(TridiagonalLu<T>),
    Banded(BandLu<T>),
    Sparse(Box<SparseLu<T>>),
}

impl<T: Entry> Lu<T> {
    /// Storage for the factors of matrices stored as `a` is.
    pub(crate) fn of(a: &Jacobian) -> Self {
        match a.entries() {
            Entries::Dense(a) => Self::Dense(DenseLu::new(a.nrows())),
            Entries::Banded(a) if a.is_tridiagonal() => Self::Tridiagonal(TridiagonalLu::new(a.dim())),
            Entries::Banded(a) => Self::Banded(BandLu::new(a)),
            Entries::Sparse(a) => Self::Sparse(Box::new(SparseLu::new(a))),
        }
    }

    /// Takes the images of the entries of `a`, which is stored as the matrix given to [`of`](Self::of), to be
    /// [factored](Self::decompose).
    pub(crate) fn assign(&mut self, a: &Jacobian, image: impl Fn(f64) -> T) -> Result<(), FactorError> {
        a.check_structure()?;
        match (&mut *self, a.entries()) {
            (Self::Dense(lu), Entries::Dense(a)) => lu.assign(a, image),
            (Self::Tridiagonal(lu), Entries::Banded(a)) if a.is_tridiagonal() => lu.assign(a, image),
            (Self::Banded(lu), Entries::Banded(a)) if !a.is_tridiagonal() => lu.assign(a, image),
            (Self::Sparse(lu), Entries::Sparse(a)) => lu.assign(a, image),
            _ => {
                *self = Self::of(a);
                return self.assign(a, image);
            }
        }
        Ok(())
    }

    /// Adds `x` to entry (i, j) of a matrix that was assigned, unless it has none there.
    #[inline]
    pub(crate) fn add(&mut self, i: usize, j: usize, x: T) {
        let entry = match self {
            Self::Dense(lu) => lu.entry(i, j),
            Self::Tridiagonal(lu) => lu.entry(i, j),
            Self::Banded(lu) => lu.entry(i, j),
            Self::Sparse(lu) => lu.entry(i, j),
        };
        if let Some(entry) = entry {
            *entry += x;
        }
    }

    /// Adds `x` to the diagonal of a matrix of order n that was assigned.
    pub(crate) fn shift(&mut self, n: usize, x: T) {
        match self {
            Self::Dense(lu) => lu.shift(x),
            Self::Tridiagonal(lu) => lu.shift(x),
            Self::Banded(_) | Self::Sparse(_) => (0..n).for_each(|i| self.add(i, i, x)),
        }
    }

    /// Factors the matrix that was assigned.
    pub(crate) fn decompose(&mut self) -> Result<(), FactorError> {
        match self {
            Self::Dense(lu) => lu.decompose(),
            Self::Tridiagonal(lu) => lu.decompose(),
            Self::Banded(lu) => lu.decompose(),
            Self::Sparse(lu) => lu.decompose(),
        }
    }

    /// [Factors](Self::decompose) two matrices, both assigned from one.
    pub(crate) fn decompose_both<U: Entry>(&mut self, other: &mut Lu<U>) -> Result<(), FactorError> {
        match (&mut *self, &mut *other) {
            (Self::Tridiagonal(a), Lu::Tridiagonal(b)) => a.decompose_both(b),
            _ => self.decompose().and_then(|()| other.decompose()),
        }
    }

    /// [Solves](Self::solve) with two matrices of one order.
    pub(crate) fn solve_both<U: Entry>(&mut self, b: &mut [T], other: &mut Lu<U>, c: &mut [U]) {
        match (&mut *self, &mut *other) {
            (Self::Tridiagonal(first), Lu::Tridiagonal(second)) => first.solve_both(b, second, c),
            _ => {
                self.solve(b);
                other.solve(c);
            }
        }
    }

    /// Factors a copy of `a`, which is stored as the matrix given to [`of`](Self::of).
    pub(crate) fn factor(&mut self, a: &Jacobian) -> Result<(), FactorError> {
        self.assign(a, T::from)?;
        self.decompose().map_err(|error| a.blame(error))
    }

    /// Overwrites `b` with the solution of A x = b.
    pub(crate) fn solve(&mut self, b: &mut [T]) {
        match self {
            Self::Dense(lu) => lu.solve(b),
            Self::Tridiagonal(lu) => lu.solve(b),
            Self::Banded(lu) => lu.solve(b),
            Self::Sparse(lu) => lu.solve(b),
        }
    }

    /// Overwrites `b` with the solution of Aᵀ x = b.
    pub(crate) fn solve_transpose(&mut self, b: &mut [T]) {
        match self {
            Self::Dense(lu) => lu.solve_transpose(b),
            Self::Tridiagonal(lu) => lu.solve_transpose(b),
            Self::Banded(lu) => lu.solve_transpose(b),
            Self::Sparse(lu) => lu.solve_transpose(b),
        }
    }
}

impl Lu {
    /// Entries stored for L and U, the diagonal counted once: as many products as a solve takes.
    fn entries(&self) -> usize {
        match self {
            Self::Dense(lu) => lu.entries(),
            Self::Tridiagonal(lu) => lu.entries(),
            Self::Banded(lu) => lu.entries(),
            Self::Sparse(lu) => lu.entries(),
        }
    }

    /// The sign of det A of the matrix that was factored last.
    pub(crate) fn sign(&self) -> f64 {
        match self {
            Self::Dense(lu) => lu.sign(),
            Self::Tridiagonal(lu) => lu.sign(),
            Self::Banded(lu) => lu.sign(),
            Self::Sparse(lu) => lu.sign(),
        }
    }
}

/// A matrix by its entries, whatever they are stored in.
pub(crate) trait Entrywise {
    /// Adds `x` to entry (i, j).
    fn add_entry(&mut self, i: usize, j: usize, x: f64);

    /// Shows every stored entry (i, j, x) to `visit`.
    fn visit(&self, visit: impl FnMut(usize, usize, f64));

    /// The first entry that was added where there is no room for it.
    fn outside(&self) -> Option<(usize, usize)> {
        None
    }

    /// Notes such an entry of a part of the matrix.
    fn set_outside(&mut self, _entry: Option<(usize, usize)>) {}
}

impl Entrywise for DMatrix<f64> {
    #[inline]
    fn add_entry(&mut self, i: usize, j: usize, x: f64) {
        self[(i, j)] += x;
    }

    fn visit(&self, mut visit: impl FnMut(usize, usize, f64)) {
        for (j, entries) in self.column_iter().enumerate() {
            entries.iter().enumerate().for_each(|(i, &x)| visit(i, j, x));
        }
    }
}

impl Entrywise for Jacobian {
    #[inline]
    fn add_entry(&mut self, i: usize, j: usize, x: f64) {
        self.add(i, j, x);
    }

    #[inline]
    fn visit(&self, visit: impl FnMut(usize, usize, f64)) {
        self.for_each(visit);
    }

    #[inline]
    fn outside(&self) -> Option<(usize, usize)> {
        self.outside()
    }

    #[inline]
    fn set_outside(&mut self, entry: Option<(usize, usize)>) {
        self.set_outside(entry);
    }
}

/// Adds `scale` times `block` to the entries of `out` from (row, column) on, and takes over an entry outside its structure.
pub(crate) fn add_block(out: &mut impl Entrywise, (row, column): (usize, usize), scale: f64, block: &impl Entrywise) {
    if scale != 0.0 {
        block.visit(|i, j, x| out.add_entry(row + i, column + j, scale * x));
    }
    out.set_outside(block.outside());
}

/// The sign of a determinant from the pivots and the number of exchanges of rows.
fn sign(pivots: impl Iterator<Item = f64>, exchanges: usize) -> f64 {
    let start = if exchanges.is_multiple_of(2) { 1.0 } else { -1.0 };
    pivots.fold(start, |sign: f64, pivot| sign * pivot.signum())
}

/// The power of two by which a row with the given largest entry is scaled to one in [1, 2).
#[inline]
fn row_scale(largest: f64) -> Result<f64, FactorError> {
    if largest == 0.0 || !largest.is_finite() {
        return Err(FactorError::Singular);
    }
    let exponent = largest.max(f64::MIN_POSITIVE).to_bits() & f64::INFINITY.to_bits();
    Ok(f64::from_bits(exponent).recip())
}

/// Whether the pivot, the last entry of its column of U, is more than the rounding of so many updates of its column by multipliers of
/// size ≤ 1. The scaled rows have entries of size 1; a column without any is that of an unknown in small units.
#[inline]
fn is_usable<T: Entry>(column: &[T], updates: usize) -> bool {
    let lost = updates as f64 * f64::EPSILON;
    column.last().is_some_and(|pivot| {
        let pivot = pivot.magnitude();
        // NaN is not usable.
        pivot > lost || column.iter().all(|u| pivot > lost * u.magnitude())
    })
}

/// Whether every component is zero. A sum of bits without their sign is found without a branch for each.
pub(crate) fn is_zero(v: &[f64]) -> bool {
    v.iter().fold(0, |bits, x| bits | x.to_bits() << 1) == 0
}

/// Largest absolute component; NaN if any component is NaN.
pub(crate) fn max_norm(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |m: f64, x| if x.abs() > m || x.is_nan() { x.abs() } else { m })
}

/// The larger of `most` and |x|; `most` if x is NaN.
#[inline(always)]
pub(crate) fn larger(most: f64, x: f64) -> f64 {
    if x.abs() > most { x.abs() } else { most }
}

#[cfg(test)]
mod tests;
