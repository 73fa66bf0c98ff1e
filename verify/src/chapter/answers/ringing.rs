//! The flow next to a wall that is set in motion at once.

use super::parabolic::{CELLS, METHODS};
use super::{Answer, prose};
use crate::chapter::{Context, StudyError};
use crate::evidence::number::brief;
use crate::evidence::{Axis, Check, Figure, Mark, Panel, Requirement, Series, Table};
use crate::experiment::course::Course;
use crate::measure::norm::Extremes;
use crate::row;

const H: f64 = 0.05;
const STEPS: u32 = 10;

/// A profile whose variation is below this goes up once: its height may be off by an error of a hundredth.
const ONCE: f64 = 1.01;

/// Points nearest to the moving wall that are drawn.
const DRAWN: usize = 24;

pub(super) fn answer(context: &Context) -> Result<Answer, StudyError> {
    let t_end = f64::from(STEPS) * H;
    let problem = format!("channel-couette cells={CELLS}");
    let runs = METHODS.map(|(method, _)| Course { problem: problem.clone(), method, h: H, t_end });
    let found = context.get_each(runs.into())?;
    let mut rows = Vec::new();
    let place = |i: usize| 2.0 * (i + 1) as f64 / f64::from(CELLS) - 1.0;
    let mut profile = |label: &str, values: &[f64], mark: Mark| {
        let near = values.len() - DRAWN.min(values.len());
        let points: Vec<(f64, f64)> = (near..values.len()).map(|i| (place(i), values[i])).collect();
        rows.extend(points.iter().map(|(y, u)| row!["profile", label, *y, *u]));
        Series::new(label, points, mark)
    };
    let mut profiles: Vec<Series> =
        METHODS.iter().zip(&found).map(|((method, _), run)| profile(method, &run.state, Mark::Line)).collect();
    profiles.push(profile("exact", &found[0].exact, Mark::Guide));
    let courses: Vec<Series> = METHODS
        .iter()
        .zip(&found)
        .map(|((method, _), run)| {
            let points: Vec<(f64, f64)> = (1..).map(f64::from).zip(&run.errors).map(|(n, (_, e))| (n, *e)).collect();
            rows.extend(points.iter().map(|(n, error)| row!["error", *method, *n, *error]));
            Series::new(*method, points, Mark::LineMarkers)
        })
        .collect();
    // How far a profile goes up and down, in heights of the exact one, which is monotone.
    let waves: Vec<f64> = found.iter().map(|run| variation(&run.state) / variation(&run.exact)).collect();
    let after = |step: usize| found.iter().map(|run| run.errors[step].1).collect::<Vec<f64>>();
    let (first, last) = (after(0), after(STEPS as usize - 1));
    let next = first[1..].iter().map(|error| error / first[0]).smallest();
    let damped = waves[2..].iter().copied().largest();
    let best = (0..METHODS.len()).min_by(|a, b| last[*a].total_cmp(&last[*b])).unwrap_or_default();
    // The first step from which on the last winner has the smallest error.
    let wins = |step: &usize| after(*step).iter().all(|error| after(*step)[best] <= *error);
    let overtaken = (0..STEPS as usize).rev().take_while(wins).last().unwrap_or_default() + 1;
    let checks = vec![
        Check::new(
            "ringing/trapezoidal",
            format!(
                "After {STEPS} steps the trapezoidal rule has more than ten times the error of Method I: ratio of the errors"
            ),
            last[1] / last[0],
            Requirement::Above(10.0),
            "R(∞) = −1: what the wall excites stays, with alternating sign",
        ),
        Check::new(
            "ringing/waves",
            "Its profile goes up and down by more than the height of the exact one: its variation over that of the exact one",
            waves[1],
            Requirement::Above(ONCE),
            "the exact profile is monotone and goes up once",
        ),
        Check::new(
            "ringing/method-i",
            "The profile of Method I goes up once, as the exact one: its variation over that of the exact one",
            waves[0],
            Requirement::Below(ONCE),
            "R(∞) = 0; its height may differ by its error, which is below a hundredth",
        ),
        Check::new(
            "ringing/others",
            "So do the profiles of TR-BDF2, SDIRK2 and Radau IIA: largest variation over that of the exact one",
            damped,
            Requirement::Below(ONCE),
            "they are L-stable",
        ),
        Check::new(
            "ringing/first",
            "After the first step Method I has the smallest error: least error of the others over its",
            next,
            Requirement::Above(1.0),
            "for z < 0, |R(z) − e^z| is at most 0.07 for Method I",
        ),
        Check::new(
            "ringing/last",
            "After the last step another method has: least error of the others over Method I's",
            last[best] / last[0],
            Requirement::Below(1.0),
            "what the answer says",
        ),
    ];
    let values = [
        ("cells", CELLS.to_string()),
        ("h", H.to_string()),
        ("steps", STEPS.to_string()),
        ("waves", brief(waves[1])),
        ("first", brief(next)),
        ("last", brief(last[1] / last[0])),
        ("later_best", format!("`{}`", METHODS[best].0)),
        ("overtaken", overtaken.to_string()),
    ];
    let panels = [
        Panel::new(Axis::linear("y"), Axis::linear("u"), profiles).titled("Next to the moving wall"),
        Panel::new(Axis::linear("step"), Axis::log("largest error"), courses).titled("Step by step"),
    ];
    let caption = "Profiles next to the wall, u over y, and the largest error over the number of the step.";
    Ok(Answer {
        id: "answer-ringing",
        question: "Does it ring after a jump?",
        short: "no",
        text: prose::fill(include_str!("ringing.md"), &values)?,
        checks,
        figure: Some(Figure::new("answer-ringing", "", "answer-ringing", panels).in_columns(2)),
        table: Table::data("answer-ringing", caption, ["what", "method", "y_or_step", "value"], rows),
    })
}

/// Σ |uᵢ₊₁ − uᵢ|.
fn variation(values: &[f64]) -> f64 {
    values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum()
}
