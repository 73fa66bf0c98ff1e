//! The run on one screen of a terminal, at most 80 columns wide.

use std::fmt::Write;
use std::io::IsTerminal;

use super::comparison::Comparison;
use super::run::{Counts, Run};
use super::verdict;
use crate::evidence::Outcome;

const WIDTH: usize = 80;
/// Of the titles, beside which the counts have room.
const TITLE: usize = 30;
const BROKE_OFF: &str = " (broke off)";
/// Lines for chapters and for what did not pass, so that the whole fits a screen of 24 lines.
const MAX_CHAPTERS: usize = 12;
const MAX_POINTS: usize = 5;
/// Lines for what changed since an earlier run.
const MAX_CHANGES: usize = 12;

/// Whether standard output wants colour: a terminal, `NO_COLOR` unset or empty (<https://no-color.org>) and `TERM` not
/// `dumb`.
pub fn wants_color() -> bool {
    let is_set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    std::io::stdout().is_terminal() && !is_set("NO_COLOR") && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
}

/// Counts by chapter, then what did not pass, the failures first.
pub fn summary(run: &Run, color: bool) -> String {
    let counts = run.counts();
    let mut out = format!(
        "{:TITLE$} {:>6} {:>6} {:>13} {:>12} {:>8}\n",
        "", "pass", "fail", "inconclusive", "not settled", "not run"
    );
    // Chapters with something to look at come before those that merely fill the screen.
    let mut chapters: Vec<_> = run.chapters.iter().collect();
    if chapters.len() > MAX_CHAPTERS {
        chapters.sort_by_key(|chapter| Counts::of(chapter).is_ok());
    }
    for chapter in chapters.iter().take(MAX_CHAPTERS) {
        line(&mut out, &chapter.title, Counts::of(chapter), color);
    }
    if chapters.len() > MAX_CHAPTERS {
        let more = chapters.len() - MAX_CHAPTERS;
        let _ = writeln!(out, "… and {more} more chapter{}", if more == 1 { "" } else { "s" });
    }
    line(&mut out, "All", Counts { broken: 0, ..counts }, color);
    points(&mut out, run, color);
    if let Some(comparison) = &run.comparison {
        changes(&mut out, comparison, color);
    }
    let style = if counts.is_ok() { GREEN } else { RED };
    let _ = writeln!(out, "\n{}", paint(&verdict::headline(counts), style, color));
    out
}

fn line(out: &mut String, title: &str, counts: Counts, color: bool) {
    let number = |count: usize, width: usize, style: &str| {
        let text = if count == 0 { "·".into() } else { count.to_string() };
        paint(&format!("{text:>width$}"), if count == 0 { DIM } else { style }, color)
    };
    let _ = writeln!(
        out,
        "{} {} {} {} {} {}",
        if counts.broken > 0 { pad(title, TITLE - BROKE_OFF.len()) + BROKE_OFF } else { pad(title, TITLE) },
        number(counts.pass, 6, GREEN),
        number(counts.fail, 6, RED),
        number(counts.inconclusive, 13, YELLOW),
        number(counts.not_settled, 12, YELLOW),
        number(counts.not_run, 8, YELLOW)
    );
}

fn points(out: &mut String, run: &Run, color: bool) {
    let broken = run.chapters.iter().filter_map(|chapter| {
        chapter.error.as_ref().map(|error| (RED, format!("✗ {} broke off: {error}", chapter.id)))
    });
    let open = [Outcome::Inconclusive, Outcome::NotSettled, Outcome::NotRun].map(|outcome| (outcome, YELLOW));
    let checks = [(Outcome::Fail, RED)].into_iter().chain(open).map(|(outcome, style)| {
        run.checks_that(outcome).map(move |(chapter, check)| {
            (style, format!("{} {}: {} ({})", verdict::symbol(outcome), chapter.id, check.id, check.reason))
        })
    });
    let points: Vec<_> = broken.chain(checks.flatten()).collect();
    if !points.is_empty() {
        out.push('\n');
    }
    for (style, text) in points.iter().take(MAX_POINTS) {
        let _ = writeln!(out, "{}", paint(pad(text, WIDTH).trim_end(), style, color));
    }
    if points.len() > MAX_POINTS {
        let _ = writeln!(out, "… and {} more in the report", points.len() - MAX_POINTS);
    }
}

fn changes(out: &mut String, comparison: &Comparison, color: bool) {
    let _ = writeln!(out, "\n{}", pad(&comparison.headline(), WIDTH).trim_end());
    for change in comparison.changes.iter().take(MAX_CHANGES) {
        let text = format!("Δ {}: {}", change.place, change.what);
        let _ = writeln!(out, "{}", paint(pad(&text, WIDTH).trim_end(), YELLOW, color));
    }
    if comparison.changes.len() > MAX_CHANGES {
        let _ = writeln!(out, "… and {} more in report.md", comparison.changes.len() - MAX_CHANGES);
    }
    if !comparison.not_run.is_empty() {
        let _ =
            writeln!(out, "{}", pad(&format!("not in this run: {}", comparison.not_run.join(", ")), WIDTH).trim_end());
    }
}

const GREEN: &str = "32";
const RED: &str = "31";
const YELLOW: &str = "33";
const DIM: &str = "2";

fn paint(text: &str, style: &str, color: bool) -> String {
    if color { format!("\x1b[{style}m{text}\x1b[0m") } else { text.into() }
}

/// Cuts or fills to a width in characters; control characters could move the cursor and become blanks.
fn pad(text: &str, width: usize) -> String {
    let text = text.replace(char::is_control, " ");
    if text.chars().count() > width {
        text.chars().take(width - 1).chain(['…']).collect()
    } else {
        format!("{text:width$}")
    }
}
