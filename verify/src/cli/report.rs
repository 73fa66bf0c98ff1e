//! `report`: every study, one report.

use std::any::Any;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};
use verify::chapter::{self, Context, Study, StudyError};
use verify::evidence::Evidence;
use verify::experiment::flow::PROJECTION;
use verify::experiment::side_by_side;
use verify::names::NameError;
use verify::problem::model::Model;
use verify::report::{self, Chapter, Counts, Earlier, Part, Run, Shard};
use verify::{method, reference};

use super::Status;
use super::args::assignment;
use super::error::Failure;
use super::output::Output;

/// Run every study but those that take minutes, and write the report.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Writes index.html (one self-contained file), report.md, results.json, junit.xml
and data/*.csv, and ends with a summary. A study that breaks off is reported as
such; the others still run. The schema of results.json is described in
verify/doc/results.md.

With --compare, the summary and report.md list what changed: checks that are
new, gone, or have another outcome, values that moved by more than a tenth of
what is allowed, and verdicts on claims.

With --shard, each of N machines runs a part of the studies and writes it to
--out; --merge joins the parts, all by one build, into the report that one
machine would have made. verify/examples/job-array.sh is an array job.

Examples:
  verify report
  verify report --brief                     the answers and the claims alone
  verify report --out /tmp/report --only orders
  verify report --compare main/results.json
  verify report --model van-der-pol.ds --set mu=2 --t-end 5
  verify report --model van-der-pol.ds --only model
  verify report --shard 2/4 --out parts

Exit status: 0 no check failed and none is inconclusive, 1 a check failed or a
study broke off, 2 bad usage or a directory that cannot be written to, 3 no
check failed, but the data do not decide all of them.")]
pub(super) struct Args {
    /// Directory to write to
    #[arg(long, value_name = "DIR", default_value = "target/report")]
    out: PathBuf,

    /// Add a chapter on your own system, in DiffSL
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,

    /// Set an input of the model; repeatable
    #[arg(long, value_name = "NAME=VALUE", value_parser = assignment, requires = "model", allow_hyphen_values = true)]
    set: Vec<(String, String)>,

    /// End time of the chapter on the model
    #[arg(long, value_name = "T", requires = "model", allow_hyphen_values = true)]
    t_end: Option<f64>,

    /// Show what changed since an earlier results.json
    #[arg(long, value_name = "OLD.json")]
    compare: Option<PathBuf>,

    /// Run what takes minutes: flows on the grids of the literature
    #[arg(long, conflicts_with = "brief")]
    full: bool,

    /// Run this study alone: `verify list studies`, `model`
    #[arg(long, value_name = "STUDY")]
    only: Vec<String>,

    /// Run the K-th of N parts of the studies only
    #[arg(long, value_name = "K/N", conflicts_with_all = ["model", "compare"])]
    shard: Option<Shard>,

    /// Join the parts in these directories, run nothing
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with_all = ["shard", "model", "full", "only", "brief"])]
    merge: Vec<PathBuf>,

    /// The first page alone: answers and claims
    #[arg(long, conflicts_with = "only")]
    brief: bool,
}

/// The studies of the first page.
const BRIEF: [&str; 2] = ["answers", "claims"];

/// The studies that are asked for by name.
fn asked(args: &Args) -> Vec<String> {
    if args.brief { BRIEF.map(str::to_owned).to_vec() } else { args.only.clone() }
}

pub(super) fn run(args: &Args, out: &mut Output) -> Result<Status, Failure> {
    if !args.merge.is_empty() {
        return join(args, out);
    }
    let studies = selected(&asked(args), args.model.is_some(), args.full)?;
    if let Some(shard) = args.shard {
        return run_part(args, shard, &studies, out);
    }
    // Before the studies, so that a mistake in the file does not cost their time.
    let model = args.model.as_ref().map(|path| Model::load(path, &args.set, args.t_end)).transpose()?;
    // It may be the very file that this run is going to replace.
    let earlier = args.compare.as_ref().map(|path| Earlier::read(path)).transpose()?;
    // And a report that cannot be written does not cost it either.
    report::prepare(&args.out)?;
    finish(args, chapters(&studies, model.as_ref()), provenance(), earlier.as_ref(), out)
}

/// Runs a part of the studies and writes it.
fn run_part(args: &Args, shard: Shard, studies: &[Study], out: &mut Output) -> Result<Status, Failure> {
    report::prepare(&args.out)?;
    let own: Vec<Study> = studies.iter().enumerate().filter(|(place, _)| shard.has(*place)).map(|(_, s)| *s).collect();
    let part = Part {
        shard,
        studies: studies.iter().map(|study| study.id.to_owned()).collect(),
        provenance: provenance(),
        chapters: chapters(&own, None),
    };
    let path = part.write(&args.out)?;
    writeln!(out, "{} of {} studies are in {}", own.len(), studies.len(), path.display()).map_err(Failure::Output)?;
    Ok(Status::Ok)
}

/// Joins parts into a report.
fn join(args: &Args, out: &mut Output) -> Result<Status, Failure> {
    let mut parts = Vec::new();
    for directory in &args.merge {
        parts.extend(Part::read_all(directory)?);
    }
    let (chapters, provenance) = report::merge(parts)?;
    let earlier = args.compare.as_ref().map(|path| Earlier::read(path)).transpose()?;
    report::prepare(&args.out)?;
    finish(args, chapters, provenance, earlier.as_ref(), out)
}

/// Writes the report of these chapters.
fn finish(
    args: &Args,
    chapters: Vec<Chapter>,
    provenance: Vec<(String, String)>,
    earlier: Option<&Earlier>,
    out: &mut Output,
) -> Result<Status, Failure> {
    let run = Run::new(chapters, provenance).with_palette(palette());
    let run = match earlier {
        Some(earlier) => run.compared_with(earlier),
        None => run,
    };
    report::write(&run, &args.out)?;
    let summary = report::summary(&run, report::wants_color());
    write!(out, "{summary}").map_err(Failure::Output)?;
    writeln!(out, "The report is in {}", args.out.join("index.html").display()).map_err(Failure::Output)?;
    Ok(status(&run))
}

fn status(run: &Run) -> Status {
    match run.counts() {
        counts if !counts.is_ok() => Status::Failed,
        Counts { inconclusive: 1.., .. } => Status::Inconclusive,
        _ => Status::Ok,
    }
}

/// Those that the first page compares have a colour each.
const FIRST: [&str; 8] = [
    "method-i",
    "trapezoidal",
    "tr-bdf2",
    "sdirk2",
    "ls-galerkin(2,radau,2)",
    "path-fitted(4)",
    "path-fitted(4,gauss)",
    "galerkin-gauss(3)",
];

/// Those of the first page, then methods, each example apart, and references in the order of their registries, which decides their colours.
fn palette() -> Vec<String> {
    let examples = method::examples().into_iter().map(|method| method.name());
    let first = FIRST.map(str::to_owned).into_iter();
    let mut methods: Vec<String> =
        first.chain(examples).chain(method::ALL.iter().map(|spec| spec.name().to_owned())).collect();
    let mut seen = std::collections::HashSet::new();
    methods.retain(|name| seen.insert(name.clone()));
    let others = reference::all().into_iter().map(|reference| reference.name()).chain([PROJECTION]);
    methods.into_iter().chain(others.map(str::to_owned)).collect()
}

/// The studies of these names in the order of the report; if there are none all of them, those that take minutes if `full`.
/// The chapter on a model has a name of its own.
fn selected(names: &[String], has_model: bool, full: bool) -> Result<Vec<Study>, NameError> {
    let model = has_model.then_some(chapter::model::ID);
    let known = || chapter::ALL.iter().chain(chapter::LONG.iter().map(|(_, long)| long));
    let ids = || known().map(|study| study.id).chain(model);
    if let Some(name) = names.iter().find(|name| ids().all(|id| id != *name)) {
        return Err(NameError::unknown("study", name, ids()));
    }
    let meant = |name: &str| chapter::LONG.iter().find(|(short, _)| full && *short == name).map(|(_, long)| long.id);
    let is_named = |study: &Study| names.iter().any(|name| meant(name).unwrap_or(name) == study.id);
    let is_long = |study: &Study| chapter::LONG.iter().any(|(_, long)| long.id == study.id);
    // A long study has the names of tables and checks of the one that it takes the place of.
    let is_replaced = |study: &Study| {
        let mut of = chapter::LONG.iter().filter(|(short, _)| *short == study.id);
        of.any(|(_, long)| full || is_named(long))
    };
    let is_selected = |study: &&Study| match names {
        [] => full && is_long(study) || !is_long(study) && !is_replaced(study),
        _ => is_named(study) && !is_replaced(study),
    };
    Ok(known().filter(is_selected).copied().collect())
}

/// Runs the studies side by side, with their progress on a terminal.
fn chapters(studies: &[Study], model: Option<&Model>) -> Vec<Chapter> {
    // Hidden where standard error is no terminal.
    let bar = ProgressBar::new(0);
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos}/{len} {elapsed}") {
        bar.set_style(style);
    }
    let (announce, tick) = (|count| bar.inc_length(count), || bar.inc(1));
    let context = Context::new(&announce, &tick, u64::MAX);
    let mut chapters = side_by_side(studies.iter().collect(), |study| chapter(study, &context));
    // First comes what the reader asked for.
    chapters.splice(0..0, model.map(|model| model_chapter(model, &context)));
    bar.finish_and_clear();
    chapters
}

fn chapter(study: &Study, context: &Context) -> Chapter {
    let start = Instant::now();
    let (evidence, error) = unless_it_breaks_off(|| (study.run)(context));
    Chapter {
        id: study.id.into(),
        title: study.title.into(),
        question: study.question.into(),
        source: study.source.into(),
        evidence,
        error,
        seconds: start.elapsed().as_secs_f64(),
    }
}

fn model_chapter(model: &Model, context: &Context) -> Chapter {
    let start = Instant::now();
    let (evidence, error) = unless_it_breaks_off(|| chapter::model::examine(model, context));
    Chapter {
        id: chapter::model::ID.into(),
        title: format!("The model {}", model.name()),
        question: chapter::model::QUESTION.into(),
        source: "a model file in DiffSL".into(),
        evidence,
        error,
        seconds: start.elapsed().as_secs_f64(),
    }
}

/// What a study found, or why it broke off: one broken study must not take the others with it.
fn unless_it_breaks_off(run: impl FnOnce() -> Result<Evidence, StudyError>) -> (Evidence, Option<String>) {
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(evidence)) => (evidence, None),
        Ok(Err(error)) => (Evidence::default(), Some(error.to_string())),
        Err(payload) => (Evidence::default(), Some(format!("it panicked: {}", panic_message(&*payload)))),
    }
}

fn panic_message(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    text.or(payload.downcast_ref::<&str>().copied()).unwrap_or("no message")
}

/// What the numbers were computed with.
fn provenance() -> Vec<(String, String)> {
    let library = |name| reference::by_name(name).and_then(|reference| reference.library());
    [
        ("verify", env!("CARGO_PKG_VERSION").to_owned()),
        ("commit", env!("VERIFY_COMMIT").to_owned()),
        ("date", env!("VERIFY_DATE").to_owned()),
        ("compiler", env!("VERIFY_RUSTC").to_owned()),
        ("target", env!("VERIFY_TARGET").to_owned()),
        ("profile", env!("VERIFY_PROFILE").to_owned()),
        ("CVODE", library("cvode-bdf").unwrap_or_else(|| "not compiled in (feature `cvode`)".into())),
        ("diffsol", library("diffsol-bdf").unwrap_or_else(|| "not compiled in".into())),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .into()
}

#[cfg(test)]
mod tests {
    use verify::evidence::{Check, Outcome};

    use super::*;

    #[derive(clap::Parser)]
    struct Line {
        #[command(flatten)]
        args: Args,
    }

    /// A colour is that of a name, wherever it is drawn.
    #[test]
    fn the_palette_names_everything_once_and_the_first_page_first() {
        let palette = palette();
        assert_eq!(palette[..FIRST.len()], FIRST);
        let distinct: std::collections::HashSet<_> = palette.iter().collect();
        assert_eq!(distinct.len(), palette.len());
        assert!(method::ALL.iter().all(|spec| palette.iter().any(|name| name == spec.name())));
        assert!(reference::all().into_iter().all(|reference| palette.iter().any(|name| name == reference.name())));
    }

    #[test]
    fn a_brief_report_has_the_answers_and_the_claims_and_nothing_else() {
        let titles = |arguments: &[&str]| {
            let Line { args } = clap::Parser::parse_from([&["report"], arguments].concat());
            let studies = selected(&asked(&args), false, args.full).expect("they are known");
            studies.iter().map(|study| study.title).collect::<Vec<_>>()
        };
        assert_eq!(titles(&["--brief"]), ["In short", "The claims of the papers"]);
        assert_eq!(titles(&["--only", "orders"]), ["Orders of accuracy"]);
        assert_eq!(titles(&[]).len(), chapter::ALL.len());
        // A long study takes the place of the short one, with all the others or by itself.
        let (short, long) = ("Two-dimensional flows", "Two-dimensional flows on fine grids");
        let full = titles(&["--full"]);
        assert!(full.len() == chapter::ALL.len() && full.contains(&long) && !full.contains(&short));
        assert_eq!(titles(&["--only", "flows", "--only", "flows-full"]), [long]);
        assert_eq!([titles(&["--only", "flows"]), titles(&["--only", "flows", "--full"])], [[short], [long]]);
    }

    #[test]
    fn the_libraries_behind_the_numbers_are_told_by_their_names() {
        let found = provenance();
        let value = |name: &str| found.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str());
        assert!(
            value("CVODE").is_some_and(|x| x.starts_with("SUNDIALS") || x.contains("not compiled in")),
            "{found:?}"
        );
        assert!(value("diffsol").is_some_and(|x| x.starts_with("diffsol ")), "{found:?}");
    }

    #[test]
    fn a_study_that_breaks_off_leaves_the_others_alone() {
        let study = |id, run| Study { id, title: "", question: "", source: "", run };
        let studies = [
            study("fails", |_| Err("no luck".into())),
            study("panics", |_| panic!("index {} out of range", 7)),
            study("works", |context| {
                context.announce(1);
                context.tick();
                Ok(Evidence { notes: vec!["found".into()], ..Evidence::default() })
            }),
        ];
        let chapters = chapters(&studies, None);
        let errors: Vec<_> = chapters.iter().map(|chapter| chapter.error.as_deref()).collect();
        assert_eq!(errors, [Some("no luck"), Some("it panicked: index 7 out of range"), None]);
        assert_eq!(chapters[2].evidence.notes, ["found"]);
        let mut works = chapters[2].clone();
        assert_eq!(status(&Run::new(vec![works.clone()], vec![])), Status::Ok);
        works.evidence.checks.push(Check::undecided("a", "b", Outcome::Inconclusive, "c"));
        assert_eq!(status(&Run::new(vec![works.clone()], vec![])), Status::Inconclusive);
        works.evidence.checks.push(Check::undecided("d", "e", Outcome::Fail, "f"));
        assert_eq!(status(&Run::new(vec![works], vec![])), Status::Failed);
        assert_eq!(status(&Run::new(chapters, vec![])), Status::Failed);
    }

    #[test]
    fn provenance_is_known() {
        for (name, value) in provenance() {
            let may_be_unknown = ["commit", "date"].contains(&name.as_str());
            assert!(!value.is_empty() && (may_be_unknown || value != "unknown"), "{name}: {value}");
            match name.as_str() {
                "verify" => assert_eq!(value, env!("CARGO_PKG_VERSION")),
                "compiler" => assert!(value.starts_with("rustc 1."), "{value}"),
                "target" => assert!(value.starts_with(std::env::consts::ARCH) && value.contains('-'), "{value}"),
                "profile" => assert!(["debug", "release"].contains(&value.as_str()), "{value}"),
                _ => {}
            }
        }
    }
}
