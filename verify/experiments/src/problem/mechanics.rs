//! What a mechanical problem gives the variational integrators, and what its motion conserves.

use lsvi::{Constraint, EulerLagrange};

use crate::kinds::System;

/// A mechanical system: a Lagrangian L(t, q, v) in n degrees of freedom, with constraints where it has them.
///
/// The state of its [`Problem`](super::Problem) is (q, p) with p = ∂L/∂v, 2n components.
pub struct Mechanics<'a> {
    /// Its class.
    pub system: System,
    /// L with its Euler–Lagrange equations; a force, where there is one, is part of them ([`lsvi::Forced`]).
    pub lagrangian: Box<dyn EulerLagrange + 'a>,
    /// Holonomic constraints f(q) = 0. In the equations of the problem the multipliers are eliminated by f̈ = 0.
    pub constraint: Option<Box<dyn Constraint + 'a>>,
}

impl<'a> Mechanics<'a> {
    /// The motions of `lagrangian`, a system of the class `system`, in all of space.
    pub(super) fn new(system: System, lagrangian: impl EulerLagrange + 'a) -> Self {
        Self { system, lagrangian: Box::new(lagrangian), constraint: None }
    }

    /// The same on the manifold f(q) = 0.
    pub(super) fn constrained(self, constraint: impl Constraint + 'a) -> Self {
        Self { constraint: Some(Box::new(constraint)), ..self }
    }
}

/// A function of the state that the motion conserves, or would without friction.
pub struct Invariant<'a> {
    /// Its name in tables and figures.
    pub name: &'static str,
    value: Box<Value<'a>>,
}

type Value<'a> = dyn Fn(&[f64]) -> f64 + Sync + 'a;

impl<'a> Invariant<'a> {
    pub(super) fn new(name: &'static str, value: impl Fn(&[f64]) -> f64 + Sync + 'a) -> Self {
        Self { name, value: Box::new(value) }
    }

    /// Its value at `state`, all components of the problem.
    pub fn value(&self, state: &[f64]) -> f64 {
        (self.value)(state)
    }
}

#[cfg(test)]
mod tests;
