//! The claims of the papers and their verdicts, the first chapter of the report.

use super::{Context, Study, StudyError};
use crate::claim::{self, Claim, Finding, Judged, Verdict};
use crate::evidence::{Cell, Check, Evidence, Outcome, Requirement, Section, Table};

pub(super) const STUDY: Study = Study {
    id: "claims",
    title: "The claims of the papers",
    question: "What the two papers claim: does it hold, by how much, and why?",
    source: "[S24], [KY21]",
    run,
};

fn run(context: &Context) -> Result<Evidence, StudyError> {
    (context.announce)(claim::all().len() as u64);
    let judged = &claim::judge(context.tick);
    let mut evidence = Evidence {
        checks: judged.iter().map(check).collect(),
        tables: vec![verdicts(judged), cases(judged)],
        notes: notes(judged),
        sections: judged.iter().map(section).collect(),
        ..Evidence::default()
    };
    for (_, finding) in judged {
        let Ok(finding) = finding else { continue };
        evidence.tables.extend(finding.tables.iter().cloned());
        evidence.figures.extend(finding.figures.iter().cloned());
    }
    Ok(evidence)
}

/// That a claim could be decided, whatever the verdict: the recorded verdicts are held by the goldens.
fn check((claim, finding): &Judged) -> Check {
    match finding {
        Ok(finding) => Check::at_most(
            claim.id,
            format!(
                "{} is decided, with the verdict {}: comparisons without a number",
                claim.id,
                finding.verdict().word()
            ),
            finding.unsound() as f64,
            0.0,
            format!("{} comparisons come out as claimed", finding.score()),
        ),
        Err(error) => Check::undecided(claim.id, format!("{} is decided", claim.id), Outcome::Fail, error),
    }
}

fn text(text: &str) -> Cell {
    Cell::Text(text.into())
}

fn verdicts(judged: &[Judged]) -> Table {
    let row = |(claim, finding): &Judged| {
        let (verdict, evidence) = match finding {
            Ok(finding) => (finding.verdict(), finding.evidence.clone()),
            Err(error) => (Verdict::Open, format!("The computation broke off: {error}.")),
        };
        vec![text(claim.id), text(claim.source), text(claim.statement), text(verdict.word()), Cell::Text(evidence)]
    };
    Table {
        id: "claims".into(),
        caption: "Every claim with its verdict and the numbers behind it; the identifiers lead to the details.".into(),
        columns: ["id", "source", "statement", "verdict", "evidence"].map(Into::into).to_vec(),
        rows: judged.iter().map(row).collect(),
        shown: true,
    }
}

fn cases(judged: &[Judged]) -> Table {
    let mut rows = Vec::new();
    for (claim, finding) in judged {
        for case in finding.iter().flat_map(Finding::cases) {
            let (low, high) = match case.required {
                Requirement::AtMost(high) | Requirement::Below(high) => (Cell::Empty, Cell::Number(high)),
                Requirement::AtLeast(low) | Requirement::Above(low) => (Cell::Number(low), Cell::Empty),
                Requirement::Within(low, high) => (Cell::Number(low), Cell::Number(high)),
                Requirement::Near(value, band) => (Cell::Number(value - band), Cell::Number(value + band)),
            };
            let holds = if case.holds() { "yes" } else { "no" };
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

fn section((claim, finding): &Judged) -> Section {
    let Claim { id, source, statement, criterion, .. } = claim;
    let mut paragraphs = vec![("Source", (*source).to_owned()), ("Criterion", (*criterion).to_owned())];
    let mut section = Section { id: (*id).into(), title: (*statement).into(), ..Section::default() };
    match finding {
        Ok(finding) => {
            section.mark = finding.verdict().word().into();
            paragraphs.push(("Evidence", format!("{} {} comparisons hold.", finding.evidence, finding.score())));
            paragraphs.extend(finding.where_it_holds.clone().map(|text| ("Where it holds", text)));
            paragraphs.extend(finding.mechanism.clone().map(|text| ("Why", text)));
            section.figures = finding.figures.iter().map(|figure| figure.id.clone()).collect();
            section.tables = finding.tables.iter().map(|table| table.id.clone()).collect();
        }
        Err(error) => paragraphs.push(("Broke off", error.clone())),
    }
    section.paragraphs = paragraphs.into_iter().map(|(label, text)| (label.to_owned(), text)).collect();
    section
}

fn notes(judged: &[Judged]) -> Vec<String> {
    let of = |verdict: Verdict| {
        judged.iter().filter(|(_, finding)| finding.as_ref().is_ok_and(|f| f.verdict() == verdict)).count()
    };
    vec![
        format!(
            "Of {} claims {} are confirmed, {} hold with qualifications, {} are refuted; of the open questions {} are answered \
             and {} still open. A claim is a list of comparisons of live runs: it is confirmed if all come out as claimed, refuted \
             if none does, qualified otherwise.",
            judged.len(),
            of(Verdict::Confirmed),
            of(Verdict::Qualified),
            of(Verdict::Refuted),
            of(Verdict::Answered),
            of(Verdict::Open)
        ),
        "Should you use Method I for a stiff parabolic problem? It is stable and damps what is stiff (`S24-b-1`, `S24-b-2`), and \
         at equal step size it has about twice the error of the trapezoidal rule, which does not damp, and at equal work that of \
         SDIRK2, which does (`S24-n-1`). Its lead on Poiseuille flow comes from the projection, not from time integration (`S24-j`). On strongly \
         nonlinear or non-normal problems neither it nor Method II is unconditionally stable (`S24-b-1`, `S24-h-1`, `S24-h-2`)."
            .into(),
        "Should you use the path-fitted integrator with three interior points, degree 4 on equispaced nodes? It is of order 4, \
         not symplectic, and momentum maps drift (`KY21-c-2`, `KY21-e-1`, `KY21-e-2`); on Gauss nodes it is of order 6 at the same \
         cost, and symplectic where the mass is constant. A Galerkin integrator is symplectic everywhere. The printed scheme for \
         constraints diverges (`KY21-h-1`); with multipliers at the nodes it works (`KY21-h-2`)."
            .into(),
    ]
}
