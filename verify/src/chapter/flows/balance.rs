//! Energy, enstrophy and error of periodic flows, in both metrics.

use rayon::prelude::*;

use super::{Scale, named, rms, setting};
use crate::chapter::StudyError;
use crate::evidence::{Axis, Cell, Check, Evidence, Field, Figure, Panel, Requirement, Table};
use crate::problem::Problem;
use crate::run::run;

const END: f64 = 1.0;
const STEPS: [f64; 3] = [0.05, 0.025, 0.0125];
const METHODS: [(&str, &str); 6] = [
    ("method-i", "velocity"),
    ("method-i", "vorticity"),
    ("trapezoidal", "velocity"),
    ("implicit-midpoint", "velocity"),
    ("tr-bdf2", "velocity"),
    ("implicit-euler", "velocity"),
];

/// What is measured of a run.
struct Row {
    flow: &'static str,
    method: &'static str,
    metric: &'static str,
    h: f64,
    /// Of the vorticity at the end, relative.
    error: f64,
    enstrophy: f64,
}

/// ½ mean ω².
fn enstrophy(vorticity: &[f64]) -> f64 {
    0.5 * vorticity.iter().map(|w| w * w).sum::<f64>() / vorticity.len() as f64
}

fn end(problem: &dyn Problem, method: &str, h: f64) -> Result<Vec<f64>, StudyError> {
    Ok(problem.observe(END, &run(problem, &*named(method)?, h, END, |_| {})?.end.q))
}

pub(super) fn study(evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    let flows = ["shear-layer", "turbulence-2d"];
    let mut rows: Vec<Row> = Vec::new();
    let mut panels = Vec::new();
    for flow in flows {
        let of = |metric: &str| setting(&format!("{flow} cells={} metric={metric}", scale.points));
        // RK4 at a quarter of the finest step, whose own error is far below those of second order.
        let reference = end(&*of("velocity")?, "rk4", 0.25 * STEPS[2])?;
        let size = rms(&reference, &vec![0.0; reference.len()]);
        let cases: Vec<_> = METHODS.iter().flat_map(|case| STEPS.map(|h| (*case, h))).collect();
        let found: Vec<Row> = cases
            .par_iter()
            .map(|((method, metric), h)| {
                let vorticity = end(&*of(metric)?, method, *h)?;
                let enstrophy = enstrophy(&vorticity) / enstrophy(&reference) - 1.0;
                Ok(Row { flow, method, metric, h: *h, error: rms(&vorticity, &reference) / size, enstrophy })
            })
            .collect::<Result<_, StudyError>>()?;
        rows.extend(found);
        panels.push(map(&format!("{flow}, t = {END}"), scale.points, &reference));
    }
    let error = |flow: &str, method: &str, metric: &str, h: f64| {
        let row = rows.iter().find(|r| (r.flow, r.method, r.metric, r.h) == (flow, method, metric, h));
        row.map_or(f64::NAN, |row| row.error)
    };
    for flow in flows {
        let of = |method, metric| error(flow, method, metric, STEPS[2]);
        evidence.checks.extend([
            Check::new(
                format!("periodic/{flow}/order"),
                format!("Method I converges on {flow} with order 2 in the velocity metric"),
                (error(flow, "method-i", "velocity", STEPS[1]) / of("method-i", "velocity")).log2(),
                Requirement::Near(2.0, 0.2),
                "from the two finest steps, where the next term of the error is a few per cent of it",
            ),
            Check::new(
                format!("periodic/{flow}/metric"),
                format!("The vorticity metric is the worse choice on {flow}: its error over that of the velocity metric"),
                of("method-i", "vorticity") / of("method-i", "velocity"),
                Requirement::Above(1.0),
                "another metric is another method, with the defect ¼h² W⁻¹JᵀW v″: on flows W = 1 weighs the small eddies by |k|²",
            ),
            Check::new(
                format!("periodic/{flow}/tr-bdf2"),
                format!("Method I loses to TR-BDF2 on {flow}: its error over that of TR-BDF2 at equal h"),
                of("method-i", "velocity") / of("tr-bdf2", "velocity"),
                Requirement::Above(1.0),
                "a smooth flow: error constants −0.04 and 1/6",
            ),
        ]);
    }
    evidence.checks.push(conservation(scale)?);
    let cells = |row: &Row| {
        let texts = [row.flow, row.method, row.metric].map(|text| Cell::Text(text.into()));
        texts.into_iter().chain([row.h, row.error, row.enstrophy].map(Cell::found)).collect()
    };
    let caption = format!(
        "Periodic flows on {0} × {0} points at t = {END}: relative error of the vorticity, root mean square, and of the enstrophy, \
         against RK4 with a quarter of the finest step.",
        scale.points
    );
    let columns = ["flow", "method", "metric", "h", "error", "enstrophy"];
    evidence.tables.push(Table::new("flow-periodic", caption, columns, rows.iter().map(cells).collect()));
    let caption = "The vorticity of the two periodic flows at the end, from the reference.";
    evidence.figures.push(Figure::new("flow-vorticity", caption, "flow-periodic", panels).in_columns(2));
    Ok(())
}

/// Without viscosity the implicit midpoint rule keeps the enstrophy, a quadratic form that the dealiased equation conserves.
fn conservation(scale: &Scale) -> Result<Check, StudyError> {
    let problem = setting(&format!("shear-layer cells={} re=1e12", scale.points))?;
    let before = enstrophy(&problem.observe(0.0, &problem.initial()));
    let after = enstrophy(&end(&*problem, "implicit-midpoint", 0.2)?);
    Ok(Check::new(
        "periodic/enstrophy",
        "Without viscosity the implicit midpoint rule keeps the enstrophy of the dealiased equations: relative change",
        (after / before - 1.0).abs(),
        Requirement::AtMost(1e-8),
        "it keeps quadratic invariants; the tolerance of the solver is 1e-10 a step, and there are ten",
    ))
}

/// A map of the vorticity.
fn map(title: &str, points: usize, vorticity: &[f64]) -> Panel {
    let place: Vec<f64> = (0..points).map(|i| 2.0 * std::f64::consts::PI * i as f64 / points as f64).collect();
    let largest = vorticity.iter().fold(0.0, |m: f64, w| m.max(w.abs()));
    let levels: Vec<f64> = [-0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75].map(|l| l * largest).to_vec();
    let values = vorticity.chunks(points).map(<[f64]>::to_vec).collect();
    let field = Field { x: place.clone(), y: place, values, bands: super::bands(&levels), levels, contours: false };
    Panel::new(Axis::linear("x"), Axis::linear("y"), Vec::new()).titled(title).over(field)
}
