//! What a step makes of small disturbances of the steady cavity: its derivative, from live steps, and as theory has it.

use std::ops::ControlFlow;

use lsvi::{Jacobian, Mass};
use nalgebra::{Complex, DMatrix};

use super::steady::march;
use super::{cavity, named};
use crate::experiment::{Context, Experiment, StudyError};
use crate::measure::norm::max_norm;
use crate::measure::stability::eigenvalues;
use crate::problem::Problem;
use crate::run::run_from;

/// Steps of one size of a method.
#[derive(Debug)]
pub struct Disturbances {
    /// Name of the method.
    pub method: &'static str,
    /// Step size.
    pub h: f64,
}

impl Disturbances {
    /// Cells along a side.
    pub const CELLS: usize = 8;
    /// The Reynolds number.
    pub const RE: f64 = 100.0;
    /// Size of the disturbances over that of ψ. Central differences leave its square times third derivatives, and of the
    /// tolerance of a step 1e-10/1e-3.
    pub(crate) const SIZE: f64 = 1e-3;
}

/// The derivative of a step.
#[derive(Debug)]
pub struct Found {
    /// Largest entry of the difference between the derivative by live steps and by theory, over the largest entry.
    pub difference: f64,
    /// Spectral radius of the derivative by live steps.
    pub radius: f64,
    /// Its eigenvalue of that size.
    pub slowest: Complex<f64>,
}

/// The steady flow and its A = M⁻¹J, by hand.
struct Linearised {
    problem: Box<dyn Problem>,
    psi: Vec<f64>,
    mass: DMatrix<f64>,
    a: DMatrix<f64>,
}

fn linearised() -> Result<Linearised, StudyError> {
    let problem = cavity(Disturbances::RE, Disturbances::CELLS)?;
    let psi = march(&*problem, problem.initial(), 20.0)?.state.q;
    let n = psi.len();
    let mut a = DMatrix::zeros(n, n);
    problem.ode().jacobian(0.0, &psi, &mut |i, j, x| a[(i, j)] += x);
    let mass = match problem.field().mass() {
        Mass::Matrix(mass) => Jacobian::to_dense(&mass),
        other => return Err(format!("a mass matrix, not {other:?}").into()),
    };
    Ok(Linearised { problem, psi, mass, a })
}

/// The derivative of a step in the state, on v̇ = Av.
fn theory(method: &str, z: &DMatrix<f64>, mass: &DMatrix<f64>) -> Result<DMatrix<f64>, StudyError> {
    let one = DMatrix::identity(z.nrows(), z.nrows());
    let over = |below: DMatrix<f64>, above: DMatrix<f64>| below.lu().solve(&above).ok_or("a singular step");
    let found = match method {
        "implicit-euler" => over(&one - z, one)?,
        "trapezoidal" | "implicit-midpoint" => over(&one - 0.5 * z, &one + 0.5 * z)?,
        "tr-bdf2" => {
            let g = 2.0 - 2.0_f64.sqrt();
            let middle = over(&one - 0.5 * g * z, &one + 0.5 * g * z)?;
            let end = (middle - (1.0 - g).powi(2) * &one) / (g * (2.0 - g));
            over(&one - (1.0 - g) / (2.0 - g) * z, end)?
        }
        // (M + BᵀMB) d₁ = (M(1 + Z) + BᵀM) d₀, B = 1 − Z: the minimum of the action in the metric M.
        "method-i" => {
            let b = &one - z;
            let across = b.transpose() * mass;
            over(mass + &across * &b, mass * (&one + z) + across)?
        }
        other => return Err(format!("no stability function of `{other}`").into()),
    };
    Ok(found)
}

impl Experiment for Disturbances {
    const ID: &'static str = "disturbances";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        context.announce(1);
        let Linearised { problem, psi, mass, a } = linearised()?;
        let method = named(self.method)?;
        let size = Self::SIZE * max_norm(&psi);
        let step = |k: usize, by: f64| -> Result<Vec<f64>, StudyError> {
            let mut start = psi.clone();
            start[k] += by;
            let end = run_from(&*problem, start, &*method, self.h, self.h, |_, _| ControlFlow::Continue(()))?;
            Ok(end.end.q)
        };
        let mut live = DMatrix::zeros(psi.len(), psi.len());
        for (k, mut column) in live.column_iter_mut().enumerate() {
            let (above, below) = (step(k, size)?, step(k, -size)?);
            column.iter_mut().zip(above.iter().zip(&below)).for_each(|(x, (a, b))| *x = (a - b) / (2.0 * size));
        }
        let expected = theory(self.method, &(self.h * a), &mass)?;
        let difference = (&live - &expected).amax() / expected.amax();
        let slowest =
            eigenvalues(&live).into_iter().max_by(|a, b| a.norm().total_cmp(&b.norm())).ok_or("no eigenvalue")?;
        context.tick();
        Ok(Found { difference, radius: slowest.norm(), slowest })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slowest_disturbance_is_the_largest_by_modulus_and_turns_by_the_trapezoidal_rule_with_long_steps() {
        let found = Disturbances { method: "trapezoidal", h: 100.0 }.measure(&Context::quick()).expect("it steps");
        approx::assert_relative_eq!(found.slowest.norm(), found.radius, max_relative = 1e-10);
        assert!(found.slowest.re < 0.0, "{found:?}");
    }
}
