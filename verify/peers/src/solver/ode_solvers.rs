//! The crate `ode_solvers`: Dormand and Prince's explicit methods. It keeps the state of every step, which cannot be turned off.

use ode_solvers::{Dop853, Dopri5, OutputType, SVector};

use super::{MAX_STEPS, Solver};
use crate::problem::{Problem, System, array, array_mut};

/// A method of the crate.
#[derive(Debug, Clone, Copy)]
pub(crate) enum OdeSolvers {
    /// Order 5.
    Dopri5,
    /// Order 8.
    Dop853,
}

/// A system as the crate takes it.
struct Rhs<'a, S>(&'a S);

impl<const N: usize, S: System<N>> ode_solvers::System<f64, SVector<f64, N>> for Rhs<'_, S> {
    fn system(&self, t: f64, v: &SVector<f64, N>, dv: &mut SVector<f64, N>) {
        self.0.rhs(t, array(v.as_slice()), array_mut(dv.as_mut_slice()));
    }
}

/// Its controls are its defaults, without dense output: safety, β, least and largest factor of a step.
const FIFTH: [f64; 4] = [0.9, 0.04, 0.2, 10.0];
const EIGHTH: [f64; 4] = [0.9, 0.0, 0.333, 6.0];
/// Steps between two tests for stiffness, its default.
const STIFFNESS: u32 = 1000;

impl<const N: usize, S: System<N>> Solver<Problem<N, S>> for OdeSolvers {
    fn name(&self) -> String {
        format!("ode_solvers {self:?}")
    }

    fn run(&self, problem: &Problem<N, S>, tol: f64) -> Option<Vec<f64>> {
        let (rhs, start, end) = (Rhs(&problem.system), SVector::from(problem.start), problem.end);
        macro_rules! integrate {
            ($method:ident, [$safety:expr, $beta:expr, $least:expr, $most:expr]) => {{
                #[rustfmt::skip]
                let mut method = $method::from_param(
                    rhs, 0.0, end, end, start, tol, tol, $safety, $beta, $least, $most, end, 0.0, MAX_STEPS, STIFFNESS,
                    OutputType::Sparse,
                );
                method.integrate().ok()?;
                Some(method.y_out().last()?.as_slice().to_vec())
            }};
        }
        match self {
            Self::Dopri5 => integrate!(Dopri5, [FIFTH[0], FIFTH[1], FIFTH[2], FIFTH[3]]),
            Self::Dop853 => integrate!(Dop853, [EIGHTH[0], EIGHTH[1], EIGHTH[2], EIGHTH[3]]),
        }
    }
}
