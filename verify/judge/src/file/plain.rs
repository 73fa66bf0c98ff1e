//! Plain tables, as tableaus are published on the web.
//!
//! Either a block of numbers, a line of the c_i, a line of the b_i, then the rows of A below its diagonal (a third line as
//! long as the first two is b̂); or an array, as it is typeset, each row a c_i and a row of A, below them b, and b̂
//! where there is one, with spaces, tabs, commas, semicolons, or the marks of LaTeX and Markdown between the numbers, and a bar behind the c_i
//! where a row may have gaps; or lists under headings `k c[k]`, `k b[k]`, `k j A[k,j]`, a coefficient a line with its
//! indices, counted from 0 or from 1; or one coefficient a line with its name, `a[2,1] = 1/18`. `#`, `%` and `!` start comments.
//! Above all of them may stand `order 4`, `embedded_order 5` and `digits 10`.

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::super::expression::vulgar;
use super::coefficients::MOST;
use super::document::{Document, Scalar, Value};
use super::error::Fault;
use experiments::measure::decimal::counted;
use experiments::measure::typeset::bare;

/// Keys that may stand above a table.
const ABOVE: [&str; 3] = ["order", "embedded_order", "digits"];

/// `text` where it is a table and no TOML: the numbers that its first lines set, and the rest of it. Of a table the first line
/// behind them starts with a number, or with a heading or name that has an index in brackets, or it is typeset.
pub(super) fn table(text: &str) -> Option<Table> {
    let above = |(at, line)| setting(at, line).map(|setting| (setting, at + line.len()));
    let (settings, ends): (Vec<_>, Vec<_>) = lines(text).map_while(above).unzip();
    let start = ends.last().copied().unwrap_or(0);
    let below = bare(&text[start..]);
    let is_typeset = matches!(below, Cow::Owned(_));
    let below = if has_decimal_commas(&below) { below.replace(',', ".") } else { below.into_owned() };
    let rest = format!("{}{below}", " ".repeat(start));
    (is_typeset || is_plain(&rest)).then_some(Table { settings, rest, is_typeset })
}

/// A table with what is set above it.
pub(super) struct Table {
    settings: Vec<(&'static str, Scalar)>,
    /// The text below, every byte where it was.
    rest: String,
    is_typeset: bool,
}

/// `digits 10` or `digits = 10`.
fn setting(at: usize, line: &str) -> Option<(&'static str, Scalar)> {
    let (key, value) = line.split_once(['=', ' ', '\t'])?;
    let key = ABOVE.into_iter().find(|known| *known == key.trim())?;
    let value = value.trim_start_matches(['=', ' ', '\t']);
    let text = value.trim().to_owned();
    text.starts_with(|c: char| c.is_ascii_digit()).then(|| (key, Scalar { text, at: at + line.len() - value.len() }))
}

/// Whether the first line that says anything is one of a table.
fn is_plain(text: &str) -> bool {
    let Some((_, first)) = lines(text).next() else { return false };
    // What a TOML key is set to may name a coefficient too.
    let named = first.split('=').next().unwrap_or_default();
    let is_row = first.contains('|') && (first.starts_with(['(', '|', '√']) || first.starts_with("sqrt"));
    is_row
        || first.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c) || vulgar(c).is_some())
        || name_of(named).is_some()
}

/// The lines that say something, without comments, with the byte each starts at.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut at = 0;
    text.split_inclusive('\n').filter_map(move |line| {
        let start = at;
        at += line.len();
        let said = line.split(['#', '%', '!']).next().unwrap_or_default();
        let trimmed = said.trim();
        (!trimmed.is_empty()).then(|| (start + said.len() - said.trim_start().len(), trimmed))
    })
}

/// Which list a name with an index stands for: `A[k,j]` and `a(2,1)` are of `a`, `b*[k]` and `bhat[k]` of `b_hat`.
fn name_of(line: &str) -> Option<&'static str> {
    let lower = line.to_ascii_lowercase();
    [("a", "a"), ("b_hat", "b_hat"), ("bhat", "b_hat"), ("b*", "b_hat"), ("b", "b"), ("c", "c")]
        .into_iter()
        .find(|(written, _)| {
            let starts =
                |bracket| lower.split_whitespace().any(|word| word.starts_with(&format!("{written}{bracket}")));
            starts('[') || starts('(')
        })
        .map(|(_, key)| key)
}

impl Table {
    pub(super) fn read(self) -> Result<Document, Fault> {
        let text = &self.rest;
        let mut document = if self.is_typeset {
            read_rows(text, true)
        } else if lines(text).any(|(_, line)| name_of(line).is_some()) {
            read_lists(text)
        } else if lines(text).any(|(_, line)| line.contains('|')) {
            read_barred(text)
        } else {
            read_rows(text, false)
        }?;
        self.settings.into_iter().for_each(|(key, scalar)| document.insert(key, scalar.at, Value::Scalar(scalar)));
        Ok(document)
    }
}

/// Whether the commas of a table are decimal, as a spreadsheet of many countries writes them: semicolons are between the numbers,
/// and every comma is between digits.
fn has_decimal_commas(text: &str) -> bool {
    let said: Vec<&str> = lines(text).map(|(_, line)| line).collect();
    let is_decimal = |line: &&str| {
        let digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
        let mut commas = line.match_indices(',');
        commas.all(|(at, _)| digit(line[..at].chars().next_back()) && digit(line[at + 1..].chars().next()))
    };
    said.iter().any(|line| line.contains(';')) && said.iter().all(is_decimal)
}

fn words(at: usize, line: &str) -> Vec<Scalar> {
    let mut from = 0;
    let word = |word: &str| {
        let start = from + line[from..].find(word).unwrap_or(0);
        from = start + word.len();
        Scalar { text: word.to_owned(), at: at + start }
    };
    let is_between = |c: char| c.is_whitespace() || c == ',' || c == ';';
    line.split(is_between).filter(|text| !text.is_empty()).map(word).collect()
}

fn list(at: usize, items: Vec<Scalar>) -> Value {
    Value::List { items: items.into_iter().map(Value::Scalar).collect(), at }
}

/// The forms of a table without names, for a hint.
pub(super) const FORMS: &str = "a table has a line of c, a line of b, then the rows of A below the diagonal; or rows of c_i and a_i1 \
                                a_i2, and below them a line of b, with spaces, tabs, commas, semicolons, `&` or `|` between";

/// A block or an array.
fn read_rows(text: &str, is_typeset: bool) -> Result<Document, Fault> {
    let rows: Vec<Row> =
        lines(text).map(|(at, line)| (at, words(at, line))).filter(|(_, row)| !row.is_empty()).collect();
    // What is typeset may have a header.
    let is_name = |word: &Scalar| {
        is_typeset && word.text.starts_with(|c: char| c.is_alphabetic() || c == '\\') && !word.text.starts_with("sqrt")
    };
    // Nor do rows need what weights are called.
    let said = |(at, row): Row| (at, row.into_iter().skip_while(is_name).collect::<Vec<_>>());
    let below = rows.into_iter().skip_while(|(_, row)| is_name(&row[0]));
    let rows: Vec<Row> = below.map(said).filter(|(_, row)| !row.is_empty()).collect();
    match stages_of_array(&rows) {
        Some(s) => Ok(array(&rows, s)),
        None => read_block(text, &rows),
    }
}

/// A line with the byte where it starts.
type Row = (usize, Vec<Scalar>);

/// The number of rows of an array that are followed by one or two lines of as many weights; each has its c and the entries left of the
/// diagonal, with it or without, or all.
fn stages_of_array(rows: &[Row]) -> Option<usize> {
    let length = |k: usize| rows[k].1.len();
    let fits = |s: &usize| {
        let weights = (*s..rows.len()).all(|k| length(k) == *s);
        weights && (0..*s).all(|i| [i + 1, i + 2, s + 1].contains(&length(i)))
    };
    // Three numbers, one a line, are a block.
    let is_block = rows.iter().all(|(_, row)| row.len() == 1);
    [1, 2].into_iter().filter_map(|weights| rows.len().checked_sub(weights)).find(|s| fits(s) && !is_block)
}

fn array(rows: &[Row], s: usize) -> Document {
    let (stages, weights) = rows.split_at(s);
    let c = stages.iter().map(|(_, row)| row[0].clone()).collect();
    let items = stages.iter().map(|(at, row)| list(*at, row[1..].to_vec())).collect();
    let mut document = Document::default();
    document.insert("c", stages[0].0, list(stages[0].0, c));
    document.insert("a", stages[0].0, Value::List { items, at: stages[0].0 });
    for (key, (at, row)) in ["b", "b_hat"].into_iter().zip(weights) {
        document.insert(key, *at, list(*at, row.clone()));
    }
    document
}

fn read_block(text: &str, rows: &[Row]) -> Result<Document, Fault> {
    let [(c_at, c), (b_at, b), rest @ ..] = rows else {
        return Err(Fault::new(text.len(), "the table ends after the first line").hint(FORMS));
    };
    let s = c.len();
    if b.len() != s {
        let [c, b] = [s, b.len()].map(|n| counted(n, "number"));
        let reason = format!("a first line of {c} and a second of {b} are neither c and b, nor rows of c_i and A");
        return Err(Fault::new(*b_at, reason).hint(FORMS));
    }
    let mut document = Document::default();
    let mut rest = rest;
    if let [(at, hat), lower @ ..] = rest
        && hat.len() == s
        && lower.len() + 1 >= s
        && s > 1
    {
        document.insert("b_hat", *at, list(*at, hat.clone()));
        rest = lower;
    }
    let at = rest.first().map_or(text.len(), |(at, _)| *at);
    let mut items: Vec<Value> = rest.iter().map(|(at, row)| list(*at, row.clone())).collect();
    if items.len() + 1 == s {
        items.insert(0, list(at, Vec::new()));
    }
    document.insert("c", *c_at, list(*c_at, c.clone()));
    document.insert("b", *b_at, list(*b_at, b.clone()));
    document.insert("a", at, Value::List { items, at });
    Ok(document)
}

/// A tableau with bars.
fn read_barred(text: &str) -> Result<Document, Fault> {
    let (mut c, mut a, mut weights) = (Vec::new(), Vec::new(), Vec::new());
    // A rule has no digits.
    for (at, line) in lines(text).filter(|(_, line)| line.contains(|c: char| c.is_ascii_alphanumeric())) {
        let Some((left, right)) = line.split_once('|') else {
            return Err(Fault::new(at, "a row without a bar").hint("c_i | a_i1 a_i2, and below them | b_1 b_2"));
        };
        let behind = at + left.len() + 1;
        let row = list(behind, words(behind, right));
        match &words(at, left)[..] {
            [] => weights.push((behind, row)),
            [node] if weights.is_empty() => {
                c.push(node.clone());
                a.push(row);
            }
            _ => return Err(Fault::new(at, "more than one number before the bar, or a row of A below the weights")),
        }
    }
    let mut document = Document::default();
    for (key, (at, row)) in ["b", "b_hat"].into_iter().zip(weights) {
        document.insert(key, at, row);
    }
    document.insert("c", 0, list(0, c));
    document.insert("a", 0, Value::List { items: a, at: 0 });
    Ok(document)
}

/// Coefficients by key and indices.
type Entries = BTreeMap<(&'static str, usize, usize), Scalar>;

fn read_lists(text: &str) -> Result<Document, Fault> {
    let mut entries = Entries::new();
    let mut heading = None;
    for (at, line) in lines(text) {
        let (key, indices, value) = match (line.split_once('='), name_of(line), heading) {
            (Some((left, right)), Some(key), _) => {
                let digits = left.split(|c: char| !c.is_ascii_digit()).filter(|part| !part.is_empty());
                let start = at + left.len() + 1 + (right.len() - right.trim_start().len());
                let value = right.trim().trim_end_matches([';', ',']).to_owned();
                (key, digits.map(str::to_owned).collect::<Vec<_>>(), Scalar { text: value, at: start })
            }
            (None, Some(key), _) => {
                heading = Some(key);
                continue;
            }
            (_, None, Some(key)) => {
                let mut words = words(at, line);
                let Some(value) = words.pop() else { continue };
                (key, words.into_iter().map(|word| word.text).collect(), value)
            }
            _ => {
                return Err(Fault::new(at, "a coefficient before any heading")
                    .hint("headings are `k c[k]`, `k b[k]`, `k j A[k,j]`"));
            }
        };
        let numbers: Option<Vec<usize>> = indices.iter().map(|word| word.parse().ok()).collect();
        if let Some(k) = numbers.iter().flatten().find(|k| **k > MOST) {
            return Err(Fault::new(at, format!("an index of {k}; there are 1 to {MOST} stages")));
        }
        let place = match (key, numbers.as_deref()) {
            ("a", Some(&[i, j])) => (key, i, j),
            ("b" | "c" | "b_hat", Some(&[i])) => (key, i, 0),
            _ => return Err(Fault::new(at, format!("a line of `{key}` has its indices, then the coefficient"))),
        };
        if entries.insert(place, value).is_some() {
            return Err(Fault::new(at, "this coefficient stands here a second time"));
        }
    }
    assemble(&entries)
}

fn assemble(entries: &Entries) -> Result<Document, Fault> {
    let indices = || entries.keys().map(|(key, i, j)| (*i, if *key == "a" { *j } else { *i }));
    let first = indices().map(|(i, j)| i.min(j)).min().unwrap_or(0).min(1);
    let s = indices().map(|(i, j)| i.max(j) + 1 - first).max().unwrap_or(0);
    let absent = |at| Scalar { text: "0".into(), at };
    let mut document = Document::default();
    for key in ["b", "c", "b_hat"] {
        let Some(at) = entries.iter().find(|((known, ..), _)| *known == key).map(|(_, scalar)| scalar.at) else {
            continue;
        };
        let row = (0..s).map(|i| entries.get(&(key, i + first, 0)).cloned().unwrap_or_else(|| absent(at))).collect();
        document.insert(key, at, list(at, row));
    }
    let row = |i: usize| {
        (0..s).map(|j| entries.get(&("a", i + first, j + first)).cloned().unwrap_or_else(|| absent(0))).collect()
    };
    document.insert("a", 0, Value::List { items: (0..s).map(|i| list(0, row(i))).collect(), at: 0 });
    Ok(document)
}

#[cfg(test)]
mod tests {
    use super::super::super::tableau::Tableau;
    use super::super::{Body, FileError, MethodFile};

    /// Rows of A below its diagonal may begin with the second stage's.
    #[test]
    fn a_third_line_as_long_as_the_others_is_an_embedded_method() {
        let text = "0 1/2 1\n1/6 2/3 1/6\n0 1 0\n1/2\n-1 2\n";
        let file = MethodFile::parse("m.txt", "m", text).expect("a table");
        let Body::RungeKutta(tableau) = &file.body else { panic!("{text}") };
        let numbers = tableau.numbers();
        let b_hat: Vec<f64> = numbers.b_hat.iter().flatten().map(|b| b.to_f64()).collect();
        assert_eq!((numbers.a.len(), b_hat), (3, vec![0.0, 1.0, 0.0]));
    }

    fn tableau(text: &str) -> Tableau {
        let file = MethodFile::parse("m.txt", "m", text).unwrap_or_else(|error| panic!("{text}{error}"));
        let Body::RungeKutta(tableau) = file.body else { panic!("{text}") };
        tableau
    }

    /// The same coefficients as TOML has them, and as many stages.
    #[test]
    fn a_table_of_any_layout_is_the_method_that_it_is_in_toml() {
        let midpoint = "c = ['1/2']\nb = [1]\na = [['1/2']]";
        let implicit_below =
            "c = [0, '1/2', 1]\nb = ['1/6', '2/3', '1/6']\na = [[], ['1/4', '1/4'], ['1/3', '1/3', '1/3']]";
        let trapezoidal = "c = [0, 1]\nb = ['1/2', '1/2']\na = [[], ['1/2', '1/2']]";
        let diagonal = "c = ['1/4', '3/4']\nb = ['1/2', '1/2']\na = [['1/4'], ['1/2', '1/4']]";
        let falling = "c = [1, 0]\nb = ['1/2', '1/2']\na = [['1/2', '1/2'], [0, 0]]";
        let negative = "c = [0, '-1/2']\nb = [2, -1]\na = [[], ['-1/2']]";
        for (text, toml) in [
            // A block of one stage, and blocks whose rows begin with the second stage's and with the first's.
            ("1/2\n1\n1/2\n", midpoint),
            ("0 1/2 1\n1/6 2/3 1/6\n1/4 1/4\n1/3 1/3 1/3\n", implicit_below),
            ("1/4 3/4\n1/2 1/2\n1/4\n1/2 1/4\n", diagonal),
            // An array up to its diagonal.
            ("1/4 1/4\n3/4 1/2 1/4\n1/2 1/2\n", diagonal),
            // Lists, counted from 0 and from 1, of which A alone or none has the first stage.
            ("c[0] = 1\nb[0] = 1/2\nb[1] = 1/2\na[0,0] = 1/2\na[0,1] = 1/2\n", falling),
            ("c[1] = 1\nb[1] = 1/2\nb[2] = 1/2\na[1,1] = 1/2\na[1,2] = 1/2\n", falling),
            ("c[2] = 1\nb[1] = 1/2\nb[2] = 1/2\na[2,1] = 1/2\na[2,2] = 1/2\n", trapezoidal),
            // A comma before a sign is none of a decimal.
            ("0 | ;\n-1/2 | -1/2;\n | 2,-1;\n", negative),
        ] {
            assert_eq!(tableau(text).numbers(), tableau(toml).numbers(), "{text}");
        }
    }

    /// Lines and columns are counted from 1.
    #[test]
    fn a_mistake_in_a_table_is_shown_where_it_is() {
        for (text, place, reason) in [
            ("0 |\n  1/2 | x\n | 1/2 1/2\n", (2, 9), "`x` is not known"),
            ("0 |\n | 1/2 1/2\n1 | 1\n", (3, 1), "a row of A below the weights"),
            ("b[1] = 1\n  a[1,1] =   x;\n", (2, 14), "`x` is not known"),
            ("b[1] = 1\na[1] = 1\n", (2, 1), "a line of `a` has its indices"),
            ("b[1] = 1\nb[41] = 1\n", (2, 1), "an index of 41; there are 1 to 40 stages"),
        ] {
            let error = MethodFile::parse("m.txt", "m", text).expect_err(text);
            let FileError::Malformed { line, column, reason: found, .. } = &error else { panic!("{error}") };
            assert!((*line, *column) == place && found.contains(reason), "{text}{error}");
        }
        let most: String = (1..=40).map(|k| format!("b[{k}] = 1/40\n")).collect();
        assert_eq!(tableau(&most).b.len(), 40);
    }

    /// Whatever the first number begins with, a bar makes it a row.
    #[test]
    fn a_row_may_begin_with_a_bracket_or_a_root() {
        for first in ["(2-sqrt(2))/2", "√2/2", "sqrt(2)/2"] {
            let text = format!("{first} | {first} 0\n1 | 1-({first}) {first}\n---\n | 1/2 1/2\n");
            let file = MethodFile::parse("m.txt", "m", &text).unwrap_or_else(|error| panic!("{text}{error}"));
            assert!(matches!(file.body, Body::RungeKutta(_)), "{text}");
        }
    }

    #[test]
    fn a_bar_in_a_text_makes_no_row_of_a_table() {
        assert!(super::is_plain("| 1/2 | 1 |\n") && super::is_plain("sqrt(3)/6 | 0\n"));
        assert!(!super::is_plain("kind = 'a | b'\n") && !super::is_plain("(said)\n"));
    }
}
