//! What the program says when it refuses or breaks off, with its hint and its exit status, word for word.

use std::fmt::Write;
use std::fs;
use std::process::Command;

use rayon::prelude::*;

use crate::{flat, scratch};

/// Files that commands name.
const FILES: [(&str, &str); 6] = [
    ("pole.ds", "u_i { x = 1 } F_i { x * x }"),
    ("log.ds", "u_i { x = 0 } F_i { log(x) }"),
    ("two.ds", "in_i { a = 1, b = 2 } u_i { x = 1, y = 0 } F_i { -a * x, -b * y }"),
    ("old.json", r#"{ "schema": 0 }"#),
    ("not.json", "no report"),
    ("grids.csv", "n,value\n1,2.0\n2,1.5\n4,1.25\n"),
];

const COMMANDS: [&str; 43] = [
    // Names.
    "solve --problem logistics --method rk4 --h 0.1 --t-end 1",
    "solve --problem logistic --method rk5 --h 0.1 --t-end 1",
    "solve --problem van-der-pol --set gamma=1 --method rk4 --h 0.1 --t-end 1",
    "solve --problem burgers --set cells=many --method rk4 --h 0.1 --t-end 1",
    "solve --problem burgers --set cells=0 --method rk4 --h 0.1 --t-end 1",
    "solve --problem van-der-pol --set mu=1 --set mu=2 --method rk4 --h 0.1 --t-end 1",
    "solve --problem logistic --method linear(1) --h 0.1 --t-end 1",
    "report --only model",
    "report --only order",
    "golden diff --dir . --only order",
    // Steps and tolerances.
    "solve --problem logistic --method rk4 --t-end 1",
    "solve --problem logistic --method rk4 --h 0 --t-end 1",
    "solve --problem logistic --method rk4 --h 1e-300 --t-end 1",
    "solve --problem logistic --method rk4 --h 0.1 --t-end -1",
    "solve --problem logistic --method rk4 --h 0.1 --rtol 1e-3 --t-end 1",
    "solve --problem logistic --method radau-adaptive --rtol 1e-30 --t-end 1",
    "solve --problem logistic --method radau-adaptive --atol -1 --t-end 1",
    "solve --problem logistic --method radau-adaptive --atol 1e-6,1e-6 --t-end 1",
    "solve --problem logistic --method galerkin-gauss(2) --h 0.25 --t-end 1",
    "solve --problem kepler --method bdf9 --h 0.1 --t-end 1",
    // Steps that fail.
    "solve --problem quadratic-drag --method method-ii --h 50 --t-end 100",
    "solve --problem hires --method method-ii --h 0.01 --t-end 1",
    "solve --problem robertson --method method-ii --h 0.1 --t-end 1",
    "solve --problem van-der-pol --method method-ii --h 0.001 --t-end 5",
    "solve --problem van-der-pol --method rk4 --h 1 --t-end 100",
    "solve --model pole.ds --method implicit-euler --h 0.3 --t-end 2",
    "solve --model pole.ds --method radau-adaptive --t-end 2",
    "solve --model log.ds --method implicit-euler --h 0.1 --t-end 1",
    // Orders.
    "order --problem logistic --method rk4 --coarsest 100",
    "order --problem logistic --method radau-adaptive",
    "order --problem hires --method method-ii",
    "order --problem van-der-pol --method rk4 --reference exact",
    "order --model pole.ds --method rk4 --reference diffsol --t-end 2",
    "order --problem logistic --method rk4 --coarsest 1e-9",
    "order --problem logistic --program ./nobody --expect 2",
    "order --problem logistic --program false --expect 2",
    "order --problem logistic --program true --expect 2",
    "order --data grids.csv",
    "order --data nowhere.csv",
    // Files.
    "report --only closed-forms --compare old.json",
    "report --only closed-forms --compare not.json",
    "solve --model two.ds --set c=1 --method rk4 --h 0.1 --t-end 1",
    "judge nowhere.toml",
];

/// Numbers of more digits than roundings leave alone, as dots.
fn rough(text: &str) -> String {
    let is_long = |word: &str| word.chars().filter(char::is_ascii_digit).count() > 8;
    text.split(' ').map(|word| if is_long(word) { "…" } else { word }).collect::<Vec<_>>().join(" ")
}

#[test]
fn refusals_are_told_word_for_word() {
    let directory = scratch("refusals");
    fs::create_dir_all(&directory).expect("writable");
    for (name, text) in FILES {
        fs::write(directory.join(name), text).expect("writable");
    }
    let told: Vec<String> = COMMANDS
        .par_iter()
        .map(|line| {
            let output = Command::new(env!("CARGO_BIN_EXE_verify"))
                .args(line.split_whitespace())
                .current_dir(&directory)
                .env("NO_COLOR", "1")
                .env_remove("COLUMNS")
                .output()
                .expect("the program starts");
            let status = output.status.code().expect("no signal");
            let said = rough(&flat(&String::from_utf8(output.stderr).expect("UTF-8")));
            let mut text = String::new();
            writeln!(text, "{line}\n    {status}: {}", said.replace(" hint: ", "\n    hint: ")).expect("a string");
            text
        })
        .collect();
    insta::assert_snapshot!(told.concat());
}
