//! The crate `differential-equations`: an explicit method and Radau IIA, which factors dense matrices.

use differential_equations::control::ControlFlag;
use differential_equations::interpolate::Interpolation;
use differential_equations::linalg::Matrix;
use differential_equations::methods::{ExplicitRungeKutta, ImplicitRungeKutta};
use differential_equations::ode::{ODE, OrdinaryNumericalMethod, solve_ode};
use differential_equations::solout::Solout;
use differential_equations::solution::Solution;

use super::{MAX_STEPS, Solver};
use crate::problem::{Problem, System};

/// A method of the crate.
#[derive(Debug, Clone, Copy)]
pub(crate) enum DifferentialEquations {
    /// Dormand and Prince's of order 8.
    Dop853,
    /// Radau IIA of order 5.
    Radau5,
}

/// A system as the crate takes it.
struct Equation<'a, S>(&'a S);

impl<const N: usize, S: System<N>> ODE<f64, [f64; N]> for Equation<'_, S> {
    fn diff(&self, t: f64, v: &[f64; N], dv: &mut [f64; N]) {
        self.0.rhs(t, v, dv);
    }

    fn jacobian(&self, t: f64, v: &[f64; N], j: &mut Matrix<f64>) {
        j.data.fill(0.0);
        self.0.jacobian(t, v, |row, column, x| j[(row, column)] = x);
    }
}

/// Keeps nothing of the steps but the last state.
struct Last<Y>(Y);

impl<const N: usize> Solout<f64, [f64; N]> for Last<[f64; N]> {
    fn solout<I>(
        &mut self,
        _t: f64,
        _before: f64,
        v: &[f64; N],
        _v_before: &[f64; N],
        _interpolator: &mut I,
        _solution: &mut Solution<f64, [f64; N]>,
    ) -> ControlFlag<f64, [f64; N]>
    where
        I: Interpolation<f64, [f64; N]> + ?Sized,
    {
        self.0 = *v;
        ControlFlag::Continue
    }
}

impl<const N: usize, S: System<N>> Solver<Problem<N, S>> for DifferentialEquations {
    fn name(&self) -> String {
        format!("diff.-eq. {self:?}")
    }

    fn run(&self, problem: &Problem<N, S>, tolerance: f64) -> Option<Vec<f64>> {
        let steps = MAX_STEPS as usize;
        match self {
            Self::Dop853 => {
                solve(ExplicitRungeKutta::dop853().rtol(tolerance).atol(tolerance).max_steps(steps), problem)
            }
            // The tolerances are transformed component by component: one for all would be transformed N times. The bound of Newton's
            // iteration is RADAU5's where it is zero, and else does not follow the tolerance.
            Self::Radau5 => {
                let each = vec![tolerance; N];
                let method = ImplicitRungeKutta::radau5().rtol(each.clone()).atol(each).max_steps(steps);
                solve(method.newton_tol(0.0), problem)
            }
        }
    }
}

fn solve<const N: usize, S: System<N>>(
    mut method: impl OrdinaryNumericalMethod<f64, [f64; N]> + Interpolation<f64, [f64; N]>,
    problem: &Problem<N, S>,
) -> Option<Vec<f64>> {
    let mut last = Last(problem.start);
    solve_ode(&mut method, &Equation(&problem.system), 0.0, problem.end, &problem.start, &mut last).ok()?;
    Some(last.0.to_vec())
}
