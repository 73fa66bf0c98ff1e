//! What CVODE calls back into: safe code that never unwinds and says why it refuses.

use std::cell::RefCell;

use super::call::CallError;
use crate::panics::caught;
use crate::reference::Ode;

/// A callback refused; [`Callbacks::explain`] knows why.
#[derive(Debug)]
pub(super) struct Refused;

/// What CVODE keeps of the Jacobian.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Storage {
    Dense,
    /// Each bandwidth is less than the dimension.
    Banded {
        lower: usize,
        upper: usize,
    },
    /// It is known by its products.
    None,
}

/// The system, and what went wrong in it.
///
/// CVODE hands the callbacks a shared reference, so that they may write only through cells.
pub(super) struct Callbacks<'a> {
    ode: &'a dyn Ode,
    dim: usize,
    storage: Storage,
    failure: RefCell<Option<String>>,
    message: RefCell<Option<String>>,
}

impl<'a> Callbacks<'a> {
    pub(super) fn new(ode: &'a dyn Ode, dim: usize) -> Self {
        let storage = match ode.bandwidths() {
            _ if ode.is_matrix_free() => Storage::None,
            Some((lower, upper)) => Storage::Banded { lower: lower.min(dim - 1), upper: upper.min(dim - 1) },
            None => Storage::Dense,
        };
        Callbacks { ode, dim, storage, failure: RefCell::default(), message: RefCell::default() }
    }

    /// The length of every vector; fixed, because the memory behind CVODE's pointers does not follow a changing `Ode::dim`.
    pub(super) fn dim(&self) -> usize {
        self.dim
    }

    /// What the Jacobian is stored as; fixed for the same reason.
    pub(super) fn storage(&self) -> Storage {
        self.storage
    }

    /// Keeps CVODE's latest message.
    pub(super) fn note(&self, message: String) {
        self.message.replace(Some(message));
    }

    /// Why the solve failed: what a callback refused, else CVODE's own message, and in any case the call that failed.
    pub(super) fn explain(&self, call: CallError) -> String {
        match self.failure.take().or(self.message.take()) {
            Some(reason) => format!("{reason} ({call})"),
            None => call.to_string(),
        }
    }

    fn refuse(&self, why: String) -> Result<(), Refused> {
        self.failure.replace(Some(why));
        Err(Refused)
    }

    /// Writes f(t, v) into `dv`.
    pub(super) fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) -> Result<(), Refused> {
        self.finite((t, "the right-hand side", "f"), dv, |dv| self.ode.rhs(t, v, dv))
    }

    /// Writes J(t, v) x into `out`.
    pub(super) fn product(&self, t: f64, v: &[f64], x: &[f64], out: &mut [f64]) -> Result<(), Refused> {
        self.finite((t, "the product with the Jacobian", "J x"), out, |out| self.ode.product(t, v, x, out))
    }

    /// Refuses what panics in `write`, or is not finite; `what` and `name` are in words and in short.
    fn finite(
        &self,
        (t, what, name): (f64, &str, &str),
        out: &mut [f64],
        write: impl FnOnce(&mut [f64]),
    ) -> Result<(), Refused> {
        if let Err(message) = caught(|| write(out)) {
            return self.refuse(format!("{what} panicked: {message}"));
        }
        match out.iter().position(|x| !x.is_finite()) {
            Some(i) => self.refuse(format!("component {i} of {name} is {} at t = {t}", out[i])),
            None => Ok(()),
        }
    }

    /// Hands each contribution to ∂f/∂v to `add`, after checking that it lies in the matrix.
    pub(super) fn jacobian(&self, t: f64, v: &[f64], mut add: impl FnMut(usize, usize, f64)) -> Result<(), Refused> {
        let mut wrong = None;
        let mut checked = |i: usize, j: usize, x: f64| {
            let in_matrix = i < self.dim && j < self.dim;
            let in_storage = || match self.storage {
                Storage::Dense => true,
                Storage::Banded { lower, upper } => i <= j + lower && j <= i + upper,
                Storage::None => false,
            };
            if !in_matrix || !in_storage() {
                wrong = Some(format!("entry ({i}, {j}) lies outside the Jacobian or its declared band"));
            } else if !x.is_finite() {
                wrong = Some(format!("entry ({i}, {j}) of the Jacobian is {x} at t = {t}"));
            } else {
                add(i, j, x);
            }
        };
        if let Err(message) = caught(|| self.ode.jacobian(t, v, &mut checked)) {
            return self.refuse(format!("the Jacobian panicked: {message}"));
        }
        wrong.map_or(Ok(()), |why| self.refuse(why))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two unknowns and a Jacobian with this one entry.
    struct Entry(usize, usize);

    impl Ode for Entry {
        fn dim(&self) -> usize {
            2
        }
        fn rhs(&self, _t: f64, _v: &[f64], dv: &mut [f64]) {
            dv.fill(0.0);
        }
        fn jacobian(&self, _t: f64, _v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
            add(self.0, self.1, 1.0);
        }
    }

    #[test]
    fn an_entry_outside_of_the_jacobian_is_refused_and_not_written() {
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (0, 2), (2, 2), (9, 0)] {
            let (entry, mut written) = (Entry(i, j), 0);
            let result = Callbacks::new(&entry, 2).jacobian(0.0, &[0.0; 2], |_, _, _| written += 1);
            let is_inside = i < 2 && j < 2;
            assert_eq!((result.is_ok(), written), (is_inside, usize::from(is_inside)), "({i}, {j})");
        }
    }
}
