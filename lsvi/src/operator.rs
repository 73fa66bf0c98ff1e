//! The matrices of a step by what they do to vectors.

use auto_impl::auto_impl;

use crate::error::{InputError, SolveError, SystemError, check_length};
use crate::linalg::{Jacobian, Lu, Structure};
use crate::mass::{Mass, MassInverse};
use crate::solver::check_assembled;
use crate::vector_field::VectorField;

/// A square matrix A, known by its products with vectors that fit.
pub(crate) trait Operator {
    /// Writes A x.
    fn multiply(&self, x: &[f64], out: &mut [f64]);

    /// Writes Aᵀ x.
    fn multiply_transpose(&self, x: &[f64], out: &mut [f64]);
}

impl Operator for Jacobian {
    fn multiply(&self, x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        self.mul_add(1.0, x, out);
    }

    fn multiply_transpose(&self, x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        self.mul_transpose_add(1.0, x, out);
    }
}

impl Jacobian {
    /// Writes A x.
    ///
    /// # Errors
    /// [`SystemError::Dimension`](crate::SystemError::Dimension) unless x and out have the order of the matrix.
    pub fn apply(&self, x: &[f64], out: &mut [f64]) -> Result<(), InputError> {
        check_product(self.dim(), x, out)?;
        self.multiply(x, out);
        Ok(())
    }

    /// Writes Aᵀ x.
    ///
    /// # Errors
    /// As for [`apply`](Self::apply).
    pub fn apply_transpose(&self, x: &[f64], out: &mut [f64]) -> Result<(), InputError> {
        check_product(self.dim(), x, out)?;
        self.multiply_transpose(x, out);
        Ok(())
    }
}

/// Refuses a factor or a product that has not the order of the matrix.
pub(crate) fn check_product(order: usize, x: &[f64], out: &[f64]) -> Result<(), InputError> {
    check_length("x", x.len(), order)?;
    check_length("out", out.len(), order)
}

/// B = M − s f_v(t, v), the matrix of an implicit stage of length s at the point (t, v).
///
/// Implicit stages solve with B, Method I with M + BᵀM⁻¹B.
#[derive(Clone, Copy)]
pub struct StepOperator<'a> {
    field: &'a dyn VectorField,
    mass: &'a Mass,
    t: f64,
    v: &'a [f64],
    s: f64,
    assembled: Option<&'a Jacobian>,
    mass_inverse: Option<&'a MassInverse>,
}

impl<'a> StepOperator<'a> {
    /// B of a field with the given mass matrix, and the same as a matrix if it was assembled.
    pub(crate) fn new(
        field: &'a dyn VectorField,
        mass: &'a Mass,
        (t, v): (f64, &'a [f64]),
        s: f64,
        assembled: Option<&'a Jacobian>,
    ) -> Self {
        Self { field, mass, t, v, s, assembled, mass_inverse: None }
    }

    /// The same with the factors of M, which the normal equations need.
    pub(crate) fn with_mass_inverse(self, mass_inverse: &'a MassInverse) -> Self {
        Self { mass_inverse: Some(mass_inverse), ..self }
    }

    /// The factors of M; none in implicit stages, where M may be singular.
    pub(crate) fn mass_inverse(&self) -> Option<&'a MassInverse> {
        self.mass_inverse
    }

    /// The time t.
    pub fn t(&self) -> f64 {
        self.t
    }

    /// The point v at which f is linearised.
    pub fn v(&self) -> &'a [f64] {
        self.v
    }

    /// The length s.
    pub fn s(&self) -> f64 {
        self.s
    }

    /// The matrix M.
    pub fn mass(&self) -> &'a Mass {
        self.mass
    }

    /// B as a matrix, unless the field is matrix-free.
    pub fn assembled(&self) -> Option<&'a Jacobian> {
        self.assembled
    }

    /// Order n.
    pub fn dim(&self) -> usize {
        self.v.len()
    }

    /// Writes B x.
    ///
    /// # Errors
    /// [`SystemError::Dimension`](crate::SystemError::Dimension) unless x and out have length n.
    pub fn apply(&self, x: &[f64], out: &mut [f64]) -> Result<(), InputError> {
        check_product(self.dim(), x, out)?;
        self.multiply(x, out);
        Ok(())
    }

    /// Writes Bᵀ x.
    ///
    /// # Errors
    /// As for [`apply`](Self::apply).
    pub fn apply_transpose(&self, x: &[f64], out: &mut [f64]) -> Result<(), InputError> {
        check_product(self.dim(), x, out)?;
        self.multiply_transpose(x, out);
        Ok(())
    }

    /// Overwrites J x, or Jᵀ x, by M x − s J x.
    fn finish(&self, x: &[f64], out: &mut [f64]) {
        out.iter_mut().for_each(|o| *o *= -self.s);
        self.mass.mul_add(1.0, x, out);
    }
}

impl Operator for StepOperator<'_> {
    fn multiply(&self, x: &[f64], out: &mut [f64]) {
        match self.assembled {
            Some(b) => b.multiply(x, out),
            None => {
                self.field.apply_jacobian(self.t, self.v, x, out);
                self.finish(x, out);
            }
        }
    }

    fn multiply_transpose(&self, x: &[f64], out: &mut [f64]) {
        match self.assembled {
            Some(b) => b.multiply_transpose(x, out),
            None => {
                self.field.apply_transpose(self.t, self.v, x, out);
                self.finish(x, out);
            }
        }
    }
}

/// An approximation P of B = M − s f_v with which systems are cheap to solve: a factorisation, a multigrid cycle, the
/// constant-coefficient part of f in Fourier space.
///
/// P preconditions the systems of implicit stages, and PᵀM⁻¹P those of Method I. With P = B the spectrum of the latter lies
/// in (1, 2] on dissipative systems, whatever the number of unknowns.
#[auto_impl(Box)]
pub trait Preconditioner {
    /// Refuses a field of a structure, or a mass, of which no P can be made.
    ///
    /// # Errors
    /// [`SystemError::Solver`](crate::SystemError::Solver), which says what is missing.
    fn check(&self, _structure: &Structure, _mass: &Mass) -> Result<(), InputError> {
        Ok(())
    }

    /// Sets P up for B. Called for the first system, when the length s changes, and when iterations have become many; in
    /// between P serves the matrices of later iterations and steps.
    ///
    /// # Errors
    /// [`SolveError::Singular`], [`SolveError::NonFinite`] or [`SolveError::NotAssembled`] if there is no such P.
    fn prepare(&mut self, b: &StepOperator<'_>) -> Result<(), SolveError>;

    /// Overwrites `x` with P⁻¹ x.
    fn solve(&mut self, x: &mut [f64]);

    /// Overwrites `x` with P⁻ᵀ x.
    fn solve_transpose(&mut self, x: &mut [f64]);

    /// Whether P is the B that it was set up for, but for rounding. Products with B can then be spared.
    fn is_exact(&self) -> bool {
        false
    }
}

/// The preconditioner P = B by LU factors, for fields with an assembled Jacobian.
#[derive(Debug, Default)]
pub struct Factored(Option<Lu>);

impl Preconditioner for Factored {
    fn check(&self, structure: &Structure, mass: &Mass) -> Result<(), InputError> {
        check_assembled(structure, mass).map_err(|_| {
            let what = "Factored needs matrices, and the field or its mass has none: give a preconditioner of your own";
            InputError::System(SystemError::Solver(what))
        })
    }

    fn prepare(&mut self, b: &StepOperator<'_>) -> Result<(), SolveError> {
        let b = b.assembled().ok_or(SolveError::NotAssembled)?;
        Ok(self.0.get_or_insert_with(|| Lu::of(b)).factor(b)?)
    }

    fn solve(&mut self, x: &mut [f64]) {
        if let Some(lu) = &mut self.0 {
            lu.solve(x);
        }
    }

    fn solve_transpose(&mut self, x: &mut [f64]) {
        if let Some(lu) = &mut self.0 {
            lu.solve_transpose(x);
        }
    }

    fn is_exact(&self) -> bool {
        true
    }
}
