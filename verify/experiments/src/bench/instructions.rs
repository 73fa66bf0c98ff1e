//! What steps cost in instructions, as callgrind counts them: repeatable for one binary, whatever else the machine does.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use lsvi::StepError;

use super::{BenchError, Case, Kernel, Side};

/// Runs that are counted, beyond a first that is not.
const RUNS: u32 = 4;
/// Steps, times cells, of the longest runs that are counted; a longer channel takes as many instructions per cell.
const MOST_ITEMS: f64 = 1e6;
/// What callgrind knows [`counted_runs`] by.
const COUNTED: &str = concat!(module_path!(), "::counted_runs");

/// Instructions per step, or per step and cell, of a [`Case`].
#[derive(Debug, Clone)]
pub struct Count {
    /// Name of the case.
    pub name: String,
    /// Of the library.
    pub ours: f64,
    /// Of the loop written by hand.
    pub limit: f64,
}

/// The cases whose instructions are counted, with the two of each.
fn counted(cases: &[Case]) -> impl Iterator<Item = (&Case, Side)> {
    let short = cases.iter().filter(|case| case.items <= MOST_ITEMS);
    short.flat_map(|case| [Side::Ours, Side::ByHand].map(|side| (case, side)))
}

/// Runs, for callgrind, what [`instructions`] counts of these cases.
///
/// # Errors
/// [`BenchError`] if a step fails.
pub fn run_counted(cases: &[Case]) -> Result<(), BenchError> {
    for (case, side) in counted(cases) {
        let mut kernel = (case.prepare)()?;
        kernel.run(side, 1)?;
        counted_runs(&mut kernel, side)?;
    }
    Ok(())
}

/// Callgrind collects while it is in here, and writes down a count whenever it leaves.
#[inline(never)]
fn counted_runs(kernel: &mut Kernel, side: Side) -> Result<(), StepError> {
    kernel.run(side, RUNS)
}

/// Counts the instructions of those of these cases that are not too long. `program` with `arguments` calls [`run_counted`] of the same.
///
/// # Errors
/// [`BenchError::Valgrind`] without valgrind, [`BenchError::Uncounted`] if it counts nothing.
pub fn instructions(program: &Path, arguments: &[&str], cases: &[Case]) -> Result<Vec<Count>, BenchError> {
    let dir = tempfile::tempdir().map_err(BenchError::Counts)?;
    let parts = dir.path().join("part");
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--collect-atstart=no"])
        .args([format!("--toggle-collect={COUNTED}"), format!("--dump-after={COUNTED}")])
        .arg(format!("--callgrind-out-file={}", parts.display()))
        .arg(program)
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .map_err(BenchError::Valgrind)?;
    let mut per_item = Vec::new();
    for (place, (case, _)) in counted(cases).enumerate() {
        let part = fs::read_to_string(parts.with_extension((1 + place).to_string())).unwrap_or_default();
        let count = part.lines().find_map(|line| line.strip_prefix("summary: ")?.trim().parse::<f64>().ok());
        let Some(count) = count.filter(|count| output.status.success() && *count > 0.0) else {
            let said = String::from_utf8_lossy(&output.stderr);
            let said = said.lines().next_back().unwrap_or_default().into();
            return Err(BenchError::Uncounted { case: case.name.clone(), said });
        };
        per_item.push(count / (f64::from(RUNS) * case.items));
    }
    let names = counted(cases).step_by(2).map(|(case, _)| case.name.clone());
    let counts = names.zip(per_item.chunks_exact(2));
    Ok(counts.map(|(name, both)| Count { name, ours: both[0], limit: both[1] }).collect())
}
