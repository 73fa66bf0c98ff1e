//! Published end values of stiff problems: how many of their digits stand, and what the adaptive method gives.

use lsvi::adaptive::Tolerances;
use rayon::prelude::*;

use super::{Context, Study, StudyError};
use crate::evidence::{Cell, Check, Evidence, Requirement, Table};
use crate::measure::norm::Extremes;
use crate::method;
use crate::problem::{self, Published};
use crate::run::run as integrate;

pub(super) const STUDY: Study = Study {
    id: "published-values",
    title: "Published end values",
    question: "How many digits of the published solutions of stiff test problems stand, and does `radau-adaptive` find them?",
    source: "Mazzia and Magherini, Test Set for Initial Value Problem Solvers, 2008; [HW96] IV.10",
    run,
};

/// Relative tolerance of the runs; the absolute one is this of the smallest end value, so that every component counts.
const TOLERANCE: f64 = 1e-9;

/// Digits asked of a run: its tolerance 1e-9 leaves six on a stiff component.
const DIGITS: f64 = 6.0;

/// Digits asked of a published value: those that all solvers of the test set were compared in.
const STAND: f64 = 9.0;

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let values = problem::published()?;
    // One run for each solution; a problem may have been published twice.
    let groups: Vec<&[Published]> = values.chunk_by(|a, b| a.source == b.source).collect();
    context.announce(groups.len());
    let rows = groups.par_iter().map(|values| {
        let row = measure(values);
        context.tick();
        row
    });
    let mut evidence = Evidence { notes: notes(), ..Evidence::default() };
    let mut rows_of_table = Vec::new();
    for row in rows.collect::<Result<Vec<_>, _>>()? {
        let id = row.source.to_lowercase().replace(|c: char| !c.is_ascii_alphanumeric(), "-");
        evidence.checks.push(Check::new(
            format!("{id}/published"),
            format!("The values of {} at t = {} stand: fewest digits of a component", row.problem, row.t),
            row.stand,
            Requirement::AtLeast(STAND),
            "against 40-digit arithmetic",
        ));
        evidence.checks.push(Check::new(
            format!("{id}/radau-adaptive"),
            format!("radau-adaptive finds them: fewest digits of a component on {}", row.problem),
            row.found,
            Requirement::AtLeast(DIGITS),
            format!("relative tolerance {TOLERANCE:e}"),
        ));
        rows_of_table.push(vec![
            Cell::from(row.problem),
            Cell::Number(row.t),
            Cell::from(row.source),
            Cell::Integer(row.components as i64),
            Cell::Integer(row.printed as i64),
            Cell::found(row.stand),
            Cell::found(row.found),
            Cell::Integer(row.steps as i64),
        ]);
    }
    evidence.tables.push(Table::new(
        "published-values",
        format!(
            "Published solutions at their end times. Digits are −log₁₀ of the largest relative error of a component, against \
             solutions in 40-digit arithmetic; `radau-adaptive` ran with a relative tolerance of {TOLERANCE:e}."
        ),
        &["problem", "t", "source", "components", "printed_digits", "digits_that_stand", "radau_digits", "radau_steps"],
        rows_of_table,
    ));
    Ok(evidence)
}

struct Row<'a> {
    problem: &'a str,
    t: f64,
    source: &'a str,
    components: usize,
    /// Fewest digits printed, confirmed, and found by `radau-adaptive`.
    printed: usize,
    stand: f64,
    found: f64,
    steps: u64,
}

fn measure(values: &[Published]) -> Result<Row<'_>, StudyError> {
    let first = &values[0];
    let problem = problem::build_setting(&first.problem)?;
    let truth = problem.tabulated(first.t).ok_or("the solution is tabulated")?;
    let smallest = truth.iter().map(|x| x.abs()).smallest();
    let tolerances = Tolerances::new(TOLERANCE, TOLERANCE * smallest)?;
    let method = method::parse("radau-adaptive")?.with_tolerances(tolerances).ok_or("it is adaptive")?;
    let run = integrate(&*problem, &*method, first.t, first.t, |_| {})?;
    let digits = run.end.q.iter().zip(&truth).map(|(found, truth)| -((found - truth) / truth).abs().log10());
    Ok(Row {
        problem: &first.problem,
        t: first.t,
        source: &first.source,
        components: values.len(),
        printed: values.iter().map(Published::printed_digits).min().unwrap_or(0),
        stand: values.iter().map(|v| v.confirmed_digits().unwrap_or(f64::NAN)).smallest(),
        found: digits.smallest(),
        steps: run.work.steps,
    })
}

fn notes() -> Vec<String> {
    vec![format!(
        "Reference solutions are themselves computed, and their last printed digits are not always right: here every \
             solution was computed anew in {}-digit arithmetic (`verify/data/stiff.py`).",
        problem::tabulated_digits()
    )]
}
