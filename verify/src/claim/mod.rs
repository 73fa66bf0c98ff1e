//! The claims of the two papers, each decided by computation.
//!
//! A claim is broken up into [`Case`]s, comparisons of a measured number with a bound. The verdict follows from them and from
//! the [`Quantifier`] of the statement alone.

pub(crate) mod ky21;
mod measure;
mod s24;

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt;
use std::sync::Arc;

use measure::text;

use crate::evidence::{Figure, Requirement, Table};
use crate::experiment::{Context, Experiment, ExperimentError, StudyError, side_by_side};

/// A statement of a paper and how it is decided.
#[derive(Debug, Clone, Copy)]
pub struct Claim {
    /// Stable identifier: `S24-b-1`.
    pub id: &'static str,
    /// Where the paper says it.
    pub source: &'static str,
    /// The statement in one sentence.
    pub statement: &'static str,
    /// Of what it is said.
    pub quantifier: Quantifier,
    /// What is measured, and what it is compared with.
    pub criterion: &'static str,
    /// The computation.
    pub decide: fn(&Context) -> Result<Finding, StudyError>,
}

/// Of what the statement is said, which decides how comparisons make a verdict. Claims that break up one clause of the source
/// share it; a sentence may have several, each said of something else.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantifier {
    /// Of every case: "unconditionally", "by construction", "for all h". It falls with one counterexample.
    Universal,
    /// Of every case too, in words that are read wider here than the source may mean them: what a counterexample refutes is that reading.
    Wider,
    /// Of cases that the source does not delimit, such as "for small h" or "generally", or of nothing in particular. It may hold
    /// under a condition that the source does not state.
    General,
    /// Of every case from some size on, as "for sufficiently large h", against other methods; the cases of each of these begin with the largest
    /// size. Where that one does not hold, there is no such size; where it is another one than the source says, that is a condition.
    Eventual,
    /// Of one method against others. It may hold under a condition too. It falls with one of the others that the method is never
    /// ahead of; a score that is mixed against each supports nothing.
    Comparison,
    /// A question that the source leaves open: the comparisons establish the answer.
    Open,
}

/// What became of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// Every comparison comes out as claimed.
    Confirmed,
    /// It holds under a condition that the source does not state: in all cases under it, and not in all others.
    Qualified,
    /// A universal statement with a counterexample, or any statement that holds nowhere.
    Refuted,
    /// The same, of a sentence that is read wider than the source may mean it.
    RefutedReading,
    /// The measurements do not establish it.
    NotSupported,
    /// A question that the paper leaves open has an answer.
    Answered,
    /// No answer yet.
    Open,
}

impl Verdict {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Confirmed,
        Self::Qualified,
        Self::Refuted,
        Self::RefutedReading,
        Self::NotSupported,
        Self::Answered,
        Self::Open,
    ];

    /// The words in tables and goldens.
    pub fn word(self) -> &'static str {
        match self {
            Self::Confirmed => "confirmed",
            Self::Qualified => "qualified",
            Self::Refuted => "refuted as stated",
            Self::RefutedReading => "refuted in the wider reading",
            Self::NotSupported => "not supported",
            Self::Answered => "answered",
            Self::Open => "open",
        }
    }

    /// Whether a counterexample decides it.
    pub fn is_refuted(self) -> bool {
        matches!(self, Self::Refuted | Self::RefutedReading)
    }
}

impl Quantifier {
    /// The verdict that follows from comparisons. One that is not a number neither holds nor refutes; one without a solution is infinite, and does.
    pub fn verdict(self, cases: &[Case]) -> Verdict {
        let fails = |case: &Case| case.is_sound() && !case.holds();
        let all_hold = !cases.is_empty() && cases.iter().all(Case::holds);
        let mut under = cases.iter().filter(|case| case.is_under_the_condition).peekable();
        let holds_under_a_condition = under.peek().is_some() && under.all(Case::holds);
        match self {
            Self::Open if all_hold => Verdict::Answered,
            Self::Open => Verdict::Open,
            _ if all_hold => Verdict::Confirmed,
            Self::Universal if cases.iter().any(fails) => Verdict::Refuted,
            Self::Wider if cases.iter().any(fails) => Verdict::RefutedReading,
            Self::Eventual if rivals(cases).any(|against| against.first().is_some_and(|case| fails(case))) => {
                Verdict::Refuted
            }
            Self::General | Self::Comparison | Self::Eventual if holds_under_a_condition => Verdict::Qualified,
            Self::General | Self::Comparison if !cases.is_empty() && cases.iter().all(fails) => Verdict::Refuted,
            Self::Comparison if rivals(cases).any(|against| against.into_iter().all(fails)) => Verdict::Refuted,
            _ => Verdict::NotSupported,
        }
    }
}

/// One comparison of a measured number with what the claim says about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// What is measured.
    pub what: String,
    /// The number: infinite where there is no solution, which is an outcome, and `NaN` where a run broke off for another reason, which is none.
    pub measured: f64,
    /// What there is in place of a number.
    pub without: Cow<'static, str>,
    /// What it is compared with.
    pub required: Requirement,
    /// Whether it is a case of the condition under which the finding says that the statement holds.
    pub is_under_the_condition: bool,
    /// The method that it compares with, where the statement is of one method against others.
    pub rival: Option<&'static str>,
}

/// The cases of each method that is compared with.
fn rivals(cases: &[Case]) -> impl Iterator<Item = Vec<&Case>> {
    let names: BTreeSet<_> = cases.iter().filter_map(|case| case.rival).collect();
    names.into_iter().map(|name| cases.iter().filter(|case| case.rival == Some(name)).collect())
}

impl Case {
    fn new(what: impl Into<String>, measured: f64, required: Requirement) -> Self {
        let without = measure::NO_SOLUTION.into();
        Self { what: what.into(), measured, without, required, is_under_the_condition: false, rival: None }
    }

    /// Says whether it is a case of the condition under which the finding says that the statement holds.
    #[must_use]
    pub fn under(self, is_under_the_condition: bool) -> Self {
        Self { is_under_the_condition, ..self }
    }

    /// Says what there is where there is no number.
    #[must_use]
    pub fn or_else(self, without: impl Into<Cow<'static, str>>) -> Self {
        Self { without: without.into(), ..self }
    }

    /// Names the method that it compares with.
    #[must_use]
    pub fn against(self, rival: &'static str) -> Self {
        Self { rival: Some(rival), ..self }
    }

    /// `measured` < `bound`.
    pub fn below(what: impl Into<String>, measured: f64, bound: f64) -> Self {
        Self::new(what, measured, Requirement::Below(bound))
    }

    /// `measured` ≤ `bound`.
    pub fn at_most(what: impl Into<String>, measured: f64, bound: f64) -> Self {
        Self::new(what, measured, Requirement::AtMost(bound))
    }

    /// `measured` > `bound`.
    pub fn above(what: impl Into<String>, measured: f64, bound: f64) -> Self {
        Self::new(what, measured, Requirement::Above(bound))
    }

    /// `low` ≤ `measured` ≤ `high`.
    pub fn between(what: impl Into<String>, measured: f64, low: f64, high: f64) -> Self {
        Self::new(what, measured, Requirement::Within(low, high))
    }

    /// Whether the comparison comes out as claimed; never for `NaN`, nor where there is no solution, which counts against what is claimed of it.
    pub fn holds(&self) -> bool {
        self.measured < f64::INFINITY && self.required.is_met_by(self.measured)
    }

    /// Neither the measured number nor the bound is `NaN`.
    pub fn is_sound(&self) -> bool {
        !self.measured.is_nan() && !self.required.bounds().any(f64::is_nan)
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let measured = if self.measured == f64::INFINITY { self.without.clone() } else { text(self.measured).into() };
        write!(f, "{}: {measured}, where {} is claimed", self.what, self.required)
    }
}

/// A number of the source beside ours.
#[derive(Debug, Clone)]
pub struct Digits {
    /// Of what.
    pub what: String,
    /// As the source prints it.
    pub printed: String,
    /// As it comes out here.
    pub here: f64,
}

/// What the computation of a claim found.
#[derive(Debug, Clone)]
pub struct Finding {
    cases: Vec<Case>,
    /// The numbers that matter, in a sentence or two.
    pub evidence: String,
    /// Where a qualified claim holds, or what holds in place of a refuted one.
    pub where_it_holds: Option<String>,
    /// Why it comes out like this.
    pub mechanism: Option<String>,
    /// The numbers that the source prints, beside ours.
    pub digits: Vec<Digits>,
    /// Data.
    pub tables: Vec<Table>,
    /// Pictures.
    pub figures: Vec<Figure>,
}

impl Finding {
    /// Comparisons, and the numbers that matter in a sentence or two.
    pub fn on(cases: Vec<Case>, evidence: impl Into<String>) -> Self {
        Self {
            cases,
            evidence: evidence.into(),
            where_it_holds: None,
            mechanism: None,
            digits: Vec::new(),
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

    /// Puts a number beside what the source prints.
    #[must_use]
    pub fn beside(mut self, what: impl Into<String>, printed: impl fmt::Display, here: f64) -> Self {
        self.digits.push(Digits { what: what.into(), printed: printed.to_string(), here });
        self
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

    /// The comparisons that the verdict follows from.
    pub fn cases(&self) -> &[Case] {
        &self.cases
    }

    /// A comparison that does not come out as claimed: the largest number against a method that is never beaten, where there is
    /// one, and else the first. One that has a number goes before one without a solution.
    pub fn counterexample(&self) -> Option<&Case> {
        let fails = |case: &&Case| case.is_sound() && !case.holds();
        let has_number = |case: &&Case| case.measured.is_finite();
        let unbeaten = rivals(&self.cases).filter(|against| against.iter().all(fails)).flatten();
        // A tie refutes too, but says less.
        let worst = unbeaten.filter(has_number).max_by(|a, b| a.measured.total_cmp(&b.measured));
        let failing = || self.cases.iter().filter(fails);
        worst.or_else(|| failing().find(has_number)).or_else(|| failing().next())
    }

    /// The methods that a comparison is never ahead of, each with the number of its cases.
    pub fn unbeaten(&self) -> Vec<(&'static str, usize)> {
        let of = |cases: Vec<&Case>| {
            let never = cases.iter().all(|case| case.is_sound() && !case.holds());
            Some((cases.first()?.rival?, cases.len())).filter(|_| never)
        };
        rivals(&self.cases).filter_map(of).collect()
    }

    /// How many comparisons hold: `9 of 10`.
    pub fn score(&self) -> String {
        format!("{} of {}", self.cases.iter().filter(|case| case.holds()).count(), self.cases.len())
    }

    /// How many comparisons lack a number, on either side; all of a finding without any, which rests on nothing.
    pub fn unsound(&self) -> usize {
        self.cases.iter().filter(|case| !case.is_sound()).count().max(usize::from(self.cases.is_empty()))
    }

    /// How many comparisons are decided by a step or a run that has no solution.
    pub fn without_solution(&self) -> usize {
        self.cases.iter().filter(|case| case.measured.is_infinite()).count()
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
#[derive(Debug)]
pub struct Judged {
    /// The claim.
    pub claim: &'static Claim,
    /// What the computation found, or why it broke off.
    pub finding: Result<Arc<Finding>, ExperimentError>,
}

impl Judged {
    /// The verdict; none where the computation broke off.
    pub fn verdict(&self) -> Option<Verdict> {
        self.finding.as_ref().ok().map(|finding| self.claim.quantifier.verdict(&finding.cases))
    }
}

/// A claim by its identifier, decided once for all who tell of it.
#[derive(Debug)]
struct Decided(&'static str);

impl Experiment for Decided {
    const ID: &'static str = "claim";
    type Found = Finding;

    fn measure(&self, context: &Context) -> Result<Finding, StudyError> {
        let claim = all().into_iter().find(|claim| claim.id == self.0).ok_or("there is no such claim")?;
        context.announce(1);
        let finding = (claim.decide)(context);
        context.tick();
        finding
    }
}

/// Decides a claim.
pub fn decide(context: &Context, claim: &'static Claim) -> Judged {
    Judged { claim, finding: context.get(Decided(claim.id)) }
}

/// Decides every claim.
pub fn judge(context: &Context) -> Vec<Judged> {
    side_by_side(all(), |claim| decide(context, claim))
}

/// The table `id` of a finding.
///
/// # Errors
/// If no claim that could be decided has such a table.
pub(crate) fn table(context: &Context, id: &str) -> Result<Table, StudyError> {
    let judged = judge(context);
    let findings = judged.iter().filter_map(|judged| judged.finding.as_ref().ok());
    let table = findings.flat_map(|finding| &finding.tables).find(|table| table.id == id);
    table.cloned().ok_or_else(|| format!("no claim has a table {id}").into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_follow_from_cases_by_the_quantifier() {
        use Quantifier::{Comparison, General, Open, Universal};
        use Verdict::{Answered, Confirmed, NotSupported, Qualified, Refuted};
        let (yes, no) = (Case::below("x", 1.0, 2.0), Case::above("x", 1.0, 2.0));
        let unresolved = Case::below("x", f64::NAN, 2.0);
        let (under, not_under) = (yes.clone().under(true), no.clone().under(true));
        for (cases, universal, general, open) in [
            (vec![&yes, &yes], Confirmed, Confirmed, Answered),
            (vec![&yes, &no], Refuted, NotSupported, Verdict::Open),
            (vec![&no, &no], Refuted, Refuted, Verdict::Open),
            (vec![&under, &no], Refuted, Qualified, Verdict::Open),
            (vec![&under, &yes, &no], Refuted, Qualified, Verdict::Open),
            (vec![&under, &not_under], Refuted, NotSupported, Verdict::Open),
            // What is not resolved neither holds nor refutes.
            (vec![&yes, &unresolved], NotSupported, NotSupported, Verdict::Open),
            (vec![&no, &unresolved], Refuted, NotSupported, Verdict::Open),
            (vec![&unresolved], NotSupported, NotSupported, Verdict::Open),
            (vec![], NotSupported, NotSupported, Verdict::Open),
        ] {
            let cases: Vec<Case> = cases.into_iter().cloned().collect();
            assert_eq!(Universal.verdict(&cases), universal, "{cases:?}");
            let wider = if universal == Refuted { Verdict::RefutedReading } else { universal };
            assert_eq!(Quantifier::Wider.verdict(&cases), wider, "{cases:?}");
            assert_eq!(General.verdict(&cases), general, "{cases:?}");
            assert_eq!(Comparison.verdict(&cases), general, "{cases:?}");
            assert_eq!(Open.verdict(&cases), open, "{cases:?}");
        }
    }

    #[test]
    fn claims_of_one_clause_share_its_quantifier() {
        let of = |id| all().into_iter().find(|claim| claim.id == id).map(|claim| claim.quantifier).expect(id);
        for clause in [
            &["S24-h-1", "S24-h-2"][..],
            &["S24-d-1", "S24-d-2"],
            &["S24-e-1", "S24-e-2"],
            &["S24-g-1", "S24-g-2"],
            &["S24-n-1", "S24-n-2"],
            &["KY21-b-1", "KY21-b-2"],
            &["KY21-b-3", "KY21-b-4"],
            // What path fitting inherits.
            &["KY21-e-1", "KY21-e-2", "KY21-f-2"],
        ] {
            assert!(clause.windows(2).all(|pair| of(pair[0]) == of(pair[1])), "{clause:?}");
        }
    }

    #[test]
    fn what_is_said_from_a_size_on_falls_with_the_largest() {
        let (yes, no) = (Case::below("x", 1.0, 2.0), Case::above("x", 1.0, 2.0));
        let judge = |cases: [(Case, &'static str); 4]| {
            Quantifier::Eventual.verdict(&cases.map(|(case, rival)| case.against(rival)))
        };
        let (yes, no, under) = (|| yes.clone(), || no.clone(), || yes.clone().under(true));
        assert_eq!(judge([(yes(), "a"), (yes(), "b"), (yes(), "a"), (yes(), "b")]), Verdict::Confirmed);
        assert_eq!(judge([(under(), "a"), (under(), "b"), (no(), "a"), (yes(), "b")]), Verdict::Qualified);
        assert_eq!(judge([(yes(), "a"), (no(), "b"), (under(), "a"), (under(), "b")]), Verdict::Refuted);
        assert_eq!(judge([(yes(), "a"), (yes(), "b"), (no(), "a"), (yes(), "b")]), Verdict::NotSupported);
        let unresolved = Case::below("x", f64::NAN, 2.0);
        assert_eq!(judge([(unresolved, "a"), (yes(), "b"), (yes(), "a"), (yes(), "b")]), Verdict::NotSupported);
    }

    #[test]
    fn a_comparison_falls_with_one_method_that_is_never_beaten() {
        let (yes, no) = (Case::below("x", 1.0, 2.0), Case::above("x", 1.0, 2.0));
        let judge = |cases: [(&Case, &'static str); 4]| {
            Quantifier::Comparison.verdict(&cases.map(|(case, rival)| case.clone().against(rival)))
        };
        assert_eq!(judge([(&yes, "a"), (&no, "a"), (&yes, "b"), (&no, "b")]), Verdict::NotSupported);
        assert_eq!(judge([(&yes, "a"), (&yes, "a"), (&no, "b"), (&no, "b")]), Verdict::Refuted);
        assert_eq!(judge([(&yes, "a"), (&yes, "a"), (&yes, "b"), (&yes, "b")]), Verdict::Confirmed);
        // What is not resolved is not known to be behind.
        let unresolved = Case::below("x", f64::NAN, 2.0);
        assert_eq!(judge([(&yes, "a"), (&yes, "a"), (&no, "b"), (&unresolved, "b")]), Verdict::NotSupported);
    }

    #[test]
    fn the_counterexample_is_the_worst_of_a_method_that_is_never_beaten_and_else_the_first_with_a_number() {
        let case = |measured: f64, rival| Case::below("x", measured, 1.0).against(rival);
        let of = |cases: &[Case]| Finding::on(cases.to_vec(), "").counterexample().map(|case| case.measured);
        // A tie with `b` is none of its defeats.
        let never = [case(7.0, "a"), case(0.5, "a"), case(1.0, "b"), case(3.0, "b"), case(2.0, "b")];
        assert_eq!(of(&never), Some(3.0));
        // Of several that are never beaten, and not where there is no solution if some other case has one.
        let none = f64::INFINITY;
        assert_eq!(of(&[case(none, "a"), case(3.0, "a"), case(none, "b"), case(4.0, "b"), case(2.0, "b")]), Some(4.0));
        assert_eq!(of(&[case(none, "a"), case(0.5, "a"), case(2.0, "a"), case(3.0, "a")]), Some(2.0));
        assert_eq!(of(&[case(none, "a"), case(0.5, "a")]), Some(none));
        assert_eq!(of(&[case(0.5, "a"), case(f64::NAN, "a"), case(2.0, "a"), case(3.0, "a")]), Some(2.0));
        assert_eq!(of(&[case(0.5, "a"), case(f64::NAN, "b")]), None);
    }

    #[test]
    fn the_methods_that_are_never_beaten_are_those_without_a_case_that_holds_or_is_open() {
        let case = |measured: f64, rival| Case::below("x", measured, 1.0).against(rival);
        let of = |cases: &[Case]| Finding::on(cases.to_vec(), "").unbeaten();
        let never =
            [case(7.0, "a"), case(0.5, "a"), case(1.0, "b"), case(3.0, "b"), case(f64::NAN, "c"), case(2.0, "c")];
        assert_eq!(of(&never), [("b", 2)]);
        assert!(of(&[Case::below("x", 7.0, 1.0)]).is_empty());
    }

    #[test]
    fn a_case_without_a_number_says_what_there_is_in_its_place() {
        let case = |measured| Case::at_most("x", measured, 1.0);
        assert_eq!(case(f64::INFINITY).to_string(), "x: no solution, where ≤ 1 is claimed");
        let other = |measured| case(measured).or_else("not determined").to_string();
        assert_eq!(other(f64::INFINITY), "x: not determined, where ≤ 1 is claimed");
        assert_eq!(other(2.0), "x: 2, where ≤ 1 is claimed");
    }

    /// A step without a solution refutes, a run that broke off for another reason does not; the two are counted apart.
    #[test]
    fn no_solution_is_an_outcome_and_a_run_that_broke_off_is_none() {
        let of = |measured: f64| {
            let finding = Finding::on(vec![Case::at_most("x", measured, 1.0)], "");
            (Quantifier::Universal.verdict(finding.cases()), finding.without_solution(), finding.unsound())
        };
        assert_eq!(of(f64::INFINITY), (Verdict::Refuted, 1, 0));
        assert_eq!(of(f64::NAN), (Verdict::NotSupported, 0, 1));
        assert_eq!(of(0.5), (Verdict::Confirmed, 0, 0));
    }

    #[test]
    fn a_case_that_is_not_a_number_neither_holds_nor_is_sound() {
        for required in [Requirement::Below(1.0), Requirement::Above(1.0), Requirement::Within(0.0, 1.0)] {
            let case = Case::new("", f64::NAN, required);
            assert!(!case.holds() && !case.is_sound());
        }
        assert!(!Case::below("", 1.0, f64::NAN).is_sound() && !Case::below("", 1.0, f64::NAN).holds());
        // No solution is no large number.
        assert!(!Case::above("", f64::INFINITY, 1.0).holds() && Case::above("", f64::INFINITY, 1.0).is_sound());
        assert!(Case::between("", 1.0, 1.0, 1.0).holds());
    }
}
