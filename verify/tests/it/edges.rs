//! What methods and tables just beside the usual ones are told: each of these once had, or would have with one slip, another answer.

use std::fs;
use std::process::Command;

use lsvi::StepError;
use lsvi::adaptive::Tolerances;
use verify::run::RunError;

use crate::{flat, scratch};

fn verify(arguments: &[&str]) -> (i32, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_verify"));
    let output = command.args(arguments).env("NO_COLOR", "1").env_remove("COLUMNS").output().expect("it starts");
    (output.status.code().expect("no signal"), flat(&String::from_utf8(output.stdout).expect("UTF-8")))
}

/// Writes a file of this name and text.
fn file(name: &str, text: &str) -> String {
    let path = scratch(&format!("edges/{name}"));
    fs::create_dir_all(path.parent().expect("a directory")).expect("writable");
    fs::write(&path, text).expect("writable");
    path.display().to_string()
}

/// Holds what `judge` says without runs: its exit status, what is in it, and what is not.
fn judged(name: &str, text: &str, status: i32, says: &[&str], never: &[&str]) {
    let (found, output) = verify(&["judge", &file(&format!("{name}.toml"), text), "--no-runs"]);
    assert_eq!(found, status, "{name}: {output}");
    for what in says {
        assert!(output.contains(what), "{name}: no `{what}` in {output}");
    }
    for what in never {
        assert!(!output.contains(what), "{name}: `{what}` in {output}");
    }
}

/// ρ with the roots ±1 and −1 beside: growth for every hλ < 0.
#[test]
fn weakly_stable_formulas_have_nothing_of_the_negative_axis() {
    for (name, coefficients) in [
        ("leapfrog", "rho = [-1, 0, 1]\nsigma = [0, 2, 0]"),
        ("milne-simpson", "rho = [-1, 0, 1]\nsigma = ['1/3', '4/3', '1/3']"),
        ("nystrom", "rho = [0, -1, 0, 1]\nsigma = ['1/3', '-2/3', '7/3', 0]"),
    ] {
        let text = format!("kind = 'multistep'\nstart = 'radau-iia3'\n{coefficients}");
        judged(name, &text, 0, &["nothing of the negative axis"], &["all of the negative axis"]);
    }
}

/// [[.246, −.036], [.536, .246]] with b = (.504, .504) has the same two digits and |R(i)| = 1.0077; (.504, .496) beside ½ a root of σ
/// outside of the unit circle.
#[test]
fn two_digits_do_not_confirm_a_stability() {
    let gauss = "digits = 2\na = [['0.25', '-0.04'], ['0.54', '0.25']]\nb = ['0.50', '0.50']\nclaims = ['A-stable']";
    judged("gauss", gauss, 3, &["inconclusive A-stable"], &["REFUTED"]);
    let trapezoid =
        "kind = 'multistep'\ndigits = 2\nrho = ['-1.00', '1.00']\nsigma = ['0.50', '0.50']\nclaims = ['A-stable']";
    judged("trapezoid", trapezoid, 3, &["inconclusive A-stable"], &["REFUTED"]);
    // Exact, they are.
    judged("exact-gauss", &gauss.replace("digits = 2\n", ""), 0, &["confirmed A-stable"], &[]);
    judged("exact-trapezoid", &trapezoid.replace("digits = 2\n", ""), 0, &["confirmed A-stable"], &[]);
}

/// R = 1 − x + 0.125 x² touches −1 at x = 4; with 0.1246, which has the same digits, it is below from 3.79 on.
#[test]
fn an_interval_ends_where_few_digits_let_r_leave_the_unit_disc() {
    let of = |digits: &str| format!("{digits}a = [[], ['0.125']]\nb = [0, 1]");
    judged("touching", &of("digits = 3\n"), 0, &["at least, which few digits leave open"], &["axis to 8"]);
    judged("exact", &of(""), 0, &["negative axis to 8.0000"], &["leave open"]);
}

#[test]
fn zeros_are_zeros_however_many_places_they_have() {
    let heun = "a = [[0.000000, 0.000000], [1.000000, 0.000000]]\nb = [0.500000, 0.500000]\nc = [0.000000, 1.000000]\norder = 2\n";
    judged("heun", &format!("{heun}claims = ['explicit']"), 0, &["confirmed explicit"], &["REFUTED"]);
    let dirk =
        "a = [[0.292893, 0.000000], [0.707107, 0.292893]]\nb = [0.707107, 0.292893]\nclaims = ['diagonally implicit']";
    judged("dirk", dirk, 0, &["confirmed diagonally implicit"], &["REFUTED"]);
}

/// R = (1 + z + 0.94 z²)/((1 − z)(1 + z + 0.93 z²)) has poles at −0.5376 ± 0.8867i, 58.77° from the negative axis.
#[test]
fn a_pole_ends_the_sector_of_stability() {
    let text = "a = [[1, 0, 0], [0, 0, 1], [0, '-93/100', -1]]\nb = ['294/293', 0, '-1/293']\n";
    judged("pole", &format!("{text}claims = ['A(80)-stable']"), 1, &["REFUTED A(80°)-stable", "α = 58.39°"], &[]);
    judged("before-pole", &format!("{text}claims = ['A(58)-stable']"), 0, &["confirmed A(58°)-stable"], &[]);
}

/// Lobatto IIIA-like stages at 0, ½, ½ and 1: the two in the middle are their own mirror images, not each other's.
#[test]
fn stages_with_one_abscissa_may_be_their_own_mirror_images() {
    let of = |last: &str| {
        format!(
            "a = [[0, 0, 0, 0], ['1/6', '1/6', '1/6', 0], ['1/8', '1/6', '1/6', '{last}'], ['1/6', '1/3', '1/3', '1/6']]\n\
             b = ['1/6', '1/3', '1/3', '1/6']\nclaims = ['symmetric']"
        )
    };
    judged("own", &of("1/24"), 0, &["confirmed symmetric"], &[]);
    judged("none", &of("1/25"), 1, &["REFUTED symmetric"], &[]);
}

#[test]
fn exchanged_weights_are_not_taken_for_interchanged_methods() {
    let fehlberg = format!("{}/methods/fehlberg45.toml", env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(fehlberg).expect("there").replace("embedded_order = 5\n", "");
    let exchanged = text.replace("\"1408/2565\", \"2197/4104\"", "\"2197/4104\", \"1408/2565\"");
    assert_ne!(text, exchanged);
    judged("fehlberg", &exchanged, 1, &["b[3] ↔ b[4]"], &["interchanged"]);
}

#[test]
fn coefficients_beside_the_usual_ones_have_the_verdict_of_their_own() {
    let multistep = |text: &str| format!("kind = 'multistep'\n{text}");
    judged(
        "implicit-euler",
        &multistep("rho = [-1, 1]\nsigma = [0, 1]\nclaims = ['symmetric']"),
        1,
        &["σ_0 is not σ_1"],
        &[],
    );
    // ρ of BDF3 with a quarter of its stability given away: α = 89.963°.
    let nearly = "rho = ['-11/60', '9/40+33/40', '-9/10-33/20', '27/40+121/120']\nsigma = [0, 0, 0, 1]\nclaims = ['A(89.99)-stable']";
    judged("nearly-a-stable", &multistep(nearly), 1, &["α = 89.96°"], &["; A-stable", "confirmed A(89"]);
    // Reversed it has order 3, and roots outside of the unit circle.
    let reversed = "order = 3\nrho = [1, 4, -5]\nsigma = [0, 4, 2]";
    judged("reversed", &multistep(reversed), 1, &["DIAGNOSIS"], &["newest step first", "and converges"]);
    let rim = "rho = ['0.9995', '-1.9995', '1']\nsigma = [0, '0.0005', 0]\nclaims = ['zero-stable']";
    judged("near-rim", &multistep(rim), 0, &["confirmed zero-stable"], &["inconclusive"]);
    let unclaimed = "rho = [0, -1, 1]\nsigma = ['-1/4', '3/2', 0]";
    judged("unclaimed", &multistep(unclaimed), 1, &["REFUTED consistency"], &["DIAGNOSIS"]);
    let path = "kind = 'path-fitted'\nnodes = ['1/3']\nclaims = ['symplectic']";
    judged("path", path, 1, &["the nodes are not those of Gauss"], &[]);
    // Stages that differ by c alone are equal where the equation does not depend on time, as steps of mechanics are told.
    let stages = "a = [['1/2', 0], ['1/4', '1/4']]\nb = ['1/2', '1/2']\nc = ['1/2', '1/4']\nclaims = ['symplectic']";
    judged("stages", stages, 1, &["confirmed symplectic", "where f does not depend on t", "REFUTED row sums"], &[]);
    let closure = "kind = 'closure'\nalpha = 'z/1000'\nbeta = '1'\nrate = '1'\nclaims = ['A-stable']";
    judged("late-closure", closure, 1, &["at z = 1.1220e3"], &["inconclusive A-stable"]);
    let rounded = "digits = 5\na = [[], [0.5], [0, 0.5], [0, 0, 1]]\nb = [0.16667, 0.33333, 0.33333, 0.16667]";
    judged("rounded-rk4", rounded, 0, &["2.7853 ± 0.0003", "2.828 ± 0.001"], &[]);
    judged("half-euler", "order = 1\na = [[]]\nb = ['1/2']", 1, &["b[1]: 1/2 → 1"], &["coincidence"]);
    // 6 · 0.166666 falls short by 4e-6: six cut decimals, but no order that they would have been cut from.
    let cut = "a = [[], ['1/8'], ['1/8', 0], ['1/8', 0, 0], ['1/8', 0, 0, 0], ['1/8', 0, 0, 0, 0]]\nb = ['0.166666', '0.166666', '0.166666', '0.166666', '0.166666', '0.166666']";
    judged("cut", cut, 1, &["REFUTED consistency"], &["cut off"]);
}

#[test]
fn a_method_without_order_passes_on_no_problem() {
    let path = file("inconsistent.toml", "a = [[], ['1/2']]\nb = ['1/2', '1/4']");
    let (status, output) = verify(&["order", "--problem", "logistic", "--method", &path]);
    assert_eq!(status, 1, "{output}");
    assert!(output.contains("a method without order does not converge"), "{output}");
}

/// Four steps of history do not reach a last step that is cut to 0.2: it starts anew.
#[test]
fn a_last_step_of_another_length_does_not_use_old_steps() {
    let solve = [
        "solve",
        "--problem",
        "logistic",
        "--method",
        "adams-bashforth4",
        "--h",
        "0.3",
        "--t-end",
        "2",
        "--no-estimate",
    ];
    let (status, output) = verify(&solve);
    assert!(status == 0 && output.contains("largest error 2.79274e-4 at t = 2"), "{output}");
}

/// Holds what `order --data` says of the rows.
fn told(name: &str, rows: &[[f64; 2]], digits: usize, arguments: &[&str], status: i32) -> String {
    let rows = rows.iter().map(|[h, u]| format!("{h},{u:.digits$}\n")).collect::<String>();
    let path = file(&format!("{name}.csv"), &format!("h,u\n{rows}"));
    let (found, output) = verify(&[&["order", "--data", &path, "--step", "h"], arguments].concat());
    assert_eq!(found, status, "{name}: {output}");
    output
}

fn json(name: &str, rows: &[[f64; 2]], digits: usize, status: i32) -> serde_json::Value {
    serde_json::from_str(&told(name, rows, digits, &["--format", "json"], status)).expect("JSON")
}

#[test]
fn grids_that_stand_still_or_are_few_decide_nothing() {
    let still = [[0.8, 1.00016], [0.4, 1.00008], [0.2, 1.00004], [0.1, 1.00004]];
    let output = told("still", &still, 6, &["--expect", "1"], 3);
    assert!(output.contains("two neighbouring grids have the same value"), "{output}");
    // Two of four errors are no more than their digits.
    let floor = [[0.4, 1.0], [0.2, 1.0], [0.1, 1.1], [0.05, 1.2]];
    let output = told("floor", &floor, 6, &["--exact", "1", "--expect", "1"], 3);
    assert!(output.contains("2 usable of 4 points") && !output.contains("diverges"), "{output}");
}

/// Coefficients that scatter by half a percent: slopes of neighbours between 1.98 and 2.014.
#[test]
fn the_uncertainty_of_an_order_covers_the_scatter_of_its_slopes() {
    let rows = [(0.8, 1.0), (0.4, 0.995), (0.2, 1.004), (0.1, 0.999), (0.05, 1.0)].map(|(h, c)| [h, 1.0 + c * h * h]);
    let output = told("scatter", &rows, 9, &[], 0);
    assert!(output.contains("2.0047 ± 0.017"), "{output}");
}

/// The finest of five grids is at the floor of its digits: it is in the table, and not in the fit, which says so.
#[test]
fn grids_that_are_left_out_count_nowhere() {
    let rows = [[0.4, 1.00032], [0.2, 1.00008], [0.1, 1.00002], [0.05, 1.000005], [0.025, 1.000001]];
    assert!(told("left-out", &rows, 6, &[], 0).contains("finest three, without those left out"));
    let found = json("left-out", &rows, 6, 0);
    assert_eq!((&found["grids"], &found["least_squares"]["grids"]), (&5.into(), &4.into()));
}

/// The formulas of Eça and Hoekstra (2014) by hand: the standard deviation divides by the grids less the parameters, the fit is the best
/// of all forms, and errors are relative to the limit.
#[test]
fn the_fits_and_errors_are_those_of_the_procedures() {
    let close = |x: &serde_json::Value, expected: f64| {
        let x = x.as_f64().expect("a number");
        assert!((x - expected).abs() <= 1e-4 * expected, "{x} and not {expected}");
    };
    let found = json("deviation", &[[1.0, 1.0], [2.0, 1.2], [4.0, 0.9], [8.0, 1.1]], 5, 3);
    close(&found["least_squares"]["uncertainty"], 0.82989);
    let rows = [1.0, 2.0, 4.0, 8.0, 16.0].map(|h: f64| [h, 1.0 + h.powf(0.3)]);
    let found = json("forms", &rows, 6, 0);
    assert_eq!(found["least_squares"]["form"], "a + b h + c h^2");
    close(&found["least_squares"]["uncertainty"], 0.61604);
    let found = json("limit", &[[1.0, 1.01], [2.0, 1.04], [4.0, 1.16]], 9, 3);
    close(&found["celik"]["extrapolated_error"], 0.01);
}

#[test]
fn an_index_in_percent_of_zero_is_none() {
    let rows = [[1.0, 0.0], [2.0, 3.0], [4.0, 15.0]];
    let output = told("zero", &rows, 5, &[], 3);
    assert!(
        output.contains("GCI, fine none, being a part of the value, which is 0") && !output.contains("inf"),
        "{output}"
    );
    let output = told("zero", &rows, 5, &["--format", "markdown"], 3);
    assert!(!output.contains("inf %"), "{output}");
}

/// 1 + h² + h³/2: of neighbouring differences the orders fall to 2 from the coarse grids to the fine ones.
#[test]
fn orders_of_three_grids_stand_from_coarse_to_fine() {
    let rows = [0.8, 0.4, 0.2, 0.1, 0.05].map(|h: f64| [h, 1.0 + h * h + 0.5 * h.powi(3)]);
    let found = json("drifting", &rows, 9, 0);
    let expected: Vec<f64> = rows.array_windows().map(|[a, b, c]| ((a[1] - b[1]) / (b[1] - c[1])).log2()).collect();
    let orders: Vec<f64> =
        found["triplet_orders"].as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect();
    assert!(expected[0] > expected[1] && expected[1] > expected[2], "{expected:?}");
    assert!(
        orders.len() == 3 && orders.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-6),
        "{orders:?} {expected:?}"
    );
}

/// Cells along a side of a grid of three dimensions, which are told for all of them.
#[test]
fn an_order_of_three_times_the_expected_one_hints_at_cells_along_a_side() {
    let rows: String = [8.0, 16.0, 32.0, 64.0].map(|n: f64| format!("{n},{:.12}\n", 1.0 + n.powi(-2))).concat();
    let path = file("per-side.csv", &format!("cells,u\n{rows}"));
    let told = |dimension: &str| {
        let (_, out) =
            verify(&["order", "--data", &path, "--cells", "cells", "--dimension", dimension, "--expect", "2"]);
        flat(&out).contains("if `cells` counts the cells along a side")
    };
    assert_eq!(["3", "1"].map(told), [true, false]);
}

/// Whatever the machine: the steps of a run take no longer than what is waited for it.
#[test]
fn the_seconds_of_a_run_are_seconds() {
    let problem = verify::problem::build("van-der-pol", &[]).expect("registered");
    let method = verify::method::parse("method-i").expect("registered");
    let begun = std::time::Instant::now();
    let run = verify::run::run(&*problem, &*method, 1e-3, 2.0, |_| {}).expect("it runs");
    assert!(run.seconds > 0.0 && run.seconds <= begun.elapsed().as_secs_f64(), "{}", run.seconds);
}

/// Whichever is given first, and with the tighter tolerances of an estimate too.
#[test]
fn a_limit_of_steps_stays_with_a_method() {
    let problem = verify::problem::build("logistic", &[]).expect("registered");
    let tolerances = || Tolerances::new(1e-10, 1e-10).expect("positive");
    let method = verify::method::parse("radau-adaptive").expect("registered");
    let limited = method.limited(3).expect("it chooses its steps");
    let last = method.with_tolerances(tolerances()).and_then(|method| method.limited(3));
    for method in [limited.with_tolerances(tolerances()), last, limited.tightened(10.0)] {
        let failed = verify::run::run(&*problem, &*method.expect("it has tolerances"), 10.0, 10.0, |_| {});
        let is_limit = matches!(failed, Err(RunError::Step(StepError::TooManySteps { limit: 3, .. })));
        assert!(is_limit, "{failed:?}");
    }
}
