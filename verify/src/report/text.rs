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

/// Text without the characters that no document may hold.
pub(super) fn clean(text: &str) -> String {
    text.replace(|c: char| c.is_control() && !c.is_whitespace(), "\u{fffd}")
}

/// Text with `code` between backticks, p_n and e^{−ct} as HTML; a backtick without a partner stays as it is.
pub(super) fn inline_html(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for span in spans(text) {
        match span {
            Span::Plain(text) => out.push_str(&typeset(text)),
            Span::Code(code) => {
                let _ = write!(out, "<code>{}</code>", escape(code));
            }
        }
    }
    out
}

/// What a single letter is followed by after `_`, and anything after `^`, lowered and raised: p_n, a_{ij}, tol^{2/3}, 10^-3.
/// Longer words keep their underscores: max_error is a name.
fn typeset(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find(['_', '^']) {
        let (before, tail) = rest.split_at(at);
        let (sign, tail) = tail.split_at(1);
        out.push_str(&escape(before));
        // A coefficient before the letter is no part of its name: 2v_n.
        let letters = before.chars().rev().take_while(|c| c.is_alphanumeric()).collect::<Vec<_>>();
        let word = letters.iter().rev().skip_while(|c| c.is_numeric()).count();
        let is_base = match sign {
            "_" => word == 1 || word > 0 && tail.starts_with('{'),
            _ => !letters.is_empty() || before.ends_with([')', '|', 'ᵀ']),
        };
        let enclosed = |open: char, close: char| tail.strip_prefix(open).and_then(|inner| inner.split_once(close));
        let script = match (is_base, enclosed('{', '}'), enclosed('(', ')')) {
            (false, ..) => None,
            (true, Some(found), _) => Some(found),
            (true, None, Some(found)) if sign == "^" => Some(found),
            _ => {
                let sign_length = if tail.starts_with('-') { 1 } else { 0 };
                let is_part = |c: char| c.is_alphanumeric();
                let end = tail[sign_length..].find(|c| !is_part(c)).map_or(tail.len(), |end| end + sign_length);
                (end > sign_length && tail[..end].chars().count() <= 3).then(|| tail.split_at(end))
            }
        };
        match script {
            Some((script, after)) => {
                let tag = if sign == "_" { "sub" } else { "sup" };
                let _ = write!(out, "<{tag}>{}</{tag}>", escape(&script.replace('-', "−")));
                rest = after;
            }
            None => {
                out.push_str(sign);
                rest = tail;
            }
        }
    }
    out + &escape(rest)
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
    fn indices_and_powers_are_typeset_and_names_are_not() {
        let cases = [
            ("p_n = 0", "p<sub>n</sub> = 0"),
            ("e^{-ct} and h^{s+1}", "e<sup>−ct</sup> and h<sup>s+1</sup>"),
            ("z^(p+1), 10^-3", "z<sup>p+1</sup>, 10<sup>−3</sup>"),
            ("f_v a_ij", "f<sub>v</sub> a<sub>ij</sub>"),
            ("max_error, a ^ b, _x", "max_error, a ^ b, _x"),
            ("2v_n, ½hJᵀr_{n+1}", "2v<sub>n</sub>, ½hJᵀr<sub>n+1</sub>"),
            ("`p_n` stays", "<code>p_n</code> stays"),
            ("p_{<b>}", "p<sub>&lt;b&gt;</sub>"),
        ];
        cases.iter().for_each(|(text, html)| assert_eq!(inline_html(text), *html));
    }

    #[test]
    fn anchors_differ_where_identifiers_do() {
        assert_eq!(anchor("order/linear(-1,1)"), "order/linear(-1,1)");
        assert_eq!(anchor("a b~"), "a~20~b~7e~");
        assert_ne!(anchor("a b"), anchor("a~20~b"));
    }
}
