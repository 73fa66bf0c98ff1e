//! Where elimination leads to entries of a column.

use std::mem::replace;
use std::ops::Range;

use super::columns::{Columns, short};
use crate::linalg::entry::Entry;

/// A row that is none of a pivot yet.
pub(super) const NONE: usize = usize::MAX;

/// The rows in which a column has entries once the columns before it are eliminated.
#[derive(Debug)]
pub(super) struct Reach {
    /// A row comes after all that its elimination adds to.
    pub(super) rows: Vec<usize>,
    pub(super) seen: Vec<bool>,
    /// Rows on the way down, each with the place in L of what is looked at next.
    path: Vec<(usize, usize)>,
    /// Of each column of L, the end of the entries that lead to all of it, by way of others.
    pub(super) ends: Vec<usize>,
}

impl Reach {
    pub(super) fn new(dim: usize) -> Self {
        let [rows, ends] = [Vec::with_capacity(dim), Vec::with_capacity(dim)];
        Self { rows, seen: vec![false; dim], path: Vec::with_capacity(dim), ends }
    }

    /// Adds what is reached from `row` and was not before; `pivots` has the column of each row's pivot.
    pub(super) fn add<T: Entry>(&mut self, row: usize, pivots: &[usize], lower: &Columns<T>) {
        let Self { rows, seen, path, ends } = self;
        let below = |row: usize| lower.starts.get(pivots[row]).map_or(0, |start| start + 1);
        let end = |row: usize| ends.get(pivots[row]).map_or(0, |end| *end);
        if replace(&mut seen[row], true) {
            return;
        }
        path.push((row, below(row)));
        while let Some((row, next)) = path.last_mut() {
            if *next >= end(*row) {
                rows.push(*row);
                path.pop();
                continue;
            }
            let found = lower.row(*next);
            *next += 1;
            if !replace(&mut seen[found], true) {
                path.push((found, below(found)));
            }
        }
    }

    /// The last column of L is known, with the row of its `pivot`. Columns `before` it that add to it and have an entry in that row have no rows below that it has not:
    /// these are reached by way of it (Eisenstat and Liu, SIAM J. Sci. Comput. 14 (1993) 253).
    pub(super) fn prune<T: Entry>(&mut self, pivot: usize, before: &[u32], pivots: &[usize], lower: &mut Columns<T>) {
        self.ends.push(lower.rows.len());
        for &k in before {
            let k = k as usize;
            let Range { start, end } = lower.range(k);
            if self.ends[k] < end || !lower.rows[start..end].contains(&short(pivot)) {
                continue;
            }
            let mut kept = start + 1;
            for place in start + 1..end {
                if pivots[lower.row(place)] != NONE {
                    lower.rows.swap(kept, place);
                    lower.values.swap(kept, place);
                    kept += 1;
                }
            }
            self.ends[k] = kept;
        }
    }
}
