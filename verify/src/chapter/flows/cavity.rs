//! The steady cavity against the literature.

use super::{Context, FULL_ID, ID, Scale, StudyError, map, prose, short, streamlines};
use crate::evidence::number::{digits, rounded_up};
use crate::evidence::{Axis, Check, Evidence, Figure, Mark, Panel, Requirement, Series, Table};
use crate::experiment::flow::profile::{Published, published};
use crate::experiment::flow::steady::{Grid, SteadyCavity};
use crate::measure::norm::Extremes;
use crate::row;

const GHIA: &str = "Ghia 1982";
const BOTELLA: &str = "Botella 1998";
const MARCHI: &str = "Marchi 2009";
/// Tables with more digits than the grids here reach, and who printed them.
const ACCURATE: [(&str, &str); 2] = [(MARCHI, "Marchi et al."), (BOTELLA, "Botella and Peyret")];
/// Re, line, coordinate and velocity of an entry of Ghia's table in most public copies, where the table here has another.
const COPIED: (f64, char, f64, f64) = (400.0, 'v', 0.9063, -0.23827);

/// The check of the steady cavity against a table with more digits than the grids here reach.
pub(super) fn against_marchi(re: f64) -> String {
    format!("steady/{re}/{MARCHI}")
}

/// Those of `reynolds` at which there is a table of Marchi and others, of Botella and Peyret, and of Ghia and others.
pub(super) fn of_each_table(reynolds: &[f64]) -> Result<[Vec<f64>; 3], StudyError> {
    let table = published()?;
    Ok([MARCHI, BOTELLA, GHIA].map(|source| {
        let has = |re: &&f64| table.iter().any(|p| p.re == **re && p.source == source);
        reynolds.iter().filter(has).copied().collect()
    }))
}

pub(super) fn steady(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    let table = published()?;
    let (mut rows, mut reached, mut profiles) = (Vec::new(), Vec::new(), Vec::new());
    let (mut streams, mut vortices) = (Vec::new(), Vec::new());
    let (mut beside, mut held, mut on) = (Vec::new(), Vec::new(), 0);
    for (re, judged, cells) in scale.steady {
        let grids = context.get(SteadyCavity { re: *re, cells })?;
        reached.extend(grids.iter().map(|grid| row![*re, grid.cells, grid.residual, grid.steps]));
        let timings = grids.iter().map(|g| (format!("steady cavity, Re = {re}, N = {}", g.cells), g.seconds));
        evidence.timings.extend(timings);
        let grid = grids.iter().find(|grid| grid.cells == *judged).ok_or("no such grid")?;
        let [.., first, coarse, fine] = grids.as_slice() else { return Err("three grids".into()) };
        let (before, limit) = (Limit([first, coarse]), Limit([coarse, fine]));
        on = grid.cells;
        let of = |source: &str| table.iter().filter(|p| p.re == *re && p.source == source).collect::<Vec<_>>();
        for (source, authors) in ACCURATE {
            let values = of(source);
            if values.is_empty() {
                continue;
            }
            let check = against(&values, (*re, source), before, limit);
            let allowed = check.required.and_then(|required| required.bounds().next());
            let told = [
                ("coarse", coarse.cells.to_string()),
                ("fine", fine.cells.to_string()),
                ("limit", bound(check.measured.unwrap_or(f64::NAN))),
                ("allowed", short(allowed.unwrap_or(f64::NAN))),
                ("authors", authors.into()),
                ("re", short(*re)),
                ("chapter", if scale.rolled.is_some() { FULL_ID } else { ID }.into()),
            ];
            held.extend(prose::fill(include_str!("richardson.md"), &told)?);
            evidence.checks.push(check);
        }
        let ghia = of(GHIA);
        if !ghia.is_empty() {
            let apart = |a: &dyn Fn(&Published) -> f64, b: &dyn Fn(&Published) -> f64| {
                bound(ghia.iter().map(|p| (a(p) - b(p)).abs()).largest())
            };
            let (here, there) = (|p: &Published| grid.profile.at(p.line, p.coord), |p: &Published| p.velocity);
            beside.push((
                short(*re),
                [apart(&here, &there), apart(&here, &|p| limit.at(p)), apart(&|p| limit.at(p), &there)],
            ));
            held.extend(copied(&ghia, grid)?);
        }
        for source in [GHIA, BOTELLA, MARCHI] {
            rows.extend(of(source).into_iter().map(|p| {
                let velocity = grid.profile.at(p.line, p.coord);
                let source = p.source.clone();
                row![*re, grid.cells, p.line.to_string(), p.coord, velocity, limit.at(p), p.velocity, source]
            }));
        }
        for (line, x, y) in [('u', "y", "u at x = ½"), ('v', "x", "v at y = ½")] {
            let mut curves =
                vec![Series::new(format!("N = {}", grid.cells), grid.profile.line(line).to_vec(), Mark::Line)];
            for source in [GHIA, BOTELLA, MARCHI] {
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
    let caption = "Velocities on the centre lines of the steady cavity: computed, as lines, and published, as markers; those of Ghia et al. and \
                   of Marchi et al. as transcribed in public codes.";
    let columns = ["re", "cells", "line", "coord", "velocity", "extrapolated", "published", "source"];
    let id = "cavity-profiles";
    evidence.tables.push(Table::data(id, caption, columns, rows));
    evidence.figures.push(Figure::new(id, caption, id, profiles).in_columns(2));
    let pictures = [
        (
            "streamlines",
            "streamlines. The lid moves to the right and drags a vortex along; where ψ > 0, in the other colour, eddies turn the other way",
            streams,
        ),
        ("vorticity", "vorticity, largest in size along the lid and where the flow meets the right wall", vortices),
    ];
    for (what, seen, panels) in pictures {
        let (id, columns) = (format!("flow-steady-{what}"), panels.len().max(2));
        let caption = format!("Steady cavity by Method I: {seen}.");
        evidence.figures.push(Figure::new(id, caption, steady, panels).in_columns(columns));
    }
    let reynolds = beside.iter().map(|(re, _)| re.clone()).collect::<Vec<_>>().join(", ");
    let list = |k: usize| beside.iter().map(|(_, apart)| apart[k].clone()).collect::<Vec<_>>().join(", ");
    let values = [("cells", on.to_string()), ("re", reynolds), ("ghia", list(0)), ("grid", list(1)), ("off", list(2))];
    evidence.notes.extend(prose::fill(include_str!("steady.md"), &values)?);
    evidence.notes.extend(held);
    Ok(())
}

/// A bound in text.
fn bound(most: f64) -> String {
    short(rounded_up(most, 4))
}

/// Velocities extrapolated from two grids, by second order.
#[derive(Clone, Copy)]
struct Limit<'a>([&'a Grid; 2]);

impl Limit<'_> {
    fn at(self, p: &Published) -> f64 {
        let Self([coarse, fine]) = self;
        let ratio = (fine.cells as f64 / coarse.cells as f64).powi(2);
        let [a, b] = [coarse, fine].map(|grid| grid.profile.at(p.line, p.coord));
        b + (b - a) / (ratio - 1.0)
    }
}

/// What may be left of the error of `limit`, from what it changes of the pair of grids before. The errors of second order are gone from both, so that from N₁ and N₂ to
/// N₂ and N₃ the rest falls by N₁N₂ to N₂N₃ at least.
fn left(values: &[&Published], before: Limit<'_>, limit: Limit<'_>) -> f64 {
    let (Limit([first, _]), Limit([_, last])) = (before, limit);
    let changed = values.iter().map(|p| (limit.at(p) - before.at(p)).abs()).largest();
    changed / (last.cells as f64 / first.cells as f64 - 1.0)
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

/// A table of the literature against the last two grids, extrapolated.
fn against(values: &[&Published], (re, source): (f64, &str), before: Limit<'_>, limit: Limit<'_>) -> Check {
    // Nine decimals of the one table and seven of the other.
    const PRINTED: f64 = 2e-7;
    let Limit([coarse, fine]) = limit;
    Check::new(
        format!("steady/{re}/{source}"),
        format!(
            "Steady cavity, Re = {re}, extrapolated from N = {} and {}: the largest difference from {source} on both centre lines",
            coarse.cells, fine.cells
        ),
        values.iter().map(|p| (limit.at(p) - p.velocity).abs()).largest(),
        Requirement::AtMost(left(values, before, limit) + PRINTED),
        "what the extrapolation changes of the one from the grids before, which is at least what is left times N₃/N₁ − 1, and the digits of the table",
    )
}

/// A map of the vorticity at the interior corners.
fn vorticity(title: &str, grid: &Grid) -> Panel {
    let place: Vec<f64> = (1..grid.cells).map(|i| i as f64 / grid.cells as f64).collect();
    map(title, &place, &grid.vorticity, vec![-5.0, -3.0, -1.0, 0.0, 1.0, 3.0, 5.0], true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;
    use crate::experiment::flow::profile::Profile;

    /// u = y³ + a on all faces of so many cells, v = b.
    fn grid(cells: usize, a: f64, b: f64) -> Grid {
        let u = (0..cells).flat_map(|j| {
            let y = (j as f64 + 0.5) / cells as f64;
            (1..cells).map(move |_| y.powi(3) + a)
        });
        let faces: Vec<f64> = u.chain(vec![b; cells * (cells - 1)]).collect();
        let profile = Profile::new(cells, &faces);
        Grid { cells, profile, psi: Vec::new(), vorticity: Vec::new(), residual: 0.0, steps: 0, seconds: 0.0 }
    }

    /// On three grids whose velocities have an error of second order, and `rest` of the one of fourth order, against a table that is off by `off`.
    fn outcome(rest: f64, off: f64) -> Outcome {
        let table = Published { re: 100.0, line: 'u', coord: 0.5, velocity: 0.125 + off, source: MARCHI.into() };
        let [first, coarse, fine] = [16, 32, 64].map(|cells: usize| {
            let n = cells as f64;
            grid(cells, 2.0 / n.powi(2) + rest / n.powi(4), 0.0)
        });
        against(&[&table], (100.0, MARCHI), Limit([&first, &coarse]), Limit([&coarse, &fine])).outcome
    }

    /// Of c/N⁴ the extrapolation leaves −c/(N₁N₂)², a sixteenth of what the grids before leave: it changes by 15 times that, and 5 times are allowed.
    #[test]
    fn a_table_is_held_to_what_extrapolation_leaves_by_the_grids_before() {
        let rest = 1e4;
        let left = rest / (32.0_f64 * 64.0).powi(2);
        for sign in [1.0, -1.0] {
            assert_eq!(outcome(sign * rest, 0.0), Outcome::Pass);
            assert_eq!(outcome(sign * rest, sign * 3.9 * left), Outcome::Pass);
            assert_eq!(outcome(sign * rest, sign * 4.2 * left), Outcome::Fail);
        }
        // An error of second order alone leaves nothing but the digits.
        assert_eq!([outcome(0.0, 1.9e-7), outcome(0.0, 2.1e-7)], [Outcome::Pass, Outcome::Fail]);
        assert_ne!(outcome(f64::NAN, 0.0), Outcome::Pass);
    }

    #[test]
    fn an_entry_that_copies_have_otherwise_is_a_misprint_only_by_velocities_that_say_so() {
        let table = published().expect("well-formed");
        let values: Vec<&Published> = table.iter().filter(|p| p.re == 400.0 && p.source == GHIA).collect();
        for (own, verdict) in [(-0.389, "a misprint by that"), (-0.24, "the better value by that")] {
            let [said] = &copied(&values, &grid(8, 0.0, own)).expect("complete")[..] else { panic!("one paragraph") };
            let told = "−0.23827 at x = 0.9063 for Re = 400, and −0.3827 is taken here. Method I has";
            assert!(said.contains(told) && said.contains(verdict), "{own}: {said}");
        }
        // There is no such entry for another Reynolds number.
        let values: Vec<&Published> = table.iter().filter(|p| p.re == 100.0 && p.source == GHIA).collect();
        assert!(copied(&values, &grid(8, 0.0, 0.0)).expect("complete").is_empty());
    }

    #[test]
    fn what_is_told_of_extrapolation_is_what_its_check_measured() {
        let scale = Scale { steady: &[(1000.0, 12, &[6, 8, 12])], ..super::super::SMALL };
        let mut evidence = Evidence::default();
        steady(&Context::quick(), &mut evidence, &scale).expect("it runs");
        let checks = evidence.checks.iter().filter(|check| check.id.ends_with(BOTELLA));
        let [measured] = checks.filter_map(|check| check.measured).collect::<Vec<_>>()[..] else { panic!("one check") };
        let told = format!("from 8 and 12 cells the steady cavity by Method I lies within {} of what", bound(measured));
        assert!(evidence.notes.iter().any(|note| note.contains(&told)), "{told}\n{:#?}", evidence.notes);
    }

    #[test]
    fn a_map_of_vorticity_has_its_values_at_the_interior_corners() {
        let values = vec![vec![0.0, 1.0, 2.0], vec![10.0, 11.0, 12.0], vec![20.0, 21.0, 22.0]];
        let grid = Grid { vorticity: values, ..grid(4, 0.0, 0.0) };
        let field = vorticity("", &grid).field.expect("a map");
        assert!(field.is_rectangular());
        for (y, row) in field.y.iter().zip(&field.values) {
            // x is 1/4, 2/4 and 3/4 where it is 0, 1 and 2.
            let is_there = |(x, value): (&f64, &f64)| (value - (4.0 * x - 1.0) - 10.0 * (4.0 * y - 1.0)).abs() < 1e-12;
            assert!(field.x.iter().zip(row).all(is_there), "{row:?} at {y}");
        }
        for place in [&field.x, &field.y] {
            assert_eq!([place.first(), place.last()], [Some(&0.25), Some(&0.75)]);
        }
    }

    #[test]
    fn extrapolation_removes_an_error_of_second_order() {
        let grid = |cells: usize| grid(cells, (cells as f64).powi(-2), 0.0);
        let published = Published { re: 1000.0, line: 'u', coord: 0.5, velocity: 0.125, source: BOTELLA.into() };
        let limit = Limit([&grid(16), &grid(24)]).at(&published);
        assert!((limit - 0.125).abs() < 1e-12, "{limit}");
    }
}
