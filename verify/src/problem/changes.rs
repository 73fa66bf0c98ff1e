//! When f changes by itself, between the times at which a run would look.

use super::Problem;
use crate::measure::norm::distance;

/// The part by which a time advances in each of the equal parts of a run over the one before: the golden ratio, to whose multiples no
/// period is near.
pub(crate) const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Times at which f is looked at, fewer where their values of f would be more than that.
const SAMPLES: usize = 1 << 15;
const VALUES: usize = 1 << 22;
/// Part of the change of f that few times see of what is smooth.
const SEEN: f64 = 0.5;
/// Shares of the change.
const SHARES: f64 = 256.0;

/// Times of a run to the horizon that share equally what f changes by in time, v as it is at the start; none where `stops` see most of
/// it.
pub(crate) fn changes(problem: &dyn Problem, horizon: f64, stops: &[f64]) -> Vec<f64> {
    let field = problem.field();
    let (n, mut v) = (field.dim(), problem.initial());
    let samples = SAMPLES.min(VALUES / n.max(1));
    if field.is_autonomous() || v.len() != n || samples < stops.len() {
        return Vec::new();
    }
    // What multiplies 0 is not seen.
    v.iter_mut().for_each(|v| *v += 1e-3 * v.abs().max(1.0));
    // Where in its part is irregular, lest what is periodic shows one phase only.
    let time = |k: usize| horizon * (k as f64 + (k as f64 * GOLDEN).fract()) / samples as f64;
    // What is not finite is no change that can be shared.
    let steps = |times: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
        let mut before: Option<Vec<f64>> = None;
        let steps = times.map(|t| {
            let mut f = vec![0.0; n];
            field.rhs(t, &v, &mut f);
            let step = before.as_ref().map_or(0.0, |before| distance(before, &f));
            before = Some(f);
            if step.is_finite() { step } else { 0.0 }
        });
        steps.collect()
    };
    let change = steps(&mut (0..samples).map(time));
    let seen: f64 = steps(&mut stops.iter().copied()).into_iter().sum();
    let total: f64 = change.iter().sum();
    if total == 0.0 || seen >= SEEN * total {
        return Vec::new();
    }
    let (mut sum, mut times) = (0.0, Vec::new());
    for (k, step) in change.into_iter().enumerate().skip(1) {
        let share = |sum: f64| (sum / total * SHARES).floor();
        if share(sum + step) > share(sum) {
            // Both sides of a jump.
            times.extend([time(k - 1), time(k)]);
        }
        sum += step;
    }
    times.dedup();
    // The start is no time to stop at.
    times.retain(|t| *t > 0.0);
    times
}
