//! Text made safe for HTML, XML and Markdown.

use std::fmt::Write;

use crate::evidence::number::digits;

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
            Span::Plain(text) => out.push_str(&typeset(&numerals(text))),
            Span::Code(code) => {
                let _ = write!(out, "<code>{}</code>", escape(code));
            }
        }
    }
    out
}

/// Numbers with an exponent as they are written everywhere else, with the digits that they have: 1.8e-10 is 1.8×10⁻¹⁰.
fn numerals(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let (before, tail) = rest.split_at(start);
        out.push_str(before);
        let is_word = |c: char| c.is_alphanumeric() || "._".contains(c);
        let end = numeral(tail).filter(|_| !out.ends_with(is_word));
        let value = end.and_then(|end| Some((end, tail[..end].parse::<f64>().ok()?)));
        let Some((end, value)) = value else {
            let end = tail.find(|c| !is_word(c)).unwrap_or(tail.len());
            let (word, after) = tail.split_at(end);
            out.push_str(word);
            rest = after;
            continue;
        };
        // A sign, not a hyphen or a difference.
        if out.ends_with('-') && !out[..out.len() - 1].ends_with(is_word) {
            out.pop();
            out.push('−');
        }
        let mantissa = tail[..end].split('e').next().unwrap_or_default();
        let known = mantissa.trim_start_matches(['0', '.']).chars().filter(char::is_ascii_digit).count();
        out.push_str(&digits(value, known.max(1)));
        rest = &tail[end..];
    }
    out + rest
}

/// Where a number with an exponent ends that `text` begins with. A complex one may go on with `i`.
fn numeral(text: &str) -> Option<usize> {
    let run = |from: usize| from + text[from..].bytes().take_while(u8::is_ascii_digit).count();
    let mut end = run(0);
    if text[end..].starts_with('.') && run(end + 1) > end + 1 {
        end = run(end + 1);
    }
    let exponent = text[end..].strip_prefix('e')?;
    let from = end + 1 + usize::from(exponent.starts_with(['-', '+']));
    end = run(from);
    let after = text[end..].strip_prefix('i').unwrap_or(&text[end..]);
    (end > from && !after.starts_with(|c: char| c.is_alphanumeric() || c == '_')).then_some(end)
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
                for c in numerals(text).chars() {
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

/// The head of a column from the key that its file has.
pub(super) fn heading(key: &str) -> String {
    const HEADS: [(&str, &str); 24] = [
        ("a_stable", "A-stable"),
        ("at_im", "there Im hλ"),
        ("at_re", "there Re hλ"),
        ("best_theta", "best θ"),
        ("damps_at_infinity", "damps at ∞"),
        ("growth_at_infinity", "growth at ∞"),
        ("h_or_tolerance", "h or tolerance"),
        ("h_up_to", "hλ up to"),
        ("id", "claim no."),
        ("implicit_euler", "implicit Euler"),
        ("kh", "Kh"),
        ("l_stable", "L-stable"),
        ("max_error", "largest error"),
        ("method_i", "Method I"),
        ("method_ii", "Method II"),
        ("r_infinity", "R(∞)"),
        ("r_squared", "R²"),
        ("re", "Re"),
        ("rhs", "evaluations of f"),
        ("stderr", "standard error"),
        ("t_at_max", "t of the largest"),
        ("t_end", "end t"),
        ("tau", "τ"),
        ("theta", "θ"),
    ];
    if let Some(steps) = key.strip_prefix("h_1_") {
        return format!("h = 1/{}", clean(steps));
    }
    HEADS
        .iter()
        .find(|(known, _)| *known == key)
        .map_or_else(|| clean(&key.replace('_', " ")), |(_, head)| (*head).into())
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
    fn raw_numbers_are_written_as_all_others_are() {
        let cases = [
            ("order 3.898 ± 2.2e-2, 0.000 ± 1.8e-10", "order 3.898 ± 0.022, 0.000 ± 1.8×10⁻¹⁰"),
            ("ends at a step of 1.0000e0.", "ends at a step of 1."),
            ("t = 1.000e1; from 1e2 to 1e10", "t = 10; from 10² to 10¹⁰"),
            ("hλ = -3.162e4+0.000e0i", "hλ = −31620+0i"),
            ("`1e-6` stays, 5e and 2em too, v1e3 is a name", "<code>1e-6</code> stays, 5e and 2em too, v1e3 is a name"),
        ];
        cases.iter().for_each(|(text, html)| assert_eq!(inline_html(text), *html));
        assert_eq!(inline_markdown("below 1e-8"), "below 10⁻⁸");
    }

    #[test]
    fn anchors_differ_where_identifiers_do() {
        assert_eq!(anchor("order/linear(-1,1)"), "order/linear(-1,1)");
        assert_eq!(anchor("a b~"), "a~20~b~7e~");
        assert_ne!(anchor("a b"), anchor("a~20~b"));
    }
}
