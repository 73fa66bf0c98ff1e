//! Groups of columns of a Jacobian that share no row, so that one sweep of differentiation serves them all.

use crate::linalg::Structure;

/// Columns that no row meets twice, in as few groups as a greedy search finds: `lower + upper + 1` for a band.
#[derive(Debug)]
pub struct Coloring {
    dim: usize,
    /// The group of each column.
    color: Vec<usize>,
    /// The column that row i meets in group c, at `c * dim + i`; empty where each column is a group, and meets all rows.
    column: Vec<Option<usize>>,
}

impl Coloring {
    /// The groups for matrices of order `dim` with the given structure.
    pub fn new(dim: usize, structure: &Structure) -> Self {
        let mut column: Vec<Option<usize>> = Vec::new();
        if *structure == Structure::Dense {
            return Self { dim, color: (0..dim).collect(), column };
        }
        let color = (0..dim)
            .map(|j| {
                let groups = column.len() / dim;
                let free = |c: &usize| structure.rows(dim, j).all(|i| column[c * dim + i].is_none());
                let c = (0..groups).find(free).unwrap_or(groups);
                if c == groups {
                    column.resize((c + 1) * dim, None);
                }
                structure.rows(dim, j).for_each(|i| column[c * dim + i] = Some(j));
                c
            })
            .collect();
        Self { dim, color, column }
    }

    /// Number of groups.
    pub fn groups(&self) -> usize {
        if self.is_dense() { self.dim } else { self.column.len() / self.dim.max(1) }
    }

    /// The columns of group `c`; none if there is no such group.
    pub fn columns(&self, c: usize) -> impl Iterator<Item = usize> + '_ {
        self.color.iter().enumerate().filter(move |(_, color)| **color == c).map(|(j, _)| j)
    }

    /// The column of group `c` that each row meets, as (row, column).
    pub fn entries(&self, c: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let rows = self.column.chunks_exact(self.dim.max(1)).nth(c).unwrap_or_default();
        let all = if self.is_dense() && c < self.dim { self.dim } else { 0 };
        (0..all).map(move |i| (i, c)).chain(rows.iter().enumerate().filter_map(|(i, j)| j.map(|j| (i, j))))
    }

    fn is_dense(&self) -> bool {
        self.column.is_empty()
    }

    /// The column of group `c` that row `i` meets; none if there is no such group or row.
    pub fn column(&self, c: usize, i: usize) -> Option<usize> {
        if i >= self.dim {
            return None;
        }
        if self.is_dense() {
            return (c < self.dim).then_some(c);
        }
        self.column.get(c.saturating_mul(self.dim).saturating_add(i)).copied().flatten()
    }
}
