//! The machinery that keeps the golden files catches whatever can go wrong with them.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use verify::golden::{self, Action, Difference, Golden, NumericComparator, Recorded, Row, Status, Tolerance, Truth};

fn workspace_dir() -> PathBuf {
    golden::find_dir(Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// Runs the command line's action; returns whether all is well, and what was printed.
fn run(action: Action, dir: &Path, goldens: &[Golden]) -> (bool, String) {
    let mut out = Vec::new();
    let ok = golden::run(action, dir, goldens, None, &mut out).unwrap();
    (ok, String::from_utf8(out).unwrap())
}

/// Asserts a golden through insta, which reads `dir/NAME.snap.csv`.
fn assert_with_insta(dir: &Path, golden: &Golden) {
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path(dir);
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.set_comparator(Box::new(NumericComparator));
    let csv = golden::render(&golden.rows().unwrap());
    settings.bind(|| insta::assert_binary_snapshot!(&format!("{}.csv", golden.name), csv.into_bytes()));
}

/// A directory of its own for one test, with the golden `sample` of [`sample_rows`] in it.
fn fixture(test: &str) -> PathBuf {
    let dir = crate::scratch(&format!("goldens/{test}"));
    let (ok, printed) = run(Action::Refresh, &dir, &[sample(sample_rows())]);
    assert!(ok && printed.contains("wrote sample.snap.csv: 4 rows"), "{printed}");
    assert!(!printed.contains("not refreshed"), "{printed}");
    dir
}

fn sample(rows: Vec<Row>) -> Golden {
    Golden::new("sample", move || Ok(rows.clone()))
}

fn sample_rows() -> Vec<Row> {
    let truth = |value| Truth { value, allowance: 1e-3, source: "tables, \"Handbook\"".into() };
    vec![
        Row::number("zeta(3)", 1.2020, Tolerance::relative(1e-6, "printed to four digits"))
            .with_truth(truth(1.202_056_903_159_594_2)),
        Row::number("catalan", 0.916, Tolerance::relative(1e-6, "printed to four digits"))
            .with_truth(truth(0.915_965_594_177_219)),
        Row::number("zero", 0.0, Tolerance::absolute(1e-12, "crosses zero")),
        Row::text("method", "Method I, (α, β) = (0, 1)"),
    ]
}

/// Where there is no directory there is no file; what cannot be listed may hold any.
#[test]
fn files_are_left_over_only_where_they_can_be_listed() {
    let dir = fixture("listed");
    assert_eq!(golden::strays(&dir.join("none"), &[]).unwrap(), Vec::<PathBuf>::new());
    assert_eq!(golden::strays(&dir, &[]).unwrap().len(), 2);
    assert!(matches!(golden::strays(&dir.join("sample.snap"), &[]), Err(golden::GoldenError::Io { .. })));
}

/// What a failed test leaves to review is a file of no golden.
#[test]
fn a_snapshot_that_waits_for_review_is_not_clean() {
    let dir = fixture("waiting");
    assert!(run(Action::Check, &dir, &[sample(sample_rows())]).0);
    fs::write(dir.join("sample.snap.new"), "waits").unwrap();
    assert!(!run(Action::Check, &dir, &[sample(sample_rows())]).0);
}

fn with_value(index: usize, value: f64) -> Vec<Row> {
    let mut rows = sample_rows();
    if let golden::Value::Number(number) = &mut rows[index].value {
        number.value = value;
    }
    rows
}

fn edit(dir: &Path, change: impl Fn(&str) -> String) {
    let path = dir.join("sample.snap.csv");
    let text = fs::read_to_string(&path).unwrap();
    let changed = change(&text);
    assert_ne!(text, changed);
    fs::write(path, changed).unwrap();
}

/// Checks `rows` against the fixture, through the command line's check and through insta's comparator alike.
fn holds(dir: &Path, rows: Vec<Row>) -> bool {
    let golden = sample(rows);
    let (ok, printed) = run(Action::Check, dir, std::slice::from_ref(&golden));
    assert_eq!(ok, printed.contains("the golden holds"), "{printed}");
    let insta = catch_unwind(AssertUnwindSafe(|| assert_with_insta(dir, &golden))).is_ok();
    assert_eq!(ok, insta, "insta and the command line disagree: {printed}");
    ok
}

#[test]
fn numbers_may_move_within_their_tolerance_only() {
    let dir = fixture("numbers");
    assert!(holds(&dir, sample_rows()));
    assert!(holds(&dir, with_value(1, 0.916 * (1.0 + 0.9e-6))));
    assert!(!holds(&dir, with_value(1, 0.916 * (1.0 + 1.1e-6))));
    assert!(holds(&dir, with_value(2, -0.9e-12)));
    assert!(!holds(&dir, with_value(2, 1.1e-12)));
    let mut reordered = sample_rows();
    reordered.reverse();
    assert!(holds(&dir, reordered));
}

#[test]
fn nan_and_infinity_never_hold() {
    let dir = fixture("nan");
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(!holds(&dir, with_value(1, bad)));
        edit(&dir, |text| text.replace("catalan,0.916,", &format!("catalan,{bad:?},")));
        assert!(!holds(&dir, with_value(1, bad)));
        let (ok, printed) = run(Action::Refresh, &dir, &[sample(with_value(1, bad))]);
        assert!(!ok && printed.contains("refused sample"), "{printed}");
        run(Action::Refresh, &dir, &[sample(sample_rows())]);
    }
    // Neither equals itself, even past the checks of the file and of the computed row.
    let nan = with_value(1, f64::NAN);
    let recorded = nan.iter().map(|row| Recorded { row: row.clone(), distance: None }).collect::<Vec<_>>();
    let changes = golden::compare(&recorded, &nan);
    assert!(changes.iter().any(|change| matches!(change.difference, Difference::Number { .. })), "{changes:?}");
}

#[test]
fn rows_may_neither_vanish_nor_appear() {
    let dir = fixture("rows");
    let mut rows = sample_rows();
    rows.remove(2);
    assert!(!holds(&dir, rows.clone()));
    assert!(run(Action::Diff, &dir, &[sample(rows)]).1.contains("zero: vanished"));
    let mut rows = sample_rows();
    rows.push(Row::text("more", "x"));
    assert!(!holds(&dir, rows.clone()));
    let (ok, printed) = run(Action::Refresh, &dir, &[sample(rows.clone())]);
    assert!(ok && printed.contains("more: new row, `x`"), "{printed}");
    assert!(holds(&dir, rows.clone()));
    rows.push(Row::text("more", "x"));
    assert!(!holds(&dir, rows.clone()), "a key computed twice");
    assert!(run(Action::Refresh, &dir, &[sample(rows)]).1.contains("refused sample"));
}

#[test]
fn texts_and_statements_about_numbers_are_exact() {
    let dir = fixture("texts");
    let changed = |change: &dyn Fn(&mut golden::Number)| {
        let mut rows = sample_rows();
        if let golden::Value::Number(number) = &mut rows[1].value {
            change(number);
        }
        rows
    };
    let truth = |n: &mut golden::Number, change: &dyn Fn(&mut Truth)| n.truth.iter_mut().for_each(change);
    assert!(!holds(&dir, changed(&|n| n.tolerance.rtol = 1e-3)));
    assert!(!holds(&dir, changed(&|n| n.tolerance.atol = 1e-3)));
    assert!(!holds(&dir, changed(&|n| n.tolerance.reason = "wider".into())));
    assert!(!holds(&dir, changed(&|n| n.tolerance.reason.clear())));
    assert!(!holds(&dir, changed(&|n| n.tolerance.rtol = -1e-6)));
    assert!(!holds(&dir, changed(&|n| n.truth = None)));
    assert!(!holds(&dir, changed(&|n| truth(n, &|t| t.value = 0.9161))));
    assert!(!holds(&dir, changed(&|n| truth(n, &|t| t.allowance = 1e-2))));
    // A computed bound moves with the rounding that it comes from.
    assert!(holds(&dir, changed(&|n| truth(n, &|t| t.allowance *= 1.009))));
    assert!(!holds(&dir, changed(&|n| truth(n, &|t| t.allowance *= 1.011))));
    assert!(!holds(&dir, changed(&|n| truth(n, &|t| t.allowance *= 0.98))));
    assert!(!holds(&dir, changed(&|n| truth(n, &|t| t.source = "hearsay".into()))));
    let mut rows = sample_rows();
    rows[3] = Row::text("method", "Method II");
    assert!(!holds(&dir, rows));
    let mut rows = sample_rows();
    rows[1] = Row::text("catalan", "0.916");
    assert!(!holds(&dir, rows), "a text that looks like the number");
}

#[test]
fn a_tolerance_that_allows_everything_is_no_tolerance() {
    let dir = fixture("tolerance");
    for (rtol, atol) in [(0.0, f64::INFINITY), (f64::INFINITY, 0.0), (f64::NAN, 0.0), (0.0, -1.0)] {
        let mut rows = sample_rows();
        if let golden::Value::Number(number) = &mut rows[1].value {
            (number.tolerance.rtol, number.tolerance.atol) = (rtol, atol);
        }
        let (ok, printed) = run(Action::Refresh, &dir, &[sample(rows)]);
        assert!(!ok && printed.contains("is no tolerance") && printed.contains("refused sample"), "{printed}");
    }
}

/// A file that has none either makes it no golden.
#[test]
fn a_golden_without_rows_is_none() {
    let dir = fixture("empty");
    let (ok, printed) = run(Action::Refresh, &dir, &[sample(vec![])]);
    assert!(!ok && printed.contains("it has no rows") && printed.contains("refused sample"), "{printed}");
    fs::write(dir.join("sample.snap.csv"), golden::render(&[])).unwrap();
    assert!(!holds(&dir, vec![]));
}

#[test]
fn a_wrong_number_is_not_frozen_as_right() {
    let dir = fixture("untrue");
    let wrong = with_value(1, 0.97);
    let (ok, printed) = run(Action::Refresh, &dir, &[sample(wrong.clone())]);
    assert!(!ok && printed.contains("catalan: WRONG, 5.40e-2 from the truth, allowed 1.00e-3"), "{printed}");
    assert!(printed.contains("refused sample"), "{printed}");
    assert!(holds(&dir, sample_rows()), "the old file is still there");
    // Even a file that agrees with the wrong number does not make it hold.
    fs::write(dir.join("sample.snap.csv"), golden::render(&wrong)).unwrap();
    assert!(!holds(&dir, wrong));
}

#[test]
fn a_refresh_says_how_each_number_moved_and_then_it_holds() {
    let dir = fixture("refresh");
    let mut rows = with_value(0, 1.2021);
    rows[1] = with_value(1, 0.9155)[1].clone();
    rows[2] = with_value(2, 1e-9)[2].clone();
    let (ok, diff) = run(Action::Diff, &dir, &[sample(rows.clone())]);
    assert!(!ok && !holds(&dir, rows.clone()));
    for line in [
        "  old  1.202\n    new  1.2021\n    relative change +8.32e-5, tolerance 1.00e-6\n    toward the truth: distance 5.69e-5 -> 4.31e-5",
        "AWAY from the truth: distance 3.44e-5 -> 4.66e-4",
        "change +1.00e-9 from zero, tolerance 1.00e-12\n    no truth is known",
    ] {
        assert!(diff.contains(line), "{diff}");
    }
    assert!(diff.lines().all(|line| line.chars().count() <= 80), "{diff}");
    let (ok, printed) = run(Action::Refresh, &dir, &[sample(rows.clone())]);
    assert!(ok && printed.starts_with(&diff) && printed.ends_with("wrote sample.snap.csv: 4 rows\n"), "{printed}");
    assert!(holds(&dir, rows.clone()));
    assert_eq!(run(Action::Refresh, &dir, &[sample(rows)]), (true, "sample: ok\nnothing to refresh\n".into()));
    assert_eq!(fs::read_dir(&dir).unwrap().count(), 2, "no temporary file is left");
}

#[test]
fn a_change_to_the_other_side_of_the_truth_is_no_nearer() {
    let dir = crate::scratch("goldens/other-side");
    let of = |value: f64| {
        let truth = Truth { value: 0.5, allowance: 0.1, source: "a half".into() };
        [sample(vec![Row::number("half", value, Tolerance::relative(1e-6, "exact")).with_truth(truth)])]
    };
    assert!(run(Action::Refresh, &dir, &of(0.4375)).0);
    let printed = run(Action::Diff, &dir, &of(0.5625)).1;
    assert!(printed.contains("no nearer to the truth: distance 6.25e-2 -> 6.25e-2"), "{printed}");
}

#[test]
fn a_missing_file_fails_until_it_is_refreshed() {
    for file in ["sample.snap", "sample.snap.csv"] {
        let dir = fixture(&format!("missing-{file}"));
        fs::remove_file(dir.join(file)).unwrap();
        assert!(!holds(&dir, sample_rows()));
        assert!(run(Action::Refresh, &dir, &[sample(sample_rows())]).0);
        assert!(holds(&dir, sample_rows()));
    }
}

#[test]
fn orphans_fail_and_a_refresh_removes_them() {
    let dir = fixture("orphans");
    for file in ["gone.snap", "gone.snap.csv", ".gitattributes", "README.md"] {
        fs::write(dir.join(file), "").unwrap();
    }
    let golden = [sample(sample_rows())];
    let (ok, printed) = run(Action::Check, &dir, &golden);
    assert!(!ok && printed.contains("gone.snap.csv: orphan"), "{printed}");
    let (ok, printed) = run(Action::Refresh, &dir, &golden);
    assert!(ok && printed.contains("removed gone.snap.csv"), "{printed}");
    assert!(run(Action::Check, &dir, &golden).0);
    assert!(dir.join(".gitattributes").exists() && dir.join("README.md").exists());
    // What is no snapshot is reported, but never removed.
    fs::write(dir.join("thesis.csv"), "").unwrap();
    assert!(run(Action::Check, &dir, &golden).1.contains("thesis.csv: orphan"));
    assert!(golden::run(Action::Refresh, &dir, &golden, None, &mut Vec::new()).is_err());
    fs::remove_file(dir.join("thesis.csv")).unwrap();
    // A golden that cannot be computed keeps its file, and fails.
    let failing = [Golden::new("sample", || Err("the solver stopped".into()))];
    let (ok, printed) = run(Action::Refresh, &dir, &failing);
    assert!(!ok && printed.contains("cannot be computed, the solver stopped"), "{printed}");
    assert!(printed.ends_with("\n1 of 1 goldens were not refreshed\n"), "{printed}");
    assert!(run(Action::Check, &dir, &golden).0);
}

#[test]
fn a_damaged_file_is_refused_with_its_line_and_can_be_refreshed() {
    type Damage = fn(&str) -> String;
    let cases: [(&str, Damage, &str); 8] = [
        ("no column", |t| t.replace(",distance", ""), "line 1: there is no column `distance`"),
        ("other columns", |t| t.replacen("key,value", "value,key", 1), "line 1: the columns are not key,value,"),
        ("no number", |t| t.replace("0.916", "0,916"), "line 3: 10 fields, not 9"),
        ("bad number", |t| t.replace("0.916", "0.9l6"), "line 3: `0.9l6` in column `value` is not a number"),
        ("infinite", |t| t.replace("0.916", "inf"), "line 3: column `value` holds inf"),
        ("no tolerance", |t| t.replace("zero,0.0,0.0,1e-12", "zero,0.0,,"), "line 4: `` in column `rtol`"),
        ("twice", |t| t.replace("catalan,", "zeta(3),"), "line 3: the key `zeta(3)` stands there twice"),
        ("empty", |_| String::new(), "line 1: the file is empty"),
    ];
    for (name, damage, message) in cases {
        let dir = fixture(&format!("damaged-{}", name.replace(' ', "-")));
        edit(&dir, damage);
        assert!(!holds(&dir, sample_rows()), "{name}");
        let printed = run(Action::Check, &dir, &[sample(sample_rows())]).1;
        assert!(printed.contains(message), "{name}: {printed}");
        assert!(run(Action::Refresh, &dir, &[sample(sample_rows())]).0);
        assert!(holds(&dir, sample_rows()), "{name}");
    }
}

#[test]
fn one_bad_line_hides_no_change_of_another() {
    let dir = fixture("bad-line");
    edit(&dir, |text| text.replace("zero,0.0,0.0,1e-12", "zero,O.O,0.0,1e-12"));
    let (ok, printed) = run(Action::Diff, &dir, &[sample(with_value(1, 0.9155))]);
    assert!(!ok && printed.contains("line 4: `O.O` in column `value` is not a number"), "{printed}");
    assert!(printed.contains("old  0.916\n    new  0.9155"), "the readable rows are compared: {printed}");
    assert_eq!(printed.matches("new row").count(), 1, "{printed}");
}

#[test]
fn both_sides_of_a_merge_are_read() {
    let dir = fixture("merge");
    edit(&dir, |text| {
        let line = text.lines().nth(2).expect("a second row").to_owned();
        let theirs = line.replace("0.916", "0.917");
        text.replace(&line, &format!("<<<<<<< HEAD\n{line}\n=======\n{theirs}\n>>>>>>> theirs"))
    });
    let (ok, printed) = run(Action::Diff, &dir, &[sample(sample_rows())]);
    assert!(!ok && printed.contains("line 3: the marker `<<<<<<<` of a merge (settle the merge)"), "{printed}");
    assert!(printed.contains("line 6: the key `catalan` stands there twice"), "{printed}");
    assert!(!printed.contains("new row") && !printed.contains("vanished"), "{printed}");
}

#[test]
fn only_one_golden_is_touched_where_one_is_named() {
    let dir = fixture("only");
    let other = || Golden::new("other", || Ok(sample_rows()));
    let only = |action, name| {
        let mut out = Vec::new();
        let ok = golden::run(action, &dir, &[sample(with_value(1, 0.9155)), other()], Some(name), &mut out);
        (ok.map_err(|error| error.to_string()), String::from_utf8(out).unwrap())
    };
    fs::write(dir.join("stray.snap.csv"), "").unwrap();
    let before = fs::read(dir.join("sample.snap.csv")).unwrap();
    for action in [Action::Diff, Action::Refresh] {
        let (ok, printed) = only(action, "other");
        assert_eq!(ok, Ok(action == Action::Refresh));
        assert!(!printed.contains("sample") && !printed.contains("stray"), "{printed}");
    }
    assert!(dir.join("stray.snap.csv").is_file() && dir.join("other.snap.csv").is_file());
    assert_eq!(fs::read(dir.join("sample.snap.csv")).unwrap(), before);
    assert_eq!(only(Action::Check, "other"), (Ok(true), "other: ok\nthe golden holds\n".into()));
    assert_eq!(only(Action::Check, "nonsense").0, Err("no golden is called `nonsense`".into()));
}

#[test]
fn a_distance_to_the_truth_that_was_edited_is_noticed() {
    let dir = fixture("distance");
    edit(&dir, |text| text.replace(&format!("{:?}", 0.916 - 0.915_965_594_177_219), "0.5"));
    assert!(!holds(&dir, sample_rows()));
    assert!(run(Action::Diff, &dir, &[sample(sample_rows())]).1.contains("catalan: distance\n    old  0.5"));
}

#[test]
fn line_endings_do_not_matter_and_files_round_trip() {
    let dir = fixture("line-endings");
    let text = fs::read_to_string(dir.join("sample.snap.csv")).unwrap();
    assert!(!text.contains('\r'));
    let rows: Vec<Row> = golden::parse(text.as_bytes()).0.into_iter().map(|r| r.row).collect();
    assert_eq!(rows, sample_rows());
    edit(&dir, |text| text.replace('\n', "\r\n"));
    assert!(holds(&dir, sample_rows()));
}

#[test]
fn names_are_file_stems_and_used_once() {
    let dir = fixture("names");
    for name in ["", "a/b", "..", "Capital", "a b"] {
        assert!(golden::inspect(&dir, &[Golden::new(name, || Ok(vec![]))]).is_err(), "{name}");
    }
    assert!(golden::inspect(&dir, &[sample(vec![]), sample(vec![])]).is_err());
    let inspection = golden::inspect(&dir, &[Golden::new("other", || Ok(sample_rows()))]).unwrap();
    assert!(matches!(inspection.statuses().next(), Some(("other", Status::Missing(changes))) if changes.len() == 4));
    assert_eq!(golden::strays(&dir, &[Golden::new("other", || Ok(vec![]))]).unwrap().len(), 2);
}

#[test]
fn the_golden_directory_is_found_from_anywhere_in_the_workspace() {
    let from_crate = workspace_dir();
    assert_eq!(golden::find_dir(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src/golden")).unwrap(), from_crate);
    assert!(golden::find_dir(Path::new("/")).is_err());
}

/// Whatever the file says.
#[test]
fn a_number_is_wrong_farther_from_the_truth_than_it_is_allowed() {
    for sign in [1.0, -1.0] {
        let is_wrong = |part: f64| {
            let truth = Truth { value: 0.5, allowance: 0.1, source: "a half".into() };
            let row =
                Row::number("half", 0.5 + sign * part * 0.1, Tolerance::relative(1e-6, "exact")).with_truth(truth);
            let recorded = Recorded { row: row.clone(), distance: Some(part * 0.1) };
            golden::compare(&[recorded], &[row]).iter().any(|change| change.difference.is_wrong())
        };
        assert_eq!([0.9, 1.2].map(is_wrong), [false, true]);
    }
}
