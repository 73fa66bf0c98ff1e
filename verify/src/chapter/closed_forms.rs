//! Live steps of every closure against their closed forms.

use lsvi::closure::Linear;
use lsvi::discrete::Trapezoidal;
use lsvi::{AutoField, FieldFn, OneStep, Scalar, StepError, least_squares, position_momentum};
use nalgebra::{Complex, Matrix2, Rotation2, Vector2};
use rayon::prelude::*;

use super::{Context, Study, StudyError};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Series, Table};
use crate::experiment::maps::{PRINTED, Printed};
use crate::golden::{Row, Tolerance, Truth};
use crate::measure::amplification::Amplification;
use crate::measure::norm::Extremes;
use crate::problem;

pub(super) const STUDY: Study = Study {
    id: "closed-forms",
    title: "One step in closed form",
    question: "Is one step of the library the amplification factor of its closure, for step sizes from 1e-6 to 1e6?",
    source: "[S24] Eqs. (8), (21), (22), (25), (27); linear theory of the closures",
    run,
};

/// Eq. (27).
fn family(Amplification { alpha, beta }: Amplification, h: f64) -> f64 {
    (alpha + beta - alpha * h + 0.5 * alpha * h * h) / (alpha + beta + beta * h + 0.5 * beta * h * h)
}

/// v̇ = A v in the plane.
struct Plane(Matrix2<f64>);

impl FieldFn for Plane {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[0] * self.0[(0, 0)] + v[1] * self.0[(0, 1)];
        dv[1] = v[0] * self.0[(1, 0)] + v[1] * self.0[(1, 1)];
    }
}

/// One live step of a closure on v̇ = A v from `v`.
///
/// # Errors
/// [`StepError`] if the step cannot be taken.
pub fn step_in_plane(
    a: Matrix2<f64>,
    h: f64,
    closure: Amplification,
    v: Vector2<f64>,
) -> Result<Vector2<f64>, StepError> {
    let (mut q, mut p) = ([v.x, v.y], [0.0; 2]);
    least_squares(AutoField::new(Plane(a)), Linear::new(closure.alpha, closure.beta)?)?.step(0.0, h, &mut q, &mut p)?;
    Ok(Vector2::from(q))
}

/// The factors by which live steps of size `h` multiply each of `starts` on v̇ = −v.
pub(crate) fn live_factors(closure: Amplification, h: f64, starts: &[f64]) -> Result<Vec<f64>, StudyError> {
    let drag = problem::build("linear-drag", &[])?;
    let mut method = least_squares(drag.field(), Linear::new(closure.alpha, closure.beta)?)?;
    starts
        .iter()
        .map(|v| {
            let (mut q, mut p) = ([*v], [0.0]);
            method.step(0.0, h, &mut q, &mut p)?;
            Ok(q[0] / v)
        })
        .collect()
}

/// A live step beside its closed form, for |v_n| = 1.
#[derive(Clone, Copy)]
struct Sample {
    closure: Amplification,
    /// hλ; the larger of the two in the plane.
    z: Complex<f64>,
    error: f64,
    tolerance: f64,
    /// |v_{n+1}|.
    size: f64,
}

impl Sample {
    fn ratio(&self) -> f64 {
        let ratio = self.error / self.tolerance;
        if ratio.is_nan() { f64::INFINITY } else { ratio }
    }
}

/// 10^{−6} … 10⁶, eight in a decade.
fn step_sizes() -> impl Iterator<Item = f64> {
    (-48..=48).map(|k| 10_f64.powf(f64::from(k) / 8.0))
}

/// The k-th point of an equidistributed sequence in the unit cube, the same in every run.
fn scattered<const D: usize>(k: u32) -> [f64; D] {
    const PRIMES: [f64; 5] = [2.0, 3.0, 5.0, 7.0, 11.0];
    std::array::from_fn(|i| (f64::from(k) * PRIMES[i].sqrt()).fract())
}

/// Number of scattered samples of each kind.
const SCATTERED: u32 = 4000;

/// Weights in [−2, 2] and a step size in [10⁻⁶, 10⁶] from three numbers in [0, 1].
fn scaled([a, b, h]: [f64; 3]) -> (Amplification, f64) {
    (Amplification { alpha: 4.0 * a - 2.0, beta: 4.0 * b - 2.0 }, 10_f64.powf(12.0 * h - 6.0))
}

/// Live steps on v̇ = −v from several starts, whose roundings differ.
fn on_drag(closure: Amplification, h: f64, exact: f64, starts: u32) -> Result<Vec<Sample>, StudyError> {
    let z = Complex::new(-h, 0.0);
    if closure.is_singular(z) {
        return Ok(Vec::new());
    }
    let starts: Vec<f64> = (0..starts).map(|k| 1.0 + scattered::<1>(k)[0]).collect();
    let factors = live_factors(closure, h, &starts)?;
    // The quotient of a step and its start is rounded once more than the step.
    let tolerance = closure.live_tolerance(&[z]) + f64::EPSILON * exact.abs();
    let sample = |factor: f64| Sample { closure, z, error: (factor - exact).abs(), tolerance, size: exact.abs() };
    Ok(factors.into_iter().map(sample).collect())
}

/// A live step on the rotation and scaling by λ = e^{iφ}: the plane is the complex numbers.
fn on_rotation(k: u32) -> Result<Option<Sample>, StudyError> {
    let [a, b, h, turn] = scattered(k);
    let (closure, h) = scaled([a, b, h]);
    let lambda = Complex::from_polar(1.0, std::f64::consts::TAU * turn);
    let z = h * lambda;
    if closure.is_singular(z) {
        return Ok(None);
    }
    let a = Matrix2::new(lambda.re, -lambda.im, lambda.im, lambda.re);
    let v = step_in_plane(a, h, closure, Vector2::x())?;
    let exact = closure.factor(z);
    let error = (Complex::new(v.x, v.y) - exact).norm();
    Ok(Some(Sample { closure, z, error, tolerance: closure.live_tolerance(&[z]), size: exact.norm() }))
}

/// A live step on a symmetric matrix: a real factor along each of two orthogonal axes.
fn on_symmetric(k: u32) -> Result<Option<Sample>, StudyError> {
    let [a, b, h, other, turn] = scattered(k);
    let (closure, h) = scaled([a, b, h]);
    let spectrum = Vector2::new(2.0 * other - 1.0, -1.0);
    let z = spectrum.map(|l| Complex::new(h * l, 0.0));
    if z.iter().any(|z| closure.is_singular(*z)) {
        return Ok(None);
    }
    let basis = Rotation2::new(std::f64::consts::PI * turn).into_inner();
    let start = Vector2::new(0.6, 0.8);
    let v = step_in_plane(basis * Matrix2::from_diagonal(&spectrum) * basis.transpose(), h, closure, basis * start)?;
    let exact = basis * start.zip_map(&z, |c, z| c * closure.factor(z).re);
    let tolerance = closure.live_tolerance(z.as_slice());
    Ok(Some(Sample { closure, z: z[1], error: (v - exact).norm(), tolerance, size: exact.norm() }))
}

fn collected(
    samples: impl ParallelIterator<Item = Result<Vec<Sample>, StudyError>>,
) -> Result<Vec<Sample>, StudyError> {
    Ok(samples.collect::<Result<Vec<_>, _>>()?.concat())
}

fn run(context: &Context) -> Result<Evidence, StudyError> {
    context.announce(2);
    let mut checks = Vec::new();
    let mut printed = Vec::new();
    for Printed { name, equation, closure, factor } in PRINTED {
        let samples = step_sizes().map(|h| on_drag(closure, h, factor(h), 32)).collect::<Result<Vec<_>, _>>()?.concat();
        let statement = format!("a step of {name} on v̇ = −v multiplies by the factor {equation}");
        checks.push(check(name, statement, &samples));
        printed.push((name, samples));
    }
    let grid = (0..81).filter(|k| *k != 40).map(|k| (0.5 * f64::from(k % 9) - 2.0, 0.5 * f64::from(k / 9) - 2.0));
    let grid: Vec<_> = grid.map(|(alpha, beta)| Amplification { alpha, beta }).collect();
    let on_grid = grid.into_par_iter().flat_map_iter(|c| step_sizes().map(move |h| on_drag(c, h, family(c, h), 4)));
    checks.push(check(
        "family-grid",
        "a step of αp_n + βp_{n+1} = 0 on v̇ = −v multiplies by the factor (27), α and β from −2 to 2 by ½",
        &collected(on_grid)?,
    ));
    let at_random = (0..SCATTERED).into_par_iter().map(|k| {
        let (closure, h) = scaled(scattered(k));
        on_drag(closure, h, family(closure, h), 4)
    });
    checks.push(check("family-random", "the same at random α, β and h", &collected(at_random)?));
    context.tick();
    let one = |sample: Result<Option<Sample>, StudyError>| sample.map(|s| s.into_iter().collect::<Vec<_>>());
    checks.push(check(
        "plane-rotations",
        "a step on [[x, −y], [y, x]] multiplies by R(h(x + iy)) in the whole complex plane, at random α, β, h and x + iy",
        &collected((0..SCATTERED).into_par_iter().map(|k| one(on_rotation(k))))?,
    ));
    checks.push(check(
        "plane-symmetric",
        "a step on a symmetric matrix multiplies by R(hλ) along each eigenvector, at random α, β, h and spectra in [−1, 1]",
        &collected((0..SCATTERED).into_par_iter().map(|k| one(on_symmetric(k))))?,
    ));
    checks.extend([0.01, 0.1, 0.5, 1.0, 2.5, 10.0, 100.0].map(growth).into_iter().collect::<Result<Vec<_>, _>>()?);
    context.tick();
    let table = table(&printed);
    let figure = figure(&printed);
    Ok(Evidence { checks, tables: vec![table], figures: vec![figure], notes: notes(), ..Evidence::default() })
}

fn check(id: &str, statement: impl Into<String>, samples: &[Sample]) -> Check {
    let worst = samples.iter().max_by(|a, b| a.ratio().total_cmp(&b.ratio()));
    let reason = worst.map_or_else(String::new, |Sample { closure, z, error, tolerance, .. }| {
        format!(
            "In units of its roundoff bound; the largest of {} steps is {error:.1e} of {tolerance:.1e} at (α, β) = \
             ({:.3}, {:.3}), hλ = {z:.3e}.",
            samples.len(),
            closure.alpha,
            closure.beta,
        )
    });
    Check::at_most(id, statement, worst.map_or(f64::NAN, Sample::ratio), 1.0, reason)
}

/// The growth per step of the conventional closure, from a run long enough to leave the growing mode alone: it gains a
/// factor of e⁸⁰ on the decaying one.
fn growth(h: f64) -> Result<Check, StudyError> {
    let drag = problem::build("linear-drag", &[])?;
    let mut method = position_momentum(Trapezoidal::new(drag.lagrangian()?));
    let rate = 2.0 * (0.5 * h).asinh();
    let (mut q, mut p, mut before) = ([1.0], [0.0], 1.0);
    for _ in 0..(40.0 / rate).ceil() as u32 {
        before = q[0];
        method.step(0.0, h, &mut q, &mut p)?;
    }
    // A step rounds v by some ε(1 + h) of itself and so p by ε/h, which takes 1/(1 − e^{−2 rate}) ≈ 1 + 1/h steps to die.
    let tolerance = 24.0 * f64::EPSILON * (1.0 + h + h.recip());
    Ok(Check::at_most(
        format!("conventional-growth-{h}"),
        format!("the conventional closure grows by e^{{2 asinh(h/2)}} = {:.6} a step on v̇ = −v, h = {h}", rate.exp()),
        (q[0] / before / rate.exp() - 1.0).abs(),
        tolerance,
        "Relative difference of v_{n+1}/v_n at the end of a live run; the bound is the roundoff that p/v gathers.",
    ))
}

fn table(printed: &[(&str, Vec<Sample>)]) -> Table {
    let rows = printed.iter().flat_map(|(name, samples)| {
        // All samples of one step size together.
        samples.chunk_by(|a, b| a.z == b.z).map(|same| {
            let largest = |f: fn(&Sample) -> f64| Cell::Number(same.iter().map(f).largest());
            let relative = largest(|s| s.error / s.size);
            vec![
                Cell::Text((*name).into()),
                Cell::Number(-same[0].z.re),
                largest(|s| s.error),
                largest(|s| s.tolerance),
                relative,
            ]
        })
    });
    Table {
        id: "closed-forms".into(),
        caption: "Live steps on v̇ = −v from |v| = 1: largest error of 32 steps, its bound, and the error relative to the result."
            .into(),
        columns: ["method", "h", "error", "bound", "relative_error"].map(Into::into).to_vec(),
        rows: rows.collect(),
        shown: false,
    }
}

fn figure(printed: &[(&str, Vec<Sample>)]) -> Figure {
    let panel = |title: &str, label: &str, value: fn(&Sample) -> f64| Panel {
        title: title.into(),
        x: Axis { label: "h".into(), log: true, limits: None },
        y: Axis { label: label.into(), log: true, limits: None },
        series: printed
            .iter()
            .map(|(name, samples)| Series {
                label: (*name).into(),
                points: samples
                    .chunk_by(|a, b| a.z == b.z)
                    .map(|same| (-same[0].z.re, same.iter().map(value).largest()))
                    .collect(),
                mark: Mark::Line,
            })
            .chain([Series {
                label: "roundoff ε".into(),
                points: step_sizes().map(|h| (h, f64::EPSILON)).collect(),
                mark: Mark::Guide,
            }])
            .collect(),
        ..Panel::default()
    };
    Figure {
        id: "closed-forms".into(),
        caption:
            "Largest error of a live step on v̇ = −v against its closed form, over several starts: relative to the \
                  result v_{n+1}, and to the state v_n before the step."
                .into(),
        data: "closed-forms".into(),
        panels: vec![
            panel("(a) relative to the result", "error / |v_{n+1}|", |s| s.error / s.size),
            panel("(b) relative to the state before", "error / |v_n|", |s| s.error),
        ],
        columns: 2,
    }
}

/// Rows of the golden `closed-forms`: a live factor in every other decade of h.
pub(crate) fn golden(_: &Context) -> Result<Vec<Row>, StudyError> {
    let mut rows = Vec::new();
    for Printed { name, equation, closure, factor } in PRINTED {
        for h in (-3..=3).map(|k| 100_f64.powi(k)) {
            let live = live_factors(closure, h, &[1.0])?[0];
            let roundoff = closure.live_tolerance(&[Complex::new(-h, 0.0)]);
            let tolerance = Tolerance::absolute(roundoff, "roundoff bound of a live step");
            let truth = Truth { value: factor(h), allowance: roundoff, source: format!("Eq. {equation}") };
            rows.push(Row::number(format!("{name} h={h:?}"), live, tolerance).with_truth(truth));
        }
    }
    Ok(rows)
}

fn notes() -> Vec<String> {
    vec![
        "Each live step builds the Lagrangian, its discrete momenta and Newton's iteration; the closed forms know nothing of \
         these. The bound counts the roundings of the step equation, each of the size of the terms that are added and not of \
         what they cancel to, and divides by its derivative; so it follows the conditioning from h = 1e-6 to 1e6 and through \
         the neighbourhood of the poles of R. Within 1e-6 of a pole nothing is asserted."
            .into(),
        "Relative to the state before the step nothing is lost at any h where |R| ≤ 1. Relative to its own size the result \
         of Method I and of p_n = 0 loses digits in proportion to h for h ≫ 1. In Method I half of v_n enters \
         ½(r_n + r_{n+1}) with one sign and ½hJᵀr_{n+1}, through the difference quotient, with the other, while the result \
         is 2v_n/h²; in p_n = 0 half of v_{n+1} does. The two cancel in exact arithmetic only because f is linear, so no \
         order of evaluation of the general step equation avoids it. Method II has no such terms and keeps all digits."
            .into(),
    ]
}
