//! The first screen: what it is, each question with its answer, and the counts.

use maud::{Markup, html};

use super::super::run::{Chapter, Counts, Run};
use super::super::text::{anchor, clean};
use super::super::verdict;
use super::{IN_SIGHT, RECOMMENDATION, SHORT, SUMMARISED, by_reason, check_anchor, class, inline, sentence};
use crate::claim::Verdict;
use crate::evidence::{Check, Outcome, Section};

/// What of the provenance stands under the title.
const ORIGIN: [&str; 3] = ["verify", "commit", "date"];

/// The first stop of the keyboard.
pub(super) fn skip(run: &Run) -> Markup {
    let is_answered = told(run).into_iter().any(|section| answer(section).is_some());
    let target = if is_answered { "#_answers" } else { "#_summary" };
    html! { a.skip href=(target) { "Skip to the answers" } }
}

pub(super) fn title(run: &Run, counts: Counts) -> Markup {
    let known = |key: &&str| run.provenance.iter().find(|(known, _)| known == key);
    let origin: Vec<_> = ORIGIN.iter().filter_map(known).map(|(key, value)| format!("{key} {value}")).collect();
    html! {
        header {
            h1 { "Verification of lsvi" }
            p.headline.(if counts.is_ok() { "good" } else { "bad" }) { (sentence(&verdict::headline(counts))) }
            @if !origin.is_empty() { p.origin { (clean(&origin.join(" · "))) } }
        }
    }
}

/// What the first screen tells: which method to take for a model of one's own, and the sections of the first chapter.
fn told(run: &Run) -> Vec<&Section> {
    let own =
        run.chapters.iter().flat_map(|chapter| &chapter.evidence.sections).filter(|part| part.id == RECOMMENDATION);
    let first =
        run.chapters.iter().filter(|chapter| chapter.id == IN_SIGHT).flat_map(|chapter| &chapter.evidence.sections);
    own.chain(first).collect()
}

/// The sentence that answers the question of a section.
fn answer(section: &Section) -> Option<&str> {
    let is_answer = |label: &str| label == SHORT || section.id == RECOMMENDATION && label == "Answer";
    section.paragraphs.iter().find(|(label, _)| is_answer(label)).map(|(_, text)| text.as_str())
}

/// Each question with a word and a sentence, before anything else; then what else there is to look up.
pub(super) fn answers(run: &Run) -> Markup {
    let (questions, others): (Vec<_>, Vec<_>) = told(run).into_iter().partition(|section| answer(section).is_some());
    let link = |section: &Section| html! { a href=(format!("#{}", anchor(&section.id))) { (inline(&section.title)) } };
    html! {
        @if !questions.is_empty() {
            section #_answers tabindex="-1" {
                ul.answers {
                    @for section in questions {
                        li {
                            (link(section)) " "
                            @if !section.mark.is_empty() { span.mark { (clean(&section.mark)) } }
                            br; (inline(answer(section).unwrap_or_default()))
                        }
                    }
                    @for section in others { li { (link(section)) } }
                }
            }
        }
    }
}

/// How many claims have each verdict.
fn verdicts(run: &Run) -> Vec<(Verdict, usize)> {
    let claims = run.chapters.iter().filter(|chapter| chapter.id == SUMMARISED);
    let marks: Vec<_> = claims.flat_map(|chapter| &chapter.evidence.sections).map(|section| &section.mark).collect();
    let count = |verdict: Verdict| marks.iter().filter(|mark| **mark == verdict.word()).count();
    Verdict::ALL.map(|verdict| (verdict, count(verdict))).into_iter().filter(|(_, count)| *count > 0).collect()
}

pub(super) fn summary(run: &Run, counts: Counts) -> Markup {
    let tiles = [
        (counts.pass, Outcome::Pass),
        (counts.fail, Outcome::Fail),
        (counts.inconclusive, Outcome::Inconclusive),
        (counts.not_settled, Outcome::NotSettled),
        (counts.not_run, Outcome::NotRun),
    ];
    let verdicts = verdicts(run);
    let broken: Vec<_> = run.chapters.iter().filter_map(|chapter| Some((chapter, chapter.error.as_deref()?))).collect();
    html! {
        section #_summary tabindex="-1" {
            @if !verdicts.is_empty() {
                p.tally { a href=(format!("#{SUMMARISED}")) { (verdicts.iter().map(|(_, count)| count).sum::<usize>()) " claims of the papers" } }
                ul.tiles {
                    @for (verdict, count) in verdicts {
                        li.(verdict.word().replace(' ', "-")) { b { (count) } " " span { (verdict.word()) } }
                    }
                }
            }
            p.tally { (counts.checks()) " checks" }
            ul.tiles.checked {
                @for (count, outcome) in tiles {
                    li.(class(outcome)).none[count == 0] {
                        b { (count) } " " span { (verdict::symbol(outcome)) " " (verdict::word(outcome)) }
                    }
                }
            }
            @if !broken.is_empty() {
                h3 { "Studies that broke off" }
                ul.points {
                    @for (chapter, error) in broken {
                        li { a href=(format!("#{}", anchor(&chapter.id))) { (clean(&chapter.title)) } ": " (inline(error)) }
                    }
                }
            }
            @for outcome in [Outcome::Fail, Outcome::Inconclusive] {
                @let checks: Vec<_> = run.checks_that(outcome).collect();
                @if !checks.is_empty() {
                    h3 { (verdict::word(outcome)) " (" (checks.len()) ")" }
                    ul.points { @for (chapter, check) in checks { li { (check_link(chapter, check)) } } }
                }
            }
            @for (outcome, count) in [(Outcome::NotSettled, counts.not_settled), (Outcome::NotRun, counts.not_run)] {
            @let reasons = by_reason(run.checks_that(outcome));
            @if !reasons.is_empty() {
                details {
                    summary { (verdict::word(outcome)) " (" (count) "): " (reasons.len()) (if reasons.len() == 1 { " reason" } else { " reasons" }) }
                    ul.points {
                        @for (reason, checks) in reasons {
                            li {
                                (inline(&sentence(reason.trim_end_matches('.'))))
                                @for (chapter, check) in &checks { br; (check_link(chapter, check)) }
                            }
                        }
                    }
                }
            }
            }
        }
    }
}

fn check_link(chapter: &Chapter, check: &Check) -> Markup {
    html! {
        a href=(format!("#{}", check_anchor(chapter, &check.id))) { (inline(&check.statement)) } " "
        span.where { (clean(&chapter.title)) }
    }
}
