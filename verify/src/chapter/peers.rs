//! Work against error beside the solvers of other libraries, on stiff and parabolic problems.

use super::{Context, Study, StudyError, prose};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Outcome, Panel, Requirement, Series, Table};
use crate::experiment::peers::{Found, Peers, Point};
use crate::row;

pub(super) const STUDY: Study = Study {
    id: "peers",
    title: "Work beside CVODE and diffsol",
    question: "How much work do the methods here need for an accuracy, and how much CVODE and diffsol?",
    source: "fixed steps, and tolerances of the adaptive solvers",
    run,
};

/// The problems with their ends.
const SETTINGS: [(&str, f64, bool); 3] =
    [("channel-poiseuille cells=64", 1.0, true), ("van-der-pol", 2.0, true), ("van-der-pol mu=1000", 2000.0, false)];

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let settings = SETTINGS.map(|(problem, horizon, fixed)| Peers { problem, horizon, fixed });
    let measured = context.get_each(settings.into())?;
    let mut evidence = Evidence { notes: prose::fill(include_str!("peers.md"), &[])?, ..Evidence::default() };
    let (mut rows, mut panels, mut timed) = (Vec::new(), Vec::new(), Vec::new());
    for ((title, ..), found) in SETTINGS.iter().zip(&measured) {
        let points = &found.points;
        let panel = |label: &str, work: fn(&Point) -> f64| {
            let curves = points.chunk_by(|a, b| a.solver == b.solver).map(|run| {
                let curve = run.iter().map(|p| (work(p), p.error)).collect();
                Series::new(run[0].solver.clone(), curve, Mark::LineMarkers)
            });
            Panel::new(Axis::log(label), Axis::log("error at the end"), curves.collect()).titled(*title)
        };
        panels.push(panel("evaluations", |p| p.counts[1] as f64));
        panels.push(panel("factorizations", |p| p.counts[2] as f64));
        timed.push(panel("seconds, measured once", |p| p.seconds));
        let timings = points.iter().map(|p| (format!("{title} {} {:e}", p.solver, p.setting), p.seconds));
        evidence.timings.extend(timings);
        rows.extend(
            points
                .iter()
                .map(|p| [row![*title, &p.solver, p.setting, p.error], p.counts.map(Cell::from).into()].concat()),
        );
        evidence.checks.push(check(title, found));
    }
    let caption = "Error at the end against evaluations of f, or of the step equations, and against factorizations of matrices: fixed \
                   steps from 8 to 512 in a run, and tolerances from 1e-3 to 1e-9.";
    let columns = ["problem", "solver", "h_or_tolerance", "error", "steps", "evaluations", "factorizations"];
    evidence.tables.push(Table::data("peers", caption, columns, rows));
    evidence.figures.push(Figure::new("peers", caption, "peers", panels).in_columns(2));
    let caption = "The same errors against time, as measured on the machine that made this page, beside other computations: not \
                   reproducible. The times are in `timings.json`.";
    evidence.figures.push(Figure::new("peers-times", caption, "peers", timed).in_columns(3));
    Ok(evidence)
}

/// Error at which the adaptive solvers are compared.
const TARGET: f64 = 1e-5;

/// Solvers within this factor of each other are alike: the count of one moves by as much from one tolerance to the next.
const MOST: f64 = 2.0;

fn check(title: &str, Found { points, absent }: &Found) -> Check {
    let id = title.replace([' ', '='], "-");
    let ours = cheapest(points, |p| p.solver == "radau-adaptive");
    let theirs = cheapest(points, |p| p.is_peer);
    let mut check = Check::new(
        format!("{id}/radau-adaptive"),
        format!("{title}: factorizations of radau-adaptive over the fewest of any peer, for an error of {TARGET:e}"),
        // Nothing to compare with is no success.
        if theirs.is_finite() { ours / theirs } else { f64::NAN },
        Requirement::AtMost(MOST),
        "alike, with two factors a step, one of them of twice the order, that are kept over longer steps",
    );
    if !absent.is_empty() && theirs.is_infinite() {
        check.outcome = Outcome::NotRun;
        check.reason = absent.join("; ");
    }
    check
}

/// Fewest factorizations of a run with an error below the target.
fn cheapest(points: &[Point], of: impl Fn(&Point) -> bool) -> f64 {
    let reached = points.iter().filter(|p| of(p) && p.error <= TARGET && p.counts[2] > 0);
    reached.map(|p| p.counts[2]).min().map_or(f64::INFINITY, |count| count as f64)
}
