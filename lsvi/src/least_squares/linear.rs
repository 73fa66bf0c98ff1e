//! The step of Method I on a linear field, factored once for a step size.

use super::System;
use crate::discrete::Interval;
use crate::error::SolveError;
use crate::linalg::{Jacobian, Structure, max_norm};
use crate::mass::Mass;
use crate::newton::Work;
use crate::operator::{Factored, Operator, StepOperator};
use crate::solver::{Augmented, Iterative, StepSolver, Twisted};

/// Largest condition number of M + BᵀM⁻¹B, 1/√ε, at which rounding leaves half of the digits at worst.
const TWISTED_CONDITION: f64 = 67_108_864.0;

/// Solutions for what the ones before have left.
const REFINEMENTS: u32 = 40;

/// Method I on f = A v + g: with M y = h g₁ − B v₁,
/// M y + B v₁ = h g₁ and Bᵀ y − M v₁ = −[2 M + h (A − Aᵀ)] v₀ − h g₀.
///
/// The right-hand side holds no product A v₀, whose rounding errors the slow modes would keep, and the solution is v₁ itself.
#[derive(Debug)]
pub(super) struct LinearStep {
    solver: Box<dyn StepSolver>,
    /// The right-hand side of a step, while `solver` iterates and is not the user's: where its iterations end early, as on waves, factors
    /// of twice the order take its place.
    kept: Option<Vec<f64>>,
    /// For a solver of the user's that iterates, where there is a B to hold its solutions to.
    held: Option<Box<Held>>,
    /// To be used in the place of `solver` where the condition number allows.
    twisted: Option<Twisted>,
    uses_twisted: bool,
    /// B = M − h A of the step size `factored`, unless the field is matrix-free.
    b: Option<Jacobian>,
    factored: Option<f64>,
    /// The entries (i, j, a_ij − a_ji) with i < j that are not zero, times −h.
    skew: Vec<(usize, usize, f64)>,
    zero: Vec<f64>,
    /// h g₀ + BᵀM⁻¹ h g₁ of a field that does not depend on t, of the step size `factored`.
    forcing: Option<Vec<f64>>,
    upper: Vec<f64>,
    estimate: [Vec<f64>; 2],
}

/// Work space in which solutions are held to their equations.
#[derive(Debug)]
struct Held {
    /// The whole right-hand side.
    sum: Vec<f64>,
    /// What is left of it.
    left: Vec<f64>,
    diagonal: Vec<f64>,
    work: Vec<f64>,
}

impl LinearStep {
    /// With the given solver, or where there is none with the one that structure and condition number ask for.
    pub(super) fn new(dim: usize, structure: &Structure, mass: &Mass, solver: Option<Box<dyn StepSolver>>) -> Self {
        let chooses = solver.is_none() && matches!(structure, Structure::Banded { .. });
        let fits = chooses && matches!(mass, Mass::Identity | Mass::Diagonal(_));
        let zeros = vec![0.0; dim];
        let iterates = solver.is_none() && matches!(structure, Structure::Sparse(_));
        let is_held =
            *structure != Structure::MatrixFree && solver.as_ref().is_some_and(|solver| solver.tolerance() > 0.0);
        let held = || Held { sum: zeros.clone(), left: zeros.clone(), diagonal: zeros.clone(), work: zeros.clone() };
        let held = is_held.then(|| Box::new(held()));
        let solver = solver.unwrap_or_else(|| match iterates {
            true => Box::new(Iterative::to_rounding(Factored::default())),
            false => Box::new(Augmented::new()),
        });
        Self {
            solver,
            kept: iterates.then(|| zeros.clone()),
            held,
            twisted: fits.then(Twisted::new),
            uses_twisted: false,
            b: (*structure != Structure::MatrixFree).then(|| Jacobian::with_structure(dim, structure)),
            factored: None,
            skew: Vec::new(),
            zero: zeros.clone(),
            forcing: None,
            upper: zeros.clone(),
            estimate: [zeros.clone(), zeros],
        }
    }

    fn factor(&mut self, system: &System<'_>, at: Interval) -> Result<(), SolveError> {
        self.factored = None;
        self.skew.clear();
        if let Some(b) = &mut self.b {
            system.set_b(at.start, at.h, &self.zero, b);
            b.check_structure()?;
            let b = &*b;
            b.for_each(|i, j, x| {
                let mirrored = b.get(j, i);
                // The pair is met at its upper entry, or where that is zero at the lower one.
                if i < j && x != 0.0 && x != mirrored {
                    self.skew.push((i, j, x - mirrored));
                } else if i > j && x != 0.0 && mirrored == 0.0 {
                    self.skew.push((j, i, -x));
                }
            });
        }
        let b = system.operator((at.start, &self.zero), at.h, self.b.as_ref());
        self.uses_twisted = match &mut self.twisted {
            Some(twisted) => {
                twisted.prepare(&b)?;
                twisted.condition(&b, &mut self.estimate) <= TWISTED_CONDITION
            }
            None => false,
        };
        if !self.uses_twisted {
            self.solver.prepare(&b)?;
        }
        self.forcing = None;
        if self.uses_twisted && self.skew.is_empty() && system.field.is_autonomous() {
            self.forcing = Some(self.constant_forcing(system, at));
        }
        self.factored = Some(at.h);
        Ok(())
    }

    /// h g + BᵀM⁻¹ h g.
    fn constant_forcing(&mut self, system: &System<'_>, at: Interval) -> Vec<f64> {
        let mut forcing = vec![0.0; self.zero.len()];
        system.field.rhs(at.start, &self.zero, &mut forcing);
        forcing.iter_mut().for_each(|g| *g *= at.h);
        self.upper.copy_from_slice(&forcing);
        system.mass.for_each(self.upper.len(), |i, _, m| self.upper[i] /= m);
        if let Some(b) = &self.b {
            b.mul_transpose_add(1.0, &self.upper, &mut forcing);
        }
        forcing
    }

    /// Replaces `v` by the value at the end of a step in one pass over what is known of steps of this size; false, and `v` as it
    /// is, where that is not enough or `v` not finite.
    pub(super) fn march(&mut self, mass: &Mass, h: f64, v: &mut [f64]) -> bool {
        match (&mut self.twisted, &self.forcing) {
            (Some(twisted), Some(forcing)) if self.factored == Some(h) => twisted.march(mass, forcing, v),
            _ => false,
        }
    }

    /// h g at the end of the last step that was solved.
    pub(super) fn end_forcing(&self) -> &[f64] {
        &self.upper
    }

    pub(super) fn solve(
        &mut self,
        system: System<'_>,
        at: Interval,
        v0: &[f64],
        v1: &mut [f64],
        work: &mut Work,
    ) -> Result<(), SolveError> {
        if self.factored != Some(at.h) {
            self.factor(&system, at)?;
            work.factorizations += 1;
        }
        system.field.rhs(at.start, &self.zero, v1);
        let b = system.operator((at.start, &self.zero), at.h, self.b.as_ref());
        v1.iter_mut().for_each(|g| *g *= at.h);
        system.mass.mul_add(2.0, v0, v1);
        if self.b.is_some() {
            for &(i, j, x) in &self.skew {
                v1[i] -= x * v0[j];
                v1[j] += x * v0[i];
            }
        } else {
            for (sign, transposed) in [(-1.0, false), (1.0, true)] {
                if transposed {
                    b.multiply_transpose(v0, &mut self.upper)
                } else {
                    b.multiply(v0, &mut self.upper)
                }
                v1.iter_mut().zip(&self.upper).for_each(|(v, x)| *v += sign * x);
            }
        }
        system.field.rhs(at.start + at.h, &self.zero, &mut self.upper);
        work.residuals += 1;
        self.upper.iter_mut().for_each(|g| *g *= at.h);
        let solver: &mut dyn StepSolver = match &mut self.twisted {
            Some(twisted) if self.uses_twisted => twisted,
            _ => &mut *self.solver,
        };
        if let Some(kept) = &mut self.kept {
            kept.copy_from_slice(v1);
        }
        if let Some(held) = &mut self.held {
            held.set_sum(&system, &b, v1, &self.upper);
        }
        work.inner += match (solver.solve_normal(&b, 0.0, Some(&self.upper), v1, 0.0), &self.kept) {
            (Err(SolveError::Linear { iterations, .. }), Some(kept)) => {
                v1.copy_from_slice(kept);
                self.kept = None;
                self.solver = Box::new(Augmented::new());
                self.solver.prepare(&b)?;
                work.factorizations += 1;
                u64::from(iterations) + self.solver.solve_normal(&b, 0.0, Some(&self.upper), v1, 0.0)?
            }
            (solved, _) => solved?,
        };
        if !v1.iter().all(|x| x.is_finite()) {
            return Err(SolveError::NonFinite);
        }
        match (&mut self.held, &self.b) {
            (Some(held), Some(matrix)) => held.refine(&system, (&b, matrix), &mut *self.solver, v1, work),
            _ => Ok(()),
        }
    }
}

impl Held {
    /// Takes up the right-hand side x + BᵀM⁻¹a.
    fn set_sum(&mut self, system: &System<'_>, b: &StepOperator<'_>, x: &[f64], a: &[f64]) {
        self.work.copy_from_slice(a);
        system.mass_inverse.solve(&mut self.work);
        b.multiply_transpose(&self.work, &mut self.sum);
        self.sum.iter_mut().zip(x).for_each(|(sum, x)| *sum += x);
    }

    /// Solves again for what is left, ρ, until each equation leaves its unknown no error above the tolerance, |ρ_j| ≤ H_jj times that with
    /// H = M + BᵀM⁻¹B: in the norm of a preconditioner some of them count for nothing.
    fn refine(
        &mut self,
        system: &System<'_>,
        (b, matrix): (&StepOperator<'_>, &Jacobian),
        solver: &mut dyn StepSolver,
        v: &mut [f64],
        work: &mut Work,
    ) -> Result<(), SolveError> {
        system.diagonals(matrix, &mut self.work, &mut self.diagonal);
        let (mut spent, mut residual) = (0, f64::NAN);
        for _ in 0..REFINEMENTS {
            b.multiply(v, &mut self.work);
            system.mass_inverse.solve(&mut self.work);
            b.multiply_transpose(&self.work, &mut self.left);
            system.mass.multiply(v, &mut self.work);
            let products = self.left.iter_mut().zip(&self.work);
            products.zip(&self.sum).for_each(|((left, mv), sum)| *left = sum - *left - mv);
            let error = solver.tolerance().max(4.0 * f64::EPSILON) * max_norm(v);
            if self.left.iter().zip(&self.diagonal).all(|(left, diagonal)| left.abs() <= diagonal * error) {
                return Ok(());
            }
            residual = max_norm(&self.left) / max_norm(&self.sum);
            let inner = solver.solve_normal(b, 0.0, None, &mut self.left, 0.0)?;
            work.inner += inner;
            spent += inner;
            v.iter_mut().zip(&self.left).for_each(|(v, d)| *v += d);
        }
        Err(SolveError::Linear { iterations: u32::try_from(spent).unwrap_or(u32::MAX), residual })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector_field::VectorField;

    /// It has found nothing after three iterations, and is content.
    #[derive(Debug)]
    struct Idle;

    impl StepSolver for Idle {
        fn prepare(&mut self, _b: &StepOperator<'_>) -> Result<(), SolveError> {
            Ok(())
        }
        fn solve_stage(&mut self, _b: &StepOperator<'_>, _x: &mut [f64], _tolerance: f64) -> Result<u64, SolveError> {
            unreachable!()
        }
        fn solve_normal(
            &mut self,
            _b: &StepOperator<'_>,
            _damping: f64,
            _a: Option<&[f64]>,
            x: &mut [f64],
            _tolerance: f64,
        ) -> Result<u64, SolveError> {
            x.fill(0.0);
            Ok(3)
        }
        fn tolerance(&self) -> f64 {
            1e-10
        }
    }

    #[test]
    fn a_solver_that_leaves_the_equations_as_they_are_is_named_with_all_of_its_iterations() {
        let field = crate::field!(1, |_t, v, dv| dv[0] = v[0] * -3.0);
        let (mass, mut v, mut work) = (Mass::Identity, [0.0], Work::default());
        let mass_inverse = mass.metric(1).expect("positive");
        let system = System { field: &field as &dyn VectorField, mass: &mass, mass_inverse: &mass_inverse };
        let mut step = LinearStep::new(1, &Structure::Dense, &mass, Some(Box::new(Idle)));
        let found = step.solve(system, Interval { start: 0.0, h: 0.5 }, &[1.0], &mut v, &mut work);
        assert_eq!(found, Err(SolveError::Linear { iterations: 3 * REFINEMENTS, residual: 1.0 }));
        assert_eq!(work.inner, u64::from(3 + 3 * REFINEMENTS));
    }
}
