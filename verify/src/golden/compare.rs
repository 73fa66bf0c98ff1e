//! The one comparison of a golden file with what the code computes now.

use super::{Malformed, Number, Recorded, Row, Tolerance, Truth, Value, parse};
use insta::internals::SnapshotContents;
use insta::{Comparator, Snapshot};
use std::collections::{HashMap, HashSet};
use std::fmt;

/// A row that is not as it should be.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// The row's key.
    pub key: String,
    /// What differs.
    pub difference: Difference,
}

/// How a row differs.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Difference {
    /// In the file, but no longer computed.
    Vanished,
    /// Computed, but not in the file.
    Added {
        /// The value.
        new: String,
    },
    /// A number moved by more than its tolerance.
    Number {
        /// In the file.
        old: f64,
        /// Computed now.
        new: f64,
        /// How far it may move.
        tolerance: f64,
        /// What it ought to be.
        truth: Option<f64>,
    },
    /// A text, or what is stated about a number, is another one.
    Text {
        /// Which column.
        column: &'static str,
        /// In the file.
        old: String,
        /// Computed now.
        new: String,
    },
    /// A computed number is wrong, whatever the file says.
    Untrue {
        /// Computed now.
        value: f64,
        /// What it ought to be, and how closely.
        truth: Truth,
    },
    /// A computed row that no golden may hold.
    Unfit(String),
}

impl Difference {
    /// Whether the fault is in the computed row itself, so that it must not be written.
    #[must_use]
    pub fn is_wrong(&self) -> bool {
        matches!(self, Self::Untrue { .. } | Self::Unfit(_))
    }
}

/// Compares the rows of a file with the rows computed now; empty if all is well. The sequence of rows does not matter.
#[must_use]
pub fn compare(old: &[Recorded], new: &[Row]) -> Vec<Change> {
    let mut recorded: HashMap<&str, &Recorded> = old.iter().map(|r| (r.row.key.as_str(), r)).collect();
    let mut changes = faults(new);
    for row in new {
        let differences = match recorded.remove(row.key.as_str()) {
            None => vec![Difference::Added { new: text_of(&row.value) }],
            Some(old) => differences(old, row),
        };
        changes.extend(differences.into_iter().map(|difference| Change { key: row.key.clone(), difference }));
    }
    let vanished = old.iter().filter(|r| recorded.contains_key(r.row.key.as_str()));
    changes.extend(vanished.map(|r| Change { key: r.row.key.clone(), difference: Difference::Vanished }));
    changes
}

/// What is wrong with computed rows, whatever the file says.
fn faults(rows: &[Row]) -> Vec<Change> {
    let mut changes = Vec::new();
    if rows.is_empty() {
        let difference = Difference::Unfit("it has no rows".to_owned());
        changes.push(Change { key: "the golden".to_owned(), difference });
    }
    let mut seen = HashSet::new();
    for row in rows {
        let mut push = |difference| changes.push(Change { key: row.key.clone(), difference });
        if !seen.insert(&row.key) {
            push(Difference::Unfit("the key is computed twice".to_owned()));
        }
        let Value::Number(Number { value, tolerance: Tolerance { rtol, atol, reason }, truth }) = &row.value else {
            continue;
        };
        if !value.is_finite() {
            push(Difference::Unfit(format!("the value is {value}")));
        }
        if !(*rtol >= 0.0 && rtol.is_finite() && *atol >= 0.0 && atol.is_finite()) {
            push(Difference::Unfit(format!("rtol = {rtol}, atol = {atol} is no tolerance")));
        }
        if reason.is_empty() {
            push(Difference::Unfit("the tolerance has no reason".to_owned()));
        }
        let Some(truth) = truth else { continue };
        if !(truth.value.is_finite() && truth.allowance >= 0.0 && truth.allowance.is_finite())
            || truth.source.is_empty()
        {
            push(Difference::Unfit("the truth needs finite numbers and a source".to_owned()));
        } else if value.is_finite() && truth.distance(*value) > truth.allowance {
            push(Difference::Untrue { value: *value, truth: truth.clone() });
        }
    }
    changes
}

fn differences(old: &Recorded, new: &Row) -> Vec<Difference> {
    match (&old.row.value, &new.value) {
        (Value::Number(number), Value::Number(new)) => number_differences(number, old.distance, new),
        (old, new) => text("value", text_of(old), text_of(new)).into_iter().collect(),
    }
}

fn number_differences(old: &Number, recorded_distance: Option<f64>, new: &Number) -> Vec<Difference> {
    // Never true of NaN.
    let agree = |old: f64, new: f64, width: f64| (new - old).abs() <= width;
    let width = |frozen: f64| new.tolerance.width(frozen);
    let moved = !agree(old.value, new.value, width(old.value));
    let mut found = Vec::new();
    if moved {
        let truth = new.truth.as_ref().map(|t| t.value);
        found.push(Difference::Number { old: old.value, new: new.value, tolerance: width(old.value), truth });
    }
    found.extend(bound("rtol", old.tolerance.rtol, new.tolerance.rtol));
    found.extend(bound("atol", old.tolerance.atol, new.tolerance.atol));
    found.extend(text("tolerance_reason", &old.tolerance.reason, &new.tolerance.reason));
    match (&old.truth, &new.truth) {
        (None, None) => {}
        (Some(old_truth), Some(truth)) => {
            if !agree(old_truth.value, truth.value, width(old_truth.value)) {
                found.extend(text("truth", old_truth.value, truth.value));
            }
            found.extend(bound("allowance", old_truth.allowance, truth.allowance));
            found.extend(text("truth_source", &old_truth.source, &truth.source));
            // A difference of two numbers, each of which may have moved by its tolerance.
            let (recorded, distance) = (recorded_distance.unwrap_or(f64::NAN), truth.distance(new.value));
            if !moved && !agree(recorded, distance, width(old.value) + width(old_truth.value)) {
                found.extend(text("distance", recorded, distance));
            }
        }
        (old, new) => {
            let source = |t: &Option<Truth>| t.as_ref().map_or("none", |t| &t.source).to_owned();
            found.extend(text("truth_source", source(old), source(new)));
        }
    }
    found
}

/// Bounds that are computed, from the rounding of a run for one, move with it; a hundredth of a bound decides nothing.
fn bound(column: &'static str, old: f64, new: f64) -> Option<Difference> {
    if (new - old).abs() <= 0.01 * old { None } else { text(column, old, new) }
}

fn text<T: PartialEq + fmt::Display>(column: &'static str, old: T, new: T) -> Option<Difference> {
    (old != new).then(|| Difference::Text { column, old: old.to_string(), new: new.to_string() })
}

fn text_of(value: &Value) -> String {
    match value {
        Value::Text(text) => format!("`{text}`"),
        Value::Number(number) => format!("{:?}", number.value),
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let key = &self.key;
        match &self.difference {
            Difference::Vanished => write!(f, "{key}: vanished"),
            Difference::Added { new } => write!(f, "{key}: new row, {new}"),
            Difference::Text { column, old, new } => write!(f, "{key}: {column}\n  old  {old}\n  new  {new}"),
            Difference::Unfit(what) => write!(f, "{key}: WRONG, {what}"),
            Difference::Untrue { value, truth } => {
                let Truth { value: true_value, allowance, source } = truth;
                let distance = truth.distance(*value);
                writeln!(f, "{key}: WRONG, {distance:.2e} from the truth, allowed {allowance:.2e}")?;
                write!(f, "  value  {value:?}\n  truth  {true_value:?}\n  from   {source}")
            }
            Difference::Number { old, new, tolerance, truth } => {
                writeln!(f, "{key}\n  old  {old:?}\n  new  {new:?}")?;
                let change = new - old;
                if *old == 0.0 {
                    write!(f, "  change {change:+.2e} from zero, tolerance {tolerance:.2e}")?;
                } else {
                    let (relative, tolerance) = (change / old.abs(), tolerance / old.abs());
                    write!(f, "  relative change {relative:+.2e}, tolerance {tolerance:.2e}")?;
                }
                let Some(truth) = truth else { return write!(f, "\n  no truth is known") };
                let (was, is) = ((old - truth).abs(), (new - truth).abs());
                let direction = if is < was {
                    "toward the truth"
                } else if is > was {
                    "AWAY from the truth"
                } else {
                    "no nearer to the truth"
                };
                write!(f, "\n  {direction}: distance {was:.2e} -> {is:.2e}")
            }
        }
    }
}

/// [`compare`] for insta: two snapshots match where every number is within its tolerance and every text is the same.
#[derive(Debug, Clone, Copy)]
pub struct NumericComparator;

impl Comparator for NumericComparator {
    fn matches(&self, reference: &Snapshot, test: &Snapshot) -> bool {
        let ((old, faults), (new, new_faults)) = (read(reference), read(test));
        let new: Vec<Row> = new.into_iter().map(|r| r.row).collect();
        faults.is_empty() && new_faults.is_empty() && compare(&old, &new).is_empty()
    }

    fn dyn_clone(&self) -> Box<dyn Comparator> {
        Box::new(*self)
    }
}

fn read(snapshot: &Snapshot) -> (Vec<Recorded>, Vec<Malformed>) {
    match snapshot.contents() {
        SnapshotContents::Binary(Some(bytes)) => parse(bytes),
        SnapshotContents::Binary(None) => parse(&[]),
        SnapshotContents::Text(text) => parse(text.to_string().as_bytes()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By more than the tolerance of the value, which the distance is left at.
    #[test]
    fn a_truth_that_was_edited_is_noticed() {
        let row = |truth: f64| {
            let truth = Truth { value: truth, allowance: 1e-2, source: "a table".into() };
            Row::number("catalan", 0.916, Tolerance::relative(1e-3, "printed to three digits")).with_truth(truth)
        };
        let truth = 0.915_965_594_177_219_f64;
        let changes = |part: f64| {
            let distance = Some((0.916 - truth).abs());
            let old = Recorded { row: row(truth * (1.0 + part * 1e-3)), distance };
            compare(&[old], &[row(truth)]).into_iter().map(|change| change.difference).collect::<Vec<_>>()
        };
        assert_eq!([-0.9, 0.9].map(changes), [vec![], vec![]]);
        for part in [-1.1, 1.1] {
            let differences = changes(part);
            let [Difference::Text { column: "truth", new, .. }] = &differences[..] else { panic!("{differences:?}") };
            assert_eq!(*new, truth.to_string());
        }
    }
}
