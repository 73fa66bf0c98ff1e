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
