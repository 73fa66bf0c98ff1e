//! What several claims measure.

use crate::evidence::{Cell, Table, number};
use crate::experiment::StudyError;
use crate::measure::norm::{distance, larger};
use crate::measure::search::try_root;
use crate::method;
use crate::problem::{self, Problem};
use crate::run::run;

/// The problem `name` with parameters given as text.
pub(super) fn problem(name: &str, set: &[(&str, &str)]) -> Result<Box<dyn Problem>, StudyError> {
    let set: Vec<_> = set.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
    Ok(problem::build(name, &set)?)
}

/// All states of a run, the initial one first, up to the first that fails or is not finite.
pub(super) fn trajectory(
    problem: &dyn Problem,
    method: &str,
    h: f64,
    horizon: f64,
) -> Result<Vec<(f64, Vec<f64>)>, StudyError> {
    let mut states = Vec::new();
    let method = method::parse(method)?;
    // What has been seen until a failure is the result.
    let _ = run(problem, &*method, h, horizon, |state| states.push((state.t, state.q.clone())));
    Ok(states)
}

/// Largest distance of the first `n` components of a run from the exact solution; infinite if the run breaks off.
pub(super) fn distance_from_exact(
    problem: &dyn Problem,
    method: &str,
    h: f64,
    horizon: f64,
    n: usize,
) -> Result<f64, StudyError> {
    let states = trajectory(problem, method, h, horizon)?;
    let reached = states.last().map_or(0.0, |(t, _)| *t);
    if reached < horizon - 0.5 * h {
        return Ok(f64::INFINITY);
    }
    states.iter().try_fold(0.0_f64, |worst, (t, state)| {
        let exact = problem.exact(*t).ok_or("no exact solution is known")?;
        Ok(larger(worst, distance(&state[..n], &exact[..n])))
    })
}

/// The state after one step of size `h`.
pub(super) fn one_state(problem: &dyn Problem, method: &str, h: f64) -> Result<Vec<f64>, StudyError> {
    Ok(run(problem, &*method::parse(method)?, h, h, |_| {})?.end.q)
}

/// Where `f` changes its sign between two numbers; there has to be such a place.
pub(super) fn threshold(
    what: &str,
    low: f64,
    high: f64,
    f: impl FnMut(f64) -> Result<f64, StudyError>,
) -> Result<f64, StudyError> {
    try_root([low, high], f)?.ok_or_else(|| format!("{what}: no change of sign between {low} and {high}").into())
}

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
