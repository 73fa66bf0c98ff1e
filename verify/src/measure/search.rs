//! Roots and minima of functions of one number.

use std::convert::Infallible;

/// The point of the interval `bracket` where `f` changes its sign, by bisection to the last bit; `None` where it has one sign at
/// both ends, or is NaN at a point that is tried.
pub fn root(bracket: [f64; 2], mut f: impl FnMut(f64) -> f64) -> Option<f64> {
    try_root(bracket, |x| Ok::<_, Infallible>(f(x))).unwrap_or_else(|error| match error {})
}

/// [`root`] of a function that can fail.
///
/// # Errors
/// The first error of `f`.
pub fn try_root<E>([mut low, mut high]: [f64; 2], mut f: impl FnMut(f64) -> Result<f64, E>) -> Result<Option<f64>, E> {
    let (at_low, at_high) = (f(low)?, f(high)?);
    if at_low == 0.0 || at_high == 0.0 {
        return Ok(Some(if at_low == 0.0 { low } else { high }));
    }
    if at_low.is_nan() || at_high.is_nan() || (at_low > 0.0) == (at_high > 0.0) {
        return Ok(None);
    }
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return Ok(Some(middle));
        }
        let value = f(middle)?;
        if value.is_nan() {
            return Ok(None);
        }
        if (value > 0.0) == (at_low > 0.0) { low = middle } else { high = middle }
    }
}

/// The point of the interval `bracket` where `f`, which has one minimum there, is least, to within ½ `width`: by golden
/// section, in which a NaN counts as large.
pub fn minimum(bracket: [f64; 2], width: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    try_minimum(bracket, width, |x| Ok::<_, Infallible>(f(x))).unwrap_or_else(|error| match error {})
}

/// [`minimum`] of a function that can fail.
///
/// # Errors
/// The first error of `f`.
pub fn try_minimum<E>(
    [mut low, mut high]: [f64; 2],
    width: f64,
    mut f: impl FnMut(f64) -> Result<f64, E>,
) -> Result<f64, E> {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    // Below √ε of a point a minimum is flat to rounding.
    let width = width.max(f64::EPSILON.sqrt() * low.abs().max(high.abs()));
    while high - low > width {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if f(a)? < f(b)? { high = b } else { low = a }
    }
    Ok(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_root_is_found_to_the_last_bit_from_either_side() {
        for sign in [1.0, -1.0] {
            let found = root([0.0, 2.0], |x| sign * (x * x - 2.0)).expect("it changes its sign");
            assert!((found - 2.0_f64.sqrt()).abs() <= f64::EPSILON, "{found}");
        }
        assert_eq!(root([0.0, 1.0], |x| x), Some(0.0));
        assert_eq!(root([-1.0, 0.0], |x| x), Some(0.0));
    }

    /// A wrong root is never returned.
    #[test]
    fn without_a_change_of_sign_there_is_no_root() {
        assert_eq!(root([1.0, 2.0], |x| x), None);
        assert_eq!(root([0.0, 2.0], |x| if x == 1.0 { f64::NAN } else { x - 0.7 }), None);
        assert_eq!(root([0.0, 2.0], |_| f64::NAN), None);
        assert_eq!(try_root([0.0, 2.0], |x| if x == 1.0 { Err("broken") } else { Ok(x - 0.7) }), Err("broken"));
    }

    /// To ½ width, or half of what rounding leaves: f changes by ε where x changes by √ε.
    #[test]
    fn a_minimum_is_found_to_the_width_asked_for() {
        for width in [1e-3, 1e-6, 0.0] {
            let found = minimum([0.0, 3.0], width, |x| 1.0 + (x - 0.7).powi(2));
            assert!((found - 0.7).abs() <= width.max(3.0 * f64::EPSILON.sqrt()), "{found}");
        }
        assert_eq!(try_minimum([0.0, 1.0], 1e-3, |_| Err::<f64, _>("broken")), Err("broken"));
    }
}
