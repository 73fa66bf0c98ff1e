//! Every solver of a problem against every other: methods ↔ exact ↔ CVODE ↔ diffsol.

use std::cell::Cell;

use rayon::prelude::*;

use crate::kinds::{Principle, Stability};
use crate::measure::decimal::{decimals, plain, significant, trimmed};
use crate::measure::norm::{Extremes, common_distance, distance, max_norm};
use crate::method::Method;
use crate::order::roundoff;
use crate::problem::changes::changes;
use crate::problem::{Limit, Problem, component_names};
use crate::program::{Program, ProgramError, Request};
use crate::reference::{self, Reference, ReferenceError};
use crate::run::{RunError, run};
use crate::theory::{Breakdown, breakdown, methods_for};

/// Sample times, equally spaced, the last at the horizon.
pub const SAMPLES: usize = 4;

/// Steps of the coarser of a method's two runs, a multiple of [`SAMPLES`]; doubled up to [`MOST_STEPS`] until the bound resolves
/// the solution.
const STEPS: usize = 1024;
const MOST_STEPS: usize = 8 * STEPS;

/// The same of a system of more than this many unknowns, whose steps are dear.
const FEW_STEPS: usize = 128;
const LARGE: usize = 200;

/// Largest bound, relative to the size of the truth, that an agreement is worth anything with: two digits.
const RESOLVED: f64 = 1e-2;

/// Orders that differ by no more are one: two runs predict an error to a fifth where the order of their difference is off by so much.
const SETTLED: f64 = 0.25;

/// Least order that a bound is taken with.
const MIN_ORDER: f64 = 1.0;

/// Growth of a distance from one sample to the next that is the equation's and no accident: a distance between two scalars may pass
/// near zero, but not between all pairs of references at once.
const GROWTH: f64 = 100.0;

/// States at the sample times, and a bound on their error.
struct Answer {
    states: Vec<Vec<f64>>,
    bound: f64,
    /// Why it must be wrong, as the problem declares.
    astray: Option<Breakdown>,
    /// Where the bound is from, if from runs with fixed steps.
    runs: Option<Runs>,
}

/// What runs with steps of 2h and h, and of 4h where these were needed, show.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Runs {
    h: f64,
    /// The order that the bound is taken with.
    order: f64,
    /// The order by which the differences of three runs fall, and that of the three before.
    observed: Option<f64>,
    earlier: Option<f64>,
    /// Whether the differences are those of errors of that order or of a higher one, or of roundings.
    is_settled: bool,
    /// Whether two runs would have done.
    at_once: bool,
}

/// Why a solver gave no answer.
enum Gap {
    NotRun(String),
    Failed(String),
    /// It failed, as the problem declares that it must.
    BrokeDown(String),
}

impl From<ReferenceError> for Gap {
    fn from(error: ReferenceError) -> Self {
        match error {
            ReferenceError::Unavailable(_) => Self::NotRun(error.to_string()),
            _ => Self::Failed(error.to_string()),
        }
    }
}

/// A solver and what it gave.
type Solved = (String, Result<Answer, Gap>);

/// How an answer stands to the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// Within bounds that resolve the solution.
    Agrees,
    /// Within bounds that are too wide to tell.
    Unresolved,
    /// Outside of the bounds.
    Differs,
    /// It does not follow the truth, or breaks down, as theory predicts.
    Astray,
    /// It follows the truth, which theory rules out.
    Unforeseen,
    /// There is no answer, or no truth.
    Undecided,
    /// It was not run.
    NotRun,
}

/// A solver's answer beside the truth.
#[derive(Debug, Clone)]
pub struct Compared {
    /// The equation that it solves, and why it is this one.
    pub equation: (&'static str, &'static str),
    /// A reference, a method or a program.
    pub solver: String,
    /// Whose solution is taken for the truth.
    pub truth: Option<String>,
    /// Largest difference at the sample times.
    pub difference: Option<f64>,
    /// What the two solutions' own bounds allow.
    pub bound: Option<f64>,
    /// What follows.
    pub standing: Standing,
    /// The same in words.
    pub status: String,
}

/// All solvers of a problem.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// The problem.
    pub problem: String,
    /// The last of the [`SAMPLES`] times.
    pub horizon: f64,
    /// One for every solver and equation.
    pub solvers: Vec<Compared>,
    /// What is to be known of the references.
    pub notes: Vec<String>,
}

/// A program to compare, by the name it goes by, with what it is asked for and the order that its runs are taken to have.
#[derive(Debug, Clone)]
pub struct Guest {
    /// The command.
    pub name: String,
    /// How to run it.
    pub program: Program,
    /// Problem and parameters.
    pub request: Request,
    /// Its order; 1 gives the widest bound, and so never accuses it falsely.
    pub order: f64,
}

impl Guest {
    /// Whether it starts, and writes the components of `problem`, as one run shows.
    ///
    /// # Errors
    /// [`ProgramError`] that every run would give.
    pub fn check(&self, problem: &dyn Problem) -> Result<(), ProgramError> {
        let horizon = problem.horizon();
        let request = Request { h: Some(horizon / STEPS as f64), t_end: Some(horizon), ..self.request.clone() };
        match self.program.run(&request, &component_names(problem)) {
            Err(error) if error.is_of_every_run() => Err(error),
            _ => Ok(()),
        }
    }
}

/// Solves `problem`, named `name`, by every reference, every method that applies, `own` methods that have other names, and
/// `guests`, and holds each answer against the truth: the exact solution where it is known, else the other reference with the
/// smallest bound.
///
/// A reference gives its own error bound. A method's is twice the error that its runs with h and h/2 predict,
/// |v_h − v_{h/2}|/(2^p − 1), plus a rounding per step. Every answer must lie within its bound and the truth's, and the bound
/// must be small beside the solution, lest a run that diverges agree with everything.
pub fn compare(name: &str, problem: &dyn Problem, own: Vec<Box<dyn Method>>, guests: &[Guest]) -> Comparison {
    let horizon = if problem.facts().model.is_some() { before_rest(problem) } else { problem.horizon() };
    let (mut solvers, mut notes) = (Vec::new(), Vec::new());
    if horizon < problem.horizon() {
        notes.push(format!(
            "By t = {} the solution has come to rest, where a method agrees however it went there: compared up to t = {}.",
            plain(horizon),
            plain(horizon)
        ));
    }
    for (limit, methods) in by_equation(problem, own) {
        let times = sample_times(horizon);
        let mut solved: Vec<Solved> = reference::all()
            .into_par_iter()
            .map(|reference| (reference.name().to_owned(), by_reference(reference, problem, &limit, &times)))
            .collect();
        // Of the references alone: a wrong method, or one whose errors grow, is no reason to doubt what it is judged by.
        let parting = parting(&times, &solved);
        let known = truth(problem, &limit, &times, &solved, "").map(|(_, truth)| truth);
        let by_steps = |method: Box<dyn Method>| (method.name(), by_method(problem, &*method, &times, known.as_ref()));
        solved.par_extend(methods.into_par_iter().map(by_steps));
        let mut asked: Vec<Solved> = Vec::new();
        if limit.name == problem.limit(Principle::Equation).name {
            let known = known.map(|truth| shown(problem, &times, truth));
            let ask = |guest: &Guest| (guest.name.clone(), by_program(problem, guest, &times, known.as_ref()));
            asked.par_extend(guests.into_par_iter().map(ask));
        }
        let of_solved =
            solved.iter().map(|(solver, answer)| (solver, answer, truth(problem, &limit, &times, &solved, solver)));
        let of_asked = asked.iter().map(|(guest, answer)| {
            let truth = truth(problem, &limit, &times, &solved, "");
            (guest, answer, truth.map(|(name, truth)| (name, shown(problem, &times, truth))))
        });
        let first = solvers.len();
        for (solver, answer, truth) in of_solved.chain(of_asked) {
            let (standing, status) = judge(answer, truth.as_ref().map(|(_, truth)| truth));
            let both = answer.as_ref().ok().zip(truth.as_ref());
            solvers.push(Compared {
                equation: (limit.name, limit.reason),
                solver: solver.clone(),
                difference: both.map(|(answer, (_, truth))| largest_distance(&answer.states, &truth.states)),
                bound: both.map(|(answer, (_, truth))| answer.bound + truth.bound),
                truth: truth.map(|(name, _)| name),
                standing,
                status,
            });
        }
        notes.extend(doubt(problem, horizon, parting.as_deref(), &solved, &mut solvers[first..]).or(parting));
    }
    Comparison { problem: name.to_owned(), horizon, solvers, notes }
}

fn sample_times(horizon: f64) -> Vec<f64> {
    (1..=SAMPLES).map(|k| horizon * k as f64 / SAMPLES as f64).collect()
}

/// The horizon of a problem, or the first sample of that, again and again, while a solution that moves is at rest at all samples: a method
/// keeps a rest whatever its weights.
fn before_rest(problem: &dyn Problem) -> f64 {
    let (limit, mut horizon) = (problem.limit(Principle::Equation), problem.horizon());
    let Some(reference) = reference::all().into_iter().find(|it| it.stiff_ok() && it.library().is_some()) else {
        return horizon;
    };
    loop {
        let times = sample_times(horizon);
        let solved = by_reference(reference, problem, &limit, &times);
        let Ok(Answer { states, bound, .. }) = solved else { return horizon };
        let rests = states.iter().all(|state| distance(state, &states[0]) <= bound);
        if !rests || distance(&limit.initial, &states[0]) <= bound {
            return horizon;
        }
        horizon = times[0];
    }
}

/// Where the references themselves part before the horizon: what is said then.
///
/// Two solutions whose distance grows from d₁ at t₁ to d₂ at t₂ tell the rate ln(d₂/d₁)/(t₂ − t₁) of the growth, where it is the equation's:
/// what it magnifies between two solvers it magnifies between the two runs of each, so that their bounds know of it. They do not know
/// of what both runs of one have passed over.
fn parting(times: &[f64], references: &[Solved]) -> Option<String> {
    let answers: Vec<_> = references.iter().filter_map(|(_, answer)| answer.as_ref().ok()).collect();
    let pairs = || answers.iter().enumerate().flat_map(|(i, a)| answers[..i].iter().map(move |b| (a, b)));
    let apart = |k: usize| pairs().map(|(a, b)| distance(&a.states[k], &b.states[k])).largest();
    let lost = |k: &usize| apart(*k) > RESOLVED * answers.iter().map(|answer| max_norm(&answer.states[*k])).largest();
    let first_lost = (0..times.len()).find(lost)?;
    // From where they part on the distance has no room left to grow.
    let last = first_lost.max(1);
    let growth = apart(last) / apart(last - 1);
    if growth.is_nan() || growth <= GROWTH {
        return None;
    }
    let is_foreseen = pairs().all(|(a, b)| distance(&a.states[last], &b.states[last]) <= a.bound + b.bound);
    let why = if is_foreseen {
        format!("Differences grow like e^({:.2} t)", growth.ln() / (times[last] - times[last - 1]))
    } else {
        "Their own bounds do not allow for that, as where one has passed over what f does for a moment".to_owned()
    };
    Some(format!(
        "The references part: by {:.1e} at t = {}, by {:.1e} at t = {}. {why}, and from there on a disagreement says nothing of a solver. \
         Compare up to t = {}.",
        apart(last - 1),
        plain(times[last - 1]),
        apart(last),
        plain(times[last]),
        plain(times[last - 1])
    ))
}

/// The methods, `own` among them, grouped by the equation that they converge to.
fn by_equation(problem: &dyn Problem, mut own: Vec<Box<dyn Method>>) -> Vec<(Limit<'_>, Vec<Box<dyn Method>>)> {
    let mut groups: Vec<(Limit<'_>, Vec<Box<dyn Method>>)> = Vec::new();
    for principle in Principle::ALL {
        let mut suited = methods_for(problem);
        suited.retain(|method| method.principle() == principle);
        for method in own.extract_if(.., |method| method.principle() == principle) {
            // What is asked for may be among them, or be asked for twice.
            if suited.iter().all(|known| known.name() != method.name()) {
                suited.push(method);
            }
        }
        if suited.is_empty() {
            continue;
        }
        let limit = problem.limit(principle);
        match groups.iter_mut().find(|(known, _)| known.name == limit.name) {
            Some((_, group)) => group.extend(suited),
            None => groups.push((limit, suited)),
        }
    }
    groups
}

fn by_reference(
    reference: &dyn Reference,
    problem: &dyn Problem,
    limit: &Limit<'_>,
    times: &[f64],
) -> Result<Answer, Gap> {
    if problem.is_stiff() && !reference.stiff_ok() {
        return Err(Gap::NotRun("the problem is stiff, the solver is not made for that".into()));
    }
    let sampled = reference.solve(limit.ode, 0.0, &limit.initial, times)?;
    let bound = max_norm(&sampled.bound);
    Ok(Answer { states: sampled.states, bound, astray: None, runs: None })
}

fn by_method(problem: &dyn Problem, method: &dyn Method, times: &[f64], truth: Option<&Answer>) -> Result<Answer, Gap> {
    if problem.is_stiff() && method.stability() == Stability::Unstable {
        return Err(Gap::NotRun("the method's own solutions grow like the problem's transients decay".into()));
    }
    let sampled = |steps: usize| -> Result<Vec<Vec<f64>>, RunError> {
        let (mut states, mut count) = (Vec::with_capacity(times.len()), 0);
        let horizon = times[times.len() - 1];
        run(problem, method, horizon / steps as f64, horizon, |state| {
            if count > 0 && count % (steps / times.len()) == 0 {
                states.push(state.q.clone());
            }
            count += 1;
        })?;
        Ok(states)
    };
    let breakdown = breakdown(problem, method, times[times.len() - 1]);
    let failed = |error: RunError| match (error, breakdown) {
        (RunError::Build(error), _) => Gap::NotRun(error.to_string()),
        (error, Some(Breakdown { reason, .. })) => Gap::BrokeDown(format!("{error}; as declared: {reason}")),
        (error, None) => Gap::Failed(error.to_string()),
    };
    if method.traits().is_adaptive {
        let answer = by_tolerance(problem, method, times).map_err(failed)?;
        return Ok(Answer { astray: breakdown, ..answer });
    }
    let cap = problem.limit(method.principle()).order.unwrap_or(f64::INFINITY);
    // What is inconsistent converges too, to something else.
    let order = f64::from(method.order()).min(cap).max(MIN_ORDER);
    let rounding = |size: f64, steps: usize| roundoff(method, size, steps as f64);
    let first = if problem.field().dim() > LARGE { FEW_STEPS } else { STEPS };
    let answer =
        refined(first, |steps| sampled(steps).map_err(failed), order, rounding, times, truth, breakdown.is_some())?;
    Ok(Answer { astray: breakdown, ..answer })
}

/// The answer of an adaptive method with tolerances a hundredth of its own; its bound is the distance from the one with its own, which
/// is most of that one's error. Where no step may be long, those of the finer are half as long, so that the two differ.
fn by_tolerance(problem: &dyn Problem, method: &dyn Method, times: &[f64]) -> Result<Answer, RunError> {
    let longest = problem.ode().longest_step(times[times.len() - 1]);
    // To each time by itself, as steps end where they like.
    let sampled = |method: &dyn Method, h: f64| -> Result<Vec<Vec<f64>>, RunError> {
        times.iter().map(|t| Ok(run(problem, method, h.min(*t), *t, |_| {})?.end.q)).collect()
    };
    let own = sampled(method, longest)?;
    let states = match method.tightened(100.0) {
        Some(finer) => sampled(&*finer, 0.5 * longest)?,
        None => own.clone(),
    };
    let bound = largest_distance(&own, &states) + roundoff(method, largest(&states), STEPS as f64);
    Ok(Answer { states, bound, astray: None, runs: None })
}

/// A program's bound is that of a method, with no roundings but its own last digits.
fn by_program(problem: &dyn Problem, guest: &Guest, times: &[f64], truth: Option<&Answer>) -> Result<Answer, Gap> {
    let columns = component_names(problem);
    let horizon = times[times.len() - 1];
    let printed = Cell::new(0.0_f64);
    let sampled = |steps: usize| -> Result<Vec<Vec<f64>>, Gap> {
        let request = Request { h: Some(horizon / steps as f64), t_end: Some(horizon), ..guest.request.clone() };
        let answer = guest.program.run(&request, &columns).map_err(|error| Gap::Failed(error.to_string()))?;
        printed.set(answer.printed.resolution(largest(&answer.states)));
        let at = |t: &f64| answer.times.iter().position(|time| (time - t).abs() <= 1e-9 * horizon);
        let found = times.iter().map(|t| at(t).map(|k| answer.states[k].clone()).ok_or(*t));
        found.collect::<Result<_, f64>>().map_err(|t| {
            let h = trimmed(horizon / steps as f64, 9);
            Gap::Failed(format!("it has no row at t = {}, a multiple of its step h = {h}", trimmed(t, 9)))
        })
    };
    let rounding = |size: f64, steps: usize| f64::EPSILON * size * steps as f64 + printed.get();
    refined(STEPS, sampled, guest.order, rounding, times, truth, false)
}

/// The answer of runs whose steps are halved until their bound resolves the solution and, where it does not hold `truth`, until
/// their differences fall as errors of `order` do: before, they predict nothing, and what falls by a lower order, as beside a jump of f,
/// has no bound that is known. `at_once`, a bound is all that is wanted.
fn refined(
    first: usize,
    sampled: impl Fn(usize) -> Result<Vec<Vec<f64>>, Gap>,
    order: f64,
    rounding: impl Fn(f64, usize) -> f64,
    times: &[f64],
    truth: Option<&Answer>,
    at_once: bool,
) -> Result<Answer, Gap> {
    let horizon = times[times.len() - 1];
    let (mut steps, mut coarse) = (first, sampled(first)?);
    let (mut before, mut earlier) = (None, None);
    let mut resolved_before = false;
    loop {
        steps *= 2;
        let states = sampled(steps)?;
        let (difference, size) = (largest_distance(&coarse, &states), largest(&states));
        let floor = rounding(size, steps);
        let observed: Option<f64> = before.map(|before: f64| (before / difference).log2());
        // Once it may be by accident, as where a jump falls into a step; a higher order than the bound's makes that wider.
        let has_order =
            |(now, before): (f64, f64)| now.min(before) >= order - SETTLED && (now - before).abs() <= SETTLED;
        // So may two runs be one, where a jump falls into the same half of both steps.
        let rests = difference <= floor && before.is_some_and(|before: f64| before <= floor);
        let is_settled = rests || observed.zip(earlier).is_some_and(has_order);
        let bound = 2.0 * difference / (order.exp2() - 1.0) + floor;
        let runs = Runs { h: horizon / steps as f64, order, observed, earlier, is_settled, at_once: !resolved_before };
        let answer = Answer { states, bound, astray: None, runs: Some(runs) };
        let is_resolved = bound <= RESOLVED * size;
        let is_told = truth.is_none_or(|truth| is_near(&answer, truth)) || is_settled;
        if is_resolved && is_told || at_once || steps > MOST_STEPS {
            return Ok(answer);
        }
        if is_resolved {
            resolved_before = true;
        }
        (before, earlier) = (Some(difference), observed);
        coarse = answer.states;
    }
}

/// The largest component of all states.
fn largest(states: &[Vec<f64>]) -> f64 {
    states.iter().map(|v| max_norm(v)).largest()
}

/// The name of the truth for `solver` and its answer, another solver's; `None` where nothing was solved.
fn truth(
    problem: &dyn Problem,
    limit: &Limit<'_>,
    times: &[f64],
    solved: &[Solved],
    solver: &str,
) -> Option<(String, Answer)> {
    let exact: Option<Vec<Vec<f64>>> = times.iter().map(|t| (limit.exact)(*t)).collect();
    let tabulated = || times.iter().map(|t| problem.tabulated(*t)).collect::<Option<Vec<_>>>();
    let known = exact.map(|states| ("exact", states)).or_else(|| Some(("tabulated", tabulated()?)));
    if let Some((name, states)) = known {
        // A few elementary functions, each to an ulp or two, of numbers no larger than the largest state.
        let bound = 16.0 * f64::EPSILON * largest(&states);
        return Some((name.into(), Answer { states, bound, astray: None, runs: None }));
    }
    let references = solved.iter().filter(|(name, _)| name != solver && reference::by_name(name).is_some());
    let answered = references.filter_map(|(name, answer)| answer.as_ref().ok().map(|answer| (name, answer)));
    let (name, best) = answered.min_by(|a, b| a.1.bound.total_cmp(&b.1.bound))?;
    Some((name.clone(), Answer { states: best.states.clone(), bound: best.bound, astray: None, runs: None }))
}

/// What the problem shows of states, with a bound on the error of that: what is shown is an affine function of the state, so that its
/// error is at most that of the state times the largest sum of the sizes of what unit states add to a component.
fn shown(problem: &dyn Problem, times: &[f64], answer: Answer) -> Answer {
    let states: Vec<_> = times.iter().zip(&answer.states).map(|(t, state)| problem.observe(*t, state)).collect();
    if states == answer.states {
        return answer;
    }
    let (t, mut unit) = (times[times.len() - 1], vec![0.0; answer.states[0].len()]);
    let without = problem.observe(t, &unit);
    let mut sums = vec![0.0; without.len()];
    for i in 0..unit.len() {
        unit[i] = 1.0;
        let with = problem.observe(t, &unit);
        sums.iter_mut().zip(with.iter().zip(&without)).for_each(|(sum, (a, b))| *sum += (a - b).abs());
        unit[i] = 0.0;
    }
    Answer { states, bound: answer.bound * max_norm(&sums), ..answer }
}

/// The decision on one answer.
fn judge(answer: &Result<Answer, Gap>, truth: Option<&Answer>) -> (Standing, String) {
    let (answer, truth) = match (answer, truth) {
        (Err(Gap::NotRun(reason)), _) => return (Standing::NotRun, format!("not run: {reason}")),
        (Err(Gap::BrokeDown(reason)), _) => return (Standing::Astray, reason.clone()),
        // What gave no answer disagrees with nothing, and agrees with nothing.
        (Err(Gap::Failed(reason)), _) => return (Standing::Undecided, format!("failed: {reason}")),
        (Ok(_), None) => return (Standing::Undecided, "there is nothing to compare with".into()),
        (Ok(answer), Some(truth)) => (answer, truth),
    };
    let bound = answer.bound + truth.bound;
    let near = is_near(answer, truth);
    let resolved = bound <= RESOLVED * largest(&truth.states);
    match (near && resolved, answer.astray) {
        (true, None) => (Standing::Agrees, agreement(answer)),
        (true, Some(Breakdown { reason, is_certain: true })) => {
            (Standing::Unforeseen, format!("agrees, against what is declared: {reason}"))
        }
        (true, Some(Breakdown { reason, .. })) => {
            (Standing::Unresolved, format!("agrees: what is declared does not show within this horizon, that {reason}"))
        }
        (false, Some(Breakdown { reason, .. })) => (Standing::Astray, format!("goes astray, as declared: {reason}")),
        (false, None) if near => (Standing::Unresolved, too_wide(answer, RESOLVED * largest(&truth.states))),
        (false, None) => match answer.runs.filter(|runs| !runs.is_settled) {
            Some(runs) => (Standing::Unresolved, unsettled(&runs)),
            None => (Standing::Differs, difference(answer)),
        },
    }
}

/// An agreement, with the step that it takes where longer ones would not do.
fn agreement(answer: &Answer) -> String {
    match answer.runs.filter(|runs| !runs.at_once) {
        Some(Runs { h, .. }) => {
            format!("agrees with h = {}; in longer steps its errors are not yet those of its order", significant(h, 2))
        }
        None => "agrees".into(),
    }
}

/// A disagreement, with the order of the runs where it is not the one that the bound is taken with.
fn difference(answer: &Answer) -> String {
    let told = "differs by more than the bounds allow";
    let other = answer.runs.and_then(|Runs { order, observed, .. }| Some((order, observed?)));
    match other.filter(|(order, observed)| (order - observed).abs() > SETTLED) {
        Some((order, observed)) => {
            format!("{told}, of an order {}: its runs differ by order {}", trimmed(order, 3), decimals(observed, 1))
        }
        None => told.into(),
    }
}

/// A bound that decides nothing, with the step that should bring it to `wanted`.
fn too_wide(answer: &Answer, wanted: f64) -> String {
    let told = "agrees, but the bounds are too wide to tell";
    let step = answer.runs.map(|Runs { h, order, .. }| (h, h * (wanted / answer.bound).powf(order.recip())));
    match step.filter(|(h, should)| *should > 0.0 && should < h) {
        Some((h, should)) => format!("{told} at h = {}; h = {} should do", significant(h, 2), significant(should, 1)),
        None => told.into(),
    }
}

/// Runs whose differences predict no error.
fn unsettled(Runs { h, order, observed, earlier, .. }: &Runs) -> String {
    let by = match (earlier, observed) {
        (Some(earlier), Some(observed)) => format!("orders {} and {}", decimals(*earlier, 1), decimals(*observed, 1)),
        (None, Some(observed)) => format!("order {}", decimals(*observed, 1)),
        _ => "no order".into(),
    };
    format!(
        "not resolved at h = {}: its runs differ by {by}, not by {}, so that they bound no error; smaller steps may tell, or a solution \
         that is smooth",
        significant(*h, 2),
        trimmed(*order, 3)
    )
}

/// Takes back what was decided by references where solvers disagree of which no bound knows what it does not see, and says why.
fn doubt(
    problem: &dyn Problem,
    horizon: f64,
    parting: Option<&str>,
    solved: &[Solved],
    rows: &mut [Compared],
) -> Option<String> {
    let is_by_reference =
        |row: &Compared| row.truth.as_deref().is_some_and(|truth| reference::by_name(truth).is_some());
    if !rows.iter().any(|row| row.standing == Standing::Differs && is_by_reference(row)) {
        return None;
    }
    let note = overlooked(problem, horizon)
        .or_else(|| parting.map(str::to_owned))
        .or_else(|| problem.facts().model.and_then(|_| contradicted(solved, rows)))?;
    let is_told = |row: &&mut Compared| matches!(row.standing, Standing::Agrees | Standing::Differs);
    for row in rows.iter_mut().filter(is_told).filter(|row| is_by_reference(row)) {
        row.standing = Standing::Unresolved;
        row.status = "not resolved: the references are in doubt".into();
    }
    Some(note)
}

/// That f changes by itself faster than steps see: a solver that passes over it and one that does not are each within bounds that know
/// nothing of it.
fn overlooked(problem: &dyn Problem, horizon: f64) -> Option<String> {
    let stops: Vec<f64> = (1..=STEPS).map(|step| horizon * step as f64 / STEPS as f64).collect();
    let changes = changes(problem, horizon, &stops);
    let (first, last) = (changes.first()?, changes.last()?);
    Some(format!(
        "The references are in doubt: from t = {} to t = {} f changes by itself faster than {STEPS} steps see, and solvers that choose their steps \
         may pass over it, within bounds that do not know. A shorter time about it tells.",
        significant(*first, 5),
        significant(*last, 5)
    ))
}

/// That the methods of fixed steps agree against the references: at least two of them, with each other and none with the truth.
///
/// That is for models, where methods and references share f. Elsewhere f is stated twice, and such methods are wrong together.
fn contradicted(solved: &[Solved], rows: &[Compared]) -> Option<String> {
    let by_steps = |standing: Standing| -> Vec<(&str, &Answer)> {
        let answers = solved.iter().zip(rows).filter(|(_, row)| row.standing == standing);
        let answers = answers.filter_map(|((name, answer), _)| Some((name.as_str(), answer.as_ref().ok()?)));
        answers.filter(|(_, answer)| answer.runs.is_some()).collect()
    };
    let against = by_steps(Standing::Differs);
    let agree = against.iter().enumerate().all(|(i, (_, a))| against[..i].iter().all(|(_, b)| is_near(a, b)));
    if against.len() < 2 || !agree || !by_steps(Standing::Agrees).is_empty() {
        return None;
    }
    let names: Vec<&str> = against.iter().map(|(name, _)| *name).collect();
    Some(format!(
        "The references are in doubt: {} agree with each other, and no method of fixed steps agrees with the references. Steps that are \
         chosen may pass over what f does for a moment; a shorter time tells.",
        names.join(", ")
    ))
}

/// Whether an answer is within its bound and the truth's.
fn is_near(answer: &Answer, truth: &Answer) -> bool {
    largest_distance(&answer.states, &truth.states) <= answer.bound + truth.bound
}

/// Of the momenta that an equation may have beside v closed forms know nothing.
fn largest_distance(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| common_distance(a, b)).largest()
}

#[cfg(test)]
mod tests {
    use lsvi::Integrator;

    use super::*;
    use crate::method::{self, BuildError, Traits};
    use crate::problem;

    /// How an answer with a bound stands where the truth is 1 exactly.
    fn standing_where(astray: Option<Breakdown>, answer: f64, bound: f64) -> Standing {
        let truth = Answer { states: vec![vec![1.0]], bound: 0.0, astray: None, runs: None };
        judge(&Ok(Answer { states: vec![vec![answer]], bound, astray, runs: None }), Some(&truth)).0
    }

    #[test]
    fn only_a_small_bound_can_agree() {
        let standing = |answer, bound| standing_where(None, answer, bound);
        assert_eq!(standing(1.001, 2e-3), Standing::Agrees);
        assert_eq!(standing(1.003, 2e-3), Standing::Differs);
        assert_eq!(standing(f64::NAN, 2e-3), Standing::Differs);
        assert_eq!(standing(5e19, 9.8e19), Standing::Unresolved);
        assert_eq!(standing(1.0, f64::INFINITY), Standing::Unresolved);
        assert_eq!(standing(1.0, f64::NAN), Standing::Differs);
    }

    #[test]
    fn two_digits_are_the_least_that_resolves_a_solution_and_the_truth_has_a_bound_too() {
        assert_eq!(standing_where(None, 1.0, 9e-3), Standing::Agrees);
        assert_eq!(standing_where(None, 1.0, 2e-2), Standing::Unresolved);
        let judged = |bound| {
            let truth = Answer { states: vec![vec![1.0]], bound, astray: None, runs: None };
            judge(&Ok(Answer { states: vec![vec![1.003]], bound: 2e-3, astray: None, runs: None }), Some(&truth)).0
        };
        assert_eq!([0.0, 2e-3].map(judged), [Standing::Differs, Standing::Agrees]);
        assert_eq!(judged(0.05), Standing::Unresolved, "the truth itself is known to less than two digits");
    }

    /// A difference counts in whichever component and at whichever time it is.
    #[test]
    fn a_difference_in_one_component_at_one_time_is_one() {
        let of = |states: Vec<Vec<f64>>, bound: f64| Answer { states, bound, astray: None, runs: None };
        let right = vec![vec![1.0, 2.0, 3.0]; 2];
        let judged = |states: Vec<Vec<f64>>| judge(&Ok(of(states, 1e-3)), Some(&of(right.clone(), 1e-3))).0;
        assert_eq!(judged(right.clone()), Standing::Agrees);
        for (k, i) in [0, 1].into_iter().flat_map(|k| [0, 1, 2].map(|i| (k, i))) {
            let mut states = right.clone();
            states[k][i] += 3e-3;
            assert_eq!(judged(states), Standing::Differs, "component {i} at time {k}");
        }
    }

    /// The two digits are those of the largest component of the truth.
    #[test]
    fn what_resolves_a_solution_is_in_proportion_to_its_size() {
        let of = |bound: f64, runs: Option<Runs>| {
            let truth = Answer { states: vec![vec![100.0, 1.0]], bound: 0.0, astray: None, runs: None };
            judge(&Ok(Answer { states: vec![vec![100.0, 1.0]], bound, astray: None, runs }), Some(&truth))
        };
        assert_eq!([0.9, 1.1].map(|bound| of(bound, None).0), [Standing::Agrees, Standing::Unresolved]);
        // A hundred times too wide: a tenth of the step of second order.
        let runs = Runs { h: 0.1, order: 2.0, observed: None, earlier: None, is_settled: true, at_once: true };
        let (standing, status) = of(100.0, Some(runs));
        assert!(standing == Standing::Unresolved && status.ends_with("at h = 0.10; h = 0.01 should do"), "{status}");
    }

    #[test]
    fn a_reference_that_is_not_compiled_in_is_not_run_and_any_other_error_is_a_failure() {
        assert!(matches!(Gap::from(ReferenceError::Unavailable("cvode-bdf")), Gap::NotRun(_)));
        assert!(matches!(Gap::from(ReferenceError::Input("none".into())), Gap::Failed(_)));
        let stopped = ReferenceError::Solver { solver: "cvode-bdf", t: 1.0, reason: "none".into() };
        assert!(matches!(Gap::from(stopped), Gap::Failed(_)));
    }

    /// The bound is twice what two runs predict, and the prediction is the error where it falls with the order.
    #[test]
    fn the_bound_of_a_method_is_twice_its_error() {
        let found = compare("logistic", &*problem::build("logistic", &[]).expect("known"), Vec::new(), &[]);
        for solver in ["trapezoidal", "implicit-euler"] {
            let row = found.solvers.iter().find(|row| row.solver == solver).expect("it applies");
            let ratio = row.bound.expect("a bound") / row.difference.expect("a difference");
            assert!((ratio - 2.0).abs() < 0.1, "{solver}: {ratio}");
        }
    }

    #[test]
    fn the_truth_is_the_best_of_the_other_references() {
        let problem = problem::build("van-der-pol", &[]).expect("known");
        let times = [0.3];
        let answer = |bound| Ok(Answer { states: vec![vec![bound, 0.0]], bound, astray: None, runs: None });
        let names: Vec<&str> = reference::all().iter().map(|reference| reference.name()).collect();
        let solved: Vec<Solved> =
            names.iter().zip([2e-9, 1e-9, 3e-9]).map(|(name, bound)| ((*name).to_owned(), answer(bound))).collect();
        let truth_for = |solver: &str| {
            truth(&*problem, &problem.limit(Principle::Equation), &times, &solved, solver).expect("a truth").0
        };
        assert_eq!(truth_for("method-i"), names[1]);
        assert_eq!(truth_for(names[1]), names[0], "not itself");
    }

    /// A declared failure must happen, if it must within the horizon.
    #[test]
    fn what_must_go_astray_is_unforeseen_if_it_agrees_and_what_may_is_left_open() {
        let astray = |is_certain, answer, bound| {
            standing_where(Some(Breakdown { reason: "it must", is_certain }), answer, bound)
        };
        assert_eq!(astray(true, 1.001, 2e-3), Standing::Unforeseen);
        assert_eq!(astray(false, 1.001, 2e-3), Standing::Unresolved);
        for is_certain in [true, false] {
            assert_eq!(astray(is_certain, 1.003, 2e-3), Standing::Astray);
            assert_eq!(astray(is_certain, 5e19, 9.8e19), Standing::Astray);
        }
    }

    /// How `method` stands on a problem, beside the exact solution or a library's, with its difference and bound.
    fn stands(name: &str, set: (&str, &str), method: &dyn Method) -> (Standing, String, [f64; 2]) {
        let problem = problem::build(name, &[(set.0.to_owned(), set.1.to_owned())]).expect("known");
        let times: Vec<f64> = (1..=SAMPLES).map(|k| problem.horizon() * k as f64 / SAMPLES as f64).collect();
        let limit = problem.limit(method.principle());
        let library = reference::by_name("diffsol-tsit45").expect("always built");
        let library = by_reference(library, &*problem, &limit, &times);
        let solved = [("diffsol-tsit45".to_owned(), library)];
        let (_, truth) = truth(&*problem, &limit, &times, &solved, "").expect("a truth");
        let answer = by_method(&*problem, method, &times, Some(&truth));
        let (standing, status) = judge(&answer, Some(&truth));
        let sizes = answer.map_or([f64::NAN; 2], |it| [largest_distance(&it.states, &truth.states), it.bound]);
        (standing, status, sizes)
    }

    fn named(name: &str) -> Box<dyn Method> {
        method::parse(name).expect("known")
    }

    #[test]
    fn a_growth_that_has_no_time_to_show_is_neither_a_disagreement_nor_a_pass() {
        let (standing, status, _) = stands("cavity", ("cells", "2"), &*named("conventional"));
        assert_eq!(standing, Standing::Unresolved, "{status}");
        assert!(status.contains("does not show within this horizon"), "{status}");
    }

    /// A method that solves an equation of its own, whatever it is asked for.
    #[derive(Debug)]
    struct Elsewhere(&'static dyn Problem);

    impl Method for Elsewhere {
        fn name(&self) -> String {
            "elsewhere".into()
        }
        fn traits(&self) -> Traits {
            Traits::new(2, Principle::Equation, Stability::Neutral)
        }
        fn build<'a>(&self, _: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
            method::parse("trapezoidal").expect("known").build(self.0)
        }
    }

    /// A method that is said to have another order than its own.
    #[derive(Debug)]
    struct Labelled(Box<dyn Method>, u32);

    impl Method for Labelled {
        fn name(&self) -> String {
            "labelled".into()
        }
        fn traits(&self) -> Traits {
            Traits { order: self.1, ..self.0.traits() }
        }
        fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
            self.0.build(problem)
        }
    }

    /// A method that is said to have solutions of its own that grow.
    #[derive(Debug)]
    struct Growing(Box<dyn Method>);

    impl Method for Growing {
        fn name(&self) -> String {
            "growing".into()
        }
        fn traits(&self) -> Traits {
            Traits { stability: Stability::Unstable, ..self.0.traits() }
        }
        fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
            self.0.build(problem)
        }
    }

    #[test]
    fn what_is_declared_of_a_method_goes_with_its_answer_however_its_steps_are_chosen() {
        let problem = problem::build("cavity", &[("cells".into(), "2".into())]).expect("known");
        for name in ["trapezoidal", "radau-adaptive"] {
            let is_astray = |method: &dyn Method| {
                let Ok(answer) = by_method(&*problem, method, &[0.5 * problem.horizon(), problem.horizon()], None)
                else {
                    panic!("{name} runs")
                };
                answer.astray.is_some()
            };
            assert_eq!([is_astray(&*named(name)), is_astray(&Growing(named(name)))], [false, true], "{name}");
        }
    }

    /// Before errors fall as h² they predict nothing, and a finer step tells.
    #[test]
    fn a_method_before_its_asymptotic_range_is_no_disagreement() {
        for solver in ["fitted(4.0)", "fitted-pade(4.0)"] {
            let (standing, status, _) = stands("logistic", ("lambda", "10"), &*named(solver));
            assert!(matches!(standing, Standing::Agrees | Standing::Unresolved), "{solver}: {status}");
            assert!(status.contains("h = "), "{solver}: {status}");
        }
    }

    #[test]
    fn a_method_that_converges_to_something_else_disagrees() {
        for lambda in ["10.001", "11"] {
            let other = problem::build("logistic", &[("lambda".into(), lambda.into())]).expect("known");
            let (standing, status, _) = stands("logistic", ("lambda", "10"), &Elsewhere(Box::leak(other)));
            assert_eq!(standing, Standing::Differs, "{lambda}: {status}");
        }
    }

    /// An order that is claimed too high makes the bound too small: nothing is known but that it is not that order.
    #[test]
    fn runs_that_fall_by_a_lower_order_than_the_bound_decide_nothing() {
        let labelled = Labelled(named("trapezoidal"), 4);
        let (standing, status, _) = stands("logistic", ("lambda", "1"), &labelled);
        assert_eq!(standing, Standing::Unresolved, "{status}");
        assert!(status.contains("its runs differ by orders 2.0 and 2.0, not by 4"), "{status}");
    }

    /// A jump at a part θ of a step leaves an error h θ, whatever the order, and θ of halved steps follows no rule; twice in succession
    /// two of these do not fall by one order.
    #[test]
    fn a_jump_of_f_is_not_resolved() {
        let run = |steps: usize| {
            let h = 1.0 / steps as f64;
            Ok(vec![vec![1.0 + h * (0.1 * std::f64::consts::SQRT_2 / h).fract()]])
        };
        let truth = Answer { states: vec![vec![1.0]], bound: 1e-12, astray: None, runs: None };
        for order in [1.0, 4.0] {
            let Ok(answer) = refined(STEPS, run, order, |_, _| 0.0, &[1.0], Some(&truth), false) else {
                panic!("it runs")
            };
            let (standing, status) = judge(&Ok(answer), Some(&truth));
            assert!(matches!(standing, Standing::Unresolved | Standing::Agrees), "order {order}: {status}");
        }
    }

    /// Against a reference that all methods of fixed steps contradict with one voice nothing is decided; one that follows it, or two
    /// that contradict each other, leave it as it is.
    #[test]
    fn a_reference_that_methods_agree_against_is_in_doubt() {
        let answer = |value: f64, is_method: bool| {
            let runs = Runs { h: 0.1, order: 2.0, observed: None, earlier: None, is_settled: true, at_once: true };
            Ok(Answer { states: vec![vec![value]], bound: 1e-3, astray: None, runs: is_method.then_some(runs) })
        };
        let file = tempfile::NamedTempFile::with_suffix(".ds").expect("a file");
        std::fs::write(file.path(), "u_i { x = 1 } F_i { 0*x }").expect("writable");
        let model = problem::model::Model::load(file.path(), &[], None).expect("a model");
        let doubted = |values: &[f64]| {
            let references = [1.0, 1.0].into_iter().map(|value| ("reference", answer(value, false)));
            let methods = values.iter().map(|value| ("method", answer(*value, true)));
            let solved: Vec<Solved> =
                references.chain(methods).map(|(name, answer)| (name.to_owned(), answer)).collect();
            let truth = Answer { states: vec![vec![1.0]], bound: 1e-9, astray: None, runs: None };
            let row = |(solver, answer): &Solved| {
                let (standing, status) = judge(answer, Some(&truth));
                let (solver, truth) = (solver.clone(), Some("diffsol-bdf".to_owned()));
                Compared { equation: ("", ""), solver, truth, difference: None, bound: None, standing, status }
            };
            let mut rows: Vec<Compared> = solved.iter().map(row).collect();
            let note = doubt(&model, 1.0, None, &solved, &mut rows);
            let open = rows.iter().filter(|row| row.standing == Standing::Unresolved).count();
            assert_eq!(note.is_some(), open > 0);
            open
        };
        assert_eq!(doubted(&[1.25, 1.2501, 1.2499]), 5);
        assert_eq!([doubted(&[1.25]), doubted(&[1.25, 1.25, 1.0]), doubted(&[1.25, 1.3])], [0, 0, 0]);
    }

    /// What is said of an answer whose runs differ by another order than that of its bound.
    #[test]
    fn orders_that_do_not_settle_are_told() {
        let answer = |order: f64, observed: Option<f64>, earlier: Option<f64>, bound: f64| {
            let runs = Runs { h: 0.1, order, observed, earlier, is_settled: false, at_once: false };
            Answer { states: vec![vec![1.0]], bound, astray: None, runs: Some(runs) }
        };
        let plain = "differs by more than the bounds allow";
        assert_eq!(difference(&answer(2.0, Some(2.2), None, 0.0)), plain);
        assert_eq!(difference(&answer(2.0, None, None, 0.0)), plain);
        for observed in [1.0, 3.0] {
            let told = difference(&answer(2.0, Some(observed), None, 0.0));
            assert_eq!(told, format!("{plain}, of an order 2: its runs differ by order {observed:.1}"));
        }
        // A hundred times too wide: a tenth of the step of second order. What would take a longer one is not named.
        let wide = "agrees, but the bounds are too wide to tell";
        assert_eq!(too_wide(&answer(2.0, None, None, 1.0), 1e-2), format!("{wide} at h = 0.10; h = 0.01 should do"));
        assert_eq!(too_wide(&answer(2.0, None, None, 1.0), 2.0), wide);
        assert_eq!(too_wide(&answer(2.0, None, None, f64::INFINITY), 1e-2), wide);
        let by = |observed, earlier| unsettled(&answer(2.0, observed, earlier, 0.0).runs.expect("runs"));
        assert!(by(Some(1.0), Some(0.5)).contains("its runs differ by orders 0.5 and 1.0, not by 2,"));
        assert!(by(Some(1.0), None).contains("its runs differ by order 1.0, not by 2,"));
        assert!(by(None, None).contains("its runs differ by no order, not by 2,"));
    }

    #[test]
    fn a_bound_that_is_too_wide_names_the_step_that_should_do() {
        let (standing, status, _) = stands("logistic", ("lambda", "10"), &*named("conventional"));
        assert_eq!(standing, Standing::Unresolved, "{status}");
        assert!(status.contains("at h = 1.2e-4; h = 6e-5 should do"), "{status}");
    }

    /// Runs with errors of (h/H)^p: the bound is twice that of the finer one, whatever p.
    #[test]
    fn the_bound_of_any_solver_is_taken_with_its_order() {
        for order in [1.0_f64, 2.0, 3.0, 4.0] {
            let run = |steps: usize| Ok(vec![vec![1.0 + (STEPS as f64 / steps as f64).powf(order) * 1e-4]]);
            let Ok(answer) = refined(STEPS, run, order, |_, _| 0.0, &[1.0], None, false) else { panic!("it runs") };
            let bound = 2.0 * (answer.states[0][0] - 1.0);
            assert!((answer.bound / bound - 1.0).abs() < 1e-6, "order {order}: {} for {bound}", answer.bound);
        }
    }

    /// Apart by 10⁻⁸, 10⁻⁵, 10⁻¹ and 1 at intervals of ½: a growth of 10⁴ is one of e^{18.42 t}, if the bounds know of it.
    #[test]
    fn where_the_references_part_is_told_with_the_rate_and_the_last_time_before() {
        let told = |off: [f64; 4], bound: f64| {
            let answer = |off: [f64; 4]| {
                let states = off.iter().map(|off| vec![1.0 + off]).collect();
                ("a reference".to_owned(), Ok(Answer { states, bound, astray: None, runs: None }))
            };
            parting(&[0.5, 1.0, 1.5, 2.0], &[answer([0.0; 4]), answer(off)])
        };
        let off = [1e-8, 1e-5, 1e-1, 1.0];
        for (bound, why) in [(1.0, "grow like e^(18.42 t)"), (1e-9, "has passed over")] {
            let note = told(off, bound).expect("they part");
            for said in ["by 1.0e-5 at t = 1, by 1.0e-1 at t = 1.5", why] {
                assert!(note.contains(said), "{said}: {note}");
            }
            assert!(note.ends_with("Compare up to t = 1."), "{note}");
        }
        assert!(!told(off, 1e-9).expect("they part").contains("grow"));
        // Neither a slow growth nor none is the equation's.
        assert_eq!([told([1e-2, 2e-2, 3e-2, 4e-2], 1.0), told([1e-9; 4], 1.0)], [None, None]);
    }

    /// An explicit method with growing errors of its own, as `conventional` has, parts from the references where these agree.
    #[test]
    fn what_methods_differ_by_puts_no_reference_in_doubt() {
        let file = tempfile::NamedTempFile::with_suffix(".ds").expect("a file");
        let of = |rate: &str, horizon: f64| {
            std::fs::write(file.path(), format!("u_i {{ x = 1 }} F_i {{ {rate} }}")).expect("writable");
            problem::model::Model::load(file.path(), &[], Some(horizon)).expect("a model")
        };
        let wrong: Box<dyn Method> =
            Box::new(Elsewhere(Box::leak(problem::build_setting("linear-drag lambda=1.1").expect("known"))));
        let found = compare("decay", &of("-x", 40.0), vec![wrong], &[]);
        assert!(found.notes.is_empty(), "{:?}", found.notes);
        let differs: Vec<&str> =
            found.solvers.iter().filter(|row| row.standing == Standing::Differs).map(|row| &*row.solver).collect();
        assert_eq!(differs, ["elsewhere"]);
        // Of a rest at all samples nothing is seen of the way there; what rests from the start has no way.
        let horizons = [("-x", 40.0), ("2 - x", 400.0), ("1 - x", 400.0)].map(|(rate, t)| before_rest(&of(rate, t)));
        assert_eq!(horizons, [40.0, 100.0 / 4.0, 400.0]);
    }

    /// Errors of the state within its bound, with the worst signs for each component shown, come to the bound of what is shown.
    #[test]
    fn the_bound_of_what_is_shown_is_met_by_the_worst_errors_of_the_state() {
        let (problem, bound) = (problem::small("shear-layer").expect("registered"), 1e-3);
        let (state, times) = (problem.initial(), [problem.horizon()]);
        let answer = Answer { states: vec![state.clone()], bound, astray: None, runs: None };
        let of = shown(&*problem, &times, answer);
        let observe = |state: &[f64]| problem.observe(times[0], state);
        let moved =
            |by: &dyn Fn(usize) -> f64| -> Vec<f64> { state.iter().enumerate().map(|(i, v)| v + by(i)).collect() };
        let here = observe(&state);
        assert_eq!(of.states, std::slice::from_ref(&here));
        let parts: Vec<Vec<f64>> = (0..state.len())
            .map(|i| {
                observe(&moved(&|j| if i == j { 1.0 } else { 0.0 })).iter().zip(&here).map(|(a, b)| a - b).collect()
            })
            .collect();
        let worst = (0..here.len()).map(|r| {
            let there = observe(&moved(&|i| bound * parts[i][r].signum()));
            (there[r] - here[r]).abs()
        });
        approx::assert_relative_eq!(of.bound, worst.largest(), max_relative = 1e-9);
    }

    /// A hundredth of the tolerance leaves less than a thirtieth of the error, a tenth of it leaves more than that.
    #[test]
    fn an_adaptive_answer_is_far_more_accurate_than_its_bound() {
        let problem = problem::build("van-der-pol", &[]).expect("known");
        let method = named("radau-adaptive");
        let times: Vec<f64> = (1..=SAMPLES).map(|k| 0.5 * k as f64).collect();
        let Ok(answer) = by_tolerance(&*problem, &*method, &times) else { panic!("it runs") };
        let truth = method.tightened(1e4).expect("adaptive");
        let to = |t: &f64| run(&*problem, &*truth, 0.1, *t, |_| {}).expect("it runs").end.q;
        let error = largest_distance(&answer.states, &times.iter().map(to).collect::<Vec<_>>());
        assert!(0.0 < error && error < answer.bound / 30.0, "{error:e} beside {:e}", answer.bound);
    }

    #[test]
    fn an_exact_truth_is_known_to_roundings() {
        let problem = problem::build("logistic", &[]).expect("known");
        let (name, truth) =
            truth(&*problem, &problem.limit(Principle::Equation), &[0.5, 1.0], &[], "").expect("a truth");
        assert!(name == "exact" && truth.bound > 0.0 && truth.bound < 1e-14, "{name}: {}", truth.bound);
    }

    #[test]
    fn what_is_not_made_for_stiff_problems_is_not_run_on_them() {
        let problem = problem::build("robertson", &[]).expect("known");
        let limit = problem.limit(Principle::Equation);
        for reference in reference::all().into_iter().filter(|it| !it.stiff_ok()) {
            let answer = by_reference(reference, &*problem, &limit, &[1.0]);
            assert!(matches!(answer, Err(Gap::NotRun(_))), "{}", reference.name());
        }
    }
}
