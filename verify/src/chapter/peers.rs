//! Work against error beside the solvers of other libraries, on stiff and parabolic problems.

use std::time::Instant;

use lsvi::adaptive::Tolerances;
use rayon::prelude::*;

use super::{Context, Study, StudyError};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Outcome, Panel, Requirement, Series, Table};
use crate::kinds::Principle;
use crate::measure::norm::distance;
use crate::method::Method;
use crate::problem::{self, Problem};
use crate::reference::{self, ReferenceError};
use crate::run::{Run, run as integrate};
use crate::{method, reference::Reference};

pub(super) const STUDY: Study = Study {
    id: "peers",
    title: "Work beside CVODE and diffsol",
    question: "How much work do the methods here need for an accuracy, and how much CVODE and diffsol?",
    source: "fixed steps, and tolerances of the adaptive solvers",
    run,
};

/// Methods with fixed steps.
const FIXED: [&str; 5] = ["method-i", "trapezoidal", "tr-bdf2", "ls-galerkin(2,radau,2)", "ls-galerkin(2,gauss,2)"];

/// Steps in a run.
const STEPS: [u32; 7] = [8, 16, 32, 64, 128, 256, 512];

/// A problem that all solvers are given.
struct Setting {
    problem: &'static str,
    horizon: f64,
    /// Whether as many fixed steps as [`STEPS`] resolve it.
    fixed: bool,
}

const SETTINGS: [Setting; 3] = [
    Setting { problem: "channel-poiseuille cells=64", horizon: 1.0, fixed: true },
    Setting { problem: "van-der-pol", horizon: 2.0, fixed: true },
    Setting { problem: "van-der-pol mu=1000", horizon: 2000.0, fixed: false },
];

struct Point {
    solver: String,
    setting: f64,
    counts: [u64; 3],
    error: f64,
    /// Of one run, beside others.
    seconds: f64,
}

fn run(context: &Context) -> Result<Evidence, StudyError> {
    context.announce(SETTINGS.len());
    let measured = SETTINGS.par_iter().map(|setting| {
        let points = measure(&*problem::build_setting(setting.problem)?, setting.horizon, setting.fixed);
        context.tick();
        points
    });
    let measured = measured.collect::<Result<Vec<_>, StudyError>>()?;
    let mut evidence = Evidence { notes: notes(), ..Evidence::default() };
    let mut rows = Vec::new();
    let (mut panels, mut timed) = (Vec::new(), Vec::new());
    for (Setting { problem: title, .. }, (points, absent)) in SETTINGS.iter().zip(&measured) {
        let panel = |label: &str, work: fn(&Point) -> f64| {
            let curves = points.chunk_by(|a, b| a.solver == b.solver).map(|run| {
                let curve = run.iter().map(|p| (work(p), p.error)).collect();
                Series::new(run[0].solver.clone(), curve, Mark::LineMarkers)
            });
            let (x, y) = (Axis::log(label), Axis::log("error at the end"));
            Panel { title: (*title).into(), x, y, series: curves.collect(), ..Panel::default() }
        };
        panels.push(panel("evaluations", |p| p.counts[1] as f64));
        panels.push(panel("factorizations", |p| p.counts[2] as f64));
        timed.push(panel("seconds, measured once", |p| p.seconds));
        let timings = points.iter().map(|p| (format!("{title} {} {:e}", p.solver, p.setting), p.seconds));
        evidence.timings.extend(timings);
        rows.extend(points.iter().map(|p| {
            let start = [Cell::from(*title), Cell::from(&p.solver), Cell::Number(p.setting), Cell::Number(p.error)];
            start.into_iter().chain(p.counts.map(|count| Cell::Integer(count as i64))).collect::<Vec<_>>()
        }));
        let id = title.replace([' ', '='], "-");
        let cheapest = |of: &dyn Fn(&str) -> bool| cheapest(points, of);
        let ours = cheapest(&|solver| solver == "radau-adaptive");
        let theirs = cheapest(&|solver| reference::by_name(solver).is_some());
        let mut verdict = Check::new(
            format!("{id}/radau-adaptive"),
            format!(
                "{title}: factorizations of radau-adaptive over the fewest of any peer, for an error of {TARGET:e}"
            ),
            ours / theirs,
            Requirement::AtMost(MOST),
            "alike, with two factors a step, one of them of twice the order, that are kept over longer steps",
        );
        if !absent.is_empty() && theirs.is_infinite() {
            verdict.outcome = Outcome::NotRun;
            verdict.reason = absent.join("; ");
        }
        evidence.checks.push(verdict);
    }
    let caption = "Error at the end against evaluations of f, or of the step equations, and against factorizations of matrices: fixed \
                   steps from 8 to 512 in a run, and tolerances from 1e-3 to 1e-9.";
    let columns = ["problem", "solver", "h_or_tolerance", "error", "steps", "evaluations", "factorizations"];
    evidence.tables.push(Table::data("peers", caption, &columns, rows));
    let (id, data) = ("peers".into(), "peers".into());
    evidence.figures.push(Figure { id, caption: caption.into(), data, panels, columns: 2 });
    evidence.figures.push(Figure {
        id: "peers-times".into(),
        caption: "The same errors against time, as measured on the machine that made this page, beside other computations: not \
                  reproducible. The times are in `timings.json`."
            .into(),
        data: "peers".into(),
        panels: timed,
        columns: 3,
    });
    Ok(evidence)
}

/// Error at which the adaptive solvers are compared.
const TARGET: f64 = 1e-5;

/// Solvers within this factor of each other are alike: the count of one moves by as much from one tolerance to the next.
const MOST: f64 = 2.0;

/// Fewest factorizations of a run with an error below the target.
fn cheapest(points: &[Point], of: &dyn Fn(&str) -> bool) -> f64 {
    let reached = points.iter().filter(|p| of(&p.solver) && p.error <= TARGET && p.counts[2] > 0);
    reached.map(|p| p.counts[2]).min().map_or(f64::INFINITY, |count| count as f64)
}

/// The points of every solver, and why peers are absent.
fn measure(problem: &dyn Problem, horizon: f64, fixed: bool) -> Result<(Vec<Point>, Vec<String>), StudyError> {
    let limit = problem.limit(Principle::MomentumZero);
    let truth = (limit.exact)(horizon).or_else(|| problem.tabulated(horizon)).ok_or("the solution is known")?;
    let mut points = Vec::new();
    for name in FIXED.iter().filter(|_| fixed) {
        for steps in STEPS {
            let h = horizon / f64::from(steps);
            points.push(own(problem, &*method::parse(name)?, h, (h, horizon), &truth)?);
        }
    }
    let tolerances: Vec<f64> = (6..=18).map(|k| 10_f64.powf(-0.5 * f64::from(k))).collect();
    for tolerance in &tolerances {
        let adaptive = method::parse("radau-adaptive")?.with_tolerances(Tolerances::new(*tolerance, *tolerance)?);
        let method = adaptive.ok_or("it is adaptive")?;
        points.push(own(problem, &*method, *tolerance, (horizon, horizon), &truth)?);
    }
    let mut absent = Vec::new();
    for reference in reference::all().into_iter().filter(|reference| reference.stiff_ok()) {
        for tolerance in &tolerances {
            match peer(reference, problem, horizon, *tolerance, &truth) {
                Ok(point) => points.push(point),
                Err(error @ ReferenceError::Unavailable(_)) => {
                    absent.push(error.to_string());
                    break;
                }
                Err(error) => return Err(error.into()),
            }
        }
    }
    Ok((points, absent))
}

/// A run with steps of h up to the horizon, under the name of the method.
fn own(
    problem: &dyn Problem,
    method: &dyn Method,
    setting: f64,
    (h, horizon): (f64, f64),
    truth: &[f64],
) -> Result<Point, StudyError> {
    let Run { end, work, seconds } = integrate(problem, method, h, horizon, |_| {})?;
    let counts = [work.steps, work.residuals, work.factorizations];
    Ok(Point { solver: method.name(), setting, counts, error: distance(&end.q, truth), seconds })
}

fn peer(
    reference: &dyn Reference,
    problem: &dyn Problem,
    horizon: f64,
    tolerance: f64,
    truth: &[f64],
) -> Result<Point, ReferenceError> {
    let limit = problem.limit(Principle::MomentumZero);
    let begun = Instant::now();
    let run = reference.run(limit.ode, 0.0, &limit.initial, &[horizon], tolerance)?;
    let error = run.states.last().map_or(f64::NAN, |state| distance(state, truth));
    let counts = [run.work.steps, run.work.rhs, run.work.factorizations];
    let seconds = begun.elapsed().as_secs_f64();
    Ok(Point { solver: reference.name().into(), setting: tolerance, counts, error, seconds })
}

fn notes() -> Vec<String> {
    vec![
        "Evaluations are counted as each library counts them: of f in CVODE and diffsol, of the step equations here, one for each \
         iteration of Newton's method, which for a method of s stages hold s values of f. A linear problem is factored once \
         for a step size where its structure is known, so that fixed steps need one or two factorizations in a run."
            .into(),
    ]
}
