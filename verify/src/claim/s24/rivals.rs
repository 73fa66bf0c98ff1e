//! Against methods of similar complexity, and against more sophisticated ones of the same kind.

use lsvi::closure::Linear;
use lsvi::discrete::Galerkin;
use lsvi::{LeastSquares, State, Trajectory, Variational};

use crate::chapter::StudyError;
use crate::claim::measure::{HORIZON, max_error, problem, table, text, threshold};
use crate::claim::{Case, Claim, Finding};
use crate::measure::norm::larger;
use crate::method;
use crate::problem::Problem;
use crate::run::run;

use super::BOTH;

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "S24-n-1",
        source: "[S24] Abstract",
        statement: "Method I is more accurate than methods of similar complexity at equal step size.",
        criterion: "Its largest error on (0, 10] is smaller than that of each one-step or two-step method that is of second \
                    order and A-stable (trapezoidal rule, implicit midpoint, SDIRK2, BDF2), on linear drag, quadratic drag \
                    and the Galerkin equation of Poiseuille flow, h from 1 to 0.01.",
        decide: || against_rivals("method-i"),
    },
    Claim {
        id: "S24-n-2",
        source: "[S24] Abstract",
        statement: "Method II is more accurate than methods of similar complexity at equal step size.",
        criterion: "As for S24-n-1; equal errors do not count as smaller.",
        decide: || against_rivals("method-ii"),
    },
    Claim {
        id: "S24-o",
        source: "[S24] Sections 2, 4 and 6",
        statement: "Least-squares integrators built from more sophisticated variational integrators do better.",
        criterion: "With Method I's closure, the Galerkin discrete Lagrangian of degree 2 with three Lobatto nodes has a smaller \
                    largest error on (0, 10] than the trapezoidal one, on linear and quadratic drag at every h from 2 to 0.01.",
        decide: sophisticated,
    },
];

const RIVALS: [&str; 4] = ["trapezoidal", "implicit-midpoint", "sdirk2", "bdf2"];
const STEPS: [f64; 6] = [1.0, 0.5, 0.2, 0.1, 0.05, 0.01];
/// Errors that differ by less than this are those of the same method, computed along different ways.
const SAME: f64 = 1e-9;

/// A problem of the comparison with its exact solution.
struct Setting {
    name: &'static str,
    problem: Box<dyn Problem>,
    truth: fn(f64) -> f64,
}

/// On the Poiseuille ansatz all methods get the Galerkin equation itself: projections are not compared here.
fn settings() -> Result<[Setting; 3], StudyError> {
    let relaxation = problem("linear-drag", &[("lambda", "2.5"), ("v0", "-1")])?;
    Ok([
        Setting { name: "linear drag", problem: problem("linear-drag", &[])?, truth: |t| (-t).exp() },
        Setting { name: "quadratic drag", problem: problem("quadratic-drag", &[])?, truth: |t| 1.0 / (1.0 + t) },
        // v − γ/2 of v̇ = (5/4)(γ − 2v), v(0) = 0, γ = 2.
        Setting { name: "Poiseuille, Galerkin", problem: relaxation, truth: |t| -(-2.5 * t).exp() },
    ])
}

/// Linear solves and evaluations of the step equation in a run to t = 10.
fn work(problem: &dyn Problem, method: &str, h: f64) -> Result<[f64; 2], StudyError> {
    let work = run(problem, &*method::parse(method)?, h, HORIZON, |_| {})?.work;
    Ok([work.factorizations as f64, work.residuals as f64])
}

fn against_rivals(method: &str) -> Result<Finding, StudyError> {
    let (mut cases, mut rows) = (Vec::new(), Vec::new());
    let (mut wins, mut ties) = ([0; RIVALS.len()], [0; RIVALS.len()]);
    for Setting { name, problem, truth } in settings()? {
        let mut ahead = [0; RIVALS.len()];
        for h in STEPS {
            let own = max_error(&*problem, method, h, HORIZON, truth)?;
            for (i, rival) in RIVALS.iter().enumerate() {
                let theirs = max_error(&*problem, rival, h, HORIZON, truth)?;
                let case =
                    Case::below(format!("error over that of {rival}, {name}, h = {h}"), own / theirs, 1.0 - SAME);
                ahead[i] += usize::from(case.holds());
                ties[i] += usize::from((own / theirs - 1.0).abs() <= SAME);
                cases.push(case);
            }
        }
        // At equal work: all are of second order, so that error × work² does not depend on h when it is small.
        let h = STEPS[STEPS.len() - 1];
        let own = max_error(&*problem, method, h, HORIZON, truth)?;
        let [solves, residuals] = work(&*problem, method, h)?;
        for (i, rival) in RIVALS.into_iter().enumerate() {
            wins[i] += ahead[i];
            let theirs = max_error(&*problem, rival, h, HORIZON, truth)?;
            let [their_solves, their_residuals] = work(&*problem, rival, h)?;
            let equal_h = own / theirs;
            let numbers = vec![
                ahead[i] as f64 / STEPS.len() as f64,
                equal_h,
                equal_h * (solves / their_solves).powi(2),
                equal_h * (residuals / their_residuals).powi(2),
            ];
            rows.push((vec![name.to_owned(), rival.to_owned()], numbers));
        }
    }
    let total = cases.len() / RIVALS.len();
    let score: Vec<String> = RIVALS
        .iter()
        .enumerate()
        .map(|(i, rival)| match ties[i] {
            0 => format!("{} of {total} against {rival}", wins[i]),
            n => format!("{} of {total} against {rival} ({n} equal)", wins[i]),
        })
        .collect();
    let evidence = format!("Smaller errors in {}.", score.join(", "));
    let caption = format!(
        "{method} against each rival: the share of the step sizes at which its error is the smaller, and its error divided by \
         the rival's at h = 0.01, at equal step size and at equal work; below 1 it is ahead. Work is counted by the integrators: \
         linear solves, and evaluations of the step equation or of f."
    );
    let against_sdirk2 = rows[2].1.clone(); // on the first problem
    let columns = ["problem", "rival", "share_ahead", "equal_step", "equal_solves", "equal_evaluations"];
    let ratios = table(&format!("claims-rivals-{method}"), &caption, &columns, rows);
    let finding = Finding::on(cases, evidence).with_table(ratios);
    if method == BOTH[1] {
        return Ok(finding
            .holds_where("On linear problems it is the trapezoidal rule; what it wins, that rule wins too.")
            .because("Local error h³/12 on linear problems, the trapezoidal rule's, to the last digits."));
    }
    let crossing = threshold("Method I against the trapezoidal rule", 0.3, 3.3, |h| {
        let drag = problem("linear-drag", &[])?;
        let error = |method| max_error(&*drag, method, h, HORIZON, |t| (-t).exp());
        Ok(error(BOTH[0])? - error(RIVALS[0])?)
    });
    Ok(finding
        .holds_where(format!(
            "Against BDF2; against the trapezoidal rule on quadratic drag and at large steps, on linear drag from h = {} on.",
            text(crossing?)
        ))
        .because(format!(
            "Its local error on v̇ = −v is h³/6, twice the trapezoidal rule's h³/12, half of BDF2's. In return it damps stiff \
             components, which the trapezoidal rule and the midpoint rule do not. SDIRK2 damps them too; on linear drag Method I \
             has {} times its error at equal step size and {} times at equal numbers of linear solves.",
            text(against_sdirk2[1]),
            text(against_sdirk2[2])
        )))
}

/// Largest error on whole steps in (0, 10] of Method I's closure on the Galerkin discretisation of degree 2 with three
/// Lobatto nodes; infinite if a step fails.
fn galerkin(setting: &Setting, h: f64) -> Result<f64, StudyError> {
    let discrete = Galerkin::lobatto(LeastSquares::new(setting.problem.field())?, 2)?;
    let method = Variational::new(discrete, Linear::METHOD_I);
    let mut worst = 0.0_f64;
    let end = h * (HORIZON / h + 1e-9).floor();
    let run = Trajectory::new(method, State::new(0.0, setting.problem.initial()), h, end)?.observe(|state| {
        worst = larger(worst, (state.q[0] - (setting.truth)(state.t)).abs());
    });
    Ok(if run.is_ok() { worst } else { f64::INFINITY })
}

fn sophisticated() -> Result<Finding, StudyError> {
    let (mut cases, mut sentences, mut from) = (Vec::new(), Vec::new(), f64::INFINITY);
    let [linear, quadratic, _] = settings()?;
    for setting in [&linear, &quadratic] {
        let own = |h| max_error(&*setting.problem, BOTH[0], h, HORIZON, setting.truth);
        for h in [2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.01] {
            let what = format!("largest error of degree 2, {}, h = {h}, against Method I", setting.name);
            let case = Case::below(what, galerkin(setting, h)?, own(h)?);
            if !case.holds() {
                from = from.min(h);
            }
            cases.push(case);
        }
        let order = (galerkin(setting, 0.1)? / galerkin(setting, 0.05)?).log2();
        sentences.push(format!(
            "on {} the error at h = 0.1 is {} instead of {}, falling with order {}",
            setting.name,
            text(galerkin(setting, 0.1)?),
            text(own(0.1)?),
            text(order)
        ));
    }
    let evidence = format!("With degree 2, {}.", sentences.join("; "));
    Ok(Finding::on(cases, evidence)
        .holds_where(format!("Everywhere below h = {}, the smallest step at which it does not.", text(from)))
        .because("A path of degree s with s + 1 Lobatto nodes is of order 2s under the same closure, at s times the unknowns."))
}
