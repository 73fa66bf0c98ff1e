//! One live step of every closure equals its closed form.

use lsvi::closure::Linear;
use lsvi::{OneStep, least_squares};
use nalgebra::{Complex, Matrix2, Vector2};
use proptest::prelude::*;
use verify::experiment::live_steps::step_in_plane;
use verify::measure::amplification::Amplification;
use verify::problem;

fn live(a: Matrix2<f64>, h: f64, closure: Amplification, v: Vector2<f64>) -> Result<Vector2<f64>, TestCaseError> {
    let fail = |error: String| TestCaseError::fail(format!("{closure:?}, h = {h}: {error}"));
    step_in_plane(a, h, closure, v).map_err(|error| fail(error.to_string()))
}

fn closure() -> impl Strategy<Value = Amplification> {
    let named = prop::sample::select(vec![(1.0, 0.0), (0.0, 1.0), (-1.0, 1.0), (0.5, 0.5), (-0.5, 1.0)]);
    prop_oneof![named, (-2.0..2.0, -2.0..2.0)].prop_map(|(alpha, beta)| Amplification { alpha, beta })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    /// Eq. (27), and (21), (22), (25) among its named members, exactly as printed.
    #[test]
    fn linear_drag(closure in closure(), log_h in -6.0..6.0_f64, v in 1.0..2.0_f64) {
        let (h, Amplification { alpha, beta }) = (10_f64.powf(log_h), closure);
        let z = Complex::new(-h, 0.0);
        prop_assume!(!closure.is_singular(z));
        let factor = match (alpha, beta) {
            (1.0, 0.0) => 1.0 - h + 0.5 * h * h,
            (0.0, 1.0) => 1.0 / (1.0 + h + 0.5 * h * h),
            (-1.0, 1.0) => (1.0 - 0.5 * h) / (1.0 + 0.5 * h),
            _ => (alpha + beta - alpha * h + 0.5 * alpha * h * h) / (alpha + beta + beta * h + 0.5 * beta * h * h),
        };
        let drag = problem::build("linear-drag", &[]).expect("registered");
        let (mut q, mut p) = ([v], [0.0]);
        let mut method = least_squares(drag.field(), Linear::new(alpha, beta).expect("not both zero")).expect("usable");
        method.step(0.0, h, &mut q, &mut p).map_err(|error| TestCaseError::fail(error.to_string()))?;
        let (error, tolerance) = ((q[0] - factor * v).abs(), v * closure.live_tolerance(&[z]));
        prop_assert!(error <= tolerance, "h = {h}: {factor} is missed by {error:e}, more than {tolerance:e}");
    }

    /// Rotation and scaling, λ = x + iy: the plane is the complex numbers.
    #[test]
    fn complex_plane(closure in closure(), log_h in -6.0..6.0_f64, angle in 0.0..std::f64::consts::TAU) {
        let (h, lambda) = (10_f64.powf(log_h), Complex::from_polar(1.0, angle));
        let z = h * lambda;
        prop_assume!(!closure.is_singular(z));
        let a = Matrix2::new(lambda.re, -lambda.im, lambda.im, lambda.re);
        let v = live(a, h, closure, Vector2::new(1.0, 0.0))?;
        let error = (Complex::new(v[0], v[1]) - closure.factor(z)).norm();
        let tolerance = closure.live_tolerance(&[z]);
        prop_assert!(error <= tolerance, "R({z}) is missed by {error:e}, more than {tolerance:e}");
    }

    /// Symmetric matrices: an orthonormal basis of real factors.
    #[test]
    fn symmetric_systems(closure in closure(), log_h in -6.0..6.0_f64, angle in 0.0..3.0_f64, l in -1.0..1.0_f64) {
        let h = 10_f64.powf(log_h);
        let basis = nalgebra::Rotation2::new(angle).into_inner();
        let spectrum = Vector2::new(l, -1.0);
        let factors = spectrum.map(|l| Complex::new(h * l, 0.0));
        prop_assume!(factors.iter().all(|z| !closure.is_singular(*z)));
        let a = basis * Matrix2::from_diagonal(&spectrum) * basis.transpose();
        let v = live(a, h, closure, basis * Vector2::new(0.6, 0.8))?;
        let exact = basis * Vector2::new(0.6, 0.8).zip_map(&factors, |c, z| c * closure.factor(z).re);
        let tolerance = closure.live_tolerance(factors.as_slice());
        prop_assert!((v - exact).norm() <= tolerance, "{} more than {tolerance:e}", (v - exact).norm());
    }
}
