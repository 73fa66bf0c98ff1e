//! The recipes of ARCHITECTURE.md, followed: a toy of each kind, stated in one place and used by what was there before.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use lsvi::closure::Linear;
use lsvi::{AutoField, FieldFn, Integrator, Scalar, VectorField, least_squares};
use verify::chapter::Study;
use verify::claim::{Case, Claim, Finding, Quantifier, Verdict};
use verify::evidence::{Check, Evidence, Outcome, Table};
use verify::experiment::{Context, Experiment, StudyError};
use verify::golden::{self, Action, Golden, Row, Tolerance, Truth};
use verify::kinds::{Principle, Stability};
use verify::method::{BuildError, Method, Traits};
use verify::problem::Problem;
use verify::reference::{self, Ode, Reference, ReferenceError};
use verify::report::{Chapter, Run};
use verify::{order, row, run};

/// A problem: v̇ = −v³ from 1, with v = (1 + 2t)^{−½}.
#[derive(Debug)]
struct Cubic;

impl FieldFn for Cubic {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = -v[0] * v[0] * v[0];
    }
}

impl Ode for Cubic {
    fn dim(&self) -> usize {
        1
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = -v[0].powi(3);
    }
    fn jacobian(&self, _t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        add(0, 0, -3.0 * v[0] * v[0]);
    }
}

impl Problem for Cubic {
    fn components(&self) -> &'static [&'static str] {
        &["v"]
    }
    fn initial(&self) -> Vec<f64> {
        vec![1.0]
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        Some(vec![(1.0 + 2.0 * t).sqrt().recip()])
    }
}

/// A method: p₁ = −p₀/10.
#[derive(Debug)]
struct Tenth;

impl Method for Tenth {
    fn name(&self) -> String {
        "tenth".into()
    }
    fn traits(&self) -> Traits {
        Traits::new(2, Principle::MomentumZero, Stability::Neutral)
    }
    fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
        let refused = |error: lsvi::InputError| BuildError { method: self.name(), reason: error.to_string() };
        let closure = Linear::new(0.1, 1.0).map_err(refused)?;
        Ok(Box::new(least_squares(problem.field(), closure).map_err(refused)?))
    }
}

/// An expectation: by how much halving the step divides the error, from facts and traits alone.
fn ratio(problem: &dyn Problem, method: &dyn Method) -> f64 {
    let limit = problem.limit(method.principle()).order.unwrap_or(f64::INFINITY);
    f64::from(method.order()).min(limit).exp2()
}

/// A reference: the classical Runge–Kutta method with as many equal steps as the fourth root of the tolerance asks for.
struct Rk4;

impl Reference for Rk4 {
    fn name(&self) -> &'static str {
        "rk4-toy"
    }
    fn stiff_ok(&self) -> bool {
        false
    }
    fn library(&self) -> Option<String> {
        Some("this test".into())
    }
    fn run(
        &self,
        ode: &dyn Ode,
        t0: f64,
        v0: &[f64],
        times: &[f64],
        tolerance: f64,
    ) -> Result<reference::Run, ReferenceError> {
        let f = |t: f64, v: &[f64]| {
            let mut dv = vec![0.0; v.len()];
            ode.rhs(t, v, &mut dv);
            dv
        };
        let moved = |v: &[f64], h: f64, k: &[f64]| v.iter().zip(k).map(|(v, k)| v + h * k).collect::<Vec<_>>();
        let (mut run, mut t, mut v) = (reference::Run::with_capacity(times.len()), t0, v0.to_vec());
        let longest = tolerance.powf(0.25);
        for end in times {
            let steps = ((end - t) / longest).ceil().max(1.0);
            let h = (end - t) / steps;
            for _ in 0..steps as u64 {
                let k1 = f(t, &v);
                let k2 = f(t + 0.5 * h, &moved(&v, 0.5 * h, &k1));
                let k3 = f(t + 0.5 * h, &moved(&v, 0.5 * h, &k2));
                let k4 = f(t + h, &moved(&v, h, &k3));
                (0..v.len()).for_each(|i| v[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
                t += h;
            }
            t = *end;
            run.work.steps += steps as u64;
            run.push(v.clone(), run.work.steps);
        }
        Ok(run)
    }
}

/// An experiment: the error at t = 1 after so many steps.
#[derive(Debug)]
struct EndError {
    steps: u32,
}

/// How often it was carried out.
static CARRIED_OUT: AtomicUsize = AtomicUsize::new(0);

impl Experiment for EndError {
    const ID: &'static str = "toy-end-error";
    type Found = f64;

    fn measure(&self, _: &Context) -> Result<f64, StudyError> {
        CARRIED_OUT.fetch_add(1, Ordering::SeqCst);
        let end = run::run(&Cubic, &Tenth, f64::from(self.steps).recip(), 1.0, |_| {})?.end;
        Ok((end.q[0] - 3_f64.sqrt().recip()).abs())
    }
}

/// The errors of 64 and of 128 steps, which everything below reads.
fn errors(context: &Context) -> Result<[f64; 2], StudyError> {
    Ok([*context.get(EndError { steps: 64 })?, *context.get(EndError { steps: 128 })?])
}

/// A chapter.
const STUDY: Study = Study {
    id: "toy",
    title: "A toy",
    question: "Is the toy of second order?",
    source: "ARCHITECTURE.md",
    run: |context| {
        let [coarse, fine] = errors(context)?;
        let order = (coarse / fine).log2();
        let rows = vec![row![64_u32, coarse], row![128_u32, fine]];
        Ok(Evidence {
            checks: vec![Check::within("order", "The toy is of second order", order, [1.9, 2.1], "h is small")],
            tables: vec![Table::new("toy", "Errors of the toy.", ["steps", "error"], rows)],
            ..Evidence::default()
        })
    },
};

/// A claim.
const CLAIM: Claim = Claim {
    id: "TOY-a",
    source: "ARCHITECTURE.md",
    statement: "Halving the step divides the error of the toy by ten.",
    quantifier: Quantifier::Universal,
    criterion: "The ratio of the errors of 64 and 128 steps is above 9.",
    decide: |context| {
        let [coarse, fine] = errors(context)?;
        Ok(Finding::on(vec![Case::above("ratio", coarse / fine, 9.0)], "It is a method of second order."))
    },
};

/// A golden.
fn toy_golden(context: &Arc<Context<'static>>) -> Golden {
    let context = Arc::clone(context);
    Golden::new("toy", move || {
        let [coarse, fine] = errors(&context)?;
        let truth = Truth { value: 4.0, allowance: 0.2, source: "second order".into() };
        let ratio = Row::number("ratio", coarse / fine, Tolerance::relative(1e-9, "roundings")).with_truth(truth);
        Ok(vec![ratio])
    })
}

#[test]
fn a_problem_and_a_method_are_enough_to_measure_an_order() {
    let fit = order::measure(&Cubic, &Tenth, order::Truth::Exact).expect("the exact solution is known");
    assert_eq!(Outcome::from(fit.verdict), Outcome::Pass, "{}", fit.reason);
}

#[test]
fn an_expectation_knows_the_problem_and_the_method_by_their_facts_and_traits() {
    let error = |steps: u32| {
        let end = run::run(&Cubic, &Tenth, f64::from(steps).recip(), 1.0, |_| {}).expect("smooth").end;
        (end.q[0] - 3_f64.sqrt().recip()).abs()
    };
    let [expected, found] = [ratio(&Cubic, &Tenth), error(64) / error(128)];
    // The band of orders: a tenth tells neighbouring ones apart by far.
    assert!((found.log2() - expected.log2()).abs() < 0.1, "{found}, expected {expected}");
}

#[test]
fn a_reference_brings_one_solve_and_is_given_its_bound() {
    let times = [0.5, 1.0, 2.0];
    let sampled = Rk4.solve_within(&Cubic, 0.0, &[1.0], &times, 1e-9).expect("smooth");
    for (t, (state, bound)) in times.iter().zip(sampled.states.iter().zip(&sampled.bound)) {
        let error = (state[0] - (1.0 + 2.0 * t).sqrt().recip()).abs();
        assert!(error <= *bound && *bound < 1e-6, "t = {t}: {error:e}, bound {bound:e}");
    }
}

#[test]
fn chapter_claim_and_golden_read_what_one_experiment_measured_once() {
    let context = Arc::new(Context::silent());
    let evidence = (STUDY.run)(&context).expect("it runs");
    let report = Run::new(vec![Chapter { id: STUDY.id.into(), evidence, ..Chapter::default() }], Vec::new());
    assert!(report.counts().is_ok(), "{:?}", report.counts());

    let finding = (CLAIM.decide)(&context).expect("it is decided");
    assert_eq!(CLAIM.quantifier.verdict(finding.cases()), Verdict::Refuted);

    let dir = crate::scratch("recipes");
    for action in [Action::Refresh, Action::Check] {
        let mut printed = Vec::new();
        let holds = golden::run(action, &dir, &[toy_golden(&context)], None, &mut printed).expect("a usable directory");
        assert!(holds, "{}", String::from_utf8_lossy(&printed));
    }
    assert_eq!(CARRIED_OUT.load(Ordering::SeqCst), 2);
}

/// The rows of the table of recipes: what is added, its file, the line of its registry and the file that it is in.
fn recipes() -> Vec<Vec<String>> {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).expect("readable");
    let section = text.split("\n## Recipes\n").nth(1).expect("a section of recipes");
    let section = section.split("\n## ").next().unwrap_or_default();
    let rows = section.lines().filter(|line| line.starts_with("| ")).skip(1);
    rows.map(|row| row.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect()).collect()
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace")
}

/// The texts in backticks.
fn quoted(cell: &str) -> Vec<&str> {
    cell.split('`').skip(1).step_by(2).collect()
}

#[test]
fn every_recipe_names_a_file_and_a_line_that_are_there() {
    let recipes = recipes();
    let kinds: Vec<&str> = recipes.iter().map(|row| row[0].as_str()).collect();
    for kind in [
        "problem",
        "method",
        "discretisation",
        "closure",
        "expectation",
        "reference",
        "experiment",
        "chapter",
        "claim",
        "golden",
    ] {
        assert!(kinds.contains(&kind), "no recipe for a {kind} among {kinds:?}");
    }
    for row in &recipes {
        let [kind, file, line] = &row[..] else { panic!("three columns: {row:?}") };
        let example = quoted(file)[0];
        assert!(root().join(example).is_file(), "{kind}: {example}");
        let [registry, line] = quoted(line)[..] else { panic!("{kind}: a file and a line in it") };
        let text = fs::read_to_string(root().join(registry)).unwrap_or_else(|_| panic!("{kind}: {registry}"));
        assert!(text.contains(line), "{kind}: {registry} has no line {line}");
    }
}
