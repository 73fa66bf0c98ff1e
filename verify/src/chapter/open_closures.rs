//! The closures that the first paper leaves open: the best constant, exponential fitting, windows of several steps.

use lsvi::StepError;
use lsvi::closure::{Linear, LinearClosure};
use rayon::prelude::*;

use super::parts::order_check;
use super::{Context, Study, StudyError};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Requirement, Series, Table};
use crate::measure::norm::{Extremes, distance, larger};
use crate::measure::order::{Expectation, Sample, fit, ladder};
use crate::method;
use crate::problem::{self, Problem};
use crate::run::{RunError, run};

pub(super) const STUDY: Study = Study {
    id: "open-closures",
    title: "The open closures",
    question: "Which constant (α, β) is best, and do fitted closures, or closures over several steps, help?",
    source: "[S24] Section 3, after Eq. (27), and Eq. (28); claim p",
    run: study,
};

/// v₁/v₀ of one live step on v̇ = −v.
fn amplification(method: &str, h: f64) -> Result<f64, StudyError> {
    let problem = problem::build("linear-drag", &[])?;
    Ok(run(&*problem, &*method::parse(method)?, h, h, |_| {})?.end.q[0])
}

fn study(context: &Context) -> Result<Evidence, StudyError> {
    context.announce(4);
    let mut evidence = Evidence::default();
    for part in [one_step, constants, beyond_one_rate, windows] {
        let Part { checks, tables, figure } = part()?;
        evidence.checks.extend(checks);
        evidence.tables.extend(tables);
        evidence.figures.extend(figure);
        context.tick();
    }
    evidence.notes = notes();
    Ok(evidence)
}

#[derive(Default)]
struct Part {
    checks: Vec<Check>,
    tables: Vec<Table>,
    figure: Option<Figure>,
}

/// The error of one step on v̇ = −v over the step size.
fn one_step() -> Result<Part, StudyError> {
    const SHOWN: [&str; 6] = ["method-i", "method-ii", "linear(-0.5,1)", "minimax(0,2)", "fitted-pade(1)", "fitted(1)"];
    let mut rows = Vec::new();
    let mut curves = Vec::new();
    let mut largest_fitted = 0.0_f64;
    for name in SHOWN {
        let mut points = Vec::new();
        for k in 0..=72 {
            let h = 10_f64.powf(f64::from(k) / 24.0 - 1.5);
            let error = (amplification(name, h)? - (-h).exp()).abs();
            rows.push(vec![Cell::Text(name.into()), Cell::found(h), Cell::found(error)]);
            points.push((h, error));
        }
        if name == "fitted(1)" {
            largest_fitted = points.iter().map(|p| p.1).largest();
        } else {
            curves.push(Series::new(name, points, Mark::Line));
        }
    }
    // At the finest h of each run, where only roundoff and the order are left.
    let order = |name: &str, expected: f64| -> Result<Check, StudyError> {
        let problem = problem::build("linear-drag", &[])?;
        let exact = problem.exact(2.0).ok_or("linear drag has an exact solution")?;
        let method = method::parse(name)?;
        let samples = ladder(2.0, 0.2, std::f64::consts::SQRT_2, 9).into_iter().map(|h| {
            match run(&*problem, &*method, h, 2.0, |_| {}) {
                Ok(run) => Sample::new(h, distance(&run.end.q, &exact), f64::EPSILON * 2.0 / h),
                Err(error) => Sample::failed(h, error.to_string()),
            }
        });
        let fitted = fit(&samples.collect::<Vec<_>>(), &Expectation::new(expected, 0.1));
        let statement = format!("{name} is of order {expected} on v̇ = −v at t = 2");
        Ok(order_check(format!("order/{name}"), statement, &fitted))
    };
    let figure = Figure {
        id: "closure-errors".into(),
        caption:
            "Error |v₁ − exp(−h) v₀| of one step on v̇ = −v. The notches are the steps at which a constant is exact; the \
                  exactly fitted closure lies at roundoff, below the picture."
                .into(),
        data: "closure-errors".into(),
        panels: vec![Panel { x: Axis::log("h"), y: Axis::log("error of one step"), series: curves, ..Panel::default() }],
        columns: 1,
    };
    let checks = vec![
        Check::new(
            "fitted/exact",
            "The closure fitted to λ = 1 is exact on v̇ = −v for every step size: largest error of one step",
            largest_fitted,
            Requirement::AtMost(8.0 * f64::EPSILON),
            "73 step sizes from 0.03 to 30, a few roundings of a number below 1",
        ),
        order("fitted-pade(1)", 3.0)?,
        order("method-i", 2.0)?,
    ];
    let caption = "Error of one step on v̇ = −v.";
    Ok(Part {
        checks,
        tables: vec![Table::data("closure-errors", caption, &["method", "h", "error"], rows)],
        figure: Some(figure),
    })
}

/// The best constant for ranges of steps.
fn constants() -> Result<Part, StudyError> {
    const RANGES: [(f64, f64); 7] =
        [(0.0, 0.5), (0.0, 1.0), (0.0, 2.0), (0.0, 5.0), (0.0, 100.0), (0.5, 1.5), (2.0, 10.0)];
    let worst = |method: &str, (from, to): (f64, f64)| -> Result<(f64, f64), StudyError> {
        // Finer towards the lower end, where the error of a wide range has its maximum.
        (1..=300).try_fold((0.0_f64, 0.0_f64), |(low, high), k| {
            let h = from + (to - from) * (f64::from(k) / 300.0).powi(2);
            let error = amplification(method, h)? - (-h).exp();
            Ok((low.min(error), high.max(error)))
        })
    };
    let modulus = |(low, high): (f64, f64)| high.max(-low);
    let rows = RANGES.par_iter().map(|range| {
        let (from, to) = *range;
        let weights = Linear::minimax(from, to)?.weights(1.0);
        let theta = -weights.alpha / weights.beta;
        let constant = |theta: f64| worst(&format!("linear({:?},1)", -theta), *range);
        let (low, high) = worst(&format!("minimax({from},{to})"), *range)?;
        let beside = modulus(constant(0.98 * theta)?).min(modulus(constant(1.0 - 0.98 * (1.0 - theta))?));
        Ok([
            from,
            to,
            theta,
            low,
            high,
            beside,
            modulus(worst("method-i", *range)?),
            modulus(worst("method-ii", *range)?),
            modulus(worst("implicit-euler", *range)?),
        ])
    });
    let rows: Vec<[f64; 9]> = rows.collect::<Result<_, StudyError>>()?;
    let over = |f: fn(&[f64; 9]) -> f64| rows.iter().map(f).largest();
    let checks = vec![
        Check::new(
            "minimax/equal",
            "The two extreme errors of the minimax constant are equal, over live steps: largest relative difference",
            over(|r| (r[4] + r[3]).abs() / r[4]),
            // 300 samples miss a maximum by an eighth of the squared spacing, below 0.07 h, times curvature over height.
            Requirement::AtMost(2e-3),
            "the error falls everywhere as θ grows, so that equality marks the best θ",
        ),
        Check::new(
            "minimax/best",
            "Constants on either side of it are worse: largest ratio of its error to the better neighbour's",
            over(|r| r[4].max(-r[3]) / r[5]),
            Requirement::AtMost(1.0),
            "θ and 1 − θ changed by two parts in a hundred",
        ),
        Check::new(
            "minimax/rivals",
            "It is better than Methods I and II over every range tried: largest ratio of its error to the better of theirs",
            over(|r| r[4].max(-r[3]) / r[6].min(r[7])),
            Requirement::AtMost(1.0),
            "live steps on v̇ = −v",
        ),
    ];
    let table = Table::new(
        "minimax-constants",
        "The constant θ = −α/β with the least largest error of one step on v̇ = −v over a range of steps, its extreme errors, and \
         the largest errors of others over the same range.",
        &[
            "from",
            "to",
            "theta",
            "least_error",
            "largest_error",
            "neighbour",
            "method_i",
            "method_ii",
            "implicit_euler",
        ],
        rows.iter().map(|row| row.map(Cell::Number).to_vec()).collect(),
    );
    Ok(Part { checks, tables: vec![table], figure: None })
}

/// Errors on problems that have more than one rate, or none.
fn beyond_one_rate() -> Result<Part, StudyError> {
    const PROBLEMS: [&str; 5] =
        ["linear-drag", "quadratic-drag", "damped-pendulum", "van-der-pol", "prothero-robinson"];
    const METHODS: [&str; 9] = [
        "method-i",
        "method-ii",
        "minimax(0,2)",
        "fitted(1)",
        "fitted(4)",
        "fitted-pade(4)",
        "window(4)",
        "trapezoidal",
        "implicit-midpoint",
    ];
    let mut rows = Vec::new();
    // Largest ratio of each fitted closure's error to the better rule's, of runs that reached their end.
    let mut worst = [0.0_f64; 3];
    let mut lost = Vec::new();
    for name in PROBLEMS {
        let problem = problem::build(name, &[])?;
        let h = if name == "van-der-pol" { 0.01 } else { 0.1 };
        let horizon = problem.facts().window.horizon;
        let truth = truth(&*problem, horizon)?;
        let mut errors = Vec::new();
        for method in METHODS {
            // A step without a solution leaves no error, and is told as what it is.
            errors.push(match run(&*problem, &*method::parse(method)?, h, horizon, |_| {}) {
                Ok(run) => Some(distance(&run.end.q, &truth)),
                Err(RunError::Step(StepError::Solve { t, .. })) => {
                    lost.push(format!("`{method}` on `{name}` at t = {t:.2}"));
                    None
                }
                Err(error) => return Err(error.into()),
            });
        }
        let rule = errors[7..].iter().map(|error| error.unwrap_or(f64::NAN)).smallest();
        for (worst, error) in worst.iter_mut().zip(&errors[3..6]) {
            *worst = error.map_or(*worst, |error| larger(*worst, error / rule));
        }
        let cells = errors.into_iter().map(|error| error.map_or(Cell::Empty, Cell::found));
        rows.push([Cell::Text(name.into()), Cell::found(h), Cell::found(horizon)].into_iter().chain(cells).collect());
    }
    let columns: Vec<&str> = ["problem", "h", "t_end"].into_iter().chain(METHODS).collect();
    let table = Table::new(
        "closures-beyond",
        format!(
            "Errors at the end of a run. Fitting pays where its rate is the problem's, and finds no step where an eigenvalue of \
             the Jacobian passes λ/2. Empty where a step has no solution: {}.",
            if lost.is_empty() { "nowhere".into() } else { lost.join(", ") }
        ),
        &columns,
        rows,
    );
    let check = Check::new(
        "fitted/no-cure",
        "Each fitted closure loses to the better of the trapezoidal and the midpoint rule on some problem that it solves: least \
         of their largest ratios of errors",
        worst.into_iter().smallest(),
        Requirement::AtLeast(1.0),
        "`fitted(1)`, `fitted(4)`, `fitted-pade(4)` on the problems of the table",
    );
    Ok(Part { checks: vec![check], tables: vec![table], figure: None })
}

/// The solution at t, exact or by a method of high order.
fn truth(problem: &dyn Problem, t: f64) -> Result<Vec<f64>, StudyError> {
    if let Some(exact) = problem.exact(t).or_else(|| problem.tabulated(t)) {
        return Ok(exact);
    }
    // Errors of h = 0.01 are compared; those of RK4 with h = 1e-4 are 1e-12 of them.
    Ok(run(problem, &*method::parse("rk4")?, 1e-4, t, |_| {})?.end.q)
}

/// Windows of K steps: mean local error on v̇ = −v against the law in Kh.
fn windows() -> Result<Part, StudyError> {
    const LENGTHS: [u32; 9] = [1, 2, 4, 8, 16, 32, 64, 128, 256];
    let law = |span: f64| 1.0 / 24.0 - (-2.0 * span).exp_m1() / (16.0 * span);
    let problem = problem::build("linear-drag", &[])?;
    let mut rows = Vec::new();
    let mut curves = Vec::new();
    let mut deviation = 0.0_f64;
    for h in [0.1, 0.03] {
        let mut points = Vec::new();
        for length in LENGTHS {
            let span = h * f64::from(length);
            let end = run(&*problem, &*method::parse(&format!("window({length})"))?, h, span, |_| {})?.end;
            let steps = f64::from(length);
            let mean = ((end.q[0].ln() + span) / steps).exp_m1() / h.powi(3);
            deviation = larger(deviation, (mean / law(span) - 1.0).abs() / (h * h));
            rows.push([steps, h, span, mean, law(span)].map(Cell::Number).to_vec());
            points.push((span, mean));
        }
        curves.push(Series::new(format!("window(K), h = {h}"), points, Mark::LineMarkers));
    }
    let spans: Vec<f64> = (0..=40).map(|k| 10_f64.powf(f64::from(k) / 15.0 - 1.5)).filter(|s| *s < 30.0).collect();
    let guide = |label: &str, f: &dyn Fn(f64) -> f64| {
        Series::new(label, spans.iter().map(|s| (*s, f(*s))).collect(), Mark::Guide)
    };
    curves.push(guide("1/24 + (1 − exp(−2Kh))/(16Kh)", &law));
    curves.push(guide("Method I, 1/6", &|_| 1.0 / 6.0));
    curves.push(guide("trapezoidal rule, 1/12", &|_| 1.0 / 12.0));
    let figure = Figure {
        id: "windows".into(),
        caption: "Mean local error of a window of K steps on v̇ = −v, in units of h³, over the length Kh of the window."
            .into(),
        data: "windows".into(),
        panels: vec![Panel {
            x: Axis::log("Kh"),
            y: Axis::linear("mean local error / h³").between(0.0, 0.2),
            series: curves,
            ..Panel::default()
        }],
        columns: 1,
    };
    let check = Check::new(
        "windows/law",
        "The mean local error of window(K) on v̇ = −v is h³[1/24 + (1 − exp(−2Kh))/(16Kh)]: largest relative deviation, divided by h²",
        deviation,
        // The law is the leading term; by the symmetry of the action under reversal of time the next is smaller by order h².
        Requirement::AtMost(1.0),
        "K from 1 to 256 at h = 0.1 and 0.03",
    );
    let caption = "Mean local error of windows of K steps on v̇ = −v, in units of h³.";
    let table = Table::data("windows", caption, &["k", "h", "kh", "mean_error", "law"], rows);
    Ok(Part { checks: vec![check], tables: vec![table], figure: Some(figure) })
}

fn notes() -> Vec<String> {
    vec![
        "There is no best constant (α, β), only a best one for a range of hλ. With θ = −α/β the error of one step on v̇ = −λv \
         falls everywhere as θ grows, from Method I at θ = 0 to Method II at θ = 1: it is positive for small hλ and negative \
         for large, and the best θ makes the two extremes equal. For h → 0 it tends to 1, and damping at infinity, |R(∞)| = θ, \
         is lost; over all steps it is near 0.06."
            .into(),
        "As a function of hλ the best coefficient makes the step exact, θ = 1 − hλ/2 + …, and 1/(1 + hλ/2) is its Padé \
         approximation, of third order. Both need λ, and are exact or of third order for that rate alone: on nonlinear problems \
         they are of second order, each behind the better of the trapezoidal and the midpoint rule on some problem. Where the Jacobian has an eigenvalue λ/2 they \
         determine nothing, as Method II where it is 0."
            .into(),
        "A homogeneous condition F(p_n, p_{n+1}) = 0 on a scalar unknown is a linear closure, or a choice between several; at a \
         given step it does no better than the best of them for that step. What is different is a window: with p = 0 only at the end of K steps, and the discrete Euler–Lagrange \
         equations in between, the mean local error falls from twice the trapezoidal rule's, Method I's, to half of it, \
         but only for windows longer than the time scale of the problem, whose cost is that of a boundary value problem."
            .into(),
        "Each of these stays of second order. What raises the order is a path of higher degree, not a closure.".into(),
    ]
}
