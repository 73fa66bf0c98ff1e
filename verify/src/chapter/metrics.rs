//! One problem, two metrics: what the metric of the residual decides.

use lsvi::closure::Linear;
use lsvi::discrete::Trapezoidal;
use lsvi::{Jacobian, LeastSquares, OneStep, Variational, VectorField};
use nalgebra::{DMatrix, DVector, Matrix2, Vector2};

use super::parts::order_check;
use super::{Context, Study, StudyError};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Requirement, Series, Table};
use crate::measure::norm::{Extremes, distance, larger};
use crate::measure::order::{Expectation, Sample, fit};
use crate::problem;

pub(super) const STUDY: Study = Study {
    id: "metrics",
    title: "The metric of the residual",
    question: "What changes in Method I when the residual is measured in another metric, and does a linear invariant survive?",
    source: "[S24] Eq. (15); Section 2, the norm of the residual",
    run: study,
};

fn study(context: &Context) -> Result<Evidence, StudyError> {
    context.announce(3);
    let mut evidence = Evidence { notes: notes(), ..Evidence::default() };
    invariant(&mut evidence)?;
    context.tick();
    covariance(&mut evidence)?;
    context.tick();
    nonlinear(&mut evidence)?;
    context.tick();
    Ok(evidence)
}

/// v̇ = A v.
struct LinearField(Matrix2<f64>);

impl VectorField for LinearField {
    fn dim(&self) -> usize {
        2
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv.copy_from_slice((self.0 * Vector2::new(v[0], v[1])).as_slice());
    }
    fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            out.add(i, j, scale * self.0[(i, j)]);
        }
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
}

/// `steps` steps of Method I in the metric `w`.
fn solve<F: VectorField>(
    field: F,
    w: &Matrix2<f64>,
    start: [f64; 2],
    h: f64,
    steps: usize,
) -> Result<Vec<f64>, StudyError> {
    let metric = DMatrix::from_fn(2, 2, |i, j| w[(i, j)]);
    let lagrangian = LeastSquares::new(field)?.with_metric(metric)?;
    let mut method = Variational::new(Trapezoidal::new(lagrangian), Linear::METHOD_I);
    let (mut q, mut p) = (start.to_vec(), vec![0.0; 2]);
    for n in 0..steps {
        method.step(n as f64 * h, h, &mut q, &mut p)?;
    }
    Ok(q)
}

/// A decays into B at the rate λ = 1.
fn decay() -> Matrix2<f64> {
    Matrix2::new(-1.0, 0.0, 1.0, 0.0)
}

/// (A, B) ↦ (A, A + B).
fn balance() -> Matrix2<f64> {
    Matrix2::new(1.0, 0.0, 1.0, 1.0)
}

const EUCLIDEAN: &str = "euclidean";
const BALANCED: &str = "balanced";

/// The residual as it stands, and that of A and A + B: W = TᵀT.
fn metrics() -> [(&'static str, Matrix2<f64>); 2] {
    [(EUCLIDEAN, Matrix2::identity()), (BALANCED, balance().transpose() * balance())]
}

/// What a step of Method I in the metric W multiplies the state of v̇ = Av by: with the adjoint Â = W⁻¹AᵀW the stationarity
/// condition W r₀ + (I − hAᵀ) W r₁ = 0 is [I + (I − hÂ)(I − hA)] v₁ = [I + hA + I − hÂ] v₀.
fn propagator(a: &Matrix2<f64>, w: &Matrix2<f64>, h: f64) -> Option<Matrix2<f64>> {
    let (one, adjoint) = (Matrix2::identity(), w.try_inverse()? * a.transpose() * w);
    let forward = one - adjoint * h;
    let left = one + forward * (one - a * h);
    Some(left.try_inverse()? * (one + a * h + forward))
}

/// A + B is conserved, by the equation and in the right metric.
fn invariant(evidence: &mut Evidence) -> Result<(), StudyError> {
    const STEPS: usize = 10;
    let start = [1.0, 0.0];
    let (mut rows, mut curves) = (Vec::new(), Vec::new());
    for (name, w) in metrics() {
        let mut drifts = Vec::new();
        let mut departure = 0.0_f64;
        for k in -4..=8 {
            let h = 10_f64.powf(0.5 * f64::from(k));
            let end = solve(LinearField(decay()), &w, start, h, STEPS)?;
            let drift = (end[0] + end[1] - 1.0).abs();
            let step = propagator(&decay(), &w, h).ok_or("the metric is regular")?;
            let predicted = step.pow(STEPS as u32) * Vector2::from(start);
            departure = larger(departure, distance(&end, predicted.as_slice()) / predicted.amax().max(1.0));
            rows.push(vec![Cell::Text(name.into()), Cell::Number(h), Cell::Number(end[0]), Cell::Number(drift)]);
            drifts.push((h, drift));
        }
        evidence.checks.push(Check::new(
            format!("propagator/{name}"),
            format!("Ten steps in the {name} metric are those of the closed propagator, hλ from 0.01 to 1e4"),
            departure,
            Requirement::AtMost(2e-7),
            "[I + (I − hÂ)(I − hA)]⁻¹ [I + hA + I − hÂ] with the adjoint Â = W⁻¹AᵀW; its condition grows like (hλ)² = 1e8: ten roundings of that size",
        ));
        let largest = drifts.iter().map(|(_, drift)| *drift).largest();
        evidence.checks.push(if name == BALANCED {
            Check::new(
                "invariant/balanced",
                "In the metric of A and A + B the sum is conserved: largest drift in ten steps, hλ from 0.01 to 1e4",
                largest,
                Requirement::AtMost(2e-11),
                "cᵀv is conserved where A W⁻¹c = 0; ten roundings times hλ = 1e4",
            )
        } else {
            Check::new(
                "invariant/euclidean",
                "In the Euclidean metric A + B drifts: largest drift in ten steps",
                largest,
                Requirement::AtLeast(0.1),
                "A W⁻¹c ≠ 0 for c = (1, 1)",
            )
        });
        curves.push(Series::new(name, drifts, Mark::LineMarkers));
    }
    let caption = "A decays into B at rate λ = 1: A after ten steps of Method I from (1, 0), and the drift of A + B.";
    evidence.tables.push(Table::new("metric-drift", caption, &["metric", "h", "a", "drift"], rows));
    let (x, y) = (Axis::log("hλ"), Axis::log("|A + B − 1|"));
    evidence.figures.push(Figure {
        id: "metric-drift".into(),
        caption: "Drift of the conserved sum A + B after ten steps of Method I, in two metrics of the residual.".into(),
        data: "metric-drift".into(),
        panels: vec![Panel { x, y, series: curves, ..Panel::default() }],
        columns: 1,
    });
    Ok(())
}

/// Method I in the metric TᵀT is Method I in the Euclidean metric of the unknowns T v.
fn covariance(evidence: &mut Evidence) -> Result<(), StudyError> {
    let (start, steps) = ([0.7, -0.2], 5);
    let a = Matrix2::new(-2.0, 3.0, -0.5, -4.0);
    let turn = Matrix2::new(0.8, -0.6, 0.6, 0.8);
    let plain = Vector2::from_vec(solve(LinearField(a), &Matrix2::identity(), start, 0.5, steps)?);
    // A dozen roundings a step of numbers of order ten, the matrix of the step included.
    let roundoff = 1e3 * f64::EPSILON;
    for (name, t) in [("rotation", turn), ("balance", balance()), ("scaling", Matrix2::new(1.0, 0.0, 0.0, 10.0))] {
        let inverse = t.try_inverse().ok_or("the change of unknowns is regular")?;
        let moved: [f64; 2] = (t * Vector2::from(start)).into();
        let elsewhere = solve(LinearField(t * a * inverse), &Matrix2::identity(), moved, 0.5, steps)?;
        let back = inverse * Vector2::from_vec(elsewhere);
        let in_metric = solve(LinearField(a), &(t.transpose() * t), start, 0.5, steps)?;
        evidence.checks.push(Check::new(
            format!("covariance/{name}"),
            format!("Changing unknowns by a {name} T is the same as measuring in TᵀT: difference of the solutions"),
            distance(back.as_slice(), &in_metric),
            Requirement::AtMost(roundoff),
            "|T r|² = rᵀ TᵀT r",
        ));
        let change = distance(back.as_slice(), plain.as_slice());
        let statement = format!("By a {name} of the unknowns the solution of Method I changes");
        evidence.checks.push(if name == "rotation" {
            let statement = format!("{statement} not at all");
            Check::new("metric/rotation", statement, change, Requirement::AtMost(roundoff), "TᵀT = I")
        } else {
            Check::new(
                format!("metric/{name}"),
                statement,
                change,
                Requirement::AtLeast(1e-3),
                "another metric, another method",
            )
        });
    }
    Ok(())
}

/// On a nonlinear problem the order is 2 in every metric, and the error is not the same.
fn nonlinear(evidence: &mut Evidence) -> Result<(), StudyError> {
    let problem = problem::build("van-der-pol", &[])?;
    let truth = problem.tabulated(2.0).ok_or("tabulated")?;
    let start: [f64; 2] = problem.initial().try_into().map_err(|_| "two unknowns")?;
    let mut rows = Vec::new();
    let mut finest = Vec::new();
    for (name, w) in metrics() {
        let mut samples = Vec::new();
        for k in 0..9 {
            let steps = (20.0 * 2_f64.powf(0.5 * f64::from(k))).round();
            let h = 2.0 / steps;
            let end = solve(problem.field(), &w, start, h, steps as usize)?;
            let error = distance(&end, &truth);
            // A rounding of the state a step.
            samples.push(Sample::new(h, error, 2.0 * steps * f64::EPSILON));
            rows.push(vec![Cell::Text(name.into()), Cell::Number(h), Cell::Number(error)]);
            if k == 8 {
                finest.push(error);
            }
        }
        let fitted = fit(&samples, &Expectation::new(2.0, 0.1));
        let statement = format!("Method I is of second order on van-der-pol in the {name} metric");
        evidence.checks.push(order_check(format!("order/{name}"), statement, &fitted));
    }
    let ratio = DVector::from_vec(finest).as_slice().windows(2).map(|e| e[1] / e[0]).sum::<f64>();
    evidence.checks.push(Check::new(
        "order/errors-differ",
        "The errors on van-der-pol differ by the metric: |log₁₀| of the ratio at h = 1/160",
        ratio.log10().abs(),
        Requirement::AtLeast(0.05),
        "the leading error is h²(¼ W⁻¹JᵀW v″ − v‴/12)",
    ));
    let caption = "Error of Method I on van-der-pol at t = 2 in two metrics.";
    evidence.tables.push(Table::data("metric-orders", caption, &["metric", "h", "error"], rows));
    Ok(())
}

fn notes() -> Vec<String> {
    vec![
        "Another metric of the residual is another method: Method I solves W r₀ + (I − hJᵀ) W r₁ = 0, and the adjoint of J in W \
         stands in its propagator. Only rotations of the unknowns leave it as it is; a change of units does not."
            .into(),
        "A linear invariant cᵀv of the equation is not an invariant of Method I unless J W⁻¹c = 0. For a substance that decays into \
         another the Euclidean metric loses or creates matter as soon as hλ is of order 1, and the metric of the residuals of A \
         and A + B conserves it to roundoff. The trapezoidal rule and every Runge–Kutta method conserve linear invariants \
         without being asked."
            .into(),
        "The order is 2 in every metric; the error constant is not the same. Choose W so that residuals are commensurable: a mass \
         matrix has its natural metric M⁻¹, which `lsvi` takes unless told otherwise."
            .into(),
    ]
}
