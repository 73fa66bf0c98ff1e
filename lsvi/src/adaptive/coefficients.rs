//! Radau IIA methods in the basis that decouples their stages ([HW96] IV.8).

use std::sync::OnceLock;

use nalgebra::{Complex, DMatrix, DVector};

use crate::error::InputError;
use crate::quadrature::{LagrangeBasis, Quadrature};

/// The method with S nodes, S odd: A⁻¹ = T Λ T⁻¹ with one real eigenvalue and (S − 1)/2 pairs,
/// Λ = diag(γ, [[α, β], [−β, α]], …).
#[derive(Debug)]
pub(super) struct Coefficients<const S: usize> {
    pub(super) nodes: [f64; S],
    /// A⁻¹: from the values of a polynomial that starts at 0 to its derivatives at the nodes.
    pub(super) inverse: [[f64; S]; S],
    pub(super) gamma: f64,
    /// α − iβ of each pair.
    pub(super) pairs: Vec<Complex<f64>>,
    pub(super) t: [[f64; S]; S],
    pub(super) t_inverse: [[f64; S]; S],
    /// The embedded estimate is (γ M/h − J)⁻¹ (f₀ + M Σ eᵢ Zᵢ/h), where h f₀ + Σ eᵢ Zᵢ is h f₀ less the slope of the
    /// collocation polynomial at the start: it is of order S.
    pub(super) estimate: [f64; S],
    /// 1/Πₖ (cⱼ − cₖ) over 0 and the other nodes.
    barycentric: [f64; S],
}

/// Three, five and seven nodes.
pub(super) fn three() -> Result<&'static Coefficients<3>, InputError> {
    static CELL: OnceLock<Result<Coefficients<3>, InputError>> = OnceLock::new();
    CELL.get_or_init(Coefficients::new).as_ref().map_err(Clone::clone)
}

/// See [`three`].
pub(super) fn five() -> Result<&'static Coefficients<5>, InputError> {
    static CELL: OnceLock<Result<Coefficients<5>, InputError>> = OnceLock::new();
    CELL.get_or_init(Coefficients::new).as_ref().map_err(Clone::clone)
}

/// See [`three`].
pub(super) fn seven() -> Result<&'static Coefficients<7>, InputError> {
    static CELL: OnceLock<Result<Coefficients<7>, InputError>> = OnceLock::new();
    CELL.get_or_init(Coefficients::new).as_ref().map_err(Clone::clone)
}

impl<const S: usize> Coefficients<S> {
    fn new() -> Result<Self, InputError> {
        let rule = Quadrature::radau(S)?;
        let points: Vec<f64> = std::iter::once(0.0).chain(rule.nodes().iter().copied()).collect();
        let derivative = LagrangeBasis::new(&points)?.differentiation().clone();
        let inverse = derivative.view((1, 1), (S, S)).clone_owned();
        let mut spectrum: Vec<Complex<f64>> = inverse.complex_eigenvalues().iter().copied().collect();
        // Of each pair the eigenvalue above the axis; the real one first.
        spectrum.sort_by(|a, b| a.im.abs().total_cmp(&b.im.abs()));
        let upper: Vec<Complex<f64>> = spectrum.iter().skip(1).filter(|x| x.im > 0.0).copied().collect();
        let gamma = spectrum.first().map_or(f64::NAN, |x| x.re);
        let mut t = DMatrix::zeros(S, S);
        t.set_column(0, &eigenvector(&inverse, gamma.into()).map(|x| x.re));
        for (k, eigenvalue) in upper.iter().enumerate() {
            let vector = eigenvector(&inverse, *eigenvalue);
            t.set_column(2 * k + 1, &vector.map(|x| x.re));
            t.set_column(2 * k + 2, &vector.map(|x| x.im));
        }
        // The eigenvalues are distinct, so that T has an inverse.
        let t_inverse = t.clone().try_inverse().unwrap_or_else(|| DMatrix::from_element(S, S, f64::NAN));
        let array = |a: &DMatrix<f64>| std::array::from_fn(|i| std::array::from_fn(|j| a[(i, j)]));
        Ok(Self {
            nodes: std::array::from_fn(|i| points[i + 1]),
            inverse: array(&inverse),
            gamma,
            pairs: upper.iter().map(Complex::conj).collect(),
            t: array(&t),
            t_inverse: array(&t_inverse),
            estimate: std::array::from_fn(|j| -derivative[(0, j + 1)]),
            barycentric: std::array::from_fn(|j| {
                let others = points.iter().enumerate().filter(|(k, _)| *k != j + 1);
                others.map(|(_, x)| points[j + 1] - x).product::<f64>().recip()
            }),
        })
    }

    /// The weights of the values at the nodes in their polynomial, which is 0 at 0, at c.
    pub(super) fn weights(&self, c: f64) -> [f64; S] {
        std::array::from_fn(|j| {
            let others = self.nodes.iter().enumerate().filter(|(k, _)| *k != j);
            others.map(|(_, x)| c - x).product::<f64>() * c * self.barycentric[j]
        })
    }
}

/// A x.
#[inline]
pub(super) fn product<const S: usize>(a: &[[f64; S]; S], x: &[f64; S]) -> [f64; S] {
    std::array::from_fn(|i| dot(&a[i], x))
}

#[inline]
pub(super) fn dot<const S: usize>(a: &[f64; S], x: &[f64; S]) -> f64 {
    a.iter().zip(x).map(|(a, x)| a * x).sum()
}

/// The eigenvector of `a` with its largest component 1, by inverse iteration.
fn eigenvector(a: &DMatrix<f64>, eigenvalue: Complex<f64>) -> DVector<Complex<f64>> {
    let n = a.nrows();
    // A shift of the eigenvalue in its last digits keeps the factors finite; two solves leave nothing of other vectors.
    let shift = eigenvalue * (1.0 + 1e-10);
    let lu = (a.map(Complex::from) - DMatrix::identity(n, n) * shift).lu();
    let mut x = DVector::from_element(n, Complex::from(1.0));
    for _ in 0..3 {
        lu.solve_mut(&mut x);
        let largest = x.iter().copied().max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap_or_default();
        x /= largest;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check<const S: usize>(c: &Coefficients<S>) {
        let norm = |a: &[[f64; S]; S]| {
            a.iter().map(|row| row.iter().map(|x| x.abs()).sum::<f64>()).max_by(f64::total_cmp).expect("entries")
        };
        // T⁻¹ A⁻¹ T, with its roundings and those of the eigenvectors, which the condition of T amplifies.
        let allowed = 1e2 * f64::EPSILON * norm(&c.t) * norm(&c.t_inverse) * norm(&c.inverse);
        assert!(allowed < 1e-8, "{allowed:e}");
        for j in 0..S {
            let column = std::array::from_fn(|i| c.t[i][j]);
            let image = product(&c.t_inverse, &product(&c.inverse, &column));
            for (i, x) in image.into_iter().enumerate() {
                let pair = |k: usize| c.pairs[(k - 1) / 2];
                let block = match (i, j) {
                    (0, 0) => c.gamma,
                    _ if i == j => pair(i).re,
                    _ if i == j + 1 && j % 2 == 1 => pair(i).im,
                    _ if j == i + 1 && i % 2 == 1 => -pair(i).im,
                    _ => 0.0,
                };
                assert!((x - block).abs() < allowed, "s = {S}: ({i}, {j}) is {x} and not {block}");
            }
        }
        // h f₀ + Σ eᵢ Zᵢ vanishes for v = t, t², …, tˢ, and no further: the estimate is of order s.
        for power in 1..=S + 1 {
            let terms: [f64; S] = std::array::from_fn(|i| c.estimate[i] * c.nodes[i].powi(power as i32));
            let start = if power == 1 { 1.0 } else { 0.0 };
            let (sum, size) = terms.iter().fold((start, start), |(sum, size), x| (sum + x, size + x.abs()));
            assert_eq!(sum.abs() <= 1e2 * f64::EPSILON * size, power <= S, "s = {S}, t^{power}: {sum:e}");
        }
        for (c_i, j) in c.nodes.iter().zip(0..) {
            for (k, w) in c.weights(*c_i).into_iter().enumerate() {
                approx::assert_abs_diff_eq!(w, if j == k { 1.0 } else { 0.0 }, epsilon = 1e-13);
            }
        }
    }

    #[test]
    fn the_basis_decouples_the_stages_and_the_estimate_has_the_order_of_the_nodes() {
        check(three().expect("nodes"));
        check(five().expect("nodes"));
        check(seven().expect("nodes"));
        // The characteristic polynomial of A⁻¹ is λ³ − 9λ² + 36λ − 60: w³ + 9w − 6 in w = λ − 3.
        let gamma = 3.0 + 9.0_f64.cbrt() - 3.0_f64.cbrt();
        approx::assert_relative_eq!(three().expect("nodes").gamma, gamma, max_relative = 1e-14);
    }
}
