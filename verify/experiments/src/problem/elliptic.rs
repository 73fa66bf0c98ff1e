//! Jacobi's amplitude and Legendre's first integral by the arithmetic–geometric mean (Abramowitz and Stegun 16.4, 17.6).

use std::f64::consts::PI;

/// Enough for a complement of the modulus as small as 1e-300: the ratio c/a is squared, or halved while b is negligible.
const LEVELS: usize = 64;

/// The functions of modulus k.
pub(super) struct Elliptic {
    /// a, b and c = ½(a − b) of the mean's iteration, from (1, k′, k) until c is negligible.
    means: Vec<[f64; 3]>,
}

impl Elliptic {
    /// Modulus k in \[0, 1\], given with its complement k′ = √(1 − k²).
    pub(super) fn new(modulus: f64, complement: f64) -> Self {
        let mut means = vec![[1.0, complement, modulus]];
        while let Some(&[a, b, c]) = means.last()
            && c > f64::EPSILON * a
            && b > 0.0
            && means.len() < LEVELS
        {
            means.push([0.5 * (a + b), (a * b).sqrt(), 0.5 * (a - b)]);
        }
        Self { means }
    }

    /// am(u, k), continuous in u: the φ with F(φ, k) = u.
    pub(super) fn amplitude(&self, u: f64) -> f64 {
        let (last, descent) = self.last();
        if last[1] == 0.0 {
            return u.sinh().atan();
        }
        let phi = 2_f64.powi(descent.len() as i32) * last[0] * u;
        descent.iter().rev().fold(phi, |phi, [a, _, c]| 0.5 * (phi + (c / a * phi.sin()).asin()))
    }

    /// F(φ, k) = ∫₀^φ dθ/√(1 − k² sin²θ).
    pub(super) fn integral(&self, phi: f64) -> f64 {
        let (last, descent) = self.last();
        if last[1] == 0.0 {
            return phi.tan().asinh();
        }
        let ascent = self.means[..descent.len()].iter();
        let phi = ascent.fold(phi, |phi, [a, b, _]| {
            let turns = PI * (phi / PI).round();
            phi + turns + (b / a * (phi - turns).tan()).atan()
        });
        phi / (2_f64.powi(descent.len() as i32) * last[0])
    }

    /// The last mean, and those from the second on.
    fn last(&self) -> ([f64; 3], &[[f64; 3]]) {
        (self.means[self.means.len() - 1], &self.means[1..])
    }
}
