//! `lsvi::adaptive::Radau`: Radau IIA of order 5, 9 and 13, by tolerance.

use lsvi::adaptive::{Options, Radau, Tolerances};
use lsvi::{State, Trajectory};

use super::{MAX_STEPS, Solver};
use crate::problem::{Field, Problem, System};

/// The adaptive method with its own choice of steps and order.
#[derive(Debug)]
pub(crate) struct AdaptiveRadau;

impl<const N: usize, S: System<N>> Solver<Problem<N, S>> for AdaptiveRadau {
    fn name(&self) -> String {
        "adaptive Radau".into()
    }

    fn run(&self, problem: &Problem<N, S>, tolerance: f64) -> Option<Vec<f64>> {
        let tolerances = Tolerances::new(tolerance, tolerance).ok()?;
        let options = Options::new(tolerances).max_steps(u64::from(MAX_STEPS)).ok()?;
        let method = Radau::new(Field(&problem.system), options).ok()?;
        let start = State::new(0.0, problem.start.to_vec());
        let end = Trajectory::new(method, start, problem.end, problem.end).ok()?.observe(|_| {}).ok()?;
        Some(end.q)
    }
}
