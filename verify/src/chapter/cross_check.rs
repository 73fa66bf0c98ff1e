//! Methods, exact solutions, CVODE and diffsol against each other on every problem.

use super::parts::scope;
use super::{Context, Study, StudyError};
use crate::evidence::{Cell, Check, Evidence, Grid, Outcome, Requirement, Table, is_plain};
use crate::experiment::cross_check::{Compared, Comparison, CrossChecks, SAMPLES, Standing};
use crate::measure::decimal::plain;

pub(super) const STUDY: Study = Study {
    id: "cross-check",
    title: "Cross-checks against CVODE and diffsol",
    question: "Do the methods, the exact solutions and two independent libraries agree on every problem but the two-dimensional flows?",
    source: "all problems but the two-dimensional flows",
    run,
};

/// What a comparison says: a check for every solver, and all of them in a table.
#[must_use]
pub fn evidence(comparison: &Comparison) -> Evidence {
    let name = &comparison.problem;
    let number = |x: Option<f64>| x.map_or(Cell::Empty, Cell::Number);
    let row = |compared: &Compared| {
        vec![
            Cell::Text(compared.equation.0.into()),
            Cell::Text(compared.solver.clone()),
            Cell::Text(compared.truth.as_deref().unwrap_or("none").into()),
            number(compared.difference),
            number(compared.bound),
            Cell::Text(compared.status.clone()),
        ]
    };
    let caption = format!(
        "Solvers of {name} at {SAMPLES} times up to t = {}: largest difference to the truth, and the bound on it \
         that the solver itself gives.",
        plain(comparison.horizon)
    );
    let columns = ["equation", "solver", "truth", "difference", "bound", "status"];
    let rows = comparison.solvers.iter().map(row).collect();
    Evidence {
        checks: comparison.solvers.iter().map(|compared| check(name, compared)).collect(),
        tables: vec![Table::new(
            format!("cross-check-{}", name.replace(|c| !is_plain(c), "-")),
            caption,
            columns,
            rows,
        )],
        notes: comparison.notes.clone(),
        ..Evidence::default()
    }
}

fn check(name: &str, compared: &Compared) -> Check {
    let Compared { equation: (equation, reason), solver, standing, .. } = compared;
    let truth = compared.truth.as_deref().unwrap_or("none");
    let is_predicted = matches!(standing, Standing::Astray | Standing::Unforeseen);
    let [does, why] = if is_predicted { ["does not follow", ", as theory predicts"] } else { ["agrees with", ""] };
    Check {
        id: format!("{name}/{equation}/{solver}"),
        statement: format!("{solver} {does} {truth} on {name}{why}, {reason}"),
        outcome: outcome(*standing),
        measured: compared.difference,
        required: required(compared),
        reason: compared.status.clone(),
    }
}

fn outcome(standing: Standing) -> Outcome {
    match standing {
        Standing::Agrees | Standing::Astray => Outcome::Pass,
        Standing::Differs | Standing::Unforeseen => Outcome::Fail,
        Standing::Unresolved | Standing::Undecided => Outcome::Inconclusive,
        Standing::NotRun => Outcome::NotRun,
    }
}

/// Of the difference, which decides alone unless the bound is too wide.
fn required(compared: &Compared) -> Option<Requirement> {
    let (difference, bound) = compared.difference.zip(compared.bound)?;
    match compared.standing {
        Standing::Unforeseen => Some(Requirement::Above(bound)),
        // One that a wide bound covers is astray for the width.
        Standing::Astray => (difference > bound || difference.is_nan()).then_some(Requirement::Above(bound)),
        _ => Some(Requirement::AtMost(bound)),
    }
}

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let mut grid = Grid::new("cross-check", String::new(), 1);
    let mut all = Evidence::default();
    let comparisons = context.get(CrossChecks)?;
    for comparison in comparisons.iter() {
        let part = evidence(comparison);
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
            grid.push(solver, &comparison.problem, ratio, strain, &check.id);
        }
        all.checks.extend(part.checks);
        all.tables.extend(part.tables.into_iter().map(|table| Table { shown: false, ..table }));
    }
    grid.caption = caption(&grid);
    all.grids.push(grid);
    all.notes.push(scope(comparisons.iter().map(|comparison| comparison.problem.as_str())));
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
         is twice the error that its own two runs predict and a rounding for each step, and the truth's own bound comes on top; a method whose error \
         is as predicted, and far above both, stands at log₁₀ ½ = −0.3, as {} of {} cells do. A cell leads to its check. It is blank where a solver comes to no end, or is not run.",
        shown().filter(|value| is_half(*value)).count(),
        shown().count()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A model is named after its file.
    #[test]
    fn the_table_of_any_name_is_a_file() {
        let (solvers, notes) = (Vec::new(), Vec::new());
        let comparison = Comparison { problem: "(a b)".into(), horizon: 1.0, solvers, notes };
        assert_eq!(evidence(&comparison).tables[0].id, "cross-check--a-b-");
    }

    /// What is printed as required is what was: the outcome follows from it wherever the bound resolves the truth.
    #[test]
    fn the_requirement_beside_an_outcome_is_the_one_that_decided_it() {
        let compared = |difference: f64, standing| Compared {
            equation: ("e", "for a reason"),
            solver: "s".into(),
            truth: Some("exact".into()),
            difference: Some(difference),
            bound: Some(2e-3),
            standing,
            status: String::new(),
        };
        for (difference, standing) in [
            (1e-3, Standing::Agrees),
            (3e-3, Standing::Differs),
            (1e-3, Standing::Unforeseen),
            (3e-3, Standing::Astray),
            (f64::NAN, Standing::Differs),
        ] {
            let check = check("p", &compared(difference, standing));
            let is_met = check.required.map(|required| required.is_met_by(difference));
            assert_eq!(is_met, Some(check.outcome == Outcome::Pass), "{standing:?}");
        }
        assert_eq!(check("p", &compared(1e-3, Standing::Astray)).required, None, "the bound is too wide");
    }

    #[test]
    fn every_standing_has_its_outcome_and_every_number_its_column() {
        let compared = |standing| Compared {
            equation: ("e", "for a reason"),
            solver: "s".into(),
            truth: Some("exact".into()),
            difference: Some(0.5),
            bound: Some(0.25),
            standing,
            status: "so".into(),
        };
        for (standing, expected, says) in [
            (Standing::Agrees, Outcome::Pass, "s agrees with exact on p"),
            (Standing::Unresolved, Outcome::Inconclusive, "s agrees with exact on p"),
            (Standing::Differs, Outcome::Fail, "s agrees with exact on p"),
            (Standing::Astray, Outcome::Pass, "s does not follow exact on p, as theory predicts"),
            (Standing::Unforeseen, Outcome::Fail, "s does not follow exact on p, as theory predicts"),
            (Standing::Undecided, Outcome::Inconclusive, "s agrees with exact on p"),
            (Standing::NotRun, Outcome::NotRun, "s agrees with exact on p"),
        ] {
            let check = check("p", &compared(standing));
            assert_eq!((check.outcome, check.statement), (expected, format!("{says}, for a reason")));
        }
        let all = Comparison {
            problem: "p".into(),
            horizon: 1.0,
            solvers: vec![compared(Standing::Agrees)],
            notes: Vec::new(),
        };
        let table = &evidence(&all).tables[0];
        let cell = |column: &str| {
            let place = table.columns.iter().position(|name| name == column).expect("a column");
            table.rows[0][place].to_string()
        };
        assert_eq!(["difference", "bound", "truth", "status"].map(cell), ["0.5", "0.25", "exact", "so"]);
    }

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
