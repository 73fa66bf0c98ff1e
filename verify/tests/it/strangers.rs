//! What people who had never seen the command tripped over.

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use crate::{flat, scratch};

fn verify(arguments: &[&str]) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_verify"));
    let output = command.args(arguments).env("NO_COLOR", "1").env_remove("COLUMNS").output().expect("it starts");
    let text = |bytes: Vec<u8>| flat(&String::from_utf8(bytes).expect("UTF-8"));
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr))
}

/// A file of this name and text in a directory of its own.
fn file(name: &str, text: &str) -> PathBuf {
    let path = scratch(&format!("strangers/{name}"));
    fs::create_dir_all(path.parent().expect("a directory")).expect("writable");
    fs::write(&path, text).expect("writable");
    path
}

fn judged(name: &str, text: &str) -> (i32, String, String) {
    verify(&["judge", &file(name, text).display().to_string(), "--no-runs"])
}

/// A program in awk that knows logistic, with its time, step and end in t, h and T, or nothing where there is no awk.
fn program(name: &str, body: &str) -> Option<String> {
    let text = format!(
        r#"function f(v) {{ return v * (1 - v) }}
        function rk4(v, d,  a, b, c) {{
            a = f(v); b = f(v + d * a / 2); c = f(v + d * b / 2)
            return v + d / 6 * (a + 2 * b + 2 * c + f(v + d * c))
        }}
        function row() {{ printf "%.17g,%.17g\n", t, v }}
        BEGIN {{
            for (i = 1; i < ARGC; i++) {{ if (ARGV[i] == "--h") h = ARGV[i + 1]; if (ARGV[i] == "--t-end") T = ARGV[i + 1] }}
            v = 0.1; t = 0; print "t,v"
            {body}
        }}"#
    );
    let path = file(name, &text);
    let has_awk = Command::new("awk").args(["BEGIN { exit 0 }"]).status().is_ok_and(|status| status.success());
    has_awk.then(|| format!("awk -f {} --", path.display()))
}

const RK4: &str = "order = 4\nc = [0, \"1/2\", \"1/2\", 1]\na = [[\"1/2\"], [0, \"1/2\"], [0, 0, 1]]\n\
                   b = [\"1/6\", \"1/3\", \"1/3\", \"1/6\"]\n";

#[test]
fn tableaus_as_they_are_typeset_or_pasted_are_read() {
    let rows =
        [["0", "", "", "", ""], ["1/2", "1/2", "", "", ""], ["1/2", "0", "1/2", "", ""], ["1", "0", "0", "1", ""]];
    let weights = ["", "1/6", "1/3", "1/3", "1/6"];
    let array =
        |between: &str, end: &str| rows.iter().chain([&weights]).map(|row| row.join(between) + end).collect::<String>();
    let fractions = |text: &str| text.replace("1/2", r"\frac{1}{2}").replace("1/6", r"$\tfrac{1}{6}$");
    let latex = format!("\\begin{{array}}{{c|cccc}}\n{}\\end{{array}}\n", array(" & ", " \\\\ \\hline\n"));
    let markdown = |above: &str, label: &str| {
        let rows = rows.iter().chain([&weights]).map(|row| format!("| {} |\n", row.join(" | "))).collect::<String>();
        format!("{above}{}", rows.replace("|  | 1/6", &format!("| {label} | 1/6")))
    };
    let square = "0;0;0;0;0\n1/2;1/2;0;0;0\n1/2;0;1/2;0;0\n1;0;0;1;0\n;1/6;1/3;1/3;1/6\n";
    let cases = [
        ("latex.tex", latex.clone()),
        ("tabs.txt", array("\t", "\n")),
        ("semicolons.csv", array(";", "\n")),
        ("commas.csv", array(",", "\n")),
        ("square.csv", square.to_owned()),
        ("lines.txt", "0 1/2 1/2 1\n1/6 1/3 1/3 1/6\n1/2\n0 1/2\n0 0 1\n".to_owned()),
        ("commas.txt", "0,1/2,1/2,1\n1/6,1/3,1/3,1/6\n1/2\n0,1/2\n0,0,1\n".to_owned()),
        ("table.md", markdown("| c | A | | | |\n|---|---|---|---|---|\n", "")),
        ("fractions.tex", fractions(&latex)),
        ("fractions.md", fractions(&markdown("| c | A | | | |\n|---|---|---|---|---|\n", ""))),
        ("rows.md", markdown("", "")),
        ("prose.md", markdown("The classical method:\n\n| c | a1 | a2 | a3 | a4 |\n|---|---|---|---|---|\n", "b")),
        ("labels.tex", latex.replace("\\\\ \\hline\n & 1/6", "\\\\ \\hline\n$\\hat b$ & 1/6")),
    ];
    for (name, text) in cases {
        let (code, out, error) = judged(name, &text);
        assert!(code == 0 && out.contains("order 4; first failing tree"), "{name}: {out}{error}\n{text}");
        // A claim above it, and the place of a fault in it.
        let (code, out, error) = judged(name, &format!("order 5\n{text}"));
        assert!(code == 1 && out.contains("REFUTED order 5"), "{name}: {out}{error}");
        let (code, _, error) = judged(name, &text.replacen("1/3", "1/x", 1));
        assert!(code == 2 && error.contains("in `1/x`"), "{name}: {error}");
    }
    let (code, _, error) = judged("words.txt", "Butcher tableau of my method\n0 1\n");
    assert!(code == 2 && error.contains("rows of c_i and a_i1 a_i2"), "{error}");
}

/// A tank that is empty at t = 40, where the square root has no derivative.
#[test]
fn what_has_no_derivative_is_said_to_be_for_explicit_methods() {
    let model = file("tank.ds", "u_i { h = 1 } F_i { -0.05 * sqrt(max(h, 0)) }").display().to_string();
    let run = ["--model", &model, "--t-end", "60"];
    let (code, out, _) = verify(&[&["advise"][..], &run].concat());
    assert!(code == 3 && out.contains("An explicit method, as rk4, asks for no derivative"), "{out}");
    let solved = |method: &str| verify(&[&["solve"][..], &run, &["--h", "0.5", "--method", method]].concat());
    let (code, _, error) = solved("conventional");
    assert!(code == 0 && error.contains("neither of two solvers that choose their steps"), "{error}");
    let (code, _, error) = verify(&[&["order", "--method", "rk4", "--reference", "cvode"][..], &run].concat());
    assert!(!cfg!(feature = "cvode") || code == 3 && error.contains("`--reference diffsol` may go on"), "{error}");
}

#[test]
fn digits_may_stand_above_a_table() {
    let table = "0 0.333 0.667\n0.25 0 0.75\n0.333\n0 0.667\n";
    let (_, out, error) = judged("exact.txt", &format!("order 3\n{table}"));
    assert!(out.contains("REFUTED order 3"), "{out}{error}");
    for above in ["digits 3", "digits = 3", "# Heun\ndigits=3"] {
        let (code, out, error) = judged("above.txt", &format!("{above}\norder = 3\n{table}"));
        assert!(code == 0 && out.contains("confirmed order 3"), "{above}: {out}{error}");
    }
    let (code, _, error) = judged("many.txt", &format!("digits 99\n{table}"));
    assert!(
        code == 2 && error.contains(":1:8:") && error.contains("`digits` is a whole number from 1 to 60"),
        "{error}"
    );
}

/// 2/3 to three places is 0.667.
#[test]
fn a_repair_is_rounded_as_the_table_is() {
    let text = "order 3\ndigits 3\n0 0.333 0.667\n0.250 0 0.750\n0.333\n0 0.766\n";
    let (code, out, error) = judged("repair.txt", text);
    assert!(code == 1 && out.contains("a[3,2]: 0.766 → 0.667"), "{out}{error}");
    // 1 − 0.167 − 0.167 is 0.666, and within the digits of what 2/3 is printed as.
    let kutta = "order 3\ndigits 3\n0 0.5 1\n0.167 0.676 0.167\n0.5\n-1 2\n";
    let (code, out, error) = judged("kutta.txt", kutta);
    assert!(code == 1 && out.contains("b[2]: 0.676 → 0.667"), "{out}{error}");
}

#[test]
fn orders_beyond_those_of_trees_are_no_claims() {
    for (order, status) in [("20", 1), ("21", 2)] {
        let (code, out, error) = judged("order.toml", &RK4.replace("order = 4", &format!("order = {order}")));
        assert_eq!(code, status, "{out}{error}");
        let (code, out, error) =
            judged("claim.toml", &RK4.replace("order = 4", &format!("claims = [\"order {order}\"]")));
        assert_eq!(code, status, "{out}{error}");
    }
}

#[test]
fn all_stages_whose_times_are_wrong_are_named() {
    let (code, out, error) = judged("stages.toml", &RK4.replace("\"1/2\", \"1/2\", 1]\na", "\"1/3\", \"1/3\", 1]\na"));
    assert!(code == 1 && out.contains("the row sums of stages 2, 3, and the order"), "{out}{error}");
}

#[test]
fn cells_a_side_that_are_given_as_all_cells_get_a_hint() {
    let data = "n,u\n8,1.0156250\n16,1.0039062\n32,1.0009766\n64,1.0002441\n".to_owned();
    let path = file("cells.csv", &data).display().to_string();
    let order = |more: &[&str]| verify(&[&["order", "--data", &path, "--cells", "n"][..], more].concat());
    let hint = "if `n` counts the cells along a side and not all of them, `--dimension 1` has the spacing";
    for expect in [&["--expect", "2"][..], &[]] {
        let (_, out, error) = order(&[&["--dimension", "2"], expect].concat());
        assert!(out.contains(&format!("the order found is 2 times 2: {hint}")), "{out}{error}");
        let (code, out, _) = order(&[&["--dimension", "1"], expect].concat());
        assert!(code == 0 && !out.contains(hint), "{out}");
    }
    assert!(!order(&["--dimension", "2", "--expect", "4"]).1.contains(hint), "an order of four is what it should be");
}

/// Second order on 16, 8 and 4, and an iteration that was stopped too early on the finest grid.
#[test]
fn a_noisy_finest_grid_is_told_from_divergence() {
    let path = file("noisy.csv", "h,u\n16,3.5600\n8,1.6400\n4,1.1600\n2,1.0400\n1,1.2300\n").display().to_string();
    let (code, out, error) = verify(&["order", "--data", &path, "--step", "h", "--expect", "2"]);
    let said = "without the finest grid they converge, with order 2.00: noise or a standstill on that grid";
    assert!(code == 3 && out.contains(said), "{out}{error}");
    // Values that never settled have no grid to blame.
    let path = file("divergent.csv", "h,u\n8,1.00\n4,2.00\n2,4.00\n1,8.00\n").display().to_string();
    let (code, out, error) = verify(&["order", "--data", &path, "--step", "h", "--expect", "2"]);
    assert!(code == 1 && out.contains("convergence divergent") && !out.contains("noise"), "{out}{error}");
    // Refined the other way round they converge.
    let path = file("convergent.csv", "h,u\n1,1.00\n2,2.00\n4,4.00\n8,8.00\n").display().to_string();
    let (code, out, error) = verify(&["order", "--data", &path, "--step", "h", "--expect", "1"]);
    assert!(code == 0 && out.contains("convergence monotonic"), "{out}{error}");
}

/// Whole steps alone end within a step of the end, at a time that the rows name. A run that ends farther off is not the one that was
/// asked for.
#[test]
fn an_end_that_is_missed_is_named_and_by_a_step_or_more_is_no_pass() {
    let late = "while (t < T - 1e-9) { v = rk4(v, h); t += h; row() }";
    let early = "while (t + h < T + 1e-9) { v = rk4(v, h); t += h; row() }";
    let one_more = "while (t < T + h - 1e-9) { v = rk4(v, h); t += h; row() }";
    let one_less = "while (t + h < T - 1e-9) { v = rk4(v, h); t += h; row() }";
    for (name, body, status, said, other) in [
        ("late.awk", late, 0, "too late", "too early"),
        ("early.awk", early, 0, "too early", "too late"),
        ("more.awk", one_more, 3, "too late", "too early"),
        ("less.awk", one_less, 3, "too early", "too late"),
    ] {
        let Some(command) = program(name, body) else { return };
        for (kind, expect) in [("order", &["--expect", "4"][..]), ("judge", &["--expect", "4"]), ("order", &[])] {
            let (code, out, error) =
                verify(&[&[kind, "--problem", "logistic", "--program", &command], expect].concat());
            let all = format!("{out}{error}");
            assert!(code == status && all.contains("it ended at t =") && all.contains(said), "{name}: {all}");
            assert!(out.contains("the end is missed") == (status == 3) && !all.contains(other), "{name}: {all}");
        }
    }
}

#[test]
fn a_program_that_shows_the_end_alone_is_judged_by_it() {
    let body = "while (t < T - 1e-9) { d = t + h > T ? T - t : h; v = rk4(v, d); t += d } t = T; row()";
    let Some(command) = program("end.awk", body) else { return };
    let (code, out, error) = verify(&["order", "--problem", "logistic", "--program", &command, "--expect", "4"]);
    assert!(code == 0 && out.contains("PASS: order") && !out.contains("Note:"), "{out}{error}");
    // Beside other solvers it has no rows at their times, and nothing is told.
    let (code, out, error) = verify(&["compare", "--problem", "logistic", "--program", &command, "--expect", "4"]);
    assert!(
        code == 3 && flat(&out).contains("no row at t = 0.5, a multiple of its step h = 0.001953125"),
        "{out}{error}"
    );
}

#[test]
fn a_program_is_judged_on_the_steps_that_are_asked_for() {
    let Some(command) =
        program("steps.awk", "row(); while (t < T - 1e-9) { d = t + h > T ? T - t : h; v = rk4(v, d); t += d; row() }")
    else {
        return;
    };
    let judge = |more: &[&str]| {
        verify(&[&["judge", "--problem", "logistic", "--program", &command, "--expect", "4"][..], more].concat())
    };
    let (code, out, error) = judge(&["--coarsest", "0.1", "--points", "7"]);
    assert_eq!(code, 0, "{out}{error}");
    let (code, out, error) = judge(&["--points", "3"]);
    assert!(code == 3 && out.contains("3 usable of 3 points"), "{out}{error}");
    let (code, _, error) = judge(&["--coarsest", "5"]);
    assert!(code == 2 && error.contains("the coarsest step 5 is longer"), "{error}");
}

/// The numbers in JUnit and in JSON are those of the verdicts.
#[test]
fn what_is_written_counts_the_verdicts() {
    let path = file(
        "counted.toml",
        &RK4.replace("order = 4", "source = \"Kutta 1901\"\nclaims = [\"order 4\", \"order 5\", \"zero-stable\"]"),
    );
    let directory = scratch("strangers/report");
    let (code, out, error) =
        verify(&["judge", &path.display().to_string(), "--no-runs", "--out", &directory.display().to_string()]);
    assert!(code == 1 && out.contains("REFUTED order 5"), "{out}{error}");
    let read = |name: &str| fs::read_to_string(directory.join(name)).expect("written");
    let junit = read("junit.xml");
    // Two claims of an order, one that the kind is not judged by, and the sums of the rows.
    let counts = "tests=\"4\" failures=\"1\" errors=\"0\" skipped=\"1\"";
    assert!(junit.contains(&format!("<testsuite name=\"judge\" {counts}")), "{junit}");
    assert!(junit.contains("Measured 4. 9 of 17"), "{junit}");
    let ours = junit.split("</testsuite>").next().unwrap_or_default();
    assert_eq!(["<testcase", "<failure", "<skipped"].map(|tag| ours.matches(tag).count()), [4, 1, 1], "{junit}");
    let json: serde_json::Value = serde_json::from_str(&read("results.json")).expect("JSON");
    let shown = json.to_string();
    assert!(shown.contains("Kutta 1901") && shown.contains("What is true of this method?"), "{shown}");
    assert_eq!(["\"pass\"", "\"fail\""].map(|word| shown.contains(word)), [true; 2], "{shown}");
    let (_, out, _) = verify(&["judge", &path.display().to_string(), "--no-runs", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    let of = |outcome: &str| {
        json["verdicts"].as_array().expect("a list").iter().filter(|verdict| verdict["outcome"] == outcome).count()
    };
    assert_eq!([of("pass"), of("fail"), of("inconclusive")], [2, 1, 1], "{out}");
}

/// v̇ = v² from 1 has a pole at t = 1. Some methods fail there, others step over it.
#[test]
fn a_run_past_a_pole_is_warned_of() {
    let model = file("pole.ds", "u_i { v = 1 }\nF_i { v * v }\n").display().to_string();
    let solve = |method: &str, t_end: &str, more: &[&str]| {
        let line = ["solve", "--model", &model, "--method", method, "--h", "0.13", "--t-end", t_end];
        verify(&[&line[..], more].concat())
    };
    for (method, t_end) in [("method-i", "2"), ("rk4", "1.1")] {
        let (code, _, error) = solve(method, t_end, &[]);
        assert!(code == 0 && error.contains("with half the step it is another solution"), "{method}: {error}");
        let (_, out, error) = solve(method, t_end, &["--csv", "-"]);
        assert!(out.contains("# at t = ") && error.contains("pole"), "{method}: {out}");
    }
    let (code, _, error) = solve("rk4", "1.1", &["--no-estimate"]);
    assert!(
        code == 0 && error.contains("in the step to t = 1.04 the solution grows from 10.8821 to 598.459"),
        "{error}"
    );
    for (method, more) in [("rk4", &[][..]), ("method-i", &[]), ("rk4", &["--no-estimate"])] {
        let (code, _, error) = solve(method, "0.7", more);
        assert!(code == 0 && error.is_empty(), "{method}: {error}");
    }
}

/// Robertson's second component is 4e-5 at most: within a tolerance of 1e-3 it is negative, and from there the solution has a pole.
#[test]
fn a_tolerance_that_lets_a_component_lose_its_sign_is_named() {
    let solve = |atol: &str| {
        let line = ["solve", "--problem", "robertson", "--method", "radau-adaptive", "--no-estimate"];
        verify(&[&line[..], &["--t-end", "40", "--rtol", "1e-3", "--atol", atol]].concat())
    };
    let (code, _, error) = solve("1e-3");
    assert!(code != 0 && error.contains("lost its sign") && error.contains("smaller `--atol`"), "{error}");
    assert_eq!(solve("1e-6").0, 0);
}

/// An estimate means nothing beside the largest row, not beside the first or the last one.
#[test]
fn an_estimate_is_held_against_the_largest_row() {
    // The end of one, 1.5⁻²⁰, and the start of the other.
    for (name, sign, method, least) in [("decays", "-", "implicit-euler", 3.1e-4), ("grows", "", "rk4", 1.0)] {
        let model = file(&format!("{name}.ds"), &format!("u_i {{ v = 1 }}\nF_i {{ {sign}v }}\n")).display().to_string();
        let (code, out, error) =
            verify(&["solve", "--model", &model, "--method", method, "--h", "0.5", "--t-end", "10"]);
        let estimate =
            out.split("largest estimate ").nth(1).and_then(|rest| rest.split(' ').next()).expect("an estimate");
        assert!(estimate.parse::<f64>().expect("a number") > least, "{name} does not tell the rows apart: {out}");
        assert!(code == 0 && error.is_empty(), "{name}: {error}");
    }
}

/// The implicit midpoint rule with a stage twice, and with one that nothing depends on: the conditions hold of the rule itself.
#[test]
fn a_method_with_stages_that_it_does_not_need_is_judged_without_them() {
    let twice = "a = [[\"1/2\", 0], [\"1/4\", \"1/4\"]]\nb = [\"1/2\", \"1/2\"]\n";
    let unused = "a = [[-1, 0], [0, \"1/2\"]]\nb = [0, 1]\n";
    let claims = "order = 2\nclaims = [\"symplectic\", \"symmetric\", \"algebraically stable\"]\n";
    for (text, why) in [(twice, "stages 1, 2 are equal"), (unused, "stage 1 has no influence")] {
        let (code, out, error) = judged("reducible.toml", &format!("{claims}{text}"));
        assert!(code == 0 && out.contains(&format!("{why}: judged on the 1 stage")), "{out}{error}");
    }
}

/// Weights cut off after six places: no single coefficient is wrong.
#[test]
fn decimals_that_were_cut_off_are_told() {
    let table = |weights: &str| format!("order 4\n0 |\n0.5 | 0.5\n0.5 | 0 0.5\n1 | 0 0 1\n | {weights}\n");
    let (code, out, error) = judged("cut.txt", &table("0.166666 0.333333 0.333333 0.166666"));
    let told = out.contains("cut off, not rounded") && out.contains("have order 4");
    assert!(code == 1 && told && out.contains("add up to 0.999998") && !out.contains("change"), "{out}{error}");
    let (code, out, error) = judged("rounded.txt", &table("0.166667 0.333333 0.333333 0.166667"));
    assert!(code == 0 && !out.contains("cut off"), "{out}{error}");
    // A wrong digit is no cut.
    let (code, out, error) = judged("wrong.txt", &table("0.166667 0.333333 0.333333 0.166676"));
    assert!(code == 1 && !out.contains("cut off") && out.contains("b[4]: 0.166676 → 0.166667"), "{out}{error}");
}

/// No label is wrong about a row sum.
#[test]
fn a_wrong_node_alone_puts_no_blame_on_the_label() {
    let (code, out, error) = judged("node.toml", &RK4.replacen("c = [0, \"1/2\"", "c = [0, \"1/3\"", 1));
    assert!(code == 1 && out.contains("A coefficient is wrong") && !out.contains("label"), "{out}{error}");
}

/// What a file denies itself is no second fault.
#[test]
fn a_method_that_is_said_not_to_be_zero_stable_passes_with_that() {
    let text =
        |claim: &str| format!("kind = \"multistep\"\nclaims = [\"{claim}\"]\nrho = [-5, 4, 1]\nsigma = [2, 4, 0]\n");
    let (code, out, error) = judged("denied.toml", &text("not zero-stable"));
    assert!(code == 0 && !out.contains("REFUTED"), "{out}{error}");
    let (code, out, error) = judged("claimed.toml", &text("zero-stable"));
    assert!(code == 1 && out.contains("convergence"), "{out}{error}");
}

/// 1 is a refutation, and a full disk refutes nothing.
#[test]
#[cfg(unix)]
fn output_that_cannot_be_written_is_bad_input() {
    let data = file("values.csv", "h,u\n0.4,1.16\n0.2,1.04\n0.1,1.01\n0.05,1.0025\n").display().to_string();
    let in_the_way = file("in-the-way", "").display().to_string();
    let picture = format!("{in_the_way}/p.svg");
    let order = ["order", "--data", &data, "--step", "h", "--expect", "2"];
    assert_eq!(verify(&order).0, 0);
    let cases: [&[&str]; 3] = [
        &["judge", "rk4", "--no-runs", "--out", &in_the_way],
        &[&order[..], &["--picture", &picture]].concat(),
        &["solve", "--problem", "logistic", "--method", "rk4", "--h", "0.1", "--t-end", "1", "--csv", &picture],
    ];
    for arguments in cases {
        let (code, out, error) = verify(arguments);
        assert!(code == 2 && error.contains("cannot write"), "{arguments:?}: {code} {out}{error}");
    }
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full");
    let Ok(full) = full else { return };
    let mut command = Command::new(env!("CARGO_BIN_EXE_verify"));
    let status = command.args(["list", "problems"]).stdout(full).stderr(std::process::Stdio::null()).status();
    assert_eq!(status.expect("it starts").code(), Some(2));
}

/// Gauss' formulas of six stages: conditions are made up to order 10, and Butcher's theorem has the rest.
#[test]
fn an_order_beyond_the_conditions_follows_from_the_simplifying_assumptions() {
    let text = include_str!("gauss6.toml");
    let (code, out, error) = judged("gauss6.toml", text);
    assert!(code == 0 && out.contains("B(12), C(6) and D(6) hold, from which order 12 follows"), "{out}{error}");
    assert!(!out.contains("DIAGNOSIS"), "{out}");
    for wrong in ["order=11", "order=13"] {
        let (code, out, error) = judged("gauss6-label.toml", &text.replace("order=12", wrong));
        assert!(code == 1 && out.contains("REFUTED order"), "{wrong}: {out}{error}");
    }
}

/// Four digits tell that the error of the phase begins with the fifth power, two do not.
#[test]
fn an_order_of_dispersion_is_told_where_the_digits_determine_it() {
    let text = "digits = 4\norder = 3\nclaims = [\"dispersion order 4\"]\nc = [\"0.4359\", \"0.7179\", \"1\"]\n\
                a = [[\"0.4359\"], [\"0.2821\", \"0.4359\"], [\"1.2085\", \"-0.6444\", \"0.4359\"]]\n\
                b = [\"1.2085\", \"-0.6444\", \"0.4359\"]\n";
    let (code, out, error) = judged("alexander3.toml", text);
    assert!(code == 0 && out.contains("dispersion of order 4 (constant -1.54e-2)"), "{out}{error}");
    let (code, out, error) = judged("alexander3-2.toml", &text.replace("dispersion order 4", "dispersion order 2"));
    assert!(code == 1 && out.contains("REFUTED dispersion order 2"), "{out}{error}");
    let few = "digits = 2\nclaims = [\"dispersion order 4\"]\na = [[\"0.44\"], [\"0.28\", \"0.44\"], [\"1.21\", \"-0.64\", \"0.44\"]]\n\
               b = [\"1.21\", \"-0.64\", \"0.44\"]\n";
    let (code, out, error) = judged("alexander3-3.toml", few);
    assert!(code == 3 && out.contains("too few digits") && !out.contains("at all"), "{out}{error}");
}

/// A zero that should be a small decimal: what is proposed is what mends.
#[test]
fn a_small_decimal_is_proposed_at_its_size() {
    let text = "digits = 4\norder = 3\nc = [\"0.4359\", \"0.7179\", \"1\"]\n\
                a = [[\"0.4359\"], [\"0.2812\", \"0.4359\"], [\"1.2085\", \"-0.6444\", \"0.4359\"]]\n\
                b = [\"1.2085\", \"-0.6444\", \"0.4359\"]\n";
    let (code, out, error) = judged("alexander3-typo.toml", text);
    assert!(code == 1 && out.contains("a[2,1]: 0.2812 → 0.282"), "{out}{error}");
    assert!(out.contains("a[2,3]: 0 → 0.0008, mends") && out.contains("couples stages that are not"), "{out}");
}

/// A program that breaks off in fine steps has no coarse steps to leave out.
#[test]
fn runs_that_fail_in_fine_steps_are_not_unstable_ones() {
    let Some(own) =
        program("breaks", "if (h < 0.05) exit 3; while (t < T - h / 2) { row(); v = rk4(v, h); t += h } row()")
    else {
        return;
    };
    let (code, out, error) = verify(&["order", "--problem", "logistic", "--program", &own, "--expect", "4"]);
    assert!(code == 3 && !out.contains("unstable") && out.contains(" 0.200000 "), "{out}{error}");
    assert!(out.contains("exit status: 3"), "{out}");
}

/// A program that prints 1 + dx² as `%.15g` does, with as many digits as it takes, for the dx or the cells that `--set` gives it.
fn refined(name: &str, cells: &str) -> Option<String> {
    program(
        name,
        &format!(
            r#"for (i = 1; i < ARGC; i++) if (ARGV[i] == "--set") {{ split(ARGV[i + 1], pair, "="); n = pair[2] }}
            dx = pair[1] == "dx" ? n : 1 / n
            {cells}
            print "0,1"; printf "1,1\n2,%.15g\n", 1 + dx * dx"#
        ),
    )
}

#[test]
fn whole_numbers_count_cells_and_others_are_spacings() {
    let Some(command) = refined("spacing.awk", "") else { return };
    for grids in ["dx=0.1,0.05,0.025,0.0125", "dx=0.25,0.5,1,0.125", "cells=10,20,40,80"] {
        let (code, out, error) =
            verify(&["order", "--program", &command, "--quantity", "v", "--refine", grids, "--expect", "2"]);
        assert!(code == 0 && out.contains("order 2.000"), "{grids}: {out}{error}");
        // The longest number tells what all are printed to.
        assert!(grids.contains("0.5,1") || out.contains("it prints 9 significant digits"), "{out}");
    }
}

#[test]
fn a_run_that_fails_on_one_grid_leaves_the_others_on_view() {
    let Some(command) = refined("fails.awk", "if (n == 40) { print \"no memory\" > \"/dev/stderr\"; exit 1 }") else {
        return;
    };
    let line = ["order", "--program", &command, "--quantity", "v", "--expect", "2"];
    let run = |grids: &str| verify(&[&line[..], &["--refine", grids]].concat());
    let (code, out, error) = run("cells=10,20,40,80");
    assert!(code == 3 && out.contains("1.00015625") && out.contains("the run with cells=40: "), "{out}{error}");
    let (code, _, error) = run("cells=40");
    assert!(code == 3 && error.contains("with cells=40") && error.contains("no memory"), "{error}");
}

#[test]
fn a_parameter_that_changes_nothing_is_named() {
    let Some(command) = refined("ignores.awk", "dx = 0.1") else { return };
    let (code, out, _) = verify(&["order", "--program", &command, "--quantity", "v", "--refine", "cells=10,20,40"]);
    assert!(code == 3 && out.contains("the program does not use cells"), "{out}");
}

/// Heun's method, of order 2, with a row at the start and one at the end: there is no first step to be seen.
#[test]
fn rows_at_the_ends_alone_tell_nothing_of_a_first_step() {
    let body = "n = int(T / h + 0.5); row(); for (k = 0; k < n; k++) { a = f(v); v += h / 2 * (a + f(v + h * a)) } t = T; row()";
    let Some(command) = program("ends.awk", body) else { return };
    let line = ["order", "--program", &command, "--quantity", "v", "--h", "0.1,0.05,0.025,0.0125", "--t-end", "2"];
    let (code, out, error) = verify(&[&line[..], &["--expect", "3"]].concat());
    assert!(code == 1 && !out.contains("starting procedure"), "{out}{error}");
}

/// A run that takes longer than it may will not be shorter in smaller steps.
#[test]
#[cfg(unix)]
fn a_program_that_hangs_is_waited_for_once() {
    let starts = file("starts.txt", "");
    let command = format!("sh -c 'echo >> {}; sleep 20'", starts.display());
    let (code, out, error) = verify(&["order", "--problem", "logistic", "--program", &command, "--time-limit", "1"]);
    assert!(code == 3 && out.contains("1 s"), "{out}{error}");
    assert_eq!(fs::read_to_string(&starts).expect("it is started").lines().count(), 1);
}

#[test]
fn what_is_no_answer_to_a_question_is_refused() {
    let data = file("two.csv", "h,u\n0.1,3.01\n0.05,3.0025\n").display().to_string();
    for (line, hint) in [
        (vec!["compare", "--problem", "logistic", "--t-end", "7"], "--t-end needs --model"),
        (vec!["order", "--data", &data, "--step", "h", "--exact", "nan"], "finite number"),
        (vec!["order", "--data", &data, "--step", "h", "--picture", "p.png"], "SVG"),
        (vec!["order", "--problem", "logistic", "--program", "true", "--t-end", "0"], "positive number"),
        (vec!["order", "--data", &data], "the columns are `h`, `u`"),
    ] {
        let (code, out, error) = verify(&line);
        assert!(code == 2 && error.contains(hint), "{line:?}: {out}{error}");
    }
    let (code, out, _) = verify(&["order", "--data", &data, "--step", "h", "--exact", "3"]);
    assert!(code == 3 && out.contains("two grids have an order against the exact value"), "{out}");
}

/// Celik et al. (2008), Table 1, third column: p = 1.51, limit 6.0269, index 0.5 %, which the values do not follow.
#[test]
fn values_that_alternate_have_the_formal_order_of_the_procedure_and_no_verdict() {
    let table = "cells,phi\n18000,6.0042\n4500,5.9624\n980,6.0909\n";
    let path = file("celik3.csv", table).to_string_lossy().into_owned();
    let options = ["--cells", "cells", "--dimension", "2", "--expect", "1.5"];
    let (code, out, error) = verify(&[&["order", "--data", &path], &options[..]].concat());
    assert!(code == 3 && out.contains("p = 1.508, limit 6.0268737, GCI 0.472 %"), "{out}{error}");
    let (_, out, _) = verify(&[&["order", "--data", &path, "--format", "json"], &options[..]].concat());
    let json: serde_json::Value = serde_json::from_str(&out).expect(&out);
    assert!(json["order"].is_null() && json["gci_fine"].is_null() && json["celik"]["formal"] == true, "{out}");
    let near = |key: &str, printed: f64| (json["celik"][key].as_f64().expect(key) - printed).abs();
    assert!(near("order", 1.51) < 0.005 && near("limit", 6.0269) < 5e-5 && near("gci_fine", 0.005) < 5e-4, "{out}");
}

#[test]
fn a_table_is_read_from_standard_input() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_verify"))
        .args(["order", "--data", "-", "--step", "h", "--expect", "2"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("it starts");
    child.stdin.take().expect("a pipe").write_all(b"h,q\n1,2\n0.5,1.25\n0.25,1.0625\n").expect("it reads");
    let out = child.wait_with_output().expect("it ends");
    let text = String::from_utf8_lossy(&out.stdout);
    assert!(out.status.success() && text.contains("extrapolated   1.0000000"), "{text}");
}

/// A spreadsheet of a country with decimal commas, and the quotients of a language with rational numbers.
#[test]
fn decimal_commas_and_double_slashes_are_read() {
    let commas =
        "order 4\ndigits 5\n0;0;0;0;0\n0,5;0,5;0;0;0\n0,5;0;0,5;0;0\n1;0;0;1;0\n;0,16667;0,33333;0,33333;0,16667\n";
    let (code, out, error) = judged("commas.csv", commas);
    assert!(code == 0 && out.contains("confirmed order 4"), "{out}{error}");
    let slashes = "order 4\n0 |\n1//2 | 1//2\n1//2 | 0 1//2\n1 | 0 0 1\n | 1//6 1//3 1//3 1//6\n";
    let (code, out, error) = judged("slashes.txt", slashes);
    assert!(code == 0 && out.contains("confirmed order 4"), "{out}{error}");
    // Commas between numbers without a semicolon are no decimal ones.
    let (code, out, error) = judged("lists.txt", "0,1\n1/2,1/2\n1\n");
    assert!(code == 0 && out.contains("order 2;"), "{out}{error}");
    let (code, _, error) = judged("short.txt", "0\n1/2 1/2\n1/2 0 1/2\n1 0 0\n1/6 1/3 1/3 1/6\n");
    assert!(code == 2 && error.contains("a first line of 1 number and a second of 2"), "{error}");
}

/// Wrong stage times lower the order in time alone, and the note says so.
#[test]
fn a_file_whose_stage_times_are_wrong_is_told_that_its_order_in_time_is_lower() {
    let text = "order = 4\nc = [0, \"1/2\", \"1/2\", \"3/4\"]\na = [[], [\"1/2\"], [0, \"1/2\"], [0, 0, 1]]\n\
                b = [\"1/6\", \"1/3\", \"1/3\", \"1/6\"]\n";
    let path = file("times.toml", text).to_string_lossy().into_owned();
    let (code, out, error) =
        verify(&["order", "--problem", "prothero-robinson", "--set", "lambda=2", "--method", &path]);
    assert!(
        code == 1 && out.contains("its coefficients have order 4, but with its c the order on v̇ = f(t, v) is"),
        "{out}{error}"
    );
}

/// A ladder that ends before the slopes settle can be made finer, and how is said.
#[test]
fn a_ladder_that_ends_too_soon_is_told_how_to_go_on() {
    let ladder = ["order", "--problem", "van-der-pol", "--method", "rk4", "--coarsest", "0.4", "--points", "5"];
    let (code, out, error) = verify(&ladder);
    assert!(code == 3 && out.contains("hint: `--coarsest` starts the ladder at a smaller step"), "{out}{error}");
    let (code, out, error) = verify(&["order", "--problem", "van-der-pol", "--method", "rk4"]);
    assert!(code == 0 && !out.contains("hint:"), "{out}{error}");
}

/// p₁ = −p₀/(1 + z) is a closure of order 2 that a step backwards does not undo.
#[test]
fn a_closure_of_functions_is_looked_at_for_its_symmetry() {
    let text = "kind = \"closure\"\norder = 2\nclaims = [\"symmetric\"]\nrate = 1\nalpha = \"-1/(1+z)\"\nbeta = 1\n";
    let (code, out, error) = judged("one-sided.toml", text);
    assert!(code == 1 && out.contains("REFUTED symmetric: |α| = 0.999900 and |β| = 1.000000"), "{out}{error}");
    let (code, out, error) =
        judged("both-sided.toml", &text.replace("-1/(1+z)", "-1").replace("beta = 1", "beta = \"1 + 0*z\""));
    assert!(code == 3 && out.contains("inconclusive symmetric: |α| = |β| at 201 values"), "{out}{error}");
}

/// The rows of a run.
fn rows(name: &str, arguments: &[&str]) -> Vec<Vec<f64>> {
    let path = file(name, "").display().to_string();
    let (status, _, errors) = verify(&[&["solve", "--csv", &path], arguments].concat());
    assert_eq!(status, 0, "{name}: {errors}");
    let text = fs::read_to_string(&path).expect("written");
    let rows = text.lines().skip(1).filter(|line| !line.starts_with('#'));
    rows.map(|line| line.split(',').map(|x| x.parse().unwrap_or(f64::NAN)).collect()).collect()
}

/// α/β is what R tends to for z → −∞.
#[test]
fn a_closure_of_functions_with_the_larger_part_at_the_start_is_not_a_stable() {
    let text = "kind = \"closure\"\nclaims = [\"A-stable\"]\nrate = 1\nalpha = \"-1.0005 + 0*z\"\nbeta = 1\n";
    let (code, out, error) = judged("larger.toml", text);
    assert!(code == 1 && out.contains("REFUTED A-stable"), "{out}{error}");
    let (code, out, error) = judged("smaller.toml", &text.replace("1.0005", "0.9995"));
    assert!(code != 1 && !out.contains("REFUTED"), "{out}{error}");
}

/// The second run's estimates and the steps are those of the tolerances as they are held, one for all components or one for each.
#[test]
fn tolerances_of_each_component_are_held_strictly_too() {
    let steps = |more: &[&str]| {
        let run =
            ["--problem", "robertson", "--method", "radau-adaptive", "--t-end", "40", "--atol", "1e-6,1e-10,1e-6"];
        rows("robertson.csv", &[&run[..], more].concat()).len()
    };
    assert!(steps(&["--strict"]) > steps(&[]));
}

/// What `solve` says on standard error of a model, its run being without an error.
fn warned(name: &str, model: &str, arguments: &[&str]) -> String {
    let path = file(&format!("{name}.ds"), model).display().to_string();
    let (status, _, errors) = verify(&[&["solve", "--model", &path], arguments].concat());
    assert_eq!(status, 0, "{name}: {errors}");
    errors
}

/// Of what the equation itself lets grow, at a rate of 0.1 at most, a step of 0.5 makes e^0.05: a dose makes seventy of it, and no pole.
#[test]
fn growth_by_forcing_is_not_taken_for_a_pole() {
    let model = "u_i { c = 0, p = 0 } F_i { exp(-0.5*(t - 20)*(t - 20)) - 0.4*c + 0.2*p, 0.3*c - 0.2*p }";
    let said = warned("dose", model, &["--method", "tr-bdf2", "--h", "0.5", "--t-end", "30"]);
    assert!(!said.contains("the solution grows from"), "{said}");
}

/// v̇ = x − v² from v = 0, where f does not change with v: the condition Jᵀ(r₀ + r₁) = 0 would hold v there.
#[test]
fn a_component_that_a_closure_would_hold_at_its_start_is_refused_on_every_path() {
    let model = "u_i { x = 1, y = 0 } F_i { -x, x - y*y }";
    let steps = ["--h", "0.01", "--t-end", "2", "--method"];
    assert_eq!(warned("held", model, &[&steps[..], &["method-i"]].concat()), "");
    let path = file("held.ds", model).display().to_string();
    for method in ["method-ii", "ls-galerkin(1,lobatto,2,ii)"] {
        let (status, _, errors) = verify(&[&["solve", "--model", &path][..], &steps, &[method]].concat());
        assert!(status == 1 && flat(&errors).contains("determines no next state"), "{method}: {errors}");
    }
}

#[test]
fn a_component_that_stays_at_its_start_is_named() {
    // A fast component is at rest beside where f would move it fast, and what turns is back at the end of each step.
    let resting = "u_i { x = 1, y = 0 } F_i { -x, 1e14*(1e-9*sin(x) - y) }";
    assert_eq!(warned("slaved", resting, &["--method", "implicit-euler", "--h", "0.1", "--t-end", "1"]), "");
    // A step of 10⁸ turns leaves almost what it found, and a short one does not.
    let fast = "u_i { x = 1, y = 0 } F_i { 1e9*y, -1e9*x }";
    let said = warned("fast", fast, &["--method", "implicit-midpoint", "--h", "0.1", "--t-end", "2"]);
    assert!(said.contains("y stays at") && said.contains("a step below 7.07107e-10 moves it"), "{said}");
    let turning = "u_i { x = 1, y = 0 } F_i { -x, cos(2*3.141592653589793*200*t) }";
    assert!(!warned("turning", turning, &["--method", "rk4", "--h", "0.005", "--t-end", "1"]).contains("stays"));
    for swaying in
        ["x = 1 } F_i { cos(2*3.141592653589793*t) }", "x = 0, y = 1 } F_i { cos(2*3.141592653589793*t), -y }"]
    {
        let steps = ["--method", "trapezoidal", "--h", "0.5", "--t-end", "4"];
        assert!(!warned("swaying", &format!("u_i {{ {swaying}"), &steps).contains("warning:"));
    }
}

#[test]
fn a_run_that_stays_beside_an_unstable_rest_is_named() {
    let model = "in_i { y0 = 1e-10 } u_i { x = 1, y = y0 } F_i { x*(1-x-2*y), y*(1.5 - y - 0.5*x) }";
    let run = |y0: &str| {
        let set = format!("y0={y0}");
        warned("competitors", model, &["--set", &set, "--method", "radau-adaptive", "--t-end", "1e5"])
    };
    assert!(
        run("1e-10").contains("stays where it starts, beside a state of rest that is unstable"),
        "{}",
        run("1e-10")
    );
    // At the rest itself the solution stays for good.
    assert!(!run("0").contains("stays"), "{}", run("0"));
}

/// What has gone on to 10¹¹, in a last step that is cut, or in each, has not stayed anywhere.
#[test]
fn a_run_beyond_a_pole_is_not_said_to_stay() {
    let blow = "u_i { x = 1 } F_i { x*x }";
    for (h, end) in [("0.4", "1.5"), ("1", "2")] {
        let said = warned("beyond", blow, &["--method", "rk4", "--h", h, "--t-end", end]);
        assert!(said.contains("warning") && !said.contains("stays"), "{said}");
    }
}

/// Where h λ = 1 implicit Euler, by which differences of two quadratures are carried on, is singular.
#[test]
fn a_rate_that_grows_steadily_in_time_is_not_said_to_be_fast() {
    let canard = "u_i { x = 1 } F_i { (t - 10)*x + 1e-12 }";
    for method in ["rk4", "method-i", "ls-galerkin(2,radau,2)"] {
        let said = warned("canard", canard, &["--method", method, "--h", "0.1", "--t-end", "21"]);
        assert!(!said.contains("faster than the steps"), "{said}");
    }
}

#[test]
fn a_step_that_amplifies_what_the_equation_damps_is_named() {
    let model = "in_i { k = 200 } u_i { x = 0, y = 1, z = 0.5 } F_i { -x + k*y, -1.1*y + k*z, -1.3*z }";
    let run = |k: &str, method: &str, h: &str| {
        let set = format!("k={k}");
        warned("non-normal", model, &["--set", &set, "--method", method, "--h", h, "--t-end", "2"])
    };
    assert!(
        run("200", "method-i", "0.1").contains("where its eigenvalues alone would make that"),
        "{}",
        run("200", "method-i", "0.1")
    );
    assert_eq!(run("200", "bdf2", "0.1"), "");
    assert_eq!(run("0.2", "method-i", "0.1"), "");
    // rk4 beyond its limit of stability, 2.785.
    assert!(
        !run("0.2", "rk4", "2").contains("warning:")
            && warned("decay", "u_i { x = 1 } F_i { -2*x }", &["--method", "rk4", "--h", "1.5", "--t-end", "6"])
                .contains("multiply a perturbation by 1.375")
    );
}

/// The Jacobian of a chain is triangular, and its eigenvalues are all −50: |R(−2.5)| = 0.65.
#[test]
fn a_chain_of_equal_rates_is_not_said_to_be_amplified() {
    let said = warned("chain", CHAIN, &["--method", "rk4", "--h", "0.05", "--t-end", "40"]);
    assert!(!said.contains("multiply a perturbation"), "{said}");
    // R(−3) = 1 − 3 + 9/2 − 27/6 + 81/24.
    let said = warned("chain", CHAIN, &["--method", "rk4", "--h", "0.06", "--t-end", "2.4"]);
    assert!(said.contains("multiply a perturbation by 1.37500 each"), "{said}");
}

/// Compartments that the one before feeds alone.
const CHAIN: &str =
    "d_ij { (0..30,0..30): -50, (1..30,0..29): 50 } u_i { (0:1): a = 1, (1:30): c = 0 } p_i { d_ij * u_j } F_i { p_i }";

/// Upwind differences of an inflow sin 2t.
const INFLOW: &str = "d_ij { (0..50,0..50): -1, (1..50,0..49): 1 } src_i { (0:1): 1, (1:50): 0 } u_i { (0:50): c = 0 } p_i { d_ij * u_j } \
                      F_i { 50 * p_i + 50 * src_i * sin(2*t) }";

/// RK4 damps −50 up to h = 2.785/50, 18 steps in a unit of time.
#[test]
fn the_rates_of_a_chain_are_those_of_its_diagonal() {
    for (name, model) in [("rates-of-chain", CHAIN), ("rates-of-inflow", INFLOW)] {
        let model = file(&format!("{name}.ds"), model).display().to_string();
        let (code, out, error) = verify(&["advise", "--model", &model, "--t-end", "1"]);
        let said = ["its fastest rate is 50.0,", "rk4 is stable with 18 equal steps", "spectral -50)"];
        assert!(code == 0 && said.iter().all(|said| out.contains(said)), "{name}: {out}{error}");
    }
}

/// While y rests at 0 both tolerances lead to the same steps, and there is no estimate; across the jump the estimate is the error.
#[test]
fn a_jump_that_the_estimate_of_an_adaptive_method_sees_is_not_said_to_be_missed() {
    let late = "u_i { y = 0 } F_i { -1e4*(y - t*heaviside(t-0.5)) }";
    for tolerance in ["1e-6", "1e-8"] {
        let tolerances = ["--rtol", tolerance, "--atol", tolerance];
        let said = warned("late", late, &[&["--method", "radau-adaptive", "--t-end", "1"][..], &tolerances].concat());
        assert!(!said.contains("faster than the steps"), "{tolerance}: {said}");
    }
}

/// Runs of a chaotic solution are as far apart as it is large, and by which order they differ is chance.
#[test]
fn an_estimate_of_chaos_is_coarse() {
    let lorenz = "u_i { x = 1, y = 1, z = 1 } F_i { 10*(y-x), x*(28-z)-y, x*y-8/3*z }";
    let said = warned("lorenz", lorenz, &["--method", "tr-bdf2", "--h", "0.05", "--t-end", "15"]);
    assert!(said.contains("the estimate is coarse"), "{said}");
}

/// With h = 2 each step looks at cos 2πt where it is 1, and so do those of h = 1.
#[test]
fn steps_that_see_one_phase_of_what_is_periodic_are_named() {
    let model = "u_i { x = 1 } F_i { -0.01*x + cos(2*3.141592653589793*t) }";
    let run = |h: &str| warned("season", model, &["--method", "method-i", "--h", h, "--t-end", "400"]);
    assert!(run("2").contains("f changes in time faster than the steps"), "{}", run("2"));
    assert_eq!(run("0.05"), "");
    // A force of size 1000 that a stiff component forgets at once.
    let stiff = "u_i { x = 0 } F_i { 1000*(sin(t) - x) + cos(t) }";
    assert_eq!(warned("forgets", stiff, &["--method", "method-i", "--h", "0.5", "--t-end", "5"]), "");
}

/// A long step may cross zero up and have turned down again: what f is at its ends tells nothing of the way.
#[test]
fn a_zero_that_is_crossed_on_the_way_up_is_not_named() {
    let model = "u_i { x = 1, y = 0 } F_i { y, -x - 0.2*y + 3*cos(2*t) }";
    for rtol in ["1e-3", "1e-4", "1e-5"] {
        assert_eq!(
            warned("turns", model, &["--method", "radau-adaptive", "--rtol", rtol, "--t-end", "100"]),
            "",
            "{rtol}"
        );
    }
}

/// A step of high order goes round several times: on a straight line from its start to its end f points back, on the way it does not.
#[test]
fn a_zero_that_a_long_step_crosses_as_the_solution_does_is_not_named() {
    for (rtol, t_end) in [("1e-3", "20"), ("1e-3", "50"), ("1e-5", "50")] {
        let line = format!("solve --problem non-normal --method radau-adaptive --rtol {rtol} --t-end {t_end}");
        let (status, _, errors) = verify(&line.split(' ').collect::<Vec<_>>());
        assert_eq!((status, &*errors), (0, ""), "{line}");
    }
}

/// A dose of a twentieth of a unit of time between the nodes of steps of h and h/2, which both leave the solution at 0.
#[test]
fn a_pulse_that_steps_pass_over_is_named() {
    let model = "u_i { x = 0 } F_i { 100*heaviside(t - 7.31)*heaviside(7.36 - t) - x }";
    let run = |rest: &[&str]| warned("pulse", model, &[rest, &["--t-end", "10"]].concat());
    for method in ["implicit-euler", "method-i", "rk4", "ls-galerkin(3,gauss,3)"] {
        let said = run(&["--method", method, "--h", "0.5"]);
        assert!(said.contains("f changes in time faster than the steps"), "{method}: {said}");
    }
    assert_eq!(run(&["--method", "method-i", "--h", "0.005"]), "");
    assert_eq!(run(&["--method", "radau-adaptive", "--h", "0.02"]), "");
}

/// Days and nights, a dose that ends with a step, and what turns 318 times a unit of time: quadratures of f have no say where another run comes
/// to the same rows, within the estimate.
#[test]
fn rows_that_another_run_comes_to_are_not_doubted_for_what_f_does_between_them() {
    let light =
        "u_i { x = 0, y = 0 } li { heaviside(sin(0.2617993877991494*t)) } F_i { li*(1 - x) - 0.3*x, 0.1*x - 0.05*y }";
    assert_eq!(warned("light", light, &["--method", "rk4", "--h", "0.48", "--t-end", "96"]), "");
    let dose = "u_i { g = 0, c = 0 } F_i { 100*heaviside(0.5 - t) - 1.2*g, 1.2*g - 0.2*c }";
    let radau = ["--method", "ls-galerkin(2,radau,2)", "--h", "0.05", "--t-end", "24"];
    assert_eq!(warned("dose", dose, &radau), "");
    let fast = "u_i { x = 0 } F_i { -x + 50*sin(2000*t) }";
    let adaptive = ["--method", "radau-adaptive", "--rtol", "3.16e-3", "--atol", "3.16e-3", "--t-end", "10"];
    assert_eq!(warned("fast", fast, &adaptive), "");
}

/// A pump that is switched over at the end of a step: with half of the step the error is as large, but for a step that ends there.
#[test]
fn a_jump_that_two_runs_meet_alike_is_in_the_estimate() {
    let laser = "u_i { n = 3, ph = 1e-9 } loss { 6 - 5*heaviside(t - 20) }
                 F_i { 0.05*(3 - n) - n*ph*0.05, (n - loss)*ph + 1e-9*n }";
    let model = file("laser.ds", laser).display().to_string();
    let known = ["--method", "radau-adaptive", "--rtol", "1e-10", "--atol", "1e-14", "--strict", "--t-end", "31.5"];
    let [known, found] = [&known[..], &["--method", "rk4", "--h", "0.5", "--t-end", "31.5"]]
        .map(|run| rows("laser.csv", &[&["--model", &model], run].concat()).pop().expect("a row"));
    let error = (found[1] - known[1]).abs().max((found[2] - known[2]).abs());
    assert!(error > 0.1 && found[3] >= 0.9 * error, "{found:?} for {known:?}");
}

/// A stiff system of two unknowns side by side so many times: what warns of it does not end with the unknowns that derivatives are looked at of,
/// and where nothing is asked any more that is said.
#[test]
fn what_is_not_looked_at_on_large_models_is_said() {
    let said = |n: usize| {
        let model = format!(
            "u_i {{ (0:{n}): x = 2, ({n}:{m}): y = 3 }} g_i {{ x_i*x_i/(1+x_i*x_i) }} d_i {{ 2*x_i*x_i/pow(1+x_i*x_i,2) }} \
             F_i {{ -x_i, -500*(y_i - g_i) - d_i }}",
            m = 2 * n
        );
        warned("davis", &model, &["--method", "method-i", "--h", "0.05", "--t-end", "4"])
    };
    let tells = |said: &str| [said.contains("warning:"), said.contains("solvers that choose their steps")];
    assert!(said(32).contains("warning:"));
    let of_66 = said(33);
    assert_eq!(tells(&of_66), [true, true], "{of_66}");
    assert!(of_66.contains("note: of 66 unknowns, more than 64, no derivatives are looked at"), "{of_66}");
    let of_300 = said(150);
    assert!(of_300.contains("nor are errors that other solvers tell"), "{of_300}");
}

/// The autocatalyst is a part of 10⁻¹² at first, which the first step of implicit Euler takes to its end.
#[test]
fn what_grows_from_next_to_nothing_is_followed_in_units_of_its_own() {
    let model = "u_i { a = 1, b = 1e-12 } F_i { -1000*a*b, 1000*a*b - b }";
    for t_end in ["0.05", "1", "5"] {
        let said = warned("autocat", model, &["--method", "implicit-euler", "--h", "0.0129", "--t-end", t_end]);
        assert!(said.contains("by two solvers that choose their steps"), "{t_end}: {said}");
    }
}

/// Carriers and photons of a laser, 10²⁴ and 10²¹ of them, within 5 ns: the run is far off in its first steps, which are of 10⁻¹⁰ s.
#[test]
fn units_may_be_of_any_size() {
    let laser = "u_i { n = 1e24, s = 1e15 } g { 1.5e-12*(n - 1e24) }
                 F_i { 2e33 - n/2e-9 - g*s, g*s - s/2e-12 + 1e-4*n/2e-9 }";
    let said = warned("lasing", laser, &["--method", "bdf2", "--h", "1.81e-10", "--t-end", "5e-9"]);
    assert!(said.contains("by two solvers that choose their steps"), "{said}");
}

/// An explicit method on stiff kinetics: of the state that it failed at f has derivatives of more than 10¹⁰⁰.
#[test]
fn a_run_that_blew_up_is_explained_at_once() {
    let kinetics = "u_i { s = 1e-3, e = 1e-6, c = 0 } F_i { -1e6*e*s + 10*c, -1e6*e*s + 20*c, 1e6*e*s - 20*c }";
    let path = file("kinetics.ds", kinetics).display().to_string();
    let (status, _, errors) = verify(&["solve", "--model", &path, "--method", "rk4", "--h", "47.7", "--t-end", "2000"]);
    assert!(status == 1 && errors.contains("step from t = "), "{errors}");
}

/// A load that is switched on beside the end of a step, whether that is h or half of it.
#[test]
fn an_error_that_two_runs_share_is_in_the_estimate_though_it_is_small() {
    let load = file("load.ds", "u_i { x = 0 } F_i { heaviside(t - 3.3333) - x }").display().to_string();
    let run = ["--model", &load, "--method", "ls-galerkin(3,gauss,3)", "--h", "0.0606", "--t-end", "10"];
    for row in rows("load.csv", &run) {
        let error = (row[1] - (1.0 - (3.3333 - row[0].max(3.3333)).exp())).abs();
        assert!(error <= 1.01 * row[2] + 1e-9, "{row:?}: {error}");
    }
}

/// e^(10 sin t), which is less than a part of 10⁸ of its largest value where it begins to grow again.
#[test]
fn a_trough_is_no_rest() {
    let run = ["--method", "radau-adaptive", "--rtol", "1e-8", "--atol", "1e-12", "--t-end", "30"];
    assert_eq!(warned("trough", "u_i { x = 1 } F_i { 10*x*cos(t) }", &run), "");
}

/// ½v² − 1/r = −½ grows in size as implicit Euler loses energy; −0.6148 by the last row.
#[test]
fn a_negative_energy_that_falls_has_grown() {
    let (status, out, errors) =
        verify(&["solve", "--problem", "kepler", "--method", "implicit-euler", "--h", "0.01", "--t-end", "1"]);
    assert!(status == 0 && out.contains("energy -0.500000 at t = 0, relative change 0.2295"), "{out}{errors}");
}

/// 1.25 (f₂ − f₃)/f₂/(2ᵖ − 1) with p = log₂ (0.125/0.033) of the finest three of four grids: 0.125/1.045 · 1.25/(3.7879 − 1).
#[test]
fn the_index_of_the_medium_grid_is_of_the_finest_three() {
    let data = file("four.csv", "h,f\n0.1,1.0120\n0.2,1.0450\n0.4,1.1700\n0.8,1.6000\n").display().to_string();
    let (_, out, errors) = verify(&["order", "--data", &data, "--step", "h"]);
    assert!(out.contains("of the medium one 5.3632"), "{out}{errors}");
}

#[test]
fn a_model_has_one_source_whatever_its_inputs_are_set_to() {
    let model = file("one-source.ds", "in_i { k = 1 } u_i { x = 1 } F_i { -k*x }").display().to_string();
    let (status, out, errors) = verify(&["compare", "--model", &model, "--set", "k=2", "--t-end", "1"]);
    assert!(status == 0 && out.contains("The equations have one source"), "{out}{errors}");
}

#[test]
fn rows_whose_sums_no_change_mends_are_counted_from_one() {
    let text = "order = 4\nc = [0, \"0.4\", \"0.6\", 1]\na = [[], [\"1/2\"], [0, \"1/2\"], [0, 0, 1]]\n\
                b = [\"1/6\", \"1/3\", \"1/3\", \"1/6\"]\n";
    let (code, out, error) = judged("two-rows.toml", text);
    assert!(code == 1 && out.contains("mends the row sums of stages 2, 3,"), "{out}{error}");
}

/// A neuron that fires once and is back at rest at the end: both rows are right.
#[test]
fn a_pulse_that_rows_on_both_sides_show_nothing_of_is_named() {
    let neuron = "u_i { v = -1.1994, w = -0.6243 } cur { 0.8*(heaviside(t - 20) - heaviside(t - 25)) }
                  F_i { v - v*v*v/3 - w + cur, 0.08*(v + 0.7 - 0.8*w) }";
    let said = warned("neuron", neuron, &["--method", "radau-adaptive", "--t-end", "100"]);
    assert!(said.contains("f changes in time faster than the steps"), "{said}");
}

/// A burst of a third of a unit of time, of which no tolerance shows anything, and steps as long as it is do.
#[test]
fn the_steps_that_show_a_burst_are_named_and_no_smaller_tolerance() {
    let model = "u_i { x = 0, y = 0 } g { exp(-pow((t - 613.7)/0.2, 2))*5 } F_i { g - 0.5*x, 0.5*x - 0.1*y }";
    let run =
        |rest: &[&str]| warned("burst", model, &[&["--method", "radau-adaptive", "--t-end", "1000"], rest].concat());
    let said = run(&[]);
    assert!(said.contains("as at t = 613.7") && said.contains("`--h`") && !said.contains("`--atol`"), "{said}");
    // 0.2 √π.
    assert!(said.contains("where it is 0.354"), "{said}");
    assert_eq!(run(&["--h", "0.354"]), "");
}

/// A rotation whose components are 10⁹ apart in size: in units in which they are alike Method I turns.
#[test]
fn units_that_least_squares_cannot_weigh_are_named() {
    let model = "u_i { x = 1, v = 0 } F_i { 1e9*v, -1e-9*x }";
    let cause = "with v in units of 9e-10 of those of x";
    let said = warned("units", model, &["--method", "method-i", "--h", "0.1", "--t-end", "10"]);
    assert!(said.contains("the method hardly moves it") && said.contains(cause), "{said}");
    // Where the residual vanishes the minimum is the same in all units.
    let path = file("units.ds", model).display().to_string();
    let run =
        ["solve", "--model", &path, "--method", "ls-galerkin(3,gauss,3)", "--h", "0.1", "--t-end", "1", "--csv", "-"];
    let (status, out, errors) = verify(&run);
    let last = out.split_whitespace().rfind(|row| row.starts_with("1.0,")).unwrap_or_default();
    let end: Vec<f64> = last.split(',').skip(1).filter_map(|x| x.parse().ok()).collect();
    // Of order 6, h⁶ and its constants.
    let is_right =
        end.len() >= 2 && (end[0] - 1_f64.cos()).abs() < 1e-10 && (end[1] + 1e-9 * 1_f64.sin()).abs() < 1e-19;
    assert!(status == 0 && is_right, "{last} {errors}");
}

/// A blow that lasts 10⁻⁴ of the run, whatever the tolerances.
#[test]
fn a_blow_that_adaptive_steps_pass_over_is_named() {
    let model = "u_i { y = 0, w = 1 } F_i { w, -y + 500*exp(-1e8*(t - 3.3004)*(t - 3.3004)) }";
    for rtol in ["1e-2", "1e-4", "1e-6", "1e-8", "1e-10"] {
        let said =
            warned("blow", model, &["--method", "radau-adaptive", "--rtol", rtol, "--atol", rtol, "--t-end", "10"]);
        assert!(said.contains("f changes in time faster than the steps"), "{rtol}: {said}");
    }
}

/// What a stiff component makes of a smooth force is next to nothing, the moment of it within a step too.
#[test]
fn a_smooth_force_on_a_stiff_component_is_not_named() {
    for method in ["trapezoidal", "ls-galerkin(2,radau,2)"] {
        let said = warned(
            "prothero",
            "u_i { v = 1 } F_i { -1000*(v - cos(t)) - sin(t) }",
            &["--method", method, "--h", "1", "--t-end", "10"],
        );
        assert_eq!(said, "", "{method}");
    }
}

/// By the end nothing of the rotation is left, in the run and in its finer one alike: their difference is largest early, or is of
/// the size of the solution.
#[test]
fn a_rotation_that_is_damped_in_both_runs_is_named() {
    let model = "u_i { q = 1, p = 0 } F_i { p, -q }";
    for method in ["implicit-euler", "method-i", "bdf2"] {
        let said = warned("rotation", model, &["--method", method, "--h", "0.7", "--t-end", "60"]);
        assert!(
            said.contains("the error is larger than the estimates near there")
                || said.contains("with half the step it is another solution"),
            "{method}: {said}"
        );
    }
    assert_eq!(warned("rotation", model, &["--method", "trapezoidal", "--h", "0.05", "--t-end", "60"]), "");
}

/// Two solvers on a chaotic equation part from each other as they do from the run.
#[test]
fn a_row_that_two_chaotic_references_miss_in_ways_of_their_own_is_not_named() {
    let model = "u_i { x = 1, v = 0 } F_i { v, x - x*x*x - 0.3*v + 0.5*cos(1.2*t) }";
    for h in ["0.02", "0.01"] {
        let arguments = ["--method", "ls-galerkin(3,gauss,3)", "--h", h, "--t-end", "100"];
        let said = warned("chaos", model, &arguments);
        assert!(!said.contains("by two solvers"), "{h}: {said}");
    }
}

/// The tail of a Gaussian grows by powers of ten in a step, beside nothing.
#[test]
fn growth_of_what_is_next_to_nothing_is_no_leap() {
    let model = "u_i { x = 0 } F_i { -0.05*x + exp(-(t - 500)*(t - 500)/50) }";
    assert_eq!(warned("tail", model, &["--method", "ls-galerkin(3,gauss,3)", "--h", "0.5", "--t-end", "1000"]), "");
}

/// A pulse is over, and a rate of 10⁻³²¹ is no motion.
#[test]
fn a_rate_below_all_normal_numbers_is_no_drift() {
    let model = "u_i { a = 0 } F_i { 1000*(exp(-(t - 0.3)*(t - 0.3)/2e-4) - a) }";
    for h in ["0.1", "0.01"] {
        let said = warned("pulse-over", model, &["--method", "method-i", "--h", h, "--t-end", "10"]);
        assert!(!said.contains("rests where f is not zero"), "{h}: {said}");
    }
    // Nor does one of 8 times the least number move anything in steps of 0.1.
    let said = warned("least", "u_i { a = 0 } F_i { 4e-323 }", &["--method", "rk4", "--h", "0.1", "--t-end", "1"]);
    assert!(!said.contains("rests where f is not zero"), "{said}");
}

#[test]
fn what_coarse_tolerances_do_not_follow_is_told_with_tolerances() {
    let lorenz = "u_i { x = 1, y = 1, z = 1 } F_i { 10*(y - x), x*(28 - z) - y, x*y - 8*z/3 }";
    let said = warned("butterfly", lorenz, &["--method", "radau-adaptive", "--rtol", "1e-4", "--t-end", "40"]);
    assert!(said.contains("with a tenth of the tolerances it is another solution"), "{said}");
}

#[test]
fn what_is_missing_is_said_and_not_guessed() {
    let (status, _, errors) = verify(&["report", "--only", "model"]);
    assert!(status == 2 && errors.contains("--model FILE"), "{errors}");
    let (status, _, errors) = verify(&["golden", "--dir", "/nonexistent", "check"]);
    assert!(status == 2 && errors.contains("/nonexistent"), "{errors}");
    let path = file("log.ds", "u_i { x = 0 } F_i { log(x) + 1 - x }").display().to_string();
    let (status, _, errors) = verify(&["solve", "--model", &path, "--method", "rk4", "--h", "0.1", "--t-end", "1"]);
    assert!(status == 1 && errors.contains("at the start"), "{errors}");
    let (status, text, _) = verify(&["advise", "--model", &path, "--t-end", "2"]);
    assert!(
        status == 3 && text.contains("f is not finite at the start") && !text.contains("system is large"),
        "{text}"
    );
}

/// An order that theory may not let show is no excuse for another one.
#[test]
fn an_order_that_is_off_by_an_order_is_refuted() {
    let method = "ls-galerkin(2,lobatto,3,-0.5:1.0)";
    let order =
        |expected| verify(&["order", "--problem", "channel-poiseuille", "--method", method, "--expect", expected]);
    let (status, text, errors) = order("2");
    assert_eq!(status, 1, "{text}{errors}");
}

/// Steps along a jump that the solution cannot leave have no end.
#[test]
fn a_run_that_slides_along_a_jump_ends_and_says_so() {
    let thermostat =
        "u_i { temp = 15, heat = 0 }\nF_i { 0.3*(5 - temp) + heat, 40*(10*heaviside(18 - temp) - heat) }\n";
    let path = file("thermostat.ds", thermostat);
    let arguments = ["solve", "--model", path.to_str().expect("ASCII"), "--method", "radau-adaptive", "--t-end", "10"];
    let (status, _, error) = verify(&[&arguments[..], &["--max-steps", "5000"]].concat());
    assert!(status == 1 && error.contains("all of the 5000 steps") && error.contains("--max-steps"), "{error}");
}

/// Errors far below the absolute tolerance of a reference are errors.
#[test]
fn the_order_on_a_small_solution_is_found() {
    let path = file(
        "tiny.ds",
        "u_i { e = 1e-12, s = 5e-11, c = 0 }\nF_i { -1e12*e*s + 3*c, -1e12*e*s + 2*c, 1e12*e*s - 3*c }\n",
    );
    let arguments = ["order", "--model", path.to_str().expect("ASCII"), "--method", "trapezoidal", "--t-end", "0.01"];
    let (status, text, _) = verify(&arguments);
    assert!(status == 0 && text.contains("PASS"), "{text}");
}

/// A time shorter than the normal numbers has more panels to look at f on than there are integers.
#[test]
fn a_run_of_next_to_no_time_ends() {
    let path = file("moment.ds", "u_i { x = 1 } F_i { -x * t }").display().to_string();
    for end in ["1e-305", "1e-310", "1e-320"] {
        for method in ["rk4", "method-i"] {
            let (status, _, errors) =
                verify(&["solve", "--model", &path, "--method", method, "--h", end, "--t-end", end]);
            assert!([0, 1, 2].contains(&status) && !errors.contains("panicked"), "{method}, {end}: {status} {errors}");
        }
    }
}

/// (1; 1 m) u̇ = F, of which e^(−t) (1, 0) is a solution: roundings of M⁻¹F are more than its second row.
#[test]
fn a_linear_model_with_a_mass_matrix_is_no_mistake() {
    for m in ["1.1", "1.0001"] {
        let text = format!(
            "u_i {{ x = 1, y = 0 }} dudt_i {{ p = 0, q = 0 }} M_i {{ p + q, p + {m} * q }} F_i {{ -x - y, -x - 2 * y }}"
        );
        let path = file("solved.ds", &text).display().to_string();
        for method in ["method-i", "method-ii", "fitted(4.0)", "minimax(0.0,2.0)"] {
            for h in ["0.1", "0.01", "0.001"] {
                let (status, _, errors) =
                    verify(&["solve", "--model", &path, "--method", method, "--h", h, "--t-end", "2", "--no-estimate"]);
                assert!(status == 0, "{method}, m = {m}, h = {h}: {errors}");
            }
        }
    }
}

/// ẋ + ẏ = −x beside rates of 10¹³.
#[test]
fn a_sum_that_decays_beside_a_fast_exchange_is_no_invariant() {
    for (fast, is_kept) in [("- x", false), ("", true)] {
        let text = format!("u_i {{ x = 1, y = 0.5 }} F_i {{ 1e13 * (y - x) {fast}, 1e13 * (x - y) }}");
        let path = file("exchange.ds", &text).display().to_string();
        let (status, _, errors) = verify(&["solve", "--model", &path, "--method", "radau-adaptive", "--t-end", "2"]);
        assert!(status == 0 && !errors.contains("the equation conserves"), "{is_kept}: {errors}");
    }
}

#[test]
fn a_formula_with_its_newest_step_first_is_told_so() {
    let (status, _, errors) =
        judged("ab2.toml", "kind = \"multistep\"\nrho = [1, -1, 0]\nsigma = [0, \"3/2\", \"-1/2\"]\n");
    assert!(status == 2 && errors.contains("the newest step seems to be listed first"), "{errors}");
}

/// v̇ = −v² from −1 has its pole at t = 1.
#[test]
fn rows_beyond_the_end_of_the_exact_solution_are_said_to_be_none_of_it() {
    let line = "solve --problem quadratic-drag --set v0=-1 --method method-i --h 0.3 --t-end 3 --no-estimate";
    let (_, _, errors) = verify(&line.split(' ').collect::<Vec<_>>());
    assert!(errors.contains("the exact solution ends before t = 1.2;"), "{errors}");
    let (_, _, errors) = verify(&line.replace("--t-end 3", "--t-end 0.9").split(' ').collect::<Vec<_>>());
    assert!(!errors.contains("the exact solution ends"), "{errors}");
}

/// The text of a model of these initial values and rates of w0, w1, …
fn model_of(name: &str, initial: &[f64], rate: impl Fn(usize) -> String) -> String {
    let values: Vec<String> = initial.iter().enumerate().map(|(k, x)| format!("w{k} = {x:.20}")).collect();
    let rates: Vec<String> = (0..initial.len()).map(rate).collect();
    file(name, &format!("u_i {{ {} }}\nF_i {{ {} }}", values.join(", "), rates.join(",\n"))).display().to_string()
}

/// The Kuramoto–Sivashinsky equation keeps u(−x) = −u(x), and at 0 leaves roundings of u, 10⁻¹⁸, whose sign is nobody's.
#[test]
fn what_vanishes_by_symmetry_has_no_sign() {
    let (n, dx) = (64, 22.0 / 64.0);
    let initial: Vec<f64> = (0..n).map(|k| (std::f64::consts::TAU * k as f64 / n as f64).sin()).collect();
    let model = model_of("sivashinsky.ds", &initial, |k| {
        let [a, b, c, d, e] = [n - 2, n - 1, n, n + 1, n + 2].map(|j| format!("w{}", (k + j) % n));
        let (steep, second, fourth) = (0.25 / dx, 1.0 / (dx * dx), 1.0 / (dx * dx * dx * dx));
        format!(
            "-({d}*{d} - {b}*{b})*{steep} - ({b} - 2*{c} + {d})*{second} - ({a} - 4*{b} + 6*{c} - 4*{d} + {e})*{fourth}"
        )
    });
    let (code, _, error) =
        verify(&["solve", "--model", &model, "--method", "radau-adaptive", "--h", "0.05", "--t-end", "1"]);
    assert!(code == 0 && !error.contains("changes its sign"), "{error}");
}

/// A step of diffsol's ESDIRK34 ends beyond the stop at t = 4.02 by just what it takes for roundings.
#[test]
fn a_solver_that_oversteps_a_stop_by_roundings_goes_on() {
    let model = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("models/predator-prey.ds").display().to_string();
    let (status, out, _) = verify(&["compare", "--model", &model, "--t-end", "5"]);
    assert!(status == 0 && out.contains(" 0 inconclusive"), "{out}");
}

/// Layers of the Allen–Cahn equation that hardly move: what a solver may take of 200 unknowns is 625 steps, and it was asked to stop 1024 times.
#[test]
fn a_solver_that_is_asked_to_stop_too_often_is_not_lost() {
    let (n, dx) = (200, 0.01);
    let layers = |k: usize| -1.0 + (k as f64 + 0.5) * dx;
    let initial: Vec<f64> = (0..n).map(|k| layers(k).powi(2) * (std::f64::consts::PI * layers(k)).cos()).collect();
    let model = model_of("allen-cahn.ds", &initial, |k| {
        let [left, here, right] = [k.saturating_sub(1), k, (k + 1).min(n - 1)].map(|j| format!("w{j}"));
        format!("{}*({left} - 2*{here} + {right}) + {here} - {here}*{here}*{here}", 4e-4 / (dx * dx))
    });
    let (code, _, error) = verify(&["solve", "--model", &model, "--method", "method-i", "--h", "0.5", "--t-end", "60"]);
    assert!(code == 0 && !error.contains("neither of two solvers"), "{error}");
}
