//! Where methods are stable, and the order that they have where they need it: `judge` against what is known in closed form.

use verify::evidence::Outcome;
use verify::judge::file::MethodFile;
use verify::judge::linear::Reach;
use verify::judge::{Effort, Judgement};

fn judge(text: &str, effort: Effort) -> Judgement {
    Judgement::new(MethodFile::parse("test.toml", "test", text).expect(text), effort)
}

fn shipped(name: &str) -> String {
    let path = format!("{}/methods/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).expect("there")
}

fn fact(judgement: &Judgement, wanted: &str) -> String {
    judgement.facts().into_iter().find(|(label, _)| *label == wanted).map(|(_, text)| text).unwrap_or_default()
}

fn claim(text: &str, claim: &str) -> (Outcome, String) {
    let judgement = judge(&format!("note = \"made\"\nclaims = [\"{claim}\"]\n{text}"), Effort::Theory);
    let verdict = judgement.verdicts.iter().find(|verdict| verdict.subject.replace('°', "") == claim);
    let check = &verdict.expect(claim).check;
    (check.outcome, check.reason.clone())
}

const RK4: &str = "a = [[\"1/2\"], [0, \"1/2\"], [0, 0, 1]]\nb = [\"1/6\", \"1/3\", \"1/3\", \"1/6\"]";

/// RK4 with weights of so few digits.
fn rounded(digits: usize) -> String {
    let [sixth, third] = [1.0 / 6.0, 1.0 / 3.0].map(|x| format!("{x:.digits$}"));
    format!("digits = {digits}\na = [[], [0.5], [0, 0.5], [0, 0, 1]]\nb = [{sixth}, {third}, {third}, {sixth}]\n")
}

/// R(z) = T_s(1 + z/s²), by the recurrence of the Chebyshev polynomials: Y_1 = Y_0 + h f_0/s², Y_j = 2 Y_{j−1} − Y_{j−2} + 2h f_{j−1}/s².
fn chebyshev(s: usize) -> String {
    let mut rows = vec![vec![0_i64; s], vec![0; s]];
    rows[1][0] = 1;
    for j in 2..=s {
        let mut row: Vec<i64> = (0..s).map(|k| 2 * rows[j - 1][k] - rows[j - 2][k]).collect();
        row[j - 1] += 2;
        rows.push(row);
    }
    let list = |row: &[i64]| row.iter().map(|n| format!("\"{n}/{}\"", s * s)).collect::<Vec<_>>().join(", ");
    let a: Vec<String> = rows[..s].iter().enumerate().map(|(i, row)| format!("[{}]", list(&row[..i]))).collect();
    format!("a = [{}]\nb = [{}]\n", a.join(", "), list(&rows[s]))
}

/// R touches ±1 at s − 1 points, which end nothing, and leaves [−1, 1] at 2s².
#[test]
fn chebyshev_methods_reach_twice_the_square_of_their_stages() {
    for s in [2, 3, 5, 9, 10, 12, 15, 20] {
        let judgement = judge(&chebyshev(s), Effort::Theory);
        let theory = judgement.runge_kutta().expect("it is one");
        let Reach::UpTo { end, open, witness } = theory.negative else { panic!("{s}: {:?}", theory.negative) };
        let known = 2.0 * (s * s) as f64;
        assert!((end - known).abs() < 1e-9 * known && open < 1e-9 * known && witness > end, "{s}: {end} ± {open}");
        assert!(matches!(theory.imaginary, Reach::UpTo { end: 0.0, .. }), "{s}: {:?}", theory.imaginary);
        assert_eq!(fact(&judgement, "axes"), format!("negative axis to {known:.4}; nothing of the imaginary axis"));
    }
}

/// What two digits leave of RK4 is not A-stable, and not stable on all of an axis; and more of them leave less open.
#[test]
fn few_digits_bound_an_interval_and_do_not_lengthen_it() {
    for (digits, axes) in [
        (2, "negative axis to 2.8 ± 0.3; what is stable of the imaginary axis is open for the digits given"),
        (3, "negative axis to 2.78 ± 0.04; imaginary axis to 2.8 ± 0.2"),
    ] {
        let judgement = judge(&rounded(digits), Effort::Theory);
        assert_eq!(fact(&judgement, "axes"), axes);
        assert!(fact(&judgement, "stability").starts_with("conditionally stable"), "{}", fact(&judgement, "stability"));
        let outcome = |text: &str| claim(&rounded(digits), text).0;
        assert_eq!((outcome("A-stable"), outcome("A(0)-stable")), (Outcome::Fail, Outcome::Fail));
        assert_eq!(outcome("stable on the imaginary axis to 2.8"), Outcome::Inconclusive);
    }
    // A number has no more digits than the coefficients.
    let order = fact(&judge(&rounded(2), Effort::Theory), "order");
    assert!(order.ends_with("principal error 2e-2"), "{order}");
    let judgement = judge(&rounded(8), Effort::Theory);
    assert!(fact(&judgement, "axes").starts_with("negative axis to 2.7853; imaginary axis to 2.8284"));
}

/// hλ = ρ(−1)/σ(−1) = −2/Σ γ_j 2ʲ, with the γ_j of the backward differences (\[HNW93\] III.1).
#[test]
fn adams_and_bashforth_are_stable_however_short_the_interval() {
    let gamma: [(i64, i64); 12] = [
        (1, 1),
        (1, 2),
        (5, 12),
        (3, 8),
        (251, 720),
        (95, 288),
        (19087, 60480),
        (5257, 17280),
        (1_070_017, 3_628_800),
        (25713, 89600),
        (26_842_253, 95_800_320),
        (4_777_223, 17_418_240),
    ];
    let binomial = |n: usize, k: usize| (0..k).fold(1, |b, i| b * (n - i) / (i + 1));
    for k in 2..=12 {
        let slope = |i: usize| {
            let sign = if i.is_multiple_of(2) { "" } else { "-" };
            let terms = (i..k).map(|j| format!("{}*{}/{}", binomial(j, i), gamma[j].0, gamma[j].1));
            format!("\"{sign}({})\"", terms.collect::<Vec<_>>().join(" + "))
        };
        let sigma: Vec<String> = (0..k).rev().map(slope).collect();
        let rho = format!("{}-1, 1", "0, ".repeat(k - 1));
        let text =
            format!("kind = \"multistep\"\nstart = \"gauss4\"\nrho = [{rho}]\nsigma = [{}, 0]\n", sigma.join(", "));
        let found = judge(&text, Effort::Theory);
        assert_eq!(found.theory.order(), k as u32, "{text}");
        let known = 2.0 / (0..k).map(|j| gamma[j].0 as f64 / gamma[j].1 as f64 * 2_f64.powi(j as i32)).sum::<f64>();
        let stability = fact(&found, "stability");
        let end = stability.strip_prefix("negative axis to ").and_then(|rest| rest.split(';').next());
        let end: f64 = end.expect(&stability).parse().expect("a number");
        assert!((end / known - 1.0).abs() < 5e-4, "{k}: {end} is not {known}");
    }
}

/// BDF7 grows for h → 0 and not for hλ → −∞; an interval need not begin at 0.
#[test]
fn a_method_that_is_not_zero_stable_may_be_stable_farther_out() {
    let stability = fact(&judge(&shipped("bdf7"), Effort::Theory), "stability");
    assert!(stability.starts_with("negative axis beyond 8.2426"), "{stability}");
}

/// To half a unit of the last digit that the claim prints, which is said where it matters.
#[test]
fn bounds_are_claimed_to_the_digits_that_they_print() {
    let bdf3 = shipped("bdf3").lines().filter(|line| !line.starts_with("claims")).collect::<Vec<_>>().join("\n");
    let nystrom = "kind = \"nystrom\"\na = [[0]]\nb_bar = [\"1/2\"]\nb = [1]\nc = [\"1/2\"]";
    let axis = |y: &str| format!("stable on the imaginary axis to {y}");
    for (body, holds, fails) in [
        (RK4, axis("2.83"), axis("2.829")),
        (RK4, axis("2.8284"), axis("2.8285")),
        (nystrom, axis("2.00"), axis("2.001")),
        (&bdf3, "A(86.03)-stable".into(), "A(86.04)-stable".into()),
        (&bdf3, "A(86)-stable".into(), "A(86.1)-stable".into()),
    ] {
        let ((passes, why), (refuted, because)) = (claim(body, &holds), claim(body, &fails));
        assert_eq!((passes, refuted), (Outcome::Pass, Outcome::Fail), "{why}; {because}");
        assert!(because.contains("to the digits claimed"), "{because}");
    }
    // A denial is of the number itself.
    for (denied, outcome) in [("not A(86.04)-stable", Outcome::Pass), ("not A(86.03)-stable", Outcome::Fail)] {
        assert_eq!(claim(&bdf3, denied).0, outcome, "{denied}");
    }
    let (_, why) = claim(RK4, &axis("2.83"));
    assert!(why.ends_with("; 2.83, to the digits claimed, is 2.825 at least"), "{why}");
}

/// On Prothero and Robinson's problem R(∞) = ±1 leaves a power of h: s + 1 for an odd number s of Gauss' stages, and s for an even one
/// (\[HW96\] IV.15).
#[test]
fn the_stiff_order_is_measured_where_no_theory_has_it() {
    for (name, order) in
        [("gauss2", 2.0), ("gauss3", 4.0), ("gauss4", 4.0), ("lobatto-iiib3", 2.0), ("lobatto-iiie3", 2.0)]
    {
        let judgement = judge(&shipped(name), Effort::Runs);
        let stiff = judgement.measured.iter().find(|measured| measured.kind == "stiff").expect("it is run");
        let fit = stiff.result.as_ref().expect("a fit");
        let line = fit.line.expect("a line");
        assert!((line.slope - order).abs() < 0.1, "{name}: {}", fit.reason);
        let told = fact(&judgement, "stiff");
        assert!(told.starts_with(&format!("order {:.1}", line.slope)), "{name}: {told}");
        assert!(judgement.verdicts.iter().all(|verdict| verdict.subject != "stiff"));
    }
}

/// Errors of stiffly accurate methods are divided by λ at hλ ≫ 1, and those of Radau IA are not.
#[test]
fn the_reason_of_an_order_reduction_is_that_of_the_method() {
    for (name, says) in [("radau-iia3", "divided by λ, not by 1/h"), ("radau-ia3", "undivided by λ")] {
        let judgement = judge(&shipped(name), Effort::Runs);
        let stiff = judgement.verdicts.iter().find(|verdict| verdict.subject == "stiff").expect("it is run");
        assert!(stiff.check.outcome == Outcome::Pass && stiff.check.reason.contains(says), "{}", stiff.check.reason);
    }
}

/// s stages have order 2s at most, which Gauss' have, beyond the conditions that are made up.
#[test]
fn an_order_that_no_method_exceeds_is_told_as_it_is() {
    let text: String =
        include_str!("gauss6.toml").lines().filter(|l| !l.starts_with("claims")).collect::<Vec<_>>().join("\n");
    let text = text.replace("order=12\n", "");
    assert_eq!(fact(&judge(&text, Effort::Theory), "order"), "12, the most that 6 stages can have");
    for (p, outcome) in [(9, Outcome::Fail), (10, Outcome::Fail), (12, Outcome::Pass), (13, Outcome::Fail)] {
        assert_eq!(claim(&text, &format!("order {p}")).0, outcome, "{p}");
    }
}
