//! Closures p₁ = θ p₀ fitted to the decay e^{−λt}: exact, rational, and uniformly best over a range of steps.

use super::Linear;
use crate::error::{ClosureError, InputError};

impl Linear {
    /// (α, β) = (−θ, 1) with θ(hλ) such that one step multiplies a solution of v̇ = −λv by exactly e^{−hλ}.
    ///
    /// With z = hλ, θ = [1 − (1 + z + z²/2) e^{−z}]/[1 − z + z²/2 − e^{−z}] = 1 − z/2 + z²/8 − …, between Method II for
    /// z → 0 and Method I for z → ∞. Other rates, and nonlinear problems, are solved to order 2. For h → 0 the condition is
    /// J₀ᵀr₀ + J₁ᵀr₁ = λ p₀, which determines nothing where J has the eigenvalue λ/2: a solution that meets such a point may
    /// stay there, as at a steady state, so that λ should exceed twice the fastest growth.
    ///
    /// # Errors
    /// [`ClosureError::Rate`] unless λ is positive and finite.
    pub fn fitted(rate: f64) -> Result<Self, InputError> {
        check_rate(rate)?;
        Self::of_step(move |h| (-theta(h * rate), 1.0))
    }

    /// (α, β) = (−θ, 1) with θ = 1/(1 + hλ/2): one step multiplies a solution of v̇ = −λv by the (1,2) Padé approximant of
    /// e^{−hλ}, of order 3. Otherwise as [`fitted`](Self::fitted), whose θ it approximates to order 2 for small hλ.
    ///
    /// # Errors
    /// [`ClosureError::Rate`] unless λ is positive and finite.
    pub fn fitted_pade(rate: f64) -> Result<Self, InputError> {
        check_rate(rate)?;
        Self::of_step(move |h| (-1.0 / (1.0 + 0.5 * h * rate), 1.0))
    }

    /// (α, β) = (−θ, 1) with the constant θ that makes the largest error of one step, |R(−z) − e^{−z}|, least over all
    /// steps z = hλ of v̇ = −λv in the range `from` ≤ z ≤ `to`.
    ///
    /// The error is positive for z below the point ẑ where θ is exact and negative beyond it; at the best θ its two
    /// extremes are equal.
    ///
    /// # Errors
    /// [`ClosureError::StepRange`] unless 0 ≤ `from` ≤ `to` and `to` is positive and finite.
    pub fn minimax(from: f64, to: f64) -> Result<Self, InputError> {
        if !(0.0 <= from && from <= to && to > 0.0 && to.is_finite()) {
            return Err(InputError::Closure(ClosureError::StepRange { from, to }));
        }
        Self::new(-minimax_theta(from, to), 1.0)
    }
}

fn check_rate(rate: f64) -> Result<(), InputError> {
    if rate > 0.0 && rate.is_finite() { Ok(()) } else { Err(InputError::Closure(ClosureError::Rate(rate))) }
}

/// (∫₀¹ s² e^{−sz} ds, ∫₀¹ (1 − s)² e^{−sz} ds) for z ≥ 0: numerator and denominator of θ are z³/2 times these.
fn moments(z: f64) -> (f64, f64) {
    if z < 2.0 {
        // Both times e^z, as series of positive terms: 2 Σ z^k/(k + 3)! and Σ z^k/(k! (k + 3)).
        let (mut power, mut a, mut b) = (1.0, 0.0, 0.0);
        let mut k = 0.0;
        while power > f64::EPSILON * b {
            a += 2.0 * power / ((k + 1.0) * (k + 2.0) * (k + 3.0));
            b += power / (k + 3.0);
            k += 1.0;
            power *= z / k;
        }
        let decay = (-z).exp();
        (decay * a, decay * b)
    } else {
        // Nothing cancels beyond a factor of 3: (1 + z + z²/2) e^{−z} ≤ 0.68, and 1 − 2/z + 2/z² ≥ ½.
        let (decay, w) = ((-z).exp(), 1.0 / z);
        let a = 2.0 * w * w * w - decay * w * (2.0 * w * w + 2.0 * w + 1.0);
        let b = w * ((1.0 - w) * (1.0 - w) + w * w * (1.0 - 2.0 * decay));
        (a, b)
    }
}

/// The θ that is exact at z = hλ ≥ 0.
fn theta(z: f64) -> f64 {
    let (a, b) = moments(z);
    a / b
}

/// R(−z) − e^{−z} of the closure with the given θ.
///
/// It equals (z³/2)(a − θ b)/(1 + z + z²/2 − θ), which does not cancel where R and e^{−z} agree.
fn error(z: f64, theta: f64) -> f64 {
    let (a, b) = moments(z);
    0.5 * z * (a - theta * b) / ((1.0 - theta) / (z * z) + 1.0 / z + 0.5)
}

/// The best constant θ for z in [from, to].
///
/// ∂R/∂θ = −(z⁴/4)/(1 + z + z²/2 − θ)² < 0, so the error falls everywhere as θ grows, and the best θ is the only one whose
/// extreme errors are equal. With θ exact at ẑ, the error on [from, ẑ] is positive with one maximum, and its modulus on
/// [ẑ, to] grows up to the end.
fn minimax_theta(from: f64, to: f64) -> f64 {
    let (mut below, mut above) = (from, to);
    loop {
        let exact = 0.5 * (below + above);
        let theta = theta(exact);
        if exact == below || exact == above {
            return theta;
        }
        // A larger ẑ means a smaller θ: more error to its left, less to its right.
        if largest(|z| error(z, theta), from, exact) < -error(to, theta) { below = exact } else { above = exact }
    }
}

/// The largest value of a function with one maximum on (a, b), by golden sections.
fn largest(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    const SECTION: f64 = 0.618_033_988_749_894_9;
    let (mut x, mut y) = (b - SECTION * (b - a), a + SECTION * (b - a));
    let (mut at_x, mut at_y) = (f(x), f(y));
    // A maximum is flat: its value is exact to roundoff once its place is known to √ε.
    while b - a > f64::EPSILON.sqrt() * b {
        if at_x < at_y {
            (a, x, at_x) = (x, y, at_y);
            y = a + SECTION * (b - a);
            at_y = f(y);
        } else {
            (b, y, at_y) = (y, x, at_x);
            x = b - SECTION * (b - a);
            at_x = f(x);
        }
    }
    at_x.max(at_y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closure::LinearClosure;

    /// (z, θ) computed in 45-digit arithmetic and rounded to double precision.
    const TABLE: [(f64, f64); 15] = [
        (1e-8, 0.999_999_995),
        (1e-5, 0.999_995_000_012_5),
        (1e-3, 0.999_500_124_981_251_5),
        (0.05, 0.975_310_166_011_920_4),
        (0.5, 0.779_003_350_585_952_7),
        (1.0, 0.607_788_808_822_667_2),
        (1.9999, 0.373_947_224_193_115_2),
        (2.0, 0.373_929_429_001_337_4),
        (2.0001, 0.373_911_634_743_285_6),
        (3.0, 0.235_412_160_072_525_55),
        (7.5, 0.045_307_206_642_829_355),
        (20.0, 0.005_524_859_361_858_768),
        (60.0, 0.000_574_382_538_770_821_4),
        (250.0, 3.225_702_396_696_881e-5),
        (700.0, 4.093_311_120_298_321e-6),
    ];

    #[test]
    fn theta_is_accurate_for_small_and_large_steps() {
        for (z, exact) in TABLE {
            // About twenty roundings, amplified at most threefold where the two forms meet.
            approx::assert_relative_eq!(theta(z), exact, max_relative = 32.0 * f64::EPSILON);
        }
        assert_eq!(theta(0.0), 1.0);
        assert!((0.0..1e-100).contains(&theta(1e200)));
    }

    fn of_step(closure: &Linear, h: f64) -> f64 {
        let w = closure.weights(h);
        -w.alpha / w.beta
    }

    #[test]
    fn the_rational_closure_is_the_pade_approximant() {
        let closure = Linear::fitted_pade(3.0).expect("positive");
        for z in [1e-3_f64, 0.1, 1.0, 10.0] {
            let theta = of_step(&closure, z / 3.0);
            let amplification = (1.0 - theta * (1.0 - z + 0.5 * z * z)) / (1.0 - theta + z + 0.5 * z * z);
            let pade = (1.0 - z / 3.0) / (1.0 + 2.0 * z / 3.0 + z * z / 6.0);
            // Numerator and denominator vanish like 3z/2: roundoff ε/z, for z below 1.
            approx::assert_abs_diff_eq!(amplification, pade, epsilon = 8.0 * f64::EPSILON / z.min(1.0));
        }
    }

    /// Least and largest value of the textbook form of the error on a grid, finer towards the lower end.
    fn extremes(theta: f64, from: f64, to: f64) -> (f64, f64) {
        (0..=4000).fold((0.0_f64, 0.0_f64), |(low, high), k| {
            let z = from + (to - from) * (f64::from(k) / 4000.0).powi(3);
            let amplification = (1.0 - theta * (1.0 - z + 0.5 * z * z)) / (1.0 - theta + z + 0.5 * z * z);
            let error = amplification - (-z).exp();
            (low.min(error), high.max(error))
        })
    }

    #[test]
    fn the_minimax_error_equioscillates() {
        for (from, to) in [(0.0, 0.1), (0.0, 1.0), (0.1, 2.5), (0.0, 10.0), (1.0, 1.5), (0.0, 1e3), (30.0, 40.0)] {
            let best = of_step(&Linear::minimax(from, to).expect("a range"), 1.0);
            let (low, high) = extremes(best, from, to);
            // The grid misses a maximum by an eighth of (spacing)² times the curvature over the height, which are of order
            // 1: the widest range has a spacing of 0.0075 near its maximum at z ≈ 1.
            approx::assert_relative_eq!(-low, high, max_relative = 1e-5);
            for other in [best - 1e-3 * best, best + 1e-3 * best] {
                let (other_low, other_high) = extremes(other, from, to);
                assert!(other_high.max(-other_low) > high.max(-low), "[{from}, {to}]: {other} is better than {best}");
            }
        }
        let at_a_point = of_step(&Linear::minimax(2.0, 2.0).expect("a range"), 1.0);
        assert_eq!(at_a_point, theta(2.0));
    }

    #[test]
    fn unusable_rates_and_ranges_are_refused() {
        for rate in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(Linear::fitted(rate), Err(InputError::Closure(ClosureError::Rate(_)))));
            assert!(matches!(Linear::fitted_pade(rate), Err(InputError::Closure(ClosureError::Rate(_)))));
        }
        for (from, to) in [(-1.0, 1.0), (2.0, 1.0), (0.0, 0.0), (0.0, f64::INFINITY), (f64::NAN, 1.0)] {
            assert!(
                matches!(Linear::minimax(from, to), Err(InputError::Closure(ClosureError::StepRange { .. }))),
                "[{from}, {to}]"
            );
        }
    }
}
