//! Sparse matrices.

mod columns;
mod lu;
mod order;
mod reach;

pub(crate) use lu::SparseLu;

use std::sync::Arc;

use super::structure::Pattern;

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

/// An addition to an entry, and the place of its value, in few bytes: assembly reads all of the trail.
#[derive(Debug, Clone, Copy)]
struct Step {
    row: u32,
    column: u32,
    place: u32,
}

impl Step {
    /// `None` in a matrix too large for it, which is searched each time.
    fn new(row: usize, column: usize, place: usize) -> Option<Self> {
        let [row, column, place] = [row, column, place].map(u32::try_from);
        Some(Self { row: row.ok()?, column: column.ok()?, place: place.ok()? })
    }
}

impl Trail {
    /// Additions that are remembered for each entry of a matrix; a path may be of any length.
    const MOST: usize = 16;

    /// The place of an entry that is next on the path.
    #[inline]
    fn follow(&mut self, row: usize, column: usize) -> Option<usize> {
        let step = self.steps.get(self.next)?;
        let is_next = step.row as usize == row && step.column as usize == column;
        is_next.then(|| {
            self.next += 1;
            step.place as usize
        })
    }

    /// Searches for an entry, and leads the path there.
    fn leave(&mut self, pattern: &Pattern, row: usize, column: usize) -> Option<usize> {
        let place = pattern.index(row, column)?;
        if let Some(step) = Step::new(row, column, place) {
            if self.next < self.steps.len() {
                self.steps[self.next] = step;
            } else if self.steps.len() < Self::MOST * pattern.entries() {
                self.steps.push(step);
            }
        }
        self.next += 1;
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

    /// Whether both have the pattern in one place, so that their values are in the same places.
    pub(super) fn shares_pattern(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.pattern, &other.pattern)
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

    /// The entry (i, j), to be added to, if it is the next one on the path of the last assembly.
    #[inline]
    pub(super) fn next_mut(&mut self, i: usize, j: usize) -> Option<&mut f64> {
        self.trail.follow(i, j).map(|k| &mut self.values[k])
    }

    /// The entry (i, j), to be added to, if it is not.
    pub(super) fn get_mut(&mut self, i: usize, j: usize) -> Option<&mut f64> {
        self.trail.leave(&self.pattern, i, j).map(|k| &mut self.values[k])
    }

    /// The entries (i, x) of column `j`.
    #[inline]
    pub(super) fn column(&self, j: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let start = self.pattern.starts()[j];
        let rows = self.pattern.column(j);
        rows.iter().copied().zip(self.values[start..start + rows.len()].iter().copied())
    }
}
