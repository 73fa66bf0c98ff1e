//! How much each chapter has: a check or a row that is lost fails nothing, and is missed here alone. `INSTA_UPDATE=always` accepts
//! what there is now.

use std::fmt::Write;

use libtest_mimic::Failed;
use verify::chapter;
use verify::evidence::{Check, Evidence};
use verify::experiment::Context;

/// The checks of each kind and the rows of each table, chapter by chapter.
pub(super) fn is_what_it_was(context: &Context) -> Result<(), Failed> {
    // Without CVODE what is compared with it is missing.
    if !cfg!(feature = "cvode") {
        return Ok(());
    }
    let mut text = String::new();
    for study in chapter::ALL {
        let evidence = (study.run)(context).map_err(|error| format!("{}: {error}", study.id))?;
        let _ = writeln!(text, "{}\n{}", study.id, contents(&evidence));
    }
    insta::with_settings!({ omit_expression => true, prepend_module_to_snapshot => false }, {
        insta::assert_snapshot!("contents", text);
    });
    Ok(())
}

fn contents(evidence: &Evidence) -> String {
    let mut kinds: Vec<(&str, usize)> = Vec::new();
    for kind in evidence.checks.iter().map(kind) {
        match kinds.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, count)) => *count += 1,
            None => kinds.push((kind, 1)),
        }
    }
    let checks = kinds.into_iter().map(|(kind, count)| format!("  {count} checks {kind}\n"));
    let rows = evidence.tables.iter().map(|table| format!("  {} rows {}\n", table.rows.len(), table.id));
    let notes = format!("  {} notes, {} figures\n", evidence.notes.len(), evidence.figures.len());
    checks.chain(rows).chain([notes]).collect()
}

/// What a check is about, as far as its identifier tells: all of it that stands before the first slash.
fn kind(check: &Check) -> &str {
    check.id.split('/').next().unwrap_or_default()
}
