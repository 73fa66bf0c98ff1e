//! Decay of errors, and stability on nonlinear problems.

use crate::chapter::StudyError;
use crate::claim::measure::{growth, one_step, problem, text, threshold};
use crate::claim::{Case, Claim, Finding};
use crate::measure::norm::{Extremes, larger};
use crate::method;
use crate::problem::{Problem, poiseuille_series};
use crate::run::run;

use super::{BOTH, YARDSTICKS};

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "S24-f-1",
        source: "[S24] Section 3, Figure 1",
        statement: "On linear drag all errors decay to zero as t → ∞.",
        criterion: "For every method and step of Figure 1 the largest error on (30, 40] is below 1 % of that on (0, 10].",
        decide: linear_errors_decay,
    },
    Claim {
        id: "S24-f-2",
        source: "[S24] Section 5, Figure 6",
        statement: "On Poiseuille flow all errors decay to zero as t → ∞.",
        criterion: "For every method and the steps 0.5, 0.1, 0.01 and 0.001 of Figure 6 the largest error on (8, 10] is below \
                    10⁻⁴ of that on (0, 2].",
        decide: poiseuille_errors_decay,
    },
    Claim {
        id: "S24-h-1",
        source: "[S24] Abstract, Section 4",
        statement: "Method I is unconditionally stable for nonlinear dissipative problems too.",
        criterion: "On quadratic drag one live step from v₀ > 0 has a solution, which lies between 0 and v₀, for every \
                    W = h v₀ from 0.01 to 100.",
        decide: || nonlinear("method-i"),
    },
    Claim {
        id: "S24-h-2",
        source: "[S24] Abstract, Section 4",
        statement: "Method II is unconditionally stable for nonlinear dissipative problems too.",
        criterion: "On quadratic drag one live step from v₀ > 0 has a solution, at most v₀ in size, for every W = h v₀ from 0.01 \
                    to 100.",
        decide: || nonlinear("method-ii"),
    },
];

/// Largest errors over an early and a late interval of a run; infinite if it breaks off.
fn errors(
    problem: &dyn Problem,
    method: &str,
    h: f64,
    early: f64,
    late: (f64, f64),
    truth: &dyn Fn(f64) -> f64,
) -> Result<(f64, f64), StudyError> {
    let (mut first, mut last) = (0.0_f64, 0.0_f64);
    let result = run(problem, &*method::parse(method)?, h, late.1, |state| {
        let error = (state.q[0] - truth(state.t)).abs();
        if state.t > 0.0 && state.t <= early {
            first = larger(first, error);
        }
        if state.t > late.0 {
            last = larger(last, error);
        }
    });
    Ok(if result.is_ok() { (first, last) } else { (first, f64::INFINITY) })
}

fn linear_errors_decay() -> Result<Finding, StudyError> {
    let drag = problem("linear-drag", &[])?;
    let mut cases = Vec::new();
    for method in BOTH.iter().chain(&YARDSTICKS) {
        for h in [2.5, 2.0, 1.5, 1.0, 0.1, 0.01] {
            let (early, late) = errors(&*drag, method, h, 10.0, (30.0, 40.0), &|t| (-t).exp())?;
            cases.push(Case::below(format!("late against early error, {method}, h = {h}"), late / early, 0.01));
        }
    }
    let slowest = cases.iter().map(|case| case.measured).largest();
    let limit = threshold("|R| of RK4", 2.0, 4.0, |h| Ok(growth("rk4", h)?.abs() - 1.0))?;
    let evidence = format!("The slowest decay, RK4's at h = 2.5, leaves {} of the error.", text(slowest));
    Ok(Finding::on(cases, evidence).because(format!(
        "All growth factors are below 1 in size at these steps. For RK4 that ends at h = {}, just beyond the largest of \
         them; Methods I and II and implicit Euler have no such limit.",
        text(limit)
    )))
}

fn poiseuille_errors_decay() -> Result<Finding, StudyError> {
    let flow = problem("poiseuille-ansatz", &[])?;
    let truth = |t: f64| poiseuille_series::velocity(2.0, 0.0, t).unwrap_or(f64::NAN);
    let mut cases = Vec::new();
    for method in BOTH.iter().chain(&YARDSTICKS) {
        for h in [0.5, 0.1, 0.01, 0.001] {
            let (early, late) = errors(&*flow, method, h, 2.0, (8.0, 10.0), &truth)?;
            cases.push(Case::below(format!("late against early error, {method}, h = {h}"), late / early, 1e-4));
        }
    }
    let slowest = cases.iter().map(|case| case.measured).largest();
    let evidence = format!("From t = 2 to t = 8 the errors fall to {} of their size, or less.", text(slowest));
    Ok(Finding::on(cases, evidence).because(
        "Both reduced equations have the steady state of the flow, and all four methods find it at these steps.",
    ))
}

fn nonlinear(method: &str) -> Result<Finding, StudyError> {
    let drag = problem("quadratic-drag", &[])?;
    let step = |w: f64| -> Result<f64, StudyError> { Ok(one_step(&*drag, method, w)?.unwrap_or(f64::INFINITY)) };
    let low = if method == BOTH[0] { 0.0 } else { -1.0 };
    let mut cases = Vec::new();
    for w in [0.01, 0.1, 0.5, 0.9, 1.1, 1.5, 1.9, 2.1, 3.0, 5.0, 10.0, 100.0] {
        cases.push(Case::between(format!("v₁/v₀, W = {w}"), step(w)?, low, 1.0));
    }
    let last = threshold(method, 0.5, 5.0, |w| Ok(if (low..=1.0).contains(&step(w)?) { 1.0 } else { -1.0 }))?;
    let just_below = step(last * (1.0 - 1e-6))?;
    let evidence = format!(
        "A step exists up to W = {}, where v₁/v₀ = {}; beyond, the root that starts at v₀ for h = 0 is gone and the step \
         fails.",
        text(last),
        text(just_below)
    );
    let finding = Finding::on(cases, evidence).holds_where(format!("h v₀ < {}.", text(last)));
    if method == BOTH[0] {
        let spurious = problem("quadratic-drag", &[("v0", "-1")])?;
        let stays = one_step(&*spurious, method, 1.0)?.unwrap_or(f64::INFINITY);
        return Ok(finding.because(format!(
            "The step is a cubic in v₁, and two of its roots merge in a fold. The one that is left is negative and leads to \
             the fixed point v = −1/h of the method, where f ≠ 0: from v = −1 with h = 1 a live step gives {}.",
            text(stays)
        )));
    }
    Ok(finding.because(
        "pₙ₊₁ = pₙ imposes J₀ᵀr₀ + J₁ᵀr₁ = 0, weighted with Jacobians that differ between the ends of the step. It is \
         the trapezoidal rule where they are equal; here its good root ends at a smaller step than Method I's.",
    ))
}
