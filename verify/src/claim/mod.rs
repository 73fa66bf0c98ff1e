//! The claims of the two papers, each decided by computation.
//!
//! A claim is broken up into [`Case`]s, comparisons of a measured number with a bound. The verdict follows from them alone:
//! all hold, it is confirmed; some hold, it is qualified, and the finding says where; none holds, it is refuted. A question
//! that a paper leaves open is answered if the cases that establish the answer hold, and stays open otherwise.

pub(crate) mod ky21;
mod measure;
mod s24;

use std::collections::HashMap;
use std::sync::{LazyLock, OnceLock};

use rayon::prelude::*;

use crate::chapter::StudyError;
use crate::evidence::{Figure, Requirement, Table};
use crate::golden::Row;

/// A statement of a paper and how it is decided.
#[derive(Debug, Clone, Copy)]
pub struct Claim {
    /// Stable identifier: `S24-b-1`.
    pub id: &'static str,
    /// Where the paper says it.
    pub source: &'static str,
    /// The statement in one sentence.
    pub statement: &'static str,
    /// What is measured, and what it is compared with.
    pub criterion: &'static str,
    /// The computation.
    pub decide: fn() -> Result<Finding, StudyError>,
}

/// What became of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// It holds in every case.
    Confirmed,
    /// It holds in some cases, and the finding says in which.
    Qualified,
    /// It holds in no case.
    Refuted,
    /// A question that the paper leaves open has an answer.
    Answered,
    /// No answer yet.
    Open,
}

impl Verdict {
    /// The word in tables and goldens.
    pub fn word(self) -> &'static str {
        match self {
            Self::Confirmed => "confirmed",
            Self::Qualified => "qualified",
            Self::Refuted => "refuted",
            Self::Answered => "answered",
            Self::Open => "open",
        }
    }
}

/// One comparison of a measured number with what the claim says about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// What is measured.
    pub what: String,
    /// The number; infinite where there is no solution to measure, never `NaN`.
    pub measured: f64,
    /// What it is compared with.
    pub required: Requirement,
}

impl Case {
    /// `measured` < `bound`.
    pub fn below(what: impl Into<String>, measured: f64, bound: f64) -> Self {
        Self { what: what.into(), measured, required: Requirement::Below(bound) }
    }

    /// `measured` > `bound`.
    pub fn above(what: impl Into<String>, measured: f64, bound: f64) -> Self {
        Self { what: what.into(), measured, required: Requirement::Above(bound) }
    }

    /// `low` ≤ `measured` ≤ `high`.
    pub fn between(what: impl Into<String>, measured: f64, low: f64, high: f64) -> Self {
        Self { what: what.into(), measured, required: Requirement::Within(low, high) }
    }

    /// Whether the comparison comes out as claimed; never for `NaN`.
    pub fn holds(&self) -> bool {
        self.required.is_met_by(self.measured)
    }

    /// Neither the measured number nor the bound is `NaN`.
    fn is_sound(&self) -> bool {
        !self.measured.is_nan() && !self.required.bounds().any(f64::is_nan)
    }
}

/// What the computation of a claim found.
#[derive(Debug, Clone)]
pub struct Finding {
    verdict: Verdict,
    cases: Vec<Case>,
    /// The numbers that matter, in a sentence or two.
    pub evidence: String,
    /// Where a qualified claim holds, or what holds in place of a refuted one.
    pub where_it_holds: Option<String>,
    /// Why it comes out like this.
    pub mechanism: Option<String>,
    /// Data.
    pub tables: Vec<Table>,
    /// Pictures.
    pub figures: Vec<Figure>,
}

impl Finding {
    /// The verdict on a statement: confirmed if all cases hold, refuted if none does, qualified otherwise.
    pub fn on(cases: Vec<Case>, evidence: impl Into<String>) -> Self {
        let holding = cases.iter().filter(|case| case.holds()).count();
        let verdict = match holding {
            0 => Verdict::Refuted,
            n if n == cases.len() => Verdict::Confirmed,
            _ => Verdict::Qualified,
        };
        Self::new(verdict, cases, evidence)
    }

    /// The verdict on a question: answered if all of the cases that establish the answer hold.
    pub fn answer(cases: Vec<Case>, evidence: impl Into<String>) -> Self {
        let established = !cases.is_empty() && cases.iter().all(Case::holds);
        Self::new(if established { Verdict::Answered } else { Verdict::Open }, cases, evidence)
    }

    fn new(verdict: Verdict, cases: Vec<Case>, evidence: impl Into<String>) -> Self {
        Self {
            verdict,
            cases,
            evidence: evidence.into(),
            where_it_holds: None,
            mechanism: None,
            tables: Vec::new(),
            figures: Vec::new(),
        }
    }

    /// Says where the claim holds.
    #[must_use]
    pub fn holds_where(self, text: impl Into<String>) -> Self {
        Self { where_it_holds: Some(text.into()), ..self }
    }

    /// Says why.
    #[must_use]
    pub fn because(self, text: impl Into<String>) -> Self {
        Self { mechanism: Some(text.into()), ..self }
    }

    /// Adds a table.
    #[must_use]
    pub fn with_table(mut self, table: Table) -> Self {
        self.tables.push(table);
        self
    }

    /// Adds a figure and the table of its data.
    #[must_use]
    pub fn with_figure(mut self, figure: Figure, data: Table) -> Self {
        self.figures.push(figure);
        self.with_table(data)
    }

    /// The verdict.
    pub fn verdict(&self) -> Verdict {
        self.verdict
    }

    /// The comparisons that it follows from.
    pub fn cases(&self) -> &[Case] {
        &self.cases
    }

    /// How many comparisons hold: `9 of 10`.
    pub fn score(&self) -> String {
        format!("{} of {}", self.cases.iter().filter(|case| case.holds()).count(), self.cases.len())
    }

    /// How many comparisons lack a number, on either side; all of a finding without any, which rests on nothing.
    pub fn unsound(&self) -> usize {
        self.cases.iter().filter(|case| !case.is_sound()).count().max(usize::from(self.cases.is_empty()))
    }

    /// Every number is one, so that the verdict rests on comparisons that were made.
    pub fn is_sound(&self) -> bool {
        self.unsound() == 0
    }
}

/// All claims, paper by paper in the order of their identifiers.
pub fn all() -> Vec<&'static Claim> {
    let of = |groups: &'static [&'static [Claim]]| {
        let mut claims: Vec<_> = groups.iter().flat_map(|group| group.iter()).collect();
        claims.sort_by_key(|claim| claim.id);
        claims
    };
    [of(s24::ALL), of(ky21::ALL)].concat()
}

/// A claim with what came of it.
pub type Judged = (&'static Claim, &'static Result<Finding, String>);

/// What came of a claim, computed once in a process.
pub fn finding(claim: &'static Claim) -> &'static Result<Finding, String> {
    static FINDINGS: LazyLock<HashMap<&str, OnceLock<Result<Finding, String>>>> =
        LazyLock::new(|| all().into_iter().map(|claim| (claim.id, OnceLock::new())).collect());
    FINDINGS[claim.id].get_or_init(|| (claim.decide)().map_err(|error| error.to_string()))
}

/// Decides every claim; `tick` is called after each.
pub fn judge(tick: &(dyn Fn() + Sync)) -> Vec<Judged> {
    let judged = all().into_par_iter().map(|claim| {
        let finding = finding(claim);
        tick();
        (claim, finding)
    });
    judged.collect()
}

/// The verdicts as rows of a golden, with the number of comparisons that hold: within a qualified claim a change of what
/// is measured shows only there.
///
/// # Errors
/// The first claim that could not be decided.
pub fn verdicts() -> Result<Vec<Row>, StudyError> {
    let mut rows = Vec::new();
    for (claim, finding) in judge(&|| {}) {
        let finding = finding.as_ref().map_err(|error| format!("{}: {error}", claim.id))?;
        rows.push(Row::text(claim.id, finding.verdict().word()));
        rows.push(Row::text(format!("{} comparisons", claim.id), finding.score()));
    }
    Ok(rows)
}

/// The table `id` of a finding.
///
/// # Errors
/// If no claim that could be decided has such a table.
pub(crate) fn table(id: &str) -> Result<&'static Table, StudyError> {
    let findings = judge(&|| {}).into_iter().filter_map(|(_, finding)| finding.as_ref().ok());
    let table = findings.flat_map(|finding| &finding.tables).find(|table| table.id == id);
    table.ok_or_else(|| format!("no claim has a table {id}").into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_follow_from_cases() {
        let (yes, no) = (Case::below("x", 1.0, 2.0), Case::above("x", 1.0, 2.0));
        let on = |cases: &[&Case]| Finding::on(cases.iter().map(|case| (*case).clone()).collect(), "").verdict();
        assert_eq!(on(&[&yes, &yes]), Verdict::Confirmed);
        assert_eq!(on(&[&yes, &no]), Verdict::Qualified);
        assert_eq!(on(&[&no]), Verdict::Refuted);
        assert_eq!(on(&[]), Verdict::Refuted);
        let answer = |cases: Vec<Case>| Finding::answer(cases, "").verdict();
        assert_eq!(answer(vec![yes.clone()]), Verdict::Answered);
        assert_eq!(answer(vec![yes, no]), Verdict::Open);
        assert_eq!(answer(vec![]), Verdict::Open);
    }

    #[test]
    fn a_case_that_is_not_a_number_neither_holds_nor_is_sound() {
        for required in [Requirement::Below(1.0), Requirement::Above(1.0), Requirement::Within(0.0, 1.0)] {
            let case = Case { what: String::new(), measured: f64::NAN, required };
            assert!(!case.holds() && !case.is_sound());
        }
        assert!(!Case::below("", 1.0, f64::NAN).is_sound() && !Case::below("", 1.0, f64::NAN).holds());
        assert!(Case::above("", f64::INFINITY, 1.0).holds() && Case::above("", f64::INFINITY, 1.0).is_sound());
        assert!(Case::between("", 1.0, 1.0, 1.0).holds());
    }
}
