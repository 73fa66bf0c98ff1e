//! Every solver of a problem against every other: methods ↔ exact ↔ CVODE ↔ diffsol.

mod answer;
mod doubt;
mod open;
mod verdict;

use rayon::prelude::*;

use crate::kinds::Principle;
use crate::measure::decimal::{plain, trimmed};
use crate::measure::norm::distance;
use crate::method::Method;
use crate::problem::{Limit, Problem, component_names};
use crate::program::{Program, ProgramError, Request};
use crate::reference;
use crate::theory::methods_for;
use answer::{Answer, STEPS, Solved, by_method, by_program, by_reference, largest, largest_distance, shown};
use doubt::{doubt, parting};
use verdict::judge;

/// Sample times, equally spaced, the last at the horizon.
pub const SAMPLES: usize = 4;

/// Largest bound, relative to the size of the truth, that an agreement is worth anything with: two digits.
const RESOLVED: f64 = 1e-2;

/// Orders that differ by no more are one: two runs predict an error to a fifth where the order of their difference is off by so much.
const SETTLED: f64 = 0.25;

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
    let is_model = problem.facts().model.is_some();
    let near = if is_model { before_rest(problem) } else { problem.horizon() };
    let horizon = if is_model { near } else { problem.far_horizon() };
    let (mut solvers, mut notes) = (Vec::new(), Vec::new());
    if horizon < problem.horizon() {
        notes.push(format!(
            "By t = {} the solution has come to rest, where a method agrees however it went there: compared up to t = {}.",
            plain(horizon),
            plain(horizon)
        ));
    }
    let guests: Vec<&Guest> = guests.iter().collect();
    for (limit, methods) in by_equation(problem, own) {
        let methods: Vec<&dyn Method> = methods.iter().map(|method| &**method).collect();
        let (mut found, told) = among(problem, &limit, horizon, &methods, &guests);
        notes.extend(told);
        notes.extend(again(problem, &limit, [near, horizon], (&methods, &guests), &mut found));
        solvers.extend(found);
    }
    Comparison { problem: name.to_owned(), horizon, solvers, notes }
}

/// Compares what is not resolved up to the later time up to the earlier one, and says so.
fn again(
    problem: &dyn Problem,
    limit: &Limit<'_>,
    [near, far]: [f64; 2],
    (methods, guests): (&[&dyn Method], &[&Guest]),
    found: &mut [Compared],
) -> Option<String> {
    let is_open = |compared: &&mut Compared| matches!(compared.standing, Standing::Unresolved | Standing::Undecided);
    let mut open: Vec<&mut Compared> = if near < far { found.iter_mut().filter(is_open).collect() } else { Vec::new() };
    open.retain(|compared| reference::by_name(&compared.solver).is_none());
    let is_asked = |name: &str| open.iter().any(|compared| compared.solver == name);
    let methods: Vec<&dyn Method> = methods.iter().copied().filter(|method| is_asked(&method.name())).collect();
    let guests: Vec<&Guest> = guests.iter().copied().filter(|guest| is_asked(&guest.name)).collect();
    if open.is_empty() {
        return None;
    }
    let (mut nearer, _) = among(problem, limit, near, &methods, &guests);
    let [near, far] = [near, far].map(|t| trimmed(t, 4));
    let names: Vec<_> = open.iter().map(|compared| compared.solver.clone()).collect();
    for compared in open {
        if let Some(place) = nearer.iter().position(|other| other.solver == compared.solver) {
            let other = nearer.swap_remove(place);
            let status = format!("to t = {near}: {}; to t = {far}: {}", other.status, compared.status);
            *compared = Compared { status, ..other };
        }
    }
    Some(format!("Up to t = {far} these are not resolved, and are compared up to t = {near}: {}.", names.join(", ")))
}

/// Every solver of one equation up to `horizon`, and what is to be known of the references.
fn among(
    problem: &dyn Problem,
    limit: &Limit<'_>,
    horizon: f64,
    methods: &[&dyn Method],
    guests: &[&Guest],
) -> (Vec<Compared>, Option<String>) {
    let times = sample_times(horizon);
    let mut solved: Vec<Solved> = reference::all()
        .into_par_iter()
        .map(|reference| (reference.name().to_owned(), by_reference(reference, problem, limit, &times)))
        .collect();
    // Of the references alone: a wrong method, or one whose errors grow, is no reason to doubt what it is judged by.
    let parting = parting(&times, &solved);
    let known = truth(problem, limit, &times, &solved, "").map(|(_, truth)| truth);
    let by_steps = |method: &&dyn Method| (method.name(), by_method(problem, *method, &times, known.as_ref()));
    solved.par_extend(methods.par_iter().map(by_steps));
    let mut asked: Vec<Solved> = Vec::new();
    if limit.name == problem.limit(Principle::Equation).name {
        let known = known.map(|truth| shown(problem, &times, truth));
        let ask = |guest: &&Guest| (guest.name.clone(), by_program(problem, guest, &times, known.as_ref()));
        asked.par_extend(guests.par_iter().map(ask));
    }
    let of_solved =
        solved.iter().map(|(solver, answer)| (solver, answer, truth(problem, limit, &times, &solved, solver)));
    let of_asked = asked.iter().map(|(guest, answer)| {
        let truth = truth(problem, limit, &times, &solved, "");
        (guest, answer, truth.map(|(name, truth)| (name, shown(problem, &times, truth))))
    });
    let mut solvers = Vec::new();
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
    let told = doubt(problem, horizon, parting.as_deref(), &solved, &mut solvers).or(parting);
    (solvers, told)
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

#[cfg(test)]
mod tests;
