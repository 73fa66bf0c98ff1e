//! Arguments that several subcommands share.

use clap::Args;
use verify::names::NameError;
use verify::problems::{self, Problem};

/// A problem and its parameters.
#[derive(Debug, Args)]
pub(super) struct ProblemArgs {
    /// Name of the problem; `verify list problems` shows all
    #[arg(long = "problem", value_name = "P")]
    pub(super) name: String,

    /// Set a parameter of the problem; repeatable
    #[arg(long, value_name = "NAME=VALUE", value_parser = assignment, allow_hyphen_values = true)]
    set: Vec<(String, String)>,
}

impl ProblemArgs {
    pub(super) fn build(&self) -> Result<Box<dyn Problem>, NameError> {
        problems::build(&self.name, &self.set)
    }
}

fn assignment(text: &str) -> Result<(String, String), String> {
    let (name, value) = text.split_once('=').ok_or("expected name=value")?;
    Ok((name.trim().to_owned(), value.trim().to_owned()))
}
