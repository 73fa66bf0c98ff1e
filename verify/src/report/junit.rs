//! `junit.xml`: one test suite a chapter, one test case a check.
//!
//! A failed check is a `<failure>` and a study that broke off an `<error>`. JUnit knows no third verdict: readers take
//! failures and errors for a broken build. An inconclusive check breaks no build and must not count as passed either, so it
//! is `<skipped>` like one that was not settled or did not run, with a message that begins with `inconclusive:`.

use std::fmt::Write;

use super::run::{Chapter, Counts, Run};
use super::text::escape;
use crate::evidence::number::exact;
use crate::evidence::{Check, Outcome};

pub(super) fn document(run: &Run) -> String {
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let _ = writeln!(out, "<testsuites name=\"verify\" {}>", attributes(run.counts()));
    for chapter in &run.chapters {
        suite(&mut out, chapter);
    }
    out.push_str("</testsuites>\n");
    out
}

fn attributes(counts: Counts) -> String {
    format!(
        "tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\"",
        counts.checks() + counts.broken,
        counts.fail,
        counts.broken,
        counts.inconclusive + counts.not_settled + counts.not_run
    )
}

fn suite(out: &mut String, chapter: &Chapter) {
    let id = escape(&chapter.id);
    let _ = writeln!(out, "  <testsuite name=\"{id}\" {}>", attributes(Counts::of(chapter)));
    if let Some(error) = &chapter.error {
        let _ = writeln!(
            out,
            "    <testcase classname=\"{id}\" name=\"(study)\"><error type=\"study\" message=\"{}\"/></testcase>",
            one_line(error)
        );
    }
    for check in &chapter.evidence.checks {
        let _ = write!(out, "    <testcase classname=\"{id}\" name=\"{}\"", one_line(&check.id));
        let verdict = match check.outcome {
            Outcome::Pass => None,
            Outcome::Fail => Some(("failure type=\"fail\"", "")),
            Outcome::Inconclusive => Some(("skipped", "inconclusive: ")),
            Outcome::NotSettled => Some(("skipped", "not settled: ")),
            Outcome::NotRun => Some(("skipped", "not run: ")),
        };
        match verdict {
            None => out.push_str("/>\n"),
            Some((tag, prefix)) => {
                let _ = writeln!(out, "><{tag} message=\"{prefix}{}\"/></testcase>", message(check));
            }
        }
    }
    out.push_str("  </testsuite>\n");
}

fn message(check: &Check) -> String {
    let mut text = format!("{}.", check.statement.trim_end_matches('.'));
    if let Some(measured) = check.measured {
        let required = check.required.map_or_else(String::new, |_| format!(", required {}", check.required_text()));
        let _ = write!(text, " Measured {}{required}.", exact(measured));
    }
    if !check.reason.is_empty() {
        let _ = write!(text, " {}", check.reason);
    }
    one_line(&text)
}

/// Attribute values lose their line breaks on reading anyway.
fn one_line(text: &str) -> String {
    escape(&text.replace(['\n', '\r', '\t'], " "))
}
