//! The mutants of a package, as cargo-mutants lists them.

use std::process::Command;

use serde::Deserialize;

use crate::{Failure, read};

#[derive(Debug, Deserialize)]
pub struct Mutant {
    /// From 1 on, in the order of the list.
    #[serde(skip)]
    pub id: u32,
    pub name: String,
    pub file: String,
    pub genre: Genre,
    pub replacement: String,
    pub span: Span,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize)]
pub enum Genre {
    FnValue,
    BinaryOperator,
    UnaryOperator,
    MatchArm,
    MatchArmGuard,
    StructField,
}

#[derive(Debug, Deserialize)]
pub struct Span {
    pub start: Position,
}

/// Lines and columns from 1 on, in characters.
#[derive(Debug, Deserialize)]
pub struct Position {
    pub line: usize,
    pub column: usize,
}

pub fn mutants(package: &str, files: &[String]) -> Result<Vec<Mutant>, Failure> {
    let mut list = Command::new("cargo");
    list.args(["mutants", "--list", "--json", "--package", package]);
    list.args(files.iter().flat_map(|file| ["--file", file]));
    let list = read(&mut list)?;
    let mut mutants: Vec<Mutant> = serde_json::from_str(&list)?;
    for (i, mutant) in mutants.iter_mut().enumerate() {
        mutant.id = i as u32 + 1;
    }
    Ok(mutants)
}
