//! What solvers that choose their steps may pass over, within bounds that do not know: f that acts for a moment.

use super::run_through;
use crate::measure::decimal::significant;
use crate::measure::norm::{distance, max_norm};
use crate::method;
use crate::problem::Problem;
use crate::problem::changes::{acts_between, changes};

/// Parts of a run at whose ends it stops.
const STEPS: usize = 1024;

/// Unknowns of a system up to which its f is looked at.
const LARGE: usize = 200;

/// Part of the solution that two runs differ by where one has passed over something.
const RESOLVED: f64 = 1e-2;

/// When f acts for a moment, by itself or at some place that the solution comes by, between the states of a run to the horizon, where a run
/// that stops there too is another one. `None` where it is not, where a run fails, and of systems whose f is not looked at.
#[must_use]
pub fn passed_over(problem: &dyn Problem, horizon: f64) -> Option<String> {
    if problem.field().dim() > LARGE {
        return None;
    }
    let times: Vec<f64> = (0..=STEPS).map(|step| horizon * step as f64 / STEPS as f64).collect();
    let method = method::parse("radau-adaptive").ok()?;
    let states = run_through(problem, &*method, &times[1..]).ok()?;
    // On the way between states of a stiff system f is another too, and nothing comes of it.
    let parts_by = |moments: &[f64]| {
        let mut stops = [moments, &times[1..]].concat();
        stops.sort_by(f64::total_cmp);
        stops.dedup();
        let Ok(anew) = run_through(problem, &*method, &stops) else { return false };
        let at_times = stops.iter().zip(anew).filter(|(t, _)| times[1..].contains(t)).map(|(_, state)| state);
        states.iter().zip(at_times).any(|(a, b)| distance(a, &b) > RESOLVED * max_norm(a))
    };
    let told = |moments: Vec<f64>, what: &str| {
        let (first, last) = (*moments.first()?, *moments.last()?);
        parts_by(&moments).then(|| {
            format!(
                "from t = {} to t = {} f {what}, and solvers that choose their steps may pass over it, within bounds that do not know",
                significant(first, 5),
                significant(last, 5)
            )
        })
    };
    let course = [&[problem.initial()], &states[..]].concat();
    told(changes(problem, horizon, &times[1..]), "changes by itself for a moment").or_else(|| {
        let acts = acts_between(problem, &times, &course);
        told(acts, "acts for a moment, where the solution comes by some place")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::model::Model;

    /// A dose of 100 so short that every solver passes over it, and one that none does.
    #[test]
    fn a_moment_is_passed_over_where_it_is_short() {
        let model = |f: &str| Model::of_text(&format!("u_i {{ c = 1 }} F_i {{ {f} }}"), &[], None).expect("a model");
        for (width, is_short) in [(1e-5, true), (1e-4, true), (1.0, false)] {
            let dose = model(&format!("100 / {width} * exp(-pow((t - 5.0371) / {width}, 2)) - 0.4 * c"));
            let told = passed_over(&dose, 10.0);
            assert_eq!(told.is_some(), is_short, "{width}: {told:?}");
            assert!(told.is_none_or(|text| text.starts_with("from t = 5.03") && text.contains("by itself")));
        }
        // A jump that steps are shortened at is passed over by none.
        assert_eq!(passed_over(&model("heaviside(t - 5.0371) - 0.4 * c"), 10.0), None);
    }
}
