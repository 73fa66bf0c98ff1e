//! The exact start-up flow by two expansions.

use std::f64::consts::{FRAC_PI_2, PI};

use rayon::prelude::*;

use super::{Context, Study, StudyError};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Series, Table};
use crate::measure::norm::max_norm;
use crate::problem::poiseuille_series::{by_modes_and_by_images, digits, steady, tabulated, velocity};

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

fn run(context: &Context) -> Result<Evidence, StudyError> {
    context.announce(1);
    let comparisons: Vec<Comparison> =
        times().collect::<Vec<_>>().into_par_iter().map(compare).collect::<Result<_, _>>()?;
    context.tick();
    let profiles = profiles()?;
    let truncation = truncation()?;
    Ok(Evidence {
        checks: vec![expansions_agree(&comparisons), against_the_table()?, as_printed()?, reaches_the_steady_profile()?],
        tables: vec![comparison_table(&comparisons), profile_table(&profiles), truncation_table(&truncation)],
        figures: vec![profile_figure(&profiles), truncation_figure(&comparisons, &truncation)],
        notes: vec![
            "The series (34) of eigenfunctions and the series of images, the diffusion of the two walls and their mirror \
             images into the channel, share no term. The first needs √(45/t)/π terms, the second about 28√t; each is used \
             where it is short, from t = 1/36 on the first. Both are evaluated here at all times."
                .into(),
            "Cut after N terms the series (34) follows the flow from t ≈ 1/N² on. Before that it is, at the centre, the series \
             1 − ⅓ + ⅕ − … = π/4 cut after N terms, and wrong by 1/(πN) of the velocity however small that is."
                .into(),
        ],
        ..Evidence::default()
    })
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
         from ½ to 0.03.",
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

/// Points of a curve.
type Curve = Vec<(f64, f64)>;

/// Times of the profiles that are drawn.
const PROFILES: [f64; 6] = [0.01, 0.05, 0.15, 0.4, 1.0, f64::INFINITY];

fn profiles() -> Result<Vec<(f64, Curve)>, StudyError> {
    let profile = |t: f64| {
        let points = (-50..=50).map(|k| {
            let y = f64::from(k) / 50.0;
            Ok((y, velocity(GAMMA, y, t)?))
        });
        Ok((t, points.collect::<Result<Vec<_>, StudyError>>()?))
    };
    PROFILES.into_iter().map(profile).collect()
}

/// Numbers of terms after which (34) is cut, with its relative error at the centre at each time.
fn truncation() -> Result<Vec<(u32, Curve)>, StudyError> {
    let error = |terms: u32, t: f64| {
        let exact = velocity(GAMMA, 0.0, t)?;
        Ok((t, (printed(0.0, t, terms) - exact).abs() / exact))
    };
    [1, 10, 100, 1000]
        .into_iter()
        .map(|terms| Ok((terms, times().map(|t| error(terms, t)).collect::<Result<Vec<_>, StudyError>>()?)))
        .collect()
}

fn comparison_table(comparisons: &[Comparison]) -> Table {
    Table {
        id: "poiseuille-expansions".into(),
        caption: "Largest difference of the two expansions across the channel, and the centre velocity, γ = 2.".into(),
        columns: ["t", "difference", "centre_velocity"].map(Into::into).to_vec(),
        rows: comparisons.iter().map(|c| [c.t, c.difference, c.centre].map(Cell::Number).to_vec()).collect(),
        shown: false,
    }
}

fn profile_table(profiles: &[(f64, Curve)]) -> Table {
    let rows =
        profiles.iter().flat_map(|(t, points)| points.iter().map(|(y, u)| [*t, *y, *u].map(Cell::Number).to_vec()));
    Table {
        id: "poiseuille-profiles".into(),
        caption: "Velocity profiles of the start-up flow, γ = 2; t = inf is the steady one.".into(),
        columns: ["t", "y", "u"].map(Into::into).to_vec(),
        rows: rows.collect(),
        shown: false,
    }
}

fn truncation_table(truncation: &[(u32, Curve)]) -> Table {
    let rows = truncation.iter().flat_map(|(terms, points)| {
        points.iter().map(|(t, e)| vec![Cell::Integer(i64::from(*terms)), Cell::Number(*t), Cell::Number(*e)])
    });
    Table {
        id: "poiseuille-truncation".into(),
        caption: "Relative error of the centre velocity by the series (34) cut after so many terms.".into(),
        columns: ["terms", "t", "relative_error"].map(Into::into).to_vec(),
        rows: rows.collect(),
        shown: false,
    }
}

fn profile_figure(profiles: &[(f64, Curve)]) -> Figure {
    let series = profiles.iter().map(|(t, points)| Series {
        label: if t.is_finite() { format!("t = {t}") } else { "steady".into() },
        points: points.clone(),
        mark: if t.is_finite() { Mark::Line } else { Mark::Guide },
    });
    Figure {
        id: "poiseuille-profiles".into(),
        caption: "Profiles of the flow from rest, γ = 2: a plug that the walls eat away until it is the parabola ½γ(1 − y²). \
                  The ansatz (35) has the parabola's shape from the start."
            .into(),
        data: "poiseuille-profiles".into(),
        panels: vec![Panel {
            x: Axis { label: "y".into(), log: false, limits: Some((-1.0, 1.0)) },
            y: Axis { label: "u".into(), ..Axis::default() },
            series: series.collect(),
            ..Panel::default()
        }],
        columns: 1,
    }
}

fn truncation_figure(comparisons: &[Comparison], truncation: &[(u32, Curve)]) -> Figure {
    let cut = truncation.iter().map(|(terms, points)| Series {
        label: if *terms == 1 { "(34), 1 term".into() } else { format!("(34), {terms} terms") },
        points: points.clone(),
        mark: Mark::Line,
    });
    let expansions = Series {
        label: "the two expansions".into(),
        points: comparisons.iter().map(|c| (c.t, c.difference / c.centre)).collect(),
        mark: Mark::Line,
    };
    Figure {
        id: "poiseuille-truncation".into(),
        caption: "Error of the centre velocity relative to its size when (34) is cut, and the difference of the two complete \
                  expansions, the largest across the channel. The latter rises to small t, where the eigenfunctions cancel \
                  from ½ down to the velocity; the images, which are used there, do not."
            .into(),
        data: "poiseuille-truncation".into(),
        panels: vec![Panel {
            x: Axis { label: "t".into(), log: true, limits: None },
            y: Axis { label: "relative error".into(), log: true, limits: None },
            series: cut.chain([expansions]).collect(),
            ..Panel::default()
        }],
        columns: 1,
    }
}
