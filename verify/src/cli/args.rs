//! Arguments that several subcommands share.

use std::io;
use std::path::{Path, PathBuf};

use clap::Args;
use verify::judge::FileMethod;
use verify::judge::file::MethodFile;
use verify::method::{self, Method};
use verify::problem::model::{CAVEAT, Model};
use verify::problem::{self, Problem};

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

/// The method that `text` names, or that the file `text` holds: a text with a slash or a file's ending is a path.
pub(super) fn method(text: &str) -> Result<Box<dyn Method>, Failure> {
    let path = Path::new(text);
    let is_file = text.contains('/') || (path.extension().is_some() && !text.contains('('));
    Ok(if is_file { Box::new(FileMethod::of(&MethodFile::load(path)?)) } else { method::parse(text)? })
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err("expected a positive number".into()),
    }
}

pub(super) fn assignment(text: &str) -> Result<(String, String), String> {
    let (name, value) = text.split_once('=').ok_or("expected name=value")?;
    Ok((name.trim().to_owned(), value.trim().to_owned()))
}
