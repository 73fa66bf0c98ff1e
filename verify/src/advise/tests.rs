use std::f64::consts::TAU;

use super::*;
use lsvi::{StepError, Work};

use crate::measure::norm::{common_distance, distance, larger};
use crate::problem::changes::changes;
use crate::problem::{self, model::Model};

/// What a run of the advised method does again, by the exact solution.
#[test]
fn the_error_that_is_predicted_is_the_true_one() {
    let mut with_steps = 0;
    for name in ["logistic", "quadratic-drag", "prothero-robinson", "harmonic-oscillator"] {
        let problem = problem::small(name).expect("registered");
        let horizon = problem.horizon();
        let advice = advise(&*problem, horizon, 1e-5, &mut |_| {}).expect("registered");
        let taken = advice.trials.first().expect("a trial");
        let method = taken.built().expect("registered");
        let h = if method.traits().is_adaptive { horizon } else { taken.setting };
        let end = crate::run::run(&*problem, &*method, h, horizon, |_| {}).expect("it ran before").end.q;
        if !method.traits().is_adaptive {
            with_steps += 1;
            let mut errors = Vec::new();
            crate::run::run(&*problem, &*method, h, horizon, |state| {
                let exact = problem.exact(state.t).expect("it is known");
                errors.push(distance(&state.q[..exact.len()], &exact));
            })
            .expect("it ran before");
            let error = errors.into_iter().fold(0.0, larger);
            let off = (taken.error - error).abs();
            assert!(off <= advice.uncertainty + 1e-8, "{name}: {error:e}, {taken:?}");
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

/// A hundred oscillators turn twice in 4π, and of more the run is not followed. e^(−t) is a thousandth at 6.9, when the angle 1.5 t has not
/// come to 4π.
#[test]
fn a_motion_that_comes_to_rest_or_is_too_large_has_its_own_horizon() {
    let oscillators = |count: usize| {
        let list = |of: fn(usize) -> String| (0..count).map(of).collect::<Vec<_>>().join(", ");
        let (start, field) = (list(|k| format!("x{k} = 1, y{k} = 0")), list(|k| format!("-y{k}, x{k}")));
        duration(&of_text(&format!("u_i {{ {start} }} F_i {{ {field} }}"), 1.0)).expect("registered")
    };
    assert!((13.0..15.0).contains(&oscillators(100)), "{}", oscillators(100));
    assert_eq!(oscillators(101), 1.0);
    let spiral = "u_i { x = 1000, y = 0 } F_i { -x - 1.5*y, 1.5*x - y }";
    assert_eq!(duration(&of_text(spiral, 1.0)).expect("registered"), 1.0);
}

/// A slope between ±1/500 turns by 4/500 in a period, so that 1571 of these make two turns, and a period takes more steps than three.
#[test]
fn a_motion_that_turns_too_slowly_for_the_steps_that_are_followed_has_its_own_horizon() {
    let of = |slope: f64, own: f64| {
        let text = format!("u_i {{ x = 0, y = 0 }} F_i {{ 1, {slope}*cos(0.05*t) }}");
        duration(&of_text(&text, own)).expect("registered")
    };
    assert_eq!(of(0.002, 3e4), 3e4);
    // A slope of 1/50 does in 157 periods, and in fewer than twice as many where steps do not end at its extremes.
    let (found, expected) = (of(0.02, 1e3), 157.0 * TAU / 0.05);
    assert!((expected..2.0 * expected).contains(&found), "{found} where {expected} is expected");
}

/// ẋ = x from 1.
#[test]
fn the_size_of_a_solution_is_the_largest_of_the_whole_run() {
    let problem = problem::build("linear-drag", &[("lambda".into(), "-1".into())]).expect("registered");
    let found = size(&*problem, 2.0, 1e-5).expect("registered").expect("it goes on");
    let start = problem.initial()[0].abs();
    assert!((found / (start * 2_f64.exp()) - 1.0).abs() < 1e-3, "{found}");
}

/// Robertson's transient is over before the first quarter, and seen from eight steps on: the error of four and that of eight steps
/// belong to different times, and give no order.
#[test]
fn an_order_is_that_of_errors_at_the_same_times() {
    let problem = problem::small("robertson").expect("registered");
    let advice = advise(&*problem, problem.horizon(), 1e-5, &mut |_| {}).expect("registered");
    assert!(!matches!(advice.refusal, Some(Refusal::NotSmooth { .. })), "{:?}", advice.refusal);
}

#[test]
fn what_cannot_be_told_is_not_advised() {
    // A solution that ends before the horizon.
    let ends = problem::build_setting("quadratic-drag v0=-1").expect("registered");
    assert!(matches!(advise(&*ends, 2.0, 1e-5, &mut |_| {}).expect("registered").refusal, Some(Refusal::Lost(_))));
    // One that stays where it is.
    let rests = problem::build_setting("quadratic-drag v0=0").expect("registered");
    assert!(matches!(
        advise(&*rests, 2.0, 1e-5, &mut |_| {}).expect("registered").refusal,
        Some(Refusal::Constant { .. })
    ));
    let falls = |found| trial("rk4", 40.0, [found, 1e-7]);
    // 2^3.5 = 11.3; to within 10⁻⁸, (11 + 0.1)/(1 − 0.1) is more.
    let unpredictable = |found: f64, uncertainty: f64| falls(found * 1e-7).unpredictable(uncertainty).is_some();
    assert!(unpredictable(11.0, 0.0) && unpredictable(f64::NAN, 0.0) && !unpredictable(12.0, 0.0));
    assert!(!unpredictable(11.0, 1e-8) && unpredictable(9.0, 1e-8) && !unpredictable(2.0, 1e-7));
}

/// Matrices of systems whose properties are known.
#[test]
fn the_character_of_a_system_is_told_by_its_matrices() {
    let of = |text: &str| {
        let problem = problem::build_setting(text).expect("registered");
        along(&*problem, problem.horizon()).matrices.expect("small")
    };
    let channel = of("channel-couette cells=8");
    assert!(channel.is_symmetric() && channel.is_contractive() && channel.invariants == 0 && !channel.is_hamiltonian);
    // With a mass matrix, in the metric of which the system is symmetric and in no other.
    let elements = of("channel-couette cells=8 scheme=legendre");
    assert!(elements.is_symmetric() && elements.is_contractive());
    let kepler = of("kepler");
    assert!(kepler.is_hamiltonian && !kepler.is_symmetric() && !kepler.is_contractive());
    let robertson = of("robertson");
    assert!(robertson.invariants == 1 && robertson.fastest > 1e3);
    assert!(of("non-normal").is_non_normal());
    // Momenta after coordinates, or each after its own; a sign spoils both.
    let model = |rates: &str| {
        let problem = of_text(&format!("u_i {{ a = 1, b = 0, c = 1, d = 0 }} F_i {{ {rates} }}"), 1.0);
        along(&problem, 1.0).matrices.expect("small").is_hamiltonian
    };
    assert!(model("b, -a, 9*d, -9*c") && model("c, 9*d, -a, -9*b") && !model("b, -a, 9*d, 8*c + d"));
}

/// With steps of 16/N days errors of a daily cycle are as large as at any step, whether they are small at whole days or not.
#[test]
fn errors_of_a_period_are_not_measured_at_one_phase() {
    for rate in ["-0.05*x + 3*cos(6.283185307179586*t)", "3*cos(6.283185307179586*t)"] {
        let problem = of_text(&format!("u_i {{ x = 1 }} F_i {{ {rate} }}"), 16.0);
        let advice = advise(&problem, 16.0, 1e-5, &mut |_| {}).expect("registered");
        assert!(!matches!(advice.refusal, Some(Refusal::Constant { .. })), "{rate}: {:?}", advice.refusal);
        let accurate = adaptive(1e-11).expect("registered");
        let fixed = advice.trials.iter().filter(|trial| trial.method != ADAPTIVE);
        for trial in fixed {
            let method = method::parse(&trial.method).expect("registered");
            let mut ends = Vec::new();
            crate::run::run(&problem, &*method, trial.setting, 16.0, |state| ends.push((state.t, state.q.clone())))
                .expect("it ran before");
            let times: Vec<f64> = ends[1..].iter().map(|(t, _)| *t).collect();
            let truth = crate::run::run_through(&problem, &*accurate, &times).expect("followed");
            let all = ends[1..].iter().zip(&truth).map(|((_, state), truth)| distance(state, truth)).fold(0.0, larger);
            // Of 64 irregular phases one is within 1/64 of a turn from the largest, where a cosine is above 0.995, but it may be a
            // day later than the largest, and what is left of a start falls by 5 % in it.
            assert!(all * 0.94 <= trial.error && trial.error <= all * 1.01 + 1e-9, "{rate}: {all:e}, {trial:?}");
        }
    }
}

#[test]
fn chosen_steps_are_all_or_one_in_each_part_and_the_last() {
    for count in [1, 4, trial::TIMES] {
        assert_eq!(trial::chosen(count, trial::TIMES), (1..=count).collect::<Vec<_>>());
    }
    for count in [65, 100, 1024, 16384] {
        let chosen = trial::chosen(count, trial::TIMES);
        assert!(
            chosen.windows(2).all(|pair| pair[0] < pair[1]) && chosen.last() == Some(&count),
            "{count}: {chosen:?}"
        );
        let in_part = |part: usize| chosen.iter().any(|step| (step * trial::TIMES).div_ceil(count) - 1 == part);
        // A step may end after its part where a part has few.
        assert!(count < 1000 || (0..trial::TIMES).all(in_part), "{count}: {chosen:?}");
    }
}

/// By its principle, by what it is stable on, by the equation that it approaches, by its cost, and by whether there is a step.
#[test]
fn methods_suit_that_say_something_of_the_problem_at_a_cost_that_is_worth_it() {
    for (problem, method, is_suited) in [
        ("linear-drag", "method-i", true),
        ("linear-drag", "method-ii", false),
        ("circle", "kong-yang-circle", false),
        ("poiseuille-ansatz", "method-i", false),
        ("channel-couette cells=32", "method-i", true),
        ("channel-couette cells=32", "ls-galerkin(3,radau,3)", false),
        ("linear-drag", "stormer-verlet", false),
    ] {
        let problem_of = problem::build_setting(problem).expect("registered");
        let method_of = method::parse(method).expect("registered");
        assert_eq!(suits(&*problem_of, &*method_of), is_suited, "{method} on {problem}");
    }
}

/// v = 10⁻⁹e^{−t}: the absolute tolerance is in the unit of the solution.
#[test]
fn tolerances_are_held_in_a_unit() {
    let problem = problem::build_setting("linear-drag v0=1e-9").expect("registered");
    let method = Held::to(1.0).in_unit(1e-9).method(0.0).expect("registered");
    let end = crate::run::run(&*problem, &*method, 8.0, 8.0, |_| {}).expect("it runs").end.q[0];
    assert!((end / (1e-9 * (-8.0_f64).exp()) - 1.0).abs() < 1e-2, "{end:e}");
}

fn of_text(code: &str, horizon: f64) -> Model {
    Model::of_text(code, &[], Some(horizon)).expect("a model")
}

/// A run that is made again has the steps of the trial, and between them and the times nothing is repaired.
#[test]
fn the_error_of_an_adaptive_method_is_that_of_its_own_steps() {
    let model = "in_i { a = 1, b = 3 } u_i { x = 1, y = 1 } F_i { a + x*x*y - (b+1)*x, b*x - x*x*y }";
    let problem = of_text(model, 20.0);
    let advice = advise(&problem, 20.0, 1e-5, &mut |_| {}).expect("registered");
    let taken = advice.trials.iter().find(|trial| trial.method == ADAPTIVE).expect("it reaches the accuracy");
    let (method, accurate) = (taken.built().expect("registered"), adaptive(1e-12).expect("registered"));
    let mut ends = Vec::new();
    crate::run::run(&problem, &*method, 20.0, 20.0, |state| ends.push((state.t, state.q.clone())))
        .expect("it ran before");
    let passed = &ends[1..];
    let times: Vec<f64> = passed.iter().map(|(t, _)| *t).collect();
    let truth = crate::run::run_through(&problem, &*accurate, &times).expect("it ran before");
    let errors = passed.iter().zip(&truth).map(|((_, state), truth)| distance(state, truth));
    let error = errors.fold(0.0, larger);
    assert!((error - taken.error).abs() <= 0.1 * taken.error, "{error}: {taken:?}");
    assert!(taken.error <= advice.target);
}

/// A mass between two springs that it does not touch at rest: f has a kink where it comes to one of them, and estimates that are not strict
/// leave errors of hundreds of tolerances there.
#[test]
fn what_strict_estimates_alone_reach_is_advised_with_them() {
    let model = "u_i { x = 1, v = 0 } F_i { v, -10 * (max(x - 0.5, 0) - max(-x - 0.5, 0)) - 0.1 * v }";
    let problem = of_text(model, 20.0);
    let advice = advise(&problem, 20.0, 1e-6, &mut |_| {}).expect("registered");
    let taken = advice.recommended().unwrap_or_else(|| panic!("{:?}", advice.refusal));
    assert!(taken.method == ADAPTIVE && taken.is_strict, "{taken:?}");
    let accurate = adaptive_within((1e-13, &[1e-13]), true).expect("registered");
    let error = largest_error_by(&*accurate, &problem, 20.0, taken);
    assert!(error <= advice.target && (error - taken.error).abs() <= advice.uncertainty, "{error:e}: {taken:?}");
}

/// A wheel that a coil pushes while it passes through 10⁻³ rad: with v dv = (F − 0.05 v) dx its speed falls by 0.05 of a way, its square grows by
/// 2 F w at the coil, and t is −20 ln of what is left of a speed.
#[test]
fn what_acts_at_a_place_is_not_passed_over() {
    let model = "u_i { x = 0, v = 1 } w { 1e-3 }
        F_i { v, -0.05*v + 4000*heaviside(x - 2.2)*heaviside(2.2 + w - x) }";
    let problem = of_text(model, 10.0);
    let advice = advise(&problem, 10.0, 1e-5, &mut |_| {}).expect("registered");
    let taken = advice.recommended().unwrap_or_else(|| panic!("{:?}", advice.refusal));
    let (kick, friction): (f64, f64) = (2.0 * 4000.0 * 1e-3, 0.05);
    let before = 1.0 - friction * 2.2;
    let behind = (before.powi(2) + kick).sqrt();
    let left = 10.0 + before.ln() / friction;
    let x = 2.2 + behind / friction * (1.0 - (-friction * left).exp());
    let h = if taken.atol.is_some() { taken.longest.unwrap_or(10.0) } else { taken.setting };
    let run = crate::run::run(&problem, &*taken.built().expect("registered"), h, 10.0, |_| {}).expect("it ran before");
    assert!((run.end.q[0] - x).abs() <= 0.01 * x, "{} for {x}: {taken:?}", run.end.q[0]);
}

#[test]
fn solutions_that_approach_each_other_are_not_said_to_part() {
    let model = "u_i { x = 1 } F_i { heaviside(1.0 - t*1.37) - 0.5*x }";
    let problem = of_text(model, 2.0);
    let Growth::By(factor) = advise(&problem, 2.0, 1e-4, &mut |_| {}).expect("registered").character.growth else {
        panic!("it is told")
    };
    // At the first sixteenth e^{-1/16}.
    assert!((factor - (-0.0625_f64).exp()).abs() <= 0.01, "{factor}");
}

fn along(problem: &dyn Problem, horizon: f64) -> Character {
    Character::of(problem, &*adaptive(1e-10).expect("registered"), horizon, 1.0)
}

fn character(text: &str, horizon: f64) -> Character {
    along(&of_text(text, horizon), horizon)
}

/// What one run sees and another passes over, or has come to the size of the solution, is not proportional to the disturbance; and the
/// end of a solution is no growth.
#[test]
fn a_growth_is_told_where_it_is_that_of_the_equation() {
    let infusion = "u_i { x = 0 } F_i { -x + 40*heaviside(sin(0.7853981633974483*(t - 0.3)) - 0.995) }";
    let found = character(infusion, 20.0).growth;
    assert!(!matches!(found, Growth::By(factor) if factor > 1.0), "{found:?}");
    let Growth::By(factor) = character("u_i { x = 1 } F_i { x }", 8.0).growth else { panic!("it is told") };
    assert!((factor / 8.0_f64.exp() - 1.0).abs() <= 1e-3, "{factor}");
    // Between two pulses, from t = 3.14 to 3.16, by the exponential of the area of the first.
    let pulse = |t: f64| format!("exp(-(t - {t})*(t - {t})/(2*0.001*0.001))");
    let moment = format!("u_i {{ x = 1 }} F_i {{ (1000*({} - {}) - 0.1)*x }}", pulse(3.137), pulse(3.157));
    let Growth::By(factor) = character(&moment, 10.0).growth else { panic!("it is told") };
    let expected = (TAU.sqrt() - 0.1 * 3.147).exp();
    assert!((factor / expected - 1.0).abs() <= 0.01, "{factor} for {expected}");
    let lorenz = "u_i { x = 1, y = 1, z = 1 } F_i { 10*(y - x), x*(28 - z) - y, x*y - 8*z/3 }";
    assert!(matches!(character(lorenz, 30.0).growth, Growth::Untold(_)));
    assert!(matches!(character("u_i { x = 1 } F_i { -0.5*sqrt(x) }", 6.0).growth, Growth::Lost(_)));
}

/// The logistic solution is 1 where f ends.
#[test]
fn what_grows_from_next_to_nothing_to_one_does_not_blow_up() {
    let ends = character("u_i { x = 1e-9 } F_i { x*(1 - x) + 0*sqrt(30 - t) }", 40.0);
    assert!(matches!(ends.growth, Growth::Lost(_)) && !ends.blows_up(), "{ends:?}");
    assert!(character("u_i { x = 1e-9 } F_i { 1 + x*x }", 2.0).blows_up());
}

/// Of a pulse that is next to nothing the square is nothing, and its rate no direction that outweighs all others.
#[test]
fn a_pulse_far_from_its_time_makes_no_invariants() {
    let pulse = "u_i { a = 0, b = 0 } F_i { -3*a + exp(-(t - 5)*(t - 5)*50), 2*a - 4*b }";
    assert_eq!(character(pulse, 10.0).matrices.expect("small").invariants, 0);
}

/// Between the steps of the run that is looked at.
#[test]
fn a_rate_that_lasts_a_moment_is_seen() {
    let pulse = "u_i { a = 1, b = 0 } pulse { exp(-(t - 3.137)*(t - 3.137)/(2*0.004*0.004)) }
        F_i { -50*pulse*a + 0.3*b, 50*pulse*a - 0.3*b - 0.1*b*b }";
    let fastest = character(pulse, 10.0).matrices.expect("small").fastest;
    assert!((45.0..51.0).contains(&fastest), "{fastest}");
    // On what is at rest, over which the run passes.
    let at_rest =
        "u_i { a = 0, b = 1 } pulse { exp(-(t - 3.137)*(t - 3.137)/(2*0.0005*0.0005)) } F_i { -50*pulse*a, -b }";
    let fastest = character(at_rest, 10.0).matrices.expect("small").fastest;
    assert!((45.0..51.0).contains(&fastest), "{fastest}");
}

/// A heater that is on below 18 and off above keeps the temperature at 18, where no step of any length resolves f.
#[test]
fn a_run_along_a_jump_of_f_ends_after_so_many_steps() {
    let thermostat = "u_i { temp = 15, heat = 0 } F_i { 0.3*(5 - temp) + heat, 40*(10*heaviside(18 - temp) - heat) }";
    let refusal = advise(&of_text(thermostat, 10.0), 10.0, 1e-5, &mut |_| {}).expect("registered").refusal;
    let Some(Refusal::Lost(RunError::Step(StepError::TooManySteps { limit, .. }))) = refusal else {
        panic!("{refusal:?}")
    };
    assert_eq!(limit, TRIED);
}

/// A matrix is as many evaluations as it has columns that differ: of a band as many as its diagonals.
#[test]
fn work_is_counted_in_evaluations() {
    let work = |residuals, factorizations, inner| Work { residuals, factorizations, inner, ..Work::default() };
    let cost = |setting: &str, method: &str, work| {
        let problem = problem::build_setting(setting).expect("registered");
        trial::cost(&*problem, &*method::parse(method).expect("registered"))(work)
    };
    // A tridiagonal one and a full one of three columns; an equation of Method I takes f at both ends of the step.
    assert_eq!(cost("channel-couette cells=8", "rk4", work(1, 1, 0)), 1.0 + 3.0);
    assert_eq!(cost("channel-couette cells=8", "method-i", work(5, 2, 7)), 2.0 * (5.0 + 2.0 * 3.0 + 7.0));
    assert_eq!(cost("robertson", "rk4", work(10, 2, 0)), 10.0 + 2.0 * 3.0);
}

/// A matrix of Method I has second derivatives in it: of a model these are differences of matrices of two columns, one at v and one for each
/// column, beside the two of the matrix itself. What is linear has none.
#[test]
fn second_derivatives_of_a_model_are_counted_in_evaluations() {
    let cost = |code: &str, method: &str| {
        let work = Work { residuals: 3, factorizations: 1, ..Work::default() };
        trial::cost(&of_text(code, 1.0), &*method::parse(method).expect("registered"))(work)
    };
    let drag = "u_i { x = 1, y = 2 } F_i { -x*x + y, x - y }";
    assert_eq!(cost(drag, "method-i"), 2.0 * (3.0 + 2.0 + (1.0 + 2.0) * 2.0));
    assert_eq!(cost(drag, "tr-bdf2"), cost("u_i { x = 1, y = 2 } F_i { -x + y, x - y }", "tr-bdf2"));
    assert_eq!(cost("u_i { x = 1, y = 2 } F_i { -x + y, x - y }", "method-i"), 2.0 * (3.0 + 2.0));
}

/// A run of four steps that has taken too much work after the first is worth no second one, and says nothing of its error.
#[test]
fn a_run_that_takes_too_much_work_is_broken_off() {
    let (problem, method) = (problem::build_setting("van-der-pol mu=100").expect("registered"), "method-i");
    let (accurate, method) = (adaptive(1e-9).expect("registered"), method::parse(method).expect("registered"));
    let truth = Truth::by(&*problem, &*accurate, 1.0, 1.0).expect("it runs");
    let closest = |most: f64| search(&*problem, &*method, &truth, 1e-6, most, None).1;
    assert!(closest(1.0) == f64::INFINITY && closest(1e6) < 1e-6, "{} {}", closest(1.0), closest(1e6));
}

/// Of a method of order 4, with its errors with so many steps and with twice as many.
pub(super) fn trial(method: &str, cost: f64, errors: [f64; 2]) -> Trial {
    Trial {
        method: method.into(),
        setting: 0.1,
        atol: None,
        longest: None,
        is_strict: false,
        steps: 10,
        error: 1e-6,
        times: vec![1.0; 16],
        cost,
        falls: Some(Falls { errors, nominal: 4 }),
    }
}

/// Costs apart by less than a tenth are a tie, whichever of the trials behind them.
#[test]
fn what_takes_the_same_work_to_a_tenth_is_a_tie() {
    let refusal = |costs: &[f64]| {
        let trials = ["rk4", "trapezoidal", "tr-bdf2"]
            .iter()
            .zip(costs)
            .map(|(name, cost)| trial(name, *cost, [16e-6, 1e-6]))
            .collect();
        Tried { trials, rivals: Vec::new(), uncertainty: 1e-9, target: 1e-5, moved: 1.0, parting: 1e-9 }.refusal(1e-5)
    };
    let tie = Some(Refusal::Tie { first: "rk4".into(), second: "trapezoidal".into() });
    assert_eq!((refusal(&[40.0, 40.0]), refusal(&[40.0, 43.9, 44.0])), (tie.clone(), tie));
    assert_eq!((refusal(&[40.0, 44.0]), refusal(&[40.0, 48.0, 48.0]), refusal(&[40.0])), (None, None, None));
    assert!(matches!(refusal(&[]), Some(Refusal::OutOfReach { .. })));
}

/// An uncertainty that is too large, or none at all, comes before what the trials say.
#[test]
fn trials_that_nothing_confirms_are_no_advice() {
    let of = |uncertainty, moved, parting| {
        let (trials, rivals) = Default::default();
        Tried { trials, rivals, uncertainty, target: 1e-5, moved, parting }
    };
    let refusal = |uncertainty: f64, moved: f64| of(uncertainty, moved, 0.0).refusal(1e-5);
    for parting in [2e-6, f64::INFINITY, f64::NAN] {
        assert!(matches!(of(1e-9, 1.0, parting).refusal(1e-5), Some(Refusal::Parting { .. })), "{parting}");
    }
    for uncertainty in [2e-6, f64::INFINITY, f64::NAN] {
        assert!(matches!(refusal(uncertainty, 1.0), Some(Refusal::Unresolved { .. })), "{uncertainty}");
        assert_eq!(refusal(uncertainty, 1e-6), Some(Refusal::Constant { moved: 1e-6, target: 1e-5 }));
    }
}

/// Starts beside a state of rest that the solution leaves after a while: one long step over it all is no run to advise.
#[test]
fn what_is_advised_beside_an_unstable_rest_follows_the_solution() {
    let competitors = "in_i { y0 = 1e-10 } u_i { x = 1, y = y0 } F_i { x*(1-x-2*y), y*(1.5 - y - 0.5*x) }";
    let pendulum = "u_i { q = 3.141592653589793, p = 0 } F_i { p, -sin(q) }";
    for (text, horizon, end) in [(competitors, 50.0, Some([0.0, 1.5])), (pendulum, 40.0, None)] {
        let problem = of_text(text, horizon);
        let advice = advise(&problem, horizon, 1e-2, &mut |_| {}).expect("registered");
        let Some(taken) = advice.recommended() else { continue };
        let end = end.expect("rounding decides where the pendulum ends");
        let method = taken.built().expect("registered");
        let h = if method.traits().is_adaptive { horizon } else { taken.setting };
        let found = crate::run::run(&problem, &*method, h, horizon, |_| {}).expect("it ran before").end.q;
        assert!(distance(&found[..2], &end) <= 2.0 * advice.target, "{text}: {found:?} by {taken:?}");
    }
}

/// A pulse of 1/140 of a unit of time, between any 64 times, of which x keeps exp(7.3 − t + σ²/2) of its area.
#[test]
fn what_is_advised_for_a_pulse_follows_it() {
    let (sigma, horizon) = (1.0 / 200.0_f64.sqrt() / 10.0, 20.0);
    let problem = of_text("u_i { x = 0 } F_i { 1000*exp(-1e4*(t - 7.3)*(t - 7.3)) - x }", horizon);
    let area = 1000.0 * sigma * TAU.sqrt();
    let after = |t: f64| area * (7.3 - t + 0.5 * sigma * sigma).exp();
    let advice = advise(&problem, horizon, 1e-3, &mut |_| {}).expect("registered");
    assert!((advice.target - 1e-3 * area).abs() < 0.05 * advice.target, "{advice:?}");
    assert!(!advice.trials.is_empty(), "{advice:?}");
    for trial in &advice.trials {
        let method = trial.built().expect("registered");
        let h = if method.traits().is_adaptive { trial.longest.unwrap_or(horizon) } else { trial.setting };
        let mut error = 0.0;
        crate::run::run(&problem, &*method, h, horizon, |state| {
            if state.t > 7.5 {
                error = larger(error, (state.q[0] - after(state.t)).abs());
            }
        })
        .expect("it ran before");
        assert!(error <= 1.1 * advice.target, "{error:e}: {trial:?}");
    }
}

/// Five long steps of the adaptive method pass over a pulse, and nothing is left of it at their ends.
#[test]
fn steps_that_pass_over_a_pulse_are_no_trial() {
    let problem = of_text("u_i { x = 0 } F_i { 2000*exp(-400*(t - 50)*(t - 50)) - 20*x }", 100.0);
    let advice = advise(&problem, 100.0, 1e-3, &mut |_| {}).expect("registered");
    for trial in advice.trials.iter().filter(|trial| trial.method == ADAPTIVE) {
        assert!(trial.steps > 20, "{trial:?}");
    }
}

/// Of what is smooth 64 times see most; of a pulse and of a jump they see nothing, and the times lie in it and beside it.
#[test]
fn times_at_which_f_changes_are_those_that_equal_parts_do_not_see() {
    let stops: Vec<f64> = (1..=64).map(|k| 20.0 * f64::from(k) / 64.0).collect();
    let of = |rate: &str| changes(&of_text(&format!("u_i {{ x = 0 }} F_i {{ {rate} }}"), 20.0), 20.0, &stops);
    for rate in ["-x", "cos(t) - x", "t*t - x", "heaviside(t - 7.3) - x"] {
        assert!(of(rate).is_empty(), "{rate}");
    }
    let within = |times: &[f64], from: f64, to: f64| times.iter().filter(|t| (from..to).contains(*t)).count();
    let pulse = of("exp(-1e4*(t - 7.3)*(t - 7.3)) - x");
    assert!(pulse.len() > 40 && within(&pulse, 7.2, 7.4) == pulse.len(), "{pulse:?}");
    assert!(pulse.is_sorted());
    // With v = 0 at the start.
    let dose = of("(x + 1e-9)*heaviside(t - 7.3)*heaviside(7.32 - t)");
    assert!(dose.len() >= 4 && within(&dose, 7.299, 7.301) == 2 && within(&dose, 7.319, 7.321) == 2, "{dose:?}");
    let start = of("heaviside(1e-4 - t) + exp(-1e4*(t - 7.3)*(t - 7.3))");
    assert!(start[0] > 0.0, "{start:?}");
    let fast = of("cos(2*3.141592653589793*50*t)");
    assert!(fast.len() > 200 && within(&fast, 0.0, 10.0).abs_diff(fast.len() / 2) < 5, "{}", fast.len());
}

#[test]
fn a_field_that_is_not_finite_at_the_start_is_named() {
    let advice =
        advise(&of_text("u_i { w = 1, x = 0 } F_i { -w, log(x) }", 2.0), 2.0, 1e-5, &mut |_| {}).expect("registered");
    assert_eq!(advice.refusal, Some(Refusal::Start { component: 1, value: f64::NEG_INFINITY }));
}

/// What a system is like is told along the whole run, and not at its start.
#[test]
fn what_holds_at_the_start_alone_is_not_said_of_the_system() {
    let matrices = |text: &str| {
        let problem = of_text(text, 4.0);
        along(&problem, 4.0).matrices.expect("small")
    };
    let oscillator = matrices("u_i { q = 1, p = 0 } F_i { p, -q }");
    assert!(oscillator.is_hamiltonian && oscillator.instants >= 16, "{oscillator:?}");
    assert!(!matrices("u_i { q = 1, p = 0 } F_i { p, -q - t*p }").is_hamiltonian);
    // The square of the frequency hides the damping.
    assert!(!matrices("u_i { q = 1e-9, p = 0 } F_i { p, -1e14*q - 2e4*p }").is_hamiltonian);
    assert!(matrices("u_i { q = 1e-9, p = 0 } F_i { p, -1e14*q }").is_hamiltonian);
    assert!(matrices("u_i { x = 1, y = 1 } F_i { -x, -y }").is_symmetric());
    assert!(matrices("u_i { x = 1, y = 1 } F_i { -x + t*y, -y }").asymmetry > 0.5);
    // The sum of the components is conserved, or but for a part in ten thousand.
    // The slowest mode of a plate of uniform temperature is five digits slower than the fastest, and its rates are all alike.
    let plate = |ends: &str| {
        let a = format!("A_ij {{ {ends}, (1..199,1..199): -2, (0..199,1..200): 1, (1..200,0..199): 1 }}");
        matrices(&format!("{a} u_i {{ (0:200): 1 }} p_i {{ A_ij * u_j }} F_i {{ 40401*p_i }}")).invariants
    };
    assert_eq!([plate("(0,0): -2, (199,199): -2"), plate("(0,0): -1, (199,199): -1")], [0, 1]);
    assert_eq!(matrices("u_i { x = 1, y = 0 } F_i { -x + y, x - y }").invariants, 1);
    assert_eq!(matrices("u_i { x = 1, y = 0 } F_i { -x + y, 1.0001*x - y }").invariants, 0);
    // At rest in (1, 0), where y has no rate of first order.
    assert_eq!(matrices("u_i { x = 1, y = 0 } F_i { 1 - x - y*y, y*y }").invariants, 0);
    assert_eq!(matrices("u_i { x = 1, y = 0 } F_i { -y*y, y*y }").invariants, 1);
    assert_eq!(matrices("u_i { x = 0, y = 0 } F_i { -x - y*y, y*y - y }").invariants, 0);
    // Method I keeps x + y where A (1, 1) = 0, whatever the units are.
    for (text, invariants, kept) in [
        ("u_i { x = 1, y = 0 } F_i { -x + y, x - y }", 1, true),
        ("u_i { x = 1, y = 0 } F_i { -x, x }", 1, false),
        ("u_i { x = 1, y = 1e-6 } F_i { -x + 1e6*y, 1e-6*x - y }", 1, false),
        ("u_i { x = 1, y = 0, z = 2 } F_i { -x + y, x - y, 0 }", 2, true),
    ] {
        let found = matrices(text);
        assert_eq!((found.invariants, found.keeps_invariants), (invariants, kept), "{text}");
    }
}

/// The largest error at the ends of the steps of a trial, against an accurate run to each of them.
fn largest_error(problem: &dyn Problem, horizon: f64, trial: &Trial) -> f64 {
    largest_error_by(&*adaptive(1e-11).expect("registered"), problem, horizon, trial)
}

fn largest_error_by(accurate: &dyn Method, problem: &dyn Problem, horizon: f64, trial: &Trial) -> f64 {
    let method = trial.built().expect("registered");
    let h = if method.traits().is_adaptive { trial.longest.unwrap_or(horizon) } else { trial.setting };
    let mut ends = Vec::new();
    crate::run::run(problem, &*method, h, horizon, |state| ends.push((state.t, state.q.clone())))
        .expect("it ran before");
    let times: Vec<f64> = ends[1..].iter().map(|(t, _)| *t).collect();
    let truth = crate::run::run_through(problem, accurate, &times).expect("followed");
    ends[1..].iter().zip(&truth).map(|((_, state), truth)| common_distance(state, truth)).largest()
}

/// Errors of phase are largest where the motion is fast, which is a small part of the time.
#[test]
fn errors_are_read_where_they_are_largest() {
    let (problem, horizon) = (problem::build_setting("kepler").expect("registered"), 60.0);
    let advice = advise(&*problem, horizon, 1e-3, &mut |_| {}).expect("registered");
    assert!(advice.trials.len() > 3, "{advice:?}");
    for trial in &advice.trials {
        let error = largest_error(&*problem, horizon, trial);
        assert!((error - trial.error).abs() <= 2.0 * advice.uncertainty + 1e-6, "{error:e}: {trial:?}");
    }
}

/// A start without fast components lets a run to a near end pass with steps that amplify them.
#[test]
fn no_step_is_advised_that_amplifies_what_the_equation_damps() {
    for (setting, accuracy) in [("heat-2d", 1e-2), ("heat-2d", 1e-3)] {
        let problem = problem::build_setting(setting).expect("registered");
        let advice = advise(&*problem, problem.horizon(), accuracy, &mut |_| {}).expect("registered");
        let fastest = advice.character.matrices.expect("small").fastest;
        for trial in advice.trials.iter().filter(|trial| trial.method == "rk4") {
            // To three digits, −2.785 is where R(z) of RK4 is 1.
            assert!(trial.setting * fastest <= 2.786, "{setting}: {trial:?}, {fastest}");
        }
    }
}

/// Where no steps of one size come near in the work that is worth a trial.
#[test]
fn a_cheap_run_is_confirmed_by_another_solver() {
    for mu in ["150", "200"] {
        let problem = problem::build_setting(&format!("van-der-pol mu={mu}")).expect("registered");
        let advice = advise(&*problem, problem.horizon(), 1e-5, &mut |_| {}).expect("registered");
        assert!(advice.recommended().is_some_and(|trial| trial.method == ADAPTIVE), "{mu}: {:?}", advice.refusal);
    }
}

/// The light of a laser falls to 10⁻¹² before it comes back to 1: with an absolute tolerance beside that the adaptive method follows it in some 60
/// steps, where RK4 needs 3456, and with the same for all it does not.
#[test]
fn what_comes_back_from_a_small_size_is_followed_with_an_absolute_tolerance_beside_that() {
    let laser = "u_i { n = 0, p = 1e-4 } pump { 3*exp(-(t - 10)*(t - 10)/4) }
                 F_i { pump - 0.1*n - 20*n*p, 20*n*p - 8*p + 1e-5*n }";
    let problem = of_text(laser, 30.0);
    let advice = advise(&problem, 30.0, 1e-5, &mut |_| {}).expect("registered");
    let taken = advice.recommended().expect("it is clear");
    assert!(taken.method == ADAPTIVE && taken.steps < 200, "{taken:?}");
    let atol = taken.atol.as_ref().expect("an adaptive method has some");
    assert!(atol.len() == 2 && atol[1] < 1e-6 * taken.setting, "{taken:?}");
    assert!(largest_error(&problem, 30.0, taken) <= 1.1 * advice.target, "{taken:?}");
    assert!(atol.iter().all(|atol| *atol == as_printed(*atol)), "{taken:?}");
    // Beside seven more components, which rest at 1, the least is that of all.
    let many = of_text(
        "u_i { n = 0, p = 1e-4, a = 1, b = 1, c = 1, d = 1, e = 1, f = 1, g = 1 } pump { 3*exp(-(t - 10)*(t - 10)/4) }
         F_i { pump - 0.1*n - 20*n*p, 20*n*p - 8*p + 1e-5*n, 0, 0, 0, 0, 0, 0, 0 }",
        30.0,
    );
    let tried = try_out(&many, 30.0, (1e-7, Held::to(1e-7)), [&[], &[]], &along(&many, 30.0), &mut |_| {})
        .expect("registered")
        .expect("it is followed");
    let atol = tried.trials[0].atol.as_ref().expect("an adaptive method has some");
    assert!(atol.len() == 1 && atol[0] < 1e-6 * tried.trials[0].setting, "{:?}", tried.trials);
}

/// Of van der Pol's equation, whose components are least where they turn back, one absolute tolerance for both takes less work at some accuracies,
/// and at others those beside their least sizes, which have larger tolerances for the same.
#[test]
fn of_two_absolute_tolerances_the_cheaper_one_is_tried() {
    let problem = problem::build("van-der-pol", &[]).expect("registered");
    let horizon = duration(&*problem).expect("it turns");
    let counts = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7].map(|accuracy| {
        let held = (accuracy, Held::to(accuracy));
        let tried = try_out(&*problem, horizon, held, [&[], &[]], &along(&*problem, horizon), &mut |_| {});
        let trials = tried.expect("registered").expect("it is followed").trials;
        assert_eq!(trials.len(), 1, "{trials:?}");
        trials[0].atol.as_ref().map(Vec::len)
    });
    assert!(counts.contains(&Some(1)) && counts.contains(&Some(2)), "{counts:?}");
}

/// Infected come back from parts of 10⁻²³, below the tolerance of a run of a solution of order one, which ends or goes another way there. The
/// exact reference is a run of the logarithm of their number.
#[test]
fn what_comes_back_from_next_to_nothing_is_followed() {
    let epidemic = of_text("u_i { s = 0.999, y = 0.001, r = 0 } F_i { -4*s*y + 0.01*r, 4*s*y - y, y - 0.01*r }", 200.0);
    let advice = advise(&epidemic, 200.0, 1e-5, &mut |_| {}).expect("registered");
    let taken = advice.recommended().expect("a method");
    let logarithm = of_text(
        "u_i { s = 0.999, l = -6.907755278982137, r = 0 } F_i { -4*s*exp(l) + 0.01*r, 4*s - 1, exp(l) - 0.01*r }",
        200.0,
    );
    let end = |problem: &Model, method: &dyn Method, h: f64| {
        crate::run::run(problem, method, h, 200.0, |_| {}).expect("it ran before").end.q
    };
    let truth = end(&logarithm, &*adaptive(1e-11).expect("registered"), 200.0);
    let method = taken.built().expect("registered");
    let h = if method.traits().is_adaptive { 200.0 } else { taken.setting };
    let found = end(&epidemic, &*method, h);
    let error = (found[0] - truth[0]).abs().max((found[2] - truth[2]).abs());
    assert!(error <= taken.error + advice.uncertainty, "{error:e}: {taken:?}, {:e}", advice.uncertainty);
}

/// Robertson's reaction with a product of its own, to a time at which no steps of one size resolve its start: CVODE confirms it. A run with
/// tolerances of 10⁻⁶ loses the sign of a part of it, and the system is another one there.
#[test]
fn a_stiff_solution_that_no_fixed_steps_follow_is_confirmed_by_another_solver() {
    let reaction = of_text(
        "u_i { a = 1, b = 0, c = 0, d = 0 }
         F_i { -0.04*a + 1e4*b*c, 0.04*a - 1e4*b*c - 3e7*b*b, 3e7*b*b - 1e-3*c, 1e-3*c }",
        1e4,
    );
    let advice = advise(&reaction, 1e4, 1e-5, &mut |_| {}).expect("registered");
    assert_eq!(advice.recommended().map(|trial| &*trial.method), Some(ADAPTIVE), "{:?}", advice.refusal);
    assert!(advice.uncertainty <= CONFIRMED * advice.target);
    let fastest = advice.character.matrices.expect("small").fastest;
    assert!((1e3..1e5).contains(&fastest), "{fastest}");
}

/// The velocity of a relaxation oscillation is 1300 for a moment, and an error is relative to that. When it jumps is known to so many digits
/// that no more than two of it are.
#[test]
fn errors_are_relative_to_what_lasts_a_moment_too() {
    let oscillator = of_text("u_i { x = 2, y = 0 } F_i { y, 1000*(1 - x*x)*y - x }", 1700.0);
    let advice = advise(&oscillator, 1700.0, 1e-2, &mut |_| {}).expect("registered");
    assert!((10.0..20.0).contains(&advice.target), "{}", advice.target);
    assert_eq!(advice.recommended().map(|trial| &*trial.method), Some(ADAPTIVE), "{:?}", advice.refusal);
}

#[test]
fn the_adaptive_method_is_tried_with_ten_times_the_tolerance_of_the_accurate_run_or_more() {
    assert_eq!(tolerances(1e-6), [1e-2, 3.16e-3, 1e-3, 3.16e-4, 1e-4, 3.16e-5, 1e-5]);
    assert_eq!((tolerances(1e-12).len(), tolerances(1e-12).last()), (17, Some(&1e-10)));
}

/// On either axis, and not for what grows.
#[test]
fn steps_for_stability_are_counted_by_the_border_of_the_region() {
    for (text, expected) in [
        ("u_i { x = 1 } F_i { -10*x }", 10.0 / 2.785_293_563),
        ("u_i { x = 1, y = 0 } F_i { 3*y, -3*x }", 3.0 / 8_f64.sqrt()),
        ("u_i { x = 1 } F_i { 10*x }", 0.0),
        ("u_i { x = 1, y = 1 } F_i { 10*x, -y }", 1.0 / 2.785_293_563),
        ("u_i { x = 1 } F_i { 0 }", 0.0),
    ] {
        let found = character(text, 0.5).matrices.expect("small").steps_of_rk4;
        approx::assert_relative_eq!(found, expected, max_relative = 1e-8);
    }
}

/// Kepler's problem in metres and seconds conserves nothing linear, however small the rates of velocities are beside those of places; and the
/// sum of two components of unlike sizes is conserved all the same.
#[test]
fn what_has_small_units_is_not_conserved_for_that() {
    let matrices = |text: &str, horizon: f64| character(text, horizon).matrices.expect("small");
    let kepler = "u_i { x = 1.5e11, y = 0, v = 0, w = 3e4 }
        F_i { v, w, -1.327e20*x/pow(x*x + y*y, 1.5), -1.327e20*y/pow(x*x + y*y, 1.5) }";
    assert_eq!(matrices(kepler, 3e7).invariants, 0);
    assert_eq!(matrices("u_i { x = 1, y = 1e-9 } F_i { -1e-9*x + y, 1e-9*x - y }", 10.0).invariants, 1);
}

/// A driven oscillator is Hamiltonian at each time, and has no energy that is kept.
#[test]
fn a_field_that_depends_on_time_is_known() {
    let is_autonomous = |text: &str| character(text, 10.0).matrices.expect("small").is_autonomous;
    assert!(is_autonomous("u_i { q = 1, p = 0 } F_i { p, -sin(q) }"));
    assert!(!is_autonomous("u_i { q = 1, p = 0 } F_i { p, -sin(q) + 0.1*cos(t) }"));
    // From where f does not depend on time.
    assert!(!is_autonomous("u_i { q = 0, p = 1 } F_i { p, -(1 + 0.6*cos(2*t))*q }"));
}

/// A burst that is over at the end of the run: steps as long as they like pass over it, at whatever tolerance, and all that is left to see at
/// the ends of few fixed steps is the rest.
#[test]
fn a_run_whose_steps_show_nothing_of_a_burst_is_no_trial() {
    let burst = of_text("u_i { x = 0 } F_i { -x + 30*exp(-(t - 61.37)*(t - 61.37)*200) }", 100.0);
    let advice = advise(&burst, 100.0, 1e-3, &mut |_| {}).expect("registered");
    let taken = advice.trials.iter().find(|trial| trial.method == ADAPTIVE).expect("it reaches the accuracy");
    assert!(taken.steps > 20, "{taken:?}");
    for trial in &advice.trials {
        let method = trial.built().expect("registered");
        let h = if method.traits().is_adaptive { trial.longest.unwrap_or(100.0) } else { trial.setting };
        let mut largest = 0.0;
        crate::run::run(&burst, &*method, h, 100.0, |state| largest = larger(largest, state.q[0])).expect("it ran");
        assert!(largest > 1.0, "{largest}: {trial:?}");
    }
}

/// On the spikes of v errors are those of the phase; between them, where 64 times of the run lie, nothing is to be seen of them.
#[test]
fn an_error_is_told_where_the_solution_is_known_to_a_part_of_it() {
    let (horizon, accuracy) = (2000.0, 1e-3);
    let problem = of_text("u_i { x = 2, v = 0 } F_i { v, 1000*(1 - x*x)*v - x }", horizon);
    let advice = advise(&problem, horizon, accuracy, &mut |_| {}).expect("registered");
    let trial = advice.recommended().expect("one");
    // One with a tolerance of 1e-11 is off by a fifth of that.
    let accurate = Held::SMALL.method(0.0).expect("registered");
    let found = largest_error_by(&*accurate, &problem, horizon, trial);
    let (told, within) = (trial.error, advice.uncertainty);
    assert!((found - told).abs() <= 2.0 * within, "{found} where {told} is told, to {within}");
    assert!(found <= 1.1 * advice.target, "{found}");
}

fn unseen() -> Character {
    Character::unseen(&*problem::build("linear-drag", &[]).expect("registered"))
}

/// What growth makes of a tolerance counts where it is beyond a tenth of the error asked for, and where no method is recommended; that there is
/// no solution always does.
#[test]
fn tolerances_are_in_doubt_where_growth_makes_too_much_of_them() {
    let is_doubtful = |growth: Growth, refusal: Option<Refusal>| {
        let character = Character { growth, ..unseen() };
        let advice =
            Advice { character, trials: Vec::new(), rivals: Vec::new(), uncertainty: 0.0, target: 1e-5, refusal };
        advice.is_doubtful(Held { rtol: 1e-11, scale: 1.0, unit: 1.0 })
    };
    let tie = || Some(Refusal::Tie { first: "rk4".into(), second: "bdf2".into() });
    for (growth, spoils) in [
        (Growth::By(9e4), false),
        (Growth::By(1.1e5), true),
        (Growth::Untold([9e4, 1.0]), false),
        (Growth::Untold([1.1e5, 1.0]), true),
        (Growth::Untold([1.0, 1.1e5]), true),
    ] {
        assert_eq!(is_doubtful(growth.clone(), tie()), spoils, "{growth:?}");
        assert!(!is_doubtful(growth, None), "it is recommended");
    }
    let lost = RunError::Step(StepError::StepUnderflow { t: 1.0, h: 1e-12 });
    for refusal in [
        Refusal::Lost(lost),
        Refusal::Parting { difference: 1.0, target: 1e-5 },
        Refusal::Unresolved { difference: 1.0, target: 1e-5 },
        // Of tolerances that are not much larger than those of the accurate runs.
        Refusal::OutOfReach { accuracy: 1e-5, most: 4 },
    ] {
        assert!(is_doubtful(Growth::By(1.0), Some(refusal.clone())), "{refusal:?}");
    }
}

/// Smaller tolerances tell more, but where they alone lose the solution.
#[test]
fn of_two_attempts_the_finer_one_is_told_unless_it_has_no_solution_where_the_other_has_one() {
    let advice = |refusal: Option<Refusal>| {
        let character = unseen();
        Advice { character, trials: Vec::new(), rivals: Vec::new(), uncertainty: 0.0, target: 1e-5, refusal }
    };
    let parting = || Some(Refusal::Parting { difference: 1.0, target: 1e-5 });
    let unresolved = || Some(Refusal::Unresolved { difference: 1.0, target: 1e-5 });
    let lost = || Some(Refusal::Lost(RunError::Step(StepError::StepUnderflow { t: 1.0, h: 1e-12 })));
    let coarse = || Some(Refusal::OutOfReach { accuracy: 1e-5, most: 4 });
    for (first, second, is_second) in [
        (coarse(), None, true),
        (parting(), None, true),
        (parting(), unresolved(), true),
        (lost(), parting(), true),
        (coarse(), parting(), false),
        (parting(), lost(), false),
        (coarse(), lost(), false),
    ] {
        let told = advice(first.clone()).or_finer(advice(second.clone())).refusal;
        assert_eq!(told, if is_second { second } else { first });
    }
}

/// Predators come back from parts of 10⁻¹², below the tolerances of a first pair of accurate runs, which part there, so that nothing is measured by
/// them.
#[test]
fn what_parts_with_usual_tolerances_is_followed_with_small_ones() {
    let problem = of_text("u_i { x = 10, y = 1e-3 } F_i { x - x*y, 3*x*y - y }", 40.0);
    let mut tried = Vec::new();
    let advice = advise(&problem, 40.0, 1e-5, &mut |what| tried.push(what.to_owned())).expect("registered");
    let times = ["the solution", "rk4"].map(|name| tried.iter().filter(|what| *what == name).count());
    assert_eq!(times, [2, 1], "{tried:?}");
    let taken = advice.recommended().expect("a method");
    assert!(taken.method == ADAPTIVE && taken.atol.iter().flatten().all(|atol| *atol < 1e-15), "{taken:?}");
    // 3x − ln x + y − ln y stays.
    let method = taken.built().expect("registered");
    let end = crate::run::run(&problem, &*method, 40.0, 40.0, |_| {}).expect("it ran before").end.q;
    let kept = |v: &[f64]| 3.0 * v[0] - v[0].ln() + v[1] - v[1].ln();
    let change = kept(&end) - kept(&problem.initial());
    assert!(change.abs() < 1e-2, "{change:e}");
}

/// Sizes of 10⁻¹² and of 10⁻⁹ in a unit of 1: the errors asked for are relative to them.
#[test]
fn a_solution_in_small_units_has_a_unit_of_its_own() {
    let decay = "u_i { a = 2e-12, b = 0 } F_i { -3e8*a + 1e8*b, 3e8*a - 2e8*b }";
    let reaction = "u_i { a = 1e-9 } F_i { -1e16*a*a }";
    for (text, horizon, size) in [(decay, 5e-9, 2e-12), (reaction, 1e-6, 1e-9)] {
        let problem = of_text(text, horizon);
        let advice = advise(&problem, horizon, 1e-5, &mut |_| {}).expect("registered");
        let taken = advice.recommended().unwrap_or_else(|| panic!("{:?}", advice.refusal));
        assert!((advice.target / (1e-5 * size) - 1.0).abs() < 1e-9 && taken.error <= advice.target, "{taken:?}");
    }
}

/// A blow of 10⁴ for a hundredth of a unit of time brings what is at rest in 0 to some 90, to which no tolerance of 10⁻¹¹ is held there.
#[test]
fn a_solution_that_no_tolerance_holds_has_a_unit_of_its_own() {
    let doses = of_text(
        "u_i { gut = 0, c = 0 } dose { 10000*heaviside(t-12.37)*heaviside(12.38-t) } F_i { dose - 1.2*gut, 1.2*gut - 0.15*c }",
        72.0,
    );
    let advice = advise(&doses, 72.0, 1e-5, &mut |_| {}).expect("registered");
    assert!((9e-4..1.01e-3).contains(&advice.target), "{advice:?}");
    let taken = advice.recommended().unwrap_or_else(|| panic!("{:?}", advice.refusal));
    assert!(taken.error <= advice.target, "{taken:?}");
}

/// Light grows from 10⁻⁹, to which CVODE is not held by a tolerance that is the same for all.
#[test]
fn what_grows_from_a_small_size_is_confirmed_beside_that() {
    let laser = of_text(
        "u_i { n = 3, ph = 1e-9 } loss { 6 - 5*heaviside(t - 20) } F_i { 0.05*(3 - n) - n*ph*0.05, (n - loss)*ph + 1e-9*n }",
        50.0,
    );
    let advice = advise(&laser, 50.0, 1e-5, &mut |_| {}).expect("registered");
    assert!(advice.recommended().is_some(), "{:?}", advice.refusal);
}

/// The cheapest whose errors follow its order; where those of none do, none.
#[test]
fn a_method_whose_errors_follow_no_order_is_passed_over() {
    let trial = |method: &str, cost: f64, found: f64| trial(method, cost, [found.exp2() * 1e-6, 1e-6]);
    let tried = |trials: Vec<Trial>| {
        let tried = Tried { trials, rivals: Vec::new(), uncertainty: 1e-9, target: 1e-5, moved: 1.0, parting: 1e-9 };
        let refusal = tried.refusal(1e-5);
        let advice = Advice {
            refusal,
            ..Advice::refused(along(&*problem::small("kepler").expect("registered"), 1.0), Refusal::MatrixFree)
        };
        let advice = Advice { trials: tried.trials, uncertainty: tried.uncertainty, ..advice };
        (advice.recommended().map(|trial| trial.method.clone()), advice.refusal)
    };
    let (taken, refusal) =
        tried(vec![trial("rk4", 40.0, 2.0), trial("tr-bdf2", 42.0, 4.0), trial("method-i", 80.0, 4.0)]);
    assert_eq!((taken.as_deref(), refusal), (Some("tr-bdf2"), None));
    let (taken, refusal) = tried(vec![trial("rk4", 40.0, 2.0), trial("tr-bdf2", 80.0, 3.0)]);
    assert!(taken.is_none() && matches!(refusal, Some(Refusal::NotSmooth { nominal: 4, .. })), "{refusal:?}");
    let (_, refusal) = tried(vec![trial("rk4", 40.0, 2.0), trial("tr-bdf2", 42.0, 4.0), trial("method-i", 43.0, 4.0)]);
    assert_eq!(refusal, Some(Refusal::Tie { first: "tr-bdf2".into(), second: "method-i".into() }));
}

/// Friction and a switch jump, also where nothing else changes; a steep f and a stiff one do not.
#[test]
fn jumps_of_f_are_seen_and_steep_ways_are_none() {
    let jumps = |text: &str| character(text, 10.0).matrices.expect("small").jumps;
    for text in [
        "u_i { x = 3, v = 0 } F_i { v, -x - 0.4*(2*heaviside(v) - 1) }",
        "u_i { x = 3, v = 0 } F_i { v, -x - 0.01*(2*heaviside(v) - 1) }",
        "u_i { x = 0 } F_i { heaviside(t - 3.1) - x }",
    ] {
        assert!(jumps(text), "{text}");
    }
    for text in [
        "u_i { x = 3, v = 0 } F_i { v, -x - 0.4*tanh(1000*v) }",
        "u_i { x = 3, v = 0 } F_i { v, -x - 0.4*tanh(1e10*v) }",
        "u_i { x = 1, y = 0 } F_i { -1e6*(x - cos(t)), x - y }",
        "u_i { q = 1, p = 0 } F_i { p, -sin(q) }",
        "u_i { x = 0.3000001 } F_i { 10*x*(1-x)*(x-0.3) }",
        "u_i { x = 0 } F_i { -x + sin(2000*t)*50 }",
        "u_i { x = 0 } F_i { 0 }",
    ] {
        assert!(!jumps(text), "{text}");
    }
}

/// rk4 comes within 1e-6, and the least error of Method I is much larger. A longest step as long as the run is not told, however many digits
/// that has.
#[test]
fn the_solution_is_confirmed_by_the_method_that_comes_nearest_whichever_is_last() {
    let problem = problem::build_setting("harmonic-oscillator").expect("registered");
    let horizon = TAU;
    let character = along(&*problem, horizon);
    let [first, last] = [["rk4", "method-i"], ["method-i", "rk4"]].map(|names| {
        let methods: Vec<_> = names.iter().map(|name| method::parse(name).expect("registered")).collect();
        let tried = try_out(&*problem, horizon, (1e-3, Held::to(1e-3)), [&methods, &[]], &character, &mut |_| {});
        let tried = tried.expect("registered").expect("followed");
        let adaptive = tried.trials.iter().find(|trial| trial.method == ADAPTIVE).expect("it reaches the accuracy");
        assert_eq!(adaptive.longest, None);
        tried.uncertainty
    });
    assert!(first <= 1.01 * last && last <= 1.01 * first, "{first:e}, {last:e}");
}

#[test]
fn what_is_said_of_matrices_holds_at_all_times_and_for_small_rates() {
    let of = |text: &str| character(text, 2.0).matrices.expect("small");
    let grows = of("u_i { x = 1, y = 1 } F_i { 1e-4*x, -y }");
    assert!(!grows.is_contractive() && !grows.is_non_normal());
    assert_eq!(of("u_i { x = 0, y = 1 } F_i { 1, -y }").invariants, 0);
    let later = of("u_i { x = 0.1 } F_i { (t - 1)*x }");
    assert!(!later.is_contractive() && !later.is_autonomous);
    assert!(!of("u_i { x = 1 } F_i { heaviside(t - 1.3)*heaviside(1.7 - t) - x }").is_autonomous);
}

/// Errors that fall, but for one that is small by chance; the work of each is told beside it.
#[test]
fn a_tolerance_whose_successor_fails_is_passed_over() {
    let trial = |rtol: f64, cost: f64| Trial {
        method: "adaptive".into(),
        setting: rtol,
        atol: None,
        longest: None,
        is_strict: false,
        steps: 1,
        error: 0.0,
        times: Vec::new(),
        cost,
        falls: None,
    };
    let found = |reached: &[(f64, f64)]| {
        let reaches = |rtol: &f64| reached.iter().find(|(at, _)| at == rtol).map(|(at, cost)| trial(*at, *cost));
        first_lasting(&[4.0, 3.0, 2.0, 1.0], reaches).map(|trial| trial.setting)
    };
    assert_eq!(found(&[(4.0, 1.0), (2.0, 5.0), (1.0, 6.0)]), Some(2.0));
    assert_eq!(found(&[(3.0, 5.0), (2.0, 4.0), (1.0, 1.0)]), Some(2.0));
    assert_eq!([found(&[(4.0, 1.0), (1.0, 2.0)]), found(&[(4.0, 1.0)])], [Some(1.0), None]);
}
