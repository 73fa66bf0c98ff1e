//! The closures on systems: Jacobian transposes, metrics and exact second derivatives.

use crate::systems::field_of;
use lsvi::closure::Linear;
use lsvi::discrete::{DiscreteLegendre, Interval, Midpoint, MomentumWeights, Trapezoidal};
use lsvi::{
    AutoField, FieldFn, InputError, Jacobian, LeastSquares, OneStep, Scalar, SystemError, Variational, VectorField,
    least_squares, method_i,
};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use proptest::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// v̇ = A v.
struct LinearSystem(Matrix3<f64>);

impl FieldFn for LinearSystem {
    fn dim(&self) -> usize {
        3
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        for (i, d) in dv.iter_mut().enumerate() {
            *d = v[0] * self.0[(i, 0)] + v[1] * self.0[(i, 1)] + v[2] * self.0[(i, 2)];
        }
    }
}

/// A nonlinear coupled field with every kind of second derivative.
struct Coupled;

impl FieldFn for Coupled {
    fn dim(&self) -> usize {
        3
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[1] * v[2] - v[0].powi(3);
        dv[1] = (v[0] * v[2]).sin() - v[1] * 2.0 + t;
        dv[2] = v[0] * v[0] * v[1] - v[2];
    }
}

fn matrix() -> impl Strategy<Value = Matrix3<f64>> {
    prop::array::uniform9(-2.0..2.0_f64).prop_map(|a| Matrix3::from_row_slice(&a))
}

fn step(method: &mut impl OneStep, h: f64, v: Vector3<f64>) -> Result<Vector3<f64>, TestCaseError> {
    let (mut q, mut p) = ([v[0], v[1], v[2]], [0.0; 3]);
    method.step(0.0, h, &mut q, &mut p).map_err(|error| TestCaseError::fail(error.to_string()))?;
    Ok(Vector3::from_row_slice(&q))
}

proptest! {
    /// [I − hS + ½h²AᵀA] v₁ = [I + hK] v₀ with S and K the symmetric and skew parts of A.
    #[test]
    fn method_i_has_its_propagator(a in matrix(), v in prop::array::uniform3(-1.0..1.0_f64), h in 0.01..2.0_f64) {
        let (s, k) = (0.5 * (a + a.transpose()), 0.5 * (a - a.transpose()));
        let left = Matrix3::identity() - h * s + 0.5 * h * h * a.transpose() * a;
        let v = Vector3::from(v);
        let computed = step(&mut method_i(field_of(LinearSystem(a))).expect("usable"), h, v)?;
        let inverse = left.try_inverse().ok_or_else(|| TestCaseError::reject("singular"))?;
        let exact = inverse * ((Matrix3::identity() + h * k) * v);
        // The residual is made of terms up to (1 + h|A|)²|v|/h, the step equation's matrix is 2/h times `left`.
        let size = (1.0 + h * a.norm()).powi(2) * (v.norm() + exact.norm());
        prop_assert!((computed - exact).norm() <= 32.0 * f64::EPSILON * inverse.norm() * size);
    }

    /// In an orthonormal basis the residual norm is the same: the step is covariant under rotations.
    #[test]
    fn rotations_commute_with_the_step(a in matrix(), v in prop::array::uniform3(-1.0..1.0_f64), angles in prop::array::uniform3(0.0..6.0_f64)) {
        let q = nalgebra::Rotation3::from_euler_angles(angles[0], angles[1], angles[2]).into_inner();
        let v = Vector3::from(v);
        let closure = || Linear::new(0.3, 1.0).expect("coefficients");
        let there = step(&mut least_squares(field_of(LinearSystem(q * a * q.transpose())), closure()).expect("usable"), 0.1, q * v)?;
        let here = step(&mut least_squares(field_of(LinearSystem(a)), closure()).expect("usable"), 0.1, v)?;
        // h|A| < 0.7: the equations are well conditioned, and each side rounds a few dozen times.
        prop_assert!((there - q * here).norm() <= 256.0 * f64::EPSILON);
    }

    /// With metric W the method is that of the transformed system w = Cᵀv, W = CCᵀ.
    #[test]
    fn a_metric_is_a_change_of_variables(a in matrix(), v in prop::array::uniform3(-1.0..1.0_f64), d in prop::array::uniform3(0.5..2.0_f64)) {
        let v = Vector3::from(v);
        let c = Matrix3::from_diagonal(&Vector3::from(d)) + Matrix3::new(0.0, 0.0, 0.0, 0.3, 0.0, 0.0, -0.2, 0.1, 0.0);
        let w = c * c.transpose();
        let metric = DMatrix::from_column_slice(3, 3, w.as_slice());
        let lagrangian = LeastSquares::new(field_of(LinearSystem(a))).expect("usable").with_metric(metric).expect("SPD");
        let weighted = step(&mut Variational::new(Trapezoidal::new(lagrangian), Linear::METHOD_I), 0.1, v)?;
        let back = c.transpose().try_inverse().expect("triangular, diagonal at least 0.5");
        let mut plain = method_i(field_of(LinearSystem(c.transpose() * a * back))).expect("usable");
        let transformed = back * step(&mut plain, 0.1, c.transpose() * v)?;
        // |C|, |C⁻¹| < 5: a hundred well-conditioned roundings.
        prop_assert!((weighted - transformed).norm() <= 2048.0 * f64::EPSILON * (1.0 + weighted.norm()));
    }
}

/// `add_derivative` against central differences of `momentum`, for both discretisations, with and without a metric.
#[test]
fn step_derivatives_are_exact() {
    fn check(mut discrete: impl DiscreteLegendre) {
        let at = Interval { start: 0.2, h: 0.3 };
        let (q0, q1) = ([0.4, -0.3, 0.8], [0.6, -0.1, 0.5]);
        for w in [MomentumWeights::START, MomentumWeights::END, MomentumWeights { alpha: -0.7, beta: 1.3 }] {
            let mut exact = Jacobian::zeros(3);
            discrete.add_derivative(at, &q0, &q1, w, &mut exact);
            for j in 0..3 {
                let e = 1e-5;
                let mut moved = |by: f64| {
                    let (mut x, mut p) = (q1, Vector3::zeros());
                    x[j] += by;
                    discrete.momentum(at, &q0, &x, w, p.as_mut_slice());
                    p
                };
                let difference = (moved(e) - moved(-e)) / (2.0 * e);
                // Truncation e² p‴ and roundoff ε p/e are both below 1e-8 for derivatives of order 10.
                let column = exact.to_dense().fixed_view::<3, 1>(0, j).into_owned();
                approx::assert_abs_diff_eq!(column, difference, epsilon = 1e-8);
            }
        }
    }
    let metric = || DMatrix::from_row_slice(3, 3, &[2.0, 0.5, 0.0, 0.5, 1.0, -0.3, 0.0, -0.3, 3.0]);
    let plain = || LeastSquares::new(field_of(Coupled)).expect("usable");
    check(Trapezoidal::new(plain()));
    check(Midpoint::new(plain()));
    check(Trapezoidal::new(plain().with_metric(metric()).expect("SPD")));
    check(Midpoint::new(plain().with_metric(metric()).expect("SPD")));
}

/// Derivatives by dual numbers against those by hand.
#[test]
fn automatic_derivatives_are_the_ones_by_hand() {
    let field = field_of(Coupled);
    let v = [0.4, -0.3, 0.8];
    let mut jacobian = Jacobian::zeros(3);
    field.add_jacobian(0.5, &v, 2.0, &mut jacobian);
    let c = (v[0] * v[2]).cos();
    let by_hand = DMatrix::from_row_slice(
        3,
        3,
        &[-3.0 * v[0] * v[0], v[2], v[1], v[2] * c, -2.0, v[0] * c, 2.0 * v[0] * v[1], v[0] * v[0], -1.0],
    );
    approx::assert_abs_diff_eq!(&jacobian.to_dense(), &(2.0 * by_hand), epsilon = 8.0 * f64::EPSILON);
    let w = DVector::from_vec(vec![1.0, -2.0, 0.5]);
    let mut curvature = Jacobian::zeros(3);
    field.add_curvature(0.5, &v, w.as_slice(), 1.0, &mut curvature);
    let s = (v[0] * v[2]).sin();
    let (xx, xz, zz) = (-v[2] * v[2] * s, c - v[0] * v[2] * s, -v[0] * v[0] * s);
    let by_hand = DMatrix::from_row_slice(
        3,
        3,
        &[
            -6.0 * v[0] * w[0] + xx * w[1] + 2.0 * v[1] * w[2],
            2.0 * v[0] * w[2],
            xz * w[1],
            2.0 * v[0] * w[2],
            0.0,
            w[0],
            xz * w[1],
            w[0],
            zz * w[1],
        ],
    );
    approx::assert_abs_diff_eq!(&curvature.to_dense(), &by_hand, epsilon = 16.0 * f64::EPSILON);
}

/// A field that is declared linear is not evaluated for them.
#[test]
fn second_derivatives_of_a_linear_field_take_nothing() {
    struct Decay {
        linear: bool,
        evaluations: AtomicUsize,
    }
    impl FieldFn for Decay {
        fn dim(&self) -> usize {
            20
        }
        fn is_linear(&self) -> bool {
            self.linear
        }
        fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
            self.evaluations.fetch_add(1, Relaxed);
            dv.iter_mut().zip(v).for_each(|(dv, v)| *dv = -*v);
        }
    }
    for linear in [true, false] {
        let decay = Decay { linear, evaluations: AtomicUsize::new(0) };
        let (field, mut curvature) = (AutoField::new(&decay), Jacobian::zeros(20));
        field.add_curvature(0.0, &[1.0; 20], &[1.0; 20], 1.0, &mut curvature);
        assert_eq!(decay.evaluations.load(Relaxed) == 0, linear);
        assert!(curvature.to_dense().iter().all(|x| *x == 0.0));
    }
}

#[test]
fn metrics_that_are_none_are_refused() {
    let metric = |entries: &[f64]| {
        LeastSquares::new(field_of(Coupled)).expect("usable").with_metric(DMatrix::from_row_slice(3, 3, entries)).err()
    };
    let refused = |entries: &[f64]| matches!(metric(entries), Some(InputError::System(SystemError::Metric(_))));
    assert!(refused(&[1.0, 0.5, 0.0, 0.4, 1.0, 0.0, 0.0, 0.0, 1.0]), "not symmetric");
    assert!(refused(&[1.0, 2.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 1.0]), "indefinite");
    assert!(refused(&[1.0, 0.0, 0.0, 0.0, f64::NAN, 0.0, 0.0, 0.0, 1.0]), "not finite");
    let small = LeastSquares::new(field_of(Coupled)).expect("usable").with_metric(DMatrix::identity(2, 2));
    assert!(matches!(
        small.err(),
        Some(InputError::System(SystemError::Dimension { what: "metric", expected: 3, found: 2 }))
    ));
}
