//! Figures: panels of curves, clouds and maps.

use std::fmt::Write;

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
    /// One of many: a thin grey line behind the others, which the legend counts and does not name.
    Other,
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

    /// The same with one logarithmic scale of ordinates in all panels, from decade to decade.
    #[must_use]
    pub fn on_one_scale(mut self) -> Self {
        let points = self.panels.iter().flat_map(|panel| &panel.series).flat_map(|series| &series.points);
        let decades = points.map(|(_, y)| y.log10()).filter(|decade| decade.is_finite());
        let (low, high) =
            decades.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), decade| (low.min(decade), high.max(decade)));
        if low <= high {
            let limits = Some((10_f64.powf(low.floor()), 10_f64.powf(high.ceil())));
            self.panels.iter_mut().for_each(|panel| panel.y.limits = limits);
        }
        self
    }
}

/// Colours of the report, and so the series that a figure can tell apart.
pub const COLORS: usize = 8;

impl Figure {
    /// The same with the series of these names in colour and all others but guides grey, which the caption says, for whoever sees
    /// no colours; as it is if there are colours for all. Names that it has no series of are passed over.
    #[must_use]
    pub fn telling(mut self, names: &[&str]) -> Self {
        let labels = self.labels();
        if labels.len() <= COLORS {
            return self;
        }
        let told = listed(names.iter().filter(|name| labels.contains(name)));
        let all = self.panels.iter_mut().flat_map(|panel| &mut panel.series);
        for series in all.filter(|series| series.mark != Mark::Guide && !names.contains(&series.label.as_str())) {
            series.mark = Mark::Other;
        }
        let _ = write!(self.caption, " In colour: {told}. The others are grey, and named where one points at them.");
        self
    }

    /// Names of all series but guides, in their order.
    fn labels(&self) -> Vec<&str> {
        let mut labels: Vec<&str> = Vec::new();
        for series in self.panels.iter().flat_map(|panel| &panel.series).filter(|series| series.mark != Mark::Guide) {
            if !labels.contains(&series.label.as_str()) {
                labels.push(&series.label);
            }
        }
        labels
    }
}

/// Names in a sentence.
fn listed<'a>(names: impl Iterator<Item = &'a &'a str>) -> String {
    names.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten curves of which `m3` is the lowest and `m7` the highest in both panels, but `m0` is lower still in the one panel where it stands.
    fn crowded() -> Figure {
        let height = |k: usize| match k {
            3 => 1e-9,
            7 => 1.0,
            _ => 1e-3 * (k + 1) as f64,
        };
        let curve = |k: usize| {
            let points = vec![(1.0, 9.0), (2.0, height(k)), (3.0, f64::NAN), (4.0, -1.0), (5.0, 10.0)];
            Series::new(format!("m{k}"), points, Mark::LineMarkers)
        };
        let panel = |series| Panel::new(Axis::log("h"), Axis::log("error"), series);
        let mut first: Vec<Series> = (1..10).map(curve).collect();
        first.push(Series::new("slope 2", vec![(1.0, 1e-12)], Mark::Guide));
        let mut second = first.clone();
        second.push(Series::new("m0", vec![(1.0, 1e-11)], Mark::Line));
        Figure::new("id", "A caption.", "data", [panel(first), panel(second)])
    }

    /// From 10⁻¹² to 10 in whole decades, where one panel alone would begin at 10⁻¹¹; what is not positive has no place.
    #[test]
    fn panels_on_one_scale_have_room_for_all_of_them() {
        let limits = |figure: Figure| figure.panels.iter().map(|panel| panel.y.limits).collect::<Vec<_>>();
        let mut figure = crowded();
        figure.panels[1].series.retain(|series| series.mark != Mark::Guide);
        let [Some(first), Some(second)] = limits(figure.on_one_scale())[..] else { panic!("there are two") };
        assert_eq!(first, second);
        approx::assert_relative_eq!(first.0, 1e-12, max_relative = 1e-9);
        approx::assert_relative_eq!(first.1, 10.0, max_relative = 1e-9);
        assert_eq!(
            limits(Figure::new("id", "", "data", [Panel::new(Axis::log("h"), Axis::log("e"), vec![])]).on_one_scale()),
            [None]
        );
    }

    fn marked(figure: &Figure, mark: impl Fn(Mark) -> bool) -> Vec<&str> {
        figure.panels[1].series.iter().filter(|s| mark(s.mark)).map(|s| s.label.as_str()).collect()
    }

    #[test]
    fn a_crowded_figure_tells_those_apart_that_it_names() {
        let figure = crowded().telling(&["m5", "m3", "unknown"]);
        assert_eq!(marked(&figure, |mark| mark == Mark::LineMarkers), ["m3", "m5"]);
        assert_eq!(marked(&figure, |mark| mark == Mark::Guide), ["slope 2"]);
        assert_eq!(marked(&figure, |mark| mark == Mark::Other), ["m1", "m2", "m4", "m6", "m7", "m8", "m9", "m0"]);
        assert!(figure.caption.starts_with("A caption. In colour: `m5`, `m3`. The others"), "{}", figure.caption);
    }

    #[test]
    fn a_figure_with_colours_for_all_stays_as_it_is() {
        let mut figure = crowded();
        for panel in &mut figure.panels {
            panel.series.retain(|series| !["m0", "m9"].contains(&series.label.as_str()));
        }
        let told = figure.clone().telling(&["m5"]);
        assert_eq!(told.caption, figure.caption);
        assert!(marked(&told, |mark| mark == Mark::Other).is_empty());
    }
}
