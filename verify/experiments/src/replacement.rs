//! A file that appears whole or not at all.

use std::fs::File;
#[cfg(unix)]
use std::fs::Permissions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{Builder, NamedTempFile};

/// Writes beside the target and takes its place when [committed](Self::commit); dropped before that, it leaves the target
/// as it was. What is no regular file (`/dev/null`, a pipe) is written to directly.
#[derive(Debug)]
pub struct Replacement(Kind);

/// The files beside their targets, those that have taken their place or are gone included.
static BESIDE: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unwritten() -> MutexGuard<'static, Vec<PathBuf>> {
    BESIDE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all that is not committed, before a process ends that drops nothing. Nothing is begun any more while what it returns is kept.
#[must_use]
pub fn discard_all() -> impl Sized {
    let mut unwritten = unwritten();
    for path in unwritten.drain(..) {
        // What has taken its place is no longer there.
        let _ = std::fs::remove_file(path);
    }
    unwritten
}

/// What is wrong with a directory, without the name of the file beside the target, which means nothing to a user.
fn without_path(error: io::Error) -> io::Error {
    let reason = error.get_ref().and_then(|named| named.source()).map(ToString::to_string);
    reason.map_or(error.kind().into(), |reason| io::Error::new(error.kind(), reason))
}

#[derive(Debug)]
enum Kind {
    Direct(File),
    Beside(NamedTempFile, PathBuf),
}

impl Replacement {
    /// Begins to replace the file at `path`, or to create it.
    ///
    /// # Errors
    /// If the directory cannot be written to.
    pub fn create(path: &Path) -> io::Result<Self> {
        // A link stays a link: the file that it leads to is replaced.
        let target = if path.exists() { path.canonicalize()? } else { path.to_owned() };
        if target.exists() && !target.is_file() {
            return Ok(Self(Kind::Direct(File::options().write(true).open(&target)?)));
        }
        let name = target.file_name().ok_or(io::ErrorKind::InvalidFilename)?.to_string_lossy().into_owned();
        let directory = target.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let prefix = format!(".{name}.");
        let mut builder = Builder::new();
        builder.prefix(&prefix).suffix(".partial");
        // Whoever the user's mask allows to may read it, as with any file.
        #[cfg(unix)]
        builder.permissions(<Permissions as std::os::unix::fs::PermissionsExt>::from_mode(0o666));
        let mut unwritten = unwritten();
        let file = builder.tempfile_in(directory).map_err(without_path)?;
        unwritten.push(file.path().to_owned());
        Ok(Self(Kind::Beside(file, target)))
    }

    /// Puts the new file in the place of the old one.
    ///
    /// # Errors
    /// If what was written cannot be stored or renamed.
    pub fn commit(mut self) -> io::Result<()> {
        self.flush()?;
        match self.0 {
            Kind::Direct(_) => Ok(()),
            Kind::Beside(file, target) => file.persist(target).map(drop).map_err(|error| error.error),
        }
    }

    /// Replaces the contents of the file at `path`.
    ///
    /// # Errors
    /// If it cannot be written; it is as it was then.
    pub fn write(path: &Path, contents: &[u8]) -> io::Result<()> {
        let mut file = Self::create(path)?;
        file.write_all(contents)?;
        file.commit()
    }
}

impl Write for Replacement {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.0 {
            Kind::Direct(file) => file.write(bytes),
            Kind::Beside(file, _) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.0 {
            Kind::Direct(file) => file.flush(),
            Kind::Beside(file, _) => file.flush(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn a_new_file_is_for_whoever_may_read_any_file() {
        let directory = tempfile::tempdir().expect("a directory");
        let [replaced, plain] = ["replaced", "plain"].map(|name| directory.path().join(name));
        Replacement::write(&replaced, b"x").expect("writable");
        File::create(&plain).expect("writable");
        let mode =
            |path: &Path| std::os::unix::fs::PermissionsExt::mode(&path.metadata().expect("a file").permissions());
        assert_eq!(mode(&replaced), mode(&plain));
    }
}
