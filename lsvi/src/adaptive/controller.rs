//! Which error is tolerated, and the step size that meets it.

use crate::error::InputError;

/// The error that is tolerated in each component, atol + rtol |vᵢ|.
///
/// It is reached in the solution where h resolves it. A stiff component that follows a forcing, hλ ≫ 1, has an error of the
/// order of its estimate, up to 0.1 rtol^(2/3) in place of rtol.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    rtol: f64,
    atol: f64,
}

impl Tolerances {
    /// Relative and absolute tolerance, the latter in the units of v.
    ///
    /// # Errors
    /// [`InputError::Tolerance`] unless both are positive and finite.
    pub fn new(rtol: f64, atol: f64) -> Result<Self, InputError> {
        match [rtol, atol].into_iter().find(|x| !(x.is_finite() && *x > 0.0)) {
            Some(bad) => Err(InputError::Tolerance(bad)),
            None => Ok(Self { rtol, atol }),
        }
    }

    /// The relative tolerance.
    pub fn rtol(&self) -> f64 {
        self.rtol
    }

    /// The absolute tolerance.
    pub fn atol(&self) -> f64 {
        self.atol
    }

    /// What the estimate is held to: it is of order 3 where the solution has order 5, and 0.1 rtol^(2/3) in its place gives
    /// errors of the solution near rtol ([HW96] IV.8).
    pub(super) fn for_estimate(self) -> Self {
        let rtol = 0.1 * self.rtol.powf(2.0 / 3.0);
        Self { rtol, atol: rtol * self.atol / self.rtol }
    }

    /// Writes atol + rtol |vᵢ|.
    pub(super) fn scale(&self, v: &[f64], out: &mut [f64]) {
        for (o, v) in out.iter_mut().zip(v) {
            *o = self.atol + self.rtol * v.abs();
        }
    }
}

/// The root of the mean of the squares of x in units of `scale`.
pub(super) fn weighted_norm(x: &[f64], scale: &[f64]) -> f64 {
    let sum: f64 = x.iter().zip(scale).map(|(x, s)| (x / s).powi(2)).sum();
    (sum / x.len().max(1) as f64).sqrt()
}

/// Gustafsson's predictive controller ([HW96] IV.8): the change of the error from step to step foretells the next.
#[derive(Debug, Default)]
pub(super) struct Controller {
    /// Size and error of the last accepted step.
    accepted: Option<(f64, f64)>,
    rejected: bool,
}

/// Safety factor.
const SAFETY: f64 = 0.9;
/// Bounds on h/h_new.
const SHRINK: f64 = 8.0;
const GROW: f64 = 0.125;
/// Errors below this say nothing about the next one.
const SMALLEST: f64 = 1e-2;

impl Controller {
    /// Forgets everything: the next step is a first step.
    pub(super) fn restart(&mut self) {
        *self = Self::default();
    }

    pub(super) fn is_cautious(&self) -> bool {
        self.rejected || self.accepted.is_none()
    }

    /// The step size after a step of size `h` with error `error` in units of the tolerance, accepted if below 1; Newton's
    /// iteration took the share `effort` ≤ 1 of its limit.
    pub(super) fn next(&mut self, h: f64, error: f64, effort: f64) -> f64 {
        // More than a few iterations call for a shorter step.
        let safety = SAFETY * (1.0 - 0.5 * effort);
        let bounded = |quotient: f64| quotient.clamp(GROW, SHRINK);
        let quotient = bounded(error.powf(0.25) / safety);
        if error >= 1.0 {
            let first = self.accepted.is_none();
            self.rejected = true;
            return if first { 0.1 * h } else { h / quotient };
        }
        let mut next = h / quotient;
        if let Some((before, last)) = self.accepted {
            next = next.min(h / bounded(h.recip() * before * (error * error / last).powf(0.25) / SAFETY));
        }
        self.accepted = Some((h, error.max(SMALLEST)));
        if std::mem::take(&mut self.rejected) { next.min(h) } else { next }
    }

    /// The iteration failed.
    pub(super) fn failed(&mut self) {
        self.rejected = true;
    }
}
