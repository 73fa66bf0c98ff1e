//! Orders of accuracy of every method on every problem.

use rayon::prelude::*;

use super::parts::order_check;
use super::{Context, Study, StudyError};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Grid, Mark, Outcome, Panel, Series, Table};
use crate::measure::order::OrderFit;
use crate::method::Method;
use crate::order::{OrderError, Source, Truth, measure};
use crate::problem::{self, Problem};
use crate::theory::methods_for;

pub(super) const STUDY: Study = Study {
    id: "orders",
    title: "Orders of accuracy",
    question: "Does every method converge with the order it should, on every problem?",
    source: "[S24] Sections 3–5, [KY21], [MW01]",
    run,
};

/// The order of one method on one problem.
pub(crate) struct Measured {
    pub(crate) problem: String,
    pub(crate) method: String,
    pub(crate) truth: Truth,
    pub(crate) fit: Result<OrderFit, OrderError>,
}

/// Measures the order of `method` on `problem`, against the best truth that there is.
pub(super) fn measure_one(name: &str, problem: &dyn Problem, method: &dyn Method) -> Measured {
    let truth = Source::default_for(problem, method).truth(problem, method);
    Measured { problem: name.into(), method: method.name(), truth, fit: measure(problem, method, truth) }
}

/// Measures every method on every problem that it applies to.
pub(crate) fn measure_all(context: &Context) -> Result<Vec<Measured>, StudyError> {
    let mut pairs = Vec::new();
    for spec in problem::paired() {
        let problem = problem::small(spec.name)?;
        pairs.extend(methods_for(&*problem).into_iter().map(|method| (spec.name, method)));
    }
    context.announce(pairs.len());
    pairs
        .into_par_iter()
        .map(|(name, method)| {
            let problem = problem::small(name)?;
            let measured = measure_one(name, &*problem, &*method);
            context.tick();
            Ok(measured)
        })
        .collect()
}

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let measured = measure_all(context)?;
    Ok(Evidence {
        figures: vec![figure(&measured, problem::paired().map(|spec| spec.name))],
        notes: vec![
            "An order is fitted over the step sizes where the local slopes agree and the error stands clear of its floor; \
             a verdict needs at least four of them, is two-sided, and is inconclusive where the data do not decide. Linear \
             problems super-converge and hide mistakes: the orders that count are those on `quadratic-drag`, `logistic`, \
             `damped-pendulum` and `van-der-pol`, and in mechanics those on `kepler`, `henon-heiles`, `double-pendulum`, \
             `charged-particle` and `spherical-pendulum`."
                .into(),
            "Two reductions are declared. On the Poiseuille ansatz the Lagrangian (37) keeps a remainder that no path \
             removes: every closure but Method II is of first order there, and Method II of second whatever the path. On `prothero-robinson` with hλ ≫ 1 the \
             error of Method I is h|v″|/(2λ), of first order like implicit Euler's, where the trapezoidal rule keeps its \
             second."
                .into(),
            "One super-convergence is declared. A path fitted at an even number of symmetric nodes leaves a defect along an \
             even derivative of q. In uniform motion on a `circle` that is radial and goes into the multiplier, so that two \
             orders are gained there, and nowhere else."
                .into(),
        ],
        ..report(&measured)
    })
}

/// The checks and the tables.
pub(super) fn report(measured: &[Measured]) -> Evidence {
    Evidence {
        checks: measured.iter().map(check).collect(),
        tables: vec![orders(measured), points(measured)],
        grids: vec![grid(measured)],
        ..Evidence::default()
    }
}

/// The orders as a map of methods and problems.
fn grid(measured: &[Measured]) -> Grid {
    let caption = "Measured order less the expected one. Green where it lies within its band, the darker the nearer to its \
                   edge; red where it fails, amber where the data do not decide, grey where nothing is measured. A cell \
                   leads to its check.";
    let mut grid = Grid::new("orders", caption, 2);
    for pair in measured {
        let fit = pair.fit.as_ref().ok();
        let excess = fit.and_then(|fit| fit.line.map(|line| line.slope - fit.expected.order));
        let strain = excess.zip(fit).map_or(0.0, |(excess, fit)| excess.abs() / fit.expected.band);
        grid.push(&pair.method, &pair.problem, excess, strain, format!("{}/{}", pair.problem, pair.method));
    }
    grid
}

fn check(pair: &Measured) -> Check {
    let id = format!("{}/{}", pair.problem, pair.method);
    let statement = format!("{} converges on {} with its order, against {}", pair.method, pair.problem, pair.truth);
    match &pair.fit {
        Ok(fit) => order_check(id, statement, fit),
        Err(error @ OrderError::Untold { .. }) => Check::undecided(id, statement, Outcome::NotRun, error.to_string()),
        Err(error) => Check::undecided(id, statement, Outcome::Inconclusive, error.to_string()),
    }
}

fn orders(measured: &[Measured]) -> Table {
    let rows = measured.iter().filter_map(|pair| {
        let fit = pair.fit.as_ref().ok()?;
        let line =
            |f: fn(&crate::measure::order::Line) -> f64| fit.line.as_ref().map_or(Cell::Empty, |l| Cell::Number(f(l)));
        Some(vec![
            Cell::Text(pair.problem.clone()),
            Cell::Text(pair.method.clone()),
            Cell::Text(pair.truth.to_string()),
            Cell::Number(fit.expected.order),
            line(|l| l.slope),
            line(|l| l.stderr),
            line(|l| l.r_squared),
            Cell::Integer(fit.kept.len() as i64),
            Cell::Integer((fit.kept.len() + fit.dropped.len()) as i64),
            Cell::Text(format!("{:?}", fit.verdict).to_lowercase()),
        ])
    });
    Table {
        id: "orders".into(),
        caption: "Fitted order of every method on every problem, with its standard error and the points it rests on."
            .into(),
        columns: [
            "problem",
            "method",
            "reference",
            "expected",
            "order",
            "stderr",
            "r_squared",
            "points",
            "of",
            "verdict",
        ]
        .map(Into::into)
        .to_vec(),
        rows: rows.collect(),
        shown: true,
    }
}

fn points(measured: &[Measured]) -> Table {
    let mut rows = Vec::new();
    for pair in measured {
        let Ok(fit) = &pair.fit else { continue };
        for (sample, reason) in fit.points() {
            let value = |f: fn(&crate::measure::order::Measured) -> f64| match &sample.result {
                Ok(m) if f(m).is_finite() => Cell::Number(f(m)),
                _ => Cell::Empty,
            };
            rows.push(vec![
                Cell::Text(pair.problem.clone()),
                Cell::Text(pair.method.clone()),
                Cell::Number(sample.h),
                value(|m| m.error),
                value(|m| m.floor),
                Cell::Text(reason.map_or_else(|| "kept".into(), ToString::to_string)),
            ]);
        }
    }
    Table {
        id: "order-points".into(),
        caption: "Errors behind the fitted orders, and what became of each point.".into(),
        columns: ["problem", "method", "h", "error", "floor", "use"].map(Into::into).to_vec(),
        rows,
        shown: false,
    }
}

/// A panel for each problem of the given names.
pub(super) fn figure<'a>(measured: &[Measured], names: impl Iterator<Item = &'a str>) -> Figure {
    let panels = names
        .map(|name| Panel {
            title: name.into(),
            x: Axis { label: "h".into(), log: true, limits: None },
            y: Axis { label: "error at the end".into(), log: true, limits: None },
            series: measured
                .iter()
                .filter(|pair| pair.problem == name)
                .filter_map(|pair| {
                    let fit = pair.fit.as_ref().ok()?;
                    let all = fit.kept.iter().chain(fit.dropped.iter().map(|(sample, _)| sample));
                    let mut points: Vec<(f64, f64)> =
                        all.filter_map(|sample| Some((sample.h, sample.result.as_ref().ok()?.error))).collect();
                    points.sort_by(|a, b| a.0.total_cmp(&b.0));
                    Some(Series { label: pair.method.clone(), points, mark: Mark::LineMarkers })
                })
                .collect(),
            ..Panel::default()
        })
        .collect();
    Figure {
        id: "orders".into(),
        caption: "Error at the end of the interval against the step size; the slope is the order.".into(),
        data: "order-points".into(),
        panels,
        columns: 2,
    }
}
