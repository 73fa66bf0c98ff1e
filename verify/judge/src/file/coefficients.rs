//! Lists of coefficients from their keys, each a text with its place.

use super::super::expression::{Expression, Malformed, Rounding};
use super::super::tableau::Coefficient;
use super::document::{Document, Scalar, Value, scalars};
use super::error::Fault;
use experiments::measure::decimal::counted;

/// Most stages or steps; the methods of order 14 have 35.
pub(super) const MOST: usize = 40;

/// A text and what it says.
pub(super) type Parsed = (Scalar, Expression);

/// The list under `key`, of `length` entries where that is given.
pub(super) fn list(
    document: &mut Document,
    key: &'static str,
    length: Option<usize>,
) -> Result<Option<Vec<Parsed>>, Fault> {
    let Some(found) = document.list(key)? else { return Ok(None) };
    let at = found.first().map_or(0, |first| first.at);
    match length {
        Some(length) if found.len() != length => {
            let reason = format!("`{key}` has {} where there should be {length}", counted(found.len(), "entry"));
            Err(Fault::new(at, reason))
        }
        None if found.is_empty() || found.len() > MOST => {
            Err(Fault::new(at, format!("`{key}` has {}; there are 1 to {MOST}", counted(found.len(), "entry"))))
        }
        _ => parse(found).map(Some),
    }
}

/// The same, which has to be there.
pub(super) fn required(
    document: &mut Document,
    key: &'static str,
    length: Option<usize>,
    hint: &str,
) -> Result<Vec<Parsed>, Fault> {
    list(document, key, length)?.ok_or_else(|| document.missing(key, hint))
}

/// The rows of a matrix of order s under `key`: all of s entries, or lower triangles without or with their diagonal, a row of no
/// entries left out.
pub(super) fn matrix(
    document: &mut Document,
    key: &'static str,
    s: usize,
    hint: &str,
) -> Result<Vec<Vec<Parsed>>, Fault> {
    let value = document.take(key).ok_or_else(|| document.missing(key, hint))?;
    let at = value.at();
    let Value::List { items, .. } = value else {
        return Err(Fault::new(at, format!("`{key}` is a list of rows: [[], [\"1/2\"]]")));
    };
    let mut rows = Vec::new();
    for item in items {
        let at = item.at();
        rows.push((at, parse(scalars(key, item)?)?));
    }
    let leaves_out_first =
        rows.first().is_some_and(|(_, row)| row.len() == 1) && rows.last().is_some_and(|(_, row)| row.len() + 1 == s);
    if rows.len() + 1 == s && (s == 1 || leaves_out_first) {
        rows.insert(0, (at, Vec::new()));
    }
    if rows.len() != s {
        let reason = format!("`{key}` has {} beside {}", counted(rows.len(), "row"), counted(s, "weight"));
        return Err(Fault::new(at, reason).hint("each stage has a row and a weight; a first row without entries is []"));
    }
    for (i, (at, row)) in rows.iter().enumerate() {
        let fits = row.len() == s || row.len() == i || row.len() == i + 1;
        if !fits {
            let reason = format!("row {} of `{key}` has {}", i + 1, counted(row.len(), "entry"));
            let hint = match s {
                1 => "a row of a method of one stage has one entry, or none".to_owned(),
                _ => format!(
                    "a row has all {s} entries, or those left of the diagonal, with it or without: {i} or {}",
                    i + 1
                ),
            };
            return Err(Fault::new(*at, reason).hint(hint));
        }
    }
    Ok(rows.into_iter().map(|(_, row)| row).collect())
}

fn parse(list: Vec<Scalar>) -> Result<Vec<Parsed>, Fault> {
    list.into_iter().map(one).collect()
}

/// A single text.
pub(super) fn one(scalar: Scalar) -> Result<Parsed, Fault> {
    match Expression::parse(&scalar.text) {
        Ok(expression) => Ok((scalar, expression)),
        Err(malformed) => Err(fault(&scalar, malformed)),
    }
}

pub(super) fn fault(scalar: &Scalar, malformed: Malformed) -> Fault {
    let hint = "a coefficient is a number, or a text like \"1/2 - sqrt(3)/6\"";
    let reason = format!("in `{}`: {}", excerpt(&scalar.text, malformed.at), malformed.reason);
    Fault::new(scalar.at + malformed.at, reason).hint(hint)
}

/// What stands in `text` around the byte `at`.
fn excerpt(text: &str, at: usize) -> String {
    const AROUND: usize = 24;
    let before = text.char_indices().filter(|(k, _)| *k < at).count();
    let (skipped, shown) = (before.saturating_sub(AROUND), 2 * AROUND);
    let (start, end) =
        (if skipped > 0 { "…" } else { "" }, if text.chars().count() > skipped + shown { "…" } else { "" });
    format!("{start}{}{end}", text.chars().skip(skipped).take(shown).collect::<String>())
}

/// How the decimals among `all` are rounded: as declared, or as the longest shows.
pub(super) fn rounding<'a>(digits: Option<u32>, all: impl Iterator<Item = &'a Parsed>) -> Rounding {
    let (mut longest, mut approximates) = (None, false);
    for (_, expression) in all {
        longest = longest.max(expression.places());
        approximates |= expression.approximates();
    }
    Rounding::new(digits, longest).with_approximants(approximates)
}

/// The values of a list.
pub(super) fn values(list: &[Parsed], rounding: Rounding) -> Result<Vec<Coefficient>, Fault> {
    list.iter().map(|parsed| coefficient(parsed, rounding)).collect()
}

/// The values of a matrix of order s, its rows filled up with zeros.
pub(super) fn square(rows: &[Vec<Parsed>], rounding: Rounding) -> Result<Vec<Vec<Coefficient>>, Fault> {
    let mut out = rows.iter().map(|row| values(row, rounding)).collect::<Result<Vec<_>, _>>()?;
    out.iter_mut().for_each(|row| row.resize_with(rows.len(), Coefficient::zero));
    Ok(out)
}

fn coefficient((scalar, expression): &Parsed, rounding: Rounding) -> Result<Coefficient, Fault> {
    let value = expression.evaluate(rounding).map_err(|malformed| fault(scalar, malformed))?;
    Ok(Coefficient { text: scalar.text.trim().to_owned(), exact: value.exact, real: value.real })
}

#[cfg(test)]
mod tests {
    use super::super::{FileError, MethodFile};
    use super::{MOST, Scalar, excerpt, one, rounding};

    #[test]
    fn the_hint_to_a_row_of_a_wrong_length_has_the_right_ones() {
        for (text, expected) in [
            ("b = [1]\na = [[1, 1]]\n", "a row of a method of one stage has one entry, or none"),
            (
                "b = [1, 0, 0]\na = [[], [1, 0, 0], [1]]\n",
                "a row has all 3 entries, or those left of the diagonal, with it or without: 2 or 3",
            ),
        ] {
            let error = MethodFile::parse("m.toml", "m", text).expect_err(text);
            let FileError::Malformed { hint, .. } = error else { panic!("{error}") };
            assert_eq!(hint.as_deref(), Some(expected));
        }
    }

    /// Of 48 characters, 24 of them before the mistake, where the text is longer.
    #[test]
    fn a_long_text_is_shown_around_its_mistake() {
        let letters = |range: std::ops::Range<usize>| -> String {
            range.map(|k| char::from(b'!' + u8::try_from(k).expect("few"))).collect()
        };
        for (length, at, from, shown, start, end) in [
            (48, 0, 0, 48, "", ""),
            (49, 0, 0, 48, "", "…"),
            (49, 24, 0, 48, "", "…"),
            (49, 25, 1, 48, "…", ""),
            (90, 50, 26, 48, "…", "…"),
            (90, 80, 56, 34, "…", ""),
        ] {
            let expected = format!("{start}{}{end}", letters(from..from + shown));
            assert_eq!(excerpt(&letters(0..length), at), expected, "{length} {at}");
        }
        // Places are bytes, and characters are counted.
        assert_eq!(excerpt(&"√".repeat(49), 3 * 25), format!("…{}", "√".repeat(48)));
    }

    #[test]
    fn a_list_has_as_many_entries_as_a_method_may_have_stages() {
        let read = |n: usize| {
            let zeros = ", 0".repeat(n.saturating_sub(2));
            let list = |last: &str| if n == 0 { "[]".to_owned() } else { format!("[-1{zeros}, {last}]") };
            MethodFile::parse(
                "m.toml",
                "m",
                &format!("kind = 'multistep'\nrho = {}\nsigma = {}\n", list("1"), list("1")),
            )
        };
        assert!(read(MOST).is_ok());
        for n in [0, MOST + 1] {
            let Err(error) = read(n) else { panic!("{n} entries") };
            assert!(error.to_string().contains("there are 1 to 40"), "{error}");
        }
    }

    /// Two rows beside three weights, the last of which has two entries.
    #[test]
    fn a_first_row_is_taken_to_be_left_out_where_the_next_has_one_entry() {
        let read = |first: &str| MethodFile::parse("m.toml", "m", &format!("a = [{first}, [0, 1]]\nb = [0, 0, 1]\n"));
        assert!(read("[1]").is_ok());
        let Err(error) = read("[1, 0, 0]") else { panic!("a row is missing") };
        assert!(error.to_string().contains("`a` has 2 rows beside 3 weights"), "{error}");
    }

    #[test]
    fn fractions_that_stand_for_other_numbers_are_told_of_any_entry() {
        let told = |texts: [&str; 2]| {
            let parsed = texts.map(|text| one(Scalar { text: text.into(), at: 0 }).expect("well-formed"));
            rounding(None, parsed.iter()).told()
        };
        let long = "1767732205903/4055673282236";
        for texts in [["1/2", long], [long, "1/2"]] {
            assert!(told(texts).starts_with("fractions p/q"), "{texts:?}");
        }
        assert_eq!(told(["1/2", "1/3"]), "coefficients taken as exact");
    }
}
