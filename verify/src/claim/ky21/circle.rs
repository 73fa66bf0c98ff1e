//! Motion on a circle: the scheme (23), and the form that works.

use crate::claim::measure::{at_most, text};
use crate::claim::{Case, Claim, Finding, Quantifier};
use crate::evidence::{Axis, Cell, Figure, Mark, Panel, Series, Table};
use crate::experiment::constraint::{Held, Radius};
use crate::experiment::motion::{LargestError, Motion};
use crate::experiment::{Context, StudyError};
use crate::measure::norm::Extremes;
use crate::row;

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "KY21-h-1",
        source: "[KY21] (23)",
        statement: "The scheme (23) integrates uniform motion on a circle with second order.",
        quantifier: Quantifier::Universal,
        criterion: "From (1, 0) with unit speed |q| of the live scheme stays within 0.01 of 1 over 20 steps, for τ = 0.05, 0.1 \
                    and 0.2. In the text that this was written from (23) has |qₖ + qₖ₊₁|² in its denominators, which uniform motion does not meet; the square roots are supplied.",
        decide: as_printed,
    },
    Claim {
        id: "KY21-h-2",
        source: "[KY21] (4), (5), Section 4",
        statement: "The construction extends to holonomic constraints.",
        quantifier: Quantifier::General,
        criterion: "As in (5), with a multiplier at each node, the end of the step among them, degree 2 keeps the constraint and its \
                    time derivative at rounding on the circle and the spherical pendulum, and the angular momentum; on the circle \
                    its order is 2 to within 0.1. (23), with the square roots of KY21-h-1, keeps the circle (its bound).",
        decide: with_nodal_multipliers,
    },
];

/// Steps over which the circle should be kept.
const STEPS: usize = 20;

/// How the scheme (23) leaves the circle at a step size.
struct Departure {
    tau: f64,
    /// ||q| − 1| by step, up to the first that is far off.
    errors: Vec<f64>,
    /// The largest within the steps, of which it is said that it stays small.
    case: Case,
}

/// At each of three sizes, and after how many steps it is how far off.
fn departures(context: &Context) -> Result<(Vec<Departure>, String), StudyError> {
    let (mut found, mut left) = (Vec::new(), Vec::new());
    for tau in [0.05, 0.1, 0.2] {
        let radii = context.get(Radius { tau })?;
        let errors = radii.errors.iter().take(STEPS + 1).map(|error| error.abs()).collect::<Vec<_>>();
        let what = format!("largest ||q| − 1| under (23) until it exceeds {}, τ = {tau}", Radius::FAR);
        let case = Case::below(what, errors.iter().copied().largest(), Radius::VISIBLE);
        left.push(radii.far.filter(|step| *step <= STEPS).ok_or("(23) stays near the circle")?.to_string());
        found.push(Departure { tau, errors, case });
    }
    Ok((found, format!("off by more than {} after {} steps (τ = 0.05, 0.1, 0.2)", Radius::FAR, left.join(", "))))
}

fn as_printed(context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut series, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    let (departures, left) = departures(context)?;
    for Departure { tau, errors, case } in departures {
        let sizes = || errors.iter().enumerate().skip(1);
        rows.extend(sizes().map(|(step, error)| row![tau, step, *error]));
        let points = sizes().map(|(step, error)| (step as f64, *error)).collect();
        series.push(Series::new(format!("τ = {tau}"), points, Mark::LineMarkers));
        cases.push(case);
    }
    let longest = rows.iter().filter_map(|row: &Vec<Cell>| row[1].number()).largest();
    let growth = context.get(Radius { tau: 0.01 })?.ratio;
    let caption = "Distance of |q| from 1 under the scheme (23), as far as it is not far from the circle.";
    let data = Table::data("claims-circle", caption, ["tau", "step", "deviation"], rows);
    let caption = "Distance of |q| from 1 under the scheme (23), which keeps |q| = 1 if it is right. From the first step to the second the \
                   distance grows fourfold, and from then on about sixfold a step while it is small, whatever τ is; a smaller τ only delays it. A \
                   curve ends where the run does.";
    let panel = Panel::new(Axis::linear("step").between(0.0, longest), Axis::log("||q| − 1|"), series);
    let figure = Figure::new("claims-circle", caption, "claims-circle", [panel]);
    let evidence = format!(
        "|q| is {left}, where the runs end. A small radial perturbation is multiplied by {} in a step, at τ = 0.01.",
        text(growth)
    );
    Ok(Finding::on(cases, evidence)
        .holds_where(
            "For consistency alone: uniform motion satisfies (23) to fourth order in τ, as a scheme of second order asks. The scheme does not \
             converge; the one of KY21-h-2 does.",
        )
        .because(format!(
            "The constraint holds at the interior node only, and nothing holds qₖ₊₁ on the circle. The radial mode of \
             the recurrence has the multiplier −(3 + 2√2) = {} in the limit of small steps. Uniform motion satisfies (23) up to a defect \
             of τ⁴/16, and this defect excites the mode.",
            text(Radius::growth())
        ))
        .with_figure(figure, data))
}

fn with_nodal_multipliers(context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut sentences) = (Vec::new(), Vec::new());
    let method = "path-fitted(2)";
    for problem in Held::PROBLEMS {
        let kept = context.get(Held { problem, method: method.into() })?;
        cases.extend([
            Case::at_most(format!("||q|² − 1|, {problem}"), kept.position, Held::PLACE).under(true),
            Case::at_most(format!("|q · p|, {problem}"), kept.hidden, Held::PLACE).under(true),
            Case::at_most(format!("change of the angular momentum, {problem}"), kept.momentum, kept.rounding)
                .under(true),
        ]);
        let [position, hidden, momentum] = [kept.position, kept.hidden, kept.momentum].map(at_most);
        sentences.push(format!("{position}, {hidden} and {momentum} on {problem}"));
    }
    let error = |h| context.get(LargestError(Motion { problem: "circle", method: method.into(), h, t_end: 10.0 }));
    let order = (*error(0.1)? / *error(0.05)?).log2();
    cases.push(Case::between("order on the circle", order, 1.9, 2.1).under(true));
    let (printed, left) = departures(context)?;
    let evidence = format!(
        "As the paper writes it out for a circle, (23), |q| is {left}. Repaired, with a multiplier at the end of the step \
         too, which (5) states and (23) drops, constraint, its derivative and angular momentum are kept to {}; the order is {}.",
        sentences.join(", "),
        text(order)
    );
    cases.extend(printed.into_iter().map(|departure| departure.case));
    let finding = Finding::on(cases, evidence).holds_where(
        "With the multiplier at the end of the step that (5) states. Not in the scheme (23), which is printed for it.",
    );
    Ok(finding.because(
        "f(xₖ₊₁) = 0 with a multiplier at the node, pₖ⁻ − pₖ⁺ = Λₖ ∇f(xₖ), is the discrete Lagrange–d'Alembert \
         principle that (5) states; (23) drops it.",
    ))
}
