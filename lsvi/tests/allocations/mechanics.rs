//! No step of mechanics or of small dense systems allocates.

use crate::allocations;
use crate::systems::{Damping, DoublePendulum, Falling, Sphere};
use lsvi::classic::{RungeKutta, Tableau};
use lsvi::closure::Linear;
use lsvi::discrete::{
    BrokenLine, Constrainable, DiscreteLegendre, Galerkin, KongYangCircle, Midpoint, PathFitted, Trapezoidal,
};
use lsvi::quadrature::NodeFamily;
use lsvi::{
    AutoConstraint, AutoForce, AutoLagrangian, Constrained, Forced, LagrangianFn, OneStep, Scalar, TwoStep, field,
    least_squares, method_i, method_ii, position_momentum,
};

fn assert_allocation_free(name: &str, method: &mut dyn OneStep, q0: &[f64], p0: &[f64]) {
    let (mut q, mut p) = (q0.to_vec(), p0.to_vec());
    let count = allocations(|| {
        q.copy_from_slice(q0);
        p.copy_from_slice(p0);
        method.step(0.0, 0.05, &mut q, &mut p).expect("short step");
    });
    assert_eq!(count, 0, "{name}");
}

/// A separable Lagrangian.
struct Explicit;

impl LagrangianFn for Explicit {
    fn dim(&self) -> usize {
        2
    }
    fn is_separable(&self) -> bool {
        true
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        (v[0] * v[0] + v[1] * v[1]) * 0.5 + q[0].cos() * q[1].cos()
    }
}

#[test]
fn steps_of_mechanics_do_not_allocate() {
    let free = AutoLagrangian::new(DoublePendulum);
    let damped = Forced::new(&free, AutoForce::new(Damping { dim: 2, rate: 0.1 })).expect("2");
    let discretisations: Vec<Box<dyn DiscreteLegendre>> = vec![
        Box::new(Trapezoidal::new(&free)),
        Box::new(Midpoint::new(&free)),
        Box::new(Galerkin::gauss(&free, 3).expect("s ≥ 1")),
        Box::new(PathFitted::on(&free, NodeFamily::Gauss, 4).expect("m ≥ 2")),
        Box::new(PathFitted::bernstein(&free, &[0.2, 0.7]).expect("nodes")),
        Box::new(Galerkin::lobatto(&damped, 2).expect("s ≥ 1")),
        Box::new(PathFitted::on(&damped, NodeFamily::Equispaced, 3).expect("m ≥ 2")),
    ];
    for (index, discrete) in discretisations.into_iter().enumerate() {
        assert_allocation_free(&index.to_string(), &mut position_momentum(discrete), &[1.0, 2.0], &[0.1, 0.2]);
    }
    let separable = AutoLagrangian::new(Explicit);
    let discretisations: Vec<(&str, Box<dyn DiscreteLegendre>)> = vec![
        ("explicit", Box::new(Trapezoidal::new(&separable))),
        ("broken line", Box::new(BrokenLine::blanes_moan(&separable).expect("separable"))),
        ("separable midpoint", Box::new(Midpoint::new(&separable))),
        ("separable Galerkin", Box::new(Galerkin::gauss(&separable, 3).expect("s ≥ 1"))),
        ("separable path", Box::new(PathFitted::on(&separable, NodeFamily::Gauss, 4).expect("m ≥ 2"))),
    ];
    for (name, discrete) in discretisations {
        assert_allocation_free(name, &mut position_momentum(discrete), &[1.0, 2.0], &[0.1, 0.2]);
    }
    let mut printed = position_momentum(KongYangCircle::new(2));
    assert_allocation_free("kong-yang-circle", &mut printed, &[1.0, 0.0], &[0.0, 1.0]);
    let mut two_step = TwoStep::new(PathFitted::on(&free, NodeFamily::Gauss, 4).expect("m ≥ 2"));
    let (mut before, mut now) = ([1.0, 2.0], [1.0, 2.0]);
    let count = allocations(|| two_step.step(0.0, 0.05, &mut before, &mut now).expect("short step"));
    assert_eq!(count, 0, "two steps");
}

#[test]
fn steps_on_constraints_do_not_allocate() {
    let l = AutoLagrangian::new(Falling { dim: 3 });
    let discretisations: Vec<Box<dyn Constrainable>> = vec![
        Box::new(Trapezoidal::new(&l)),
        Box::new(Galerkin::gauss(&l, 3).expect("s ≥ 1")),
        Box::new(PathFitted::bernstein(&l, &[0.2, 0.7]).expect("nodes")),
    ];
    for (index, discrete) in discretisations.into_iter().enumerate() {
        let sphere = AutoConstraint::new(Sphere { dim: 3 });
        let mut method = Constrained::new(discrete, sphere).expect("dimensions fit");
        assert_allocation_free(&index.to_string(), &mut method, &[0.6, 0.0, -0.8], &[0.4, 1.0, 0.3]);
    }
}

#[test]
fn steps_of_least_squares_do_not_allocate() {
    let van_der_pol = || {
        field!(2, |_t, v, dv| {
            dv[0] = v[1];
            dv[1] = (-v[0] * v[0] + 1.0) * v[1] - v[0];
        })
    };
    let by = |closure: Result<Linear, _>| least_squares(van_der_pol(), closure.expect("a closure")).expect("usable");
    let tableau = |tableau| RungeKutta::new(van_der_pol(), tableau).expect("usable");
    let methods: Vec<(&str, Box<dyn OneStep>)> = vec![
        ("method I", Box::new(method_i(van_der_pol()).expect("usable"))),
        ("method II", Box::new(method_ii(van_der_pol()).expect("usable"))),
        ("(-1/2, 1)", Box::new(by(Linear::new(-0.5, 1.0)))),
        ("fitted", Box::new(by(Linear::fitted(1.0)))),
        ("fitted-pade", Box::new(by(Linear::fitted_pade(1.0)))),
        ("RK4", Box::new(tableau(Tableau::rk4()))),
        ("implicit Euler", Box::new(tableau(Tableau::implicit_euler()))),
        ("TR-BDF2", Box::new(tableau(Tableau::tr_bdf2()))),
        ("SDIRK2", Box::new(tableau(Tableau::sdirk2()))),
    ];
    for (name, mut method) in methods {
        assert_allocation_free(name, &mut *method, &[2.0, 0.0], &[0.0, 0.0]);
    }
}

/// Steps not far before the folds at h = 2.175 and 1 + √2, so long that their roots are followed in pieces.
#[test]
fn long_steps_do_not_allocate() {
    let drag = || field!(1, |_t, v, dv| dv[0] = -v[0] * v[0]);
    for (name, mut method) in [
        ("method I", Box::new(method_i(drag()).expect("usable")) as Box<dyn OneStep>),
        ("trapezoidal", Box::new(RungeKutta::new(drag(), Tableau::trapezoidal()).expect("usable"))),
    ] {
        let mut v = [1.0];
        let pieces = allocations(|| {
            v = [1.0];
            method.step(0.0, 2.0, &mut v, &mut [0.0]).expect("a root");
        });
        assert_eq!(pieces, 0, "{name}");
        assert!(v[0] > -1.0 && v[0] < 1.0, "{name}: {v:?}");
    }
}
