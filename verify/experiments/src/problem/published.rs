//! End values that others have published, and how many of their digits stand.

use super::tabulated;

const TABLE: &str = include_str!("../../../data/published.csv");

/// A component of a solution as it was printed.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
pub struct Published {
    /// The problem, and parameters that are not the defaults: `van-der-pol mu=1000`.
    pub problem: String,
    /// The time.
    pub t: f64,
    /// Which component, from 0.
    pub component: usize,
    /// The value, digit by digit.
    pub printed: String,
    /// Where it was printed.
    pub source: String,
}

/// All of them.
///
/// # Errors
/// [`csv::Error`] if the table is malformed.
pub fn published() -> Result<Vec<Published>, csv::Error> {
    csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(TABLE.as_bytes()).deserialize().collect()
}

impl Published {
    /// Significant digits printed.
    pub fn printed_digits(&self) -> usize {
        let mantissa = self.printed.split(['e', 'E']).next().unwrap_or_default();
        mantissa.trim_start_matches(['-', '0', '.']).chars().filter(char::is_ascii_digit).count()
    }

    /// Digits in which the printed value agrees with the solution tabulated here, −log₁₀ of the relative difference; at most
    /// as many as were printed, or as a double has. `None` where nothing is tabulated.
    pub fn confirmed_digits(&self) -> Option<f64> {
        let computed = *tabulated::lookup(&self.problem, self.t)?.get(self.component)?;
        let difference = ((self.printed.parse::<f64>().ok()? - computed) / computed).abs();
        let most = (self.printed_digits() as f64).min(-f64::EPSILON.log10());
        Some(-difference.max(10_f64.powf(-most)).log10())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At least nine digits of each stand, as many as any solver here is asked for, and all are tabulated.
    #[test]
    fn published_values_are_those_tabulated() {
        let all = published().expect("well-formed");
        assert!(all.len() >= 46);
        for value in &all {
            let digits = value.confirmed_digits();
            assert!(digits.is_some_and(|digits| digits >= 9.0), "{value:?}: {digits:?}");
            assert!(super::super::build_setting(&value.problem).is_ok());
        }
    }

    #[test]
    fn digits_are_counted() {
        let value = |printed: &str| Published {
            problem: "van-der-pol".into(),
            t: 0.5,
            component: 0, // 1.837719208244123…
            printed: printed.into(),
            source: String::new(),
        };
        assert_eq!(value("-0.0012340e-3").printed_digits(), 5);
        assert_eq!(value("1.8377192").confirmed_digits(), Some(8.0));
        assert!((value("1.8377292").confirmed_digits().expect("tabulated") - 5.264).abs() < 1e-3);
    }
}
