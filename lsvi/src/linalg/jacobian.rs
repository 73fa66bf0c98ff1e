//! A square matrix of derivatives in the storage that its structure asks for.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::banded::Band;
use super::sparse::Sparse;
use super::structure::{Pattern, Structure};
use super::{Cholesky, FactorError, Lu};
use crate::error::{InputError, SolveError, SystemError, check_length};

/// A square matrix of derivatives, ∂F_i/∂x_j.
///
/// Fields and Lagrangians add their entries to it; what it is stored as is its own business.
#[derive(Debug, Clone, PartialEq)]
pub struct Jacobian {
    entries: Entries,
    /// The first entry that was added where the structure has none.
    outside: Option<(usize, usize)>,
    /// Whether the matrix is not known by its entries, so that it cannot be factored.
    is_missing: bool,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Entries {
    Dense(DMatrix<f64>),
    Banded(Band),
    Sparse(Sparse),
}

impl Jacobian {
    /// The dense zero matrix of order `dim`.
    pub fn zeros(dim: usize) -> Self {
        Self { entries: Entries::Dense(DMatrix::zeros(dim, dim)), outside: None, is_missing: false }
    }

    /// The zero matrix of order `dim` with room for the entries of `structure`, as far as they lie in the matrix.
    pub fn with_structure(dim: usize, structure: &Structure) -> Self {
        let entries = match structure {
            Structure::Dense => return Self::zeros(dim),
            Structure::Banded { lower, upper } => Entries::Banded(Band::zeros(dim, *lower, *upper)),
            Structure::Sparse(pattern) if pattern.dim() == dim => Entries::Sparse(Sparse::zeros(Arc::clone(pattern))),
            // The positions inside the matrix; of a matrix-free one there are none but the diagonal.
            Structure::Sparse(_) | Structure::MatrixFree => {
                let inside = (0..dim).flat_map(|j| structure.rows(dim, j).map(move |i| (i, j)));
                let pattern = Pattern::new(dim, inside).expect("all positions are below dim");
                Entries::Sparse(Sparse::zeros(pattern.into()))
            }
        };
        Self { entries, outside: None, is_missing: *structure == Structure::MatrixFree }
    }

    /// Order of the matrix.
    pub fn dim(&self) -> usize {
        match &self.entries {
            Entries::Dense(a) => a.nrows(),
            Entries::Banded(a) => a.dim(),
            Entries::Sparse(a) => a.pattern().dim(),
        }
    }

    /// Where the matrix has room for entries.
    pub(crate) fn structure(&self) -> Structure {
        match &self.entries {
            _ if self.is_missing => Structure::MatrixFree,
            Entries::Dense(_) => Structure::Dense,
            Entries::Banded(a) => a.structure(),
            Entries::Sparse(a) => Structure::Sparse(a.shared_pattern()),
        }
    }

    /// Sets every entry to zero.
    pub fn clear(&mut self) {
        self.outside = None;
        self.values_mut().fill(0.0);
        if let Entries::Sparse(a) = &mut self.entries {
            a.start_again();
        }
    }

    /// [`clear`](Self::clear) of a matrix that may be dense and of order N.
    #[inline(always)]
    pub(crate) fn clear_sized<const N: usize>(&mut self) {
        match &mut self.entries {
            Entries::Dense(a) if a.len() == N * N => {
                self.outside = None;
                a.as_mut_slice()[..N * N].fill(0.0);
            }
            _ => self.clear(),
        }
    }

    /// Adds `x` to entry (i, j).
    ///
    /// Where the structure has no such entry, a nonzero `x` spoils the matrix: solving with it fails with
    /// [`SolveError::OutsideStructure`](crate::SolveError::OutsideStructure).
    #[inline]
    pub fn add(&mut self, i: usize, j: usize, x: f64) {
        match &mut self.entries {
            Entries::Dense(a) if i < a.nrows() && j < a.ncols() => a[(i, j)] += x,
            Entries::Banded(a) => match a.get_mut(i, j) {
                Some(entry) => *entry += x,
                None => self.add_in_structure(i, j, x),
            },
            Entries::Sparse(a) => match a.next_mut(i, j) {
                Some(entry) => *entry += x,
                None => self.add_in_structure(i, j, x),
            },
            Entries::Dense(_) => self.add_in_structure(i, j, x),
        }
    }

    /// [`add`](Self::add) where the place of an entry is not at hand; apart, so that additions where it is are short.
    fn add_in_structure(&mut self, i: usize, j: usize, x: f64) {
        let entry = match &mut self.entries {
            Entries::Dense(a) => a.get_mut((i, j)),
            Entries::Banded(a) => a.get_mut(i, j),
            Entries::Sparse(a) => a.get_mut(i, j),
        };
        match entry {
            Some(entry) => *entry += x,
            None if x != 0.0 && self.outside.is_none() => self.outside = Some((i, j)),
            None => {}
        }
    }

    /// Entry (i, j); zero where the structure has none.
    pub fn get(&self, i: usize, j: usize) -> f64 {
        match &self.entries {
            Entries::Dense(a) => a.get((i, j)).copied(),
            Entries::Banded(a) => a.get(i, j),
            Entries::Sparse(a) => a.get(i, j),
        }
        .unwrap_or(0.0)
    }

    /// The entries of the LU factors with which a step would solve for this matrix, nnz(L + U): their storage, and the products
    /// that a solution takes. Rows are exchanged, and the columns of a sparse matrix ordered for little fill (COLAMD).
    ///
    /// It factors the matrix, to be thrown away.
    ///
    /// # Errors
    /// [`SolveError::Singular`] without usable factors; [`SolveError::OutsideStructure`], [`SolveError::NotAssembled`].
    ///
    /// ```
    /// use lsvi::{Jacobian, Structure};
    ///
    /// // Elimination in a ring joins the two neighbours of every unknown, until three are left.
    /// let n = 12;
    /// let neighbours = (0..n).flat_map(|i| [(i, (i + 1) % n), ((i + 1) % n, i)]);
    /// let structure = Structure::sparse(n, neighbours)?;
    /// let mut a = Jacobian::with_structure(n, &structure);
    /// for i in 0..n {
    ///     a.add(i, i, 4.0);
    ///     a.add(i, (i + 1) % n, -1.0);
    ///     a.add((i + 1) % n, i, -1.0);
    /// }
    /// assert_eq!(a.factor_entries()?, 3 * n + 2 * (n - 3));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn factor_entries(&self) -> Result<usize, SolveError> {
        let mut lu = Lu::of(self);
        lu.factor(self)?;
        Ok(lu.entries())
    }

    /// A copy as a dense matrix.
    pub fn to_dense(&self) -> DMatrix<f64> {
        let mut dense = DMatrix::zeros(self.dim(), self.dim());
        self.for_each(|i, j, x| dense[(i, j)] = x);
        dense
    }

    /// The entries of a dense matrix, column by column.
    #[inline]
    pub(crate) fn dense_mut(&mut self) -> Option<&mut [f64]> {
        match &mut self.entries {
            Entries::Dense(a) => Some(a.as_mut_slice()),
            _ => None,
        }
    }

    /// The entries of a dense matrix.
    #[inline]
    pub(crate) fn dense(&self) -> Option<&DMatrix<f64>> {
        match &self.entries {
            Entries::Dense(a) => Some(a),
            _ => None,
        }
    }

    pub(super) fn entries(&self) -> &Entries {
        &self.entries
    }

    pub(super) fn entries_mut(&mut self) -> &mut Entries {
        &mut self.entries
    }

    /// The stored values, in an order that the structure alone determines.
    pub(super) fn values(&self) -> &[f64] {
        match &self.entries {
            Entries::Dense(a) => a.as_slice(),
            Entries::Banded(a) => a.values(),
            Entries::Sparse(a) => a.values(),
        }
    }

    /// Shows every stored entry (i, j) to `visit`, with its place among the [`values`](Self::values).
    pub(super) fn for_each_place(&self, mut visit: impl FnMut(usize, usize, usize)) {
        let n = self.dim();
        for j in 0..n {
            match &self.entries {
                Entries::Dense(_) => (0..n).for_each(|i| visit(i, j, i + j * n)),
                Entries::Banded(a) => {
                    let (rows, places) = a.places(j);
                    rows.zip(places).for_each(|(i, place)| visit(i, j, place));
                }
                Entries::Sparse(a) => {
                    let pattern = a.pattern();
                    pattern.column(j).iter().zip(pattern.starts()[j]..).for_each(|(&i, place)| visit(i, j, place));
                }
            }
        }
    }

    /// Notes that what was to be added has no entries.
    pub(crate) fn set_missing(&mut self) {
        self.is_missing = true;
    }

    /// Refuses a matrix that was given an entry outside its structure, or is not known by its entries.
    #[inline]
    pub(crate) fn check_structure(&self) -> Result<(), FactorError> {
        if self.is_missing {
            return Err(FactorError::NotAssembled);
        }
        self.outside.map_or(Ok(()), |(row, column)| Err(FactorError::OutsideStructure { row, column }))
    }

    /// The first entry that is not finite.
    pub(crate) fn non_finite(&self) -> Option<(usize, usize)> {
        let mut found = None;
        self.for_each(|i, j, x| {
            if !x.is_finite() {
                found.get_or_insert((i, j));
            }
        });
        found
    }

    /// Why the matrix has no factors: what elimination takes for singular may not be finite.
    pub(crate) fn blame(&self, error: FactorError) -> FactorError {
        match (error, self.non_finite()) {
            (FactorError::Singular, Some((row, column))) => FactorError::NonFinite { row, column },
            _ => error,
        }
    }

    /// The first entry that was added where the structure has none.
    pub(crate) fn outside(&self) -> Option<(usize, usize)> {
        self.outside
    }

    /// Notes an entry that a part of the matrix was given outside its structure.
    pub(super) fn set_outside(&mut self, entry: Option<(usize, usize)>) {
        self.outside = self.outside.or(entry);
    }

    /// Adds `scale` AᵀB.
    pub(crate) fn add_product_tr(&mut self, scale: f64, a: &DMatrix<f64>, b: &DMatrix<f64>) {
        match &mut self.entries {
            Entries::Dense(out) if out.shape() == (a.ncols(), b.ncols()) => out.gemm_tr(scale, a, b, 1.0),
            _ => {
                for (j, b) in b.column_iter().enumerate() {
                    a.column_iter().enumerate().for_each(|(i, a)| self.add(i, j, scale * a.dot(&b)));
                }
            }
        }
    }

    /// Becomes Σ c_k A_k of matrices of the same structure.
    pub(crate) fn set_sum<const N: usize>(&mut self, c: [f64; N], a: &[Self; N]) {
        self.outside = a.iter().find_map(Self::outside);
        let terms = a.each_ref().map(Self::values);
        for (k, x) in self.values_mut().iter_mut().enumerate() {
            *x = terms.iter().zip(c).map(|(values, c)| c * values[k]).sum();
        }
    }

    /// Adds `scale` times `other`, of the same order.
    pub(crate) fn add_scaled(&mut self, scale: f64, other: &Self) {
        match (&mut self.entries, &other.entries) {
            // The same places: nothing is looked up.
            (Entries::Sparse(a), Entries::Sparse(b)) if a.shares_pattern(b) => {
                a.values_mut().iter_mut().zip(b.values()).for_each(|(a, b)| *a += scale * b);
            }
            _ => other.for_each(|i, j, x| self.add(i, j, scale * x)),
        }
    }

    fn values_mut(&mut self) -> &mut [f64] {
        match &mut self.entries {
            Entries::Dense(a) => a.as_mut_slice(),
            Entries::Banded(a) => a.values_mut(),
            Entries::Sparse(a) => a.values_mut(),
        }
    }

    /// Takes over from `other`, whose entries were added, that it was given one outside its structure.
    pub(crate) fn inherit_outside(&mut self, other: &Self) {
        self.set_outside(other.outside);
    }

    /// Shows every stored entry (i, j, x) to `visit`, column by column.
    #[inline]
    pub(crate) fn for_each(&self, mut visit: impl FnMut(usize, usize, f64)) {
        match &self.entries {
            Entries::Dense(a) => {
                for (j, column) in a.column_iter().enumerate() {
                    column.iter().enumerate().for_each(|(i, &x)| visit(i, j, x));
                }
            }
            Entries::Banded(a) => (0..a.dim()).for_each(|j| a.column(j).for_each(|(i, x)| visit(i, j, x))),
            Entries::Sparse(a) => (0..a.pattern().dim()).for_each(|j| a.column(j).for_each(|(i, x)| visit(i, j, x))),
        }
    }

    /// The factors of a symmetric positive definite matrix; refuses any other.
    pub(crate) fn cholesky(&self) -> Result<Cholesky, InputError> {
        let mut asymmetric = None;
        self.for_each(|i, j, a| {
            let b = self.get(j, i);
            // Symmetric to rounding: a product such as M⁻¹ need not be so to the last bit.
            let tolerance = 8.0 * f64::EPSILON * (self.get(i, i).abs() + self.get(j, j).abs());
            let symmetric = (a - b).abs() <= tolerance;
            if !symmetric {
                asymmetric = Some(format!("entries ({i}, {j}) and its mirror image are {a} and {b}"));
            }
        });
        if let Some(what) = asymmetric {
            return Err(InputError::System(SystemError::Metric(what)));
        }
        Cholesky::new(self).ok_or_else(|| InputError::System(SystemError::Metric("it has no Cholesky factor".into())))
    }

    /// Adds `scale` A x to `out`.
    pub(crate) fn mul_add(&self, scale: f64, x: &[f64], out: &mut [f64]) {
        self.for_each(|i, j, a| out[i] += scale * a * x[j]);
    }

    /// Adds `scale` Aᵀ x to `out`.
    pub(crate) fn mul_transpose_add(&self, scale: f64, x: &[f64], out: &mut [f64]) {
        // In one sum for each column.
        match &self.entries {
            Entries::Dense(matrix) => {
                for (out, column) in out.iter_mut().zip(matrix.as_slice().chunks_exact(matrix.nrows().max(1))) {
                    *out = column.iter().zip(x).fold(*out, |sum, (a, x)| sum + scale * a * x);
                }
            }
            Entries::Sparse(matrix) => {
                for (j, out) in out.iter_mut().enumerate() {
                    *out = matrix.column(j).fold(*out, |sum, (i, a)| sum + scale * a * x[i]);
                }
            }
            Entries::Banded(_) => self.for_each(|i, j, a| out[j] += scale * a * x[i]),
        }
    }
}

impl TryFrom<DMatrix<f64>> for Jacobian {
    type Error = InputError;

    /// The dense matrix `a`; [`SystemError::Dimension`] unless it is square.
    fn try_from(a: DMatrix<f64>) -> Result<Self, InputError> {
        check_length("columns of the matrix", a.ncols(), a.nrows())?;
        Ok(Self { entries: Entries::Dense(a), outside: None, is_missing: false })
    }
}
