//! What a reader comes for: which method to take, and what it costs. Each answer rests on runs made for it.

use std::f64::consts::{SQRT_2, TAU};

use nalgebra::Complex;
use rayon::prelude::*;

use super::mechanics::{problem, text};
use super::{Context, Study, StudyError, symplecticity};
use crate::evidence::{Cell, Check, Evidence, Outcome, Requirement, Section, Table};
use crate::kinds::Principle;
use crate::measure::amplification::Amplification;
use crate::measure::norm::distance;
use crate::measure::order::{Expectation, Sample, fit, ladder};
use crate::order::roundoff;
use crate::problem::{self, Problem};
use crate::run;
use crate::{method, reference};

pub(super) const STUDY: Study = Study {
    id: "answers",
    title: "In short",
    question: "Which of these methods should I take, and what would I lose?",
    source: "runs at equal step size; the chapters below have the details",
    run: study,
};

/// An answer to one question.
struct Answer {
    id: &'static str,
    question: &'static str,
    /// In a word or two; shown only if every check holds.
    short: &'static str,
    paragraphs: Vec<(&'static str, String)>,
    checks: Vec<Check>,
    table: Table,
}

fn study(context: &Context) -> Result<Evidence, StudyError> {
    let questions: [fn() -> Result<Answer, StudyError>; 4] = [parabolic, smooth, path_fitted, trust];
    (context.announce)(questions.len() as u64);
    let answers = questions.into_par_iter().map(|answer| {
        let answer = answer();
        (context.tick)();
        answer
    });
    let mut evidence = Evidence::default();
    for answer in answers.collect::<Result<Vec<_>, _>>()? {
        let holds = answer.checks.iter().all(|check| check.outcome == Outcome::Pass);
        evidence.checks.extend(answer.checks);
        evidence.sections.push(Section {
            id: answer.id.into(),
            title: answer.question.into(),
            mark: if holds { answer.short } else { "unsettled" }.into(),
            paragraphs: answer.paragraphs.into_iter().map(|(label, words)| (label.into(), words)).collect(),
            tables: vec![answer.table.id.clone()],
            figures: Vec::new(),
        });
        evidence.tables.push(answer.table);
    }
    Ok(evidence)
}

/// A problem, and where its solutions are compared.
struct Setting {
    name: &'static str,
    problem: Box<dyn Problem>,
    h: f64,
    t_end: f64,
}

impl Setting {
    fn new(name: &'static str, set: &[(&str, &str)], h: f64, t_end: f64) -> Result<Self, StudyError> {
        Ok(Self { name, problem: problem(name, set)?, h, t_end })
    }

    /// The error of `method` at `t_end` after steps of h/`pieces`.
    fn error(&self, method: &str, pieces: u32) -> Result<f64, StudyError> {
        let exact = (self.problem.limit(Principle::MomentumZero).exact)(self.t_end);
        let truth = exact.or_else(|| self.problem.tabulated(self.t_end)).ok_or("the solution is known")?;
        let h = self.h / f64::from(pieces);
        Ok(distance(&run::run(&*self.problem, &*method::parse(method)?, h, self.t_end, |_| {})?.end.q, &truth))
    }
}

/// A table of errors with a row per setting and a column per method, and these errors.
fn errors(
    id: &str,
    caption: &str,
    settings: &[Setting],
    columns: &[(&str, &str, u32)],
) -> Result<(Table, Vec<Vec<f64>>), StudyError> {
    let of = |setting: &Setting| columns.iter().map(|(_, method, pieces)| setting.error(method, *pieces)).collect();
    let errors = settings.iter().map(of).collect::<Result<Vec<Vec<f64>>, _>>()?;
    let rows = settings.iter().zip(&errors).map(|(setting, errors)| {
        let start = [text(setting.name), Cell::found(setting.h), Cell::found(setting.t_end)];
        start.into_iter().chain(errors.iter().copied().map(Cell::found)).collect()
    });
    let names: Vec<&str> = ["problem", "h", "t_end"].into_iter().chain(columns.iter().map(|c| c.0)).collect();
    Ok((Table::new(id, caption, &names, rows.collect()), errors))
}

/// Least and largest ratio of column `a` to column `b`.
fn ratios(errors: &[Vec<f64>], a: usize, b: usize) -> (f64, f64) {
    let ratios = errors.iter().map(|row| row[a] / row[b]);
    ratios.fold((f64::INFINITY, 0.0), |(low, high), ratio| (low.min(ratio), f64::max(high, ratio)))
}

const REASON: &str = "the runs of the table";

fn parabolic() -> Result<Answer, StudyError> {
    const COLUMNS: [(&str, &str, u32); 7] = [
        ("method-i", "method-i", 1),
        ("method-i, h/2", "method-i", 2),
        ("implicit-euler", "implicit-euler", 1),
        ("trapezoidal", "trapezoidal", 1),
        ("bdf2", "bdf2", 1),
        ("tr-bdf2", "tr-bdf2", 1),
        ("ls-galerkin(2,radau,2)", "ls-galerkin(2,radau,2)", 1),
    ];
    let mut settings = Vec::new();
    for (name, h) in
        [("channel-couette", 0.1), ("channel-couette", 0.02), ("channel-poiseuille", 0.1), ("channel-poiseuille", 0.02)]
    {
        settings.push(Setting::new(name, &[("cells", "64")], h, 0.5)?);
    }
    let caption = "Errors at t_end of channel flow on 64 cells, against the exact solution of the same 63 equations.";
    let (table, errors) = errors("answer-parabolic-errors", caption, &settings, &COLUMNS)?;
    let (ringing, _) = ratios(&errors[..1], 3, 0);
    let (_, smooth) = ratios(&errors[2..], 0, 3);
    let (halved_low, halved_high) = ratios(&errors, 1, 5);
    let (radau, _) = ratios(&errors, 0, 6);
    let checks = vec![
        Check::new(
            "parabolic/ringing",
            "Couette flow, long steps: the trapezoidal rule's error over Method I's",
            ringing,
            Requirement::AtLeast(10.0),
            "the wall's jump excites modes that the trapezoidal rule does not damp",
        ),
        Check::new(
            "parabolic/multistep",
            "Method I is more accurate than implicit Euler and BDF2 at equal h: largest ratio of errors",
            ratios(&errors, 0, 2).1.max(ratios(&errors, 0, 4).1),
            Requirement::AtMost(1.0),
            REASON,
        ),
        Check::new(
            "parabolic/tr-bdf2",
            "At equal work, two solves, Method I and TR-BDF2 are within a factor of 3: largest ratio of errors, either way",
            halved_high.max(halved_low.recip()),
            Requirement::AtMost(3.0),
            "Method I with h/2 against TR-BDF2 with h",
        ),
        Check::new(
            "parabolic/radau",
            "Radau IIA with two stages is more accurate by more than a digit: least ratio of Method I's error to its",
            radau,
            Requirement::AtLeast(10.0),
            REASON,
        ),
    ];
    Ok(Answer {
        id: "answer-parabolic",
        question: "Should I use Method I for my stiff parabolic problem?",
        short: "not for itself",
        paragraphs: vec![
            (
                "Answer",
                format!(
                    "It is sound: L-stable on symmetric dissipative problems, of second order, with banded and sparse \
                     Jacobians at a cost linear in the cells. Where data jump and steps are long its error is {ringing:.0} \
                     times smaller than the trapezoidal rule's, which rings; on a start from rest it is {smooth:.1} times \
                     larger at most. But it earns nothing that TR-BDF2 does not give for the same number of solves, from \
                     {halved_low:.2} to {halved_high:.2} times its error, and Radau IIA with two stages is {radau:.0} \
                     times as accurate at least."
                ),
            ),
            ("Take", "`tr-bdf2` or `ls-galerkin(2,radau,2)` with fixed steps, `radau-adaptive` with a tolerance.".into()),
            (
                "Beware",
                "The problem must be symmetric or nearly so: on non-normal systems Method I can grow where the solution \
                 decays, does not conserve linear invariants, and its result depends on the metric. Its steady states may \
                 be spurious; `lsvi::steady` refuses them."
                    .into(),
            ),
        ],
        checks,
        table,
    })
}

fn smooth() -> Result<Answer, StudyError> {
    const COLUMNS: [(&str, &str, u32); 5] = [
        ("method-i", "method-i", 1),
        ("trapezoidal", "trapezoidal", 1),
        ("implicit-midpoint", "implicit-midpoint", 1),
        ("ls-galerkin(2,gauss,2)", "ls-galerkin(2,gauss,2)", 1),
        ("ls-galerkin(3,gauss,3)", "ls-galerkin(3,gauss,3)", 1),
    ];
    let mut settings = Vec::new();
    for name in ["quadratic-drag", "logistic", "damped-pendulum", "van-der-pol"] {
        settings.push(Setting::new(name, &[], 0.05, 2.0)?);
    }
    let caption = "Errors at t_end; `ls-galerkin(S,gauss,S)` is Gauss collocation of order 2S.";
    let (table, errors) = errors("answer-smooth-errors", caption, &settings, &COLUMNS)?;
    let (trapezoidal, midpoint) = (ratios(&errors, 0, 1), ratios(&errors, 0, 2));
    let (gauss, _) = ratios(&errors, 0, 3);
    let checks = vec![
        Check::new(
            "smooth/midpoint",
            "Method I is less accurate than the implicit midpoint rule: least ratio of their errors",
            midpoint.0,
            Requirement::AtLeast(1.0),
            REASON,
        ),
        Check::new(
            "smooth/gauss",
            "Gauss collocation of order 4 is more accurate by two digits: least ratio of Method I's error to its",
            gauss,
            Requirement::AtLeast(100.0),
            REASON,
        ),
    ];
    Ok(Answer {
        id: "answer-smooth",
        question: "What would I lose against the trapezoidal rule, or Gauss collocation?",
        short: "digits",
        paragraphs: vec![
            (
                "Answer",
                format!(
                    "On smooth nonlinear problems at equal steps Method I makes {:.1} to {:.0} times the error of the \
                     trapezoidal rule and {:.1} to {:.1} times that of the implicit midpoint rule, all of second order \
                     with one nonlinear solve a step. Gauss collocation with two nodes is {:.0e} times as accurate at \
                     least. What Method I has and they have not is damping: R(∞) = 0 on symmetric problems.",
                    trapezoidal.0, trapezoidal.1, midpoint.0, midpoint.1, gauss
                ),
            ),
            (
                "Take",
                "`ls-galerkin(S,gauss,S)` for smooth problems. Gauss collocation is itself the least-squares method of its \
                 nodes, whatever the closure: the variational idea pays at high degree, not through the closure."
                    .into(),
            ),
        ],
        checks,
        table,
    })
}

fn path_fitted() -> Result<Answer, StudyError> {
    const METHODS: [&str; 6] = [
        "path-fitted(4)",
        "path-fitted(4,lobatto)",
        "path-fitted(4,gauss)",
        "galerkin-gauss(2)",
        "galerkin-gauss(3)",
        "stormer-verlet",
    ];
    let kepler = problem("kepler", &[])?;
    let double = problem("double-pendulum", &[("p10", "0.3"), ("p20", "-0.2")])?;
    let truth = kepler.exact(TAU).ok_or("Kepler's problem has an exact solution")?;
    let mut measured = Vec::new();
    for name in METHODS {
        let method = method::parse(name)?;
        let run = run::run(&*kepler, &*method, TAU / 200.0, TAU, |_| {})?;
        let defect = symplecticity::defect(&*double, &*method, 0.2, &[double.initial()])?.0;
        measured.push((name, distance(&run.end.q, &truth), run.work.residuals, defect));
    }
    let of = |name: &str| measured.iter().find(|m| m.0 == name).map_or((f64::NAN, f64::NAN), |m| (m.1, m.3));
    let (error, defect) = of("path-fitted(4)");
    let (gauss, galerkin) = (error / of("path-fitted(4,gauss)").0, error / of("galerkin-gauss(3)").0);
    let checks = vec![
        Check::new(
            "path-fitted/gauss",
            "Moving the three points to Gauss' nodes gains more than a digit: ratio of the errors",
            gauss,
            Requirement::AtLeast(10.0),
            REASON,
        ),
        Check::new(
            "path-fitted/galerkin",
            "galerkin-gauss(3) gains more than a digit: ratio of the errors",
            galerkin,
            Requirement::AtLeast(10.0),
            REASON,
        ),
        Check::new(
            "path-fitted/defect",
            "The path-fitted step is not symplectic on the double pendulum: defect over that of galerkin-gauss(3)",
            defect / of("galerkin-gauss(3)").1,
            Requirement::AtLeast(1e6),
            "one step of 0.2; the Galerkin step's defect is rounding",
        ),
    ];
    let rows = measured.iter().map(|(name, error, evaluations, defect)| {
        vec![text(*name), Cell::found(*error), Cell::Integer(*evaluations as i64), Cell::found(*defect)]
    });
    let table = Table::new(
        "answer-path-fitted-errors",
        "Error after one period of Kepler's problem, eccentricity 0.6, in 200 steps, evaluations of the step equations for \
         it, and the defect of symplecticity of one step of 0.2 on the double pendulum.",
        &["method", "error", "evaluations", "symplecticity_defect"],
        rows.collect(),
    );
    Ok(Answer {
        id: "answer-path-fitted",
        question: "Should I use the path-fitted integrator with three interior points?",
        short: "no",
        paragraphs: vec![
            (
                "Answer",
                format!(
                    "Not with equispaced points: it is of order 4, and at equal cost its error on Kepler's problem is \
                     {gauss:.0} times that of the same method on Gauss' nodes. Path fitting is symplectic on Gauss' nodes \
                     only, and there only where the mass is constant: on the double pendulum its defect is {defect:.0e}. \
                     The Galerkin integrator of degree 3 is {galerkin:.0} times as accurate for the same number of \
                     evaluations, and symplectic on every regular Lagrangian."
                ),
            ),
            ("Take", "`galerkin-gauss(3)`; `stormer-verlet` where a cheap explicit step is enough.".into()),
        ],
        checks,
        table,
    })
}

/// Whether the tools of this report can say no: they are given something wrong.
fn trust() -> Result<Answer, StudyError> {
    let logistic = Setting::new("logistic", &[], 0.2, 2.0)?;
    let exact = logistic.problem.exact(2.0).ok_or("logistic growth has an exact solution")?;
    let judge = |method: &str, scale: f64| -> Result<String, StudyError> {
        let method = method::parse(method)?;
        let mut samples = Vec::new();
        for h in ladder(2.0, 0.2, SQRT_2, 13) {
            let end = run::run(&*logistic.problem, &*method, h, 2.0, |_| {})?.end;
            samples.push(Sample::new(h, distance(&end.q, &[exact[0] * scale]), roundoff(&*method, 1.0, 2.0 / h)));
        }
        Ok(format!("{:?}", fit(&samples, &Expectation::new(2.0, 0.1)).verdict).to_lowercase())
    };
    // Method I whose α is wrong in the ninth digit.
    let (right, wrong) = (Amplification { alpha: 0.0, beta: 1.0 }, Amplification { alpha: 1e-9, beta: 1.0 });
    let z = Complex::from(-1.0);
    let seen = (wrong.factor(z) - right.factor(z)).norm() / right.live_tolerance(&[z]);
    let controls = [
        ("order of the trapezoidal rule, said to be 2", judge("trapezoidal", 1.0)?, "pass"),
        ("order of implicit Euler, said to be 2", judge("implicit-euler", 1.0)?, "fail"),
        ("order of the trapezoidal rule against a truth wrong by 1e-4", judge("trapezoidal", 1.0 + 1e-4)?, "not pass"),
        ("one step of Method I with α = 1e-9 in place of 0", (if seen > 1.0 { "fail" } else { "pass" }).into(), "fail"),
    ];
    let wrong = controls.iter().filter(|(_, found, wanted)| match *wanted {
        "not pass" => found == "pass",
        wanted => found != wanted,
    });
    let checks = vec![Check::new(
        "trust/controls",
        "The rules that judge this report refuse what is wrong: number of wrong answers",
        wrong.count() as f64,
        Requirement::AtMost(0.0),
        "negative controls, run each time",
    )];
    let rows = controls.iter().map(|(what, found, wanted)| vec![text(*what), text(found), text(*wanted)]);
    let table = Table::new(
        "answer-trust-controls",
        "Right and wrong inputs given to the rules that judge orders and closed forms.",
        &["input", "verdict", "wanted"],
        rows.collect(),
    );
    Ok(Answer {
        id: "answer-trust",
        question: "Can I trust these numbers?",
        short: "check them",
        paragraphs: vec![
            (
                "Answer",
                format!(
                    "Every number is computed when the report is made: {} problems, {} methods, and besides exact \
                     solutions {} solvers of two libraries as references, which share no code with the integrators and \
                     state their own error bounds. Closed forms are held to bounds derived from conditioning, orders to \
                     two-sided bands, with a third verdict where the data do not decide; failures that theory predicts are \
                     asserted to happen.",
                    problem::ALL.len(),
                    method::ALL.len(),
                    reference::all().len()
                ),
            ),
            (
                "Reproduce",
                "`scripts/report` makes this page and `scripts/test` runs every check; `verify order` and `verify solve` \
                 run any pair of problem and method."
                    .into(),
            ),
        ],
        checks,
        table,
    })
}
