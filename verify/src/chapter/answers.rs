//! What a reader comes for: which method to take, and what it costs. Each answer rests on runs made for it.

use super::{Context, Study, StudyError};
use crate::evidence::number::short;
use crate::evidence::{Cell, Check, Evidence, Outcome, Requirement, Section, Table};
use crate::experiment::controls::Controls;
use crate::experiment::end_errors::{EndErrors, Truth};
use crate::experiment::kepler_period::KeplerPeriod;
use crate::experiment::symplectic_defect::Defects;
use crate::{method, problem, reference, row};

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
    let mut evidence = Evidence::default();
    for answer in [parabolic, smooth, path_fitted, trust] {
        let answer = answer(context)?;
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

/// Where solutions are compared.
struct Setting {
    name: &'static str,
    /// The problem with its parameters.
    problem: String,
    h: f64,
    t_end: f64,
}

impl Setting {
    /// The error of `method` at `t_end` after steps of h/`pieces`.
    fn error(&self, context: &Context, method: &'static str, pieces: u32) -> Result<f64, StudyError> {
        let Self { problem, h, t_end, .. } = self;
        let (h, t_end, truth) = (*h, *t_end, Truth::Equations);
        Ok(context.get(EndErrors { problem: problem.clone(), method: method.into(), h, pieces, t_end, truth })?.end)
    }
}

/// A table of errors with a row per setting and a column per method, and these errors.
fn errors(
    context: &Context,
    id: &str,
    caption: &str,
    settings: &[Setting],
    columns: &[(&str, &'static str, u32)],
) -> Result<(Table, Vec<Vec<f64>>), StudyError> {
    let of =
        |setting: &Setting| columns.iter().map(|(_, method, pieces)| setting.error(context, method, *pieces)).collect();
    let errors = settings.iter().map(of).collect::<Result<Vec<Vec<f64>>, _>>()?;
    let rows = settings.iter().zip(&errors).map(|(setting, errors)| {
        let start = [Cell::from(setting.name), Cell::found(setting.h), Cell::found(setting.t_end)];
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

fn parabolic(context: &Context) -> Result<Answer, StudyError> {
    const COLUMNS: [(&str, &str, u32); 7] = [
        ("method-i", "method-i", 1),
        ("method-i, h/2", "method-i", 2),
        ("implicit-euler", "implicit-euler", 1),
        ("trapezoidal", "trapezoidal", 1),
        ("bdf2", "bdf2", 1),
        ("tr-bdf2", "tr-bdf2", 1),
        ("ls-galerkin(2,radau,2)", "ls-galerkin(2,radau,2)", 1),
    ];
    let setting =
        |name: &'static str, h: f64, t_end: f64| Setting { name, problem: format!("{name} cells=64"), h, t_end };
    let settings = [
        setting("channel-couette", 0.1, 0.1),
        setting("channel-couette", 0.02, 0.02),
        setting("channel-couette", 0.1, 0.5),
        setting("channel-couette", 0.02, 0.5),
        setting("channel-poiseuille", 0.1, 0.5),
        setting("channel-poiseuille", 0.02, 0.5),
    ];
    let caption = "Errors at t_end of channel flow on 64 cells, against the exact solution of the same 63 equations: after the \
                   first step from a wall that is set in motion at once, later, and on a start from rest.";
    let (table, errors) = errors(context, "answer-parabolic-errors", caption, &settings, &COLUMNS)?;
    let (first, later) = errors.split_at(2);
    let (ringing, _) = ratios(&later[..1], 3, 0);
    let (_, smooth) = ratios(&later[2..], 0, 3);
    let (halved_low, halved_high) = ratios(later, 1, 5);
    let (radau, _) = ratios(later, 0, 6);
    let (first_low, first_high) = ratios(first, 5, 1);
    let (first_radau_low, first_radau_high) = ratios(first, 6, 0);
    let checks = vec![
        Check::new(
            "parabolic/first-tr-bdf2",
            "After the first step from a jump Method I is ahead of TR-BDF2 at equal work: least ratio of TR-BDF2's error to its",
            first_low,
            Requirement::Above(1.0),
            "Method I with two steps of h/2 against TR-BDF2 with one of h, two solves each",
        ),
        Check::new(
            "parabolic/first-radau",
            "There Method I is ahead of Radau IIA with two stages too, at equal steps: least ratio of the other's error to its",
            first_radau_low,
            Requirement::Above(1.0),
            REASON,
        ),
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
            ratios(later, 0, 2).1.max(ratios(later, 0, 4).1),
            Requirement::AtMost(1.0),
            REASON,
        ),
        Check::new(
            "parabolic/tr-bdf2",
            "Later, at equal work, two solves, Method I and TR-BDF2 are within a factor of 3: largest ratio of errors, either way",
            halved_high.max(halved_low.recip()),
            Requirement::AtMost(3.0),
            "Method I with h/2 against TR-BDF2 with h",
        ),
        Check::new(
            "parabolic/radau",
            "Later Radau IIA with two stages is more accurate by more than a digit: least ratio of Method I's error to its",
            radau,
            Requirement::AtLeast(10.0),
            REASON,
        ),
    ];
    Ok(Answer {
        id: "answer-parabolic",
        question: "Should I use Method I for my stiff parabolic problem?",
        short: "after a jump",
        paragraphs: vec![
            (
                "Answer",
                format!(
                    "It is sound: L-stable on symmetric dissipative problems, of second order, with banded and sparse \
                     Jacobians at a cost linear in the cells. What it earns depends on where you look. After the first step \
                     from a jump it is ahead of the other L-stable methods: TR-BDF2 has {} to {} times its error for the \
                     same number of solves, and Radau IIA with two stages {} to {} times at equal steps. Once the layer has \
                     spread, and on a start from rest, it earns nothing that TR-BDF2 does not give for the same number of \
                     solves: it has {} to {} times its error, and {} times that of Radau IIA at equal steps, or more. The \
                     trapezoidal rule rings after a jump, with {} times the error of Method I where steps are long; on a \
                     start from rest Method I has {} times its error at most.",
                    short(first_low),
                    short(first_high),
                    short(first_radau_low),
                    short(first_radau_high),
                    short(halved_low),
                    short(halved_high),
                    short(radau),
                    short(ringing),
                    short(smooth)
                ),
            ),
            (
                "Take",
                "`method-i` where the first steps after a jump matter. Otherwise `tr-bdf2` or `ls-galerkin(2,radau,2)` with \
                 fixed steps, `radau-adaptive` with a tolerance."
                    .into(),
            ),
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

fn smooth(context: &Context) -> Result<Answer, StudyError> {
    const COLUMNS: [(&str, &str, u32); 5] = [
        ("method-i", "method-i", 1),
        ("trapezoidal", "trapezoidal", 1),
        ("implicit-midpoint", "implicit-midpoint", 1),
        ("ls-galerkin(2,gauss,2)", "ls-galerkin(2,gauss,2)", 1),
        ("ls-galerkin(3,gauss,3)", "ls-galerkin(3,gauss,3)", 1),
    ];
    let settings = ["quadratic-drag", "logistic", "damped-pendulum", "van-der-pol"].map(|name| Setting {
        name,
        problem: name.into(),
        h: 0.05,
        t_end: 2.0,
    });
    let caption = "Errors at t_end; `ls-galerkin(S,gauss,S)` is Gauss collocation of order 2S.";
    let (table, errors) = errors(context, "answer-smooth-errors", caption, &settings, &COLUMNS)?;
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

fn path_fitted(context: &Context) -> Result<Answer, StudyError> {
    const METHODS: [&str; 6] = [
        "path-fitted(4)",
        "path-fitted(4,lobatto)",
        "path-fitted(4,gauss)",
        "galerkin-gauss(2)",
        "galerkin-gauss(3)",
        "stormer-verlet",
    ];
    let mut measured = Vec::new();
    for name in METHODS {
        let period = context.get(KeplerPeriod { method: name.into(), steps: 200 })?;
        let defect = context.get(Defects { problem: "double-pendulum", method: name.into() })?.at(0.2);
        measured.push((name, period.error, period.work.residuals, defect));
    }
    let of = |name: &str| measured.iter().find(|m| m.0 == name).map_or((f64::NAN, f64::NAN), |m| (m.1, m.3));
    let (error, defect) = of("path-fitted(4)");
    let (gauss, galerkin) = (error / of("path-fitted(4,gauss)").0, error / of("galerkin-gauss(3)").0);
    let on_gauss = of("galerkin-gauss(3)").0 / of("path-fitted(4,gauss)").0;
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
            "path-fitted/gauss-against-galerkin",
            "On Gauss' nodes path fitting is ahead of galerkin-gauss(3) on Kepler's problem: ratio of the errors",
            on_gauss,
            Requirement::AtLeast(1.0),
            REASON,
        ),
        Check::new(
            "path-fitted/gauss-defect",
            "Even on Gauss' nodes its step is not symplectic on the double pendulum: defect over that of galerkin-gauss(3)",
            of("path-fitted(4,gauss)").1 / of("galerkin-gauss(3)").1,
            Requirement::AtLeast(1e6),
            "one step of 0.2; the Galerkin step's defect is rounding",
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
        vec![Cell::from(*name), Cell::found(*error), Cell::Integer(*evaluations as i64), Cell::found(*defect)]
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
        short: "on Gauss' nodes",
        paragraphs: vec![
            (
                "Answer",
                format!(
                    "Not with equispaced points: it is of order 4, and at equal cost its error on Kepler's problem is \
                     {gauss:.0} times that of the same method on Gauss' nodes. Path fitting is symplectic on Gauss' nodes \
                     only, and there only where the mass is constant: on the double pendulum its defect is {defect:.0e}. \
                     The Galerkin integrator of degree 3 is {galerkin:.0} times as accurate as on equispaced points for the \
                     same number of evaluations, has {on_gauss:.1} times the error of path fitting on Gauss' nodes, and is \
                     symplectic on every regular Lagrangian."
                ),
            ),
            (
                "Take",
                "`path-fitted(4,gauss)` where the mass is constant, `galerkin-gauss(3)` where it is not; `stormer-verlet` where a \
                 cheap explicit step is enough."
                    .into(),
            ),
        ],
        checks,
        table,
    })
}

/// Whether the tools of this report can say no: they are given something wrong.
fn trust(context: &Context) -> Result<Answer, StudyError> {
    let controls = context.get(Controls)?;
    let wrong = controls.iter().filter(|control| !control.holds());
    let checks = vec![Check::new(
        "trust/controls",
        "The rules that judge this report refuse what is wrong: number of wrong answers",
        wrong.count() as f64,
        Requirement::AtMost(0.0),
        "negative controls, run each time",
    )];
    let rows = controls.iter().map(|control| row![control.input, control.verdict.as_str(), control.wanted]);
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
                     solutions {} solvers of two libraries as references, which state their own error bounds. CVODE \
                     shares no code with the integrators; diffsol shares the linear algebra of nalgebra and faer. Closed forms are held to bounds derived from conditioning, orders to \
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
