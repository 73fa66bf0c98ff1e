//! `bench`: what steps cost.

use std::env;
use std::fs;
use std::io::Write;
use std::path::PathBuf;

use verify::bench::{self, BenchError, Case, Cost, Count, Other};
use verify::golden::{self, Action, Golden, GoldenError, Row, Tolerance};
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
  verify bench --instructions            counted by valgrind
  verify bench --peers                   other solvers too, minutes

A development build checks its arithmetic, which costs both. What optimises:
  cargo run --release -p verify -- bench

Instructions are the same for the same build whatever else the machine does.
Without --only they are held against golden/callgrind, to a twentieth. A count
of the loops by hand that moved means another compiler or processor.

Exit status: 0 when all was timed, as ratios are figures and not checks; 1 if
counts differ from the golden file, or nothing could be run (the peers need
SUNDIALS, and a network at first); 2 trouble with files or bad usage.")]
pub(super) struct Args {
    /// Time only the case of this name, or those whose names contain it
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,

    /// How often each is timed
    #[arg(long, value_name = "N", default_value_t = 21, value_parser = clap::value_parser!(u16).range(1..))]
    rounds: u16,

    /// The folder of which data/bench.csv is written
    #[arg(long, value_name = "DIR", default_value = "target/report")]
    out: PathBuf,

    /// Compare with other solvers at equal error too: builds verify/peers
    #[arg(long, conflicts_with_all = ["only", "instructions"])]
    peers: bool,

    /// Count instructions instead of time, by valgrind
    #[arg(long, conflicts_with = "rounds")]
    instructions: bool,

    /// Accept the counts as the golden ones
    #[arg(long, requires = "instructions", conflicts_with = "only")]
    refresh: bool,

    /// The golden counts [default: golden/callgrind of the workspace]
    #[arg(long, requires = "instructions", value_name = "DIR")]
    golden: Option<PathBuf>,

    /// Run what is counted, and say nothing
    #[arg(long, conflicts_with = "instructions", hide = true)]
    counted: bool,
}

const NAME: usize = 28;
const NUMBER: usize = 10;

pub(super) fn run(args: &Args, out: &mut Output) -> Result<Status, Failure> {
    let mut cases = bench::all();
    if let Some(text) = &args.only {
        let names: Vec<String> = cases.iter().map(|case| case.name.clone()).collect();
        let is_name = names.contains(text);
        cases.retain(|case| if is_name { case.name == *text } else { case.name.contains(text.as_str()) });
        if cases.is_empty() {
            return Err(NameError::unknown("case", text, names.iter().map(String::as_str)).into());
        }
    }
    if args.counted {
        bench::run_counted(&cases)?;
        return Ok(Status::Ok);
    }
    if args.instructions { count(args, &cases, out) } else { time(args, &cases, out) }
}

/// How far a count may move without a word: less than a call more in each evaluation of an equation.
const BUDGET: f64 = 0.05;

fn count(args: &Args, cases: &[Case], out: &mut Output) -> Result<Status, Failure> {
    let program = env::current_exe().map_err(Failure::Output)?;
    line(out, "case", ["lsvi", "by hand", "ratio", ""].map(String::from)).map_err(Failure::Output)?;
    let mut arguments = vec!["bench", "--counted"];
    arguments.extend(args.only.iter().flat_map(|text| ["--only", text]));
    let mut rows = Vec::new();
    for Count { name, ours, limit } in bench::instructions(&program, &arguments, cases)? {
        let [a, b] = [ours, limit].map(|x| significant(x, 4));
        line(out, &name, [a, b, significant(ours / limit, 3), String::new()]).map_err(Failure::Output)?;
        let tolerance = || Tolerance::relative(BUDGET, "of one compiler and processor: a twentieth");
        rows.push(Row::number(format!("{name}: lsvi"), ours, tolerance()));
        rows.push(Row::number(format!("{name}: by hand"), limit, tolerance()));
    }
    if args.only.is_some() {
        return Ok(Status::Ok);
    }
    let dir = match &args.golden {
        Some(dir) => dir.clone(),
        None => golden::find_dir(&env::current_dir().map_err(GoldenError::Output)?)?.join("callgrind"),
    };
    let golden = Golden::new("instructions", move || Ok(rows.clone()));
    let action = if args.refresh { Action::Refresh } else { Action::Diff };
    Ok(if golden::run(action, &dir, &[golden], None, out)? { Status::Ok } else { Status::Failed })
}

fn time(args: &Args, cases: &[Case], out: &mut Output) -> Result<Status, Failure> {
    let path = args.out.join("data").join("bench.csv");
    let create = || -> Result<_, csv::Error> {
        fs::create_dir_all(args.out.join("data"))?;
        let mut table = csv::Writer::from_path(&path)?;
        table.write_record(["case", "ours_ns", "limit_ns", "peer", "peer_ns", "ratio_limit", "ratio_peer"])?;
        Ok(table)
    };
    let failed = |source| Failure::Table { path: path.clone(), source };
    // Looked for before minutes are spent.
    let golden = args.peers.then(|| golden::find_dir(&env::current_dir().map_err(GoldenError::Output)?));
    let manifest = golden.transpose()?.map(|dir| dir.with_file_name("verify").join("peers").join("Cargo.toml"));
    if let Some(manifest) = manifest.as_ref().filter(|manifest| !manifest.is_file()) {
        return Err(BenchError::NoPeers(manifest.clone()).into());
    }
    let mut table = create().map_err(failed)?;
    line(out, "case", ["ours, ns", "by hand", "ratio", "wanted"].map(String::from)).map_err(Failure::Output)?;
    for case in cases {
        let cost = case.measure(usize::from(args.rounds))?;
        let Cost { ours, limit } = cost;
        write(&mut table, &case.name, Some(ours), Some(limit), None).map_err(failed)?;
        let numbers = [ours, limit, cost.ratio()].map(|x| significant(x, 3));
        let [a, b, c] = numbers;
        line(out, &case.name, [a, b, c, format!("≤ {}", case.wanted)]).map_err(Failure::Output)?;
        out.flush().map_err(Failure::Output)?;
    }
    if let Some(manifest) = manifest {
        writeln!(out).and_then(|()| out.flush()).map_err(Failure::Output)?;
        for cell in bench::beside_peers(&manifest, args.rounds)? {
            let (limit, peer) = match (cell.side, cell.other) {
                (Other::ByHand, other) => (other.map(|(_, time)| time), None),
                (Other::Peer, other) => (None, other),
            };
            write(&mut table, &cell.case, cell.ours, limit, peer).map_err(failed)?;
        }
    }
    writeln!(out, "The table is in {}", path.display()).map_err(Failure::Output)?;
    Ok(Status::Ok)
}

/// A row of the table; a field is empty where there is no such time.
fn write(
    table: &mut csv::Writer<fs::File>,
    case: &str,
    ours: Option<f64>,
    limit: Option<f64>,
    peer: Option<(String, f64)>,
) -> Result<(), csv::Error> {
    let (name, peer) = peer.unzip();
    let ratio = |other: Option<f64>| Some(ours? / other?);
    let [ours_ns, limit_ns, peer_ns, ratio_limit, ratio_peer] =
        [ours, limit, peer, ratio(limit), ratio(peer)].map(|x| x.map(|x| x.to_string()).unwrap_or_default());
    let name = name.unwrap_or_default();
    table.write_record([case, &ours_ns, &limit_ns, &name, &peer_ns, &ratio_limit, &ratio_peer])?;
    Ok(table.flush()?)
}

fn line(out: &mut Output, name: &str, columns: [String; 4]) -> std::io::Result<()> {
    let columns = columns.map(|text| right(&text, NUMBER)).concat();
    writeln!(out, "{}{columns}", left(name, NAME))
}
