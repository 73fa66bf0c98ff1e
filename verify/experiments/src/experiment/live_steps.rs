//! Live steps of the closures beside their closed forms.

use lsvi::closure::Linear;
use lsvi::discrete::Trapezoidal;
use lsvi::{AutoField, FieldFn, OneStep, Scalar, StepError, least_squares, position_momentum};
use nalgebra::{Complex, Matrix2, Rotation2, Vector2};
use rayon::prelude::*;

use super::maps::Printed;
use super::{Context, Experiment, StudyError};
use crate::measure::amplification::Amplification;
use crate::problem;

/// Eq. (27).
fn family(Amplification { alpha, beta }: Amplification, h: f64) -> f64 {
    (alpha + beta - alpha * h + 0.5 * alpha * h * h) / (alpha + beta + beta * h + 0.5 * beta * h * h)
}

/// Many live steps of one kind.
#[derive(Debug, Clone, Copy)]
pub enum LiveSteps {
    /// On v̇ = −v, of a closure whose factor the paper prints.
    Printed(&'static str),
    /// On v̇ = −v, of closures on a grid of (α, β).
    Grid,
    /// On v̇ = −v, of closures and step sizes at random.
    Random,
    /// On rotations in the plane.
    Rotations,
    /// On symmetric matrices in the plane.
    Symmetric,
}

/// A live step beside its closed form, for |v_n| = 1.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// The closure.
    pub closure: Amplification,
    /// hλ; the larger of the two in the plane.
    pub z: Complex<f64>,
    /// The difference of the two.
    pub error: f64,
    /// A bound on its rounding.
    pub tolerance: f64,
    /// |v_{n+1}|.
    pub size: f64,
}

impl Sample {
    /// The error in units of its bound.
    pub fn ratio(&self) -> f64 {
        let ratio = self.error / self.tolerance;
        if ratio.is_nan() { f64::INFINITY } else { ratio }
    }
}

impl Experiment for LiveSteps {
    const ID: &'static str = "live-steps";
    type Found = Vec<Sample>;

    fn measure(&self, context: &Context) -> Result<Vec<Sample>, StudyError> {
        context.announce(1);
        let one = |sample: Result<Option<Sample>, StudyError>| sample.map(|s| s.into_iter().collect::<Vec<_>>());
        let found = match *self {
            Self::Printed(name) => {
                let Printed { closure, factor, .. } = Printed::of(name).ok_or("its factor is not printed")?;
                collected(step_sizes().into_par_iter().map(|h| on_drag(closure, h, factor(h), 32)))
            }
            Self::Grid => {
                let grid =
                    (0..81).filter(|k| *k != 40).map(|k| (0.5 * f64::from(k % 9) - 2.0, 0.5 * f64::from(k / 9) - 2.0));
                let grid: Vec<_> = grid.map(|(alpha, beta)| Amplification { alpha, beta }).collect();
                collected(
                    grid.into_par_iter()
                        .flat_map_iter(|c| step_sizes().into_iter().map(move |h| on_drag(c, h, family(c, h), 4))),
                )
            }
            Self::Random => collected((0..SCATTERED).into_par_iter().map(|k| {
                let (closure, h) = scaled(scattered(k));
                on_drag(closure, h, family(closure, h), 4)
            })),
            Self::Rotations => collected((0..SCATTERED).into_par_iter().map(|k| one(on_rotation(k)))),
            Self::Symmetric => collected((0..SCATTERED).into_par_iter().map(|k| one(on_symmetric(k)))),
        };
        context.tick();
        found
    }
}

fn collected(
    samples: impl ParallelIterator<Item = Result<Vec<Sample>, StudyError>>,
) -> Result<Vec<Sample>, StudyError> {
    Ok(samples.collect::<Result<Vec<_>, _>>()?.concat())
}

/// The factor by which one live step multiplies 1 on v̇ = −v, and a bound on its rounding.
#[derive(Debug)]
pub struct LiveFactor {
    /// The name of a closure whose factor the paper prints.
    pub closure: &'static str,
    /// The step size.
    pub h: f64,
}

impl Experiment for LiveFactor {
    const ID: &'static str = "live-factor";
    type Found = [f64; 2];

    fn measure(&self, _: &Context) -> Result<[f64; 2], StudyError> {
        let closure = Printed::of(self.closure).ok_or("its factor is not printed")?.closure;
        let live = live_factors(closure, self.h, &[1.0])?[0];
        Ok([live, closure.live_tolerance(&[Complex::new(-self.h, 0.0)])])
    }
}

/// The growth per step of the conventional closure on v̇ = −v, from a run long enough to leave the growing mode alone: it gains
/// a factor of e⁸⁰ on the decaying one.
#[derive(Debug)]
pub struct ConventionalGrowth {
    /// The step size.
    pub h: f64,
}

impl ConventionalGrowth {
    /// The logarithm of the factor by linear theory, 2 asinh(h/2).
    pub fn rate(&self) -> f64 {
        2.0 * (0.5 * self.h).asinh()
    }
}

impl Experiment for ConventionalGrowth {
    const ID: &'static str = "conventional-growth";
    /// v_{n+1}/v_n at the end.
    type Found = f64;

    fn measure(&self, _: &Context) -> Result<f64, StudyError> {
        let drag = problem::build("linear-drag", &[])?;
        let mut method = position_momentum(Trapezoidal::new(drag.lagrangian()?));
        let (mut q, mut p, mut before) = ([1.0], [0.0], 1.0);
        for _ in 0..(40.0 / self.rate()).ceil() as u32 {
            before = q[0];
            method.step(0.0, self.h, &mut q, &mut p)?;
        }
        Ok(q[0] / before)
    }
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
fn live_factors(closure: Amplification, h: f64, starts: &[f64]) -> Result<Vec<f64>, StudyError> {
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

/// The step sizes of [`LiveSteps::Printed`] and [`LiveSteps::Grid`]: 10^{−6} … 10⁶, eight in a decade.
pub fn step_sizes() -> Vec<f64> {
    (-48..=48).map(|k| 10_f64.powf(f64::from(k) / 8.0)).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::norm::larger;

    const CLOSURE: Amplification = Amplification { alpha: 0.0, beta: 1.0 };

    #[test]
    fn a_step_that_is_no_number_is_as_far_off_as_can_be() {
        let sample = |error: f64, tolerance: f64| {
            Sample { closure: CLOSURE, z: Complex::new(-1.0, 0.0), error, tolerance, size: 1.0 }.ratio()
        };
        assert_eq!(
            [(f64::NAN, 1.0), (1.0, f64::NAN), (2.0, 4.0)].map(|(e, t)| sample(e, t)),
            [f64::INFINITY, f64::INFINITY, 0.5]
        );
    }

    /// Of the 23 roundings that [`Amplification::live_tolerance`] counts, ten times as many are an error.
    #[test]
    fn a_step_that_is_off_by_several_times_its_rounding_is_found() {
        for h in [1e-3, 1.0, 1e3] {
            let rounding = CLOSURE.live_tolerance(&[Complex::new(-h, 0.0)]);
            let worst = |off: f64| {
                let samples = on_drag(CLOSURE, h, family(CLOSURE, h) + off * rounding, 4).expect("linear");
                samples.iter().map(Sample::ratio).fold(0.0, larger)
            };
            assert!(worst(0.0) <= 1.0 && worst(10.0) > 1.0, "{h}: {} and {}", worst(0.0), worst(10.0));
        }
    }
}
