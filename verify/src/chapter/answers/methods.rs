//! The methods that the first page names: what each is, and whether to use it.

use super::smooth::FAMILY;
use super::{parabolic, prose, smooth};
use crate::chapter::{Context, StudyError};
use crate::evidence::number::{between, brief};
use crate::evidence::{Cell, Check, Evidence, Requirement, Section, Table};
use crate::experiment::best_theta::BestTheta;
use crate::experiment::end_errors::{EndErrors, Truth};
use crate::experiment::one_step::{LeavesAt, OneStep};
use crate::kinds::{Principle, Stability};
use crate::measure::norm::Extremes;
use crate::method;

const ID: &str = "methods";

/// Up to which hλ a closure of the family is the best one.
const RANGE: f64 = 3.0;
/// Where the run of the position–momentum form ends.
const END: f64 = 10.0;
/// Steps hλ of which two methods are compared.
const STEPS: [f64; 5] = [0.01, 0.1, 1.0, 10.0, 100.0];

pub(super) fn tell(context: &Context, evidence: &mut Evidence) -> Result<(), StudyError> {
    let after_jump = |method: &str| EndErrors {
        problem: "channel-couette cells=64".into(),
        method: method.into(),
        h: 0.05,
        pieces: 1,
        t_end: 0.5,
        truth: Truth::Equations,
    };
    let ringing = ["method-i", "method-ii", "trapezoidal"].map(after_jump);
    let ringing: Vec<f64> = context.get_each(ringing.into())?.iter().map(|found| found.end).collect();
    let mut apart = Vec::new();
    for h in STEPS {
        let [second, rule] = ["method-ii", "trapezoidal"].map(|name| OneStep::growth(name, h).or_infinity(context));
        apart.push((second? - rule?).abs());
    }
    let step = OneStep::on_quadratic_drag("method-ii", 0.5);
    let lost = *context.get(LeavesAt { step, least: -2.0, most: 2.0, low: 0.5, high: 2.0 })?;
    let theta = context.get(BestTheta { range: RANGE })?;
    let smooth = |method: &'static str| -> Result<Vec<f64>, StudyError> {
        let runs = smooth::PROBLEMS.map(|problem| smooth::setting(problem, method));
        Ok(context.get_each(runs.into())?.iter().map(|found| found.largest()).collect())
    };
    let (family, rule) = (smooth(FAMILY)?, smooth("trapezoidal")?);
    let ratios = || family.iter().zip(&rule).map(|(a, b)| a / b);
    let drag_h = 0.1;
    let drag = EndErrors { problem: "linear-drag".into(), h: drag_h, t_end: END, ..after_jump("conventional") };
    let growth = context.get(drag)?.end;
    evidence.checks.extend([
        Check::new(
            "methods/method-ii-linear",
            "On v̇ = −v the step of Method II is the trapezoidal rule's: largest difference",
            apart.iter().copied().largest(),
            Requirement::AtMost(16.0 * f64::EPSILON),
            "five step sizes from 0.01 to 100; a few roundings of a number below 1",
        ),
        Check::within(
            "methods/method-ii-channel",
            "After a jump in a channel Method II has the error of the trapezoidal rule: their ratio",
            ringing[1] / ringing[2],
            [1.0 - 1e-6, 1.0 + 1e-6],
            "the same steps, found from matrices whose condition is the square of the trapezoidal rule's",
        ),
        Check::new(
            "methods/method-ii-rings",
            "That error is more than ten times Method I's: ratio",
            ringing[1] / ringing[0],
            Requirement::Above(10.0),
            "ten steps after the wall is set in motion",
        ),
        Check::within(
            "methods/method-ii-lost",
            "On v̇ = −v² from v₀ = 1 the branch of a step of Method II ends at this h",
            lost,
            [1.0 - 1e-6, 1.0 + 1e-6],
            "the quadratic for v₁ has no real root for hv₀ > 1; the search stops within a millionth",
        ),
        Check::new(
            "methods/family-best",
            "The best constant of the family has a smaller largest error of a step than Method I: ratio",
            theta.best / theta.method_i,
            Requirement::Below(1.0),
            "v̇ = −v, h up to 3",
        ),
        Check::new(
            "methods/family",
            "On smooth problems the family's closure is behind the trapezoidal rule on some problem: largest ratio of the errors",
            ratios().largest(),
            Requirement::Above(1.0),
            "equal steps",
        ),
        Check::new(
            "methods/conventional",
            "The position–momentum form leaves a decaying solution: its error over the initial state",
            growth,
            Requirement::Above(1.0),
            "v̇ = −v from 1, h = 0.1",
        ),
    ]);
    let values = [
        ("ringing", brief(ringing[1] / ringing[0])),
        ("lost", brief(lost)),
        ("range", RANGE.to_string()),
        ("best", brief(theta.best / theta.method_i)),
        ("problems", smooth::COUNT.into()),
        ("family", between(ratios().smallest(), ratios().largest())),
        ("growth", brief(growth)),
        ("growth_h", drag_h.to_string()),
        ("end", END.to_string()),
        ("over_tr_bdf2", parabolic::radau_leads_from(context, "tr-bdf2")?.to_string()),
        ("over_sdirk2", parabolic::radau_leads_from(context, "sdirk2")?.to_string()),
    ];
    let rows =
        prose::fill(include_str!("methods.md"), &values)?.iter().map(|text| row(text)).collect::<Result<_, _>>()?;
    let caption = "The methods that the answers recommend or advise against; `verify list methods` has all. Order and damping of stiff components are those to which \
                   the runs of the report are held; of integrators of mechanics the latter is not asked. CVODE (SUNDIALS) and diffsol are solvers of other libraries, the references here.";
    evidence.tables.push(Table::new(ID, caption, ["name", "what it is", "order", "stiff components", "use it?"], rows));
    evidence.sections.push(Section {
        id: "answer-methods".into(),
        title: "Which name is which method, and should I use it?".into(),
        tables: vec![ID.into()],
        ..Section::default()
    });
    Ok(())
}

/// `name: what it is | whether to use it`, with what the method itself says between.
fn row(text: &str) -> Result<Vec<Cell>, StudyError> {
    let parts = text.split_once(": ").and_then(|(name, rest)| Some((name, rest.split_once(" | ")?)));
    let (name, (what, usage)) = parts.ok_or("a method has a name, a description and a use")?;
    let method = method::parse(name)?;
    let decay = match (method.principle(), method.stability()) {
        (Principle::Hamilton, _) => "",
        (_, Stability::Damping) => "damped to zero",
        (_, Stability::Neutral) => "not damped to zero",
        (_, Stability::Conditional) => "stable for small steps",
        (_, Stability::Unstable) => "grows",
    };
    let text = |text: &str| Cell::Text(text.into());
    let order = match method.traits().highest_order {
        Some(highest) => text(&format!("{} to {highest}", method.order())),
        None => Cell::Integer(method.order().into()),
    };
    Ok(vec![text(&format!("`{name}`")), text(what), order, text(decay), text(usage)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::Symplecticity;

    /// What the table says of symplecticity, and of what damps, is what the methods are held to.
    #[test]
    fn the_advice_agrees_with_the_traits() {
        let symplecticity = |name: &str| method::parse(name).expect("known").traits().symplectic;
        assert_eq!(symplecticity("galerkin-gauss(3)"), Symplecticity::Always);
        assert_eq!(symplecticity("path-fitted(4,gauss)"), Symplecticity::ConstantMass);
        assert_eq!(symplecticity("path-fitted(4)"), Symplecticity::Never);
        let stability = |name: &str| method::parse(name).expect("known").stability();
        for name in ["tr-bdf2", "sdirk2", "ls-galerkin(2,radau,2)", "method-i"] {
            assert_eq!(stability(name), Stability::Damping, "{name}");
        }
        for name in ["method-ii", "trapezoidal"] {
            assert_eq!(stability(name), Stability::Neutral, "{name}");
        }
        assert_eq!(stability("conventional"), Stability::Unstable);
    }
}
