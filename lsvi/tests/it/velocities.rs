//! Lagrangians that are not quadratic in the velocity: the velocity of a momentum, dense output, and steps.

use crate::systems::lagrangian_of;
use lsvi::discrete::{Galerkin, Midpoint, Trapezoidal};
use lsvi::{
    AutoConstraint, Constrained, ConstraintFn, Integrator, LagrangianFn, Scalar, SolveError, State, StepError,
    Trajectory, TwoStep, position_momentum,
};

use crate::mechanics::discretisations;

const EPS: f64 = f64::EPSILON;

/// L = |v|²/2 + |v|⁴/4 − q₀²/2.
struct Quartic(usize);

impl LagrangianFn for Quartic {
    fn dim(&self) -> usize {
        self.0
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        let square = v.iter().fold(q[0] * 0.0, |sum, v| sum + *v * *v);
        square * 0.5 + square * square * 0.25 - q[0] * q[0] * 0.5
    }
}

/// L = −√(1 − v²) − q²/2, a relativistic oscillator: p = v/√(1 − v²).
struct Relativistic;

impl LagrangianFn for Relativistic {
    fn dim(&self) -> usize {
        1
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        -(-v[0] * v[0] + 1.0).sqrt() - q[0] * q[0] * 0.5
    }
}

fn energy(state: &State) -> f64 {
    state.p[0].hypot(1.0) + 0.5 * state.q[0] * state.q[0]
}

/// L = √(1 + v²): |p| < 1.
struct Bounded;

impl LagrangianFn for Bounded {
    fn dim(&self) -> usize {
        1
    }
    fn lagrangian<T: Scalar>(&self, _t: T, _q: &[T], v: &[T]) -> T {
        (v[0] * v[0] + 1.0).sqrt()
    }
}

struct Circle;

impl ConstraintFn for Circle {
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

#[test]
fn the_rate_is_the_velocity_of_the_momentum() {
    let (quartic, relativistic) = (lagrangian_of(Quartic(1)), lagrangian_of(Relativistic));
    for (name, discrete) in discretisations(&quartic) {
        let mut method = position_momentum(discrete);
        for v in [-30.0_f64, -2.0, 0.0, 1e-3, 0.5, 2.0, 1e4] {
            let mut rate = [f64::NAN];
            let state = State::new(0.0, vec![0.3]).with_momentum(vec![v + v.powi(3)]);
            method.rate(&state, &mut rate).expect("regular");
            // The rounding of p, of v and of q + v.
            assert!((rate[0] - v).abs() <= 16.0 * EPS * (1.0 + v.abs()), "{name}: {} for {v}", rate[0]);
        }
    }
    for (name, discrete) in discretisations(&relativistic) {
        let mut method = position_momentum(discrete);
        for p in [0.1, 0.9, 5.0, 50.0, 1e6] {
            let (mut rate, v) = ([f64::NAN], p / f64::hypot(1.0, p));
            let state = State::new(0.0, vec![0.3]).with_momentum(vec![p]);
            method.rate(&state, &mut rate).expect("inside the domain");
            assert!((rate[0] - v).abs() <= 16.0 * EPS, "{name}: {} for {v}", rate[0]);
        }
    }
    let quartic = lagrangian_of(Quartic(2));
    let mut method =
        Constrained::new(Galerkin::gauss(quartic, 2).expect("s ≥ 1"), AutoConstraint::new(Circle)).expect("fits");
    let mut rate = [f64::NAN; 2];
    method.rate(&State::new(0.0, vec![1.0, 0.0]).with_momentum(vec![0.0, 10.0]), &mut rate).expect("regular");
    assert!(rate[0].abs() <= 16.0 * EPS && (rate[1] - 2.0).abs() <= 16.0 * EPS, "{rate:?}");
}

#[test]
fn a_momentum_of_no_velocity_is_an_error() {
    let mut method = position_momentum(Midpoint::new(lagrangian_of(Bounded)));
    let mut rate = [0.0];
    let mut at = |p: f64| method.rate(&State::new(0.0, vec![0.3]).with_momentum(vec![p]), &mut rate);
    at(0.9).expect("in the range of ∂L/∂v");
    let error = at(2.0);
    // The range of ∂L/∂v ends at 1.
    assert!(
        matches!(error, Err(StepError::Solve { source: SolveError::NoVelocity { difference }, .. })
            if difference >= 1.0),
        "{error:?}"
    );
}

#[test]
fn dense_output_keeps_its_order_where_l_is_not_quadratic_in_the_velocity() {
    let run = |h: f64| {
        let method = position_momentum(Galerkin::gauss(lagrangian_of(Quartic(1)), 3).expect("s ≥ 1"));
        Trajectory::new(method, State::new(0.0, vec![1.0]), h, 3.0).expect("fits")
    };
    // States of order 6 at the short step: errors below 1e-13.
    let error = |h: f64| {
        let t = 2.0 + 0.37 * h;
        let (mut fine, mut coarse) = (f64::NAN, f64::NAN);
        run(t / (t / 0.01).round()).sample(&[t], |_, q| fine = q[0]).expect("steps");
        run(h).sample(&[t], |_, q| coarse = q[0]).expect("steps");
        (coarse - fine).abs()
    };
    let errors = [0.2, 0.1, 0.05].map(error);
    for pair in errors.windows(2) {
        // Order 4 of the cubic, less the half that leaves no room for 3.
        assert!((pair[0] / pair[1]).log2() > 3.5, "{errors:?}");
    }
}

#[test]
fn a_relativistic_particle_moves_in_every_discretisation() {
    let relativistic = lagrangian_of(Relativistic);
    for (q, p) in [(1.0, 0.0), (0.0, 2.0), (0.3, -5.0)] {
        for index in 0..discretisations(&relativistic).len() {
            let worst = [0.1, 0.05].map(|h| {
                let (name, discrete) = discretisations(&relativistic).swap_remove(index);
                let start = State::new(0.0, vec![q]).with_momentum(vec![p]);
                let (e, mut worst) = (energy(&start), 0.0_f64);
                Trajectory::new(position_momentum(discrete), start, h, 3.0)
                    .expect("fits")
                    .observe(|state| worst = worst.max((energy(state) / e - 1.0).abs()))
                    .unwrap_or_else(|error| panic!("{name} from ({q}, {p}) with h = {h}: {error}"));
                worst
            });
            // Order 2 at least, to the rounding of q/h in each of 60 steps.
            assert!(worst[1] <= 0.3 * worst[0] + 60.0 * 100.0 * EPS / 0.05, "{index} from ({q}, {p}): {worst:?}");
        }
    }
}

#[test]
fn fast_particles_are_as_good_as_slow_ones() {
    let start = State::new(0.0, vec![0.0]).with_momentum(vec![50.0]);
    let mut method = position_momentum(Galerkin::gauss(lagrangian_of(Relativistic), 2).expect("s ≥ 1"));
    // Until all of the energy is potential, and back: q² = 2 (√(1 + p²) − 1), with |v| almost 1 on the way.
    let (h, mut worst) = (0.02, 0.0_f64);
    let end = Trajectory::new(&mut method, start.clone(), h, 21.0)
        .expect("fits")
        .observe(|state| worst = worst.max((energy(state) / energy(&start) - 1.0).abs()))
        .expect("a solution exists");
    assert!(end.p[0] < 0.0, "{end:?}");
    let work = method.work();
    assert!(work.residuals.max(work.factorizations) < 5 * work.steps, "{work:?}");
    // The error h⁴ of a slow one, and the rounding of q/h in 1000 steps, which reaches p with ∂²L/∂v² = γ³ ≈ p³.
    let rounding = 50.0_f64.powi(2) * EPS * 10.0 / h;
    assert!(worst < h.powi(4) + 1000.0 * rounding, "{worst:e}");
}

#[test]
fn two_steps_of_a_relativistic_particle() {
    // L = −√(1 − v²) + q, p = t: q = √(1 + t²).
    struct Pushed;
    impl LagrangianFn for Pushed {
        fn dim(&self) -> usize {
            1
        }
        fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
            -(-v[0] * v[0] + 1.0).sqrt() + q[0]
        }
    }
    let (exact, h) = (|t: f64| t.hypot(1.0), 0.05);
    let mut method = TwoStep::new(Galerkin::gauss(lagrangian_of(Pushed), 2).expect("s ≥ 1"));
    let (mut before, mut now) = ([exact(2.0)], [exact(2.0 + h)]);
    method.step(2.0 + h, h, &mut before, &mut now).expect("a solution exists");
    // The local error of order 5, and what the momentum lost: (h/2)⁴.
    assert!((now[0] - exact(2.0 + 2.0 * h)).abs() < (0.5 * h).powi(4), "{}", now[0] - exact(2.0 + 2.0 * h));
}

/// L = −√(1 − v²) + 5q: the momentum grows by the force alone, in every discrete Lagrangian of it.
struct Accelerated;

impl LagrangianFn for Accelerated {
    fn dim(&self) -> usize {
        1
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        -(-v[0] * v[0] + 1.0).sqrt() + q[0] * 5.0
    }
}

/// ∂²L/∂v² is p³, and so is what the rounding of a velocity would be multiplied by.
#[test]
fn the_momentum_of_a_fast_particle_grows_by_its_impulse() {
    let l = lagrangian_of(Accelerated);
    for p in [1.0, 1e3, 1e5] {
        let methods: [(&str, Box<dyn Integrator + '_>); 4] = [
            ("midpoint", Box::new(position_momentum(Midpoint::new(&l)))),
            ("trapezoidal", Box::new(position_momentum(Trapezoidal::new(&l)))),
            ("galerkin-gauss(3)", Box::new(position_momentum(Galerkin::gauss(&l, 3).expect("s ≥ 1")))),
            ("galerkin-lobatto(2)", Box::new(position_momentum(Galerkin::lobatto(&l, 2).expect("s ≥ 1")))),
        ];
        for (name, method) in methods {
            let initial = State::new(0.0, vec![0.0]).with_momentum(vec![p]);
            let end = Trajectory::new(method, initial, 0.01, 1.0).expect("valid").observe(|_| {}).expect("it moves");
            // A rounding of p in each of a hundred steps.
            assert!(
                (end.p[0] - p - 5.0).abs() <= 100.0 * EPS * (p + 5.0),
                "{name}, p = {p:e}: {:e}",
                end.p[0] - p - 5.0
            );
        }
    }
}

/// L = (1 + t) v²/2: p = (1 + t) v.
struct Growing;

impl LagrangianFn for Growing {
    fn dim(&self) -> usize {
        1
    }
    fn lagrangian<T: Scalar>(&self, t: T, _q: &[T], v: &[T]) -> T {
        (t + 1.0) * v[0] * v[0] * 0.5
    }
}

#[test]
fn a_velocity_is_that_of_the_momentum_at_its_time() {
    let lagrangian = lagrangian_of(Growing);
    let state = State { t: 2.0, q: vec![7.0], p: vec![6.0] };
    for (name, discrete) in discretisations(&lagrangian) {
        let mut rate = [0.0];
        position_momentum(discrete).rate(&state, &mut rate).expect("regular");
        // Some have it half a step of size 1 later.
        assert!((1.5..=2.0 + 1e-12).contains(&rate[0]), "{name}: {rate:?}");
    }
}
