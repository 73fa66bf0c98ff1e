//! Adaptive integration against exact solutions and against itself at tighter tolerances.

use crate::fields::{As, Line, Walls, with_structure};
use crate::systems::{AnyField, field_of};
use lsvi::adaptive::{Options, Radau, Tolerances};
use lsvi::{
    FieldFn, InputError, Integrator, Jacobian, Mass, Scalar, SettingError, SolveError, State, StepError, Structure,
    SystemError, TimeError, Trajectory, VectorField,
};

struct VanDerPol {
    mu: f64,
}
impl FieldFn for VanDerPol {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[1];
        dv[1] = (-v[0] * v[0] + 1.0) * v[1] * self.mu - v[0];
    }
}

/// v̇ = −λ (v − cos t) − sin t.
struct ProtheroRobinson {
    lambda: f64,
}
impl FieldFn for ProtheroRobinson {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = (v[0] - t.cos()) * -self.lambda - t.sin();
    }
}

/// Robertson's reaction; with `algebraic` its third equation is the conservation of mass.
struct Robertson {
    algebraic: bool,
}
impl FieldFn for Robertson {
    fn dim(&self) -> usize {
        3
    }
    fn mass(&self) -> Mass {
        if self.algebraic { Mass::Diagonal(vec![1.0, 1.0, 0.0]) } else { Mass::Identity }
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        let (slow, fast) = (v[0] * -0.04 + v[1] * v[2] * 1e4, v[1] * v[1] * 3e7);
        dv[0] = slow;
        dv[1] = -slow - fast;
        dv[2] = if self.algebraic { v[0] + v[1] + v[2] - 1.0 } else { fast };
    }
}

/// v̇ = v², v = 1/(1 − t).
struct BlowUp;
impl FieldFn for BlowUp {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[0] * v[0];
    }
}

fn radau<F: VectorField>(field: F, rtol: f64, atol: f64) -> Radau<F> {
    Radau::new(field, Tolerances::new(rtol, atol).expect("positive")).expect("a valid field")
}

/// The state at `end` and the steps to it.
fn solve<F: VectorField>(field: F, v: &[f64], end: f64, rtol: f64, atol: f64) -> (Vec<f64>, u64) {
    let mut method = radau(field, rtol, atol);
    let state = Trajectory::new(&mut method, State::new(0.0, v.to_vec()), end, end).expect("valid").observe(|_| {});
    let state = state.expect("solvable");
    assert_eq!(state.t, end);
    (state.q, lsvi::Integrator::work(&method).steps)
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
}

/// The largest error of v = cos t by s stages in a run to t = 100, and the steps.
fn smooth_run(s: usize, tolerance: f64) -> (f64, f64) {
    let tolerances = Tolerances::new(tolerance, tolerance).expect("positive");
    let options = Options::new(tolerances).stages(s, s).expect("a choice");
    let mut method = Radau::new(field_of(ProtheroRobinson { lambda: 1.0 }), options).expect("valid");
    let mut largest = 0.0_f64;
    Trajectory::new(&mut method, State::new(0.0, vec![1.0]), 100.0, 100.0)
        .expect("valid")
        .observe(|state| largest = largest.max((state.q[0] - state.t.cos()).abs()))
        .expect("solvable");
    (largest, lsvi::Integrator::work(&method).steps as f64)
}

/// On a smooth problem the error is the power 2s − 1 of the mean step.
#[test]
fn the_error_is_of_order_five_nine_and_thirteen() {
    for (s, loose, tight) in [(3, 1e-6, 1e-11), (5, 1e-4, 1e-10), (7, 1e-2, 1e-9)] {
        let ((coarse, few), (fine, many)) = (smooth_run(s, loose), smooth_run(s, tight));
        let (order, expected) = ((coarse / fine).ln() / (many / few).ln(), 2.0 * s as f64 - 1.0);
        // The tolerance varies the steps along the run, and the shares of the steps with it: a tenth of the order.
        assert!(
            (order - expected).abs() < 0.1 * expected,
            "order {order} of {s} stages from {coarse:e} in {few} and {fine:e} in {many} steps"
        );
    }
}

/// On a grid of both tolerances, atol the same part of each component's size: the error at the end stays below ten times what
/// is tolerated, or what the estimate of a stiff component is held to, and so falls with either tolerance; with three stages
/// the steps grow with each.
#[test]
fn error_and_work_are_monotone_in_each_tolerance() {
    let van_der_pol = field_of(VanDerPol { mu: 1.0 });
    let robertson = field_of(Robertson { algebraic: false });
    let stiff = field_of(ProtheroRobinson { lambda: 1e4 });
    // What is tolerated at the end of each, in units of the tolerance, grows by at most the factor 10 of a digit.
    type Case<'a> = (&'a dyn VectorField, &'a [f64], f64, &'a [f64], bool);
    let cases: [Case<'_>; 3] = [
        (&van_der_pol, &[2.0, 0.0], 2.0, &[1.0, 1.0], false),
        (&robertson, &[1.0, 0.0, 0.0], 40.0, &[1.0, 1e-5, 1.0], false),
        (&stiff, &[0.0], 3.0, &[1.0], true),
    ];
    for (case, (field, start, end, sizes, is_stiff)) in cases.into_iter().enumerate() {
        let run = |rtol: f64, atol: f64, most: usize| {
            let each = sizes.iter().map(|size| size * atol).collect();
            let tolerances = Tolerances::new(rtol, 0.0).and_then(|t| t.with_atol(each)).expect("positive");
            let options = Options::new(tolerances).stages(3, most).expect("a choice");
            let mut method = Radau::new(field, options).expect("valid");
            let state = Trajectory::new(&mut method, State::new(0.0, start.to_vec()), end, end).expect("valid");
            let state = state.observe(|_| {}).unwrap_or_else(|error| panic!("{case}: {rtol:e}, {atol:e}: {error}"));
            (state.q, lsvi::Integrator::work(&method).steps + method.rejected())
        };
        let (truth, _) = run(1e-14, 1e-20, 7);
        let exponents: Vec<i32> = (2..=14).step_by(2).collect();
        let mut steps = Vec::new();
        for r in &exponents {
            for a in exponents.iter().map(|a| a + (a - 2) / 2) {
                let (rtol, atol) = (10_f64.powi(-r), 10_f64.powi(-a));
                let (v, _) = run(rtol, atol, 7);
                for ((v, exact), size) in v.iter().zip(&truth).zip(sizes) {
                    let tolerated = size * atol + rtol * exact.abs();
                    let held = if is_stiff { tolerated.max(0.1 * tolerated.powf(2.0 / 3.0)) } else { tolerated };
                    // Some hundred steps with a rounding each.
                    let allowed = 10.0 * held + 100.0 * f64::EPSILON * size;
                    assert!((v - exact).abs() <= allowed, "{case}: {:e} at {rtol:e}, {atol:e}", v - exact);
                }
                if a <= 8 && *r <= 8 {
                    steps.push((r, a, run(rtol, atol, 3).1));
                }
            }
        }
        for (r, a, fewer) in &steps {
            for (k, l, more) in &steps {
                // Rejections come and go: a tenth, and a few.
                let is_less = *more as f64 * 1.1 + 3.0 < *fewer as f64;
                assert!(!(k >= r && l >= a && is_less), "{case}: {fewer} at {r}, {a}, {more} at {k}, {l}");
            }
        }
    }
}

#[test]
fn options_are_obeyed() {
    let tolerances = Tolerances::new(1e-8, 1e-8).expect("positive");
    let field = field_of(VanDerPol { mu: 1.0 });
    let run = |options: Options| {
        let mut method = Radau::new(&field, options).expect("valid");
        let (mut ends, mut most) = (vec![0.0], 0);
        let mut trajectory = Trajectory::new(&mut method, State::new(0.0, vec![2.0, 0.0]), 20.0, 20.0).expect("valid");
        let result = loop {
            match trajectory.step() {
                Ok(Some(state)) => ends.push(state.t),
                Ok(None) => break Ok(()),
                Err(error) => break Err(error),
            }
            most = most.max(trajectory.integrator().stages());
        };
        let lengths: Vec<f64> = ends.windows(2).map(|t| t[1] - t[0]).collect();
        (lengths, most, result)
    };
    let options = || Options::new(tolerances.clone());
    let (free, most, _) = run(options());
    assert!(most == 7 && free.iter().any(|h| *h > 0.2), "{most} stages, {free:?}");
    let (short, _, _) = run(options().h_max(0.1).expect("positive"));
    assert!(short.iter().all(|h| *h < 0.1 + 1e-12) && short.len() >= 200);
    let (first, _, _) = run(options().h0(1e-5).expect("positive"));
    assert!((first[0] - 1e-5).abs() < 1e-16 && free[0] > 2e-5);
    let (careful, _, _) = run(options().safety(0.5).expect("inside"));
    assert!(careful.len() > free.len());
    for s in [3, 5, 7] {
        assert_eq!(run(options().stages(s, s).expect("a choice")).1, s);
    }
    let (tried, _, result) = run(options().max_steps(10).expect("some"));
    assert!(tried.len() <= 10 && matches!(result, Err(StepError::TooManySteps { limit: 10, .. })), "{result:?}");
    let (_, _, result) = run(options().h_min(0.3).expect("positive"));
    assert!(matches!(result, Err(StepError::BelowShortest { h_min: 0.3, .. })), "{result:?}");
}

/// A first step of 10 is rejected by the iteration, shorter ones by their errors.
#[test]
fn a_step_that_is_rejected_is_one_of_those_that_are_allowed() {
    let limit = 60;
    let options = Options::new(Tolerances::new(1e-8, 1e-8).expect("positive")).max_steps(limit);
    let options = options.and_then(|options| options.h0(10.0)).expect("positive");
    let mut method = Radau::new(field_of(VanDerPol { mu: 1.0 }), options).expect("valid");
    let run = Trajectory::new(&mut method, State::new(0.0, vec![2.0, 0.0]), 1e6, 1e6).expect("valid");
    let ended = run.observe(|_| {});
    assert!(matches!(ended, Err(StepError::TooManySteps { .. })), "{ended:?}");
    let (accepted, rejected) = (method.work().steps, method.rejected());
    assert!(rejected > 0 && accepted + rejected == limit, "{accepted} accepted, {rejected} rejected");
}

/// The steps that are allowed are those from one start: a second one has as many.
#[test]
fn another_start_has_all_its_steps() {
    let tolerances = Tolerances::new(1e-8, 1e-8).expect("positive");
    let field = field_of(VanDerPol { mu: 1.0 });
    let steps = |method: &mut Radau<_>| {
        let mut steps = 0;
        let run = Trajectory::new(method, State::new(0.0, vec![2.0, 0.0]), 20.0, 20.0).expect("valid");
        run.observe(|_| steps += 1).map(|_| steps)
    };
    let accepted = steps(&mut Radau::new(&field, Options::new(tolerances.clone())).expect("valid")).expect("few steps");
    let options = Options::new(tolerances).max_steps(2 * accepted - 1).expect("some");
    let mut method = Radau::new(&field, options).expect("valid");
    assert_eq!([(); 3].map(|()| steps(&mut method)), [(); 3].map(|()| Ok(accepted)));
}

/// A run that used up its steps goes on with as many, by whichever way it is resumed, and so does one that came to its end.
#[test]
fn a_run_that_is_resumed_has_all_its_steps() {
    let limit = 20;
    let options = Options::new(Tolerances::new(1e-8, 1e-8).expect("positive")).max_steps(limit).expect("some");
    let field = field_of!(1, |t, v, dv| dv[0] = -v[0] + (t * 30.0).cos());
    let method = Radau::new(field, options).expect("valid");
    let mut run = Trajectory::new(method, State::new(0.0, vec![1.0]), 10.0, 10.0).expect("valid");
    for resumed in 0..6 {
        let ended = loop {
            if let Err(error) = run.step() {
                break error;
            }
        };
        assert_eq!(ended, StepError::TooManySteps { t: run.state().t, limit }, "resumed {resumed} times");
        let tries = run.work().steps + run.integrator().rejected();
        assert_eq!(tries, (resumed + 1) * limit, "resumed {resumed} times");
        if resumed % 2 == 0 {
            run.resume(10.0, 10.0).expect("valid");
        } else {
            let (method, state) = run.into_parts();
            run = Trajectory::new(method, state, 10.0, 10.0).expect("valid");
        }
    }
    let to = run.state().t + 0.01;
    run.resume(10.0, to).expect("valid");
    while run.step().expect("few steps").is_some() {}
    let before = run.work().steps + run.integrator().rejected();
    run.resume(10.0, 10.0).expect("valid");
    while run.step().is_ok() {}
    assert_eq!(run.work().steps + run.integrator().rejected() - before, limit);
}

/// A component that starts at zero, and relative accuracy alone: v₂ ~ t³ stays accurate to rtol from the first step on.
#[test]
fn a_purely_relative_tolerance_takes_a_component_that_starts_at_zero() {
    let mut method = radau(field_of(Robertson { algebraic: false }), 1e-6, 0.0);
    let mut early = None;
    Trajectory::new(&mut method, State::new(0.0, vec![1.0, 0.0, 0.0]), 40.0, 40.0)
        .expect("valid")
        .observe(|state| {
            if early.is_none() && state.t > 0.0 {
                early = Some(state.clone());
            }
        })
        .expect("solvable");
    let early = early.expect("a step");
    let (truth, _) = solve(field_of(Robertson { algebraic: false }), &[1.0, 0.0, 0.0], early.t, 1e-12, 1e-40);
    for (v, exact) in early.q.iter().zip(&truth) {
        assert!((v - exact).abs() < 1e-5 * exact, "{v:e} and {exact:e} at {:e}", early.t);
    }
}

/// The tries of a run with a tolerance, from t = `start`, and where it ends.
fn tried(
    field: impl VectorField,
    (rtol, atol): (f64, f64),
    (start, v, end): (f64, f64, f64),
) -> (u64, Result<f64, StepError>) {
    // Steps from a thousandth of the least time to 1 that grow by a tenth each are some 7500.
    let options = Options::new(Tolerances::new(rtol, atol).expect("positive")).max_steps(20_000).expect("some");
    let mut method = Radau::new(field, options).expect("valid");
    let run = Trajectory::new(&mut method, State::new(start, vec![v]), end - start, end).expect("valid");
    let end = run.observe(|_| {}).map(|state| state.q[0]);
    (method.work().steps + method.rejected(), end)
}

const SMALL_TOLERANCES: [f64; 4] = [0.0, 5e-324, 1e-308, 1e-300];

/// No start is too small for a tolerance, and no solution becomes too small for it.
#[test]
fn what_decays_is_followed_down_to_zero() {
    let ends = |v: f64| [1.0, 600.0, 700.0, 740.0, 1e4].map(|end| (v, end));
    let small = [1e-290, 1e-299, 5e-301, 1e-305, f64::MIN_POSITIVE, 1e-312, 5e-324, 0.0, -1e-305].map(|v| (v, 1.0));
    for rtol in [1e-2, 1e-4, 1e-8, 1e-12, Tolerances::LEAST_RTOL] {
        for (atol, (v, end)) in SMALL_TOLERANCES
            .into_iter()
            .flat_map(|atol| [&ends(1.0)[..], &small].concat().into_iter().map(move |it| (atol, it)))
        {
            let case = format!("{rtol:e}, {atol:e}: from {v:e} to {end}");
            let (_, found) = tried(field_of!(1, |_t, v, dv| dv[0] = -v[0]), (rtol, atol), (0.0, v, end));
            let found = found.unwrap_or_else(|error| panic!("{case}: {error}"));
            let exact = v * (-end).exp();
            // The errors of all steps of a relative tolerance stay, of an absolute one they decay.
            let allowed = (1.0 + end) * rtol * exact.abs() + 10.0 * atol.max(f64::MIN_POSITIVE);
            assert!((found - exact).abs() <= 10.0 * allowed, "{case}: {found:e} for {exact:e}");
        }
    }
}

/// v = tᵏ and, of a forcing, v ~ t²/2.
#[test]
fn a_component_leaves_zero_with_a_relative_tolerance() {
    for rtol in [1e-4, 1e-8, 1e-12] {
        for atol in SMALL_TOLERANCES {
            for k in 1..=6 {
                let power = field_of!(1, k = f64::from(k); |t, v, dv| dv[0] = v[0] * 0.0 + k * t.powf(k - 1.0));
                let (_, found) = tried(power, (rtol, atol), (0.0, 0.0, 2.0));
                let found = found.unwrap_or_else(|error| panic!("{rtol:e}, {atol:e}: power {k}: {error}"));
                let exact = 2_f64.powi(k);
                assert!((found - exact).abs() <= 1e2 * rtol * exact, "{rtol:e}, {atol:e}: power {k}: {found}");
            }
            let forced = field_of!(1, |t, v, dv| dv[0] = -v[0] + t.sin());
            let (tries, found) = tried(forced, (rtol, atol), (0.0, 0.0, 2.0));
            let found = found.unwrap_or_else(|error| panic!("{rtol:e}, {atol:e}: forced: {error}"));
            let exact = 0.5 * (2_f64.sin() - 2_f64.cos() + (-2_f64).exp());
            assert!(
                (found - exact).abs() <= 1e2 * rtol * exact && tries < 1000,
                "{rtol:e}, {atol:e}: {found}, {tries} tries"
            );
        }
    }
}

/// Away from t = 0 times do not tell how late (t − 1)ᵏ is as small as that, k > 3: no step has three digits of it.
#[test]
fn a_component_that_leaves_zero_more_slowly_than_the_stages_tell_is_an_error_within_few_tries() {
    for k in 1..=6 {
        let power = field_of!(1, k = f64::from(k); |t, v, dv| dv[0] = v[0] * 0.0 + k * (t - 1.0).powf(k - 1.0));
        let (tries, found) = tried(power, (1e-8, 0.0), (1.0, 0.0, 2.0));
        match found {
            Ok(v) => assert!(k <= 3 && (v - 1.0).abs() < 1e-6, "power {k}: {v}"),
            Err(error) => {
                assert!(k > 3 && matches!(error, StepError::StepUnderflow { t: 1.0, .. }), "power {k}: {error}")
            }
        }
        assert!(tries < 100, "power {k}: {tries} tries");
    }
}

/// Equal systems side by side have the error norm, and the steps, of one.
#[test]
fn copies_of_a_system_take_the_steps_of_one() {
    struct Copies(usize);
    impl FieldFn for Copies {
        fn dim(&self) -> usize {
            2 * self.0
        }
        fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
            for (v, dv) in v.chunks(2).zip(dv.chunks_mut(2)) {
                VanDerPol { mu: 5.0 }.rhs(t, v, dv);
            }
        }
    }
    // When the order rises would hang on rounding.
    let run = |copies: usize| {
        let options = Options::new(Tolerances::new(1e-6, 1e-8).expect("positive")).stages(3, 3).expect("three");
        let method = Radau::new(field_of(Copies(copies)), options).expect("valid");
        let mut run = Trajectory::new(method, State::new(0.0, [2.0, 0.0].repeat(copies)), 10.0, 10.0).expect("valid");
        while run.step().expect("solvable").is_some() {}
        (run.state().q.clone(), run.work().steps)
    };
    let ((one, steps), (many, others)) = (run(1), run(20));
    // The error estimates of the first, short steps are off by their rounding, and few steps follow from them. A norm of the sum would
    // take a third more steps, as the error grows by √20 and has order 4.
    assert!(steps.abs_diff(others) <= 3, "{steps} and {others}");
    // The limit cycle attracts: the runs differ by what their tolerances leave.
    assert!(distance(&one, &many[38..]) < 1e-5);
}

/// Errors on van der Pol's limit cycle grow with the phase, by less than an order of magnitude up to t = 10.
#[test]
fn errors_are_near_the_tolerance() {
    let field = field_of(VanDerPol { mu: 1.0 });
    let (truth, _) = solve(&field, &[2.0, 0.0], 10.0, 1e-13, 1e-13);
    for tolerance in [1e-5, 1e-7, 1e-9] {
        let (end, _) = solve(&field, &[2.0, 0.0], 10.0, tolerance, tolerance);
        let error = distance(&end, &truth);
        assert!(error < 10.0 * tolerance, "{error:e} at {tolerance:e}");
    }
}

/// v₂ = v₁/(1 + v₁) + ¼ e^(−1000 t) follows v₁ = 3 e^(−t): where it goes on in a straight line the iteration converges at once, and a step later
/// the Jacobian is another one.
#[test]
fn what_follows_a_slow_component_is_solved_to_the_tolerance_in_every_step() {
    let field = lsvi::field!(2, |_t, v, dv| {
        let above = v[0] + 1.0;
        dv[0] = -v[0];
        dv[1] = v[1] * -1e3 + (v[0] * 999.0 + v[0] * v[0] * 1e3) / (above * above);
    });
    for (rtol, end) in [1e-3, 1e-4, 1e-5, 1e-6].into_iter().flat_map(|rtol| [2.0, 2.5, 3.0].map(|end| (rtol, end))) {
        let atol = 1e-3 * rtol;
        let run = Trajectory::new(radau(&field, rtol, atol), State::new(0.0, vec![3.0, 1.0]), end, end).expect("valid");
        let check = |state: &State| {
            let slow = 3.0 * (-state.t).exp();
            let exact = slow / (1.0 + slow) + 0.25 * (-1e3 * state.t).exp();
            let error = (state.q[1] - exact).abs() / (rtol * exact + atol);
            assert!(error <= 1.0, "{rtol:e} to {end}: {error:.1} tolerances at t = {}", state.t);
        };
        run.observe(check).expect("solvable");
    }
}

/// Increments left by Newton's iteration add up from step to step: where the grid makes steps shorter than the tolerance allows, each leaves
/// less. In 20 steps as long as that allows they are 20 · 0.03 tolerances.
#[test]
fn many_short_steps_do_not_add_up_what_the_iteration_leaves() {
    let pendulum = || lsvi::field!(2, |_t, v, dv| (dv[0], dv[1]) = (v[1], -v[0].sin()));
    let end = |h: f64, tolerance: f64| {
        let options =
            Options::new(Tolerances::new(tolerance, tolerance).expect("positive")).stages(7, 7).expect("a choice");
        let method = Radau::new(pendulum(), options).expect("valid");
        let run = Trajectory::new(method, State::new(0.0, vec![2.0, 0.0]), h, 20.0).expect("valid");
        run.observe(|_| {}).expect("solvable").q
    };
    let truth = end(20.0, 1e-13);
    for h in [0.5, 0.2, 0.1, 0.05] {
        let error = distance(&end(h, 1e-10), &truth);
        assert!(error <= 1e-10, "h = {h}: {error:e}");
    }
}

/// A mass on a spring that is four times as stiff on one side: half a turn takes π on the one and π/2 on the other.
struct Sides;
impl FieldFn for Sides {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[1];
        dv[1] = v[0] * if v[0].re() < 0.0 { -4.0 } else { -1.0 };
    }
}

/// The steps across the eight kinks of four turns err by τ, of 2 in units of the tolerance, each, and a spring makes twice that of an error of v
/// or x at most: 32 tolerances. An estimate vanishes for some places of a kink in its step, by chance, so that this is held of three quarters of
/// the tolerances; with estimates that are held to less the error is beyond it for three quarters.
#[test]
fn strict_tolerances_are_met_across_most_kinks() {
    let end = 6.0 * std::f64::consts::PI;
    let error = |tolerances: Tolerances| {
        let method = Radau::new(field_of(Sides), tolerances).expect("consistent");
        let run = Trajectory::new(method, State::new(0.0, vec![0.0, 1.0]), end, end).expect("valid");
        distance(&run.observe(|_| {}).expect("solvable").q, &[0.0, 1.0])
    };
    let quarter = 25;
    let (mut held, mut strict): (Vec<f64>, Vec<f64>) = (0..4 * quarter)
        .map(|k| {
            let tolerance = 10_f64.powf(-5.0 - 7.0 * k as f64 / (4 * quarter) as f64);
            let plain = Tolerances::new(tolerance, tolerance).expect("positive");
            (error(plain.clone()) / tolerance, error(plain.strict()) / tolerance)
        })
        .unzip();
    held.sort_by(f64::total_cmp);
    strict.sort_by(f64::total_cmp);
    let (most, least) = (strict[3 * quarter - 1], held[quarter]);
    assert!(most < 32.0 && least > 32.0, "{most:e} tolerances, {least:e} if not strict");
}

/// Where hλ ≫ 1 the error has the order of the estimate, and what the estimate is held to bounds it: 0.1 rtol^(2/3) of
/// 1 + |v| ≤ 2.
#[test]
fn stiff_transients_cost_no_more_than_smooth_solutions() {
    for lambda in [1e3, 1e6, 1e9] {
        for tolerance in [1e-4, 1e-8] {
            let field = field_of(ProtheroRobinson { lambda });
            let (end, steps) = solve(field, &[0.0], 10.0, tolerance, tolerance);
            let error = (end[0] - 10_f64.cos()).abs();
            assert!(error < 0.2 * tolerance.powf(2.0 / 3.0), "λ = {lambda:e}: {error:e} at {tolerance:e}");
            // An explicit method needs λ t/3 steps.
            assert!(steps < 300, "λ = {lambda:e}: {steps} steps");
        }
    }
}

/// Eight decades of time scales, as differential equations and with the conservation law as an algebraic one.
#[test]
fn robertson_with_and_without_the_algebraic_equation() {
    let start = [1.0, 0.0, 0.0];
    let (truth, _) = solve(field_of(Robertson { algebraic: false }), &start, 1e4, 1e-11, 1e-15);
    for algebraic in [false, true] {
        let (end, steps) = solve(field_of(Robertson { algebraic }), &start, 1e4, 1e-6, 1e-10);
        for (a, b) in end.iter().zip(&truth) {
            // Errors of the slow variables do not grow: a few tolerances.
            assert!((a - b).abs() <= 1e-5 * b.abs(), "{end:?} and {truth:?}");
        }
        assert!((end.iter().sum::<f64>() - 1.0).abs() < 1e-10);
        assert!(steps < 200, "{steps} steps");
    }
}

/// Dense, banded and sparse storage take the same steps; stiff van der Pol needs few factorizations.
#[test]
fn structures_agree_and_factors_are_reused() {
    let line = Line::new(20, 1.0, Walls::Dirichlet);
    let start: Vec<f64> = (1..=20).map(|i| (std::f64::consts::PI * f64::from(i) / 21.0).sin()).collect();
    let (banded, steps) = solve(&line, &start, 1.0, 1e-6, 1e-8);
    let pattern: Vec<(usize, usize)> = (1..20).flat_map(|i| [(i, i - 1), (i - 1, i)]).collect();
    for structure in [Structure::Dense, Structure::sparse(20, pattern).expect("inside")] {
        let (other, count) = solve(with_structure(structure, &line), &start, 1.0, 1e-6, 1e-8);
        assert_eq!(count, steps);
        // Roundoff of each stiff solve, some 40 steps of it.
        assert!(distance(&other, &banded) < 1e-12);
    }
    let mut method = radau(field_of(VanDerPol { mu: 1000.0 }), 1e-6, 1e-6);
    let end = Trajectory::new(&mut method, State::new(0.0, vec![2.0, 0.0]), 2000.0, 2000.0).expect("valid");
    end.observe(|_| {}).expect("solvable");
    let work = lsvi::Integrator::work(&method);
    assert!(work.steps < 700 && work.factorizations < work.steps + 2 * method.rejected(), "{work:?}");
}

#[test]
fn steps_end_at_stop_times_and_the_solution_is_dense() {
    let mut method = radau(field_of(ProtheroRobinson { lambda: 10.0 }), 1e-8, 1e-8);
    let stops = [3.0, 1.0, 1.25];
    method.stop_at(&stops).expect("finite");
    assert!(matches!(method.interpolate(0.0, &mut [0.0]), Err(InputError::Time(TimeError::NoStep { .. }))));
    assert!(matches!(method.stop_at(&[f64::NAN]), Err(InputError::System(SystemError::NonFinite { .. }))));
    method.stop_at(&stops).expect("finite");
    let (mut state, grid) = (State::new(0.0, vec![1.0]), lsvi::Grid::new(0.0, 0.7, 4.0).expect("valid"));
    let (mut ends, mut before) = (Vec::new(), 0.0);
    while grid.next(state.t).is_some() {
        lsvi::Integrator::advance(&mut method, &mut state, &grid).expect("solvable");
        assert!(state.t - before <= 0.7 + 1e-12);
        for k in 0..=4 {
            let t = before + (state.t - before) * 0.25 * f64::from(k);
            let mut v = [0.0];
            method.interpolate(t, &mut v).expect("inside the step");
            // The polynomial of degree 3 has its error |v⁗| h⁴/4! · max |Π (c − cᵢ)| of 0.02 on top of that of the ends.
            let allowed = 1e-7 + 0.02 / 24.0 * (state.t - before).powi(4);
            assert!((v[0] - t.cos()).abs() < allowed, "{} at t = {t}", v[0] - t.cos());
        }
        let mut v = [0.0];
        method.interpolate(state.t, &mut v).expect("the end");
        assert_eq!(v[0], state.q[0]);
        before = state.t;
        ends.push(state.t);
    }
    for stop in stops {
        assert!(ends.contains(&stop), "{stop} is not among {ends:?}");
    }
    assert_eq!(ends.last(), Some(&4.0));
    assert!(matches!(method.interpolate(4.1, &mut [0.0]), Err(InputError::Time(TimeError::Outside { .. }))));
    assert!(matches!(method.interpolate(-0.1, &mut [0.0]), Err(InputError::Time(TimeError::Outside { .. }))));
    assert!(matches!(method.interpolate(4.0, &mut []), Err(InputError::System(SystemError::Dimension { .. }))));
}

#[test]
fn what_cannot_be_solved_is_a_typed_error() {
    for bad in [0.0, -1e-6, f64::NAN, f64::INFINITY, 1e-15] {
        assert!(matches!(Tolerances::new(bad, 1e-6), Err(InputError::Setting(SettingError::RelativeTolerance { .. }))));
    }
    for bad in [-1e-6, f64::NAN, f64::INFINITY] {
        let each = Tolerances::new(1e-6, 0.0).expect("relative alone").with_atol(vec![1e-6, bad]);
        assert!(matches!(each, Err(InputError::Setting(SettingError::AbsoluteTolerance { index: 1, .. }))));
    }
    let three = Tolerances::new(1e-6, 0.0).and_then(|t| t.with_atol(vec![1e-6; 3])).expect("positive");
    assert!(matches!(
        Radau::new(field_of(BlowUp), three.clone()),
        Err(InputError::System(SystemError::Dimension { what: "atol", .. }))
    ));
    let options = Options::new(three);
    for bad in [0.0, -1.0, f64::NAN] {
        assert!(matches!(options.clone().h0(bad), Err(InputError::Setting(SettingError::Setting { what: "h0", .. }))));
        assert!(matches!(
            options.clone().h_max(bad),
            Err(InputError::Setting(SettingError::Setting { what: "h_max", .. }))
        ));
        assert!(matches!(
            options.clone().h_min(bad - 1.0),
            Err(InputError::Setting(SettingError::Setting { what: "h_min", .. }))
        ));
        assert!(matches!(
            options.clone().safety(bad + 1.0),
            Err(InputError::Setting(SettingError::Setting { what: "safety", .. }))
        ));
    }
    assert!(options.clone().max_steps(0).is_err());
    for (fewest, most) in [(4, 5), (5, 3), (3, 9), (1, 3)] {
        assert!(matches!(options.clone().stages(fewest, most), Err(InputError::Setting(SettingError::Stages { .. }))));
    }
    let mut state = State::new(0.0, vec![1.0]);
    let grid = lsvi::Grid::new(0.0, 2.0, 2.0).expect("valid");
    let mut method = radau(field_of(BlowUp), 1e-6, 1e-6);
    let error = loop {
        let before = state.clone();
        if let Err(error) = lsvi::Integrator::advance(&mut method, &mut state, &grid) {
            assert_eq!(state, before);
            break error;
        }
    };
    match error {
        StepError::StepUnderflow { t, h } => {
            assert!((t - 1.0).abs() < 1e-5 && h <= 8.0 * f64::EPSILON * t, "t = {t}, h = {h:e}");
        }
        StepError::Solve { t, source: SolveError::NonFinite, .. } => assert!((t - 1.0).abs() < 1e-5, "t = {t}"),
        other => panic!("{other}"),
    }
    let outside = As(Structure::Banded { lower: 0, upper: 0 }, VanDerPol { mu: 1.0 });
    let mut method = radau(field_of(outside), 1e-6, 1e-6);
    let mut state = State::new(0.0, vec![2.0, 0.0]);
    let error = lsvi::Integrator::advance(&mut method, &mut state, &grid).expect_err("an entry outside");
    assert!(matches!(error, StepError::Solve { source: SolveError::OutsideStructure { .. }, .. }), "{error}");
    let mut nan = State::new(0.0, vec![f64::NAN, 0.0]);
    let error = lsvi::Integrator::advance(&mut method, &mut nan, &grid).expect_err("not a number");
    assert!(matches!(error, StepError::Input(InputError::System(SystemError::NonFinite { .. }))), "{error}");
    // Where f itself overflows no step is to blame.
    let mut far = State::new(0.25, vec![1e200, 1.0]);
    let mut method = radau(field_of(VanDerPol { mu: 1.0 }), 1e-6, 1e-6);
    let error = lsvi::Integrator::advance(&mut method, &mut far, &grid).expect_err("infinite");
    assert_eq!(error, StepError::Solve { t: 0.25, h: 0.0, source: SolveError::NonFinite });
    assert!(error.to_string().starts_with("no step starts from the state at t = 0.25: "), "{error}");
}

/// v̇₀ = −v₀, and v₀ = v₁ in units in which it is a thousand times that.
struct Tied {
    mass: Mass,
}
impl FieldFn for Tied {
    fn dim(&self) -> usize {
        2
    }
    fn mass(&self) -> Mass {
        self.mass.clone()
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = -v[0];
        dv[1] = (v[0] - v[1]) * 1000.0;
    }
}

#[test]
fn a_start_off_an_algebraic_equation_is_refused_with_its_row() {
    let mut matrix = Jacobian::zeros(2);
    matrix.add(0, 0, 1.0);
    for mass in [Mass::Diagonal(vec![1.0, 0.0]), Mass::Matrix(matrix)] {
        let start = |v: f64| {
            let tolerances = Tolerances::new(1e-6, 1e-6).expect("positive");
            let method = Radau::new(field_of(Tied { mass: mass.clone() }), tolerances).expect("usable");
            Trajectory::new(method, State::new(0.0, vec![1.0, v]), 1.0, 1.0).expect("valid")
        };
        // 1000 (τ₀ + τ₁), τ = 1e-6 (1 + |v|).
        let expected = 1000.0 * 1e-6 * (2.0 + 6.0);
        match start(5.0).step() {
            Err(StepError::Input(InputError::System(SystemError::InconsistentStart { row, value, allowed }))) => {
                assert!(row == 1 && value == -4000.0 && (allowed - expected).abs() < 1e-15, "{value} {allowed}");
            }
            other => panic!("{other:?}"),
        }
        let off = |by: f64| start(1.0 + by).observe(|_| {});
        // Off by the tolerances of both is off by no more than they allow.
        for by in [0.0, 3.9e-6, -3.9e-6] {
            let end = off(by).expect("consistent");
            assert!((end.q[1] - (-1_f64).exp()).abs() < 1e-5, "{by:e}: {end:?}");
        }
        assert!(off(4.1e-6).is_err() && off(-4.1e-6).is_err());
    }
}

/// A run that goes on is not asked again, and one from another state is.
#[test]
fn a_start_is_looked_at_once() {
    let mass = Mass::Diagonal(vec![1.0, 0.0]);
    let tolerances = Tolerances::new(1e-10, 1e-12).expect("positive");
    let mut method = Radau::new(field_of(Tied { mass }), tolerances).expect("usable");
    let run = Trajectory::new(&mut method, State::new(0.0, vec![1.0, 1.0]), 0.1, 2.0).expect("valid");
    run.observe(|_| {}).expect("consistent");
    let moved = Trajectory::new(&mut method, State::new(2.0, vec![1.0, 1.1]), 0.1, 3.0).expect("valid");
    assert!(moved.observe(|_| {}).is_err());
}

#[test]
fn the_shortest_step_is_tried_before_the_tolerance_is_given_up() {
    let run = |options: Options, longest: f64| {
        let method = Radau::new(field_of!(1, |_t, v, dv| dv[0] = -v[0]), options).expect("usable");
        let mut steps = Vec::new();
        let mut last = 0.0;
        Trajectory::new(method, State::new(0.0, vec![1.0]), longest, 5.0)
            .expect("fits")
            .observe(|state| {
                steps.push(state.t - last);
                last = state.t;
            })
            .map(|end| (end, steps))
    };
    let options = |tolerance: f64| Options::new(Tolerances::new(tolerance, tolerance).expect("positive"));
    for (tolerance, h_min, h0) in [(1e-3, 0.02, None), (1e-2, 0.5, Some(0.1)), (1e-3, 0.02, Some(4.0))] {
        let mut options = options(tolerance).h_min(h_min).expect("finite");
        if let Some(h0) = h0 {
            options = options.h0(h0).expect("positive");
        }
        let (end, steps) = run(options, 10.0).expect("the tolerance can be met");
        assert!((end.q[0] - f64::exp(-5.0)).abs() <= tolerance, "{end:?}");
        // The last step may be shorter.
        let (_, most) = steps.split_at(1);
        assert!(most[..most.len() - 1].iter().all(|h| *h >= h_min * (1.0 - 1e-12)), "{steps:?}");
    }
    // The grid's steps are the longest, and below h_min what there is.
    run(options(1e-3).h_min(0.5).expect("finite"), 0.1).expect("short steps are asked for");
    let failed = run(options(1e-12).h_min(2.0).expect("finite"), 10.0);
    assert!(matches!(failed, Err(StepError::BelowShortest { h_min: 2.0, .. })), "{failed:?}");
}

/// Of 1.5 there is less than two shortest steps of 1; a first step of 10⁻⁶ is none at t = 1.7·10⁹, where times are 2·10⁻⁷ apart.
#[test]
fn steps_are_no_shorter_than_the_shortest_and_than_times_resolve() {
    let ends = |options: Options, start: f64, length: f64| {
        let decay = field_of!(1, |_t, v, dv| dv[0] = v[0] * -0.1);
        let method = Radau::new(decay, options).expect("valid");
        let mut ends = Vec::new();
        let run = Trajectory::new(method, State::new(start, vec![1.0]), length, start + length).expect("valid");
        let end = run.observe(|state| ends.push(state.t - start)).expect("smooth");
        assert!((end.q[0] - (-0.1 * length).exp()).abs() < 1e-2);
        ends
    };
    let options = || Options::new(Tolerances::new(1e-2, 1e-2).expect("positive"));
    assert_eq!(ends(options().h_min(1.0).and_then(|o| o.h0(1.0)).expect("positive"), 0.0, 1.5), [0.0, 1.0, 1.5]);
    let ends = ends(options().h0(1e-6).expect("positive"), 1.7e9, 10.0);
    assert_eq!(ends.last(), Some(&10.0));
}

/// v̇ = λv.
struct Grows(f64);

impl FieldFn for Grows {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[0] * self.0;
    }
}

#[test]
fn growth_beyond_all_times_is_not_passed_over() {
    // From t = 0 steps may be as short as they have to be.
    let run = |rate: f64| {
        let method = radau(field_of(Grows(rate)), 1e-6, 1e-9);
        Trajectory::new(method, State::new(0.0, vec![1.0]), 1.0, 1.0)
            .expect("valid")
            .observe(|_| {})
            .map(|end| end.q[0])
    };
    for rate in [1e20, 1e30, 1e200] {
        assert!(run(rate).is_err(), "{:?}", run(rate));
        let end = run(-rate).expect("stiff");
        assert!(end.abs() <= 1e-9, "{end:e}");
    }
}

/// Beside a rate of 10²¹ that acts on nothing, ẋ = 5x makes entries of 10⁻¹⁵ of their row, which no rounding has touched: such a matrix is not
/// singular, and steps are not halved for it.
#[test]
fn a_slow_component_beside_a_fast_one_in_other_units_takes_its_own_steps() {
    let predators = field_of!(2, half = 0.5; |_t, v, dv| {
        dv[0] = v[0] * (v[1] * -0.4 + 5.0);
        dv[1] = v[1] * (v[0] * half - 0.8);
    });
    for eaten in [0.0, 1e-100, 1e-10] {
        let start = State::new(0.0, vec![-2e21, eaten]);
        let mut run = Trajectory::new(radau(&predators, 1e-6, 1e-9), start, 2.0, 2.0).unwrap();
        let steps = (0..200).take_while(|_| run.step().unwrap().is_some()).count();
        assert!(steps < 200, "{eaten}: {steps}");
        approx::assert_relative_eq!(run.state().q[0], -2e21 * 10_f64.exp(), max_relative = 1e-4);
    }
}

#[test]
fn stops_that_lie_close_are_all_kept() {
    let mut method = radau(field_of(ProtheroRobinson { lambda: 1.0 }), 1e-6, 1e-6);
    // A thousand times what times near 1 are told apart by.
    let stops = [1.0, 1.0 + 1e-12, 2.0];
    method.stop_at(&stops).expect("finite");
    let (mut state, grid) = (State::new(0.0, vec![1.0]), lsvi::Grid::new(0.0, 3.0, 3.0).expect("valid"));
    let mut ends = Vec::new();
    while state.t < 3.0 {
        lsvi::Integrator::advance(&mut method, &mut state, &grid).expect("solvable");
        ends.push(state.t);
    }
    assert!(stops.iter().all(|stop| ends.contains(stop)), "{ends:?}");
}

#[test]
fn a_step_that_a_stop_cuts_does_not_shorten_the_next_one() {
    let mut method = radau(field_of(ProtheroRobinson { lambda: 1.0 }), 1e-6, 1e-6);
    let (mut state, grid) = (State::new(0.0, vec![1.0]), lsvi::Grid::new(0.0, 100.0, 100.0).expect("valid"));
    let mut advance = |method: &mut Radau<_>| {
        let before = state.t;
        lsvi::Integrator::advance(method, &mut state, &grid).expect("solvable");
        (state.t, state.t - before)
    };
    let (mut t, mut long) = (0.0, 0.0);
    (0..20).for_each(|_| (t, long) = advance(&mut method));
    method.stop_at(&[t + 1e-4 * long]).expect("finite");
    let (stop, cut) = advance(&mut method);
    assert!(stop == t + 1e-4 * long && cut < 1e-3 * long);
    // From the short step alone the controller would take one of a few of its lengths.
    let (_, next) = advance(&mut method);
    assert!(next >= 0.5 * long, "{next} after {long}");
}

/// v̇ = −λ (v − sin t) + cos t where λ jumps from 1 to 10⁴ at t = 5.
struct Stiffening;
impl FieldFn for Stiffening {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = (v[0] - t.sin()) * if t < 5.0 { -1.0 } else { -1e4 } + t.cos();
    }
}

/// v̇ = ±1 − v, which turns at 1, 2, …, 9: whether f has its new value at such a time or the old one, its pieces are smooth.
#[test]
fn a_jump_at_a_stop_costs_no_digits_on_whichever_side_f_has_its_value() {
    let exact = (0..10).fold(1.0, |v: f64, k| {
        let wave = if k % 2 == 0 { 1.0 } else { -1.0 };
        wave + (v - wave) * (-1_f64).exp()
    });
    for tolerance in [1e-6, 1e-10] {
        let tolerances = || Tolerances::new(tolerance, tolerance).expect("positive");
        let stops: Vec<f64> = (1..10).map(f64::from).collect();
        let run = |field: AnyField<'static>| {
            let mut method = Radau::new(field, tolerances()).expect("valid");
            method.stop_at(&stops).expect("finite");
            let mut run = Trajectory::new(method, State::new(0.0, vec![1.0]), 10.0, 10.0).expect("valid");
            while run.step().expect("solvable").is_some() {}
            ((run.state().q[0] - exact).abs(), run.integrator().work().steps)
        };
        let new =
            run(field_of!(1, |t, v, dv| dv[0] = -v[0] + if t.floor().rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 }));
        let old =
            run(field_of!(1, |t, v, dv| dv[0] =
                -v[0] + if (t.ceil() - 1.0).rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 }));
        // The last of ten pieces counts, and of those before e⁻¹, e⁻², … as much.
        assert!(new.0 < 2.0 * tolerance && old.0 < 2.0 * tolerance, "{tolerance}: {new:?} {old:?}");
        // The rate at the start of a piece is its own.
        assert!(new.1 <= old.1, "{tolerance}: {new:?} {old:?}");
    }
}

#[test]
fn an_old_jacobian_is_renewed_before_the_step_is_made_shorter() {
    let tolerances = Tolerances::new(1e-6, 1e-6).expect("positive");
    // Equal steps from the first on, which share factors.
    let options = Options::new(tolerances).stages(3, 3).and_then(|options| options.h0(0.01)).expect("a choice");
    let mut method = Radau::new(field_of(Stiffening), options).expect("valid");
    method.stop_at(&[5.0]).expect("finite");
    // Off the slow solution by 5e-6 at t = 5, well within what estimates are held to, a tenth of 1e-4, and beyond what the iteration is.
    let mut run = Trajectory::new(method, State::new(0.0, vec![7e-4]), 0.01, 10.0).expect("valid");
    while run.state().t < 5.0 {
        run.step().expect("solvable");
    }
    let rejected = run.integrator().rejected();
    run.step().expect("solvable");
    // The iteration with the Jacobian of λ = 1 diverges once, and not with that of 10⁴ for the same step.
    assert_eq!(run.integrator().rejected() - rejected, 1);
}

/// v̇ = −λ (v − 10 t) from off its slow solution: the estimate filtered at the time of the step's start knows that the
/// transient is over at its end.
/// Steps shrink a thousand times toward each jump of van der Pol's equation. What an error foretells of the next is heeded whatever the
/// rounding of times makes of a step, and few are in vain.
#[test]
fn few_steps_toward_a_jump_are_rejected() {
    for (tolerance, part) in [(1e-3, 0.3), (1e-5, 0.2), (1e-8, 0.1)] {
        let mut method = radau(field_of(VanDerPol { mu: 1000.0 }), tolerance, tolerance);
        let run = Trajectory::new(&mut method, State::new(0.0, vec![2.0, 0.0]), 2000.0, 2000.0).expect("valid");
        run.observe(|_| {}).expect("solvable");
        let (rejected, steps) = (method.rejected() as f64, lsvi::Integrator::work(&method).steps as f64);
        assert!(rejected < part * steps, "{tolerance}: {rejected} of {steps}");
    }
}

#[test]
fn a_first_step_over_a_stiff_transient_is_accepted() {
    let field = field_of!(1, |t, v, dv| dv[0] = (v[0] - 10.0 * t) * -1e6);
    let options = Options::new(Tolerances::new(1e-3, 1e-3).expect("positive")).h0(1.0).expect("positive");
    let mut method = Radau::new(field, options).expect("valid");
    let end = Trajectory::new(&mut method, State::new(0.0, vec![1.0]), 1.0, 1.0).expect("valid").observe(|_| {});
    let end = end.expect("solvable");
    assert_eq!((method.rejected(), lsvi::Integrator::work(&method).steps), (0, 1));
    // The slow solution is 10 t − 10/λ.
    assert!((end.q[0] - 10.0).abs() < 1e-3, "{}", end.q[0]);
}

/// Robertson's second component is drawn to its slow value within 10⁻³; f at the start tells a first step of a quarter. The unit of
/// time does not matter.
#[test]
fn a_fast_transient_is_seen_before_the_first_step() {
    for unit in [1.0, 1e-6, 1e9] {
        for tolerance in [1e-5, 1e-6, 1e-7] {
            let robertson = field_of!(3, unit = unit; |_t, v, dv| {
                let (decay, back, pair) = (v[0] * 0.04, v[1] * v[2] * 1e4, v[1] * v[1] * 3e7);
                dv[0] = (back - decay) / unit;
                dv[1] = (decay - back - pair) / unit;
                dv[2] = pair / unit;
            });
            let end = 40.0 * unit;
            let method = radau(robertson, tolerance, tolerance);
            let mut run = Trajectory::new(method, State::new(0.0, vec![1.0, 0.0, 0.0]), end, end).expect("valid");
            let first = run.step().expect("solvable").expect("a step").t / unit;
            let rejected = run.integrator().rejected();
            assert!(rejected <= 2, "{rejected} rejected before a step of {first}, unit {unit}, {tolerance:e}");
            assert!((1e-5..2e-3).contains(&first), "{first}, unit {unit}, {tolerance:e}");
        }
    }
}

/// What grows is little beside what decays, and large beside what is tolerated of it.
#[test]
fn growth_is_told_in_units_of_what_is_tolerated() {
    let field = field_of!(2, |_t, v, dv| {
        dv[0] = v[0];
        dv[1] = v[1] * -2.0;
    });
    let tolerances = Tolerances::new(1e-12, 1.0).and_then(|t| t.with_atol(vec![1e-6, 1e3])).expect("positive");
    let method = Radau::new(field, tolerances).expect("valid");
    let mut run = Trajectory::new(method, State::new(0.0, vec![1e-7, 1.0]), 40.0, 40.0).expect("valid");
    let first = run.step().expect("solvable").expect("a step").t;
    // v₀ would change by what is tolerated in 14 units of time, in which it grows by e¹⁴.
    assert!(run.integrator().rejected() == 0 && (1.0..4.0).contains(&first), "{first}");
}

/// What decays within a thousandth of the first step, and is little, is no reason for a shorter one.
#[test]
fn a_little_that_decays_fast_does_not_shorten_the_first_step() {
    let field = field_of!(1, |_t, v, dv| dv[0] = v[0] * -1e6);
    let mut run = Trajectory::new(radau(field, 1e-6, 1e-3), State::new(0.0, vec![1e-6]), 1.0, 1.0).expect("valid");
    // v changes by what is tolerated in a thousandth of a unit of time.
    let first = run.step().expect("solvable").expect("a step").t;
    assert!((0.99e-3..1.01e-3).contains(&first), "{first}");
}

/// A rate that grows with time is seen where the first step would end, and cuts it by the power s + 1 = 4.
#[test]
fn the_first_step_is_cut_by_what_it_would_lead_to() {
    let field = field_of!(1, |t, _v, dv| dv[0] = (t * 5e3).exp().into());
    let method = Radau::new(field, Tolerances::new(1e-12, 1e-3).expect("positive")).expect("valid");
    let mut run = Trajectory::new(method, State::new(0.0, vec![1e-6]), 1.0, 1.0).expect("valid");
    // v changes by what is tolerated in 1e-3, in which v̇ changes by e⁵ − 1 times 1/1e-3 in units of it.
    let cut = 1e-3 * (0.01 / (5_f64.exp() - 1.0)).powf(0.25);
    let first = run.step().expect("solvable").expect("a step").t;
    assert!((first / cut - 1.0).abs() < 1e-6, "{first:e}, {cut:e}");
}

#[test]
fn the_order_waits_for_ten_steps_after_a_fall() {
    let mut falls = 0;
    for (mu, tolerance) in [(1e3, 1e-4), (1e3, 1e-6), (1e3, 1e-8), (1e2, 1e-6), (1e2, 1e-8), (1e5, 1e-6)] {
        let method = radau(field_of(VanDerPol { mu }), tolerance, tolerance);
        let mut run = Trajectory::new(method, State::new(0.0, vec![2.0, 0.0]), 4.0 * mu, 4.0 * mu).expect("valid");
        let mut stages = vec![3];
        while run.step().expect("solvable").is_some() {
            stages.push(run.integrator().stages());
        }
        for k in (1..stages.len()).filter(|&k| stages[k] < stages[k - 1]) {
            falls += 1;
            // The step of the fall is the first of the ten, if the order fell before it.
            let rise = (k + 1..stages.len()).find(|&j| stages[j] > stages[j - 1]);
            assert!(rise.is_none_or(|rise| rise - k >= 9), "μ = {mu}: {:?}", &stages[k - 1..]);
        }
    }
    assert!(falls > 0, "nothing was seen");
}

/// v̇ = −λ (v − φ) + φ̇ with φ = 3 + cos ωt, in steps of up to a period: an estimate that vanishes by chance counts for a tenth of what
/// the one before foretells. Here that keeps errors within ten times what estimates are held to, and without it they are 18 to 46 times that.
#[test]
fn an_estimate_that_vanishes_by_chance_does_not_lose_a_forcing() {
    for (lambda, omega, tolerance) in [(350.0, 5.0, 1e-10), (500.0, 20.0, 1e-7), (700.0, 10.0, 1e-8)] {
        let phi = move |t: f64| 3.0 + (omega * t).cos();
        let field = field_of!(1, lambda = lambda, omega = omega; |t, v, dv| {
            dv[0] = (v[0] - 3.0 - (omega * t).cos()) * -lambda - omega * (omega * t).sin();
        });
        let run = Trajectory::new(radau(field, tolerance, tolerance), State::new(0.0, vec![4.0]), 10.0, 10.0);
        let mut worst = 0.0_f64;
        run.expect("valid")
            .observe(|state| {
                let tau = tolerance * (1.0 + state.q[0]);
                let held = 0.1 * tau.powf(4.0 / 7.0) * state.q[0].powf(3.0 / 7.0);
                worst = worst.max((state.q[0] - phi(state.t)).abs() / held);
            })
            .expect("solvable");
        assert!(worst <= 10.0, "λ = {lambda}, ω = {omega}, {tolerance:e}: {worst}");
    }
}

/// v̇ = v, whose solution shows every difference between the time that steps add up to and the time that is told.
#[test]
fn steps_far_from_zero_are_as_long_as_the_times_tell() {
    let growth = || field_of!(1, |_t, v, dv| dv[0] = v[0]);
    for start in [0.0, 1.0, 1.7e9, -1.7e9, 1e12] {
        let method = Radau::new(growth(), Tolerances::new(1e-12, 0.0).expect("usable")).expect("usable");
        let mut run = Trajectory::new(method, State::new(start, vec![1.0]), 1e-2, start + 4.0).expect("valid");
        let mut worst = 0.0_f64;
        while let Some(state) = run.step().expect("smooth") {
            worst = worst.max((state.q[0] / (state.t - start).exp() - 1.0).abs());
        }
        assert!(worst <= 1e-11, "from t = {start}: {worst:e}");
        // The times of a few steps have fewer digits, so that the factors change, and then no more.
        let factorizations = run.work().factorizations;
        assert!(factorizations <= 60, "from t = {start}: {factorizations} for {} steps", run.work().steps);
    }
}

#[test]
fn a_stop_is_made_however_far_the_end() {
    for end in [1.0, 1e13, 1e300] {
        let mut method =
            Radau::new(field_of!(1, |_t, v, dv| dv[0] = -v[0]), Tolerances::new(1e-6, 1e-9).expect("usable"))
                .expect("usable");
        method.stop_at(&[0.01, 0.02]).expect("finite");
        let mut run = Trajectory::new(method, State::new(0.0, vec![1.0]), end, end).expect("valid");
        let mut times = Vec::new();
        while times.last().is_none_or(|t| *t < 0.02) {
            times.push(run.step().expect("smooth").expect("not the end").t);
        }
        assert!(times.contains(&0.01) && times.ends_with(&[0.02]), "{end:e}: {times:?}");
    }
}

/// The Jacobian of logistic growth changes little in a step and is kept; from another start it is another one, and so are the factors, of a
/// first step as long as the last one too.
#[test]
fn a_run_from_another_start_is_that_of_a_new_method() {
    let method = |is_regular: bool| {
        let field = field_of!(1, |_t, v, dv| dv[0] = (v[0] * -1.0 + 1.0) * v[0]);
        let options = Options::new(Tolerances::new(1e-6, 1e-6).expect("positive"));
        let regular = |options: Options| options.h0(0.0625)?.h_max(0.0625);
        let options = if is_regular { regular(options).expect("positive") } else { options };
        Radau::new(field, options).expect("valid")
    };
    let run = |method: &mut Radau<_>, v: f64| {
        let before = lsvi::Integrator::work(method);
        let run = Trajectory::new(&mut *method, State::new(0.0, vec![v]), 0.1, 1.0).expect("valid");
        let end = run.observe(|_| {}).expect("solvable").q;
        let after = lsvi::Integrator::work(method);
        (end, after.residuals - before.residuals, after.factorizations - before.factorizations)
    };
    for is_regular in [false, true] {
        let mut used = method(is_regular);
        run(&mut used, 0.9);
        assert_eq!(run(&mut used, -0.1), run(&mut method(is_regular), -0.1), "{is_regular}");
    }
}

#[test]
fn the_last_step_ends_where_it_ends() {
    let field = field_of!(1, |_t, v, dv| dv[0] = -v[0]);
    let options = Options::new(Tolerances::new(1e-6, 1e-6).expect("positive"));
    let mut run = Trajectory::new(Radau::new(field, options).expect("valid"), State::new(0.0, vec![1.0]), 10.0, 10.0)
        .expect("valid");
    run.step().expect("solvable");
    let (end, mut v) = (run.state().t, [0.0]);
    assert!(lsvi::Integrator::path(run.integrator(), end, &mut v).is_some_and(|it| it.is_ok()));
    for beyond in [1e-3, 1e-9] {
        let path = lsvi::Integrator::path(run.integrator(), end * (1.0 + beyond), &mut v);
        assert!(path.is_some_and(|it| it.is_err()), "{beyond}");
    }
}

/// M = [[2, 1], [1, 2]] has no algebraic row, whatever f is at the start.
#[test]
fn a_mass_with_entries_beside_its_diagonal_is_no_constraint() {
    struct Coupled;
    impl lsvi::VectorField for Coupled {
        fn dim(&self) -> usize {
            2
        }
        fn mass(&self) -> Mass {
            Mass::Matrix(Jacobian::try_from(nalgebra::dmatrix![2.0, 1.0; 1.0, 2.0]).expect("square"))
        }
        fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
            (dv[0], dv[1]) = (-2.0 * v[0] - v[1], -v[0] - 2.0 * v[1]);
        }
        fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
            [(0, 0, -2.0), (0, 1, -1.0), (1, 0, -1.0), (1, 1, -2.0)]
                .into_iter()
                .for_each(|(i, j, x)| out.add(i, j, scale * x));
        }
    }
    let options = Options::new(Tolerances::new(1e-8, 1e-8).expect("positive"));
    let method = Radau::new(Coupled, options).expect("valid");
    let run = Trajectory::new(method, State::new(0.0, vec![1.0, 3.0]), 1.0, 1.0).expect("valid");
    let end = run.observe(|_| {}).expect("a start like any other").q;
    assert!((end[0] - (-1_f64).exp()).abs() < 1e-7 && (end[1] - 3.0 * (-1_f64).exp()).abs() < 1e-7, "{end:?}");
}

/// v̇ = ±k vᵖ, which has no value on the other side of its start: the estimate of a long first step may lead there, where its filter finds none.
#[test]
fn an_estimate_that_has_no_value_passes_no_step() {
    struct Edge {
        rate: f64,
        power: f64,
    }
    impl lsvi::VectorField for Edge {
        fn dim(&self) -> usize {
            1
        }
        fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
            let is_inside = v[0] > 0.0 && (v[0] - 1.0) * self.rate >= 0.0;
            dv[0] = if is_inside { self.rate * v[0].powf(self.power) } else { f64::NAN };
        }
        fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
            out.add(0, 0, scale * self.rate * self.power * v[0].powf(self.power - 1.0));
        }
    }
    let rates = [1.0, 10.0, 100.0, 1e4].into_iter().flat_map(|k| [k, -k]);
    let fields = rates.flat_map(|rate| [-2.0, -1.0, 0.5, 2.0, 3.0, 5.0].map(|power| Edge { rate, power }));
    let (mut wrong, mut steps) = (Vec::new(), 0);
    for Edge { rate, power } in fields.filter(|it| it.rate < 0.0 || it.power < 1.0) {
        for h in [0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 10.0] {
            let options = Options::new(Tolerances::new(1e-8, 1e-10).expect("positive")).h0(h).expect("positive");
            let method = Radau::new(Edge { rate, power }, options).expect("valid");
            let mut run = Trajectory::new(method, State::new(0.0, vec![1.0]), 10.0, 10.0).expect("valid");
            let Ok(Some(state)) = run.step() else { continue };
            steps += 1;
            let exact = (1.0 + rate * (1.0 - power) * state.t).powf((1.0 - power).recip());
            let is_right = (state.q[0] - exact).abs() <= 1e-7 * exact.max(1.0);
            if !is_right {
                wrong.push(format!("{rate} v^{power}, h = {h}: {state:?} where {exact} is right"));
            }
        }
    }
    assert!(wrong.is_empty() && steps > 100, "{steps} steps, {} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn a_stop_beyond_the_end_of_the_grid_is_none() {
    let tolerances = Tolerances::new(1e-6, 1e-9).expect("positive");
    let mut method = Radau::new(field_of!(1, |_t, v, dv| dv[0] = -v[0]), tolerances).expect("valid");
    method.stop_at(&[3.0]).expect("finite");
    let mut run = Trajectory::new(method, State::new(0.0, vec![1.0]), 10.0, 1.0).expect("valid");
    while run.step().expect("solved").is_some() {}
    assert_eq!(run.state().t, 1.0);
    assert!((run.state().q[0] - (-1.0_f64).exp()).abs() < 1e-5, "{:?}", run.state());
}

#[test]
fn strict_tolerances_stay_so_with_others_for_each_component() {
    let strict = Tolerances::new(1e-6, 1e-6).expect("positive").strict();
    assert_eq!(strict.clone().with_atol(vec![1e-6]).expect("positive"), strict);
}

#[test]
fn stop_times_take_the_place_of_those_before() {
    let mut method = radau(lsvi::field!(1, |_t, v, dv| dv[0] = v[0] * -1e-3), 1e-6, 1e-6);
    method.stop_at(&[0.3]).expect("a time");
    method.stop_at(&[0.7]).expect("a time");
    let mut ends = Vec::new();
    let run = Trajectory::new(method, State::new(0.0, vec![1.0]), 1.0, 1.0).expect("valid");
    run.observe(|state| ends.push(state.t)).expect("solvable");
    assert!(ends.contains(&0.7) && !ends.contains(&0.3), "{ends:?}");
}

/// v̇ = −v^p, or from a time on −2 v^p, that says to be linear and autonomous, or does not; its Jacobian is exact.
struct Said {
    power: i32,
    from: f64,
    is_linear: bool,
    /// Evaluations of f and of its Jacobian.
    calls: [std::sync::atomic::AtomicUsize; 2],
}

impl Said {
    fn new(power: i32, from: f64, is_linear: bool) -> Self {
        Self { power, from, is_linear, calls: Default::default() }
    }

    fn rate(&self, t: f64) -> f64 {
        if t < self.from { -1.0 } else { -2.0 }
    }

    fn count(&self, which: usize) {
        self.calls[which].fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    }
}

impl VectorField for Said {
    fn dim(&self) -> usize {
        1
    }
    fn is_linear(&self) -> bool {
        self.is_linear
    }
    fn is_autonomous(&self) -> bool {
        self.is_linear
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.count(0);
        dv[0] = self.rate(t) * v[0].powi(self.power);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.count(1);
        out.add(0, 0, scale * self.rate(t) * f64::from(self.power) * v[0].powi(self.power - 1));
    }
}

/// A step of three stages evaluates f at its start, at the stages and once more at its end; the error is as small as by an iteration that knows nothing.
#[test]
fn one_increment_solves_a_linear_step() {
    let run = |is_linear: bool| {
        let field = Said::new(1, f64::INFINITY, is_linear);
        let options = Options::new(Tolerances::new(1e-8, 1e-8).expect("positive")).stages(3, 3).expect("a choice");
        let method = Radau::new(&field, options).expect("valid");
        let mut run = Trajectory::new(method, State::new(0.0, vec![1.0]), 5.0, 5.0).expect("valid");
        while run.step().expect("solvable").is_some() {}
        let error = (run.state().q[0] * 5_f64.exp() - 1.0).abs();
        let [f, jacobian] = field.calls.each_ref().map(|calls| calls.load(std::sync::atomic::Ordering::Relaxed) as u64);
        assert!(jacobian <= run.work().factorizations);
        (run.work().steps, f, error)
    };
    let (steps, f, error) = run(true);
    // A first step looks one step ahead, and iterates from nothing.
    assert!(f <= 5 * steps + 5, "{f} evaluations in {steps} steps");
    let (steps, f, iterated) = run(false);
    assert!(f > 6 * steps, "{f} evaluations in {steps} steps");
    assert!(error <= 2.0 * iterated.max(1e-8), "{error:e} and {iterated:e}");
}

/// What says to be linear and is not is iterated on as any other: from the start, and where another rate begins at a time that no step is told of.
#[test]
fn what_only_says_to_be_linear_is_solved_all_the_same() {
    for (power, from) in [(2, f64::INFINITY), (3, f64::INFINITY), (1, 2.5), (2, 2.5)] {
        for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
            let end = |is_linear: bool| {
                let field = Said::new(power, from, is_linear);
                solve(field, &[1.0], 10.0, tolerance, tolerance).0[0]
            };
            let late = (10.0 - from).max(0.0);
            let exact = match power {
                1 => (-10.0 - late).exp(),
                _ => (1.0 + f64::from(power - 1) * (10.0 + late)).powf(-f64::from(power - 1).recip()),
            };
            let [said, honest] = [true, false].map(|is_linear| (end(is_linear) - exact).abs());
            // A step across a jump has an error of the order of what its estimate is held to.
            let held = if from < 10.0 { tolerance.max(0.1 * tolerance.powf(2.0 / 3.0)) } else { tolerance };
            assert!(said <= 3.0 * honest.max(held), "v^{power} from {from} at {tolerance:e}: {said:e}, {honest:e}");
        }
    }
}

/// v̇ = −(1 + sin²(πt/T)) v, which says to be linear with an A that is the same after T: steps of T would find nothing wrong at their ends.
#[test]
fn a_matrix_that_goes_round_in_a_step_is_not_passed_over() {
    const PERIOD: f64 = 0.1;
    struct Round;
    impl VectorField for Round {
        fn dim(&self) -> usize {
            1
        }
        fn is_linear(&self) -> bool {
            true
        }
        fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
            dv[0] = -(1.0 + (std::f64::consts::PI * t / PERIOD).sin().powi(2)) * v[0];
        }
        fn add_jacobian(&self, t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
            out.add(0, 0, -scale * (1.0 + (std::f64::consts::PI * t / PERIOD).sin().powi(2)));
        }
    }
    for tolerance in [1e-2, 1e-4, 1e-6] {
        let options = Options::new(Tolerances::new(tolerance, tolerance).expect("positive"));
        let method = Radau::new(Round, options.h_max(PERIOD).expect("positive")).expect("valid");
        let end = Trajectory::new(method, State::new(0.0, vec![1.0]), 1.0, 1.0).expect("valid").observe(|_| {});
        let error = (end.expect("solvable").q[0] - (-1.5_f64).exp()).abs();
        assert!(error <= tolerance, "{error:e} at {tolerance:e}");
    }
}

/// v̇ = k (1 − v) until t = 1 and v̇ = 2 − v from there, which says to be linear and autonomous: what a fast rate leaves of an increment is next
/// to nothing, and must not be taken for convergence where the rate has fallen.
#[test]
fn a_rate_that_falls_is_not_passed_over() {
    struct Valve(f64);
    impl VectorField for Valve {
        fn dim(&self) -> usize {
            1
        }
        fn is_linear(&self) -> bool {
            true
        }
        fn is_autonomous(&self) -> bool {
            true
        }
        fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
            dv[0] = if t < 1.0 { self.0 * (1.0 - v[0]) } else { 2.0 - v[0] };
        }
        fn add_jacobian(&self, t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
            out.add(0, 0, if t < 1.0 { -scale * self.0 } else { -scale });
        }
    }
    for (k, tolerance) in [1e3, 1e4, 1e6, 1e10].into_iter().flat_map(|k| [1e-2, 1e-4, 1e-6].map(|tol| (k, tol))) {
        let mut method = radau(Valve(k), tolerance, tolerance);
        method.stop_at(&[1.0]).expect("finite");
        let end = Trajectory::new(method, State::new(0.0, vec![0.0]), 5.0, 5.0).expect("valid").observe(|_| {});
        let error = (end.expect("solvable").q[0] - (2.0 - (-4_f64).exp())).abs();
        assert!(error <= 30.0 * tolerance, "{error:e} at {tolerance:e} with k = {k:e}");
    }
}
