//! The one-shape-function Poiseuille flow in closed form.

use lsvi::quadrature::Quadrature;

use super::{Context, Study, StudyError, prose};
use crate::evidence::{Check, Evidence, number};
use crate::experiment::ansatz_step::{AnsatzStep, Closed};
use crate::measure::norm::max_norm;
use crate::problem::{self, PoiseuilleAnsatz, Problem, poiseuille_series};

pub(super) const STUDY: Study = Study {
    id: "poiseuille-maps",
    title: "Poiseuille flow with one shape function in closed form",
    question: "Are the Lagrangian, the two maps, their steady limit and the two reduced equations what the paper says?",
    source: "[S24] Eqs. (33), (35)–(41)",
    run,
};

/// γ, v_n and h of the samples: both sides of the steady state, and steps from 1e-6 to 1e6.
fn samples() -> impl Iterator<Item = (f64, f64, f64)> {
    let states = [(2.0, 0.0), (2.0, 0.37), (2.0, 1.0), (2.0, 1.9), (-0.7, 0.3), (0.0, 1.1), (13.0, -4.0)];
    let sizes = || (-24..=24).map(|k| 10_f64.powf(f64::from(k) / 4.0));
    states.into_iter().flat_map(move |(gamma, v)| sizes().map(move |h| (gamma, v, h)))
}

/// A map of the paper, and h times the step equation that it solves: its derivative, and how much of ∂L/∂v̇ there is in it.
struct Map {
    id: &'static str,
    statement: &'static str,
    closure: Closed,
    printed: fn(f64, f64, f64) -> f64,
    slope: fn(f64) -> f64,
    momentum: f64,
}

impl Map {
    /// Roundoff of a live step: twelve roundings of ε/2 of the terms of h times the step equation, and as many of the map,
    /// over the derivative. With e = 2v − γ, the terms are (16/15)Δv and (2/3)h e from the momentum, 4h²e and (8/3)hΔv from
    /// h ∂L/∂v.
    fn roundoff(&self, gamma: f64, h: f64, (v0, v1): (f64, f64)) -> f64 {
        let (v, e) = (v0.abs() + v1.abs(), 2.0 * (2.0 * v0.abs().max(v1.abs()) + gamma.abs()));
        let momentum = self.momentum * (16.0 / 15.0 * v + 2.0 / 3.0 * h * e);
        12.0 * f64::EPSILON * (momentum + h * (4.0 * h * e + 8.0 / 3.0 * v)) / (self.slope)(h)
    }

    /// The difference between a live step and the printed map in units of its bound.
    fn deviation(&self, context: &Context, gamma: f64, v: f64, h: f64) -> Result<f64, StudyError> {
        let live = *context.get(AnsatzStep { closure: self.closure, gamma, v, h })?;
        Ok((live - (self.printed)(gamma, h, v)).abs() / self.roundoff(gamma, h, (v, live)))
    }

    fn check(&self, context: &Context) -> Result<Check, StudyError> {
        let deviations = samples().map(|(gamma, v, h)| self.deviation(context, gamma, v, h));
        let deviations = deviations.collect::<Result<Vec<_>, _>>()?;
        let count = deviations.len();
        let reason = format!("In units of its roundoff bound, the largest of {count} steps, h from 1e-6 to 1e6.");
        Ok(Check::at_most(self.id, self.statement, max_norm(&deviations), 1.0, reason))
    }
}

const MAPS: [Map; 2] = [
    Map {
        id: "method-i",
        statement: "Method I is the map (38)",
        closure: Closed::MethodI,
        printed: |g, h, v| {
            (8.0 / 15.0 * v + g * h * h + 2.0 / 3.0 * g * h) / (8.0 / 15.0 + 2.0 * h * h + 4.0 / 3.0 * h)
        },
        slope: |h| 2.0 * (8.0 / 15.0 + 2.0 * h * h + 4.0 / 3.0 * h),
        momentum: 1.0,
    },
    Map {
        id: "method-ii",
        statement: "Method II is the map (40)",
        closure: Closed::MethodII,
        printed: |g, h, v| ((1.0 - 1.5 * h) * v + 1.5 * g * h) / (1.0 + 1.5 * h),
        slope: |h| 8.0 / 3.0 * h * (1.0 + 1.5 * h),
        momentum: 0.0,
    },
];

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let mut checks = MAPS.iter().map(|map| map.check(context)).collect::<Result<Vec<_>, _>>()?;
    checks.extend([steady_limit(context)?, steady_profile(context)?, lagrangian()?]);
    for (id, weight, equation) in [
        ("averaged", (|_| 1.0) as fn(f64) -> f64, "v̇ = (3/2)(γ − 2v), Eq. (41), is ∫R̂ dy = 0"),
        ("galerkin", |y| 1.0 - y * y, "v̇ = (5/4)(γ − 2v) is ∫R̂(1 − y²) dy = 0"),
    ] {
        checks.push(projection(id, weight, equation)?);
    }
    for (id, closure, slope, statement) in [
        ("method-i-rate", Closed::MethodI, 1.25, "Method I tends to the Galerkin equation"),
        ("method-ii-rate", Closed::MethodII, 1.5, "Method II tends to the averaged equation (41)"),
    ] {
        checks.push(rate(context, id, closure, slope, statement)?);
    }
    let flow = number::short(poiseuille_series::SLOWEST_DECAY_RATE);
    Ok(Evidence {
        checks,
        notes: prose::fill(include_str!("poiseuille_maps.md"), &[("flow", flow)])?,
        ..Evidence::default()
    })
}

/// Eq. (39): what one step of Method I leaves of the distance to ½γ is 1/(1 + 5h/2 + 15h²/4).
fn steady_limit(context: &Context) -> Result<Check, StudyError> {
    let (gamma, v, mut ratios) = (2.0, 0.37, Vec::new());
    for h in [1e2, 1e4, 1e6, 1e8, 1e10] {
        let live = *context.get(AnsatzStep { closure: Closed::MethodI, gamma, v, h })?;
        let left = (v - 0.5 * gamma).abs() / (3.75 * h * h);
        ratios.push((live - 0.5 * gamma).abs() / (left + 4.0 * f64::EPSILON));
    }
    Ok(Check::at_most(
        "steady-limit",
        "as h → ∞ one step of Method I reaches ½γ, Eq. (39), with 4/(15h²) of the distance left",
        max_norm(&ratios),
        1.0,
        "Largest distance for h from 1e2 to 1e10, in units of 4/(15h²) and four roundings.",
    ))
}

/// The profile that this limit belongs to is the steady flow.
fn steady_profile(context: &Context) -> Result<Check, StudyError> {
    let gamma = 2.0;
    let v = *context.get(AnsatzStep { closure: Closed::MethodI, gamma, v: 0.0, h: 1e9 })?;
    let mut differences = Vec::new();
    for k in 0..=40 {
        let y = f64::from(k) / 20.0 - 1.0;
        differences.push(v * (1.0 - y * y) - poiseuille_series::steady(gamma, y)?);
    }
    Ok(Check::at_most(
        "steady-profile",
        "v(1 − y²) is then the steady profile ½γ(1 − y²), the t → ∞ limit of the series (34)",
        max_norm(&differences),
        8.0 * f64::EPSILON,
        "Largest difference at 41 points; v and both profiles are rounded a few times.",
    ))
}

/// ∫ g(y) dy over the channel by four-point Gauss quadrature, exact to degree 7.
fn over_channel(g: impl Fn(f64) -> f64) -> Result<f64, StudyError> {
    let rule = Quadrature::gauss(4)?;
    Ok(rule.nodes().iter().zip(rule.weights()).map(|(c, b)| 2.0 * b * g(2.0 * c - 1.0)).sum())
}

/// R̂(y), Eq. (36).
fn residual(gamma: f64, v: f64, rate: f64, y: f64) -> f64 {
    -gamma + 2.0 * v + rate * (1.0 - y * y)
}

fn lagrangian() -> Result<Check, StudyError> {
    let mut ratios = Vec::new();
    for (gamma, v, rate) in samples().filter(|(.., rate)| *rate <= 1e3) {
        let closed = PoiseuilleAnsatz::from_rest(gamma).lagrangian()?.value(0.0, &[v], &[rate]);
        let quadrature = over_channel(|y| 0.5 * residual(gamma, v, rate, y).powi(2))?;
        let terms = (gamma.abs() + 2.0 * v.abs() + rate).powi(2);
        ratios.push((closed - quadrature).abs() / (16.0 * f64::EPSILON * terms));
    }
    Ok(Check::at_most(
        "lagrangian",
        "the Lagrangian (37) is ∫½R̂² dy with the residual (36)",
        max_norm(&ratios),
        1.0,
        "In units of sixteen roundings of the largest terms, by quadrature that is exact for the quartic.",
    ))
}

/// The reduced equation makes its projection of the residual vanish.
fn projection(id: &str, weight: fn(f64) -> f64, equation: &str) -> Result<Check, StudyError> {
    let mut ratios = Vec::new();
    for (gamma, v, _) in samples() {
        let set = [("gamma", gamma.to_string()), ("reduction", id.to_owned())].map(|(k, x)| (k.to_owned(), x));
        let problem = problem::build("poiseuille-ansatz", &set)?;
        let mut rate = [0.0];
        problem.field().rhs(0.0, &[v], &mut rate);
        let projected = over_channel(|y| residual(gamma, v, rate[0], y) * weight(y))?;
        ratios.push(projected / (16.0 * f64::EPSILON * (gamma.abs() + 2.0 * v.abs())));
    }
    Ok(Check::at_most(
        format!("{id}-equation"),
        equation,
        max_norm(&ratios),
        1.0,
        "In units of sixteen roundings of its terms, by quadrature.",
    ))
}

/// (v_{n+1} − v_n)/h tends to `slope` (γ − 2v_n) with h.
fn rate(context: &Context, id: &str, closure: Closed, slope: f64, statement: &str) -> Result<Check, StudyError> {
    let (gamma, v, h) = (2.0, 0.37, 1e-5);
    let measured = (*context.get(AnsatzStep { closure, gamma, v, h })? - v) / h / (gamma - 2.0 * v);
    // v̈ = −2·slope·v̇: half of h|v̈| is slope·h relative to v̇, doubled for the error of the step itself; and ε|v|/h.
    let allowed = 2.0 * slope * slope * h + 4.0 * f64::EPSILON / h;
    Ok(Check::within(
        id,
        format!("{statement}: (v_{{n+1}} − v_n)/h → {slope} (γ − 2v_n)"),
        measured,
        [slope - allowed, slope + allowed],
        "One live step of h = 1e-5; the width is the step's curvature and roundoff.",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Eqs. (38), (40).
        #[test]
        fn a_step_is_the_printed_map(gamma in 0.01..10.0_f64, v in -5.0..5.0_f64, log_h in -6.0..6.0_f64) {
            let context = Context::silent();
            for map in &MAPS {
                let deviation = map.deviation(&context, gamma, v, 10_f64.powf(log_h)).expect("linear");
                prop_assert!(deviation <= 1.0, "{}: {deviation}", map.id);
            }
        }
    }
}
