//! The closures that the first paper leaves open: the best constant, exponential fitting, windows of several steps.

use super::parts::order_check;
use super::{Context, Study, StudyError};
use crate::evidence::number::{brief, short};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Requirement, Series, Table};
use crate::experiment::ends::{DragErrors, End, HorizonError};
use crate::experiment::minimax::{Found, Minimax, theta};
use crate::experiment::one_step::OneStep;
use crate::measure::norm::{Extremes, larger};
use crate::measure::order::{Expectation, fit};

pub(super) const STUDY: Study = Study {
    id: "open-closures",
    title: "The open closures",
    question: "Which constant (α, β) is best, and do fitted closures, or closures over several steps, help?",
    source: "[S24] Section 3, after Eq. (27), and Eq. (28); claim p",
    run: study,
};

/// Beyond it |R| is what it is at infinity.
const LONGEST: f64 = 1e6;

fn study(context: &Context) -> Result<Evidence, StudyError> {
    context.announce(4);
    let mut evidence = Evidence::default();
    for part in [one_step, constants, beyond_one_rate, windows] {
        let Part { checks, tables, figure } = part(context)?;
        evidence.checks.extend(checks);
        evidence.tables.extend(tables);
        evidence.figures.extend(figure);
        context.tick();
    }
    evidence.notes = notes(theta(0.0, LONGEST)?);
    Ok(evidence)
}

#[derive(Default)]
struct Part {
    checks: Vec<Check>,
    tables: Vec<Table>,
    figure: Option<Figure>,
}

/// The error of one step on v̇ = −v over the step size.
fn one_step(context: &Context) -> Result<Part, StudyError> {
    const SHOWN: [&str; 6] = ["method-i", "method-ii", "linear(-0.5,1)", "minimax(0,2)", "fitted-pade(1)", "fitted(1)"];
    let mut rows = Vec::new();
    let mut curves = Vec::new();
    let mut largest_fitted = 0.0_f64;
    for name in SHOWN {
        let mut points = Vec::new();
        for k in 0..=72 {
            let h = 10_f64.powf(f64::from(k) / 24.0 - 1.5);
            let error = (OneStep::growth(name, h).or_infinity(context)? - (-h).exp()).abs();
            rows.push(vec![Cell::Text(name.into()), Cell::found(h), Cell::found(error)]);
            points.push((h, error));
        }
        if name == "fitted(1)" {
            largest_fitted = points.iter().map(|p| p.1).largest();
        } else {
            curves.push(Series::new(name, points, Mark::Line));
        }
    }
    let order = |name: &'static str, expected: f64| -> Result<Check, StudyError> {
        let samples = context.get(DragErrors { method: name })?;
        let fitted = fit(&samples, &Expectation::new(expected, 0.1));
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
fn constants(context: &Context) -> Result<Part, StudyError> {
    const RANGES: [(f64, f64); 7] =
        [(0.0, 0.5), (0.0, 1.0), (0.0, 2.0), (0.0, 5.0), (0.0, 100.0), (0.5, 1.5), (2.0, 10.0)];
    let ranges = RANGES.map(|(from, to)| Minimax { from, to });
    let found = context.get_each(ranges.into())?;
    let over = |f: fn(&Found) -> f64| found.iter().map(|found| f(found)).largest();
    let checks = vec![
        Check::new(
            "minimax/equal",
            "The two extreme errors of the minimax constant are equal, over live steps: largest relative difference",
            over(|r| (r.extremes[1] + r.extremes[0]).abs() / r.extremes[1]),
            // An extreme is flat: half of the digits of its place are all of its height. θ has these at least.
            Requirement::AtMost(f64::EPSILON.sqrt()),
            "the signed error falls everywhere as θ grows, so that equality marks the best θ",
        ),
        Check::new(
            "minimax/best",
            "Constants on either side of it are worse: largest ratio of its error to the better neighbour's",
            over(|r| r.best() / r.neighbour),
            Requirement::AtMost(1.0),
            "θ and 1 − θ changed by two parts in a hundred",
        ),
        Check::new(
            "minimax/rivals",
            "It is better than Methods I and II over every range tried: largest ratio of its error to the better of theirs",
            over(|r| r.best() / r.method_i.min(r.method_ii)),
            Requirement::AtMost(1.0),
            "live steps on v̇ = −v",
        ),
    ];
    let rows = RANGES.iter().zip(&found).map(|((from, to), r)| {
        let [low, high] = r.extremes;
        let row = [*from, *to, r.theta, low, high, r.neighbour, r.method_i, r.method_ii, r.implicit_euler];
        row.map(Cell::Number).to_vec()
    });
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
        rows.collect(),
    );
    Ok(Part { checks, tables: vec![table], figure: None })
}

/// Errors on problems that have more than one rate, or none.
fn beyond_one_rate(context: &Context) -> Result<Part, StudyError> {
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
    // Where its error is the smaller one.
    let mut ahead: [Vec<String>; 3] = Default::default();
    let mut lost = Vec::new();
    for name in PROBLEMS {
        let h = if name == "van-der-pol" { 0.01 } else { 0.1 };
        let runs = METHODS.map(|method| HorizonError { problem: name, method, h });
        let found = context.get_each(runs.into())?;
        // A step without a solution leaves no error, and is told as what it is.
        for (method, ended) in METHODS.iter().zip(&found) {
            lost.extend(ended.error.err().map(|t| format!("`{method}` on `{name}` at t = {t:.2}")));
        }
        let errors: Vec<Option<f64>> = found.iter().map(|ended| ended.error.ok()).collect();
        let rule = errors[7..].iter().map(|error| error.unwrap_or(f64::NAN)).smallest();
        for ((worst, ahead), error) in worst.iter_mut().zip(&mut ahead).zip(&errors[3..6]) {
            *worst = error.map_or(*worst, |error| larger(*worst, error / rule));
            ahead.extend(error.filter(|error| *error < rule).map(|_| format!("`{name}`")));
        }
        let cells = errors.into_iter().map(|error| error.map_or(Cell::Empty, Cell::found));
        rows.push(
            [Cell::Text(name.into()), Cell::found(h), Cell::found(found[0].horizon)].into_iter().chain(cells).collect(),
        );
    }
    let columns: Vec<&str> = ["problem", "h", "t_end"].into_iter().chain(METHODS).collect();
    let wins = METHODS[3..6].iter().zip(&ahead).map(|(method, problems)| match &problems[..] {
        [] => format!("`{method}` nowhere"),
        problems => format!("`{method}` on {}", problems.join(" and ")),
    });
    let table = Table::new(
        "closures-beyond",
        format!(
            "Errors at the end of a run. `fitted(λ)` is exact, to rounding, on v̇ = −λv alone, as `fitted(1)` on `linear-drag`. More \
             accurate than both the trapezoidal and the midpoint rule are, of the fitted closures, {}. A step has no solution where an eigenvalue of the Jacobian passes λ/2, and \
             the place is empty: {}.",
            wins.collect::<Vec<_>>().join(", "),
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

/// Windows of K steps: mean local error on v̇ = −v against the law in Kh.
fn windows(context: &Context) -> Result<Part, StudyError> {
    const LENGTHS: [u32; 9] = [1, 2, 4, 8, 16, 32, 64, 128, 256];
    let law = |span: f64| 1.0 / 24.0 - (-2.0 * span).exp_m1() / (16.0 * span);
    let mut rows = Vec::new();
    let mut curves = Vec::new();
    let mut deviation = 0.0_f64;
    for h in [0.1, 0.03] {
        let mut points = Vec::new();
        for length in LENGTHS {
            let span = h * f64::from(length);
            let method = format!("window({length})");
            let end = context.get(End { problem: "linear-drag".into(), method, h, steps: length })?;
            let steps = f64::from(length);
            let mean = ((end.ln() + span) / steps).exp_m1() / h.powi(3);
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
        caption: "Mean local error of a window of K steps on v̇ = −v, relative and in units of h³: (v_K/(v₀ exp(−Kh)))^(1/K) − 1 over h³, over the length Kh of \
                  the window."
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

fn notes(over_all: f64) -> Vec<String> {
    vec![
        format!(
            "There is no best constant (α, β), only a best one for a range of hλ. With θ = −α/β the signed error of one step on v̇ = −λv \
         falls everywhere as θ grows, from Method I at θ = 0 to Method II at θ = 1: in between it is positive for small hλ and negative \
         for large, and the best θ makes the two extremes equal. For h → 0 it tends to 1, and damping at infinity, |R(∞)| = θ, \
         is lost; over all steps, those up to hλ = {} here, it is {}.",
            short(LONGEST),
            brief(over_all)
        ),
        "As a function of hλ the best coefficient makes the step exact, θ = 1 − hλ/2 + …, and 1/(1 + hλ/2) is its Padé \
         approximation, of third order. Both need λ, and are exact or of third order for that rate alone: on nonlinear problems \
         they are of second order, each behind the better of the trapezoidal and the midpoint rule on some problem. Where the Jacobian has an eigenvalue near λ/2, for h → 0 at λ/2 itself, they \
         determine nothing, as Method II where it is 0."
            .into(),
        "A homogeneous condition F(p_n, p_{n+1}) = 0 on a scalar unknown is a linear closure, or a choice between several; at a \
         given step it does no better than the best of them for that step. What is different is a window: with p = 0 only at the end of K steps, and the discrete Euler–Lagrange \
         equations in between, the mean local error falls from twice the trapezoidal rule's, Method I's, to half of it, \
         but only for windows longer than the time scale of the problem, whose cost is that of a boundary value problem."
            .into(),
        "On nonlinear problems each of these stays of second order. What raises the order is a path of higher degree, not a closure.".into(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Its largest error above is as large as that at infinity, which is θ below.
    #[test]
    fn the_best_constant_over_all_steps_makes_two_errors_equal() {
        let above = |theta: f64| {
            let errors = (1..10_000).map(|k| 0.001 * f64::from(k)).map(|z: f64| {
                let square = 0.5 * z * z;
                (1.0 - theta * (1.0 - z + square)) / (1.0 + z + square - theta) - (-z).exp()
            });
            errors.largest()
        };
        let (mut low, mut high) = (0.0, 0.5);
        for _ in 0..40 {
            let theta = 0.5 * (low + high);
            if above(theta) > theta { low = theta } else { high = theta }
        }
        let found = theta(0.0, LONGEST).expect("a range");
        assert!((found - low).abs() < 1e-5, "{found} {low}");
        let told = format!("up to hλ = 10⁶ here, it is {}.", brief(low));
        assert!(notes(low)[0].contains(&told) && told.ends_with("0.057."), "{told}");
    }
}
