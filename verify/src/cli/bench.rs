//! `bench`: what steps cost.

use std::fs;
use std::io::Write;
use std::path::PathBuf;

use verify::bench::{self, Cost};
use verify::names::NameError;

use super::Status;
use super::error::Failure;
use super::layout::{left, right, significant};
use super::output::Output;

/// Time the kernels of the library beside loops written by hand.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Times are CPU time per step, those of a channel per step and cell: medians over
rounds, in each of which both are run. The loop by hand solves the same
equations, and the results are compared first.

Examples:
  verify bench
  verify bench --only channel --rounds 5

A development build checks its arithmetic, which costs both. What optimises:
  cargo run --release -p verify -- bench

Exit status: 0 always when all was timed; ratios are figures, not checks.")]
pub(super) struct Args {
    /// Time only the cases whose names contain this
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,

    /// How often each is timed
    #[arg(long, value_name = "N", default_value_t = 21, value_parser = clap::value_parser!(u16).range(1..))]
    rounds: u16,

    /// The folder of which data/bench.csv is written
    #[arg(long, value_name = "DIR", default_value = "target/report")]
    out: PathBuf,
}

const NAME: usize = 28;
const NUMBER: usize = 10;

pub(super) fn run(args: &Args, out: &mut Output) -> Result<Status, Failure> {
    let mut cases = bench::all().map_err(bench::BenchError::from)?;
    if let Some(text) = &args.only {
        let names: Vec<String> = cases.iter().map(|case| case.name.clone()).collect();
        cases.retain(|case| case.name.contains(text.as_str()));
        if cases.is_empty() {
            return Err(NameError::unknown("case", text, names.iter().map(String::as_str)).into());
        }
    }
    let path = args.out.join("data").join("bench.csv");
    let create = || -> Result<_, csv::Error> {
        fs::create_dir_all(args.out.join("data"))?;
        let mut table = csv::Writer::from_path(&path)?;
        table.write_record(["case", "ours_ns", "limit_ns", "peer", "peer_ns", "ratio_limit", "ratio_peer"])?;
        Ok(table)
    };
    let failed = |source| Failure::Table { path: path.clone(), source };
    let mut table = create().map_err(failed)?;
    line(out, "case", ["ours, ns", "by hand", "ratio", "wanted"].map(String::from)).map_err(Failure::Output)?;
    for case in &mut cases {
        let cost = case.measure(usize::from(args.rounds))?;
        let Cost { ours, limit } = cost;
        let record = [ours.to_string(), limit.to_string(), String::new(), String::new(), cost.ratio().to_string()];
        let fields = std::iter::once(case.name.clone()).chain(record).chain([String::new()]);
        table.write_record(fields).and_then(|()| Ok(table.flush()?)).map_err(failed)?;
        let numbers = [ours, limit, cost.ratio()].map(|x| significant(x, 3));
        let [a, b, c] = numbers;
        line(out, &case.name, [a, b, c, format!("≤ {}", case.wanted)]).map_err(Failure::Output)?;
        out.flush().map_err(Failure::Output)?;
    }
    writeln!(out, "The table is in {}", path.display()).map_err(Failure::Output)?;
    Ok(Status::Ok)
}

fn line(out: &mut Output, name: &str, columns: [String; 4]) -> std::io::Result<()> {
    let columns = columns.map(|text| right(&text, NUMBER)).concat();
    writeln!(out, "{}{columns}", left(name, NAME))
}
