//! Published end values of stiff problems: how many of their digits stand, and what the adaptive method gives.

use super::{Context, Study, StudyError, prose};
use crate::evidence::{Cell, Check, Evidence, Requirement, Table};
use crate::experiment::published_values::PublishedValues;
use crate::problem;
use crate::row;

pub(super) const STUDY: Study = Study {
    id: "published-values",
    title: "Published end values",
    question: "How many digits of the published solutions of stiff test problems are correct, and does `radau-adaptive` reproduce them?",
    source: "Mazzia and Magherini, Test Set for Initial Value Problem Solvers, 2008; [HW96] IV.10",
    run,
};

/// Digits asked of a run: its tolerance 1e-9 leaves six on a stiff component.
const DIGITS: f64 = 6.0;

/// Digits asked of a published value: those that all solvers of the test set were compared in.
const STAND: f64 = 9.0;

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let digits = problem::tabulated_digits().to_string();
    let tolerance = PublishedValues::TOLERANCE;
    let (mut checks, mut rows) = (Vec::new(), Vec::new());
    for found in context.get(PublishedValues)?.iter() {
        let id = found.source.to_lowercase().replace(|c: char| !c.is_ascii_alphanumeric(), "-");
        checks.push(Check::new(
            format!("{id}/published"),
            format!("The values of {} at t = {} stand: fewest digits of a component", found.problem, found.t),
            found.stand,
            Requirement::AtLeast(STAND),
            format!("against {digits}-digit arithmetic"),
        ));
        checks.push(Check::new(
            format!("{id}/radau-adaptive"),
            format!("radau-adaptive finds them: fewest digits of a component on {}", found.problem),
            found.found,
            Requirement::AtLeast(DIGITS),
            format!("relative tolerance {tolerance:e}"),
        ));
        let [stand, by_radau] = [found.stand, found.found].map(Cell::found);
        let start = row![&found.problem, found.t, &found.source, found.components, found.printed];
        rows.push([start, vec![stand, by_radau, found.steps.into()]].concat());
    }
    let caption = format!(
        "Published solutions at their end times. Digits are −log₁₀ of the largest relative error of a component, against \
         solutions in {digits}-digit arithmetic; `radau-adaptive` ran with a relative tolerance of {tolerance:e}."
    );
    let columns =
        ["problem", "t", "source", "components", "printed_digits", "digits_that_stand", "radau_digits", "radau_steps"];
    Ok(Evidence {
        checks,
        tables: vec![Table::new("published-values", caption, columns, rows)],
        notes: prose::fill(include_str!("published_values.md"), &[("digits", digits)])?,
        ..Evidence::default()
    })
}
