//! The exact start-up flow by two expansions.

use std::f64::consts::{FRAC_PI_2, PI};

use rayon::prelude::*;

use super::{Context, Study, StudyError, prose};
use crate::evidence::{Axis, Check, Evidence, Figure, Mark, Panel, Series, Table};
use crate::measure::norm::max_norm;
use crate::problem::poiseuille_series::{by_modes_and_by_images, digits, steady, tabulated, velocity};
use crate::row;

pub(super) const STUDY: Study = Study {
    id: "poiseuille-series",
    title: "The exact start-up flow",
    question: "Is the series (34), against which the flow is judged, evaluated to 1e-14 at all times from 1e-8 to 10?",
    source: "[S24] Eqs. (33), (34)",
    run,
};

const GAMMA: f64 = 2.0;

/// 10⁻⁸ … 10, ten in a decade.
fn times() -> impl Iterator<Item = f64> {
    (-80..=10).map(|k| 10_f64.powf(f64::from(k) / 10.0))
}

/// From the centre to the wall, closer and closer to it.
fn positions() -> impl Iterator<Item = f64> {
    let even = (0..10).map(|k| f64::from(k) / 10.0);
    even.chain((1..=8).map(|k| 1.0 - 10_f64.powi(-k))).chain([1.0])
}

/// One time: the largest difference of the expansions across the channel, and the centre velocity.
struct Comparison {
    t: f64,
    difference: f64,
    centre: f64,
}

fn compare(t: f64) -> Result<Comparison, StudyError> {
    let difference = |y| by_modes_and_by_images(GAMMA, y, t).map(|[modes, images]| modes - images);
    let differences = positions().map(difference).collect::<Result<Vec<_>, _>>()?;
    Ok(Comparison { t, difference: max_norm(&differences), centre: velocity(GAMMA, 0.0, t)? })
}

/// Eq. (34) as printed, cut after `terms` terms.
fn printed(y: f64, t: f64, terms: u32) -> f64 {
    let term = |k: u32| {
        let n = f64::from(2 * k + 1);
        let decay = (-(n * FRAC_PI_2).powi(2) * t).exp_m1();
        -16.0 * GAMMA / (n * PI).powi(3) * (n * FRAC_PI_2 * (y + 1.0)).sin() * decay
    };
    (0..terms).map(term).sum()
}

fn run(_: &Context) -> Result<Evidence, StudyError> {
    let comparisons: Vec<Comparison> =
        times().collect::<Vec<_>>().into_par_iter().map(compare).collect::<Result<_, _>>()?;
    let mut evidence = Evidence {
        checks: vec![
            expansions_agree(&comparisons),
            against_the_table()?,
            as_printed()?,
            reaches_the_steady_profile()?,
        ],
        notes: prose::fill(include_str!("poiseuille_series.md"), &[])?,
        ..Evidence::default()
    };
    profiles(&mut evidence)?;
    truncation(&mut evidence, &comparisons)?;
    Ok(evidence)
}

fn expansions_agree(comparisons: &[Comparison]) -> Check {
    let worst = comparisons.iter().max_by(|a, b| a.difference.total_cmp(&b.difference));
    Check::at_most(
        "expansions-agree",
        "the eigenfunctions and the images give the same velocity, γ = 2, for t from 1e-8 to 10 across the whole channel",
        worst.map_or(f64::NAN, |c| c.difference),
        1e-14,
        worst.map_or_else(String::new, |c| format!("Largest difference at t = {:.3e}; velocities are up to 1.", c.t)),
    )
}

fn against_the_table() -> Result<Check, StudyError> {
    let differences = tabulated()?
        .iter()
        .map(|row| Ok(velocity(GAMMA, row.y, row.t)? / row.u - 1.0))
        .collect::<Result<Vec<_>, StudyError>>()?;
    Ok(Check::at_most(
        "sixty-digits",
        format!("the velocity agrees with values computed in {}-digit arithmetic, relative to its own size", digits()),
        max_norm(&differences),
        1e-14,
        "Largest relative difference at 55 points; just after the expansions are exchanged at t = 1/36 the first cancels \
         from ½γ to 0.03γ.",
    ))
}

/// Number of terms of (34) in the check of its printed form.
const MANY: u32 = 20_000;

fn as_printed() -> Result<Check, StudyError> {
    // Σ over odd n > 2N of 16γ/(πn)³ is below 4γ/(π³ (2N)²).
    let tail = GAMMA / (PI.powi(3) * f64::from(MANY).powi(2));
    let mut differences = Vec::new();
    for t in [1e-8, 1e-6, 1e-4, 1e-2, 0.1, 1.0, 10.0] {
        for y in [-0.99, -0.5, 0.0, 0.3, 0.9] {
            differences.push(printed(y, t, MANY) - velocity(GAMMA, y, t)?);
        }
    }
    Ok(Check::at_most(
        "as-printed",
        format!("the series (34) exactly as printed, {MANY} terms of it, gives the same velocity"),
        max_norm(&differences),
        tail + 16.0 * f64::EPSILON,
        "Largest difference at 35 points; the bound is the sum of the terms left out, γ/(π³N²).",
    ))
}

fn reaches_the_steady_profile() -> Result<Check, StudyError> {
    let differences = positions()
        .map(|y| Ok(steady(GAMMA, y)? - 0.5 * GAMMA * (1.0 - y * y)))
        .collect::<Result<Vec<_>, StudyError>>()?;
    Ok(Check::at_most(
        "steady-profile",
        "the flow tends to ½γ(1 − y²)",
        max_norm(&differences),
        2.0 * f64::EPSILON,
        "Largest difference; each side is rounded twice or three times.",
    ))
}

/// Profiles at several times.
fn profiles(evidence: &mut Evidence) -> Result<(), StudyError> {
    let (mut rows, mut curves) = (Vec::new(), Vec::new());
    for t in [0.01, 0.05, 0.15, 0.4, 1.0, f64::INFINITY] {
        let at = |k: i32| {
            let y = f64::from(k) / 50.0;
            Ok((y, velocity(GAMMA, y, t)?))
        };
        let points = (-50..=50).map(at).collect::<Result<Vec<_>, StudyError>>()?;
        rows.extend(points.iter().map(|(y, u)| row![t, *y, *u]));
        let (label, mark) =
            if t.is_finite() { (format!("t = {t}"), Mark::Line) } else { ("steady".into(), Mark::Guide) };
        curves.push(Series::new(label, points, mark));
    }
    let caption = "Velocity profiles of the start-up flow, γ = 2; t = inf is the steady one.";
    evidence.tables.push(Table::data("poiseuille-profiles", caption, ["t", "y", "u"], rows));
    let caption = "Profiles of the flow from rest, γ = 2: a plug profile that friction at the walls turns into the parabola ½γ(1 − y²). \
                   The ansatz (35) has the parabola's shape from the start.";
    let panel = Panel::new(Axis::linear("y").between(-1.0, 1.0), Axis::linear("u"), curves);
    evidence.figures.push(Figure::new("poiseuille-profiles", caption, "poiseuille-profiles", [panel]));
    Ok(())
}

/// The relative error of (34) at the centre, cut after so many terms, beside the difference of the two expansions.
fn truncation(evidence: &mut Evidence, comparisons: &[Comparison]) -> Result<(), StudyError> {
    let (mut rows, mut curves) = (Vec::new(), Vec::new());
    for terms in [1, 10, 100, 1000] {
        let error = |t: f64| {
            let exact = velocity(GAMMA, 0.0, t)?;
            Ok((t, (printed(0.0, t, terms) - exact).abs() / exact))
        };
        let points = times().map(error).collect::<Result<Vec<_>, StudyError>>()?;
        rows.extend(points.iter().map(|(t, error)| row![terms, *t, *error]));
        let label = if terms == 1 { "(34), 1 term".into() } else { format!("(34), {terms} terms") };
        curves.push(Series::new(label, points, Mark::Line));
    }
    let expansions = comparisons.iter().map(|c| (c.t, c.difference / c.centre)).collect();
    curves.push(Series::new("the two expansions", expansions, Mark::Line));
    let caption = "Largest difference of the two expansions across the channel, and the centre velocity, γ = 2.";
    let compared = comparisons.iter().map(|c| row![c.t, c.difference, c.centre]).collect();
    let columns = ["t", "difference", "centre_velocity"];
    evidence.tables.push(Table::data("poiseuille-expansions", caption, columns, compared));
    let caption = "Relative error of the centre velocity by the series (34) cut after so many terms.";
    let columns = ["terms", "t", "relative_error"];
    evidence.tables.push(Table::data("poiseuille-truncation", caption, columns, rows));
    let caption = "Error of the centre velocity relative to its size when (34) is cut, and the difference of the two complete \
                   expansions, the largest across the channel. The latter rises to small t, where the eigenfunctions cancel \
                   from ½γ down to the velocity; the images, which are used there, do not. At large t it is the images that cancel.";
    let panel = Panel::new(Axis::log("t"), Axis::log("relative error"), curves);
    evidence.figures.push(Figure::new("poiseuille-truncation", caption, "poiseuille-truncation", [panel]));
    Ok(())
}
