//! The step size that meets a tolerance.

/// Gustafsson's predictive controller ([HW96] IV.8): the change of the error from step to step foretells the next.
#[derive(Debug)]
pub(super) struct Controller {
    safety: f64,
    /// Size and error of the last accepted step.
    accepted: Option<(f64, f64)>,
    /// That error, however small.
    error: f64,
    /// What that error counted for, and whether it was far below what the one before had foretold.
    counted: f64,
    fell: bool,
    rejected: bool,
    /// Whether no step was accepted since the start.
    is_first: bool,
}

/// Bounds on h/h_new.
const SHRINK: f64 = 8.0;
const GROW: f64 = 0.125;
/// Errors below this say nothing about the next one.
const SMALLEST: f64 = 1e-2;
/// Part of what the last error foretells that the error of a step counts for at least, unless that of the last step fell below it too, with
/// more than three stages. A forcing that a step takes through a good part of a period makes estimates that vanish by chance.
const CHANCE: f64 = 0.1;

/// Power 1/(s + 1).
fn root(x: f64, s: usize) -> f64 {
    if s == 3 { x.sqrt().sqrt() } else { x.powf(1.0 / (s + 1) as f64) }
}

impl Controller {
    pub(super) fn new(safety: f64) -> Self {
        Self { safety, accepted: None, error: 1.0, counted: 0.0, fell: false, rejected: false, is_first: true }
    }

    /// Forgets everything: the next step is a first step.
    pub(super) fn restart(&mut self) {
        *self = Self::new(self.safety);
    }

    /// Forgets the last error, which is that of another order.
    pub(super) fn forget(&mut self) {
        (self.accepted, self.error) = (None, 1.0);
    }

    /// The part that the last step was of one whose error is what is tolerated.
    pub(super) fn part(&self, s: usize) -> f64 {
        root(self.error, s)
    }

    /// Whether the error may be that of a stiff component's start, where the plain estimate is far too large.
    pub(super) fn is_cautious(&self) -> bool {
        self.rejected || self.is_first
    }

    /// The step size after a step of size `h` with error `error` in units of the tolerance, accepted if below 1. The estimate
    /// goes like h^(s+1); Newton's iteration took `iterations` of at most `limit`.
    pub(super) fn next(&mut self, h: f64, error: f64, s: usize, iterations: u32, limit: u32) -> f64 {
        let bounded = |quotient: f64| quotient.clamp(GROW, SHRINK);
        // More than a few iterations call for a shorter step.
        let effort = f64::from(2 * limit + 1) / f64::from(2 * limit + iterations);
        let foretold = match self.accepted {
            Some((before, _)) if s > 3 && self.counted >= SMALLEST => {
                CHANCE * self.counted * (h / before).powi(s as i32 + 1)
            }
            _ => 0.0,
        };
        let falls = error < foretold;
        let counted = if falls && !self.fell { foretold } else { error };
        let quotient = bounded(root(counted, s) / (self.safety * effort));
        if error >= 1.0 {
            self.rejected = true;
            return if self.is_first { 0.1 * h } else { h / quotient };
        }
        let mut next = h / quotient;
        if let Some((before, last)) = self.accepted {
            next = next.min(h / bounded(before / h * root(error * error / last, s) / self.safety));
        }
        (self.accepted, self.error) = (Some((h, error.max(SMALLEST))), error);
        (self.counted, self.fell) = (counted, falls);
        self.is_first = false;
        if std::mem::take(&mut self.rejected) { next.min(h) } else { next }
    }

    /// The iteration failed.
    pub(super) fn failed(&mut self) {
        self.rejected = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hundredth of what the last error foretells counts for a tenth of it, with more than three stages, and the next fall for what it is.
    #[test]
    fn an_error_that_vanishes_by_chance_makes_no_long_step() {
        for (s, held) in [(3, 0.01), (5, 0.1), (7, 0.1)] {
            let mut controller = Controller::new(0.9);
            controller.next(1.0, 0.5, s, 1, 7);
            let power = (s + 1) as i32;
            let foretold = 0.5 * 1.05_f64.powi(power);
            let next = controller.next(1.05, 0.01 * foretold, s, 1, 7);
            // 0.9 · 15/15, and of it what the predictive controller leaves.
            let plain = 1.05 * 0.9 * (held * foretold).powf(-f64::from(power).recip());
            assert!(next <= plain * (1.0 + 1e-14), "{s} stages: {next}, {plain}");
            let again = controller.next(1.05, 1e-9, s, 1, 7);
            assert_eq!(again, 8.0 * 1.05, "{s} stages");
        }
    }

    #[test]
    fn a_first_step_that_is_rejected_is_cut_to_a_tenth_and_a_later_one_by_its_error() {
        let mut controller = Controller::new(0.9);
        assert_eq!(controller.next(1.0, 4.0, 3, 2, 7), 0.1);
        assert!(controller.is_cautious());
        controller.next(0.1, 0.5, 3, 2, 7);
        let again = controller.next(0.1, 4.0, 3, 2, 7);
        // 0.9 · 15/16 · 4^(−1/4) of it.
        approx::assert_relative_eq!(again, 0.1 * 0.9 * (15.0 / 16.0) / 2_f64.sqrt(), max_relative = 1e-14);
        // The step after a rejected one does not grow.
        assert_eq!(controller.next(0.05, 1e-6, 3, 2, 7), 0.05);
        assert!(controller.next(0.05, 1e-6, 3, 2, 7) > 0.05);
    }
}
