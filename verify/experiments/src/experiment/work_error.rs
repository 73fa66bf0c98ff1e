//! Work and error of methods with fixed steps, of the adaptive method, and of the references, each on the same equations.

use std::time::Instant;

use lsvi::adaptive::Tolerances;
use rayon::prelude::*;

use super::{Context, Experiment, StudyError};
use crate::kinds::Principle;
use crate::measure::norm::{Extremes, common_distance, max_norm};
use crate::method::{self, Method};
use crate::problem::{self, Problem};
use crate::reference::{self, Reference, ReferenceError};
use crate::run::run;
use crate::theory::methods_for;

/// What is run.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    /// Methods with fixed steps; those that do not apply to the problem are left out.
    pub methods: &'static [&'static str],
    /// Steps in a run of theirs.
    pub steps: &'static [u32],
    /// Tolerances of the others: 10 to the minus so many halves.
    pub halves: &'static [i32],
}

/// One run.
#[derive(Debug, Clone)]
pub struct Point {
    /// The method or reference.
    pub solver: String,
    /// Whether it is a reference.
    pub is_reference: bool,
    /// The step size or the tolerance.
    pub setting: f64,
    /// Steps.
    pub steps: u64,
    /// Evaluations of f: as many for each evaluation of its step equations as a method has stages.
    pub evaluations: u64,
    /// Factorizations.
    pub factorizations: u64,
    /// Largest error of a component at the end.
    pub error: f64,
    /// What the run took, beside others.
    pub seconds: f64,
}

/// What is found.
#[derive(Debug, Clone, Default)]
pub struct Found {
    /// The runs, solver by solver. One that breaks off is left out.
    pub points: Vec<Point>,
    /// Why references are absent.
    pub absent: Vec<String>,
    /// What times of runs are, solver by solver, where they were asked for.
    pub times: Vec<Times>,
}

impl Found {
    /// The runs of each solver.
    pub fn by_solver(&self) -> impl Iterator<Item = &[Point]> {
        self.points.chunk_by(|a, b| a.solver == b.solver)
    }

    /// Of each method, or of each reference, the run with the least work whose error is `target` at most; the least of all first.
    pub fn ranked(&self, of_references: bool, target: f64, work: fn(&Point) -> u64) -> Vec<&Point> {
        let solvers = self.by_solver().filter(|runs| runs[0].is_reference == of_references);
        let mut best: Vec<&Point> =
            solvers.filter_map(|runs| runs.iter().filter(|p| p.error <= target).min_by_key(|p| work(p))).collect();
        best.sort_by_key(|point| work(point));
        best
    }
}

/// How long a solver takes for an accuracy.
#[derive(Debug, Clone)]
pub struct Times {
    /// The solver.
    pub solver: String,
    /// Whether it is a reference.
    pub is_reference: bool,
    /// Seconds of repeated runs of the same kind, ascending.
    pub seconds: Vec<f64>,
}

/// A problem to its end.
#[derive(Debug, Clone)]
pub struct WorkError {
    /// The problem with its parameters; its small version where there are none.
    pub problem: &'static str,
    /// The end.
    pub horizon: f64,
    /// What is run.
    pub plan: Plan,
    /// The error at which times are taken.
    pub timed_at: Option<f64>,
}

impl Experiment for WorkError {
    const ID: &'static str = "work-error";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        context.announce(1);
        let is_set = self.problem.contains(' ');
        let problem = if is_set { problem::build_setting(self.problem)? } else { problem::small(self.problem)? };
        let mut found = measure(&*problem, self.horizon, self.plan)?;
        if let Some(target) = self.timed_at {
            found.times = time(&*problem, self.horizon, target, &found)?;
        }
        context.tick();
        Ok(found)
    }
}

/// Work and error on `problem` at time `horizon`.
///
/// # Errors
/// If a name or number of the plan is unusable, or the truth is not known.
pub fn measure(problem: &dyn Problem, horizon: f64, plan: Plan) -> Result<Found, StudyError> {
    let mut found = Found::default();
    let truth = |principle| -> Result<Vec<f64>, StudyError> {
        let states = solution(problem, principle, &[horizon])?.states;
        Ok(states.into_iter().next().ok_or("a solution at the horizon")?)
    };
    let suited: Vec<String> = methods_for(problem).iter().map(|method| method.name()).collect();
    for name in plan.methods {
        let method = method::parse(name)?;
        if !suited.contains(&method.name()) {
            continue;
        }
        let truth = truth(method.principle())?;
        let runs = plan.steps.par_iter().filter_map(|steps| {
            let h = horizon / f64::from(*steps);
            own(problem, &*method, h, (h, horizon), &truth)
        });
        found.points.extend(runs.collect::<Vec<_>>());
    }
    let truth = truth(Principle::Equation)?;
    for half in plan.halves {
        let method = adaptive(tolerance(*half))?;
        found.points.extend(own(problem, &*method, tolerance(*half), (horizon, horizon), &truth));
    }
    for reference in suited_references(problem) {
        for half in plan.halves {
            match peer(reference, problem, horizon, tolerance(*half), &truth) {
                Ok(point) => found.points.push(point),
                Err(error @ ReferenceError::Unavailable(_)) => {
                    found.absent.push(error.to_string());
                    break;
                }
                // Beyond what the solver can do.
                Err(_) => {}
            }
        }
    }
    Ok(found)
}

fn tolerance(half: i32) -> f64 {
    10_f64.powf(-0.5 * f64::from(half))
}

fn adaptive(tolerance: f64) -> Result<Box<dyn Method>, StudyError> {
    let method = method::parse("radau-adaptive")?.with_tolerances(Tolerances::new(tolerance, tolerance)?);
    Ok(method.ok_or("it is adaptive")?)
}

fn suited_references(problem: &dyn Problem) -> impl Iterator<Item = &'static dyn Reference> {
    let is_stiff = problem.is_stiff();
    reference::all().into_iter().filter(move |reference| reference.stiff_ok() || !is_stiff)
}

/// States at some times, and a bound on their errors.
pub(super) struct Solution {
    pub(super) states: Vec<Vec<f64>>,
    /// Of what is known in closed form or tabulated, a few roundings.
    pub(super) bound: f64,
}

/// The solution at increasing `times` of what methods of this principle step: exact, tabulated, or of the reference with the least bound.
pub(super) fn solution(problem: &dyn Problem, principle: Principle, times: &[f64]) -> Result<Solution, StudyError> {
    let limit = problem.limit(principle);
    let known = |t: &f64| (limit.exact)(*t).or_else(|| problem.tabulated(*t));
    if let Some(states) = times.iter().map(known).collect::<Option<Vec<_>>>() {
        let bound = 8.0 * f64::EPSILON * states.iter().map(|state| max_norm(state)).largest();
        return Ok(Solution { states, bound });
    }
    let solved = suited_references(problem).filter_map(|reference| {
        let sampled = reference.solve(limit.ode, 0.0, &limit.initial, times).ok()?;
        Some(Solution { bound: max_norm(&sampled.bound), states: sampled.states })
    });
    let best = solved.min_by(|a, b| a.bound.total_cmp(&b.bound));
    Ok(best.ok_or("neither a solution nor a reference is at hand")?)
}

/// A run with steps of h up to the horizon, under the name of the method; nothing if a step fails.
fn own(
    problem: &dyn Problem,
    method: &dyn Method,
    setting: f64,
    (h, horizon): (f64, f64),
    truth: &[f64],
) -> Option<Point> {
    let found = run(problem, method, h, horizon, |_| {}).ok()?;
    Some(Point {
        solver: method.name(),
        is_reference: false,
        setting,
        steps: found.work.steps,
        evaluations: u64::from(method.traits().stages) * found.work.residuals,
        factorizations: found.work.factorizations,
        error: common_distance(&found.end.q, truth),
        seconds: found.seconds,
    })
}

fn peer(
    reference: &dyn Reference,
    problem: &dyn Problem,
    horizon: f64,
    tolerance: f64,
    truth: &[f64],
) -> Result<Point, ReferenceError> {
    let limit = problem.limit(Principle::Equation);
    let begun = Instant::now();
    let run = reference.run(limit.ode, 0.0, &limit.initial, &[horizon], tolerance)?;
    let seconds = begun.elapsed().as_secs_f64();
    Ok(Point {
        solver: reference.name().into(),
        is_reference: true,
        setting: tolerance,
        steps: run.work.steps,
        evaluations: run.work.rhs,
        factorizations: run.work.factorizations,
        error: run.states.last().map_or(f64::NAN, |state| common_distance(state, truth)),
        seconds,
    })
}

/// Runs of each solver whose time is taken.
const REPEATS: usize = 7;

/// Each solver's fastest run with an error of `target` at most, repeated.
fn time(problem: &dyn Problem, horizon: f64, target: f64, found: &Found) -> Result<Vec<Times>, StudyError> {
    let mut times = Vec::new();
    for runs in found.by_solver() {
        let reached = runs.iter().filter(|p| p.error <= target);
        let Some(point) = reached.min_by(|a, b| a.seconds.total_cmp(&b.seconds)) else { continue };
        let again = || -> Result<f64, StudyError> {
            if let Some(reference) = reference::by_name(&point.solver) {
                return Ok(peer(reference, problem, horizon, point.setting, &[])?.seconds);
            }
            let method = method::parse(&point.solver)?;
            let (method, h) =
                if method.traits().is_adaptive { (adaptive(point.setting)?, horizon) } else { (method, point.setting) };
            Ok(run(problem, &*method, h, horizon, |_| {})?.seconds)
        };
        let mut seconds = (0..REPEATS).map(|_| again()).collect::<Result<Vec<_>, _>>()?;
        seconds.sort_by(f64::total_cmp);
        times.push(Times { solver: point.solver.clone(), is_reference: point.is_reference, seconds });
    }
    Ok(times)
}

/// The components of the solution of `problem` over time, by the adaptive method; up to where it breaks off.
///
/// # Errors
/// If the adaptive method is not there.
pub fn course(problem: &dyn Problem, horizon: f64) -> Result<Vec<(f64, Vec<f64>)>, StudyError> {
    const POINTS: f64 = 300.0;
    let mut states = Vec::new();
    // What has been seen until a failure is the result.
    let _ = run(problem, &*adaptive(1e-6)?, horizon / POINTS, horizon, |state| {
        states.push((state.t, problem.observe(state.t, &state.q)));
    });
    Ok(states)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::{Ode, Run, Work};

    /// A reference that is said to have done this much.
    struct Stub;

    impl Reference for Stub {
        fn name(&self) -> &'static str {
            "stub"
        }
        fn stiff_ok(&self) -> bool {
            true
        }
        fn library(&self) -> Option<String> {
            None
        }
        fn run(&self, _: &dyn Ode, _: f64, v0: &[f64], _: &[f64], _: f64) -> Result<Run, ReferenceError> {
            let mut run = Run::with_capacity(1);
            run.states.push(v0.to_vec());
            run.work = Work { steps: 3, rhs: 20, jacobians: 7, factorizations: 5, products: 11 };
            Ok(run)
        }
    }

    #[test]
    fn the_work_of_a_reference_is_its_own_count() {
        let problem = problem::small("linear-drag").expect("known");
        let point = peer(&Stub, &*problem, 1.0, 1e-3, &problem.initial()).expect("it answers");
        assert_eq!((point.steps, point.evaluations, point.factorizations), (3, 20, 5));
        assert!(point.is_reference && point.setting == 1e-3 && point.error == 0.0, "{point:?}");
    }

    /// RK4 evaluates f four times a step, and the equation of Method I has f at both ends of one.
    #[test]
    fn evaluations_are_those_of_f_and_not_of_the_equations_of_a_step() {
        let problem = problem::small("linear-drag").expect("known");
        let of = |name: &str| {
            let method = method::parse(name).expect("known");
            let equations = run(&*problem, &*method, 0.25, 1.0, |_| {}).expect("linear").work.residuals;
            (own(&*problem, &*method, 0.25, (0.25, 1.0), &[0.0]).expect("linear"), equations)
        };
        let (rk4, _) = of("rk4");
        assert_eq!((rk4.steps, rk4.evaluations), (4, 16));
        let (method_i, equations) = of("method-i");
        assert_eq!(method_i.evaluations, 2 * equations);
    }

    /// No other of these runs can be repeated.
    #[test]
    fn times_are_those_of_the_fastest_run_that_is_accurate_enough() {
        let point = |setting: f64, error: f64, seconds: f64| Point {
            solver: "rk4".into(),
            is_reference: false,
            setting,
            steps: 1,
            evaluations: 4,
            factorizations: 0,
            error,
            seconds,
        };
        let points = vec![point(-1.0, 1e-2, 0.5), point(0.1, 1e-6, 1.0), point(-1.0, 1e-8, 2.0)];
        let found = Found { points, ..Found::default() };
        let problem = problem::small("linear-drag").expect("known");
        let times = time(&*problem, 1.0, 1e-5, &found).expect("steps of 0.1");
        let lengths =
            |times: &[Times]| times.iter().map(|it| (it.solver.clone(), it.seconds.len())).collect::<Vec<_>>();
        assert_eq!(lengths(&times), [("rk4".into(), REPEATS)]);
        assert!(
            time(&*problem, 1.0, 1e-7, &found).is_err() && time(&*problem, 1.0, 1e-9, &found).expect("none").is_empty()
        );
    }
}
