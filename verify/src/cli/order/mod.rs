//! `order`: an order of accuracy, measured.

mod data;
mod picture;
mod program;

use std::io::{self, Write};
use std::path::PathBuf;

use clap::ValueEnum;
use serde::Serialize;
use verify::judge::FileMethod;
use verify::measure::order::{OrderFit, Reason, Sample, Verdict};
use verify::method::Method;
use verify::order::{Ladder, Source, Truth, measure_on};
use verify::problem::Problem;
use verify::program::{Request, Shown};
use verify::run::passed_over;
use verify::theory::{methods_for, order_plan};

use data::DataArgs;
use program::ProgramArgs;

use crate::cli::Status;
use crate::cli::args::{self, ProblemArgs};
use crate::cli::error::Failure;
use crate::cli::layout::{decimals, number, paragraph, plain, right, significant};
use crate::cli::output::Output;

/// Measure the order of a method on a problem and judge it.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The errors at the end of a run are fitted against h. The verdict is pass, fail
or inconclusive: the order must be the expected one within a two-sided band,
and the table says which points decided and why the others did not. Of a method
theory has an order to expect, which belongs to the pair of method and problem;
where it is not the nominal one, the reason is given. Of a method file it is the
order that it claims, or what the coefficients have on equations in general; a
claim that they do not have there passes nowhere. Of a program, or of data,
nothing is expected without --expect: the verdict is measured, or inconclusive
where three grids leave nothing to test an order with. The +- of an order is the
standard error of the fit, and what its floors can do to it; of a measured one
it is no less than what a drift of the local slopes has left to go.

A program is run with steps that divide the time, and then with steps that leave
half a one over: a last step that is cut short shows there. One that ends a step
or more from the time that it was asked for does not pass; one that ends less
than a step from it is measured at the time that it reached, with a note.

The default reference is the exact solution where it is known, else CVODE (or
diffsol in a build without it). A solver is run at two tolerances; the bound on
its error that follows is part of an error's floor. Both may pass over what f of
a model does for a moment: where a run that stops at it is another, the verdict
is inconclusive, with a note.

JSON, one object: problem, method, reference, t_end, expected {order, band} or
null, declared {nominal, reason} or null, notes, slope, stderr, r_squared (null
where there is no fit), verdict (pass, measured, fail, inconclusive), reason,
and points, coarse to fine, each {h, error, floor, local_order, kept, reason}.
error and floor are null where the run failed. local_order is taken with the
next coarser point; null where there is none. reason says why a point was
dropped, else it is null.

Examples:
  verify order --problem quadratic-drag --method method-i
  verify order --problem van-der-pol --method rk4 --reference diffsol
  verify order --problem logistic --method bdf2 --format json
  verify order --model van-der-pol.ds --method method-i --t-end 5
  verify order --data drag.csv --cells cells --dimension 3 --expect 2
  verify order --data drag.csv --cells cells --dimension 3 --picture drag.svg

  verify order --problem logistic --program 'python3 mine.py' --expect 4
  verify order --program ./flow --quantity drag --refine cells=32,64,128,256

A program gets the arguments --problem NAME --h H --t-end T [--set K=V ...] and
writes CSV to standard output, as `verify solve --csv -` does: a header, t and
the names of the components, which `verify list problems` shows, then a row for
each time; further columns are ignored. On van-der-pol:
  t,x,y
  0,2,0
  0.1,1.99093,-0.172638
Without a reference it is judged by its own values: of a column, at the last
time, over several --h, or over a parameter with --refine, by the rules of
--data. Whole numbers of --refine count cells along a side, others are spacings.
Runs are made in parallel.

With --data the table has a header; one column is the spacing of the grids (or
their number of cells), each other one a quantity, lines with # are comments.
Three grids that converge from one side give the order, the limit and the grid
convergence index of Celik et al. (2008); values that alternate follow no power
law, and have formal ones by that procedure, of which none is judged. Four or
more have the least squares of Eca and Hoekstra (2014) and the test whether the
order has settled. Half a unit of the last digit given is the resolution of a
value: differences below ten times that decide nothing, and the finest grids are
left out where they differ by less, or by rounding.
JSON, for one quantity: quantity, grids, order, order_uncertainty, extrapolated,
gci_fine (a part of the value, 0.01 for 1 %), celik {order, formal, limit,
approximate_error, extrapolated_error, gci_fine, gci_medium} or null, of the
three finest grids, formal where their differences alternate, convergence
(monotonic, oscillatory, divergent, oscillatory and divergent, unresolved,
unknown),
triplet_orders and pair_orders (coarse to fine), least_squares {form, weighted,
grids, limit, deviation, uncertainty} or null, verdict, reason, notes; for
several: verdict and quantities. What could not be found is null.

Exit status: 0 pass or measured, 1 fail, 2 bad input, 3 inconclusive. A program
that does not start, or writes another header, is bad input; runs that fail or
take too long are points without an error, and may leave too few to tell.")]
pub(super) struct Args {
    #[command(flatten)]
    problem: ProblemArgs,

    /// A method by name (`verify list methods`), or a file
    #[arg(long, value_name = "M", required_unless_present_any = ["data", "program"])]
    method: Option<String>,

    /// Measure errors against exact, cvode or diffsol
    #[arg(long, value_name = "R", value_enum, hide_possible_values = true)]
    reference: Option<Source>,

    /// End time, for a model or a program
    #[arg(long, value_name = "T", allow_hyphen_values = true, value_parser = args::positive)]
    t_end: Option<f64>,

    /// Coarsest step of the ladder
    #[arg(long, value_name = "H", allow_hyphen_values = true, value_parser = args::positive)]
    coarsest: Option<f64>,

    /// Number of steps of the ladder
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..=60))]
    points: Option<u16>,

    /// Tolerance of a numerical reference, 1e-12 by default
    #[arg(long, value_name = "TOL", allow_hyphen_values = true, value_parser = args::part)]
    reference_tolerance: Option<f64>,

    /// Order to expect, in place of the one that theory has for the pair
    #[arg(long, value_name = "P", allow_hyphen_values = true, value_parser = args::positive)]
    expect: Option<f64>,

    /// Largest distance from the expected order; 0.25 without reference
    #[arg(long, value_name = "B", allow_hyphen_values = true, value_parser = args::positive)]
    band: Option<f64>,

    /// Form of the result: table, json or markdown
    #[arg(long, value_enum, hide_possible_values = true, default_value_t = Format::Table)]
    format: Format,

    /// Draw errors, or values and their limit, to this file in SVG
    #[arg(long, value_name = "FILE.svg", value_parser = svg)]
    picture: Option<PathBuf>,

    #[command(flatten)]
    data: DataArgs,

    #[command(flatten)]
    program: ProgramArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    Table,
    Json,
    Markdown,
}

/// A path that does not promise another kind of picture.
fn svg(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension() {
        Some(end) if !end.eq_ignore_ascii_case("svg") => Err("pictures are written in SVG: FILE.svg".into()),
        _ => Ok(path),
    }
}

/// Characters of a reason that takes more than a line of its column.
const LONG: usize = 33;

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Pass => "PASS",
        Verdict::Measured => "MEASURED",
        Verdict::Fail => "FAIL",
        Verdict::Inconclusive => "INCONCLUSIVE",
    }
}

impl Args {
    /// Refuses options that are of another question: clap asks for what an option requires only where nothing given excludes that.
    fn refuse_others(&self) -> Result<(), Failure> {
        let (is_data, is_program) = (self.data.data.is_some(), self.program.program.is_some());
        let is_of_values = is_data || is_program && self.program.refines();
        let of_references = [
            ("--reference", self.reference.is_some()),
            ("--reference-tolerance", self.reference_tolerance.is_some()),
            ("--coarsest", self.coarsest.is_some()),
            ("--points", self.points.is_some()),
        ];
        let of_references = of_references.into_iter().filter_map(|(option, is_given)| is_given.then_some(option));
        let programs = self.program.given().filter(|_| !is_program).map(|option| (option, "--program"));
        let tables = self.data.given().filter(|_| !is_data).map(|option| (option, "--data"));
        let quantities = self.data.given_of_quantities().filter(|_| !is_of_values);
        let quantities = quantities.map(|option| (option, "--data, or --program with --h or --refine"));
        let references = of_references.filter(|_| is_of_values);
        let references = references.map(|option| (option, "--method, or --program without --h and --refine"));
        match programs.chain(tables).chain(quantities).chain(references).next() {
            Some((option, needed)) => Err(Failure::Incomplete(option, needed)),
            None => Ok(()),
        }
    }
}

pub(super) fn run(args: &Args, out: &mut Output) -> Result<Status, Failure> {
    args.refuse_others()?;
    if let Some(path) = &args.data.data {
        let quantities = args.data.read(path)?;
        return args.data.judge((&quantities, &Shown::default()), args, out);
    }
    let ladder = Ladder {
        expected: args.expect,
        band: args.band,
        coarsest: args.coarsest,
        points: args.points.map(usize::from),
        tolerance: args.reference_tolerance,
    };
    if let Some(command) = &args.program.program {
        let set = args.problem.set().to_vec();
        if args.program.refines() {
            let request = Request { problem: args.problem.name().map(str::to_owned), h: None, t_end: args.t_end, set };
            let columns = args.data.columns().ok_or(Failure::Incomplete("--h or --refine", "--quantity COLUMN"))?;
            let (quantities, shown) = args.program.refined(command, &request, columns)?;
            return args.data.judge((&quantities, &shown), args, out);
        }
        let request = Request { problem: None, h: None, t_end: args.t_end, set };
        return args.program.against_reference(command, request, &ladder, args, out);
    }
    if args.t_end.is_some() && !args.problem.is_model() {
        return Err(Failure::Incomplete("--t-end", "--model or --program: a problem has its own"));
    }
    let (name, problem) = args.problem.build(args.t_end)?;
    let text = args.method.as_deref().unwrap_or_default();
    let method = args::method(text)?;
    let mut ladder = ladder;
    let mut notes = Vec::new();
    let file = args::method_file(text)?;
    // A wrong coefficient lowers the order that theory has, and the runs would agree with it.
    let claimed = file.as_ref().and_then(|file| file.order()).filter(|p| *p != method.order());
    if let Some(claimed) = claimed {
        ladder.expected = ladder.expected.or(Some(f64::from(claimed)));
        let but = file.as_ref().and_then(|file| FileMethod::of(file).refutes(claimed)).unwrap_or_default();
        notes.push(format!(
            "the file claims order {claimed}, which is expected here unless `--expect` says otherwise, and {but}: `verify judge \
             {text}` says why"
        ));
    }
    let divergent = file.as_ref().and_then(|file| FileMethod::of(file).diverges());
    notes.extend(divergent.map(|what| format!("the method is {what}; `verify judge {text}` says why")));
    // A method that does not apply would otherwise show as a failure at each step size.
    method.build(&*problem)?;
    let source = args.reference.unwrap_or_else(|| Source::default_for(&*problem, &*method));
    let truth = source.truth(&*problem, &*method);
    let fit = measure_on(&*problem, &*method, truth, &ladder)?;
    // Coefficients alone say nothing of a special problem.
    let is_known = is_known(&args.problem, &*problem, &*method);
    let mut fit = if is_known || ladder.expected.is_some() { fit } else { fit.of_equations_in_general() };
    let overstated = claimed.filter(|claimed| *claimed > method.order() && args.expect.is_none());
    if overstated.is_some() && fit.verdict == Verdict::Pass {
        fit.verdict = Verdict::Inconclusive;
        fit.reason += &format!(", on this equation: on others the order is {}", method.order());
    }
    // Runs of an inconsistent method agree with its order, which is none.
    if let (0, None, Verdict::Pass) = (method.order(), args.expect, fit.verdict) {
        fit.verdict = Verdict::Fail;
        fit.reason += &format!(": a method without order does not converge; `verify judge {text}` says why");
    }
    let end = order_plan(&*problem, &*method).horizon;
    doubt(&*problem, (truth, end), &mut fit, &mut notes);
    let result = Measurement::new(&name, method.name(), (truth, end), (&fit, true), &notes);
    let start = problem.initial();
    let result = match problem.observe(0.0, &start) == start {
        true => result,
        false => result.of("an unknown of the equations, not of what `solve` shows of them,"),
    };
    result.write(args, &fit, out)?;
    if args.format == Format::Table {
        args.problem.write_caveat(out).map_err(Failure::Output)?;
    }
    Ok(fit.verdict.into())
}

/// Takes back what was told by a reference of a model that may pass over what f does for a moment, and says why.
fn doubt(problem: &dyn Problem, (truth, end): (Truth, f64), fit: &mut OrderFit, notes: &mut Vec<String>) {
    if problem.facts().model.is_none() || !matches!(truth, Truth::Numerical(_)) {
        return;
    }
    if let Some(passed_over) = passed_over(problem, end) {
        notes.push(format!("the reference is in doubt: {passed_over}; a shorter `--t-end` about it tells"));
        if fit.verdict != Verdict::Inconclusive {
            fit.verdict = Verdict::Inconclusive;
            fit.reason += ", by a reference that is in doubt";
        }
    }
}

/// Whether the report measures the method on this problem too, as on each of its own.
fn is_known(named: &ProblemArgs, problem: &dyn Problem, method: &dyn Method) -> bool {
    !named.is_model()
        && named.set().is_empty()
        && methods_for(problem).iter().any(|known| known.name() == method.name())
}

/// The result in the form that JSON has; the help states the schema.
#[derive(Debug, Serialize)]
struct Measurement<'a> {
    problem: &'a str,
    method: String,
    reference: String,
    t_end: f64,
    expected: Option<Expected>,
    declared: Option<Declared<'a>>,
    slope: Option<f64>,
    stderr: Option<f64>,
    r_squared: Option<f64>,
    verdict: Verdict,
    reason: &'a str,
    notes: &'a [String],
    points: Vec<Point>,
    /// What an error is a difference of.
    #[serde(skip)]
    of: &'static str,
    /// Whether finer steps may tell.
    #[serde(skip)]
    wants_finer: bool,
}

#[derive(Debug, Serialize)]
struct Expected {
    order: f64,
    band: f64,
}

#[derive(Debug, Serialize)]
struct Declared<'a> {
    nominal: f64,
    reason: &'a str,
}

#[derive(Debug, Serialize)]
struct Point {
    h: f64,
    error: Option<f64>,
    floor: Option<f64>,
    local_order: Option<f64>,
    kept: bool,
    reason: Option<String>,
}

impl<'a> Measurement<'a> {
    /// Of a fit, and whether an order was expected.
    fn new(
        problem: &'a str,
        method: String,
        (truth, t_end): (Truth, f64),
        (fit, expects): (&'a OrderFit, bool),
        notes: &'a [String],
    ) -> Self {
        let point = |(sample, reason): (&Sample, Option<&Reason>)| {
            let measured = sample.result.as_ref().ok();
            Point {
                h: sample.h,
                error: measured.map(|m| m.error),
                floor: measured.map(|m| m.floor),
                local_order: fit.local_slopes.iter().find(|local| local.fine == sample.h).map(|local| local.slope),
                kept: reason.is_none(),
                reason: reason.map(Reason::to_string),
            }
        };
        let declared = fit.expected.declared.as_ref();
        Self {
            problem,
            method,
            reference: truth.to_string(),
            t_end,
            expected: expects.then_some(Expected { order: fit.expected.order, band: fit.expected.band }),
            declared: declared.map(|d| Declared { nominal: d.nominal, reason: &d.reason }),
            slope: fit.line.map(|line| line.slope),
            stderr: fit.line.map(|line| line.stderr),
            r_squared: fit.line.map(|line| line.r_squared),
            verdict: fit.verdict,
            reason: &fit.reason,
            notes,
            points: fit.points().into_iter().map(point).collect(),
            of: "a component of the state",
            wants_finer: fit.wants_finer(),
        }
    }

    /// The same, of errors in something else.
    fn of(self, of: &'static str) -> Self {
        Self { of, ..self }
    }

    fn write(&self, args: &Args, fit: &OrderFit, out: &mut Output) -> Result<(), Failure> {
        match args.format {
            Format::Table => self.write_table(out),
            Format::Json => self.write_json(out),
            Format::Markdown => self.write_markdown(out),
        }
        .map_err(Failure::Output)?;
        let title = || format!("{} on {}", self.method, self.problem);
        args.picture
            .as_ref()
            .map_or(Ok(()), |path| picture::write(&picture::of_errors(&title(), fit, self.expected.is_some()), path))
    }

    /// What an error is.
    fn compared(&self) -> String {
        format!("the largest difference of {} at t = {}", self.of, plain(self.t_end))
    }

    fn write_json(&self, out: &mut impl Write) -> io::Result<()> {
        serde_json::to_writer_pretty(&mut *out, self)?;
        writeln!(out)
    }

    /// A table of the points for a pull request, the verdict below.
    fn write_markdown(&self, out: &mut impl Write) -> io::Result<()> {
        writeln!(
            out,
            "`{}` on `{}`, errors against {}: {}\n",
            self.method,
            self.problem,
            self.reference,
            self.compared()
        )?;
        writeln!(out, "| h | error | order | in the fit |\n|---|---|---|---|")?;
        for point in &self.points {
            let cell = |x: Option<f64>| x.map_or_else(|| "—".into(), |x| significant(x, 4));
            let order = point.local_order.map_or_else(|| "—".into(), |x| decimals(x, 3));
            let fate = point.reason.as_ref().map_or_else(|| "yes".into(), |reason| format!("no: {reason}"));
            writeln!(out, "| {} | {} | {order} | {fate} |", number(point.h), cell(point.error))?;
        }
        writeln!(out, "\n**{}**: {}", word(self.verdict), self.reason)?;
        self.notes.iter().try_for_each(|note| writeln!(out, "\n- {note}"))
    }

    fn write_table(&self, out: &mut impl Write) -> io::Result<()> {
        let title = format!("{} on {}, errors against {}", self.method, self.problem, self.reference);
        paragraph(out, "", 0, &title)?;
        paragraph(out, "", 0, &self.compared())?;
        writeln!(out, "\n{:>11} {:>11} {:>9} {:>7}  in the fit", "h", "error", "floor", "order")?;
        let mut before = None;
        for point in &self.points {
            let cell = |x: Option<f64>, digits| x.map_or_else(|| "—".into(), |x| significant(x, digits));
            let order = point.local_order.map_or_else(|| "—".into(), |x| decimals(x, 3));
            let label = format!(
                "{} {} {} {}  ",
                right(&number(point.h), 11),
                right(&cell(point.error, 5), 11),
                right(&cell(point.floor, 2), 9),
                right(&order, 7)
            );
            // A long reason is told once.
            let fate = match &point.reason {
                None => "yes".into(),
                Some(reason) if before == Some(reason) && reason.len() > LONG => "no: the same".into(),
                Some(reason) => format!("no: {reason}"),
            };
            before = point.reason.as_ref();
            paragraph(out, &label, 43, &fate)?;
        }
        writeln!(out)?;
        let verdict = word(self.verdict);
        paragraph(out, &format!("{verdict}: "), verdict.len() + 2, self.reason)?;
        self.notes.iter().try_for_each(|note| paragraph(out, "\nNote: ", 6, note))?;
        match self.wants_finer {
            true => paragraph(
                out,
                "hint: ",
                6,
                "`--coarsest` starts the ladder at a smaller step, and `--points` makes it longer",
            ),
            false => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use verify::method;

    use super::*;

    /// The order of a method on a problem with its own parameters, and of no model.
    #[test]
    fn orders_that_the_report_measures_are_known() {
        #[derive(clap::Parser)]
        struct Asked {
            #[command(flatten)]
            problem: ProblemArgs,
        }
        let file = tempfile::NamedTempFile::with_suffix(".ds").expect("a file");
        std::fs::write(file.path(), "u_i { x = 1 } F_i { -x }").expect("writable");
        let model = file.path().to_str().expect("UTF-8");
        for (words, method, is_expected) in [
            (&["--problem", "linear-drag"][..], "rk4", true),
            (&["--problem", "linear-drag", "--set", "v0=2"], "rk4", false),
            (&["--problem", "linear-drag"], "stormer-verlet", false),
            (&["--model", model], "rk4", false),
        ] {
            let asked = <Asked as clap::Parser>::try_parse_from(["order"].iter().chain(words)).expect("it makes sense");
            let (_, problem) = asked.problem.build(None).expect("there");
            let method_of = method::parse(method).expect("registered");
            assert_eq!(is_known(&asked.problem, &*problem, &*method_of), is_expected, "{words:?}, {method}");
        }
    }

    /// Of two points with the same reason.
    fn table(reason: &str) -> String {
        let point = |h: f64| Point {
            h,
            error: Some(1.0),
            floor: Some(0.0),
            local_order: None,
            kept: false,
            reason: Some(reason.into()),
        };
        let measurement = Measurement {
            problem: "linear-drag",
            method: "rk4".into(),
            reference: "the exact solution".into(),
            t_end: 1.0,
            expected: None,
            declared: None,
            slope: None,
            stderr: None,
            r_squared: None,
            verdict: Verdict::Fail,
            reason: &"word ".repeat(crate::cli::layout::columns() / 4),
            notes: &[],
            points: vec![point(0.5), point(0.25)],
            of: "a component of the state",
            wants_finer: false,
        };
        let mut out = Vec::new();
        measurement.write_table(&mut out).expect("written");
        String::from_utf8(out).expect("UTF-8")
    }

    #[test]
    fn a_reason_of_more_than_a_line_is_told_once() {
        let times = |letters: usize| table(&"x".repeat(letters)).matches("xxx").count() / (letters / 3);
        assert_eq!([LONG, LONG + 1].map(times), [2, 1]);
        assert!(table(&"x".repeat(LONG + 1)).contains("no: the same"));
    }

    #[test]
    fn a_long_reason_stands_right_of_the_verdict() {
        let text = table("x");
        let (first, more) = text.trim_end().rsplit_once('\n').expect("two lines");
        let first = first.lines().last().expect("a line");
        assert!(first.contains(": word") && first.find("word") == more.find("word"), "{text}");
    }
}
