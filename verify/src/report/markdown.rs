//! `report.md`: the run as a comment on a pull request.

use std::fmt::Write;

use super::comparison::Comparison;
use super::run::{Chapter, Counts, Run};
use super::text::inline_markdown as inline;
use super::verdict;
use crate::evidence::number::short;
use crate::evidence::{Cell, Check, Outcome, Table};

/// GitHub cuts comments at 65 536 characters; what goes beyond is in `index.html`.
const MAX_LENGTH: usize = 60_000;
/// Longer tables are in their files.
const MAX_ROWS: usize = 25;

pub(super) fn document(run: &Run) -> String {
    let counts = run.counts();
    let mut out = format!("# Verification: {}\n\n", verdict::headline(counts));
    out.push_str("| Chapter | Pass | Fail | Inconclusive | Not settled | Not run |\n|:--|--:|--:|--:|--:|--:|\n");
    for chapter in &run.chapters {
        let title = inline(&chapter.title);
        let title = if chapter.error.is_some() { format!("**{title}** (broke off)") } else { title };
        row(&mut out, &title, Counts::of(chapter));
    }
    row(&mut out, "**All**", counts);
    if let Some(comparison) = &run.comparison {
        changes(&mut out, comparison);
    }
    open_points(&mut out, run);
    details(&mut out, run);
    if !run.provenance.is_empty() {
        out.push_str("\n<details><summary>Provenance</summary>\n\n| | |\n|:--|:--|\n");
        for (key, value) in &run.provenance {
            let _ = writeln!(out, "| {} | {} |", inline(key), inline(value));
        }
        out.push_str("\n</details>\n");
    }
    out
}

fn row(out: &mut String, title: &str, counts: Counts) {
    let Counts { pass, fail, inconclusive, not_settled, not_run, .. } = counts;
    let _ = writeln!(out, "| {title} | {pass} | {fail} | {inconclusive} | {not_settled} | {not_run} |");
}

fn changes(out: &mut String, comparison: &Comparison) {
    let _ = write!(out, "\n## Compared: {}\n\n", inline(&comparison.headline()));
    for (index, change) in comparison.changes.iter().enumerate() {
        if out.len() > MAX_LENGTH / 2 {
            let _ = writeln!(out, "- … and {} more", comparison.changes.len() - index);
            break;
        }
        let _ = writeln!(out, "- **{}** · {}", inline(&change.place), inline(&change.what));
    }
    if !comparison.not_run.is_empty() {
        let _ = writeln!(out, "\nNot in this run: {}.", inline(&comparison.not_run.join(", ")));
    }
}

/// Everything that did not pass, the failures first.
fn open_points(out: &mut String, run: &Run) {
    let broken: Vec<_> =
        run.chapters.iter().filter_map(|chapter| chapter.error.as_ref().map(|error| (chapter, error))).collect();
    if !broken.is_empty() {
        out.push_str("\n## Studies that broke off\n\n");
        for (chapter, error) in broken {
            let _ = writeln!(out, "- **{}**: {}", inline(&chapter.title), inline(error));
        }
    }
    for outcome in [Outcome::Fail, Outcome::Inconclusive, Outcome::NotSettled, Outcome::NotRun] {
        let checks: Vec<_> = run.checks_that(outcome).collect();
        if checks.is_empty() {
            continue;
        }
        let _ = write!(out, "\n## {} ({})\n\n", verdict::word(outcome), checks.len());
        for (index, (chapter, check)) in checks.iter().enumerate() {
            if out.len() > MAX_LENGTH {
                let _ = writeln!(out, "- … and {} more, see `index.html`", checks.len() - index);
                break;
            }
            let _ = write!(out, "- **{}** · {}", inline(&chapter.title), inline(&check.statement));
            if let Some(measured) = check.measured {
                let _ = write!(out, ": {}, required {}", short(measured), check.required_text());
            }
            if !check.reason.is_empty() {
                let _ = write!(out, ". {}", inline(&check.reason));
            }
            out.push('\n');
        }
    }
}

fn details(out: &mut String, run: &Run) {
    out.push_str("\n## Details\n");
    for (index, chapter) in run.chapters.iter().enumerate() {
        let text = chapter_details(chapter);
        if out.len() + text.len() > MAX_LENGTH {
            let rest: Vec<_> = run.chapters[index..].iter().map(|chapter| inline(&chapter.title)).collect();
            let _ = writeln!(out, "\nToo long to show here, see `index.html`: {}.", rest.join(", "));
            return;
        }
        out.push_str(&text);
    }
}

fn chapter_details(chapter: &Chapter) -> String {
    let evidence = &chapter.evidence;
    // Headings inside <summary> are HTML, where Markdown's escapes would show.
    let title = super::text::escape(&chapter.title);
    let mut out = format!("\n<details><summary>{title}: {}</summary>\n", verdict::tally(Counts::of(chapter)));
    for paragraph in std::iter::once(&chapter.question).chain(&evidence.notes).filter(|text| !text.is_empty()) {
        let _ = write!(out, "\n{}\n", inline(paragraph));
    }
    let shown = || evidence.tables.iter().filter(|table| table.shown);
    for section in evidence.sections.iter().filter(|section| section.is_text()) {
        let _ = write!(out, "\n#### {}\n", inline(&section.title));
        for (_, text) in &section.paragraphs {
            let _ = write!(out, "\n{}\n", inline(text));
        }
        shown().filter(|table| section.tables.contains(&table.id)).for_each(|table| show_table(&mut out, table));
    }
    if !evidence.checks.is_empty() {
        out.push_str("\n| | Check | Measured | Required |\n|:--|:--|--:|:--|\n");
        evidence.checks.iter().for_each(|check| check_row(&mut out, check));
    }
    // The details of other sections are in `index.html`.
    let is_placed = |table: &&Table| evidence.sections.iter().any(|section| section.tables.contains(&table.id));
    shown().filter(|table| !is_placed(table)).for_each(|table| show_table(&mut out, table));
    out.push_str("\n</details>\n");
    out
}

fn check_row(out: &mut String, check: &Check) {
    let measured = check.measured.map(short).unwrap_or_default();
    let (symbol, word) = (verdict::symbol(check.outcome), verdict::word(check.outcome));
    let _ =
        writeln!(out, "| {symbol} {word} | {} | {measured} | {} |", inline(&check.statement), check.required_text());
}

fn show_table(out: &mut String, table: &Table) {
    let _ = write!(out, "\n{}\n\n|", inline(&table.caption));
    for column in &table.columns {
        let _ = write!(out, " {} |", inline(column));
    }
    out.push_str("\n|");
    out.push_str(&":--|".repeat(table.columns.len()));
    out.push('\n');
    for row in table.rows.iter().take(MAX_ROWS) {
        out.push('|');
        for cell in row {
            let text = match cell {
                Cell::Text(text) => inline(text),
                Cell::Number(value) => short(*value),
                Cell::Integer(value) => value.to_string(),
                Cell::Empty => String::new(),
            };
            let _ = write!(out, " {text} |");
        }
        out.push('\n');
    }
    if table.rows.len() > MAX_ROWS {
        let _ =
            write!(out, "\n{} more rows in `{}`.\n", table.rows.len() - MAX_ROWS, super::text::data_file(&table.id));
    }
}
