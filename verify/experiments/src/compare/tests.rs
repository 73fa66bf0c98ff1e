use lsvi::Integrator;

use super::answer::{Gap, LARGE, MOST_STEPS, Runs, across_jumps, by_tolerance, refined};
use super::verdict::{difference, unsettled};
use super::*;
use crate::kinds::Stability;
use crate::measure::norm::Extremes;
use crate::method::{self, BuildError, Traits};
use crate::problem;
use crate::reference::ReferenceError;
use crate::run::run;
use crate::theory::Breakdown;

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
    let runs = Runs { h: 0.1, order: 2.0, observed: None, earlier: None, is_settled: true, longer: None };
    let (standing, status) = of(100.0, Some(runs));
    assert!(standing == Standing::Unresolved && status.contains("at h = 0.10, the shortest"), "{status}");
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
    let astray =
        |is_certain, answer, bound| standing_where(Some(Breakdown { reason: "it must", is_certain }), answer, bound);
    assert_eq!(astray(true, 1.001, 2e-3), Standing::Unforeseen);
    assert_eq!(astray(false, 1.001, 2e-3), Standing::Agrees);
    assert_eq!(
        [true, false].map(|is_certain| astray(is_certain, 1.003, 2e-3)),
        [Standing::Astray, Standing::Unresolved]
    );
    for is_certain in [true, false] {
        assert_eq!(astray(is_certain, 1.003, 0.02), Standing::Unresolved, "the bound is too wide");
    }
    // Far is a hundredth of the truth, within bounds of a twentieth.
    for size in [0.01, 1.0, 100.0] {
        let truth = Answer { states: vec![vec![size]], bound: 0.0, astray: None, runs: None };
        let judged = |part: f64| {
            let astray = Some(Breakdown { reason: "it must", is_certain: true });
            let (states, bound) = (vec![vec![size * (1.0 + part)]], 0.05 * size);
            judge(&Ok(Answer { states, bound, astray, runs: None }), Some(&truth)).0
        };
        assert_eq!([0.02, 0.005].map(judged), [Standing::Astray, Standing::Unresolved], "{size}");
    }
    // Beyond all bounds but its own, which grows as it does.
    assert_eq!(astray(true, 5e19, 9.8e19), Standing::Astray);
    assert_eq!(astray(false, 5e19, 9.8e19), Standing::Unresolved);
}

/// How `method` stands on a problem, beside the exact solution or a library's, with its difference and bound.
fn stands(name: &str, set: Option<(&str, &str)>, method: &dyn Method) -> (Standing, String, [f64; 2]) {
    let set: Vec<_> = set.into_iter().map(|(key, value)| (key.to_owned(), value.to_owned())).collect();
    let problem = problem::build(name, &set).expect("known");
    let times: Vec<f64> = (1..=SAMPLES).map(|k| problem.horizon() * k as f64 / SAMPLES as f64).collect();
    let limit = problem.limit(method.principle());
    let library = if problem.is_stiff() { "diffsol-bdf" } else { "diffsol-tsit45" };
    let answer = by_reference(reference::by_name(library).expect("always built"), &*problem, &limit, &times);
    let solved = [(library.to_owned(), answer)];
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
fn a_growth_that_has_no_time_to_show_is_none() {
    let (standing, status, _) = stands("cavity", Some(("cells", "2")), &*named("conventional"));
    assert_eq!(standing, Standing::Agrees, "{status}");
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
            let Ok(answer) = by_method(&*problem, method, &[0.5 * problem.horizon(), problem.horizon()], None) else {
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
        let (standing, status, _) = stands("logistic", Some(("lambda", "10")), &*named(solver));
        assert!(matches!(standing, Standing::Agrees | Standing::Unresolved), "{solver}: {status}");
        assert!(status.contains("h = "), "{solver}: {status}");
    }
}

#[test]
fn a_method_that_converges_to_something_else_disagrees() {
    for lambda in ["10.001", "11"] {
        let other = problem::build("logistic", &[("lambda".into(), lambda.into())]).expect("known");
        let (standing, status, _) = stands("logistic", Some(("lambda", "10")), &Elsewhere(Box::leak(other)));
        assert_eq!(standing, Standing::Differs, "{lambda}: {status}");
    }
}

/// An order that is claimed too high makes the bound too small: nothing is known but that it is not that order.
#[test]
fn runs_that_fall_by_a_lower_order_than_the_bound_decide_nothing() {
    let labelled = Labelled(named("trapezoidal"), 4);
    let (standing, status, _) = stands("logistic", Some(("lambda", "1")), &labelled);
    assert_eq!(standing, Standing::Unresolved, "{status}");
    assert!(status.contains("its runs differ by orders 2.0 and 2.0, not by 4"), "{status}");
}

/// Wherever an order that is claimed too high would have them go on to: they come no nearer.
#[test]
fn runs_that_go_elsewhere_by_a_lower_order_than_claimed_disagree() {
    let beside = |bound: f64, limit: f64, order: f64| {
        let truth = Answer { states: vec![vec![1.0]], bound, astray: None, runs: None };
        let run = |steps: usize| Ok(vec![vec![limit + 0.1 * (STEPS as f64 / steps as f64).powf(order)]]);
        let Ok(answer) = refined(STEPS, run, 4.0, |_, _| 0.0, &[1.0], Some(&truth), MOST_STEPS) else {
            panic!("it runs")
        };
        judge(&Ok(answer), Some(&truth))
    };
    let judged = |limit: f64, order: f64| beside(1e-9, limit, order);
    let (standing, status) = judged(1.2, 1.0);
    assert_eq!(standing, Standing::Differs, "{status}");
    assert!(status.ends_with("of an order 4: its runs differ by order 1.0"), "{status}");
    // They come to it, or may, or may stand still for a while only.
    for (limit, order) in [(1.0, 1.0), (1.02, 1.0), (1.2, 0.4)] {
        assert_eq!(judged(limit, order).0, Standing::Unresolved, "{limit}, {order}");
    }
    // So may they come to a truth that is known to a hundredth: of order 1/2 at least the last two runs, 1/160 apart, are off by 0.030 at most.
    assert_eq!([1e-9, 0.01].map(|bound| beside(bound, 1.029, 1.0).0), [Standing::Differs, Standing::Unresolved]);
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
        let Ok(answer) = refined(STEPS, run, order, |_, _| 0.0, &[1.0], Some(&truth), MOST_STEPS) else {
            panic!("it runs")
        };
        let (standing, status) = judge(&Ok(answer), Some(&truth));
        assert!(matches!(standing, Standing::Unresolved | Standing::Agrees), "order {order}: {status}");
    }
}

/// Wherever it is between two samples, a step of it.
#[test]
fn a_bound_knows_of_a_jump_of_f() {
    for at in [0.4021, 0.9999, 1.9182, 3.9999] {
        let model = problem::model::Model::of_text(
            &format!("u_i {{ c = 0.5 }} F_i {{ -c + 0.3*heaviside(t - {at}) }}"),
            &[],
            Some(4.0),
        )
        .expect("a model");
        let times = [1.0, 2.0, 3.0, 4.0];
        for h in [0.1, 1e-3] {
            let runs = Runs { h, order: 2.0, observed: None, earlier: None, is_settled: true, longer: None };
            let states = times.map(|t: f64| vec![0.5 * (-t).exp()]).to_vec();
            let Answer { bound, .. } =
                across_jumps(&model, &times, Answer { states, bound: 1e-9, astray: None, runs: Some(runs) });
            // Where f is smooth it changes by a little in what the jump is located to.
            assert!((bound / (0.3 * h) - 1.0).abs() < 1e-3, "{at}, {h}: {bound}");
        }
    }
}

/// Against a reference that all methods of fixed steps contradict with one voice nothing is decided; one that follows it, or two
/// that contradict each other, leave it as it is.
#[test]
fn a_reference_that_methods_agree_against_is_in_doubt() {
    let answer = |value: f64, is_method: bool| {
        let runs = Runs { h: 0.1, order: 2.0, observed: None, earlier: None, is_settled: true, longer: None };
        Ok(Answer { states: vec![vec![value]], bound: 1e-3, astray: None, runs: is_method.then_some(runs) })
    };
    let model = problem::model::Model::of_text("u_i { x = 1 } F_i { 0*x }", &[], None).expect("a model");
    let doubted_to = |horizon: f64, problem: &dyn Problem, by: &str, values: &[f64]| {
        let references = [1.0, 1.0].into_iter().map(|value| ("reference", answer(value, false)));
        let methods = values.iter().map(|value| ("method", answer(*value, true)));
        let solved: Vec<Solved> = references.chain(methods).map(|(name, answer)| (name.to_owned(), answer)).collect();
        let truth = Answer { states: vec![vec![1.0]], bound: 1e-9, astray: None, runs: None };
        let row = |(solver, answer): &Solved| {
            let (standing, status) = judge(answer, Some(&truth));
            let (solver, truth) = (solver.clone(), Some(by.to_owned()));
            Compared { equation: ("", ""), solver, truth, difference: None, bound: None, standing, status }
        };
        let mut rows: Vec<Compared> = solved.iter().map(row).collect();
        let note = doubt(problem, horizon, None, &solved, &mut rows);
        let open = rows.iter().filter(|row| row.standing == Standing::Unresolved).count();
        assert_eq!(note.is_some(), open > 0);
        open
    };
    let doubted_on = |problem: &dyn Problem, by: &str, values: &[f64]| doubted_to(1.0, problem, by, values);
    let doubted = |values: &[f64]| doubted_on(&model, "diffsol-bdf", values);
    assert_eq!([doubted(&[1.25, 1.2501]), doubted(&[1.25, 1.2501, 1.2499])], [4, 5]);
    assert_eq!([doubted(&[1.25]), doubted(&[1.25, 1.25, 1.0]), doubted(&[1.25, 1.3])], [0, 0, 0]);
    // A solution that is known, and an f that references state by themselves, leave no such doubt; a pulse leaves some of one method, too.
    assert_eq!(doubted_on(&model, "exact", &[1.25, 1.2501, 1.2499]), 0);
    let drag = problem::build("linear-drag", &[]).expect("known");
    assert_eq!(doubted_on(&*drag, "diffsol-bdf", &[1.25, 1.2501, 1.2499]), 0);
    let pulse =
        problem::model::Model::of_text("u_i { x = 1 } F_i { exp(-1e8*(t - 0.5003)*(t - 0.5003)) - x }", &[], Some(1.0))
            .expect("a model");
    assert_eq!([1.25, 1.0].map(|value| doubted_on(&pulse, "diffsol-bdf", &[value])), [3, 0]);
    // Of what changes all the time steps see most; what acts at a place by less than a hundredth of the solution is not passed over.
    let hill = problem::model::Model::of_text("u_i { x = 1 } F_i { max(t*(1 - t), 0.0) - x }", &[], Some(1.0))
        .expect("a model");
    assert_eq!(doubted_on(&hill, "diffsol-bdf", &[1.25]), 0);
    let late = problem::model::Model::of_text("u_i { x = 1 } F_i { max((t - 6)*(8 - t), 0.0) - x }", &[], Some(10.0))
        .expect("a model");
    assert_eq!(doubted_to(10.0, &late, "diffsol-bdf", &[1.25]), 0);
    let weak = problem::model::Model::of_text(
        "u_i { x = 0 } F_i { 1 + 10*heaviside(x - 0.50035)*heaviside(0.5005 - x) }",
        &[],
        Some(1.0),
    )
    .expect("a model");
    assert_eq!(doubted_on(&weak, "diffsol-bdf", &[1.0]), 0);
    // Nor where a state is zero for a while.
    let late = "heaviside(t - 0.1)*(1 + 10*heaviside(x - 0.50035)*heaviside(0.5005 - x))";
    let late =
        problem::model::Model::of_text(&format!("u_i {{ x = 0 }} F_i {{ {late} }}"), &[], Some(1.0)).expect("a model");
    assert_eq!(doubted_on(&late, "diffsol-bdf", &[1.0]), 0);
    // And by more it is: by a seventh of y, between two of a thousand states, in whatever units.
    for (unit, horizon) in [(1.0, 1.0), (1e-3, 10.0)] {
        let [rate, at, end, pulse] = [1.0 / horizon, 0.50035, 0.5005, 1000.0 / horizon].map(|x| x * unit);
        let f = format!("{rate}, {pulse}*heaviside(x - {at})*heaviside({end} - x)");
        let strong =
            problem::model::Model::of_text(&format!("u_i {{ x = 0, y = {unit} }} F_i {{ {f} }}"), &[], Some(horizon))
                .expect("a model");
        assert_eq!(doubted_to(horizon, &strong, "diffsol-bdf", &[1.0]), 3, "{unit}, {horizon}");
    }
    // Of hundreds of unknowns the runs that would tell take too long.
    let (n, pulse) = (LARGE + 1, "1000*heaviside(x - 0.50035)*heaviside(0.5005 - x)");
    let (u, f) = (format!("x = 0, y = 1, (2:{n}): z = 1"), format!("1, {pulse}, (2:{n}): 0.0"));
    let many =
        problem::model::Model::of_text(&format!("u_i {{ {u} }} F_i {{ {f} }}"), &[], Some(1.0)).expect("a model");
    assert_eq!(doubted_on(&many, "diffsol-bdf", &[1.0]), 0);
}

/// An earlier end would tell no more, and what rests at another value tells.
#[test]
fn a_solution_that_rests_at_zero_decides_nothing() {
    let stands = |x: f64| {
        let answer = || Answer { states: vec![vec![x, 0.0]], bound: 1e-12, astray: None, runs: None };
        judge(&Ok(answer()), Some(&answer()))
    };
    let (standing, status) = stands(0.0);
    assert!(standing == Standing::Unresolved && status.contains("the solution is zero"), "{status}");
    assert_eq!(stands(0.1).0, Standing::Agrees);
}

/// What is said of an answer whose runs differ by another order than that of its bound.
#[test]
fn orders_that_do_not_settle_are_told() {
    let answer = |order: f64, observed: Option<f64>, earlier: Option<f64>, bound: f64| {
        let runs = Runs { h: 0.1, order, observed, earlier, is_settled: false, longer: Some("it is not settled") };
        Answer { states: vec![vec![1.0]], bound, astray: None, runs: Some(runs) }
    };
    let plain = "differs by more than the bounds allow";
    assert_eq!(difference(&answer(2.0, Some(2.2), None, 0.0)), plain);
    assert_eq!(difference(&answer(2.0, None, None, 0.0)), plain);
    for observed in [1.0, 3.0] {
        let told = difference(&answer(2.0, Some(observed), None, 0.0));
        assert_eq!(told, format!("{plain}, of an order 2: its runs differ by order {observed:.1}"));
    }
    let by = |observed, earlier| unsettled(&answer(2.0, observed, earlier, 0.0).runs.expect("runs"));
    assert!(by(Some(1.0), Some(0.5)).contains("its runs differ by orders 0.5 and 1.0, not by 2,"));
    assert!(by(Some(1.0), None).contains("its runs differ by order 1.0, not by 2,"));
    assert!(by(None, None).contains("its runs differ by no order, not by 2,"));
}

#[test]
fn a_bound_that_is_too_wide_names_its_steps() {
    let (standing, status, _) = stands("logistic", Some(("lambda", "10")), &*named("conventional"));
    assert_eq!(standing, Standing::Unresolved, "{status}");
    assert!(status.ends_with("at h = 1.2e-4, the shortest steps taken: an earlier end may tell"), "{status}");
}

/// Runs with errors of (h/H)^p: the bound is twice that of the finer one, whatever p.
#[test]
fn the_bound_of_any_solver_is_taken_with_its_order() {
    for order in [1.0_f64, 2.0, 3.0, 4.0] {
        let run = |steps: usize| Ok(vec![vec![1.0 + (STEPS as f64 / steps as f64).powf(order) * 1e-4]]);
        let Ok(answer) = refined(STEPS, run, order, |_, _| 0.0, &[1.0], None, MOST_STEPS) else { panic!("it runs") };
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
    for (bound, why) in [
        (1.0, "grow like e^(18.42 t)"),
        (0.06, "grow like e^(18.42 t)"),
        (0.04, "has passed over"),
        (1e-9, "has passed over"),
    ] {
        let note = told(off, bound).expect("they part");
        for said in ["by 1.0e-5 at t = 1, by 1.0e-1 at t = 1.5", why] {
            assert!(note.contains(said), "{said}: {note}");
        }
        assert!(note.ends_with("Compare up to t = 1."), "{note}");
    }
    assert!(!told(off, 1e-9).expect("they part").contains("grow"));
    // Of three, two are near each other and the bounds of the third do not know.
    let of = |off: [f64; 2], bound: f64| {
        let states = off.iter().map(|off| vec![1.0 + off]).collect();
        ("a reference".to_owned(), Ok(Answer { states, bound, astray: None, runs: None }))
    };
    let note = parting(&[1.0, 2.0], &[of([0.0, 0.0], 1e-3), of([1e-8, 1e-3], 1e-3), of([1e-8, 1.0], 1e-3)]);
    assert!(note.is_some_and(|note| note.contains("has passed over")));
    // In whatever units.
    for unit in [1e-3, 1e3] {
        let answer = |off: [f64; 4]| {
            let states = off.iter().map(|off| vec![unit * (1.0 + off)]).collect();
            ("a reference".to_owned(), Ok(Answer { states, bound: unit, astray: None, runs: None }))
        };
        let note = parting(&[0.5, 1.0, 1.5, 2.0], &[answer([0.0; 4]), answer(off)]);
        assert!(note.as_ref().is_some_and(|note| note.ends_with("Compare up to t = 1.")), "{unit}: {note:?}");
    }
    // At rest at zero they do not part.
    let from_zero = |end: f64| {
        let answer = Answer { states: vec![vec![0.0], vec![end]], bound: 1e-6, astray: None, runs: None };
        ("a reference".to_owned(), Ok(answer))
    };
    assert_eq!(parting(&[1.0, 2.0], &[from_zero(1.0), from_zero(1.0 + 1e-9)]), None);
    // Neither a slow growth nor none is the equation's.
    assert_eq!([told([1e-2, 2e-2, 3e-2, 4e-2], 1.0), told([1e-9; 4], 1.0)], [None, None]);
}

/// An explicit method with growing errors of its own, as `conventional` has, parts from the references where these agree.
#[test]
fn what_methods_differ_by_puts_no_reference_in_doubt() {
    let of = |rate: &str, horizon: f64| {
        problem::model::Model::of_text(&format!("u_i {{ x = 1 }} F_i {{ {rate} }}"), &[], Some(horizon))
            .expect("a model")
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
    let notes = compare("approach", &of("2 - x", 400.0), Vec::new(), &[]).notes;
    assert!(notes.iter().any(|note| note.starts_with("By t = 25 the solution has come to rest")), "{notes:?}");
}

/// What differs in the end may agree nearer to the start, and differs all the same; only what is not decided there is asked again.
#[test]
fn a_difference_up_to_the_later_time_is_none_to_be_compared_up_to_the_earlier() {
    let problem = problem::build("logistic", &[]).expect("known");
    let limit = problem.limit(Principle::Equation);
    let method = named("trapezoidal");
    for standing in [Standing::Differs, Standing::Agrees, Standing::Unresolved, Standing::Undecided] {
        let mut found = [Compared {
            equation: (limit.name, limit.reason),
            solver: method.name(),
            truth: None,
            difference: None,
            bound: None,
            standing,
            status: String::new(),
        }];
        let note = again(&*problem, &limit, [1.0, 2.0], (&[&*method], &[]), &mut found);
        let is_open = matches!(standing, Standing::Unresolved | Standing::Undecided);
        assert_eq!(note.is_some(), is_open, "{standing:?}: {note:?}");
        assert_eq!(found[0].standing, if is_open { Standing::Agrees } else { standing });
    }
}

/// The rows of a program at the sample times are there to the roundings of sums of steps; a solution that hardly moves agrees at any other.
#[test]
#[cfg(unix)]
fn a_row_beside_a_sample_time_is_none_of_that_time() {
    let problem = problem::build("logistic", &[]).expect("known");
    let horizon = problem.horizon();
    let times = sample_times(horizon);
    let of = |unit: f64, late: f64, value: f64| {
        let times: Vec<f64> = times.iter().map(|t| unit * t).collect();
        let rows: String = times.iter().map(|t| format!("; echo {},{value:.18}", t + late * unit * horizon)).collect();
        let command = format!("sh -c 'echo t,v{rows}'");
        let program = Program::new(&command, std::time::Duration::from_secs(60)).expect("a command");
        let guest = Guest { name: "late".into(), program, request: Request::default(), order: 1.0 };
        by_program(&*problem, &guest, &times, None)
    };
    // A rounding for each step, and half of the last digit, in whatever units.
    assert!(of(1.0, 0.0, 1.0).is_ok_and(|answer| answer.bound >= STEPS as f64 * f64::EPSILON));
    let bound = of(1.0, 0.0, 1.0 / 3e6).map_or(f64::NAN, |answer| answer.bound);
    assert!(bound > 0.0 && bound < 1e-6 / 3e6, "{bound:e}");
    for unit in [1.0, 1e6] {
        for late in [0.0, 1e-12, -1e-12] {
            assert!(of(unit, late, 1.0).is_ok(), "{unit}, {late}");
        }
        for late in [3e-3, -3e-3, 1e-6] {
            assert!(matches!(of(unit, late, 1.0), Err(Gap::Failed(_))), "{unit}, {late}");
        }
    }
}

/// A program whose table depends on how it is asked is asked as it is in all runs.
#[test]
#[cfg(unix)]
fn a_guest_is_asked_for_the_whole_time_in_the_coarsest_steps_by_a_first_run() {
    let problem = problem::build("logistic", &[]).expect("known");
    let horizon = problem.horizon();
    let asked = format!("--h {} --t-end {horizon}", horizon / STEPS as f64);
    let command = format!("sh -c 'case \"$*\" in \"{asked}\") echo t,v;; *) echo t;; esac; echo 0,1' sh");
    let program = Program::new(&command, std::time::Duration::from_secs(60)).expect("a command");
    let guest = Guest { name: "asked".into(), program, request: Request::default(), order: 1.0 };
    assert!(guest.check(&*problem).is_ok());
}

/// Errors of the state within its bound, with the worst signs for each component shown, come to the bound of what is shown.
#[test]
fn the_bound_of_what_is_shown_is_met_by_the_worst_errors_of_the_state() {
    // Vorticities, and velocities with that of a wall, which no state moves.
    for setting in ["shear-layer cells=8", "channel-couette scheme=legendre cells=6"] {
        let (problem, bound) = (problem::build_setting(setting).expect("registered"), 1e-3);
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

/// Of a model a step is a thousandth of the time at most, and of the finer run half of that; both are shorter than v̇ = −v needs.
#[test]
fn the_steps_of_a_finer_answer_are_half_as_long_where_none_may_be_long() {
    let problem = problem::model::Model::of_text("u_i { v = 1 } F_i { -v }", &[], None).expect("a model");
    let method = named("radau-adaptive");
    let Ok(answer) = by_tolerance(&problem, &*method, &[1.0]) else { panic!("it runs") };
    let finer = method.tightened(100.0).expect("adaptive");
    let with = |h: f64| run(&problem, &*finer, h, 1.0, |_| {}).expect("it runs").end.q;
    assert_ne!(with(1e-3), with(5e-4));
    assert_eq!(answer.states, [with(5e-4)]);
}

#[test]
fn an_exact_truth_is_known_to_roundings() {
    let problem = problem::build("logistic", &[]).expect("known");
    let (name, truth) = truth(&*problem, &problem.limit(Principle::Equation), &[0.5, 1.0], &[], "").expect("a truth");
    assert!(name == "exact" && truth.bound > 0.0 && truth.bound < 1e-14, "{name}: {}", truth.bound);
}

/// The answer of a solver that is not made for stiff problems on Prothero and Robinson's at rate λ.
fn explicit_at(lambda: &str) -> Vec<Result<Answer, Gap>> {
    let problem = problem::build("prothero-robinson", &[("lambda".into(), lambda.into())]).expect("known");
    let limit = problem.limit(Principle::Equation);
    let unsuited = reference::all().into_iter().filter(|it| !it.stiff_ok() && it.library().is_some());
    unsuited.map(|reference| by_reference(reference, &*problem, &limit, &[1.0, 2.0])).collect()
}

#[test]
fn what_is_not_made_for_stiff_problems_is_run_on_them_where_it_has_the_steps() {
    for (lambda, rate) in [("1e3", None), ("1e9", Some("2.0e9"))] {
        let answers = explicit_at(lambda);
        assert!(!answers.is_empty());
        for answer in answers {
            match (answer, rate) {
                (Ok(answer), None) => assert!((answer.states[1][0] - 2.0_f64.cos()).abs() <= answer.bound),
                (Err(Gap::NotRun(reason)), Some(rate)) => assert!(reason.contains(&format!("is {rate}:")), "{reason}"),
                _ => panic!("{lambda}"),
            }
        }
    }
}

#[test]
fn what_is_made_for_stiff_problems_is_run_on_them_however_stiff() {
    let problem = problem::build("prothero-robinson", &[("lambda".into(), "1e9".into())]).expect("known");
    let suited = reference::by_name("diffsol-bdf").expect("always built");
    assert!(by_reference(suited, &*problem, &problem.limit(Principle::Equation), &[1.0]).is_ok());
}

/// A step for each life of the fastest rate, 0.04 at the start of Robertson's reaction, costs as many unknowns as there are.
#[test]
fn the_steps_of_what_is_not_made_for_stiff_problems_are_counted_with_their_unknowns() {
    let problem = problem::build("robertson", &[]).expect("known");
    let unsuited = reference::by_name("diffsol-tsit45").expect("always built");
    let answer = by_reference(unsuited, &*problem, &problem.limit(Principle::Equation), &[1e7]);
    assert!(
        matches!(answer, Err(Gap::NotRun(reason)) if reason.contains("is 4.0e5:") && reason.contains("of 3 unknowns"))
    );
}

/// On Robertson's reaction it grows beyond 10¹⁸ before Newton's method fails, which alone would decide nothing.
#[test]
fn what_has_left_the_truth_before_it_fails_has_gone_astray() {
    let problem = problem::build("robertson", &[]).expect("known");
    let method = method::parse("conventional").expect("known");
    let gap = |size: f64| {
        let truth = Answer { states: vec![vec![size, 0.0, 0.0]; 4], bound: 0.0, astray: None, runs: None };
        by_method(&*problem, &*method, &[0.05, 0.1, 0.15, 0.2], Some(&truth)).err()
    };
    let told = |gap: Option<Gap>| match gap {
        Some(Gap::Failed(reason) | Gap::BrokeDown(reason) | Gap::NotRun(reason)) => reason,
        _ => String::new(),
    };
    let grown = |gap: Option<Gap>| {
        let Some(Gap::BrokeDown(reason)) = gap else { return None };
        let grown = reason.strip_prefix("it grows to ").and_then(|rest| rest.split_once(','));
        Some(grown.and_then(|(grown, _)| grown.parse::<f64>().ok()).expect("a number"))
    };
    // Runs of shorter steps grow further, and are made where longer ones have not left the truth behind.
    let mut most = grown(gap(1.0)).expect("it breaks down");
    for _ in 0..4 {
        most = grown(gap(0.02 * most)).unwrap_or(most);
    }
    // Far is a hundred times.
    assert!(matches!(gap(0.005 * most), Some(Gap::BrokeDown(_))), "{most:e}: {}", told(gap(0.005 * most)));
    assert!(matches!(gap(0.02 * most), Some(Gap::Failed(_))), "{most:e}: {}", told(gap(0.02 * most)));
    assert!(matches!(gap(1e300), Some(Gap::Failed(_))), "{}", told(gap(1e300)));
}

/// Of hundreds of unknowns steps are dear.
#[test]
fn a_large_system_is_run_in_longer_steps_first() {
    let times = [0.5, 1.0];
    let steps = |unknowns: usize| {
        let model =
            problem::model::Model::of_text(&format!("u_i {{ (0:{unknowns}): x = 1 }} F_i {{ 0*x_i }}"), &[], Some(1.0))
                .expect("a model");
        let answer = by_method(&model, &*named("rk4"), &times, None);
        (1.0 / answer.ok().and_then(|answer| answer.runs).expect("it runs").h).round()
    };
    let [small, large] = [1, LARGE + 1].map(steps);
    assert!(small == (2 * STEPS) as f64 && large <= 0.25 * small, "{small}, {large}");
}

/// e^{2000} of a rounding is no number.
#[test]
fn a_method_whose_own_solutions_grow_is_seen_to_break_down() {
    let problem = problem::build("prothero-robinson", &[]).expect("known");
    let method = method::parse("conventional").expect("known");
    let answer = by_method(&*problem, &*method, &[1.0, 2.0], None);
    assert!(matches!(answer, Err(Gap::BrokeDown(reason)) if reason.contains("own solutions grow")));
}

/// Orders that go up and down, or of which one is too low, bound no error unless they lead far from the truth; runs that are one but
/// for roundings, and those whose orders settle, do.
#[test]
fn orders_settle_where_two_in_succession_agree_and_neither_is_too_low() {
    let truth = Answer { states: vec![vec![2.0]], bound: 1e-12, astray: None, runs: None };
    let stands = |order: f64, orders: [f64; 2], first: f64| {
        let run = |steps: usize| {
            let (mut value, mut difference) = (1.0, first);
            for k in 0..(steps / STEPS).ilog2() as usize {
                value += difference;
                difference /= orders[k % 2].exp2();
            }
            Ok(vec![vec![value]])
        };
        let Ok(answer) = refined(STEPS, run, order, |_, _| 1e-15, &[1.0], Some(&truth), MOST_STEPS) else {
            panic!("it runs")
        };
        judge(&Ok(answer), Some(&truth)).0
    };
    assert_eq!([stands(1.0, [1.5, 3.0], 1e-4), stands(2.0, [1.7, 1.9], 0.69)], [Standing::Unresolved; 2]);
    assert_eq!([stands(2.0, [2.0, 1.9], 0.69), stands(2.0, [2.0; 2], 0.0)], [Standing::Differs; 2]);
    assert_eq!(stands(2.0, [1.7, 1.9], 1e-4), Standing::Differs);
}

/// An order that is lower than the bound's by less than a quarter is that; of errors of a lower one a truth as near as this is no sign.
#[test]
fn runs_of_about_the_order_of_the_bound_disagree_beyond_it() {
    let stands = |order: f64| {
        // Of four runs the first two are one by accident.
        let sum = |k: i32| (1..k).map(|k| 1e-3 * (-order * f64::from(k)).exp2()).sum::<f64>();
        let run = |steps: usize| Ok(vec![vec![1.0 + sum((steps / STEPS).ilog2() as i32)]]);
        let truth = vec![vec![1.0 + sum(4) + 3.5e-4 * (-order).exp2()]];
        let truth = Answer { states: truth, bound: 1e-12, astray: None, runs: None };
        let Ok(answer) = refined(STEPS, run, 2.0, |_, _| 1e-15, &[1.0], Some(&truth), MOST_STEPS) else {
            panic!("it runs")
        };
        judge(&Ok(answer), Some(&truth)).0
    };
    assert_eq!([1.8, 1.76, 1.74].map(stands), [Standing::Differs, Standing::Differs, Standing::Unresolved]);
}

/// The bounds 2 · 0.009 (h − h/2) and so on are a part of the solution, whatever its size.
#[test]
fn steps_are_halved_until_two_digits_are_known() {
    for size in [1e-3, 1.0, 1e3] {
        let steps = |error: f64| {
            let run = |steps: usize| Ok(vec![vec![size * (1.0 + error * STEPS as f64 / steps as f64)]]);
            let answer = refined(STEPS, run, 1.0, |_, _| 0.0, &[1.0], None, MOST_STEPS);
            (1.0 / answer.ok().and_then(|answer| answer.runs).expect("it runs").h).round() as usize / STEPS
        };
        assert_eq!([0.009, 0.018, 0.036].map(steps), [2, 4, 8], "{size}");
    }
}

/// Two runs give a bound, with a rounding for each step of the finer.
#[test]
fn a_bound_has_the_roundings_and_where_it_is_all_that_is_wanted_takes_two_runs() {
    let truth = Answer { states: vec![vec![2.0]], bound: 1e-12, astray: None, runs: None };
    for (at_once, is_two) in [(true, true), (false, false)] {
        let count = std::cell::Cell::new(0);
        let run = |_: usize| {
            count.set(count.get() + 1);
            Ok(vec![vec![1.0]])
        };
        let rounding = |size: f64, steps: usize| 1e-12 * size * steps as f64;
        let Ok(answer) = refined(STEPS, run, 2.0, rounding, &[1.0], Some(&truth), if at_once { 0 } else { MOST_STEPS })
        else {
            panic!("it runs")
        };
        assert_eq!(count.get() == 2, is_two);
        assert!(!is_two || answer.bound == 1e-12 * (2 * STEPS) as f64, "{:e}", answer.bound);
    }
}

/// det J of the Oregonator first vanishes at t = 20: before, Method II follows, in steps in which Newton's iteration converges.
#[test]
fn a_failure_that_is_declared_of_later_times_is_none_before() {
    let (standing, status, _) = stands("oregonator", None, &*named("method-ii"));
    assert_eq!(standing, Standing::Agrees, "{status}");
    assert!(status.contains("in longer steps a step has no answer"), "{status}");
    // An iteration that does not converge is not the end of a branch.
    let (standing, status, _) = stands("van-der-pol", None, &*named("method-ii"));
    assert!(standing == Standing::Astray && status.contains("branch of solutions"), "{status}");
}

/// The conventional closure's own solutions have no time to overtake slow diffusion, and in short steps none shows.
#[test]
fn a_wide_bound_is_no_failure_that_was_declared() {
    for (problem, cells) in [("heat-2d", "5"), ("burgers", "8")] {
        let (standing, status, _) = stands(problem, Some(("cells", cells)), &*named("conventional"));
        assert_eq!(standing, Standing::Agrees, "{problem}: {status}");
    }
}

/// As the truth may be off too.
#[test]
fn the_bound_beside_a_difference_is_that_of_both_solutions() {
    let model = problem::model::Model::of_text("u_i { x = 1 } F_i { -x*x }", &[], Some(1.0)).expect("a model");
    let found = compare("model", &model, Vec::new(), &[]);
    let (limit, times) = (model.limit(Principle::Equation), sample_times(found.horizon));
    let bound = |name: &str| Some(by_reference(reference::by_name(name)?, &model, &limit, &times).ok()?.bound);
    let mut references = 0;
    for row in &found.solvers {
        assert!(row.standing != Standing::Agrees || row.difference <= row.bound, "{row:?}");
        let Some((own, truth)) = bound(&row.solver).zip(row.truth.as_deref().and_then(bound)) else { continue };
        assert_eq!(row.bound, Some(own + truth), "{}", row.solver);
        references += 1;
    }
    assert!(references >= 2);
}

/// What is of order two and more resolves a whole orbit; implicit Euler does not, and is compared over a tenth of it.
#[test]
fn an_orbit_is_compared_as_a_whole_by_what_resolves_it() {
    let kepler = problem::small("kepler").expect("registered");
    let compared = compare("kepler", &*kepler, Vec::new(), &[]);
    assert_eq!(compared.horizon, std::f64::consts::TAU);
    let is_nearer = |compared: &&Compared| compared.status.starts_with("to t = 0.6: agrees; to t = 6.283: agrees, but");
    let (nearer, whole): (Vec<_>, Vec<_>) = compared.solvers.iter().partition(is_nearer);
    let names: Vec<_> = nearer.iter().map(|compared| compared.solver.as_str()).collect();
    assert_eq!(names, ["implicit-euler"]);
    assert!(whole.len() > 20 && compared.notes.iter().any(|note| note.contains(names[0])), "{:?}", compared.notes);
    for Compared { solver, standing, status, .. } in &compared.solvers {
        assert_eq!(*standing, Standing::Agrees, "{solver}: {status}");
    }
}
