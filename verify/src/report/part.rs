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
    /// A part with a number that none has.
    #[error("no part can be called {0}")]
    NoPlace(Shard),
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
        let place = part.shard.k.checked_sub(1).and_then(|k| seen.get_mut(k as usize));
        if std::mem::replace(place.ok_or(PartError::NoPlace(part.shard))?, true) {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn part(k: u32, n: u32) -> Part {
        let chapter = |id: String| Chapter { id, ..Chapter::default() };
        let provenance = vec![("version".to_owned(), "1".to_owned())];
        let studies = (1..=n).map(|k| format!("study-{k}")).collect();
        Part { shard: Shard { k, n }, studies, provenance, chapters: vec![chapter(format!("study-{k}"))] }
    }

    #[test]
    fn parts_join_in_reading_order_and_others_do_not_belong() {
        let (chapters, _) = merge(vec![part(3, 3), part(1, 3), part(2, 3)]).expect("all there");
        assert_eq!(
            chapters.iter().map(|chapter| chapter.id.as_str()).collect::<Vec<_>>(),
            ["study-1", "study-2", "study-3"]
        );
        let reason = |parts: Vec<Part>| merge(parts).map(|_| ()).expect_err("no report").to_string();
        let mut later = part(2, 2);
        later.provenance[0].1 = "2".into();
        assert!(reason(vec![part(1, 2), later]).contains("differs from the part 1/2 in what they were computed with"));
        assert!(reason(vec![part(1, 2), part(2, 3)]).contains("the number of parts"));
        let mut other = part(2, 2);
        other.studies[0] = "another".into();
        assert!(reason(vec![part(1, 2), other]).contains("the studies asked for"));
        for k in [0, 3] {
            let mut stray = part(2, 2);
            stray.shard.k = k;
            assert!(reason(vec![part(1, 2), stray]).contains("no part can be called"), "{k}");
        }
        assert!(reason(vec![part(1, 2), part(1, 2)]).contains("twice"));
        assert!(reason(vec![part(1, 3), part(3, 3)]).contains("missing: 2"));
        assert!(reason(Vec::new()).contains("missing: 1"));
    }

    /// Another format, or a file that ends too soon.
    #[test]
    fn a_part_of_another_version_is_not_read() {
        let dir = tempfile::tempdir().expect("a directory");
        let path = part(1, 2).write(dir.path()).expect("writable");
        let bytes = fs::read(&path).expect("readable");
        assert_eq!(Part::read_all(dir.path()).expect("a part")[0].shard, Shard { k: 1, n: 2 });
        let later = [&b"lsvi report part 2\n"[..], &bytes[MAGIC.len()..]].concat();
        for foreign in [later, bytes[..bytes.len() - 1].to_vec(), Vec::new()] {
            fs::write(&path, foreign).expect("writable");
            assert!(matches!(Part::read_all(dir.path()), Err(PartError::Foreign(_))));
        }
    }

    /// A chapter that broke off is one, and what nobody asked for comes last.
    #[test]
    fn no_chapter_is_lost() {
        let mut broken = part(2, 2);
        broken.chapters[0].error = Some("it broke off".into());
        broken.chapters[0].seconds = 2.5;
        let mut with_more = part(1, 2);
        with_more.chapters.insert(0, Chapter { id: "unasked".into(), ..Chapter::default() });
        let (chapters, _) = merge(vec![broken, with_more]).expect("all there");
        assert_eq!(chapters[1].seconds, 2.5);
        let found: Vec<_> = chapters.iter().map(|it| (it.id.as_str(), it.error.as_deref())).collect();
        assert_eq!(found, [("study-1", None), ("study-2", Some("it broke off")), ("unasked", None)]);
    }
}
