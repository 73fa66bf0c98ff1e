//! Every number and every ordering that the finding of a claim states is computed again: from its comparisons, from the tables that
//! stand beside it, and from closed forms.

mod ky21;
mod s24;

use libtest_mimic::Failed;
use verify::claim::{Case, Claim, Finding, Quantifier, Verdict};
use verify::evidence::{Cell, number};
use verify::measure::norm::Extremes;

use super::answers::consists;

/// What a finding has to say.
#[derive(Default)]
struct Known {
    /// The parts of its sentences that state numbers or order methods.
    parts: Vec<String>,
    /// Of what the source prints a number, as it prints it, and the number as computed here.
    digits: Vec<(String, &'static str, f64)>,
}

impl Known {
    fn of<const N: usize>(parts: [String; N]) -> Self {
        Self { parts: parts.into(), digits: Vec::new() }
    }

    fn beside(mut self, what: impl Into<String>, printed: &'static str, here: f64) -> Self {
        self.digits.push((what.into(), printed, here));
        self
    }
}

/// That the evidence, where a claim holds, why, and the digits beside the source's say what was found, and no number besides.
pub(super) fn says_what_was_found(claim: &Claim, finding: &Finding) -> Result<(), Failed> {
    let found = Found(finding);
    let known = match claim.id.split_once('-') {
        Some(("S24", id)) => s24::known(id, &found)?,
        Some(("KY21", id)) => ky21::known(id, &found)?,
        _ => Known::default(),
    };
    let Finding { evidence, where_it_holds, mechanism, digits, .. } = finding;
    let sentences: Vec<_> =
        [Some(evidence), where_it_holds.as_ref(), mechanism.as_ref()].into_iter().flatten().cloned().collect();
    consists(&sentences.join("\n"), &known.parts)?;
    let is_same = |a: f64, b: f64| (a - b).abs() <= 1e-6 * b.abs().max(1e-9);
    let agrees = digits.len() == known.digits.len()
        && digits.iter().zip(&known.digits).all(|(said, (what, printed, here))| {
            said.what == *what && said.printed == *printed && is_same(said.here, *here)
        });
    require(agrees, || format!("{digits:?} where {:?} is known", known.digits))?;
    // A condition is not picked by its outcomes alone.
    let is_qualified = claim.quantifier.verdict(finding.cases()) == Verdict::Qualified;
    require(!is_qualified || (where_it_holds.is_some() && mechanism.is_some()), || {
        "a qualified claim without its condition, or without a reason for it".into()
    })?;
    are_distinct(finding)?;
    let rivals = finding.cases().iter().filter(|case| case.rival.is_some()).count();
    let expected = if matches!(claim.quantifier, Quantifier::Comparison | Quantifier::Eventual) {
        finding.cases().len()
    } else {
        0
    };
    require(rivals == expected, || format!("{rivals} comparisons name a rival, not {expected}"))
}

/// That no two comparisons of a method against others are of the same two numbers: one of them would be of another method or step than its name.
fn are_distinct(finding: &Finding) -> Result<(), Failed> {
    let numbers = |case: &Case| (case.measured, case.required.bounds().collect::<Vec<_>>());
    let cases: Vec<_> = finding.cases().iter().filter(|case| case.what.contains(", against ")).collect();
    for (i, case) in cases.iter().enumerate() {
        if let Some(same) = cases[..i].iter().find(|other| numbers(other) == numbers(case)) {
            return Err(format!("{same}, as well as {case}").into());
        }
    }
    Ok(())
}

fn require(holds: bool, what: impl FnOnce() -> String) -> Result<(), Failed> {
    if holds { Ok(()) } else { Err(what().into()) }
}

/// A number in a sentence.
fn text(x: f64) -> String {
    if x == f64::INFINITY {
        return "no solution".into();
    }
    number::digits(x, if (1.0..2.0).contains(&x.abs()) { 4 } else { 3 })
}

/// A number of which a sentence says "at most", and one of which it says "at least".
fn at_most(x: f64) -> String {
    text(number::rounded_up(x, if (1.0..2.0).contains(&x.abs()) { 4 } else { 3 }))
}

fn at_least(x: f64) -> String {
    text(number::rounded_down(x, if (1.0..2.0).contains(&x.abs()) { 4 } else { 3 }))
}

/// From the least of some numbers to the most.
fn range(least: f64, most: f64) -> String {
    if text(least) == text(most) { text(least) } else { format!("{} to {}", at_least(least), at_most(most)) }
}

/// The lower and the upper end of an interval of sizes, to four digits within it.
fn from(x: f64) -> String {
    number::short(number::rounded_up(x, 4))
}

fn to(x: f64) -> String {
    number::short(number::rounded_down(x, 4))
}

/// So many sizes between two, at equal ratios.
fn between([low, high]: [f64; 2], count: u32) -> impl Iterator<Item = f64> {
    (1..count).map(move |k| low * (high / low).powf(f64::from(k) / f64::from(count)))
}

fn texts(values: impl IntoIterator<Item = f64>) -> String {
    values.into_iter().map(text).collect::<Vec<_>>().join(", ")
}

/// A finding whose parts have names.
struct Found<'a>(&'a Finding);

impl<'a> Found<'a> {
    /// The comparisons with this in their names.
    fn of(&self, part: &str) -> Vec<&'a Case> {
        let found: Vec<_> = self.0.cases().iter().filter(|case| case.what.contains(part)).collect();
        assert!(!found.is_empty(), "no comparison is about “{part}”");
        found
    }

    /// The numbers measured in them.
    fn all(&self, part: &str) -> Vec<f64> {
        self.of(part).into_iter().map(|case| case.measured).collect()
    }

    fn largest(&self, part: &str) -> f64 {
        self.all(part).into_iter().largest()
    }

    fn smallest(&self, part: &str) -> f64 {
        self.all(part).into_iter().smallest()
    }

    /// The number measured in the comparison of this name, and its bound.
    fn pair(&self, what: &str) -> [f64; 2] {
        let case = self.0.cases().iter().find(|case| case.what == what);
        let case = case.unwrap_or_else(|| panic!("no comparison “{what}”"));
        [case.measured, case.required.bounds().last().expect("a bound")]
    }

    fn measured(&self, what: &str) -> f64 {
        self.pair(what)[0]
    }

    /// The number in a column of a table in the first row that has these cells, as they are printed.
    fn cell(&self, table: &str, having: &[&str], column: &str) -> f64 {
        let table = self.0.tables.iter().find(|known| known.id == table).expect("a table");
        let column = table.column(column).expect("a column");
        let has = |row: &[Cell], text: &str| row.iter().any(|cell| cell.to_string() == text);
        let row = table.rows.iter().find(|row| having.iter().all(|text| has(row, text)));
        row.and_then(|row| row[column].number()).unwrap_or_else(|| panic!("no {having:?} in {}", table.id))
    }
}
