//! Random mutations of every kind of input, and random settings of every method on every problem: nothing panics, no run takes
//! more work than it is allowed, and what is not finite is an error. The corpora are in `tests/fuzz`; VERIFY_FUZZ has the number
//! of cases of each test.

use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use lsvi::adaptive::Tolerances;
use lsvi::{SolveError, StepError};
use verify::judge::file::MethodFile;
use verify::measure::norm::distance;
use verify::measure::refinement::Question;
use verify::measure::refinement::data::{Spacing, read};
use verify::problem::model::Model;
use verify::run::{RunError, run_while, step_from};
use verify::{golden, method, problem};

/// Uniform numbers by Knuth's MMIX generator, of which the upper bits are the good ones.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % n.max(1)
    }

    fn of<'a, T: ?Sized>(&mut self, all: &'a [Box<T>]) -> &'a T {
        &all[self.below(all.len())]
    }

    /// 10^−a to 10^b.
    fn size(&mut self, a: usize, b: usize) -> f64 {
        10.0_f64.powf(self.below(1000 * (a + b)) as f64 / 1000.0 - a as f64)
    }
}

/// What tends to be overlooked in numbers, lists and names.
const PIECES: [&str; 30] = [
    "0",
    "-1",
    "1e309",
    "-0.0",
    "1e-320",
    "NaN",
    "inf",
    "(",
    ")",
    "((",
    "[",
    "]",
    "{",
    "}",
    ",",
    ";",
    ":",
    "=",
    "\"",
    "'",
    "\n",
    "\r",
    "\t",
    "é",
    "\u{0}",
    "1/0",
    "99999999999999999999",
    "sqrt(-1)",
    "_",
    "..",
];

/// One to four random edits: bytes changed, pieces put in, parts removed, doubled or taken from another input.
fn mutated(random: &mut Random, corpus: &[Box<[u8]>]) -> Vec<u8> {
    let mut bytes = random.of(corpus).to_vec();
    for _ in 0..=random.below(4) {
        let (a, b) = (random.below(bytes.len() + 1), random.below(bytes.len() + 1));
        let (a, b) = (a.min(b), a.max(b).min(a.min(b) + 64));
        match random.below(6) {
            0 if a < bytes.len() => bytes[a] ^= 1 << random.below(8),
            1 => drop(bytes.splice(a..a, PIECES[random.below(PIECES.len())].bytes())),
            2 => drop(bytes.splice(a..b, PIECES[random.below(PIECES.len())].bytes())),
            3 => drop(bytes.drain(a..b)),
            4 => {
                let part = bytes[a..b].to_vec();
                drop(bytes.splice(b..b, part));
            }
            _ => {
                let other = random.of(corpus);
                let from = random.below(other.len() + 1);
                let part = other[from..other.len().min(from + 64)].to_vec();
                drop(bytes.splice(a..b, part));
            }
        }
    }
    bytes
}

/// Cases of a test: `default`, or VERIFY_FUZZ.
fn count(default: usize) -> usize {
    std::env::var("VERIFY_FUZZ").map_or(default, |text| text.parse().expect("VERIFY_FUZZ is a number of cases"))
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

/// The files of these folders, in the order of their names.
fn files(folders: &[&str]) -> Vec<Box<[u8]>> {
    let paths =
        folders.iter().flat_map(|folder| std::fs::read_dir(root().join(folder)).expect("a folder of the repository"));
    let mut paths: Vec<PathBuf> =
        paths.map(|entry| entry.expect("readable").path()).filter(|path| path.is_file()).collect();
    paths.sort();
    paths.iter().map(|path| std::fs::read(path).expect("readable").into()).collect()
}

fn lines(path: &str) -> Vec<Box<[u8]>> {
    let text = std::fs::read_to_string(root().join(path)).expect("a file of the repository");
    text.lines().map(|line| line.as_bytes().into()).collect()
}

/// Does `each` with as many mutations, and names the input on which it panics.
fn fuzz(seed: u64, cases: usize, corpus: &[Box<[u8]>], mut each: impl FnMut(&[u8])) {
    let mut random = Random(seed);
    // What is in the corpus goes first, as it is.
    let inputs = corpus.iter().map(|input| input.to_vec()).collect::<Vec<_>>().into_iter();
    for input in inputs.chain((0..cases).map(|_| mutated(&mut random, corpus))) {
        let survived = catch_unwind(AssertUnwindSafe(|| each(&input))).is_ok();
        assert!(survived, "a panic on\n{}", String::from_utf8_lossy(&input).escape_debug());
    }
}

#[test]
fn no_name_of_a_method_panics() {
    let mut corpus = lines("tests/fuzz/names/methods.txt");
    corpus.extend(method::ALL.iter().flat_map(|spec| spec.examples).map(|name| name.as_bytes().into()));
    let problem = problem::build("logistic", &[]).expect("registered");
    let mut parsed = 0;
    fuzz(1, count(3000), &corpus, |input| {
        let text = String::from_utf8_lossy(input);
        if let Ok(method) = method::parse(&text) {
            parsed += 1;
            assert_eq!(method::parse(&method.name()).map(|again| again.name()), Ok(method.name()), "{text}");
            // Windows of 10⁴ steps fill matrices of that order.
            if !text.starts_with("window") {
                drop(method.build(&*problem));
            }
        }
    });
    assert!(parsed > 50, "only {parsed} names were any");
}

#[test]
fn no_setting_of_a_problem_panics_and_none_starts_from_what_is_not_finite() {
    let mut corpus = lines("tests/fuzz/settings/problems.txt");
    for spec in problem::ALL {
        for parameter in spec.parameters {
            corpus.push(format!("{} {}={}", spec.name, parameter.name, parameter.default).into_bytes().into());
        }
    }
    let mut built = 0;
    fuzz(2, count(1000), &corpus, |input| {
        let text = String::from_utf8_lossy(input);
        // Grids of a million cells are legal, and take their time.
        let is_large = text
            .split(|c: char| !c.is_ascii_alphanumeric())
            .any(|word| word.len() > 2 && word.parse::<f64>().is_ok_and(|x| x > 100.0));
        if is_large {
            return;
        }
        if let Ok(problem) = problem::build_setting(&text) {
            built += 1;
            let bad = problem.initial().iter().any(|x| !x.is_finite());
            assert!(!bad, "{text} starts from what is not finite");
        }
    });
    assert!(built > 50, "only {built} settings were any");
}

#[test]
fn no_model_panics() {
    let path = super::scratch("fuzz.ds");
    let corpus = files(&["models", "tests/fuzz/models", "tests/twins"]);
    let mut compiled = 0;
    fuzz(3, count(60), &corpus, |input| {
        std::fs::write(&path, input).expect("writable");
        match Model::load(&path, &[], None) {
            Ok(_) => compiled += 1,
            Err(error) => drop(error.to_string()),
        }
    });
    assert!(compiled > 5, "only {compiled} models were any");
}

#[test]
fn no_table_of_values_panics_and_no_order_is_made_of_what_is_none() {
    let corpus = files(&["tests/fuzz/data"]);
    let mut judged = 0;
    fuzz(4, count(3000), &corpus, |input| {
        for spacing in [Spacing::Step("h".into()), Spacing::Cells { column: "cells".into(), dimension: 2 }] {
            for quantity in read(input, Some(&spacing), &[]).unwrap_or_default() {
                judged += 1;
                let judgement = quantity.judge(&Question::default());
                let numbers = [judgement.order, judgement.uncertainty, judgement.extrapolated, judgement.gci];
                assert!(numbers.iter().flatten().all(|x| x.is_finite()), "{numbers:?}");
            }
        }
    });
    assert!(judged > 100, "only {judged} quantities were any");
}

#[test]
fn no_golden_file_panics_and_what_is_read_is_written_the_same() {
    let corpus: Vec<Box<[u8]>> =
        files(&["../golden"]).into_iter().map(|file| file[..file.len().min(4000)].into()).collect();
    let mut rows = 0;
    fuzz(5, count(1000), &corpus, |input| {
        let (recorded, _) = golden::parse(input);
        rows += recorded.len();
        let text = golden::render(&recorded.iter().map(|one| one.row.clone()).collect::<Vec<_>>());
        let (again, faults) = golden::parse(text.as_bytes());
        assert!(faults.is_empty() && again.len() == recorded.len(), "{faults:?}");
    });
    assert!(rows > 1000, "only {rows} rows were any");
}

#[test]
fn no_file_of_a_method_panics() {
    let corpus = files(&["methods", "methods/misprints", "tests/fuzz/methods"]);
    let mut parsed = 0;
    fuzz(6, count(300), &corpus, |input| {
        match MethodFile::parse("fuzz.toml", "fuzz", &String::from_utf8_lossy(input)) {
            Ok(_) => parsed += 1,
            Err(error) => drop(error.to_string()),
        }
    });
    assert!(parsed > 40, "only {parsed} files were any");
}

/// Steps, work and what is returned of random pairs, step sizes and tolerances.
#[test]
fn no_run_panics_works_without_end_or_returns_what_is_not_finite() {
    // Of a step: pieces of a branch and iterations of each, `newton.rs` says, with one evaluation or a few each.
    const MOST_OF_A_STEP: u64 = 500 * 60 * 10;
    const STEPS: usize = 5;
    let methods: Vec<_> = method::ALL
        .iter()
        .flat_map(|spec| spec.examples)
        .map(|name| method::parse(name).expect("registered"))
        .collect();
    let mut random = Random(7);
    let (mut finished, mut refused) = (0, 0);
    for _ in 0..count(150) {
        let spec = &problem::ALL[random.below(problem::ALL.len())];
        let problem = problem::small(spec.name).expect("registered");
        let mut method = random.of(&methods);
        let tolerances =
            Tolerances::new(random.size(30, 3), if random.below(5) == 0 { 0.0 } else { random.size(30, 3) });
        let tuned = tolerances.ok().and_then(|tolerances| method.with_tolerances(tolerances));
        method = tuned.as_deref().unwrap_or(method);
        let h = random.size(6, 4);
        let what = format!("{} on {} with h = {h:?}", method.name(), spec.name);
        let (mut steps, mut all_finite) = (0, true);
        let run = catch_unwind(AssertUnwindSafe(|| {
            run_while(&*problem, method, h, h * STEPS as f64, |state| {
                steps += 1;
                all_finite &= state.q.iter().chain(&state.p).all(|x| x.is_finite());
                // An adaptive method may need more.
                if steps > 10 * STEPS { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            })
        }));
        let Ok(run) = run else { panic!("{what} panics") };
        assert!(all_finite, "{what} shows a state that is not finite");
        match run {
            Ok(run) => {
                finished += 1;
                let most = MOST_OF_A_STEP * steps as u64;
                assert!(run.work.residuals <= most, "{what} took {} evaluations", run.work.residuals);
            }
            Err(RunError::NonFinite(_)) => refused += 1,
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().is_empty(), "{what}");
            }
        }
    }
    println!("{finished} finished, {refused} refused");
    assert!(finished > 0 && refused > 0);
}

/// The end of a step moves with its length as far as its branch goes: it does not leap, and no step is longer than one of which the branch was found
/// to end.
#[test]
fn no_step_of_a_motion_ends_on_another_branch_than_shorter_ones_lead_to() {
    const PARTS: u32 = 24;
    const HALVINGS: u32 = 20;
    let methods: Vec<_> = method::ALL
        .iter()
        .flat_map(|spec| spec.examples)
        .map(|name| method::parse(name).expect("registered"))
        .filter(|method| !method.traits().is_adaptive)
        .collect();
    let motions: Vec<_> = problem::ALL
        .iter()
        .map(|spec| (spec.name, problem::small(spec.name).expect("registered")))
        .filter(|(_, problem)| problem.mechanics().is_some())
        .collect();
    let mut random = Random(8);
    let (mut followed, mut folds) = (0, 0);
    for _ in 0..count(60) {
        let ((name, problem), method) = (&motions[random.below(motions.len())], random.of(&methods));
        let longest = random.size(2, 1);
        let what = format!("{} on {name}", method.name());
        let step = |h: f64| step_from(&**problem, problem.initial(), method, h);
        let (mut last, mut fold) = ((0.0, problem.initial()), None);
        for k in 1..=PARTS {
            let h = longest * f64::from(k) / f64::from(PARTS);
            let end = match step(h) {
                Ok(end) => end,
                Err(RunError::Step(StepError::Solve { source: SolveError::BranchLost { reached }, .. })) => {
                    fold = fold.or(Some(reached));
                    folds += 1;
                    continue;
                }
                Err(_) => continue,
            };
            assert!(fold.is_none(), "{what}: a step of h = {h} ends at {end:?}, and the branch at h = {fold:?}");
            let mut ends = [last, (h, end.clone())];
            let whole = distance(&ends[0].1, &end);
            let closer = || {
                let middle = 0.5 * (ends[0].0 + ends[1].0);
                let v = step(middle).ok()?;
                let is_later = distance(&ends[0].1, &v) >= distance(&v, &ends[1].1);
                ends[usize::from(is_later)] = (middle, v);
                Some(())
            };
            // A step that fails in between tells nothing; what moves evenly is at rest in a millionth of the way, but for Newton's tolerance.
            if std::iter::repeat_with(closer).take(HALVINGS as usize).all(|closer| closer.is_some()) {
                let [(before, a), (behind, b)] = &ends;
                let is_even = distance(a, b) <= 1e-3 * whole + 1e-9;
                assert!(
                    is_even,
                    "{what}: from h = {before:?} to {behind:?} the end of a step leaps from {a:?} to {b:?}"
                );
                followed += 1;
            }
            last = (h, end);
        }
    }
    assert!(folds > 0 && followed > 0, "{folds} folds, {followed} pieces");
}
