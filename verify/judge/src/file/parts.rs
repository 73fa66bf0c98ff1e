//! The coefficients of methods with two parts from their keys: `partitioned-runge-kutta` and `nystrom`.

use super::super::expression::Rounding;
use super::super::parts::{Coupling, Parts};
use super::super::tableau::Coefficient;
use super::coefficients::{list, matrix, required, rounding, square, values};
use super::document::Document;
use super::error::Fault;

const PARTITIONED: &str = "a partitioned method has `a` and `b` for q̇, `a_hat` and `b_hat` for ṗ, and maybe `c`";

pub(super) fn partitioned(document: &mut Document, digits: Option<u32>) -> Result<(Parts, Rounding), Fault> {
    let b = required(document, "b", None, PARTITIONED)?;
    let s = b.len();
    let a = matrix(document, "a", s, PARTITIONED)?;
    let a_hat = matrix(document, "a_hat", s, PARTITIONED)?;
    let b_hat = required(document, "b_hat", Some(s), PARTITIONED)?;
    let c = list(document, "c", Some(s))?;
    let coupling = match document.scalar("systems")? {
        None => Coupling::General,
        Some(scalar) if scalar.text == "separable" => Coupling::Separable,
        Some(scalar) if scalar.text == "all" => Coupling::General,
        Some(scalar) => {
            let reason = format!("`systems` is \"all\" or \"separable\", not `{}`", scalar.text);
            return Err(Fault::new(scalar.at, reason));
        }
    };
    let all = a.iter().chain(&a_hat).flatten().chain(&b).chain(&b_hat).chain(c.iter().flatten());
    let rounding = rounding(digits, all);
    let parts = Parts {
        coupling,
        a: [square(&a, rounding)?, square(&a_hat, rounding)?],
        b: [values(&b, rounding)?, values(&b_hat, rounding)?],
        c: c.map(|c| values(&c, rounding)).transpose()?,
    };
    Ok((parts, rounding))
}

const NYSTROM: &str = "a Nyström method has `a` (rows), `b_bar` for q, `b` for q̇, and `c`";

pub(super) fn nystrom(document: &mut Document, digits: Option<u32>) -> Result<(Parts, Rounding), Fault> {
    let b = required(document, "b", None, NYSTROM)?;
    let s = b.len();
    let a = matrix(document, "a", s, NYSTROM)?;
    let b_bar = required(document, "b_bar", Some(s), NYSTROM)?;
    let c = required(document, "c", Some(s), NYSTROM)?;
    let rounding = rounding(digits, a.iter().flatten().chain(&b).chain(&b_bar).chain(&c));
    // What carries an acceleration to itself.
    let identity = |i: usize| (0..s).map(|j| if i == j { Coefficient::one() } else { Coefficient::zero() }).collect();
    let parts = Parts {
        coupling: Coupling::SecondOrder,
        a: [square(&a, rounding)?, (0..s).map(identity).collect()],
        b: [values(&b_bar, rounding)?, values(&b, rounding)?],
        c: Some(values(&c, rounding)?),
    };
    Ok((parts, rounding))
}
