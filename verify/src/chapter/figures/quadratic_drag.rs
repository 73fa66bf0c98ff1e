//! Figures 3 and 4.

use lsvi::{SolveError, StepError};

use super::{METHODS, Plan, Sweep, maps};
use crate::chapter::{Context, Study, StudyError};
use crate::evidence::{Check, Evidence, Figure};
use crate::run::RunError;

pub(in crate::chapter) const STUDY: Study = Study {
    id: "quadratic-drag",
    title: "Quadratic drag: Figures 3 and 4",
    question: "Do the orders of merit on v̇ = −v carry over to the nonlinear v̇ = −v²?",
    source: "[S24] Section 4, Figures 3 and 4",
    run,
};

const PROBLEM: &str = "quadratic-drag";

pub(super) const PLAN: Plan = Plan {
    cases: &[(PROBLEM, &METHODS)],
    steps: [1.0, 0.1, 0.05, 0.01, 0.005, 0.001],
    figure: 3,
    map: maps::quadratic_drag,
};

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let sweep = Sweep::run(&PLAN, context)?;
    let mut checks = vec![sweep.follows_the_closed_forms(), sweep.errors_decay(), method_ii_ends(&sweep)];
    for (better, worse, coarsest) in [
        ("method-i", "implicit-euler", 1.0),
        ("method-ii", "implicit-euler", 0.1),
        ("rk4", "method-i", 0.1),
        ("rk4", "method-ii", 0.1),
        ("method-i", "trapezoidal", 1.0),
        ("implicit-midpoint", "method-i", 0.1),
    ] {
        checks.push(ordered(&sweep, (better, worse), coarsest));
    }
    checks.push(Check::at_most(
        "method-i-before-rk4-1",
        "at h = 1 it is Method I that has a smaller error than RK4",
        sweep.ratio(PROBLEM, ("method-i", "rk4"), 1.0),
        1.0,
        "Ratio of the largest errors.",
    ));
    checks.extend(constants(&sweep));
    checks.push(explicit_momentum_is_stuck(&sweep));
    let curves = METHODS.map(|method| (PROBLEM, method));
    let figures = vec![
        sweep.series_figure(
            "figure-3".into(),
            "Errors on v̇ = −v², v(0) = 1, against 1/(1 + t), in the panels of the paper's Figure 3. At \
             h = 1 the first step of Method I is exact, Method II has none and p_n = 0 stands still; at h = 0.001 RK4 is at \
             roundoff.".into(),
            PROBLEM,
            &METHODS,
        ),
        Figure {
            id: "figure-4".into(),
            caption: "Largest error up to t = 10 against 1/h: the paper's Figure 4, with three methods more.".into(),
            data: "figure-4".into(),
            panels: vec![sweep.maxima_panel("", &curves)],
            columns: 1,
        },
    ];
    Ok(Evidence {
        checks,
        tables: vec![
            sweep.maxima_table("Largest error on v̇ = −v² at the grid points up to t = 10."),
            sweep.series_table(),
        ],
        figures,
        notes: vec![
            "The order of merit carries over: Methods I and II beat implicit Euler at every step size where they exist, and RK4 \
             beats them at all but the largest, where Method I is better than anything else."
                .into(),
            "Against methods of its own order Method I holds its ground here. Its defect h²(¼Jᵀv″ − v‴/12) is as large as the \
             trapezoidal rule's h²v‴/12 on v = 1/(1 + t), Method II's twice that, and the implicit midpoint rule's half: \
             another problem, another order of merit."
                .into(),
            "Two runs of the first panel go wrong for reasons of their own. With X = hv_{n+1} and W = hv_n the equation of \
             Method II is X²(1 + X) = W²(1 − W): the right root is gone for W > 1, and h = 1 is exactly where it meets its \
             mirror image at 0. The run ends there with the reason in the table rather than with a root chosen by chance. And \
             p_n = 0 has the spurious steady state hv = 1, from which the run starts: it never moves."
                .into(),
        ],
        ..Evidence::default()
    })
}

/// The first of two methods has the smaller error at all step sizes up to `coarsest`.
fn ordered(sweep: &Sweep, (better, worse): (&'static str, &'static str), coarsest: f64) -> Check {
    let ratios = sweep.steps().filter(|h| *h <= coarsest).map(|h| (h, sweep.ratio(PROBLEM, (better, worse), h)));
    let (at, ratio) = ratios.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((f64::NAN, f64::NAN));
    Check::at_most(
        format!("{better}-before-{worse}"),
        format!("{better} has a smaller error than {worse} at every step size up to {coarsest}"),
        ratio,
        1.0,
        format!("Largest ratio of the largest errors, at h = {at}."),
    )
}

/// At h v_n = 1 two roots of X²(1 + X) = W²(1 − W) meet and the branch of Method II ends.
fn method_ii_ends(sweep: &Sweep) -> Check {
    let reached = match sweep.find(PROBLEM, "method-ii", 1.0).map(|run| &run.largest) {
        Some(Err(RunError::Step(StepError::Solve { source: SolveError::BranchLost { reached }, .. }))) => *reached,
        _ => f64::NAN,
    };
    // The root X ≈ √(1 − W) of a computed equation is lost within √ε² of W = 1; the continuation halves its last piece
    // at most to 1e-8 before X loses half its digits.
    Check::within(
        "method-ii-ends",
        "Method II cannot take the first step of h = 1: its branch ends where hv = 1",
        reached,
        [1.0 - 1e-7, 1.0],
        "Longest step for which the branch was found.",
    )
}

/// Ratios of the largest errors as h → 0, from the leading error terms: on v = 1/(1 + t) the defects are −½, −1, −½ and ¼
/// times h²v⁴ for Methods I, II, the trapezoidal and the implicit midpoint rule.
fn constants(sweep: &Sweep) -> Vec<Check> {
    let mut checks = Vec::new();
    for (method, expected) in [("method-i", 1.0), ("method-ii", 2.0), ("implicit-midpoint", 0.5)] {
        for h in sweep.steps().filter(|h| *h <= 0.01) {
            checks.push(Check::within(
                format!("constant-{method}-{h}"),
                format!("at h = {h} the error of {method} is {expected} times the trapezoidal rule's"),
                sweep.ratio(PROBLEM, (method, "trapezoidal"), h),
                [expected * (1.0 - 3.0 * h), expected * (1.0 + 3.0 * h)],
                "From the leading error terms, within a relative 3h.",
            ));
        }
    }
    checks
}

/// Fixed points of p_n = 0 are (2 + hJ) f = 0: f = 0, and here hv = 1.
fn explicit_momentum_is_stuck(sweep: &Sweep) -> Check {
    let at_rest = 1.0 - 1.0 / 11.0;
    let roundoff = super::roundoff(1.0, at_rest);
    Check::within(
        "explicit-momentum-is-stuck",
        "p_n = 0 stays at its spurious steady state hv = 1 when h = 1",
        sweep.error(PROBLEM, "explicit-momentum", 1.0),
        [at_rest - roundoff, at_rest + roundoff],
        "Largest error: 1 − 1/(1 + t) at t = 10.",
    )
}
