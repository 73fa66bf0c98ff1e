//! Curves and their legends.

use super::*;

/// Class, dash and shape of a path of a curve or its markers.
type Look<'a> = (Vec<&'a str>, Option<&'a str>, String);

/// The looks of the line and of the markers in a drawing, each with the first point of the path.
fn looks<'a>(drawing: Node<'a, '_>) -> Vec<(bool, Look<'a>, [f64; 2])> {
    let of = |node: &Node<'a, '_>| {
        let classes = classes(node);
        let is_line = classes.first() == Some(&"l");
        let is_curve = classes.get(1).is_some_and(|class| class.starts_with('s'));
        let path = node.attribute("d")?.strip_prefix('M').filter(|_| is_curve)?;
        let end = |text: &str| text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
        let (x, rest) = path.split_at(end(path));
        let rest = rest.trim_start();
        let (y, rest) = rest.split_at(end(rest));
        // Up to the next point.
        let shape = if is_line { "" } else { rest.split('M').next().unwrap_or_default() };
        Some((
            is_line,
            (classes, node.attribute("stroke-dasharray"), shape.into()),
            [x, y].map(|n| n.parse().expect("a number")),
        ))
    };
    drawing.descendants().filter_map(|node| of(&node)).collect()
}

#[test]
fn a_curve_looks_like_its_entry_in_the_legend_and_a_method_alike_everywhere() {
    let path = written("curves", &run());
    let page = page(&path);
    let document = Document::parse(&page).expect("a tree");
    for (id, curves) in [("figure:early", &FIRST[..]), ("figure:late", &SECOND), ("figure:covered", &COVERED)] {
        let figure = element(&document, id);
        let legend = with_tag(only(&with_class(figure, "legend")), &["li"]);
        assert_eq!(
            legend.iter().map(|entry| text(*entry)).collect::<Vec<_>>(),
            curves.iter().map(|c| c.0).collect::<Vec<_>>()
        );
        let axes = with_tag(only(&with_class(figure, "panel")), &["svg"])
            .into_iter()
            .find(|svg| svg.has_attribute("overflow"));
        let axes = axes.expect("the inside of the axes");
        let height: f64 = axes.attribute("height").and_then(|n| n.parse().ok()).expect("a number");
        for (entry, (label, value, mark)) in legend.into_iter().zip(curves) {
            let (has_line, has_marker) = (*mark != Mark::Markers, matches!(mark, Mark::Markers | Mark::LineMarkers));
            // Lines are drawn in quarters of a pixel, markers in whole ones.
            let is_at = |is_line: bool, y: f64| {
                let y = if is_line { y / 4.0 } else { y };
                (TOP * (1.0 - y / height) - value).abs() < 0.02
            };
            let drawn: Vec<_> = looks(axes).into_iter().filter(|(is_line, _, [_, y])| is_at(*is_line, *y)).collect();
            let told = looks(entry);
            assert_eq!(
                told.iter().map(|look| look.0).collect::<Vec<_>>(),
                [(has_line, true), (has_marker, false)]
                    .into_iter()
                    .filter(|part| part.0)
                    .map(|part| part.1)
                    .collect::<Vec<_>>(),
                "{label}"
            );
            for (is_line, look, _) in &told {
                assert!(
                    drawn.iter().any(|(line, drawn, _)| line == is_line && drawn == look),
                    "{label} in {id}: {look:?} and {drawn:?}"
                );
            }
            // But for curves that lie on each other.
            assert!(drawn.len() == told.len() || id == "figure:covered", "{label} in {id}");
            let place = METHODS.iter().position(|name| name == label).map(|method| PLACES[method]);
            let colour = format!("s{}", place.map_or(8, |place| place % 8));
            assert!(told.iter().all(|(_, (classes, ..), _)| classes[1] == colour), "{label} in {id} is not {colour}");
        }
        let hidden: Vec<_> = with_class(figure, "dropped").into_iter().map(text).collect();
        assert_eq!(hidden, if id == "figure:covered" { vec!["alpha lies on beta."] } else { vec![] });
    }
}

/// None of them has a colour of its own on every page.
#[test]
fn curves_of_other_names_in_one_figure_differ() {
    const OTHERS: [(&str, f64, Mark); 3] =
        [("one", 1.0, Mark::Line), ("two", 2.0, Mark::Line), ("three", 3.0, Mark::Line)];
    let evidence = Evidence {
        figures: vec![figure("strange", &OTHERS)],
        tables: vec![Table::data("data-strange", "Data.", ["x"], Vec::new())],
        ..Evidence::default()
    };
    let path =
        written("strange", &Run::new(vec![Chapter { id: "open".into(), evidence, ..Chapter::default() }], Vec::new()));
    let page = page(&path);
    let document = Document::parse(&page).expect("a tree");
    let legend = only(&with_class(element(&document, "figure:strange"), "legend"));
    let drawn: Vec<Look> = looks(legend).into_iter().map(|(_, look, _)| look).collect();
    assert_eq!(drawn.len(), OTHERS.len());
    for (place, look) in drawn.iter().enumerate() {
        assert!(!drawn[..place].contains(look), "{look:?} twice");
    }
}

/// What is read aloud names both axes.
#[test]
fn a_panel_is_described_by_its_ordinate_over_its_abscissa() {
    let path = written("described", &run());
    let page = page(&path);
    let document = Document::parse(&page).expect("a tree");
    let panels = with_class(element(&document, "figure:early"), "panel");
    let described = panels.iter().flat_map(|panel| panel.descendants()).filter_map(|node| node.attribute("aria-label"));
    let described: Vec<_> = described.collect();
    assert!(described.iter().any(|text| text.starts_with("y over x")), "{described:?}");
}
