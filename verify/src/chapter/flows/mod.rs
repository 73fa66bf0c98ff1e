//! Two-dimensional Navier–Stokes: what the family does on real flows.

mod balance;
mod cavity;
mod lid;
mod orders;
mod profile;

use super::{Context, Study, StudyError};
use crate::evidence::Evidence;
use crate::evidence::number::short;
use crate::measure::order::Expectation;
use crate::method::{self, Method};
use crate::problem::{self, Problem};
use crate::run::run;

pub(super) const STUDY: Study = Study {
    id: "flows",
    title: "Two-dimensional flows",
    question: "What do the least-squares integrators do on the Navier–Stokes equations: which answers are right, where do they \
               lose to TR-BDF2, and where do their large steps pay?",
    source: "[S24] title and Section 5; claims b, h, n",
    run: |context| study(context, &SMALL),
};

pub(super) const FULL: Study = Study {
    id: "flows-full",
    title: "Two-dimensional flows on fine grids",
    question: "Does what holds on coarse grids hold on the grids of the literature: cavity to 128², periodic flows to 128²?",
    source: STUDY.source,
    run: |context| study(context, &LARGE),
};

/// How large the grids are.
struct Scale {
    /// Cells of the two grids on which orders in (h, Δx) are measured.
    refinement: [usize; 2],
    /// Cells of the impulsively started cavity.
    lid: usize,
    /// Reynolds numbers and cells of the steady cavity: the last two grids are extrapolated.
    steady: &'static [(f64, [usize; 3])],
    /// Grid points of the periodic flows.
    points: usize,
    /// Cells of the cavity that CVODE solves as well.
    reference: usize,
}

const SMALL: Scale =
    Scale { refinement: [12, 24], lid: 20, steady: &[(100.0, [16, 32, 64])], points: 32, reference: 12 };

const LARGE: Scale = Scale {
    refinement: [24, 48],
    lid: 32,
    steady: &[(100.0, [32, 64, 128]), (400.0, [32, 64, 128]), (1000.0, [32, 64, 128])],
    points: 64,
    reference: 24,
};

/// Adds what it finds at a scale.
type Part = fn(&mut Evidence, &Scale) -> Result<(), StudyError>;

fn study(context: &Context, scale: &Scale) -> Result<Evidence, StudyError> {
    let parts: [Part; 6] =
        [orders::in_time, orders::in_time_and_space, balance::study, lid::study, cavity::steady, cavity::cross_check];
    context.announce(parts.len());
    let mut evidence = Evidence::default();
    for part in parts {
        part(&mut evidence, scale)?;
        context.tick();
    }
    Ok(evidence)
}

/// The observed values of a run at its end.
fn observed(problem: &dyn Problem, method: &dyn Method, h: f64, end: f64) -> Result<Vec<f64>, StudyError> {
    let state = run(problem, method, h, end, |_| {})?.end;
    Ok(problem.observe(end, &state.q))
}

/// Root mean square of a difference: the norm of the energy.
fn rms(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / a.len() as f64).sqrt()
}

fn setting(text: &str) -> Result<Box<dyn Problem>, StudyError> {
    Ok(problem::build_setting(text)?)
}

fn named(text: &str) -> Result<Box<dyn Method>, StudyError> {
    Ok(method::parse(text)?)
}

/// The nominal order of a method with a tenth to either side.
fn nominal(method: &dyn Method) -> Expectation {
    Expectation::new(f64::from(method.order()), 0.1)
}

/// Legend entries of the bands between `levels`.
fn bands(levels: &[f64]) -> Vec<String> {
    let below = levels.first().map(|l| format!("below {}", short(*l)));
    let above = levels.last().map(|l| format!("above {}", short(*l)));
    let between = levels.windows(2).map(|pair| format!("{} to {}", short(pair[0]), short(pair[1])));
    below.into_iter().chain(between).chain(above).collect()
}
