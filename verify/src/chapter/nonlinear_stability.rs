//! Where nonlinear problems end up: the right steady state, another one, or a step equation without a solution.

use std::sync::Arc;

use super::{Context, Study, StudyError};
use crate::evidence::number::{brief, digits};
use crate::evidence::{Axis, Cell, Check, Evidence, Field, Figure, Mark, Panel, Requirement, Series, Table};
use crate::experiment::ends::End;
use crate::experiment::fates::{self, Fate, Fates, Folds, GRID, Map, STEPS, Spacing};
use crate::experiment::step_equation::{Found, StepEquation};
use crate::measure::norm::{Extremes, larger};
use crate::measure::search::root;

pub(super) const STUDY: Study = Study {
    id: "nonlinear-stability",
    title: "Stability on nonlinear problems",
    question: "From which initial values, and with which steps, does a run reach the right steady state?",
    source: "[S24] Sections 3 and 4, Eq. (30); claims b, g, h",
    run: study,
};

const METHODS: [&str; 4] = ["method-i", "method-ii", "implicit-euler", "trapezoidal"];

/// An arena of runs, and how it is shown.
struct Arena {
    runs: fates::Arena,
    equation: &'static str,
    axes: fn() -> [Axis; 2],
    /// What the curves are, for the caption.
    marked: &'static str,
}

const ARENAS: [Arena; 2] = [
    Arena {
        runs: fates::QUADRATIC_DRAG,
        equation: "v̇ = −v²",
        axes: || [Axis::log("h"), Axis::log("v₀")],
        marked: " The first step of Method I has a solution below the dashed line.",
    },
    Arena {
        runs: fates::LOGISTIC,
        equation: "v̇ = v (1 − v)",
        axes: || [Axis::linear("h").between(0.0, 6.0), Axis::log("v₀")],
        marked: " Below the spurious steady state v = ½ − 1/h, drawn up to where its branch crosses another, Method I goes to 0 instead of \
                 1, and beyond it for small v₀ alone; the dashed line is the fold of its first step.",
    },
];

fn study(context: &Context) -> Result<Evidence, StudyError> {
    let mut evidence = Evidence::default();
    let (mut shares, mut on_drag) = (Vec::new(), Vec::new());
    let crossing = crossing(context)?;
    for arena in ARENAS {
        let runs = METHODS.map(|method| Fates { arena: arena.runs, method });
        let maps = context.get_each(runs.into())?;
        let fold = context.get(Folds { arena: arena.runs })?;
        evidence.checks.extend(checks(&arena, &maps, &fold));
        shares.extend(maps.iter().map(|map| share_row(&arena, map)));
        if arena.runs.problem == fates::QUADRATIC_DRAG.problem {
            on_drag = maps.iter().map(|map| map.share(Fate::Right)).collect();
        }
        let (figure, table) = show(&arena, &maps, &fold, crossing);
        evidence.figures.push(figure);
        evidence.tables.push(table);
    }
    evidence.checks.push(spurious_drag(context)?);
    let (checks, factors) = spurious_logistic(context)?;
    evidence.checks.extend(checks);
    evidence.checks.push(Check::new(
        "logistic/crossing",
        "On v̇ = v (1 − v) the branch from beside v = ½ − 1/h leaves it where it crosses another branch: largest h of live steps that \
         return, distance to the h of the crossing",
        (crossing - CROSSING).abs(),
        // A start beside the state by 10⁻⁹ opens the crossing by the root of that, times a slope of order 10.
        Requirement::AtMost(1e-3),
        "F = ∂F/∂x = ∂F/∂s = 0 of the cubic F(s, x) from v = ½ − 1/h; bisection to 10⁻⁴",
    ));
    evidence.tables.push(factors);
    evidence.checks.push(spurious_method_ii(context)?);
    evidence.tables.insert(
        0,
        Table::new(
            "nonlinear-fates",
            format!("What becomes of runs from a grid of {GRID} × {GRID} pairs (h, v₀), as parts of all of them."),
            &["problem", "method", "right_steady_state", "wrong_steady_state", "no_step", "unsettled"],
            shares,
        ),
    );
    evidence.notes = notes(crossing, &on_drag);
    Ok(evidence)
}

fn share_row(arena: &Arena, map: &Map) -> Vec<Cell> {
    let names = [arena.runs.problem, map.method].map(|name| Cell::Text(name.into()));
    let shares = [Fate::Right, Fate::Wrong, Fate::NoStep, Fate::Unsettled].map(|fate| Cell::Number(map.share(fate)));
    names.into_iter().chain(shares).collect()
}

fn checks(arena: &Arena, maps: &[Arc<Map>], fold: &[(f64, f64)]) -> Vec<Check> {
    let id = |what: &str| format!("{}/{what}", arena.runs.problem);
    let on = |what: &str| format!("On {} {what}", arena.equation);
    let share =
        |method: &str, fate| maps.iter().find(|map| map.method == method).map_or(f64::NAN, |map| map.share(fate));
    let grid = format!("{GRID} × {GRID} pairs (h, v₀), runs of up to {STEPS} steps");
    let mut checks = vec![
        Check::new(
            id("implicit-euler"),
            on("implicit Euler reaches the right steady state from every start: part of the starts"),
            share("implicit-euler", Fate::Right),
            Requirement::AtLeast(1.0),
            grid.as_str(),
        ),
        Check::new(
            id("method-i"),
            on("Method I does not: part of the starts that reach it"),
            share("method-i", Fate::Right),
            Requirement::AtMost(0.99),
            grid.as_str(),
        ),
    ];
    if arena.runs.problem == "quadratic-drag" {
        let exact = drag_fold();
        let deviation = fold.iter().map(|(h, v0)| (h * v0 / exact - 1.0).abs()).largest();
        checks.push(Check::new(
            id("fold"),
            format!("Method I loses its branch at h v₀ = {exact:.6}, the fold of its cubic: largest relative deviation of live steps"),
            if fold.is_empty() { f64::NAN } else { deviation },
            // v₀ is halved to 1e-11 of it; Newton's iteration gives up where √(distance) is at roundoff.
            Requirement::AtMost(1e-8),
            "2X³ + 3X² + (2 − 2W) X + W² − 2W = 0, X = h v₁, has a double root there",
        ));
        checks.push(Check::new(
            id("below-fold"),
            on("every run of Method I that starts below the fold reaches the right steady state: starts that do not"),
            mismatches(arena, maps, exact),
            Requirement::AtMost(0.0),
            grid.as_str(),
        ));
    }
    checks
}

/// Starts of Method I whose fate is not decided by the side of the fold, h v₀ = `fold`.
fn mismatches(arena: &Arena, maps: &[Arc<Map>], fold: f64) -> f64 {
    let Some(map) = maps.iter().find(|map| map.method == "method-i") else { return f64::NAN };
    let mut count = 0;
    let [h, v0] = [arena.runs.h, arena.runs.v0].map(Spacing::values);
    for (v0, row) in v0.iter().zip(&map.fates) {
        for (h, fate) in h.iter().zip(row) {
            let expected = if h * v0 < fold { Fate::Right } else { Fate::NoStep };
            count += usize::from(*fate != expected);
        }
    }
    f64::from(u32::try_from(count).unwrap_or(u32::MAX))
}

/// W = h v₀ at the double root X of the cubic of Method I: W = 1 + 3X + 3X², by bisection.
fn drag_fold() -> f64 {
    let w = |x: f64| 1.0 + 3.0 * x + 3.0 * x * x;
    let cubic = |x: f64| 2.0 * x.powi(3) + 3.0 * x * x + (2.0 - 2.0 * w(x)) * x + w(x) * (w(x) - 2.0);
    root([0.1, 1.0], cubic).map_or(f64::NAN, w)
}

/// v at the end of a run from v₀.
fn end(context: &Context, [problem, method]: [&str; 2], v0: f64, h: f64, steps: u32) -> Result<f64, StudyError> {
    let problem = format!("{problem} v0={v0}");
    Ok(*context.get(End { problem, method: method.into(), h, steps })?)
}

/// Solutions of v̇ = −v² from v₀ < 0 run away; Method I has a steady state there.
fn spurious_drag(context: &Context) -> Result<Check, StudyError> {
    let h = 0.5;
    let v = end(context, ["quadratic-drag", "method-i"], -1.0, h, 400)?;
    Ok(Check::new(
        "quadratic-drag/spurious",
        "On v̇ = −v² Method I turns the runaway from v₀ = −1 into a steady state at v = −1/h, where f is not zero: distance",
        (v + 1.0 / h).abs(),
        Requirement::AtMost(1e-12),
        "h = 0.5, 400 steps; fixed points satisfy (2 − hJ) f = 0, and hJ = 2 at v = −1/h",
    ))
}

/// The largest h at which the branch of solutions from beside v = ½ − 1/h leads back there: beyond, it passes a crossing with another
/// one at a smaller step, and goes up.
fn crossing(context: &Context) -> Result<f64, StudyError> {
    let (mut below, mut above) = (2.2, 2.8);
    while above - below > 1e-4 {
        let h = 0.5 * (below + above);
        let v0 = spurious_state(h) + 1e-9;
        let v = end(context, ["logistic", "method-i"], v0, h, 1)?;
        if (v - v0).abs() < 1e-6 { below = h } else { above = h }
    }
    Ok(below)
}

/// On logistic growth hJ = 2 at v = ½ − 1/h, between the two steady states if h > 2. A small distance from there is
/// multiplied in each step by 4/(8 − h²), up to the [`crossing`].
fn spurious_logistic(context: &Context) -> Result<(Vec<Check>, Table), StudyError> {
    let (mut checks, mut rows) = (Vec::new(), Vec::new());
    for h in [2.2, 2.3, 2.4] {
        let spurious = spurious_state(h);
        let end = |v0: f64, steps: u32| end(context, ["logistic", "method-i"], v0, h, steps);
        let distance = 1e-5;
        let (predicted, factor) = (4.0 / (8.0 - h * h), (end(spurious + distance, 1)? - spurious) / distance);
        let (below, above) = (end(0.9 * spurious, STEPS)?, end(1.1 * spurious, STEPS)?);
        rows.push([h, spurious, predicted, factor, below, above].map(Cell::found).to_vec());
        checks.push(Check::new(
            format!("logistic/factor-{h}"),
            format!("On v̇ = v (1 − v) with h = {h} a step of Method I multiplies a small distance from v = ½ − 1/h by 4/(8 − h²): relative deviation"),
            (factor / predicted - 1.0).abs(),
            Requirement::AtMost(1e-3),
            "from a distance of 10⁻⁵, times curvatures of order 10",
        ));
        checks.push(separatrix(h, [below, above]));
    }
    // The crossing is met on the way to each longer step.
    for h in [2.6, 3.0, 5.0] {
        let end = |part: f64| end(context, ["logistic", "method-i"], part * BORDER, h, STEPS);
        checks.push(Check::new(
            format!("logistic/border-{h}"),
            format!("With h = {h} runs from a tenth above the start of the crossing end at 1, runs from a tenth below it at 0: largest distance"),
            larger((end(1.1)? - 1.0).abs(), end(0.9)?.abs()),
            Requirement::AtMost(1e-12),
            "2000 steps; the start of the crossing does not depend on h",
        ));
    }
    let caption = "Method I on v̇ = v (1 − v) near its spurious steady state: the factor of a small distance in one step, predicted and \
                   of a live one, and where runs from 0.9 and 1.1 times the state end.";
    let columns = ["h", "spurious", "predicted", "factor", "from_below", "from_above"];
    Ok((checks, Table::new("spurious-logistic", caption, &columns, rows)))
}

/// Where runs from below and from above the spurious state end.
fn separatrix(h: f64, [below, above]: [f64; 2]) -> Check {
    Check::new(
        format!("logistic/separatrix-{h}"),
        format!("With h = {h} runs from a tenth above it end at 1, runs from a tenth below it at 0: largest distance"),
        larger((above - 1.0).abs(), below.abs()),
        Requirement::AtMost(1e-12),
        "2000 steps; 0 attracts for h > 2, where 1/(1 − h + h²/2) < 1",
    )
}

/// The fixed points of Method II satisfy J f = 0: v = ½ is one on logistic growth, and a step from there, where J is singular, is refused.
fn spurious_method_ii(context: &Context) -> Result<Check, StudyError> {
    let step = StepEquation { problem: "logistic v0=0.5", weights: StepEquation::METHOD_II, h: 1.0 };
    let Found::Roots(roots) = &*context.get(step)? else { return Err("not every end is a root".into()) };
    Ok(Check::new(
        "logistic/method-ii",
        "On v̇ = v (1 − v) the equation of a step of Method II from v = ½, where the growth is fastest, has the root ½: distance of the nearest root",
        roots.iter().map(|v| (v - 0.5).abs()).smallest(),
        Requirement::AtMost(1e-12),
        "h = 1; the step is refused, as its equation leaves it open for h → 0",
    ))
}

/// 1/(½ − v) where s²(2x³ − 3x² + x) + s(3x² − 2x − 2vx + v²) + 2(x − v) and its derivatives in x and in s vanish together:
/// s = 2.123 035 56, x = 0.286 740 04, v = 0.090 150 666, by Newton's method.
const CROSSING: f64 = 1.0 / (0.5 - BORDER);
const BORDER: f64 = 0.090_150_666;

/// hJ = 2 on logistic growth.
fn spurious_state(h: f64) -> f64 {
    0.5 - 1.0 / h
}

fn show(arena: &Arena, maps: &[Arc<Map>], fold: &[(f64, f64)], crossing: f64) -> (Figure, Table) {
    let [h, v0] = [arena.runs.h, arena.runs.v0].map(Spacing::values);
    let panels = maps.iter().map(|map| {
        let [x, y] = (arena.axes)();
        let marked = map.method == "method-i" && !fold.is_empty();
        let curve = marked.then(|| Series::new("fold of the first step", fold.to_vec(), Mark::Guide));
        let values = map.fates.iter().map(|row| row.iter().map(|fate| f64::from(*fate as u8)).collect()).collect();
        let separatrix = (arena.runs.problem == "logistic" && map.method == "method-i").then(|| {
            let points = (1..=40).map(|i| 2.0 + (crossing - 2.0) * f64::from(i) / 40.0).map(|h| (h, spurious_state(h)));
            Series::new("v = ½ − 1/h", points.collect(), Mark::Line)
        });
        Panel {
            title: map.method.into(),
            x,
            y,
            series: curve.into_iter().chain(separatrix).collect(),
            field: Some(Field {
                x: h.clone(),
                y: v0.clone(),
                values,
                levels: vec![0.5, 1.5, 2.5],
                bands: ["right steady state", "wrong steady state", "no solution of a step", "unsettled"]
                    .map(Into::into)
                    .to_vec(),
                contours: false,
            }),
        }
    });
    let id = format!("fates-{}", arena.runs.problem);
    let figure = Figure {
        id: id.clone(),
        caption: format!(
            "What becomes of runs on {} over step size and initial value.{}",
            arena.equation, arena.marked
        ),
        data: id.clone(),
        panels: panels.collect(),
        columns: 2,
    };
    let mut rows = Vec::new();
    for map in maps {
        for (v0, fates) in v0.iter().zip(&map.fates) {
            for (h, fate) in h.iter().zip(fates) {
                let fate = format!("{fate:?}").to_lowercase();
                rows.push(vec![Cell::Text(map.method.into()), Cell::found(*h), Cell::found(*v0), Cell::Text(fate)]);
            }
        }
    }
    let caption = format!("What becomes of runs on {}.", arena.equation);
    (figure, Table::data(&id, caption, &["method", "h", "v0", "fate"], rows))
}

/// `on_drag` are the parts of the starts from which each of the methods reaches the right steady state there.
fn notes(crossing: f64, on_drag: &[f64]) -> Vec<String> {
    let parts: Vec<String> =
        METHODS.iter().zip(on_drag).map(|(method, part)| format!("`{method}` {}", digits(*part, 2))).collect();
    vec![
        format!(
            "Method I is called unconditionally stable for dissipative systems. Where they are nonlinear it need not be. On v̇ = −v² its step is a \
         cubic with the right root on the branch from the present state, and that branch ends in a fold at h v₀ = {:.3}: beyond, \
         a step has no solution that continues it, and the integrator says so. Below the fold every run from v₀ > 0 reaches the right steady \
         state. Of the starts and steps of the picture, those from which a run reaches it are, as parts of all: {}. Implicit Euler has a root \
         for every step.",
            drag_fold(),
            parts.join(", ")
        ),
        format!(
            "From a negative start, where solutions of v̇ = −v² blow up, Method I goes to v = −1/h, a steady state of the scheme and \
             not of the equation. On the logistic equation it has one at v = ½ − 1/h for h > 2, between the two true ones. It \
             repels, and up to h = {crossing:.2} what starts below it goes to 0: the state that repels every solution attracts the scheme, which damps \
             fast growth like fast decay, by 1/(1 − h + h²/2) < 1. The answer is wrong, smooth and steady. For \
             h ≥ {crossing:.2} the branch from beside that state crosses another on the way, and leads up from it. There the border is at {}, whatever h is: \
             starts below it go to 0, and those above it go to 1 where their steps have solutions. Implicit Euler damps fast growth too, but the branch that it keeps to leads to 1 from every start.",
            brief(BORDER)
        ),
        "Method II has a steady state of its own wherever f_v = 0, v = ½ on the logistic equation, and \
         many of its runs come to a step without a solution."
            .into(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;

    fn map(method: &'static str, fates: [Fate; 4]) -> Arc<Map> {
        Arc::new(Map { method, fates: vec![fates.to_vec()] })
    }

    #[test]
    fn each_fate_has_its_column() {
        use Fate::{NoStep, Right, Unsettled, Wrong};
        let of = |fates| {
            share_row(&ARENAS[0], &map("method-i", fates))[2..].iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        assert_eq!(of([Wrong, Wrong, NoStep, Right]), ["0.25", "0.5", "0.25", "0"]);
        assert_eq!(of([Unsettled, NoStep, NoStep, NoStep]), ["0", "0", "0.75", "0.25"]);
    }

    #[test]
    fn the_claim_on_a_method_is_judged_on_its_own_runs() {
        let [all, some] = [[Fate::Right; 4], [Fate::Right, Fate::Right, Fate::Right, Fate::NoStep]];
        let outcomes = |euler, own| {
            let maps = [map("method-i", own), map("method-ii", all), map("implicit-euler", euler)];
            checks(&ARENAS[1], &maps, &[]).iter().map(|check| check.outcome).collect::<Vec<_>>()
        };
        assert_eq!(outcomes(all, some), [Outcome::Pass; 2]);
        assert_eq!(outcomes(all, all), [Outcome::Pass, Outcome::Fail]);
        assert_eq!(outcomes(some, some), [Outcome::Fail, Outcome::Pass]);
    }

    #[test]
    fn a_state_separates_where_runs_from_either_side_of_it_go_their_way() {
        let outcome = |ends| separatrix(2.2, ends).outcome;
        assert_eq!(outcome([1e-13, 1.0 - 1e-13]), Outcome::Pass);
        for ends in [[1.0, 1.0], [0.0, 0.0], [1.0, 0.0], [f64::NAN, 1.0], [0.0, f64::NAN]] {
            assert_eq!(outcome(ends), Outcome::Fail, "{ends:?}");
        }
    }
}
