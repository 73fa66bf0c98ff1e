//! The instrumented copy of a workspace, without the mutants that do not compile.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde::Deserialize;

use crate::instrument::{Instrumented, instrument};
use crate::list::{Genre, Mutant};
use crate::{Failure, read};

/// A program of tests, and where it runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    pub file: PathBuf,
    pub directory: PathBuf,
}

/// A built copy.
#[derive(Debug)]
pub struct Built {
    pub tests: Vec<Program>,
    /// The mutants in it, by the first one of their place.
    pub places: HashMap<u32, u32>,
    pub unviable: HashSet<u32>,
}

pub fn build(packages: &[String], mutants: &[Mutant], tree: &Path, target: &Path) -> Result<Built, Failure> {
    copy(tree, &mutants.iter().map(|mutant| mutant.file.as_str()).collect())?;
    let mut files = BTreeMap::<&str, Vec<&Mutant>>::new();
    for mutant in mutants {
        files.entry(&mutant.file).or_default().push(mutant);
    }
    let roots: BTreeSet<&str> = files.keys().filter_map(|file| file.split("/src/").next()).collect();
    // A library, and a program of its own modules.
    let crates: Vec<_> =
        roots.iter().flat_map(|root| ["lib", "main"].map(|name| format!("{root}/src/{name}.rs"))).collect();
    for root in roots {
        write(&tree.join(root).join("src/schemata.rs"), include_str!("at.rs"))?;
    }
    // Those of an earlier run, so that what it built stays built where nothing has changed.
    let known = tree.with_file_name("unviable.txt");
    let names = fs::read_to_string(&known).unwrap_or_default();
    let names: HashSet<&str> = names.lines().collect();
    let known_before = mutants.iter().filter(|mutant| names.contains(mutant.name.as_str()));
    let mut unviable: HashSet<u32> = known_before.map(|mutant| mutant.id).collect();
    loop {
        let mut instrumented = HashMap::new();
        for (file, mutants) in &files {
            let left: Vec<_> = mutants.iter().filter(|mutant| !unviable.contains(&mutant.id)).copied().collect();
            let new = instrument(&fs::read_to_string(file)?, &left)?;
            write(&tree.join(file), &new.text)?;
            instrumented.insert(*file, new);
        }
        for name in crates.iter().filter(|name| Path::new(name).exists()) {
            let text = match instrumented.get(name.as_str()) {
                Some(new) => new.text.clone(),
                None => fs::read_to_string(name)?,
            };
            write(&tree.join(name), &(text + "\npub(crate) mod schemata;\n"))?;
        }
        let before = unviable.len();
        let errors = check(packages, tree, target)?;
        let blame = |span: &Span| instrumented.get(span.file_name.as_str())?.blame(span.byte_start);
        // Of a match that misses a pattern the compiler shows the head alone.
        let next_arm = |span: &Span| {
            let arms = |id: &u32| mutants[*id as usize - 1].genre == Genre::MatchArm;
            let places = instrumented.get(span.file_name.as_str())?.places.iter();
            let after = places.filter(|place| place.text.start > span.byte_start && place.mutants.iter().all(arms));
            after.min_by_key(|place| place.text.start).map(|place| &place.mutants[..])
        };
        for error in &errors {
            let blamed = error.spans.iter().find_map(blame).or_else(|| error.spans.iter().find_map(next_arm));
            unviable.extend(blamed.unwrap_or_default());
        }
        eprintln!("schemata: {} errors, {} of {} mutants do not compile", errors.len(), unviable.len(), mutants.len());
        if errors.is_empty() {
            let of =
                mutants.iter().filter(|mutant| unviable.contains(&mutant.id)).map(|mutant| mutant.name.clone() + "\n");
            fs::write(known, of.collect::<String>())?;
            let places = instrumented.values().flat_map(places).collect();
            return Ok(Built { tests: tests(packages, tree, target)?, places, unviable });
        }
        if unviable.len() == before {
            return Err(format!("errors outside of all mutants: {errors:?}").into());
        }
    }
}

fn places(instrumented: &Instrumented) -> impl Iterator<Item = (u32, u32)> {
    let ids = instrumented.places.iter().flat_map(|place| place.mutants.iter().map(|&id| (id, place.mutants[0])));
    ids.collect::<Vec<_>>().into_iter()
}

/// Writes a file where it differs, so that cargo sees what has changed.
fn write(path: &Path, text: &str) -> Result<(), Failure> {
    if fs::read_to_string(path).is_ok_and(|old| old == text) {
        return Ok(());
    }
    Ok(fs::write(path, text)?)
}

/// Copies what git tracks, but for files to be instrumented.
fn copy(tree: &Path, instrumented: &HashSet<&str>) -> Result<(), Failure> {
    let files = read(Command::new("git").args(["ls-files", "-z"]))?;
    for file in files.split_terminator('\0').filter(|file| !instrumented.contains(file)) {
        let to = tree.join(file);
        fs::create_dir_all(to.parent().unwrap_or(tree))?;
        if fs::read(&to).ok() != Some(fs::read(file)?) {
            fs::copy(file, to)?;
        }
    }
    for file in instrumented {
        fs::create_dir_all(tree.join(file).parent().unwrap_or(tree))?;
    }
    Ok(())
}

fn cargo(command: &str, packages: &[String], tree: &Path, target: &Path) -> Command {
    let mut cargo = Command::new("cargo");
    cargo.args([command, "--message-format", "json"]).current_dir(tree);
    cargo.args(packages.iter().flat_map(|package| ["--package", package]));
    cargo.env("CARGO_TARGET_DIR", target).env("RUSTFLAGS", "--cap-lints allow");
    cargo
}

#[derive(Debug, Deserialize)]
struct Line {
    message: Option<Message>,
    executable: Option<PathBuf>,
    manifest_path: Option<PathBuf>,
    profile: Option<Profile>,
}

#[derive(Debug, Deserialize)]
struct Profile {
    test: bool,
}

#[derive(Debug, Deserialize)]
struct Message {
    level: String,
    spans: Vec<Span>,
}

#[derive(Debug, Deserialize)]
struct Span {
    file_name: String,
    byte_start: usize,
    is_primary: bool,
    /// Of what a macro wrote.
    expansion: Option<Box<Expansion>>,
}

#[derive(Debug, Deserialize)]
struct Expansion {
    span: Span,
}

impl Span {
    /// The place in the source that it came from, if by way of macros.
    fn in_source(self) -> Self {
        match self.expansion {
            Some(expansion) => Self { is_primary: self.is_primary, ..expansion.span.in_source() },
            None => self,
        }
    }
}

fn lines(text: &str) -> impl Iterator<Item = Line> {
    text.lines().filter_map(|line| serde_json::from_str(line).ok())
}

/// The errors, each with its own places before those that it refers to.
fn check(packages: &[String], tree: &Path, target: &Path) -> Result<Vec<Message>, Failure> {
    let output = cargo("check", packages, tree, target).args(["--lib", "--bins"]).stderr(Stdio::null()).output()?;
    let text = String::from_utf8(output.stdout)?;
    let of_code = |message: &Message| message.level == "error" && !message.spans.is_empty();
    let mut errors: Vec<_> = lines(&text).filter_map(|line| line.message).filter(of_code).collect();
    for Message { spans, .. } in &mut errors {
        *spans = spans.drain(..).map(Span::in_source).collect();
        spans.sort_by_key(|span| !span.is_primary);
    }
    if errors.is_empty() && !output.status.success() {
        return Err("cargo check failed without an error in the code".into());
    }
    Ok(errors)
}

fn tests(packages: &[String], tree: &Path, target: &Path) -> Result<Vec<Program>, Failure> {
    let text = read(cargo("test", packages, tree, target).args(["--no-run", "--lib", "--tests"]))?;
    let tests = lines(&text).filter(|line| line.profile.as_ref().is_some_and(|profile| profile.test));
    let program = |line: Line| {
        let directory = line.manifest_path?.parent()?.to_owned();
        Some(Program { file: line.executable?, directory })
    };
    Ok(tests.filter_map(program).collect())
}
