//! Variational integrators of mechanics: stability, symplecticity, what is kept, and the tables of \[KY21\].

use std::sync::Arc;

use super::table::rows;
use super::{Row, Tolerance, Truth};
use crate::chapter::constraints::TAUS;
use crate::chapter::long_runs::short_runs;
use crate::claim;
use crate::claim::ky21::tables::{TAU, half_unit, reproduced};
use crate::experiment::constraint::{Held, Radius};
use crate::experiment::energy_drift::Kind;
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
                // The derivative that vanishes there is known to some hundred roundings, and of slope 0.1 or more.
                let tolerance = Tolerance::absolute(1e3 * f64::EPSILON * tau, "rounding over the slope at the root");
                let truth = known.map(|known| {
                    let value = root([tau - 1e-3, tau + 1e-3], |tau| known.trace(tau).abs() - 2.0);
                    // |R| − 2 near its root: a dozen roundings of terms a hundred times as large as the result.
                    let source = format!("|R| = 2 in {}", known.source);
                    value.map(|value| Truth { value, allowance: 1e-9, source })
                });
                let truth = truth.map(|truth| truth.ok_or("the closed form has no end there")).transpose()?;
                rows.push(Row::number(key, tau, tolerance).with_truth(truth));
            }
        }
    }
    Ok(rows)
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
                let tolerance = Tolerance::absolute(0.01, "roundoff moves the finest defect used by a tenth at most");
                let source = "theory: the order of the method and one more".to_owned();
                let truth = Truth { value: expected.order, allowance: expected.band, source };
                Row::number(key, line.slope, tolerance).with_truth(truth)
            }
        }
    };
    Ok(found.iter().map(row).collect())
}

/// The largest energy errors in 1000 steps, and the change of angular momenta.
pub(super) fn long_runs(context: &Context) -> Result<Vec<Row>, StudyError> {
    let mut rows = Vec::new();
    for drift in context.get_each(short_runs(context)?)? {
        let mut push = |what: &str, value: f64, truth: Option<Truth>| {
            let tolerance = Tolerance::absolute(drift.rounding, "the rounding of the steps");
            let key = format!("{} {} {what}", drift.problem, drift.method);
            rows.push(Row::number(key, value, tolerance).with_truth(truth));
        };
        push("energy error", drift.largest(), None);
        if let Some(change) = drift.momentum {
            let is_kept = drift.kind == Kind::Symplectic;
            let truth = is_kept.then(|| Truth::vanishes(drift.rounding, "Noether's theorem"));
            push("change of the angular momentum", change, truth);
        }
    }
    Ok(rows)
}

/// What runs under a constraint keep.
pub(super) fn constraints(context: &Context) -> Result<Vec<Row>, StudyError> {
    let mut rows = Vec::new();
    for kept in context.get_each(Held::all()?)? {
        let mut push = |what: &str, value: f64, atol: f64, vanishes: bool| {
            let key = format!("{} {} {what}", kept.problem, kept.method);
            let truth = vanishes.then(|| Truth::vanishes(atol, "held, or kept"));
            rows.push(Row::number(key, value, Tolerance::absolute(atol, "rounding of the run")).with_truth(truth));
        };
        push("position", kept.position, Held::PLACE, true);
        push("hidden", kept.hidden, Held::PLACE, true);
        push("momentum", kept.momentum, kept.rounding, kept.is_symplectic);
        // On the circle the energy is that of the angular momentum.
        push("energy", kept.energy, kept.rounding, kept.problem == "circle");
    }
    Ok(rows)
}

/// The radial errors of the scheme (23).
pub(super) fn circle_growth(context: &Context) -> Result<Vec<Row>, StudyError> {
    let mut rows = Vec::new();
    for tau in TAUS {
        let found = context.get(Radius { tau })?;
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
        for (what, value, truth) in
            [("first", found.first, Some(first)), ("ratio", found.ratio, ratio), ("visible_at", visible, None)]
        {
            let tolerance = Tolerance::relative(rtol, "roundings of |q| over the first error");
            rows.push(Row::number(format!("{tau} {what}"), value, tolerance).with_truth(truth));
        }
    }
    Ok(rows)
}

/// Tables 1 and 2, with what is printed as the truth, except where it cannot be reproduced.
pub(super) fn printed_table(context: &Context, id: &str) -> Result<Vec<Row>, StudyError> {
    // A rounding in each of 500 steps, of sixteen operations on numbers up to 1.5, acts on all later ones; a forward
    // difference divides by τ.
    let rounding = 24.0 * f64::EPSILON * 500.0 * 500.0 / 2.0;
    Ok(rows(&claim::table(context, id)?, &["t", "scheme", "start", "quantity"], &["value"], |entry| {
        let scale = if entry.text("quantity") == Some("energy") { 2.0 / TAU } else { 1.0 };
        let tolerance = Tolerance::absolute(scale * rounding, "roundings of the recursion");
        let printed = entry.number("printed").filter(|printed| reproduced(id, entry.value, *printed));
        let source = || "printed digits".into();
        (tolerance, printed.map(|value| Truth { value, allowance: half_unit(id, value), source: source() }))
    }))
}

/// Orders and errors of path fitting by degree, on the pendulum and on Kepler's problem.
///
/// An order log₂(e/e′) of two errors that are known to ρ is known to ρ (1/e + 1/e′)/ln 2.
pub(super) fn path_fitted_orders(context: &Context) -> Result<Vec<Row>, StudyError> {
    let table = claim::table(context, "claims-path-fitted-orders")?;
    let values = ["order_equispaced", "error_equispaced", "order_gauss", "error_gauss"];
    Ok(rows(&table, &["problem", "degree"], &values, |entry| {
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
    }))
}
