//! Method I by Gauss–Newton iterations with Levenberg–Marquardt damping.

use super::System;
use crate::discrete::Interval;
use crate::error::SolveError;
use crate::inexact::{check_increment, forcing};
use crate::linalg::{Jacobian, Structure, max_norm};
use crate::mass::Mass;
use crate::newton::{Rounding, SAMPLES, Work};
use crate::operator::Operator;
use crate::solver::StepSolver;

/// The iteration converges linearly, by the ratio of the curvature of f times the residual to B.
const ITERATIONS: u32 = 200;
/// By how much a linear system is solved more accurately where its norm passed over a part of it.
const TIGHTER: f64 = 1e-3;
/// Damping beyond which a step is shorter than rounding.
const STRONGEST: f64 = 1e18;

/// Descent from v₀ to a minimum of φ = ½|h r₀|² + ½|h r₁|² in the norm of M⁻¹, 2h times the action.
///
/// The damped Gauss–Newton step solves ((1 + μ) M + BᵀM⁻¹B) δ = −g, g = h r₀ + BᵀM⁻¹ h r₁, no more accurately than the outer
/// iteration can use.
#[derive(Debug)]
pub(super) struct GaussNewton {
    solver: Box<dyn StepSolver>,
    /// μ of the next step.
    damping: f64,
    /// B, unless the field is matrix-free.
    b: Option<Jacobian>,
    action: Action,
    gradient: Vec<f64>,
    increment: Vec<f64>,
    trial: Vec<f64>,
    work: Vec<f64>,
    rounding: Rounding,
}

/// φ and what it is made of.
#[derive(Debug)]
struct Action {
    f0: Vec<f64>,
    /// h r₀ and h r₁ at the point of the last evaluation.
    start: Vec<f64>,
    end: Vec<f64>,
    /// M⁻¹ h r₁.
    dual: Vec<f64>,
}

impl Action {
    fn at(&mut self, system: &System<'_>, at: Interval, v0: &[f64], v: &[f64]) -> f64 {
        system.field.rhs(at.start + at.h, v, &mut self.end);
        self.end.iter_mut().for_each(|f| *f *= -at.h);
        for (r, f) in self.start.iter_mut().zip(&self.f0) {
            *r = -at.h * f;
        }
        let mut sum = 0.0;
        for residual in [&mut self.start, &mut self.end] {
            system.mass.add_difference(1.0, v, v0, residual);
            self.dual.copy_from_slice(residual);
            system.mass_inverse.solve(&mut self.dual);
            sum += 0.5 * dot(residual, &self.dual);
        }
        sum
    }
}

impl GaussNewton {
    pub(super) fn new(dim: usize, structure: &Structure, solver: Box<dyn StepSolver>) -> Self {
        let zeros = vec![0.0; dim];
        Self {
            solver,
            damping: 0.0,
            b: (*structure != Structure::MatrixFree).then(|| Jacobian::with_structure(dim, structure)),
            action: Action { f0: zeros.clone(), start: zeros.clone(), end: zeros.clone(), dual: zeros.clone() },
            gradient: zeros.clone(),
            increment: zeros.clone(),
            trial: zeros.clone(),
            work: zeros,
            rounding: Rounding::default(),
        }
    }

    pub(super) fn solve(
        &mut self,
        system: System<'_>,
        at: Interval,
        v0: &[f64],
        v: &mut [f64],
        work: &mut Work,
    ) -> Result<(), SolveError> {
        system.field.rhs(at.start, v0, &mut self.action.f0);
        v.copy_from_slice(v0);
        self.damping = 0.0;
        let (mut last, mut iterations) = (f64::INFINITY, 0);
        // Norms of the gradient.
        let (mut first, mut size) = (f64::NAN, f64::NAN);
        let mut action = self.action.at(&system, at, v0, v);
        let mut most = 1.0_f64;
        while iterations < ITERATIONS {
            iterations += 1;
            work.residuals += 1;
            if !action.is_finite() {
                return Err(SolveError::NonFinite);
            }
            if let Some(b) = &mut self.b {
                system.set_b(at.start + at.h, at.h, v, b);
                b.check_structure()?;
            }
            let b = system.operator((at.start + at.h, v), at.h, self.b.as_ref());
            b.multiply_transpose(&self.action.dual, &mut self.gradient);
            self.gradient.iter_mut().zip(&self.action.start).for_each(|(g, r)| *g += r);
            let before = std::mem::replace(&mut size, dot(&self.gradient, &self.gradient).sqrt());
            first = if iterations == 1 { size } else { first };
            if size == 0.0 {
                return Ok(());
            }
            self.solver.prepare(&b)?;
            work.factorizations += 1;
            let tolerance = forcing(size / before).min(most);
            let largest = max_norm(v).max(max_norm(v0));
            let (roundoff, enough) = (f64::EPSILON * largest, f64::EPSILON.max(self.solver.tolerance()) * largest);
            let Some((delta, next)) = self.descend(&system, (at, v0), v, action, (tolerance, enough), work)? else {
                break;
            };
            v.copy_from_slice(&self.trial);
            action = next;
            let theta = if last.is_finite() { delta / last } else { 1.0 };
            // Linear convergence by θ leaves θ/(1 − θ) δ; below √ε φ is flat to rounding and only stagnation is left.
            let converged = delta <= 4.0 * roundoff || (theta < 1.0 && theta * delta <= (1.0 - theta) * enough);
            let stagnates = theta >= 1.0
                && last <= f64::EPSILON.sqrt() * largest
                && self.is_at_rounding(&system, at, (v0, v), last, work);
            if self.damping == 0.0 && (converged || stagnates) {
                let allowed = if converged { enough } else { f64::EPSILON.sqrt() * largest };
                if self.is_solved_to(allowed.max(4.0 * roundoff), &system) {
                    return Ok(());
                }
                // The norm of the preconditioner passed over what is left, of which increments so far say nothing.
                (most, last) = ((TIGHTER * tolerance).max(f64::EPSILON), f64::INFINITY);
            } else {
                last = delta;
            }
        }
        system.field.rhs(at.start + at.h, v, &mut self.work);
        Err(SolveError::Stalled { iterations, gradient: size / first, rate: max_norm(&self.work), v: (&*v).into() })
    }

    /// Whether what the increment leaves of its linear system, ρ = H δ + g with H = M + BᵀM⁻¹B, is that of errors of up to `error`, each told by its
    /// own equation: |ρ_j| ≤ H_jj `error`. It costs about an inner iteration. Of a matrix-free field the diagonal is not known.
    fn is_solved_to(&mut self, error: f64, system: &System<'_>) -> bool {
        let Some(b) = &self.b else { return true };
        let Self { increment, gradient, work, trial, .. } = self;
        // ρ in `trial`.
        b.multiply(increment, work);
        system.mass_inverse.solve(work);
        b.multiply_transpose(work, trial);
        system.mass.multiply(increment, work);
        trial.iter_mut().zip(work.iter().zip(gradient.iter())).for_each(|(r, (m, g))| *r += m + g);
        system.diagonals(b, work, increment);
        trial.iter().zip(increment.iter()).all(|(r, diagonal)| r.abs() <= diagonal * error)
    }

    /// Whether the gradient at `v`, by the last B, is one of roundings.
    fn is_at_rounding(
        &mut self,
        system: &System<'_>,
        at: Interval,
        (v0, v): (&[f64], &[f64]),
        last: f64,
        work: &mut Work,
    ) -> bool {
        let Self { action, b, increment, rounding, .. } = self;
        let b = system.operator((at.start + at.h, v), at.h, b.as_ref());
        let mut gradient = |v: &[f64], out: &mut [f64]| {
            action.at(system, at, v0, v);
            b.multiply_transpose(&action.dual, out);
            out.iter_mut().zip(&action.start).for_each(|(g, r)| *g += r);
        };
        work.residuals += SAMPLES + 1;
        let is_rounding = rounding.explains(&mut gradient, v, increment, last);
        action.at(system, at, v0, v);
        is_rounding
    }

    /// Sets the trial point to one of lower φ, and returns the increment's max norm and the new φ; `None` if no step is short
    /// enough. `tolerance` is that of the linear system, and increments up to `enough` need not lower φ: at a steady state it is
    /// nothing but rounding.
    fn descend(
        &mut self,
        system: &System<'_>,
        (at, v0): (Interval, &[f64]),
        v: &[f64],
        action: f64,
        (tolerance, enough): (f64, f64),
        work: &mut Work,
    ) -> Result<Option<(f64, f64)>, SolveError> {
        let b = system.operator((at.start + at.h, v), at.h, self.b.as_ref());
        while self.damping < STRONGEST {
            for (d, g) in self.increment.iter_mut().zip(&self.gradient) {
                *d = -g;
            }
            let inner = self.solver.solve_normal(&b, self.damping, None, &mut self.increment, tolerance)?;
            work.inner += inner;
            let delta = max_norm(&self.increment);
            check_increment(delta, max_norm(&self.gradient), inner)?;
            for ((trial, v), d) in self.trial.iter_mut().zip(v).zip(&self.increment) {
                *trial = v + d;
            }
            let predicted = predicted(&self.gradient, &self.increment, self.damping, system.mass, &mut self.work);
            let next = self.action.at(system, at, v0, &self.trial);
            // Differences of φ below its own rounding say nothing.
            let flat = (1.0 + self.damping) * delta <= enough || predicted <= 64.0 * f64::EPSILON * action;
            let ratio = (action - next) / predicted;
            if flat || ratio > 0.75 {
                self.damping = if self.damping > 1.0 { self.damping / 8.0 } else { 0.0 };
            } else if ratio.is_nan() || ratio <= 0.25 {
                self.damping = (8.0 * self.damping).max(1.0);
            }
            if flat || ratio > 1e-4 {
                return Ok(Some((delta, next)));
            }
            work.factorizations += 1;
        }
        Ok(None)
    }
}

/// What the model of φ that the increment δ comes from, quadratic and without the damping, says that it takes from φ:
/// −½ gᵀδ + ½ μ δᵀMδ.
fn predicted(gradient: &[f64], increment: &[f64], damping: f64, mass: &Mass, work: &mut [f64]) -> f64 {
    mass.multiply(increment, work);
    -0.5 * dot(gradient, increment) + 0.5 * damping * dot(increment, work)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::VectorField;
    use crate::operator::Factored;
    use crate::solver::Iterative;

    /// Of a linear field two increments do, the second of roundings: the damping of a step that failed would make them many.
    #[test]
    fn damping_ends_with_its_step() {
        let field = crate::field!(1, |_t, v, dv| dv[0] = v[0] * -3.0);
        let mass_inverse = Mass::Identity.metric(1).expect("positive");
        let system =
            || System { field: &field as &dyn VectorField, mass: &Mass::Identity, mass_inverse: &mass_inverse };
        let [of_new, of_damped] = [0.0, 100.0].map(|damping| {
            let solver = Iterative::to_rounding(Factored::default());
            let mut step = GaussNewton::new(1, &Structure::Dense, Box::new(solver));
            let (mut v, mut work) = ([0.0], Work::default());
            step.damping = damping;
            step.solve(system(), Interval { start: 0.0, h: 0.5 }, &[1.0], &mut v, &mut work).expect("linear");
            (v, work)
        });
        assert_eq!(of_damped, of_new);
    }

    /// v̇ = −t v by its products.
    struct Fading;

    impl VectorField for Fading {
        fn dim(&self) -> usize {
            1
        }
        fn structure(&self) -> Structure {
            Structure::MatrixFree
        }
        fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
            dv[0] = -t * v[0];
        }
        fn add_jacobian(&self, _t: f64, _v: &[f64], _scale: f64, _out: &mut Jacobian) {}
        fn apply_jacobian(&self, t: f64, _v: &[f64], x: &[f64], out: &mut [f64]) {
            out[0] = -t * x[0];
        }
        fn apply_transpose(&self, t: f64, v: &[f64], w: &[f64], out: &mut [f64]) {
            self.apply_jacobian(t, v, w, out);
        }
    }

    /// From 1 at t = 1 with h = ½, h r₀ = v − ½, h r₁ = B v − 1 and B = 1.75: g = 4.0625 v − 2.25.
    #[test]
    fn the_gradient_is_one_of_roundings_at_the_minimum_alone() {
        let mass_inverse = Mass::Identity.metric(1).expect("positive");
        let system = System { field: &Fading as &dyn VectorField, mass: &Mass::Identity, mass_inverse: &mass_inverse };
        let (at, v0) = (Interval { start: 1.0, h: 0.5 }, [1.0]);
        let is_at_rounding = |v: f64| {
            let solver = Iterative::to_rounding(Factored::default());
            let mut step = GaussNewton::new(1, &Structure::MatrixFree, Box::new(solver));
            system.field.rhs(at.start, &v0, &mut step.action.f0);
            step.increment[0] = f64::EPSILON;
            let mut work = Work { residuals: 5, ..Work::default() };
            let is_rounding = step.is_at_rounding(&system, at, (&v0, &[v]), f64::EPSILON, &mut work);
            assert_eq!(work, Work { residuals: 5 + SAMPLES + 1, ..Work::default() });
            is_rounding
        };
        let minimum = 36.0 / 65.0;
        assert_eq!([-1e-9, 0.0, 1e-9].map(|off| is_at_rounding(minimum + off)), [false, true, false]);
    }

    /// An increment that damping shortens tells nothing of what is left, however loose the tolerance is.
    #[test]
    fn no_increment_that_is_damped_is_the_last() {
        let field = crate::field!(1, |_t, v, dv| dv[0] = -v[0] * v[0] * v[0]);
        let mass_inverse = Mass::Identity.metric(1).expect("positive");
        for (start, h) in [(10.0, 2.0), (100.0, 5.0)] {
            let solve = |tolerance: f64| {
                let solver = Iterative::new(Factored::default()).with_tolerance(tolerance).expect("in (0, 1)");
                let mut step = GaussNewton::new(1, &Structure::Dense, Box::new(solver));
                let system =
                    System { field: &field as &dyn VectorField, mass: &Mass::Identity, mass_inverse: &mass_inverse };
                let (mut v, mut work) = ([0.0], Work::default());
                step.solve(system, Interval { start: 0.0, h }, &[start], &mut v, &mut work).expect("a minimum");
                v[0]
            };
            let (loose, tight) = (solve(1e-2), solve(1e-15));
            assert!((loose - tight).abs() < 1e-2 * start, "{loose} for {tight}");
        }
    }

    /// φ of a linear field is its model.
    #[test]
    fn the_predicted_decrease_is_that_of_a_linear_field_at_every_damping() {
        let field = crate::field!(2, |t, v, dv| {
            dv[0] = v[0] * -3.0 + v[1] + t;
            dv[1] = v[0] * 2.0 - v[1] * 5.0;
        });
        for mass in [Mass::Identity, Mass::Diagonal(vec![2.0, 0.5])] {
            let mass_inverse = mass.metric(2).expect("positive");
            let system = System { field: &field as &dyn VectorField, mass: &mass, mass_inverse: &mass_inverse };
            for damping in [0.0, 1.0, 100.0] {
                let solver = Iterative::to_rounding(Factored::default());
                let mut step = GaussNewton::new(2, &Structure::Dense, Box::new(solver));
                let (at, v0, v) = (Interval { start: 0.0, h: 0.5 }, [1.0, -0.5], [0.3, 0.7]);
                field.rhs(at.start, &v0, &mut step.action.f0);
                let before = step.action.at(&system, at, &v0, &v);
                let mut b = Jacobian::with_structure(2, &Structure::Dense);
                system.set_b(at.h, at.h, &v, &mut b);
                let b = system.operator((at.h, &v), at.h, Some(&b));
                b.multiply_transpose(&step.action.dual, &mut step.gradient);
                step.gradient.iter_mut().zip(&step.action.start).for_each(|(g, r)| *g += r);
                step.increment.iter_mut().zip(&step.gradient).for_each(|(d, g)| *d = -g);
                step.solver.prepare(&b).expect("regular");
                step.solver.solve_normal(&b, damping, None, &mut step.increment, 0.0).expect("definite");
                let predicted = predicted(&step.gradient, &step.increment, damping, &mass, &mut step.work);
                let end: Vec<f64> = v.iter().zip(&step.increment).map(|(v, d)| v + d).collect();
                let after = step.action.at(&system, at, &v0, &end);
                // Roundings of φ, and of B in solutions that are good to 1e-15.
                approx::assert_abs_diff_eq!(predicted, before - after, epsilon = 1e-13 * before);
                assert!(predicted > 0.0);
            }
        }
    }
}
