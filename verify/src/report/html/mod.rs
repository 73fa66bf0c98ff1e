//! `index.html`: one file with style, script and figures inside, readable without a network. What is in sight needs no script.

mod chapter;
mod figure;
mod fold;
mod map;
mod opening;

pub(super) use figure::Legend;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::run::{Chapter, Counts, Run};
use super::style::Palette;
use super::text::{anchor, clean, inline_html};
use super::verdict;
use crate::evidence::number::{exact, short};
use crate::evidence::{Check, Outcome};

/// The chapter of which everything is in sight; of the others, what is behind their words takes a click.
const IN_SIGHT: &str = "answers";
/// The label of the sentence by which a section of it is told on the first screen, and there alone.
const SHORT: &str = "Short";
/// The section that stands in sight wherever it is.
const RECOMMENDATION: &str = "model-recommendation";
/// The chapter whose summary, its first table, is in sight.
const SUMMARISED: &str = "claims";

pub(super) fn document(run: &Run) -> String {
    let counts = run.counts();
    let mut numbers = Numbers::default();
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                // The page asks the network for nothing, and this keeps it so.
                meta http-equiv="Content-Security-Policy"
                    content="default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";
                link rel="icon" href="data:,";
                title { "Verification of lsvi" }
                style { (PreEscaped(include_str!("../page.css"))) }
            }
            body {
                (opening::skip(run))
                (opening::title(run, counts))
                (contents(run))
                main {
                    noscript {
                        p.error {
                            "The details of this page are packed, and its script unpacks them when they are opened. Without scripts they are in "
                            code { "data/" } " and " code { "report.md" } "."
                        }
                    }
                    (opening::answers(run))
                    (opening::summary(run, counts))
                    (primer(run))
                    @for (index, chapter) in run.chapters.iter().enumerate() {
                        (chapter::write(index + 1, chapter, Palette(&run.palette), &mut numbers))
                    }
                    (super::bibliography::write())
                    (provenance(run))
                }
                script { (PreEscaped(include_str!("../page.js"))) }
            }
        }
    };
    page.into_string()
}

/// What the words mean. Who asks about a model of his own looks for the recommendation first, and finds this folded.
fn primer(run: &Run) -> Markup {
    let text = PreEscaped(include_str!("../primer.html"));
    let is_known = |id: &str| run.chapters.iter().any(|chapter| chapter.id == id);
    let recommends =
        run.chapters.iter().flat_map(|chapter| &chapter.evidence.sections).any(|part| part.id == RECOMMENDATION);
    html! {
        @if recommends && !is_known(IN_SIGHT) { details { summary { "Terms: what is asked, and in which words" } (text) } }
        @else { (text) }
    }
}

/// Running numbers over the whole page.
#[derive(Default)]
struct Numbers {
    figures: usize,
    tables: usize,
}

/// Text with code, subscripts and superscripts.
fn inline(text: &str) -> Markup {
    PreEscaped(inline_html(text))
}

fn sentence(text: &str) -> String {
    let mut chars = text.chars();
    let first = chars.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}.", chars.as_str())
}

fn check_anchor(chapter: &Chapter, check: &str) -> String {
    anchor(&format!("{}/{check}", chapter.id))
}

/// The sign after a heading or caption by which it can be linked.
fn permalink(anchor: &str, what: &str) -> Markup {
    html! { a.permalink href=(format!("#{anchor}")) aria-label=(format!("Link to this {what}")) { "#" } }
}

fn badge(outcome: Outcome) -> Markup {
    html! { span.badge.(class(outcome)) { span aria-hidden="true" { (verdict::symbol(outcome)) } " " (verdict::word(outcome)) } }
}

fn class(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Pass => "pass",
        Outcome::Fail => "fail",
        Outcome::Inconclusive => "inconclusive",
        Outcome::NotSettled => "not-settled",
        Outcome::NotRun => "not-run",
    }
}

/// Four significant digits, with the whole number on request.
fn number(value: f64) -> Markup {
    let text = short(value);
    html! {
        @if value.is_nan() { span.number.odd { (text) } }
        @else if exact(value) == text { span.number { (text) } }
        @else { span.number title=(exact(value)) { (text) } }
    }
}

fn contents(run: &Run) -> Markup {
    let state = |counts: Counts| match counts {
        counts if !counts.is_ok() => Some(Outcome::Fail),
        Counts { inconclusive: 1.., .. } => Some(Outcome::Inconclusive),
        Counts { not_settled: 1.., .. } => Some(Outcome::NotSettled),
        Counts { not_run: 1.., .. } => Some(Outcome::NotRun),
        Counts { pass: 1.., .. } => Some(Outcome::Pass),
        _ => None,
    };
    html! {
        nav #_contents aria-label="Contents" {
            details {
                summary { "Contents" }
                ol {
                    @for chapter in &run.chapters {
                        li {
                            a href=(format!("#{}", anchor(&chapter.id))) { (clean(&chapter.title)) }
                            @if let Some(outcome) = state(Counts::of(chapter)) {
                                span.sign.(class(outcome)) title=(verdict::tally(Counts::of(chapter))) {
                                    (verdict::symbol(outcome))
                                }
                            }
                        }
                    }
                }
            }
            p {
                a href="#_terms" { "Terms" } " · " a href="#_bibliography" { "Bibliography" } " · "
                a href="#_provenance" { "Provenance" }
                @for file in ["results.json", "timings.json", "junit.xml", "report.md"] {
                    " · " a href=(file) { (file) }
                }
            }
        }
    }
}

/// Checks by their reason, in the order of the first of each.
fn by_reason<'a, T>(checks: impl Iterator<Item = (T, &'a Check)>) -> Vec<(&'a str, Vec<(T, &'a Check)>)> {
    let mut groups: Vec<(&str, Vec<_>)> = Vec::new();
    for (chapter, check) in checks {
        match groups.iter_mut().find(|(reason, _)| *reason == check.reason) {
            Some((_, group)) => group.push((chapter, check)),
            None => groups.push((&check.reason, vec![(chapter, check)])),
        }
    }
    groups
}

fn provenance(run: &Run) -> Markup {
    html! {
        section #_provenance {
            h2 { "Provenance" }
            dl { @for (key, value) in &run.provenance { dt { (inline(key)) } dd { (inline(value)) } } }
        }
    }
}
