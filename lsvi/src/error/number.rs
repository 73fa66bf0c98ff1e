//! How numbers are written in messages.

use std::fmt;

/// A number as people write it: with an exponent outside of 1e-4 to 1e6, where zeros would hide its size.
pub(super) struct Number(pub(super) f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(x) = self;
        if *x == 0.0 || !x.is_finite() || (1e-4..1e6).contains(&x.abs()) {
            write!(f, "{x}")
        } else {
            write!(f, "{x:e}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_far_from_one_have_an_exponent() {
        let text = |x| Number(x).to_string();
        assert_eq!([1e-4, 0.1, -2.5, 999_999.0, 0.0].map(text), ["0.0001", "0.1", "-2.5", "999999", "0"]);
        assert_eq!([1e-300, -9.9e-5, 1e6, f64::MAX].map(text), ["1e-300", "-9.9e-5", "1e6", "1.7976931348623157e308"]);
        assert_eq!([f64::NAN, f64::INFINITY, -f64::INFINITY].map(text), ["NaN", "inf", "-inf"]);
    }
}
