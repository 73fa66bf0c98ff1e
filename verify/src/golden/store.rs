//! The directory of golden files: what is in it, what ought to be, and bringing the two together.

use super::{Change, Golden, GoldenError, Malformed, Row, compare, parse, render};
use std::collections::BTreeSet;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// insta's metadata of a snapshot kept as a `.csv` beside it.
const METADATA: &str = "---\nsource: verify/tests/goldens.rs\nextension: csv\nsnapshot_kind: binary\n---\n";

/// What became of one golden.
#[derive(Debug)]
pub enum Status {
    /// File and computation agree.
    Same,
    /// Rows differ.
    Changed(Vec<Change>),
    /// There is no file; the changes name its rows as new, and what is wrong with them.
    Missing(Vec<Change>),
    /// The file cannot be read; the changes are those against an empty file.
    Malformed(Malformed, Vec<Change>),
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
    /// Files that no golden produces.
    pub orphans: Vec<PathBuf>,
}

#[derive(Debug)]
struct Inspected {
    name: String,
    rows: Vec<Row>,
    status: Status,
}

/// Holds every golden against its file in `dir`, and looks for files that none of them produces. Hidden files and
/// `README.md` are left alone.
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
        if golden.is_left_out {
            continue;
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
    let expected: BTreeSet<String> = names.iter().flat_map(|name| file_names(name)).collect();
    let orphans =
        listing(dir)?.into_iter().filter(|file| !expected.contains(file)).map(|file| dir.join(file)).collect();
    Ok(Inspection { dir: dir.to_owned(), goldens: inspected, orphans })
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
    /// Name and status of every golden.
    pub fn statuses(&self) -> impl Iterator<Item = (&str, &Status)> {
        self.goldens.iter().map(|g| (g.name.as_str(), &g.status))
    }

    /// Whether every golden agrees with its file and no file is left over.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        self.orphans.is_empty() && self.goldens.iter().all(|g| matches!(g.status, Status::Same))
    }

    /// Writes the goldens that differ, each by a temporary file and a rename, and removes orphans. Goldens that are wrong
    /// ([`Status::is_fit`]) keep their old file. Returns what was done, a line each.
    ///
    /// # Errors
    /// [`GoldenError::Foreign`], before anything is touched, if an orphan is no snapshot: `dir` may be another directory
    /// than was meant. [`GoldenError::Io`] at the first file that cannot be written or removed.
    pub fn apply(&self) -> Result<Vec<String>, GoldenError> {
        if let Some(foreign) = self
            .orphans
            .iter()
            .find(|orphan| !orphan.file_name().unwrap_or_default().to_string_lossy().contains(".snap"))
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
        for orphan in &self.orphans {
            fs::remove_file(orphan).map_err(io(orphan))?;
            done.push(format!("removed {}", orphan.file_name().unwrap_or_default().display()));
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
    Ok(match parse(&bytes) {
        Err(malformed) => Status::Malformed(malformed, compare(&[], rows)),
        Ok(old) => match compare(&old, rows) {
            changes if changes.is_empty() => Status::Same,
            changes => Status::Changed(changes),
        },
    })
}

fn listing(dir: &Path) -> Result<BTreeSet<String>, GoldenError> {
    let entries = match fs::read_dir(dir) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(BTreeSet::new()),
        entries => entries.map_err(io(dir))?,
    };
    let mut files = BTreeSet::new();
    for entry in entries {
        let file = entry.map_err(io(dir))?.file_name().to_string_lossy().into_owned();
        if !file.starts_with('.') && file != "README.md" {
            files.insert(file);
        }
    }
    Ok(files)
}

fn replace(dir: &Path, file: &str, text: &str) -> Result<(), GoldenError> {
    let (path, temporary) = (dir.join(file), dir.join(format!(".{file}.{}", std::process::id())));
    fs::write(&temporary, text).map_err(io(&temporary))?;
    fs::rename(&temporary, &path).map_err(io(&path))
}

fn io(path: &Path) -> impl FnOnce(std::io::Error) -> GoldenError {
    move |source| GoldenError::Io { path: path.to_owned(), source }
}
