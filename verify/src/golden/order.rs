//! The row of a fitted order, with the order that theory expects as its truth.

use super::{Row, Tolerance, Truth};
use crate::measure::order::Expectation;

/// The order `slope` of what is called an error or a defect, `what`, beside the one `expected` by `source`.
pub(super) fn row(key: String, slope: f64, expected: &Expectation, what: &str, source: &str) -> Row {
    let reason = format!("roundoff moves the finest {what} used by a tenth at most");
    let truth = Truth { value: expected.order, allowance: expected.band, source: source.into() };
    Row::number(key, slope, Tolerance::absolute(0.01, reason)).with_truth(truth)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_order_outside_its_band_is_untrue() {
        let is_fit = |slope| row("order".into(), slope, &Expectation::new(2.0, 0.1), "error", "theory").is_fit();
        assert!(is_fit(1.91) && is_fit(2.09));
        assert!(!is_fit(1.89) && !is_fit(2.11) && !is_fit(f64::NAN));
    }
}
