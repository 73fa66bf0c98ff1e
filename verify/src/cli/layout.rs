//! Text for a terminal of 80 columns.

use std::io::{self, Write};
use std::sync::OnceLock;

pub(super) use verify::measure::decimal::{counted, decimals, number, plain, significant, trimmed};

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

/// Writes a message line by line, those that are too long broken at blanks.
pub(super) fn message(out: &mut impl Write, label: &str, text: &str) -> io::Result<()> {
    for (k, line) in text.trim_end().lines().enumerate() {
        let label = if k == 0 { label } else { "" };
        if width(label) + width(line) <= columns() {
            writeln!(out, "{label}{line}")?;
        } else {
            let own = line.len() - line.trim_start().len();
            paragraph(out, label, width(label).max(own), line)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

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
