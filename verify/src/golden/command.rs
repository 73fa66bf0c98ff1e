//! `golden check`, `golden diff` and `golden refresh`.

use super::{Golden, GoldenError, Inspection, Status, inspect, strays};
use std::io::Write;
use std::path::Path;

/// What to do with the golden files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// Say of each golden whether it holds.
    Check,
    /// Say of each row that differs how it differs.
    Diff,
    /// Say the same, then bring the files up to date.
    Refresh,
}

/// Runs `action` on the goldens kept in `dir`, or on the one called `only`, and reports to `out`. Files that belong to no
/// golden count where all goldens are looked at, and are not touched otherwise. Returns whether all is well: for a refresh, whether it
/// left nothing to do; otherwise, whether every golden holds.
///
/// # Errors
/// [`GoldenError`] where the files or the output cannot be worked on.
pub fn run(
    action: Action,
    dir: &Path,
    goldens: &[Golden],
    only: Option<&str>,
    out: &mut dyn Write,
) -> Result<bool, GoldenError> {
    let inspection = match only {
        Some(name) => match goldens.iter().find(|golden| golden.name == name) {
            Some(golden) => inspect(dir, std::slice::from_ref(golden))?,
            None => return Err(GoldenError::Unknown(name.to_owned())),
        },
        None => inspect(dir, goldens)?.with_strays(strays(dir, goldens)?),
    };
    let count = inspection.statuses().count();
    print(&inspection, action != Action::Check, out)?;
    if action == Action::Refresh {
        for line in inspection.apply()? {
            writeln!(out, "{line}")?;
        }
        let wrong = inspection.statuses().filter(|(_, status)| !status.is_fit()).count();
        if wrong > 0 {
            writeln!(out, "{wrong} of {count} goldens were not refreshed")?;
        } else if inspection.is_clean() {
            writeln!(out, "nothing to refresh")?;
        }
        return Ok(wrong == 0);
    }
    if inspection.is_clean() {
        match count {
            1 => writeln!(out, "the golden holds")?,
            _ => writeln!(out, "all {count} goldens hold")?,
        }
    } else if action == Action::Check {
        writeln!(out, "`golden diff` shows the rows, `golden refresh` accepts them")?;
    }
    Ok(inspection.is_clean())
}

fn print(inspection: &Inspection, rows: bool, out: &mut dyn Write) -> Result<(), GoldenError> {
    for (name, status) in inspection.statuses() {
        let count = status.changes().len();
        match status {
            Status::Same => writeln!(out, "{name}: ok")?,
            Status::Changed(_) => writeln!(out, "{name}: differs ({count})")?,
            Status::Missing(_) => writeln!(out, "{name}: no file")?,
            Status::Malformed(faults, _) => {
                writeln!(out, "{name}: malformed ({}), differs ({count})", faults.len())?;
                for fault in faults {
                    writeln!(out, "  {fault}")?;
                }
            }
            Status::Failed(error) => writeln!(out, "{name}: cannot be computed, {error}")?,
        }
        // A golden that cannot be frozen says why in every case.
        for change in status.changes().iter().filter(|change| rows || change.difference.is_wrong()) {
            for line in change.to_string().lines() {
                writeln!(out, "  {line}")?;
            }
        }
    }
    for stray in inspection.strays() {
        let why = if stray.to_string_lossy().contains(".snap.new") {
            "left to review: `cargo insta review`, or `golden refresh`"
        } else {
            "orphan, no golden produces it"
        };
        writeln!(out, "{}: {why}", stray.display())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Neither a check nor a refresh has anything good to say of it.
    #[test]
    fn a_golden_that_cannot_be_computed_does_not_hold() {
        let golden = Golden::new("broken", || Err("no luck".into()));
        let elsewhere = tempfile::tempdir().expect("a directory");
        let dir = &elsewhere.path().join("none");
        let inspection = inspect(dir, std::slice::from_ref(&golden)).expect("a name");
        assert!(!inspection.is_clean());
        for action in [Action::Check, Action::Diff, Action::Refresh] {
            let mut out = Vec::new();
            let all_is_well = run(action, dir, std::slice::from_ref(&golden), None, &mut out).expect("can be written");
            let said = String::from_utf8(out).expect("text");
            assert!(
                !all_is_well && !said.contains("hold") && !said.contains("nothing to refresh"),
                "{action:?}: {said}"
            );
        }
        assert!(!dir.exists());
    }
}
