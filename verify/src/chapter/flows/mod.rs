//! Two-dimensional Navier–Stokes: what the family does on real flows.

mod approach;
mod balance;
mod cavity;
mod cost;
mod cvode;
mod identities;
mod lid;
mod orders;
mod summary;
mod too_long;
mod work;

use super::{Context, Study, StudyError, prose};
use crate::evidence::number::{about, between, brief, short};
use crate::evidence::{Axis, Evidence, Field, Panel};
use crate::experiment::flow::Seconds;
use crate::experiment::flow::steady::{corner, interpolated};

const ID: &str = "flows";
const FULL_ID: &str = "flows-full";

pub(super) const STUDY: Study = Study {
    id: ID,
    title: "Two-dimensional flows",
    question: "What do the least-squares integrators do on the Navier–Stokes equations: which answers are right, where do they \
               lose to TR-BDF2 or to a projection method, and where do their large steps pay?",
    source: "[S24] title and Section 5; claims b, h, n",
    run: |context| study(context, ID, &SMALL),
};

pub(super) const FULL: Study = Study {
    id: FULL_ID,
    title: "Two-dimensional flows on fine grids",
    question: "Does what holds on coarse grids hold on the grids of the literature: cavity to 160², periodic flows to 128²?",
    source: STUDY.source,
    run: |context| study(context, FULL_ID, &LARGE),
};

/// How large the grids are.
struct Scale {
    /// Flows on which orders in time are measured.
    flows: &'static [&'static str],
    /// Cells of the three grids on which orders in (h, Δx) are measured.
    refinement: [usize; 3],
    /// Cells of the manufactured cavity whose error is held against work.
    precision: usize,
    /// Cells of the impulsively started cavity.
    lid: usize,
    /// Reynolds numbers of the steady cavity, the cells at which it is judged, and all cells: the last two are extrapolated.
    steady: &'static [(f64, usize, &'static [usize])],
    /// Cells and step sizes with which Method I starts from rest, the last too long for the grid.
    too_long: &'static [(usize, f64)],
    /// Cells of the cavity that all methods step to a steady state.
    approach: usize,
    /// Grid points of the periodic flows, the last ones shown.
    points: &'static [usize],
    /// Grid points of shear layers that roll up.
    rolled: Option<usize>,
    /// Cells of the cavity that CVODE solves as well.
    reference: usize,
    /// Grids on which the cost of a step is measured: of the cavity, and of decaying turbulence with steps of one size, and with
    /// steps in proportion to Δx.
    costs: [&'static [usize]; 3],
}

const SMALL: Scale = Scale {
    flows: &orders::FLOWS,
    refinement: [12, 24, 48],
    precision: 16,
    lid: 20,
    steady: &[(100.0, 64, &[16, 32, 64])],
    too_long: &[(16, 1e3), (24, 1e3), (32, 100.0), (32, 1e3)],
    approach: 12,
    points: &[32],
    rolled: None,
    reference: 16,
    costs: [&[16, 32, 64], &[32, 64], &[32, 64]],
};

const LARGE: Scale = Scale {
    flows: &orders::FLOWS,
    refinement: [24, 48, 96],
    precision: 48,
    lid: 32,
    steady: &[(100.0, 128, &[32, 64, 128]), (400.0, 128, &[32, 64, 128]), (1000.0, 128, &[32, 64, 128, 160])],
    too_long: &[
        (16, 1e3),
        (24, 1e3),
        (32, 20.0),
        (32, 50.0),
        (32, 100.0),
        (32, 200.0),
        (32, 500.0),
        (48, 100.0),
        (64, 100.0),
        (64, 1e3),
        (32, 1e3),
    ],
    approach: 32,
    points: &[64, 128],
    rolled: Some(96),
    reference: 32,
    costs: [&[32, 64, 128, 256], &[64, 128, 256, 512], &[128, 256, 512]],
};

/// Adds what it finds at a scale.
type Part = fn(&Context, &mut Evidence, &Scale) -> Result<(), StudyError>;

/// Headings, each with what is found under it.
const PARTS: [(&str, &str, &[Part]); 7] = [
    (
        "right",
        "Where its answers are right",
        &[identities::study, orders::in_time, orders::in_time_and_space, cavity::steady, cvode::cross_check],
    ),
    ("loses", "Where it loses", &[work::study, balance::errors]),
    ("metric", "The metric, energy and enstrophy", &[balance::metric, balance::without_viscosity]),
    ("large-steps", "Where large steps pay", &[lid::study, lid::disturbances, approach::study]),
    ("too-long", "Steps too long for their grid", &[too_long::study]),
    ("cost", "What a step costs", &[cost::study]),
    ("rerun", "How to rerun it", &[rerun]),
];

fn study(context: &Context, id: &str, scale: &Scale) -> Result<Evidence, StudyError> {
    let mut evidence = Evidence::default();
    for (name, title, parts) in PARTS {
        let mut found = Evidence::default();
        for part in parts {
            part(context, &mut found, scale)?;
        }
        evidence.add_under((format!("{id}-{name}"), title), found);
    }
    evidence.notes.extend(summary::told(context, &evidence.checks, scale)?);
    if id != FULL_ID {
        evidence.notes.extend(summary::finer()?);
    }
    Ok(evidence)
}

fn rerun(_context: &Context, evidence: &mut Evidence, _scale: &Scale) -> Result<(), StudyError> {
    evidence.notes.extend(prose::fill(include_str!("rerun.md"), &[])?);
    Ok(())
}

/// What a method with these errors, over another's, does to it.
fn contest(ratios: &[f64]) -> String {
    let word = match ratios {
        ratios if ratios.iter().all(|ratio| *ratio > 1.0) => "loses to",
        ratios if ratios.iter().all(|ratio| *ratio < 1.0) => "beats",
        _ => "is now ahead of and now behind",
    };
    word.into()
}

/// Seconds, as far as their repetitions agree.
fn measured(seconds: Seconds) -> String {
    let Seconds { least, most } = seconds;
    if seconds.is_of_one_run() { about(least, most) } else { between(least, most) }
}

/// One run's seconds over another's, as far as the repetitions of both agree.
fn times(own: Seconds, other: Seconds) -> String {
    let Seconds { least, most } = own.over(other);
    let is_rough = own.is_of_one_run() || other.is_of_one_run();
    if is_rough { about(least, most) } else { between(least, most) }
}

/// Legend entries of the bands between `levels`.
fn bands(levels: &[f64]) -> Vec<String> {
    let below = levels.first().map(|l| format!("below {}", short(*l)));
    let above = levels.last().map(|l| format!("above {}", short(*l)));
    let between = levels.windows(2).map(|pair| format!("{} to {}", short(pair[0]), short(pair[1])));
    below.into_iter().chain(between).chain(above).collect()
}

/// Values at equally spaced places, with others between them on lines, until there are as many as the page shows.
fn finer(values: &[f64]) -> Vec<f64> {
    const SHOWN: usize = 128;
    let parts = (SHOWN / values.len()).max(1);
    let between = values
        .windows(2)
        .flat_map(|pair| (0..parts).map(move |k| pair[0] + k as f64 / parts as f64 * (pair[1] - pair[0])));
    between.chain(values.last().copied()).collect()
}

/// A map of values at `place` along both axes, bilinear between them.
fn map(title: &str, place: &[f64], values: &[Vec<f64>], levels: Vec<f64>, contours: bool) -> Panel {
    let rows: Vec<Vec<f64>> = values.iter().map(|row| finer(row)).collect();
    let across = rows.first().map_or(0, Vec::len);
    let columns: Vec<Vec<f64>> =
        (0..across).map(|i| finer(&rows.iter().map(|row| row[i]).collect::<Vec<_>>())).collect();
    let place = finer(place);
    let values = (0..place.len()).map(|j| columns.iter().map(|column| column[j]).collect()).collect();
    let field = Field { x: place.clone(), y: place, values, bands: bands(&levels), levels, contours };
    Panel::new(Axis::linear("x"), Axis::linear("y"), Vec::new()).titled(title).over(field)
}

/// Streamlines of a cavity from ψ at its interior corners.
fn streamlines(title: &str, cells: usize, psi: &[f64]) -> Panel {
    // As fine as the page shows it.
    let drawn = cells * (128 / cells).max(1);
    let psi = interpolated(cells, psi, drawn);
    let place: Vec<f64> = (0..=drawn).map(|i| i as f64 / drawn as f64).collect();
    let values: Vec<Vec<f64>> = (0..=drawn).map(|j| (0..=drawn).map(|i| corner(drawn, &psi, i, j)).collect()).collect();
    map(title, &place, &values, vec![-0.1, -0.07, -0.04, -0.02, -0.005, -1e-5, 1e-5], true)
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    /// A paragraph that is told without it could not be rerun by its reader.
    #[test]
    fn every_paragraph_names_the_command_that_reruns_it() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/chapter/flows");
        let files = fs::read_dir(folder).expect("a folder of this crate").map(|file| file.expect("readable").path());
        let templates: Vec<_> =
            files.filter(|path| path.extension().is_some_and(|extension| extension == "md")).collect();
        assert!(templates.len() > 10);
        for path in templates {
            let text = fs::read_to_string(&path).expect("readable");
            for paragraph in text.split("\n\n") {
                assert!(paragraph.contains("`verify "), "{}: {paragraph}", path.display());
            }
        }
    }

    #[test]
    fn seconds_have_two_digits_where_both_runs_were_repeated() {
        let (once, twice) = (Seconds { least: 2.2, most: 2.2 }, Seconds { least: 0.0238, most: 0.0247 });
        assert_eq!([measured(once), measured(twice)], ["about 2", "0.023 to 0.025"]);
        assert_eq!([times(once, twice), times(twice, once)], ["about 90", "about 0.011"]);
        assert_eq!(times(twice, twice), "0.96 to 1.1");
    }

    #[test]
    fn the_larger_error_loses() {
        assert_eq!(contest(&[1.1, 3.0]), "loses to");
        assert_eq!(contest(&[0.9, 0.3]), "beats");
        assert_eq!(contest(&[0.9, 1.3]), "is now ahead of and now behind");
    }

    #[test]
    fn bands_are_told_by_the_levels_that_bound_them() {
        assert_eq!(bands(&[1.0, 2.0, 3.0]), ["below 1", "1 to 2", "2 to 3", "above 3"]);
        assert_eq!(bands(&[-0.5]), ["below −0.5", "above −0.5"]);
    }

    #[test]
    fn a_map_is_bilinear_between_its_values() {
        let values = [vec![0.0, 1.0, 2.0], vec![3.0, 4.0, 5.0], vec![6.0, 7.0, 8.0]];
        let field = map("", &[0.0, 1.0, 2.0], &values, vec![0.5], true).field.expect("a map");
        assert!(field.x.len() > 80 && field.x.len() == field.y.len() && field.x == field.y);
        for (y, row) in field.y.iter().zip(&field.values) {
            assert!(field.x.iter().zip(row).all(|(x, value)| (value - (x + 3.0 * y)).abs() < 1e-12));
        }
    }

    #[test]
    fn a_map_of_streamlines_has_its_rows_along_x() {
        let field = streamlines("", 3, &[1.0, 2.0, 3.0, 4.0]).field.expect("a map");
        let corners = |row: &[f64]| row.iter().step_by(42).copied().collect::<Vec<f64>>();
        assert_eq!(corners(&field.values[42]), [0.0, 1.0, 2.0, 0.0]);
        assert_eq!(corners(&field.values[84]), [0.0, 3.0, 4.0, 0.0]);
    }
}
