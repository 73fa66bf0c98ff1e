//! The impulsively started lid, with steps that do not resolve its first moments.

use rayon::prelude::*;

use super::profile::{Profile, cavity};
use super::{Scale, named, observed, rms};
use crate::chapter::StudyError;
use crate::evidence::number::short;
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Requirement, Series, Table};
use crate::measure::norm::Extremes;

const RE: f64 = 100.0;
const METHODS: [&str; 6] = ["method-i", "trapezoidal", "implicit-midpoint", "tr-bdf2", "bdf2", "implicit-euler"];
const STEPS: [f64; 2] = [0.5, 0.25];
/// After one step, and later.
const TIMES: [f64; 2] = [0.5, 2.0];

pub(super) fn study(evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    let problem = cavity(RE, scale.lid)?;
    let tr_bdf2 = named("tr-bdf2")?;
    // Two runs with small steps: their difference, over three, is the error of the finer.
    let fine: Vec<(Vec<f64>, f64)> = TIMES
        .par_iter()
        .map(|end| {
            let coarse = observed(&*problem, &*tr_bdf2, 1.0 / 64.0, *end)?;
            let fine = observed(&*problem, &*tr_bdf2, 1.0 / 128.0, *end)?;
            let error = rms(&coarse, &fine) / 3.0;
            Ok((fine, error))
        })
        .collect::<Result<_, StudyError>>()?;
    let mut cases = Vec::new();
    for h in STEPS {
        cases.extend(TIMES.iter().flat_map(|end| METHODS.map(|method| (h, *end, method))));
    }
    let runs: Vec<Vec<f64>> = cases
        .par_iter()
        .map(|(h, end, method)| observed(&*problem, &*named(method)?, *h, *end))
        .collect::<Result<_, StudyError>>()?;
    let at = |end: f64| usize::from(end == TIMES[1]);
    let errors: Vec<f64> =
        cases.iter().zip(&runs).map(|((_, end, _), velocities)| rms(velocities, &fine[at(*end)].0)).collect();
    let error = |h: f64, end: f64, method: &str| {
        let case = cases.iter().position(|case| *case == (h, end, method));
        case.map_or(f64::NAN, |case| errors[case])
    };
    let ratio = |method: &str, h: f64, end: f64| error(h, end, method) / error(h, end, "method-i");
    let [large, _] = STEPS;
    let [first, last] = TIMES;
    evidence.checks.extend([
        Check::new(
            "lid/reference",
            "The reference of the impulsively started lid is good enough: its error over the smallest that is measured",
            fine.iter().map(|(_, e)| *e).largest() / errors.iter().copied().smallest(),
            Requirement::AtMost(0.1),
            "a tenth of an error changes no order of merit that is stated below by more than that",
        ),
        Check::new(
            "lid/first-step",
            "After one step of h = 0.5 from rest Method I is the best of all: the smallest error of the others over its",
            METHODS[1..].iter().map(|method| ratio(method, large, first)).smallest(),
            Requirement::Above(1.0),
            "for z < 0, |R(z) − e^z| is at most 0.07 for Method I and 0.2 for implicit Euler; TR-BDF2 changes sign",
        ),
        Check::new(
            "lid/trapezoidal-rings",
            "The trapezoidal rule still rings after four steps of h = 0.5: its error over Method I's",
            ratio("trapezoidal", large, last),
            Requirement::Above(1.0),
            "h|λ| reaches 8νh/Δx², and R(−16)⁴ = 0.37 of what the jump excites is left there at N = 20",
        ),
        Check::new(
            "lid/tr-bdf2",
            "Once the layer has spread Method I loses to TR-BDF2: the largest ratio of TR-BDF2's error to its at t = 2",
            STEPS.map(|h| ratio("tr-bdf2", h, last)).into_iter().largest(),
            Requirement::Below(1.0),
            "L-stable as well, with error constant −0.04 for 1/6",
        ),
        Check::new(
            "lid/implicit-euler",
            "Implicit Euler's error over Method I's at t = 2, least over h",
            STEPS.map(|h| ratio("implicit-euler", h, last)).into_iter().smallest(),
            Requirement::Above(1.0),
            "first order against second",
        ),
    ]);
    for h in STEPS {
        for end in TIMES {
            let best =
                METHODS.into_iter().min_by(|a, b| error(h, end, a).total_cmp(&error(h, end, b))).unwrap_or_default();
            evidence.notes.push(format!(
                "Impulsively started lid, h = {h}, t = {end}: the smallest error is that of `{best}`, {}; `method-i` has {}, \
                 `trapezoidal` {}, `tr-bdf2` {}.",
                short(error(h, end, best)),
                short(error(h, end, "method-i")),
                short(error(h, end, "trapezoidal")),
                short(error(h, end, "tr-bdf2")),
            ));
        }
    }
    let rows = cases.iter().zip(&errors).map(|((h, end, method), error)| {
        vec![Cell::Number(*h), Cell::Number(*end), Cell::Text((*method).into()), Cell::Number(*error)]
    });
    let caption = format!(
        "Cavity of {} cells a side, Re = {RE}, lid started at once: root mean square of the error of the velocities against TR-BDF2 \
         with h = 1/128.",
        scale.lid
    );
    evidence.tables.push(Table::new("flow-lid", caption, ["h", "t", "method", "error"], rows.collect()));
    let mut data = Vec::new();
    let panels: Vec<Panel> = TIMES
        .iter()
        .map(|end| {
            let mut curves = Vec::new();
            let reference = ("reference", &fine[at(*end)].0, Mark::Guide);
            let shown = cases.iter().zip(&runs).filter(|(case, _)| case.0 == STEPS[0] && case.1 == *end);
            for (label, velocities, mark) in
                shown.map(|((.., method), run)| (*method, run, Mark::Line)).chain([reference])
            {
                let points = Profile::new(scale.lid, velocities).line('u').to_vec();
                let row = |(y, u): &(f64, f64)| {
                    vec![Cell::Number(*end), Cell::Text(label.into()), Cell::Number(*y), Cell::Number(*u)]
                };
                data.extend(points.iter().map(row));
                curves.push(Series::new(label, points, mark));
            }
            Panel::new(Axis::linear("y"), Axis::linear("u at x = ½"), curves).titled(format!("t = {end}"))
        })
        .collect();
    let caption = "Velocity on the vertical centre line after one and after four steps of h = 0.5: the trapezoidal rule rings at the \
                   lid.";
    evidence.tables.push(Table::data("flow-lid-profiles", caption, ["t", "method", "y", "u"], data));
    evidence.figures.push(Figure::new("flow-lid-profiles", caption, "flow-lid-profiles", panels).in_columns(2));
    filmstrip(evidence, scale)
}

/// The stream function of the start-up, by Method I.
fn filmstrip(evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    let problem = cavity(RE, scale.lid)?;
    let mut panels = Vec::new();
    let mut rows = Vec::new();
    for end in [0.25, 1.0, 4.0, 16.0] {
        let state = crate::run::run(&*problem, &*named("method-i")?, 0.25, end, |_| {})?.end;
        panels.push(streamlines(&format!("t = {end}"), scale.lid, &state.q));
        rows.extend(state.q.iter().enumerate().map(|(i, psi)| {
            let (x, y) = (i % (scale.lid - 1) + 1, i / (scale.lid - 1) + 1);
            let n = scale.lid as f64;
            vec![Cell::Number(end), Cell::Number(x as f64 / n), Cell::Number(y as f64 / n), Cell::Number(*psi)]
        }));
    }
    let caption = "Streamlines of the cavity after the lid has started, Re = 100, by Method I with h = 0.25.";
    evidence.tables.push(Table::data("flow-start-up", caption, ["t", "x", "y", "psi"], rows));
    evidence.figures.push(Figure::new("flow-start-up", caption, "flow-start-up", panels).in_columns(4));
    Ok(())
}

/// Streamlines of a cavity from ψ at its interior corners.
pub(super) fn streamlines(title: &str, cells: usize, psi: &[f64]) -> Panel {
    let place: Vec<f64> = (0..=cells).map(|i| i as f64 / cells as f64).collect();
    let inside = cells - 1;
    let value = |i: usize, j: usize| {
        if i == 0 || j == 0 || i == cells || j == cells { 0.0 } else { psi[(j - 1) * inside + i - 1] }
    };
    let values = (0..=cells).map(|j| (0..=cells).map(|i| value(i, j)).collect()).collect();
    let levels = vec![-0.1, -0.08, -0.06, -0.04, -0.02, -0.005, -1e-4, 1e-5, 1e-4];
    let field = crate::evidence::Field {
        x: place.clone(),
        y: place,
        values,
        bands: super::bands(&levels),
        levels,
        contours: true,
    };
    Panel::new(Axis::linear("x"), Axis::linear("y"), Vec::new()).titled(title).over(field)
}
