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
    pub fn telling(self, names: &[&str]) -> Self {
        let names = self.among(names);
        let told = format!("In colour: {}", listed(&names));
        self.dimmed(&names, told)
    }

    /// The same with those in colour, too, whose least error is smaller and larger than that of every other one. Only for figures of errors: a defect at rounding is not
    /// the better the smaller it is.
    #[must_use]
    pub fn telling_with_extremes(self, names: &[&str]) -> Self {
        let Extremes { best, worst, of, panels } = self.extremes();
        let mut names = self.among(names);
        let mut told = format!("In colour: {}", listed(&names));
        let (among, place) = if panels == 1 {
            (format!("the {of} curves"), "")
        } else {
            (format!("the {of} curves that are in most of the {panels} panels"), ", in most panels that show both")
        };
        let is = |name: &str, than: &str| format!("the least error of `{name}` is {than} than that of each other one");
        let found: Vec<_> =
            best.iter().map(|name| is(name, "smaller")).chain(worst.iter().map(|name| is(name, "larger"))).collect();
        if !found.is_empty() {
            let _ = write!(told, "; of {among} {}{place}", found.join(" and "));
        }
        names.extend(best.into_iter().chain(worst));
        self.dimmed(&names, told)
    }

    fn among(&self, names: &[&str]) -> Vec<String> {
        let labels = self.labels();
        names.iter().filter(|name| labels.contains(name)).map(ToString::to_string).collect()
    }

    fn dimmed(mut self, names: &[String], told: String) -> Self {
        if self.labels().len() <= COLORS {
            return self;
        }
        let all = self.panels.iter_mut().flat_map(|panel| &mut panel.series);
        for series in all.filter(|series| series.mark != Mark::Guide && !names.contains(&series.label)) {
            series.mark = Mark::Other;
        }
        let _ = write!(self.caption, " {told}. The others are grey, and named where one points at them.");
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

    /// Of the series in more than half of the panels that which is below each other one, and that which is above each other one, by their least ordinates in
    /// most of the panels that have both: a curve that is left out of some panels is compared where it is. The least ordinate is the one that does not depend on
    /// where a curve that leaves the axes begins.
    fn extremes(&self) -> Extremes {
        let least = |series: &Series, log: bool| {
            let values = series.points.iter().map(|point| point.1).filter(|y| y.is_finite() && (!log || *y > 0.0));
            values.min_by(f64::total_cmp)
        };
        // Its least ordinate in each panel.
        let of = |label: &str| {
            let in_panel = |panel: &Panel| {
                let series = panel.series.iter().find(|series| series.label == label && series.mark != Mark::Guide)?;
                least(series, panel.y.log)
            };
            self.panels.iter().map(in_panel).collect::<Vec<_>>()
        };
        let panels = self.panels.len();
        let is_common = |found: &[Option<f64>]| 2 * found.iter().flatten().count() > panels;
        let all: Vec<_> = self.labels().into_iter().map(|label| (label, of(label))).collect();
        let all: Vec<_> = all.into_iter().filter(|(_, found)| is_common(found)).collect();
        let is_below = |a: &[Option<f64>], b: &[Option<f64>]| {
            let shared = || a.iter().zip(b).filter_map(|(a, b)| Some(((*a)?, (*b)?)));
            2 * shared().filter(|(a, b)| a < b).count() > shared().count()
        };
        type Known<'a> = (&'a str, Vec<Option<f64>>);
        let extreme = |is_it: &dyn Fn(&Known<'_>, &Known<'_>) -> bool| {
            let is_first = |one: &&Known<'_>| all.iter().all(|other| other.0 == one.0 || is_it(one, other));
            all.iter().find(is_first).filter(|_| all.len() > 1).map(|(label, _)| (*label).to_owned())
        };
        let best = extreme(&|one, other| is_below(&one.1, &other.1));
        let worst = extreme(&|one, other| is_below(&other.1, &one.1));
        Extremes { best, worst, of: all.len(), panels }
    }
}

/// The series below and above each other one, if there are such, of so many in most panels.
struct Extremes {
    best: Option<String>,
    worst: Option<String>,
    of: usize,
    panels: usize,
}

/// Names in a sentence.
fn listed(names: &[String]) -> String {
    let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    names.join(", ")
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
    fn a_crowded_figure_tells_those_apart_that_it_names_and_the_best_and_the_worst() {
        let figure = crowded().telling_with_extremes(&["m5", "m3"]);
        assert_eq!(marked(&figure, |mark| mark == Mark::LineMarkers), ["m3", "m5", "m7"]);
        assert_eq!(marked(&figure, |mark| mark == Mark::Guide), ["slope 2"]);
        assert_eq!(marked(&figure, |mark| mark == Mark::Other), ["m1", "m2", "m4", "m6", "m8", "m9", "m0"]);
        for words in [
            "In colour: `m5`, `m3`;",
            "of the 9 curves that are in most of the 2 panels the least error of `m3` is smaller than that of each other one and the least error \
             of `m7` is larger than that of each other one, in most panels that show both",
        ] {
            assert!(figure.caption.contains(words), "{words}: {}", figure.caption);
        }
        // One in all panels is neither the best nor the worst.
        let mut alone = crowded();
        alone.panels[0].series.retain(|series| series.label == "m4");
        let alone = alone.telling_with_extremes(&["m5"]);
        assert!(!alone.caption.contains("error"), "{}", alone.caption);
        // One that is left out of a panel is compared in the others.
        let mut three = crowded();
        three.panels.push(three.panels[0].clone());
        three.panels[0].series.retain(|series| series.label != "m3");
        assert!(three.telling_with_extremes(&["m5"]).caption.contains("the least error of `m3` is smaller"));
        // None where each is beaten by some other.
        let heights = [[1.0, 2.0, 3.0], [2.0, 3.0, 1.0], [3.0, 1.0, 2.0]];
        let panel = |k: usize| {
            let curves =
                heights.iter().enumerate().map(|(i, y)| Series::new(format!("r{i}"), vec![(1.0, y[k])], Mark::Line));
            Panel::new(Axis::log("h"), Axis::log("error"), curves.collect())
        };
        let round = Figure::new("id", "", "data", [0, 1, 2].map(panel)).extremes();
        assert_eq!((round.best, round.worst, round.of), (None, None, 3));
        let figure = crowded().telling(&["m5"]);
        assert_eq!(marked(&figure, |mark| mark == Mark::LineMarkers), ["m5"]);
        assert!(figure.caption.starts_with("A caption. In colour: `m5`. The others"), "{}", figure.caption);
    }

    #[test]
    fn a_figure_with_colours_for_all_stays_as_it_is() {
        let mut figure = crowded();
        for panel in &mut figure.panels {
            panel.series.retain(|series| !["m0", "m9"].contains(&series.label.as_str()));
        }
        let told = figure.clone().telling_with_extremes(&["m5"]);
        assert_eq!(told.caption, figure.caption);
        assert!(marked(&told, |mark| mark == Mark::Other).is_empty());
    }
}
