//! Figures 3 and 4.

use lsvi::{SolveError, StepError};

use super::{METHODS, Plan, Sweep, prose};
use crate::chapter::{Context, Study, StudyError};
use crate::evidence::number::{digits, rounded_down, short};
use crate::evidence::{Check, Evidence, Figure};
use crate::experiment::errors::{Ahead, RunError, roundoff};
use crate::measure::norm::max_norm;
use crate::measure::search::root;

pub(in crate::chapter) const STUDY: Study = Study {
    id: "quadratic-drag",
    title: "Quadratic drag: Figures 3 and 4",
    question: "Does the ranking of the methods on v̇ = −v carry over to the nonlinear v̇ = −v²?",
    source: "[S24] Section 4, Figures 3 and 4",
    run,
};

const PROBLEM: &str = "quadratic-drag";

pub(crate) const PLAN: Plan =
    Plan { cases: &[(PROBLEM, &METHODS)], steps: [1.0, 0.1, 0.05, 0.01, 0.005, 0.001], figure: 3 };

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let sweep = Sweep::run(&PLAN, context)?;
    let mut checks = vec![sweep.follows_the_closed_forms(), sweep.errors_decay(context)?, method_ii_ends(&sweep)];
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
    checks.push(method_i_is_the_best(&sweep));
    let [ahead, behind] = ends(context)?;
    checks.extend(against_euler([ahead, behind]));
    checks.extend(constants(&sweep));
    checks.push(explicit_momentum_is_stuck(&sweep));
    let curves = METHODS.map(|method| (PROBLEM, method));
    let figures = vec![
        sweep.series_figure(
            "figure-3".into(),
            "Errors on v̇ = −v², v(0) = 1, against 1/(1 + t), in the panels of the paper's Figure 3. At \
             h = 1 the first step of Method I is exact, that of Method II is singular (its branch ends there) and p_n = 0 stands still; at h = 0.001 the error of RK4 \
             comes near the roundings of the state.".into(),
            PROBLEM,
            &METHODS,
        ),
        Figure::new(
            "figure-4",
            "Largest error up to t = 10 against 1/h: the paper's Figure 4, with three methods more.",
            "figure-4",
            [sweep.maxima_panel("", &curves)],
        ),
    ];
    Ok(Evidence {
        checks,
        tables: vec![
            sweep.maxima_table("Largest error on v̇ = −v² at the grid points up to t = 10."),
            sweep.series_table(),
        ],
        figures,
        notes: prose::fill(include_str!("quadratic_drag.md"), &values(&sweep, [ahead, behind]))?,
        ..Evidence::default()
    })
}

/// What the text says in numbers.
fn values(sweep: &Sweep, [ahead, behind]: [f64; 2]) -> Vec<(&'static str, String)> {
    let finest = sweep.steps().last().unwrap_or(f64::NAN);
    let against = |method| short(sweep.ratio(PROBLEM, (method, "trapezoidal"), finest));
    vec![
        ("coarsest", COARSEST.to_string()),
        ("finest", finest.to_string()),
        ("method_i", against("method-i")),
        ("method_ii", against("method-ii")),
        ("midpoint", against("implicit-midpoint")),
        ("ahead", short(rounded_down(ahead, 4))),
        ("behind", short(rounded_down(behind, 4))),
    ]
}

/// The largest step of the figures.
const COARSEST: f64 = 1.0;

/// Up to which step the largest errors of Methods I and II are below implicit Euler's; at larger ones they are not.
fn ends(context: &Context) -> Result<[f64; 2], StudyError> {
    const BETWEEN: [f64; 2] = [0.001, 4.0];
    let of = |method| -> Result<f64, StudyError> {
        let ahead = Ahead { problem: PROBLEM, method, rival: "implicit-euler", times: 1.0, between: BETWEEN };
        match context.get(ahead)?[..] {
            [[from, to]] if from == BETWEEN[0] && to < BETWEEN[1] => Ok(to),
            ref found => Err(format!("{method} is ahead at {found:?}, not up to a step").into()),
        }
    };
    Ok([of("method-i")?, of("method-ii")?])
}

/// Where those steps lie in closed form: after one step from 1, where the errors are the largest, a method is as far below the solution as
/// implicit Euler is above it.
fn against_euler(found: [f64; 2]) -> [Check; 2] {
    // X = h v₁ with v₁ = 2/(1 + h) − x, where h x² + x − 1 = 0.
    let below = |h: f64| h * (2.0 / (1.0 + h) - ((1.0 + 4.0 * h).sqrt() - 1.0) / (2.0 * h));
    let method_i = |h: f64| {
        let x = below(h);
        2.0 * x.powi(3) + 3.0 * x * x + 2.0 * (1.0 - h) * x + h * h - 2.0 * h
    };
    let method_ii = |h: f64| below(h).powi(2) * (1.0 + below(h)) - h * h * (1.0 - h);
    let closed = [root([1.0, 2.2], method_i), root([0.3, 0.99], method_ii)].map(|h| h.unwrap_or(f64::NAN));
    let check = |(name, id, here, closed): (&str, &str, f64, f64)| {
        Check::within(
            id,
            format!(
                "{name} falls behind implicit Euler at the h = {} at which the closed forms of a step do",
                digits(closed, 6)
            ),
            here,
            [closed * (1.0 - 1e-9), closed * (1.0 + 1e-9)],
            "roundings of the errors over the slope of their difference",
        )
    };
    [
        check(("Method I", "method-i-falls-behind", found[0], closed[0])),
        check(("Method II", "method-ii-falls-behind", found[1], closed[1])),
    ]
}

/// At the largest step, against all that take it; Method II does not.
fn method_i_is_the_best(sweep: &Sweep) -> Check {
    let rivals = METHODS.into_iter().filter(|method| !["method-i", "method-ii"].contains(method));
    let ratios: Vec<f64> = rivals.map(|rival| sweep.ratio(PROBLEM, ("method-i", rival), COARSEST)).collect();
    Check::at_most(
        "method-i-is-the-best-1",
        format!("at h = {COARSEST} Method I has a smaller error than RK4 and all others that take the step"),
        max_norm(&ratios),
        1.0,
        "Largest ratio of the largest errors.",
    )
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
    let roundoff = roundoff(1.0, at_rest);
    Check::within(
        "explicit-momentum-is-stuck",
        "p_n = 0 stays at its spurious steady state hv = 1 when h = 1",
        sweep.error(PROBLEM, "explicit-momentum", 1.0),
        [at_rest - roundoff, at_rest + roundoff],
        "Largest error: 1 − 1/(1 + t) at t = 10.",
    )
}
