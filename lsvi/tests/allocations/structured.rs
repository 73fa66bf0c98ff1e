//! Steps allocate nothing once the first has set up factors.

use crate::allocations;
use crate::fields::{As, Burgers, By, Line, Plane, Walls};
use lsvi::adaptive::{Radau, Tolerances};
use lsvi::classic::{Bdf2, CoupledRungeKutta, RungeKutta, Tableau};
use lsvi::closure::Linear;
use lsvi::discrete::{Galerkin, Trapezoidal};
use lsvi::quadrature::Quadrature;
use lsvi::{
    AutoField, FieldFn, Integrator, Jacobian, LeastSquares, Mass, Scalar, State, Structure, Trajectory, Variational,
    VectorField, Window, method_i,
};

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

/// Nonlinear in each component, with a mass.
struct Heavy(Mass);

impl FieldFn for Heavy {
    fn dim(&self) -> usize {
        20
    }
    fn mass(&self) -> Mass {
        self.0.clone()
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        let n = v.len();
        for i in 0..n {
            dv[i] = -v[i] * v[i] + v[(i + 1) % n] * (0.1 * t);
        }
    }
}

/// Of products of full matrices those of more than a few columns are where a kernel would pack its operands.
#[test]
fn steps_of_least_squares_in_a_metric_allocate_nothing() {
    let mut full = Jacobian::zeros(20);
    for i in 0..20 {
        (0..20).for_each(|j| full.add(i, j, 0.5_f64.powi((i as i32 - j as i32).abs())));
    }
    for mass in [Mass::Identity, Mass::Diagonal(vec![2.0; 20]), Mass::Matrix(full)] {
        let least_squares = || LeastSquares::new(AutoField::new(Heavy(mass.clone()))).expect("a metric");
        let name = format!("{mass:?}").chars().take(8).collect::<String>();
        assert_eq!(of_steps(Window::new(Trapezoidal::new(least_squares()), 4).expect("four")), 0, "{name}");
        let radau = Quadrature::radau(2).expect("two nodes");
        let galerkin = Galerkin::new(least_squares(), 2, &radau).expect("a path");
        assert_eq!(of_steps(Variational::new(galerkin, Linear::METHOD_I)), 0, "{name}");
    }
}
