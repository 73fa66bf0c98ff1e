//! The steady cavity by large steps of Method I.

use lsvi::closure::Linear;
use lsvi::solver::Augmented;
use lsvi::steady::{self, Steady, SteadyError};
use lsvi::{InputError, LeastSquaresStep, State, VectorField};

use super::profile::Profile;
use super::{cavity, timed};
use crate::experiment::{Context, Experiment, StudyError};
use crate::problem::Problem;

/// |f| at which a flow counts as steady, in units of M ψ̇, and the steps that it may take.
pub const STEADY: f64 = 1e-10;
const STEPS: u64 = 400;

/// Method I from `start` to a steady state with steps of `h`.
pub(super) fn march(problem: &dyn Problem, start: Vec<f64>, h: f64) -> Result<Steady, SteadyError> {
    let field = problem.field();
    steady::march(method_i(problem, &field)?, &field, State::new(0.0, start), h, STEADY, STEPS)
}

/// Method I with the solver that `problem` asks for.
pub(super) fn method_i<F: VectorField>(problem: &dyn Problem, field: F) -> Result<LeastSquaresStep<F>, InputError> {
    let solver = problem.solver().unwrap_or_else(|| Box::new(Augmented::new()));
    LeastSquaresStep::with_solver(field, Linear::METHOD_I, solver)
}

/// ψ at corner (i, j) of a cavity, from its values inside.
pub fn corner(cells: usize, psi: &[f64], i: usize, j: usize) -> f64 {
    if i == 0 || j == 0 || i == cells || j == cells { 0.0 } else { psi[(j - 1) * (cells - 1) + i - 1] }
}

/// ψ on another number of cells a side, by linear interpolation.
pub fn interpolated(from: usize, psi: &[f64], to: usize) -> Vec<f64> {
    let place = |k: usize| {
        let at = k as f64 * from as f64 / to as f64;
        let below = (at.floor() as usize).min(from - 1);
        (below, at - below as f64)
    };
    let value = |i: usize, j: usize| {
        let ((i, x), (j, y)) = (place(i), place(j));
        let row = |j| (1.0 - x) * corner(from, psi, i, j) + x * corner(from, psi, i + 1, j);
        (1.0 - y) * row(j) + y * row(j + 1)
    };
    (1..to).flat_map(|j| (1..to).map(move |i| (i, j))).map(|(i, j)| value(i, j)).collect()
}

/// v_x − u_y at the interior corners, row by row, from the velocities of the faces.
fn vorticity(cells: usize, faces: &[f64]) -> Vec<Vec<f64>> {
    let (inside, n) = (cells - 1, cells as f64);
    let (u, v) = faces.split_at(cells * inside);
    let at = |i: usize, j: usize| {
        let v_x = v[(j - 1) * cells + i] - v[(j - 1) * cells + i - 1];
        n * (v_x - (u[j * inside + i - 1] - u[(j - 1) * inside + i - 1]))
    };
    (1..cells).map(|j| (1..cells).map(|i| at(i, j)).collect()).collect()
}

/// The step size to a steady state: as large as Gauss and Newton's iteration follows from rest, or from a coarser grid.
fn step_size(re: f64, is_from_rest: bool) -> f64 {
    match is_from_rest {
        true if re > 500.0 => 5.0,
        true => 20.0,
        false => 100.0,
    }
}

/// The steady flow on several grids, each from the one before.
#[derive(Debug)]
pub struct SteadyCavity {
    /// Reynolds number.
    pub re: f64,
    /// Cells along a side, ascending.
    pub cells: &'static [usize],
}

/// On one grid.
#[derive(Debug)]
pub struct Grid {
    /// Cells in each direction.
    pub cells: usize,
    /// Stream function.
    pub psi: Vec<f64>,
    /// Velocities along the two lines through the centre.
    pub profile: Profile,
    /// At the interior corners, row by row.
    pub vorticity: Vec<Vec<f64>>,
    /// What is left of the equation.
    pub residual: f64,
    /// Number of steps.
    pub steps: u64,
    /// Seconds that it took.
    pub seconds: f64,
}

impl Experiment for SteadyCavity {
    const ID: &'static str = "steady-cavity";
    type Found = Vec<Grid>;

    fn measure(&self, context: &Context) -> Result<Vec<Grid>, StudyError> {
        context.announce(self.cells.len());
        let mut grids: Vec<Grid> = Vec::new();
        for &cells in self.cells {
            let problem = cavity(self.re, cells)?;
            let start = match grids.last() {
                Some(coarse) => interpolated(coarse.cells, &coarse.psi, cells),
                None => problem.initial(),
            };
            let h = step_size(self.re, grids.is_empty());
            let (steady, seconds) = timed(|| march(&*problem, start, h));
            let Steady { state, residual, steps } = steady?;
            let faces = problem.observe(0.0, &state.q);
            let (profile, vorticity) = (Profile::new(cells, &faces), vorticity(cells, &faces));
            grids.push(Grid { cells, psi: state.q, profile, vorticity, residual, steps, seconds });
            context.tick();
        }
        Ok(grids)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::norm::max_norm;

    #[test]
    fn interpolation_keeps_what_vanishes_on_the_walls_and_is_bilinear_between() {
        let psi = [1.0, 2.0, 3.0, 4.0];
        assert_eq!(interpolated(3, &psi, 3), psi);
        let fine = interpolated(3, &psi, 6);
        assert_eq!((fine[0], fine[6], fine[12]), (0.25, 1.0, 2.5));
    }

    #[test]
    fn the_vorticity_of_a_parabola_is_its_laplacian() {
        // u = ψ_y and v = −ψ_x of ψ = x² + 2y²: v_x − u_y = −6, by exact differences.
        let n = 6;
        let dx = 1.0 / n as f64;
        let u = (0..n).flat_map(|j| (1..n).map(move |_| 4.0 * (j as f64 + 0.5) * dx));
        let v = (1..n).flat_map(|_| (0..n).map(move |i| -2.0 * (i as f64 + 0.5) * dx));
        let faces: Vec<f64> = u.chain(v).collect();
        assert!(vorticity(n, &faces).iter().flatten().all(|w| (w + 6.0).abs() < 1e-12));
    }

    #[test]
    fn a_steady_cavity_is_at_rest_to_ten_digits() {
        let grids = SteadyCavity { re: 100.0, cells: &[6, 8] }.measure(&Context::quick()).expect("it is steady");
        for grid in grids {
            let (problem, mut f) = (cavity(100.0, grid.cells).expect("known"), vec![0.0; grid.psi.len()]);
            problem.field().rhs(0.0, &grid.psi, &mut f);
            let largest = max_norm(&f);
            assert!(largest <= 1e-10 && largest == grid.residual, "{largest} {}", grid.residual);
        }
    }
}
