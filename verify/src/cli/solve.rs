//! `solve`: one method on one problem, as rows.

mod beside;
mod beware;
mod equation;
mod held;
mod stopped;
mod table;
mod units;
mod unresolved;

use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use lsvi::adaptive::Tolerances;
use lsvi::{Grid, InputError, State, SystemError};
use verify::estimate::{Estimator, Settling};
use verify::kinds::Stability;
use verify::measure::decimal::{decimals, trimmed};
use verify::measure::norm::{Extremes, distance, larger, max_norm};
use verify::method::adaptive::{DEFAULT_ATOL, DEFAULT_RTOL};
use verify::method::{Method, Traits};
use verify::problem::changes::acts_between;
use verify::problem::{Invariant, Problem, component_names};
use verify::run::{RunError, run_while};
use verify::theory::breakdown;

use super::Status;
use super::args::{self, ProblemArgs};
use super::error::Failure;
use super::layout::{counted, number, paragraph, plain};
use super::output::Output;
use beside::Beside;
use beware::Watch;
use table::Table;
use unresolved::{Forcing, Unseen};
use verify::replacement::Replacement;

/// Part of the largest value above which an estimate of its error says that no digit of it is right.
const MEANINGLESS: f64 = 0.5;

/// Times what the tolerances allow in all steps together; a disturbance that grows by as much makes an error of it.
const FAR: f64 = 100.0;

/// Columns after the components: the error where an exact solution is known, and the estimate.
const ERRORS: [&str; 2] = ["error", "estimate"];

/// Steps that take minutes.
const MANY: f64 = 1e7;

/// Integrate a problem and show or write the solution, a row per step.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Rows run from t = 0 to the end time; where the step size does not divide it, the
last step is shorter. An adaptive method gives a row per accepted step. Columns:
t, the components, where an exact solution is known error, the largest error of
a component, and estimate, what the step size alone is estimated to contribute
to it: a second run with half the step, or of an adaptive method with a tenth of
the tolerances, and on models in steps of a thousandth of the time at most,
tells. Of one-step methods the second run has a step end where f jumps; of
others the estimate may be a part of the error there, and in the first row of
bdf2, whose first step another method takes, a small one. A third run, with
twice the step, tells at the end whether errors fall by the order that the
estimate takes them to; where they do not, or where f is not linear and it would
have errors as large as the solution, and nothing else is wrong, a note says
that it is coarse. Where f has kinks three runs may fall so by chance, and the
estimate be off by more without a note. Both runs take five sevenths of the
time; with --no-estimate there is none. The estimate is empty where both
tolerances lead to the same steps. After the rows, what is lost of energy,
angular momentum or enstrophy, for problems that have them, and for flows |f|,
the largest component of f, which is near 0 where the end is a steady state, and
the linear systems that the steps took.

A run of more than a second shows its progress on a terminal.

What the rows do not show is said on standard error, and after the rows of a
CSV in lines that start with #: a run past the end of the exact solution, a
rest, or a component at rest, where f is not zero, a rest where the equation is
unstable, a linear invariant that is broken, a step across what may be a pole, a
step that amplifies what the equation damps, or with half of it as well damps
what it keeps or keeps what it damps, steps that do not see how f changes in
time, errors of an adaptive method beyond all that its tolerances allow, a
solution that is smaller than the absolute one; where none of these is found,
an error that other solvers tell and the estimate does not. Derivatives are
looked at up to 64 unknowns, of invariants of more the sum of all components
alone; other solvers are asked of models up to 256, if they are done soon. A
place at which f acts for much less than a step may be passed over by the run,
its finer one and those solvers alike.

The steps of radau-adaptive are chosen by an estimate of lower order, held to a
tenth of the power 2/3 to 4/7 of the tolerance, as in RADAU5: the solution then
meets the tolerance where h resolves it, and its stiff components, which have
the error of the estimate, meet that power, as do steps within which f jumps or
has a kink. With --strict estimates are held to the tolerance itself, and the
error of a kink with them, as a rule; an estimate may miss a kink or a jump by
where it lies in the step. The column estimate tells.

With --csv the numbers read back as the same doubles. A solve that fails leaves
FILE as it was; rows already sent to standard output stand.

Examples:
  verify solve --problem logistic --method method-i --h 0.1 --t-end 10
  verify solve --problem van-der-pol --set mu=5 --method bdf2 \\
      --h 0.01 --t-end 20 --csv van-der-pol.csv
  verify solve --problem van-der-pol --set mu=1000 --method radau-adaptive \\
      --rtol 1e-8 --t-end 2000
  verify solve --problem robertson --method radau-adaptive --rtol 1e-8 \\
      --atol 1e-10,1e-14,1e-10 --t-end 1e4
  verify solve --problem linear-drag --method 'linear(-0.5,1)' --h 0.1 \\
      --t-end 1 --csv - | head
  verify solve --problem cavity --set re=400 --set cells=32 \\
      --method method-i --h 0.1 --t-end 1 --csv cavity.csv
  verify solve --problem shear-layer --set re=1e12 --method trapezoidal \\
      --h 0.1 --t-end 1
  verify solve --model van-der-pol.ds --set mu=2 --method method-i \\
      --h 0.01 --t-end 20

Exit status: 0 solved, 1 the solve failed on the way, 2 bad usage.")]
pub(super) struct Args {
    #[command(flatten)]
    problem: ProblemArgs,

    /// A method by name (`verify list methods`), or a file
    #[arg(long, value_name = "M")]
    method: String,

    /// Step size (adaptive methods: the longest, optional)
    #[arg(long, allow_hyphen_values = true)]
    h: Option<f64>,

    /// Relative tolerance of an adaptive method, 1e-6 by default
    #[arg(long, value_name = "TOL", allow_hyphen_values = true)]
    rtol: Option<f64>,

    /// Absolute tolerance of an adaptive method, 1e-9 by default: one for all
    /// components, or one for each, separated by commas
    #[arg(long, value_name = "TOL,..", allow_hyphen_values = true, value_delimiter = ',')]
    atol: Vec<f64>,

    /// Hold the estimates of an adaptive method to the tolerances themselves:
    /// for an f that has kinks
    #[arg(long)]
    strict: bool,

    /// Steps that an adaptive method may try, 1000000 by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    max_steps: Option<u64>,

    /// Leave out the estimate of the error, and the run that it takes
    #[arg(long)]
    no_estimate: bool,

    /// End time
    #[arg(long, value_name = "T", allow_hyphen_values = true, value_parser = args::finite)]
    t_end: f64,

    /// Write every row to FILE, or to standard output for `-`
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
}

pub(super) fn run(args: &Args, out: &mut Output) -> Result<Status, Failure> {
    let solve = Solve::new(args)?;
    match &args.csv {
        None => solve.show(out),
        Some(path) if path.as_os_str() == "-" => solve.stream(out),
        Some(path) => solve.write(path, out),
    }?;
    Ok(Status::Ok)
}

/// A request that makes sense.
struct Solve<'a> {
    args: &'a Args,
    name: String,
    problem: Box<dyn Problem>,
    method: Box<dyn Method>,
    h: f64,
    has_exact: bool,
    /// What speaks against the order that the method's file claims.
    overclaim: Option<String>,
}

/// A row of the result.
#[derive(Debug, Clone, Copy)]
struct Row<'a> {
    t: f64,
    /// Observed components.
    values: &'a [f64],
    /// One for each of the columns after the components: the error where the exact solution exists, and the estimate.
    errors: &'a [Option<f64>],
}

/// What the rows come to.
#[derive(Debug, Default)]
struct Summary {
    rows: usize,
    t: f64,
    /// The largest component of all rows.
    size: f64,
    /// The largest error and its time.
    error: Option<(f64, f64)>,
    /// The largest estimate and its time.
    estimate: Option<(f64, f64)>,
    /// Whether the order of the estimate shows.
    settling: Option<Settling>,
    /// The first row behind which none has an estimate, and why.
    unestimated: Option<(f64, String)>,
    /// Of flows, |f| at the end and the linear systems that were solved.
    effort: Option<(f64, u64)>,
    watch: Watch,
    beside: Beside,
    /// That the steps do not see how f depends on time.
    unseen: Option<Unseen>,
    course: Course,
}

/// The rows of a small model, as long as they are few.
#[derive(Debug, Default)]
struct Course {
    times: Vec<f64>,
    states: Vec<Vec<f64>>,
    /// Whether it is too long, or of no model, and not looked at.
    is_long: bool,
}

impl Course {
    /// More rows are closer than what is looked at between them.
    const ROWS: usize = 4096;

    fn add(&mut self, t: f64, state: &[f64]) {
        self.is_long |= self.times.len() == Self::ROWS || state.len() > equation::DENSE;
        if !self.is_long {
            self.times.push(t);
            self.states.push(state.to_vec());
        }
    }

    /// That f acts between two rows alone, at a place that the solution comes by.
    fn passed_over(&self, problem: &dyn Problem, beside: &Beside) -> Option<String> {
        let acts = if self.is_long { Vec::new() } else { acts_between(problem, &self.times, &self.states) };
        // Nothing may come of it, as on the way between states of a stiff system.
        if acts.is_empty() || beside.is_met(problem, &acts) {
            return None;
        }
        Some(format!(
            "from t = {} to t = {} f acts for a moment, as a switch at some place does, between rows: the run passes over it, and the estimate does not \
             know; a smaller `--h` tells",
            number(*acts.first()?),
            number(*acts.last()?)
        ))
    }
}

impl<'a> Solve<'a> {
    fn new(args: &'a Args) -> Result<Self, Failure> {
        let (name, problem) = args.problem.build(None)?;
        // A column of that name would be read as another.
        if let Some(name) = component_names(&*problem).into_iter().find(|name| ERRORS.contains(&&**name)) {
            return Err(Failure::Column(name));
        }
        let method = with_tolerances(args::method(&args.method)?, problem.initial().len(), args)?;
        let limited = |steps| method.limited(steps).ok_or_else(|| Failure::NoTolerances(method.name()));
        let method = args.max_steps.map(limited).transpose()?.unwrap_or(method);
        // Before anything is written, as is the check of the grid.
        method.build(&*problem)?;
        let h = match args.h {
            Some(h) => h,
            // As long as it likes; an interval of length 0 has no steps.
            None if method.traits().is_adaptive => {
                if args.t_end > 0.0 {
                    args.t_end
                } else {
                    1.0
                }
            }
            None => return Err(Failure::NoStepSize(method.name())),
        };
        let overclaim = args::method_file(&args.method)?.and_then(|file| args::overclaim(&args.method, &file));
        let solve = Self { args, name, has_exact: problem.exact(0.0).is_some(), problem, method, h, overclaim };
        Grid::new(0.0, h, args.t_end).map_err(|error| solve.unstarted(error.into()))?;
        let steps = args.t_end / h;
        if steps > MANY {
            let text = format!("{} steps of h = {} are to be taken; end them with Ctrl-C", number(steps), plain(h));
            let _ = paragraph(&mut io::stderr(), "warning: ", 9, &text);
        }
        Ok(solve)
    }

    /// The failure of a run that came to the state `v`, its largest component having been `largest`.
    fn failed(&self, source: RunError, v: &[f64], largest: f64) -> Failure {
        let known = breakdown(&*self.problem, &*self.method, self.args.t_end).map(|known| known.reason.to_owned());
        let told = || stopped::told(&*self.problem, &*self.method, &source, (v, largest));
        let reason = known.or_else(told);
        let Traits { order, stability, .. } = self.method.traits();
        let breakdown = match self.overclaim.clone() {
            // No step mends it.
            Some(wrong) if order == 0 || stability == Stability::Unstable => Some(wrong),
            // An order that is too low is no reason to break off.
            Some(wrong) => Some(reason.map_or_else(|| wrong.clone(), |reason| format!("{reason}; {wrong}"))),
            None => reason,
        };
        Failure::Run { problem: self.name.as_str().into(), method: self.method.name().into(), source, breakdown }
    }

    /// The failure of a run that did not start.
    fn unstarted(&self, source: RunError) -> Failure {
        let initial = self.problem.initial();
        self.failed(source, &initial, max_norm(&initial))
    }

    /// Column names: `t`, the components, `error`, `estimate`.
    fn columns(&self) -> Vec<String> {
        let errors = ERRORS.into_iter().zip([self.has_exact, !self.args.no_estimate]);
        let errors = errors.filter(|(_, is_shown)| *is_shown).map(|(name, _)| name.to_owned());
        ["t".to_owned()].into_iter().chain(component_names(&*self.problem)).chain(errors).collect()
    }

    /// Integrates and hands every row to `observe`, until that breaks or fails.
    fn follow(&self, mut observe: impl FnMut(Row) -> io::Result<ControlFlow<()>>) -> Result<Summary, Stop> {
        let is_model = self.problem.facts().model.is_some();
        let course = Course { is_long: !is_model, ..Course::default() };
        let mut summary = Summary { course, ..Summary::default() };
        let mut io = Ok(());
        let mut progress = Progress::new(self.args);
        let forcing = || Forcing::new(&*self.problem, self.method.order(), self.args.t_end);
        let mut forcing = (!self.args.no_estimate).then(forcing);
        let estimator = || Estimator::new(&*self.problem, &*self.method, self.h, self.args.t_end);
        let mut estimator = (!self.args.no_estimate).then(estimator).transpose();
        let mut estimator = estimator.as_mut().map_err(|error| Stop::Failed(self.unstarted(error.clone())))?.as_mut();
        let solved = run_while(&*self.problem, &*self.method, self.h, self.args.t_end, |state| {
            progress.reach(state.t);
            let values = self.problem.observe(state.t, &state.q);
            let error = self.problem.exact(state.t).map(|exact| distance(&values, &exact));
            let estimate = estimator.as_mut().and_then(|estimator| {
                let difference = distance(&values, &self.problem.observe(state.t, estimator.at(state.t)?));
                estimator.error(difference, max_norm(&values))
            });
            if summary.unestimated.is_none() {
                let failure = estimator.as_ref().and_then(|estimator| estimator.failure());
                summary.unestimated = failure.map(|why| (state.t, why.to_string()));
            }
            summary.add(state.t, max_norm(&values), error, estimate);
            if let Some(forcing) = &mut forcing {
                forcing.add(state.t, &state.q);
            }
            summary.beside.add(state.t, &values, estimate);
            summary.course.add(state.t, &state.q);
            let has_ended = self.has_exact && error.is_none();
            let row = beware::Row { t: state.t, state: &state.q, estimate, has_ended };
            summary.watch.add(&*self.problem, &*self.method, row);
            let errors = [error, estimate];
            let shown = usize::from(!self.has_exact)..1 + usize::from(estimator.is_some());
            observe(Row { t: state.t, values: &values, errors: &errors[shown] }).unwrap_or_else(|error| {
                io = Err(error);
                ControlFlow::Break(())
            })
        });
        io.map_err(Stop::Io)?;
        let failed = |source| Stop::Failed(self.failed(source, summary.watch.past.ends().1, summary.size));
        let run = solved.map_err(failed)?;
        summary.effort = self.problem.solver().map(|_| (self.rate(&run.end), run.work.factorizations));
        summary.settling = estimator.as_ref().and_then(|it| it.settling(&*self.problem, &*self.method, &run.end));
        // Where both tolerances lead to the same steps there is no difference.
        let estimate = summary.estimate.map_or(0.0, |(estimate, _)| estimate);
        let is_adaptive = self.method.traits().is_adaptive;
        summary.unseen = forcing.and_then(|forcing| forcing.unresolved(is_adaptive, estimate, summary.size));
        Ok(summary)
    }

    /// The largest component of f.
    fn rate(&self, state: &State) -> f64 {
        let field = self.problem.field();
        let mut f = vec![0.0; field.dim()];
        field.rhs(state.t, &state.q, &mut f);
        max_norm(&f)
    }

    fn show(&self, out: &mut Output) -> Result<(), Failure> {
        let mut table = Table::new(self.columns(), component_names(&*self.problem).len());
        let result = self.follow(|row| {
            table.push(row);
            Ok(ControlFlow::Continue(()))
        });
        // The rows up to a failure tell where it came from.
        table.write(out).map_err(Failure::Output)?;
        let summary = result.map_err(|stop| stop.at(Failure::Output))?;
        writeln!(out, "{summary}{}", self.changes(&summary)).map_err(Failure::Output)?;
        out.flush().map_err(Failure::Output)?;
        self.warn(&summary);
        Ok(())
    }

    /// What became of energy, angular momentum and the like, a line each.
    fn changes(&self, summary: &Summary) -> String {
        let (first, last) = summary.watch.past.ends();
        let line = |quantity: &Invariant| {
            let (before, after) = (quantity.value(first), quantity.value(last));
            let change = match before {
                0.0 => format!("change {}", number(after)),
                _ => format!("relative change {}", number(after / before - 1.0)),
            };
            format!("\n{} {} at t = 0, {change}", quantity.name, number(before))
        };
        self.problem.quantities().iter().map(line).collect()
    }

    /// Says on standard error what the rows do not, and returns it as comment lines.
    fn warn(&self, summary: &Summary) -> String {
        let is_adaptive = self.method.traits().is_adaptive;
        let (mut warnings, broken) = summary.watch.warnings(&*self.problem, &*self.method);
        if !is_adaptive {
            let off = || summary.watch.past.off(&*self.problem, &*self.method, self.h, summary.estimate?.0);
            warnings.extend(summary.watch.past.amplified(&*self.problem, &*self.method).or_else(off));
        }
        // What the nodes make of f is a reason to look, and rows that another run comes to are right for all that.
        let is_refuted = |unseen: &Unseen| summary.beside.is_met(&*self.problem, &unseen.places);
        let unseen = summary.unseen.as_ref().filter(|unseen| !is_refuted(unseen)).map(|unseen| unseen.text.clone());
        // Where f is not seen, another solution with half the step is no news, and being small is no reason.
        let is_seen = unseen.is_none();
        let of_estimate = || summary.unresolved(is_adaptive).or_else(|| summary.watch.leap().filter(|_| !is_adaptive));
        warnings.extend(unseen.or_else(of_estimate));
        let default = [DEFAULT_ATOL];
        let atol = if self.args.atol.is_empty() { &default[..] } else { &self.args.atol };
        if is_adaptive && warnings.is_empty() {
            warnings.extend(summary.beyond((self.args.rtol.unwrap_or(DEFAULT_RTOL), atol)));
        }
        if is_adaptive && is_seen {
            // With a tenth of the tolerances it is small too.
            let is_small = summary.estimate.is_none_or(|(estimate, _)| estimate < atol.iter().copied().largest());
            warnings.extend(summary.watch.below(atol).filter(|_| is_small));
        }
        // What has a reason of its own needs no other solver.
        if warnings.is_empty() {
            warnings.extend(summary.beside.told(&*self.problem, &*self.method));
        }
        // Rows of a wrong method are off the slopes of the equation everywhere.
        if warnings.is_empty() && self.overclaim.is_none() {
            warnings.extend(summary.course.passed_over(&*self.problem, &summary.beside));
        }
        warnings.extend(broken);
        warnings.extend(self.overclaim.clone());
        warnings.extend(summary.unestimated.as_ref().map(|(from, why)| {
            format!(
                "the estimate ends early, and what rows from t = {} on are off by is not known: the finer run fails: {why}",
                plain(*from)
            )
        }));
        for text in &warnings {
            // Nobody can be told where standard error is closed.
            let _ = paragraph(&mut io::stderr(), "warning: ", 9, text);
        }
        // Errors of a linear equation fall by their order however large they are.
        let largest = summary.estimate.filter(|_| !self.problem.field().is_linear());
        // A warning says more than that.
        let settling = summary.settling.filter(|_| warnings.is_empty());
        let coarse = settling.and_then(|settling| coarse(settling, largest, summary.size));
        let notes: Vec<String> = coarse.into_iter().chain(self.limits()).collect();
        for text in &notes {
            let _ = paragraph(&mut io::stderr(), "note: ", 6, text);
        }
        warnings.iter().chain(&notes).map(|text| format!("# {text}\n")).collect()
    }

    /// What is not looked at on a large model.
    fn limits(&self) -> Option<String> {
        let n = self.problem.ode().dim();
        (n > equation::DENSE && self.problem.facts().model.is_some()).then(|| {
            format!(
                "of {n} unknowns, more than {}, no derivatives are looked at: steps that amplify or damp what the equation does not, rests \
                 where it is unstable, and linear invariants that are broken, but for the sum of all components, are not told{}",
                equation::DENSE,
                if n > beside::MOST { "; nor are errors that other solvers tell" } else { "" }
            )
        })
    }

    fn stream(&self, out: &mut Output) -> Result<(), Failure> {
        let mut csv = self.csv(out).map_err(Failure::Output)?;
        let result = self.follow(|row| {
            self.write_row(&mut csv, row)?;
            Ok(if csv.get_ref().is_closed() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
        });
        let out = csv.into_inner().map_err(|error| Failure::Output(error.into_error()))?;
        out.flush().map_err(Failure::Output)?;
        let summary = result.map_err(|stop| stop.at(Failure::Output))?;
        write!(out, "{}", self.warn(&summary)).map_err(Failure::Output)
    }

    fn write(&self, path: &Path, out: &mut Output) -> Result<(), Failure> {
        let unwritable = |source| Failure::Write { path: path.to_owned(), source };
        let mut csv = Replacement::create(path).and_then(|file| self.csv(file)).map_err(unwritable)?;
        let summary = self
            .follow(|row| self.write_row(&mut csv, row).map(ControlFlow::Continue))
            .map_err(|stop| stop.at(unwritable))?;
        let mut file = csv.into_inner().map_err(|error| unwritable(error.into_error()))?;
        let comments = self.warn(&summary);
        file.write_all(comments.as_bytes()).map_err(unwritable)?;
        file.commit().map_err(unwritable)?;
        let changes = self.changes(&summary);
        writeln!(out, "{} rows written to {}\n{summary}{changes}", summary.rows, path.display())
            .map_err(Failure::Output)
    }

    fn csv<W: Write>(&self, writer: W) -> io::Result<csv::Writer<W>> {
        let mut csv = csv::WriterBuilder::new().has_headers(false).from_writer(writer);
        csv.write_record(self.columns())?;
        Ok(csv)
    }

    fn write_row<W: Write>(&self, csv: &mut csv::Writer<W>, Row { t, values, errors }: Row) -> io::Result<()> {
        Ok(csv.serialize((t, values, errors))?)
    }
}

/// That the estimate is coarse, where its order does not show, or where the `largest` one, at its time, would with twice the step be larger than the
/// solution: two solutions of a nonlinear equation that are so far apart differ by no order, and what shows at the end is chance.
fn coarse(settling: Settling, largest: Option<(f64, f64)>, size: f64) -> Option<String> {
    let found = match settling.observed {
        Some(_) if settling.is_settled() => {
            let (estimate, t) = largest?;
            let doubled = settling.order.exp2() * estimate;
            (doubled > size).then(|| {
                format!(
                    "at t = {} it is {}, and with 2h an error of its order is {}, where no row is above {}",
                    plain(t),
                    number(estimate),
                    number(doubled),
                    number(size)
                )
            })?
        }
        Some(observed) => format!("at the end runs with 2h, h and h/2 differ by order {}", decimals(observed, 1)),
        None => "at the end a run with 2h fails".into(),
    };
    Some(format!(
        "the estimate is coarse: {found}, and it is taken with order {}; it may be more than twice the error or less than half of it, and a smaller \
         `--h` tells",
        trimmed(settling.order, 3)
    ))
}

/// How far a long run has come, on standard error if that is a terminal.
struct Progress {
    t_end: f64,
    begun: Instant,
    /// After a while; never where rows appear on the same terminal.
    bar: Option<ProgressBar>,
    is_shown: bool,
}

impl Progress {
    const PATIENCE: Duration = Duration::from_secs(1);
    const POSITIONS: f64 = 1000.0;

    fn new(args: &Args) -> Self {
        let is_shown = args.csv.as_ref().is_none_or(|path| path.as_os_str() != "-");
        Self { t_end: args.t_end, begun: Instant::now(), bar: None, is_shown }
    }

    fn reach(&mut self, t: f64) {
        if !self.is_shown || self.begun.elapsed() < Self::PATIENCE {
            return;
        }
        let bar = self.bar.get_or_insert_with(|| {
            let style = ProgressStyle::with_template("{bar:40} t = {msg}, {elapsed} gone, {eta} to go");
            ProgressBar::new(Self::POSITIONS as u64)
                .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
                .with_elapsed(self.begun.elapsed())
        });
        bar.set_message(plain(t));
        bar.set_position((Self::POSITIONS * t / self.t_end) as u64);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// The method with the tolerances that were given, for a problem with `components`.
fn with_tolerances(method: Box<dyn Method>, components: usize, args: &Args) -> Result<Box<dyn Method>, Failure> {
    if args.rtol.is_none() && args.atol.is_empty() && !args.strict {
        return Ok(method);
    }
    let atol = if args.atol.is_empty() { vec![DEFAULT_ATOL] } else { args.atol.clone() };
    if ![1, components].contains(&atol.len()) {
        let (expected, found) = (components, atol.len());
        return Err(Failure::Tolerance(InputError::System(SystemError::Dimension { what: "--atol", expected, found })));
    }
    let tolerances = Tolerances::new(args.rtol.unwrap_or(DEFAULT_RTOL), 0.0).and_then(|t| t.with_atol(atol));
    let tolerances = tolerances.map(|tolerances| if args.strict { tolerances.strict() } else { tolerances });
    method.with_tolerances(tolerances.map_err(Failure::Tolerance)?).ok_or_else(|| Failure::NoTolerances(method.name()))
}

/// Why the rows ended early.
enum Stop {
    Io(io::Error),
    Failed(Failure),
}

impl Stop {
    /// The failure, where `io` says what could not be written.
    fn at(self, io: impl FnOnce(io::Error) -> Failure) -> Failure {
        match self {
            Self::Io(error) => io(error),
            Self::Failed(failure) => failure,
        }
    }
}

impl Summary {
    /// What is to be said where the finer run gives another solution: past a pole, in chaos, or where the steps resolve nothing.
    fn unresolved(&self, is_adaptive: bool) -> Option<String> {
        let (estimate, t) = self.estimate.filter(|(estimate, _)| *estimate > MEANINGLESS * self.size)?;
        let [finer, smaller] = if is_adaptive {
            [
                "a tenth of the tolerances",
                "smaller tolerances tell, or `--h`, the longest step, where f acts for a moment",
            ]
        } else {
            ["half the step", "a smaller `--h` tells"]
        };
        Some(format!(
            "at t = {} the error is estimated as {}, where no row is above {}: with {finer} it is another solution. It may be unresolved, or \
             sensitive, or have ended before, as in a pole; {smaller}",
            plain(t),
            number(estimate),
            number(self.size)
        ))
    }

    /// What is to be said of an adaptive run that the tolerances do not hold.
    fn beyond(&self, (rtol, atol): (f64, &[f64])) -> Option<String> {
        let steps = self.rows.saturating_sub(1);
        let allowed = steps as f64 * (atol.iter().copied().largest() + rtol * self.size);
        let (estimate, t) = self.estimate.filter(|(estimate, _)| *estimate > FAR * allowed)?;
        Some(format!(
            "at t = {} the error is estimated as {}, {:.0} times what the tolerances allow in all {} together: steps may pass over what f does for \
             a moment, which `--h` limits, f may have kinks, which `--strict` looks at, or disturbances grow along the solution, which smaller \
             tolerances tell",
            plain(t),
            number(estimate),
            estimate / allowed,
            counted(steps, "step")
        ))
    }

    fn add(&mut self, t: f64, size: f64, error: Option<f64>, estimate: Option<f64>) {
        self.rows += 1;
        self.t = t;
        self.size = larger(self.size, size);
        for (largest, found) in [(&mut self.error, error), (&mut self.estimate, estimate)] {
            if let Some(found) = found.filter(|found| largest.is_none_or(|(largest, _)| *found > largest)) {
                *largest = Some((found, t));
            }
        }
    }
}

impl std::fmt::Display for Summary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} to t = {}", counted(self.rows - 1, "step"), plain(self.t))?;
        match self.error {
            Some((error, t)) => write!(f, "; largest error {} at t = {}", number(error), plain(t)),
            None => write!(f, "; no exact solution is known"),
        }?;
        match self.estimate {
            Some((estimate, t)) => write!(f, "\nlargest estimate {} at t = {}", number(estimate), plain(t)),
            None => Ok(()),
        }?;
        match self.effort {
            Some((rate, systems)) => {
                let plural = if systems == 1 { "" } else { "s" };
                write!(f, "\n|f| = {} at the end; {systems} linear system{plural} solved", number(rate))
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_estimate_whose_order_does_not_show_is_called_coarse() {
        let told = |observed| coarse(Settling { observed, order: 2.0 }, Some((0.24, 3.0)), 1.0);
        assert_eq!(told(Some(2.3)), None);
        let words = |observed, words: &str| told(observed).is_some_and(|text| text.contains(words));
        assert!(words(Some(0.31), "runs with 2h, h and h/2 differ by order 0.3, and it is taken with order 2;"));
        assert!(words(None, "a run with 2h fails"));
        assert_eq!(coarse(Settling { observed: Some(2.3), order: 2.0 }, Some((0.0, 3.0)), 0.0), None, "it is at rest");
        // An error of second order is four times as large with twice the step.
        let far = coarse(Settling { observed: Some(2.3), order: 2.0 }, Some((0.26, 3.0)), 1.0);
        assert!(far.is_some_and(|text| {
            text.contains("at t = 3 it is 0.260000, and with 2h an error of its order is 1.04000")
        }));
    }

    /// Three quarters of the way to t = 4; nothing before the first second.
    #[test]
    fn the_bar_is_at_the_part_of_the_time_that_is_done_after_a_while() {
        let begun = Instant::now();
        let long_ago = begun.checked_sub(2 * Progress::PATIENCE).expect("the clock has run for two seconds");
        for (begun, is_shown, position) in [(long_ago, true, Some(750)), (begun, true, None), (long_ago, false, None)] {
            let mut progress = Progress { t_end: 4.0, begun, bar: None, is_shown };
            progress.reach(3.0);
            assert_eq!(progress.bar.as_ref().map(ProgressBar::position), position);
            let bar = progress.bar.clone();
            drop(progress);
            assert!(bar.is_none_or(|bar| bar.is_finished()), "it is gone with the run");
        }
    }

    /// Of ten steps; the largest of several absolute tolerances counts.
    #[test]
    fn errors_are_beyond_the_tolerances_a_hundred_times_those_of_all_steps() {
        let said = |estimate: f64, atol: &[f64]| {
            let summary = Summary { rows: 11, size: 2.0, estimate: Some((estimate, 1.0)), ..Summary::default() };
            summary.beyond((1e-6, atol)).is_some()
        };
        let allowed = |atol: f64| 10.0 * (atol + 2e-6);
        assert_eq!([0.99, 1.01].map(|part| said(part * FAR * allowed(1e-5), &[1e-9, 1e-5])), [false, true]);
        assert_eq!([0.99, 1.01].map(|part| said(part * FAR * allowed(0.0), &[0.0])), [false, true]);
    }

    /// A request as the command line has it.
    #[derive(clap::Parser)]
    struct Asked {
        #[command(flatten)]
        args: Args,
    }

    fn asked(problem: [&str; 2]) -> Args {
        let words = ["solve", problem[0], problem[1], "--method", "rk4", "--h", "0.25", "--t-end", "1"];
        <Asked as clap::Parser>::try_parse_from(words).expect("it makes sense").args
    }

    fn file(text: &str) -> tempfile::NamedTempFile {
        let file = tempfile::NamedTempFile::with_suffix(".ds").expect("a file");
        std::fs::write(file.path(), text).expect("writable");
        file
    }

    #[test]
    fn a_course_is_kept_of_small_systems_and_not_too_many_rows() {
        let kept = |n: usize, rows: usize, is_long: bool| {
            let mut course = Course { is_long, ..Course::default() };
            (0..rows).for_each(|k| course.add(k as f64, &vec![0.0; n]));
            assert_eq!(course.times.len(), course.states.len());
            (course.is_long, course.times.len())
        };
        assert_eq!([1, equation::DENSE].map(|n| kept(n, 2, false)), [(false, 2); 2]);
        assert_eq!(kept(equation::DENSE + 1, 2, false), (true, 0));
        assert_eq!([0, 1].map(|more| kept(1, Course::ROWS + more, false)), [(false, 4096), (true, 4096)]);
        assert_eq!(kept(1, 2, true), (true, 0), "it was of no model from the start");
    }

    #[test]
    fn a_course_is_kept_of_models_alone_and_an_error_of_exact_solutions() {
        let model = file("u_i { x = 1 } F_i { -x }");
        let model = model.path().to_str().expect("UTF-8");
        for (problem, kept, errors) in
            [(["--model", model], (false, 5), 1), (["--problem", "linear-drag"], (true, 0), 2)]
        {
            let args = asked(problem);
            let followed = Solve::new(&args).expect("it makes sense").follow(|row| {
                assert_eq!(row.errors.len(), errors, "{problem:?}");
                Ok(ControlFlow::Continue(()))
            });
            let course = followed.ok().expect("it runs").course;
            assert_eq!((course.is_long, course.times.len()), kept, "{problem:?}");
        }
    }

    /// A clock comes by its place at t = 0.53, between rows; what f does there is left to y, or is undone at once.
    #[test]
    fn what_acts_between_rows_is_told_where_something_comes_of_it() {
        let told = |rate: &str, rows: u32| {
            let model = file(&format!("u_i {{ x = 0, y = 1 }} F_i {{ 1, {rate} }}"));
            let problem = verify::problem::model::Model::load(model.path(), &[], None).expect("a model");
            let (mut course, mut beside) = (Course::default(), Beside::default());
            for t in (0..=rows).map(|k| f64::from(k) / f64::from(rows)) {
                course.add(t, &[t, 1.0]);
                beside.add(t, &[t, 1.0], Some(0.0));
            }
            course.passed_over(&problem, &beside)
        };
        let (first, second) =
            ("heaviside(x - 0.53)*heaviside(0.5305 - x)", "heaviside(x - 0.5305)*heaviside(0.531 - x)");
        let left = told(&format!("10*{first}"), 4);
        assert!(left.as_ref().is_some_and(|text| text.starts_with("from t = 0.53")), "{left:?}");
        // From the first to the last; of few rows two would be too many.
        let twice = told(&format!("10*{first} + 10*heaviside(x - 0.83)*heaviside(0.8305 - x)"), 64).expect("two");
        assert!(twice.starts_with("from t = 0.53") && twice.contains(" to t = 0.83"), "{twice}");
        assert_eq!(told(&format!("{first} - {second}"), 4), None);
    }

    /// Of a flow that is driven by a force of t, which is another one at the start.
    #[test]
    fn the_rate_at_the_end_is_that_of_the_time_there() {
        let words =
            "solve --problem cavity-manufactured --set cells=8 --method method-i --h 0.5 --t-end 1 --no-estimate";
        let args = <Asked as clap::Parser>::try_parse_from(words.split(' ')).expect("it makes sense").args;
        let solve = Solve::new(&args).expect("it makes sense");
        let summary = solve.follow(|_| Ok(ControlFlow::Continue(()))).ok().expect("it runs");
        let end = summary.watch.past.ends().1;
        let largest = |t: f64| {
            let mut f = vec![0.0; end.len()];
            solve.problem.field().rhs(t, end, &mut f);
            max_norm(&f)
        };
        let (rate, _) = summary.effort.expect("of a flow");
        assert!((rate - largest(1.0)).abs() < 1e-12 && (rate - 0.011_457_0).abs() < 5e-8, "{rate}");
        assert!((rate - largest(0.0)).abs() > 1e-3, "{rate}");
    }

    #[test]
    fn what_is_not_looked_at_is_told_of_large_models() {
        let limits = |n: usize| {
            let entries = |entry: &str| vec![entry; n].join(", ");
            let model = file(&format!("u_i {{ {} }} F_i {{ {} }}", entries("1"), entries("1")));
            let args = asked(["--model", model.path().to_str().expect("UTF-8")]);
            Solve::new(&args).expect("it makes sense").limits()
        };
        assert_eq!(limits(equation::DENSE), None);
        assert!(limits(equation::DENSE + 1).is_some_and(|text| text.starts_with("of 65 unknowns, more than 64, ")));
    }

    #[test]
    fn the_first_of_equal_errors_is_the_largest_and_none_of_nothing() {
        let mut summary = Summary::default();
        for (t, error) in [(0.0, 0.1), (1.0, 0.3), (2.0, 0.3), (3.0, 0.2)] {
            summary.add(t, 1.0, Some(error), Some(2.0 * error));
        }
        assert_eq!((summary.error, summary.estimate), (Some((0.3, 1.0)), Some((0.6, 1.0))));
        let rest = Summary { rows: 11, estimate: Some((0.0, 1.0)), ..Summary::default() };
        assert_eq!((rest.unresolved(false), rest.beyond((1e-6, &[0.0][..]))), (None, None));
    }
}
