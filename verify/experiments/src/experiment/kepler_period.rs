//! Error and work of one period of Kepler's problem, eccentricity 0.6.

use std::f64::consts::TAU;

use lsvi::Work;

use super::{Context, Experiment, StudyError};
use crate::measure::norm::distance;
use crate::method;
use crate::problem;
use crate::run::run;

/// One period in equal steps.
#[derive(Debug, Clone)]
pub struct KeplerPeriod {
    /// The method.
    pub method: String,
    /// Steps.
    pub steps: u32,
}

/// What it takes and what it gives.
#[derive(Debug)]
pub struct Found {
    /// The work.
    pub work: Work,
    /// The largest error of a position or momentum at the end.
    pub error: f64,
}

impl Experiment for KeplerPeriod {
    const ID: &'static str = "kepler-period";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        context.announce(1);
        let kepler = problem::build_setting("kepler")?;
        let run = run(&*kepler, &*method::parse(&self.method)?, TAU / f64::from(self.steps), TAU, |_| {})?;
        let exact = kepler.exact(TAU).ok_or("no exact solution is known")?;
        context.tick();
        Ok(Found { work: run.work, error: distance(&run.end.q, &exact) })
    }
}
