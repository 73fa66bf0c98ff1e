//! Each claim against the theory: confirmed, refuted with the counterexample, or inconclusive.

use serde::Serialize;

use super::analysis::Analysis;
use super::claim::{Claim, Property};
use super::file::MethodFile;

use evidence::{Check, Outcome};

/// What a verdict is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// A claim of the file.
    Claim,
    /// The coefficients among themselves.
    Consistency,
    /// Theory and a run.
    Run,
}

/// A statement about the method, and what came of it.
#[derive(Debug, Clone, Serialize)]
pub struct Verdict {
    /// What it is on.
    pub kind: Kind,
    /// Its subject in a word or two: `order 4`.
    pub subject: String,
    /// The statement, decided.
    #[serde(flatten)]
    pub check: Check,
}

/// What theory says of a property: whether it holds, and the number or counterexample that shows it.
#[derive(Debug, Clone)]
pub struct Finding {
    /// Whether it holds.
    pub outcome: Outcome,
    /// The number.
    pub measured: Option<f64>,
    /// The counterexample, or why it holds.
    pub why: String,
}

impl Finding {
    pub(super) fn new(holds: bool, why: impl Into<String>) -> Self {
        Self { outcome: holds.into(), measured: None, why: why.into() }
    }

    /// What cannot be told.
    pub(super) fn open(why: impl Into<String>) -> Self {
        Self { outcome: Outcome::Inconclusive, measured: None, why: why.into() }
    }

    pub(super) fn measured(self, x: impl Into<f64>) -> Self {
        Self { measured: Some(x.into()), ..self }
    }
}

/// The verdict on `claim`.
pub(super) fn judge(claim: &Claim, theory: &dyn Analysis) -> Verdict {
    // What is denied of a number is not claimed of those that are rounded to it.
    let property = if claim.denied { claim.property.exact() } else { claim.property };
    let finding = theory.find(property).unwrap_or_else(|| Finding {
        outcome: Outcome::Inconclusive,
        measured: None,
        why: format!("this is not looked at in the kind {}", theory.kind()),
    });
    let outcome = match (finding.outcome, claim.denied) {
        (Outcome::Pass, true) => Outcome::Fail,
        (Outcome::Fail, true) => Outcome::Pass,
        (outcome, _) => outcome,
    };
    let text = claim.to_string();
    let check = Check {
        id: format!("claim/{}", text.replace(' ', "-")),
        statement: format!("It is {text}, as claimed"),
        outcome,
        measured: finding.measured,
        required: None,
        reason: finding.why,
    };
    Verdict { kind: Kind::Claim, subject: text, check }
}

/// Leaves what no method can have that denies itself zero-stability: it does not converge, and says so.
pub(super) fn is_conceded(file: &MethodFile, verdict: &Verdict) -> bool {
    let denial = Claim { property: Property::ZeroStable, denied: true };
    verdict.subject == "convergence" && file.claims.contains(&denial)
}

/// Consistency, which every method claims: order 1 at least, of b and of b̂ where there is one. Nothing where an order is claimed,
/// which says more.
pub(super) fn consistency(file: &MethodFile, theory: &dyn Analysis) -> Vec<Verdict> {
    let embedded = theory.as_runge_kutta().and_then(|theory| theory.embedded.as_ref()).map(|embedded| embedded.order);
    let is_claimed = file.claims.iter().any(|claim| claim.as_embedded_order().is_some());
    let main = file.order().is_none().then(|| ("consistency", "The method", theory.order()));
    let embedded = embedded.filter(|_| !is_claimed).map(|order| ("embedded consistency", "The embedded method", order));
    let verdict = |(subject, what, order): (&str, &str, u32)| {
        let reason = match order {
            0 => "the conditions of order 1 fail: its runs do not converge to the solution",
            _ => "the conditions of order 1 hold",
        };
        let check = Check {
            id: subject.replace(' ', "-"),
            statement: format!("{what} is consistent, as any method is meant to be"),
            outcome: (order >= 1).into(),
            measured: Some(f64::from(order)),
            required: None,
            reason: reason.into(),
        };
        Verdict { kind: Kind::Consistency, subject: subject.into(), check }
    };
    main.into_iter().chain(embedded).map(verdict).collect()
}
