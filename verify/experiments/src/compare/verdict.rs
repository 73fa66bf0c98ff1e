//! How an answer stands to the truth, and why.

use super::answer::{Answer, Gap, Runs, is_near, largest, largest_distance};
use super::{RESOLVED, SETTLED, Standing};
use crate::measure::decimal::{decimals, significant, trimmed};
use crate::theory::Breakdown;

/// What is said of a solution that rests at 0.
const ZERO: &str = "agrees, but the solution is zero, of which no bound is a small part";

/// The decision on one answer.
pub(super) fn judge(answer: &Result<Answer, Gap>, truth: Option<&Answer>) -> (Standing, String) {
    let (answer, truth) = match (answer, truth) {
        (Err(Gap::NotRun(reason)), _) => return (Standing::NotRun, format!("not run: {reason}")),
        (Err(Gap::BrokeDown(reason)), _) => return (Standing::Astray, reason.clone()),
        // What gave no answer disagrees with nothing, and agrees with nothing.
        (Err(Gap::Failed(reason)), _) => return (Standing::Undecided, format!("failed: {reason}")),
        (Ok(_), None) => return (Standing::Undecided, "there is nothing to compare with".into()),
        (Ok(answer), Some(truth)) => (answer, truth),
    };
    let bound = answer.bound + truth.bound;
    let near = is_near(answer, truth);
    let resolved = bound <= RESOLVED * largest(&truth.states);
    match (near && resolved, answer.astray) {
        (true, Some(Breakdown { reason, is_certain: true })) => {
            (Standing::Unforeseen, format!("agrees, against what is declared: {reason}"))
        }
        (true, _) => (Standing::Agrees, agreement(answer)),
        (false, Some(breakdown)) => where_it_may_break_down(near, breakdown, answer, truth),
        (false, None) if near && largest(&truth.states) == 0.0 => (Standing::Unresolved, ZERO.into()),
        (false, None) if near => (Standing::Unresolved, too_wide(answer)),
        (false, None) => match answer.runs.filter(|runs| !runs.is_settled) {
            Some(runs) => (Standing::Unresolved, unsettled(&runs)),
            None => (Standing::Differs, difference(answer)),
        },
    }
}

/// The decision on an answer that is not known to agree, where a failure is declared.
fn where_it_may_break_down(near: bool, breakdown: Breakdown, answer: &Answer, truth: &Answer) -> (Standing, String) {
    let Breakdown { reason, is_certain } = breakdown;
    if !near && is_certain {
        return (Standing::Astray, format!("goes astray, as declared: {reason}"));
    }
    if !near {
        return (Standing::Unresolved, format!("goes astray, as it may by then: {reason}"));
    }
    // Where the bound of its own runs covers a difference as large as this, they are astray too.
    let is_far = largest_distance(&answer.states, &truth.states) > RESOLVED * largest(&truth.states);
    if is_certain && is_far {
        return (Standing::Astray, format!("goes astray, and so do its own runs, as declared: {reason}"));
    }
    (Standing::Unresolved, format!("{}; {reason}", too_wide(answer)))
}

/// An agreement, with the step that it takes where longer ones would not do.
fn agreement(answer: &Answer) -> String {
    match answer.runs.and_then(|runs| Some((runs.h, runs.longer?))) {
        Some((h, longer)) => format!("agrees with h = {}; in longer steps {longer}", significant(h, 2)),
        None => "agrees".into(),
    }
}

/// A disagreement, with the order of the runs where it is not the one that the bound is taken with.
pub(super) fn difference(answer: &Answer) -> String {
    let told = "differs by more than the bounds allow";
    let other = answer.runs.and_then(|Runs { order, observed, .. }| Some((order, observed?)));
    match other.filter(|(order, observed)| (order - observed).abs() > SETTLED) {
        Some((order, observed)) => {
            format!("{told}, of an order {}: its runs differ by order {}", trimmed(order, 3), decimals(observed, 1))
        }
        None => told.into(),
    }
}

/// A bound that decides nothing, with the steps of the runs that it is from.
pub(super) fn too_wide(answer: &Answer) -> String {
    let told = "agrees, but the bounds are too wide to tell";
    match answer.runs {
        Some(Runs { h, .. }) => {
            format!("{told} at h = {}, the shortest steps taken: an earlier end may tell", significant(h, 2))
        }
        None => told.into(),
    }
}

/// Runs whose differences predict no error.
pub(super) fn unsettled(Runs { h, order, observed, earlier, .. }: &Runs) -> String {
    let by = match (earlier, observed) {
        (Some(earlier), Some(observed)) => format!("orders {} and {}", decimals(*earlier, 1), decimals(*observed, 1)),
        (None, Some(observed)) => format!("order {}", decimals(*observed, 1)),
        _ => "no order".into(),
    };
    format!(
        "not resolved at h = {}: its runs differ by {by}, not by {}, so that they bound no error; smaller steps may tell, or a solution \
         that is smooth",
        significant(*h, 2),
        trimmed(*order, 3)
    )
}
