//! Numbers as decimal text, for a terminal and for sentences.

/// Six significant digits in at most twelve columns: `0.333333`, `1.23457e-10`.
#[must_use]
pub fn number(x: f64) -> String {
    significant(x, 6)
}

/// The same without trailing zeros, for numbers that were chosen rather than computed: `0.3`, `10`.
#[must_use]
pub fn plain(x: f64) -> String {
    trimmed(x, 6)
}

/// So many significant digits at most, without trailing zeros.
#[must_use]
pub fn trimmed(x: f64, digits: usize) -> String {
    let text = significant(x, digits);
    let (digits, exponent) = text.find('e').map_or((text.as_str(), ""), |e| text.split_at(e));
    match digits.contains('.') {
        true => format!("{}{exponent}", digits.trim_end_matches('0').trim_end_matches('.')),
        false => text,
    }
}

/// `digits` significant digits, with an exponent where the plain form is longer.
#[must_use]
pub fn significant(x: f64, digits: usize) -> String {
    if x == 0.0 {
        return "0".into();
    }
    let scientific = format!("{x:.*e}", digits - 1);
    // NaN and infinities have no exponent.
    let Some(exponent) = scientific.split_once('e').and_then(|(_, e)| e.parse::<i32>().ok()) else {
        return scientific;
    };
    match usize::try_from(digits as i32 - 1 - exponent) {
        Ok(decimals) if exponent >= -3 => format!("{x:.decimals$}"),
        _ => scientific,
    }
}

/// A slope to so many places, with a proper minus sign, and without one where nothing but zeros is left of it.
#[must_use]
pub fn decimals(slope: f64, places: usize) -> String {
    let text = format!("{slope:.places$}");
    match text.strip_prefix('-') {
        Some(zero) if !zero.contains(|c: char| matches!(c, '1'..='9' | 'i')) => zero.to_owned(),
        Some(size) => format!("−{size}"),
        None => text,
    }
}

/// A slope to three places, or as many as two digits of its uncertainty have, and that beside it.
#[must_use]
pub fn uncertain(slope: f64, by: f64) -> String {
    // Not a number leaves no place unsaid.
    let places = if by > 0.0 { (1.0 - by.log10().floor()).clamp(0.0, 3.0) as usize } else { 3 };
    format!("{} ± {by:.1e}", decimals(slope, places))
}

/// So many of what a noun names: `1 row`, `2 rows`, `3 entries`.
#[must_use]
pub fn counted(n: usize, noun: &str) -> String {
    match (n, noun.strip_suffix('y')) {
        (1, _) => format!("1 {noun}"),
        (_, Some(stem)) => format!("{n} {stem}ies"),
        (_, None) => format!("{n} {noun}s"),
    }
}

/// A number as it is printed, by Fortran too: `1.5D-3`.
#[must_use]
pub fn parsed(text: &str) -> Option<f64> {
    text.parse().ok().or_else(|| text.replace(['d', 'D'], "e").parse().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_has_no_more_digits_than_its_uncertainty() {
        for (slope, by, text) in [
            (2.00846, 2.3e-3, "2.008 ± 2.3e-3"),
            (-0.4567, 0.0222, "−0.457 ± 2.2e-2"),
            (1.9584, 0.131, "1.96 ± 1.3e-1"),
            (1.9584, 4.2, "2.0 ± 4.2e0"),
            (2.0, 0.0, "2.000 ± 0.0e0"),
            (2.0, f64::NAN, "2.000 ± NaN"),
        ] {
            assert_eq!(uncertain(slope, by), text);
        }
    }

    #[test]
    fn what_is_counted_agrees_with_its_number() {
        assert_eq!([0, 1, 2].map(|n| counted(n, "row")), ["0 rows", "1 row", "2 rows"]);
        assert_eq!([1, 3].map(|n| counted(n, "entry")), ["1 entry", "3 entries"]);
    }

    #[test]
    fn numbers_fit_their_column() {
        for (x, text) in [
            (0.0, "0"),
            (1.0 / 3.0, "0.333333"),
            (-0.001234567, "-0.00123457"),
            (0.00012345678, "1.23457e-4"),
            (999999.7, "1.00000e6"),
            (99999.96, "100000"),
            (-1.0e-300, "-1.00000e-300"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-inf"),
        ] {
            assert_eq!(number(x), text);
        }
        for (x, text) in [(10.0, "10"), (0.1 + 0.2, "0.3"), (1e-9, "1e-9"), (100000.0, "100000"), (0.0, "0")] {
            assert_eq!(plain(x), text);
        }
        // What a sum of steps or a product leaves in the last bits is no digit of the number.
        for (x, text) in [(2.9699999999999998, "2.97"), (1.500000001689936, "1.5"), (1.00000001, "1.00000001")] {
            assert_eq!(trimmed(x, 9), text);
        }
    }
}
