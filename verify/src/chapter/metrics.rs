//! One problem, two metrics: what the metric of the residual decides.

use nalgebra::{Matrix2, Vector2};

use super::parts::order_check;
use super::{Context, Study, StudyError, prose};
use crate::evidence::{Axis, Check, Evidence, Figure, Mark, Panel, Requirement, Table};
use crate::experiment::metric::{Field, InMetric};
use crate::measure::norm::{Extremes, distance, larger};
use crate::measure::order::{Expectation, Sample, fit};
use crate::problem;
use crate::row;

pub(super) const STUDY: Study = Study {
    id: "metrics",
    title: "The metric of the residual",
    question: "What changes in Method I when the residual is measured in another metric, and does a linear invariant survive?",
    source: "[S24] Eq. (15); Section 2, the norm of the residual",
    run: study,
};

fn study(context: &Context) -> Result<Evidence, StudyError> {
    let mut evidence = Evidence { notes: prose::fill(include_str!("metrics.md"), &[])?, ..Evidence::default() };
    invariant(&mut evidence, context)?;
    covariance(&mut evidence, context)?;
    nonlinear(&mut evidence, context)?;
    Ok(evidence)
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
fn invariant(evidence: &mut Evidence, context: &Context) -> Result<(), StudyError> {
    const STEPS: usize = 10;
    let start = Vector2::new(1.0, 0.0);
    let mut rows = Vec::new();
    for (name, w) in metrics() {
        let (mut drifts, mut departure) = (Vec::new(), 0.0_f64);
        for k in -4..=8 {
            let h = 10_f64.powf(0.5 * f64::from(k));
            let end = context.get(InMetric { field: Field::Linear(decay()), metric: w, start, h, steps: STEPS })?;
            let drift = (end[0] + end[1] - 1.0).abs();
            let step = propagator(&decay(), &w, h).ok_or("the metric is regular")?;
            let predicted = step.pow(STEPS as u32) * start;
            departure = larger(departure, distance(end.as_slice(), predicted.as_slice()) / predicted.amax().max(1.0));
            rows.push(row![name, h, end[0], drift]);
            drifts.push(drift);
        }
        evidence.checks.push(Check::new(
            format!("propagator/{name}"),
            format!("Ten steps in the {name} metric are those of the closed propagator, hλ from 0.01 to 1e4"),
            departure,
            Requirement::AtMost(2e-7),
            "[I + (I − hÂ)(I − hA)]⁻¹ [I + hA + I − hÂ] with the adjoint Â = W⁻¹AᵀW; its condition grows like (hλ)² = 1e8: ten roundings of that size",
        ));
        let largest = drifts.into_iter().largest();
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
    }
    let caption = "A decays into B at rate λ = 1: A after ten steps of Method I from (1, 0), and the drift of A + B.";
    let table = Table::new("metric-drift", caption, ["metric", "h", "a", "drift"], rows);
    let curves = table.curves("metric", "h", "drift", Mark::LineMarkers);
    let panel = Panel::new(Axis::log("hλ"), Axis::log("|A + B − 1|"), curves);
    let caption = "Drift of the conserved sum A + B after ten steps of Method I, in two metrics of the residual.";
    evidence.figures.push(Figure::new("metric-drift", caption, "metric-drift", [panel]));
    evidence.tables.push(table);
    Ok(())
}

/// Method I in the metric TᵀT is Method I in the Euclidean metric of the unknowns T v.
fn covariance(evidence: &mut Evidence, context: &Context) -> Result<(), StudyError> {
    let start = Vector2::new(0.7, -0.2);
    let solve = |a, metric, start| context.get(InMetric { field: Field::Linear(a), metric, start, h: 0.5, steps: 5 });
    let a = Matrix2::new(-2.0, 3.0, -0.5, -4.0);
    let turn = Matrix2::new(0.8, -0.6, 0.6, 0.8);
    let plain = solve(a, Matrix2::identity(), start)?;
    // A dozen roundings a step of numbers of order ten, the matrix of the step included.
    let roundoff = 1e3 * f64::EPSILON;
    for (name, t) in [("rotation", turn), ("balance", balance()), ("scaling", Matrix2::new(1.0, 0.0, 0.0, 10.0))] {
        let inverse = t.try_inverse().ok_or("the change of unknowns is regular")?;
        let back = inverse * *solve(t * a * inverse, Matrix2::identity(), t * start)?;
        let in_metric = solve(a, t.transpose() * t, start)?;
        evidence.checks.push(Check::new(
            format!("covariance/{name}"),
            format!("Changing unknowns by a {name} T is the same as measuring in TᵀT: difference of the solutions"),
            distance(back.as_slice(), in_metric.as_slice()),
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
fn nonlinear(evidence: &mut Evidence, context: &Context) -> Result<(), StudyError> {
    let problem = problem::build("van-der-pol", &[])?;
    let truth = problem.tabulated(2.0).ok_or("tabulated")?;
    let start = Vector2::from_column_slice(&problem.initial());
    let (mut rows, mut finest) = (Vec::new(), Vec::new());
    for (name, metric) in metrics() {
        let mut samples = Vec::new();
        for k in 0..9 {
            let steps = (20.0 * 2_f64.powf(0.5 * f64::from(k))).round();
            let h = 2.0 / steps;
            let run = InMetric { field: Field::Of("van-der-pol"), metric, start, h, steps: steps as usize };
            let error = distance(context.get(run)?.as_slice(), &truth);
            // A rounding of the state a step.
            samples.push(Sample::new(h, error, 2.0 * steps * f64::EPSILON));
            rows.push(row![name, h, error]);
            if k == 8 {
                finest.push(error);
            }
        }
        let fitted = fit(&samples, &Expectation::new(2.0, 0.1));
        let statement = format!("Method I is of second order on van-der-pol in the {name} metric");
        evidence.checks.push(order_check(format!("order/{name}"), statement, &fitted));
    }
    evidence.checks.push(Check::new(
        "order/errors-differ",
        "The errors on van-der-pol differ by the metric: |log₁₀| of the ratio at h = 1/160",
        (finest[1] / finest[0]).log10().abs(),
        Requirement::AtLeast(0.05),
        "the leading error is h²(¼ W⁻¹JᵀW v″ − v‴/12)",
    ));
    let caption = "Error of Method I on van-der-pol at t = 2 in two metrics.";
    evidence.tables.push(Table::data("metric-orders", caption, ["metric", "h", "error"], rows));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At the shortest and the longest steps, in both metrics.
    #[test]
    fn the_column_of_a_is_what_is_left_of_it() {
        let mut evidence = Evidence::default();
        invariant(&mut evidence, &Context::quick()).expect("it runs");
        let rows = &evidence.tables[0].rows;
        for (name, w) in metrics() {
            let of: Vec<_> = rows.iter().filter(|row| row[0].to_string() == name).collect();
            for row in [of[0], of[of.len() - 1]] {
                let [h, a] = [1, 2].map(|column| row[column].number().expect("a number"));
                let expected = propagator(&decay(), &w, h).expect("regular").pow(10)[(0, 0)];
                assert!((a - expected).abs() < 2e-7, "{name}, h = {h}: {a} against {expected}");
            }
        }
    }

    #[test]
    fn solutions_that_differ_by_more_than_rounding_are_not_the_same() {
        let mut evidence = Evidence::default();
        covariance(&mut evidence, &Context::quick()).expect("it runs");
        let same = |check: &&Check| check.id.starts_with("covariance/") || check.id == "metric/rotation";
        let required: Vec<_> = evidence.checks.iter().filter(same).filter_map(|check| check.required).collect();
        assert_eq!(required.len(), 4);
        assert!(required.iter().all(|required| !required.is_met_by(1e-12)), "{required:?}");
    }
}
