//! Two computable measures of the error of a step: the estimate of adaptive Radau IIA, and the least-squares action.

use super::parts::order_check;
use super::{Context, Study, StudyError, prose};
use crate::evidence::number::between;
use crate::evidence::{Axis, Check, Evidence, Figure, Mark, Panel, Requirement, Series, Table};
use crate::experiment::error_control::{ActionStep, StepsOfOrder5, Tolerated};
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
    grid(&mut evidence, context)?;
    actions(&mut evidence, context)?;
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

/// Rejected steps come and go with a tolerance: the part, and the number of steps, by which work may fall as it tightens.
const SPARED: (f64, f64) = (1.1, 3.0);

/// What an error is held to, within [`KEPT`], where so much is tolerated.
fn bound(name: &str, tolerated: f64) -> f64 {
    if name == STIFF { tolerated.max(tolerated.powf(2.0 / 3.0)) } else { tolerated }
}

/// Both tolerances varied on their own: what is tolerated in each cell against the error made, and the steps of order 5.
fn grid(evidence: &mut Evidence, context: &Context) -> Result<(), StudyError> {
    let exponents = || (2..=14).step_by(2);
    let mut rows = Vec::new();
    for name in PROBLEMS {
        let horizon = horizon(name)?;
        let mut cells = Vec::new();
        for (r, a) in exponents().flat_map(|r| exponents().map(move |a| (r, a))) {
            let (rtol, atol) = (10_f64.powi(-r), 10_f64.powi(-a));
            let setting = Tolerated { problem: name, horizon, rtol, atol };
            let (run, tried) = (context.get(setting)?, *context.get(StepsOfOrder5(setting))?);
            let tolerated = atol + rtol * run.size;
            let held = bound(name, tolerated);
            cells.push(((r, a), held, run.error, tried as f64));
            rows.push(row![name, horizon, rtol, atol, held, run.error, run.work.steps, tried]);
        }
        evidence.checks.push(Check::new(
            format!("grid/{name}/error"),
            format!("On {name} the error of radau-adaptive keeps to a bound that falls with each of rtol and atol: largest ratio of the two"),
            cells.iter().map(|(_, held, error, _)| error / held).largest(),
            Requirement::AtMost(KEPT),
            "in every cell from 1e-2 to 1e-14 of both the bound is atol + rtol |v|, or its power 2/3 where that is more and the problem is \
             stiff; from one tolerance to the next the error itself may rise",
        ));
        let neighbours = cells.iter().flat_map(|cell| cells.iter().map(move |other| (cell, other)));
        let tighter = neighbours.filter(|(((r, a), ..), ((k, l), ..))| k >= r && l >= a);
        evidence.checks.push(Check::new(
            format!("grid/{name}/work"),
            format!("On {name} the steps of order 5 grow with each of rtol and atol: largest ratio of fewer asked for to more"),
            tighter.map(|((.., few), (.., many))| (few - SPARED.1) / many).largest(),
            Requirement::AtMost(SPARED.0),
            "what the estimate is held to grows with each tolerance; three steps and a tenth of them for rejections",
        ));
    }
    let caption = "Error of radau-adaptive at the end of the run and steps, at relative and absolute tolerances of their own; \
                   bound: a tenth of what the error may be; tried: steps with three stages alone, rejected ones among them.";
    let columns = ["problem", "t_end", "rtol", "atol", "bound", "error", "steps", "tried"];
    evidence.tables.push(Table::data("tolerance-grid", caption, columns, rows));
    Ok(())
}

/// √(2 h L_d) beside the true error of a step.
fn actions(evidence: &mut Evidence, context: &Context) -> Result<(), StudyError> {
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
    let caption = "The action's √(2 h L_d), dashed, and the true error of the first step of ls-galerkin(s,lobatto,s+1), Method I.";
    let columns = ["problem", "degree", "h", "indicator", "error"];
    evidence.tables.push(Table::data("action-indicator", caption, columns, rows));
    let figure = Figure::new("action-indicator", caption, "action-indicator", panels);
    evidence.figures.push(figure.in_columns(3));
    values.push(("first_steps", first_steps.to_string()));
    evidence.notes.extend(prose::fill(include_str!("error_control.md"), &values)?);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_stiff_may_have_the_power_of_its_tolerance() {
        for name in PROBLEMS.into_iter().filter(|name| *name != STIFF) {
            assert_eq!([1e-9, 8.0].map(|tolerated| bound(name, tolerated)), [1e-9, 8.0], "{name}");
        }
        // Above one the power is less.
        assert!((bound(STIFF, 1e-9) / 1e-6 - 1.0).abs() < 1e-12 && bound(STIFF, 8.0) == 8.0);
    }
}
