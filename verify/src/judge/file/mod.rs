//! Method files: what a method is called, what is claimed of it, and its coefficients.

mod document;
mod error;
mod plain;
mod runge_kutta;
mod shipped;

use std::path::Path;

pub use error::FileError;
pub use shipped::{SHIPPED, Shipped};

use super::claim::Claim;
use super::expression::Rounding;
use super::tableau::Tableau;
use document::Document;
use error::Fault;

/// Longest file, in bytes; the largest tableaus have a few thousand digits.
const MAX_BYTES: u64 = 1 << 20;

/// The kinds of methods that can be judged, and those that are planned and refused.
pub const KINDS: &[&str] = &["runge-kutta"];

/// A method as its file states it.
#[derive(Debug, Clone)]
pub struct MethodFile {
    /// Its name; the file's where it has none.
    pub name: String,
    /// Where it was published.
    pub source: Option<String>,
    /// What else the file says.
    pub note: Option<String>,
    /// What is claimed of it; the order first, where it is claimed.
    pub claims: Vec<Claim>,
    /// Which decimals have been rounded.
    pub rounding: Rounding,
    /// Its coefficients.
    pub body: Body,
}

/// The coefficients of a method of one kind.
#[derive(Debug, Clone)]
pub enum Body {
    /// A Runge–Kutta method.
    RungeKutta(Tableau),
}

impl MethodFile {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// [`FileError`] with line and column.
    pub fn load(path: &Path) -> Result<Self, FileError> {
        let shown = path.display().to_string();
        let unreadable = |reason: String| FileError::Unreadable { path: shown.clone(), reason };
        let size = std::fs::metadata(path).map_err(|error| unreadable(error.to_string()))?.len();
        if size > MAX_BYTES {
            return Err(unreadable(format!("it has {size} bytes, more than {MAX_BYTES}")));
        }
        let text = std::fs::read_to_string(path).map_err(|error| unreadable(error.to_string()))?;
        let stem = path.file_stem().map_or_else(|| shown.clone(), |stem| stem.to_string_lossy().into_owned());
        Self::parse(&shown, &stem, &text)
    }

    /// Reads `text`, which `path` is named as in errors; `stem` is the method's name where the text gives none.
    ///
    /// # Errors
    /// [`FileError`] with line and column.
    pub fn parse(path: &str, stem: &str, text: &str) -> Result<Self, FileError> {
        let located = |fault: Fault| fault.locate(path, text);
        let document = if plain::is_plain(text) { plain::read(text) } else { Document::read(text) };
        Self::from_document(document.map_err(located)?, stem).map_err(located)
    }

    fn from_document(mut document: Document, stem: &str) -> Result<Self, Fault> {
        let name = document.text("name")?.unwrap_or_else(|| stem.to_owned());
        let kind = document.scalar("kind")?;
        if let Some(kind) = &kind
            && !KINDS.contains(&kind.text.as_str())
        {
            let hint = format!("the kinds that can be judged: {}", KINDS.join(", "));
            return Err(Fault::new(kind.at, format!("the kind `{}` is not supported", kind.text)).hint(hint));
        }
        let mut claims = Vec::new();
        for (key, make) in [("order", Claim::order as fn(u32) -> Claim), ("embedded_order", Claim::embedded_order)] {
            if let Some(order) = document.count(key, 1, 20)? {
                claims.push(make(order));
            }
        }
        for claim in document.list("claims")?.unwrap_or_default() {
            claims.push(
                Claim::parse(&claim.text).map_err(|reason| Fault::new(claim.at, reason).hint(super::claim::FORMS))?,
            );
        }
        let (source, note) = (document.text("source")?, document.text("note")?);
        let digits = document.count("digits", 1, 60)?;
        let (tableau, rounding) = runge_kutta::read(&mut document, digits)?;
        document.finish()?;
        Ok(Self { name, source, note, claims, rounding, body: Body::RungeKutta(tableau) })
    }

    /// The order claimed.
    pub fn order(&self) -> Option<u32> {
        self.claims.iter().find_map(Claim::as_order)
    }
}
