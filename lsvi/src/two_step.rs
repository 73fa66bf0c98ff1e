//! The two-step form of a variational integrator.

use crate::closure::PositionMomentum;
use crate::discrete::{DiscreteLegendre, Interval, MomentumWeights};
use crate::error::{StepError, check_step_from, check_unknowns, check_vector};
use crate::integrator::OneStep;
use crate::linalg::Jacobian;
use crate::newton::{Newton, System};
use crate::variational::{Variational, position_momentum};

/// The map (q_{k−1}, q_k) → (q_k, q_{k+1}) of the discrete Euler–Lagrange equations
/// D₂L_d(q_{k−1}, q_k) + D₁L_d(q_k, q_{k+1}) = 0, \[KY21\] (3), (11).
///
/// It finds the momentum between two configurations and then takes a step of the position–momentum form: the same
/// trajectories, for where two configurations are what is given.
#[derive(Debug)]
pub struct TwoStep<D> {
    method: Variational<D, PositionMomentum>,
    boundary: Newton,
    interior: Vec<f64>,
    scratch: Scratch,
    p: Vec<f64>,
    next: Vec<f64>,
}

#[derive(Debug)]
struct Scratch {
    /// Interior values and q₁.
    x: Vec<f64>,
    equations: Vec<f64>,
    derivative: Jacobian,
}

impl<D: DiscreteLegendre> TwoStep<D> {
    /// The two-step form of `discrete`.
    pub fn new(discrete: D) -> Self {
        let (interior, n) = (discrete.interior(), discrete.dim());
        let unknowns = interior + n;
        let scratch =
            Scratch { x: vec![0.0; unknowns], equations: vec![0.0; unknowns], derivative: Jacobian::zeros(unknowns) };
        Self {
            method: position_momentum(discrete),
            boundary: Newton::new(interior),
            interior: vec![0.0; interior],
            scratch,
            p: vec![0.0; n],
            next: vec![0.0; n],
        }
    }

    /// Writes the momentum p₁ = D₂L_d(q₀, q₁) at the end of a step from t to t + h.
    ///
    /// # Errors
    /// [`StepError`] if no path of the discretisation is found that joins q₀ and q₁, or the input is unusable.
    pub fn momentum(&mut self, t: f64, h: f64, q0: &[f64], q1: &[f64], p1: &mut [f64]) -> Result<(), StepError> {
        check_vector("p1", p1, self.p.len())?;
        self.join(t, h, q0, q1)?;
        p1.copy_from_slice(&self.p);
        Ok(())
    }

    /// Finds the path from q₀ to q₁ and sets `p` to its momentum at the end.
    fn join(&mut self, t: f64, h: f64, q0: &[f64], q1: &[f64]) -> Result<(), StepError> {
        let n = self.p.len();
        check_unknowns(n)?;
        check_step_from(t, h)?;
        check_vector("q0", q0, n)?;
        check_vector("q1", q1, n)?;
        let discrete = self.method.discrete_mut();
        let inside = self.interior.len();
        let pieces = (inside / n + 1) as f64;
        for (j, values) in self.interior.chunks_exact_mut(n).enumerate() {
            for ((x, a), b) in values.iter_mut().zip(q0).zip(q1) {
                *x = a + (j + 1) as f64 / pieces * (b - a);
            }
        }
        self.scratch.x[inside..].copy_from_slice(q1);
        if inside > 0 {
            let mut path = BoundaryPath { discrete, scratch: &mut self.scratch, t, q0 };
            let solved = self.boundary.solve(&mut path, h, &mut self.interior);
            solved.map_err(|source| StepError::Solve { t, h, source })?;
        }
        self.scratch.x[..inside].copy_from_slice(&self.interior);
        discrete.momentum(Interval { start: t, h }, q0, &self.scratch.x, MomentumWeights::END, &mut self.p);
        Ok(())
    }

    /// Replaces (q_{k−1}, q_k) at times t − h, t by (q_k, q_{k+1}).
    ///
    /// # Errors
    /// [`StepError`] if the input is unusable or either step is not solved; the configurations are then as they were.
    pub fn step(&mut self, t: f64, h: f64, before: &mut [f64], now: &mut [f64]) -> Result<(), StepError> {
        self.join(t - h, h, before, now)?;
        self.next.copy_from_slice(now);
        self.method.step(t, h, &mut self.next, &mut self.p)?;
        before.copy_from_slice(now);
        now.copy_from_slice(&self.next);
        Ok(())
    }
}

/// The conditions on the interior values of a path with given ends.
struct BoundaryPath<'a, D> {
    discrete: &'a mut D,
    scratch: &'a mut Scratch,
    t: f64,
    q0: &'a [f64],
}

impl<D: DiscreteLegendre> System for BoundaryPath<'_, D> {
    fn dim(&self) -> usize {
        self.discrete.interior()
    }

    fn residual(&mut self, h: f64, interior: &[f64], out: &mut [f64]) {
        let Scratch { x, equations, .. } = &mut *self.scratch;
        x[..interior.len()].copy_from_slice(interior);
        self.discrete.equations(Interval { start: self.t, h }, self.q0, x, MomentumWeights::END, equations);
        out.copy_from_slice(&equations[..interior.len()]);
    }

    fn derivative(&mut self, h: f64, interior: &[f64], out: &mut Jacobian) {
        let (n, Scratch { x, derivative, .. }) = (interior.len(), &mut *self.scratch);
        x[..n].copy_from_slice(interior);
        derivative.clear();
        self.discrete.add_derivative(Interval { start: self.t, h }, self.q0, x, MomentumWeights::END, derivative);
        derivative.for_each(|i, j, x| {
            if i < n && j < n {
                out.add(i, j, x);
            }
        });
        out.inherit_outside(derivative);
    }
}
