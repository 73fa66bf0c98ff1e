//! Orders in time on a fixed grid, and in time and space together.

use rayon::prelude::*;

use super::{Scale, named, nominal, observed, rms, setting};
use crate::chapter::StudyError;
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Requirement, Series, Table};
use crate::measure::norm::Extremes;

/// Flows on coarse grids: what the grid leaves of them is an equation with a solution of its own.
const FLOWS: [&str; 4] =
    ["cavity-manufactured cells=8", "kovasznay cells=8", "channel-2d cells=8 length=4", "taylor-green cells=12"];
const METHODS: [&str; 8] = [
    "method-i",
    "method-ii",
    "linear(-0.5,1)",
    "trapezoidal",
    "implicit-midpoint",
    "tr-bdf2",
    "bdf2",
    "implicit-euler",
];
const END: f64 = 1.0;
/// Steps to the end, doubled three times: so short that the rates of the grid, 8ν/Δx², are resolved.
const STEPS: [u32; 4] = [64, 128, 256, 512];

/// Differences between neighbouring step sizes, which converge with the order of the method.
fn differences(flow: &str, method: &str) -> Result<Vec<f64>, StudyError> {
    let (problem, method) = (setting(flow)?, named(method)?);
    let ends: Vec<Vec<f64>> = STEPS
        .iter()
        .map(|steps| observed(&*problem, &*method, END / f64::from(*steps), END))
        .collect::<Result<_, _>>()?;
    Ok(ends.windows(2).map(|pair| rms(&pair[0], &pair[1])).collect())
}

pub(super) fn in_time(evidence: &mut Evidence, _scale: &Scale) -> Result<(), StudyError> {
    let pairs: Vec<(&str, &str)> = FLOWS.iter().flat_map(|flow| METHODS.map(|method| (*flow, method))).collect();
    let measured: Vec<Result<Vec<f64>, StudyError>> =
        pairs.par_iter().map(|(flow, method)| differences(flow, method)).collect();
    let mut rows = Vec::new();
    for ((flow, method), found) in pairs.iter().zip(&measured) {
        let (expected, name) = (nominal(&*named(method)?), flow.split(' ').next().unwrap_or(flow));
        let (numbers, order, note) = match found {
            Ok(d) => (d.clone(), (d[1] / d[2]).log2(), String::new()),
            Err(error) => (vec![f64::NAN; STEPS.len() - 1], f64::NAN, error.to_string()),
        };
        let is_ours = ["method-i", "method-ii"].contains(method);
        evidence.checks.push(Check::new(
            format!("order/{name}/{method}"),
            format!("{method} converges in h on {name} with its order, the grid fixed"),
            order,
            Requirement::Near(expected.order, if is_ours { 0.05 } else { expected.band }),
            if note.is_empty() { "from three differences of successive halvings".into() } else { note },
        ));
        let setting = [Cell::Text((*flow).into()), Cell::Text((*method).into())];
        let cells = numbers.into_iter().chain([order]).map(Cell::found);
        rows.push(setting.into_iter().chain(cells).collect());
    }
    let caption = "Root mean square of the difference between runs with h and h/2 at t = 1, on a fixed grid, and the order that \
                   the last two give.";
    let columns = ["flow", "method", "h_1_64", "h_1_128", "h_1_256", "order"];
    evidence.tables.push(Table::new("flow-orders", caption, columns, rows));
    Ok(())
}

/// Against the exact flows, with h in proportion to Δx.
pub(super) fn in_time_and_space(evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    const METHODS: [&str; 3] = ["method-i", "tr-bdf2", "implicit-euler"];
    let flows = ["cavity-manufactured", "kovasznay", "channel-2d length=4"];
    let mut rows = Vec::new();
    let mut panels = Vec::new();
    for flow in flows {
        let name = flow.split(' ').next().unwrap_or(flow);
        let mut curves = Vec::new();
        for method in METHODS {
            let found: Vec<(f64, Vec<f64>, Vec<f64>)> = scale
                .refinement
                .par_iter()
                .map(|cells| {
                    let problem = setting(&format!("{flow} cells={cells}"))?;
                    let end = observed(&*problem, &*named(method)?, 1.0 / *cells as f64, END)?;
                    Ok((*cells as f64, end, problem.exact(END).ok_or("the flow is known")?))
                })
                .collect::<Result<_, StudyError>>()?;
            let errors: Vec<f64> = found.iter().map(|(_, end, exact)| rms(end, exact)).collect();
            let order = (errors[0] / errors[1]).ln() / (found[1].0 / found[0].0).ln();
            if method == "method-i" {
                evidence.checks.push(Check::new(
                    format!("space-time/{name}"),
                    format!("Method I converges on {name} in h and Δx together"),
                    order,
                    Requirement::Near(2.0, 0.1),
                    "second order in both",
                ));
            }
            if name == "channel-2d" && method == "method-i" {
                let variation = streamwise(&found[1].1, scale.refinement[1]);
                evidence.checks.push(Check::new(
                    "channel/streamwise",
                    "Start-up of the flow in a channel stays the same along it: the largest difference in u, and the largest v",
                    variation,
                    Requirement::Below(1e-10),
                    "nothing but rounding and the tolerance of the solver can make it differ",
                ));
            }
            let points = found.iter().zip(&errors).map(|((cells, ..), error)| (1.0 / cells, *error)).collect();
            curves.push(Series::new(method, points, Mark::LineMarkers));
            let texts = [Cell::Text(name.into()), Cell::Text(method.into())];
            rows.push(texts.into_iter().chain(errors.into_iter().chain([order]).map(Cell::found)).collect());
        }
        panels.push(Panel::new(Axis::log("Δx"), Axis::log("error"), curves).titled(name));
    }
    let caption = format!(
        "Root mean square of the error of the velocities at t = 1 against the exact flows, on {} and {} cells across with h = 1/N.",
        scale.refinement[0], scale.refinement[1]
    );
    let columns = ["flow", "method", "coarse", "fine", "order"];
    evidence.tables.push(Table::new("flow-space-time", caption.clone(), columns, rows));
    evidence.figures.push(Figure::new("flow-convergence", caption, "flow-space-time", panels).in_columns(3));
    Ok(())
}

/// The largest difference along the channel of u, and the largest v; u row by row, four to a row, then v.
fn streamwise(velocities: &[f64], cells: usize) -> f64 {
    const LENGTH: usize = 4;
    let (u, v) = velocities.split_at(LENGTH * cells);
    let along = u.chunks(LENGTH).map(|row| row.iter().copied().largest() - row.iter().copied().smallest());
    along.chain(v.iter().map(|v| v.abs())).largest()
}
