//! The steady cavity against the literature, and the cavity against CVODE.

use std::time::Instant;

use lsvi::closure::Linear;
use lsvi::solver::Augmented;
use lsvi::steady::{self, Steady, SteadyError};
use lsvi::{LeastSquaresStep, SolveError, State, StepError};

use super::lid::streamlines;
use super::profile::{Profile, Published, cavity, published};
use super::{Scale, named, observed};
use crate::chapter::StudyError;
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Outcome, Panel, Requirement, Series, Table};
use crate::measure::norm::{Extremes, distance};
use crate::problem::Problem;
use crate::reference;

/// |f| at which a flow counts as steady, in units of M ψ̇, and the steps that it may take.
const STEADY: f64 = 1e-10;
const STEPS: u64 = 400;

/// Method I from `start` to a steady state with steps of `h`.
fn march(problem: &dyn Problem, start: Vec<f64>, h: f64) -> Result<Steady, SteadyError> {
    let field = problem.field();
    let solver = problem.solver().unwrap_or_else(|| Box::new(Augmented::new()));
    let method = LeastSquaresStep::with_solver(&field, Linear::METHOD_I, solver)?;
    steady::march(method, &field, State::new(0.0, start), h, STEADY, STEPS)
}

/// ψ on twice as many cells a side, by linear interpolation.
fn refined(cells: usize, psi: &[f64]) -> Vec<f64> {
    let inside = cells - 1;
    let value = |i: usize, j: usize| {
        if i == 0 || j == 0 || i == cells || j == cells { 0.0 } else { psi[(j - 1) * inside + i - 1] }
    };
    let fine = (1..2 * cells).flat_map(|j| (1..2 * cells).map(move |i| (i, j)));
    let mean = |(i, j): (usize, usize)| {
        let ([a, b], [c, d]) = ([i / 2, i.div_ceil(2)], [j / 2, j.div_ceil(2)]);
        0.25 * (value(a, c) + value(b, c) + value(a, d) + value(b, d))
    };
    fine.map(mean).collect()
}

/// The step size to a steady state: as large as Gauss and Newton's iteration follows from rest, or from a coarser grid.
fn step_size(re: f64, from_rest: bool) -> f64 {
    match from_rest {
        true if re > 500.0 => 5.0,
        true => 20.0,
        false => 100.0,
    }
}

/// The steady flow on one grid.
struct Grid {
    cells: usize,
    steady: Steady,
    profile: Profile,
}

/// The steady flow on each of three grids, each from the one before.
fn grids(re: f64, cells: [usize; 3], evidence: &mut Evidence) -> Result<Vec<Grid>, StudyError> {
    let mut grids: Vec<Grid> = Vec::new();
    for cells in cells {
        let problem = cavity(re, cells)?;
        let start =
            grids.last().map_or_else(|| problem.initial(), |coarse| refined(coarse.cells, &coarse.steady.state.q));
        let clock = Instant::now();
        let steady = march(&*problem, start, step_size(re, grids.is_empty()))?;
        evidence.timings.push((format!("steady cavity, Re = {re}, N = {cells}"), clock.elapsed().as_secs_f64()));
        let profile = Profile::new(cells, &problem.observe(0.0, &steady.state.q));
        grids.push(Grid { cells, steady, profile });
    }
    Ok(grids)
}

/// The band of the table of Ghia et al.: their values carry the error of their own grids.
fn band(re: f64) -> f64 {
    match re {
        re if re <= 100.0 => 0.010,
        re if re <= 400.0 => 0.008,
        _ => 0.02,
    }
}

pub(super) fn steady(evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    let table = published()?;
    let (mut rows, mut reached, mut panels, mut streams) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (re, cells) in scale.steady {
        let grids = grids(*re, *cells, evidence)?;
        reached.extend(grids.iter().map(|grid| {
            let numbers = [Cell::Number(grid.steady.residual), Cell::Integer(grid.steady.steps as i64)];
            [Cell::Number(*re), Cell::Integer(grid.cells as i64)].into_iter().chain(numbers).collect()
        }));
        let [.., coarse, fine] = grids.as_slice() else { return Err("three grids".into()) };
        let extrapolated = |p: &Published| {
            let (c, f) = (coarse.profile.at(p.line, p.coord), fine.profile.at(p.line, p.coord));
            f + (f - c) / 3.0
        };
        for source in ["Ghia 1982", "Botella 1998"] {
            let values: Vec<&Published> = table.iter().filter(|p| p.re == *re && p.source == source).collect();
            if values.is_empty() {
                continue;
            }
            let off = |at: &dyn Fn(&Published) -> f64| values.iter().map(|p| (at(p) - p.velocity).abs()).largest();
            let allowed = if source == "Ghia 1982" { band(*re) } else { 0.01 };
            evidence.checks.push(Check::new(
                format!("steady/{re}/{source}"),
                format!(
                    "Steady cavity, Re = {re}, N = {}: the largest difference from {source} on both centre lines",
                    fine.cells
                ),
                off(&|p| fine.profile.at(p.line, p.coord)),
                Requirement::AtMost(allowed),
                if source == "Ghia 1982" {
                    "what the published values themselves are uncertain by, as later tables show"
                } else {
                    "the error of second order on this grid"
                },
            ));
            if source == "Botella 1998" {
                evidence.checks.push(Check::new(
                    format!("steady/{re}/richardson"),
                    format!("The same, extrapolated from N = {} and {}", coarse.cells, fine.cells),
                    off(&extrapolated),
                    Requirement::AtMost(2e-4),
                    "the errors of second order cancel; what is left is of third order, where the corners are singular",
                ));
            }
            rows.extend(values.iter().map(|p| {
                vec![
                    Cell::Number(*re),
                    Cell::Integer(fine.cells as i64),
                    Cell::Text(p.line.into()),
                    Cell::Number(p.coord),
                    Cell::Number(fine.profile.at(p.line, p.coord)),
                    Cell::Number(p.velocity),
                    Cell::Text(p.source.clone()),
                ]
            }));
        }
        for (line, x, y) in [('u', "y", "u at x = ½"), ('v', "x", "v at y = ½")] {
            let mut curves =
                vec![Series::new(format!("N = {}", fine.cells), fine.profile.line(line).to_vec(), Mark::Line)];
            for source in ["Ghia 1982", "Botella 1998"] {
                let of = |p: &&Published| p.re == *re && p.line == line && p.source == source;
                let points: Vec<_> = table.iter().filter(of).map(|p| (p.coord, p.velocity)).collect();
                if !points.is_empty() {
                    curves.push(Series::new(source, points, Mark::Markers));
                }
            }
            panels.push(Panel::new(Axis::linear(x), Axis::linear(y), curves).titled(format!("Re = {re}")));
        }
        streams.push(streamlines(&format!("Re = {re}"), fine.cells, &fine.steady.state.q));
    }
    let caption = "Steady cavity by Method I: the largest |f| that is left, in units of M ψ̇, and the steps to it, each grid from the one before.";
    evidence.tables.push(Table::new("flow-steady", caption, ["re", "cells", "residual", "steps"], reached));
    let caption = "Velocities on the centre lines of the steady cavity: computed on the finest grid, and published.";
    let columns = ["re", "cells", "line", "coord", "velocity", "published", "source"];
    evidence.tables.push(Table::data("cavity-profiles", caption, columns, rows));
    evidence.figures.push(Figure::new("cavity-profiles", caption, "cavity-profiles", panels).in_columns(2));
    let caption = "Streamlines of the steady cavity.";
    evidence.figures.push(Figure::new("flow-steady-streamlines", caption, "flow-steady", streams).in_columns(3));
    evidence.checks.push(spurious()?);
    Ok(())
}

/// Where the minimum of the action at a step too long for the grid is no steady flow.
fn spurious() -> Result<Check, StudyError> {
    const H: f64 = 1e3;
    let problem = cavity(1000.0, 32)?;
    let statement = "Re = 1000 on 32² cells with h = 1000: the minimum of the action to which the flow from rest descends has |f| ≠ 0 \
                     and is refused; |f| there";
    Ok(match march(&*problem, problem.initial(), H) {
        Err(
            SteadyError::Spurious { residual: rate, .. }
            | SteadyError::Step(StepError::Solve { source: SolveError::Stalled { rate, .. }, .. }),
        ) => Check::new(
            "steady/spurious",
            statement,
            rate,
            Requirement::AtLeast(1e6 * STEADY),
            "(2M − h Jᵀ) M⁻¹f = 0 has roots with f ≠ 0 where hM⁻¹J has the eigenvalue 2",
        ),
        other => {
            Check::undecided("steady/spurious", statement, Outcome::Fail, format!("{:?}", other.map(|s| s.residual)))
        }
    })
}

/// CVODE on the same semi-discrete cavity, written by hand.
pub(super) fn cross_check(evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    const END: f64 = 1.0;
    let problem = cavity(100.0, scale.reference)?;
    let statement = format!("Method I and CVODE agree on the cavity of {} cells a side at t = {END}", scale.reference);
    let Some(cvode) = reference::by_name("cvode-bdf") else { return Err("no reference of that name".into()) };
    let clock = Instant::now();
    let found = match cvode.solve(problem.ode(), 0.0, &problem.initial(), &[END]) {
        Ok(found) => found,
        Err(error) => {
            evidence.checks.push(Check::undecided("cvode", statement, Outcome::NotRun, error.to_string()));
            return Ok(());
        }
    };
    evidence.timings.push(("cavity by CVODE, two tolerances".into(), clock.elapsed().as_secs_f64()));
    let mut rows = vec![vec![
        Cell::Text("cvode-bdf".into()),
        Cell::Empty,
        Cell::Integer(found.work.steps as i64),
        Cell::Empty,
        Cell::Number(found.bound[0]),
    ]];
    let truth = problem.observe(END, &found.states[0]);
    // Differences of ψ, each wrong by the bound, over Δx.
    let bound = 2.0 * scale.reference as f64 * found.bound[0];
    let method = named("method-i")?;
    let mut ends: Vec<Vec<f64>> = Vec::new();
    for steps in [32_u32, 64, 128] {
        let clock = Instant::now();
        let end = observed(&*problem, &*method, END / f64::from(steps), END)?;
        evidence.timings.push((format!("cavity by Method I, {steps} steps"), clock.elapsed().as_secs_f64()));
        // Of second order: a third of the difference from half as many steps.
        let predicted = ends.last().map_or(f64::NAN, |last| distance(last, &end) / 3.0);
        rows.push(vec![
            Cell::Text("method-i".into()),
            Cell::Number(END / f64::from(steps)),
            Cell::Integer(i64::from(steps)),
            Cell::Number(distance(&end, &truth)),
            Cell::found(predicted),
        ]);
        ends.push(end);
    }
    let [.., coarse, fine] = ends.as_slice() else { return Err("three runs".into()) };
    let predicted = distance(coarse, fine) / 3.0;
    evidence.checks.push(Check::new(
        "cvode",
        statement,
        distance(fine, &truth) / (predicted + bound),
        Requirement::AtMost(1.25),
        "the difference over what Method I's own two runs predict and CVODE's bound; a quarter for the terms beyond the second order",
    ));
    let caption = format!(
        "The same semi-discrete cavity of {} cells a side, Re = 100, at t = {END}, by Method I and by CVODE: the largest difference of a \
         velocity, and what each expects its own error to be.",
        scale.reference
    );
    evidence.tables.push(Table::new("flow-cvode", caption, ["method", "h", "steps", "difference", "own_bound"], rows));
    Ok(())
}
