//! Statements decided by computation.

use serde::{Deserialize, Serialize, Serializer};

use super::Requirement;
use experiments::measure::order::Verdict;

/// Outcome of one check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, speedy::Readable, speedy::Writable)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The check ran and held.
    Pass,
    /// The check ran and did not hold.
    Fail,
    /// The data allow no decision; never counted as a pass.
    Inconclusive,
    /// The check ran and misses the resolution that it needs, as theory predicts of it; never counted as a pass.
    NotSettled,
    /// The check could not run here (a feature or library is missing).
    NotRun,
}

impl From<bool> for Outcome {
    fn from(holds: bool) -> Self {
        if holds { Self::Pass } else { Self::Fail }
    }
}

impl From<Verdict> for Outcome {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::Pass => Self::Pass,
            Verdict::Fail => Self::Fail,
            // What was claimed of nothing passes nothing.
            Verdict::Measured | Verdict::Inconclusive => Self::Inconclusive,
        }
    }
}

/// One statement decided by computation.
#[derive(Debug, Clone, Serialize, speedy::Readable, speedy::Writable)]
pub struct Check {
    /// Stable identifier, unique in the study: `order/method-i/logistic`.
    pub id: String,
    /// What is asserted, in one sentence.
    pub statement: String,
    /// What came out.
    pub outcome: Outcome,
    /// The number that was measured, where there is one.
    #[serde(serialize_with = "optional_number")]
    pub measured: Option<f64>,
    /// What was required of it; nothing where the check could not come as far.
    pub required: Option<Requirement>,
    /// Where the requirement comes from, or why the check failed, was inconclusive, not settled or did not run.
    pub reason: String,
}

impl Check {
    /// A number that must meet `required`; NaN never does.
    pub fn new(
        id: impl Into<String>,
        statement: impl Into<String>,
        measured: f64,
        required: Requirement,
        reason: impl Into<String>,
    ) -> Self {
        Self {
            id: id.into(),
            statement: statement.into(),
            outcome: required.is_met_by(measured).into(),
            measured: Some(measured),
            required: Some(required),
            reason: reason.into(),
        }
    }

    /// A number that must lie in the closed interval from `low` to `high`.
    pub fn within(
        id: impl Into<String>,
        statement: impl Into<String>,
        measured: f64,
        [low, high]: [f64; 2],
        reason: impl Into<String>,
    ) -> Self {
        Self::new(id, statement, measured, Requirement::Within(low, high), reason)
    }

    /// A number that must not exceed `bound`.
    pub fn at_most(
        id: impl Into<String>,
        statement: impl Into<String>,
        measured: f64,
        bound: f64,
        reason: impl Into<String>,
    ) -> Self {
        Self::new(id, statement, measured, Requirement::AtMost(bound), reason)
    }

    /// A number that `bound` must not exceed.
    pub fn at_least(
        id: impl Into<String>,
        statement: impl Into<String>,
        measured: f64,
        bound: f64,
        reason: impl Into<String>,
    ) -> Self {
        Self::new(id, statement, measured, Requirement::AtLeast(bound), reason)
    }

    /// A statement that could not be put to the test, and why.
    pub fn undecided(
        id: impl Into<String>,
        statement: impl Into<String>,
        outcome: Outcome,
        reason: impl Into<String>,
    ) -> Self {
        Self {
            id: id.into(),
            statement: statement.into(),
            outcome,
            measured: None,
            required: None,
            reason: reason.into(),
        }
    }

    /// What was required, in words; empty where nothing was.
    pub fn required_text(&self) -> String {
        self.required.map(|required| required.to_string()).unwrap_or_default()
    }
}

fn optional_number<S: Serializer>(value: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    match value {
        Some(value) => super::number::serialize(value, serializer),
        None => serializer.serialize_none(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_order_passes_a_check_only_where_it_was_claimed_and_found() {
        let of = [Verdict::Pass, Verdict::Fail, Verdict::Measured, Verdict::Inconclusive].map(Outcome::from);
        assert_eq!(of, [Outcome::Pass, Outcome::Fail, Outcome::Inconclusive, Outcome::Inconclusive]);
    }
}
