//! Large steps on the way to a steady cavity.

use super::{Context, Scale, StudyError, prose, short, times};
use crate::evidence::{Cell, Evidence, Table};
use crate::experiment::flow::approach::{Approach, Found};
use crate::row;

/// Steps from rest to the steady cavity.
pub(super) fn from_rest(method: &'static str, cells: usize, h: f64) -> Approach {
    Approach { method, re: 100.0, cells, h }
}

/// How steps to a steady cavity end.
pub(super) fn ended(found: &Found) -> String {
    match &found.error {
        Some(error) => error.clone(),
        None if found.is_steady() => "steady".to_owned(),
        None => "still moving".to_owned(),
    }
}

/// Steps of several methods from rest to the steady cavity.
pub(super) fn study(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    const METHODS: [&str; 5] = ["method-i", "trapezoidal", "tr-bdf2", "bdf2", "implicit-euler"];
    const STEPS: [f64; 3] = [1.0, 10.0, 100.0];
    let mut cases = Vec::new();
    for method in METHODS {
        cases.extend(STEPS.map(|h| (method, h)));
    }
    // By so long a step implicit Euler is Newton's method on f = 0.
    const NEWTON: (&str, f64) = ("implicit-euler", 1e8);
    cases.push(NEWTON);
    let cells = scale.approach;
    let Approach { re, .. } = from_rest("", cells, 0.0);
    let settings = cases.iter().map(|(method, h)| from_rest(method, cells, *h));
    let found = context.get_each(settings.collect())?;
    let rows = cases.iter().zip(&found).map(|((method, h), found)| {
        let [least, most] = [found.seconds.least, found.seconds.most];
        row![*method, *h, found.steps, found.solves, least, most, Cell::found(found.residual), ended(found)]
    });
    let rows = rows.collect();
    let of =
        |method: &str, h: f64| cases.iter().zip(&found).find(|(case, _)| **case == (method, h)).map(|(_, found)| found);
    let count = |method: &str, h: f64| match of(method, h) {
        Some(found) if found.is_steady() => {
            let steps = if found.steps == 1 { "one step".to_owned() } else { format!("{} steps", found.steps) };
            format!("takes {steps} and {} linear systems", found.solves)
        }
        Some(found) if found.error.is_some() => "fails in a step".to_owned(),
        _ => format!("does not get there in {} steps", Approach::MOST),
    };
    let [one, ten, hundred] = STEPS;
    let solves = |method: &str, h: f64| of(method, h).filter(|found| found.is_steady()).map(|found| found.solves);
    let takes_fewer = |other: &str, steps: &[f64]| {
        steps.iter().all(|h| match (solves("method-i", *h), solves(other, *h)) {
            (Some(own), Some(other)) => own < other,
            (own, _) => own.is_some(),
        })
    };
    let ranked = |steps: &[f64]| -> (Vec<&str>, Vec<&str>) {
        METHODS[1..].iter().copied().partition(|other| takes_fewer(other, steps))
    };
    let ((ahead_of, not_of), (ahead_of_one, not_of_one)) = (ranked(&[ten, hundred]), ranked(&[one]));
    let list = |methods: &[&str]| match methods {
        [] => "none of them".to_owned(),
        [only] => (*only).to_owned(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    };
    // A run that is given up has taken what it was given.
    let seconds = |method: &str, h: f64| of(method, h).filter(|found| found.is_steady()).map(|found| found.seconds);
    let against = |other: &str, h: f64| match (seconds("method-i", hundred), seconds(other, h)) {
        (Some(own), Some(other)) => format!("{} times", times(own, other)),
        _ => "an unknown part of".into(),
    };
    let values = [
        ("re", short(re)),
        ("cells", cells.to_string()),
        ("ten", short(ten)),
        ("hundred", short(hundred)),
        ("method_i_ten", count("method-i", ten)),
        ("rule_ten", count("trapezoidal", ten)),
        ("tr_bdf2_ten", count("tr-bdf2", ten)),
        ("euler_ten", count("implicit-euler", ten)),
        ("method_i_hundred", count("method-i", hundred)),
        ("tr_bdf2_hundred", count("tr-bdf2", hundred)),
        ("bdf2_ten", count("bdf2", ten)),
        ("bdf2_hundred", count("bdf2", hundred)),
        ("euler_hundred", count("implicit-euler", hundred)),
        ("fewer", list(&ahead_of)),
        ("no_fewer", list(&not_of)),
        ("one", short(one)),
        ("method_i_one", count("method-i", one)),
        ("rule_one", count("trapezoidal", one)),
        ("tr_bdf2_one", count("tr-bdf2", one)),
        ("bdf2_one", count("bdf2", one)),
        ("euler_one", count("implicit-euler", one)),
        ("fewer_one", list(&ahead_of_one)),
        ("no_fewer_one", list(&not_of_one)),
        ("newton", short(NEWTON.1)),
        ("newton_count", count(NEWTON.0, NEWTON.1)),
        ("cpu_tr_bdf2", against("tr-bdf2", hundred)),
        ("cpu_bdf2", against("bdf2", hundred)),
        ("cpu_euler", against("implicit-euler", hundred)),
        ("cpu_newton", against(NEWTON.0, NEWTON.1)),
    ];
    evidence.notes.extend(prose::fill(include_str!("approach.md"), &values)?);
    let caption = format!(
        "Cavity of {cells} cells a side, Re = {re}, from rest until |f| ≤ {:e} in units of M ψ̇: steps, up to {} of them; `solves`, the linear systems, each \
         with a solve in an iteration of GMRES or, of Method I, two in one of conjugate gradients; and the least and the most CPU seconds \
         of up to three such runs.",
        Approach::STEADY,
        Approach::MOST
    );
    let columns = ["method", "h", "steps", "solves", "least_seconds", "most_seconds", "residual", "outcome"];
    evidence.tables.push(Table::new("flow-approach", caption, columns, rows));
    Ok(())
}
