//! Whether f is smooth along a solution, as far as its values tell.

use crate::measure::norm::{Extremes, distance, max_norm};
use crate::reference::Ode;

/// Equal parts of the time at whose ends f is looked at.
pub(super) const PARTS: usize = 1 << 10;
/// Highest differences that are taken: roundings hide those above.
const HIGHEST: usize = 4;
/// Part of a difference that roundings may make: of each of two, they change the exponent by log₂((1 + r)/(1 − r)), a half at r = 3 − √8.
const PART: f64 = 0.17;

/// Where f is least smooth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rough {
    /// The time.
    pub(super) t: f64,
    /// The order above which no method shows one: a step across a jump of f leaves an error ∝ h, across a kink one ∝ h².
    pub(super) order: f64,
}

/// Where f along a solution is not as smooth as a method of this order needs. `states` are known to within their bounds at `times`, equally
/// spaced.
///
/// The largest of the pth differences over a distance δ falls like δᵖ where f is smooth, and like δˢ, s < p, about a place where it is not;
/// p of them in succession have a sum that does not depend on where between two times this is.
pub(super) fn roughness(ode: &dyn Ode, times: &[f64], states: &[(Vec<f64>, f64)], order: u32) -> Option<Rough> {
    let rate = |t: f64, v: &[f64]| {
        let mut f = vec![0.0; ode.dim()];
        ode.rhs(t, v, &mut f);
        f
    };
    let rates: Vec<Vec<f64>> = times.iter().zip(states).map(|(t, (v, _))| rate(*t, v)).collect();
    // What the bound of a state leaves open of f there; beside a kink the Jacobian would not tell.
    let open = |k: usize| -> f64 {
        let (mut v, bound) = states[k].clone();
        let aside = (0..v.len()).map(|i| {
            let here = v[i];
            v[i] += bound;
            let moved = distance(&rates[k], &rate(times[k], &v));
            v[i] = here;
            moved
        });
        aside.sum()
    };
    let open = (0..rates.len()).map(open).largest() + f64::EPSILON * rates.iter().map(|f| max_norm(f)).largest();
    let coarse: Vec<Vec<f64>> = rates.iter().step_by(2).cloned().collect();
    let mut before = 0.0;
    for p in 1..=HIGHEST.min(order as usize) {
        let ((wide, _), (narrow, place)) = (largest(&coarse, p)?, largest(&rates, p)?);
        let roundings = open * (p as f64) * (p as f64).exp2();
        let exponent = (wide / narrow).log2();
        // NaN tells nothing, nor does what lower differences contradict.
        if !(roundings <= PART * narrow && exponent >= before - 0.5) {
            return None;
        }
        if exponent < p as f64 - 0.5 {
            return Some(Rough { t: 0.5 * (times[place] + times[place + 2 * p - 1]), order: 1.0 + exponent });
        }
        before = exponent;
    }
    None
}

/// The largest sum of the sizes of `p` successive pth differences, and where it starts.
fn largest(values: &[Vec<f64>], p: usize) -> Option<(f64, usize)> {
    let mut differences = values.to_vec();
    for _ in 0..p {
        let difference = |pair: &[Vec<f64>]| pair[0].iter().zip(&pair[1]).map(|(a, b)| b - a).collect();
        differences = differences.windows(2).map(difference).collect();
    }
    let sizes: Vec<f64> = differences.iter().map(|difference| max_norm(difference)).collect();
    let sums = sizes.windows(p).enumerate().map(|(place, sizes)| (sizes.iter().sum::<f64>(), place));
    sums.max_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// v̇ = g(t) − v, of which v = 0 is looked at.
    #[derive(Debug)]
    struct Rate(fn(f64) -> f64);

    impl Ode for Rate {
        fn dim(&self) -> usize {
            1
        }
        fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
            dv[0] = (self.0)(t) - v[0];
        }
        fn jacobian(&self, _t: f64, _v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
            add(0, 0, -1.0);
        }
    }

    fn found(g: fn(f64) -> f64, bound: f64, order: u32) -> Option<Rough> {
        let times: Vec<f64> = (0..=PARTS).map(|k| 2.0 * k as f64 / PARTS as f64).collect();
        roughness(&Rate(g), &times, &vec![(vec![0.0], bound); times.len()], order)
    }

    #[test]
    fn a_jump_a_kink_and_a_root_are_found_with_the_order_that_they_leave() {
        type Case = (fn(f64) -> f64, f64, f64);
        let cases: [Case; 5] = [
            (|t| if t < 0.7391 { 1.0 } else { t.cos() }, 0.7391, 1.0),
            (|t| if t < 1.0 { 0.0 } else { 1.0 }, 1.0, 1.0),
            (|t| (t - 0.7391).abs() + t.sin(), 0.7391, 2.0),
            (|t| (t - 0.7391).powi(2).copysign(t - 0.7391), 0.7391, 3.0),
            (|t| t.sqrt() - t, 0.0, 1.5),
        ];
        for (g, t, order) in cases {
            let rough = found(g, 0.0, 5).expect("it is rough");
            assert!((rough.t - t).abs() < 0.01 && (rough.order - order).abs() < 0.1, "{t}, {order}: {rough:?}");
        }
        let jump = found(|t| if t < 0.7391 { 1.0 } else { 0.0 }, 0.0, 1);
        for rough in [jump, found(|t| (t - 0.7391).abs(), 0.0, 2)].map(|rough| rough.expect("it is rough")) {
            assert!(
                (rough.t - 0.7391).abs() <= 0.5 * 2.0 / PARTS as f64,
                "it is told by the times about it: {rough:?}"
            );
        }
    }

    #[test]
    fn what_is_smooth_or_lost_in_roundings_or_smooth_enough_is_not_found() {
        let rounded = |t: f64| 1.0 + f64::EPSILON * (1e3 * t).sin();
        let large = |t: f64| 1e6 * (1.0 + f64::EPSILON * (1e3 * t).sin());
        let sine = |t: f64| (40.0 * t).sin();
        for g in [f64::cos, sine, |t: f64| (-20.0 * t).exp(), |t: f64| t * t, |_| 1.0, rounded, large] {
            assert_eq!([found(g, 0.0, 6), found(g, 1e-9, 6), found(g, 1.0, 6)], [None; 3]);
        }
        let kink = |t: f64| (t - 0.7391).abs();
        assert_eq!([found(kink, 0.0, 1), found(kink, 1.0, 2)], [None; 2]);
        // Its second differences are 2/512, of which eight times the bound may be a sixth.
        assert!(found(kink, 7e-5, 2).is_some() && found(kink, 1e-4, 2).is_none());
        assert_eq!(found(|t| if t < 1.0 { f64::NAN } else { 1.0 }, 0.0, 3), None);
    }
}
