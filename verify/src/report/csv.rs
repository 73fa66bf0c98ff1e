//! `data/<id>.csv`: every table at full precision.
//!
//! The first line holds the column names. Numbers are the shortest decimals that read back as the same `f64`, with
//! exponents as in `1e-6`. An empty cell means that there is no value, and another column says why; `inf`, `-inf` and
//! `NaN` are written as such, since an empty cell would hide them.

use crate::evidence::number::exact;
use crate::evidence::{Cell, Table};

pub(super) fn table(table: &Table) -> Result<Vec<u8>, csv::Error> {
    // Flexible, so that a ragged row is shown as it is; the audit reports it.
    let mut writer = csv::WriterBuilder::new().flexible(true).from_writer(Vec::new());
    writer.write_record(&table.columns)?;
    for row in &table.rows {
        writer.write_record(row.iter().map(field))?;
    }
    writer.into_inner().map_err(|error| error.into_error().into())
}

fn field(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) => text.clone(),
        Cell::Number(value) => exact(*value),
        Cell::Integer(value) => value.to_string(),
        Cell::Empty => String::new(),
    }
}
