//! Seconds of a step by the size of the grid.

use super::{named, setting};
use crate::experiment::{Context, Experiment, StudyError};
use crate::run::run;

/// A few steps of Method I.
#[derive(Debug)]
pub(crate) struct StepCost {
    /// The flow with its parameters.
    pub(crate) flow: &'static str,
    /// Cells, or grid points, along a side.
    pub(crate) cells: usize,
    pub(crate) h: f64,
}

/// Measured once.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) unknowns: usize,
    /// With what is set up for all steps.
    pub(crate) first: f64,
    /// Each of the next.
    pub(crate) next: f64,
    /// Gauss–Newton iterations of each of the next.
    pub(crate) iterations: f64,
    /// Inner iterations of each of those.
    pub(crate) inner: f64,
}

/// Steps after the first.
const NEXT: u32 = 4;

impl Experiment for StepCost {
    const ID: &'static str = "step-cost";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        context.announce(1);
        let problem = setting(&format!("{} cells={}", self.flow, self.cells))?;
        let method = named("method-i")?;
        let one = run(&*problem, &*method, self.h, self.h, |_| {})?;
        let all = run(&*problem, &*method, self.h, f64::from(1 + NEXT) * self.h, |_| {})?;
        context.tick();
        let iterations = (all.work.residuals - one.work.residuals) as f64;
        Ok(Found {
            unknowns: one.end.q.len(),
            first: one.seconds,
            next: (all.seconds - one.seconds) / f64::from(NEXT),
            iterations: iterations / f64::from(NEXT),
            inner: (all.work.inner - one.work.inner) as f64 / iterations,
        })
    }
}
