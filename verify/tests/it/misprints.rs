//! Misprints that are more than one wrong entry, and files that leave out what their claim is for.

use std::path::Path;

use verify::evidence::Outcome;
use verify::judge::diagnosis::Diagnosis;
use verify::judge::file::MethodFile;
use verify::judge::{Effort, Judgement};

fn shipped(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("methods").join(name).with_extension("toml");
    std::fs::read_to_string(path).expect(name)
}

/// A shipped file with texts replaced wherever they stand.
fn changed(name: &str, replacements: &[(&str, &str)]) -> String {
    replacements.iter().fold(shipped(name), |text, (from, to)| {
        assert!(text.contains(from), "{name}: {from}");
        text.replace(from, to)
    })
}

fn judge(text: &str, effort: Effort) -> Judgement {
    Judgement::new(MethodFile::parse("test.toml", "test", text).expect(text), effort)
}

/// What is proposed for a shipped file with misprints, without what it mends.
fn proposed(name: &str, replacements: &[(&str, &str)]) -> Vec<String> {
    let judgement = judge(&changed(name, replacements), Effort::Theory);
    assert_eq!(judgement.outcome(), Outcome::Fail, "{name}");
    let changes = judgement.changes().into_iter();
    changes.map(|change| change.split(", mends").next().unwrap_or_default().to_owned()).collect()
}

#[test]
fn one_misprint_at_several_places_is_mended_at_each_of_them() {
    let lobatto = "lobatto-iiia-iiib3";
    for (name, replacements, change) in [
        // The last row of A is b: c₄ is right, or the sum of what is wrong.
        (
            "bogacki-shampine",
            vec![("\"2/9\", \"1/3\", \"4/9\"", "\"2/9\", \"1/2\", \"4/9\"")],
            "a[4,2] and b[2]: 1/2 → 1/3",
        ),
        (
            "bogacki-shampine",
            vec![("\"2/9\", \"1/3\", \"4/9\"", "\"2/9\", \"1/2\", \"4/9\""), ("\"3/4\", 1]", "\"3/4\", \"7/6\"]")],
            "a[4,2] and b[2]: 1/2 → 1/3, and c[4] with it",
        ),
        ("radau-iia3", vec![("\"1/9\"]", "\"1/6\"]")], "a[3,3] and b[3]: 1/6 → 1/9"),
        ("sdirk2", vec![("[\"sqrt(2)/2\"", "[\"sqrt(3)/2\"")], "a[2,1] and b[1]: sqrt(3)/2 → sqrt(2)/2"),
        // An entry of A, and c made of it.
        ("rk4", vec![("[0, 0, 1]", "[0, 0, 2]"), ("\"1/2\", 1]", "\"1/2\", 2]")], "a[4,3]: 2 → 1, and c[4] with it"),
        (
            lobatto,
            vec![("\"5/24\", \"1/3\"", "\"5/24\", \"1/4\""), ("c = [0, \"1/2\"", "c = [0, \"5/12\"")],
            "a[2,2]: 1/4 → 1/3, and c[2] with it",
        ),
        // Both parts, and all rows that are the weights.
        (
            lobatto,
            vec![
                ("b = [\"1/6\", \"2/3\"", "b = [\"1/6\", \"1/3\""),
                ("b_hat = [\"1/6\", \"2/3\"", "b_hat = [\"1/6\", \"1/3\""),
            ],
            "b[2] and b_hat[2]: 1/3 → 2/3",
        ),
        (lobatto, vec![("\"1/6\", \"2/3\"", "\"1/6\", \"1/5\"")], "a[3,2], b[2] and b_hat[2]: 1/5 → 2/3"),
        (lobatto, vec![("\"1/6\", \"2/3\"", "\"1/6\", \"1/3\"")], "a[3,2], b[2] and b_hat[2]: 1/3 → 2/3"),
        ("ruth3", vec![("\"-2/3\"", "\"-3/2\"")], "a[2,2], a[3,2] and b[2]: -3/2 → -2/3"),
    ] {
        assert_eq!(proposed(name, &replacements), [change], "{name}: {replacements:?}");
    }
}

#[test]
fn entries_that_have_been_exchanged_are_exchanged_back() {
    for (name, from, to, change) in [
        ("rk4", "[\"1/6\", \"1/3\", \"1/3\"", "[\"1/3\", \"1/6\", \"1/3\"", "b[1] ↔ b[2]"),
        ("dormand-prince", "\"3/40\", \"9/40\"", "\"9/40\", \"3/40\"", "a[3,1] ↔ a[3,2]"),
        ("dormand-prince", "\"-56/15\", \"32/9\"", "\"32/9\", \"-56/15\"", "a[4,2] ↔ a[4,3]"),
        ("bogacki-shampine", "\"1/2\", \"3/4\", 1]", "\"3/4\", \"1/2\", 1]", "c[2] ↔ c[3]"),
        ("bogacki-shampine", "\"1/4\", \"1/3\", \"1/8\"", "\"1/3\", \"1/4\", \"1/8\"", "b_hat[2] ↔ b_hat[3]"),
        ("adams-bashforth4", "\"37/24\", \"-59/24\"", "\"-59/24\", \"37/24\"", "sigma[2] ↔ sigma[3]"),
        ("nystrom5", "\"125/336\", \"162/336\"", "\"162/336\", \"125/336\"", "b[2] ↔ b[3]"),
    ] {
        assert_eq!(proposed(name, &[(from, to)]), [change], "{name}");
    }
    let rows: Vec<String> = shipped("gauss3").lines().map(str::to_owned).collect();
    let first = rows.iter().position(|row| row.starts_with("    [")).expect("a row of A");
    let mut exchanged = rows;
    exchanged.swap(first, first + 1);
    let judgement = judge(&exchanged.join("\n"), Effort::Theory);
    assert_eq!(judgement.changes(), ["row 1 of a ↔ row 2 of a, mends all 38 failing conditions"]);
    // Without a label the order that was meant is found too.
    let text = changed(
        "dormand-prince",
        &[("order = 5\nembedded_order = 4\n", ""), ("\"-56/15\", \"32/9\"", "\"32/9\", \"-56/15\"")],
    );
    let judgement = judge(&text, Effort::Theory);
    assert!(
        matches!(&judgement.diagnosis, Diagnosis::Exchanged { target, .. } if target.order == 5),
        "{:?}",
        judgement.diagnosis
    );
}

/// The weights of Adams and Bashforth add up to 1 in either sequence, and one condition of order 2 alone fails; of order 4 several do.
#[test]
fn an_exchange_that_mends_one_condition_may_be_a_coincidence() {
    for (name, from, to, is_one) in [
        ("adams-bashforth2", "\"-1/2\", \"3/2\"", "\"3/2\", \"-1/2\"", true),
        ("adams-bashforth4", "\"37/24\", \"-59/24\"", "\"-59/24\", \"37/24\"", false),
    ] {
        let judgement = judge(&changed(name, &[(from, to)]), Effort::Theory);
        assert!(matches!(judgement.diagnosis, Diagnosis::Exchanged { .. }), "{name}: {:?}", judgement.diagnosis);
        let told = judgement.diagnosis_text().expect("it is told");
        let text = "One condition may hold by coincidence: it may be the label that is wrong.";
        assert_eq!(told.contains(text), is_one, "{name}: {told}");
    }
}

#[test]
fn a_missing_sign_is_a_single_wrong_entry() {
    assert_eq!(proposed("dormand-prince", &[("\"-56/15\"", "\"56/15\"")]), ["a[4,2]: 56/15 → -56/15"]);
    assert_eq!(proposed("nystrom5", &[("\"-2/35\"", "\"2/35\"")]), ["a[4,2]: 2/35 → -2/35"]);
}

#[test]
fn weights_and_embedded_weights_that_look_interchanged_are_told() {
    let told = |replacements: &[(&str, &str)]| {
        let judgement = judge(&changed("dormand-prince", replacements), Effort::Theory);
        (judgement.diagnosis_text(), judgement.changes().len())
    };
    let names = [("b_hat =", "b_other ="), ("\nb =", "\nb_hat ="), ("b_other =", "b =")];
    let text = "b and b_hat, or the orders claimed of them, look interchanged: b has order 4, and b_hat has order 5.";
    assert_eq!(told(&names), (Some(text.to_owned()), 0));
    let unlabelled = [names.as_slice(), &[("embedded_order = 4\n", "")]].concat();
    assert_eq!(told(&unlabelled), (Some(text.to_owned()), 0));
    assert_eq!(told(&[]), (None, 0));
}

#[test]
fn a_method_for_separable_systems_whose_file_does_not_say_so_is_told_the_key() {
    for (name, order) in [("forest-ruth", 4), ("ruth3", 3)] {
        let text = changed(name, &[("systems = \"separable\"\n", "")]);
        let judgement = judge(&text, Effort::Theory);
        assert_eq!(judgement.outcome(), Outcome::Fail, "{name}");
        let told = judgement.diagnosis_text().expect(name);
        assert!(told.contains(&format!("the order is {order};")), "{told}");
        assert!(told.contains("systems = \"separable\"") && judgement.changes().is_empty(), "{told}");
        // A label that is too high there too is a wrong label.
        let text = text.replace(&format!("order = {order}"), "order = 5");
        let diagnosis = judge(&text, Effort::Theory).diagnosis;
        assert!(matches!(diagnosis, Diagnosis::LabelTooHigh { .. }), "{name}: {diagnosis:?}");
    }
}

/// Quade's method: all roots of ρ are on the unit circle, and their components grow on solutions that decay.
#[test]
fn the_order_of_a_weakly_stable_method_is_measured_where_no_solution_decays() {
    let text = "kind = \"multistep\"\norder = 6\nrho = [-1, \"8/19\", 0, \"-8/19\", 1]\n\
                sigma = [\"6/19\", \"24/19\", 0, \"24/19\", \"6/19\"]\n";
    let judgement = judge(text, Effort::Runs);
    for kind in ["linear", "nonlinear"] {
        let verdict = judgement.verdicts.iter().find(|verdict| verdict.subject == kind).expect(kind);
        assert_eq!(verdict.check.outcome, Outcome::Pass, "{kind}: {}", verdict.check.reason);
    }
}

/// With an order more than they have.
#[test]
fn a_wrong_label_of_a_right_method_gets_no_change_of_several_conditions() {
    let wrong = |(name, labelled): &'static (String, Vec<Judgement>)| {
        let judgement = labelled.last()?;
        let many = judgement.repairs().iter().any(|repair| repair.mends > 1);
        let many = many || judgement.exchanges().iter().any(|exchange| exchange.mends > 1);
        many.then(|| format!("{name}: {:?}", judgement.diagnosis))
    };
    let found: Vec<String> = crate::judgements::WRONG.iter().filter_map(wrong).collect();
    assert!(found.is_empty(), "{found:?}");
}

/// Seventeen stages at the start of the step: no change of one entry gives order 3.
#[test]
fn exchanges_that_are_not_looked_for_are_told() {
    let rows: Vec<String> = (0..17).map(|i| format!("[{}]", vec!["0"; i].join(", "))).collect();
    let text = format!("order = 3\na = [{}]\nb = [{}]\n", rows.join(", "), ["\"1/17\""; 17].join(", "));
    let told = judge(&text, Effort::Theory).diagnosis_text().expect("its order is 1");
    assert!(told.contains("Exchanged entries are looked for up to 16 stages only."), "{told}");
}

/// The backward differentiation formula of three steps with its newest step first has roots of ρ of modulus 2.3 and is inconsistent.
/// One change of a slope would make it consistent, and leave it divergent.
#[test]
fn a_formula_that_is_listed_with_its_newest_step_first_is_told() {
    let reversed = "kind = \"multistep\"\norder = 3\nrho = [\"11/6\", -3, \"3/2\", \"-1/3\"]\nsigma = [1, 0, 0, 0]\n";
    let judgement = judge(reversed, Effort::Theory);
    assert!(matches!(judgement.diagnosis, Diagnosis::Reversed { order: 3 }), "{:?}", judgement.diagnosis);
    assert!(judgement.changes().is_empty());
    let told = judgement.diagnosis_text().expect("it is wrong");
    assert!(told.contains("in reverse it has order 3"), "{told}");
    // In reverse it has order 3, and not 4; and what is listed the right way round is not reversed.
    let higher = judge(&reversed.replace("order = 3", "order = 4"), Effort::Theory);
    assert!(!matches!(higher.diagnosis, Diagnosis::Reversed { .. }), "{:?}", higher.diagnosis);
    let right = changed("bdf3", &[("order = 3", "order = 4")]);
    assert!(matches!(judge(&right, Effort::Theory).diagnosis, Diagnosis::LabelTooHigh { order: 3 }));
}

/// Solvers list b − b̂ or b̂ − b, with which they estimate the error.
#[test]
fn weights_of_an_error_estimate_in_place_of_the_embedded_ones_are_told() {
    let embedded = "b_hat = [\"7/24\", \"1/4\", \"1/3\", \"1/8\"]";
    for list in ["b_hat = [\"-5/72\", \"1/12\", \"1/9\", \"-1/8\"]", "b_hat = [\"5/72\", \"-1/12\", \"-1/9\", \"1/8\"]"]
    {
        let judgement = judge(&changed("bogacki-shampine", &[(embedded, list)]), Effort::Theory);
        let told = judgement.diagnosis_text().expect("it is wrong");
        assert!(told.starts_with("b_hat adds up to 0") && told.contains("the embedded method has order 2"), "{told}");
        assert!(judgement.changes().is_empty());
    }
    // Weights that add up to zero by a misprint are no difference of anything.
    let misprint = changed("bogacki-shampine", &[(embedded, "b_hat = [\"-17/24\", \"1/4\", \"1/3\", \"1/8\"]")]);
    let changes = judge(&misprint, Effort::Theory).changes();
    assert!(changes.iter().any(|change| change.contains("b_hat[1]: -17/24 → 7/24")), "{changes:?}");
}

/// A and b of the implicit Euler method satisfy all that there is, and the time of its stage disagrees.
#[test]
fn a_stage_time_is_changed_before_an_entry_that_satisfies_every_condition() {
    let changes = proposed("implicit-euler", &[("c = [1]", "c = [-1]")]);
    assert_eq!(changes, ["c[1]: -1 → 1", "a[1,1]: 1 → -1"]);
}

/// One unit of the last of six digits: the row sum moves by what it is uncertain by twice over.
#[test]
fn a_misprint_of_one_unit_is_mended_where_it_stands() {
    let changes = proposed("rk4", &[("[\"1/2\"]", "[0.500001]")]);
    assert_eq!(changes[0], "a[2,1]: 0.500001 → 0.500000");
}

/// After a misprint of 10⁻¹⁵ the method has order 1 and an error term of that size, which no step in double precision shows.
#[test]
fn an_error_term_that_does_not_show_is_told_from_a_special_equation() {
    let text = changed("gauss3", &[("[\"5/36\",", "[\"5/36 + 1/10^15\",")]);
    let judgement = judge(&text, Effort::Runs);
    let linear = judgement.verdicts.iter().find(|verdict| verdict.subject == "linear").expect("it is run");
    assert_eq!(linear.check.outcome, Outcome::Inconclusive, "{}", linear.check.reason);
    assert!(linear.check.reason.contains("does not show at these steps"), "{}", linear.check.reason);
    assert!(!linear.check.reason.contains("falls faster"), "{}", linear.check.reason);
}
