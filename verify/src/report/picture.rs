//! A figure as a file of its own: SVG with its legend and the colours of the page on paper.

use std::fmt::Write;

use super::chart;
use super::html::Legend;
use super::style::Palette;
use super::text::escape;
use crate::evidence::Figure;

/// Height of a title and of an entry of the legend.
const TITLE: f64 = 26.0;
const ENTRY: f64 = 19.0;
/// Where the text of an entry begins, behind its swatch.
const TEXT: f64 = 48.0;

/// `figure` as a document in SVG; nothing if none of its panels has anything to draw.
#[must_use]
pub fn picture(figure: &Figure) -> Option<String> {
    let legend = Legend::of(figure, Palette(&[]));
    let columns = figure.columns.clamp(1, figure.panels.len().max(1));
    let (width, height) = chart::size(columns);
    let mut panels = String::new();
    let mut drawn = 0;
    for panel in &figure.panels {
        let styles: Vec<_> = panel.series.iter().map(|series| legend.style(series)).collect();
        let Some(drawing) = chart::panel(panel, &styles, columns) else { continue };
        let (x, y) = ((drawn % columns) as f64 * width, (drawn / columns) as f64 * (TITLE + height));
        let _ = write!(
            panels,
            "<text class=\"title\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            x + 0.5 * width,
            y + 18.0,
            escape(&panel.title)
        );
        let place = format!("<svg x=\"{x}\" y=\"{}\" width=\"{width}\" height=\"{height}\" ", y + TITLE);
        panels.push_str(&drawing.svg.replacen("<svg ", &place, 1));
        drawn += 1;
    }
    if drawn == 0 {
        return None;
    }
    let top = drawn.div_ceil(columns) as f64 * (TITLE + height);
    let mut entries = String::new();
    for (row, (label, mark, style)) in legend.entries().iter().enumerate() {
        let y = top + row as f64 * ENTRY;
        entries.push_str(&style.swatch(*mark, &format!("x=\"8\" y=\"{y}\" width=\"34\" height=\"14\"")));
        let _ = write!(entries, "<text x=\"{TEXT}\" y=\"{}\">{}</text>", y + 11.0, escape(label));
    }
    let (wide, high) = (columns.min(drawn) as f64 * width, top + legend.entries().len() as f64 * ENTRY + 8.0);
    Some(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {wide} {high}\" width=\"{wide}\" height=\"{high}\" \
         font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\" font-size=\"12.5\"><title>{}</title><style>{}</style>\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>{panels}{entries}</svg>\n",
        escape(&figure.caption),
        rules()
    ))
}

/// The rules of the page for drawings, with the colours that it has on paper: not every viewer knows variables.
fn rules() -> String {
    let page = include_str!("page.css");
    let between =
        |from: &str, to: &str| page.split_once(from).and_then(|(_, rest)| rest.split_once(to)).map_or("", |it| it.0);
    let mut rules = format!(
        "text {{ fill: var(--ink); }} .title {{ font-weight: 600; }}\n{}",
        between("/* drawings */", "/* end */")
    );
    for (name, value) in between(":root {", "}").split(';').filter_map(|line| line.trim().split_once(':')) {
        // A comment may stand before the name.
        let name = name.split_whitespace().next_back().unwrap_or_default();
        rules = rules.replace(&format!("var({name})"), value.trim());
    }
    rules
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::{Axis, Mark, Panel, Series};

    fn figure(points: &[(f64, f64)]) -> Figure {
        let series = Series::new("a & b", points.to_vec(), Mark::LineMarkers);
        let panel = Panel::new(Axis::log("h"), Axis::log("error"), vec![series]).titled("x < y");
        Figure::new("id", "What is <drawn>.", "data", [panel])
    }

    #[test]
    fn a_picture_stands_alone() {
        let svg = picture(&figure(&[(0.1, 1e-3), (0.2, 4e-3)])).expect("two points");
        assert!(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\"") && svg.ends_with("</svg>\n"));
        // The colours of the page, and none of its variables.
        assert!(svg.contains(".s0 { color: #0072b2; }") && !svg.contains("var("), "{svg}");
        assert!(svg.contains("a &amp; b</text>") && svg.contains("x &lt; y</text>") && svg.contains("&lt;drawn&gt;"));
        assert_eq!(svg.matches("<svg").count(), svg.matches("</svg>").count());
        assert_eq!(svg.matches("<text").count(), svg.matches("</text>").count());
    }

    #[test]
    fn the_others_are_grey_behind_one_entry_and_every_point_says_what_it_is() {
        let curve = |k: u32| Series::new(format!("m{k}"), vec![(0.5, f64::from(k))], Mark::LineMarkers);
        let panel = Panel::new(Axis::log("h"), Axis::log("error"), (1..=12).map(curve).collect());
        let figure = Figure::new("id", "Many.", "data", [panel.clone(), panel]).telling(&["m11", "m12"]);
        let svg = picture(&figure).expect("points");
        assert!(svg.contains(">others (10)</text>") && svg.contains(">m12</text>") && !svg.contains(">m3</text>"));
        assert_eq!(svg.matches("<title>m3: 0.5, 3</title>").count(), 2);
        assert_eq!(svg.matches("<title>m12: 0.5, 12</title>").count(), 2);
        // Ten lines a panel and the swatch; those in colour lie over them.
        assert_eq!(svg.matches("class=\"l s9\"").count(), 21);
        assert!(svg.find("<title>m12</title>") > svg.find("<title>m10</title>"));
    }

    #[test]
    fn nothing_to_draw_is_no_picture() {
        assert_eq!(picture(&figure(&[])), None);
        assert_eq!(picture(&figure(&[(0.1, -1.0), (0.2, f64::NAN)])), None);
    }
}
