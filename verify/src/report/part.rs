//! Parts of a report that several machines have made, and the report that they make together.

use std::path::{Path, PathBuf};
use std::{fs, io};

use speedy::{Readable, Writable};

use super::run::Chapter;

/// Versions, parameters and seeds in the order shown.
pub type Provenance = Vec<(String, String)>;

/// What one machine contributes.
#[derive(Debug, Clone, Readable, Writable)]
pub struct Part {
    /// Which of how many, from 1.
    pub shard: Shard,
    /// The studies of the whole report in reading order.
    pub studies: Vec<String>,
    /// What the numbers were computed with.
    pub provenance: Provenance,
    /// The chapters of this part.
    pub chapters: Vec<Chapter>,
}

/// The k-th of n parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Readable, Writable)]
pub struct Shard {
    /// From 1.
    pub k: u32,
    /// How many there are.
    pub n: u32,
}

impl Shard {
    /// Whether the study at this place of the whole selection belongs to it: every n-th, so that neighbours, which are often alike
    /// in length, are dealt out.
    pub fn has(self, place: usize) -> bool {
        place % self.n as usize == (self.k - 1) as usize
    }
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
        match parsed {
            Some((k, n)) if 1 <= k && k <= n && n <= 1000 => Ok(Self { k, n }),
            _ => Err("expected K/N with 1 ≤ K ≤ N ≤ 1000, such as 2/4".into()),
        }
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.k, self.n)
    }
}

/// Why parts make no report.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PartError {
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A file is no part of a report by this version of the program.
    #[error("{} is no part of a report by this version of the program", .0.display())]
    Foreign(PathBuf),
    /// There is none in a directory.
    #[error("there is no part of a report in {}; `report --shard` writes one", .0.display())]
    None(PathBuf),
    /// A part was made of other studies, with other programs, or of another number of parts.
    #[error("the part {0} differs from the part {1} in {2}: they do not belong together")]
    Differs(Shard, Shard, &'static str),
    /// A part is there more than once.
    #[error("the part {0} is there twice")]
    Twice(Shard),
    /// Parts are missing.
    #[error("of {n} parts these are missing: {missing}")]
    Missing {
        /// How many there are.
        n: u32,
        /// Those that are not.
        missing: String,
    },
}

/// What the first bytes of the file say.
const MAGIC: &[u8] = b"lsvi report part 1\n";
/// The ending of the file.
const ENDING: &str = "part";

impl Part {
    /// Writes it into `directory`, under a name that says which it is.
    ///
    /// # Errors
    /// [`PartError::File`].
    pub fn write(&self, directory: &Path) -> Result<PathBuf, PartError> {
        let path = directory.join(format!("{}-of-{}.{ENDING}", self.shard.k, self.shard.n));
        let fails = |source| PartError::File { path: path.clone(), source };
        fs::create_dir_all(directory).map_err(fails)?;
        let encoded = self.write_to_vec().map_err(|error| fails(io::Error::other(error)))?;
        let partial = tempfile::NamedTempFile::new_in(directory).map_err(fails)?;
        fs::write(partial.path(), [MAGIC, &encoded].concat()).map_err(fails)?;
        partial.persist(&path).map_err(|error| fails(error.error))?;
        Ok(path)
    }

    /// Reads all that are in `directory`.
    ///
    /// # Errors
    /// [`PartError`] if there is none, or a file is not what it is called.
    pub fn read_all(directory: &Path) -> Result<Vec<Self>, PartError> {
        let fails = |path: &Path| {
            let path = path.to_owned();
            move |source| PartError::File { path, source }
        };
        let mut paths = Vec::new();
        for entry in fs::read_dir(directory).map_err(fails(directory))? {
            let path = entry.map_err(fails(directory))?.path();
            if path.extension().is_some_and(|ending| ending == ENDING) {
                paths.push(path);
            }
        }
        if paths.is_empty() {
            return Err(PartError::None(directory.into()));
        }
        let read = |path: PathBuf| {
            let bytes = fs::read(&path).map_err(fails(&path))?;
            let content = bytes.strip_prefix(MAGIC).and_then(|content| Self::read_from_buffer(content).ok());
            content.ok_or(PartError::Foreign(path))
        };
        paths.into_iter().map(read).collect()
    }
}

/// The chapters of all parts in reading order, and what they were computed with.
///
/// # Errors
/// [`PartError`] if they do not belong together, or some are missing.
pub fn merge(parts: Vec<Part>) -> Result<(Vec<Chapter>, Provenance), PartError> {
    let Some(first) = parts.first().cloned() else {
        return Err(PartError::Missing { n: 1, missing: "1".into() });
    };
    let n = first.shard.n;
    let mut seen = vec![false; n as usize];
    for part in &parts {
        let differs = |what| Err(PartError::Differs(part.shard, first.shard, what));
        if part.shard.n != n {
            return differs("the number of parts");
        }
        if part.studies != first.studies {
            return differs("the studies asked for");
        }
        if part.provenance != first.provenance {
            return differs("what they were computed with");
        }
        if std::mem::replace(&mut seen[part.shard.k as usize - 1], true) {
            return Err(PartError::Twice(part.shard));
        }
    }
    let missing: Vec<String> = (1..=n).filter(|k| !seen[*k as usize - 1]).map(|k| k.to_string()).collect();
    if !missing.is_empty() {
        return Err(PartError::Missing { n, missing: missing.join(", ") });
    }
    let mut chapters: Vec<Chapter> = parts.into_iter().flat_map(|part| part.chapters).collect();
    let place = |chapter: &Chapter| first.studies.iter().position(|study| *study == chapter.id);
    chapters.sort_by_key(|chapter| place(chapter).unwrap_or(usize::MAX));
    Ok((chapters, first.provenance))
}
