//! Method I on linear systems whose matrix is not normal: a search for stable systems that it amplifies.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::{Context, Study, StudyError};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Requirement, Series, Table};
use crate::measure::norm::larger;
use crate::measure::stability::{Uniform, numerical_abscissa, spectral_abscissa, spectral_norm, spectral_radius};
use crate::method::{self, Method};
use crate::propagator::propagator;

pub(super) const STUDY: Study = Study {
    id: "non-normal",
    title: "Stable systems that Method I amplifies",
    question: "Is Method I stable for every stable linear system, or only for some kinds?",
    source: "[S24] Section 3; claim b, `unconditionally stable`",
    run,
};

/// The spectral radius and norm of a propagator of order n ≤ 5 are exact to some n² roundings, times the condition of its
/// matrix, which is below 1e4 for the entries below that the search allows.
const ROUNDOFF: f64 = 1e-10;
/// All eigenvalues of a matrix of the search lie left of minus this.
const MARGIN: f64 = 0.05;
/// Largest entry.
const LARGEST: f64 = 10.0;
/// Ascents for each order, random matrices at the start of each, and changes tried in it.
const ASCENTS: usize = 40;
const RANDOM: usize = 20;
const CHANGES: usize = 200;
/// Number of the sequence of random numbers.
const SEED: u64 = 1;

/// A matrix that a search ended with.
struct Found {
    order: usize,
    matrix: DMatrix<f64>,
    radius: f64,
}

/// The largest spectral radius of a live step of `method` that is found among Hurwitz matrices of the given order: the best
/// of many ascents, each from the best of a few random matrices of all sizes.
fn search(method: &dyn Method, order: usize) -> Result<Found, StudyError> {
    let mut random = Uniform::new(SEED + order as u64);
    let mut uniform = move || random.next().unwrap_or_default();
    let mut best = Found { order, matrix: -DMatrix::identity(order, order), radius: 0.0 };
    for _ in 0..ASCENTS {
        let (mut here, mut radius, mut change) = (DMatrix::zeros(order, order), 0.0, 1.0);
        for attempt in 0..RANDOM + CHANGES {
            let size = if attempt < RANDOM { LARGEST * 10_f64.powf(uniform() - 1.0) } else { change };
            let random = DMatrix::from_fn(order, order, |_, _| size * uniform());
            let Some(matrix) = stable(&if attempt < RANDOM { random } else { &here + random }) else { continue };
            let reached = spectral_radius(&propagator(method, &matrix)?);
            if reached > radius {
                (here, radius) = (matrix, reached);
                change *= 2.0;
            } else if attempt >= RANDOM {
                change *= 0.95;
            }
        }
        if radius > best.radius {
            best = Found { matrix: here, radius, ..best };
        }
    }
    Ok(best)
}

/// The matrix shifted to have its eigenvalues left of −[`MARGIN`], with entries of two decimals that can be printed; `None`
/// if they are too large.
fn stable(candidate: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let order = candidate.nrows();
    // Rounding the entries moves the eigenvalues a little.
    let shift = spectral_abscissa(candidate) + 1.2 * MARGIN;
    let matrix = (candidate - shift * DMatrix::identity(order, order)).map(|x| (100.0 * x).round() / 100.0);
    (matrix.amax() <= LARGEST && spectral_abscissa(&matrix) <= -MARGIN).then_some(matrix)
}

/// Random matrices with a negative semidefinite symmetric part of any rank.
fn dissipative(order: usize, count: usize) -> Vec<DMatrix<f64>> {
    let mut random = Uniform::new(SEED);
    let mut uniform = move || random.next().unwrap_or_default();
    let mut matrix = |k: usize| {
        let (damping, turning) = (4.0 * uniform().abs(), 8.0 * uniform().abs());
        let b = DMatrix::from_fn(1 + k % order, order, |_, _| damping * uniform());
        let c = DMatrix::from_fn(order, order, |_, _| turning * uniform());
        0.5 * (&c - c.transpose()) - b.transpose() * b
    };
    (0..count).map(&mut matrix).collect()
}

fn run(context: &Context) -> Result<Evidence, StudyError> {
    (context.announce)(6);
    let (method_i, rule) = (method::parse("method-i")?, method::parse("trapezoidal")?);
    let found = [2, 3, 4, 5].into_par_iter().map(|order| {
        let found = search(&*method_i, order);
        (context.tick)();
        found
    });
    let found: Vec<Found> = found.collect::<Result<_, _>>()?;
    let (dissipative_checks, norms) = dissipative_systems(&*method_i, &*rule)?;
    (context.tick)();
    let example = found.iter().find(|found| found.order == 3).ok_or("the search has a matrix of order 3")?;
    let (figure, runs) = example_runs(&example.matrix)?;
    (context.tick)();
    let mut checks: Vec<Check> = found.iter().map(check_search).collect();
    checks.extend(dissipative_checks);
    checks.push(rivals_damp(&found)?);
    Ok(Evidence {
        checks,
        tables: vec![matrices(&found), norms, runs],
        figures: vec![figure],
        notes: notes(&found),
        ..Evidence::default()
    })
}

fn check_search(found: &Found) -> Check {
    let reason = format!(
        "{ASCENTS} ascents from the best of {RANDOM} random matrices in {CHANGES} changes, seed {SEED}, live steps of h = 1"
    );
    if found.order == 2 {
        return Check::new(
            "search/2",
            "No stable 2 × 2 system is amplified by Method I: largest spectral radius found",
            found.radius,
            Requirement::AtMost(1.0 + ROUNDOFF),
            reason,
        );
    }
    Check::new(
        format!("search/{}", found.order),
        format!("Method I amplifies some stable {0} × {0} system: largest spectral radius found", found.order),
        found.radius,
        Requirement::AtLeast(1.0 + 1e-3),
        reason,
    )
}

/// The same systems stepped by A-stable Runge–Kutta methods.
fn rivals_damp(found: &[Found]) -> Result<Check, StudyError> {
    let mut largest = 0.0_f64;
    for name in ["trapezoidal", "implicit-midpoint", "implicit-euler", "sdirk2"] {
        let method = method::parse(name)?;
        for found in found {
            largest = larger(largest, spectral_radius(&propagator(&*method, &found.matrix)?));
        }
    }
    Ok(Check::new(
        "rivals",
        "A-stable Runge–Kutta methods damp all of these systems: largest spectral radius",
        largest,
        Requirement::AtMost(1.0),
        "the eigenvalues of R(hA) are R(hλ); trapezoidal rule, implicit midpoint, implicit Euler and SDIRK2",
    ))
}

/// Systems whose symmetric part is negative semidefinite: |v| never grows.
fn dissipative_systems(method_i: &dyn Method, rule: &dyn Method) -> Result<(Vec<Check>, Table), StudyError> {
    const TRIED: usize = 300;
    let (mut radius, mut norm, mut rule_norm) = (0.0_f64, 0.0_f64, 0.0_f64);
    let mut rows = Vec::new();
    for order in [2, 3, 4] {
        let mut worst: Option<(f64, DMatrix<f64>)> = None;
        for a in dissipative(order, TRIED) {
            let step = propagator(method_i, &a)?;
            let stretch = spectral_norm(&step);
            radius = larger(radius, spectral_radius(&step));
            rule_norm = larger(rule_norm, spectral_norm(&propagator(rule, &a)?));
            if worst.as_ref().is_none_or(|(most, _)| stretch > *most) {
                worst = Some((stretch, a));
            }
        }
        let Some((most, a)) = worst else { continue };
        norm = larger(norm, most);
        rows.push(vec![
            Cell::Integer(order as i64),
            Cell::Number(numerical_abscissa(&a)),
            Cell::Number(spectral_radius(&propagator(method_i, &a)?)),
            Cell::Number(most),
            Cell::Number(spectral_norm(&propagator(rule, &a)?)),
        ]);
    }
    let reason = format!("{TRIED} random matrices −BᵀB + K, K skew, of each of the orders 2, 3 and 4, seed {SEED}");
    let checks = vec![
        Check::new(
            "dissipative/radius",
            "Where the symmetric part of A is negative semidefinite Method I is stable: largest spectral radius",
            radius,
            Requirement::AtMost(1.0 + ROUNDOFF),
            reason.clone(),
        ),
        Check::new(
            "dissipative/norm",
            "Even there one step of Method I may lengthen v, which the solution never does: largest norm of a step",
            norm,
            Requirement::AtLeast(1.0 + 1e-3),
            reason.clone(),
        ),
        Check::new(
            "dissipative/rule",
            "The trapezoidal rule lengthens no v on these systems: largest norm of a step",
            rule_norm,
            Requirement::AtMost(1.0 + ROUNDOFF),
            reason,
        ),
    ];
    let table = Table::new(
        "non-normal-norms",
        "Among random systems with a negative semidefinite symmetric part, those that one step of Method I lengthens most: \
         largest eigenvalue of the symmetric part, spectral radius and norm of the step, and the trapezoidal rule's norm.",
        &["order", "largest_symmetric", "spectral_radius", "norm", "trapezoidal_norm"],
        rows,
    );
    Ok((checks, table))
}

/// A matrix in one line, rows separated by semicolons.
fn text(a: &DMatrix<f64>) -> String {
    let rows =
        a.row_iter().map(|row| row.iter().map(|x| format!("{x}").replace('-', "−")).collect::<Vec<_>>().join(", "));
    rows.collect::<Vec<_>>().join("; ")
}

fn matrices(found: &[Found]) -> Table {
    let row = |found: &Found| {
        vec![
            Cell::Integer(found.order as i64),
            Cell::Text(text(&found.matrix)),
            Cell::Number(spectral_abscissa(&found.matrix)),
            Cell::Number(numerical_abscissa(&found.matrix)),
            Cell::Number(found.radius),
        ]
    };
    Table::new(
        "non-normal-matrices",
        "The matrices hA, rows separated by semicolons, that Method I amplifies most in the search: largest real part of an \
         eigenvalue, largest eigenvalue of the symmetric part, and spectral radius of a live step.",
        &["order", "matrix", "abscissa", "largest_symmetric", "spectral_radius"],
        found.iter().map(row).collect(),
    )
}

/// |v_n| from the vector that grows fastest, and the spectral radius over the step size.
fn example_runs(a: &DMatrix<f64>) -> Result<(Figure, Table), StudyError> {
    const SHOWN: [&str; 4] = ["method-i", "trapezoidal", "implicit-euler", "sdirk2"];
    const STEPS: usize = 60;
    let (mut rows, mut runs, mut radii) = (Vec::new(), Vec::new(), Vec::new());
    let exact = a.exp();
    let steps = SHOWN.iter().map(|name| Ok((*name, propagator(&*method::parse(name)?, a)?)));
    let steps = steps.chain([Ok(("exact", exact))]).collect::<Result<Vec<_>, StudyError>>()?;
    for (name, step) in steps {
        let mut v = DMatrix::from_element(a.nrows(), 1, 1.0);
        let mut curve = Vec::new();
        for n in 0..=STEPS {
            curve.push((n as f64, v.norm()));
            rows.push(vec![
                Cell::Text("run".into()),
                Cell::Text(name.into()),
                Cell::found(n as f64),
                Cell::found(v.norm()),
            ]);
            v = &step * v;
        }
        let mark = if name == "exact" { Mark::Guide } else { Mark::Line };
        // What has decayed beyond ten digits says no more.
        runs.push(Series::new(name, curve.into_iter().filter(|(_, size)| *size > 1e-10).collect(), mark));
    }
    for name in SHOWN {
        let method = method::parse(name)?;
        let mut curve = Vec::new();
        for k in -30..=30 {
            let scale = 10_f64.powf(f64::from(k) / 15.0);
            let radius = spectral_radius(&propagator(&*method, &(scale * a))?);
            curve.push((scale, radius));
            rows.push(vec![
                Cell::Text("step".into()),
                Cell::Text(name.into()),
                Cell::found(scale),
                Cell::found(radius),
            ]);
        }
        radii.push(Series::new(name, curve, Mark::Line));
    }
    radii.push(Series::new("1", vec![(0.01, 1.0), (100.0, 1.0)], Mark::Guide));
    let panel = |title: &str, x, y, series| Panel { title: title.into(), x, y, series, field: None };
    let figure = Figure {
        id: "non-normal-example".into(),
        caption: "The stable 3 × 3 system of the table. Left: |v| over steps of h = 1 from v = (1, 1, 1). Right: spectral radius \
                  of a step over the step size; Method I is unstable where its curve is above 1."
            .into(),
        data: "non-normal-example".into(),
        panels: vec![
            panel("a run", Axis::linear("number of steps").between(0.0, STEPS as f64), Axis::log("|v|"), runs),
            panel("over the step size", Axis::log("h"), Axis::linear("spectral radius").between(0.0, 1.5), radii),
        ],
        columns: 2,
    };
    let caption =
        "Length |v| by number of steps, and spectral radius of a step by step size, of the stable 3 × 3 system.";
    Ok((figure, Table::data("non-normal-example", caption, &["part", "method", "steps_or_h", "value"], rows)))
}

fn notes(found: &[Found]) -> Vec<String> {
    let worst = |order: usize| found.iter().find(|f| f.order == order).map_or(f64::NAN, |f| f.radius);
    vec![
        format!(
            "No: stability for every step size is a theorem for a scalar, for a system with a normal matrix, and for a \
             dissipative one, whose symmetric part is negative semidefinite. A stable system with three or more unknowns \
             need not be any of these, and the search finds such systems that Method I amplifies, by factors up to {:.3}, {:.3} \
             and {:.3} in each step for 3, 4 and 5 unknowns, although all their eigenvalues lie left of −{MARGIN}. With two \
             unknowns it finds none.",
            worst(3),
            worst(4),
            worst(5)
        ),
        "The reason is the step itself: [I − hS + ½h²AᵀA] v₁ = [I + hK] v₀ with the symmetric and skew parts S and K of A. \
         Eigenvalues of A do not appear in it; a shear makes AᵀA small in one direction while K turns v into another. An \
         A-stable Runge–Kutta method has a function of A as its step, whose eigenvalues are those of A transformed, and \
         damps all of these systems."
            .into(),
        "On dissipative systems Method I is stable, but its step may lengthen v, which neither the solution nor the \
         trapezoidal rule ever does there: energy estimates do not carry over."
            .into(),
    ]
}
