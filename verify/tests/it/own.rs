//! Methods, programs and data of the reader's own, as a stranger hands them to the command.

use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::thread;

use rayon::prelude::*;
use verify::judge::file::SHIPPED;

use crate::{fits_a_terminal, flat, scratch, written};

const METHODS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/methods");

fn verify(arguments: &[&str]) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_verify"));
    let output = command.args(arguments).env("NO_COLOR", "1").env_remove("COLUMNS").output().expect("it starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr))
}

/// The words of `line` as arguments.
fn say(line: &str) -> (i32, String, String) {
    verify(&line.split_whitespace().collect::<Vec<_>>())
}

fn directory(name: &str) -> PathBuf {
    let path = scratch(&format!("own/{name}"));
    fs::create_dir_all(&path).expect("writable");
    path
}

/// The table of Celik et al. that is shipped has the order, the limit and the indices of theirs: 1.53, 6.1685 and 2.2 %.
#[test]
fn the_shipped_table_of_a_flow_has_its_published_order() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/data/reattachment.csv");
    let (code, out, _) = say(&format!("order --data {path} --cells cells --dimension 2"));
    let out = flat(&out);
    for words in ["order 1.5340 ± 0.058 (three grids", "extrapolated 6.1684956", "GCI, fine 2.17499 % of the value"] {
        assert!(code == 3 && out.contains(words), "{words}: {code} {out}");
    }
}

#[test]
fn a_file_that_is_no_method_is_refused_at_its_place_with_a_hint() {
    let dir = directory("files");
    let method = |a: &str| format!("c = [0, 1]\na = [[], [{a}]]\nb = [\"1/2\", \"1/2\"]\n").into_bytes();
    let deep = format!("\"{}1{}\"", "(".repeat(50_000), ")".repeat(50_000));
    let long = format!("\"{}\"", vec!["1"; 20_000].join("+"));
    let binary = [&b"c = [0, 1]\na = [["[..], &[0, 0xff, 0xfe, 1]].concat();
    let cases: [(&str, Vec<u8>, &str, &str); 10] = [
        ("empty", Vec::new(), ":1:1:", "the file is empty"),
        ("blank", b"\n \r\n".to_vec(), ":1:1:", "the file is empty"),
        ("binary", binary, ":2:8:", "no text in UTF-8"),
        ("zero", method("\"1/(sqrt(4) - 2)\""), ":2:14:", "division by zero"),
        ("not-a-number", method("nan"), ":2:11:", "`nan` is not known"),
        ("deep", method(&deep), ":2:", "nested too deeply"),
        ("long", method(&long), ":2:", "in `…"),
        ("shape", method("1, 2, 3"), ":2:10:", "row 2 of `a` has 3 entries"),
        ("letter", b"A = [[], [1]]\nb = [\"1/2\", \"1/2\"]\n".to_vec(), ":1:1:", "the key `A` is not known"),
        ("key", [b"fo = 1\n".to_vec(), method("1")].concat(), ":1:1:", "unknown key `fo`"),
    ];
    for (name, bytes, place, reason) in cases {
        let path = dir.join(format!("{name}.toml"));
        fs::write(&path, bytes).expect("writable");
        let (code, out, error) = verify(&["judge", &path.display().to_string(), "--no-runs"]);
        assert!(code == 2 && out.is_empty(), "{name}: {out}");
        assert!(
            flat(&error).contains(place) && flat(&error).contains(reason) && flat(&error).contains("hint: "),
            "{name}: {error}"
        );
        assert!(error.len() < 600, "{name}: {} bytes", error.len());
    }
    let (code, _, error) = say(&format!("judge {}", dir.display()));
    assert!(code == 2 && flat(&error).contains("cannot read"), "{error}");
    // A device without an end is not read to its end.
    #[cfg(target_os = "linux")]
    for line in ["judge /dev/zero", "order --data /dev/zero --step h"] {
        let (code, _, error) = say(line);
        assert!(code == 2 && flat(&error).contains("more than"), "{error}");
    }
}

#[test]
fn marks_of_byte_order_and_line_ends_of_other_systems_are_no_coefficients() {
    let dir = directory("line-ends");
    let toml = "c = [0, 1]\na = [[], [1]]\nb = [\"1/2\", \"1/2\"]\n";
    for (name, text) in [("toml", toml), ("txt", "0 1\n1/2 1/2\n1\n")] {
        let path = dir.join(format!("heun.{name}"));
        let judged = |text: String| {
            fs::write(&path, text).expect("writable");
            say(&format!("judge {} --no-runs", path.display()))
        };
        let plain = judged(text.to_owned());
        assert!(plain.0 == 0 && flat(&plain.1).contains("order 2;"), "{}", plain.1);
        assert_eq!(judged(format!("\u{feff}{}", text.replace('\n', "\r\n"))), plain, "{name}");
    }
}

/// A wrong coefficient lowers the order that theory has for the runs, and they must not pass by that.
#[test]
fn a_method_file_is_held_to_the_order_that_it_claims() {
    let path = format!("{METHODS}/misprints/rk4-a44.toml");
    let (code, out, _) = say(&format!("order --problem logistic --method {path}"));
    assert!(code == 1 && out.contains("is not 4 ± 0.1"), "{out}");
    assert!(flat(&out).contains("the file claims order 4") && flat(&out).contains("have order 1"), "{out}");
    let (code, out, _) = say(&format!("order --problem logistic --method {path} --expect 1"));
    assert!(code == 0 && flat(&out).contains("the file claims order 4"), "{out}");
    let (code, out, _) = say(&format!("order --problem logistic --method {METHODS}/rk4.toml"));
    assert!(code == 0 && !out.contains("Note"), "{out}");
    let solve = "solve --problem logistic --h 0.1 --t-end 1 --method";
    for line in ["compare --problem logistic --method", solve] {
        let (_, _, warning) = say(&format!("{line} {path}"));
        let is_told = flat(&warning).contains("claims order 4, and its coefficients have order 1");
        assert!(is_told, "{line}: {warning}");
        let (_, _, warning) = say(&format!("{line} {METHODS}/rk4.toml"));
        assert!(!warning.contains("warning"), "{line}: {warning}");
    }
    // Beside rows it is said on both streams.
    let is_told =
        |line: &str| line.starts_with("# ") && line.contains("claims order 4, and its coefficients have order 1");
    for (path, is_wrong) in [(path, true), (format!("{METHODS}/rk4.toml"), false)] {
        let (_, rows, warning) = say(&format!("{solve} {path} --csv -"));
        assert_eq!(flat(&warning).contains("claims order 4, and its"), is_wrong, "{warning}");
        assert_eq!(rows.lines().any(is_told), is_wrong, "{rows}");
    }
}

/// Adams–Moulton of order 5, of which a start of order 1 leaves 2.
#[test]
fn a_start_that_lowers_the_order_is_blamed_and_not_the_coefficients() {
    let path = directory("start").join("am5.toml");
    let text = "kind = \"multistep\"\norder = 5\nrho = [0, 0, 0, -1, 1]\nstart = \"implicit-euler\"\n\
                sigma = [\"-19/720\", \"106/720\", \"-264/720\", \"646/720\", \"251/720\"]\n";
    fs::write(&path, text).expect("writable");
    let (code, out, _) = say(&format!("order --problem logistic --method {}", path.display()));
    let out = flat(&out);
    let blame =
        "its coefficients have order 5, but its start implicit-euler has order 1, where 4 is needed, so that order 2";
    assert!(code == 1 && out.contains(blame), "{out}");
}

/// Every command that takes the name of a method takes a file of every kind.
#[test]
fn files_of_every_kind_go_where_names_go() {
    for (name, problem) in [
        ("radau-iia3", "logistic"),
        ("stormer-verlet", "pendulum"),
        ("nystrom4", "pendulum"),
        ("bdf3", "logistic"),
        ("fitted-pade", "damped-pendulum"),
        ("path-fitted3-gauss", "pendulum"),
        ("galerkin-gauss2", "pendulum"),
    ] {
        let path = format!("{METHODS}/{name}.toml");
        let (code, out, error) = say(&format!("solve --problem {problem} --method {path} --h 0.1 --t-end 1"));
        assert!(code == 0 && out.contains("10 steps"), "{name}: {error}");
        let (code, out, error) = say(&format!("order --problem {problem} --method {path}"));
        assert!(code == 0 && out.contains("PASS"), "{name}: {out}{error}");
        let (code, out, error) = say(&format!("compare --problem {problem} --method {path}"));
        assert!(code == 0 && out.contains("0 do not"), "{name}: {out}{error}");
    }
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/models/van-der-pol.ds");
    let (code, out, error) = say(&format!("order --model {model} --set mu=2 --t-end 2 --method {METHODS}/sdirk2.toml"));
    assert!(code == 0 && out.contains("is 2 ±"), "{out}{error}");
    // The same by the program that this is.
    let own = format!("{} solve --method {METHODS}/gauss2.toml --csv -", env!("CARGO_BIN_EXE_verify"));
    let (code, out, error) = verify(&["order", "--problem", "logistic", "--program", &own, "--expect", "4"]);
    assert!(code == 0, "{out}{error}");
    let (code, _, error) = say(&format!("solve --problem logistic --method {METHODS}/nystrom4.toml --h 0.1 --t-end 1"));
    assert!(code == 2 && flat(&error).contains("two halves"), "{error}");
}

/// A step of a file and of the method that a name stands for, to the roundings of a dozen stages; the digits of a file count for as
/// many.
#[test]
fn a_file_makes_the_step_of_the_method_that_the_library_has() {
    let closures = ["method-i", "method-ii", "fitted-exponential", "fitted-pade"];
    let names = ["method-i", "method-ii", "fitted(4)", "fitted-pade(4)"];
    let field = [
        ("rk4", "rk4"),
        ("implicit-euler", "implicit-euler"),
        ("sdirk2", "sdirk2"),
        ("tr-bdf2", "tr-bdf2"),
        ("gauss2", "ls-galerkin(2,gauss,2)"),
        ("radau-iia2", "ls-galerkin(2,radau,2)"),
    ];
    let mechanics = [
        ("stormer-verlet", "stormer-verlet"),
        ("blanes-moan", "blanes-moan"),
        ("galerkin-gauss2", "galerkin-gauss(2)"),
        ("path-fitted3", "path-fitted(3)"),
        ("path-fitted3-gauss", "path-fitted(3,gauss)"),
    ];
    let closures = closures.into_iter().zip(names).map(|pair| ("damped-pendulum", pair));
    let field = field.map(|pair| ("van-der-pol", pair));
    let mechanics = mechanics.map(|pair| ("henon-heiles", pair));
    for (problem, (file, name)) in closures.chain(field).chain(mechanics) {
        let step = |method: &str| {
            let line = format!("solve --problem {problem} --h 0.5 --t-end 0.5 --no-estimate --csv - --method {method}");
            let (code, out, error) = say(&line);
            assert_eq!(code, 0, "{line}: {error}");
            let row = out.lines().last().unwrap_or_default().to_owned();
            row.split(',').map(|cell| cell.parse::<f64>().expect("a number")).collect::<Vec<_>>()
        };
        let [ours, theirs] = [step(name), step(&format!("{METHODS}/{file}.toml"))];
        let apart = ours.iter().zip(&theirs).map(|(a, b)| (a - b).abs() / a.abs().max(1.0));
        let apart: Vec<f64> = apart.collect();
        assert!(ours.len() == theirs.len() && ours.len() > 2, "{file}: {ours:?}, {theirs:?}");
        assert!(apart.iter().all(|d| *d <= 16.0 * f64::EPSILON), "{file}: {apart:?}");
    }
}

#[test]
fn long_names_leave_the_table_of_a_comparison_as_wide_as_a_terminal() {
    let own = format!("{} solve --method rk4 --csv -", env!("CARGO_BIN_EXE_verify"));
    let long = format!("{METHODS}/galerkin-gauss2.toml");
    let (code, out, _) =
        verify(&["compare", "--problem", "pendulum", "--program", &own, "--expect", "4", "--method", &long]);
    assert_eq!(code, 0, "{out}");
    // A path is no longer than it is.
    fits_a_terminal(&out);
    let row = |start: &str| out.lines().find(|line| line.contains(start)).unwrap_or_default().to_owned();
    assert!(row("[1]").contains("agrees") && flat(&out).contains(&format!("[2] {own}")), "{out}");
}

/// One that keeps what it is asked, and answers nothing.
#[test]
fn a_program_is_asked_for_the_end_that_is_set() {
    let dir = directory("asked");
    let (script, kept) = (dir.join("keep.sh"), dir.join("kept"));
    if kept.exists() {
        fs::remove_file(&kept).expect("it can be removed");
    }
    fs::write(&script, format!("echo \"$@\" >>'{}'\nexit 1\n", kept.display())).expect("writable");
    let program = format!("sh '{}'", script.display());
    let (code, out, error) =
        verify(&["judge", "--program", &program, "--expect", "4", "--problem", "logistic", "--t-end", "0.5"]);
    assert!(code != 0, "{out}{error}");
    let asked = fs::read_to_string(&kept).expect("it was asked");
    fs::remove_file(&kept).expect("it is there");
    assert!(asked.lines().all(|line| line.contains("--problem logistic") && line.contains("--t-end 0.5")), "{asked}");
}

/// A program that knows one's own system, by the name of its file, with its inputs and end time.
#[test]
fn a_program_is_judged_on_a_model() {
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/models/van-der-pol.ds");
    // `solve` knows it by its file, and asked for the name it takes the problem that is called the same.
    let own = format!("{} solve --method rk4 --no-estimate --csv -", env!("CARGO_BIN_EXE_verify"));
    let judge = |order: &str, more: &[&str]| {
        verify(&[&["judge", "--program", &own, "--expect", order, "--model", model][..], more].concat())
    };
    let (code, out, error) = judge("4", &["--set", "mu=0.5", "--t-end", "2"]);
    assert!(code == 0 && out.contains("van-der-pol: order"), "{out}{error}");
    assert_eq!(judge("3", &["--set", "mu=0.5", "--t-end", "2"]).0, 1);
    // An end that is none.
    let (code, out, _) = judge("4", &["--set", "mu=0.5", "--t-end", "-1"]);
    assert!(code == 2, "{out}");
    let (code, _, error) = say("judge rk4 --model x.ds");
    assert!(code == 2 && flat(&error).contains("--program"), "{error}");
}

#[test]
fn a_file_may_name_a_coefficient_in_words() {
    let path = directory("words").join("named.toml");
    let text =
        "name = \"Heun, a[2,1] as printed\"\na = [[], [1]]\nb = [\"1/2\", \"1/2\"]\nclaims = [\"not symplectic\"]\n";
    fs::write(&path, text).expect("writable");
    let (code, out, error) = say(&format!("judge {}", path.display()));
    assert!(code == 0 && out.contains("Heun, a[2,1] as printed"), "{out}{error}");
    // What is confirmed is the claim, and not its opposite.
    assert!(out.contains("confirmed    not symplectic: a step") && !out.contains("confirmed    symplectic"), "{out}");
}

#[test]
fn published_decimals_are_held_to_their_own_last_places() {
    let path = directory("decimals").join("alexander.toml");
    // SDIRK of order 3 as printed: places differ from coefficient to coefficient.
    let text = "order = 3\na = [[0.4358665215], [0.28206673925, 0.4358665215], [1.208496649, -0.644363171, 0.4358665215]]\n\
                b = [1.208496649, -0.644363171, 0.4358665215]\nc = [0.4358665215, 0.71793326075, 1]\n";
    fs::write(&path, text).expect("writable");
    let (code, out, _) = say(&format!("judge {} --no-runs", path.display()));
    assert!(code == 0 && out.contains("confirmed    order 3"), "{out}");
    // A digit that is not that of rounding is still found.
    fs::write(&path, text.replace("1.208496649,", "1.208496549,")).expect("writable");
    let (code, out, _) = say(&format!("judge {} --no-runs", path.display()));
    assert!(code == 1 && out.contains("REFUTED      order 3"), "{out}");
}

/// A wrong sign in Adams' and Bashforth's method of three steps: σ(1) is not ρ'(1), whatever the roots.
#[test]
fn a_method_that_is_not_consistent_does_not_converge() {
    let path = directory("inconsistent").join("ab3.toml");
    let text = "kind = \"multistep\"\nrho = [0, 0, -1, 1]\nsigma = [\"5/12\", \"16/12\", \"23/12\", 0]\n";
    fs::write(&path, text).expect("writable");
    let (code, out, _) = say(&format!("judge {} --no-runs", path.display()));
    assert!(code == 1 && flat(&out).contains("REFUTED convergence:") && flat(&out).contains("not consistent"), "{out}");
}

/// RK4 that prints six decimals, and what its verdict rests on.
#[test]
fn few_printed_digits_decide_nothing_and_are_named() {
    let script = directory("few").join("few.sh");
    let own = env!("CARGO_BIN_EXE_verify");
    let text = format!(
        "\"{own}\" solve --method rk4 --csv - \"$@\" | awk -F, '/^#/ {{ next }} /^t/ {{ print; next }} \
         {{ for (i = 1; i <= NF; i++) $i = $i == \"\" ? \"\" : sprintf(\"%.6f\", $i); print }}' OFS=,\n"
    );
    fs::write(&script, text).expect("writable");
    let program = format!("sh {}", script.display());
    let order = ["order", "--problem", "damped-pendulum", "--expect", "4", "--program", &program];
    let (code, out, error) = verify(&order);
    assert!(code == 3, "{out}{error}");
    // Beside the other solvers its last digit is part of its bound.
    let compare = ["compare", "--problem", "damped-pendulum", "--expect", "4", "--program", &program];
    let (code, text, _) = verify(&compare);
    assert!(code == 0 && text.contains(" 0 do not"), "{text}");
    assert!(
        flat(&format!("{out}{error}")).contains("significant digits, below which errors are not seen"),
        "{out}{error}"
    );
}

#[test]
fn that_stage_times_are_not_seen_is_said_where_no_equation_depends_on_time() {
    let program = format!("{} solve --method rk4 --no-estimate --csv -", env!("CARGO_BIN_EXE_verify"));
    let (_, _, error) = verify(&["judge", "--expect", "4", "--problem", "logistic", "--program", &program]);
    assert!(flat(&error).contains("wrong stage times are"), "{error}");
    let depends = ["logistic", "channel-womersley"]
        .map(|name| verify::order::depends_on_time(&*verify::problem::build(name, &[]).expect("a problem")));
    assert_eq!(depends, [false, true]);
}

#[test]
fn what_is_not_zero_stable_is_not_run() {
    let (code, out, _) = say("judge bdf7");
    let out = flat(&out);
    assert!(code == 1 && out.contains("work not run: it is not zero-stable"), "{out}");
}

/// Values, fit, limit and the order as found and as expected; and errors of a method.
#[test]
fn a_study_is_drawn() {
    let dir = directory("pictures");
    let path = |name: &str| dir.join(name).display().to_string();
    fs::write(path("nparc.csv"), "h,recovery\n1,0.97050\n2,0.96854\n4,0.96178\n").expect("writable");
    let draw = |line: &str, name: &str| {
        let (code, out, error) = say(&format!("{line} --picture {}", path(name)));
        (code, fs::read_to_string(path(name)).unwrap_or_default(), format!("{out}{error}"))
    };
    let (code, svg, _) = draw(&format!("order --data {} --step h --expect 2", path("nparc.csv")), "nparc.svg");
    assert_eq!(code, 0);
    for part in ["xmlns=", "recovery", "p = 1.786", "limit φ₀", "± its GCI", "order 2.00, as expected"] {
        assert!(svg.contains(part), "{part}: {svg}");
    }
    let (code, svg, _) = draw("order --problem logistic --method rk4", "rk4.svg");
    assert!(code == 0 && svg.contains("rk4 on logistic") && svg.contains("expected order 4"), "{svg}");
    // What has no order is drawn without one, what has no point is not drawn, and no file appears.
    fs::write(path("rough.csv"), "h,u\n1,1.0\n2,1.4\n4,1.1\n").expect("writable");
    let (code, svg, _) = draw(&format!("order --data {} --step h", path("rough.csv")), "rough.svg");
    assert!(code == 3 && svg.contains("values") && !svg.contains("limit"), "{svg}");
    fs::write(path("none.csv"), "h,u\n1,nan\n2,nan\n4,nan\n").expect("writable");
    let (code, svg, said) = draw(&format!("order --data {} --step h", path("none.csv")), "none.svg");
    assert!(code == 2 && svg.is_empty() && said.contains("a point to draw"), "{said}");
    let (code, _, error) = say("order --problem logistic --method rk4 --picture /no/such/place.svg");
    assert!(code == 2 && flat(&error).contains("cannot write /no/such/place.svg"), "{error}");
}

/// Runs that end at different times pass for whatever order the differences of their ends have.
#[test]
fn values_of_different_times_decide_nothing() {
    let script = directory("late").join("late.awk");
    let text = "BEGIN { for (i = 1; i < ARGC; i++) if (ARGV[i] == \"--h\") h = ARGV[i + 1]
        print \"t,v\"; for (t = 0; t < 1 - 1e-9; t += h) printf \"%.17g,%.17g\\n\", t, exp(-t)
        printf \"%.17g,%.17g\\n\", 1 + h / 3, exp(-1 - h / 3) }";
    fs::write(&script, text).expect("writable");
    if !Command::new("awk").args(["BEGIN { exit 0 }"]).status().is_ok_and(|status| status.success()) {
        return;
    }
    let program = format!("awk -f {} --", script.display());
    let order = ["order", "--program", &program, "--quantity", "v", "--h", "0.1,0.05,0.025,0.0125", "--expect", "1"];
    let (code, out, error) = verify(&order);
    assert!(code == 3 && flat(&out).contains("their values belong to different times"), "{out}{error}");
}

/// An answer in words for whatever a table holds, and never a pass.
#[test]
fn data_that_decide_nothing_say_why() {
    let dir = directory("data");
    let path = dir.join("study.csv");
    let order = |text: &str, more: &str| {
        fs::write(&path, text).expect("writable");
        let (code, out, error) = say(&format!("order --data {} --step h {more}", path.display()));
        fits_a_terminal(&out);
        (code, flat(&out), error)
    };
    for (text, more, reason) in [
        ("h,u\n4,1.5\n2,nan\n1,1.1\n", "--expect 2", "spacing 2 is missing or not a number"),
        ("h,u\n4,1.5\n2,\n1,1.1\n", "--expect 2", "spacing 2 is missing or not a number"),
        ("h,u\n4,1.5\n2,NA\n1,1.1\n", "--expect 2", "not a number; without its row the others may decide"),
        ("h,u\n4,1.5\n2,n/a\n1,1.1\n", "--expect 2", "spacing 2 is missing or not a number"),
        ("h,u\n4,1.5\n2,inf\n1,1.1\n", "--expect 2", "spacing 2 is missing or not a number"),
        ("h,u\n4,1.50\n2,1.50\n1,1.50\n", "--expect 2", "exact or converged to all digits"),
        ("h,u\n4,1.50\n2,1.20\n2,1.21\n1,1.10\n", "--expect 2", "the same spacing 2"),
        ("h,u\n4,1.5\n2,1.2\n", "--expect 2", "two grids determine no order"),
        ("h,u\n4,1.5\n", "--expect 2", "one grid determines no order"),
        ("h,u\n4,1.0400\n2,1.0200\n1,1.0100\n", "--expect 2", "do not tell a wrong order"),
        ("h,u\n4,1.0001\n2,1.0000\n1,1.0000\n", "--expect 2", "have the same value"),
        ("h,u\n8,1.0\n4,1.0\n2,1.0\n1,1.0\n", "--expect 2 --exact 1", "every value is the exact one"),
        (
            "h,u\n8,1.0000000000000004\n4,1.0000000000000002\n2,1.0000000000000000\n1,1.0000000000000002\n",
            "--expect 2 --exact 1",
            "which is not exactness",
        ),
    ] {
        let (code, out, error) = order(text, more);
        assert!(code == 3 && out.contains("INCONCLUSIVE") && out.contains(reason), "{text}: {out}{error}");
        assert!(!out.contains("NaN") && !out.contains("inf "), "{out}");
    }
    for (text, reason) in [
        ("", "no header"),
        ("h\tu\n1\tx\n", "line 2, column `u`"),
        ("h;u\n0,1;1\n", "decimals have a point"),
        ("x u\n1 2\n", "commas, semicolons or tabs separate columns"),
    ] {
        let (code, out, error) = order(text, "");
        assert!(code == 2 && out.is_empty() && flat(&error).contains(reason), "{text}: {error}");
    }
    // A column of errors is recognised by its limit, or by its name.
    for (text, is_named) in [
        ("h,l2\n8,0.064000\n4,0.016000\n2,0.004000\n1,0.001000\n", true),
        ("h,error\n8,1.064\n4,1.016\n2,1.004\n1,1.001\n", true),
        ("h,drag\n8,1.064\n4,1.016\n2,1.004\n1,1.001\n", false),
    ] {
        let (_, out, _) = order(text, "");
        assert_eq!(out.contains("`--exact 0` fits them"), is_named, "{out}");
        assert!(!order(text, "--exact 0").1.contains("fits them"));
    }
    assert!(order("h,u\n1,2.5\n", "").1.contains("u, 1 grid h"));
    assert!(!order("h,u\n8,1.64\n4,1.16\n2,1.04\n1,1.01\n", "").1.contains("± 0 "));
    // An order of about zero is written without a sign.
    let (_, out, _) = order("h,u\n8,2.1\n4,2.1001\n2,2.1002\n1,2.1003\n", "--expect 1 --exact 1");
    assert!(!out.contains("-0.000"), "{out}");
    let (code, _, error) = say(&format!("order --data {} --step h", dir.display()));
    assert!(code == 2 && flat(&error).contains("directory") && !flat(&error).contains("comma"), "{error}");
}

/// Nothing passes of which nothing is claimed: a program, and data.
#[test]
fn what_is_measured_without_an_expectation_is_called_measured() {
    let dir = directory("measured");
    let path = dir.join("law.csv");
    let rows: String = [8.0, 4.0, 2.0, 1.0].map(|h: f64| format!("{h},{:.9}\n", 3.0 + 0.01 * h * h)).concat();
    fs::write(&path, format!("h,u\n{rows}")).expect("writable");
    let data = format!("order --data {} --step h", path.display());
    let own = format!("{} solve --method rk4 --no-estimate --csv -", env!("CARGO_BIN_EXE_verify"));
    let program = ["order", "--problem", "logistic", "--program", &own];
    let words: Vec<&str> = data.split(' ').collect();
    for (line, order) in [(&words[..], "2"), (&[&words[..], &["--exact", "3"]].concat(), "2"), (&program[..], "4")] {
        for (more, status, text, json) in [
            (&[][..], 0, "MEASURED: ", "measured"),
            (&["--expect", order], 0, "PASS: ", "pass"),
            (&["--expect", "3"], 1, "FAIL: ", "fail"),
        ] {
            let (code, out, error) = verify(&[line, more].concat());
            assert!(code == status && out.contains(&format!("\n{text}order ")), "{line:?} {more:?}: {out}{error}");
            assert_eq!(out.contains("no order was expected"), more.is_empty(), "{out}");
            let (code, out, _) = verify(&[line, more, &["--format", "json"]].concat());
            let found: serde_json::Value = serde_json::from_str(&out).expect("JSON");
            assert_eq!((code, found["verdict"].as_str()), (status, Some(json)), "{out}");
            assert!(!line.contains(&"--program") || found["expected"].is_null() == more.is_empty(), "{out}");
        }
    }
}

/// What a program has to write is shown with the error, and said once.
#[test]
fn a_wrong_header_stops_at_the_first_run_and_shows_the_right_one() {
    let runs = directory("header").join("runs");
    let program = format!("sh -c 'echo run >> {}; echo time,q; echo 0,1' -", runs.display());
    for command in [&["order"][..], &["judge", "--expect", "2"], &["compare"]] {
        let _ = fs::remove_file(&runs);
        let (code, out, error) = verify(&[command, &["--problem", "pendulum", "--program", &program]].concat());
        assert!(code == 2 && out.is_empty(), "{command:?}: {code} {out}");
        let expected = "no column `t`: the first line is `time,q`, where `t,q,p` is expected";
        assert!(flat(&error).contains("the program on pendulum") && flat(&error).contains(expected), "{error}");
        assert!(flat(&error).contains("hint: the header has `t` and the columns"), "{error}");
        assert_eq!(fs::read_to_string(&runs).expect("it ran").lines().count(), 1, "{command:?}");
    }
    let line = ["order", "--program", &program, "--quantity", "q", "--h", "0.1,0.05,0.025"];
    let (code, _, error) = verify(&line);
    assert!(code == 2 && flat(&error).contains("where `t,q` is expected"), "{error}");
    for help in ["order --help", "judge --help", "compare --help", "list problems"] {
        assert!(flat(&say(help).1).contains("header"), "{help}");
    }
    assert!(say("list problems").1.contains("header t,q,p"));
}

/// A program that ends after every limit.
const LATE: &str = "sh -c 'sleep 300'";

/// 0 holds, 1 is refuted, 2 is bad input, 3 is inconclusive: by every command that runs a program.
#[test]
fn a_program_that_does_not_start_is_bad_input_and_one_that_fails_is_inconclusive() {
    let own = format!("{} solve --method rk4 --no-estimate --csv -", env!("CARGO_BIN_EXE_verify"));
    let wrong = format!("{own} --set lambda=1.01");
    let order = ["order", "--problem", "logistic", "--expect", "4"];
    let judge = ["judge", "--problem", "logistic", "--expect", "4"];
    let compare = ["compare", "--problem", "logistic", "--expect", "4"];
    let refined = [
        "order",
        "--problem",
        "logistic",
        "--expect",
        "4",
        "--quantity",
        "v",
        "--t-end",
        "2",
        "--h",
        "0.2,0.1,0.05,0.025",
    ];
    let lines = [(&order[..], [0, 1]), (&judge, [0, 1]), (&compare, [0, 1]), (&refined, [0, 0])];
    // Side by side, because one of the programs is waited for.
    let judged = |line: &[&str], statuses: [i32; 2]| {
        for (program, status) in [
            (own.as_str(), statuses[0]),
            (&wrong, statuses[1]),
            ("/no/such/program", 2),
            ("false", 3),
            ("sh -c 'echo sh: no such thing as one that there would be >&2; exit 1'", 3),
            ("sh -c 'echo t,v; echo 0,junk'", 3),
            (LATE, 3),
        ] {
            // The others have all the time that they need, however busy the machine.
            let limit: &[&str] = if program == LATE { &["--time-limit", "1"] } else { &[] };
            let (code, out, error) = verify(&[line, &["--program", program], limit].concat());
            assert_eq!(code, status, "{line:?} {program}: {out}{error}");
            // In a table the reason is told once, and again below it.
            assert!(flat(&out).matches("sh: no such").count() <= 3, "{out}");
        }
    };
    thread::scope(|scope| {
        for (line, statuses) in &lines {
            scope.spawn(|| judged(line, *statuses));
        }
    });
    for help in ["order --help", "judge --help", "--help"] {
        assert!(flat(&say(help).1).contains("does not start"), "{help}");
    }
}

/// Equations on which leading terms cancel, or which a method is not made for, refute nothing of its coefficients.
#[test]
fn a_special_problem_does_not_refute_the_order_of_a_method_file() {
    let order = |name: &str, problem: &str| say(&format!("order --problem {problem} --method {METHODS}/{name}.toml"));
    let (code, out, _) = order("gauss2", "quadratic-drag");
    assert!(code == 3 && flat(&out).contains("the errors fall faster"), "{out}");
    let (code, out, _) = order("dormand-prince", "damped-pendulum");
    assert!(code == 3 && flat(&out).contains("explains the errors no worse"), "{out}");
    for (name, problem, reason) in [
        ("forest-ruth", "damped-pendulum", "made for q̇ = f(p), ṗ = g(q)"),
        ("fitted-pade", "poiseuille-ansatz", "keeps a remainder"),
    ] {
        let (code, _, error) = order(name, problem);
        assert!(code == 2 && flat(&error).contains(reason), "{name}: {error}");
    }
    // Every file that is right, on problems of each sort: it passes, does not apply, or is left open.
    let files: Vec<&str> =
        SHIPPED.iter().map(|file| file.name).filter(|name| *name != "bdf7" && !name.contains('/')).collect();
    let problems = ["quadratic-drag", "pendulum"];
    let refuted: Vec<String> = files
        .par_iter()
        .flat_map_iter(|name| problems.map(|problem| (name, problem)))
        .filter(|(name, problem)| order(name, problem).0 == 1)
        .map(|(name, problem)| format!("{name} on {problem}"))
        .collect();
    assert!(refuted.is_empty(), "{refuted:?}");
    // An order below is still one.
    let (code, out, _) = say(&format!("order --problem logistic --method {METHODS}/heun2.toml --expect 3"));
    assert_eq!(code, 1, "{out}");
}

#[test]
fn a_file_that_comes_along_goes_by_its_name_and_a_mistyped_one_is_guessed() {
    let (code, out, error) = say("order --problem logistic --method heun2");
    assert!(code == 0 && out.contains("is 2 ± 0.1"), "{out}{error}");
    let (code, _, error) = say("order --problem logistic --method huen2");
    assert!(code == 2 && flat(&error).contains("did you mean `heun2`?"), "{error}");
    fits_a_terminal(&error);
}

#[test]
fn coefficients_that_contradict_their_kind_are_refused_at_their_place() {
    let dir = directory("contradictions");
    let path = dir.join("m.toml");
    for (text, place, reason, hint) in [
        ("kind = \"path-fitted\"\nnodes = [\"1/2\", 0.5]\n", ":2:17:", "`1/2` and `0.5` coincide", "differ"),
        (
            "kind = \"galerkin\"\ndegree = 1\nnodes = [0, 0]\nweights = [\"1/2\", \"1/2\"]\n",
            ":3:13:",
            "coincide",
            "differ",
        ),
        (
            "order = 1\nembedded_order = 2\na = [[]]\nb = [1]\n",
            ":2:18:",
            "gives no `b_hat`",
            "weights of the embedded method",
        ),
        (
            "claims = [\"not embedded order 2\"]\na = [[]]\nb = [1]\n",
            ":1:12:",
            "gives no `b_hat`",
            "weights of the embedded method",
        ),
    ] {
        fs::write(&path, text).expect("writable");
        let (code, out, error) = verify(&["judge", &path.display().to_string(), "--no-runs"]);
        assert!(code == 2 && out.is_empty(), "{text}: {out}");
        assert!(
            flat(&error).contains(place) && flat(&error).contains(reason) && flat(&error).contains(hint),
            "{text}: {error}"
        );
    }
    // A method of one stage has no rows, or an empty one.
    for a in ["[]", "[[]]", "[[0]]"] {
        fs::write(&path, format!("order = 1\na = {a}\nb = [1]\n")).expect("writable");
        let (code, out, error) = verify(&["judge", &path.display().to_string(), "--no-runs"]);
        assert!(code == 0 && out.contains("explicit, 1 stage"), "{a}: {out}{error}");
    }
}

/// Alexander's method to six places, by which Σ b_i is off by 10⁻⁶: the runs see that, and do not refute the order.
#[test]
fn runs_of_rounded_coefficients_count_their_rounding() {
    let path = directory("six-places").join("sdirk.toml");
    let text = "order = 3\nc = [0.435867, 0.717933, 1]\nb = [1.208497, -0.644363, 0.435867]\n\
                a = [[0.435867], [0.282067, 0.435867], [1.208497, -0.644363, 0.435867]]\n";
    fs::write(&path, text).expect("writable");
    let file = path.display().to_string();
    let (code, out, _) = verify(&["judge", &file, "--no-runs"]);
    assert!(code == 0 && out.contains("confirmed    order 3"), "{out}");
    let (code, out, _) = verify(&["judge", &file]);
    assert!(code != 1 && !out.contains("REFUTED"), "{out}");
    for problem in ["logistic", "van-der-pol", "pendulum"] {
        let (code, out, error) = verify(&["order", "--problem", problem, "--method", &file]);
        assert!(code == 0 || code == 3, "{problem}: {out}{error}");
        // The errors do not fall below what the digits leave, and the table says so.
        assert!(out.contains("at the floor"), "{out}");
    }
    // Four places are taken at their word, with a hint.
    let places = |n: usize| {
        let numbers = [0.4358665215, 0.71793326075, 1.208496649, -0.644363171, 0.28206673925];
        let [g, c, b, d, a] = numbers.map(|x: f64| format!("{x:.n$}"));
        format!("order = 3\nc = [{g}, {c}, 1]\nb = [{b}, {d}, {g}]\na = [[{g}], [{a}, {g}], [{b}, {d}, {g}]]\n")
    };
    fs::write(&path, places(4)).expect("writable");
    let (code, out, _) = verify(&["judge", &file, "--no-runs"]);
    assert!(code == 1 && flat(&out).contains("`digits = 4`"), "{out}");
    fs::write(&path, format!("digits = 4\n{}", places(4))).expect("writable");
    let (code, out, _) = verify(&["judge", &file, "--no-runs"]);
    assert!(code == 0 && !out.contains("DIAGNOSIS"), "{out}");
}

#[test]
fn a_system_gets_advice_with_an_error_that_was_found_or_none() {
    let (code, out, _) = verify(&["advise", "--problem", "channel-couette", "--set", "cells=8"]);
    assert!(code == 0 && out.contains("TAKE") && out.contains("symmetric") && out.contains("contractive"), "{out}");
    assert!(out.contains("RUN           verify solve --problem channel-couette --set 'cells=8' "), "{out}");
    // To the end of the advice, which is later than the problem's own.
    let (code, out, _) = verify(&["advise", "--problem", "van-der-pol"]);
    assert!(code == 0 && out.contains("to t = 13,") && out.contains("--t-end 13 "), "{out}");
    let model = format!("{}/models/predator-prey.ds", env!("CARGO_MANIFEST_DIR"));
    let (code, out, _) = verify(&["advise", "--model", &model, "--t-end", "2"]);
    assert!([0, 3].contains(&code) && out.contains("evaluations") && out.contains("Note:"), "{out}");
    // A path is not broken.
    assert!(out.lines().all(|line| line.contains(&model) || line.chars().count() <= 81), "{out}");
    // The solution of v̇ = −v² from −1 ends at t = 1.
    let (code, out, _) = verify(&["advise", "--problem", "taylor-green", "--set", "cells=8"]);
    assert_eq!((code, out.contains("24 unknowns"), out.contains("growth")), (3, true, false), "{out}");
    assert!(flat(&out).contains("NO ADVICE the system is known by products with its Jacobian"), "{out}");
    let (code, out, _) = verify(&["advise", "--problem", "quadratic-drag", "--set", "v0=-1", "--t-end", "2"]);
    assert!(code == 3 && out.contains("NO ADVICE") && !out.contains("TAKE"), "{out}");
    let (code, out, _) = verify(&["advise", "--problem", "kepler", "--t-end", "13"]);
    assert!(code == 3 && out.contains("NO ADVICE     no clear winner") && out.matches("RUN").count() == 2, "{out}");
    // Of [[−1, 10], [0, −1]] the symmetric part has the eigenvalue 4.
    let sheared = directory("sheared").join("sheared.ds");
    fs::write(&sheared, "u_i { x = 1, y = 1 } F_i { -x + 10*y, -y }").expect("writable");
    let (_, out, _) = verify(&["advise", "--model", &sheared.display().to_string(), "--t-end", "5"]);
    assert!(flat(&out).contains("(numerical abscissa 4.0, spectral -1.0)"), "{out}");
    for bad in ["0", "1", "NaN", "x"] {
        assert_eq!(verify(&["advise", "--problem", "logistic", "--accuracy", bad]).0, 2);
    }
}

/// A band decides by how much an order may be off.
#[test]
fn the_band_that_is_asked_for_decides() {
    let dir = directory("band");
    let path = dir.join("law.csv");
    let rows: String = [8.0, 4.0, 2.0, 1.0].map(|h: f64| format!("{h},{:.9}\n", 3.0 + 0.01 * h.powf(1.8))).concat();
    fs::write(&path, format!("h,u\n{rows}")).expect("writable");
    let data = format!("order --data {} --step h --expect 2", path.display());
    let euler = format!("{} solve --method heun2 --no-estimate --csv -", env!("CARGO_BIN_EXE_verify"));
    let program = ["order", "--problem", "logistic", "--expect", "2.3", "--program", &euler];
    let words: Vec<&str> = data.split(' ').collect();
    for (line, narrow, wide, default) in [
        (&words[..], "0.1", "0.25", 0),
        (&[&words[..], &["--exact", "3"]].concat(), "0.1", "0.25", 0),
        (&program[..], "0.2", "0.5", 1),
        (&["order", "--problem", "logistic", "--method", "rk4", "--expect", "4.3"], "0.2", "0.5", 1),
    ] {
        assert_eq!(verify(line).0, default, "{line:?}");
        for (band, status) in [(narrow, 1), (wide, 0)] {
            let (code, out, error) = verify(&[line, &["--band", band]].concat());
            assert_eq!(code, status, "{line:?} --band {band}: {out}{error}");
        }
    }
    assert_eq!(say(&format!("{data} --band 0")).0, 2);
}

/// A program's bound is that of the order it is taken to have; of one that its runs do not show there is none.
#[test]
fn a_comparison_takes_the_order_of_a_program_for_its_bound() {
    let own = format!("{} solve --method implicit-euler --no-estimate --csv -", env!("CARGO_BIN_EXE_verify"));
    let compare = |order: &[&str]| {
        let (code, out, _) = verify(&[&["compare", "--problem", "logistic", "--program", &own], order].concat());
        (code, flat(&out))
    };
    for (order, status) in [(&[][..], 0), (&["--expect", "1"], 0), (&["--expect", "4"], 3)] {
        let (code, out) = compare(order);
        assert!(code == status && out.contains(" 0 do not"), "{order:?}: {out}");
        assert_eq!(out.contains("its runs differ by orders 1.0 and 1.0, not by 4"), status == 3, "{order:?}: {out}");
    }
}

/// Of two programs that are asked for, one that is told does not stand for the other.
#[test]
fn a_comparison_that_tells_nothing_of_one_of_two_programs_is_inconclusive() {
    let own = |method: &str| format!("{} solve --method {method} --csv -", env!("CARGO_BIN_EXE_verify"));
    let (first, second) = (own("rk4"), own("implicit-euler"));
    let both = [&first, &second];
    for (programs, status) in [(&[&first][..], 0), (&[&second], 3), (&both, 3), (&[&second, &first], 3)] {
        let programs = programs.iter().flat_map(|program| ["--program", program.as_str()]);
        let line = ["compare", "--problem", "logistic", "--expect", "4"].into_iter().chain(programs);
        let line: Vec<&str> = line.collect();
        let (code, out, error) = verify(&line);
        assert!(code == status && out.contains(" 0 do not"), "{line:?}: {code} {out}{error}");
    }
    // One that disagrees is told whatever is open beside it: this one converges, to another value.
    let wrong = directory("wrong").join("wrong.awk");
    let text = "BEGIN { print \"t,v\"; for (k = 0; k <= 4; k++) printf \"%.17g,%.17g\\n\", k * t / 4, 0.5 + 0.01 * h }";
    fs::write(&wrong, text).expect("writable");
    let wrong = format!("sh -c 'awk -v h=\"$4\" -v t=\"$6\" -f {}' -", wrong.display());
    let (code, out, error) =
        verify(&["compare", "--problem", "logistic", "--program", &wrong, "--program", "sh -c 'exit 1'"]);
    assert!(code == 1 && out.contains(" 1 do not"), "{code} {out}{error}");
}

/// A program shows velocities and vorticity; references and methods have values of the stream function and Fourier coefficients.
/// A pulse of a thousandth of a unit of time that one reference sees and the others pass over, whose bounds know nothing of it.
#[test]
fn a_pulse_that_solvers_pass_over_puts_none_of_them_in_the_wrong() {
    let path = directory("pulse").join("pulse.ds");
    let pulse = "3*exp(-((t-37.123)/1e-3)*((t-37.123)/1e-3))/(1e-3*1.7724538509055159)";
    fs::write(&path, format!("u_i {{ x = 1 }} F_i {{ -x + {pulse} }}")).expect("writable");
    for t_end in [37.5, 40.0, 50.0] {
        let (status, text, _) = say(&format!("compare --model {} --t-end {t_end}", path.display()));
        let text = flat(&text);
        assert!(status == 3 && text.contains(" 0 agree, 0 do not"), "{t_end}: {status} {text}");
        assert!(text.contains("changes by itself") && !text.contains("Differences grow"), "{t_end}: {text}");
    }
}

/// A dose that steps and references alike pass over: the runs agree with the reference on a solution without it.
#[test]
fn a_dose_that_all_pass_over_leaves_every_verdict_open() {
    let path = directory("dose").join("dose.ds");
    fs::write(&path, "u_i { c = 1 } F_i { 398942 * exp(-5e7 * (t - 5.0371) * (t - 5.0371)) - 0.4 * c }")
        .expect("writable");
    let model = path.display();
    let (status, out, _) = say(&format!("order --model {model} --t-end 10 --method rk4"));
    let text = flat(&out);
    assert!(status == 3 && text.contains("INCONCLUSIVE: order 4"), "{status} {text}");
    assert!(text.contains("the reference is in doubt: from t = 5.03") && text.contains("by itself"), "{text}");
    let (status, out, _) = say(&format!("compare --model {model} --t-end 10"));
    assert!(status == 3 && flat(&out).contains("The references are in doubt: from t = 5.03"), "{status} {out}");
    // One that nobody passes over.
    fs::write(&path, "u_i { c = 1 } F_i { 100 * exp(-0.1 * (t - 5.0371) * (t - 5.0371)) - 0.4 * c }")
        .expect("writable");
    let (status, out, _) = say(&format!("order --model {model} --t-end 10 --method rk4"));
    assert!(status == 0 && !out.contains("in doubt"), "{status} {out}");
}

/// Rows of it may look right for a while; where they break off, no smaller step helps.
#[test]
fn a_method_that_is_not_zero_stable_is_named_as_the_cause() {
    let known = "bdf7 is not zero-stable, and converges in no run";
    for line in [
        "solve --problem logistic --method bdf7 --h 0.1 --t-end 1",
        "solve --problem logistic --method bdf7 --h 0.01 --t-end 20",
        "compare --problem logistic --method bdf7",
    ] {
        let (_, _, error) = say(line);
        assert!(flat(&error).contains(known) && !flat(&error).contains("smaller `--h`"), "{line}: {error}");
    }
    // A lower order than a file claims is told beside the reason that a run breaks off for.
    let (model, file) = (directory("rest").join("rest.ds"), format!("{METHODS}/misprints/rk4-a44.toml"));
    fs::write(&model, "u_i { x = 1 } F_i { -sqrt(x) }").expect("writable");
    let (status, _, error) = say(&format!("solve --model {} --method {file} --h 0.1 --t-end 4", model.display()));
    let error = flat(&error);
    assert!(status == 1 && error.contains("lead on from there"), "{status} {error}");
    assert!(error.contains("claims order 4, and its coefficients have order 1"), "{error}");
    let (status, out, _) = say("order --problem logistic --method bdf7");
    assert!(status != 0 && flat(&out).contains("the method is not zero-stable"), "{status} {out}");
}

/// Its bound knows of a jump of f, as those of methods do: 0.3 of a step of 4/2048 at most, and of one of 4/16384 at least.
#[test]
fn the_bound_of_a_program_knows_of_a_jump() {
    let dir = directory("jumping");
    let path = dir.join("jump.ds");
    fs::write(&path, "u_i { c = 0.5 } F_i { -c + 0.3*heaviside(t - 1.9182) }").expect("writable");
    let script = dir.join("rk4.awk");
    let text = r#"
        function f(t, c) { return -c + (t < 1.9182 ? 0 : 0.3) }
        BEGIN {
            for (i = 1; i < ARGC; i++) { if (ARGV[i] == "--h") h = ARGV[i + 1]; if (ARGV[i] == "--t-end") T = ARGV[i + 1] }
            c = 0.5; print "t,c"; printf "0,%.17g\n", c
            for (k = 0; k * h < T - 1e-9; k++) {
                t = k * h; q = f(t, c); r = f(t + h / 2, c + h * q / 2); s = f(t + h / 2, c + h * r / 2)
                c += h / 6 * (q + 2 * r + 2 * s + f(t + h, c + h * s)); printf "%.17g,%.17g\n", t + h, c
            }
        }"#;
    fs::write(&script, text).expect("writable");
    if !Command::new("awk").args(["BEGIN { exit 0 }"]).status().is_ok_and(|status| status.success()) {
        return;
    }
    let own = format!("awk -f {} --", script.display());
    let line = format!("compare --model {} --t-end 4 --expect 4", path.display());
    let (code, out, error) = verify(&[&line.split(' ').collect::<Vec<_>>()[..], &["--program", &own]].concat());
    let row = out.lines().find(|row| row.starts_with("awk ")).expect("a row of it");
    let bounds: Vec<f64> = row.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let [_, bound] = bounds[..] else { panic!("{row}") };
    assert!(code == 0 && (0.3 * 4.0 / 16384.0..0.3 * 4.0 / 2048.0 + 1e-5).contains(&bound), "{code} {row} {error}");
}

/// Beside a rest that is unstable roundings alone decide when a solution leaves it.
#[test]
fn a_disagreement_that_says_nothing_is_no_failure() {
    let path = directory("top").join("top.ds");
    fs::write(&path, "u_i { q = 3.141592653589793, p = 0 } F_i { p, -sin(q) }").expect("writable");
    let (status, text, _) = say(&format!("compare --model {} --t-end 80", path.display()));
    let text = flat(&text);
    assert!(text.contains("a disagreement says nothing of a solver") && text.contains(", 0 do not"), "{text}");
    assert_ne!(status, 1, "{text}");
}

#[test]
fn a_comparison_with_a_program_is_in_what_the_problem_shows() {
    for (setting, wrong) in [("taylor-green --set cells=6", "implicit-euler"), ("cavity --set cells=3", "rk4")] {
        let program = |method: &str, set: &str| {
            format!("{} solve --method {method} {set} --no-estimate --csv -", env!("CARGO_BIN_EXE_verify"))
        };
        let programs = [program("method-i", ""), program(wrong, "--set re=30")];
        let problem = ["compare", "--problem"].into_iter().chain(setting.split(' '));
        let line: Vec<&str> = problem.chain(programs.iter().flat_map(|program| ["--program", program])).collect();
        let (code, out, error) = verify(&line);
        let agrees = out.lines().any(|row| row.contains(" [1] ") && row.ends_with(" agrees"));
        assert!(code == 1 && out.contains(" 1 do not") && agrees, "{setting}: {out}{error}");
    }
}

/// Each option has a question of its own; another one does not pass over it.
#[test]
fn options_of_another_question_are_refused() {
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/drag.csv");
    let table = format!("order --data {data} --cells cells --dimension 2");
    for (line, needed) in [
        ("order --problem cavity --method method-i --refine cells=4,8,16", "--refine needs --program"),
        ("order --problem logistic --method rk4 --h 0.1,0.05,0.025", "--h needs --program"),
        ("order --problem logistic --method rk4 --time-limit 3", "--time-limit needs --program"),
        ("order --problem logistic --method rk4 --cells N --dimension 2", "--cells needs --data"),
        ("order --problem logistic --method rk4 --quantity energy", "--quantity needs --data"),
        ("order --problem logistic --program true --exact 2", "--exact needs --data"),
        (&format!("{table} --h 0.1"), "--h needs --program"),
        (&format!("{table} --coarsest 0.1"), "--coarsest needs --method"),
        (&format!("{table} --points 5"), "--points needs --method"),
    ] {
        let (code, out, error) = say(line);
        assert!(code == 2 && out.is_empty() && flat(&error).contains(needed), "{line}: {code} {out}{error}");
    }
    assert_eq!(say(&table).0, 0);
}

/// An error in Fourier coefficients is not one in the vorticity that is shown.
#[test]
fn an_order_says_what_its_errors_are_of() {
    let method = "order --problem taylor-green --set cells=8 --method rk4";
    let program = format!("{} solve --method rk4 --no-estimate --csv -", env!("CARGO_BIN_EXE_verify"));
    let (_, out, _) = say(method);
    assert!(flat(&out).contains("the largest difference of an unknown of the equations"), "{out}");
    let (_, out, _) = verify(&["order", "--problem", "taylor-green", "--set", "cells=8", "--program", &program]);
    assert!(flat(&out).contains("the largest difference of a component that it shows"), "{out}");
}

/// Grids in place of steps: a parameter that the program is given, without a reference.
#[test]
fn a_program_is_refined_in_space() {
    let script = directory("refine").join("flow.awk");
    let text =
        "BEGIN { for (i = 1; i < ARGC; i++) if (split(ARGV[i], pair, \"=\") == 2 && pair[1] == \"cells\") n = pair[2]
        print \"t,drag,lift\"; printf \"2,%.15g,%.15g\\n\", 1.5 + 0.3 / n ^ 2, 0.7 - 0.2 / n }";
    fs::write(&script, text).expect("writable");
    if !Command::new("awk").args(["BEGIN { exit 0 }"]).status().is_ok_and(|status| status.success()) {
        return;
    }
    let program = format!("awk -f {} --", script.display());
    let order = |more: &[&str]| verify(&[&["order", "--program", &program][..], more].concat());
    let drag = ["--quantity", "drag", "--refine", "cells=32,64,128,256"];
    for (expect, status, word) in [
        (&["--expect", "2"][..], 0, "PASS: order 2.000"),
        (&["--expect", "1"], 1, "FAIL"),
        (&[], 0, "MEASURED: order 2.000"),
    ] {
        let (code, out, error) = order(&[&drag[..], expect].concat());
        assert!(code == status && out.contains(word), "{out}{error}");
    }
    // Spacings are those of all grids where one of them is no number of cells.
    fs::write(&script, text.replace("\"cells\") n = pair[2]", "\"dx\") n = 1 / pair[2]")).expect("writable");
    let (code, out, error) = order(&["--quantity", "drag", "--refine", "dx=2,1,0.5,0.25", "--expect", "2"]);
    assert!(code == 0 && out.contains("PASS: order 2.000"), "{out}{error}");
    // A step that is asked for is that of every grid: one that the program does not get leaves a larger error in time.
    let text = text
        .replace("BEGIN {", "BEGIN { e = 1; for (i = 1; i < ARGC; i++) if (ARGV[i] == \"--h\") e = ARGV[i + 1];")
        .replace("1.5 + 0.3", "e + 0.3");
    fs::write(&script, &text).expect("writable");
    let (code, out, error) = order(&[&drag[..], &["--h", "0.25"]].concat());
    assert!(code == 0 && out.contains("0.25"), "{out}{error}");
    // It belongs to no grid: that its last one is cut, in every run alike, says nothing of what the grids differ by.
    let cut = text.replace("printf \"2,", "printf \"0,1,1\\n1.2,1,1\\n\"; printf \"2,");
    fs::write(&script, &cut).expect("writable");
    let (code, out, error) = order(&[&drag[..], &["--h", "1.2"]].concat());
    assert!(code == 0 && !flat(&out).contains("the last step was cut"), "{out}{error}");
    fs::write(&script, text).expect("writable");
    // Every quantity has to have the order.
    let (code, out, _) = order(&[&drag[..], &["--quantity", "lift", "--expect", "2"]].concat());
    assert!(code == 1 && out.contains("PASS: order 2.000") && out.contains("FAIL: order 1.000"), "{out}");
    for (more, reason) in [
        (&["--refine", "cells=32,64"][..], "--quantity"),
        (&["--quantity", "drag", "--refine", "cells=32,x"], "--refine: `x`"),
        (&["--quantity", "drag", "--refine", "cells=0,32,64"], "--refine: `0`"),
        (&["--quantity", "drag", "--refine", "cells"], "name=value"),
        (&["--quantity", "mass", "--refine", "cells=32,64,128"], "where `t,mass` is expected"),
    ] {
        let (code, out, error) = order(more);
        assert!(code == 2 && out.is_empty() && flat(&error).contains(reason), "{more:?}: {out}{error}");
    }
}

/// Few digits widen what is known of R, but a term of the series that is there does not vanish in it.
#[test]
fn an_explicit_method_of_few_digits_is_not_taken_for_a_stable() {
    let path = directory("few-digits").join("dopri.toml");
    let rows = [
        "[0.2]",
        "[0.075, 0.225]",
        "[0.97777778, -3.73333333, 3.55555556]",
        "[2.95259869, -11.59579332, 9.82289285, -0.29080933]",
        "[2.84627525, -10.75757576, 8.90642272, 0.27840909, -0.27353130]",
    ];
    let text = format!(
        "order = 5\nclaims = [\"not A-stable\", \"not A(30)-stable\"]\nc = [0, 0.2, 0.3, 0.8, 0.88888889, 1]\na = [[], {}]\n\
         b = [0.09114583, 0, 0.44923630, 0.65104167, -0.32237618, 0.13095238]\n",
        rows.join(", ")
    );
    fs::write(&path, text).expect("writable");
    let (code, out, error) = say(&format!("judge {} --no-runs", path.display()));
    assert!(
        code == 0 && out.contains("confirmed    not A-stable") && !out.contains("all of the negative"),
        "{out}{error}"
    );
    let kutta = directory("few-digits").join("kutta.toml");
    let text = "digits = 3\norder = 4\nclaims = [\"stable on the imaginary axis to 2.7\", \"dissipation order 5\"]\n\
                c = [0, 0.333, 0.667, 1]\na = [[], [0.333], [-0.333, 1], [1, -1, 1]]\nb = [0.125, 0.375, 0.375, 0.125]\n";
    fs::write(&kutta, text).expect("writable");
    let (_, out, error) = say(&format!("judge {} --no-runs", kutta.display()));
    assert!(!out.contains("REFUTED"), "{out}{error}");
}

/// RK4 all of whose stages take the time at the start of the step: right where no equation depends on time.
#[test]
fn wrong_stage_times_of_a_program_are_refuted_without_being_asked_for() {
    let script = directory("stages").join("late.sh");
    let text = r#"
        while [ $# -gt 0 ]; do
            case $1 in
                --problem) problem=$2 ;; --h) h=$2 ;; --t-end) end=$2 ;;
            esac
            shift 2
        done
        awk -v p="$problem" -v h="$h" -v T="$end" '
            function f(t, x) { return p == "logistic" ? x * (1 - x) : -2 * (x - cos(t)) - sin(t) }
            BEGIN {
                x = p == "logistic" ? 0.1 : 1; n = int(T / h + 0.5); print "t,v"; printf "0,%.17g\n", x
                for (k = 0; k < n; k++) {
                    t = k * h; a = f(t, x); b = f(t, x + h * a / 2); c = f(t, x + h * b / 2); d = f(t, x + h * c)
                    x += h * (a + 2 * b + 2 * c + d) / 6; printf "%.17g,%.17g\n", (k + 1) * h, x
                }
            }'
    "#;
    fs::write(&script, text).expect("writable");
    let program = format!("sh {}", script.display());
    let judge = |problems: &[&str]| verify(&[&["judge", "--expect", "4", "--program", &program], problems].concat());
    let start = verify::problem::build("logistic", &[]).expect("registered").initial()[0];
    fs::write(&script, text.replace("? 0.1 :", &format!("? {start:?} :"))).expect("writable");
    let (code, out, error) = judge(&["--problem", "logistic"]);
    assert!(code == 0 && flat(&error).contains("prothero-robinson lambda=2"), "{out}{error}");
    let (code, out, error) = judge(&["--problem", "logistic", "--problem", "prothero-robinson lambda=2"]);
    assert!(code == 1 && out.contains("REFUTED") && error.is_empty(), "{out}{error}");
    let (code, _, error) = judge(&["--problem", "prothero-robinson lambda"]);
    assert!(code == 2 && flat(&error).contains("NAME x=1"), "{error}");
}

/// Explicit Euler's error at the end of this problem changes its sign at the coarsest step, and its slopes settle beyond the usual ones.
#[test]
fn a_program_whose_slopes_have_not_settled_is_run_in_finer_steps() {
    let script = directory("finer").join("euler.awk");
    let text = r#"
        BEGIN {
            for (i = 1; i < ARGC; i++) { if (ARGV[i] == "--h") h = ARGV[i + 1]; if (ARGV[i] == "--t-end") T = ARGV[i + 1] }
            x = 1; t = 0; print "t,v"; print "0,1"
            while (t < T - 1e-9) {
                d = t + h > T ? T - t : h; x += d * (-2 * (x - cos(t)) - sin(t)); t += d; printf "%.17g,%.17g\n", t, x
            }
        }
    "#;
    fs::write(&script, text).expect("writable");
    let program = format!("awk -f {} --", script.display());
    let judge = |more: &[&str]| {
        let asked = ["judge", "--expect", "1", "--problem", "prothero-robinson lambda=2", "--program", &program];
        verify(&[&asked, more].concat())
    };
    let (code, out, error) = judge(&[]);
    assert!(code == 0 && out.contains("confirmed"), "{out}{error}");
    // Who asks for so many steps has so many.
    let (code, out, error) = judge(&["--points", "9"]);
    assert!(code == 3 && out.contains("have not settled"), "{out}{error}");
}

/// Solvers of v' = v (1 − v) that clip their last step: right, by a step of Euler, by a splitting without symmetry, by a whole step, or not at all.
#[test]
fn a_last_step_that_is_cut_wrongly_is_seen_beside_a_reference() {
    let script = directory("cut").join("cut.awk");
    let text = r#"
        function f(v) { return v * (1 - v) }
        function rk4(v, d,  a, b, c) {
            a = f(v); b = f(v + d * a / 2); c = f(v + d * b / 2)
            return v + d / 6 * (a + 2 * b + 2 * c + f(v + d * c))
        }
        function grow(v, d) { return v * exp(d) }
        function brake(v, d) { return v / (1 + d * v) }
        function strang(v, d) { return grow(brake(grow(v, d / 2), d), d / 2) }
        BEGIN {
            for (i = 1; i < ARGC; i++) { if (ARGV[i] == "--h") h = ARGV[i + 1]; if (ARGV[i] == "--t-end") T = ARGV[i + 1] }
            if (kind == "same") h = 0.01
            v = 0.1; t = 0; print "t,v"; printf "0,%.17g\n", v
            if (kind == "far") T += h
            if (kind == "farther") T += 2 * h
            while (t < T - 1e-9) {
                d = h; cut = 0
                if (t + h > T + 1e-9 && kind != "over") { d = T - t; cut = 1 }
                if (cut && kind == "refuses") { print "h does not divide T" > "/dev/stderr"; exit 1 }
                if (kind == "lie" || kind == "strang") v = cut && kind == "lie" ? brake(grow(v, d), d) : strang(v, d)
                else v = cut && kind == "euler" ? v + d * f(v) : rk4(v, kind == "whole" ? h : d)
                t += d; if (cut) t = T
                printf "%.17g,%.17g\n", t, v
            }
        }"#;
    fs::write(&script, text).expect("writable");
    if !Command::new("awk").args(["BEGIN { exit 0 }"]).status().is_ok_and(|status| status.success()) {
        return;
    }
    let run = |command: &str, kind: &str, expect: &[&str]| {
        let program = format!("awk -v kind={kind} -f {} --", script.display());
        let (code, out, _) = verify(&[&[command, "--problem", "logistic", "--program", &program], expect].concat());
        (code, flat(&out))
    };
    for (kind, order, status, said) in [
        ("right", "4", 0, "the last step is cut, with h ="),
        ("strang", "2", 0, "the last step is cut, with h ="),
        ("euler", "4", 1, "where h does not divide the time"),
        ("euler", "4", 1, "; where it does the order is 3.9"),
        ("lie", "2", 0, "the last step has an error of order"),
        ("whole", "4", 1, "it is longer or shorter than the time that it ends at says"),
        ("refuses", "4", 0, "h does not divide T"),
        // The step is not the program's own.
        ("same", "4", 3, "every run gives the same values"),
        // Whole steps lead to less than one beyond the end, or to more.
        ("over", "4", 0, "too late: the order is that of the errors at the times it reached"),
        ("over", "4", 0, "they are of order 1"),
        ("far", "4", 3, "but the end is missed: with h ="),
        ("far", "4", 3, "they are of order 1"),
        ("farther", "4", 3, "they are those of another time"),
    ] {
        for command in ["order", "judge"] {
            let (code, out) = run(command, kind, &["--expect", order]);
            assert!(code == status && out.contains(said), "{command} {kind}: {code} {out}");
            assert!(
                ["lie", "euler", "whole"].contains(&kind) || !out.contains("the last step has an error"),
                "{kind}: {out}"
            );
        }
    }
    // Without an expectation the two orders contradict each other.
    assert_eq!(run("order", "right", &[]).0, 0);
    let (code, out) = run("order", "euler", &[]);
    assert!(code == 3 && out.contains("where h does not divide the time"), "{out}");
    assert!(out.contains("the order is 2.0") && out.contains(", and where it does 3.9"), "{out}");
}

/// An explicit method is unstable with coarse steps on a stiff problem, and has its order with finer ones.
#[test]
fn instability_of_coarse_runs_is_not_divergence() {
    let own = format!("{} solve --method rk4 --no-estimate --csv -", env!("CARGO_BIN_EXE_verify"));
    let line = ["--problem", "channel-womersley", "--expect", "4", "--program", &own];
    let (code, out, error) = verify(&[&["judge"][..], &line].concat());
    assert!(code != 1 && flat(&out).contains("coarse runs are unstable: the steps start at h = "), "{out}{error}");
}

/// On v̇ = −100 v RK4 is stable up to h = 0.0278: of the halves of ¼ from the fourth on.
#[test]
fn the_first_stable_step_is_named_where_those_that_were_asked_for_are_not() {
    let own = format!("{} solve --method rk4 --no-estimate --csv -", env!("CARGO_BIN_EXE_verify"));
    let line = ["order", "--problem", "linear-drag", "--set", "lambda=100", "--expect", "4", "--program", &own];
    let (code, out, error) = verify(&[&line[..], &["--coarsest", "0.25", "--points", "3"]].concat());
    let said = "coarse runs are unstable, with errors above the solution itself: smaller steps would tell, from \
                `--coarsest 0.015625` on";
    assert!(code == 3 && flat(&out).contains(said), "{out}{error}");
}

/// What the numbers beside a verdict are from, and what is said of values that do not settle as they should.
#[test]
fn a_table_of_values_is_judged_by_its_trend_and_says_what_its_numbers_are_from() {
    let path = directory("trend").join("study.csv");
    let order = |rows: &[(f64, f64)], more: &str| {
        let rows: String = rows.iter().map(|(h, u)| format!("{h},{u:.12}\n")).collect();
        fs::write(&path, format!("h,u\n{rows}")).expect("writable");
        let (code, out, _) = say(&format!("order --data {} --step h {more}", path.display()));
        fits_a_terminal(&out);
        (code, flat(&out))
    };
    // Differences that halve to the power of an order each.
    let drifting = |orders: [f64; 2]| {
        let (first, second) = (0.1, 0.1 / orders[0].exp2());
        let third = second / orders[1].exp2();
        [(8.0, 2.0), (4.0, 2.0 - first), (2.0, 2.0 - first - second), (1.0, 2.0 - first - second - third)]
    };
    let (code, out) = order(&drifting([1.862, 1.759]), "--expect 2");
    assert!(code == 3 && out.contains("the orders go from 1.862 to 1.759, away from 2"), "{out}");
    let (code, out) = order(&drifting([1.862, 1.959]), "--expect 2");
    assert!(code == 0 && !out.contains("away from"), "{out}");
    // The same of errors: slopes of 1.9, 1.85 and 1.79.
    let errors = [(8.0, 1.0), (4.0, 0.26794), (2.0, 0.074325), (1.0, 0.021493)].map(|(h, e)| (h, 3.0 + e));
    let (code, out) = order(&errors, "--expect 2 --exact 3");
    assert!(code == 3 && out.contains("away from 2"), "{out}");

    // The coarsest grid does not belong: neither order nor fit is from it, and it is named.
    let law = [16.0, 8.0, 4.0, 2.0, 1.0].map(|h: f64| (h, 3.0 + 0.01 * h.powi(2) + if h > 10.0 { 3.0 } else { 0.0 }));
    let (code, out) = order(&law, "--expect 2");
    assert!(code == 0 && out.contains("left out as too coarse") && out.contains(": h = 16"), "{out}");
    assert!(out.contains("(power law on 4 grids; ±") && out.contains("a + b h^p"), "{out}");
    assert!(
        out.contains("p = 2.000 on 4 grids: limit 3.0000000") && out.contains("p = 2.000 of the finest three"),
        "{out}"
    );
    let (_, out) = order(&law, "--expect 2 --exact 3");
    assert!(out.contains("left out as too coarse"), "{out}");
    // The finest three speak for themselves.
    assert!(out.contains("convergence monotonic, on the finest three grids"), "{out}");

    // Values that diverge, or say nothing, are not fitted; differences have the sign of the values.
    let (code, out) = order(&[(8.0, 1.0), (4.0, 1.1), (2.0, 1.3), (1.0, 1.7)], "--expect 2");
    assert!(code == 1 && !out.contains("least squares") && out.contains("from 0.2000 to 0.4000"), "{out}");
    let (code, out) = order(&[(8.0, 1.5), (4.0, 1.25), (2.0, 1.0), (1.0, 1.0)], "--expect 2");
    assert!(code == 3 && !out.contains("0.000e0") && !out.contains("least squares"), "{out}");
    // A wrong exact value.
    let right = [8.0, 4.0, 2.0, 1.0].map(|h: f64| (h, 3.0 + 0.01 * h.powi(2)));
    for exact in ["2.9", "3.01"] {
        let (code, out) = order(&right, &format!("--expect 2 --exact {exact}"));
        assert!(code != 0 && out.contains("the exact value may be wrong"), "{exact}: {out}");
    }
    assert!(!order(&right, "--expect 2 --exact 3").1.contains("may be wrong"));
}

#[test]
fn labels_lengths_and_forms_of_a_file_are_read_as_they_are_meant() {
    let dir = directory("meant");
    let judge = |name: &str, text: &str| {
        let path = dir.join(name);
        fs::write(&path, text).expect("writable");
        let (code, out, error) = say(&format!("judge {} --no-runs", path.display()));
        (code, flat(&out), flat(&error))
    };
    // The order of b̂ is told, not that of b.
    let bogacki = "order = 3\nembedded_order = 3\nc = [0, \"1/2\", \"3/4\", 1]\n\
                   a = [[], [\"1/2\"], [0, \"3/4\"], [\"2/9\", \"1/3\", \"4/9\"]]\n\
                   b = [\"2/9\", \"1/3\", \"4/9\", 0]\nb_hat = [\"7/24\", \"1/4\", \"1/3\", \"1/8\"]\n";
    let (code, out, error) = judge("embedded.toml", bogacki);
    assert!(code == 1 && !out.contains("they have order 3"), "{out}{error}");
    assert!(!out.contains("label is too high") || out.contains("they have order 2"), "{out}");
    // b is short, and c is not to blame.
    let short = "c = [0, \"1/2\", 1]\na = [[], [\"1/2\"], [-1, 2]]\nb = [\"1/6\", \"5/6\"]\n";
    let (code, _, error) = judge("short.toml", short);
    assert!(code == 2 && error.contains(":3:") && error.contains("`b` has 2 entries where `a` has 3 rows"), "{error}");
    // A tableau as it is typeset, and one as Fortran prints it.
    let typeset = "0    |\n1/2  | 1/2\n1/2  | 0   1/2\n1    | 0 0 1\n-----+------------\n     | 1/6 1/3 1/3 1/6\n";
    let fortran = "0.0D0 0.5D0 0.5D0 1.0D0\n1/6 1/3 1/3 1/6\n0.5D0\n0.0D0 0.5D0\n0.0D0 0.0D0 1.0D0\n";
    for (name, text) in [("typeset.txt", typeset), ("fortran.txt", fortran)] {
        let (code, out, error) = judge(name, text);
        assert!(code == 0 && out.contains("order 4; first failing tree"), "{name}: {out}{error}");
    }
    let (code, _, error) = judge("bars.txt", "0 |\n1 2 | 1\n | 1/2 1/2\n");
    assert!(code == 2 && error.contains("more than one number before the bar"), "{error}");
    // Claims in other words, and one that is made twice.
    let euler = "order = 1\nclaims = [\"order 1\", \"implicit\", \"A(0)-stable\"]\na = [[1]]\nb = [1]\nc = [1]\n";
    let (code, out, error) = judge("implicit.toml", euler);
    assert!(code == 0 && out.contains("confirmed not explicit") && out.contains("A(0°)-stable"), "{out}{error}");
    assert_eq!(out.matches("confirmed order 1").count(), 1, "{out}");
    let (code, out, _) =
        judge("explicit.toml", "claims = [\"implicit\", \"A(0)-stable\"]\na = [[]]\nb = [1]\nc = [0]\n");
    assert!(code == 1 && out.matches("REFUTED").count() == 2, "{out}");
    // An explicit method stays one.
    let heun = "order = 2\nclaims = [\"explicit\"]\nc = [0, 1]\na = [[], [\"1/2\"]]\nb = [\"1/2\", \"1/2\"]\n";
    let (code, out, _) = judge("heun.toml", heun);
    assert!(code == 1 && out.contains("a[2,1]") && !out.contains("a[2,2]"), "{out}");
}

/// A claim that fails on equations in general is not confirmed by one that does not show it.
#[test]
fn an_equation_that_does_not_show_a_wrong_coefficient_decides_nothing() {
    let path = directory("unseen").join("rk4.toml");
    let text = fs::read_to_string(format!("{METHODS}/rk4.toml")).expect("there");
    let nodes = text.lines().find(|line| line.starts_with("c = ")).expect("nodes").to_owned();
    fs::write(&path, text.replace(&nodes, "c = [0, \"1/2\", \"1/3\", 1]")).expect("writable");
    let (code, out, error) = say(&format!("order --problem logistic --method {}", path.display()));
    assert!(code == 3 && flat(&out).contains("on this equation: on others the order is"), "{out}{error}");
    assert!(flat(&say("order --help").1).contains("a claim that they do not have there passes nowhere"));
}

/// Messages fit a terminal whatever they are about; a word that is longer than a line stays whole.
#[test]
fn errors_are_as_wide_as_a_terminal() {
    let dir = directory("wide");
    let path = |name: &str, text: &str| written(&dir, name, text);
    let ragged = path("ragged.csv", "h,u\n4,1.5\n2,1.2,3\n1,1.1\n");
    let words = path("words.csv", "h u\n1 2\n");
    let wide =
        path("wide.csv", &format!("h,{}\n1,2\n", (0..30).map(|k| format!("u{k}")).collect::<Vec<_>>().join(",")));
    let good = path("good.csv", "h,u\n4,1.5\n2,1.2\n1,1.1\n");
    let toml = path("m.toml", "claims = [\"wonderful\"]\na = [[]]\nb = [1]\n");
    let lines: Vec<Vec<&str>> = vec![
        vec!["order", "--data", &ragged, "--step", "h"],
        vec!["order", "--data", &words, "--step", "h"],
        vec!["order", "--data", &wide, "--step", "dx"],
        vec!["order", "--data", &good, "--step", "h", "--quantity", "lift"],
        vec!["order", "--data", &good],
        vec!["order", "--data", &good, "--step", "h", "--expect", "-1"],
        vec!["order", "--problem", "logistic", "--program", "/no/such/program/of/mine --with options"],
        vec!["order", "--problem", "logistic", "--program", "sh -c 'echo time,velocity,pressure; echo 0,1,2'"],
        vec!["order", "--program", "sh -c 'echo drag; echo 1'", "--quantity", "drag", "--h", "0.1,0.05"],
        vec!["compare", "--problem", "logistic", "--program", "sh -c 'echo t,w; echo 0,1'"],
        vec!["advise", "--problem", "logistic", "--accuracy", "2"],
        vec!["advise", "--problem", "logistic", "--accuracy", "one-hundred-thousandth-of-what-there-is"],
        vec!["judge", &toml],
        vec!["judge", "no-such-method-as-this-one-is-there-anywhere"],
        vec!["solve", "--problem", "logistic", "--method", "rk5", "--h", "0.1", "--t-end", "1"],
        vec!["solve", "--problem", "logistic", "--method", "radau-adaptive", "--t-end", "1", "--rtol", "-1"],
        vec!["report", "--compare", &good],
        vec![
            "order",
            "--problem",
            "logistic",
            "--method",
            "rk4",
            "--band",
            "a-band-that-is-no-number-at-all-is-refused",
        ],
    ];
    for line in lines {
        let (code, _, error) = verify(&line);
        assert!(code == 2 && error.starts_with("error: "), "{line:?}: {code} {error}");
        fits_a_terminal(&error);
    }
}

#[test]
fn steps_of_a_programs_own_make_no_order_in_h() {
    let script = directory("rounded").join("own.awk");
    let text = "BEGIN { for (i = 1; i < ARGC; i++) if (ARGV[i] == \"--h\") h = ARGV[i + 1]
        n = kind == \"fixed\" ? 10 : int(1 / h + 0.5); print \"t,v\"; v = 1
        for (k = 0; k <= n; k++) { printf \"%.17g,%.17g\\n\", k / n, v; v *= 1 - 1 / n } }";
    fs::write(&script, text).expect("writable");
    if !Command::new("awk").args(["BEGIN { exit 0 }"]).status().is_ok_and(|status| status.success()) {
        return;
    }
    let order = |kind: &str, steps: &str| {
        let program = format!("awk -v kind={kind} -f {} --", script.display());
        let (code, out, _) = verify(&["order", "--program", &program, "--quantity", "v", "--h", steps]);
        (code, flat(&out))
    };
    let (code, out) = order("rounded", "0.3,0.15,0.075,0.0375");
    assert!(code == 3 && out.contains("the program takes other steps than it is asked for"), "{out}");
    let (code, out) = order("rounded", "0.05,0.025,0.0125,0.00625");
    assert!(code == 0 && !out.contains("other steps"), "{out}");
    let (code, out) = order("fixed", "0.3,0.15,0.075,0.0375");
    assert!(code == 3 && out.contains("every run gives the same values"), "{out}");
}

#[test]
fn advice_says_what_the_solution_does_and_what_its_errors_are() {
    let (code, out, _) = say("advise --problem kepler --t-end 0.6");
    let out = flat(&out);
    assert!(code == 0 && out.contains("of a turn at its fastest rate; `--t-end`"), "{out}");
    assert!(out.contains("relative to the largest component, or to 1, 2.0e-5 absolute"), "{out}");
    assert!(out.contains("its largest absolute error at "), "{out}");
    // Two periods of 2π, to two digits and the end of a step.
    let (code, out, _) = say("advise --problem harmonic-oscillator");
    let out = flat(&out);
    assert!(out.contains("unknowns, to t = 14,") && out.contains("has turned twice; `--t-end`"), "{out}");
    // An explicit splitting method and an adaptive one take the same work there.
    assert!(code == 3 && !out.contains("of a turn") && out.contains("no clear winner"), "{out}");
    let (code, out, _) = say("advise --problem quadratic-drag --set v0=-1 --t-end 2");
    assert!(code == 3 && flat(&out).contains("the solution blows up"), "{out}");
    let (code, out, _) = say("advise --problem quadratic-drag --set v0=0 --t-end 2");
    assert!(code == 3 && flat(&out).contains("moves by 0.0e0 from its start, within the error of 1.0e-5"), "{out}");
}

/// x + y of x' = y − x, y' = x − y is kept by Method I, that of x' = −x, y' = x is not, and the last system has none and only grows.
#[test]
fn advice_says_what_keeps_an_invariant_and_what_stability_asks_for() {
    let model = directory("told").join("told.ds");
    for (f, told) in [
        (
            "y - x, x - y",
            [
                "one linear: Runge–Kutta methods keep what is linear, and Method I",
                "rk4 is stable with 4 equal steps or more to the run",
            ],
        ),
        (
            "-x, x",
            [
                "one linear: Runge–Kutta methods keep what is linear, and Method I in the Euclidean metric need not",
                "rk4 is stable with 2 equal steps or more",
            ],
        ),
        ("x, 0.5*y", ["invariants none that is linear", "no mode decays, so that rk4 is stable with any steps"]),
    ] {
        fs::write(&model, format!("u_i {{ x = 1, y = 0.5 }} F_i {{ {f} }}")).expect("writable");
        let (_, out, error) = say(&format!("advise --model {} --t-end 5", model.display()));
        let out = flat(&out);
        assert!(told.iter().all(|words| out.contains(words)), "{f}: {out}{error}");
        assert_eq!(out.contains("need not"), f == "-x, x", "{out}");
        // Of a disturbance all of x comes to y in the second, and the last grows.
        assert_eq!(out.contains("has no larger component at any of the times looked at"), f == "y - x, x - y", "{out}");
    }
}

/// DiffSL's compiler panics on a state given twice; what it prints then is not for a reader.
#[test]
fn a_model_that_the_compiler_does_not_survive_is_an_error_and_nothing_else() {
    let path = directory("gave-up").join("twice.ds");
    fs::write(&path, "u_i { x = 1 }\nF_i { -x }\nu { 2*x }\n").expect("writable");
    let (code, out, error) =
        verify(&["solve", "--model", &path.display().to_string(), "--method", "rk4", "--h", "0.1", "--t-end", "1"]);
    assert!(code == 2 && out.is_empty(), "{out}");
    assert!(error.starts_with("error: the compiler of DiffSL gave up on"), "{error}");
    assert!(flat(&error).contains("twice.ds: ") && flat(&error).contains("hint: a model states"), "{error}");
}

#[test]
fn a_coarsest_step_beyond_the_time_is_refused() {
    for line in ["--method method-i", "--program ./none"] {
        let (code, out, error) = say(&format!("order --problem logistic {line} --coarsest 2.5"));
        assert!(code == 2 && out.is_empty(), "{out}");
        assert!(flat(&error).contains("the coarsest step 2.5 is longer than the time of a run, 2"), "{error}");
    }
    let (code, out, _) = say("order --problem logistic --method method-i --coarsest 2");
    assert!(code == 0 && out.contains("\n    2.00000 "), "{out}");
}

#[test]
fn a_method_that_is_compared_anyway_is_listed_once_and_a_file_of_its_name_beside_it() {
    let path = directory("compared").join("mine.toml");
    fs::write(&path, "name = \"rk4\"\na = [[]]\nb = [1]\n").expect("writable");
    let file = path.display().to_string();
    let (code, out, error) = verify(&["compare", "--problem", "logistic", "--method", "method-i", "--method", &file]);
    let count = |name: &str| out.lines().filter(|line| line.starts_with(&format!("{name} "))).count();
    assert_eq!((code, count("method-i"), count("rk4"), count("rk4 of")), (0, 1, 2, 1), "{out}{error}");
}

/// What was asked for and gave no answer is not covered by what agrees.
#[test]
#[cfg(unix)]
fn a_comparison_in_which_one_of_two_own_solvers_fails_is_inconclusive() {
    let file = format!("{METHODS}/radau-iia3.toml");
    let line = ["compare", "--problem", "linear-drag", "--method", &file];
    let (code, out, error) = verify(&line);
    assert_eq!(code, 0, "{out}{error}");
    let (code, out, error) = verify(&[&line[..], &["--program", "sh -c 'exit 1'"]].concat());
    assert!(code == 3 && out.contains(" 0 do not, 1 inconclusive"), "{out}{error}");
}

#[test]
fn rows_that_the_weights_do_not_match_are_counted_in_grammar() {
    let path = directory("rows").join("rows.toml");
    for (a, b, says) in [
        ("[0], [1, 0]", "1", "`a` has 2 rows beside 1 weight"),
        ("[0]", "0, 0, 1", "`a` has 1 row beside 3 weights"),
        ("[0], [1, 0, 0]", "0, 1", "row 2 of `a` has 3 entries"),
    ] {
        fs::write(&path, format!("a = [{a}]\nb = [{b}]\n")).expect("writable");
        let (code, _, error) = say(&format!("judge {}", path.display()));
        assert!(code == 2 && flat(&error).contains(says) && error.contains("\nhint: "), "{error}");
    }
}

/// Alexander's method to ten digits, which are a defect of 1e-10 in a problem where h λ ≫ 1 leaves errors of 1e-8.
#[test]
fn an_order_that_the_printed_digits_leave_open_says_so() {
    let [g, half, b1, b2] = ["0.4358665215", "0.2820667392", "1.208496649", "-0.6443631707"];
    let text = format!(
        "order = 3\na = [[\"{g}\"], [\"{half}\", \"{g}\"], [\"{b1}\", \"{b2}\", \"{g}\"]]\nb = [\"{b1}\", \"{b2}\", \"{g}\"]\n"
    );
    let path = directory("digits").join("sdirk3.toml");
    fs::write(&path, text).expect("writable");
    let (code, out, error) = say(&format!("judge {}", path.display()));
    let out = flat(&out);
    assert!(code == 0 && out.contains("not settled stiff: "), "{out}{error}");
    assert!(
        out.contains("the digits printed leave 2.0e-9 of these errors open") && out.contains("`digits = N`"),
        "{out}"
    );
    // Where nothing is at the floor of the digits it is not theirs.
    let (_, out, _) = say(&format!("order --problem prothero-robinson --method {}", path.display()));
    assert!(!out.contains("digits printed"), "{out}");
}

/// 3 + h²/5 on 1, 2, 4 and 8 has the index 1.25 · 0.2/3.2 of the finest grid, and the uncertainty 1.25 · 0.2 of the fit.
#[test]
fn tables_and_json_hold_the_numbers_of_a_power_law() {
    let path = directory("power-law").join("data.csv");
    fs::write(&path, "h,u\n1,3.2\n2,3.8\n4,6.2\n8,15.8\n").expect("writable");
    let order = |format: &str| say(&format!("order --data {} --step h --format {format}", path.display())).1;
    let markdown = order("markdown");
    assert!(markdown.contains(" 7.81 % "), "{markdown}");
    let json: serde_json::Value = serde_json::from_str(&order("json")).expect("JSON");
    let uncertainty = json["least_squares"]["uncertainty"].as_f64().expect("a number");
    // The order of the fit is found to half of the digits, as a minimum is.
    assert!((uncertainty - 0.25).abs() < 1e-6, "{uncertainty}");
    // A difference is a value less the one above it.
    let text = order("table");
    let numbers = |line: &str| line.split_whitespace().map(|word| word.parse::<f64>().ok()).collect::<Vec<_>>();
    let rows: Vec<_> = text.lines().map(numbers).filter(|row| row.len() == 4 && row[1].is_some()).collect();
    let found: Vec<_> = rows.iter().map(|row| (row[0], row[2], row[3])).collect();
    let expected = [
        (Some(8.0), None, None),
        (Some(4.0), Some(-9.6), None),
        (Some(2.0), Some(-2.4), Some(2.0)),
        (Some(1.0), Some(-0.6), Some(2.0)),
    ];
    assert_eq!(found, expected, "{text}");
}

/// A program that ends where its step leads it: none of its columns can be compared.
#[test]
#[cfg(unix)]
fn every_quantity_of_runs_that_end_at_different_times_is_left_open() {
    let dir = directory("ends");
    let script = dir.join("ends.sh");
    fs::write(
        &script,
        "while [ $# -gt 0 ]; do [ $1 = --h ] && h=$2; shift; done\necho t,u,v\necho 0,1,1\necho 1$h,1${h#0.},2${h#0.}\n",
    )
    .expect("writable");
    let program = format!("sh {}", script.display());
    let line = ["order", "--program", &program, "--h", "0.4,0.2,0.1,0.05", "--quantity", "u", "--quantity", "v"];
    let (code, out, error) = verify(&[&line[..], &["--format", "json"]].concat());
    let json: serde_json::Value = serde_json::from_str(&out).expect(&error);
    let verdicts: Vec<_> = json["quantities"].as_array().expect("two").iter().map(|q| q["verdict"].clone()).collect();
    assert!(code == 3 && verdicts == ["inconclusive", "inconclusive"], "{out}");
    for quantity in json["quantities"].as_array().expect("two") {
        assert!(quantity["reason"].as_str().expect("a reason").contains("different times"), "{out}");
    }
}

/// The band of a program's order is the one that decides, and the verdict shows it.
#[test]
fn a_program_is_judged_within_the_band_that_is_shown() {
    let own = format!("{} solve --method rk4 --no-estimate --csv -", env!("CARGO_BIN_EXE_verify"));
    let line = ["judge", "--program", &own, "--expect", "4", "--problem", "logistic", "--format", "json"];
    let (code, out, error) = verify(&line);
    let json: serde_json::Value = serde_json::from_str(&out).expect(&error);
    assert_eq!(code, 0, "{out}");
    assert_eq!(json[0]["required"]["near"], serde_json::json!([4.0, 0.1]), "{out}");
}

/// v̇ = v(1 − v) from another state than the problem's is another solution, whatever the steps.
#[test]
#[cfg(unix)]
fn a_program_that_starts_elsewhere_is_told_so() {
    let own = format!("{} solve --method rk4 --no-estimate --csv - --set v0=0.5", env!("CARGO_BIN_EXE_verify"));
    let (code, out, error) = verify(&["judge", "--program", &own, "--expect", "4", "--problem", "logistic"]);
    let out = flat(&out);
    assert!(
        code == 1 && out.contains("its row at t = 0 has v = 0.5, where the problem starts from v = 0.1"),
        "{out}{error}"
    );
    assert!(!out.contains("starting procedure"), "{out}");
}

/// As DiffSL's own names are, and those of a model.
#[test]
fn a_name_that_is_given_twice_is_told_with_both_places() {
    let model = directory("twice").join("twice.ds");
    let own = "DiffSL calls f `F`; ";
    for (code, told) in [
        ("u_i { x = 1 }\n// F of all\nin_i { F = 2 }\nF_i { -F*x }", format!("`F` is already there in line 3; {own}")),
        ("u_i { x = 1 }\nF_i { -x }\nF_i { x }", format!("`F` is already there in line 2; {own}")),
        ("k { 3 }\n\nk { 4 }\nu_i { x = 1 }\nF_i { -k*x }", "`k` is already there in line 1; ".to_owned()),
        (
            "M { 2 }\nu_i { x = 1 }\nF_i { -M*x }",
            "; DiffSL calls the product of the mass matrix with dudt `M`; ".to_owned(),
        ),
    ] {
        fs::write(&model, code).expect("writable");
        let (code, _, error) = say(&format!("solve --model {} --method rk4 --h 0.1 --t-end 1", model.display()));
        assert!(code == 2 && flat(&error).contains(&format!("{told}rename what is another thing")), "{error}");
    }
    // Given once, and reserved.
    fs::write(&model, "u_i { x = 1 }\nN { 2 }\nF_i { -N*x }").expect("writable");
    let (code, _, error) = say(&format!("solve --model {} --method rk4 --h 0.1 --t-end 1", model.display()));
    assert!(code == 2 && error.contains("reserved") && !error.contains("already there"), "{error}");
}

#[test]
fn mistakes_in_tables_and_claims_are_answered_by_what_mends_them() {
    let dir = directory("mended");
    let (table, method) = (dir.join("data.csv"), dir.join("method.toml"));
    fs::write(&table, "h,u,note\n0.1,1.01,a\n0.05,1.0025,b\n").expect("writable");
    let (code, _, error) = say(&format!("order --data {} --step h", table.display()));
    assert!(code == 2 && flat(&error).contains("`a` is not a number hint: `--quantity COLUMN`"), "{error}");
    let (code, _, error) = say(&format!("order --data {} --cells h --quantity u", table.display()));
    assert!(code == 2 && flat(&error).contains("--dimension 1, 2 or 3"), "{error}");
    fs::write(&table, "n,u\n10,1.01\n20,1.0025\n40,1.000625\n").expect("writable");
    let (code, _, error) = say(&format!("order --data {}", table.display()));
    assert!(code == 2 && flat(&error).contains("hint: `--step COLUMN` names the one with the spacing"), "{error}");
    let model = dir.join("open.ds");
    fs::write(&model, "u_i { x = 1 } F_i { -x").expect("writable");
    let (code, _, error) = say(&format!("solve --model {} --method rk4 --h 0.1 --t-end 1", model.display()));
    assert!(code == 2 && flat(&error).contains("hint: the language is described at https://"), "{error}");
    fs::write(&method, "claims = \"L-stable\"\nb = [1]\na = [[1]]\n").expect("writable");
    let (code, _, error) = say(&format!("judge {}", method.display()));
    assert!(code == 2 && error.contains("`claims` is a list: [\"A-stable\"]"), "{error}");
}
