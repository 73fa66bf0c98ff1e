//! What steps cost in instructions, as callgrind counts them: repeatable for one binary, whatever else the machine does.

use std::path::Path;
use std::process::{Command, Stdio};

use super::{BenchError, Case, Side};

/// Runs that are counted, beyond a first that is not.
const RUNS: u32 = 4;
/// Steps, times cells, of the longest runs that are counted; a longer channel takes as many instructions per cell.
const MOST_ITEMS: f64 = 1e6;

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

/// Counts the instructions of one of these cases; `None` of one that is too long. `program` is this crate's command, of which
/// `bench --runs` does what is counted.
///
/// # Errors
/// [`BenchError::Valgrind`] without valgrind, [`BenchError::Uncounted`] if it counts nothing.
pub fn instructions(program: &Path, case: &Case) -> Result<Option<Count>, BenchError> {
    if case.items > MOST_ITEMS {
        return Ok(None);
    }
    let per_item = |side| -> Result<f64, BenchError> {
        let (first, all) = (collected(program, case, side, 1)?, collected(program, case, side, 1 + RUNS)?);
        Ok((all - first) / (f64::from(RUNS) * case.items))
    };
    Ok(Some(Count { name: case.name.clone(), ours: per_item(Side::Ours)?, limit: per_item(Side::ByHand)? }))
}

/// Instructions of a process that runs one side of a case so many times.
fn collected(program: &Path, case: &Case, side: Side, runs: u32) -> Result<f64, BenchError> {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(program)
        .args(["bench", "--only", &case.name, "--runs", &runs.to_string()])
        .args((side == Side::ByHand).then_some("--by-hand"))
        .stdin(Stdio::null())
        .output()
        .map_err(BenchError::Valgrind)?;
    let said = String::from_utf8_lossy(&output.stderr);
    let count = said.lines().find_map(|line| line.split_once("Collected :")?.1.trim().parse().ok());
    match count.filter(|_| output.status.success()) {
        Some(count) => Ok(count),
        None => Err(BenchError::Uncounted {
            case: case.name.clone(),
            said: said.lines().next_back().unwrap_or_default().into(),
        }),
    }
}
