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
        _ => error.position().map_or(1, Position::line),
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
}
