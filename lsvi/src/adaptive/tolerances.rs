//! Which error is tolerated.

use crate::error::{InputError, SettingError, SystemError};

/// The error that is tolerated in each component, τᵢ = atolᵢ + rtol |vᵢ|.
///
/// It is reached in the solution where h resolves it. A stiff component that follows a forcing, hλ ≫ 1, has an error of the
/// order of what its estimate is held to, with s stages 0.1 τ^((s+1)/2s) |v|^((s−1)/2s) where that is more than τ: the power
/// 2/3 of τ with three, 4/7 with seven. So has a step within which f has a kink or jumps; [`strict`](Self::strict) tolerances hold the error
/// of a kink to τ, as a rule. A kink or a jump may lie where the estimate of a step hardly sees it; [`Radau::stop_at`](super::Radau::stop_at)
/// ends a step at one.
/// A first step, and one that takes in a good part of a period of the forcing, of which an
/// estimate may vanish by chance, can have ten times that and more; [`Options::h_max`](super::Options::h_max) limits both.
///
/// atol = 0 asks for relative accuracy alone; a component that passes through zero then has short steps there. A component that is 0 and
/// leaves it like tᵏ has relative accuracy if k is at most the number of stages, or if it leaves at t = 0, where times go down to 10⁻³⁰⁸;
/// elsewhere no step reaches it, and the method returns [`StepError::StepUnderflow`](crate::StepError::StepUnderflow).
///
/// No τ is below [`f64::MIN_POSITIVE`], whatever the tolerances: doubles below that have fewer digits, and the
/// reciprocals of some are infinite. So small is the error of a component of which rtol |v| is less, as of one that decays to nothing.
///
/// Components of different size want an atol each:
///
/// ```
/// # use lsvi::adaptive::Tolerances;
/// let robertson = Tolerances::new(1e-6, 1e-8)?.with_atol(vec![1e-8, 1e-14, 1e-6])?;
/// assert!(Tolerances::new(1e-17, 1e-8).is_err());
/// # Ok::<(), lsvi::InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Tolerances {
    rtol: f64,
    /// One for all components, or one for each.
    atol: Vec<f64>,
    is_strict: bool,
}

impl Tolerances {
    /// The least normal number, whose reciprocal is finite. The least double is ε times that, so that what underflow changes of products and
    /// differences is as far below τ as roundings are below one.
    const LEAST: f64 = f64::MIN_POSITIVE;

    /// Least relative tolerance, ten roundings: below it the error of a step drowns in that of its arithmetic.
    pub const LEAST_RTOL: f64 = 10.0 * f64::EPSILON;

    /// A relative tolerance, and an absolute one for all components, in the units of v.
    ///
    /// # Errors
    /// [`SettingError::RelativeTolerance`] unless [`LEAST_RTOL`](Self::LEAST_RTOL) ≤ rtol ≤ 1,
    /// [`SettingError::AbsoluteTolerance`] unless atol ≥ 0 is finite.
    pub fn new(rtol: f64, atol: f64) -> Result<Self, InputError> {
        let within = (Self::LEAST_RTOL..=1.0).contains(&rtol);
        if !within {
            return Err(InputError::Setting(SettingError::RelativeTolerance { rtol, least: Self::LEAST_RTOL }));
        }
        Self { rtol, atol: Vec::new(), is_strict: false }.with_atol(vec![atol])
    }

    /// The same, which estimates are held to as they are, to τᵢ in component i: an error of their own order, as where f has a kink within a
    /// step, is then τ too, unless the kink lies where an estimate vanishes. Steps on smooth solutions are shorter than they need be.
    #[must_use]
    pub fn strict(self) -> Self {
        Self { is_strict: true, ..self }
    }

    /// The same with an absolute tolerance for each component, or one for all.
    ///
    /// # Errors
    /// [`SettingError::AbsoluteTolerance`] unless each is finite and not negative, [`SystemError::Dimension`] without any.
    pub fn with_atol(self, atol: Vec<f64>) -> Result<Self, InputError> {
        if atol.is_empty() {
            return Err(InputError::System(SystemError::Dimension { what: "atol", expected: 1, found: 0 }));
        }
        match atol.iter().position(|x| !(x.is_finite() && *x >= 0.0)) {
            Some(index) => Err(InputError::Setting(SettingError::AbsoluteTolerance { index, atol: atol[index] })),
            None => Ok(Self { atol, ..self }),
        }
    }

    /// All of them divided by `factor`, the relative one down to [`LEAST_RTOL`](Self::LEAST_RTOL); a factor below 1, or NaN, is 1.
    #[must_use]
    pub fn tightened(&self, factor: f64) -> Self {
        let factor = factor.max(1.0);
        let atol = self.atol.iter().map(|atol| atol / factor).collect();
        Self { rtol: (self.rtol / factor).max(Self::LEAST_RTOL), atol, ..*self }
    }

    /// The relative tolerance.
    pub fn rtol(&self) -> f64 {
        self.rtol
    }

    /// The absolute tolerances, one for all components or one for each.
    pub fn atol(&self) -> &[f64] {
        &self.atol
    }

    /// The same with an atol for each of n components, none below [`LEAST`](Self::LEAST).
    pub(super) fn expanded(mut self, n: usize) -> Result<Self, InputError> {
        self.atol.iter_mut().for_each(|atol| *atol = atol.max(Self::LEAST));
        if let [atol] = *self.atol {
            self.atol = vec![atol; n];
        }
        if self.atol.len() == n {
            Ok(self)
        } else {
            Err(InputError::System(SystemError::Dimension { what: "atol", expected: n, found: self.atol.len() }))
        }
    }

    /// τ of component `i` of the given size.
    #[inline]
    pub(super) fn of(&self, i: usize, size: f64) -> f64 {
        self.atol[i] + self.rtol * size
    }

    /// Whether nothing tells how large component `i` of the given size is: it is zero, and there is no absolute tolerance.
    #[inline]
    pub(super) fn knows_no_size(&self, i: usize, size: f64) -> bool {
        size == 0.0 && self.atol[i] <= Self::LEAST
    }

    /// What an estimate of order s of component `i` of size w is held to, where the solution has order 2s − 1: τ, or where
    /// that is more 0.1 τ^((s+1)/2s) w^((s−1)/2s), and τ alone where the tolerances are strict.
    ///
    /// The exponents sum to 1, so that units do not matter, and both terms grow with either tolerance. With w = τ/rtol in
    /// place of the size it would be the transform of RADAU5 ([HW96] IV.8), which lets the error grow where rtol falls below
    /// atol.
    #[inline]
    pub(super) fn of_estimate(&self, i: usize, size: f64, s: usize) -> f64 {
        let tolerated = self.of(i, size);
        if self.is_strict {
            return tolerated;
        }
        let size = size / tolerated;
        let root = if s == 3 { cube_root(size) } else { size.powf((s - 1) as f64 / (2 * s) as f64) };
        tolerated * (0.1 * root).max(1.0)
    }
}

/// The square of x times one over what is tolerated, which is finite.
#[inline]
pub(super) fn squared(x: f64, over_tolerated: f64) -> f64 {
    (x * over_tolerated).powi(2)
}

/// The cube root of x ≥ 0, positive for 0 too: from a third of the exponent, right to a thirtieth, by two iterations of Halley's method, which
/// cubes the error. It takes a third of the time of a power.
#[inline]
fn cube_root(x: f64) -> f64 {
    /// Two thirds of the bits of 1, less what balances the error.
    const OFFSET: u64 = 0x2a9f_7893 << 32;
    let mut root = f64::from_bits(x.to_bits() / 3 + OFFSET);
    for _ in 0..2 {
        let cube = root * root * root;
        root *= (cube + 2.0 * x) / (2.0 * cube + x);
    }
    root
}

/// The root of the mean of n squares that sum to `sum`: it does not grow with the number of components alike.
pub(super) fn root_mean(sum: f64, n: usize) -> f64 {
    (sum / n.max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Doubling either tolerance never tightens a scale; doubling the unit of v doubles the scale.
    #[test]
    fn what_an_estimate_is_held_to_grows_with_each_tolerance_and_with_the_unit() {
        for s in [3, 5, 7] {
            for size in [0.0, 1e-12, 1e-3, 1.0, 1e6] {
                for (a, b) in (0..30).flat_map(|a| (0..30).map(move |b| (a, b))) {
                    let (rtol, atol) = (0.5_f64.powi(a) * 1e-2, 0.5_f64.powi(b) * 1e-2);
                    let scale =
                        |rtol, atol, size| Tolerances::new(rtol, atol).expect("positive").of_estimate(0, size, s);
                    let here = scale(rtol, atol, size);
                    // Roundings of a power.
                    assert!(scale(0.5 * rtol, atol, size) <= here * (1.0 + 1e-14));
                    assert!(scale(rtol, 0.5 * atol, size) <= here * (1.0 + 1e-14));
                    approx::assert_relative_eq!(scale(rtol, 2.0 * atol, 2.0 * size), 2.0 * here, max_relative = 1e-14);
                }
            }
        }
    }

    #[test]
    fn an_estimate_is_held_to_a_power_of_the_tolerance_that_goes_by_the_stages() {
        for s in [3, 5, 7] {
            let power = |x: f64, twice: usize| x.powf(twice as f64 / (2 * s) as f64);
            for (rtol, atol, size) in [(1e-3, 1e-6, 1.0), (1e-6, 1e-9, 20.0), (1e-12, 0.0, 1e-3), (1e-1, 1.0, 1.0)] {
                let tolerated = atol + rtol * size;
                let held = (0.1 * power(tolerated, s + 1) * power(size, s - 1)).max(tolerated);
                let found = Tolerances::new(rtol, atol).expect("positive").of_estimate(0, size, s);
                // Roundings of a power.
                approx::assert_relative_eq!(found, held, max_relative = 1e-14);
            }
        }
    }

    #[test]
    fn tightened_tolerances_stay_strict_and_others_do_not_become_so() {
        let of = |rtol, atol| Tolerances::new(rtol, atol).expect("positive");
        // A factor of two rounds nothing.
        assert_eq!(of(1e-4, 1e-6).strict().tightened(2.0), of(0.5e-4, 0.5e-6).strict());
        assert_eq!(of(1e-4, 1e-6).tightened(2.0), of(0.5e-4, 0.5e-6));
    }

    /// n equal components have the norm of one.
    #[test]
    fn the_norm_is_a_mean() {
        for n in [1, 7, 100] {
            let sum = (0..n).map(|_| squared(3.0, 2.0)).sum();
            approx::assert_relative_eq!(root_mean(sum, n), 6.0, max_relative = 1e-14);
        }
        assert_eq!(squared(0.0, Tolerances::LEAST.recip()), 0.0);
    }
}
