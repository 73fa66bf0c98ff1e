//! Quantities on grids, read from a table with a header.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::io::Read;

use super::{Grid, Quantity};
use crate::measure::decimal::parsed;
use crate::measure::typeset::bare;
use crate::measure::{fault, line_of};

/// Where the spacing of the grids stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Spacing {
    /// A column with the spacing or the step itself.
    Step(String),
    /// A column with the number N of cells in so many dimensions D: h = N^(−1/D).
    Cells {
        /// The column.
        column: String,
        /// The dimensions, 1 to 3.
        dimension: u32,
    },
}

/// Most bytes that are read.
const MOST: u64 = 64 << 20;

/// A table that cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DataError {
    /// It cannot be read.
    #[error("{0}")]
    Unreadable(#[from] std::io::Error),
    /// The text is no table.
    #[error("line {line}: {reason}")]
    Table {
        /// The line, from 1.
        line: u64,
        /// Why not.
        reason: String,
    },
    /// It is not said which column holds the spacings.
    #[error("no column of spacings is named; {known}")]
    NoSpacing {
        /// The names that there are, in words.
        known: String,
    },
    /// There is no such column.
    #[error("no column is named `{name}`; {known}")]
    Column {
        /// The name asked for.
        name: String,
        /// The names that there are, in words.
        known: String,
    },
    /// Two columns have the same name.
    #[error("two columns are named `{0}`")]
    Ambiguous(String),
    /// A cell holds something that is no number.
    #[error(
        "line {line}, column `{column}`: `{text}` is not a number{}",
        if .text.contains(',') { "; decimals have a point" } else { "" }
    )]
    Number {
        /// The line, from 1.
        line: u64,
        /// The column.
        column: String,
        /// The cell.
        text: String,
    },
    /// A spacing that is none.
    #[error("line {line}, column `{column}`: {value} is no {what}, which is positive and finite")]
    Spacing {
        /// The line, from 1.
        line: u64,
        /// The column.
        column: String,
        /// The cell.
        value: String,
        /// What it should be.
        what: &'static str,
    },
    /// A quantity is asked for in the column of the spacings.
    #[error("column `{0}` holds the spacings, and is no quantity on them")]
    NoQuantity(String),
    /// It is no table of grids.
    #[error("it has more than {} MiB", MOST >> 20)]
    TooLong,
    /// No header, no row, or no column beside the spacing.
    #[error("the table has {0}")]
    Empty(&'static str),
}

/// Reads the `quantities` of the table, all columns beside the spacing where none is named.
///
/// Lines that start with `#` are comments. A header without a comma that has semicolons or tabs says what separates the cells; tables in
/// Markdown and LaTeX are read too. A cell that is empty, `NaN`, `NA`, `n/a` or `-` is a missing value. The resolution of a quantity is half a unit of the last decimal place that any of its values shows.
///
/// # Errors
/// [`DataError`] with line and column; [`DataError::NoSpacing`] names the columns where no `spacing` is said.
pub fn read(input: impl Read, spacing: Option<&Spacing>, quantities: &[String]) -> Result<Vec<Quantity>, DataError> {
    let mut text = Vec::new();
    if input.take(MOST + 1).read_to_end(&mut text)? as u64 > MOST {
        return Err(DataError::TooLong);
    }
    let text = match std::str::from_utf8(&text).map(bare) {
        // A line of spaces would be a row.
        Ok(Cow::Owned(text)) => text
            .lines()
            .flat_map(|line| [line.trim_start_matches(' ').trim_end(), "\n"])
            .collect::<String>()
            .into_bytes(),
        _ => text,
    };
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .delimiter(separator(&text))
        .from_reader(&*text);
    let table = |error: csv::Error| {
        let (line, reason) = fault(&text, &error);
        DataError::Table { line, reason }
    };
    let header: Vec<String> = reader.headers().map_err(table)?.iter().map(str::to_owned).collect();
    if header.is_empty() {
        return Err(DataError::Empty("no header"));
    }
    if header.iter().all(|name| parsed(name).is_some()) {
        return Err(DataError::Empty("no header: its first row holds numbers, where names are expected"));
    }
    let mut seen = BTreeSet::new();
    if let Some(twice) = header.iter().find(|name| !seen.insert(name.as_str())) {
        return Err(DataError::Ambiguous(twice.clone()));
    }
    let known = || match &header[..] {
        [single] => {
            format!("the only one is `{single}`; commas, semicolons or tabs separate columns, or the bars of Markdown")
        }
        several => {
            let names = several.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>();
            format!("the columns are {}", names.join(", "))
        }
    };
    let find = |name: &str| {
        header
            .iter()
            .position(|column| column == name)
            .ok_or_else(|| DataError::Column { name: name.into(), known: known() })
    };
    let (name, exponent, what) = match spacing.ok_or_else(|| DataError::NoSpacing { known: known() })? {
        Spacing::Step(column) => (column, 1.0, "step"),
        Spacing::Cells { column, dimension } => (column, -1.0 / f64::from(*dimension), "number of cells"),
    };
    let own = find(name)?;
    let columns: Vec<usize> = match quantities {
        [] => (0..header.len()).filter(|column| *column != own).collect(),
        names => names.iter().map(|name| find(name)).collect::<Result<_, _>>()?,
    };
    if columns.contains(&own) {
        return Err(DataError::NoQuantity(name.clone()));
    }
    if columns.is_empty() {
        return Err(DataError::Empty("no column beside the spacing"));
    }
    let mut found: Vec<Quantity> = columns
        .iter()
        .map(|column| Quantity { name: header[*column].clone(), grids: Vec::new(), resolution: f64::INFINITY })
        .collect();
    for record in reader.records() {
        let record = record.map_err(table)?;
        let line = || record.position().map_or(0, |at| line_of(&text, at));
        let cell = |column: usize| record.get(column).unwrap_or_default();
        let number = |column: usize| {
            let text = cell(column);
            parsed(text).ok_or_else(|| DataError::Number {
                line: line(),
                column: header[column].clone(),
                text: text.into(),
            })
        };
        let size = number(own)?;
        if !(size > 0.0 && size.is_finite()) {
            return Err(DataError::Spacing { line: line(), column: name.clone(), value: cell(own).into(), what });
        }
        for (quantity, column) in found.iter_mut().zip(&columns) {
            let is_missing = ["", "-", "na", "n/a"].contains(&cell(*column).to_ascii_lowercase().as_str());
            let value = if is_missing { None } else { Some(number(*column)?) };
            if let Some(place) = value.filter(|v| v.is_finite()).and_then(|_| last_place(cell(*column))) {
                quantity.resolution = quantity.resolution.min(0.5 * place);
            }
            quantity.grids.push(Grid { h: size.powf(exponent), value: value.filter(|v| v.is_finite()) });
        }
    }
    if found[0].grids.is_empty() {
        return Err(DataError::Empty("no rows"));
    }
    for quantity in found.iter_mut().filter(|quantity| quantity.resolution.is_infinite()) {
        quantity.resolution = 0.0;
    }
    Ok(found)
}

/// What separates the cells of a table, as its header shows.
fn separator(text: &[u8]) -> u8 {
    let mut lines = text.split(|byte| *byte == b'\n');
    let header = lines.find(|line| !line.starts_with(b"#") && !line.trim_ascii().is_empty()).unwrap_or_default();
    [b',', b';', b'\t'].into_iter().find(|separator| header.contains(separator)).unwrap_or(b',')
}

/// The unit of the last digit of a decimal number: 10⁻⁵ for `0.97050`, 10⁻⁸ for `1.5e-7`.
fn last_place(text: &str) -> Option<f64> {
    let lower = text.to_ascii_lowercase().replace('d', "e");
    let (mantissa, exponent) = lower.split_once('e').unwrap_or((&lower, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, digits)| digits.len());
    let exponent: i32 = exponent.parse().ok()?;
    Some(10_f64.powi(exponent - i32::try_from(decimals).ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_digit_given_is_the_resolution() {
        for (text, place) in
            [("0.97050", 1e-5), ("-6", 1.0), ("1.5e-7", 1e-8), ("2.0E+3", 1e2), ("2.50D-3", 1e-5), (".5", 0.1)]
        {
            let found = last_place(text).expect("a number");
            assert!((found / place - 1.0).abs() < 1e-14, "{text}: {found}");
        }
    }

    #[test]
    fn cells_become_spacings_and_missing_values_stay_missing() {
        let text = "# a study\ncells,drag,lift\n8000, 1.50,\n1000,1.6,NaN\n";
        let spacing = Spacing::Cells { column: "cells".into(), dimension: 3 };
        let read = read(text.as_bytes(), Some(&spacing), &[]).expect("a table");
        assert_eq!(read.len(), 2);
        assert!((read[0].grids[0].h - 0.05).abs() < 1e-16 && (read[0].grids[1].h - 0.1).abs() < 1e-15);
        assert_eq!(read[0].resolution, 0.005);
        // Each quantity by its own digits.
        let unlike = "h,drag,lift\n0.2,1.4,1.123456\n0.1,1.1,1.03\n";
        let found = super::read(unlike.as_bytes(), Some(&Spacing::Step("h".into())), &[]).expect("a table");
        assert!((found[0].resolution - 0.05).abs() < 1e-16 && (found[1].resolution - 5e-7).abs() < 1e-20);
        assert!(read[1].grids.iter().all(|grid| grid.value.is_none()));
    }

    #[test]
    fn a_spreadsheet_may_separate_by_semicolons_or_tabs_and_mark_its_byte_order() {
        let read = |text: &str| read(text.as_bytes(), Some(&Spacing::Step("h".into())), &[]).expect("a table");
        let plain = read("# x, y\nh,u\n0.2,1.5\n0.1,1.25\n");
        assert_eq!(plain.len(), 1);
        assert_eq!(read("\u{feff}h;u\r\n0.2;1.5\r\n0.1;1.25\r\n"), plain);
        assert_eq!(read("h\tu\n0.2\t1.5\n0.1\t1.25\n"), plain);
        assert_eq!(read("| h | u |\n|---|---|\n| 0.2 | 1.5 |\n| 0.1 | 1.25 |\n"), plain);
        assert_eq!(
            read("\\begin{tabular}{ll}\n$h$ & $u$ \\\\ \\hline\n0.2 & 1.5 \\\\\n0.1 & 1.25 \\\\\n\\end{tabular}\n"),
            plain
        );
    }

    #[test]
    fn what_cannot_be_read_is_named_with_its_place() {
        let step = || Spacing::Step("h".into());
        let fails = |text: &str, spacing: Spacing, names: &[String]| {
            read(text.as_bytes(), Some(&spacing), names).map(|_| ()).expect_err(text).to_string()
        };
        assert_eq!(fails("h,u\n0.1,one\n", step(), &[]), "line 2, column `u`: `one` is not a number");
        assert!(fails("h,u\n0.1,1\n0,2\n", step(), &[]).starts_with("line 3, column `h`: 0 is no step"));
        assert!(fails("h,u\ninf,1\n", step(), &[]).starts_with("line 2, column `h`: inf is no step"));
        assert!(fails("dx,u\n0.1,1\n", step(), &[]).contains("the columns are `dx`, `u`"));
        assert!(fails("h,u\n0.1,1\n", step(), &["v".into()]).contains("no column is named `v`"));
        assert!(fails("h u\n0.1 1\n", step(), &[]).contains("the only one is `h u`; commas, semicolons or tabs"));
        assert!(fails("h,u\n0.1,1\n", step(), &["h".into()]).contains("`h` holds the spacings"));
        assert!(fails("", step(), &[]).contains("no header"));
        assert!(fails("0.1,1\n0.05,2\n", step(), &[]).contains("its first row holds numbers"));
        assert!(fails("h;u\n0,1;1\n", step(), &[]).contains("decimals have a point"));
        assert!(fails("h,u,u\n0.1,1,2\n", step(), &[]).contains("two columns"));
        assert_eq!(fails("h,u\n0.1,1\n0.05,1,2\n", step(), &[]), "line 3: the row has 3 cells, and the header 2");
        let unsaid = read(&b"h,u\n0.1,1\n"[..], None, &[]).expect_err("no spacing").to_string();
        assert!(unsaid.ends_with("the columns are `h`, `u`"), "{unsaid}");
        assert!(fails("h,u\n", step(), &[]).contains("no rows"));
        assert!(fails("h\n1\n", step(), &[]).contains("beside the spacing"));
    }
}
