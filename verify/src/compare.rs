//! Every solver of a problem against every other: methods ↔ exact ↔ CVODE ↔ diffsol.

use rayon::prelude::*;

use crate::kinds::{Principle, Stability};
use crate::measure::decimal::{plain, trimmed};
use crate::measure::norm::{Extremes, distance, max_norm};
use crate::method::Method;
use crate::order::roundoff;
use crate::problem::{Limit, Problem, component_names};
use crate::program::{Program, ProgramError, Request};
use crate::reference::{self, Reference, ReferenceError};
use crate::run::{RunError, run};
use crate::theory::{breakdown, methods_for};

/// Sample times, equally spaced, the last at the horizon.
pub const SAMPLES: usize = 4;

/// Steps of the coarser of a method's two runs, a multiple of [`SAMPLES`]; doubled up to [`MOST_STEPS`] until the bound resolves
/// the solution.
const STEPS: usize = 1024;
const MOST_STEPS: usize = 8 * STEPS;

/// Largest bound, relative to the size of the truth, that an agreement is worth anything with: two digits.
const RESOLVED: f64 = 1e-2;

/// Growth of a distance from one sample to the next that is the equation's and no accident: a distance between two scalars may pass
/// near zero, but not between all pairs of references at once.
const GROWTH: f64 = 100.0;

/// States at the sample times, and a bound on their error.
struct Answer {
    states: Vec<Vec<f64>>,
    bound: f64,
    /// Why it must be wrong, as the problem declares.
    astray: Option<&'static str>,
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
    let horizon = problem.horizon();
    let (mut solvers, mut notes) = (Vec::new(), Vec::new());
    for (limit, methods) in by_equation(problem, own) {
        let times: Vec<f64> = (1..=SAMPLES).map(|k| horizon * k as f64 / SAMPLES as f64).collect();
        let mut solved: Vec<Solved> = reference::all()
            .into_par_iter()
            .map(|reference| (reference.name().to_owned(), by_reference(reference, problem, &limit, &times)))
            .collect();
        notes.extend(parting(&times, &solved));
        solved.par_extend(methods.into_par_iter().map(|method| (method.name(), by_method(problem, &*method, &times))));
        if limit.name == problem.limit(Principle::Equation).name {
            let answers = guests.into_par_iter().map(|guest| (guest.name.clone(), by_program(problem, guest, &times)));
            solved.par_extend(answers);
        }
        for (solver, answer) in &solved {
            let truth = truth(problem, &limit, &times, &solved, solver);
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
    }
    Comparison { problem: name.to_owned(), horizon, solvers, notes }
}

/// Where the references themselves part before the horizon, because the equation magnifies every difference: what is said then.
///
/// Two solutions whose distance grows from d₁ at t₁ to d₂ at t₂ tell the rate ln(d₂/d₁)/(t₂ − t₁) of the growth.
fn parting(times: &[f64], references: &[Solved]) -> Option<String> {
    let answers: Vec<_> = references.iter().filter_map(|(_, answer)| answer.as_ref().ok()).collect();
    let apart = |k: usize| -> f64 {
        let pairs = answers.iter().enumerate().flat_map(|(i, a)| answers[..i].iter().map(move |b| (a, b)));
        pairs.map(|(a, b)| distance(&a.states[k], &b.states[k])).largest()
    };
    let lost = |k: &usize| apart(*k) > RESOLVED * answers.iter().map(|answer| max_norm(&answer.states[*k])).largest();
    let first_lost = (0..times.len()).find(lost)?;
    // From where they part on the distance has no room left to grow.
    let last = first_lost.max(1);
    let growth = apart(last) / apart(last - 1);
    if growth.is_nan() || growth <= GROWTH {
        return None;
    }
    let rate = growth.ln() / (times[last] - times[last - 1]);
    Some(format!(
        "The references part: by {:.1e} at t = {}, by {:.1e} at t = {}. Differences grow like e^({rate:.2} t), and from there on a \
         disagreement says nothing of a solver. Compare up to t = {}.",
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
    Ok(Answer { states: sampled.states, bound, astray: None })
}

fn by_method(problem: &dyn Problem, method: &dyn Method, times: &[f64]) -> Result<Answer, Gap> {
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
    let breakdown = breakdown(problem, method);
    let failed = |error: RunError| match (error, breakdown) {
        (RunError::Build(error), _) => Gap::NotRun(error.to_string()),
        (error, Some(reason)) => Gap::BrokeDown(format!("{error}; as declared: {reason}")),
        (error, None) => Gap::Failed(error.to_string()),
    };
    let cap = problem.limit(method.principle()).order.unwrap_or(f64::INFINITY);
    let order = f64::from(method.order()).min(cap);
    let (mut steps, mut coarse) = (STEPS, sampled(STEPS).map_err(failed)?);
    loop {
        steps *= 2;
        let fine = sampled(steps).map_err(failed)?;
        let predicted = largest_distance(&coarse, &fine) / (2_f64.powf(order) - 1.0);
        let size = largest(&fine);
        let bound = 2.0 * predicted + roundoff(method, size, steps as f64);
        if bound <= RESOLVED * size || breakdown.is_some() || steps > MOST_STEPS {
            return Ok(Answer { states: fine, bound, astray: breakdown });
        }
        coarse = fine;
    }
}

/// A program's bound is that of a method, with no roundings but its own last digits.
fn by_program(problem: &dyn Problem, guest: &Guest, times: &[f64]) -> Result<Answer, Gap> {
    let columns = component_names(problem);
    let horizon = times[times.len() - 1];
    let mut printed = 0.0_f64;
    let mut sampled = |steps: usize| -> Result<Vec<Vec<f64>>, Gap> {
        let request = Request { h: Some(horizon / steps as f64), t_end: Some(horizon), ..guest.request.clone() };
        let answer = guest.program.run(&request, &columns).map_err(|error| Gap::Failed(error.to_string()))?;
        printed = answer.printed.resolution(largest(&answer.states));
        let at = |t: &f64| answer.times.iter().position(|time| (time - t).abs() <= 1e-9 * horizon);
        let found = times.iter().map(|t| at(t).map(|k| answer.states[k].clone()).ok_or(*t));
        found.collect::<Result<_, f64>>().map_err(|t| {
            let h = trimmed(horizon / steps as f64, 9);
            Gap::Failed(format!("it has no row at t = {}, a multiple of its step h = {h}", trimmed(t, 9)))
        })
    };
    let (mut steps, mut coarse) = (STEPS, sampled(STEPS)?);
    loop {
        steps *= 2;
        let fine = sampled(steps)?;
        let size = largest(&fine);
        let predicted = largest_distance(&coarse, &fine) / (2_f64.powf(guest.order) - 1.0);
        let bound = 2.0 * predicted + f64::EPSILON * size * steps as f64;
        if bound <= RESOLVED * size || steps > MOST_STEPS {
            return Ok(Answer { states: fine, bound: bound + printed, astray: None });
        }
        coarse = fine;
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
        return Some((name.into(), Answer { states, bound, astray: None }));
    }
    let references = solved.iter().filter(|(name, _)| name != solver && reference::by_name(name).is_some());
    let answered = references.filter_map(|(name, answer)| answer.as_ref().ok().map(|answer| (name, answer)));
    let (name, best) = answered.min_by(|a, b| a.1.bound.total_cmp(&b.1.bound))?;
    Some((name.clone(), Answer { states: best.states.clone(), bound: best.bound, astray: None }))
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
    let near = largest_distance(&answer.states, &truth.states) <= bound;
    let resolved = bound <= RESOLVED * largest(&truth.states);
    match (near && resolved, answer.astray) {
        (true, None) => (Standing::Agrees, "agrees".into()),
        (true, Some(reason)) => (Standing::Unforeseen, format!("agrees, against what is declared: {reason}")),
        (false, Some(reason)) => (Standing::Astray, format!("goes astray, as declared: {reason}")),
        (false, None) if near => (Standing::Unresolved, "agrees, but the bounds are too wide to tell".into()),
        (false, None) => (Standing::Differs, "differs by more than the bounds allow".into()),
    }
}

fn largest_distance(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| distance(a, b)).largest()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem;

    /// How an answer with a bound stands where the truth is 1 exactly.
    fn standing_where(astray: Option<&'static str>, answer: f64, bound: f64) -> Standing {
        let truth = Answer { states: vec![vec![1.0]], bound: 0.0, astray: None };
        judge(&Ok(Answer { states: vec![vec![answer]], bound, astray }), Some(&truth)).0
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
            let truth = Answer { states: vec![vec![1.0]], bound, astray: None };
            judge(&Ok(Answer { states: vec![vec![1.003]], bound: 2e-3, astray: None }), Some(&truth)).0
        };
        assert_eq!([0.0, 2e-3].map(judged), [Standing::Differs, Standing::Agrees]);
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
        let answer = |bound| Ok(Answer { states: vec![vec![bound, 0.0]], bound, astray: None });
        let names: Vec<&str> = reference::all().iter().map(|reference| reference.name()).collect();
        let solved: Vec<Solved> =
            names.iter().zip([2e-9, 1e-9, 3e-9]).map(|(name, bound)| ((*name).to_owned(), answer(bound))).collect();
        let truth_for = |solver: &str| {
            truth(&*problem, &problem.limit(Principle::Equation), &times, &solved, solver).expect("a truth").0
        };
        assert_eq!(truth_for("method-i"), names[1]);
        assert_eq!(truth_for(names[1]), names[0], "not itself");
    }

    /// A declared failure must happen.
    #[test]
    fn what_must_go_astray_is_unforeseen_if_it_agrees() {
        let astray = |answer, bound| standing_where(Some("it must"), answer, bound);
        assert_eq!(astray(1.001, 2e-3), Standing::Unforeseen);
        assert_eq!(astray(1.003, 2e-3), Standing::Astray);
        assert_eq!(astray(5e19, 9.8e19), Standing::Astray);
    }
}
