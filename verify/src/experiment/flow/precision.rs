//! Error in time of the manufactured cavity, against step size and work.

use super::{Cost, cavity_by, rms};
use crate::experiment::{Context, Experiment, StudyError};

/// Runs of a method with several step sizes.
#[derive(Debug)]
pub(crate) struct FlowPrecision {
    /// The method, or [`PROJECTION`](super::PROJECTION).
    pub(crate) method: &'static str,
    /// Cells along a side.
    pub(crate) cells: usize,
}

impl FlowPrecision {
    /// The Reynolds number: convection matters.
    pub(crate) const RE: f64 = 1000.0;
    /// Steps to t = 1.
    pub(crate) const STEPS: [u32; 5] = [4, 8, 16, 32, 64];
}

/// A run.
#[derive(Debug)]
pub(crate) struct Point {
    pub(crate) h: f64,
    /// Root mean square of the difference from RK4 with small steps on the same grid; nothing where a step failed.
    pub(crate) error: Option<f64>,
    pub(crate) cost: Cost,
}

/// The reference: RK4 with a fourth of the finest step, which is stable on these grids.
#[derive(Debug)]
struct Truth {
    cells: usize,
}

impl Experiment for Truth {
    const ID: &'static str = "flow-precision-truth";
    type Found = Vec<f64>;

    fn measure(&self, _: &Context) -> Result<Vec<f64>, StudyError> {
        let [.., finest] = FlowPrecision::STEPS;
        let steps = 4 * finest;
        Ok(cavity_by("rk4", true, (FlowPrecision::RE, self.cells), (1.0 / f64::from(steps), steps))?.0)
    }
}

impl Experiment for FlowPrecision {
    const ID: &'static str = "flow-precision";
    type Found = Vec<Point>;

    fn measure(&self, context: &Context) -> Result<Vec<Point>, StudyError> {
        context.announce(1);
        let truth = context.get(Truth { cells: self.cells })?;
        let points = Self::STEPS.iter().map(|steps| {
            let h = 1.0 / f64::from(*steps);
            match cavity_by(self.method, true, (Self::RE, self.cells), (h, *steps)) {
                Ok((end, cost)) => Point { h, error: Some(rms(&end, &truth)).filter(|e| e.is_finite()), cost },
                Err(_) => Point { h, error: None, cost: Cost::default() },
            }
        });
        let points = points.collect();
        context.tick();
        Ok(points)
    }
}
