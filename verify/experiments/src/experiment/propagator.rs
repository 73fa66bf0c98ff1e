//! Linear systems v̇ = Av and what a method makes of them, from live steps of size 1: A stands for hA.

use std::ops::ControlFlow;

use lsvi::{Jacobian, VectorField};
use nalgebra::{Complex, DMatrix, DVector};

use crate::measure::stability::spectral_radius;
use crate::method::Method;
use crate::problem::Problem;
use crate::reference::Ode;
use crate::run::{RunError, run_from};

/// Why there is no propagator.
#[derive(Debug, thiserror::Error)]
pub enum ProbeError {
    /// The method does not apply, or a step fails.
    #[error(transparent)]
    Run(#[from] RunError),
    /// It is none of fixed steps.
    #[error("{0} chooses its own steps")]
    OwnSteps(String),
}

/// v̇ = Av from the first unit vector.
#[derive(Debug)]
struct LinearSystem<'a>(&'a DMatrix<f64>);

impl VectorField for LinearSystem<'_> {
    fn dim(&self) -> usize {
        self.0.nrows()
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        for (i, dv) in dv.iter_mut().enumerate() {
            *dv = v.iter().enumerate().map(|(j, v)| self.0[(i, j)] * v).sum();
        }
    }
    fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
        for j in 0..self.0.ncols() {
            (0..self.0.nrows()).for_each(|i| out.add(i, j, scale * self.0[(i, j)]));
        }
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
}

impl Ode for LinearSystem<'_> {
    fn dim(&self) -> usize {
        self.0.nrows()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        VectorField::rhs(self, t, v, dv);
    }
    fn jacobian(&self, _t: f64, _v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        for j in 0..self.0.ncols() {
            (0..self.0.nrows()).for_each(|i| add(i, j, self.0[(i, j)]));
        }
    }
}

impl Problem for LinearSystem<'_> {
    fn components(&self) -> &'static [&'static str] {
        &["v"]
    }
    fn initial(&self) -> Vec<f64> {
        let mut v = vec![0.0; self.0.nrows()];
        v[0] = 1.0;
        v
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(LinearSystem(self.0))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
}

/// The first `count` rows of `method` on v̇ = Av from the unit vector of component `start`, the initial state first.
///
/// # Errors
/// [`ProbeError`] if the method does not apply, a step fails, or steps are not of size 1.
fn rows(method: &dyn Method, a: &DMatrix<f64>, start: usize, count: usize) -> Result<Vec<Vec<f64>>, ProbeError> {
    let problem = LinearSystem(a);
    let mut v = vec![0.0; a.nrows()];
    v[start] = 1.0;
    let (mut rows, mut own_steps) = (Vec::with_capacity(count), false);
    run_from(&problem, v, method, 1.0, (count - 1) as f64, |state, _| {
        own_steps |= state.t != rows.len() as f64;
        rows.push(state.q.clone());
        if own_steps { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    if own_steps {
        return Err(ProbeError::OwnSteps(method.name()));
    }
    Ok(rows)
}

/// The matrix by which `method` multiplies the state in one step of v̇ = Av.
///
/// # Errors
/// [`ProbeError`] if the method does not apply, a step fails, or steps are not of size 1.
pub fn propagator(method: &dyn Method, a: &DMatrix<f64>) -> Result<DMatrix<f64>, ProbeError> {
    let mut matrix = DMatrix::zeros(a.nrows(), a.nrows());
    for (j, mut column) in matrix.column_iter_mut().enumerate() {
        column.copy_from_slice(&rows(method, a, j, 2)?[1]);
    }
    Ok(matrix)
}

/// The factor by which a step of `method` multiplies the perturbation of v̇ = Av that it amplifies most, A standing for hA: the spectral
/// radius of its matrix. None of a method that does not apply, or chooses its own steps.
pub fn growth(method: &dyn Method, a: &DMatrix<f64>) -> Option<f64> {
    propagator(method, a).ok().map(|step| spectral_radius(&step))
}

/// The error of a step of `method` on v̇ = f + A v from 0, (R(A) − e^A) d where A d = f, without the part of f outside of the range of A;
/// A and f stand for hA and hf. None of a method that does not apply, or chooses its own steps.
pub fn step_error(method: &dyn Method, a: &DMatrix<f64>, f: &DVector<f64>) -> Option<DVector<f64>> {
    let carried = exponential(a)?;
    let step = propagator(method, a).ok()?;
    let svd = a.clone().svd(true, true);
    let distance = svd.solve(f, f64::EPSILON * a.nrows() as f64 * svd.singular_values.max()).ok()?;
    Some((step - carried) * distance)
}

/// A norm of A whose tenth power, of which the scaling of e^A is told, does not overflow, nor the squares that balancing adds.
pub const SCALED: f64 = 1e30;

/// e^A; none where A is so large, or not finite, that its scaling would have no end.
pub fn exponential(a: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    (a.norm() < SCALED).then(|| a.exp())
}

/// The amplitudes w₀ = 1, w₁, w₂, w₃ of v̇ = zv at the ends of as many solutions of the equations of `method`, which sees it
/// as the real system with the normal matrix ((x, −y), (y, x)), z = x + iy.
///
/// # Errors
/// [`ProbeError`] if the method does not apply, a step fails, or steps are not of size 1.
pub(crate) fn amplitudes(method: &dyn Method, z: Complex<f64>) -> Result<[Complex<f64>; 4], ProbeError> {
    let a = DMatrix::from_row_slice(2, 2, &[z.re, -z.im, z.im, z.re]);
    let stride = method.traits().rows_per_solve;
    let rows = rows(method, &a, 0, 3 * stride + 1)?;
    Ok([0, 1, 2, 3].map(|k| Complex::new(rows[k * stride][0], rows[k * stride][1])))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a matrix that is too large, or none, powers would be taken without end.
    #[test]
    fn an_exponential_is_told_where_it_comes_to_an_end() {
        let of = |x: f64| exponential(&DMatrix::from_row_slice(2, 2, &[0.0, x, -x, 0.0]));
        approx::assert_relative_eq!(of(1.0).expect("a rotation")[(0, 1)], 1.0_f64.sin(), max_relative = 1e-14);
        assert!([1e200, f64::INFINITY, f64::NAN].into_iter().all(|x| of(x).is_none()));
    }
}
