//! Golden files: numbers frozen with their tolerance, their provenance and their distance to the truth.
//!
//! A golden is a table of [`Row`]s computed by the code and kept as `golden/NAME.snap.csv`, an insta snapshot (its
//! metadata is `NAME.snap`). It guards against change, and where a truth is known also against freezing a wrong number: a
//! value further from the truth than its allowance fails even if the file agrees with it, and is never written.
//!
//! The command line ([`run`]) and the tests (insta, through [`NumericComparator`]) share one comparison, [`compare`]. A test
//! that fails leaves `NAME.snap.new` beside the file, which `cargo insta review` shows and accepts; `golden refresh` does the
//! same for all at once, and says of every number whether it moved toward the truth.

mod command;
mod compare;
mod figures;
mod file;
mod mechanics;
mod order;
mod registry;
mod store;
mod table;

pub use command::{Action, run};
pub use compare::{Change, Difference, NumericComparator, compare};
pub use file::{Malformed, Recorded, parse, render};
pub use registry::all;
pub use store::{Inspection, Status, find_dir, inspect, strays};

use std::error::Error;
use std::fmt;
use std::path::PathBuf;

/// A named table of numbers to keep.
pub struct Golden {
    /// File stem: lower-case letters, digits and hyphens.
    pub name: String,
    rows: Box<Compute>,
}

type Compute = dyn Fn() -> Result<Vec<Row>, Box<dyn Error + Send + Sync>> + Send + Sync;

impl Golden {
    /// A golden whose rows `rows` computes.
    pub fn new(
        name: impl Into<String>,
        rows: impl Fn() -> Result<Vec<Row>, Box<dyn Error + Send + Sync>> + Send + Sync + 'static,
    ) -> Self {
        Self { name: name.into(), rows: Box::new(rows) }
    }

    /// Computes the rows.
    ///
    /// # Errors
    /// Whatever stopped the computation.
    pub fn rows(&self) -> Result<Vec<Row>, Box<dyn Error + Send + Sync>> {
        (self.rows)()
    }
}

impl fmt::Debug for Golden {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Golden").field("name", &self.name).finish_non_exhaustive()
    }
}

/// One row of a golden.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// What the value is, unique in the golden: `u(0.3, 0.1)`.
    pub key: String,
    /// The value, with what is known about it.
    pub value: Value,
}

/// What a row keeps.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Compared exactly.
    Text(String),
    /// Compared within its tolerance, and with the truth.
    Number(Number),
}

/// A number and what is known about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Number {
    /// The number.
    pub value: f64,
    /// How far it may move.
    pub tolerance: Tolerance,
    /// What it ought to be, where that is known.
    pub truth: Option<Truth>,
}

/// A number may differ from the frozen one by `atol` + `rtol`·|frozen|.
#[derive(Debug, Clone, PartialEq)]
pub struct Tolerance {
    /// Relative part.
    pub rtol: f64,
    /// Absolute part; needed where the value may be zero.
    pub atol: f64,
    /// Where the tolerance comes from.
    pub reason: String,
}

/// What a number ought to be.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// The true value.
    pub value: f64,
    /// Largest |value − truth| that is accepted; stated in the code, not computed anew in each run.
    pub allowance: f64,
    /// Where the true value comes from.
    pub source: String,
}

impl Row {
    /// A number with its tolerance.
    pub fn number(key: impl Into<String>, value: f64, tolerance: Tolerance) -> Self {
        Self { key: key.into(), value: Value::Number(Number { value, tolerance, truth: None }) }
    }

    /// A text, compared exactly.
    pub fn text(key: impl Into<String>, text: impl Into<String>) -> Self {
        Self { key: key.into(), value: Value::Text(text.into()) }
    }

    /// Adds the truth about a number, where it is known; a text has none.
    #[must_use]
    pub fn with_truth(mut self, known: impl Into<Option<Truth>>) -> Self {
        if let Value::Number(number) = &mut self.value {
            number.truth = known.into();
        }
        self
    }
}

impl Tolerance {
    /// A relative tolerance and its reason.
    pub fn relative(rtol: f64, reason: impl Into<String>) -> Self {
        Self { rtol, atol: 0.0, reason: reason.into() }
    }

    /// An absolute tolerance and its reason.
    pub fn absolute(atol: f64, reason: impl Into<String>) -> Self {
        Self { rtol: 0.0, atol, reason: reason.into() }
    }

    /// How far a number may be from `frozen`.
    fn width(&self, frozen: f64) -> f64 {
        self.atol + self.rtol * frozen.abs()
    }
}

impl Truth {
    /// It is zero, to within `allowance`.
    pub fn vanishes(allowance: f64, source: impl Into<String>) -> Self {
        Self { value: 0.0, allowance, source: source.into() }
    }

    /// |value − truth|.
    fn distance(&self, value: f64) -> f64 {
        (value - self.value).abs()
    }
}

/// Why the golden files cannot be worked on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GoldenError {
    /// A name that is no file stem.
    #[error("`{0}` cannot name a golden: use lower-case letters, digits and hyphens")]
    Name(String),
    /// Two goldens of one name.
    #[error("two goldens are called `{0}`")]
    Duplicate(String),
    /// No golden of this name.
    #[error("no golden is called `{0}`")]
    Unknown(String),
    /// No workspace above the current directory.
    #[error("no Cargo workspace in {} or above it; name the golden directory with --dir", .0.display())]
    NoWorkspace(PathBuf),
    /// A file that `golden refresh` will not remove.
    #[error("{} is no golden file: move it away, or name the golden directory with --dir", .0.display())]
    Foreign(PathBuf),
    /// A file could not be read, written or removed.
    #[error("{}: {source}", path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The output could not be written.
    #[error("cannot write the report: {0}")]
    Output(#[from] std::io::Error),
}

#[cfg(test)]
impl Row {
    /// Whether nothing is wrong with it, whatever a file says.
    fn is_fit(&self) -> bool {
        !compare(&[], std::slice::from_ref(self)).iter().any(|change| change.difference.is_wrong())
    }
}
