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
    /// Cells across, doubled.
    pub cells: [usize; 2],
}

/// The end of the runs.
pub(crate) const END: f64 = 1.0;

/// What refining does.
#[derive(Debug)]
pub struct Found {
    /// Root mean squares of the error.
    pub errors: [f64; 2],
    /// The order that they give.
    pub order: f64,
    /// Velocities on the finer grid.
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
        let [coarse, fine] = self.cells;
        let ((_, first), (end, second)) = (run(coarse)?, run(fine)?);
        context.tick();
        let order = (first / second).ln() / (fine as f64 / coarse as f64).ln();
        Ok(Found { errors: [first, second], order, end })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_as_long_as_cells_are_wide() {
        let (flow, method, cells) = ("cavity-manufactured re=10", "implicit-euler", [4, 8]);
        let found = Refinement { flow, method, cells }.measure(&Context::quick()).expect("it runs");
        for (cells, error) in cells.into_iter().zip(found.errors) {
            let problem = setting(&format!("{flow} cells={cells}")).expect("known");
            let run = crate::run::run(&*problem, &*named(method).expect("known"), 1.0 / cells as f64, END, |_| {});
            let run = run.expect("it runs");
            assert_eq!(error, rms(&problem.observe(END, &run.end.q), &problem.exact(END).expect("known")), "{cells}");
        }
        approx::assert_relative_eq!(found.order, (found.errors[0] / found.errors[1]).log2(), max_relative = 1e-12);
    }
}
