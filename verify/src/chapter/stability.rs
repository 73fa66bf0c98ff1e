//! Absolute stability of every method with fixed steps, from live steps on normal systems.

use std::f64::consts::{FRAC_PI_2, PI, SQRT_2};

use nalgebra::Complex;
use rayon::prelude::*;

use super::{Context, Study, StudyError};
use crate::evidence::{Axis, Cell, Check, Evidence, Field, Figure, Mark, Panel, Requirement, Series, Table};
use crate::experiment::propagator::amplitudes;
use crate::kinds::Stability;
use crate::measure::norm::Extremes;
use crate::measure::search::root;
use crate::measure::stability::growth;
use crate::method::{self, Method};

pub(super) const STUDY: Study = Study {
    id: "stability",
    title: "Regions of absolute stability",
    question: "For which hλ does each method damp v̇ = λv, is it A-stable, and does it damp at infinity?",
    source: "[S24] Section 3, Eqs. (21)–(27); claims a, b, c",
    run,
};

/// Growth beyond 1 by less than this is roundoff: a recurrence with two roots loses up to half of the digits.
const ROUNDOFF: f64 = 1e-7;
/// A method damps at infinity if its factor at |hλ| = [`FAR`] is below this: 2/√|hλ|, because the roots of two-step methods
/// vanish as slowly as 1/√(2|hλ|).
const DAMPED: f64 = 2e-3;
const FAR: f64 = 1e6;
/// Bands of the maps.
const LEVELS: [f64; 4] = [0.1, 0.3, 0.6, 1.0 + ROUNDOFF];
const BANDS: [&str; 5] = ["|R| below 0.1", "0.1 to 0.3", "0.3 to 0.6", "0.6 to 1: stable", "above 1: unstable"];

/// |R| over one solution of the equations; NaN where the step has no solution.
fn factor(method: &dyn Method, z: Complex<f64>) -> f64 {
    amplitudes(method, z).map_or(f64::NAN, growth)
}

/// |R| for each row.
fn factor_per_row(method: &dyn Method, z: Complex<f64>) -> f64 {
    factor(method, z).powf((method.traits().rows_per_solve as f64).recip())
}

/// The methods that make steps of the given size on v̇ = Av.
fn subjects() -> Vec<Box<dyn Method>> {
    let applies = |method: &dyn Method| amplitudes(method, Complex::new(-0.1, 0.0)).is_ok();
    method::examples().into_iter().filter(|method| applies(&**method)).collect()
}

/// What a search over the left half-plane found.
struct Profile {
    name: String,
    declared: Stability,
    /// Largest factor for Re z ≤ 0, and where.
    largest: f64,
    at: Complex<f64>,
    /// Largest factor for |z| = [`FAR`] and Re z ≤ 0.
    far: f64,
    /// Lengths of the stable parts of the negative real and the imaginary axis, counted from 0.
    real: f64,
    imaginary: f64,
}

impl Profile {
    fn of(method: &dyn Method) -> Self {
        let (mut largest, mut at) = (0.0, Complex::new(0.0, 0.0));
        for z in left_half_plane(40, 13) {
            let r = factor_per_row(method, z);
            // A step without a solution is no stable step.
            if r.is_nan() || r > largest {
                (largest, at) = (if r.is_nan() { f64::INFINITY } else { r }, z);
            }
        }
        let far = [0.5, 0.51, 0.75, 1.0].map(|turn| factor(method, Complex::from_polar(FAR, turn * PI)));
        let interval = |turn: f64| stable_interval(|r| factor(method, Complex::from_polar(r, turn * PI)));
        Self {
            name: method.name(),
            declared: method.stability(),
            largest,
            at,
            far: far.into_iter().fold(0.0, |m: f64, r| if r.is_nan() { f64::INFINITY } else { m.max(r) }),
            real: interval(1.0),
            imaginary: interval(0.5),
        }
    }

    fn is_a_stable(&self) -> bool {
        self.largest <= 1.0 + ROUNDOFF
    }

    fn check(&self) -> Check {
        let (claim, measured, required) = match self.declared {
            Stability::Damping if self.is_a_stable() => {
                ("is A-stable and damps at infinity", self.far, Requirement::AtMost(DAMPED))
            }
            Stability::Neutral if self.is_a_stable() => {
                ("is A-stable and does not damp at infinity", self.far, Requirement::AtLeast(DAMPED))
            }
            Stability::Damping | Stability::Neutral => {
                ("is A-stable", self.largest, Requirement::AtMost(1.0 + ROUNDOFF))
            }
            Stability::Conditional if self.is_a_stable() => {
                ("is not A-stable", self.largest, Requirement::AtLeast(1.0 + ROUNDOFF))
            }
            Stability::Conditional => ("is stable for small steps only", self.real, Requirement::Within(0.1, 100.0)),
            Stability::Unstable => {
                ("is stable on no part of the negative real axis", self.real, Requirement::AtMost(0.0))
            }
        };
        let reason = "live steps over the left half-plane, |hλ| from 10⁻² to 10⁴ in 40 radii and 13 directions";
        Check::new(format!("class/{}", self.name), format!("{} {claim}", self.name), measured, required, reason)
    }

    fn row(&self) -> Vec<Cell> {
        vec![
            Cell::Text(self.name.clone()),
            Cell::Number(self.largest),
            Cell::Number(self.at.re),
            Cell::Number(self.at.im),
            Cell::Text(if self.is_a_stable() { "yes" } else { "no" }.into()),
            Cell::Number(self.far),
            Cell::Text(if self.far <= DAMPED { "yes" } else { "no" }.into()),
            Cell::Number(self.real),
            Cell::Number(self.imaginary),
        ]
    }
}

/// Points of the upper left quarter-plane, |z| from 0.01 to 10⁴; the lower one mirrors it, because the methods are real.
fn left_half_plane(radii: u32, directions: u32) -> impl Iterator<Item = Complex<f64>> {
    (0..radii).flat_map(move |i| {
        let radius = 10_f64.powf(6.0 * f64::from(i) / f64::from(radii - 1) - 2.0);
        (0..directions)
            .map(move |k| Complex::from_polar(radius, FRAC_PI_2 * (1.0 + f64::from(k) / f64::from(directions - 1))))
    })
}

/// The largest r such that the factor is at most 1 from 0 to r; 0 if it is not at 0.1, infinite if it is up to 100.
fn stable_interval(factor: impl Fn(f64) -> f64) -> f64 {
    let is_stable = |r: f64| factor(r) <= 1.0 + ROUNDOFF;
    let mut reached = 0.1;
    if !is_stable(reached) {
        return 0.0;
    }
    let mut ahead = 1.05 * reached;
    while is_stable(ahead) {
        if ahead > 100.0 {
            return f64::INFINITY;
        }
        (reached, ahead) = (ahead, 1.05 * ahead);
    }
    // A step that fails has no factor, and is not stable.
    root([reached, ahead], |r| if is_stable(r) { 1.0 } else { -1.0 }).unwrap_or(f64::NAN)
}

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let subjects = subjects();
    context.announce(2 * subjects.len() + 1);
    let profiles: Vec<Profile> = subjects
        .par_iter()
        .map(|method| {
            let profile = Profile::of(&**method);
            context.tick();
            profile
        })
        .collect();
    let (regions, map) = regions(&subjects, context);
    let (axes, along) = along_axes()?;
    let family = family()?;
    context.tick();
    let mut checks: Vec<Check> = profiles.iter().map(Profile::check).collect();
    checks.extend(family.checks());
    checks.extend(known_limits(&profiles));
    let classes = Table::new(
        "stability",
        "What a search with live steps on v̇ = λv finds: the largest growth for Re hλ ≤ 0 and where it is met, the growth at \
         |hλ| = 10⁶, and the stable parts of the negative real and the imaginary axis, counted from 0.",
        &[
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
        profiles.iter().map(Profile::row).collect(),
    );
    let (family_figure, family_table) = family.show();
    Ok(Evidence {
        checks,
        tables: vec![classes, map, along, family_table],
        figures: vec![regions, axes, family_figure],
        notes: notes(),
        ..Evidence::default()
    })
}

fn notes() -> Vec<String> {
    vec![
        "Every number is a live step, of size h = 1, on the real system v̇ = ((x, −y), (y, x)) v, which is v̇ = (x + iy) v for \
         a complex v; no stability function is typed in. Methods with a memory, `bdf2` and `conventional`, are judged by both \
         roots of the recurrence that four of their values satisfy, so that a root that a run happens not to excite counts \
         too. `window(K)` is judged over whole windows; its map shows the growth for each step."
            .into(),
        "The closure (α, β) is A-stable if and only if |α| ≤ |β|, and damps at infinity if and only if α = 0: the search \
         agrees with this theorem on every member it tries. So Method I is the one member of the family that is L-stable, and \
         the price of damping is accuracy for moderate hλ. Fitted closures are drawn at the fit hLAMBDA of their name; away \
         from it they are members of the family with that θ."
            .into(),
        "Unlike a Runge–Kutta method's, the factor of these closures is no analytic function of hλ: the transpose of the \
         Jacobian brings in the complex conjugate of λ. The maximum over the left half-plane need not lie on the imaginary \
         axis, which is why the search covers the whole of it."
            .into(),
    ]
}

/// |R| of every method as maps.
fn regions(subjects: &[Box<dyn Method>], context: &Context) -> (Figure, Table) {
    let x: Vec<f64> = (0..61).map(|i| -8.0 + 0.2 * f64::from(i)).collect();
    let y: Vec<f64> = (0..31).map(|j| 0.2 * f64::from(j)).collect();
    let maps: Vec<Vec<Vec<f64>>> = subjects
        .par_iter()
        .map(|method| {
            let row = |y: &f64| x.iter().map(|x| factor_per_row(&**method, Complex::new(*x, *y))).collect();
            let map = y.iter().map(row).collect();
            context.tick();
            map
        })
        .collect();
    let panels = subjects.iter().zip(&maps).map(|(method, values)| Panel {
        title: method.name(),
        x: Axis::linear("Re hλ"),
        y: Axis::linear("Im hλ"),
        series: vec![Series::new("Re hλ = 0", vec![(0.0, 0.0), (0.0, 6.0)], Mark::Guide)],
        field: Some(Field {
            x: x.clone(),
            y: y.clone(),
            values: values.clone(),
            levels: LEVELS.to_vec(),
            bands: BANDS.map(Into::into).to_vec(),
            contours: true,
        }),
    });
    let figure = Figure {
        id: "stability-regions".into(),
        caption:
            "Growth |R| of one step on v̇ = λv; the lower half-plane mirrors the upper one. A method is A-stable if no \
                  point left of 0 has the colour of growth. Blank: the step has no solution."
                .into(),
        data: "stability-regions".into(),
        panels: panels.collect(),
        columns: 3,
    };
    let columns: Vec<String> =
        ["re", "im"].map(Into::into).into_iter().chain(subjects.iter().map(|method| method.name())).collect();
    let mut rows = Vec::new();
    for (j, y) in y.iter().enumerate() {
        for (i, x) in x.iter().enumerate() {
            let values = maps.iter().map(|map| Cell::found(map[j][i]));
            rows.push([*x, *y].map(Cell::Number).into_iter().chain(values).collect());
        }
    }
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    (figure, Table::data("stability-regions", "Growth |R| of one step on v̇ = λv by method.", &columns, rows))
}

/// Growth along the negative real and the imaginary axis.
fn along_axes() -> Result<(Figure, Table), StudyError> {
    const SHOWN: [&str; 8] =
        ["method-i", "method-ii", "linear(-0.5,1)", "window(4)", "implicit-euler", "sdirk2", "bdf2", "rk4"];
    let methods = SHOWN.iter().map(|call| method::parse(call)).collect::<Result<Vec<_>, _>>()?;
    let radii: Vec<f64> = (0..=60).map(|i| 10_f64.powf(f64::from(i) / 15.0 - 1.0)).collect();
    let mut rows = Vec::new();
    let mut panels = Vec::new();
    for (title, label, turn) in [("negative real axis", "−hλ", 1.0), ("imaginary axis", "|hλ|", 0.5)] {
        let curves: Vec<Vec<(f64, f64)>> = methods
            .par_iter()
            .map(|method| {
                let at = |r: &f64| (*r, factor_per_row(&**method, Complex::from_polar(*r, turn * PI)));
                radii.iter().map(at).filter(|(_, growth)| *growth <= 100.0).collect()
            })
            .collect();
        for (method, curve) in methods.iter().zip(&curves) {
            let name = || Cell::Text(method.name());
            rows.extend(
                curve
                    .iter()
                    .map(|(r, growth)| vec![Cell::Text(title.into()), name(), Cell::found(*r), Cell::found(*growth)]),
            );
        }
        let drawn = methods.iter().zip(curves).map(|(method, points)| Series::new(method.name(), points, Mark::Line));
        let one = Series::new("|R| = 1", vec![(radii[0], 1.0), (radii[radii.len() - 1], 1.0)], Mark::Guide);
        panels.push(Panel {
            title: title.into(),
            x: Axis::log(label),
            y: Axis::log("|R| for each step"),
            series: drawn.chain([one]).collect(),
            field: None,
        });
    }
    let figure = Figure {
        id: "stability-axes".into(),
        caption:
            "Growth |R| along two rays. Method I damps like 2/|hλ|² on the real axis, implicit Euler like 1/|hλ|; the \
                  factor of Method II passes through 0 at hλ = −2 and returns to 1."
                .into(),
        data: "stability-axes".into(),
        panels,
        columns: 2,
    };
    Ok((
        figure,
        Table::data("stability-axes", "Growth |R| along two rays.", &["axis", "method", "radius", "growth"], rows),
    ))
}

/// The closures (α, β) by the ratio α/β.
struct Family {
    /// (α/β, largest growth for Re z ≤ 0, growth at infinity).
    members: Vec<(f64, f64, f64)>,
}

fn family() -> Result<Family, StudyError> {
    let members = (-30..=30).into_par_iter().map(|k| {
        let ratio = 0.05 * f64::from(k);
        let method = method::parse(&format!("linear({ratio},1)"))?;
        // At −1 and on a circle of growth the left half-plane has points of its own for each radius.
        let growths = left_half_plane(30, 9).map(|z| factor(&*method, z));
        let largest = growths.fold(0.0, |m: f64, r| if r.is_nan() { f64::INFINITY } else { m.max(r) });
        Ok((ratio, largest, factor(&*method, Complex::new(-FAR, 0.0))))
    });
    Ok(Family { members: members.collect::<Result<_, StudyError>>()? })
}

impl Family {
    fn checks(&self) -> [Check; 2] {
        let inside = |ratio: f64| ratio.abs() <= 1.0;
        let wrong = |(ratio, largest, _): &&(f64, f64, f64)| inside(*ratio) != (*largest <= 1.0 + ROUNDOFF);
        let disagreeing = self.members.iter().filter(wrong).count();
        // R(∞) = α/β up to terms of order 1/|z|, with a factor of at most 4.
        let at_infinity = self.members.iter().map(|(ratio, _, far)| (far - ratio.abs()).abs()).largest();
        [
            Check::new(
                "theorem/a-stable",
                "The closure (α, β) is A-stable if and only if |α| ≤ |β|: members for which the search disagrees",
                disagreeing as f64,
                Requirement::AtMost(0.0),
                format!("{} ratios α/β from −1.5 to 1.5", self.members.len()),
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

    fn show(&self) -> (Figure, Table) {
        let curve = |f: fn(&(f64, f64, f64)) -> f64| self.members.iter().map(|m| (m.0, f(m))).collect();
        let panel = Panel {
            x: Axis::linear("α/β"),
            y: Axis::linear("|R|").between(0.0, 2.0),
            series: vec![
                Series::new("largest |R| for Re hλ ≤ 0", curve(|m| m.1.min(2.0)), Mark::LineMarkers),
                Series::new("|R| at hλ = −10⁶", curve(|m| m.2), Mark::Line),
                Series::new("|R| = 1", vec![(-1.5, 1.0), (1.5, 1.0)], Mark::Guide),
            ],
            ..Panel::default()
        };
        let figure = Figure {
            id: "stability-family".into(),
            caption: "The closures (α, β): largest growth over the left half-plane, cut off at 2, and damping at infinity. Method \
                      I is at 0, Method II at −1."
                .into(),
            data: "stability-family".into(),
            panels: vec![panel],
            columns: 1,
        };
        let rows = self.members.iter().map(|(a, b, c)| [*a, *b, *c].map(Cell::Number).to_vec()).collect();
        let caption = "Largest growth for Re hλ ≤ 0 and growth at hλ = −10⁶ of the closures (α, β).";
        (
            figure,
            Table::data(
                "stability-family",
                caption,
                &["alpha_over_beta", "largest_growth", "growth_at_infinity"],
                rows,
            ),
        )
    }
}

/// Limits that are known: they test the search itself.
fn known_limits(profiles: &[Profile]) -> Vec<Check> {
    let known = [
        ("rk4", "negative real axis", 2.785_293_563_405_282, "the real root of 24 + 12z + 4z² + z³ = 0"),
        ("rk4", "imaginary axis", 2.0 * SQRT_2, "|R(iy)|² = 1 − y⁶/72 + y⁸/576"),
        ("explicit-momentum", "negative real axis", 2.0, "1 − h + h²/2 = 1, Eq. (21)"),
    ];
    let find = |(name, axis, exact, source): (&str, &str, f64, &str)| {
        let profile = profiles.iter().find(|profile| profile.name == name)?;
        let found = if axis == "imaginary axis" { profile.imaginary } else { profile.real };
        // Where |R| = 1 is crossed with a slope of order 1, the allowance for roundoff moves the limit by as much.
        let required = Requirement::Within(exact - 1e-6, exact + 1e-6);
        let statement = format!("{name} is stable on the {axis} up to {exact:.6}");
        Some(Check::new(format!("limit/{name}/{axis}"), statement, found, required, source))
    };
    known.into_iter().filter_map(find).collect()
}
