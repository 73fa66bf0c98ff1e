//! A file that appears whole or not at all.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Writes beside the target and takes its place when [committed](Self::commit); dropped before that, it leaves the target
/// as it was. What is no regular file (`/dev/null`, a pipe) is written to directly.
#[derive(Debug)]
pub(super) struct Replacement {
    file: File,
    target: PathBuf,
    temporary: Option<PathBuf>,
}

impl Replacement {
    pub(super) fn create(path: &Path) -> io::Result<Self> {
        // A link stays a link: the file that it leads to is replaced.
        let target = if path.exists() { path.canonicalize()? } else { path.to_owned() };
        if target.exists() && !target.is_file() {
            return Ok(Self { file: File::options().write(true).open(&target)?, target, temporary: None });
        }
        let name = target.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
        let hidden = format!(".{}.{}.partial", name.to_string_lossy(), std::process::id());
        let temporary = target.with_file_name(hidden);
        Ok(Self { file: File::create(&temporary)?, target, temporary: Some(temporary) })
    }

    pub(super) fn commit(mut self) -> io::Result<()> {
        self.file.flush()?;
        if let Some(temporary) = &self.temporary {
            fs::rename(temporary, &self.target)?;
            self.temporary = None;
        }
        Ok(())
    }
}

impl Write for Replacement {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Drop for Replacement {
    fn drop(&mut self) {
        if let Some(temporary) = &self.temporary {
            // Nothing can be done about a failure here, and the target is untouched in any case.
            let _ = fs::remove_file(temporary);
        }
    }
}
