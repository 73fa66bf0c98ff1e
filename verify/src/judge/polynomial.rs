//! Polynomials with real coefficients, and where they are negative.

use std::f64::consts::PI;

use nalgebra::{Complex, DMatrix, Schur};

use super::real::Real;
use crate::measure::norm::larger;

/// Most iterations for a root; a handful is usual.
pub(super) const ITERATIONS: usize = 100;

/// Coefficients of 1, x, x², …; none that may be zero at the end.
#[derive(Debug, Clone, PartialEq)]
pub struct Polynomial(Vec<Real>);

/// Where a polynomial on x > 0 is first negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Sign {
    /// Nowhere.
    NonNegative,
    /// From `from` on, where it is zero or x = 0; `at` is a point where it is negative.
    NegativeFrom { from: f64, at: f64 },
}

impl Polynomial {
    pub(super) fn new(mut coefficients: Vec<Real>) -> Self {
        while coefficients.last().is_some_and(Real::may_be_zero) {
            coefficients.pop();
        }
        Self(coefficients)
    }

    /// The coefficients of 1, x, x², ….
    pub fn coefficients(&self) -> &[Real] {
        &self.0
    }

    /// The degree; `None` for the zero polynomial.
    pub fn degree(&self) -> Option<usize> {
        self.0.len().checked_sub(1)
    }

    pub(super) fn doubles(&self) -> Vec<f64> {
        self.0.iter().map(Real::to_f64).collect()
    }

    pub(super) fn at(&self, x: &Real) -> Real {
        self.0.iter().rev().fold(Real::zero(), |sum, c| &(&sum * x) + c)
    }

    /// The value at a complex point.
    pub fn at_complex(&self, z: Complex<f64>) -> Complex<f64> {
        self.0.iter().rev().fold(Complex::new(0.0, 0.0), |sum, c| sum * z + c.to_f64())
    }

    pub(super) fn minus(&self, other: &Self) -> Self {
        let n = self.0.len().max(other.0.len());
        let get = |p: &Self, k: usize| p.0.get(k).cloned().unwrap_or_else(Real::zero);
        Self::new((0..n).map(|k| &get(self, k) - &get(other, k)).collect())
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        self.minus(&Self(other.0.iter().map(|c| -c).collect()))
    }

    pub(super) fn times(&self, other: &Self) -> Self {
        let mut out = vec![Real::zero(); (self.0.len() + other.0.len()).saturating_sub(1)];
        for (i, a) in self.0.iter().enumerate() {
            for (j, b) in other.0.iter().enumerate() {
                out[i + j] = &out[i + j] + &(a * b);
            }
        }
        Self::new(out)
    }

    /// p/(x − r), where r is a root.
    pub(super) fn without_root(&self, root: &Real) -> Self {
        let mut quotient: Vec<Real> = Vec::new();
        for c in self.0.iter().skip(1).rev() {
            let carried = quotient.last().map_or_else(Real::zero, |last| last * root);
            quotient.push(c + &carried);
        }
        quotient.reverse();
        Self(quotient)
    }

    /// p(−x).
    pub(super) fn mirrored(&self) -> Self {
        Self(self.0.iter().enumerate().map(|(k, c)| if k % 2 == 0 { c.clone() } else { -c }).collect())
    }

    /// |p(i√x)|² as a polynomial in x.
    pub(super) fn modulus_on_imaginary_axis(&self) -> Self {
        let part = |odd: usize| {
            let terms = self.0.iter().skip(odd).step_by(2).enumerate();
            Self::new(terms.map(|(k, c)| if k % 2 == 0 { c.clone() } else { -c }).collect())
        };
        let (even, odd) = (part(0), part(1));
        let shifted = Self::new([vec![Real::zero()], odd.times(&odd).0].concat());
        even.times(&even).plus(&shifted)
    }

    /// All roots in double precision.
    pub fn roots(&self) -> Vec<Complex<f64>> {
        let Some(degree) = self.degree().filter(|n| *n > 0) else { return Vec::new() };
        let c = self.doubles();
        // In a variable in which the first and the last coefficient are of one size, the companion matrix is balanced.
        let lowest = c.iter().position(|x| *x != 0.0).unwrap_or(0);
        let n = degree - lowest;
        let mut roots = vec![Complex::new(0.0, 0.0); lowest];
        if n == 0 {
            return roots;
        }
        let scale = (c[lowest] / c[degree]).abs().powf(1.0 / n as f64);
        let mut companion = DMatrix::zeros(n, n);
        for k in 0..n {
            companion[(k, n - 1)] = -c[lowest + k] / c[degree] * scale.powi(k as i32 - n as i32);
            if k > 0 {
                companion[(k, k - 1)] = 1.0;
            }
        }
        if companion.iter().all(|x| x.is_finite()) {
            let schur = Schur::try_new(companion, f64::EPSILON, ITERATIONS * n);
            let found = schur.map(|schur| schur.complex_eigenvalues().iter().map(|z| z * scale).collect::<Vec<_>>());
            let rest: Vec<Complex<f64>> = c[lowest..].iter().map(|c| Complex::new(*c, 0.0)).collect();
            roots.extend(found.unwrap_or_else(|| simultaneous(&rest)));
        }
        roots
    }

    /// p′.
    fn derivative(&self) -> Self {
        Self::new(self.0.iter().enumerate().skip(1).map(|(k, c)| c * &Real::from(k as i64)).collect())
    }

    /// xⁿ p(1/x), which has the roots 1/r.
    fn reversed(&self) -> Self {
        Self::new(self.0.iter().rev().cloned().collect())
    }

    /// Quotient and remainder; the divisor is not zero.
    fn divided_by(&self, divisor: &Self) -> (Self, Self) {
        let (mut rest, n) = (self.0.clone(), divisor.0.len());
        let mut quotient = vec![Real::zero(); (rest.len() + 1).saturating_sub(n)];
        let Some(leading) = divisor.0.last() else { return (Self(Vec::new()), self.clone()) };
        for k in (0..quotient.len()).rev() {
            let factor = &rest[k + n - 1] / leading;
            for (x, d) in rest[k..].iter_mut().zip(&divisor.0) {
                *x = &*x - &(&factor * d);
            }
            quotient[k] = factor;
        }
        rest.truncate(n - 1);
        (Self::new(quotient), Self::new(rest))
    }

    /// The greatest common divisor, by Euclid; what cannot be told from zero is zero.
    fn common_divisor(&self, other: &Self) -> Self {
        let (mut a, mut b) = (self.clone(), other.clone());
        while b.degree().is_some() {
            (a, b) = (b.clone(), a.divided_by(&b).1);
        }
        a
    }

    /// Each root once.
    pub(super) fn squarefree(&self) -> Self {
        self.divided_by(&self.repeated()).0
    }

    /// The roots that are there more than once, each one time less.
    pub(super) fn repeated(&self) -> Self {
        self.common_divisor(&self.derivative())
    }

    /// The part of which the roots come in pairs z, 1/z: those on the unit circle are among them.
    pub(super) fn reciprocal_part(&self) -> Self {
        self.common_divisor(&self.reversed())
    }

    /// The widest of the coefficients.
    pub(super) fn radius(&self) -> f64 {
        self.0.iter().map(Real::radius).fold(0.0, larger)
    }

    /// Where on x > 0 it is first negative. Candidates for a change of sign are the real roots in double precision; between
    /// them the sign is that at one point, computed to 57 digits.
    pub(super) fn sign(&self) -> Sign {
        // What cannot be told from zero is zero: the first coefficients vanish with the order of a method.
        let known = |c: &Real| if c.may_be_zero() { Real::zero() } else { c.clone() };
        let certain = Self::new(self.0.iter().map(known).collect());
        let mut candidates: Vec<f64> =
            certain.roots().iter().filter(|z| z.re > 0.0 && z.im.abs() <= 1e-3 * z.re).map(|z| z.re).collect();
        candidates.sort_by(f64::total_cmp);
        let mut points = Vec::new();
        let mut left = 0.0;
        for &root in &candidates {
            points.push((left, if left == 0.0 { 0.5 * root } else { (left * root).sqrt() }));
            left = root;
        }
        points.push((left, if left == 0.0 { 1.0 } else { 2.0 * left }));
        for (from, at) in points {
            if certain.at(&Real::double(at)).is_negative() {
                return Sign::NegativeFrom { from, at };
            }
        }
        Sign::NonNegative
    }
}

/// All roots of Σ c_k xᵏ, c_0 ≠ 0 ≠ c_n, at once, by the iteration of Ehrlich and Aberth: slower than the eigenvalues of the
/// companion matrix, whose iteration stalls where many roots have one modulus.
pub(super) fn simultaneous(c: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let n = c.len() - 1;
    let size = (c[0].norm() / c[n].norm()).powf(1.0 / n as f64);
    // No symmetry of the roots is one of these angles.
    let start = |k: usize| Complex::from_polar(size, 0.4 + 2.0 * PI * k as f64 / n as f64);
    let mut roots: Vec<Complex<f64>> = (0..n).map(start).collect();
    let zero = Complex::new(0.0, 0.0);
    for _ in 0..ITERATIONS {
        let mut is_settled = true;
        for k in 0..n {
            let z = roots[k];
            let (value, slope, rounding) =
                c.iter().rev().fold((zero, zero, 0.0), |(p, d, r), c| (p * z + c, d * z + p, r * z.norm() + c.norm()));
            if value.norm() <= 2.0 * f64::EPSILON * rounding {
                continue;
            }
            let newton = value / slope;
            let others: Complex<f64> =
                roots.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, other)| (z - other).inv()).sum();
            let step = newton / (Complex::new(1.0, 0.0) - newton * others);
            roots[k] = z - step;
            is_settled &= step.norm() <= 4.0 * f64::EPSILON * z.norm();
        }
        if is_settled {
            break;
        }
    }
    roots
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polynomial(coefficients: &[i64]) -> Polynomial {
        Polynomial::new(coefficients.iter().map(|c| Real::from(*c)).collect())
    }

    #[test]
    fn signs_are_found_between_the_roots_and_not_where_a_root_only_touches() {
        assert_eq!(polynomial(&[1, -2, 1]).sign(), Sign::NonNegative);
        let Sign::NegativeFrom { from, at } = polynomial(&[2, -3, 1]).sign() else {
            panic!("negative between 1 and 2")
        };
        assert!((from - 1.0).abs() < 1e-9 && at > 1.0 && at < 2.0);
        assert!(matches!(polynomial(&[0, -1, 1]).sign(), Sign::NegativeFrom { from: 0.0, .. }));
        assert!(matches!(polynomial(&[0, 0, -1]).sign(), Sign::NegativeFrom { from: 0.0, .. }));
        assert_eq!(polynomial(&[]).sign(), Sign::NonNegative);
    }

    /// Roots of unity, twice: the iteration for eigenvalues does not settle on them.
    #[test]
    fn roots_of_one_modulus_are_found_too() {
        // (x − 1)(x² + 1)².
        let p = polynomial(&[-1, 1, -2, 2, -1, 1]);
        let roots = p.roots();
        assert_eq!(roots.len(), 5);
        for root in roots {
            let near = |z: Complex<f64>| (z - root).norm() < 1e-6;
            assert!(
                near(Complex::new(1.0, 0.0)) || near(Complex::new(0.0, 1.0)) || near(Complex::new(0.0, -1.0)),
                "{root}"
            );
        }
        assert_eq!(p.repeated().degree(), Some(2));
        assert_eq!(p.squarefree().degree(), Some(3));
        assert_eq!(p.reciprocal_part().degree(), Some(5));
        // (x − 2)(x² + 1): the pair on the circle alone.
        assert_eq!(polynomial(&[-2, 1, -2, 1]).reciprocal_part().degree(), Some(2));
        let complex: Vec<Complex<f64>> = [6.0, -5.0, 1.0].map(|c| Complex::new(c, 0.0)).to_vec();
        let mut two = simultaneous(&complex).iter().map(|z| z.re).collect::<Vec<_>>();
        two.sort_by(f64::total_cmp);
        assert!((two[0] - 2.0).abs() < 1e-12 && (two[1] - 3.0).abs() < 1e-12, "{two:?}");
    }

    #[test]
    fn the_modulus_on_the_imaginary_axis_is_that_of_the_value_there() {
        let p = polynomial(&[3, -1, 4, 2, -5]);
        let y = 0.7_f64;
        let value = p.at_complex(Complex::new(0.0, y)).norm_sqr();
        assert!((p.modulus_on_imaginary_axis().at(&Real::double(y * y)).to_f64() - value).abs() < 1e-13);
    }
}
