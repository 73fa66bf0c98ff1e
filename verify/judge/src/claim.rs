//! What a file claims of its method.

use std::fmt;

use evidence::Outcome;
use experiments::measure::decimal::plain;

/// The claims that can be judged, for a hint.
pub(super) const FORMS: &str = "claims are texts like \"order 4\", \"embedded order 3\", \"stage order 2\", \"explicit\", \"implicit\", \
     \"diagonally implicit\", \"A-stable\", \"A(88)-stable\", \"L-stable\", \"algebraically stable\", \"stiffly accurate\", \
     \"symplectic\", \"symmetric\", \"zero-stable\", \"dispersion order 4\", \"dissipation order 5\", \"stable on the imaginary axis to 2.8\"; \
     each with \"not\" before it denies";

/// A property that a method has or has not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Property {
    /// Order of the method.
    Order(u32),
    /// Order of the embedded method.
    EmbeddedOrder(u32),
    /// Order of the stages.
    StageOrder(u32),
    /// Zero on and above the diagonal of A.
    Explicit,
    /// Zero above the diagonal of A.
    DiagonallyImplicit,
    /// |R| ≤ 1 in the left half-plane.
    AStable,
    /// |R| ≤ 1 in a sector about the negative axis, of this half-angle in degrees; of 0, in some sector.
    AlphaStable(Printed),
    /// A-stable, and R(∞) = 0.
    LStable,
    /// b ≥ 0 and B A + Aᵀ B − b bᵀ ≥ 0.
    AlgebraicallyStable,
    /// The last row of A is b.
    StifflyAccurate,
    /// b_i a_ij + b_j a_ji = b_i b_j.
    Symplectic,
    /// Its own adjoint.
    Symmetric,
    /// Order of the phase error on oscillations.
    DispersionOrder(u32),
    /// Order of the amplitude error on oscillations.
    DissipationOrder(u32),
    /// |R(iy)| ≤ 1 for |y| up to this bound.
    ImaginaryInterval(Printed),
    /// Roots of ρ in the closed unit disc, those on its rim simple.
    ZeroStable,
}

/// A bound as a claim prints it, rounded to so many places after the point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Printed {
    /// The number.
    pub value: f64,
    /// Places after the point; `usize::MAX` where it is meant exactly.
    pub places: usize,
}

impl Printed {
    fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        let value = text.parse().ok()?;
        // What has an exponent is taken as exact.
        let places = text.split_once('.').map_or(0, |(_, fraction)| fraction.len());
        let places = if text.contains(['e', 'E']) { usize::MAX } else { places };
        Some(Self { value, places })
    }

    /// The least number that is rounded to it.
    fn least(self) -> f64 {
        match i32::try_from(self.places) {
            Ok(places) if self.value > 0.0 => self.value - 0.5 * 10_f64.powi(-places),
            _ => self.value,
        }
    }

    /// Whether what ends at `end`, to within `open`, reaches so far, and in words how the claim is taken where that matters.
    pub(super) fn is_reached(self, end: f64, open: f64) -> (Outcome, String) {
        let least = self.least();
        // What the number itself is uncertain by in double precision.
        let open = open + 4.0 * f64::EPSILON * end.abs();
        let outcome = match () {
            () if least <= end - open => Outcome::Pass,
            () if least > end + open => Outcome::Fail,
            () => Outcome::Inconclusive,
        };
        let words = match outcome {
            Outcome::Inconclusive => "; the digits given leave open whether that is enough".to_owned(),
            _ if self.value <= end || least == self.value => String::new(),
            _ => format!("; {self}, to the digits claimed, is {} at least", plain(least)),
        };
        (outcome, words)
    }
}

impl fmt::Display for Printed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.places {
            usize::MAX => write!(f, "{}", self.value),
            places => write!(f, "{:.places$}", self.value),
        }
    }
}

/// A property, claimed or denied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Claim {
    /// The property.
    pub property: Property,
    /// Whether the claim is that the method has it not.
    pub denied: bool,
}

impl Property {
    /// The same with its bound as a number and not as digits.
    pub(super) fn exact(self) -> Self {
        let exact = |bound: Printed| Printed { places: usize::MAX, ..bound };
        match self {
            Self::AlphaStable(angle) => Self::AlphaStable(exact(angle)),
            Self::ImaginaryInterval(y) => Self::ImaginaryInterval(exact(y)),
            other => other,
        }
    }
}

impl Claim {
    pub(super) fn order(p: u32) -> Self {
        Self { property: Property::Order(p), denied: false }
    }

    pub(super) fn embedded_order(p: u32) -> Self {
        Self { property: Property::EmbeddedOrder(p), denied: false }
    }

    /// The order, if that is what is claimed.
    pub fn as_order(&self) -> Option<u32> {
        match self {
            Self { property: Property::Order(p), denied: false } => Some(*p),
            _ => None,
        }
    }

    /// The order of the embedded method, if that is what is claimed.
    pub fn as_embedded_order(&self) -> Option<u32> {
        match self {
            Self { property: Property::EmbeddedOrder(p), denied: false } => Some(*p),
            _ => None,
        }
    }

    /// Reads a claim.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let words = text.trim().to_lowercase();
        let (denied, rest) = match words.strip_prefix("not ") {
            Some(rest) => (true, rest.trim()),
            None => (false, words.as_str()),
        };
        if rest == "implicit" {
            return Ok(Self { property: Property::Explicit, denied: !denied });
        }
        let property = property(rest).ok_or_else(|| format!("`{text}` is no claim that can be judged"))?;
        Ok(Self { property, denied })
    }
}

fn property(text: &str) -> Option<Property> {
    let numbered = |prefix: &str| text.strip_prefix(prefix)?.trim().parse::<u32>().ok().filter(|n| *n <= 20);
    let plain = [
        ("explicit", Property::Explicit),
        ("diagonally implicit", Property::DiagonallyImplicit),
        ("a-stable", Property::AStable),
        ("l-stable", Property::LStable),
        ("algebraically stable", Property::AlgebraicallyStable),
        ("stiffly accurate", Property::StifflyAccurate),
        ("symplectic", Property::Symplectic),
        ("symmetric", Property::Symmetric),
        ("zero-stable", Property::ZeroStable),
    ];
    if let Some((_, property)) = plain.into_iter().find(|(name, _)| *name == text) {
        return Some(property);
    }
    let orders = [
        ("order ", Property::Order as fn(u32) -> Property),
        ("embedded order ", Property::EmbeddedOrder),
        ("stage order ", Property::StageOrder),
        ("dispersion order ", Property::DispersionOrder),
        ("dissipation order ", Property::DissipationOrder),
    ];
    if let Some(property) = orders.into_iter().find_map(|(prefix, make)| numbered(prefix).map(make)) {
        return Some(property);
    }
    let number = |text: &str, most: f64| Printed::parse(text).filter(|x| x.value > 0.0 && x.value <= most);
    if let Some(angle) = text.strip_prefix("a(").and_then(|rest| rest.strip_suffix(")-stable")) {
        let angle = angle.trim_end_matches('°');
        // In some sector, however narrow.
        let narrow = || Printed::parse(angle).filter(|angle| angle.value == 0.0);
        return number(angle, 90.0).or_else(narrow).map(Property::AlphaStable);
    }
    number(text.strip_prefix("stable on the imaginary axis to ")?, 1e6).map(Property::ImaginaryInterval)
}

impl fmt::Display for Property {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Order(p) => write!(f, "order {p}"),
            Self::EmbeddedOrder(p) => write!(f, "embedded order {p}"),
            Self::StageOrder(q) => write!(f, "stage order {q}"),
            Self::Explicit => f.write_str("explicit"),
            Self::DiagonallyImplicit => f.write_str("diagonally implicit"),
            Self::AStable => f.write_str("A-stable"),
            Self::AlphaStable(angle) => write!(f, "A({angle}°)-stable"),
            Self::LStable => f.write_str("L-stable"),
            Self::AlgebraicallyStable => f.write_str("algebraically stable"),
            Self::StifflyAccurate => f.write_str("stiffly accurate"),
            Self::Symplectic => f.write_str("symplectic"),
            Self::Symmetric => f.write_str("symmetric"),
            Self::ZeroStable => f.write_str("zero-stable"),
            Self::DispersionOrder(p) => write!(f, "dispersion order {p}"),
            Self::DissipationOrder(p) => write!(f, "dissipation order {p}"),
            Self::ImaginaryInterval(y) => write!(f, "stable on the imaginary axis to {y}"),
        }
    }
}

impl fmt::Display for Claim {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", if self.denied { "not " } else { "" }, self.property)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// √8 is 2.828427…: what rounds to more than that is too much, and what rounds to less is not.
    #[test]
    fn a_bound_is_claimed_to_the_digits_that_it_prints() {
        let reached = |text: &str, open: f64| Printed::parse(text).expect(text).is_reached(8_f64.sqrt(), open).0;
        for text in ["2", "2.8", "2.83", "2.828", "2.8284", "2.82843"] {
            assert_eq!(reached(text, 0.0), Outcome::Pass, "{text}");
        }
        for text in ["2.829", "2.8285", "2.82844", "2.9", "3.5"] {
            assert_eq!(reached(text, 0.0), Outcome::Fail, "{text}");
        }
        assert_eq!([reached("2.829", 0.01), reached("2.84", 0.01)], [Outcome::Inconclusive; 2]);
        // Meant exactly, and a unit of the last place away.
        assert_eq!(
            [reached("2.8284271247461916e0", 0.0), reached("2.828427124746e0", 0.0)],
            [Outcome::Inconclusive, Outcome::Pass]
        );
        assert_eq!(reached("2.82842712475e0", 0.0), Outcome::Fail);
        let of = |text: &str, end: f64, open: f64| Printed::parse(text).expect(text).is_reached(end, open);
        assert!(of("2.829", 8.0_f64.sqrt(), 0.01).1.contains("leave open whether that is enough"));
        assert_eq!(of("2.8", 8.0_f64.sqrt(), 0.0).1, "");
        assert_eq!(of("2.83", 8.0_f64.sqrt(), 0.0).1, "; 2.83, to the digits claimed, is 2.825 at least");
        // What is not above zero is not rounded up.
        assert_eq!([of("-0.5", -0.52, 0.0).0, of("0.0", -0.02, 0.0).0], [Outcome::Fail; 2]);
        assert_eq!(Printed::parse("2.80").expect("a number").to_string(), "2.80");
    }

    #[test]
    fn every_bound_can_be_meant_exactly() {
        for (text, digits) in [("A(45.5)-stable", 1), ("stable on the imaginary axis to 2.83", 2)] {
            let places = |property| match property {
                Property::AlphaStable(bound) | Property::ImaginaryInterval(bound) => bound.places,
                other => panic!("{other:?}"),
            };
            let property = || Claim::parse(text).expect(text).property;
            assert_eq!([places(property()), places(property().exact())], [digits, usize::MAX], "{text}");
        }
    }

    #[test]
    fn a_bound_is_positive_and_no_larger_than_makes_sense() {
        let is_claim = |text: &str| Claim::parse(text).is_ok();
        for text in ["A(0)-stable", "A(90)-stable", "stable on the imaginary axis to 2.8"] {
            assert!(is_claim(text), "{text}");
        }
        for text in ["A(91)-stable", "A(-1)-stable"] {
            assert!(!is_claim(text), "{text}");
        }
        for bound in ["0", "-1", "2e6"] {
            assert!(!is_claim(&format!("stable on the imaginary axis to {bound}")), "{bound}");
        }
    }
}
