//! `judge`: a method from a file, and what is true of it.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::ValueEnum;
use serde::Serialize;
use verify::evidence::{Check, Outcome, Requirement};
use verify::judge::file::{MethodFile, Shipped};
use verify::judge::{Effort, Judgement, Kind, Verdict};
use verify::order::{Ladder, depends_on_time, measure_program};
use verify::problem::Problem;
use verify::problem::model::Model;
use verify::program::Request;
use verify::report::{self, Chapter, Run};

use super::Status;
use super::args::{self, assignment, positive};
use super::error::Failure;
use super::layout::paragraph;
use super::output::Output;

/// Judge a method that comes as a file: claims, misprints, stability.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A file is TOML with the keys name, kind, order (claimed, optional), claims (a
list of texts, optional), digits, source, note, and those of its kind:
  runge-kutta             a (rows; lower triangles will do), b, and c, b_hat,
                          embedded_order where there are any
  partitioned-runge-kutta a, b for q; a_hat, b_hat for p; c; systems =
                          \"separable\" where it is for q' = f(p), p' = g(q)
  nystrom                 a, b_bar for q; b for q'; c
  multistep               rho, sigma, the oldest step first; start, the name of
                          a Runge-Kutta file (radau-iia3)
  closure                 alpha, beta: numbers, or texts in z = h rate; rate
  path-fitted             nodes between 0 and 1
  galerkin                degree, and nodes and weights of a quadrature
Coefficients are numbers or texts such as \"1/2 - sqrt(3)/6\", with + - * / ^
and sqrt, cbrt, sin, cos, tan, exp, pi; 7√6 and 2(1 + √3) are products. A plain
table is read as a Runge-Kutta method too: a line of c, a line of b, then the
rows of A below the diagonal; or as it is typeset, rows of c_i and of A and
below them the weights, with spaces, tabs, commas, semicolons or a bar between,
or in LaTeX or Markdown; or lists headed k c[k], k b[k], k j A[k,j]. `order 4`
and `digits 10` may stand above it.

Decimals with six places or more are taken as rounded: conditions then hold or
fail to the digits printed. Shorter ones are exact, unless digits = N says that
N places are meant. Fractions p/q with q above 10^10 stand for numbers within
1/q^2 of them. A defect, a drift or an order of a run that their digits leave
open is not settled, and so is a drift too slow to be seen, which leaves status
0. Where c of a Runge–Kutta method, or of a pair, is not the sums of the rows,
and no change of one coefficient makes it so, the order claimed is that on v' =
f(t, v) with this c. Orders that do not settle are looked at in finer steps and
over longer times.

Claims: order 4, embedded order 3, stage order 2, explicit, implicit, diagonally
implicit, A-stable, A(88)-stable, L-stable, algebraically stable, stiffly
accurate, symplectic, symmetric, zero-stable, dispersion order 4, dissipation
order 5, stable on the imaginary axis to 2.8; each with `not` before it denies.
What a kind is not judged by is inconclusive.

Order conditions are those of the rooted trees, up to order 10; of coloured ones
for methods with two parts. Where conditions fail, every change of a single
coefficient is tried; then of one number at several places, as a weight that the
last row of A repeats; then every exchange of two entries or rows, up to 16
stages. Those that mend everything are proposed. b and b_hat that look
interchanged are told, and an order on separable systems alone. The orders of
live runs are judged as by `order`.

What THEORY tells, of a method of order p:
  error constant          of a multistep method C_(p+1), where each C_k is
                          divided by sigma(1), the sum of sigma; in CLAIMS too
  principal error         root of the sum of squares of the residuals of order
                          p + 1, each divided by the symmetry of its tree
  dispersion, dissipation arg R(iy) - y and |R(iy)| - 1: constant y^(order + 1);
                          a dissipation below 0 damps, one above 0 amplifies
  axes                    the interval from 0 on which |R| <= 1, with what it is
                          uncertain by where coefficients have few digits
A claim of a bound, as A(86.0)-stable, is taken to half a unit of its last
digit.

A program is what `order --program` takes, and its header is t and the names of
the components, t,v on logistic (`verify list problems` shows them all); it is
run on logistic, damped-pendulum, van-der-pol and, for wrong stage times,
prothero-robinson with --set lambda=2, unless --problem names others, or --model
a system of your own.

Examples:
  verify judge rk4
  verify judge mine.toml --no-runs
  verify judge mine.toml --format json
  verify judge mine.toml --out target/mine
  verify order --problem van-der-pol --method mine.toml
  verify judge --program 'python3 mine.py' --expect 4

Exit status: 0 all is confirmed, 1 something is refuted, 2 bad input, which a
program is that does not start, 3 something is inconclusive.")]
pub(super) struct Args {
    /// The file, or a name that `verify list method-files` shows: ./NAME is a
    /// file of such a name
    #[arg(value_name = "METHOD.toml", required_unless_present = "program")]
    file: Option<PathBuf>,

    /// A program instead, judged by its runs
    #[arg(long, value_name = "COMMAND", conflicts_with_all = ["file", "out", "no_runs"], requires = "expect")]
    program: Option<String>,

    /// The order that the program should have
    #[arg(long, value_name = "P", requires = "program", value_parser = positive)]
    expect: Option<f64>,

    /// A problem that the program knows, with its parameters: 'NAME x=1'; repeatable
    #[arg(long, value_name = "NAME", requires = "program", default_values = PROGRAM_PROBLEMS, hide_default_value = true)]
    problem: Vec<String>,

    /// A model in DiffSL that the program knows by the name of its file, instead
    #[arg(long, value_name = "FILE", requires = "program", conflicts_with = "problem")]
    model: Option<PathBuf>,

    /// Set an input of the model; repeatable
    #[arg(long, value_name = "NAME=VALUE", requires = "model", value_parser = args::assignment, allow_hyphen_values = true)]
    set: Vec<(String, String)>,

    /// End time of the model
    #[arg(long, value_name = "T", requires = "model", allow_hyphen_values = true)]
    t_end: Option<f64>,

    /// Coarsest step of the ladder
    #[arg(long, value_name = "H", requires = "program", value_parser = positive)]
    coarsest: Option<f64>,

    /// Number of steps of the ladder
    #[arg(long, value_name = "N", requires = "program", value_parser = clap::value_parser!(u16).range(2..=60))]
    points: Option<u16>,

    /// End a run after so many seconds
    #[arg(long, value_name = "SECONDS", requires = "program", default_value_t = 60)]
    time_limit: u64,

    /// Write a report with figures to this directory too
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Judge by the coefficients alone
    #[arg(long)]
    no_runs: bool,

    /// Form: text, markdown or json
    #[arg(long, value_enum, hide_possible_values = true, default_value_t = Format::Text)]
    format: Format,
}

const OPEN_BY_RUNS: &str =
    "Runs alone leave something open; `--no-runs` judges by the coefficients, with an exit status of their own.";

const UNSEEN: &str = "\
note: none of these equations depends on time, so that wrong stage times are
      not seen; `--problem 'prothero-robinson lambda=2'` shows them, or
      `--model` with an equation that does";

/// Nonlinear, oscillating, with a solution that leaves every scale behind, and with time in the equation: wrong stage times show
/// nowhere else.
const PROGRAM_PROBLEMS: [&str; 4] = ["logistic", "damped-pendulum", "van-der-pol", "prothero-robinson lambda=2"];

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    Text,
    Markdown,
    Json,
}

pub(super) fn run(args: &Args, out: &mut Output) -> Result<Status, Failure> {
    if let (Some(command), Some(order)) = (&args.program, args.expect) {
        return run_program(args, command, order, out);
    }
    let path = args.file.clone().unwrap_or_default();
    // A program that is built beside may have the name of its method.
    let shipped = path.to_str().map(Shipped::by_name);
    let file = match shipped {
        Some(Ok(shipped)) => shipped.read()?,
        Some(Err(unknown)) if path.extension().is_none() && !path.exists() => return Err(unknown.into()),
        _ => MethodFile::load(&path)?,
    };
    let judgement = Judgement::new(file, if args.no_runs { Effort::Theory } else { Effort::Runs });
    match args.format {
        Format::Text => write_text(&judgement, out),
        Format::Markdown => write_markdown(&judgement, out),
        Format::Json => write_json(&judgement, out),
    }
    .map_err(Failure::Output)?;
    if let Some(directory) = &args.out {
        let chapter = Chapter {
            id: "judge".into(),
            title: judgement.file.name.clone(),
            question: "What is true of this method?".into(),
            source: judgement.file.source.clone().unwrap_or_default(),
            evidence: judgement.evidence(),
            ..Chapter::default()
        };
        report::write(&Run::new(vec![chapter], Vec::new()), directory)?;
    }
    Ok(status(judgement.outcome()))
}

fn status(outcome: Outcome) -> Status {
    match outcome {
        Outcome::Pass | Outcome::NotSettled | Outcome::NotRun => Status::Ok,
        Outcome::Fail => Status::Failed,
        Outcome::Inconclusive => Status::Inconclusive,
    }
}

/// A problem that a program is asked for: its name, the parameters that are set, and itself.
type Asked = (String, Vec<(String, String)>, Box<dyn Problem>);

/// The orders of a program on several problems, with what its times and its start show.
fn run_program(options: &Args, command: &str, order: f64, out: &mut Output) -> Result<Status, Failure> {
    let program = args::program(command, options.time_limit)?;
    let ladder = Ladder {
        expected: Some(order),
        coarsest: options.coarsest,
        points: options.points.map(usize::from),
        ..Ladder::default()
    };
    let mut verdicts = Vec::new();
    let problems: Vec<Asked> = match &options.model {
        Some(path) => {
            let model = Model::load(path, &options.set, options.t_end)?;
            vec![(model.name().to_owned(), options.set.clone(), Box::new(model))]
        }
        None => {
            let built = |text: &String| {
                let mut words = text.split_whitespace();
                let name = words.next().unwrap_or_default().to_owned();
                let set = words.map(assignment).collect::<Result<Vec<_>, _>>().map_err(|_| Failure::Value {
                    option: "--problem",
                    value: text.clone(),
                    wanted: "a name and parameters, NAME x=1,",
                })?;
                let problem = verify::problem::build(&name, &set)?;
                Ok((name, set, problem))
            };
            options.problem.iter().map(built).collect::<Result<_, Failure>>()?
        }
    };
    for (name, set, problem) in &problems {
        let request =
            Request { problem: Some(name.clone()), t_end: options.t_end, set: set.clone(), ..Request::default() };
        let (truth, found) = measure_program(&**problem, &program, &request, None, &ladder)?;
        let notes = found.notes.iter().map(|note| format!("; {note}")).collect::<String>();
        let check = Check {
            id: format!("measured/{name}"),
            statement: format!("On {name}, against {truth}, the order of the program is {order}"),
            outcome: found.fit.verdict.into(),
            measured: found.fit.line.map(|line| line.slope),
            required: Some(Requirement::Near(order, found.fit.expected.band)),
            reason: format!("{}{notes}", found.fit.reason),
        };
        verdicts.push(Verdict { kind: Kind::Run, subject: name.clone(), check });
    }
    if options.format == Format::Text && problems.iter().all(|(.., problem)| !depends_on_time(&**problem)) {
        // Beside the verdicts, not among them.
        let _ = writeln!(io::stderr(), "{UNSEEN}");
    }
    match options.format {
        Format::Text => {
            paragraph(out, &format!("`{command}`: "), 2, &format!("a program, of which order {order} is expected"))
                .and_then(|()| write_verdicts(&verdicts, out))
        }
        Format::Markdown => write_markdown_verdicts(&verdicts, out),
        Format::Json => {
            serde_json::to_writer_pretty(&mut *out, &verdicts).map_err(io::Error::from).and_then(|()| writeln!(out))
        }
    }
    .map_err(Failure::Output)?;
    Ok(status(verify::judge::overall(&verdicts)))
}

/// Column at which the text of a line starts.
const INDENT: usize = 15;

/// The word for the outcome of a claim.
fn word(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Pass => "confirmed",
        Outcome::Fail => "REFUTED",
        Outcome::Inconclusive => "inconclusive",
        Outcome::NotSettled => "not settled",
        Outcome::NotRun => "not run",
    }
}

fn write_verdicts(verdicts: &[Verdict], out: &mut impl Write) -> io::Result<()> {
    for (heading, kinds) in [("CLAIMS", &[Kind::Claim, Kind::Consistency][..]), ("RUNS", &[Kind::Run])] {
        let mut verdicts = verdicts.iter().filter(|verdict| kinds.contains(&verdict.kind)).peekable();
        if verdicts.peek().is_some() {
            writeln!(out, "\n{heading}")?;
        }
        for Verdict { subject, check, .. } in verdicts {
            paragraph(out, &format!("  {}", word(check.outcome)), INDENT, &format!("{subject}: {}", check.reason))?;
        }
    }
    Ok(())
}

fn write_text(judgement: &Judgement, out: &mut impl Write) -> io::Result<()> {
    paragraph(out, &format!("{}: ", judgement.file.name), 2, &judgement.headline())?;
    if let Some(source) = &judgement.file.source {
        paragraph(out, "", 2, source)?;
    }
    write_verdicts(&judgement.verdicts, out)?;
    if is_open_by_runs(&judgement.verdicts) {
        writeln!(out)?;
        paragraph(out, "", 2, OPEN_BY_RUNS)?;
    }
    if let Some(diagnosis) = judgement.diagnosis_text() {
        writeln!(out, "\nDIAGNOSIS")?;
        paragraph(out, "", 2, &diagnosis)?;
        for change in judgement.changes() {
            paragraph(out, "  change ", INDENT, &change)?;
        }
    }
    writeln!(out, "\nTHEORY")?;
    for (label, text) in judgement.facts() {
        paragraph(out, &format!("  {label}"), INDENT, &text)?;
    }
    Ok(())
}

/// Whether nothing is refuted, and nothing but runs inconclusive.
fn is_open_by_runs(verdicts: &[Verdict]) -> bool {
    let is_open = |verdict: &&Verdict| verdict.check.outcome == Outcome::Inconclusive;
    verify::judge::overall(verdicts) == Outcome::Inconclusive
        && verdicts.iter().filter(is_open).all(|verdict| verdict.kind == Kind::Run)
}

fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('*', "\\*").replace('_', "\\_")
}

fn write_markdown_verdicts(verdicts: &[Verdict], out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "| Statement | Verdict | Because |\n|:--|:--|:--|")?;
    verdicts.iter().try_for_each(|Verdict { check, .. }| {
        writeln!(out, "| {} | {} | {} |", cell(&check.statement), word(check.outcome), cell(&check.reason))
    })
}

fn write_markdown(judgement: &Judgement, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "# {}\n\n{}.\n", judgement.file.name, judgement.headline())?;
    write_markdown_verdicts(&judgement.verdicts, out)?;
    if let Some(diagnosis) = judgement.diagnosis_text() {
        writeln!(out, "\n**{}**\n", cell(&diagnosis))?;
        judgement.changes().iter().try_for_each(|change| writeln!(out, "- {}", cell(change)))?;
    }
    writeln!(out, "\n| Theory | |\n|:--|:--|")?;
    judgement.facts().iter().try_for_each(|(label, text)| writeln!(out, "| {label} | {} |", cell(text)))
}

/// The result in the form that JSON has.
#[derive(Debug, Serialize)]
struct Json<'a> {
    name: &'a str,
    kind: &'a str,
    digits: Option<u32>,
    outcome: Outcome,
    order: u32,
    #[serde(flatten)]
    runge_kutta: Option<JsonRungeKutta>,
    verdicts: &'a [Verdict],
    diagnosis: Option<String>,
    repairs: Vec<JsonRepair<'a>>,
    exchanges: Vec<JsonExchange<'a>>,
    facts: Vec<(&'static str, String)>,
}

/// What only Runge–Kutta methods have.
#[derive(Debug, Serialize)]
struct JsonRungeKutta {
    stages: usize,
    order_in_time: u32,
    embedded_order: Option<u32>,
    stage_order: u32,
    error_norm: Option<f64>,
    alpha: Option<f64>,
}

#[derive(Debug, Serialize)]
struct JsonRepair<'a> {
    place: String,
    also: Vec<String>,
    was: &'a str,
    text: &'a str,
    value: f64,
    with_c: bool,
    mends: usize,
}

#[derive(Debug, Serialize)]
struct JsonExchange<'a> {
    names: &'a [String; 2],
    with_c: bool,
    mends: usize,
}

fn write_json(judgement: &Judgement, out: &mut impl Write) -> io::Result<()> {
    let runge_kutta = judgement.runge_kutta().map(|theory| JsonRungeKutta {
        stages: theory.numbers.stages(),
        order_in_time: theory.order_in_time,
        embedded_order: theory.embedded.as_ref().map(|e| e.order),
        stage_order: theory.simplifying.stage_order(),
        error_norm: theory.main.error_norm,
        alpha: theory.alpha,
    });
    let repairs = judgement.repairs().iter().map(|r| JsonRepair {
        place: r.place.to_string(),
        also: r.also.iter().map(ToString::to_string).collect(),
        was: &r.was,
        text: &r.text,
        value: r.value.to_f64(),
        with_c: !r.follows.is_empty(),
        mends: r.mends,
    });
    let exchanges =
        judgement.exchanges().iter().map(|e| JsonExchange { names: &e.names, with_c: e.with_c, mends: e.mends });
    let json = Json {
        name: &judgement.file.name,
        kind: judgement.theory.kind(),
        digits: judgement.file.rounding.places(),
        outcome: judgement.outcome(),
        order: judgement.theory.order(),
        runge_kutta,
        verdicts: &judgement.verdicts,
        diagnosis: judgement.diagnosis_text(),
        repairs: repairs.collect(),
        exchanges: exchanges.collect(),
        facts: judgement.facts(),
    };
    serde_json::to_writer_pretty(&mut *out, &json)?;
    writeln!(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_named_where_they_alone_leave_something_open() {
        let verdict = |kind, outcome| Verdict {
            kind,
            subject: String::new(),
            check: Check { outcome, ..Check::at_most("id", "statement", 0.0, 1.0, "reason") },
        };
        let is_named = |verdicts: &[(Kind, Outcome)]| {
            is_open_by_runs(&verdicts.iter().map(|(kind, outcome)| verdict(*kind, *outcome)).collect::<Vec<_>>())
        };
        let (claim, run) = (Kind::Claim, (Kind::Run, Outcome::Inconclusive));
        assert!(is_named(&[(claim, Outcome::Pass), run]));
        assert!(!is_named(&[(claim, Outcome::Inconclusive), run]) && !is_named(&[(claim, Outcome::Fail), run]));
        assert!(!is_named(&[(claim, Outcome::Pass), (Kind::Run, Outcome::NotSettled)]));
    }

    #[test]
    fn a_cell_shows_what_it_says() {
        assert_eq!(cell("a|b, *c* and d_e"), "a\\|b, \\*c\\* and d\\_e");
    }
}
