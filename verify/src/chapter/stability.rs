//! Absolute stability of every method with fixed steps, from live steps on normal systems.

use std::f64::consts::SQRT_2;
use std::sync::Arc;

use super::{Context, Study, StudyError, prose};
use crate::evidence::{Axis, Cell, Check, Evidence, Field, Figure, Mark, Panel, Requirement, Series, Table};
use crate::experiment::stability::{FAR, Found, Growth, Points, Profile, ROUNDOFF, StableInterval, Subjects};
use crate::kinds::Stability;
use crate::measure::norm::Extremes;
use crate::method;
use crate::row;

pub(super) const STUDY: Study = Study {
    id: "stability",
    title: "Regions of absolute stability",
    question: "For which hλ does each method damp v̇ = λv, is it A-stable, and does it damp at infinity?",
    source: "[S24] Section 3, Eqs. (21)–(27); claims a, b, c",
    run,
};

/// A method damps at infinity if its factor at |hλ| = [`FAR`] is below this: 2/√|hλ|, because the roots of two-step methods
/// vanish as slowly as 1/√(2|hλ|).
const DAMPED: f64 = 2e-3;
/// Bands of the maps.
const LEVELS: [f64; 4] = [0.1, 0.3, 0.6, 1.0 + ROUNDOFF];
const BANDS: [&str; 5] = ["|R| below 0.1", "0.1 to 0.3", "0.3 to 0.6", "0.6 to 1: stable", "above 1: unstable"];

/// What is found of a method.
struct Class {
    name: String,
    declared: Stability,
    found: Arc<Found>,
    /// Lengths of the stable parts of the negative real and the imaginary axis, counted from 0.
    real: f64,
    imaginary: f64,
}

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let subjects = context.get(Subjects)?;
    let classes = classes(context, &subjects)?;
    let mut evidence = Evidence {
        checks: classes.iter().map(check).collect(),
        tables: vec![table(&classes)],
        notes: prose::fill(include_str!("stability.md"), &[])?,
        ..Evidence::default()
    };
    regions(&mut evidence, context, &subjects)?;
    along_axes(&mut evidence, context)?;
    family(&mut evidence, context)?;
    evidence.checks.extend(known_limits(&classes));
    Ok(evidence)
}

fn table(classes: &[Class]) -> Table {
    let rows = classes.iter().map(|class| {
        let (found, yes) = (&class.found, |holds: bool| if holds { "yes" } else { "no" });
        let [a_stable, damps] = [found.is_a_stable(), found.far <= DAMPED].map(yes);
        // On an axis the other part is the rounding of the angle.
        let part = |x: f64| if x.abs() < 4.0 * f64::EPSILON * found.at.norm() { 0.0 } else { x };
        let start = row![&class.name, found.largest, part(found.at.re), part(found.at.im), a_stable];
        [start, row![found.far, damps, class.real, class.imaginary]].concat()
    });
    Table::new(
        "stability",
        "What a search with live steps on v̇ = λv finds: the largest growth for Re hλ ≤ 0 and where it is met, the growth at \
         |hλ| = 10⁶, and the stable parts of the negative real and the imaginary axis, counted from 0.",
        [
            "method",
            "largest_growth",
            "at_re",
            "at_im",
            "a_stable",
            "growth_at_infinity",
            "damps_at_infinity",
            "real_interval",
            "imaginary_interval",
        ],
        rows.collect(),
    )
}

fn classes(context: &Context, subjects: &[String]) -> Result<Vec<Class>, StudyError> {
    let profile = |method: &String| Profile { method: method.clone(), radii: 40, directions: 13 };
    let found = context.get_each(subjects.iter().map(profile).collect())?;
    let class = |(name, found): (&String, Arc<Found>)| {
        let interval = |turn| context.get(StableInterval { method: name.clone(), turn });
        let declared = method::parse(name)?.stability();
        Ok(Class { name: name.clone(), declared, found, real: *interval(1.0)?, imaginary: *interval(0.5)? })
    };
    subjects.iter().zip(found).map(class).collect()
}

fn check(class: &Class) -> Check {
    let Class { name, declared, found, real, .. } = class;
    let (claim, measured, required) = match declared {
        Stability::Damping if found.is_a_stable() => {
            ("is A-stable and damps at infinity", found.far, Requirement::AtMost(DAMPED))
        }
        Stability::Neutral if found.is_a_stable() => {
            ("is A-stable and does not damp at infinity", found.far, Requirement::AtLeast(DAMPED))
        }
        Stability::Damping | Stability::Neutral => ("is A-stable", found.largest, Requirement::AtMost(1.0 + ROUNDOFF)),
        Stability::Conditional if found.is_a_stable() => {
            ("is not A-stable", found.largest, Requirement::AtLeast(1.0 + ROUNDOFF))
        }
        Stability::Conditional => ("is stable for small steps, and not A-stable", *real, Requirement::Above(0.0)),
        Stability::Unstable => ("is stable on no part of the negative real axis", *real, Requirement::AtMost(0.0)),
    };
    let reason = "live steps over the left half-plane, |hλ| from 10⁻² to 10⁴ in 40 radii and 13 directions";
    Check::new(format!("class/{name}"), format!("{name} {claim}"), measured, required, reason)
}

/// |R| of every method as maps.
fn regions(evidence: &mut Evidence, context: &Context, subjects: &[String]) -> Result<(), StudyError> {
    let growth = |method: &String| Growth { method: method.clone(), points: Points::Grid };
    let maps = context.get_each(subjects.iter().map(growth).collect())?;
    let (re, im) = (Points::re(), Points::im());
    let panels = subjects.iter().zip(&maps).map(|(method, values)| {
        let guide = Series::new("Re hλ = 0", vec![(0.0, 0.0), (0.0, 6.0)], Mark::Guide);
        // Where there is no step the map stays blank; a factor of 0 is one below all levels.
        let shown = |growth: &f64| if growth.is_finite() { growth.max(0.1 * LEVELS[0]) } else { f64::NAN };
        let field = Field {
            x: re.clone(),
            y: im.clone(),
            values: values.chunks(re.len()).map(|row| row.iter().map(shown).map(f64::log10).collect()).collect(),
            // On either side of 1.
            levels: LEVELS.map(f64::log10).to_vec(),
            bands: BANDS.map(Into::into).to_vec(),
            contours: true,
        };
        let points = im.iter().flat_map(|y| re.iter().map(move |x| (*x, *y)));
        let undetermined = points.zip(values.iter()).filter(|(_, growth)| !growth.is_finite()).map(|(point, _)| point);
        let undetermined: Vec<_> = undetermined.collect();
        let marked = (!undetermined.is_empty()).then(|| Series::new("no R", undetermined, Mark::Markers));
        let series = std::iter::once(guide).chain(marked).collect();
        Panel::new(Axis::linear("Re hλ"), Axis::linear("Im hλ"), series).titled(method).over(field)
    });
    let caption = "Amplification factor |R| of one step on v̇ = λv; the lower half-plane mirrors the upper one. A method is A-stable only if no \
                   point left of 0 has the colour of |R| > 1, here and outside of the picture. At the points marked the step has no solution, or every number is one.";
    evidence.figures.push(Figure::new("stability-regions", caption, "stability-regions", panels).in_columns(3));
    let columns = ["re", "im"].into_iter().chain(subjects.iter().map(String::as_str));
    let points = im.iter().flat_map(|y| re.iter().map(move |x| row![*x, *y]));
    let rows = points.enumerate().map(|(i, mut row)| {
        row.extend(maps.iter().map(|map| if map[i].is_finite() { Cell::Number(map[i]) } else { Cell::Empty }));
        row
    });
    let caption = "Growth |R| of one step on v̇ = λv by method.";
    evidence.tables.push(Table::data("stability-regions", caption, columns, rows.collect()));
    Ok(())
}

/// Growth along the negative real and the imaginary axis.
fn along_axes(evidence: &mut Evidence, context: &Context) -> Result<(), StudyError> {
    const SHOWN: [&str; 8] =
        ["method-i", "method-ii", "linear(-0.5,1)", "window(4)", "implicit-euler", "sdirk2", "bdf2", "rk4"];
    const AXES: [(&str, &str, f64); 2] = [("negative real axis", "−hλ", 1.0), ("imaginary axis", "|hλ|", 0.5)];
    let radii = Points::radii();
    let mut rows = Vec::new();
    for (title, _, turn) in AXES {
        let growth = |method: &str| Growth { method: method.into(), points: Points::Ray(turn) };
        for (method, curve) in SHOWN.iter().zip(context.get_each(SHOWN.map(growth).into())?) {
            let name = method::parse(method)?.name();
            let drawn = radii.iter().zip(curve.iter()).filter(|(_, growth)| **growth <= 100.0);
            rows.extend(drawn.map(|(r, growth)| row![title, &name, *r, *growth]));
        }
    }
    let columns = ["axis", "method", "radius", "growth"];
    let table = Table::data("stability-axes", "Amplification factor |R| along two rays.", columns, rows);
    let panels = AXES.map(|(title, label, _)| {
        let mut curves = table.where_text("axis", title).curves("method", "radius", "growth", Mark::Line);
        curves.push(Series::new("|R| = 1", vec![(radii[0], 1.0), (radii[radii.len() - 1], 1.0)], Mark::Guide));
        Panel::new(Axis::log(label), Axis::log("|R| for each step"), curves).titled(title)
    });
    let caption = "Amplification factor |R| along two rays. Method I damps like 2/|hλ|² on the real axis, implicit Euler like 1/|hλ|; the \
                   factor of Method II passes through 0 at hλ = −2 and returns to 1.";
    evidence.figures.push(Figure::new("stability-axes", caption, "stability-axes", panels).in_columns(2));
    evidence.tables.push(table);
    Ok(())
}

/// The closures (α, β) by the ratio α/β.
fn family(evidence: &mut Evidence, context: &Context) -> Result<(), StudyError> {
    let ratios: Vec<f64> = (-30..=30).map(|k| 0.05 * f64::from(k)).collect();
    // At −1 and on a circle of growth the left half-plane has points of its own for each radius.
    let profile = |ratio: &f64| Profile { method: format!("linear({ratio},1)"), radii: 30, directions: 9 };
    let found = context.get_each(ratios.iter().map(profile).collect())?;
    let found: Vec<&Found> = found.iter().map(|found| &**found).collect();
    evidence.checks.extend(theorem(&ratios, &found));
    let members = || ratios.iter().zip(&found);
    let curve = |f: fn(&Found) -> f64| members().map(|(ratio, found)| (*ratio, f(found))).collect();
    let curves = vec![
        Series::new("largest |R| for Re hλ ≤ 0", curve(|found| found.largest), Mark::LineMarkers),
        Series::new("|R| at hλ = −10⁶", curve(|found| found.on_axis), Mark::Line),
        Series::new("|R| = 1", vec![(-1.5, 1.0), (1.5, 1.0)], Mark::Guide),
    ];
    let panel = Panel::new(Axis::linear("α/β"), Axis::linear("|R|").between(0.0, 2.0), curves);
    let caption = "The closures (α, β): largest growth over the left half-plane, and damping at infinity. Method \
                   I is at 0, Method II at −1.";
    evidence.figures.push(Figure::new("stability-family", caption, "stability-family", [panel]));
    let caption = "Largest growth for Re hλ ≤ 0 and growth at hλ = −10⁶ of the closures (α, β).";
    let columns = ["alpha_over_beta", "largest_growth", "growth_at_infinity"];
    let rows = members().map(|(ratio, found)| row![*ratio, found.largest, found.on_axis]).collect();
    evidence.tables.push(Table::data("stability-family", caption, columns, rows));
    Ok(())
}

/// What linear theory says of the closures with these ratios α/β.
fn theorem(ratios: &[f64], found: &[&Found]) -> [Check; 2] {
    let members = || ratios.iter().zip(found);
    let agrees =
        |(ratio, found): &(&f64, &&Found)| (ratio.abs() <= 1.0) == found.is_a_stable() && !found.largest.is_nan();
    let disagreeing = members().filter(|member| !agrees(member)).count();
    // R(z) = α/β (1 − 4/|z|) up to terms of second order, which is within 6/|z| of α/β for |α/β| up to 1.5.
    let at_infinity = members().map(|(ratio, found)| (found.on_axis - ratio.abs()).abs()).largest();
    [
        Check::new(
            "theorem/a-stable",
            "The closure (α, β) is A-stable if and only if |α| ≤ |β|: members for which the search disagrees",
            disagreeing as f64,
            Requirement::AtMost(0.0),
            format!("{} ratios α/β from −1.5 to 1.5", ratios.len()),
        ),
        Check::new(
            "theorem/infinity",
            "|R(∞)| = |α/β|, so that the closure damps at infinity if and only if α = 0: largest deviation",
            at_infinity,
            Requirement::AtMost(10.0 / FAR),
            "at hλ = −10⁶, where the next term is of order 1/|hλ|",
        ),
    ]
}

/// Limits that are known: they test the search itself.
fn known_limits(classes: &[Class]) -> Vec<Check> {
    let known = [
        ("rk4", "negative real axis", 2.785_293_563_405_282, "the real root of 24 + 12z + 4z² + z³ = 0"),
        ("rk4", "imaginary axis", 2.0 * SQRT_2, "|R(iy)|² = 1 − y⁶/72 + y⁸/576"),
        ("explicit-momentum", "negative real axis", 2.0, "1 − h + h²/2 = 1, Eq. (21)"),
    ];
    let find = |(name, axis, exact, source): (&str, &str, f64, &str)| {
        let class = classes.iter().find(|class| class.name == name)?;
        let found = if axis == "imaginary axis" { class.imaginary } else { class.real };
        // Where |R| = 1 is crossed with a slope of order 1, the allowance for roundoff moves the limit by as much.
        let required = Requirement::Within(exact - 1e-6, exact + 1e-6);
        let statement = format!("{name} is stable on the {axis} up to {exact:.6}");
        Some(Check::new(format!("limit/{name}/{axis}"), statement, found, required, source))
    };
    known.into_iter().filter_map(find).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;
    use nalgebra::Complex;

    fn found(largest: f64, on_axis: f64, far: f64) -> Found {
        Found { largest, at: Complex::new(-1.0, 2.0), on_axis, far }
    }

    fn class(name: &str, declared: Stability, found: Found, [real, imaginary]: [f64; 2]) -> Class {
        Class { name: name.into(), declared, found: Arc::new(found), real, imaginary }
    }

    #[test]
    fn what_is_found_of_a_method_stands_under_its_name() {
        let table = table(&[class("some", Stability::Conditional, found(3.0, 4.0, 5.0), [6.0, 7.0])]);
        for (name, value) in [
            ("largest_growth", 3.0),
            ("at_re", -1.0),
            ("at_im", 2.0),
            ("growth_at_infinity", 5.0),
            ("real_interval", 6.0),
            ("imaginary_interval", 7.0),
        ] {
            assert_eq!(table.rows[0][table.column(name).expect("a column")].number(), Some(value), "{name}");
        }
        let is_yes = |largest: f64, far: f64| {
            let table = super::table(&[class("some", Stability::Damping, found(largest, far, far), [1.0; 2])]);
            ["a_stable", "damps_at_infinity"].map(|name| table.where_text(name, "yes").rows.len() == 1)
        };
        assert_eq!(is_yes(1.0, 1e-3), [true, true]);
        assert_eq!(is_yes(1.1, 1e-3), [false, true]);
        assert_eq!(is_yes(1.0, 0.1), [true, false]);
        assert_eq!(is_yes(f64::NAN, f64::NAN), [false, false]);
    }

    /// Each kind is held to both of its ends.
    #[test]
    fn a_method_of_another_kind_than_declared_fails() {
        use Stability::{Conditional, Damping, Neutral, Unstable};
        let is_met = |declared, largest: f64, far: f64, real: f64| {
            check(&class("some", declared, found(largest, far, far), [real, 1.0])).outcome == Outcome::Pass
        };
        for (declared, largest, far, real) in [
            (Damping, 1.0, 1e-3, 1.0),
            (Neutral, 1.0, 0.5, 1.0),
            (Conditional, 9.0, 9.0, 2.0),
            (Unstable, 9.0, 9.0, 0.0),
        ] {
            assert!(is_met(declared, largest, far, real), "{declared:?}");
        }
        for (declared, largest, far, real) in [
            (Damping, 1.0, 3e-3, 1.0),
            (Damping, 1.1, 1e-3, 1.0),
            (Damping, 1.0, f64::NAN, 1.0),
            (Neutral, 1.0, 1e-3, 1.0),
            (Neutral, 1.1, 0.5, 1.0),
            (Neutral, f64::NAN, 0.5, 1.0),
            (Conditional, 1.0, 0.5, 2.0),
            (Conditional, 9.0, 9.0, 0.0),
            (Conditional, 9.0, 9.0, f64::NAN),
            (Unstable, 9.0, 9.0, 0.1),
            (Unstable, 9.0, 9.0, f64::NAN),
        ] {
            assert!(!is_met(declared, largest, far, real), "{declared:?} {largest} {far} {real}");
        }
    }

    /// |R| differs from |α/β| by up to 6/|hλ| where it follows theory.
    #[test]
    fn one_member_that_departs_from_theory_fails() {
        let ratios = [-1.2, -0.5, 0.0, 1.0, 1.2];
        let outcomes = |place: usize, growth: f64, off: f64| {
            let mut members = ratios.map(|ratio: f64| found(ratio.abs().max(1.0), ratio.abs(), ratio.abs()));
            members[place].largest *= growth;
            members[place].on_axis += off;
            theorem(&ratios, &members.each_ref()).map(|check| check.outcome == Outcome::Pass)
        };
        for (place, ratio) in ratios.into_iter().enumerate() {
            assert_eq!(outcomes(place, 1.0, 6.0 / FAR), [true, true], "{place}");
            let other = if ratio.abs() > 1.0 { 0.5 } else { 1.1 };
            assert_eq!(outcomes(place, other, 0.0), [false, true], "{place}");
            assert_eq!(outcomes(place, f64::NAN, 0.0), [false, true], "{place}");
            assert_eq!(outcomes(place, 1.0, 11.0 / FAR), [true, false], "{place}");
            assert_eq!(outcomes(place, 1.0, f64::NAN), [true, false], "{place}");
        }
    }

    /// 24 + 12z + 4z² + z³ = 0 and y⁶/72 = y⁸/576 bound rk4, and h = 2 the explicit closure.
    #[test]
    fn a_search_that_misses_a_known_limit_fails() {
        let outcomes = |[real, imaginary, explicit]: [f64; 3]| {
            let limits = [2.785_293_563_405_282 + real, 8_f64.sqrt() + imaginary];
            let classes = [
                class("rk4", Stability::Conditional, found(9.0, 9.0, 9.0), limits),
                class("explicit-momentum", Stability::Conditional, found(9.0, 9.0, 9.0), [2.0 + explicit, 0.0]),
            ];
            known_limits(&classes).into_iter().map(|check| check.outcome == Outcome::Pass).collect::<Vec<_>>()
        };
        assert_eq!(outcomes([0.9e-6, -0.9e-6, 0.9e-6]), [true; 3]);
        for place in 0..3 {
            for off in [1.1e-6, -1.1e-6, f64::NAN] {
                let mut all = [0.0; 3];
                all[place] = off;
                let expected: Vec<bool> = (0..3).map(|other| other != place).collect();
                assert_eq!(outcomes(all), expected, "{off}");
            }
        }
    }
}
