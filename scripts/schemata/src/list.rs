//! The mutants of packages, as cargo-mutants lists them.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::process::Command;

use serde::Deserialize;

use crate::{Failure, read};

#[derive(Debug, Deserialize)]
pub struct Mutant {
    /// From 1 on, in the order of the list.
    #[serde(skip)]
    pub id: u32,
    /// Which of the changes of its function that are named alike it is, and how many there are.
    #[serde(skip)]
    place: (usize, usize),
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

impl Mutant {
    /// The name without the line and the column, which move with every edit.
    fn kind(&self) -> String {
        let kind = self.name.splitn(4, ':').nth(3).unwrap_or_default();
        format!("{}:{kind}", self.file)
    }

    /// Whether it is among `known` changes: by itself, as the function's second of three such in `… (2 of 3)`, or with all of its kind.
    pub fn is_among(&self, known: &HashSet<String>) -> bool {
        let (kind, (place, of)) = (self.kind(), self.place);
        known.contains(&format!("{kind} ({place} of {of})")) || known.contains(&kind)
    }
}

/// The changes that no test is to notice, of a file with a reason above each group of them.
pub fn known(file: &Path) -> Result<HashSet<String>, Failure> {
    if !file.exists() {
        return Ok(HashSet::new());
    }
    let text = std::fs::read_to_string(file)?;
    Ok(text.lines().filter(|line| !line.is_empty() && !line.starts_with('#')).map(str::to_string).collect())
}

pub fn mutants(packages: &[String], files: &[String]) -> Result<Vec<Mutant>, Failure> {
    let mut list = Command::new("cargo");
    list.args(["mutants", "--list", "--json"]);
    list.args(packages.iter().flat_map(|package| ["--package", package]));
    list.args(files.iter().flat_map(|file| ["--file", file]));
    let list = read(&mut list)?;
    let mut mutants: Vec<Mutant> = serde_json::from_str(&list)?;
    let mut alike = HashMap::<_, Vec<usize>>::new();
    for (i, mutant) in mutants.iter_mut().enumerate() {
        mutant.id = i as u32 + 1;
        alike.entry(mutant.kind()).or_default().push(i);
    }
    for alike in alike.into_values() {
        for (k, &i) in alike.iter().enumerate() {
            mutants[i].place = (k + 1, alike.len());
        }
    }
    Ok(mutants)
}
