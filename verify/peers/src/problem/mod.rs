//! Problems, stated once for all solvers: f and its Jacobian by hand, on arrays whose length the compiler knows.

mod burgers;
mod channel;
mod hires;
mod kepler;
mod pendulum;
mod robertson;
mod van_der_pol;

pub(crate) use burgers::Burgers;
pub(crate) use channel::Channel;
pub(crate) use hires::Hires;
pub(crate) use kepler::Kepler;
pub(crate) use pendulum::Pendulum;
pub(crate) use robertson::Robertson;
pub(crate) use van_der_pol::VanDerPol;

use experiments::names::NameError;
use experiments::problem;
use experiments::reference::Ode;
use lsvi::{Jacobian, Structure, VectorField};

use crate::solver::Solver;

/// The largest difference of two independent solutions of which one is the reference: a hundredth of the least error that is
/// asked for, and no more.
const AGREEMENT: f64 = 1e-11;

/// A first-order system v̇ = f(t, v) in N unknowns.
pub(crate) trait System<const N: usize>: Sync {
    /// Lower and upper bandwidth of the Jacobian, where it is banded.
    const BAND: Option<(usize, usize)> = None;

    /// Whether f(t, v) = A v + g with constant A and g.
    const IS_LINEAR: bool = false;

    /// Writes f(t, v).
    fn rhs(&self, t: f64, v: &[f64; N], dv: &mut [f64; N]);

    /// Calls `add(i, j, x)` with x = ∂f_i/∂v_j, once for each entry that may differ from zero.
    fn jacobian(&self, t: f64, v: &[f64; N], add: impl FnMut(usize, usize, f64));
}

/// A system from a start to an end at which its solution is known.
#[derive(Debug)]
pub(crate) struct Problem<const N: usize, S> {
    pub(crate) system: S,
    pub(crate) start: [f64; N],
    pub(crate) end: f64,
    /// The solution there.
    pub(crate) truth: [f64; N],
}

/// Why a problem has no reference solution.
#[derive(Debug, thiserror::Error)]
pub(crate) enum TruthError {
    /// The registry of `verify` does not have it.
    #[error(transparent)]
    Name(#[from] NameError),
    /// There is a problem but no solution of so many components.
    #[error("{problem} has no known solution at t = {t}")]
    Unknown { problem: &'static str, t: f64 },
    /// Two solvers that share no code do not agree.
    #[error("two solvers differ by {difference:.1e} on {problem}, more than {allowed:.0e}")]
    Disagreement { problem: &'static str, difference: f64, allowed: f64 },
}

impl<const N: usize, S: System<N>> Problem<N, S> {
    /// The problem of `verify` of that name, with its closed form or its table of more digits than a double has.
    fn known(system: S, name: &'static str, end: f64) -> Result<Self, TruthError> {
        let problem = problem::build_setting(name)?;
        let truth = problem.exact(end).or_else(|| problem.tabulated(end));
        let whole = |state: Vec<f64>| <[f64; N]>::try_from(state).ok();
        match (whole(problem.initial()), truth.and_then(whole)) {
            (Some(start), Some(truth)) => Ok(Self { system, start, end, truth }),
            _ => Err(TruthError::Unknown { problem: name, t: end }),
        }
    }

    /// The error of a state at the end, max |vᵢ − truthᵢ| / max |truthᵢ|, the same measure for all; NaN is an infinite one.
    pub(crate) fn error(&self, state: &[f64]) -> f64 {
        relative_difference(state, &self.truth)
    }
}

/// max |aᵢ − bᵢ| / max |bᵢ|, infinite where it is not a number.
fn relative_difference(a: &[f64], b: &[f64]) -> f64 {
    let largest = |x: f64, y: f64| if y.is_nan() { f64::INFINITY } else { x.max(y.abs()) };
    let difference = a.iter().zip(b).map(|(a, b)| a - b).fold(0.0, largest);
    difference / b.iter().copied().fold(0.0, largest)
}

/// The solution by one solver, once another that shares no code with it agrees to [`AGREEMENT`].
fn agreed<const N: usize, S: System<N>>(
    name: &'static str,
    problem: Problem<N, S>,
    by: [(&dyn Solver<Problem<N, S>>, f64); 2],
) -> Result<Problem<N, S>, TruthError> {
    let [first, second] = by.map(|(solver, setting)| solver.run(&problem, setting));
    let unknown = TruthError::Unknown { problem: name, t: problem.end };
    let (Some(first), Some(second)) = (first, second) else { return Err(unknown) };
    let difference = relative_difference(&second, &first);
    match <[f64; N]>::try_from(first) {
        Ok(truth) if difference <= AGREEMENT => Ok(Problem { truth, ..problem }),
        Ok(_) => Err(TruthError::Disagreement { problem: name, difference, allowed: AGREEMENT }),
        Err(_) => Err(unknown),
    }
}

/// A system as `lsvi` and the references of `verify` take it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Field<'a, const N: usize, S>(pub(crate) &'a S);

/// A slice of N entries, which is what solvers of a system of N unknowns pass.
pub(crate) fn array<const N: usize>(v: &[f64]) -> &[f64; N] {
    v.try_into().expect("a state has N entries")
}

/// The same to be written.
pub(crate) fn array_mut<const N: usize>(v: &mut [f64]) -> &mut [f64; N] {
    v.try_into().expect("a state has N entries")
}

impl<const N: usize, S: System<N>> VectorField for Field<'_, N, S> {
    fn dim(&self) -> usize {
        N
    }
    fn structure(&self) -> Structure {
        S::BAND.map_or(Structure::Dense, |(lower, upper)| Structure::Banded { lower, upper })
    }
    fn is_linear(&self) -> bool {
        S::IS_LINEAR
    }
    fn is_autonomous(&self) -> bool {
        S::IS_LINEAR
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.0.rhs(t, array(v), array_mut(dv));
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.0.jacobian(t, array(v), |i, j, x| out.add(i, j, scale * x));
    }
}

impl<const N: usize, S: System<N>> Ode for Field<'_, N, S> {
    fn dim(&self) -> usize {
        N
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.0.rhs(t, array(v), array_mut(dv));
    }
    fn jacobian(&self, t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        self.0.jacobian(t, array(v), add);
    }
    fn bandwidths(&self) -> Option<(usize, usize)> {
        S::BAND
    }
}
