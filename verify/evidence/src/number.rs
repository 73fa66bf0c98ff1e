//! Numbers as text, everywhere the same: short for people, exact for files.

use serde::Serializer;

/// JSON has no word for a number that is not finite; it becomes the string `NaN`, `inf` or `-inf`, never `null`.
pub(super) fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if value.is_finite() { serializer.serialize_f64(*value) } else { serializer.collect_str(value) }
}

/// Four significant digits: `1.234×10⁻⁵`.
pub fn short(value: f64) -> String {
    Short::new(value, 4).text()
}

/// So many significant digits.
pub fn digits(value: f64, count: usize) -> String {
    Short::new(value, count).text()
}

/// A number in the digits that a bound on its error leaves: the last is right to a unit. One at least.
pub fn resolved(value: f64, bound: f64) -> f64 {
    let digits = (value / bound).abs().log10().floor().clamp(1.0, 17.0) as usize;
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

/// Two significant digits, for a sentence: `3.6`, `0.84`, `120`, `1.2×10⁻⁵`.
pub fn brief(value: f64) -> String {
    let text = Short::new(value, 2);
    match text.exponent {
        // Up to five digits before the point are written out.
        Some(2..=4) => {
            let unit = 10_f64.powf(value.abs().log10().floor() - 1.0);
            format!("{}", (value / unit).round() * unit)
        }
        _ => text.text(),
    }
}

/// What a measurement says that was not repeated: `about 3` where its least and its most have the same first digit, or two where that is
/// a 1, and else as [`between`], with `about` before it.
pub fn about(least: f64, most: f64) -> String {
    let rounded = |value: f64| {
        let two = format!("{value:.1e}");
        let text = if two.starts_with('1') { two } else { format!("{value:.0e}") };
        brief(text.parse().unwrap_or(value))
    };
    let both = [least, most].map(rounded);
    if both[0] == both[1] { format!("about {}", both[0]) } else { format!("about {}", between(least, most)) }
}

/// What a measurement says that was repeated, two significant digits of its least and of its most, rounded so that all lies between
/// them: `13 to 15`, and `1.6` where the two have the same to the nearest.
pub fn between(least: f64, most: f64) -> String {
    let nearest = brief(least);
    if nearest == brief(most) {
        nearest
    } else {
        format!("{} to {}", brief(rounded_down(least, 2)), brief(rounded_up(most, 2)))
    }
}

/// The least number of so many significant digits that is no less than `value`: what a sentence may say with "at most".
pub fn rounded_up(value: f64, digits: usize) -> f64 {
    // The digits are those of a decimal text, which reads back as a number a rounding away from it.
    let step = |x: f64| format!("{x:.*e}", digits - 1).parse().unwrap_or(x);
    let near: f64 = step(value);
    let unit = 10_f64.powf(value.abs().log10().floor() - (digits - 1) as f64);
    if value - near > 1e-9 * near.abs() { step(near + unit) } else { near }
}

/// The largest number of so many significant digits that is no more than `value`: what a sentence may say with "at least", or "or more".
pub fn rounded_down(value: f64, digits: usize) -> f64 {
    -rounded_up(-value, digits)
}

/// A bound: as it was chosen if that takes six digits at most, and otherwise four digits of it. One a little beyond 1 shows
/// by how much.
pub fn bound(value: f64) -> String {
    let excess = value - 1.0;
    match excess != 0.0 && excess.abs() < 1e-4 {
        true => format!("1 {} {}", if excess > 0.0 { '+' } else { '−' }, Short::new(excess.abs(), 1).text()),
        false => {
            let is_exact = |digits: usize| format!("{value:.*e}", digits - 1).parse() == Ok(value);
            Short::new(value, if !is_exact(4) && is_exact(6) { 6 } else { 4 }).text()
        }
    }
}

/// Shortest text that reads back as the same number: `0.1`, `1e-6`, `inf`, `NaN`.
pub fn exact(value: f64) -> String {
    // Rust's `{:?}` round-trips and switches to exponents at 1e16 and 1e-5, but keeps `.0` on whole numbers.
    let text = format!("{value:?}");
    text.strip_suffix(".0").map(str::to_owned).unwrap_or(text)
}

/// A number cut to `digits` significant digits, apart into its decimal mantissa and power of ten.
#[derive(Debug, PartialEq)]
struct Short {
    /// Digits with a proper minus sign, or the name of a value that is not finite.
    mantissa: String,
    /// Power of ten to multiply by, where the number is too large or too small to be written out.
    exponent: Option<i32>,
}

impl Short {
    /// Trailing zeros stay only where digits were cut: `2` is two exactly, `2.000` was rounded.
    fn new(value: f64, digits: usize) -> Self {
        if value.is_nan() {
            return Self { mantissa: "not a number".into(), exponent: None };
        }
        if value.is_infinite() {
            return Self { mantissa: if value > 0.0 { "∞".into() } else { "−∞".into() }, exponent: None };
        }
        if value == 0.0 {
            return Self { mantissa: "0".into(), exponent: None };
        }
        // `{:e}` rounds to the digits asked for and only then settles the exponent: 9.9999 becomes 1.000e1.
        let rounded = format!("{value:.*e}", digits - 1);
        let (mantissa, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
        let exponent: i32 = exponent.parse().unwrap_or(0);
        let is_exact = rounded.parse() == Ok(value);
        let (text, exponent) = if (-3..digits as i32 + 1).contains(&exponent) {
            let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
            // From the rounded text, so that five-digit numbers show no more than the digits asked for.
            (format!("{:.decimals$}", rounded.parse().unwrap_or(value)), None)
        } else {
            (mantissa.to_owned(), Some(exponent))
        };
        let text = match is_exact && text.contains('.') {
            true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
            false => text,
        };
        Self { mantissa: text.replace('-', "−"), exponent }
    }

    /// Plain text: `1.234×10⁻⁵`.
    fn text(&self) -> String {
        match (self.exponent, self.mantissa.as_str()) {
            (None, mantissa) => mantissa.into(),
            (Some(exponent), "1") => power_of_ten(exponent),
            (Some(exponent), "−1") => format!("−{}", power_of_ten(exponent)),
            (Some(exponent), mantissa) => format!("{mantissa}×{}", power_of_ten(exponent)),
        }
    }
}

/// `10⁻⁵`.
pub fn power_of_ten(exponent: i32) -> String {
    let raised = |c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' | '4'..='9' => char::from_u32('⁰' as u32 + (c as u32 - '0' as u32)).unwrap_or(c),
        other => other,
    };
    std::iter::once('1').chain(std::iter::once('0')).chain(exponent.to_string().chars().map(raised)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_has_the_digits_that_its_bound_leaves() {
        assert_eq!(resolved(-3.937_41e-8, 3e-11), -3.94e-8);
        assert_eq!(resolved(2.0 / 3.0, 0.005), 0.67);
        assert_eq!(resolved(0.7, 0.5), 0.7);
        assert_eq!(resolved(1.0 / 3.0, 0.0), 1.0 / 3.0);
    }

    #[test]
    fn what_repetitions_agree_on_has_two_digits() {
        let cases = [
            ((1.55, 1.63), "1.6"),
            ((13.5, 15.3), "13 to 16"),
            ((12.04, 12.83), "12 to 13"),
            ((1.38, 1.81), "1.3 to 1.9"),
            ((0.936, 1.0), "0.93 to 1"),
            ((9.96, 99.6), "9.9 to 100"),
            ((99.6, 996.0), "99 to 1000"),
            ((-2.34, -0.51), "−2.4 to −0.51"),
            ((0.0023, 0.0025), "0.0023 to 0.0025"),
            ((f64::NAN, 2.0), "not a number to 2"),
        ];
        for ((least, most), text) in cases {
            assert_eq!(between(least, most), text);
        }
    }

    #[test]
    fn a_bound_lies_on_its_side_of_the_number_and_next_to_it() {
        let cases = [
            (1.765, [1.7, 1.8]),
            (0.9364, [0.93, 0.94]),
            (12.68, [12.0, 13.0]),
            (-0.8424, [-0.85, -0.84]),
            (0.5, [0.5; 2]),
        ];
        for (value, bounds) in cases {
            assert_eq!([rounded_down(value, 2), rounded_up(value, 2)], bounds, "{value}");
        }
        assert_eq!([rounded_up(0.009_080_4, 4), rounded_down(2.174_83, 4)], [0.009_081, 2.174]);
        assert_eq!([rounded_up(0.0, 3), rounded_down(f64::INFINITY, 3)], [0.0, f64::INFINITY]);
        assert!(rounded_up(f64::NAN, 2).is_nan());
        for k in 1..2000 {
            let value = f64::from(k).powf(3.7) * 1e-9;
            for digits in 2..5 {
                let [low, high] = [rounded_down(value, digits), rounded_up(value, digits)];
                let unit = 1.001 * 10_f64.powf(value.log10().floor() - (digits - 1) as f64);
                assert!(low <= value * (1.0 + 2e-9) && value <= high * (1.0 + 2e-9), "{low} {value} {high}");
                assert!(high - low <= unit, "{low} {value} {high}");
            }
        }
    }

    #[test]
    fn what_was_not_repeated_has_one_digit_or_a_range_that_it_lies_in() {
        let cases = [
            ((2.9, 3.2), "about 3"),
            ((1.8, 4.11), "about 1.8 to 4.2"),
            ((74.0, 93.0), "about 74 to 93"),
            ((19.3, 21.9), "about 19 to 22"),
        ];
        for ((least, most), text) in cases {
            assert_eq!(about(least, most), text);
        }
        assert_eq!(about(0.0031, 0.0058), "about 0.0031 to 0.0058");
        assert_eq!([about(9.6, 10.2), about(12.9, 13.4), about(8.0, 12.9)], ["about 10", "about 13", "about 8 to 13"]);
    }

    #[test]
    fn short_numbers_read_as_a_person_would_write_them() {
        let cases = [
            (0.0, "0"),
            (2.0, "2"),
            (2.00004, "2.000"),
            (-0.5, "−0.5"),
            (1.0 / 3.0, "0.3333"),
            (9.99999, "10.00"),
            (12345.6, "12350"),
            (99999.0, "1.000×10⁵"),
            (123456.0, "1.235×10⁵"),
            (1e6, "10⁶"),
            (1e-6, "10⁻⁶"),
            (-1e-6, "−10⁻⁶"),
            (0.00099999, "0.001000"),
            (0.0009999, "9.999×10⁻⁴"),
            (0.001, "0.001"),
            (-1.23456e-17, "−1.235×10⁻¹⁷"),
            (f64::MIN_POSITIVE, "2.225×10⁻³⁰⁸"),
            (f64::NAN, "not a number"),
            (f64::NEG_INFINITY, "−∞"),
        ];
        for (value, expected) in cases {
            assert_eq!(Short::new(value, 4).text(), expected, "{value:?}");
        }
    }

    #[test]
    fn a_brief_number_is_written_out_up_to_five_digits() {
        let cases = [
            (3.62, "3.6"),
            (0.8449, "0.84"),
            (123.4, "120"),
            (1234.5, "1200"),
            (12_345.0, "12000"),
            (99_499.0, "99000"),
        ];
        cases.iter().for_each(|(value, text)| assert_eq!(brief(*value), *text));
        assert_eq!([brief(123_456.0), brief(1.234e-5)], ["1.2×10⁵", "1.2×10⁻⁵"]);
    }

    #[test]
    fn bounds_show_what_was_chosen() {
        let cases = [(1.0, "1"), (0.3, "0.3"), (10.0, "10"), (0.0123456, "0.0123456"), (1.0 / 3.0, "0.3333")];
        cases.iter().for_each(|(value, text)| assert_eq!(bound(*value), *text));
        assert_eq!(bound(1.0 + 1e-7), "1 + 10⁻⁷");
        assert_eq!(bound(1.0 - 2e-5), "1 − 2×10⁻⁵");
        // An excess that four digits show is shown by them.
        assert_eq!([bound(1.0005), bound(0.9995), bound(1.0 + 9e-5)], ["1.0005", "0.9995", "1 + 9×10⁻⁵"]);
    }

    #[test]
    fn exact_numbers_read_back_bit_for_bit() {
        for value in [0.1, 1e-6, -0.0, 1.0, 123456789.0, 1e300, 5e-324, f64::MAX, f64::INFINITY, 0.1 + 0.2] {
            let read: f64 = exact(value).parse().expect("a number");
            assert_eq!(read.to_bits(), value.to_bits(), "{value:?}");
        }
        assert_eq!(exact(f64::NAN), "NaN");
        assert_eq!(exact(3.0), "3");
    }
}
