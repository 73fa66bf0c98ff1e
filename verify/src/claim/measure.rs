//! What claims write.

use crate::evidence::number;

/// What a case says in place of a number if it says nothing else.
pub(super) const NO_SOLUTION: &str = "no solution";

/// A number for a sentence: three significant digits, four from 1 to 2.
pub(super) fn text(x: f64) -> String {
    if x == f64::INFINITY {
        return NO_SOLUTION.into();
    }
    let digits = if (1.0..2.0).contains(&x.abs()) { 4 } else { 3 };
    number::Short::new(x, digits).text()
}

/// A number near 1, to `rounding`: by how much it is above or below, which three digits of it would not say.
pub(super) fn beside_one(x: f64, rounding: f64) -> String {
    match x - 1.0 {
        off if off.abs() <= rounding => "1 to rounding".into(),
        off if off.abs() < 0.01 => format!("1 {} {}", if off < 0.0 { '−' } else { '+' }, text(off.abs())),
        _ => text(x),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
