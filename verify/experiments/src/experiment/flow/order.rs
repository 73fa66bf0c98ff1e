//! Orders in time on a fixed grid: what the grid leaves of a flow is an equation with a solution of its own.

use super::{Cost, PROJECTION, cavity_by, named, observed, rms, setting};
use crate::experiment::{Context, Experiment, StudyError};

/// Runs with steps halved three times, on a flow with its parameters.
#[derive(Debug)]
pub struct FlowOrder {
    /// The flow with its parameters.
    pub flow: &'static str,
    /// The method, or [`PROJECTION`] on a manufactured cavity.
    pub method: &'static str,
}

/// Cells of the manufactured cavity, whose Reynolds number is 10.
pub const CELLS: usize = 6;
/// That cavity.
pub const CAVITY: &str = "cavity-manufactured cells=6";
/// The end of the runs.
pub const END: f64 = 0.25;
/// Steps to the end, doubled three times: so short that the rates of the grid, 8ν/Δx², are resolved, and the third order that every
/// method leaves beside its second is small.
pub const STEPS: [u32; 4] = [32, 64, 128, 256];

/// What halving does.
#[derive(Debug)]
pub struct Found {
    /// Root mean squares of the differences between neighbouring step sizes.
    pub differences: Vec<f64>,
    /// The order that the last two give.
    pub order: f64,
    /// The order that the method claims.
    pub nominal: f64,
    /// Of the run with the finest steps.
    pub cost: Cost,
    /// Velocities or vorticities at its end.
    pub end: Vec<f64>,
}

impl Experiment for FlowOrder {
    const ID: &'static str = "flow-order";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        context.announce(1);
        let is_projection = self.method == PROJECTION;
        let mut ends = Vec::new();
        for steps in STEPS {
            let h = END / f64::from(steps);
            ends.push(if is_projection {
                cavity_by(PROJECTION, true, (10.0, CELLS), (h, steps))?
            } else {
                observed(&*setting(self.flow)?, &*named(self.method)?, h, END)?
            });
        }
        let differences: Vec<f64> = ends.windows(2).map(|pair| rms(&pair[0].0, &pair[1].0)).collect();
        let nominal = if is_projection { 2.0 } else { f64::from(named(self.method)?.order()) };
        let (end, cost) = ends.pop().ok_or("no run")?;
        context.tick();
        let order = (differences[differences.len() - 2] / differences[differences.len() - 1]).log2();
        Ok(Found { order, differences, nominal, cost, end })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_order_is_that_of_the_shortest_steps() {
        let found = FlowOrder { flow: CAVITY, method: "implicit-euler" }.measure(&Context::quick()).expect("it runs");
        let [_, before, last] = *found.differences else { panic!("{found:?}") };
        assert_eq!((found.order, found.nominal), ((before / last).log2(), 1.0));
    }
}
