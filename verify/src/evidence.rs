//! What a study found: checks, tables and figures. Studies fill these in, the report renders them; neither knows the other.

use serde::{Deserialize, Serialize, Serializer};

/// Outcome of one check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The check ran and held.
    Pass,
    /// The check ran and did not hold.
    Fail,
    /// The data allow no decision; never counted as a pass.
    Inconclusive,
    /// The check could not run here (a feature or library is missing).
    NotRun,
}

impl From<bool> for Outcome {
    fn from(holds: bool) -> Self {
        if holds { Self::Pass } else { Self::Fail }
    }
}

/// One statement decided by computation.
#[derive(Debug, Clone, Serialize)]
pub struct Check {
    /// Stable identifier, unique in the study: `order/method-i/logistic`.
    pub id: String,
    /// What is asserted, in one sentence.
    pub statement: String,
    /// What came out.
    pub outcome: Outcome,
    /// The number that was measured, where there is one.
    #[serde(serialize_with = "optional_number")]
    pub measured: Option<f64>,
    /// What was required of it: `2.00 ± 0.05`, `≤ 3.1e-15`.
    pub required: String,
    /// Where the requirement comes from, or why the check failed, was inconclusive or did not run.
    pub reason: String,
}

impl Check {
    /// A number that must lie in the closed interval from `low` to `high`; NaN does not.
    pub fn within(
        id: impl Into<String>,
        statement: impl Into<String>,
        measured: f64,
        [low, high]: [f64; 2],
        reason: impl Into<String>,
    ) -> Self {
        let required = match (low.is_finite(), high.is_finite()) {
            (true, true) => format!("{:.6} ± {:.1e}", 0.5 * (low + high), 0.5 * (high - low)),
            (false, _) => format!("≤ {high:.3e}"),
            (_, false) => format!("≥ {low:.3e}"),
        };
        Self {
            id: id.into(),
            statement: statement.into(),
            outcome: (low <= measured && measured <= high).into(),
            measured: Some(measured),
            required,
            reason: reason.into(),
        }
    }

    /// A number that must not exceed `bound`.
    pub fn at_most(
        id: impl Into<String>,
        statement: impl Into<String>,
        measured: f64,
        bound: f64,
        reason: impl Into<String>,
    ) -> Self {
        Self::within(id, statement, measured, [f64::NEG_INFINITY, bound], reason)
    }
}

/// A table; also written as `data/<id>.csv` at full precision.
#[derive(Debug, Clone, Serialize)]
pub struct Table {
    /// Stable identifier: file stem and anchor.
    pub id: String,
    /// One sentence saying what the reader sees.
    pub caption: String,
    /// Column names, machine readable: `max_error`.
    pub columns: Vec<String>,
    /// Rows; each as long as `columns`.
    pub rows: Vec<Vec<Cell>>,
    /// Whether the report shows the rows; data behind a figure only are linked.
    pub shown: bool,
}

/// One cell of a [`Table`].
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Cell {
    /// Text.
    Text(String),
    /// A number: round-trip precision in files, four significant digits on the page. One that is not finite is shown as
    /// such; a result that does not exist is [`Cell::Empty`].
    #[serde(serialize_with = "number")]
    Number(f64),
    /// A count.
    Integer(i64),
    /// Nothing there; the reason stands in another column.
    Empty,
}

/// JSON has no word for a number that is not finite; it becomes the string `NaN`, `inf` or `-inf`, never `null`.
fn number<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if value.is_finite() { serializer.serialize_f64(*value) } else { serializer.collect_str(value) }
}

fn optional_number<S: Serializer>(value: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    match value {
        Some(value) => number(value, serializer),
        None => serializer.serialize_none(),
    }
}

/// A figure of one or more panels, laid out in reading order.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Stable identifier and anchor.
    pub id: String,
    /// One or two sentences: what is drawn and what to see in it.
    pub caption: String,
    /// Id of the [`Table`] that holds the data.
    pub data: String,
    /// The panels.
    pub panels: Vec<Panel>,
    /// Panels per row on a wide page.
    pub columns: usize,
}

/// One set of axes.
#[derive(Debug, Clone, Default)]
pub struct Panel {
    /// Title above the axes; may be empty.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// What is drawn.
    pub series: Vec<Series>,
    /// A map drawn beneath the series, such as a region of stability.
    pub field: Option<Field>,
}

/// A function of two variables on a rectangular grid, drawn as a map of bands.
///
/// Band `k` holds the values in `[levels[k-1], levels[k])`, the first everything below `levels[0]` and the last
/// everything from the last level on. Each grid point colours the cell around it, so that the map shows the samples and
/// nothing between them. Values that are not finite stay blank.
#[derive(Debug, Clone)]
pub struct Field {
    /// Abscissae, ascending.
    pub x: Vec<f64>,
    /// Ordinates, ascending.
    pub y: Vec<f64>,
    /// `values[j][i]` at `(x[i], y[j])`.
    pub values: Vec<Vec<f64>>,
    /// Boundaries between the bands, ascending.
    pub levels: Vec<f64>,
    /// Legend entries of the bands, one more than there are levels.
    pub bands: Vec<String>,
    /// Interpolated lines at the levels too; for continuous functions, not for categories.
    pub contours: bool,
}

impl Field {
    /// Whether there is one value for every point of the grid.
    pub fn is_rectangular(&self) -> bool {
        self.values.len() == self.y.len() && self.values.iter().all(|row| row.len() == self.x.len())
    }
}

/// An axis.
#[derive(Debug, Clone, Default)]
pub struct Axis {
    /// Label with unit, `1/h`.
    pub label: String,
    /// Logarithmic scale.
    pub log: bool,
    /// Fixed limits; from the data where absent.
    pub limits: Option<(f64, f64)>,
}

/// One curve or cloud of points.
#[derive(Debug, Clone)]
pub struct Series {
    /// Legend entry.
    pub label: String,
    /// Points; one that is not finite, or not positive on a log axis, breaks the line and is counted below the panel.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub mark: Mark,
}

/// How a [`Series`] is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A line.
    Line,
    /// A line with a marker at each point.
    LineMarkers,
    /// Markers only.
    Markers,
    /// A thin dashed guide, such as a slope triangle or an exact curve.
    Guide,
}

/// All that a study found.
#[derive(Debug, Clone, Default)]
pub struct Evidence {
    /// Decisions.
    pub checks: Vec<Check>,
    /// Tables.
    pub tables: Vec<Table>,
    /// Figures.
    pub figures: Vec<Figure>,
    /// Findings in words, a paragraph each, `inline code` allowed.
    pub notes: Vec<String>,
    /// Parts with a heading each, after everything else.
    pub sections: Vec<Section>,
    /// Measured times in seconds by what took them; they differ from run to run and stand in `timings.json` alone.
    pub timings: Vec<(String, f64)>,
}

/// A part of a chapter with a heading and an anchor of its own.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Section {
    /// Stable identifier and anchor, unique in the report: `S24-a`. Cells of tables that hold it link here.
    pub id: String,
    /// Heading.
    pub title: String,
    /// A word set off beside the heading, such as a verdict; may be empty.
    pub mark: String,
    /// Labelled paragraphs, `inline code` allowed.
    pub paragraphs: Vec<(String, String)>,
    /// Ids of the chapter's figures that are shown here.
    pub figures: Vec<String>,
    /// Ids of the chapter's tables that are shown here.
    pub tables: Vec<String>,
}
