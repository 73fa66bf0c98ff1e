//! Holonomic constraints: the working form of every discretisation, and the scheme (23), its square roots supplied.

use super::{Context, Study, StudyError, prose};
use crate::evidence::{Axis, Check, Evidence, Figure, Mark, Panel, Series, Table, number};
use crate::experiment::constraint::{Held, Kept, Radius};
use crate::row;

pub(super) const STUDY: Study = Study {
    id: "constraints",
    title: "Holonomic constraints",
    question: "Which discretisations hold a constraint, its derivative and the angular momentum together, and what does (23) do?",
    source: "[KY21] (4), (5), (23)",
    run,
};

/// Step sizes of (23).
pub(crate) const TAUS: [f64; 5] = [0.2, 0.1, 0.05, 0.02, 0.01];

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let kept = context.get_each(Held::all()?)?;
    let growth = number::short(Radius::growth());
    let mut evidence = Evidence {
        checks: kept.iter().flat_map(|kept| checks(kept)).collect(),
        notes: prose::fill(include_str!("constraints.md"), &[("growth", growth)])?,
        ..Evidence::default()
    };
    let rows = kept.iter().map(|k| row![k.problem, &k.method, k.position, k.hidden, k.momentum, k.energy]);
    evidence.tables.push(Table::new(
        "constraints",
        format!(
            "Largest ||q|² − 1|, |q · p|, change of the angular momentum and of the energy up to t = {} with h = {}, working form.",
            Held::HORIZON,
            Held::H
        ),
        ["problem", "method", "position", "hidden", "momentum", "energy"],
        rows.collect(),
    ));
    as_printed(&mut evidence, context)?;
    Ok(evidence)
}

fn checks(kept: &Kept) -> [Check; 3] {
    let Kept { problem, method, momentum, rounding, .. } = kept;
    let on = format!("{problem}/{method}");
    let held = |what: &str, formula: &str, value: f64, reason: &str| {
        let statement = format!("{method} holds {formula} on {problem}");
        Check::at_most(format!("{what}/{on}"), statement, value, Held::PLACE, reason)
    };
    let id = format!("momentum/{on}");
    [
        held("position", "|q| = 1", kept.position, "64 roundings of q"),
        held("hidden", "q · p = 0", kept.hidden, "64 roundings of p"),
        if kept.is_symplectic {
            let statement = format!("{method} keeps the angular momentum on {problem}");
            let reason = "independent roundings of the momentum, four deviations of their sum";
            Check::at_most(id, statement, *momentum, *rounding, reason)
        } else {
            let statement = format!("{method} does not keep the angular momentum on {problem}");
            Check::at_least(id, statement, *momentum, 10.0 * rounding, "ten times its rounding")
        },
    ]
}

/// (23) with its square roots: its radial error at each step.
fn as_printed(evidence: &mut Evidence, context: &Context) -> Result<(), StudyError> {
    let growth = Radius::growth();
    let (mut rows, mut summary, mut series) = (Vec::new(), Vec::new(), Vec::new());
    for tau in TAUS {
        let found = context.get(Radius { tau })?;
        evidence.checks.push(Check::at_most(
            format!("first-error/tau-{tau}"),
            format!("The first radial error of (23) is −τ⁴/32, τ = {tau}"),
            (found.first - 1.0).abs(),
            tau * tau + 8.0 * f64::EPSILON / tau.powi(4) * 32.0,
            "relative deviation: the next term of a series in τ², and roundings of |q|",
        ));
        if tau <= 0.02 {
            evidence.checks.push(Check::at_most(
                format!("growth/tau-{tau}"),
                format!("A radial error of (23) is multiplied by −(3 + 2√2) per step, τ = {tau}"),
                (found.ratio / growth - 1.0).abs(),
                0.01,
                "relative deviation; it is of the order of τ² and of the error itself, here below a hundredth, plus what feeds the first \
                 of some eight steps",
            ));
        }
        evidence.checks.push(Check::at_most(
            format!("visible/tau-{tau}"),
            format!("|q| under (23) is off by more than a hundredth within 20 steps, τ = {tau}"),
            found.visible.map_or(f64::INFINITY, |step| step as f64),
            20.0,
            "the number of steps in which a rounding would grow to a hundredth at that rate is 18",
        ));
        let visible = found.visible.map(|step| step as f64);
        summary.push(row![tau, found.first, found.ratio, growth, visible]);
        rows.extend(found.errors.iter().enumerate().map(|(step, error)| row![tau, step, *error]));
        let sizes = found.errors.iter().enumerate().skip(1).map(|(step, error)| (step as f64, error.abs()));
        series.push(Series::new(format!("τ = {tau}"), sizes.collect(), Mark::LineMarkers));
    }
    let guide = (1..=12).map(|k| (f64::from(k), 1e-9 * growth.abs().powi(k))).collect();
    series.push(Series::new("3 + 2√2 a step", guide, Mark::Guide));
    evidence.tables.push(Table::new(
        "circle-growth",
        "The scheme (23), its square roots supplied: the radial error after the first step in units of −τ⁴/32; its factor per step, of the last \
         two steps from the third on that leave |q| off by less than a hundredth; the limit of this factor for small angles; and the step at \
         which |q| is off by a hundredth.",
        ["tau", "first", "ratio", "predicted", "visible_at"],
        summary,
    ));
    evidence.tables.push(Table::data("circle-radius", "|q| − 1 under (23).", ["tau", "step", "error"], rows));
    let caption = "Distance from the circle under (23), its square roots supplied. For small steps the factor of a step tends to 3 + 2√2.";
    let panel = Panel::new(Axis::linear("step"), Axis::log("||q| − 1|"), series);
    evidence.figures.push(Figure::new("circle-radius", caption, "circle-radius", [panel]));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;

    #[test]
    fn momentum_is_kept_to_its_rounding_and_its_loss_is_ten_times_that() {
        let outcome = |is_symplectic, momentum| {
            let (problem, method) = ("circle", "method".into());
            let [position, hidden, energy, rounding] = [0.0, 0.0, 0.0, 1e-12];
            checks(&Kept { problem, method, position, hidden, momentum, energy, is_symplectic, rounding })[2].outcome
        };
        let (pass, fail) = (Outcome::Pass, Outcome::Fail);
        assert_eq!([0.9e-12, 1.1e-12, f64::NAN].map(|change| outcome(true, change)), [pass, fail, fail]);
        assert_eq!([1.1e-11, 0.9e-11, 0.0, f64::NAN].map(|change| outcome(false, change)), [pass, fail, fail, fail]);
    }
}
