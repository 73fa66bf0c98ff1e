use std::f64::consts::TAU;

use rayon::prelude::*;

use super::*;
use lsvi::State;

use crate::measure::norm::{distance, larger};
use crate::problem;
use crate::theory::methods_for;

/// Against every method that suits, on every problem that methods are paired with.
#[test]
fn what_is_advised_takes_at_most_twice_the_work_of_the_cheapest() {
    let refusals = problem::paired().collect::<Vec<_>>().into_par_iter().filter_map(|spec| {
        let problem = problem::small(spec.name).expect("registered");
        let advice = advise(&*problem, problem.horizon(), 1e-4).expect("registered");
        let Some(taken) = advice.recommended() else { return Some((spec.name, advice.refusal)) };
        let all = try_out(&*problem, problem.horizon(), 1e-4, &methods_for(&*problem));
        let all = all.expect("registered").expect("followed").trials;
        let least = &all[0];
        assert!(taken.cost <= 2.0 * least.cost, "{}: {taken:?}, where {least:?}", spec.name);
        None
    });
    let refusals: Vec<_> = refusals.collect();
    assert!(3 * refusals.len() <= problem::paired().count(), "{refusals:?}");
}

/// What a run of the advised method does again, by the exact solution.
#[test]
fn the_error_that_is_predicted_is_the_true_one() {
    let mut with_steps = 0;
    for name in ["logistic", "quadratic-drag", "prothero-robinson", "harmonic-oscillator"] {
        let problem = problem::small(name).expect("registered");
        let horizon = problem.horizon();
        let advice = advise(&*problem, horizon, 1e-5).expect("registered");
        let taken = advice.trials.first().expect("a trial");
        let method = method::parse(&taken.method).expect("registered");
        let method = if method.traits().is_adaptive { adaptive(taken.setting).expect("registered") } else { method };
        let h = if method.traits().is_adaptive { horizon } else { taken.setting };
        let end = crate::run::run(&*problem, &*method, h, horizon, |_| {}).expect("it ran before").end.q;
        if !method.traits().is_adaptive {
            with_steps += 1;
            let sixteenth = |state: &State| (16.0 * state.t / horizon).fract() == 0.0 && state.t > 0.0;
            let mut errors = Vec::new();
            crate::run::run(&*problem, &*method, h, horizon, |state| {
                let exact = problem.exact(state.t).expect("it is known");
                errors.extend(sixteenth(state).then(|| distance(&state.q[..exact.len()], &exact)));
            })
            .expect("it ran before");
            let off = (taken.error - errors.iter().copied().fold(0.0, larger)).abs();
            assert!(errors.len() == taken.times && off <= advice.uncertainty + 1e-8, "{name}: {errors:?}, {taken:?}");
        }
        let exact = problem.exact(horizon).expect("it is known");
        let error = crate::measure::norm::distance(&end[..exact.len()], &exact);
        assert!(error <= taken.error + advice.uncertainty + 1e-8, "{name}: {error:e}, {taken:?}");
    }
    assert!(with_steps >= 2, "rk4 and the trapezoidal rule are the cheapest on some of these");
}

/// Two periods of a motion that comes round; what grows to a rest, or ends, has none.
#[test]
fn a_run_is_as_long_as_two_turns_of_the_motion() {
    let of = |text: &str| {
        let problem = problem::build_setting(text).expect("registered");
        (duration(&*problem).expect("registered"), problem.horizon())
    };
    for (text, period) in
        [("harmonic-oscillator omega=1", TAU), ("harmonic-oscillator omega=0.3", TAU / 0.3), ("kepler", TAU)]
    {
        let (found, _) = of(text);
        // The last step, and the rounding to two digits.
        assert!((1.9 * period..2.4 * period).contains(&found), "{text}: {found}");
    }
    for text in [
        "logistic",
        "quadratic-drag v0=-1",
        "quadratic-drag v0=0",
        "robertson",
        "channel-couette cells=8",
        "linear-drag",
        "harmonic-oscillator omega=20",
    ] {
        let (found, own) = of(text);
        assert_eq!(found, own, "{text}");
    }
}

/// Robertson's transient is over before the first quarter, and seen from eight steps on: the error of four and that of eight steps
/// belong to different times, and give no order.
#[test]
fn an_order_is_that_of_errors_at_the_same_times() {
    let problem = problem::small("robertson").expect("registered");
    let advice = advise(&*problem, problem.horizon(), 1e-5).expect("registered");
    assert!(!matches!(advice.refusal, Some(Refusal::NotSmooth { .. })), "{:?}", advice.refusal);
}

#[test]
fn what_cannot_be_told_is_not_advised() {
    // A solution that ends before the horizon.
    let ends = problem::build_setting("quadratic-drag v0=-1").expect("registered");
    assert!(matches!(advise(&*ends, 2.0, 1e-5).expect("registered").refusal, Some(Refusal::Lost(_))));
    // One that stays where it is.
    let rests = problem::build_setting("quadratic-drag v0=0").expect("registered");
    assert!(matches!(advise(&*rests, 2.0, 1e-5).expect("registered").refusal, Some(Refusal::Constant)));
    let falls = |found| Trial {
        method: "rk4".into(),
        setting: 0.1,
        steps: 10,
        error: 1e-6,
        times: 16,
        cost: 40.0,
        order: Some((found, 4)),
    };
    assert_eq!(falls(3.4).unpredictable(), Some((3.4, 4)));
    assert!(falls(f64::NAN).unpredictable().is_some() && falls(3.6).unpredictable().is_none());
}

/// Matrices of systems whose properties are known.
#[test]
fn the_character_of_a_system_is_told_by_its_matrices() {
    let of = |text: &str| {
        let problem = problem::build_setting(text).expect("registered");
        Character::of(&*problem, &*adaptive(1e-6).expect("registered"), problem.horizon()).matrices.expect("small")
    };
    let channel = of("channel-couette cells=8");
    assert!(channel.is_symmetric() && channel.is_dissipative() && channel.invariants == 0 && !channel.is_hamiltonian);
    let kepler = of("kepler");
    assert!(kepler.is_hamiltonian && !kepler.is_symmetric() && !kepler.is_dissipative());
    let robertson = of("robertson");
    assert!(robertson.invariants == 1 && robertson.fastest > 1e3);
    assert!(of("non-normal").is_non_normal());
}
