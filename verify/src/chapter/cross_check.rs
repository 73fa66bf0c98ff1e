//! Methods, exact solutions, CVODE and diffsol against each other on every problem.

use rayon::prelude::*;

use super::{Context, Study, StudyError};
use crate::compare::cross_check;
use crate::evidence::{Evidence, Grid, Outcome, Requirement, Table};
use crate::problem;

pub(super) const STUDY: Study = Study {
    id: "cross-check",
    title: "Cross-checks against CVODE and diffsol",
    question: "Do the methods, the exact solutions and two independent libraries agree on every problem?",
    source: "all problems",
    run,
};

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let specs: Vec<_> = problem::paired().collect();
    context.announce(specs.len());
    let parts: Vec<Evidence> = specs
        .par_iter()
        .map(|spec| {
            let problem = problem::small(spec.name)?;
            let evidence = cross_check(spec.name, &*problem);
            context.tick();
            Ok(evidence)
        })
        .collect::<Result<_, StudyError>>()?;
    let mut grid = Grid::new("cross-check", String::new(), 1);
    let mut all = Evidence::default();
    for (spec, part) in specs.iter().zip(parts) {
        for check in &part.checks {
            // `problem/equation/solver`; one solver meets one equation of a problem.
            let solver = check.id.rsplit('/').next().unwrap_or_default();
            let bound = check.required.map(Requirement::scale);
            let ratio = check.measured.zip(bound).map(|(difference, bound)| (difference / bound).log10());
            let agrees = matches!(check.required, Some(Requirement::AtMost(_)));
            // A method that passes without agreeing is one that was predicted to go astray.
            let is_predicted = check.outcome == Outcome::Pass && !agrees;
            // No difference at all is as good as two decades.
            let strain = (!is_predicted).then(|| ratio.map_or(0.0, |ratio| 1.0 + 0.5 * ratio));
            grid.push(solver, spec.name, ratio, strain, &check.id);
        }
        all.checks.extend(part.checks);
        all.tables.extend(part.tables.into_iter().map(|table| Table { shown: false, ..table }));
    }
    grid.caption = caption(&grid);
    all.grids.push(grid);
    all.notes.push(
        "The equations that CVODE and diffsol solve are written by hand in each problem, apart from the ones that the \
         methods differentiate; a test holds the two against each other. Each reference is solved at two tolerances, and \
         twice the difference is its bound. On the Poiseuille ansatz the closures converge to different equations, so \
         each is compared with solutions of its own."
            .into(),
    );
    Ok(all)
}

/// What the numbers are, and why so many are the same.
fn caption(grid: &Grid) -> String {
    let is_half = |value: f64| (value - 0.5_f64.log10()).abs() < 0.05;
    let shown = || grid.cells.iter().filter_map(|cell| cell.value);
    format!(
        "log₁₀ of the largest difference over its bound, solver by problem: −1 is ten times closer than the bound. The bound of a method \
         is twice the error that its own two runs predict, so that a method whose error is as predicted stands at log₁₀ ½ = −0.3, as \
         {} of {} cells do. A cell leads to its check. It is blank where the solver is not made for the problem.",
        shown().filter(|value| is_half(*value)).count(),
        shown().count()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_caption_counts_what_is_as_predicted() {
        let mut grid = Grid::new("g", "", 1);
        for (place, value) in [-0.30, -0.32, -0.5, 8.0].into_iter().enumerate() {
            grid.push("m", &place.to_string(), Some(value), Some(0.0), "c");
        }
        grid.push("m", "none", None, None, "c");
        assert!(caption(&grid).contains("as 2 of 4 cells do"), "{}", caption(&grid));
    }
}
