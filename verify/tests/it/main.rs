//! What the program promises, in one binary, so that it is linked once. What it finds is tested by name in `evidence.rs`.

mod claims;
mod cli;
mod closed_forms;
mod floors;
mod formats;
mod goldens;
mod judge;
mod model;
mod own;
mod readme;
mod recipes;
mod references;
mod report;

/// A text on one line: where a terminal breaks it is another matter.
fn flat(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
