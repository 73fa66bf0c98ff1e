//! Derivatives by forward-mode automatic differentiation, from one generic definition.

mod constraint;
mod force;
mod lagrangian;
mod sweep;

pub use constraint::{AutoConstraint, ConstraintFn};
pub use force::{AutoForce, ForceFn};
pub use lagrangian::{AutoLagrangian, LagrangianFn};

use auto_impl::auto_impl;
use num_dual::{Dual64, DualNum};

use self::sweep::{Sweeps, add_columns, each, write_values};
use crate::linalg::{Jacobian, Structure, by_size};
use crate::mass::Mass;
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
    sweeps: Sweeps,
}

impl<F: FieldFn> AutoField<F> {
    /// Wraps `field`.
    pub fn new(field: F) -> Self {
        Self { sweeps: Sweeps::new(field.dim(), field.structure()), field }
    }

    /// The definition that is differentiated.
    pub fn inner(&self) -> &F {
        &self.field
    }

    /// The state of a dense system of N unknowns, whose derivatives are found on the stack.
    #[inline(always)]
    fn few<'a, const N: usize>(&self, v: &'a [f64]) -> Option<&'a [f64; N]> {
        v.try_into().ok().filter(|_| self.sweeps.is_dense())
    }

    /// Adds `scale` · J of a dense system to `out`, and writes f into `dv`.
    #[inline(always)]
    fn linearize_small<const N: usize>(&self, t: f64, v: &[f64; N], dv: &mut [f64], scale: f64, out: &mut Jacobian) {
        let mut columns = [[Dual64::from(0.0); N]; N];
        each::<N>(v, |j, v| self.field.rhs(t, v, &mut columns[j]));
        add_columns(&columns, scale, out);
        write_values(&columns[0], dv);
    }
}

impl<F: FieldFn> VectorField for AutoField<F> {
    fn dim(&self) -> usize {
        self.field.dim()
    }

    fn structure(&self) -> Structure {
        self.sweeps.structure().clone()
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
            return self.linearize_small(t, v, dv, scale, out);
        }, else {});
        self.field.rhs(t, v, dv);
        self.add_jacobian(t, v, scale, out);
    }

    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.sweeps.add_jacobian(&|v, dv| self.field.rhs(t, v, dv), v, scale, out);
    }

    fn apply_jacobian(&self, t: f64, v: &[f64], x: &[f64], out: &mut [f64]) {
        self.sweeps.apply_jacobian(&|v, dv| self.field.rhs(t, v, dv), v, x, out);
    }

    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        if !self.field.is_linear() {
            self.sweeps.add_curvature(&|v, dv| self.field.rhs(t, v, dv), v, w, scale, out);
        }
    }
}
