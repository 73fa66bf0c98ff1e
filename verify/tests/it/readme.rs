//! The README tells the truth.

use std::path::Path;

use verify::chapter::{self, Context};
use verify::evidence::Outcome;
use verify::evidence::number::{brief, rounded_down, rounded_up};
use verify::measure::norm::Extremes;
use verify::{method, problem, theory};

/// Continuous integration runs the README's command, and that every check, the tests last.
#[test]
fn every_check_is_run_by_the_command_for_all() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace");
    let read = |name: &str| std::fs::read_to_string(root.join(name)).expect(name);
    let commands = |script: &str| -> Vec<String> {
        let is_command = |line: &&str| line.contains("cargo ") && !line.starts_with([' ', '#']);
        script.lines().filter(is_command).map(str::to_owned).collect()
    };
    let test = read("scripts/test");
    assert!(test.contains("\nset -euo pipefail\n"), "{test}");
    let all = [
        "cargo fmt --all --check",
        "with_bindings cargo clippy --workspace --all-targets --quiet -- -D warnings",
        "RUSTDOCFLAGS='-D warnings' cargo doc --workspace --no-deps --quiet",
        "cargo test --workspace \"$@\"",
    ];
    assert_eq!(commands(&test), all);
    assert!(test.trim_end().ends_with(all[3]), "{test}");
    let ci = read(".ci/run");
    assert!(ci.trim_end().ends_with("\nexec \"$(dirname \"${BASH_SOURCE[0]}\")/../scripts/test\" </dev/null"), "{ci}");
}

/// What the account says of changes that tests do not notice is what their list says, where each is below a reason, and the row of the README
/// is the sum of the account.
#[test]
fn the_changes_that_are_not_noticed_are_those_of_their_list() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace");
    let read = |name: &str| std::fs::read_to_string(root.join(name)).expect(name);
    let (readme, account) = (read("README.md"), read("scripts/schemata/known/README.md"));
    for (package, entries) in [("lsvi", "changes"), ("verify", "kinds")] {
        let list = read(&format!("scripts/schemata/known/{package}.txt"));
        let part = account.split("\n## ").find_map(|part| part.strip_prefix(package)).expect("a part");
        let counts = list.lines().next().and_then(|line| line.strip_prefix("# Of ")).expect("counts in the first line");
        assert!(part.contains(counts), "{counts}");
        let place = format!("{package}/");
        let known = list.lines().filter(|line| line.starts_with(&place)).count();
        let is_by_place = list.lines().any(|line| line.ends_with(" of 2)"));
        assert_eq!(is_by_place, entries == "changes", "{package}");
        assert!(part.contains(&format!(" {known} {entries} ")), "{known} {entries} are listed");
        let untested = list.split("# No test yet").nth(1).map(|last| {
            let untested = last.lines().filter(|line| line.starts_with(&place)).count();
            format!(" {untested} without a test yet")
        });
        match &untested {
            Some(untested) => assert!(part.contains(untested), "{untested}"),
            None => assert!(!part.contains("without a test yet"), "all that is listed has a reason"),
        }
        // Of all changes of a run of the command in the row, the first of the part.
        let run = part
            .lines()
            .find_map(|line| line.strip_prefix("Of ").filter(|line| line.contains(" changes ")))
            .expect("a run");
        let before = |words: &str| -> usize {
            let number = run.split(words).next().and_then(|before| before.rsplit(' ').next());
            number.and_then(|number| number.parse().ok()).expect(words)
        };
        let compiled = before(" changes ") - before(" do not compile") - before(" have no place");
        let ends: Vec<usize> = run.contains(" never end").then(|| before(" never end")).into_iter().collect();
        let parts = [before(" are noticed"), before(" are not noticed"), before(" are not within ")];
        assert_eq!(parts.iter().chain(&ends).sum::<usize>(), compiled, "{run}");
        let command = part.split('`').nth(1).expect("a command");
        let counted = format!(
            "| when last tested {} of {compiled} noticed, {}{} not, {} not within the time; ",
            before(" are noticed"),
            if ends.is_empty() { String::new() } else { format!("{} never end, ", ends[0]) },
            before(" are not noticed"),
            before(" are not within "),
        );
        let listed = format!(
            " {known} {entries}{} ([account](scripts/schemata/known/README.md#{package})) |",
            untested.map_or_else(String::new, |untested| format!(",{untested}"))
        );
        let row = readme.lines().find(|line| line.starts_with('|') && line.contains(command)).expect("a row");
        assert!(row.contains(&counted) && row.ends_with(&listed), "{counted}…{listed}");
        for (line, before) in list.lines().skip(1).zip(list.lines()) {
            assert!(!line.starts_with(&place) || !before.is_empty(), "no reason above {line}");
        }
    }
}

/// Every order in the README's table is the recorded one, to the digits printed; the record is held to the code elsewhere.
#[test]
fn the_table_of_orders_is_the_recorded_one() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace");
    let readme = std::fs::read_to_string(root.join("README.md")).expect("README.md");
    let golden = csv::Reader::from_path(root.join("golden/orders.snap.csv")).expect("a golden of orders");
    let recorded: Vec<(String, f64)> = golden
        .into_records()
        .map(|row| row.expect("well-formed"))
        .filter_map(|row| Some((row[0].to_owned(), row[1].parse().ok()?)))
        .collect();
    let table = readme.split("<!-- orders -->").nth(1).and_then(|rest| rest.split("<!-- /orders -->").next());
    let mut lines = table.expect("a table between markers").lines().filter(|line| line.starts_with('|'));
    let cells = |line: &str| line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
    let header = cells(lines.next().expect("a header"));
    let mut compared = 0;
    for row in lines.skip(1).map(cells) {
        let method = row[0].trim_matches('`');
        for (problem, printed) in header.iter().zip(&row).skip(1) {
            let key = format!("{problem} {method}");
            let known = recorded.iter().find(|(known, _)| *known == key);
            assert_eq!(*printed, known.map_or("—".to_owned(), |(_, value)| format!("{value:.2}")), "{key}");
            // Where there is none, the method is known to lose its branch.
            let (problem, method) = (problem::build_setting(problem), method::parse(method));
            let breaks = problem
                .is_ok_and(|problem| theory::breakdown(&*problem, &*method.expect(&key), problem.horizon()).is_some());
            assert_eq!(known.is_none(), breaks, "{key}");
            compared += 1;
        }
    }
    assert!(compared >= 40, "only {compared} numbers in the table");
}

/// What the README shows of one's own method, program and data is what the command prints.
#[test]
fn the_judgements_are_those_that_the_command_prints() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace");
    let readme = std::fs::read_to_string(root.join("README.md")).expect("README.md");
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("readme");
    std::fs::create_dir_all(&directory).expect("writable");
    let copy = std::fs::copy(root.join("verify/examples/drag.csv"), directory.join("drag.csv"));
    // Contracted products would differ in the last digits.
    let compiler = std::process::Command::new("cc")
        .args(["-O2", "-ffp-contract=off", "-DWRONG", "-o", "rk4"])
        .arg(root.join("verify/programs/rk4.c"))
        .arg("-lm")
        .current_dir(&directory)
        .status();
    assert!(copy.is_ok() && compiler.is_ok_and(|status| status.success()));
    for (marker, status) in [("judge", 1), ("judge-multistep", 1), ("program", 1), ("data", 0)] {
        let part = readme.split(&format!("<!-- {marker} -->")).nth(1);
        let part = part.and_then(|rest| rest.split(&format!("<!-- /{marker} -->")).next());
        let block = part.and_then(|part| part.split("```console\n").nth(1)).and_then(|rest| rest.split("```").next());
        let (command, shown) = block.and_then(|block| block.split_once('\n')).expect("a command and what it prints");
        let arguments = command.strip_prefix("$ verify ").expect("a command").split_whitespace();
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_verify"))
            .args(arguments)
            .current_dir(&directory)
            .env_remove("COLUMNS")
            .output()
            .expect("it starts");
        assert_eq!(String::from_utf8(output.stdout).expect("UTF-8"), shown, "{marker}");
        assert_eq!(output.status.code(), Some(status), "{marker}");
        assert!(shown.lines().count() < 30, "{marker} is no screen");
    }
}

/// What the README answers is what the first page of the report does, word for word and digit for digit.
#[test]
fn the_answers_are_those_of_the_report() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace");
    let readme = std::fs::read_to_string(root.join("README.md")).expect("README.md");
    let part = readme.split("<!-- answers -->").nth(1).and_then(|rest| rest.split("<!-- /answers -->").next());
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let bullets: Vec<String> = part.expect("a list between markers").split("\n- ").skip(1).map(words).collect();
    let study = chapter::ALL.iter().find(|study| study.id == "answers").expect("the first chapter");
    let evidence = (study.run)(&Context::quick()).expect("it runs");
    assert!(evidence.checks.iter().all(|check| check.outcome == Outcome::Pass), "the sentences rest on the checks");
    let answers = || evidence.sections.iter().filter(|section| !section.mark.is_empty());
    for section in answers() {
        let caption = section.figures.first().and_then(|id| evidence.figures.iter().find(|figure| figure.id == *id));
        let answer = caption.map_or_else(|| section.paragraphs[0].1.clone(), |figure| figure.caption.clone());
        let question = format!("*{}* ", section.title);
        let Some(bullet) = bullets.iter().find_map(|bullet| bullet.strip_prefix(question.as_str())) else {
            assert_eq!(section.id, "answer-trust", "the README leaves out `{}`", section.title);
            continue;
        };
        assert!(
            bullet.len() > 60 && words(&answer).starts_with(bullet),
            "the README says\n{bullet}\nthe report\n{answer}"
        );
    }
    assert!(bullets.len() + 1 == answers().count());
}

/// What the README says about its picture, from the record of the picture's numbers.
#[test]
fn the_picture_shows_what_is_said_of_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace");
    let readme = std::fs::read_to_string(root.join("README.md")).expect("README.md");
    let golden = csv::Reader::from_path(root.join("golden/figure-7.snap.csv")).expect("a golden of Figure 7");
    let rows: Vec<csv::StringRecord> = golden.into_records().map(|row| row.expect("well-formed")).collect();
    let error = |problem: &str, method: &str| -> f64 {
        let key = format!("{problem} h=0.001 {method}");
        rows.iter().find(|row| row[0] == *key).expect("recorded")[1].parse().expect("a number")
    };
    let own = error("poiseuille-ansatz", "method-i");
    let (mut ratios, mut same) = (Vec::new(), Vec::new());
    for rival in ["implicit-euler", "rk4"] {
        ratios.push(own / error("poiseuille-ansatz", rival));
        same.push(error("poiseuille-galerkin", rival) / own);
    }
    let said = format!("has {:.2} of the largest error of implicit Euler and {:.2} of RK4's", ratios[0], ratios[1]);
    let galerkin = format!("implicit Euler has {:.3} of its largest error and RK4 {:.3}.", same[0], same[1]);
    let readme = readme.split_whitespace().collect::<Vec<_>>().join(" ");
    for said in [said, galerkin] {
        assert!(readme.contains(&said), "{said}");
    }
}

/// What is said of loose tolerances on Robertson's system, and of instructions.
#[test]
fn the_steps_and_instructions_under_speed_are_counted() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace");
    let readme = std::fs::read_to_string(root.join("README.md")).expect("README.md");
    let readme = readme.split_whitespace().collect::<Vec<_>>().join(" ");
    let steps = |tolerance: &str| {
        let line = "solve --problem robertson --method radau-adaptive --t-end 40 --rtol";
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_verify"));
        let output = command.args(line.split(' ')).arg(tolerance).output().expect("starts");
        let text = String::from_utf8(output.stdout).expect("UTF-8");
        let count =
            text.lines().find_map(|line| line.split_once(" steps to t = 40")).unwrap_or_else(|| panic!("{text}"));
        count.0.to_owned()
    };
    let said = format!("it takes {} steps at a tolerance of 10⁻³, and still {} at 10⁻¹", steps("1e-3"), steps("1e-1"));
    assert!(readme.contains(&said), "{said}");
    let golden = std::fs::read_to_string(root.join("golden/callgrind/instructions.snap.csv")).expect("a golden");
    let count = |name: &str, whose: &str| -> f64 {
        let row = golden.lines().find_map(|row| row.strip_prefix(&format!("\"{name}: {whose}\","))).expect("a row");
        row.split(',').next().and_then(|x| x.parse().ok()).expect("a number")
    };
    for (name, words) in [
        ("Method I, quadratic drag", "drag"),
        ("midpoint, Kepler", "the midpoint rule"),
        ("Galerkin Gauss-2, Kepler", "Gauss-2"),
    ] {
        let said = format!("{:.0} and {:.0} for {words}", count(name, "lsvi"), count(name, "by hand"));
        assert!(readme.contains(&said), "{said}");
    }
    let names = golden.lines().filter_map(|row| Some(row.strip_prefix('"')?.split_once(": lsvi\"")?.0));
    let ratios: Vec<f64> = names.map(|name| count(name, "lsvi") / count(name, "by hand")).collect();
    let [low, high] =
        [rounded_down(ratios.iter().copied().smallest(), 2), rounded_up(ratios.iter().copied().largest(), 2)];
    let said = format!("take {} to {} times the instructions of the loops", brief(low), brief(high));
    assert!(readme.contains(&said), "{said}");
}
