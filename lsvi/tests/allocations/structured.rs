//! Steps allocate nothing once the first has set up factors.

use crate::allocations;
use crate::fields::{As, Burgers, By, Line, Plane, Walls};
use lsvi::adaptive::{Radau, Tolerances};
use lsvi::classic::{Bdf2, CoupledRungeKutta, RungeKutta, Tableau};
use lsvi::{AutoField, Integrator, State, Structure, Trajectory, VectorField, method_i};

/// Allocations of ten steps after the first two.
fn of_steps(method: impl Integrator) -> u64 {
    let n = method.dim();
    let v = (1..=n).map(|i| (std::f64::consts::PI * i as f64 / (n + 1) as f64).sin()).collect();
    let mut trajectory = Trajectory::new(method, State::new(0.0, v), 0.01, 1.0).expect("usable");
    let mut step = || assert!(trajectory.step().expect("solvable").is_some());
    step();
    allocations(step)
}

/// Two stages found together: Radau IIA of order 3, A regular, and Lobatto IIIA of order 2, A singular.
fn coupled(field: &dyn VectorField) -> [CoupledRungeKutta<&dyn VectorField>; 2] {
    let radau = [vec![5.0 / 12.0, -1.0 / 12.0], vec![0.75, 0.25]];
    let lobatto = [vec![0.0, 0.0], vec![0.5, 0.5]];
    [(radau, [0.75, 0.25], [1.0 / 3.0, 1.0]), (lobatto, [0.5, 0.5], [0.0, 1.0])]
        .map(|(a, b, c)| CoupledRungeKutta::new(field, &a, &b, &c).expect("sizes that fit"))
}

#[test]
fn steps_allocate_nothing() {
    let line = Line::new(20, 1.0, Walls::Dirichlet);
    let plane = Plane { side: 6 };
    let burgers = AutoField::new(Burgers { cells: 20, viscosity: 0.1 });
    let fields: [&dyn VectorField; 5] =
        [&line, &plane, &burgers, &As(Structure::Dense, &line), &As(Structure::Dense, &burgers)];
    for field in fields {
        assert_eq!(of_steps(method_i(field).expect("usable")), 0);
        assert_eq!(of_steps(Bdf2::new(field).expect("usable")), 0);
        let tolerances = Tolerances::new(1e-6, 1e-6).expect("positive");
        assert_eq!(of_steps(Radau::new(field, tolerances).expect("valid")), 0);
        for tableau in [Tableau::implicit_euler(), Tableau::trapezoidal(), Tableau::sdirk2()] {
            assert_eq!(of_steps(RungeKutta::new(field, tableau).expect("usable")), 0);
        }
        coupled(field).into_iter().for_each(|method| assert_eq!(of_steps(method), 0));
        for by in By::ALL {
            if let Ok(method) = by.method_i(field) {
                assert_eq!(of_steps(method), 0, "{by:?}");
            }
        }
    }
}
