//! Where a method must fail.

use crate::kinds::{Principle, Stability};
use crate::method::Method;
use crate::problem::{Problem, Singular, Stiffness};

/// A failure that is known beforehand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Breakdown {
    /// Why.
    pub reason: &'static str,
    /// Whether it must happen, however small the steps, so that it is asserted; else it has no time to, if they are small enough.
    pub is_certain: bool,
}

/// Why `method` may not reach `horizon` on the solution of `problem`, where that is known.
///
/// A solution of the method's own that grows like e^{λt} starts from a rounding ε of the true one at least, and has overtaken it,
/// whatever the step, where λt > ln(1/ε).
pub fn breakdown(problem: &dyn Problem, method: &dyn Method, horizon: f64) -> Option<Breakdown> {
    let stiffness = problem.facts().stiffness;
    if let (Stability::Unstable, Stiffness::Transient(rate) | Stiffness::Forced(rate)) = (method.stability(), stiffness)
    {
        let reason = "the method's own solutions grow as fast as the problem's fastest transients decay";
        return Some(Breakdown { reason, is_certain: rate * horizon > -f64::EPSILON.ln() });
    }
    let free = free_residual(problem, method).filter(|singular| singular.from <= horizon);
    free.map(|Singular { reason, .. }| Breakdown { reason, is_certain: true })
}

/// Where the equation of a step of `method` leaves the residual free on `problem`.
///
/// As h → 0 a closure with p₁ = p₀ is Jᵀ(r₀ + r₁) = 0, which determines the residuals r only where J = ∂f/∂v is regular; one
/// with p₁ = (1 − ½hλ) p₀ is (½λ − Jᵀ)(r₀ + r₁) = 0, and does so where ½λ is no eigenvalue of J.
pub(super) fn free_residual(problem: &dyn Problem, method: &dyn Method) -> Option<Singular> {
    match method.principle() {
        Principle::MomentumConserved => problem.facts().singular,
        Principle::MomentumDecaying => problem.facts().growing,
        _ => None,
    }
}
