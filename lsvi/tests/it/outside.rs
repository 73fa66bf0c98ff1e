//! Derivatives where a matrix has no entries: every method refuses them, whatever it is stored in.

use lsvi::adaptive::{Radau, Tolerances};
use lsvi::classic::{Bdf2, CoupledRungeKutta, RungeKutta, Tableau};
use lsvi::closure::Linear;
use lsvi::discrete::{Galerkin, Midpoint, Trapezoidal};
use lsvi::quadrature::Quadrature;
use lsvi::solver::{Augmented, Iterative};
use lsvi::{
    AutoField, Factored, FieldFn, InputError, Integrator, Jacobian, Lagrangian, LeastSquares, LeastSquaresStep,
    OneStep, Scalar, SolveError, State, StepError, Structure, Trajectory, Variational, VectorField, Window,
    least_squares, method_i, method_ii,
};

/// v̇ = −v − v³/10 with an entry of its Jacobian at a place where there is none.
#[derive(Clone)]
struct Stray {
    dim: usize,
    structure: Structure,
    at: (usize, usize),
    /// From when on.
    from: f64,
}

impl VectorField for Stray {
    fn dim(&self) -> usize {
        self.dim
    }
    fn structure(&self) -> Structure {
        self.structure.clone()
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv.iter_mut().zip(v).for_each(|(dv, v)| *dv = -v - 0.1 * v.powi(3));
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        v.iter().enumerate().for_each(|(i, v)| out.add(i, i, -scale * (1.0 + 0.3 * v * v)));
        if t >= self.from {
            out.add(self.at.0, self.at.1, scale);
        }
    }
    fn add_curvature(&self, _t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        v.iter().zip(w).enumerate().for_each(|(i, (v, w))| out.add(i, i, -0.6 * v * w * scale));
    }
}

type Made = (&'static str, Result<Box<dyn Integrator>, InputError>);

fn boxed<I: Integrator + 'static>(method: Result<I, InputError>) -> Result<Box<dyn Integrator>, InputError> {
    method.map(|method| Box::new(method) as _)
}

fn methods(f: &Stray) -> Vec<Made> {
    let radau = || Quadrature::radau(2);
    let lagrangian = || LeastSquares::new(f.clone());
    let coupled = || {
        let a = [vec![5.0 / 12.0, -1.0 / 12.0], vec![0.75, 0.25]];
        CoupledRungeKutta::new(f.clone(), &a, &[0.75, 0.25], &[1.0 / 3.0, 1.0])
    };
    let fitted = || Linear::fitted(2.0).and_then(|closure| least_squares(f.clone(), closure));
    let galerkin = || Ok(Variational::new(Galerkin::new(lagrangian()?, 2, &radau()?)?, Linear::METHOD_I));
    let solved = |closure, iterative: bool| {
        boxed(match iterative {
            true => LeastSquaresStep::with_solver(f.clone(), closure, Iterative::new(Factored::default())),
            false => LeastSquaresStep::with_solver(f.clone(), closure, Augmented::new()),
        })
    };
    vec![
        ("Method I", boxed(method_i(f.clone()))),
        ("Method II", boxed(method_ii(f.clone()))),
        ("explicit momentum", boxed(least_squares(f.clone(), Linear::EXPLICIT_MOMENTUM))),
        ("fitted", boxed(fitted())),
        ("Method I, augmented", solved(Linear::METHOD_I, false)),
        ("Method I, iterative", solved(Linear::METHOD_I, true)),
        ("implicit Euler", boxed(RungeKutta::new(f.clone(), Tableau::implicit_euler()))),
        ("bdf2", boxed(Bdf2::new(f.clone()))),
        ("coupled", boxed(coupled())),
        ("Radau", boxed(Tolerances::new(1e-6, 1e-9).and_then(|tolerances| Radau::new(f.clone(), tolerances)))),
        ("window", boxed(lagrangian().and_then(|l| Window::new(Trapezoidal::new(l), 3)))),
        ("midpoint", boxed(lagrangian().map(|l| Variational::new(Midpoint::new(l), Linear::METHOD_I)))),
        ("Galerkin", boxed(galerkin())),
    ]
}

#[test]
fn every_method_refuses_a_derivative_where_its_matrix_has_no_entries() {
    let diagonal = Structure::Banded { lower: 0, upper: 0 };
    let sparse = |n| Structure::sparse(n, []).expect("inside");
    let cases = [
        (1, Structure::Dense, (1, 0)),
        (1, Structure::Dense, (0, 1)),
        (2, Structure::Dense, (1, 2)),
        (2, Structure::Dense, (2, 1)),
        (2, diagonal.clone(), (1, 0)),
        (2, diagonal, (1, 2)),
        (2, sparse(2), (0, 1)),
        (2, sparse(2), (2, 1)),
    ];
    let mut wrong = Vec::new();
    for (dim, structure, at) in cases {
        for from in [0.0, 0.45] {
            let field = Stray { dim, structure: structure.clone(), at, from };
            for (name, method) in methods(&field) {
                let start = State::new(0.0, vec![1.0; dim]);
                let run = Trajectory::new(method.expect(name), start, 0.1, 1.0).expect("valid");
                let outside = SolveError::OutsideStructure { row: at.0, column: at.1 };
                match run.observe(|_| {}) {
                    Err(StepError::Solve { source, .. }) if source == outside => {}
                    other => wrong.push(format!("{name}, {structure:?}, {at:?} from {from}: {other:?}")),
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// ∂L/∂v is a product with the Jacobian, and of one that lacks an entry there is none.
#[test]
fn the_gradient_of_a_least_squares_lagrangian_is_unknown_where_an_entry_is_missing() {
    let sparse = Structure::sparse(3, [(1, 0)]).expect("inside");
    for (structure, at) in
        [(Structure::Dense, (0, 3)), (Structure::Banded { lower: 1, upper: 1 }, (0, 2)), (sparse, (0, 2))]
    {
        let field = Stray { dim: 3, structure: structure.clone(), at, from: 0.45 };
        let lagrangian = LeastSquares::new(field).expect("usable");
        let is_known = |t: f64| {
            let (mut of_v, mut of_rate) = ([0.0; 3], [0.0; 3]);
            lagrangian.gradient(t, &[1.0, 0.5, -0.3], &[0.2; 3], &mut of_v, &mut of_rate);
            of_v.map(|x| !x.is_nan())
        };
        assert_eq!([0.4, 0.5].map(is_known), [[true; 3], [false; 3]], "{structure:?}");
    }
}

/// Eight unknowns in a chain, and a small part of the last in the row of the first.
struct Far(f64);

impl FieldFn for Far {
    fn dim(&self) -> usize {
        8
    }
    fn structure(&self) -> Structure {
        Structure::Banded { lower: 1, upper: 1 }
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        for i in 0..8 {
            dv[i] = v[i.saturating_sub(1)] - v[i] * 2.0 + v[(i + 1).min(7)];
        }
        dv[0] += v[7] * self.0;
    }
}

#[test]
fn a_derivative_that_is_a_small_part_of_its_row_is_refused_too() {
    for part in [1e-2, 1e-4, 1e-6] {
        let mut method = method_i(AutoField::new(Far(part))).expect("usable");
        let found = method.step(0.0, 0.5, &mut [1.0; 8], &mut [0.0; 8]);
        let Err(StepError::Solve { source: SolveError::OutsideStructure { row: 0, column: 7 }, .. }) = found else {
            panic!("{part:e}: {found:?}")
        };
    }
}
