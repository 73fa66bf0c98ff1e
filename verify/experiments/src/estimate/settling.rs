//! Whether the order that an estimate is taken with shows at its step.

use crate::measure::norm::{distance, max_norm};
use crate::method::{Method, roundoff};
use crate::problem::Problem;
use crate::run::run;

/// Orders above the expected one that are its own: errors that fall by the term of the next order alone do so by one more, and a little more by those behind
/// it. Those that fall faster are two terms that cancel.
const NEXT: f64 = 1.25;

/// The order by which runs with steps of 2h, h and h/2 differ at the end, beside the one that the estimate is taken with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settling {
    /// `None` where the run with 2h fails.
    pub observed: Option<f64>,
    /// What the estimate takes it for.
    pub order: f64,
}

impl Settling {
    /// Of a run with steps of `h` to `t_end` that comes to the first of two ends, and with half of the steps to the second; `None` where their
    /// difference is that of roundings, of which there is no order.
    pub(super) fn of(
        problem: &dyn Problem,
        method: &dyn Method,
        [h, t_end]: [f64; 2],
        [end, finer]: [&[f64]; 2],
        order: f64,
    ) -> Option<Self> {
        let difference = distance(end, finer);
        if difference <= roundoff(method, max_norm(end), 2.0 * (t_end / h).ceil()) {
            return None;
        }
        let coarser = run(problem, method, 2.0 * h, t_end, |_| {}).ok();
        let observed = coarser.map(|coarser| (distance(&coarser.end.q, end) / difference).log2());
        Some(Self { observed, order })
    }

    /// Whether an estimate that takes errors to fall by order p is within a factor of two of what they are if they fall by the observed order q: it is
    /// (1 − 2^−q)/(1 − 2^−p) of them, at most 1/(1 − 2^−p) ≤ 2 for p ≥ 1.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        let part = |order: f64| 1.0 - (-order).exp2();
        self.observed.is_some_and(|q| part(q) >= 0.5 * part(self.order) && q <= self.order + NEXT)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Estimator;
    use super::*;
    use crate::{method, problem};

    fn settling(problem: &str, method: &str, [h, t_end]: [f64; 2]) -> Option<Settling> {
        let (problem, method) = (problem::build(problem, &[]).expect("known"), method::parse(method).expect("known"));
        let mut estimator = Estimator::new(&*problem, &*method, h, t_end).expect("applies");
        let end = run(&*problem, &*method, h, t_end, |_| {}).expect("it runs").end;
        estimator.at(t_end);
        let early = lsvi::State { t: 0.5 * t_end, ..end.clone() };
        assert_eq!(estimator.settling(&*problem, &*method, &early), None, "it has not ended");
        let rounded = lsvi::State { t: t_end.next_down(), ..end.clone() };
        let [found, beside] = [&end, &rounded].map(|end| estimator.settling(&*problem, &*method, end));
        assert_eq!(found, beside, "a rounding of the end is none");
        found
    }

    #[test]
    fn an_order_shows_at_short_steps_and_not_at_long_ones() {
        let short = settling("linear-drag", "implicit-euler", [0.01, 1.0]).expect("it differs");
        assert!((short.observed.expect("it runs") - 1.0).abs() < 0.02 && short.order == 1.0 && short.is_settled());
        assert!(settling("harmonic-oscillator", "rk4", [0.2, 200.0]).expect("it differs").is_settled());
        // With 2h = 5 it grows: R(−5) = 13.7.
        assert!(!settling("linear-drag", "rk4", [2.5, 10.0]).expect("it differs").is_settled());
        // A single step is its own run with twice of it.
        assert!(!settling("linear-drag", "method-i", [1.0, 1.0]).expect("it differs").is_settled());
        // 2h = 1.2 is beyond the fold of Method II, at 1.
        let beyond = settling("quadratic-drag", "method-ii", [0.6, 3.0]).expect("it differs");
        assert!(beyond.observed.is_none() && !beyond.is_settled());
    }

    #[test]
    fn roundings_and_chosen_steps_have_no_order() {
        assert_eq!(settling("linear-drag", "rk4", [1e-4, 0.1]), None);
        assert_eq!(settling("linear-drag", "radau-adaptive", [1.0, 1.0]), None);
    }

    #[test]
    fn an_order_is_settled_whose_estimate_is_half_of_the_error_at_least() {
        let is_settled = |observed| Settling { observed, order: 2.0 }.is_settled();
        // 1 − 2^−0.678 is three eighths.
        assert_eq!([0.679, 2.0, 3.25].map(|order| is_settled(Some(order))), [true; 3]);
        assert_eq!([Some(0.678), Some(3.26), Some(f64::NAN), Some(f64::INFINITY), None].map(is_settled), [false; 5]);
    }
}
