//! The crate `russell_ode`, whose linear solver in Rust needs no system library: Hairer and Wanner's codes translated.

use russell_lab::Vector;
use russell_ode::prelude::{Method, NoArgs, OdeSolver, Params, System as Equations};
use russell_sparse::Sym;

use super::{MAX_STEPS, Solver};
use crate::problem::{Problem, System, array, array_mut};

/// A method of the crate.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Russell {
    /// Dormand and Prince's of order 8.
    DoPri8,
    /// Radau IIA of order 5, with sparse factors.
    Radau5,
}

impl<const N: usize, S: System<N>> Solver<Problem<N, S>> for Russell {
    fn name(&self) -> String {
        format!("russell {self:?}")
    }

    fn run(&self, problem: &Problem<N, S>, tolerance: f64) -> Option<Vec<f64>> {
        let system = &problem.system;
        let mut equations = Equations::new(N, move |f: &mut Vector, t, v: &Vector, _: &mut NoArgs| {
            system.rhs(t, array(v.as_data()), array_mut(f.as_mut_data()));
            Ok(())
        });
        let mut entries = 0;
        system.jacobian(0.0, &problem.start, |_, _, _| entries += 1);
        let jacobian = move |j: &mut russell_sparse::CooMatrix, scale: f64, t: f64, v: &Vector, _: &mut NoArgs| {
            j.reset();
            let mut stored = Ok(());
            system.jacobian(t, array(v.as_data()), |row, column, x| {
                stored = stored.and_then(|()| j.put(row, column, scale * x));
            });
            stored
        };
        equations.set_jacobian(Some(entries), Sym::No, jacobian).ok()?;
        let mut params = Params::new(match self {
            Self::DoPri8 => Method::DoPri8,
            Self::Radau5 => Method::Radau5,
        });
        params.set_tolerances(tolerance, tolerance, None).ok()?;
        params.step.n_step_max = MAX_STEPS as usize;
        // Threads cost more than they save where time is that of the process.
        params.radau5.concurrent = false;
        let mut state = Vector::from(&problem.start);
        let mut solver = OdeSolver::new(params, equations).ok()?;
        solver.solve(&mut state, 0.0, problem.end, None, &mut 0, None).ok()?;
        Some(state.as_data().clone())
    }
}
