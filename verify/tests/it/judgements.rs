//! What is said of every shipped method file, word for word.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use rayon::prelude::*;
use verify::evidence::{Cell, Evidence, Figure, Table};
use verify::judge::file::MethodFile;
use verify::judge::{Effort, Judgement};

/// The files in a folder of `verify/methods`, by name.
fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("methods").join(folder);
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("readable").path());
    let mut files: Vec<PathBuf> = entries.filter(|path| path.is_file()).collect();
    files.sort();
    files
}

/// What is made of each file, by its name and its text.
fn each<T: Send>(files: &[PathBuf], make: impl Fn(&str, &str) -> T + Sync) -> Vec<T> {
    let made = files.par_iter().map(|path| {
        let name = path.file_stem().expect("a name").to_string_lossy();
        make(&name, &std::fs::read_to_string(path).expect("readable"))
    });
    made.collect()
}

/// The name of every right file, and what is judged of it with runs.
pub(crate) static RUN: LazyLock<Vec<(String, Judgement)>> =
    LazyLock::new(|| each(&files(""), |name, text| (name.to_owned(), judge(name, text, Effort::Runs))));

/// The name of every right file, and where it claims an order what is judged of it with a label that is wrong by one.
pub(crate) static WRONG: LazyLock<Vec<(String, Vec<Judgement>)>> = LazyLock::new(|| {
    each(&files(""), |name, text| {
        let claimed = text.lines().find_map(|line| line.strip_prefix("order = ")?.trim().parse::<u32>().ok());
        let wrong = claimed.into_iter().flat_map(|order| {
            [order - 1, order + 1]
                .map(|wrong| text.replacen(&format!("order = {order}"), &format!("order = {wrong}"), 1))
        });
        let read = wrong.filter_map(|text| MethodFile::parse("test.toml", name, &text).ok());
        (name.to_owned(), read.map(|file| Judgement::new(file, Effort::Theory)).collect())
    })
});

fn judge(name: &str, text: &str, effort: Effort) -> Judgement {
    Judgement::new(MethodFile::parse("test.toml", name, text).expect("well-formed"), effort)
}

/// A sum in digits that roundings do not reach.
fn rough(numbers: impl Iterator<Item = f64>) -> String {
    let sum: f64 = numbers.filter(|x| x.is_finite()).sum();
    format!("{:.4e}", if sum.abs() < 1e-9 { 0.0 } else { sum })
}

/// A table by its head, its size, its texts' length and the sum of its numbers.
fn table(table: &Table) -> String {
    let cells = || table.rows.iter().flatten();
    let numbers = cells().filter_map(|cell| match cell {
        Cell::Number(x) => Some(*x),
        Cell::Integer(x) => Some(*x as f64),
        _ => None,
    });
    let letters =
        cells().filter_map(|cell| if let Cell::Text(text) = cell { Some(text.chars().count()) } else { None });
    let head = table.columns.iter().map(String::as_str).collect::<Vec<_>>().join(" | ");
    let (rows, letters) = (table.rows.len(), letters.sum::<usize>());
    format!("table {}: {head}: {rows} rows, {letters} letters, {}", table.id, rough(numbers))
}

/// A figure by its curves, with how many points each has and their sums, and by how much of a map lies below the level.
fn figure(figure: &Figure) -> String {
    let mut text = format!("figure {} on {}:", figure.id, figure.data);
    for panel in &figure.panels {
        for series in &panel.series {
            let (x, y) = (series.points.iter().map(|p| p.0), series.points.iter().map(|p| p.1));
            let _ = write!(text, " {} {} {} {};", series.label, series.points.len(), rough(x), rough(y));
        }
        if let Some(field) = &panel.field {
            let below = field.values.iter().flatten().filter(|value| **value <= field.levels[0]).count();
            let ends = [field.x[0], field.x[field.x.len() - 1], field.y[0], field.y[field.y.len() - 1]];
            let _ = write!(text, " {below} of {} points of {ends:?}", field.x.len() * field.y.len());
        }
    }
    text
}

fn evidence(evidence: &Evidence) -> String {
    let notes = evidence.notes.iter().map(|note| format!("note {note}"));
    let lines = notes.chain(evidence.tables.iter().map(table)).chain(evidence.figures.iter().map(figure));
    lines.map(|line| format!("  {line}\n")).collect()
}

/// What the coefficients say, of right files and of published misprints.
#[test]
fn theory() {
    let told = each(&[files(""), files("misprints")].concat(), |name, text| {
        let judgement = judge(name, text, Effort::Theory);
        let mut told = format!("{name}: {}\n", judgement.headline());
        let _ = writeln!(told, "  unknowns of a step: {} a component", judgement.theory.unknowns());
        for (label, text) in judgement.facts() {
            let _ = writeln!(told, "  {label}: {text}");
        }
        for verdict in &judgement.verdicts {
            let _ = writeln!(told, "  {:?} {}: {}", verdict.check.outcome, verdict.subject, verdict.check.reason);
        }
        told + &evidence(&judgement.evidence())
    });
    insta::assert_snapshot!(told.concat());
}

/// What is said where the file claims an order more, or less, than its method has.
#[test]
fn wrong_labels() {
    let told = WRONG.iter().map(|(name, judgements)| {
        if judgements.is_empty() {
            return format!("{name}: no order\n");
        }
        let mut told = format!("{name}:\n");
        for judgement in judgements {
            let (order, diagnosis) = (judgement.file.order(), judgement.diagnosis_text().unwrap_or_default());
            let order = order.expect("a label");
            let _ = writeln!(told, "  order = {order}: {:?}: {diagnosis}", judgement.outcome());
            judgement.changes().iter().for_each(|change| told.push_str(&format!("    change {change}\n")));
        }
        told
    });
    insta::assert_snapshot!(told.collect::<String>());
}

/// What runs add, without the numbers that they measure.
#[test]
fn runs() {
    let told = RUN.iter().map(|(name, judgement)| {
        let mut told = format!("{name}:\n");
        for verdict in &judgement.verdicts {
            let _ = writeln!(told, "  {:?} {}", verdict.check.outcome, verdict.subject);
        }
        let labels: Vec<&str> = judgement.facts().iter().map(|(label, _)| *label).collect();
        let _ = writeln!(told, "  {}", labels.join(", "));
        let evidence = judgement.evidence();
        for table in &evidence.tables {
            let _ = writeln!(told, "  table {}: {}, {} rows", table.id, table.columns.join(" | "), table.rows.len());
        }
        for series in evidence.figures.iter().flat_map(|figure| &figure.panels).flat_map(|panel| &panel.series) {
            let _ = writeln!(told, "  curve {}, {} points", series.label, series.points.len());
        }
        told
    });
    insta::assert_snapshot!(told.collect::<String>());
}
