//! The tableau of a Runge–Kutta method from its keys.

use super::super::expression::Rounding;
use super::super::tableau::Tableau;
use super::coefficients::{list, matrix, required, rounding, square, values};
use super::document::Document;
use super::error::Fault;

const HINT: &str = "a Runge–Kutta method has `a` (rows), `b`, and mostly `c`";

pub(super) fn read(document: &mut Document, digits: Option<u32>) -> Result<(Tableau, Rounding), Fault> {
    // Where two lists agree, the third is the wrong one.
    let [in_a, in_b, in_c] = ["a", "b", "c"].map(|key| document.length(key));
    if let (Some(rows), Some(weights), Some(nodes), Some(at)) = (in_a, in_b, in_c, document.at("b"))
        && weights != nodes
        && rows == nodes
    {
        let reason = format!("`b` has {weights} entries where `a` has {rows} rows and `c` has {nodes} entries");
        return Err(Fault::new(at, reason).hint("one weight for each stage"));
    }
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
