//! SUNDIALS CVODE and diffsol, as `verify` calls them: with the analytic Jacobian, banded or sparse where it has a band.

use experiments::reference::{self, Reference};

use super::Solver;
use crate::problem::{Field, Problem, System};

/// A reference of `verify`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ByReference(&'static dyn Reference);

impl ByReference {
    /// All of them, or those for stiff problems.
    pub(crate) fn all(is_stiff: bool) -> impl Iterator<Item = Self> {
        reference::all().into_iter().filter(move |reference| reference.stiff_ok() || !is_stiff).map(Self)
    }
}

impl<const N: usize, S: System<N>> Solver<Problem<N, S>> for ByReference {
    fn name(&self) -> String {
        self.0.name().into()
    }

    fn run(&self, problem: &Problem<N, S>, tolerance: f64) -> Option<Vec<f64>> {
        let run = self.0.run(&Field(&problem.system), 0.0, &problem.start, &[problem.end], tolerance).ok()?;
        run.states.into_iter().next()
    }
}
