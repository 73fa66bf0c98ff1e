//! The schemes for the pendulum.

use crate::claim::measure::text;
use crate::claim::{Case, Claim, Finding, Quantifier};
use crate::experiment::end_errors::{EndErrors, Truth};
use crate::experiment::motion::Motion;
use crate::experiment::pendulum_orbit::PendulumOrbit;
use crate::experiment::{Context, StudyError};
use crate::measure::norm::{distance, max_norm};
use crate::measure::search;

pub(super) const CLAIMS: &[Claim] = &[Claim {
    id: "KY21-g",
    source: "[KY21] (21), (22), Figure 3",
    statement: "The schemes (21) and (22) simulate the pendulum: they follow the motion and keep the energy.",
    quantifier: Quantifier::Universal,
    criterion: "(21) and (22), solved as printed, give the live trajectory of degree 2 to 10⁻¹⁰ over 100 steps of 0.1; on \
                it the error at t = 10 is of second order to within 0.1, and the energy error on (90, 100] is at most 1.01 \
                times that on (0, 10].",
    decide: schemes,
}];

const TAU: f64 = 0.1;
const STEPS: usize = 100;

/// The root of `f` in [`low`, `high`]; NaN where there is none.
fn root(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    search::root([low, high], f).unwrap_or(f64::NAN)
}

/// (21): η from θ_k and θ_{k+1} by the first equation, where θ_{k+1} follows from the second.
fn lagrange(first: [f64; 2]) -> Vec<f64> {
    let mut theta = first.to_vec();
    // 4/τ² (θ_k − 2η + θ_{k+1}) + sin η = 0 falls with η.
    let inside = |a: f64, b: f64| {
        let middle = 0.5 * (a + b);
        root(middle - 1.0, middle + 1.0, |eta| -(4.0 / (TAU * TAU) * (a - 2.0 * eta + b) + eta.sin()))
    };
    for k in 1..STEPS {
        let (before, now) = (theta[k - 1], theta[k]);
        let bar = inside(before, now);
        let next = root(now - 1.0, now + 1.0, |next| 4.0 * (inside(now, next) + bar) - before - 6.0 * now - next);
        theta.push(next);
    }
    theta
}

/// (22): η̄ by the third equation, η by the second, θ_{k+1} by the first.
fn bernstein(first: [f64; 2]) -> Vec<f64> {
    let mut theta = first.to_vec();
    let balance =
        |a: f64, eta: f64, b: f64| 2.0 / (TAU * TAU) * (a - 2.0 * eta + b) + (0.25 * a + 0.5 * eta + 0.25 * b).sin();
    for k in 1..STEPS {
        let (before, now) = (theta[k - 1], theta[k]);
        let middle = 0.5 * (before + now);
        let bar = root(middle - 1.0, middle + 1.0, |eta| -balance(before, eta, now));
        let eta = 2.0 * now - bar;
        theta.push(root(now - 1.0, now + 1.0, |next| balance(now, eta, next)));
    }
    theta
}

fn schemes(context: &Context) -> Result<Finding, StudyError> {
    let method = "path-fitted(2)";
    let live = context.get(Motion { problem: "pendulum", method: method.into(), h: TAU, t_end: 100.0 })?;
    let angles: Vec<f64> = live.states.iter().take(STEPS + 1).map(|(_, y)| y[0]).collect();
    let [first, second, ..] = angles[..] else { return Err("the run broke off".into()) };
    if angles.len() <= STEPS {
        return Err("the run broke off".into());
    }
    let (mut cases, mut off) = (Vec::new(), Vec::new());
    for (name, printed) in [("(21)", lagrange([first, second])), ("(22)", bernstein([first, second]))] {
        let difference = distance(&printed, &angles);
        off.push(text(difference));
        // A rounding of the angle goes on as a change of momentum: n ε after n steps, and of all of them n²/2 ε; there are two trajectories.
        let roundings = (STEPS * STEPS) as f64 * f64::EPSILON * max_norm(&angles);
        cases.push(Case::below(format!("distance of {name} from the live trajectory"), difference, roundings));
    }
    let error = |h: f64| -> Result<f64, StudyError> {
        let (problem, truth) = ("pendulum".into(), Truth::Solution);
        Ok(context.get(EndErrors { problem, method: method.into(), h, pieces: 1, t_end: 10.0, truth })?.end)
    };
    let order = (error(0.05)? / error(0.025)?).log2();
    cases.push(Case::between("order at t = 10", order, 1.9, 2.1));
    let (early, late) = (live.largest_change("energy", 0.0, 10.0), live.largest_change("energy", 90.0, 100.0));
    cases.push(Case::at_most("late over early energy error", late / early, PendulumOrbit::BOUNDED));
    let evidence = format!(
        "Printed and live schemes differ by {}; the order is {}, the energy error {} early and {} late.",
        off.join(" and "),
        text(order),
        text(early),
        text(late)
    );
    Ok(Finding::on(cases, evidence).because(
        "(21) and (22) are one scheme in two coordinates, path fitting of degree 2; its single node is the Gauss node, and it \
         is symplectic here.",
    ))
}
