//! Holonomic constraints: the working form of every discretisation, and the scheme (23) as printed.

use std::ops::ControlFlow;

use rayon::prelude::*;

use super::mechanics::{integrators, problem, text};

use super::{Context, Study, StudyError};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Series, Table};
use crate::golden::{self, Row, Tolerance, Truth};
use crate::measure::norm::larger;
use crate::method::{self, Method};
use crate::run::run_while;
use crate::theory::is_symplectic;

pub(super) const STUDY: Study = Study {
    id: "constraints",
    title: "Holonomic constraints",
    question: "Which discretisations hold a constraint, its derivative and the angular momentum together, and what does (23) do?",
    source: "[KY21] (4), (5), (23)",
    run,
};

/// Step and length of the runs.
const H: f64 = 0.1;
const HORIZON: f64 = 20.0;

/// |q|² − 1 of a q that is known to a few ε: what Newton's iteration leaves and the rounding of q itself.
const PLACE: f64 = 64.0 * f64::EPSILON;

/// What the runs leave of f(q) = 0, of its derivative and of the angular momentum.
struct Kept {
    problem: &'static str,
    method: String,
    position: f64,
    hidden: f64,
    momentum: f64,
    energy: f64,
    /// Whether the angular momentum is kept, as by every symplectic method.
    symplectic: bool,
    /// Rounding of the momentum over the run.
    rounding: f64,
}

/// Every integrator on both problems.
fn keep_all(context: &Context) -> Result<Vec<Kept>, StudyError> {
    let mut pairs = Vec::new();
    for name in ["circle", "spherical-pendulum"] {
        pairs.extend(integrators()?.into_iter().map(|method| (name, method)));
    }
    context.announce(pairs.len());
    pairs
        .into_par_iter()
        .map(|(name, method)| {
            let kept = keep(name, &*method);
            context.tick();
            kept
        })
        .collect()
}

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let kept = keep_all(context)?;
    let mut evidence = Evidence {
        notes: vec![
            "The working form holds f = 0 at the end of every step by a multiplier at the node and removes from the momentum \
             what would leave the constraint. Every discretisation then keeps the position constraint and the hidden one, \
             G q̇ = 0, to rounding. The angular momentum is kept by what is symplectic, and on the circle by all, since there is \
             nothing else that a symmetric step could do. The orders of the same methods on the same two problems are in the chapter on orders."
                .into(),
            "As printed, (23) holds the constraint at the interior node alone. Nothing holds the ends of the steps: a radial \
             error is multiplied by −(3 + 2√2) ≈ −5.83 in each step, at every step size, until it is of the size of the circle. Smaller steps \
             start from a smaller error, τ⁴/32 after the first step, and gain a few steps. The scheme is unusable."
                .into(),
        ],
        ..Evidence::default()
    };
    for Kept { problem, method, position, hidden, momentum, symplectic, rounding, .. } in &kept {
        let on = format!("{problem}/{method}");
        let statement = format!("{method} holds |q| = 1 on {problem}");
        evidence.checks.push(Check::at_most(
            format!("position/{on}"),
            statement,
            *position,
            PLACE,
            "64 roundings of q",
        ));
        let statement = format!("{method} holds q · p = 0 on {problem}");
        evidence.checks.push(Check::at_most(format!("hidden/{on}"), statement, *hidden, PLACE, "64 roundings of p"));
        let id = format!("momentum/{on}");
        evidence.checks.push(if *symplectic {
            let statement = format!("{method} keeps the angular momentum on {problem}");
            let reason = "independent roundings of the momentum, four deviations of their sum";
            Check::at_most(id, statement, *momentum, *rounding, reason)
        } else {
            let statement = format!("{method} does not keep the angular momentum on {problem}");
            Check::at_least(id, statement, *momentum, 10.0 * rounding, "ten times its rounding")
        });
    }
    let rows = kept.iter().map(|k| {
        let numbers = [k.position, k.hidden, k.momentum, k.energy].map(Cell::Number);
        [text(k.problem), text(k.method.as_str())].into_iter().chain(numbers).collect()
    });
    evidence.tables.push(Table::new(
        "constraints",
        format!(
            "Largest ||q|² − 1|, |q · p|, change of the angular momentum and of the energy up to t = {HORIZON} with h = {H}, working form."
        ),
        &["problem", "method", "position", "hidden", "momentum", "energy"],
        rows.collect(),
    ));
    as_printed(&mut evidence)?;
    Ok(evidence)
}

fn keep(name: &'static str, method: &dyn Method) -> Result<Kept, StudyError> {
    let problem = problem(name, &[])?;
    let start = problem.initial();
    let n = start.len() / 2;
    let invariants = problem.invariants();
    let change = |which: &str, state: &[f64]| {
        let invariant = invariants.iter().find(|i| i.name == which);
        invariant.map_or(f64::NAN, |i| (i.value(state) - i.value(&start)).abs())
    };
    let (mut position, mut hidden, mut momentum, mut energy) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    crate::run::run(&*problem, method, H, HORIZON, |state| {
        let (q, p) = state.q.split_at(n);
        position = larger(position, (q.iter().map(|x| x * x).sum::<f64>() - 1.0).abs());
        hidden = larger(hidden, q.iter().zip(p).map(|(q, p)| q * p).sum::<f64>().abs());
        momentum = larger(momentum, change("angular momentum", &state.q));
        energy = larger(energy, change("energy", &state.q));
    })?;
    let rounding = 4.0 * (HORIZON / H).sqrt() * (1.0 + method.momentum_roundoff(1.0)) * f64::EPSILON / H;
    let symplectic = is_symplectic(&*problem, method).ok_or("the problem has no Lagrangian of mechanics")?;
    Ok(Kept { problem: name, method: method.name(), position, hidden, momentum, energy, symplectic, rounding })
}

/// (23) as printed: its radial error at each step.
fn as_printed(evidence: &mut Evidence) -> Result<(), StudyError> {
    let circle = problem("circle", &[])?;
    let method = method::parse("kong-yang-circle")?;
    let predicted = 3.0 + 8.0_f64.sqrt();
    let (mut series, mut rows, mut summary) = (Vec::new(), Vec::new(), Vec::new());
    for tau in [0.2, 0.1, 0.05, 0.02, 0.01] {
        let mut errors = Vec::new();
        let mut step = 0.0;
        run_while(&*circle, &*method, tau, 40.0 * tau, |state| {
            errors.push((step, state.q[0].hypot(state.q[1]) - 1.0));
            step += 1.0;
            // Beyond, it is far from the circle, and the step equations need not be solvable.
            if errors.last().is_some_and(|e| e.1.abs() > 0.3) {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        })?;
        // The ratio of the last two errors that are still small against the circle and large against what feeds them.
        let ratio =
            errors.windows(2).rev().find(|pair| pair[1].1.abs() < 1e-3).map_or(f64::NAN, |pair| pair[1].1 / pair[0].1);
        let first = errors.get(1).map_or(f64::NAN, |e| e.1) / -(tau.powi(4) / 32.0);
        evidence.checks.push(Check::at_most(
            format!("first-error/tau-{tau}"),
            format!("The first radial error of (23) is −τ⁴/32, τ = {tau}"),
            (first - 1.0).abs(),
            tau * tau + 8.0 * f64::EPSILON / tau.powi(4) * 32.0,
            "relative deviation: the next term of a series in τ², and roundings of |q|",
        ));
        let visible = errors.iter().find(|e| e.1.abs() > 1e-2).map(|e| e.0 as i64);
        summary.push(vec![
            Cell::Number(tau),
            Cell::Number(first),
            Cell::Number(ratio),
            Cell::Number(-predicted),
            visible.map_or(Cell::Empty, Cell::Integer),
        ]);
        if tau <= 0.02 {
            evidence.checks.push(Check::at_most(
                format!("growth/tau-{tau}"),
                format!("A radial error of (23) is multiplied by −(3 + 2√2) per step, τ = {tau}"),
                (ratio / -predicted - 1.0).abs(),
                0.01,
                "relative deviation; it is of the order of τ² and of the error itself, here below 10⁻³, plus what feeds the first \
                 of some eight steps",
            ));
        }
        let steps = visible.unwrap_or(i64::MAX) as f64;
        evidence.checks.push(Check::at_most(
            format!("visible/tau-{tau}"),
            format!("|q| under (23) is off by more than a hundredth within 20 steps, τ = {tau}"),
            steps,
            20.0,
            "the number of steps in which a rounding would grow to a hundredth at that rate is 18",
        ));
        for (k, error) in &errors {
            rows.push(vec![Cell::Number(tau), Cell::Integer(*k as i64), Cell::Number(*error)]);
        }
        let points = errors.iter().skip(1).map(|(k, error)| (*k, error.abs())).collect();
        series.push(Series { label: format!("τ = {tau}"), points, mark: Mark::LineMarkers });
    }
    let guide = (1..=12).map(|k| (f64::from(k), 1e-9 * predicted.powi(k))).collect();
    series.push(Series { label: "slope 3 + 2√2".into(), points: guide, mark: Mark::Guide });
    let columns = ["tau", "first", "ratio", "predicted", "visible_at"];
    evidence.tables.push(Table::new(
        "circle-growth",
        "The scheme (23) as printed: the radial error after the first step in units of −τ⁴/32, its factor per step, its limit for small angles, and the step at which \
         |q| is off by a hundredth.",
        &columns,
        summary,
    ));
    evidence.tables.push(Table::data("circle-radius", "|q| − 1 under (23).", &["tau", "step", "error"], rows));
    evidence.figures.push(Figure {
        id: "circle-radius".into(),
        caption: "Distance from the circle under (23) as printed. The slope does not depend on the step size.".into(),
        data: "circle-radius".into(),
        panels: vec![Panel {
            x: Axis { label: "step".into(), ..Axis::default() },
            y: Axis { label: "||q| − 1|".into(), log: true, limits: None },
            series,
            ..Panel::default()
        }],
        columns: 1,
    });
    Ok(())
}

/// Rows of the golden `constraints`.
pub(crate) fn golden(context: &Context) -> Result<Vec<Row>, StudyError> {
    let mut rows = Vec::new();
    for Kept { problem, method, position, hidden, momentum, energy, symplectic, rounding } in keep_all(context)? {
        let mut push = |what: &str, value: f64, atol: f64, vanishes: bool| {
            let row = Row::number(
                format!("{problem} {method} {what}"),
                value,
                Tolerance::absolute(atol, "rounding of the run"),
            );
            let truth = Truth { value: 0.0, allowance: atol, source: "held, or kept".into() };
            rows.push(if vanishes { row.with_truth(truth) } else { row });
        };
        push("position", position, PLACE, true);
        push("hidden", hidden, PLACE, true);
        push("momentum", momentum, rounding, symplectic);
        // On the circle the energy is that of the angular momentum.
        push("energy", energy, rounding, problem == "circle");
    }
    Ok(rows)
}

/// Rows of the golden `circle-growth`.
pub(crate) fn growth_golden(_: &Context) -> Result<Vec<Row>, StudyError> {
    let mut evidence = Evidence::default();
    as_printed(&mut evidence)?;
    let table = evidence.tables.iter().find(|table| table.id == "circle-growth").ok_or("the table is gone")?;
    Ok(golden::table::rows(table, &["tau"], &["first", "ratio", "visible_at"], |entry| {
        let tau = entry.number("tau").unwrap_or(f64::NAN);
        // A few roundings of |q| relative to the first error, with which all later ones grow.
        let rtol = 8.0 * f64::EPSILON * 32.0 / tau.powi(4);
        let tolerance = Tolerance::relative(rtol, "roundings of |q| over the first error");
        let truth = match entry.column {
            "first" => Some(Truth { value: 1.0, allowance: tau * tau + rtol, source: "−τ⁴/32".into() }),
            "ratio" if tau <= 0.02 => {
                let value = -(3.0 + 8.0_f64.sqrt());
                Some(Truth { value, allowance: 0.01 * value.abs(), source: "−(3 + 2√2) for small angles".into() })
            }
            _ => None,
        };
        (tolerance, truth)
    }))
}
