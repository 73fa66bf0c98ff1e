//! Each claim against the theory: confirmed, refuted with the counterexample, or inconclusive.

use super::claim::{Claim, Property};
use super::linear::Reach;
use super::structure::Indefinite;
use super::tableau::Shape;
use super::theory::{Theory, WeightsTheory};
use super::tree::MAX_ORDER;
use serde::Serialize;

use crate::evidence::{Check, Outcome};

/// What a verdict is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// A claim of the file.
    Claim,
    /// The coefficients among themselves.
    Consistency,
    /// Theory and a run.
    Run,
}

/// A statement about the method, and what came of it.
#[derive(Debug, Clone, Serialize)]
pub struct Verdict {
    /// What it is on.
    pub kind: Kind,
    /// Its subject in a word or two: `order 4`.
    pub subject: String,
    /// The statement, decided.
    #[serde(flatten)]
    pub check: Check,
}

/// What theory says of a property: whether it holds, and the number or counterexample that shows it.
#[derive(Debug, Clone)]
struct Finding {
    outcome: Outcome,
    measured: Option<f64>,
    why: String,
}

impl Finding {
    fn new(holds: bool, why: impl Into<String>) -> Self {
        Self { outcome: holds.into(), measured: None, why: why.into() }
    }

    fn measured(self, x: impl Into<f64>) -> Self {
        Self { measured: Some(x.into()), ..self }
    }
}

/// The verdict on `claim`.
pub(super) fn judge(claim: &Claim, theory: &Theory) -> Verdict {
    let finding = find(claim.property, theory);
    let outcome = match (finding.outcome, claim.denied) {
        (Outcome::Pass, true) => Outcome::Fail,
        (Outcome::Fail, true) => Outcome::Pass,
        (outcome, _) => outcome,
    };
    let text = claim.to_string();
    let check = Check {
        id: format!("claim/{}", text.replace(' ', "-")),
        statement: format!("It is {text}, as claimed"),
        outcome,
        measured: finding.measured,
        required: None,
        reason: finding.why,
    };
    Verdict { kind: Kind::Claim, subject: text, check }
}

/// Whether c is the sum of the rows of A, where the file gives it.
pub(super) fn rows(theory: &Theory) -> Option<Verdict> {
    let defects = theory.row_defects.as_ref()?;
    let wrong = theory.wrong_rows();
    let words = |i: &usize| {
        let sum = &theory.numbers.c[*i] - &defects[*i];
        format!(
            "row {} adds up to {:.10}, and c[{}] is {:.10}",
            i + 1,
            sum.to_f64(),
            i + 1,
            theory.numbers.c[*i].to_f64()
        )
    };
    let reason = match wrong.as_slice() {
        [] => "c_i = Σ_j a_ij in every row".to_owned(),
        rows => rows.iter().map(words).collect::<Vec<_>>().join("; "),
    };
    let check = Check {
        id: "rows".into(),
        statement: "The abscissae are the sums of the rows".into(),
        outcome: wrong.is_empty().into(),
        measured: defects.iter().map(|defect| defect.to_f64().abs()).reduce(f64::max),
        required: None,
        reason,
    };
    Some(Verdict { kind: Kind::Consistency, subject: "row sums".into(), check })
}

fn find(property: Property, theory: &Theory) -> Finding {
    match property {
        Property::Order(p) => order(p, &theory.main, "b"),
        Property::EmbeddedOrder(p) => match &theory.embedded {
            Some(embedded) => order(p, embedded, "b̂"),
            None => Finding::new(false, "the file has no b_hat"),
        },
        Property::StageOrder(q) => {
            let found = theory.simplifying.stage_order();
            let why = format!(
                "B({}) and C({}) hold, so that the stage order is {found}",
                theory.simplifying.b, theory.simplifying.c
            );
            Finding::new(found == q, why).measured(found)
        }
        Property::Explicit => shape(theory, Shape::Explicit),
        Property::DiagonallyImplicit => shape(theory, Shape::DiagonallyImplicit),
        Property::AStable => a_stable(theory),
        Property::AlphaStable(angle) => match theory.alpha {
            Some(alpha) => {
                let why = format!("|R| ≤ 1 in the sector |arg(−z)| ≤ {alpha:.2}°");
                // The angle is found to a hundredth, and claims are rounded to the digits they have.
                Finding::new(angle <= alpha + 0.01, why).measured(alpha)
            }
            None => Finding::new(false, "not even the negative axis is in the region of stability"),
        },
        Property::LStable => {
            let infinity = theory.stability.at_infinity();
            match a_stable(theory) {
                finding if finding.outcome == Outcome::Fail => finding,
                _ if infinity == 0.0 => Finding::new(true, "A-stable, and deg N < deg D, so that R(∞) = 0"),
                _ => Finding::new(false, format!("A-stable, but R(∞) = {infinity:.6}")).measured(infinity),
            }
        }
        Property::AlgebraicallyStable => match &theory.algebraic {
            Ok(()) => Finding::new(true, "b ≥ 0, and B A + Aᵀ B − b bᵀ is positive semidefinite"),
            Err(Indefinite::Weight(i, b)) => {
                Finding::new(false, format!("b[{}] = {b:.6} is negative", i + 1)).measured(*b)
            }
            Err(Indefinite::Pivot(i, x)) => {
                let why = format!("B A + Aᵀ B − b bᵀ is indefinite: elimination meets {x:.4e} at stage {}", i + 1);
                Finding::new(false, why).measured(*x)
            }
            Err(Indefinite::Undecided) => Finding {
                outcome: Outcome::Inconclusive,
                measured: None,
                why: "the digits given do not tell whether B A + Aᵀ B − b bᵀ is semidefinite".into(),
            },
        },
        Property::StifflyAccurate => {
            let text = if theory.stiffly_accurate { "the last row of A is b" } else { "the last row of A is not b" };
            Finding::new(theory.stiffly_accurate, text)
        }
        Property::Symplectic => match theory.symplectic_defect {
            None => Finding::new(true, "b_i a_ij + b_j a_ji = b_i b_j for all i, j"),
            Some((i, j, x)) => {
                let why = format!("b_i a_ij + b_j a_ji − b_i b_j = {x:.4e} at i = {}, j = {}", i + 1, j + 1);
                Finding::new(false, why).measured(x)
            }
        },
        Property::Symmetric => {
            let text = if theory.symmetric {
                "a_σ(i)σ(j) + a_ij = b_j with the stages reversed"
            } else {
                "a_σ(i)σ(j) + a_ij = b_j fails with the stages reversed"
            };
            Finding::new(theory.symmetric, text)
        }
        Property::DispersionOrder(p) => series_order(p, theory.linear.dispersion, "phase"),
        Property::DissipationOrder(p) => series_order(p, theory.linear.dissipation, "amplitude"),
        Property::ImaginaryInterval(y) => match theory.imaginary {
            Reach::Everything => Finding::new(true, "|R(iy)| ≤ 1 for all y"),
            Reach::UpTo { end, witness } => {
                let size = theory.stability.at(nalgebra::Complex::new(0.0, witness)).norm();
                let why = format!("|R(iy)| ≤ 1 up to |y| = {end:.6}; |R({witness:.4}i)| = {size:.8}");
                // The claim is rounded to the digits it has, of which there are rarely more than four.
                Finding::new(y <= end * (1.0 + 5e-4), why).measured(end)
            }
        },
    }
}

fn shape(theory: &Theory, claimed: Shape) -> Finding {
    let text = match theory.shape {
        Shape::Explicit => "A is zero on and above its diagonal",
        Shape::DiagonallyImplicit => "A is zero above its diagonal and not on it",
        Shape::FullyImplicit => "A has entries above its diagonal",
    };
    Finding::new(theory.shape == claimed, text)
}

fn a_stable(theory: &Theory) -> Finding {
    match theory.stability.is_a_stable() {
        Ok(()) => Finding::new(true, "no pole in the left half-plane, and |R(iy)| ≤ 1 for all y"),
        Err(z) => {
            let size = theory.stability.at(z).norm();
            let place = if z.re == 0.0 { format!("{:.6}i", z.im) } else { format!("{:.6} {:+.6}i", z.re, z.im) };
            let why = if size < 1e6 {
                format!("|R| = {size:.8} at z = {place}")
            } else {
                format!("R has a pole at z = {place}")
            };
            Finding::new(false, why).measured(size)
        }
    }
}

fn series_order(p: u32, found: Option<(u32, f64)>, what: &str) -> Finding {
    match found {
        Some((order, constant)) => {
            let why = format!("the leading error of the {what} is {constant:.4e} (hω)^{}", order + 1);
            Finding::new(order == p, why).measured(order)
        }
        None => Finding::new(false, format!("there is no error of the {what} at all, to any order looked at")),
    }
}

fn order(p: u32, weights: &WeightsTheory, name: &str) -> Finding {
    if p > MAX_ORDER {
        let why = format!("conditions are made up to order {MAX_ORDER}; they hold up to order {}", weights.order);
        let outcome = if weights.order < MAX_ORDER { Outcome::Fail } else { Outcome::Inconclusive };
        return Finding { outcome, measured: None, why };
    }
    let number = weights.conditions.iter().filter(|c| c.order <= p).count();
    let why = match weights.failing(p).next() {
        Some(first) => {
            let failing = weights.failing(p).count();
            format!(
                "{failing} of {number} conditions on {name} fail, the first at order {}: {} is off by {:.3e}",
                first.order,
                weights.forest.formula(first.tree, name, false),
                first.residual.to_f64()
            )
        }
        None if weights.order > p => {
            format!("all {number} conditions hold, and those up to order {} too", weights.order)
        }
        None => {
            let next = weights.conditions.iter().find(|c| !c.holds());
            let then = next.map_or_else(String::new, |c| {
                format!(
                    "; of order {}, {} is off by {:.3e}",
                    c.order,
                    weights.forest.formula(c.tree, name, false),
                    c.residual.to_f64()
                )
            });
            let conditions =
                if number == 1 { "the condition holds".into() } else { format!("all {number} conditions hold") };
            format!("{conditions} to within {:.0e}{then}", weights.resolution())
        }
    };
    Finding::new(weights.order == p, why).measured(weights.order)
}
