//! Every golden, one line each.

use super::{Golden, Row, Tolerance, Truth, figures, mechanics, order};
use crate::chapter::figures::{FIGURE_2, FIGURE_4, FIGURE_7};
use crate::claim::{self, Judged, Verdict};
use crate::experiment::orders::{OrderError, Orders, Truth as Reference};
use crate::experiment::{Context, StudyError};
use crate::problem::poiseuille_series::{self, Tabulated};
use std::sync::Arc;

/// All goldens, computed in `context`.
#[must_use]
pub fn all(context: &Arc<Context<'static>>) -> Vec<Golden> {
    let golden = |name: &str, rows: fn(&Context) -> Result<Vec<Row>, StudyError>| {
        let context = Arc::clone(context);
        Golden::new(name, move || rows(&context))
    };
    vec![
        golden("closed-forms", figures::closed_forms),
        golden("figure-2", |context| figures::maxima(&FIGURE_2, context)),
        golden("figure-4", |context| figures::maxima(&FIGURE_4, context)),
        golden("figure-7", |context| figures::maxima(&FIGURE_7, context)),
        golden("orders", orders),
        golden("poiseuille-series", poiseuille_series),
        golden("claims", verdicts),
        golden("ky21-table-1", |context| mechanics::printed_table(context, "ky21-table-1")),
        golden("ky21-table-2", |context| mechanics::printed_table(context, "ky21-table-2")),
        golden("path-fitted-orders", mechanics::path_fitted_orders),
        golden("oscillator-stability", mechanics::oscillator_stability),
        golden("symplecticity", mechanics::symplecticity),
        golden("long-runs", mechanics::long_runs),
        golden("constraints", mechanics::constraints),
        golden("circle-growth", mechanics::circle_growth),
    ]
}

/// The fitted orders of every pair whose truth is exact or tabulated.
fn orders(context: &Context) -> Result<Vec<Row>, StudyError> {
    let mut rows = Vec::new();
    for pair in context.get(Orders)?.iter() {
        if matches!(pair.truth, Reference::Numerical(_)) {
            continue;
        }
        let key = format!("{} {}", pair.problem, pair.method);
        let fit = match &pair.fit {
            Err(OrderError::Untold { because, .. }) => {
                rows.push(Row::text(key, format!("no order is predicted: {because}")));
                continue;
            }
            Err(error) => return Err(error.to_string().into()),
            Ok(fit) => fit,
        };
        rows.push(match &fit.line {
            Some(line) => order::row(key, line.slope, &fit.expected, "error", "theory"),
            None => Row::text(key, fit.reason.clone()),
        });
    }
    Ok(rows)
}

fn poiseuille_series(_: &Context) -> Result<Vec<Row>, StudyError> {
    beside_the_series(poiseuille_series::tabulated()?)
}

/// The velocities at the places of a table, with what it has there as their truth.
fn beside_the_series(table: Vec<Tabulated>) -> Result<Vec<Row>, StudyError> {
    let mut rows = Vec::new();
    let digits = poiseuille_series::digits();
    for Tabulated { y, t, u } in table {
        let tolerance = Tolerance::relative(1e-14, "sin, exp and erfc differ by an ulp or so between platforms");
        let truth = Truth {
            value: u,
            allowance: 1e-14 * u,
            source: format!("{digits} digits, verify/data/poiseuille-series.py"),
        };
        let value = poiseuille_series::velocity(2.0, y, t)?;
        rows.push(Row::number(format!("u(y={y:?} t={t:?})"), value, tolerance).with_truth(truth));
    }
    Ok(rows)
}

/// The verdicts as rows of a golden, with the number of comparisons that hold: within a qualified claim a change of what
/// is measured shows only there.
fn verdicts(context: &Context) -> Result<Vec<Row>, StudyError> {
    let mut rows = Vec::new();
    for judged in claim::judge(context) {
        let Judged { claim, finding } = &judged;
        let finding = finding.as_ref().map_err(|error| format!("{}: {error}", claim.id))?;
        rows.push(Row::text(claim.id, judged.verdict().map_or("broke off", Verdict::word)));
        rows.push(Row::text(format!("{} comparisons", claim.id), finding.score()));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The allowance is 10⁻¹⁴ of a velocity.
    #[test]
    fn a_velocity_is_held_to_the_table() {
        let all_fit = |factor: f64| {
            let table =
                poiseuille_series::tabulated().expect("a table").into_iter().filter(|entry| entry.u > 0.0).take(5);
            let table = table.map(|entry| Tabulated { u: factor * entry.u, ..entry }).collect();
            let rows = beside_the_series(table).expect("inside the channel");
            assert_eq!(rows.len(), 5);
            rows.iter().map(Row::is_fit).collect::<Vec<_>>()
        };
        assert_eq!(all_fit(1.0), [true; 5]);
        assert_eq!(all_fit(1.0 + 1e-12), [false; 5]);
    }
}
