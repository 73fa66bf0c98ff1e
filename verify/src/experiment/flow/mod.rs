//! Two-dimensional flows.

pub(crate) mod against_cvode;
pub(crate) mod approach;
pub(crate) mod cost;
pub(crate) mod lid;
pub(crate) mod order;
pub(crate) mod periodic;
pub(crate) mod precision;
pub(crate) mod profile;
mod projection;
pub(crate) mod propagator;
pub(crate) mod refinement;
pub(crate) mod steady;

use std::time::Instant;

use lsvi::Work;

use super::StudyError;
use crate::method::{self, Method};
use crate::problem::{self, Problem, flow};
use crate::run::run;
use projection::Projection;

/// The name of the scheme in [`projection`] among those of methods.
pub(crate) const PROJECTION: &str = "pressure-correction";

/// What a run costs.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Cost {
    /// Solutions of linear systems of the size of the flow: by conjugate gradients in Gauss–Newton steps, with factors elsewhere.
    pub(crate) solves: u64,
    /// Products and solutions inside of those.
    pub(crate) inner: u64,
    /// Evaluations of the equations of a step, with one of f each.
    pub(crate) residuals: u64,
    /// Measured once, beside other computations.
    pub(crate) seconds: f64,
}

fn setting(text: &str) -> Result<Box<dyn Problem>, StudyError> {
    Ok(problem::build_setting(text)?)
}

fn named(text: &str) -> Result<Box<dyn Method>, StudyError> {
    Ok(method::parse(text)?)
}

fn cavity(re: f64, cells: usize) -> Result<Box<dyn Problem>, StudyError> {
    setting(&format!("cavity re={re} cells={cells}"))
}

/// The observed values of a run at its end.
fn observed(problem: &dyn Problem, method: &dyn Method, h: f64, end: f64) -> Result<(Vec<f64>, Cost), StudyError> {
    let run = run(problem, method, h, end, |_| {})?;
    let Work { factorizations, inner, residuals, .. } = run.work;
    let cost = Cost { solves: factorizations, inner, residuals, seconds: run.seconds };
    Ok((problem.observe(end, &run.end.q), cost))
}

/// The velocities at the end of `steps` steps of size h in a cavity: of the method of that name, or of pressure correction.
fn cavity_by(
    method: &str,
    is_manufactured: bool,
    (re, cells): (f64, usize),
    (h, steps): (f64, u32),
) -> Result<(Vec<f64>, Cost), StudyError> {
    let name = if is_manufactured { "cavity-manufactured" } else { "cavity" };
    let problem = setting(&format!("{name} re={re} cells={cells}"))?;
    if method != PROJECTION {
        return observed(&*problem, &*named(method)?, h, f64::from(steps) * h);
    }
    let given: Box<dyn flow::Given> =
        if is_manufactured { Box::new(flow::manufactured(1.0 / re)) } else { Box::new(flow::lid()) };
    let clock = Instant::now();
    let mut scheme = Projection::new(cells, 1.0 / re, &*given, &problem.observe(0.0, &problem.initial()));
    (0..steps).for_each(|_| scheme.step(h));
    // Two components and the pressure.
    let solves = 3 * u64::from(steps);
    let cost = Cost { solves, seconds: clock.elapsed().as_secs_f64(), ..Cost::default() };
    Ok((scheme.faces(), cost))
}

/// Root mean square of a difference: the norm of the energy.
pub(crate) fn rms(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / a.len() as f64).sqrt()
}
