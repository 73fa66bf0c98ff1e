//! `golden check`, `golden diff` and `golden refresh`.

use super::{Golden, GoldenError, Inspection, Status, inspect};
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

/// Runs `action` on `goldens` kept in `dir` and reports to `out`. Returns whether all is well: for a refresh, whether it
/// left nothing to do; otherwise, whether every golden holds.
///
/// # Errors
/// [`GoldenError`] where the files or the output cannot be worked on.
pub fn run(action: Action, dir: &Path, goldens: &[Golden], out: &mut dyn Write) -> Result<bool, GoldenError> {
    let inspection = inspect(dir, goldens)?;
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
        writeln!(out, "all {count} goldens hold")?;
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
            Status::Malformed(error, _) => writeln!(out, "{name}: malformed, {error}")?,
            Status::Failed(error) => writeln!(out, "{name}: cannot be computed, {error}")?,
        }
        // A golden that cannot be frozen says why in every case.
        for change in status.changes().iter().filter(|change| rows || change.difference.is_wrong()) {
            for line in change.to_string().lines() {
                writeln!(out, "  {line}")?;
            }
        }
    }
    for orphan in &inspection.orphans {
        writeln!(out, "{}: orphan, no golden produces it", orphan.display())?;
    }
    Ok(())
}
