//! Method I on linear systems whose matrix is not normal: a search for stable systems that it amplifies.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::{Context, Study, StudyError, prose};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Requirement, Series, Table, number};
use crate::experiment::non_normal::{
    ASCENTS, Amplified, CHANGES, Dissipative, Example, Found, HIGHEST, MARGIN, MORE_CHANGES, ORDERS, OfOrder, Point,
    RANDOM, ROUNDOFF, Rivals, SEED, TRIED,
};
use crate::measure::norm::max_norm;
use crate::measure::stability::{numerical_abscissa, spectral_abscissa};
use crate::row;

pub(super) const STUDY: Study = Study {
    id: "non-normal",
    title: "Stable systems that Method I amplifies",
    question: "Is Method I stable for every stable linear system, or only for some kinds?",
    source: "[S24] Section 3; claim b, `unconditionally stable`",
    run,
};

/// A-stable Runge–Kutta methods beside Method I.
const RIVALS: &[&str] = &["trapezoidal", "implicit-midpoint", "implicit-euler", "sdirk2"];
/// Methods of the figure.
const SHOWN: &[&str] = &["method-i", "trapezoidal", "implicit-euler", "sdirk2"];

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let found = context.get_each(ORDERS.map(|order| Amplified { method: "method-i", order }).into())?;
    let dissipative = context.get(Dissipative)?;
    let (figure, runs) = example(&context.get(Example(SHOWN))?);
    let mut checks: Vec<Check> = found.iter().map(|found| check_search(found)).collect();
    checks.extend(dissipative_checks(&dissipative));
    checks.push(rivals_damp(&context.get(Rivals(RIVALS))?));
    let radius = |order: usize| found.iter().find(|found| found.order == order).map_or(f64::NAN, |found| found.radius);
    let values = [("three", 3), ("four", 4), ("five", 5)].map(|(name, order)| (name, number::short(radius(order))));
    let mut values = Vec::from(values);
    values.push(("margin", format!("−{MARGIN}")));
    Ok(Evidence {
        checks,
        tables: vec![matrices(&found), norms(&dissipative), runs],
        figures: vec![figure],
        notes: prose::fill(include_str!("non_normal.md"), &values)?,
        ..Evidence::default()
    })
}

fn check_search(found: &Found) -> Check {
    let reason = format!(
        "{ASCENTS} ascents from the best of {RANDOM} random matrices in {CHANGES} changes, the highest {HIGHEST} in \
         {MORE_CHANGES} more{}; seed {SEED}, live steps of h = 1",
        if found.order > 3 { ", as does the system of one unknown fewer beside one that decays by itself" } else { "" }
    );
    if found.order == 2 {
        return Check::new(
            "search/2",
            "No stable 2 × 2 system is amplified by Method I: largest spectral radius found",
            found.radius,
            Requirement::AtMost(1.0 + ROUNDOFF),
            reason,
        );
    }
    Check::new(
        format!("search/{}", found.order),
        format!("Method I amplifies some stable {0} × {0} system: largest spectral radius found", found.order),
        found.radius,
        Requirement::AtLeast(1.0 + 1e-3),
        reason,
    )
}

/// The same systems stepped by A-stable Runge–Kutta methods.
fn rivals_damp(radii: &[f64]) -> Check {
    Check::new(
        "rivals",
        "A-stable Runge–Kutta methods damp all of these systems: largest spectral radius",
        max_norm(radii),
        Requirement::AtMost(1.0),
        "the eigenvalues of R(hA) are R(hλ); trapezoidal rule, implicit midpoint, implicit Euler and SDIRK2",
    )
}

/// Systems whose symmetric part is negative semidefinite: |v| never grows.
fn dissipative_checks(found: &[OfOrder]) -> [Check; 3] {
    let reason = format!("{TRIED} random matrices −BᵀB + K, K skew, of each of the orders 2, 3 and 4, seed {SEED}");
    let largest = |of: fn(&OfOrder) -> f64| max_norm(&found.iter().map(of).collect::<Vec<_>>());
    [
        Check::new(
            "dissipative/radius",
            "Where the symmetric part of A is negative semidefinite Method I is stable: largest spectral radius",
            largest(|found| found.radius),
            Requirement::AtMost(1.0 + ROUNDOFF),
            reason.clone(),
        ),
        Check::new(
            "dissipative/norm",
            "Even there one step of Method I may lengthen v, which the solution never does: largest norm of a step",
            largest(|found| found.most_lengthened[2]),
            Requirement::AtLeast(1.0 + 1e-3),
            reason.clone(),
        ),
        Check::new(
            "dissipative/rule",
            "The trapezoidal rule lengthens no v on these systems: largest norm of a step",
            largest(|found| found.rule_norm),
            Requirement::AtMost(1.0 + ROUNDOFF),
            reason,
        ),
    ]
}

fn norms(found: &[OfOrder]) -> Table {
    let row = |found: &OfOrder| {
        let [symmetric, radius, norm, rule] = found.most_lengthened;
        row![found.order, symmetric, radius, norm, rule]
    };
    Table::new(
        "non-normal-norms",
        "Among random systems with a negative semidefinite symmetric part, those that one step of Method I lengthens most: \
         largest eigenvalue of the symmetric part, spectral radius and norm of the step, and the trapezoidal rule's norm.",
        ["order", "largest_symmetric", "spectral_radius", "norm", "trapezoidal_norm"],
        found.iter().map(row).collect(),
    )
}

/// A matrix in one line, rows separated by semicolons.
fn text(a: &DMatrix<f64>) -> String {
    let rows =
        a.row_iter().map(|row| row.iter().map(|x| format!("{x}").replace('-', "−")).collect::<Vec<_>>().join(", "));
    rows.collect::<Vec<_>>().join("; ")
}

fn matrices(found: &[Arc<Found>]) -> Table {
    let row = |found: &Arc<Found>| {
        vec![
            Cell::Integer(found.order as i64),
            Cell::Text(text(&found.matrix)),
            Cell::Number(spectral_abscissa(&found.matrix)),
            Cell::Number(numerical_abscissa(&found.matrix)),
            Cell::Number(found.radius),
        ]
    };
    Table::new(
        "non-normal-matrices",
        "The matrices hA, rows separated by semicolons, of those in the search the ones with the largest factor of a step of Method I, which for two \
         unknowns is no larger than 1: largest real part of an \
         eigenvalue, largest eigenvalue of the symmetric part, and spectral radius of a live step.",
        &["order", "matrix", "abscissa", "largest_symmetric", "spectral_radius"],
        found.iter().map(row).collect(),
    )
}

/// |v_n| from (1, 1, 1), and the spectral radius over the step size.
fn example(points: &[Point]) -> (Figure, Table) {
    let curve = |is_of_run: bool, name: &'static str| -> Vec<(f64, f64)> {
        let of_curve = points.iter().filter(|point| point.is_of_run == is_of_run && point.method == name);
        of_curve.map(|point| (point.x, point.value)).collect()
    };
    let mut runs = Vec::new();
    for name in SHOWN.iter().copied().chain(["exact"]) {
        let mark = if name == "exact" { Mark::Guide } else { Mark::Line };
        // What has decayed beyond ten digits says no more.
        runs.push(Series::new(name, curve(true, name).into_iter().filter(|(_, size)| *size > 1e-10).collect(), mark));
    }
    let mut radii: Vec<_> = SHOWN.iter().map(|name| Series::new(*name, curve(false, name), Mark::Line)).collect();
    let part = |point: &Point| if point.is_of_run { "run" } else { "step" };
    let rows = points.iter().map(|point| row![part(point), point.method, point.x, point.value]).collect();
    radii.push(Series::new("1", vec![(0.01, 1.0), (100.0, 1.0)], Mark::Guide));
    let panel = |title: &str, x, y, series| Panel { title: title.into(), x, y, series, field: None };
    let figure = Figure {
        id: "non-normal-example".into(),
        caption: "The stable 3 × 3 system of the table. Left: |v| over steps of h = 1 from v = (1, 1, 1). Right: spectral radius \
                  of a step over the step size; Method I is unstable where its curve is above 1."
            .into(),
        data: "non-normal-example".into(),
        panels: vec![
            panel("a run", Axis::linear("number of steps").between(0.0, Example::STEPS as f64), Axis::log("|v|"), runs),
            panel("over the step size", Axis::log("h"), Axis::linear("spectral radius").between(0.0, 1.6), radii),
        ],
        columns: 2,
    };
    let caption =
        "Norm |v| by number of steps, and spectral radius of a step by step size, of the stable 3 × 3 system.";
    (figure, Table::data("non-normal-example", caption, &["part", "method", "steps_or_h", "value"], rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_order_has_its_row() {
        let found = [2, 3, 4].map(|order| OfOrder { order, radius: 1.0, rule_norm: 1.0, most_lengthened: [1.0; 4] });
        let orders: Vec<String> = norms(&found).rows.iter().map(|row| row[0].to_string()).collect();
        assert_eq!(orders, ["2", "3", "4"]);
    }

    #[test]
    fn what_is_told_of_the_system_lengthened_most_stands_under_its_name() {
        let most_lengthened = [-0.25, 0.75, 1.25, 0.5];
        let table = norms(&[OfOrder { order: 3, radius: 1.0, rule_norm: 1.0, most_lengthened }]);
        let columns = ["largest_symmetric", "spectral_radius", "norm", "trapezoidal_norm"];
        let found = columns.map(|name| table.rows[0][table.column(name).expect("a column")].number());
        assert_eq!(found, most_lengthened.map(Some));
    }
}
