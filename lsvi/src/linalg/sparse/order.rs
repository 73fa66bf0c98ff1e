//! The order in which the unknowns of a sparse matrix are eliminated.

use std::mem::replace;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::{amd, colamd};

use crate::linalg::structure::Pattern;

#[derive(Debug)]
pub(super) struct Permutation {
    pub(super) forward: Vec<usize>,
    pub(super) inverse: Vec<usize>,
}

impl Permutation {
    pub(super) fn identity(dim: usize) -> Self {
        Self { forward: (0..dim).collect(), inverse: (0..dim).collect() }
    }

    /// So many exchanges of two make it up: one less than each cycle has members.
    pub(super) fn exchanges(&self, seen: &mut [bool]) -> usize {
        let mut exchanges = 0;
        seen.fill(false);
        for first in 0..seen.len() {
            let mut k = first;
            while !replace(&mut seen[k], true) {
                k = self.forward[k];
                exchanges += usize::from(k != first);
            }
        }
        exchanges
    }
}

fn symbolic(pattern: &Pattern) -> SymbolicSparseColMatRef<'_, usize> {
    let n = pattern.dim();
    SymbolicSparseColMatRef::new_checked(n, n, pattern.starts(), None, pattern.rows())
}

/// An order of the columns for little fill, whatever the pivots.
pub(super) fn by_columns(pattern: &Pattern) -> Permutation {
    let n = pattern.dim();
    let mut order = Permutation::identity(n);
    let mut scratch = MemBuffer::new(colamd::order_scratch::<usize>(n, n, pattern.entries()));
    let (forward, inverse, stack) = (&mut order.forward, &mut order.inverse, MemStack::new(&mut scratch));
    let is_found = colamd::order(forward, inverse, symbolic(pattern), Default::default(), stack).is_ok();
    // The order decides the fill only.
    if is_found { order } else { Permutation::identity(n) }
}

/// An order of the unknowns for little fill with pivots on the diagonal.
pub(super) fn by_degree(pattern: &Pattern) -> Permutation {
    let n = pattern.dim();
    let mut order = Permutation::identity(n);
    let mut scratch = MemBuffer::new(amd::order_scratch::<usize>(n, pattern.entries()));
    let (forward, inverse, stack) = (&mut order.forward, &mut order.inverse, MemStack::new(&mut scratch));
    let is_found = amd::order(forward, inverse, symbolic(pattern), Default::default(), stack).is_ok();
    if is_found { order } else { Permutation::identity(n) }
}
