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

/// The peers have a lock of their own, which no build of the workspace looks at.
#[test]
fn the_lock_of_the_peers_knows_what_the_workspace_depends_on() {
    let read = |path: &str| {
        std::fs::read_to_string(format!("{}/{path}", env!("CARGO_MANIFEST_DIR"))).expect("it stands in the repository")
    };
    let lock = read("peers/Cargo.lock");
    for (package, manifest) in [("experiments", "experiments/Cargo.toml"), ("lsvi", "../lsvi/Cargo.toml")] {
        let (_, block) = lock.split_once(&format!("name = \"{package}\"\n")).expect(package);
        let (block, _) = block.split_once("\n]").expect("a list of dependencies");
        // A version follows the name where there are several.
        let is_locked =
            |name: &str| [format!(" \"{name}\","), format!(" \"{name} ")].iter().any(|it| block.contains(it));
        let manifest = read(manifest);
        let (_, section) = manifest.split_once("[dependencies]\n").expect("dependencies");
        let lines = section.lines().take_while(|line| !line.is_empty()).filter(|line| !line.contains("optional"));
        let asked: Vec<_> = lines.filter_map(|line| line.split(['.', ' ']).next()).collect();
        let missing: Vec<_> = asked.iter().filter(|name| !is_locked(name)).collect();
        assert!(missing.is_empty() && asked.len() > 4, "{package}: {missing:?}; build verify/peers to mend its lock");
    }
}
