//! Where the references that solvers are judged by are in doubt themselves.

use super::answer::{Answer, STEPS, Solved, is_near};
use super::{Compared, RESOLVED, Standing};
use crate::measure::decimal::{plain, significant};
use crate::measure::norm::{Extremes, distance, max_norm};
use crate::problem::Problem;
use crate::problem::changes::changes;
use crate::reference;
use crate::run::passed_over;

/// Growth of a distance from one sample to the next that is the equation's and no accident: a distance between two scalars may pass
/// near zero, but not between all pairs of references at once.
pub(super) const GROWTH: f64 = 100.0;

/// Where the references themselves part before the horizon: what is said then.
///
/// Two solutions whose distance grows from d₁ at t₁ to d₂ at t₂ tell the rate ln(d₂/d₁)/(t₂ − t₁) of the growth, where it is the equation's:
/// what it magnifies between two solvers it magnifies between the two runs of each, so that their bounds know of it. They do not know
/// of what both runs of one have passed over.
pub(super) fn parting(times: &[f64], references: &[Solved]) -> Option<String> {
    let answers: Vec<_> = references.iter().filter_map(|(_, answer)| answer.as_ref().ok()).collect();
    let pairs = || answers.iter().enumerate().flat_map(|(i, a)| answers[..i].iter().map(move |b| (a, b)));
    let apart = |k: usize| pairs().map(|(a, b)| distance(&a.states[k], &b.states[k])).largest();
    let lost = |k: &usize| apart(*k) > RESOLVED * answers.iter().map(|answer| max_norm(&answer.states[*k])).largest();
    let first_lost = (0..times.len()).find(lost)?;
    // From where they part on the distance has no room left to grow.
    let last = first_lost.max(1);
    let growth = apart(last) / apart(last - 1);
    if growth.is_nan() || growth <= GROWTH {
        return None;
    }
    let is_foreseen = pairs().all(|(a, b)| distance(&a.states[last], &b.states[last]) <= a.bound + b.bound);
    let why = if is_foreseen {
        format!("Differences grow like e^({:.2} t)", growth.ln() / (times[last] - times[last - 1]))
    } else {
        "Their own bounds do not allow for that, as where one has passed over what f does for a moment".to_owned()
    };
    Some(format!(
        "The references part: by {:.1e} at t = {}, by {:.1e} at t = {}. {why}, and from there on a disagreement says nothing of a solver. \
         Compare up to t = {}.",
        apart(last - 1),
        plain(times[last - 1]),
        apart(last),
        plain(times[last]),
        plain(times[last - 1])
    ))
}

/// Takes back what was decided by references where solvers disagree of which no bound knows what it does not see, and says why.
pub(super) fn doubt(
    problem: &dyn Problem,
    horizon: f64,
    parting: Option<&str>,
    solved: &[Solved],
    rows: &mut [Compared],
) -> Option<String> {
    let is_by_reference =
        |row: &Compared| row.truth.as_deref().is_some_and(|truth| reference::by_name(truth).is_some());
    if !rows.iter().any(is_by_reference) {
        return None;
    }
    let is_model = problem.facts().model.is_some();
    let is_contested = rows.iter().any(|row| row.standing == Standing::Differs && is_by_reference(row));
    let contested = || is_contested.then_some(());
    // What all pass over nobody contests.
    let note = contested()
        .and_then(|()| overlooked(problem, horizon))
        .or_else(|| {
            let passed_over = is_model.then(|| passed_over(problem, horizon)).flatten()?;
            Some(format!("The references are in doubt: {passed_over}. A shorter time about it tells."))
        })
        .or_else(|| contested().and_then(|()| parting.map(str::to_owned)))
        .or_else(|| contested().filter(|()| is_model).and_then(|()| contradicted(solved, rows)))?;
    let is_told = |row: &&mut Compared| matches!(row.standing, Standing::Agrees | Standing::Differs);
    for row in rows.iter_mut().filter(is_told).filter(|row| is_by_reference(row)) {
        row.standing = Standing::Unresolved;
        row.status = "not resolved: the references are in doubt".into();
    }
    Some(note)
}

/// That f changes by itself faster than steps see: a solver that passes over it and one that does not are each within bounds that know
/// nothing of it.
fn overlooked(problem: &dyn Problem, horizon: f64) -> Option<String> {
    let stops: Vec<f64> = (1..=STEPS).map(|step| horizon * step as f64 / STEPS as f64).collect();
    let changes = changes(problem, horizon, &stops);
    let (first, last) = (changes.first()?, changes.last()?);
    Some(format!(
        "The references are in doubt: from t = {} to t = {} f changes by itself faster than {STEPS} steps see, and solvers that choose their steps \
         may pass over it, within bounds that do not know. A shorter time about it tells.",
        significant(*first, 5),
        significant(*last, 5)
    ))
}

/// That the methods of fixed steps agree against the references: at least two of them, with each other and none with the truth.
///
/// That is for models, where methods and references share f. Elsewhere f is stated twice, and such methods are wrong together.
fn contradicted(solved: &[Solved], rows: &[Compared]) -> Option<String> {
    let by_steps = |standing: Standing| -> Vec<(&str, &Answer)> {
        let answers = solved.iter().zip(rows).filter(|(_, row)| row.standing == standing);
        let answers = answers.filter_map(|((name, answer), _)| Some((name.as_str(), answer.as_ref().ok()?)));
        answers.filter(|(_, answer)| answer.runs.is_some()).collect()
    };
    let against = by_steps(Standing::Differs);
    let agree = against.iter().enumerate().all(|(i, (_, a))| against[..i].iter().all(|(_, b)| is_near(a, b)));
    if against.len() < 2 || !agree || !by_steps(Standing::Agrees).is_empty() {
        return None;
    }
    let names: Vec<&str> = against.iter().map(|(name, _)| *name).collect();
    Some(format!(
        "The references are in doubt: {} agree with each other, and no method of fixed steps agrees with the references. Steps that are \
         chosen may pass over what f does for a moment; a shorter time tells.",
        names.join(", ")
    ))
}
