//! The claims of \[KY21\].

mod circle;
mod oscillator;
mod pendulum;
mod structure;
pub(crate) mod tables;

use super::Claim;

/// By subject.
pub(super) const ALL: &[&[Claim]] =
    &[oscillator::CLAIMS, tables::CLAIMS, structure::CLAIMS, pendulum::CLAIMS, circle::CLAIMS];
