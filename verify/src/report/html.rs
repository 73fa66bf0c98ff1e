//! `index.html`: one file with style, script and figures inside, readable without a network and without the script.

use std::fmt::Write;

use super::plot::{self, Style};
use super::run::{Chapter, Counts, Run};
use super::text::{anchor, data_file, escape, inline_html as inline};
use super::verdict;
use crate::evidence::number::{Short, exact};
use crate::evidence::{Cell, Check, Evidence, Figure, Mark, Outcome, Section, Table};

/// Longer tables scroll within the page.
const TALL_TABLE: usize = 30;
/// Cells with longer texts want columns that do not shrink to a word.
const LONG_TEXT: usize = 80;
/// Passed checks beyond this many in a chapter are folded.
const MANY_CHECKS: usize = 12;

pub(super) fn document(run: &Run) -> String {
    let counts = run.counts();
    let mut out = String::from(concat!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n",
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n",
        "<meta name=\"color-scheme\" content=\"light dark\">\n",
        // The page asks the network for nothing, and this keeps it so.
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; ",
        "style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:\">\n",
        "<link rel=\"icon\" href=\"data:,\">\n<title>Verification of lsvi</title>\n<style>\n",
        include_str!("page.css"),
        "</style>\n</head>\n<body>\n",
    ));
    let _ = writeln!(
        out,
        "<header><h1>Verification of lsvi</h1><p class=\"headline {}\">{}</p></header>",
        if counts.is_ok() { "good" } else { "bad" },
        sentence(&verdict::headline(counts))
    );
    contents(&mut out, run);
    out.push_str("<main>\n");
    summary(&mut out, run, counts);
    let mut numbers = Numbers::default();
    for (index, chapter) in run.chapters.iter().enumerate() {
        write_chapter(&mut out, index + 1, chapter, &mut numbers);
    }
    provenance(&mut out, run);
    out.push_str("</main>\n<script>\n");
    out.push_str(include_str!("page.js"));
    out.push_str("</script>\n</body>\n</html>\n");
    out
}

/// Running numbers over the whole page.
#[derive(Default)]
struct Numbers {
    figures: usize,
    tables: usize,
}

fn sentence(text: &str) -> String {
    let mut chars = text.chars();
    let first = chars.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    format!("{}.", escape(&(first + chars.as_str())))
}

fn check_anchor(chapter: &Chapter, check: &Check) -> String {
    escape(&anchor(&format!("{}/{}", chapter.id, check.id)))
}

/// The sign after a heading or caption by which it can be linked.
fn permalink(anchor: &str, what: &str) -> String {
    format!("<a class=\"permalink\" href=\"#{anchor}\" aria-label=\"Link to this {what}\">#</a>")
}

fn badge(outcome: Outcome) -> String {
    format!(
        "<span class=\"badge {}\"><span aria-hidden=\"true\">{}</span> {}</span>",
        class(outcome),
        verdict::symbol(outcome),
        verdict::word(outcome)
    )
}

fn class(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Pass => "pass",
        Outcome::Fail => "fail",
        Outcome::Inconclusive => "inconclusive",
        Outcome::NotRun => "not-run",
    }
}

/// Four significant digits, with the whole number on request.
fn number(value: f64) -> String {
    let short = Short::new(value, 4);
    let text = match short.exponent {
        None => short.mantissa.clone(),
        Some(exponent) => {
            let power = format!("10<sup>{}</sup>", exponent.to_string().replace('-', "−"));
            match short.mantissa.as_str() {
                "1" => power,
                "−1" => format!("−{power}"),
                mantissa => format!("{mantissa}×{power}"),
            }
        }
    };
    let class = if value.is_nan() { "number odd" } else { "number" };
    format!("<span class=\"{class}\" title=\"{}\">{text}</span>", exact(value))
}

fn contents(out: &mut String, run: &Run) {
    out.push_str("<nav id=\"_contents\" aria-label=\"Contents\"><h2>Contents</h2>\n<ol>\n");
    for chapter in &run.chapters {
        let counts = Counts::of(chapter);
        let state = match counts {
            counts if !counts.is_ok() => Some(Outcome::Fail),
            Counts { inconclusive: 1.., .. } => Some(Outcome::Inconclusive),
            Counts { not_run: 1.., .. } => Some(Outcome::NotRun),
            Counts { pass: 1.., .. } => Some(Outcome::Pass),
            _ => None,
        };
        let sign = state.map(|outcome| {
            format!(
                "<span class=\"sign {}\" title=\"{}\">{}</span>",
                class(outcome),
                escape(&verdict::tally(counts)),
                verdict::symbol(outcome)
            )
        });
        let _ = writeln!(
            out,
            "<li><a href=\"#{}\">{}</a>{}</li>",
            escape(&anchor(&chapter.id)),
            escape(&chapter.title),
            sign.unwrap_or_default()
        );
    }
    out.push_str("</ol>\n<p><a href=\"#_provenance\">Provenance</a> · <a href=\"results.json\">results.json</a> · ");
    out.push_str("<a href=\"timings.json\">timings.json</a> · <a href=\"junit.xml\">junit.xml</a> · ");
    out.push_str("<a href=\"report.md\">report.md</a></p>\n</nav>\n");
}

fn summary(out: &mut String, run: &Run, counts: Counts) {
    out.push_str("<section id=\"_summary\"><h2>Summary</h2>\n<ul class=\"tiles\">");
    let tiles = [
        (counts.pass, Outcome::Pass),
        (counts.fail, Outcome::Fail),
        (counts.inconclusive, Outcome::Inconclusive),
        (counts.not_run, Outcome::NotRun),
    ];
    for (count, outcome) in tiles {
        let muted = if count == 0 { " none" } else { "" };
        let _ = write!(
            out,
            "<li class=\"{}{muted}\"><b>{count}</b> <span>{} {}</span></li>",
            class(outcome),
            verdict::symbol(outcome),
            verdict::word(outcome)
        );
    }
    out.push_str("</ul>\n");
    let broken: Vec<_> = run.chapters.iter().filter(|chapter| chapter.error.is_some()).collect();
    if !broken.is_empty() {
        out.push_str("<h3>Studies that broke off</h3>\n<ul class=\"points\">\n");
        for chapter in broken {
            let error = inline(chapter.error.as_deref().unwrap_or_default());
            let (id, title) = (escape(&anchor(&chapter.id)), escape(&chapter.title));
            let _ = writeln!(out, "<li><a href=\"#{id}\">{title}</a>: {error}</li>");
        }
        out.push_str("</ul>\n");
    }
    for outcome in [Outcome::Fail, Outcome::Inconclusive, Outcome::NotRun] {
        let checks: Vec<_> = run.checks_that(outcome).collect();
        if checks.is_empty() {
            continue;
        }
        // What did not run has its reason beside it in the chapters; the rest is what a reader must see.
        let folded = outcome == Outcome::NotRun && checks.len() > MANY_CHECKS;
        let [open, close] = if folded { ["<details><summary>", "</summary>"] } else { ["<h3>", "</h3>"] };
        let _ = writeln!(out, "{open}{} ({}){close}\n<ul class=\"points\">", verdict::word(outcome), checks.len());
        for (chapter, check) in checks {
            let _ = writeln!(
                out,
                "<li><a href=\"#{}\">{}</a> <span class=\"where\">{}</span></li>",
                check_anchor(chapter, check),
                inline(&check.statement),
                escape(&chapter.title)
            );
        }
        out.push_str(if folded { "</ul></details>\n" } else { "</ul>\n" });
    }
    out.push_str("</section>\n");
}

fn write_chapter(out: &mut String, position: usize, chapter: &Chapter, numbers: &mut Numbers) {
    let id = escape(&anchor(&chapter.id));
    let _ = writeln!(
        out,
        "<section class=\"chapter\" id=\"{id}\"><h2><span class=\"ordinal\">{position}</span> {} {}</h2>",
        escape(&chapter.title),
        permalink(&id, "chapter")
    );
    if !chapter.question.is_empty() {
        let _ = writeln!(out, "<p class=\"question\">{}</p>", inline(&chapter.question));
    }
    if !chapter.source.is_empty() {
        let _ = writeln!(out, "<p class=\"source\">Source: {}</p>", inline(&chapter.source));
    }
    if let Some(error) = &chapter.error {
        let _ = writeln!(
            out,
            "<p class=\"error\" role=\"alert\"><b>This study broke off:</b> {} What it found until then is below.</p>",
            inline(&ended(error))
        );
    }
    let evidence = &chapter.evidence;
    for note in &evidence.notes {
        let _ = writeln!(out, "<p>{}</p>", inline(note));
    }
    write_checks(out, chapter);
    let sections = &evidence.sections;
    let is_placed = |id: &str| sections.iter().any(|s| s.tables.iter().chain(&s.figures).any(|part| part == id));
    let figures = evidence.figures.iter().filter(|figure| !is_placed(&figure.id));
    figures.for_each(|figure| write_figure(out, figure, &mut numbers.figures));
    let tables = evidence.tables.iter().filter(|table| table.shown && !is_placed(&table.id));
    tables.for_each(|table| write_table(out, table, sections, &mut numbers.tables));
    sections.iter().for_each(|section| write_section(out, section, evidence, numbers));
    // Data that no figure of the chapter links to.
    let is_loose = |table: &&Table| !table.shown && evidence.figures.iter().all(|figure| figure.data != table.id);
    let loose: Vec<_> = evidence.tables.iter().filter(is_loose).collect();
    if !loose.is_empty() {
        out.push_str("<p class=\"data\">Further data:</p>\n<ul class=\"data\">\n");
        for table in loose {
            let _ = writeln!(
                out,
                "<li id=\"{}\">{}: {}</li>",
                table_anchor(table),
                data_link(&table.id),
                inline(&table.caption)
            );
        }
        out.push_str("</ul>\n");
    }
    out.push_str("</section>\n");
}

fn write_section(out: &mut String, section: &Section, evidence: &Evidence, numbers: &mut Numbers) {
    let id = escape(&anchor(&section.id));
    let mark = match section.mark.as_str() {
        "" => String::new(),
        mark => format!(" <span class=\"mark {0}\">{0}</span>", escape(mark)),
    };
    let _ = writeln!(
        out,
        "<section class=\"part\" id=\"{id}\"><h3><span class=\"ordinal\">{}</span> {}{mark} {}</h3>",
        escape(&section.id),
        inline(&section.title),
        permalink(&id, "section")
    );
    if !section.paragraphs.is_empty() {
        out.push_str("<dl>\n");
        for (label, text) in &section.paragraphs {
            let _ = writeln!(out, "<dt>{}</dt><dd>{}</dd>", inline(label), inline(text));
        }
        out.push_str("</dl>\n");
    }
    for figure in evidence.figures.iter().filter(|figure| section.figures.contains(&figure.id)) {
        write_figure(out, figure, &mut numbers.figures);
    }
    for table in evidence.tables.iter().filter(|table| table.shown && section.tables.contains(&table.id)) {
        write_table(out, table, &evidence.sections, &mut numbers.tables);
    }
    out.push_str("</section>\n");
}

fn ended(text: &str) -> String {
    let text = text.trim_end();
    if text.ends_with(['.', '!', '?']) { text.into() } else { format!("{text}.") }
}

fn write_checks(out: &mut String, chapter: &Chapter) {
    let checks = &chapter.evidence.checks;
    let mut order: Vec<_> = checks.iter().collect();
    order.sort_by_key(|check| match check.outcome {
        Outcome::Fail => 0,
        Outcome::Inconclusive => 1,
        Outcome::NotRun => 2,
        Outcome::Pass => 3,
    });
    let (open, passed): (Vec<_>, Vec<_>) = match checks.len() > MANY_CHECKS || !chapter.evidence.sections.is_empty() {
        true => order.into_iter().partition(|check| check.outcome != Outcome::Pass),
        false => (order, Vec::new()),
    };
    check_table(out, chapter, &open);
    if !passed.is_empty() {
        let _ = writeln!(out, "<details><summary>{} checks passed</summary>", passed.len());
        check_table(out, chapter, &passed);
        out.push_str("</details>\n");
    }
}

fn check_table(out: &mut String, chapter: &Chapter, checks: &[&Check]) {
    if checks.is_empty() {
        return;
    }
    out.push_str("<div class=\"scroll\"><table class=\"checks\"><thead><tr><th scope=\"col\">Outcome</th>");
    out.push_str("<th scope=\"col\">Check</th><th scope=\"col\" class=\"right\">Measured</th>");
    out.push_str("<th scope=\"col\">Required</th></tr></thead><tbody>\n");
    for check in checks {
        let id = check_anchor(chapter, check);
        let reason = match check.reason.as_str() {
            "" => String::new(),
            reason => format!("<p class=\"reason\">{}</p>", inline(reason)),
        };
        let measured = check.measured.map(number).unwrap_or_default();
        let _ = writeln!(
            out,
            "<tr id=\"{id}\"><td>{}</td><td>{} {}{reason}</td><td class=\"right\" data-name=\"Measured\"{}>{measured}</td>\
             <td data-name=\"Required\">{}</td></tr>",
            badge(check.outcome),
            inline(&check.statement),
            permalink(&id, "check"),
            check.measured.map(sort_key).unwrap_or_default(),
            escape(&check.required_text())
        );
    }
    out.push_str("</tbody></table></div>\n");
}

/// The number as the script reads it, where that is not the title of what is shown.
fn sort_key(value: f64) -> &'static str {
    match value {
        f64::INFINITY => " data-value=\"Infinity\"",
        f64::NEG_INFINITY => " data-value=\"-Infinity\"",
        _ => "",
    }
}

fn table_anchor(table: &Table) -> String {
    escape(&anchor(&format!("table:{}", table.id)))
}

fn data_link(id: &str) -> String {
    let file = escape(&data_file(id));
    format!("<a class=\"data\" href=\"{file}\">{file}</a>")
}

fn write_table(out: &mut String, table: &Table, sections: &[Section], count: &mut usize) {
    *count += 1;
    let id = table_anchor(table);
    let tall = if table.rows.len() > TALL_TABLE { " tall" } else { "" };
    let is_prose = |cell: &Cell| matches!(cell, Cell::Text(text) if text.len() > LONG_TEXT);
    let prose = if table.rows.iter().flatten().any(is_prose) { " prose" } else { "" };
    let _ = writeln!(
        out,
        "<div class=\"table\" id=\"{id}\"><p class=\"caption\" id=\"{id}-caption\"><b>Table {count}.</b> {} {} {}</p>",
        inline(&table.caption),
        data_link(&table.id),
        permalink(&id, "table")
    );
    if table.rows.is_empty() {
        out.push_str("<p class=\"empty\">No rows.</p></div>\n");
        return;
    }
    let _ = write!(
        out,
        "<div class=\"scroll{tall}\" tabindex=\"0\" role=\"region\" aria-labelledby=\"{id}-caption\">\
         <table class=\"sortable{prose}\" aria-labelledby=\"{id}-caption\"><thead><tr>"
    );
    let right: Vec<_> = (0..table.columns.len()).map(|column| is_numeric(table, column)).collect();
    let align = |column: usize| if right.get(column) == Some(&true) { " class=\"right\"" } else { "" };
    for (column, name) in table.columns.iter().enumerate() {
        let _ = write!(
            out,
            "<th scope=\"col\"{} title=\"{}\">{}</th>",
            align(column),
            escape(name),
            inline(&name.replace('_', " "))
        );
    }
    out.push_str("</tr></thead><tbody>\n");
    for row in &table.rows {
        out.push_str("<tr>");
        for (column, cell) in row.iter().enumerate() {
            let align = align(column);
            let _ = match cell {
                Cell::Text(text) if sections.iter().any(|section| section.id == *text) => {
                    let id = escape(&anchor(text));
                    write!(out, "<td{align}><a class=\"part\" href=\"#{id}\">{}</a></td>", escape(text))
                }
                Cell::Text(text) if sections.iter().any(|section| section.mark == *text) && !text.is_empty() => {
                    write!(out, "<td{align}><span class=\"mark {0}\">{0}</span></td>", escape(text))
                }
                Cell::Text(text) => write!(out, "<td{align}>{}</td>", inline(text)),
                Cell::Number(value) => write!(out, "<td{align}{}>{}</td>", sort_key(*value), number(*value)),
                Cell::Integer(value) => write!(
                    out,
                    "<td{align} data-value=\"{value}\"><span class=\"number\">{}</span></td>",
                    value.to_string().replace('-', "−")
                ),
                Cell::Empty => write!(out, "<td{align}></td>"),
            };
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody></table></div></div>\n");
}

fn is_numeric(table: &Table, column: usize) -> bool {
    let mut cells = table.rows.iter().filter_map(|row| row.get(column)).filter(|cell| **cell != Cell::Empty).peekable();
    cells.peek().is_some() && cells.all(|cell| matches!(cell, Cell::Number(_) | Cell::Integer(_)))
}

fn write_figure(out: &mut String, figure: &Figure, count: &mut usize) {
    *count += 1;
    let id = escape(&anchor(&format!("figure:{}", figure.id)));
    let columns = figure.columns.clamp(1, figure.panels.len().max(1));
    let legend = Legend::of(figure);
    let _ = writeln!(out, "<figure id=\"{id}\">\n<div class=\"panels columns-{}\">", columns.min(4));
    for (index, panel) in figure.panels.iter().enumerate() {
        out.push_str("<div class=\"panel\">");
        if !panel.title.is_empty() {
            let _ = write!(out, "<p class=\"title\">{}</p>", inline(&panel.title));
        }
        let styles: Vec<_> = panel.series.iter().map(|series| legend.style(&series.label, series.mark)).collect();
        match plot::panel(panel, &styles, &format!("{id}-{}", index + 1), columns) {
            Some(drawing) => {
                out.push_str(&drawing.svg);
                if drawing.dropped > 0 {
                    let _ = write!(
                        out,
                        "<p class=\"dropped\">Without {} that the axes have no place for (zero or less on a logarithmic \
                         axis, or not finite).</p>",
                        if drawing.dropped == 1 { "1 point".into() } else { format!("{} points", drawing.dropped) }
                    );
                }
            }
            None => {
                out.push_str("<p class=\"empty\">Nothing to draw: no point is finite and has a place on the axes.</p>")
            }
        }
        out.push_str("</div>\n");
    }
    out.push_str("</div>\n");
    legend.write(out);
    let _ = writeln!(
        out,
        "<figcaption><b>Figure {count}.</b> {} {} {}</figcaption>\n</figure>",
        inline(&figure.caption),
        data_link(&figure.data),
        permalink(&id, "figure")
    );
}

/// The entries of a figure, shared by its panels: a label looks the same in each.
struct Legend<'a> {
    entries: Vec<(&'a str, Style)>,
    bands: Vec<(&'a str, String)>,
}

impl<'a> Legend<'a> {
    fn of(figure: &'a Figure) -> Self {
        let mut legend = Self { entries: Vec::new(), bands: Vec::new() };
        let (mut guides, mut curves) = (0, 0);
        for panel in &figure.panels {
            for series in &panel.series {
                let is_guide = series.mark == Mark::Guide;
                if legend.find(&series.label, is_guide).is_some() {
                    continue;
                }
                let counter = if is_guide { &mut guides } else { &mut curves };
                legend.entries.push((&series.label, Style::new(*counter, series.mark)));
                *counter += 1;
            }
            if let Some(field) = &panel.field {
                let count = field.levels.len() + 1;
                for (index, band) in field.bands.iter().enumerate() {
                    let entry = (band.as_str(), plot::band_color(index, count, field.contours));
                    if !legend.bands.contains(&entry) {
                        legend.bands.push(entry);
                    }
                }
            }
        }
        legend
    }

    fn find(&self, label: &str, is_guide: bool) -> Option<Style> {
        let is_it = |(entry, style): &&(&str, Style)| *entry == label && style.is_guide() == is_guide;
        self.entries.iter().find(is_it).map(|(_, style)| *style)
    }

    fn style(&self, label: &str, mark: Mark) -> Style {
        self.find(label, mark == Mark::Guide).unwrap_or(Style::new(0, mark)).with_mark(mark)
    }

    fn write(&self, out: &mut String) {
        let named: Vec<_> = self.entries.iter().filter(|(label, _)| !label.is_empty()).collect();
        if named.is_empty() && self.bands.is_empty() {
            return;
        }
        out.push_str("<ul class=\"legend\">");
        for (label, color) in &self.bands {
            let _ = write!(
                out,
                "<li><span class=\"band\" style=\"background:{color}\"></span><span>{}</span></li>",
                inline(label)
            );
        }
        for (label, style) in named {
            let _ = write!(out, "<li>{}<span>{}</span></li>", style.swatch(), inline(label));
        }
        out.push_str("</ul>\n");
    }
}

fn provenance(out: &mut String, run: &Run) {
    out.push_str("<section id=\"_provenance\"><h2>Provenance</h2>\n<dl>\n");
    for (key, value) in &run.provenance {
        let _ = writeln!(out, "<dt>{}</dt><dd>{}</dd>", inline(key), inline(value));
    }
    out.push_str("</dl>\n</section>\n");
}
