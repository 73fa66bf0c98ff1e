//! What Method I loses on smooth nonlinear problems.

use std::sync::Arc;

use super::{Answer, prose};
use crate::chapter::{Context, StudyError};
use crate::evidence::number::{brief, rounded_down, rounded_up};
use crate::evidence::{Cell, Check, Requirement, Table};
use crate::experiment::course::{Course, Found};
use crate::measure::norm::Extremes;
use crate::method;

const METHODS: [&str; 6] =
    ["method-i", "trapezoidal", "implicit-midpoint", "ls-galerkin(2,gauss,2)", "ls-galerkin(3,gauss,3)", FAMILY];
/// The closure that stands for the (α, β) family, of which the table of methods tells.
pub(super) const FAMILY: &str = "linear(-0.5,1)";
pub(super) const PROBLEMS: [&str; 4] = ["quadratic-drag", "logistic", "damped-pendulum", "van-der-pol"];
/// So many, in a word.
pub(super) const COUNT: &str = "four";
const _: () = assert!(PROBLEMS.len() == 4);
const H: f64 = 0.05;
const END: f64 = 2.0;
/// The place of Gauss collocation, and the numbers of steps among which Method I has the one for as much work.
const GAUSS: usize = 3;
const STEPS: [u32; 13] = [20, 24, 28, 32, 36, 40, 44, 48, 52, 56, 60, 70, 80];

/// How far the reference may be off that the errors are measured against, as a part of the smallest of them: half a unit in the second digit of a
/// factor.
const KNOWN: f64 = 0.05;

/// A run as the answer compares them: by its largest error.
pub(super) fn setting(problem: &str, method: &'static str) -> Course {
    Course { problem: problem.into(), method, h: H, t_end: END }
}

/// The least error of a run with at most so many evaluations of f.
fn for_equal_work(runs: &[Arc<Found>], most: u64) -> f64 {
    runs.iter().filter(|run| run.evaluations <= most).map(|run| run.largest()).smallest()
}

pub(super) fn answer(context: &Context) -> Result<Answer, StudyError> {
    let runs = PROBLEMS.iter().flat_map(|problem| METHODS.map(|method| setting(problem, method))).collect();
    let runs = context.get_each(runs)?;
    let found: Vec<f64> = runs.iter().map(|found| found.largest()).collect();
    // Of those that a sentence tells of; what is below the bound is not shown.
    let told = runs.chunks(METHODS.len()).flat_map(|runs| &runs[..=GAUSS]);
    let unknown = told.map(|run| run.bound / run.largest()).largest();
    let shown: Vec<f64> =
        runs.iter().map(|run| if run.largest() > run.bound { run.largest() } else { f64::NAN }).collect();
    let mut work = Vec::new();
    for (problem, runs) in PROBLEMS.iter().zip(runs.chunks(METHODS.len())) {
        let own = STEPS.map(|n| Course { h: END / f64::from(n), ..setting(problem, METHODS[0]) });
        work.push(for_equal_work(&context.get_each(own.into())?, runs[GAUSS].evaluations));
    }
    let rows = PROBLEMS.iter().zip(shown.chunks(METHODS.len())).zip(&work).map(|((problem, errors), work)| {
        let start = [Cell::from(*problem), Cell::from(H), Cell::from(END)];
        start.into_iter().chain(errors.iter().chain([work]).copied().map(Cell::found)).collect()
    });
    let caption = "Largest errors on the grid points of (0, t_end] with steps of h; `ls-galerkin(S,gauss,S)` is Gauss collocation of order 2S, and `linear(-0.5,1)` stands for the (α, β) family; empty below the bound on the solution that it is measured against. Last, the least of these of Method I \
                   for at most as many evaluations of f as Gauss collocation with two nodes takes.";
    let columns: Vec<&str> =
        ["problem", "h", "t_end"].into_iter().chain(METHODS).chain(["method_i_for_equal_work"]).collect();
    let table = Table::data("answer-smooth-errors", caption, columns, rows.collect());
    // Least and largest error of Method I over that of another method.
    let ratios = |other: usize| {
        let ratios = || found.chunks(METHODS.len()).map(|errors| errors[0] / errors[other]);
        (ratios().smallest(), ratios().largest())
    };
    let (trapezoidal, midpoint, (gauss, _)) = (ratios(1), ratios(2), ratios(GAUSS));
    let equal_work = found.chunks(METHODS.len()).zip(&work).map(|(errors, work)| work / errors[GAUSS]).smallest();
    let checks = vec![
        Check::at_most(
            "smooth/known",
            "The solutions that the errors are measured against are known better: largest bound on their errors over the error of a run",
            unknown,
            KNOWN,
            "closed forms, and of damped-pendulum and van-der-pol the reference with the least bound",
        ),
        Check::new(
            "smooth/midpoint",
            "Method I is less accurate than the implicit midpoint rule: least ratio of their errors",
            midpoint.0,
            Requirement::Above(1.0),
            "equal steps",
        ),
        Check::new(
            "smooth/gauss",
            "Gauss collocation of order 4 is more accurate by two digits: least ratio of Method I's error to its",
            gauss,
            Requirement::AtLeast(100.0),
            "equal steps",
        ),
        Check::new(
            "smooth/work",
            "It is for as many evaluations of f too: least ratio of Method I's error to its",
            equal_work,
            Requirement::AtLeast(100.0),
            "the best of Method I's runs with as many evaluations at most",
        ),
    ];
    let order = |place: usize| Ok::<_, StudyError>(method::parse(METHODS[place])?.order().to_string());
    let at_least = |ratio| brief(rounded_down(ratio, 2));
    let at_most = |ratio| brief(rounded_up(ratio, 2));
    let values = [
        ("problems", COUNT.into()),
        ("order", order(0)?),
        ("trapezoidal_order", order(1)?),
        ("gauss_order", order(GAUSS)?),
        ("h", H.to_string()),
        ("end", END.to_string()),
        ("trapezoidal_low", at_least(trapezoidal.0)),
        ("trapezoidal_high", at_most(trapezoidal.1)),
        ("midpoint_low", at_least(midpoint.0)),
        ("midpoint_high", at_most(midpoint.1)),
        ("gauss", at_least(gauss)),
        ("equal_work", at_least(equal_work)),
    ];
    Ok(Answer {
        id: "answer-smooth",
        question: "What would I lose with Method I against the trapezoidal rule, or Gauss collocation?",
        short: format!(
            "with steps of {H} a factor of up to {}, or of {} and more",
            at_most(trapezoidal.1),
            at_least(gauss)
        ),
        text: prose::fill(include_str!("smooth.md"), &values)?,
        checks,
        figure: None,
        table,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_work_is_no_more_evaluations_and_the_least_error_for_it() {
        let runs = [(100, 4.0), (210, 1.0), (200, 2.0), (211, 0.5)];
        let runs = runs.map(|(evaluations, error)| {
            Arc::new(Found {
                errors: vec![(1.0, 0.5), (2.0, error)],
                bound: 0.0,
                state: vec![],
                exact: vec![],
                evaluations,
            })
        });
        assert_eq!(for_equal_work(&runs, 210), 1.0);
        assert!(for_equal_work(&runs, 99).is_nan());
    }
}
