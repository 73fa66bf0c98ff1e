//! Method I on systems with structure, at a cost linear in the number of entries.
//!
//! In the natural metric M⁻¹, Method I minimises the action ¼h (r₀ᵀM⁻¹r₀ + r₁ᵀM⁻¹r₁) of one step over the new value v₁,
//! r = M (v₁ − v₀)/h − f. With B = M − h f_v its Gauss–Newton matrix M + BᵀM⁻¹B is symmetric positive definite for every f,
//! but has the square of the condition number of B. The step is therefore solved in one of three [`Formulation`]s.

mod augmented;
mod conjugate_gradients;
mod full_newton;
mod gauss_newton;
mod linear;
mod step_matrix;
mod twisted;

pub use step_matrix::Formulation;

use full_newton::FullNewton;
use gauss_newton::GaussNewton;
use linear::LinearStep;

use crate::closure::Linear;
use crate::discrete::{Interval, Trapezoidal};
use crate::error::{InputError, StepError, check_step, check_vector};
use crate::integrator::{Grid, Integrator, OneStep, State, advance_one_step};
use crate::lagrangian::LeastSquares;
use crate::linalg::{Jacobian, Structure};
use crate::mass::Mass;
use crate::newton::Work;
use crate::variational::{Variational, least_squares};
use crate::vector_field::VectorField;

/// Method I, p₁ = 0, of M v̇ = f(t, v) in the natural metric M⁻¹: Eq. (22) on v̇ = −v, second order, L-stable on symmetric
/// dissipative systems.
///
/// On a field with a banded or sparse [`structure`](VectorField::structure) a step costs in proportion to the entries, and a
/// field that [is linear](VectorField::is_linear) is factored once per step size; the momentum of the state becomes the
/// zero that the closure makes it. On a dense one it is the [`Variational`] integrator of the closure
/// [`Linear::METHOD_I`]. Nonlinear equations are solved by Newton's method on the branch that is continuous in h.
pub fn method_i<F: VectorField>(field: F) -> MethodI<F> {
    MethodI(match field.structure() {
        Structure::Dense => Kind::Dense(Box::new(least_squares(field, Linear::METHOD_I))),
        _ => Kind::Structured(Box::new(Structured::new(field, Solver::Auto))),
    })
}

/// The integrator of Method I, made by [`method_i`] or with a choice of its machinery.
#[derive(Debug)]
pub struct MethodI<F>(Kind<F>);

#[derive(Debug)]
enum Kind<F> {
    Dense(Box<Variational<Trapezoidal<LeastSquares<F>>, Linear>>),
    Structured(Box<Structured<F>>),
}

/// How a structured step is solved.
#[derive(Debug, Clone, Copy)]
enum Solver {
    /// Linear fields in the formulation that the condition number allows, others by Newton's method.
    Auto,
    /// In this formulation, nonlinear fields by Gauss–Newton iterations.
    GaussNewton(Formulation),
}

impl<F: VectorField> MethodI<F> {
    /// Method I in the given formulation, whatever the structure of the field.
    ///
    /// A nonlinear f is solved by the Gauss–Newton iteration with Levenberg–Marquardt damping, which descends from v₀ to a
    /// minimum of the action. It converges where Newton's method meets the end of its branch; for steps that long it may
    /// find another minimum than the one continuous in h.
    ///
    /// # Errors
    /// [`InputError::Formulation`] if the formulation does not fit the structure or the mass matrix, or if its tolerance is
    /// not in (0, 1); [`InputError::Metric`] if M is not symmetric positive definite.
    pub fn with_formulation(field: F, formulation: Formulation) -> Result<Self, InputError> {
        formulation.check(&field.structure(), &field.mass())?;
        field.mass().check_metric(field.dim())?;
        Ok(Self(Kind::Structured(Box::new(Structured::new(field, Solver::GaussNewton(formulation))))))
    }

    /// The formulation in which the last step was solved; `None` before the first and for dense fields.
    pub fn formulation(&self) -> Option<Formulation> {
        match &self.0 {
            Kind::Dense(_) => None,
            Kind::Structured(method) => method.equations.formulation(),
        }
    }
}

/// M v̇ = f(t, v).
struct System<'a, F> {
    field: &'a F,
    mass: &'a Mass,
}

impl<F: VectorField> System<'_, F> {
    /// Sets `b` to M − h f_v(t, v).
    fn set_b(&self, t: f64, h: f64, v: &[f64], b: &mut Jacobian) {
        b.clear();
        self.mass.add_to(1.0, b);
        self.field.add_jacobian(t, v, -h, b);
    }
}

/// The step equations with their work space.
#[derive(Debug)]
enum Equations {
    Linear(Box<LinearStep>),
    Newton(Box<FullNewton>),
    GaussNewton(Box<GaussNewton>),
}

impl Equations {
    fn formulation(&self) -> Option<Formulation> {
        match self {
            Self::Linear(linear) => linear.formulation(),
            Self::Newton(_) => Some(Formulation::Augmented),
            Self::GaussNewton(method) => Some(method.formulation()),
        }
    }
}

#[derive(Debug)]
struct Structured<F> {
    field: F,
    mass: Mass,
    /// What is wrong with the mass matrix.
    refused: Result<(), InputError>,
    equations: Equations,
    next: Vec<f64>,
    work: Work,
}

impl<F: VectorField> Structured<F> {
    fn new(field: F, solver: Solver) -> Self {
        let (n, structure, mass) = (field.dim(), field.structure(), field.mass());
        let refused = mass.check_metric(n);
        let equations = match solver {
            Solver::GaussNewton(formulation) if !field.is_linear() => {
                Equations::GaussNewton(Box::new(GaussNewton::new(n, &structure, &mass, formulation)))
            }
            Solver::GaussNewton(formulation) => {
                Equations::Linear(Box::new(LinearStep::new(n, &structure, &mass, Some(formulation))))
            }
            Solver::Auto if field.is_linear() => {
                Equations::Linear(Box::new(LinearStep::new(n, &structure, &mass, None)))
            }
            Solver::Auto => Equations::Newton(Box::new(FullNewton::new(n, &structure, &mass))),
        };
        Self { field, mass, refused, equations, next: vec![0.0; n], work: Work::default() }
    }

    fn step(&mut self, t: f64, h: f64, v: &mut [f64], p: &mut [f64]) -> Result<(), StepError> {
        check_step(h)?;
        check_vector("q", v, self.next.len())?;
        check_vector("p", p, self.next.len())?;
        self.refused.clone()?;
        let (system, at) = (System { field: &self.field, mass: &self.mass }, Interval { t, h });
        let solved = match &mut self.equations {
            Equations::Linear(linear) => linear.solve(system, at, v, &mut self.next, &mut self.work),
            Equations::GaussNewton(method) => method.solve(system, at, v, &mut self.next, &mut self.work),
            Equations::Newton(method) => method.solve(system, at, v, &mut self.next, &mut self.work),
        };
        solved.map_err(|source| StepError::Solve { t, h, source })?;
        v.copy_from_slice(&self.next);
        p.fill(0.0);
        self.work.steps += 1;
        Ok(())
    }
}

impl<F: VectorField> Integrator for MethodI<F> {
    fn dim(&self) -> usize {
        match &self.0 {
            Kind::Dense(method) => method.dim(),
            Kind::Structured(method) => method.next.len(),
        }
    }

    fn advance(&mut self, state: &mut State, grid: &Grid) -> Result<(), StepError> {
        advance_one_step(self, state, grid)
    }

    fn work(&self) -> Work {
        match &self.0 {
            Kind::Dense(method) => method.work(),
            Kind::Structured(method) => method.work,
        }
    }
}

impl<F: VectorField> OneStep for MethodI<F> {
    fn step(&mut self, t: f64, h: f64, q: &mut [f64], p: &mut [f64]) -> Result<(), StepError> {
        match &mut self.0 {
            Kind::Dense(method) => method.step(t, h, q, p),
            Kind::Structured(method) => method.step(t, h, q, p),
        }
    }
}
