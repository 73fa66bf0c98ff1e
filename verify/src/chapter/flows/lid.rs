//! The impulsively started lid, with steps that do not resolve its first moments, and what steps make of disturbances.

use super::{Context, Scale, StudyError, brief, contest, prose, short, streamlines};
use crate::evidence::{Axis, Check, Evidence, Figure, Mark, Panel, Requirement, Series, Table};
use crate::experiment::flow::PROJECTION;
use crate::experiment::flow::lid::{Found, METHODS, RE, STEPS, StartUp, StartedLid, TIMES};
use crate::experiment::flow::profile::Profile;
use crate::experiment::flow::propagator::Disturbances;
use crate::measure::norm::Extremes;
use crate::row;

pub(super) fn study(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    let cells = scale.lid;
    let found = context.get(StartedLid { cells })?;
    let error = |h: f64, t: f64, method: &str| {
        let case = found.cases.iter().find(|case| (case.h, case.t, case.method) == (h, t, method));
        case.map_or(f64::NAN, |case| case.error)
    };
    evidence.checks.push(reference(&found));
    let ([large, small], [first, last]) = (STEPS, TIMES);
    let own = |h, t| short(error(h, t, "method-i"));
    let over = |method, h, t| error(h, t, method) / error(h, t, "method-i");
    let ratio = |method, h, t| brief(over(method, h, t));
    let is_best = is_least(|method| over(method, large, first));
    // Of Method I, in all runs.
    let against_projection: Vec<f64> =
        TIMES.into_iter().flat_map(|t| STEPS.map(|h| 1.0 / over(PROJECTION, h, t))).collect();
    let values = [
        ("cells", cells.to_string()),
        ("re", short(RE)),
        ("large", short(large)),
        ("small", short(small)),
        ("first", short(first)),
        ("last", short(last)),
        ("rank", if is_best { "the smallest of all" } else { "not the smallest" }.into()),
        ("own_large_first", own(large, first)),
        ("own_large_last", own(large, last)),
        ("own_small_first", own(small, first)),
        ("own_small_last", own(small, last)),
        ("rule_large_first", ratio("trapezoidal", large, first)),
        ("rule_large_last", ratio("trapezoidal", large, last)),
        ("rule_small_first", ratio("trapezoidal", small, first)),
        ("rule_small_last", ratio("trapezoidal", small, last)),
        ("tr_bdf2_large_first", ratio("tr-bdf2", large, first)),
        ("tr_bdf2_large_last", ratio("tr-bdf2", large, last)),
        ("tr_bdf2_small_first", ratio("tr-bdf2", small, first)),
        ("tr_bdf2_small_last", ratio("tr-bdf2", small, last)),
        ("euler_large_first", ratio("implicit-euler", large, first)),
        ("euler_large_last", ratio("implicit-euler", large, last)),
        ("against_projection", contest(&against_projection)),
        // The lid moves with velocity 1.
        ("courant_large", brief(large * cells as f64)),
        ("courant_small", brief(small * cells as f64)),
    ];
    evidence.notes.extend(prose::fill(include_str!("lid.md"), &values)?);
    let rows = found.cases.iter().map(|case| row![case.h, case.t, case.method, case.error]);
    let caption = format!(
        "Cavity of {cells} cells a side, Re = {RE}, lid started at once: root mean square of the error of the velocities against \
         RK4 with h = 1/128."
    );
    let columns = ["h", "t", "method", "error"];
    evidence.tables.push(Table::new("flow-lid", caption, columns, rows.collect()));
    let mut data = Vec::new();
    let mut panels = Vec::new();
    for truth in &found.references {
        let shown = found.cases.iter().filter(|case| case.h == large && case.t == truth.t);
        let shown = shown.map(|case| (case.method, &case.velocities, Mark::Line));
        let mut curves = Vec::new();
        for (label, velocities, mark) in shown.chain([("reference", &truth.velocities, Mark::Guide)]) {
            let points = Profile::new(cells, velocities).line('u').to_vec();
            data.extend(points.iter().map(|(y, u)| row![truth.t, label, *y, *u]));
            curves.push(Series::new(label, points, mark));
        }
        panels
            .push(Panel::new(Axis::linear("y"), Axis::linear("u at x = ½"), curves).titled(format!("t = {}", truth.t)));
    }
    let caption = format!(
        "Velocity on the vertical centre line after one and after four steps of h = {large} from rest: the trapezoidal \
         and the midpoint rule swing from one side of the reference to the other next to the lid, at y = 1."
    );
    let id = "flow-lid-profiles";
    evidence.tables.push(Table::data(id, caption.clone(), ["t", "method", "y", "u"], data));
    evidence.figures.push(Figure::new(id, caption, id, panels).in_columns(2));
    filmstrip(context, evidence, scale)
}

/// Whether every other method has more than the error of Method I, by its error over that.
fn is_least(over: impl Fn(&'static str) -> f64) -> bool {
    METHODS.into_iter().all(|method| method == "method-i" || over(method) > 1.0)
}

/// What errors are measured against has less of its own.
fn reference(found: &Found) -> Check {
    Check::new(
        "lid/reference",
        "The reference of the impulsively started lid is good enough: its error over the smallest that is measured",
        found.references.iter().map(|r| r.error).largest() / found.cases.iter().map(|case| case.error).smallest(),
        Requirement::AtMost(0.1),
        "a tenth of an error changes no ratio stated here by more than that",
    )
}

/// The stream function of the start-up, by Method I.
fn filmstrip(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    let cells = scale.lid;
    let states = context.get(StartUp { cells })?;
    let mut panels = Vec::new();
    let mut rows = Vec::new();
    for (t, psi) in StartUp::TIMES.into_iter().zip(states.iter()) {
        panels.push(streamlines(&format!("t = {t}"), cells, psi));
        rows.extend(psi.iter().enumerate().map(|(k, psi)| {
            let (i, j) = (k % (cells - 1) + 1, k / (cells - 1) + 1);
            row![t, i as f64 / cells as f64, j as f64 / cells as f64, *psi]
        }));
    }
    let caption = format!(
        "Streamlines of the cavity after the lid has started, Re = {RE}, by Method I with h = {}: the vortex grows from the lid into the cavity.",
        StartUp::H
    );
    let id = "flow-start-up";
    evidence.tables.push(Table::data(id, caption.clone(), ["t", "x", "y", "psi"], rows));
    evidence.figures.push(Figure::new(id, caption, id, panels).in_columns(4));
    Ok(())
}

/// By what factor a step damps a small disturbance of the steady cavity.
pub(super) fn disturbances(context: &Context, evidence: &mut Evidence, _scale: &Scale) -> Result<(), StudyError> {
    const METHODS: [&str; 5] = ["method-i", "trapezoidal", "implicit-midpoint", "tr-bdf2", "implicit-euler"];
    const STEPS: [f64; 3] = [1.0, 10.0, 100.0];
    let mut cases = Vec::new();
    for method in METHODS {
        cases.extend(STEPS.map(|h| (method, h)));
    }
    let found = context.get_each(cases.iter().map(|(method, h)| Disturbances { method, h: *h }).collect())?;
    for method in METHODS {
        let of = cases.iter().zip(&found).filter(|(case, _)| case.0 == method);
        evidence.checks.push(as_in_theory(method, of.map(|(_, found)| found.difference)));
    }
    let rows = cases.iter().zip(&found).map(|((method, h), found)| {
        row![*method, *h, found.radius, found.slowest.re, found.slowest.im.abs(), found.difference]
    });
    let of = |method: &str, h: f64| {
        let found = cases.iter().zip(&found).find(|(case, _)| **case == (method, h));
        found.map(|(_, found)| found).ok_or("no such case")
    };
    let radius = |method: &str, h: f64| of(method, h).map(|found| short(found.radius));
    let [one, .., hundred] = STEPS;
    let slowest = of("trapezoidal", hundred)?.slowest;
    let values = [
        ("cells", Disturbances::CELLS.to_string()),
        ("re", short(Disturbances::RE)),
        ("sign", if slowest.re < 0.0 { "with its sign changed, so that it rings" } else { "with its sign" }.into()),
        ("one", short(one)),
        ("hundred", short(hundred)),
        ("rule_one", radius("trapezoidal", one)?),
        ("rule_hundred", radius("trapezoidal", hundred)?),
        ("method_i_one", radius("method-i", one)?),
        ("method_i_hundred", radius("method-i", hundred)?),
        ("tr_bdf2_hundred", radius("tr-bdf2", hundred)?),
        ("euler_hundred", radius("implicit-euler", hundred)?),
    ];
    evidence.notes.extend(prose::fill(include_str!("disturbances.md"), &values)?);
    let caption = format!(
        "Steady cavity of {} cells a side at Re = {}: the factor by which a step damps the disturbance that it damps least, the eigenvalue \
         of that size, and the largest difference between the derivative of a step by live steps and by theory.",
        Disturbances::CELLS,
        Disturbances::RE
    );
    let columns = ["method", "h", "factor", "real", "imaginary", "difference"];
    evidence.tables.push(Table::new("flow-disturbances", caption, columns, rows.collect()));
    Ok(())
}

/// That no derivative of a step of a method differs from theory's.
fn as_in_theory(method: &str, differences: impl Iterator<Item = f64>) -> Check {
    Check::new(
        format!("disturbances/{method}"),
        format!(
            "{method} steps small disturbances of the steady cavity as theory has it, for all h: largest relative difference"
        ),
        differences.largest(),
        Requirement::AtMost(1e-4),
        "R(hA), for Method I the minimum of its action, with A by hand; central differences of disturbances of 1e-3 leave their \
         square, and a hundred times that for the third derivatives",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;
    use crate::experiment::flow::lid::{Case, Reference};

    #[test]
    fn the_worst_reference_is_held_against_the_best_run() {
        let outcome = |references: [f64; 2], errors: [f64; 2]| {
            let references = references.map(|error| Reference { t: 0.5, velocities: Vec::new(), error }).into();
            let case = |error| Case { h: 0.5, t: 0.5, method: "method-i", error, velocities: Vec::new() };
            reference(&Found { references, cases: errors.map(case).into() }).outcome
        };
        assert_eq!(outcome([9e-6, 1e-9], [1e-4, 1.0]), Outcome::Pass);
        assert_eq!(outcome([1e-9, 1.1e-5], [1.0, 1e-4]), Outcome::Fail);
        assert_ne!(outcome([1e-9, f64::NAN], [1.0, 1e-4]), Outcome::Pass);
    }

    #[test]
    fn the_data_of_the_start_up_run_along_x_first() {
        let (context, mut evidence) = (Context::quick(), Evidence::default());
        filmstrip(&context, &mut evidence, &Scale { lid: 3, ..super::super::SMALL }).expect("it runs");
        let states = context.get(StartUp { cells: 3 }).expect("it ran");
        let places = [[1.0, 1.0], [2.0, 1.0], [1.0, 2.0], [2.0, 2.0]];
        let expected = StartUp::TIMES
            .into_iter()
            .zip(states.iter())
            .flat_map(|(t, psi)| psi.iter().zip(places).map(move |(psi, [i, j])| row![t, i / 3.0, j / 3.0, *psi]));
        assert_eq!(evidence.tables[0].rows, expected.collect::<Vec<_>>());
    }

    #[test]
    fn one_step_size_at_which_theory_is_missed_is_enough() {
        let outcome = |differences: [f64; 3]| as_in_theory("method-i", differences.into_iter()).outcome;
        assert_eq!(outcome([1e-8, 0.9e-4, 1e-9]), Outcome::Pass);
        assert_eq!(outcome([1e-8, 1.1e-4, 1e-9]), Outcome::Fail);
        assert_ne!(outcome([f64::NAN, 1e-8, 1e-9]), Outcome::Pass);
    }

    #[test]
    fn an_error_is_the_smallest_of_all_where_no_other_is_as_small() {
        assert!(is_least(|method| if method == "method-i" { 1.0 } else { 1.1 }));
        for one in METHODS.into_iter().filter(|method| *method != "method-i") {
            for its_own in [0.9, 1.0, f64::NAN] {
                assert!(!is_least(|method| if method == one { its_own } else { 2.0 }), "{one}, {its_own}");
            }
        }
    }
}
