//! Solution of the linear systems of a step: with factors, or iteratively.
//!
//! With B = M − s f_v, implicit stages solve with B and Method I with its normal equations M + BᵀM⁻¹B. That matrix is symmetric
//! positive definite for every f, but has the square of the condition number of B. The solvers differ in what they make of
//! that:
//!
//! | solver | for | normal equations by |
//! |---|---|---|
//! | [`Augmented`] | dense, banded, sparse f_v | LU factors of [[M, B], [Bᵀ, −M]], as well conditioned as B |
//! | [`Twisted`] | banded f_v, diagonal M | LDLᵀ from both ends at once: cheapest, condition number squared |
//! | [`Iterative`] | any f_v, matrix-free too | conjugate gradients or LSMR, with a [`Preconditioner`](crate::Preconditioner) |
//!
//! A solver of your own implements [`StepSolver`].

mod augmented;
mod iterative;
mod krylov;
mod twisted;

pub use augmented::Augmented;
pub(crate) use augmented::{first, second, structure_of};
pub use iterative::Iterative;
pub use twisted::Twisted;

use std::fmt;

use auto_impl::auto_impl;

use crate::error::{InputError, SolveError, SystemError};
use crate::linalg::Structure;
use crate::mass::Mass;
use crate::operator::StepOperator;
use crate::vector_field::VectorField;

/// Writes the product of a matrix with its first argument into the second.
pub type Product<'a> = &'a mut dyn FnMut(&[f64], &mut [f64]);

/// Refuses what has no entries to factor.
pub(crate) fn check_assembled(structure: &Structure, mass: &Mass) -> Result<(), InputError> {
    match (structure, mass) {
        (Structure::MatrixFree, _) | (_, Mass::Operator(_)) => Err(InputError::System(SystemError::NotAssembled)),
        _ => Ok(()),
    }
}

/// Where M − s f_v of `field` has entries: with a mass that is an operator it is known by its products only.
pub(crate) fn assembled_structure(field: &dyn VectorField) -> Structure {
    match field.mass() {
        Mass::Operator(_) => Structure::MatrixFree,
        _ => field.structure(),
    }
}

/// Solves the linear systems of a step.
#[auto_impl(Box)]
pub trait StepSolver: fmt::Debug + Send {
    /// Refuses a field of a structure, or a mass, that it cannot serve.
    ///
    /// # Errors
    /// [`SystemError::NotAssembled`] or [`SystemError::Solver`].
    fn check(&self, _structure: &Structure, _mass: &Mass) -> Result<(), InputError> {
        Ok(())
    }

    /// Takes up the B of a new linearisation, that of the systems to follow.
    ///
    /// # Errors
    /// [`SolveError`] if B, or what it is preconditioned by, cannot be factored.
    fn prepare(&mut self, b: &StepOperator<'_>) -> Result<(), SolveError>;

    /// Overwrites `x` with the solution y of B y = x, to a relative error of `tolerance` or the solver's own if that is larger,
    /// and returns the number of iterations.
    ///
    /// # Errors
    /// [`SolveError`] if there is no solution, or the iterations do not reach it.
    fn solve_stage(&mut self, b: &StepOperator<'_>, x: &mut [f64], tolerance: f64) -> Result<u64, SolveError>;

    /// Overwrites `x` with the solution y of ((1 + μ) M + BᵀM⁻¹B) y = x + BᵀM⁻¹a, μ = `damping`; otherwise as
    /// [`solve_stage`](Self::solve_stage).
    ///
    /// # Errors
    /// As for [`solve_stage`](Self::solve_stage).
    fn solve_normal(
        &mut self,
        b: &StepOperator<'_>,
        damping: f64,
        a: Option<&[f64]>,
        x: &mut [f64],
        tolerance: f64,
    ) -> Result<u64, SolveError>;

    /// Whether it has a [`solve_closure`](Self::solve_closure), without which a closure with α ≠ 0 is refused.
    fn takes_products(&self) -> bool {
        false
    }

    /// Overwrites `x` with the solution y of D y = x, where `matrix` writes D y. D is the derivative of a closure
    /// α p₀ + β p₁ = 0 and differs from β BᵀM⁻¹B by terms of lower order in h f_v.
    ///
    /// # Errors
    /// As for [`solve_stage`](Self::solve_stage); [`SolveError::NotAssembled`] from solvers that do not [take products](Self::takes_products).
    fn solve_closure(
        &mut self,
        _b: &StepOperator<'_>,
        _matrix: Product<'_>,
        _x: &mut [f64],
        _tolerance: f64,
    ) -> Result<u64, SolveError> {
        Err(SolveError::NotAssembled)
    }

    /// The relative error that is good enough for the solver's user; 0 if it is rounding error.
    fn tolerance(&self) -> f64 {
        0.0
    }
}
