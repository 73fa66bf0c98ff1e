//! Sparse matrices and their LU factors, the column ordering found once.

use std::fmt;
use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::perm::PermRef;
use faer::sparse::linalg::colamd;
use faer::sparse::linalg::lu::simplicial::{self, SimplicialLu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par};

use super::entry::Entry;
use super::structure::Pattern;
use super::{FactorError, row_scale};

/// A square sparse matrix with a fixed pattern.
#[derive(Debug, Clone)]
pub(super) struct Sparse {
    pattern: Arc<Pattern>,
    values: Vec<f64>,
    trail: Trail,
}

/// The places to which the last assembly added, one after the other: the next one mostly takes the same path, and need not search.
#[derive(Debug, Clone, Default)]
struct Trail {
    places: Vec<usize>,
    next: usize,
}

impl Trail {
    /// Additions that are remembered for each entry of a matrix; a path may be of any length.
    const MOST: usize = 16;

    fn place(&mut self, pattern: &Pattern, i: usize, j: usize) -> Option<usize> {
        let place = match self.places.get(self.next) {
            Some(&place) if pattern.is_place(place, i, j) => place,
            _ => self.leave(pattern, i, j)?,
        };
        self.next += 1;
        Some(place)
    }

    /// Searches, and changes the path.
    fn leave(&mut self, pattern: &Pattern, i: usize, j: usize) -> Option<usize> {
        let place = pattern.index(i, j)?;
        if self.next < self.places.len() {
            self.places[self.next] = place;
        } else if self.places.len() < Self::MOST * pattern.entries() {
            self.places.push(place);
        }
        Some(place)
    }
}

impl PartialEq for Sparse {
    fn eq(&self, other: &Self) -> bool {
        self.pattern == other.pattern && self.values == other.values
    }
}

impl Sparse {
    pub(super) fn zeros(pattern: Arc<Pattern>) -> Self {
        Self { values: vec![0.0; pattern.entries()], trail: Trail::default(), pattern }
    }

    pub(super) fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    pub(super) fn shared_pattern(&self) -> Arc<Pattern> {
        Arc::clone(&self.pattern)
    }

    pub(super) fn clear(&mut self) {
        self.values.fill(0.0);
        self.trail.next = 0;
    }

    #[inline]
    pub(super) fn get(&self, i: usize, j: usize) -> Option<f64> {
        self.pattern.index(i, j).map(|k| self.values[k])
    }

    /// The entry (i, j), to be added to.
    #[inline]
    pub(super) fn get_mut(&mut self, i: usize, j: usize) -> Option<&mut f64> {
        self.trail.place(&self.pattern, i, j).map(|k| &mut self.values[k])
    }

    /// The entries (i, x) of column `j`.
    #[inline]
    pub(super) fn column(&self, j: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let start = self.pattern.starts()[j];
        let rows = self.pattern.column(j);
        rows.iter().copied().zip(self.values[start..start + rows.len()].iter().copied())
    }
}

/// P D A Q = L U with the columns ordered once for little fill (COLAMD) and partial pivoting in rows.
///
/// Storage grows while pivoting finds more fill than before, then no more.
pub(crate) struct SparseLu<T: Entry = f64> {
    pattern: Arc<Pattern>,
    column_order: Permutation,
    row_order: Permutation,
    scaled: Vec<T>,
    row_scale: Vec<f64>,
    factors: SimplicialLu<usize, T>,
    scratch: MemBuffer,
}

#[derive(Debug)]
struct Permutation {
    forward: Vec<usize>,
    inverse: Vec<usize>,
}

impl Permutation {
    fn identity(dim: usize) -> Self {
        Self { forward: (0..dim).collect(), inverse: (0..dim).collect() }
    }

    fn as_ref(&self) -> PermRef<'_, usize> {
        PermRef::new_checked(&self.forward, &self.inverse, self.forward.len())
    }
}

impl<T: Entry> fmt::Debug for SparseLu<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SparseLu").field("column_order", &self.column_order).finish_non_exhaustive()
    }
}

fn symbolic(pattern: &Pattern) -> SymbolicSparseColMatRef<'_, usize> {
    let n = pattern.dim();
    SymbolicSparseColMatRef::new_checked(n, n, pattern.starts(), None, pattern.rows())
}

impl<T: Entry> SparseLu<T> {
    pub(super) fn new(a: &Sparse) -> Self {
        let pattern = Arc::clone(&a.pattern);
        let n = pattern.dim();
        let mut column_order = Permutation::identity(n);
        let mut scratch = MemBuffer::new(colamd::order_scratch::<usize>(n, n, pattern.entries()));
        let (forward, inverse) = (&mut column_order.forward, &mut column_order.inverse);
        let stack = MemStack::new(&mut scratch);
        if colamd::order(forward, inverse, symbolic(&pattern), Default::default(), stack).is_err() {
            // The order decides the fill only.
            column_order = Permutation::identity(n);
        }
        let requirement = StackReq::any_of(&[
            simplicial::factorize_simplicial_numeric_lu_scratch::<usize, T>(n, n),
            simplicial::solve_in_place_scratch::<usize, T>(n, 1, Par::Seq),
            simplicial::solve_transpose_in_place_scratch::<usize, T>(n, 1, Par::Seq),
        ]);
        Self {
            column_order,
            row_order: Permutation::identity(n),
            scaled: vec![T::from(0.0); pattern.entries()],
            row_scale: vec![0.0; n],
            factors: SimplicialLu::new(),
            scratch: MemBuffer::new(requirement),
            pattern,
        }
    }

    /// The matrix of the images of the entries of `a`, to be factored.
    pub(super) fn assign(&mut self, a: &Sparse, image: impl Fn(f64) -> T) {
        self.scaled.iter_mut().zip(&a.values).for_each(|(x, a)| *x = image(*a));
    }

    pub(super) fn entry(&mut self, i: usize, j: usize) -> Option<&mut T> {
        self.pattern.index(i, j).map(|k| &mut self.scaled[k])
    }

    pub(super) fn decompose(&mut self) -> Result<(), FactorError> {
        self.row_scale.fill(0.0);
        for (&i, x) in self.pattern.rows().iter().zip(&self.scaled) {
            let (largest, x) = (self.row_scale[i], x.magnitude());
            self.row_scale[i] = if x.is_nan() { f64::INFINITY } else { largest.max(x) };
        }
        for s in &mut self.row_scale {
            *s = row_scale(*s)?;
        }
        for (x, &i) in self.scaled.iter_mut().zip(self.pattern.rows()) {
            *x = x.scaled(self.row_scale[i]);
        }
        simplicial::factorize_simplicial_numeric_lu(
            &mut self.row_order.forward,
            &mut self.row_order.inverse,
            &mut self.factors,
            SparseColMatRef::new(symbolic(&self.pattern), &self.scaled),
            self.column_order.as_ref(),
            MemStack::new(&mut self.scratch),
        )
        .map_err(|_| FactorError::Singular)?;
        let u = self.factors.u_factor_unsorted();
        let usable = (0..self.pattern.dim()).all(|j| {
            // The pivot comes last in its column, after as many updates as there are entries above it.
            let column = u.val_of_col(j);
            column.last().is_some_and(|pivot| pivot.magnitude() > column.len() as f64 * f64::EPSILON)
        });
        if usable { Ok(()) } else { Err(FactorError::Singular) }
    }

    /// Entries of L and of U after the last factorisation, the diagonal counted once.
    pub(super) fn entries(&self) -> usize {
        let (l, u) = (self.factors.l_factor_unsorted(), self.factors.u_factor_unsorted());
        // L has its ones.
        l.compute_nnz() + u.compute_nnz() - self.pattern.dim()
    }

    pub(super) fn solve(&mut self, b: &mut [T]) {
        for (x, s) in b.iter_mut().zip(&self.row_scale) {
            *x = x.scaled(*s);
        }
        self.factors.solve_in_place_with_conj(
            self.row_order.as_ref(),
            self.column_order.as_ref(),
            Conj::No,
            MatMut::from_column_major_slice_mut(b, self.pattern.dim(), 1),
            Par::Seq,
            MemStack::new(&mut self.scratch),
        );
    }

    pub(super) fn solve_transpose(&mut self, b: &mut [T]) {
        self.factors.solve_transpose_in_place_with_conj(
            self.row_order.as_ref(),
            self.column_order.as_ref(),
            Conj::No,
            MatMut::from_column_major_slice_mut(b, self.pattern.dim(), 1),
            Par::Seq,
            MemStack::new(&mut self.scratch),
        );
        for (x, s) in b.iter_mut().zip(&self.row_scale) {
            *x = x.scaled(*s);
        }
    }
}
