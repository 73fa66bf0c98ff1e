//! What was found out about a method, in sentences.

use super::Judgement;
use super::diagnosis::Diagnosis;
use super::file::Body;
use super::linear::Reach;
use super::real::Real;
use super::repair::Repair;
use super::theory::WeightsTheory;
use crate::measure::decimal::trimmed;

/// Labelled lines of text.
pub type Facts = Vec<(&'static str, String)>;

impl Judgement {
    /// Kind, shape and digits in a line.
    pub fn headline(&self) -> String {
        let digits = self.file.rounding.told();
        format!("{}, {digits}", self.theory.headline())
    }

    /// What the theory says, and defects that were measured, each with its label.
    pub fn facts(&self) -> Facts {
        let mut facts = self.theory.facts();
        if let Some(Ok(defects)) = &self.defects {
            let text = format!("symplecticity {:.1e}, symmetry {:.1e}", defects.symplectic, defects.symmetric);
            facts.push(("defects", text));
        }
        match &self.work {
            Some(Ok((problem, points))) => facts.push(("work", super::work::summary(problem, points))),
            Some(Err(reason)) => facts.push(("work", format!("not run: {reason}"))),
            None => {}
        }
        facts
    }

    /// Whether a label or a coefficient is wrong, in sentences; nothing where neither is.
    pub fn diagnosis_text(&self) -> Option<String> {
        let found = self.found_wrong()?;
        let is_too_low = matches!(self.diagnosis, Diagnosis::LabelTooLow { .. });
        let doubt = self.file.rounding.doubt().filter(|_| !is_too_low);
        Some(doubt.map_or_else(|| found.clone(), |doubt| format!("{found} {doubt}")))
    }

    fn found_wrong(&self) -> Option<String> {
        match &self.diagnosis {
            Diagnosis::Sound => None,
            Diagnosis::Truncated { order } => Some(format!(
                "The decimals look as if they were cut off, not rounded: up to a unit larger in their last place they have order {order}, \
                 and all row sums hold. Rounded, or as fractions, they would do.{}",
                self.sum_of_weights()
            )),
            Diagnosis::LabelTooLow { order } => {
                let claimed = self.file.order().unwrap_or(0);
                Some(format!(
                    "The label is too low: order {claimed} is claimed, and the coefficients have order {order}."
                ))
            }
            Diagnosis::LabelTooHigh { order } => {
                let claimed = self.file.order().unwrap_or(0);
                match self.file.body {
                    Body::RungeKutta(_) => {}
                    Body::Closure(_) => {
                        return Some(format!(
                            "The label is too high: a closure has order {order} for any α and β with α + β ≠ 0, so that no \
                             condition singles out a coefficient."
                        ));
                    }
                    _ => {
                        return Some(format!(
                            "The label is too high, or more than one coefficient is wrong: no change of a single coefficient makes \
                             the conditions of order {claimed} hold. As they stand they have order {order}."
                        ));
                    }
                }
                let embedded = self.runge_kutta().and_then(|theory| theory.embedded.as_ref());
                let (weights, order) = match embedded.filter(|_| self.theory.order() >= claimed) {
                    Some(embedded) => ("b_hat", embedded.order),
                    None => ("b", *order),
                };
                Some(format!(
                    "The label is too high, or more than one coefficient is wrong: the row sums hold, the conditions on \
                     {weights} fail, and no change of a single coefficient mends them. As they stand they have order {order}.{}",
                    self.sum_of_weights()
                ))
            }
            Diagnosis::Coefficient { target, repairs } => {
                let embedded = target.embedded.map_or_else(String::new, |q| format!(", of the embedded method {q}"));
                let sums = match self.file.body {
                    Body::RungeKutta(_) => ", and all row sums hold",
                    _ => "",
                };
                let start = format!("With one coefficient changed the order is {}{embedded}{sums}", target.order);
                // No label is wrong about a row sum.
                let rows = self.runge_kutta().is_some_and(|theory| !theory.wrong_rows().is_empty());
                let doubt = match repairs.first() {
                    Some(repair) if repair.mends == 1 && !rows => {
                        " One number that satisfies one condition may be a coincidence: it may be the label that is wrong."
                    }
                    _ => "",
                };
                Some(format!("A coefficient is wrong. {start}.{doubt}{}", self.sum_of_weights()))
            }
            Diagnosis::Several { rows } => {
                let of = match rows.as_slice() {
                    [row] => format!("the row sum of stage {}", row + 1),
                    rows => {
                        let rows: Vec<String> = rows.iter().map(|i| (i + 1).to_string()).collect();
                        format!("the row sums of stages {}", rows.join(", "))
                    }
                };
                Some(format!(
                    "More than one coefficient is wrong: no change of a single one mends {of}, and the order.{}",
                    self.sum_of_weights()
                ))
            }
        }
    }

    /// What the weights add up to, where that is not 1, or may be so for digits that were cut off.
    fn sum_of_weights(&self) -> String {
        let is_cut = matches!(self.diagnosis, Diagnosis::Truncated { .. });
        let sums = self.runge_kutta().filter(|theory| is_cut || theory.main.order == 0).map(|theory| {
            let sum: Real = theory.numbers.b.iter().cloned().sum();
            format!(" The weights add up to {}.", trimmed(sum.to_f64(), 12))
        });
        sums.unwrap_or_default()
    }

    /// The changes that mend everything, each in a line.
    pub fn repairs(&self) -> &[Repair] {
        match &self.diagnosis {
            Diagnosis::Coefficient { repairs, .. } => repairs,
            _ => &[],
        }
    }
}

impl Repair {
    /// `a[4,3]: 1/2 → 1`, with what it mends.
    pub fn sentence(&self) -> String {
        let with_c = match (self.with_c, self.place) {
            (true, super::tableau::Place::A(i, _)) => format!(", and c[{}] with it", i + 1),
            _ => String::new(),
        };
        let failing = if self.mends == 1 {
            "the failing condition".into()
        } else {
            format!("all {} failing conditions", self.mends)
        };
        let implicit = if self.makes_implicit { ", and couples stages that are not coupled" } else { "" };
        format!("{}: {} → {}{with_c}, mends {failing}{implicit}", self.place, self.was, self.text)
    }
}

pub(super) fn order(weights: &WeightsTheory) -> String {
    let failing = weights.conditions.iter().find(|c| !c.holds());
    match (failing, weights.error_norm) {
        (Some(first), Some(norm)) => format!(
            "{}; first failing tree {}, principal error {norm:.3e}",
            weights.order,
            weights.forest.brackets(first.tree)
        ),
        _ => format!("{} or more: every condition looked at holds", weights.order),
    }
}

pub(super) fn reach(reach: Reach, axis: &str) -> String {
    match reach {
        Reach::Everything => format!("all of the {axis} axis"),
        Reach::UpTo { end: 0.0, .. } => format!("nothing of the {axis} axis"),
        Reach::UpTo { end, .. } => format!("{axis} axis to {end:.4}"),
    }
}

pub(super) fn short(x: f64) -> String {
    let text = format!("{x:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.to_owned() }
}
