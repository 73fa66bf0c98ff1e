//! Triangular factors by their columns.

use std::array::from_fn;
use std::mem::replace;
use std::ops::Range;

use crate::linalg::entry::Entry;

/// The columns of a triangular matrix, one after the other.
pub(super) struct Columns<T> {
    pub(super) starts: Vec<usize>,
    /// In few bytes: solutions read all of them.
    pub(super) rows: Vec<u32>,
    pub(super) values: Vec<T>,
}

/// A row in few bytes. So many rows that it has none are more than memory has room for.
pub(super) fn short(row: usize) -> u32 {
    u32::try_from(row).expect("fewer than 2³² rows")
}

impl<T: Entry> Columns<T> {
    pub(super) fn new() -> Self {
        Self { starts: Vec::new(), rows: Vec::new(), values: Vec::new() }
    }

    pub(super) fn clear(&mut self) {
        self.starts.clear();
        self.starts.push(0);
        self.rows.clear();
        self.values.clear();
    }

    pub(super) fn push(&mut self, row: usize, value: T) {
        self.rows.push(short(row));
        self.values.push(value);
    }

    pub(super) fn end_column(&mut self) {
        self.starts.push(self.rows.len());
    }

    pub(super) fn range(&self, j: usize) -> Range<usize> {
        self.starts[j]..self.starts[j + 1]
    }

    pub(super) fn row(&self, place: usize) -> usize {
        self.rows[place] as usize
    }

    /// Subtracts `factor` times the entries in `range` from `x`.
    #[inline]
    pub(super) fn subtract(&self, range: Range<usize>, factor: T, x: &mut [T]) {
        for (&i, &entry) in self.rows[range.clone()].iter().zip(&self.values[range]) {
            x[i as usize] -= entry * factor;
        }
    }

    /// The product of the entries in `range` with those of `x`.
    #[inline]
    pub(super) fn product(&self, range: Range<usize>, x: &[T]) -> T {
        self.rows[range.clone()].iter().zip(&self.values[range]).map(|(&i, &entry)| entry * x[i as usize]).sum()
    }

    /// Brings the rows of each column into ascending order, by way of `x` and `order`, work space.
    pub(super) fn sort(&mut self, x: &mut [T], order: &mut Vec<u32>) {
        for j in 0..self.starts.len() - 1 {
            let range = self.range(j);
            let (rows, values) = (&mut self.rows[range.clone()], &mut self.values[range]);
            order.clear();
            order.extend_from_slice(rows);
            order.sort_unstable();
            rows.iter().zip(&*values).for_each(|(&i, &entry)| x[i as usize] = entry);
            rows.copy_from_slice(order);
            rows.iter().zip(values).for_each(|(&i, entry)| *entry = replace(&mut x[i as usize], T::from(0.0)));
        }
    }

    /// Of a unit lower triangle: how many columns from each on, at most 255, have the same rows below the last of them.
    pub(super) fn alike(&self, alike: &mut [u8]) {
        for j in (0..alike.len()).rev() {
            let is_next_alike = j + 1 < alike.len() && {
                let (this, next) = (self.range(j), self.range(j + 1));
                self.rows[this.start + 1..this.end] == self.rows[next]
            };
            alike[j] = if is_next_alike { alike[j + 1].saturating_add(1) } else { 1 };
        }
    }

    /// Eliminates column `k` and those that are `alike`, of `most`, and returns their number.
    #[inline]
    pub(super) fn eliminate_alike(&self, k: usize, alike: &[u8], most: usize, x: &mut [T]) -> usize {
        match most.min(alike[k].into()) {
            4.. => {
                self.eliminate::<4>(k, x);
                4
            }
            2.. => {
                self.eliminate::<2>(k, x);
                2
            }
            _ => {
                self.eliminate::<1>(k, x);
                1
            }
        }
    }

    /// Eliminates W columns from `k` on with the same rows below them, of a unit lower triangle: leaves in `x` the factors of these columns, and
    /// subtracts as much of them.
    #[inline]
    fn eliminate<const W: usize>(&self, k: usize, x: &mut [T]) {
        let starts: [usize; W] = from_fn(|c| self.starts[k + c]);
        for c in 0..W {
            for d in c + 1..W {
                let taken = self.values[starts[c] + d - c] * x[k + c];
                x[k + d] -= taken;
            }
        }
        let factors: [T; W] = from_fn(|c| x[k + c]);
        let rows = &self.rows[starts[W - 1] + 1..self.starts[k + W]];
        let columns: [&[T]; W] = from_fn(|c| &self.values[starts[c] + W - c..][..rows.len()]);
        for (place, &i) in rows.iter().enumerate() {
            let taken = (1..W).fold(columns[0][place] * factors[0], |sum, c| sum + columns[c][place] * factors[c]);
            x[i as usize] -= taken;
        }
    }
}
