//! What CVODE calls back into: safe code that never unwinds and says why it refuses.

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::reference::{Ode, panic_text};

/// A callback refused; [`Callbacks::explain`] knows why.
#[derive(Debug)]
pub(super) struct Refused;

/// The system, and what went wrong in it.
///
/// CVODE hands the callbacks a shared reference, so that they may write only through cells.
pub(super) struct Callbacks<'a> {
    ode: &'a dyn Ode,
    dim: usize,
    band: Option<(usize, usize)>,
    failure: RefCell<Option<String>>,
    message: RefCell<Option<String>>,
}

impl<'a> Callbacks<'a> {
    pub(super) fn new(ode: &'a dyn Ode, dim: usize) -> Self {
        let band = ode.bandwidths().map(|(lower, upper)| (lower.min(dim - 1), upper.min(dim - 1)));
        Callbacks { ode, dim, band, failure: RefCell::default(), message: RefCell::default() }
    }

    /// The length of every vector; fixed, because the memory behind CVODE's pointers does not follow a changing `Ode::dim`.
    pub(super) fn dim(&self) -> usize {
        self.dim
    }

    /// Lower and upper bandwidth, each less than the dimension; fixed for the same reason.
    pub(super) fn band(&self) -> Option<(usize, usize)> {
        self.band
    }

    /// Keeps CVODE's latest message.
    pub(super) fn note(&self, message: String) {
        self.message.replace(Some(message));
    }

    /// Why the solve failed: what a callback refused, else CVODE's own message, and in any case the call that failed.
    pub(super) fn explain(&self, call: &str) -> String {
        match self.failure.take().or(self.message.take()) {
            Some(reason) => format!("{reason} ({call})"),
            None => call.into(),
        }
    }

    fn refuse(&self, why: String) -> Result<(), Refused> {
        self.failure.replace(Some(why));
        Err(Refused)
    }

    /// Writes f(t, v) into `dv`.
    pub(super) fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) -> Result<(), Refused> {
        if let Err(payload) = catch_unwind(AssertUnwindSafe(|| self.ode.rhs(t, v, dv))) {
            return self.refuse(format!("the right-hand side panicked: {}", panic_text(&*payload)));
        }
        match dv.iter().position(|x| !x.is_finite()) {
            Some(i) => self.refuse(format!("component {i} of f is {} at t = {t}", dv[i])),
            None => Ok(()),
        }
    }

    /// Hands each contribution to ∂f/∂v to `add`, after checking that it lies in the matrix.
    pub(super) fn jacobian(&self, t: f64, v: &[f64], mut add: impl FnMut(usize, usize, f64)) -> Result<(), Refused> {
        let mut wrong = None;
        let mut checked = |i: usize, j: usize, x: f64| {
            let in_matrix = i < self.dim && j < self.dim;
            let in_band = || self.band.is_none_or(|(lower, upper)| i <= j + lower && j <= i + upper);
            if !in_matrix || !in_band() {
                wrong = Some(format!("entry ({i}, {j}) lies outside the Jacobian or its declared band"));
            } else if !x.is_finite() {
                wrong = Some(format!("entry ({i}, {j}) of the Jacobian is {x} at t = {t}"));
            } else {
                add(i, j, x);
            }
        };
        if let Err(payload) = catch_unwind(AssertUnwindSafe(|| self.ode.jacobian(t, v, &mut checked))) {
            return self.refuse(format!("the Jacobian panicked: {}", panic_text(&*payload)));
        }
        wrong.map_or(Ok(()), |why| self.refuse(why))
    }
}
