//! Error against work on a stiff parabolic problem, with data that fit together and with a jump.

use super::{Answer, prose};
use crate::chapter::{Context, StudyError};
use crate::evidence::number::{between, brief};
use crate::evidence::{Axis, Check, Figure, Mark, Panel, Requirement, Table};
use crate::experiment::end_errors::{EndErrors, Truth};
use crate::measure::norm::Extremes;
use crate::method;
use crate::row;

/// A method with the number of linear systems of the size of the problem in a step. The denominator of the stability function
/// tells it: of degree two for Method I, whose augmented system has twice the unknowns, and for Radau IIA, whose stages are
/// coupled; two systems, one after the other, for the others.
pub(super) const METHODS: [(&str, u32); 5] =
    [("method-i", 2), ("trapezoidal", 1), ("tr-bdf2", 2), ("sdirk2", 2), ("ls-galerkin(2,radau,2)", 2)];

/// The places of the trapezoidal rule and of Radau IIA among them.
pub(super) const TRAPEZOIDAL: usize = 1;
const RADAU: usize = 4;

pub(super) const CELLS: u32 = 64;

/// Systems in a run.
const SYSTEMS: [u32; 8] = [2, 4, 8, 16, 32, 64, 128, 256];
/// Where on this ladder the methods are compared: steps that resolve the slow motion and not the shortest waves.
const COMPARED: usize = 4;

/// Panel, flow, end.
const CASES: [(&str, &str, f64); 3] = [
    ("Smooth data, t = 1", "channel-womersley", 1.0),
    ("After a jump, t = 0.5", "channel-couette", 0.5),
    ("Immediately after the jump, t = 0.02", "channel-couette", 0.02),
];

/// A run for so many systems.
fn setting(flow: &str, t_end: f64, (method, each): (&str, u32), systems: u32) -> EndErrors {
    let (problem, truth) = (format!("{flow} cells={CELLS}"), Truth::Equations);
    EndErrors { problem, method: method.into(), h: t_end, pieces: systems / each, t_end, truth }
}

/// The least number of systems from which on Radau IIA is more accurate than `method` in every picture.
pub(super) fn radau_leads_from(context: &Context, method: &str) -> Result<u32, StudyError> {
    let method = METHODS.into_iter().find(|(name, _)| *name == method).ok_or("it is in no picture")?;
    let mut leads_from = None;
    for systems in SYSTEMS.into_iter().rev() {
        for (_, flow, t_end) in CASES {
            let error = |method| context.get(setting(flow, t_end, method, systems));
            if error(METHODS[RADAU])?.end >= error(method)?.end {
                return Ok(leads_from.ok_or("Radau IIA is not ahead")?);
            }
        }
        leads_from = Some(systems);
    }
    Ok(leads_from.ok_or("no runs")?)
}

pub(super) fn answer(context: &Context) -> Result<Answer, StudyError> {
    let mut rows = Vec::new();
    let mut panels = Vec::new();
    let (mut measured, mut factored) = (Vec::new(), Vec::new());
    for (title, flow, t_end) in CASES {
        let runs =
            METHODS.iter().flat_map(|method| SYSTEMS.map(|systems| setting(flow, t_end, *method, systems))).collect();
        let found = context.get_each(runs)?;
        let factors = |place: usize| found[place * SYSTEMS.len() + COMPARED].factorizations;
        factored.push((0..METHODS.len()).map(factors).collect::<Vec<_>>());
        let found: Vec<f64> = found.iter().map(|found| found.end).collect();
        let of = |place: usize| found.chunks(SYSTEMS.len()).map(|errors| errors[place]).collect::<Vec<f64>>();
        measured.push([of(0), of(1), of(COMPARED)]);
        for ((method, each), errors) in METHODS.iter().zip(found.chunks(SYSTEMS.len())) {
            rows.extend(SYSTEMS.iter().zip(errors).map(|(n, error)| row![title, *method, n / each, *n, *error]));
        }
        let mut data = Table::data("", "", COLUMNS, rows.clone());
        data.rows.retain(|row| row[0].to_string() == title);
        let curves = data.curves("method", "systems", "error", Mark::LineMarkers);
        let panel = Panel::new(Axis::log("linear systems"), Axis::log("largest error"), curves);
        panels.push(panel.titled(title));
    }
    let [smooth, later, soon, second] = [&measured[0][2], &measured[1][2], &measured[2][0], &measured[2][1]];
    let (smooth_best, later_best) = (best(smooth), best(later));
    let rivals = || soon[1..].iter().map(|error| error / soon[0]);
    let (low, high) = (rivals().smallest(), rivals().largest());
    let systems = SYSTEMS[COMPARED];
    // f is linear in all of them, with constant coefficients.
    let keeps = |place: &usize| factored.iter().all(|factors| factors[*place] <= factors[0]);
    let kept = (1..METHODS.len()).filter(keeps).min_by(|a, b| smooth[*a].total_cmp(&smooth[*b]));
    let kept = kept.ok_or("no other method factors as few matrices as Method I")?;
    let checks = vec![
        Check::new(
            "parabolic/smooth",
            format!(
                "On smooth data Method I is not the best for {systems} systems: least error of the others over its"
            ),
            smooth[smooth_best] / smooth[0],
            Requirement::Below(1.0),
            "left panel; the smallest of the four others",
        ),
        Check::new(
            "parabolic/trapezoidal",
            format!(
                "On smooth data the trapezoidal rule is ahead of Method I for {systems} systems: its error over Method I's"
            ),
            smooth[TRAPEZOIDAL] / smooth[0],
            Requirement::Below(1.0),
            "it takes twice as many steps, and has the smaller error constant",
        ),
        Check::new(
            "parabolic/later",
            format!(
                "Well after a jump Method I is not the best for {systems} systems: least error of the others over its"
            ),
            later[later_best] / later[0],
            Requirement::Below(1.0),
            "middle panel; the smallest of the four others",
        ),
        Check::new(
            "parabolic/radau",
            format!(
                "Radau IIA with two stages is the best well after a jump for {systems} systems: its error over the least"
            ),
            later[RADAU] / later[later_best],
            Requirement::AtMost(1.0),
            "middle panel; 1 where it is the best",
        ),
        Check::new(
            "parabolic/overtaken",
            "Immediately after the jump another method is ahead of Method I as soon as more than one step is taken: least error of the \
             others over its for four systems",
            second[1..].iter().map(|error| error / second[0]).smallest(),
            Requirement::Below(1.0),
            "right panel, the second point from the left",
        ),
        Check::new(
            "parabolic/first",
            "In the first instant after a jump Method I is the best for two systems: least error of the others over its",
            low,
            Requirement::Above(1.0),
            "two steps of the trapezoidal rule, one of any other",
        ),
        Check::new(
            "parabolic/factors",
            format!(
                "Where f is linear with constant coefficients Method I is not the best for {systems} systems among the methods that factor as few matrices: \
                 the larger of another one's errors over its, on smooth data and well after the jump"
            ),
            [smooth[kept] / smooth[0], later[kept] / later[0]].into_iter().largest(),
            Requirement::Below(1.0),
            "left and middle panels; the matrix of a step is kept while its size is the same",
        ),
        Check::new(
            "parabolic/renewed",
            format!(
                "Radau IIA with two stages factors anew in each step although f and the step stay the same: \
                 least number of factorizations a step in the runs of {systems} systems"
            ),
            factored.iter().map(|factors| factors[RADAU] as f64 / f64::from(systems / METHODS[RADAU].1)).smallest(),
            Requirement::AtLeast(1.0),
            "1 where no factors are kept from one step to the next",
        ),
    ];
    let values = [
        ("cells", CELLS.to_string()),
        ("systems", systems.to_string()),
        ("steps", (systems / METHODS[0].1).to_string()),
        ("smooth_best", named(smooth_best)),
        ("smooth_radau", brief(smooth[later_best] / smooth[0])),
        ("smooth_trapezoidal", brief(smooth[TRAPEZOIDAL] / smooth[0])),
        ("later_best", named(later_best)),
        ("later", CASES[1].2.to_string()),
        ("later_ratio", brief(later[later_best] / later[0])),
        ("soon", CASES[2].2.to_string()),
        ("order", method::parse(METHODS[0].0)?.order().to_string()),
        ("radau_order", method::parse(METHODS[RADAU].0)?.order().to_string()),
        ("first", between(low, high)),
        ("own_factors", factored[0][0].to_string()),
        ("radau_factors", factored[0][RADAU].to_string()),
        ("kept", named(kept)),
        ("kept_factors", factored[0][kept].to_string()),
        ("kept_smooth", brief(smooth[kept] / smooth[0])),
        ("kept_later", brief(later[kept] / later[0])),
    ];
    let table = Table::data("answer-parabolic", "Error against work in a channel, by case and method.", COLUMNS, rows);
    Ok(Answer {
        id: "answer-parabolic",
        question: "Should I use Method I for my stiff parabolic problem?",
        short: "no, but for one step across a jump".into(),
        text: prose::fill(include_str!("parabolic.md"), &values)?,
        checks,
        figure: Some(Figure::new("answer-parabolic", "", "answer-parabolic", panels).in_columns(3)),
        table,
    })
}

const COLUMNS: [&str; 5] = ["case", "method", "steps", "systems", "error"];

fn best(errors: &[f64]) -> usize {
    (0..errors.len()).min_by(|a, b| errors[*a].total_cmp(&errors[*b])).unwrap_or_default()
}

fn named(method: usize) -> String {
    format!("`{}`", METHODS[method].0)
}
