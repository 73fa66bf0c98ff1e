//! A wall set in motion at once, followed with large steps; beside it a smooth flow.

use std::sync::Arc;

use super::{Context, Study, StudyError, prose};
use crate::evidence::number::{rounded_down, rounded_up, short};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Requirement, Series, Table};
use crate::experiment::end_errors::{EndErrors, EndState, Found, Truth};
use crate::measure::norm::Extremes;
use crate::row;

pub(super) const STUDY: Study = Study {
    id: "couette-large-steps",
    title: "Couette flow with large steps",
    question: "Where does Method I win against the methods that one would otherwise take for diffusion, and where does it lose?",
    source: "[S24] Section 5; claims j, n",
    run: study,
};

const METHODS: [&str; 5] = ["method-i", "trapezoidal", "tr-bdf2", "bdf2", "implicit-euler"];
const CELLS: [usize; 3] = [64, 256, 1024];
const STEPS: [f64; 3] = [0.1, 0.05, 0.02];
const END: f64 = 1.0;

/// What is measured of a run.
#[derive(Debug, Clone, Copy)]
enum Measure {
    /// The error at the end.
    End,
    /// The error after the first step.
    First,
}

/// The rows of the table: a flow, and what of it.
const CASES: [(&str, &str, Measure); 3] = [
    ("channel-couette", "impulsive wall, t = 1", Measure::End),
    ("channel-couette", "impulsive wall, first step", Measure::First),
    ("channel-womersley", "smooth, t = 1", Measure::End),
];

fn study(context: &Context) -> Result<Evidence, StudyError> {
    let mut evidence = Evidence::default();
    contest(&mut evidence, context)?;
    profiles(&mut evidence, context)?;
    Ok(evidence)
}

/// The errors of one run against the flow itself.
fn run(flow: &str, method: &str, cells: usize, h: f64) -> EndErrors {
    EndErrors {
        problem: format!("{flow} cells={cells}"),
        method: method.into(),
        h,
        pieces: 1,
        t_end: END,
        truth: Truth::Solution,
    }
}

/// Who wins, case by case.
fn contest(evidence: &mut Evidence, context: &Context) -> Result<(), StudyError> {
    let mut settings = Vec::new();
    for (name, label, what) in CASES {
        settings.extend(CELLS.iter().flat_map(|cells| STEPS.map(|h| (name, label, what, *cells, h))));
    }
    let runs = settings.iter().flat_map(|(name, _, _, cells, h)| METHODS.map(|method| run(name, method, *cells, *h)));
    let found = context.get_each(runs.collect())?;
    let measured: Vec<Vec<f64>> = settings
        .iter()
        .zip(found.chunks(METHODS.len()))
        .map(|((_, _, what, ..), found)| {
            let of = |found: &Arc<Found>| match what {
                Measure::End => found.end,
                Measure::First => found.first,
            };
            found.iter().map(of).collect()
        })
        .collect();
    let mut rows = Vec::new();
    for ((_, label, _, cells, h), errors) in settings.iter().zip(&measured) {
        let setting = [Cell::Text((*label).into()), Cell::Integer(*cells as i64), Cell::Number(*h)];
        let numbers = errors.iter().map(|error| Cell::Number(*error));
        rows.push(setting.into_iter().chain(numbers).chain([Cell::Text(best(errors).into())]).collect());
    }
    let of_case = |label: &str| -> Vec<&[f64]> {
        let of_case = settings.iter().zip(&measured).filter(|((_, l, ..), _)| *l == label);
        of_case.map(|(_, errors)| errors.as_slice()).collect()
    };
    let cases @ [impulsive, first, smooth] = &CASES.map(|(_, label, _)| of_case(label));
    evidence.checks.extend(checks(cases));
    let [at_most, or_more] =
        [rounded_up, rounded_down].map(|rounded: fn(f64, usize) -> f64| move |value| short(rounded(value, 4)));
    let values = [
        ("rings", or_more(least(impulsive, |e| e[1] / e[0]))),
        ("first", at_most(largest(first, |e| e[0] / rivals(e)))),
        ("tr_bdf2", at_most(largest(impulsive, |e| e[2] / e[0]))),
        ("bdf2", or_more(least(impulsive, |e| e[3] / e[0]))),
        ("smooth", or_more(least(smooth, |e| e[0] / e[1]))),
        ("smooth_tr_bdf2", at_most(largest(smooth, |e| e[2] / e[1]))),
    ];
    evidence.notes = prose::fill(include_str!("couette_large_steps.md"), &values)?;
    let caption =
        "Largest error in the channel with large steps, against the exact flow. The last column names the best method.";
    let columns = [&["case", "cells", "h"], METHODS.as_slice(), &["best"]].concat();
    evidence.tables.push(Table::new("couette-contest", caption, &columns, rows));
    Ok(())
}

/// The method with the least error. An error that is not a number is that of none.
fn best(errors: &[f64]) -> &'static str {
    let known = METHODS.into_iter().zip(errors).filter(|(_, error)| !error.is_nan());
    known.min_by(|a, b| a.1.total_cmp(b.1)).map_or("", |(name, _)| name)
}

/// The errors of all methods in each setting of a case.
type Case<'a> = Vec<&'a [f64]>;

fn least(case: &Case, ratio: impl Fn(&[f64]) -> f64) -> f64 {
    case.iter().map(|errors| ratio(errors)).smallest()
}

fn largest(case: &Case, ratio: impl Fn(&[f64]) -> f64) -> f64 {
    case.iter().map(|errors| ratio(errors)).largest()
}

/// The least error of the methods other than Method I.
fn rivals(errors: &[f64]) -> f64 {
    errors[1..].iter().copied().smallest()
}

/// What is said of the three cases.
fn checks([impulsive, first, smooth]: &[Case; 3]) -> [Check; 7] {
    [
        Check::new(
            "impulsive/trapezoidal-rings",
            "The trapezoidal rule still rings at t = 1: its error over Method I's, least over N and h",
            least(impulsive, |e| e[1] / e[0]),
            Requirement::Above(1.0),
            "R(∞) = −1: what the wall excites stays, with alternating sign; Method I has R(∞) = 0",
        ),
        Check::new(
            "impulsive/implicit-euler",
            "Implicit Euler is less accurate than Method I at t = 1: least ratio of the errors",
            least(impulsive, |e| e[4] / e[0]),
            Requirement::Above(1.0),
            "first order against second",
        ),
        Check::new(
            "impulsive/tr-bdf2",
            "TR-BDF2 is the better one at t = 1: the largest ratio of its error to Method I's",
            largest(impulsive, |e| e[2] / e[0]),
            Requirement::AtMost(1.0),
            "it is L-stable as well, with error constant (4 − 3√2)/6 = −0.04 for Method I's 1/6",
        ),
        Check::new(
            "first/method-i",
            "The first step of Method I has an error that no N and h make small: the least of them over the largest",
            least(first, |e| e[0]) / largest(first, |e| e[0]),
            Requirement::AtLeast(0.5),
            "the error is a function of the distance from the wall over √(νh), whatever h; one of first order would fall to a fifth",
        ),
        Check::new(
            "first/best",
            "After the first step Method I is the best of all: its error over that of the next, largest over N and h",
            largest(first, |e| e[0] / rivals(e)),
            Requirement::Below(1.0),
            "for z < 0, |R(z) − e^z| is at most 0.07 for Method I, and up to 0.2 for implicit Euler",
        ),
        Check::new(
            "smooth/trapezoidal",
            "On smooth data the trapezoidal rule is the better one: Method I's error over its, least over N and h",
            least(smooth, |e| e[0] / e[1]),
            Requirement::Above(1.0),
            "the defects are h²(¼ Jᵀv″ − v‴/12) and −h² v‴/12",
        ),
        Check::new(
            "smooth/tr-bdf2",
            "On smooth data TR-BDF2 is better still: its error over the trapezoidal rule's, largest over N and h",
            largest(smooth, |e| e[2] / e[1]),
            Requirement::AtMost(1.0),
            "error constant −0.04 for −1/12",
        ),
    ]
}

/// Points nearest to the moving wall that are drawn.
const DRAWN: usize = 40;

/// The flow near the wall after ten steps.
fn profiles(evidence: &mut Evidence, context: &Context) -> Result<(), StudyError> {
    const H: f64 = 0.1;
    let mut rows = Vec::new();
    let mut panels = Vec::new();
    for cells in CELLS {
        let place = |i: usize| 2.0 * (i + 1) as f64 / cells as f64 - 1.0;
        let mut record = |label: &str, values: &[f64], mark: Mark| {
            let near = values.len() - DRAWN.min(values.len());
            let points: Vec<(f64, f64)> = (near..values.len()).map(|i| (place(i), values[i])).collect();
            rows.extend(points.iter().map(|(y, u)| row![cells, label, *y, *u]));
            Series::new(label, points, mark)
        };
        let mut curves = Vec::new();
        let ends = context.get_each(METHODS.map(|method| EndState(run("channel-couette", method, cells, H))).into())?;
        for (method, end) in METHODS.into_iter().zip(&ends) {
            curves.push(record(method, &end.state, Mark::Line));
        }
        curves.push(record("exact", &ends[0].exact, Mark::Guide));
        let (title, x, y) = (format!("N = {cells}"), Axis::linear("y"), Axis::linear("u"));
        panels.push(Panel { title, x, y, series: curves, ..Panel::default() });
    }
    let caption = "Couette flow at t = 1 after ten steps of h = 0.1, at the forty points next to the wall that was set in \
                   motion: the trapezoidal rule still carries the jump, with a sign that alternates from step to step, and the \
                   more of it the finer the grid; of the others little is left.";
    evidence.tables.push(Table::data("couette-profiles", caption, &["cells", "method", "y", "u"], rows));
    let (id, caption, data) = ("couette-profiles".into(), caption.into(), "couette-profiles".into());
    evidence.figures.push(Figure { id, caption, data, panels, columns: 3 });
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;

    #[test]
    fn extremes_are_over_all_settings_and_lose_no_nan() {
        let [a, b, c] = [[1.0, 20.0], [1.0, 5.0], [1.0, 10.0]];
        let ratio = |e: &[f64]| e[1] / e[0];
        let case: Case = vec![&a, &b, &c];
        assert_eq!((least(&case, ratio), largest(&case, ratio)), (5.0, 20.0));
        let lost: Case = vec![&a, &[1.0, f64::NAN], &c];
        assert!(least(&lost, ratio).is_nan() && largest(&lost, ratio).is_nan());
        assert_eq!(rivals(&[1.0, 4.0, 3.0, 5.0]), 3.0);
        assert!(rivals(&[1.0, 4.0, f64::NAN, 5.0]).is_nan());
    }

    /// A NaN of either sign, as different machines make them, is first or last in the total order.
    #[test]
    fn the_best_method_has_the_least_error() {
        for (place, name) in METHODS.into_iter().enumerate() {
            for other in [2.0, f64::NAN, -f64::NAN] {
                let mut errors = [3.0, 4.0, 2.0, 5.0, 6.0];
                errors[(place + 1) % METHODS.len()] = other;
                errors[place] = 1.0;
                assert_eq!(best(&errors), name);
            }
        }
        assert_eq!(best(&[f64::NAN; 5]), "");
    }

    /// Errors in the order of [`METHODS`], with every ratio a little inside of what is required in all settings but one, where one
    /// is a little outside.
    #[test]
    fn one_setting_outside_of_what_is_required_fails_its_check() {
        const INSIDE: [[f64; 5]; 3] =
            [[1.0, 1.01, 0.99, 1.0, 1.01], [0.0101, 0.0204, 0.0300, 0.0300, 0.0204], [1.01, 1.0, 0.99, 9.0, 9.0]];
        // The case, the method whose error is another one, that error, and the check that it fails.
        const OUTSIDE: [(usize, usize, f64, usize); 7] = [
            (0, 1, 0.99, 0),
            (0, 4, 0.99, 1),
            (0, 2, 1.01, 2),
            (1, 0, 0.0050, 3),
            (1, 3, 0.0100, 4),
            (2, 0, 0.999, 5),
            (2, 2, 1.01, 6),
        ];
        let failing = |case: usize, method: usize, error: f64, place: usize| -> Vec<usize> {
            let mut settings = INSIDE.map(|errors| [errors; 3]);
            settings[case][place][method] = error;
            let cases = settings.each_ref().map(|case| case.iter().map(|errors| errors.as_slice()).collect());
            let failing = checks(&cases).into_iter().enumerate().filter(|(_, check)| check.outcome != Outcome::Pass);
            failing.map(|(check, _)| check).collect()
        };
        assert_eq!(failing(0, 0, INSIDE[0][0], 0), [0; 0]);
        for (case, method, error, check) in OUTSIDE {
            for place in 0..3 {
                assert_eq!(failing(case, method, error, place), [check]);
                assert!(failing(case, method, f64::NAN, place).contains(&check));
            }
        }
    }
}
