//! What claims write.

use crate::evidence::{Cell, Table, number};

/// A table of numbers with a text in front of each row.
pub(super) fn table(id: &str, caption: &str, columns: &[&str], rows: Vec<(Vec<String>, Vec<f64>)>) -> Table {
    let row = |(texts, numbers): (Vec<String>, Vec<f64>)| {
        texts.into_iter().map(Cell::Text).chain(numbers.into_iter().map(Cell::found)).collect()
    };
    Table::new(id, caption, columns, rows.into_iter().map(row).collect())
}

/// A number for a sentence: three significant digits, four from 1 to 2.
pub(super) fn text(x: f64) -> String {
    if x == f64::INFINITY {
        return "∞ (a step fails)".into();
    }
    let digits = if (1.0..2.0).contains(&x.abs()) { 4 } else { 3 };
    number::Short::new(x, digits).text()
}
