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
