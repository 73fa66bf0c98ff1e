//! Checks laid out by two names, such as method and problem.

use serde::Serialize;

/// Checks as a map: a cell for a pair of names, coloured by what came out and by how near it came to its bound.
#[derive(Debug, Clone, Serialize, speedy::Readable, speedy::Writable)]
pub struct Grid {
    /// Stable identifier and anchor.
    pub id: String,
    /// What the numbers are, and what to see in them.
    pub caption: String,
    /// Digits after the point.
    pub decimals: usize,
    /// Names of the rows, in the order of their first cells.
    pub rows: Vec<String>,
    /// Names of the columns, likewise.
    pub columns: Vec<String>,
    /// The cells that there are.
    pub cells: Vec<GridCell>,
}

/// One cell of a [`Grid`].
#[derive(Debug, Clone, Serialize, speedy::Readable, speedy::Writable)]
pub struct GridCell {
    /// Position in [`Grid::rows`].
    pub row: usize,
    /// Position in [`Grid::columns`].
    pub column: usize,
    /// The number shown; nothing where the check measured none.
    pub value: Option<f64>,
    /// How near the measured number came to its bound: 0 far from it, 1 at it; nothing where theory predicts that the two
    /// differ.
    pub strain: Option<f64>,
    /// The identifier of the check in its chapter.
    pub check: String,
}

impl Grid {
    /// A grid without cells.
    pub fn new(id: impl Into<String>, caption: impl Into<String>, decimals: usize) -> Self {
        let (id, caption) = (id.into(), caption.into());
        Self { id, caption, decimals, rows: Vec::new(), columns: Vec::new(), cells: Vec::new() }
    }

    /// Adds the cell of a check.
    pub fn push(&mut self, row: &str, column: &str, value: Option<f64>, strain: Option<f64>, check: impl Into<String>) {
        let place = |names: &mut Vec<String>, name: &str| {
            names.iter().position(|known| known == name).unwrap_or_else(|| {
                names.push(name.to_owned());
                names.len() - 1
            })
        };
        let (row, column) = (place(&mut self.rows, row), place(&mut self.columns, column));
        self.cells.push(GridCell { row, column, value, strain, check: check.into() });
    }
}
