//! Sweeps, and times of those runs that decide.

use cpu_time::ProcessTime;

use crate::front::{Bracket, Point, guarded};
use crate::problem::{Problem, System};
use crate::solver::Solver;

/// The errors at which solvers are compared.
pub(crate) const TARGETS: [f64; 3] = [1e-3, 1e-6, 1e-9];

/// CPU time that one measurement is to take at least, in seconds, so that the clock's resolution does not matter.
const LONG_ENOUGH: f64 = 1e-3;

/// CPU time of one run, in seconds, after which a solver's finer settings are not tried.
const PATIENCE: f64 = 1.0;

/// Solvers whose run of the sweep took at most this many times that of the fastest on their side are timed in rounds.
const CLOSE: f64 = 2.0;

/// The two sides of a comparison on problems P.
pub(crate) struct Sides<P> {
    pub(crate) ours: Vec<Box<dyn Solver<P>>>,
    pub(crate) peers: Vec<Box<dyn Solver<P>>>,
}

/// A solver and its CPU time in seconds at an error.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cost {
    pub(crate) solver: String,
    pub(crate) seconds: f64,
}

/// What was found at one error.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cell {
    pub(crate) error: f64,
    /// The fastest of each side; nothing where none has so small an error.
    pub(crate) ours: Option<Cost>,
    pub(crate) peer: Option<Cost>,
}

impl Cell {
    /// Our time in terms of the peer's; nothing where either fails.
    pub(crate) fn ratio(&self) -> Option<f64> {
        Some(self.ours.as_ref()?.seconds / self.peer.as_ref()?.seconds)
    }
}

/// The time of each solver at each of [`TARGETS`], from its sweep alone.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    pub(crate) solver: String,
    pub(crate) seconds: [Option<f64>; TARGETS.len()],
}

/// What was found on a problem.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) cells: Vec<Cell>,
    pub(crate) rows: Vec<Row>,
}

/// A solver with its sweep.
struct Swept<'a, P> {
    solver: &'a dyn Solver<P>,
    is_ours: bool,
    points: Vec<Point>,
}

/// Compares the two sides on `problem`, with medians over so many rounds.
pub(crate) fn compare<const N: usize, S: System<N>>(
    problem: &Problem<N, S>,
    sides: &Sides<Problem<N, S>>,
    rounds: u16,
) -> Found {
    let both = sides.ours.iter().map(|s| (s, true)).chain(sides.peers.iter().map(|s| (s, false)));
    let swept: Vec<Swept<Problem<N, S>>> =
        both.map(|(solver, is_ours)| Swept { solver: &**solver, is_ours, points: sweep(&**solver, problem) }).collect();
    let rows = swept.iter().map(|swept| Row {
        solver: swept.solver.name(),
        seconds: TARGETS.map(|target| Some(Bracket::of(&swept.points, target)?.seconds(target))),
    });
    Found { rows: rows.collect(), cells: TARGETS.map(|target| cell(problem, &swept, target, rounds)).to_vec() }
}

/// The runs of a solver from coarse to fine, down to the least error that is asked for.
fn sweep<const N: usize, S: System<N>>(solver: &dyn Solver<Problem<N, S>>, problem: &Problem<N, S>) -> Vec<Point> {
    let finest = TARGETS.into_iter().fold(f64::INFINITY, f64::min);
    let mut points: Vec<Point> = Vec::new();
    for setting in solver.settings(problem) {
        let (state, seconds) = timed(|| solver.run(problem, setting));
        let error = state.map_or(f64::INFINITY, |state| problem.error(&state));
        let is_done = error <= finest && points.last().is_some_and(|last| last.error <= finest);
        points.push(Point { setting, error, seconds });
        if is_done || seconds > PATIENCE {
            break;
        }
    }
    guarded(points)
}

/// The result of `run` and its CPU time, in seconds: the mean over as many repeats as are long enough together.
fn timed<T>(mut run: impl FnMut() -> T) -> (T, f64) {
    let start = ProcessTime::now();
    let result = run();
    let first = start.elapsed().as_secs_f64();
    if first >= LONG_ENOUGH {
        return (result, first);
    }
    let repeats = (LONG_ENOUGH / first.max(1e-7)).ceil();
    (result, repeated(repeats, run))
}

/// The mean CPU time of so many repeats, in seconds.
fn repeated<T>(repeats: f64, mut run: impl FnMut() -> T) -> f64 {
    let start = ProcessTime::now();
    for _ in 0..repeats as u32 {
        std::hint::black_box(run());
    }
    start.elapsed().as_secs_f64() / repeats
}

/// The fastest of each side at the error `target`.
fn cell<const N: usize, S: System<N>>(
    problem: &Problem<N, S>,
    swept: &[Swept<Problem<N, S>>],
    target: f64,
    rounds: u16,
) -> Cell {
    let [ours, peer] = [true, false].map(|side| finalists(swept, target, side));
    let mut finalists: Vec<Finalist<Problem<N, S>>> = ours.into_iter().chain(peer).collect();
    for _ in 0..rounds {
        finalists.iter_mut().for_each(|finalist| finalist.take_times(problem));
    }
    let best = |side: bool| {
        let costs = finalists
            .iter()
            .filter(|finalist| finalist.is_ours == side)
            .map(|finalist| Cost { solver: finalist.solver.name(), seconds: finalist.bracket().seconds(target) });
        costs.min_by(|a, b| a.seconds.total_cmp(&b.seconds))
    };
    Cell { error: target, ours: best(true), peer: best(false) }
}

/// A solver that may be the fastest of its side, and the times of the two runs that decide.
struct Finalist<'a, P> {
    solver: &'a dyn Solver<P>,
    is_ours: bool,
    swept: Bracket,
    coarse: Vec<f64>,
    fine: Vec<f64>,
}

impl<P> Finalist<'_, P> {
    fn take_times(&mut self, problem: &P) {
        let take = |point: Point| {
            let repeats = (LONG_ENOUGH / point.seconds).max(1.0).ceil();
            repeated(repeats, || self.solver.run(problem, point.setting))
        };
        self.coarse.extend(self.swept.coarse.map(take));
        self.fine.push(take(self.swept.fine));
    }

    /// The bracket with the medians of its times.
    fn bracket(&self) -> Bracket {
        let coarse = self.swept.coarse.map(|point| Point { seconds: median(&self.coarse), ..point });
        Bracket { coarse, fine: Point { seconds: median(&self.fine), ..self.swept.fine } }
    }
}

/// The solvers of one side that are close to its fastest at the error `target`.
fn finalists<'a, P>(swept: &[Swept<'a, P>], target: f64, is_ours: bool) -> Vec<Finalist<'a, P>> {
    let side = swept.iter().filter(|swept| swept.is_ours == is_ours);
    let reached: Vec<(&'a dyn Solver<P>, Bracket)> =
        side.filter_map(|swept| Some((swept.solver, Bracket::of(&swept.points, target)?))).collect();
    let fastest = reached.iter().map(|(_, bracket)| bracket.seconds(target)).fold(f64::INFINITY, f64::min);
    let close = reached.into_iter().filter(|(_, bracket)| bracket.seconds(target) <= CLOSE * fastest);
    close.map(|(solver, swept)| Finalist { solver, is_ours, swept, coarse: Vec::new(), fine: Vec::new() }).collect()
}

fn median(times: &[f64]) -> f64 {
    let mut sorted = times.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}
