//! What the paper leaves open: the best coefficients (α, β), and nonlinear conditions on the momenta.

use std::f64::consts::PI;

use lsvi::closure::{Linear, LinearClosure};

use crate::chapter::StudyError;
use crate::claim::measure::{self, growth, text};
use crate::claim::{Case, Claim, Finding};
use crate::evidence::{Axis, Figure, Mark, Panel, Series};
use crate::measure::norm::{Extremes, larger};
use crate::measure::search::try_minimum;

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "S24-p-1",
        source: "[S24] Section 3, after Eq. (27)",
        statement: "Which coefficients (α, β) of the linear closure are the best?",
        criterion: "For step sizes up to 1, 3, 10 and 100 there is a constant θ = −α/β, inside [0, 1), whose largest one-step \
                    error on v̇ = −v is smaller than that of Methods I and II, and which the minimax closure attains to 1 %; and \
                    α/β as a function of h makes the error vanish to rounding.",
        decide: coefficients,
    },
    Claim {
        id: "S24-p-2",
        source: "[S24] Section 3, Eq. (28)",
        statement: "Does a nonlinear homogeneous condition F(pₙ, pₙ₊₁) = 0 do better?",
        criterion: "For a scalar unknown each of several homogeneous F of degrees 2 to 4 has, to rounding, the same line as \
                    zero set, α pₙ + β pₙ₊₁ = 0, at every scale of the momenta: it is a linear closure.",
        decide: homogeneous,
    },
];

/// Largest one-step error on v̇ = −v over step sizes up to `range`, of a method.
fn worst_of(method: &str, range: f64) -> Result<f64, StudyError> {
    // Down to 10⁻³ of the range, below which all errors are small.
    (0..=60).try_fold(0.0_f64, |worst, i| {
        let h = range * 10_f64.powf(-f64::from(i) / 20.0);
        Ok(larger(worst, (growth(method, h)? - (-h).exp()).abs()))
    })
}

/// The same for α = −θ, β = 1.
fn worst(theta: f64, range: f64) -> Result<f64, StudyError> {
    worst_of(&format!("linear({:?},1.0)", -theta), range)
}

fn coefficients() -> Result<Finding, StudyError> {
    let (mut cases, mut rows) = (Vec::new(), Vec::new());
    let (mut curves, mut data) = (Vec::new(), Vec::new());
    for range in [1.0, 3.0, 10.0, 100.0] {
        let theta = try_minimum([0.0, 1.0], 1e-5, |theta| worst(theta, range))?;
        let (best, one, two) = (worst(theta, range)?, worst(0.0, range)?, worst(1.0, range)?);
        cases.push(Case::between(format!("best θ, h ≤ {range}"), theta, 0.0, 1.0 - 1e-4));
        cases.push(Case::below(format!("largest error with it, h ≤ {range}, against Method I"), best, one));
        cases.push(Case::below(format!("largest error with it, h ≤ {range}, against Method II"), best, two));
        // The closure made for it, by another computation, on the steps sampled here.
        let made = worst_of(&format!("minimax(0,{range})"), range)?;
        cases.push(Case::below(
            format!("largest error of the minimax closure over it, h ≤ {range}"),
            made / best,
            1.01,
        ));
        rows.push((vec![], vec![range, theta, best, one, two]));
        let points = (0..=25).map(|i| 0.04 * f64::from(i)).map(|theta| Ok((theta, worst(theta, range)?)));
        let points = points.collect::<Result<Vec<_>, StudyError>>()?;
        data.extend(points.iter().map(|(theta, error)| (vec![], vec![range, *theta, *error])));
        curves.push(Series { label: format!("h ≤ {range}"), points, mark: Mark::Line });
    }
    let mut fitted = 0.0_f64;
    for h in [0.5, 1.0, 2.0, 5.0, 10.0] {
        let error = (growth("fitted(1)", h)? - (-h).exp()).abs();
        fitted = larger(fitted, error);
        // A few roundings of θ and of the step.
        cases.push(Case::below(format!("error with θ(h), h = {h}"), error, 16.0 * f64::EPSILON));
    }
    let best: Vec<String> = rows.iter().map(|(_, row)| format!("{} for h ≤ {}", text(row[1]), row[0])).collect();
    let evidence = format!(
        "The best constant θ = −α/β is {}, with largest errors of {}; θ(h) leaves {}.",
        best.join(", "),
        rows.iter().map(|(_, row)| text(row[2])).collect::<Vec<_>>().join(", "),
        text(fitted)
    );
    let columns = ["h_up_to", "best_theta", "max_error", "method_i", "method_ii"];
    let table = measure::table(
        "claims-best-theta",
        "Best constant θ = −α/β by the largest one-step error on v̇ = −v over step sizes up to a bound; beside it the errors of \
         Method I (θ = 0) and Method II (θ = 1).",
        &columns,
        rows,
    );
    let mut behind =
        measure::table("claims-theta", "Largest one-step error on v̇ = −v.", &["h_up_to", "theta", "max_error"], data);
    behind.shown = false;
    let figure = Figure {
        id: "claims-theta".into(),
        caption:
            "Largest one-step error on v̇ = −v over step sizes up to a bound, against θ = −α/β. Method I is at the left \
                  edge, Method II at the right."
                .into(),
        data: "claims-theta".into(),
        panels: vec![Panel {
            x: Axis { label: "θ = −α/β".into(), log: false, limits: Some((0.0, 1.0)) },
            y: Axis { label: "largest error".into(), log: true, limits: None },
            series: curves,
            ..Panel::default()
        }],
        columns: 1,
    };
    Ok(Finding::answer(cases, evidence)
        .holds_where(
            "The answer is for decay at one known rate, v̇ = −λv with h standing for hλ. On nonlinear problems every \
             member stays of second order.",
        )
        .because(
            "For constant α + β ≠ 0 all members have the same leading local error h³/6, so that for small h only θ → 1 \
             helps, which gives up damping: R(∞) = −θ. With θ(h) = 1 − h/2 + h²/8 − … the growth factor is exp(−h) itself.",
        )
        .with_table(table)
        .with_figure(figure, behind))
}

fn homogeneous() -> Result<Finding, StudyError> {
    type Condition = fn(f64, f64) -> f64;
    let conditions: [(&str, Condition); 4] = [
        ("pₙ pₙ₊₁ + pₙ₊₁²", |a, b| a * b + b * b),
        ("pₙ³ + pₙ₊₁³", |a, b| a.powi(3) + b.powi(3)),
        ("pₙ₊₁³ − ½ pₙ² pₙ₊₁ + pₙ³", |a, b| b.powi(3) - 0.5 * a * a * b + a.powi(3)),
        ("pₙ₊₁⁴ − 2 pₙ pₙ₊₁³", |a, b| b.powi(4) - 2.0 * a * b.powi(3)),
    ];
    let (mut cases, mut ratios) = (Vec::new(), Vec::new());
    for (name, f) in conditions {
        let line = Linear::from_homogeneous(f, (0.9, 1.0))?.weights(1.0);
        let degree = (f(2.0, 0.6) / f(1.0, 0.3)).log2();
        for scale in [1e-3, 1.0, 1e3] {
            // A point of the line, and F there relative to its largest value at the same distance from the origin.
            let (a, b) = (scale * line.beta, -scale * line.alpha);
            let around = (0..16).map(|i| (0.125 * PI * f64::from(i)).sin_cos());
            let size = around.map(|(x, y)| f(a.hypot(b) * x, a.hypot(b) * y).abs()).largest();
            let what = format!("|F| relative on the line of {name}, degree {degree}, scale {scale:e}");
            cases.push(Case::below(what, f(a, b).abs() / size, 1e-14));
        }
        ratios.push(format!("{} ({name})", text(line.alpha / line.beta)));
    }
    let evidence = format!("The lines nearest to α/β = 0.9 have α/β = {}.", ratios.join(", "));
    Ok(Finding::answer(cases, evidence)
        .holds_where("For a scalar unknown. For systems F would have to be a vector of conditions, which Eq. (28) is not.")
        .because(
            "Homogeneity makes the zero set a union of lines through the origin: F selects one or more pairs (α, β), and a \
             rule is needed to choose between them. It cannot do better than the best linear closure.",
        ))
}
