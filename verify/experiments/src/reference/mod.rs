//! Reference solutions by other libraries. CVODE shares no code with the methods under test, and diffsol no more than the package nalgebra.
//!
//! A reference solves a first-order system v̇ = f(t, v) that a problem states by hand in [`Ode`]; it never sees
//! the discretisation that it is to judge. Each is solved at two tolerances, and twice the difference is its error bound.

pub mod bound;
#[cfg(feature = "cvode")]
mod cvode;
#[cfg(not(feature = "cvode"))]
#[path = "cvode_absent.rs"]
mod cvode;
mod diffsol;

pub use bound::{InUnits, Run};

use std::fmt;

/// Every reference, whether compiled in or not.
pub fn all() -> [&'static dyn Reference; 6] {
    [&cvode::BDF, &cvode::ADAMS, &diffsol::BDF, &diffsol::TR_BDF2, &diffsol::ESDIRK34, &diffsol::TSIT45]
}

/// The reference of that name, such as `cvode-bdf`.
pub fn by_name(name: &str) -> Option<&'static dyn Reference> {
    all().into_iter().find(|r| r.name() == name)
}

/// A first-order system v̇ = f(t, v) with its Jacobian, written by hand for the references.
pub trait Ode: Sync {
    /// Number of unknowns.
    fn dim(&self) -> usize;

    /// Writes f(t, v) into `dv`.
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]);

    /// Calls `add(i, j, x)` with contributions x to ∂f_i/∂v_j; entries that are never named are zero, repeated ones add up.
    fn jacobian(&self, t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64));

    /// Lower and upper bandwidth of the Jacobian, where it is banded.
    fn bandwidths(&self) -> Option<(usize, usize)> {
        None
    }

    /// Whether entries of the Jacobian are few enough for sparse factors, banded or not.
    fn is_sparse(&self) -> bool {
        self.bandwidths().is_some()
    }

    /// Writes J x.
    fn product(&self, t: f64, v: &[f64], x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        self.jacobian(t, v, &mut |i, j, a| out[i] += a * x[j]);
    }

    /// Whether products with the Jacobian are cheap and its entries dear, so that Krylov iterations should solve with it.
    fn is_matrix_free(&self) -> bool {
        false
    }

    /// Whether f is known not to depend on t.
    fn is_autonomous(&self) -> bool {
        false
    }

    /// The longest step to be taken on the way over a time `span`: infinite, unless f may act for a part of it only, over which a
    /// step may pass without a look.
    fn longest_step(&self, _span: f64) -> f64 {
        f64::INFINITY
    }
}

/// Steps allowed in a solve, within seconds of a small system.
const MAX_STEPS: i32 = 1_000_000;

/// Largest order of a dense matrix: it takes 128 MB.
const MAX_DENSE: usize = 4096;

/// Refuses systems whose Jacobian would be stored as a larger dense matrix than [`MAX_DENSE`].
fn check_size(solver: &str, n: usize, is_dense: bool) -> Result<(), ReferenceError> {
    if !is_dense || n <= MAX_DENSE {
        return Ok(());
    }
    let reason =
        format!("{solver} would store a dense Jacobian of order {n}, more than {MAX_DENSE}; fewer cells will do");
    Err(ReferenceError::Input(reason))
}

/// Work spent on a solve.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Work {
    /// Accepted steps.
    pub steps: u64,
    /// Evaluations of f.
    pub rhs: u64,
    /// Evaluations of the Jacobian.
    pub jacobians: u64,
    /// Linear systems factored, or set up for iterations.
    pub factorizations: u64,
    /// Products of the Jacobian with a vector.
    pub products: u64,
}

/// A solution at requested times with its own error bound.
#[derive(Debug, Clone)]
pub struct Sampled {
    /// The times asked for.
    pub times: Vec<f64>,
    /// The state at each time.
    pub states: Vec<Vec<f64>>,
    /// Bound on the max-norm error at each time: twice the difference between two tolerances, no less than roundoff.
    pub bound: Vec<f64>,
    /// Work of the finer of the two solves.
    pub work: Work,
}

/// Why a reference gave no answer.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum ReferenceError {
    /// The solver stopped.
    #[error("{solver} stopped at t = {t}: {reason}")]
    Solver {
        /// Which solver.
        solver: &'static str,
        /// Where it stopped.
        t: f64,
        /// What it said.
        reason: String,
    },
    /// The request cannot be met.
    #[error("{0}")]
    Input(String),
    /// Not compiled in.
    #[error("{0} is not compiled in (feature `cvode`)")]
    Unavailable(&'static str),
}

/// A solver used as reference.
pub trait Reference: Sync {
    /// Name in reports, such as `cvode-bdf`.
    fn name(&self) -> &'static str;

    /// Whether the method suits stiff problems.
    fn stiff_ok(&self) -> bool;

    /// The library behind it and its version, such as `SUNDIALS 6.4.1`; `None` where it is not compiled in.
    fn library(&self) -> Option<String>;

    /// Solves from `(t0, v0)` once, with this relative and absolute tolerance; `times` as for [`solve`](Self::solve).
    ///
    /// # Errors
    /// [`ReferenceError`] if the solver fails, or if the request is malformed.
    fn run(&self, ode: &dyn Ode, t0: f64, v0: &[f64], times: &[f64], tolerance: f64) -> Result<Run, ReferenceError>;

    /// Solves from `(t0, v0)` and samples at `times` (not decreasing, each ≥ t0), with a bound on the error.
    ///
    /// # Errors
    /// [`ReferenceError`] if the solver fails, or if the request is malformed.
    fn solve(&self, ode: &dyn Ode, t0: f64, v0: &[f64], times: &[f64]) -> Result<Sampled, ReferenceError> {
        self.solve_within(ode, t0, v0, times, bound::FINE)
    }

    /// The same with a tolerance of one's own for the finer of the two solves.
    ///
    /// # Errors
    /// As for [`solve`](Self::solve), and for a tolerance that is not positive.
    fn solve_within(
        &self,
        ode: &dyn Ode,
        t0: f64,
        v0: &[f64],
        times: &[f64],
        finest: f64,
    ) -> Result<Sampled, ReferenceError> {
        if !(finest > 0.0 && finest < 1.0) {
            return Err(ReferenceError::Input(format!("the tolerance {finest} is not between 0 and 1")));
        }
        bound::solve_twice(ode, t0, v0, times, finest, |ode, tolerance, times| self.run(ode, t0, v0, times, tolerance))
    }
}

impl fmt::Debug for dyn Reference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::{Ode, all};

    /// v̇ = 0 with this longest step.
    pub(super) struct Still(pub(super) f64);

    impl Ode for Still {
        fn dim(&self) -> usize {
            1
        }
        fn rhs(&self, _t: f64, _v: &[f64], dv: &mut [f64]) {
            dv[0] = 0.0;
        }
        fn jacobian(&self, _t: f64, _v: &[f64], _add: &mut dyn FnMut(usize, usize, f64)) {}
        fn longest_step(&self, _span: f64) -> f64 {
            self.0
        }
    }

    #[test]
    fn a_system_that_does_not_say_so_is_neither_banded_nor_sparse_nor_matrix_free_nor_autonomous() {
        let still = Still(1.0);
        assert_eq!((still.bandwidths(), still.is_sparse()), (None, false));
        assert_eq!((still.is_matrix_free(), still.is_autonomous()), (false, false));
    }

    #[test]
    fn every_reference_that_is_compiled_in_names_its_library_with_a_version() {
        for reference in all() {
            let (name, library) = (reference.name(), reference.library());
            let version = |library: &str| {
                let prefix = if name.starts_with("cvode") { "SUNDIALS " } else { "diffsol " };
                library.strip_prefix(prefix).is_some_and(|version| version.starts_with(|c: char| c.is_ascii_digit()))
            };
            let is_built = cfg!(feature = "cvode") || !name.starts_with("cvode");
            assert_eq!(library.as_deref().map(version), is_built.then_some(true), "{name}: {library:?}");
        }
    }
}
