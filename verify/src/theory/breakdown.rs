//! Where a method must fail.

use crate::kinds::{Principle, Stability};
use crate::method::Method;
use crate::problem::{Problem, Singular, Stiffness};

/// Why `method` cannot reach the horizon of `problem`, or not on the solution, however small its steps, where that is known:
/// a failure that is asserted.
pub fn breakdown(problem: &dyn Problem, method: &dyn Method) -> Option<&'static str> {
    let grows =
        method.stability() == Stability::Unstable && matches!(problem.facts().stiffness, Stiffness::Transient(_));
    if grows {
        return Some("the method's own solutions grow as fast as the problem's fastest transients decay");
    }
    free_residual(problem, method).map(|singular| singular.reason)
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
