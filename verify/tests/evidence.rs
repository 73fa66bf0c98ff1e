//! One test for every chapter of the report, every claim and every golden, by its name: `cargo test -p verify poiseuille`.
//!
//! They run in one process and share what they compute.

#[path = "evidence/answers.rs"]
mod answers;
#[path = "evidence/claims/mod.rs"]
mod claims;
#[path = "evidence/contents.rs"]
mod contents;
#[path = "evidence/curves.rs"]
mod curves;
#[path = "evidence/figures.rs"]
mod figures;
#[path = "evidence/flows.rs"]
mod flows;
#[path = "evidence/tables.rs"]
mod tables;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::{Arc, LazyLock};

use libtest_mimic::{Arguments, Failed, Trial};
use verify::chapter::{self, Study};
use verify::claim::{self, Claim, Quantifier, Verdict};
use verify::evidence::Outcome;
use verify::experiment::Context;
use verify::golden::{self, Action, Golden, NumericComparator};
use verify::report::{Chapter, Run};

/// What all tests share.
static CONTEXT: LazyLock<Arc<Context<'static>>> = LazyLock::new(|| Arc::new(Context::quick()));

fn main() {
    let chapters =
        chapter::ALL.iter().map(|study| Trial::test(format!("chapter::{}", study.id), || every_check_holds(study)));
    let claims = claim::all()
        .into_iter()
        .map(|claim| Trial::test(format!("claim::{}", claim.id), || it_is_decided_by_numbers_and_explained(claim)));
    let goldens = golden::all(&CONTEXT)
        .into_iter()
        .map(|golden| Trial::test(format!("golden::{}", golden.name), move || it_holds(&golden)));
    let strays = Trial::test("golden::none_is_left_over", none_is_left_over);
    let answers = Trial::test("answers::rest_on_their_tables", answers::rest_on_their_tables);
    let flows = Trial::test("flows::rest_on_their_tables", flows::rest_on_their_tables);
    let figures = Trial::test("figures::rest_on_their_tables", figures::rest_on_their_tables);
    let curves = Trial::test("curves::what_is_in_no_row_is_found", curves::what_is_in_no_row_is_found);
    let contents = Trial::test("contents::is_what_it_was", || contents::is_what_it_was(&CONTEXT));
    let trials =
        chapters.chain(claims).chain(goldens).chain([strays, answers, figures, flows, curves, contents]).collect();
    libtest_mimic::run(&Arguments::from_args(), trials).exit();
}

/// Whatever the chapter found holds, what it draws is in its tables, and what it says is fit to print.
fn every_check_holds(study: &Study) -> Result<(), Failed> {
    let evidence = (study.run)(&CONTEXT).map_err(|error| error.to_string())?;
    if evidence.checks.is_empty() {
        return Err("it decides nothing".into());
    }
    let strays = [
        curves::strays(&evidence),
        curves::blind(&evidence),
        curves::crowded(&evidence),
        curves::misquoted(&evidence),
        tables::contradictions(&evidence),
    ]
    .concat();
    if !strays.is_empty() {
        return Err(strays.join("\n").into());
    }
    let chapter = Chapter { id: study.id.into(), title: study.title.into(), evidence, ..Chapter::default() };
    // With the audit that the report makes of itself.
    let run = Run::new(vec![chapter], Vec::new());
    let undecided = run.checks_that(Outcome::Fail).chain(run.checks_that(Outcome::Inconclusive));
    let failures: Vec<_> = undecided
        .map(|(_, check)| {
            let measured = check.measured.map_or("nothing".into(), |value| value.to_string());
            let required = check.required_text();
            format!("{}: {:?}: measured {measured}, required {required}. {}", check.id, check.outcome, check.reason)
        })
        .collect();
    if failures.is_empty() { Ok(()) } else { Err(failures.join("\n").into()) }
}

fn it_is_decided_by_numbers_and_explained(claim: &'static Claim) -> Result<(), Failed> {
    let judged = claim::decide(&CONTEXT, claim);
    let finding = judged.finding.as_ref().map_err(ToString::to_string)?;
    let require = |holds: bool, what: String| if holds { Ok(()) } else { Err(Failed::from(what)) };
    require(finding.is_sound(), format!("a comparison without a number: {:?}", finding.cases()))?;
    let evidence = &finding.evidence;
    require(evidence.ends_with('.') && evidence.contains(char::is_numeric), format!("no number in “{evidence}”"))?;
    let is_question = claim.statement.ends_with('?');
    require(
        is_question == (claim.quantifier == Quantifier::Open),
        format!("{:?} does not suit “{}”", claim.quantifier, claim.statement),
    )?;
    let is_explained = finding.where_it_holds.is_some() && finding.mechanism.is_some();
    require(
        is_explained || matches!(judged.verdict(), Some(Verdict::Confirmed | Verdict::Answered | Verdict::Open)),
        "it does not say where it holds and why".into(),
    )?;
    let mut cases: Vec<_> = finding.cases().iter().map(|case| &case.what).collect();
    cases.sort();
    let count = cases.len();
    cases.dedup();
    require(cases.len() == count, "two comparisons have the same name".into())?;
    claims::says_what_was_found(claim, finding)
}

/// As `verify golden diff --only NAME` has it. Where it does not, insta leaves what was computed for `cargo insta review`.
fn it_holds(golden: &Golden) -> Result<(), Failed> {
    let dir = golden::find_dir(Path::new(env!("CARGO_MANIFEST_DIR")))?;
    let rows = golden.rows().map_err(|error| error.to_string())?;
    let csv = golden::render(&rows);
    let computed = [Golden::new(golden.name.clone(), move || Ok(rows.clone()))];
    let mut printed = Vec::new();
    let holds = golden::run(Action::Diff, &dir, &computed, Some(&golden.name), &mut printed)?;
    let agrees = catch_unwind(AssertUnwindSafe(|| {
        let mut settings = insta::Settings::clone_current();
        settings.set_snapshot_path(&dir);
        settings.set_prepend_module_to_snapshot(false);
        settings.set_omit_expression(true);
        settings.set_comparator(Box::new(NumericComparator));
        settings.bind(|| insta::assert_binary_snapshot!(&format!("{}.csv", golden.name), csv.into_bytes()));
    }));
    if holds && agrees.is_ok() { Ok(()) } else { Err(String::from_utf8_lossy(&printed).into_owned().into()) }
}

fn none_is_left_over() -> Result<(), Failed> {
    let dir = golden::find_dir(Path::new(env!("CARGO_MANIFEST_DIR")))?;
    let strays = golden::strays(&dir, &golden::all(&CONTEXT))?;
    if strays.is_empty() { Ok(()) } else { Err(format!("no golden produces {strays:?}").into()) }
}
