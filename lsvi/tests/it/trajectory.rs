//! The solution between the steps, at given times and at the zeros of functions, against exact solutions.

use crate::systems::Oscillator;
use crate::systems::{AnyField, field_of, lagrangian_of};
use approx::assert_abs_diff_eq;
use lsvi::adaptive::{Options, Radau, Tolerances};
use lsvi::classic::{Bdf2, RungeKutta, Tableau};
use lsvi::discrete::{Galerkin, PathFitted, Trapezoidal};
use lsvi::quadrature::NodeFamily;
use lsvi::{
    AutoLagrangian, Crossing, FieldFn, Grid, InputError, Integrator, LagrangianFn, Mass, Scalar, State, StepError,
    SystemError, TimeError, Trajectory, Window, Work, method_i, position_momentum,
};

/// m v̇ = m (v₁, −v₀): (cos t, −sin t) from (1, 0).
#[derive(Clone, Copy)]
struct Circle {
    mass: f64,
}
impl FieldFn for Circle {
    fn dim(&self) -> usize {
        2
    }
    fn mass(&self) -> Mass {
        if self.mass == 1.0 { Mass::Identity } else { Mass::Diagonal(vec![self.mass; 2]) }
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[1] * self.mass;
        dv[1] = v[0] * -self.mass;
    }
}

fn circle() -> AnyField<'static> {
    field_of(Circle { mass: 1.0 })
}

/// The largest error of q₀ = cos t between the steps of size h up to t = 2.
fn largest_error(method: &mut dyn Integrator, h: f64) -> f64 {
    let mut q = vec![0.0; method.dim()];
    q[0] = 1.0;
    let mut trajectory = Trajectory::new(method, State::new(0.0, q.clone()), h, 2.0).expect("valid");
    let (mut before, mut largest) = (0.0, 0.0_f64);
    while let Some(t) = trajectory.step().expect("solvable").map(|state| state.t) {
        for part in [0.1, 0.3, 0.5, 0.7, 0.9] {
            let t = before + part * (t - before);
            trajectory.interpolate(t, &mut q).expect("inside");
            largest = largest.max((q[0] - t.cos()).abs());
        }
        before = t;
    }
    largest
}

type Made<'a> = Box<dyn Fn() -> Box<dyn Integrator + 'a> + 'a>;

/// Methods with the order p of their states.
fn methods() -> Vec<(&'static str, u32, Made<'static>)> {
    let tableau = |tableau: fn() -> Tableau| -> Made<'static> {
        Box::new(move || Box::new(RungeKutta::new(circle(), tableau()).expect("usable")))
    };
    let galerkin = |degree: usize| -> Made<'static> {
        Box::new(move || {
            let discrete = Galerkin::gauss(lagrangian_of(Oscillator), degree).expect("s ≥ 1");
            Box::new(position_momentum(discrete))
        })
    };
    vec![
        ("implicit Euler", 1, tableau(Tableau::implicit_euler)),
        ("trapezoidal rule", 2, tableau(Tableau::trapezoidal)),
        ("rk4", 4, tableau(Tableau::rk4)),
        ("bdf2", 2, Box::new(|| Box::new(Bdf2::new(circle()).expect("usable")))),
        ("method I", 2, Box::new(|| Box::new(method_i(circle()).expect("usable")))),
        ("method I with a mass", 2, Box::new(|| Box::new(method_i(field_of(Circle { mass: 3.0 })).expect("usable")))),
        ("Störmer–Verlet", 2, Box::new(|| Box::new(position_momentum(Trapezoidal::new(lagrangian_of(Oscillator)))))),
        ("galerkin(2)", 4, galerkin(2)),
        ("galerkin(4)", 8, galerkin(4)),
        (
            "path-fitted(3)",
            4,
            Box::new(|| {
                let l = lagrangian_of(Oscillator);
                Box::new(position_momentum(PathFitted::on(l, NodeFamily::Gauss, 3).expect("m ≥ 2")))
            }),
        ),
        (
            "window of 1",
            2,
            Box::new(|| {
                let field = lsvi::LeastSquares::new(circle()).expect("usable");
                Box::new(Window::new(Trapezoidal::new(field), 1).expect("some"))
            }),
        ),
    ]
}

#[test]
fn the_dense_output_of_every_method_has_the_order_of_its_states_up_to_four() {
    for (name, order, make) in methods() {
        let errors = [0.1, 0.05, 0.025].map(|h| largest_error(&mut *make(), h));
        let measured = (errors[1] / errors[2]).log2();
        let expected = f64::from(order.min(4));
        // The next term of the error is smaller by h = 0.025.
        assert!((measured - expected).abs() < 0.15, "{name}: order {measured} from {errors:?}");
    }
}

/// Simpson's rule, which is rk4 where f does not depend on v, ends where t, t² and t³ do, and a cubic is its own interpolant.
#[test]
fn the_path_along_a_cubic_is_the_cubic() {
    let powers = field_of!(3, |t, _v, dv| {
        dv[0] = T::from(1.0);
        dv[1] = T::from(2.0 * t);
        dv[2] = T::from(3.0 * t * t);
    });
    let method = RungeKutta::new(powers, Tableau::rk4()).expect("usable");
    let (h, mut q) = (0.5, [0.0; 3]);
    let mut run = Trajectory::new(method, State::new(1.0, vec![1.0; 3]), h, 2.0).expect("valid");
    while let Some(end) = run.step().expect("explicit").map(|state| state.t) {
        for part in [0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0] {
            let t = end - part * h;
            run.interpolate(t, &mut q).expect("inside");
            for (power, q) in (1..).zip(&q) {
                // A dozen roundings of numbers up to 2³.
                assert_abs_diff_eq!(*q, t.powi(power), epsilon = 12.0 * 4.0 * f64::EPSILON);
            }
        }
    }
}

/// s stages at steps of one size: the polynomial of degree s has order s + 1 between its nodes.
#[test]
fn the_collocation_polynomial_has_one_order_more_than_stages() {
    for s in [3, 5, 7] {
        let errors = [1.0, 0.5].map(|h| {
            let options = Options::new(Tolerances::new(1.0, 1.0).expect("positive")).stages(s, s).expect("a choice");
            let mut method = Radau::new(circle(), options.h0(h).expect("positive")).expect("valid");
            largest_error(&mut method, h)
        });
        let measured = (errors[0] / errors[1]).log2();
        assert!((measured - s as f64 - 1.0).abs() < 0.6, "{s} stages: order {measured} from {errors:?}");
    }
}

/// q = cos t falls through 0 at π/2, 5π/2 … and rises at 3π/2; the error of a zero is that of the path, |q̇| being 1.
#[test]
fn zeros_are_found_to_the_order_of_the_path() {
    use std::f64::consts::PI;
    let run = |h: f64, crossing: Crossing| {
        let method = RungeKutta::new(circle(), Tableau::rk4()).expect("usable");
        let mut trajectory = Trajectory::new(method, State::new(0.0, vec![1.0, 0.0]), h, 9.0).expect("valid");
        let mut zeros = Vec::new();
        while let Some(event) = trajectory.until(|_, v| v[0], crossing).expect("solvable") {
            // A rounding of t ≤ 9.
            assert!(event.q[0].abs() < 4e-15, "{}", event.q[0]);
            zeros.push(event.t);
        }
        zeros
    };
    let (falling, rising) = ([0.5 * PI, 2.5 * PI], [1.5 * PI]);
    for (crossing, exact) in [
        (Crossing::Falling, falling.to_vec()),
        (Crossing::Rising, rising.to_vec()),
        (Crossing::Any, vec![0.5 * PI, 1.5 * PI, 2.5 * PI]),
    ] {
        let errors = [0.2, 0.1].map(|h| {
            let zeros = run(h, crossing);
            assert_eq!(zeros.len(), exact.len(), "{zeros:?}");
            zeros.iter().zip(&exact).fold(0.0, |m: f64, (t, exact)| m.max((t - exact).abs()))
        });
        let order = (errors[0] / errors[1]).log2();
        // The place of a zero within its step changes with h, and the share of the cubic in the error with it.
        assert!(errors[1] < 1e-4 && (order - 4.0).abs() < 1.0, "{crossing:?}: order {order} from {errors:?}");
    }
}

#[test]
fn the_zero_of_an_adaptive_run_keeps_its_tolerance() {
    let method = Radau::new(circle(), Tolerances::new(1e-10, 1e-10).expect("positive")).expect("valid");
    let mut trajectory = Trajectory::new(method, State::new(0.0, vec![1.0, 0.0]), 0.2, 9.0).expect("valid");
    let t = trajectory.until(|_, v| v[0], Crossing::Any).expect("solvable").expect("a zero").t;
    // Three stages at h = 0.2 at the most: max |Π (c − cᵢ)| h⁴/4! of 1.3e-6, on top of the tolerance.
    assert!((t - std::f64::consts::FRAC_PI_2).abs() < 2e-6, "{t}");
}

#[test]
fn an_error_is_the_last_of_the_states() {
    let ending = field_of!(1, |t, _v, dv| dv[0] = T::from(if t >= 1.0 { f64::NAN } else { 1.0 }));
    let method = RungeKutta::new(ending, Tableau::rk4()).expect("usable");
    let states = Trajectory::new(method, State::new(0.0, vec![0.0]), 0.4, 2.0).expect("valid").states();
    // Of a run that would go on failing no more than a few are asked for.
    let found: Vec<bool> = states.take(9).map(|state| state.is_ok()).collect();
    assert_eq!(found, [true, true, false]);
}

/// Times where a step ends get the state itself; others the dense output; wrong lists are refused before a step is taken.
#[test]
fn sampled_times_are_exact_where_steps_end() {
    let start = || {
        let method = RungeKutta::new(circle(), Tableau::rk4()).expect("usable");
        Trajectory::new(method, State::new(0.0, vec![1.0, 0.0]), 0.25, 2.0).expect("valid")
    };
    let states: Vec<State> = start().states().collect::<Result<_, _>>().expect("solvable");
    let times = [0.0, 0.25, 0.3, 0.3, 1.0, 1.9, 2.0];
    let mut seen = Vec::new();
    let mut trajectory = start();
    trajectory.sample(&times, |t, q| seen.push((t, q.to_vec()))).expect("solvable");
    assert_eq!(seen.len(), times.len());
    for ((t, q), wanted) in seen.iter().zip(times) {
        assert_eq!(*t, wanted);
        match states.iter().find(|state| state.t == wanted) {
            Some(state) => assert_eq!(*q, state.q),
            // h⁴/384 of the cubic and h⁴ t/120 of rk4, and a tenth for the next terms.
            None => {
                let allowed = 1.1 * 0.25_f64.powi(4) * (1.0 / 384.0 + wanted / 120.0);
                assert!((q[0] - wanted.cos()).abs() < allowed, "{q:?} at {wanted}");
            }
        }
    }
    for bad in [[0.5, 0.4], [-0.1, 0.5], [0.5, 2.1], [0.5, f64::NAN]] {
        let mut trajectory = start();
        let error = trajectory.sample(&bad, |_, _| panic!("nothing is shown")).expect_err("refused");
        assert!(matches!(error, StepError::Input(InputError::Time(TimeError::SaveTime { .. }))), "{error}");
        assert_eq!(trajectory.state().t, 0.0);
    }
}

#[test]
fn a_step_that_failed_has_no_times_within() {
    let method = RungeKutta::new(field_of!(1, |_t, v, dv| dv[0] = v[0] * v[0]), Tableau::implicit_euler());
    let mut run = Trajectory::new(method.expect("usable"), State::new(0.0, vec![1.0]), 0.2, 2.0).expect("valid");
    run.step().expect("solvable");
    run.interpolate(0.1, &mut [0.0]).expect("within the step");
    while run.step().is_ok() {}
    let t = run.state().t;
    let refused = run.interpolate(t, &mut [0.0]);
    assert!(matches!(refused, Err(StepError::Input(InputError::Time(TimeError::NoStep { .. })))), "{refused:?}");
}

#[test]
fn what_lies_outside_the_last_step_is_refused() {
    let method = RungeKutta::new(circle(), Tableau::rk4()).expect("usable");
    let mut trajectory = Trajectory::new(method, State::new(0.0, vec![1.0, 0.0]), 0.5, 2.0).expect("valid");
    let input = |result: Result<(), StepError>| match result {
        Err(StepError::Input(error)) => error,
        other => panic!("{other:?}"),
    };
    assert!(matches!(input(trajectory.interpolate(0.0, &mut [0.0; 2])), InputError::Time(TimeError::NoStep { .. })));
    trajectory.step().expect("solvable");
    trajectory.step().expect("solvable");
    for t in [0.4, 1.1, f64::NAN] {
        assert!(matches!(input(trajectory.interpolate(t, &mut [0.0; 2])), InputError::Time(TimeError::Outside { .. })));
    }
    assert!(matches!(
        input(trajectory.interpolate(0.7, &mut [0.0])),
        InputError::System(SystemError::Dimension { .. })
    ));
    let refused = trajectory.until(|_, _| f64::NAN, Crossing::Any).map(|_| ());
    assert!(matches!(input(refused), InputError::System(SystemError::NonFinite { .. })));
    let backward = Trajectory::new(method_i(circle()).expect("usable"), State::new(1.0, vec![1.0, 0.0]), 0.1, 0.0);
    assert!(matches!(backward, Err(InputError::Time(TimeError::EndTime { .. }))));
}

/// A method that says nothing of its rate has states, and a typed error between them.
#[test]
fn a_method_without_a_rate_says_so() {
    struct Still;
    impl Integrator for Still {
        fn dim(&self) -> usize {
            1
        }
        fn advance(&mut self, state: &mut State, grid: &Grid) -> Result<(), StepError> {
            if let Some(step) = grid.next(state.t) {
                state.t += step.h;
            }
            Ok(())
        }
        fn work(&self) -> Work {
            Work::default()
        }
    }
    let mut trajectory = Trajectory::new(Still, State::new(0.0, vec![1.0]), 0.5, 1.0).expect("valid");
    trajectory.step().expect("a step");
    let error = trajectory.interpolate(0.2, &mut [0.0]).expect_err("no rate");
    assert!(matches!(error, StepError::Input(InputError::Time(TimeError::NoRate))), "{error}");
    trajectory.interpolate(0.5, &mut [0.0]).expect("a state");
}

/// Steps of h to t = 1 and on to 2 are those to 2 at once, which also a method with a memory has to know.
#[test]
fn a_run_goes_on_after_its_end_as_if_it_had_none() {
    let tolerances = || Tolerances::new(1e-6, 1e-6).expect("positive");
    let methods: [fn() -> Box<dyn Integrator>; 3] = [
        || Box::new(method_i(circle()).expect("usable")),
        || Box::new(Bdf2::new(circle()).expect("usable")),
        || Box::new(RungeKutta::new(circle(), Tableau::rk4()).expect("usable")),
    ];
    for (i, method) in methods.iter().enumerate() {
        let start = || State::new(0.0, vec![1.0, 0.0]);
        let whole = Trajectory::new(method(), start(), 0.125, 2.0).expect("valid").observe(|_| {}).expect("solvable");
        let mut parts = Trajectory::new(method(), start(), 0.125, 1.0).expect("valid");
        while parts.step().expect("solvable").is_some() {}
        parts.resume(0.125, 2.0).expect("later");
        while parts.step().expect("solvable").is_some() {}
        assert_eq!(*parts.state(), whole, "{i}");
        parts.resume(0.3, 2.9).expect("later");
        assert_eq!(parts.step().expect("solvable").expect("not at the end").t, 2.3, "{i}");
        parts.resume(0.3, 2.3).expect("here");
        let refused = [parts.resume(0.125, 1.0), parts.resume(0.0, 3.0), parts.resume(0.1, f64::NAN)];
        assert!(refused.iter().all(Result::is_err));
        assert!(parts.step().expect("at the end").is_none(), "a refused end is none");
    }
    let method = Radau::new(circle(), tolerances()).expect("usable");
    let mut run = Trajectory::new(method, State::new(0.0, vec![1.0, 0.0]), 1.0, 1.0).expect("valid");
    while run.step().expect("solvable").is_some() {}
    let reached = run.state().clone();
    let (method, state) = run.into_parts();
    assert!(state == reached && state.t == 1.0, "{state:?}");
    let end = Trajectory::new(method, state, 1.0, 2.0).expect("valid").observe(|_| {}).expect("solvable");
    // The tolerance, with room for its growth along two units of time.
    assert!((end.q[0] - 2_f64.cos()).abs() < 1e-5, "{}", end.q[0]);
}

#[test]
fn a_run_goes_on_after_an_error_with_a_shorter_step() {
    let growth = field_of!(1, |_t, v, dv| dv[0] = v[0] * v[0]);
    let method = RungeKutta::new(growth, Tableau::implicit_euler()).expect("usable");
    let mut run = Trajectory::new(method, State::new(0.0, vec![1.0]), 0.3, 0.5).expect("valid");
    let error = run.step().expect_err("no next state for steps above a quarter");
    assert!(matches!(error, StepError::Solve { t: 0.0, .. }), "{error}");
    run.resume(0.01, 0.5).expect("shorter");
    while run.step().expect("solvable").is_some() {}
    assert!((run.state().q[0] - 2.0).abs() < 0.1, "{}", run.state().q[0]);
}

/// Between the quarters of a step of 1 from 0, at 0.3 and 0.8, and on one of them or the end of a step.
#[test]
fn every_zero_within_a_step_is_found_also_where_it_is_one_of_the_times_looked_at() {
    let still = || {
        let method = RungeKutta::new(field_of!(1, |_t, _v, dv| dv[0] = T::from(1.0)), Tableau::rk4());
        Trajectory::new(method.expect("usable"), State::new(0.0, vec![0.0]), 1.0, 3.0).expect("valid")
    };
    let zeros = |g: &dyn Fn(f64) -> f64, crossing: Crossing| {
        let (mut run, mut zeros) = (still(), Vec::new());
        while let Some(event) = run.until(|t, _| g(t), crossing).expect("solvable") {
            zeros.push(event.t);
        }
        zeros
    };
    let twice = |t: f64| (t - 0.3) * (t - 0.8);
    for (crossing, expected) in
        [(Crossing::Any, vec![0.3, 0.8]), (Crossing::Falling, vec![0.3]), (Crossing::Rising, vec![0.8])]
    {
        let found = zeros(&twice, crossing);
        // A rounding of t.
        let is_same = found.len() == expected.len() && found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 4e-16);
        assert!(is_same, "{crossing:?}: {found:?}");
    }
    for zero in [0.25, 1.0, 1.5, 2.0] {
        assert_eq!(zeros(&|t| t - zero, Crossing::Rising), [zero]);
        assert_eq!(zeros(&|t| t - zero, Crossing::Any), [zero]);
        assert_eq!(zeros(&|t| zero - t, Crossing::Falling), [zero]);
        assert_eq!(zeros(&|t| zero - t, Crossing::Any), [zero]);
        assert!(zeros(&|t| t - zero, Crossing::Falling).is_empty());
    }
}

#[test]
fn times_within_the_last_step_can_be_sampled() {
    let method = RungeKutta::new(circle(), Tableau::rk4()).expect("usable");
    let mut run = Trajectory::new(method, State::new(0.0, vec![1.0, 0.0]), 0.5, 2.0).expect("valid");
    run.step().expect("solvable");
    run.step().expect("solvable");
    let mut seen = Vec::new();
    run.sample(&[0.5, 0.7, 1.0, 1.2], |t, q| seen.push((t, q[0]))).expect("from the start of the last step on");
    assert_eq!(seen.iter().map(|(t, _)| *t).collect::<Vec<_>>(), [0.5, 0.7, 1.0, 1.2]);
    for (t, q) in seen {
        // h⁴/384 of the cubic and h⁴ t/120 of rk4, and a tenth for the next terms.
        let allowed = 1.1 * 0.5_f64.powi(4) * (1.0 / 384.0 + t / 120.0);
        assert!((q - t.cos()).abs() < allowed, "{q} at {t}");
    }
}

#[test]
fn a_method_with_a_memory_starts_anew_from_a_state_that_was_changed() {
    let methods: [fn() -> Box<dyn Integrator>; 2] = [
        || Box::new(Bdf2::new(circle()).expect("usable")),
        || Box::new(Radau::new(circle(), Tolerances::new(1e-6, 1e-6).expect("positive")).expect("usable")),
    ];
    let changes: [fn(&mut State); 2] = [|state| state.q[0] += 0.1, |state| state.t = 1.25];
    let grid = Grid::new(0.0, 0.25, 2.0).expect("valid");
    for (i, method) in methods.iter().enumerate() {
        for (j, change) in changes.iter().enumerate() {
            let mut used = method();
            let mut state = State::new(0.0, vec![1.0, 0.0]);
            (0..3).for_each(|_| used.advance(&mut state, &grid).expect("solvable"));
            change(&mut state);
            let mut fresh = state.clone();
            used.advance(&mut state, &grid).expect("solvable");
            method().advance(&mut fresh, &grid).expect("solvable");
            assert_eq!(state, fresh, "method {i}, change {j}");
        }
    }
}

#[test]
fn the_dense_output_of_an_integrator_in_a_box_is_its_own() {
    let method = || {
        let circle = field_of!(2, |_t, v, dv| {
            dv[0] = v[1];
            dv[1] = -v[0];
        });
        Radau::new(circle, Tolerances::new(1e-6, 1e-6).expect("usable")).expect("usable")
    };
    let values = |method: Box<dyn Integrator>| {
        let mut run = Trajectory::new(method, State::new(0.0, vec![1.0, 0.0]), 3.0, 3.0).expect("valid");
        let mut values = Vec::new();
        run.sample(&[0.7, 1.9, 2.6], |_, v| values.extend_from_slice(v)).expect("solvable");
        values
    };
    let mut own = Vec::new();
    let mut run = Trajectory::new(method(), State::new(0.0, vec![1.0, 0.0]), 3.0, 3.0).expect("valid");
    run.sample(&[0.7, 1.9, 2.6], |_, v| own.extend_from_slice(v)).expect("solvable");
    assert_eq!(values(Box::new(method())), own);
    assert_eq!(values(Box::new(Box::new(method()) as Box<dyn Integrator>)), own);
}

/// v̇ = 2t, on which BDF2 is exact in steps of any size.
#[test]
fn bdf2_goes_on_in_steps_of_another_size() {
    let field = lsvi::field!(1, |t, _v, dv| dv[0] = (2.0 * t).into());
    let mut run =
        Trajectory::new(lsvi::classic::Bdf2::new(field).expect("valid"), State::new(0.0, vec![0.0]), 0.2, 1.0)
            .expect("valid");
    while run.step().expect("solvable").is_some() {}
    run.resume(0.05, 2.0).expect("valid");
    while run.step().expect("solvable").is_some() {}
    // The first step of all, by another method, is off by roundings at most too.
    assert!((run.state().q[0] - 4.0).abs() < 1e-12, "{}", run.state().q[0]);
}

/// The unit circle in time units of 1 to 10⁻¹⁴ of its own, 100 steps to a radian: cubics are off by (hω)⁴/384 = 2.6e-11.
#[test]
fn dense_output_of_a_motion_is_the_same_in_every_unit_of_time() {
    struct Slow(f64);
    impl LagrangianFn for Slow {
        fn dim(&self) -> usize {
            1
        }
        fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
            v[0] * v[0] * (0.5 * self.0 * self.0) - q[0] * q[0] * 0.5
        }
    }
    for unit in [1.0, 1e8, 1e14] {
        let method = Galerkin::gauss(AutoLagrangian::new(Slow(unit)), 4).expect("s ≥ 1");
        let start = State::new(0.0, vec![1.0]).with_momentum(vec![0.0]);
        let mut run = Trajectory::new(position_momentum(method), start, 0.01 * unit, 2.0 * unit).expect("usable");
        let times: Vec<f64> = (0..400).map(|k| f64::from(k) * 0.005 * unit).collect();
        run.sample(&times, |t, q| assert_abs_diff_eq!(q[0], (t / unit).cos(), epsilon = 3e-11)).expect("solvable");
    }
}
