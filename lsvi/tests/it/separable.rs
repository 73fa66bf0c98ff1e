//! Steps of separable Lagrangians against Newton's method on the equations of a step.

use crate::mechanics::{Named, discretisations};
use crate::systems::lagrangian_of;
use crate::systems::{AnyLagrangian, ChargedParticle, DoublePendulum, HenonHeiles, Oscillator, Pendulum};
use lsvi::discrete::{BrokenLine, Galerkin, Midpoint, Trapezoidal};
use lsvi::{
    HessianWeights, Integrator, Jacobian, Lagrangian, LagrangianFn, OneStep, Scalar, SolveError, StepError,
    position_momentum,
};
use std::sync::Mutex;

/// A Lagrangian that says that it is separable.
#[derive(Debug)]
pub(crate) struct Separable<L>(pub(crate) L);

impl<L: LagrangianFn> LagrangianFn for Separable<L> {
    fn dim(&self) -> usize {
        self.0.dim()
    }
    fn is_separable(&self) -> bool {
        true
    }
    fn lagrangian<T: Scalar>(&self, t: T, q: &[T], v: &[T]) -> T {
        self.0.lagrangian(t, q, v)
    }
}

/// A mass that is not diagonal and a potential that depends on time.
#[derive(Debug)]
pub(crate) struct Swaying;

impl LagrangianFn for Swaying {
    fn dim(&self) -> usize {
        2
    }
    fn lagrangian<T: Scalar>(&self, t: T, q: &[T], v: &[T]) -> T {
        v[0] * v[0] + v[1] * v[1] * 0.5 + v[0] * v[1] * 0.6 + (q[0] - t).cos() - q[1] * q[1] * (q[0].sin() + 2.0) * 0.5
    }
}

/// Six masses on a line with springs that harden, driven at one end.
#[derive(Debug)]
pub(crate) struct Chain;

impl LagrangianFn for Chain {
    fn dim(&self) -> usize {
        6
    }
    fn lagrangian<T: Scalar>(&self, t: T, q: &[T], v: &[T]) -> T {
        let spring = |x: T| x * x * 0.5 + x.powi(4) * 0.25;
        let kinetic = (0..6).fold(v[0] * v[1] * 0.3, |sum, k| sum + v[k] * v[k] * (0.5 + 0.1 * k as f64));
        q.windows(2).fold(kinetic - spring(q[0] - t.sin() * 0.1), |sum, pair| sum - spring(pair[1] - pair[0]))
    }
}

/// More wells than one.
struct Washboard;

impl LagrangianFn for Washboard {
    fn dim(&self) -> usize {
        1
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        v[0] * v[0] * 0.5 + (q[0] * 2.0).cos() + q[0] * 0.3
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |most: f64, (a, b)| if (a - b).abs() <= most { most } else { (a - b).abs() })
}

/// A guess by a polynomial through the nodes of the last step would lose all digits of so many.
#[test]
fn paths_of_high_degree_are_those_of_their_equations() {
    let (separable, general) = (lagrangian_of(Separable(Pendulum)), lagrangian_of(Pendulum));
    let end = |discrete: Galerkin<&AnyLagrangian<'_>>| {
        let (mut method, mut q, mut p) = (position_momentum(discrete), [1.0], [0.0]);
        for k in 0..10 {
            method.step(f64::from(k), 1.0, &mut q, &mut p).expect("a root");
        }
        [q[0], p[0]]
    };
    for degree in [9, 12, 20, 44, 60] {
        let [one, other] = [&separable, &general].map(|l| end(Galerkin::gauss(l, degree).expect("nodes")));
        // Roundings of ten steps, and of coefficients of so many nodes.
        assert!(distance(&one, &other) < 1e-12, "degree {degree}: {one:?} {other:?}");
    }
}

#[test]
fn the_step_of_a_separable_lagrangian_is_that_of_its_equations() {
    fn compare(separable: Vec<Named<'_>>, general: Vec<Named<'_>>, [q, p]: [&[f64]; 2]) {
        let (h, eps) = (0.05, f64::EPSILON);
        for ((name, separable), (_, general)) in separable.into_iter().zip(general) {
            let (mut one, mut other) = (position_momentum(separable), position_momentum(general));
            let mut states = [(q.to_vec(), p.to_vec()), (q.to_vec(), p.to_vec())];
            for k in 0..100 {
                let t = h * f64::from(k);
                let [(q, p), (r, s)] = &mut states;
                one.step(t, h, q, p).expect("bounded");
                other.step(t, h, r, s).expect("bounded");
                // p is a derivative of the path, up to 16 roundings of q over h; regular motion lets them grow like t.
                let allowed = 64.0 * (1.0 + t) * 16.0 * eps / h;
                let apart = distance(q, r).max(distance(p, s)).max(distance(one.unknowns(), other.unknowns()));
                assert!(apart <= allowed, "{name}, step {k}: {apart:e}");
                // A position that a caller has changed is not taken for the end of the last step.
                if k == 50 {
                    (q[0], r[0]) = (0.15, 0.15);
                }
            }
            assert_eq!((one.work().factorizations, one.work().steps), (0, 100), "{name}");
            assert!(other.work().factorizations > 0, "{name}");
        }
    }
    let (separable, general) = (lagrangian_of(Separable(HenonHeiles)), lagrangian_of(HenonHeiles));
    let two: [&[f64]; 2] = [&[0.1, 0.2], &[0.3, -0.1]];
    compare(discretisations(&separable), discretisations(&general), two);
    let (separable, general) = (lagrangian_of(Separable(Swaying)), lagrangian_of(Swaying));
    compare(discretisations(&separable), discretisations(&general), two);
    let (separable, general) = (lagrangian_of(Separable(Chain)), lagrangian_of(Chain));
    let six: [&[f64]; 2] = [&[0.1, 0.2, -0.1, 0.0, 0.3, 0.2], &[0.3, -0.1, 0.0, 0.2, -0.2, 0.1]];
    compare(discretisations(&separable), discretisations(&general), six);
}

/// A force of time alone changes nothing that an iteration on accelerations would have to look at, whichever component it acts on.
#[test]
fn a_force_of_time_in_any_component_takes_no_matrix() {
    struct Pushed(usize);
    impl LagrangianFn for Pushed {
        fn dim(&self) -> usize {
            3
        }
        fn is_separable(&self) -> bool {
            true
        }
        fn lagrangian<T: Scalar>(&self, t: T, q: &[T], v: &[T]) -> T {
            let motion = (0..3).fold(q[0] * 0.0, |sum, k| sum + v[k] * v[k] * 0.5 - q[k] * q[k] * 0.5);
            motion + q[self.0] * (t * 6.0).sin() * 50.0
        }
    }
    for k in 0..3 {
        let mut method = position_momentum(Galerkin::gauss(lagrangian_of(Pushed(k)), 3).expect("nodes"));
        let (mut q, mut p) = ([0.1; 3], [0.0; 3]);
        for step in 0..20 {
            method.step(0.1 * f64::from(step), 0.1, &mut q, &mut p).expect("solvable");
        }
        assert_eq!(method.work().factorizations, 0, "component {k}");
    }
}

#[test]
fn a_separable_step_that_fails_leaves_the_state_as_it_was() {
    let l = lagrangian_of(Separable(HenonHeiles));
    for (name, discrete) in discretisations(&l) {
        let mut method = position_momentum(discrete);
        let (mut q, mut p) = ([f64::NAN, 0.0], [0.0; 2]);
        assert!(method.step(0.0, 0.1, &mut q, &mut p).is_err(), "{name}");
        let (mut q, mut p) = ([1e200, 0.0], [0.0; 2]);
        assert!(method.step(0.0, 0.1, &mut q, &mut p).is_err(), "{name}");
        assert_eq!((q, p), ([1e200, 0.0], [0.0; 2]), "{name}");
    }
}

/// Steps along trajectories, as long as they are unstable even, against those that Newton's method takes from the same states.
#[test]
fn no_separable_step_returns_a_root_of_another_branch() {
    let (separable, general) = (lagrangian_of(Separable(Washboard)), lagrangian_of(Washboard));
    let (mut direct, mut wrong) = (0, Vec::new());
    for i in 0..30 {
        let h = 0.02 * 1.25_f64.powi(i);
        for ((name, one), (_, other)) in discretisations(&separable).into_iter().zip(discretisations(&general)) {
            let (mut one, mut other) = (position_momentum(one), position_momentum(other));
            let (mut q, mut p) = ([0.3 + 0.02 * f64::from(i)], [1.5 - 0.1 * f64::from(i)]);
            for k in 0..20 {
                let (mut r, mut s, before) = (q, p, one.work().factorizations);
                let (found, expected) = (one.step(0.0, h, &mut q, &mut p), other.step(0.0, h, &mut r, &mut s));
                direct += i32::from(one.work().factorizations == before && found.is_ok());
                // An explicit step has no other branch, and goes on where its equation has too small a derivative.
                let is_same = match (&found, &expected) {
                    (Ok(()), Ok(())) => {
                        distance(&q, &r).max(distance(&p, &s)) <= 1e-7 * (1.0 + q[0].abs() + p[0].abs())
                    }
                    (Err(_), Err(_)) => true,
                    _ => name == "trapezoidal",
                };
                if !is_same {
                    wrong.push(format!(
                        "{name}, h = {h}, step {k}: {q:?} {p:?} {found:?}, not {r:?} {s:?} {expected:?}"
                    ));
                }
                if !is_same || found.is_err() || expected.is_err() {
                    break;
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
    assert!(direct > 2000, "{direct} steps without Newton's method");
}

/// With h the midpoint moves to 0.4 left of the start. The root beside the start, which an iteration from there contracts to, is on
/// no branch that comes from it.
#[test]
fn a_step_that_seems_to_stand_still_is_not_taken_for_short() {
    struct Spikes(bool);
    impl LagrangianFn for Spikes {
        fn dim(&self) -> usize {
            1
        }
        fn is_separable(&self) -> bool {
            self.0
        }
        fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
            let spike = |height: f64, k: f64, phase: f64| (((q[0] * k + phase).cos() - 1.0) * 4.0).exp() * height;
            let spikes = spike(-1.1405, 3.8459, 1.3092) + spike(-0.9115, 0.2043, 3.9008);
            v[0] * v[0] * 0.5 + spikes + spike(0.8964, 4.2523, 4.5508) + spike(0.1479, 2.4286, 5.2287)
        }
    }
    let end = |is_separable: bool| {
        let mut method = position_momentum(Midpoint::new(lagrangian_of(Spikes(is_separable))));
        let (mut q, mut p) = ([-5.10705], [-1.24156]);
        method.step(0.0, 0.48, &mut q, &mut p).expect("the branch goes on");
        q[0]
    };
    assert!((end(false) + 5.910).abs() < 0.01, "{}", end(false));
    assert!((end(true) - end(false)).abs() < 1e-9, "{} and {}", end(true), end(false));
}

/// ½ v² with a force of its own, that notes where it is asked for.
struct Noted<F> {
    force: F,
    notes: Mutex<Vec<(f64, f64)>>,
}

impl<F: Fn(f64, f64) -> f64> Noted<F> {
    fn new(force: F) -> Self {
        Self { force, notes: Mutex::default() }
    }
}

impl<F: Fn(f64, f64) -> f64 + Sync> Lagrangian for Noted<F> {
    fn dim(&self) -> usize {
        1
    }
    fn is_separable(&self) -> bool {
        true
    }
    /// Without the potential, which nobody asks for.
    fn value(&self, _t: f64, _q: &[f64], v: &[f64]) -> f64 {
        0.5 * v[0] * v[0]
    }
    fn gradient(&self, t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
        self.notes.lock().expect("one thread").push((t, q[0]));
        (dl_dq[0], dl_dv[0]) = ((self.force)(t, q[0]), v[0]);
    }
    fn add_hessian(&self, t: f64, q: &[f64], _v: &[f64], c: HessianWeights, out: &mut Jacobian) {
        let slope = ((self.force)(t, q[0] + 1e-6) - (self.force)(t, q[0] - 1e-6)) / 2e-6;
        out.add(0, 0, c.qq * slope + c.vv);
    }
}

/// A branch that has turned is looked at in a step half as long.
#[test]
fn a_branch_that_turns_is_looked_at_half_way() {
    let (t, h, q0, v0) = (0.3, 1.0, 2.34, 0.6);
    let spring = |t: f64, q: f64| -0.4 * q + 0.02 * (3.0 * t).sin();
    let step = |l: &dyn Lagrangian| {
        let mut method = position_momentum(Midpoint::new(l));
        let (mut q, mut p) = ([q0], [v0]);
        method.step(t, h, &mut q, &mut p).expect("solvable");
        (q[0], method.work())
    };
    let plain = Noted::new(spring);
    let (q1, work) = step(&plain);
    // The look at what is declared takes two more.
    assert_eq!((work.factorizations, work.residuals + 2), (0, plain.notes.lock().expect("one thread").len() as u64));
    let node = 0.5 * (q0 + q1);
    assert!(node - q0 < 0.25 * 0.5 * h * v0, "{node} has not turned");
    // Its acceleration is a quarter of what it was as far as the way goes, and its time that of the forces at the start.
    let half = q0 + 0.25 * (node - q0 + 0.5 * h * v0);
    let &(time, place) = plain.notes.lock().expect("one thread").last().expect("forces");
    assert!((time - (t + 0.5 * h)).abs() < 1e-15 && (place - half).abs() < 1e-14, "{time} {place}, {half}");
    // A force that acts there alone.
    let bump = |t: f64, q: f64| spring(t, q) - 0.05 * (-((q - half) / 0.005).powi(2)).exp();
    let (q2, work) = step(&Noted::new(bump));
    assert!(work.factorizations > 0 && (q2 - q1).abs() < 1e-9, "{work:?}, {q1} {q2}");
}

/// The nodes of Gauss's rule are (3 ∓ √3)/6 of the way. An acceleration is as large as an eighth of what lies between them over h²ρ(|A|) at 0.68 v/h, where
/// ρ = 0.1138 for Nyström's A, and as an eighth of all that lies before the second at 0.90 v/h.
#[test]
fn a_force_that_begins_between_two_nodes_is_held_to_what_lies_between_them() {
    for (strength, is_direct) in [(0.6, true), (0.75, false)] {
        let (h, q0, v0) = (0.1, 0.3, 2.0);
        let l = Noted::new(|_, q| if q > q0 + 0.5 * h * v0 { strength * v0 / h } else { 0.0 });
        let mut method = position_momentum(Galerkin::gauss(&l, 2).expect("s ≥ 1"));
        method.step(0.0, h, &mut [q0], &mut [v0]).expect("solvable");
        assert_eq!(method.work().factorizations == 0, is_direct, "{strength}: {:?}", method.work());
    }
}

/// Attraction to the origin.
pub(crate) struct Kepler;

impl LagrangianFn for Kepler {
    fn dim(&self) -> usize {
        2
    }
    fn is_separable(&self) -> bool {
        true
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        (v[0] * v[0] + v[1] * v[1]) * 0.5 + (q[0] * q[0] + q[1] * q[1]).sqrt().recip()
    }
}

/// An orbit of eccentricity 0.6, whose forces change by a factor of 16, in 16 steps a period.
#[test]
fn long_steps_round_a_pericentre_need_no_factors() {
    let mut method = position_momentum(Galerkin::gauss(lagrangian_of(Kepler), 6).expect("s ≥ 1"));
    let h = std::f64::consts::TAU / 16.0;
    // From the apocentre, where a trajectory may start with steps that long.
    let (mut q, mut p) = ([-1.6, 0.0], [0.0, -0.5]);
    (0..160).for_each(|k| method.step(f64::from(k) * h, h, &mut q, &mut p).expect("bounded"));
    assert_eq!(method.work().factorizations, 0);
    let energy = 0.5 * (p[0] * p[0] + p[1] * p[1]) - q[0].hypot(q[1]).recip();
    assert!((energy + 0.5).abs() < 1e-4, "{energy}");
}

#[test]
fn rounding_adds_up_to_that_of_the_increments() {
    // Gauss collocation conserves the energy of the oscillator: what it changes by is rounding.
    let l = lagrangian_of(Separable(Oscillator));
    let (h, steps) = (1e-4, 1_000_000);
    let mut midpoint = position_momentum(Midpoint::new(&l));
    let mut gauss = position_momentum(Galerkin::gauss(&l, 2).expect("s ≥ 1"));
    let mut verlet = position_momentum(Trapezoidal::new(&l));
    let mut line = position_momentum(BrokenLine::blanes_moan(&l).expect("separable"));
    let methods: [(&mut dyn OneStep, f64); 4] =
        // Störmer and Verlet's conserves q² + p²/(1 − h²/4); Blanes and Moan's what differs from q² + p² by h⁶, below rounding.
        [(&mut midpoint, 0.0), (&mut gauss, 0.0), (&mut verlet, 0.25 * h * h), (&mut line, 0.0)];
    for (method, shift) in methods {
        let (mut q, mut p) = ([0.8], [0.6 * f64::sqrt(1.0 - shift)]);
        let mut error = 0.0_f64;
        for k in 0..steps {
            method.step(f64::from(k) * h, h, &mut q, &mut p).expect("linear");
            error = error.max((q[0] * q[0] + p[0] * p[0] / (1.0 - shift) - 1.0).abs());
        }
        // Four roundings of q, p and their squares; those of the increments h q and h p add up to ε h √steps at random. Those of q and
        // p in every step would add up to some hundred ε, and those of (q₁ − q₀)/h to 1/h of that.
        assert!(error <= 16.0 * f64::EPSILON, "{error:e}");
    }
}

#[test]
fn a_step_goes_on_from_the_last_one_however_its_time_is_rounded() {
    let (l, h) = (lagrangian_of(Separable(HenonHeiles)), 0.01);
    for (name, discrete) in discretisations(&l) {
        let mut method = position_momentum(discrete);
        let mut run = |time: &dyn Fn(u32, f64) -> f64| {
            let (mut q, mut p, mut t) = ([0.1, 0.2], [0.3, -0.1], 0.0);
            for k in 0..500 {
                method.step(t, h, &mut q, &mut p).expect("bounded");
                t = time(k + 1, t);
            }
            (q, p)
        };
        assert_eq!(run(&|_, t| t + h), run(&|k, _| f64::from(k) * h), "{name}");
    }
}

#[test]
fn a_lagrangian_that_is_not_separable_as_it_says_is_refused() {
    let (charged, double) = (lagrangian_of(Separable(ChargedParticle)), lagrangian_of(Separable(DoublePendulum)));
    let refuses = |name: &str, method: &mut dyn OneStep| {
        let step = method.step(0.0, 0.1, &mut [1.0, 2.0], &mut [0.3, 0.1]);
        let is_refused = matches!(step, Err(StepError::Solve { source: SolveError::NotSeparable { .. }, .. }));
        assert!(is_refused, "{name}: {step:?}");
    };
    for (name, discrete) in discretisations(&charged) {
        refuses(&name, &mut position_momentum(discrete));
    }
    for (name, discrete) in discretisations(&double) {
        refuses(&name, &mut position_momentum(discrete));
    }
}

/// ½ v² + v⁴/10 − ½ q², declared separable.
struct Quartic;

impl LagrangianFn for Quartic {
    fn dim(&self) -> usize {
        1
    }
    fn is_separable(&self) -> bool {
        true
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        let square = v[0] * v[0];
        square * 0.5 + square * square * 0.1 - q[0] * q[0] * 0.5
    }
}

#[test]
fn a_start_at_rest_does_not_hide_that_a_lagrangian_is_not_separable() {
    let quartic = lagrangian_of(Quartic);
    for (name, discrete) in discretisations(&quartic) {
        let step = position_momentum(discrete).step(0.0, 0.1, &mut [1.0], &mut [0.0]);
        let is_refused = matches!(step, Err(StepError::Solve { source: SolveError::NotSeparable { .. }, .. }));
        assert!(is_refused, "{name}: {step:?}");
    }
}

/// ½ (v + a)² − ½ q², a mass on a spring seen from a base that moves, declared separable.
struct MovingBase {
    speed: f64,
}

impl LagrangianFn for MovingBase {
    fn dim(&self) -> usize {
        1
    }
    fn is_separable(&self) -> bool {
        true
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        (v[0] + self.speed) * (v[0] + self.speed) * 0.5 - q[0] * q[0] * 0.5
    }
}

/// Its second derivatives are those of ½ v² − ½ q².
#[test]
fn a_term_that_is_linear_in_the_velocity_is_not_separable() {
    for speed in [0.7, 1e-8] {
        let l = lagrangian_of(MovingBase { speed });
        for (name, discrete) in discretisations(&l) {
            let step = position_momentum(discrete).step(0.0, 0.1, &mut [0.1], &mut [1.0]);
            let Err(StepError::Solve { source: SolveError::LinearInVelocity { row: 0, difference }, .. }) = step else {
                panic!("{name}, {speed}: {step:?}")
            };
            assert!((difference - speed).abs() <= 4.0 * f64::EPSILON, "{name}: {difference}");
        }
    }
}

/// (2 + a sin q + t) v²/2 − cos q, declared separable.
struct Claimed {
    bend: f64,
    growth: f64,
}

impl LagrangianFn for Claimed {
    fn dim(&self) -> usize {
        1
    }
    fn is_separable(&self) -> bool {
        true
    }
    fn lagrangian<T: Scalar>(&self, t: T, q: &[T], v: &[T]) -> T {
        (q[0].sin() * self.bend + t * self.growth + 2.0) * v[0] * v[0] * 0.5 - q[0].cos()
    }
}

#[test]
fn a_mass_that_changes_by_little_or_with_time_is_not_separable() {
    for (bend, growth) in [(0.01, 0.0), (0.0, 1.0)] {
        let l = lagrangian_of(Claimed { bend, growth });
        let mut method = position_momentum(Trapezoidal::new(&l));
        let error = method.step(0.0, 0.5, &mut [0.3], &mut [1.0]).expect_err("another mass at the end");
        let StepError::Solve { source, .. } = error else { panic!("{error}") };
        assert_eq!(source, SolveError::NotSeparable { row: 0, column: 0 });
    }
}

/// A free particle and one on a spring, whose mass grows, or a term (q₁ − far) q₂v₂ begins, where the first one has come far; declared separable.
struct Onset {
    far: f64,
    mass: f64,
    mixed: f64,
}

impl LagrangianFn for Onset {
    fn dim(&self) -> usize {
        2
    }
    fn is_separable(&self) -> bool {
        true
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        let beyond = if q[0].re() > self.far { q[0] - self.far } else { T::from(0.0) };
        v[0] * v[0] * 0.5 + v[1] * v[1] * (beyond * self.mass + 1.0) * 0.5 + beyond * v[1] * q[1] * self.mixed
            - q[1] * q[1] * 0.5
    }
}

/// The first particle moves at 1 and comes to 1 in step 100, to 9.995 in step 1000: the next looks are in steps 127 and 1023, as after those
/// the steps between two are a power of two, 256 at most.
#[test]
fn a_lagrangian_that_is_separable_at_the_start_alone_is_refused_along_the_run() {
    // At rest at the origin a mixed term shows at other velocities alone, and in ∂L/∂q alone.
    let cases = [
        (1.0, 127, 1.0, 0.0, [0.2, 0.1]),
        (1.0, 127, 0.0, 1.0, [0.2, 0.1]),
        (1.0, 127, 0.0, 1.0, [0.0, 0.0]),
        (9.995, 1023, 1e-6, 0.0, [0.2, 0.1]),
    ];
    for (far, step, mass, mixed, [x, w]) in cases {
        let l = lagrangian_of(Onset { far, mass, mixed });
        for (name, discrete) in discretisations(&l) {
            let mut method = position_momentum(discrete);
            let (mut q, mut p, mut refused) = ([0.0, x], [1.0, w], None);
            for k in 0..2000 {
                let before = (q, p);
                if let Err(error) = method.step(f64::from(k) * 0.01, 0.01, &mut q, &mut p) {
                    // Again, from where it was.
                    assert_eq!((q, p), before, "{name}");
                    let again = method.step(f64::from(k) * 0.01, 0.01, &mut q, &mut p);
                    for error in [Err(error), again] {
                        let is_told =
                            matches!(error, Err(StepError::Solve { source: SolveError::NotSeparable { .. }, .. }));
                        assert!(is_told, "{name}: {error:?}");
                    }
                    refused = Some(k + 1);
                    break;
                }
            }
            assert_eq!(refused, Some(step), "{name}: from {far}, mass {mass}, mixed {mixed}");
        }
    }
}

#[test]
fn one_heavy_particle_moves_by_its_mass() {
    // Störmer and Verlet by hand on 2 v²/2 − cos q.
    let l = lagrangian_of(Claimed { bend: 0.0, growth: 0.0 });
    let mut method = position_momentum(Trapezoidal::new(&l));
    let (mut q, mut p) = ([0.3], [1.0]);
    method.step(0.0, 0.5, &mut q, &mut p).expect("explicit");
    let half = 1.0 + 0.25 * 0.3_f64.sin();
    let end = 0.3 + 0.5 * half / 2.0;
    approx::assert_abs_diff_eq!(q[0], end, epsilon = 1e-15);
    approx::assert_abs_diff_eq!(p[0], half + 0.25 * end.sin(), epsilon = 1e-15);
}

#[test]
fn a_lagrangian_is_as_separable_behind_a_reference() {
    let l = Separable(HenonHeiles);
    let borrowed = lagrangian_of(&l);
    assert_eq!(lsvi::Lagrangian::dim(&borrowed), 2);
    assert!(BrokenLine::blanes_moan(&borrowed).is_ok());
}
