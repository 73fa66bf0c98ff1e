//! A solver in any language, run as a command.
//!
//! `COMMAND --problem NAME --h H --t-end T [--set k=v …]` writes comma-separated values with a header, `t` and then the
//! components, one row for each time that it reached, to standard output: what `verify solve --csv -` writes. Other columns and
//! lines that start with `#` are ignored.

mod process;
mod shown;

use std::process::Command;
use std::time::Duration;

pub use process::end_all;
use process::{Ended, MOST};
pub use shown::Shown;

use crate::measure::decimal::parsed;
use crate::measure::{fault, line_of};

/// A command and how long one run of it may take.
#[derive(Debug, Clone)]
pub struct Program {
    words: Vec<String>,
    limit: Duration,
}

/// What a run is asked for; each part becomes an argument.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Request {
    /// `--problem`.
    pub problem: Option<String>,
    /// `--h`.
    pub h: Option<f64>,
    /// `--t-end`.
    pub t_end: Option<f64>,
    /// `--set`, each.
    pub set: Vec<(String, String)>,
}

/// What a run wrote.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// Times, increasing.
    pub times: Vec<f64>,
    /// Values of the columns that were asked for, at each time.
    pub states: Vec<Vec<f64>>,
    /// How the values are printed.
    pub printed: Printed,
    /// How the times are.
    pub clock: Printed,
}

/// How many digits a program prints, by the longest of its numbers: a short one may be exact.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Printed {
    /// Decimals after the point.
    decimals: i32,
    /// Significant digits.
    significant: i32,
    /// Whether it looks like single precision.
    single: Single,
}

/// Whether numbers are all of single precision, as far as their digits tell.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Single {
    /// How improbable it is of other numbers, as −log₂ of the chance.
    bits: f64,
    /// Whether one is not.
    refuted: bool,
}

impl Single {
    /// Digits from which on numbers are told from others: single precision has seven, and prints with nine at most.
    const DIGITS: i32 = 9;
    /// Trailing zeros of a mantissa of 24 bits that a number has by construction, as 0, 1 or 0.375, and not by rounding.
    const EXACT: u32 = 12;
    /// What counts as certain.
    const CERTAIN: f64 = 32.0;

    /// Takes a number into account that is printed to half a unit of `half`.
    fn see(&mut self, value: f64, half: f64) {
        let near = value as f32;
        let half = half.max(f64::EPSILON * value.abs());
        self.refuted |= (f64::from(near) - value).abs() > half;
        if near.to_bits().trailing_zeros() < Self::EXACT {
            let spacing = f64::from(near.abs().next_up()) - f64::from(near.abs());
            self.bits -= (2.0 * half / spacing).min(1.0).log2();
        }
    }

    fn is_certain(self) -> bool {
        !self.refuted && self.bits >= Self::CERTAIN
    }

    fn with(self, other: Self) -> Self {
        Self { bits: self.bits + other.bits, refuted: self.refuted || other.refuted }
    }
}

impl Printed {
    /// Takes another number into account.
    fn see(&mut self, text: &str) {
        let (mantissa, exponent) = text.split_once(['e', 'E', 'd', 'D']).unwrap_or((text, "0"));
        let exponent: i32 = exponent.parse().unwrap_or(0);
        let decimals = mantissa.split_once('.').map_or(0, |(_, after)| after.len() as i32);
        let digits = mantissa.chars().filter(char::is_ascii_digit);
        let significant = digits.skip_while(|digit| *digit == '0').count() as i32;
        let decimals = decimals.saturating_sub(exponent);
        self.decimals = self.decimals.max(decimals);
        self.significant = self.significant.max(significant);
        if let Some(value) = parsed(text).filter(|_| significant >= Single::DIGITS) {
            self.single.see(value, 0.5 * 10_f64.powi(-decimals));
        }
    }

    /// Of the numbers of both.
    fn with(self, other: Self) -> Self {
        Self {
            decimals: self.decimals.max(other.decimals),
            significant: self.significant.max(other.significant),
            single: self.single.with(other.single),
        }
    }

    /// The distance from 1 to the next number that the program computes with.
    #[must_use]
    pub fn epsilon(self) -> f64 {
        if self.single.is_certain() { f64::from(f32::EPSILON) } else { f64::EPSILON }
    }

    /// Half a unit of the last digit that a number of this size is printed with, or computed with in single precision.
    #[must_use]
    pub fn resolution(self, size: f64) -> f64 {
        if self.significant == 0 || size == 0.0 {
            return 0.0;
        }
        let leading = size.abs().log10().floor() as i32;
        let printed = 0.5 * 10_f64.powi((-self.decimals).max(leading + 1 - self.significant));
        if self.single.is_certain() { printed.max(0.5 * self.epsilon() * size.abs()) } else { printed }
    }

    /// In words, where doubles have more digits.
    fn told(self) -> Option<String> {
        if self.single.is_certain() {
            return Some(
                "it looks like single precision: every number that it prints is one of 24 bits, about 7 digits, below which \
                 errors are rounding"
                    .into(),
            );
        }
        (1..15).contains(&self.significant).then(|| {
            format!(
                "it prints {} significant digits, below which errors are not seen; `%.17g` prints all of them",
                self.significant
            )
        })
    }
}

/// Why a command gave no answer.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ProgramError {
    /// The command line is empty, or a quotation in it does not close.
    #[error("`{0}` is no command: {1}")]
    Command(String, String),
    /// It did not start.
    #[error("`{command}` does not start: {reason}")]
    Start {
        /// The command.
        command: String,
        /// Why not.
        reason: String,
    },
    /// It ran for too long, and was ended.
    #[error("no end after {0} s")]
    TimedOut(u64),
    /// It wrote more than is read, and was ended.
    #[error("its output has more than {} MiB", .0 >> 20)]
    TooLong(u64),
    /// It ended with a failure.
    #[error("it failed ({status}){}", if .message.is_empty() { String::new() } else { format!(": {message}") })]
    Failed {
        /// Its exit status.
        status: String,
        /// The end of what it wrote to standard error.
        message: String,
    },
    /// It wrote something other than a table of numbers.
    #[error("line {line} of its output: {reason}")]
    Junk {
        /// The line, from 1.
        line: u64,
        /// What is wrong with it.
        reason: String,
    },
    /// A column is missing.
    #[error(
        "its output has no column `{name}`: the first line is `{found}`, where `{expected}` is expected, in any sequence"
    )]
    Column {
        /// The column.
        name: String,
        /// The first line that is no comment.
        found: String,
        /// What a header has.
        expected: String,
    },
    /// There is no row.
    #[error("its output has no rows")]
    Empty,
}

/// Characters of standard error that are shown, the last ones: where the reason stands.
const SHOWN: usize = 400;

impl ProgramError {
    /// Whether every run would say the same: there is no such command, or its output has another header.
    #[must_use]
    pub fn is_of_every_run(&self) -> bool {
        matches!(self, Self::Command(..) | Self::Start { .. } | Self::Column { .. })
    }
}

impl Program {
    /// A command line, split as a shell splits words, without a shell; each run is ended after `limit`.
    ///
    /// # Errors
    /// [`ProgramError::Command`] if there is no word, or a quotation does not close.
    pub fn new(command: &str, limit: Duration) -> Result<Self, ProgramError> {
        let fails = |reason: String| ProgramError::Command(command.to_owned(), reason);
        let words = shell_words::split(command).map_err(|error| fails(error.to_string()))?;
        if words.is_empty() {
            return Err(fails("it is empty".into()));
        }
        Ok(Self { words, limit })
    }

    /// Runs the command and reads the `columns` of its output.
    ///
    /// # Errors
    /// [`ProgramError`] if it does not start, does not end in time, fails, or writes no table of finite numbers at increasing
    /// times.
    pub fn run(&self, request: &Request, columns: &[String]) -> Result<Answer, ProgramError> {
        let mut command = Command::new(&self.words[0]);
        command.args(&self.words[1..]);
        let mut option = |name: &str, value: String| {
            command.args([name, &value]);
        };
        request.problem.iter().for_each(|name| option("--problem", name.clone()));
        request.h.iter().for_each(|h| option("--h", h.to_string()));
        request.t_end.iter().for_each(|t| option("--t-end", t.to_string()));
        request.set.iter().for_each(|(name, value)| option("--set", format!("{name}={value}")));
        let ended = process::run(&mut command, self.limit)
            .map_err(|error| ProgramError::Start { command: self.words[0].clone(), reason: error.to_string() })?;
        let (status, stdout, stderr) = match ended {
            Ended::TimedOut => return Err(ProgramError::TimedOut(self.limit.as_secs())),
            Ended::TooLong => return Err(ProgramError::TooLong(MOST)),
            Ended::Itself { status, stdout, stderr } => (status, stdout, stderr),
        };
        if !status.success() {
            let text = String::from_utf8_lossy(&stderr);
            let text = text.trim();
            let from = text.char_indices().rev().nth(SHOWN - 1).map_or(0, |(at, _)| at);
            return Err(ProgramError::Failed { status: status.to_string(), message: text[from..].to_owned() });
        }
        read(&stdout, columns)
    }
}

/// The start of a line.
fn excerpt(line: &str) -> String {
    const LONGEST: usize = 60;
    match line.char_indices().nth(LONGEST) {
        Some((at, _)) => format!("{}…", &line[..at]),
        None => line.to_owned(),
    }
}

/// The `columns` of a table, with its times.
fn read(text: &[u8], columns: &[String]) -> Result<Answer, ProgramError> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text);
    let junk = |error: csv::Error| {
        let (line, reason) = fault(text, &error);
        ProgramError::Junk { line, reason }
    };
    let header = reader.headers().map_err(junk)?.clone();
    if header.is_empty() {
        return Err(ProgramError::Empty);
    }
    let find = |name: &str| {
        let missing = || ProgramError::Column {
            name: name.into(),
            found: excerpt(&header.iter().collect::<Vec<_>>().join(",")),
            expected: excerpt(
                &std::iter::once("t").chain(columns.iter().map(String::as_str)).collect::<Vec<_>>().join(","),
            ),
        };
        header.iter().position(|column| column == name).ok_or_else(missing)
    };
    let time = find("t")?;
    let positions: Vec<usize> = columns.iter().map(|name| find(name)).collect::<Result<_, _>>()?;
    let (printed, clock) = (Printed::default(), Printed::default());
    let mut answer = Answer { times: Vec::new(), states: Vec::new(), printed, clock };
    for record in reader.records() {
        let record = record.map_err(junk)?;
        let line = || record.position().map_or(0, |at| line_of(text, at));
        let number = |column: usize| {
            let text = record.get(column).unwrap_or_default();
            let value = parsed(text).filter(|x| x.is_finite());
            value.ok_or_else(|| ProgramError::Junk { line: line(), reason: format!("`{text}` is not a finite number") })
        };
        let t = number(time)?;
        if answer.times.last().is_some_and(|last| t <= *last) {
            let reason = format!("the time {t} does not follow on the one before");
            return Err(ProgramError::Junk { line: line(), reason });
        }
        answer.states.push(positions.iter().map(|column| number(*column)).collect::<Result<_, _>>()?);
        positions.iter().filter_map(|column| record.get(*column)).for_each(|text| answer.printed.see(text));
        record.get(time).into_iter().for_each(|text| answer.clock.see(text));
        answer.times.push(t);
    }
    if answer.times.is_empty() { Err(ProgramError::Empty) } else { Ok(answer) }
}

/// Whether runs with different steps are one run, where they show more than its end.
#[must_use]
pub fn are_one_run<'a>(mut answers: impl Iterator<Item = &'a Answer>) -> bool {
    let Some(first) = answers.next().filter(|first| first.times.len() > 2) else { return false };
    let mut others = answers.peekable();
    others.peek().is_some() && others.all(|other| other.times == first.times && other.states == first.states)
}

/// What is said of them.
pub(crate) const ONE_RUN: &str = "every run gives the same values at the same times: the program does not use --h";

/// Lets all runs of a program have the digits of the longest number in any of them.
pub fn share_digits<'a>(answers: impl Iterator<Item = &'a mut Answer>) {
    let mut answers: Vec<&mut Answer> = answers.collect();
    let all =
        |digits: fn(&Answer) -> Printed| answers.iter().map(|a| digits(a)).reduce(Printed::with).unwrap_or_default();
    let (printed, clock) = (all(|a| a.printed), all(|a| a.clock));
    for answer in &mut answers {
        (answer.printed, answer.clock) = (printed, clock);
    }
}

impl Answer {
    /// The last time and the values there.
    #[must_use]
    pub fn end(&self) -> (f64, &[f64]) {
        // `read` gives at least one row.
        let last = self.times.len() - 1;
        (self.times[last], &self.states[last])
    }

    /// A note on how many digits are printed, where they are few.
    #[must_use]
    pub fn few_digits(&self) -> Option<String> {
        self.printed.told()
    }

    /// The part of the step `h` to which the last step was cut, where it was, and the others were not.
    #[must_use]
    pub fn clipped(&self, h: f64) -> Option<f64> {
        let steps: Vec<f64> = self.times.windows(2).map(|pair| (pair[1] - pair[0]) / h).collect();
        let (last, others) = steps.split_last()?;
        // A step is off by what its two times are rounded by.
        let rounding = 1e-6 + 2.0 * self.clock.resolution(self.end().0) / h;
        let is_whole = |step: &f64| (step - 1.0).abs() < rounding;
        (!others.is_empty() && others.iter().all(is_whole) && *last < 1.0 - rounding).then_some(*last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns() -> Vec<String> {
        vec!["v".into()]
    }

    #[test]
    fn tables_are_read_and_junk_is_named_with_its_line() {
        let answer = read(b"# by hand\nt,v,error\n0,1,\n0.5,2e-1,0\n0.7,0.1,0\n", &columns()).expect("a table");
        assert_eq!(answer.end(), (0.7, &[0.1][..]));
        assert!((answer.clipped(0.5).expect("cut") - 0.4).abs() < 1e-12);
        assert_eq!(answer.clipped(0.2), None);
        // Times with one decimal are off by 0.05, and so is no last step of 0.3 from one of 0.35.
        let rounded = read(b"t,v\n0,1\n0.3,1\n0.7,1\n1.0,1\n", &columns()).expect("a table");
        assert_eq!(rounded.clipped(0.35), None);
        let clipped = |text: &str, h: f64| read(text.as_bytes(), &columns()).expect("a table").clipped(h);
        assert_eq!(clipped("t,v\n0,1\n0.2,1\n0.4,1\n0.5,1\n", 0.2), None, "0.1 may be 0.2");
        assert_eq!(clipped("t,v\n0,1\n0.50,1\n1.00,1\n", 0.5), None, "the last is whole");
        let of_values = clipped("t,v\n0,1\n0.500000,1\n1.000000,1\n1.400000,1\n", 0.5);
        assert!(
            of_values.is_some_and(|part| (part - 0.8).abs() < 1e-5),
            "the digits of the values are none of the times: {of_values:?}"
        );
        assert_eq!(clipped("t,v\n0,1\n0.30,1\n", 0.5), None, "a step alone is as long as it is");
        for (text, line) in [
            ("t,v\n0,1\n1,NaN\n", 3),
            ("t,v\n0,1\n1,two\n", 3),
            ("t,v\n0,1\n0,1\n", 3),
            ("t,v\n0,1\n1,2,3\n", 3),
            ("t,v\n0,\n", 2),
        ] {
            let error = read(text.as_bytes(), &columns()).expect_err(text);
            assert!(matches!(&error, ProgramError::Junk { line: found, .. } if *found == line), "{text}: {error}");
        }
        assert!(matches!(read(b"t,u\n0,1\n", &columns()), Err(ProgramError::Column { name, .. }) if name == "v"));
        assert_eq!(read(b"t,v\n", &columns()), Err(ProgramError::Empty));
        assert_eq!(read(b"", &columns()), Err(ProgramError::Empty));
        assert!(read(&[0xff, b'\n', 0xfe], &columns()).is_err());
    }

    /// The floats beside 3.3 are 2⁻²² apart, and numbers of single precision stand on one of them.
    #[test]
    fn numbers_are_of_single_precision_as_far_as_their_digits_tell() {
        let seen = |value: f64, half: f64| {
            let mut single = Single::default();
            single.see(value, half);
            single
        };
        let (float, spacing) = (f64::from(3.3_f32), 2_f64.powi(-22));
        assert_eq!(seen(float, 1e-12), Single { bits: -(2e-12 / spacing).log2(), refuted: false });
        assert_eq!(
            seen(float, 0.0).bits,
            -(2.0 * f64::EPSILON * float / spacing).log2(),
            "a double has no more digits"
        );
        assert_eq!(seen(float, 1.0).bits, 0.0);
        // By half a unit of its last digit it may have been rounded.
        let half = 2_f64.powi(-30);
        assert!(!seen(float + half, half).refuted && seen(float + 2.0 * half, half).refuted);
        // 1 + 2⁻¹¹ ends in twelve zeros, 1 + 2⁻¹² in eleven.
        assert_eq!([-11, -12].map(|k| seen(1.0 + 2_f64.powi(k), 1e-12).bits > 0.0), [false, true]);
        let both = seen(float, 1e-12).with(seen(3.3, 1e-12));
        assert!(both.refuted && both.bits > seen(float, 1e-12).bits);
    }

    /// 1.01, 1.0025 and 1.00015625 by `%.15g`: a short number is exact beside a longer one of another run.
    #[test]
    fn runs_share_their_digits() {
        let mut runs = [&b"t,v\n1,1.01\n"[..], b"t,v\n1,1.0025\n", b"t,v\n1,1.00015625\n"]
            .map(|text| read(text, &columns()).expect("a table"));
        assert!(runs[0].printed.resolution(1.01) > 1e-3);
        share_digits(runs.iter_mut());
        for run in &runs {
            assert_eq!(run.printed.resolution(1.01), 0.5e-8);
        }
        let mut runs = [&b"t,v\n0.5,1\n"[..], b"t,v\n0.125,1\n"].map(|text| read(text, &columns()).expect("a table"));
        share_digits(runs.iter_mut());
        assert!(runs.iter().all(|run| run.clock.resolution(0.5) == 0.5e-3), "times have digits too");
    }

    #[test]
    fn runs_are_one_where_their_values_are() {
        let are_one = |texts: [&str; 2]| {
            let runs = texts.map(|text| read(text.as_bytes(), &columns()).expect("a table"));
            are_one_run(runs.iter())
        };
        let first = "t,v\n0,1\n1,2\n2,3\n";
        assert!(are_one([first, first]));
        assert!(!are_one([first, "t,v\n0,1\n1,2\n2,3.5\n"]), "other values");
        assert!(!are_one([first, "t,v\n0,1\n1,2\n2.5,3\n"]), "other times");
        assert!(!are_one(["t,v\n0,1\n1,2\n", "t,v\n0,1\n1,2\n"]), "two rows are a start and an end");
    }

    #[test]
    fn a_command_that_gives_no_answer_says_why() {
        let run = |command: &str, limit| {
            Program::new(command, Duration::from_millis(limit))
                .and_then(|program| program.run(&Request::default(), &columns()))
        };
        assert!(matches!(run("", 1000), Err(ProgramError::Command(..))));
        assert!(matches!(run("'open", 1000), Err(ProgramError::Command(..))));
        assert!(matches!(run("/no/such/program", 1000), Err(ProgramError::Start { .. })));
        assert!(matches!(run("sh -c 'sleep 20'", 100), Err(ProgramError::TimedOut(_))));
        let failed = run("sh -c 'echo the reason >&2; exit 3'", 5000);
        assert!(matches!(&failed, Err(ProgramError::Failed { message, .. }) if message == "the reason"), "{failed:?}");
        let answer = run("sh -c 'echo t,v; echo 1,2'", 5000).expect("a table");
        assert_eq!(answer.end(), (1.0, &[2.0][..]));
    }

    /// A table that is written in whole may be a part of another.
    #[test]
    #[cfg(unix)]
    fn a_program_that_is_killed_after_its_table_has_failed() {
        let run = |end: &str| {
            let command = format!("sh -c 'echo t,v; echo 1,2; {end}'");
            let program = Program::new(&command, Duration::from_secs(60)).expect("a command");
            program.run(&Request::default(), &columns())
        };
        assert!(run("exit 0").is_ok());
        for signal in ["KILL", "TERM"] {
            let ended = run(&format!("kill -{signal} $$"));
            assert!(matches!(ended, Err(ProgramError::Failed { .. })), "{ended:?}");
        }
    }

    /// However much a program says before it fails, the end is shown.
    #[test]
    #[cfg(unix)]
    fn the_reason_at_the_end_of_a_long_message_is_shown() {
        for lines in [100, 5000] {
            let command = format!("sh -c 'seq {lines} >&2; echo the reason >&2; exit 3'");
            let program = Program::new(&command, Duration::from_secs(10)).expect("a command");
            let error = program.run(&Request::default(), &columns()).expect_err("it fails");
            let ProgramError::Failed { message, .. } = error else { panic!("{error}") };
            assert!(message.ends_with("the reason") && message.chars().count() <= SHOWN, "{message}");
        }
    }

    /// Neither a child of the command survives its limit, nor one that keeps its output open delays it.
    #[test]
    #[cfg(unix)]
    fn what_a_command_has_started_ends_with_it() {
        let dir = tempfile::tempdir().expect("a directory");
        let path = |name: &str| dir.path().join(name).display().to_string();
        for (k, end) in ["wait", "echo t,v; echo 1,2"].into_iter().enumerate() {
            // Left alone, the child says so in the end.
            let (number, outlived) = (path(&format!("number-{k}")), path(&format!("outlived-{k}")));
            let script = format!("(sleep 20; echo > {outlived}) & echo $! > {number}; {end}");
            let program = Program::new(&format!("sh -c '{script}'"), Duration::from_millis(300)).expect("a command");
            let ended = program.run(&Request::default(), &columns());
            assert!(matches!(ended, Err(ProgramError::TimedOut(_))), "{ended:?}");
            let child = std::fs::read_to_string(&number).expect("the child's number");
            let is_alive = || {
                let state = Command::new("ps").args(["-o", "stat=", "-p", child.trim()]).output().expect("ps");
                // One that has ended and is not yet reaped by the system is `Z`.
                !String::from_utf8_lossy(&state.stdout).trim().trim_start_matches('Z').is_empty()
            };
            assert!((0..200).any(|_| {
                std::thread::sleep(Duration::from_millis(10));
                !is_alive()
            }));
            assert!(!std::path::Path::new(&outlived).exists(), "it ended by itself");
        }
    }

    #[test]
    #[cfg(unix)]
    fn an_output_without_end_is_cut_off() {
        // Whatever is to come after it.
        let endless = Program::new("sh -c 'yes; sleep 60'", Duration::from_secs(50)).expect("a command");
        assert_eq!(endless.run(&Request::default(), &columns()), Err(ProgramError::TooLong(MOST)));
    }

    #[test]
    fn requests_become_arguments() {
        let program = Program::new("sh -c 'echo t,v; echo 1,2; echo \"# $@\" >&2; exit 1' -", Duration::from_secs(5));
        let set = vec![("cells".to_owned(), "8".to_owned())];
        let request = Request { problem: Some("p".into()), h: Some(0.1), t_end: Some(2.0), set };
        let error = program.expect("a command").run(&request, &columns()).expect_err("it fails");
        let ProgramError::Failed { message, .. } = error else { panic!("{error}") };
        assert_eq!(message, "# --problem p --h 0.1 --t-end 2 --set cells=8");
    }

    /// Single precision printed to all digits, and to the nine that tell it apart; neither double precision nor few digits.
    #[test]
    fn single_precision_is_told_by_its_numbers() {
        let printed = |rows: &mut dyn Iterator<Item = String>| {
            let text =
                format!("t,v\n{}\n", rows.enumerate().map(|(k, v)| format!("{k},{v}")).collect::<Vec<_>>().join("\n"));
            read(text.as_bytes(), &columns()).expect("a table").printed
        };
        let numbers = || (0..40).map(|k| 1.0 / (1.0 + 9.0 * (-0.1 * f64::from(k)).exp()));
        let single = || numbers().map(|x| f64::from(x as f32));
        let looks = [
            printed(&mut single().map(|x| format!("{x}"))),
            printed(&mut single().map(|x| format!("{x:.16e}"))),
            printed(&mut single().map(|x| format!("{x:.8e}"))),
        ];
        for found in looks {
            assert!(found.epsilon() > 1e-7 && (2e-8..5e-8).contains(&found.resolution(0.5)), "{found:?}");
            assert!(found.told().is_some_and(|text| text.contains("single precision")));
        }
        // Values with short mantissas belong to either.
        let short = (1..40).map(|k| format!("{:.16e}", f64::from(k) / 64.0));
        for (found, digits) in [
            (printed(&mut numbers().map(|x| format!("{x:.16e}"))), 5e-17),
            (printed(&mut numbers().map(|x| format!("{x:.8e}"))), 5e-9),
            (printed(&mut single().map(|x| format!("{x:.5e}"))), 5e-6),
            (printed(&mut { short }), 5e-17),
        ] {
            assert!(found.epsilon() < 1e-15 && found.resolution(0.5) <= digits, "{found:?}");
        }
    }

    #[test]
    fn digits_are_those_of_the_longest_number() {
        let resolution = |text: &str| read(text.as_bytes(), &columns()).expect("a table").printed.resolution(0.7);
        // `%.6f`, `%g`, `%.17g` and the shortest that reads back, which may be short by chance.
        for (text, expected) in [
            ("t,v\n0,1.000000\n1,0.700000\n", 5e-7),
            ("t,v\n0,1\n1,0.333333\n", 5e-7),
            ("t,v\n0,1\n1,0.69999999999999996\n", 5e-18),
            ("t,v\n0,0.5\n1,0.3333333333333333\n", 5e-17),
            ("t,v\n0,1\n1,3.33333e-1\n", 5e-7),
        ] {
            let found = resolution(text);
            assert!((found / expected - 1.0).abs() < 1e-9, "{text}: {found:e}");
        }
        // An exponent of any size is read without a panic.
        assert_eq!(resolution("t,v\n0,1e-2147483648\n").to_bits() >> 63, 0);
        let answer = |text: &str| read(text.as_bytes(), &columns()).expect("a table");
        assert!(answer("t,v\n0,1.000000\n").few_digits().is_some());
        assert_eq!(answer("t,v\n0,0.3333333333333333\n").few_digits(), None);
    }

    /// Zeros before the first digit that counts are none.
    #[test]
    fn leading_zeros_are_no_significant_digits() {
        let told = |text: &str| read(format!("t,v\n0,{text}\n").as_bytes(), &columns()).expect("a table").few_digits();
        for (text, digits) in [("0.0012", 2), ("0.3333", 4), ("-00.120", 3), ("0.033333333333333", 14), ("1.002e-3", 4)]
        {
            let says = told(text).unwrap_or_default();
            assert!(says.starts_with(&format!("it prints {digits} significant digits")), "{text}: {says}");
        }
        assert_eq!(told("0.333333333333333"), None);
    }
}
