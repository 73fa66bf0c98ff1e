//! Every golden, one line each.

use super::{Golden, Row, Tolerance, Truth};
use crate::problems::poiseuille_series;
use std::error::Error;

/// All goldens.
#[must_use]
pub fn all() -> Vec<Golden> {
    vec![Golden::new("poiseuille-series", poiseuille_series)]
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
