//! Where a matrix of derivatives may have entries.

use std::sync::Arc;

use crate::error::{InputError, SystemError};

/// The positions at which the Jacobian of a system may differ from zero.
///
/// A declared structure is a promise: an entry outside it makes the first step that meets it fail with
/// [`SolveError::OutsideStructure`](crate::SolveError::OutsideStructure). Declaring too much costs time, no accuracy.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Structure {
    /// Anywhere.
    #[default]
    Dense,
    /// Entries (i, j) with i − `lower` ≤ j ≤ i + `upper`.
    Banded {
        /// Number of diagonals below the main one.
        lower: usize,
        /// Number of diagonals above the main one.
        upper: usize,
    },
    /// The positions of a [`Pattern`].
    Sparse(Arc<Pattern>),
    /// Not assembled: known by its products with vectors only.
    MatrixFree,
}

impl Structure {
    /// The positions of a sparse matrix of order `dim`; the diagonal always belongs to them.
    ///
    /// # Errors
    /// [`SystemError::Position`] if one of them lies outside the matrix.
    pub fn sparse(dim: usize, positions: impl IntoIterator<Item = (usize, usize)>) -> Result<Self, InputError> {
        Ok(Self::Sparse(Arc::new(Pattern::new(dim, positions)?)))
    }

    /// The structure of AᵀA for A of this structure and order `dim`.
    pub(crate) fn gram(&self, dim: usize) -> Self {
        match self {
            Self::Dense | Self::MatrixFree => self.clone(),
            Self::Banded { lower, upper } => {
                let width = lower.saturating_add(*upper);
                Self::Banded { lower: width, upper: width }
            }
            Self::Sparse(_) => {
                let mut columns = vec![Vec::new(); dim];
                (0..dim).for_each(|j| self.rows(dim, j).for_each(|i| columns[i].push(j)));
                let pairs = columns.iter().flat_map(|row| row.iter().flat_map(|&j| row.iter().map(move |&k| (j, k))));
                Self::sparse(dim, pairs).expect("all positions are below dim")
            }
        }
    }

    /// The structure of `count` × `count` blocks of this structure and order `dim`.
    pub(crate) fn blocks(&self, dim: usize, count: usize) -> Self {
        match self {
            _ if count == 1 => self.clone(),
            Self::Dense | Self::MatrixFree => self.clone(),
            Self::Banded { .. } | Self::Sparse(_) => {
                let entries = (0..dim).flat_map(|j| self.rows(dim, j).map(move |i| (i, j)));
                let copies = |(i, j)| (0..count).flat_map(move |a| (0..count).map(move |b| (a * dim + i, b * dim + j)));
                Self::sparse(count * dim, entries.flat_map(copies)).expect("all positions are below the order")
            }
        }
    }

    /// The rows of column `j` that may have entries in a matrix of order `dim`, in ascending order.
    pub(crate) fn rows(&self, dim: usize, j: usize) -> impl Iterator<Item = usize> + '_ {
        let (range, list) = match self {
            Self::Dense => (0..dim, [].as_slice()),
            Self::Banded { lower, upper } => {
                (j.saturating_sub(*upper)..j.saturating_add(*lower).saturating_add(1).min(dim), [].as_slice())
            }
            Self::Sparse(pattern) if j < pattern.dim => (0..0, pattern.column(j)),
            Self::Sparse(_) | Self::MatrixFree => (0..0, [].as_slice()),
        };
        range.chain(list.iter().copied().filter(move |&i| i < dim))
    }
}

/// The positions of the entries of a sparse square matrix, by columns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    dim: usize,
    /// Column j occupies `starts[j]..starts[j + 1]` of `rows`.
    starts: Vec<usize>,
    rows: Vec<usize>,
}

impl Pattern {
    /// The given (row, column) positions, repeated ones once, and the diagonal, in a matrix of order `dim`.
    ///
    /// # Errors
    /// [`SystemError::Position`] if one of them lies outside the matrix.
    pub fn new(dim: usize, positions: impl IntoIterator<Item = (usize, usize)>) -> Result<Self, InputError> {
        let mut entries: Vec<(usize, usize)> = (0..dim).map(|i| (i, i)).collect();
        for (row, column) in positions {
            if row >= dim || column >= dim {
                return Err(InputError::System(SystemError::Position { row, column, dim }));
            }
            entries.push((column, row));
        }
        entries.sort_unstable();
        entries.dedup();
        let mut starts = vec![0; dim + 1];
        for &(column, _) in &entries {
            starts[column + 1] += 1;
        }
        for j in 0..dim {
            starts[j + 1] += starts[j];
        }
        Ok(Self { dim, starts, rows: entries.into_iter().map(|(_, row)| row).collect() })
    }

    /// Order of the matrix.
    pub fn dim(&self) -> usize {
        self.dim
    }

    /// Number of positions.
    pub fn entries(&self) -> usize {
        self.rows.len()
    }

    /// The rows of column `j`, ascending.
    pub(super) fn column(&self, j: usize) -> &[usize] {
        &self.rows[self.starts[j]..self.starts[j + 1]]
    }

    pub(super) fn starts(&self) -> &[usize] {
        &self.starts
    }

    pub(super) fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// Whether most entries beside the diagonal have a mirror image.
    pub(super) fn is_mostly_symmetric(&self) -> bool {
        let beside = (0..self.dim).flat_map(|j| self.column(j).iter().filter(move |&&i| i != j).map(move |&i| (i, j)));
        let (all, mirrored) = beside.fold((0, 0), |(all, mirrored), (i, j)| {
            (all + 1_usize, mirrored + usize::from(self.index(j, i).is_some()))
        });
        2 * mirrored > all
    }

    /// Where the value of entry (i, j) is stored.
    #[inline]
    pub(super) fn index(&self, i: usize, j: usize) -> Option<usize> {
        if j >= self.dim {
            return None;
        }
        self.column(j).binary_search(&i).ok().map(|k| self.starts[j] + k)
    }
}
