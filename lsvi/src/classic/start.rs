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

#[cfg(test)]
mod tests {
    use super::*;

    /// v₀' = 3 v₁, 0 = 5 v₀ + 7 v₁ + 11 t².
    struct Algebraic;

    impl VectorField for Algebraic {
        fn dim(&self) -> usize {
            2
        }
        fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
            dv.copy_from_slice(&[3.0 * v[1], 5.0 * v[0] + 7.0 * v[1] + 11.0 * t * t]);
        }
        fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
            for (i, j, x) in [(0, 1, 3.0), (1, 0, 5.0), (1, 1, 7.0)] {
                out.add(i, j, scale * x);
            }
        }
    }

    /// What a start is off by, and may be.
    fn refused(start: &mut Start, t: f64, h: f64, v: [f64; 2]) -> Option<[f64; 2]> {
        match start.check(&Algebraic, (t, h), &v) {
            Err(StepError::Input(InputError::System(SystemError::InconsistentStart { row: 1, value, allowed }))) => {
                Some([value, allowed])
            }
            other => other.map(|()| None).expect("no other error"),
        }
    }

    #[test]
    fn a_start_may_be_off_by_what_half_of_the_digits_of_time_and_state_explain() {
        let mut start = Start::new(&Algebraic, vec![1]).expect("an algebraic equation");
        for [t, h, x, y] in [[2.0_f64, 0.5, 1.0, -0.25], [-3.0, 8.0, -1.0, 4.0], [0.5, 20.0, 2.0, 1.0]] {
            let value = 5.0 * x + 7.0 * y + 11.0 * t * t;
            let change = h * value.abs().max((3.0 * y).abs());
            let later = t + ALLOWED * t.abs().max(h);
            let of_time = 11.0 * (later * later - t * t).abs();
            let of_state = ALLOWED * (5.0 * (x.abs() + change) + 7.0 * (y.abs() + change));
            let [found, allowed] = refused(&mut start, t, h, [x, y]).expect("far off");
            assert_eq!(found, value);
            approx::assert_relative_eq!(allowed, of_state + of_time, max_relative = 1e-6);
        }
    }

    #[test]
    fn the_end_of_the_last_step_is_no_start() {
        let mut start = Start::new(&Algebraic, vec![1]).expect("an algebraic equation");
        let (off, end) = ([1.0, 1.0], 3.0);
        start.end(end, &off);
        let roundings = |n: f64| end + n * f64::EPSILON * end;
        assert_eq!(refused(&mut start, roundings(3.0), 0.1, off), None);
        // A check of another start forgets it.
        for (t, v) in [(roundings(6.0), off), (roundings(-6.0), off), (end, [1.0, 1.5])] {
            start.end(end, &off);
            assert!(refused(&mut start, t, 0.1, v).is_some(), "{t} {v:?}");
        }
    }
}
