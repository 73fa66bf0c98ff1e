//! Method I with steps of one size.

use lsvi::{State, Trajectory, method_i};

use super::{Solver, step_counts};
use crate::problem::{Field, Problem, System};

/// Least squares on straight paths, closed by p₁ = 0: order 2.
#[derive(Debug)]
pub(crate) struct MethodI;

impl<const N: usize, S: System<N>> Solver<Problem<N, S>> for MethodI {
    fn name(&self) -> String {
        "Method I".into()
    }

    fn settings(&self, _problem: &Problem<N, S>) -> Vec<f64> {
        step_counts(4.0, 1e5)
    }

    fn run(&self, problem: &Problem<N, S>, steps: f64) -> Option<Vec<f64>> {
        let method = method_i(Field(&problem.system)).ok()?;
        let start = State::new(0.0, problem.start.to_vec());
        let end = Trajectory::new(method, start, problem.end / steps, problem.end).ok()?.observe(|_| {}).ok()?;
        Some(end.q)
    }
}
