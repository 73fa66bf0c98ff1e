//! What several claims measure.

use crate::chapter::StudyError;
use crate::evidence::{Cell, Table, number};
use crate::measure::norm::{distance, larger};
use crate::measure::search::try_root;
use crate::method;
use crate::problem::{self, Problem};
use crate::run::run;

/// The horizon of the figures of \[S24\].
pub(super) const HORIZON: f64 = 10.0;

/// The problem `name` with parameters given as text.
pub(super) fn problem(name: &str, set: &[(&str, &str)]) -> Result<Box<dyn Problem>, StudyError> {
    let set: Vec<_> = set.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
    Ok(problem::build(name, &set)?)
}

/// max |v_n − truth(t_n)| over the whole steps of size `h` in (0, `horizon`]; infinite if a step fails.
pub(super) fn max_error(
    problem: &dyn Problem,
    method: &str,
    h: f64,
    horizon: f64,
    truth: impl Fn(f64) -> f64,
) -> Result<f64, StudyError> {
    let mut worst = 0.0_f64;
    let end = h * (horizon / h + 1e-9).floor();
    let result = run(problem, &*method::parse(method)?, h, end, |state| {
        if state.t > 0.0 {
            worst = larger(worst, (state.q[0] - truth(state.t)).abs());
        }
    });
    Ok(if result.is_ok() { worst } else { f64::INFINITY })
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

/// The first component after one step of size `h`, `None` if the step fails.
pub(super) fn one_step(problem: &dyn Problem, method: &str, h: f64) -> Result<Option<f64>, StudyError> {
    Ok(run(problem, &*method::parse(method)?, h, h, |_| {}).ok().map(|run| run.end.q[0]))
}

/// The state after one step of size `h`.
pub(super) fn one_state(problem: &dyn Problem, method: &str, h: f64) -> Result<Vec<f64>, StudyError> {
    Ok(run(problem, &*method::parse(method)?, h, h, |_| {})?.end.q)
}

/// The growth factor R(h) of one step on v̇ = −v.
pub(super) fn growth(method: &str, h: f64) -> Result<f64, StudyError> {
    let problem = problem("linear-drag", &[])?;
    one_step(&*problem, method, h)?.ok_or_else(|| format!("{method} fails on v̇ = −v with h = {h}").into())
}

/// The point in (`low`, `high`), both positive, where `f` changes sign, by bisection of the logarithm; `None`
/// if the signs at the ends agree.
pub(super) fn sign_change(
    low: f64,
    high: f64,
    mut f: impl FnMut(f64) -> Result<f64, StudyError>,
) -> Result<Option<f64>, StudyError> {
    Ok(try_root([low.ln(), high.ln()], |x| f(x.exp()))?.map(f64::exp))
}

/// [`sign_change`] where there has to be one.
pub(super) fn threshold(
    what: &str,
    low: f64,
    high: f64,
    f: impl FnMut(f64) -> Result<f64, StudyError>,
) -> Result<f64, StudyError> {
    sign_change(low, high, f)?.ok_or_else(|| format!("{what}: no change of sign between {low} and {high}").into())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_the_closed_form() {
        // A handful of roundings on numbers of order 1.
        let near = |a: f64, b: f64| assert!((a - b).abs() < 8.0 * f64::EPSILON, "{a} and {b}");
        near(growth("method-i", 0.5).expect("linear"), 1.0 / 1.625);
        near(growth("method-ii", 0.5).expect("linear"), 0.75 / 1.25);
    }

    #[test]
    fn numbers_in_sentences_are_short() {
        let cases = [(0.0, "0"), (1.518_37, "1.518"), (12.345, "12.3"), (-0.012_345, "−0.0123"), (31415.9, "3.14×10⁴")];
        cases.iter().for_each(|(x, expected)| assert_eq!(text(*x), *expected));
        assert_eq!(text(-2.5e-7), "−2.5×10⁻⁷");
        assert_eq!(text(f64::INFINITY), "∞ (a step fails)");
    }

    #[test]
    fn thresholds_are_found_or_missed() {
        let root = sign_change(0.1, 10.0, |x| Ok(x * x - 2.0)).expect("no error").expect("changes sign");
        assert!((root - 2.0_f64.sqrt()).abs() < 4e-12, "{root}");
        assert!(sign_change(2.0, 10.0, |x| Ok(x * x - 2.0)).expect("no error").is_none());
        assert!(threshold("x", 2.0, 10.0, |x| Ok(x * x - 2.0)).is_err());
    }
}
