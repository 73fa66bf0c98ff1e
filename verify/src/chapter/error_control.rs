//! Two computable measures of the error of a step: the estimate of adaptive Radau IIA, and the least-squares action.

use lsvi::adaptive::{Options, Radau, Tolerances};
use lsvi::closure::Linear;
use lsvi::discrete::{DiscreteLagrangian, Galerkin, Interval};
use lsvi::quadrature::Quadrature;
use lsvi::{Integrator, OneStep, State, Trajectory, Variational};

use super::parts::order_check;
use super::{Context, Study, StudyError};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Requirement, Series, Table};
use crate::measure::norm::{Extremes, distance, max_norm};
use crate::measure::order::{Expectation, Sample, fit};
use crate::method;
use crate::problem::{self, Problem};
use crate::run::run;

pub(super) const STUDY: Study = Study {
    id: "error-control",
    title: "Error control",
    question: "Does an adaptive method keep its tolerance, and what does the least action say about the error of a step?",
    source: "[HW96] IV.8; the action of [S24] Eq. (15) as an indicator",
    run: study,
};

fn study(context: &Context) -> Result<Evidence, StudyError> {
    context.announce(3);
    let mut evidence = Evidence { notes: notes(), ..Evidence::default() };
    tolerances(&mut evidence)?;
    context.tick();
    grid(&mut evidence)?;
    context.tick();
    actions(&mut evidence)?;
    context.tick();
    Ok(evidence)
}

/// Errors up to this many tolerances keep it: one digit, for a tolerance is on the error of a step and not of a run.
const KEPT: f64 = 10.0;

/// The problem among them that is stiff.
const STIFF: &str = "prothero-robinson";

/// Tolerance asked for against error made, by `radau-adaptive`.
fn tolerances(evidence: &mut Evidence) -> Result<(), StudyError> {
    let mut rows = Vec::new();
    let mut curves = Vec::new();
    for name in ["logistic", "damped-pendulum", "van-der-pol", STIFF] {
        let problem = problem::build(name, &[])?;
        // Over ten time units the forcing takes the error of a stiff component through all its sizes.
        let horizon = if name == STIFF { 10.0 } else { problem.horizon() };
        let truth = problem.exact(horizon).or_else(|| problem.tabulated(horizon)).ok_or("no truth is known")?;
        let mut points = Vec::new();
        for k in 4..=20 {
            let tolerance = 10_f64.powf(-0.5 * f64::from(k));
            let tolerances = Tolerances::new(tolerance, tolerance)?;
            let method = method::parse("radau-adaptive")?.with_tolerances(tolerances).ok_or("it is adaptive")?;
            let run = run(&*problem, &*method, horizon, horizon, |_| {})?;
            let (error, work) = (distance(&run.end.q, &truth), run.work);
            let counts = [work.steps, work.residuals, work.factorizations].map(|count| Cell::Integer(count as i64));
            let row = [Cell::Text(name.into()), Cell::Number(tolerance), Cell::Number(error)];
            rows.push(row.into_iter().chain(counts).collect());
            points.push((tolerance, error));
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
        curves.push(Series::new(name, points, Mark::LineMarkers));
    }
    let guide = |label: &str, exponent: f64| {
        let ends = [1e-10_f64, 1e-2].map(|tolerance| (tolerance, tolerance.powf(exponent)));
        Series::new(label, ends.to_vec(), Mark::Guide)
    };
    curves.extend([guide("error = tolerance", 1.0), guide("error = tolerance^(2/3)", 2.0 / 3.0)]);
    let caption = "Error of radau-adaptive at the end of the run against its tolerance, relative and absolute alike.";
    let columns = ["problem", "tolerance", "error", "steps", "evaluations", "factorizations"];
    evidence.tables.push(Table::data("tolerances", caption, &columns, rows));
    let axes = (Axis::log("tolerance"), Axis::log("error at the end"));
    evidence.figures.push(Figure {
        id: "tolerances".into(),
        caption: caption.into(),
        data: "tolerances".into(),
        panels: vec![Panel { x: axes.0, y: axes.1, series: curves, ..Panel::default() }],
        columns: 1,
    });
    Ok(())
}

/// Rejected steps come and go with a tolerance: the part, and the number of steps, by which work may fall as it tightens.
const SPARED: (f64, f64) = (1.1, 3.0);

/// Both tolerances varied on their own: what is tolerated in each cell against the error made, and the steps of order 5.
fn grid(evidence: &mut Evidence) -> Result<(), StudyError> {
    let exponents = || (2..=14).step_by(2);
    let mut rows = Vec::new();
    for name in ["logistic", "damped-pendulum", "van-der-pol", STIFF] {
        let problem = problem::build(name, &[])?;
        let horizon = problem.horizon();
        let truth = problem.exact(horizon).or_else(|| problem.tabulated(horizon)).ok_or("no truth is known")?;
        let mut cells = Vec::new();
        for (r, a) in exponents().flat_map(|r| exponents().map(move |a| (r, a))) {
            let (rtol, atol) = (10_f64.powi(-r), 10_f64.powi(-a));
            let tolerances = Tolerances::new(rtol, atol)?;
            let method =
                method::parse("radau-adaptive")?.with_tolerances(tolerances.clone()).ok_or("it is adaptive")?;
            let run = run(&*problem, &*method, horizon, horizon, |_| {})?;
            let mut fixed = Radau::new(problem.field(), Options::new(tolerances).stages(3, 3)?)?;
            Trajectory::new(&mut fixed, State::new(0.0, problem.initial()), horizon, horizon)?.observe(|_| ())?;
            let tried = fixed.work().steps + fixed.rejected();
            let tolerated = atol + rtol * max_norm(&truth);
            let held = if name == STIFF { tolerated.max(tolerated.powf(2.0 / 3.0)) } else { tolerated };
            let error = distance(&run.end.q, &truth);
            cells.push(((r, a), held, error, tried as f64));
            let counts = [run.work.steps, tried].map(|count| Cell::Integer(count as i64));
            let row = [Cell::Text(name.into()), Cell::Number(rtol), Cell::Number(atol), Cell::Number(error)];
            rows.push(row.into_iter().chain(counts).collect());
        }
        evidence.checks.push(Check::new(
            format!("grid/{name}/error"),
            format!("On {name} the error of radau-adaptive falls with each of rtol and atol: largest ratio to what is tolerated"),
            cells.iter().map(|(_, held, error, _)| error / held).largest(),
            Requirement::AtMost(KEPT),
            "a bound that falls with each tolerance, held in every cell from 1e-2 to 1e-14 of both; atol + rtol |v|, or its \
             power 2/3 where that is more and the problem is stiff",
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
                   tried: steps with three stages alone, rejected ones among them.";
    let columns = ["problem", "rtol", "atol", "error", "steps", "tried"];
    evidence.tables.push(Table::data("tolerance-grid", caption, &columns, rows));
    Ok(())
}

/// √(2 h L_d) beside the true error of a step.
fn actions(evidence: &mut Evidence) -> Result<(), StudyError> {
    const PROBLEMS: [&str; 4] = ["logistic", "quadratic-drag", "damped-pendulum", "van-der-pol"];
    let mut rows = Vec::new();
    let mut panels = Vec::new();
    for degree in 1..=3_u32 {
        let mut curves = Vec::new();
        for name in PROBLEMS {
            let problem = problem::build(name, &[])?;
            let floor = max_norm(&problem.initial()) * f64::EPSILON;
            let mut indicators = Vec::new();
            let mut errors = Vec::new();
            let mut least = f64::INFINITY;
            for k in 0..=14 {
                let h = 0.5 * 2_f64.powf(-0.5 * f64::from(k));
                let step = one_step(&*problem, degree, degree + 1, h)?;
                // The residual of a path of degree s at a node is a sum of s + 1 values with weights up to s²/h.
                indicators.push(Sample::new(h, step.indicator, f64::from(degree * degree * 4) * floor));
                // One rounding or two of the step, and of each of the eight that give the truth.
                errors.push(Sample::new(h, step.error, 16.0 * floor));
                if step.error > 160.0 * floor {
                    least = least.min(step.indicator / step.error);
                }
                rows.push(vec![
                    Cell::Text(name.into()),
                    Cell::Integer(degree.into()),
                    Cell::Number(h),
                    Cell::Number(step.indicator),
                    Cell::Number(step.error),
                ]);
            }
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
                least,
                Requirement::AtLeast(1.0),
                "steps from 0.5 to 0.004 with an error above roundoff",
            ));
            let collocation = one_step(&*problem, degree + 1, degree + 1, 0.1)?;
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
        let (title, x, y) = (format!("degree {degree}"), Axis::log("h"), Axis::log("indicator, error of one step"));
        panels.push(Panel { title, x, y, series: curves, ..Panel::default() });
    }
    let caption = "The action's √(2 h L_d), dashed, and the true error of the first step of ls-galerkin(s,lobatto,s+1), Method I.";
    evidence.tables.push(Table::data(
        "action-indicator",
        caption,
        &["problem", "degree", "h", "indicator", "error"],
        rows,
    ));
    let (id, caption, data) = ("action-indicator".into(), caption.into(), "action-indicator".into());
    evidence.figures.push(Figure { id, caption, data, panels, columns: 3 });
    Ok(())
}

/// What the action says of a step, and the truth.
struct Step {
    indicator: f64,
    error: f64,
}

/// The first step of paths of the given degree on Lobatto's nodes, closed by Method I.
fn one_step(problem: &dyn Problem, degree: u32, nodes: u32, h: f64) -> Result<Step, StudyError> {
    let q0 = problem.initial();
    let discrete = Galerkin::new(problem.lagrangian()?, degree as usize, &Quadrature::lobatto(nodes as usize)?)?;
    let mut method = Variational::new(discrete, Linear::METHOD_I);
    let (mut q, mut p) = (q0.clone(), vec![0.0; q0.len()]);
    method.step(0.0, h, &mut q, &mut p)?;
    let unknowns = method.unknowns().to_vec();
    let action = method.discrete_mut().action(Interval { start: 0.0, h }, &q0, &unknowns);
    // Collocation of order 12 on eight pieces of the step: far below the error of a step of order seven.
    let truth = run(problem, &*method::parse("ls-galerkin(6,gauss,6)")?, h / 8.0, h, |_| {})?.end.q;
    Ok(Step { indicator: (2.0 * h * action).sqrt(), error: distance(&q, &truth) })
}

fn notes() -> Vec<String> {
    vec![
        "`radau-adaptive` makes errors of the size of its tolerance where the problem is not stiff. With s stages its estimate \
         is of order s and its solution of order 2s − 1, and to make up for that the estimate is held to \
         0.1 tol^{(s+1)/2s}, or to the tolerance where that is more; on a stiff component, whose error is as large as the \
         estimate, that is what remains. Ask for a smaller tolerance there."
            .into(),
        "The least-squares action of a step measures its residual. `√(2 h L_d)` bounds the error of the step from above, \
         at no cost beyond the step, but it falls with `h^{s+1}` and the error with `h^{2s+1}`: for s = 1 it is a useful \
         estimate, and for paths of higher degree a pessimistic one. With as many nodes as degrees it is zero and says \
         nothing."
            .into(),
    ]
}
