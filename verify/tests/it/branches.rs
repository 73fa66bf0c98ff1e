//! No step of a least-squares method returns a root of another branch than the one that starts at the present state. The equations are
//! set up from the action in balls of 57 digits, which share no code with the steps, and the branch is proved piece by piece.

mod action;
mod follow;

use action::{Action, Closure, Equations, Field};
use follow::{Followed, follow, only_root};
use lsvi::closure::{Linear, LinearClosure};
use lsvi::quadrature::Quadrature;
use lsvi::{SolveError, StepError};
use rayon::prelude::*;
use verify::kinds::Principle;
use verify::problem::Problem;
use verify::run::{RunError, run};
use verify::{method, problem};

/// A method for states of size `size`, and its equations.
struct Case {
    name: Box<dyn Fn(f64) -> String + Send + Sync>,
    action: Action,
    /// For states of size 1.
    closure: Closure,
}

fn case(name: &str, action: Action, closure: Closure) -> Case {
    let name = name.to_owned();
    Case { name: Box::new(move |_| name.clone()), action, closure }
}

/// Of a number of nodes.
type Rule = fn(usize) -> Result<Quadrature, lsvi::InputError>;

/// Every least-squares method and closure that has a name.
fn cases(all: bool) -> Vec<Case> {
    let mut cases = Vec::new();
    let constant = |name: &str, alpha: f64, beta: f64| case(name, Action::pieces(1), Closure::Constant(alpha, beta));
    cases.extend([
        constant("method-i", 0.0, 1.0),
        constant("method-ii", -1.0, 1.0),
        constant("explicit-momentum", 1.0, 0.0),
        // Its first step has no momentum.
        constant("conventional", 1.0, 0.0),
        constant("linear(-0.5,1.0)", -0.5, 1.0),
        constant("linear(-0.9,1.0)", -0.9, 1.0),
        constant("linear(0.5,1.0)", 0.5, 1.0),
        constant("linear(1.0,0.2)", 1.0, 0.2),
        constant("minimax(0.0,2.0)", Linear::minimax(0.0, 2.0).expect("a range").weights(1.0).alpha, 1.0),
    ]);
    for rate in [0.5, 4.0] {
        let named = |name: &'static str, closure| Case {
            name: Box::new(move |size| format!("{name}({:?})", rate * size)),
            action: Action::pieces(1),
            closure,
        };
        cases.extend([named("fitted-pade", Closure::Pade(rate)), named("fitted", Closure::Exact(rate))]);
    }
    for steps in if all { vec![1, 2, 3, 4] } else { vec![2, 4] } {
        cases.push(case(&format!("window({steps})"), Action::pieces(steps), Closure::Constant(0.0, 1.0)));
    }
    let families: [(&str, Rule); 3] =
        [("gauss", Quadrature::gauss), ("lobatto", Quadrature::lobatto), ("radau", Quadrature::radau)];
    for (family, rule) in families {
        if !all && family == "gauss" {
            continue;
        }
        for degree in 1..=if all { 3 } else { 2 } {
            for nodes in [degree, degree + 1] {
                let Ok(rule) = rule(nodes) else { continue };
                let action = Action::galerkin(degree, rule.nodes(), rule.weights());
                for (suffix, alpha, beta) in [("", 0.0, 1.0), (",ii", -1.0, 1.0), (",-0.5:1.0", -0.5, 1.0)] {
                    let name = format!("ls-galerkin({degree},{family},{nodes}{suffix})");
                    cases.push(case(&name, action.clone(), Closure::Constant(alpha, beta)));
                }
            }
        }
    }
    cases
}

/// Uniform numbers in [0, 1), by Knuth's MMIX generator.
struct Random(u64);

impl Random {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// What comparing live steps with their branches came to.
#[derive(Debug, Default)]
struct Tally {
    right: usize,
    /// Refused as [`SolveError::BranchLost`] beyond the end of the branch.
    lost: usize,
    /// Where the branch could not be followed.
    undecided: Vec<String>,
    /// Refused although the branch goes on.
    refused: Vec<String>,
    /// Refused beyond the end of the branch, but for another reason.
    other: Vec<String>,
    wrong: Vec<String>,
}

impl Tally {
    fn count(&mut self, what: impl Fn() -> String, live: &Result<f64, RunError>, truth: Followed, size: f64) {
        match (truth, live) {
            (Followed::Undecided(_), _) => self.undecided.push(what()),
            (Followed::To(root, error), Ok(found)) if (found / size - root).abs() <= error => self.right += 1,
            (Followed::To(..), Err(_)) => self.refused.push(what()),
            (Followed::To(..) | Followed::Lost(_), Ok(_)) => self.wrong.push(what()),
            (Followed::Lost(_), Err(RunError::Step(StepError::Solve { source, .. }))) => match source {
                SolveError::BranchLost { .. } => self.lost += 1,
                _ => self.other.push(what()),
            },
            (Followed::Lost(_), Err(_)) => self.other.push(what()),
        }
    }

    fn and(mut self, other: Self) -> Self {
        self.right += other.right;
        self.lost += other.lost;
        self.undecided.extend(other.undecided);
        self.refused.extend(other.refused);
        self.other.extend(other.other);
        self.wrong.extend(other.wrong);
        self
    }
}

/// Live steps of a method from starts of any size against the branch of the same step from ±1: v̇ = a v − v² does the same to states
/// and rates of any size.
fn compare(case: &Case, (name, start, field): &(&str, f64, Field), steps: usize, seed: u64) -> Tally {
    let (start, field) = (*start, *field);
    let mut random = Random(seed);
    // One in each of equal parts of the range, so that both sides of an end of size 1 have some.
    let part = |i: usize| -2.0 + 4.0 * i as f64 / steps as f64;
    let sizes: Vec<f64> = (0..steps).map(|i| 10.0_f64.powf(random.within(part(i), part(i + 1)))).collect();
    let equations = Equations { action: case.action.clone(), closure: case.closure, field, start };
    let truths = match field.b {
        0.0 => sizes.iter().map(|s| only_root(&equations, *s)).collect(),
        _ => follow(&equations, &sizes),
    };
    let mut tally = Tally::default();
    for (s, truth) in sizes.iter().zip(truths) {
        // A power of two scales without rounding.
        let size = random.within(-10.0, 10.0).round().exp2();
        let set = |name: &str, value: f64| (name.to_owned(), format!("{value:?}"));
        let (problem, rate): (Box<dyn Problem>, f64) = match *name {
            "quadratic-drag" => {
                let problem = problem::build(name, &[set("v0", start * size)]);
                (problem.expect("registered"), size)
            }
            "logistic" => (problem::build(name, &[set("v0", start), set("lambda", size)]).expect("registered"), size),
            _ => {
                let settings = [set("v0", start), set("lambda", -field.a * size)];
                (problem::build(name, &settings).expect("registered"), size)
            }
        };
        let unit = if *name == "quadratic-drag" { size } else { 1.0 };
        let method = method::parse(&(case.name)(rate)).expect("registered");
        let h = s / rate;
        let live = run(&*problem, &*method, h, h * case.action.steps as f64, |_| {}).map(|run| run.end.q[0]);
        let what = || {
            format!(
                "{} on {name} from {}, h = {h}: {live:?}, and the branch {truth:?} at {s}",
                method.name(),
                start * unit
            )
        };
        tally.count(what, &live, truth, unit);
    }
    tally
}

#[test]
fn a_step_returns_the_root_of_its_branch_or_is_refused_beyond_its_end() {
    let steps: Option<usize> =
        std::env::var("VERIFY_BRANCHES").ok().map(|text| text.parse().expect("a number of steps"));
    let cases = cases(steps.is_some());
    let drag = Field { a: 0.0, b: -1.0 };
    let logistic = Field { a: 1.0, b: -1.0 };
    let linear = |a| Field { a, b: 0.0 };
    let runs = [
        ("quadratic-drag", 1.0, drag),
        ("quadratic-drag", -1.0, drag),
        ("logistic", 0.1, logistic),
        ("logistic", 0.75, logistic),
        ("logistic", 1.5, logistic),
        ("linear-drag", 1.0, linear(-1.0)),
        ("linear-drag", 1.0, linear(0.3)),
    ];
    let pairs: Vec<(usize, &Case, usize)> = (0..runs.len())
        .flat_map(|run| cases.iter().enumerate().map(move |(seed, case)| (run, case, seed)))
        // One unknown and algebraic weights: those are followed to the end, and in seconds.
        .filter(|(run, case, _)| {
            let is_short = case.action.unknowns() == 1 && !matches!(case.closure, Closure::Exact(_));
            steps.is_some() || (is_short && [0, 2, 5].contains(run))
        })
        .collect();
    let tally = pairs
        .into_par_iter()
        .map(|(run, case, seed)| compare(case, &runs[run], steps.unwrap_or(STEPS), seed as u64))
        .reduce(Tally::default, Tally::and);
    let Tally { right, lost, undecided, refused, other, wrong } = tally;
    println!("{right} right, {lost} lost, {} undecided:\n{}", undecided.len(), undecided.join("\n"));
    for (what, list) in [("wrong", wrong), ("refused", refused), ("lost for another reason", other)] {
        assert!(list.is_empty(), "{} {what}:\n{}", list.len(), list.join("\n"));
    }
    // In several unknowns, or with a fit of exp that is known in doubles, pieces may become too short to reach the end of a branch.
    assert!(steps.is_some() || undecided.is_empty(), "{} undecided:\n{}", undecided.len(), undecided.join("\n"));
    assert!(right > 0 && lost > 0, "{right} right, {lost} lost");
}

/// Random steps of each method from each start, unless VERIFY_BRANCHES has their number, and asks for all methods and starts.
const STEPS: usize = 4;

/// No least-squares method of the registry is left out where VERIFY_BRANCHES asks for all.
#[test]
fn the_equations_of_every_least_squares_method_are_known() {
    let followed: Vec<String> = cases(false).iter().map(|case| (case.name)(1.0)).collect();
    let (mut missing, mut expected) = (Vec::new(), 0);
    for method in method::examples() {
        let is_ours = matches!(
            method.principle(),
            Principle::MomentumZero
                | Principle::MomentumConserved
                | Principle::MomentumDecaying
                | Principle::EulerLagrange
        );
        expected += usize::from(is_ours);
        if is_ours && !followed.contains(&method.name()) {
            missing.push(method.name());
        }
    }
    assert!(expected > 10 && missing.is_empty(), "{missing:?}");
}
