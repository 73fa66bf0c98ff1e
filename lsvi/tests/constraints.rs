//! Holonomic constraints: orders against reduced coordinates, constraint and momentum to rounding, typed errors.

mod systems;

use approx::assert_abs_diff_eq;
use lsvi::discrete::{Constrainable, Galerkin, KongYangCircle, Midpoint, PathFitted, Trapezoidal};
use lsvi::quadrature::NodeFamily;
use lsvi::{
    AutoConstraint, AutoLagrangian, Constrained, ConstraintFn, InputError, OneStep, Scalar, SolveError, State,
    StepError, Trajectory, TwoStep, position_momentum,
};
use systems::{Degenerate, Falling, Free, Pendulum, Sphere};

const EPS: f64 = f64::EPSILON;

/// Every discretisation of the plane pendulum in Cartesian coordinates, with its order.
fn discretisations(l: &AutoLagrangian<Falling>) -> Vec<(String, usize, Box<dyn Constrainable + '_>)> {
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
    let reduced = AutoLagrangian::new(Pendulum);
    let method = position_momentum(Galerkin::gauss(&reduced, 8).expect("s ≥ 1"));
    let end = Trajectory::new(method, State::new(0.0, vec![2.0]), 0.1, 2.0).expect("valid").observe(|_| {});
    let end = end.expect("solvable");
    let (angle, rate) = (end.q[0], end.p[0]);
    let truth = [angle.sin(), -angle.cos(), rate * angle.cos(), rate * angle.sin()];
    let l = AutoLagrangian::new(Falling { dim: 2 });
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
            difference.fold(0.0, f64::max)
        };
        let h = if order > 4 { 0.2 } else { 0.05 };
        let (coarse, fine) = (error(h), error(0.5 * h));
        let measured = (coarse / fine).log2();
        println!("{name}: {measured:.2} of {order}, {coarse:e} {fine:e}");
        if (measured - order as f64).abs() > 0.25 {
            wrong.push(format!("{name}: {measured:.2} instead of {order} ({coarse:e}, {fine:e})"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
