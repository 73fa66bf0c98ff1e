//! Arguments that several subcommands share.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use verify::judge::FileMethod;
use verify::judge::file::{MethodFile, SHIPPED, Shipped};
use verify::method::{self, Method};
use verify::names::NameError;
use verify::problem::model::{CAVEAT, Model};
use verify::problem::{self, Problem};
use verify::program::{self, Program};
use verify::replacement;

use super::error::Failure;
use super::layout::paragraph;
use super::output::Output;

/// A problem or a model, and its parameters.
#[derive(Debug, Args)]
pub(super) struct ProblemArgs {
    /// Name of the problem; `verify list problems` shows all
    #[arg(long = "problem", value_name = "P")]
    name: Option<String>,

    /// A first-order system of your own in DiffSL instead
    #[arg(long, value_name = "FILE", conflicts_with = "name")]
    model: Option<PathBuf>,

    /// Set a parameter, or an input of the model; repeatable
    #[arg(long, value_name = "NAME=VALUE", value_parser = assignment, allow_hyphen_values = true)]
    set: Vec<(String, String)>,
}

impl ProblemArgs {
    /// The problem and its name; measurements on a model end at `horizon`.
    pub(super) fn build(&self, horizon: Option<f64>) -> Result<(String, Box<dyn Problem>), Failure> {
        let repeated =
            |(k, (name, _)): &(usize, &(String, String))| self.set[..*k].iter().any(|(earlier, _)| earlier == name);
        if let Some((_, (name, _))) = self.set.iter().enumerate().find(repeated) {
            return Err(Failure::Repeated(name.clone()));
        }
        if let Some(path) = &self.model {
            let model = Model::load(path, &self.set, horizon)?;
            return Ok((model.name().into(), Box::new(model)));
        }
        let Some(name) = self.name.clone() else {
            return Err(Failure::Incomplete("the command", "--problem NAME or --model FILE"));
        };
        let problem = problem::build(&name, &self.set)?;
        Ok((name, problem))
    }

    /// The name of the problem, if it is one by name.
    pub(super) fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// The options that were given, each with its value.
    pub(super) fn options(&self) -> Vec<[String; 2]> {
        let model = self.model.iter().map(|path| ("--model", path.display().to_string()));
        let name = self.name.iter().map(|name| ("--problem", name.clone()));
        let set = self.set.iter().map(|(name, value)| ("--set", format!("{name}={value}")));
        model.chain(name).chain(set).map(|(option, value)| [option.to_owned(), value]).collect()
    }

    /// Whether it is a model.
    pub(super) fn is_model(&self) -> bool {
        self.model.is_some()
    }

    /// The parameters.
    pub(super) fn set(&self) -> &[(String, String)] {
        &self.set
    }

    /// Says below a judgement that a model has no second source.
    pub(super) fn write_caveat(&self, out: &mut Output) -> io::Result<()> {
        match self.model {
            Some(_) => paragraph(out, "\nNote: ", 6, CAVEAT),
            None => Ok(()),
        }
    }
}

/// The method that `text` names, or that the file `text` holds.
pub(super) fn method(text: &str) -> Result<Box<dyn Method>, Failure> {
    Ok(match method_file(text)? {
        Some(file) => Box::new(FileMethod::of(&file)),
        None => method::parse(text)?,
    })
}

/// What is to be said where the file `text` claims another order than its runs have, or is of a method that is not zero-stable.
pub(super) fn overclaim(text: &str, file: &MethodFile) -> Option<String> {
    let method = FileMethod::of(file);
    let order = || {
        let claimed = file.order()?;
        Some(format!("claims order {claimed}, and {}", method.refutes(claimed)?))
    };
    let divergent = method.diverges().map(|what| format!("is {what}"));
    Some(format!("{text} {}: `verify judge {text}` says why", divergent.or_else(order)?))
}

/// The file that `text` is the path of, a text with a slash or a file's ending; or that comes along by that name, where no method
/// has it.
pub(super) fn method_file(text: &str) -> Result<Option<MethodFile>, Failure> {
    let path = Path::new(text);
    let is_file = text.contains('/') || (path.extension().is_some() && !text.contains('('));
    match (is_file, method::parse(text)) {
        (_, Err(NameError::Unknown { .. })) if Shipped::by_name(text).is_ok() => {
            Ok(Some(Shipped::by_name(text)?.read()?))
        }
        (true, _) => Ok(Some(MethodFile::load(path)?)),
        // The nearest name of both lists.
        (false, Err(NameError::Unknown { kind: "method", name, suggestion: None })) => {
            let error = NameError::unknown("method", &name, SHIPPED.iter().map(|file| file.name));
            Err(error.into())
        }
        _ => Ok(None),
    }
}

/// The program that `command` runs.
pub(super) fn program(command: &str, seconds: u64) -> Result<Program, Failure> {
    Program::new(command, Duration::from_secs(seconds)).map_err(Failure::Command)
}

/// Lets this process, interrupted, take along what it has started and what it has not written to the end.
pub(super) fn clean_up_when_interrupted() {
    let interrupted = || {
        program::end_all();
        let _nothing_more = replacement::discard_all();
        // As a shell reports a process that ended by SIGINT.
        std::process::exit(130);
    };
    // Without a handler, interrupted programs run to their end.
    let _ = ctrlc::set_handler(interrupted);
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err("expected a positive number".into()),
    }
}

pub(super) fn part(text: &str) -> Result<f64, String> {
    positive(text).ok().filter(|x| *x < 1.0).ok_or_else(|| "expected a number between 0 and 1".into())
}

pub(super) fn finite(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| "expected a finite number".into())
}

pub(super) fn assignment(text: &str) -> Result<(String, String), String> {
    let (name, value) = text.split_once('=').ok_or("expected name=value")?;
    Ok((name.trim().to_owned(), value.trim().to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_of_a_problem_are_those_given() {
        let set = vec![("a".to_owned(), "1".to_owned()), ("b".to_owned(), "-2".to_owned())];
        let by_name = ProblemArgs { name: Some("kepler".into()), model: None, set: set.clone() };
        let of_file = ProblemArgs { name: None, model: Some("my.ds".into()), set };
        for (problem, first) in [(by_name, ["--problem", "kepler"]), (of_file, ["--model", "my.ds"])] {
            assert_eq!(problem.options(), [first, ["--set", "a=1"], ["--set", "b=-2"]]);
        }
    }

    /// What has a slash or an ending, but for the numbers of a method with parameters.
    #[test]
    fn a_path_is_read_as_a_file() {
        for path in ["./none", "none.toml"] {
            assert!(matches!(method_file(path), Err(Failure::MethodFile(_))), "{path}");
        }
        assert!(matches!(method_file("linear(-0.5,1)"), Ok(None)));
    }
}
