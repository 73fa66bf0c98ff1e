//! What the discrete equations owe to each other.

use super::{Context, Scale, StudyError, prose, short};
use crate::evidence::number::rounded_up;
use crate::evidence::{Cell, Check, Evidence, Requirement, Table};
use crate::experiment::flow::identities::{Found, Identities};
use crate::measure::norm::Extremes;
use crate::row;

/// Flows, and whether nothing but viscosity and the walls changes their energy.
const FLOWS: [(&str, bool); 7] = [
    ("cavity cells=12", true),
    ("cavity-manufactured cells=12", false),
    ("kovasznay cells=12", false),
    ("channel-2d cells=12 length=4", false),
    ("taylor-green cells=16", true),
    ("turbulence-2d cells=16", true),
    ("turbulence-2d cells=16 metric=vorticity", true),
];

pub(super) fn study(context: &Context, evidence: &mut Evidence, _scale: &Scale) -> Result<(), StudyError> {
    let cases = FLOWS.map(|(flow, is_closed)| Identities { flow, is_closed });
    let found = context.get_each(cases.into())?;
    let mut rows = Vec::new();
    for ((flow, _), found) in FLOWS.into_iter().zip(&found) {
        evidence.checks.extend(judged(flow, found));
        rows.push(row![flow, found.adjoint, found.jacobian, Cell::found(found.work.unwrap_or(f64::NAN))]);
    }
    let largest = |of: Vec<f64>| short(rounded_up(of.into_iter().largest(), 4));
    let values = [
        ("adjoint", largest(found.iter().map(|found| found.adjoint).collect())),
        ("jacobian", largest(found.iter().map(|found| found.jacobian).collect())),
        ("work", largest(found.iter().filter_map(|found| found.work).collect())),
    ];
    evidence.notes.extend(prose::fill(include_str!("identities.md"), &values)?);
    let caption = "Identities of the discrete equations at random states, relative to what they equate: yᵀ(Jx) = (Jᵀy)ᵀx, Jx and the \
                   central difference of f, and vᵀf = 0 without viscosity, where the flow is closed: of energy, and in the metric of the \
                   vorticity of enstrophy.";
    evidence.tables.push(Table::new("flow-identities", caption, ["flow", "adjoint", "jacobian", "work"], rows));
    Ok(())
}

/// Of a component of f the 30 products or fewer, or the stages of two Fourier transforms, are rounded twice each, in f at two states, which are up to twice as large.
const COMPONENT: f64 = 256.0 * f64::EPSILON;

/// Each identity of a flow.
fn judged(flow: &str, found: &Found) -> Vec<Check> {
    // Each product is rounded as often as something is added to it, and once before.
    let sum = (1 + found.unknowns) as f64 * f64::EPSILON;
    let check = |what: &str, says: &str, measured: f64, most: f64, why: &'static str| {
        let id = format!("identities/{what}/{}", flow.replace([' ', '='], "-"));
        Check::new(id, format!("{says} on {flow}: relative difference"), measured, Requirement::AtMost(most), why)
    };
    let rounding = "sums of as many terms as there are unknowns and neighbours, each rounded";
    let exact = "f is quadratic: its central difference is rounded only";
    let mut checks = vec![
        check("adjoint", "Jᵀy is the adjoint of Jx", found.adjoint, sum, rounding),
        check("jacobian", "Jx is the derivative of f", found.jacobian, COMPONENT, exact),
    ];
    checks.extend(found.work.map(|work| check("work", "Convection does no work", work, sum, rounding)));
    checks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;

    #[test]
    fn each_identity_is_judged_by_its_own_number() {
        let refused = |adjoint: f64, jacobian: f64, work: f64| -> Vec<String> {
            let checks = judged("flow", &Found { unknowns: 99, adjoint, jacobian, work: Some(work) });
            let refused = checks.into_iter().filter(|check| check.outcome != Outcome::Pass);
            let identity = |id: &str| id.strip_prefix("identities/")?.strip_suffix("/flow").map(str::to_owned);
            refused.map(|check| identity(&check.id).expect("an identity of the flow")).collect()
        };
        let (less, more) = (90.0 * f64::EPSILON, 110.0 * f64::EPSILON);
        assert_eq!(refused(less, 0.9 * COMPONENT, less), [""; 0]);
        assert_eq!(refused(more, 0.9 * COMPONENT, less), ["adjoint"]);
        assert_eq!(refused(less, 1.1 * COMPONENT, less), ["jacobian"]);
        assert_eq!(refused(less, 0.9 * COMPONENT, more), ["work"]);
        assert_eq!(refused(f64::NAN, f64::NAN, f64::NAN).len(), 3);
    }
}
