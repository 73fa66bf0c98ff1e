//! Stands in for CVODE where it is not compiled in, so that a report can name what did not run.

use super::{Ode, Reference, ReferenceError, Run};

/// CVODE, not compiled in.
pub(super) struct Cvode {
    name: &'static str,
    stiff_ok: bool,
}

/// Backward differentiation formulas.
pub(super) static BDF: Cvode = Cvode { name: "cvode-bdf", stiff_ok: true };
/// Adams–Moulton formulas.
pub(super) static ADAMS: Cvode = Cvode { name: "cvode-adams", stiff_ok: false };

impl Reference for Cvode {
    fn name(&self) -> &'static str {
        self.name
    }

    fn stiff_ok(&self) -> bool {
        self.stiff_ok
    }

    fn library(&self) -> Option<String> {
        None
    }

    fn run(&self, _: &dyn Ode, _: f64, _: &[f64], _: &[f64], _: f64) -> Result<Run, ReferenceError> {
        Err(ReferenceError::Unavailable(self.name))
    }
}
