//! The claims of the papers and their verdicts, the first chapter of the report.

use super::{Context, Study, StudyError};
use crate::claim::{self, Claim, Digits, Judged, Quantifier, Verdict};
use crate::evidence::number::digits;
use crate::evidence::{Cell, Check, Evidence, Outcome, Requirement, Section, Table};
use crate::row;

pub(super) const STUDY: Study = Study {
    id: "claims",
    title: "The claims of the papers",
    question: "What the two papers claim: does it hold, by how much, and why?",
    source: "[S24], [KY21]",
    run,
};

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let judged = &claim::judge(context);
    let mut evidence = Evidence {
        checks: judged.iter().map(check).collect(),
        tables: vec![verdicts(judged), cases(judged)],
        notes: notes(judged),
        sections: judged.iter().map(section).chain([unexamined()]).collect(),
        ..Evidence::default()
    };
    for Judged { finding, .. } in judged.iter() {
        let Ok(finding) = finding else { continue };
        evidence.tables.extend(finding.tables.iter().cloned());
        evidence.figures.extend(finding.figures.iter().cloned());
    }
    Ok(evidence)
}

/// How the comparisons of a claim make its verdict; ARCHITECTURE.md has the same words.
const RULE: &str = "A claim is confirmed if all its comparisons come out as claimed. A universal statement is refuted as stated \
                    by one counterexample, or in the wider reading where its words are read wider than the source may mean them. What is said from some size on is refuted if it fails at the largest that was tested. Any other is qualified if it holds in all cases of a condition that the paper does \
                    not state; if there is none, it is refuted if it holds in no case or, as a comparison of methods, in no case \
                    against one of the others; and else it is not supported. A condition is one that a user can check beforehand: of the \
                    problem, the step size, the data or, in a statement on a family of schemes, the member; and the finding says why it \
                    holds there. Of a range of step sizes the ends may be scanned for by the outcome itself, and the finding says so and rounds them inwards; that there is such a range has to follow \
                    from orders, error constants or a closed form, and a range that nothing but the scan shows is no condition. That a method beats some of its competitors \
                    is no condition, unless the source names each of them: then each pair is a claim of its own. Where a condition ends with the tests and not with \
                    what was found, it says how far it was tested. Where a step has no solution, that is itself the outcome, and counts \
                    against what is claimed of it; a run that broke off for another reason decides nothing. A statement marked as our restriction is what \
                    is left of a wider one, which another claim judges.";

/// That a claim could be decided, whatever the verdict: the recorded verdicts are held by the goldens.
fn check(judged: &Judged) -> Check {
    let Judged { claim, finding } = judged;
    match finding {
        Ok(finding) => Check::at_most(
            claim.id,
            format!("{} is decided, whatever the verdict: comparisons without a number", claim.id),
            finding.unsound() as f64,
            0.0,
            match finding.without_solution() {
                0 => format!("{} comparisons come out as claimed", finding.score()),
                none => {
                    format!(
                        "{} comparisons come out as claimed; {none} are of a step without a solution",
                        finding.score()
                    )
                }
            },
        ),
        Err(error) => Check::undecided(claim.id, format!("{} is decided", claim.id), Outcome::Fail, error.to_string()),
    }
}

fn text(text: &str) -> Cell {
    Cell::Text(text.into())
}

fn word(judged: &Judged) -> &'static str {
    judged.verdict().map_or("broke off", Verdict::word)
}

fn verdicts(judged: &[Judged]) -> Table {
    let row = |judged: &Judged| {
        let Claim { id, statement, source, quantifier, .. } = judged.claim;
        row![*id, word(judged), *statement, found(judged), *source, said_of(*quantifier)]
    };
    Table::new(
        "claims",
        "The verdict on every claim, the claim restated, what decided it, its place in the source and what it is said of. Where the \
         source prints a number, ours stands beside it. What is said of all cases falls with one counterexample, what is said from a size on with the largest; what is said of cases that the source \
         leaves open, or of one method against others, may hold under a condition. The identifiers lead to the evidence.",
        ["id", "verdict", "claim", "found", "place", "said of"],
        judged.iter().map(row).collect(),
    )
}

/// Of what a claim is said.
fn said_of(quantifier: Quantifier) -> &'static str {
    match quantifier {
        Quantifier::Universal => "all cases",
        Quantifier::Wider => "all cases, in a wider reading",
        Quantifier::General => "cases left open",
        Quantifier::Eventual => "all cases from a size on",
        Quantifier::Comparison => "one method against others",
        Quantifier::Open => "an open question",
    }
}

/// What a referee asks after the verdict: the numbers of the source beside ours, the counterexample, where it holds.
fn found(judged: &Judged) -> String {
    let finding = match &judged.finding {
        Ok(finding) => finding,
        Err(error) => return error.to_string(),
    };
    let mut sentences: Vec<_> = finding.digits.iter().map(|digits| sentence(beside(digits))).collect();
    match judged.verdict() {
        Some(verdict) if verdict.is_refuted() => {
            sentences.extend(never_ahead(judged));
            sentences.extend(finding.counterexample().map(|case| format!("Counterexample: {case}.")))
        }
        Some(Verdict::Qualified) => {
            sentences.extend(finding.counterexample().map(|case| format!("It does not hold everywhere: {case}.")));
        }
        Some(Verdict::Answered) => sentences.push(finding.evidence.clone()),
        _ => sentences.push(format!("{} comparisons hold.", finding.score())),
    }
    if judged.verdict() != Some(Verdict::Confirmed) {
        sentences.extend(finding.where_it_holds.as_ref().map(|text| format!("{}: {text}", reach(judged))));
    }
    sentences.join(" ")
}

/// With a capital where it begins with a word; symbols and names stay as they are.
fn sentence(text: String) -> String {
    let first = text.split([' ', '’', '\'', ',', ':']).next().unwrap_or_default();
    match first.len() > 1 && first.bytes().all(|byte| byte.is_ascii_lowercase()) {
        true => text[..1].to_ascii_uppercase() + &text[1..],
        false => text,
    }
}

/// The methods that refute a comparison, since it is never ahead of them.
fn never_ahead(Judged { claim, finding }: &Judged) -> Option<String> {
    let finding = finding.as_ref().ok().filter(|_| claim.quantifier == Quantifier::Comparison)?;
    let unbeaten = finding.unbeaten().into_iter().map(|(rival, cases)| format!("0 of {cases} against {rival}"));
    let unbeaten: Vec<_> = unbeaten.collect();
    (!unbeaten.is_empty()).then(|| format!("It is ahead of each of these methods in no case: {}.", unbeaten.join(", ")))
}

/// What the finding says of where the statement holds: that decides a verdict only where a condition makes it hold.
fn reach(judged: &Judged) -> &'static str {
    match judged.verdict() {
        Some(Verdict::NotSupported) => "What is left of it",
        Some(Verdict::Answered) => "For what",
        _ => "Where it holds",
    }
}

/// A number of the source with ours.
fn beside(digits: &Digits) -> String {
    format!("{}: printed {}, here {}.", digits.what, digits.printed, brief(digits))
}

/// Our number with as many digits as the source has, two at least.
fn brief(Digits { printed, here, .. }: &Digits) -> String {
    let mantissa = printed.split('×').next().unwrap_or_default();
    let is_number = mantissa.parse::<f64>().is_ok();
    let known = mantissa.trim_start_matches(['0', '.', '−']).chars().filter(char::is_ascii_digit).count();
    digits(*here, if is_number { known.max(2) } else { 3 })
}

fn cases(judged: &[Judged]) -> Table {
    let mut rows = Vec::new();
    for Judged { claim, finding } in judged {
        for case in finding.iter().flat_map(|finding| finding.cases()) {
            let (low, high) = match case.required {
                Requirement::AtMost(high) | Requirement::Below(high) => (Cell::Empty, Cell::Number(high)),
                Requirement::AtLeast(low) | Requirement::Above(low) => (Cell::Number(low), Cell::Empty),
                Requirement::Within(low, high) => (Cell::Number(low), Cell::Number(high)),
                Requirement::Near(value, band) => (Cell::Number(value - band), Cell::Number(value + band)),
            };
            let holds = match case.holds() {
                true => "yes",
                false if case.measured.is_infinite() => "no: without a solution",
                false if case.is_sound() => "no",
                false => "not decided: the run broke off",
            };
            rows.push(vec![text(claim.id), text(&case.what), Cell::Number(case.measured), low, high, text(holds)]);
        }
    }
    Table {
        id: "claims-cases".into(),
        caption:
            "The comparisons from which the verdicts follow: what was measured, and the bounds that the claim sets."
                .into(),
        columns: ["claim", "case", "measured", "above", "below", "holds"].map(Into::into).to_vec(),
        rows,
        shown: false,
    }
}

fn section(judged: &Judged) -> Section {
    let Judged { claim, finding } = judged;
    let Claim { id, source, statement, criterion, .. } = claim;
    let mut paragraphs = vec![("Source", (*source).to_owned()), ("Criterion", (*criterion).to_owned())];
    let mut section =
        Section { id: (*id).into(), title: (*statement).into(), mark: word(judged).into(), ..Section::default() };
    match finding {
        Ok(finding) => {
            paragraphs.push(("Evidence", format!("{} {} comparisons hold.", finding.evidence, finding.score())));
            let label = match judged.verdict() {
                Some(verdict) if verdict.is_refuted() => Some("Counterexample"),
                Some(Verdict::Qualified) => Some("Where it does not hold"),
                _ => None,
            };
            if judged.verdict() == Some(Verdict::Refuted) {
                paragraphs.extend(never_ahead(judged).map(|text| ("What refutes it", text)));
            }
            paragraphs.extend(label.zip(finding.counterexample()).map(|(label, case)| (label, format!("{case}."))));
            paragraphs.extend(finding.where_it_holds.clone().map(|text| (reach(judged), text)));
            paragraphs.extend(finding.mechanism.clone().map(|text| ("Why", text)));
            section.figures = finding.figures.iter().map(|figure| figure.id.clone()).collect();
            section.tables = finding.tables.iter().map(|table| table.id.clone()).collect();
        }
        Err(error) => paragraphs.push(("Broke off", error.to_string())),
    }
    section.paragraphs = paragraphs.into_iter().map(|(label, text)| (label.to_owned(), text)).collect();
    section
}

/// What the abstracts and the conclusions say besides, and why no computation decides it.
const UNEXAMINED: [(&str, &str); 23] = [
    (
        "Validation of the canonical Hamiltonian formulation ([S24] Abstract, Sections 5 and 6)",
        "The accuracy of a scheme does not distinguish the formulation from any other with the same solutions: the least-squares Lagrangian of an \
         equation has them whatever is discretised. What the accuracy on Poiseuille flow comes from is S24-j and S24-l-2.",
    ),
    (
        "The first symplectic integrator for the Navier–Stokes equations ([S24] Abstract)",
        "Who was first is a question to the literature. Whether the schemes are symplectic is S24-m-2.",
    ),
    (
        "Unprecedented performance of further symplectic integrators ([S24] Section 6)",
        "A forecast that names no method and no measure. S24-o judges what can be built of the paper's own parts.",
    ),
    (
        "The velocity profile ([S24] Abstract)",
        "Errors are those of the velocity at the centre, as in the figures of [S24]. How close to the flow a parabola can be over the whole channel is in S24-l-2, and \
         with it the distances of the two reduced equations.",
    ),
    (
        "pₙ = 0 and pₙ₊₁ = 0 at once for h = 0 alone ([S24] Section 3)",
        "Algebra, and right: on v̇ = −v the two conditions agree where (1 − h + h²/2)(1 + h + h²/2) = 1 + h⁴/4 is 1.",
    ),
    (
        "Symplectic integrators cannot be applied to (10), (16) and (30) themselves ([S24] Sections 2 to 4)",
        "It depends on the word. The midpoint rule is applied to (10), and is called symplectic for what it does to Hamiltonian systems.",
    ),
    (
        "First-order time derivatives are not the variation of a first-order Lagrangian without unphysical terms ([S24] Section 2)",
        "The least-squares Lagrangian is of first order in v̇. Its variation gives (14), which is of second order and has solutions besides those of (10): \
         with p other than 0.",
    ),
    (
        "Liouville's theorem holds automatically ([S24] Section 2)",
        "Of (14) in (v, p) it does, as of any Hamiltonian system. In v, on the surface p = 0 to which the motion is confined, volumes shrink wherever the \
         system dissipates. What a step does to them is S24-m-2.",
    ),
    (
        "The principle includes the terms of higher order by itself ([S24] Section 3)",
        "What it includes shows in the order of its methods, which the chapter on orders measures.",
    ),
    (
        "A closure makes an initial value of p unnecessary ([S24] Section 3)",
        "So it is, by construction: no step of a closure here takes one.",
    ),
    (
        "Solutions of (10) of [S24] minimise the action (11) and solve (14) (Section 2)",
        "Algebra, and right for one unknown: the action is nowhere negative and zero on them, and the derivative of (10) along them is (14).",
    ),
    (
        "The constrained discrete equations (5) of [KY21] are those of an extended discrete Lagrangian (Section 1)",
        "Algebra, and right: the multipliers are unknowns of it, and its derivatives by them are the constraints.",
    ),
    (
        "Classical difference schemes inevitably destroy the structure and bring in artificial dissipation ([KY21] Introduction)",
        "It depends on what is called classical. The implicit midpoint rule is a difference scheme for the equation of motion and is symplectic.",
    ),
    (
        "More complex quadratures give more accurate classical integrators ([KY21] Section 3.1, after (19))",
        "It is said of other integrators than the paper's. The chapter on orders has Galerkin integrators on Gauss and Lobatto nodes, whose order rises \
         with each node.",
    ),
    (
        "MacKay's method gives Störmer–Verlet for kinetic less potential energy ([S24] Section 1)",
        "Textbook knowledge [HLW06]. The integrator called stormer-verlet here is that method.",
    ),
    (
        "The curves of Figure 1 of [KY21] coincide",
        "That is to the eye. The numbers behind them are Table 1, which is recomputed.",
    ),
    (
        "Use in commercial programs for fluid dynamics ([S24] Sections 5 and 6)",
        "A hope. The chapter on flows measures errors and costs beside usual methods.",
    ),
    (
        "A simpler construction, above all at high order ([KY21] Abstract, Introduction)",
        "Simplicity has no unit here. What the construction omits, a quadrature of the action, makes a Galerkin integrator symplectic on every system: KY21-e-1.",
    ),
    (
        "A general technique for any symplectic integrator and any dissipative system ([S24] Abstract, Sections 1 and 2)",
        "A statement on all integrators and systems cannot be run, only fall with single ones: Method II determines no step where the \
         matrix is singular, S24-c-4.",
    ),
    (
        "v̇ = f(t, v), Eq. (10), stands for arbitrary dynamical systems ([S24] Section 2)",
        "A statement on form. A system of higher order is written so with its velocities as unknowns; one with constraints is not.",
    ),
    (
        "The momentum of the least-squares Lagrangian is its residual, ∂L/∂v̇ = v̇ − f ([S24] Section 2)",
        "An identity, by which the discrete momenta are formed that every claim on Methods I and II is judged with.",
    ),
    (
        "Eq. (14) of [S24], v̈ = f_t + f_v f, for systems",
        "It is right for one unknown. The Euler–Lagrange equation of a system has (J − Jᵀ)v̇ + Jᵀf in place of f_v f, with J = f_v, and that is \
         what is run.",
    ),
    (
        "Eq. (26) of [S24] as it is printed",
        "It divides by α and by β, one of which is zero in Method I. Eq. (27), which follows from it, is right, and its factors are held against \
         live steps.",
    ),
];

fn unexamined() -> Section {
    Section {
        id: "claims-unexamined".into(),
        title: "What was not examined, and why".into(),
        paragraphs: UNEXAMINED.map(|(what, why)| (what.to_owned(), why.to_owned())).into(),
        ..Section::default()
    }
}

fn notes(judged: &[Judged]) -> Vec<String> {
    let counts = Verdict::ALL.iter().filter_map(|verdict| {
        let count = judged.iter().filter(|judged| judged.verdict() == Some(*verdict)).count();
        (count > 0).then(|| format!("{count} {}", verdict.word()))
    });
    let counts: Vec<_> = counts.collect();
    vec![format!(
        "The verdicts on {} claims: {}. A claim is a list of comparisons of live runs, and its quantifier decides what they \
             make of it. {RULE}",
        judged.len(),
        counts.join(", ")
    )]
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::claim::{Case, Finding};

    #[test]
    fn a_row_says_what_decided_the_verdict() {
        let claim =
            |quantifier| claim::all().into_iter().find(|claim| claim.quantifier == quantifier).expect("such a claim");
        let found = |quantifier, cases| {
            let finding = Finding::on(cases, "").holds_where("For x < 1.").beside("x", "≈ 1.5", 1.518);
            found(&Judged { claim: claim(quantifier), finding: Ok(Arc::new(finding)) })
        };
        let (yes, no) = (Case::below("y", 1.0, 2.0).under(true), Case::below("z", 3.0, 2.0));
        let universal = claim::Quantifier::Universal;
        let begun = ["overtakes RK4 at h: 1.", "v₁/v₀: 1.", "method-i: 1.", "x: 1."].map(|text| sentence(text.into()));
        assert_eq!(begun, ["Overtakes RK4 at h: 1.", "v₁/v₀: 1.", "method-i: 1.", "x: 1."]);
        assert_eq!(found(universal, vec![yes.clone()]), "x: printed ≈ 1.5, here 1.52. 1 of 1 comparisons hold.");
        let refuted = found(universal, vec![yes.clone(), no.clone()]);
        assert!(
            refuted.contains("Counterexample: z: 3") && refuted.ends_with("Where it holds: For x < 1."),
            "{refuted}"
        );
        let qualified = found(claim::Quantifier::General, vec![yes, no]);
        assert_eq!(
            qualified,
            "x: printed ≈ 1.5, here 1.52. It does not hold everywhere: z: 3, where < 2 is claimed. Where it holds: For x < 1."
        );
    }

    fn judged(quantifier: Quantifier, cases: Vec<Case>) -> Judged {
        let claim = claim::all().into_iter().find(|claim| claim.quantifier == quantifier).expect("such a claim");
        let finding = Finding::on(cases, "The answer is 42.").holds_where("For x < 1.");
        let finding = finding.beside("x", "0.3", 0.324).beside("y", "2", 2.04);
        Judged { claim, finding: Ok(Arc::new(finding)) }
    }

    #[test]
    fn the_table_of_cases_has_each_bound_on_its_side_and_says_which_holds() {
        let of = vec![Case::below("a", 1.0, 2.0), Case::above("b", 1.0, 2.0), Case::between("c", 1.0, 0.5, 2.0)];
        let table = cases(&[judged(Quantifier::Universal, of)]);
        let shown: Vec<_> = table.rows.iter().map(|row| (&row[3], &row[4], &row[5])).collect();
        let (empty, two, half) = (&Cell::Empty, &Cell::Number(2.0), &Cell::Number(0.5));
        let [yes, no] = [&text("yes"), &text("no")];
        assert_eq!(shown, [(empty, two, yes), (two, empty, no), (half, two, yes)]);
        let without = [f64::NAN, f64::INFINITY].map(|measured| Case::below("a", measured, 2.0));
        let table = cases(&[judged(Quantifier::Universal, without.into())]);
        let shown: Vec<_> = table.rows.iter().map(|row| &row[5]).collect();
        assert_eq!(shown, [&text("not decided: the run broke off"), &text("no: without a solution")]);
    }

    #[test]
    fn the_rule_of_verdicts_has_the_same_words_everywhere() {
        let architecture = include_str!("../../../ARCHITECTURE.md").split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(architecture.contains(RULE), "{RULE}");
        assert!(notes(&[])[0].ends_with(RULE));
    }

    #[test]
    fn every_part_of_the_chapter_tells_the_verdict_that_was_reached() {
        let (yes, no) = (Case::below("y", 1.0, 2.0), Case::below("z", 3.0, 2.0));
        let refuted = judged(Quantifier::Universal, vec![yes.clone(), no.clone()]);
        let confirmed = judged(Quantifier::General, vec![yes.clone()]);
        let qualified = judged(Quantifier::General, vec![yes.clone().under(true), no.clone()]);
        let mixed = judged(Quantifier::Comparison, vec![yes.clone(), no.clone()]);
        let unbeaten =
            judged(Quantifier::Comparison, vec![yes.clone().against("a"), no.clone().against("b"), no.against("b")]);
        let answered = judged(Quantifier::Open, vec![yes]);
        let labels = |judged: &Judged| -> Vec<String> {
            section(judged).paragraphs.into_iter().map(|(label, _)| label).collect()
        };
        assert!(labels(&refuted).contains(&"Counterexample".to_owned()));
        assert!(!labels(&confirmed).contains(&"Counterexample".to_owned()));
        assert!(labels(&qualified).contains(&"Where it does not hold".to_owned()));
        // What is said of where it holds has the name that suits the verdict, in the table and below it.
        for (judged, label) in [(&refuted, "Where it holds"), (&mixed, "What is left of it"), (&answered, "For what")] {
            assert!(labels(judged).contains(&label.to_owned()));
            assert!(found(judged).ends_with(&format!("{label}: For x < 1.")), "{}", found(judged));
        }
        assert!(found(&answered).contains("The answer is 42."));
        // What refutes a comparison is a method that it is never ahead of.
        assert!(
            found(&unbeaten)
                .contains("It is ahead of each of these methods in no case: 0 of 2 against b. Counterexample: z: 3"),
            "{}",
            found(&unbeaten)
        );
        assert!(
            labels(&unbeaten).contains(&"What refutes it".to_owned())
                && !labels(&refuted).contains(&"What refutes it".to_owned())
        );
        // As many digits as the source has, two at least, and every number of it.
        assert!(found(&confirmed).contains("printed 0.3, here 0.32. y: printed 2, here 2.0."), "{}", found(&confirmed));
        let table = verdicts(&[refuted, confirmed, mixed, answered]);
        let words: Vec<_> = table.rows.iter().map(|row| (row[1].clone(), row[5].clone())).collect();
        let expected = [
            ("refuted as stated", "all cases"),
            ("confirmed", "cases left open"),
            ("not supported", "one method against others"),
            ("answered", "an open question"),
        ];
        assert_eq!(words, expected.map(|(verdict, of)| (text(verdict), text(of))));
    }

    #[test]
    fn verdicts_are_counted_and_a_claim_without_comparisons_is_not_decided() {
        let confirmed = || judged(Quantifier::Universal, vec![Case::below("y", 1.0, 2.0)]);
        let refuted = judged(Quantifier::Universal, vec![Case::below("y", 3.0, 2.0)]);
        let all = [confirmed(), refuted, confirmed()];
        assert!(notes(&all)[0].starts_with("The verdicts on 3 claims: 2 confirmed, 1 refuted as stated."));
        assert_eq!(check(&confirmed()).outcome, Outcome::Pass);
        assert_eq!(check(&judged(Quantifier::Universal, vec![])).outcome, Outcome::Fail);
        assert_eq!(check(&judged(Quantifier::Universal, vec![Case::below("y", f64::NAN, 2.0)])).outcome, Outcome::Fail);
    }
}
