//! The flow next to a wall that is set in motion at once.

use std::f64::consts::PI;

use super::parabolic::{CELLS, METHODS, TRAPEZOIDAL};
use super::{Answer, prose};
use crate::chapter::{Context, StudyError};
use crate::evidence::number::{brief, digits};
use crate::evidence::{Axis, Check, Figure, Mark, Panel, Requirement, Series, Table};
use crate::experiment::course::{Course, Found};
use crate::experiment::one_step::OneStep;
use crate::measure::norm::Extremes;
use crate::row;

const H: f64 = 0.05;
const STEPS: u32 = 10;

/// A profile whose variation is no more than this goes up once, from one wall to the other: the difference of the walls, and the roundings of a
/// sum over the cells.
const ONCE: f64 = 1.0 + CELLS as f64 * f64::EPSILON;

/// Points nearest to the moving wall that are drawn.
const DRAWN: usize = 24;

pub(super) fn answer(context: &Context) -> Result<Answer, StudyError> {
    let t_end = f64::from(STEPS) * H;
    let problem = format!("channel-couette cells={CELLS}");
    let runs = METHODS.map(|(method, _)| Course { problem: problem.clone(), method, h: H, t_end });
    let found = context.get_each(runs.into())?;
    // Those after the step before, which show what alternates.
    let before = METHODS.map(|(method, _)| Course { problem: problem.clone(), method, h: H, t_end: t_end - H });
    let before = context.get_each(before.into())?;
    let mut rows = Vec::new();
    let place = |i: usize| 2.0 * (i + 1) as f64 / f64::from(CELLS) - 1.0;
    let off = |run: &Found| run.state.iter().zip(&run.exact).map(|(u, exact)| u - exact).collect::<Vec<f64>>();
    let mut profiles = Vec::new();
    for (step, runs) in [(STEPS - 1, &before), (STEPS, &found)] {
        let curves = METHODS.iter().zip(runs).map(|((method, _), run)| {
            let errors = off(run);
            let near = errors.len() - DRAWN.min(errors.len());
            let points: Vec<(f64, f64)> = (near..errors.len()).map(|i| (place(i), errors[i])).collect();
            rows.extend(points.iter().map(|(y, error)| row![format!("error after {step} steps"), *method, *y, *error]));
            Series::new(*method, points, Mark::Line)
        });
        profiles.push((step, curves.collect::<Vec<_>>()));
    }
    let height = profiles.iter().flat_map(|(_, curves)| curves).flat_map(|curve| &curve.points);
    let height = 1.05 * height.map(|point| point.1.abs()).largest();
    let courses: Vec<Series> = METHODS
        .iter()
        .zip(&found)
        .map(|((method, _), run)| {
            let points: Vec<(f64, f64)> = (1..).map(f64::from).zip(&run.errors).map(|(n, (_, e))| (n, *e)).collect();
            rows.extend(points.iter().map(|(n, error)| row!["error", *method, *n, *error]));
            Series::new(*method, points, Mark::LineMarkers)
        })
        .collect();
    // −1 where the errors after two steps are the same but for their signs.
    let (one, next_one) = (off(&before[TRAPEZOIDAL]), off(&found[TRAPEZOIDAL]));
    let alternation = dot(&one, &next_one) / (dot(&one, &one) * dot(&next_one, &next_one)).sqrt();
    // How far a profile goes up and down between the walls, in heights of the exact one, which is monotone.
    let waves: Vec<f64> =
        found.iter().map(|run| variation(&profile(&run.state)) / variation(&profile(&run.exact))).collect();
    let after = |step: usize| found.iter().map(|run| run.errors[step].1).collect::<Vec<f64>>();
    let (first, last) = (after(0), after(STEPS as usize - 1));
    let next = first[1..].iter().map(|error| error / first[0]).smallest();
    let damped = waves[2..].iter().copied().largest();
    let best = (0..METHODS.len()).min_by(|a, b| last[*a].total_cmp(&last[*b])).unwrap_or_default();
    // The first step from which on the last winner has the smallest error.
    let wins = |step: &usize| after(*step).iter().all(|error| after(*step)[best] <= *error);
    let overtaken = (0..STEPS as usize).rev().take_while(wins).last().unwrap_or_default() + 1;
    let mut fast = Vec::new();
    for (method, _) in METHODS {
        fast.push(OneStep::growth(method, 1e6).or_infinity(context)?);
    }
    // The largest eigenvalue of the second difference on the cells, whose length is 2/CELLS.
    let cells = f64::from(CELLS);
    let stiffest = H * (cells * (0.5 * PI / cells).cos()).powi(2);
    let mut left = Vec::new();
    for (method, _) in METHODS {
        left.push(brief(OneStep::growth(method, stiffest).or_infinity(context)?));
    }
    let [method_i, rule, tr_bdf2, sdirk2, radau] = &left[..] else { return Err("five methods".into()) };
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
            "ringing/alternates",
            "From each step to the next the error of the trapezoidal rule changes its sign: cosine of the angle between two",
            alternation,
            Requirement::Below(0.0),
            "the last two steps",
        ),
        Check::new(
            "ringing/fast",
            "At a step that is long for it, a fast wave is damped to nothing by Method I, TR-BDF2, SDIRK2 and Radau IIA: largest |R|",
            fast.iter().enumerate().filter(|(i, _)| *i != TRAPEZOIDAL).map(|(_, r)| r.abs()).largest(),
            Requirement::AtMost(1e-5),
            "hλ = 10⁶, and |R| falls like 1/(hλ) at least with a constant below 10",
        ),
        Check::within(
            "ringing/turns",
            "The trapezoidal rule only turns its sign: R",
            fast[TRAPEZOIDAL],
            [-1.0, -0.999],
            "hλ = 10⁶; R = −1 + 4/(hλ + 2)",
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
            Requirement::AtMost(ONCE),
            "R(∞) = 0; the difference of the walls is its height, whatever its error",
        ),
        Check::new(
            "ringing/others",
            "So do the profiles of TR-BDF2, SDIRK2 and Radau IIA: largest variation over that of the exact one",
            damped,
            Requirement::AtMost(ONCE),
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
            "the smallest of the four others",
        ),
    ];
    let values = [
        ("cells", CELLS.to_string()),
        ("h", H.to_string()),
        ("steps", STEPS.to_string()),
        ("before", (STEPS - 1).to_string()),
        ("t", brief(t_end)),
        ("waves", brief(waves[1])),
        ("first", brief(next)),
        ("last", brief(last[1] / last[0])),
        ("later_best", format!("`{}`", METHODS[best].0)),
        ("overtaken", overtaken.to_string()),
        ("stiffest", digits(stiffest, 3)),
        ("method_i", method_i.clone()),
        ("rule", rule.clone()),
        ("tr_bdf2", tr_bdf2.clone()),
        ("sdirk2", sdirk2.clone()),
        ("radau", radau.clone()),
    ];
    let near = |(step, curves): (u32, Vec<Series>)| {
        let axis = Axis::linear("error of u").between(-height, height);
        Panel::new(Axis::linear("y"), axis, curves).titled(format!("Next to the wall, after {step} steps"))
    };
    let mut panels: Vec<Panel> = profiles.into_iter().map(near).collect();
    panels.push(Panel::new(Axis::linear("step"), Axis::log("largest error"), courses).titled("Step by step"));
    let caption =
        "Errors next to the wall over y after two numbers of steps, and the largest error over the number of steps.";
    Ok(Answer {
        id: "answer-ringing",
        question: "Does Method I ring after a jump?",
        short: "no".into(),
        text: prose::fill(include_str!("ringing.md"), &values)?,
        checks,
        figure: Some(Figure::new("answer-ringing", "", "answer-ringing", panels).in_columns(3)),
        table: Table::data("answer-ringing", caption, ["what", "method", "y_or_step", "value"], rows),
    })
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The profile from the wall at rest to the one that moves with speed 1: the unknowns are the velocities between them.
fn profile(inside: &[f64]) -> Vec<f64> {
    [&[0.0], inside, &[1.0]].concat()
}

/// Σ |uᵢ₊₁ − uᵢ|.
fn variation(values: &[f64]) -> f64 {
    values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum()
}
