//! Rows of a run beside solvers that choose their steps: runs with h and h/2 agree on what both of them miss.

use std::sync::atomic::{AtomicU64, Ordering};

use lsvi::StepError;
use lsvi::adaptive::Tolerances;
use verify::kinds::Principle;
use verify::measure::norm::{Extremes, larger};
use verify::method::{self, Method};
use verify::problem::{Problem, component_names};
use verify::reference::{self, InUnits, Ode};
use verify::run::{RunError, run_between, run_through};

use super::beware::BEYOND;
use super::equation::{COURSE, DENSE};
use super::units::unlike;
use crate::cli::layout::{number, plain};

/// Rows that are looked at: from half as many up to so many of a long run, and the last.
const ROWS: usize = 128;

/// Part of the run on either side of a row within which the largest estimate is that of the row: one alone passes zero where a run and its
/// finer one cross.
const NEARBY: f64 = 1.0 / 16.0;

/// A row is looked at in the place of the one that follows if the run comes to it by so many times as large a step.
const LEAPS: f64 = 2.0;

/// Errors this many times the largest estimate are told though more than three digits are right.
const GROSS: f64 = 100.0;

/// Part of the largest value of a component that an error comes to where fewer than three digits are right.
const THREE_DIGITS: f64 = 1e-3;

/// Part of what a row is off by to which the two solvers agree on it: those of a chaotic solution part as rows do.
const AGREE: f64 = 0.1;

/// Errors of a solver are sums of what it allows in a step, which tolerance times this is well beyond.
const SUMS: f64 = 1e3;

/// Part of its largest value that a component's unit is at least.
const LITTLE: f64 = 1e-30;

/// What the run that confirms is held to: three digits are asked for.
const HELD: f64 = 1e-9;

/// Times that differ by this part of the run are one.
const RESOLVED: f64 = 1e-9;

/// Parts of a run of which the rows are looked at: the first that the reference comes to the end of.
const FIRST: [f64; 3] = [1.0, 1.0 / 8.0, 1.0 / 128.0];

/// Evaluations of f that the reference may take, and steps of the method that confirms it: tenths of a second of a small system.
const EVALUATIONS: u64 = 100_000;
const STEPS: u64 = 40_000;
/// A method that comes to nine tenths of where it ended in this part of its steps ended for what is there, and not for the length of the run.
const EARLY: u64 = 10;
/// Steps of that method for each of the equal parts of a run at whose ends it stops, where a reference was lost: stops are not what takes its steps.
const OF_A_STOP: u64 = 40;

/// Largest model whose solution is cheap enough.
pub(super) const MOST: usize = 256;

/// What a solver may take of evaluations or steps, of a system of `n` unknowns, whose factors cost n³.
fn affordable(count: u64, n: usize) -> u64 {
    let times = n.div_ceil(DENSE).max(1) as u64;
    count / times.pow(3)
}

/// Follows a run.
#[derive(Debug)]
pub(super) struct Beside {
    /// One of every so many rows from the start, without it.
    rows: Vec<Row>,
    every: usize,
    /// One of those since then.
    group: Option<Row>,
    last: Row,
    /// The longest step.
    longest: f64,
    count: usize,
    /// The largest value of each component so far.
    sizes: Vec<f64>,
}

#[derive(Debug, Clone, Default)]
struct Row {
    t: f64,
    /// Components.
    values: Vec<f64>,
    /// The largest estimate of the rows that it stands for, infinite where there is none.
    estimate: f64,
    /// The largest part of its size so far by which a component has moved since the row before.
    moved: f64,
}

impl Row {
    /// The one of two to be looked at: the later one, but for one behind which f acted in the step that leads to it alone.
    fn or(self, later: Self) -> Self {
        let estimate = larger(self.estimate, later.estimate);
        Self { estimate, ..if self.moved > LEAPS * later.moved { self } else { later } }
    }
}

impl Default for Beside {
    fn default() -> Self {
        let (rows, group, last, longest, sizes) = Default::default();
        Self { rows, every: 1, group, last, longest, count: 0, sizes }
    }
}

impl Beside {
    /// The next row of a run.
    pub(super) fn add(&mut self, t: f64, values: &[f64], estimate: Option<f64>) {
        if values.len() > MOST {
            return;
        }
        self.sizes.resize(values.len(), 0.0);
        self.sizes.iter_mut().zip(values).for_each(|(size, x)| *size = larger(*size, x.abs()));
        let part = |(size, (a, b)): (&f64, (&f64, &f64))| if *size > 0.0 { (b - a).abs() / size } else { 0.0 };
        let moved = self.sizes.iter().zip(self.last.values.iter().zip(values)).map(part).fold(0.0, larger);
        self.longest = larger(self.longest, t - self.last.t);
        self.last = Row { t, values: values.to_vec(), estimate: estimate.unwrap_or(f64::INFINITY), moved };
        if t == 0.0 {
            return;
        }
        self.count += 1;
        let of_group = match self.group.take() {
            Some(row) => row.or(self.last.clone()),
            None => self.last.clone(),
        };
        if !self.count.is_multiple_of(self.every) {
            self.group = Some(of_group);
            return;
        }
        self.rows.push(of_group);
        if self.rows.len() > ROWS {
            self.every *= 2;
            let mut rows = std::mem::take(&mut self.rows).into_iter();
            while let Some(row) = rows.next() {
                match rows.next() {
                    Some(later) => self.rows.push(row.or(later)),
                    // Of an odd number the last goes to the row that follows.
                    None => self.group = Some(row),
                }
            }
        }
    }

    /// The rows that are looked at.
    fn rows(&self) -> impl Iterator<Item = &Row> {
        let shown = self.group.as_ref().or(self.rows.last());
        let is_shown = self.count == 0 || shown.is_some_and(|row| row.t == self.last.t);
        self.rows.iter().chain(&self.group).chain((!is_shown).then_some(&self.last))
    }

    /// The largest estimate near a row, those beside it included.
    fn estimate(&self, place: usize) -> f64 {
        self.largest_near(place, |_| true)
    }

    /// The largest estimate near a row of those that count.
    fn largest_near(&self, place: usize, counts: impl Fn(f64) -> bool) -> f64 {
        let (near, t) = (NEARBY * self.last.t, self.rows().nth(place).map_or(f64::NAN, |row| row.t));
        let is_near = |(k, row): &(usize, &Row)| k.abs_diff(place) <= 1 || (row.t - t).abs() <= near;
        let near = self.rows().enumerate().filter(is_near).map(|(_, row)| row.estimate);
        near.filter(|estimate| counts(*estimate)).fold(0.0, larger)
    }

    /// The largest of the estimates near a row that has one itself; none is right where there is none. Beside it there may be none where an adaptive
    /// method takes the same steps for both tolerances, as along a solution that rests until f jumps.
    fn known_estimate(&self, place: usize, row: &Row) -> f64 {
        if row.estimate.is_finite() { self.largest_near(place, f64::is_finite) } else { 0.0 }
    }

    /// The largest value of each component, of the rows and of `states`.
    fn sizes(&self, states: &[Vec<f64>]) -> Vec<f64> {
        states.iter().chain(self.rows().map(|row| &row.values)).fold(Vec::new(), |mut sizes, values| {
            sizes.resize(values.len(), 0.0);
            sizes.iter_mut().zip(values).for_each(|(size, x)| *size = larger(*size, x.abs()));
            sizes
        })
    }

    /// The unit of each component of the state: what it starts from, or the largest value of one that starts at 0. What grows from little
    /// is of no size beside the others at first.
    fn units(&self, start: &[f64]) -> Vec<f64> {
        let sizes = Some(self.sizes(&[])).filter(|sizes| sizes.len() == start.len());
        let size = |k: usize| sizes.as_ref().map_or(1.0, |sizes| sizes[k]);
        let unit = |(k, x): (usize, &f64)| if *x == 0.0 { size(k) } else { x.abs().max(LITTLE * size(k)) };
        start.iter().enumerate().map(unit).map(|unit| if unit.is_normal() { unit } else { 1.0 }).collect()
    }

    /// Whether an accurate run that stops at the `places` too, and passes over none of them, comes to all rows that are looked at, within
    /// the estimates near them or to three digits, and at the places is no further from the rows than they are from each other.
    pub(super) fn is_met(&self, problem: &dyn Problem, places: &[f64]) -> bool {
        let times: Vec<f64> = self.rows().map(|row| row.t).collect();
        let mut stops: Vec<(f64, bool)> =
            times.iter().map(|t| (*t, true)).chain(places.iter().map(|t| (*t, false))).collect();
        stops.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        // A row that is a place as well is one stop.
        stops.dedup_by(|next, stop| !next.1 && next.0 - stop.0 <= RESOLVED * self.last.t);
        stops.retain(|(t, _)| *t > 0.0);
        let all: Vec<f64> = stops.iter().map(|(t, _)| *t).collect();
        let start = problem.initial();
        let Some(reached) = accurate(&self.units(&start), STEPS)
            .filter(|_| self.count > 0)
            .and_then(|it| run_through(problem, &*it, &all).ok())
        else {
            return false;
        };
        let observed = reached.iter().zip(&stops).map(|(state, (t, is_row))| (problem.observe(*t, state), *is_row));
        let (states, between): (Vec<_>, Vec<_>) = observed.partition(|(_, is_row)| *is_row);
        let states: Vec<Vec<f64>> = states.into_iter().map(|(state, _)| state).collect();
        let sizes = self.sizes(&states);
        let start = problem.observe(0.0, &start);
        let is_shown = |(k, x): (usize, &f64)| {
            let shown = || states.iter().chain([&start]).map(|state| state[k]);
            let (least, most) = (shown().smallest(), shown().largest());
            let far = (most - least).max(THREE_DIGITS * sizes[k]);
            (least - far..=most + far).contains(x)
        };
        if !between.iter().all(|(state, _)| state.iter().enumerate().all(is_shown)) {
            return false;
        }
        self.rows().zip(&states).enumerate().all(|(place, (row, state))| {
            let estimate = self.known_estimate(place, row);
            let is_near =
                |(k, (a, b)): (usize, (&f64, &f64))| (a - b).abs() <= (BEYOND * estimate).max(THREE_DIGITS * sizes[k]);
            row.values.iter().zip(state).enumerate().all(is_near)
        })
    }

    /// A row that is off by far more than the estimates near it, as a reference tells and another solver confirms: the one may have passed
    /// over what f does for a moment, or be at its end, but hardly both and with the same result.
    pub(super) fn told(&self, problem: &dyn Problem, method: &dyn Method) -> Option<String> {
        let limit = problem.limit(method.principle());
        let is_equation = limit.name == problem.limit(Principle::Equation).name;
        let most = if problem.facts().model.is_some() { MOST } else { DENSE };
        if !is_equation || limit.ode.dim() > most || self.count == 0 {
            return None;
        }
        let units = self.units(&limit.initial);
        let reference = reference::by_name("diffsol-bdf")?;
        let mut is_lost = false;
        // Of a run that is too long to be followed, or beyond the end of its solution, the first rows.
        let solved = FIRST.into_iter().find_map(|part| {
            let times: Vec<f64> = self.rows().map(|row| row.t).filter(|t| *t <= part * self.last.t).collect();
            let limited = Limited { ode: limit.ode, left: AtomicU64::new(affordable(EVALUATIONS, units.len())) };
            let ode = InUnits::new(&limited, &units);
            let solved = reference.run(&ode, 0.0, &ode.in_units(&limit.initial), &times, COURSE);
            is_lost |= solved.is_err();
            Some((times, solved.ok()?.states.iter().map(|state| ode.states(state)).collect::<Vec<_>>()))
        });
        let off = solved.and_then(|solved| self.off(problem, method, &units, solved));
        off.or_else(|| is_lost.then(|| self.unfollowed(problem, &units)).flatten())
    }

    /// That no solver with steps of its own comes to the end, for another reason than that it would take too many of them all the way.
    fn unfollowed(&self, problem: &dyn Problem, units: &[f64]) -> Option<String> {
        // With stops on the way, or it may leap over what stopped the reference.
        let count = affordable(STEPS, units.len()) / OF_A_STOP;
        let stops: Vec<f64> = (1..=count).map(|k| k as f64 / count as f64 * self.last.t).collect();
        let error = run_through(problem, &*accurate(units, STEPS)?, &stops).err()?;
        let is_told = match error {
            RunError::Step(StepError::TooManySteps { t, .. }) => {
                run_through(problem, &*accurate(units, STEPS / EARLY)?, &[0.9 * t]).is_ok()
            }
            _ => true,
        };
        is_told.then(|| {
            format!(
                "neither of two solvers that choose their steps follows the equation to t = {}, one because {error}: nothing tells whether the rows from \
                 there on are right",
                plain(self.last.t)
            )
        })
    }

    /// The row that is off by most, as the states of a reference at these times have it and another solver confirms.
    fn off(
        &self,
        problem: &dyn Problem,
        method: &dyn Method,
        units: &[f64],
        (times, states): (Vec<f64>, Vec<Vec<f64>>),
    ) -> Option<String> {
        let limit = problem.limit(method.principle());
        let observed = |(t, state): (&f64, &Vec<f64>)| problem.observe(*t, state);
        let known: Vec<Vec<f64>> = times.iter().zip(&states).map(observed).collect();
        let sizes = self.sizes(&known);
        // Errors of solvers are of the unit, where a component is one of the state.
        let sums = |k: usize| SUMS * COURSE * if units.len() == sizes.len() { units[k] } else { 1.0 };
        let largest = self.rows().map(|row| row.estimate).fold(0.0, larger);
        let far = |place: usize, k: usize| {
            let told = (GROSS * largest).min(THREE_DIGITS * sizes[k]);
            (BEYOND * self.estimate(place)).max(told).max(sums(k))
        };
        let off = |place: usize, row: &Row, state: &[f64]| -> Vec<(usize, f64)> {
            let off = row.values.iter().zip(state).map(|(a, b)| (a - b).abs()).enumerate();
            off.filter(|(k, off)| *off > far(place, *k)).collect()
        };
        let rows = || self.rows().zip(&known).enumerate();
        let (last, _) = rows().filter(|(place, (row, state))| !off(*place, row, state).is_empty()).last()?;
        let end = times[last];
        let steps = [limit.ode.longest_step(end).min(end), end];
        let confirmed = run_between(problem, &*accurate(units, STEPS)?, steps, &times[..=last]).ok()?;
        let confirmed = times.iter().zip(&confirmed).map(observed);
        let (place, k, _) = rows()
            .zip(confirmed)
            .flat_map(|((place, (row, known)), state)| {
                let is_confirmed = |(k, off): &(usize, f64)| (known[*k] - state[*k]).abs() <= AGREE * off;
                off(place, row, &state)
                    .into_iter()
                    .filter(is_confirmed)
                    .map(|(k, off)| (place, k, off))
                    .collect::<Vec<_>>()
            })
            .max_by(|a, b| (a.2 / sizes[a.1]).total_cmp(&(b.2 / sizes[b.1])))?;
        let row = self.rows().nth(place)?;
        let [shared, smaller] = if method.traits().is_adaptive {
            ["a tenth of the tolerances", "smaller tolerances"]
        } else {
            ["half the step", "a much smaller `--h`"]
        };
        let remedy = unlike(problem, method, (0.0, &limit.initial), self.longest, k)
            .unwrap_or_else(|| format!("{smaller}, or another method, tells"));
        Some(format!(
            "at t = {} {} is {}, and {} by two solvers that choose their steps: the error is larger than the estimates near there, of {} at most, which do not \
             know of what the run with {shared} misses as well; {remedy}",
            plain(row.t),
            component_names(problem)[k],
            number(row.values[k]),
            number(known[place][k]),
            number(self.estimate(place))
        ))
    }
}

/// An adaptive method whose errors, across kinks too, are well below those that are told, and which takes no longer than they are
/// worth: in units of the components.
fn accurate(units: &[f64], steps: u64) -> Option<Box<dyn Method>> {
    let steps = affordable(steps, units.len());
    let atol = units.iter().map(|unit| HELD * unit).collect();
    let tolerances = Tolerances::new(HELD, 0.0).and_then(|t| t.with_atol(atol)).ok()?.strict();
    method::parse("radau-adaptive").ok()?.limited(steps)?.with_tolerances(tolerances)
}

/// An equation whose f is finite for so many evaluations.
struct Limited<'a> {
    ode: &'a dyn Ode,
    left: AtomicU64,
}

impl Ode for Limited<'_> {
    fn dim(&self) -> usize {
        self.ode.dim()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        let left = self.left.load(Ordering::Relaxed);
        self.left.store(left.saturating_sub(1), Ordering::Relaxed);
        if left > 0 { self.ode.rhs(t, v, dv) } else { dv.fill(f64::NAN) }
    }
    fn jacobian(&self, t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        self.ode.jacobian(t, v, add);
    }
    fn bandwidths(&self) -> Option<(usize, usize)> {
        self.ode.bandwidths()
    }
    fn is_sparse(&self) -> bool {
        self.ode.is_sparse()
    }
    fn longest_step(&self, span: f64) -> f64 {
        self.ode.longest_step(span)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 1000 rows at equal speed every eighth, 125, which is the last too; of 1003 the last besides.
    #[test]
    fn a_large_system_may_cost_as_much_as_a_small_one() {
        let counts = [1, DENSE, DENSE + 1, 2 * DENSE, MOST].map(|n| affordable(EVALUATIONS, n));
        assert_eq!(counts, [1, 1, 8, 8, 64].map(|times| EVALUATIONS / times));
    }

    #[test]
    fn rows_are_those_at_equal_distances_and_the_last() {
        for (count, every, shown) in [(5, 1, 5), (128, 1, 128), (129, 2, 65), (1000, 8, 125), (1003, 8, 126)] {
            let mut beside = Beside::default();
            (0..=count).for_each(|k| beside.add(k as f64, &[k as f64], Some(0.0)));
            let times: Vec<f64> = beside.rows().map(|row| row.t).collect();
            assert_eq!((times.len(), times[0], times.last()), (shown, f64::from(every), Some(&(count as f64))));
            assert!(times.is_sorted() && beside.rows().all(|row| row.t == row.values[0]), "{count}: {times:?}");
        }
    }

    /// x leaps by one in the step to each hundredth row and rests on its way, so that all of these are shown, beside what goes by thousandths of its
    /// size.
    #[test]
    fn a_row_that_a_leap_leads_to_is_shown() {
        let mut beside = Beside::default();
        (0..=1000).for_each(|k| beside.add(f64::from(k), &[f64::from((k + 37) / 100), f64::from(1000 + k)], Some(0.0)));
        let times: Vec<f64> = beside.rows().map(|row| row.t).collect();
        assert!((0..10).all(|leap| times.contains(&(63.0 + 100.0 * f64::from(leap)))), "{times:?}");
        assert!(times.is_sorted() && times.len() == 125 && times.last() == Some(&1000.0), "{times:?}");
    }

    /// A sixteenth of the run is 8 rows of 128, and 9 of 129 of which every other one is kept; one without an estimate has an infinite one.
    #[test]
    fn an_estimate_is_the_largest_near_a_row() {
        for (count, of) in [(128, 64), (129, 63), (1000, 500), (1000, 501), (1000, 129)] {
            let mut beside = Beside::default();
            (1..=count).for_each(|k| beside.add(f64::from(k), &[0.0], Some(if k == of { 1.0 } else { 1e-3 })));
            let near = f64::from(count) / 16.0;
            for (t, largest) in [(0.8 * near, 1.0), (-0.8 * near, 1.0), (1.3 * near, 1e-3), (-1.3 * near, 1e-3)] {
                let t = f64::from(of) + t;
                let place = beside.rows().position(|row| row.t >= t).expect("within the run");
                assert_eq!(beside.estimate(place), largest, "{count}, {of}: {t}");
            }
        }
        let mut beside = Beside::default();
        [Some(1.0), None]
            .into_iter()
            .enumerate()
            .for_each(|(k, estimate)| beside.add(1.0 + k as f64, &[0.0], estimate));
        beside.add(3.0, &[0.0], Some(1.0));
        beside.add(4.0, &[0.0], Some(2.0));
        let estimates = [0, 1, 2, 3].map(|place| beside.estimate(place));
        assert_eq!(estimates, [f64::INFINITY, f64::INFINITY, f64::INFINITY, 2.0]);
        let known: Vec<f64> = beside.rows().enumerate().map(|(place, row)| beside.known_estimate(place, row)).collect();
        assert_eq!(known, [1.0, 0.0, 2.0, 2.0]);
    }

    /// √v has no derivative at 0, where v = (1 − t/2)² comes to rest at t = 2; before that, and of v = 1 + t, nothing is said. Between −1 and 1 no step
    /// ends from t = 1 on, where v = 2 is to be kept, by however many of them.
    #[test]
    fn an_equation_that_no_solver_follows_to_the_end_is_told() {
        let method = method::parse("rk4").expect("registered");
        let told = |f: &str, ends: &[f64]| {
            let model = verify::problem::model::Model::of_text(&format!("u_i {{ v = 1 }} F_i {{ {f} }}"), &[], None)
                .expect("a model");
            let mut beside = Beside::default();
            let v = |t: f64| if f == "1" { 1.0 + t } else { (1.0 - 0.5 * t).max(0.0).powi(2) };
            ends.iter().for_each(|end| beside.add(*end, &[v(*end)], Some(1e-9)));
            beside.told(&model, &*method).unwrap_or_default()
        };
        let lost = told("-sqrt(max(v, 0))", &[1.0, 3.0]);
        assert!(lost.starts_with("neither of two solvers") && lost.contains("to t = 3, one because"), "{lost}");
        assert_eq!([told("-sqrt(max(v, 0))", &[0.5, 1.0]), told("1", &[1.0, 3.0])], ["", ""]);
        let held = told("1 - 2 * heaviside(v - 2) * heaviside(2.02 - v)", &[0.5, 3.0]);
        assert!(held.contains("to t = 3, one because") && held.contains("all of the 40000 steps"), "{held}");
        // Nor where f is −1 from there on, over which no step leaps.
        let wall = told("1 - 2 * heaviside(v - 2)", &[0.5, 3.0]);
        assert!(wall.contains("all of the 40000 steps"), "{wall}");
    }

    /// Of a long oscillation to ten digits.
    #[test]
    fn a_reference_that_takes_too_many_evaluations_says_nothing_but_of_the_first_rows() {
        let problem = verify::problem::build("harmonic-oscillator", &[]).expect("registered");
        let method = method::parse("implicit-euler").expect("registered");
        let told = |ends: &[f64]| {
            let mut beside = Beside::default();
            ends.iter().for_each(|end| beside.add(*end, &[2.0, 2.0], Some(1e-3)));
            beside.told(&*problem, &*method).unwrap_or_default()
        };
        assert!(told(&[10.0]).starts_with("at t = 10 ") && told(&[1e5]).is_empty());
        // Of the first 128th part it says what there is.
        assert!(told(&[10.0, 1e5]).starts_with("at t = 10 "), "{}", told(&[10.0, 1e5]));
    }

    #[test]
    fn a_limited_equation_has_no_f_after_its_last_evaluation() {
        let problem = verify::problem::build("harmonic-oscillator", &[]).expect("registered");
        let ode = Limited { ode: problem.ode(), left: AtomicU64::new(2) };
        let mut f = [0.0; 2];
        for is_left in [true, true, false, false] {
            ode.rhs(0.0, &[1.0, 1.0], &mut f);
            assert_eq!(f.iter().all(|x| x.is_finite()), is_left);
        }
    }

    /// What is said of one row that is `off` by so much.
    fn told(setting: &str, (t, off): (f64, &[f64]), method: &str, estimate: f64) -> Option<String> {
        let problem = verify::problem::build_setting(setting).expect("registered");
        let method = method::parse(method).expect("registered");
        let exact = problem.exact(t).expect("it is known");
        let values: Vec<f64> = exact.iter().zip(off).map(|(x, off)| x + off).collect();
        let mut beside = Beside::default();
        beside.add(t, &values, Some(estimate));
        beside.told(&*problem, &*method)
    }

    /// At t = 10 cos t + sin t = −1.38. The errors of solvers on what is about 10⁻⁸ are no part of it that counts.
    #[test]
    fn an_error_is_told_beyond_the_estimate_and_what_solvers_have_and_three_digits_or_where_it_is_gross() {
        let oscillator = "harmonic-oscillator";
        for (setting, t, off, estimate, is_told) in [
            (oscillator, 10.0, 5e-4, 6e-6, false),
            (oscillator, 10.0, -5e-4, 6e-6, false),
            (oscillator, 10.0, 5e-4, 4e-6, true),
            (oscillator, 10.0, 1e-8, 0.0, false),
            (oscillator, 10.0, 2e-3, 0.0, true),
            (oscillator, 10.0, -2e-3, 0.0, true),
            (oscillator, 10.0, 0.1, 0.034, false),
            (oscillator, 10.0, 0.1, 0.032, true),
            // Three digits of 0.003 68 are no hundred estimates.
            ("linear-drag v0=0.01", 1.0, 5e-6, 1e-6, true),
            ("linear-drag v0=0.01", 1.0, 3.5e-6, 1e-6, false),
            ("linear-drag v0=1e-8", 1.0, 5e-16, 0.0, false),
            ("linear-drag v0=1e-8", 1.0, 1e-10, 0.0, true),
        ] {
            let found = told(setting, (t, &[off, 0.0]), "implicit-euler", estimate);
            assert_eq!(found.is_some(), is_told, "{setting}, {off:e} beside {estimate:e}: {found:?}");
        }
    }

    /// Of q = −1.38 and p = −0.30 the one is −100, which is off by that, and the other 0.30, which is off by twice what it is.
    #[test]
    fn the_error_that_is_told_is_the_largest_part_of_its_component() {
        let found =
            told("harmonic-oscillator", (10.0, &[-98.6, 0.6]), "implicit-euler", 0.0).expect("both are far off");
        assert!(found.starts_with("at t = 10 p is "), "{found}");
        assert!(found.contains("with half the step") && found.contains("; a much smaller `--h`"), "{found}");
        let adaptive = told("harmonic-oscillator", (10.0, &[0.5, 0.0]), "radau-adaptive", 0.0).expect("it is far off");
        assert!(adaptive.starts_with("at t = 10 q is "), "{adaptive}");
        assert!(
            adaptive.contains("with a tenth of the tolerances") && adaptive.contains("; smaller tolerances"),
            "{adaptive}"
        );
    }

    #[test]
    fn the_estimate_that_is_told_is_that_near_the_row() {
        let problem = verify::problem::build("harmonic-oscillator", &[]).expect("registered");
        let mut beside = Beside::default();
        for (t, off, estimate) in [(5.0, 0.5, 1e-3), (7.5, 0.0, 1e-3), (10.0, 0.0, 2e-3)] {
            let mut values = problem.exact(t).expect("it is known");
            values[0] += off;
            beside.add(t, &values, Some(estimate));
        }
        let method = method::parse("implicit-euler").expect("registered");
        let found = beside.told(&*problem, &*method).expect("it is off");
        assert!(
            found.starts_with("at t = 5 q is ") && found.contains(&format!(", of {} at most", number(1e-3))),
            "{found}"
        );
    }

    /// Method I approaches another equation there, which no other solver is asked about.
    #[test]
    fn a_method_that_approaches_another_equation_is_not_told() {
        let problem = verify::problem::build("poiseuille-ansatz", &[]).expect("registered");
        for (method, is_told) in [("method-i", false), ("implicit-euler", true)] {
            let method = method::parse(method).expect("registered");
            let mut beside = Beside::default();
            beside.add(1.0, &[10.0], Some(1e-3));
            assert_eq!(beside.told(&*problem, &*method).is_some(), is_told, "{}", method.name());
        }
    }

    /// v̇ = 50 for t from 0.5 to 0.52, as the reference has it; the methods have this part of it.
    #[derive(Debug)]
    struct Moment {
        part: f64,
    }

    impl Moment {
        fn push(t: f64) -> f64 {
            if (0.5..0.52).contains(&t) { 50.0 } else { 0.0 }
        }
    }

    impl lsvi::FieldFn for Moment {
        fn dim(&self) -> usize {
            1
        }
        fn rhs<T: lsvi::Scalar>(&self, t: f64, _v: &[T], dv: &mut [T]) {
            dv[0] = T::from(self.part * Self::push(t));
        }
    }

    impl Ode for Moment {
        fn dim(&self) -> usize {
            1
        }
        fn rhs(&self, t: f64, _v: &[f64], dv: &mut [f64]) {
            dv[0] = Self::push(t);
        }
        fn jacobian(&self, _t: f64, _v: &[f64], _add: &mut dyn FnMut(usize, usize, f64)) {}
        fn longest_step(&self, span: f64) -> f64 {
            0.01 * span
        }
    }

    impl Problem for Moment {
        fn components(&self) -> &'static [&'static str] {
            &["v"]
        }
        fn initial(&self) -> Vec<f64> {
            vec![0.0]
        }
        fn field(&self) -> Box<dyn lsvi::VectorField + '_> {
            Box::new(lsvi::AutoField::new(self))
        }
        fn ode(&self) -> &dyn Ode {
            self
        }
        fn exact(&self, _t: f64) -> Option<Vec<f64>> {
            None
        }
    }

    /// A run that passes over the moment ends at 0. The solver that confirms passes over none, and where it ends there too, or elsewhere than
    /// the reference by more than a tenth of what the run is off by, nothing is said.
    #[test]
    fn what_one_solver_alone_tells_is_not_told() {
        let method = method::parse("implicit-euler").expect("registered");
        for (part, is_told) in [(1.0, true), (0.92, true), (0.9, false), (0.6, false), (0.0, false)] {
            let mut beside = Beside::default();
            beside.add(1.0, &[0.0], Some(0.0));
            let found = beside.told(&Moment { part }, &*method);
            assert_eq!(found.is_some(), is_told, "{part}: {found:?}");
        }
    }

    /// Of a row that is off by a tenth, within the estimate or without one; and of one at t = 1 that has passed over what v moves by, which the
    /// other run sees where it stops there.
    #[test]
    fn rows_are_met_by_a_run_that_passes_over_nothing() {
        let oscillator = verify::problem::build("harmonic-oscillator", &[]).expect("registered");
        for (off, estimate, is_met) in
            [(0.1, Some(0.034), true), (0.1, Some(0.032), false), (5e-4, None, true), (5e-3, None, false)]
        {
            let mut values = oscillator.exact(10.0).expect("it is known");
            values[0] += off;
            let mut beside = Beside::default();
            beside.add(10.0, &values, estimate);
            assert_eq!(beside.is_met(&*oscillator, &[3.0, 10.0]), is_met, "{off} beside {estimate:?}");
        }
        // To three digits of what it is, in its unit.
        for (v0, off, is_met) in [(1e-2, 5e-4, true), (1e-2, 2e-3, false), (1e-8, 5e-4, true), (1e-8, 2e-3, false)] {
            let drag = verify::problem::build_setting(&format!("linear-drag v0={v0}")).expect("registered");
            let mut beside = Beside::default();
            beside.add(8.0, &[v0 * (-8.0_f64).exp() * (1.0 + off)], Some(0.0));
            assert_eq!(beside.is_met(&*drag, &[]), is_met, "{v0}, {off}");
        }
        // Of a row at its start again, between which it moves.
        let mut beside = Beside::default();
        beside.add(std::f64::consts::TAU, &[1.0, 1.0], Some(0.0));
        assert!(!beside.is_met(&*oscillator, &[0.5]) && beside.is_met(&*oscillator, &[]));
        assert!(!Beside::default().is_met(&*oscillator, &[]), "there is no row");
        // The start is no place on the way.
        let mut beside = Beside::default();
        beside.add(10.0, &oscillator.exact(10.0).expect("it is known"), Some(0.0));
        assert!(beside.is_met(&*oscillator, &[0.0, 3.0]));
        // A place that is a rounding behind a row, of a long run.
        let mut beside = Beside::default();
        beside.add(1e4, &[0.0], Some(0.0));
        assert!(beside.is_met(&Moment { part: 0.0 }, &[1e4_f64.next_up()]));
        let mut beside = Beside::default();
        beside.add(1.0, &[0.0], Some(0.0));
        assert!(!beside.is_met(&Moment { part: 1.0 }, &[0.51]));
        assert!(beside.is_met(&Moment { part: 0.0 }, &[0.51]));
    }

    #[test]
    fn rows_of_systems_that_are_too_large_are_not_kept() {
        let kept = |n: usize| {
            let mut beside = Beside::default();
            [0.0, 1.0].iter().for_each(|t| beside.add(*t, &vec![1.0; n], None));
            beside.rows().count()
        };
        assert_eq!([MOST, MOST + 1].map(kept), [1, 0]);
    }

    #[test]
    fn the_longest_step_is_the_largest_distance_of_rows() {
        let mut beside = Beside::default();
        [0.0, 1.0, 4.0, 4.5].iter().for_each(|t| beside.add(*t, &[0.0], None));
        assert_eq!(beside.longest, 3.0);
    }

    /// A component that starts at 0 has the size of its rows as its unit, where the rows are of the state.
    #[test]
    fn units_are_those_of_the_start_or_of_what_becomes_of_it() {
        let mut beside = Beside::default();
        [2.0, 7.0, 5.0].iter().zip(1..).for_each(|(v, t)| beside.add(f64::from(t), &[5.0, -v, 3.0, 0.0], None));
        assert_eq!(beside.units(&[-2.0, 0.0, 1e-40, 0.0]), [2.0, 7.0, 3.0 * LITTLE, 1.0]);
        assert_eq!(beside.units(&[-2.0, 0.0]), [2.0, 1.0]);
    }

    /// Of a channel of 20 points a solver tells; one of more unknowns than 64 has dear derivatives.
    #[test]
    fn of_a_large_problem_no_other_solver_is_asked() {
        let method = method::parse("implicit-euler").expect("registered");
        let is_told = |setting: &str| {
            let problem = verify::problem::build_setting(setting).expect("registered");
            let off: Vec<f64> = problem.observe(0.0, &problem.initial()).iter().map(|x| x + 1.0).collect();
            let mut beside = Beside::default();
            beside.add(1e-3, &off, Some(0.0));
            (problem.ode().dim() > DENSE, beside.told(&*problem, &*method).is_some())
        };
        let found = ["channel-couette cells=20", "channel-couette cells=80"].map(is_told);
        assert_eq!(found, [(false, true), (true, false)]);
    }

    /// ẋ_k = −x_k with a band that it does not need.
    struct Banded;

    impl Ode for Banded {
        fn dim(&self) -> usize {
            4
        }
        fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
            dv.iter_mut().zip(v).for_each(|(dv, v)| *dv = -v);
        }
        fn jacobian(&self, _t: f64, _v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
            (0..4).for_each(|k| add(k, k, -1.0));
        }
        fn bandwidths(&self) -> Option<(usize, usize)> {
            Some((2, 1))
        }
        fn is_sparse(&self) -> bool {
            false
        }
    }

    #[test]
    fn a_limited_equation_has_the_structure_of_its_equation() {
        let limited = Limited { ode: &Banded, left: AtomicU64::new(1) };
        assert_eq!((limited.bandwidths(), limited.is_sparse()), (Some((2, 1)), false));
    }
}
