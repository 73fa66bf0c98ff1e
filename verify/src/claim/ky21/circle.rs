//! Motion on a circle: the scheme as printed, and the form that works.

use crate::claim::measure::{self, distance_from_exact, problem, text, trajectory};
use crate::claim::{Case, Claim, Finding, Quantifier};
use crate::evidence::{Axis, Figure, Mark, Panel, Series};
use crate::measure::norm::{Extremes, larger};

use crate::experiment::{Context, StudyError};

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "KY21-h-1",
        source: "[KY21] (23)",
        statement: "The scheme (23) integrates uniform motion on a circle with second order.",
        quantifier: Quantifier::Universal,
        criterion: "From (1, 0) with unit speed |q| of the live scheme stays within 0.01 of 1 over 20 steps, for τ = 0.05, 0.1 \
                    and 0.2.",
        decide: as_printed,
    },
    Claim {
        id: "KY21-h-2",
        source: "[KY21] (4), (5), Section 4",
        statement: "The construction extends to holonomic constraints.",
        quantifier: Quantifier::Universal,
        criterion: "With a multiplier at each node, the end of the step among them, degree 2 keeps the constraint and its \
                    time derivative at rounding on the circle and the spherical pendulum, and the angular momentum; on the circle \
                    its order is 2 to within 0.1.",
        decide: with_nodal_multipliers,
    },
];

/// |q| − 1 after each step of (23).
fn radii(tau: f64, steps: u32) -> Result<Vec<f64>, StudyError> {
    let circle = problem("circle", &[])?;
    let states = trajectory(&*circle, "kong-yang-circle", tau, tau * f64::from(steps))?;
    Ok(states.iter().map(|(_, y)| y[0].hypot(y[1]) - 1.0).collect())
}

fn as_printed(_context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut series, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    for tau in [0.05, 0.1, 0.2] {
        let deviations = radii(tau, 20)?;
        let worst = if deviations.len() == 21 { deviations.iter().map(|x| x.abs()).largest() } else { f64::INFINITY };
        cases.push(Case::below(format!("largest ||q| − 1|, τ = {tau}"), worst, 0.01));
        let points: Vec<(f64, f64)> = deviations.iter().enumerate().skip(1).map(|(k, x)| (k as f64, x.abs())).collect();
        rows.extend(points.iter().map(|(k, x)| (vec![], vec![tau, *k, *x])));
        series.push(Series { label: format!("τ = {tau}"), points, mark: Mark::LineMarkers });
    }
    // The growth once the perturbation outgrows what feeds it, while it is still small.
    let deviations = radii(0.01, 14)?;
    let growth = deviations.windows(2).filter(|pair| pair[1].abs() < 1e-3).map(|pair| pair[1] / pair[0]).next_back();
    let growth = growth.ok_or("the perturbation is never small")?;
    let predicted = -(3.0 + 8.0_f64.sqrt());
    let mut data = measure::table(
        "claims-circle",
        "Distance of |q| from 1 under the scheme (23).",
        &["tau", "step", "deviation"],
        rows,
    );
    data.shown = false;
    let figure = Figure {
        id: "claims-circle".into(),
        caption:
            "Distance of |q| from 1 under the scheme (23). It grows sixfold per step at every step size until it is of \
                  the size of the circle."
                .into(),
        data: "claims-circle".into(),
        panels: vec![Panel {
            x: Axis { label: "step".into(), log: false, limits: Some((0.0, 20.0)) },
            y: Axis { label: "||q| − 1|".into(), log: true, limits: None },
            series,
            ..Panel::default()
        }],
        columns: 1,
    };
    let evidence = format!(
        "|q| is off by {}, {} and {}; a small radial perturbation is multiplied by {} per step.",
        text(cases[0].measured),
        text(cases[1].measured),
        text(cases[2].measured),
        text(growth)
    );
    Ok(Finding::on(cases, evidence)
        .holds_where("Nowhere; see KY21-h-2 for what does work.")
        .because(format!(
            "The constraint holds at the interior node only, and nothing holds qₖ₊₁ on the circle: the radial mode of \
             the recurrence has the multiplier −(3 + 2√2) = {} in the limit of small steps, and uniform motion, which \
             satisfies (23) up to τ⁴/16 only, excites it. As printed, (23) also lacks the square roots in its denominators.",
            text(predicted)
        ))
        .with_figure(figure, data))
}

fn with_nodal_multipliers(_context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, tau, horizon) = (Vec::new(), 0.1, 10.0);
    let mut sentences = Vec::new();
    for (name, n) in [("circle", 2), ("spherical-pendulum", 3)] {
        let system = problem(name, &[])?;
        let invariants = system.invariants();
        let momentum = invariants.iter().find(|i| i.name.contains("angular momentum")).ok_or("no angular momentum")?;
        let start = momentum.value(&system.initial());
        let (mut off, mut hidden, mut change) = (0.0_f64, 0.0_f64, 0.0_f64);
        let states = trajectory(&*system, "path-fitted(2)", tau, horizon)?;
        if states.last().is_none_or(|(t, _)| *t < horizon) {
            return Err(format!("the run on {name} broke off").into());
        }
        for (_, y) in &states {
            let (q, p) = y.split_at(n);
            off = larger(off, (q.iter().map(|x| x * x).sum::<f64>() - 1.0).abs());
            hidden = larger(hidden, q.iter().zip(p).map(|(q, p)| q * p).sum::<f64>().abs());
            change = larger(change, (momentum.value(y) - start).abs());
        }
        // A hundred steps of rounding, magnified by 4/τ in the momentum.
        let bound = 100.0 * 4.0 / tau * f64::EPSILON;
        cases.push(Case::below(format!("||q|² − 1|, {name}"), off, bound));
        cases.push(Case::below(format!("|q · p|, {name}"), hidden, bound));
        cases.push(Case::below(format!("change of the angular momentum, {name}"), change, bound));
        sentences.push(format!("{}, {} and {} on {name}", text(off), text(hidden), text(change)));
    }
    let circle = problem("circle", &[])?;
    let error = |tau| distance_from_exact(&*circle, "path-fitted(2)", tau, horizon, 2);
    let order = (error(0.1)? / error(0.05)?).log2();
    cases.push(Case::between("order on the circle", order, 1.9, 2.1));
    let evidence = format!(
        "Constraint, its derivative and angular momentum are kept to {}; the order is {}.",
        sentences.join(", "),
        text(order)
    );
    Ok(Finding::on(cases, evidence).because(
        "f(xₖ₊₁) = 0 with a multiplier at the node, pₖ⁻ − pₖ⁺ = Λₖ ∇f(xₖ), is the discrete Lagrange–d'Alembert \
         principle that (5) states; (23) drops it.",
    ))
}
