//! The variational integrator: a discrete Legendre transform stepped by a closure.

use crate::closure::{Closure, Linear, PositionMomentum};
use crate::discrete::{DiscreteLegendre, Interval, MomentumWeights, Trapezoidal};
use crate::error::{StepError, check_step, check_vector};
use crate::integrator::{Grid, Integrator, OneStep, State, advance_one_step};
use crate::lagrangian::LeastSquares;
use crate::linalg::Jacobian;
use crate::newton::{Newton, System, Work};
use crate::vector_field::VectorField;

/// One step solves the stationarity conditions and the closure together for the interior values and q₁, then sets
/// p₁ = D₂L_d, Eqs. (6), (8).
#[derive(Debug)]
pub struct Variational<D, C> {
    discrete: D,
    closure: C,
    newton: Newton,
    unknowns: Vec<f64>,
}

impl<D: DiscreteLegendre, C: Closure> Variational<D, C> {
    /// Closes `discrete` by `closure`.
    pub fn new(discrete: D, closure: C) -> Self {
        let unknowns = discrete.interior() + discrete.dim();
        Self { discrete, closure, newton: Newton::new(unknowns), unknowns: vec![0.0; unknowns] }
    }

    /// The discrete Legendre transform.
    pub fn discrete(&mut self) -> &mut D {
        &mut self.discrete
    }
}

/// Method I, p₁ = 0: Eq. (22) on v̇ = −v, second order, L-stable on symmetric dissipative systems.
pub fn method_i<F: VectorField>(field: F) -> Variational<Trapezoidal<LeastSquares<F>>, Linear> {
    least_squares(field, Linear::METHOD_I)
}

/// Method II, p₁ = p₀: Eq. (25) on v̇ = −v. It has no equation where f_v = 0.
pub fn method_ii<F: VectorField>(field: F) -> Variational<Trapezoidal<LeastSquares<F>>, Linear> {
    least_squares(field, Linear::METHOD_II)
}

/// A linear closure of the trapezoidal least-squares Lagrangian of `field`, Eqs. (26), (27).
pub fn least_squares<F: VectorField>(field: F, closure: Linear) -> Variational<Trapezoidal<LeastSquares<F>>, Linear> {
    Variational::new(Trapezoidal::new(LeastSquares::new(field)), closure)
}

/// The position–momentum form of a discrete Legendre transform, Eq. (8).
pub fn position_momentum<D: DiscreteLegendre>(discrete: D) -> Variational<D, PositionMomentum> {
    Variational::new(discrete, PositionMomentum)
}

/// The equations of one step for a given (t, q₀, p₀).
struct StepEquations<'a, D, C> {
    discrete: &'a mut D,
    closure: &'a C,
    t: f64,
    q0: &'a [f64],
    p0: &'a [f64],
}

impl<D: DiscreteLegendre, C: Closure> System for StepEquations<'_, D, C> {
    fn dim(&self) -> usize {
        self.discrete.interior() + self.discrete.dim()
    }

    fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
        let at = Interval { t: self.t, h };
        let (interior, end) = out.split_at_mut(self.discrete.interior());
        self.discrete.stationarity(at, self.q0, x, interior);
        self.discrete.momentum(at, self.q0, x, self.closure.weights(h), end);
        let carried = self.closure.carried();
        end.iter_mut().zip(self.p0).for_each(|(o, p)| *o -= carried * p);
    }

    fn derivative(&mut self, h: f64, x: &[f64], out: &mut Jacobian) {
        let at = Interval { t: self.t, h };
        self.discrete.add_derivative(at, self.q0, x, self.closure.weights(h), out);
    }
}

impl<D: DiscreteLegendre, C: Closure> Integrator for Variational<D, C> {
    fn dim(&self) -> usize {
        self.discrete.dim()
    }

    fn advance(&mut self, state: &mut State, grid: &Grid) -> Result<(), StepError> {
        advance_one_step(self, state, grid)
    }

    fn work(&self) -> Work {
        self.newton.work
    }
}

impl<D: DiscreteLegendre, C: Closure> OneStep for Variational<D, C> {
    fn step(&mut self, t: f64, h: f64, q: &mut [f64], p: &mut [f64]) -> Result<(), StepError> {
        let n = self.discrete.dim();
        check_step(h)?;
        check_vector("q", q, n)?;
        check_vector("p", p, n)?;
        let at = Interval { t, h };
        self.discrete.predict(at, q, p, &mut self.unknowns);
        let mut equations = StepEquations { discrete: &mut self.discrete, closure: &self.closure, t, q0: q, p0: p };
        self.newton.solve(&mut equations, h, &mut self.unknowns).map_err(|source| StepError::Solve { t, h, source })?;
        self.discrete.momentum(at, q, &self.unknowns, MomentumWeights::END, p);
        q.copy_from_slice(&self.unknowns[self.unknowns.len() - n..]);
        self.newton.work.steps += 1;
        Ok(())
    }
}
