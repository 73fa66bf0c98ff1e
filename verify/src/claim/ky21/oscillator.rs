//! The schemes for the harmonic oscillator: what they are, and what more nodes bring.

use crate::claim::measure::{distance_from_exact, one_state, problem, table, text, threshold};
use crate::claim::{Case, Claim, Finding, Quantifier};
use crate::experiment::{Context, StudyError};
use crate::golden::table::rows;
use crate::golden::{Row, Tolerance, Truth};
use crate::measure::norm::{Extremes, larger};

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
        statement: "At equal order path fitting has smaller errors than a classical variational integrator.",
        quantifier: Quantifier::Comparison,
        criterion: "The largest error in x on (0, 20] of degree 2 is smaller than that of the midpoint rule and of \
                    Störmer–Verlet, on the oscillator, the pendulum and Kepler's problem (e = 0.3), for τ from 0.05 to 0.4, and \
                    on the oscillator for τ = 1, 2 and 3.",
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

/// Number of a recurrence, method that gives it, and R as a function of τ².
type Printed = (&'static str, &'static str, fn(f64) -> f64);

/// A problem with parameters, the number of its coordinates and the steps to take.
type Setting = (&'static str, &'static [(&'static str, &'static str)], usize, &'static [f64]);

/// The recurrences as printed.
pub(super) const PRINTED: [Printed; 4] = [
    ("(16)", "path-fitted(2)", |s| (16.0 - 6.0 * s) / (8.0 + s)),
    ("(17)", "midpoint-vi", |s| (8.0 - 2.0 * s) / (4.0 + s)),
    ("(18)", "path-fitted(3)", |s| (22.0 * s * s - 468.0 * s + 972.0) / (2.0 * s * s + 9.0 * s + 486.0)),
    ("(19)", "path-fitted(4)", |s| {
        (-150.0 * s.powi(3) + 9616.0 * s * s - 142_848.0 * s + 294_912.0)
            / (9.0 * s.powi(3) - 184.0 * s * s + 2304.0 * s + 147_456.0)
    }),
];

/// The map of one step on the oscillator, by its columns.
fn map(method: &str, tau: f64) -> Result<[[f64; 2]; 2], StudyError> {
    let column = |q0: &str, p0: &str| -> Result<[f64; 2], StudyError> {
        let oscillator = problem("harmonic-oscillator", &[("q0", q0), ("p0", p0)])?;
        let state = one_state(&*oscillator, method, tau)?;
        Ok([state[0], state[1]])
    };
    Ok([column("1", "0")?, column("0", "1")?])
}

/// Rounding of a step: two differentiations of m ≤ 5 nodes over τ, at most m⁴/τ² each, on numbers up to `size`.
fn rounding(tau: f64, size: f64) -> f64 {
    4.0 * f64::EPSILON * (1.0 + 625.0 / (tau * tau)) * (1.0 + size) * (1.0 + size)
}

fn recurrences(_context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut worst) = (Vec::new(), 0.0_f64);
    for (equation, method, printed) in PRINTED {
        for tau in [0.1, 0.2, 0.5, 1.0, 2.0, 3.0] {
            let [a, b] = map(method, tau)?;
            let exact = printed(tau * tau);
            let off = (a[0] + b[1] - exact).abs();
            worst = larger(worst, off);
            let size = [a[0], a[1], b[0], b[1]].map(f64::abs).into_iter().largest();
            cases.push(Case::below(format!("|trace − R| of {equation}, τ = {tau}"), off, rounding(tau, size)));
            let determinant = (a[0] * b[1] - a[1] * b[0] - 1.0).abs();
            let what = format!("|determinant − 1| of {equation}, τ = {tau}");
            cases.push(Case::below(what, determinant, rounding(tau, size)));
        }
    }
    let evidence =
        format!("All printed coefficients are right: the traces differ from them by {} at most.", text(worst));
    Ok(Finding::on(cases, evidence))
}

fn at_equal_order(_context: &Context) -> Result<Finding, StudyError> {
    let mut cases = Vec::new();
    let settings: [Setting; 3] = [
        ("harmonic-oscillator", &[], 1, &[0.05, 0.1, 0.2, 0.4, 1.0, 2.0, 3.0]),
        ("pendulum", &[], 1, &[0.05, 0.1, 0.2, 0.4]),
        ("kepler", &[("eccentricity", "0.3")], 2, &[0.05, 0.1, 0.2, 0.4]),
    ];
    let limit = threshold("|R| = 2 of degree 2", 2.0, 3.5, |tau| {
        let [a, b] = map("path-fitted(2)", tau)?;
        Ok((a[0] + b[1]).abs() - 2.0)
    })?;
    let (mut ratios, mut ahead) = (Vec::new(), Vec::new());
    for (name, set, n, steps) in settings {
        let system = problem(name, set)?;
        let first = cases.len();
        for tau in steps {
            // Whole steps up to the last time before 20.
            let horizon = tau * (20.0 / tau + 1e-9).floor();
            let error = |method: &str| distance_from_exact(&*system, method, *tau, horizon, n);
            let own = error("path-fitted(2)")?;
            for rival in ["midpoint-vi", "stormer-verlet"] {
                let theirs = error(rival)?;
                if *tau == 0.1 {
                    ratios.push(format!("{} ({name}, {rival})", text(own / theirs)));
                }
                let is_stable_oscillation = name == "harmonic-oscillator" && *tau < limit;
                let case = Case::below(format!("largest error, {name}, τ = {tau}, against {rival}"), own, theirs);
                cases.push(case.under(is_stable_oscillation));
            }
        }
        for (i, rival) in ["midpoint-vi", "stormer-verlet"].into_iter().enumerate() {
            let holding = cases[first..].iter().skip(i).step_by(2).filter(|case| case.holds()).count();
            ahead.push((name, rival, holding, steps.len()));
        }
    }
    let ahead: Vec<String> = ahead
        .iter()
        .map(|(name, rival, holding, of)| format!("{holding} of {of} steps on {name} against {rival}"))
        .collect();
    let evidence = format!("At τ = 0.1 the error of degree 2 divided by the other's is {}.", ratios.join(", "));
    Ok(Finding::on(cases, evidence)
        .holds_where(format!(
            "On the oscillator below τ = {}, beyond which it is unstable; the midpoint rule has no such limit. It is ahead at {}.",
            text(limit),
            ahead.join(", ")
        ))
        .because(
            "On the oscillator the phase errors per step are τ³/48 (degree 2), τ³/12 (midpoint rule) and −τ³/24 \
             (Störmer–Verlet): one Gauss node on a parabola instead of a straight path. All three are of second order, and on nonlinear problems it depends on the \
             problem which constant is the smallest.",
        ))
}

fn more_nodes(_context: &Context) -> Result<Finding, StudyError> {
    let pendulum = problem("pendulum", &[])?;
    // At the end, t = 4: larger steps for higher orders, whose errors would reach rounding else.
    let error = |method: &str, tau: f64| -> Result<f64, StudyError> {
        let states = crate::claim::measure::trajectory(&*pendulum, method, tau, 4.0)?;
        let (t, last) = states.last().ok_or("no state")?;
        let exact = pendulum.exact(*t).ok_or("no exact solution is known")?;
        Ok(crate::measure::norm::distance(last, &exact))
    };
    let order = |method: &str, tau: f64| -> Result<f64, StudyError> {
        Ok((error(method, tau)? / error(method, 0.5 * tau)?).log2())
    };
    let (mut cases, mut rows, mut before) = (Vec::new(), Vec::new(), None);
    for m in 2..=6 {
        let (equispaced, gauss) = (format!("path-fitted({m})"), format!("path-fitted({m},gauss)"));
        let measured = order(&equispaced, if m < 4 { 0.1 } else { 0.2 })?;
        let own = error(&equispaced, 0.2)?;
        if let Some(before) = before.replace(own) {
            cases.push(Case::below(format!("error of degree {m}, against degree {}", m - 1), own, before));
        }
        // Beyond degree 4 the errors on Gauss nodes reach rounding before they are asymptotic.
        let on_gauss = if m > 4 { f64::NAN } else { order(&gauss, if m < 4 { 0.1 } else { 0.2 })? };
        rows.push((vec![], vec![m as f64, measured, own, on_gauss, error(&gauss, 0.2)?]));
    }
    let orders: Vec<String> = rows.iter().map(|(_, row)| format!("{:.1}", row[1])).collect();
    let gauss: Vec<String> = rows.iter().take(3).map(|(_, row)| format!("{:.1}", row[3])).collect();
    let evidence = format!(
        "The orders of degrees 2 to 6 on equispaced nodes are {}; those of 2 to 4 on Gauss nodes {}.",
        orders.join(", "),
        gauss.join(", ")
    );
    let columns = ["degree", "order_equispaced", "error_equispaced", "order_gauss", "error_gauss"];
    let orders = table(
        "claims-path-fitted-orders",
        "Path fitting on the pendulum from 2 rad: measured order and error at t = 4 with τ = 0.2, by degree, on the paper's \
         equispaced nodes and on Gauss nodes.",
        &columns,
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

fn bernstein(_context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut worst) = (Vec::new(), 0.0_f64);
    for name in ["harmonic-oscillator", "pendulum"] {
        let system = problem(name, &[])?;
        for m in 2..=5 {
            for tau in [0.1, 0.5, 1.0, 2.0] {
                let lagrange = one_state(&*system, &format!("path-fitted({m})"), tau)?;
                let bernstein = one_state(&*system, &format!("path-fitted-bernstein({m})"), tau)?;
                let off = crate::measure::norm::distance(&lagrange, &bernstein);
                worst = larger(worst, off);
                let size = crate::measure::norm::max_norm(&lagrange);
                cases.push(Case::below(format!("difference, {name}, degree {m}, τ = {tau}"), off, rounding(tau, size)));
            }
        }
    }
    let evidence = format!("The two differ by {} at most, on the pendulum too.", text(worst));
    Ok(Finding::on(cases, evidence).because(
        "Both bases span the polynomials of degree m, and the conditions on the path do not mention a basis: it is one \
         method in two coordinates for every Lagrangian, (21) and (22) included.",
    ))
}

/// Rows of the golden `path-fitted-orders`: orders and errors by degree, on the pendulum.
pub(crate) fn orders_golden(context: &Context) -> Result<Vec<Row>, StudyError> {
    let table = crate::claim::table(context, "claims-path-fitted-orders")?;
    let values = ["order_equispaced", "error_equispaced", "order_gauss", "error_gauss"];
    Ok(rows(&table, &["degree"], &values, |entry| {
        let degree = entry.number("degree").unwrap_or(f64::NAN);
        let order = match entry.column {
            "order_equispaced" => 2.0 * (degree / 2.0).floor(),
            "order_gauss" => 2.0 * (degree - 1.0),
            // Forty steps at most, each with roundings of numbers up to 2 that differentiation magnifies m² times.
            _ => {
                let rounding = 40.0 * degree * degree * 2.0 * f64::EPSILON;
                return (Tolerance::absolute(rounding, "roundings of the steps"), None);
            }
        };
        let truth = Truth { value: order, allowance: 0.3, source: "theory, between two steps".into() };
        (Tolerance::absolute(0.01, "roundoff moves the finer error by a hundredth at most"), Some(truth))
    }))
}
