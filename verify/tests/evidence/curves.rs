//! What a figure draws under the name of a method is what the table of its data has in the rows of that name.

use std::collections::HashSet;

use verify::evidence::{Cell, Evidence, Series, Table};

/// The curves of figures with a point that no row of their name has.
pub(super) fn strays(evidence: &Evidence) -> Vec<String> {
    let mut found = Vec::new();
    for figure in &evidence.figures {
        let Some(table) = evidence.tables.iter().find(|table| table.id == figure.data) else {
            found.push(format!("figure `{}` has no data", figure.id));
            continue;
        };
        let rows: Vec<Row> = table.rows.iter().map(|row| Row::of(row)).collect();
        let numbers: HashSet<u64> = rows.iter().flat_map(|row| row.numbers.iter().copied()).collect();
        for series in figure.panels.iter().flat_map(|panel| &panel.series) {
            let lost = lost(series, &rows, &numbers);
            if lost > 0 {
                found
                    .push(format!("{lost} points of “{}” in `{}` are in no row of that name", series.label, figure.id));
            }
        }
    }
    found
}

struct Row<'a> {
    texts: Vec<&'a str>,
    /// Bit by bit, and what 1/h of them is.
    numbers: HashSet<u64>,
}

impl<'a> Row<'a> {
    fn of(row: &'a [Cell]) -> Self {
        let texts = row.iter().filter_map(|cell| match cell {
            Cell::Text(text) => Some(text.as_str()),
            _ => None,
        });
        let numbers = row.iter().filter_map(Cell::number).flat_map(|x| [x, 1.0 / x]).map(f64::to_bits);
        Self { texts: texts.collect(), numbers: numbers.collect() }
    }
}

/// How many points of a curve are in no row that it is named after. Its name may have two parts, as in `method-i, vorticity`.
fn lost(series: &Series, rows: &[Row], numbers: &HashSet<u64>) -> usize {
    let parts = match series.label.split_once(", ") {
        Some((first, second)) => vec![first, second],
        None => vec![series.label.as_str()],
    };
    let rows: Vec<_> = rows.iter().filter(|row| parts.iter().all(|part| row.texts.contains(part))).collect();
    let is_there = |(x, y): &&(f64, f64)| {
        let [x, y] = [x, y].map(|value| value.to_bits());
        // Seconds, which differ from run to run, are in no table.
        rows.iter().any(|row| row.numbers.contains(&y) && (row.numbers.contains(&x) || !numbers.contains(&x)))
    };
    let points = series.points.iter().filter(|point| point.1.is_finite());
    if rows.is_empty() { 0 } else { points.filter(|point| !is_there(point)).count() }
}

/// The points that the rows with `group` in their first column and `label` in the second have in two columns, in their order.
pub(super) fn points(table: &Table, group: &str, label: &str, x: &str, y: &str) -> Vec<(f64, f64)> {
    let [x, y] = [x, y].map(|name| table.column(name).expect("a column"));
    let is_it = |row: &&Vec<Cell>| row[0].to_string() == group && row[1].to_string() == label;
    table.rows.iter().filter(is_it).filter_map(|row| row[x].number().zip(row[y].number())).collect()
}
