//! What changed since an earlier run, read from its `results.json`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::{fs, io};

use serde::Deserialize;
use serde_json::Value;

use super::json::SCHEMA;
use super::run::Chapter;
use super::verdict;
use crate::evidence::number::short;
use crate::evidence::{Cell, Check, Outcome, Requirement};

/// The part of a requirement's [scale](Requirement::scale) that a measured value may move without mention; of the value
/// itself where nothing is required. Roundoff moves a value within its bound from build to build, by less.
const NOTABLE: f64 = 0.1;

/// The table of the claims' verdicts, with the columns `id` and `verdict`.
const CLAIMS: &str = "claims";

/// Why an earlier run cannot be compared with.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ComparisonError {
    /// The file cannot be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file is not what `verify report` writes.
    #[error("{path} is no results.json of this program: {source}")]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong, with line and column.
        source: serde_json::Error,
    },
    /// The file has another version of the schema.
    #[error("{path} has schema {found}, this program compares with schema {SCHEMA}")]
    Schema {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: u32,
    },
}

/// An earlier run, as far as it is compared.
#[derive(Debug, Clone)]
pub struct Earlier {
    name: String,
    results: Results,
}

#[derive(Debug, Clone, Deserialize)]
struct Results {
    chapters: Vec<EarlierChapter>,
}

#[derive(Debug, Clone, Deserialize)]
struct EarlierChapter {
    id: String,
    error: Option<String>,
    checks: Vec<EarlierCheck>,
    tables: Vec<EarlierTable>,
}

#[derive(Debug, Clone, Deserialize)]
struct EarlierCheck {
    id: String,
    outcome: Outcome,
    /// A number, its name where it is not finite, or null.
    measured: Value,
    /// A requirement or null; a sentence in files of schema 1, which is not compared.
    required: Value,
}

#[derive(Debug, Clone, Deserialize)]
struct EarlierTable {
    id: String,
    columns: Vec<String>,
    rows: Option<Vec<Vec<Value>>>,
}

impl Earlier {
    /// Reads the `results.json` at `path`.
    ///
    /// # Errors
    /// [`ComparisonError`] if it cannot be read, is malformed, or has another schema.
    pub fn read(path: &Path) -> Result<Self, ComparisonError> {
        #[derive(Deserialize)]
        struct Version {
            schema: u32,
        }
        let text = fs::read_to_string(path).map_err(|source| ComparisonError::Read { path: path.into(), source })?;
        let malformed = |source| ComparisonError::Malformed { path: path.into(), source };
        // The version first: another schema need not have the same fields.
        let Version { schema } = serde_json::from_str(&text).map_err(malformed)?;
        // Schema 1 differs in what is required of a check only, which was a sentence.
        if ![1, SCHEMA].contains(&schema) {
            return Err(ComparisonError::Schema { path: path.into(), found: schema });
        }
        let results = serde_json::from_str(&text).map_err(malformed)?;
        Ok(Self { name: path.display().to_string(), results })
    }

    /// What differs in `chapters`.
    pub(super) fn against(&self, chapters: &[Chapter]) -> Comparison {
        let mut changes = Vec::new();
        let mut not_run = Vec::new();
        for old in &self.results.chapters {
            match chapters.iter().find(|new| new.id == old.id) {
                Some(new) => compare(old, new, &mut changes),
                None => not_run.push(old.id.clone()),
            }
        }
        let is_new = |new: &&Chapter| self.results.chapters.iter().all(|old| old.id != new.id);
        for new in chapters.iter().filter(is_new) {
            let checks = format!("a new chapter with {} checks", new.evidence.checks.len());
            changes.push(Change::new(&new.id, "", checks));
        }
        Comparison { earlier: self.name.clone(), changes, not_run }
    }
}

/// What changed between two runs.
#[derive(Debug, Clone)]
pub(super) struct Comparison {
    /// The file of the earlier run.
    pub(super) earlier: String,
    /// The changes in reading order.
    pub(super) changes: Vec<Change>,
    /// Chapters of the earlier run that this one does not have.
    pub(super) not_run: Vec<String>,
}

impl Comparison {
    /// The result in a line.
    pub(super) fn headline(&self) -> String {
        match self.changes.len() {
            0 => format!("nothing changed since {}", self.earlier),
            1 => format!("1 change since {}", self.earlier),
            n => format!("{n} changes since {}", self.earlier),
        }
    }
}

/// One difference.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Change {
    /// Chapter, and check or claim where it is about one.
    pub(super) place: String,
    /// What it was and is.
    pub(super) what: String,
}

impl Change {
    fn new(chapter: &str, id: &str, what: impl Into<String>) -> Self {
        let place = if id.is_empty() { chapter.into() } else { format!("{chapter}: {id}") };
        Self { place, what: what.into() }
    }
}

fn compare(old: &EarlierChapter, new: &Chapter, changes: &mut Vec<Change>) {
    let mut note = |id: &str, what: String| changes.push(Change::new(&new.id, id, what));
    match (&old.error, &new.error) {
        (None, Some(error)) => note("", format!("breaks off: {error}")),
        (Some(_), None) => note("", "no longer breaks off".into()),
        _ => {}
    }
    for (id, was, is) in pairs(verdicts_before(old), verdicts_now(new)) {
        match (was, is) {
            (Some(was), Some(is)) if was != is => note(&id, format!("verdict {was} → {is}")),
            (None, Some(is)) => note(&id, format!("new verdict: {is}")),
            (Some(was), None) => note(&id, format!("verdict gone, it was {was}")),
            _ => {}
        }
    }
    let before = old.checks.iter().map(|check| (check.id.clone(), check));
    let now = new.evidence.checks.iter().map(|check| (check.id.clone(), check));
    for (id, was, is) in pairs(before.collect(), now.collect()) {
        let word = |outcome| verdict::word(outcome).to_lowercase();
        match (was, is) {
            (Some(was), Some(is)) => {
                if was.outcome != is.outcome {
                    note(&id, format!("{} → {}", word(was.outcome), word(is.outcome)));
                } else if let Some(what) = moved(number(&was.measured), is) {
                    note(&id, what);
                }
                // What passes now may do so because less is required; of what did not come as far nothing is.
                let is_open = is.required.is_none() && was.outcome != is.outcome;
                let required: Option<Requirement> = serde_json::from_value(was.required.clone()).ok();
                if let Some(required) = required.filter(|required| Some(*required) != is.required && !is_open) {
                    let now = is.required.map_or_else(|| "nothing".into(), |required| required.to_string());
                    note(&id, format!("required {required} → {now}"));
                }
            }
            (None, Some(is)) => note(&id, format!("new: {}", word(is.outcome))),
            (Some(was), None) => note(&id, format!("gone, it was {}", word(was.outcome))),
            (None, None) => {}
        }
    }
}

/// Old and new values by key: the new ones in their order, then those that are gone.
fn pairs<A: Copy, B>(old: Vec<(String, A)>, new: Vec<(String, B)>) -> Vec<(String, Option<A>, Option<B>)> {
    let before: HashMap<String, A> = old.iter().cloned().collect();
    let mut all: Vec<_> =
        new.into_iter().map(|(id, b)| (before.get(&id).copied(), id, b)).map(|(a, id, b)| (id, a, Some(b))).collect();
    let gone: Vec<_> = old.into_iter().filter(|(id, _)| all.iter().all(|(known, ..)| known != id)).collect();
    all.extend(gone.into_iter().map(|(id, a)| (id, Some(a), None)));
    all
}

/// What a measured value did, if it moved by more than is [`NOTABLE`].
fn moved(was: Option<f64>, check: &Check) -> Option<String> {
    let show = |x: Option<f64>| x.map_or_else(|| "none".into(), short);
    let required = check.required.map_or_else(|| "nothing".into(), |required| required.to_string());
    let text = || Some(format!("measured {} → {}, required {required}", show(was), show(check.measured)));
    match (was, check.measured) {
        (None, None) => None,
        (Some(was), Some(is)) => {
            let scale = check.required.map_or(was.abs(), Requirement::scale);
            let is_same = was == is || was.is_nan() && is.is_nan() || (is - was).abs() <= NOTABLE * scale;
            if is_same { None } else { text() }
        }
        _ => text(),
    }
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::String(name) => name.parse().ok(),
        other => other.as_f64(),
    }
}

fn verdicts_before(chapter: &EarlierChapter) -> Vec<(String, &str)> {
    let Some(table) = chapter.tables.iter().find(|table| table.id == CLAIMS) else { return Vec::new() };
    let Some([id, verdict]) = columns(&table.columns) else { return Vec::new() };
    let rows = table.rows.iter().flatten();
    rows.filter_map(|row| Some((row.get(id)?.as_str()?.to_owned(), row.get(verdict)?.as_str()?))).collect()
}

fn verdicts_now(chapter: &Chapter) -> Vec<(String, &str)> {
    let Some(table) = chapter.evidence.tables.iter().find(|table| table.id == CLAIMS) else { return Vec::new() };
    let Some([id, verdict]) = columns(&table.columns) else { return Vec::new() };
    let rows = table.rows.iter();
    rows.filter_map(|row| match (row.get(id)?, row.get(verdict)?) {
        (Cell::Text(id), Cell::Text(verdict)) => Some((id.clone(), verdict.as_str())),
        _ => None,
    })
    .collect()
}

fn columns(names: &[String]) -> Option<[usize; 2]> {
    let find = |name| names.iter().position(|known| known == name);
    Some([find("id")?, find("verdict")?])
}
