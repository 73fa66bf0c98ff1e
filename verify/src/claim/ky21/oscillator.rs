//! The schemes for the harmonic oscillator: what they are, and what more nodes bring.

use crate::claim::measure::text;
use crate::claim::{Case, Claim, Finding, Quantifier};
use crate::evidence::{Table, number};
use crate::experiment::end_errors::{EndErrors, Truth};
use crate::experiment::motion::{Difference, LargestError, Motion};
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
        id: "KY21-b-3",
        source: "[KY21] Abstract, Section 3.1",
        statement: "At equal order path fitting has smaller errors, local and global, than a classical variational integrator.",
        quantifier: Quantifier::Comparison,
        criterion: "The largest error in x on (0, 20] of degree 2 is smaller than that of the midpoint rule and of \
                    Störmer–Verlet, on the oscillator, the pendulum and Kepler's problem (e = 0.3), for τ from 0.05 to 0.4, and \
                    on the oscillator for τ = 1, 2 and 3; and so is that of a single step of 0.1.",
        decide: at_equal_order,
    },
    Claim {
        id: "KY21-c-2",
        source: "[KY21] Section 3.1, after (19)",
        statement: "The denser the interior nodes, the more accurate the scheme.",
        quantifier: Quantifier::Universal,
        criterion: "On the pendulum, a nonlinear problem, each further node from degree 2 to 6 makes the error at t = 4 with \
                    τ = 0.2 smaller.",
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
    let worst = text(off.into_iter().largest());
    let evidence = format!("All printed coefficients are right: the traces differ from them by {worst} at most.");
    Ok(Finding::on(cases, evidence))
}

/// A problem, and the steps to take on it.
type Setting = (&'static str, &'static str, &'static [f64]);

fn at_equal_order(context: &Context) -> Result<Finding, StudyError> {
    let mut cases = Vec::new();
    let settings: [Setting; 3] = [
        ("harmonic-oscillator", "harmonic-oscillator", &[0.05, 0.1, 0.2, 0.4, 1.0, 2.0, 3.0]),
        ("pendulum", "pendulum", &[0.05, 0.1, 0.2, 0.4]),
        ("kepler", "kepler eccentricity=0.3", &[0.05, 0.1, 0.2, 0.4]),
    ];
    let stable = context.get(Stable { method: "path-fitted(2)".into() })?;
    let limit = stable.first().map(|(_, end)| *end).ok_or("degree 2 is stable nowhere")?;
    let (mut ratios, mut ahead, mut local) = (Vec::new(), Vec::new(), Vec::new());
    for (name, problem, steps) in settings {
        let first = cases.len();
        for h in steps {
            // Whole steps up to the last time before 20.
            let t_end = h * (20.0 / h + 1e-9).floor();
            let error = |method: &str| -> Result<f64, StudyError> {
                Ok(*context.get(LargestError(Motion { problem, method: method.into(), h: *h, t_end }))?)
            };
            let own = error("path-fitted(2)")?;
            for rival in ["midpoint-vi", "stormer-verlet"] {
                let theirs = error(rival)?;
                if *h == 0.1 {
                    ratios.push(format!("{} ({name}, {rival})", text(own / theirs)));
                }
                let is_stable_oscillation = name == "harmonic-oscillator" && *h < limit;
                let case = Case::below(format!("largest error, {name}, τ = {h}, against {rival}"), own, theirs);
                cases.push(case.under(is_stable_oscillation).against(rival));
            }
        }
        for rival in ["midpoint-vi", "stormer-verlet"] {
            let (h, t_end) = (0.1, 0.1);
            let error = |method: &str| context.get(LargestError(Motion { problem, method: method.into(), h, t_end }));
            let what = format!("error of one step, {name}, τ = {h}, against {rival}");
            local.push(Case::below(what, *error("path-fitted(2)")?, *error(rival)?).against(rival));
        }
        for (i, rival) in ["midpoint-vi", "stormer-verlet"].into_iter().enumerate() {
            let holding = cases[first..].iter().skip(i).step_by(2).filter(|case| case.holds()).count();
            ahead.push((name, rival, holding, steps.len()));
        }
    }
    let behind: Vec<_> = local.iter().filter(|case| !case.holds()).map(Case::to_string).collect();
    let single = format!("{} of {} single steps of 0.1", local.len() - behind.len(), local.len());
    cases.extend(local);
    let never: Vec<_> = ahead.iter().filter(|(_, _, holding, _)| *holding == 0).collect();
    let never: Vec<_> =
        never.iter().map(|(name, rival, _, of)| format!("at none of {of} steps on {name} against {rival}")).collect();
    let ahead: Vec<String> = ahead
        .iter()
        .map(|(name, rival, holding, of)| format!("{holding} of {of} steps on {name} against {rival}"))
        .collect();
    let evidence = format!(
        "At τ = 0.1 the error of degree 2 divided by the other's is {}. It is ahead {}. Of single steps these fail: {}.",
        ratios.join(", "),
        never.join(", "),
        behind.join("; ")
    );
    Ok(Finding::on(cases, evidence)
        .holds_where(format!(
            "In largest errors, on the oscillator below τ = {}, beyond which it is unstable; the midpoint rule has no such limit. It is \
             ahead at {}, and at {single}.",
            text(limit),
            ahead.join(", ")
        ))
        .because(
            "On the oscillator the phase errors per step are τ³/48 (degree 2), τ³/12 (midpoint rule) and −τ³/24 \
             (Störmer–Verlet): one Gauss node on a parabola instead of a straight path. All three are of second order, and on nonlinear problems it depends on the \
             problem which constant is the smallest.",
        ))
}

fn more_nodes(context: &Context) -> Result<Finding, StudyError> {
    // At the end, t = 4, for τ = 0.2 and 0.1.
    let error = |method: &str, h: f64| -> Result<f64, StudyError> {
        let (problem, truth) = ("pendulum".into(), Truth::Solution);
        Ok(context.get(EndErrors { problem, method: method.into(), h, pieces: 1, t_end: 4.0, truth })?.end)
    };
    let order = |method: &str| -> Result<f64, StudyError> { Ok((error(method, 0.2)? / error(method, 0.1)?).log2()) };
    let (mut cases, mut rows, mut before) = (Vec::new(), Vec::new(), None);
    let (mut orders, mut gauss_orders) = (Vec::new(), Vec::new());
    for m in 2..=6_u32 {
        let (equispaced, gauss) = (format!("path-fitted({m})"), format!("path-fitted({m},gauss)"));
        let measured = order(&equispaced)?;
        let own = error(&equispaced, 0.2)?;
        if let Some(before) = before.replace(own) {
            cases.push(Case::below(format!("error of degree {m}, against degree {}", m - 1), own, before));
        }
        // Beyond degree 4 the errors on Gauss nodes reach rounding before they are asymptotic.
        let on_gauss = if m > 4 { None } else { Some(order(&gauss)?) };
        orders.push(format!("{measured:.1}"));
        gauss_orders.extend(on_gauss.map(|order| format!("{order:.1}")));
        rows.push(row![m, measured, own, on_gauss, error(&gauss, 0.2)?]);
    }
    let evidence = format!(
        "The orders of degrees 2 to 6 on equispaced nodes are {}; those of 2 to 4 on Gauss nodes {}. Table 2 itself prints a larger \
         error for (19) than for (18) at t = 10, {} against {}, for a reason of its own (KY21-c-1).",
        orders.join(", "),
        gauss_orders.join(", "),
        number::digits(TABLE_2[3][0], 5),
        number::digits(TABLE_2[2][0], 5)
    );
    let columns = ["degree", "order_equispaced", "error_equispaced", "order_gauss", "error_gauss"];
    let orders = Table::new(
        "claims-path-fitted-orders",
        "Path fitting on the pendulum from 2 rad: error at t = 4 with τ = 0.2, and order measured between τ = 0.2 and 0.1, by \
         degree, on the paper's equispaced nodes and on Gauss nodes.",
        columns,
        rows,
    );
    Ok(Finding::on(cases, evidence)
        .holds_where("From an odd degree to the even one after it, which gains two orders; from an even to an odd one the order stays.")
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
    let worst = text(apart.into_iter().largest());
    let evidence = format!("The two differ by {worst} at most, on the pendulum too.");
    Ok(Finding::on(cases, evidence).because(
        "Both bases span the polynomials of degree m, and the conditions on the path do not mention a basis: it is one \
         method in two coordinates for every Lagrangian, (21) and (22) included.",
    ))
}
