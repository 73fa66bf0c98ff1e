//! What a figure draws under the name of a method is what the table of its data has in the rows of that name.

use std::collections::HashSet;

use verify::evidence::{COLORS, Cell, Evidence, Figure, Mark, Series, Table};

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
        for (panel, series) in figure.panels.iter().flat_map(|panel| panel.series.iter().map(move |s| (panel, s))) {
            let lost = lost(series, &panel.x.label, &rows, &numbers);
            if lost > 0 {
                found
                    .push(format!("{lost} points of “{}” in `{}` are in no row of that name", series.label, figure.id));
            }
        }
    }
    found
}

/// Figures in which curves that change their names would not be noticed by [`strays`], though rows of the table have the names.
pub(super) fn blind(evidence: &Evidence) -> Vec<String> {
    let mut found = Vec::new();
    for (place, figure) in evidence.figures.iter().enumerate() {
        let Some(table) = evidence.tables.iter().find(|table| table.id == figure.data) else { continue };
        let rows: Vec<Row> = table.rows.iter().map(|row| Row::of(row)).collect();
        for (which, panel) in figure.panels.iter().enumerate() {
            let is_named = |series: &&Series| rows.iter().any(|row| row.texts.contains(&series.label.as_str()));
            let named: Vec<&Series> = panel.series.iter().filter(is_named).collect();
            // Curves that coincide may change their names, and so may those of one or two points that meet.
            let [first, .., last] = named.as_slice() else { continue };
            let meets = |a: &Series, b: &Series| a.points.iter().all(|p| b.points.iter().any(|q| p.1 == q.1));
            if meets(first, last) && meets(last, first) {
                continue;
            }
            let (first, last) = (first.label.clone(), last.label.clone());
            let mut changed =
                Evidence { figures: vec![figure.clone()], tables: vec![table.clone()], ..Evidence::default() };
            for series in &mut changed.figures[0].panels[which].series {
                if series.label == first {
                    series.label.clone_from(&last);
                } else if series.label == last {
                    series.label.clone_from(&first);
                }
            }
            if strays(&changed).is_empty() {
                found.push(format!("“{first}” and “{last}” may change places in figure {place}, `{}`", figure.id));
            }
        }
    }
    found
}

/// Figures with more coloured series than colours, with a series that is neither in colour nor grey throughout, whose caption names
/// one in colour that is not, or with an axis that does not say what it measures.
pub(super) fn crowded(evidence: &Evidence) -> Vec<String> {
    evidence
        .figures
        .iter()
        .filter_map(|figure| unreadable(figure).map(|what| format!("`{}`: {what}", figure.id)))
        .collect()
}

fn unreadable(figure: &Figure) -> Option<String> {
    let all = || figure.panels.iter().flat_map(|panel| &panel.series).filter(|series| series.mark != Mark::Guide);
    let of = |grey: bool| {
        all().filter(|s| (s.mark == Mark::Other) == grey).map(|s| s.label.as_str()).collect::<HashSet<_>>()
    };
    let (coloured, grey) = (of(false), of(true));
    if coloured.len() > COLORS {
        return Some(format!("{} series in colour", coloured.len()));
    }
    if let Some(label) = coloured.intersection(&grey).next() {
        return Some(format!("“{label}” is both in colour and grey"));
    }
    let told: HashSet<&str> = match figure.caption.split_once(" In colour: ") {
        Some((_, told)) => told.split('`').skip(1).step_by(2).collect(),
        None => HashSet::new(),
    };
    if !grey.is_empty() && told != coloured {
        return Some(format!("its caption tells of {told:?}, in colour are {coloured:?}"));
    }
    let nameless =
        figure.panels.iter().flat_map(|panel| [&panel.x, &panel.y]).find(|axis| axis.label.trim().is_empty());
    nameless.map(|_| "an axis does not say what it measures".into())
}

/// Captions whose numbers are not those of what is drawn: the error above which nothing is, and the range of tolerances.
pub(super) fn misquoted(evidence: &Evidence) -> Vec<String> {
    let mut found = Vec::new();
    for figure in &evidence.figures {
        if let Some(most) = number_after(&figure.caption, "rrors above ") {
            // Where estimates are drawn over errors, the errors are the abscissae.
            let errors = figure.panels.iter().flat_map(|panel| {
                let is_across = panel.x.label.contains("error");
                let drawn = panel.series.iter().filter(|series| series.mark != Mark::Guide);
                drawn.flat_map(|s| &s.points).map(move |point| if is_across { point.0 } else { point.1 })
            });
            let above = errors.filter(|error| *error > most).count();
            if above > 0 {
                found.push(format!("`{}` draws {above} errors above {most}", figure.id));
            }
        }
        let said = figure.caption.split_once("tolerances from ").and_then(|(_, rest)| range(rest));
        let table = evidence.tables.iter().find(|table| table.id == figure.data);
        if let Some(((most, least), table)) = said.zip(table) {
            let [solver, setting] = ["solver", "h_or_tolerance"].map(|name| table.column(name).expect("a column"));
            let rows = table.rows.iter().filter(|row| row[solver].to_string() == "radau-adaptive");
            let mut tolerances: Vec<f64> = rows.filter_map(|row| row[setting].number()).collect();
            tolerances.sort_by(f64::total_cmp);
            let [low, high] = [tolerances.first(), tolerances.last()].map(|found| found.copied().unwrap_or(f64::NAN));
            let agrees = |said: f64, had: f64| (had / said).ln().abs() < 1e-9;
            if !agrees(most, high) || !agrees(least, low) {
                found.push(format!("`{}` has tolerances from {high:e} to {low:e}", figure.id));
            }
        }
    }
    found
}

/// The two numbers of `1e-3 to 1e-9`.
fn range(text: &str) -> Option<(f64, f64)> {
    let (first, rest) = text.split_once(" to ")?;
    first.parse().ok().zip(rest.split([' ', ',', '.']).next()?.parse().ok())
}

/// The number that stands behind these words.
fn number_after(text: &str, words: &str) -> Option<f64> {
    let (_, rest) = text.split_once(words)?;
    rest.split([' ', ',']).next()?.trim_end_matches(['.', ';', ':']).parse().ok()
}

struct Row<'a> {
    texts: Vec<&'a str>,
    /// Bit by bit, with what 1/h of them is.
    numbers: HashSet<u64>,
    plain: HashSet<u64>,
    reciprocal: HashSet<u64>,
}

impl<'a> Row<'a> {
    fn of(row: &'a [Cell]) -> Self {
        let texts = row.iter().filter_map(|cell| match cell {
            Cell::Text(text) => Some(text.as_str()),
            _ => None,
        });
        let numbers = || row.iter().filter_map(Cell::number);
        let plain: HashSet<u64> = numbers().map(f64::to_bits).collect();
        let reciprocal: HashSet<u64> = numbers().map(|x| (1.0 / x).to_bits()).collect();
        let numbers = plain.union(&reciprocal).copied().collect();
        Self { texts: texts.collect(), numbers, plain, reciprocal }
    }
}

/// How many points of a curve are in no row that it is named after. Its name may have two parts, as in
/// `method-i, vorticity`, where no row has it as it stands. What the axis of the abscissae says decides what these are.
fn lost(series: &Series, axis: &str, rows: &[Row], numbers: &HashSet<u64>) -> usize {
    let whole = series.label.as_str();
    let is_whole = rows.iter().any(|row| row.texts.contains(&whole));
    let parts = match whole.split_once(", ") {
        Some((first, second)) if !is_whole => vec![first, second],
        _ => vec![whole],
    };
    let rows: Vec<_> = rows.iter().filter(|row| parts.iter().all(|part| row.texts.contains(part))).collect();
    let is_there = |(x, y): &&(f64, f64)| {
        let [x, y] = [x, y].map(|value| value.to_bits());
        let is_at = |row: &&Row| match axis {
            "1/h" => row.reciprocal.contains(&x),
            "h" | "CPU seconds" => row.plain.contains(&x),
            // Places that are computed for the figure alone are in no table.
            _ => row.numbers.contains(&x) || !numbers.contains(&x),
        };
        rows.iter().any(|row| row.numbers.contains(&y) && is_at(row))
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
