//! Models in DiffSL: the examples are what they say, and mistakes are shown where they are.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use lsvi::{Jacobian, Structure};
use verify::chapter::{self, Context};
use verify::evidence::{Cell, Evidence, Outcome};
use verify::measure::norm::{distance, larger};
use verify::method;
use verify::problem::model::{Model, ModelError};
use verify::problem::{self, Problem};

use crate::{flat, scratch};

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(name)
}

fn load(name: &str, set: &[(&str, &str)]) -> Model {
    let set: Vec<_> = set.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
    Model::load(&example(name), &set, Some(5.0)).expect("a valid model")
}

/// f and ∂f/∂v, row by row.
fn derivatives(problem: &dyn Problem, t: f64, v: &[f64]) -> (Vec<f64>, Vec<f64>) {
    derivatives_of_size(problem, t, v, 15.0)
}

fn derivatives_of_size(problem: &dyn Problem, t: f64, v: &[f64], size: f64) -> (Vec<f64>, Vec<f64>) {
    let mut f = vec![0.0; v.len()];
    problem.ode().rhs(t, v, &mut f);
    let mut jacobian = Jacobian::zeros(v.len());
    problem.ode().jacobian(t, v, &mut |i, j, x| jacobian.add(i, j, x));
    let mut by_field = Jacobian::zeros(v.len());
    problem.field().add_jacobian(t, v, 1.0, &mut by_field);
    agree(by_field.to_dense().as_slice(), jacobian.to_dense().as_slice(), size);
    (f, jacobian.to_dense().transpose().as_slice().to_vec())
}

#[track_caller]
fn agree(found: &[f64], expected: &[f64], size: f64) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        // A dozen operations on numbers no larger than `size`.
        assert!((a - b).abs() <= 12.0 * f64::EPSILON * size, "{found:?} {expected:?}");
    }
}

#[test]
fn van_der_pol_is_the_built_in_problem() {
    let set = [("mu".to_owned(), "3".to_owned())];
    let (model, built_in) =
        (load("van-der-pol.ds", &[("mu", "3")]), problem::build("van-der-pol", &set).expect("known"));
    assert_eq!(model.components(), built_in.components());
    assert_eq!(model.initial(), built_in.initial());
    for v in [[2.0, 0.0], [0.3, -1.7], [-1.1, 0.4]] {
        let (found, expected) = (derivatives(&model, 0.4, &v), derivatives(&*built_in, 0.4, &v));
        agree(&found.0, &expected.0, 15.0);
        agree(&found.1, &expected.1, 15.0);
    }
    assert!(!model.is_stiff() && load("van-der-pol.ds", &[("mu", "100")]).is_stiff());
}

/// A rotation is none, however large its matrix is in the units of the user.
#[test]
fn a_model_is_stiff_by_its_fastest_decay() {
    let is_stiff = |text: &str, t_end: f64| Model::of_text(text, &[], Some(t_end)).expect("a model").is_stiff();
    assert!(!is_stiff("u_i { x = 1, v = 0 } F_i { v, -400*x }", 10.0));
    assert!(!is_stiff("u_i { q = 1e-9, i = 0 } F_i { i, -1e6*i - 1e14*q }", 1e-6));
    assert!(is_stiff("u_i { q = 1e-9, i = 0 } F_i { i, -1e9*i - 1e14*q }", 1e-5));
    assert_eq!(
        [99.0, 101.0].map(|rate| is_stiff(&format!("u_i {{ x = 1 }} F_i {{ -{rate}*x }}"), 10.0)),
        [false, true]
    );
}

#[test]
fn predator_prey_has_the_derivatives_of_its_equations() {
    let model = load("predator-prey.ds", &[("yield", "0.5")]);
    assert_eq!(model.components(), ["prey", "predators"]);
    assert_eq!(model.initial(), [1.0, 0.5]);
    let (t, [x, y]) = (0.7_f64, [1.3, 0.8]);
    let supply = 1.0 + 0.3 * t.sin();
    let (f, jacobian) = derivatives(&model, t, &[x, y]);
    agree(&f, &[supply * x - x * y, 0.5 * x * y - y], 2.0);
    agree(&jacobian, &[supply - y, -x, 0.5 * y, 0.5 * x - 1.0], 2.0);
}

/// At zeros of the state entries are what they are, those that vanish and the others.
#[test]
fn the_jacobian_of_a_model_at_zeros_of_its_state_has_all_entries() {
    let text = "u_i { x = 0, y = 0, z = 1 } F_i { 2 * y + x * z, 3 * z - x * y, -5 * x + y * y }";
    let model = Model::of_text(text, &[], Some(2.0)).expect("a model");
    let field = model.field();
    for [x, y, z] in [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]] {
        let mut found = Jacobian::with_structure(3, &field.structure());
        field.add_jacobian(0.0, &[x, y, z], 1.0, &mut found);
        let expected = nalgebra::dmatrix![z, 2.0, x; -y, -x, 3.0; -5.0, 2.0 * y, 0.0];
        assert_eq!(found.to_dense(), expected, "{x}, {y}, {z}");
    }
}

/// The derivative of √t by the state is 0, at t = 0 too.
#[test]
fn a_forcing_whose_derivative_in_time_is_infinite_leaves_the_jacobian() {
    let model =
        Model::of_text("u_i { x = 1, y = 0 } F_i { -2 * x + sqrt(t), x * y }", &[], Some(2.0)).expect("a model");
    let (f, jacobian) = derivatives(&model, 0.0, &[1.0, 3.0]);
    agree(&f, &[-2.0, 3.0], 3.0);
    agree(&jacobian, &[-2.0, 0.0, 3.0, 1.0], 3.0);
    // Where no time is beside it either, it is left as it is.
    let mut entries = Vec::new();
    model.ode().jacobian(f64::NAN, &[1.0, 3.0], &mut |i, j, x| entries.push((i, j, x)));
    assert!(entries.iter().any(|(i, _, x)| *i == 0 && x.is_nan()), "{entries:?}");
}

/// Its f is the u̇ of M u̇ = F: one sixth, four and one of it beside a second difference of u.
#[test]
fn heat_by_finite_elements_is_solved_for_its_rates() {
    let model = load("heat-elements.ds", &[("diffusivity", "2")]);
    let u: Vec<f64> = (0..31).map(|i| (0.7 * f64::from(i)).sin()).collect();
    let (f, jacobian) = derivatives_of_size(&model, 0.4, &u, 1e4);
    let at = |v: &[f64], i: usize| if (1..=31).contains(&i) { v[i - 1] } else { 0.0 };
    for i in 1..=31 {
        let mass = |v: &[f64]| (at(v, i - 1) + 4.0 * at(v, i) + at(v, i + 1)) / 6.0;
        let by_hand = |v: &[f64]| 2048.0 * (at(v, i - 1) - 2.0 * at(v, i) + at(v, i + 1));
        agree(&[mass(&f)], &[by_hand(&u)], 1e4);
        let column = |j: usize| -> Vec<f64> { (0..31).map(|i| jacobian[31 * i + j]).collect() };
        let unit = |j: usize| -> Vec<f64> { (0..31).map(|i| f64::from(u8::from(i == j))).collect() };
        (0..31).for_each(|j| agree(&[mass(&column(j))], &[by_hand(&unit(j))], 1e4));
    }
}

/// The program's runs of a model with a mass matrix are those of the model that is solved for its rates, and the references agree.
#[test]
fn a_mass_matrix_is_known_to_every_command() {
    let directory = scratch("mass");
    fs::create_dir_all(&directory).expect("writable");
    let system = "u_i { x = 1, y = 0 }";
    let with = "dudt_i { dxdt = 0, dydt = 0 } M_i { 2 * dxdt + dydt, dxdt + dydt } F_i { y - x * x * x, -x * x * x }";
    for (name, rest) in [("with", with), ("without", "F_i { y, -y - x * x * x }")] {
        fs::write(directory.join(format!("{name}.ds")), format!("{system} {rest}")).expect("writable");
    }
    let run = |arguments: &str| {
        let output =
            Command::new(env!("CARGO_BIN_EXE_verify")).current_dir(&directory).args(arguments.split(' ')).output();
        let output = output.expect("starts");
        assert_eq!(output.status.code(), Some(0), "{arguments}: {output:?}");
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    // Steps that are chosen go by roundings, and each run is within its tolerance.
    for (method, most) in [("rk4 --h 0.1", 1e-12), ("method-i --h 0.1", 1e-12), ("radau-adaptive --rtol 1e-6", 1e-6)] {
        let solve = |name: &str| -> Vec<f64> {
            let text = run(&format!("solve --model {name}.ds --t-end 2 --csv - --method {method}"));
            let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
            rows.flat_map(|line| line.split(',').take(3).map(|x| x.parse().expect("a number")).collect::<Vec<f64>>())
                .collect()
        };
        let (a, b) = (solve("with"), solve("without"));
        assert_eq!(a.len(), b.len(), "{method}");
        assert!(a.len() > 9 && distance(&a, &b) < most, "{method}: {a:?} {b:?}");
    }
    assert!(run("compare --model with.ds --t-end 2").contains("agree"));
    assert!(run("order --model with.ds --t-end 2 --method implicit-midpoint").contains("PASS"));
}

/// With differences for second derivatives the methods keep their orders and agree with the libraries.
#[test]
fn every_method_is_judged_on_a_model() {
    let model = load("van-der-pol.ds", &[]);
    let evidence = chapter::model::examine(&model, &Context::silent()).expect("it runs");
    for check in &evidence.checks {
        // The bound of the references leaves few points to the methods of order 4.
        let is_known = check.outcome == Outcome::Pass || check.outcome == Outcome::Inconclusive;
        assert!(is_known, "{}: {}", check.id, check.reason);
    }
    for name in ["van-der-pol/method-i", "van-der-pol/bdf2", "van-der-pol/equation/method-i"] {
        let check = evidence.checks.iter().find(|check| check.id == name).expect(name);
        assert_eq!(check.outcome, Outcome::Pass, "{name}: {}", check.reason);
    }
    assert!(evidence.notes.iter().any(|note| note.contains("one source")));
    recommends_what_its_runs_show(&evidence);
}

/// The method that is recommended has the fewest evaluations of all runs that are accurate enough.
fn recommends_what_its_runs_show(evidence: &Evidence) {
    let section = evidence.sections.iter().find(|section| section.id == "model-recommendation").expect("a section");
    assert_eq!(section.figures, ["model-solution", "model-work"]);
    let answer = &section.paragraphs[0].1;
    let code: Vec<&str> = answer.split('`').skip(1).step_by(2).collect();
    let table = evidence.tables.iter().find(|table| table.id == "model-work").expect("its runs");
    let column = |row: &[Cell], name| row[table.column(name).expect("a column")].clone();
    let number = |row: &[Cell], name| column(row, name).number().expect("a number");
    // The error asked for is 1e-5 of the solution at the end, or of 1 where that is smaller.
    let solution = evidence.tables.iter().find(|table| table.id == "model-solution").expect("its solution");
    let end = solution.rows.last().expect("rows").iter().skip(1).filter_map(Cell::number);
    let target = 1e-5 * end.map(f64::abs).fold(1.0, larger);
    let reached = table.rows.iter().filter(|row| number(row, "error") <= target);
    let is_own = |row: &&Vec<Cell>| method::parse(&column(row, "solver").to_string()).is_ok();
    let best = reached.filter(is_own).min_by_key(|row| number(row, "evaluations") as u64).expect("a run");
    assert_eq!(code[0], column(best, "solver").to_string(), "{answer}");
    assert!(answer.contains(&format!("{} evaluations", number(best, "evaluations"))), "{answer}");
    let reached = table.rows.iter().filter(|row| number(row, "error") <= target).filter(is_own);
    let implicit = reached.filter(|row| number(row, "factorizations") > 0.0);
    let thrifty = implicit.min_by_key(|row| number(row, "factorizations") as u64).expect("a run");
    let basis: String = section.paragraphs.iter().map(|(_, text)| text.as_str()).collect();
    let count = number(thrifty, "factorizations");
    assert!(
        basis.split_whitespace().collect::<Vec<_>>().join(" ").contains(&format!("is the best with {count}.")),
        "{basis}"
    );
}

#[test]
fn methods_that_need_more_than_a_model_has_refuse() {
    let model = load("van-der-pol.ds", &[]);
    let Err(error) = method::parse("path-fitted(3)").expect("known").build(&model) else { panic!("it was built") };
    assert!(error.reason.contains("Lagrangian of mechanics"), "{error}");
}

/// Every state of a run, or what stopped it.
fn states(problem: &dyn Problem, method: &str, h: f64, t_end: f64) -> Result<Vec<Vec<f64>>, String> {
    let method = method::parse(method).expect("known");
    let mut all = Vec::new();
    let result = verify::run::run(problem, &*method, h, t_end, |state| all.push(state.q.clone()));
    result.map(|_| all).map_err(|error| error.to_string())
}

/// Heat on a line in n cells, with and without a term that is not linear.
fn heat(n: usize, more: &str) -> Model {
    let mut equations = String::new();
    for i in 0..n {
        let left = if i > 0 { format!("u[{}]", i - 1) } else { "0".into() };
        let right = if i + 1 < n { format!("u[{}]", i + 1) } else { "0".into() };
        equations += &format!("  k * ({left} - 2 * u[{i}] + {right}) + sin(t){},\n", more.replace('#', &i.to_string()));
    }
    let text = format!("in_i {{ k = 100 }}\nu_i {{ (0:{n}): x = 1 }}\nF_i {{\n{equations}}}\n");
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("heat-{n}-{}.ds", more.len()));
    fs::write(&path, text.replace("u[", "u_i[")).expect("writable");
    Model::load(&path, &[], None).expect("valid")
}

#[test]
fn sparsity_and_linearity_are_those_of_the_text() {
    let linear = heat(40, "");
    let field = linear.field();
    assert_eq!(field.structure(), Structure::Banded { lower: 1, upper: 1 });
    assert!(field.is_linear());
    let mut jacobian = Jacobian::with_structure(40, &field.structure());
    field.add_jacobian(0.3, &[0.5; 40], 1.0, &mut jacobian);
    assert_eq!([jacobian.get(7, 6), jacobian.get(7, 7), jacobian.get(7, 8)], [100.0, -200.0, 100.0]);
    for more in [" - u[#] * u[#]", " - exp(u[#])", " + t * u[#]", " + 1 / u[#]", " - u[#] / (1.0 + t)"] {
        assert!(!heat(40, more).field().is_linear(), "{more}");
    }
    assert_eq!(load("van-der-pol.ds", &[]).field().structure(), Structure::Dense);
    // The work of a linear system does not depend on what has been factored before.
    let run = states(&linear, "method-i", 0.01, 0.1).expect("solvable");
    assert_eq!(run.len(), 11);
}

#[test]
fn entries_of_a_block_that_has_a_name_are_counted_within_it() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("blocks.ds");
    fs::write(&path, "u_i { x = 1, (1:3): y = 2, z = 3 } F_i { x, (1:3): 2.0, z }").expect("writable");
    let model = Model::load(&path, &[], None).expect("valid");
    assert_eq!(verify::problem::component_names(&model), ["x", "y[0]", "y[1]", "z"]);
}

/// Exit status and standard error of `verify order` on a model of this text.
fn complain(name: &str, text: &str, more: &[&str]) -> (Option<i32>, String) {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("model");
    fs::create_dir_all(&directory).expect("writable");
    let file = format!("{name}.ds");
    fs::write(directory.join(&file), text).expect("writable");
    let mut command = Command::new(env!("CARGO_BIN_EXE_verify"));
    command.current_dir(directory).args(["order", "--method", "method-i", "--model", &file]).args(more);
    let output = command.output().expect("starts");
    assert!(output.stdout.is_empty());
    (output.status.code(), String::from_utf8(output.stderr).expect("UTF-8"))
}

/// Its slopes fall from 4.16 to 4.06 before the bound of the reference cuts them off: those of the finest four steps are in the band.
#[test]
fn a_right_method_of_high_order_is_not_refuted_for_a_reference_of_few_digits() {
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/models/van-der-pol.ds");
    let order = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_verify"));
        command.args(["order", "--model", model, "--set", "mu=1", "--t-end", "2", "--method", "rk4"]).args(more);
        let output = command.output().expect("starts");
        (output.status.code(), String::from_utf8(output.stdout).expect("UTF-8"))
    };
    let (status, text) = order(&[]);
    assert_eq!(status, Some(0), "{text}");
    let (status, text) = order(&["--reference-tolerance", "1e-12"]);
    assert!(status == Some(0) && text.contains("is 4 ± 0.1"), "{text}");
}

/// The local slopes of RK4 end at 3.95, 4.11 and 4.10, where the floor cuts them off.
#[test]
fn slopes_outside_the_band_that_still_approach_the_order_are_inconclusive_for_methods_built_in_and_from_files() {
    let directory = scratch("model/approach");
    fs::create_dir_all(&directory).expect("writable");
    let model = directory.join("sir.ds");
    let text = "u_i { s = 0.99, i = 0.01, r = 0 }\n\
                F_i { 0.02 - 1.5*s*i - 0.02*s, 1.5*s*i - 0.42*i, 0.4*i - 0.02*r }\n";
    fs::write(&model, text).expect("writable");
    let model = model.to_str().expect("UTF-8");
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/methods/rk4.toml");
    for method in ["rk4", file] {
        for problem in [
            &["--model", model, "--t-end", "5"][..],
            &["--problem", "logistic", "--set", "lambda=10"],
            &["--problem", "van-der-pol", "--set", "mu=5"],
        ] {
            let mut command = Command::new(env!("CARGO_BIN_EXE_verify"));
            let output = command.args(["order", "--method", method]).args(problem).output().expect("starts");
            let text = String::from_utf8(output.stdout).expect("UTF-8");
            let is_told = flat(&text).contains("still approach 4 where errors reach their floor");
            // The floor of a model's reference decides which of the two it is.
            let passes = problem[0] == "--model" && output.status.code() == Some(0);
            assert!(passes || output.status.code() == Some(3) && is_told, "{method} {problem:?}: {text}");
        }
    }
}

#[test]
fn a_mistake_is_shown_with_its_file_and_line() {
    let valid = "in_i { a = 1 }\nu_i { x = 1 }\nF_i { -a * x }\n";
    for (name, text, words) in [
        ("syntax", "u_i { x = 1 }\nF_i { (x }\n", vec!["--> syntax.ds:2:10", "2 | F_i { (x }"]),
        (
            "unknown",
            "u_i { x = 1 }\nF_i {\n  2 * z\n}\n",
            vec!["--> unknown.ds:3:7", "3 |   2 * z", "unknown name `z`"],
        ),
        (
            "call",
            "u_i { x = 1 }\nF_i { -x *\n foo(x) }\n",
            vec!["--> call.ds:3:2", "3 |  foo(x) }", "unknown function `foo`"],
        ),
        ("shape", "u_i { x = 1 }\nF_i { x, -x }\n", vec!["--> shape.ds:2:1", "2 | F_i { x, -x }", "F has 2 rows"]),
        ("empty", "", vec!["empty.ds: the state is missing"]),
        ("old", "in = [a]\nu_i { x = 1 }\nF_i { x }\n", vec!["old.ds: input list is no longer supported"]),
        (
            "mass",
            "u_i { x = 1 }\ndudt_i { y = 0 }\nM_i { 0 * y }\nF_i { x }\n",
            vec![
                "mass.ds is not of the form M du/dt = F(t, u): M_i, in line 3, states a product of which row 1 has no dudt",
            ],
        ),
        (
            "event",
            "u_i { x = 1 }\nF_i { x }\nstop_i { x - 2 }\n",
            vec!["event.ds is not", "stop_i, in line 3, states events, at which no run here stops; leave it out, or"],
        ),
        ("start", "u_i { x = log(0 - 1) }\nF_i { x }\n", vec!["x at t = 0 = NaN"]),
        (
            "twice",
            "in_i { a = 1, a = 2 }\nu_i { x = 1 }\nF_i { a * x }\n",
            vec!["twice.ds is not", "`a` names two things"],
        ),
        ("state", "u_i { v = 2, u = 1 }\nF_i { u, v }\n", vec!["`u` names two things, in line 1, and"]),
        (
            "named",
            "u_i { x = 1 }\n// x = 2\nF_i { x = -x }\n",
            vec!["`x` names two things, in lines 1 and 3, and", "or leave its name out"],
        ),
        ("both", "u_i { a = 1, a = 2 }\nF_i { -a, -a }\n", vec!["`a` names two things"]),
        ("shadow", "in_i { k = 3 }\nu_i { k = 1 }\nF_i { -k }\n", vec!["`k` names two things"]),
        ("inside", "u_i { x = 1 }\nz_i { x = 3, q = 4 }\nF_i { -x }\n", vec!["`x` names two things"]),
        ("time", "u_i { t = 1 }\nF_i { -t }\n", vec!["time.ds:1:7", "t is a reserved name"]),
        ("clock", "u_i { x = 1, y = 2 * t }\nF_i { -x, -y }\n", vec!["--> clock.ds:1:18", "depends on time through t"]),
        (
            "later",
            "in_i { k = 2 }\na { k * cos(t) }\nb { 3 * a }\nu_i { x = 1 + b }\nF_i { -x }\n",
            vec!["--> later.ds:4:11", "depends on time through b"],
        ),
        ("nodes", "r_i { t, 2 * t }\nu_i { r_i }\nF_i { -u_i }\n", vec!["--> nodes.ds:2:7", "through r"]),
        ("output", "u_i { x = 1 }\nF_i { x }\nout_i { 2 * x }\n", vec!["out_i, in line 3, states outputs"]),
        ("comma", "in_i { k = 1,5 }\nu_i { x = 1 }\nF_i { -k * x }\n", vec!["comma.ds is not", "`5` among its inputs"]),
        ("rows", "u_i { x = 1, v = 0 }\nF_i { dvdt = -x, dxdt = v }\n", vec!["`dvdt` is at the place of x"]),
        ("default", "in_i { a = 1 + 1 }\nu_i { x = 1 }\nF_i { a * x }\n", vec!["default of its input `a`"]),
    ] {
        let (status, message) = complain(name, text, &[]);
        assert_eq!(status, Some(2), "{message}");
        assert!(words.iter().all(|word| message.contains(word) || flat(&message).contains(word)), "{name}: {message}");
        assert!(!flat(&message).contains("panicked"), "{message}");
    }
    for (more, words) in [
        (["--set", "b=1"], "has no input `b`; it has a"),
        (["--set", "a=fast"], "a = fast: not a finite number"),
        (["--t-end", "-1"], "expected a positive number"),
        (["--reference", "exact"], "no exact solution is known"),
        (["--problem", "logistic"], "cannot be used with"),
    ] {
        let (status, message) = complain("valid", valid, &more);
        assert_eq!(status, Some(2), "{message}");
        assert!(flat(&message).contains(words), "{message}");
    }
    assert!(matches!(Model::load(Path::new("no such file"), &[], None), Err(ModelError::Read { .. })));
}

/// The model of a text.
/// The rest of what DiffSL says follows from the first.
#[test]
fn a_mistake_is_one_message_with_its_place_and_what_mends_it() {
    for (text, place, words) in [
        ("in_i { k = 1 }\nu_i { x = 1, y = 0 }\nF_i { y, -kk*x }", "3:11", "unknown name `kk`; did you mean `k`?"),
        (
            "u_i { x = 1, y = 2 }\na { foo*x }\nF_i { a, a*y }",
            "2:5",
            "unknown name `foo`; state it before, as an input",
        ),
        ("u_i { x = 1 }\nF_i { -a*x } // a\na { 3 }", "2:8", "`a` is used before it is stated, in line 3"),
        ("u_i { x = 1, y = x }\nF_i { -x, y }", "1:18", "`x`, of line 1, is known after the closing brace"),
        ("u_i { x = 1 }\nF_i { -sin*x }", "2:8", "`sin` is a function"),
        ("u_i { x = 1 }\nF_i { -sinn(x) }", "2:8", "unknown function `sinn`; did you mean `sin`?"),
        ("u_i { x = 1 }\nF_i { -qqq (x) }", "2:8", "unknown function `qqq`; there are sin, cos"),
        ("u_i { x = 1 }\nF_i { -asin(x) }", "2:8", "unknown function `asin`; there are sin, cos"),
        ("u_i { x = 1 }\nF_i { -ln(x) }", "2:8", "DiffSL has it as log(x)"),
        ("u_i { x = 1 }\nF_i { -pi*x }", "2:8", "write 3.141592653589793"),
        ("u_i { x = 1 }\nF_i { cos(time) }", "2:11", "time is `t`"),
        ("u_i { v = 1 }\nF_i { -V }", "2:8", "did you mean `v`?"),
        ("u_i { x = 1d3 }\nF_i { -x }", "1:12", "a small e"),
        ("u_i { x = 1 }\nF_i { -2d }", "2:9", "products are written as 2 * x"),
        ("u_i { x = 1 }\nF_i { if x }", "2:10", "there are no comparisons; heaviside"),
        ("u_i { x = 1 }\nF_i { x == 0 }", "2:10", "there are no comparisons; heaviside"),
        ("u_i { x = 1, v = 0 }\nF_i { x' = v, v' = -x }", "2:8", "without the rates that they are"),
        ("u_i { x = 1 }\nF_i { dx/dt = -x }", "2:13", "rows of F need none"),
        ("u_i { x := 1 }\nF_i { -x }", "1:9", "values are given with ="),
        ("u_i { x = 1 }\nF_i { \u{2212}x }", "2:7", "is not the minus sign of a keyboard"),
        ("u_i { x = 1 }\nF_i { 2\u{b7}x }", "2:8", "is not the sign of products, *"),
        ("u_i { \u{3b1} = 1 }\nF_i { 2 }", "1:7", "those of ASCII, and `\u{3b1}` is not"),
        ("u_i { x = 1\u{a0}E5 }\nF_i { 2 }", "1:12", "not that of a keyboard"),
        ("u_i { x = 1 }\nF_i { -dudt }", "2:8", "DiffSL calls the rate of the state so"),
        ("/* u0 */ u0 { 3 }\nu_i { x = 1 }\nF_i { -u0*x }", "1:10", "u0 is a reserved name: DiffSL has a use"),
        ("u_i { x = 1, root = 2 }\nF_i { -x, root }", "1:14", "root is a reserved name"),
        ("t { 3 }\nu_i { x = 1 }\nF_i { -t*x }", "1:1", "t is a reserved name"),
        ("u_i { x = 1\nF_i { -x }", "2:1", "the `{` of line 1 is not closed: `}` is missing before this"),
        ("u_i { x = 1 }\nF_i { -x ", "2:", "the `{` of line 2 is not closed"),
        ("u_i { x = 1 }\nF_i { -(x + 2 }", "2:15", "the `(` of line 2 is not closed"),
        ("u_i { x = 1 }\nF_i { -x + 2) }", "2:13", "this `)` closes nothing"),
        ("u_i { x = 1 } }\nF_i { -x }", "1:15", "this `}` closes nothing"),
        ("u_i { x = 1, y = 2 }\nF_i { -x -y }", "2:1", "F has 1 row and the state u 2 components; each"),
        ("u_i { x = 1 }\nF_i { -x^2 }", "2:9", "powers are written as pow(x, 2)"),
        ("u_i { x = 1 }\nF_i { -x**2 }", "2:10", "powers are written as pow(x, 2)"),
        ("u_i { x = 1 }\nF_i { -2x }", "2:9", "an operator or a comma is missing before this"),
        ("u_i { x = 1 y = 2 }\nF_i { -x, -y }", "1:13", "an operator or a comma is missing before this"),
        ("u_i { x = 1; y = 2 }\nF_i { -x, -y }", "1:12", "parted by commas"),
        ("u_i { x = 1 }\nF_i { x > 0 }", "2:9", "there are no comparisons; heaviside"),
        ("u_i { x = 1 }\n# f\nF_i { x }", "2:1", "comments begin with //"),
        ("u_i { x = .5 }\nF_i { x }", "1:11", "numbers begin with a digit"),
        ("u_i { x = 1E5 }\nF_i { x }", "1:12", "a small e"),
        ("in_i { k_1 = 1 }\nu_i { x = 1 }\nF_i { -x }", "1:10", "names have letters and digits alone"),
        ("u_i { x = 1 }\nx' = -x", "2:1", "a model consists of tensors"),
        ("u { x = 1, y = 2 }\nF { x, y }", "1:12", "what has several has an index"),
    ] {
        let Err(ModelError::Compile(told)) = of_text(text) else { panic!("{text}") };
        assert!(told.contains(&format!(".ds:{place}")) && told.contains(words), "{text}\n{told}");
        assert!(told.matches("-->").count() == 1 && told.lines().count() == 5, "{told}");
    }
    for (text, words) in [
        ("u_i { x = 1 }", "f is missing; state it as F_i { y, -x }, with a row for each component"),
        ("u_i { x = 1 }\nf_i { -x }", "a row for each component; `f` in line 2 is another name than `F`"),
        ("F_i { 1 }", "the state is missing; state it as u_i {"),
    ] {
        let Err(ModelError::Compile(told)) = of_text(text) else { panic!("{text}") };
        assert!(told.contains(words) && told.lines().count() == 1, "{told}");
    }
    let told = of_text("u { x = 1 } F { -x }").expect_err("scalars").to_string();
    assert!(told.contains("are vectors, with an index"), "{told}");
}

fn of_text(text: &str) -> Result<Model, ModelError> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("text.ds");
    std::fs::write(&path, text).expect("room");
    Model::load(&path, &[], None)
}

/// DiffSL differentiates a power by its exponent too, with a logarithm that has no value at x < 0.
#[test]
fn powers_with_whole_exponents_have_derivatives_at_negative_numbers() {
    let x = -1.3_f64;
    for (text, f, slope) in [
        ("pow(x, 3)", x.powi(3), 3.0 * x.powi(2)),
        ("2 * pow(x - 0.5, 2) - pow(x, 1)", 2.0 * (x - 0.5).powi(2) - x, 4.0 * (x - 0.5) - 1.0),
        ("pow(x, -2)", x.powi(-2), -2.0 * x.powi(-3)),
        (
            "pow(pow(x, 2), 1.5) + sin(pow(x, 5))",
            -x.powi(3) + x.powi(5).sin(),
            -3.0 * x.powi(2) + x.powi(5).cos() * 5.0 * x.powi(4),
        ),
        ("pow(x, 16)", x.powi(16), 16.0 * x.powi(15)),
    ] {
        let model = of_text(&format!("u_i {{ x = 1 }} F_i {{ {text} }}")).expect("a model");
        let (found, jacobian) = derivatives(&model, 0.0, &[x]);
        agree(&found, &[f], f.abs().max(1.0));
        agree(&jacobian, &[slope], 2.0 * slope.abs().max(1.0));
    }
    // Where the exponent is no whole number, a power of a negative number has no value.
    let model = of_text("u_i { x = 1 } F_i { pow(x, 1.5) }").expect("a model");
    let mut f = [0.0];
    model.ode().rhs(0.0, &[x], &mut f);
    assert!(f[0].is_nan());
}

/// What is known not to depend on time is not looked at for that.
#[test]
fn a_model_is_autonomous_where_no_time_is_in_its_text() {
    for (text, expected) in [
        ("u_i { x = 1 } F_i { -x }", true),
        ("in_i { t0 = 1 } a { t0*2 } u_i { x = 1 } s_i { x*x } F_i { a*s_i - x }", true),
        ("u_i { x = 1 } F_i { t - x }", false),
        ("u_i { x = 1, y = 1 } F_i { -x, -y*heaviside(t - 1) }", false),
        ("a { cos(t) } u_i { x = 1 } F_i { a - x }", false),
        ("a { cos(t) } b { 2*a } u_i { x = 1 } F_i { b*x }", false),
        ("u_i { x = 1 } s_i { x*t } F_i { -s_i }", false),
    ] {
        assert_eq!(of_text(text).expect("a model").ode().is_autonomous(), expected, "{text}");
    }
}

#[test]
fn a_model_of_any_length_is_compiled_or_refused() {
    let sum = |terms: usize| format!("u_i {{ x = 1 }} F_i {{ -x{} }}", " - 0.5 * x".repeat(terms));
    let model = of_text(&sum(8000)).expect("a model");
    let (f, jacobian) = derivatives(&model, 0.0, &[1.0]);
    assert_eq!((f[0], jacobian[0]), (-4001.0, -4001.0));
    let nested = format!("u_i {{ x = 1 }} F_i {{ {}-x{} }}", "(".repeat(5000), ")".repeat(5000));
    assert_eq!(derivatives(&of_text(&nested).expect("a model"), 0.0, &[2.0]).0[0], -2.0);
    assert!(matches!(of_text(&sum(200_000)), Err(ModelError::TooLong { length, .. }) if length > 1 << 20));
}

/// The exit status of `verify` on a model of this text, and what it says on both streams.
fn said(name: &str, text: &str, line: &[&str]) -> (Option<i32>, String) {
    let path = scratch(&format!("dose/{name}.ds"));
    fs::create_dir_all(path.parent().expect("a directory")).expect("writable");
    fs::write(&path, text).expect("writable");
    let mut command = Command::new(env!("CARGO_BIN_EXE_verify"));
    let command = command.arg(line[0]).arg("--model").arg(&path).args(&line[1..]).env("NO_COLOR", "1");
    let output = command.output().expect("it starts");
    let [out, error] = [output.stdout, output.stderr].map(|bytes| flat(&String::from_utf8_lossy(&bytes)));
    (output.status.code(), format!("{out} {error}"))
}

const DOSE: &str = "u_i { blood = 0.5, tissue = 0.5 }\ninfusion { heaviside(t - 20) * heaviside(20.5 - t) }\n\
                    F_i { tissue - blood + infusion, blood - tissue }\n";

/// A dose at rest, an eightieth of the time: nothing before it tells a tolerance that it comes.
#[test]
fn a_dose_is_seen_by_references_and_estimates_and_breaks_no_invariant() {
    let (code, text) = said("dose", DOSE, &["compare", "--t-end", "40"]);
    assert!(code != Some(1) && text.contains(" 0 do not"), "{text}");
    let (_, text) = said("dose", DOSE, &["solve", "--method", "radau-adaptive", "--t-end", "40"]);
    assert!(text.contains("with a tenth of the tolerances it is another solution"), "{text}");
    let (_, text) = said("dose", DOSE, &["solve", "--method", "rk4", "--h", "0.1", "--t-end", "40"]);
    assert!(!text.contains("conserves"), "{text}");
    // Where the run stays below the tolerance and one with a tenth of it does not, the latter alone is told.
    let small = DOSE.replace("0.5,", "1e-12,").replace("0.5 }", "1e-12 }");
    let (_, text) = said("small", &small, &["solve", "--method", "radau-adaptive", "--t-end", "40"]);
    let words = ["with a tenth of the tolerances it is another solution", "no component comes to"];
    assert_eq!(words.map(|words| text.contains(words)), [true, false], "{text}");
}

#[test]
fn a_solution_below_the_tolerance_and_growth_from_zero_are_told_apart_from_others() {
    let tiny = "u_i { x = 1e-12, y = 0 }\nF_i { y, -x }\n";
    let tells = |more: &[&str]| {
        let line = [&["solve", "--method", "radau-adaptive", "--t-end", "10"], more].concat();
        said("tiny", tiny, &line).1.contains("no component comes to the absolute tolerance")
    };
    assert!(tells(&[]) && tells(&["--no-estimate"]) && !tells(&["--atol", "1e-18"]));
    let late = "u_i { x = 0 }\nF_i { -x + heaviside(t - 1) * (t - 1) }\n";
    let (_, text) = said("late", late, &["solve", "--method", "rk4", "--h", "0.01", "--t-end", "3"]);
    assert!(!text.contains("resolves nothing"), "{text}");
}

/// On a ring the corners keep the pattern from being a band; every entry is there, the first one too.
#[test]
fn the_jacobian_of_a_sparse_model_is_that_of_its_text() {
    const N: usize = 40;
    let state: Vec<_> = (0..N).map(|i| format!("v{i} = {}", 0.1 + 0.01 * i as f64)).collect();
    let rate: Vec<_> = (0..N).map(|i| format!("-{}*v{i} + v{}*v{i}", i + 1, (i + 1) % N)).collect();
    let path = scratch("model/ring.ds");
    fs::create_dir_all(path.parent().expect("a folder")).expect("writable");
    fs::write(&path, format!("u_i {{ {} }} F_i {{ {} }}", state.join(", "), rate.join(", "))).expect("writable");
    let model = Model::load(&path, &[], Some(1.0)).expect("a model");
    assert!(matches!(model.field().structure(), Structure::Sparse(_)), "{:?}", model.field().structure());
    let v = model.initial();
    let mut found = Jacobian::with_structure(N, &model.field().structure());
    model.field().add_jacobian(0.0, &v, 1.0, &mut found);
    let mut expected = Jacobian::zeros(N);
    for i in 0..N {
        expected.add(i, i, v[(i + 1) % N] - (i + 1) as f64);
        expected.add(i, (i + 1) % N, v[i]);
    }
    agree(found.to_dense().as_slice(), expected.to_dense().as_slice(), 40.0);
}

/// The references eliminate in the band that methods do.
#[test]
fn the_references_of_a_model_know_its_band() {
    const N: usize = 40;
    let state: Vec<_> = (0..N).map(|i| format!("v{i} = {}", 0.1 + 0.01 * i as f64)).collect();
    let rate = |i: usize| match i {
        0 => "v1 - v0".to_owned(),
        i => format!("v{} - v{i}", i - 1),
    };
    let rates: Vec<_> = (0..N).map(rate).collect();
    let path = scratch("model/band.ds");
    fs::create_dir_all(path.parent().expect("a folder")).expect("writable");
    fs::write(&path, format!("u_i {{ {} }} F_i {{ {} }}", state.join(", "), rates.join(", "))).expect("writable");
    let model = Model::load(&path, &[], Some(1.0)).expect("a model");
    assert_eq!(model.field().structure(), Structure::Banded { lower: 1, upper: 1 });
    assert_eq!(model.ode().bandwidths(), Some((1, 1)));
    assert_eq!(load("van-der-pol.ds", &[]).ode().bandwidths(), None);
}
