//! Against methods of similar complexity, and against more sophisticated ones of the same kind.

use crate::claim::measure::{sizes, text};
use crate::claim::{Case, Claim, Finding, Quantifier};
use crate::evidence::Table;
use crate::experiment::errors::{Errors, Evaluations, HORIZON};
use crate::experiment::{Context, StudyError};
use crate::row;

use super::{BOTH, FOLD, ahead};

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "S24-n-1",
        source: "[S24] Abstract",
        statement: "Method I is more accurate than methods of similar complexity at equal step size.",
        quantifier: Quantifier::Comparison,
        criterion: "Its largest error on (0, 10] is smaller than that of each of six A-stable one-step or two-step methods up \
                    to second order (trapezoidal rule, implicit midpoint, SDIRK2, TR-BDF2, BDF2, implicit Euler), on linear drag, \
                    quadratic drag and v̇ = −2.5v, the Galerkin equation of Poiseuille flow for the distance from the steady state, with L = ½|v̇ − f|² \
                    and not the Lagrangian (37), which is S24-j; h from 1 to 0.01.",
        decide: |context| against_rivals(context, "method-i"),
    },
    Claim {
        id: "S24-n-2",
        source: "[S24] Abstract",
        statement: "Method II is more accurate than methods of similar complexity at equal step size.",
        quantifier: Quantifier::Comparison,
        criterion: "As for S24-n-1; equal errors do not count as smaller.",
        decide: |context| against_rivals(context, "method-ii"),
    },
    Claim {
        id: "S24-o",
        source: "[S24] Abstract, Sections 2, 4, 5 and 6",
        statement: "Least-squares integrators built from more sophisticated variational integrators are expected to do significantly better.",
        quantifier: Quantifier::General,
        criterion: "With Method I's closure, the Galerkin discrete Lagrangian of degree 2 with three Lobatto nodes has a smaller \
                    largest error on (0, 10] than the trapezoidal one, on linear and quadratic drag at every h tested from 2 to 0.01. The source has no measure \
                    of “significantly”: any smaller error counts.",
        decide: sophisticated,
    },
];

const RIVALS: [&str; 6] = ["trapezoidal", "implicit-midpoint", "sdirk2", "tr-bdf2", "bdf2", "implicit-euler"];
const STEPS: [f64; 6] = [1.0, 0.5, 0.2, 0.1, 0.05, 0.01];
/// How far errors of the same method may be apart, over the error, where they are computed along different ways: each step of a velocity of at most 1 rounds a few times.
fn same(h: f64, error: f64) -> f64 {
    const ROUNDINGS: f64 = 4.0;
    ROUNDINGS * HORIZON / h * f64::EPSILON / error
}

/// A problem of the comparison.
#[derive(Clone, Copy)]
struct Setting {
    name: &'static str,
    problem: &'static str,
}

impl Setting {
    fn run(self, method: &'static str, h: f64) -> Errors {
        Errors::of(self.problem, method, h)
    }
}

const LINEAR: Setting = Setting { name: "linear drag", problem: "linear-drag" };
const QUADRATIC: Setting = Setting { name: "quadratic drag", problem: "quadratic-drag" };
/// The Galerkin equation of Poiseuille flow, for v − γ/2 of v̇ = (5/4)(γ − 2v), v(0) = 0, γ = 2, itself: projections are not compared here, nor
/// the scheme (38) that the paper's Lagrangian gives.
const FASTER: Setting = Setting { name: "v̇ = −2.5v", problem: "linear-drag lambda=2.5 v0=-1" };

fn against_rivals(context: &Context, method: &'static str) -> Result<Finding, StudyError> {
    let (mut cases, mut rows, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    let (mut wins, mut ties) = ([0; RIVALS.len()], [0; RIVALS.len()]);
    let mut beaten = Vec::new();
    for setting in [LINEAR, QUADRATIC, FASTER] {
        let name = setting.name;
        let error = |method, h| setting.run(method, h).largest(context);
        let mut ahead = [0; RIVALS.len()];
        let mut by_step = Vec::new();
        for h in STEPS {
            let mut names = Vec::new();
            let own = error(method, h)?;
            for (i, rival) in RIVALS.into_iter().enumerate() {
                let theirs = error(rival, h)?;
                let case = Case::below(
                    format!("error over that of {rival}, {name}, h = {h}"),
                    own / theirs,
                    1.0 - same(h, theirs),
                )
                .or_else(FOLD)
                .against(rival);
                ahead[i] += usize::from(case.holds());
                names.extend(case.holds().then_some(rival));
                ties[i] += usize::from((own / theirs - 1.0).abs() <= same(h, theirs));
                cases.push(case);
            }
            by_step.push(names);
        }
        // At equal work: all are of second order, so that error × work² does not depend on h when it is small.
        let h = STEPS[STEPS.len() - 1];
        let own = error(method, h)?;
        let work =
            |method| -> Result<f64, StudyError> { Ok(*context.get(Evaluations(setting.run(method, h)))? as f64) };
        for (i, rival) in RIVALS.into_iter().enumerate() {
            wins[i] += ahead[i];
            let theirs = error(rival, h)?;
            let equal_step = own / theirs;
            let equal_work = equal_step * (work(method)? / work(rival)?).powi(2);
            ratios.push([equal_step, equal_work]);
            rows.push(row![name, rival, ahead[i] as f64 / STEPS.len() as f64, equal_step, equal_work]);
        }
        beaten.push((name, by_step));
    }
    let total = cases.len() / RIVALS.len();
    let score: Vec<String> = RIVALS
        .iter()
        .enumerate()
        .map(|(i, rival)| match ties[i] {
            0 => format!("{} of {total} against {rival}", wins[i]),
            n => format!("{} of {total} against {rival} ({n} equal)", wins[i]),
        })
        .collect();
    let evidence = format!("Smaller errors in {}.", score.join(", "));
    let caption = format!(
        "{method} against each rival: the share of the step sizes at which its error is the smaller, and its error divided by \
         the rival's at h = 0.01, at equal step size and at equal work; below 1 it is ahead. Work is counted by the integrators: \
         evaluations of f, in those of a step equation as many as the method has stages; a product Jᵀr counts as one."
    );
    let columns = ["problem", "rival", "share_ahead", "equal_step", "equal_evaluations"];
    let table = Table::new(format!("claims-rivals-{method}"), caption, columns, rows);
    let finding = Finding::on(cases, evidence).with_table(table);
    if method == BOTH[1] {
        return Ok(finding
            .holds_where("On linear problems with an invertible matrix it is the trapezoidal rule; what it wins, that rule wins too.")
            .because("Local error h³/12 on linear problems, the trapezoidal rule's, to the last digits."));
    }
    // On the first problem.
    let [[_, trapezoidal], [_, midpoint], [at_equal_step, sdirk2], [_, tr_bdf2]] = ratios[..4] else {
        return Err("a rival has no ratio".into());
    };
    Ok(finding
        .holds_where(where_ahead(&beaten))
        .because(format!(
            "Its error constant on v̇ = −v is 1/6, twice the trapezoidal rule's 1/12, half of BDF2's 1/3. It damps stiff \
             components, which the trapezoidal rule and the midpoint rule do not. SDIRK2 damps them too; on linear drag Method I \
             has {} times its error at equal step size. At equal numbers of evaluations, as steps are taken here, it has {} times SDIRK2's, {} times TR-BDF2's, {} times the trapezoidal \
             rule's and {} times the midpoint rule's.",
            text(at_equal_step),
            text(sdirk2),
            text(tr_bdf2),
            text(trapezoidal),
            text(midpoint)
        )))
}

/// The rivals that are beaten everywhere, then the others by problem and step: `beaten[i][j]` are those of the problem i and
/// the step j.
fn where_ahead(beaten: &[(&str, Vec<Vec<&str>>)]) -> String {
    let everywhere = |rival: &&str| beaten.iter().all(|(_, by_step)| by_step.iter().all(|names| names.contains(rival)));
    let (always, others): (Vec<&str>, Vec<&str>) = RIVALS.iter().partition(|rival| everywhere(rival));
    let mut parts = Vec::new();
    for (problem, by_step) in beaten {
        let mut at = Vec::new();
        let rest = |names: &[&str]| others.iter().copied().filter(|name| names.contains(name)).collect::<Vec<_>>();
        for same in by_step.iter().map(|names| rest(names)).zip(STEPS).collect::<Vec<_>>().chunk_by(|a, b| a.0 == b.0) {
            let (names, steps) = (&same[0].0, same.iter().map(|(_, h)| h.to_string()).collect::<Vec<_>>());
            let whom = if names.len() == others.len() { "all".into() } else { names.join(" and ") };
            at.extend((!names.is_empty()).then(|| format!("at h = {} against {whom}", steps.join(", "))));
        }
        parts.extend((!at.is_empty()).then(|| format!("on {problem} {}", at.join(" and "))));
    }
    format!("At every step tested against {}; {}.", always.join(" and "), parts.join("; "))
}

/// Method I's closure on the Galerkin discretisation of degree 2 with three Lobatto nodes.
const DEGREE_2: &str = "ls-galerkin(2,lobatto,3)";

fn sophisticated(context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut sentences) = (Vec::new(), Vec::new());
    for setting in [LINEAR, QUADRATIC] {
        let own = |h| setting.run(BOTH[0], h).largest(context);
        let galerkin = |h| setting.run(DEGREE_2, h).largest(context);
        for h in [2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.01] {
            let what = format!("largest error of degree 2, {}, h = {h}, against Method I", setting.name);
            // Steps that resolve the time scale, 1 for both.
            cases.push(Case::below(what, galerkin(h)?, own(h)?).under(h <= 0.5));
        }
        let order = (galerkin(0.1)? / galerkin(0.05)?).log2();
        sentences.push(format!(
            "on {} the error at h = 0.1 is {} instead of {}, falling with order {}",
            setting.name,
            text(galerkin(0.1)?),
            text(own(0.1)?),
            text(order)
        ));
    }
    let evidence = format!("With degree 2, {}.", sentences.join("; "));
    const BETWEEN: [f64; 2] = [0.01, 2.0];
    let of = |setting: Setting| -> Result<String, StudyError> {
        Ok(sizes("h", &ahead(context, setting.problem, [DEGREE_2, BOTH[0]], 1.0, BETWEEN)?, BETWEEN))
    };
    Ok(Finding::on(cases, evidence)
        .holds_where(format!(
            "At steps of up to half the time scale of the two problems. Of all steps from {} to {}, scanned, it holds on linear drag at {} and on quadratic drag at {}.",
            BETWEEN[0],
            BETWEEN[1],
            of(LINEAR)?,
            of(QUADRATIC)?
        ))
        .because(
            "A path of degree s with s + 1 Lobatto nodes is of order 2s under the same closure, at s times the unknowns; a higher order is worth \
             its price where the steps resolve the time scale.",
        ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of v̇ = −v at h = 0.01, where another program with the same two formulas came to errors 1.5e-9 apart, in units of them.
    #[test]
    fn errors_of_one_method_are_the_same_up_to_the_roundings_of_its_steps() {
        let (h, error) = (0.01, 3.0657e-6);
        assert!(same(h, error) > 1.5e-9 && same(h, error) < 1e-6, "{}", same(h, error));
        // Fewer steps round less.
        assert!(same(1.0, 0.03) < 1e-12);
    }

    #[test]
    fn what_is_left_of_a_comparison_names_every_win_once() {
        let always = ["bdf2", "implicit-euler"];
        let with = |more: &[&'static str]| [more, &always].concat();
        let [none, one] = [with(&[]), with(&["trapezoidal"])];
        let all = with(&["trapezoidal", "implicit-midpoint", "sdirk2", "tr-bdf2"]);
        let first = vec![all.clone(), all, one.clone(), one.clone(), one.clone(), none.clone()];
        let beaten = [("drag", first), ("flow", vec![none.clone(); 6])];
        assert_eq!(
            where_ahead(&beaten),
            "At every step tested against bdf2 and implicit-euler; on drag at h = 1, 0.5 against all and at h = 0.2, 0.1, 0.05 against trapezoidal."
        );
    }
}
