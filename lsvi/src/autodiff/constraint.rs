//! Holonomic constraints from one generic definition.

use nalgebra::DMatrix;
use num_dual::{Dual64, HyperDual64};

use super::Scalar;
use crate::constraint::Constraint;
use crate::linalg::Jacobian;
use crate::pool::Pool;

/// Holonomic constraints f(q) = 0, written once for every [`Scalar`].
///
/// ```
/// use lsvi::{ConstraintFn, Scalar};
/// struct Sphere;
/// impl ConstraintFn for Sphere {
///     fn dim(&self) -> usize { 3 }
///     fn count(&self) -> usize { 1 }
///     fn constraint<T: Scalar>(&self, q: &[T], out: &mut [T]) {
///         out[0] = q.iter().map(|&x| x * x).sum::<T>() - 1.0;
///     }
/// }
/// ```
pub trait ConstraintFn {
    /// Degrees of freedom n.
    fn dim(&self) -> usize;

    /// Number m of constraints.
    fn count(&self) -> usize;

    /// Writes f(q), length [`count`](Self::count).
    fn constraint<T: Scalar>(&self, q: &[T], out: &mut [T]);
}

/// Makes a [`Constraint`] of a [`ConstraintFn`]: the Jacobian in n evaluations, the curvature in n(n + 1)/2.
#[derive(Debug)]
pub struct AutoConstraint<F> {
    function: F,
    first: Pool<(Vec<Dual64>, Vec<Dual64>)>,
    second: Pool<(Vec<HyperDual64>, Vec<HyperDual64>)>,
}

impl<F: ConstraintFn> AutoConstraint<F> {
    /// Wraps `function`.
    pub fn new(function: F) -> Self {
        let (n, m) = (function.dim(), function.count());
        let first = Pool::new(move || (vec![Dual64::from(0.0); n], vec![Dual64::from(0.0); m]));
        let second = Pool::new(move || (vec![HyperDual64::from(0.0); n], vec![HyperDual64::from(0.0); m]));
        Self { function, first, second }
    }
}

impl<F: ConstraintFn> Constraint for AutoConstraint<F> {
    fn dim(&self) -> usize {
        self.function.dim()
    }

    fn count(&self) -> usize {
        self.function.count()
    }

    fn value(&self, q: &[f64], out: &mut [f64]) {
        self.function.constraint(q, out);
    }

    fn jacobian(&self, q: &[f64], out: &mut DMatrix<f64>) {
        self.first.with(|(dual, f)| {
            dual.iter_mut().zip(q).for_each(|(dual, &x)| *dual = Dual64::from(x));
            for i in 0..q.len() {
                dual[i].eps = 1.0;
                self.function.constraint(dual, f);
                dual[i].eps = 0.0;
                f.iter().enumerate().for_each(|(k, f)| out[(k, i)] = f.eps);
            }
        });
    }

    fn add_curvature(&self, q: &[f64], multipliers: &[f64], scale: f64, out: &mut Jacobian) {
        self.second.with(|(dual, f)| {
            dual.iter_mut().zip(q).for_each(|(dual, &x)| *dual = HyperDual64::from(x));
            for i in 0..q.len() {
                dual[i].eps1 = 1.0;
                for j in 0..=i {
                    dual[j].eps2 = 1.0;
                    self.function.constraint(dual, f);
                    dual[j].eps2 = 0.0;
                    let c = scale * f.iter().zip(multipliers).map(|(f, l)| l * f.eps1eps2).sum::<f64>();
                    out.add(i, j, c);
                    if i != j {
                        out.add(j, i, c);
                    }
                }
                dual[i].eps1 = 0.0;
            }
        });
    }
}
