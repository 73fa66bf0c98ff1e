//! Text for a terminal of 80 columns.

use std::io::{self, Write};
use std::sync::OnceLock;

/// Columns of a terminal that does not say otherwise.
const WIDTH: usize = 80;

/// Columns that text may take: as `COLUMNS` says, where that leaves room for a few words.
pub(super) fn columns() -> usize {
    static COLUMNS: OnceLock<usize> = OnceLock::new();
    let said = || std::env::var("COLUMNS").ok()?.parse().ok().filter(|columns| (40..=500).contains(columns));
    *COLUMNS.get_or_init(|| said().unwrap_or(WIDTH))
}

/// Columns that `text` takes up; combining marks (v̇) take none.
pub(super) fn width(text: &str) -> usize {
    text.chars().filter(|c| !('\u{300}'..='\u{36f}').contains(c)).count()
}

/// `text` with blanks on its right up to `columns`.
pub(super) fn left(text: &str, columns: usize) -> String {
    format!("{text}{}", " ".repeat(columns.saturating_sub(width(text))))
}

/// `text` with blanks on its left up to `columns`.
pub(super) fn right(text: &str, columns: usize) -> String {
    format!("{}{text}", " ".repeat(columns.saturating_sub(width(text))))
}

/// Writes `label`, then `text` broken at blanks so that all of it stands right of column `indent`.
pub(super) fn paragraph(out: &mut impl Write, label: &str, indent: usize, text: &str) -> io::Result<()> {
    let mut line = left(label, indent);
    let mut is_empty = true;
    for word in text.split_whitespace() {
        if !is_empty && width(&line) + 1 + width(word) > columns() {
            writeln!(out, "{line}")?;
            line = " ".repeat(indent);
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
        }
        line.push_str(word);
        is_empty = false;
    }
    writeln!(out, "{}", line.trim_end())
}

/// Six significant digits in at most twelve columns: `0.333333`, `1.23457e-10`.
pub(super) fn number(x: f64) -> String {
    significant(x, 6)
}

/// The same without trailing zeros, for numbers that were chosen rather than computed: `0.3`, `10`.
pub(super) fn plain(x: f64) -> String {
    let text = number(x);
    let (digits, exponent) = text.find('e').map_or((text.as_str(), ""), |e| text.split_at(e));
    match digits.contains('.') {
        true => format!("{}{exponent}", digits.trim_end_matches('0').trim_end_matches('.')),
        false => text,
    }
}

/// `digits` significant digits, with an exponent where the plain form is longer.
pub(super) fn significant(x: f64, digits: usize) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;

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
    }

    #[test]
    fn paragraphs_break_at_blanks_and_count_marks_as_nothing() {
        let mut out = Vec::new();
        paragraph(&mut out, "  label", 10, &"v̇= ".repeat(40)).expect("memory");
        let text = String::from_utf8(out).expect("text");
        let lines: Vec<_> = text.lines().collect();
        assert!(lines[0].starts_with("  label   v̇= v̇=") && lines[1].starts_with("          v̇="));
        assert_eq!(lines.len(), 2);
        assert!(lines.iter().all(|line| width(line) <= WIDTH));
        assert_eq!(width(lines[0]), 10 + 23 * 3 - 1);
    }
}
