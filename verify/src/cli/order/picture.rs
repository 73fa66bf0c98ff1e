//! `order --picture`: errors or values against the step, with the order that was found.

use std::io::Write;
use std::path::Path;

use verify::evidence::{Axis, Figure, Mark, Panel, Series};
use verify::measure::order::OrderFit;
use verify::measure::refinement::{Judgement, Quantity};
use verify::replacement::Replacement;
use verify::report::picture;

use crate::cli::error::Failure;
use crate::cli::layout::{decimals, significant};

/// Points of a fitted curve.
const CURVE: u32 = 100;

/// Writes `figure` to `path`.
pub(super) fn write(figure: &Figure, path: &Path) -> Result<(), Failure> {
    let svg = picture(figure).ok_or(Failure::Incomplete("--picture", "a point to draw: no value is finite"))?;
    let written = Replacement::create(path).and_then(|mut file| file.write_all(svg.as_bytes()).and(file.commit()));
    written.map_err(|source| Failure::Write { path: path.into(), source })
}

/// Errors against h: those in the fit, the others, floors, and the order expected.
pub(super) fn of_errors(title: &str, fit: &OrderFit, expects: bool) -> Figure {
    let measured = fit.points().into_iter().filter_map(|(sample, reason)| {
        let measured = sample.result.as_ref().ok()?;
        Some((sample.h, measured.error, measured.floor, reason.is_none()))
    });
    let measured: Vec<_> = measured.collect();
    let errors = |kept: bool| measured.iter().filter(|p| p.3 == kept).map(|p| (p.0, p.1)).collect::<Vec<_>>();
    let floors = measured.iter().map(|p| (p.0, p.2)).collect();
    let mut series = vec![Series::new("error, in the fit", errors(true), Mark::LineMarkers)];
    if !errors(false).is_empty() {
        series.push(Series::new("error, not in the fit", errors(false), Mark::Markers));
    }
    // From the finest error that counts.
    if let (Some(&(h, error)), [first, ..]) = (errors(true).last(), &measured[..]) {
        let order = fit.expected.order;
        let at = |x: f64| (x, error * (x / h).powf(order));
        let label = format!("{} {}", if expects { "expected order" } else { "order" }, significant(order, 3));
        series.push(Series::new(label, vec![at(first.0), at(h)], Mark::Line));
    }
    series.push(Series::new("floor", floors, Mark::Guide));
    let panel = Panel::new(Axis::log("h"), Axis::log("error"), series).titled(title);
    Figure::new("order", fit.reason.clone(), "order", [panel])
}

/// Values against h with the fitted curve, the limit and the band of the grid convergence index; and how far they are from the
/// limit, beside the order.
pub(super) fn of_values(quantities: &[Quantity], judgements: &[Judgement], expected: Option<f64>) -> Figure {
    let panels: Vec<Panel> = quantities
        .iter()
        .zip(judgements)
        .flat_map(|(quantity, judgement)| two_panels(quantity, judgement, expected))
        .collect();
    let reasons: Vec<&str> = judgements.iter().map(|judgement| judgement.reason.as_str()).collect();
    Figure::new("refinement", reasons.join("; "), "refinement", panels).in_columns(2)
}

fn two_panels(quantity: &Quantity, judgement: &Judgement, expected: Option<f64>) -> Vec<Panel> {
    let mut points: Vec<(f64, f64)> = quantity.grids.iter().filter_map(|grid| Some((grid.h, grid.value?))).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let values = Series::new("values", points.clone(), Mark::Markers);
    let (Some(&(finest, value)), Some(&(coarsest, _))) = (points.first(), points.last()) else { return Vec::new() };
    let mut over = vec![values];
    let mut panels = Vec::new();
    if let (Some(order), Some(limit)) = (judgement.order, judgement.extrapolated) {
        // The factor α that fits the values best, with the order and the limit that were found.
        let (scalar, square) = points.iter().fold((0.0, 0.0), |(a, b), (h, value)| {
            let power = (h / coarsest).powf(order);
            (a + power * (value - limit), b + power * power)
        });
        let law = |h: f64| limit + scalar / square * (h / coarsest).powf(order);
        let at = |k: u32| coarsest * f64::from(k) / f64::from(CURVE);
        let curve = (0..=CURVE).map(|k| (at(k), law(at(k)))).collect();
        over.push(Series::new(format!("φ₀ + α hᵖ, p = {}", decimals(order, 3)), curve, Mark::Line));
        over.push(Series::new("limit φ₀", vec![(0.0, limit), (coarsest, limit)], Mark::Line));
        let away = points.iter().map(|(h, value)| (*h, (value - limit).abs())).collect();
        let reference = |p: f64, label: String| {
            let size = (law(finest) - limit).abs();
            let point = |h: f64| (h, size * (h / finest).powf(p));
            Series::new(label, vec![point(finest), point(coarsest)], Mark::Line)
        };
        let mut series = vec![Series::new("|values − φ₀|", away, Mark::LineMarkers)];
        series.push(reference(order, format!("order {}, as found", decimals(order, 3))));
        series.extend(expected.map(|p| reference(p, format!("order {}, as expected", significant(p, 3)))));
        panels.push(Panel::new(Axis::log("h"), Axis::log("distance from the limit"), series).titled(&quantity.name));
    }
    if let Some(gci) = judgement.gci {
        for bound in [value * (1.0 - gci), value * (1.0 + gci)] {
            let band = vec![(0.0, bound), (coarsest, bound)];
            over.push(Series::new("finest value ± its GCI", band, Mark::Guide));
        }
    }
    panels.insert(0, Panel::new(Axis::linear("h"), Axis::linear("value"), over).titled(&quantity.name));
    panels
}

#[cfg(test)]
mod tests {
    use super::*;
    use verify::measure::order::{Expectation, Sample, fit};
    use verify::measure::refinement::{Grid, Question};

    /// 1 + 2 h² on grids with h = 0.1, 0.2, 0.4 and 0.8, with an order to expect or none.
    fn two_of(expected: Option<f64>) -> Vec<Panel> {
        let grid = |h: f64| Grid { h, value: Some(1.0 + 2.0 * h * h) };
        let mut quantity =
            Quantity { name: "drag".into(), grids: [0.2, 0.8, 0.1, 0.4].map(grid).into(), resolution: 0.0 };
        let judgement = quantity.judge(&Question { expected, ..Question::default() });
        // Which the picture leaves out.
        quantity.grids.push(Grid { h: 1.6, value: None });
        of_values(&[quantity], &[judgement], expected).panels
    }

    fn near(found: &[(f64, f64)], expected: &[(f64, f64)]) -> bool {
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-8 * b.abs().max(0.1);
        found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| close(a.0, b.0) && close(a.1, b.1))
    }

    #[test]
    fn values_are_drawn_with_their_law_its_limit_and_the_band_of_the_finest() {
        let panels = two_of(None);
        let over: Vec<_> = panels[0].series.iter().map(|s| (&*s.label, s.mark)).collect();
        let (marks, line, guide) = (Mark::Markers, Mark::Line, Mark::Guide);
        let band = "finest value ± its GCI";
        let names =
            [("values", marks), ("φ₀ + α hᵖ, p = 2.000", line), ("limit φ₀", line), (band, guide), (band, guide)];
        assert_eq!(over, names);
        let points = |k: usize| &panels[0].series[k].points[..];
        assert!(near(points(0), &[(0.1, 1.02), (0.2, 1.08), (0.4, 1.32), (0.8, 2.28)]), "{:?}", points(0));
        let curve = [(0.0, 1.0), (0.2, 1.08), (0.4, 1.32), (0.8, 2.28)];
        assert!(near(&[0, 25, 50, 100].map(|k| points(1)[k]), &curve) && points(1).len() == 101, "{:?}", points(1));
        assert!(near(points(2), &[(0.0, 1.0), (0.8, 1.0)]), "{:?}", points(2));
        // 1.25 · (1.08 − 1.02)/(2² − 1) = 0.025 to either side of the value on the finest grid.
        assert!(near(points(3), &[(0.0, 0.995), (0.8, 0.995)]) && near(points(4), &[(0.0, 1.045), (0.8, 1.045)]));
        assert_eq!((&*panels[0].title, &*panels[1].title), ("drag", "drag"));
        assert_eq!((panels[0].x.log, panels[0].y.log, panels[1].x.log, panels[1].y.log), (false, false, true, true));
    }

    #[test]
    fn distances_from_the_limit_are_drawn_beside_the_orders_from_the_finest() {
        let distances = |expected: Option<f64>| two_of(expected).remove(1).series;
        let series = distances(Some(1.0));
        let names: Vec<_> = series.iter().map(|s| (&*s.label, s.mark)).collect();
        let lines = [("order 2.000, as found", Mark::Line), ("order 1.00, as expected", Mark::Line)];
        assert_eq!(names, [&[("|values − φ₀|", Mark::LineMarkers)][..], &lines].concat());
        assert!(near(&series[0].points, &[(0.1, 0.02), (0.2, 0.08), (0.4, 0.32), (0.8, 1.28)]), "{series:?}");
        assert!(near(&series[1].points, &[(0.1, 0.02), (0.8, 1.28)]), "{series:?}");
        // First order from 0.02 on: eight times as much at eight times the spacing.
        assert!(near(&series[2].points, &[(0.1, 0.02), (0.8, 0.16)]), "{series:?}");
        assert_eq!(distances(None).len(), 2);
    }

    /// Of values that obey no law there are the values alone, and of none at all no panel.
    #[test]
    fn without_a_law_the_values_are_drawn_alone() {
        let panels = |values: &[f64]| {
            let grids = (1..).zip(values).map(|(k, value)| Grid { h: f64::from(k), value: Some(*value) }).collect();
            let quantity = Quantity { name: "drag".into(), grids, resolution: 0.0 };
            let judgement = quantity.judge(&Question::default());
            of_values(&[quantity], &[judgement], None).panels
        };
        let alone = panels(&[1.0, 2.0]);
        assert_eq!((alone.len(), alone[0].series.len()), (1, 1));
        assert!(panels(&[]).is_empty());
    }

    /// Errors 3 h² down to a floor of 10⁻⁵, from a run that failed on.
    #[test]
    fn errors_are_drawn_by_whether_they_count_beside_the_order_that_is_expected() {
        let sample =
            |k: i32| Sample::new(0.5_f64.powi(k), 3.0 * 0.25_f64.powi(k) + if k > 8 { 1e-5 } else { 0.0 }, 1e-5);
        let samples: Vec<_> = [Sample::failed(2.0, "no solution")].into_iter().chain((0..12).map(sample)).collect();
        let fit = fit(&samples, &Expectation::new(2.0, 0.1));
        let drawn = |expects: bool| of_errors("errors", &fit, expects);
        let figure = drawn(true);
        let series = &figure.panels[0].series;
        let names: Vec<_> = series.iter().map(|s| (&*s.label, s.mark)).collect();
        let expected = [
            ("error, in the fit", Mark::LineMarkers),
            ("error, not in the fit", Mark::Markers),
            ("expected order 2.00", Mark::Line),
            ("floor", Mark::Guide),
        ];
        assert_eq!(names, expected);
        let kept = fit.kept.len();
        assert!(kept >= 5 && series[0].points.len() == kept && series[1].points.len() == 12 - kept, "{series:?}");
        assert!(series[0].points.iter().all(|(h, error)| (error - 3.0 * h * h).abs() <= 1e-12), "{series:?}");
        assert!(series[1].points.iter().all(|(h, _)| *h < series[0].points[kept - 1].0), "{series:?}");
        // The line goes through the finest error that counts, to the coarsest step with a result.
        let (h, error) = series[0].points[kept - 1];
        assert!(near(&series[2].points, &[(1.0, 3.0), (h, error)]), "{series:?}");
        assert!(series[3].points.len() == 12 && series[3].points.iter().all(|p| p.1 == 1e-5), "{series:?}");
        assert_eq!(drawn(false).panels[0].series[2].label, "order 2.00");
        assert_eq!((&*figure.panels[0].title, &*figure.caption), ("errors", &*fit.reason));
        assert!(figure.panels[0].x.log && figure.panels[0].y.log);
    }
}
