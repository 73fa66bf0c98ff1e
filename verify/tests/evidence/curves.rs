//! What a figure draws under the name of a method is what the table of its data has in the rows of that name.

use std::collections::{HashMap, HashSet};

use libtest_mimic::Failed;
use verify::evidence::{Axis, COLORS, Cell, Evidence, Figure, Mark, Panel, Series, Table};

/// The curves of figures with a point that no row of their name has.
pub(super) fn strays(evidence: &Evidence) -> Vec<String> {
    let mut found = Vec::new();
    for figure in &evidence.figures {
        let Some(table) = evidence.tables.iter().find(|table| table.id == figure.data) else {
            found.push(format!("figure `{}` has no data", figure.id));
            continue;
        };
        let rows = Rows::of(table);
        for (panel, series) in figure.panels.iter().flat_map(|panel| panel.series.iter().map(move |s| (panel, s))) {
            let lost = rows.lost(series, &series.label, &panel.x.label);
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
        let rows = Rows::of(table);
        for panel in &figure.panels {
            let is_named = |series: &&Series| rows.named.contains_key(series.label.as_str());
            let named: Vec<&Series> = panel.series.iter().filter(is_named).collect();
            // Curves that coincide may change their names, and so may those of one or two points that meet.
            let [first, .., last] = named.as_slice() else { continue };
            let meets = |a: &Series, b: &Series| a.points.iter().all(|p| b.points.iter().any(|q| p.1 == q.1));
            if meets(first, last) && meets(last, first) {
                continue;
            }
            let (first, last) = (first.label.as_str(), last.label.as_str());
            let changed = |label| match label {
                _ if label == first => last,
                _ if label == last => first,
                _ => label,
            };
            if panel.series.iter().all(|series| rows.lost(series, changed(&series.label), &panel.x.label) == 0) {
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

/// The rows of a table, by the texts in them.
struct Rows<'a> {
    all: Vec<Row>,
    named: HashMap<&'a str, Vec<usize>>,
    numbers: HashSet<u64>,
}

/// The numbers of a row and 1/h of them, bit by bit.
struct Row {
    plain: Vec<u64>,
    reciprocal: Vec<u64>,
}

impl Row {
    fn numbers(&self) -> impl Iterator<Item = &u64> {
        self.plain.iter().chain(&self.reciprocal)
    }
}

impl<'a> Rows<'a> {
    fn of(table: &'a Table) -> Self {
        let bits =
            |row: &[Cell], f: fn(f64) -> f64| row.iter().filter_map(|c| Some(f(c.number()?).to_bits())).collect();
        let all: Vec<Row> =
            table.rows.iter().map(|row| Row { plain: bits(row, |x| x), reciprocal: bits(row, |x| 1.0 / x) }).collect();
        let mut named: HashMap<&str, Vec<usize>> = HashMap::new();
        for (place, row) in table.rows.iter().enumerate() {
            for cell in row {
                if let Cell::Text(text) = cell {
                    named.entry(text).or_default().push(place);
                }
            }
        }
        let numbers = all.iter().flat_map(Row::numbers).copied().collect();
        Self { all, named, numbers }
    }

    /// The rows that have a name, which may have two parts, as in `method-i, vorticity`, where no row has it as it stands.
    fn named(&self, name: &str) -> Vec<&Row> {
        let of = |part: &str| self.named.get(part).map_or(&[][..], Vec::as_slice);
        let whole = of(name);
        let places: Vec<usize> = match name.split_once(", ") {
            Some((first, second)) if whole.is_empty() => {
                let others: HashSet<_> = of(second).iter().collect();
                of(first).iter().filter(|place| others.contains(place)).copied().collect()
            }
            _ => whole.to_vec(),
        };
        places.into_iter().map(|place| &self.all[place]).collect()
    }

    /// How many points of a curve are in no row of this name; none where no row has it. What the axis of the abscissae says decides what
    /// these are.
    fn lost(&self, series: &Series, name: &str, axis: &str) -> usize {
        let rows = self.named(name);
        let mut ordinates: Vec<(u64, &Row)> =
            rows.iter().flat_map(|row| row.numbers().map(move |number| (*number, *row))).collect();
        ordinates.sort_unstable_by_key(|(number, _)| *number);
        let is_there = |(x, y): &&(f64, f64)| {
            let [x, y] = [x, y].map(|value| value.to_bits());
            let is_at = |row: &Row| match axis {
                "1/h" => row.reciprocal.contains(&x),
                "h" | "CPU seconds" => row.plain.contains(&x),
                // Places that are computed for the figure alone are in no table.
                _ => row.numbers().any(|number| *number == x) || !self.numbers.contains(&x),
            };
            let first = ordinates.partition_point(|(number, _)| *number < y);
            ordinates[first..].iter().take_while(|(number, _)| *number == y).any(|(_, row)| is_at(row))
        };
        let points = series.points.iter().filter(|point| point.1.is_finite());
        if rows.is_empty() { 0 } else { points.filter(|point| !is_there(point)).count() }
    }
}

/// Each fault of a small figure is found, and nothing where there is none.
pub(super) fn what_is_in_no_row_is_found() -> Result<(), Failed> {
    type Curve = (&'static str, [(f64, f64); 2]);
    let rows = [
        ("a", "plain", 0.125, 1.0),
        ("a", "plain", 0.0625, 2.0),
        ("b", "plain", 0.125, 3.0),
        ("b", "fine", 0.0625, 4.0),
    ];
    let of = |first: &str, curves: [Curve; 2]| {
        let cells = |(name, kind, h, error): (&str, &str, f64, f64)| -> Vec<Cell> {
            vec![first.replace('*', name).as_str().into(), kind.into(), h.into(), error.into()]
        };
        let table = Table {
            id: "errors".into(),
            caption: String::new(),
            columns: ["method", "kind", "h", "error"].map(String::from).into(),
            rows: rows.map(cells).into(),
            shown: true,
        };
        let series =
            curves.map(|(label, points)| Series { label: label.into(), points: points.into(), mark: Mark::Line });
        let x = Axis { label: "1/h".into(), ..Axis::default() };
        let panels = vec![Panel { x, series: series.into(), ..Panel::default() }];
        let figure = Figure { id: "f".into(), caption: String::new(), data: "errors".into(), panels, columns: 1 };
        let evidence = Evidence { figures: vec![figure], tables: vec![table], ..Evidence::default() };
        (strays(&evidence).len(), blind(&evidence).len())
    };
    let (a, b) = ([(8.0, 1.0), (16.0, 2.0)], [(8.0, 3.0), (16.0, 4.0)]);
    for (first, curves, expected) in [
        ("*", [("a", a), ("b", b)], (0, 0)),
        ("*", [("a", b), ("b", a)], (2, 1)),
        ("*", [("a", [(8.0, 1.5), (16.0, 2.0)]), ("b", b)], (1, 0)),
        ("*", [("a", [(8.0, 2.0), (16.0, 2.0)]), ("b", b)], (1, 0)),
        ("*", [("a", [(0.125, 1.0), (16.0, 2.0)]), ("b", b)], (1, 0)),
        // Nothing is known of a name that no row has.
        ("*", [("c", b), ("b", b)], (0, 0)),
        ("*", [("a, plain", a), ("b, plain", b)], (1, 0)),
        // Where rows have one name the points tell nothing of it.
        ("both", [("both", a), ("plain", [(8.0, 3.0), (8.0, 1.0)])], (0, 1)),
    ] {
        let found = of(first, curves);
        if found != expected {
            return Err(format!("{first} {curves:?}: {found:?} instead of {expected:?}").into());
        }
    }
    Ok(())
}

/// The points that the rows with `group` in their first column and `label` in the second have in two columns, in their order.
pub(super) fn points(table: &Table, group: &str, label: &str, x: &str, y: &str) -> Vec<(f64, f64)> {
    let [x, y] = [x, y].map(|name| table.column(name).expect("a column"));
    let is_it = |row: &&Vec<Cell>| row[0].to_string() == group && row[1].to_string() == label;
    table.rows.iter().filter(is_it).filter_map(|row| row[x].number().zip(row[y].number())).collect()
}
