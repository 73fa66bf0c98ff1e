//! What was found: checks, tables and figures. Chapters fill these in, the report renders them; neither knows the other.

mod check;
mod figure;
mod grid;
pub mod number;
mod requirement;
mod table;

pub use check::{Check, Outcome};
pub use figure::{Axis, COLORS, Field, Figure, Mark, Panel, Series};
pub use grid::{Grid, GridCell};
pub use requirement::Requirement;
pub use table::{Cell, Table, is_plain};

use serde::Serialize;

/// All that a study found.
#[derive(Debug, Clone, Default, speedy::Readable, speedy::Writable)]
pub struct Evidence {
    /// Decisions.
    pub checks: Vec<Check>,
    /// Tables.
    pub tables: Vec<Table>,
    /// Figures.
    pub figures: Vec<Figure>,
    /// Checks as maps.
    pub grids: Vec<Grid>,
    /// Findings in words, a paragraph each, `inline code` allowed.
    pub notes: Vec<String>,
    /// Parts with a heading each, after everything else.
    pub sections: Vec<Section>,
    /// Measured times in seconds by what took them; they differ from run to run and stand in `timings.json` alone.
    pub timings: Vec<(String, f64)>,
    /// Measured times of several solvers beside each other; on the page and in `timings.json` alone.
    pub spreads: Vec<Spread>,
}

/// How long a solver takes, over what another takes.
#[derive(Debug, Clone, Serialize, speedy::Readable, speedy::Writable)]
pub struct Spread {
    /// For what.
    pub what: String,
    /// The solver.
    pub solver: String,
    /// The solver whose fastest run is 1.
    pub base: String,
    /// Least, lower quartile and median of repeated runs; what other computations cost them is in the slow ones.
    pub ratios: [f64; 3],
}

impl Evidence {
    /// Takes up what was found under a heading: its words, figures and tables stand together there.
    pub fn add_under(&mut self, (id, title): (String, &str), part: Self) {
        let Self { checks, tables, figures, grids, notes, sections, timings, spreads } = part;
        self.sections.push(Section {
            id,
            title: title.into(),
            paragraphs: notes.into_iter().map(|text| (String::new(), text)).collect(),
            figures: figures.iter().map(|figure| figure.id.clone()).collect(),
            tables: tables.iter().filter(|table| table.shown).map(|table| table.id.clone()).collect(),
            ..Section::default()
        });
        self.checks.extend(checks);
        self.tables.extend(tables);
        self.figures.extend(figures);
        self.grids.extend(grids);
        self.sections.extend(sections);
        self.timings.extend(timings);
        self.spreads.extend(spreads);
    }

    /// Every text that a reader meets.
    pub fn texts(&self) -> impl Iterator<Item = &String> {
        let checks = self.checks.iter().flat_map(|check| [&check.statement, &check.reason]);
        let tables = self.tables.iter().flat_map(|table| {
            let cells = table.rows.iter().flatten().filter_map(|cell| match cell {
                Cell::Text(text) => Some(text),
                _ => None,
            });
            [&table.caption].into_iter().chain(cells)
        });
        let panels = self.figures.iter().flat_map(|figure| &figure.panels).flat_map(|panel| {
            let labels = panel.series.iter().map(|series| &series.label);
            [&panel.title, &panel.x.label, &panel.y.label].into_iter().chain(labels)
        });
        let sections = self.sections.iter().flat_map(|section| {
            let paragraphs = section.paragraphs.iter().flat_map(|(label, text)| [label, text]);
            [&section.title, &section.mark].into_iter().chain(paragraphs)
        });
        let captions = self.figures.iter().map(|figure| &figure.caption);
        checks.chain(tables).chain(captions).chain(panels).chain(&self.notes).chain(sections)
    }
}

/// A part of a chapter with a heading and an anchor of its own.
#[derive(Debug, Clone, Default, Serialize, speedy::Readable, speedy::Writable)]
pub struct Section {
    /// Stable identifier and anchor, unique in the report: `S24-a`. Cells of tables that hold it link here.
    pub id: String,
    /// Heading.
    pub title: String,
    /// A word set off beside the heading, such as a verdict; may be empty.
    pub mark: String,
    /// Labelled paragraphs, `inline code` allowed. Those of the running text, which is in sight, have empty labels.
    pub paragraphs: Vec<(String, String)>,
    /// Ids of the chapter's figures that are shown here.
    pub figures: Vec<String>,
    /// Ids of the chapter's tables that are shown here.
    pub tables: Vec<String>,
}

impl Section {
    /// Whether it belongs to the running text.
    pub fn is_text(&self) -> bool {
        self.paragraphs.iter().any(|(label, _)| label.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heading_names_the_tables_that_are_shown_and_every_text_is_met() {
        let table = |id: &str, shown| Table {
            shown,
            ..Table::new(id, format!("Of {id}."), ["x"], vec![vec![Cell::from("cell")]])
        };
        let check = Check::undecided("c", "The statement", Outcome::NotSettled, "the reason");
        let part = Evidence {
            checks: vec![check],
            tables: vec![table("seen", true), table("data", false)],
            ..Evidence::default()
        };
        let mut whole = Evidence::default();
        whole.add_under(("here".into(), "The heading"), part);
        assert_eq!(whole.sections[0].tables, ["seen"]);
        assert_eq!(whole.tables.len(), 2);
        let texts: Vec<_> = whole.texts().map(String::as_str).collect();
        for text in ["The statement", "the reason", "Of seen.", "Of data.", "cell", "The heading"] {
            assert!(texts.contains(&text), "{text} in {texts:?}");
        }
    }
}
