//! Work against error on Kepler's problem.

use std::sync::Arc;

use lsvi::Work;

use super::{Context, Study, StudyError, prose};
use crate::evidence::{Axis, Check, Evidence, Figure, Mark, Panel, Table};
use crate::experiment::kepler_period::{Found, KeplerPeriod};
use crate::method;
use crate::row;

pub(super) const STUDY: Study = Study {
    id: "work-precision",
    title: "Work against error",
    question: "How much work does each method need for a given accuracy on Kepler's problem?",
    source: "[KY21] Section 3.1: accuracy at equal order and at equal cost",
    run,
};

/// Classical methods, on the equations of the first order.
const BASELINES: [&str; 4] = ["rk4", "implicit-midpoint", "trapezoidal", "sdirk2"];

/// What the checks and the caption speak of.
pub(super) const TOLD: [&str; 6] =
    ["path-fitted(3)", "path-fitted(3,gauss)", "path-fitted(4)", "path-fitted(4,gauss)", "galerkin-gauss(3)", "rk4"];

/// Steps per period.
const STEPS: [u32; 6] = [32, 64, 128, 256, 512, 1024];

/// Accuracy at which methods are compared.
const TARGET: f64 = 1e-3;

struct Curve {
    method: String,
    points: Vec<(Work, f64)>,
}

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let mut all = method::integrators();
    for name in BASELINES {
        all.push(method::parse(name)?);
    }
    let names: Vec<String> = all.iter().map(|method| method.name()).collect();
    let runs = names.iter().flat_map(|name| STEPS.map(|steps| KeplerPeriod { method: name.clone(), steps }));
    let found = context.get_each(runs.collect())?;
    let curve = |(name, found): (&String, &[Arc<Found>])| {
        let points = found.iter().map(|found| (found.work, found.error)).collect();
        Curve { method: name.clone(), points }
    };
    let curves: Vec<Curve> = names.iter().zip(found.chunks(STEPS.len())).map(curve).collect();
    let rows = curves.iter().flat_map(|curve| {
        curve
            .points
            .iter()
            .map(|(work, error)| row![&curve.method, work.steps, work.residuals, work.factorizations, *error])
    });
    let columns = ["method", "steps", "residuals", "factorizations", "error"];
    let data = Table::data("work-precision", "Work and error of every run.", &columns, rows.collect());
    let reached = curves.iter().map(|curve| {
        let count = |f| work_at(curve, f);
        row![&curve.method, count(|w| w.steps), count(|w| w.residuals), count(|w| w.factorizations), place(curve)]
    });
    let reached = Table::new(
        "work-at-accuracy",
        format!(
            "Work for an error of {TARGET:e} after one period, and how it was found; empty where no run of the ladder is that accurate."
        ),
        &["method", "steps", "residuals", "factorizations", "found"],
        reached.collect(),
    );
    let panel = |label: &str, count: &str| {
        let curves = data.curves("method", count, "error", Mark::LineMarkers);
        Panel::new(Axis::log(label), Axis::log("error in (q, p)"), curves)
    };
    let caption = "Error in (q, p) after one period of Kepler's problem, eccentricity 0.6, against steps and against evaluations of \
                   the step equations, one for each iteration; rk4 evaluates the right-hand side instead.";
    let panels = [panel("steps", "steps"), panel("evaluations of the step equations", "residuals")];
    let figure = Figure::new("work-precision", caption, data.id.clone(), panels).in_columns(2);
    let figure = figure.telling(&TOLD);
    Ok(Evidence {
        checks: vec![
            cheaper(&curves, "path-fitted(3,gauss)", "path-fitted(3)")?,
            cheaper(&curves, "path-fitted(4,gauss)", "path-fitted(4)")?,
            cheaper(&curves, "path-fitted(4,gauss)", "path-fitted(2)")?,
            cheaper(&curves, "galerkin-gauss(3)", "galerkin-gauss(2)")?,
        ],
        tables: vec![reached, data],
        figures: vec![figure],
        notes: prose::fill(include_str!("work_precision.md"), &[])?,
        ..Evidence::default()
    })
}

/// Where on its ladder a method reaches `TARGET`.
fn place(curve: &Curve) -> &'static str {
    match curve.points.first() {
        Some((_, error)) if *error <= TARGET => "at most: the coarsest run is more accurate",
        _ if work_at(curve, |work| work.steps).is_some() => "interpolated",
        _ => "not reached by the finest run",
    }
}

/// The work at which the error passes `TARGET`, on a straight line in logarithms; that of the coarsest run if it is already
/// more accurate.
fn work_at(curve: &Curve, count: fn(&Work) -> u64) -> Option<f64> {
    let (work, error) = curve.points.first()?;
    if *error <= TARGET {
        return Some(count(work) as f64);
    }
    let pair = curve.points.windows(2).find(|pair| pair[0].1 > TARGET && pair[1].1 <= TARGET)?;
    let part = (TARGET / pair[0].1).ln() / (pair[1].1 / pair[0].1).ln();
    let [coarse, fine] = [count(&pair[0].0) as f64, count(&pair[1].0) as f64];
    // An explicit method has no factorizations at all.
    Some(if coarse == 0.0 { 0.0 } else { coarse * (fine / coarse).powf(part) })
}

fn cheaper(curves: &[Curve], cheap: &str, dear: &str) -> Result<Check, StudyError> {
    let curve = |name: &str| curves.iter().find(|curve| curve.method == name).ok_or("a method of the ladder");
    // The equations of a step ask for the force at each of its nodes.
    let nodes = |name: &str| -> Result<f64, StudyError> { Ok(f64::from(method::parse(name)?.traits().stages)) };
    let work = |curve: &Curve| work_at(curve, |work| work.residuals);
    let [own, other] = [curve(cheap)?, curve(dear)?];
    // The dear one needs more than its last run where that does not get there; of the cheap one nothing is known then.
    let most = other.points.last().map(|(work, _)| work.residuals as f64);
    let evaluations = [work(own), work(other).or(most)].map(|work| work.unwrap_or(f64::NAN));
    Ok(Check::at_most(
        format!("{cheap}-against-{dear}"),
        format!("{cheap} needs fewer evaluations of the force than {dear} for an error of {TARGET:e}"),
        evaluations[0] * nodes(cheap)? / (evaluations[1] * nodes(dear)?),
        1.0,
        format!(
            "ratio of the evaluations, one at each node; where the ladder of {dear} ends before the accuracy, those of its last run count"
        ),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;

    /// Half-way between ten times the error and a tenth of it the work is the geometric mean.
    #[test]
    fn work_between_two_runs_is_on_a_line_in_logarithms() {
        let work = |steps| Work { steps, ..Work::default() };
        let points = vec![(work(100), 10.0 * TARGET), (work(400), 0.1 * TARGET)];
        let found = work_at(&Curve { method: "rk4".into(), points }, |work| work.steps);
        assert!(found.is_some_and(|steps| (steps - 200.0).abs() < 1e-9), "{found:?}");
    }

    #[test]
    fn a_method_that_does_not_get_there_is_not_cheaper() {
        let curve = |method: &str, errors: [f64; 2]| {
            let work = |residuals| Work { residuals, ..Work::default() };
            Curve { method: method.into(), points: vec![(work(100), errors[0]), (work(200), errors[1])] }
        };
        let outcome = |own: [f64; 2], other: [f64; 2]| {
            let curves = [curve("galerkin-gauss(2)", own), curve("galerkin-gauss(3)", other)];
            cheaper(&curves, "galerkin-gauss(2)", "galerkin-gauss(3)").expect("known").outcome
        };
        // For as many equations the one with two nodes takes two thirds of the evaluations of the one with three.
        let curves = [curve("galerkin-gauss(2)", [0.5 * TARGET; 2]), curve("galerkin-gauss(3)", [0.5 * TARGET; 2])];
        let check = cheaper(&curves, "galerkin-gauss(2)", "galerkin-gauss(3)").expect("known");
        assert_eq!(check.measured, Some(200.0 / 300.0));
        let (there, not) = ([1.0, 0.5 * TARGET], [1.0, 2.0 * TARGET]);
        assert_eq!(outcome(there, there), Outcome::Pass);
        assert_eq!(outcome(there, not), Outcome::Pass);
        assert_eq!(outcome(not, not), Outcome::Fail);
        assert_eq!(outcome(not, there), Outcome::Fail);
    }
}
