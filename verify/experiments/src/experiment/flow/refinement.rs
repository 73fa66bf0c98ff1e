//! Errors against exact flows, with h in proportion to Δx.

use super::{named, observed, rms, setting};
use crate::experiment::{Context, Experiment, StudyError};

/// A flow on several grids of `cells` across, each with h = 1/cells.
#[derive(Debug)]
pub struct Refinement {
    /// The flow, its cells apart.
    pub flow: &'static str,
    /// The method.
    pub method: &'static str,
    /// Cells across, doubled from grid to grid.
    pub cells: [usize; 3],
}

/// The end of the runs.
pub(crate) const END: f64 = 1.0;

/// What refining does.
#[derive(Debug)]
pub struct Found {
    /// Root mean squares of the error.
    pub errors: [f64; 3],
    /// The orders that each two of them give.
    pub orders: [f64; 2],
    /// Velocities on the finest grid.
    pub end: Vec<f64>,
}

impl Experiment for Refinement {
    const ID: &'static str = "flow-refinement";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        context.announce(1);
        let run = |cells: usize| -> Result<(Vec<f64>, f64), StudyError> {
            let problem = setting(&format!("{} cells={cells}", self.flow))?;
            let (end, _) = observed(&*problem, &*named(self.method)?, 1.0 / cells as f64, END)?;
            let error = rms(&end, &problem.exact(END).ok_or("the flow is known")?);
            Ok((end, error))
        };
        let [coarse, middle, fine] = self.cells;
        let ((_, first), (_, second), (end, third)) = (run(coarse)?, run(middle)?, run(fine)?);
        context.tick();
        let order = |[a, b]: [f64; 2], [m, n]: [usize; 2]| (a / b).ln() / (n as f64 / m as f64).ln();
        let orders = [order([first, second], [coarse, middle]), order([second, third], [middle, fine])];
        Ok(Found { errors: [first, second, third], orders, end })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_as_long_as_cells_are_wide() {
        let (flow, method, cells) = ("cavity-manufactured re=10", "implicit-euler", [4, 8, 16]);
        let found = Refinement { flow, method, cells }.measure(&Context::quick()).expect("it runs");
        for (cells, error) in cells.into_iter().zip(found.errors) {
            let problem = setting(&format!("{flow} cells={cells}")).expect("known");
            let run = crate::run::run(&*problem, &*named(method).expect("known"), 1.0 / cells as f64, END, |_| {});
            let run = run.expect("it runs");
            assert_eq!(error, rms(&problem.observe(END, &run.end.q), &problem.exact(END).expect("known")), "{cells}");
        }
        for (order, errors) in found.orders.into_iter().zip(found.errors.windows(2)) {
            approx::assert_relative_eq!(order, (errors[0] / errors[1]).log2(), max_relative = 1e-12);
        }
    }
}
