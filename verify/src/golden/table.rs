//! Rows of a golden from the tables of a report.

use super::{Row, Tolerance, Truth};
use crate::evidence::{Cell, Table};

/// One number of a table: the cells of its row, and where it stands in it.
pub(super) struct Entry<'a> {
    pub(super) table: &'a Table,
    pub(super) row: &'a [Cell],
    pub(super) column: &'a str,
    pub(super) value: f64,
}

impl Entry<'_> {
    /// The number in another column of the same row.
    pub(super) fn number(&self, column: &str) -> Option<f64> {
        self.cell(column).and_then(number)
    }

    /// The text in another column of the same row.
    pub(super) fn text(&self, column: &str) -> Option<&str> {
        match self.cell(column)? {
            Cell::Text(text) => Some(text),
            _ => None,
        }
    }

    fn cell(&self, column: &str) -> Option<&Cell> {
        self.table.columns.iter().position(|name| name == column).and_then(|i| self.row.get(i))
    }
}

/// The numbers in the columns `values`, by the cells in the columns `keys`; an empty cell is kept as a text.
pub(super) fn rows(
    table: &Table,
    keys: &[&str],
    values: &[&str],
    describe: impl Fn(&Entry<'_>) -> (Tolerance, Option<Truth>),
) -> Vec<Row> {
    let mut rows = Vec::new();
    for row in &table.rows {
        let of = |which: &[&str]| {
            let columns = table.columns.iter().zip(row);
            columns.filter(|(name, _)| which.contains(&name.as_str())).map(|(_, cell)| show(cell)).collect::<Vec<_>>()
        };
        let key = of(keys).join(" ");
        for (column, cell) in table.columns.iter().zip(row).filter(|(name, _)| values.contains(&name.as_str())) {
            let key = format!("{key} {column}");
            let Some(value) = number(cell) else {
                rows.push(Row::text(key, show(cell)));
                continue;
            };
            let (tolerance, truth) = describe(&Entry { table, row, column, value });
            rows.push(Row::number(key, value, tolerance).with_truth(truth));
        }
    }
    rows
}

fn number(cell: &Cell) -> Option<f64> {
    match cell {
        Cell::Number(x) => Some(*x),
        Cell::Integer(n) => Some(*n as f64),
        _ => None,
    }
}

fn show(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) => text.clone(),
        Cell::Number(x) => format!("{x}"),
        Cell::Integer(n) => n.to_string(),
        Cell::Empty => "none".into(),
    }
}
