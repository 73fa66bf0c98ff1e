//! What is required of a number, kept as numbers.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::number;

/// What is required of a number. NaN meets none of these, and no number meets one whose bound is NaN.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, speedy::Readable, speedy::Writable)]
#[serde(rename_all = "kebab-case")]
pub enum Requirement {
    /// x ≤ bound.
    AtMost(f64),
    /// x ≥ bound.
    AtLeast(f64),
    /// x < bound.
    Below(f64),
    /// x > bound.
    Above(f64),
    /// low ≤ x ≤ high.
    Within(f64, f64),
    /// |x − value| ≤ tolerance, as of an order of convergence and its band.
    Near(f64, f64),
}

impl Requirement {
    /// Whether `x` meets it.
    pub fn is_met_by(self, x: f64) -> bool {
        // Comparisons that hold, never negated ones that do not: those let NaN pass.
        match self {
            Self::AtMost(bound) => x <= bound,
            Self::AtLeast(bound) => x >= bound,
            Self::Below(bound) => x < bound,
            Self::Above(bound) => x > bound,
            Self::Within(low, high) => low <= x && x <= high,
            Self::Near(value, tolerance) => (x - value).abs() <= tolerance,
        }
    }

    /// Its one or two numbers.
    pub fn bounds(self) -> impl Iterator<Item = f64> {
        let (first, second) = match self {
            Self::AtMost(bound) | Self::AtLeast(bound) | Self::Below(bound) | Self::Above(bound) => (bound, None),
            Self::Within(low, high) => (low, Some(high)),
            Self::Near(value, tolerance) => (value, Some(tolerance)),
        };
        [Some(first), second].into_iter().flatten()
    }

    /// Whether some number fails it and some meets it: not so where a bound is infinite or NaN, or an interval empty.
    pub fn can_fail(self) -> bool {
        self.bounds().all(f64::is_finite)
            && match self {
                Self::Within(low, high) => low <= high,
                Self::Near(_, tolerance) => tolerance >= 0.0,
                _ => true,
            }
    }

    /// The scale on which a change of the measured number matters: the size of the bound, or half of the interval's width.
    pub fn scale(self) -> f64 {
        match self {
            Self::AtMost(bound) | Self::AtLeast(bound) | Self::Below(bound) | Self::Above(bound) => bound.abs(),
            Self::Within(low, high) => 0.5 * (high - low),
            Self::Near(_, tolerance) => tolerance,
        }
    }
}

impl fmt::Display for Requirement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = number::bound;
        match *self {
            Self::AtMost(bound) => write!(f, "≤ {}", text(bound)),
            Self::AtLeast(bound) => write!(f, "≥ {}", text(bound)),
            Self::Below(bound) => write!(f, "< {}", text(bound)),
            Self::Above(bound) => write!(f, "> {}", text(bound)),
            Self::Within(low, high) => write!(f, "from {} to {}", text(low), text(high)),
            Self::Near(value, tolerance) => write!(f, "{} ± {}", text(value), text(tolerance)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Requirement::*;

    const EVERY_KIND: [Requirement; 6] =
        [AtMost(1.0), AtLeast(1.0), Below(1.0), Above(1.0), Within(0.0, 2.0), Near(1.0, 1.0)];

    #[test]
    fn a_number_that_is_none_meets_no_requirement() {
        for required in EVERY_KIND {
            assert!(!required.is_met_by(f64::NAN), "{required}");
        }
    }

    #[test]
    fn no_number_meets_a_bound_that_is_not_a_number() {
        let nan = f64::NAN;
        for required in [AtMost(nan), AtLeast(nan), Below(nan), Above(nan), Within(nan, 2.0), Within(0.0, nan)] {
            assert!(!required.is_met_by(1.0) && !required.can_fail(), "{required}");
        }
        for required in [Near(nan, 1.0), Near(1.0, nan)] {
            assert!(!required.is_met_by(1.0) && !required.can_fail(), "{required}");
        }
    }

    #[test]
    fn bounds_belong_to_closed_requirements_alone() {
        for (required, below, at, above) in [
            (AtMost(1.0), true, true, false),
            (AtLeast(1.0), false, true, true),
            (Below(1.0), true, false, false),
            (Above(1.0), false, false, true),
            (Within(1.0, 1.0), false, true, false),
            (Near(1.0, 0.0), false, true, false),
        ] {
            let met = [0.5, 1.0, 1.5].map(|x| required.is_met_by(x));
            assert_eq!(met, [below, at, above], "{required}");
            assert!(required.can_fail());
        }
        assert!(Within(1.0, 2.0).is_met_by(2.0) && !Within(1.0, 2.0).is_met_by(2.1) && !Near(1.0, 0.1).is_met_by(0.8));
    }

    #[test]
    fn changes_are_measured_by_the_bound_or_by_half_of_the_width() {
        let kinds = [AtMost(-3.0), AtLeast(3.0), Below(3.0), Above(-3.0), Within(1.0, 4.0), Near(2.0, 0.1)];
        assert_eq!(kinds.map(Requirement::scale), [3.0, 3.0, 3.0, 3.0, 1.5, 0.1]);
    }

    /// Whatever the text of a bound rounds away, the comparison does not.
    #[test]
    fn a_number_a_little_beyond_one_is_beyond_one() {
        for excess in [5e-4, 1e-7, f64::EPSILON] {
            assert!(!AtMost(1.0).is_met_by(1.0 + excess) && AtMost(1.0 + excess).is_met_by(1.0 + excess));
            assert!(AtMost(1.0 + excess).to_string() != "≤ 1", "{excess}");
        }
    }

    #[test]
    fn what_every_number_meets_is_no_requirement() {
        for required in [AtMost(f64::INFINITY), Within(0.0, f64::INFINITY), Within(2.0, 1.0), Near(1.0, -1.0)] {
            assert!(!required.can_fail(), "{required}");
        }
    }

    #[test]
    fn requirements_read_as_a_person_would_write_them() {
        let cases = [
            (AtMost(1.0), "≤ 1"),
            (AtMost(1.0 + 1e-7), "≤ 1 + 10⁻⁷"),
            (AtLeast(1e6), "≥ 10⁶"),
            (Below(0.05), "< 0.05"),
            (Above(0.0), "> 0"),
            (Within(0.1, 100.0), "from 0.1 to 100"),
            (Near(2.0, 0.05), "2 ± 0.05"),
            (AtMost(3.141_592e-15), "≤ 3.142×10⁻¹⁵"),
        ];
        for (required, text) in cases {
            assert_eq!(required.to_string(), text);
        }
    }

    #[test]
    fn requirements_survive_a_file() {
        for required in EVERY_KIND {
            let text = serde_json::to_string(&required).expect("numbers");
            assert_eq!(serde_json::from_str::<Requirement>(&text).expect("the same"), required, "{text}");
        }
        assert_eq!(serde_json::to_string(&Near(2.0, 0.05)).expect("numbers"), r#"{"near":[2.0,0.05]}"#);
    }

    #[test]
    fn a_change_matters_beside_the_bound_or_what_is_allowed_around_a_value() {
        let cases = [(AtMost(-2.0), 2.0), (Above(0.5), 0.5), (Within(1.0, 5.0), 2.0), (Near(4.0, 0.05), 0.05)];
        for (required, scale) in cases {
            assert_eq!(required.scale(), scale, "{required}");
        }
    }

    /// Without a feature of `serde_json` some come back as the next double.
    #[test]
    fn a_bound_is_read_to_the_last_bit() {
        for k in 1..=1000 {
            let required = Requirement::AtMost(1.88e-9 * f64::from(k).sqrt());
            let text = serde_json::to_string(&required).expect("no error");
            assert_eq!(serde_json::from_str::<Requirement>(&text).expect("the same"), required, "{text}");
        }
    }
}
