//! Work against error of methods here and of the solvers of other libraries.

use std::time::Instant;

use lsvi::adaptive::Tolerances;

use super::{Context, Experiment, StudyError};
use crate::kinds::Principle;
use crate::measure::norm::distance;
use crate::method::{self, Method};
use crate::problem::{self, Problem};
use crate::reference::{self, Reference, ReferenceError};
use crate::run::{Run, run};

/// Methods with fixed steps.
const FIXED: [&str; 5] = ["method-i", "trapezoidal", "tr-bdf2", "ls-galerkin(2,radau,2)", "ls-galerkin(2,gauss,2)"];

/// Steps in a run.
const STEPS: [u32; 7] = [8, 16, 32, 64, 128, 256, 512];

/// Every solver on one problem.
#[derive(Debug)]
pub struct Peers {
    /// The problem with its parameters.
    pub problem: &'static str,
    /// The end.
    pub horizon: f64,
    /// Whether up to 512 fixed steps resolve it.
    pub fixed: bool,
}

/// What is found.
#[derive(Debug)]
pub struct Found {
    /// The runs of one solver after the other.
    pub points: Vec<Point>,
    /// Why solvers are absent.
    pub absent: Vec<String>,
}

/// One run.
#[derive(Debug)]
pub struct Point {
    /// The method or solver.
    pub solver: String,
    /// Whether it is one of another library.
    pub is_peer: bool,
    /// Step size or tolerance.
    pub setting: f64,
    /// Steps, evaluations, factorizations.
    pub counts: [u64; 3],
    /// The error at the end.
    pub error: f64,
    /// Of one run, beside others.
    pub seconds: f64,
}

impl Experiment for Peers {
    const ID: &'static str = "peers";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        context.announce(1);
        let found = points(&*problem::build_setting(self.problem)?, self.horizon, self.fixed);
        context.tick();
        found
    }
}

fn points(problem: &dyn Problem, horizon: f64, fixed: bool) -> Result<Found, StudyError> {
    let limit = problem.limit(Principle::MomentumZero);
    let truth = (limit.exact)(horizon).or_else(|| problem.tabulated(horizon)).ok_or("the solution is known")?;
    let mut points = Vec::new();
    for name in FIXED.iter().filter(|_| fixed) {
        for steps in STEPS {
            let h = horizon / f64::from(steps);
            points.push(own(problem, &*method::parse(name)?, h, (h, horizon), &truth)?);
        }
    }
    let tolerances: Vec<f64> = (6..=18).map(|k| 10_f64.powf(-0.5 * f64::from(k))).collect();
    for tolerance in &tolerances {
        let adaptive = method::parse("radau-adaptive")?.with_tolerances(Tolerances::new(*tolerance, *tolerance)?);
        let method = adaptive.ok_or("it is adaptive")?;
        points.push(own(problem, &*method, *tolerance, (horizon, horizon), &truth)?);
    }
    let mut absent = Vec::new();
    for reference in reference::all().into_iter().filter(|reference| reference.stiff_ok()) {
        for tolerance in &tolerances {
            match peer(reference, problem, horizon, *tolerance, &truth) {
                Ok(point) => points.push(point),
                Err(error @ ReferenceError::Unavailable(_)) => {
                    absent.push(error.to_string());
                    break;
                }
                Err(error) => return Err(error.into()),
            }
        }
    }
    Ok(Found { points, absent })
}

/// A run with steps of h up to the horizon, under the name of the method.
fn own(
    problem: &dyn Problem,
    method: &dyn Method,
    setting: f64,
    (h, horizon): (f64, f64),
    truth: &[f64],
) -> Result<Point, StudyError> {
    let Run { end, work, seconds } = run(problem, method, h, horizon, |_| {})?;
    let counts = [work.steps, work.residuals, work.factorizations];
    Ok(Point { solver: method.name(), is_peer: false, setting, counts, error: distance(&end.q, truth), seconds })
}

fn peer(
    reference: &dyn Reference,
    problem: &dyn Problem,
    horizon: f64,
    tolerance: f64,
    truth: &[f64],
) -> Result<Point, ReferenceError> {
    let limit = problem.limit(Principle::MomentumZero);
    let begun = Instant::now();
    let run = reference.run(limit.ode, 0.0, &limit.initial, &[horizon], tolerance)?;
    let error = run.states.last().map_or(f64::NAN, |state| distance(state, truth));
    let counts = [run.work.steps, run.work.rhs, run.work.factorizations];
    let seconds = begun.elapsed().as_secs_f64();
    Ok(Point { solver: reference.name().into(), is_peer: true, setting: tolerance, counts, error, seconds })
}
