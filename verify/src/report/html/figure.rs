//! Figures with their legends.

use std::borrow::Cow;
use std::collections::BTreeSet;

use maud::{Markup, PreEscaped, html};

use super::super::chart;
use super::super::style::{self, Palette, Style, band};
use super::super::text::anchor;
use super::chapter::data_link;
use super::{inline, permalink};
use crate::evidence::{Figure, Mark, Series};

pub(super) fn figure(figure: &Figure, palette: Palette<'_>, count: &mut usize) -> Markup {
    *count += 1;
    let id = anchor(&format!("figure:{}", figure.id));
    let columns = figure.columns.clamp(1, figure.panels.len().max(1));
    let legend = Legend::of(figure, palette);
    html! {
        figure id=(id) {
            // The legend keeps in sight beside the panels, and never covers the caption.
            div {
                (legend.write())
                div.panels.(format!("columns-{}", columns.min(4))) {
                    @for panel in &figure.panels {
                        @let styles: Vec<_> = panel.series.iter().map(|series| legend.style(series)).collect();
                        div.panel {
                            @if !panel.title.is_empty() { p.title { (inline(&panel.title)) } }
                            @match chart::panel(panel, &styles, columns) {
                                Some(drawing) => {
                                    (PreEscaped(drawing.svg))
                                    @if drawing.dropped > 0 {
                                        p.dropped {
                                            "Without " (drawing.dropped) (if drawing.dropped == 1 { " point" } else { " points" })
                                            " that the axes have no place for (zero or less on a logarithmic axis, or not finite)."
                                        }
                                    }
                                    @for (hidden, by) in coincident(panel) {
                                        p.dropped { (inline(hidden)) " lies on " (inline(by)) "." }
                                    }
                                }
                                None => { p.empty { "Nothing to draw: no point is finite and has a place on the axes." } }
                            }
                        }
                    }
                }
            }
            figcaption {
                b { "Figure " (count) "." } " " (inline(&figure.caption)) " " (data_link(&figure.data)) " " (permalink(&id, "figure"))
            }
        }
    }
}

/// Curves with a name that another one covers: equal at every point to a thousandth of a decade, or to half of a line's width.
fn coincident(panel: &crate::evidence::Panel) -> Vec<(&str, &str)> {
    let values = panel.series.iter().flat_map(|series| &series.points).map(|point| point.1).filter(|y| y.is_finite());
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
    let is_near = |a: f64, b: f64| match panel.y.log {
        true => a > 0.0 && b > 0.0 && (a / b).log10().abs() < 1e-3,
        false => (a - b).abs() < 4e-3 * (high - low),
    };
    let covers = |a: &[(f64, f64)], b: &[(f64, f64)]| {
        a.len() > 1 && a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.0 == b.0 && is_near(a.1, b.1))
    };
    let mut found = Vec::new();
    let named: Vec<_> = panel.series.iter().filter(|series| series.mark != Mark::Other).collect();
    for (index, series) in named.iter().enumerate() {
        let later = &named[index + 1..];
        if let Some(other) = later.iter().find(|other| covers(&series.points, &other.points)) {
            found.push((series.label.as_str(), other.label.as_str()));
        }
    }
    found
}

/// The entries of a figure, shared by its panels: a label looks the same in each. The others have one entry, their number.
pub(in crate::report) struct Legend<'a> {
    entries: Vec<(Cow<'a, str>, Mark, Style)>,
    bands: Vec<(&'a str, String)>,
}

impl<'a> Legend<'a> {
    pub(in crate::report) fn of(figure: &'a Figure, palette: Palette<'_>) -> Self {
        let mut legend = Self { entries: Vec::new(), bands: Vec::new() };
        let all = || figure.panels.iter().flat_map(|panel| &panel.series);
        for series in all().filter(|series| series.mark != Mark::Other) {
            if legend.entries.iter().all(|(label, ..)| *label != series.label) {
                let place = legend.entries.len();
                let style = palette.style(&series.label, place, series.mark);
                let taken = |style: &Style| legend.entries.iter().any(|entry| style.looks_like(entry.2, series.mark));
                let style = style.variants().find(|style| !taken(style)).unwrap_or(style);
                legend.entries.push((series.label.as_str().into(), series.mark, style));
            }
        }
        let others: BTreeSet<_> = all().filter(|series| series.mark == Mark::Other).map(|s| &s.label).collect();
        if !others.is_empty() {
            legend.entries.push((style::others(others.len()).into(), Mark::Other, palette.style("", 0, Mark::Other)));
        }
        for field in figure.panels.iter().filter_map(|panel| panel.field.as_ref()) {
            for (index, name) in field.bands.iter().enumerate() {
                let entry = (name.as_str(), band(index, &field.levels, field.contours));
                if !legend.bands.contains(&entry) {
                    legend.bands.push(entry);
                }
            }
        }
        legend
    }

    /// Labels with the mark and the look of their series.
    pub(in crate::report) fn entries(&self) -> &[(Cow<'a, str>, Mark, Style)] {
        &self.entries
    }

    pub(in crate::report) fn style(&self, series: &Series) -> Style {
        self.entries
            .iter()
            .find(|(known, mark, _)| match series.mark {
                Mark::Other => *mark == Mark::Other,
                _ => *known == series.label,
            })
            .map_or_else(|| Palette(&[]).style("", 0, Mark::Line), |entry| entry.2)
    }

    fn write(&self) -> Markup {
        let named: Vec<_> = self.entries.iter().filter(|(label, ..)| !label.is_empty()).collect();
        html! {
            @if !named.is_empty() || !self.bands.is_empty() {
                ul.legend {
                    @for (label, class) in &self.bands { li { span.band.(class) {} span { (inline(label)) } } }
                    @for (label, mark, style) in named { li { (PreEscaped(style.swatch(*mark, "class=\"swatch\""))) span { (inline(label)) } } }
                }
            }
        }
    }
}
