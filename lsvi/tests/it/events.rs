//! Events: the state at the zero of a function, restarts on the zero itself, and sections of mechanical motions.

use crate::systems::Oscillator;
use crate::systems::{field_of, lagrangian_of};
use lsvi::adaptive::{Radau, Tolerances};
use lsvi::classic::{Bdf2, CoupledRungeKutta, RungeKutta, Tableau};
use lsvi::discrete::{Galerkin, Trapezoidal};
use lsvi::{
    AutoConstraint, Constrained, ConstraintFn, Crossing, FieldFn, Integrator, LagrangianFn, Mass, Scalar, State,
    Trajectory, method_i, position_momentum,
};

/// Gravity 9.81 on height and speed.
fn fall() -> impl lsvi::VectorField {
    field_of!(2, |_t, v, dv| {
        dv[0] = v[1];
        dv[1] = T::from(-9.81);
    })
}

#[test]
fn a_crossing_soon_after_a_start_on_the_zero_is_found() {
    // The first is within a step of 0.05 by four decades, the last beyond its first quarter.
    for speed in [1e-5, 0.01, 0.1, 0.2] {
        for height in [0.0, 1e-18, -1e-18] {
            let method = RungeKutta::new(fall(), Tableau::rk4()).expect("usable");
            let start = State::new(0.0, vec![height, speed]);
            let mut run = Trajectory::new(method, start, 0.05, 5.0).expect("valid");
            for crossing in [Crossing::Falling, Crossing::Any] {
                let mut run = Trajectory::new(run.integrator_mut(), State::new(0.0, vec![height, speed]), 0.05, 5.0)
                    .expect("valid");
                let hit = run.until(|_, v| v[0], crossing).expect("solvable").expect("it falls back");
                let (exact, shift) = (2.0 * speed / 9.81, height.abs() / speed);
                assert!((hit.t - exact).abs() < 1e-12 * exact + 2.0 * shift, "{speed} {height:e}: {} {exact}", hit.t);
            }
            assert!(run.until(|_, v| v[0], Crossing::Rising).expect("solvable").is_none(), "the start is no crossing");
        }
    }
}

#[test]
fn a_ball_that_bounces_comes_to_its_place_at_every_impact() {
    // Restarted where it is found, the n-th flight takes eⁿ times the first.
    let (mut e, mut time) = (2.0 * (20.0 / 9.81_f64).sqrt(), (20.0 / 9.81_f64).sqrt());
    let mut state = State::new(0.0, vec![10.0, 0.0]);
    for bounce in 0..25 {
        let method = RungeKutta::new(fall(), Tableau::rk4()).expect("usable");
        let mut run = Trajectory::new(method, state, 0.05, 60.0).expect("valid");
        let hit = run.until(|_, v| v[0], Crossing::Falling).expect("solvable").expect("an impact").clone();
        assert!((hit.t - time).abs() < 1e-12 * time, "impact {bounce} at {}, not {time}", hit.t);
        e *= 0.7;
        time += e;
        state = State::new(hit.t, vec![hit.q[0], -0.7 * hit.q[1]]);
    }
}

/// An error by step size.
type ErrorOf<'a> = Box<dyn Fn(f64) -> f64 + 'a>;

/// A method made anew.
type Made<'a> = Box<dyn Fn() -> Box<dyn Integrator> + 'a>;

/// The largest errors of the time, of q and of p where q = cos t falls through 0.3.
fn error_of_event(method: impl Integrator, h: f64, with_momentum: bool) -> f64 {
    let mut q = vec![0.0; method.dim()];
    q[0] = 1.0;
    let mut run = Trajectory::new(method, State::new(0.0, q), h, 9.0).expect("valid");
    let mut largest = 0.0_f64;
    for turn in 0..2 {
        let hit = run.until(|_, q| q[0] - 0.3, Crossing::Falling).expect("solvable").expect("a crossing");
        let exact = 0.3_f64.acos() + f64::from(turn) * std::f64::consts::TAU;
        largest = largest.max((hit.t - exact).abs()).max((hit.q[0] - 0.3).abs());
        let rate = if with_momentum { hit.p[0] } else { hit.q[1] };
        largest = largest.max((rate + exact.sin()).abs());
    }
    largest
}

#[test]
fn the_state_at_an_event_has_the_order_of_the_method() {
    let circle = || {
        field_of!(2, |_t, v, dv| {
            dv[0] = v[1];
            dv[1] = -v[0];
        })
    };
    let l = || lagrangian_of(Oscillator);
    let gauss = |h: f64, s: usize| error_of_event(position_momentum(Galerkin::gauss(l(), s).expect("s")), h, true);
    let r = 15_f64.sqrt();
    let a = [
        vec![5.0 / 36.0, 2.0 / 9.0 - r / 15.0, 5.0 / 36.0 - r / 30.0],
        vec![5.0 / 36.0 + r / 24.0, 2.0 / 9.0, 5.0 / 36.0 - r / 24.0],
        vec![5.0 / 36.0 + r / 30.0, 2.0 / 9.0 + r / 15.0, 5.0 / 36.0],
    ];
    let (b, c) = ([5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0], [0.5 - r / 10.0, 0.5, 0.5 + r / 10.0]);
    let coupled = |h: f64| error_of_event(CoupledRungeKutta::new(circle(), &a, &b, &c).expect("usable"), h, false);
    let cases: [(&str, f64, f64, ErrorOf<'_>); 8] = [
        ("Störmer–Verlet", 2.0, 0.1, Box::new(|h| error_of_event(position_momentum(Trapezoidal::new(l())), h, true))),
        ("Galerkin 2", 4.0, 0.1, Box::new(|h| gauss(h, 2))),
        ("Galerkin 3", 6.0, 0.4, Box::new(|h| gauss(h, 3))),
        ("Galerkin 4", 8.0, 0.8, Box::new(|h| gauss(h, 4))),
        ("three Gauss stages", 6.0, 0.4, Box::new(coupled)),
        ("Method I", 2.0, 0.1, Box::new(|h| error_of_event(method_i(circle()).expect("usable"), h, false))),
        ("bdf2", 2.0, 0.1, Box::new(|h| error_of_event(Bdf2::new(circle()).expect("usable"), h, false))),
        (
            "rk4",
            4.0,
            0.1,
            Box::new(|h| error_of_event(RungeKutta::new(circle(), Tableau::rk4()).expect("usable"), h, false)),
        ),
    ];
    for (name, order, h, error) in cases {
        let errors = [error(h), error(0.5 * h)];
        let measured = (errors[0] / errors[1]).log2();
        // The place of an event within its step changes with h, and the share of that step's error with it.
        assert!((measured - order).abs() < 0.5, "{name}: order {measured} from {errors:?}");
    }
}

/// Hénon–Heiles.
struct Stars;
impl LagrangianFn for Stars {
    fn dim(&self) -> usize {
        2
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        let potential = (q[0] * q[0] + q[1] * q[1]) * 0.5 + q[0] * q[0] * q[1] - q[1] * q[1] * q[1] * (1.0 / 3.0);
        (v[0] * v[0] + v[1] * v[1]) * 0.5 - potential
    }
}

#[test]
fn points_of_a_section_lie_on_the_energy_surface() {
    let energy = |q: &[f64], p: &[f64]| {
        let potential = 0.5 * (q[0] * q[0] + q[1] * q[1]) + q[0] * q[0] * q[1] - q[1].powi(3) / 3.0;
        0.5 * (p[0] * p[0] + p[1] * p[1]) + potential
    };
    let start = State::new(0.0, vec![0.0, 0.1]).with_momentum(vec![0.4, 0.1]);
    let expected = energy(&start.q, &start.p);
    let method = position_momentum(Galerkin::gauss(lagrangian_of(Stars), 4).expect("s"));
    let mut run = Trajectory::new(method, start, 0.25, 200.0).expect("valid");
    let mut points = 0;
    while let Some(point) = run.until(|_, q| q[0], Crossing::Rising).expect("solvable") {
        let error = (energy(&point.q, &point.p) - expected).abs();
        // Order 8 with steps of 1/25 of a period, and the energy of a method that keeps a nearby one.
        assert!(point.q[0].abs() < 1e-14 && point.p[0] > 0.0 && error < 1e-10, "{point:?}: {error:e}");
        points += 1;
    }
    assert!((25..=40).contains(&points), "{points} returns");
}

/// A unit circle for a pendulum.
struct Ring;
impl ConstraintFn for Ring {
    fn dim(&self) -> usize {
        2
    }
    fn count(&self) -> usize {
        1
    }
    fn constraint<T: Scalar>(&self, q: &[T], out: &mut [T]) {
        out[0] = q[0] * q[0] + q[1] * q[1] - 1.0;
    }
}
struct Bob;
impl LagrangianFn for Bob {
    fn dim(&self) -> usize {
        2
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        (v[0] * v[0] + v[1] * v[1]) * 0.5 - q[1]
    }
}

#[test]
fn an_event_of_a_constrained_motion_is_on_the_constraint() {
    let method = Constrained::new(Galerkin::gauss(lagrangian_of(Bob), 2).expect("s"), AutoConstraint::new(Ring));
    let mut run = Trajectory::new(method.expect("fits"), State::new(0.0, vec![1.0, 0.0]), 0.1, 5.0).expect("valid");
    let hit = run.until(|_, q| q[0], Crossing::Falling).expect("solvable").expect("the lowest point");
    // ½ p² = 1 from a height of 1, to order 4 in 0.1.
    assert!(hit.q[0].abs() < 1e-14 && (hit.q[1] + 1.0).abs() < 1e-13, "{hit:?}");
    assert!((hit.p[0] + 2_f64.sqrt()).abs() < 1e-5 && hit.p[1].abs() < 1e-13, "{hit:?}");
}

/// An event changes the run in no more than roundings.
#[test]
fn a_run_goes_on_after_an_event_as_if_it_had_none() {
    let methods: [fn() -> Box<dyn Integrator>; 4] = [
        || Box::new(position_momentum(Galerkin::gauss(lagrangian_of(Oscillator), 2).expect("s"))),
        || Box::new(position_momentum(Trapezoidal::new(lagrangian_of(Oscillator)))),
        || Box::new(Bdf2::new(field_of!(1, |_t, v, dv| dv[0] = -v[0])).expect("usable")),
        || {
            let tolerances = Tolerances::new(1e-6, 1e-6).expect("positive");
            Box::new(Radau::new(field_of!(1, |_t, v, dv| dv[0] = -v[0]), tolerances).expect("usable"))
        },
    ];
    for (i, method) in methods.iter().enumerate() {
        let start = || Trajectory::new(method(), State::new(0.0, vec![1.0]), 0.1, 4.0).expect("valid");
        let plain = start().observe(|_| {}).expect("solvable");
        let mut run = start();
        let mut events = 0;
        while run.until(|_, q| q[0] - 0.4, Crossing::Any).expect("solvable").is_some() {
            events += 1;
        }
        assert!(events > 0);
        assert!((run.state().q[0] - plain.q[0]).abs() < 1e-14 && run.state().t == 4.0, "{i}");
    }
}

/// v̇₀ = −v₀ with v₁ = 2 v₀, an equation without a rate.
#[derive(Clone)]
struct Algebraic {
    mass: Mass,
}
impl FieldFn for Algebraic {
    fn dim(&self) -> usize {
        2
    }
    fn mass(&self) -> Mass {
        self.mass.clone()
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = -v[0];
        dv[1] = v[0] * 2.0 - v[1];
    }
}

#[test]
fn algebraic_components_have_a_dense_output_too() {
    let mut full = lsvi::Jacobian::zeros(2);
    full.add(0, 0, 1.0);
    for mass in [Mass::Diagonal(vec![1.0, 0.0]), Mass::Matrix(full)] {
        let field = || field_of(Algebraic { mass: mass.clone() });
        let tableau = |tableau| -> Box<dyn Integrator> { Box::new(RungeKutta::new(field(), tableau).expect("usable")) };
        let methods: [(&str, f64, Made<'_>); 5] = [
            ("implicit Euler", 1.0, Box::new(|| tableau(Tableau::implicit_euler()))),
            ("sdirk2", 2.0, Box::new(|| tableau(Tableau::sdirk2()))),
            ("trapezoidal", 2.0, Box::new(|| tableau(Tableau::trapezoidal()))),
            ("bdf2", 2.0, Box::new(|| Box::new(Bdf2::new(field()).expect("usable")))),
            (
                "two Radau stages",
                2.0,
                Box::new(|| {
                    let a = [vec![5.0 / 12.0, -1.0 / 12.0], vec![0.75, 0.25]];
                    let method = CoupledRungeKutta::new(field(), &a, &[0.75, 0.25], &[1.0 / 3.0, 1.0]);
                    Box::new(method.expect("usable"))
                }),
            ),
        ];
        for (name, order, method) in methods {
            let error = |h: f64| {
                let start = State::new(0.0, vec![1.0, 2.0]);
                let mut run = Trajectory::new(method(), start.clone(), h, 2.0).expect("valid");
                let mut largest = 0.0_f64;
                let times: Vec<f64> = (0..).map(|k| (f64::from(k) + 0.4) * h).take_while(|t| *t < 2.0).collect();
                let exact = |t: f64| [(-t).exp(), 2.0 * (-t).exp()];
                run.sample(&times, |t, v| {
                    let off = v.iter().zip(exact(t)).map(|(v, exact)| (v - exact).abs());
                    largest = off.fold(largest, |m, x| if x <= m { m } else { x });
                })
                .unwrap_or_else(|error| panic!("{name}: {error}"));
                let mut run = Trajectory::new(method(), start, h, 2.0).expect("valid");
                let hit = run.until(|_, v| v[1] - 1.0, Crossing::Falling).expect("solvable").expect("at ln 2");
                largest.max((hit.t - 2_f64.ln()).abs())
            };
            let errors = [error(0.1), error(0.025)];
            let measured = 0.5 * (errors[0] / errors[1]).log2();
            assert!((measured - order).abs() < 0.3, "{name}: order {measured} from {errors:?}");
        }
    }
}

#[test]
fn a_zero_that_is_a_number_is_found_to_the_last_bit_and_one_that_is_touched_from_below_does_not_fall() {
    let run = |g: fn(f64) -> f64, crossing| {
        let drift = field_of!(1, |_t, _v, dv| dv[0] = T::from(1.0));
        let method = RungeKutta::new(drift, Tableau::rk4()).expect("usable");
        let mut run = Trajectory::new(method, State::new(0.0, vec![0.0]), 1.0, 1.0).expect("valid");
        run.until(|t, _| g(t), crossing).expect("solvable").map(|hit| hit.t)
    };
    assert_eq!(run(|t| t - 0.375, Crossing::Rising), Some(0.375));
    assert_eq!(run(|t| 0.375 - t, Crossing::Falling), Some(0.375));
    // At 0.5 the search looks.
    assert_eq!(run(|t| -(t - 0.5) * (t - 0.5), Crossing::Falling), None);
    assert_eq!(run(|t| (t - 0.5) * (t - 0.5), Crossing::Rising), None);
}

#[test]
fn momenta_at_the_event_of_a_window_are_between_those_of_the_step_in_proportion() {
    let run = || {
        let pull = field_of!(1, |t, v, dv| dv[0] = -v[0] * v[0] - t);
        let discrete = Trapezoidal::new(lsvi::LeastSquares::new(pull).expect("usable"));
        let window = lsvi::Window::new(discrete, 3).expect("a length");
        Trajectory::new(window, State::new(1.0, vec![1.0]), 0.25, 1.75).expect("valid")
    };
    let states: Vec<State> = run().states().collect::<Result<_, _>>().expect("solvable");
    let level = 0.4 * states[0].q[0] + 0.6 * states[1].q[0];
    let mut run = run();
    let hit = run.until(|_, v| v[0] - level, Crossing::Falling).expect("solvable").expect("a crossing").clone();
    let [before, after] = [&states[0], &states[1]];
    let share = (hit.t - before.t) / 0.25;
    assert!(share > 0.5 && share < 0.7 && (before.p[0] - after.p[0]).abs() > 1e-3, "{share} {before:?} {after:?}");
    approx::assert_abs_diff_eq!(hit.p[0], before.p[0] + share * (after.p[0] - before.p[0]), epsilon = 1e-15);
}

#[test]
fn the_event_of_a_least_squares_method_is_the_end_of_a_shorter_step() {
    let pull = || field_of!(1, |t, v, dv| dv[0] = -v[0] * v[0] - t);
    let mut run =
        Trajectory::new(method_i(pull()).expect("usable"), State::new(0.0, vec![1.0]), 0.5, 2.0).expect("valid");
    let hit = run.until(|_, v| v[0] - 0.8, Crossing::Falling).expect("solvable").expect("a crossing").clone();
    let (mut v, mut p) = ([1.0], [0.0]);
    lsvi::OneStep::step(&mut method_i(pull()).expect("usable"), 0.0, hit.t, &mut v, &mut p).expect("solvable");
    assert_eq!(hit.q, v);
    approx::assert_abs_diff_eq!(v[0], 0.8, epsilon = 1e-15);
}

#[test]
fn a_pole_is_no_zero_and_a_jump_is_one() {
    let count = |g: &dyn Fn(f64) -> f64, crossing| {
        let turn = field_of!(1, |_t, v, dv| dv[0] = v[0] * 0.0 + 1.0);
        let method = RungeKutta::new(turn, Tableau::rk4()).expect("usable");
        let mut run = Trajectory::new(method, State::new(0.0, vec![0.0]), 0.1, 7.0).expect("valid");
        let mut times = Vec::new();
        while let Some(hit) = run.until(|_, q| g(q[0]), crossing).expect("solvable") {
            times.push(hit.t);
        }
        times
    };
    let pi = std::f64::consts::PI;
    // Poles at π/2 and 3π/2, between zeros.
    let zeros = count(&|x: f64| (x - 0.01).tan(), Crossing::Any);
    assert_eq!(zeros.len(), 3, "{zeros:?}");
    for (zero, exact) in zeros.iter().zip([0.01, pi + 0.01, 2.0 * pi + 0.01]) {
        approx::assert_abs_diff_eq!(*zero, exact, epsilon = 1e-13);
    }
    // Poles that are numbers, beside zeros that are.
    for pole in [0.53, 0.537_109_375, 3.3] {
        assert_eq!(count(&|x: f64| (x - pole).recip(), Crossing::Any), [0.0; 0], "{pole}");
    }
    // A zero in the part of the step behind that of a pole.
    let behind = count(&|x: f64| (x - 0.565) / (x - 0.53), Crossing::Any);
    assert!(behind.len() == 1 && (behind[0] - 0.565).abs() < 1e-12, "{behind:?}");
    // A jump from little to much stays where it is.
    let jumps = count(&|x: f64| if x < 0.53 { -1e-4 } else { 100.0 }, Crossing::Any);
    assert!(jumps.len() == 1 && (jumps[0] - 0.53).abs() < 1e-14, "{jumps:?}");
    // Jumps, to which g rises.
    let jumps = count(&|x: f64| if x < 2.03 { x } else { x - 5.0 }, Crossing::Falling);
    assert!(jumps.len() == 1 && (jumps[0] - 2.03).abs() < 1e-12, "{jumps:?}");
}

#[test]
fn an_integrator_in_a_box_takes_shorter_steps_too() {
    let rule = || {
        let swing = field_of!(2, |_t, v, dv| {
            dv[0] = v[1];
            dv[1] = -v[0].sin();
        });
        CoupledRungeKutta::new(swing, &[vec![0.5]], &[1.0], &[0.5]).expect("usable")
    };
    let start = || State::new(0.0, vec![2.0, 0.0]);
    let event = |method: Box<dyn Integrator>| {
        let mut run = Trajectory::new(method, start(), 0.5, 5.0).expect("valid");
        run.until(|_, v| v[0], Crossing::Falling).expect("solvable").map(|hit| hit.q.clone())
    };
    let mut run = Trajectory::new(rule(), start(), 0.5, 5.0).expect("valid");
    let own = run.until(|_, v| v[0], Crossing::Falling).expect("solvable").map(|hit| hit.q.clone());
    assert!(own.is_some());
    assert_eq!(event(Box::new(rule())), own);
    assert_eq!(event(Box::new(Box::new(rule()) as Box<dyn Integrator>)), own);
}

#[test]
fn the_adaptive_method_tells_rates() {
    let mut method = Radau::new(fall(), Tolerances::new(1e-6, 1e-6).expect("usable")).expect("usable");
    let mut rate = [0.0; 2];
    method.rate(&State::new(0.0, vec![10.0, 3.0]), &mut rate).expect("finite");
    assert_eq!(rate, [3.0, -9.81]);
}

/// Both zeros lie in the first half of the step, one in its first quarter.
#[test]
fn two_zeros_of_a_step_are_told_apart_where_a_quarter_of_it_lies_between() {
    let still = field_of!(1, |_t, _v, dv| dv[0] = T::from(0.0));
    let method = RungeKutta::new(still, Tableau::rk4()).expect("usable");
    let mut run = Trajectory::new(method, State::new(0.0, vec![1.0]), 1.0, 1.0).expect("valid");
    let mut found = Vec::new();
    while let Some(hit) = run.until(|t, _| (t - 0.1) * (t - 0.3), Crossing::Any).expect("solvable") {
        found.push(hit.t);
    }
    assert!(found.len() == 2 && (found[0] - 0.1).abs() < 1e-12 && (found[1] - 0.3).abs() < 1e-12, "{found:?}");
}

/// What a time that is right to two roundings leaves of a zero with the slope 1, and as much for those of the step.
fn rounding(t: f64) -> f64 {
    4.0 * f64::EPSILON * t
}

/// In steps of most of a turn the dense output is no path at all, and the method is right to many digits.
#[test]
fn an_event_is_a_zero_in_its_direction_however_poor_the_dense_output() {
    let gauss = |stages| position_momentum(Galerkin::gauss(lagrangian_of(Oscillator), stages).expect("a method"));
    for (stages, h, least) in [(8, 4.5, 63), (10, 4.75, 63), (8, 5.25, 30), (10, 6.17, 20), (8, 3.3, 63)] {
        for (crossing, share) in [(Crossing::Any, 1), (Crossing::Rising, 2), (Crossing::Falling, 2)] {
            let start = State::new(0.0, vec![0.0]).with_momentum(vec![1.0]);
            let mut run = Trajectory::new(gauss(stages), start, h, 200.0).expect("valid");
            let (mut count, mut before) = (0, 0.0);
            while let Some(event) = run.until(|_, q| q[0], crossing).expect("solvable") {
                let what = format!("{stages} stages, h = {h}, {crossing:?}: {event:?} after t = {before}");
                assert!(
                    event.t > before && event.q[0].abs() <= rounding(event.t) && (event.p[0].abs() - 1.0).abs() < 1e-4,
                    "{what}"
                );
                let is_counted = match crossing {
                    Crossing::Rising => event.p[0] > 0.0,
                    Crossing::Falling => event.p[0] < 0.0,
                    Crossing::Any => true,
                };
                let off = event.t - (event.t / std::f64::consts::PI).round() * std::f64::consts::PI;
                assert!(is_counted && off.abs() < 1e-2, "{what}");
                (count, before) = (count + 1, event.t);
            }
            assert!(count >= least / share, "{stages} stages, h = {h}, {crossing:?}: {count}");
        }
    }
}

/// A run that goes on with another step after events.
#[test]
fn events_follow_each_other_in_time_whatever_the_steps() {
    let mut method = position_momentum(Galerkin::gauss(lagrangian_of(Oscillator), 6).expect("a method"));
    for k in 5..80 {
        let h = 0.09 * f64::from(k);
        let start = State::new(0.0, vec![0.0]).with_momentum(vec![1.0]);
        let mut run = Trajectory::new(&mut method, start, h, 500.0).expect("valid");
        let mut times = vec![0.0];
        while let Some(event) = run.until(|_, q| q[0], Crossing::Any).expect("solvable") {
            times.push(event.t);
            assert!(event.q[0].abs() <= rounding(event.t), "h = {h}: {event:?}");
            if times.len() % 5 == 0 {
                run.resume(if times.len() % 2 == 0 { h } else { 0.7 * h }, 500.0).expect("valid");
            }
        }
        assert!(times.is_sorted_by(|a, b| a < b) && times.len() > 20, "h = {h}: {times:?}");
    }
}

/// Beside the zero of a cube root a secant leads beyond it, and signs lead to it.
#[test]
fn a_zero_at_which_no_secant_converges_is_found_between_signs() {
    let method = position_momentum(Trapezoidal::new(lagrangian_of(Oscillator)));
    let start = State::new(0.0, vec![1.0]).with_momentum(vec![0.0]);
    let mut run = Trajectory::new(method, start, 0.4, 10.0).expect("valid");
    let event = run.until(|_, q| q[0].cbrt(), Crossing::Falling).expect("solved").expect("it crosses");
    assert!(event.q[0].abs() < 1e-14, "{event:?}");
}

/// Two oscillators whose steps are more than a turn: q₀ q₁ goes through a value at times that the dense output knows little of.
#[test]
fn no_event_is_told_twice_in_steps_of_more_than_a_turn() {
    struct Coupled;
    impl LagrangianFn for Coupled {
        fn dim(&self) -> usize {
            2
        }
        fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
            (v[0] * v[0] + v[1] * v[1] - q[0] * q[0] - q[1] * q[1] * 1.7) * 0.5 - q[0] * q[0] * q[1] * 0.02
        }
    }
    for h in [7.4, 7.77, 8.14, 8.51] {
        for crossing in [Crossing::Any, Crossing::Falling] {
            let method = position_momentum(Galerkin::gauss(lagrangian_of(Coupled), 2).expect("s ≥ 1"));
            let start = State::new(0.0, vec![0.3, 0.1]).with_momentum(vec![0.4, 0.2]);
            let mut run = Trajectory::new(method, start, h, 60.0).expect("usable");
            let (mut before, mut events) = (0.0, 0);
            while let Some(event) = run.until(|_, q| q[0] * q[1] - 0.01, crossing).expect("solvable") {
                // The nearest ones here are more than 0.5 apart.
                assert!(event.t > before + 1e-3, "h = {h}, {crossing:?}: {} after {before}", event.t);
                (before, events) = (event.t, events + 1);
            }
            assert!(events >= 6, "h = {h}, {crossing:?}: {events}");
        }
    }
}
