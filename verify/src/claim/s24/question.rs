//! What the paper leaves open: the best coefficients (α, β), and nonlinear conditions on the momenta.

use crate::claim::measure::text;
use crate::claim::{Case, Claim, Finding, Quantifier};
use crate::evidence::{Axis, Figure, Mark, Panel, Table};
use crate::experiment::best_theta::{BestTheta, Found};
use crate::experiment::homogeneous::{Line, Lines};
use crate::experiment::one_step::OneStep;
use crate::experiment::{Context, StudyError};
use crate::measure::norm::larger;
use crate::row;

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "S24-p-1",
        source: "[S24] Section 3, after Eq. (27)",
        statement: "Which coefficients (α, β) of the linear closure are the best?",
        quantifier: Quantifier::Open,
        criterion: "For step sizes up to 1, 3, 10 and 100 there is a constant θ = −α/β, inside [0, 1), whose largest one-step \
                    error on v̇ = −v is smaller than that of Methods I and II, and which the minimax closure attains to 1 %; and \
                    α/β as a function of h makes the error vanish to rounding.",
        decide: coefficients,
    },
    Claim {
        id: "S24-p-2",
        source: "[S24] Section 3, Eq. (28)",
        statement: "Does a nonlinear homogeneous condition F(pₙ, pₙ₊₁) = 0 do better?",
        quantifier: Quantifier::Open,
        criterion: "For a scalar unknown each of several homogeneous F of degrees 2 to 4 vanishes, to rounding, on a line \
                    α pₙ + β pₙ₊₁ = 0, the same at every scale of the momenta: it is a linear closure, or a choice between several.",
        decide: homogeneous,
    },
];

fn coefficients(context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut found, mut rows, mut data) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for range in [1.0, 3.0, 10.0, 100.0] {
        let Found { theta, best, method_i: one, method_ii: two, minimax: made, ref curve } =
            *context.get(BestTheta { range })?;
        cases.push(Case::between(format!("best θ, h ≤ {range}"), theta, 0.0, 1.0 - 1e-4));
        cases.push(Case::below(format!("largest error with it, h ≤ {range}, against Method I"), best, one));
        cases.push(Case::below(format!("largest error with it, h ≤ {range}, against Method II"), best, two));
        // The closure made for it, by another computation, on the steps sampled here.
        cases.push(Case::below(
            format!("largest error of the minimax closure over it, h ≤ {range}"),
            made / best,
            1.01,
        ));
        found.push((range, theta, best));
        rows.push(row![range, theta, best, one, two]);
        data.extend(curve.iter().map(|(theta, error)| row![format!("h ≤ {range}"), *theta, *error]));
    }
    let mut fitted = 0.0_f64;
    for h in [0.5, 1.0, 2.0, 5.0, 10.0] {
        let error = (OneStep::growth("fitted(1)", h).or_infinity(context)? - (-h).exp()).abs();
        fitted = larger(fitted, error);
        // A few roundings of θ and of the step.
        cases.push(Case::below(format!("error with θ(h), h = {h}"), error, 16.0 * f64::EPSILON));
    }
    let best = found.iter().map(|(range, theta, _)| format!("{} for h ≤ {range}", text(*theta))).collect::<Vec<_>>();
    let evidence = format!(
        "The best constant θ = −α/β is {}, with largest errors of {}; θ(h) leaves {}.",
        best.join(", "),
        found.iter().map(|(.., error)| text(*error)).collect::<Vec<_>>().join(", "),
        text(fitted)
    );
    let columns = ["h_up_to", "best_theta", "max_error", "method_i", "method_ii"];
    let table = Table::new(
        "claims-best-theta",
        "Best constant θ = −α/β by the largest one-step error on v̇ = −v over step sizes up to a bound; beside it the errors of \
         Method I (θ = 0) and Method II (θ = 1).",
        columns,
        rows,
    );
    let columns = ["steps", "theta", "max_error"];
    let behind = Table::data("claims-theta", "Largest one-step error on v̇ = −v.", columns, data);
    let caption = "Largest one-step error on v̇ = −v over step sizes up to a bound, against θ = −α/β. Method I is at the left \
                   edge, Method II at the right.";
    let curves = behind.curves("steps", "theta", "max_error", Mark::Line);
    let panel = Panel::new(Axis::linear("θ = −α/β").between(0.0, 1.0), Axis::log("largest error"), curves);
    let figure = Figure::new("claims-theta", caption, "claims-theta", [panel]);
    Ok(Finding::on(cases, evidence)
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

/// A ratio α/β that is no different from 0: the angle of a line, of at most π, is found to a few roundings.
const ZERO: f64 = 8.0 * f64::EPSILON;

fn homogeneous(context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut ratios) = (Vec::new(), Vec::new());
    for line in context.get(Lines)?.iter() {
        let Line { name, degree, ratio, ref sizes } = *line;
        for (scale, size) in sizes {
            let what = format!("|F| relative on the line of {name}, degree {degree}, scale {scale:e}");
            // A line that is off by an angle changes F of degree d by no more than d times that.
            cases.push(Case::below(what, *size, degree.max(1.0) * ZERO));
        }
        let ratio = if ratio.abs() <= ZERO { "0 to rounding".into() } else { text(ratio) };
        ratios.push(format!("{ratio} ({name})"));
    }
    let evidence = format!(
        "It does no better than the best linear closure for the step, for it is one: each F tried vanishes on one or more lines αpₙ + βpₙ₊₁ = 0. \
         A search from α/β = 0.9 finds, of each, the line with α/β = {}.",
        ratios.join(", ")
    );
    Ok(Finding::on(cases, evidence)
        .holds_where("For a scalar unknown. For systems F would have to be a vector of conditions, which Eq. (28) is not.")
        .because(
            "Homogeneity makes the zero set a union of lines through the origin, or the origin alone: F selects pairs (α, β), and \
             where there are several a rule has to choose between them. At a given step it cannot do better than the best (α, β) \
             for that step.",
        ))
}
