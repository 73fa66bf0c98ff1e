//! Tests every mutant of a package, or of several, with one build: mutant schemata.
//!
//! cargo-mutants builds a package again for each of its mutants, which for some thousand of them takes days. Here its list of
//! mutants is compiled into one instrumented copy of the packages, and a variable of the environment chooses the one that is
//! active; of the packages' tests each mutant gets those that come by its place, until one fails: cheapest first,
//! and before them those that have noticed most of the file's.
//!
//!     schemata PACKAGE[,PACKAGE]... [--file GLOB]... [--seconds S] [--only FILE] [--jobs N]
//!
//! Run it in the root of the workspace. The copy, and outcomes.csv with what became of each mutant, stand in
//! target/schemata/PACKAGE, by the first of them. What the compiler computes (constants, lengths of arrays) has no environment: such mutants are left
//! to cargo-mutants, as `not placed`. Those that are missed for a reason are listed with it in scripts/schemata/known.

mod build;
mod instrument;
mod list;
mod run;

use std::hash::{BuildHasher, BuildHasherDefault, DefaultHasher};
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::time::Duration;

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// What a command prints, which must succeed; its complaints go where this program's do.
fn read(command: &mut Command) -> Result<String, Failure> {
    let output = command.stderr(Stdio::inherit()).output()?;
    if !output.status.success() {
        return Err(format!("{command:?}: {}", output.status).into());
    }
    Ok(String::from_utf8(output.stdout)?)
}

#[derive(Debug)]
struct Options {
    /// Whose mutants, and whose tests.
    packages: Vec<String>,
    /// Which of its source files; all, if none is named.
    files: Vec<String>,
    /// Seconds of tests for a mutant, at most.
    limit: Duration,
    only: Option<String>,
    jobs: usize,
}

fn options() -> Result<Options, Failure> {
    let mut arguments = std::env::args().skip(1);
    let usage = "usage: schemata PACKAGE[,PACKAGE]... [--file GLOB]... [--seconds S] [--only FILE] [--jobs N]";
    let packages = arguments.next().ok_or(usage)?.split(',').map(str::to_owned).collect();
    let jobs = std::thread::available_parallelism()?.get();
    let mut options = Options { packages, files: Vec::new(), limit: Duration::MAX, only: None, jobs };
    while let Some(option) = arguments.next() {
        let value = arguments.next().ok_or_else(|| format!("{option} needs a value"))?;
        match option.as_str() {
            "--file" => options.files.push(value),
            "--seconds" => options.limit = Duration::try_from_secs_f64(value.parse()?)?,
            "--only" => options.only = Some(std::fs::read_to_string(value)?),
            "--jobs" => options.jobs = value.parse()?,
            _ => return Err(format!("unknown option {option}").into()),
        }
    }
    Ok(options)
}

impl Options {
    /// What the copy and the list of known mutants are called by.
    fn name(&self) -> &str {
        self.packages.first().map_or("", |name| name)
    }
}

fn work() -> Result<bool, Failure> {
    let options = options()?;
    let mutants = list::mutants(&options.packages, &options.files)?;
    let target = std::env::current_dir()?.join("target/schemata");
    // One tree for each package, so that what is built of one may run while another is built.
    let out = target.join(options.name());
    let built = build::build(&options.packages, &mutants, &out.join("tree"), &target.join("target"))?;
    let is_wanted = |name: &str| options.only.as_ref().is_none_or(|only| only.lines().any(|line| line.ends_with(name)));
    let mut wanted: Vec<_> = mutants.iter().filter(|mutant| is_wanted(&mutant.name)).collect();
    // In no order, so that the outcomes of a run that is broken off are a fair sample.
    wanted.sort_by_cached_key(|mutant| BuildHasherDefault::<DefaultHasher>::default().hash_one(&mutant.name));
    run::run(&built, &wanted, &options, Path::new(&out))
}

fn main() -> ExitCode {
    match work() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(2),
        Err(failure) => {
            eprintln!("schemata: {failure}");
            ExitCode::FAILURE
        }
    }
}
