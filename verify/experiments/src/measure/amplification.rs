//! Amplification factors in closed form, and how precisely a live step can reproduce them.

use crate::measure::norm::Extremes;
use nalgebra::Complex;

/// One step of the linear closure (α, β) on v̇ = λ v multiplies v by R(z), z = hλ: for normal systems, with x = Re z,
/// y = Im z and m = |z|²/2,
///
/// R(z) = [α (1 + x + m) + β (1 + iy)] / [α (1 − iy) + β (1 − x + m)].
///
/// For λ = −1 this is Eq. (27), with (21), (22) and (25) as special cases.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amplification {
    /// Weight of p_n.
    pub alpha: f64,
    /// Weight of p_{n+1}.
    pub beta: f64,
}

impl Amplification {
    /// R(z).
    pub fn factor(self, z: Complex<f64>) -> Complex<f64> {
        let m = 0.5 * z.norm_sqr();
        // α + β is summed first: for Method II it cancels exactly.
        let numerator = Complex::new(self.alpha + self.beta + self.alpha * (z.re + m), self.beta * z.im);
        numerator / self.denominator(z)
    }

    /// The denominator D of R, h times the derivative of the step equation.
    pub fn denominator(self, z: Complex<f64>) -> Complex<f64> {
        let m = 0.5 * z.norm_sqr();
        Complex::new(self.alpha + self.beta + self.beta * (m - z.re), -self.alpha * z.im)
    }

    /// Whether z is so near a pole of R that first-order error bounds do not hold: D loses six of its digits.
    pub fn is_singular(self, z: Complex<f64>) -> bool {
        let m = 0.5 * z.norm_sqr();
        let terms = (self.alpha + self.beta).abs() + self.beta.abs() * (m + z.re.abs()) + (self.alpha * z.im).abs();
        self.denominator(z).norm() < 1e-6 * terms
    }

    /// Bound on the error of a live step from |v₀| = 1 on a normal system whose eigenvalues times h are `spectrum`.
    ///
    /// With residuals r₀ = d − λv₀, r₁ = d − λv₁ and d = (v₁ − v₀)/h, the step equation is
    /// ½(α+β)(r₀ + r₁) + ½h(α λ̄ r₀ − β λ̄ r₁) = 0. In the plane, each residual is rounded seven times, its product with λ̄
    /// three times and the combination five times: 15 roundings of ε/2, of the sizes of the terms and not of the differences
    /// they cancel to, twice as much for the absolute values of the entries of A, whose own rounding counts among them. They
    /// reach v₁ through the inverse of the equation's derivative, h/D; Newton's iteration ends no sooner. The formula itself
    /// rounds the same terms eight times in numerator and denominator. Together 23 ε.
    pub fn live_tolerance(self, spectrum: &[Complex<f64>]) -> f64 {
        let largest = |f: &dyn Fn(Complex<f64>) -> f64| spectrum.iter().map(|z| f(*z)).largest();
        let (z, v1) = (largest(&|z| z.norm()), largest(&|z| self.factor(z).norm()));
        let inverse = largest(&|z| self.denominator(z).norm().recip());
        // Everything times h: d h = v₁ − v₀, h r = d h − z v.
        let dh = 1.0 + v1;
        let (r0, r1) = (dh + z, dh + z * v1);
        let (sum, a, b) = ((self.alpha + self.beta).abs(), self.alpha.abs(), self.beta.abs());
        23.0 * f64::EPSILON * 0.5 * (sum * (r0 + r1) + z * (a * r0 + b * r1)) * inverse
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The closure (−½, 1) has D = ½ (x − 1)² for real z = x, of terms that add up to 2 at its zero.
    #[test]
    fn a_pole_is_where_the_denominator_has_lost_six_digits() {
        let closure = Amplification { alpha: -0.5, beta: 1.0 };
        let is_singular = |x: f64, y: f64| closure.is_singular(Complex::new(x, y));
        for sign in [-1.0, 1.0] {
            assert!(is_singular(1.0 + sign * 1.9e-3, 0.0) && !is_singular(1.0 + sign * 2.1e-3, 0.0));
        }
        assert!(!is_singular(1.0, 0.1) && !is_singular(-1.0, 0.0));
        // β = 0: D = −½ (1 − iy) never vanishes, α = 0 in D = 1 − x + m neither.
        assert!(!Amplification { alpha: -0.5, beta: 0.0 }.is_singular(Complex::new(1.0, 0.0)));
        assert!(!Amplification { alpha: 0.0, beta: 1.0 }.is_singular(Complex::new(1.0, 0.0)));
    }

    /// The closure (−⅘, 1) has D = ⅕ − x + ½x² for real z = x, with zeros 1 ± √⅗, where it rises by √⅗ and its terms add up to
    /// ⅕ + x + ½x².
    #[test]
    fn a_pole_is_as_wide_as_a_millionth_of_the_terms() {
        let root = 0.6_f64.sqrt();
        for x in [1.0 - root, 1.0 + root] {
            let width = 1e-6 * (0.2 + x + 0.5 * x * x) / root;
            for (scale, sign) in [(1.0, 1.0), (1.0, -1.0), (-40.0, 1.0)] {
                let closure = Amplification { alpha: -0.8 * scale, beta: scale };
                let is_singular = |part: f64| closure.is_singular(Complex::new(x + sign * part * width, 0.0));
                assert!(is_singular(0.98) && !is_singular(1.02), "{x}: {sign}");
            }
        }
    }

    /// The special cases as the paper prints them.
    #[test]
    fn reduces_to_the_printed_factors() {
        for h in [1e-3, 0.3, 1.0, 7.0, 1e3] {
            let z = Complex::new(-h, 0.0);
            let factor = |alpha, beta| Amplification { alpha, beta }.factor(z).re;
            let close = |a: f64, b: f64| assert!((a - b).abs() <= 8.0 * f64::EPSILON * (1.0 + b.abs()), "{a} and {b}");
            close(factor(1.0, 0.0), 1.0 - h + 0.5 * h * h); // (21)
            close(factor(0.0, 1.0), 1.0 / (1.0 + h + 0.5 * h * h)); // (22)
            close(factor(-1.0, 1.0), (1.0 - 0.5 * h) / (1.0 + 0.5 * h)); // (25)
            let (a, b) = (0.3, 1.7); // no pole for h > 0
            let printed = (a + b - a * h + 0.5 * a * h * h) / (a + b + b * h + 0.5 * b * h * h); // (27)
            close(factor(a, b), printed);
        }
    }
}
