//! Large steps on the way to a steady cavity, and those that are too long for their grid.

use super::{Context, Scale, StudyError, prose, short, streamlines, times};
use crate::evidence::{Cell, Check, Evidence, Figure, Panel, Requirement, Table};
use crate::experiment::flow::approach::{Approach, Found};
use crate::experiment::flow::steady::{Refused, STEADY, Spurious};
use crate::row;

/// Steps from rest on a grid that is too coarse for them.
pub(super) fn too_long(h: f64) -> Spurious {
    Spurious { re: 1000.0, cells: 32, h }
}

/// Steps from rest to the steady cavity.
pub(super) fn from_rest(method: &'static str, cells: usize, h: f64) -> Approach {
    Approach { method, re: 100.0, cells, h }
}

/// Where the minimum of the action at a step too long for the grid is no steady flow.
pub(super) fn spurious(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    const OTHERS: [&str; 2] = ["implicit-euler", "tr-bdf2"];
    let Spurious { re, cells, .. } = too_long(0.0);
    let found = context.get_each(scale.spurious.iter().map(|h| too_long(*h)).collect())?;
    let by = |method| scale.spurious.iter().map(move |h| Approach { method, re, cells, h: *h });
    let others = context.get_each(OTHERS.into_iter().flat_map(by).collect())?;
    let cases = || scale.spurious.iter().zip(&found);
    let Some((h, worst)) = cases().next_back() else { return Ok(()) };
    let reach = others.iter().filter(|other| other.is_steady()).count();
    let reach = match others.len() - reach {
        0 => "all come to a steady flow".to_owned(),
        missed => format!("come to a steady flow in all but {missed} of their runs"),
    };
    let values = [
        ("others", reach),
        ("h", short(*h)),
        ("re", short(re)),
        ("cells", cells.to_string()),
        ("rest", short(worst.residual)),
        ("gradient", worst.gradient.map_or("an unknown number of".into(), short)),
    ];
    evidence.notes.extend(prose::fill(include_str!("spurious.md"), &values)?);
    evidence.checks.push(refused(&too_long(*h), worst));
    let outcome = |message: &str| if message.is_empty() { "steady".to_owned() } else { format!("refused: {message}") };
    let own = cases().map(|(h, found)| row!["method-i", *h, found.residual, found.gradient, outcome(&found.message)]);
    let each = OTHERS.into_iter().flat_map(|method| scale.spurious.iter().map(move |h| (method, *h)));
    let others = each
        .zip(&others)
        .map(|((method, h), found)| row![method, h, Cell::found(found.residual), Cell::Empty, ended(found)]);
    let rows = own.chain(others).collect();
    let caption = format!(
        "From rest at Re = {re} on {cells} cells a side, by step size: |f| in units of M ψ̇ where the iteration of Method I ends, or where \
         another method has it below {:e}; where that iteration stalls, the gradient of the action over that at rest; and the outcome.",
        Approach::STEADY
    );
    let id = "flow-spurious";
    evidence.tables.push(Table::new(id, caption, ["method", "h", "residual", "gradient", "outcome"], rows));
    let steady = cases().find(|(_, found)| found.message.is_empty()).map(|(h, found)| (h, found, "steady"));
    let shown = steady.into_iter().chain([(h, worst, "refused")]);
    let panels: Vec<Panel> = shown
        .filter_map(|(h, found, what)| Some(streamlines(&format!("h = {h}, {what}"), cells, found.psi.as_ref()?)))
        .collect();
    let caption =
        "Streamlines where Method I comes to rest from rest with long steps: those that are refused are no flow.";
    evidence.figures.push(Figure::new(id, caption, id, panels).in_columns(2));
    Ok(())
}

/// That the library refuses where the iteration ends, and that the flow is not steady there.
fn refused(Spurious { re, cells, h }: &Spurious, found: &Refused) -> Check {
    Check::new(
        "steady/spurious",
        format!(
            "Re = {re} on {cells}² cells with h = {h}: where the iteration of Method I ends the flow is not steady, and the library refuses \
             it; |f| there"
        ),
        if found.message.is_empty() { f64::NAN } else { found.residual },
        Requirement::AtLeast(1e6 * STEADY),
        "a million times what counts as steady; (2M − h Jᵀ) M⁻¹f = 0 can have roots with f ≠ 0 where hM⁻¹J has the eigenvalue 2",
    )
}

/// How steps to a steady cavity end.
fn ended(found: &Found) -> String {
    match &found.error {
        Some(error) => error.clone(),
        None if found.is_steady() => "steady".to_owned(),
        None => "still moving".to_owned(),
    }
}

/// Steps of several methods from rest to the steady cavity.
pub(super) fn study(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    const METHODS: [&str; 5] = ["method-i", "trapezoidal", "tr-bdf2", "bdf2", "implicit-euler"];
    const STEPS: [f64; 3] = [1.0, 10.0, 100.0];
    let mut cases = Vec::new();
    for method in METHODS {
        cases.extend(STEPS.map(|h| (method, h)));
    }
    let cells = scale.approach;
    let Approach { re, .. } = from_rest("", cells, 0.0);
    let settings = cases.iter().map(|(method, h)| from_rest(method, cells, *h));
    let found = context.get_each(settings.collect())?;
    let rows = cases.iter().zip(&found).map(|((method, h), found)| {
        let [least, most] = [found.seconds.least, found.seconds.most];
        row![*method, *h, found.steps, found.solves, least, most, Cell::found(found.residual), ended(found)]
    });
    let rows = rows.collect();
    let of =
        |method: &str, h: f64| cases.iter().zip(&found).find(|(case, _)| **case == (method, h)).map(|(_, found)| found);
    let count = |method: &str, h: f64| match of(method, h) {
        Some(found) if found.is_steady() => format!("takes {} steps and {} linear systems", found.steps, found.solves),
        Some(found) if found.error.is_some() => "fails in a step".to_owned(),
        _ => format!("does not get there in {} steps", Approach::MOST),
    };
    let [_, ten, hundred] = STEPS;
    let solves = |method: &str, h: f64| of(method, h).filter(|found| found.is_steady()).map(|found| found.solves);
    let pays = |other: &str| {
        [ten, hundred].iter().all(|h| match (solves("method-i", *h), solves(other, *h)) {
            (Some(own), Some(other)) => own < other,
            (own, _) => own.is_some(),
        })
    };
    let verdict = |other| if pays(other) { "pay" } else { "do not pay" };
    // A run that is given up has taken what it was given.
    let seconds = |method: &str, h: f64| of(method, h).filter(|found| found.is_steady()).map(|found| found.seconds);
    let against = |other: &str| match (seconds("method-i", hundred), seconds(other, hundred)) {
        (Some(own), Some(other)) => format!("{} times", times(own, other)),
        _ => "an unknown part of".into(),
    };
    let values = [
        ("re", short(re)),
        ("cells", cells.to_string()),
        ("ten", short(ten)),
        ("hundred", short(hundred)),
        ("method_i_ten", count("method-i", ten)),
        ("rule_ten", count("trapezoidal", ten)),
        ("tr_bdf2_ten", count("tr-bdf2", ten)),
        ("euler_ten", count("implicit-euler", ten)),
        ("method_i_hundred", count("method-i", hundred)),
        ("tr_bdf2_hundred", count("tr-bdf2", hundred)),
        ("bdf2_ten", count("bdf2", ten)),
        ("bdf2_hundred", count("bdf2", hundred)),
        ("against_bdf2", verdict("bdf2").into()),
        ("euler_hundred", count("implicit-euler", hundred)),
        ("against_rule", verdict("trapezoidal").into()),
        ("against_tr_bdf2", verdict("tr-bdf2").into()),
        ("against_euler", verdict("implicit-euler").into()),
        ("cpu_tr_bdf2", against("tr-bdf2")),
        ("cpu_bdf2", against("bdf2")),
        ("cpu_euler", against("implicit-euler")),
    ];
    evidence.notes.extend(prose::fill(include_str!("approach.md"), &values)?);
    let caption = format!(
        "Cavity of {cells} cells a side, Re = {re}, from rest until |f| ≤ {:e} in units of M ψ̇: steps, up to {} of them; `solves`, the linear systems, each \
         with a solve in an iteration of GMRES or, of Method I, two in one of conjugate gradients; and the least and the most CPU seconds \
         of up to three such runs.",
        Approach::STEADY,
        Approach::MOST
    );
    let columns = ["method", "h", "steps", "solves", "least_seconds", "most_seconds", "residual", "outcome"];
    evidence.tables.push(Table::new("flow-approach", caption, columns, rows));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;

    #[test]
    fn what_is_refused_moves_and_what_is_accepted_was_not_refused() {
        let outcome = |residual: f64, message: &str| {
            let found = Refused { residual, psi: None, gradient: None, message: message.into() };
            refused(&too_long(1e3), &found).outcome
        };
        assert_eq!(outcome(8e-4, "refused"), Outcome::Pass);
        for (residual, message) in [(8e-4, ""), (9e-5, "refused"), (f64::NAN, "refused")] {
            assert_ne!(outcome(residual, message), Outcome::Pass, "{residual} {message}");
        }
    }
}
