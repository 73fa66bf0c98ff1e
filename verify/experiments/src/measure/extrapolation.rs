//! Limits as a step goes to zero.

/// A number and a bound on its error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounded {
    /// The number.
    pub value: f64,
    /// The bound.
    pub bound: f64,
}

/// The limit for h → 0 of what is even in h, from its values at falling steps, each with a bound on its rounding: the polynomials in h² through some
/// steps that follow each other, by Neville's recursion. Of all of them the one with the least bound, which is the larger of its distances from the two of
/// one step less and the roundings that it carries. NaN for fewer than two steps.
pub fn even_limit(steps: &[(f64, Bounded)]) -> Bounded {
    let mut best = Bounded { value: f64::NAN, bound: f64::INFINITY };
    let mut row: Vec<Bounded> = Vec::new();
    for (i, (h, value)) in steps.iter().enumerate() {
        let mut next = vec![*value];
        for (before, (longer, _)) in row.iter().zip(steps[..i].iter().rev()) {
            let (here, ratio) = (next[next.len() - 1], (longer / h).powi(2));
            let value = here.value + (here.value - before.value) / (ratio - 1.0);
            let rounding = (ratio * here.bound + before.bound) / (ratio - 1.0);
            let bound = (value - here.value).abs().max((value - before.value).abs()) + rounding;
            if bound < best.bound {
                best = Bounded { value, bound };
            }
            next.push(Bounded { value, bound: rounding });
        }
        row = next;
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limit(f: impl Fn(f64) -> f64, rounding: f64, count: i32) -> Bounded {
        let at = |k: i32| {
            let h = 0.8_f64.powi(k);
            (h, Bounded { value: f(h), bound: rounding })
        };
        even_limit(&(0..count).map(at).collect::<Vec<_>>())
    }

    #[test]
    fn a_polynomial_in_h_squared_is_gone_with_as_many_columns() {
        let found = limit(|h| 2.0 - h.powi(2) + 0.5 * h.powi(4), 1e-15, 4);
        assert!((found.value - 2.0).abs() <= found.bound && found.bound < 1.0, "{found:?}");
        let found = limit(|h| 2.0 - h.powi(2) + 0.5 * h.powi(4), 1e-15, 6);
        assert!((found.value - 2.0).abs() <= found.bound && found.bound < 1e-12, "{found:?}");
    }

    /// 1, 1/2, 1/3 and so on.
    #[test]
    fn steps_need_no_common_ratio() {
        let at = |k: i32| {
            let h = f64::from(k).recip();
            (h, Bounded { value: 2.0 - h.powi(2) + 0.5 * h.powi(4), bound: 1e-15 })
        };
        let found = even_limit(&(1..=6).map(at).collect::<Vec<_>>());
        assert!((found.value - 2.0).abs() <= found.bound && found.bound < 1e-12, "{found:?}");
    }

    #[test]
    fn the_bound_covers_what_is_left_and_what_rounding_does() {
        let found = limit(|h| h.cosh(), 1e-15, 12);
        assert!((found.value - 1.0).abs() <= found.bound && found.bound < 1e-10, "{found:?}");
        // The sign of the noise alternates, as the weights of the extrapolation do.
        let noisy =
            limit(|h| h.cosh() + 1e-6 * if (h.log(0.8).round() as i32) % 2 == 0 { 1.0 } else { -1.0 }, 1e-6, 12);
        assert!((noisy.value - 1.0).abs() <= noisy.bound && noisy.bound < 1e-3, "{noisy:?}");
        assert!(even_limit(&[]).value.is_nan() && limit(|h| h, 0.0, 1).value.is_nan());
    }
}
