//! Sparse matrices and their LU factors: what is found for one matrix of a pattern, its places, order and fill, serves the next.

use std::fmt;
use std::mem::replace;
use std::ops::Range;
use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::colamd;

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
/// Columns are eliminated one after the other (Gilbert and Peierls, SIAM J. Sci. Stat. Comput. 9 (1988) 862–874). Where entries of the
/// factors come to lie is searched for where the pivots are others than those of the last matrix, and stands up to there.
///
/// Storage grows while pivoting finds more fill than before, then no more.
pub(crate) struct SparseLu<T: Entry = f64> {
    pattern: Arc<Pattern>,
    /// The columns of A in the order of their elimination.
    columns: Vec<usize>,
    /// When the row of A became that of a pivot; the order of A where it did not.
    eliminated: Vec<usize>,
    scaled: Vec<T>,
    row_scale: Vec<f64>,
    /// Columns of L below its ones, by rows of A; each begins with its pivot, of which the inverse is stored.
    lower: Factor<T>,
    /// Columns of U above its pivots, in the order in which those of L are subtracted.
    upper: Factor<T>,
    search: Search,
    /// A column in the course of its elimination, by rows of A; zeros before and after. A solution, in the order of the columns.
    x: Vec<T>,
}

/// Sparse columns, one after the other.
#[derive(Debug)]
struct Factor<T> {
    starts: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<T>,
}

impl<T: Entry> Factor<T> {
    fn new() -> Self {
        Self { starts: vec![0], rows: Vec::new(), values: Vec::new() }
    }

    fn columns(&self) -> usize {
        self.starts.len() - 1
    }

    fn range(&self, j: usize) -> Range<usize> {
        self.starts[j]..self.starts[j + 1]
    }

    #[inline]
    fn column(&self, j: usize) -> (&[usize], &[T]) {
        (&self.rows[self.range(j)], &self.values[self.range(j)])
    }

    #[inline]
    fn column_mut(&mut self, j: usize) -> (&mut [usize], &mut [T]) {
        let range = self.range(j);
        (&mut self.rows[range.clone()], &mut self.values[range])
    }

    /// Ends a column whose rows have been appended.
    fn end_column(&mut self) {
        self.starts.push(self.rows.len());
        self.values.resize(self.rows.len(), T::from(0.0));
    }

    fn truncate(&mut self, columns: usize) {
        self.starts.truncate(columns + 1);
        self.rows.truncate(self.starts[columns]);
        self.values.truncate(self.starts[columns]);
    }
}

/// Work space of a depth-first search.
#[derive(Debug)]
struct Search {
    /// In which search a row was met last.
    met: Vec<usize>,
    count: usize,
    /// Rows on the way, each with the places of its column of L that are still to be looked at.
    way: Vec<(usize, Range<usize>)>,
    /// Rows that are done with, each after all that it leads to.
    done: Vec<usize>,
}

impl<T: Entry> fmt::Debug for SparseLu<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SparseLu").field("columns", &self.columns).finish_non_exhaustive()
    }
}

/// An order of the columns that makes little fill whatever the pivots are; it decides nothing else.
fn order(pattern: &Pattern) -> Vec<usize> {
    let n = pattern.dim();
    let columns = || (0..n).collect::<Vec<_>>();
    let (mut forward, mut inverse) = (columns(), columns());
    let mut scratch = MemBuffer::new(colamd::order_scratch::<usize>(n, n, pattern.entries()));
    let symbolic = SymbolicSparseColMatRef::new_checked(n, n, pattern.starts(), None, pattern.rows());
    let stack = MemStack::new(&mut scratch);
    let ordered = colamd::order(&mut forward, &mut inverse, symbolic, Default::default(), stack);
    if ordered.is_ok() { forward } else { columns() }
}

impl<T: Entry> SparseLu<T> {
    pub(super) fn new(a: &Sparse) -> Self {
        let pattern = Arc::clone(&a.pattern);
        let n = pattern.dim();
        Self {
            columns: order(&pattern),
            eliminated: vec![n; n],
            scaled: vec![T::from(0.0); pattern.entries()],
            row_scale: vec![0.0; n],
            lower: Factor::new(),
            upper: Factor::new(),
            search: Search { met: vec![0; n], count: 0, way: Vec::with_capacity(n), done: Vec::with_capacity(n) },
            x: vec![T::from(0.0); n],
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
        self.x.fill(T::from(0.0));
        (0..self.pattern.dim()).try_for_each(|j| {
            if j == self.lower.columns() {
                self.find_places(j);
            }
            self.eliminate(j).inspect_err(|_| self.forget(j))
        })
    }

    /// Appends to L and U the places of column `j`: what its rows in A lead to through the columns of L before.
    fn find_places(&mut self, j: usize) {
        let Self { pattern, columns, eliminated, lower, upper, search, .. } = self;
        let Search { met, count, way, done } = search;
        *count += 1;
        let below = |row: usize| match eliminated[row] {
            k if k < j => lower.starts[k] + 1..lower.starts[k + 1],
            _ => 0..0,
        };
        for &row in pattern.column(columns[j]) {
            if replace(&mut met[row], *count) != *count {
                way.push((row, below(row)));
            }
            while let Some((row, places)) = way.last_mut() {
                match places.map(|place| lower.rows[place]).find(|row| met[*row] != *count) {
                    Some(row) => {
                        met[row] = *count;
                        way.push((row, below(row)));
                    }
                    None => {
                        done.push(*row);
                        way.pop();
                    }
                }
            }
        }
        for row in done.drain(..).rev() {
            match eliminated[row] {
                k if k < j => upper.rows.push(k),
                _ => lower.rows.push(row),
            }
        }
        lower.end_column();
        upper.end_column();
    }

    /// Finds the entries of column `j` of L and U at their places; forgets those of later columns if they do not follow.
    fn eliminate(&mut self, j: usize) -> Result<(), FactorError> {
        let zero = T::from(0.0);
        let Self { pattern, columns, scaled, lower, upper, x, .. } = self;
        let column = columns[j];
        for (&i, a) in pattern.column(column).iter().zip(&scaled[pattern.starts()[column]..]) {
            x[i] = *a;
        }
        let (above, values) = upper.column_mut(j);
        for (&k, entry) in above.iter().zip(values) {
            let (rows, factors) = lower.column(k);
            *entry = replace(&mut x[rows[0]], zero);
            for (&i, &factor) in rows[1..].iter().zip(&factors[1..]) {
                x[i] -= factor * *entry;
            }
        }
        // A NaN is no smaller than any other.
        let mut largest = (0, -1.0);
        for (place, &i) in lower.column(j).0.iter().enumerate() {
            let size = x[i].magnitude();
            if size > largest.1 || size.is_nan() {
                largest = (place, size);
            }
        }
        // It may be off by a rounding for each of its updates.
        let usable = largest.1 > (above.len() + 1) as f64 * f64::EPSILON;
        if !usable {
            x.fill(zero);
            return Err(FactorError::Singular);
        }
        if largest.0 > 0 {
            self.forget(j + 1);
            let (rows, _) = self.lower.column_mut(j);
            self.eliminated[rows[0]] = self.pattern.dim();
            rows[..=largest.0].rotate_right(1);
        }
        let (rows, values) = self.lower.column_mut(j);
        self.eliminated[rows[0]] = j;
        let inverse = T::from(1.0) / replace(&mut self.x[rows[0]], zero);
        values[0] = inverse;
        for (&i, value) in rows[1..].iter().zip(&mut values[1..]) {
            *value = replace(&mut self.x[i], zero) * inverse;
        }
        Ok(())
    }

    /// Forgets the places of the entries in column `j` and after it.
    fn forget(&mut self, j: usize) {
        for k in j..self.lower.columns() {
            if let Some(&row) = self.lower.column(k).0.first() {
                self.eliminated[row] = self.pattern.dim();
            }
        }
        self.lower.truncate(j);
        self.upper.truncate(j);
    }

    /// Entries of L and of U after the last factorisation, the diagonal counted once.
    pub(super) fn entries(&self) -> usize {
        self.lower.rows.len() + self.upper.rows.len()
    }

    pub(super) fn solve(&mut self, b: &mut [T]) {
        for (x, s) in b.iter_mut().zip(&self.row_scale) {
            *x = x.scaled(*s);
        }
        let Self { columns, lower, upper, x, .. } = self;
        for (j, x) in x.iter_mut().enumerate() {
            let (rows, factors) = lower.column(j);
            *x = b[rows[0]];
            for (&i, &factor) in rows[1..].iter().zip(&factors[1..]) {
                b[i] -= factor * *x;
            }
        }
        for (j, &column) in columns.iter().enumerate().rev() {
            x[j] *= lower.column(j).1[0];
            b[column] = x[j];
            let (rows, factors) = upper.column(j);
            for (&k, &factor) in rows.iter().zip(factors) {
                x[k] -= factor * b[column];
            }
        }
    }

    pub(super) fn solve_transpose(&mut self, b: &mut [T]) {
        let Self { columns, lower, upper, x, .. } = self;
        for (j, &column) in columns.iter().enumerate() {
            let (rows, factors) = upper.column(j);
            let above: T = rows.iter().zip(factors).map(|(&k, &factor)| factor * x[k]).sum();
            x[j] = (b[column] - above) * lower.column(j).1[0];
        }
        for (j, &x) in x.iter().enumerate().rev() {
            let (rows, factors) = lower.column(j);
            let below: T = rows[1..].iter().zip(&factors[1..]).map(|(&i, &factor)| factor * b[i]).sum();
            b[rows[0]] = x - below;
        }
        for (x, s) in b.iter_mut().zip(&self.row_scale) {
            *x = x.scaled(*s);
        }
    }
}
