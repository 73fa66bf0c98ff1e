//! The tests are built on what the report has built: no package has other features because of them.

use std::collections::BTreeSet;
use std::process::Command;

/// Packages with their features, one a line, of what is built for these arguments.
fn features(asked: &[&str]) -> BTreeSet<String> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let format = ["--prefix", "none", "--format", "{p} [{f}]"];
    let tree = Command::new(cargo)
        .args(["tree", "--offline", "--locked"])
        .args(format)
        .args(asked)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .output()
        .expect("cargo runs");
    assert!(tree.status.success(), "{}", String::from_utf8_lossy(&tree.stderr));
    // What was shown before is marked.
    String::from_utf8_lossy(&tree.stdout).lines().map(|line| line.trim_end_matches(" (*)").to_owned()).collect()
}

#[test]
fn nothing_that_the_report_has_built_is_built_anew_for_the_tests() {
    let report = features(&["--package", "verify", "--edges", "normal,build"]);
    let tests = features(&["--workspace", "--edges", "normal,build,dev"]);
    let anew: Vec<_> = report.difference(&tests).collect();
    assert!(anew.is_empty() && report.len() > 100, "{anew:#?}");
}
