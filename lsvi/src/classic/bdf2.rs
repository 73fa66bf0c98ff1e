//! The two-step backward differentiation formula.

use crate::error::{InputError, StepError, check_step_from, check_vector};
use crate::integrator::{Grid, GridStep, Integrator, OneStep, State};
use crate::linalg::Jacobian;
use crate::mass::Mass;
use crate::newton::{LimitAtZero, System, Work};
use crate::solver::StepSolver;
use crate::vector_field::VectorField;

use super::stage::{InexactStage, StageSolver, Stages};
use super::{RungeKutta, Tableau};

/// BDF2 with variable steps, order 2, A-stable at constant steps; the first step is taken by SDIRK2.
///
/// With ω = h_n/h_{n−1}: M [v_{n+1} − (1+ω)²/(1+2ω) v_n + ω²/(1+2ω) v_{n−1}] = h (1+ω)/(1+2ω) f(t_{n+1}, v_{n+1}).
/// A state that is not the one it returned last starts it anew.
#[derive(Debug)]
pub struct Bdf2<F> {
    first: RungeKutta<F>,
    stages: Stages,
    mass: Mass,
    /// The end and size of the last step; `None` before the first.
    last: Option<GridStep>,
    before: Vec<f64>,
    now: Vec<f64>,
    next: Vec<f64>,
}

impl<F: VectorField> Bdf2<F> {
    /// The method for `field`, its steps solved with factors.
    ///
    /// # Errors
    /// As for [`RungeKutta::new`].
    pub fn new(field: F) -> Result<Self, InputError> {
        let stages = Stages::factored(&field);
        Ok(Self::with_stages(RungeKutta::new(field, Tableau::sdirk2())?, stages))
    }

    /// The method for `field`, its steps by an inexact Newton method with solvers that `solver` makes: one for the first step,
    /// one for the others.
    ///
    /// # Errors
    /// As for [`RungeKutta::with_solver`].
    pub fn with_solver<S: StepSolver + 'static>(field: F, solver: impl Fn() -> S) -> Result<Self, InputError> {
        let stages = Stages::Solved(Box::new(StageSolver::new(&field, solver())?));
        Ok(Self::with_stages(RungeKutta::with_solver(field, Tableau::sdirk2(), solver())?, stages))
    }

    fn with_stages(first: RungeKutta<F>, stages: Stages) -> Self {
        let zeros = vec![0.0; first.dim()];
        Self {
            stages,
            mass: first.field().mass(),
            first,
            last: None,
            before: zeros.clone(),
            now: zeros.clone(),
            next: zeros,
        }
    }
}

struct BdfEquation<'a> {
    field: &'a dyn VectorField,
    mass: &'a Mass,
    algebraic: &'a [usize],
    t: f64,
    last_h: f64,
    now: &'a [f64],
    before: &'a [f64],
}

impl BdfEquation<'_> {
    /// (ω²/(1+2ω), h (1+ω)/(1+2ω)).
    fn coefficients(&self, h: f64) -> (f64, f64) {
        let omega = h / self.last_h;
        let scale = 1.0 / (1.0 + 2.0 * omega);
        (omega * omega * scale, h * (1.0 + omega) * scale)
    }
}

impl System for BdfEquation<'_> {
    fn dim(&self) -> usize {
        self.now.len()
    }

    fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
        let (past, gamma) = self.coefficients(h);
        self.field.rhs(self.t + h, x, out);
        out.iter_mut().for_each(|o| *o *= -gamma);
        // (1+ω)²/(1+2ω) = 1 + ω²/(1+2ω): differences, so that small steps do not cancel.
        self.mass.add_difference(1.0, x, self.now, out);
        self.mass.add_difference(-past, self.now, self.before, out);
    }

    fn derivative(&mut self, h: f64, x: &[f64], out: &mut Jacobian) {
        let (_, gamma) = self.coefficients(h);
        self.mass.add_to(1.0, out);
        self.field.add_jacobian(self.t + h, x, -gamma, out);
    }

    fn algebraic(&self) -> &[usize] {
        self.algebraic
    }

    fn limit(&self) -> LimitAtZero {
        LimitAtZero::Kept
    }
}

impl InexactStage for BdfEquation<'_> {
    fn at(&self, h: f64) -> (&dyn VectorField, &Mass, f64, f64) {
        (self.field, self.mass, self.t + h, self.coefficients(h).1)
    }
}

impl<F: VectorField> Integrator for Bdf2<F> {
    fn dim(&self) -> usize {
        self.now.len()
    }

    fn advance(&mut self, state: &mut State, grid: &Grid) -> Result<(), StepError> {
        let Some(step) = grid.next(state.t) else { return Ok(()) };
        let (t, h) = (state.t, step.h);
        check_step_from(t, h)?;
        check_vector("v", &state.q, self.now.len())?;
        let last = self.last.take().filter(|last| last.end == t && self.now == state.q);
        self.next.copy_from_slice(&state.q);
        match last {
            Some(last) => {
                let (field, mass, now, before) = (self.first.field(), &self.mass, &self.now, &self.before);
                let mut equation =
                    BdfEquation { field, mass, algebraic: self.first.algebraic(), t, last_h: last.h, now, before };
                self.stages.solve(&mut equation, h, &mut self.next).map_err(|source| StepError::Solve {
                    t,
                    h,
                    source,
                })?;
            }
            None => self.first.step(t, h, &mut self.next, &mut [])?,
        }
        self.before.copy_from_slice(&state.q);
        self.now.copy_from_slice(&self.next);
        state.q.copy_from_slice(&self.next);
        state.t = step.end;
        self.last = Some(step);
        self.stages.work_mut().steps += 1;
        Ok(())
    }

    fn rate(&mut self, state: &State, out: &mut [f64]) -> Result<(), StepError> {
        self.first.rate(state, out)
    }

    fn work(&self) -> Work {
        let (first, rest) = (self.first.work(), self.stages.work());
        Work { steps: rest.steps, ..first + rest }
    }
}
