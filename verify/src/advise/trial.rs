//! Trial runs, and what they cost.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::f64::consts::SQRT_2;
use std::ops::ControlFlow;
use std::rc::Rc;

use lsvi::{SolveError, StepError, Structure, Work};
use nalgebra::DMatrix;

use super::{Held, adaptive_within, worst};
use crate::experiment::growth;
use crate::kinds::{Principle, Stability};
use crate::measure::norm::{Extremes, common_distance, distance, larger, max_norm};
use crate::method::{self, Method};
use crate::names::NameError;
use crate::problem::Problem;
use crate::problem::changes::{GOLDEN, acts_between, changes};
use crate::reference::Reference;
use crate::reference::bound::InUnits;
use crate::run::{RunError, run_between, run_from, run_through, run_while};

/// A run that reaches the accuracy.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// The method.
    pub method: String,
    /// Its step size, or relative tolerance.
    pub setting: f64,
    /// The absolute tolerances of an adaptive method, one for all components or one for each.
    pub atol: Option<Vec<f64>>,
    /// The longest step that an adaptive method may take, where that is shorter than the run.
    pub longest: Option<f64>,
    /// Whether its estimates were held to the tolerances themselves.
    pub is_strict: bool,
    /// Its steps.
    pub steps: u64,
    /// Its largest error at the times below.
    pub error: f64,
    /// The ends of its steps that are looked at, and those between where f changes by itself.
    pub times: Vec<f64>,
    /// Its work in evaluations of f.
    pub cost: f64,
    /// How the errors fall here; none for an adaptive method, or one that is exact here.
    pub falls: Option<Falls>,
}

/// The errors of a method with a number of steps and with twice as many, and its nominal order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Falls {
    /// The two errors.
    pub errors: [f64; 2],
    /// The order.
    pub nominal: u32,
}

impl Falls {
    /// The order found, where the errors fall so slowly that those of other steps cannot be told, as far as they are known to within
    /// `uncertainty`.
    fn unpredictable(self, uncertainty: f64) -> Option<f64> {
        let [error, finer] = self.errors;
        let most = ((error + uncertainty) / (finer - uncertainty).max(0.0)).log2();
        // NaN is no order.
        (most.is_nan() || most < f64::from(self.nominal) - 0.5).then(|| (error / finer).log2())
    }
}

impl Trial {
    /// The method as it was run.
    ///
    /// # Errors
    /// [`NameError`] if it is none of the registered ones.
    pub fn built(&self) -> Result<Box<dyn Method>, NameError> {
        let adaptive = |atol: &Vec<f64>| adaptive_within((self.setting, atol), self.is_strict);
        self.atol.as_ref().map_or_else(|| method::parse(&self.method), adaptive)
    }

    /// The order found and the nominal one, where no error can be told from those that are known to within `uncertainty`.
    pub fn unpredictable(&self, uncertainty: f64) -> Option<(f64, u32)> {
        self.falls.and_then(|falls| Some((falls.unpredictable(uncertainty)?, falls.nominal)))
    }
}

/// Steps of the coarsest and finest trial.
const LEAST: u32 = 4;
pub(super) const MOST: u32 = 1 << 14;

/// Errors are measured at the ends of all steps, and of this many at least where a system is so large that its Jacobian at more of them
/// would have more than so many values: each is the end of a step of the accurate run, too.
pub(super) const TIMES: usize = 64;
const VALUES: usize = 1 << 18;

/// Steps of the run at whose times the size of the solution and its motion are told: many to each of the [`TIMES`].
const FINE: u32 = 1 << 10;

/// Places one after another at which f acts for a moment.
const PLACES: u32 = 8;

/// A factor by which a step multiplies that differs from 1 by less is 1 but for rounding.
const SAME: f64 = 1e-9;

/// Parts of the run in each of which a component has a size of its own: of two turns of a motion each is an eighth of a turn, in which what
/// passes zero comes to sin(π/8) of its amplitude at least.
const PARTS: usize = 16;

/// Times that differ by this part of the horizon are one.
const RESOLVED: f64 = 1e-9;

/// How many times of a run of so many unknowns are looked at.
fn looked_at(unknowns: usize) -> usize {
    (VALUES / unknowns.max(1).pow(2)).max(TIMES)
}

/// The numbers of those of `count` steps at whose ends errors are measured: each, or one in each of `most` equal parts, the last of all
/// included. Where in its part is irregular, lest what is periodic shows one phase only.
pub(super) fn chosen(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (1..=count).collect();
    }
    let end = |part: usize| {
        let within = (part as f64 * GOLDEN).fract();
        let step = (count as f64 * (part as f64 - within) / most as f64).ceil();
        (step as usize).clamp(1, count)
    };
    let mut chosen: Vec<usize> = (1..most).map(end).chain([count]).collect();
    // Of few steps two parts may choose the same.
    chosen.dedup();
    chosen
}

/// An accurate solution at the chosen ends of the steps of runs, looked up by their number.
pub(super) struct Truth<'a> {
    problem: &'a dyn Problem,
    method: &'a dyn Method,
    horizon: f64,
    /// The least size that errors are relative to.
    unit: f64,
    /// How many times of a run it is known at.
    most: usize,
    /// When f changes by itself.
    changes: Vec<f64>,
    known: RefCell<BTreeMap<u32, Rc<Vec<Vec<f64>>>>>,
    /// The largest component of the runs that were made, and how far they went from their start.
    extent: Cell<(f64, f64)>,
    /// Where they end.
    ends: RefCell<Vec<Vec<f64>>>,
}

impl<'a> Truth<'a> {
    /// By an adaptive method.
    pub(super) fn by(
        problem: &'a dyn Problem,
        method: &'a dyn Method,
        horizon: f64,
        unit: f64,
    ) -> Result<Self, RunError> {
        let (known, extent, ends) = Default::default();
        let most = looked_at(problem.field().dim());
        let mut truth = Self { problem, method, horizon, unit, most, changes: Vec::new(), known, extent, ends };
        truth.changes = changes(problem, horizon, &truth.stops());
        truth.of_steps(FINE)?;
        truth.look_between()?;
        Ok(truth)
    }

    /// Follows the solution anew, with stops where f acts for a moment at some place: what it does there leads on to other places.
    fn look_between(&mut self) -> Result<(), RunError> {
        for _ in 0..PLACES {
            let times = [vec![0.0], self.ends_of(FINE)].concat();
            let states = [vec![self.problem.initial()], self.of_steps(FINE)?.to_vec()].concat();
            let is_known = |t: &f64| {
                let near = self.horizon / f64::from(FINE);
                self.changes.iter().any(|known| (known - t).abs() <= near)
            };
            let mut found = acts_between(self.problem, &times, &states);
            found.retain(|t| !is_known(t));
            if found.is_empty() {
                break;
            }
            self.changes.extend(found);
            self.changes.sort_by(f64::total_cmp);
            (self.known, self.extent, self.ends) = Default::default();
            self.of_steps(FINE)?;
        }
        Ok(())
    }

    /// Whether f changes by itself between the times at which the first run stopped.
    pub(super) fn changes_by_itself(&self) -> bool {
        !self.changes.is_empty()
    }

    /// The numbers of the steps that end at `ends` at which errors are measured: [`chosen`] ones, and those in which f changes.
    fn shown(&self, ends: &[f64]) -> Vec<usize> {
        let mut shown = chosen(ends.len(), self.most);
        let after = |t: &f64| ends.partition_point(|end| end < t) + 1;
        shown.extend(self.changes.iter().map(after).filter(|step| *step <= ends.len()));
        shown.sort_unstable();
        shown.dedup();
        shown
    }

    /// The numbers of those of so many steps at whose ends errors are measured.
    fn steps(&self, steps: u32) -> Vec<usize> {
        let ends: Vec<f64> = (1..=steps).map(|step| self.horizon * f64::from(step) / f64::from(steps)).collect();
        self.shown(&ends)
    }

    /// The states at these ends.
    fn of_steps(&self, steps: u32) -> Result<Rc<Vec<Vec<f64>>>, RunError> {
        if let Some(states) = self.known.borrow().get(&steps) {
            return Ok(Rc::clone(states));
        }
        let states = Rc::new(self.at(&self.ends_of(steps))?);
        self.known.borrow_mut().insert(steps, Rc::clone(&states));
        Ok(states)
    }

    /// Those ends.
    pub(super) fn ends_of(&self, steps: u32) -> Vec<f64> {
        let end = |step: usize| self.horizon * step as f64 / f64::from(steps);
        self.steps(steps).into_iter().map(end).collect()
    }

    /// Times at which every accurate run stops.
    fn stops(&self) -> Vec<f64> {
        chosen(FINE as usize, TIMES).into_iter().map(|step| self.horizon * step as f64 / f64::from(FINE)).collect()
    }

    /// The states at `times` up to the horizon, by a run that stops at those of many steps too: a run as long as it likes may pass
    /// over what the solution does.
    fn at(&self, times: &[f64]) -> Result<Vec<Vec<f64>>, RunError> {
        let is_asked = |t: &f64| times.iter().any(|time| (time - t).abs() <= RESOLVED * self.horizon);
        let stops = self.stops().into_iter().chain(self.changes.iter().copied());
        let stops = stops.filter(|t| !is_asked(t) && *t > 0.0).map(|t| (t, false));
        let mut stops: Vec<(f64, bool)> = times.iter().map(|t| (*t, true)).chain(stops).collect();
        stops.sort_by(|a, b| a.0.total_cmp(&b.0));
        stops.dedup_by(|next, stop| !next.1 && next.0 - stop.0 <= RESOLVED * self.horizon);
        let all = run_through(self.problem, self.method, &stops.iter().map(|(t, _)| *t).collect::<Vec<_>>())?;
        self.ends.borrow_mut().extend(all.last().cloned());
        let (start, (size, moved)) = (self.problem.initial(), self.extent.get());
        let size = all.iter().map(|state| max_norm(state)).fold(size, larger);
        self.extent.set((size, all.iter().map(|state| common_distance(state, &start)).fold(moved, larger)));
        Ok(all.into_iter().zip(&stops).filter_map(|(state, (_, is_asked))| is_asked.then_some(state)).collect())
    }

    /// How far the runs that were made end from the first one.
    pub(super) fn parts_by(&self) -> f64 {
        let ends = self.ends.borrow();
        worst(ends.iter().map(|end| common_distance(end, &ends[0])))
    }

    /// The largest component, or the unit.
    pub(super) fn size(&self) -> f64 {
        larger(self.extent.get().0, self.unit)
    }

    /// How far `reference` is from it at `times` with the tolerances of accurate runs, one for all components in the unit or beside the least
    /// size of each: infinitely, where it fails.
    pub(super) fn apart_from(&self, reference: &dyn Reference, held: Held, times: &[f64]) -> f64 {
        let limit = self.problem.limit(Principle::Equation);
        let Ok(known) = self.at(times) else { return f64::INFINITY };
        // What f does for a moment is seen in steps as short as those of a trial may be.
        let shortest = self.horizon / f64::from(MOST);
        let longest = if self.changes_by_itself() { shortest } else { f64::INFINITY };
        let apart = |sizes: &[f64]| {
            let ode = InUnits::new(limit.ode, sizes).within(longest);
            let run = reference.run(&ode, 0.0, &ode.in_units(&limit.initial), times, held.rtol);
            let Ok(run) = run else { return f64::INFINITY };
            let observed = |t: f64, state: &[f64]| self.problem.observe(t, state);
            let states = times.iter().zip(known.iter().zip(&run.states));
            worst(states.map(|(t, (known, state))| distance(&observed(*t, known), &observed(*t, &ode.states(state)))))
        };
        let n = limit.initial.len();
        let least = self.least_sizes(held.scale).filter(|sizes| sizes.len() == n);
        apart(&vec![self.unit; n]).min(least.map_or(f64::INFINITY, |sizes| apart(&sizes)))
    }

    /// The least size that a component has in a part of the run, but for roundings of the largest, or for this part of them: an absolute
    /// tolerance beside it lets go of what comes back from there.
    pub(super) fn least_sizes(&self, part: f64) -> Option<Vec<f64>> {
        let states = self.of_steps(FINE).ok()?;
        let of_part = |part: &[Vec<f64>], k: usize| part.iter().map(|state| state[k].abs()).fold(0.0, larger);
        let parts = || states.chunks(states.len().div_ceil(PARTS));
        let least = |k: usize| parts().map(|part| of_part(part, k)).smallest().max(part * f64::EPSILON * self.size());
        Some((0..states.first()?.len()).map(least).collect())
    }

    /// Whether states of it show what it does.
    fn is_shown_by(&self, states: &[Vec<f64>]) -> bool {
        let start = self.problem.initial();
        worst(states.iter().map(|state| common_distance(state, &start))) >= SHOWN * self.moves_by()
    }

    /// Takes over that another run saw it go so far from its start.
    pub(super) fn was_seen_to_move(&self, moved: f64) {
        let (size, before) = self.extent.get();
        self.extent.set((size, larger(before, moved)));
    }

    /// How far it goes from its start, as far as any run has asked.
    pub(super) fn moves_by(&self) -> f64 {
        self.extent.get().1
    }
}

/// Part of the way that the solution goes from its start which it has to go at the ends of the steps of a run: one that passes over a burst
/// shows nothing of it.
const SHOWN: f64 = 0.5;

/// A run that takes so many times the work that is worth a trial is broken off. Its error might still have confirmed the solution.
const WORTH: f64 = 4.0;

/// A run with a number of steps: its largest error at the times chosen, infinite if it was broken off, and its work.
struct Ran {
    steps: u32,
    error: f64,
    work: Work,
}

impl Ran {
    /// With its error at the times of a run with `shown` steps, of which its own are a multiple; broken off after the work `most`.
    fn at_ends_of(
        shown: u32,
        (problem, method): (&dyn Problem, &dyn Method),
        steps: u32,
        truth: &Truth,
        most: f64,
    ) -> Result<Self, RunError> {
        let (states, times) = (truth.of_steps(shown)?, truth.steps(shown));
        let (every, mut step, mut next, mut worst) = ((steps / shown) as usize, 0, 0, 0.0);
        let (h, cost) = (truth.horizon / f64::from(steps), cost(problem, method));
        let run = run_from(problem, problem.initial(), method, h, truth.horizon, |state, work| {
            if times.get(next).is_some_and(|time| time * every == step) {
                worst = larger(worst, common_distance(&states[next], &state.q));
                next += 1;
            }
            step += 1;
            if cost(work) > most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })?;
        let error = if next < times.len() { f64::INFINITY } else { worst };
        Ok(Self { steps, error, work: run.work })
    }
}

/// The run of an adaptive method, if its error is within the target at the ends of its steps that are chosen, and between them where f
/// changes by itself, over which a step may pass. They are those of a run that a user makes; the truth is followed to where they end. A run
/// of more steps than any other method is tried with has lost the solution.
pub(super) fn with_tolerance(
    problem: &dyn Problem,
    (rtol, atol): (f64, &[f64]),
    is_strict: bool,
    longest: f64,
    truth: &Truth,
    target: f64,
) -> Option<Trial> {
    let horizon = truth.horizon;
    let method = &*adaptive_within((rtol, atol), is_strict).ok()?;
    let mut ends = Vec::new();
    let run = run_while(problem, method, longest, horizon, |state| {
        ends.push((state.t, state.q.clone()));
        if ends.len() > MOST as usize { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
    .ok()?;
    if run.end.t < horizon {
        return None;
    }
    // The first is the start.
    let all: Vec<f64> = ends[1..].iter().map(|(t, _)| *t).collect();
    let shown: Vec<_> = truth.shown(&all).into_iter().map(|step| &ends[step]).collect();
    let times: Vec<f64> = shown.iter().map(|(t, _)| *t).collect();
    let between = run_between(problem, method, [longest, horizon], &truth.changes).ok()?;
    let known = truth.at(&times).ok()?;
    if !truth.is_shown_by(&known) {
        return None;
    }
    let known = [known, truth.at(&truth.changes).ok()?].concat();
    let found = shown.iter().map(|(_, state)| state).chain(&between);
    let error = worst(found.zip(&known).map(|(state, known)| common_distance(known, state)));
    let mut times = [times, truth.changes.clone()].concat();
    times.sort_by(f64::total_cmp);
    let trial = Trial {
        method: method.name(),
        setting: rtol,
        atol: Some(atol.to_vec()),
        longest: (longest < horizon).then_some(longest),
        is_strict,
        steps: run.work.steps,
        error,
        times,
        cost: cost(problem, method)(run.work),
        falls: None,
    };
    (error <= target).then_some(trial)
}

/// Whether a step of a method that h|λ| limits amplifies what the equation with the Jacobian `calm` lets not grow: the next start may have
/// of it what this one has not.
fn amplifies(method: &dyn Method, h: f64, calm: Option<&DMatrix<f64>>) -> bool {
    let factor = calm.filter(|_| method.stability() == Stability::Conditional).and_then(|a| growth(method, &(h * a)));
    factor.is_some_and(|factor| factor > 1.0 + SAME)
}

/// The longest step from the start of a run, as its failure tells: where the branch of solutions ends in the first step, it does in every longer one.
fn longest_first_step(error: &RunError) -> f64 {
    match *error {
        RunError::Step(StepError::Solve { t: 0.0, source: SolveError::BranchLost { reached }, .. }) => reached,
        _ => f64::INFINITY,
    }
}

/// The fewest steps with which a method reaches the target, found by halving and by its order, and its smallest error; besides twice the
/// steps, where the errors of those alone follow its order. None where a run takes more work than `most`.
pub(super) fn search(
    problem: &dyn Problem,
    method: &dyn Method,
    truth: &Truth,
    target: f64,
    most: f64,
    calm: Option<&DMatrix<f64>>,
) -> (Vec<Trial>, f64) {
    let (horizon, cost) = (truth.horizon, cost(problem, method));
    let longest = Cell::new(f64::INFINITY);
    let tried = |steps: u32| {
        if horizon / f64::from(steps) > longest.get() {
            return None;
        }
        let ran = Ran::at_ends_of(steps, (problem, method), steps, truth, WORTH * most);
        let ran = ran.inspect_err(|error| longest.set(longest.get().min(longest_first_step(error)))).ok()?;
        let is_right = ran.error <= target;
        let is_shown = || truth.of_steps(steps).is_ok_and(|states| truth.is_shown_by(&states));
        let is_useless = is_right && (amplifies(method, horizon / f64::from(steps), calm) || !is_shown());
        Some(if is_useless { Ran { error: f64::INFINITY, ..ran } } else { ran })
    };
    let mut before = None;
    let mut steps = LEAST;
    let (coarse, found) = loop {
        let now = tried(steps);
        match now {
            Some(found) if found.error <= target => break (before, found),
            _ if steps == MOST || now.as_ref().is_some_and(|ran| cost(ran.work) > most) => {
                return (Vec::new(), now.map_or(f64::INFINITY, |ran| ran.error));
            }
            _ => (before, steps) = (now, 2 * steps),
        }
    };
    // Twice the steps, for the order and for an error that is known.
    let halved = |steps: u32| Ran::at_ends_of(steps, (problem, method), 2 * steps, truth, f64::INFINITY).ok();
    let Some(fine) = halved(found.steps) else { return (Vec::new(), found.error) };
    // Of a method that is exact here there is no order to see.
    let falls =
        |error: f64, finer: f64| (error > 0.0).then(|| Falls { errors: [error, finer], nominal: method.order() });
    let trial = |Ran { steps, error, work }: Ran, falls: Option<Falls>| Trial {
        method: method.name(),
        setting: horizon / f64::from(steps),
        atol: None,
        longest: None,
        is_strict: false,
        steps: u64::from(steps),
        error,
        times: truth.ends_of(steps),
        cost: cost(work),
        falls,
    };
    let nearer = coarse.and_then(|coarse| {
        // Between the two, where the error reaches the target; a multiple of four steps, or of sixteen where that is little more, so
        // that several methods have the same.
        let factor = match coarse.error.is_finite() {
            true => (coarse.error / target).powf(1.0 / (coarse.error / found.error).log2().max(0.5)),
            false => SQRT_2,
        };
        let steps = f64::from(coarse.steps) * factor;
        let unit = if steps < 64.0 { 4.0 } else { 16.0 };
        let between = (unit * (steps / unit).ceil()) as u32;
        (between < found.steps).then(|| tried(between)).flatten()
    });
    let (steps, falling) = (2 * found.steps, falls(found.error, fine.error));
    let first = trial(nearer.filter(|ran| ran.error <= target).unwrap_or(found), falling);
    // An error that is small by chance is no guide to others, and twice the steps may be still cheaper than any other method.
    let is_chance = first.unpredictable(0.0).is_some() && steps <= MOST;
    let twice = is_chance.then(|| tried(steps)).flatten().filter(|ran| ran.error <= target && cost(ran.work) <= most);
    let twice = twice.and_then(|ran| {
        let falling = falls(ran.error, halved(steps)?.error);
        Some(trial(ran, falling)).filter(|trial| trial.unpredictable(0.0).is_none())
    });
    let least = fine.error.min(first.error);
    ([Some(first), twice].into_iter().flatten().collect(), least)
}

/// Work in evaluations of f: an equation of the method takes as many as it has stages, a matrix those of its columns that differ. Where a
/// matrix has second derivatives in it, and f is a model, which has none of its own, they are differences of a matrix for each column.
pub(super) fn cost(problem: &dyn Problem, method: &dyn Method) -> impl Fn(Work) -> f64 + use<> {
    let field = problem.field();
    let columns = match field.structure() {
        Structure::Banded { lower, upper } => lower + upper + 1,
        Structure::Dense => field.dim(),
        // Few colours, or a product at a time.
        _ => 5,
    };
    let has_second = !matches!(method.principle(), Principle::Equation | Principle::Hamilton) && !field.is_linear();
    let is_differenced = has_second && problem.facts().model.is_some();
    let matrix = columns as f64 * if is_differenced { (columns + 2) as f64 } else { 1.0 };
    let stages = f64::from(method.traits().stages);
    move |work| {
        let equations = work.residuals as f64 + matrix * work.factorizations as f64;
        stages * (equations + work.inner as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::super::adaptive;
    use super::*;
    use crate::method;
    use crate::problem::{self, model::Model};
    use crate::reference::{Ode, ReferenceError, Run};

    const HORIZON: f64 = 8.0;

    fn drag() -> Box<dyn Problem> {
        problem::build_setting("linear-drag").expect("registered")
    }

    /// v̇ = −v from 1 and an accurate solution of it, to `check`.
    fn with_truth(check: impl Fn(&dyn Problem, Truth)) {
        let (problem, method) = (drag(), adaptive(1e-12).expect("registered"));
        check(&*problem, Truth::by(&*problem, &*method, HORIZON, 1.0).expect("it runs"));
    }

    /// The largest error of implicit Euler with so many steps on v̇ = −v at each `every`-th of them.
    fn of_implicit_euler(steps: u32, every: usize) -> f64 {
        let h = HORIZON / f64::from(steps);
        let error = |k: u32| ((1.0 + h).powf(-f64::from(k)) - (-h * f64::from(k)).exp()).abs();
        (1..=steps).step_by(every).map(|k| error(k - 1 + every as u32)).fold(0.0, larger)
    }

    /// |R(z)| of RK4 is 1 at 0, 0.27 at −2 and 1.375 at −3; implicit Euler damps at any.
    #[test]
    fn steps_amplify_what_they_multiply_by_more_than_one() {
        let amplified = |name: &str, h: f64, rate: f64| {
            let method = method::parse(name).expect("registered");
            amplifies(&*method, h, Some(&DMatrix::from_element(1, 1, rate)))
        };
        assert_eq!([0.0, -1.0, -1.5].map(|rate| amplified("rk4", 2.0, rate)), [false, false, true]);
        assert!(!amplified("implicit-euler", 2.0, -1.5));
        let rk4 = method::parse("rk4").expect("registered");
        assert!(!amplifies(&*rk4, 2.0, None));
    }

    /// v̇ = −v in 8 steps of 1, and not as one of 64.
    #[test]
    fn steps_that_damp_what_is_damped_are_a_trial() {
        with_truth(|problem, truth| {
            let rk4 = method::parse("rk4").expect("registered");
            let calm = DMatrix::from_element(1, 1, -1.0);
            let (found, _) = search(problem, &*rk4, &truth, 0.01, f64::INFINITY, Some(&calm));
            assert!(found.first().is_some_and(|trial| trial.error <= 0.01 && trial.setting <= 2.7), "{found:?}");
            // RK4's leading error is h⁴/120 t e⁻ᵗ: 2·10⁻⁴ at t = 1 with 16 steps.
            let (found, _) = search(problem, &*rk4, &truth, 1e-3, f64::INFINITY, Some(&calm));
            assert!(found.first().is_some_and(|trial| trial.error <= 1e-3 && trial.steps >= 9), "{found:?}");
        });
    }

    /// The equation of implicit Euler, W = 1 + h W², has a solution for h ≤ 1/4: from the start no longer step has one, later a shorter one than 1/4 may
    /// have none.
    #[test]
    fn a_branch_that_ends_in_the_first_step_ends_in_every_longer_one() {
        let problem = problem::build_setting("quadratic-drag lambda=-1").expect("registered");
        let euler = method::parse("implicit-euler").expect("registered");
        let failed = |h: f64| run_from(&*problem, vec![1.0], &*euler, h, 0.9, |_, _| ControlFlow::Continue(()));
        let [first, later] = [0.3, 0.15].map(|h| longest_first_step(&failed(h).expect_err("it has no solution")));
        approx::assert_relative_eq!(first, 0.25, max_relative = 1e-3);
        assert_eq!(later, f64::INFINITY);
    }

    /// At rest every method is exact.
    #[test]
    fn of_a_method_without_errors_no_order_is_told() {
        let rest = problem::build_setting("harmonic-oscillator q0=0 p0=0").expect("registered");
        let (accurate, rk4) = (adaptive(1e-12).expect("registered"), method::parse("rk4").expect("registered"));
        let truth = Truth::by(&*rest, &*accurate, HORIZON, 1.0).expect("it runs");
        let (found, _) = search(&*rest, &*rk4, &truth, 0.01, f64::INFINITY, None);
        let found = found.first().expect("it is exact");
        assert_eq!((found.error, found.falls), (0.0, None));
    }

    /// As far as errors are known: 1 and 0.19 to within 0.1 may be 1.1 and 0.09, which are an order of log₂ 12.2 = 3.61 apart.
    #[test]
    fn errors_are_unpredictable_where_they_fall_by_half_an_order_less_than_they_should() {
        let of = |errors: [f64; 2], uncertainty: f64| Falls { errors, nominal: 4 }.unpredictable(uncertainty);
        assert_eq!(of([1.0, 0.5], 0.0), Some(1.0));
        assert_eq!([of([1.0, 0.088], 0.0), of([1.0, 0.19], 0.1)], [None, None]);
        assert_eq!(of([1.0, 0.125], 0.0), Some(3.0));
        assert_eq!(of([1.0, 0.25], 0.1), Some(2.0));
    }

    /// Another run may have seen more of the solution than those that were asked of it.
    #[test]
    fn steps_show_a_solution_that_moves_as_far_as_any_run_has_seen() {
        with_truth(|_, truth| {
            let states = truth.of_steps(8).expect("it runs");
            assert!(truth.is_shown_by(&states));
            truth.was_seen_to_move(1.5);
            assert!(truth.is_shown_by(&states));
            truth.was_seen_to_move(2.5);
            truth.was_seen_to_move(0.1);
            assert!(!truth.is_shown_by(&states) && truth.moves_by() == 2.5);
        });
    }

    /// Part k of 64 has its time at k − frac(0.618 k): of 640 steps the first three end at 3.82, 17.64 and 21.46, the last but one
    /// at 620.64.
    #[test]
    fn steps_are_chosen_at_irregular_places_in_equal_parts() {
        let chosen = chosen(640, TIMES);
        assert_eq!((&chosen[..3], &chosen[62..]), (&[4, 18, 22][..], &[621, 640][..]));
    }

    #[test]
    fn fewer_times_are_looked_at_of_a_large_system() {
        assert_eq!([0, 1, 2, 32, 64, 65, 1000].map(looked_at), [1 << 18, 1 << 18, 1 << 16, 1 << 8, 64, 64, 64]);
    }

    /// A change belongs to the step that ends with it or after it; one beyond the last step to none.
    #[test]
    fn the_steps_in_which_f_changes_are_shown_beside_those_chosen() {
        with_truth(|_, mut truth| {
            assert_eq!(truth.changes, [0.0; 0]);
            assert_eq!(truth.steps(640).len(), 640, "a system of one unknown is looked at at each");
            truth.most = TIMES;
            let ends: Vec<f64> = (1..=640).map(f64::from).collect();
            truth.changes = vec![1.5, 3.0, 30.0, 700.0];
            let shown = truth.shown(&ends);
            assert_eq!((&shown[..5], shown.last()), (&[2, 3, 4, 18, 22][..], Some(&640)));
            assert!(shown.contains(&30) && shown.is_sorted() && shown.len() == 64 + 3, "{shown:?}");
            truth.changes = vec![5.5];
            assert_eq!((truth.steps(4), truth.ends_of(4)), (vec![1, 2, 3, 4], vec![2.0, 4.0, 6.0, 8.0]));
            // A step of 1/80: the change is in the 440th.
            assert!(truth.steps(640).contains(&440) && !chosen(640, TIMES).contains(&440));
            assert!(truth.ends_of(640).contains(&5.5));
        });
    }

    /// Two places of a clock, each within a step of 1/128. What f does at the second it does after the first has done its part.
    #[test]
    fn a_place_to_which_another_leads_is_found_too() {
        let at = |place: f64| format!("1000*heaviside(x - {place})*heaviside({} - x)", place + 1e-3);
        let rates = format!("1, {}, heaviside(v - 0.1)*{}", at(2.3462), at(5.6822));
        let problem = Model::of_text(&format!("u_i {{ x = 0, v = 0, w = 0 }} F_i {{ {rates} }}"), &[], Some(HORIZON))
            .expect("a model");
        let method = adaptive(1e-4).expect("registered");
        let truth = Truth::by(&problem, &*method, HORIZON, 1.0).expect("it runs");
        // Beside it, in its step.
        let is_found = |place: f64| truth.changes.iter().any(|t| (t - place).abs() < HORIZON / f64::from(FINE));
        assert!(is_found(2.3462) && is_found(5.6822), "{:?}", truth.changes);
    }

    #[test]
    fn the_accurate_solution_is_known_at_the_times_that_are_asked_for_and_no_others() {
        with_truth(|problem, mut truth| {
            // Two of these are stops of every run.
            truth.changes = vec![0.003, truth.stops()[10], truth.stops()[20].next_up(), 5.0];
            // At a change, a rounding beside one, at a stop of the long run, and elsewhere.
            let stop = truth.ends_of(FINE)[7];
            for times in [vec![0.003, stop, 5.0 + 1e-12, 6.1], vec![8.0], vec![0.5, 1.0, 7.999_999]] {
                let states = truth.at(&times).expect("it runs");
                assert_eq!(states.len(), times.len());
                for (t, state) in times.iter().zip(&states) {
                    let exact = problem.exact(*t).expect("it is known");
                    assert!((state[0] - exact[0]).abs() <= 1e-9, "t = {t}: {state:?}, {exact:?}");
                }
            }
            let four = truth.of_steps(4).expect("it runs");
            assert!((four[1][0] - (-4.0_f64).exp()).abs() <= 1e-9 && four.len() == 4, "{four:?}");
            assert!(Rc::ptr_eq(&four, &truth.of_steps(4).expect("it ran")));
            assert!(truth.parts_by() <= 1e-9, "{:e}", truth.parts_by());
            truth.ends.borrow_mut().push(vec![0.5 + (-HORIZON).exp(); 1]);
            assert!((truth.parts_by() - 0.5).abs() <= 1e-9, "{}", truth.parts_by());
            truth.ends.borrow_mut().push(vec![f64::NAN]);
            assert!(truth.parts_by().is_nan());
        });
    }

    /// v = v₀/(1 + v₀ t) at t = 8: from 3 to 3/25, and from ½ to ½/5. The size is 1 at least, however small a solution is.
    #[test]
    fn the_size_of_the_solution_and_how_far_it_goes_are_those_of_its_runs() {
        for (setting, size, moved) in [
            ("quadratic-drag v0=3", 3.0 / (1.0 + 3.0 * 8.0 / 1024.0), 3.0 - 3.0 / 25.0),
            ("quadratic-drag v0=0.5", 1.0, 0.4),
        ] {
            let (problem, method) =
                (problem::build_setting(setting).expect("registered"), adaptive(1e-12).expect("registered"));
            let truth = Truth::by(&*problem, &*method, HORIZON, 1.0).expect("it runs");
            assert!((truth.moves_by() - moved).abs() <= 1e-9, "{setting}: {}", truth.moves_by());
            // The run stops at some of 1024 steps; the first of them is chosen or a few steps on.
            assert!(truth.size() <= 3.0 && (truth.size() - size).abs() <= 0.8, "{setting}: {}", truth.size());
        }
    }

    /// e^(−t) to t = 8 is least in its last sixteenth, of which t = 7.5 is the first time but for a step; what comes back is least on the way.
    #[test]
    fn the_least_size_of_a_component_is_that_in_the_part_in_which_it_is_least() {
        with_truth(|_, truth| {
            let least = truth.least_sizes(1.0).expect("it has one unknown")[0];
            assert!((least - (-7.5_f64).exp()).abs() <= 0.01 * least, "{least}");
        });
        let rest = problem::build_setting("harmonic-oscillator q0=0 p0=0").expect("registered");
        let method = adaptive(1e-12).expect("registered");
        let truth = Truth::by(&*rest, &*method, HORIZON, 8.0).expect("it runs");
        for part in [1.0, 0.25] {
            let least = part * 8.0 * f64::EPSILON;
            assert_eq!(truth.least_sizes(part), Some(vec![least; 2]), "an absolute tolerance of 0 would allow no step");
        }
    }

    /// The errors fall from the first unit of time on, which is the end of a step of eight and of none of four.
    #[test]
    fn an_error_is_that_at_the_ends_of_the_steps_asked_for() {
        let method = method::parse("implicit-euler").expect("registered");
        with_truth(|problem, truth| {
            let ran = |shown: u32, steps: u32, most: f64| {
                Ran::at_ends_of(shown, (problem, &*method), steps, &truth, most).expect("it runs")
            };
            for (shown, steps, every) in [(8, 8, 1), (4, 8, 2), (4, 4, 1), (4, 16, 4)] {
                let (found, expected) = (ran(shown, steps, f64::INFINITY), of_implicit_euler(steps, every));
                assert!((found.error - expected).abs() <= 1e-9, "{shown}, {steps}: {} for {expected}", found.error);
                assert_eq!((found.steps, found.work.steps), (steps, u64::from(steps)));
            }
            let work = ran(8, 8, f64::INFINITY).work;
            let all = cost(problem, &*method)(work);
            // Work that is reached is not exceeded; with half of it the run ends half way.
            assert!(ran(8, 8, all).error.is_finite() && ran(8, 8, 0.5 * all).error == f64::INFINITY);
        });
    }

    /// Few steps, by multiples of four or of sixteen, that reach the target where a few less do not; twice the power of two from
    /// which they were found tell the order and the smallest error.
    #[test]
    fn the_steps_that_are_found_are_the_fewest_but_for_one_unit() {
        let method = method::parse("implicit-euler").expect("registered");
        with_truth(|problem, truth| {
            for target in [0.15, 0.1, 0.05, 0.03, 0.02, 0.011, 0.01, 0.008] {
                let (trials, least) = search(problem, &*method, &truth, target, 1e6, None);
                assert_eq!(trials.len(), 1, "its errors follow its order");
                let trial = trials.into_iter().next().expect("within reach");
                let steps = trial.steps as u32;
                let (unit, below) = if steps < 64 { (4, 8) } else { (16, 32) };
                assert!(steps.is_multiple_of(unit), "{target}: {trial:?}");
                let every = |steps: u32| of_implicit_euler(steps, 1);
                if steps <= 64 {
                    assert!((trial.error - every(steps)).abs() <= 1e-9, "{target}: {trial:?}");
                    assert_eq!(trial.times.len(), steps as usize);
                }
                assert!(trial.error <= target, "{target}: {trial:?}");
                assert!(steps <= below || every(steps - below) > target, "{target}: {trial:?}");
                assert_eq!((&*trial.method, trial.setting), ("implicit-euler", HORIZON / f64::from(steps)));
                let power = steps.next_power_of_two();
                if power <= 64 {
                    let order = (every(power) / of_implicit_euler(2 * power, 2)).log2();
                    let falls = trial.falls.expect("it has errors");
                    let (found, nominal) = ((falls.errors[0] / falls.errors[1]).log2(), falls.nominal);
                    assert!((found - order).abs() <= 1e-6 && nominal == 1, "{target}: {trial:?} for {order}");
                    let smallest = of_implicit_euler(2 * power, 2).min(trial.error);
                    assert!((least - smallest).abs() <= 1e-9, "{target}: {least} for {smallest}");
                }
            }
            // Half of the work of the last trial, four times of which are still tried and found wanting.
            let (found, least) = search(problem, &*method, &truth, 1e-9, 64.0, None);
            assert!(found.is_empty() && least > 1e-9 && least.is_finite(), "{found:?}, {least}");
            let work = Ran::at_ends_of(32, (problem, &*method), 32, &truth, f64::INFINITY).expect("it runs").work;
            let (_, least) = search(problem, &*method, &truth, 1e-9, 0.75 * cost(problem, &*method)(work), None);
            assert!((least - of_implicit_euler(32, 1)).abs() <= 1e-9, "with more work than 16 steps: {least}");
        });
    }

    /// v̇ = −v|v|: the errors of rk4 in 4 steps and in 8 are of opposite signs and of one size, those of 8 and 16 apart by 2⁴ and more.
    #[test]
    fn where_an_error_is_small_by_chance_twice_the_steps_are_a_trial_too() {
        let problem = problem::build_setting("quadratic-drag").expect("registered");
        let (rk4, accurate) = (method::parse("rk4").expect("registered"), adaptive(1e-12).expect("registered"));
        let truth = Truth::by(&*problem, &*accurate, problem.horizon(), 1.0).expect("it runs");
        let trials = |most: f64| search(&*problem, &*rk4, &truth, 1e-3, most, None).0;
        let told: Vec<_> =
            trials(1e3).iter().map(|trial| (trial.steps, trial.cost, trial.unpredictable(0.0).is_some())).collect();
        assert_eq!(told, [(4, 16.0, true), (8, 32.0, false)]);
        assert_eq!(trials(31.0).len(), 1, "that is more work than is worth it");
    }

    #[test]
    fn a_tolerance_is_tried_against_the_target_at_the_steps_that_it_takes() {
        with_truth(|problem, truth| {
            let longest = [0.5, 1.0].map(|part| {
                let trial = with_tolerance(problem, (1e-4, &[1e-4]), false, part * HORIZON, &truth, 1.0);
                trial.expect("within 1").longest
            });
            assert_eq!(longest, [Some(0.5 * HORIZON), None], "that of the run needs no telling");
            let tried = |target: f64| with_tolerance(problem, (1e-4, &[1e-4]), false, HORIZON, &truth, target);
            let trial = tried(1.0).expect("within 1");
            assert!(
                trial.error > 0.0 && trial.error < 1e-3 && trial.setting == 1e-4 && trial.falls.is_none(),
                "{trial:?}"
            );
            assert_eq!((trial.times.len() as u64, trial.cost > 0.0), (trial.steps, true));
            assert_eq!(tried(trial.error), Some(trial.clone()));
            assert_eq!(tried(0.999 * trial.error), None);
        });
    }

    #[test]
    fn a_tolerance_with_more_steps_than_any_other_method_may_take_is_no_trial() {
        with_truth(|problem, truth| {
            let tried = |steps: f64| with_tolerance(problem, (1e-4, &[1e-4]), false, HORIZON / steps, &truth, 1.0);
            assert!(tried(100.0).is_some());
            assert_eq!(tried(20_000.0), None);
        });
    }

    /// Inside of long steps it is larger.
    #[test]
    fn the_error_of_an_adaptive_method_is_that_where_f_changes_too() {
        with_truth(|problem, mut truth| {
            let error = |truth: &Truth| {
                with_tolerance(problem, (1e-2, &[1e-2]), false, HORIZON, truth, 1.0).expect("within 1").error
            };
            let at_ends = error(&truth);
            truth.changes = (1..80).map(|k| 0.1 * f64::from(k)).collect();
            assert!(error(&truth) > 2.0 * at_ends, "{:e}, {at_ends:e}", error(&truth));
        });
    }

    /// e^(−t) but for a difference at the last time, which the equation may tell, or a failure.
    struct Says(fn(&dyn Ode) -> Option<f64>);

    impl Reference for Says {
        fn name(&self) -> &'static str {
            "says"
        }
        fn stiff_ok(&self) -> bool {
            true
        }
        fn library(&self) -> Option<String> {
            None
        }
        fn run(&self, ode: &dyn Ode, _: f64, v0: &[f64], times: &[f64], _: f64) -> Result<Run, ReferenceError> {
            let off = (self.0)(ode).ok_or_else(|| ReferenceError::Input("fails".into()))?;
            let mut run = Run::with_capacity(times.len());
            for (k, t) in times.iter().enumerate() {
                let last = if k + 1 == times.len() { off } else { 0.0 };
                run.push(vec![v0[0] * ((-t).exp() + last)], 1);
            }
            Ok(run)
        }
    }

    #[test]
    fn a_reference_confirms_at_all_times_and_not_by_failing() {
        with_truth(|_, truth| {
            let apart = |off| truth.apart_from(&Says(off), Held::to(1e-5), &[0.5, 1.0, 4.0]);
            assert_eq!(apart(|_| None), f64::INFINITY);
            assert!(apart(|_| Some(0.0)) <= 1e-9 && (apart(|_| Some(0.25)) - 0.25).abs() <= 1e-9);
        });
    }

    #[test]
    fn a_reference_takes_steps_as_short_as_those_of_a_trial_where_f_changes() {
        with_truth(|_, mut truth| {
            let longest =
                |truth: &Truth| truth.apart_from(&Says(|ode| Some(ode.longest_step(HORIZON))), Held::to(1e-5), &[4.0]);
            assert_eq!(longest(&truth), f64::INFINITY);
            truth.changes = vec![3.0];
            assert!((longest(&truth) - HORIZON / f64::from(MOST)).abs() <= 1e-9, "{}", longest(&truth));
        });
    }
}
