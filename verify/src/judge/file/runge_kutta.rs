//! The tableau of a Runge–Kutta method from its keys.

use super::super::expression::{Expression, Malformed, Rounding};
use super::super::tableau::{Coefficient, Tableau};
use super::document::{Document, Scalar, Value, scalars};
use super::error::Fault;

/// Most stages; the methods of order 14 have 35.
const MAX_STAGES: usize = 40;

type Parsed = (Scalar, Expression);

pub(super) fn read(document: &mut Document, digits: Option<u32>) -> Result<(Tableau, Rounding), Fault> {
    let b = parse(required(document, "b")?)?;
    let s = b.len();
    let a_value = document.take("a").ok_or_else(|| missing("a"))?;
    if s == 0 || s > MAX_STAGES {
        return Err(Fault::new(a_value.at(), format!("`b` has {s} weights; there are 1 to {MAX_STAGES} stages")));
    }
    let a = rows(a_value, s)?;
    let fitting = |key: &'static str, document: &mut Document| -> Result<Option<Vec<Parsed>>, Fault> {
        let at = |list: &[Scalar]| list.first().map_or(0, |first| first.at);
        match document.list(key)? {
            Some(list) if list.len() != s => {
                let reason = format!("`{key}` has {} entries where `b` has {s}", list.len());
                Err(Fault::new(at(&list), reason))
            }
            Some(list) => parse(list).map(Some),
            None => Ok(None),
        }
    };
    let c = fitting("c", document)?;
    let b_hat = fitting("b_hat", document)?;
    let all = || a.iter().flatten().chain(&b).chain(c.iter().flatten()).chain(b_hat.iter().flatten());
    let rounding = Rounding::new(digits, all().filter_map(|(_, expression)| expression.places()).max());
    let mut radicands = Vec::new();
    all().for_each(|(_, expression)| expression.radicands(&mut radicands));
    radicands.sort_unstable();
    radicands.dedup();
    let evaluate =
        |list: &[Parsed]| list.iter().map(|parsed| coefficient(parsed, rounding)).collect::<Result<Vec<_>, _>>();
    let mut tableau = Tableau {
        a: a.iter().map(|row| evaluate(row)).collect::<Result<_, _>>()?,
        b: evaluate(&b)?,
        c: c.as_deref().map(evaluate).transpose()?,
        b_hat: b_hat.as_deref().map(evaluate).transpose()?,
        radicands,
    };
    tableau.a.iter_mut().for_each(|row| row.resize_with(s, Coefficient::zero));
    Ok((tableau, rounding))
}

fn missing(key: &str) -> Fault {
    Fault::new(0, format!("`{key}` is missing")).hint("a Runge–Kutta method has `a` (rows), `b`, and mostly `c`")
}

fn required(document: &mut Document, key: &'static str) -> Result<Vec<Scalar>, Fault> {
    document.list(key)?.ok_or_else(|| missing(key))
}

/// The rows of A: all of s entries, or lower triangles without or with their diagonal, a row of no entries left out.
fn rows(value: Value, s: usize) -> Result<Vec<Vec<Parsed>>, Fault> {
    let at = value.at();
    let Value::List { items, .. } = value else {
        return Err(Fault::new(at, "`a` is a list of rows: [[], [\"1/2\"]]"));
    };
    let mut rows = Vec::new();
    for item in items {
        let at = item.at();
        rows.push((at, parse(scalars("a", item)?)?));
    }
    if rows.len() + 1 == s
        && rows.first().is_some_and(|(_, row)| row.len() == 1)
        && rows.last().is_some_and(|(_, row)| row.len() + 1 == s)
    {
        rows.insert(0, (at, Vec::new()));
    }
    if rows.len() != s {
        return Err(Fault::new(at, format!("`a` has {} rows where `b` has {s} weights", rows.len())));
    }
    for (i, (at, row)) in rows.iter().enumerate() {
        let fits = row.len() == s || row.len() == i || row.len() == i + 1;
        if !fits {
            let reason = format!("row {} of `a` has {} entries", i + 1, row.len());
            let hint = format!(
                "a row has all {s} entries, or those left of the diagonal, with it or without: {i} or {}",
                i + 1
            );
            return Err(Fault::new(*at, reason).hint(hint));
        }
    }
    Ok(rows.into_iter().map(|(_, row)| row).collect())
}

fn parse(list: Vec<Scalar>) -> Result<Vec<Parsed>, Fault> {
    let one = |scalar: Scalar| match Expression::parse(&scalar.text) {
        Ok(expression) => Ok((scalar, expression)),
        Err(malformed) => Err(fault(&scalar, malformed)),
    };
    list.into_iter().map(one).collect()
}

fn fault(scalar: &Scalar, malformed: Malformed) -> Fault {
    let hint = "a coefficient is a number, or a text like \"1/2 - sqrt(3)/6\"";
    Fault::new(scalar.at + malformed.at, format!("in `{}`: {}", scalar.text, malformed.reason)).hint(hint)
}

fn coefficient((scalar, expression): &Parsed, rounding: Rounding) -> Result<Coefficient, Fault> {
    let value = expression.evaluate(rounding).map_err(|malformed| fault(scalar, malformed))?;
    Ok(Coefficient { text: scalar.text.trim().to_owned(), exact: value.exact, real: value.real })
}
