//! The rows of a solve on one screen.

use std::io::{self, Write};

use super::Row;
use crate::cli::layout::{columns, number, plain, right};

/// Rows kept: they fit on a screen of 24 lines with the heading and the summary.
const ROWS: usize = 17;

/// Columns of a terminal that one column of numbers takes.
const COLUMN: usize = 13;

/// At most [`ROWS`] rows, evenly thinned, and the last. What is kept is bounded, however many rows come.
pub(super) struct Table {
    columns: Vec<String>,
    components: usize,
    count: usize,
    stride: usize,
    kept: Vec<Kept>,
    last: Option<Kept>,
}

/// A [`Row`] of its own.
type Kept = (f64, Vec<f64>, Vec<Option<f64>>);

impl Table {
    pub(super) fn new(columns: Vec<String>, components: usize) -> Self {
        Self { columns, components, count: 0, stride: 1, kept: Vec::new(), last: None }
    }

    pub(super) fn push(&mut self, Row { t, values, errors }: Row) {
        let row = (t, values.to_vec(), errors.to_vec());
        if self.kept.len() == ROWS && self.count.is_multiple_of(self.stride) {
            let mut number = 0;
            self.kept.retain(|_| {
                number += 1;
                number % 2 == 1
            });
            self.stride *= 2;
        }
        if self.count.is_multiple_of(self.stride) {
            self.last = None;
            self.kept.push(row);
        } else {
            self.last = Some(row);
        }
        self.count += 1;
    }

    pub(super) fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let components = self.components;
        let extra = self.columns.len() - components;
        let shown = components.min(columns() / COLUMN - extra);
        let line = |cells: &mut dyn Iterator<Item = String>| -> String {
            cells.map(|cell| right(&cell, COLUMN)).collect::<String>()[1..].to_owned()
        };
        let headings = self.columns[..=shown].iter().chain(&self.columns[1 + components..]);
        writeln!(out, "{}", line(&mut headings.cloned()))?;
        for (t, values, errors) in self.kept.iter().chain(&self.last) {
            let numbers = [plain(*t)].into_iter().chain(values[..shown].iter().copied().map(number));
            let errors = errors.iter().map(|error| error.map_or_else(String::new, number));
            writeln!(out, "{}", line(&mut numbers.chain(errors)))?;
        }
        if shown < components {
            writeln!(out, "and {} more components; `--csv FILE` writes them all", components - shown)?;
        }
        if self.stride > 1 {
            writeln!(out, "1 row of {} is shown, out of {}; `--csv FILE` writes them all", self.stride, self.count)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(components: usize, rows: u32) -> String {
        let components_and_errors = (0..components).map(|k| format!("x{k}")).chain(["error".into(), "estimate".into()]);
        let mut table = Table::new(["t".into()].into_iter().chain(components_and_errors).collect(), components);
        for k in 0..rows {
            let values = vec![1.0; components];
            table.push(Row { t: f64::from(k), values: &values, errors: &[None, Some(0.5)] });
        }
        let mut out = Vec::new();
        table.write(&mut out).expect("written");
        String::from_utf8(out).expect("UTF-8")
    }

    /// As many as make the lines no wider.
    #[test]
    fn as_many_columns_are_shown_as_a_terminal_has() {
        let most = columns() / COLUMN;
        let fits = most - 3;
        assert!(!written(fits, 1).contains("more component"));
        for components in [fits + 1, fits + 7] {
            let text = written(components, 1);
            let heading = text.lines().next().expect("a heading");
            assert_eq!(heading.split_whitespace().count(), most, "{text}");
            assert!(text.contains(&format!("and {} more components", components - fits)), "{text}");
        }
    }

    /// Of 100 rows one of 8, 13 in all, and the last.
    #[test]
    fn rows_are_thinned_by_halves_until_they_fit_on_a_screen() {
        let text = written(1, 100);
        let times: Vec<f64> =
            text.lines().filter_map(|line| line.split_whitespace().next()?.parse().ok()).take(14).collect();
        let expected: Vec<f64> = (0..13).map(|k| 8.0 * f64::from(k)).chain([99.0]).collect();
        assert_eq!(times, expected, "{text}");
        assert!(text.ends_with("1 row of 8 is shown, out of 100; `--csv FILE` writes them all\n"), "{text}");
        assert!(!written(1, ROWS as u32).contains("is shown"));
    }
}
