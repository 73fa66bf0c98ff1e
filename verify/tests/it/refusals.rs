//! What the program says when it refuses, breaks off or doubts a run, with its hint and its exit status, word for word.

use std::fs;
use std::process::Command;

use rayon::prelude::*;

use crate::{flat, scratch};

/// Files that commands name.
const FILES: [(&str, &str); 7] = [
    ("pole.ds", "u_i { x = 1 } F_i { x * x }"),
    ("log.ds", "u_i { x = 0 } F_i { log(x) }"),
    ("two.ds", "in_i { a = 1, b = 2 } u_i { x = 1, y = 0 } F_i { -a * x, -b * y }"),
    ("columns.ds", "u_i { x = 1, estimate = 2 } F_i { -x, -estimate }"),
    ("old.json", r#"{ "schema": 0 }"#),
    ("not.json", "no report"),
    ("grids.csv", "n,value\n1,2.0\n2,1.5\n4,1.25\n"),
];

const COMMANDS: [&str; 42] = [
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
    "solve --problem logistic --method radau-adaptive --t-end inf",
    "solve --problem logistic --method rk4 --h 0.1 --rtol 1e-3 --t-end 1",
    "solve --problem logistic --method radau-adaptive --rtol 1e-30 --t-end 1",
    "solve --problem logistic --method radau-adaptive --atol -1 --t-end 1",
    "solve --problem logistic --method radau-adaptive --atol 1e-6,1e-6 --t-end 1",
    "solve --problem logistic --method galerkin-gauss(2) --h 0.25 --t-end 1",
    "solve --problem kepler --method bdf9 --h 0.1 --t-end 1",
    "solve --model columns.ds --method rk4 --h 0.5 --t-end 1 --no-estimate",
    // Steps that fail.
    "solve --problem quadratic-drag --method method-ii --h 50 --t-end 100",
    "solve --problem hires --method method-ii --h 0.01 --t-end 1",
    "solve --problem van-der-pol --method method-ii --h 0.001 --t-end 5",
    "solve --problem van-der-pol --method rk4 --h 1 --t-end 100",
    "solve --model pole.ds --method implicit-euler --h 0.3 --t-end 2",
    "solve --model pole.ds --method radau-adaptive --t-end 2",
    "solve --model log.ds --method implicit-euler --h 0.1 --t-end 1",
    // Orders.
    "order --problem logistic --method rk4 --coarsest 100",
    "order --problem logistic --method radau-adaptive",
    "order --problem hires --method method-ii",
    "order --model two.ds --method rk4 --reference exact --t-end 1",
    "order --model pole.ds --method rk4 --reference diffsol --t-end 2",
    "order --problem logistic --method rk4 --coarsest 1e-9",
    "order --problem logistic --program ./nobody --expect 2",
    "order --data grids.csv",
    "order --data nowhere.csv",
    // Files.
    "report --only closed-forms --compare old.json",
    "report --only closed-forms --compare not.json",
    "solve --model two.ds --set c=1 --method rk4 --h 0.1 --t-end 1",
    "judge nowhere.toml",
];

/// Fractions of many digits with two of them, which roundings leave alone.
fn rough(text: &str) -> String {
    let short = |word: &str| {
        let number = word.trim_matches(|c: char| !c.is_ascii_digit() && c != '-');
        let is_long = number.contains('.') && number.chars().filter(char::is_ascii_digit).count() > 4;
        let value = number.parse::<f64>().ok().filter(|_| is_long);
        value.map_or_else(|| word.into(), |x| word.replace(number, &format!("{x:.1e}")))
    };
    text.split(' ').map(short).collect::<Vec<String>>().join(" ")
}

/// Exit status and standard error of commands, run where `files` are, side by side.
fn told(name: &str, files: &[(&str, &str)], commands: &[&str]) -> String {
    let directory = scratch(name);
    fs::create_dir_all(&directory).expect("writable");
    for (name, text) in files {
        fs::write(directory.join(name), text).expect("writable");
    }
    let one = |line: &&str| {
        let output = Command::new(env!("CARGO_BIN_EXE_verify"))
            .args(line.split_whitespace())
            .current_dir(&directory)
            .env("NO_COLOR", "1")
            .env_remove("COLUMNS")
            .output()
            .expect("the program starts");
        let status = output.status.code().expect("no signal");
        let said = rough(&flat(&String::from_utf8(output.stderr).expect("UTF-8")));
        format!(
            "{line}\n    {status}: {}\n",
            said.replace(" hint: ", "\n    hint: ").replace(" warning: ", "\n    warning: ")
        )
    };
    commands.par_iter().map(one).collect::<Vec<_>>().concat()
}

#[test]
fn refusals_are_told_word_for_word() {
    insta::assert_snapshot!(told("refusals", &FILES, &COMMANDS));
}

/// Systems that runs of [`WARNED`] are of.
const MODELS: [(&str, &str); 21] = [
    ("log.ds", "u_i { x = 0 } F_i { log(x) }"),
    ("coil.ds", "u_i { charge = 1e-9, current = 0 } F_i { current, -5e6*current - 1e15*charge }"),
    ("tank.ds", "u_i { level = 1 } F_i { -0.5*sqrt(level) }"),
    ("pole.ds", "u_i { x = 0.1 } F_i { exp(x) }"),
    ("robertson.ds", "u_i { a = 1, b = 0, c = 0 } F_i { -0.04*a + 1e4*b*c, 0.04*a - 1e4*b*c - 3e7*b*b, 3e7*b*b }"),
    ("prey.ds", "u_i { x = 40, y = 9 } F_i { x*(5-0.4*y), y*(0.5*x-0.8) }"),
    ("saddle.ds", "u_i { x = 1, y = 1e-3 } F_i { -x, y }"),
    ("ridge.ds", "u_i { x = 0, y = 1 } F_i { x - x*x*x, -y }"),
    ("near.ds", "u_i { x = 1e-9, y = 1 } F_i { 3*x - x*x*x, 0 }"),
    ("shear.ds", "u_i { x = 1, y = 1 } F_i { -x + 60*y, -2*y }"),
    ("spiral.ds", "u_i { x = 1, y = 0, z = 1 } F_i { -0.1*x + 6*y, -6*x - 0.1*y, -z }"),
    (
        "spirals.ds",
        "u_i { x = 1, y = 0, z = 1, w = 0 } F_i { -0.1*x + 6*y + 40*z, -6*x - 0.1*y, -0.1*z + 6*w, -6*z - 0.1*w }",
    ),
    // Steps of two periods of a force whose integral over each is 0.
    ("beat.ds", "u_i { x = 1 } F_i { -x + 20*sin(628.3185307179587*t) }"),
    ("wave.ds", "u_i { x = 1, y = 0 } F_i { y, -x }"),
    ("sir.ds", "u_i { s = 0.9, i = 0.1, r = 0 } F_i { -3*s*i, 3*s*i - i, i }"),
    ("small.ds", "u_i { x = 5e-10, y = 8e-10 } F_i { -x, -y }"),
    ("logistic.ds", "u_i { x = 0.1 } F_i { x*(1-x) }"),
    (
        "season.ds",
        "u_i { s = 1e6, e = 0, i = 10, r = 0 } beta { 0.05 + 1.6*exp(-(t - 60)*(t - 60)/200) }
         F_i { -beta*s*i/1e6, beta*s*i/1e6 - 0.5*e, 0.5*e - 0.25*i, 0.25*i }",
    ),
    ("mathieu.ds", "u_i { x = 0.001, v = 0 } F_i { v, -(1 + 0.4*cos(2*t))*x - 0.02*v - x*x*x }"),
    ("phase.ds", "u_i { x = 0, phase = 0 } F_i { -x + 10*cos(phase)*cos(phase), 62.83185307179586 }"),
    (
        "nerve.ds",
        "u_i { v = -1.19941, w = -0.62426 } I { 2*heaviside(t - 20.05)*heaviside(20.55 - t) }
         F_i { v - v*v*v/3 - w + I, 0.08*(v + 0.7 - 0.8*w) }",
    ),
];

const WARNED: [&str; 55] = [
    "solve --model log.ds --method rk4 --h 1e-7 --t-end 1",
    "solve --model log.ds --method rk4 --h 1e-8 --t-end 1",
    "solve --model saddle.ds --method radau-adaptive --t-end 0.5 --atol 10,2",
    "solve --model coil.ds --method method-i --h 1e-9 --t-end 1e-7",
    "solve --model tank.ds --method radau-adaptive --t-end 6",
    "solve --model pole.ds --method rk4 --h 0.1 --t-end 3",
    "solve --model pole.ds --method rk4 --h 0.05 --t-end 0.5",
    "solve --model robertson.ds --method trapezoidal --h 100 --t-end 1e4",
    "solve --model robertson.ds --method radau-adaptive --t-end 1e4",
    "solve --model robertson.ds --method method-i --h 0.1 --t-end 1",
    "solve --model robertson.ds --method method-ii --h 0.1 --t-end 1",
    "solve --model prey.ds --method radau-adaptive --t-end 8 --rtol 1e-7 --atol 1e-7",
    "solve --model prey.ds --method radau-adaptive --t-end 8 --atol 1e-13",
    "solve --model saddle.ds --method trapezoidal --h 1 --t-end 10",
    "solve --model saddle.ds --method implicit-euler --h 3 --t-end 12",
    "solve --model saddle.ds --method implicit-euler --h 30 --t-end 120",
    "solve --model saddle.ds --method method-i --h 3 --t-end 12",
    "solve --model ridge.ds --method implicit-euler --h 0.5 --t-end 20",
    "solve --model ridge.ds --method implicit-euler --h 5 --t-end 400",
    "solve --model ridge.ds --method trapezoidal --h 5 --t-end 400",
    "solve --model near.ds --method implicit-euler --h 0.1 --t-end 0.5",
    "solve --model near.ds --method implicit-euler --h 2 --t-end 20",
    "solve --model near.ds --method radau-adaptive --t-end 4",
    "solve --model near.ds --method radau-adaptive --t-end 4 --atol 1e-2",
    "solve --model shear.ds --method method-i --h 0.5 --t-end 1",
    "solve --model shear.ds --method method-i --h 0.1 --t-end 1",
    "solve --model shear.ds --method implicit-euler --h 0.5 --t-end 1",
    "solve --model shear.ds --method trapezoidal --h 2 --t-end 8",
    "solve --model shear.ds --method rk4 --h 2 --t-end 8",
    "solve --model spiral.ds --method method-i --h 0.1 --t-end 1",
    "solve --model spiral.ds --method rk4 --h 0.5 --t-end 5",
    "solve --model spiral.ds --method heun2 --h 0.1 --t-end 1",
    "solve --model spirals.ds --method method-i --h 0.1 --t-end 1",
    "solve --model spirals.ds --method method-i --h 0.5 --t-end 2",
    "solve --model wave.ds --method rk4 --h 0.3 --t-end 20",
    "solve --model wave.ds --method heun2 --h 0.3 --t-end 20",
    "solve --model sir.ds --method method-i --h 0.2 --t-end 2",
    "solve --model sir.ds --method method-ii --h 0.2 --t-end 2",
    "solve --model sir.ds --method trapezoidal --h 0.2 --t-end 2",
    "solve --model small.ds --method radau-adaptive --t-end 1",
    "solve --model small.ds --method radau-adaptive --t-end 1 --atol 1e-9,7e-10",
    "solve --model small.ds --method radau-adaptive --t-end 1 --atol 1e-12",
    "solve --model logistic.ds --method implicit-euler --h 3 --t-end 30",
    "solve --model logistic.ds --method method-i --h 3 --t-end 30",
    "solve --model season.ds --method method-i --h 2 --t-end 150",
    "solve --model season.ds --method tr-bdf2 --h 2 --t-end 150",
    "solve --model mathieu.ds --method implicit-euler --h 5 --t-end 100",
    "solve --model mathieu.ds --method rk4 --h 0.1 --t-end 100",
    "solve --model phase.ds --method trapezoidal --h 0.1 --t-end 5",
    "solve --model phase.ds --method rk4 --h 0.01 --t-end 5",
    "solve --model nerve.ds --method tr-bdf2 --h 0.16 --t-end 80",
    "solve --model beat.ds --method rk4 --h 0.02 --t-end 10",
    "solve --model beat.ds --method rk4 --h 0.0005 --t-end 1",
    "solve --problem hires --method method-i --h 2 --t-end 20",
    "solve --problem quadratic-drag --method method-i --h 2 --t-end 20",
];

#[test]
fn warnings_are_told_word_for_word() {
    insta::assert_snapshot!(told("warnings", &MODELS, &WARNED));
}
