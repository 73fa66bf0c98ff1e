//! The step of a linear field, factored once for a step size.

use super::System;
use super::step_matrix::{Formulation, StepMatrix};
use crate::discrete::Interval;
use crate::error::SolveError;
use crate::linalg::{Jacobian, Structure, inverse_norm};
use crate::mass::Mass;
use crate::newton::Work;
use crate::vector_field::VectorField;

/// Largest condition number of M + BᵀM⁻¹B, 1/√ε, at which rounding leaves half of the digits at worst.
const TWISTED_CONDITION: f64 = 67_108_864.0;

/// Method I on f = A v + g: with M y = h g₁ − B v₁,
/// M y + B v₁ = h g₁ and Bᵀ y − M v₁ = −[2 M + h (A − Aᵀ)] v₀ − h g₀.
///
/// The right-hand side holds no product A v₀, whose rounding errors the slow modes would keep, and the solution is v₁ itself.
#[derive(Debug)]
pub(super) struct LinearStep {
    matrix: StepMatrix,
    /// To be used in the place of `matrix` where the condition number allows.
    twisted: Option<StepMatrix>,
    uses_twisted: bool,
    /// B = M − h A of the step size `factored`.
    b: Jacobian,
    factored: Option<f64>,
    /// The entries (i, j, a_ij − a_ji) with i < j that are not zero, times −h.
    skew: Vec<(usize, usize, f64)>,
    zero: Vec<f64>,
    upper: Vec<f64>,
    estimate: [Vec<f64>; 2],
}

impl LinearStep {
    /// In the given formulation, or where there is none in the one that structure and condition number ask for.
    pub(super) fn new(dim: usize, structure: &Structure, mass: &Mass, formulation: Option<Formulation>) -> Self {
        let make = |formulation: Formulation| StepMatrix::new(dim, structure, mass, formulation);
        let (matrix, twisted) = match (formulation, structure) {
            (Some(formulation), _) => (make(formulation), None),
            (None, Structure::Sparse(_)) => (make(Formulation::CONJUGATE_GRADIENTS), None),
            (None, _) => {
                let fits = Formulation::Twisted.check(structure, mass).is_ok();
                (make(Formulation::Augmented), fits.then(|| make(Formulation::Twisted)))
            }
        };
        let zeros = vec![0.0; dim];
        Self {
            matrix,
            twisted,
            uses_twisted: false,
            b: Jacobian::with_structure(dim, structure),
            factored: None,
            skew: Vec::new(),
            zero: zeros.clone(),
            upper: zeros.clone(),
            estimate: [zeros.clone(), zeros],
        }
    }

    pub(super) fn formulation(&self) -> Option<Formulation> {
        self.factored?;
        let used = self.twisted.as_ref().filter(|_| self.uses_twisted).unwrap_or(&self.matrix);
        Some(used.formulation())
    }

    fn factor<F: VectorField>(&mut self, system: &System<'_, F>, at: Interval) -> Result<(), SolveError> {
        self.factored = None;
        system.set_b(at.t, at.h, &self.zero, &mut self.b);
        self.b.check_structure()?;
        self.skew.clear();
        self.b.for_each(|i, j, x| {
            let mirrored = self.b.get(j, i);
            // The pair is met at its upper entry, or where that is zero at the lower one.
            if i < j && x != 0.0 && x != mirrored {
                self.skew.push((i, j, x - mirrored));
            } else if i > j && x != 0.0 && mirrored == 0.0 {
                self.skew.push((j, i, -x));
            }
        });
        self.uses_twisted = match &mut self.twisted {
            Some(StepMatrix::Twisted(twisted)) => {
                twisted.factor(system.mass, &self.b, 0.0).is_ok() && {
                    let inverse = inverse_norm(|x| twisted.solve(x), &mut self.estimate);
                    inverse * normal_norm(system.mass, &self.b, &mut self.estimate) <= TWISTED_CONDITION
                }
            }
            _ => false,
        };
        if !self.uses_twisted {
            self.matrix.factor(system.mass, &self.b, 0.0)?;
        }
        self.factored = Some(at.h);
        Ok(())
    }

    pub(super) fn solve<F: VectorField>(
        &mut self,
        system: System<'_, F>,
        at: Interval,
        v0: &[f64],
        v1: &mut [f64],
        work: &mut Work,
    ) -> Result<(), SolveError> {
        if self.factored != Some(at.h) {
            self.factor(&system, at)?;
            work.factorizations += 1;
        }
        system.field.rhs(at.t, &self.zero, v1);
        system.field.rhs(at.t + at.h, &self.zero, &mut self.upper);
        work.residuals += 1;
        v1.iter_mut().for_each(|g| *g *= at.h);
        self.upper.iter_mut().for_each(|g| *g *= at.h);
        system.mass.mul_add(2.0, v0, v1);
        for &(i, j, x) in &self.skew {
            v1[i] -= x * v0[j];
            v1[j] += x * v0[i];
        }
        let matrix = self.twisted.as_mut().filter(|_| self.uses_twisted).unwrap_or(&mut self.matrix);
        matrix.solve(system.mass, &self.b, &mut self.upper, v1)?;
        if v1.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(SolveError::NonFinite) }
    }
}

/// A bound of ‖M + BᵀM⁻¹B‖₁ for a diagonal M: the column sums of M + |B|ᵀM⁻¹|B|.
fn normal_norm(mass: &Mass, b: &Jacobian, work: &mut [Vec<f64>; 2]) -> f64 {
    let [rows, columns] = work;
    rows.fill(0.0);
    columns.fill(0.0);
    b.for_each(|i, _, x| rows[i] += x.abs());
    mass.for_each(b.dim(), |i, _, m| {
        rows[i] /= m;
        columns[i] += m;
    });
    b.for_each(|i, j, x| columns[j] += x.abs() * rows[i]);
    columns.iter().fold(0.0, |largest, x| largest.max(*x))
}
