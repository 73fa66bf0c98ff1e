//! Homogeneous closures of a scalar problem, Eq. (28).

use std::f64::consts::{FRAC_PI_2, PI};

use super::Linear;
use crate::error::{ClosureError, InputError};

impl Linear {
    /// The closure that F(p₀, p₁) = 0 amounts to, for F homogeneous of any degree and one degree of freedom, Eq. (28).
    ///
    /// The zero set of such an F is a union of lines α p₀ + β p₁ = 0, so F is a linear closure with a choice of line: the one
    /// nearest in direction to α p₀ + β p₁ = 0 with the coefficients `near`, among those where F changes sign. Lines are told apart to a
    /// degree: of two within one degree of each other either is taken, or none is seen, as F changes its sign twice. F itself cannot
    /// serve as the step equation: all lines with α + β ≠ 0 have roots within O(h³) of each other, so that two of them make
    /// every step nearly degenerate.
    ///
    /// ```
    /// use lsvi::closure::{Linear, LinearClosure};
    /// // p₀³ + p₁³ = 0 is p₀ + p₁ = 0.
    /// let closure = Linear::from_homogeneous(|a, b| a.powi(3) + b.powi(3), (0.0, 1.0))?;
    /// let w = closure.weights(0.1);
    /// assert!((w.alpha / w.beta - 1.0).abs() < 1e-15);
    /// # Ok::<(), lsvi::InputError>(())
    /// ```
    ///
    /// # Errors
    /// [`ClosureError::NoLine`] if F changes sign between no two lines a degree apart or is not finite, [`ClosureError::Closure`] if `near` is (0, 0).
    pub fn from_homogeneous(f: impl Fn(f64, f64) -> f64, near: (f64, f64)) -> Result<Self, InputError> {
        Self::new(near.0, near.1)?;
        // On the line through direction φ, (p₀, p₁) ∝ (cos φ, sin φ) and (α, β) ∝ (sin φ, −cos φ).
        let along = |phi: f64| f(phi.cos(), phi.sin());
        let start = near.0.atan2(-near.1);
        // The momenta of a line repeat after half a turn; look to both sides in steps that tell lines a degree apart.
        let step = PI / 180.0;
        for k in 0..90 {
            let (inner, outer) = (f64::from(k) * step, (f64::from(k + 1) * step).min(FRAC_PI_2));
            for side in [1.0, -1.0] {
                let bracket = (start + side * inner, start + side * outer);
                if let Some(phi) = bisect(&along, bracket) {
                    return Self::new(phi.sin(), -phi.cos());
                }
            }
        }
        Err(InputError::Closure(ClosureError::NoLine))
    }
}

/// The sign change of `g` in the bracket, to the last bit; `None` if there is none.
fn bisect(g: &impl Fn(f64) -> f64, (mut a, mut b): (f64, f64)) -> Option<f64> {
    let (sign, end) = (g(a), g(b));
    if sign == 0.0 {
        return Some(a);
    }
    if end == 0.0 {
        return Some(b);
    }
    if sign.is_nan() || end.is_nan() || sign.signum() == end.signum() {
        return None;
    }
    loop {
        let middle = 0.5 * (a + b);
        if middle == a || middle == b {
            return Some(middle);
        }
        if (g(middle) < 0.0) == (sign < 0.0) { a = middle } else { b = middle }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closure::LinearClosure;

    #[test]
    fn lines_more_than_a_degree_apart_are_told_apart() {
        let line = |degrees: f64| (PI + degrees.to_radians()).sin_cos();
        let [(s, c), (other_s, other_c)] = [line(1.3), line(2.6)];
        let closure = Linear::from_homogeneous(|a, b| (s * a - c * b) * (other_s * a - other_c * b), (0.0, 1.0));
        let found = closure.expect("two lines").weights(0.1);
        approx::assert_abs_diff_eq!(found.alpha / found.beta, -s / c, epsilon = 1e-15);
    }

    /// Between directions a degree apart F changes its sign twice, which looks like not at all.
    #[test]
    fn two_lines_within_a_degree_are_not_seen() {
        let found = Linear::from_homogeneous(|a, b| (b - 0.5 * a) * (b - 0.501 * a), (-0.4, 1.0));
        assert_eq!(found.err(), Some(InputError::Closure(ClosureError::NoLine)));
    }

    #[test]
    fn takes_the_nearest_line() {
        // (p₀ − p₁)(3 p₀ + p₁) p₁
        let f = |a: f64, b: f64| (a - b) * (3.0 * a + b) * b;
        for (near, ratio) in [((-1.0, 1.1), -1.0), ((2.0, 1.0), 3.0), ((0.1, 1.0), 0.0), ((-0.1, -1.0), 0.0)] {
            let w = Linear::from_homogeneous(f, near).expect("has lines").weights(1.0);
            approx::assert_abs_diff_eq!(w.alpha / w.beta, ratio, epsilon = 8.0 * f64::EPSILON);
        }
    }

    #[test]
    fn refuses_functions_without_a_line() {
        assert_eq!(
            Linear::from_homogeneous(|a, b| a * a + b * b, (0.0, 1.0)).err(),
            Some(InputError::Closure(ClosureError::NoLine))
        );
        assert_eq!(
            Linear::from_homogeneous(|_, _| f64::NAN, (0.0, 1.0)).err(),
            Some(InputError::Closure(ClosureError::NoLine))
        );
        assert!(Linear::from_homogeneous(|a, _| a, (0.0, 0.0)).is_err());
    }
}
