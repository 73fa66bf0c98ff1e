//! The claims of \[KY21\].

mod circle;
mod oscillator;
mod pendulum;
mod structure;
mod tables;

use super::Claim;

pub(crate) use oscillator::orders_golden;
pub(crate) use tables::table_golden;

/// By subject.
pub(super) const ALL: &[&[Claim]] =
    &[oscillator::CLAIMS, tables::CLAIMS, structure::CLAIMS, pendulum::CLAIMS, circle::CLAIMS];
