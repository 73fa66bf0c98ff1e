//! The schemes for the harmonic oscillator: what they are, and what more nodes bring.

use crate::claim::measure::{at_most, is_within, range, sizes, text};
use crate::claim::{Case, Claim, Finding, Quantifier};
use crate::evidence::{Table, number};
use crate::experiment::motion::{AheadInMotion, Difference, LargestError, LocalError, Motion};
use crate::experiment::orders::Order;
use crate::experiment::oscillator::{Stable, StepMap};
use crate::experiment::{Context, StudyError};
use crate::measure::norm::Extremes;
use crate::row;
use crate::theory::oscillator::PRINTED;

use super::tables::TABLE_2;

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "KY21-a",
        source: "[KY21] (16)–(19)",
        statement: "Path fitting of degree 2, 3 and 4 gives the recurrences (16), (18) and (19) for the harmonic oscillator, the \
                    midpoint rule (17).",
        quantifier: Quantifier::Universal,
        criterion: "The trace of the live map (x, p) over one step is the printed R(τ), and its determinant 1, to the \
                    rounding of the step, for τ from 0.1 to 3.",
        decide: recurrences,
    },
    Claim {
        id: "KY21-b-5",
        source: "[KY21] Section 3.1, after (17)",
        statement: "For the harmonic oscillator the schemes (16) and (17) are both of second order.",
        quantifier: Quantifier::Universal,
        criterion: "The orders fitted to live runs of degree 2 and of the midpoint rule are 2 to within 0.1.",
        decide: second_order,
    },
    Claim {
        id: "KY21-b-3",
        source: "[KY21] Sections 3.1 and 4",
        statement: "Path fitting of degree 2 has smaller global errors than a classical variational integrator of its order.",
        quantifier: Quantifier::Comparison,
        criterion: "The largest error in x on (0, 20] of degree 2 is smaller than that of the midpoint rule and of \
                    Störmer–Verlet, on the oscillator, the pendulum from 2 rad and Kepler's problem (e = 0.3), for τ from 0.05 to 0.4, and \
                    on the oscillator for τ = 1, 2, 2.8 and 2.825; degree 2 diverges from τ = √8 on.",
        decide: global_errors,
    },
    Claim {
        id: "KY21-b-4",
        source: "[KY21] Abstract, Section 3.1",
        statement: "Path fitting of degree 2 has smaller local errors than a classical variational integrator of its order.",
        quantifier: Quantifier::Comparison,
        criterion: "The schemes are recurrences, as (16) and (17) are: from exact xₖ₋₁ and xₖ the distance of xₖ₊₁ from the solution is smaller for \
                    degree 2 than for the midpoint rule and Störmer–Verlet, with τ = 0.1 from 16 times of (0, 20] on each of the three problems.",
        decide: local_errors,
    },
    Claim {
        id: "KY21-c-2",
        source: "[KY21] Section 3.1, after (19)",
        statement: "The denser the interior nodes, the more accurate the scheme.",
        quantifier: Quantifier::Universal,
        criterion: "Each further node from degree 2 to 6 makes the largest error in x on (0, 20] smaller, on two nonlinear problems: the pendulum \
                    from 2 rad with τ = 0.2 and Kepler's problem (e = 0.3) with τ = 0.1.",
        decide: more_nodes,
    },
    Claim {
        id: "KY21-d",
        source: "[KY21] (13), remark after Table 2",
        statement: "Bernstein interpolation in place of Lagrange's gives the same schemes for the linear oscillator.",
        quantifier: Quantifier::General,
        criterion: "One live step of either gives the same (x, p) to rounding for degrees 2 to 5 and τ from 0.1 to 2, and so \
                    does one on the pendulum.",
        decide: bernstein,
    },
];

fn recurrences(context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut off) = (Vec::new(), Vec::new());
    for known in PRINTED {
        for tau in [0.1, 0.2, 0.5, 1.0, 2.0, 3.0] {
            let map = context.get(StepMap { method: known.method.into(), tau })?;
            let (trace, determinant) = ((map.trace - known.trace(tau)).abs(), (map.determinant - 1.0).abs());
            off.push(trace);
            for (what, off) in [("trace − R", trace), ("determinant − 1", determinant)] {
                cases.push(Case::below(format!("|{what}| of {}, τ = {tau}", known.equation()), off, map.rounding));
            }
        }
    }
    let worst = at_most(off.into_iter().largest());
    let evidence = format!("All printed coefficients are right: the traces differ from them by {worst} at most.");
    Ok(Finding::on(cases, evidence))
}

fn second_order(context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut orders) = (Vec::new(), Vec::new());
    for method in ["path-fitted(2)", "midpoint-vi"] {
        let order = *context.get(Order { problem: "harmonic-oscillator", method })?;
        orders.push(format!("{} ({method})", text(order)));
        cases.push(Case::between(format!("order of {method}"), order, 1.9, 2.1));
    }
    Ok(Finding::on(cases, format!("The orders are {}.", orders.join(" and "))))
}

/// The classical integrators of the same order.
const CLASSICAL: [&str; 2] = ["midpoint-vi", "stormer-verlet"];
/// The problems by name, with their parameters.
const PROBLEMS: [(&str, &str); 3] = [
    ("harmonic-oscillator", "harmonic-oscillator"),
    ("pendulum from 2 rad", "pendulum"),
    ("kepler", "kepler eccentricity=0.3"),
];

fn global_errors(context: &Context) -> Result<Finding, StudyError> {
    // To where degree 2 diverges, at √8.
    const BETWEEN: [f64; 2] = [0.05, 2.828];
    const METHOD: &str = "path-fitted(2)";
    let stable = context.get(Stable { method: METHOD.into() })?;
    let limit = stable.first().map(|(_, end)| *end).ok_or("degree 2 is stable nowhere")?;
    let of_verlet = context.get(Stable { method: CLASSICAL[1].into() })?;
    let of_verlet = of_verlet.first().map(|(_, end)| *end).ok_or("Störmer–Verlet is stable nowhere")?;
    let scan = |rival| AheadInMotion { problem: PROBLEMS[0].1, method: METHOD, rival, t_end: T_END, between: BETWEEN };
    let scanned = CLASSICAL.map(|rival| context.get(scan(rival)));
    let [midpoint, verlet] = scanned;
    let (midpoint, verlet) = (midpoint?, verlet?);
    let (mut cases, mut ratios, mut ahead) = (Vec::new(), Vec::new(), Vec::new());
    for (name, problem) in PROBLEMS {
        let first = cases.len();
        let large: &[f64] = if name == PROBLEMS[0].0 { &[1.0, 2.0, 2.8, 2.825] } else { &[] };
        let steps = [&[0.05, 0.1, 0.2, 0.4], large].concat();
        for h in &steps {
            let own = largest_error(context, problem, METHOD, *h)?;
            for (rival, scanned) in CLASSICAL.into_iter().zip([&midpoint, &verlet]) {
                let theirs = largest_error(context, problem, rival, *h)?;
                if *h == 0.1 {
                    ratios.push(format!("{} ({name}, {rival})", text(own / theirs)));
                }
                let case = Case::below(format!("largest error, {name}, τ = {h}, against {rival}"), own, theirs);
                cases.push(case.under(name == PROBLEMS[0].0 && is_within(scanned, *h)).against(rival));
            }
        }
        for (i, rival) in CLASSICAL.into_iter().enumerate() {
            let holding = cases[first..].iter().skip(i).step_by(2).filter(|case| case.holds()).count();
            ahead.push((name, rival, holding, steps.len()));
        }
    }
    let never: Vec<_> = ahead
        .iter()
        .filter(|(_, _, holding, _)| *holding == 0)
        .map(|(name, rival, _, of)| format!("at none of {of} steps on {name} against {rival}"))
        .collect();
    let ahead: Vec<String> = ahead
        .iter()
        .map(|(name, rival, holding, of)| format!("{holding} of {of} steps on {name} against {rival}"))
        .collect();
    let evidence = format!(
        "At τ = 0.1 the error of degree 2 divided by the other's is {}. It is ahead {}.",
        ratios.join(", "),
        never.join(", ")
    );
    Ok(Finding::on(cases, evidence)
        .holds_where(format!(
            "On the oscillator at {} against the midpoint rule, which has no limit of stability, and at {} against Störmer–Verlet, which is \
             unstable from τ = {} on (scanned from {} to {}); degree 2 is unstable from τ = {} on. Of the steps tested it is ahead at {}.",
            sizes("τ", &midpoint, BETWEEN),
            sizes("τ", &verlet, BETWEEN),
            text(of_verlet),
            BETWEEN[0],
            BETWEEN[1],
            text(limit),
            ahead.join(", ")
        ))
        .because(
            "On the oscillator the phase of a step is off by −τ³/48 (degree 2), −τ³/12 (midpoint rule) and τ³/24 \
             (Störmer–Verlet): one Gauss node on a parabola instead of a straight path. All three are of second order, and on nonlinear problems it depends on the \
             problem which constant is the smallest.",
        ))
}

fn local_errors(context: &Context) -> Result<Finding, StudyError> {
    const H: f64 = 0.1;
    const STARTS: u32 = 16;
    let (mut cases, mut ratios, mut behind) = (Vec::new(), Vec::new(), Vec::new());
    for (name, problem) in PROBLEMS {
        for rival in CLASSICAL {
            let mut quotients = Vec::new();
            let first = cases.len();
            for k in 1..=STARTS {
                let t = T_END * f64::from(k) / f64::from(STARTS);
                let error = |method| context.get(LocalError { problem, method, h: H, t });
                let [own, theirs] = [*error("path-fitted(2)")?, *error(rival)?];
                quotients.push(own / theirs);
                let what = format!("local error, {name}, from t = {t}, against {rival}");
                cases.push(Case::below(what, own, theirs).under(name == PROBLEMS[0].0).against(rival));
            }
            let [least, most] = [quotients.iter().copied().smallest(), quotients.iter().copied().largest()];
            ratios.push(format!("{} ({name}, {rival})", range(least, most)));
            let failing: Vec<_> = cases[first..].iter().filter(|case| !case.holds()).collect();
            if !failing.is_empty() {
                behind.push(format!("{} of {STARTS} on {name} against {rival}", failing.len()));
            }
        }
    }
    let evidence = format!(
        "The local error of degree 2 divided by the other's is {}. It is behind at {}.",
        ratios.join(", "),
        behind.join(", ")
    );
    Ok(Finding::on(cases, evidence)
        .holds_where(format!(
            "For small τ, tested at {H}, to leading order and so where x⁗ is not 0, where the Lagrangian is ½|ẋ|² − V(x): on oscillators against both, on any \
             smooth V against Störmer–Verlet, where its local error is half as large, and against the midpoint rule on a nonlinear problem of one unknown \
             where F′(x) ẍ has the sign of x⁗."
        ))
        .because(
            "For ẍ = F(x) the local errors of the recurrences, solution less step, are −τ⁴x⁗/24 (degree 2), τ⁴x⁗/12 (Störmer–Verlet) and −τ⁴x⁗/24 − τ⁴F′(x) ẍ/8 (midpoint \
             rule); on the oscillator F′ẍ = x⁗ and the last is −τ⁴x⁗/6.",
        ))
}

/// The end of the runs whose largest errors are compared.
const T_END: f64 = 20.0;

/// The largest error of a coordinate up to [`T_END`], in whole steps.
fn largest_error(context: &Context, problem: &'static str, method: &str, h: f64) -> Result<f64, StudyError> {
    let t_end = AheadInMotion::whole_steps(h, T_END);
    Ok(*context.get(LargestError(Motion { problem, method: method.into(), h, t_end }))?)
}

fn more_nodes(context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut rows) = (Vec::new(), Vec::new());
    let (mut orders, mut gauss_orders, mut behind) = (Vec::new(), Vec::new(), Vec::new());
    for ((name, problem), tau) in PROBLEMS[1..].iter().copied().zip([0.2, 0.1]) {
        let error = |method: &str, h| largest_error(context, problem, method, h);
        let order =
            |method: &str| -> Result<f64, StudyError> { Ok((error(method, tau)? / error(method, 0.5 * tau)?).log2()) };
        let mut before = None;
        for m in 2..=6_u32 {
            let (equispaced, gauss) = (format!("path-fitted({m})"), format!("path-fitted({m},gauss)"));
            let measured = order(&equispaced)?;
            let own = error(&equispaced, tau)?;
            if let Some(before) = before.replace(own) {
                let what = format!("largest error of degree {m}, {name}, against degree {}", m - 1);
                cases.push(Case::below(what, own, before));
                if own >= before {
                    behind.push(format!("{m} is {} times that of {}", text(own / before), m - 1));
                }
            }
            // Beyond degree 4 the errors on Gauss nodes reach rounding before they are asymptotic.
            let on_gauss = if m > 4 { None } else { Some(order(&gauss)?) };
            orders.push(measured);
            gauss_orders.extend(on_gauss);
            rows.push(row![name, m, measured, own, on_gauss, error(&gauss, tau)?]);
        }
    }
    // One order to a digit, whatever the problem.
    let of_both = |orders: &[f64]| -> String {
        let [here, there] = [0, 1].map(|half| orders.chunks(orders.len() / 2).nth(half).unwrap_or_default());
        let said = here.iter().zip(there).map(|(a, b)| match [a, b].map(|order| format!("{order:.1}")) {
            [a, b] if a == b => a,
            [a, b] => format!("{a} or {b}"),
        });
        said.collect::<Vec<_>>().join(", ")
    };
    let evidence = format!(
        "On Kepler's problem the largest error of degree {}. The orders of degrees 2 to 6 on equispaced nodes are {}; those of 2 to 4 on Gauss nodes {}. \
         Table 2 itself prints a larger error for (19) than for (18) at t = 10, {} against {}, for a reason of its own (KY21-c-1).",
        behind.join(", and that of degree "),
        of_both(&orders),
        of_both(&gauss_orders),
        number::digits(TABLE_2[3][0], 5),
        number::digits(TABLE_2[2][0], 5)
    );
    let columns = ["problem", "degree", "order_equispaced", "error_equispaced", "order_gauss", "error_gauss"];
    let orders = Table::new(
        "claims-path-fitted-orders",
        "Path fitting on the pendulum from 2 rad (τ = 0.2) and on Kepler's problem (e = 0.3, τ = 0.1): largest error in x on (0, 20], and its order \
         measured between τ and τ/2, by degree, on the paper's equispaced nodes and on Gauss nodes, where those of degrees 5 and 6 reach rounding before they settle.",
        columns,
        rows,
    );
    Ok(Finding::on(cases, evidence)
        .holds_where(
            "From an odd degree to the even one after it, which gains two orders, in steps so short that the orders show and from exact starting values. From an even to an odd one the order stays, and it depends on the problem \
             which error constant is the smaller.",
        )
        .because(
            "It is direct collocation with m − 1 stages: m − 1 equispaced nodes, symmetric about the middle, integrate \
             to order 2⌊m/2⌋, Gauss nodes to 2(m − 1), at the same cost.",
        )
        .with_table(orders))
}

fn bernstein(context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut apart) = (Vec::new(), Vec::new());
    for problem in ["harmonic-oscillator", "pendulum"] {
        for m in 2..=5 {
            let (one, other) = (format!("path-fitted({m})"), format!("path-fitted-bernstein({m})"));
            for h in [0.1, 0.5, 1.0, 2.0] {
                let (one, other) = (one.clone(), other.clone());
                let found = context.get(Difference { problem, one, other, h, steps: 1 })?;
                apart.push(found.largest);
                let what = format!("difference, {problem}, degree {m}, τ = {h}");
                cases.push(Case::below(what, found.largest, found.rounding));
            }
        }
    }
    let worst = at_most(apart.into_iter().largest());
    let evidence = format!("The two differ by {worst} at most, on the pendulum too.");
    Ok(Finding::on(cases, evidence).because(
        "Both bases span the polynomials of degree m, and the conditions on the path do not mention a basis: it is one \
         method in two coordinates for every Lagrangian, (21) and (22) included.",
    ))
}
