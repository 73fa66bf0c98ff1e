//! Variational integrators of mechanics with steps of one size.

use lsvi::discrete::{BrokenLine, DiscreteLegendre, Galerkin, PathFitted};
use lsvi::quadrature::NodeFamily;
use lsvi::{EulerLagrange, State, Trajectory, position_momentum};

use super::{Solver, step_counts};
use crate::problem::{Problem, System};

/// A method in position–momentum form.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Fixed {
    /// Galerkin's with s Gauss nodes.
    Gauss(usize),
    /// Path fitting of degree m at m − 1 Gauss nodes.
    PathFitted(usize),
    /// Blanes and Moan's explicit one of order 6.
    BlanesMoan,
}

impl Fixed {
    /// All that are worth a try: of order 4 to 16.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        (2..=8).map(Self::Gauss).chain((3..=9).map(Self::PathFitted)).chain([Self::BlanesMoan])
    }
}

impl<const N: usize, S> Solver<Problem<N, S>> for Fixed
where
    S: System<N> + EulerLagrange + Copy,
{
    fn name(&self) -> String {
        match self {
            Self::Gauss(s) => format!("Galerkin Gauss-{s}"),
            Self::PathFitted(m) => format!("path-fitted({m})"),
            Self::BlanesMoan => "Blanes–Moan".into(),
        }
    }

    /// From a step of the size of 6, as long as a period or so, to one of 1/200.
    fn settings(&self, problem: &Problem<N, S>) -> Vec<f64> {
        step_counts((problem.end / 6.0).ceil(), 200.0 * problem.end)
    }

    fn run(&self, problem: &Problem<N, S>, steps: f64) -> Option<Vec<f64>> {
        match *self {
            Self::Gauss(s) => run(Galerkin::gauss(problem.system, s).ok()?, problem, steps),
            Self::PathFitted(m) => run(PathFitted::on(problem.system, NodeFamily::Gauss, m).ok()?, problem, steps),
            Self::BlanesMoan => run(BrokenLine::blanes_moan(problem.system).ok()?, problem, steps),
        }
    }
}

/// The state (q, p) at the end.
fn run<const N: usize, S>(discrete: impl DiscreteLegendre, problem: &Problem<N, S>, steps: f64) -> Option<Vec<f64>> {
    let (q, p) = problem.start.split_at(N / 2);
    let start = State::new(0.0, q.to_vec()).with_momentum(p.to_vec());
    let method = position_momentum(discrete);
    let end = Trajectory::new(method, start, problem.end / steps, problem.end).ok()?.observe(|_| {}).ok()?;
    Some([end.q, end.p].concat())
}
