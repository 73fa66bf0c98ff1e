#![doc = include_str!("../../doc/results.md")]

use serde::Serialize;

use super::run::{Counts, Run};
use super::text::data_file;
use crate::evidence::{Cell, Check, Section};

/// Version of the schema that the file describes.
pub(super) const SCHEMA: u32 = 2;

#[derive(Serialize)]
struct Results<'a> {
    schema: u32,
    provenance: &'a [(String, String)],
    counts: Counts,
    chapters: Vec<ChapterResults<'a>>,
}

#[derive(Serialize)]
struct ChapterResults<'a> {
    id: &'a str,
    title: &'a str,
    question: &'a str,
    source: &'a str,
    error: Option<&'a str>,
    counts: Counts,
    checks: &'a [Check],
    tables: Vec<TableResults<'a>>,
    figures: Vec<FigureResults<'a>>,
    notes: &'a [String],
    sections: &'a [Section],
}

#[derive(Serialize)]
struct TableResults<'a> {
    id: &'a str,
    caption: &'a str,
    file: String,
    columns: &'a [String],
    row_count: usize,
    rows: Option<&'a [Vec<Cell>]>,
}

#[derive(Serialize)]
struct FigureResults<'a> {
    id: &'a str,
    caption: &'a str,
    data: &'a str,
}

pub(super) fn document(run: &Run) -> Result<String, serde_json::Error> {
    let chapters = run.chapters.iter().map(|chapter| {
        let evidence = &chapter.evidence;
        let tables = evidence.tables.iter().map(|table| TableResults {
            id: &table.id,
            caption: &table.caption,
            file: data_file(&table.id),
            columns: &table.columns,
            row_count: table.rows.len(),
            rows: table.shown.then_some(&table.rows),
        });
        let figures = evidence.figures.iter().map(|figure| FigureResults {
            id: &figure.id,
            caption: &figure.caption,
            data: &figure.data,
        });
        ChapterResults {
            id: &chapter.id,
            title: &chapter.title,
            question: &chapter.question,
            source: &chapter.source,
            error: chapter.error.as_deref(),
            counts: Counts::of(chapter),
            checks: &evidence.checks,
            tables: tables.collect(),
            figures: figures.collect(),
            notes: &evidence.notes,
            sections: &evidence.sections,
        }
    });
    let results =
        Results { schema: SCHEMA, provenance: &run.provenance, counts: run.counts(), chapters: chapters.collect() };
    Ok(serde_json::to_string_pretty(&results)? + "\n")
}

/// `timings.json`: the measured times, apart from all that a second run reproduces.
pub(super) fn timings(run: &Run) -> Result<String, serde_json::Error> {
    let of = |chapter: &super::Chapter| {
        let runs: serde_json::Map<String, serde_json::Value> =
            chapter.evidence.timings.iter().map(|(what, seconds)| (what.clone(), (*seconds).into())).collect();
        serde_json::json!({ "id": chapter.id, "seconds": chapter.seconds, "runs": runs, "spreads": chapter.evidence.spreads })
    };
    let chapters: Vec<_> = run.chapters().iter().map(of).collect();
    serde_json::to_string_pretty(&serde_json::json!({ "schema": SCHEMA, "chapters": chapters }))
}

/// The data files that an earlier `results.json` lists, so that those no longer written can be removed; none if it cannot
/// be read.
pub(super) fn files_listed(text: &str) -> Vec<String> {
    let Ok(value) = serde_json::from_str::<serde_json::Value>(text) else { return Vec::new() };
    let chapters = value["chapters"].as_array().into_iter().flatten();
    let tables = chapters.flat_map(|chapter| chapter["tables"].as_array().into_iter().flatten());
    // Through `data_file` again, so that no path in the file leads elsewhere.
    tables.filter_map(|table| table["id"].as_str()).map(data_file).collect()
}
