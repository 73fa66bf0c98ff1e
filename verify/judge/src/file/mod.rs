//! Method files: what a method is called, what is claimed of it, and its coefficients.

mod closure;
mod coefficients;
mod document;
mod error;
mod multistep;
mod nodes;
mod parts;
mod plain;
mod runge_kutta;
mod shipped;

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

pub use error::FileError;
pub use shipped::{SHIPPED, Shipped};

use super::analysis::Analysis;
use super::claim::{Claim, Property};
use super::closure::{Closure, ClosureTheory};
use super::expression::Rounding;
use super::multistep::{Multistep, MultistepTheory};
use super::nodes::{Nodes, NodesTheory};
use super::parts::{Parts, PartsTheory};
use super::tableau::Tableau;
use super::theory::Theory;
use document::Document;
use error::Fault;
use evidence::Table;

/// Longest file, in bytes; the largest tableaus have a few thousand digits.
const MAX_BYTES: u64 = 1 << 20;

/// The kinds of methods that can be judged.
pub const KINDS: &[&str] =
    &["runge-kutta", "partitioned-runge-kutta", "nystrom", "multistep", "closure", "path-fitted", "galerkin"];

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
    /// A partitioned Runge–Kutta or a Nyström method.
    Parts(Parts),
    /// A linear multistep method.
    Multistep(Multistep),
    /// A closure of the trapezoidal discrete Lagrangian.
    Closure(Closure),
    /// A path-fitted or a Galerkin variational integrator.
    Nodes(Nodes),
}

impl Body {
    /// What follows from the coefficients, conditions up to the orders claimed and one more at least.
    pub fn analyse(&self, claimed: Option<u32>, claimed_embedded: Option<u32>) -> Arc<dyn Analysis> {
        match self {
            Self::RungeKutta(tableau) => Arc::new(Theory::new(tableau, claimed, claimed_embedded)),
            Self::Parts(parts) => Arc::new(PartsTheory::new(parts, claimed)),
            Self::Multistep(method) => Arc::new(MultistepTheory::new(method)),
            Self::Closure(closure) => Arc::new(ClosureTheory::new(closure)),
            Self::Nodes(nodes) => Arc::new(NodesTheory::new(nodes)),
        }
    }

    /// The coefficients as texts.
    pub(super) fn table(&self) -> Table {
        match self {
            Self::RungeKutta(tableau) => tableau.table(),
            Self::Parts(parts) => parts.table(),
            Self::Multistep(method) => method.table(),
            Self::Closure(closure) => closure.table(),
            Self::Nodes(nodes) => nodes.table(),
        }
    }
}

impl MethodFile {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// [`FileError`] with line and column.
    pub fn load(path: &Path) -> Result<Self, FileError> {
        let shown = path.display().to_string();
        let unreadable = |reason: String| FileError::Unreadable { path: shown.clone(), reason };
        let mut bytes = Vec::new();
        // What is no regular file may have no end.
        let read = File::open(path).and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes));
        if read.map_err(|error| unreadable(error.to_string()))? as u64 > MAX_BYTES {
            return Err(unreadable(format!("it has more than {MAX_BYTES} bytes")));
        }
        let text = String::from_utf8(bytes).map_err(|error| {
            let at = error.utf8_error().valid_up_to();
            let fault =
                Fault::new(at, "a byte that is no text in UTF-8").hint("a method file is TOML or a plain table");
            fault.locate(&shown, &String::from_utf8_lossy(&error.as_bytes()[..at]))
        })?;
        let stem = path.file_stem().map_or_else(|| shown.clone(), |stem| stem.to_string_lossy().into_owned());
        Self::parse(&shown, &stem, &text)
    }

    /// Reads `text`, which `path` is named as in errors; `stem` is the method's name where the text gives none.
    ///
    /// # Errors
    /// [`FileError`] with line and column.
    pub fn parse(path: &str, stem: &str, text: &str) -> Result<Self, FileError> {
        // A mark of the byte order is no text.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let located = |fault: Fault| fault.locate(path, text);
        if text.trim().is_empty() {
            return Err(located(Fault::new(0, "the file is empty").hint("`verify judge --help` states what it holds")));
        }
        let document = match plain::table(text) {
            Some(table) => table.read(),
            None => Document::read(text),
        };
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
        let (mut claims, mut embedded_at) = (Vec::new(), None);
        for (key, make) in [("order", Claim::order as fn(u32) -> Claim), ("embedded_order", Claim::embedded_order)] {
            let at = document.at(key);
            if let Some(order) = document.count(key, 1, 20)? {
                claims.push(make(order));
                embedded_at = at.filter(|_| key == "embedded_order").or(embedded_at);
            }
        }
        for text in document.list("claims")?.unwrap_or_default() {
            let claim =
                Claim::parse(&text.text).map_err(|reason| Fault::new(text.at, reason).hint(super::claim::FORMS))?;
            if matches!(claim.property, Property::EmbeddedOrder(_)) {
                embedded_at = embedded_at.or(Some(text.at));
            }
            if !claims.contains(&claim) {
                claims.push(claim);
            }
        }
        let (source, note) = (document.text("source")?, document.text("note")?);
        let digits = document.count("digits", 1, 60)?;
        let kind = kind.map_or_else(|| KINDS[0].to_owned(), |kind| kind.text);
        let document = &mut document;
        let (body, rounding) = match kind.as_str() {
            "partitioned-runge-kutta" => with(Body::Parts, parts::partitioned(document, digits)?),
            "nystrom" => with(Body::Parts, parts::nystrom(document, digits)?),
            "multistep" => with(Body::Multistep, multistep::read(document, digits)?),
            "closure" => with(Body::Closure, closure::read(document, digits)?),
            "path-fitted" => with(Body::Nodes, nodes::path_fitted(document, digits)?),
            "galerkin" => with(Body::Nodes, nodes::galerkin(document, digits)?),
            _ => with(Body::RungeKutta, runge_kutta::read(document, digits)?),
        };
        std::mem::take(document).finish()?;
        if let (Some(at), Body::RungeKutta(Tableau { b_hat: None, .. })) = (embedded_at, &body) {
            return Err(Fault::new(at, "an order of the embedded method is claimed, and the file gives no `b_hat`")
                .hint(
                    "`b_hat` has the weights of the embedded method, one for each stage: b_hat = [\"1/2\", \"1/2\"]",
                ));
        }
        Ok(Self { name, source, note, claims, rounding, body })
    }

    /// The order claimed.
    pub fn order(&self) -> Option<u32> {
        self.claims.iter().find_map(Claim::as_order)
    }
}

fn with<T>(make: fn(T) -> Body, (read, rounding): (T, Rounding)) -> (Body, Rounding) {
    (make(read), rounding)
}

#[cfg(test)]
mod tests {
    use super::{MAX_BYTES, MethodFile};

    #[test]
    fn the_longest_file_is_read_and_one_byte_more_is_not() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("long.toml");
        let method = "a = [[]]\nb = [1]\n#";
        let load = |bytes: u64| {
            let comment = " ".repeat(usize::try_from(bytes).expect("few") - method.len());
            std::fs::write(&path, format!("{method}{comment}")).expect("it is written");
            MethodFile::load(&path)
        };
        assert_eq!(load(MAX_BYTES).expect("a method").name, "long");
        let error = load(MAX_BYTES + 1).expect_err("it is too long").to_string();
        assert!(error.ends_with("it has more than 1048576 bytes"), "{error}");
    }
}
