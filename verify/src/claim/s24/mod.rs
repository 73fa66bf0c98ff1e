//! The claims of \[S24\].

mod dissipation;
mod drag;
mod poiseuille;
mod question;
mod rivals;
mod stability;
mod structure;

use super::Claim;
use crate::experiment::errors::Ahead;
use crate::experiment::{Context, StudyError};

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

/// Where the largest error of a method is below `times` a rival's.
fn ahead(
    context: &Context,
    problem: &'static str,
    [method, rival]: [&'static str; 2],
    times: f64,
    between: [f64; 2],
) -> Result<Vec<[f64; 2]>, StudyError> {
    Ok(context.get(Ahead { problem, method, rival, times, between })?.to_vec())
}

/// Methods I and II as named in the registry.
const BOTH: [&str; 2] = ["method-i", "method-ii"];
/// The baseline methods of the paper.
const BASELINES: [&str; 2] = ["implicit-euler", "rk4"];
/// What a run of Method II on quadratic drag from v₀ = 1 meets at h = 1, where X²(1 + X) = W²(1 − W) of X = h v₁ and W = h v₀ has the
/// root 0 twice.
const FOLD: &str = "none at the fold, where two roots of its step meet at v₁ = 0: refused by the library";
