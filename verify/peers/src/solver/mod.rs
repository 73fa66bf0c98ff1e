//! Solvers of one interface: those of `lsvi` and their peers, one file each.

mod adaptive;
mod by_hand;
mod differential_equations;
mod fixed;
mod method_i;
mod ode_solvers;
mod reference;
mod russell;

pub(crate) use adaptive::AdaptiveRadau;
pub(crate) use by_hand::{Dense, Matrix, RadauByHand, Tridiagonal};
pub(crate) use differential_equations::DifferentialEquations;
pub(crate) use fixed::Fixed;
pub(crate) use method_i::MethodI;
pub(crate) use ode_solvers::OdeSolvers;
pub(crate) use reference::ByReference;
pub(crate) use russell::Russell;

/// Steps that a run may take, as in the codes of Hairer and Wanner; those of `verify`'s references have a bound of their own.
const MAX_STEPS: u32 = 100_000;

/// A solver of problems P with one knob.
pub(crate) trait Solver<P> {
    /// Its name in tables.
    fn name(&self) -> String;

    /// What to try, from coarse to fine: tolerances, relative and absolute ones alike, or numbers of steps.
    fn settings(&self, _problem: &P) -> Vec<f64> {
        tolerances()
    }

    /// The state at the end; nothing where the solver fails.
    fn run(&self, problem: &P, setting: f64) -> Option<Vec<f64>>;
}

/// Thirds of a decade from a tenth down to half a rounding, of which a solver refuses what it finds too small.
fn tolerances() -> Vec<f64> {
    (3..=48).map(|third| 10_f64.powf(-f64::from(third) / 3.0)).collect()
}

/// So many numbers of steps, each larger by a sixth than the one before.
fn step_counts(fewest: f64, most: f64) -> Vec<f64> {
    std::iter::successors(Some(fewest), |n| Some((n * 7.0 / 6.0).ceil())).take_while(|n| *n <= most).collect()
}
