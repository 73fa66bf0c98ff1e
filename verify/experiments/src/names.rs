//! Names given by users: registries, calls with arguments, parameters, and suggestions for mistyped ones.

use std::collections::BTreeMap;
use std::ops::{Range, RangeInclusive};

use thiserror::Error;

/// A name, argument or parameter that means nothing here.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum NameError {
    /// No entry of a registry has this name.
    #[error("unknown {kind} `{name}`{}", hint(.suggestion.as_deref()))]
    Unknown {
        /// What was looked for: `problem`, `method`, `parameter`.
        kind: &'static str,
        /// The offending name.
        name: String,
        /// The known name nearest to it.
        suggestion: Option<String>,
    },
    /// A call that does not have the form `name` or `name(argument,…)`.
    #[error("`{call}` is not of the form {form}: {reason}")]
    Form {
        /// The offending text.
        call: String,
        /// What was expected.
        form: String,
        /// What is wrong.
        reason: String,
    },
    /// A parameter with a value it cannot take.
    #[error("{parameter} = {value}: {reason}")]
    Value {
        /// The parameter.
        parameter: String,
        /// The offending value.
        value: String,
        /// What is wrong.
        reason: String,
    },
}

fn hint(suggestion: Option<&str>) -> String {
    suggestion.map_or_else(String::new, |s| format!("; did you mean `{s}`?"))
}

impl NameError {
    /// `name` is none of `known`; suggests the nearest.
    pub fn unknown<'a>(kind: &'static str, name: &str, known: impl IntoIterator<Item = &'a str>) -> Self {
        let similarity = |k: &str| if k.eq_ignore_ascii_case(name) { 1.0 } else { strsim::jaro_winkler(name, k) };
        // Below a Jaro–Winkler similarity of 0.8 a suggestion is a guess.
        let suggestion = known
            .into_iter()
            .map(|k| (similarity(k), k))
            .filter(|(similarity, _)| *similarity > 0.8)
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, k)| k.to_owned());
        Self::Unknown { kind, name: name.to_owned(), suggestion }
    }
}

/// `name` or `name(a,b,…)`, with blanks around the parts ignored.
#[derive(Debug, Clone, PartialEq)]
pub struct Call {
    /// What stands before the bracket.
    pub name: String,
    /// The arguments, trimmed; none without a bracket.
    pub arguments: Vec<String>,
}

impl Call {
    /// Splits `text`.
    ///
    /// # Errors
    /// [`NameError::Form`] if brackets do not close, or an argument is empty.
    pub fn parse(text: &str) -> Result<Self, NameError> {
        let text = text.trim();
        let malformed = |reason: &str| NameError::Form {
            call: text.to_owned(),
            form: "`name` or `name(argument,…)`".into(),
            reason: reason.into(),
        };
        let Some((name, rest)) = text.split_once('(') else {
            return if text.contains(')') {
                Err(malformed("it closes a bracket that it does not open"))
            } else {
                Ok(Self { name: text.to_owned(), arguments: Vec::new() })
            };
        };
        let inside = rest.strip_suffix(')').ok_or_else(|| malformed("the bracket does not close at the end"))?;
        if inside.contains(['(', ')']) {
            return Err(malformed("brackets inside brackets"));
        }
        let arguments: Vec<String> = inside.split(',').map(|a| a.trim().to_owned()).collect();
        if arguments.iter().any(String::is_empty) {
            return Err(malformed("an argument is missing"));
        }
        Ok(Self { name: name.trim().to_owned(), arguments })
    }

    /// The arguments as `N` numbers.
    ///
    /// # Errors
    /// [`NameError::Form`] for another count, or one that is not a finite number; `form` is named in it.
    pub fn numbers<const N: usize>(&self, form: &str) -> Result<[f64; N], NameError> {
        let malformed = |reason: String| NameError::Form { call: self.to_string(), form: form.into(), reason };
        let values = self
            .arguments
            .iter()
            .map(|a| match a.parse::<f64>() {
                Ok(x) if x.is_finite() => Ok(x),
                _ => Err(malformed(format!("`{a}` is not a finite number"))),
            })
            .collect::<Result<Vec<f64>, _>>()?;
        let found = values.len();
        values.try_into().map_err(|_| malformed(format!("it has {found} arguments, not {N}")))
    }
}

impl std::fmt::Display for Call {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.name)?;
        if self.arguments.is_empty() { Ok(()) } else { write!(f, "({})", self.arguments.join(",")) }
    }
}

/// A parameter of a problem.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Name in `--set name=value`.
    pub name: &'static str,
    /// Value where none is set.
    pub default: &'static str,
    /// Meaning and range, in a few words.
    pub meaning: &'static str,
}

/// The parameters of a problem with the values set for them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Parameters {
    values: BTreeMap<&'static str, String>,
}

impl Parameters {
    /// Defaults of `known`, overridden by `set`, pairs of name and value.
    ///
    /// # Errors
    /// [`NameError::Unknown`] for a name that is not among `known`.
    pub fn new(known: &[Parameter], set: &[(String, String)]) -> Result<Self, NameError> {
        let mut values: BTreeMap<_, _> = known.iter().map(|p| (p.name, p.default.to_owned())).collect();
        for (name, value) in set {
            match values.get_mut(name.as_str()) {
                Some(slot) => *slot = value.trim().to_owned(),
                None => return Err(NameError::unknown("parameter", name, known.iter().map(|p| p.name))),
            }
        }
        Ok(Self { values })
    }

    /// The text of parameter `name`.
    ///
    /// # Errors
    /// [`NameError::Unknown`] if the problem has no such parameter.
    pub fn text(&self, name: &str) -> Result<&str, NameError> {
        match self.values.get(name) {
            Some(value) => Ok(value),
            None => Err(NameError::unknown("parameter", name, self.values.keys().copied())),
        }
    }

    /// The value of `name` as a finite number.
    ///
    /// # Errors
    /// [`NameError::Value`] if it is none.
    pub fn number(&self, name: &str) -> Result<f64, NameError> {
        let value = self.text(name)?;
        match value.parse::<f64>() {
            Ok(x) if x.is_finite() => Ok(x),
            _ => Err(Self::refuse(name, value, "not a finite number")),
        }
    }

    /// The value of `name` as a positive number.
    ///
    /// # Errors
    /// [`NameError::Value`] if it is none.
    pub fn positive(&self, name: &str) -> Result<f64, NameError> {
        match self.number(name)? {
            x if x > 0.0 => Ok(x),
            x => Err(Self::refuse(name, &x.to_string(), "must be positive")),
        }
    }

    /// The value of `name` in the half-open interval `range`.
    ///
    /// # Errors
    /// [`NameError::Value`] if it lies outside or is no number.
    pub fn within(&self, name: &str, range: Range<f64>) -> Result<f64, NameError> {
        match self.number(name)? {
            x if range.contains(&x) => Ok(x),
            x => Err(Self::refuse(name, &x.to_string(), &format!("must lie in [{}, {})", range.start, range.end))),
        }
    }

    /// The value of `name` as a whole number in `range`.
    ///
    /// # Errors
    /// [`NameError::Value`] if it is none.
    pub fn count(&self, name: &str, range: RangeInclusive<usize>) -> Result<usize, NameError> {
        let value = self.text(name)?;
        let whole = || format!("must be a whole number from {} to {}", range.start(), range.end());
        value.parse().ok().filter(|n| range.contains(n)).ok_or_else(|| Self::refuse(name, value, &whole()))
    }

    /// The value of `name`, one of `choices`.
    ///
    /// # Errors
    /// [`NameError::Value`] for any other.
    pub fn choice<T: Copy>(&self, name: &str, choices: &[(&str, T)]) -> Result<T, NameError> {
        let value = self.text(name)?;
        choices.iter().find(|(text, _)| *text == value).map(|(_, choice)| *choice).ok_or_else(|| {
            let list: Vec<_> = choices.iter().map(|(text, _)| *text).collect();
            Self::refuse(name, value, &format!("must be one of {}", list.join(", ")))
        })
    }

    /// Every name with its value, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.values.iter().map(|(name, value)| (*name, value.as_str()))
    }

    fn refuse(parameter: &str, value: &str, reason: &str) -> NameError {
        NameError::Value { parameter: parameter.into(), value: value.into(), reason: reason.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calls_take_signs_blanks_and_exponents() {
        let call = Call::parse(" linear( -1.5e-3 , +2 ) ").expect("well-formed");
        assert_eq!(call.name, "linear");
        assert_eq!(call.numbers::<2>("linear(ALPHA,BETA)"), Ok([-1.5e-3, 2.0]));
        for bad in ["linear(1,2", "linear)", "linear(,2)", "linear()", "linear(1,(2))", "linear(1,2)x"] {
            assert!(matches!(Call::parse(bad), Err(NameError::Form { .. })), "{bad}");
        }
        for bad in ["linear(1)", "linear(1,2,3)", "linear(a,2)", "linear(inf,2)", "linear(NaN,1)"] {
            let call = Call::parse(bad).expect("well-formed");
            assert!(matches!(call.numbers::<2>("linear(ALPHA,BETA)"), Err(NameError::Form { .. })), "{bad}");
        }
    }

    #[test]
    fn mistyped_names_get_a_suggestion() {
        let error = NameError::unknown("problem", "quadratic-darg", ["linear-drag", "quadratic-drag"]);
        assert_eq!(error.to_string(), "unknown problem `quadratic-darg`; did you mean `quadratic-drag`?");
        let error = NameError::unknown("problem", "xyz", ["linear-drag"]);
        assert_eq!(error.to_string(), "unknown problem `xyz`");
    }
}
