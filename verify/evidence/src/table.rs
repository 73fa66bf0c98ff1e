//! Tables of what was found.

use std::fmt;

use serde::Serialize;

use super::{Mark, Series};

/// Whether a character may stand in an identifier, which serves as a file stem and an anchor.
#[must_use]
pub fn is_plain(c: char) -> bool {
    c.is_ascii_alphanumeric() || "-_.".contains(c)
}

/// A table; also written as `data/<id>.csv` at full precision.
#[derive(Debug, Clone, Serialize, speedy::Readable, speedy::Writable)]
pub struct Table {
    /// Stable identifier: file stem and anchor.
    pub id: String,
    /// One sentence saying what the reader sees.
    pub caption: String,
    /// Column names, machine readable: `max_error`.
    pub columns: Vec<String>,
    /// Rows; each as long as `columns`.
    pub rows: Vec<Vec<Cell>>,
    /// Whether the report shows the rows; data behind a figure only are linked.
    pub shown: bool,
}

/// One cell of a [`Table`].
#[derive(Debug, Clone, PartialEq, Serialize, speedy::Readable, speedy::Writable)]
#[serde(untagged)]
pub enum Cell {
    /// Text.
    Text(String),
    /// A number: round-trip precision in files, four significant digits on the page. One that is not finite is shown as
    /// such; a result that does not exist is [`Cell::Empty`].
    #[serde(serialize_with = "super::number::serialize")]
    Number(f64),
    /// A count.
    Integer(i64),
    /// Nothing there; the reason stands in another column.
    Empty,
}

impl Table {
    /// A table whose rows are shown.
    pub fn new(
        id: impl Into<String>,
        caption: impl Into<String>,
        columns: impl IntoIterator<Item: AsRef<str>>,
        rows: Vec<Vec<Cell>>,
    ) -> Self {
        let columns = columns.into_iter().map(|name| name.as_ref().to_owned()).collect();
        Self { id: id.into(), caption: caption.into(), columns, rows, shown: true }
    }

    /// A table behind a figure: its rows are not shown.
    pub fn data(
        id: impl Into<String>,
        caption: impl Into<String>,
        columns: impl IntoIterator<Item: AsRef<str>>,
        rows: Vec<Vec<Cell>>,
    ) -> Self {
        Self { shown: false, ..Self::new(id, caption, columns, rows) }
    }

    /// The position of a column.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|known| known == name)
    }

    /// The rows in which a column has this text.
    #[must_use]
    pub fn where_text(&self, column: &str, text: &str) -> Self {
        let is_it = |row: &&Vec<Cell>| self.column(column).is_some_and(|i| row[i].to_string() == text);
        Self { rows: self.rows.iter().filter(is_it).cloned().collect(), ..self.clone() }
    }

    /// The curves of column `y` over column `x`, one for each text in column `by`, in the order of their first rows. Rows
    /// without a number in either are left out. Empty if a column is missing.
    pub fn curves(&self, by: &str, x: &str, y: &str, mark: Mark) -> Vec<Series> {
        let (Some(by), Some(x), Some(y)) = (self.column(by), self.column(x), self.column(y)) else { return Vec::new() };
        let mut curves: Vec<Series> = Vec::new();
        for row in &self.rows {
            let label = row[by].to_string();
            let position = curves.iter().position(|curve| curve.label == label).unwrap_or_else(|| {
                curves.push(Series::new(label, Vec::new(), mark));
                curves.len() - 1
            });
            curves[position].points.extend(row[x].number().zip(row[y].number()));
        }
        curves
    }
}

impl Cell {
    /// A number, or nothing where there is none.
    pub fn found(x: f64) -> Self {
        if x.is_nan() { Self::Empty } else { Self::Number(x) }
    }

    /// The number in the cell.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(x) => Some(*x),
            Self::Integer(n) => Some(*n as f64),
            Self::Text(_) | Self::Empty => None,
        }
    }
}

/// As in a file, at full precision; nothing for [`Cell::Empty`].
impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Number(value) => f.write_str(&super::number::exact(*value)),
            Self::Integer(value) => value.fmt(f),
            Self::Empty => Ok(()),
        }
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<Option<f64>> for Cell {
    fn from(value: Option<f64>) -> Self {
        value.map_or(Self::Empty, Self::Number)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<&String> for Cell {
    fn from(text: &String) -> Self {
        Self::Text(text.clone())
    }
}

impl From<i64> for Cell {
    fn from(count: i64) -> Self {
        Self::Integer(count)
    }
}

impl From<u32> for Cell {
    fn from(count: u32) -> Self {
        Self::Integer(count.into())
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Self::Integer(i64::try_from(count).unwrap_or(i64::MAX))
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Self {
        Self::Integer(i64::try_from(count).unwrap_or(i64::MAX))
    }
}

/// One row of a [`Table`], each value by its kind: `row!["method-i", 0.1, 4_usize]`.
#[macro_export]
macro_rules! row {
    ($($value:expr),* $(,)?) => { vec![$($crate::Cell::from($value)),*] };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_is_a_selection_of_columns() {
        let rows = vec![row!["a", 1.0, 0.5], row!["b", 1.0, 0.7], row!["a", 2.0, Cell::Empty], row!["a", 3_usize, 0.1]];
        let table = Table::data("t", "", ["method", "h", "error"], rows);
        let curves = table.curves("method", "h", "error", Mark::Line);
        let found: Vec<_> = curves.iter().map(|curve| (curve.label.as_str(), curve.points.clone())).collect();
        assert_eq!(found, [("a", vec![(1.0, 0.5), (3.0, 0.1)]), ("b", vec![(1.0, 0.7)])]);
        assert!(table.curves("method", "h", "nothing", Mark::Line).is_empty());
    }
}
