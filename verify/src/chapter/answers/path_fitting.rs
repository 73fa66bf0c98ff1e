//! Error and energy of path fitting on equispaced and on Gauss nodes, beside the Galerkin integrator of the same cost.

use super::{Answer, prose};
use crate::chapter::{Context, StudyError};
use crate::evidence::number::{brief, rounded_up};
use crate::evidence::{Axis, Check, Figure, Mark, Panel, Requirement, Series, Table};
use crate::experiment::energy_course::EnergyCourse;
use crate::experiment::kepler_period::KeplerPeriod;
use crate::experiment::symplectic_defect::Defects;
use crate::measure::norm::{Extremes, larger};
use crate::{method, row};

/// The step whose defect of symplecticity is told.
const DEFECT_H: f64 = 0.2;
/// Three interior points each; the equations of a step are as many.
const METHODS: [&str; 3] = ["path-fitted(4)", "path-fitted(4,gauss)", "galerkin-gauss(3)"];

/// Steps per period, and where on this ladder the methods are compared.
const LADDER: [u32; 6] = [32, 64, 128, 256, 512, 1024];
const COMPARED: usize = 3;

/// The long run.
const ENERGY: (&str, f64, u32) = ("asymmetric-pendulum", 0.5, 10_000);

pub(super) fn answer(context: &Context) -> Result<Answer, StudyError> {
    let mut rows = Vec::new();
    let runs = METHODS.iter().flat_map(|name| LADDER.map(|steps| KeplerPeriod { method: (*name).into(), steps }));
    let periods = context.get_each(runs.collect())?;
    let errors: Vec<Series> = METHODS
        .iter()
        .zip(periods.chunks(LADDER.len()))
        .map(|(name, found)| {
            let points: Vec<_> = found.iter().map(|found| (found.work.residuals as f64, found.error)).collect();
            rows.extend(points.iter().map(|(work, error)| row!["error over evaluations", *name, *work, *error]));
            Series::new(*name, points, Mark::LineMarkers)
        })
        .collect();
    let (name, h, steps) = ENERGY;
    let runs = METHODS.map(|method| EnergyCourse { problem: name, method, h, steps });
    let courses = context.get_each(runs.into())?;
    let energies: Vec<Series> = METHODS
        .iter()
        .zip(&courses)
        .map(|(name, windows)| {
            rows.extend(windows.iter().map(|(t, error)| row!["mean energy error over time", *name, *t, *error]));
            Series::new(*name, windows.to_vec(), Mark::LineMarkers)
        })
        .collect();
    // By how much the means of the windows differ at most: of a drift, those of the first and the last.
    let change = |i: usize| {
        let means = || courses[i].iter().map(|(_, mean)| *mean);
        means().largest() - means().smallest()
    };
    let kept = larger(change(1), change(2));
    let drift = (slope(&courses[0]) * h * f64::from(steps)).abs();
    let mut defects = Vec::new();
    for name in METHODS {
        defects.push(context.get(Defects { problem: "double-pendulum", method: name.into() })?.at(DEFECT_H));
    }
    let error = |i: usize| periods[i * LADDER.len() + COMPARED].error;
    let (gauss, galerkin) = (error(0) / error(1), error(2) / error(1));
    let checks = vec![
        Check::new(
            "path-fitting/gauss",
            "Moving the points to Gauss' nodes gains more than a digit: ratio of the errors",
            gauss,
            Requirement::AtLeast(10.0),
            "equal steps",
        ),
        Check::within(
            "path-fitting/work",
            "The two take as many evaluations: their ratio",
            periods[COMPARED].work.residuals as f64 / periods[LADDER.len() + COMPARED].work.residuals as f64,
            [0.8, 1.25],
            format!(
                "{} evaluations a step on Gauss' nodes; in some steps the iteration of one of them ends an evaluation earlier",
                brief(periods[LADDER.len() + COMPARED].work.residuals as f64 / f64::from(LADDER[COMPARED]))
            ),
        ),
        Check::new(
            "path-fitting/galerkin",
            "On Gauss' nodes path fitting is ahead of galerkin-gauss(3) on Kepler's problem: ratio of the errors",
            galerkin,
            Requirement::Above(1.0),
            "as many steps; the error of galerkin-gauss(3) over the other",
        ),
        Check::new(
            "path-fitting/energy",
            "On equispaced nodes the energy drifts: the change of its mean over the larger of the two on Gauss' nodes and with the \
             Galerkin integrator",
            change(0) / kept,
            Requirement::AtLeast(100.0),
            "two symplectic integrators, whose means change by less than rounding may add up to",
        ),
        Check::new(
            "path-fitting/defect",
            "Even on Gauss' nodes a step is not symplectic on the double pendulum: defect over that of galerkin-gauss(3)",
            defects[1] / defects[2],
            Requirement::AtLeast(1e6),
            format!("one step of {DEFECT_H}; the Galerkin step's defect is rounding"),
        ),
    ];
    let values = [
        ("steps", LADDER[COMPARED].to_string()),
        ("order", method::parse(METHODS[0])?.order().to_string()),
        ("gauss_order", method::parse(METHODS[1])?.order().to_string()),
        ("gauss", brief(gauss)),
        ("galerkin", brief(galerkin)),
        ("long", steps.to_string()),
        ("drift", brief(drift)),
        ("kept", brief(rounded_up(kept, 2))),
        ("equispaced_defect", brief(defects[0])),
        ("defect_h", DEFECT_H.to_string()),
        ("gauss_defect", brief(defects[1])),
        ("galerkin_defect", brief(defects[2])),
    ];
    let work = Axis::log("evaluations of the step equations");
    let panels = [
        Panel::new(work, Axis::log("error after one period"), errors).titled("Kepler's problem, eccentricity 0.6"),
        Panel::new(Axis::linear("t"), Axis::linear("mean energy error"), energies).titled("Rotating pendulum, h = 0.5"),
    ];
    let caption =
        "Error over evaluations on Kepler's problem, and mean energy error over time of the rotating pendulum.";
    Ok(Answer {
        id: "answer-path-fitted",
        question: "Should I use the path-fitted integrator with three interior points?",
        short: "not as published (equispaced nodes); with Gauss nodes, yes".into(),
        text: prose::fill(include_str!("path_fitting.md"), &values)?,
        checks,
        figure: Some(Figure::new("answer-path-fitted", "", "answer-path-fitted", panels).in_columns(2)),
        table: Table::data("answer-path-fitted", caption, ["what", "method", "evaluations_or_t", "error"], rows),
    })
}

/// Of the line through the points, by least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let [x, y] = [mean(|point| point.0), mean(|point| point.1)];
    let squares: f64 = points.iter().map(|point| (point.0 - x).powi(2)).sum();
    points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum::<f64>() / squares
}
