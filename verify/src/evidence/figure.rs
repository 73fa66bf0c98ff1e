//! Figures: panels of curves, clouds and maps.

/// A figure of one or more panels, laid out in reading order.
#[derive(Debug, Clone, speedy::Readable, speedy::Writable)]
pub struct Figure {
    /// Stable identifier and anchor.
    pub id: String,
    /// One or two sentences: what is drawn and what to see in it.
    pub caption: String,
    /// Id of the [`Table`](super::Table) that holds the data.
    pub data: String,
    /// The panels.
    pub panels: Vec<Panel>,
    /// Panels per row on a wide page.
    pub columns: usize,
}

/// One set of axes.
#[derive(Debug, Clone, Default, speedy::Readable, speedy::Writable)]
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
#[derive(Debug, Clone, speedy::Readable, speedy::Writable)]
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
#[derive(Debug, Clone, Default, speedy::Readable, speedy::Writable)]
pub struct Axis {
    /// Label with unit, `1/h`.
    pub label: String,
    /// Logarithmic scale.
    pub log: bool,
    /// Fixed limits; from the data where absent.
    pub limits: Option<(f64, f64)>,
}

/// One curve or cloud of points.
#[derive(Debug, Clone, speedy::Readable, speedy::Writable)]
pub struct Series {
    /// Legend entry.
    pub label: String,
    /// Points; one that is not finite, or not positive on a log axis, breaks the line and is counted below the panel.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub mark: Mark,
}

/// How a [`Series`] is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, speedy::Readable, speedy::Writable)]
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

impl Figure {
    /// A figure on the data of the table `data`, with one panel a row.
    pub fn new(
        id: impl Into<String>,
        caption: impl Into<String>,
        data: impl Into<String>,
        panels: impl IntoIterator<Item = Panel>,
    ) -> Self {
        let panels = panels.into_iter().collect();
        Self { id: id.into(), caption: caption.into(), data: data.into(), panels, columns: 1 }
    }

    /// The same with so many panels in a row.
    #[must_use]
    pub fn in_columns(self, columns: usize) -> Self {
        Self { columns, ..self }
    }
}

impl Panel {
    /// Axes with curves.
    pub fn new(x: Axis, y: Axis, series: Vec<Series>) -> Self {
        Self { x, y, series, ..Self::default() }
    }

    /// The same under a title.
    #[must_use]
    pub fn titled(self, title: impl Into<String>) -> Self {
        Self { title: title.into(), ..self }
    }

    /// The same over a map.
    #[must_use]
    pub fn over(self, field: Field) -> Self {
        Self { field: Some(field), ..self }
    }
}

impl Axis {
    /// An axis as long as the data.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), log: false, limits: None }
    }

    /// A logarithmic axis.
    pub fn log(label: impl Into<String>) -> Self {
        Self { label: label.into(), log: true, limits: None }
    }

    /// The same between fixed limits.
    #[must_use]
    pub fn between(self, low: f64, high: f64) -> Self {
        Self { limits: Some((low, high)), ..self }
    }
}

impl Series {
    /// Points under one legend entry.
    pub fn new(label: impl Into<String>, points: Vec<(f64, f64)>, mark: Mark) -> Self {
        Self { label: label.into(), points, mark }
    }
}
