//! The directory of golden files: what is in it, what ought to be, and bringing the two together.

use crate::replacement::Replacement;

use super::{Change, Golden, GoldenError, Malformed, Row, compare, parse, render};
use std::collections::BTreeSet;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// insta's metadata of a snapshot kept as a `.csv` beside it.
const METADATA: &str = "---\nsource: verify/tests/evidence.rs\nextension: csv\nsnapshot_kind: binary\n---\n";

/// What became of one golden.
#[derive(Debug)]
pub enum Status {
    /// File and computation agree.
    Same,
    /// Rows differ.
    Changed(Vec<Change>),
    /// There is no file; the changes name its rows as new, and what is wrong with them.
    Missing(Vec<Change>),
    /// Some lines of the file cannot be read; the changes are those against the rest.
    Malformed(Vec<Malformed>, Vec<Change>),
    /// The rows could not be computed.
    Failed(String),
}

impl Status {
    /// Rows that differ.
    #[must_use]
    pub fn changes(&self) -> &[Change] {
        match self {
            Self::Changed(changes) | Self::Missing(changes) | Self::Malformed(_, changes) => changes,
            Self::Same | Self::Failed(_) => &[],
        }
    }

    /// Whether the computed rows may be frozen.
    #[must_use]
    pub fn is_fit(&self) -> bool {
        !matches!(self, Self::Failed(_)) && !self.changes().iter().any(|change| change.difference.is_wrong())
    }
}

/// The golden directory held against what the code computes now.
#[derive(Debug)]
pub struct Inspection {
    dir: PathBuf,
    goldens: Vec<Inspected>,
    strays: Vec<PathBuf>,
}

#[derive(Debug)]
struct Inspected {
    name: String,
    rows: Vec<Row>,
    status: Status,
}

/// Holds every one of these goldens against its file in `dir`, and looks at no other file.
///
/// # Errors
/// [`GoldenError`] for a bad or repeated name, or a file that the system does not let us read.
pub fn inspect(dir: &Path, goldens: &[Golden]) -> Result<Inspection, GoldenError> {
    let mut names = BTreeSet::new();
    let mut inspected = Vec::with_capacity(goldens.len());
    for golden in goldens {
        let name = golden.name.clone();
        if name.is_empty() || !name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-') {
            return Err(GoldenError::Name(name));
        }
        if !names.insert(name.clone()) {
            return Err(GoldenError::Duplicate(name));
        }
        let (rows, status) = match golden.rows() {
            Ok(rows) => {
                let status = status(dir, &name, &rows)?;
                (rows, status)
            }
            Err(error) => (Vec::new(), Status::Failed(error.to_string())),
        };
        inspected.push(Inspected { name, rows, status });
    }
    Ok(Inspection { dir: dir.to_owned(), goldens: inspected, strays: Vec::new() })
}

/// The files in `dir` that none of these goldens produces. Hidden files, folders and `README.md` belong there.
///
/// # Errors
/// [`GoldenError::Io`] if the directory cannot be read.
pub fn strays(dir: &Path, goldens: &[Golden]) -> Result<Vec<PathBuf>, GoldenError> {
    let expected: BTreeSet<String> = goldens.iter().flat_map(|golden| file_names(&golden.name)).collect();
    Ok(listing(dir)?.into_iter().filter(|file| !expected.contains(file)).map(|file| dir.join(file)).collect())
}

/// The golden directory of the workspace that contains `start`.
///
/// # Errors
/// [`GoldenError::NoWorkspace`] where there is none.
pub fn find_dir(start: &Path) -> Result<PathBuf, GoldenError> {
    start
        .ancestors()
        .find(|dir| fs::read_to_string(dir.join("Cargo.toml")).is_ok_and(|toml| toml.contains("[workspace]")))
        .map(|root| root.join("golden"))
        .ok_or_else(|| GoldenError::NoWorkspace(start.to_owned()))
}

impl Inspection {
    /// The same with files that belong to no golden, which make it unclean and which [`Self::apply`] removes.
    #[must_use]
    pub fn with_strays(self, strays: Vec<PathBuf>) -> Self {
        Self { strays, ..self }
    }

    /// Files that belong to no golden.
    pub fn strays(&self) -> &[PathBuf] {
        &self.strays
    }

    /// Name and status of every golden.
    pub fn statuses(&self) -> impl Iterator<Item = (&str, &Status)> {
        self.goldens.iter().map(|g| (g.name.as_str(), &g.status))
    }

    /// Whether every golden agrees with its file and no file is left over.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        self.strays.is_empty() && self.goldens.iter().all(|g| matches!(g.status, Status::Same))
    }

    /// Writes the goldens that differ, each by a temporary file and a rename, and removes strays. Goldens that are wrong
    /// ([`Status::is_fit`]) keep their old file. Returns what was done, a line each.
    ///
    /// # Errors
    /// [`GoldenError::Foreign`], before anything is touched, if a stray is no snapshot: `dir` may be another directory
    /// than was meant. [`GoldenError::Io`] at the first file that cannot be written or removed.
    pub fn apply(&self) -> Result<Vec<String>, GoldenError> {
        if let Some(foreign) =
            self.strays.iter().find(|stray| !stray.file_name().unwrap_or_default().to_string_lossy().contains(".snap"))
        {
            return Err(GoldenError::Foreign(foreign.clone()));
        }
        let mut done = Vec::new();
        for Inspected { name, rows, status } in &self.goldens {
            if matches!(status, Status::Same) {
                continue;
            }
            if !status.is_fit() {
                done.push(format!("refused {name}: what it computes is wrong"));
                continue;
            }
            fs::create_dir_all(&self.dir).map_err(io(&self.dir))?;
            let [metadata, csv] = file_names(name);
            replace(&self.dir, &csv, &render(rows))?;
            replace(&self.dir, &metadata, METADATA)?;
            done.push(format!("wrote {csv}: {} rows", rows.len()));
        }
        for stray in &self.strays {
            fs::remove_file(stray).map_err(io(stray))?;
            done.push(format!("removed {}", stray.file_name().unwrap_or_default().display()));
        }
        Ok(done)
    }
}

/// insta's two files of a snapshot: metadata and contents.
fn file_names(name: &str) -> [String; 2] {
    [format!("{name}.snap"), format!("{name}.snap.csv")]
}

fn status(dir: &Path, name: &str, rows: &[Row]) -> Result<Status, GoldenError> {
    let [metadata, csv] = file_names(name).map(|file| dir.join(file));
    if !metadata.is_file() || !csv.is_file() {
        return Ok(Status::Missing(compare(&[], rows)));
    }
    let bytes = fs::read(&csv).map_err(io(&csv))?;
    let (old, faults) = parse(&bytes);
    let changes = compare(&old, rows);
    Ok(match (faults.is_empty(), changes.is_empty()) {
        (false, _) => Status::Malformed(faults, changes),
        (true, true) => Status::Same,
        (true, false) => Status::Changed(changes),
    })
}

fn listing(dir: &Path) -> Result<BTreeSet<String>, GoldenError> {
    let entries = match fs::read_dir(dir) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(BTreeSet::new()),
        entries => entries.map_err(io(dir))?,
    };
    let mut files = BTreeSet::new();
    for entry in entries {
        let entry = entry.map_err(io(dir))?;
        if entry.file_type().map_err(io(dir))?.is_dir() {
            continue;
        }
        let file = entry.file_name().to_string_lossy().into_owned();
        if !file.starts_with('.') && file != "README.md" {
            files.insert(file);
        }
    }
    Ok(files)
}

fn replace(dir: &Path, file: &str, text: &str) -> Result<(), GoldenError> {
    let path = dir.join(file);
    Replacement::write(&path, text.as_bytes()).map_err(io(&path))
}

fn io(path: &Path) -> impl FnOnce(std::io::Error) -> GoldenError {
    move |source| GoldenError::Io { path: path.to_owned(), source }
}
