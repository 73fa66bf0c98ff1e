//! The steady cavity against the literature, the way to it, and the cavity against CVODE.

use super::{Context, Scale, StudyError, brief, map, prose, short, streamlines};
use crate::evidence::number::digits;
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Outcome, Panel, Requirement, Series, Table};
use crate::experiment::flow::against_cvode::{AgainstCvode, Loose, Row};
use crate::experiment::flow::approach::{Approach, Found as Reached};
use crate::experiment::flow::profile::{Published, published};
use crate::experiment::flow::steady::{Grid, STEADY, Spurious, SteadyCavity};
use crate::measure::norm::Extremes;
use crate::row;

const GHIA: &str = "Ghia 1982";
const BOTELLA: &str = "Botella 1998";
/// Re, line, coordinate and velocity of an entry of Ghia's table in most public copies, where the table here has another.
const COPIED: (f64, char, f64, f64) = (400.0, 'v', 0.9063, -0.23827);

/// The check of the steady cavity against that table.
pub(super) fn against_ghia(re: f64) -> String {
    format!("steady/{re}/{GHIA}")
}

/// How far a table may be off. For Re = 1000 that of Ghia et al. is off that of Botella and Peyret by up to 0.0185, and where their own grids
/// of 129² points leave so much, 0.02 is no more than their next digit. No second table is at hand for smaller Re: these bounds are against
/// gross errors, and the check beside them sees to it that the grid takes no more than half of them.
fn band(source: &str, re: f64) -> f64 {
    match re {
        _ if source == BOTELLA => 0.01,
        re if re <= 100.0 => 0.010,
        re if re <= 400.0 => 0.008,
        _ => 0.02,
    }
}

pub(super) fn steady(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    let table = published()?;
    let (mut rows, mut reached, mut profiles) = (Vec::new(), Vec::new(), Vec::new());
    let (mut streams, mut vortices) = (Vec::new(), Vec::new());
    let (mut within, mut extrapolated, mut on) = (Vec::new(), Vec::new(), 0);
    for (re, judged, cells) in scale.steady {
        let grids = context.get(SteadyCavity { re: *re, cells })?;
        reached.extend(grids.iter().map(|grid| row![*re, grid.cells, grid.residual, grid.steps]));
        let timings = grids.iter().map(|g| (format!("steady cavity, Re = {re}, N = {}", g.cells), g.seconds));
        evidence.timings.extend(timings);
        let grid = grids.iter().find(|grid| grid.cells == *judged).ok_or("no such grid")?;
        let [.., coarse, fine] = grids.as_slice() else { return Err("two grids".into()) };
        on = grid.cells;
        for source in [GHIA, BOTELLA] {
            let values: Vec<&Published> = table.iter().filter(|p| p.re == *re && p.source == source).collect();
            if values.is_empty() {
                continue;
            }
            let checks = against(&values, (*re, source), grid, coarse, fine);
            let largest: Vec<String> = checks.iter().filter_map(|check| check.measured).map(short).collect();
            match (source, &*largest) {
                (GHIA, [ghia, grid]) => within.push((short(*re), ghia.clone(), grid.clone())),
                (_, [_, richardson]) => {
                    let values = [
                        ("coarse", coarse.cells.to_string()),
                        ("fine", fine.cells.to_string()),
                        ("richardson", richardson.clone()),
                        ("re", short(*re)),
                        ("gap", short(apart(&table, *re))),
                    ];
                    extrapolated.extend(prose::fill(include_str!("richardson.md"), &values)?);
                }
                _ => {}
            }
            evidence.checks.extend(checks);
            extrapolated.extend(copied(&values, grid)?);
            rows.extend(values.iter().map(|p| {
                let velocity = grid.profile.at(p.line, p.coord);
                row![*re, grid.cells, p.line.to_string(), p.coord, velocity, p.velocity, p.source.clone()]
            }));
        }
        for (line, x, y) in [('u', "y", "u at x = ½"), ('v', "x", "v at y = ½")] {
            let mut curves =
                vec![Series::new(format!("N = {}", grid.cells), grid.profile.line(line).to_vec(), Mark::Line)];
            for source in [GHIA, BOTELLA] {
                let of = |p: &&Published| p.re == *re && p.line == line && p.source == source;
                let points: Vec<_> = table.iter().filter(of).map(|p| (p.coord, p.velocity)).collect();
                if !points.is_empty() {
                    curves.push(Series::new(source, points, Mark::Markers));
                }
            }
            profiles.push(Panel::new(Axis::linear(x), Axis::linear(y), curves).titled(format!("Re = {re}")));
        }
        streams.push(streamlines(&format!("Re = {re}, ψ"), grid.cells, &grid.psi));
        vortices.push(vorticity(&format!("Re = {re}, ω"), grid));
    }
    let caption = "Steady cavity by Method I: the largest |f| that is left, in units of M ψ̇, and the steps to it, each grid from the \
                   one before.";
    let steady = "flow-steady";
    evidence.tables.push(Table::new(steady, caption, ["re", "cells", "residual", "steps"], reached));
    let caption = "Velocities on the centre lines of the steady cavity: computed, as lines, and published, as markers; those of Ghia et al. as \
                   transcribed in public codes.";
    let columns = ["re", "cells", "line", "coord", "velocity", "published", "source"];
    let id = "cavity-profiles";
    evidence.tables.push(Table::data(id, caption, columns, rows));
    evidence.figures.push(Figure::new(id, caption, id, profiles).in_columns(2));
    let pictures = [
        (
            "streamlines",
            "streamlines. The lid moves to the right and drags a vortex along; where ψ > 0, in the other colour, eddies turn the other way",
            streams,
        ),
        ("vorticity", "vorticity, largest along the lid and where the flow meets the right wall", vortices),
    ];
    for (what, seen, panels) in pictures {
        let (id, columns) = (format!("flow-steady-{what}"), panels.len().max(2));
        let caption = format!("Steady cavity by Method I: {seen}.");
        evidence.figures.push(Figure::new(id, caption, steady, panels).in_columns(columns));
    }
    let list =
        |of: fn(&(String, String, String)) -> &String| within.iter().map(of).cloned().collect::<Vec<_>>().join(", ");
    let values =
        [("cells", on.to_string()), ("re", list(|w| &w.0)), ("ghia", list(|w| &w.1)), ("grid", list(|w| &w.2))];
    evidence.notes.extend(prose::fill(include_str!("steady.md"), &values)?);
    evidence.notes.extend(extrapolated);
    Ok(())
}

/// The largest difference between the two tables.
fn apart(table: &[Published], re: f64) -> f64 {
    let of = |source: &'static str| table.iter().filter(move |p| p.re == re && p.source == source);
    let pairs =
        of(GHIA).flat_map(|a| of(BOTELLA).filter(|b| (b.line, b.coord) == (a.line, a.coord)).map(move |b| (a, b)));
    pairs.map(|(a, b)| (a.velocity - b.velocity).abs()).largest()
}

/// What speaks for the entry that most copies have otherwise, if it is among `values`.
fn copied(values: &[&Published], grid: &Grid) -> Result<Vec<String>, StudyError> {
    let (re, line, coord, copies) = COPIED;
    let Some(here) = values.iter().find(|p| (p.re, p.line, p.coord) == (re, line, coord) && p.source == GHIA) else {
        return Ok(Vec::new());
    };
    let own = grid.profile.at(line, coord);
    let is_nearer = (own - here.velocity).abs() < (own - copies).abs();
    let values = [
        ("re", short(re)),
        ("line", line.to_string()),
        ("coord", short(coord)),
        ("copies", digits(copies, 5)),
        ("here", digits(here.velocity, 5)),
        ("own", digits(own, 5)),
        ("verdict", if is_nearer { "a misprint by that" } else { "the better value by that" }.into()),
    ];
    prose::fill(include_str!("ghia.md"), &values)
}

/// A table of the literature against the grid on which it is judged, and the last two grids extrapolated.
fn against(values: &[&Published], (re, source): (f64, &str), grid: &Grid, coarse: &Grid, fine: &Grid) -> Vec<Check> {
    let off = |at: &dyn Fn(&Published) -> f64| values.iter().map(|p| (at(p) - p.velocity).abs()).largest();
    let mut checks = vec![Check::new(
        format!("steady/{re}/{source}"),
        format!(
            "Steady cavity, Re = {re}, N = {}: the largest difference from {source} on both centre lines",
            grid.cells
        ),
        off(&|p| grid.profile.at(p.line, p.coord)),
        Requirement::AtMost(band(source, re)),
        if source == GHIA {
            match re {
                re if re > 400.0 => "what the table of Botella and Peyret shows these values to be off by",
                _ => {
                    "against gross errors: no second table says what these values are off by; half of it is the most that the grid may take"
                }
            }
        } else {
            "the error of second order on this grid"
        },
    )];
    let ratio = (fine.cells as f64 / coarse.cells as f64).powi(2);
    let change = |p: &Published| fine.profile.at(p.line, p.coord) - coarse.profile.at(p.line, p.coord);
    if source == GHIA {
        // Of second order: the error of the finer grid, and from it that of the one which is judged.
        let part = (fine.cells as f64 / grid.cells as f64).powi(2) / (ratio - 1.0);
        checks.push(Check::new(
            format!("steady/{re}/grid"),
            format!(
                "The grid takes part of that difference: its own error, from N = {} and {}",
                coarse.cells, fine.cells
            ),
            values.iter().map(|p| (part * change(p)).abs()).largest(),
            Requirement::AtMost(0.5 * band(source, re)),
            "half of what is allowed, so that more than that would be the table's",
        ));
    }
    if source == BOTELLA {
        checks.push(Check::new(
            format!("steady/{re}/richardson"),
            format!("The same, extrapolated from N = {} and {}", coarse.cells, fine.cells),
            off(&|p| {
                let fine = fine.profile.at(p.line, p.coord);
                fine + change(p) / (ratio - 1.0)
            }),
            Requirement::AtMost(2e-4),
            "the errors of second order cancel, and of fourth order c/(N₁N₂)² is left; from N = 64 and 128 that was 6e-4",
        ));
    }
    checks
}

/// A map of the vorticity at the interior corners.
fn vorticity(title: &str, grid: &Grid) -> Panel {
    let place: Vec<f64> = (1..grid.cells).map(|i| i as f64 / grid.cells as f64).collect();
    map(title, &place, &grid.vorticity, vec![-5.0, -3.0, -1.0, 0.0, 1.0, 3.0, 5.0], true)
}

/// Steps from rest on a grid that is too coarse for them.
pub(super) fn too_long(h: f64) -> Spurious {
    Spurious { re: 1000.0, cells: 32, h }
}

/// Steps from rest to the steady cavity.
pub(super) fn from_rest(method: &'static str, cells: usize, h: f64) -> Approach {
    Approach { method, re: 100.0, cells, h }
}

/// Where the minimum of the action at a step too long for the grid is no steady flow.
pub(super) fn spurious(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    const OTHERS: [&str; 2] = ["implicit-euler", "tr-bdf2"];
    let Spurious { re, cells, .. } = too_long(0.0);
    let found = context.get_each(scale.spurious.iter().map(|h| too_long(*h)).collect())?;
    let by = |method| scale.spurious.iter().map(move |h| Approach { method, re, cells, h: *h });
    let others = context.get_each(OTHERS.into_iter().flat_map(by).collect())?;
    let cases = || scale.spurious.iter().zip(&found);
    let Some((h, worst)) = cases().next_back() else { return Ok(()) };
    let reach = others.iter().filter(|other| other.is_steady()).count();
    let reach = match others.len() - reach {
        0 => "all come to a steady flow".to_owned(),
        missed => format!("come to a steady flow in all but {missed} of their runs"),
    };
    let values = [
        ("others", reach),
        ("h", short(*h)),
        ("re", short(re)),
        ("cells", cells.to_string()),
        ("rest", short(worst.residual)),
        ("gradient", worst.gradient.map_or("an unknown number of".into(), short)),
    ];
    evidence.notes.extend(prose::fill(include_str!("spurious.md"), &values)?);
    let statement = format!(
        "Re = {re} on {cells}² cells with h = {h}: where the iteration of Method I ends the flow is not steady, and the library refuses it; \
         |f| there"
    );
    evidence.checks.push(Check::new(
        "steady/spurious",
        statement,
        if worst.message.is_empty() { f64::NAN } else { worst.residual },
        Requirement::AtLeast(1e6 * STEADY),
        "a million times what counts as steady; (2M − h Jᵀ) M⁻¹f = 0 can have roots with f ≠ 0 where hM⁻¹J has the eigenvalue 2",
    ));
    let outcome = |message: &str| if message.is_empty() { "steady".to_owned() } else { format!("refused: {message}") };
    let own = cases().map(|(h, found)| row!["method-i", *h, found.residual, found.gradient, outcome(&found.message)]);
    let each = OTHERS.into_iter().flat_map(|method| scale.spurious.iter().map(move |h| (method, *h)));
    let others = each
        .zip(&others)
        .map(|((method, h), found)| row![method, h, Cell::found(found.residual), Cell::Empty, ended(found)]);
    let rows = own.chain(others).collect();
    let caption = format!(
        "From rest at Re = {re} on {cells} cells a side, by step size: |f| in units of M ψ̇ where the iteration of Method I ends, or where \
         another method has it below {:e}; where that iteration stalls, the gradient of the action over that at rest; and the outcome.",
        Approach::STEADY
    );
    let id = "flow-spurious";
    evidence.tables.push(Table::new(id, caption, ["method", "h", "residual", "gradient", "outcome"], rows));
    let steady = cases().find(|(_, found)| found.message.is_empty()).map(|(h, found)| (h, found, "steady"));
    let shown = steady.into_iter().chain([(h, worst, "refused")]);
    let panels: Vec<Panel> = shown
        .filter_map(|(h, found, what)| Some(streamlines(&format!("h = {h}, {what}"), cells, found.psi.as_ref()?)))
        .collect();
    let caption =
        "Streamlines where Method I comes to rest from rest with long steps: those that are refused are no flow.";
    evidence.figures.push(Figure::new(id, caption, id, panels).in_columns(2));
    Ok(())
}

/// How steps to a steady cavity end.
fn ended(found: &Reached) -> String {
    match &found.error {
        Some(error) => error.clone(),
        None if found.is_steady() => "steady".to_owned(),
        None => "still moving".to_owned(),
    }
}

/// Steps of several methods from rest to the steady cavity.
pub(super) fn approach(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    const METHODS: [&str; 5] = ["method-i", "trapezoidal", "tr-bdf2", "bdf2", "implicit-euler"];
    const STEPS: [f64; 3] = [1.0, 10.0, 100.0];
    let mut cases = Vec::new();
    for method in METHODS {
        cases.extend(STEPS.map(|h| (method, h)));
    }
    let cells = scale.approach;
    let Approach { re, .. } = from_rest("", cells, 0.0);
    let settings = cases.iter().map(|(method, h)| from_rest(method, cells, *h));
    let found = context.get_each(settings.collect())?;
    let rows = cases.iter().zip(&found).map(|((method, h), found)| {
        row![*method, *h, found.steps, found.solves, Cell::found(found.residual), ended(found)]
    });
    let rows = rows.collect();
    let of =
        |method: &str, h: f64| cases.iter().zip(&found).find(|(case, _)| **case == (method, h)).map(|(_, found)| found);
    let count = |method: &str, h: f64| match of(method, h) {
        Some(found) if found.is_steady() => format!("takes {} steps and {} linear systems", found.steps, found.solves),
        Some(found) if found.error.is_some() => "fails in a step".to_owned(),
        _ => format!("does not get there in {} steps", Approach::MOST),
    };
    let [_, ten, hundred] = STEPS;
    let solves = |method: &str, h: f64| of(method, h).filter(|found| found.is_steady()).map(|found| found.solves);
    let pays = |other: &str| {
        [ten, hundred].iter().all(|h| match (solves("method-i", *h), solves(other, *h)) {
            (Some(own), Some(other)) => own < other,
            (own, _) => own.is_some(),
        })
    };
    let verdict = |other| if pays(other) { "pay" } else { "do not pay" };
    let values = [
        ("re", short(re)),
        ("cells", cells.to_string()),
        ("ten", short(ten)),
        ("hundred", short(hundred)),
        ("method_i_ten", count("method-i", ten)),
        ("rule_ten", count("trapezoidal", ten)),
        ("tr_bdf2_ten", count("tr-bdf2", ten)),
        ("euler_ten", count("implicit-euler", ten)),
        ("method_i_hundred", count("method-i", hundred)),
        ("tr_bdf2_hundred", count("tr-bdf2", hundred)),
        ("bdf2_ten", count("bdf2", ten)),
        ("bdf2_hundred", count("bdf2", hundred)),
        ("against_bdf2", verdict("bdf2").into()),
        ("euler_hundred", count("implicit-euler", hundred)),
        ("against_rule", verdict("trapezoidal").into()),
        ("against_tr_bdf2", verdict("tr-bdf2").into()),
        ("against_euler", verdict("implicit-euler").into()),
    ];
    evidence.notes.extend(prose::fill(include_str!("approach.md"), &values)?);
    let caption = format!(
        "Cavity of {cells} cells a side, Re = {re}, from rest until |f| ≤ {:e} in units of M ψ̇: steps, up to {} of them, and `solves`, the linear systems.",
        Approach::STEADY,
        Approach::MOST
    );
    let columns = ["method", "h", "steps", "solves", "residual", "outcome"];
    evidence.tables.push(Table::new("flow-approach", caption, columns, rows));
    Ok(())
}

/// CVODE on the same semi-discrete cavity, written by hand.
pub(super) fn cross_check(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    let cells = scale.reference;
    let end = AgainstCvode::END;
    let statement = format!("Method I and CVODE agree on the cavity of {cells} cells a side at t = {end}");
    let found = context.get(AgainstCvode { cells })?;
    let found = match &*found {
        Ok(found) => found,
        Err(absent) => {
            evidence.checks.push(Check::undecided("cvode", statement, Outcome::NotRun, absent.clone()));
            return Ok(());
        }
    };
    let [coarse, middle, finest] = found.rows.as_slice() else { return Err("three runs".into()) };
    let excess = finest.difference - (finest.predicted + found.bound);
    // From a h² + b h³ with steps of 4h and 2h; a third of the difference of the errors with 2h and h has 7/3 of b h³.
    let of_third_order = (coarse.difference - 4.0 * middle.difference) / 32.0;
    evidence.checks.push(Check::new(
        "cvode",
        statement,
        finest.difference / (finest.predicted + found.bound),
        Requirement::AtMost(1.25),
        "the difference over what Method I's own two runs predict and CVODE's bound; a quarter for the terms beyond the second order",
    ));
    let alike = found.loose.iter().find(|run| run.difference <= finest.difference);
    let alike = match alike {
        Some(Loose { tolerance, work, seconds, difference }) => format!(
            "For an error of {}, no more than that of Method I, CVODE with a tolerance of {} takes {} steps, {} evaluations, {} products and {} s",
            short(*difference),
            short(*tolerance),
            work.steps,
            work.rhs,
            work.products,
            brief(*seconds)
        ),
        None => "None of its looser solves is as accurate as Method I".into(),
    };
    let values = [
        ("alike", alike),
        ("cells", cells.to_string()),
        ("re", short(AgainstCvode::RE)),
        ("end", short(end)),
        ("tolerance", short(AgainstCvode::TOLERANCE)),
        ("seconds", brief(found.cvode_seconds)),
        ("h", short(end / f64::from(finest.steps))),
        ("difference", short(finest.difference)),
        ("excess", brief(excess.abs())),
        ("more", if excess > 0.0 { "more" } else { "less" }.into()),
        ("first_ratio", short(coarse.difference / middle.difference)),
        ("second_ratio", short(middle.difference / finest.difference)),
        ("missed", brief(-4.0 / 3.0 * of_third_order)),
        ("predicted", short(finest.predicted)),
        ("bound", short(found.bound)),
        ("steps", found.cvode.steps.to_string()),
        ("rhs", found.cvode.rhs.to_string()),
        ("products", found.cvode.products.to_string()),
        ("own_systems", finest.cost.solves.to_string()),
        ("own_products", finest.cost.inner.to_string()),
        ("accuracy", brief(finest.predicted / found.bound)),
        ("own_seconds", brief(finest.cost.seconds)),
    ];
    evidence.notes.extend(prose::fill(include_str!("cvode.md"), &values)?);
    evidence.timings.push((format!("cavity, N = {cells}, by CVODE"), found.cvode_seconds));
    let work = &found.cvode;
    let mut rows = vec![row![
        "cvode-bdf",
        Cell::Empty,
        work.steps,
        work.rhs,
        work.products,
        Cell::Empty,
        found.cvode_seconds,
        Cell::Empty,
        found.bound
    ]];
    for Loose { tolerance, work, seconds, difference } in &found.loose {
        let name = format!("cvode-bdf, tolerance {tolerance:e}");
        rows.push(row![
            name,
            Cell::Empty,
            work.steps,
            work.rhs,
            work.products,
            Cell::Empty,
            *seconds,
            *difference,
            Cell::Empty
        ]);
    }
    for Row { steps, cost, difference, predicted } in &found.rows {
        evidence.timings.push((format!("cavity, N = {cells}, by Method I, {steps} steps"), cost.seconds));
        let (h, predicted) = (end / f64::from(*steps), Cell::found(*predicted));
        let counts = [u64::from(*steps), cost.residuals, cost.inner, cost.solves].map(Cell::from);
        let measured = [Cell::from(cost.seconds), Cell::from(*difference), predicted];
        rows.push([Cell::from("method-i"), Cell::from(h)].into_iter().chain(counts).chain(measured).collect());
    }
    let caption = format!(
        "The same semi-discrete cavity of {cells} cells a side, Re = {}, at t = {end}, by Method I and by CVODE, whose Newton iteration \
         has GMRES and products with the Jacobian by hand: steps, evaluations of f, products with the Jacobian (of Method I with B and \
         Bᵀ, for the first system after a factorisation of B with neither), systems of Gauss–Newton steps, seconds of one solve, measured \
         once, of CVODE with a tolerance of {:e} where none is named, the largest difference of a velocity, and what each expects its own error to be.",
        AgainstCvode::RE,
        AgainstCvode::TOLERANCE
    );
    let columns = ["method", "h", "steps", "rhs", "products", "systems", "seconds", "difference", "own_bound"];
    evidence.tables.push(Table::new("flow-cvode", caption, columns, rows));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::flow::profile::Profile;

    #[test]
    fn extrapolation_removes_an_error_of_second_order() {
        // u = y³ + 1/N² on all faces.
        let grid = |cells: usize| {
            let u = (0..cells).flat_map(|j| {
                let y = (j as f64 + 0.5) / cells as f64;
                (1..cells).map(move |_| y.powi(3) + (cells as f64).powi(-2))
            });
            let faces: Vec<f64> = u.chain(vec![0.0; cells * (cells - 1)]).collect();
            let profile = Profile::new(cells, &faces);
            Grid { cells, profile, psi: Vec::new(), vorticity: Vec::new(), residual: 0.0, steps: 0, seconds: 0.0 }
        };
        let published = Published { re: 1000.0, line: 'u', coord: 0.5, velocity: 0.125, source: BOTELLA.into() };
        let (coarse, fine) = (grid(16), grid(24));
        let checks = against(&[&published], (1000.0, BOTELLA), &fine, &coarse, &fine);
        let [plain, extrapolated] = checks.as_slice() else { panic!("{checks:?}") };
        assert!((plain.measured.expect("a number") - 24.0_f64.powi(-2)).abs() < 1e-12);
        assert!(extrapolated.measured.expect("a number") < 1e-12, "{extrapolated:?}");
    }
}
