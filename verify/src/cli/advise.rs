//! `advise`: which method to take, and with which step size.

use std::f64::consts::TAU;
use std::io::{self, Write};

use indicatif::{ProgressBar, ProgressStyle};
use lsvi::{SolveError, StepError};
use verify::advise::{Advice, Character, Growth, Refusal, Trial, advise, duration};
use verify::measure::norm::Extremes;
use verify::problem::component_names;
use verify::run::RunError;

use super::Status;
use super::args::{self, ProblemArgs};
use super::error::Failure;
use super::layout::{columns, counted, left, paragraph, plain, right, significant, width};
use super::output::Output;

/// Say what a system is like, and which method to take on it.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Methods of each family are run with ever shorter steps until their error, the
largest of a component at the ends of steps, in a large system at an irregular
choice of them, and of adaptive ones also between steps where f changes for
a moment, is within --accuracy of the largest component, or of 1 unless the
solution is so small that it would hardly move; the table shows it in absolute
terms. The errors are measured against an accurate run, and that against the
best trial with fixed steps, or against CVODE or diffsol where none of these
comes near, and against these again at the times of what is recommended. The
cheapest whose errors fall with the order of its method is recommended, with the
step size and the error that were found; where an error is small by chance, so
that those of shorter steps do not fall with the order, half the step is tried
too, and the tolerance after the one advised, a third of it, keeps the accuracy.
Work is counted in evaluations of f, a matrix as many as it has columns that
differ. A run is no trial if its rows go less than half as far from the start as
the solution does.

The tolerance of radau-adaptive in the table is the relative one. The absolute
one is the same number, or the relative one times the least amplitude that each
component, or of more than six any, has in a sixteenth of the time, whichever is
cheaper; in place of 1 it has the size of the solution where that is so small
that it would hardly move, or so large that no tolerance is met. Its steps are
not limited, or, where such steps pass over something, to 1/64 or 1/1024 of the
run, or to 1/8192 of it where f changes by itself for a moment.

Nothing is recommended where f is not finite at the start or its matrix is not
known, where the solution moves by less than the error asked for or ends before
the run does, where two accurate runs disagree or nothing confirms them, where
no method reaches the accuracy or the errors of none fall with its order, or
where two take the same work to a tenth; both commands are shown then. A run of
radau-adaptive that has tried eight times as many steps as any method may take
has failed, as where f jumps back and forth across a place.

Examples:
  verify advise --problem van-der-pol
  verify advise --problem burgers --accuracy 1e-3
  verify advise --model verify/models/predator-prey.ds --t-end 5

Exit status: 0 a method is recommended, 2 bad usage, 3 none is.")]
pub(super) struct Args {
    #[command(flatten)]
    problem: ProblemArgs,

    /// The error to reach
    #[arg(long, value_name = "ERROR", default_value_t = 1e-5, value_parser = accuracy)]
    accuracy: f64,

    /// End time; the default is that of the cross-checks, or later, when the
    /// direction of the motion has turned twice
    #[arg(long, value_name = "T", value_parser = args::positive, allow_hyphen_values = true)]
    t_end: Option<f64>,
}

/// What double precision can tell errors of.
fn accuracy(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if (1e-10..=0.1).contains(&x) => Ok(x),
        _ => Err("expected a number from 1e-10 to 0.1".into()),
    }
}

pub(super) fn run(options: &Args, out: &mut Output) -> Result<Status, Failure> {
    let horizon = options.t_end.filter(|_| options.problem.is_model());
    let (name, problem) = options.problem.build(horizon)?;
    let horizon = options.t_end.map_or_else(|| duration(&*problem), Ok)?;
    // Hidden where standard error is no terminal.
    let bar = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{elapsed} gone, now {msg}") {
        bar.set_style(style);
    }
    let advice = advise(&*problem, horizon, options.accuracy, &mut |tried| bar.set_message(tried.to_owned()))?;
    bar.finish_and_clear();
    let own = if options.t_end.is_some() { horizon } else { problem.horizon() };
    show((&name, &component_names(&*problem)), (horizon, own), options.accuracy, &advice, out)
        .and_then(|()| commands(&options.problem.options(), horizon, &advice, out))
        .and_then(|()| options.problem.write_caveat(out))
        .map_err(Failure::Output)?;
    Ok(if advice.recommended().is_some() { Status::Ok } else { Status::Inconclusive })
}

/// Where a text begins right of its label.
const INDENT: usize = 14;
/// Trials that are shown.
const SHOWN: usize = 6;
/// Small components that are named.
const LISTED: usize = 3;

/// Of a problem with components of these names, in a run to a horizon, which may be later than the problem's own.
fn show(
    (name, components): (&str, &[String]),
    (horizon, own): (f64, f64),
    accuracy: f64,
    advice: &Advice,
    out: &mut impl Write,
) -> io::Result<()> {
    let Advice { character, trials, uncertainty, refusal, .. } = advice;
    let (to, errors) = (plain(horizon), plain(accuracy));
    let absolute =
        if advice.target.is_nan() { String::new() } else { format!(", {} absolute", significant(advice.target, 2)) };
    // Less than that of a solution of size 1.
    let least = if advice.target < accuracy { "" } else { ", or to 1" };
    let about = format!(
        "{name}: {}, to t = {to}, for errors of {errors} relative to the largest component{least}{absolute}",
        counted(character.unknowns, "unknown")
    );
    paragraph(out, "", 0, &about)?;
    if !matches!(refusal, Some(Refusal::MatrixFree | Refusal::Start { .. })) {
        writeln!(out)?;
        if horizon > own {
            let text = "the run ends when the direction of the motion has turned twice; `--t-end` sets another end";
            paragraph(out, "duration", INDENT, text)?;
        }
        describe(character, horizon, out)?;
        let small: Vec<_> = character.within(advice.target).collect();
        if !(small.is_empty() || character.is_large() || matches!(refusal, Some(Refusal::Constant { .. }))) {
            let name = |k: &usize| match components.len() == character.unknowns {
                true => components[*k].clone(),
                false => format!("unknown {}", k + 1),
            };
            let mut names: Vec<String> = small.iter().map(name).collect();
            if names.len() > LISTED {
                names.splice(LISTED.., [format!("{} more", small.len() - LISTED)]);
            }
            let text = format!(
                "the largest value of {} is {}, within the error asked for, which may be all of it: a smaller `--accuracy` has its digits too",
                names.join(", "),
                significant(small.iter().map(|k| character.largest[*k]).largest(), 2),
            );
            paragraph(out, "small", INDENT, &text)?;
        }
    }
    if !trials.is_empty() {
        writeln!(out)?;
        row(["method", "steps", "h or tol", "abs. error", "evaluations"], out)?;
    }
    for Trial { method, setting, steps, error, cost, .. } in trials.iter().take(SHOWN) {
        let numbers = [steps.to_string(), significant(*setting, 3), significant(*error, 2), format!("{cost:.0}")];
        let [steps, setting, error, cost] = &numbers;
        row([method, steps, setting, error, cost], out)?;
    }
    writeln!(out)?;
    match (refusal, advice.recommended()) {
        (None, Some(trial)) => {
            let with = match &trial.atol {
                Some(_) => "the tolerances below".into(),
                None => format!("h = {}", significant(trial.setting, 3)),
            };
            let text = format!(
                "{} with {with}: in the trial its largest absolute error at {} was {}, measured to {}, for {:.0} evaluations{}.",
                trial.method,
                counted(trial.times.len(), "time"),
                significant(trial.error, 2),
                significant(*uncertainty, 1),
                trial.cost,
                advice.predictable().find(|next| next.method != trial.method).map_or_else(String::new, |next| format!(
                    ", {} times fewer than {}",
                    significant(next.cost / trial.cost, 2),
                    next.method
                ))
            );
            let text = text + &passed_over(&trials[0], *uncertainty);
            paragraph(out, "TAKE", INDENT, &text)
        }
        (Some(refusal @ Refusal::Lost(_)), _) if character.blows_up() => {
            let sizes = [character.sizes.0, character.sizes.1].map(|size| significant(size, 2));
            let text = format!(
                "the solution blows up: its largest component grows from {} to {} by t = {}; {refusal}.",
                sizes[0],
                sizes[1],
                significant(character.reached, 5)
            );
            paragraph(out, "NO ADVICE", INDENT, &text)
        }
        (Some(refusal), _) => {
            let has_no_derivative = matches!(
                refusal,
                Refusal::Lost(RunError::Step(StepError::Solve { source: SolveError::NonFiniteDerivative { .. }, .. }))
            );
            let way_on = if has_no_derivative {
                " An explicit method, as rk4, asks for no derivative; `verify solve` estimates its error."
            } else {
                ""
            };
            paragraph(out, "NO ADVICE", INDENT, &format!("{refusal}.{way_on}"))
        }
        (None, None) => Ok(()),
    }
}

/// Why the cheapest trial is not the one to take, where it is not.
fn passed_over(cheapest: &Trial, uncertainty: f64) -> String {
    cheapest.unpredictable(uncertainty).map_or_else(String::new, |(found, nominal)| {
        format!(
            " The errors of {} fall with order {found:.1} where it has {nominal}, so that none can be predicted.",
            cheapest.method
        )
    })
}

/// The command of what is recommended, or those of two that are as good.
fn commands(problem: &[[String; 2]], horizon: f64, advice: &Advice, out: &mut impl Write) -> io::Result<()> {
    match advice.recommended() {
        Some(trial) => command(problem, horizon, trial, out),
        // Either will do.
        None if matches!(advice.refusal, Some(Refusal::Tie { .. })) => {
            advice.predictable().take(2).try_for_each(|trial| command(problem, horizon, trial, out))
        }
        None => Ok(()),
    }
}

/// The command that makes the run of a trial again, broken as a shell reads it.
fn command(problem: &[[String; 2]], horizon: f64, trial: &Trial, out: &mut impl Write) -> io::Result<()> {
    let setting = match &trial.atol {
        Some(atol) => {
            let atol: Vec<String> = atol.iter().map(|atol| format!("{atol:e}")).collect();
            let tolerances = [["--rtol".to_owned(), format!("{:e}", trial.setting)], ["--atol".into(), atol.join(",")]];
            tolerances.into_iter().chain(trial.longest.map(|h| ["--h".into(), h.to_string()])).collect()
        }
        None => vec![["--h".into(), trial.setting.to_string()]],
    };
    let run = [["--method".to_owned(), trial.method.clone()], ["--t-end".into(), horizon.to_string()]];
    let mut line = format!("{}verify solve", left("RUN", INDENT));
    let with_value = |[option, value]: [String; 2]| format!(" {option} {}", shell_words::quote(&value));
    let options = problem.iter().cloned().chain(run).chain(setting).map(with_value);
    for pair in options.chain(trial.is_strict.then(|| " --strict".to_owned())) {
        if width(&line) + width(&pair) + 2 > columns() {
            writeln!(out, "{line} \\")?;
            line = format!("{} {pair}", left("", INDENT));
        } else {
            line += &pair;
        }
    }
    writeln!(out, "{line}")
}

/// A line of the table of trials.
fn row([method, steps, setting, error, cost]: [&str; 5], out: &mut impl Write) -> io::Result<()> {
    let cells = [right(steps, 7), right(setting, 12), right(error, 11), right(cost, 13)];
    writeln!(out, "{}{}", left(method, 26), cells.concat())
}

fn describe(character: &Character, horizon: f64, out: &mut impl Write) -> io::Result<()> {
    let growth = match &character.growth {
        Growth::Unseen => "not looked at".into(),
        Growth::Lost(error) => format!("not known, for a run that it takes fails: {error}"),
        Growth::Untold(factors) => format!(
            "not linear: disturbances of the start of 1e-6 and of 1e-7 are {} and {} times their size at the largest of the times looked at, which \
             differ, so that the larger one is no small one any more, as in chaos, beside a separatrix, or to a component that is small beside the largest; or f jumps",
            significant(factors[0], 2),
            significant(factors[1], 2)
        ),
        // What has decayed may be roundings.
        Growth::By(factor) if *factor <= 1.0 => {
            "a disturbance of the start, in one direction that was tried, has no larger component at any of the times looked at; in others it may grow".into()
        }
        Growth::By(factor) => format!(
            "the largest component of a disturbance of the start, in one direction that was tried, is {} times its size at the largest of the \
             times looked at; it may be more between them, or in another direction",
            significant(*factor, 2)
        ),
    };
    let neighbours = format!("{growth}; the largest component comes to {}", significant(character.sizes.1, 2));
    paragraph(out, "growth", INDENT, &neighbours)?;
    let Some(found) = &character.matrices else {
        let why = if character.is_large() {
            "not looked at: the system is large"
        } else {
            "not looked at: a Jacobian along the run is not finite or its eigenvalues are not found, or the mass matrix is not positive definite"
        };
        return paragraph(out, "structure", INDENT, why);
    };
    let least = (found.steps_of_rk4 * horizon).ceil();
    let stable = match least {
        0.0 => "no mode decays, so that rk4 is stable with any steps".into(),
        1.0 => "rk4 is stable with a single step".into(),
        _ => format!(
            "for what decays or turns at these times rk4 is stable with {} equal steps or more to the run",
            plain(least)
        ),
    };
    let speed = format!(
        "its fastest rate is {}, of {} looked at; {stable}",
        significant(found.fastest, 3),
        counted(found.instants, "time"),
    );
    paragraph(out, "stiffness", INDENT, &speed)?;
    // What turns at this rate has not come round once.
    if found.fastest > 0.0 && found.fastest * horizon < TAU {
        let part = significant(found.fastest * horizon / TAU, 2);
        let text = format!("short: the run is {part} of a turn at its fastest rate; `--t-end` sets a later end");
        paragraph(out, "duration", INDENT, &text)?;
    }
    let abscissas = format!(
        "(numerical abscissa {}, spectral {})",
        significant(found.numerical, 2),
        significant(found.spectral, 2)
    );
    if found.jumps {
        paragraph(
            out,
            "jumps",
            INDENT,
            "f jumps along the run, as friction and doses do: what is said of its structure holds between the jumps",
        )?;
    }
    let contraction = if found.is_contractive() {
        "contractive: the distance between solutions does not grow, in the Euclidean norm"
    } else if found.is_non_normal() {
        "non-normal: solutions may grow although no eigenvalue says so; Method I may amplify them"
    } else {
        "not contractive: some solutions part"
    };
    paragraph(out, "contraction", INDENT, &format!("{contraction} {abscissas}"))?;
    let symmetry = match (found.is_symmetric(), found.is_hamiltonian) {
        (true, _) => "symmetric: all eigenvalues are real".into(),
        (false, true) if found.jumps => "Hamiltonian between jumps of f, which need not keep the energy".to_owned(),
        (false, true) if found.is_autonomous => {
            "Hamiltonian: a symplectic method keeps its energy within bounds".to_owned()
        }
        (false, true) => "Hamiltonian at each time; f depends on t, so that there is no energy to keep".to_owned(),
        (false, false) => {
            format!(
                "neither symmetric nor Hamiltonian in these coordinates; asymmetry {}",
                significant(found.asymmetry, 2)
            )
        }
    };
    paragraph(out, "symmetry", INDENT, &symmetry)?;
    let by_method_i =
        if found.keeps_invariants { "and Method I" } else { "and Method I in the Euclidean metric need not" };
    let kept = |count: &str| format!("{count} linear: Runge–Kutta methods keep what is linear, {by_method_i}");
    let invariants = match found.invariants {
        0 => "none that is linear".into(),
        1 => kept("one"),
        n => kept(&n.to_string()),
    };
    paragraph(out, "invariants", INDENT, &invariants)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn why_the_cheapest_is_passed_over_is_said_where_it_is() {
        let problem = verify::problem::build("linear-drag", &[]).expect("registered");
        let advice = advise(&*problem, 1.0, 1e-3, &mut |_| {}).expect("registered");
        let trial = advice.trials.iter().find(|trial| trial.unpredictable(f64::NAN).is_some()).expect("a fixed step");
        let (_, nominal) = trial.unpredictable(f64::NAN).expect("of errors that are not known nothing is told");
        let text = passed_over(trial, f64::NAN);
        assert!(text.starts_with(&format!(" The errors of {} fall with order ", trial.method)), "{text}");
        assert!(text.ends_with(&format!(" where it has {nominal}, so that none can be predicted.")), "{text}");
        assert_eq!(passed_over(trial, 0.0), "");
    }

    /// Not beside one whose error is not predicted, however cheap.
    #[test]
    fn the_advised_is_set_beside_the_next_that_is_predicted() {
        let problem = verify::problem::build("linear-drag", &[]).expect("registered");
        let mut advice = advise(&*problem, 1.0, 1e-3, &mut |_| {}).expect("registered");
        let [_, second, third] = &mut advice.trials[..3] else { panic!("three methods reach it") };
        (second.falls, third.falls) = (Some(verify::advise::Falls { errors: [1e-4, 1e-4], nominal: 2 }), None);
        let (passed, next) = [&*second, &*third].map(|trial| trial.method.clone()).into();
        (advice.trials[0].falls, advice.refusal) = (None, None);
        let mut out = Vec::new();
        show(("linear-drag", &[]), (1.0, 1.0), 1e-3, &advice, &mut out).expect("written");
        let text = String::from_utf8(out).expect("UTF-8").split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            text.contains(&format!("times fewer than {next}.")) && !text.contains(&format!("fewer than {passed}")),
            "{text}"
        );
    }

    /// In lines that a terminal shows whole and a shell reads as one.
    #[test]
    fn a_trial_is_made_again_by_the_command_that_is_shown() {
        let problem = verify::problem::build("linear-drag", &[]).expect("registered");
        let mut advice = advise(&*problem, 1.0, 1e-3, &mut |_| {}).expect("registered");
        let trial = advice.trials.first_mut().expect("some method reaches it");
        (trial.method, trial.setting) = ("radau-adaptive".into(), 3.16e-5);
        trial.atol = Some(vec![1.23e-5, 4.56e-14]);
        let mut out = Vec::new();
        let problem = [["--problem".into(), "linear-drag".into()], ["--set".into(), "v0=1".into()]];
        command(&problem, 0.1, trial, &mut out).expect("written");
        let text = String::from_utf8(out).expect("UTF-8");
        assert!(text.lines().all(|line| width(line) <= columns()), "{text}");
        let breaks = text.lines().count() - 1;
        assert!(breaks > 0 && text.matches(" \\\n").count() == breaks, "{text}");
        let text = text.replace("\\\n", "");
        let words = shell_words::split(&text).expect("as a shell reads it");
        let options: Vec<_> = words[3..].chunks(2).map(|pair| (&*pair[0], &*pair[1])).collect();
        let tolerances = [("--rtol", "3.16e-5"), ("--atol", "1.23e-5,4.56e-14")];
        let run = [("--problem", "linear-drag"), ("--set", "v0=1"), ("--method", "radau-adaptive"), ("--t-end", "0.1")];
        assert_eq!(options, [&run[..], &tolerances].concat(), "{text}");
        trial.is_strict = true;
        let mut out = Vec::new();
        command(&[], 0.1, trial, &mut out).expect("written");
        let text = String::from_utf8(out).expect("UTF-8").replace("\\\n", "");
        assert_eq!(shell_words::split(&text).expect("as a shell reads it").last().expect("words"), "--strict");
        trial.is_strict = false;
        // Of fixed steps, of a model whose name has a space.
        (trial.method, trial.setting, trial.atol) = ("path-fitted(4,gauss)".into(), 1.0 / 48.0, None);
        let mut out = Vec::new();
        command(&[["--model".into(), "my model.ds".into()]], 1.0, trial, &mut out).expect("written");
        let words = shell_words::split(&String::from_utf8(out).expect("UTF-8").replace("\\\n", "")).expect("a line");
        let run = ["--model", "my model.ds", "--method", "path-fitted(4,gauss)", "--t-end", "1", "--h"];
        let (h, before) = words[3..].split_last().expect("words");
        assert_eq!(before, run);
        assert_eq!(h.parse(), Ok(1.0 / 48.0));
    }

    #[test]
    fn a_command_is_shown_of_what_is_recommended_and_of_both_in_a_tie() {
        let problem = verify::problem::build("linear-drag", &[]).expect("registered");
        let mut advice = advise(&*problem, 1.0, 1e-3, &mut |_| {}).expect("registered");
        assert!(advice.predictable().count() > 2);
        let tie = Refusal::Tie { first: "rk4".into(), second: "heun2".into() };
        for (refusal, count) in [(None, 1), (Some(tie), 2), (Some(Refusal::OutOfReach { accuracy: 1e-3, most: 4 }), 0)]
        {
            advice.refusal = refusal;
            let mut out = Vec::new();
            commands(&[], 1.0, &advice, &mut out).expect("written");
            let text = String::from_utf8(out).expect("UTF-8");
            assert_eq!(text.matches("verify solve").count(), count, "{text}");
        }
    }

    /// Of any length of an option, and of some to the last column.
    #[test]
    fn a_line_of_a_command_is_as_long_as_the_terminal_is_wide_and_no_longer() {
        let problem = verify::problem::build("linear-drag", &[]).expect("registered");
        let advice = advise(&*problem, 1.0, 1e-3, &mut |_| {}).expect("registered");
        let longest = |value: usize| {
            let mut out = Vec::new();
            command(&[["--model".into(), "x".repeat(value)]], 1.0, &advice.trials[0], &mut out).expect("written");
            let text = String::from_utf8(out).expect("UTF-8");
            text.lines().filter(|line| line.ends_with('\\')).map(width).max()
        };
        // An option that takes up a line of its own begins two columns right of the label.
        let most = columns() - INDENT - "  --model ".len() - " \\".len();
        assert_eq!((1..=most).filter_map(longest).max(), Some(columns()));
        // It stands behind the command as long as there is room.
        let beside = most - "verify solve".len() + 1;
        let lines = |value: usize| {
            let mut out = Vec::new();
            command(&[["--model".into(), "x".repeat(value)]], 1.0, &advice.trials[0], &mut out).expect("written");
            String::from_utf8(out).expect("UTF-8").lines().next().map(width)
        };
        assert_eq!([beside, beside + 1].map(lines), [Some(columns()), Some(INDENT + "verify solve \\".len())]);
    }

    #[test]
    fn steps_with_which_a_method_is_stable_are_told_by_their_number() {
        let problem = verify::problem::build("linear-drag", &[]).expect("registered");
        let mut character = advise(&*problem, 1.0, 1e-3, &mut |_| {}).expect("registered").character;
        for (steps, text) in [
            (0.0, "no mode decays, so that rk4 is stable with any steps"),
            (0.7, "rk4 is stable with a single step"),
            (1.2, "rk4 is stable with 2 equal steps or more to the run"),
        ] {
            character.matrices.as_mut().expect("a small system").steps_of_rk4 = steps;
            let mut out = Vec::new();
            describe(&character, 1.0, &mut out).expect("written");
            let told = String::from_utf8(out).expect("UTF-8").split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(told.contains(text), "{told}");
        }
    }

    /// What is neither symmetric nor keeps an energy is told for what it is.
    #[test]
    fn hamiltonian_systems_keep_an_energy_where_f_neither_jumps_nor_depends_on_time() {
        let problem = verify::problem::build("linear-drag", &[]).expect("registered");
        let mut character = advise(&*problem, 1.0, 1e-3, &mut |_| {}).expect("registered").character;
        for (is_hamiltonian, jumps, is_autonomous, text) in [
            (true, false, true, "Hamiltonian: a symplectic method keeps its energy within bounds"),
            (true, false, false, "Hamiltonian at each time; f depends on t, so that there is no energy to keep"),
            (true, true, true, "Hamiltonian between jumps of f, which need not keep the energy"),
            (false, false, true, "neither symmetric nor Hamiltonian"),
        ] {
            let found = character.matrices.as_mut().expect("a small system");
            (found.asymmetry, found.is_hamiltonian, found.jumps, found.is_autonomous) =
                (1.0, is_hamiltonian, jumps, is_autonomous);
            let mut out = Vec::new();
            describe(&character, 1.0, &mut out).expect("written");
            let told = String::from_utf8(out).expect("UTF-8").split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(told.contains(text), "{told}");
        }
    }

    /// Errors are relative to 1 unless the solution is so small that they are less than was asked for.
    #[test]
    fn what_errors_are_relative_to_is_told() {
        let problem = verify::problem::build("linear-drag", &[]).expect("registered");
        let mut advice = advise(&*problem, 1.0, 1e-3, &mut |_| {}).expect("registered");
        for (target, or_one) in [(5e-4, false), (1e-3, true), (2e-3, true), (f64::NAN, true)] {
            advice.target = target;
            let mut out = Vec::new();
            show(("drag", &[]), (1.0, 1.0), 1e-3, &advice, &mut out).expect("written");
            let told = String::from_utf8(out).expect("UTF-8").split_whitespace().collect::<Vec<_>>().join(" ");
            assert_eq!(told.contains("relative to the largest component, or to 1"), or_one, "{told}");
        }
    }

    /// Three of them, and how many more; one that is zero throughout has no digits.
    #[test]
    fn components_within_the_error_asked_for_are_named() {
        let problem = verify::problem::build("linear-drag", &[]).expect("registered");
        let mut advice = advise(&*problem, 1.0, 1e-3, &mut |_| {}).expect("registered");
        let names = ["a", "b", "c", "d", "e", "f"].map(str::to_owned);
        let mut told = |largest: [f64; 6], names: &[String], refusal: Option<Refusal>| {
            (advice.target, advice.refusal) = (1e-3, refusal);
            (advice.character.unknowns, advice.character.largest) = (6, largest.to_vec());
            let mut out = Vec::new();
            show(("drag", names), (1.0, 1.0), 1e-3, &advice, &mut out).expect("written");
            let text = String::from_utf8(out).expect("UTF-8").split_whitespace().collect::<Vec<_>>().join(" ");
            text.split_once("small ").map(|(_, told)| told.split(" within").next().unwrap_or_default().to_owned())
        };
        let some = [1.0, 1e-3, 0.0, 2e-4, 1e-4, 1e-5];
        assert_eq!(told(some, &names, None).as_deref(), Some("the largest value of b, d, e, 1 more is 0.0010,"));
        let two = [1.0, 1.1e-3, 0.0, 2e-4, 1.0, 1e-5];
        // What is observed may be no unknown.
        assert_eq!(
            told(two, &names[..3], None).as_deref(),
            Some("the largest value of unknown 4, unknown 6 is 2.0e-4,")
        );
        assert_eq!(told([1.0, 1.1e-3, 0.0, 1.0, 1.0, f64::NAN], &names, None), None);
        assert_eq!(told(some, &names, Some(Refusal::Constant { moved: 1e-4, target: 1e-3 })), None);
    }

    /// With its step or its tolerances, its error and what that was measured to, and how much dearer the next is.
    #[test]
    fn what_is_advised_is_told_beside_the_next() {
        let problem = verify::problem::build("linear-drag", &[]).expect("registered");
        let mut advice = advise(&*problem, 1.0, 1e-3, &mut |_| {}).expect("registered");
        let trial = |method: &str, atol: Option<Vec<f64>>, cost: f64| Trial {
            method: method.into(),
            setting: 0.125,
            atol,
            longest: None,
            is_strict: false,
            steps: 8,
            error: 1.5e-6,
            times: vec![1.0; 8],
            cost,
            falls: None,
        };
        advice.trials = vec![trial("rk4", None, 40.0), trial("radau-adaptive", Some(vec![1e-6]), 100.0)];
        (advice.uncertainty, advice.refusal) = (2e-8, None);
        let told = |advice: &Advice, own: f64| {
            let mut out = Vec::new();
            show(("drag", &[]), (1.0, own), 1e-3, advice, &mut out).expect("written");
            String::from_utf8(out).expect("UTF-8").split_whitespace().collect::<Vec<_>>().join(" ")
        };
        let limited = Trial { longest: Some(0.0625), ..trial("radau-adaptive", Some(vec![1e-6]), 100.0) };
        let mut run = Vec::new();
        command(&[], 1.0, &limited, &mut run).expect("written");
        let run = String::from_utf8(run).expect("UTF-8");
        assert!(run.contains("--h 0.0625") && run.contains("--rtol 1.25e-1"), "{run}");
        let text = told(&advice, 1.0);
        let taken = "TAKE rk4 with h = 0.125: in the trial its largest absolute error at 8 times was 1.5e-6, measured to 2e-8, for \
                     40 evaluations, 2.5 times fewer than radau-adaptive.";
        assert!(text.contains(taken), "{text}");
        assert!(text.contains("evaluations rk4 8 0.125 1.5e-6 40 radau-adaptive 8 0.125 1.5e-6 100"), "{text}");
        // Not beside the same method at another step.
        advice.trials.insert(1, trial("rk4", None, 60.0));
        assert!(told(&advice, 1.0).contains(taken));
        advice.trials.remove(1);
        assert_eq!([1.0, 0.5].map(|own| told(&advice, own).contains("has turned twice")), [false, true]);
        // Of a run of 1; at rest nothing turns.
        for (fastest, is_short) in [(0.0, false), (0.3, true), (0.95, true), (1.05, false)] {
            advice.character.matrices.as_mut().expect("a small system").fastest = fastest * TAU;
            let text = told(&advice, 1.0);
            let short = format!("short: the run is {} of a turn at its fastest rate", significant(fastest, 2));
            assert_eq!((text.contains(&short), text.contains("short: ")), (is_short, is_short), "{text}");
        }
        advice.character.matrices.as_mut().expect("a small system").fastest = 0.2 * TAU;
        let mut out = Vec::new();
        describe(&advice.character, 2.0, &mut out).expect("written");
        assert!(String::from_utf8(out).expect("UTF-8").contains("the run is 0.40 of a turn"));
        advice.trials.remove(0);
        let text = told(&advice, 1.0);
        assert!(text.contains("TAKE radau-adaptive with the tolerances below: in the trial"), "{text}");
    }
}
