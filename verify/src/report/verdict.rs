//! The words and signs for outcomes, the same in every format.

use super::run::Counts;
use crate::evidence::Outcome;

pub(super) fn word(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Pass => "Pass",
        Outcome::Fail => "Fail",
        Outcome::Inconclusive => "Inconclusive",
        Outcome::NotRun => "Not run",
    }
}

/// A sign that differs in shape, for readers who do not see the colour.
pub(super) fn symbol(outcome: Outcome) -> char {
    match outcome {
        Outcome::Pass => '✓',
        Outcome::Fail => '✗',
        Outcome::Inconclusive => '?',
        Outcome::NotRun => '–',
    }
}

/// The run in half a sentence.
pub(super) fn headline(counts: Counts) -> String {
    let failed = match counts.fail {
        0 => String::new(),
        1 => "1 check failed".into(),
        n => format!("{n} checks failed"),
    };
    let broken = match counts.broken {
        0 => String::new(),
        1 => "1 study broke off".into(),
        n => format!("{n} studies broke off"),
    };
    match (counts.fail, counts.broken) {
        (0, 0) if counts.inconclusive + counts.not_run == 0 => format!("all {} checks passed", counts.pass),
        (0, 0) => format!("no check failed, {} of {} passed", counts.pass, counts.checks()),
        (_, 0) => failed,
        (0, _) => broken,
        _ => format!("{failed}, {broken}"),
    }
}

/// The counts that are not zero: `12 pass, 1 fail`.
pub(super) fn tally(counts: Counts) -> String {
    let parts = [
        (counts.broken, "broke off"),
        (counts.fail, "fail"),
        (counts.inconclusive, "inconclusive"),
        (counts.not_run, "not run"),
        (counts.pass, "pass"),
    ];
    let parts: Vec<_> = parts
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, word)| if *word == "broke off" { (*word).into() } else { format!("{count} {word}") })
        .collect();
    if parts.is_empty() { "no checks".into() } else { parts.join(", ") }
}
