//! Text made safe for HTML, XML and Markdown.

use std::fmt::Write;

/// Escapes text for HTML and XML, element content and quoted attributes alike. Characters that XML 1.0 forbids become
/// U+FFFD.
pub(super) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\t' | '\n' | '\r' => out.push(c),
            '\u{0}'..='\u{1f}' | '\u{7f}'..='\u{9f}' | '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            _ => out.push(c),
        }
    }
    out
}

/// Text with `code` between backticks as HTML; a backtick without a partner stays as it is.
pub(super) fn inline_html(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for span in spans(text) {
        match span {
            Span::Plain(text) => out.push_str(&escape(text)),
            Span::Code(code) => {
                let _ = write!(out, "<code>{}</code>", escape(code));
            }
        }
    }
    out
}

/// Text as Markdown for one line or one table cell: what looks like markup is escaped, `code` between backticks stays.
pub(super) fn inline_markdown(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for span in spans(text) {
        match span {
            Span::Plain(text) => {
                for c in text.chars() {
                    match c {
                        '\\' | '`' | '*' | '_' | '[' | ']' | '#' | '|' | '~' | '$' | '!' | '@' => out.extend(['\\', c]),
                        '<' => out.push_str("&lt;"),
                        '>' => out.push_str("&gt;"),
                        '&' => out.push_str("&amp;"),
                        c if c.is_control() => out.push(' '),
                        c => out.push(c),
                    }
                }
            }
            Span::Code(code) => {
                let _ = write!(out, "`{}`", code.replace('|', "\\|").replace(char::is_control, " "));
            }
        }
    }
    out
}

/// An anchor from an identifier, one to one: what may not stand in an `id` or a fragment is replaced by its code point.
pub(super) fn anchor(id: &str) -> String {
    encode(id, |c| c.is_alphanumeric() || "-_./:(),+=".contains(c))
}

/// The file `data/<stem>.csv` of a table, one to one and never outside of `data`.
pub(super) fn data_file(id: &str) -> String {
    format!("data/{}.csv", encode(id, |c| c.is_ascii_alphanumeric() || "-_.".contains(c)))
}

fn encode(id: &str, keep: impl Fn(char) -> bool) -> String {
    let mut out = String::with_capacity(id.len());
    for c in id.chars() {
        if keep(c) {
            out.push(c);
        } else {
            let _ = write!(out, "~{:x}~", c as u32);
        }
    }
    out
}

enum Span<'a> {
    Plain(&'a str),
    Code(&'a str),
}

fn spans(text: &str) -> Vec<Span<'_>> {
    let mut spans = Vec::new();
    let mut rest = text;
    while let Some((plain, tail)) = rest.split_once('`') {
        let Some((code, after)) = tail.split_once('`') else { break };
        spans.push(Span::Plain(plain));
        spans.push(Span::Code(code));
        rest = after;
    }
    spans.push(Span::Plain(rest));
    spans
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_in_text_is_inert() {
        assert_eq!(escape("<a href=\"x\">'&\u{1}"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;\u{fffd}");
        assert_eq!(inline_html("a `h < 1` b ` c"), "a <code>h &lt; 1</code> b ` c");
        assert_eq!(inline_markdown("a|b *c* `d|e` <f>\n"), "a\\|b \\*c\\* `d\\|e` &lt;f&gt; ");
    }

    #[test]
    fn anchors_differ_where_identifiers_do() {
        assert_eq!(anchor("order/linear(-1,1)"), "order/linear(-1,1)");
        assert_eq!(anchor("a b~"), "a~20~b~7e~");
        assert_ne!(anchor("a b"), anchor("a~20~b"));
    }
}
