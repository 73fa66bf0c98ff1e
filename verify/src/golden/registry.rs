//! Every golden, one line each.

use super::{Golden, Row, Tolerance, Truth};
use crate::chapter::{self, Context};
use crate::claim;
use crate::order;
use crate::problem::poiseuille_series;
use std::error::Error;

/// All goldens.
#[must_use]
pub fn all() -> Vec<Golden> {
    vec![
        Golden::new("closed-forms", chapter::closed_forms::golden),
        Golden::new("figure-2", chapter::figures::figure_2),
        Golden::new("figure-4", chapter::figures::figure_4),
        Golden::new("figure-7", chapter::figures::figure_7),
        Golden::new("orders", orders),
        Golden::new("poiseuille-series", poiseuille_series),
        Golden::new("claims", claim::verdicts),
        Golden::new("ky21-table-1", || claim::ky21::table_golden("ky21-table-1")),
        Golden::new("ky21-table-2", || claim::ky21::table_golden("ky21-table-2")),
        Golden::new("path-fitted-orders", claim::ky21::orders_golden),
        Golden::new("oscillator-stability", chapter::oscillator::golden),
        Golden::new("symplecticity", chapter::symplecticity::golden),
        Golden::new("long-runs", chapter::long_runs::golden),
        Golden::new("constraints", chapter::constraints::golden),
        Golden::new("circle-growth", chapter::constraints::growth_golden),
    ]
}

/// The fitted orders of every pair whose truth is exact or tabulated.
fn orders() -> Result<Vec<Row>, Box<dyn Error + Send + Sync>> {
    let mut rows = Vec::new();
    for pair in chapter::orders::measure_all(&Context::SILENT)? {
        if matches!(pair.truth, order::Truth::Numerical(_)) {
            continue;
        }
        let key = format!("{} {}", pair.problem, pair.method);
        let fit = match pair.fit {
            Err(error @ order::OrderError::Unmeasured(_)) => {
                rows.push(Row::text(key, error.to_string()));
                continue;
            }
            fit => fit?,
        };
        rows.push(match fit.line {
            Some(line) => {
                let tolerance = Tolerance::absolute(0.01, "roundoff moves the finest error used by a tenth at most");
                let truth =
                    Truth { value: fit.expected.order, allowance: fit.expected.band, source: "theory".to_owned() };
                Row::number(key, line.slope, tolerance).with_truth(truth)
            }
            None => Row::text(key, fit.reason),
        });
    }
    Ok(rows)
}

fn poiseuille_series() -> Result<Vec<Row>, Box<dyn Error + Send + Sync>> {
    let mut rows = Vec::new();
    for poiseuille_series::Tabulated { y, t, u } in poiseuille_series::tabulated()? {
        let tolerance = Tolerance::relative(1e-14, "sin, exp and erfc differ by an ulp or so between platforms");
        let truth =
            Truth { value: u, allowance: 1e-14 * u, source: "60 digits, verify/data/poiseuille-series.py".to_owned() };
        let value = poiseuille_series::velocity(2.0, y, t)?;
        rows.push(Row::number(format!("u(y={y:?} t={t:?})"), value, tolerance).with_truth(truth));
    }
    Ok(rows)
}
