//! Steps of Method I that are too long for their grid.

use std::sync::Arc;

use super::approach::ended;
use super::{Context, Scale, StudyError, prose, short, streamlines};
use crate::evidence::{Cell, Check, Evidence, Figure, Requirement, Table};
use crate::experiment::flow::approach::{self, Approach};
use crate::experiment::flow::spurious::{Refused, RestingState, Root, Spurious};
use crate::experiment::flow::steady::STEADY;
use crate::measure::norm::{distance, max_norm};
use crate::row;

pub(super) const RE: f64 = 1000.0;

/// Steps from rest.
pub(super) fn steps(&(cells, h): &(usize, f64)) -> Spurious {
    Spurious { re: RE, cells, h }
}

/// Where the minimum of the action of a long step is no steady flow.
pub(super) fn study(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    const OTHERS: [&str; 2] = ["implicit-euler", "tr-bdf2"];
    let found = context.get_each(scale.too_long.iter().map(steps).collect())?;
    let cases = || scale.too_long.iter().zip(&found);
    let Some((longest @ &(cells, h), worst)) = cases().next_back() else { return Ok(()) };
    let by = |method| scale.too_long.iter().map(move |&(cells, h)| Approach { method, re: RE, cells, h });
    let others = context.get_each(OTHERS.into_iter().flat_map(by).collect())?;
    let list = |arrives: bool| {
        let such = cases().filter(|(_, found)| found.message.is_empty() == arrives);
        let such: Vec<_> = such.map(|((cells, h), _)| format!("h = {} on {cells}²", short(*h))).collect();
        if such.is_empty() { "none of these steps".to_owned() } else { such.join(", ") }
    };
    let values = [
        ("re", short(RE)),
        ("arrives", list(true)),
        ("stalls", list(false)),
        ("cells", cells.to_string()),
        ("h", short(h)),
        ("rest", short(worst.residual)),
        ("gradient", worst.gradient.map_or("an unknown number of".into(), short)),
        ("others", reach(&others)),
    ];
    evidence.notes.extend(prose::fill(include_str!("spurious.md"), &values)?);
    evidence.checks.push(refused(&steps(longest), worst));
    let id = "flow-too-long";
    let root = context.get(RestingState(steps(longest)))?;
    let arrived = cases().find(|((others, _), found)| *others == cells && found.message.is_empty());
    let steady = arrived.and_then(|(_, found)| found.psi.as_ref()).ok_or("no steps arrive on this grid")?;
    let moved = root.as_ref().as_ref().map(|root| root.change / distance(&root.psi, steady));
    evidence.checks.extend(rests(&steps(longest), root.as_ref().as_ref(), moved));
    if let (Some(root), Some(moved)) = (&*root, moved) {
        let values = [
            ("residual", short(root.residual)),
            ("imbalance", short(root.imbalance)),
            ("rate", short(2.0 / h)),
            ("moved", short(moved)),
            ("vortex", short(max_norm(&root.psi))),
            ("steady", short(max_norm(steady))),
        ];
        evidence.notes.extend(prose::fill(include_str!("resting.md"), &values)?);
        let panels = [("steady".to_owned(), steady), (format!("h = {h}, refused"), &root.psi)];
        let panels = panels.map(|(title, psi)| streamlines(&title, cells, psi));
        let caption = "Streamlines of the steady flow, and of a spurious fixed point of Method I with long steps.";
        evidence.figures.push(Figure::new(id, caption, id, panels).in_columns(2));
    }
    let outcome = |message: &str| if message.is_empty() { "steady".to_owned() } else { format!("refused: {message}") };
    let own = cases().map(|((cells, h), found)| {
        let vortex = found.psi.as_deref().map(max_norm);
        row!["method-i", *cells, *h, found.residual, found.gradient, vortex, outcome(&found.message)]
    });
    let each = OTHERS.into_iter().flat_map(|method| scale.too_long.iter().map(move |case| (method, *case)));
    let others = each.zip(&others).map(|((method, (cells, h)), found)| {
        row![method, cells, h, Cell::found(found.residual), Cell::Empty, Cell::Empty, ended(found)]
    });
    let resting = root.iter().map(|root| {
        let vortex = max_norm(&root.psi);
        row!["resting", cells, h, root.residual, Cell::Empty, vortex, outcome(&root.message)]
    });
    let rows = own.chain(others).chain(resting).collect();
    let caption = format!(
        "From rest at Re = {RE}, by cells a side and step size: |f| in units of M ψ̇ where the iteration of Method I ends, or where \
         another method has it below {:e}; where that iteration stalls, the gradient of the action over that at rest; max |ψ| of Method I; \
         and the outcome. The last row is the spurious fixed point of Method I.",
        Approach::STEADY
    );
    let columns = ["method", "cells", "h", "residual", "gradient", "vortex", "outcome"];
    evidence.tables.push(Table::new(id, caption, columns, rows));
    Ok(())
}

/// How many runs of other methods come to a steady flow.
fn reach(others: &[Arc<approach::Found>]) -> String {
    match others.iter().filter(|other| !other.is_steady()).count() {
        0 => "all come to a steady flow".to_owned(),
        missed => format!("come to a steady flow in all but {missed} of their runs"),
    }
}

/// That the library refuses where the iteration ends, and that the flow is not steady there.
fn refused(Spurious { re, cells, h }: &Spurious, found: &Refused) -> Check {
    Check::new(
        "steady/too-long",
        format!(
            "Re = {re} on {cells}² cells with h = {h}: where the iteration of Method I ends the flow is not steady, and the library refuses \
             it; |f| there"
        ),
        if found.message.is_empty() { f64::NAN } else { found.residual },
        Requirement::AtLeast(1e6 * STEADY),
        "a million times what counts as steady",
    )
}

/// That Method I rests in a state that is not steady, and that the library refuses it.
///
/// `moved` is what a step of Method I from there changes, over the distance from the steady flow.
fn rests(Spurious { re, cells, h }: &Spurious, root: Option<&Root>, moved: Option<f64>) -> [Check; 3] {
    let place = format!("Re = {re} on {cells}² cells with h = {h}");
    let refused = root.filter(|root| root.message.starts_with("spurious steady state"));
    [
        Check::new(
            "steady/resting",
            format!("{place}: Method I rests, (2M − hJᵀ)M⁻¹f = 0; what is left of that, over its terms"),
            root.map_or(f64::NAN, |root| root.imbalance),
            Requirement::AtMost(64.0 * f64::EPSILON),
            "sums of some thirty products, of entries that are rounded themselves",
        ),
        Check::new(
            "steady/stays",
            format!("{place}: what a step of Method I changes of ψ there, over its distance from the steady flow"),
            moved.unwrap_or(f64::NAN),
            Requirement::AtMost(1e-3),
            "a thousandth of the way to the steady flow is none: the action is flat to rounding at √ε of ψ",
        ),
        Check::new(
            "steady/spurious",
            format!("{place}: the flow is not steady there, and the library refuses it as spurious; |f| there"),
            refused.map_or(f64::NAN, |root| root.residual),
            Requirement::AtLeast(1e6 * STEADY),
            "a million times what counts as steady",
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;
    use crate::experiment::flow::Seconds;

    const LONG: (usize, f64) = (32, 1e3);

    #[test]
    fn what_is_refused_moves_and_what_is_accepted_was_not_refused() {
        let outcome = |residual: f64, message: &str| {
            let found = Refused { residual, psi: None, gradient: None, message: message.into() };
            refused(&steps(&LONG), &found).outcome
        };
        assert_eq!(outcome(8e-4, "refused"), Outcome::Pass);
        for (residual, message) in [(8e-4, ""), (9e-5, "refused"), (f64::NAN, "refused")] {
            assert_ne!(outcome(residual, message), Outcome::Pass, "{residual} {message}");
        }
    }

    #[test]
    fn a_resting_state_is_a_root_that_moves_and_is_refused_as_spurious() {
        let outcomes = |imbalance: f64, moved: f64, residual: f64, message: &str| {
            let root = Root { psi: Vec::new(), residual, imbalance, change: 0.0, message: message.into() };
            rests(&steps(&LONG), Some(&root), Some(moved)).map(|check| check.outcome == Outcome::Pass)
        };
        let spurious = "spurious steady state: as it is";
        assert_eq!(outcomes(1e-16, 1e-6, 8e-4, spurious), [true, true, true]);
        assert_eq!(outcomes(1e-13, 1e-6, 8e-4, spurious), [false, true, true]);
        assert_eq!(outcomes(1e-16, 0.01, 8e-4, spurious), [true, false, true]);
        assert_eq!(outcomes(1e-16, 1e-6, 9e-5, spurious), [true, true, false]);
        assert_eq!(outcomes(1e-16, 1e-6, 8e-4, ""), [true, true, false]);
        assert_eq!(outcomes(f64::NAN, f64::NAN, f64::NAN, spurious), [false; 3]);
        assert!(rests(&steps(&LONG), None, None).iter().all(|check| check.outcome != Outcome::Pass));
    }

    #[test]
    fn a_run_that_fails_and_one_that_still_moves_come_to_no_steady_flow() {
        let run = |residual: f64, error: Option<&str>| {
            let (error, seconds) = (error.map(Into::into), Seconds::NONE);
            Arc::new(approach::Found { steps: 100, solves: 100, residual, error, seconds })
        };
        let [steady, moving, failed] = [run(0.5e-8, None), run(1e-3, None), run(1e-3, Some("no root"))];
        assert_eq!(reach(&[steady.clone(), steady.clone()]), "all come to a steady flow");
        assert!(reach(&[steady.clone(), moving.clone()]).ends_with("in all but 1 of their runs"));
        assert!(reach(&[steady, moving, failed]).ends_with("in all but 2 of their runs"));
    }
}
