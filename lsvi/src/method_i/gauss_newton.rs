//! Gauss–Newton iterations with Levenberg–Marquardt damping.

use super::System;
use super::step_matrix::{Formulation, StepMatrix};
use crate::discrete::Interval;
use crate::error::SolveError;
use crate::linalg::{Jacobian, Structure, max_norm};
use crate::mass::{Mass, MassInverse};
use crate::newton::Work;
use crate::vector_field::VectorField;

/// The iteration converges linearly, by the ratio of the curvature of f times the residual to B.
const ITERATIONS: u32 = 200;
/// Damping beyond which a step is shorter than rounding.
const STRONGEST: f64 = 1e18;

/// Descent from v₀ to a minimum of φ = ½|h r₀|² + ½|h r₁|² in the norm of M⁻¹, 2h times the action.
///
/// The damped Gauss–Newton step solves ((1 + μ) M + BᵀM⁻¹B) δ = −(h r₀ + BᵀM⁻¹ h r₁).
#[derive(Debug)]
pub(super) struct GaussNewton {
    matrix: StepMatrix,
    /// μ of the next step.
    damping: f64,
    b: Jacobian,
    mass_inverse: MassInverse,
    f0: Vec<f64>,
    /// h r₀ and h r₁ at the present point.
    start: Vec<f64>,
    end: Vec<f64>,
    gradient: Vec<f64>,
    increment: Vec<f64>,
    trial: Vec<f64>,
    work: Vec<f64>,
}

impl GaussNewton {
    pub(super) fn new(dim: usize, structure: &Structure, mass: &Mass, formulation: Formulation) -> Self {
        let zeros = vec![0.0; dim];
        Self {
            matrix: StepMatrix::new(dim, structure, mass, formulation),
            damping: 0.0,
            b: Jacobian::with_structure(dim, structure),
            mass_inverse: MassInverse::new(mass),
            f0: zeros.clone(),
            start: zeros.clone(),
            end: zeros.clone(),
            gradient: zeros.clone(),
            increment: zeros.clone(),
            trial: zeros.clone(),
            work: zeros,
        }
    }

    pub(super) fn formulation(&self) -> Formulation {
        self.matrix.formulation()
    }

    /// Sets h r₀ and h r₁ at `v` and returns φ.
    fn action<F: VectorField>(
        &mut self,
        system: &System<'_, F>,
        at: Interval,
        v0: &[f64],
        v: &[f64],
    ) -> Result<f64, SolveError> {
        system.field.rhs(at.t + at.h, v, &mut self.end);
        self.end.iter_mut().for_each(|f| *f *= -at.h);
        for (r, f) in self.start.iter_mut().zip(&self.f0) {
            *r = -at.h * f;
        }
        let mut sum = 0.0;
        for residual in [&mut self.start, &mut self.end] {
            system.mass.add_difference(1.0, v, v0, residual);
            self.work.copy_from_slice(residual);
            self.mass_inverse.solve(&mut self.work)?;
            sum += 0.5 * dot(residual, &self.work);
        }
        Ok(sum)
    }

    pub(super) fn solve<F: VectorField>(
        &mut self,
        system: System<'_, F>,
        at: Interval,
        v0: &[f64],
        v: &mut [f64],
        work: &mut Work,
    ) -> Result<(), SolveError> {
        system.field.rhs(at.t, v0, &mut self.f0);
        v.copy_from_slice(v0);
        self.damping = 0.0;
        let mut last = f64::INFINITY;
        let mut action = self.action(&system, at, v0, v)?;
        for _ in 0..ITERATIONS {
            work.residuals += 1;
            if !action.is_finite() {
                return Err(SolveError::NonFinite);
            }
            // `work` holds M⁻¹ h r₁ since the action was evaluated.
            system.set_b(at.t + at.h, at.h, v, &mut self.b);
            self.b.check_structure()?;
            self.gradient.copy_from_slice(&self.start);
            self.b.mul_transpose_add(1.0, &self.work, &mut self.gradient);
            let (delta, next) = self.descend(&system, at, v0, v, action, work)?;
            v.copy_from_slice(&self.trial);
            action = next;
            let roundoff = f64::EPSILON * max_norm(v).max(max_norm(v0));
            let theta = if last.is_finite() { delta / last } else { 1.0 };
            // Linear convergence by θ leaves θ/(1 − θ) δ; below √ε φ is flat to rounding and only stagnation is left.
            let converged = delta <= 4.0 * roundoff || (theta < 1.0 && theta * delta <= (1.0 - theta) * roundoff);
            let stagnates = theta >= 1.0 && last <= f64::EPSILON.sqrt() * roundoff / f64::EPSILON;
            if self.damping == 0.0 && (converged || stagnates) {
                return Ok(());
            }
            last = delta;
        }
        Err(SolveError::Diverged { iterations: ITERATIONS, increment: last })
    }

    /// Sets the trial point to one of lower φ, and returns the increment's max norm and the new φ.
    fn descend<F: VectorField>(
        &mut self,
        system: &System<'_, F>,
        at: Interval,
        v0: &[f64],
        v: &[f64],
        action: f64,
        work: &mut Work,
    ) -> Result<(f64, f64), SolveError> {
        while self.damping < STRONGEST {
            self.matrix.factor(system.mass, &self.b, self.damping)?;
            work.factorizations += 1;
            self.work.fill(0.0);
            for (d, g) in self.increment.iter_mut().zip(&self.gradient) {
                *d = -g;
            }
            self.matrix.solve(system.mass, &self.b, &mut self.work, &mut self.increment)?;
            let delta = max_norm(&self.increment);
            for ((trial, v), d) in self.trial.iter_mut().zip(v).zip(&self.increment) {
                *trial = v + d;
            }
            self.work.fill(0.0);
            system.mass.mul_add(1.0, &self.increment, &mut self.work);
            let predicted =
                -0.5 * dot(&self.gradient, &self.increment) + 0.5 * self.damping * dot(&self.increment, &self.work);
            let trial = std::mem::take(&mut self.trial);
            let next = self.action(system, at, v0, &trial);
            self.trial = trial;
            let next = next?;
            // Differences of φ below its own rounding say nothing.
            let flat = predicted <= 64.0 * f64::EPSILON * action;
            let ratio = (action - next) / predicted;
            if flat || ratio > 0.75 {
                self.damping = if self.damping > 1.0 { self.damping / 8.0 } else { 0.0 };
            } else if ratio.is_nan() || ratio <= 0.25 {
                self.damping = (8.0 * self.damping).max(1.0);
            }
            if flat || ratio > 1e-4 {
                return Ok((delta, next));
            }
        }
        Err(SolveError::Diverged { iterations: work.residuals as u32, increment: max_norm(&self.increment) })
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
