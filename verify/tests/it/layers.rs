//! The modules of `verify` and of the crates below it stand on layers: what a module uses is below it, and only some of them run solvers.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// From the ground up. Modules of one layer do not use each other.
const LAYERS: &[&[&str]] = &[
    &["kinds", "names", "measure", "panics", "replacement"],
    &["reference"],
    &["problem"],
    &["method"],
    &["theory", "run", "program"],
    &["order", "estimate"],
    &["compare"],
    &["bench", "experiment"],
    &["evidence"],
    &["advise", "judge"],
    &["claim"],
    &["chapter"],
    &["golden"],
    &["report"],
    &["cli"],
];

/// The modules that are crates.
const CRATES: &[&str] = &["evidence", "judge"];

/// The modules that may run a method or a reference, and the command line, which does so for its user.
const SOLVERS: &[&str] = &["run", "reference", "order", "compare", "estimate"];
const MAY_SOLVE: &[&str] = &[
    "reference",
    "problem",
    "method",
    "theory",
    "run",
    "order",
    "estimate",
    "experiment",
    "advise",
    "bench",
    "judge",
    "compare",
    "cli",
];
/// What the other modules may use of the library: values, no integrators.
const VALUES: &[&str] = &["Work", "SolveError", "StepError", "InputError", "quadrature"];

/// The sources of the crates from the ground up, and before them the module that a crate is as a whole.
fn sources() -> [(&'static str, PathBuf); 4] {
    [("", "experiments/src"), ("evidence/", "evidence/src"), ("judge/", "judge/src"), ("", "src")]
        .map(|(module, source)| (module, Path::new(env!("CARGO_MANIFEST_DIR")).join(source)))
}

/// All files of the crates with their paths in `src`, crate by crate.
fn all_files() -> [Vec<(String, String)>; 4] {
    sources().map(|(module, source)| {
        let mut found = Vec::new();
        files((module, &source), &source, &mut found);
        found
    })
}

fn files((module, source): (&str, &Path), dir: &Path, found: &mut Vec<(String, String)>) {
    for entry in fs::read_dir(dir).expect("a folder of this crate").map(|entry| entry.expect("readable").path()) {
        if entry.is_dir() {
            files((module, source), &entry, found);
        } else if entry.extension().is_some_and(|extension| extension == "rs") {
            let path = entry.strip_prefix(source).expect("below it").to_string_lossy().replace('\\', "/");
            let path = format!("{module}{path}");
            let is_test = path.ends_with("tests.rs");
            let text = fs::read_to_string(&entry).expect("readable");
            if !is_test && !["lib.rs", "main.rs"].contains(&path.as_str()) {
                found.push((path, text));
            }
        }
    }
}

/// The first names after each `root::` in the text outside of comments and tests, those of a list in braces too.
fn uses(text: &str, root: &str) -> BTreeSet<String> {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    // What stands in backticks is spoken of, not used.
    let code: Vec<String> = lines.map(|line| line.split('`').step_by(2).collect()).collect();
    let code = code.join("\n");
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut found = BTreeSet::new();
    for (at, _) in code.match_indices(&format!("{root}::")) {
        if code[..at].ends_with(|c: char| is_name(c) || c == ':') {
            continue;
        }
        let rest = &code[at + root.len() + 2..];
        let name = |text: &str| text.trim().chars().take_while(|c| is_name(*c)).collect::<String>();
        match rest.strip_prefix('{') {
            None => {
                found.insert(name(rest));
            }
            Some(list) => {
                // Names at the outer level of the braces.
                let mut depth = 0;
                let mut item = String::new();
                for c in list.chars() {
                    match c {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        ',' if depth == 0 => {
                            found.insert(name(&item));
                            item.clear();
                            continue;
                        }
                        _ => {}
                    }
                    item.push(c);
                }
                found.insert(name(&item));
            }
        }
    }
    found.remove("");
    found
}

fn layer(module: &str) -> Option<usize> {
    LAYERS.iter().position(|layer| layer.contains(&module))
}

/// What a file uses that it should not.
fn breaches(path: &str, text: &str) -> Vec<String> {
    let module = module(path);
    let Some(own) = layer(module) else { return vec![format!("the module {module} has no layer")] };
    let mut found = Vec::new();
    let mut used = uses(text, "experiments");
    if !CRATES.contains(&module) {
        used.append(&mut uses(text, "crate"));
        used.append(&mut uses(text, "verify"));
    }
    used.extend(CRATES.iter().filter(|name| !uses(text, name).is_empty()).map(|name| (*name).to_owned()));
    for used in used {
        // A macro of the crate is a macro of its module.
        let used = if used == "row" { "evidence".into() } else { used };
        let is_below = layer(&used).is_some_and(|layer| layer < own);
        let may_run = MAY_SOLVE.contains(&module) || !SOLVERS.contains(&used.as_str());
        // Modules of the command line itself come without a module.
        if used != module && module != "cli" && !(is_below && may_run) {
            found.push(used);
        }
    }
    if !MAY_SOLVE.contains(&module) {
        let values = |used: &String| !VALUES.contains(&used.as_str());
        if uses(text, "lsvi").iter().any(values) {
            found.push("lsvi".into());
        }
    }
    found
}

#[test]
fn every_module_uses_what_is_below_it_and_only_some_run_solvers() {
    let all = all_files();
    let found: BTreeSet<(String, String)> = all
        .iter()
        .flatten()
        .flat_map(|(path, text)| breaches(path, text).into_iter().map(move |used| (path.clone(), used)))
        .collect();
    assert!(found.is_empty(), "these use what they should not: {found:#?}");
}

/// The name of the module that a file of a crate is part of.
fn module(path: &str) -> &str {
    path.split('/').next().unwrap_or_default().trim_end_matches(".rs")
}

/// What is measured, `experiments`, is compiled without what is said of it, `verify`.
#[test]
fn every_layer_is_in_one_crate_but_for_what_is_beside_judge() {
    let layers = all_files().map(|all| {
        let mut layers: Vec<_> = all.iter().filter_map(|(path, _)| layer(module(path))).collect();
        layers.sort_unstable();
        layers.dedup();
        layers
    });
    let [evidence, judge] = ["evidence", "judge"].map(|name| layer(name).expect("a layer"));
    assert_eq!(
        layers,
        [(0..evidence).collect(), vec![evidence], vec![judge], (judge..LAYERS.len()).collect::<Vec<_>>()]
    );
}

/// The layers of a drawing, `a, b → c`, the first indented block of a text, and the names in backticks of the sentence below it.
fn drawn(text: &str) -> (Vec<Vec<&str>>, BTreeSet<&str>) {
    let mut lines = text.lines().skip_while(|line| !line.starts_with("    "));
    let drawing: Vec<&str> = lines.by_ref().take_while(|line| line.starts_with("    ")).collect();
    let layers = drawing.iter().flat_map(|line| line.split('→')).map(|layer| layer.split(',').map(str::trim));
    let layers = layers.map(|modules| modules.filter(|module| !module.is_empty()).collect::<Vec<_>>());
    // `take_while` has eaten the empty line.
    let below: Vec<&str> = lines.take_while(|line| !line.is_empty()).collect();
    let names = below.into_iter().flat_map(|line| line.split('`').skip(1).step_by(2));
    (layers.filter(|layer| !layer.is_empty()).collect(), names.collect())
}

/// ARCHITECTURE.md draws the layers as they are, and names the modules that run nothing.
#[test]
fn the_drawing_of_the_modules_is_the_order_that_is_held() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../ARCHITECTURE.md");
    let text = fs::read_to_string(path).expect("readable");
    let (layers, idle) = drawn(&text);
    assert_eq!(layers, LAYERS);
    let others = LAYERS.iter().flat_map(|layer| layer.iter().copied()).filter(|module| !MAY_SOLVE.contains(module));
    assert_eq!(idle, others.collect());
}

#[test]
fn a_drawing_is_read_line_by_line() {
    let (layers, idle) = drawn("Text → no.\n\n    a, b → c\n    → d\n\nNot `a` and\n`c`.\n\nNor `d`.");
    assert_eq!((layers, idle), (vec![vec!["a", "b"], vec!["c"], vec!["d"]], BTreeSet::from(["a", "c"])));
}

#[test]
fn uses_are_read_as_the_compiler_reads_them() {
    let text = "use crate::a::{b, c};\nuse crate::{d, e::{f, g}};\n// crate::comment\nlet x = crate::h::i();\n\
                my_crate::j();\n#[cfg(test)]\nuse crate::k;";
    assert_eq!(uses(text, "crate").into_iter().collect::<Vec<_>>(), ["a", "d", "e", "h"]);
}

#[test]
fn breaches_are_found() {
    assert_eq!(breaches("problem/x.rs", "use crate::method::parse;"), ["method"]);
    assert_eq!(breaches("claim/x.rs", "use crate::run::run;\nuse crate::experiment::Context;"), ["run"]);
    assert_eq!(breaches("claim/x.rs", "use lsvi::{Work, Trajectory};"), ["lsvi"]);
    assert_eq!(breaches("chapter/x.rs", "use crate::row;\nuse crate::measure::norm;"), Vec::<String>::new());
    assert_eq!(
        breaches("evidence/x.rs", "use crate::Cell;\nuse experiments::measure::order::Verdict;"),
        Vec::<String>::new()
    );
    assert_eq!(breaches("judge/x.rs", "use crate::run::run;\nuse experiments::compare::Entry;"), Vec::<String>::new());
    assert_eq!(breaches("evidence/x.rs", "use judge::Judgement;\nuse experiments::run::run;"), ["judge", "run"]);
    assert_eq!(breaches("attic/x.rs", ""), ["the module attic has no layer"]);
}
