//! The linear systems of a step in their three formulations.

use super::augmented::Augmented;
use super::conjugate_gradients::ConjugateGradients;
use super::twisted::Twisted;
use crate::error::{InputError, SolveError};
use crate::linalg::{Jacobian, Structure};
use crate::mass::Mass;

/// How the linear systems of a step of Method I are solved, with B = M − h f_v.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Formulation {
    /// LU factors of [[M, B], [Bᵀ, −M]], the two unknowns of a component next to each other: as well conditioned as B
    /// itself. For banded, sparse and dense systems.
    Augmented,
    /// LDLᵀ factors of the band matrix M + BᵀM⁻¹B, from both ends at once: cheapest, with the condition number of B squared.
    /// For banded systems with diagonal M.
    Twisted,
    /// Conjugate gradients on M + BᵀM⁻¹B preconditioned by BᵀM⁻¹B, from one LU of B. On dissipative systems the
    /// preconditioned spectrum lies in (1, 2], so that the number of iterations does not depend on that of the unknowns.
    ConjugateGradients {
        /// Error of the solution relative to its size, both in the energy norm (xᵀ(M + BᵀM⁻¹B)x)^½.
        tolerance: f64,
    },
}

impl Formulation {
    /// Conjugate gradients to rounding error.
    pub const CONJUGATE_GRADIENTS: Self = Self::ConjugateGradients { tolerance: 1e-15 };

    /// Refuses what does not fit the system.
    pub(super) fn check(self, structure: &Structure, mass: &Mass) -> Result<(), InputError> {
        match self {
            Self::Twisted if !matches!(structure, Structure::Banded { .. }) => {
                Err(InputError::Formulation("twisted elimination needs a banded structure"))
            }
            Self::Twisted if matches!(mass, Mass::Matrix(_)) => {
                Err(InputError::Formulation("twisted elimination needs a diagonal mass matrix"))
            }
            Self::ConjugateGradients { tolerance } if !(tolerance > 0.0 && tolerance < 1.0) => {
                Err(InputError::Formulation("the tolerance of conjugate gradients must be in (0, 1)"))
            }
            _ => Ok(()),
        }
    }
}

/// The system M y + B x = a, Bᵀ y − (1 + μ) M x = −b of a step: (M + μM + BᵀM⁻¹B) x = b + BᵀM⁻¹a.
#[derive(Debug)]
pub(super) enum StepMatrix {
    Augmented(Box<Augmented>),
    Twisted(Twisted),
    ConjugateGradients(Box<ConjugateGradients>),
}

impl StepMatrix {
    /// Storage for a system of order `dim`; `formulation` has been checked.
    pub(super) fn new(dim: usize, structure: &Structure, mass: &Mass, formulation: Formulation) -> Self {
        match (formulation, structure) {
            (Formulation::Twisted, Structure::Banded { lower, upper }) => {
                Self::Twisted(Twisted::new(dim, lower.saturating_add(*upper)))
            }
            (Formulation::ConjugateGradients { tolerance }, _) => {
                Self::ConjugateGradients(Box::new(ConjugateGradients::new(dim, structure, mass, tolerance)))
            }
            _ => Self::Augmented(Box::new(Augmented::new(dim, structure, mass))),
        }
    }

    pub(super) fn formulation(&self) -> Formulation {
        match self {
            Self::Augmented(_) => Formulation::Augmented,
            Self::Twisted(_) => Formulation::Twisted,
            Self::ConjugateGradients(cg) => Formulation::ConjugateGradients { tolerance: cg.tolerance() },
        }
    }

    /// Factors the matrix for B and μ = `damping`.
    pub(super) fn factor(&mut self, mass: &Mass, b: &Jacobian, damping: f64) -> Result<(), SolveError> {
        match self {
            Self::Augmented(matrix) => matrix.factor(mass, b, damping),
            Self::Twisted(matrix) => matrix.factor(mass, b, damping),
            Self::ConjugateGradients(matrix) => matrix.factor(b, damping),
        }
    }

    /// Overwrites `b`, given as b, with x. `a` is overwritten too. `bm` is the B that was factored.
    pub(super) fn solve(&mut self, mass: &Mass, bm: &Jacobian, a: &mut [f64], b: &mut [f64]) -> Result<(), SolveError> {
        match self {
            Self::Augmented(matrix) => matrix.solve(a, b),
            Self::Twisted(matrix) => {
                mass.for_each(a.len(), |i, _, m| a[i] /= m);
                bm.mul_transpose_add(1.0, a, b);
                matrix.solve(b);
            }
            Self::ConjugateGradients(matrix) => {
                matrix.mass_solve(a)?;
                bm.mul_transpose_add(1.0, a, b);
                matrix.solve(mass, b)?;
            }
        }
        Ok(())
    }
}
