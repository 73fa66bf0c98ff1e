//! Start-up Poiseuille flow with one shape function.

use crate::chapter::StudyError;
use crate::claim::measure::{self, max_error, one_step, problem, text, threshold};
use crate::claim::{Case, Claim, Finding};
use crate::evidence::{Axis, Figure, Mark, Panel, Series};
use crate::measure::norm::Extremes;
use crate::measure::richardson::Richardson;
use crate::measure::search::minimum;
use crate::problem::poiseuille_series;

use super::{BOTH, YARDSTICKS};

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "S24-i",
        source: "[S24] Section 5, Eqs. (38), (39)",
        statement: "As h → ∞ one step of Method I gives the steady velocity γ/2 of the channel, whatever the start.",
        criterion: "|v₁ − γ/2| of one live step of h = 10⁴ is below 10⁻⁷ for γ = 2 and v₀ from −1 to 10, and for γ = 0.5.",
        decide: steady_limit,
    },
    Claim {
        id: "S24-j",
        source: "[S24] Section 5, Figures 6 and 7",
        statement: "On Poiseuille flow Method I has smaller errors than Method II, implicit Euler and RK4, even at very small h.",
        criterion: "Its largest error on (0, 2] is smaller than that of the three as the paper runs them, on the \
                    domain-averaged equation, and than that of implicit Euler and RK4 on the Galerkin equation, the \
                    one to which Method I itself converges; h from 0.5 to 0.0001.",
        decide: against_all,
    },
    Claim {
        id: "S24-k",
        source: "[S24] Section 5, Figure 7",
        statement: "For h ≲ 0.01 the largest error of Method I on Poiseuille flow is about a quarter of that of the other three.",
        criterion: "One over the ratio of the largest errors on (0, 2], the three run as in the paper, rounds to 4 for \
                    h = 0.01, 0.001 and 0.0001.",
        decide: a_quarter,
    },
    Claim {
        id: "S24-l-1",
        source: "[S24] Section 5, Figure 7",
        statement: "On Poiseuille flow the errors do not converge to zero as h → 0, because the shape function is approximate.",
        criterion: "The limit of Method I's largest error, by Richardson extrapolation, is above zero by more than its grid \
                    convergence index, and is the distance of the Galerkin equation's solution from the flow to within it.",
        decide: floor,
    },
    Claim {
        id: "S24-l-2",
        source: "[S24] Section 5, caption of Figure 7",
        statement: "The numerical solution comes as close to the exact one as the shape function allows.",
        criterion: "The limits of the largest errors of Methods I and II are within 1 % of the smallest that a relaxation \
                    v̇ = μ(γ/2 − v) of the same shape function reaches at any rate μ.",
        decide: as_close_as_possible,
    },
];

const GAMMA: f64 = 2.0;
const STEPS: [f64; 5] = [0.5, 0.1, 0.01, 0.001, 1e-4];
const SECOND_ORDER: &str = "trapezoidal";

/// The velocity u(0, t) for γ = 2.
fn centre(t: f64) -> f64 {
    poiseuille_series::velocity(GAMMA, 0.0, t).unwrap_or(f64::NAN)
}

/// The largest error is an early one: later than t = 2 all have decayed (claim S24-f-2).
fn error(method: &str, reduction: &str, h: f64) -> Result<f64, StudyError> {
    max_error(&*problem("poiseuille-ansatz", &[("reduction", reduction)])?, method, h, 2.0, centre)
}

fn steady_limit() -> Result<Finding, StudyError> {
    let (mut cases, h) = (Vec::new(), 1e4);
    for (gamma, steady) in [("2", 1.0), ("0.5", 0.25)] {
        for v0 in ["-1", "0", "0.5", "10"] {
            let flow = problem("poiseuille-ansatz", &[("gamma", gamma), ("v0", v0)])?;
            let v = one_step(&*flow, BOTH[0], h)?.unwrap_or(f64::INFINITY);
            cases.push(Case::below(format!("|v₁ − γ/2|, γ = {gamma}, v₀ = {v0}"), (v - steady).abs(), 1e-7));
        }
    }
    let worst = cases.iter().map(|case| case.measured).largest();
    let evidence = format!("One step of h = 10⁴ comes within {} of γ/2 from every start.", text(worst));
    Ok(Finding::on(cases, evidence).because("The excess is divided by 1 + (5/2)h + (15/4)h², Eq. (38)."))
}

fn against_all() -> Result<Finding, StudyError> {
    let mut cases = Vec::new();
    let (mut rows, mut series) = (Vec::new(), Vec::new());
    let mut curve = |method: &str, reduction: &str, label: &str| -> Result<Vec<f64>, StudyError> {
        let errors = STEPS.iter().map(|h| error(method, reduction, *h)).collect::<Result<Vec<_>, _>>()?;
        rows.extend(STEPS.iter().zip(&errors).map(|(h, e)| (vec![method.into(), label.into()], vec![*h, *e])));
        let equation = if label == "own" { method.into() } else { format!("{method}, {label}") };
        let points = STEPS.iter().copied().zip(errors.iter().copied()).filter(|(_, e)| e.is_finite()).collect();
        series.push(Series { label: equation, points, mark: Mark::LineMarkers });
        Ok(errors)
    };
    let own = curve(BOTH[0], "galerkin", "own")?;
    let mut rivals = vec![(format!("{} as in the paper", BOTH[1]), curve(BOTH[1], "averaged", "own")?)];
    for method in YARDSTICKS {
        rivals.push((format!("{method}, averaged"), curve(method, "averaged", "averaged")?));
    }
    for method in YARDSTICKS {
        rivals.push((format!("{method}, Galerkin"), curve(method, "galerkin", "Galerkin")?));
    }
    curve(SECOND_ORDER, "averaged", "averaged")?;
    let second_order = curve(SECOND_ORDER, "galerkin", "Galerkin")?;
    for (rival, errors) in &rivals {
        for ((h, mine), theirs) in STEPS.iter().zip(&own).zip(errors) {
            cases.push(Case::below(format!("largest error, h = {h}, against {rival}"), *mine, *theirs));
        }
    }
    let at = |rival: usize, step: usize| text(rivals[rival].1[step]);
    let evidence = format!(
        "At h = 0.001 the largest errors are {} (Method I), {} (Method II), {} and {} (implicit Euler and RK4 on the averaged \
         equation), but {} and {} (the same two on the Galerkin equation).",
        text(own[3]),
        at(0, 3),
        at(1, 3),
        at(2, 3),
        at(3, 3),
        at(4, 3)
    );
    let mut data = measure::table(
        "claims-poiseuille",
        "Largest error on (0, 2] of the centre velocity, γ = 2, by integrator and reduced equation.",
        &["method", "equation", "h", "max_error"],
        rows,
    );
    data.shown = false;
    let figure = Figure {
        id: "claims-poiseuille".into(),
        caption:
            "Largest error on (0, 2] of the centre velocity. Every integrator ends on one of two levels, that of the \
                  equation it steps: the projection earns the advantage, not the time integrator."
                .into(),
        data: "claims-poiseuille".into(),
        panels: vec![Panel {
            x: Axis { label: "step size h".into(), log: true, limits: None },
            y: Axis { label: "largest error".into(), log: true, limits: None },
            series,
            ..Panel::default()
        }],
        columns: 1,
    };
    Ok(Finding::on(cases, evidence)
        .holds_where(
            "Against the other three on the averaged equation at every step. Not against the same integrators on the \
             Galerkin equation, v̇ = (5/4)(γ − 2v).",
        )
        .because(format!(
            "Methods I and II do not solve the same equation: p → 0 is the Galerkin projection of the flow, ṗ → 0 the \
             domain average, whose rate 3 is further from the true π²/4 than 5/2 is. On the Galerkin equation the \
             trapezoidal rule has the error {} at h = 0.001, and at h = 0.1 {} where Method I, of first order here, has {}.",
            text(second_order[3]),
            text(second_order[1]),
            text(own[1])
        ))
        .with_figure(figure, data))
}

fn a_quarter() -> Result<Finding, StudyError> {
    let mut cases = Vec::new();
    for h in [0.01, 0.001, 1e-4] {
        let own = error(BOTH[0], "averaged", h)?;
        for rival in [BOTH[1], YARDSTICKS[0], YARDSTICKS[1]] {
            let ratio = error(rival, "averaged", h)? / own;
            let what = format!("error of {rival} over that of method-i, h = {h}");
            cases.push(Case::between(what, ratio, 3.5, 4.5));
        }
    }
    let limit = distance(3.0) / distance(2.5);
    let start = |rival: &'static str| {
        threshold(rival, 0.001, 0.1, |h| Ok(error(rival, "averaged", h)? / error(BOTH[0], "averaged", h)? - 3.5))
    };
    let [implicit, explicit] = YARDSTICKS.map(start);
    let range = |pick: fn(f64, f64) -> f64, start| text(cases.iter().map(|case| case.measured).fold(start, pick));
    let evidence = format!(
        "The errors of the others are {} to {} times Method I's; as h → 0 all tend to {} times.",
        range(f64::min, f64::INFINITY),
        range(f64::max, 0.0),
        text(limit)
    );
    let finding = Finding::on(cases, evidence).holds_where(format!(
        "Against RK4 and Method II from h = {} down, against implicit Euler from h = {} down.",
        text(explicit?),
        text(implicit?)
    ));
    Ok(finding.because(
        "At these steps the errors are those of the two reduced equations. The quarter is the ratio of their distances from \
         the flow and says nothing of time integration.",
    ))
}

/// Largest distance of the relaxation ½γ(1 − e^{−μt}) from the centre velocity, over a grid of spacing 10⁻³ refined at its
/// maximum: the distance is smooth there, so that what is missed is of the order of the square of the last spacing.
fn distance(rate: f64) -> f64 {
    let at = |t: f64| (0.5 * GAMMA * (1.0 - (-rate * t).exp()) - centre(t)).abs();
    let best = (1..=2000).map(|i| 1e-3 * f64::from(i)).max_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap_or(1e-3);
    (-100..=100).map(|i| at(best + 1e-5 * f64::from(i))).largest()
}

fn floor() -> Result<Finding, StudyError> {
    let values = [0.001, 0.002, 0.004].map(|h| error(BOTH[0], "averaged", h));
    let [fine, medium, coarse] = values;
    let limit = Richardson::new([fine?, medium?, coarse?], 2.0)?;
    let galerkin = distance(2.5);
    let cases = vec![
        Case::above("limit of the largest error of Method I", limit.limit, limit.gci),
        Case::below(
            "its difference from the distance of the Galerkin solution",
            (limit.limit - galerkin).abs(),
            limit.gci,
        ),
    ];
    let evidence = format!(
        "Steps of 0.004, 0.002 and 0.001 extrapolate to {} ± {} with observed order {}; the Galerkin equation's solution is {} \
         from the flow.",
        text(limit.limit),
        text(limit.gci),
        text(limit.order),
        text(galerkin)
    );
    Ok(Finding::on(cases, evidence).because(
        "The Lagrangian (37) keeps a remainder that no v(t) removes; the limit is the error of the reduced equation.",
    ))
}

fn as_close_as_possible() -> Result<Finding, StudyError> {
    // Below the optimum the late error grows, above it the early one: the larger of the two has one minimum.
    let rate = minimum([1.5, 3.5], 1e-6, distance);
    let (best, galerkin, averaged) = (distance(rate), distance(2.5), distance(3.0));
    let cases = vec![
        Case::below("limit of Method I, the Galerkin equation, over the smallest", galerkin / best, 1.01),
        Case::below("limit of Method II, the averaged equation, over the smallest", averaged / best, 1.01),
    ];
    let evidence = format!(
        "The limits are {} (Method I) and {} (Method II); the rate μ = {} reaches {} with the same shape function.",
        text(galerkin),
        text(averaged),
        text(rate),
        text(best)
    );
    Ok(Finding::on(cases, evidence)
        .holds_where("The floor is that of the reduced equation: it is a property of the closure, not of the shape function.")
        .because(
            "With v(t) free, the shape function meets the centre velocity exactly. What the methods solve is one equation for \
             v or another, and the two of them already differ by a factor of four.",
        ))
}
