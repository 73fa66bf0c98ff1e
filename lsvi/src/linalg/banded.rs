//! Band matrices and their LU factors with partial pivoting.

use std::ops::Range;

use super::entry::Entry;
use super::structure::Structure;
use super::{FactorError, is_usable, row_scale};

/// A square band matrix, stored by columns: entry (i, j) is at `upper + i − j` of column j.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Band {
    dim: usize,
    lower: usize,
    upper: usize,
    values: Vec<f64>,
}

impl Band {
    pub(super) fn zeros(dim: usize, lower: usize, upper: usize) -> Self {
        let widest = dim.saturating_sub(1);
        let (lower, upper) = (lower.min(widest), upper.min(widest));
        Self { dim, lower, upper, values: vec![0.0; dim * (lower + upper + 1)] }
    }

    pub(super) fn dim(&self) -> usize {
        self.dim
    }

    pub(super) fn structure(&self) -> Structure {
        Structure::Banded { lower: self.lower, upper: self.upper }
    }

    /// Whether it has one diagonal beside its own on either side.
    pub(super) fn is_tridiagonal(&self) -> bool {
        (self.lower, self.upper) == (1, 1)
    }

    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    pub(super) fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// The rows of column `j`, and where its entries are among the values.
    #[inline]
    pub(super) fn places(&self, j: usize) -> (Range<usize>, Range<usize>) {
        let rows = j.saturating_sub(self.upper)..(j + self.lower + 1).min(self.dim);
        let start = j * (self.lower + self.upper + 1) + self.upper + rows.start - j;
        let end = start + rows.len();
        (rows, start..end)
    }

    #[inline]
    fn index(&self, i: usize, j: usize) -> Option<usize> {
        let width = self.lower + self.upper + 1;
        // Beyond the upper band it wraps, to no width.
        let place = (self.upper + i).wrapping_sub(j);
        (place < width && i < self.dim && j < self.dim).then(|| j * width + place)
    }

    #[inline]
    pub(super) fn get(&self, i: usize, j: usize) -> Option<f64> {
        self.index(i, j).map(|k| self.values[k])
    }

    #[inline]
    pub(super) fn get_mut(&mut self, i: usize, j: usize) -> Option<&mut f64> {
        self.index(i, j).map(|k| &mut self.values[k])
    }

    /// The entries (i, x) of column `j`.
    #[inline]
    pub(super) fn column(&self, j: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let (rows, places) = self.places(j);
        rows.zip(self.values[places].iter().copied())
    }

    /// The first column in which row `i` has an entry.
    #[inline]
    pub(super) fn first_column(&self, i: usize) -> usize {
        i.saturating_sub(self.lower)
    }

    /// The entries of row `i` from there on.
    #[inline]
    pub(super) fn row(&self, i: usize) -> impl Iterator<Item = f64> + '_ {
        let stride = self.lower + self.upper;
        // Entry (i, j) is at j · stride + i + upper; a diagonal matrix has a stride of 0 and one entry in the row.
        let place = |j: usize| j * stride + i + self.upper;
        let last = (i + self.upper).min(self.dim - 1);
        self.values[place(self.first_column(i))..=place(last)].iter().step_by(stride.max(1)).copied()
    }

    /// The entries of column `j` from row `i` on.
    #[inline]
    pub(super) fn column_from_mut(&mut self, i: usize, j: usize) -> &mut [f64] {
        let (rows, places) = self.places(j);
        &mut self.values[places.start + i - rows.start..places.end]
    }

    /// Whether every entry of AᵀA has its place, for A of the structure of `a`.
    pub(super) fn has_room_for_gram_of(&self, a: &Self) -> bool {
        let width = (a.lower + a.upper).min(self.dim.saturating_sub(1));
        a.dim == self.dim && self.lower >= width && self.upper >= width
    }
}

/// P D A = L U of a band matrix, D the row scaling; row interchanges widen the upper band of U to `lower + upper`.
#[derive(Debug)]
pub(crate) struct BandLu<T = f64> {
    dim: usize,
    lower: usize,
    upper: usize,
    /// Upper bandwidth of U, A = L D U with ones on the diagonals of both: column j of U is at `reach + i − j`, with one over the pivot in the
    /// place of its diagonal, and the multipliers of L below. A solve waits for no division and, from row to row, for one product.
    reach: usize,
    factors: Vec<T>,
    /// How far below the diagonal the pivot of each column was found.
    pivots: Vec<usize>,
    row_scale: Vec<f64>,
}

impl<T: Entry> BandLu<T> {
    pub(super) fn new(a: &Band) -> Self {
        let reach = a.lower + a.upper;
        Self {
            dim: a.dim,
            lower: a.lower,
            upper: a.upper,
            reach,
            factors: vec![T::from(0.0); a.dim * (a.lower + reach + 1)],
            pivots: vec![0; a.dim],
            row_scale: vec![0.0; a.dim],
        }
    }

    /// The matrix of the images of the entries of `a`, to be factored.
    pub(super) fn assign(&mut self, a: &Band, image: impl Fn(f64) -> T) {
        let height = self.lower + self.reach + 1;
        let columns = a.values.chunks_exact(a.lower + a.upper + 1);
        for (target, column) in self.factors.chunks_exact_mut(height).zip(columns) {
            target[..self.lower].fill(T::from(0.0));
            target[self.lower..].iter_mut().zip(column).for_each(|(x, a)| *x = image(*a));
        }
    }

    #[inline]
    pub(super) fn entry(&mut self, i: usize, j: usize) -> Option<&mut T> {
        let inside = i < self.dim && j < self.dim && i <= j + self.lower && j <= i + self.upper;
        if inside { self.factors.get_mut(j * (self.lower + self.reach + 1) + self.reach + i - j) } else { None }
    }

    /// The rows of column `j`, and where they are in the storage.
    fn column(&self, j: usize) -> (std::ops::Range<usize>, usize) {
        let rows = j.saturating_sub(self.upper)..(j + self.lower + 1).min(self.dim);
        let start = j * (self.lower + self.reach + 1) + self.reach + rows.start - j;
        (rows, start)
    }

    /// Entries of L and of U, the diagonal counted once.
    pub(super) fn entries(&self) -> usize {
        (0..self.dim).map(|j| self.reach.min(j) + 1 + self.lower.min(self.dim - 1 - j)).sum()
    }

    /// Factors the matrix in place.
    pub(super) fn decompose(&mut self) -> Result<(), FactorError> {
        self.scale_rows()?;
        self.eliminate()
    }

    /// Scales the rows to largest entries in [1, 2).
    fn scale_rows(&mut self) -> Result<(), FactorError> {
        let n = self.dim;
        self.row_scale.fill(0.0);
        for j in 0..n {
            let (rows, start) = self.column(j);
            let entries = &self.factors[start..start + rows.len()];
            for (s, x) in self.row_scale[rows].iter_mut().zip(entries) {
                let x = x.magnitude();
                *s = if x.is_nan() { f64::INFINITY } else { s.max(x) };
            }
        }
        for s in &mut self.row_scale {
            *s = row_scale(*s)?;
        }
        for j in 0..n {
            let (rows, start) = self.column(j);
            let entries = &mut self.factors[start..start + rows.len()];
            entries.iter_mut().zip(&self.row_scale[rows]).for_each(|(x, s)| *x = x.scaled(*s));
        }
        Ok(())
    }

    /// Gaussian elimination of the scaled rows.
    fn eliminate(&mut self) -> Result<(), FactorError> {
        let (n, lower, reach) = (self.dim, self.lower, self.reach);
        let height = lower + reach + 1;
        let mut last = 0;
        for j in 0..n {
            let below = lower.min(n - 1 - j);
            let (done, rest) = self.factors.split_at_mut((j + 1) * height);
            let done = &mut done[j * height..];
            let column = &mut done[reach..=reach + below];
            let mut pivot = 0;
            for (i, x) in column.iter().enumerate().skip(1) {
                if x.magnitude() > column[pivot].magnitude() {
                    pivot = i;
                }
            }
            self.pivots[j] = pivot;
            column.swap(0, pivot);
            if !is_usable(&done[reach - reach.min(j)..=reach], reach + 1) {
                return Err(FactorError::Singular);
            }
            let column = &mut done[reach..=reach + below];
            let inverse = T::from(1.0) / column[0];
            column[0] = inverse;
            column[1..].iter_mut().for_each(|x| *x *= inverse);
            // Row j + pivot reaches `upper` beyond its own diagonal.
            last = (j + pivot + (reach - lower)).max(last).min(n - 1);
            for (k, target) in rest.chunks_exact_mut(height).take(last - j).enumerate() {
                let target = &mut target[reach - k - 1..reach - k + below];
                target.swap(0, pivot);
                let factor = target[0];
                if factor != T::from(0.0) {
                    for (x, l) in target[1..].iter_mut().zip(&column[1..]) {
                        *x -= *l * factor;
                    }
                }
            }
        }
        for j in 1..n {
            let above = reach.min(j);
            let (done, rest) = self.factors.split_at_mut(j * height);
            let pivots = done[(j - above) * height..].chunks_exact(height).map(|column| column[reach]);
            rest[reach - above..reach].iter_mut().zip(pivots).for_each(|(u, inverse)| *u *= inverse);
        }
        Ok(())
    }

    pub(super) fn solve(&self, b: &mut [T]) {
        let (n, lower, reach) = (self.dim, self.lower, self.reach);
        let height = lower + reach + 1;
        for (x, s) in b.iter_mut().zip(&self.row_scale) {
            *x = x.scaled(*s);
        }
        for (j, column) in self.factors.chunks_exact(height).enumerate() {
            let below = lower.min(n - 1 - j);
            b.swap(j, j + self.pivots[j]);
            let x = b[j];
            for (b, l) in b[j + 1..=j + below].iter_mut().zip(&column[reach + 1..]) {
                *b -= *l * x;
            }
            b[j] = x * column[reach];
        }
        for (j, column) in self.factors.chunks_exact(height).enumerate().rev() {
            let above = reach.min(j);
            let x = b[j];
            for (b, u) in b[j - above..j].iter_mut().zip(&column[reach - above..reach]) {
                *b -= *u * x;
            }
        }
    }

    pub(super) fn solve_transpose(&self, b: &mut [T]) {
        let (n, lower, reach) = (self.dim, self.lower, self.reach);
        let height = lower + reach + 1;
        for (j, column) in self.factors.chunks_exact(height).enumerate() {
            let above = reach.min(j);
            let known: T = b[j - above..j].iter().zip(&column[reach - above..reach]).map(|(b, u)| *b * *u).sum();
            b[j] -= known;
        }
        for (j, column) in self.factors.chunks_exact(height).enumerate().rev() {
            let below = lower.min(n - 1 - j);
            let known: T = b[j + 1..=j + below].iter().zip(&column[reach + 1..]).map(|(b, l)| *b * *l).sum();
            b[j] = b[j] * column[reach] - known;
            b.swap(j, j + self.pivots[j]);
        }
        for (x, s) in b.iter_mut().zip(&self.row_scale) {
            *x = x.scaled(*s);
        }
    }
}

impl BandLu {
    pub(super) fn sign(&self) -> f64 {
        let height = self.lower + self.reach + 1;
        let pivots = self.factors.chunks_exact(height).map(|column| column[self.reach]);
        // One over a pivot has its sign.
        super::sign(pivots, self.pivots.iter().filter(|pivot| **pivot != 0).count())
    }
}
