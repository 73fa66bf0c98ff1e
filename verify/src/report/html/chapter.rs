//! One chapter: its question and answer in words, and the evidence a click behind.

use maud::{Markup, html};

use super::super::style::Palette;
use super::super::text::{anchor, clean, data_file, heading};
use super::super::verdict;
use super::figure::figure;
use super::fold::fold;
use super::map::map;
use super::{Numbers, badge, by_reason, check_anchor, class, inline, number, permalink};
use crate::evidence::{Cell, Check, Evidence, Figure, Outcome, Section, Spread, Table};
use crate::report::run::Chapter;

/// Longer tables scroll within the page.
const TALL_TABLE: usize = 30;
/// Cells with longer texts want columns that do not shrink to a word.
const LONG_TEXT: usize = 80;
/// A cell with a longer sentence is no narrower than half a line.
const SENTENCE: usize = 40;

pub(super) fn write(position: usize, chapter: &Chapter, palette: Palette<'_>, numbers: &mut Numbers) -> Markup {
    let id = anchor(&chapter.id);
    let evidence = &chapter.evidence;
    let summary = (chapter.id == super::SUMMARISED).then(|| evidence.tables.first()).flatten();
    let summary = summary.map(|first| (&first.id, table(first, &evidence.sections, true, &mut numbers.tables)));
    // Written in the order of the page, in which figures and tables are numbered.
    let is_recommendation = |part: &&Section| part.id == super::RECOMMENDATION;
    let recommended = evidence.sections.iter().filter(is_recommendation);
    let recommended: Vec<_> = recommended.map(|part| section(part, chapter, palette, numbers)).collect();
    let text = evidence.sections.iter().filter(|part| part.is_text());
    let text: Vec<_> = text.map(|part| text_section(part, chapter, palette, numbers)).collect();
    let body = body(chapter, summary.as_ref().map(|(id, _)| id.as_str()), palette, numbers);
    html! {
        section.chapter id=(id) {
            h2 { span.ordinal { (position) } " " (clean(&chapter.title)) " " (permalink(&id, "chapter")) }
            @if !chapter.question.is_empty() { p.question { (inline(&chapter.question)) } }
            @if !chapter.source.is_empty() { p.source { "Source: " (inline(&chapter.source)) } }
            @if let Some(error) = &chapter.error {
                p.error role="alert" {
                    b { "This study broke off:" } " " (inline(&ended(error))) " What it found until then is below."
                }
            }
            @for part in recommended { (part) }
            @for note in &evidence.notes { p { (inline(note)) } }
            @for grid in &evidence.grids { (map(grid, chapter)) }
            (undecided(chapter))
            @for part in text { (part) }
            @if let Some((_, table)) = &summary { (table) }
            @if chapter.id == super::IN_SIGHT { (body) }
            @else if !body.0.is_empty() {
                @let (figures, tables) = outside_text(evidence);
                @let passed = evidence.checks.iter().filter(|check| check.outcome == Outcome::Pass).count();
                (fold("evidence", &behind(figures.len(), tables.len(), passed), body))
            }
        }
    }
}

/// Figures and tables to be shown that belong to no section of the running text.
fn outside_text(evidence: &Evidence) -> (Vec<&Figure>, Vec<&Table>) {
    let sections = || evidence.sections.iter().filter(|part| part.is_text());
    let figures = evidence.figures.iter().filter(|figure| !sections().any(|part| part.figures.contains(&figure.id)));
    let tables = evidence.tables.iter().filter(|table| table.shown);
    let tables = tables.filter(|table| !sections().any(|part| part.tables.contains(&table.id)));
    (figures.collect(), tables.collect())
}

/// What a click shows.
fn behind(figures: usize, tables: usize, passed: usize) -> String {
    let count = |n: usize, one: &str, many: &str| (n > 0).then(|| format!("{n} {}", if n == 1 { one } else { many }));
    let parts = [
        count(figures, "figure", "figures"),
        count(tables, "table", "tables"),
        count(passed, "check that passed", "checks that passed"),
    ];
    match parts.into_iter().flatten().collect::<Vec<_>>().as_slice() {
        [] => "Data".into(),
        parts => parts.join(", "),
    }
}

/// Everything that is not told above it, such as the table `told`.
fn body(chapter: &Chapter, told: Option<&str>, palette: Palette<'_>, numbers: &mut Numbers) -> Markup {
    let evidence = &chapter.evidence;
    let sections = &evidence.sections;
    let is_placed = |id: &str| sections.iter().any(|s| s.tables.iter().chain(&s.figures).any(|part| part == id));
    let passed: Vec<_> = evidence.checks.iter().filter(|check| check.outcome == Outcome::Pass).collect();
    // Data that no figure of the chapter links to.
    let is_loose = |table: &&Table| !table.shown && evidence.figures.iter().all(|figure| figure.data != table.id);
    let loose: Vec<_> = evidence.tables.iter().filter(is_loose).collect();
    html! {
        @for part in evidence.figures.iter().filter(|figure| !is_placed(&figure.id)) {
            (figure(part, palette, &mut numbers.figures))
        }
        @for part in evidence.tables.iter().filter(|table| table.shown && !is_placed(&table.id) && told != Some(&table.id)) {
            (table(part, sections, false, &mut numbers.tables))
        }
        @if !evidence.spreads.is_empty() { (spreads(&evidence.spreads)) }
        @for part in sections.iter().filter(|part| part.id != super::RECOMMENDATION && !part.is_text()) {
            (section(part, chapter, palette, numbers))
        }
        @if !loose.is_empty() {
            p.data { "Further data:" }
            ul.data {
                @for table in loose {
                    li id=(table_anchor(table)) { (data_link(&table.id)) ": " (inline(&table.caption)) }
                }
            }
        }
        // What a fold of the chapter holds alone takes one click.
        @let (figures, tables) = outside_text(evidence);
        @if chapter.id != super::IN_SIGHT && figures.is_empty() && tables.is_empty() {
            (check_table(chapter, &passed))
        } @else if !passed.is_empty() {
            details {
                summary { (passed.len()) (if passed.len() == 1 { " check passed" } else { " checks passed" }) }
                (check_table(chapter, &passed))
            }
        }
    }
}

/// Measured times: they differ from run to run, and have no file of data.
fn spreads(spreads: &[Spread]) -> Markup {
    html! {
        div.table {
            p.caption { "Times of repeated runs, each solver with the setting that reaches the accuracy fastest, as multiples of the fastest of the one named as base." }
            div.scroll tabindex="0" role="region" aria-label="Times" {
                table.sortable {
                    thead { tr { @for name in ["problem", "solver", "least", "quartile", "median", "base"] { th scope="col" { (name) } } } }
                    tbody {
                        @for Spread { what, solver, base, ratios } in spreads {
                            tr {
                                td { (clean(what)) } td { (clean(solver)) }
                                @for ratio in ratios { td.right data-value=(ratio) { (format!("{ratio:.2}")) } }
                                td { (clean(base)) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// What failed or was not decided stands in sight; what was not settled or did not run, once for each reason.
fn undecided(chapter: &Chapter) -> Markup {
    let of = |outcome| chapter.evidence.checks.iter().filter(move |check| check.outcome == outcome);
    let open: Vec<_> = of(Outcome::Fail).chain(of(Outcome::Inconclusive)).collect();
    html! {
        (check_table(chapter, &open))
        @for outcome in [Outcome::NotSettled, Outcome::NotRun] {
        @for (reason, checks) in by_reason(of(outcome).map(|check| ((), check))) {
            details.(class(outcome)) {
                summary { (verdict::symbol(outcome)) " " (verdict::word(outcome)) " (" (checks.len()) "): " (inline(reason.trim_start_matches("not run: "))) }
                ul { @for (_, check) in checks { li id=(check_anchor(chapter, &check.id)) { (inline(&check.statement)) } } }
            }
        }
        }
    }
}

/// A section of the running text: what it says, and its figures and tables a click behind.
fn text_section(section: &Section, chapter: &Chapter, palette: Palette<'_>, numbers: &mut Numbers) -> Markup {
    let id = anchor(&section.id);
    let evidence = &chapter.evidence;
    let figures = evidence.figures.iter().filter(|figure| section.figures.contains(&figure.id));
    let figures: Vec<_> = figures.map(|part| figure(part, palette, &mut numbers.figures)).collect();
    let tables = evidence.tables.iter().filter(|table| table.shown && section.tables.contains(&table.id));
    let tables: Vec<_> = tables.map(|part| table(part, &evidence.sections, false, &mut numbers.tables)).collect();
    let label = behind(figures.len(), tables.len(), 0);
    html! {
        section.part id=(id) {
            h3 { (inline(&section.title)) " " (permalink(&id, "section")) }
            @for (_, text) in &section.paragraphs { p { (inline(text)) } }
            @if !figures.is_empty() || !tables.is_empty() {
                (fold("evidence", &label, html! { @for part in figures.iter().chain(&tables) { (part) } }))
            }
        }
    }
}

fn section(section: &Section, chapter: &Chapter, palette: Palette<'_>, numbers: &mut Numbers) -> Markup {
    let id = anchor(&section.id);
    let evidence = &chapter.evidence;
    let is_recommendation = section.id == super::RECOMMENDATION;
    html! {
        section.part id=(id) {
            h3 {
                @if chapter.id != super::IN_SIGHT && section.id != super::RECOMMENDATION { span.ordinal { (clean(&section.id)) } " " } (inline(&section.title))
                @if !section.mark.is_empty() { " " span.mark.(clean(&section.mark).replace(' ', "-")) { (clean(&section.mark)) } }
                " " (permalink(&id, "section"))
            }
            // What to take comes before the pictures that show why; elsewhere the picture is the answer.
            @if is_recommendation { (paragraphs(section)) }
            @for part in evidence.figures.iter().filter(|figure| section.figures.contains(&figure.id)) {
                (figure(part, palette, &mut numbers.figures))
            }
            @if !is_recommendation { (paragraphs(section)) }
            @for part in evidence.tables.iter().filter(|table| table.shown && section.tables.contains(&table.id)) {
                (table(part, &evidence.sections, false, &mut numbers.tables))
            }
        }
    }
}

/// The labelled paragraphs, but the one that the first screen has.
fn paragraphs(section: &Section) -> Markup {
    let told: Vec<_> = section.paragraphs.iter().filter(|(label, _)| label != super::SHORT).collect();
    html! { @if !told.is_empty() { dl { @for (label, text) in told { dt { (inline(label)) } dd { (inline(text)) } } } } }
}

fn ended(text: &str) -> String {
    let text = text.trim_end();
    if text.ends_with(['.', '!', '?']) { text.into() } else { format!("{text}.") }
}

fn check_table(chapter: &Chapter, checks: &[&Check]) -> Markup {
    html! {
        @if !checks.is_empty() {
            div.scroll tabindex="0" role="region" aria-label="Checks" {
                table.checks {
                    thead {
                        tr { th scope="col" { "Outcome" } th scope="col" { "Check" } th scope="col" { "Measured" } th scope="col" { "Required" } }
                    }
                    tbody {
                        @for check in checks {
                            tr id=(check_anchor(chapter, &check.id)) {
                                td { (badge(check.outcome)) }
                                td {
                                    (inline(&check.statement))
                                    @if !check.reason.is_empty() { p.reason { (inline(&check.reason)) } }
                                }
                                td data-value=[check.measured.and_then(sort_key)] { @if let Some(value) = check.measured { (number(value)) } }
                                td { (check.required_text()) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The number as the script reads it, where that is not the title of what is shown.
fn sort_key(value: f64) -> Option<&'static str> {
    match value {
        f64::INFINITY => Some("Infinity"),
        f64::NEG_INFINITY => Some("-Infinity"),
        _ => None,
    }
}

fn table_anchor(table: &Table) -> String {
    anchor(&format!("table:{}", table.id))
}

pub(super) fn data_link(id: &str) -> Markup {
    let file = data_file(id);
    html! { a.data href=(file) { (file) } }
}

/// A long table scrolls within the page unless it is shown `whole`.
fn table(table: &Table, sections: &[Section], whole: bool, count: &mut usize) -> Markup {
    *count += 1;
    let id = table_anchor(table);
    let is_prose = |cell: &Cell| matches!(cell, Cell::Text(text) if text.len() > LONG_TEXT);
    let is_prose = table.rows.iter().flatten().any(is_prose);
    let right: Vec<_> = (0..table.columns.len()).map(|column| is_numeric(table, column)).collect();
    let align = |column: usize| (right.get(column) == Some(&true)).then_some("right");
    let label = |name: String| if name.ends_with('?') { name } else { name + ":" };
    let labels: Vec<String> = table.columns.iter().filter(|_| is_prose).map(|name| label(heading(name))).collect();
    let label = |column: usize| labels.get(column).map(String::as_str);
    html! {
        div.table id=(id) {
            p.caption id=(format!("{id}-caption")) {
                b { "Table " (count) "." } " " (inline(&table.caption)) " " (data_link(&table.id)) " " (permalink(&id, "table"))
            }
            @if table.rows.is_empty() { p.empty { "No rows." } }
            @else {
                div.scroll.tall[table.rows.len() > TALL_TABLE && !whole] tabindex="0" role="region" aria-labelledby=(format!("{id}-caption")) {
                    table.sortable.prose[is_prose] aria-labelledby=(format!("{id}-caption")) {
                        thead {
                            tr { @for (column, name) in table.columns.iter().enumerate() { th scope="col" class=[align(column)] { (heading(name)) } } }
                        }
                        tbody {
                            @for row in &table.rows {
                                tr { @for (column, content) in row.iter().enumerate() { (cell(content, align(column), label(column), sections)) } }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// `label` is the heading of its column, for a narrow window, which has no room for a head.
fn cell(content: &Cell, align: Option<&str>, label: Option<&str>, sections: &[Section]) -> Markup {
    match content {
        Cell::Text(text) => match sections.iter().find(|section| section.id == *text) {
            Some(section) => {
                html! { td class=[align] data-label=[label] { a.part href=(format!("#{}", anchor(&section.id))) { (clean(text)) } } }
            }
            // A verdict looks the same here as beside the heading of its section.
            None if !text.is_empty() && sections.iter().any(|section| section.mark == *text) => {
                html! { td data-label=[label] { span.mark.(clean(text).replace(' ', "-")) { (clean(text)) } } }
            }
            None if text.len() > SENTENCE && text.ends_with(['.', '?']) => {
                html! { td.sentence data-label=[label] { (inline(text)) } }
            }
            None => html! { td class=[align] data-label=[label] { (inline(text)) } },
        },
        Cell::Number(value) => {
            html! { td class=[align] data-label=[label] data-value=[sort_key(*value)] { (number(*value)) } }
        }
        Cell::Integer(value) => {
            html! { td class=[align] data-label=[label] data-value=(value) { (value.to_string().replace('-', "−")) } }
        }
        Cell::Empty => html! { td class=[align] {} },
    }
}

fn is_numeric(table: &Table, column: usize) -> bool {
    let mut cells = table.rows.iter().filter_map(|row| row.get(column)).filter(|cell| **cell != Cell::Empty).peekable();
    cells.peek().is_some() && cells.all(|cell| matches!(cell, Cell::Number(_) | Cell::Integer(_)))
}
