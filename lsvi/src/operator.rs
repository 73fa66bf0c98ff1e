//! The matrices of a step by what they do to vectors.

use crate::error::SolveError;
use crate::linalg::{Jacobian, Lu};
use crate::mass::{Mass, MassInverse};
use crate::vector_field::VectorField;

/// A square matrix A of order n, known by its products.
pub trait Operator {
    /// Order n.
    fn dim(&self) -> usize;

    /// Writes A x.
    fn apply(&self, x: &[f64], out: &mut [f64]);

    /// Writes Aᵀ x.
    fn apply_transpose(&self, x: &[f64], out: &mut [f64]);
}

impl Operator for Jacobian {
    fn dim(&self) -> usize {
        self.dim()
    }

    fn apply(&self, x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        self.mul_add(1.0, x, out);
    }

    fn apply_transpose(&self, x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        self.mul_transpose_add(1.0, x, out);
    }
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

    /// Overwrites J x, or Jᵀ x, by M x − s J x.
    fn finish(&self, x: &[f64], out: &mut [f64]) {
        out.iter_mut().for_each(|o| *o *= -self.s);
        self.mass.mul_add(1.0, x, out);
    }
}

impl Operator for StepOperator<'_> {
    fn dim(&self) -> usize {
        self.v.len()
    }

    fn apply(&self, x: &[f64], out: &mut [f64]) {
        match self.assembled {
            Some(b) => b.apply(x, out),
            None => {
                self.field.apply_jacobian(self.t, self.v, x, out);
                self.finish(x, out);
            }
        }
    }

    fn apply_transpose(&self, x: &[f64], out: &mut [f64]) {
        match self.assembled {
            Some(b) => b.apply_transpose(x, out),
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
pub trait Preconditioner {
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

impl<P: Preconditioner + ?Sized> Preconditioner for Box<P> {
    fn prepare(&mut self, b: &StepOperator<'_>) -> Result<(), SolveError> {
        (**self).prepare(b)
    }
    fn solve(&mut self, x: &mut [f64]) {
        (**self).solve(x);
    }
    fn solve_transpose(&mut self, x: &mut [f64]) {
        (**self).solve_transpose(x);
    }
    fn is_exact(&self) -> bool {
        (**self).is_exact()
    }
}

/// The preconditioner P = B by LU factors, for fields with an assembled Jacobian.
#[derive(Debug, Default)]
pub struct Factored(Option<Lu>);

impl Preconditioner for Factored {
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
