//! Two computable measures of the error of a step: the estimate of adaptive Radau IIA, and the least-squares action.

use super::parts::order_check;
use super::{Context, Study, StudyError, prose};
use crate::evidence::number::{between, brief, rounded_up};
use crate::evidence::{Axis, Check, Evidence, Figure, Mark, Panel, Requirement, Series, Table};
use crate::experiment::error_control::{ActionStep, Growth, OfOrder5, Tolerated};
use crate::measure::norm::{Extremes, max_norm};
use crate::measure::order::{Expectation, Sample, fit};
use crate::problem;
use crate::row;

pub(super) const STUDY: Study = Study {
    id: "error-control",
    title: "Error control",
    question: "Does an adaptive method keep its tolerance, and what does the least action say about the error of a step?",
    source: "[HW96] IV.8; the action of [S24] Eq. (15) as an indicator",
    run: study,
};

fn study(context: &Context) -> Result<Evidence, StudyError> {
    let mut evidence = Evidence::default();
    tolerances(&mut evidence, context)?;
    let rises = grid(&mut evidence, context)?;
    actions(&mut evidence, context, rises)?;
    Ok(evidence)
}

/// Errors up to this many tolerances keep it: one digit, for a tolerance is on the error of a step and not of a run.
const KEPT: f64 = 10.0;

/// The problems; the last is stiff.
const PROBLEMS: [&str; 4] = ["logistic", "damped-pendulum", "van-der-pol", STIFF];
const STIFF: &str = "prothero-robinson";

/// The end of a run. Over ten time units the forcing takes the error of a stiff component through all its sizes.
fn horizon(name: &str) -> Result<f64, StudyError> {
    Ok(if name == STIFF { 10.0 } else { problem::build_setting(name)?.horizon() })
}

/// Tolerance asked for against error made, by `radau-adaptive`.
fn tolerances(evidence: &mut Evidence, context: &Context) -> Result<(), StudyError> {
    let mut rows = Vec::new();
    for name in PROBLEMS {
        let horizon = horizon(name)?;
        let mut points = Vec::new();
        for k in 4..=20 {
            let tol = 10_f64.powf(-0.5 * f64::from(k));
            let run = context.get(Tolerated { problem: name, horizon, rtol: tol, atol: tol })?;
            rows.push(row![name, horizon, tol, run.error, run.work.steps, run.work.residuals, run.work.factorizations]);
            points.push((tol, run.error));
        }
        let worst = |exponent: f64| points.iter().map(|(tol, e)| e / tol.powf(exponent)).largest();
        if name == STIFF {
            evidence.checks.push(Check::new(
                format!("tolerance/{name}/exceeded"),
                format!("The error of radau-adaptive on {name}, which is stiff, exceeds its tolerance: largest ratio of the two"),
                worst(1.0),
                Requirement::AtLeast(KEPT),
                "the estimate of s stages is held to 0.1 tol^{(s+1)/2s}, and the error of a stiff component is as large as its estimate",
            ));
            evidence.checks.push(Check::new(
                format!("tolerance/{name}"),
                format!("The error of radau-adaptive on {name} stays below tol^{{2/3}}: largest ratio of the two"),
                worst(2.0 / 3.0),
                Requirement::AtMost(1.0),
                "a digit above what the estimate is held to",
            ));
        } else {
            evidence.checks.push(Check::new(
                format!("tolerance/{name}"),
                format!(
                    "The error of radau-adaptive on {name} at the end keeps its tolerance: largest ratio of the two"
                ),
                worst(1.0),
                Requirement::AtMost(KEPT),
                "tolerances from 1e-2 to 1e-10, the relative and the absolute one the same",
            ));
        }
    }
    let guide = |label: &str, exponent: f64| {
        let ends = [1e-10_f64, 1e-2].map(|tolerance| (tolerance, tolerance.powf(exponent)));
        Series::new(label, ends.to_vec(), Mark::Guide)
    };
    let caption = "Error of radau-adaptive at the end of the run against its tolerance, relative and absolute alike.";
    let columns = ["problem", "t_end", "tolerance", "error", "steps", "evaluations", "factorizations"];
    let table = Table::data("tolerances", caption, columns, rows);
    let mut curves = table.curves("problem", "tolerance", "error", Mark::LineMarkers);
    curves.extend([guide("error = tolerance", 1.0), guide("error = tolerance^(2/3)", 2.0 / 3.0)]);
    let panel = Panel::new(Axis::log("tolerance"), Axis::log("error at the end"), curves);
    evidence.figures.push(Figure::new("tolerances", caption, "tolerances", [panel]));
    evidence.tables.push(table);
    Ok(())
}

/// What the error of a step is of its tolerance at most: the estimate of s stages, of order s, is held to 0.1 tol^{(s+1)/2s}, and the
/// error, of order 2s − 1, is about its power 2s/(s+1), which is 0.1^{3/2} tol with three stages and less with more.
const OF_A_STEP: f64 = 0.031_622_776_601_683_79;

/// The smallest power (s + 1)/2s of a tolerance that an estimate is held to, that of seven stages.
const OF_AN_ESTIMATE: f64 = 4.0 / 7.0;

/// A run with tolerances of its own in either direction.
struct Cell {
    /// Minus the exponents of rtol and atol.
    at: [i32; 2],
    /// What the error is held to.
    bound: f64,
    /// The largest error on the way.
    largest: f64,
    /// The steps of order 5.
    steps: f64,
}

impl Cell {
    /// Whether both tolerances are smaller by so many digits at least.
    fn is_looser(&self, other: &Self, digits: i32) -> bool {
        self.at.iter().zip(&other.at).all(|(at, other)| at + digits <= *other)
    }
}

/// What an error is held to in so many steps along a solution of this size whose neighbours part by this factor.
fn bound(name: &str, tolerated: f64, (steps, growth, size): (f64, f64, f64)) -> f64 {
    if name == STIFF {
        // The error of a step is as large as its estimate and dies out in the next.
        tolerated.max(tolerated.powf(OF_AN_ESTIMATE))
    } else {
        steps * growth * (OF_A_STEP * tolerated + f64::EPSILON * size)
    }
}

/// The two cells of which the second has tolerances smaller by so many digits and the largest share of the first one's error, NaN before all
/// others.
fn worst(cells: &[Cell], digits: i32) -> Option<(f64, &Cell, &Cell)> {
    let pairs = cells.iter().flat_map(|cell| cells.iter().map(move |other| (cell, other)));
    let pairs = pairs.filter(|(looser, tighter)| looser.at != tighter.at && looser.is_looser(tighter, digits));
    let rises = pairs.map(|(looser, tighter)| (tighter.largest / looser.largest, looser, tighter));
    // NaN is above all numbers.
    rises.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
}

/// Both tolerances varied on their own: what is tolerated in each cell against the error made, and the steps of order 5. Returns what the prose says
/// of it.
fn grid(evidence: &mut Evidence, context: &Context) -> Result<[(&'static str, String); 3], StudyError> {
    let exponents = || (2..=14).step_by(2);
    let (mut rows, mut rises) = (Vec::new(), Vec::new());
    let (mut most, mut shares) = ((0.0, ""), Vec::new());
    for name in PROBLEMS {
        let horizon = horizon(name)?;
        let growth = *context.get(Growth { problem: name, horizon })?;
        let mut cells = Vec::new();
        for (r, a) in exponents().flat_map(|r| exponents().map(move |a| (r, a))) {
            let (rtol, atol) = (10_f64.powi(-r), 10_f64.powi(-a));
            let setting = Tolerated { problem: name, horizon, rtol, atol };
            let (run, of_order_5) = (context.get(setting)?, context.get(OfOrder5(setting))?);
            let bound = bound(name, atol + rtol * run.size, (run.work.steps as f64, growth, run.size));
            cells.push(Cell { at: [r, a], bound, largest: run.largest, steps: of_order_5.accepted as f64 });
            let (accepted, rejected) = (of_order_5.accepted, of_order_5.rejected);
            rows.push(row![
                name,
                horizon,
                rtol,
                atol,
                bound,
                run.largest,
                run.error,
                run.work.steps,
                accepted,
                rejected
            ]);
        }
        evidence.checks.extend(monotone(name, &cells));
        if let Some((rise, looser, tighter)) = worst(&cells, 0) {
            let [from, to] = [looser, tighter].map(|cell| cell.at.map(|k| 10_f64.powi(-k)));
            let share = tighter.largest / tighter.bound;
            shares.push(share);
            if rise > most.0 {
                most = (rise, name);
            }
            rises.push(row![name, from[0], from[1], looser.largest, to[0], to[1], tighter.largest, rise, share]);
        }
    }
    let caption = "Largest error of radau-adaptive on the way and its bound, the error at the end, and steps, at relative and absolute \
                   tolerances of their own; accepted, rejected: steps with three stages alone.";
    let columns = ["problem", "t_end", "rtol", "atol", "bound", "largest", "error", "steps", "accepted", "rejected"];
    evidence.tables.push(Table::data("tolerance-grid", caption, columns, rows));
    let caption = "Where smaller tolerances make the largest error rise most: both runs, the rise, and the part of its bound that the \
                   larger error is.";
    let columns =
        ["problem", "from rtol", "from atol", "from error", "to rtol", "to atol", "to error", "rise", "of bound"];
    evidence.tables.push(Table::new("tolerance-rises", caption, columns, rises));
    let share = brief(rounded_up(shares.into_iter().largest(), 2));
    Ok([("rise", brief(rounded_up(most.0, 2))), ("rises", format!("`{}`", most.1)), ("of_bound", share)])
}

/// Errors below a bound that falls with each tolerance, and errors that fall and steps that grow where both do.
fn monotone(name: &str, cells: &[Cell]) -> [Check; 3] {
    let pairs = cells.iter().flat_map(|cell| cells.iter().map(move |other| (cell, other)));
    let tighter = pairs.filter(|(looser, tighter)| looser.is_looser(tighter, 2));
    let source = match name == STIFF {
        true => {
            "in every cell from 1e-2 to 1e-14 of both the bound is the power 4/7 of atol + rtol |v|, a digit above what the estimate is held to"
        }
        false => {
            "in every cell from 1e-2 to 1e-14 of both the bound is 0.1^{3/2} (atol + rtol |v|) and a rounding for each step, times what \
             neighbours of the solution part by"
        }
    };
    [
        Check::new(
            format!("grid/{name}/error"),
            format!(
                "On {name} no error of radau-adaptive on the way exceeds a bound that falls with each of rtol and atol: largest ratio of the two"
            ),
            cells.iter().map(|cell| cell.largest / cell.bound).largest(),
            Requirement::AtMost(1.0),
            source,
        ),
        Check::new(
            format!("grid/{name}/falls"),
            format!(
                "On {name} the largest error of radau-adaptive falls where both tolerances fall to a hundredth or less: largest ratio of the later to the earlier"
            ),
            worst(cells, 2).map_or(f64::NAN, |(rise, ..)| rise),
            Requirement::Below(1.0),
            "from one number and place of steps to another an error scatters by less than that",
        ),
        Check::new(
            format!("grid/{name}/work"),
            format!(
                "On {name} radau-adaptive takes no fewer steps of order 5 where both tolerances fall to a hundredth or less: largest ratio of the earlier number to the later"
            ),
            tighter.map(|(looser, tighter)| looser.steps / tighter.steps).largest(),
            Requirement::AtMost(1.0),
            "between tolerances that hardly differ, as where the other one decides, the number scatters",
        ),
    ]
}

/// √(2 h L_d) beside the true error of a step.
fn actions(evidence: &mut Evidence, context: &Context, rises: [(&'static str, String); 3]) -> Result<(), StudyError> {
    const TIMES: [&str; 3] = ["times_1", "times_2", "times_3"];
    const SMOOTH: [&str; 4] = ["logistic", "quadratic-drag", "damped-pendulum", "van-der-pol"];
    let mut rows = Vec::new();
    let mut values = vec![("problems", SMOOTH.len().to_string())];
    let mut first_steps = 0;
    let mut panels = Vec::new();
    for degree in 1..=3_u32 {
        let mut curves = Vec::new();
        let mut of_degree = Vec::new();
        for name in SMOOTH {
            let problem = problem::build_setting(name)?;
            let floor = max_norm(&problem.initial()) * f64::EPSILON;
            let mut indicators = Vec::new();
            let mut errors = Vec::new();
            let mut ratios = Vec::new();
            for k in 0..=14 {
                let h = 0.5 * 2_f64.powf(-0.5 * f64::from(k));
                let step = context.get(ActionStep { problem: name, degree, nodes: degree + 1, h })?;
                // The residual of a path of degree s at a node is a sum of s + 1 values with weights up to s²/h.
                indicators.push(Sample::new(h, step.indicator, f64::from(degree * degree * 4) * floor));
                // One rounding or two of the step, and of each of the eight that give the truth.
                errors.push(Sample::new(h, step.error, 16.0 * floor));
                // NaN is an error too.
                if step.error.is_nan() || step.error > 160.0 * floor {
                    ratios.push(step.indicator / step.error);
                }
                rows.push(row![name, degree, h, step.indicator, step.error]);
            }
            of_degree.extend(ratios.iter().copied());
            let id = |what: &str| format!("action/{name}/{degree}/{what}");
            let method = format!("ls-galerkin({degree},lobatto,{})", degree + 1);
            let orders = [
                ("indicator", "√(2 h L_d)", &indicators, degree + 1),
                ("local-error", "the error of one step", &errors, 2 * degree + 1),
            ];
            // At degree 3 the error meets roundoff before its slope has settled.
            let measurable = if degree < 3 { 2 } else { 1 };
            for (what, words, samples, order) in orders.into_iter().take(measurable) {
                let fitted = fit(samples, &Expectation::new(order.into(), 0.1));
                let statement = format!("{words} of {method} on {name} is of order {order}");
                evidence.checks.push(order_check(id(what), statement, &fitted));
            }
            evidence.checks.push(Check::new(
                id("bound"),
                format!("√(2 h L_d) of {method} on {name} is no less than the error of the step: least ratio"),
                ratios.into_iter().smallest(),
                Requirement::AtLeast(1.0),
                "steps from 0.5 to 0.004 with an error above roundoff",
            ));
            let nodes = degree + 1;
            let collocation = context.get(ActionStep { problem: name, degree: nodes, nodes, h: 0.1 })?;
            evidence.checks.push(Check::new(
                id("collocation"),
                format!("With as many nodes as degrees, {}, the action on {name} is zero", degree + 1),
                collocation.indicator,
                Requirement::AtMost(f64::from((degree + 1) * (degree + 1) * 4) * floor),
                "the residual vanishes at the nodes, up to rounding",
            ));
            for (what, samples, mark) in [("√(2 h L_d)", indicators, Mark::Guide), ("error", errors, Mark::LineMarkers)]
            {
                let measured = samples.iter().filter_map(|s| Some((s.h, s.result.as_ref().ok()?)));
                let points = measured.filter(|(_, m)| m.error > m.floor).map(|(h, m)| (h, m.error));
                curves.push(Series::new(format!("{name}, {what}"), points.collect(), mark));
            }
        }
        first_steps += of_degree.len();
        let range = || of_degree.iter().copied();
        values.push((TIMES[degree as usize - 1], between(range().smallest(), range().largest())));
        let y = Axis::log("indicator, error of one step");
        panels.push(Panel::new(Axis::log("h"), y, curves).titled(format!("degree {degree}")));
    }
    let caption = "The action's √(2 h L_d), grey and without markers, and the true error of the first step of ls-galerkin(s,lobatto,s+1), Method I.";
    let columns = ["problem", "degree", "h", "indicator", "error"];
    evidence.tables.push(Table::data("action-indicator", caption, columns, rows));
    let figure = Figure::new("action-indicator", caption, "action-indicator", panels);
    evidence.figures.push(figure.in_columns(3));
    values.push(("first_steps", first_steps.to_string()));
    values.extend(rises);
    evidence.notes.extend(prose::fill(include_str!("error_control.md"), &values)?);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_stiff_may_have_the_power_of_its_tolerance() {
        for name in PROBLEMS.into_iter().filter(|name| *name != STIFF) {
            let of = |tolerated: f64| bound(name, tolerated, (10.0, 3.0, 2.0)) / (30.0 * tolerated);
            assert!(
                (of(1e-3) - 0.1_f64.powf(1.5)).abs() < 1e-11 && (of(8.0) - 0.1_f64.powf(1.5)).abs() < 1e-14,
                "{name}"
            );
            assert!((bound(name, 0.0, (10.0, 3.0, 2.0)) / f64::EPSILON - 60.0).abs() < 1e-9, "{name}");
        }
        // Above one the power is less.
        let of = |tolerated: f64| bound(STIFF, tolerated, (10.0, 3.0, 2.0));
        assert!((of(1e-7) / 1e-4 - 1.0).abs() < 1e-12 && of(8.0) == 8.0);
    }

    /// On a grid of three by three, an error of a hundredth for each digit pair, and two steps more for each digit.
    #[test]
    fn a_rise_and_fewer_steps_are_refused_where_both_tolerances_fall() {
        let cells = || -> Vec<Cell> {
            let all = [2, 4, 6].into_iter().flat_map(|r| [2, 4, 6].map(|a| [r, a]));
            let cell = |at: [i32; 2]| {
                let digits = f64::from(at[0].min(at[1]));
                Cell { at, bound: 10_f64.powf(-digits), largest: 0.5 * 10_f64.powf(-digits), steps: 2.0 * digits }
            };
            all.map(cell).collect()
        };
        let outcomes = |spoil: fn(&mut Vec<Cell>)| {
            let mut cells = cells();
            spoil(&mut cells);
            monotone("logistic", &cells).map(|check| check.outcome == crate::evidence::Outcome::Pass)
        };
        assert_eq!(outcomes(|_| {}), [true; 3]);
        // The second cell is beside the first, and the fifth a hundredth of it in both.
        assert_eq!(outcomes(|cells| cells[1].largest *= 1.9), [true; 3]);
        assert_eq!(outcomes(|cells| cells[1].largest *= 2.1), [false, true, true]);
        assert_eq!(outcomes(|cells| (cells[4].bound, cells[4].largest) = (1.0, 0.5)), [true, false, true]);
        assert_eq!(outcomes(|cells| cells[8].largest = f64::NAN), [false, false, true]);
        assert_eq!(outcomes(|cells| cells[3].steps = 3.0), [true; 3]);
        assert_eq!(outcomes(|cells| cells[4].steps = 3.0), [true, true, false]);
        let cells = cells();
        let (rise, looser, tighter) = worst(&cells, 2).expect("a pair");
        assert!((rise - 1e-2).abs() < 1e-12 && looser.is_looser(tighter, 2));
    }
}
