//! LU factors of sparse matrices. The order of elimination is found once; pivots are kept from one matrix to the next.

use std::fmt;
use std::mem::replace;
use std::ops::Range;
use std::sync::Arc;

use super::Sparse;
use super::columns::{Columns, short};
use super::order::{Permutation, by_columns, by_degree};
use super::reach::{NONE, Reach};
use crate::linalg::entry::Entry;
use crate::linalg::structure::Pattern;
use crate::linalg::{FactorError, is_usable, row_scale, sign};

/// P D A Q = L U with partial pivoting in rows, the columns ordered once for little fill.
///
/// Where most entries have a mirror image the unknowns are ordered by minimum degree (AMD), and the entry on the diagonal is the pivot while it
/// is [`STEADY`]: rows and columns are then eliminated together, which makes much less fill than an order of the columns (COLAMD) that has
/// to serve any pivots. UMFPACK chooses between the two in the same way (Davis, ACM Trans. Math. Softw. 30 (2004) 165); the factors of faer, whose
/// orders these are, prefer no diagonal.
///
/// Pivots are found column by column, from those entries that are not zero (Gilbert and Peierls, SIAM J. Sci. Stat. Comput. 9 (1988)
/// 862). The next matrix takes them over with the places of the entries, as long as they are steady, as KLU's refactorisation does (Davis and
/// Palamadai Natarajan, ACM Trans. Math. Softw. 37 (2010) 36).
///
/// Storage grows while pivoting finds more fill than before, then no more.
pub(crate) struct SparseLu<T: Entry = f64> {
    pattern: Arc<Pattern>,
    prefers_diagonal: bool,
    column_order: Permutation,
    row_order: Permutation,
    /// Exchanges that make up the order of the columns, and both orders together.
    column_exchanges: usize,
    exchanges: usize,
    scaled: Vec<T>,
    row_scale: Vec<f64>,
    /// Each column begins with its one; rows are in ascending order.
    lower: Columns<T>,
    /// Of each column of L: see [`Columns::alike`].
    alike: Vec<u8>,
    /// Each column ends with its pivot; rows are in ascending order.
    upper: Columns<T>,
    /// Zeros between calls.
    x: Vec<T>,
    reach: Reach,
    sorted: Vec<u32>,
}

/// A pivot that is smaller than the largest entry below it by more than this factor is not steady.
const STEADY: f64 = 0.1;

impl<T: Entry> fmt::Debug for SparseLu<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SparseLu").field("column_order", &self.column_order).finish_non_exhaustive()
    }
}

impl<T: Entry> SparseLu<T> {
    pub(in crate::linalg) fn new(a: &Sparse) -> Self {
        let pattern = Arc::clone(&a.pattern);
        let n = pattern.dim();
        let prefers_diagonal = pattern.is_mostly_symmetric();
        let column_order = if prefers_diagonal { by_degree(&pattern) } else { by_columns(&pattern) };
        let mut seen = vec![false; n];
        let column_exchanges = column_order.exchanges(&mut seen);
        Self {
            prefers_diagonal,
            column_order,
            row_order: Permutation::identity(n),
            column_exchanges,
            exchanges: column_exchanges,
            scaled: vec![T::from(0.0); pattern.entries()],
            row_scale: vec![0.0; n],
            lower: Columns::new(),
            alike: vec![1; n],
            upper: Columns::new(),
            x: vec![T::from(0.0); n],
            reach: Reach::new(n),
            sorted: Vec::with_capacity(n),
            pattern,
        }
    }

    /// The matrix of the images of the entries of `a`, to be factored.
    pub(in crate::linalg) fn assign(&mut self, a: &Sparse, image: impl Fn(f64) -> T) {
        self.scaled.iter_mut().zip(&a.values).for_each(|(x, a)| *x = image(*a));
    }

    pub(in crate::linalg) fn entry(&mut self, i: usize, j: usize) -> Option<&mut T> {
        self.pattern.index(i, j).map(|k| &mut self.scaled[k])
    }

    pub(in crate::linalg) fn decompose(&mut self) -> Result<(), FactorError> {
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
        let Self { pattern, column_order, row_order, scaled, lower, alike, upper, x, .. } = self;
        let zero = T::from(0.0);
        let column = column_order.forward[j];
        for (&i, &a) in pattern.column(column).iter().zip(&scaled[pattern.starts()[column]..]) {
            x[row_order.inverse[i]] = a;
        }
        let places = upper.range(j);
        let last = places.end - 1;
        let mut place = places.start;
        while place < last {
            // Where a column adds to j, so do those after it that are like it.
            place += lower.eliminate_alike(upper.row(place), alike, last - place, x);
        }
        for place in places.start..last {
            upper.values[place] = replace(&mut x[upper.row(place)], zero);
        }
        let pivot = replace(&mut x[j], zero);
        upper.values[last] = pivot;
        let mut is_steady = is_usable(&upper.values[places.clone()], places.len());
        for place in lower.range(j).skip(1) {
            let entry = replace(&mut x[lower.row(place)], zero);
            // NaN is not steady.
            is_steady &= STEADY * entry.magnitude() <= pivot.magnitude();
            lower.values[place] = entry / pivot;
        }
        is_steady
    }

    fn find_pivots(&mut self) -> Result<(), FactorError> {
        self.lower.clear();
        self.upper.clear();
        self.reach.ends.clear();
        self.row_order.inverse.fill(NONE);
        if !(0..self.pattern.dim()).all(|j| self.find_pivot(j)) {
            // What was found is not the factors of a matrix.
            self.upper.starts.clear();
            return Err(FactorError::Singular);
        }
        let Permutation { forward, inverse } = &mut self.row_order;
        inverse.iter().enumerate().for_each(|(row, &j)| forward[j] = row);
        self.lower.rows.iter_mut().for_each(|row| *row = short(inverse[*row as usize]));
        self.lower.sort(&mut self.x, &mut self.sorted);
        self.upper.sort(&mut self.x, &mut self.sorted);
        self.lower.alike(&mut self.alike);
        self.exchanges = self.column_exchanges + self.row_order.exchanges(&mut self.reach.seen);
        self.reach.seen.fill(false);
        Ok(())
    }

    /// Finds column `j` of L, by rows of A, and of U; false where there is no usable pivot.
    fn find_pivot(&mut self, j: usize) -> bool {
        let Self { pattern, column_order, row_order, scaled, lower, upper, x, reach, .. } = self;
        let (pivots, column) = (&mut row_order.inverse, column_order.forward[j]);
        for (&i, &a) in pattern.column(column).iter().zip(&scaled[pattern.starts()[column]..]) {
            x[i] = a;
            reach.add(i, pivots, lower);
        }
        let (mut pivot, mut largest) = (column, f64::NEG_INFINITY);
        for &i in reach.rows.iter().rev() {
            reach.seen[i] = false;
            if pivots[i] == NONE {
                let size = x[i].magnitude();
                // NaN stays the largest, and is not usable.
                if size > largest || size.is_nan() {
                    (pivot, largest) = (i, size);
                }
                continue;
            }
            let factor = replace(&mut x[i], T::from(0.0));
            upper.push(pivots[i], factor);
            let Range { start, end } = lower.range(pivots[i]);
            lower.subtract(start + 1..end, factor, x);
        }
        if self.prefers_diagonal && pivots[column] == NONE && STEADY * largest <= x[column].magnitude() {
            pivot = column;
        }
        let of_pivot = x[pivot];
        upper.push(j, of_pivot);
        lower.push(pivot, T::from(1.0));
        for i in reach.rows.drain(..) {
            let entry = replace(&mut x[i], T::from(0.0));
            if pivots[i] == NONE && i != pivot {
                lower.push(i, entry / of_pivot);
            }
        }
        pivots[pivot] = j;
        upper.end_column();
        lower.end_column();
        let Range { start, end } = upper.range(j);
        reach.prune(pivot, &upper.rows[start..end - 1], pivots, lower);
        let of_column = &upper.values[start..end];
        // Without a row that is left there is no pivot.
        largest >= 0.0 && is_usable(of_column, of_column.len())
    }

    /// Entries of L and of U after the last factorisation, the diagonal counted once.
    pub(in crate::linalg) fn entries(&self) -> usize {
        // L has its ones.
        self.lower.rows.len() + self.upper.rows.len() - self.pattern.dim()
    }

    pub(in crate::linalg) fn solve(&mut self, b: &mut [T]) {
        let Self { column_order, row_order, row_scale, lower, alike, upper, x, .. } = self;
        for ((b, s), &k) in b.iter().zip(row_scale).zip(&row_order.inverse) {
            x[k] = b.scaled(*s);
        }
        let mut j = 0;
        while j < x.len() {
            j += lower.eliminate_alike(j, alike, x.len() - j, x);
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

    pub(in crate::linalg) fn solve_transpose(&mut self, b: &mut [T]) {
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
    pub(in crate::linalg) fn sign(&self) -> f64 {
        let pivots = self.upper.starts.iter().skip(1).map(|end| self.upper.values[end - 1]);
        sign(pivots, self.exchanges)
    }
}
