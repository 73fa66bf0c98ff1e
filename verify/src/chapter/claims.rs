//! The claims of the papers and their verdicts, the first chapter of the report.

use std::collections::HashMap;
use std::path::Path;

use super::{Context, Study, StudyError};
use crate::claim::{self, Claim, Finding, Judged, Required, Verdict};
use crate::evidence::{Cell, Check, Evidence, Outcome, Section, Table};
use crate::golden::{self, Value};

pub(super) const STUDY: Study = Study {
    id: "claims",
    title: "The claims of the papers",
    question: "What the two papers claim: does it hold, by how much, and why?",
    source: "[S24], [KY21]",
    run,
};

fn run(context: &Context) -> Result<Evidence, StudyError> {
    (context.announce)(claim::all().len() as u64);
    let judged = claim::judge(context.tick);
    let recorded = recorded();
    let mut evidence = Evidence {
        checks: judged.iter().map(|judged| check(judged, recorded.as_ref())).collect(),
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

/// The verdicts of the golden file; `None` where the program runs outside of the repository.
fn recorded() -> Option<Result<HashMap<String, String>, String>> {
    let dir = golden::find_dir(Path::new(".").canonicalize().ok()?.as_path()).ok()?;
    let file = dir.join("claims.snap.csv");
    let bytes = std::fs::read(&file).map_err(|error| format!("{}: {error}", file.display()));
    Some(bytes.and_then(|bytes| {
        let rows = golden::parse(&bytes).map_err(|error| error.to_string())?;
        let verdict = |recorded: golden::Recorded| match recorded.row.value {
            Value::Text(verdict) => Some((recorded.row.key, verdict)),
            Value::Number(_) => None,
        };
        Ok(rows.into_iter().filter_map(verdict).collect())
    }))
}

fn check((claim, finding): &Judged, recorded: Option<&Result<HashMap<String, String>, String>>) -> Check {
    let found = finding.as_ref().map(|finding| format!("{}, {}", finding.verdict().word(), finding.score()));
    let old = match recorded {
        Some(Ok(rows)) => {
            let of = |key: &str| rows.get(key).map_or("nothing", String::as_str);
            Ok(format!("{}, {}", of(claim.id), of(&claim::comparisons(claim))))
        }
        Some(Err(error)) => Err((Outcome::Fail, error.clone())),
        None => Err((Outcome::NotRun, "the recorded verdicts are in the repository, and this is not run there".into())),
    };
    let (outcome, reason) = match (&found, &old) {
        (Err(error), _) => (Outcome::Fail, (*error).clone()),
        (Ok(_), _) if finding.as_ref().is_ok_and(|finding| !finding.is_sound()) => {
            (Outcome::Fail, "a measured number is `NaN`".into())
        }
        (Ok(_), Err((outcome, reason))) => (*outcome, reason.clone()),
        (Ok(found), Ok(old)) => {
            let outcome = if found == old { Outcome::Pass } else { Outcome::Fail };
            (outcome, format!("{found} comparisons come out as claimed"))
        }
    };
    Check {
        id: claim.id.into(),
        statement: format!("{}: verdict and comparisons are the recorded ones", claim.id),
        outcome,
        measured: None,
        required: old.unwrap_or_default(),
        reason,
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
                Required::Below(high) => (Cell::Empty, Cell::Number(high)),
                Required::Above(low) => (Cell::Number(low), Cell::Empty),
                Required::Between(low, high) => (Cell::Number(low), Cell::Number(high)),
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
