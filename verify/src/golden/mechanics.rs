//! Variational integrators of mechanics: stability, symplecticity, what is kept, and the tables of \[KY21\].

use std::sync::Arc;

use super::table::{Entry, rows};
use super::{Row, Tolerance, Truth, order};
use crate::chapter::constraints::TAUS;
use crate::chapter::long_runs::short_runs;
use crate::claim;
use crate::claim::ky21::tables::{TAU, half_unit, reproduced};
use crate::experiment::constraint::{Held, Kept, Radii, Radius};
use crate::experiment::energy_drift::{Drift, Kind};
use crate::experiment::oscillator::Stable;
use crate::experiment::symplectic_defect::{Defects, Found};
use crate::experiment::{Context, StudyError};
use crate::measure::order::OrderFit;
use crate::measure::search::root;
use crate::method;
use crate::theory::oscillator::Recurrence;

/// The ends of the intervals of stability on the oscillator, and those that the closed forms give.
pub(super) fn oscillator_stability(context: &Context) -> Result<Vec<Row>, StudyError> {
    let mut rows = Vec::new();
    for method in method::integrators().iter().map(|method| method.name()) {
        let known = Recurrence::of(&method);
        let intervals = context.get(Stable { method: method.clone() })?;
        for (i, (from, to)) in intervals.iter().enumerate() {
            for (end, tau) in [("from", *from), ("to", *to)] {
                let key = format!("{method} {} {end}", i + 1);
                if tau == 0.0 || tau == Stable::LARGEST {
                    rows.push(Row::text(key, if tau == 0.0 { "0" } else { "beyond" }));
                    continue;
                }
                rows.push(end_of_stability(key, tau, known)?);
            }
        }
    }
    Ok(rows)
}

/// An end of an interval of stability, and where the closed form of the method, if it is known, has one near it.
fn end_of_stability(key: String, tau: f64, known: Option<&Recurrence>) -> Result<Row, StudyError> {
    // The derivative that vanishes there is known to some hundred roundings, and of slope 0.1 or more.
    let tolerance = Tolerance::absolute(1e3 * f64::EPSILON * tau, "rounding over the slope at the root");
    let truth = known.map(|known| {
        let value = root([tau - 1e-3, tau + 1e-3], |tau| known.trace(tau).abs() - 2.0);
        // |R| − 2 near its root: a dozen roundings of terms a hundred times as large as the result.
        let source = format!("|R| = 2 in {}", known.source);
        value.map(|value| Truth { value, allowance: 1e-9, source })
    });
    let truth = truth.map(|truth| truth.ok_or("the closed form has no end there")).transpose()?;
    Ok(Row::number(key, tau, tolerance).with_truth(truth))
}

/// The power of h of each defect of symplecticity.
pub(super) fn symplecticity(context: &Context) -> Result<Vec<Row>, StudyError> {
    let found = context.get_each(Defects::all()?)?;
    let row = |found: &Arc<Found>| {
        let key = format!("{} {}", found.problem, found.method);
        match &found.fit {
            None => {
                let reason = "a defect within its rounding is noise, which any build may change";
                let truth = Truth::vanishes(1.0, "theory: it is symplectic");
                Row::number(key, found.excess(), Tolerance::absolute(1.0, reason)).with_truth(truth)
            }
            Some(OrderFit { line: None, reason, .. }) => Row::text(key, reason),
            Some(OrderFit { line: Some(line), expected, .. }) => {
                order::row(key, line.slope, expected, "defect", "theory: the order of the method and one more")
            }
        }
    };
    Ok(found.iter().map(row).collect())
}

/// The largest energy errors in 1000 steps, and the change of angular momenta.
pub(super) fn long_runs(context: &Context) -> Result<Vec<Row>, StudyError> {
    Ok(context.get_each(short_runs(context)?)?.iter().flat_map(|drift| long_run(drift)).collect())
}

fn long_run(drift: &Drift) -> Vec<Row> {
    let row = |what: &str, value: f64, truth: Option<Truth>| {
        let tolerance = Tolerance::absolute(drift.rounding, "the rounding of the steps");
        Row::number(format!("{} {} {what}", drift.problem, drift.method), value, tolerance).with_truth(truth)
    };
    let mut rows = vec![row("energy error", drift.largest(), None)];
    if let Some(change) = drift.momentum {
        let is_kept = drift.kind == Kind::Symplectic;
        let truth = is_kept.then(|| Truth::vanishes(drift.rounding, "Noether's theorem"));
        rows.push(row("change of the angular momentum", change, truth));
    }
    rows
}

/// What runs under a constraint keep.
pub(super) fn constraints(context: &Context) -> Result<Vec<Row>, StudyError> {
    Ok(context.get_each(Held::all()?)?.iter().flat_map(|kept| constrained(kept)).collect())
}

fn constrained(kept: &Kept) -> [Row; 4] {
    let row = |what: &str, value: f64, atol: f64, vanishes: bool| {
        let key = format!("{} {} {what}", kept.problem, kept.method);
        let truth = vanishes.then(|| Truth::vanishes(atol, "held, or kept"));
        Row::number(key, value, Tolerance::absolute(atol, "rounding of the run")).with_truth(truth)
    };
    [
        row("position", kept.position, Held::PLACE, true),
        row("hidden", kept.hidden, Held::PLACE, true),
        row("momentum", kept.momentum, kept.rounding, kept.is_symplectic),
        // On the circle the energy is that of the angular momentum.
        row("energy", kept.energy, kept.rounding, kept.problem == "circle"),
    ]
}

/// The radial errors of the scheme (23).
pub(super) fn circle_growth(context: &Context) -> Result<Vec<Row>, StudyError> {
    let mut rows = Vec::new();
    for tau in TAUS {
        rows.extend(growing(tau, &*context.get(Radius { tau })?));
    }
    Ok(rows)
}

fn growing(tau: f64, found: &Radii) -> [Row; 3] {
    // A few roundings of |q| relative to the first error, with which all later ones grow.
    let rtol = 8.0 * f64::EPSILON * 32.0 / tau.powi(4);
    let growth = Radius::growth();
    let first = Truth { value: 1.0, allowance: tau * tau + rtol, source: "−τ⁴/32".into() };
    let ratio = (tau <= 0.02).then(|| Truth {
        value: growth,
        allowance: 0.01 * growth.abs(),
        source: "−(3 + 2√2) for small angles".into(),
    });
    let visible = found.visible.map_or(f64::NAN, |step| step as f64);
    [("first", found.first, Some(first)), ("ratio", found.ratio, ratio), ("visible_at", visible, None)].map(
        |(what, value, truth)| {
            let tolerance = Tolerance::relative(rtol, "roundings of |q| over the first error");
            Row::number(format!("{tau} {what}"), value, tolerance).with_truth(truth)
        },
    )
}

/// Tables 1 and 2, with what is printed as the truth, except where it cannot be reproduced.
pub(super) fn printed_table(context: &Context, id: &str) -> Result<Vec<Row>, StudyError> {
    let table = claim::table(context, id)?;
    Ok(rows(&table, &["t", "scheme", "start", "quantity"], &["value"], |entry| printed(id, entry)))
}

fn printed(id: &str, entry: &Entry) -> (Tolerance, Option<Truth>) {
    // A rounding in each of 500 steps, of sixteen operations on numbers up to 1.5, acts on all later ones; a forward
    // difference divides by τ.
    let rounding = 24.0 * f64::EPSILON * 500.0 * 500.0 / 2.0;
    let scale = if entry.text("quantity") == Some("energy") { 2.0 / TAU } else { 1.0 };
    let tolerance = Tolerance::absolute(scale * rounding, "roundings of the recursion");
    let printed = entry.number("printed").filter(|printed| reproduced(id, entry.value, *printed));
    let source = || "printed digits".into();
    (tolerance, printed.map(|value| Truth { value, allowance: half_unit(id, value), source: source() }))
}

/// Orders and errors of path fitting by degree, on the pendulum and on Kepler's problem.
pub(super) fn path_fitted_orders(context: &Context) -> Result<Vec<Row>, StudyError> {
    let table = claim::table(context, "claims-path-fitted-orders")?;
    let values = ["order_equispaced", "error_equispaced", "order_gauss", "error_gauss"];
    Ok(rows(&table, &["problem", "degree"], &values, path_fitted))
}

/// An order log₂(e/e′) of two errors that are known to ρ is known to ρ (1/e + 1/e′)/ln 2.
fn path_fitted(entry: &Entry) -> (Tolerance, Option<Truth>) {
    let degree = entry.number("degree").unwrap_or(f64::NAN);
    // 400 steps at most, each with roundings of numbers up to 2 that differentiation magnifies m² times.
    let rounding = 400.0 * degree * degree * 2.0 * f64::EPSILON;
    let (order, error) = match entry.column {
        "order_equispaced" => (2.0 * (degree / 2.0).floor(), "error_equispaced"),
        "order_gauss" => (2.0 * (degree - 1.0), "error_gauss"),
        _ => return (Tolerance::absolute(rounding, "roundings of the steps"), None),
    };
    let coarser = entry.number(error).unwrap_or(f64::NAN);
    let finer = coarser / entry.value.exp2();
    let moved = rounding * (coarser.recip() + finer.recip()) / std::f64::consts::LN_2;
    let truth = Truth { value: order, allowance: 0.3, source: "theory, between two steps".into() };
    (Tolerance::absolute(moved, "roundings of the steps over the two errors, in powers of 2"), Some(truth))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Table;
    use crate::experiment::energy_drift::Window;
    use crate::row;

    /// |2 − τ²| is 2 at τ = 2 and nowhere within a thousandth of 2.002; the allowance is 10⁻⁹.
    #[test]
    fn an_end_of_stability_is_held_to_the_closed_form() {
        let end = |off: f64| end_of_stability("end".into(), 2.0 + off, Recurrence::of("stormer-verlet"));
        for (off, is_true) in [(0.0, true), (0.9e-9, true), (1.1e-9, false), (-1.1e-9, false), (1e-6, false)] {
            assert_eq!(end(off).expect("an end is near").is_fit(), is_true, "{off}");
        }
        assert!(end(2e-3).is_err() && end(f64::NAN).is_err());
        assert!(end_of_stability("end".into(), 3.0, None).expect("nothing is known").is_fit());
    }

    #[test]
    fn a_symplectic_method_keeps_the_angular_momentum_within_rounding() {
        let is_fit = |kind, change| {
            let windows = vec![Window { t: 0.5, mean: 0.0, largest: 1e-3 }];
            let (problem, method, momentum) = ("kepler", "some".into(), Some(change));
            let drift =
                Drift { problem, method, kind, steps: 10, windows, drift: 0.0, stderr: 0.0, rounding: 1e-14, momentum };
            long_run(&drift).iter().all(Row::is_fit)
        };
        assert!(is_fit(Kind::Symplectic, 0.9e-14) && is_fit(Kind::Dissipative, 1.1e-14));
        assert!(!is_fit(Kind::Symplectic, 1.1e-14) && !is_fit(Kind::Dissipative, f64::NAN));
    }

    /// Of position, its derivative, angular momentum and energy, twice the allowance is wrong where it is held or kept.
    #[test]
    fn what_is_held_or_kept_vanishes() {
        let fit = |problem: &'static str, is_symplectic: bool, size: f64| {
            let [place, change] = [size * Held::PLACE, size * 1e-14];
            let (position, hidden, momentum, energy, rounding) = (place, place, change, change, 1e-14);
            let method = "some".into();
            let kept = Kept { problem, method, position, hidden, momentum, energy, is_symplectic, rounding };
            constrained(&kept).map(|row| row.is_fit())
        };
        assert_eq!(fit("circle", true, 0.9), [true; 4]);
        assert_eq!(fit("circle", true, 1.1), [false; 4]);
        assert_eq!(fit("spherical-pendulum", true, 1.1), [false, false, false, true]);
        assert_eq!(fit("spherical-pendulum", false, 1.1), [false, false, true, true]);
    }

    /// The first error is known up to τ² of itself, and the growth of small angles up to a hundredth.
    #[test]
    fn radial_errors_are_held_to_theory() {
        let fit = |tau: f64, first: f64, ratio: f64| {
            let (ratio, visible) = (ratio * Radius::growth(), Some(9));
            growing(tau, &Radii { errors: Vec::new(), first, ratio, visible, far: None }).map(|row| row.is_fit())
        };
        let inside = [1.0 + 0.9 * 0.01 * 0.01, 1.009];
        let outside = [1.0 + 1.2 * 0.01 * 0.01, 1.011];
        assert_eq!(fit(0.01, inside[0], inside[1]), [true; 3]);
        assert_eq!(fit(0.01, outside[0], outside[1]), [false, false, true]);
        assert_eq!(fit(0.1, 1.02, 2.0), [false, true, true]);
    }

    /// Path fitting of degree 3 is of order 2 at equidistant nodes and of order 4 at Gauss nodes.
    #[test]
    fn orders_by_degree_are_held_to_theory() {
        let fit = |equispaced: f64, gauss: f64| {
            let columns = ["problem", "degree", "order_equispaced", "error_equispaced", "order_gauss", "error_gauss"];
            let cells = vec![row!["pendulum", 3_i64, equispaced, 1e-3, gauss, 1e-6]];
            let rows = rows(&Table::new("orders", "", columns, cells), &["degree"], &columns[2..], path_fitted);
            rows.iter().map(Row::is_fit).collect::<Vec<_>>()
        };
        assert_eq!(fit(2.25, 3.75), [true; 4]);
        assert_eq!(fit(1.65, 4.35), [false, true, false, true]);
    }

    /// Four decimals are printed.
    #[test]
    fn a_value_is_held_to_the_digits_that_it_reproduces() {
        let truth = |value: f64| {
            let table = Table::new("some", "", ["quantity", "value", "printed"], vec![row!["x", value, 1.2346]]);
            let entry = Entry { table: &table, row: &table.rows[0], column: "value", value };
            printed("ky21-table-1", &entry).1.map(|truth| (truth.value, truth.allowance))
        };
        assert_eq!(truth(1.234_58), Some((1.2346, 0.5e-4)));
        assert_eq!(truth(1.234_66), None);
    }
}
