//! The coefficients of a closure from their keys.

use dashu_ratio::RBig;

use super::super::closure::{Closure, Weight};
use super::super::expression::{Expression, Rounding};
use super::coefficients::{fault, one, rounding};
use super::document::Document;
use super::error::Fault;

const HINT: &str = "a closure α p₀ + β p₁ = 0 has `alpha` and `beta`, functions of z = h·rate where there is a `rate`";

pub(super) fn read(document: &mut Document, digits: Option<u32>) -> Result<(Closure, Rounding), Fault> {
    let mut get = |key: &'static str| one(document.scalar(key)?.ok_or_else(|| document.missing(key, HINT))?);
    let parsed = [get("alpha")?, get("beta")?];
    let rounding = rounding(digits, parsed.iter());
    let rate = match document.scalar("rate")? {
        None => None,
        Some(scalar) => match scalar.text.parse::<f64>() {
            Ok(rate) if rate > 0.0 && rate.is_finite() => Some(rate),
            _ => return Err(Fault::new(scalar.at, format!("`rate` is a positive number, not `{}`", scalar.text))),
        },
    };
    let weight = |(scalar, expression): &(super::document::Scalar, Expression)| {
        if expression.is_function() && rate.is_none() {
            return Err(Fault::new(scalar.at, "a function of z needs a `rate`: z = h·rate").hint(HINT));
        }
        // At z = 1 as anywhere else; where it is singular, the step says so.
        expression.at(&RBig::ONE).evaluate(rounding).map_err(|malformed| fault(scalar, malformed))?;
        Ok(Weight { text: scalar.text.trim().to_owned(), expression: expression.clone() })
    };
    let [alpha, beta] = [weight(&parsed[0])?, weight(&parsed[1])?];
    let closure = Closure { alpha, beta, rate, rounding };
    if !closure.is_function() && closure.at(&RBig::ZERO).is_some_and(|(a, b)| a.may_be_zero() && b.may_be_zero()) {
        return Err(Fault::new(parsed[0].0.at, "`alpha` and `beta` are both zero").hint(HINT));
    }
    Ok((closure, rounding))
}

#[cfg(test)]
mod tests {
    use super::super::MethodFile;

    #[test]
    fn a_rate_is_positive() {
        for (rate, is_read) in [("2", true), ("0", false), ("-1", false), ("inf", false)] {
            let text = format!("kind = 'closure'\nalpha = 'z'\nbeta = '1'\nrate = '{rate}'\n");
            assert_eq!(MethodFile::parse("m.toml", "m", &text).is_ok(), is_read, "{rate}");
        }
    }
}
