//! Work against error beside the solvers of other libraries.

use super::{Context, Study, StudyError, prose};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Outcome, Panel, Requirement, Series, Spread, Table};
use crate::experiment::orders::LOST;
use crate::experiment::work_error::{Found, Plan, Point, Times, WorkError};
use crate::{problem, row};

pub(super) const STUDY: Study = Study {
    id: "peers",
    title: "Work beside CVODE and diffsol",
    question: "How much work do the methods here need for an accuracy, and how much CVODE and diffsol?",
    source: "fixed steps, and tolerances of the adaptive solvers",
    run,
};

/// A problem that all solvers are given.
struct Setting {
    problem: &'static str,
    horizon: f64,
    plan: Plan,
}

const FINE: &[i32] = &[6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18];
const FIXED: Plan = Plan {
    methods: &["method-i", "trapezoidal", "tr-bdf2", "ls-galerkin(2,radau,2)", "ls-galerkin(2,gauss,2)"],
    steps: &[8, 16, 32, 64, 128, 256, 512],
    halves: FINE,
};
/// As many fixed steps as [`FIXED`] has do not resolve it.
const ADAPTIVE: Plan = Plan { methods: &[], steps: &[], halves: FINE };

const SETTINGS: [Setting; 3] = [
    Setting { problem: "channel-poiseuille cells=64", horizon: 1.0, plan: FIXED },
    Setting { problem: "van-der-pol", horizon: 2.0, plan: FIXED },
    Setting { problem: "van-der-pol mu=1000", horizon: 2000.0, plan: ADAPTIVE },
];

/// What every problem is given.
const EVERYWHERE: Plan = Plan {
    methods: &[
        "method-i",
        "trapezoidal",
        "rk4",
        "ls-galerkin(2,radau,2)",
        "path-fitted(4)",
        "path-fitted(4,gauss)",
        "galerkin-gauss(3)",
    ],
    steps: &[16, 32, 64, 128, 256, 512],
    halves: &[6, 9, 12, 15, 18],
};

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let mut evidence = Evidence { notes: prose::fill(include_str!("peers.md"), &[])?, ..Evidence::default() };
    let runs = SETTINGS.iter().map(|setting| WorkError {
        problem: setting.problem,
        horizon: setting.horizon,
        plan: setting.plan,
        timed_at: Some(TARGET),
    });
    let measured = context.get_each(runs.collect())?;
    let (mut rows, mut panels) = (Vec::new(), Vec::new());
    for (Setting { problem: title, .. }, found) in SETTINGS.iter().zip(&measured) {
        panels.push(panel(title, "evaluations", found, |p| p.evaluations));
        panels.push(panel(title, "factorizations", found, |p| p.factorizations));
        rows.extend(table_rows(title, found));
        evidence.checks.push(check(title, found));
        evidence.spreads.extend(spread(title, found));
    }
    let caption = format!(
        "Error at the end against evaluations of f, in step equations as many as there are stages, and against factorizations of matrices: fixed \
         steps from 8 to 512 in a run, and tolerances from 1e-3 to 1e-9. Errors above {LOST} are left out."
    );
    evidence.tables.push(Table::data("peers", caption.clone(), COLUMNS, rows));
    let figure = Figure::new("peers", caption, "peers", panels).in_columns(2);
    evidence.figures.push(figure.telling(&TOLD));
    everywhere(context, &mut evidence)?;
    Ok(evidence)
}

const COLUMNS: [&str; 7] = ["problem", "solver", "h_or_tolerance", "error", "steps", "evaluations", "factorizations"];

fn table_rows(title: &str, found: &Found) -> Vec<Vec<Cell>> {
    let row = |p: &Point| row![title, &p.solver, p.setting, p.error, p.steps, p.evaluations, p.factorizations];
    found.points.iter().filter(|p| !p.error.is_nan()).map(row).collect()
}

fn panel(title: &str, label: &str, found: &Found, work: fn(&Point) -> u64) -> Panel {
    let curves = found.by_solver().map(|run| {
        // Of an explicit method nothing is factored.
        let points =
            run.iter().filter(|p| work(p) > 0 && p.error > 0.0 && p.error <= LOST).map(|p| (work(p) as f64, p.error));
        Series::new(run[0].solver.clone(), points.collect(), Mark::LineMarkers)
    });
    let curves = curves.filter(|series| !series.points.is_empty()).collect();
    Panel::new(Axis::log(label), Axis::log("error at the end"), curves).titled(title)
}

/// Methods of fixed steps, the adaptive one, and a reference of either library.
pub(super) const TOLD: [&str; 6] = ["method-i", "trapezoidal", "rk4", "radau-adaptive", "cvode-bdf", "diffsol-bdf"];

/// A panel for every problem.
fn everywhere(context: &Context, evidence: &mut Evidence) -> Result<(), StudyError> {
    let mut runs = Vec::new();
    for spec in problem::paired() {
        let horizon = problem::small(spec.name)?.horizon();
        runs.push(WorkError { problem: spec.name, horizon, plan: EVERYWHERE, timed_at: None });
    }
    let names: Vec<&str> = runs.iter().map(|run| run.problem).collect();
    let found = context.get_each(runs)?;
    let (mut rows, mut panels) = (Vec::new(), Vec::new());
    for (name, found) in names.into_iter().zip(&found) {
        panels.push(panel(name, "steps", found, |p| p.steps));
        rows.extend(table_rows(name, found));
    }
    let caption = format!(
        "Error at the end against steps on every problem but the two-dimensional flows, large ones in their small version: methods with fixed steps beside \
                   radau-adaptive, CVODE and diffsol at tolerances from 1e-3 to 1e-9. A method with fixed steps is a line whose slope \
                   is its order; an adaptive one takes its steps where the solution moves. Errors above {LOST} are left out."
    );
    evidence.tables.push(Table::data("peers-everywhere", caption.clone(), COLUMNS, rows));
    let figure = Figure::new("peers-everywhere", caption, "peers-everywhere", panels).in_columns(3);
    evidence.figures.push(figure.telling(&TOLD));
    Ok(())
}

/// Error at which the solvers are compared.
const TARGET: f64 = 1e-5;

/// Solvers within this factor of each other are alike: the count of one moves by as much from one tolerance to the next.
const MOST: f64 = 2.0;

fn check(title: &str, found: &Found) -> Check {
    let fewest = |of_references: bool, name: &str| {
        let ranked = found.ranked(of_references, TARGET, |p| p.factorizations);
        // A solver that factors nothing is none for stiff problems.
        let mut counts = ranked.iter().filter(|p| p.solver.contains(name) && p.factorizations > 0);
        counts.next().map_or(f64::INFINITY, |p| p.factorizations as f64)
    };
    let (ours, theirs) = (fewest(false, "radau-adaptive"), fewest(true, ""));
    let mut verdict = Check::new(
        format!("{}/radau-adaptive", title.replace([' ', '='], "-")),
        format!("{title}: factorizations of radau-adaptive over the fewest of any peer, for an error of {TARGET:e}"),
        // Nothing to compare with is no success.
        if theirs.is_finite() { ours / theirs } else { f64::NAN },
        Requirement::AtMost(MOST),
        "alike, with two factors a step, one of them of twice the order, that are kept over longer steps",
    );
    if !found.absent.is_empty() && theirs.is_infinite() {
        verdict.outcome = Outcome::NotRun;
        verdict.reason = found.absent.join("; ");
    }
    verdict
}

/// The times of a problem as multiples of the fastest run of the first reference, or of the first solver where there is none.
fn spread(title: &str, found: &Found) -> Vec<Spread> {
    let base = found.times.iter().find(|times| times.is_reference).or(found.times.first());
    let Some(base) = base else { return Vec::new() };
    // Beside other computations the fastest of some runs is the least disturbed.
    let least = base.seconds[0];
    let spread = |times: &Times| {
        let at = |place: usize| times.seconds[place] / least;
        let last = times.seconds.len() - 1;
        Spread {
            what: title.to_owned(),
            solver: times.solver.clone(),
            base: base.solver.clone(),
            ratios: [at(0), at(last / 4), at(last / 2)],
        }
    };
    found.times.iter().map(spread).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(solver: &str, is_reference: bool, factorizations: u64) -> Point {
        let [setting, error, seconds] = [1e-6, 1e-6, 1.0];
        Point { solver: solver.into(), is_reference, setting, steps: 1, evaluations: 1, factorizations, error, seconds }
    }

    #[test]
    fn the_adaptive_method_is_judged_by_its_own_run_against_the_best_peer() {
        let ratio = |own: u64| {
            let ours = [point("method-i", false, 1), point("radau-adaptive", false, own), point("rk4", false, 0)];
            let theirs = [point("cvode-bdf", true, 100), point("diffsol-bdf", true, 500)];
            let check = check("p", &Found { points: [&ours[..], &theirs].concat(), ..Found::default() });
            (check.measured, check.outcome)
        };
        assert_eq!(ratio(190), (Some(1.9), Outcome::Pass));
        assert_eq!(ratio(210), (Some(2.1), Outcome::Fail));
        // What factors nothing is not compared.
        assert_eq!(ratio(0), (Some(f64::INFINITY), Outcome::Fail));
    }

    #[test]
    fn times_are_multiples_of_the_fastest_run_of_the_first_reference() {
        let times = |solver: &str, is_reference, scale: f64| {
            let seconds = [1.0, 2.0, 3.0, 5.0, 6.0, 7.0, 8.0].map(|time| scale * time).into();
            Times { solver: solver.into(), is_reference, seconds }
        };
        let times = vec![times("method-i", false, 8.0), times("cvode-bdf", true, 2.0), times("diffsol-bdf", true, 1.0)];
        let found = spread("p", &Found { times, ..Found::default() });
        assert!(found.iter().all(|spread| spread.base == "cvode-bdf"), "{found:?}");
        let ratios: Vec<_> = found.iter().map(|spread| spread.ratios).collect();
        assert_eq!(ratios, [[4.0, 8.0, 20.0], [1.0, 2.0, 5.0], [0.5, 1.0, 2.5]]);
    }
}
