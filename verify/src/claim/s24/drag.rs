//! Accuracy on linear and quadratic drag against implicit Euler and RK4.

use crate::claim::measure::{common, is_within, sizes, text};
use crate::claim::{Case, Claim, Finding, Quantifier};
use crate::evidence::{Axis, Figure, Mark, Panel, Series, Table};
use crate::experiment::errors::Errors;
use crate::experiment::one_step::LeavesAt;
use crate::experiment::orders::Order;
use crate::experiment::{Context, StudyError};
use crate::row;

use super::{BASELINES, BOTH, FOLD, ahead};

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "S24-d-1",
        source: "[S24] Section 3, Figures 1 and 2",
        statement: "On linear drag with sufficiently large h (≳ 1.5) Method I has smaller errors than implicit Euler and RK4.",
        quantifier: Quantifier::Eventual,
        criterion: "The largest error on (0, 10] of live runs is smaller at the steps 1.5, 2 and 2.5 of Figure 1 and at others up to 10: \
                    h ≳ 1.5 is read as h ≥ 1.5, the paper's own step, and “sufficiently large” asks for 10.",
        decide: |context| large_steps(context, "method-i"),
    },
    Claim {
        id: "S24-d-2",
        source: "[S24] Section 3, Figures 1 and 2",
        statement: "On linear drag with sufficiently large h (≳ 1.5) Method II has smaller errors than implicit Euler and RK4.",
        quantifier: Quantifier::Eventual,
        criterion: "As for S24-d-1.",
        decide: |context| large_steps(context, "method-ii"),
    },
    Claim {
        id: "S24-e-1",
        source: "[S24] Section 3, Figures 1 and 2",
        statement: "On linear drag with h ≲ 1.5 Methods I and II have errors smaller than implicit Euler's by several orders of \
                    magnitude.",
        quantifier: Quantifier::Universal,
        criterion: "The largest error on (0, 10] of implicit Euler is at least 100 times that of Method I and of Method II for \
                    every h tested from 0.002 to 1.5.",
        decide: orders_of_magnitude,
    },
    Claim {
        id: "S24-e-2",
        source: "[S24] Section 3, Figures 1 and 2",
        statement: "On linear drag with h ≲ 1.5 RK4 has smaller errors than Methods I and II.",
        quantifier: Quantifier::Universal,
        criterion: "The largest error on (0, 10] of RK4 is the smallest at every h tested from 0.01 to 1.5.",
        decide: runge_kutta_wins,
    },
    Claim {
        id: "S24-e-3",
        source: "[S24] Section 3, after Eq. (27)",
        statement: "Methods I and II are also expected to converge faster than implicit Euler.",
        quantifier: Quantifier::Comparison,
        criterion: "The order fitted in the chapter on orders, against the exact solution of the equation that the method steps, exceeds \
                    implicit Euler's by a half at least on linear drag, on quadratic drag, on the Poiseuille ansatz and on prothero-robinson.",
        decide: rates,
    },
    Claim {
        id: "S24-e-4",
        source: "[S24] Section 1, and Section 3 after Eq. (27)",
        statement: "Methods I and II generally have smaller errors than implicit Euler: here on linear drag.",
        quantifier: Quantifier::Comparison,
        criterion: "The largest error on (0, 10] is smaller than implicit Euler's for each of the two at every h tested from 0.001 to 10.",
        decide: linear_against_euler,
    },
    Claim {
        id: "S24-g-1",
        source: "[S24] Section 4, Figures 3 and 4",
        statement: "On quadratic drag Methods I and II generally have smaller errors than implicit Euler.",
        quantifier: Quantifier::Comparison,
        criterion: "The largest error on (0, 10] is smaller than implicit Euler's for each of the two at every step of the \
                    figures and, between its two largest, at 0.2, 0.5, 0.6, 0.7, 0.8 and 0.9.",
        decide: quadratic_against_euler,
    },
    Claim {
        id: "S24-g-2",
        source: "[S24] Section 4, Figures 3 and 4",
        statement: "On quadratic drag RK4 has smaller errors than Methods I and II at the smaller steps.",
        quantifier: Quantifier::Comparison,
        criterion: "The largest error on (0, 10] of RK4 is the smallest at every step of the figures below 1.",
        decide: quadratic_against_runge_kutta,
    },
];

fn linear(context: &Context, method: &'static str, h: f64) -> Result<f64, StudyError> {
    Ok(Errors::of("linear-drag", method, h).largest(context)?)
}

fn quadratic(context: &Context, method: &'static str, h: f64) -> Result<f64, StudyError> {
    Ok(Errors::of("quadratic-drag", method, h).largest(context)?)
}

/// All steps that are looked at for where the large ones begin.
const LARGE: [f64; 2] = [1.0, 10.0];

fn large_steps(context: &Context, method: &'static str) -> Result<Finding, StudyError> {
    let name = if method == BOTH[0] { "Method I" } else { "Method II" };
    let [euler, rk4] = BASELINES.map(|rival| ahead(context, "linear-drag", [method, rival], 1.0, LARGE));
    let (euler, rk4) = (euler?, rk4?);
    let &[overtakes, _] = rk4.first().ok_or("RK4 is not overtaken")?;
    let loses = euler.first().map(|interval| interval[1]).filter(|to| *to < LARGE[1]);
    let of_both = common(&euler, &rk4);
    let mut cases = Vec::new();
    for h in [10.0, 5.0, 3.0, 2.5, 2.25, 2.0, 1.75, 1.55, 1.5] {
        let error = linear(context, method, h)?;
        for rival in BASELINES {
            let what = format!("largest error, h = {h}, against {rival}");
            let case = Case::below(what, error, linear(context, rival, h)?);
            cases.push(case.under(is_within(&of_both, h)).against(rival));
        }
    }
    let [at_the_paper_s, rk4_there] = [linear(context, method, 1.5)?, linear(context, "rk4", 1.5)?];
    let evidence = format!(
        "At h = 1.5 the largest error of {name} is {}, of RK4 {}: the paper's own step is on the other side, by {} %. At h = 2.5 the \
         largest errors are {} ({name}), {} (implicit Euler) and {} (RK4); {name} overtakes RK4 at h = {}{}.",
        text(at_the_paper_s),
        text(rk4_there),
        text(100.0 * (at_the_paper_s / rk4_there - 1.0)),
        text(linear(context, method, 2.5)?),
        text(linear(context, "implicit-euler", 2.5)?),
        text(linear(context, "rk4", 2.5)?),
        text(overtakes),
        loses.map_or_else(String::new, |h| format!(" and falls behind implicit Euler at h = {}", text(h)))
    );
    let finding = Finding::on(cases, evidence).beside("overtakes RK4 at h", "≈ 1.5", overtakes).holds_where(format!(
        "{} (scanned from {} to {}).",
        sizes("h", &of_both, LARGE),
        LARGE[0],
        LARGE[1]
    ));
    if method == BOTH[0] {
        let finding = finding.because(format!(
            "R(h) = 1/(1 + h + h²/2) tends to 0 like exp(−h) does, only more slowly; RK4's polynomial turns upwards \
             and is unstable beyond h = {}.",
            text(*context.get(LeavesAt::unit_circle("rk4", 2.0, 4.0))?)
        ));
        return with_figure(context, finding, overtakes);
    }
    Ok(finding.because(
        "R(h) = (1 − h/2)/(1 + h/2) tends to −1, while implicit Euler's 1/(1 + h) tends to 0 as the solution does.",
    ))
}

/// Errors of the four methods against h, and where Method I overtakes RK4.
fn with_figure(context: &Context, finding: Finding, overtakes: f64) -> Result<Finding, StudyError> {
    let methods = [BOTH[0], BOTH[1], BASELINES[0], BASELINES[1]];
    let steps: Vec<f64> = (0..=36).map(|i| 0.02 * 10_f64.powf(f64::from(i) / 14.0)).collect();
    let mut rows = Vec::new();
    for method in methods {
        for h in &steps {
            rows.push(row![method, *h, linear(context, method, *h)?]);
        }
    }
    let columns = ["method", "h", "max_error"];
    let data = Table::data("claims-linear-drag", "Largest error on (0, 10] on linear drag.", columns, rows);
    let mut series = data.curves("method", "h", "max_error", Mark::Line);
    let here = linear(context, BOTH[0], overtakes)?;
    let guide = vec![(overtakes, here * 1e-3), (overtakes, here * 10.0)];
    series.push(Series::new(format!("h = {}", text(overtakes)), guide, Mark::Guide));
    let caption = "Largest error on (0, 10] on linear drag. RK4 is the best up to the dotted vertical line, Method I beyond it; \
                   Method II ends up behind implicit Euler.";
    let panel = Panel::new(Axis::log("step size h"), Axis::log("largest error").between(1e-9, 10.0), series);
    Ok(finding.with_figure(Figure::new("claims-linear-drag", caption, "claims-linear-drag", [panel]), data))
}

fn orders_of_magnitude(context: &Context) -> Result<Finding, StudyError> {
    let ratio = |method: &'static str, h: f64| -> Result<f64, StudyError> {
        Ok(linear(context, "implicit-euler", h)? / linear(context, method, h)?)
    };
    const BETWEEN: [f64; 2] = [0.002, 1.5];
    let (mut cases, mut starts, mut smaller) = (Vec::new(), Vec::new(), Vec::new());
    for method in BOTH {
        for h in [1.5, 1.0, 0.5, 0.1, 0.05, 0.01, 0.002] {
            cases.push(Case::above(format!("error ratio, {method}, h = {h}"), ratio(method, h)?, 100.0));
        }
        let of = |times| ahead(context, "linear-drag", [method, "implicit-euler"], times, BETWEEN);
        smaller.push(of(1.0)?);
        starts.push(sizes("h", &of(0.01)?, BETWEEN));
    }
    let evidence = format!(
        "Implicit Euler's error is {} and {} times that of Methods I and II at h = 1, {} and {} times at h = 0.1, {} and \
         {} times at h = 0.01.",
        text(ratio(BOTH[0], 1.0)?),
        text(ratio(BOTH[1], 1.0)?),
        text(ratio(BOTH[0], 0.1)?),
        text(ratio(BOTH[1], 0.1)?),
        text(ratio(BOTH[0], 0.01)?),
        text(ratio(BOTH[1], 0.01)?)
    );
    Ok(Finding::on(cases, evidence)
        .beside("implicit Euler's error over Method I's, h = 0.1", "several orders of magnitude", ratio(BOTH[0], 0.1)?)
        .holds_where(format!(
            "They are smaller at {} (scanned), by two orders of magnitude at {} (Method I) and {} (Method II).",
            sizes("h", &common(&smaller[0], &smaller[1]), BETWEEN),
            starts[0],
            starts[1]
        ))
        .because(
            "Local errors h²/2 against h³/6 and h³/12: the ratios are 3/h and 6/h for small h, as between any method of \
             first and any of second order.",
        ))
}

fn runge_kutta_wins(context: &Context) -> Result<Finding, StudyError> {
    let mut cases = Vec::new();
    for method in BOTH {
        for h in [0.01, 0.05, 0.1, 0.5, 1.0, 1.25, 1.5] {
            let what = format!("largest error of rk4, h = {h}, against {method}");
            cases.push(Case::below(what, linear(context, "rk4", h)?, linear(context, method, h)?));
        }
    }
    let best = |method| -> Result<f64, StudyError> {
        match ahead(context, "linear-drag", ["rk4", method], 1.0, [0.01, 2.4])?[..] {
            [[_, end]] if end < 2.4 => Ok(end),
            ref found => Err(format!("RK4 is the best at {found:?}, not up to a step").into()),
        }
    };
    let (one, two) = (best(BOTH[0])?, best(BOTH[1])?);
    let evidence =
        format!("RK4 is the best up to h = {} against Method I and h = {} against Method II.", text(one), text(two));
    Ok(Finding::on(cases, evidence).beside("RK4 is the best up to h", "≈ 1.5", one.min(two)).because(LONGER_STEPS))
}

/// Why RK4 is ahead where it is.
const LONGER_STEPS: &str = "At small steps RK4 is of fourth order, they are of second. At large ones, where orders do not show, it rests on \
                            these runs alone.";

fn rate(context: &Context, problem: &'static str, method: &'static str) -> Result<f64, StudyError> {
    Ok(*context.get(Order { problem, method })?)
}

fn rates(context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut rows) = (Vec::new(), Vec::new());
    for problem in ["linear-drag", "quadratic-drag", "poiseuille-ansatz", "prothero-robinson"] {
        let slow = rate(context, problem, "implicit-euler")?;
        let orders = [rate(context, problem, BOTH[0])?, rate(context, problem, BOTH[1])?];
        for (method, order) in BOTH.into_iter().zip(orders) {
            let case = Case::above(format!("order of {method}, {problem}, against implicit-euler"), order, slow + 0.5);
            let is_resolved_and_whole = !["poiseuille-ansatz", "prothero-robinson"].contains(&problem);
            cases.push(case.under(is_resolved_and_whole).against("implicit-euler"));
        }
        rows.push(row![problem, orders[0], orders[1], slow]);
    }
    let of = |order: usize| text(cases[order].measured);
    let evidence = format!(
        "The orders of Methods I and II are {} and {} on linear drag, {} and {} on quadratic drag, {} and {} on the \
         Poiseuille ansatz, and {} and {} on prothero-robinson with hλ ≫ 1.",
        of(0),
        of(1),
        of(2),
        of(3),
        of(4),
        of(5),
        of(6),
        of(7)
    );
    let columns = ["problem", "method_i", "method_ii", "implicit_euler"];
    let table = Table::new("claims-rates", "Fitted orders, those of the chapter on orders.", columns, rows);
    Ok(Finding::on(cases, evidence)
        .holds_where("Where the Lagrangian is ½|v̇ − f|² and not the reduced (37), and the steps resolve the fastest rate; with Method II on the other two as well. It takes an \
                      invertible Jacobian with Method II: S24-c-4.")
        .because(
            "A closure that leaves the residual at zero is of second order, one more than implicit Euler. The reduced Lagrangian of the \
             ansatz keeps a remainder besides, and with it p = 0 is met to first order only. On prothero-robinson with \
             hλ ≫ 1 the error of Method I is h|v″|/(2λ), as implicit Euler's.",
        )
        .with_table(table))
}

/// An error of a method with steps of h on a problem.
type ErrorOf = fn(&Context, &'static str, f64) -> Result<f64, StudyError>;

/// Both methods' errors beside implicit Euler's at some steps, and the steps at which each is ahead, as a text.
fn against_euler(
    context: &Context,
    (problem, error): (&'static str, ErrorOf),
    steps: &[f64],
    between: [f64; 2],
) -> Result<(Vec<Case>, [String; 2]), StudyError> {
    let mut cases = Vec::new();
    let mut compare = |method: &'static str| -> Result<String, StudyError> {
        let found = ahead(context, problem, [method, "implicit-euler"], 1.0, between)?;
        for &h in steps {
            let what = format!("largest error, {method}, h = {h}, against implicit-euler");
            let case = Case::below(what, error(context, method, h)?, error(context, "implicit-euler", h)?);
            cases.push(case.under(is_within(&found, h)).against("implicit-euler"));
        }
        Ok(sizes("h", &found, between))
    };
    let ahead = [compare(BOTH[0])?, compare(BOTH[1])?];
    Ok((cases, ahead))
}

/// How many times a method's error implicit Euler's is.
fn gain(context: &Context, error: ErrorOf, method: &'static str, h: f64) -> Result<String, StudyError> {
    Ok(text(error(context, "implicit-euler", h)? / error(context, method, h)?))
}

fn linear_against_euler(context: &Context) -> Result<Finding, StudyError> {
    const BETWEEN: [f64; 2] = [0.001, 10.0];
    const STEPS: [f64; 13] = [10.0, 5.0, 3.0, 2.5, 2.0, 1.5, 1.0, 0.5, 0.1, 0.05, 0.01, 0.005, 0.001];
    let (cases, [one, two]) = against_euler(context, ("linear-drag", linear), &STEPS, BETWEEN)?;
    let gain = |method: usize, h: f64| gain(context, linear, BOTH[method], h);
    let evidence = format!(
        "Implicit Euler's error is {} times Method I's and {} times Method II's at h = 0.1, {} and {} times at h = 1, {} and {} times at h = 5.",
        gain(0, 0.1)?,
        gain(1, 0.1)?,
        gain(0, 1.0)?,
        gain(1, 1.0)?,
        gain(0, 5.0)?,
        gain(1, 5.0)?
    );
    Ok(Finding::on(cases, evidence)
        .holds_where(format!(
            "With Method I at {one}, and with Method II at {two} (scanned from {} to {}).",
            BETWEEN[0], BETWEEN[1]
        ))
        .because(
            "Order 2 against order 1 at small steps. For h → ∞ the factor of Method II tends to −1, and those of Method I and of implicit Euler to 0 as 2/h² and 1/h.",
        ))
}

/// The steps of Figures 3 and 4.
const QUADRATIC_STEPS: [f64; 6] = [1.0, 0.1, 0.05, 0.01, 0.005, 0.001];

fn quadratic_against_euler(context: &Context) -> Result<Finding, StudyError> {
    // As far as Method I has steps, and beyond.
    const BETWEEN: [f64; 2] = [0.001, 4.0];
    let steps = [&QUADRATIC_STEPS[..], &[0.9, 0.8, 0.7, 0.6, 0.5, 0.2]].concat();
    let (cases, [one, two]) = against_euler(context, ("quadratic-drag", quadratic), &steps, BETWEEN)?;
    // Method I has a step at each of them.
    let cases = cases.into_iter().map(|case| case.or_else(FOLD)).collect();
    let gain = |method: usize, h: f64| gain(context, quadratic, BOTH[method], h);
    let evidence = format!(
        "Implicit Euler's error is {} times Method I's at h = 1, {} times at h = 0.1, {} times at h = 0.01; {} and {} times \
         Method II's at the last two. At h = 0.8 Method II has {} and implicit Euler {}.",
        gain(0, 1.0)?,
        gain(0, 0.1)?,
        gain(0, 0.01)?,
        gain(1, 0.1)?,
        gain(1, 0.01)?,
        text(quadratic(context, BOTH[1], 0.8)?),
        text(quadratic(context, "implicit-euler", 0.8)?)
    );
    Ok(Finding::on(cases, evidence)
        .holds_where(format!(
            "With Method I at {one}, nearly to the end of its branch (S24-h-1), and with Method II at {two} (scanned from {} to {}).",
            BETWEEN[0], BETWEEN[1]
        ))
        .because(
            "Order 2 against order 1 at small steps. The solution of Method II's step falls to v₁ = 0 as h v₀ tends to 1, where two roots meet, \
             and beyond there is none on the branch of v₀: S24-h-2.",
        ))
}

fn quadratic_against_runge_kutta(context: &Context) -> Result<Finding, StudyError> {
    let mut cases = Vec::new();
    for method in BOTH {
        for h in &QUADRATIC_STEPS[1..] {
            let what = format!("largest error of rk4, h = {h}, against {method}");
            let case = Case::below(what, quadratic(context, "rk4", *h)?, quadratic(context, method, *h)?);
            cases.push(case.against(method));
        }
    }
    let evidence = format!(
        "At h = 0.1 the errors are {} (Method I), {} (Method II) and {} (RK4).",
        text(quadratic(context, BOTH[0], 0.1)?),
        text(quadratic(context, BOTH[1], 0.1)?),
        text(quadratic(context, "rk4", 0.1)?)
    );
    Ok(Finding::on(cases, evidence).because(LONGER_STEPS))
}
