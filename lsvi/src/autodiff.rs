//! Derivatives by forward-mode automatic differentiation, from one generic definition.

mod constraint;
mod force;
mod lagrangian;

pub use constraint::{AutoConstraint, ConstraintFn};
pub use force::{AutoForce, ForceFn};
pub use lagrangian::{AutoLagrangian, LagrangianFn};

use std::cell::RefCell;

use num_dual::{Dual64, DualNum, HyperDual64};

use crate::linalg::Jacobian;
use crate::vector_field::VectorField;

/// Numbers that a generic definition computes with: `f64` and dual numbers over it.
///
/// Arithmetic takes `f64` on the right (`x * 2.0`); functions are methods (`x.sin()`, `x.powi(2)`).
pub trait Scalar: DualNum<Primitive = f64> + Copy {}
impl<T: DualNum<Primitive = f64> + Copy> Scalar for T {}

/// The right-hand side of v̇ = f(t, v), written once for every [`Scalar`].
///
/// ```
/// use lsvi::{Rhs, Scalar};
/// struct VanDerPol { mu: f64 }
/// impl Rhs for VanDerPol {
///     fn dim(&self) -> usize { 2 }
///     fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
///         dv[0] = v[1];
///         dv[1] = (-v[0] * v[0] + 1.0) * v[1] * self.mu - v[0];
///     }
/// }
/// ```
pub trait Rhs {
    /// Number of unknowns.
    fn dim(&self) -> usize;

    /// Writes f(t, v) into `dv`; both have length [`dim`](Self::dim).
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]);
}

impl<F: Rhs> Rhs for &F {
    fn dim(&self) -> usize {
        (**self).dim()
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        (**self).rhs(t, v, dv);
    }
}

/// Makes a [`VectorField`] of an [`Rhs`]: the Jacobian in n sweeps, the curvature in n(n + 1)/2.
#[derive(Debug)]
pub struct AutoDiff<F> {
    field: F,
    first: RefCell<Sweep<Dual64>>,
    second: RefCell<Sweep<HyperDual64>>,
}

#[derive(Debug)]
struct Sweep<T> {
    v: Vec<T>,
    dv: Vec<T>,
}

impl<T: Scalar> Sweep<T> {
    fn new(dim: usize) -> RefCell<Self> {
        RefCell::new(Self { v: vec![T::from(0.0); dim], dv: vec![T::from(0.0); dim] })
    }

    fn seed(&mut self, v: &[f64]) {
        for (dual, &x) in self.v.iter_mut().zip(v) {
            *dual = T::from(x);
        }
    }
}

impl<F: Rhs> AutoDiff<F> {
    /// Wraps `field`.
    pub fn new(field: F) -> Self {
        let dim = field.dim();
        Self { first: Sweep::new(dim), second: Sweep::new(dim), field }
    }

    /// The definition that is differentiated.
    pub fn inner(&self) -> &F {
        &self.field
    }
}

impl<F: Rhs> VectorField for AutoDiff<F> {
    fn dim(&self) -> usize {
        self.field.dim()
    }

    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.field.rhs(t, v, dv);
    }

    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        let sweep = &mut *self.first.borrow_mut();
        sweep.seed(v);
        for j in 0..v.len() {
            sweep.v[j].eps = 1.0;
            self.field.rhs(t, &sweep.v, &mut sweep.dv);
            sweep.v[j].eps = 0.0;
            for (i, f) in sweep.dv.iter().enumerate() {
                if f.eps != 0.0 {
                    out.add(i, j, scale * f.eps);
                }
            }
        }
    }

    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        let sweep = &mut *self.second.borrow_mut();
        sweep.seed(v);
        for j in 0..v.len() {
            sweep.v[j].eps1 = 1.0;
            for k in 0..=j {
                sweep.v[k].eps2 = 1.0;
                self.field.rhs(t, &sweep.v, &mut sweep.dv);
                sweep.v[k].eps2 = 0.0;
                let c: f64 = sweep.dv.iter().zip(w).map(|(f, w)| w * f.eps1eps2).sum();
                if c != 0.0 {
                    out.add(j, k, scale * c);
                    if j != k {
                        out.add(k, j, scale * c);
                    }
                }
            }
            sweep.v[j].eps1 = 0.0;
        }
    }
}
