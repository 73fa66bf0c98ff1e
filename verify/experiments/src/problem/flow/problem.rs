//! Flows in a rectangle as problems.

use std::sync::OnceLock;

use lsvi::solver::{Iterative, StepSolver};
use lsvi::{Factored, VectorField};

use super::by_hand::{ByHand, Factors};
use super::confined::{Confined, Given};
use super::staggered::{Component, Rectangle};
use crate::kinds::Principle;
use crate::problem::{Facts, Limit, Problem};
use crate::reference::Ode;

/// A [`Confined`] flow with its statement by hand.
#[derive(Debug)]
pub(super) struct InRectangle {
    pub(super) flow: Confined,
    factors: OnceLock<Option<Factors>>,
}

impl InRectangle {
    pub(super) fn new(rectangle: Rectangle, nu: f64, given: impl Given + 'static) -> Self {
        Self { flow: Confined::new(rectangle, nu, Box::new(given)), factors: OnceLock::new() }
    }

    fn by_hand(&self) -> ByHand<'_> {
        let Confined { space, nu, given, .. } = &self.flow;
        ByHand { rectangle: space.rectangle, nu: *nu, given: &**given, factors: &self.factors }
    }

    /// A bound of the fastest rate of decay, 4ν (1/Δx² + 1/Δy²).
    fn fastest(&self) -> f64 {
        let [dx, dy] = self.flow.space.rectangle.spacing();
        4.0 * self.flow.nu * (dx.powi(-2) + dy.powi(-2))
    }
}

impl Ode for InRectangle {
    fn dim(&self) -> usize {
        self.flow.space.dim
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.by_hand().rhs(t, v, dv);
    }
    fn jacobian(&self, t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        self.by_hand().jacobian(t, v, add);
    }
    fn product(&self, t: f64, v: &[f64], x: &[f64], out: &mut [f64]) {
        self.by_hand().product(t, v, x, out);
    }
    fn is_matrix_free(&self) -> bool {
        self.by_hand().is_matrix_free()
    }
}

impl Problem for InRectangle {
    fn components(&self) -> &'static [&'static str] {
        &["velocity"]
    }
    /// The velocities of the interior faces: u, then v.
    fn observe(&self, t: f64, state: &[f64]) -> Vec<f64> {
        let w = self.flow.velocities(t, state);
        self.flow.space.faces.iter().map(|face| w[face.at]).collect()
    }
    fn initial(&self) -> Vec<f64> {
        let space = &self.flow.space;
        space.corners.iter().map(|at| self.flow.given.stream(*at, 0.0)).collect()
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(self.flow.field())
    }
    /// Conjugate gradients with one LU of B, kept as long as it serves.
    fn solver(&self) -> Option<Box<dyn StepSolver>> {
        Some(Box::new(Iterative::new(Factored::default())))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        let space = &self.flow.space;
        let component = |component| usize::from(component == Component::V);
        space.faces.iter().map(|face| Some(self.flow.given.exact(face.point, t)?[component(face.component)])).collect()
    }
    fn limit(&self, _principle: Principle) -> Limit<'_> {
        Limit::semi_discrete(self, |_| None)
    }
    fn facts(&self) -> Facts {
        Facts::semi_discrete(self.fastest())
    }
}
