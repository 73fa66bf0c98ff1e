//! What can go wrong, the exit status that says so, and a hint at the remedy.

use std::io;
use std::path::PathBuf;

use lsvi::{InputError, SettingError, SolveError, StepError, TimeError};
use verify::bench::BenchError;
use verify::chapter;
use verify::golden::GoldenError;
use verify::judge::file::FileError;
use verify::measure::refinement::data::DataError;
use verify::method::BuildError;
use verify::names::NameError;
use verify::order::OrderError;
use verify::problem::model::ModelError;
use verify::program::ProgramError;
use verify::reference::ReferenceError;
use verify::report::{ComparisonError, PartError, ReportError};
use verify::run::RunError;

/// Why a command did not run to its end.
#[derive(Debug, thiserror::Error)]
pub(super) enum Failure {
    #[error(transparent)]
    Name(#[from] NameError),
    #[error(transparent)]
    Model(#[from] ModelError),
    #[error(transparent)]
    MethodFile(#[from] FileError),
    #[error("{problem} by {method}: {source}")]
    Run {
        problem: Box<str>,
        method: Box<str>,
        source: RunError,
        /// Why the method cannot succeed on the problem, where that is known.
        breakdown: Option<String>,
    },
    #[error(transparent)]
    Build(#[from] BuildError),
    #[error("`{0}` is set twice")]
    Repeated(String),
    #[error("a component has the name `{0}`, which is that of a column of `solve`")]
    Column(String),
    #[error("{0} needs a step size")]
    NoStepSize(String),
    #[error(transparent)]
    Tolerance(InputError),
    #[error("{0} takes steps of one size and no tolerance")]
    NoTolerances(String),
    #[error(transparent)]
    Order(#[from] OrderError),
    #[error(transparent)]
    Report(#[from] ReportError),
    #[error(transparent)]
    Comparison(#[from] ComparisonError),
    #[error(transparent)]
    Part(#[from] PartError),
    #[error(transparent)]
    Golden(#[from] GoldenError),
    #[error(transparent)]
    Bench(#[from] BenchError),
    #[error("cannot write {}: {source}", path.display())]
    Table { path: PathBuf, source: csv::Error },
    #[error("cannot read {}: {source}", path.display())]
    Read { path: PathBuf, source: io::Error },
    #[error("{}: {source}", path.display())]
    Data { path: PathBuf, source: Box<DataError> },
    #[error(transparent)]
    Command(ProgramError),
    #[error("the program, with {at}: {source}")]
    Program { at: String, source: ProgramError },
    #[error("{option}: `{value}`, where {wanted} are expected")]
    Value { option: &'static str, value: String, wanted: &'static str },
    /// An option, and what it needs beside it.
    #[error("{0} needs {1}")]
    Incomplete(&'static str, &'static str),
    #[error("cannot write {}: {source}", path.display())]
    Write { path: PathBuf, source: io::Error },
    #[error("cannot write to standard output: {0}")]
    Output(#[source] io::Error),
}

impl Failure {
    /// Exit status: 2 where the command asks for something that does not exist or cannot be written, 1 where it was tried and failed, 3 where a
    /// judgement was asked for and nothing can be judged. `golden` is like diff(1), where 1 says that files differ and 2 that they
    /// could not be compared.
    pub(super) fn status(&self) -> u8 {
        match self {
            // A program that cannot be started, or speaks another language, is a mistake of the command line.
            Self::Program { source, .. } if !source.is_of_every_run() => 3,
            Self::Order(OrderError::Reference(error)) if !matches!(error, ReferenceError::Unavailable(_)) => 3,
            Self::Order(OrderError::Untold { .. }) => 3,
            Self::Program { .. } | Self::Order(OrderError::Program { .. } | OrderError::Reference(_)) => 2,
            Self::Name(_)
            | Self::Model(_)
            | Self::MethodFile(_)
            | Self::Build(_)
            | Self::Repeated(_)
            | Self::Column(_)
            | Self::NoStepSize(_)
            | Self::Read { .. }
            | Self::Data { .. }
            | Self::Incomplete(..)
            | Self::Command(_)
            | Self::Value { .. }
            | Self::NoTolerances(_)
            | Self::Tolerance(_)
            | Self::Run { source: RunError::Build(_) | RunError::Input(_), .. }
            | Self::Order(OrderError::NoExact | OrderError::Adaptive(_) | OrderError::Coarsest { .. } | OrderError::TooManySteps { .. })
            | Self::Comparison(_)
            | Self::Part(_)
            // What cannot be written says nothing of what was computed.
            | Self::Report(_)
            | Self::Output(_)
            | Self::Write { .. }
            | Self::Table { .. }
            | Self::Golden(_) => 2,
            _ => 1,
        }
    }

    pub(super) fn hint(&self) -> Option<String> {
        let text = match self {
            Self::Name(error) => return name_hint(error),
            Self::Run { source: RunError::Step(_) | RunError::NonFinite(_), breakdown: Some(reason), .. } => reason,
            Self::Build(_) | Self::Run { source: RunError::Build(_), .. } => {
                "`verify list methods` says what each method is for; `method-i` takes every first-order system"
            }
            Self::MethodFile(FileError::Malformed { hint, .. }) => return hint.clone(),
            Self::Model(ModelError::Compile(_)) => {
                "the language is described at https://martinjrobins.github.io/diffsl"
            }
            Self::Model(ModelError::GaveUp { .. }) => {
                "a model states its inputs, its state at t = 0 and f once each, as in_i { mu = 1 } u_i { x = 2, y = 0 } F_i \
                 { y, -mu * x }; https://martinjrobins.github.io/diffsl has the language"
            }
            Self::Comparison(ComparisonError::Schema { .. }) => "write it again with this version: `verify report`",
            Self::Comparison(ComparisonError::Malformed { .. }) => "`--compare` takes the results.json of a report",
            Self::Data { source, .. } if matches!(&**source, DataError::Number { text, .. } if !text.contains(',')) => {
                "`--quantity COLUMN` leaves out the columns that hold no numbers"
            }
            Self::Data { source, .. } if matches!(**source, DataError::NoSpacing { .. }) => {
                "`--step COLUMN` names the one with the spacing of the grid or the time step; `--cells COLUMN --dimension D` the one \
                 with numbers of cells"
            }
            Self::Column(_) => {
                "rename it in the model: `error` and `estimate` are columns beside those of the components"
            }
            Self::NoStepSize(_) => "for example `--h 0.1`",
            Self::NoTolerances(_) => "`radau-adaptive` is adaptive",
            Self::Tolerance(InputError::Setting(SettingError::RelativeTolerance { .. })) => {
                "for example `--rtol 1e-8`; for an absolute error alone, `--rtol 1e-14` beside a larger `--atol`"
            }
            Self::Tolerance(_) => {
                "for example `--atol 1e-10`, `--atol 0` for relative accuracy alone, or one number for each component"
            }
            Self::Run { source, .. } => return run_hint(source).map(str::to_owned),
            Self::Command(error)
            | Self::Program { source: error, .. }
            | Self::Order(OrderError::Program { source: error, .. }) => {
                return program_hint(error).map(str::to_owned);
            }
            Self::Order(OrderError::Coarsest { .. }) => {
                "steps divide the time; `--t-end`, for a model or a program, makes it longer"
            }
            Self::Order(OrderError::Reference(ReferenceError::Solver { .. })) => {
                "the solution may end there, as in a pole, where for a model or a program `--t-end` stays before it, or f have no finite derivative, \
                 as sqrt(x) has none at x = 0, where `--reference diffsol` may go on"
            }
            Self::Order(OrderError::NoExact) => "`--reference cvode` or `--reference diffsol`",
            Self::Order(OrderError::Reference(ReferenceError::Unavailable(_))) => {
                "build with the feature `cvode`, or use `--reference diffsol`"
            }
            _ => return None,
        };
        Some(text.into())
    }
}

fn program_hint(error: &ProgramError) -> Option<&'static str> {
    match error {
        ProgramError::Start { .. } => Some(
            "the first word of the command is a program on the PATH, or a path like ./rk4; for a script name what runs it: \
             'python3 mine.py'",
        ),
        ProgramError::Column { .. } => Some(
            "the header has `t` and the columns that `--quantity` names, or else the components of the problem, which `verify list \
             problems` shows; `verify solve --problem NAME --method rk4 --h 0.1 --t-end 1 --csv -` writes an example",
        ),
        _ => None,
    }
}

fn name_hint(error: &NameError) -> Option<String> {
    match error {
        NameError::Unknown { kind: "parameter", .. } => {
            Some("`verify list problems` shows the parameters of each problem".into())
        }
        NameError::Unknown { kind: "method", .. } => Some(
            "`verify list methods` and `verify list method-files` show the names; a file of your own has a slash or an ending: \
             ./mine.toml"
                .into(),
        ),
        NameError::Unknown { kind: "study", name, .. } if name == chapter::model::ID => {
            Some("that chapter is on a model: `--model FILE` names it".into())
        }
        NameError::Unknown { kind: kind @ ("problem" | "reference" | "study" | "golden"), .. } => {
            Some(format!("`verify list` shows every {kind}"))
        }
        NameError::Value { .. } => Some("`verify list problems` says what a parameter means".into()),
        _ => None,
    }
}

fn run_hint(error: &RunError) -> Option<&'static str> {
    match error {
        RunError::Input(InputError::Time(TimeError::StepSize(_))) => Some("for example `--h 0.1`"),
        RunError::Input(InputError::Time(TimeError::EndTime { .. })) => {
            Some("runs start at t = 0; for example `--t-end 10`")
        }
        RunError::Input(InputError::Time(TimeError::Unresolvable { .. })) => Some("use a larger `--h`"),
        RunError::Step(StepError::Solve { source: SolveError::Singular, .. }) => {
            Some("no step size helps; another method may: `verify list methods`")
        }
        RunError::Step(StepError::TooManySteps { .. }) => Some(
            "`--max-steps` allows more; if they lead nowhere, f may jump back and forth, as about a threshold that the solution cannot leave, \
             where a change over a short distance or a hysteresis helps, or a component has lost its sign within `--atol`",
        ),
        RunError::Step(StepError::StepUnderflow { .. }) => Some(
            "the solution may end there, by itself or because a component lost its sign within the tolerance, where a \
                 smaller `--atol` helps; with `--atol 0` a component that is 0 may not be off at all; else a larger `--rtol` may help",
        ),
        RunError::Step(StepError::Solve {
            source: SolveError::BranchLost { .. } | SolveError::OtherBranch, ..
        }) => Some("a smaller `--h` may help, unless the solution ends there, as in a pole, or f jumps there"),
        RunError::Step(StepError::Solve { source: SolveError::NotLinear { .. }, .. }) => {
            Some("the problem declares what it is not; that is a mistake in the problem")
        }
        RunError::Step(StepError::Solve { source: SolveError::Linear { .. }, .. }) => Some(
            "another method may do; a smaller `--h` helps where the step, and not the equation, makes the system hard",
        ),
        RunError::Step(StepError::Solve { t: 0.0, source: SolveError::NonFinite, .. }) => Some(
            "where f or a derivative of it is NaN or infinite at the start, as of log(x) or sqrt(x) at x = 0, no step helps; elsewhere a shorter \
             one may",
        ),
        RunError::Step(StepError::Solve { h: 0.0, source: SolveError::NonFinite, .. }) => {
            Some("the run has come to where f is not defined, as sqrt(x) below x = 0; the solution may end before")
        }
        RunError::Step(StepError::Solve { source: SolveError::NonFiniteDerivative { .. }, .. }) => Some(
            "f has no finite derivative at the state of that step, as sqrt(x) has none at x = 0; an explicit method, as rk4, asks for none",
        ),
        RunError::Step(_) | RunError::NonFinite(_) => {
            Some("a smaller `--h` may help, unless the solution ends there, as in a pole")
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use verify::reference::ReferenceError;

    use super::*;

    fn data(source: DataError) -> Failure {
        Failure::Data { path: "drag.csv".into(), source: Box::new(source) }
    }

    /// What a build without CVODE cannot do was asked for in vain; what a solver stops at leaves a judgement open.
    #[test]
    fn a_reference_that_is_missing_is_bad_input_and_one_that_stops_is_none() {
        let of = |error: ReferenceError| Failure::Order(OrderError::Reference(error));
        let missing = of(ReferenceError::Unavailable("cvode-bdf"));
        let stopped = of(ReferenceError::Solver { solver: "cvode-bdf", t: 1.0, reason: "a pole".into() });
        assert_eq!([&missing, &stopped].map(Failure::status), [2, 3]);
        assert!(missing.hint().is_some_and(|hint| hint.contains("`--reference diffsol`")));
        assert!(stopped.hint().is_some_and(|hint| hint.contains("`--t-end` stays before it")));
    }

    #[test]
    fn a_column_of_spacings_is_asked_for_where_none_is_known() {
        let hint = data(DataError::NoSpacing { known: "there are h and u".into() }).hint();
        assert!(hint.is_some_and(|hint| hint.contains("`--step COLUMN`")));
        assert_eq!(data(DataError::Ambiguous("u".into())).hint(), None);
    }

    #[test]
    fn steps_that_fail_for_different_reasons_have_different_hints() {
        for (source, hint) in [
            (SolveError::Linear { iterations: 100, residual: 0.1 }, "another method may do"),
            (SolveError::NotLinear { row: 0, difference: 0.1 }, "a mistake in the problem"),
            (SolveError::BranchLost { reached: 0.05 }, "or f jumps there"),
            (SolveError::OtherBranch, "or f jumps there"),
        ] {
            let error = RunError::Step(StepError::Solve { t: 0.0, h: 0.1, source });
            assert!(run_hint(&error).is_some_and(|told| told.contains(hint)), "{error}: {hint}");
        }
    }
}
