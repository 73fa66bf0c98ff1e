//! Orders in time and in space of flows between two plates.

use rayon::prelude::*;

use super::parts::order_check;
use super::{Context, Study, StudyError};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Requirement, Series, Table};
use crate::kinds::Principle;
use crate::measure::norm::{Extremes, distance, larger};
use crate::measure::order::{Expectation, OrderFit, Sample, Verdict, fit};
use crate::method;
use crate::order::{Source, Truth, measure};
use crate::problem::{self, Problem};
use crate::run::run;
use crate::theory::order_plan;

pub(super) const STUDY: Study = Study {
    id: "channel-orders",
    title: "Orders of a discretised channel",
    question: "With which order does Method I follow a flow in N cells, in time and in space, and where is the order lost?",
    source: "[S24] Section 5, its outlook on finite volumes and shape functions; claims j, k",
    run: study,
};

const FLOWS: [&str; 4] = ["channel-poiseuille", "channel-couette", "channel-womersley", "channel-stokes2"];

fn study(context: &Context) -> Result<Evidence, StudyError> {
    context.announce(5);
    let mut evidence = Evidence { notes: notes(), ..Evidence::default() };
    let mut panels = vec![in_time(&mut evidence)?];
    context.tick();
    panels.push(maxima(&mut evidence)?);
    context.tick();
    panels.push(in_space(&mut evidence)?);
    context.tick();
    panels.push(by_modes(&mut evidence)?);
    context.tick();
    without_diffusion(&mut evidence)?;
    ansatz(&mut evidence)?;
    context.tick();
    evidence.figures.push(Figure {
        id: "channel-orders".into(),
        caption:
            "Errors of flows in a channel: of Method I in time at t = 1 (32 cells), its maximum over all steps (128 \
                  cells), of the discretisations in space at t = 1 (Poiseuille), and of the spectral one in all flows."
                .into(),
        data: "channel-order-points".into(),
        panels,
        columns: 2,
    });
    Ok(evidence)
}

/// The flow in `cells` cells of a scheme.
fn channel(flow: &str, scheme: &str, cells: usize) -> Result<Box<dyn Problem>, StudyError> {
    Ok(problem::build_setting(&format!("{flow} scheme={scheme} cells={cells}"))?)
}

/// The solution of the system that is discretised in space, at time t.
fn semi_discrete(problem: &dyn Problem, t: f64) -> Result<Vec<f64>, StudyError> {
    Ok((problem.limit(Principle::Equation).exact)(t).ok_or("the system is small")?)
}

/// The error of the discretisation in space at time t.
fn space_error(problem: &dyn Problem, t: f64) -> Result<f64, StudyError> {
    let observed = problem.observe(t, &semi_discrete(problem, t)?);
    Ok(distance(&observed, &problem.exact(t).ok_or("the flow is known")?))
}

/// Adds the points of a fit to the data and returns them as a curve.
fn curve(evidence: &mut Evidence, what: &str, label: &str, fit: &OrderFit) -> Series {
    let measured =
        fit.points().into_iter().filter_map(|(sample, _)| Some((sample.h, sample.result.as_ref().ok()?.error)));
    let mut points: Vec<(f64, f64)> = measured.collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    add_points(evidence, what, label, &points);
    Series::new(label, points, Mark::LineMarkers)
}

fn add_points(evidence: &mut Evidence, what: &str, label: &str, points: &[(f64, f64)]) {
    const ID: &str = "channel-order-points";
    if !evidence.tables.iter().any(|table| table.id == ID) {
        let caption = "Errors behind the orders: of time steps h, of cells of length h, of N modes.";
        evidence.tables.push(Table::data(ID, caption, &["error_of", "case", "h_or_n", "error"], Vec::new()));
    }
    if let Some(table) = evidence.tables.iter_mut().find(|table| table.id == ID) {
        let row = |(h, e): &(f64, f64)| {
            vec![Cell::Text(what.into()), Cell::Text(label.into()), Cell::Number(*h), Cell::Number(*e)]
        };
        table.rows.extend(points.iter().map(row));
    }
}

fn short(flow: &str) -> &str {
    flow.trim_start_matches("channel-")
}

/// Orders in h at t = 1.
fn in_time(evidence: &mut Evidence) -> Result<Panel, StudyError> {
    const METHODS: [&str; 5] = ["method-i", "trapezoidal", "tr-bdf2", "bdf2", "implicit-euler"];
    let pairs: Vec<(&str, &str)> = FLOWS.iter().flat_map(|flow| METHODS.map(|method| (*flow, method))).collect();
    let fits: Vec<OrderFit> = pairs
        .par_iter()
        .map(|(flow, method)| Ok(measure(&*channel(flow, "fd", 32)?, &*method::parse(method)?, Truth::Exact)?))
        .collect::<Result<_, StudyError>>()?;
    let (mut rows, mut curves) = (Vec::new(), Vec::new());
    for ((flow, method), fit) in pairs.iter().zip(&fits) {
        let slope = fit.line.map_or(f64::NAN, |line| line.slope);
        rows.push(vec![
            Cell::Text((*flow).into()),
            Cell::Text((*method).into()),
            if slope.is_nan() { Cell::Empty } else { Cell::Number(slope) },
            Cell::Text(format!("{:?}", fit.verdict).to_lowercase()),
        ]);
        if *method != "method-i" {
            continue;
        }
        curves.push(curve(evidence, "h at t = 1", short(flow), fit));
        // A wall that moves in time stiffens the forcing, and the order is approached slowly.
        let least = if *flow == FLOWS[3] { 1.9 } else { 1.95 };
        evidence.checks.push(Check::new(
            format!("time/{flow}"),
            format!("Method I is of second order in h on {flow} at t = 1"),
            if fit.verdict == Verdict::Pass { slope } else { f64::NAN },
            Requirement::Within(least, 2.1),
            fit.reason.clone(),
        ));
    }
    let caption = "Orders in h at t = 1 with 32 cells, against the exact solution of the system that is discretised in space. \
                   The trapezoidal rule's settles only where h damps the shortest waves, if the data excite them.";
    evidence.tables.push(Table::new("channel-time", caption, &["flow", "method", "order", "verdict"], rows));
    let (x, y) = (Axis::log("h"), Axis::log("error at t = 1"));
    Ok(Panel { title: "Method I in time".into(), x, y, series: curves, ..Panel::default() })
}

/// Orders in h of the largest error over all steps, while h is long for the shortest waves of the grid.
fn maxima(evidence: &mut Evidence) -> Result<Panel, StudyError> {
    let expected = [
        (FLOWS[0], 1.0, "the flow starts with u_t = γ between walls that hold it: a layer of width √h and velocity γh"),
        (FLOWS[1], 0.0, "the wall jumps: the first step has the same shape for every h, in a layer of width √h"),
        (FLOWS[2], 2.0, "the data fit together"),
    ];
    let method = method::parse("method-i")?;
    let (mut curves, mut rows) = (Vec::new(), Vec::new());
    for (flow, order, why) in expected {
        let problem = channel(flow, "fd", 128)?;
        let exact = problem.limit(Principle::Equation).exact;
        let samples: Vec<Sample> = (0..9)
            .into_par_iter()
            .map(|k| {
                let h = (10.0 * 2_f64.powf(0.5 * f64::from(k))).round().recip();
                let mut largest = 0.0_f64;
                let observed = run(&*problem, &*method, h, 1.0, |state| {
                    let error = exact(state.t).map_or(f64::INFINITY, |exact| distance(&state.q, &exact));
                    largest = larger(largest, error);
                });
                match observed {
                    // The eigenvectors of 127 unknowns, each sum of which rounds 127 times.
                    Ok(_) => Sample::new(h, largest, 127.0 * 127.0 * f64::EPSILON),
                    Err(error) => Sample::failed(h, error.to_string()),
                }
            })
            .collect();
        let fit = fit(&samples, &Expectation::new(2.0, 0.1).declared(order, why));
        curves.push(curve(evidence, "h, maximum over steps", short(flow), &fit));
        let slope = fit.line.map_or(Cell::Empty, |line| Cell::Number(line.slope));
        rows.push(vec![Cell::Text(flow.into()), Cell::Number(order), slope, Cell::Text(why.into())]);
        let statement = format!("The largest error of Method I over all steps on {flow} is of order {order}: {why}");
        evidence.checks.push(order_check(format!("maximum/{flow}"), statement, &fit));
    }
    let caption = "Orders in h of the largest error over all steps up to t = 1, with 128 cells, h from 0.1 to 1/160.";
    evidence.tables.push(Table::new("channel-maxima", caption, &["flow", "expected", "order", "why"], rows));
    let (x, y) = (Axis::log("h"), Axis::log("largest error"));
    Ok(Panel { title: "Method I, maximum over all steps".into(), x, y, series: curves, ..Panel::default() })
}

/// Orders in the length of a cell at t = 1.
fn in_space(evidence: &mut Evidence) -> Result<Panel, StudyError> {
    // The centre of the outermost volume moves with the grid, and its share of the error fades slowly. The fourth order of
    // Hermite elements is approached from below, in Womersley's flow with slopes of 3.7 to 3.8 here: 0.3 tells it from 3.
    let schemes: [(&str, f64, f64, [usize; 5]); 3] = [
        ("fd", 2.0, 0.05, [16, 23, 32, 45, 64]),
        ("fv", 2.0, 0.05, [64, 90, 128, 180, 256]),
        ("hermite", 4.0, 0.3, [23, 32, 45, 64, 90]),
    ];
    let cases: Vec<_> = schemes.iter().flat_map(|scheme| FLOWS.map(|flow| (*scheme, flow))).collect();
    let fits: Vec<OrderFit> = cases
        .par_iter()
        .map(|((scheme, order, band, cells), flow)| {
            let sample = |n: &usize| {
                let error = space_error(&*channel(flow, scheme, *n)?, 1.0)?;
                // Eigenvalues of the size of N² carry N² roundings into the slow modes.
                Ok(Sample::new(2.0 / *n as f64, error, f64::EPSILON * (n * n) as f64))
            };
            let samples: Vec<Sample> = cells.iter().map(sample).collect::<Result<_, StudyError>>()?;
            Ok(fit(&samples, &Expectation::new(*order, *band)))
        })
        .collect::<Result<_, StudyError>>()?;
    let (mut rows, mut curves) = (Vec::new(), Vec::new());
    for (((scheme, order, _, cells), flow), fit) in cases.iter().zip(&fits) {
        if *flow == FLOWS[0] {
            curves.push(curve(evidence, "cells at t = 1", scheme, fit));
        }
        let statement = format!("Scheme {scheme} is of order {order} in the length of a cell on {flow} at t = 1");
        evidence.checks.push(order_check(format!("space/{scheme}/{flow}"), statement, fit));
        let slope = fit.line.map_or(Cell::Empty, |line| Cell::Number(line.slope));
        let range = format!("{}–{}", cells[0], cells[4]);
        rows.push(vec![Cell::Text((*scheme).into()), Cell::Text((*flow).into()), Cell::Text(range), slope]);
    }
    let caption =
        "Orders in the length of a cell at t = 1, of the exact solution of the discretised system against the flow.";
    evidence.tables.push(Table::new("channel-space", caption, &["scheme", "flow", "cells", "order"], rows));
    let (x, y) = (Axis::log("length of a cell"), Axis::log("error in space"));
    Ok(Panel { title: "Poiseuille in space".into(), x, y, series: curves, ..Panel::default() })
}

/// The spectral scheme's error for t ≥ 0.1.
fn by_modes(evidence: &mut Evidence) -> Result<Panel, StudyError> {
    let mut curves = Vec::new();
    for flow in FLOWS {
        let mut points = Vec::new();
        for modes in (4..=20).step_by(2) {
            let problem = channel(flow, "legendre", modes)?;
            let errors: Vec<f64> =
                [0.1, 0.2, 0.5, 1.0].into_iter().map(|t| space_error(&*problem, t)).collect::<Result<_, _>>()?;
            points.push((modes as f64, errors.into_iter().largest()));
        }
        let at_16 = points.iter().find(|(n, _)| *n == 16.0).map_or(f64::NAN, |(_, error)| *error);
        evidence.checks.push(Check::new(
            format!("space/legendre/{flow}"),
            format!("Sixteen Legendre modes have {flow} to six digits at t = 0.1, 0.2, 0.5 and 1"),
            at_16,
            Requirement::AtMost(1e-6),
            "the flow is analytic for t > 0",
        ));
        add_points(evidence, "modes, t ≥ 0.1", short(flow), &points);
        curves.push(Series::new(short(flow), points, Mark::LineMarkers));
    }
    let (x, y) = (Axis::log("modes"), Axis::log("error in space, t ≥ 0.1"));
    Ok(Panel { title: "Legendre modes".into(), x, y, series: curves, ..Panel::default() })
}

/// The documented failure: least squares of the residual over piecewise linear elements.
fn without_diffusion(evidence: &mut Evidence) -> Result<(), StudyError> {
    let mut rows = Vec::new();
    for cells in [16, 32, 64, 128] {
        let problem = channel(FLOWS[0], "strong-linear", cells)?;
        let error = space_error(&*problem, 1.0)?;
        rows.push(vec![Cell::Integer(cells as i64), Cell::Number(error)]);
        // ∫ φ (u_t − γ) = 0 gives γt (1 − (−q)ⁿ), q = 2 − √3, at the n-th point from a wall. The first one overshoots; the true
        // flow there is below the steady γ times its distance to the wall, 2/N.
        let overshoot = 2.0 * (3.0 - 3_f64.sqrt());
        let bounds = Requirement::Within(overshoot - 4.0 / cells as f64, overshoot);
        evidence.checks.push(Check::new(
            format!("space/strong-linear/{cells}"),
            format!(
                "Linear elements in the strong form fail: with {cells} cells the error at t = 1 is that of γt, no diffusion"
            ),
            error,
            bounds,
            "u_yy = 0 inside every element, so that the viscosity drops out of the residual",
        ));
    }
    let caption = "Error of linear elements in the strong form on channel-poiseuille at t = 1: the finer, the worse.";
    evidence.tables.push(Table::new("channel-strong-linear", caption, &["cells", "error"], rows));
    Ok(())
}

/// One shape function in place of N cells.
fn ansatz(evidence: &mut Evidence) -> Result<(), StudyError> {
    let (problem, method) = (problem::build("poiseuille-ansatz", &[])?, method::parse("method-i")?);
    let planned = measure(&*problem, &*method, Source::Exact.truth(&*problem, &*method))?;
    let horizon = order_plan(&*problem, &*method).horizon;
    let statement = format!("With one shape function Method I is of first order in h, at t = {horizon}");
    let first = Expectation::new(1.0, planned.expected.band);
    let samples: Vec<_> = planned.points().into_iter().map(|(sample, _)| sample.clone()).collect();
    evidence.checks.push(order_check("time/poiseuille-ansatz", statement, &fit(&samples, &first)));
    Ok(())
}

fn notes() -> Vec<String> {
    vec![
        "In N cells Method I is of second order in h at a fixed time, whatever the data: start-up from rest, a wall set in motion \
         at once, oscillating drives. It is of first order on the ansatz with one shape function, for another reason than \
         stiffness: the residual of that ansatz vanishes for no v(t), and what remains enters the momentum. With N cells the \
         residual of the discretised system can vanish, and does."
            .into(),
        "As a maximum over all steps the order drops to 1 for Poiseuille's flow and to 0 for Couette's. That is no property of the \
         method: the data contradict the walls at t = 0, and the first step is taken in a layer of width √h that no step \
         size resolves. It holds while h is long for the shortest waves, hνN² ≫ 1; the errors are damped at later times."
            .into(),
        "Finite differences and volumes are of second order in space, cubic Hermite elements of fourth, and sixteen Legendre \
         modes give six digits from t = 0.1 on. Linear elements do not work with the strong form of the residual: the second \
         derivative vanishes inside each of them, so that the fluid accelerates as if it had no viscosity, and refinement \
         brings it closer to that."
            .into(),
    ]
}
