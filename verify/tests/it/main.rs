//! What the program promises, in one binary, so that it is linked once. What it finds is tested by name in `evidence.rs`.

mod branches;
mod claims;
mod cli;
mod closed_forms;
mod edges;
mod equivariance;
mod features;
mod formats;
mod fuzz;
mod goldens;
mod judge;
mod judgements;
mod layers;
mod misprints;
mod model;
mod own;
mod readme;
mod recipes;
mod references;
mod refusals;
mod regions;
mod report;
mod strangers;
mod twins;

use std::path::{Path, PathBuf};

/// A place for what one test writes, with nothing there. A message that names it is always broken over several lines,
/// as it is wherever a checkout lies deep.
fn scratch(name: &str) -> PathBuf {
    let wide = "a-directory-with-a-name-that-leaves-no-room-for-a-message-on-a-line-of-eighty-columns";
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(wide).join(name);
    match path.is_dir() {
        true => std::fs::remove_dir_all(&path).expect("removable"),
        false => drop(std::fs::remove_file(&path)),
    }
    std::fs::create_dir_all(path.parent().expect("inside a directory")).expect("writable");
    path
}

/// Writes a file of a test, and returns its path as an argument.
fn written(dir: &Path, name: &str, text: &str) -> String {
    let path = dir.join(name);
    std::fs::write(&path, text).expect("writable");
    path.display().to_string()
}

/// A text on one line: where a terminal breaks it is another matter.
fn flat(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// No line is wider than a terminal, save by a path, which is not broken.
#[track_caller]
fn fits_a_terminal(text: &str) {
    let columns = |text: &str| text.chars().filter(|c| !('\u{300}'..='\u{36f}').contains(c)).count();
    for line in text.lines() {
        let is_path = line.split_whitespace().any(|word| columns(word) > 60);
        assert!(columns(line) <= 80 || is_path, "{} columns: {line}", columns(line));
    }
}
