//! Whether a start satisfies the algebraic equations.

use crate::error::{InputError, StepError, SystemError};
use crate::linalg::{Jacobian, Structure};
use crate::vector_field::VectorField;

/// Part of itself that a value may be off by, √ε: half of the digits.
const ALLOWED: f64 = 1.5e-8;
/// Roundings by which two times that are one may differ.
const ROUNDINGS: f64 = 4.0;

/// The algebraic equations of a method that carries on what a start violates of them, as the trapezoidal rule does with its sign
/// turned in each step.
#[derive(Debug)]
pub(super) struct Start {
    /// The rows of M that are zero.
    rows: Vec<usize>,
    jacobian: Jacobian,
    /// Where the last step ended.
    end: Option<f64>,
    last: Vec<f64>,
    f: Vec<f64>,
    allowed: Vec<f64>,
}

impl Start {
    /// None where there is nothing to violate, or no entries of f_v to tell by how much.
    pub(super) fn new(field: &dyn VectorField, rows: Vec<usize>) -> Option<Self> {
        let (n, structure) = (field.dim(), field.structure());
        let is_needed = !rows.is_empty() && structure != Structure::MatrixFree;
        is_needed.then(|| Self {
            rows,
            jacobian: Jacobian::with_structure(n, &structure),
            end: None,
            last: vec![0.0; n],
            f: vec![0.0; n],
            allowed: vec![0.0; n],
        })
    }

    /// Refuses a step of size `h` from a state that is not the end of the last one and violates an algebraic equation by more than
    /// changes of t and v by √ε, of themselves or of what the step makes of them, explain.
    pub(super) fn check(&mut self, field: &dyn VectorField, (t, h): (f64, f64), v: &[f64]) -> Result<(), StepError> {
        let continues = self.end.is_some_and(|end| (end - t).abs() <= ROUNDINGS * f64::EPSILON * t.abs());
        if continues && self.last == v {
            return Ok(());
        }
        field.rhs(t, v, &mut self.f);
        self.jacobian.clear();
        field.add_jacobian(t, v, 1.0, &mut self.jacobian);
        let change = h * self.f.iter().fold(0.0, |most: f64, f| most.max(f.abs()));
        let allowed = &mut self.allowed;
        allowed.fill(0.0);
        self.jacobian.for_each(|i, j, x| allowed[i] += ALLOWED * x.abs() * (v[j].abs() + change));
        field.rhs(t + ALLOWED * t.abs().max(h), v, &mut self.last);
        for &row in &self.rows {
            let (value, allowed) = (self.f[row], allowed[row] + (self.last[row] - self.f[row]).abs());
            if value.abs() > allowed {
                return Err(InputError::System(SystemError::InconsistentStart { row, value, allowed }).into());
            }
        }
        Ok(())
    }

    /// A step ended at `t` with `v`.
    pub(super) fn end(&mut self, t: f64, v: &[f64]) {
        self.end = Some(t);
        self.last.copy_from_slice(v);
    }
}
