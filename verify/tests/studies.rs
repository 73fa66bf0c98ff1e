//! Every check of every study holds.

use verify::chapter::{ALL, Context};
use verify::evidence::Outcome;

#[test]
fn every_check_of_every_study_holds() {
    let mut failures = Vec::new();
    for study in ALL {
        let evidence = (study.run)(&Context::QUICK).unwrap_or_else(|error| panic!("{}: {error}", study.id));
        assert!(!evidence.checks.is_empty(), "{} decides nothing", study.id);
        for check in evidence.checks {
            if matches!(check.outcome, Outcome::Fail | Outcome::Inconclusive) {
                failures.push(format!("{}/{}: {:?}: {}", study.id, check.id, check.outcome, check.reason));
            }
        }
    }
    assert!(failures.is_empty(), "{} checks do not hold:\n{}", failures.len(), failures.join("\n"));
}
