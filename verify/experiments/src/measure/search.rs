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

/// The intervals in which `holds` does, as far as it is seen at `points`, which ascend: an end between two of them by bisection, and an
/// interval that lies between two of them not at all.
///
/// # Errors
/// The first error of `holds`.
pub fn try_intervals<E>(points: &[f64], mut holds: impl FnMut(f64) -> Result<bool, E>) -> Result<Vec<[f64; 2]>, E> {
    let (mut found, mut before): (Vec<[f64; 2]>, Option<(f64, bool)>) = (Vec::new(), None);
    for &point in points {
        let here = holds(point)?;
        let mut change = point;
        if let Some((last, was)) = before
            && was != here
        {
            let sign = |x| Ok(if holds(x)? { 1.0 } else { -1.0 });
            change = try_root([last, point], sign)?.unwrap_or(point);
        }
        match found.last_mut() {
            Some(open) if before.is_some_and(|(_, was)| was) => open[1] = if here { point } else { change },
            _ if here => found.push([change, point]),
            _ => {}
        }
        before = Some((point, here));
    }
    Ok(found)
}

/// Points from `low` to `high`, both among them, so many of them in each decade at least.
pub fn logarithmic([low, high]: [f64; 2], per_decade: u32) -> Vec<f64> {
    let count = ((high / low).log10() * f64::from(per_decade)).ceil().max(1.0) as u32;
    let between = (1..count).map(|k| low * (high / low).powf(f64::from(k) / f64::from(count)));
    [low].into_iter().chain(between).chain([high]).collect()
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

    #[test]
    fn intervals_begin_and_end_where_what_holds_changes() {
        let of = |holds: fn(f64) -> bool| {
            try_intervals(&[0.0, 1.0, 2.0, 3.0, 4.0], |x| Ok::<_, Infallible>(holds(x))).expect("infallible")
        };
        let is = |found: Vec<[f64; 2]>, known: &[[f64; 2]]| {
            let ends = found.iter().flatten().zip(known.iter().flatten());
            assert!(found.len() == known.len() && ends.clone().all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        };
        is(of(|_| true), &[[0.0, 4.0]]);
        is(of(|_| false), &[]);
        is(of(|x| x < 2.3), &[[0.0, 2.3]]);
        is(of(|x| x > 2.3), &[[2.3, 4.0]]);
        is(of(|x| x < 0.7 || (1.6..2.4).contains(&x) || x > 3.9), &[[0.0, 0.7], [1.6, 2.4], [3.9, 4.0]]);
        // What lies between two points is not seen.
        is(of(|x| (1.2..1.8).contains(&x)), &[]);
        assert_eq!(try_intervals(&[0.0, 1.0], |x| if x > 0.0 { Err("broken") } else { Ok(true) }), Err("broken"));
    }

    #[test]
    fn logarithmic_points_have_both_ends() {
        let points = logarithmic([1e-3, 0.5], 10);
        assert!(points[0] == 1e-3 && points[points.len() - 1] == 0.5 && points.is_sorted());
        assert!(points.windows(2).all(|pair| (pair[1] / pair[0]).log10() <= 0.1 + 1e-12));
        assert_eq!(logarithmic([2.0, 2.0], 10), [2.0, 2.0]);
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
