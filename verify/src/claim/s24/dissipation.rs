//! Decay of errors, and stability on nonlinear problems.

use crate::claim::measure::{range, text};
use crate::claim::{Case, Claim, Finding, Quantifier};
use crate::evidence::number;
use crate::experiment::errors::Decay;
use crate::experiment::one_step::{LeavesAt, OneStep, PartsAt, Separation};
use crate::experiment::step_equation::{self, OnlySolutions, StepEquation};
use crate::experiment::{Context, StudyError};
use crate::measure::norm::Extremes;

use super::{BASELINES, BOTH};

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "S24-f-1",
        source: "[S24] Section 3, Figure 1",
        statement: "On linear drag all errors decay to zero as t → ∞, at the steps of Figure 1.",
        quantifier: Quantifier::Universal,
        criterion: "For every method and step of Figure 1 the largest error on (t, 2t] is at most half of that on (t/2, t]: it \
                    falls at least like 1/t. Of t = 20, 10, 5, … it is the last at which the earlier error is well above roundoff.",
        decide: linear_errors_decay,
    },
    Claim {
        id: "S24-f-2",
        source: "[S24] Section 5, Figure 6",
        statement: "On Poiseuille flow all errors decay to zero as t → ∞, at the steps of Figure 6.",
        quantifier: Quantifier::Universal,
        criterion: "As for S24-f-1, for every method and step of Figure 6.",
        decide: poiseuille_errors_decay,
    },
    Claim {
        id: "S24-h-1",
        source: "[S24] Abstract, Section 6",
        statement: "Method I is unconditionally stable for dissipative systems, nonlinear ones included. Our reading of stable, that of the glossary's dissipative: whatever h is, two solutions come no \
                    further apart in a step, and a step has a solution on the branch of v₀, which is at most v₀ in size.",
        quantifier: Quantifier::Universal,
        criterion: "On quadratic drag, which brings solutions with v > 0 together, neighbouring starts come no further apart in a live step, for every \
                    W = h v₀ tested that has one, nor do two that lie between the first W at which neighbours do and the fold; and one live step from v₀ > 0 has a solution that \
                    continues v₀ from h = 0, at most v₀ in size, for every W tested from 0.01 to 100.",
        decide: |context| nonlinear(context, "method-i"),
    },
    Claim {
        id: "S24-h-2",
        source: "[S24] Abstract, Section 6",
        statement: "Method II is unconditionally stable for dissipative systems, nonlinear ones included. Our reading of stable, that of the glossary's dissipative: whatever h is, two solutions come no \
                    further apart in a step, and a step has a solution on the branch of v₀, which is at most v₀ in size.",
        quantifier: Quantifier::Universal,
        criterion: "As for S24-h-1.",
        decide: |context| nonlinear(context, "method-ii"),
    },
];

/// Late against early errors of the four methods of the figures on a problem.
fn decay(context: &Context, problem: &'static str, steps: &[f64]) -> Result<Vec<Case>, StudyError> {
    let mut cases = Vec::new();
    for method in BOTH.iter().chain(&BASELINES) {
        for h in steps {
            cases.push(late_against_early(method, *h, *context.get(Decay { problem, method, h: *h })?));
        }
    }
    Ok(cases)
}

/// Errors that are roundoff all the way say nothing.
fn late_against_early(method: &str, h: f64, ratio: Option<f64>) -> Case {
    let what = format!("late against early error, {method}, h = {h}");
    Case::at_most(what, ratio.unwrap_or(f64::NAN), Decay::MOST)
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
    let cases = decay(context, "poiseuille-ansatz", &[0.5, 0.1, 0.01, 0.001, 1e-4, 1e-5])?;
    let worst = slowest(&cases)?;
    let evidence = format!("The slowest decay leaves {} of the early error: {}.", text(worst.measured), worst.what);
    Ok(Finding::on(cases, evidence).because(
        "Both reduced equations have the steady state of the flow, and all four methods find it at these steps.",
    ))
}

/// The smallest W that is looked at.
const SMALLEST: f64 = 0.01;
/// Between these a step is at most v₀ in size.
const NOT_AMPLIFIED: [f64; 2] = [-1.0, 1.0];

fn nonlinear(context: &Context, method: &'static str) -> Result<Finding, StudyError> {
    let [low, high] = NOT_AMPLIFIED;
    let weights = if method == BOTH[0] { StepEquation::METHOD_I } else { StepEquation::METHOD_II };
    let step = |w: f64| OneStep::on_quadratic_drag(method, w);
    let last = *context.get(LeavesAt { step: step(1.0), least: low, most: high, low: SMALLEST, high: 5.0 })?;
    // Short of the fold by what a neighbour is moved.
    let parts = *context.get(PartsAt { method, low: SMALLEST, high: last * (1.0 - 1e-4) })?;
    let starts = [0.0, 0.9].map(|part| parts + part * (last - parts));
    let end = |w: f64| step(w).or_infinity(context).map(|v| w * v);
    let (before, after) = (starts[1] - starts[0], (end(starts[1])? - end(starts[0])?).abs());
    let pair = format!("from {} and {}", text(starts[0]), text(starts[1]));
    let what = format!("distance after a step of h = 1 {pair}, {} apart", text(before));
    let (mut cases, mut left) = (vec![Case::at_most(what, after, before)], Vec::new());
    for w in [SMALLEST, 0.1, 0.5, 0.9, 1.1, 1.5, 1.9, 2.1, 3.0, 5.0, 10.0, 100.0] {
        let v = step(w).or_infinity(context)?;
        let case = Case::between(format!("v₁/v₀ on the branch from h = 0, W = {w}"), v, low, high).under(w < last);
        if v.is_finite() {
            cases.push(case);
            let slope = Separation { method: method.into(), w }.or_infinity(context)?;
            let what = format!("distance of neighbouring starts after a step over that before, W = {w}");
            cases.push(Case::at_most(what, slope.abs(), 1.0).under(w < parts));
            continue;
        }
        let found = context.get(StepEquation { problem: "quadratic-drag", weights, h: w })?;
        let step_equation::Found::Roots(roots) = &*found else { return Err("a step is not determined".into()) };
        let &[root] = &roots[..] else { return Err(format!("not one root is left at W = {w}").into()) };
        left.push(root);
        let instead = format!("no solution on the branch (the only root off it is v₁/v₀ = {})", text(root));
        cases.push(case.or_else(instead));
    }
    let below = |part: f64| step(last * (1.0 - part)).or_infinity(context);
    // Two roots meet at the fold, so that v goes like the root of the distance: this way it drops out.
    let at_fold = 2.0 * below(0.25e-6)? - below(1e-6)?;
    let at_fold = (at_fold * 1e5).round() / 1e5;
    let bound = number::short(number::rounded_down(last, 4));
    let (least, most) = (left.iter().copied().smallest(), left.iter().copied().largest());
    let evidence = format!(
        "A step on the branch exists up to W = {bound}, where v₁/v₀ has come to {}; beyond, the root that starts at v₀ for h = 0 is gone and \
         the step fails. The one root left at the steps tested is off the branch, v₁/v₀ = {}: none of these steps amplifies, and what fails \
         is the solution.",
        text(at_fold),
        range(least, most),
    );
    let evidence = format!(
        "{evidence} Before that, from W = {} on, neighbouring solutions come further apart in a step: {pair}, {} apart, a step of h = 1 leads to states {} apart, on \
         the branch.",
        text(parts),
        text(before),
        text(after)
    );
    if !(low <= least && most < 0.0) {
        return Err(format!("the roots that are left, {left:?}, are not between −v₀ and 0").into());
    }
    let first = StepEquation { problem: "quadratic-drag", weights, h: 3.0 };
    let states = context.get(OnlySolutions { first, steps: 100 })?;
    let &[.., before, end] = &states[..] else { return Err("no steps".into()) };
    let run = "a run from v₀ = 1 with h = 3 that takes the only root at every step";
    let reading = format!(
        "On v̇ = −v² from v₀ > 0, where it is dissipative: two solutions come no further apart in a step where h v₀ < {} for both, and a step has a solution \
         on the branch, at most v₀ in size, where h v₀ < {bound} (scanned from {SMALLEST}). The only root beyond does not amplify.",
        number::short(number::rounded_down(parts, 4))
    );
    if method == BOTH[0] {
        let evidence = format!(
            "{evidence} With that root left, {run} ends at {}, which is −1/h, while the solution tends to 0.",
            text(end)
        );
        let spurious = OneStep { problem: "quadratic-drag v0=-1", ..step(1.0) };
        return Ok(Finding::on(cases, evidence)
            .holds_where(format!("{reading} That root is negative and leads to the spurious steady state v = −1/h."))
            .because(format!(
                "The step is a cubic in v₁, and two of its roots merge in a fold. The one that is left is negative and leads to \
                 the fixed point v = −1/h of the method, where f ≠ 0: from v = −1 with h = 1 a live step gives {}.",
                text(spurious.or_infinity(context)?)
            )));
    }
    let evidence = format!(
        "{evidence} With that root left, {run} comes to {} and {} in turn for ever, while the solution tends to 0.",
        text(before.max(end)),
        text(before.min(end))
    );
    Ok(Finding::on(cases, evidence).holds_where(reading).because(
        "pₙ₊₁ = pₙ imposes J₀ᵀr₀ + J₁ᵀr₁ = 0, weighted with Jacobians that differ between the ends of the step. It is \
         the trapezoidal rule where they are equal; here its branch ends at a smaller step than Method I's, and v₁ = −v₀ is left.",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claim::Verdict;

    #[test]
    fn errors_that_are_roundoff_all_the_way_neither_confirm_a_decay_nor_refute_it() {
        let verdict = |ratios: &[Option<f64>]| {
            let cases: Vec<Case> = ratios.iter().map(|ratio| late_against_early("rk4", 0.1, *ratio)).collect();
            Quantifier::Universal.verdict(&cases)
        };
        assert_eq!(verdict(&[Some(0.4), Some(0.5)]), Verdict::Confirmed);
        assert_eq!(verdict(&[Some(0.4), Some(0.6)]), Verdict::Refuted);
        assert_eq!([verdict(&[Some(0.4), None]), verdict(&[None])], [Verdict::NotSupported; 2]);
    }
}
