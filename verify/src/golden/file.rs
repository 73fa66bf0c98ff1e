//! The format of a golden file: CSV with one header line, a fixed set of columns, and numbers that round-trip.

use super::{Number, Row, Tolerance, Truth, Value};
use crate::measure::line_of;
use csv::{ReaderBuilder, StringRecord};
use std::collections::HashSet;

const COLUMNS: [&str; 9] =
    ["key", "value", "rtol", "atol", "tolerance_reason", "truth", "allowance", "distance", "truth_source"];

/// A row as it stands in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// The row.
    pub row: Row,
    /// The recorded |value − truth|, where there is a truth.
    pub distance: Option<f64>,
}

/// A golden file that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {what} ({hint})")]
pub struct Malformed {
    /// Line in the file, from 1.
    pub line: u64,
    /// What is wrong.
    pub what: String,
    /// What to do about it.
    pub hint: &'static str,
}

const RESTORE: &str = "restore the file from version control, or write it anew with `golden refresh`";

/// Writes rows as the text of a golden file; lines end in `\n` on every system.
#[must_use]
pub fn render(rows: &[Row]) -> String {
    let mut text = COLUMNS.join(",") + "\n";
    for row in rows {
        text += &fields(row).map(quote).join(",");
        text.push('\n');
    }
    text
}

fn fields(row: &Row) -> [String; COLUMNS.len()] {
    let key = row.key.clone();
    match &row.value {
        Value::Text(text) => {
            let mut fields: [String; COLUMNS.len()] = Default::default();
            (fields[0], fields[1]) = (key, text.clone());
            fields
        }
        Value::Number(Number { value, tolerance: Tolerance { rtol, atol, reason }, truth }) => {
            let number = |x: f64| format!("{x:?}");
            let [truth, allowance, distance, source] = truth.as_ref().map_or_else(Default::default, |t| {
                [number(t.value), number(t.allowance), number(t.distance(*value)), t.source.clone()]
            });
            [key, number(*value), number(*rtol), number(*atol), reason.clone(), truth, allowance, distance, source]
        }
    }
}

fn quote(field: String) -> String {
    if field.contains([',', '"', '\n', '\r']) { format!("\"{}\"", field.replace('"', "\"\"")) } else { field }
}

/// Reads the bytes of a golden file, with `\n` or `\r\n`: the rows that can be read, and the lines that cannot.
#[must_use]
pub fn parse(bytes: &[u8]) -> (Vec<Recorded>, Vec<Malformed>) {
    let mut reader = ReaderBuilder::new().has_headers(false).flexible(true).from_reader(bytes);
    let (mut rows, mut faults) = (Vec::new(), Vec::new());
    let mut keys = HashSet::new();
    let mut header = false;
    for record in reader.records() {
        let record = match record {
            Ok(record) => record,
            Err(error) => {
                let line = error.position().map_or(1, |at| line_of(bytes, at));
                faults.push(Malformed { line, what: error.to_string(), hint: RESTORE });
                continue;
            }
        };
        let line = || record.position().map_or(1, |at| line_of(bytes, at));
        let marker = ["<<<<<<<", "|||||||", "=======", ">>>>>>>"].iter().find(|marker| record[0].starts_with(**marker));
        let read = match marker {
            Some(marker) => Err((format!("the marker `{marker}` of a merge"), "settle the merge")),
            None if !header => {
                header = true;
                match read_header(&record) {
                    Ok(()) => continue,
                    // Rows of unknown columns mean nothing.
                    Err((what, hint)) => return (Vec::new(), vec![Malformed { line: line(), what, hint }]),
                }
            }
            None => read_row(&record),
        };
        match read {
            Ok(recorded) if keys.insert(recorded.row.key.clone()) => rows.push(recorded),
            Ok(Recorded { row, .. }) => {
                let what = format!("the key `{}` stands there twice", row.key);
                faults.push(Malformed { line: line(), what, hint: RESTORE });
            }
            Err((what, hint)) => faults.push(Malformed { line: line(), what, hint }),
        }
    }
    if !header {
        faults.push(Malformed { line: 1, what: "the file is empty".to_owned(), hint: RESTORE });
    }
    (rows, faults)
}

fn read_header(record: &StringRecord) -> Result<(), Fault> {
    if let Some(missing) = COLUMNS.iter().find(|c| !record.iter().any(|field| field == **c)) {
        return Err((format!("there is no column `{missing}`"), RESTORE));
    }
    if record != COLUMNS[..] {
        return Err((format!("the columns are not {}", COLUMNS.join(",")), RESTORE));
    }
    Ok(())
}

type Fault = (String, &'static str);

fn read_row(record: &StringRecord) -> Result<Recorded, Fault> {
    if record.len() != COLUMNS.len() {
        let what = format!("{} fields, not {}", record.len(), COLUMNS.len());
        return Err((what, "a comma is missing, or a text with a comma has lost its quotes"));
    }
    let key = record[0].to_owned();
    if record.iter().skip(2).all(str::is_empty) {
        return Ok(Recorded { row: Row::text(key, &record[1]), distance: None });
    }
    let number = |i: usize| read_number(COLUMNS[i], &record[i]);
    let tolerance = Tolerance { rtol: number(2)?, atol: number(3)?, reason: record[4].to_owned() };
    let row = Row::number(key, number(1)?, tolerance);
    if record.iter().skip(5).all(str::is_empty) {
        return Ok(Recorded { row, distance: None });
    }
    let truth = Truth { value: number(5)?, allowance: number(6)?, source: record[8].to_owned() };
    Ok(Recorded { row: row.with_truth(truth), distance: Some(number(7)?) })
}

fn read_number(column: &str, text: &str) -> Result<f64, Fault> {
    let number: f64 = text.parse().map_err(|_| {
        (format!("`{text}` in column `{column}` is not a number"), "numbers look like 1.5, -2e-9 or 0.0")
    })?;
    if number.is_finite() {
        Ok(number)
    } else {
        Err((format!("column `{column}` holds {number}"), "a golden keeps finite numbers only"))
    }
}
