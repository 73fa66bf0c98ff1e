//! Accuracy on linear and quadratic drag against implicit Euler and RK4.

use crate::claim::measure::text;
use crate::claim::{Case, Claim, Finding, Quantifier};
use crate::evidence::{Axis, Figure, Mark, Panel, Series, Table};
use crate::experiment::errors::{Crossing, Errors};
use crate::experiment::one_step::LeavesAt;
use crate::experiment::orders::Order;
use crate::experiment::{Context, StudyError};
use crate::row;

use super::{BOTH, YARDSTICKS};

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "S24-d-1",
        source: "[S24] Section 3, Figures 1 and 2",
        statement: "On linear drag with h ≳ 1.5 Method I has smaller errors than implicit Euler and RK4.",
        quantifier: Quantifier::Comparison,
        criterion: "The largest error on (0, 10] of live runs is smaller at the steps 1.5, 2 and 2.5 of Figure 1 and at others up to 10.",
        decide: |context| large_steps(context, "method-i"),
    },
    Claim {
        id: "S24-d-2",
        source: "[S24] Section 3, Figures 1 and 2",
        statement: "On linear drag with h ≳ 1.5 Method II has smaller errors than implicit Euler and RK4.",
        quantifier: Quantifier::Comparison,
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
                    every h from 0.002 to 1.5.",
        decide: orders_of_magnitude,
    },
    Claim {
        id: "S24-e-2",
        source: "[S24] Section 3, Figures 1 and 2",
        statement: "On linear drag with h ≲ 1.5 RK4 has smaller errors than Methods I and II.",
        quantifier: Quantifier::Universal,
        criterion: "The largest error on (0, 10] of RK4 is the smallest for every h from 0.01 to 1.5.",
        decide: runge_kutta_wins,
    },
    Claim {
        id: "S24-e-3",
        source: "[S24] Section 3, after Eq. (27)",
        statement: "Methods I and II are also expected to converge faster than implicit Euler.",
        quantifier: Quantifier::Comparison,
        criterion: "The order fitted in the chapter on orders, against the exact solution of the equation that the method steps, exceeds \
                    implicit Euler's by a half at least on linear drag, on quadratic drag and on the Poiseuille ansatz.",
        decide: rates,
    },
    Claim {
        id: "S24-g-1",
        source: "[S24] Section 4, Figures 3 and 4",
        statement: "On quadratic drag Methods I and II generally have smaller errors than implicit Euler.",
        quantifier: Quantifier::Comparison,
        criterion: "The largest error on (0, 10] is smaller than implicit Euler's for each of the two at every step of the \
                    figures.",
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

/// The crossings of RK4 lie here, short of its loss of stability.
const UP_TO_STABILITY: [f64; 2] = [1.0, 2.4];

/// Where the largest error of a method on linear drag is that of its rival; there is no such step beyond a size.
fn crossing(
    context: &Context,
    method: &'static str,
    rival: &'static str,
    [low, high]: [f64; 2],
) -> Result<Option<f64>, StudyError> {
    Ok(*context.get(Crossing { problem: "linear-drag", method, rival, times: 1.0, low, high })?)
}

fn large_steps(context: &Context, method: &'static str) -> Result<Finding, StudyError> {
    let name = if method == BOTH[0] { "Method I" } else { "Method II" };
    let overtakes = crossing(context, method, "rk4", UP_TO_STABILITY)?.ok_or("RK4 is not overtaken")?;
    let loses = crossing(context, method, "implicit-euler", [2.0, 3.3])?; // Beyond h = 10/3 the runs have three points or fewer, and their largest errors jump.
    let mut cases = Vec::new();
    for h in [1.5, 1.55, 1.75, 2.0, 2.25, 2.5, 3.0, 5.0, 10.0] {
        let error = linear(context, method, h)?;
        for rival in YARDSTICKS {
            let what = format!("largest error, h = {h}, against {rival}");
            let is_between = h > overtakes && loses.is_none_or(|loses| h < loses);
            cases.push(Case::below(what, error, linear(context, rival, h)?).under(is_between).against(rival));
        }
    }
    let evidence = format!(
        "At h = 1.5 the largest error of {name} is {}, of RK4 {}: the paper's own step is on the other side. At h = 2.5 the \
         largest errors are {} ({name}), {} (implicit Euler) and {} (RK4); {name} overtakes RK4 at h = {}{}.",
        text(linear(context, method, 1.5)?),
        text(linear(context, "rk4", 1.5)?),
        text(linear(context, method, 2.5)?),
        text(linear(context, "implicit-euler", 2.5)?),
        text(linear(context, "rk4", 2.5)?),
        text(overtakes),
        loses.map_or_else(String::new, |h| format!(" and falls behind implicit Euler at h = {}", text(h)))
    );
    let finding = Finding::on(cases, evidence).beside("overtakes RK4 at h", "≈ 1.5", overtakes);
    let finding = match loses {
        None => finding.holds_where(format!("h > {} (tested to 10).", text(overtakes))).because(format!(
            "R(h) = 1/(1 + h + h²/2) tends to 0 like exp(−h) does, only more slowly; RK4's polynomial turns upwards \
             and is unstable beyond h = {}.",
            text(*context.get(LeavesAt::unit_circle("rk4", 2.0, 4.0))?)
        )),
        Some(h) => finding.holds_where(format!("{} < h < {}.", text(overtakes), text(h))).because(
            "R(h) = (1 − h/2)/(1 + h/2) tends to −1, while implicit Euler's 1/(1 + h) tends to 0 as the solution does.",
        ),
    };
    if method == BOTH[0] { with_figure(context, finding, overtakes) } else { Ok(finding) }
}

/// Errors of the four methods against h, and where Method I overtakes RK4.
fn with_figure(context: &Context, finding: Finding, overtakes: f64) -> Result<Finding, StudyError> {
    let methods = [BOTH[0], BOTH[1], YARDSTICKS[0], YARDSTICKS[1]];
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
    let caption = "Largest error on (0, 10] on linear drag. RK4 is the best up to the dashed line, Method I beyond it; \
                   Method II ends up behind implicit Euler.";
    let panel = Panel::new(Axis::log("step size h"), Axis::log("largest error").between(1e-9, 10.0), series);
    Ok(finding.with_figure(Figure::new("claims-linear-drag", caption, "claims-linear-drag", [panel]), data))
}

fn orders_of_magnitude(context: &Context) -> Result<Finding, StudyError> {
    let ratio = |method: &'static str, h: f64| -> Result<f64, StudyError> {
        Ok(linear(context, "implicit-euler", h)? / linear(context, method, h)?)
    };
    let (mut cases, mut starts) = (Vec::new(), Vec::new());
    for method in BOTH {
        for h in [1.5, 1.0, 0.5, 0.1, 0.05, 0.01, 0.002] {
            cases.push(Case::above(format!("error ratio, {method}, h = {h}"), ratio(method, h)?, 100.0));
        }
        let hundredfold = Crossing {
            problem: "linear-drag",
            method: "implicit-euler",
            rival: method,
            times: 100.0,
            low: 0.01,
            high: 1.0,
        };
        starts.push(context.get(hundredfold)?.ok_or("the ratio of the errors does not reach 100")?);
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
            "They are smaller at every h ≤ 1.5 (tested from 0.002), by two orders of magnitude from h = {} (Method I) and h = {} (Method II) \
             down.",
            text(starts[0]),
            text(starts[1])
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
    let crossings =
        [crossing(context, BOTH[0], "rk4", UP_TO_STABILITY)?, crossing(context, BOTH[1], "rk4", UP_TO_STABILITY)?];
    let [Some(one), Some(two)] = crossings else { return Err("RK4 is not overtaken".into()) };
    let evidence =
        format!("RK4 is the best up to h = {} against Method I and h = {} against Method II.", text(one), text(two));
    Ok(Finding::on(cases, evidence)
        .beside("RK4 is the best up to h", "≈ 1.5", one.min(two))
        .because("RK4 is of fourth order, they are of second."))
}

fn rate(context: &Context, problem: &'static str, method: &'static str) -> Result<f64, StudyError> {
    Ok(*context.get(Order { problem, method })?)
}

fn rates(context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut rows) = (Vec::new(), Vec::new());
    for problem in ["linear-drag", "quadratic-drag", "poiseuille-ansatz"] {
        let slow = rate(context, problem, "implicit-euler")?;
        let orders = [rate(context, problem, BOTH[0])?, rate(context, problem, BOTH[1])?];
        for (method, order) in BOTH.into_iter().zip(orders) {
            let case = Case::above(format!("order of {method}, {problem}, against implicit-euler"), order, slow + 0.5);
            cases.push(case.under(problem != "poiseuille-ansatz").against("implicit-euler"));
        }
        rows.push(row![problem, orders[0], orders[1], slow]);
    }
    let of = |order: usize| text(cases[order].measured);
    let evidence = format!(
        "The orders of Methods I and II are {} and {} on linear drag, {} and {} on quadratic drag, and {} and {} on the \
         Poiseuille ansatz.",
        of(0),
        of(1),
        of(2),
        of(3),
        of(4),
        of(5)
    );
    let columns = ["problem", "method_i", "method_ii", "implicit_euler"];
    let table = Table::new("claims-rates", "Fitted orders, those of the chapter on orders.", columns, rows);
    Ok(Finding::on(cases, evidence)
        .holds_where("Where the Lagrangian is the residual's alone; with Method II on the ansatz too.")
        .because(
            "A closure that leaves the residual at zero is of second order, one more than implicit Euler. The reduced Lagrangian of the \
             ansatz keeps a remainder besides, and with it p = 0 is met to first order only.",
        )
        .with_table(table))
}

/// The steps of Figures 3 and 4.
const QUADRATIC_STEPS: [f64; 6] = [1.0, 0.1, 0.05, 0.01, 0.005, 0.001];

fn quadratic_against_euler(context: &Context) -> Result<Finding, StudyError> {
    let mut cases = Vec::new();
    for method in BOTH {
        for h in QUADRATIC_STEPS {
            let what = format!("largest error, {method}, h = {h}, against implicit-euler");
            cases.push(
                Case::below(what, quadratic(context, method, h)?, quadratic(context, "implicit-euler", h)?)
                    .under(h < 1.0)
                    .against("implicit-euler"),
            );
        }
    }
    let ratio = |method: &'static str, h: f64| -> Result<f64, StudyError> {
        Ok(quadratic(context, "implicit-euler", h)? / quadratic(context, method, h)?)
    };
    let evidence = format!(
        "Implicit Euler's error is {} times Method I's at h = 1, {} times at h = 0.1, {} times at h = 0.01; {} and {} times \
         Method II's at the last two.",
        text(ratio(BOTH[0], 1.0)?),
        text(ratio(BOTH[0], 0.1)?),
        text(ratio(BOTH[0], 0.01)?),
        text(ratio(BOTH[1], 0.1)?),
        text(ratio(BOTH[1], 0.01)?)
    );
    Ok(Finding::on(cases, evidence).holds_where("At h < 1 (tested from 0.001), and with Method I at h = 1 too.").because(
        "At h v₀ = 1 two roots of Method II's step meet at v₁ = 0, and beyond there is none on the branch of v₀: S24-h-2.",
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
    Ok(Finding::on(cases, evidence).because("RK4 is of fourth order, they are of second."))
}
