//! The three-stage Radau IIA method in the basis that decouples its stages ([HW96] IV.8).

use nalgebra::{Complex, Matrix3};

use crate::error::InputError;
use crate::quadrature::{LagrangeBasis, Quadrature};

/// Nodes, and A⁻¹ = T Λ T⁻¹ with Λ = diag(γ, [[α, β], [−β, α]]).
#[derive(Debug)]
pub(super) struct Coefficients {
    /// 0 and the nodes c₁, c₂, 1: where a collocation polynomial that starts at 0 has values.
    pub(super) points: [f64; 4],
    pub(super) gamma: f64,
    pub(super) alpha: f64,
    pub(super) beta: f64,
    pub(super) t: Matrix3<f64>,
    pub(super) t_inverse: Matrix3<f64>,
    /// The embedded estimate is (γ M/h − J)⁻¹ (f₀ + M Σ eᵢ Zᵢ/h).
    pub(super) estimate: [f64; 3],
}

impl Coefficients {
    pub(super) fn new() -> Result<Self, InputError> {
        let rule = Quadrature::radau(3)?;
        let points = [0.0, rule.nodes()[0], rule.nodes()[1], rule.nodes()[2]];
        let inverse = inverse_of_a(points)?;
        // A⁻¹ has the characteristic polynomial λ³ − 9λ² + 36λ − 60, in λ = 3 + w: w³ + 9w − 6.
        let (p, q) = (9.0_f64.cbrt(), 3.0_f64.cbrt());
        let gamma = 3.0 + p - q;
        let (alpha, beta) = (3.0 - 0.5 * (p - q), 0.5 * 3.0_f64.sqrt() * (p + q));
        let real = eigenvector(&inverse, Complex::new(gamma, 0.0));
        let pair = eigenvector(&inverse, Complex::new(alpha, beta));
        let t = Matrix3::from_fn(|i, j| [real[i].re, pair[i].re, pair[i].im][j]);
        // The eigenvalues are distinct, so that T has an inverse.
        let t_inverse = t.try_inverse().unwrap_or_else(Matrix3::zeros);
        let root = 7.0 * 6.0_f64.sqrt();
        let estimate = [-(13.0 + root) / 3.0, (root - 13.0) / 3.0, -1.0 / 3.0];
        Ok(Self { points, gamma, alpha, beta, t, t_inverse, estimate })
    }

    /// The weights of the values at [`points`](Self::points) in their polynomial at c.
    pub(super) fn weights(&self, c: f64) -> [f64; 4] {
        std::array::from_fn(|j| {
            let others = self.points.iter().enumerate().filter(|(k, _)| *k != j);
            others.map(|(_, x)| (c - x) / (self.points[j] - x)).product()
        })
    }
}

/// A⁻¹ takes the values of a polynomial that starts at 0 to its derivatives at the nodes.
fn inverse_of_a(points: [f64; 4]) -> Result<Matrix3<f64>, InputError> {
    let basis = LagrangeBasis::new(&points)?;
    let derivative = basis.differentiation();
    Ok(Matrix3::from_fn(|i, j| derivative[(i + 1, j + 1)]))
}

/// The eigenvector with last component 1, from the first two rows of (A − λ) x = 0.
fn eigenvector(a: &Matrix3<f64>, eigenvalue: Complex<f64>) -> [Complex<f64>; 3] {
    let (p, q) = (Complex::from(a[(0, 0)]) - eigenvalue, Complex::from(a[(1, 1)]) - eigenvalue);
    let (b, c, u, v) = (a[(0, 1)], a[(1, 0)], a[(0, 2)], a[(1, 2)]);
    let determinant = p * q - b * c;
    [(-q * u + b * v) / determinant, (-p * v + c * u) / determinant, Complex::from(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_basis_decouples_the_stages() {
        let c = Coefficients::new().expect("three nodes");
        let decoupled = c.t_inverse * inverse_of_a(c.points).expect("distinct nodes") * c.t;
        let blocks = Matrix3::new(c.gamma, 0.0, 0.0, 0.0, c.alpha, c.beta, 0.0, -c.beta, c.alpha);
        // Entries of A⁻¹ and of T⁻¹ are below 10, with a dozen roundings each.
        approx::assert_abs_diff_eq!(decoupled, blocks, epsilon = 1e3 * f64::EPSILON);
    }

    /// f₀ + Σ eᵢ Zᵢ/h vanishes for v′ = 1, t, t²: the estimate is of third order.
    #[test]
    fn the_estimate_is_of_third_order() {
        let c = Coefficients::new().expect("three nodes");
        for power in 1..=3 {
            let sum: f64 = c.estimate.iter().zip(&c.points[1..]).map(|(e, x)| e * x.powi(power)).sum();
            let start = if power == 1 { 1.0 } else { 0.0 };
            // Three products with factors up to 11.
            approx::assert_abs_diff_eq!(start + sum, 0.0, epsilon = 64.0 * f64::EPSILON);
        }
        assert!(c.estimate.iter().zip(&c.points[1..]).map(|(e, x)| e * x.powi(4)).sum::<f64>().abs() > 0.01);
    }
}
