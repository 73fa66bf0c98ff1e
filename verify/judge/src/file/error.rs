//! What is wrong with a method file, and where.

/// Why a method file was not read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// There is no such file, or it is no text.
    #[error("cannot read {path}: {reason}")]
    Unreadable {
        /// The file.
        path: String,
        /// What the system says.
        reason: String,
    },
    /// Something in it means nothing.
    #[error("{path}:{line}:{column}: {reason}")]
    Malformed {
        /// The file.
        path: String,
        /// Counted from 1.
        line: usize,
        /// In characters, counted from 1.
        column: usize,
        /// What is wrong.
        reason: String,
        /// How to put it right.
        hint: Option<String>,
    },
}

/// A fault at a byte of the text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Fault {
    at: usize,
    reason: String,
    hint: Option<String>,
}

impl Fault {
    pub(super) fn new(at: usize, reason: impl Into<String>) -> Self {
        Self { at, reason: reason.into(), hint: None }
    }

    pub(super) fn hint(self, hint: impl Into<String>) -> Self {
        Self { hint: Some(hint.into()), ..self }
    }

    pub(super) fn locate(self, path: &str, text: &str) -> FileError {
        let mut at = self.at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        let before = &text[..at];
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().map_or(0, |last| last.chars().count()) + 1;
        FileError::Malformed { path: path.into(), line, column, reason: self.reason, hint: self.hint }
    }
}

#[cfg(test)]
mod tests {
    use super::{Fault, FileError};

    /// As after escapes, behind which a place is counted from the text that they stand for.
    #[test]
    fn a_fault_within_a_character_is_shown_at_it() {
        for (text, at, place) in [("√", 1, (1, 1)), ("a\n√√", 7, (2, 2)), ("a\n√√", 8, (2, 3)), ("a", 5, (1, 2))]
        {
            let FileError::Malformed { line, column, .. } = Fault::new(at, "wrong").locate("m.toml", text) else {
                panic!("it is malformed")
            };
            assert_eq!((line, column), place, "{text} {at}");
        }
    }
}
