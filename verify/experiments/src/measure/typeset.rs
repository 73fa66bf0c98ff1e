//! Tables as they are typeset, in LaTeX or Markdown, laid bare: numbers and names stay where they are, byte by byte, and what
//! separates them becomes tabs and spaces.

use std::borrow::Cow;

/// The text of a LaTeX tabular or a Markdown table without its rules and commands, as long as before; any other text as it is.
#[must_use]
pub fn bare(text: &str) -> Cow<'_, str> {
    let is_latex = |line: &str| line.contains('&') && line.contains(r"\\");
    // The text of a key in TOML may have both.
    let form = if text.lines().any(is_latex) && !text.lines().any(|line| is_latex(line) && line.contains('=')) {
        latex_line as fn(&str) -> String
    } else if is_markdown(text) {
        markdown_line
    } else {
        return Cow::Borrowed(text);
    };
    let lines = text.split_inclusive('\n').map(|line| {
        let said = line.trim_end_matches(['\n', '\r']);
        form(said) + &line[said.len()..]
    });
    Cow::Owned(lines.collect())
}

/// Whether it is a Markdown table: rows with a rule, and prose about them at most, or rows alone.
fn is_markdown(text: &str) -> bool {
    let said = || text.lines().filter(|line| !line.trim().is_empty());
    let has_rule = said().any(is_rule) && !said().any(|line| line.contains('='));
    said().filter(|line| is_row(line)).count() > 1 && (has_rule || said().all(is_row))
}

/// Whether a line is a row of a Markdown table.
fn is_row(line: &str) -> bool {
    let line = line.trim();
    line.len() > 1 && line.starts_with('|') && line.ends_with('|')
}

/// Whether it is the one below the header.
fn is_rule(line: &str) -> bool {
    is_row(line) && line.contains('-') && line.chars().all(|c| "|-: \t".contains(c))
}

fn blank(line: &str) -> String {
    " ".repeat(line.len())
}

fn markdown_line(line: &str) -> String {
    // The outermost bars separate nothing.
    let (Some(first), Some(last), true) = (line.find('|'), line.rfind('|'), is_row(line) && !is_rule(line)) else {
        return blank(line);
    };
    let cells: Vec<String> = line[first + 1..last].split('|').map(latex_cell).collect();
    format!("{} {} {}", &line[..first], cells.join("\t"), &line[last + 1..])
}

/// Signs that have another name here.
const SIGNS: [(&str, &str); 5] = [(r"\cdot", "*"), (r"\times", "*"), (r"\left", ""), (r"\right", ""), ("$", "")];

/// Commands that draw or arrange and hold nothing.
const RULES: [&str; 6] = [r"\hline", r"\toprule", r"\midrule", r"\bottomrule", r"\cline", r"\cmidrule"];

fn latex_line(line: &str) -> String {
    let line = without_environments(line);
    // What is no row of cells: captions, `\[`, prose below.
    let is_row = line.contains('&') || line.contains(r"\\");
    let says_more = line.trim_start().starts_with('\\') || line.contains(char::is_alphabetic);
    if !is_row && says_more {
        return blank(&line);
    }
    let row = line.split(r"\\").next().unwrap_or_default();
    let cells: Vec<String> = row.split('&').map(latex_cell).collect();
    let bare = cells.join("\t");
    bare + &" ".repeat(line.len() - row.len())
}

/// A line with spaces for `\begin{tabular}[t]{cc}` and `\end{tabular}`, beside which there may be cells.
fn without_environments(line: &str) -> String {
    let mut said = line.to_owned();
    for command in [r"\begin", r"\end"] {
        while let Some(at) = said.find(command) {
            let after = |rest| group(rest).map_or(rest, |(_, after)| after);
            let mut rest = after(&said[at + command.len()..]);
            if command == r"\begin" {
                rest = after(
                    rest.strip_prefix('[').and_then(|place| place.split_once(']')).map_or(rest, |(_, after)| after),
                );
            }
            let end = said.len() - rest.len();
            said.replace_range(at..end, &" ".repeat(end - at));
        }
    }
    said
}

/// `\frac{1}{2}` as `(1)/(2)`, padded to the length that it had.
fn latex_cell(cell: &str) -> String {
    let start = cell.len() - cell.trim_start().len();
    let mut said = cell[start..].to_owned();
    for rule in RULES {
        while let Some(at) = said.find(rule) {
            let rest = &said[at + rule.len()..];
            // `\cline{2-3}` has columns.
            let end = said.len() - group(rest).map_or(rest, |(_, after)| after).len();
            said.replace_range(at..end, &" ".repeat(end - at));
        }
    }
    for (sign, plain) in SIGNS {
        said = said.replace(sign, plain);
    }
    let mut bare = formula(&said);
    if bare.replace("sqrt", "").chars().all(|c| !c.is_alphabetic()) {
        bare.retain(|c| !c.is_whitespace());
    }
    let width = cell.len().saturating_sub(start + bare.len());
    format!("{}{bare}{}", " ".repeat(start), " ".repeat(width))
}

/// Fractions and roots in the notation of expressions, none longer than before.
fn formula(text: &str) -> String {
    for (command, count) in [(r"\nicefrac", 2), (r"\dfrac", 2), (r"\tfrac", 2), (r"\frac", 2), (r"\sqrt", 1)] {
        let Some(at) = text.find(command) else { continue };
        let mut rest = &text[at + command.len()..];
        let mut arguments = Vec::new();
        while arguments.len() < count {
            let Some((argument, after)) = group(rest).or_else(|| token(rest)) else { return text.to_owned() };
            arguments.push(formula(argument));
            rest = after;
        }
        let said = match &arguments[..] {
            [top, bottom] => format!("({top})/({bottom})"),
            // Shorter than `sqrt(3)`, as the command is without braces.
            [inside] if inside.len() == 1 => format!("√{inside}"),
            [inside, ..] => format!("sqrt({inside})"),
            [] => String::new(),
        };
        return format!("{}{said}{}", &text[..at], formula(rest));
    }
    text.to_owned()
}

/// What stands in the braces that `text` starts with, and what follows them.
fn group(text: &str) -> Option<(&str, &str)> {
    let inner = text.strip_prefix('{')?;
    let mut depth = 1;
    let end = inner.char_indices().find(|(_, c)| {
        depth += i32::from(*c == '{') - i32::from(*c == '}');
        depth == 0
    })?;
    Some((&inner[..end.0], &inner[end.0 + 1..]))
}

/// The digit that `text` starts with, which needs no braces, and what follows it.
fn token(text: &str) -> Option<(&str, &str)> {
    let text = text.trim_start();
    text.starts_with(|c: char| c.is_ascii_digit()).then(|| text.split_at(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_laid_bare_with_every_number_in_its_place() {
        let words = |text: &str| {
            let bare = bare(text).into_owned();
            assert_eq!(bare.len(), text.len());
            bare.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect::<Vec<_>>()
        };
        let latex = "\\begin{array}{c|cc}\n0 & \\\\\n$\\frac{1}{2}$ & -\\tfrac{3-\\sqrt{3}}{6} \\\\ \\hline\n\\hline & 1 & 2\\\\[2pt]\n\\end{array}\n";
        assert_eq!(words(latex), ["", "0", "(1)/(2) -(3-√3)/(6)", "1 2", ""]);
        let paper = "\\[\n\\renewcommand\\arraystretch{1.2}\n\\frac12 & -\\frac{12}7 \\\\\n& \\nicefrac{1}{6} & \\sqrt3\n\\]\n\\caption{Order 3}\nwith $c_2 = 1/2$\n";
        assert_eq!(words(paper), ["", "", "(1)/(2) -(12)/(7)", "(1)/(6) √3", "", "", ""]);
        // A rule may stand before a cell, or under some columns.
        assert_eq!(words("\\hline 0.5 & 1.25 \\\\\n\\cline{1-2} 2 & \\cmidrule{2-3}-3\\\\\n"), ["0.5 1.25", "2 -3"]);
        assert_eq!(words("\\sqrt{12} & \\sqrt3\\\\\n"), ["sqrt(12) √3"]);
        // An environment may begin or end with a line break, and the last row has none.
        let broken = "\\begin{tabular}{cc} \\\\\n0.5 & 1.25 \\\\\n\\frac12 & 3\n\\end{tabular} \\\\\n7 \\\\\nas & in\n";
        assert_eq!(words(broken), ["", "0.5 1.25", "(1)/(2) 3", "", "7", "as in"]);
        let close =
            "\\begin{tabular}[t]{cc} 0.5 & 1.25 \\\\\n3 & 4 \\\\ \\end{tabular}\n\\begin{center}\n\\end{center}\n";
        assert_eq!(words(close), ["0.5 1.25", "3 4", "", ""]);
        assert_eq!(words("x \\cline{1-2} & 2\\\\\n"), ["x 2"]);
        // What is computed is one word, prose is as it was.
        assert_eq!(words("1 + 2 & method I\\\\\n"), ["1+2 method I"]);
        assert_eq!(words("| h | u |\n|---|:--|\n| 1 | 2 |\n"), ["h u", "", "1 2"]);
        assert_eq!(words("Order 3:\n| c | a |\n|---|---|\n| $\\frac12$ | $-1$ |\n"), ["", "c a", "", "(1)/(2) -1"]);
        assert_eq!(words("| 0 | |\n| 1/2 | 1/2 |\n"), ["0", "1/2 1/2"]);
        for plain in [
            "| 0 | 1 |\n",
            "a = 1\n| 0 |\n|---|\n",
            "0 1\n1/2 1/2\n1\n",
            "0 | 1\n | 1\n",
            "| 0\n| 1\n",
            "0 |\n1 |\n",
            "| 0 | 1 |\n---\n| 2 | 3 |\n",
            "| 0 | 1 |\n| 2 | 3 |\n|\n",
            "h,u & v\n1,2\n",
            "h,\\\\u\n1,2\n",
            "h,u\n1,2\n",
            "a = [\"1 & 2 \\\\\"]\n",
        ] {
            assert!(matches!(bare(plain), Cow::Borrowed(_)), "{plain}");
        }
    }
}
