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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_stand_in_the_order_of_the_table() {
        for n in 1..10 {
            let names: Vec<String> = (0..n).map(|k| format!("column {k}")).collect();
            let row = (0..n).map(Cell::Integer).collect();
            let text = table(&Table::data("t", "", names.iter().map(String::as_str), vec![row])).expect("written");
            let numbers: Vec<String> = (0..n).map(|k| k.to_string()).collect();
            assert_eq!(text, format!("{}\n{}\n", names.join(","), numbers.join(",")).into_bytes());
        }
    }
}
