//! The defect of symplecticity of one step.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::mechanics::{integrators, map, problem, tangent, text};
use super::parts::{data, table};
use super::{Context, Study, StudyError};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Series};
use crate::measure::order::{Expectation, OrderFit, Sample, fit};
use crate::methods::Method;
use crate::problems::Problem;

pub(super) const STUDY: Study = Study {
    id: "symplecticity",
    title: "Symplecticity",
    question: "Which integrators are symplectic, on which systems, and by how much do the others fail to be?",
    source: "[KY21] Section 1; [MW01]",
    run,
};

/// A problem at a state without symmetry, on which no defect vanishes by chance, and whether it is L = ½ |v|² − V(q).
struct Setting {
    name: &'static str,
    set: &'static [(&'static str, &'static str)],
    separable: bool,
    /// The coarsest step.
    coarsest: f64,
}

const SETTINGS: [Setting; 5] = [
    Setting { name: "asymmetric-pendulum", set: &[], separable: true, coarsest: 0.2 },
    Setting {
        name: "henon-heiles",
        set: &[("x0", "0.1"), ("y0", "-0.2"), ("px0", "0.4"), ("py0", "0.3")],
        separable: true,
        coarsest: 0.8,
    },
    Setting { name: "kepler", set: &[], separable: true, coarsest: 0.2 },
    Setting { name: "charged-particle", set: &[("y0", "-0.3"), ("vx0", "0.2")], separable: false, coarsest: 0.4 },
    Setting { name: "double-pendulum", set: &[("p10", "0.3"), ("p20", "-0.2")], separable: false, coarsest: 0.4 },
];

/// The defects of symmetric methods are of odd order: two apart, so that this band tells them apart by far.
const BAND: f64 = 0.4;

/// Number of step sizes, each 2^{−1/4} of the one before.
const STEPS: i32 = 21;

/// The defects of one method on one problem.
struct Row {
    problem: &'static str,
    method: String,
    /// (h, defect, rounding).
    points: Vec<(f64, f64, f64)>,
    /// The order, where the method is not symplectic.
    fit: Option<OrderFit>,
}

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let mut pairs = Vec::new();
    for setting in &SETTINGS {
        pairs.extend(integrators()?.into_iter().map(|method| (setting, method)));
    }
    (context.announce)(pairs.len() as u64);
    let rows: Vec<Row> = pairs
        .into_par_iter()
        .map(|(setting, method)| {
            let row = measure(setting, &*method);
            (context.tick)();
            row
        })
        .collect::<Result<_, StudyError>>()?;
    Ok(Evidence {
        checks: rows.iter().map(check).collect(),
        tables: vec![summary(&rows), points(&rows)],
        figures: vec![figure(&rows)],
        notes: vec![
            "The defect is the Frobenius norm of DΦᵀΩDΦ − Ω in the canonical (q, p), where the derivative DΦ of a live step is \
             exact, by implicit differentiation. It is measured at states without symmetry."
                .into(),
            "The Galerkin integrators and the two classical ones come from a discrete Lagrangian, and their defect is rounding \
             on every system. Path fitting has one only by the grace of its nodes: with Gauss nodes, of which the single \
             midpoint of degree 2 is the first, and only where L = ½ vᵀMv − V(q) with constant M. On any other nodes, \
             and on Gauss nodes in a magnetic field or with a mass that depends on the configuration, the defect is of the \
             size of the local error, a power r + 1 of h for a method of order r. The claim that path-fitted integrators are symplectic \
             by construction does not hold."
                .into(),
        ],
        ..Evidence::default()
    })
}

/// Whether theory says that the method is symplectic here.
pub(super) fn is_symplectic(method: &str, separable: bool) -> bool {
    let gauss = method == "path-fitted(2)" || method.ends_with("gauss)");
    !method.starts_with("path-fitted") || (separable && gauss)
}

fn measure(setting: &Setting, method: &dyn Method) -> Result<Row, StudyError> {
    let problem = problem(setting.name, setting.set)?;
    let symplectic = is_symplectic(&method.name(), setting.separable);
    let mut points = Vec::new();
    for h in (0..STEPS).map(|k| setting.coarsest * (-0.25 * f64::from(k)).exp2()) {
        let (defect, rounding) = defect(&*problem, method, h)?;
        points.push((h, defect, rounding));
    }
    let fit = (!symplectic).then(|| {
        let samples: Vec<Sample> =
            points.iter().map(|(h, defect, rounding)| Sample::new(*h, *defect, *rounding)).collect();
        fit(&samples, &Expectation::new(f64::from(method.order() + 1), BAND))
    });
    Ok(Row { problem: setting.name, method: method.name(), points, fit })
}

/// ‖DΦᵀΩDΦ − Ω‖ of one step from the initial state, and a bound on its rounding.
fn defect(problem: &dyn Problem, method: &dyn Method, h: f64) -> Result<(f64, f64), StudyError> {
    let state = problem.initial();
    let n = state.len() / 2;
    let tangent = tangent(&mut map(method, problem)?, h, &state)?;
    let mut omega = DMatrix::zeros(2 * n, 2 * n);
    for i in 0..n {
        omega[(i, n + i)] = 1.0;
        omega[(n + i, i)] = -1.0;
    }
    let defect = (tangent.transpose() * &omega * &tangent - &omega).norm();
    // The derivatives of the path, of order 1 and known to a few ε, enter ∂p₁/∂q₀ with coefficients Λ/h, Λ² the sum of
    // their squares; the product then multiplies by DΦ.
    let slopes = method.momentum_roundoff(1.0);
    let rounding = 4.0 * f64::EPSILON * (1.0 + slopes) / h * tangent.norm();
    Ok((defect, rounding))
}

fn check(row: &Row) -> Check {
    let Row { problem, method, .. } = row;
    let id = format!("{problem}/{method}");
    match &row.fit {
        None => {
            let worst = row.points.iter().map(|(_, defect, rounding)| defect / rounding).fold(0.0, f64::max);
            let statement = format!("{method} is symplectic on {problem}");
            Check::at_most(id, statement, worst, 1.0, "largest defect over its rounding, of 21 step sizes")
        }
        Some(fit) => Check {
            id,
            statement: format!(
                "{method} is not symplectic on {problem}, with a defect of h to the power {}",
                fit.expected.order
            ),
            outcome: fit.verdict.into(),
            measured: fit.line.map(|line| line.slope),
            required: format!("{} ± {}", fit.expected.order, fit.expected.band),
            reason: fit.reason.clone(),
        },
    }
}

fn summary(rows: &[Row]) -> crate::evidence::Table {
    let rows = rows.iter().map(|row| {
        let line = row.fit.as_ref().and_then(|fit| fit.line);
        let (h, defect, rounding) = row.points[8];
        vec![
            text(row.problem),
            text(row.method.as_str()),
            Cell::Number(h),
            Cell::Number(defect),
            Cell::Number(rounding),
            line.map_or(Cell::Empty, |line| Cell::Number(line.slope)),
            text(if row.fit.is_none() { "symplectic" } else { "not symplectic" }),
        ]
    });
    table(
        "symplecticity",
        "Defect of symplecticity of one step of size h, the rounding of its computation, and the power of h with which it falls.",
        &["problem", "method", "h", "defect", "rounding", "power", "kind"],
        rows.collect(),
    )
}

fn points(rows: &[Row]) -> crate::evidence::Table {
    let rows = rows.iter().flat_map(|row| {
        row.points.iter().map(|(h, defect, rounding)| {
            let numbers = [*h, *defect, *rounding].map(Cell::Number);
            [text(row.problem), text(row.method.as_str())].into_iter().chain(numbers).collect()
        })
    });
    let columns = ["problem", "method", "h", "defect", "rounding"];
    data("symplecticity-points", "Defects at all step sizes.", &columns, rows.collect())
}

fn figure(rows: &[Row]) -> Figure {
    let panels = SETTINGS.iter().map(|setting| Panel {
        title: setting.name.into(),
        x: Axis { label: "h".into(), log: true, limits: None },
        y: Axis { label: "defect".into(), log: true, limits: Some((1e-17, 1.0)) },
        series: rows
            .iter()
            .filter(|row| row.problem == setting.name)
            .map(|row| Series {
                label: row.method.clone(),
                points: row.points.iter().map(|(h, defect, _)| (*h, *defect)).collect(),
                mark: Mark::LineMarkers,
            })
            .collect(),
        field: None,
    });
    Figure {
        id: "symplecticity".into(),
        caption: "Defect of symplecticity of one step. What is symplectic lies in the rounding at the bottom; an exact zero is \
                  left out."
            .into(),
        data: "symplecticity-points".into(),
        panels: panels.collect(),
        columns: 2,
    }
}
