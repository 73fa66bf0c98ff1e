//! Steps in units of the equation's own.
//!
//! Increments of Newton's iteration do not depend on the units of the unknowns, but the norms do by which they are compared: in metres and
//! metres per second, of an oscillator that turns a thousand times a second, all is what the velocity does. With A(s) = ∂F/∂x(s, x₀), a step
//! that is refused is tried again in units in which the rows and columns of A(0)⁻¹A(h) are balanced ([PR69]); powers of two, so that
//! nothing is rounded.
//!
//! [PR69] B. N. Parlett and C. Reinsch, Numer. Math. 13 (1969) 293.

use nalgebra::linalg::balancing::balance_parlett_reinsch;

use super::{LimitAtZero, Newton, System};
use crate::error::SolveError;
use crate::linalg::Jacobian;

/// Unknowns up to which a matrix is balanced: it takes as many divisions as their cube.
const MOST: usize = 64;
/// Entries beyond are not balanced: their squares overflow.
const LARGEST: f64 = 1e100;

/// Units of unknowns that differ by this factor are unlike.
const UNLIKE: f64 = 4.0;

/// Whether the rows and columns of a matrix J of order n ≤ [`MOST`], as of v̇ = J v, are balanced by units that are unlike.
pub(crate) fn are_unlike(j: &Jacobian) -> bool {
    let Some(mut j) = j.dense().filter(|j| j.nrows() <= MOST).cloned() else { return false };
    if !j.iter().all(|x| x.abs() <= LARGEST) {
        return false;
    }
    let units = balance_parlett_reinsch(&mut j);
    units.max() >= UNLIKE * units.min()
}

/// The iteration in its own units: x_i = `units`_i y_i.
#[derive(Debug)]
pub(super) struct Balanced {
    newton: Newton,
    units: Vec<f64>,
    /// x, and y.
    x: Vec<f64>,
    y: Vec<f64>,
    /// Whether the last step was found so.
    is_in_use: bool,
}

/// F(h, D y).
struct InUnits<'a> {
    system: &'a mut dyn System,
    units: &'a [f64],
    x: &'a mut [f64],
}

fn scale(y: &[f64], units: &[f64], x: &mut [f64]) {
    x.iter_mut().zip(y.iter().zip(units)).for_each(|(x, (y, unit))| *x = unit * y);
}

impl System for InUnits<'_> {
    fn dim(&self) -> usize {
        self.units.len()
    }

    fn residual(&mut self, h: f64, y: &[f64], out: &mut [f64]) {
        scale(y, self.units, self.x);
        self.system.residual(h, self.x, out);
    }

    fn derivative(&mut self, h: f64, y: &[f64], out: &mut Jacobian) {
        scale(y, self.units, self.x);
        self.system.derivative(h, self.x, out);
        if let Some(entries) = out.dense_mut() {
            let columns = entries.chunks_exact_mut(self.units.len()).zip(self.units);
            columns.for_each(|(column, unit)| column.iter_mut().for_each(|x| *x *= unit));
        }
    }

    fn origin(&self, y: &mut [f64]) {
        y.iter_mut().zip(self.units).for_each(|(y, unit)| *y *= unit);
        self.system.origin(y);
        y.iter_mut().zip(self.units).for_each(|(y, unit)| *y /= unit);
    }

    fn limit(&self) -> LimitAtZero {
        self.system.limit()
    }

    fn guesses_along_tangent(&self) -> bool {
        self.system.guesses_along_tangent()
    }

    fn algebraic(&self) -> &[usize] {
        self.system.algebraic()
    }

    fn is_affine(&self) -> bool {
        self.system.is_affine()
    }

    fn scale(&self, h: f64) -> f64 {
        self.system.scale(h)
    }
}

impl Newton {
    /// Whether steps are found in units of their own for the time being.
    pub(super) fn is_balanced(&self) -> bool {
        self.balanced.as_ref().is_some_and(|balanced| balanced.is_in_use)
    }

    /// Replaces `x`, a first guess, as [`solve`](Newton::solve) does, in the units of the last step that was solved so, or in new ones.
    pub(super) fn solve_balanced(
        &mut self,
        system: &mut dyn System,
        h: f64,
        x: &mut [f64],
        is_new: bool,
    ) -> Option<Result<(), SolveError>> {
        if is_new && !self.balance(system, h, x) {
            return None;
        }
        let mut balanced = self.balanced.take()?;
        let Balanced { newton, units, x: scratch, y, is_in_use } = &mut *balanced;
        y.iter_mut().zip(x.iter().zip(&*units)).for_each(|(y, (x, unit))| *y = x / unit);
        let before = newton.work;
        let found = newton.solve_in_these_units(&mut InUnits { system, units, x: scratch }, h, y);
        if found.is_ok() {
            scale(y, units, x);
        }
        *is_in_use = found.is_ok();
        self.work.residuals += newton.work.residuals - before.residuals;
        self.work.factorizations += newton.work.factorizations - before.factorizations;
        self.balanced = Some(balanced);
        Some(found)
    }

    /// Sets new units; false where they are those that the unknowns have, or none are found.
    fn balance(&mut self, system: &mut dyn System, h: f64, x: &[f64]) -> bool {
        let n = x.len();
        if n > MOST || system.limit() != LimitAtZero::Kept || !self.limit.is_regular || self.jacobian.dense().is_none()
        {
            return false;
        }
        self.point.copy_from_slice(x);
        system.origin(&mut self.point);
        let origin = std::mem::take(&mut self.point);
        system.residual(h, &origin, &mut self.part);
        self.jacobian.clear();
        system.derivative(h, &origin, &mut self.jacobian);
        self.point = origin;
        self.work.residuals += 1;
        let Some(mut a) = self.jacobian.dense().cloned() else { return false };
        a.column_iter_mut().for_each(|mut column| self.limit.solve(system, h, column.as_mut_slice()));
        let factor = self.limit.scale / system.scale(h);
        a *= factor;
        if !a.iter().all(|x| x.abs() <= LARGEST) {
            return false;
        }
        let units = balance_parlett_reinsch(&mut a);
        if units.iter().all(|unit| *unit == units[0]) {
            return false;
        }
        let balanced = self.balanced.get_or_insert_with(|| {
            let zeros = vec![0.0; n];
            let newton = Newton::new(n);
            Box::new(Balanced { newton, units: zeros.clone(), x: zeros.clone(), y: zeros, is_in_use: false })
        });
        if balanced.units != units.as_slice() {
            balanced.units.copy_from_slice(units.as_slice());
            balanced.newton.forget_limit();
        }
        true
    }
}
