//! What is wrong with the text of a model: of all that DiffSL says the first, which the rest follows from, with its place and what mends it.

use diffsl::execution::functions::{FUNCTIONS_F64, TWO_ARG_FUNCTIONS_F64};

use crate::names::NameError;

/// Names that DiffSL has for what a model consists of.
const OWN: [(&str, &str); 6] = [
    ("u", "the state"),
    ("F", "f"),
    ("M", "the product of the mass matrix with dudt"),
    ("dudt", "the rate of the state"),
    ("in", "the inputs"),
    ("out", "what is written"),
];

/// Functions of other languages, and how DiffSL has them.
const FOREIGN: [(&str, &str); 14] = [
    ("acosh", "arccosh(x)"),
    ("asinh", "arcsinh(x)"),
    ("cbrt", "copysign(pow(abs(x), 1/3), x)"),
    ("fabs", "abs(x)"),
    ("hypot", "sqrt(x * x + y * y)"),
    ("ln", "log(x)"),
    ("log2", "log(x) / log(2)"),
    ("power", "pow(x, 2)"),
    ("sgn", "copysign(1, x)"),
    ("sign", "copysign(1, x)"),
    ("sqr", "pow(x, 2)"),
    ("square", "pow(x, 2)"),
    ("step", "heaviside(x)"),
    ("theta", "heaviside(x)"),
];

/// Functions that DiffSL has no equivalent of, some with names near to one that it has.
const NONE_SUCH: [&str; 16] = [
    "acos", "arccos", "arcsin", "arctan", "arctanh", "asin", "atan", "atan2", "atanh", "ceil", "erf", "floor", "fmod",
    "gamma", "mod", "round",
];

/// What the parser cannot read, `message` being a position with the text around it.
pub(super) fn syntax(path: &str, code: &str, message: &str) -> String {
    let place = || {
        let (line, column) = message.split_once("--> ")?.1.lines().next()?.split_once(':')?;
        Some((line.trim().parse().ok()?, column.trim().parse().ok()?))
    };
    let expected = message.rsplit_once("= ").map_or(message, |(_, text)| text).trim();
    match place() {
        Some((line, column)) => {
            let text = unread(&uncommented(code), offset(code, (line, column))).unwrap_or_else(|| expected.to_owned());
            shown(path, code, (line, column), &text)
        }
        None => format!("{path}: {expected}"),
    }
}

/// The first message that names a cause: `Line l, Column c: Error: text`, or one without a place.
pub(super) fn located(path: &str, code: &str, messages: &str) -> String {
    let words = uncommented(code);
    let mut lines = messages.lines().filter(|line| !line.trim().is_empty());
    // Of a name that is given once DiffSL says itself, next, why it cannot be.
    let is_cause = |message: &&str| message.strip_suffix(" is already defined").is_none() || is_twice(code, message);
    let Some(message) = lines.clone().find(is_cause).or_else(|| lines.next()) else { return path.to_owned() };
    let (at, text) = match place(&words, message) {
        Some((line, column, text)) => (Some((line, column)), text),
        None => (None, message.trim_start_matches("Error: ")),
    };
    let (at, text) = match at {
        // Where a tensor is missing there is no place.
        _ if text.starts_with("missing '") => (None, missing(&words, text)),
        None => (None, mended(text)),
        Some(at) => {
            let from = offset(code, at);
            if let Some(name) = text.strip_prefix("cannot find variable ") {
                (Some(at), unknown(&words, name, from))
            } else if let Some(name) = text.strip_suffix(" is a reserved name") {
                let at = each_word(&words[from..]).find(|(_, word)| *word == name).map(|(k, _)| from + k);
                (
                    Some(position(code, at.unwrap_or(from))),
                    format!("{text}: DiffSL has a use of its own for it; choose another"),
                )
            } else {
                (Some(at), clash(code, at.0, text).unwrap_or_else(|| mended(text)))
            }
        }
    };
    match at {
        Some(at) => shown(path, code, at, &text),
        None => format!("{path}: {text}"),
    }
}

/// A line of the file with a mark below a place of it, and what is to be said.
fn shown(path: &str, code: &str, (line, column): (usize, usize), text: &str) -> String {
    let shown = code.lines().nth(line.saturating_sub(1)).unwrap_or_default();
    let (margin, indent) = (" ".repeat(line.to_string().len()), " ".repeat(column.saturating_sub(1)));
    format!("{margin}--> {path}:{line}:{column}\n{margin} |\n{line} | {shown}\n{margin} | {indent}^\n{margin} = {text}")
}

/// What a message says with what mends it, where that is known.
fn mended(text: &str) -> String {
    if let Some(name) = text.strip_prefix("unknown function call '").and_then(|rest| rest.strip_suffix('\'')) {
        if let Some((_, form)) = FOREIGN.into_iter().find(|(foreign, _)| *foreign == name) {
            return format!("unknown function `{name}`; DiffSL has it as {form}");
        }
        let error = NameError::unknown("function", name, functions().filter(|_| !NONE_SUCH.contains(&name)));
        let is_guessed = matches!(error, NameError::Unknown { suggestion: Some(_), .. });
        return if is_guessed { error.to_string() } else { format!("{error}; there are {}", list(functions())) };
    }
    if text.starts_with("input list is no longer supported") {
        return "input list is no longer supported; inputs are stated with their values, as in_i { a = 1 }".into();
    }
    if text.starts_with("cannot have more than one element in a scalar") {
        return format!("{text}; what has several has an index, as in u_i {{ x = 1, y = 0 }}");
    }
    let shapes = || {
        let (f, u) =
            text.strip_prefix("F and u must have the same shape, but F has shape ")?.split_once(" and u has shape ")?;
        let count = |shape: &str| match shape.trim_matches(['[', ']']) {
            "" => Some(1),
            number => number.parse::<usize>().ok(),
        };
        Some((count(f)?, count(u)?))
    };
    match shapes() {
        Some((rows, components)) => {
            let [rows, components] = [(rows, "row"), (components, "component")]
                .map(|(n, what)| format!("{n} {what}{}", if n == 1 { "" } else { "s" }));
            format!("F has {rows} and the state u {components}; each component has a row, and commas part them")
        }
        None => text.to_owned(),
    }
}

/// Of a tensor that every model has, and this one has not.
fn missing(words: &str, text: &str) -> String {
    let [name, what, form] = if text.contains("'u'") {
        ["u", "the state is", "u_i { x = 1, y = 0 }, with its value at t = 0"]
    } else {
        ["F", "f is", "F_i { y, -x }, with a row for each component"]
    };
    let other = stated(words).find(|(_, word)| word.eq_ignore_ascii_case(name));
    let other = other.map_or_else(String::new, |(at, word)| {
        format!("; `{word}` in line {} is another name than `{name}`", position(words, at).0)
    });
    format!("{what} missing; state it as {form}{other}")
}

/// Of a name that means nothing at a place.
fn unknown(words: &str, name: &str, from: usize) -> String {
    let place = |at: usize| position(words, at).0;
    if functions().any(|function| function == name) {
        return format!("`{name}` is a function, and has its arguments in parentheses");
    }
    if let Some((at, _)) = stated(words).find(|(_, word)| *word == name) {
        let line = place(at);
        return if at > from {
            format!(
                "`{name}` is used before it is stated, in line {line}; state it before, as names are known from there on"
            )
        } else {
            format!(
                "`{name}`, of line {line}, is known after the closing brace of what it is a part of; state it before, on its own"
            )
        };
    }
    match name {
        "pi" | "Pi" | "PI" => return format!("unknown name `{name}`; write 3.141592653589793"),
        "time" => return format!("unknown name `{name}`; time is `t`"),
        _ => {}
    }
    if let Some((_, meaning)) = OWN.into_iter().find(|(own, _)| *own == name) {
        return format!("unknown name `{name}`; DiffSL calls {meaning} so, and nothing before this states it");
    }
    let known = stated(words).take_while(|(at, _)| *at < from).map(|(_, word)| word);
    let error = NameError::unknown("name", name, known.chain(["t"]));
    let is_guessed = matches!(error, NameError::Unknown { suggestion: Some(_), .. });
    match is_guessed {
        true => error.to_string(),
        false => format!("{error}; state it before, as an input, in_i {{ {name} = 1 }}, or by itself, {name} {{ 1 }}"),
    }
}

/// What cannot be read at a place.
fn unread(words: &str, at: usize) -> Option<String> {
    let (before, rest) = words.split_at(at);
    let line = |at: usize| position(words, at).0;
    let mut open: Vec<(usize, char)> = Vec::new();
    for (k, c) in before.char_indices() {
        match c {
            '{' | '(' => open.push((k, c)),
            '}' | ')' => drop(open.pop()),
            _ => {}
        }
    }
    // Blanks of other kinds are no blanks to DiffSL.
    let next = rest.trim_ascii_start().chars().next();
    let last = before.chars().next_back();
    // A tensor, within another.
    let is_tensor = stated(rest).next().is_some_and(|(k, word)| {
        let is_first = rest[..k].trim().is_empty();
        is_first && rest[k + word.len()..].trim_start_matches(is_of_index).trim_start().starts_with('{')
    });
    let no_comparisons = "there are no comparisons; heaviside(x - a) is 1 for x > a and 0 for x < a".to_owned();
    let previous = each_word(before).last().filter(|(k, word)| before[k + word.len()..].trim().is_empty());
    let text = match (next, open.last()) {
        (None, Some((k, c))) => format!("the `{c}` of line {} is not closed", line(*k)),
        (Some('}'), Some((k, '('))) => format!("the `(` of line {} is not closed", line(*k)),
        (_, Some((k, '{'))) if is_tensor => format!("the `{{` of line {} is not closed: `}}` is missing before this", line(*k)),
        (Some(c @ '}'), None) | (Some(c @ ')'), Some((_, '{')) | None) => format!("this `{c}` closes nothing"),
        (Some('^'), _) => "powers are written as pow(x, 2)".into(),
        (Some('*'), _) if last == Some('*') => "powers are written as pow(x, 2)".into(),
        (Some('<' | '>' | '?' | '&' | '|' | '!'), _) => {
            no_comparisons
        }
        (Some(';'), Some(_)) => "what stands in braces is parted by commas".into(),
        (Some('#'), _) => "comments begin with //".into(),
        (Some('.'), Some(_)) => "numbers begin with a digit: 0.5".into(),
        (Some('E' | 'd' | 'D'), _) if last.is_some_and(|c| c.is_ascii_digit()) && has_exponent(rest) => {
            "exponents of numbers have a small e: 1e5".into()
        }
        (Some('\''), _) => "f is stated as F_i { y, -x }, a row for each component, without the rates that they are".into(),
        (Some(':'), _) if rest.trim_start().starts_with(":=") => "values are given with =, as in u_i { x = 1 }".into(),
        (Some('='), _) if last == Some('=') => no_comparisons,
        (Some('='), Some(_)) => {
            "before `=` stands the name of an element and nothing else; rows of F need none, as in F_i { y, -x }".into()
        }
        (Some(c @ ('\u{2212}' | '\u{2013}' | '\u{2014}')), _) => format!("`{c}` is not the minus sign of a keyboard, -"),
        (Some(c @ ('\u{d7}' | '\u{b7}' | '\u{22c5}')), _) => format!("`{c}` is not the sign of products, *"),
        (Some(c), _) if c.is_whitespace() && !c.is_ascii() => "the blank here is not that of a keyboard".into(),
        (Some(c), _) if !c.is_ascii() => format!("names and signs are those of ASCII, and `{c}` is not"),
        _ if last == Some('_') || next == Some('_') => {
            "names have letters and digits alone; `_` stands before an index, as in u_i".into()
        }
        _ if previous.is_some_and(|(_, word)| matches!(word, "if" | "else" | "where" | "and" | "or" | "not")) => {
            no_comparisons
        }
        (Some(c), Some(_)) if c.is_alphanumeric() || c == '(' => {
            let follows = before.trim_end().chars().next_back();
            return follows
                .is_some_and(|c| c.is_alphanumeric() || c == ')')
                .then(|| "an operator or a comma is missing before this; products are written as 2 * x".into());
        }
        (_, None) => "a model consists of tensors, name { … }: its inputs in_i { k = 1 }, the state at t = 0 u_i { x = 1, y = 0 } \
                      and f, F_i { y, -k * x }"
            .into(),
        _ => return None,
    };
    Some(text)
}

/// Whether digits follow the first letter of a text, as in an exponent.
fn has_exponent(text: &str) -> bool {
    let mut rest = text.chars();
    rest.next();
    rest.as_str().trim_start_matches(['+', '-']).starts_with(|c: char| c.is_ascii_digit())
}

/// The functions of DiffSL, but for those of tables and of pieces, whose arguments are constants.
fn functions() -> impl Iterator<Item = &'static str> {
    let of_one = FUNCTIONS_F64.iter().map(|(name, ..)| *name);
    of_one.chain(TWO_ARG_FUNCTIONS_F64.iter().map(|(name, ..)| *name))
}

fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(", ")
}

/// The text with blanks in the place of comments, byte for byte.
fn uncommented(code: &str) -> String {
    let mut text = String::with_capacity(code.len());
    let mut rest = code;
    while let Some(start) = [rest.find("//"), rest.find("/*")].into_iter().flatten().min() {
        let (before, comment) = rest.split_at(start);
        let end = if comment.starts_with("//") { comment.find('\n') } else { comment.find("*/").map(|k| k + 2) };
        let (comment, after) = comment.split_at(end.unwrap_or(comment.len()));
        text.push_str(before);
        text.extend(comment.bytes().map(|b| if b == b'\n' { '\n' } else { ' ' }));
        rest = after;
    }
    text + rest
}

/// Each name, with its place. An index is no part of it.
fn each_word(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut words = text.split_inclusive(|c: char| !c.is_ascii_alphanumeric());
    let mut at = 0;
    let mut is_index = false;
    std::iter::from_fn(move || {
        loop {
            let part = words.next()?;
            let (start, word) = (at, part.trim_end_matches(|c: char| !c.is_ascii_alphanumeric()));
            at += part.len();
            let is_name = !is_index && word.starts_with(|c: char| c.is_ascii_alphabetic());
            is_index = is_name && part.ends_with('_');
            if is_name {
                return Some((start, word));
            }
        }
    })
}

fn is_of_index(c: char) -> bool {
    c == '_' || c.is_ascii_alphanumeric()
}

/// The names that are stated, as tensors or elements of one, with their places.
fn stated(words: &str) -> impl Iterator<Item = (usize, &str)> {
    each_word(words).filter(|(at, word)| {
        let rest = &words[at + word.len()..];
        let of_tensor = rest.strip_prefix('_').map_or(rest, |index| index.trim_start_matches(is_of_index));
        of_tensor.trim_start().starts_with('{') || rest.trim_start().starts_with('=')
    })
}

/// The lines in which a name is stated, as words.
pub(super) fn lines_with(code: &str, name: &str) -> String {
    let words = uncommented(code);
    let mut lines: Vec<usize> =
        stated(&words).filter(|(_, word)| *word == name).map(|(at, _)| position(&words, at).0).collect();
    lines.dedup();
    match &lines[..] {
        [] => String::new(),
        [line] => format!(", in line {line}"),
        [first, second, ..] => format!(", in lines {first} and {second}"),
    }
}

/// Whether a name that is said to be defined already is there twice.
fn is_twice(code: &str, message: &str) -> bool {
    place(code, message).is_none_or(|(line, _, text)| clash(code, line, text).is_some())
}

/// What a message says of a name that is given twice, the second time in this line, or that is one of DiffSL's own.
fn clash(code: &str, line: usize, text: &str) -> Option<String> {
    let own = |name: &str| {
        let (_, meaning) = OWN.into_iter().find(|(own, _)| *own == name)?;
        Some(format!("DiffSL calls {meaning} `{name}`"))
    };
    if text.starts_with("M and u must have the same shape") {
        return own("M").map(|own| format!("{text}; {own}; rename what is another thing"));
    }
    let name = text.strip_suffix(" is already defined")?;
    let uses = |(before, text): (usize, &str)| {
        let text = text.split("//").next().unwrap_or_default();
        // An index is no part of a name.
        let words = text.split(|c: char| !c.is_alphanumeric()).filter(|word| *word == name);
        vec![before + 1; words.count()]
    };
    let mut lines = code.lines().take(line).enumerate().flat_map(uses);
    let first = lines.next()?;
    // Of a name that is given once DiffSL says itself why it cannot be.
    lines.next()?;
    let own = own(name).map_or_else(String::new, |own| format!("{own}; "));
    Some(format!("`{name}` is already there in line {first}; {own}rename what is another thing, or state it once"))
}

/// Line, column and text of a message; where it names a function only, those of the first call.
fn place<'a>(code: &str, message: &'a str) -> Option<(usize, usize, &'a str)> {
    if let Some(name) = message.strip_prefix("unknown function call '").and_then(|rest| rest.strip_suffix('\'')) {
        let (at, _) = each_word(code)
            .find(|(at, word)| *word == name && code[at + name.len()..].trim_start().starts_with('('))?;
        let (line, column) = position(code, at);
        return Some((line, column, message));
    }
    let (line, rest) = message.strip_prefix("Line ")?.split_once(", Column ")?;
    let (column, text) = rest.split_once(": Error: ")?;
    Some((line.parse().ok()?, column.parse().ok()?, text))
}

/// Line and column of a byte.
pub(super) fn position(code: &str, offset: usize) -> (usize, usize) {
    let before = &code[..offset];
    let start = before.rfind('\n').map_or(0, |end| end + 1);
    (before.matches('\n').count() + 1, before[start..].chars().count() + 1)
}

/// The byte at a line and a column, or the end.
fn offset(code: &str, (line, column): (usize, usize)) -> usize {
    let start: usize = code.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let of_line = code[start..].char_indices().nth(column.saturating_sub(1)).map(|(k, _)| k);
    of_line.map_or(code.len(), |k| start + k)
}
