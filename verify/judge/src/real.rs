//! Real numbers of 57 digits with a bound on what they are uncertain by.

use std::fmt;
use std::iter::Sum;
use std::ops::{Add, Div, Mul, Neg, Sub};

use dashu_float::FBig;
use dashu_float::round::Rounded;
use dashu_float::round::mode::HalfEven;
use dashu_int::IBig;
use dashu_ratio::RBig;

/// A binary float, rounded to nearest.
pub(super) type Float = FBig<HalfEven, 2>;

/// A decimal one.
type Decimal = FBig<HalfEven, 10>;

/// Bits of a mantissa: 57 decimal digits.
pub(super) const BITS: usize = 192;
/// Relative error of one rounded operation, 2⁻¹⁹¹: a whole unit of the last place, as quotients are not always rounded to the nearest.
const UNIT: f64 = 2.0 / ((1_u128 << 96) as f64 * (1_u128 << 96) as f64);
/// What the roundings of the radius itself, in double precision, can add to it.
const SLACK: f64 = 1.0 + 16.0 * f64::EPSILON;

/// A number known to lie within `radius` of `mid`: arithmetic on balls, so that what follows from rounded coefficients
/// carries the bound on its error along.
#[derive(Debug, Clone, PartialEq)]
pub struct Real {
    mid: Float,
    radius: f64,
}

impl Real {
    /// Zero.
    pub fn zero() -> Self {
        Self::from(0)
    }

    /// One.
    pub fn one() -> Self {
        Self::from(1)
    }

    pub(super) fn rounded(mid: Float, radius: f64) -> Self {
        let mid = mid.with_precision(BITS).value();
        let rounding = to_f64(&mid).abs() * UNIT;
        Self { mid, radius: (radius + rounding) * SLACK }
    }

    /// A rational number, rounded.
    pub(super) fn rational(value: &RBig) -> Self {
        match value.to_float::<HalfEven, 2>(BITS) {
            Rounded::Exact(mid) => Self { mid: mid.with_precision(BITS).value(), radius: 0.0 },
            Rounded::Inexact(mid, _) => Self::rounded(mid, 0.0),
        }
    }

    /// A double, which has no more bits than this; anything where it is not finite.
    pub fn double(x: f64) -> Self {
        let anything = || Self { mid: Float::ZERO, radius: f64::INFINITY };
        RBig::try_from(x).map_or_else(|_| anything(), |x| Self::rational(&x))
    }

    /// The same with `radius` more of uncertainty.
    #[must_use]
    pub fn widened(&self, radius: f64) -> Self {
        Self { mid: self.mid.clone(), radius: (self.radius + radius) * SLACK }
    }

    /// The numbers of which this one, printed, is the next towards zero, where it is one of those of which it is the nearest.
    #[must_use]
    pub(super) fn of_truncated(&self) -> Self {
        self + &Self::double(self.radius.copysign(self.to_f64()))
    }

    /// The numbers that are rounded to the double of which this one is the expansion, as far as it is printed; `None` if it is none of a double.
    #[must_use]
    pub(super) fn of_double(&self) -> Option<Self> {
        let double = self.to_f64();
        let exact = Self::double(double);
        (self - &exact).may_be_zero().then(|| exact.widened(0.5 * f64::EPSILON * double.abs()))
    }

    /// The same without its uncertainty.
    #[must_use]
    pub fn centre(&self) -> Self {
        Self { mid: self.mid.clone(), radius: 0.0 }
    }

    pub(super) fn mid(&self) -> &Float {
        &self.mid
    }

    /// How far the number may lie from its centre.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The double nearest to the centre.
    pub fn to_f64(&self) -> f64 {
        to_f64(&self.mid)
    }

    /// Whether it is uncertain by more than a double is.
    pub(super) fn is_rough(&self) -> bool {
        self.radius > f64::EPSILON * self.to_f64().abs()
    }

    /// Whether the number is zero and no other.
    pub fn is_zero(&self) -> bool {
        self.radius == 0.0 && self.may_be_zero()
    }

    /// Whether the number may be zero.
    pub fn may_be_zero(&self) -> bool {
        self.to_f64().abs() <= self.radius * SLACK
    }

    /// Whether the number is certainly positive.
    pub fn is_positive(&self) -> bool {
        !self.may_be_zero() && self.to_f64() > 0.0
    }

    /// Whether the number is certainly negative.
    pub fn is_negative(&self) -> bool {
        !self.may_be_zero() && self.to_f64() < 0.0
    }

    /// `digits` significant decimal digits of the centre.
    pub fn decimal(&self, digits: usize) -> String {
        // All digits come first, exactly, as 2⁻ⁿ = 5ⁿ 10⁻ⁿ: the library's conversion to few at once is off by powers of ten, and that to
        // many takes logarithms.
        let (mantissa, exponent) = (self.mid.repr().significand(), self.mid.repr().exponent());
        let power = |base: u8| IBig::from(base).pow(exponent.unsigned_abs());
        let all = match exponent {
            0.. => Decimal::from_parts(mantissa * power(2), 0),
            _ => Decimal::from_parts(mantissa * power(5), exponent),
        };
        all.with_precision(digits).value().to_string()
    }

    /// The rational of the smallest denominator within the radius, or within 10⁻⁴⁰ where that is wider.
    pub(super) fn simplest(&self) -> Option<RBig> {
        let centre = RBig::try_from(self.mid.clone()).ok()?;
        let radius = RBig::try_from((self.radius * SLACK).max(1e-40)).ok()?;
        let (low, high) = (&centre - &radius, &centre + &radius);
        // The library takes ends for no part of the interval.
        if low.is_zero() || high.is_zero() {
            return Some(RBig::ZERO);
        }
        Some(RBig::simplest_in(low, high))
    }
}

/// The mantissa rounded and then scaled: the library's conversion bounds logarithms on the way, and took most of the time of a judgement.
fn to_f64(x: &Float) -> f64 {
    let (mantissa, exponent) = (x.repr().significand(), x.repr().exponent());
    // What is out of the range of an i32 is beyond that of doubles too.
    let exponent = exponent.clamp(i32::MIN as isize, i32::MAX as isize) as i32;
    libm::scalbn(mantissa.to_f64().value(), exponent)
}

impl From<i64> for Real {
    fn from(n: i64) -> Self {
        Self { mid: Float::from(n).with_precision(BITS).value(), radius: 0.0 }
    }
}

impl Add for &Real {
    type Output = Real;
    fn add(self, other: &Real) -> Real {
        if self.is_exact_zero() {
            return other.clone();
        }
        if other.is_exact_zero() {
            return self.clone();
        }
        Real::rounded(&self.mid + &other.mid, self.radius + other.radius)
    }
}

impl Sub for &Real {
    type Output = Real;
    fn sub(self, other: &Real) -> Real {
        self + &-other
    }
}

impl Mul for &Real {
    type Output = Real;
    fn mul(self, other: &Real) -> Real {
        if self.is_exact_zero() || other.is_exact_zero() {
            return Real::zero();
        }
        let (a, b) = (self.to_f64().abs(), other.to_f64().abs());
        let radius = a * other.radius + b * self.radius + self.radius * other.radius;
        Real::rounded(&self.mid * &other.mid, radius)
    }
}

impl Div for &Real {
    type Output = Real;
    /// The divisor must not be able to be zero.
    fn div(self, other: &Real) -> Real {
        let (a, b) = (self.to_f64().abs(), other.to_f64().abs());
        let radius = (self.radius + a / b * other.radius) / (b - other.radius);
        Real::rounded(&self.mid / &other.mid, radius)
    }
}

impl Neg for &Real {
    type Output = Real;
    fn neg(self) -> Real {
        Real { mid: -self.mid.clone(), radius: self.radius }
    }
}

impl Real {
    fn is_exact_zero(&self) -> bool {
        self.radius == 0.0 && self.mid == Float::ZERO
    }
}

impl Sum for Real {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::zero(), |sum, x| &sum + &x)
    }
}

impl<'a> Sum<&'a Self> for Real {
    fn sum<I: Iterator<Item = &'a Self>>(iter: I) -> Self {
        iter.fold(Self::zero(), |sum, x| &sum + x)
    }
}

impl fmt::Display for Real {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.decimal(f.precision().unwrap_or(20)))
    }
}

/// Σ x_i y_i.
pub(super) fn dot(x: &[Real], y: &[Real]) -> Real {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_thrice_is_one_within_the_roundings_and_nothing_wider() {
        let third = &Real::one() / &Real::from(3);
        let defect = &(&third * &Real::from(3)) - &Real::one();
        assert!(defect.may_be_zero() && defect.radius() < 1e-56);
        let off = &third + &Real::rational(&RBig::from_parts(1.into(), 10_u8.into()).pow(50));
        assert!((&(&off * &Real::from(3)) - &Real::one()).is_positive());
    }

    /// (n/d − ½) 2d = 2n − d, however much cancels.
    #[test]
    fn what_quotients_lose_is_within_their_bounds() {
        for d in (3..200).chain([10_000, 1_000_003]) {
            for n in [1, 2, d - 1, d + 1, d / 2 + 1] {
                let quotient = Real::rational(&RBig::from_parts(n.into(), u64::try_from(d).expect("positive").into()));
                for quotient in [quotient, &Real::from(n) / &Real::from(d)] {
                    let half = &quotient - &Real::double(0.5);
                    let left = &(&half * &Real::from(2 * d)) - &Real::from(2 * n - d);
                    assert!(left.may_be_zero(), "{n}/{d}: {:e} beyond {:e}", left.to_f64(), left.radius());
                }
            }
        }
    }

    /// Ties go to the even one, and what is out of range to 0 and to infinity.
    #[test]
    fn a_double_is_the_nearest() {
        let third = &Real::one() / &Real::from(3);
        assert_eq!([&third, &-&third].map(Real::to_f64), [1.0 / 3.0, -1.0 / 3.0]);
        let power =
            |n: i32| Real { mid: Float::from_parts(1.into(), n as isize).with_precision(BITS).value(), radius: 0.0 };
        for (low, expected) in [(-53, 1.0), (-52, 1.0 + f64::EPSILON)] {
            assert_eq!((&Real::one() + &power(low)).to_f64(), expected);
        }
        let beyond = &(&Real::one() + &power(-53)) + &power(-150);
        assert_eq!((beyond.to_f64(), (-&beyond).to_f64()), (1.0 + f64::EPSILON, -1.0 - f64::EPSILON));
        assert_eq!((&(&Real::from(3) * &power(-53)) + &Real::one()).to_f64(), 1.0 + 2.0 * f64::EPSILON);
        for n in [-1074, -1000, -1, 0, 100, 1023] {
            assert_eq!(power(n).to_f64(), libm::scalbn(1.0, n), "2^{n}");
        }
        assert_eq!([-1200, 1200, 1 << 30].map(|n| power(n).to_f64()), [0.0, f64::INFINITY, f64::INFINITY]);
        assert_eq!(Real::zero().to_f64(), 0.0);
    }

    #[test]
    fn a_decimal_is_the_number_to_its_digits() {
        for (n, d) in [(8, 10_000), (1, 1_000_000), (3, 100_000), (-1, 7), (22, 7), (99_996, 100_000), (12_345_678, 1)]
        {
            let x = Real::rational(&RBig::from_parts(n.into(), u64::try_from(d).expect("positive").into()));
            for digits in [1, 2, 3, 12] {
                let text = x.decimal(digits);
                let read: f64 = text.parse().expect("a decimal");
                let unit = 10_f64.powi(x.to_f64().abs().log10().floor() as i32 + 1 - digits as i32);
                let error = (read - x.to_f64()).abs();
                assert!(error <= 0.5 * unit * (1.0 + 1e-9), "{n}/{d} to {digits} digits is no {text}");
            }
        }
        assert_eq!(Real::rational(&RBig::from_parts(8.into(), 10_000_u64.into())).decimal(1), "0.0008");
        assert_eq!(Real::from(0).decimal(3), "0");
        assert_eq!(format!("{:.3}", &Real::from(1) / &Real::from(3)), "0.333");
    }

    #[test]
    fn rationals_are_recovered_from_their_digits() {
        let x = &Real::from(-2187) / &Real::from(6784);
        assert_eq!(x.simplest().expect("finite").to_string(), "-2187/6784");
        assert_eq!((&x - &x).simplest().expect("finite").to_string(), "0");
    }

    #[test]
    fn what_was_truncated_is_further_from_zero_on_either_side() {
        for sign in [1.0, -1.0] {
            let found = Real::double(0.25 * sign).widened(0.125).of_truncated();
            assert!((found.to_f64() - 0.375 * sign).abs() < 1e-14, "{found:?}");
        }
    }

    /// 1/(½ − ¼) is 2 from 1/½.
    #[test]
    fn the_bound_of_a_quotient_holds_the_ends_of_a_wide_divisor() {
        let found = &Real::one() / &Real::double(0.5).widened(0.25);
        assert!(found.radius() >= 2.0 && found.radius() < 2.0001, "{found:?}");
    }

    /// ε of 1000 is 2.2·10⁻¹³.
    #[test]
    fn what_is_uncertain_by_more_than_a_double_is_rough() {
        let is_rough = |radius: f64| Real::from(1000).widened(radius).is_rough();
        assert_eq!([0.0, 1e-13, 3e-13].map(is_rough), [false, false, true]);
    }

    /// A radius that is short of 1 by a rounding of its own, and one by more.
    #[test]
    fn a_radius_reaches_farther_by_the_roundings_in_it() {
        let may_be_zero = |radius: f64| Real { radius, ..Real::one() }.may_be_zero();
        assert_eq!([1.0, 1.0 - f64::EPSILON, 1.0 - 1e-13].map(may_be_zero), [true, true, false]);
    }

    #[test]
    fn zero_is_the_simplest_number_of_an_interval_that_ends_there() {
        for sign in [1.0, -1.0] {
            let x = Real { radius: 0.25, ..Real::double(sign * 0.25 * SLACK) };
            assert_eq!(x.simplest(), Some(RBig::ZERO), "{sign}");
        }
        assert_eq!(Real::double(0.4).widened(0.125).simplest().expect("finite").to_string(), "1/2");
    }

    #[test]
    fn zero_times_anything_is_zero() {
        let anything = Real::double(f64::INFINITY);
        assert!((&Real::zero() * &anything).is_zero() && (&anything * &Real::zero()).is_zero());
    }
}
