//! Sparse matrices and their LU factors. The order of the columns is found once; pivots are kept from one matrix to the next.

use std::fmt;
use std::mem::replace;
use std::ops::Range;
use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::perm::PermRef;
use faer::sparse::linalg::colamd;
use faer::sparse::linalg::lu::simplicial::{self, SimplicialLu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};

use super::entry::Entry;
use super::structure::Pattern;
use super::{FactorError, is_usable, row_scale};

/// A square sparse matrix with a fixed pattern.
#[derive(Debug, Clone)]
pub(super) struct Sparse {
    pattern: Arc<Pattern>,
    values: Vec<f64>,
    trail: Trail,
}

/// The additions of the last assembly, one after the other: the next one mostly takes the same path, and need not search.
#[derive(Debug, Clone, Default)]
struct Trail {
    steps: Vec<Step>,
    next: usize,
}

/// An addition to an entry, and the place of its value.
#[derive(Debug, Clone, Copy)]
struct Step {
    row: usize,
    column: usize,
    place: usize,
}

impl Trail {
    /// Additions that are remembered for each entry of a matrix; a path may be of any length.
    const MOST: usize = 16;

    #[inline]
    fn place(&mut self, pattern: &Pattern, row: usize, column: usize) -> Option<usize> {
        let place = match self.steps.get(self.next) {
            Some(step) if step.row == row && step.column == column => step.place,
            _ => self.leave(pattern, row, column)?,
        };
        self.next += 1;
        Some(place)
    }

    /// Searches, and changes the path.
    fn leave(&mut self, pattern: &Pattern, row: usize, column: usize) -> Option<usize> {
        let place = pattern.index(row, column)?;
        let step = Step { row, column, place };
        if self.next < self.steps.len() {
            self.steps[self.next] = step;
        } else if self.steps.len() < Self::MOST * pattern.entries() {
            self.steps.push(step);
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

    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    pub(super) fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// An assembly begins, along the path of the last one.
    pub(super) fn start_again(&mut self) {
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
/// faer finds pivots, and with them the places of the entries; half of its time goes there. The next matrix takes both over,
/// as long as its pivots are [`STEADY`], as KLU's refactorisation does (Davis and Palamadai Natarajan, ACM Trans. Math. Softw. 37
/// (2010) 36).
///
/// Storage grows while pivoting finds more fill than before, then no more.
pub(crate) struct SparseLu<T: Entry = f64> {
    pattern: Arc<Pattern>,
    column_order: Permutation,
    row_order: Permutation,
    /// Exchanges that lead from the order of the columns to that of the rows.
    exchanges: usize,
    scaled: Vec<T>,
    row_scale: Vec<f64>,
    search: SimplicialLu<usize, T>,
    scratch: MemBuffer,
    /// Each column begins with its one.
    lower: Columns<T>,
    /// Each column ends with its pivot, after the others in an order in which they may be eliminated.
    upper: Columns<T>,
    /// Zeros between calls.
    x: Vec<T>,
    seen: Vec<bool>,
}

/// A pivot that is smaller than the largest entry below it by more than this factor is not taken over.
const STEADY: f64 = 0.1;

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

    /// So many exchanges of two lead from it to another one: one less than each cycle has members.
    fn exchanges_to(&self, other: &Self, seen: &mut [bool]) -> usize {
        let mut exchanges = 0;
        seen.fill(false);
        for first in 0..seen.len() {
            let mut k = first;
            while !replace(&mut seen[k], true) {
                k = other.forward[self.inverse[k]];
                exchanges += usize::from(k != first);
            }
        }
        exchanges
    }
}

/// The columns of a triangular matrix, one after the other.
struct Columns<T> {
    starts: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<T>,
}

impl<T: Entry> Columns<T> {
    fn new() -> Self {
        Self { starts: Vec::new(), rows: Vec::new(), values: Vec::new() }
    }

    fn copy(&mut self, from: SparseColMatRef<'_, usize, T>) {
        self.rows.clear();
        self.values.clear();
        for j in 0..from.ncols() {
            self.rows.extend_from_slice(from.row_idx_of_col_raw(j));
            self.values.extend_from_slice(from.val_of_col(j));
        }
        self.starts.clear();
        self.starts.extend_from_slice(from.col_ptr());
    }

    fn range(&self, j: usize) -> Range<usize> {
        self.starts[j]..self.starts[j + 1]
    }

    /// Subtracts `factor` times the entries in `range` from `x`.
    #[inline]
    fn subtract(&self, range: Range<usize>, factor: T, x: &mut [T]) {
        for (&i, &entry) in self.rows[range.clone()].iter().zip(&self.values[range]) {
            x[i] -= entry * factor;
        }
    }

    /// The product of the entries in `range` with those of `x`.
    #[inline]
    fn product(&self, range: Range<usize>, x: &[T]) -> T {
        self.rows[range.clone()].iter().zip(&self.values[range]).map(|(&i, &entry)| entry * x[i]).sum()
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
        Self {
            column_order,
            row_order: Permutation::identity(n),
            exchanges: 0,
            scaled: vec![T::from(0.0); pattern.entries()],
            row_scale: vec![0.0; n],
            search: SimplicialLu::new(),
            scratch: MemBuffer::new(simplicial::factorize_simplicial_numeric_lu_scratch::<usize, T>(n, n)),
            lower: Columns::new(),
            upper: Columns::new(),
            x: vec![T::from(0.0); n],
            seen: vec![false; n],
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
        let takes_over = !self.upper.starts.is_empty() && (0..self.pattern.dim()).all(|j| self.eliminate(j));
        if takes_over { Ok(()) } else { self.find_pivots() }
    }

    /// Finds the entries of column `j` of L and U at the places of the last matrix; false where its pivot is not steady.
    fn eliminate(&mut self, j: usize) -> bool {
        let Self { pattern, column_order, row_order, scaled, lower, upper, x, .. } = self;
        let zero = T::from(0.0);
        let column = column_order.forward[j];
        for (&i, &a) in pattern.column(column).iter().zip(&scaled[pattern.starts()[column]..]) {
            x[row_order.inverse[i]] = a;
        }
        let places = upper.range(j);
        let last = places.end - 1;
        for place in places.start..last {
            let k = upper.rows[place];
            let factor = replace(&mut x[k], zero);
            upper.values[place] = factor;
            let Range { start, end } = lower.range(k);
            lower.subtract(start + 1..end, factor, x);
        }
        let pivot = replace(&mut x[j], zero);
        upper.values[last] = pivot;
        let mut is_steady = is_usable(&upper.values[places.clone()], places.len());
        for place in lower.range(j).skip(1) {
            let entry = replace(&mut x[lower.rows[place]], zero);
            // NaN is not steady.
            is_steady &= STEADY * entry.magnitude() <= pivot.magnitude();
            lower.values[place] = entry / pivot;
        }
        is_steady
    }

    fn find_pivots(&mut self) -> Result<(), FactorError> {
        // What was kept is not the factors of this matrix.
        self.upper.starts.clear();
        simplicial::factorize_simplicial_numeric_lu(
            &mut self.row_order.forward,
            &mut self.row_order.inverse,
            &mut self.search,
            SparseColMatRef::new(symbolic(&self.pattern), &self.scaled),
            self.column_order.as_ref(),
            MemStack::new(&mut self.scratch),
        )
        .map_err(|_| FactorError::Singular)?;
        let u = self.search.u_factor_unsorted();
        let usable = (0..self.pattern.dim()).all(|j| {
            let column = u.val_of_col(j);
            is_usable(column, column.len())
        });
        if !usable {
            return Err(FactorError::Singular);
        }
        self.upper.copy(u);
        self.lower.copy(self.search.l_factor_unsorted());
        self.exchanges = self.column_order.exchanges_to(&self.row_order, &mut self.seen);
        Ok(())
    }

    /// Entries of L and of U after the last factorisation, the diagonal counted once.
    pub(super) fn entries(&self) -> usize {
        // L has its ones.
        self.lower.rows.len() + self.upper.rows.len() - self.pattern.dim()
    }

    pub(super) fn solve(&mut self, b: &mut [T]) {
        let Self { column_order, row_order, row_scale, lower, upper, x, .. } = self;
        for ((b, s), &k) in b.iter().zip(row_scale).zip(&row_order.inverse) {
            x[k] = b.scaled(*s);
        }
        for j in 0..x.len() {
            let Range { start, end } = lower.range(j);
            lower.subtract(start + 1..end, x[j], x);
        }
        for j in (0..x.len()).rev() {
            let Range { start, end } = upper.range(j);
            x[j] /= upper.values[end - 1];
            upper.subtract(start..end - 1, x[j], x);
        }
        for (x, &j) in x.iter_mut().zip(&column_order.forward) {
            b[j] = replace(x, T::from(0.0));
        }
    }

    pub(super) fn solve_transpose(&mut self, b: &mut [T]) {
        let Self { column_order, row_order, row_scale, lower, upper, x, .. } = self;
        for (x, &j) in x.iter_mut().zip(&column_order.forward) {
            *x = b[j];
        }
        for j in 0..x.len() {
            let Range { start, end } = upper.range(j);
            x[j] = (x[j] - upper.product(start..end - 1, x)) / upper.values[end - 1];
        }
        for j in (0..x.len()).rev() {
            let Range { start, end } = lower.range(j);
            let known = lower.product(start + 1..end, x);
            x[j] -= known;
        }
        for ((b, s), &k) in b.iter_mut().zip(row_scale).zip(&row_order.inverse) {
            *b = replace(&mut x[k], T::from(0.0)).scaled(*s);
        }
    }
}

impl SparseLu {
    pub(super) fn sign(&self) -> f64 {
        let pivots = self.upper.starts.iter().skip(1).map(|end| self.upper.values[end - 1]);
        super::sign(pivots, self.exchanges)
    }
}
