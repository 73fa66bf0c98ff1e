//! Whether the closed schemes are symplectic.

use lsvi::Variational;
use lsvi::closure::{Linear, LinearClosure, PositionMomentum};
use lsvi::discrete::Trapezoidal;

use crate::chapter::StudyError;
use crate::claim::measure::{problem, text};
use crate::claim::{Case, Claim, Finding};
use crate::measure::norm::Extremes;

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "S24-m-1",
        source: "[S24] Eq. (8)",
        statement: "The conventional map (vₙ, pₙ) → (vₙ₊₁, pₙ₊₁) is symplectic.",
        criterion: "The determinant of the derivative of a live step is 1 to rounding, on linear and on quadratic drag.",
        decide: conventional,
    },
    Claim {
        id: "S24-m-2",
        source: "[S24] Title, Sections 2 and 3",
        statement: "Methods I and II, the closed schemes, are symplectic integrators.",
        criterion: "The determinant of the derivative of a live step as a map of (v, p) is 1 to rounding, on linear and on \
                    quadratic drag.",
        decide: closed,
    },
];

/// ∂(v₁, p₁)/∂(v₀, p₀) of live steps with a few sizes on both drags, by implicit differentiation: what it is about and its
/// determinant.
fn determinants<C: LinearClosure>(name: &str, closure: impl Fn() -> C) -> Result<Vec<(String, f64)>, StudyError> {
    let mut found = Vec::new();
    for drag in ["linear-drag", "quadratic-drag"] {
        let problem = problem(drag, &[])?;
        for h in [0.01, 0.1, 0.5] {
            let mut method = Variational::new(Trapezoidal::new(problem.lagrangian()?), closure());
            let map = method.step_with_tangent(0.0, h, &mut [1.0], &mut [0.0])?;
            found.push((format!("determinant, {name} on {drag}, h = {h}"), map.determinant()));
        }
    }
    Ok(found)
}

/// The entries of the map are sums of terms of size 1/h ≤ 100, of which the determinant multiplies two.
const ROUNDOFF: f64 = 100.0 * 100.0 * 16.0 * f64::EPSILON;

fn area_kept(found: Vec<(String, f64)>) -> Vec<Case> {
    found.into_iter().map(|(what, det)| Case::between(what, det, 1.0 - ROUNDOFF, 1.0 + ROUNDOFF)).collect()
}

fn conventional() -> Result<Finding, StudyError> {
    let found = determinants("conventional", || PositionMomentum)?;
    let worst = found.iter().map(|(_, det)| (det - 1.0).abs()).largest();
    let evidence = format!("The determinant differs from 1 by {} at most.", text(worst));
    Ok(Finding::on(area_kept(found), evidence).because(
        "It is the map that the discrete Lagrangian generates. On these problems it is also the unstable one, S24-a.",
    ))
}

fn closed() -> Result<Finding, StudyError> {
    let mut found = determinants("method-i", || Linear::METHOD_I)?;
    found.extend(determinants("method-ii", || Linear::METHOD_II)?);
    let largest = found.iter().map(|(_, det)| det.abs()).largest();
    let evidence =
        format!("No determinant exceeds {}: a step collapses every area of the (v, p) plane.", text(largest));
    Ok(Finding::on(area_kept(found), evidence).holds_where("For the conventional map only, S24-m-1.").because(
        "A closure discards pₙ: a step is a map of v alone, and (v₁, p₁) does not depend on p₀. That the motion on \
             p = 0 encloses no area is true of every one-step method for v, implicit Euler included, and conserves \
             nothing. What makes Method I useful is least squares, not symplecticity.",
    ))
}
