//! CVODE on the same semi-discrete cavity.

use super::{Context, Scale, StudyError, brief, measured, prose, short, times};
use crate::evidence::{Cell, Check, Evidence, Outcome, Requirement, Table};
use crate::experiment::flow::against_cvode::{AgainstCvode, Found, Loose, Row};
use crate::row;

/// CVODE on the same semi-discrete cavity, written by hand.
pub(super) fn cross_check(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    let cells = scale.reference;
    let end = AgainstCvode::END;
    let statement = format!("Method I and CVODE agree on the cavity of {cells} cells a side at t = {end}");
    let found = context.get(AgainstCvode { cells })?;
    let found = match &*found {
        Ok(found) => found,
        Err(absent) => {
            evidence.checks.push(Check::undecided("cvode", statement, Outcome::NotRun, absent.clone()));
            return Ok(());
        }
    };
    let [coarse, middle, finest] = found.rows.as_slice() else { return Err("three runs".into()) };
    evidence.checks.push(agrees(statement, finest, found));
    let excess = finest.difference - (finest.predicted + found.bound);
    // From a h² + b h³ with steps of 4h and 2h; a third of the difference of the errors with 2h and h has 7/3 of b h³.
    let of_third_order = (coarse.difference - 4.0 * middle.difference) / 32.0;
    let alike = match found.as_accurate(finest.difference) {
        Some(Loose { tolerance, work, seconds, difference }) => format!(
            "Of tolerances a quarter of a decade apart, {} gives CVODE the error that is nearest to that of Method I from below, {} of it; with \
             that it takes {} steps, {} evaluations, {} products and {} s, and Method I {} times the CPU time",
            brief(*tolerance),
            brief(difference / finest.difference),
            work.steps,
            work.rhs,
            work.products,
            measured(*seconds),
            times(finest.seconds, *seconds),
        ),
        None => "None of its looser solves is as accurate as Method I".into(),
    };
    let values = [
        ("alike", alike),
        ("cells", cells.to_string()),
        ("re", short(AgainstCvode::RE)),
        ("end", short(end)),
        ("tolerance", short(AgainstCvode::TOLERANCE)),
        ("seconds", measured(found.cvode_seconds)),
        ("h", short(end / f64::from(finest.steps))),
        ("difference", short(finest.difference)),
        ("excess", brief(excess.abs())),
        ("more", if excess > 0.0 { "above" } else { "below" }.into()),
        ("share", short(share(finest, found))),
        ("allowed", short(ALLOWED)),
        ("verdict", verdict(share(finest, found)).into()),
        ("first_ratio", short(coarse.difference / middle.difference)),
        ("second_ratio", short(middle.difference / finest.difference)),
        ("missed", brief(-4.0 / 3.0 * of_third_order)),
        ("predicted", short(finest.predicted)),
        ("bound", short(found.bound)),
        ("steps", found.cvode.steps.to_string()),
        ("rhs", found.cvode.rhs.to_string()),
        ("products", found.cvode.products.to_string()),
        ("own_systems", finest.cost.solves.to_string()),
        ("own_products", finest.cost.inner.to_string()),
        ("accuracy", brief(finest.predicted / found.bound)),
        ("own_seconds", measured(finest.seconds)),
    ];
    evidence.notes.extend(prose::fill(include_str!("cvode.md"), &values)?);
    evidence.timings.push((format!("cavity, N = {cells}, by CVODE"), found.cvode_seconds.least));
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    for Row { steps, cost, seconds, difference, predicted } in &found.rows {
        evidence.timings.push((format!("cavity, N = {cells}, by Method I, {steps} steps"), cost.seconds));
        let (h, predicted) = (end / f64::from(*steps), Cell::found(*predicted));
        let counts = [u64::from(*steps), cost.residuals, cost.inner, cost.solves].map(Cell::from);
        let measured = [seconds.least, seconds.most, *difference].map(Cell::from).into_iter().chain([predicted]);
        rows.push(row!["method-i", h, Cell::Empty].into_iter().chain(counts).chain(measured).collect());
    }
    let finest = (AgainstCvode::TOLERANCE, &found.cvode, found.cvode_seconds, Cell::Empty, found.bound.into());
    let looser = found.loose.iter().map(|run| {
        let Loose { tolerance, work, seconds, difference } = run;
        (*tolerance, work, *seconds, Cell::from(*difference), Cell::Empty)
    });
    for (tolerance, work, seconds, difference, bound) in [finest].into_iter().chain(looser) {
        let counts = row![work.steps, work.rhs, work.products, Cell::Empty];
        let measured = row![seconds.least, seconds.most, difference, bound];
        rows.push(row!["cvode-bdf", Cell::Empty, tolerance].into_iter().chain(counts).chain(measured).collect());
    }
    let caption = format!(
        "The same semi-discrete cavity of {cells} cells a side, Re = {}, at t = {end}, by Method I and by CVODE, whose Newton iteration \
         has GMRES and products with the Jacobian by hand. Counted are steps, evaluations of f, products with the Jacobian and systems of Gauss–Newton steps. \
         Method I has products with B and Bᵀ, and for the first system after a factorisation of B neither. Seconds are the least and the most of \
         CPU time of up to three such runs. The difference is the largest of a velocity from CVODE's with its smallest tolerance; beside it \
         is what each expects its own error to be; the longest steps and the looser tolerances have nothing to tell it by.",
        AgainstCvode::RE
    );
    let columns = [
        "method",
        "h",
        "tolerance",
        "steps",
        "rhs",
        "products",
        "systems",
        "least_seconds",
        "most_seconds",
        "difference",
        "own_bound",
    ];
    evidence.tables.push(Table::new("flow-cvode", caption, columns, rows));
    Ok(())
}

/// What Method I costs beside CVODE for equal errors.
pub(super) fn in_cpu_time(context: &Context, scale: &Scale) -> Result<String, StudyError> {
    let cells = scale.reference;
    let found = context.get(AgainstCvode { cells })?;
    let Ok(found) = &*found else { return Ok("CVODE is not there to compare with".into()) };
    let finest = found.rows.last().ok_or("no run")?;
    let against = found.as_accurate(finest.difference).map(|loose| times(finest.seconds, loose.seconds));
    let cost = against.map_or("an unknown multiple of".into(), |times| format!("{times} times"));
    Ok(format!(
        "In the cavity of {cells}² cells at Re = {} Method I takes {cost} the CPU time of CVODE",
        short(AgainstCvode::RE)
    ))
}

/// The difference of a run of Method I from CVODE over what the two expect.
fn share(run: &Row, found: &Found) -> f64 {
    run.difference / (run.predicted + found.bound)
}

/// The part of that which passes: a quarter more, as the estimate of Method I knows of no error of third order.
const ALLOWED: f64 = 1.25;

/// How the check of it ends.
fn verdict(share: f64) -> &'static str {
    match share {
        share if share <= 1.0 => "passes and would without an allowance",
        share if share <= ALLOWED => "passes by its allowance alone",
        _ => "fails",
    }
}

/// That a run of Method I and CVODE differ by no more than what the two expect.
fn agrees(statement: String, run: &Row, found: &Found) -> Check {
    Check::new(
        "cvode",
        statement,
        share(run, found),
        Requirement::AtMost(ALLOWED),
        "the difference over what Method I's own two runs predict and CVODE's bound; a quarter for the terms beyond the second order",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::flow::{Cost, Seconds};
    use crate::reference::Work;

    #[test]
    fn velocities_beyond_what_the_two_expect_do_not_agree() {
        let outcome = |difference: f64, predicted: f64| {
            let (cost, seconds) = (Cost::default(), Seconds::NONE);
            let run = Row { steps: 1, cost, seconds, difference, predicted };
            let (rows, loose, cvode, bound) = (Vec::new(), Vec::new(), Work::default(), 1e-5);
            let check = agrees(String::new(), &run, &Found { rows, loose, cvode, cvode_seconds: seconds, bound });
            assert_eq!(verdict(check.measured.unwrap_or(f64::NAN)) == "fails", check.outcome != Outcome::Pass);
            check.outcome
        };
        assert_eq!(outcome(1.2e-4, 9e-5), Outcome::Pass);
        assert_eq!([0.9, 1.1].map(verdict), ["passes and would without an allowance", "passes by its allowance alone"]);
        assert_eq!(outcome(1.3e-4, 9e-5), Outcome::Fail);
        assert_ne!(outcome(1e-4, f64::NAN), Outcome::Pass);
    }
}
