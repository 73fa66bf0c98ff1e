//! Which mutants the tests notice.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::io::Write;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use crate::build::{Built, Program};
use crate::list::{Mutant, known};
use crate::{Failure, Options, read};

/// A test, the places that it comes by, and how long it takes of the processor's time, so that what else runs meanwhile does not count.
#[derive(Debug)]
struct Test {
    program: Program,
    name: String,
    covered: HashSet<u32>,
    time: Duration,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Outcome {
    Caught,
    TimedOut,
    Missed,
    /// Missed or not covered, and known to be so for a reason.
    Known,
    /// Tests of the time allowed have not noticed it; others remain.
    Unfinished,
    NotCovered,
    NotPlaced,
    Unviable,
}

/// How many mutants of each file each test has noticed.
///
/// What notices one change of a file often notices the next, so that such tests come first.
type Noticed = HashMap<String, HashMap<usize, u32>>;

/// What the outcomes of mutants go by.
struct Session<'a> {
    tests: &'a [Test],
    built: &'a Built,
    limit: Duration,
    noticed: Mutex<Noticed>,
}

/// The first tests of a mutant run together for so long, the next ones for twice as long, and so on.
const FIRST_BATCH: Duration = Duration::from_millis(50);
/// Beyond so many times what they take unchanged, and two seconds, of the processor's time, tests are endless.
const SLOWER: u32 = 10;
const START: Duration = Duration::from_secs(2);
/// Tests that wait for ever use no processor: so many times longer by the clock.
const WAITING: u32 = 20;
/// Kilobytes.
const MEMORY: &str = "8000000";
const RUN: &str = "ulimit -v $0; ulimit -t $1; shift; exec \"$@\"";
const RUN_AND_TIME: &str = "ulimit -v $0; ulimit -t $1; shift; \"$@\" >/dev/null; status=$?; times; exit $status";
/// By which `times` counts.
const TICK: Duration = Duration::from_millis(10);
/// What ends a process that has used its time.
const SIGXCPU: i32 = 24;
const SIGKILL: i32 = 9;

/// Runs the tests on each mutant and writes `outcomes.csv`; false if any is missed.
pub fn run(built: &Built, mutants: &[&Mutant], options: &Options, out: &Path) -> Result<bool, Failure> {
    let mut named = Vec::new();
    for program in &built.tests {
        let list =
            read(Command::new(&program.file).args(["--list", "--format", "terse"]).current_dir(&program.directory))?;
        let names = list.lines().filter_map(|line| line.strip_suffix(": test"));
        named.extend(names.map(|name| (program, name.to_owned())));
    }
    let tests = Mutex::new(Vec::new());
    in_parallel(options.jobs, &named, |job, (program, name)| {
        let test = measure(program, name, &out.join(format!("cover-{job}")))?;
        tests.lock().unwrap().extend(test);
        Ok(())
    })?;
    let tests = tests.into_inner().unwrap();
    let total: Duration = tests.iter().map(|test| test.time).sum();
    eprintln!("schemata: {} tests, {:.1} s", tests.len(), total.as_secs_f64());
    let file = Mutex::new(fs::File::create(out.join("outcomes.csv"))?);
    let known = known(&Path::new("scripts/schemata/known").join(options.name()).with_extension("txt"))?;
    let session = Session { tests: &tests, built, limit: options.limit, noticed: Mutex::default() };
    let counts = Mutex::new(HashMap::<Outcome, usize>::new());
    in_parallel(options.jobs, mutants, |job, mutant| {
        let mut outcome = session.outcome(mutant, &out.join(format!("said-{job}")))?;
        if matches!(outcome, Outcome::Missed | Outcome::NotCovered) && mutant.is_among(&known) {
            outcome = Outcome::Known;
        }
        writeln!(file.lock().unwrap(), "{outcome:?},{}", mutant.name)?;
        let mut counts = counts.lock().unwrap();
        *counts.entry(outcome).or_default() += 1;
        let done: usize = counts.values().sum();
        if done.is_multiple_of(100) || done == mutants.len() {
            eprintln!("schemata: {done} of {}: {counts:?}", mutants.len());
        }
        Ok(())
    })?;
    let counts = counts.into_inner().unwrap();
    Ok([Outcome::Missed, Outcome::NotCovered].iter().all(|outcome| !counts.contains_key(outcome)))
}

/// Calls `work` with each item, and with the number of the job, of which each works at one item at a time.
fn in_parallel<T: Sync>(
    jobs: usize,
    items: &[T],
    work: impl Fn(usize, &T) -> Result<(), Failure> + Sync,
) -> Result<(), Failure> {
    let next = AtomicUsize::new(0);
    let one = |job| {
        while let Some(item) = items.get(next.fetch_add(1, Ordering::Relaxed)) {
            work(job, item)?;
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let (one, jobs) = (&one, 0..jobs);
        let jobs: Vec<_> = jobs.map(|job| scope.spawn(move || one(job))).collect();
        jobs.into_iter().try_for_each(|job| job.join().unwrap())
    })
}

/// What a test takes; `None` if it fails without a mutant too.
fn measure(program: &Program, name: &str, cover: &Path) -> Result<Option<Test>, Failure> {
    if cover.exists() {
        fs::remove_file(cover)?;
    }
    // Covering writes and allocates, which tests of allocations notice.
    command(RUN, program, &[name], Duration::MAX).env("SCHEMATA_COVER", cover).status()?;
    let start = Instant::now();
    let output = command(RUN_AND_TIME, program, &[name], Duration::MAX).stdout(Stdio::piped()).output()?;
    if !output.status.success() {
        eprintln!("schemata: left out, as it fails without a mutant: {name}");
        return Ok(None);
    }
    let time = start.elapsed().min(processor_time(&String::from_utf8(output.stdout)?)? + TICK);
    let covered = fs::read(cover).unwrap_or_default();
    let covered = covered.chunks_exact(4).map(|id| u32::from_le_bytes(id.try_into().unwrap())).collect();
    Ok(Some(Test { program: program.clone(), name: name.into(), covered, time }))
}

/// What `times` prints of the programs that a shell has run, in its second line, as in 0m1.250000s 0m0.010000s: the user's time and the system's.
fn processor_time(times: &str) -> Result<Duration, Failure> {
    let mut time = Duration::ZERO;
    for part in times.lines().nth(1).unwrap_or_default().split_whitespace() {
        let (minutes, seconds) =
            part.trim_end_matches('s').split_once('m').ok_or_else(|| format!("not a time: {part}"))?;
        time += Duration::try_from_secs_f64(60.0 * minutes.parse::<f64>()? + seconds.parse::<f64>()?)?;
    }
    Ok(time)
}

/// A command by a script of the shell, which may take `limit` of the processor's time, in whole seconds.
fn command(script: &str, program: &Program, names: &[&str], limit: Duration) -> Command {
    let seconds = if limit == Duration::MAX { "unlimited".into() } else { (limit.as_secs() + 1).to_string() };
    let mut command = Command::new("sh");
    command.args(["-c", script, MEMORY, &seconds]).arg(&program.file).arg("--exact").args(names);
    command.arg("--test-threads=1").current_dir(&program.directory).env("CARGO_MANIFEST_DIR", &program.directory);
    // Random tests do the same each time, and leave nothing.
    command.env("PROPTEST_RNG_SEED", "1").env("PROPTEST_DISABLE_FAILURE_PERSISTENCE", "1");
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command
}

impl Session<'_> {
    /// The tests that come by a place of a file, by their time for each mutant of the file that they have noticed.
    fn in_order(&self, place: u32, file: &str) -> Vec<usize> {
        let covering = (0..self.tests.len()).filter(|&i| self.tests[i].covered.contains(&place));
        let noticed = self.noticed.lock().unwrap();
        let noticed = |i| noticed.get(file).and_then(|of_file| of_file.get(&i)).copied().unwrap_or_default();
        let mut order: Vec<_> = covering.collect();
        order.sort_by_cached_key(|&i| self.tests[i].time / (1 + noticed(i)));
        order
    }

    /// Keeps which of the tests failed, by what they have said.
    fn keep(&self, file: &str, tests: &[usize], said: &Path) -> Result<(), Failure> {
        let said = fs::read(said)?;
        let said = String::from_utf8_lossy(&said);
        let failed: HashSet<_> =
            said.lines().filter_map(|line| line.strip_prefix("test ")?.strip_suffix(" ... FAILED")).collect();
        let mut noticed = self.noticed.lock().unwrap();
        let of_file = noticed.entry(file.to_owned()).or_default();
        for &i in tests.iter().filter(|&&i| failed.contains(self.tests[i].name.as_str())) {
            *of_file.entry(i).or_default() += 1;
        }
        Ok(())
    }

    /// `said` is a file for what tests print.
    fn outcome(&self, mutant: &Mutant, said: &Path) -> Result<Outcome, Failure> {
        if self.built.unviable.contains(&mutant.id) {
            return Ok(Outcome::Unviable);
        }
        let Some(&place) = self.built.places.get(&mutant.id) else { return Ok(Outcome::NotPlaced) };
        let order = self.in_order(place, &mutant.file);
        let mut left = order.as_slice();
        if left.is_empty() {
            return Ok(Outcome::NotCovered);
        }
        let (mut batch, mut spent) = (FIRST_BATCH, Duration::ZERO);
        while let Some(&first) = left.first() {
            let first = &self.tests[first];
            // Tests of one program, and one at least.
            let mut time = first.time;
            let fits = |&&i: &&usize| {
                let test = &self.tests[i];
                time += test.time;
                test.program == first.program && time <= batch.saturating_add(first.time)
            };
            let now = 1 + left[1..].iter().take_while(fits).count();
            let (now, after) = left.split_at(now);
            let expected = now.iter().map(|&i| self.tests[i].time).sum();
            if spent + expected > self.limit {
                return Ok(Outcome::Unfinished);
            }
            let names: Vec<_> = now.iter().map(|&i| self.tests[i].name.as_str()).collect();
            let endless = SLOWER * expected + START;
            let mut command = command(RUN, &first.program, &names, endless);
            command.env("SCHEMATA", mutant.id.to_string()).stdout(fs::File::create(said)?);
            match end(&mut command, WAITING * endless)? {
                None => return Ok(Outcome::TimedOut),
                Some(status) if [SIGXCPU, SIGKILL].map(Some).contains(&status.signal()) => {
                    return Ok(Outcome::TimedOut);
                }
                Some(status) if !status.success() => {
                    self.keep(&mutant.file, now, said)?;
                    return Ok(Outcome::Caught);
                }
                Some(_) => {}
            }
            (left, spent, batch) = (after, spent + expected, batch.saturating_mul(2));
        }
        Ok(Outcome::Missed)
    }
}

/// How a command ends; `None` where it has not within `limit` by the clock.
fn end(command: &mut Command, limit: Duration) -> Result<Option<ExitStatus>, Failure> {
    let mut child = command.spawn()?;
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if start.elapsed() > limit {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}
