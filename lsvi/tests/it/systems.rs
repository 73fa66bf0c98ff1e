//! Systems that the tests share, most of them mechanical, and pointers to any.
#![allow(dead_code, unused_macros)]

use lsvi::{
    AutoField, AutoLagrangian, ConstraintFn, EulerLagrange, FieldFn, ForceFn, LagrangianFn, Scalar, VectorField,
};

/// A Lagrangian behind a pointer, so that what steps it is compiled once for all tests. As their own types, systems are stepped in
/// `work.rs`, `counts.rs` and `recipes.rs`.
pub(crate) type AnyLagrangian<'a> = Box<dyn EulerLagrange + 'a>;
/// A field, as [`AnyLagrangian`].
pub(crate) type AnyField<'a> = Box<dyn VectorField + 'a>;

pub(crate) fn lagrangian_of<'a>(function: impl LagrangianFn + 'a) -> AnyLagrangian<'a> {
    Box::new(AutoLagrangian::new(function))
}

pub(crate) fn field_of<'a>(function: impl FieldFn + 'a) -> AnyField<'a> {
    Box::new(AutoField::new(function))
}

/// [`lsvi::field!`], as [`field_of`].
macro_rules! field_of {
    ($($formula:tt)*) => {
        Box::new(lsvi::field!($($formula)*)) as $crate::systems::AnyField
    };
}

/// Unit mass and stiffness.
pub(crate) struct Oscillator;
impl LagrangianFn for Oscillator {
    fn dim(&self) -> usize {
        1
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        (v[0] * v[0] - q[0] * q[0]) * 0.5
    }
}

/// Unit mass, length and gravity.
pub(crate) struct Pendulum;
impl LagrangianFn for Pendulum {
    fn dim(&self) -> usize {
        1
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        v[0] * v[0] * 0.5 + q[0].cos()
    }
}

/// Two unit masses on unit rods.
pub(crate) struct DoublePendulum;
impl LagrangianFn for DoublePendulum {
    fn dim(&self) -> usize {
        2
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        v[0] * v[0] + v[1] * v[1] * 0.5 + v[0] * v[1] * (q[0] - q[1]).cos() + q[0].cos() * 2.0 + q[1].cos()
    }
}

/// A plane particle in the magnetic field B = 2 + 4r² of the vector potential (1 + r²)(−y, x), and a quartic well.
pub(crate) struct ChargedParticle;
impl LagrangianFn for ChargedParticle {
    fn dim(&self) -> usize {
        2
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        let r2 = q[0] * q[0] + q[1] * q[1];
        (v[0] * v[0] + v[1] * v[1]) * 0.5 + (r2 + 1.0) * (q[0] * v[1] - q[1] * v[0]) - r2 * r2 * 0.25
    }
}

/// Hénon and Heiles's potential.
pub(crate) struct HenonHeiles;
impl LagrangianFn for HenonHeiles {
    fn dim(&self) -> usize {
        2
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        let (x, y) = (q[0], q[1]);
        (v[0] * v[0] + v[1] * v[1] - x * x - y * y) * 0.5 - x * x * y + y * y * y / 3.0
    }
}

/// A Lagrangian that depends on everything, no part of it quadratic.
pub(crate) struct Driven;
impl LagrangianFn for Driven {
    fn dim(&self) -> usize {
        2
    }
    fn lagrangian<T: Scalar>(&self, t: T, q: &[T], v: &[T]) -> T {
        let mass = (q[0] + t).sin() + 3.0;
        mass * v[0] * v[0] * 0.5 + (v[1] * v[1] + 1.0).sqrt() * 2.0 + v[0] * v[1] * q[1].cos() * 0.3 + q[0] * v[1] * t
            - (q[0] * q[1] - t).sin()
            - q[0].powi(4) * 0.1
    }
}

/// L_vv = 0.
pub(crate) struct Degenerate;
impl LagrangianFn for Degenerate {
    fn dim(&self) -> usize {
        2
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        q[0] * v[1] - q[0] * q[0] - q[1] * q[1]
    }
}

/// A free particle of unit mass with unit gravity along the last of `dim` axes.
pub(crate) struct Falling {
    pub(crate) dim: usize,
}
impl LagrangianFn for Falling {
    fn dim(&self) -> usize {
        self.dim
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        v.iter().map(|&v| v * v * 0.5).sum::<T>() - q[self.dim - 1]
    }
}

/// |q|² = 1.
pub(crate) struct Sphere {
    pub(crate) dim: usize,
}
impl ConstraintFn for Sphere {
    fn dim(&self) -> usize {
        self.dim
    }
    fn count(&self) -> usize {
        1
    }
    fn constraint<T: Scalar>(&self, q: &[T], out: &mut [T]) {
        out[0] = q.iter().map(|&x| x * x).sum::<T>() - 1.0;
    }
}

/// −rate (1 + q²) v, which depends on the configuration too.
pub(crate) struct Damping {
    pub(crate) dim: usize,
    pub(crate) rate: f64,
}
impl ForceFn for Damping {
    fn dim(&self) -> usize {
        self.dim
    }
    fn force<T: Scalar>(&self, _t: f64, q: &[T], v: &[T], out: &mut [T]) {
        for ((o, &q), &v) in out.iter_mut().zip(q).zip(v) {
            *o = -(q * q + 1.0) * v * self.rate;
        }
    }
}

/// A free particle of unit mass.
pub(crate) struct Free {
    pub(crate) dim: usize,
}
impl LagrangianFn for Free {
    fn dim(&self) -> usize {
        self.dim
    }
    fn lagrangian<T: Scalar>(&self, _t: T, _q: &[T], v: &[T]) -> T {
        v.iter().map(|&v| v * v * 0.5).sum::<T>()
    }
}
