//! Energy, enstrophy and error of periodic flows, in both metrics.

use std::sync::Arc;

use super::{Context, Scale, StudyError, brief, contest, map, prose, short};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Requirement, Series, Table};
use crate::experiment::flow::log_log;
use crate::experiment::flow::periodic::{
    Change, END, Found, GridError, METHODS, PeriodicErrors, RE, Row, WithoutViscosity,
};
use crate::experiment::flow::stops::Stops;
use crate::measure::norm::{Extremes, max_norm};
use crate::row;

const FLOWS: [&str; 2] = ["shear-layer", "turbulence-2d"];

/// A short run, with steps from 1/20.
fn short_run(flow: &'static str, points: usize) -> PeriodicErrors {
    PeriodicErrors { flow, points, end: END, longest: 0.05 }
}

/// Thin shear layers until they have rolled up.
fn rolled_up(points: usize) -> PeriodicErrors {
    PeriodicErrors { flow: "shear-layer thickness=0.21", points, end: 8.0, longest: 0.1 }
}

/// Runs on all flows and grids.
struct Runs {
    cases: Vec<PeriodicErrors>,
    found: Vec<Arc<Found>>,
}

impl Runs {
    fn new(context: &Context, scale: &Scale) -> Result<Self, StudyError> {
        let short_runs = scale.points.iter().flat_map(|points| FLOWS.map(|flow| short_run(flow, *points)));
        let cases: Vec<PeriodicErrors> = short_runs.chain(scale.rolled.map(rolled_up)).collect();
        Ok(Self { found: context.get_each(cases.clone())?, cases })
    }

    /// Those of a flow on its finest grid.
    fn of(&self, flow: &str) -> Result<&Found, StudyError> {
        let found = self.cases.iter().zip(&self.found).rfind(|(case, _)| case.flow == flow).map(|(_, found)| &**found);
        found.ok_or_else(|| "no such flow".into())
    }

    /// That with the finest step.
    fn finest(&self, flow: &str, (method, metric): (&str, &str)) -> Result<&Row, StudyError> {
        row_of(self.of(flow)?, method, metric, finest()).ok_or_else(|| "no such run".into())
    }

    /// The error of a run over that of another, both with the finest step.
    fn over(&self, flow: &str, a: (&str, &str), b: (&str, &str)) -> Result<f64, StudyError> {
        Ok(self.finest(flow, a)?.error / self.finest(flow, b)?.error)
    }
}

/// The finest step of the short runs.
fn finest() -> f64 {
    let [_, _, finest] = short_run("", 0).steps();
    finest
}

/// The error of Method I over that of TR-BDF2 on each of the flows, with the finest step.
pub(super) fn over_tr_bdf2(context: &Context, scale: &Scale) -> Result<[f64; 2], StudyError> {
    let runs = Runs::new(context, scale)?;
    let [shear, turbulence] = FLOWS.map(|flow| runs.over(flow, OURS, ("tr-bdf2", "velocity")));
    Ok([shear?, turbulence?])
}

/// What becomes of Method II on shear layers of 32² points, whatever the step.
fn method_ii(context: &Context) -> Result<String, StudyError> {
    const STEPS: [f64; 3] = [0.1, 0.01, 0.001];
    let found = context.get_each(STEPS.map(|h| Stops { flow: "shear-layer cells=32", h }).into())?;
    let residuals: Option<Vec<f64>> = found.iter().map(|residual| **residual).collect();
    Ok(residuals.map_or_else(
        || "Method II takes a step of one of these sizes on the shear layers.".into(),
        |residuals| {
            format!(
                "Method II does not start on the shear layers of 32² points: with steps of {} its linear solver stops at a relative residual of {}, \
                 since its matrix tends to a multiple of Jᵀ, which no preconditioner here knows.",
                STEPS.map(short).join(", "),
                residuals.iter().map(|residual| brief(*residual)).collect::<Vec<_>>().join(", ")
            )
        },
    ))
}

const OURS: (&str, &str) = ("method-i", "velocity");

/// Errors of all methods against step size and work.
pub(super) fn errors(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    let runs = Runs::new(context, scale)?;
    let Runs { cases, found } = &runs;
    let (mut rows, mut curves, mut costs, mut maps) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (case, found) in cases.iter().zip(found) {
        let PeriodicErrors { flow, points, end, .. } = *case;
        evidence.checks.extend(judged(case, found)?);
        rows.extend(found.rows.iter().map(|r| {
            let [energy, enstrophy] = r.balance;
            let numbers = [r.error, r.energy, r.enstrophy, energy, enstrophy].map(Cell::found);
            let counts = [r.cost.solves, r.cost.inner, r.evaluations].map(Cell::from);
            row![flow, points, end, r.method, r.metric, r.h].into_iter().chain(numbers).chain(counts).collect()
        }));
        let name = flow.split(' ').next().unwrap_or(flow);
        let title = format!("{name}, {points}², t = {end}");
        if points >= scale.points.iter().copied().max().unwrap_or(0) || end > END {
            let seconds = found.rows.iter().filter(|r| r.error.is_finite());
            evidence.timings.extend(
                seconds.map(|r| {
                    (format!("{title}, {} in the {} metric, h = {}", r.method, r.metric, r.h), r.cost.seconds)
                }),
            );
            costs.push(
                curves_of(found, Axis::log("evaluations of f, J·x and Jᵀ·x"), |r| r.evaluations as f64)
                    .titled(title.clone()),
            );
            maps.push(vortices(&title, points, &found.reference));
        }
        curves.push(curves_of(found, Axis::log("h"), |r| r.h).titled(title));
    }
    let [shear, turbulence] = FLOWS;
    let rule = ("tr-bdf2", "velocity");
    let ratio = |flow, a, b| runs.over(flow, a, b).map(short);
    let values = [
        ("tr_bdf2", contest(&over_tr_bdf2(context, scale)?)),
        ("points", scale.points.last().ok_or("no grid")?.to_string()),
        ("re", short(RE)),
        ("end", short(END)),
        ("h", short(finest())),
        ("shear_tr_bdf2", ratio(shear, OURS, rule)?),
        ("turbulence_tr_bdf2", ratio(turbulence, OURS, rule)?),
        ("turbulence_trapezoidal", ratio(turbulence, OURS, ("trapezoidal", "velocity"))?),
        ("turbulence_euler", ratio(turbulence, ("implicit-euler", "velocity"), OURS)?),
    ];
    evidence.notes.extend(prose::fill(include_str!("periodic.md"), &values)?);
    let work = |flow| Ok::<_, StudyError>(brief(equal_work(runs.of(flow)?, "tr-bdf2")));
    let own = runs.finest(shear, OURS)?;
    let cheapest = cheapest(runs.of(shear)?, own).ok_or("RK4 is nowhere ahead")?;
    evidence.checks.push(explicit(cheapest, own));
    let values = [
        ("points", scale.points.last().ok_or("no grid")?.to_string()),
        ("shear", work(shear)?),
        ("turbulence", work(turbulence)?),
        ("rk4", brief(cheapest.error)),
        ("rk4_evaluations", cheapest.evaluations.to_string()),
        ("own", brief(own.error)),
        ("own_evaluations", own.evaluations.to_string()),
        ("method_ii", method_ii(context)?),
    ];
    evidence.notes.extend(prose::fill(include_str!("evaluations.md"), &values)?);
    for (case, found) in cases.iter().zip(found).filter(|(case, _)| case.end > END) {
        rolled(context, evidence, case, found)?;
    }
    let caption = format!(
        "Periodic flows at Re = {RE} and time t on grids of points² points, by metric of the residual. Errors are relative and against RK4 with half the finest step: of the vorticity, root mean \
         square, and of energy E and enstrophy Z. The balances Ė = −2νZ and Ż = −2νP are integrated over the steps of a run by Simpson's rule; \
         the columns of balances have what it leaves of them, in units of E and Z at the start. Counted are linear systems, \
         iterations of conjugate gradients or GMRES in them, and evaluations of f with products of its Jacobian and the transpose, which \
         take as many transforms each. A run of RK4 with steps too long for the grid has no numbers."
    );
    let columns = [
        "flow",
        "points",
        "t",
        "method",
        "metric",
        "h",
        "error",
        "energy",
        "enstrophy",
        "energy_balance",
        "enstrophy_balance",
        "solves",
        "inner",
        "evaluations",
    ];
    evidence.tables.push(Table::new("flow-periodic", caption, columns, rows));
    let caption = format!(
        "Relative error of the vorticity of the periodic flows at Re = {RE}, root mean square, against step size. All lines but those of \
         implicit Euler and RK4 have the same slope, that of second order: what separates them is a factor at every step size."
    );
    evidence.figures.push(Figure::new("flow-periodic", caption, "flow-periodic", curves).in_columns(2));
    let caption = format!(
        "The same errors against what they cost: evaluations of f and products with its Jacobian and the transpose, Re = {RE}. Lower left is better."
    );
    evidence.figures.push(Figure::new("flow-periodic-work", caption, "flow-periodic", costs).in_columns(2));
    let caption = format!(
        "The vorticity of the periodic flows at Re = {RE}, over its largest value, from the reference: shear layers, which at t = {END} have not \
         rolled up, and decaying turbulence with its eddies and the sheets between them{}.",
        if scale.rolled.is_some() {
            "; thinner shear layers later, rolled up into two vortices with braids between them"
        } else {
            ""
        }
    );
    evidence.figures.push(Figure::new("flow-vorticity", caption, "flow-periodic", maps).in_columns(2));
    Ok(())
}

fn row_of<'f>(found: &'f Found, method: &str, metric: &str, h: f64) -> Option<&'f Row> {
    found.rows.iter().find(|row| (row.method, row.metric, row.h) == (method, metric, h))
}

/// The explicit method's longest step that holds, beside a run of Method I.
fn cheapest<'f>(found: &'f Found, own: &Row) -> Option<&'f Row> {
    let holds = found.rows.iter().filter(|row| row.method == "rk4" && row.error < own.error);
    holds.min_by(|a, b| a.evaluations.cmp(&b.evaluations))
}

/// That the one costs less than the other.
fn explicit(cheapest: &Row, own: &Row) -> Check {
    Check::new(
        "periodic/explicit",
        "The cheapest run of RK4 on the shear layers that is ahead of Method I's best takes fewer evaluations: their ratio",
        cheapest.evaluations as f64 / own.evaluations as f64,
        Requirement::Below(1.0),
        "what the chapter says; the flow is not stiff at this resolution",
    )
}

/// The error of Method I over that of a rule with as many evaluations as the two have in common, log-log between runs.
fn equal_work(found: &Found, rule: &str) -> f64 {
    let runs = |method: &str| -> Vec<(f64, f64)> {
        let of = found.rows.iter().filter(|r| (r.method, r.metric) == (method, "velocity"));
        of.map(|r| (r.evaluations as f64, r.error)).collect()
    };
    let (own, rule) = (runs("method-i"), runs(rule));
    let last = |runs: &[(f64, f64)]| runs.last().map_or(f64::NAN, |run| run.0);
    let work = last(&own).min(last(&rule));
    let at = |runs: &[(f64, f64)]| log_log(runs, work).unwrap_or(f64::NAN);
    at(&own) / at(&rule)
}

/// Shear layers that have rolled up.
fn rolled(context: &Context, evidence: &mut Evidence, case: &PeriodicErrors, found: &Found) -> Result<(), StudyError> {
    let [.., finest] = case.steps();
    let error = |method: &str| row_of(found, method, "velocity", finest).map_or(f64::NAN, |row| row.error);
    let grid = *context.get(GridError { of: *case })?;
    evidence.checks.push(resolved(case.points, grid, error("method-i")));
    let ratio = |method: &str| brief(error("method-i") / error(method));
    let values = [
        ("points", case.points.to_string()),
        ("end", short(case.end)),
        ("h", short(finest)),
        ("grid", short(grid)),
        ("own", short(error("method-i"))),
        ("tr_bdf2", ratio("tr-bdf2")),
        ("rule", ratio("trapezoidal")),
        ("euler", brief(error("implicit-euler") / error("method-i"))),
        ("work", brief(equal_work(found, "tr-bdf2"))),
        ("flow", case.flow.replacen(' ', " --set ", 1)),
    ];
    evidence.notes.extend(prose::fill(include_str!("rolled.md"), &values)?);
    Ok(())
}

/// What a grid leaves of an error in time.
fn resolved(points: usize, grid: f64, error: f64) -> Check {
    Check::new(
        "periodic/rolled-up/resolved",
        format!(
            "The rolled-up shear layers are resolved on {points}² points: what twice as many change, over Method I's error"
        ),
        grid / error,
        Requirement::AtMost(0.1),
        "a tenth of an error in time changes no conclusion",
    )
}

/// The reference, the orders, and the balances of a flow on a grid.
fn judged(case: &PeriodicErrors, found: &Found) -> Result<Vec<Check>, StudyError> {
    let [_, coarser, finest] = case.steps();
    let name = case.flow.split(' ').next().unwrap_or(case.flow);
    let setting = match case.end > END {
        true => format!("{name}/{}/rolled-up", case.points),
        false => format!("{name}/{}", case.points),
    };
    let of = |metric: &str, h: f64| row_of(found, "method-i", metric, h).ok_or("no such run");
    let smallest = found.rows.iter().filter(|row| row.method != "rk4").map(|row| row.error).smallest();
    let mut checks = vec![Check::new(
        format!("periodic/{setting}/reference"),
        format!("RK4 is a reference on {setting}: its error over the smallest of the others"),
        found.reference_error / smallest,
        Requirement::AtMost(0.01),
        "a hundredth of an error moves no order by more than that; RK4's own, by two step sizes",
    )];
    for metric in ["velocity", "vorticity"] {
        checks.push(Check::new(
            format!("periodic/{setting}/order/{metric}"),
            format!("Method I converges on {setting} with order 2 in the {metric} metric"),
            (of(metric, coarser)?.error / of(metric, finest)?.error).log2(),
            Requirement::Near(2.0, 0.2),
            "from the two finest steps, where the next term of the error, at most 15 per cent of it, moves log₂ by no more",
        ));
    }
    for (place, what) in ["energy", "enstrophy"].into_iter().enumerate() {
        checks.push(Check::new(
            format!("periodic/{setting}/balance/{what}/reference"),
            format!("The reference keeps the balance of {what} on {setting}: what it leaves of it over the smallest error of the others"),
            found.reference_balance[place].abs() / smallest,
            Requirement::AtMost(0.01),
            "a hundredth of what is compared by it; RK4 and Simpson's rule are of fourth order, so that an equation without a term too many or too few leaves less",
        ));
    }
    Ok(checks)
}

/// Error against step size, or what runs cost, of all methods.
fn curves_of(found: &Found, axis: Axis, of_run: fn(&Row) -> f64) -> Panel {
    let curves = METHODS.iter().map(|(method, metric)| {
        let of = |row: &&Row| (row.method, row.metric) == (*method, *metric);
        let label = if *metric == "velocity" { (*method).to_owned() } else { format!("{method}, {metric}") };
        let points =
            found.rows.iter().filter(of).filter(|row| row.error.is_finite()).map(|row| (of_run(row), row.error));
        Series::new(label, points.collect(), Mark::LineMarkers)
    });
    Panel::new(axis, Axis::log("error, relative r.m.s."), curves.collect())
}

/// The same where the layers have rolled up.
fn metric_where_rolled_up(case: &PeriodicErrors, found: &Found) -> Option<String> {
    let [.., finest] = case.steps();
    let [own, other] = ["velocity", "vorticity"].map(|metric| row_of(found, "method-i", metric, finest));
    Some(format!(
        " On shear layers that have rolled up, with h = {}, the vorticity metric has {} of the error; as for the enstrophy, {}.",
        short(finest),
        brief(other?.error / own?.error),
        enstrophies(found)
    ))
}

/// What measuring the residual by vorticity does to errors.
pub(super) fn metric(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    let runs = Runs::new(context, scale)?;
    let [shear, turbulence] = FLOWS;
    let other = ("method-i", "vorticity");
    let ratio = |flow| runs.over(flow, other, OURS).map(short);
    let short_flow = |flow: &str| {
        let case = runs.cases.iter().zip(&runs.found).rfind(|(case, _)| case.flow == flow && case.end == END);
        case.map(|(_, found)| enstrophies(found)).ok_or("no such flow")
    };
    let rolled = runs.cases.iter().zip(&runs.found).find(|(case, _)| case.end > END);
    let rolled = rolled.and_then(|(case, found)| metric_where_rolled_up(case, found));
    let values = [
        ("h", short(finest())),
        ("shear_metric", ratio(shear)?),
        ("turbulence_metric", ratio(turbulence)?),
        ("shear_enstrophy", short_flow(shear)?),
        ("turbulence_enstrophy", short_flow(turbulence)?),
        ("rolled", rolled.unwrap_or_default()),
    ];
    evidence.notes.extend(prose::fill(include_str!("metric.md"), &values)?);
    let balance = |flow, of_what: usize| runs.finest(flow, OURS).map(|row| short(row.balance[of_what].abs()));
    let values = [
        ("h", short(finest())),
        ("shear_energy_balance", balance(shear, 0)?),
        ("shear_enstrophy_balance", balance(shear, 1)?),
        ("turbulence_energy_balance", balance(turbulence, 0)?),
        ("turbulence_enstrophy_balance", balance(turbulence, 1)?),
    ];
    evidence.notes.extend(prose::fill(include_str!("balance.md"), &values)?);
    Ok(())
}

/// The relative errors of the enstrophy in the two metrics with the shortest steps; where one of them passes zero with h, it is small by
/// chance, and nothing follows from its size.
fn enstrophies(found: &Found) -> String {
    let [own, other] = ["velocity", "vorticity"].map(|metric| -> Vec<f64> {
        let of = found.rows.iter().filter(|row| (row.method, row.metric) == ("method-i", metric));
        of.map(|row| row.enstrophy).collect()
    });
    let passes_zero = |errors: &[f64]| errors.windows(2).any(|pair| (pair[0] > 0.0) != (pair[1] > 0.0));
    let place = match (passes_zero(&own), passes_zero(&other)) {
        (false, false) => {
            let [own, other] = [own, other].map(|errors| brief(errors.last().copied().unwrap_or(f64::NAN)));
            return format!("its error is {other} instead of {own}");
        }
        (true, false) => "in the velocity metric",
        (false, true) => "in that of the vorticity",
        (true, true) => "in both metrics",
    };
    format!("the two cannot be compared, as with h the error passes zero {place}")
}

/// The implicit midpoint rule keeps energy and enstrophy, quadratic forms that the dealiased equations conserve.
pub(super) fn without_viscosity(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    let [points, ..] = scale.points else { return Err("no grid".into()) };
    let found = context.get(WithoutViscosity { points: *points })?;
    let caption = format!(
        "The shear layer without viscosity, which keeps both: relative change of energy and of enstrophy after ten steps of h = {}.",
        WithoutViscosity::H
    );
    let rows = found.iter().map(|c| row![c.method, c.metric, c.energy, c.enstrophy]).collect();
    let columns = ["method", "metric", "energy", "enstrophy"];
    let table = Table::new("flow-conservation", caption, columns, rows);
    let change = |method: &str, metric: &str| {
        let found = found.iter().find(|change| (change.method, change.metric) == (method, metric));
        short(found.map_or(f64::NAN, |change| change.energy))
    };
    let values = [
        ("points", points.to_string()),
        ("h", short(WithoutViscosity::H)),
        ("end", short(END)),
        ("method_i", change("method-i", "velocity")),
        ("vorticity", change("method-i", "vorticity")),
        ("trapezoidal", change("trapezoidal", "velocity")),
        ("tr_bdf2", change("tr-bdf2", "velocity")),
        ("midpoint", change("implicit-midpoint", "velocity")),
        ("euler", change("implicit-euler", "velocity")),
    ];
    evidence.checks.push(kept(&found));
    evidence.tables.push(table);
    evidence.notes.extend(prose::fill(include_str!("conservation.md"), &values)?);
    Ok(())
}

/// That one method keeps both.
fn kept(found: &[Change]) -> Check {
    let kept = found.iter().find(|change| change.method == "implicit-midpoint");
    Check::new(
        "periodic/conservation",
        "Without viscosity the implicit midpoint rule keeps energy and enstrophy of the dealiased equations: relative change",
        kept.map_or(f64::NAN, |change| max_norm(&[change.energy, change.enstrophy])),
        Requirement::AtMost(1e-8),
        "it keeps quadratic invariants; the tolerance of the solver is 1e-10 a step, and there are ten",
    )
}

/// A map of the vorticity over its largest value.
fn vortices(title: &str, points: usize, vorticity: &[f64]) -> Panel {
    // The last are the first again.
    let place: Vec<f64> = (0..=points).map(|i| 2.0 * std::f64::consts::PI * i as f64 / points as f64).collect();
    let largest = max_norm(vorticity);
    let at = |i: usize, j: usize| vorticity[j % points * points + i % points] / largest;
    let values: Vec<Vec<f64>> = (0..=points).map(|j| (0..=points).map(|i| at(i, j)).collect()).collect();
    map(title, &place, &values, vec![-0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75], true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;
    use crate::experiment::flow::Cost;

    fn row(method: &'static str, (h, error): (f64, f64), evaluations: u64) -> Row {
        let balance = [error, 2.0 * error];
        Row {
            method,
            metric: "velocity",
            h,
            error,
            energy: 0.0,
            enstrophy: 0.0,
            balance,
            evaluations,
            cost: Cost::default(),
        }
    }

    /// Method I in both metrics with errors h², and RK4, a reference that is as good as they ask for.
    fn found(case: &PeriodicErrors) -> Found {
        let own = case.steps().map(|h| row("method-i", (h, h * h), (10.0 / h) as u64));
        let other = own.clone().map(|row| Row { metric: "vorticity", ..row });
        let [.., finest] = own.each_ref().map(|row| row.error);
        Found {
            rows: own.into_iter().chain(other).collect(),
            reference: Vec::new(),
            reference_error: 1e-3 * finest,
            reference_balance: [1e-3 * finest, 2e-3 * finest],
        }
    }

    /// Observed row by row, along x first; the last row and column are the first again.
    #[test]
    fn a_map_of_vorticity_has_its_rows_along_x() {
        let points = 4;
        let values: Vec<f64> = (0..16).map(|k| f64::from(k) / 15.0).collect();
        let field = vortices("", points, &values).field.expect("a map");
        let parts = (field.x.len() - 1) / points;
        for (j, row) in field.values.iter().step_by(parts).enumerate() {
            for (i, value) in row.iter().step_by(parts).enumerate() {
                assert_eq!(*value, values[j % points * points + i % points], "({i}, {j})");
            }
        }
        assert_eq!((field.values.len() - 1) / parts, points);
    }

    #[test]
    fn enstrophies_are_compared_only_where_neither_passes_zero() {
        let said = |own: [f64; 3], other: [f64; 3]| {
            let mut runs = found(&short_run("shear-layer", 8));
            for (row, enstrophy) in runs.rows.iter_mut().zip(own.into_iter().chain(other)) {
                row.enstrophy = enstrophy;
            }
            enstrophies(&runs)
        };
        let (kept, crossed) = ([4e-8, 1e-8, 3e-9], [4e-8, 1e-8, -3e-9]);
        assert_eq!(said(kept, [-8e-8, -4e-8, -2e-8]), "its error is −2×10⁻⁸ instead of 3×10⁻⁹");
        assert!(said(crossed, kept).ends_with("passes zero in the velocity metric"));
        assert!(said(kept, crossed).ends_with("passes zero in that of the vorticity"));
        assert!(said(crossed, crossed).ends_with("passes zero in both metrics"));
    }

    #[test]
    fn the_metric_of_the_vorticity_is_told_by_its_share_of_the_error() {
        let case = rolled_up(8);
        let mut runs = found(&case);
        for row in runs.rows.iter_mut().filter(|row| row.metric == "vorticity") {
            row.error *= 2.5;
        }
        let said = metric_where_rolled_up(&case, &runs).expect("both are there");
        assert!(said.contains("with h = 0.025, the vorticity metric has 2.5 of the error"), "{said}");
        // A curve that names no metric is of that of the velocity.
        let panel = curves_of(&runs, Axis::log("h"), |row| row.h);
        for (label, factor) in [("method-i", 1.0), ("method-i, vorticity", 2.5)] {
            let curve = panel.series.iter().find(|series| series.label == label).expect(label);
            assert_eq!(curve.points, case.steps().map(|h| (h, factor * (h * h))), "{label}");
        }
    }

    #[test]
    fn checks_of_the_explicit_method_of_the_grid_and_of_conservation_fall_with_what_they_say() {
        let own = row("method-i", (0.1, 1e-6), 1000);
        let mut runs = found(&short_run("shear-layer", 8));
        runs.rows = vec![row("rk4", (0.1, 1e-5), 10), row("rk4", (0.1, 1e-8), 900), row("rk4", (0.1, 1e-9), 1800)];
        let cheapest = cheapest(&runs, &own).expect("one is ahead").clone();
        assert_eq!((cheapest.evaluations, explicit(&cheapest, &own).outcome), (900, Outcome::Pass));
        assert_eq!(explicit(&Row { evaluations: 1000, ..cheapest }, &own).outcome, Outcome::Fail);
        assert_eq!([0.9e-7, 1.1e-7].map(|grid| resolved(8, grid, 1e-6).outcome), [Outcome::Pass, Outcome::Fail]);
        assert_ne!(resolved(8, f64::NAN, 1e-6).outcome, Outcome::Pass);
        let outcome = |method: &'static str, energy: f64, enstrophy: f64| {
            let change = |method, energy, enstrophy| Change { method, metric: "velocity", energy, enstrophy };
            kept(&[change("method-i", 1.0, 1.0), change(method, energy, enstrophy)]).outcome
        };
        assert_eq!(outcome("implicit-midpoint", -0.9e-8, 0.9e-8), Outcome::Pass);
        assert_eq!(outcome("implicit-midpoint", -1.1e-8, 0.0), Outcome::Fail);
        assert_eq!(outcome("implicit-midpoint", 0.0, 1.1e-8), Outcome::Fail);
        assert_ne!(outcome("trapezoidal", 0.0, 0.0), Outcome::Pass);
    }

    #[test]
    fn at_equal_work_errors_are_compared_on_their_power_laws() {
        // 8/n² of the one, 2/n² of the other, as far as both have come.
        let own = [10, 20, 40].map(|n| row("method-i", (1.0, 8.0 / f64::from(n).powi(2)), n as u64));
        let rule = [15, 30, 60].map(|n| row("tr-bdf2", (1.0, 2.0 / f64::from(n).powi(2)), n as u64));
        let (reference, balance) = (Vec::new(), [0.0; 2]);
        let found = Found {
            rows: own.into_iter().chain(rule).collect(),
            reference,
            reference_error: 0.0,
            reference_balance: balance,
        };
        approx::assert_relative_eq!(equal_work(&found, "tr-bdf2"), 4.0, max_relative = 1e-12);
        assert!(equal_work(&found, "bdf2").is_nan());
    }

    /// The ends of the names of the checks that do not pass.
    fn refused(found: &Found, case: &PeriodicErrors) -> Vec<String> {
        let checks = judged(case, found).expect("all runs are there");
        let refused = checks.into_iter().filter(|check| check.outcome != Outcome::Pass);
        refused.map(|check| check.id.replace("periodic/shear-layer/8/", "")).collect()
    }

    #[test]
    fn each_check_judges_what_it_names_and_nothing_else() {
        let case = short_run("shear-layer", 8);
        assert_eq!(refused(&found(&case), &case), [""; 0]);
        for (place, what) in ["energy", "enstrophy"].into_iter().enumerate() {
            let mut wrong = found(&case);
            wrong.reference_balance[place] *= -20.0;
            assert_eq!(refused(&wrong, &case), [format!("balance/{what}/reference")]);
        }
        for metric in ["velocity", "vorticity"] {
            let mut wrong = found(&case);
            for row in wrong.rows.iter_mut().filter(|row| row.metric == metric && row.h == case.steps()[1]) {
                row.error *= 2.0;
            }
            assert_eq!(refused(&wrong, &case), [format!("order/{metric}")]);
        }
        let mut wrong = found(&case);
        wrong.reference_error *= 20.0;
        assert_eq!(refused(&wrong, &case), ["reference"]);
    }

    /// The sentences of the full chapter about layers that have rolled up, on a small grid, from the rows of the table.
    #[test]
    fn what_is_said_of_rolled_up_layers_is_in_the_table() {
        let scale = Scale { points: &[8], rolled: Some(8), ..super::super::SMALL };
        let (context, mut evidence) = (Context::quick(), Evidence::default());
        errors(&context, &mut evidence, &scale).expect("they run");
        metric(&context, &mut evidence, &scale).expect("they ran");
        let table = &evidence.tables[0];
        let place = |name: &str| table.column(name).expect("a column");
        let of = |method: &str, metric: &str, column: &str| -> Vec<f64> {
            let is_it = |row: &&Vec<Cell>| {
                let texts = [row[place("method")].to_string(), row[place("metric")].to_string()];
                row[place("t")] == Cell::Number(8.0) && texts == [method, metric]
            };
            table.rows.iter().filter(is_it).map(|row| row[place(column)].number().expect("a number")).collect()
        };
        let last = |method: &str| of(method, "velocity", "error")[2];
        // Both axes logarithmic, at the evaluations of the shorter of the two last runs.
        let at = |method: &str, work: f64| {
            let [works, errors] = ["evaluations", "error"].map(|column| of(method, "velocity", column));
            let k = if work <= works[1] { 0 } else { 1 };
            let slope = (errors[k + 1] / errors[k]).ln() / (works[k + 1] / works[k]).ln();
            errors[k] * (work / works[k]).powf(slope)
        };
        let work = of("method-i", "velocity", "evaluations")[2].min(of("tr-bdf2", "velocity", "evaluations")[2]);
        let grid = *context.get(GridError { of: rolled_up(8) }).expect("it runs");
        let own = last("method-i");
        let expected = format!(
            "at t = 8. On 8² points, where twice as many change the vorticity by {}, the error of Method I with h = 0.025 is {}: {} times \
             that of TR-BDF2 at equal steps and {} times at equal evaluations, and {} times that of the trapezoidal rule at equal steps; \
             implicit Euler has {} times its error. Look at them with `verify solve --problem shear-layer --set thickness=0.21 --set",
            short(grid),
            short(own),
            brief(own / last("tr-bdf2")),
            brief(at("method-i", work) / at("tr-bdf2", work)),
            brief(own / last("trapezoidal")),
            brief(last("implicit-euler") / own)
        );
        let said = |text: &str| evidence.notes.iter().any(|note| note.contains(text));
        assert!(said(&expected), "{expected}\n{:#?}", evidence.notes);
        let other = |column: &str| of("method-i", "vorticity", column)[2];
        let expected = format!(
            "with h = 0.025, the vorticity metric has {} of the error; as for the enstrophy, ",
            brief(other("error") / own)
        );
        assert!(said(&expected), "{expected}\n{:#?}", evidence.notes);
    }
}
