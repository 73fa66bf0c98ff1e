//! Decay of errors, and stability on nonlinear problems.

use crate::claim::measure::text;
use crate::claim::{Case, Claim, Finding, Quantifier};
use crate::evidence::number;
use crate::experiment::errors::Decay;
use crate::experiment::one_step::{LeavesAt, OneStep};
use crate::experiment::{Context, StudyError};

use super::{BOTH, YARDSTICKS};

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "S24-f-1",
        source: "[S24] Section 3, Figure 1",
        statement: "On linear drag all errors decay to zero as t → ∞, at the steps of Figure 1.",
        quantifier: Quantifier::Universal,
        criterion: "For every method and step of Figure 1 the largest error on (20, 40] is at most half of that on (10, 20]: it \
                    falls at least like 1/t, or is roundoff.",
        decide: linear_errors_decay,
    },
    Claim {
        id: "S24-f-2",
        source: "[S24] Section 5, Figure 6",
        statement: "On Poiseuille flow all errors decay to zero as t → ∞, at the steps of Figure 6 from 0.0001 on.",
        quantifier: Quantifier::Universal,
        criterion: "For every method and the steps of Figure 6 from 0.0001 on the largest error on (20, 40] is at \
                    most half of that on (10, 20], or is roundoff.",
        decide: poiseuille_errors_decay,
    },
    Claim {
        id: "S24-h-1",
        source: "[S24] Abstract, Section 6",
        statement: "Method I is unconditionally stable for dissipative systems, nonlinear ones included.",
        quantifier: Quantifier::Universal,
        criterion: "On quadratic drag one live step from v₀ > 0 has a solution that continues v₀ from h = 0, and lies between 0 \
                    and v₀, for every W = h v₀ from 0.01 to 100.",
        decide: |context| nonlinear(context, "method-i"),
    },
    Claim {
        id: "S24-h-2",
        source: "[S24] Abstract, Section 6",
        statement: "Method II is unconditionally stable for dissipative systems, nonlinear ones included.",
        quantifier: Quantifier::Universal,
        criterion: "On quadratic drag one live step from v₀ > 0 has a solution that continues v₀ from h = 0, at most v₀ in size, \
                    for every W = h v₀ from 0.01 to 100.",
        decide: |context| nonlinear(context, "method-ii"),
    },
];

/// Late against early errors of the four methods of the figures on a problem.
fn decay(context: &Context, problem: &'static str, steps: &[f64]) -> Result<Vec<Case>, StudyError> {
    let mut cases = Vec::new();
    for method in BOTH.iter().chain(&YARDSTICKS) {
        for h in steps {
            let ratio = *context.get(Decay { problem, method, h: *h })?;
            cases.push(Case::at_most(format!("late against early error, {method}, h = {h}"), ratio, Decay::MOST));
        }
    }
    Ok(cases)
}

/// The case with the largest measured number.
fn slowest(cases: &[Case]) -> Result<&Case, StudyError> {
    Ok(cases.iter().max_by(|a, b| a.measured.total_cmp(&b.measured)).ok_or("no comparison")?)
}

fn linear_errors_decay(context: &Context) -> Result<Finding, StudyError> {
    let cases = decay(context, "linear-drag", &[2.5, 2.0, 1.5, 1.0, 0.1, 0.01])?;
    let worst = slowest(&cases)?;
    let limit = context.get(LeavesAt::unit_circle("rk4", 2.0, 4.0))?;
    let evidence = format!("The slowest decay leaves {} of the early error: {}.", text(worst.measured), worst.what);
    Ok(Finding::on(cases, evidence).because(format!(
        "All growth factors are below 1 in size at these steps. For RK4 that ends at h = {}, just beyond the largest of \
         them; Methods I and II and implicit Euler have no such limit.",
        text(*limit)
    )))
}

fn poiseuille_errors_decay(context: &Context) -> Result<Finding, StudyError> {
    let cases = decay(context, "poiseuille-ansatz", &[0.5, 0.1, 0.01, 0.001, 1e-4])?;
    let worst = slowest(&cases)?;
    let evidence = match worst.measured {
        0.0 => format!("All {} late errors are roundoff.", cases.len()),
        ratio => format!("The slowest decay leaves {} of the early error: {}.", text(ratio), worst.what),
    };
    Ok(Finding::on(cases, evidence).because(
        "Both reduced equations have the steady state of the flow, and all four methods find it at these steps.",
    ))
}

fn nonlinear(context: &Context, method: &'static str) -> Result<Finding, StudyError> {
    let low = if method == BOTH[0] { 0.0 } else { -1.0 };
    let step = |w: f64| OneStep::on_quadratic_drag(method, w);
    let last = *context.get(LeavesAt { step: step(1.0), least: low, most: 1.0, low: 0.5, high: 5.0 })?;
    let mut cases = Vec::new();
    for w in [0.01, 0.1, 0.5, 0.9, 1.1, 1.5, 1.9, 2.1, 3.0, 5.0, 10.0, 100.0] {
        let v = step(w).or_infinity(context)?;
        cases.push(Case::between(format!("v₁/v₀ on the branch from h = 0, W = {w}"), v, low, 1.0).under(w < last));
    }
    let just_below = step(last * (1.0 - 1e-6)).or_infinity(context)?;
    let bound = number::Short::new(last, 4).text();
    let evidence = format!(
        "A step exists up to W = {}, where v₁/v₀ = {}; beyond, the root that starts at v₀ for h = 0 is gone and the step \
         fails.",
        bound,
        text(just_below)
    );
    let finding = Finding::on(cases, evidence).holds_where(format!("h v₀ < {bound}."));
    if method == BOTH[0] {
        let spurious = OneStep { problem: "quadratic-drag v0=-1", ..step(1.0) };
        return Ok(finding.because(format!(
            "The step is a cubic in v₁, and two of its roots merge in a fold. The one that is left is negative and leads to \
             the fixed point v = −1/h of the method, where f ≠ 0: from v = −1 with h = 1 a live step gives {}.",
            text(spurious.or_infinity(context)?)
        )));
    }
    Ok(finding.because(
        "pₙ₊₁ = pₙ imposes J₀ᵀr₀ + J₁ᵀr₁ = 0, weighted with Jacobians that differ between the ends of the step. It is \
         the trapezoidal rule where they are equal; here its good root ends at a smaller step than Method I's.",
    ))
}
