//! What several chapters build their evidence from.

use std::collections::BTreeSet;

use crate::evidence::{Check, Requirement};
use crate::measure::order::OrderFit;
use crate::problem;

/// Of which problems a chapter tells, how many that is of all, and where the others are.
pub(super) fn scope<'a>(problems: impl IntoIterator<Item = &'a str>) -> String {
    let here: BTreeSet<&str> = problems.into_iter().collect();
    let others: Vec<_> = problem::ALL.iter().filter(|spec| !here.contains(spec.name)).collect();
    let names: Vec<_> = others.iter().map(|spec| format!("`{}`", spec.name)).collect();
    format!(
        "These are {} of the {} problems. The other {}, {}, are the two-dimensional flows. Not every method can step them, and one run takes \
         as long as many here; the chapter `flows` measures orders on flows with known solutions, each on a fixed grid, and compares the cavity with CVODE.",
        problem::ALL.len() - others.len(),
        problem::ALL.len(),
        others.len(),
        names.join(", ")
    )
}

/// The verdict on an order of convergence.
pub(super) fn order_check(id: impl Into<String>, statement: impl Into<String>, fit: &OrderFit) -> Check {
    Check {
        id: id.into(),
        statement: statement.into(),
        outcome: fit.verdict.into(),
        measured: fit.line.map(|line| line.slope),
        required: Some(Requirement::Near(fit.expected.order, fit.expected.band)),
        reason: fit.reason.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_problems_that_are_left_out_are_counted_and_named() {
        let all = problem::ALL.len();
        let told = scope(problem::ALL[2..].iter().map(|spec| spec.name));
        let names = [0, 1].map(|place| format!("`{}`", problem::ALL[place].name)).join(", ");
        assert!(
            told.starts_with(&format!("These are {} of the {all} problems. The other 2, {names}, are", all - 2)),
            "{told}"
        );
        // What it calls them is what they are: the problems with a solver of their own.
        let paired: BTreeSet<&str> = problem::paired().map(|spec| spec.name).collect();
        for spec in problem::ALL.iter().filter(|spec| !paired.contains(spec.name)) {
            assert!(problem::small(spec.name).is_ok_and(|flow| flow.solver().is_some()), "{}", spec.name);
        }
    }
}
