//! Equations of motion in units in which the velocity is a thousand times the position: a step is taken in all units or in none.

use lsvi::classic::{CoupledRungeKutta, RungeKutta, Tableau};
use lsvi::closure::Linear;
use lsvi::discrete::Galerkin;
use lsvi::nalgebra::{Matrix2, Vector2};
use lsvi::quadrature::Quadrature;
use lsvi::{
    AutoField, FieldFn, InputError, Integrator, LeastSquares, OneStep, Scalar, Variational, VectorField, method_i,
};

/// ẍ = −ω² g(x) − 2d ẋ + ω² a(t), with ẋ = `unit` y.
#[derive(Clone, Copy)]
struct Oscillator {
    name: &'static str,
    stiffness: f64,
    damping: f64,
    unit: f64,
    forcing: fn(f64) -> f64,
    spring: Spring,
}

#[derive(Clone, Copy)]
enum Spring {
    Linear,
    Sine,
    Cubic(f64),
}

impl FieldFn for Oscillator {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        let spring = match self.spring {
            Spring::Linear => v[0],
            Spring::Sine => v[0].sin(),
            Spring::Cubic(c) => v[0] + v[0] * v[0] * v[0] * c,
        };
        dv[0] = v[1] * self.unit;
        dv[1] = (T::from((self.forcing)(t)) - spring) * (self.stiffness / self.unit) - v[1] * self.damping;
    }
}

const OSCILLATORS: [Oscillator; 5] = [
    Oscillator { name: "pendulum", stiffness: 1e6, damping: 10.0, unit: 1.0, forcing: |_| 0.0, spring: Spring::Sine },
    Oscillator {
        name: "circuit",
        stiffness: 1e7,
        damping: 500.0,
        unit: 1.0,
        forcing: |t| 1e-4 * (20.0 * t).sin(),
        spring: Spring::Cubic(10.0),
    },
    Oscillator { name: "spring", stiffness: 1e6, damping: 2.0, unit: 1.0, forcing: f64::cos, spring: Spring::Linear },
    Oscillator {
        name: "mild",
        stiffness: 100.0,
        damping: 1.0,
        unit: 1.0,
        forcing: f64::cos,
        spring: Spring::Cubic(0.01),
    },
    Oscillator { name: "swing", stiffness: 981.0, damping: 2.0, unit: 1.0, forcing: |_| 0.0, spring: Spring::Sine },
];

const STEPS: [f64; 11] = [1.0, 0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5];

/// Radau IIA of two stages in its own equations.
fn radau(field: impl VectorField) -> impl OneStep {
    let a = [vec![5.0 / 12.0, -1.0 / 12.0], vec![0.75, 0.25]];
    CoupledRungeKutta::new(field, &a, &[0.75, 0.25], &[1.0 / 3.0, 1.0]).expect("consistent")
}

/// Least squares on a polynomial path, with as many nodes as its degree.
fn least_squares(field: impl VectorField, nodes: Result<Quadrature, InputError>) -> impl OneStep {
    let (lagrangian, nodes) = (LeastSquares::new(field).expect("dense"), nodes.expect("a rule"));
    let degree = nodes.nodes().len();
    Variational::new(Galerkin::new(lagrangian, degree, &nodes).expect("as many nodes as the degree"), Linear::METHOD_I)
}

/// The end of a few steps from (x, ẋ) = (0.1, 0), with ẋ in units of ω so that both are of one size. Each takes evaluations, in whatever units and by
/// whatever equations it is found.
fn end(method: &mut dyn OneStep, field: &Oscillator, h: f64) -> Result<[f64; 2], String> {
    let (mut v, mut p) = ([0.1, 0.0], [0.0; 2]);
    for k in 0..5 {
        let (t, before) = (f64::from(k) * h, method.work().residuals);
        method.step(t, h, &mut v, &mut p).map_err(|error| format!("{}, h = {h}: {error}", field.name))?;
        assert!(method.work().residuals > before, "{}, h = {h}, step {k}: {:?}", field.name, method.work());
    }
    Ok([v[0], v[1] * field.unit / field.stiffness.sqrt()])
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs())
}

/// Runge–Kutta methods are the same in all units; Newton's iteration leaves a few roundings of the larger component, here ω times the
/// smaller, in it, and a step multiplies them by its condition.
#[test]
fn steps_of_runge_kutta_methods_are_taken_in_all_units() {
    let methods = [Tableau::implicit_euler(), Tableau::trapezoidal(), Tableau::implicit_midpoint(), Tableau::sdirk2()];
    for field in OSCILLATORS {
        let even = Oscillator { unit: field.stiffness.sqrt(), ..field };
        for h in STEPS {
            for tableau in &methods {
                let step = |field| RungeKutta::new(AutoField::new(field), tableau.clone()).expect("usable");
                let [found, expected] = [field, even].map(|field| end(&mut step(field), &field, h).expect("a root"));
                let allowed = 64.0 * f64::EPSILON * field.stiffness.sqrt();
                assert!(apart(found, expected) <= allowed, "{}, h = {h}: {found:?}, {expected:?}", field.name);
            }
        }
    }
}

/// The metric of least squares is one of units, but where the residual vanishes its minimum is a method of collocation in all of them.
#[test]
fn least_squares_whose_residual_vanishes_are_solved_in_all_units() {
    for field in OSCILLATORS {
        for h in STEPS {
            let f = || AutoField::new(field);
            let end = |method| end(method, &field, h).expect("a root");
            let stages = |tableau| RungeKutta::new(f(), tableau).expect("usable");
            let pairs = [
                (end(&mut least_squares(f(), Quadrature::radau(1))), end(&mut stages(Tableau::implicit_euler()))),
                (end(&mut least_squares(f(), Quadrature::gauss(1))), end(&mut stages(Tableau::implicit_midpoint()))),
                (end(&mut least_squares(f(), Quadrature::radau(2))), end(&mut radau(f()))),
            ];
            for (found, expected) in pairs {
                let allowed = 64.0 * f64::EPSILON * field.stiffness.sqrt();
                assert!(apart(found, expected) <= allowed, "{}, h = {h}: {found:?}, {expected:?}", field.name);
            }
        }
    }
}

/// The derivative of the momentum is indefinite at the start of many of these steps. In units that are unlike, a long step is the minimum of what
/// has little to do with the solution; where f is linear it is known, (1 + BᵀB) v₁ = v₀ + h f₀ + Bᵀ(v₀ + h a(t₁)), B = 1 − hJ.
#[test]
fn method_i_takes_every_step_of_an_oscillator() {
    for field in OSCILLATORS {
        for h in STEPS {
            let mut method = method_i(AutoField::new(field)).expect("dense");
            let mut v = [0.1, 0.0];
            for k in 0..5 {
                let (t, v0, before) = (f64::from(k) * h, Vector2::from(v), method.work().residuals);
                method.step(t, h, &mut v, &mut [0.0; 2]).unwrap_or_else(|error| panic!("{}: {error}", field.name));
                assert!(method.work().residuals > before, "{}, h = {h}, step {k}: {:?}", field.name, method.work());
                if !matches!(field.spring, Spring::Linear) {
                    continue;
                }
                let force = |t: f64| Vector2::new(0.0, field.stiffness * (field.forcing)(t));
                let j = Matrix2::new(0.0, 1.0, -field.stiffness, -field.damping);
                let b = Matrix2::identity() - j * h;
                let known = v0 + (j * v0 + force(t)) * h + b.tr_mul(&(v0 + force(t + h) * h));
                let expected = (Matrix2::identity() + b.tr_mul(&b)).try_inverse().expect("definite") * known;
                // The eigenvalues of 1 + BᵀB are from 1 on, and its entries are up to (hω²)², as are the terms of what is known.
                let condition = 1.0 + (h * field.stiffness).powi(2);
                let allowed = 64.0 * f64::EPSILON * condition * expected.amax().max(1.0);
                assert!((Vector2::from(v) - expected).amax() <= allowed, "h = {h}: {v:?}, {expected:?}");
            }
        }
    }
}
