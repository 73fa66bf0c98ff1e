//! The keys of a method file and their values as texts with places, whatever the syntax they came in.

use std::collections::BTreeMap;

use toml::de::{DeTable, DeValue};

use super::error::Fault;
use super::plain::FORMS;
use experiments::names::NameError;

/// The keys of all kinds.
const KEYS: &[&str] = &[
    "name",
    "kind",
    "source",
    "note",
    "order",
    "embedded_order",
    "claims",
    "digits",
    "systems",
    "a",
    "b",
    "c",
    "a_hat",
    "b_hat",
    "b_bar",
    "rho",
    "sigma",
    "start",
    "alpha",
    "beta",
    "rate",
    "nodes",
    "weights",
    "degree",
];

/// A text and the byte where it starts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Scalar {
    pub(super) text: String,
    pub(super) at: usize,
}

/// A value: one text, or a list of values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Value {
    Scalar(Scalar),
    List { items: Vec<Value>, at: usize },
}

impl Value {
    pub(super) fn at(&self) -> usize {
        match self {
            Self::Scalar(scalar) => scalar.at,
            Self::List { at, .. } => *at,
        }
    }
}

/// Keys not yet asked for, with their values.
#[derive(Debug, Clone, Default)]
pub(super) struct Document {
    entries: BTreeMap<String, (usize, Value)>,
    asked: Vec<&'static str>,
}

impl Document {
    /// Reads TOML.
    pub(super) fn read(text: &str) -> Result<Self, Fault> {
        let table = DeTable::parse(text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            let hint = if text.contains('=') { "coefficients other than numbers are texts: \"1/2\"" } else { FORMS };
            Fault::new(at, format!("no TOML: {}", error.message())).hint(hint)
        })?;
        let mut document = Self::default();
        for (key, value) in table.get_ref() {
            let value = convert(text, value.span(), value.get_ref())?;
            document.insert(key.get_ref(), key.span().start, value);
        }
        Ok(document)
    }

    pub(super) fn insert(&mut self, key: &str, at: usize, value: Value) {
        self.entries.insert(key.to_owned(), (at, value));
    }

    /// The value of `key`, which counts as known from now on.
    pub(super) fn take(&mut self, key: &'static str) -> Option<Value> {
        self.asked.push(key);
        self.entries.remove(key).map(|(_, value)| value)
    }

    /// Where the value of `key` stands.
    pub(super) fn at(&self, key: &str) -> Option<usize> {
        self.entries.get(key).map(|(_, value)| value.at())
    }

    /// Entries of the list under `key`.
    pub(super) fn length(&self, key: &str) -> Option<usize> {
        match self.entries.get(key) {
            Some((_, Value::List { items, .. })) => Some(items.len()),
            _ => None,
        }
    }

    pub(super) fn scalar(&mut self, key: &'static str) -> Result<Option<Scalar>, Fault> {
        match self.take(key) {
            None => Ok(None),
            Some(Value::Scalar(scalar)) => Ok(Some(scalar)),
            Some(Value::List { at, .. }) => Err(Fault::new(at, format!("`{key}` is one text, not a list"))),
        }
    }

    pub(super) fn text(&mut self, key: &'static str) -> Result<Option<String>, Fault> {
        Ok(self.scalar(key)?.map(|scalar| scalar.text))
    }

    /// A whole number from `least` to `most`.
    pub(super) fn count(&mut self, key: &'static str, least: u32, most: u32) -> Result<Option<u32>, Fault> {
        let Some(scalar) = self.scalar(key)? else { return Ok(None) };
        match scalar.text.parse() {
            Ok(n) if (least..=most).contains(&n) => Ok(Some(n)),
            _ => {
                let reason = format!("`{key}` is a whole number from {least} to {most}, not `{}`", scalar.text);
                Err(Fault::new(scalar.at, reason))
            }
        }
    }

    /// A list of texts.
    pub(super) fn list(&mut self, key: &'static str) -> Result<Option<Vec<Scalar>>, Fault> {
        match self.take(key) {
            None => Ok(None),
            Some(value) => scalars(key, value).map(Some),
        }
    }

    /// That `key` is not there, told where a key stands that no kind has, if one does: it may be meant.
    pub(super) fn missing(&self, key: &str, hint: &str) -> Fault {
        let strangers = self.entries.iter().filter(|(name, _)| !KEYS.contains(&name.as_str()));
        let fault = match strangers.min_by_key(|(_, (at, _))| *at) {
            None => Fault::new(0, format!("`{key}` is missing")),
            Some((name, (at, _))) => Fault::new(*at, format!("`{key}` is missing, and the key `{name}` is not known")),
        };
        fault.hint(hint)
    }

    /// Refuses keys that nobody has asked for.
    pub(super) fn finish(self) -> Result<(), Fault> {
        let Some((key, (at, _))) = self.entries.into_iter().min_by_key(|(_, (at, _))| *at) else { return Ok(()) };
        let known = self.asked.join(", ");
        let error = NameError::unknown("key", &key, self.asked);
        Err(Fault::new(at, error.to_string()).hint(format!("the keys of this kind: {known}")))
    }
}

/// The items of a list, none of which may be a list.
pub(super) fn scalars(key: &str, value: Value) -> Result<Vec<Scalar>, Fault> {
    let Value::List { items, .. } = value else {
        return Err(Fault::new(
            value.at(),
            format!("`{key}` is a list: {}", if key == "claims" { "[\"A-stable\"]" } else { "[\"1/2\", \"1/2\"]" }),
        ));
    };
    let item = |value| match value {
        Value::Scalar(scalar) => Ok(scalar),
        Value::List { at, .. } => Err(Fault::new(at, format!("`{key}` is a list of numbers, not of lists"))),
    };
    items.into_iter().map(item).collect()
}

fn convert(text: &str, span: std::ops::Range<usize>, value: &DeValue<'_>) -> Result<Value, Fault> {
    let at = span.start;
    let scalar = |text: &str, at| Ok(Value::Scalar(Scalar { text: text.to_owned(), at }));
    match value {
        // What stands between plain quotes starts one byte later; after escapes, places within are approximate.
        DeValue::String(inner) => scalar(inner, at + if text[at..].starts_with("\"\"\"") { 3 } else { 1 }),
        DeValue::Integer(_) | DeValue::Float(_) => scalar(text.get(span).unwrap_or_default(), at),
        DeValue::Array(items) => {
            let items = items.iter().map(|item| convert(text, item.span(), item.get_ref()));
            Ok(Value::List { items: items.collect::<Result<_, _>>()?, at })
        }
        other => Err(Fault::new(at, format!("a {} means nothing here", other.type_str()))),
    }
}
