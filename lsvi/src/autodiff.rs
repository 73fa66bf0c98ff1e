//! Derivatives by forward-mode automatic differentiation, from one generic definition.

mod constraint;
mod force;
mod lagrangian;
mod sweep;

pub use constraint::{AutoConstraint, ConstraintFn};
pub use force::{AutoForce, ForceFn};
pub use lagrangian::{AutoLagrangian, LagrangianFn};

use auto_impl::auto_impl;
use num_dual::{Dual64, DualNum, HyperDual64};

use crate::coloring::Coloring;
use crate::linalg::{Jacobian, Structure, by_size};
use crate::mass::Mass;
use crate::pool::Pool;
use crate::vector_field::VectorField;

/// Numbers that a generic definition computes with: `f64` and dual numbers over it.
///
/// Arithmetic takes `f64` on the right (`x * 2.0`); functions are methods (`x.sin()`, `x.powi(2)`). The `tanh` of dual numbers is sinh/cosh, whose
/// derivative is NaN for |x| > 355; (1 − e)/(1 + e) with e = e⁻²ˣ for x > 0 is the same, and finite. Where a derivative is infinite, as of `sqrt` or
/// `cbrt` at 0, it is not finite here.
pub trait Scalar: DualNum<Primitive = f64> + Copy {}
impl<T: DualNum<Primitive = f64> + Copy> Scalar for T {}

/// The right-hand side of v̇ = f(t, v), written once for every [`Scalar`].
///
/// ```
/// use lsvi::{FieldFn, Scalar};
/// struct VanDerPol { mu: f64 }
/// impl FieldFn for VanDerPol {
///     fn dim(&self) -> usize { 2 }
///     fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
///         dv[0] = v[1];
///         dv[1] = (-v[0] * v[0] + 1.0) * v[1] * self.mu - v[0];
///     }
/// }
/// ```
#[auto_impl(&)]
pub trait FieldFn {
    /// Number of unknowns.
    fn dim(&self) -> usize;

    /// Where ∂f_i/∂v_j may differ from zero, as [`VectorField::structure`].
    fn structure(&self) -> Structure {
        Structure::Dense
    }

    /// The matrix M of M v̇ = f, as [`VectorField::mass`].
    fn mass(&self) -> Mass {
        Mass::Identity
    }

    /// Whether f(t, v) = A v + g(t) with a constant A, as [`VectorField::is_linear`].
    fn is_linear(&self) -> bool {
        false
    }

    /// Whether f does not depend on t, as [`VectorField::is_autonomous`].
    fn is_autonomous(&self) -> bool {
        false
    }

    /// Writes f(t, v) into `dv`; both have length [`dim`](Self::dim).
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]);
}

/// Makes an [`AutoField`] of a formula: its number of unknowns, its parameters (all f64), and f as `|t, v, dv|`.
///
/// A closure cannot be generic over its numbers, as differentiation asks of it; this states a [`FieldFn`] in its place.
///
/// ```
/// use lsvi::{State, Trajectory, field, method_i};
/// let field = field!(2, mu = 5.0; |_t, v, dv| {
///     dv[0] = v[1];
///     dv[1] = (-v[0] * v[0] + 1.0) * v[1] * mu - v[0];
/// });
/// let run = Trajectory::new(method_i(field)?, State::new(0.0, vec![2.0, 0.0]), 0.01, 1.0)?;
/// assert!(run.observe(|_| {})?.q[0] > 1.8);
/// # Ok::<(), lsvi::StepError>(())
/// ```
#[macro_export]
macro_rules! field {
    ($dim:expr $(, $name:ident = $value:expr)*; |$t:ident, $v:ident, $dv:ident| $body:expr) => {{
        struct Formula {
            dim: usize,
            $($name: f64,)*
        }
        impl $crate::FieldFn for Formula {
            fn dim(&self) -> usize {
                self.dim
            }
            fn rhs<T: $crate::Scalar>(&self, $t: f64, $v: &[T], $dv: &mut [T]) {
                $(let $name = self.$name;)*
                $body
            }
        }
        $crate::AutoField::new(Formula { dim: $dim, $($name: $value,)* })
    }};
    ($dim:expr, |$t:ident, $v:ident, $dv:ident| $body:expr) => {
        $crate::field!($dim; |$t, $v, $dv| $body)
    };
}

/// Makes a [`VectorField`] of an [`FieldFn`].
///
/// A dense Jacobian takes n sweeps. With g groups of columns that share no row (`lower + upper + 1` for a band) it takes g + 1, and the
/// curvature, with g = n where it is dense, g(g + 1)/2. The extra sweep differentiates along all columns at once, which shows an f
/// that does not have the declared structure; its Jacobian is then found column by column, so that it is refused.
#[derive(Debug)]
pub struct AutoField<F> {
    field: F,
    structure: Structure,
    coloring: Coloring,
    /// Along which the structure is checked, if the field declares one.
    directions: Vec<f64>,
    first: Pool<Sweep<Dual64>>,
    second: Pool<Sweep<HyperDual64>>,
    row_check: Pool<Vec<RowCheck>>,
}

#[derive(Debug)]
struct Sweep<T> {
    v: Vec<T>,
    dv: Vec<T>,
}

impl<T: Scalar> Sweep<T> {
    fn new(dim: usize) -> Pool<Self> {
        Pool::new(move || Self { v: vec![T::from(0.0); dim], dv: vec![T::from(0.0); dim] })
    }

    fn seed(&mut self, v: &[f64]) {
        for (dual, &x) in self.v.iter_mut().zip(v) {
            *dual = T::from(x);
        }
    }
}

/// Σ_j J_ij s_j and Σ_j |J_ij s_j| of the entries found in row i.
#[derive(Debug, Clone, Copy, Default)]
struct RowCheck {
    sum: f64,
    size: f64,
}

impl RowCheck {
    /// Whether the sweep along s gives the same row sum but for the rounding of two evaluations.
    fn agrees(self, sweep: f64) -> bool {
        // Intermediate terms of f may exceed the entries; a structural entry shows far above this.
        const RELATIVE: f64 = 1e-8;
        sweep.is_nan() || (sweep - self.sum).abs() <= RELATIVE * self.size.max(sweep.abs() * f64::EPSILON.sqrt())
    }
}

/// Directions without small integer relations between their components, so that entries do not cancel.
fn direction(j: usize) -> f64 {
    1.0 + 0.5 * ((j + 1) as f64).sin()
}

impl<F: FieldFn> AutoField<F> {
    /// Wraps `field`.
    pub fn new(field: F) -> Self {
        let dim = field.dim();
        let structure = field.structure();
        Self {
            first: Sweep::new(dim),
            second: Sweep::new(dim),
            row_check: Pool::new(move || vec![RowCheck::default(); dim]),
            coloring: Coloring::new(dim, &structure),
            directions: if structure == Structure::Dense { Vec::new() } else { (0..dim).map(direction).collect() },
            structure,
            field,
        }
    }

    /// The definition that is differentiated.
    pub fn inner(&self) -> &F {
        &self.field
    }

    fn is_dense(&self) -> bool {
        self.structure == Structure::Dense
    }

    /// Whether the derivative along [`direction`] is that of the entries in `row_check`.
    fn has_declared_structure(&self, t: f64, sweep: &mut Sweep<Dual64>, row_check: &[RowCheck]) -> bool {
        sweep.v.iter_mut().zip(&self.directions).for_each(|(x, direction)| x.eps = *direction);
        self.field.rhs(t, &sweep.v, &mut sweep.dv);
        sweep.v.iter_mut().for_each(|x| x.eps = 0.0);
        row_check.iter().zip(&sweep.dv).all(|(row, f)| row.agrees(f.eps))
    }

    /// The state of a dense system of N unknowns, whose derivatives are found on the stack.
    #[inline(always)]
    fn few<'a, const N: usize>(&self, v: &'a [f64]) -> Option<&'a [f64; N]> {
        v.try_into().ok().filter(|_| self.is_dense())
    }

    /// Adds `scale` · J of a dense system to `out`, and returns f.
    #[inline(always)]
    fn linearize_small<const N: usize>(&self, t: f64, v: &[f64; N], scale: f64, out: &mut Jacobian) -> [f64; N] {
        let mut columns = [[Dual64::from(0.0); N]; N];
        sweep::each::<N>(v, |j, v| self.field.rhs(t, v, &mut columns[j]));
        match out.dense_mut() {
            Some(out) if out.len() == N * N => {
                for (out, f) in out.iter_mut().zip(columns.as_flattened()) {
                    *out += scale * f.eps;
                }
            }
            _ => {
                for (j, column) in columns.iter().enumerate() {
                    column.iter().enumerate().for_each(|(i, f)| out.add(i, j, scale * f.eps));
                }
            }
        }
        columns[0].map(|f| f.re)
    }

    /// The Jacobian of a dense system at the state of `sweep`, column by column.
    fn sweep_columns(&self, sweep: &mut Sweep<Dual64>, t: f64, scale: f64, out: &mut Jacobian) {
        for j in 0..sweep.v.len() {
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

    /// Adds `scale` · Σ_i w_i ∂²f_i of a dense system at `v` to `out`; `dv` is work space.
    #[inline(always)]
    fn sweep_pairs(
        &self,
        (t, v, dv): (f64, &mut [HyperDual64], &mut [HyperDual64]),
        w: &[f64],
        scale: f64,
        out: &mut Jacobian,
    ) {
        for j in 0..v.len() {
            v[j].eps1 = 1.0;
            for k in 0..=j {
                v[k].eps2 = 1.0;
                self.field.rhs(t, v, dv);
                v[k].eps2 = 0.0;
                let entry = scale * w.iter().zip(&*dv).map(|(w, f)| w * f.eps1eps2).sum::<f64>();
                if entry != 0.0 {
                    out.add(j, k, entry);
                    if j != k {
                        out.add(k, j, entry);
                    }
                }
            }
            v[j].eps1 = 0.0;
        }
    }

    /// [`VectorField::add_jacobian`] with work space.
    fn sweep_jacobian(
        &self,
        sweep: &mut Sweep<Dual64>,
        row_check: &mut [RowCheck],
        (t, v): (f64, &[f64]),
        scale: f64,
        out: &mut Jacobian,
    ) {
        sweep.seed(v);
        if self.is_dense() {
            return self.sweep_columns(sweep, t, scale, out);
        }
        row_check.fill(RowCheck::default());
        for c in 0..self.coloring.groups() {
            self.coloring.columns(c).for_each(|j| sweep.v[j].eps = 1.0);
            self.field.rhs(t, &sweep.v, &mut sweep.dv);
            self.coloring.columns(c).for_each(|j| sweep.v[j].eps = 0.0);
            for (i, j) in self.coloring.entries(c) {
                let entry = sweep.dv[i].eps;
                if entry != 0.0 {
                    out.add(i, j, scale * entry);
                    let along = entry * self.directions[j];
                    row_check[i].sum += along;
                    row_check[i].size += along.abs();
                }
            }
        }
        if self.has_declared_structure(t, sweep, row_check) {
            return;
        }
        for j in 0..v.len() {
            sweep.v[j].eps = 1.0;
            self.field.rhs(t, &sweep.v, &mut sweep.dv);
            sweep.v[j].eps = 0.0;
            for (i, f) in sweep.dv.iter().enumerate() {
                if self.structure.rows(v.len(), j).all(|row| row != i) {
                    out.add(i, j, scale * f.eps);
                }
            }
        }
    }
}

impl<F: FieldFn> VectorField for AutoField<F> {
    fn dim(&self) -> usize {
        self.field.dim()
    }

    fn structure(&self) -> Structure {
        self.structure.clone()
    }

    fn mass(&self) -> Mass {
        self.field.mass()
    }

    fn is_linear(&self) -> bool {
        self.field.is_linear()
    }

    fn is_autonomous(&self) -> bool {
        self.field.is_autonomous()
    }

    #[inline]
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.field.rhs(t, v, dv);
    }

    #[inline(always)]
    fn linearize(&self, t: f64, v: &[f64], dv: &mut [f64], scale: f64, out: &mut Jacobian) {
        by_size!(self.field.dim(), N => if let Some(v) = self.few::<N>(v) {
            let f = self.linearize_small(t, v, scale, out);
            return dv.iter_mut().zip(f).for_each(|(dv, f)| *dv = f);
        }, else {});
        self.field.rhs(t, v, dv);
        self.add_jacobian(t, v, scale, out);
    }

    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        by_size!(self.field.dim(), N => if let Some(v) = self.few::<N>(v) {
            self.linearize_small(t, v, scale, out);
            return;
        }, else {});
        self.first.with(|sweep| self.row_check.with(|rows| self.sweep_jacobian(sweep, rows, (t, v), scale, out)));
    }

    fn apply_jacobian(&self, t: f64, v: &[f64], x: &[f64], out: &mut [f64]) {
        self.first.with(|sweep| {
            sweep.seed(v);
            sweep.v.iter_mut().zip(x).for_each(|(dual, x)| dual.eps = *x);
            self.field.rhs(t, &sweep.v, &mut sweep.dv);
            out.iter_mut().zip(&sweep.dv).for_each(|(o, f)| *o = f.eps);
        });
    }

    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        if self.field.is_linear() {
            return;
        }
        by_size!(self.field.dim(), N => if let Some(v) = self.few::<N>(v) {
            let (mut v, mut dv) = (v.map(HyperDual64::from), [HyperDual64::from(0.0); N]);
            return self.sweep_pairs((t, &mut v, &mut dv), w, scale, out);
        }, else {});
        self.second.with(|sweep| {
            sweep.seed(v);
            if self.is_dense() {
                return self.sweep_pairs((t, &mut sweep.v, &mut sweep.dv), w, scale, out);
            }
            for c in 0..self.coloring.groups() {
                self.coloring.columns(c).for_each(|j| sweep.v[j].eps1 = 1.0);
                for d in 0..=c {
                    self.coloring.columns(d).for_each(|k| sweep.v[k].eps2 = 1.0);
                    self.field.rhs(t, &sweep.v, &mut sweep.dv);
                    self.coloring.columns(d).for_each(|k| sweep.v[k].eps2 = 0.0);
                    for (i, j) in self.coloring.entries(c) {
                        let (Some(k), entry) = (self.coloring.column(d, i), scale * w[i] * sweep.dv[i].eps1eps2) else {
                            continue;
                        };
                        if entry != 0.0 {
                            out.add(j, k, entry);
                            if c != d {
                                out.add(k, j, entry);
                            }
                        }
                    }
                }
                self.coloring.columns(c).for_each(|j| sweep.v[j].eps1 = 0.0);
            }
        });
    }
}
