//! Energy, enstrophy and error of periodic flows, in both metrics.

use super::{Context, Scale, StudyError, contest, map, prose, short};
use crate::evidence::{Check, Evidence, Figure, Panel, Requirement, Table};
use crate::experiment::flow::periodic::{END, PeriodicErrors, STEPS, WithoutViscosity};
use crate::measure::norm::{Extremes, max_norm};
use crate::row;

const FLOWS: [&str; 2] = ["shear-layer", "turbulence-2d"];

pub(super) fn study(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    let points = scale.points;
    let found = context.get_each(FLOWS.map(|flow| PeriodicErrors { flow, points }).into())?;
    let of = |flow: &str, method: &str, metric: &str, h: f64| {
        let (_, found) = FLOWS.iter().zip(&found).find(|(name, _)| **name == flow)?;
        found.rows.iter().find(|row| (row.method, row.metric, row.h) == (method, metric, h))
    };
    let error =
        |flow: &str, method: &str, metric: &str, h: f64| of(flow, method, metric, h).map_or(f64::NAN, |row| row.error);
    let [.., coarser, finest] = STEPS;
    let mut rows = Vec::new();
    let mut panels = Vec::new();
    for (flow, found) in FLOWS.iter().zip(&found) {
        let smallest = found.rows.iter().filter(|row| row.method != "rk4").map(|row| row.error).smallest();
        evidence.checks.push(Check::new(
            format!("periodic/{flow}/reference"),
            format!("RK4 is a reference on {flow}: its error over the smallest of the others"),
            found.reference_error / smallest,
            Requirement::AtMost(0.01),
            "a hundredth of an error moves no order by more than that; RK4's own, by two step sizes",
        ));
        for metric in ["velocity", "vorticity"] {
            let of = |h| error(flow, "method-i", metric, h);
            evidence.checks.push(Check::new(
                format!("periodic/{flow}/order/{metric}"),
                format!("Method I converges on {flow} with order 2 in the {metric} metric"),
                (of(coarser) / of(finest)).log2(),
                Requirement::Near(2.0, 0.2),
                "from the two finest steps, where the next term of the error is a few per cent of it",
            ));
        }
        rows.extend(found.rows.iter().map(|r| row![*flow, r.method, r.metric, r.h, r.error, r.energy, r.enstrophy]));
        panels.push(vortices(&format!("{flow}, t = {END}"), points, &found.reference));
    }
    let (check, table) = conservation(context, scale)?;
    evidence.checks.push(check);
    evidence.tables.push(table);
    let over = |flow, a: (&str, &str), b: (&str, &str)| error(flow, a.0, a.1, finest) / error(flow, b.0, b.1, finest);
    let ratio = |flow, a, b| short(over(flow, a, b));
    let balance = |flow, metric| of(flow, "method-i", metric, finest).map_or(f64::NAN, |row| row.enstrophy.abs());
    let (ours, other) = (("method-i", "velocity"), ("method-i", "vorticity"));
    let rule = ("tr-bdf2", "velocity");
    let values = [
        ("tr_bdf2", contest(&FLOWS.map(|flow| over(flow, ours, rule)))),
        ("shear_metric", ratio("shear-layer", other, ours)),
        ("turbulence_metric", ratio("turbulence-2d", other, ours)),
        ("shear_enstrophy", short(balance("shear-layer", "vorticity") / balance("shear-layer", "velocity"))),
        ("turbulence_enstrophy", short(balance("turbulence-2d", "vorticity") / balance("turbulence-2d", "velocity"))),
        ("shear_tr_bdf2", ratio("shear-layer", ours, rule)),
        ("turbulence_tr_bdf2", ratio("turbulence-2d", ours, rule)),
        ("turbulence_trapezoidal", ratio("turbulence-2d", ours, ("trapezoidal", "velocity"))),
        ("turbulence_euler", ratio("turbulence-2d", ("implicit-euler", "velocity"), ours)),
        ("h", short(finest)),
    ];
    evidence.notes.extend(prose::fill(include_str!("balance.md"), &values)?);
    let caption = format!(
        "Periodic flows on {points} × {points} points at t = {END}, by metric of the residual: relative error of the vorticity, root \
         mean square, and of energy and enstrophy, against RK4 with half the finest step."
    );
    let id = format!("flow-periodic{}", scale.suffix);
    let columns = ["flow", "method", "metric", "h", "error", "energy", "enstrophy"];
    evidence.tables.push(Table::new(id.clone(), caption, columns, rows));
    let caption = "The vorticity of the two periodic flows at the end, over its largest value, from the reference.";
    evidence.figures.push(Figure::new(format!("flow-vorticity{}", scale.suffix), caption, id, panels).in_columns(2));
    Ok(())
}

/// Without viscosity the implicit midpoint rule keeps energy and enstrophy, quadratic forms that the dealiased equations conserve.
fn conservation(context: &Context, scale: &Scale) -> Result<(Check, Table), StudyError> {
    let found = context.get(WithoutViscosity { points: scale.points })?;
    let caption = format!(
        "The shear layer without viscosity, which keeps both: relative change of energy and of enstrophy after ten steps of h = {}.",
        WithoutViscosity::H
    );
    let rows = found.iter().map(|c| row![c.method, c.metric, c.energy, c.enstrophy]).collect();
    let columns = ["method", "metric", "energy", "enstrophy"];
    let table = Table::new(format!("flow-conservation{}", scale.suffix), caption, columns, rows);
    let kept = found.iter().find(|change| change.method == "implicit-midpoint");
    let check = Check::new(
        "periodic/conservation",
        "Without viscosity the implicit midpoint rule keeps energy and enstrophy of the dealiased equations: relative change",
        kept.map_or(f64::NAN, |change| max_norm(&[change.energy, change.enstrophy])),
        Requirement::AtMost(1e-8),
        "it keeps quadratic invariants; the tolerance of the solver is 1e-10 a step, and there are ten",
    );
    Ok((check, table))
}

/// A map of the vorticity over its largest value.
fn vortices(title: &str, points: usize, vorticity: &[f64]) -> Panel {
    let place = (0..points).map(|i| 2.0 * std::f64::consts::PI * i as f64 / points as f64).collect();
    let largest = max_norm(vorticity);
    let values = vorticity.chunks(points).map(|row| row.iter().map(|w| w / largest).collect()).collect();
    map(title, place, values, vec![-0.75, -0.5, -0.25, -0.05, 0.05, 0.25, 0.5, 0.75], true)
}
