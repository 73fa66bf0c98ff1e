//! Evidence as a report: HTML, Markdown, JSON, JUnit, CSV and a summary for the terminal. Nothing is computed here.

mod bibliography;
mod chart;
mod comparison;
mod csv;
mod html;
mod json;
mod junit;
mod markdown;
mod part;
mod picture;
mod run;
mod style;
mod terminal;
mod text;
mod verdict;

use std::path::{Path, PathBuf};
use std::{fs, io};

pub use comparison::{ComparisonError, Earlier};
pub use part::{Part, PartError, Provenance, Shard, merge};
pub use picture::picture;
pub use run::{Chapter, Counts, Run};
pub use terminal::{summary, wants_color};

/// Why no report was written; files of an earlier report are left as they were, or replaced as a whole.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A file or directory could not be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// What was to be written.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The directory cannot be written to, found out before anything was computed.
    #[error("cannot write into {}: {source}", path.display())]
    Unwritable {
        /// The directory, or the file in its way.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A table could not be put into CSV.
    #[error("cannot write table `{table}` as CSV: {source}")]
    Csv {
        /// The table's identifier.
        table: String,
        /// What the writer said.
        source: ::csv::Error,
    },
    /// The results could not be put into JSON.
    #[error("cannot write the results as JSON: {0}")]
    Json(#[from] serde_json::Error),
}

/// Creates `directory` where it is missing and tries to write into it, so that a report that cannot be written costs no time.
///
/// # Errors
/// [`ReportError::Unwritable`] names what stands in the way.
pub fn prepare(directory: &Path) -> Result<(), ReportError> {
    for path in [directory, &directory.join("data")] {
        let tried = fs::create_dir_all(path).and_then(|()| tempfile::tempfile_in(path));
        tried.map_err(|source| ReportError::Unwritable { path: path.into(), source })?;
    }
    Ok(())
}

/// Writes `index.html`, `report.md`, `results.json`, `timings.json`, `junit.xml` and `data/<table>.csv` into `directory`, which is created
/// where missing.
///
/// The files are complete before the first one takes its place, each by renaming. Data files that the directory's earlier
/// `results.json` lists and this run no longer has are removed; other files are left alone.
///
/// # Errors
/// [`ReportError`] names the file that could not be written.
pub fn write(run: &Run, directory: &Path) -> Result<(), ReportError> {
    let files = documents(run)?;
    let stale = stale_files(directory, &files);
    create(&directory.join("data"))?;
    let staging = tempfile::Builder::new().prefix(".partial-").tempdir_in(directory);
    let staging = staging.map_err(|source| ReportError::Write { path: directory.into(), source })?;
    create(&staging.path().join("data"))?;
    for (name, content) in &files {
        let path = staging.path().join(name);
        fs::write(&path, content).map_err(|source| ReportError::Write { path, source })?;
    }
    for (name, _) in &files {
        let path = directory.join(name);
        fs::rename(staging.path().join(name), &path).map_err(|source| ReportError::Write { path, source })?;
    }
    for path in stale {
        fs::remove_file(&path).map_err(|source| ReportError::Write { path, source })?;
    }
    Ok(())
}

/// Every file with its content; the page that links to the others last.
fn documents(run: &Run) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    let mut files = Vec::new();
    for table in run.chapters.iter().flat_map(|chapter| &chapter.evidence.tables) {
        let content = csv::table(table).map_err(|source| ReportError::Csv { table: table.id.clone(), source })?;
        files.push((text::data_file(&table.id), content));
    }
    files.push(("junit.xml".into(), junit::document(run).into_bytes()));
    files.push(("report.md".into(), markdown::document(run).into_bytes()));
    files.push(("results.json".into(), json::document(run)?.into_bytes()));
    files.push(("timings.json".into(), json::timings(run)?.into_bytes()));
    files.push(("index.html".into(), html::document(run).into_bytes()));
    Ok(files)
}

fn stale_files(directory: &Path, files: &[(String, Vec<u8>)]) -> Vec<PathBuf> {
    let earlier = fs::read_to_string(directory.join("results.json")).unwrap_or_default();
    let is_stale = |name: &String| files.iter().all(|(kept, _)| kept != name);
    let paths = json::files_listed(&earlier).into_iter().filter(is_stale).map(|name| directory.join(name));
    paths.filter(|path| path.is_file()).collect()
}

fn create(path: &Path) -> Result<(), ReportError> {
    fs::create_dir_all(path).map_err(|source| ReportError::Write { path: path.into(), source })
}
