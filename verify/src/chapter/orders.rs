//! Orders of accuracy of every method on every problem.

use super::parts::{order_check, scope};
use super::{Context, Study, StudyError};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Grid, Mark, Outcome, Panel, Series, Table};
use crate::experiment::orders::{LOST, Measured, OrderError, Orders};
use crate::kinds::Principle;
use crate::measure::order::Sample;

pub(super) const STUDY: Study = Study {
    id: "orders",
    title: "Orders of accuracy",
    question: "Does every method converge with the order it should, on every problem but the two-dimensional flows?",
    source: "[S24] Sections 3–5, [KY21], [MW01]",
    run,
};

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let measured = context.get(Orders)?;
    Ok(Evidence {
        figures: figures(&measured),
        notes: vec![
            scope(measured.iter().map(|pair| pair.problem.as_str())),
            "An order is fitted over the step sizes where the local slopes agree and the error stands clear of its floor; \
             a verdict needs at least four of them, is two-sided, and is inconclusive where the data do not decide. Linear \
             problems, and some of one unknown, super-converge and hide mistakes: the orders that count are those on `quadratic-drag`, `logistic`, \
             `damped-pendulum` and `van-der-pol`, and in mechanics those on `kepler`, `henon-heiles`, `double-pendulum`, \
             `charged-particle` and `spherical-pendulum`."
                .into(),
            "Reductions of three kinds are declared. On the Poiseuille ansatz the Lagrangian (37) keeps a remainder that no path \
             removes: every closure α p₀ + β p₁ = 0 is of first order there but two of second, Method II whatever the path, and α = β. On `prothero-robinson` with hλ ≫ 1 the \
             error of Method I is h|v″|/(2λ), of first order like implicit Euler's, where the trapezoidal rule keeps its \
             second. There the closed methods of higher order lose one or two of theirs to the defects of their stages, which the end of a step keeps."
                .into(),
            "Three super-convergences are declared. Collocation at two Gauss nodes or more, `ls-galerkin(2,gauss,2)`, gains two orders on `quadratic-drag`, which therefore \
             does not count for it; it is not in the map. Least squares of `v̇ = A v + b`, integrated without error, gain an order or two \
             where A is symmetric: the chapter on high orders has which. A path fitted at an even number of equidistant nodes leaves a defect along an \
             even derivative of q. In uniform motion on a `circle` that is radial and goes into the multiplier, so that two \
             orders are gained there."
                .into(),
        ],
        ..report(&measured)
    })
}

/// The checks and the tables.
pub(super) fn report(measured: &[Measured]) -> Evidence {
    Evidence {
        checks: measured.iter().map(check).collect(),
        tables: [convergence(measured), vec![orders(measured), points(measured)]].concat(),
        grids: vec![grid(measured)],
        ..Evidence::default()
    }
}

/// The orders as a map of methods and problems.
fn grid(measured: &[Measured]) -> Grid {
    let caption = "Measured order less the expected one, method by problem. A cell leads to its check. It is blank where the \
                   method is not made for the problem.";
    let mut grid = Grid::new("orders", caption, 2);
    for pair in measured {
        let fit = pair.fit.as_ref().ok();
        let excess = fit.and_then(|fit| fit.line.map(|line| line.slope - fit.expected.order));
        let strain = excess.zip(fit).map_or(0.0, |(excess, fit)| excess.abs() / fit.expected.band);
        grid.push(&pair.method, &pair.problem, excess, Some(strain), format!("{}/{}", pair.problem, pair.method));
    }
    grid
}

fn check(pair: &Measured) -> Check {
    let id = format!("{}/{}", pair.problem, pair.method);
    let statement = format!("{} converges on {} with its order, against {}", pair.method, pair.problem, pair.truth);
    match &pair.fit {
        Ok(fit) => order_check(id, statement, fit),
        Err(error @ OrderError::Untold { .. }) => {
            Check::undecided(id, statement, Outcome::NotSettled, error.to_string())
        }
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
        caption: "Fitted order of every method on every problem here that it is made for, with its standard error and the points it rests on."
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

/// The family by what a method steps.
fn family(pair: &Measured) -> &'static str {
    match pair.principle {
        Principle::Equation => FAMILIES[1],
        Principle::Hamilton => FAMILIES[2],
        _ => FAMILIES[0],
    }
}

const FAMILIES: [&str; 3] =
    ["least-squares integrators", "Runge–Kutta and multistep methods", "integrators of mechanics"];

/// Of the families with more methods than colours, the closures of the paper and one of higher order, and one of each kind in mechanics.
pub(super) const TOLD: [&str; 10] = [
    "method-i",
    "method-ii",
    "explicit-momentum",
    "window(4)",
    "ls-galerkin(2,radau,2)",
    "midpoint-vi",
    "stormer-verlet",
    "path-fitted(4)",
    "path-fitted(4,gauss)",
    "galerkin-gauss(2)",
];

/// A figure for each family, with a panel for each problem.
pub(super) fn figures(measured: &[Measured]) -> Vec<Figure> {
    let mut problems: Vec<&str> = measured.iter().map(|pair| pair.problem.as_str()).collect();
    problems.dedup();
    let figure = |(place, name): (usize, &&str)| {
        let of =
            |problem: &str| measured.iter().filter(|pair| family(pair) == *name && pair.problem == problem).collect();
        let panels = problems.iter().filter_map(|problem| panel(problem, of(problem)));
        let caption = format!(
            "Error at the end of the interval against the step size, {name}; the slope is the order. The dashed lines have the \
             slopes that theory expects. Errors above {LOST} times the initial state, or {LOST}, are left out: such a run is lost."
        );
        let figure = Figure::new(format!("orders-{}", place + 1), caption, "order-points", panels).in_columns(3);
        figure.telling(&TOLD)
    };
    FAMILIES.iter().enumerate().map(figure).filter(|figure| !figure.panels.is_empty()).collect()
}

/// The errors of some methods on a problem, with a line of each expected slope through the largest error at the coarsest step.
fn panel(problem: &str, pairs: Vec<&Measured>) -> Option<Panel> {
    let mut series = Vec::new();
    let mut guides: Vec<(f64, (f64, f64), f64)> = Vec::new();
    for pair in pairs {
        let Ok(fit) = &pair.fit else { continue };
        let found = |sample: &Sample| {
            let error = sample.result.as_ref().ok()?.error;
            (error <= pair.most).then_some((sample.h, error))
        };
        let points: Vec<(f64, f64)> = fit.points().into_iter().filter_map(|(sample, _)| found(sample)).collect();
        if points.is_empty() {
            continue;
        }
        if let (Some(first), Some(last)) = (fit.kept.iter().find_map(found), fit.kept.last().and_then(found)) {
            let order = fit.expected.order;
            match guides.iter_mut().find(|guide| guide.0 == order) {
                Some(guide) if guide.1.1 >= first.1 => guide.2 = guide.2.min(last.0),
                Some(guide) => *guide = (order, first, guide.2.min(last.0)),
                None => guides.push((order, first, last.0)),
            }
        }
        series.push(Series::new(pair.method.clone(), points, Mark::LineMarkers));
    }
    guides.sort_by(|a, b| a.0.total_cmp(&b.0));
    series.extend(guides.into_iter().map(|(order, (h, error), end)| {
        // A factor of three above the curve.
        let line = [h, end].map(|x| (x, 3.0 * error * (x / h).powf(order)));
        Series::new(format!("slope {order}"), line.into(), Mark::Guide)
    }));
    let panel = Panel::new(Axis::log("h"), Axis::log("error at the end"), series).titled(problem);
    (!panel.series.is_empty()).then_some(panel)
}

/// The pairs on which the report's first statements rest: a problem and methods on it.
const HEADLINE: [(&str, &[&str]); 3] = [
    ("quadratic-drag", &["method-i", "method-ii", "trapezoidal", "ls-galerkin(2,lobatto,3)"]),
    ("van-der-pol", &["method-i", "trapezoidal", "tr-bdf2", "ls-galerkin(2,radau,2)"]),
    ("kepler", &["path-fitted(4)", "path-fitted(4,gauss)", "galerkin-gauss(3)"]),
];

/// Errors and the rates at which they fall from one row to the next.
fn convergence(measured: &[Measured]) -> Vec<Table> {
    let table = |(problem, methods): &(&str, &[&str])| {
        let errors = |method: &str| -> Option<Vec<(f64, f64)>> {
            let pair = measured.iter().find(|pair| pair.problem == *problem && pair.method == method)?;
            let points = pair.fit.as_ref().ok()?.points();
            Some(points.iter().filter_map(|(sample, _)| Some((sample.h, sample.result.as_ref().ok()?.error))).collect())
        };
        let found: Vec<(&str, Vec<(f64, f64)>)> = methods.iter().filter_map(|m| Some((*m, errors(m)?))).collect();
        // Every other step of the ladder is half of the one before.
        let mut steps: Vec<f64> = found.iter().flat_map(|(_, errors)| errors.iter().map(|point| point.0)).collect();
        steps.sort_by(|a, b| b.total_cmp(a));
        steps.dedup();
        let steps: Vec<f64> = steps.into_iter().step_by(2).collect();
        let rows = steps.iter().enumerate().map(|(place, h)| {
            let mut row = vec![Cell::Number(*h)];
            for (_, errors) in &found {
                let at = |h: f64| errors.iter().find(|point| point.0 == h).map(|point| point.1);
                let before = place.checked_sub(1).and_then(|before| Some((steps[before], at(steps[before])?)));
                let rate =
                    at(*h).zip(before).map(|(error, (longer, before))| (before / error).ln() / (longer / h).ln());
                row.extend([
                    Cell::from(at(*h)),
                    rate.map_or(Cell::Empty, |rate| Cell::found((rate * 100.0).round() / 100.0)),
                ]);
            }
            row
        });
        let columns = found.iter().flat_map(|(method, _)| [(*method).to_owned(), format!("rate {method}")]);
        let columns: Vec<String> = ["h".to_owned()].into_iter().chain(columns).collect();
        let caption = format!(
            "Convergence on {problem}: errors at the end, and the rate at which each falls from the row above, \
             log₂ of the ratio where the step is halved."
        );
        (!found.is_empty()).then(|| Table::new(format!("convergence-{problem}"), caption, columns, rows.collect()))
    };
    HEADLINE.iter().filter_map(table).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::orders::Truth;
    use crate::measure::order::{Expectation, fit};

    /// Errors hᵖ for steps of which every other is a third of the one before.
    fn measured(problem: &str, method: &str, order: f64) -> Measured {
        let steps = (0..8).map(|k| 3_f64.powf(-0.5 * f64::from(k)));
        let samples: Vec<_> = steps.map(|h| Sample::new(h, h.powf(order), 1e-12)).collect();
        Measured {
            problem: problem.into(),
            method: method.into(),
            principle: Principle::MomentumZero,
            truth: Truth::Exact,
            fit: Ok(fit(&samples, &Expectation::new(2.0, 0.1))),
            most: LOST,
        }
    }

    /// An order too high is positive in the map, and its strain is its share of the band.
    #[test]
    fn the_map_has_the_excess_of_each_order() {
        for excess in [0.04, -0.04] {
            let cell = grid(&[measured("logistic", "method-i", 2.0 + excess)]).cells.remove(0);
            let [value, strain] = [cell.value, cell.strain].map(|found| found.expect("a number"));
            assert!((value - excess).abs() < 1e-9 && (strain - 0.4).abs() < 1e-8, "{value} {strain}");
        }
    }

    #[test]
    fn a_rate_is_the_power_of_the_ratio_of_two_steps() {
        let tables = convergence(&[measured("quadratic-drag", "method-i", 2.0)]);
        let column = tables[0].column("rate method-i").expect("a column");
        let rates: Vec<_> = tables[0].rows.iter().map(|row| row[column].number()).collect();
        assert_eq!(rates, [None, Some(2.0), Some(2.0), Some(2.0)]);
    }
}
