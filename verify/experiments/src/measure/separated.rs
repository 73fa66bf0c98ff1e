//! What is wrong with comma-separated values, in words for those who wrote them.

use csv::{Error, ErrorKind, Position};

use super::decimal::counted;

/// The line of `text`, from 1, and what is wrong with it.
pub(crate) fn fault(text: &[u8], error: &Error) -> (u64, String) {
    // Of bytes that are no text the reader does not say where they are.
    let valid = str::from_utf8(text).map_or_else(|error| error.valid_up_to(), str::len);
    let breaks = text[..valid].iter().filter(|byte| **byte == b'\n').count() as u64;
    let line = match error.kind() {
        ErrorKind::Utf8 { .. } => breaks + 1,
        _ => error.position().map_or(1, |at| line_of(text, at)),
    };
    let reason = match error.kind() {
        ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("the row has {}, and the header {expected_len}", counted(*len as usize, "cell"))
        }
        ErrorKind::Utf8 { .. } => "the text is not UTF-8".into(),
        _ => error.to_string(),
    };
    (line, reason)
}

/// The line of `text`, from 1, of the row that the reader found at `position`, which is where the row before ends: what lies between is empty
/// lines, comments and what is left of a line break. All of the text before is looked through: for the row of a fault, not for each.
#[must_use]
pub fn line_of(text: &[u8], position: &Position) -> u64 {
    let mut at = usize::try_from(position.byte()).unwrap_or(usize::MAX).min(text.len());
    let ends = |byte: &u8| [b'\r', b'\n'].contains(byte);
    loop {
        let rest = &text[at..];
        let skipped = match rest.first() {
            Some(byte) if ends(byte) => 1,
            Some(b'#') => rest.iter().position(ends).unwrap_or(rest.len()),
            _ => break,
        };
        at += skipped;
    }
    let before = &text[..at];
    // A break is \n, \r\n or \r.
    let breaks = before
        .iter()
        .zip(before[1.min(at)..].iter().map(Some).chain([None]))
        .filter(|(byte, next)| **byte == b'\n' || **byte == b'\r' && *next != Some(&b'\n'));
    breaks.count() as u64 + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_another_length_and_bytes_that_are_no_text_are_named() {
        let first = |text: &'static [u8]| {
            let mut reader = csv::Reader::from_reader(text);
            fault(text, &reader.records().find_map(Result::err).expect("a fault"))
        };
        assert_eq!(first(b"t,v\n0,1\n1\n"), (3, "the row has 1 cell, and the header 2".into()));
        assert_eq!(first(b"t,v\n0,1,2\n"), (2, "the row has 3 cells, and the header 2".into()));
        assert_eq!(first(b"t,v\n0,\xff\n"), (2, "the text is not UTF-8".into()));
    }

    #[test]
    fn rows_are_counted_whatever_ends_a_line() {
        let lines = |text: &[u8]| {
            let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text);
            let rows = reader.records().map(|row| row.expect("well-formed"));
            rows.map(|row| line_of(text, row.position().expect("a place"))).collect::<Vec<_>>()
        };
        for end in ["\n", "\r\n", "\r"] {
            let text = |lines: &[&str]| lines.iter().map(|line| format!("{line}{end}")).collect::<String>();
            assert_eq!(lines(text(&["h,v", "0.4,1", "0.2,2"]).as_bytes()), [2, 3], "{end:?}");
            assert_eq!(lines(text(&["", "h,v", "", "", "0.4,1", "", "0.2,2"]).as_bytes()), [5, 7], "{end:?}");
        }
        // Where lines end by \r alone the reader knows no comments.
        for end in ["\n", "\r\n"] {
            let text = ["# so", "h,v", "# and so", "", "0.4,1", "", "# on", "0.2,2"].map(|line| format!("{line}{end}"));
            assert_eq!(lines(text.concat().as_bytes()), [5, 8], "{end:?}");
        }
        assert_eq!(lines(b"h,v\n0.4,1"), [2]);
    }
}
