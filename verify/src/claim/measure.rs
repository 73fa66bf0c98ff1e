//! What claims write.

use crate::evidence::number;

/// What a case says in place of a number if it says nothing else.
pub(super) const NO_SOLUTION: &str = "no solution";

/// A number for a sentence: three significant digits, four from 1 to 2.
pub(super) fn text(x: f64) -> String {
    if x == f64::INFINITY {
        return NO_SOLUTION.into();
    }
    number::digits(x, digits(x))
}

fn digits(x: f64) -> usize {
    if (1.0..2.0).contains(&x.abs()) { 4 } else { 3 }
}

/// A number of which a sentence says that others are at most as large: rounded up.
pub(super) fn at_most(x: f64) -> String {
    text(number::rounded_up(x, digits(x)))
}

/// One of which a sentence says that others are at least as large: rounded down.
pub(super) fn at_least(x: f64) -> String {
    text(number::rounded_down(x, digits(x)))
}

/// Numbers from the least to the most, rounded so that all lies between the two said; one where both are the same to the nearest.
pub(super) fn range(least: f64, most: f64) -> String {
    let nearest = text(least);
    if nearest == text(most) { nearest } else { format!("{} to {}", at_least(least), at_most(most)) }
}

/// A number near 1, to `rounding`: by how much it is above or below, which three digits of it would not say.
pub(super) fn beside_one(x: f64, rounding: f64) -> String {
    match x - 1.0 {
        off if off.abs() <= rounding => "1 to rounding".into(),
        off if off.abs() < 0.01 => format!("1 {} {}", if off < 0.0 { '−' } else { '+' }, text(off.abs())),
        _ => text(x),
    }
}

/// The sizes in some intervals, of all between two that were looked at: `h < 0.6090`. What is said of an end is within the interval.
pub(super) fn sizes(symbol: &str, found: &[[f64; 2]], [low, high]: [f64; 2]) -> String {
    let above = |x: f64| number::short(number::rounded_up(x, 4));
    let below = |x: f64| number::short(number::rounded_down(x, 4));
    let part = |&[from, to]: &[f64; 2]| match (from == low, to == high) {
        (true, true) => format!("{symbol} from {low} to {high}"),
        (true, false) => format!("{symbol} < {}", below(to)),
        (false, true) => format!("{symbol} > {}", above(from)),
        (false, false) => format!("{} < {symbol} < {}", above(from), below(to)),
    };
    if found.is_empty() { format!("no {symbol}") } else { found.iter().map(part).collect::<Vec<_>>().join(" and ") }
}

/// Whether a size lies in one of some intervals.
pub(super) fn is_within(found: &[[f64; 2]], size: f64) -> bool {
    found.iter().any(|[from, to]| (*from..=*to).contains(&size))
}

/// The sizes that lie in one of the intervals here and in one of those there.
pub(super) fn common(here: &[[f64; 2]], there: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let of = |a: &[f64; 2], b: &[f64; 2]| [a[0].max(b[0]), a[1].min(b[1])];
    here.iter().flat_map(|a| there.iter().map(|b| of(a, b))).filter(|[from, to]| from < to).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_said_within_their_intervals() {
        let said = |found: &[[f64; 2]]| sizes("h", found, [0.001, 10.0]);
        assert_eq!(said(&[[0.001, 10.0]]), "h from 0.001 to 10");
        assert_eq!(said(&[[0.001, 0.609_19]]), "h < 0.6091");
        assert_eq!(said(&[[1.517_23, 10.0]]), "h > 1.518");
        assert_eq!(said(&[[0.001, 0.5], [1.761_81, 2.585_69]]), "h < 0.5 and 1.762 < h < 2.585");
        assert_eq!(said(&[]), "no h");
    }

    #[test]
    fn a_range_holds_what_lies_between_its_ends() {
        assert_eq!(range(3.2141, 4.4561), "3.21 to 4.46");
        assert_eq!(range(3.2161, 4.4521), "3.21 to 4.46");
        assert_eq!(range(-0.8424, -0.1948), "−0.843 to −0.194");
        assert_eq!(range(0.2499, 0.2502), "0.250");
        assert_eq!([at_most(1.104e-16), at_least(0.01137), at_most(0.0)], ["1.11×10⁻¹⁶", "0.0113", "0"]);
    }

    #[test]
    fn sizes_in_common_lie_in_both() {
        assert_eq!(common(&[[0.0, 2.0], [3.0, 5.0]], &[[1.0, 4.0]]), [[1.0, 2.0], [3.0, 4.0]]);
        assert!(common(&[[0.0, 1.0]], &[[2.0, 3.0]]).is_empty());
        assert!(is_within(&[[0.0, 1.0], [2.0, 3.0]], 2.5) && !is_within(&[[0.0, 1.0], [2.0, 3.0]], 1.5));
    }

    #[test]
    fn a_number_near_one_says_on_which_side() {
        let said = |x| beside_one(x, 1e-10);
        assert_eq!([1.0, 1.0 - 1e-11].map(said), ["1 to rounding"; 2]);
        assert_eq!(said(1.0 - 2.0_f64.powi(-10)), format!("1 − {}", text(2.0_f64.powi(-10))));
        assert_eq!(said(1.0 + 2.0_f64.powi(-10)), format!("1 + {}", text(2.0_f64.powi(-10))));
        assert_eq!([0.9, 1.5].map(said), [0.9, 1.5].map(text));
        assert!(!said(f64::NAN).contains("rounding"));
    }
}
