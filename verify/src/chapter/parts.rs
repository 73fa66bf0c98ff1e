//! What the studies build their evidence from.

use crate::evidence::{Axis, Cell, Check, Mark, Outcome, Series, Table};

/// A table whose rows are shown.
pub(super) fn table(id: &str, caption: impl Into<String>, columns: &[&str], rows: Vec<Vec<Cell>>) -> Table {
    let columns = columns.iter().map(|name| (*name).into()).collect();
    Table { id: id.into(), caption: caption.into(), columns, rows, shown: true }
}

/// A table behind a figure.
pub(super) fn data(id: &str, caption: impl Into<String>, columns: &[&str], rows: Vec<Vec<Cell>>) -> Table {
    Table { shown: false, ..table(id, caption, columns, rows) }
}

/// A number, or nothing where there is none.
pub(super) fn number(x: f64) -> Cell {
    if x.is_nan() { Cell::Empty } else { Cell::Number(x) }
}

pub(super) fn linear_axis(label: &str, limits: Option<(f64, f64)>) -> Axis {
    Axis { label: label.into(), log: false, limits }
}

pub(super) fn log_axis(label: &str) -> Axis {
    Axis { label: label.into(), log: true, limits: None }
}

pub(super) fn series(label: impl Into<String>, points: Vec<(f64, f64)>, mark: Mark) -> Series {
    Series { label: label.into(), points, mark }
}

/// A decision on a number; one that is NaN never passes.
pub(super) fn check(
    id: impl Into<String>,
    statement: impl Into<String>,
    measured: f64,
    required: Required,
    reason: impl Into<String>,
) -> Check {
    let (holds, required) = match required {
        Required::AtMost(bound) => (measured <= bound, format!("≤ {}", text(bound))),
        Required::AtLeast(bound) => (measured >= bound, format!("≥ {}", text(bound))),
        Required::Within(low, high) => {
            ((low..=high).contains(&measured), format!("in [{}, {}]", text(low), text(high)))
        }
    };
    Check {
        id: id.into(),
        statement: statement.into(),
        outcome: if holds { Outcome::Pass } else { Outcome::Fail },
        measured: measured.is_finite().then_some(measured),
        required,
        reason: reason.into(),
    }
}

/// What is required of a number.
#[derive(Debug, Clone, Copy)]
pub(super) enum Required {
    AtMost(f64),
    AtLeast(f64),
    Within(f64, f64),
}

/// A bound in the shortest form: one a little beyond 1 shows by how much.
fn text(bound: f64) -> String {
    let excess = bound - 1.0;
    match bound.abs() {
        _ if excess != 0.0 && excess.abs() < 1e-4 => format!("1 + {excess:.0e}"),
        0.0 | 1e-3..1e5 => bound.to_string(),
        _ => format!("{bound:.2e}"),
    }
}
