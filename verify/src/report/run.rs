//! A whole run: the chapters in reading order and where they come from.

use std::collections::HashSet;

use super::bibliography;
use super::comparison::{Comparison, Earlier};
use crate::evidence::{Cell, Check, Evidence, Outcome, Panel, is_plain};

/// What one study contributed.
#[derive(Debug, Clone, Default, speedy::Readable, speedy::Writable)]
pub struct Chapter {
    /// Stable identifier and anchor: `linear-drag`.
    pub id: String,
    /// Heading.
    pub title: String,
    /// The question that the chapter answers.
    pub question: String,
    /// Where the question comes from: `[S24] §3`.
    pub source: String,
    /// What was found; whatever there was up to an error.
    pub evidence: Evidence,
    /// Why the study broke off, where it did.
    pub error: Option<String>,
    /// Seconds from its beginning to its end, side by side with other studies.
    pub seconds: f64,
}

impl Chapter {
    /// The check of this identifier.
    pub(super) fn check(&self, id: &str) -> Option<&Check> {
        self.evidence.checks.iter().find(|check| check.id == id)
    }
}

/// Everything that the report shows.
#[derive(Debug, Clone)]
pub struct Run {
    pub(super) chapters: Vec<Chapter>,
    pub(super) provenance: Vec<(String, String)>,
    pub(super) comparison: Option<Comparison>,
    pub(super) palette: Vec<String>,
}

impl Run {
    /// Puts the chapters together and adds a last one, `report`, that audits them: identifiers serve as anchors and file
    /// names, so they must be unique and plain; tables must be rectangular; a figure must name the table of its data; and a
    /// result that is not a number must be left empty and explained. A repeated identifier is made unique, so that
    /// nothing is lost.
    ///
    /// `provenance` lists versions, parameters and seeds in the order shown.
    pub fn new(mut chapters: Vec<Chapter>, provenance: Vec<(String, String)>) -> Self {
        let repeated = make_unique(&mut chapters);
        let checks = vec![
            decide("unique-ids", "No two chapters, sections, tables, figures or checks share an identifier", repeated),
            decide(
                "plain-ids",
                "Identifiers of chapters, sections and tables serve as file names and anchors",
                odd_ids(&chapters),
            ),
            decide(
                "rectangular",
                "Every row of a table is as long as its header, every map as large as its grid",
                ragged_rows(&chapters),
            ),
            decide(
                "numbers",
                "No number in a table is `NaN`; a result that does not exist is left empty",
                not_numbers(&chapters),
            ),
            decide("requirements", "Some number fails each requirement, and some number meets it", vacuous(&chapters)),
            decide(
                "spacing",
                "No text has two blanks in a row, such as a broken line leaves behind",
                runs_of_blanks(&chapters),
            ),
            decide("data", "Every figure names the table that holds its data", figures_without_data(&chapters)),
            decide(
                "citations",
                "Every source that is cited by a key stands in the bibliography",
                unexplained(&chapters),
            ),
            decide("maps", "Every cell of a map of checks leads to a check", cells_without_checks(&chapters)),
            decide("parts", "Every section names tables and figures of its chapter", sections_without_parts(&chapters)),
        ];
        chapters.push(Chapter {
            id: AUDIT.into(),
            title: "The report itself".into(),
            question: "Is this report complete and sound in itself?".into(),
            evidence: Evidence { checks, ..Evidence::default() },
            ..Chapter::default()
        });
        Self { chapters, provenance, comparison: None, palette: Vec::new() }
    }

    /// Adds what changed since an earlier run.
    #[must_use]
    pub fn compared_with(self, earlier: &Earlier) -> Self {
        Self { comparison: Some(earlier.against(&self.chapters)), ..self }
    }

    /// Gives each of these names, of methods and references, one colour and shape in the whole report.
    #[must_use]
    pub fn with_palette(self, palette: Vec<String>) -> Self {
        Self { palette, ..self }
    }

    /// The chapters in reading order, the audit last.
    pub fn chapters(&self) -> &[Chapter] {
        &self.chapters
    }

    /// Checks by outcome over all chapters.
    pub fn counts(&self) -> Counts {
        self.chapters.iter().fold(Counts::default(), |sum, chapter| sum.plus(Counts::of(chapter)))
    }

    /// The checks with this outcome in reading order.
    pub fn checks_that(&self, outcome: Outcome) -> impl Iterator<Item = (&Chapter, &Check)> {
        let checks = |chapter| move |check| (chapter, check);
        self.chapters
            .iter()
            .flat_map(move |chapter| chapter.evidence.checks.iter().map(checks(chapter)))
            .filter(move |(_, check): &(&Chapter, &Check)| check.outcome == outcome)
    }
}

/// Number of checks by outcome.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counts {
    /// Checks that held.
    pub pass: usize,
    /// Checks that did not hold.
    pub fail: usize,
    /// Checks that the data could not decide.
    pub inconclusive: usize,
    /// Checks that were tried and miss the resolution that they need.
    pub not_settled: usize,
    /// Checks that could not run here.
    pub not_run: usize,
    /// Chapters whose study broke off with an error.
    pub broken: usize,
}

impl Counts {
    /// The checks of one chapter.
    pub fn of(chapter: &Chapter) -> Self {
        let count = |outcome| chapter.evidence.checks.iter().filter(|check| check.outcome == outcome).count();
        Self {
            pass: count(Outcome::Pass),
            fail: count(Outcome::Fail),
            inconclusive: count(Outcome::Inconclusive),
            not_settled: count(Outcome::NotSettled),
            not_run: count(Outcome::NotRun),
            broken: usize::from(chapter.error.is_some()),
        }
    }

    /// No check failed and no study broke off.
    pub fn is_ok(self) -> bool {
        self.fail == 0 && self.broken == 0
    }

    /// All checks, whatever came of them.
    pub fn checks(self) -> usize {
        self.pass + self.fail + self.inconclusive + self.not_settled + self.not_run
    }

    fn plus(self, other: Self) -> Self {
        Self {
            pass: self.pass + other.pass,
            fail: self.fail + other.fail,
            inconclusive: self.inconclusive + other.inconclusive,
            not_settled: self.not_settled + other.not_settled,
            not_run: self.not_run + other.not_run,
            broken: self.broken + other.broken,
        }
    }
}

const AUDIT: &str = "report";

fn decide(id: &str, statement: &str, defects: Vec<String>) -> Check {
    Check::at_most(id, statement, defects.len() as f64, 0.0, defects.join("; "))
}

/// Appends `-2`, `-3`, … to identifiers seen before, and lists them.
fn make_unique(chapters: &mut [Chapter]) -> Vec<String> {
    let mut repeated = Vec::new();
    let mut claim = |seen: &mut HashSet<String>, id: &mut String| {
        if seen.insert(id.clone()) {
            return;
        }
        repeated.push(format!("`{id}`"));
        let fresh = (2..).map(|n| format!("{id}-{n}")).find(|name| !seen.contains(name));
        *id = fresh.unwrap_or_default();
        seen.insert(id.clone());
    };
    // The audit's own chapter comes later and must find its name free.
    let mut chapter_ids = HashSet::from([AUDIT.to_owned()]);
    let (mut table_ids, mut figure_ids) = (HashSet::new(), HashSet::new());
    for chapter in chapters {
        claim(&mut chapter_ids, &mut chapter.id);
        let mut check_ids = HashSet::new();
        chapter.evidence.checks.iter_mut().for_each(|check| claim(&mut check_ids, &mut check.id));
        chapter.evidence.tables.iter_mut().for_each(|table| claim(&mut table_ids, &mut table.id));
        chapter.evidence.figures.iter_mut().for_each(|figure| claim(&mut figure_ids, &mut figure.id));
        chapter.evidence.sections.iter_mut().for_each(|section| claim(&mut chapter_ids, &mut section.id));
    }
    repeated
}

fn odd_ids(chapters: &[Chapter]) -> Vec<String> {
    let serves = |id: &str| id.starts_with(|c: char| c.is_ascii_alphanumeric()) && id.chars().all(is_plain);
    let tables = chapters.iter().flat_map(|chapter| &chapter.evidence.tables).map(|table| &table.id);
    let sections = chapters.iter().flat_map(|chapter| &chapter.evidence.sections).map(|section| &section.id);
    chapters
        .iter()
        .map(|chapter| &chapter.id)
        .chain(tables)
        .chain(sections)
        .filter(|id| !serves(id))
        .map(|id| format!("`{id}`"))
        .collect()
}

fn ragged_rows(chapters: &[Chapter]) -> Vec<String> {
    let evidence = || chapters.iter().map(|chapter| &chapter.evidence);
    let tables = evidence().flat_map(|evidence| &evidence.tables).filter_map(|table| {
        let count = table.rows.iter().filter(|row| row.len() != table.columns.len()).count();
        (count > 0).then(|| format!("{count} in `{}`", table.id))
    });
    let is_ragged = |panel: &Panel| panel.field.as_ref().is_some_and(|field| !field.is_rectangular());
    let figures =
        evidence().flat_map(|evidence| &evidence.figures).filter(|figure| figure.panels.iter().any(is_ragged));
    tables.chain(figures.map(|figure| format!("a map in figure `{}`", figure.id))).collect()
}

fn not_numbers(chapters: &[Chapter]) -> Vec<String> {
    let tables = chapters.iter().flat_map(|chapter| &chapter.evidence.tables);
    tables
        .filter_map(|table| {
            let cells = table.rows.iter().flatten();
            let count = cells.filter(|cell| matches!(cell, Cell::Number(value) if value.is_nan())).count();
            (count > 0).then(|| format!("{count} in `{}`", table.id))
        })
        .collect()
}

fn vacuous(chapters: &[Chapter]) -> Vec<String> {
    let checks = chapters.iter().flat_map(|chapter| &chapter.evidence.checks);
    let cannot_fail = |check: &&Check| check.required.is_some_and(|required| !required.can_fail());
    checks.filter(cannot_fail).map(|check| format!("`{}`", check.id)).collect()
}

fn texts(chapters: &[Chapter]) -> impl Iterator<Item = &String> {
    chapters.iter().flat_map(|chapter| {
        let heads = [&chapter.title, &chapter.question, &chapter.source];
        heads.into_iter().chain(chapter.evidence.texts())
    })
}

fn unexplained(chapters: &[Chapter]) -> Vec<String> {
    texts(chapters).flat_map(|text| bibliography::unknown(text)).map(|key| format!("[{key}]")).collect()
}

fn runs_of_blanks(chapters: &[Chapter]) -> Vec<String> {
    texts(chapters).filter(|text| text.contains("  ")).map(|text| format!("“{text}”")).collect()
}

fn sections_without_parts(chapters: &[Chapter]) -> Vec<String> {
    let mut missing = Vec::new();
    for Evidence { tables, figures, sections, .. } in chapters.iter().map(|chapter| &chapter.evidence) {
        for section in sections {
            let lost_tables = section.tables.iter().filter(|id| tables.iter().all(|table| table.id != **id));
            let lost_figures = section.figures.iter().filter(|id| figures.iter().all(|figure| figure.id != **id));
            missing.extend(lost_tables.chain(lost_figures).map(|id| format!("`{}` names `{id}`", section.id)));
        }
    }
    missing
}

fn cells_without_checks(chapters: &[Chapter]) -> Vec<String> {
    let cells = chapters.iter().flat_map(|chapter| {
        chapter.evidence.grids.iter().flat_map(|grid| &grid.cells).filter(|cell| chapter.check(&cell.check).is_none())
    });
    cells.map(|cell| format!("`{}`", cell.check)).collect()
}

fn figures_without_data(chapters: &[Chapter]) -> Vec<String> {
    let ids: HashSet<_> =
        chapters.iter().flat_map(|chapter| &chapter.evidence.tables).map(|table| table.id.as_str()).collect();
    let figures = chapters.iter().flat_map(|chapter| &chapter.evidence.figures);
    figures
        .filter(|figure| !ids.contains(figure.data.as_str()))
        .map(|figure| format!("`{}` names `{}`", figure.id, figure.data))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Section;

    #[test]
    fn tables_and_figures_that_a_section_names_in_vain_are_found() {
        let named = |figures: &[&str], tables: &[&str]| {
            let [figures, tables] = [figures, tables].map(|ids| ids.iter().map(|id| (*id).to_owned()).collect());
            let section = Section {
                id: "s".into(),
                title: String::new(),
                mark: String::new(),
                paragraphs: Vec::new(),
                figures,
                tables,
            };
            let evidence = Evidence { sections: vec![section], ..Evidence::default() };
            let [id, title, question, source] = std::array::from_fn(|_| String::new());
            sections_without_parts(&[Chapter { id, title, question, source, evidence, error: None, seconds: 0.0 }])
        };
        assert_eq!(named(&[], &[]), [""; 0]);
        assert_eq!(named(&["f"], &["t"]), ["`s` names `t`", "`s` names `f`"]);
    }
}
