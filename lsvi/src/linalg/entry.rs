//! What the entries of a factored matrix are: real or complex.

use std::fmt::Debug;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Sub, SubAssign};

use nalgebra::Complex;

/// Real and complex numbers.
pub(crate) trait Entry:
    faer::traits::ComplexField
    + Copy
    + Debug
    + From<f64>
    + PartialEq
    + Sum
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
{
    /// |x|, or |Re x| + |Im x|, which serves as well for the choice of a pivot.
    fn magnitude(self) -> f64;

    /// s x.
    fn scaled(self, s: f64) -> Self;
}

impl Entry for f64 {
    #[inline]
    fn magnitude(self) -> f64 {
        self.abs()
    }
    #[inline]
    fn scaled(self, s: f64) -> Self {
        self * s
    }
}

impl Entry for Complex<f64> {
    #[inline]
    fn magnitude(self) -> f64 {
        self.re.abs() + self.im.abs()
    }
    #[inline]
    fn scaled(self, s: f64) -> Self {
        self.scale(s)
    }
}
