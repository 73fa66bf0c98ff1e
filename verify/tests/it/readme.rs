//! The README tells the truth.

use std::path::Path;

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
            compared += 1;
        }
    }
    assert!(compared >= 40, "only {compared} numbers in the table");
}

/// What the README shows of `judge` is what it prints.
#[test]
fn the_judgement_is_the_one_that_the_command_prints() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace");
    let readme = std::fs::read_to_string(root.join("README.md")).expect("README.md");
    let part = readme.split("<!-- judge -->").nth(1).and_then(|rest| rest.split("<!-- /judge -->").next());
    let block = part.and_then(|part| part.split("```console\n").nth(1)).and_then(|rest| rest.split("```").next());
    let (command, shown) = block.and_then(|block| block.split_once('\n')).expect("a command and what it prints");
    let arguments = command.strip_prefix("$ verify ").expect("a command").split_whitespace();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_verify")).args(arguments).output().expect("it starts");
    assert_eq!(String::from_utf8(output.stdout).expect("UTF-8"), shown);
    assert_eq!(output.status.code(), Some(1));
}
