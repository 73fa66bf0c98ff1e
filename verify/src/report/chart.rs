//! One panel as inline SVG: axes, curves, clouds and maps.
//!
//! Colours are classes of the page, so that one drawing serves light and dark, screen and paper. Coordinates are whole
//! numbers of quarter pixels, written as differences: thousands of points stay small. A map shows its samples as cells, and
//! nothing between them.

use std::fmt::Write;

use super::style::{Style, band};
use super::text::escape;
use crate::evidence::number::{digits, power_of_ten, short};
use crate::evidence::{Axis, Field, Mark, Panel, Series};

/// Units of the drawing in a pixel.
const FINE: f64 = 4.0;
/// Room above and to the right of the axes, and below them.
const TOP: f64 = 8.0;
const RIGHT: f64 = 16.0;
const BOTTOM: f64 = 46.0;

/// A series of no more points than these tells the values of each under the pointer, a longer one its name alone.
const POINTED: usize = 64;

/// A drawn panel.
pub(super) struct Drawing {
    /// An `svg` element.
    pub(super) svg: String,
    /// Number of points that the axes have no place for.
    pub(super) dropped: usize,
}

/// Width and height of a panel in a figure with this many in a row: the more, the smaller, so that the lettering keeps its
/// size on a wide page.
pub(super) fn size(columns: usize) -> (f64, f64) {
    if columns > 2 { (370.0, 290.0) } else { (470.0, 340.0) }
}

/// Draws a panel of a figure with so many columns. `None` if nothing in it can be drawn.
pub(super) fn panel(panel: &Panel, styles: &[Style], columns: usize) -> Option<Drawing> {
    let (width, mut height) = size(columns);
    let [x, y] = scales(panel)?;
    let (x_ticks, y_ticks) = (x.ticks(6), y.ticks(7));
    let widest = y_ticks.iter().map(|(_, label)| label.chars().count()).max().unwrap_or(0);
    let left = 30.0 + 7.2 * widest as f64;
    // A map of a square is one.
    if panel.field.as_ref().is_some_and(|field| field.x == field.y) {
        height = width - left - RIGHT + TOP + BOTTOM;
    }
    let frame = Frame { left, width: width - left - RIGHT, height: height - TOP - BOTTOM, x, y };
    let mut svg =
        format!("<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\">", escape(&description(panel)));
    frame.axes(&mut svg, panel, &x_ticks, &y_ticks);
    // What reaches beyond the axes is cut off by an element of their size.
    let _ = write!(
        svg,
        "<svg x=\"{left:.0}\" y=\"{TOP}\" width=\"{:.0}\" height=\"{:.0}\" overflow=\"hidden\"><g transform=\"scale({})\">",
        frame.width,
        frame.height,
        1.0 / FINE
    );
    if let Some(field) = &panel.field {
        frame.cells(&mut svg, field);
        if field.contours {
            frame.contours(&mut svg, field);
        }
    }
    let mut dropped = 0;
    let (mut markers, mut hits) = (String::new(), String::new());
    let drawn = || panel.series.iter().zip(styles);
    let is_other = |series: &Series| series.mark == Mark::Other;
    let behind = drawn().filter(|(series, _)| is_other(series));
    for (series, style) in behind.chain(drawn().filter(|(series, _)| !is_other(series))) {
        let has_place = |point: &&(f64, f64)| frame.x.holds(point.0) && frame.y.holds(point.1);
        dropped += series.points.iter().filter(|point| !has_place(point)).count();
        if series.mark != Mark::Markers {
            let runs = series.points.split(|point| !has_place(&point)).filter(|run| !run.is_empty());
            let d: String = runs.map(|run| polyline(run.iter().map(|point| frame.place(point)))).collect();
            let _ = write!(svg, "<path {} d=\"{d}\"><title>{}</title></path>", style.line(), escape(&series.label));
        }
        if matches!(series.mark, Mark::Markers | Mark::LineMarkers) {
            let _ = write!(markers, "<path {} d=\"", style.markers());
            for (x, y) in series.points.iter().filter(has_place).map(|point| frame.place(point)) {
                let _ = write!(markers, "M{} {}{}", x / FINE as i64, y / FINE as i64, style.shape.path());
            }
            markers.push_str("\"/>");
        }
        if series.mark != Mark::Guide && series.points.len() <= POINTED {
            for point in series.points.iter().filter(has_place) {
                let (x, y) = frame.place(point);
                let _ = write!(
                    hits,
                    "<path d=\"M{} {}h0\"><title>{}: {}, {}</title></path>",
                    x / FINE as i64,
                    y / FINE as i64,
                    escape(&series.label),
                    short(point.0),
                    short(point.1)
                );
            }
        }
    }
    // Markers lie over all lines, in whole pixels, and over these what the pointer finds.
    let _ = write!(svg, "</g>{markers}<g class=\"hit\">{hits}</g></svg></svg>");
    Some(Drawing { svg, dropped })
}

/// Points as differences, those that fall together left out, and those within one column cut to its lowest and highest.
fn polyline(points: impl Iterator<Item = (i64, i64)>) -> String {
    let mut kept: Vec<(i64, i64)> = Vec::new();
    for point in points {
        match kept.as_slice() {
            [.., last] if *last == point => {}
            // Up or down the same column further on in the same direction.
            [.., before, last]
                if before.0 == point.0 && last.0 == point.0 && (last.1 - before.1) * (point.1 - last.1) > 0 =>
            {
                kept.pop();
                kept.push(point);
            }
            [.., a, b, c] if a.0 == point.0 && b.0 == point.0 && c.0 == point.0 => {
                let (low, high) = (b.1.min(c.1).min(point.1), b.1.max(c.1).max(point.1));
                let column = point.0;
                kept.truncate(kept.len() - 2);
                kept.extend([(column, low), (column, high)]);
            }
            _ => kept.push(point),
        }
    }
    let Some((&(x, y), rest)) = kept.split_first() else { return String::new() };
    let mut d = format!("M{x} {y}");
    if rest.is_empty() {
        d.push_str("h1");
    }
    let (mut last, mut is_first) = ((x, y), true);
    for &(x, y) in rest {
        let (dx, dy) = (x - last.0, y - last.1);
        let separator = if is_first {
            "l"
        } else if dx < 0 {
            ""
        } else {
            " "
        };
        let _ = write!(d, "{separator}{dx}{}{dy}", if dy < 0 { "" } else { " " });
        (last, is_first) = ((x, y), false);
    }
    d
}

fn description(panel: &Panel) -> String {
    let axis = |axis: &Axis| format!("{}{}", axis.label, if axis.log { " (logarithmic)" } else { "" });
    let mut text = format!("{} over {}", axis(&panel.y), axis(&panel.x));
    if !panel.title.is_empty() {
        text = format!("{}: {text}", panel.title);
    }
    if let Some(field) = &panel.field {
        let _ = write!(text, ". Map of {}", field.bands.join(", "));
    }
    if !panel.series.is_empty() {
        let (others, named): (Vec<_>, Vec<_>) = panel.series.iter().partition(|series| series.mark == Mark::Other);
        let mut labels: Vec<_> = named.iter().map(|series| series.label.clone()).collect();
        if !others.is_empty() {
            labels.push(super::style::others(others.len()));
        }
        let _ = write!(text, ". Series: {}", labels.join(", "));
    }
    text + "."
}

/// Where values lie on an axis: between 0 and 1.
struct Scale {
    log: bool,
    low: f64,
    high: f64,
}

fn scales(panel: &Panel) -> Option<[Scale; 2]> {
    if let Some(field) = &panel.field {
        // A map fills its axes; series on it do not widen them.
        let scale = |axis: &Axis, grid: &[f64]| Scale::new(axis, grid.iter().copied(), true);
        return match field.is_rectangular() {
            true => Some([scale(&panel.x, &field.x)?, scale(&panel.y, &field.y)?]),
            false => None,
        };
    }
    let has_place = |point: &&(f64, f64)| holds(panel.x.log, point.0) && holds(panel.y.log, point.1);
    let points = || panel.series.iter().flat_map(|series| &series.points).filter(has_place);
    points().next()?;
    Some([
        Scale::new(&panel.x, points().map(|point| point.0), false)?,
        Scale::new(&panel.y, points().map(|point| point.1), false)?,
    ])
}

/// Whether an axis has a place for a value. Within these bounds no span between two values overflows.
fn holds(log: bool, value: f64) -> bool {
    if log { (1e-140..1e140).contains(&value) } else { value.abs() < 1e140 }
}

impl Scale {
    /// `None` if no value has a place on the axis.
    fn new(axis: &Axis, values: impl Iterator<Item = f64>, is_tight: bool) -> Option<Self> {
        let range = |range: Option<(f64, f64)>, value: f64| {
            let (low, high) = range.unwrap_or((value, value));
            Some((value.min(low), value.max(high)))
        };
        let (low, high) = axis.limits.or_else(|| values.fold(None, range))?;
        if !holds(axis.log, low) || !holds(axis.log, high) || low > high {
            return None;
        }
        let (low, high) = if axis.log { (low.log10(), high.log10()) } else { (low, high) };
        let is_tight = (is_tight || axis.limits.is_some()) && low < high;
        // A little room at both ends, so that markers are drawn whole; for one value, as much as its size.
        let margin = match (is_tight, low == high) {
            (true, _) => 0.0,
            (false, true) => {
                if axis.log {
                    0.6
                } else {
                    0.1 * low.abs().max(1e-9)
                }
            }
            (false, false) => 0.04 * (high - low),
        };
        Some(Self { log: axis.log, low: low - margin, high: high + margin })
    }

    fn holds(&self, value: f64) -> bool {
        holds(self.log, value)
    }

    /// 0 at the lower end, 1 at the upper one.
    fn place(&self, value: f64) -> f64 {
        let value = if self.log { value.log10() } else { value };
        (value - self.low) / (self.high - self.low)
    }

    /// Places and labels of about `count` ticks.
    fn ticks(&self, count: usize) -> Vec<(f64, String)> {
        let span = self.high - self.low;
        let place = |value: f64| (value - self.low) / span;
        if self.log && span >= 1.0 {
            let stride = (span / count as f64).ceil().max(1.0);
            let is_plain = self.low >= -3.1 && self.high <= 3.1;
            let label = |exponent: i32| match is_plain {
                // Through text, since ten to a negative power is not exact.
                true => short(format!("1e{exponent}").parse().unwrap_or(1.0)),
                false => power_of_ten(exponent),
            };
            let mut ticks: Vec<_> = within(self.low, self.high, stride)
                .map(|k| k as f64 * stride)
                .map(|exponent| (place(exponent), label(exponent as i32)))
                .collect();
            if ticks.len() < 3 {
                // Few decades: twice and five times each as well.
                let decades = self.low.floor() as i32..=self.high.ceil() as i32;
                let between = decades.flat_map(|k| [2, 5].map(|n| (n, k)));
                let inside = between.map(|(n, k)| (f64::from(n).log10() + f64::from(k), n, k));
                let inside = inside.filter(|(value, ..)| (self.low..=self.high).contains(value));
                ticks.extend(inside.map(|(value, n, k)| {
                    let label = short(format!("{n}e{k}").parse().unwrap_or(1.0));
                    (place(value), label)
                }));
            }
            return ticks;
        }
        // 1, 2 or 5 times a power of ten apart; within a decade of a logarithmic axis too, where round numbers serve best.
        let (low, high) =
            if self.log { (10_f64.powf(self.low), 10_f64.powf(self.high)) } else { (self.low, self.high) };
        let raw = (high - low) / count as f64;
        let power = 10_f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|n| n * power).find(|step| *step >= raw).unwrap_or(power);
        // Ticks are multiples of steps; six digits are what they are meant to be.
        let label = |value: f64| digits(format!("{value:.5e}").parse().unwrap_or(value), 6);
        within(low, high, step).map(|k| k as f64 * step).map(|value| (self.place(value), label(value))).collect()
    }
}

/// The multiples of `step` in an interval, as integers.
fn within(low: f64, high: f64, step: f64) -> std::ops::RangeInclusive<i64> {
    (low / step - 1e-9).ceil() as i64..=(high / step + 1e-9).floor() as i64
}

/// The axes on the page.
struct Frame {
    left: f64,
    width: f64,
    height: f64,
    x: Scale,
    y: Scale,
}

impl Frame {
    /// Where a point lies within the axes, in quarters of a pixel; far out, where it can no longer be seen.
    fn place(&self, point: &(f64, f64)) -> (i64, i64) {
        let far = |place: f64| place.clamp(-20.0, 21.0);
        let x = far(self.x.place(point.0)) * self.width * FINE;
        let y = (1.0 - far(self.y.place(point.1))) * self.height * FINE;
        (x.round() as i64, y.round() as i64)
    }

    /// Grid, labels and the names of the axes.
    fn axes(&self, svg: &mut String, panel: &Panel, x_ticks: &[(f64, String)], y_ticks: &[(f64, String)]) {
        let (left, bottom) = (self.left, TOP + self.height);
        let mut grid = String::new();
        let mut labels = String::new();
        for (place, label) in x_ticks {
            let x = left + place * self.width;
            let _ = write!(grid, "M{x:.1} {TOP}v{:.0}", self.height);
            let _ =
                write!(labels, "<text x=\"{x:.1}\" y=\"{:.0}\" text-anchor=\"middle\">{label}</text>", bottom + 16.0);
        }
        for (place, label) in y_ticks {
            let y = TOP + (1.0 - place) * self.height;
            let _ = write!(grid, "M{left:.1} {y:.1}h{:.0}", self.width);
            let _ =
                write!(labels, "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>", left - 5.0, y + 4.0);
        }
        let middle = TOP + 0.5 * self.height;
        let _ = write!(
            svg,
            "<path class=\"grid\" d=\"{grid}\"/><path class=\"axis\" d=\"M{left:.1} {TOP}v{:.0}h{:.0}\"/>{labels}\
             <text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"middle\">{}</text>\
             <text transform=\"translate(14 {middle:.0})rotate(-90)\" text-anchor=\"middle\">{}</text>",
            self.height,
            self.width,
            left + 0.5 * self.width,
            bottom + 38.0,
            escape(&panel.x.label),
            escape(&panel.y.label)
        );
    }

    /// The cells around the grid points, one path a band, neighbours in a row joined.
    fn cells(&self, svg: &mut String, field: &Field) {
        let edges = |places: Vec<i64>| {
            let middle = places.windows(2).map(|pair| (pair[0] + pair[1]) / 2);
            let ends = places.first().copied().zip(places.last().copied());
            let (first, last) = ends.unwrap_or_default();
            [first].into_iter().chain(middle).chain([last]).collect::<Vec<_>>()
        };
        let across = edges(field.x.iter().map(|x| self.place(&(*x, field.y[0])).0).collect());
        let down = edges(field.y.iter().map(|y| self.place(&(field.x[0], *y)).1).collect());
        let band_of = |value: &f64| value.is_finite().then(|| field.levels.partition_point(|level| level <= value));
        let mut paths = vec![String::new(); field.levels.len() + 1];
        for (row, height) in field.values.iter().zip(down.windows(2)) {
            let row: Vec<_> = row.iter().map(band_of).collect();
            let mut begin = 0;
            for stretch in row.chunk_by(|a, b| a == b) {
                let end = begin + stretch.len();
                if let Some(band) = stretch[0] {
                    let (x, wide) = (across[begin], across[end] - across[begin]);
                    let _ = write!(paths[band], "M{x} {}h{wide}V{}h{}z", height[0], height[1], -wide);
                }
                begin = end;
            }
        }
        for (index, d) in paths.into_iter().enumerate().filter(|(_, d)| !d.is_empty()) {
            let _ = write!(svg, "<path class=\"{}\" d=\"{d}\"/>", band(index, &field.levels, field.contours));
        }
    }

    /// Lines at the levels, straight within each cell of four samples, on whose edges they are interpolated.
    fn contours(&self, svg: &mut String, field: &Field) {
        let mut d = String::new();
        for level in &field.levels {
            for (j, rows) in field.values.windows(2).enumerate() {
                for i in 0..field.x.len().saturating_sub(1) {
                    let at = |di: usize, dj: usize| (field.x[i + di], field.y[j + dj], rows[dj][i + di]);
                    let corners = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
                    // A pole or a hole is no level; nothing is drawn beside it.
                    if corners.iter().any(|corner| !corner.2.is_finite()) {
                        continue;
                    }
                    let crossings = (0..4).filter_map(|k| {
                        let (a, b) = (corners[k], corners[(k + 1) % 4]);
                        ((a.2 < *level) != (b.2 < *level)).then(|| {
                            let share = (level - a.2) / (b.2 - a.2);
                            self.place(&(a.0 + share * (b.0 - a.0), a.1 + share * (b.1 - a.1)))
                        })
                    });
                    let crossings: Vec<_> = crossings.collect();
                    for pair in crossings.chunks_exact(2) {
                        let _ = write!(d, "M{} {}L{} {}", pair[0].0, pair[0].1, pair[1].0, pair[1].1);
                    }
                }
            }
        }
        let _ = write!(svg, "<path class=\"contour\" d=\"{d}\"/>");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(log: bool) -> Axis {
        Axis { log, ..Axis::linear("") }
    }

    #[test]
    fn axes_begin_near_their_data() {
        for (values, log) in [([0.0, 1.0], false), ([1e-12, 1.0], true), ([3.0, 3.0], false), ([5.0, 5.0], true)] {
            let scale = Scale::new(&axis(log), values.into_iter(), false).expect("numbers");
            for value in values {
                assert!((0.0..=1.0).contains(&scale.place(value)), "{values:?}");
            }
            assert!(values[0] == values[1] || scale.place(values[0]) < 0.05 && scale.place(values[1]) > 0.95);
        }
        assert!(Scale::new(&axis(true), [0.0, 1.0].into_iter(), false).is_none());
        assert!(Scale::new(&axis(false), std::iter::empty(), false).is_none());
    }

    #[test]
    fn larger_values_lie_further_to_the_right_and_higher() {
        let scale = || Scale { log: false, low: 0.0, high: 1.0 };
        let frame = Frame { left: 0.0, width: 100.0, height: 50.0, x: scale(), y: scale() };
        // From the upper left corner, in quarters.
        assert_eq!(
            [(0.0, 0.0), (1.0, 1.0), (0.5, 1.0)].map(|point| frame.place(&point)),
            [(0, 200), (400, 0), (200, 0)]
        );
    }

    #[test]
    fn points_without_a_place_are_counted_in_every_series() {
        let series = |points: &[(f64, f64)]| Series::new("s", points.to_vec(), Mark::Markers);
        let log = Axis { log: true, ..Axis::linear("") };
        let all = vec![series(&[(1.0, 1.0), (2.0, 0.0), (3.0, -1.0)]), series(&[(1.0, 2.0), (2.0, f64::NAN)])];
        let panel = Panel::new(Axis::linear(""), log, all);
        let style = super::super::style::Palette(&[]).style("s", 0, Mark::Markers);
        let drawing = super::panel(&panel, &[style; 2], 1).expect("some have one");
        assert_eq!(drawing.dropped, 3);
    }

    #[test]
    fn ticks_are_few_round_and_within_the_axis() {
        let labels = |low: f64, high: f64, log: bool| {
            let scale = Scale::new(&Axis { limits: Some((low, high)), ..axis(log) }, std::iter::empty(), true);
            let ticks = scale.expect("numbers").ticks(6);
            assert!((2..=8).contains(&ticks.len()), "{ticks:?}");
            assert!(ticks.iter().all(|(place, _)| (-1e-9..=1.0 + 1e-9).contains(place)));
            ticks.into_iter().map(|(_, label)| label).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(labels(0.0, 10.0, false), "0 2 4 6 8 10");
        assert_eq!(labels(-0.5, 0.5, false), "−0.4 −0.2 0 0.2 0.4");
        assert_eq!(labels(1e-16, 1.0, true), "10⁻¹⁵ 10⁻¹² 10⁻⁹ 10⁻⁶ 10⁻³ 10⁰");
        assert_eq!(labels(0.001, 10.0, true), "0.001 0.01 0.1 1 10");
        assert_eq!(labels(0.1, 1.0, true), "0.1 1 0.2 0.5");
        assert_eq!(labels(0.0375, 0.0926, true), "0.04 0.05 0.06 0.07 0.08 0.09");
    }

    #[test]
    fn a_curve_keeps_its_shape_in_fewer_points() {
        let wave = (0..1000).map(|i| (i / 100, if i % 2 == 0 { 0 } else { 10 + i % 7 }));
        let d = polyline(wave);
        assert!(d.len() < 200 && d.starts_with("M0 0l"), "{d}");
        assert_eq!(polyline([(0, 0), (0, 0), (3, -2), (1, 5)].into_iter()), "M0 0l3-2-2 7");
        assert_eq!(polyline([(4, 5)].into_iter()), "M4 5h1");
    }
}
