//! Work and precision of `lsvi` beside other solvers, at equal error.
//!
//! A solver is run over its tolerances, or numbers of steps, and what it costs at an error is interpolated on the lower envelope
//! of its runs: a power law between the two that the error lies between. Both are then timed again in rounds, in which all solvers
//! that come into question take turns, so that whatever else the machine does meets all; what counts are medians of the CPU
//! time of the process.

mod contest;
mod front;
mod measure;
mod problem;
mod solver;
mod table;
#[cfg(test)]
mod tests;

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

use crate::contest::{ALL, Contest, Set};
use crate::measure::Found;
use crate::problem::TruthError;

/// Time lsvi beside other solvers at equal error
#[derive(Debug, Parser)]
#[command(name = "peers", after_help = HELP)]
struct Args {
    /// Only the problems whose names contain this
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,

    /// How often each run that decides is timed
    #[arg(long, value_name = "N", default_value_t = 11, value_parser = clap::value_parser!(u16).range(1..))]
    rounds: u16,

    /// The table as comma-separated values
    #[arg(long, value_name = "FILE", default_value = "peers.csv")]
    out: PathBuf,

    /// Show every solver, with the times of its sweep
    #[arg(long)]
    all: bool,
}

const HELP: &str = "\
ours_us and peer_us are microseconds of CPU time of the process for a run with
the error, of the fastest on each side; ratio is the first over the second, so
that less than 1 is in favour of lsvi. Where a solver does not reach the error,
fails, or takes too many steps, there is a dash, which counts for neither.

The error is the largest difference of a component from the solution at the
end over the largest component there, the same for all. It counts only where
the next finer run confirms it.

problem       to t =    solution
channel       1         closed form; 200 unknowns, banded
Burgers       1         DoPri8 and Radau IIA agree; 200 unknowns, banded
van der Pol   2000      tabulated; mu = 1000
Robertson     40        tabulated
HIRES         321.8122  tabulated
pendulum      100       elliptic functions; from rest at 2 rad
Kepler        200 pi    closed form; eccentricity 0.6, 100 periods

Peers: SUNDIALS CVODE, diffsol, ode_solvers, differential-equations (diff.-eq.)
and russell_ode, each with the analytic Jacobian, and its band, if it takes one,
the same tolerance relative and absolute, and without dense output.

By hand: Radau IIA of order 5 with RADAU5's steps, for dense matrices of a size
that the compiler knows or for three diagonals, beside the adaptive method.

Examples:
  peers --only Kepler --all
  peers --rounds 5 --out work.csv

Exit status: 0 where all was timed, whatever the ratios; 2 for bad input.";

/// Why there are no tables.
#[derive(Debug, thiserror::Error)]
enum Failure {
    #[error("no problem has {text:?} in its name; there are {names}")]
    NoSuchProblem { text: String, names: String },
    #[error(transparent)]
    Truth(#[from] TruthError),
    #[error("cannot write {}: {source}", path.display())]
    Table { path: PathBuf, source: csv::Error },
    #[error("cannot write: {0}")]
    Output(#[from] io::Error),
}

fn main() -> ExitCode {
    match run(&Args::parse(), &mut io::stdout()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::from(2)
        }
    }
}

fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let text = args.only.as_deref().unwrap_or_default();
    if !ALL.iter().any(|contest| contest.problem.contains(text)) {
        // Those of the loops by hand are among the others.
        let others = ALL.iter().filter(|contest| contest.set != Set::ByHand);
        let names: Vec<&str> = others.map(|contest| contest.problem).collect();
        return Err(Failure::NoSuchProblem { text: text.into(), names: names.join(", ") });
    }
    let mut found: Vec<(&Contest, Found)> = Vec::new();
    for set in Set::ALL {
        let before = found.len();
        for contest in ALL.iter().filter(|contest| contest.set == set && contest.problem.contains(text)) {
            let result = (contest.run)(args.rounds)?;
            if args.all {
                table::solvers(out, contest.problem, &result)?;
            }
            found.push((contest, result));
        }
        if found.len() > before {
            table::set(out, set, &found[before..])?;
            out.flush()?;
        }
    }
    table::csv(&args.out, &found).map_err(|source| Failure::Table { path: args.out.clone(), source })?;
    Ok(writeln!(out, "The table is in {}", args.out.display())?)
}
