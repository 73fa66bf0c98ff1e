//! What several chapters build their evidence from.

use crate::evidence::{Check, Requirement};
use crate::measure::order::OrderFit;

/// The verdict on an order of convergence.
pub(super) fn order_check(id: impl Into<String>, statement: impl Into<String>, fit: &OrderFit) -> Check {
    Check {
        id: id.into(),
        statement: statement.into(),
        outcome: fit.verdict.into(),
        measured: fit.line.map(|line| line.slope),
        required: Some(Requirement::Near(fit.expected.order, fit.expected.band)),
        reason: fit.reason.clone(),
    }
}
