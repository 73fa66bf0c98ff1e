//! The defect of symplecticity of one step.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::mechanics::{held_map, integrators, map, problem, tangent, tangent_projector, text};
use super::parts::order_check;
use super::{Context, Study, StudyError};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Series, Table};
use crate::golden::{self, Tolerance, Truth};
use crate::measure::norm::{Extremes, larger};
use crate::measure::order::{Expectation, OrderFit, Sample, fit};
use crate::method::{self, Method};
use crate::problem::Problem;
use crate::run::run as integrate;
use crate::theory::is_symplectic;

pub(super) const STUDY: Study = Study {
    id: "symplecticity",
    title: "Symplecticity",
    question: "Which integrators are symplectic, on which systems, and by how much do the others fail to be?",
    source: "[KY21] Section 1; [MW01]",
    run,
};

/// A problem, and the states on whose motion it is measured at.
struct Setting {
    name: &'static str,
    set: &'static [(&'static str, &'static str)],
    /// The coarsest step.
    coarsest: f64,
}

const SETTINGS: [Setting; 7] = [
    Setting { name: "asymmetric-pendulum", set: &[], coarsest: 0.2 },
    Setting { name: "henon-heiles", set: &[("y0", "-0.2"), ("px0", "0.3")], coarsest: 0.8 },
    Setting { name: "kepler", set: &[], coarsest: 0.2 },
    Setting { name: "charged-particle", set: &[("y0", "-0.3"), ("vx0", "0.2")], coarsest: 0.4 },
    Setting { name: "double-pendulum", set: &[("p10", "0.3"), ("p20", "-0.2")], coarsest: 0.4 },
    Setting { name: "circle", set: &[], coarsest: 0.4 },
    Setting { name: "spherical-pendulum", set: &[("dtheta0", "0.3")], coarsest: 0.4 },
];

/// The methods are symmetric, so that their defects have odd powers of h only and the next orders are two away: a tenth of
/// that distance.
const BAND: f64 = 0.2;

/// Number of step sizes, each 2^{−1/4} of the one before.
const STEPS: i32 = 21;

/// Number of states on the motion, and the time between them. The defect is their root mean square: at a single state a
/// leading coefficient may all but vanish.
const STATES: usize = 8;
const APART: f64 = 0.8;

/// The defects of one method on one problem.
struct Row {
    problem: &'static str,
    method: String,
    /// (h, defect, rounding).
    points: Vec<(f64, f64, f64)>,
    /// The order, where the method is not symplectic.
    fit: Option<OrderFit>,
}

/// Every integrator in every setting.
fn measure_all(context: &Context) -> Result<Vec<Row>, StudyError> {
    let mut pairs = Vec::new();
    for setting in &SETTINGS {
        pairs.extend(integrators()?.into_iter().map(|method| (setting, method)));
    }
    context.announce(pairs.len());
    pairs
        .into_par_iter()
        .map(|(setting, method)| {
            let row = measure(setting, &*method);
            context.tick();
            row
        })
        .collect()
}

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let rows = measure_all(context)?;
    Ok(Evidence {
        checks: rows.iter().map(check).collect(),
        tables: vec![summary(&rows), points(&rows)],
        figures: vec![figure(&rows)],
        notes: vec![
            "The defect is the Frobenius norm of DΦᵀΩDΦ − Ω in the canonical (q, p), where the derivative DΦ of a live step is \
             exact, by implicit differentiation. It is the root mean square over eight states of a motion. Under a constraint \
             both forms are restricted to the vectors tangent to it, G δq = 0; the part of δp along the reactions enters neither."
                .into(),
            "The Galerkin integrators and the two classical ones come from a discrete Lagrangian, and their defect is rounding \
             on every system. Path fitting has one only by the grace of its nodes: with Gauss nodes, of which the single \
             midpoint of degree 2 is the first, and only where L = ½ vᵀMv − V(q) with constant M. On any other nodes, \
             and on Gauss nodes in a magnetic field or with a mass that depends on the configuration, the defect is of the \
             size of the local error, a power r + 1 of h for a method of order r. The claim that path-fitted integrators are symplectic \
             by construction does not hold."
                .into(),
            "Constraints change nothing of that: on the spherical pendulum the same methods are symplectic and the same are not. \
             Uniform motion round a circle hides the difference, as the oscillator does. Every symmetric method that \
             commutes with rotations and reflections keeps the angular momentum there, and turns each circle of phase space \
             as a whole."
                .into(),
        ],
        ..Evidence::default()
    })
}

fn measure(setting: &Setting, method: &dyn Method) -> Result<Row, StudyError> {
    let problem = problem(setting.name, setting.set)?;
    let states = states(&*problem)?;
    let symplectic = is_symplectic(&*problem, method).ok_or("the problem has no Lagrangian of mechanics")?;
    let mut points = Vec::new();
    for h in (0..STEPS).map(|k| setting.coarsest * (-0.25 * f64::from(k)).exp2()) {
        let (defect, rounding) = defect(&*problem, method, h, &states)?;
        points.push((h, defect, rounding));
    }
    let fit = (!symplectic).then(|| {
        let samples: Vec<Sample> =
            points.iter().map(|(h, defect, rounding)| Sample::new(*h, *defect, *rounding)).collect();
        fit(&samples, &Expectation::new(f64::from(method.order() + 1), BAND))
    });
    Ok(Row { problem: setting.name, method: method.name(), points, fit })
}

/// [`STATES`] states on the motion of `problem`.
fn states(problem: &dyn Problem) -> Result<Vec<Vec<f64>>, StudyError> {
    let method = method::parse("galerkin-gauss(3)")?;
    let mut states = Vec::new();
    integrate(problem, &*method, APART / 8.0, APART * STATES as f64, |state| states.push(state.q.clone()))?;
    Ok(states.into_iter().skip(4).step_by(8).collect())
}

/// ‖DΦᵀΩDΦ − Ω‖ of one step, the root mean square over `states`, and a bound on its rounding.
///
/// Under constraints both forms are restricted to the tangent space of their cotangent bundle.
pub(super) fn defect(
    problem: &dyn Problem,
    method: &dyn Method,
    h: f64,
    states: &[Vec<f64>],
) -> Result<(f64, f64), StudyError> {
    let n = problem.initial().len() / 2;
    let mut omega = DMatrix::zeros(2 * n, 2 * n);
    for i in 0..n {
        omega[(i, n + i)] = 1.0;
        omega[(n + i, i)] = -1.0;
    }
    let (mut defects, mut size) = (0.0, 0.0_f64);
    for state in states {
        let (tangent, projector) = match held_map(method, problem) {
            None => (tangent(&mut map(method, problem)?, h, state)?, DMatrix::identity(2 * n, 2 * n)),
            Some(map) => {
                let (mut q, mut p) = (state[..n].to_vec(), state[n..].to_vec());
                let tangent = map?.step_with_tangent(0.0, h, &mut q, &mut p)?;
                let constraint = problem.mechanics().and_then(|system| system.constraint);
                (tangent, tangent_projector(&*constraint.ok_or("the constraint is gone")?, &state[..n])?)
            }
        };
        let tangent = tangent * &projector;
        let difference = tangent.transpose() * &omega * &tangent - projector.transpose() * &omega * &projector;
        defects += difference.norm_squared() / states.len() as f64;
        size = larger(size, tangent.norm());
    }
    // The derivatives of the path, of order 1 and known to a few ε, enter ∂p₁/∂q₀ with coefficients Λ/h, Λ² the sum of
    // their squares; the product then multiplies by DΦ.
    let slopes = method.momentum_roundoff(1.0);
    let rounding = 4.0 * f64::EPSILON * (1.0 + slopes) / h * size;
    Ok((defects.sqrt(), rounding))
}

impl Row {
    /// The largest defect in units of its rounding.
    fn excess(&self) -> f64 {
        self.points.iter().map(|(_, defect, rounding)| defect / rounding).largest()
    }
}

fn check(row: &Row) -> Check {
    let Row { problem, method, .. } = row;
    let id = format!("{problem}/{method}");
    match &row.fit {
        None => {
            let statement = format!("{method} is symplectic on {problem}");
            Check::at_most(id, statement, row.excess(), 1.0, "largest defect over its rounding, of 21 step sizes")
        }
        Some(fit) => {
            let power = fit.expected.order;
            let statement = format!("{method} is not symplectic on {problem}, with a defect of h to the power {power}");
            order_check(id, statement, fit)
        }
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
    Table::new(
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
    Table::data("symplecticity-points", "Defects at all step sizes.", &columns, rows.collect())
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

/// Rows of the golden `symplecticity`: the power of h of each defect.
pub(crate) fn golden(context: &Context) -> Result<Vec<golden::Row>, StudyError> {
    let rows = measure_all(context)?.into_iter().map(|row| {
        let key = format!("{} {}", row.problem, row.method);
        match row.fit {
            None => {
                let reason = "a defect within its rounding is noise, which any build may change";
                let truth = Truth { value: 0.0, allowance: 1.0, source: "theory: it is symplectic".into() };
                golden::Row::number(key, row.excess(), Tolerance::absolute(1.0, reason)).with_truth(truth)
            }
            Some(OrderFit { line: None, reason, .. }) => golden::Row::text(key, reason),
            Some(OrderFit { line: Some(line), expected, .. }) => {
                let tolerance = Tolerance::absolute(0.01, "roundoff moves the finest defect used by a tenth at most");
                let source = "theory: the order of the method and one more".to_owned();
                let truth = Truth { value: expected.order, allowance: expected.band, source };
                golden::Row::number(key, line.slope, tolerance).with_truth(truth)
            }
        }
    });
    Ok(rows.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;

    #[test]
    fn one_defect_that_is_no_number_fails_the_check() {
        let row = |defect| Row {
            problem: "kepler",
            method: "midpoint-vi".into(),
            points: vec![(0.2, 1e-17, 1e-16), (0.1, defect, 1e-16), (0.05, 1e-17, 1e-16)],
            fit: None,
        };
        assert_eq!(check(&row(1e-17)).outcome, Outcome::Pass);
        assert_eq!(check(&row(f64::NAN)).outcome, Outcome::Fail);
    }
}
