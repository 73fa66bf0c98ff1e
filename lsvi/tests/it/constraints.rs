//! Holonomic constraints: orders against reduced coordinates, constraint and momentum to rounding, typed errors.

use crate::systems::{AnyLagrangian, lagrangian_of};
use crate::systems::{Degenerate, Falling, Free, Pendulum, Sphere};
use approx::assert_abs_diff_eq;
use lsvi::discrete::{Constrainable, Galerkin, KongYangCircle, Midpoint, PathFitted, Trapezoidal};
use lsvi::quadrature::NodeFamily;
use lsvi::{
    AutoConstraint, Constrained, Constraint, ConstraintError, ConstraintFn, InputError, Integrator, LagrangianFn,
    OneStep, Scalar, SolveError, State, StepError, SystemError, Trajectory, TwoStep, position_momentum,
};

const EPS: f64 = f64::EPSILON;

/// Every discretisation of the plane pendulum in Cartesian coordinates, with its order.
fn discretisations<'a>(l: &'a AnyLagrangian) -> Vec<(String, usize, Box<dyn Constrainable + 'a>)> {
    let mut all: Vec<(String, usize, Box<dyn Constrainable>)> = vec![
        ("trapezoidal".into(), 2, Box::new(Trapezoidal::new(l))),
        ("midpoint".into(), 2, Box::new(Midpoint::new(l))),
    ];
    for m in 2..=5 {
        for family in [NodeFamily::Equispaced, NodeFamily::Gauss, NodeFamily::Lobatto, NodeFamily::Chebyshev] {
            let order = if family == NodeFamily::Gauss { 2 * (m - 1) } else { 2 * (m / 2) };
            let discrete = PathFitted::on(l, family, m).expect("m ≥ 2");
            all.push((format!("path-fitted({m},{family:?})"), order, Box::new(discrete)));
        }
    }
    for s in 1..=4 {
        all.push((format!("galerkin-gauss({s})"), 2 * s, Box::new(Galerkin::gauss(l, s).expect("s ≥ 1"))));
        all.push((format!("galerkin-lobatto({s})"), 2 * s, Box::new(Galerkin::lobatto(l, s).expect("s ≥ 1"))));
    }
    all
}

fn circle() -> AutoConstraint<Sphere> {
    AutoConstraint::new(Sphere { dim: 2 })
}

#[test]
fn orders_on_the_circle_are_those_of_the_reduced_pendulum() {
    let reduced = lagrangian_of(Pendulum);
    let method = position_momentum(Galerkin::gauss(&reduced, 8).expect("s ≥ 1"));
    let end = Trajectory::new(method, State::new(0.0, vec![2.0]), 0.1, 2.0).expect("valid").observe(|_| {});
    let end = end.expect("solvable");
    let (angle, rate) = (end.q[0], end.p[0]);
    let truth = [angle.sin(), -angle.cos(), rate * angle.cos(), rate * angle.sin()];
    let l = lagrangian_of(Falling { dim: 2 });
    let initial = State::new(0.0, vec![2f64.sin(), -2f64.cos()]);
    let mut wrong = Vec::new();
    for index in 0..discretisations(&l).len() {
        let (name, order, _) = discretisations(&l).swap_remove(index);
        let error = |h: f64| {
            let discrete = discretisations(&l).swap_remove(index).2;
            let method = Constrained::new(discrete, circle()).expect("dimensions fit");
            let end = Trajectory::new(method, initial.clone(), h, 2.0).expect("valid").observe(|_| {});
            let end = end.expect("solvable");
            let difference = end.q.iter().chain(&end.p).zip(truth).map(|(a, b)| (a - b).abs());
            difference.max_by(f64::total_cmp).expect("entries")
        };
        // As short as the rounding of 1e-13 that the steps add up to lets the errors be.
        let h = match order {
            8 => 0.25,
            6 => 0.2,
            _ => 0.05,
        };
        let (coarse, fine) = (error(h), error(0.5 * h));
        let measured = (coarse / fine).log2();
        if !(0.0..=0.25).contains(&(measured - order as f64).abs()) {
            wrong.push(format!("{name}: {measured:.2} instead of {order} ({coarse:e}, {fine:e})"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Where the end of a step leaps as its length grows, by bisection, Newton's iteration has come to another branch; behind the end of a branch no
/// step succeeds. Of two halves the one on which the end moves further is followed until it has come to rest.
#[test]
fn steps_on_the_circle_keep_to_their_branch() {
    const LONGEST: f64 = 5.0;
    const NARROW: f64 = 1e-6;
    const PARTS: u32 = 25;
    let l = lagrangian_of(Falling { dim: 2 });
    let (mut wrong, mut ends, mut followed) = (Vec::new(), 0, 0);
    for rate in [0.0, 0.3, 2.0] {
        for (name, _, discrete) in discretisations(&l) {
            let mut method = Constrained::new(discrete, circle()).expect("dimensions fit");
            let mut step = |h: f64| {
                let (mut q, mut p) = ([2f64.sin(), -2f64.cos()], [rate * 2f64.cos(), rate * 2f64.sin()]);
                method.step(0.0, h, &mut q, &mut p).map(|()| q)
            };
            let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
            let (mut last, mut end) = ((0.0, [2f64.sin(), -2f64.cos()]), f64::INFINITY);
            for k in 1..=PARTS {
                let h = LONGEST * f64::from(k) / f64::from(PARTS);
                // Behind the end of the branch a few tell as much, and that none succeeds takes a long search.
                if end < h && k % 5 != 0 {
                    continue;
                }
                let found = match step(h) {
                    Ok(q) => q,
                    Err(StepError::Solve { source: SolveError::BranchLost { reached }, .. }) => {
                        (end, ends) = (end.min(reached), ends + 1);
                        continue;
                    }
                    Err(_) => continue,
                };
                if end < h {
                    wrong.push(format!("{name}, {rate}: {found:?} at h = {h}, and the branch ends at {end}"));
                }
                let (mut low, mut high, at_rest) = (last, (h, found), 1e-3 * apart(last.1, found) + 1e-5);
                last = (h, found);
                while high.0 - low.0 > NARROW && apart(low.1, high.1) > at_rest {
                    let middle = 0.5 * (low.0 + high.0);
                    let Ok(q) = step(middle) else { break };
                    if apart(low.1, q) >= apart(q, high.1) { high = (middle, q) } else { low = (middle, q) }
                }
                let moves = apart(low.1, high.1) > at_rest;
                followed += u32::from(!moves);
                if moves && high.0 - low.0 <= NARROW {
                    wrong.push(format!("{name}, {rate}: from {:?} to {:?} at h = {}", low.1, high.1, high.0));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(ends > 0 && followed > 0, "{ends} ends, {followed} pieces");
}

/// Spherical pendulum: the constraint, the hidden constraint and the angular momentum about the vertical.
#[test]
fn spherical_pendulum_keeps_constraints_and_angular_momentum_to_rounding() {
    let l = lagrangian_of(Falling { dim: 3 });
    let initial = State::new(0.0, vec![0.6, 0.0, -0.8]).with_momentum(vec![0.4, 1.0, 0.3]);
    let run = |discrete: Box<dyn Constrainable>| {
        let mut method = Constrained::new(discrete, AutoConstraint::new(Sphere { dim: 3 })).expect("dimensions fit");
        let mut trajectory = Trajectory::new(&mut method, initial.clone(), 0.1, 20.0).expect("valid");
        let (mut position, mut hidden, mut vertical) = (0.0_f64, 0.0_f64, 0.0_f64);
        while let Some(State { q, p, .. }) = trajectory.step().expect("solvable") {
            position = position.max((q.iter().map(|x| x * x).sum::<f64>() - 1.0).abs());
            hidden = hidden.max(q.iter().zip(p).map(|(q, p)| q * p).sum::<f64>().abs());
            vertical = vertical.max((q[0] * p[1] - q[1] * p[0] - 0.6).abs());
        }
        (position, hidden, vertical)
    };
    let conserving: Vec<Box<dyn Constrainable>> = vec![
        Box::new(Trapezoidal::new(&l)),
        Box::new(Midpoint::new(&l)),
        Box::new(Galerkin::gauss(&l, 2).expect("s ≥ 1")),
        Box::new(Galerkin::lobatto(&l, 3).expect("s ≥ 1")),
        Box::new(PathFitted::on(&l, NodeFamily::Gauss, 2).expect("m ≥ 2")),
        Box::new(PathFitted::on(&l, NodeFamily::Gauss, 4).expect("m ≥ 2")),
    ];
    for discrete in conserving {
        let (position, hidden, vertical) = run(discrete);
        assert!(position < 16.0 * EPS, "{position:e}");
        assert!(hidden < 16.0 * EPS, "{hidden:e}");
        // 200 steps, each with the rounding ε m²/h of a momentum.
        assert!(vertical < 200.0 * 160.0 * EPS, "{vertical:e}");
    }
    let (position, hidden, vertical) = run(Box::new(PathFitted::on(&l, NodeFamily::Equispaced, 3).expect("m ≥ 2")));
    assert!(position < 16.0 * EPS && hidden < 16.0 * EPS, "{position:e}, {hidden:e}");
    assert!(vertical > 1e-6, "equispaced nodes do not conserve angular momentum, but it drifts by {vertical:e} only");
}

#[test]
fn the_printed_circle_scheme_is_its_formula_and_grows_as_predicted() {
    let angle = |x: f64| [x.cos(), x.sin()];
    let mut scheme = TwoStep::new(KongYangCircle::new(2));
    let tau = 1e-3;
    let (mut before, mut now) = (angle(0.0), angle(tau));
    now[0] *= 1.0 + 1e-9;
    now[1] *= 1.0 + 1e-9;
    let mut radial = Vec::new();
    for _ in 0..8 {
        let (x0, x1) = (before, now);
        scheme.step(0.0, tau, &mut before, &mut now).expect("regular");
        let norm = |a: [f64; 2], b: [f64; 2]| (a[0] + b[0]).hypot(a[1] + b[1]);
        for i in 0..2 {
            let middles = (x1[i] + now[i]) / norm(x1, now) + (x0[i] + x1[i]) / norm(x0, x1);
            assert_abs_diff_eq!(x0[i] + 6.0 * x1[i] + now[i], 4.0 * middles, epsilon = 64.0 * EPS);
        }
        radial.push(now[0].hypot(now[1]) - 1.0);
    }
    // From the third step on the growing mode dominates the other by 5.8² each step; τ² = 1e-6 is the angle's effect.
    let growth = radial[7] / radial[6];
    assert_abs_diff_eq!(growth, -(3.0 + 8f64.sqrt()), epsilon = 1e-3);
}

#[test]
fn several_constraints_hold_together() {
    /// Two rods of unit length from the origin: a plane double pendulum.
    struct Rods;
    impl ConstraintFn for Rods {
        fn dim(&self) -> usize {
            4
        }
        fn count(&self) -> usize {
            2
        }
        fn constraint<T: Scalar>(&self, q: &[T], out: &mut [T]) {
            out[0] = q[0] * q[0] + q[1] * q[1] - 1.0;
            out[1] = (q[2] - q[0]).powi(2) + (q[3] - q[1]).powi(2) - 1.0;
        }
    }
    let l = lagrangian_of(Free { dim: 4 });
    let mut method =
        Constrained::new(Galerkin::gauss(&l, 3).expect("s ≥ 1"), AutoConstraint::new(Rods)).expect("dimensions fit");
    let mut state = State::new(0.0, vec![1.0, 0.0, 1.0, 1.0]).with_momentum(vec![0.3, 0.5, -0.7, 0.2]);
    method.project(0.0, &state.q, &mut state.p).expect("independent");
    let energy = |s: &State| 0.5 * s.p.iter().map(|p| p * p).sum::<f64>();
    let spin = |s: &State| s.q[0] * s.p[1] - s.q[1] * s.p[0] + s.q[2] * s.p[3] - s.q[3] * s.p[2];
    let (e, j) = (energy(&state), spin(&state));
    let end = Trajectory::new(&mut method, state, 0.05, 5.0).expect("valid").observe(|_| {}).expect("solvable");
    // Energy to the order h⁶ of the method, angular momentum to the rounding of 100 steps.
    assert_abs_diff_eq!(energy(&end), e, epsilon = 1e-8);
    assert_abs_diff_eq!(spin(&end), j, epsilon = 100.0 * 200.0 * EPS);
}

#[test]
fn bad_constraints_have_typed_errors() {
    /// The circle twice.
    struct Twice;
    impl ConstraintFn for Twice {
        fn dim(&self) -> usize {
            2
        }
        fn count(&self) -> usize {
            2
        }
        fn constraint<T: Scalar>(&self, q: &[T], out: &mut [T]) {
            out[0] = q[0] * q[0] + q[1] * q[1] - 1.0;
            out[1] = out[0] * 3.0;
        }
    }
    let l = lagrangian_of(Falling { dim: 2 });
    let step = |method: &mut dyn OneStep, q: [f64; 2], p: [f64; 2]| {
        let (mut q1, mut p1) = (q, p);
        let error = method.step(0.0, 0.1, &mut q1, &mut p1).err();
        assert!(error.is_none() || (q1, p1) == (q, p), "a failed step leaves the state as it was");
        error
    };
    let mut method = Constrained::new(Trapezoidal::new(&l), circle()).expect("dimensions fit");
    assert_eq!(step(&mut method, [0.0, -1.0], [1.0, 0.0]), None);
    let off = step(&mut method, [0.0, -1.1], [1.0, 0.0]);
    assert!(
        matches!(off, Some(StepError::Input(InputError::Constraint(ConstraintError::OffConstraint { index: 0, .. })))),
        "{off:?}"
    );
    let hidden = step(&mut method, [0.0, -1.0], [1.0, 0.5]);
    let hidden_expected = matches!(
        hidden,
        Some(StepError::Input(InputError::Constraint(ConstraintError::OffHiddenConstraint { index: 1, value }))) if (value - 0.5).abs() < 8.0 * EPS
    );
    assert!(hidden_expected, "{hidden:?}");
    let mut twice = Constrained::new(Trapezoidal::new(&l), AutoConstraint::new(Twice)).expect("dimensions fit");
    let redundant = step(&mut twice, [0.0, -1.0], [1.0, 0.0]);
    let expected =
        StepError::Input(InputError::Constraint(ConstraintError::RedundantConstraints { count: 2, rank: 1 }));
    assert_eq!(redundant, Some(expected));
    let degenerate = lagrangian_of(Degenerate);
    let mut massless = Constrained::new(Galerkin::gauss(&degenerate, 2).expect("s ≥ 1"), circle()).expect("fits");
    let singular = step(&mut massless, [0.0, -1.0], [0.0, 0.0]);
    assert!(matches!(singular, Some(StepError::Solve { source: SolveError::SingularMass, .. })), "{singular:?}");
    let space = AutoConstraint::new(Sphere { dim: 3 });
    let wrong = Constrained::new(Trapezoidal::new(&l), space).err();
    assert_eq!(wrong, Some(InputError::System(SystemError::Dimension { what: "constraint", expected: 2, found: 3 })));
}

#[test]
fn how_far_off_a_state_may_be_goes_by_its_size_and_the_way_of_a_step() {
    let l = lagrangian_of(Free { dim: 2 });
    let step = |off: f64, speed: f64, h: f64| {
        let mut method = Constrained::new(Trapezoidal::new(&l), circle()).expect("dimensions fit");
        let (mut q, mut p) = ([1.0 + off, 0.0], [0.0, speed]);
        method.step(0.0, h, &mut q, &mut p).map(|()| q)
    };
    let is_off = |step: Result<[f64; 2], StepError>| {
        matches!(step, Err(StepError::Input(InputError::Constraint(ConstraintError::OffConstraint { index: 0, .. }))))
    };
    // |q| = 1 and h |v|, by 1.5e-8.
    assert!(step(1e-9, 0.0, 1e-6).is_ok() && step(1e-9, 1e-3, 1e-6).is_ok());
    assert!(is_off(step(1e-7, 100.0, 1e-3)) && is_off(step(1e-7, 1e-8, 1e-3)) && is_off(step(1e-7, 0.0, 1e-3)));
    assert!(step(1e-8, 9.0, 0.1).is_ok(), "a step as long as 0.9");
    assert!(is_off(step(2e-8, 1e-6, 0.1)) && step(2e-8, 9.0, 0.1).is_ok());
}

/// Half of the digits of |p| = 1: the part of p across the circle is what projecting it takes away.
#[test]
fn how_far_off_a_momentum_may_be_goes_by_its_size() {
    let l = lagrangian_of(Free { dim: 2 });
    let step = |off: f64| {
        let mut method = Constrained::new(Trapezoidal::new(&l), circle()).expect("dimensions fit");
        method.step(0.0, 1e-3, &mut [1.0, 0.0], &mut [off, 1.0])
    };
    assert_eq!(step(0.5 * EPS.sqrt()), Ok(()));
    let refused = step(8.0 * EPS.sqrt());
    let is_hidden = |error: &StepError| {
        matches!(error, StepError::Input(InputError::Constraint(ConstraintError::OffHiddenConstraint { index: 0, .. })))
    };
    assert!(refused.as_ref().is_err_and(is_hidden), "{refused:?}");
}

/// At rest on a circle of radius r, f is like its tangent within |∇f| / |∇²f| = 2r / √8, by a Frobenius norm.
#[test]
fn how_far_off_a_state_may_be_goes_by_the_curvature_of_the_constraint() {
    let l = lagrangian_of(Free { dim: 2 });
    for (length, pivot) in [(1e-3, 0.0), (1.0, 0.0), (1e3, 0.0), (0.02, 1.0), (3.0, 64.0)] {
        let allowed = EPS.sqrt() * length / 2_f64.sqrt();
        let step = |part: f64| {
            let rod = AutoConstraint::new(Rod { length, pivot, unit: 1.0 });
            let mut method = Constrained::new(Trapezoidal::new(&l), rod).expect("dimensions fit");
            method.step(0.0, 1e-3, &mut [pivot + length + part * allowed, 0.0], &mut [0.0, 0.0])
        };
        let case = format!("length {length}, pivot {pivot}");
        step(0.98).unwrap_or_else(|error| panic!("{case}: {error}"));
        let found = step(1.02);
        assert!(
            matches!(
                found,
                Err(StepError::Input(InputError::Constraint(ConstraintError::OffConstraint { index: 0, .. })))
            ),
            "{case}: {found:?}"
        );
    }
}

/// So far away that half of the digits of the radius are fewer than those to which the state can be written down.
#[test]
fn a_small_circle_far_away_is_known_to_rounding() {
    let (l, length) = (lagrangian_of(Free { dim: 2 }), 1e-3);
    for pivot in [1e6, -3e7] {
        let rod = AutoConstraint::new(Rod { length, pivot, unit: 1.0 });
        let mut method = Constrained::new(Trapezoidal::new(&l), rod).expect("dimensions fit");
        let (mut q, mut p) = ([pivot + 0.6 * length, 0.8 * length], [0.0, 0.0]);
        method.step(0.0, 1e-3, &mut q, &mut p).unwrap_or_else(|error| panic!("pivot at {pivot}: {error}"));
    }
}

/// A sphere twice, the second time with a part of z: what is singular is their product and not the mass.
#[test]
fn constraints_that_are_one_but_for_half_of_the_digits_are_redundant() {
    struct Twice(f64);
    impl ConstraintFn for Twice {
        fn dim(&self) -> usize {
            3
        }
        fn count(&self) -> usize {
            2
        }
        fn constraint<T: Scalar>(&self, q: &[T], out: &mut [T]) {
            out[0] = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] - 1.0;
            out[1] = out[0] + q[2] * self.0;
        }
    }
    let l = lagrangian_of(Free { dim: 3 });
    let project = |part: f64| {
        let rod = AutoConstraint::new(Twice(part));
        let mut method = Constrained::new(Trapezoidal::new(&l), rod).expect("dimensions fit");
        method.project(0.0, &[1_f64.sin(), -1_f64.cos(), 0.0], &mut [0.5, 0.3, 0.2])
    };
    project(1e-4).expect("independent");
    for part in [1e-8, 1e-10, 1e-12, 1e-14, 0.0] {
        let found = project(part);
        let expected = InputError::Constraint(ConstraintError::RedundantConstraints { count: 2, rank: 1 });
        assert!(matches!(&found, Err(StepError::Input(error)) if *error == expected), "{part:e}: {found:?}");
    }
}

/// Gradients along two axes of a mass that has none along the third, and one that vanishes.
#[test]
fn a_singular_mass_is_not_taken_for_gradients_of_different_lengths() {
    struct Flat(f64);
    impl LagrangianFn for Flat {
        fn dim(&self) -> usize {
            3
        }
        fn lagrangian<T: Scalar>(&self, _t: T, _q: &[T], v: &[T]) -> T {
            (v[0] * v[0] + v[1] * v[1]) * (0.5 * self.0)
        }
    }
    struct Axes(f64);
    impl ConstraintFn for Axes {
        fn dim(&self) -> usize {
            3
        }
        fn count(&self) -> usize {
            2
        }
        fn constraint<T: Scalar>(&self, q: &[T], out: &mut [T]) {
            out[0] = q[0];
            out[1] = q[1] * self.0;
        }
    }
    let project = |mass: f64, length: f64| {
        let l = lagrangian_of(Flat(mass));
        let axes = AutoConstraint::new(Axes(length));
        let mut method = Constrained::new(Galerkin::gauss(&l, 2).expect("s ≥ 1"), axes).expect("dimensions fit");
        method.project(0.0, &[0.0, 0.0, 1.0], &mut [0.5 * mass, 0.3 * mass, 0.0]).expect_err("singular")
    };
    // Gradients are measured in the unit of the mass.
    for mass in [1e-12, 1.0, 1e12] {
        for length in [1e-12, 1e-3, 1.0, 1e3, 1e12] {
            let found = project(mass, length);
            let is_told = matches!(found, StepError::Solve { source: SolveError::SingularMass, .. });
            assert!(is_told, "{mass:e}, {length:e}: {found:?}");
        }
        let redundant = InputError::Constraint(ConstraintError::RedundantConstraints { count: 2, rank: 1 });
        assert_eq!(project(mass, 0.0), StepError::Input(redundant), "{mass:e}");
    }
}

/// x² + y² = 1 at the height ½.
struct Rim;

impl ConstraintFn for Rim {
    fn dim(&self) -> usize {
        3
    }
    fn count(&self) -> usize {
        2
    }
    fn constraint<T: Scalar>(&self, q: &[T], out: &mut [T]) {
        out[0] = q[0] * q[0] + q[1] * q[1] - 1.0;
        out[1] = q[2] - 0.5;
    }
}

#[test]
fn constraints_in_a_box_hold_as_they_do_outside() {
    let l = lagrangian_of(Falling { dim: 3 });
    let run = |constraint: Box<dyn Constraint>| {
        let mut method = Constrained::new(Galerkin::gauss(&l, 2).expect("s ≥ 1"), constraint).expect("dimensions fit");
        let (mut q, mut p) = ([0.6, -0.8, 0.5], [0.8, 0.6, 0.0]);
        (0..10).for_each(|k| method.step(f64::from(k) * 0.1, 0.1, &mut q, &mut p).expect("solvable"));
        assert_eq!(method.work().steps, 10);
        assert!(method.work().residuals > 20);
        (q, p)
    };
    let (q, p) = run(Box::new(AutoConstraint::new(Rim)));
    assert_eq!(run(Box::new(Box::new(AutoConstraint::new(Rim)) as Box<dyn Constraint>)), (q, p));
    assert_abs_diff_eq!(q[0].hypot(q[1]), 1.0, epsilon = 16.0 * EPS);
    assert_abs_diff_eq!(q[2], 0.5, epsilon = 16.0 * EPS);
}

#[test]
fn a_start_off_the_second_constraint_is_refused_like_one_off_the_first() {
    let l = lagrangian_of(Free { dim: 3 });
    let mut method = Constrained::new(Trapezoidal::new(&l), AutoConstraint::new(Rim)).expect("dimensions fit");
    for (q, index, off) in [([1.1, 0.0, 0.5], 0, 0.21), ([1.0, 0.0, 0.6], 1, 0.1)] {
        let found = method.step(0.0, 0.1, &mut q.clone(), &mut [0.0; 3]);
        let is_told = matches!(
            found,
            Err(StepError::Input(InputError::Constraint(ConstraintError::OffConstraint { index: k, value })))
                if k == index && (value - off).abs() < 1e-12
        );
        assert!(is_told, "{q:?}: {found:?}");
    }
}

/// A rod of a length about a pivot on the x axis, f in a unit, and a point of a mass on it in a field g.
struct Rod {
    length: f64,
    pivot: f64,
    unit: f64,
}

impl ConstraintFn for Rod {
    fn dim(&self) -> usize {
        2
    }
    fn count(&self) -> usize {
        1
    }
    fn constraint<T: Scalar>(&self, q: &[T], out: &mut [T]) {
        let x = q[0] - self.pivot;
        out[0] = (x * x + q[1] * q[1] - self.length * self.length) * self.unit;
    }
}

struct Weight {
    mass: f64,
    g: f64,
}

impl lsvi::LagrangianFn for Weight {
    fn dim(&self) -> usize {
        2
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        (v[0] * v[0] + v[1] * v[1]) * (0.5 * self.mass) - q[1] * (self.mass * self.g)
    }
}

#[test]
fn constrained_motions_are_the_same_in_all_units() {
    let end = |name: &str, mass: f64, length: f64, g: f64, unit: f64| -> Vec<f64> {
        let (l, rod) = (lagrangian_of(Weight { mass, g }), AutoConstraint::new(Rod { length, pivot: 0.0, unit }));
        let period = (length / g).sqrt();
        let method: Box<dyn Integrator + '_> = match name {
            "RATTLE" => Box::new(Constrained::new(Trapezoidal::new(&l), rod).expect("dimensions fit")),
            "gauss" => Box::new(Constrained::new(Galerkin::gauss(&l, 3).expect("s ≥ 1"), rod).expect("dimensions fit")),
            _ => Box::new(
                Constrained::new(PathFitted::on(&l, NodeFamily::Gauss, 3).expect("m ≥ 2"), rod)
                    .expect("dimensions fit"),
            ),
        };
        let run = Trajectory::new(method, State::new(0.0, vec![length, 0.0]), period / 50.0, 3.0 * period);
        let case = format!("{name}, mass {mass:e}, length {length:e}, g {g:e}, f in {unit:e}");
        let end = run.expect("valid").observe(|_| {}).unwrap_or_else(|error| panic!("{case}: {error}"));
        end.q.iter().map(|q| q / length).chain(end.p.iter().map(|p| p / (mass * (length * g).sqrt()))).collect()
    };
    for name in ["RATTLE", "gauss", "path-fitted"] {
        let right = end(name, 1.0, 1.0, 1.0, 1.0);
        for (mass, length, g, unit) in [
            (1e-26, 1.0, 1.0, 1.0),
            (1e26, 1.0, 1.0, 1.0),
            (1.0, 1.0, 1.0, 1e-12),
            (1.0, 1.0, 1.0, 1e15),
            (1e-26, 1e-10, 1e13, 1.0),
            (6e24, 4e8, 9.81, 1e-3),
        ] {
            let found = end(name, mass, length, g, unit);
            for (a, b) in found.iter().zip(&right) {
                assert!((a - b).abs() <= 1e-11, "{name}, {mass:e}, {length:e}, {g:e}, {unit:e}: {found:?}, {right:?}");
            }
        }
    }
}

/// Makes the motions of a Lagrangian on the rods.
type Make<L> = for<'a> fn(&'a L, AutoConstraint<Rods>) -> Box<dyn Integrator + 'a>;

/// A double pendulum whose two rods are told in units of their own.
struct Rods([f64; 2]);

impl ConstraintFn for Rods {
    fn dim(&self) -> usize {
        4
    }
    fn count(&self) -> usize {
        2
    }
    fn constraint<T: Scalar>(&self, q: &[T], out: &mut [T]) {
        let (x, y) = (q[2] - q[0], q[3] - q[1]);
        out[0] = (q[0] * q[0] + q[1] * q[1] - 1.0) * self.0[0];
        out[1] = (x * x + y * y - 1.0) * self.0[1];
    }
}

struct Two;

impl lsvi::LagrangianFn for Two {
    fn dim(&self) -> usize {
        4
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        v.iter().fold(-q[1] - q[3], |l, v| l + *v * *v * 0.5)
    }
}

#[test]
fn each_constraint_may_have_a_unit_of_its_own() {
    let l = lagrangian_of(Two);
    for (path, make) in [
        ("RATTLE", (|l, k| Box::new(Constrained::new(Trapezoidal::new(l), k).expect("fits"))) as Make<_>),
        ("gauss", |l, k| Box::new(Constrained::new(Galerkin::gauss(l, 2).expect("s ≥ 1"), k).expect("fits"))),
        ("path-fitted", |l, k| {
            Box::new(Constrained::new(PathFitted::on(l, NodeFamily::Gauss, 3).expect("m ≥ 2"), k).expect("fits"))
        }),
    ] {
        let end = |units: [f64; 2]| {
            let run = Trajectory::new(
                make(&l, AutoConstraint::new(Rods(units))),
                State::new(0.0, vec![1.0, 0.0, 2.0, 0.0]),
                0.02,
                2.0,
            );
            run.expect("valid").observe(|_| {}).unwrap_or_else(|error| panic!("{path}, {units:?}: {error}")).q
        };
        let right = end([1.0; 2]);
        for units in [[1e-8, 1.0], [1.0, 1e12], [1e10, 1e-10]] {
            let found = end(units);
            // Roundings of a hundred steps.
            assert!(
                found.iter().zip(&right).all(|(a, b)| (a - b).abs() < 1e-11),
                "{path}, {units:?}: {found:?}, {right:?}"
            );
        }
    }
}

#[test]
fn a_state_off_the_constraint_is_refused_wherever_coordinates_are_counted_from() {
    for pivot in [0.0, 6.4e6, -1e8] {
        let step = |off: f64| {
            let (l, rod) = (
                lagrangian_of(Weight { mass: 2.0, g: 9.81 }),
                AutoConstraint::new(Rod { length: 1.0, pivot, unit: 1.0 }),
            );
            let mut method = Constrained::new(Trapezoidal::new(&l), rod).expect("dimensions fit");
            method.step(0.0, 0.01, &mut [pivot + 0.6 + off, 0.8], &mut [0.0, 0.0])
        };
        step(0.0).unwrap_or_else(|error| panic!("pivot at {pivot}: {error}"));
        for off in [0.05, -1e-4] {
            let found = step(off);
            let is_refused = matches!(
                found,
                Err(StepError::Input(InputError::Constraint(ConstraintError::OffConstraint { index: 0, value })))
                    if (value - 1.2 * off - off * off).abs() <= 1e-6
            );
            assert!(is_refused, "pivot at {pivot}, {off} off: {found:?}");
        }
    }
}
