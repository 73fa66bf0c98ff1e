//! The words and signs for outcomes, the same in every format.

use super::run::Counts;
use crate::evidence::Outcome;

pub(super) fn word(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Pass => "Pass",
        Outcome::Fail => "Fail",
        Outcome::Inconclusive => "Inconclusive",
        Outcome::NotSettled => "Not settled",
        Outcome::NotRun => "Not run",
    }
}

/// A sign that differs in shape, for readers who do not see the colour.
pub(super) fn symbol(outcome: Outcome) -> char {
    match outcome {
        Outcome::Pass => '✓',
        Outcome::Fail => '✗',
        Outcome::Inconclusive => '?',
        Outcome::NotSettled => '~',
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
        (0, 0) if counts.pass == counts.checks() => format!("all {} checks passed", counts.pass),
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
        (counts.not_settled, "not settled"),
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

#[cfg(test)]
mod tests {
    use super::*;

    const COUNTS: Counts = Counts { pass: 7, fail: 5, inconclusive: 3, not_settled: 4, not_run: 2, broken: 0 };

    #[test]
    fn a_headline_claims_no_more_than_the_counts() {
        let none = Counts { fail: 0, ..COUNTS };
        assert_eq!(headline(COUNTS), "5 checks failed");
        assert_eq!(headline(none), "no check failed, 7 of 16 passed");
        assert_eq!(headline(Counts { inconclusive: 0, ..none }), "no check failed, 7 of 13 passed");
        assert_eq!(headline(Counts { not_run: 0, ..none }), "no check failed, 7 of 14 passed");
        assert_eq!(headline(Counts { pass: 7, not_settled: 1, ..Counts::default() }), "no check failed, 7 of 8 passed");
        assert_eq!(headline(Counts { pass: 7, ..Counts::default() }), "all 7 checks passed");
        assert_eq!(headline(Counts { broken: 1, ..none }), "1 study broke off");
        assert_eq!(headline(Counts { broken: 3, ..none }), "3 studies broke off");
        assert_eq!(headline(Counts { fail: 1, broken: 2, ..none }), "1 check failed, 2 studies broke off");
        assert_eq!(tally(COUNTS), "5 fail, 3 inconclusive, 4 not settled, 2 not run, 7 pass");
    }

    /// A failure or a study that broke off makes a run that is not well, and the exit status 1.
    #[test]
    fn what_failed_or_broke_off_is_not_well() {
        let well = Counts { fail: 0, ..COUNTS };
        assert!(well.is_ok() && !COUNTS.is_ok() && !Counts { broken: 1, ..well }.is_ok());
        let signs =
            [Outcome::Pass, Outcome::Fail, Outcome::Inconclusive, Outcome::NotSettled, Outcome::NotRun].map(symbol);
        assert_eq!(signs, ['✓', '✗', '?', '~', '–']);
    }
}
