//! The words of a chapter, in a `.md` beside it, with placeholders for what was computed.

use std::collections::BTreeSet;

use super::StudyError;

/// The paragraphs of `template` with every `{name}` replaced by its value. Paragraphs are set apart by blank lines.
///
/// # Errors
/// A placeholder without a value, a value without a placeholder, a brace without its other.
pub(super) fn fill(template: &str, values: &[(&str, String)]) -> Result<Vec<String>, StudyError> {
    let mut unused: BTreeSet<&str> = values.iter().map(|(name, _)| *name).collect();
    let mut paragraphs = Vec::new();
    for lines in template.split("\n\n").map(str::trim).filter(|lines| !lines.is_empty()) {
        let text = lines.lines().map(str::trim).collect::<Vec<_>>().join(" ");
        let mut filled = String::new();
        let mut rest = text.as_str();
        while let Some((before, after)) = rest.split_once('{') {
            let (name, after) = after.split_once('}').ok_or_else(|| format!("`{{{after}` is not closed"))?;
            let value = values.iter().find(|(known, _)| *known == name);
            let (name, value) = value.ok_or_else(|| format!("`{{{name}}}` has no value"))?;
            unused.remove(name);
            filled.push_str(before);
            filled.push_str(value);
            rest = after;
        }
        filled.push_str(rest);
        paragraphs.push(filled);
    }
    match unused.first() {
        Some(name) => Err(format!("nobody asks for the value `{name}`").into()),
        None => Ok(paragraphs),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::{Path, PathBuf};

    use super::*;

    #[test]
    fn placeholders_are_filled_and_lines_joined() {
        let values = [("a", "one".to_owned()), ("b", "two".to_owned())];
        let filled = fill("The {a}\nand the {b},\n\nagain {a}.\n", &values).expect("complete");
        assert_eq!(filled, ["The one and the two,", "again one."]);
    }

    #[test]
    fn what_is_missing_or_left_over_is_an_error() {
        let values = [("a", "one".to_owned())];
        for (template, message) in
            [("{b}", "`{b}` has no value"), ("none", "nobody asks for the value `a`"), ("{a", "`{a` is not closed")]
        {
            assert_eq!(fill(template, &values).expect_err("incomplete").to_string(), message);
        }
    }

    /// All `.md` files of chapters and claims.
    fn templates(dir: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(dir).expect("a folder of this crate").map(|entry| entry.expect("readable").path()) {
            if entry.is_dir() {
                templates(&entry, found);
            } else if entry.extension().is_some_and(|extension| extension == "md") {
                found.push(entry);
            }
        }
    }

    /// Numbers that stand in the text itself. A name or a formula in backticks may have digits, and so may what stands in a
    /// reference to a source, as in "Figure 7", "Eq. (23)", "Section 3" or "[S24]", and a word such as RK4.
    fn stated(template: &str) -> Vec<String> {
        let text: String = template.split('`').step_by(2).collect::<Vec<_>>().join(" ");
        let text: String = text.split('{').map(|part| part.split_once('}').map_or(part, |(_, rest)| rest)).collect();
        let words: Vec<&str> = text.split_whitespace().collect();
        let is_reference = |word: &str| {
            let word = word.trim_start_matches('(');
            ["Figure", "Figures", "Section", "Sections", "Table", "Tables", "Eq.", "Eqs.", "and", "to"].contains(&word)
        };
        let mut numbers = Vec::new();
        for (place, word) in words.iter().enumerate() {
            let begins_with_digit =
                word.trim_start_matches(|c: char| !c.is_alphanumeric()).starts_with(|c: char| c.is_ascii_digit());
            let mut before = words[..place]
                .iter()
                .rev()
                .take_while(|word| is_reference(word) || word.contains(|c: char| c.is_ascii_digit()));
            let is_cited = before.any(|word| is_reference(word) && !["and", "to"].contains(word));
            if begins_with_digit && !is_cited {
                numbers.push((*word).to_owned());
            }
        }
        numbers
    }

    #[test]
    fn stated_numbers_are_found() {
        assert_eq!(stated("At h = 1.5 RK4 (Figures 3 and 4, [S24] Eq. (23)) is {x} `p^2` ahead, by 3."), ["1.5", "3."]);
        assert_eq!(stated("twice in Sections 3 to 5 and 7 times"), Vec::<String>::new());
    }

    #[test]
    fn no_text_states_a_number_that_is_not_computed() {
        let mut found = Vec::new();
        templates(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut found);
        assert!(!found.is_empty());
        for path in found {
            let numbers = stated(&fs::read_to_string(&path).expect("readable"));
            assert!(numbers.is_empty(), "{}: {numbers:?}", path.display());
        }
    }
}
