//! Method files: what is shipped is right, and every misprint in it would be found.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use verify::evidence::{Cell, Outcome};
use verify::judge::diagnosis::Diagnosis;
use verify::judge::file::{Body, FileError, MethodFile, SHIPPED};
use verify::judge::linear::Reach;
use verify::judge::parts::Coupling;
use verify::judge::tableau::{Coefficient, Place, Tableau};
use verify::judge::{Effort, Judgement, Kind, Verdict};
use verify::measure::stability::Uniform;

#[path = "../../examples/judge_own_method.rs"]
mod judge_own_method;

/// Its main fails on a claim that is not confirmed.
#[test]
fn the_example_of_an_own_method_is_confirmed() {
    judge_own_method::main().expect("Heun's method has order 3");
}

fn files(directory: &str) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("methods").join(directory);
    let entries = std::fs::read_dir(root).expect("a directory").map(|entry| entry.expect("readable").path());
    let mut files: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
    files.sort();
    assert!(!files.is_empty());
    files
}

fn judge(text: &str, effort: Effort) -> Judgement {
    Judgement::new(MethodFile::parse("test.toml", "test", text).expect(text), effort)
}

fn published(name: &str) -> Judgement {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("methods/misprints").join(name);
    Judgement::new(MethodFile::load(&path).expect("well-formed"), Effort::Theory)
}

#[test]
fn every_claim_of_every_shipped_file_is_confirmed_by_theory_and_by_runs() {
    let right = crate::judgements::RUN.iter().filter(|(name, _)| name != "bdf7");
    let open: Vec<String> = right
        .flat_map(|(name, judgement)| {
            assert!(judgement.file.order().is_some() && judgement.file.source.is_some(), "{name}");
            assert!(matches!(judgement.diagnosis, Diagnosis::Sound), "{name}: {:?}", judgement.diagnosis);
            assert!(judgement.measured.iter().filter(|measured| measured.result.is_ok()).count() >= 2);
            let open = judgement.verdicts.iter().filter(|verdict| {
                !matches!(verdict.check.outcome, Outcome::Pass | Outcome::NotSettled | Outcome::NotRun)
            });
            open.map(move |verdict| format!("{name}: {verdict:?}"))
        })
        .collect();
    assert!(open.is_empty(), "{open:#?}");
}

#[test]
fn published_misprints_are_found_and_mended() {
    for (name, place, text) in
        [("fehlberg45-a63.toml", Place::A(5, 2), "-3544/2565"), ("rk4-a44.toml", Place::A(3, 3), "0")]
    {
        let judgement = published(name);
        assert_eq!(judgement.outcome(), Outcome::Fail, "{name}");
        let [repair] = judgement.repairs() else { panic!("{name}: {:?}", judgement.diagnosis) };
        assert_eq!((repair.place, repair.text.as_str()), (place, text), "{name}");
    }
    let judgement = published("kraaijevanger-spijker.toml");
    assert!(matches!(judgement.diagnosis, Diagnosis::LabelTooHigh { order: 1 }), "{:?}", judgement.diagnosis);
    assert_eq!(judgement.outcome(), Outcome::Fail);
}

/// Gauss' method of three stages with so many places, with what is claimed of it and of none of its neighbours.
fn gauss_to(places: usize) -> String {
    let root = 15.0_f64.sqrt();
    let rows = [
        [5.0 / 36.0, 2.0 / 9.0 - root / 15.0, 5.0 / 36.0 - root / 30.0],
        [5.0 / 36.0 + root / 24.0, 2.0 / 9.0, 5.0 / 36.0 - root / 24.0],
        [5.0 / 36.0 + root / 30.0, 2.0 / 9.0 + root / 15.0, 5.0 / 36.0],
    ];
    let row = |row: &[f64]| row.iter().map(|x| format!("'{x:.places$}'")).collect::<Vec<_>>().join(", ");
    let a = rows.map(|entries| format!("[{}]", row(&entries))).join(", ");
    let b = row(&[5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0]);
    format!("order = 6\nclaims = ['symplectic', 'symmetric', 'A-stable']\na = [{a}]\nb = [{b}]\n")
}

/// The subjects of what is measured of structure.
const STRUCTURE: [&str; 3] = ["symplectic", "symmetric", "energy"];

/// What rounding does to a step is neither what the method is off by, nor shows that it is off by nothing.
#[test]
fn runs_of_a_right_tableau_allow_for_the_digits_that_it_is_printed_to() {
    let refuted: Vec<String> = (6..=14)
        .into_par_iter()
        .flat_map_iter(|places| {
            let judgement = judge(&gauss_to(places), Effort::Runs);
            let told = |subject: &str| {
                let is_run = |verdict: &&Verdict| verdict.kind == Kind::Run && verdict.subject == subject;
                judgement.verdicts.iter().find(is_run).map(|verdict| verdict.check.outcome)
            };
            let open = [Outcome::NotSettled; 3].map(Some);
            match places {
                6..=8 => assert_eq!(STRUCTURE.map(told), open, "{places}"),
                13.. => assert_eq!(STRUCTURE.map(told), [Outcome::Pass; 3].map(Some), "{places}"),
                _ => {}
            }
            let refuted = judgement.verdicts.iter().filter(|verdict| verdict.check.outcome == Outcome::Fail);
            refuted.map(|verdict| format!("{places} places: {verdict:?}")).collect::<Vec<_>>()
        })
        .collect();
    assert!(refuted.is_empty(), "{refuted:#?}");
}

/// 0.48 for 0.4804 in the fourth of twelve places, or one unit of the eleventh.
#[test]
fn a_wrong_digit_within_those_printed_is_refuted() {
    let right = gauss_to(12);
    for (digits, wrong) in [("0.480421111969", "0.480521111969"), ("0.480421111969", "0.480421111989")] {
        assert!(right.contains(digits), "{right}");
        let judgement = judge(&right.replace(digits, wrong), Effort::Runs);
        let outcome = |subject: &str| {
            let of_claim = judgement.verdicts.iter().find(|verdict| verdict.subject == subject).expect("claimed");
            of_claim.check.outcome
        };
        assert_eq!(["order 6", "symplectic", "symmetric"].map(outcome), [Outcome::Fail; 3], "{wrong}");
    }
}

/// Gauss' method of four stages and Radau IIA of order 7 to three places, backward differentiation to two: what they are is open, and nothing of it
/// refuted.
#[test]
fn few_digits_of_a_right_method_refute_nothing_of_it() {
    let gauss = "order = 8
claims = ['symplectic', 'symmetric', 'A-stable', 'algebraically stable']
digits = 3
c = ['0.069', '0.330', '0.670', '0.931']
a = [['0.087', '-0.027', '0.013', '-0.004'], ['0.188', '0.163', '-0.028', '0.007'], ['0.167', '0.354', '0.163', '-0.014'], ['0.177', '0.313', '0.353', '0.087']]
b = ['0.174', '0.326', '0.326', '0.174']
";
    let radau = "order = 7
claims = ['L-stable', 'stiffly accurate', 'not symplectic']
digits = 3
c = ['0.089', '0.409', '0.788', '1.000']
a = [['0.113', '-0.040', '0.026', '-0.010'], ['0.234', '0.207', '-0.048', '0.016'], ['0.217', '0.406', '0.189', '-0.024'], ['0.220', '0.388', '0.329', '0.062']]
b = ['0.220', '0.388', '0.329', '0.062']
";
    let bdf3 = "kind = 'multistep'
order = 3
claims = ['A(86.0)-stable']
digits = 2
rho = ['-0.33', '1.50', '-3.00', '1.83']
sigma = [0, 0, 0, 1]
";
    let bdf5 = "kind = 'multistep'
order = 5
digits = 2
rho = ['-0.20', '1.25', '-3.33', '5.00', '-5.00', '2.28']
sigma = [0, 0, 0, 0, 0, '1.00']
";
    for (text, open) in [
        (gauss, &["A-stable"][..]),
        (radau, &["order 7", "L-stable"]),
        (bdf3, &["A(86.0°)-stable"]),
        (bdf5, &["order 5"]),
    ] {
        let judgement = judge(text, Effort::Theory);
        assert_eq!(judgement.outcome(), Outcome::Inconclusive, "{:?}", judgement.verdicts);
        assert!(matches!(judgement.diagnosis, Diagnosis::Sound), "{:?}", judgement.diagnosis);
        for subject in open {
            let claim = judgement.verdicts.iter().find(|verdict| verdict.subject == *subject).expect(subject);
            assert_eq!(claim.check.outcome, Outcome::Inconclusive, "{subject}: {}", claim.check.reason);
        }
    }
}

/// The file again, with `text` at `place`.
fn corrupted(file: &MethodFile, tableau: &Tableau, place: Place, text: &str) -> String {
    let mut out = format!("kind = \"runge-kutta\"\norder = {}\n", file.order().expect("claimed"));
    if let Some(order) = file.claims.iter().find_map(|claim| claim.as_embedded_order()) {
        let _ = writeln!(out, "embedded_order = {order}");
    }
    let list = |coefficients: &[Coefficient], at: &dyn Fn(usize) -> Place| {
        let one = |(i, c): (usize, &Coefficient)| format!("\"{}\"", if at(i) == place { text } else { &c.text });
        format!("[{}]", coefficients.iter().enumerate().map(one).collect::<Vec<_>>().join(", "))
    };
    let rows: Vec<String> = tableau.a.iter().enumerate().map(|(i, row)| list(row, &|j| Place::A(i, j))).collect();
    let _ = writeln!(out, "a = [{}]\nb = {}", rows.join(", "), list(&tableau.b, &Place::B));
    for (key, list) in [
        ("c", tableau.c.as_deref().map(|c| list(c, &Place::C))),
        ("b_hat", tableau.b_hat.as_deref().map(|b| list(b, &Place::Hat))),
    ] {
        if let Some(list) = list {
            let _ = writeln!(out, "{key} = {list}");
        }
    }
    out
}

/// `text` with another digit in one place, or with its sign changed; none of the digits beyond the 20th.
fn misprint(text: &str, random: &mut Uniform) -> String {
    let mut draw = |n: usize| ((random.next().expect("endless") + 1.0) / 2.0 * n as f64) as usize % n.max(1);
    if draw(5) == 0 {
        return text.strip_prefix('-').map_or_else(|| format!("-({text})"), |rest| format!("({rest})"));
    }
    let is_digit = |(i, c): &(usize, char)| {
        // What a root is taken of is a word of the formula and not a number of the method.
        c.is_ascii_digit()
            && *i < 20
            && !text[..*i].ends_with("sqrt(")
            && !text[..*i].ends_with("sqrt(1")
            && !text[..*i].ends_with('^')
    };
    let digits: Vec<usize> = text.char_indices().filter(is_digit).map(|(i, _)| i).collect();
    let at = digits[draw(digits.len())];
    let old = text[at..=at].parse::<usize>().expect("a digit");
    format!("{}{}{}", &text[..at], (old + 1 + draw(9)) % 10, &text[at + 1..])
}

fn shipped(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("methods/{name}.toml"));
    std::fs::read_to_string(path).expect("there")
}

/// The subjects of what is not confirmed, of those that ran.
fn refuted(judgement: &Judgement) -> Vec<&str> {
    let open = |outcome| !matches!(outcome, Outcome::Pass | Outcome::NotSettled | Outcome::NotRun);
    judgement.verdicts.iter().filter(|v| open(v.check.outcome)).map(|v| v.subject.as_str()).collect()
}

#[test]
fn embedded_weights_that_do_not_add_up_to_one_are_refuted_though_nothing_is_claimed_of_them() {
    let with = |claimed: &str, b_hat: &str| {
        let text = format!(
            "{claimed}a = [['1/2'], [0, '1/2'], [0, 0, 1]]\nc = [0, '1/2', '1/2', 1]\nb = ['1/6', '1/3', '1/3', '1/6']\nb_hat = [{b_hat}]\n"
        );
        let judgement = judge(&text, Effort::Theory);
        let verdict = judgement.verdicts.into_iter().find(|verdict| verdict.subject == "embedded consistency");
        let check = verdict.expect("it is judged").check;
        (check.outcome, check.measured)
    };
    for claimed in ["", "order = 4\n"] {
        assert_eq!(with(claimed, "'1/2', 0, 0, 0"), (Outcome::Fail, Some(0.0)));
        assert_eq!(with(claimed, "0, 1, 0, 0"), (Outcome::Pass, Some(2.0)));
    }
}

#[test]
fn backward_differentiation_of_seven_steps_has_its_order_and_does_not_converge() {
    let judgement = judge(&shipped("bdf7"), Effort::Runs);
    assert_eq!((judgement.theory.order(), judgement.outcome()), (7, Outcome::Fail));
    assert_eq!(refuted(&judgement), ["zero-stable", "convergence"]);
}

/// Two digits of Gauss's method satisfy conditions beyond what two stages can, to within what they leave open.
#[test]
fn few_digits_give_no_order_beyond_what_the_stages_have() {
    // Gauss's, and the diagonally implicit one with γ = ½ + √3/6 and order 3.
    for (a, order) in [("[[0.25, -0.04], [0.54, 0.25]]", 4), ("[[0.8, 0], [-0.6, 0.8]]", 3)] {
        let text = format!("order = {order}\ndigits = {}\na = {a}\nb = [0.5, 0.5]\n", if order == 4 { 2 } else { 1 });
        let judgement = judge(&text, Effort::Theory);
        assert_eq!((judgement.theory.order(), judgement.outcome()), (order, Outcome::Pass), "{a}");
    }
}

/// A wrong coefficient in a file of each kind: what the claims are refuted by, and that the runs agree with the order left.
#[test]
fn a_wrong_coefficient_of_any_kind_is_refuted_and_the_runs_agree_with_what_is_left() {
    for (name, from, to, order, expected) in [
        (
            "lobatto-iiia-iiib3",
            "\"1/6\", \"5/6\", 0",
            "\"1/6\", \"4/6\", 0",
            1,
            &["order 4", "symplectic", "symmetric"][..],
        ),
        (
            "lobatto-iiia-iiib3",
            "\"5/24\", \"1/3\", \"-1/24\"",
            "\"1/4\", \"1/3\", \"-1/12\"",
            2,
            &["order 4", "symplectic"],
        ),
        ("forest-ruth", "b_hat = [\"1/(2", "b_hat = [\"1/(2.5", 0, &["order 4", "symplectic", "symmetric"]),
        ("nystrom4", "[0, \"1/2\"]", "[0, \"1/3\"]", 2, &["order 4"]),
        ("nystrom5", "\"7/27\"", "\"7/26\"", 2, &["order 5"]),
        ("blanes-moan", "b_bar = [\n    0.0414", "b_bar = [\n    0.0514", 1, &["order 6", "symplectic"]),
        (
            "verlet-nystrom",
            "b_bar = [\"1/2\"]",
            "b_bar = [\"1/3\"]",
            1,
            &["order 2", "symplectic", "symmetric", "stable on the imaginary axis to 2"],
        ),
        ("bdf3", "\"11/6\"", "\"11/5\"", 0, &["order 3"]),
        ("adams-moulton3", "\"19/24\", \"3/8\"", "\"18/24\", \"10/24\"", 1, &["order 4"]),
        ("path-fitted3-gauss", "\"1/2 + sqrt(3)/6\"", "\"2/3\"", 2, &["order 4", "symmetric", "symplectic"]),
        ("galerkin-simpson2", "\"1/6\", \"2/3\", \"1/6\"", "\"1/4\", \"1/2\", \"1/4\"", 2, &["order 4"]),
        ("method-i", "alpha = 0", "alpha = 2", 2, &["L-stable"]),
        ("method-ii", "alpha = -1", "alpha = \"-1/2\"", 2, &["symmetric"]),
    ] {
        let text = shipped(name);
        assert!(text.contains(from), "{name}: {from}");
        let judgement = judge(&text.replace(from, to), Effort::Runs);
        assert_eq!(judgement.theory.order(), order, "{name}: {to}");
        assert_eq!(judgement.outcome(), Outcome::Fail, "{name}");
        let found = refuted(&judgement);
        expected.iter().for_each(|subject| assert!(found.contains(subject), "{name}: {subject} is not in {found:?}"));
        if order > 0 {
            let runs = judgement.measured.iter().filter_map(|measured| measured.result.as_ref().ok());
            let slopes: Vec<f64> = runs.map(|fit| fit.line.map_or(f64::NAN, |line| line.slope)).collect();
            let agree = slopes.iter().filter(|slope| (**slope - f64::from(order)).abs() < 0.3).count();
            assert!(agree >= 2, "{name}: order {order}, runs {slopes:?}");
        }
    }
}

#[test]
fn a_poor_start_of_a_multistep_method_is_told_from_its_coefficients() {
    let text = shipped("bdf4").replace("rho =", "start = \"implicit-euler\"\nrho =");
    let judgement = judge(&text, Effort::Runs);
    assert_eq!(judgement.theory.order(), 4);
    assert_eq!(refuted(&judgement), ["start"]);
    let linear = judgement.measured.iter().find(|measured| measured.kind == "linear").expect("it is run");
    let slope = linear.result.as_ref().expect("a fit").line.expect("a line").slope;
    assert!((slope - 2.0).abs() < 0.1, "{slope}");
}

/// Known from the literature: A(α) of backward differentiation, the intervals of Adams and Bashforth.
#[test]
fn regions_of_stability_of_multistep_methods_are_those_of_the_literature() {
    let fact = |name: &str| {
        let judgement = judge(&shipped(name), Effort::Theory);
        judgement.facts().into_iter().find(|(label, _)| *label == "stability").expect("it has one").1
    };
    for (name, expected) in [
        ("bdf2", "A-stable"),
        ("bdf3", "86.03°"),
        ("bdf4", "73.35°"),
        ("bdf5", "51.84°"),
        ("bdf6", "17.84°"),
        ("adams-bashforth2", "negative axis to 1.0000"),
        ("adams-bashforth4", "negative axis to 0.3000"),
        ("adams-moulton3", "negative axis to 3.0000"),
    ] {
        assert!(fact(name).contains(expected), "{name}: {}", fact(name));
    }
}

/// The stability polynomials of two to four stages, and the principal errors that Dormand and Prince, J. Comput. Appl. Math. 6
/// (1980) 19, print for their pair.
#[test]
fn intervals_of_stability_and_principal_errors_are_those_of_the_literature() {
    let theory = |name: &str| judge(&shipped(name), Effort::Theory).runge_kutta().expect("it is one").clone();
    let end = |reach: Reach| match reach {
        Reach::UpTo { end, .. } => end,
        Reach::Everything => f64::INFINITY,
        Reach::Open { .. } => panic!("the coefficients are exact"),
    };
    let near = |x: f64, y: f64, digits: f64| assert!((x - y).abs() <= 0.5 * digits, "{x} is not {y}");
    for (name, imaginary, negative) in [
        ("rk4", 8_f64.sqrt(), 2.785_293_563),
        ("kutta-38", 8_f64.sqrt(), 2.785_293_563),
        ("ssp-rk3", 3_f64.sqrt(), 2.512_745_327),
    ] {
        near(end(theory(name).imaginary), imaginary, 2e-8);
        near(end(theory(name).negative), negative, 2e-8);
    }
    assert_eq!(end(theory("heun2").imaginary), 0.0);
    assert_eq!(theory("radau-iia3").imaginary, Reach::Everything);
    let pair = theory("dormand-prince");
    near(pair.main.error_norm.expect("not of all orders"), 3.99e-4, 1e-6);
    near(pair.embedded.expect("a pair").error_norm.expect("not of all orders"), 1.18e-3, 1e-5);
}

/// A double root of ρ at −1.
#[test]
fn double_roots_on_the_unit_circle_are_never_zero_stable() {
    let text = "kind = \"multistep\"\nclaims = [\"zero-stable\"]\nrho = [-1, -1, 1, 1]\nsigma = [0, 2, 2, 0]\n";
    let judgement = judge(text, Effort::Theory);
    assert_eq!(judgement.verdicts[0].check.outcome, Outcome::Fail, "{}", judgement.verdicts[0].check.reason);
}

/// −1/3 of BDF2 and 5/12 of Adams and Bashforth (\[HNW93\] III.2), whatever the equation is multiplied by.
#[test]
fn error_constants_of_multistep_methods_are_those_of_the_literature() {
    for (rho, sigma, constant) in
        [("1, -4, 3", "0, 0, 2", "-3.3333e-1"), ("0, -1, 1", "\"-1/2\", \"3/2\", 0", "4.1667e-1")]
    {
        let text = format!("kind = \"multistep\"\norder = 2\nrho = [{rho}]\nsigma = [{sigma}]\n");
        let facts = judge(&text, Effort::Theory).facts();
        assert!(facts[0].1.contains(&format!("error constant {constant}")), "{facts:?}");
    }
}

#[test]
fn energy_and_work_are_looked_at_beside_those_of_others() {
    let judged = |name: &str| judge(&shipped(name), Effort::Runs);
    for (name, outcome) in [
        ("forest-ruth", Outcome::Pass),
        ("galerkin-radau2", Outcome::Pass),
        ("rk4", Outcome::Pass),
        ("bdf7", Outcome::NotRun),
    ] {
        let judgement = judged(name);
        let energy = judgement.verdicts.iter().find(|verdict| verdict.subject == "energy").expect("there");
        assert_eq!(energy.check.outcome, outcome, "{name}: {}", energy.check.reason);
        let drifts = energy.check.statement.contains("energy drifts");
        assert_eq!(drifts, name == "rk4", "{}", energy.check.statement);
        if let Some(Ok((_, points))) = &judgement.work {
            for rival in ["rk4", "diffsol-tsit45"] {
                assert!(points.iter().filter(|point| point.solver == rival).count() >= 3, "{name}: {rival}");
            }
            assert!(points.iter().all(|point| point.work[1] > 0));
        }
    }
    // An evaluation is one of f, whoever counts: a stage, and for Störmer and Verlet's method by its name a step, but for
    // looks at what the Lagrangian declares: at the first step, and two each after 2, 4, 8, …, 256, 256, … more.
    for (file, stages) in [("rk4", 4.0), ("nystrom4", 3.0), ("verlet-nystrom", 1.0)] {
        let judgement = judged(file);
        let Some(Ok((_, points))) = &judgement.work else { panic!("{file}: it runs") };
        let per_step = |name: &str, n: f64, extra: fn(f64) -> f64| {
            let mut of = points.iter().filter(|point| point.solver == name).peekable();
            assert!(of.peek().is_some(), "{file}: {name}");
            for point in of {
                let [steps, evaluations, _] = point.work.map(|count| count as f64);
                assert!((n * steps..=n * steps + extra(steps)).contains(&evaluations), "{file}: {point:?}");
            }
        };
        // One evaluation tells whether the equations are of second order.
        per_step(&judgement.file.name, stages, |_| 1.0);
        per_step("rk4", 4.0, |_| 0.0);
        per_step("stormer-verlet", 1.0, |steps| 8.0 + 2.0 * (steps.log2() + steps / 256.0));
    }
    // Of two stages that are found together both are evaluated, twice at least.
    let judgement = judged("gauss2");
    let Some(Ok((_, points))) = &judgement.work else { panic!("it runs") };
    for point in points.iter().filter(|point| point.solver == judgement.file.name) {
        assert!(point.work[1] % 2 == 0 && point.work[1] >= 4 * point.work[0], "{point:?}");
    }
    // A wrong sign in the last kick: what is claimed to keep energy does not.
    let broken = shipped("stormer-verlet").replace("b_hat = [\"1/2\", \"1/2\"]", "b_hat = [\"2/5\", \"3/5\"]");
    let judgement = judge(&broken, Effort::Runs);
    let energy = judgement.verdicts.iter().find(|verdict| verdict.subject == "energy").expect("there");
    assert!(energy.check.statement.contains("energy drifts") && energy.check.outcome == Outcome::Pass, "{energy:?}");
}

/// What a kind is not judged by is neither confirmed nor refuted.
#[test]
fn a_claim_that_a_kind_is_not_judged_by_is_inconclusive() {
    let text = shipped("bdf2").replace("\"zero-stable\"", "\"symplectic\"");
    assert_eq!(refuted(&judge(&text, Effort::Theory)), ["symplectic"]);
    assert_eq!(judge(&text, Effort::Theory).outcome(), Outcome::Inconclusive);
    let function = shipped("fitted-pade").replace("order = 2", "order = 2\nclaims = [\"A-stable\"]");
    assert_eq!(judge(&function, Effort::Theory).outcome(), Outcome::Inconclusive);
}

#[test]
fn mistakes_in_a_file_of_any_kind_are_shown_where_they_are() {
    for (name, from, to, line, reason) in [
        ("stormer-verlet", "b_hat = [\"1/2\", \"1/2\"]", "b_hat = [1]", 15, "`b_hat` has 1 entry"),
        ("forest-ruth", "\"separable\"", "\"some\"", 5, "`systems` is"),
        ("nystrom4", "b_bar", "bbar", 12, "`b_bar` is missing, and the key `bbar` is not known"),
        ("bdf2", "sigma = [0, 0, 1]", "sigma = [0, 1]", 7, "`sigma` has 2 entries"),
        ("bdf2", "rho =", "start = \"bdf1\"\nrho =", 6, "no Runge–Kutta method"),
        ("bdf2", "sigma = [0, 0, 1]", "sigma = [0, 0, \"z\"]", 7, "`z` is not known here"),
        ("fitted-pade", "rate = 4", "rate = -4", 5, "positive"),
        ("fitted-pade", "rate = 4\n", "", 5, "needs a `rate`"),
        ("method-i", "beta = 1", "beta = 0", 6, "both zero"),
        ("path-fitted3", "\"2/3\"", "\"4/3\"", 6, "between 0 and 1"),
        ("galerkin-gauss2", "degree = 2", "degree = 3", 6, "whole number"),
    ] {
        let text = shipped(name);
        assert!(text.contains(from), "{name}: {from}");
        let error = MethodFile::parse("m.toml", "m", &text.replace(from, to)).expect_err(to);
        let FileError::Malformed { line: found, reason: text, .. } = &error else { panic!("{error}") };
        assert!(text.contains(reason) && *found == line, "{name}: {error}");
    }
}

/// A seeded sample of misprints, three for each kind of coefficient of each file.
#[test]
fn a_misprint_in_any_coefficient_of_any_shipped_file_is_found_and_mended() {
    let tableaus = files("").into_iter().map(|path| MethodFile::load(&path).expect("well-formed"));
    let tableaus: Vec<MethodFile> = tableaus.filter(|file| matches!(file.body, Body::RungeKutta(_))).collect();
    let tallies: Vec<(usize, usize, usize)> = tableaus
        .par_iter()
        .enumerate()
        .map(|(seed, file)| {
            let Body::RungeKutta(tableau) = &file.body else { return (0, 0, 0) };
            let mut random = Uniform::new(seed as u64);
            let s = tableau.stages();
            let mut places: Vec<Place> = (0..s).flat_map(|i| [Place::B(i), Place::C(i), Place::Hat(i)]).collect();
            places.extend((0..s).flat_map(|i| (0..s).map(move |j| Place::A(i, j))));
            places.retain(|place| tableau.coefficient(*place).is_some_and(|c| c.text != "0"));
            let (mut all, mut unique, mut first) = (0, 0, 0);
            for _ in 0..12 {
                let at = ((random.next().expect("endless") + 1.0) / 2.0 * places.len() as f64) as usize;
                let place = places[at % places.len()];
                let original = tableau.coefficient(place).expect("there");
                let text = misprint(&original.text, &mut random);
                let file_text = corrupted(file, tableau, place, &text);
                let Ok(read) = MethodFile::parse("test.toml", "test", &file_text) else { continue };
                let Body::RungeKutta(changed) = &read.body else { continue };
                let value = &changed.coefficient(place).expect("there").real;
                if (value - &original.real).may_be_zero() {
                    continue;
                }
                let judgement = Judgement::new(read.clone(), Effort::Theory);
                let what = format!("{}, {place}: {} → {text}: {:?}", file.name, original.text, judgement.diagnosis);
                assert_eq!(judgement.outcome(), Outcome::Fail, "{what}");
                let is_original = |value: &verify::judge::real::Real| (value - &original.real).to_f64().abs() < 1e-15;
                let right = judgement.repairs().iter().position(|r| r.place == place && is_original(&r.value));
                assert!(right.is_some(), "{what}");
                all += 1;
                unique += usize::from(judgement.repairs().len() == 1);
                first += usize::from(right == Some(0));
            }
            (all, unique, first)
        })
        .collect();
    let sum = |f: fn(&(usize, usize, usize)) -> usize| tallies.iter().map(f).sum::<usize>();
    let (all, unique, first) = (sum(|t| t.0), sum(|t| t.1), sum(|t| t.2));
    eprintln!("{all} misprints, {unique} with one repair only, {first} with the right one first");
    assert!(all >= 200 && unique * 10 >= all * 8 && first * 10 >= all * 9, "{all} {unique} {first}");
}

/// Keys with the rows that stand under them.
type Lists<'a> = Vec<(&'static str, Vec<&'a [Coefficient]>)>;

/// The coefficients of a method of another kind than Runge–Kutta: the lines of the file above them, then the rows of each list.
fn lists(file: &MethodFile) -> (String, Lists<'_>) {
    fn rows(a: &[Vec<Coefficient>]) -> Vec<&[Coefficient]> {
        a.iter().map(Vec::as_slice).collect()
    }
    match &file.body {
        Body::Parts(parts) => {
            let second_order = parts.coupling == Coupling::SecondOrder;
            let head = match parts.coupling {
                Coupling::SecondOrder => "kind = \"nystrom\"",
                Coupling::Separable => "kind = \"partitioned-runge-kutta\"\nsystems = \"separable\"",
                Coupling::General => "kind = \"partitioned-runge-kutta\"",
            };
            let mut lists = vec![("a", rows(&parts.a[0]))];
            if !second_order {
                lists.push(("a_hat", rows(&parts.a[1])));
            }
            let names = if second_order { ["b_bar", "b"] } else { ["b", "b_hat"] };
            lists.extend(names.into_iter().zip(&parts.b).map(|(name, b)| (name, vec![b.as_slice()])));
            lists.extend(parts.c.iter().map(|c| ("c", vec![c.as_slice()])));
            (head.into(), lists)
        }
        Body::Multistep(method) => {
            let head = format!("kind = \"multistep\"\nstart = \"{}\"", method.start_name);
            (head, vec![("rho", vec![&method.rho]), ("sigma", vec![&method.sigma])])
        }
        Body::Nodes(nodes) => {
            let head = match nodes.weights {
                Some(_) => format!("kind = \"galerkin\"\ndegree = {}", nodes.degree),
                None => "kind = \"path-fitted\"".into(),
            };
            let weights = nodes.weights.iter().map(|weights| ("weights", vec![weights.as_slice()]));
            (head, [("nodes", vec![nodes.nodes.as_slice()])].into_iter().chain(weights).collect())
        }
        Body::RungeKutta(_) | Body::Closure(_) => (String::new(), Vec::new()),
    }
}

/// Every coefficient of every shipped file of the other kinds, misprinted twice; nodes more often, since most are refused.
#[test]
fn a_misprint_in_any_coefficient_of_another_kind_is_found_and_mended() {
    let files: Vec<MethodFile> =
        files("").into_iter().map(|path| MethodFile::load(&path).expect("well-formed")).collect();
    let (mut all, mut unique, mut first, mut kinds) = (0, 0, 0, std::collections::BTreeSet::new());
    for (seed, file) in files.iter().enumerate() {
        let mut random = Uniform::new(seed as u64);
        let (head, lists) = lists(file);
        let places = lists.iter().flat_map(|(key, rows)| {
            let row =
                |(i, row): (usize, &&[Coefficient])| (0..row.len()).map(move |j| (*key, i, j)).collect::<Vec<_>>();
            rows.iter().enumerate().flat_map(row).collect::<Vec<_>>()
        });
        let places: Vec<_> = places.collect();
        // Of a file of a hundred coefficients, each of which takes half a second, four or so.
        for (name, i, j) in places.iter().copied().step_by(if places.len() > 60 { places.len() / 4 } else { 1 }) {
            let of = |list: &[&[Coefficient]]| list[i][j].clone();
            let original = lists.iter().find(|(key, _)| *key == name).map(|(_, rows)| of(rows)).expect("there");
            for _ in 0..if matches!(file.body, Body::Nodes(_)) { 8 } else { 2 } {
                if original.text == "0" {
                    continue;
                }
                let text = misprint(&original.text, &mut random);
                let mut out = format!("{head}\norder = {}\n", file.order().expect("claimed"));
                for (key, rows) in &lists {
                    let row = |(k, row): (usize, &&[Coefficient])| {
                        let cell = |(l, x): (usize, &Coefficient)| {
                            format!("\"{}\"", if (*key, k, l) == (name, i, j) { &text } else { &x.text })
                        };
                        format!("[{}]", row.iter().enumerate().map(cell).collect::<Vec<_>>().join(", "))
                    };
                    let rows_text = rows.iter().enumerate().map(row).collect::<Vec<_>>();
                    let is_matrix = matches!(*key, "a" | "a_hat");
                    let value = if is_matrix { format!("[{}]", rows_text.join(", ")) } else { rows_text.concat() };
                    let _ = writeln!(out, "{key} = {value}");
                }
                // A weight of 0 for the new step, or a node beyond it, is refused by the reader.
                let Ok(read) = MethodFile::parse("test.toml", "test", &out) else { continue };
                let judgement = Judgement::new(read, Effort::Theory);
                if judgement.theory.order() >= file.order().expect("claimed") && judgement.outcome() == Outcome::Pass {
                    continue;
                }
                let what =
                    format!("{}, {name}[{i},{j}]: {} → {text}: {:?}", file.name, original.text, judgement.diagnosis);
                // Of printed digits to what the roundings of all of them leave open.
                let is_original = |value: &verify::judge::real::Real| {
                    let apart = value - &original.real;
                    apart.to_f64().abs() <= 1e-15_f64.max(apart.radius())
                };
                let place = match lists.iter().find(|(key, _)| *key == name) {
                    Some((key, _)) if matches!(*key, "a" | "a_hat") => Place::Of(name, i, j),
                    _ => Place::In(name, j),
                };
                let right = judgement.repairs().iter().position(|r| r.place == place && is_original(&r.value));
                assert!(right.is_some(), "{what}");
                kinds.insert(judgement.theory.kind());
                all += 1;
                unique += usize::from(judgement.repairs().len() == 1);
                first += usize::from(right == Some(0));
            }
        }
    }
    eprintln!("{all} misprints, {unique} with one repair only, {first} with the right one first");
    assert_eq!(
        kinds.into_iter().collect::<Vec<_>>(),
        ["galerkin", "multistep", "nystrom", "partitioned-runge-kutta", "path-fitted"]
    );
    assert!(all >= 150 && unique * 10 >= all * 7 && first * 10 >= all * 8, "{all} {unique} {first}");
}

/// What cannot be mended is said to be a label, and of a closure why.
#[test]
fn a_wrong_label_of_another_kind_is_named() {
    for (name, from, to, text) in [
        ("bdf3", "order = 3", "order = 4", "no change of a single coefficient makes the conditions of order 4 hold"),
        ("method-i", "order = 2", "order = 3", "has order 2 for any α and β"),
        ("galerkin-gauss2", "order = 4", "order = 6", "no change of a single coefficient"),
        ("nystrom4", "order = 4", "order = 3", "The label is too low"),
    ] {
        let judgement = judge(&shipped(name).replace(from, to), Effort::Theory);
        let found = judgement.diagnosis_text().unwrap_or_default();
        assert!(found.contains(text) && judgement.repairs().is_empty(), "{name}: {found}");
        assert_eq!(judgement.outcome(), Outcome::Fail, "{name}");
    }
    // Without a label, what the order was meant to be.
    let text = shipped("bdf4").replace("order = 4\n", "").replace("\"25/12\"", "\"25/11\"");
    assert!(text.contains("25/11"));
    let judgement = judge(&text, Effort::Theory);
    let [repair] = judgement.repairs() else { panic!("{:?}", judgement.diagnosis) };
    assert_eq!((repair.place.to_string().as_str(), repair.text.as_str()), ("rho[5]", "25/12"));
    // Abscissae that no condition of an autonomous system has.
    let judgement = judge(&shipped("lobatto-iiia-iiib3").replace("c = [0, \"1/2\"", "c = [0, \"1/3\""), Effort::Theory);
    let [repair] = judgement.repairs() else { panic!("{:?}", judgement.diagnosis) };
    assert_eq!((repair.place.to_string().as_str(), repair.text.as_str()), ("c[2]", "1/2"));
    assert_eq!(refuted(&judgement), ["row sums"]);
}

const RK4: &str = "\
kind = \"runge-kutta\"
order = 4
c = [0, \"1/2\", \"1/2\", 1]
a = [[\"1/2\"], [0, \"1/2\"], [0, 0, 1]]
b = [\"1/6\", \"1/3\", \"1/3\", \"1/6\"]
";

#[test]
fn a_wrong_label_is_told_from_a_wrong_coefficient() {
    let diagnosis = |from: &str, to: &str| judge(&RK4.replace(from, to), Effort::Theory).diagnosis;
    assert!(matches!(diagnosis("", ""), Diagnosis::Sound));
    assert!(matches!(diagnosis("order = 4", "order = 3"), Diagnosis::LabelTooLow { order: 4 }));
    assert!(matches!(diagnosis("order = 4", "order = 5"), Diagnosis::LabelTooHigh { order: 4 }));
    assert!(matches!(diagnosis("\"1/3\", \"1/3\"", "\"1/3\", \"1/4\""), Diagnosis::Coefficient { .. }));
    let two = RK4.replace("[0, 0, 1]", "[0, 0, 2]").replace("\"1/3\", \"1/3\"", "\"1/4\", \"1/3\"");
    assert!(matches!(judge(&two, Effort::Theory).diagnosis, Diagnosis::Several { .. }));
    // Without a label the same misprint is found, and what the order was meant to be.
    let unlabelled = RK4.replace("order = 4\n", "").replace("\"1/3\", \"1/3\"", "\"1/3\", \"1/4\"");
    let judgement = judge(&unlabelled, Effort::Theory);
    assert!(matches!(&judgement.diagnosis, Diagnosis::Coefficient { target, .. } if target.order == 4));
}

/// c = (0, ½, ⅓, 1): every autonomous problem is solved to order 4 still.
#[test]
fn wrong_stage_times_show_where_time_is_in_the_equation_and_nowhere_else() {
    let judgement = judge(&RK4.replace("\"1/2\", \"1/2\", 1", "\"1/2\", \"1/3\", 1"), Effort::Runs);
    assert_eq!((judgement.theory.order(), judgement.runge_kutta().expect("it is one").order_in_time), (4, 1));
    let slope = |kind: &str| {
        let measured = judgement.measured.iter().find(|measured| measured.kind == kind).expect(kind);
        measured.result.as_ref().expect("a fit").line.expect("a line").slope
    };
    assert!((slope("nonlinear") - 4.0).abs() < 0.1 && (slope("non-autonomous") - 1.0).abs() < 0.1);
    let [repair] = judgement.repairs() else { panic!("{:?}", judgement.diagnosis) };
    assert_eq!((repair.place, repair.text.as_str()), (Place::C(2), "1/2"));
}

#[test]
fn digits_decide_how_far_a_condition_can_be_held_to() {
    let gauss = |digits: usize| {
        let r = 3_f64.sqrt() / 6.0;
        let x = |x: f64| format!("{x:.digits$}");
        format!(
            "kind = \"runge-kutta\"\norder = 4\na = [[0.25, {}], [{}, 0.25]]\nb = [0.5, 0.5]\nc = [{}, {}]\n",
            x(0.25 - r),
            x(0.25 + r),
            x(0.5 - r),
            x(0.5 + r)
        )
    };
    let judgement = judge(&gauss(10), Effort::Theory);
    assert_eq!((judgement.outcome(), judgement.file.rounding.places()), (Outcome::Pass, Some(10)));
    // A wrong sixth digit is beyond what ten digits leave open, and four digits are taken at their word unless declared.
    let wrong = judge(&gauss(10).replace("-0.0386751346", "-0.0386761346"), Effort::Theory);
    assert_eq!(wrong.repairs()[0].place, Place::A(0, 1));
    assert!((wrong.repairs()[0].value.to_f64() + 0.0386751346).abs() < 1e-9);
    // And so are three units of the tenth.
    let off = gauss(10).replace("-0.0386751346", "-0.0386751349");
    assert_eq!(judge(&off, Effort::Theory).outcome(), Outcome::Fail);
    assert_eq!(judge(&gauss(4), Effort::Theory).outcome(), Outcome::Fail);
    assert_eq!(judge(&format!("digits = 4\n{}", gauss(4)), Effort::Theory).outcome(), Outcome::Pass);
}

#[test]
fn mistakes_in_a_file_are_shown_where_they_are() {
    for (from, to, place, reason) in [
        ("order = 4", "ordre = 4", (2, 1), "did you mean `order`?"),
        ("\"1/3\", \"1/3\"", "\"1/3\", \"nan\"", (5, 21), "`nan` is not known"),
        ("\"1/3\", \"1/3\"", "\"1/3\", nan", (5, 20), "`nan` is not known"),
        ("\"1/3\", \"1/3\"", "\"1/3\"", (3, 6), "`c` has 4 entries"),
        ("[0, \"1/2\"],", "[0, \"1/2\", 0, 0, 0],", (4, 15), "row 3"),
        ("runge-kutta", "rosenbrock", (1, 9), "not supported"),
        ("order = 4", "order = four", (2, 9), "no TOML"),
        ("order = 4", "order = -1", (2, 9), "whole number"),
        ("b = ", "d = ", (5, 1), "missing"),
        ("order = 4", "claims = [\"good\"]", (2, 12), "no claim"),
    ] {
        let error = MethodFile::parse("rk.toml", "rk", &RK4.replacen(from, to, 1)).expect_err(to);
        let FileError::Malformed { line, column, reason: found, .. } = &error else { panic!("{error}") };
        assert!(found.contains(reason), "{to}: {error}");
        if reason != "missing" {
            assert_eq!((*line, *column), place, "{to}: {error}");
        }
    }
}

#[test]
fn plain_tables_are_the_same_method() {
    let block = "0 1/2 1/2 1\n1/6 1/3 1/3 1/6\n1/2\n0 1/2\n0 0 1\n";
    let lists =
        "k c[k]\n1 0\n2 0.5\n3 0.5\n4 1\nk b[k]\n1 1/6\n2 1/3\n3 1/3\n4 1/6\nk j A[k,j]\n2 1 0.5\n3 2 0.5\n4 3 1\n";
    let named = "# comment\nc[2] = 1/2\nc[3] = 1/2;\nc[4] = 1\na[2,1] = 1/2\na[3,2] = 1/2\na[4,3] = 1\n\
                 b[1] = 1/6\nb[2] = 1/3\nb[3] = 1/3\nb[4] = 1/6\n";
    let from_zero = lists.lines().map(|line| {
        let shift = |word: &str| word.parse::<usize>().map_or(word.to_owned(), |k| (k - 1).to_string());
        let words: Vec<&str> = line.split(' ').collect();
        match words.split_last() {
            Some((last, rest)) if last.contains('[') => format!("{} {last}", rest.join(" ")),
            Some((last, rest)) => {
                rest.iter().map(|word| shift(word)).chain([(*last).to_owned()]).collect::<Vec<_>>().join(" ")
            }
            None => String::new(),
        }
    });
    let from_zero: Vec<String> = from_zero.collect();
    for text in [block, lists, named, &from_zero.join("\n")] {
        let judgement = judge(text, Effort::Theory);
        assert_eq!((judgement.theory.order(), judgement.outcome()), (4, Outcome::Pass), "{text}");
    }
    let error = MethodFile::parse("t.txt", "t", "0 1/2\n1/2 x\n1").expect_err("x");
    assert!(error.to_string().starts_with("t.txt:2:5:"), "{error}");
}

proptest::proptest! {
    #[test]
    fn no_text_makes_the_reader_panic(text in "[a-c_hatorde\\[\\]=,\"0-9/ .\n#k-]{0,80}", junk in "\\PC{0,40}") {
        for text in [&text, &junk, &format!("{RK4}{text}"), &format!("c[1] = {junk}"), &format!("0 1\n{text}")] {
            let _ = MethodFile::parse("fuzz.toml", "fuzz", text);
        }
    }

    /// Whatever the numbers, theory ends without a panic.
    #[test]
    fn no_coefficients_make_theory_panic(x in proptest::collection::vec(-4_i32..5, 12)) {
        let text = format!(
            "kind = \"runge-kutta\"\na = [[{}, {}], [{}, {}]]\nb = [{}, {}]\nc = [{}, {}]\nb_hat = [{}, {}]\norder = {}\n",
            x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8], x[9], x[10].abs() + 1
        );
        let _ = judge(&text, Effort::Theory);
    }
}

#[test]
fn every_file_is_shipped_and_read() {
    let below = |directory: &'static str| {
        let stem = |path: PathBuf| path.file_stem().expect("a name").to_string_lossy().into_owned();
        files(directory).into_iter().map(move |path| format!("{directory}{}", stem(path)))
    };
    let mut there: Vec<String> = below("").chain(below("misprints/")).collect();
    let mut shipped: Vec<String> = SHIPPED.iter().map(|file| file.name.to_owned()).collect();
    there.sort();
    shipped.sort();
    assert_eq!(there, shipped);
    SHIPPED.iter().for_each(|file| assert!(file.read().is_ok(), "{}", file.name));
}

fn say(line: &str) -> (i32, String, String) {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_verify"));
    let output = command.args(line.split_whitespace()).env("NO_COLOR", "1").output().expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr))
}

#[test]
fn the_command_judges_prints_in_every_form_and_says_what_is_wrong() {
    let (status, text, _) = say("judge rk4");
    assert!(status == 0 && text.contains("confirmed    order 4"), "{text}");
    let width = |line: &str| line.chars().filter(|c| !('\u{300}'..='\u{36f}').contains(c)).count();
    for line in
        ["judge rk4", "judge misprints/rk4-a44", "judge crouzeix3 --no-runs", "judge --help", "list method-files"]
    {
        let (_, text, _) = say(line);
        text.lines().for_each(|line| assert!(width(line) <= 80, "{line}"));
    }
    let (status, json, _) = say("judge misprints/rk4-a44 --no-runs --format json");
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!((status, json["repairs"][0]["place"].as_str()), (1, Some("a[4,4]")));
    assert_eq!(json["outcome"], "fail");
    let (status, markdown, _) = say("judge gauss2 --no-runs --format markdown");
    assert!(status == 0 && markdown.contains("| It is symplectic, as claimed | confirmed |"), "{markdown}");
    let (status, _, error) = say("judge gaus2");
    assert!(status == 2 && error.contains("did you mean `gauss2`?"), "{error}");
    let (status, _, error) = say("judge missing.toml");
    assert!(status == 2 && error.contains("cannot read missing.toml"), "{error}");
}

#[test]
fn a_file_goes_where_the_name_of_a_method_goes() {
    let methods = concat!(env!("CARGO_MANIFEST_DIR"), "/methods");
    let last = |text: &str| text.lines().last().expect("a line").split(',').next_back().map(str::to_owned);
    let solve = |method: &str| say(&format!("solve --problem logistic --method {method} --h 0.1 --t-end 1"));
    let (status, by_file, _) = solve(&format!("{methods}/rk4.toml"));
    assert_eq!((status, last(&by_file)), (0, last(&solve("rk4").1)));
    let (status, text, _) =
        say(&format!("order --problem van-der-pol --method {methods}/gauss2.toml --reference diffsol"));
    assert!(status == 0 && text.contains("is 4 ± 0.1"), "{text}");
    let (status, text, _) = say(&format!("compare --problem linear-drag --method {methods}/radau-iia3.toml"));
    assert!(status == 0 && text.contains("Radau IIA, 3 stages"), "{text}");
}

#[test]
fn a_report_of_a_judgement_has_its_figures() {
    let directory = crate::scratch("judge");
    let (status, _, error) = say(&format!("judge sdirk2 --out {}", directory.display()));
    assert_eq!(status, 0, "{error}");
    let page = std::fs::read_to_string(directory.join("index.html")).expect("a page");
    assert!(page.contains("SDIRK2"));
    let results = std::fs::read_to_string(directory.join("results.json")).expect("results");
    let results: serde_json::Value = serde_json::from_str(&results).expect("JSON");
    assert!(results["chapters"][0]["figures"].as_array().is_some_and(|figures| !figures.is_empty()));
    assert_eq!((&results["counts"]["fail"], &results["counts"]["broken"]), (&0.into(), &0.into()), "{results}");
}

/// Made for one property each, which a rule that is a little off gets wrong; the (0, 3) Padé approximation is A(88.23)-stable.
#[test]
fn claims_that_are_nearly_true_are_refuted() {
    const PADE: &str = "a = [[0, 0, 1], [1, 0, 1], [\"-2/3\", \"1/6\", 1]]\nb = [0, 0, 1]";
    const TRAPEZIUM: &str = "a = [[0, 0], [\"1/2\", \"1/2\"]]\nb = [0, 1]";
    const KICKS: &str =
        "a = [[\"3/8\"], [\"3/4\", \"-1/4\"], [\"3/4\", \"-1/2\", \"3/8\"]]\nb = [\"3/4\", \"-1/2\", \"3/4\"]";
    // Steps forward, back and forward again, which are one step.
    const FORTH_AND_BACK: &str = "a = [[\"1/2\"], [1, \"-1/2\"], [1, -1, \"1/2\"]]\nb = [1, -1, 1]";
    const SWAPPED: &str = "c = [\"1/2\", 0, 1]\nb = [\"2/3\", \"1/6\", \"1/6\"]\n\
        a = [[\"1/3\", \"5/24\", \"-1/24\"], [0, 0, 0], [\"2/3\", \"1/6\", \"1/6\"]]";
    const RK4: &str = "a = [[\"1/2\"], [0, \"1/2\"], [0, 0, 1]]\nb = [\"1/6\", \"1/3\", \"1/3\", \"1/6\"]";
    let multistep = |rho: &str, sigma: &str| format!("kind = \"multistep\"\nrho = [{rho}]\nsigma = [{sigma}]");
    let nystrom = |a: &str, b_bar: &str, c: &str| {
        format!("kind = \"nystrom\"\na = {a}\nb_bar = [\"{b_bar}\"]\nb = [1]\nc = [\"{c}\"]")
    };
    let galerkin = |degree: u32, nodes: &str, weights: &str| {
        format!("kind = \"galerkin\"\ndegree = {degree}\nnodes = [{nodes}]\nweights = [{weights}]")
    };
    for (body, holds, fails) in [
        (PADE, "A(88.23)-stable", "A(88.3)-stable"),
        (PADE, "not A(88.3)-stable", "not A(88.2)-stable"),
        // |R| = 1 on the imaginary axis, and a pole at −1 − √5.
        ("a = [[\"3/4\", \"1/4\"], [\"1/4\", \"-1/4\"]]\nb = [\"1/2\", \"1/2\"]", "not A-stable", "A-stable"),
        (TRAPEZIUM, "stage order 1", "stage order 2"),
        (&shipped("gauss2").replace("order = 4", "").replace("claims", "# claims"), "stage order 2", "stage order 1"),
        // Composed midpoint rules: symplectic, with a negative weight.
        (KICKS, "symplectic", "algebraically stable"),
        (FORTH_AND_BACK, "algebraically stable", "not symmetric"),
        ("a = [[\"1/4\", 1], [0, \"1/4\"]]\nb = [\"1/2\", \"1/2\"]", "not symplectic", "symplectic"),
        (SWAPPED, "symmetric", "not symmetric"),
        (RK4, "stable on the imaginary axis to 2.828", "stable on the imaginary axis to 2.84"),
        (RK4, "dispersion order 4", "dispersion order 3"),
        // Roots ±i on the rim, simple and double; 1.01 of them is none.
        (&multistep("-1, 1, -1, 1", "0, 0, 0, 2"), "zero-stable", "not zero-stable"),
        (&multistep("-1, 1, -2, 2, -1, 1", "0, 0, 0, 0, 0, 4"), "not zero-stable", "zero-stable"),
        (&multistep("-1, 1, \"-101/100\", \"101/100\"", "0, 0, 0, 2"), "zero-stable", "not zero-stable"),
        (&multistep("\"-101/100\", \"101/100\", -1, 1", "0, 0, 0, 2"), "not zero-stable", "zero-stable"),
        (&multistep("-1, 0, 1", "0, 2, 0"), "symmetric", "not symmetric"),
        (&multistep("-1, 0, 1", "\"1/3\", \"4/3\", \"1/3\""), "symmetric", "not symmetric"),
        (&multistep("0, -1, 1", "\"-1/2\", \"3/2\", 0"), "not symmetric", "symmetric"),
        // Half a step of each: b̄ is no b/2, and a stage that needs itself is not explicit.
        (&nystrom("[[0]]", "1/2", "1/2"), "explicit", "not explicit"),
        (&nystrom("[[\"1/8\"]]", "1/2", "1/2"), "not explicit", "explicit"),
        (&nystrom("[[0]]", "1/2", "1/2"), "order 2", "order 1"),
        (&nystrom("[[0]]", "1/3", "1/2"), "not symplectic", "symplectic"),
        (&nystrom("[[0]]", "1/3", "1/2"), "order 1", "order 2"),
        // The order is the smaller of that of the quadrature and twice the degree.
        (&galerkin(1, "0, \"1/2\", 1", "\"1/6\", \"2/3\", \"1/6\""), "order 2", "order 4"),
        (&galerkin(2, "0, \"1/2\", 1", "\"1/6\", \"2/3\", \"1/6\""), "order 4", "order 2"),
        (&galerkin(2, "0, \"1/2\", 1", "\"1/4\", \"1/2\", \"1/4\""), "order 2", "order 4"),
        (&galerkin(2, "0, \"1/2\", 1", "\"1/6\", \"1/2\", \"1/3\""), "not symmetric", "symmetric"),
    ] {
        let kind = if body.contains("kind =") { "" } else { "kind = \"runge-kutta\"\n" };
        for (claim, outcome) in [(holds, Outcome::Pass), (fails, Outcome::Fail)] {
            let judgement = judge(&format!("note = \"made\"\n{kind}claims = [\"{claim}\"]\n{body}"), Effort::Theory);
            let verdict = judgement.verdicts.iter().find(|v| v.subject.replace('°', "") == claim).expect(claim);
            assert_eq!(verdict.check.outcome, outcome, "{claim}: {}", verdict.check.reason);
        }
    }
}

/// What oscillations are looked at to is said as a bound, and a claim beyond it stays open.
#[test]
fn a_search_that_ended_at_its_limit_says_so() {
    let text = "kind = \"partitioned-runge-kutta\"\na = [[\"1/2\"]]\nb = [1]\na_hat = [[\"1/2\"]]\nb_hat = [1]\n";
    let claim =
        |end: u32| judge(&format!("claims = [\"stable on the imaginary axis to {end}\"]\n{text}"), Effort::Theory);
    assert!(claim(50).facts().iter().any(|(_, text)| text.ends_with("to hω = 60 at least")), "{:?}", claim(50).facts());
    assert_eq!((claim(50).outcome(), claim(70).outcome()), (Outcome::Pass, Outcome::Inconclusive));
}

/// The fields that scripts read.
#[test]
fn a_judgement_as_json_keeps_to_its_schema() {
    let json = |line: &str| -> (i32, serde_json::Value) {
        let (status, out, error) = say(&format!("judge --format json --no-runs {line}"));
        (status, serde_json::from_str(&out).unwrap_or_else(|_| panic!("{out}{error}")))
    };
    let keys = |value: &serde_json::Value| value.as_object().expect("an object").keys().cloned().collect::<Vec<_>>();
    let (status, pair) = json("dormand-prince");
    assert_eq!(status, 0);
    let mut expected = vec!["name", "kind", "digits", "outcome", "order", "stages", "order_in_time", "embedded_order"];
    expected.extend(["stage_order", "error_norm", "alpha", "verdicts", "diagnosis", "repairs", "exchanges", "facts"]);
    let mut found = keys(&pair);
    found.sort();
    expected.sort_unstable();
    assert_eq!(found, expected);
    for (key, value) in [
        ("kind", "runge-kutta".into()),
        ("outcome", "pass".into()),
        ("order", 5.into()),
        ("stages", 7.into()),
        ("order_in_time", 5.into()),
        ("embedded_order", 4.into()),
        ("stage_order", 1.into()),
        ("digits", serde_json::Value::Null),
        ("alpha", serde_json::Value::Null),
        ("diagnosis", serde_json::Value::Null),
    ] {
        assert_eq!(pair[key], value, "{key}");
    }
    assert!((pair["error_norm"].as_f64().expect("a number") - 3.99e-4).abs() < 1e-6);
    assert_eq!(json("sdirk2").1["alpha"], 90.0);
    let verdict = &pair["verdicts"][0];
    assert_eq!((&verdict["kind"], &verdict["subject"]), (&"claim".into(), &"order 5".into()));
    assert_eq!((&verdict["outcome"], &verdict["measured"]), (&"pass".into(), &5.0.into()));
    let (status, wrong) = json("misprints/fehlberg45-a63");
    let repair = &wrong["repairs"][0];
    assert_eq!(status, 1);
    assert_eq!((&repair["place"], &repair["was"]), (&"a[6,3]".into(), &"-3554/2565".into()));
    assert_eq!((&repair["text"], &repair["mends"]), (&"-3544/2565".into(), &16.into()));
    assert!((repair["value"].as_f64().expect("a number") + 3544.0 / 2565.0).abs() < 1e-12 && repair["with_c"] == false);
    assert!(wrong["diagnosis"].as_str().is_some_and(|text| text.starts_with("A coefficient is wrong.")));
    // A multistep method has no stages.
    assert!(json("bdf2").1.get("stages").is_none());
}

/// With c₃ off the order is that of problems without time. Where a₂₁ and c₂ are off together, both change; where b is,
/// c stays.
#[test]
fn a_judgement_as_json_tells_the_order_in_time_and_whether_c_follows_a_repair() {
    let path = crate::scratch("misprinted.toml");
    let json = |text: &str| -> serde_json::Value {
        std::fs::write(&path, text).expect("writable");
        let (_, out, error) = say(&format!("judge --format json --no-runs {}", path.display()));
        serde_json::from_str(&out).unwrap_or_else(|_| panic!("{out}{error}"))
    };
    let late = json(&RK4.replace("\"1/2\", \"1/2\", 1", "\"1/2\", \"1/3\", 1"));
    assert_eq!((&late["order"], &late["order_in_time"]), (&4.into(), &1.into()));
    let repair = |text: &str| {
        let repair = &json(text)["repairs"][0];
        (repair["place"].as_str().expect("a place").to_owned(), repair["with_c"].as_bool().expect("true or false"))
    };
    let early = RK4.replace("[[\"1/2\"]", "[[\"1/3\"]").replace("c = [0, \"1/2\"", "c = [0, \"1/3\"");
    assert_eq!(repair(&early), ("a[2,1]".into(), true));
    assert_eq!(repair(&RK4.replace("\"1/3\", \"1/3\"", "\"1/4\", \"1/3\"")), ("b[2]".into(), false));
}

/// Nothing refuted and something open is neither success nor failure.
#[test]
fn a_judgement_with_a_claim_left_open_has_status_three() {
    let path = crate::scratch("open.toml");
    let status = |claims: &str| {
        std::fs::write(&path, shipped("bdf2").replace("\"zero-stable\"", claims)).expect("writable");
        say(&format!("judge --no-runs {}", path.display())).0
    };
    assert_eq!(status("\"zero-stable\""), 0);
    assert_eq!(status("\"symplectic\""), 3);
    assert_eq!(status("\"symplectic\", \"explicit\""), 1);
}

fn judged(text: &str) -> Judgement {
    Judgement::new(MethodFile::parse("method", "method", text).expect("well-formed"), Effort::Theory)
}

/// Ralston's method of order 4 to four places, with b₃ = 1.2055 misprinted, and Kutta's of order 3 to three places.
#[test]
fn repairs_have_the_places_of_the_file_and_are_confirmed_when_they_are_made() {
    let ralston = "order = 4\ndigits = 4\nc = [0, 0.4, 0.4557, 1]\n\
        a = [[0.4], [0.2970, 0.1588], [0.2181, -3.0510, 3.8329]]\nb = [0.1748, -0.5515, 1.2505, 0.1712]\n";
    let kutta = |b: &str| {
        format!("order = 3\ndigits = 3\na = [['1/2'], [-1, 2]]\nc = [0, '1/2', 1]\nb = [0.167, {b}, 0.167]\n")
    };
    assert_eq!(judged(&kutta("0.667")).outcome(), Outcome::Pass);
    for (text, was, right) in
        [(ralston.to_owned(), "1.2505", "1.2055"), (kutta("0.767"), "0.767", "0.66"), (kutta("0.676"), "0.676", "0.66")]
    {
        let judgement = judged(&text);
        let Some(repair) = judgement.repairs().iter().find(|repair| repair.was == was) else {
            panic!("{was}: {:?}", judgement.diagnosis)
        };
        assert!(repair.text.starts_with(right) && repair.text.len() == was.len(), "{was}: {}", repair.text);
        let mended = judged(&text.replace(was, &repair.text));
        assert_eq!(mended.outcome(), Outcome::Pass, "{:?}", mended.verdicts);
    }
}

/// Heun's method, its sum of b off by a digit, and an embedded one.
#[test]
fn a_table_without_claims_is_meant_to_be_consistent() {
    let outcome = |text: &str| judged(text).outcome();
    assert_eq!(outcome("0 |\n1 | 1\n  | 1/2 1/2\n"), Outcome::Pass);
    assert_eq!(outcome("0 |\n1 | 1\n  | 1/2 2/5\n"), Outcome::Fail);
    assert_eq!(outcome("0 |\n1 | 1\n  | 1/2 1/2\n  | 1 0\n"), Outcome::Pass);
    assert_eq!(outcome("0 |\n1 | 1\n  | 1/2 1/2\n  | 1 1\n"), Outcome::Fail);
}

/// No explicit method of seven stages has an order above 6, so that Dormand and Prince's of order 5 is as it was meant to be.
#[test]
fn orders_that_no_such_tableau_has_are_not_looked_for() {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("methods/dormand-prince.toml"));
    let text = text.expect("it is shipped");
    let unlabelled: String = text
        .lines()
        .filter(|line| !line.contains("order") && !line.starts_with("claims"))
        .map(|line| format!("{line}\n"))
        .collect();
    let judgement = judged(&unlabelled);
    assert!(matches!(judgement.diagnosis, Diagnosis::Sound), "{:?}", judgement.diagnosis);
    assert_eq!(judgement.outcome(), Outcome::Pass);
}

/// Lobatto IIIB of two stages, A of which knows no c: rows of A add up to ½ where c is 0 and 1.
const LOBATTO_IIIB2: &str = "order = 2\nclaims = [\"A-stable\", \"symmetric\"]\nc = [0, 1]\n\
                             a = [[\"1/2\", 0], [\"1/2\", 0]]\nb = [\"1/2\", \"1/2\"]\n";

#[test]
fn abscissae_of_a_methods_own_are_held_to_the_order_where_f_depends_on_time() {
    let judgement = judge(LOBATTO_IIIB2, Effort::Runs);
    assert!(matches!(judgement.diagnosis, Diagnosis::OwnTimes), "{:?}", judgement.diagnosis);
    let times = judgement.verdicts.iter().find(|verdict| verdict.subject == "abscissae").expect("it has its own");
    let told = "the order is 2 too, and the stage order is 0";
    assert!(times.check.reason.ends_with(told), "{}", times.check.reason);
    assert_eq!((judgement.outcome(), judgement.diagnosis_text()), (Outcome::Pass, None));
    // Without time in f its stages are those of the implicit midpoint rule, and what is claimed of it agrees with the runs.
    let facts = judgement.facts();
    let structure = facts.iter().find(|(label, _)| *label == "structure").expect("told");
    assert!(structure.1.starts_with("symplectic where f does not depend on t, symmetric, "), "{}", structure.1);
    let structure = judge(&LOBATTO_IIIB2.replace("A-stable", "symplectic"), Effort::Runs);
    for subject in ["symplectic", "symmetric"] {
        let said = structure.verdicts.iter().filter(|verdict| verdict.subject == subject);
        assert_eq!(said.map(|verdict| verdict.check.outcome).collect::<Vec<_>>(), [Outcome::Pass; 2], "{subject}");
    }
    let symplectic = structure.verdicts.iter().find(|verdict| verdict.subject == "symplectic").expect("claimed");
    let told = "b_i a_ij + b_j a_ji = b_i b_j for all i, j where f does not depend on t; stages 1, 2 are equal: judged on the 1 stage of \
                the reduced method";
    assert_eq!(symplectic.check.reason, told);
    // RK4 with the times of another: what is claimed is the order with them.
    let lower = "order = 2\nc = [0, \"1/3\", \"2/3\", 1]\na = [[], [\"1/2\"], [0, \"1/2\"], [0, 0, 1]]\n\
                 b = [\"1/6\", \"1/3\", \"1/3\", \"1/6\"]\n";
    let judgement = judge(lower, Effort::Theory);
    assert_eq!(refuted(&judgement), Vec::<&str>::new());
    let reasons: Vec<&str> = judgement.verdicts.iter().map(|verdict| verdict.check.reason.as_str()).collect();
    assert!(
        reasons.iter().any(|text| text.contains("the order on v̇ = f(t, v) is 2, and without t it is 4")),
        "{reasons:?}"
    );
    // Without a label nothing says that it is meant so, but what it would be.
    let silent = judge(&LOBATTO_IIIB2.replace("order = 2\n", ""), Effort::Theory);
    let told = silent.diagnosis_text().expect("c is not the sums");
    assert!(told.contains("or c is meant so") && told.contains("the order on v̇ = f(t, v) is 2 still"), "{told}");
    assert_eq!(refuted(&silent), ["row sums"]);
    // c = (¼, 1): Σ b_i c_i is not ½. And with weights (0, 1) of an embedded method of order 2 c₂ is not.
    for wrong in [
        LOBATTO_IIIB2.replace("c = [0, 1]", "c = [\"1/4\", 1]"),
        format!("{LOBATTO_IIIB2}b_hat = [0, 1]\nembedded_order = 2\n"),
    ] {
        let judgement = judge(&wrong, Effort::Theory);
        assert!(matches!(judgement.diagnosis, Diagnosis::Several { .. }), "{wrong}: {:?}", judgement.diagnosis);
        assert_eq!(refuted(&judgement), ["row sums"], "{wrong}");
    }
    let lower = judge(&LOBATTO_IIIB2.replace("c = [0, 1]", "c = [\"1/4\", 1]"), Effort::Theory);
    let rows = lower.verdicts.iter().find(|verdict| verdict.subject == "row sums").expect("looked at");
    assert!(rows.check.reason.ends_with("; with this c the order on v̇ = f(t, v) is 1"), "{}", rows.check.reason);
}

/// A pair of tableaux with abscissae that are the sums of the rows of neither.
const PAIR: &str = "kind = \"partitioned-runge-kutta\"\norder = 2\nclaims = [\"symplectic\", \"symmetric\"]\nc = [\"1/4\", \"3/4\"]\n\
                    a = [[0, 0], [\"1/2\", \"1/2\"]]\nb = [\"1/2\", \"1/2\"]\n\
                    a_hat = [[\"1/2\", 0], [\"1/2\", 0]]\nb_hat = [\"1/2\", \"1/2\"]\n";

#[test]
fn abscissae_of_a_pairs_own_are_held_to_the_order_where_f_depends_on_time() {
    for text in [PAIR.to_owned(), format!("systems = \"separable\"\n{PAIR}")] {
        let judgement = judge(&text, Effort::Runs);
        assert!(matches!(judgement.diagnosis, Diagnosis::OwnTimes), "{text}: {:?}", judgement.diagnosis);
        let times = judgement.verdicts.iter().find(|verdict| verdict.subject == "abscissae").expect("it has its own");
        assert!(times.check.reason.ends_with("; on v̇ = f(t, v) the order is 2 too"), "{}", times.check.reason);
        let run = judgement.verdicts.iter().find(|verdict| verdict.subject == "non-autonomous").expect("run");
        assert_eq!((run.check.outcome, judgement.outcome()), (Outcome::Pass, Outcome::Pass), "{}", run.check.reason);
        assert_eq!(judgement.diagnosis_text(), None);
    }
    // Σ b_i c_i is 11/24: order 1 with time, as runs show.
    let lower = PAIR.replace("3/4", "2/3");
    let judgement = judge(&lower, Effort::Runs);
    assert!(matches!(judgement.diagnosis, Diagnosis::Several { .. }), "{:?}", judgement.diagnosis);
    assert_eq!(refuted(&judgement), ["row sums"]);
    let rows = judgement.verdicts.iter().find(|verdict| verdict.subject == "row sums").expect("looked at");
    assert!(rows.check.reason.ends_with("; with this c the order on v̇ = f(t, v) is 1"), "{}", rows.check.reason);
    let in_time = judgement.measured.iter().find(|measured| measured.kind == "non-autonomous").expect("run");
    assert_eq!(in_time.expected, Some((1.0, "the conditions with c as given")));
    let meant = judge(&lower.replace("order = 2", "order = 1"), Effort::Theory);
    assert_eq!((meant.outcome(), meant.diagnosis_text()), (Outcome::Pass, None));
    let silent = judge(&PAIR.replace("order = 2\n", ""), Effort::Theory);
    let told = silent.diagnosis_text().expect("c is not the sums");
    assert!(told.contains("or c is meant so") && told.contains("the order on v̇ = f(t, v) is 2 still"), "{told}");
    // A single one is a misprint, which no label makes right.
    let single = judge(&PAIR.replace("c = [\"1/4\", \"3/4\"]", "c = [0, \"3/4\"]"), Effort::Theory);
    let told = single.diagnosis_text().expect("c is not the sums");
    assert_eq!(told, "A coefficient is wrong. With one coefficient changed the order is 2, and all row sums hold.");
}

/// C_1 and C_2 of two Adams weights that are both wrong: no label is right of what has no order.
#[test]
fn no_label_is_blamed_where_there_is_no_order() {
    let sigma = |first: &str, order: u32| {
        let text = format!("kind = \"multistep\"\norder = {order}\nrho = [-1, 1]\nsigma = [{first}, \"1/4\"]\n");
        judge(&text, Effort::Theory).diagnosis_text().expect("something is wrong")
    };
    assert!(sigma("\"1/3\"", 2).starts_with("More than one coefficient is wrong: "), "{}", sigma("\"1/3\"", 2));
    let label = "The label is too high, or more than one coefficient is wrong: ";
    assert!(sigma("\"3/4\"", 3).starts_with(label), "{}", sigma("\"3/4\"", 3));
}

/// An entry and the c that was made of it: neither is right without the other.
#[test]
fn a_row_of_a_pair_is_mended_with_the_abscissa_that_its_sum_is() {
    let text = PAIR
        .replace("[\"1/4\", \"3/4\"]", "[0, \"5/6\"]")
        .replace("[\"1/2\", \"1/2\"]]\nb =", "[\"1/2\", \"1/3\"]]\nb =");
    let changes = judge(&text, Effort::Theory).changes();
    assert!(changes.iter().any(|change| change.starts_with("a[2,2]: 1/3 → 1/2, and c[2] with it")), "{changes:?}");
}

/// What a printed condition is off by, of a file with these coefficients: each sum over all its indices.
fn residual(condition: &str, body: &Body) -> f64 {
    let doubles = |list: &[Coefficient]| list.iter().map(|x| x.real.to_f64()).collect::<Vec<_>>();
    let rows = |a: &[Vec<Coefficient>]| a.iter().map(|row| doubles(row)).collect::<Vec<_>>();
    let sums = |a: &[Vec<f64>]| a.iter().map(|row| row.iter().sum()).collect::<Vec<f64>>();
    let (lists, matrices) = match body {
        Body::RungeKutta(Tableau { a, b, c, .. }) => {
            let a = rows(a);
            let c = c.as_deref().map_or_else(|| sums(&a), doubles);
            (vec![("b", doubles(b)), ("c", c)], vec![("a", a)])
        }
        Body::Parts(parts) => {
            let [a, hat] = parts.a.each_ref().map(|a| rows(a));
            let stated = parts.c.as_deref().map(doubles);
            let [c, c_hat] = [&a, &hat].map(|a| stated.clone().unwrap_or_else(|| sums(a)));
            let [b, b_hat] = parts.b.each_ref().map(|b| doubles(b));
            (vec![("b", b), ("b̂", b_hat), ("c", c), ("ĉ", c_hat)], vec![("a", a), ("â", hat)])
        }
        _ => panic!("it has stages"),
    };
    let (sum, right) = condition.strip_prefix("Σ ").and_then(|rest| rest.split_once(" = ")).expect(condition);
    let right = right.strip_prefix("1/").map_or(1.0, |density| 1.0 / density.parse::<f64>().expect(condition));
    let factors: Vec<(&str, Vec<usize>, i32)> = sum
        .split(' ')
        .map(|factor| {
            let (name, rest) = factor.split_once('_').expect(condition);
            let indices: Vec<usize> =
                rest.chars().filter(char::is_ascii_lowercase).map(|index| index as usize - 'i' as usize).collect();
            let power = rest.chars().last().and_then(|last| "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().position(|digit| digit == last));
            (name, indices, power.unwrap_or(1) as i32)
        })
        .collect();
    let (stages, used) = (lists[0].1.len(), 1 + factors.iter().flat_map(|factor| &factor.1).max().expect(condition));
    let term = |n: usize| {
        let at = |index: usize| n / stages.pow(index as u32) % stages;
        let value = |(name, indices, power): &(&str, Vec<usize>, i32)| {
            let x = match indices.as_slice() {
                [i] => lists.iter().find(|list| list.0 == *name).expect(condition).1[at(*i)],
                [i, j] => matrices.iter().find(|matrix| matrix.0 == *name).expect(condition).1[at(*i)][at(*j)],
                _ => panic!("{condition}"),
            };
            x.powi(*power)
        };
        factors.iter().map(value).product::<f64>()
    };
    (0..stages.pow(used as u32)).map(term).sum::<f64>() - right
}

/// Without c, c is the sums of the rows; with one that is not, the sums are spelled out.
#[test]
fn a_printed_condition_is_off_by_what_is_printed_beside_it() {
    let mut spelled = 0;
    for text in [
        shipped("rk4"),
        shipped("stormer-verlet"),
        LOBATTO_IIIB2.to_owned(),
        PAIR.to_owned(),
        // The sums of the rows of a alone, and those of â alone.
        PAIR.replace("[\"1/4\", \"3/4\"]", "[0, 1]"),
        PAIR.replace("[\"1/4\", \"3/4\"]", "[\"1/2\", \"1/2\"]"),
    ] {
        let judgement = judge(&text, Effort::Theory);
        let table = judgement.evidence().tables.into_iter().find(|table| table.id == "conditions").expect("it has");
        for row in &table.rows {
            let (Cell::Text(condition), Cell::Number(printed)) = (&row[2], &row[3]) else { panic!("{row:?}") };
            let computed = residual(condition, &judgement.file.body);
            assert!((computed - printed).abs() < 1e-14, "{text}: {condition} is off by {computed}, not {printed}");
            spelled += usize::from(condition.contains(" a_ij a_ik") || condition.contains(" â_ij â_ik"));
        }
    }
    assert!(spelled > 5, "{spelled}");
    // The claim has the same condition.
    let claim = judge(LOBATTO_IIIB2, Effort::Theory);
    let reason = &claim.verdicts.iter().find(|verdict| verdict.subject == "order 2").expect("claimed").check.reason;
    assert!(reason.ends_with("; of order 3, Σ b_i a_ij a_jk = 1/6 is off by 8.333e-2"), "{reason}");
}

/// Time is one more component of q, or of p, whichever matrix has c as the sums of its rows.
#[test]
fn abscissae_of_a_partitioned_method_are_those_of_either_part() {
    let (a, hat) = ("[[0, 0], [\"1/2\", \"1/2\"]]", "[[\"1/2\", 0], [\"1/2\", 0]]");
    let pair = |first: &str, second: &str| {
        format!(
            "kind = \"partitioned-runge-kutta\"\norder = 2\nclaims = [\"symplectic\", \"symmetric\"]\nc = [0, 1]\n\
             a = {first}\nb = [\"1/2\", \"1/2\"]\na_hat = {second}\nb_hat = [\"1/2\", \"1/2\"]\n"
        )
    };
    for (text, name) in [(pair(a, hat), "a"), (pair(hat, a), "â")] {
        let judgement = judge(&text, Effort::Theory);
        let rows = judgement.verdicts.iter().find(|verdict| verdict.subject == "row sums").expect("c is stated");
        assert_eq!(rows.check.reason, format!("c_i = Σ_j {name}_ij in every row"));
        assert!(judgement.outcome() == Outcome::Pass && matches!(judgement.diagnosis, Diagnosis::Sound), "{text}");
    }
    // An entry that makes a row of â another one is found with the c that it disagrees with.
    let judgement =
        judge(&pair(hat, a).replace("[0, 0], [\"1/2\", \"1/2\"]", "[0, 0], [\"1/2\", \"1/3\"]"), Effort::Theory);
    assert!(
        judgement.changes().iter().any(|change| change.starts_with("a_hat[2,2]: 1/3 → 1/2")),
        "{:?}",
        judgement.changes()
    );
}

const MERSON: &str = "order = 4\nembedded_order = 3\nc = [0, \"1/3\", \"1/3\", \"1/2\", 1]\n\
                      a = [[], [\"1/3\"], [\"1/6\", \"1/6\"], [\"1/8\", 0, \"3/8\"], [\"1/2\", 0, \"-3/2\", 2]]\n\
                      b = [\"1/6\", 0, 0, \"2/3\", \"1/6\"]\nb_hat = [\"1/10\", 0, \"3/10\", \"2/5\", \"1/5\"]\n";

/// \[HW96\] IV.6: Σ |b_i| is 17, and each slope that follows from a value is divided by γ = ¼.
const SDIRK4: &str = "order = 4\nembedded_order = 3\nclaims = [\"L-stable\"]\n\
    a = [[\"1/4\"], [\"1/2\", \"1/4\"], [\"17/50\", \"-1/25\", \"1/4\"], [\"371/1360\", \"-137/2720\", \"15/544\", \"1/4\"],\n\
    [\"25/24\", \"-49/48\", \"125/16\", \"-85/12\", \"1/4\"]]\nc = [\"1/4\", \"3/4\", \"11/20\", \"1/2\", 1]\n\
    b = [\"25/24\", \"-49/48\", \"125/16\", \"-85/12\", \"1/4\"]\nb_hat = [\"59/48\", \"-17/96\", \"225/32\", \"-85/12\", 0]\n";

/// The pair of orders 7 and 8 of \[HNW93\] II.5.
const FEHLBERG78: &str = r#"
order = 7
embedded_order = 8
c = [0, "2/27", "1/9", "1/6", "5/12", "1/2", "5/6", "1/6", "2/3", "1/3", 1, 0, 1]
a = [
    [],
    ["2/27"],
    ["1/36", "1/12"],
    ["1/24", 0, "1/8"],
    ["5/12", 0, "-25/16", "25/16"],
    ["1/20", 0, 0, "1/4", "1/5"],
    ["-25/108", 0, 0, "125/108", "-65/27", "125/54"],
    ["31/300", 0, 0, 0, "61/225", "-2/9", "13/900"],
    [2, 0, 0, "-53/6", "704/45", "-107/9", "67/90", 3],
    ["-91/108", 0, 0, "23/108", "-976/135", "311/54", "-19/60", "17/6", "-1/12"],
    ["2383/4100", 0, 0, "-341/164", "4496/1025", "-301/82", "2133/4100", "45/82", "45/164", "18/41"],
    ["3/205", 0, 0, 0, 0, "-6/41", "-3/205", "-3/41", "3/41", "6/41", 0],
    ["-1777/4100", 0, 0, "-341/164", "4496/1025", "-289/82", "2193/4100", "51/82", "33/164", "12/41", 0, 1],
]
b = ["41/840", 0, 0, 0, 0, "34/105", "9/35", "9/35", "9/280", "9/280", "41/840", 0, 0]
b_hat = [0, 0, 0, 0, 0, "34/105", "9/35", "9/35", "9/280", "9/280", 0, "41/840", "41/840"]
"#;

/// Nyström's explicit formulas of three and four steps (\[HNW93\] III.1), weakly stable.
const NYSTROM3: &str =
    "kind = \"multistep\"\norder = 3\nrho = [0, -1, 0, 1]\nsigma = [\"1/3\", \"-2/3\", \"7/3\", 0]\n";
const NYSTROM4: &str =
    "kind = \"multistep\"\norder = 4\nrho = [0, 0, -1, 0, 1]\nsigma = [\"-1/3\", \"4/3\", \"-5/3\", \"8/3\", 0]\n";

/// Leading terms that are small beside the next ones, roundings of slopes, and parasitic roots: longer times, finer steps, a floor that
/// knows of them and problems on which they do not grow tell.
#[test]
fn the_orders_of_right_methods_settle_whose_leading_errors_are_small() {
    for text in [MERSON, SDIRK4, FEHLBERG78, NYSTROM3, NYSTROM4] {
        let judgement = judge(text, Effort::Runs);
        let open = judgement.verdicts.iter().filter(|verdict| verdict.check.outcome == Outcome::Inconclusive);
        let open: Vec<&str> = open.map(|verdict| verdict.check.reason.as_str()).collect();
        assert!(open.is_empty() && judgement.outcome() == Outcome::Pass, "{text}: {open:?}");
    }
}

/// Radau IIA of order 5 to eight places: on stiff problems its errors are below what the last of them leaves open.
#[test]
fn an_order_that_the_digits_of_a_file_leave_open_is_not_settled() {
    let text = "order = 5\nc = [0.15505103, 0.64494897, 1]\n\
                a = [[0.19681548, -0.06553543, 0.02377097], [0.39442431, 0.29207341, -0.04154875], [0.37640306, 0.51248583, 0.11111111]]\n\
                b = [0.37640306, 0.51248583, 0.11111111]\n";
    let judgement = judge(text, Effort::Runs);
    let stiff = judgement.verdicts.iter().find(|verdict| verdict.subject == "stiff").expect("looked at");
    assert_eq!(stiff.check.outcome, Outcome::NotSettled, "{}", stiff.check.reason);
    assert!(stiff.check.reason.contains("the digits printed leave"), "{}", stiff.check.reason);
    assert_eq!(judgement.outcome(), Outcome::Pass);
}

/// Half a step of Euler's method, of which no order is claimed.
#[test]
fn a_method_without_an_order_is_told_to_be_inconsistent() {
    let reason = |b: &str| {
        let file = MethodFile::parse("m.toml", "m", &format!("a = [[0]]\nb = ['{b}']\n")).expect("well-formed");
        let judgement = Judgement::new(file, Effort::Theory);
        let verdict =
            judgement.verdicts.into_iter().find(|verdict| verdict.subject == "consistency").expect("looked at");
        (verdict.check.outcome, verdict.check.reason)
    };
    assert_eq!(reason("1"), (Outcome::Pass, "the conditions of order 1 hold".into()));
    let fails = "the conditions of order 1 fail: its runs do not converge to the solution";
    assert_eq!(reason("1/2"), (Outcome::Fail, fails.into()));
}

/// The midpoint rule but for 10⁻¹³, of order 1 and not symplectic, which no run shows.
#[test]
fn what_runs_alone_leave_open_is_not_confirmed() {
    let path = crate::scratch("judge/open-by-runs").join("m.toml");
    std::fs::create_dir_all(path.parent().expect("a directory")).expect("writable");
    std::fs::write(&path, "a = [['1/2 + 1/10^13']]\nb = [1]\n").expect("writable");
    let (status, out, error) = say(&format!("judge {}", path.display()));
    assert!(status == 3 && out.contains("Runs alone leave something open"), "{out}{error}");
    let (status, out, error) = say(&format!("judge {} --no-runs", path.display()));
    assert!(status == 0 && !out.contains("inconclusive"), "{out}{error}");
}
