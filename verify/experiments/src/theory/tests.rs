use std::path::{Path, PathBuf};

use nalgebra::DMatrix;

use super::*;
use crate::kinds::Principle;
use crate::measure::norm::distance;
use crate::measure::order::Verdict;
use crate::method::{self, Method};
use crate::order::{OrderError, Source, Truth, measure};
use crate::problem::{self, Problem, Singular, Stiffness};
use crate::reference;
use crate::run::step_from;

/// One example of every method that steps `problem`, and path fitting and collocation where they are the midpoint rule and Gauss's.
fn methods(problem: &dyn Problem) -> Vec<Box<dyn Method>> {
    let more = ["ls-galerkin(2,gauss,2)", "ls-galerkin(1,gauss,1)"];
    let more = more.map(|name| method::parse(name).expect("registered"));
    method::examples().into_iter().chain(more).filter(|method| method.build(problem).is_ok()).collect()
}

/// The state after one step of `h` from `state`.
fn step(problem: &dyn Problem, method: &dyn Method, h: f64, state: &[f64]) -> Vec<f64> {
    step_from(problem, state.to_vec(), method, h).expect("solvable")
}

/// ‖DΦᵀΩDΦ − Ω‖ of a step of `h` from `state`, with DΦ from central differences.
fn defect(problem: &dyn Problem, method: &dyn Method, h: f64, state: &[f64]) -> f64 {
    let (n, e) = (state.len(), 1e-4);
    let mut tangent = DMatrix::zeros(n, n);
    for j in 0..n {
        let moved = |by: f64| {
            let mut state = state.to_vec();
            state[j] += by;
            step(problem, method, h, &state)
        };
        let ends = [moved(-2.0 * e), moved(-e), moved(e), moved(2.0 * e)];
        for i in 0..n {
            tangent[(i, j)] = (ends[0][i] - 8.0 * ends[1][i] + 8.0 * ends[2][i] - ends[3][i]) / (12.0 * e);
        }
    }
    let omega = DMatrix::from_fn(n, n, |i, j| f64::from(i + n / 2 == j) - f64::from(j + n / 2 == i));
    (tangent.transpose() * &omega * tangent - omega).norm()
}

/// Fourth-order differences leave e⁴ = 10⁻¹⁶ of derivatives of a few hundred, and a rounding of 10⁻¹⁵/e, magnified by the
/// coefficients of a path; a method that is not symplectic has a defect of h^{p+1}, h = 0.4, of order p ≤ 4.
#[test]
fn what_is_said_to_be_symplectic_is_and_nothing_else() {
    for name in ["henon-heiles", "double-pendulum", "charged-particle", "damped-pendulum"] {
        let problem = problem::build(name, &[]).expect("registered");
        let state: Vec<f64> = problem.initial().iter().enumerate().map(|(i, x)| x + 0.1 * (i as f64 + 0.5)).collect();
        for method in methods(&*problem) {
            let defect = defect(&*problem, &*method, 0.4, &state);
            let symplectic = is_symplectic(&*problem, &*method).expect("mechanical");
            assert_eq!(defect < 1e-9, symplectic, "{} on {name}: {defect:e}", method.name());
        }
    }
    let logistic = problem::build("logistic", &[]).expect("registered");
    assert_eq!(is_symplectic(&*logistic, &*method::parse("rk4").expect("registered")), None);
}

/// A step, a reversal of the momentum, a step and a reversal lead back to the start, to the rounding of momenta.
#[test]
fn what_is_said_to_be_reversible_is_and_nothing_else() {
    for name in ["henon-heiles", "double-pendulum"] {
        let problem = problem::build(name, &[]).expect("registered");
        let start = problem.initial();
        let turn = |mut state: Vec<f64>| {
            let n = state.len() / 2;
            state[n..].iter_mut().for_each(|p| *p = -*p);
            state
        };
        for method in methods(&*problem) {
            let half = |state: &[f64]| turn(step(&*problem, &*method, 0.4, state));
            let off = distance(&half(&half(&start)), &start);
            assert_eq!(off < 1e-12, method.traits().is_reversible, "{} on {name}: {off:e}", method.name());
        }
    }
}

#[test]
fn a_method_that_restates_another_takes_its_steps() {
    let problem = problem::build("double-pendulum", &[]).expect("registered");
    let start = problem.initial();
    let mut found = 0;
    for method in methods(&*problem) {
        let Some(other) = method.traits().restates else { continue };
        let other = method::parse(&other).expect("registered");
        let ends = [&*method, &*other].map(|method| step(&*problem, method, 0.1, &start));
        // A few roundings, magnified by the coefficients of the path over h.
        assert!(distance(&ends[0], &ends[1]) < 1e-13, "{}", method.name());
        found += 1;
    }
    assert!(found > 0);
}

/// All source files of this crate but those that give methods their names.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("readable").path();
        if path.is_dir() && !path.ends_with("src/method") {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// What is known of a method is in its traits: nothing is guessed from the text of its name.
#[test]
fn no_decision_rests_on_the_text_of_a_name() {
    let names: Vec<String> = method::examples().iter().map(|method| method.name()).collect();
    let is_part = |text: &str| !text.is_empty() && names.iter().any(|name| name.contains(text));
    let literal = |rest: &str| rest.split_once('"').map_or_else(String::new, |(text, _)| text.to_owned());
    let offends = |line: &str| {
        let guesses = ["starts_with(\"", "ends_with(\"", ".contains(\""];
        let guessed = guesses.iter().any(|call| line.split(call).skip(1).any(|rest| is_part(&literal(rest))));
        let compared = [".name() == \"", ".name() != \"", "match method.name()", "matches!(method.name()"];
        guessed || compared.iter().any(|text| line.contains(text))
    };
    let mut files = Vec::new();
    for folder in ["src", "../src", "../evidence/src", "../judge/src"] {
        sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder), &mut files);
    }
    assert!(files.len() > 200);
    for path in files.iter().filter(|path| !path.ends_with("theory/tests.rs")) {
        let text = std::fs::read_to_string(path).expect("readable");
        for (i, line) in text.lines().enumerate() {
            assert!(!offends(line), "{}:{}: {}", path.display(), i + 1, line.trim());
        }
    }
    for guess in ["name.ends_with(\"gauss)\")", "m.starts_with(\"path-fitted\")", "if method.name() == \"rk4\" {"] {
        assert!(offends(guess), "{guess}");
    }
}

/// \[HW96\] IV.15: a stiffly accurate method with stages of order 1 has an error ∝ h/λ, where that is all there is.
#[test]
fn the_stiff_order_of_sdirk2_is_one() {
    let set = |lambda: &str| problem::build("prothero-robinson", &[("lambda".into(), lambda.into())]).expect("valid");
    let method = method::parse("sdirk2").expect("registered");
    let measured = |problem: &dyn Problem| measure(problem, &*method, Truth::Exact).expect("exact");
    let stiff = measured(&*set("1e6"));
    assert!(stiff.verdict == Verdict::Pass && stiff.expected.order == 1.0, "{}", stiff.reason);
    let mild = measured(&*set("1000"));
    assert!(mild.verdict == Verdict::Pass && mild.expected.order == 2.0, "{}", mild.reason);
}

/// What theory gains on special equations is expected there, and nowhere else.
#[test]
fn orders_that_are_gained_are_those_of_theory() {
    for (problem, method, order) in [
        ("poiseuille-ansatz", "method-i", 1.0),
        ("poiseuille-ansatz", "linear(-0.5,1)", 1.0),
        ("poiseuille-ansatz", "linear(1,1)", 2.0),
        ("poiseuille-ansatz", "ls-galerkin(1,gauss,2)", 1.0),
        ("linear-drag", "ls-galerkin(1,gauss,2)", 3.0),
        ("linear-drag", "ls-galerkin(1,radau,2,-0.5:1)", 3.0),
        ("linear-drag", "ls-galerkin(1,gauss,2,1:1)", 4.0),
        ("linear-drag", "ls-galerkin(1,gauss,2,ii)", 2.0),
        ("linear-drag", "ls-galerkin(2,radau,3,ii)", 6.0),
        ("linear-drag", "ls-galerkin(2,gauss,3,1:1)", 4.0),
        ("linear-drag", "ls-galerkin(1,lobatto,2)", 2.0),
        ("damped-pendulum", "ls-galerkin(1,gauss,2)", 2.0),
        ("quadratic-drag", "ls-galerkin(2,gauss,2)", 6.0),
        ("quadratic-drag", "ls-galerkin(1,gauss,1)", 2.0),
        ("logistic", "ls-galerkin(2,gauss,2)", 4.0),
        ("linear-drag", "fitted-pade(1)", 3.0),
        ("linear-drag", "fitted-pade(4)", 2.0),
    ] {
        let problem_of_name = problem::small(problem).expect("registered");
        let method = method::parse(method).expect("registered");
        let truth = Source::default_for(&*problem_of_name, &*method).truth(&*problem_of_name, &*method);
        let measured = measure(&*problem_of_name, &*method, truth).expect("measured");
        let name = method.name();
        let is_right = measured.verdict == Verdict::Pass && measured.expected.order == order;
        assert!(is_right, "{problem} {name} {}: {}", measured.expected.order, measured.reason);
        // What is gained or lost is so beside the nominal order.
        if let Some(declared) = measured.expected.declared {
            assert_eq!(declared.nominal, f64::from(method.order()), "{name}");
        }
    }
}

/// 1.0000001 is no rate of v̇ = −v, and gains no order: at steps that are small enough its error shows.
#[test]
fn a_fitted_rate_beside_that_of_the_problem_gains_no_order() {
    let problem = problem::small("linear-drag").expect("registered");
    let expected = |method: &str| {
        let method = method::parse(method).expect("registered");
        order_plan(&*problem, &*method).expectation.order
    };
    assert_eq!(["fitted-pade(1)", "fitted-pade(1.0000001)"].map(expected), [3.0, 2.0]);
}

/// Where e^{λt} has grown from ε to 1 the method's own solution is as large as the problem's: λt = 36.04.
#[test]
fn a_breakdown_is_certain_once_roundings_have_grown_to_the_solution() {
    for name in ["hires", "prothero-robinson"] {
        let problem = problem::small(name).expect("registered");
        let rate = match problem.facts().stiffness {
            Stiffness::Transient(rate) | Stiffness::Forced(rate) => rate,
            Stiffness::None => panic!("{name} is stiff"),
        };
        let method = method::parse("conventional").expect("registered");
        let is_certain = |growth: f64| breakdown(&*problem, &*method, growth / rate).expect("unstable").is_certain;
        assert_eq!([19.0, 36.0, 36.1].map(is_certain), [false, false, true], "{name}");
    }
}

/// From when on a closure with p₁ = p₀ is said to leave the residual free, det J = 0 along the solution, and not before.
#[test]
fn a_jacobian_is_singular_from_the_declared_time_on() {
    let mut later = 0;
    for spec in problem::paired() {
        let problem = problem::small(spec.name).expect("registered");
        let Some(Singular { from, .. }) = problem.facts().singular else { continue };
        let ode = problem.ode();
        let determinant = |t: f64, v: &[f64]| -> f64 {
            let mut jacobian = DMatrix::<f64>::zeros(v.len(), v.len());
            ode.jacobian(t, v, &mut |i, j, x| jacobian[(i, j)] += x);
            let most: f64 = jacobian.row_iter().map(|row| row.norm()).product();
            jacobian.determinant() / most.max(f64::MIN_POSITIVE)
        };
        let start = problem.limit(Principle::Equation).initial;
        if from == 0.0 {
            assert!(determinant(0.0, &start).abs() < 1e-14, "{}", spec.name);
            continue;
        }
        let times: Vec<f64> = (1..=21).map(|k| 0.05 * f64::from(k) * from).collect();
        let library = reference::by_name("diffsol-bdf").expect("always built");
        let solution = library.solve(ode, 0.0, &start, &times).expect("solvable");
        let signs: Vec<f64> = times.iter().zip(&solution.states).map(|(t, v)| determinant(*t, v).signum()).collect();
        let first = determinant(0.0, &start).signum();
        let (before, then) = signs.split_at(19);
        assert!(before.iter().all(|sign| *sign == first) && then.contains(&-first), "{}: {signs:?}", spec.name);
        later += 1;
    }
    assert_eq!(later, 4);
}

#[test]
fn a_symmetric_system_is_told_from_others() {
    for (name, is) in [
        ("linear-drag", true),
        ("channel-poiseuille", true),
        ("non-normal", false),
        ("prothero-robinson", false),
        ("logistic", false),
        ("robertson", false),
        ("damped-pendulum", false),
    ] {
        assert_eq!(order::is_symmetric(&*problem::small(name).expect("registered")), is, "{name}");
    }
}

/// Where no order should be told, the steps are tried, and one that is told fails.
#[test]
fn an_order_that_should_not_be_told_is_not() {
    let problem = problem::small("hires").expect("registered");
    let method = method::parse("method-ii").expect("registered");
    assert!(order_plan(&*problem, &*method).untold.is_some());
    let told = measure(&*problem, &*method, Truth::Tabulated);
    assert!(matches!(&told, Err(OrderError::Untold { found, .. }) if !found.is_empty()), "{told:?}");
}
