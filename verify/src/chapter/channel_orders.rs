//! Orders in time and in space of flows between two plates.

use std::sync::Arc;

use super::parts::order_check;
use super::{Context, Study, StudyError, prose};
use crate::evidence::number::{brief, digits, rounded_up};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Requirement, Series, Table};
use crate::experiment::channel::{HermiteRemainder, LargestOverSteps, OrderInTime, Remainder, SpaceError};
use crate::measure::norm::Extremes;
use crate::measure::order::{Expectation, OrderFit, Sample, fit};
use crate::method;
use crate::problem;
use crate::row;
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
    let mut evidence = Evidence::default();
    let caption = "Errors behind the orders: of time steps h, of cells of length h, of N modes.";
    evidence.tables.push(Table::data(POINTS, caption, ["error_of", "case", "h_or_n", "error"], Vec::new()));
    let panels = [
        in_time(&mut evidence, context)?,
        maxima(&mut evidence, context)?,
        in_space(&mut evidence, context)?,
        by_modes(&mut evidence, context)?,
    ];
    without_diffusion(&mut evidence, context)?;
    evidence.checks.push(ansatz(context)?);
    let number = |table: &str, having: [&str; 2], column: &str| -> Result<f64, StudyError> {
        let table = evidence.tables.iter().find(|known| known.id == table).ok_or("a table")?;
        let column = table.column(column).ok_or("a column")?;
        let is_it = |row: &&Vec<Cell>| having.iter().zip(*row).all(|(text, cell)| cell.to_string() == *text);
        Ok(table.rows.iter().find(is_it).and_then(|row| row[column].number()).ok_or("a number")?)
    };
    let worst = largest_of_modes(&evidence.tables[0]);
    let values = [
        ("hermite", digits(number("channel-space", [HERMITE, FLOWS[2]], "order")?, 2)),
        ("modes", MODES.to_string()),
        ("worst", brief(rounded_up(worst, 2))),
    ];
    evidence.notes = prose::fill(include_str!("channel_orders.md"), &values)?;
    let caption = "Errors of flows in a channel: of Method I in time at t = 1 (32 cells), its maximum over all steps (128 \
                   cells), of the discretisations in space at t = 1 (Poiseuille), and of the spectral one in all flows.";
    evidence.figures.push(Figure::new("channel-orders", caption, POINTS, panels).in_columns(2));
    Ok(evidence)
}

/// The table of all errors.
const POINTS: &str = "channel-order-points";

/// What it calls those of the spectral scheme.
const BY_MODES: &str = "modes, t ≥ 0.1";

/// The largest error of [`MODES`] modes in the table of all errors.
fn largest_of_modes(points: &Table) -> f64 {
    let is_it = |row: &&Vec<Cell>| row[0].to_string() == BY_MODES && row[2].number() == Some(f64::from(MODES));
    points.rows.iter().filter(is_it).map(|row| row[3].number().unwrap_or(f64::NAN)).largest()
}

/// The flow in `cells` cells of a scheme.
fn channel(flow: &str, scheme: &str, cells: usize) -> String {
    format!("{flow} scheme={scheme} cells={cells}")
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
    evidence.tables[0].rows.extend(points.iter().map(|(h, error)| row![what, label, *h, *error]));
}

fn short(flow: &str) -> &str {
    flow.trim_start_matches("channel-")
}

/// Orders in h at t = 1.
fn in_time(evidence: &mut Evidence, context: &Context) -> Result<Panel, StudyError> {
    const METHODS: [&str; 5] = ["method-i", "trapezoidal", "tr-bdf2", "bdf2", "implicit-euler"];
    let pairs: Vec<(&str, &'static str)> =
        FLOWS.iter().flat_map(|flow| METHODS.map(|method| (*flow, method))).collect();
    let settings = pairs.iter().map(|(flow, method)| OrderInTime { problem: channel(flow, "fd", 32), method });
    let fits = context.get_each(settings.collect())?;
    let (mut rows, mut curves) = (Vec::new(), Vec::new());
    for ((flow, method), fit) in pairs.iter().zip(&fits) {
        let slope = fit.line.map(|line| line.slope);
        rows.push(row![*flow, *method, slope, format!("{:?}", fit.verdict).to_lowercase()]);
        if *method != "method-i" {
            continue;
        }
        curves.push(curve(evidence, "h at t = 1", short(flow), fit));
        // To the band of every order: where a wall moves in time it is approached slowly.
        let statement = format!("Method I is of second order in h on {flow} at t = 1");
        evidence.checks.push(order_check(format!("time/{flow}"), statement, fit));
    }
    let caption = "Orders in h at t = 1 with 32 cells, against the exact solution of the system that is discretised in space. \
                   The order of the trapezoidal rule shows only at steps that damp the shortest waves, if the data excite them.";
    evidence.tables.push(Table::new("channel-time", caption, ["flow", "method", "order", "verdict"], rows));
    Ok(Panel::new(Axis::log("h"), Axis::log("error at t = 1"), curves).titled("Method I in time"))
}

/// Orders in h of the largest error over all steps, while h is long for the shortest waves of the grid.
fn maxima(evidence: &mut Evidence, context: &Context) -> Result<Panel, StudyError> {
    let expected = [
        (FLOWS[0], 1.0, "the flow starts with u_t = γ between walls that hold it: a layer of width √h and velocity γh"),
        (FLOWS[1], 0.0, "the wall jumps: the first step has the same shape for every h, in a layer of width √h"),
        (FLOWS[2], 2.0, "the data fit together"),
    ];
    let (mut curves, mut rows) = (Vec::new(), Vec::new());
    for (flow, order, why) in expected {
        let steps = (0..9).map(|k| (10.0 * 2_f64.powf(0.5 * f64::from(k))).round().recip());
        let setting = |h| LargestOverSteps { problem: channel(flow, "fd", 128), method: "method-i", h };
        let samples = context.get_each(steps.map(setting).collect())?;
        let samples: Vec<Sample> = samples.iter().map(|sample| Sample::clone(sample)).collect();
        let fit = fit(&samples, &Expectation::new(2.0, 0.1).declared(order, why));
        curves.push(curve(evidence, "h, maximum over steps", short(flow), &fit));
        rows.push(row![flow, order, fit.line.map(|line| line.slope), why]);
        let statement = format!("The largest error of Method I over all steps on {flow} is of order {order}: {why}");
        evidence.checks.push(order_check(format!("maximum/{flow}"), statement, &fit));
    }
    let caption = "Orders in h of the largest error over all steps up to t = 1, with 128 cells, h from 0.1 to 1/160.";
    evidence.tables.push(Table::new("channel-maxima", caption, ["flow", "expected", "order", "why"], rows));
    Ok(Panel::new(Axis::log("h"), Axis::log("largest error"), curves).titled("Method I, maximum over all steps"))
}

/// Orders in the length of a cell at t = 1.
fn in_space(evidence: &mut Evidence, context: &Context) -> Result<Panel, StudyError> {
    // The centre of the outermost volume moves with the grid, and its share of the error fades slowly.
    let schemes: [(&str, f64, [usize; 5]); 3] =
        [("fd", 2.0, [16, 23, 32, 45, 64]), ("fv", 2.0, [64, 90, 128, 180, 256]), (HERMITE, 4.0, [23, 32, 45, 64, 90])];
    let cases: Vec<_> = schemes.iter().flat_map(|scheme| FLOWS.map(|flow| (*scheme, flow))).collect();
    let setting = |((scheme, _, cells), flow): &((&str, f64, [usize; 5]), &str)| {
        cells.map(|n| SpaceError { problem: channel(flow, scheme, n), t: 1.0 })
    };
    let errors = context.get_each(cases.iter().flat_map(setting).collect())?;
    let (mut rows, mut curves) = (Vec::new(), Vec::new());
    for (((scheme, order, cells), flow), errors) in cases.iter().zip(errors.chunks(5)) {
        // Eigenvalues of the size of N² carry N² roundings into the slow modes.
        let sample =
            |(n, error): (&usize, &Arc<f64>)| Sample::new(2.0 / *n as f64, **error, f64::EPSILON * (n * n) as f64);
        let samples: Vec<Sample> = cells.iter().zip(errors).map(sample).collect();
        let fit = fit(&samples, &Expectation::new(*order, 0.05));
        if *flow == FLOWS[0] {
            curves.push(curve(evidence, "cells at t = 1", scheme, &fit));
        }
        if *scheme == HERMITE {
            let remainders = cells.map(|cells| HermiteRemainder { flow, cells, t: 1.0 });
            evidence.checks.push(fourth_order(flow, &context.get_each(remainders.into())?));
        } else {
            let statement = format!("Scheme {scheme} is of order {order} in the length of a cell on {flow} at t = 1");
            evidence.checks.push(order_check(format!("space/{scheme}/{flow}"), statement, &fit));
        }
        let range = format!("{}–{}", cells[0], cells[4]);
        rows.push(row![*scheme, *flow, range, fit.line.map(|line| line.slope)]);
    }
    let caption =
        "Orders in the length of a cell at t = 1, of the exact solution of the discretised system against the flow.";
    evidence.tables.push(Table::new("channel-space", caption, ["scheme", "flow", "cells", "order"], rows));
    Ok(Panel::new(Axis::log("length of a cell"), Axis::log("error in space"), curves).titled("Poiseuille in space"))
}

/// Elements whose errors near a wall are pre-asymptotic for their fitted order long after they are those of theory.
const HERMITE: &str = "hermite";

/// The fourth order of Hermite elements, on every grid, from what is left beside the leading term of their errors.
fn fourth_order(flow: &str, remainders: &[Arc<Remainder>]) -> Check {
    Check::new(
        format!("space/{HERMITE}/{flow}"),
        format!(
            "Scheme {HERMITE} is of order 4 in the length of a cell on {flow} at t = 1: what is left of its errors beside Δ⁴ u_yyyy/720, less the layers at \
             the walls, over Δ⁶ u_yyyyyy/720 at its largest"
        ),
        remainders.iter().map(|remainder| remainder.ratio()).largest(),
        Requirement::AtMost(1.0),
        "the leading term of the nodal error by theory; the next one is of the sixth order, and N² roundings come on top",
    )
}

/// The spectral scheme's error for t ≥ 0.1.
fn by_modes(evidence: &mut Evidence, context: &Context) -> Result<Panel, StudyError> {
    let mut curves = Vec::new();
    for flow in FLOWS {
        let mut found = Vec::new();
        for modes in (4..=20).step_by(2) {
            let at = |t| Ok(*context.get(SpaceError { problem: channel(flow, "legendre", modes), t })?);
            let errors: Vec<f64> = [0.1, 0.2, 0.5, 1.0].into_iter().map(at).collect::<Result<_, StudyError>>()?;
            found.push((modes as f64, errors));
        }
        evidence.checks.push(spectral(flow, &found));
        let points: Vec<_> = found.into_iter().map(|(modes, errors)| (modes, errors.into_iter().largest())).collect();
        add_points(evidence, BY_MODES, short(flow), &points);
        curves.push(Series::new(short(flow), points, Mark::LineMarkers));
    }
    Ok(Panel::new(Axis::log("modes"), Axis::log("error in space, t ≥ 0.1"), curves).titled("Legendre modes"))
}

/// The errors of [`MODES`] modes at all times, among those of other numbers of modes.
fn spectral(flow: &str, found: &[(f64, Vec<f64>)]) -> Check {
    let errors = found.iter().find(|(modes, _)| *modes == f64::from(MODES));
    Check::new(
        format!("space/legendre/{flow}"),
        format!(
            "{MODES} Legendre modes have {flow} at t = 0.1, 0.2, 0.5 and 1 but for what they leave of its waves: largest error"
        ),
        errors.map_or(f64::NAN, |(_, errors)| errors.iter().copied().largest()),
        Requirement::AtMost(left_of_waves(MODES, 0.1)),
        "the largest coefficient of degree N of a wave e^{−κ²t} cos κy, (2N + 1) κᴺ/(2N + 1)!! at κ² = N/2t",
    )
}

/// The modes of which the text tells.
const MODES: u32 = 16;

/// The wave e^{−κ²t} cos κy has the Legendre coefficient (2N + 1) j_N(κ) e^{−κ²t} of degree N, and j_N(κ) is at most κᴺ/(2N + 1)!!: the largest over all κ.
fn left_of_waves(modes: u32, t: f64) -> f64 {
    let n = f64::from(modes);
    let double_factorial: f64 = (0..=modes).map(|k| f64::from(2 * k + 1)).product();
    (2.0 * n + 1.0) * (n / (2.0 * t * std::f64::consts::E)).powf(0.5 * n) / double_factorial
}

/// The documented failure: least squares of the residual over piecewise linear elements.
fn without_diffusion(evidence: &mut Evidence, context: &Context) -> Result<(), StudyError> {
    let mut rows = Vec::new();
    for cells in [16, 32, 64, 128] {
        let problem = channel(FLOWS[0], "strong-linear", cells);
        let error = *context.get(SpaceError { problem, t: 1.0 })?;
        rows.push(row![cells, error]);
        evidence.checks.push(overshoot(cells, error));
    }
    let caption = "Error of linear elements in the strong form on channel-poiseuille at t = 1: the finer, the worse.";
    evidence.tables.push(Table::new("channel-strong-linear", caption, ["cells", "error"], rows));
    Ok(())
}

fn overshoot(cells: usize, error: f64) -> Check {
    // ∫ φ (u_t − γ) = 0 gives γt (1 − (−q)ⁿ), q = 2 − √3, at the n-th point from a wall. The first one overshoots; the true
    // flow there is below the steady γ times its distance to the wall, 2/N.
    let overshoot = 2.0 * (3.0 - 3_f64.sqrt());
    Check::new(
        format!("space/strong-linear/{cells}"),
        format!(
            "Linear elements in the strong form fail: with {cells} cells the largest error at t = 1 is that of a flow without diffusion, γt, \
             and of its overshoot beside the walls"
        ),
        error,
        Requirement::Within(overshoot - 4.0 / cells as f64, overshoot),
        "u_yy = 0 inside every element, so that the viscosity drops out of the residual",
    )
}

/// One shape function in place of N cells.
fn ansatz(context: &Context) -> Result<Check, StudyError> {
    let planned = context.get(OrderInTime { problem: "poiseuille-ansatz".into(), method: "method-i" })?;
    let horizon = order_plan(&*problem::build_setting("poiseuille-ansatz")?, &*method::parse("method-i")?).horizon;
    let statement = format!("With one shape function Method I is of first order in h, at t = {horizon}");
    let first = Expectation::new(1.0, planned.expected.band);
    let samples: Vec<_> = planned.points().into_iter().map(|(sample, _)| sample.clone()).collect();
    Ok(order_check("time/poiseuille-ansatz", statement, &fit(&samples, &first)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;

    #[test]
    fn one_grid_with_more_than_the_next_term_fails() {
        let outcome = |place: usize, left: f64| {
            let mut left_of_each = [0.5; 5];
            left_of_each[place] = left;
            let remainders = left_of_each.map(|left| Arc::new(Remainder { left, next: 0.75, rounding: 0.25 }));
            fourth_order(FLOWS[0], &remainders).outcome
        };
        for place in 0..5 {
            assert_eq!(
                [0.99, 1.01, f64::NAN].map(|left| outcome(place, left)),
                [Outcome::Pass, Outcome::Fail, Outcome::Fail]
            );
        }
    }

    /// (2N + 1)(N/2te)^(N/2)/(2N + 1)!! at N = 16 and t = 0.1.
    #[test]
    fn the_largest_error_of_the_modes_is_held_to_what_they_leave() {
        let bound = 33.0 * (80.0 / std::f64::consts::E).powi(8) / 6_332_659_870_762_850_625.0;
        let outcome = |place: usize, error: f64| {
            let mut errors = vec![0.0; 4];
            errors[place] = error;
            spectral(FLOWS[0], &[(4.0, vec![1.0; 4]), (f64::from(MODES), errors), (20.0, vec![0.0; 4])]).outcome
        };
        for place in 0..4 {
            assert_eq!(outcome(place, 0.99 * bound), Outcome::Pass);
            assert_eq!(outcome(place, 1.01 * bound), Outcome::Fail);
            assert_eq!(outcome(place, f64::NAN), Outcome::Fail);
        }
        assert_eq!(spectral(FLOWS[0], &[(4.0, vec![0.0; 4])]).outcome, Outcome::Fail);
    }

    #[test]
    fn the_text_has_the_largest_error_of_the_modes_over_all_flows() {
        let of = |what: &str, modes: u32, error: f64| row![what, "some", f64::from(modes), error];
        let rows = vec![
            of("h at t = 1", MODES, 9.0),
            of(BY_MODES, 4, 8.0),
            of(BY_MODES, MODES, 1.0),
            of(BY_MODES, MODES, 3.0),
            of(BY_MODES, MODES, 2.0),
        ];
        let mut points = Table::data(POINTS, "", ["error_of", "case", "h_or_n", "error"], rows);
        assert_eq!(largest_of_modes(&points), 3.0);
        points.rows.push(of(BY_MODES, MODES, f64::NAN));
        assert!(largest_of_modes(&points).is_nan());
    }

    /// Beside the wall the true flow is between 0 and 4/N, and 2(3 − √3) is what is found there without diffusion.
    #[test]
    fn an_overshoot_is_held_to_the_true_flow_beside_the_wall() {
        for cells in [16, 128] {
            let at = |flow: f64| overshoot(cells, 2.0 * (3.0 - 3_f64.sqrt()) - flow / cells as f64).outcome;
            assert_eq!([0.1, 3.9].map(at), [Outcome::Pass; 2]);
            assert_eq!([-0.1, 4.1, f64::NAN].map(at), [Outcome::Fail; 3]);
        }
    }
}
