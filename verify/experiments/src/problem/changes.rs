//! When f changes by itself, between the times at which a run would look.

use super::Problem;
use super::rounding::rounding;
use crate::measure::norm::{distance, larger};

/// The part by which a time advances in each of the equal parts of a run over the one before: the golden ratio, to whose multiples no
/// period is near.
pub const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Times at which f is looked at, fewer where their values of f would be more than that.
const SAMPLES: usize = 1 << 15;
const VALUES: usize = 1 << 22;
/// Part of the change of f that few times see of what is smooth.
const SEEN: f64 = 0.5;
/// Shares of the change.
const SHARES: f64 = 256.0;

/// Times of a run to the horizon that share equally what f changes by in time, v as it is at the start; none where `stops` see most of
/// it.
pub fn changes(problem: &dyn Problem, horizon: f64, stops: &[f64]) -> Vec<f64> {
    let field = problem.field();
    let (n, mut v) = (field.dim(), problem.initial());
    let samples = SAMPLES.min(VALUES / n.max(1));
    let is_autonomous = field.is_autonomous() || problem.ode().is_autonomous();
    if is_autonomous || v.len() != n || samples < stops.len() {
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

/// What f is off by where it acts between two states, beside the largest that it is at any of them; and the part of all ways between them on
/// which it may: a course that is off on more of them is one that the states do not resolve.
const ODD: f64 = 1.0;
const FEW: usize = 16;
/// Times what a few roundings of a state make of f, which is nothing that acts.
const ROUNDINGS: f64 = 8.0;

/// Times between those of a course at which f, along the cubic through two states and their rates, is another than the slope of that: it
/// acts for a moment at some place, over which a run may pass as over some time.
pub fn acts_between(problem: &dyn Problem, times: &[f64], states: &[Vec<f64>]) -> Vec<f64> {
    let ode = problem.ode();
    let (n, ways) = (ode.dim(), times.len().saturating_sub(1));
    let samples = SAMPLES.min(VALUES / n.max(1));
    if samples < 2 * ways || states.len() != times.len() || states.iter().any(|state| state.len() != n) {
        return Vec::new();
    }
    // What is linear acts at no place; where a cubic leaves the solution it is the states that do not resolve it.
    if problem.field().is_linear() {
        return Vec::new();
    }
    let f = |t: f64, v: &[f64]| {
        let mut f = vec![0.0; n];
        ode.rhs(t, v, &mut f);
        f
    };
    let rates: Vec<Vec<f64>> = times.iter().zip(states).map(|(t, v)| f(*t, v)).collect();
    let largest: Vec<f64> = (0..n).map(|k| rates.iter().map(|f| f[k].abs()).fold(0.0, larger)).collect();
    let is_odd = |way: usize, s: f64| {
        let h = times[way + 1] - times[way];
        let (v, slope): (Vec<f64>, Vec<f64>) = (0..n)
            .map(|k| {
                let ([a, b], [c, d]) = ([way, way + 1].map(|i| states[i][k]), [way, way + 1].map(|i| rates[i][k]));
                let (line, left, right) = (b - a, h * c - (b - a), h * d - (b - a));
                let v = a + s * line + s * (1.0 - s) * ((1.0 - s) * left - s * right);
                (v, (line + (1.0 - s) * (1.0 - 3.0 * s) * left + s * (3.0 * s - 2.0) * right) / h)
            })
            .unzip();
        let t = times[way] + s * h;
        let f = f(t, &v);
        let mut off =
            (0..n).map(|k| (k, (f[k] - slope[k]).abs())).filter(|(k, off)| *off > ODD * largest[*k]).peekable();
        off.peek().is_some() && {
            let rounded = rounding(|v, f| ode.rhs(t, v, f), &v, n);
            off.any(|(k, off)| off > ROUNDINGS * rounded[k])
        }
    };
    let (mut odd, mut looks) = (0, 0);
    let mut found = Vec::new();
    let span = times.last().zip(times.first()).map_or(0.0, |(last, first)| last - first);
    for way in 0..ways {
        // As many as it is long.
        let parts = (samples as f64 * (times[way + 1] - times[way]) / span) as usize;
        // Where in its part is irregular, as above.
        let places = (0..parts).map(|k| (k as f64 + ((looks + k) as f64 * GOLDEN).fract()) / parts as f64);
        let places: Vec<f64> = places.filter(|s| is_odd(way, *s)).collect();
        looks += parts;
        odd += usize::from(!places.is_empty());
        let ends = places.first().into_iter().chain(places.last());
        found.extend(ends.map(|s| times[way] + s * (times[way + 1] - times[way])));
    }
    found.dedup();
    // Of few ways one is not too many.
    if odd * FEW > ways.max(FEW) { Vec::new() } else { found }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::model::Model;

    fn model(f: &str) -> Model {
        Model::of_text(&format!("u_i {{ x = 1, y = 0 }} F_i {{ {f} }}"), &[], Some(4.0)).expect("a model")
    }

    #[test]
    fn a_run_is_to_stop_on_both_sides_of_a_jump() {
        let found = changes(&model("heaviside(t - 1.2345) - x, 0"), 4.0, &[4.0]);
        let apart = 2.0 * 4.0 / SAMPLES as f64;
        assert!(
            matches!(found[..], [before, behind] if before < 1.2345 && behind >= 1.2345 && behind - before <= apart),
            "{found:?}"
        );
    }

    /// A clock that comes by a place in the time of two steps, of few or of many.
    #[test]
    fn what_acts_between_two_of_few_states_is_found() {
        let pulse = model("1, heaviside(x - 1.2345)*heaviside(1.2355 - x)*100");
        for ways in [4_u32, 64] {
            let times: Vec<f64> = (0..=ways).map(|k| 3.0 * (f64::from(k) / f64::from(ways)).powi(2)).collect();
            let states: Vec<Vec<f64>> = times.iter().map(|t| vec![1.0 + t, 0.0]).collect();
            let found = acts_between(&pulse, &times, &states);
            let is_there = |t: &f64| (0.2345..=0.2355).contains(t);
            assert!(found.len() == 2 && found.iter().all(is_there), "{ways}: {found:?}");
        }
    }

    /// A rotation from few states: its cubics turn as it does, and meet x = 0.6 where cos t is that.
    #[test]
    fn a_course_that_turns_between_its_states_acts_nowhere() {
        let pulse = model("y, -x + 40*heaviside(1e-3 - abs(x - 0.6))");
        for ways in [4_u32, 16] {
            let times: Vec<f64> = (0..=ways).map(|k| 4.0 * f64::from(k) / f64::from(ways)).collect();
            let states: Vec<Vec<f64>> = times.iter().map(|t| vec![t.cos(), -t.sin()]).collect();
            let found = acts_between(&pulse, &times, &states);
            // A cubic of 1 from h = 1 is off by h⁴/384.
            let is_there = |t: &f64| (t - 0.6_f64.acos()).abs() < 0.01;
            assert!(!found.is_empty() && found.iter().all(is_there), "{ways}: {found:?}");
        }
    }

    /// A fast rotation that decays, from states that do not resolve it, is linear.
    #[test]
    fn what_is_linear_acts_nowhere() {
        let decaying = model("-1000*x + 800*y, -800*x - 1000*y");
        let times: Vec<f64> = (0..=30).map(|k| 0.1 * f64::from(k)).collect();
        let states: Vec<Vec<f64>> = (0..=30).map(|k| vec![0.01_f64.powi(k), 0.0]).collect();
        assert_eq!(acts_between(&decaying, &times, &states), [0.0; 0]);
    }

    /// What multiplies a component that starts at zero is looked at beside zero.
    #[test]
    fn a_change_that_a_zero_hides_is_seen() {
        let found = changes(&model("0, 1000*y*heaviside(t - 1.2345)*heaviside(1.2355 - t)"), 4.0, &[4.0]);
        assert!(found.iter().any(|t| (1.2345..=1.2355).contains(t)), "{found:?}");
    }
}
