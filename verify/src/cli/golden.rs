//! `golden`: the frozen numbers.

use std::env;
use std::path::PathBuf;
use std::sync::Arc;

use clap::Subcommand;
use verify::experiment::Context;
use verify::golden::{self, Action, GoldenError};
use verify::names::NameError;

use super::Status;
use super::error::Failure;
use super::output::Output;

/// Hold the golden files against what the code computes now.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A golden row has a value, a tolerance, its provenance and where known the truth.
A value that is wrong is never written, and a file that no golden produces
counts as a difference, unless --only names the golden to look at. A test that
fails leaves what it computed beside the file, for `cargo insta review`.

Examples:
  verify golden check
  verify golden diff       each row that differs, toward or away from the truth
  verify golden refresh    the same, then write the files
  verify golden diff --only orders

Exit status: 0 nothing differs, or all was refreshed, 1 otherwise, 2 trouble
with the files or bad usage.")]
pub(super) struct Args {
    #[command(subcommand)]
    command: Command,

    /// The golden files [default: golden/ of the workspace]
    #[arg(long, global = true)]
    dir: Option<PathBuf>,

    /// This golden alone; see `verify list goldens`
    #[arg(long, global = true, value_name = "NAME")]
    only: Option<String>,
}

#[derive(Debug, Clone, Copy, Subcommand)]
enum Command {
    /// Say of each golden whether it holds
    #[command(after_help = "Examples:\n  verify golden check\n  verify golden check --only figure-2")]
    Check,
    /// Show the rows that differ
    #[command(after_help = "Examples:\n  verify golden diff\n  verify golden diff --only orders")]
    Diff,
    /// Show the rows that differ, then bring the files up to date
    #[command(after_help = "Examples:\n  verify golden refresh\n  verify golden refresh --only orders")]
    Refresh,
}

pub(super) fn run(args: &Args, out: &mut Output) -> Result<Status, Failure> {
    let action = match args.command {
        Command::Check => Action::Check,
        Command::Diff => Action::Diff,
        Command::Refresh => Action::Refresh,
    };
    let dir = match &args.dir {
        Some(dir) => {
            // A folder that is not there has no goldens that differ; a refresh makes one.
            if action != Action::Refresh {
                let unread = |source| GoldenError::Io { path: dir.clone(), source };
                dir.read_dir().map_err(unread)?;
            }
            dir.clone()
        }
        None => golden::find_dir(&env::current_dir().map_err(GoldenError::Output)?)?,
    };
    let goldens = golden::all(&Arc::new(Context::quick()));
    let is_unknown = |only: &&String| goldens.iter().all(|golden| golden.name != **only);
    if let Some(only) = args.only.as_ref().filter(is_unknown) {
        return Err(NameError::unknown("golden", only, goldens.iter().map(|golden| golden.name.as_str())).into());
    }
    Ok(if golden::run(action, &dir, &goldens, args.only.as_deref(), out)? { Status::Ok } else { Status::Failed })
}
