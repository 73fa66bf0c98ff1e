//! Whether the closed schemes are symplectic.

use crate::claim::measure::at_most;
use crate::claim::{Case, Claim, Finding, Quantifier};
use crate::experiment::momentum_map::{Closed, MomentumMap};
use crate::experiment::{Context, StudyError};
use crate::measure::norm::Extremes;

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "S24-m-1",
        source: "[S24] Eq. (8)",
        statement: "The conventional map (vₙ, pₙ) → (vₙ₊₁, pₙ₊₁) is symplectic.",
        quantifier: Quantifier::Universal,
        criterion: "The determinant of the derivative of a live step is 1 to rounding, on linear and on quadratic drag.",
        decide: conventional,
    },
    Claim {
        id: "S24-m-2",
        source: "[S24] Title, Sections 2 and 3",
        statement: "Methods I and II, the closed schemes, are symplectic integrators.",
        quantifier: Quantifier::Universal,
        criterion: "The determinant of the derivative of a live step as a map of (v, p) is 1 to rounding, on linear and on \
                    quadratic drag.",
        decide: closed,
    },
];

/// ∂(v₁, p₁)/∂(v₀, p₀) of live steps with a few sizes on both drags: its determinant, which ought to be 1.
fn determinants(context: &Context, name: &str, closure: Closed) -> Result<Vec<Case>, StudyError> {
    let mut found = Vec::new();
    for problem in ["linear-drag", "quadratic-drag"] {
        for h in [0.01, 0.1, 0.5] {
            let determinant = context.get(MomentumMap { problem, closure, h })?.determinant;
            let what = format!("determinant, {name} on {problem}, h = {h}");
            found.push(Case::between(what, determinant, 1.0 - roundoff(h), 1.0 + roundoff(h)));
        }
    }
    Ok(found)
}

/// The entries of the map are quotients of D₁₁L_d, D₁₂L_d and D₂₂L_d, which are 1/h and at most as much again for h up to 1, a few roundings each; in
/// the determinant two of size 1 + 1/h² cancel but for 1.
fn roundoff(h: f64) -> f64 {
    16.0 * f64::EPSILON * (1.0 + (h * h).recip())
}

fn conventional(context: &Context) -> Result<Finding, StudyError> {
    let found = determinants(context, "conventional", Closed::Conventional)?;
    let worst = found.iter().map(|case| (case.measured - 1.0).abs()).largest();
    let evidence = format!("The determinant differs from 1 by {} at most.", at_most(worst));
    Ok(Finding::on(found, evidence).because(
        "It is the map that the discrete Lagrangian generates. On linear drag it is also the unstable one, S24-a.",
    ))
}

fn closed(context: &Context) -> Result<Finding, StudyError> {
    let mut found = determinants(context, "method-i", Closed::MethodI)?;
    found.extend(determinants(context, "method-ii", Closed::MethodII)?);
    let largest = found.iter().map(|case| case.measured).largest();
    let evidence =
        format!("No determinant exceeds {}: a step collapses every area of the (v, p) plane.", at_most(largest));
    Ok(Finding::on(found, evidence).holds_where("For the conventional map only, S24-m-1.").because(
        "A closure discards pₙ: a step is a map of v alone, and (v₁, p₁) does not depend on p₀. That the motion on \
             p = 0 encloses no area is true of every one-step method for v, implicit Euler included, and conserves \
             nothing. What makes Method I useful is least squares, not symplecticity.",
    ))
}
