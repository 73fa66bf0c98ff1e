//! The claims of \[S24\].

mod dissipation;
mod drag;
mod poiseuille;
mod question;
mod rivals;
mod stability;
mod structure;

use super::Claim;

/// By subject.
pub(super) const ALL: &[&[Claim]] = &[
    stability::CLAIMS,
    drag::CLAIMS,
    dissipation::CLAIMS,
    poiseuille::CLAIMS,
    structure::CLAIMS,
    rivals::CLAIMS,
    question::CLAIMS,
];

/// Methods I and II as named in the registry.
const BOTH: [&str; 2] = ["method-i", "method-ii"];
/// The yardsticks of the paper.
const YARDSTICKS: [&str; 2] = ["implicit-euler", "rk4"];
