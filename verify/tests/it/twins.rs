//! Models of the built-in problems: every method that both can run takes the same steps on either, for the same work.

use std::ops::ControlFlow;
use std::path::Path;

use lsvi::{State, Work};
use rayon::prelude::*;
use verify::kinds::Principle;
use verify::measure::norm::{Extremes, distance, larger, max_norm};
use verify::method::adaptive::{DEFAULT_ATOL, DEFAULT_RTOL};
use verify::method::{self, Method};
use verify::problem::model::Model;
use verify::problem::{self, Problem};
use verify::run::{RunError, run_from};

/// Parameters beside the default ones.
const OTHERS: &[(&str, &str, &str)] = &[
    ("quadratic-drag", "lambda", "-1"),
    ("quadratic-drag", "v0", "3"),
    ("logistic", "v0", "0.7"),
    ("logistic", "v0", "1.5"),
    ("van-der-pol", "mu", "2"),
    ("van-der-pol", "mu", "5"),
    ("prothero-robinson", "lambda", "10"),
    ("kepler", "eccentricity", "0.2"),
];

/// The model that states the built-in problem `name`.
fn twin(name: &str, set: &[(String, String)]) -> Model {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let own = root.join("tests/twins").join(name).with_extension("ds");
    let path = if own.exists() { own } else { root.join("models").join(name).with_extension("ds") };
    Model::load(&path, set, None).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The states and the work of a run.
type Steps = Result<(Vec<State>, Work), RunError>;

fn steps(problem: &dyn Problem, start: &[f64], method: &dyn Method, [h, t_end]: [f64; 2]) -> Steps {
    let mut all = Vec::new();
    let run = run_from(problem, start.to_vec(), method, h, t_end, |state, _| {
        all.push(state.clone());
        ControlFlow::Continue(())
    });
    run.map(|run| (all, run.work))
}

/// The largest factor by which two runs part from one step to a later one, at least 1, while they are further apart than roundings are.
fn parting(a: &[State], b: &[State]) -> f64 {
    let apart: Vec<f64> = a.iter().zip(b).map(|(a, b)| distance(&a.q, &b.q)).collect();
    let from = (0..apart.len()).filter(|i| apart[*i] > 1e-4 * apart[0]);
    from.map(|i| apart[i..].iter().copied().largest() / apart[i]).fold(1.0, larger)
}

/// What compares a model with the problem that it states.
struct Pair {
    model: Model,
    built_in: Box<dyn Problem>,
}

impl Pair {
    fn new(name: &str, set: &[(String, String)]) -> Self {
        let built_in = problem::build(name, &[problem::small_settings(name), set.to_vec()].concat()).expect("known");
        let model = twin(name, set);
        assert_eq!(problem::component_names(&model), problem::component_names(&*built_in), "{name}");
        // A few elementary functions.
        let (found, expected) = (model.initial(), built_in.initial());
        assert!(distance(&found, &expected) <= 4.0 * f64::EPSILON * larger(1.0, max_norm(&expected)), "{name}");
        Self { model, built_in }
    }

    /// Whether both can be stepped by the method: a Lagrangian of one's own and mechanics are no part of a model.
    fn admits(&self, method: &dyn Method) -> bool {
        let of_equation = method.principle() == Principle::Equation;
        (of_equation || self.built_in.own_lagrangian().is_none()) && method.build(&self.model).is_ok()
    }

    /// What the iterations of a step leave, three hundredths of what is tolerated, where one of the two alone says to be linear and has no
    /// need of them.
    fn left(&self, method: &dyn Method, size: f64) -> f64 {
        let differ = self.model.field().is_linear() != self.built_in.field().is_linear();
        let is_adaptive = method.tightened(2.0).is_some();
        if differ && is_adaptive { 0.03 * (DEFAULT_ATOL + DEFAULT_RTOL * size) } else { 0.0 }
    }

    /// What is wrong with the model's run, where both end; that neither or one alone does is an error of `None`.
    fn compare(&self, method: &dyn Method, grid: [f64; 2]) -> Result<bool, String> {
        let start = self.built_in.initial();
        let size = larger(max_norm(&start), f64::MIN_POSITIVE);
        let nudged: Vec<f64> = start.iter().enumerate().map(|(i, v)| v + 1e-7 * size * [1.0, -0.7][i % 2]).collect();
        let ((found, work), (expected, due)) =
            match [&self.model as &dyn Problem, &*self.built_in].map(|it| steps(it, &start, method, grid)) {
                [Ok(found), Ok(expected)] => (found, expected),
                [Err(_), Err(_)] => return Ok(false),
                [found, expected] => {
                    return Err(format!("one alone ends: {:?} {:?}", found.err(), expected.err()));
                }
            };
        let size = expected.iter().map(|state| max_norm(&state.q)).largest();
        // Steps that are chosen go by estimates that may be roundings of each other: they end elsewhere, but for the last.
        let is_at = |a: &State, b: &State| (a.t - b.t).abs() <= 4.0 * f64::EPSILON * b.t;
        let at_once = found.iter().zip(&expected).filter(|(a, b)| is_at(a, b));
        let apart = at_once.map(|(a, b)| distance(&a.q, &b.q)).largest();
        let ends = found.last().zip(expected.last()).is_some_and(|(a, b)| is_at(a, b));
        // A few roundings in each step, which part by as much as neighbours do; where they need not part no neighbour is run.
        let roundings = (4.0 * f64::EPSILON * size + self.left(method, size)) * expected.len() as f64;
        let factor =
            || steps(&*self.built_in, &nudged, method, grid).map_or(1.0, |(beside, _)| parting(&beside, &expected));
        let rounding = if apart <= roundings { roundings } else { roundings * factor() };
        let takes_more = |more: u64, than: u64| more > 2 * than;
        let agrees = found.len() == expected.len() && ends && apart <= rounding;
        if !agrees {
            return Err(format!(
                "{apart:e} apart where roundings are {rounding:e}, in {} and {} steps",
                found.len(),
                expected.len()
            ));
        }
        if takes_more(work.residuals, due.residuals) || takes_more(work.factorizations, due.factorizations) {
            return Err(format!("it takes {work:?}, and the built-in problem {due:?}"));
        }
        Ok(true)
    }
}

/// All problems but the flows, by all methods, in long steps and in short ones.
#[test]
fn a_model_is_solved_like_the_built_in_problem_that_it_states() {
    let registered: Vec<_> = method::ALL.iter().flat_map(|spec| spec.examples).collect();
    let methods: Vec<_> = registered.into_iter().map(|name| method::parse(name).expect("registered")).collect();
    let defaults = problem::paired().map(|spec| (spec.name, Vec::new()));
    let others = OTHERS.iter().map(|(name, key, value)| (*name, vec![((*key).to_owned(), (*value).to_owned())]));
    // The last test of all, which leaves no other thread to do.
    let settings: Vec<_> = defaults.chain(others).collect();
    let found: Vec<_> = settings.par_iter().map(|(name, set)| compare_all(name, set, &methods)).collect();
    let faults: Vec<_> = found.iter().flat_map(|(faults, _)| faults).map(String::as_str).collect();
    let compared: u32 = found.iter().map(|(_, compared)| compared).sum();
    assert!(faults.is_empty(), "{} of {compared}:\n{}", faults.len(), faults.join("\n"));
    assert!(compared > 1000, "only {compared} runs were compared");
}

/// What is wrong with runs of the model of a problem, and how many were compared.
fn compare_all(name: &str, set: &[(String, String)], methods: &[Box<dyn Method>]) -> (Vec<String>, u32) {
    let (mut faults, mut compared) = (Vec::new(), 0);
    let pair = Pair::new(name, set);
    let window = pair.built_in.facts().window;
    // A step of 28 unknowns takes as long as hundreds of others, and one that fails most of all.
    let (parts, steps): (&[f64], _) = if pair.built_in.ode().dim() > 12 && !pair.model.ode().is_sparse() {
        (&[0.5], 3.0)
    } else {
        (&[2.0, 0.5], 8.0)
    };
    for method in methods.iter().filter(|method| pair.admits(&***method)) {
        for h in parts.iter().map(|part| part * window.coarsest) {
            match pair.compare(&**method, [h, window.horizon.min(steps * h)]) {
                Ok(both_end) => compared += u32::from(both_end),
                Err(fault) => faults.push(format!("{name} {set:?} {} h = {h}: {fault}", method.name())),
            }
        }
    }
    (faults, compared)
}
