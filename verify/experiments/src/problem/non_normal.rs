//! A decaying linear system, far from normal, that Method I amplifies.

use lsvi::{AutoField, FieldFn, Scalar, VectorField};
use nalgebra::{Matrix3, Vector3};

use super::{Problem, Spec};
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "non-normal",
    summary: "v̇ = A v with eigenvalues −0.57 and −0.22 ± 1.31i: Method I with h = 0.5 grows by 1.066 per step",
    parameters: &[
        Parameter { name: "x0", default: "1", meaning: "initial x" },
        Parameter { name: "y0", default: "0", meaning: "initial y" },
        Parameter { name: "z0", default: "0", meaning: "initial z" },
    ],
    build: |p| Ok(Box::new(NonNormal { start: [p.number("x0")?, p.number("y0")?, p.number("z0")?] })),
};

/// Characteristic polynomial λ³ + λ² + 2λ + 1. Found by search among integer matrices.
const A: [[f64; 3]; 3] = [[-2.0, 2.0, -1.0], [-1.0, 2.0, -2.0], [-6.0, 5.0, -1.0]];

#[derive(Debug)]
struct NonNormal {
    start: [f64; 3],
}

fn matrix() -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| A[i][j])
}

impl FieldFn for NonNormal {
    fn dim(&self) -> usize {
        3
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        for (dv, row) in dv.iter_mut().zip(A) {
            *dv = v[0] * row[0] + v[1] * row[1] + v[2] * row[2];
        }
    }
}

impl Ode for NonNormal {
    fn dim(&self) -> usize {
        3
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = -2.0 * v[0] + 2.0 * v[1] - v[2];
        dv[1] = -v[0] + 2.0 * v[1] - 2.0 * v[2];
        dv[2] = -6.0 * v[0] + 5.0 * v[1] - v[2];
    }
    fn jacobian(&self, _t: f64, _v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        for (i, row) in A.iter().enumerate() {
            row.iter().enumerate().for_each(|(j, a)| add(i, j, *a));
        }
    }
}

impl Problem for NonNormal {
    fn components(&self) -> &'static [&'static str] {
        &["x", "y", "z"]
    }
    fn initial(&self) -> Vec<f64> {
        self.start.to_vec()
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    /// e^{At} v₀.
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        Some(((matrix() * t).exp() * Vector3::from(self.start)).as_slice().to_vec())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    fn radius(m: &Matrix3<f64>) -> f64 {
        let values = DMatrix::from_fn(3, 3, |i, j| m[(i, j)]).complex_eigenvalues();
        values.iter().fold(0.0, |r: f64, z| r.max(z.norm()))
    }

    /// [I − hS + ½h²AᵀA]⁻¹ [I + hK] with the symmetric and skew parts S and K of A.
    fn propagator(h: f64) -> Matrix3<f64> {
        let (a, one) = (matrix(), Matrix3::identity());
        let (s, k) = ((a + a.transpose()) * 0.5, (a - a.transpose()) * 0.5);
        let left = one - s * h + a.transpose() * a * (0.5 * h * h);
        left.try_inverse().expect("positive definite") * (one + k * h)
    }

    /// Every solution decays, but Method I's does not; the trapezoidal rule's does.
    #[test]
    fn method_i_amplifies_a_system_that_decays() {
        let a = matrix();
        let eigenvalues = DMatrix::from_fn(3, 3, |i, j| A[i][j]).complex_eigenvalues();
        assert!(eigenvalues.iter().all(|z| z.re < -0.2));
        assert!((radius(&propagator(0.5)) - 1.0658).abs() < 1e-4);
        assert!(radius(&propagator(0.1)) < 1.0 && radius(&propagator(1.0)) < 1.0);
        let one = Matrix3::identity();
        for h in [0.1, 0.5, 1.0, 10.0] {
            let rule = (one - a * (0.5 * h)).try_inverse().expect("regular") * (one + a * (0.5 * h));
            assert!(radius(&rule) < 1.0, "{h}");
        }
    }

    /// The method itself is that propagator: a hundred steps amplify by more than 1.06^100 = 339.
    #[test]
    fn the_method_steps_by_its_propagator() {
        let problem = NonNormal { start: [1.0, 0.0, 0.0] };
        let method = crate::method::parse("method-i").expect("registered");
        let run = crate::run::run(&problem, &*method, 0.5, 50.0, |_| {}).expect("linear");
        let predicted = propagator(0.5).pow(100) * Vector3::from(problem.start);
        assert!(predicted.amax() > 100.0, "{predicted}");
        // A hundred steps, a dozen roundings each, in a basis of eigenvectors that is far from orthogonal.
        assert!(
            crate::measure::norm::distance(&run.end.q, predicted.as_slice()) < 1e4 * f64::EPSILON * predicted.amax()
        );
    }
}
