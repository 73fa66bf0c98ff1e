//! SUNDIALS CVODE: variable-order, variable-step BDF and Adams formulas with a Newton iteration on the analytic Jacobian, dense
//! or banded with its factors, or by its products alone with GMRES (Hindmarsh et al., ACM Trans. Math. Softw. 31 (2005) 363–396).

mod call;
mod callbacks;
#[allow(unsafe_code)]
mod ffi;

use self::call::CallError;
use self::callbacks::Callbacks;
use self::ffi::{Formulas, Session};
use super::{Ode, Reference, ReferenceError, Run, bound, check_size};

/// CVODE with one of its two families of formulas.
pub(super) struct Cvode {
    name: &'static str,
    formulas: Formulas,
    stiff_ok: bool,
}

/// Backward differentiation formulas of orders 1 to 5.
pub(super) static BDF: Cvode = Cvode { name: "cvode-bdf", formulas: Formulas::Bdf, stiff_ok: true };

/// Adams–Moulton formulas of orders 1 to 12.
pub(super) static ADAMS: Cvode = Cvode { name: "cvode-adams", formulas: Formulas::Adams, stiff_ok: false };

impl Reference for Cvode {
    fn name(&self) -> &'static str {
        self.name
    }

    fn stiff_ok(&self) -> bool {
        self.stiff_ok
    }

    fn library(&self) -> Option<String> {
        Some(format!("SUNDIALS {}", ffi::version()))
    }

    /// One solve. CVODE interpolates the samples with the polynomial of the step's own order; only the last is a stop time, so
    /// that f is never evaluated beyond it.
    fn run(&self, ode: &dyn Ode, t0: f64, v0: &[f64], times: &[f64], tolerance: f64) -> Result<Run, ReferenceError> {
        bound::check(ode, t0, v0, times)?;
        if !ode.is_matrix_free() {
            check_size(self.name, ode.dim(), ode.bandwidths().is_none())?;
        }
        let callbacks = Callbacks::new(ode, v0.len());
        let failed =
            |t: f64, call: CallError| ReferenceError::Solver { solver: self.name, t, reason: callbacks.explain(call) };
        let mut session =
            Session::new(self.formulas, t0, v0, tolerance, &callbacks).map_err(|call| failed(t0, call))?;
        let mut run = Run::with_capacity(times.len());
        let end = times.last().copied().filter(|&end| end > t0);
        if let Some(end) = end {
            session.stop_at(end).map_err(|call| failed(t0, call))?;
            session.step_at_most(ode.longest_step(end - t0)).map_err(|call| failed(t0, call))?;
        }
        let mut state = v0.to_vec();
        let mut reached = t0;
        for &t in times {
            if t > reached {
                if let Err(call) = session.advance_to(t, &mut state) {
                    return Err(failed(session.current_time().unwrap_or(reached), call));
                }
                reached = t;
            }
            run.work = session.work().map_err(|call| failed(t, call))?;
            run.push(state.clone(), run.work.steps);
        }
        Ok(run)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// v̇ = 0, looked at in steps of a hundredth of the way.
    struct Watched;

    impl Ode for Watched {
        fn dim(&self) -> usize {
            1
        }
        fn rhs(&self, _t: f64, _v: &[f64], dv: &mut [f64]) {
            dv[0] = 0.0;
        }
        fn jacobian(&self, _t: f64, _v: &[f64], _add: &mut dyn FnMut(usize, usize, f64)) {}
        fn longest_step(&self, span: f64) -> f64 {
            0.01 * span
        }
    }

    #[test]
    fn no_step_is_longer_than_the_longest_of_the_way_that_is_left() {
        for cvode in [&BDF, &ADAMS] {
            let run = cvode.run(&Watched, 2.0, &[1.0], &[2.5, 3.0], 1e-6).expect("it runs");
            assert!(run.work.steps >= 100, "{}", run.work.steps);
        }
    }
}
