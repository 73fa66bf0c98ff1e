//! One panel as inline SVG.
//!
//! kuva draws it; colours are CSS variables of the page, so that one drawing serves light and dark, screen and paper. Two
//! things are done around it. kuva's logarithmic axes end at 1e-10, far above the errors shown here, so data are shifted by
//! whole decades before and labels back after. And its maps interpolate between samples, which would invent values between
//! categories, so the cells of a [`Field`] are drawn here.

use std::fmt::Write;
use std::sync::Arc;

use kuva::backend::svg::SvgBackend;
use kuva::plot::scatter::MarkerShape;
use kuva::plot::{ContourPlot, LinePlot, ScatterPlot};
use kuva::render::layout::{AxisLabelOverlap, ComputedLayout, Layout, TickFormat};
use kuva::render::plots::Plot;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor, render_multiple};
use kuva::render::render_utils::{auto_nice_range, generate_ticks, generate_ticks_log, wrap_text};
use kuva::render::theme::Theme;

use super::svg::compact;
use super::text::escape;
use crate::evidence::number::{Short, power_of_ten};
use crate::evidence::{Axis, Field, Mark, Panel, Series};

/// Width and height of a panel in a figure with this many in a row: the more, the smaller, so that the lettering keeps its
/// size on a wide page.
fn size(columns: usize) -> (f64, f64) {
    if columns > 2 { (370.0, 300.0) } else { (470.0, 350.0) }
}

const LABEL_SIZE: f64 = 14.0;
const TICK_SIZE: f64 = 13.0;

/// Colour, dash and marker of a series, by its place in the figure's legend.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Style {
    index: usize,
    mark: Mark,
}

impl Style {
    const COLORS: usize = 8;
    const DASHES: [&str; 5] = ["", "8 4", "2 3", "8 3 2 3", "12 3 2 3 2 3"];
    const MARKERS: [MarkerShape; 7] = [
        MarkerShape::Circle,
        MarkerShape::Square,
        MarkerShape::Triangle,
        MarkerShape::Diamond,
        MarkerShape::TriangleDown,
        MarkerShape::Cross,
        MarkerShape::Plus,
    ];

    /// `index` counts guides and other series apart.
    pub(super) fn new(index: usize, mark: Mark) -> Self {
        Self { index, mark }
    }

    fn color(self) -> String {
        match self.mark {
            Mark::Guide => "var(--guide)".into(),
            _ => format!("var(--s{})", self.index % Self::COLORS),
        }
    }

    fn dash(self) -> &'static str {
        let pattern = match self.mark {
            Mark::Guide => 1 + self.index % (Self::DASHES.len() - 1),
            // Markers tell these apart; dashes join in when the colours repeat.
            Mark::LineMarkers => self.index / Self::COLORS % Self::DASHES.len(),
            Mark::Line | Mark::Markers => self.index % Self::DASHES.len(),
        };
        Self::DASHES[pattern]
    }

    fn width(self) -> f64 {
        if self.is_guide() { 1.2 } else { 1.9 }
    }

    fn marker(self) -> Option<MarkerShape> {
        let has_marker = matches!(self.mark, Mark::LineMarkers | Mark::Markers);
        // Seven shapes against eight colours: the pair repeats after 56 series only.
        has_marker.then(|| Self::MARKERS[self.index % Self::MARKERS.len()])
    }

    fn has_line(self) -> bool {
        self.mark != Mark::Markers
    }

    /// The same colour for another mark.
    pub(super) fn with_mark(self, mark: Mark) -> Self {
        Self { mark, ..self }
    }

    pub(super) fn is_guide(self) -> bool {
        self.mark == Mark::Guide
    }

    /// A small drawing of the style for a legend.
    pub(super) fn swatch(self) -> String {
        let color = self.color();
        let mut svg = String::from(
            "<svg class=\"swatch\" viewBox=\"0 0 34 14\" width=\"34\" height=\"14\" aria-hidden=\"true\">",
        );
        if self.has_line() {
            let _ = write!(
                svg,
                "<path d=\"M1 7H33\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{}\" stroke-dasharray=\"{}\"/>",
                self.width(),
                self.dash()
            );
        }
        let d = match self.marker() {
            None => "",
            Some(MarkerShape::Circle) => "M13 7a4 4 0 1 0 8 0a4 4 0 1 0-8 0Z",
            Some(MarkerShape::Square) => "M13 3h8v8h-8Z",
            Some(MarkerShape::Triangle) => "M17 2l4.5 8h-9Z",
            Some(MarkerShape::Diamond) => "M17 2l4.5 5-4.5 5-4.5-5Z",
            Some(MarkerShape::TriangleDown) => "M17 12l4.5-8h-9Z",
            Some(MarkerShape::Cross) => "M13 3l8 8M13 11l8-8",
            Some(_) => "M17 2v10M12 7h10",
        };
        let _ = write!(svg, "<path d=\"{d}\" fill=\"{color}\" stroke=\"{color}\" stroke-width=\"1.4\"/></svg>");
        svg
    }
}

/// The CSS colour of band `index` of `count`: shades of one hue where the bands are ordered, distinct tints for categories.
pub(super) fn band_color(index: usize, count: usize, is_ordered: bool) -> String {
    const SHADES: usize = 8;
    match is_ordered {
        true => format!("var(--q{})", index * (SHADES - 1) / (count.max(2) - 1)),
        false => format!("var(--c{})", index % SHADES),
    }
}

/// A drawn panel.
pub(super) struct Drawing {
    /// An `svg` element.
    pub(super) svg: String,
    /// Number of points that the axes have no place for.
    pub(super) dropped: usize,
}

/// Draws a panel of a figure with so many columns; `id` becomes part of the identifiers inside. `None` if nothing in it can be
/// drawn.
pub(super) fn panel(panel: &Panel, styles: &[Style], id: &str, columns: usize) -> Option<Drawing> {
    let (x, y) = scales(panel)?;
    let mut plots = Vec::new();
    if let Some(field) = panel.field.as_ref().filter(|field| field.contours) {
        plots.push(contours(field, &x, &y));
    }
    let mut dropped = 0;
    // Markers lie over all lines.
    let mut markers = Vec::new();
    for (series, style) in panel.series.iter().zip(styles) {
        let runs = runs(panel, series, &x, &y);
        dropped += series.points.len() - runs.iter().map(Vec::len).sum::<usize>();
        if let Some(marker) = style.marker() {
            let points = runs.iter().flatten().copied();
            markers.push(Plot::from(
                ScatterPlot::new().with_data(points).with_color(style.color()).with_size(3.4).with_marker(marker),
            ));
        }
        if style.has_line() {
            plots.extend(runs.into_iter().map(|run| line(thinned(run), *style)));
        }
    }
    plots.append(&mut markers);
    if plots.is_empty() {
        // A map alone: kuva needs something to draw axes around, and points on them where they are logarithmic.
        plots.push(LinePlot::new().with_data([(x.low, y.low), (x.high, y.high)]).with_color("none").into());
    }
    let (layout, y_label) = layout(panel, &x, &y, &plots, size(columns));
    let cells = panel.field.as_ref().map(|field| cells(field, &x, &y, &ComputedLayout::from_layout(&layout)));
    let mut scene = render_multiple(plots, layout);
    scene.elements.extend(y_label);
    let at = scene.elements.iter().position(|element| matches!(element, Primitive::ClipStart { .. }));
    scene.elements.splice(at.map_or(0..0, |at| at + 1..at + 1), cells.unwrap_or_default());
    Some(Drawing { svg: embed(&scene, panel, id), dropped })
}

fn line(run: Vec<(f64, f64)>, style: Style) -> Plot {
    let line = LinePlot::new().with_data(run).with_color(style.color()).with_stroke_width(style.width());
    Plot::from(match style.dash() {
        "" => line,
        dash => line.with_line_style(kuva::plot::LineStyle::Custom(dash.into())),
    })
}

/// The layout and the label of the vertical axis. kuva reserves room for tick labels as it would write them, not as they are
/// written here, so the left margin and the label beside it are set here.
fn layout(panel: &Panel, x: &Scale, y: &Scale, plots: &[Plot], size: (f64, f64)) -> (Layout, Vec<Primitive>) {
    let lines = wrap_text(&label(&panel.y), (size.1 / 8.0) as usize);
    let line_height = 1.2 * LABEL_SIZE;
    let left = line_height * lines.len() as f64 + y.tick_width() + 16.0;
    let label_of_y = lines.into_iter().enumerate().map(|(index, content)| Primitive::Text {
        x: LABEL_SIZE + line_height * index as f64,
        y: 0.45 * size.1,
        content,
        size: LABEL_SIZE as u32,
        anchor: TextAnchor::Middle,
        rotate: Some(-90.0),
        bold: false,
        color: None,
    });

    let color = |name: &str| format!("var(--{name})");
    let theme = Theme {
        background: "none".into(),
        axis_color: color("axis"),
        tick_color: color("axis"),
        grid_color: color("grid"),
        text_color: color("ink"),
        font_family: Some("inherit".into()),
        ..Theme::default()
    };
    let mut layout = Layout::auto_from_plots(plots)
        .with_width(size.0)
        .with_height(size.1)
        .with_theme(theme)
        .with_x_label(label(&panel.x))
        .with_x_label_wrap((size.0 / 9.0) as usize)
        .with_label_size(LABEL_SIZE as u32)
        .with_tick_size(TICK_SIZE as u32)
        .with_ticks(TICKS)
        .with_x_label_overlap(AxisLabelOverlap::Thin)
        .with_grid_line_width(0.7)
        .with_x_tick_format(TickFormat::Custom(Arc::new(x.tick_label(7))))
        .with_y_tick_format(TickFormat::Custom(Arc::new(y.tick_label(9))))
        .with_x_axis_min(x.low)
        .with_x_axis_max(x.high)
        .with_y_axis_min(y.low)
        .with_y_axis_max(y.high);
    if x.has_minor_ticks() && y.has_minor_ticks() {
        layout = layout.with_minor_ticks(9);
    }
    layout.show_legend = false;
    layout.show_colorbar = false;
    layout.log_x = x.log;
    layout.log_y = y.log;
    layout.force_margin_left = Some(left);
    // Room for the half of the last tick's label that reaches beyond the axis.
    layout.force_margin_right = Some(20.0);
    (layout, label_of_y.collect())
}

/// kuva escapes markup, lets control characters pass and typesets what stands between dollars.
fn label(axis: &Axis) -> String {
    axis.label.replace(char::is_control, "\u{fffd}").replace('$', "\\$")
}

/// kuva's drawing under an opening tag that scales and that names it for those who cannot see it.
fn embed(scene: &Scene, panel: &Panel, id: &str) -> String {
    let drawn = SvgBackend::new().render_scene(scene);
    let body = drawn.split_once('>').map_or("", |(_, body)| body);
    // kuva numbers clip paths over the life of the process; the page must come out the same every time.
    let mut pieces = body.split("kuva-clip-");
    let mut stable = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let _ = write!(stable, "{id}-clip{}", piece.trim_start_matches(|c: char| c.is_ascii_digit()));
    }
    let title = match panel.title.as_str() {
        "" => format!("{} against {}", panel.y.label, panel.x.label),
        title => title.to_owned(),
    };
    format!(
        "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-labelledby=\"{id}-title {id}-desc\"><title id=\"{id}-title\">{}</title>\
         <desc id=\"{id}-desc\">{}</desc>{}",
        scene.width,
        scene.height,
        escape(&title),
        escape(&description(panel)),
        compact(&stable)
    )
}

fn description(panel: &Panel) -> String {
    let axis = |axis: &Axis| format!("{}{}", axis.label, if axis.log { " (logarithmic)" } else { "" });
    let mut text = format!("Vertical axis: {}. Horizontal axis: {}.", axis(&panel.y), axis(&panel.x));
    if let Some(field) = &panel.field {
        let _ = write!(text, " Map of {}.", field.bands.join(", "));
    }
    if !panel.series.is_empty() {
        let labels: Vec<_> = panel.series.iter().map(|series| series.label.as_str()).collect();
        let _ = write!(text, " Series: {}.", labels.join(", "));
    }
    text
}

/// A linear axis, or a logarithmic one shifted by whole decades to where kuva can draw it.
struct Scale {
    log: bool,
    /// Limits as drawn.
    low: f64,
    high: f64,
    /// Decade of the lower limit.
    decade: i32,
}

/// Major ticks on a linear axis, about.
const TICKS: usize = 6;

impl Scale {
    /// `None` if no value has a place on the axis.
    fn new(axis: &Axis, values: impl Iterator<Item = f64>, is_tight: bool) -> Option<Self> {
        let (low, high) = axis.limits.or_else(|| range(values))?;
        if !holds(axis, low) || !holds(axis, high) || low > high {
            return None;
        }
        let is_tight = (is_tight || axis.limits.is_some()) && low < high;
        if axis.log {
            let (mut first, mut last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
            if first == last {
                (first, last) = (first - 1, last + 1);
            }
            // A little beyond the decades, so that markers on them are drawn whole.
            let (span, margin) = (f64::from(last - first), 0.03 * f64::from(last - first));
            let scale = Self { log: true, low: 10f64.powf(-margin), high: 10f64.powf(span + margin), decade: first };
            return Some(match is_tight {
                true => Self { low: scale.place(low), high: scale.place(high), ..scale },
                false => scale,
            });
        }
        let margin = if low == high { 0.1 * low.abs().max(1.0) } else { 0.03 * (high - low) };
        let (low, high) = if is_tight { (low, high) } else { auto_nice_range(low - margin, high + margin, TICKS) };
        Some(Self { log: false, low, high, decade: 0 })
    }

    /// Where kuva is told to draw a value that the axis has a place for.
    fn place(&self, value: f64) -> f64 {
        if self.log { 10f64.powf(value.log10() - f64::from(self.decade)) } else { value }
    }

    /// Whether nine parts between two ticks are 2, 3, … 9 times the lower one, and not too many. On fewer decades kuva puts ticks
    /// at 2 and 5 of its own accord.
    fn has_minor_ticks(&self) -> bool {
        self.log && (1e2..1e8).contains(&(self.high / self.low))
    }

    /// Labels at most about `count` ticks of a logarithmic axis.
    fn tick_label(&self, count: i32) -> impl Fn(f64) -> String + Send + Sync + use<> {
        let (log, first) = (self.log, self.decade);
        let last = first + if log { self.high.log10().floor() as i32 } else { 0 };
        let stride = ((last - first + count - 1) / count).max(1);
        let is_plain = first >= -3 && last <= 3;
        move |value: f64| {
            if !log {
                // Ticks are sums of steps; six digits are what they are meant to be.
                return Short::new(format!("{value:.5e}").parse().unwrap_or(value), 6).text();
            }
            let decade = (value.log10() + 1e-9).floor();
            let leading = (value / 10f64.powf(decade)).round();
            let exponent = decade as i32 + first;
            match leading == 1.0 {
                true if exponent.rem_euclid(stride) != 0 => String::new(),
                true if !is_plain => power_of_ten(exponent),
                false if !is_plain => format!("{leading}×{}", power_of_ten(exponent)),
                // Through text, since ten to a negative power is not exact.
                _ => Short::new(format!("{leading}e{exponent}").parse().unwrap_or(leading), 4).text(),
            }
        }
    }

    /// Width of the widest label of a vertical axis.
    fn tick_width(&self) -> f64 {
        let ticks = match self.log {
            true => generate_ticks_log(self.low, self.high),
            false => generate_ticks(self.low, self.high, TICKS),
        };
        // Digits of common sans-serif faces are 0.64 em wide at most, raised ones two thirds of that.
        let width = |c: char| if c.is_ascii() || c == '−' || c == '×' { 0.64 } else { 0.43 };
        let widths = ticks.into_iter().map(self.tick_label(9)).map(|label| label.chars().map(width).sum());
        TICK_SIZE * widths.fold(0.0, f64::max)
    }
}

/// Whether an axis has a place for a value. Within these bounds no span between two values overflows.
fn holds(axis: &Axis, value: f64) -> bool {
    if axis.log { (1e-140..1e140).contains(&value) } else { value.abs() < 1e140 }
}

fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |range, value| {
        let (low, high) = range.unwrap_or((value, value));
        Some((value.min(low), value.max(high)))
    })
}

fn scales(panel: &Panel) -> Option<(Scale, Scale)> {
    if let Some(field) = &panel.field {
        if !field.is_rectangular() {
            return None;
        }
        // A map fills its axes; series on it do not widen them.
        let scale = |axis: &Axis, grid: &[f64]| Scale::new(axis, grid.iter().copied(), true);
        return Some((scale(&panel.x, &field.x)?, scale(&panel.y, &field.y)?));
    }
    let points = || panel.series.iter().flat_map(|series| &series.points).filter(|point| has_place(panel, point));
    let x = Scale::new(&panel.x, points().map(|point| point.0), false)?;
    let y = Scale::new(&panel.y, points().map(|point| point.1), false)?;
    points().next().map(|_| (x, y))
}

fn has_place(panel: &Panel, point: &(f64, f64)) -> bool {
    holds(&panel.x, point.0) && holds(&panel.y, point.1)
}

/// The stretches of a series between points that have no place on the axes.
fn runs(panel: &Panel, series: &Series, x: &Scale, y: &Scale) -> Vec<Vec<(f64, f64)>> {
    let runs = series.points.split(|point| !has_place(panel, point)).filter(|run| !run.is_empty());
    runs.map(|run| run.iter().map(|point| (x.place(point.0), y.place(point.1))).collect()).collect()
}

/// A line of very many points, cut to its first, last, lowest and highest within every block: what a screen can show.
fn thinned(run: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    const BLOCKS: usize = 1000;
    if run.len() <= 4 * BLOCKS {
        return run;
    }
    let mut kept = Vec::with_capacity(4 * BLOCKS);
    for block in run.chunks(run.len().div_ceil(BLOCKS)) {
        let by_height = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let index = |point: &(f64, f64)| block.iter().position(|other| other == point);
        let extremes = [block.iter().min_by(by_height), block.iter().max_by(by_height)];
        let mut indices = vec![0, block.len() - 1];
        indices.extend(extremes.into_iter().flatten().filter_map(index));
        indices.sort_unstable();
        indices.dedup();
        kept.extend(indices.into_iter().map(|index| block[index]));
    }
    kept
}

fn contours(field: &Field, x: &Scale, y: &Scale) -> Plot {
    let places = |values: &[f64], scale: &Scale| values.iter().map(|value| scale.place(*value)).collect();
    // A pole or a hole is above every level; interpolating towards it must not end in a coordinate that is not a number.
    let bounded =
        |value: &f64| if value.is_nan() { f64::MAX / 2.0 } else { value.clamp(f64::MIN / 2.0, f64::MAX / 2.0) };
    let values = field.values.iter().map(|row| row.iter().map(bounded).collect()).collect();
    let plot = ContourPlot::new()
        .with_grid(values, places(&field.x, x), places(&field.y, y))
        .with_levels(&field.levels)
        .with_line_color("var(--ink)")
        .with_line_width(1.0);
    Plot::from(plot)
}

/// The cells around the grid points, one path a band, neighbours in a row joined.
fn cells(field: &Field, x: &Scale, y: &Scale, computed: &ComputedLayout) -> Vec<Primitive> {
    let edges = |positions: Vec<f64>| {
        let middle = positions.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        let first = positions.first().into_iter().copied();
        let last = positions.last().into_iter().copied();
        first.chain(middle).chain(last).collect::<Vec<_>>()
    };
    let across = edges(field.x.iter().map(|value| computed.map_x(x.place(*value))).collect());
    let down = edges(field.y.iter().map(|value| computed.map_y(y.place(*value))).collect());
    let band = |value: &f64| value.is_finite().then(|| field.levels.partition_point(|level| level <= value));
    let mut paths = vec![String::new(); field.levels.len() + 1];
    for (row, height) in field.values.iter().zip(down.windows(2)) {
        let row: Vec<_> = row.iter().take(across.len().saturating_sub(1)).map(band).collect();
        let mut begin = 0;
        for stretch in row.chunk_by(|a, b| a == b) {
            let end = begin + stretch.len();
            if let Some(band) = stretch[0] {
                let _ = write!(
                    paths[band],
                    "M{:.1} {:.1}H{:.1}V{:.1}H{:.1}Z",
                    across[begin], height[0], across[end], height[1], across[begin]
                );
            }
            begin = end;
        }
    }
    let count = paths.len();
    let paths = paths.into_iter().enumerate().filter(|(_, d)| !d.is_empty());
    let fill = |band| kuva::render::color::Color::from(band_color(band, count, field.contours));
    paths
        .map(|(band, d)| {
            let stroke_dasharray = None;
            // A hair of stroke closes the seams that anti-aliasing leaves between cells.
            let data = PathData {
                d,
                fill: Some(fill(band)),
                stroke: fill(band),
                stroke_width: 0.4,
                opacity: None,
                stroke_dasharray,
            };
            Primitive::Path(Box::new(data))
        })
        .collect()
}
