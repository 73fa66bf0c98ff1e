//! The tableau of a Runge–Kutta method from its keys.

use super::super::expression::Rounding;
use super::super::tableau::Tableau;
use super::coefficients::{list, matrix, required, rounding, square, values};
use super::document::Document;
use super::error::Fault;

const HINT: &str = "a Runge–Kutta method has `a` (rows), `b`, and mostly `c`";

pub(super) fn read(document: &mut Document, digits: Option<u32>) -> Result<(Tableau, Rounding), Fault> {
    let b = required(document, "b", None, HINT)?;
    let s = b.len();
    let a = matrix(document, "a", s, HINT)?;
    let c = list(document, "c", Some(s))?;
    let b_hat = list(document, "b_hat", Some(s))?;
    let all = || a.iter().flatten().chain(&b).chain(c.iter().flatten()).chain(b_hat.iter().flatten());
    let rounding = rounding(digits, all());
    let mut radicands = Vec::new();
    all().for_each(|(_, expression)| expression.radicands(&mut radicands));
    radicands.sort_unstable();
    radicands.dedup();
    let tableau = Tableau {
        a: square(&a, rounding)?,
        b: values(&b, rounding)?,
        c: c.map(|c| values(&c, rounding)).transpose()?,
        b_hat: b_hat.map(|b| values(&b, rounding)).transpose()?,
        radicands,
    };
    Ok((tableau, rounding))
}
