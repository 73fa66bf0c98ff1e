//! The conventional closure of variational integrators.

use super::LinearClosure;
use crate::discrete::MomentumWeights;

/// p₀ = −D₁L_d is the momentum that the state carries: the symplectic map (q₀, p₀) → (q₁, p₁) of Eq. (8).
///
/// The right closure in mechanics. On a least-squares Lagrangian it is unstable: on v̇ = −v one step grows by
/// e^{2 asinh(h/2)}.
#[derive(Debug, Clone, Copy, Default)]
pub struct PositionMomentum;

impl LinearClosure for PositionMomentum {
    fn weights(&self, _h: f64) -> MomentumWeights {
        MomentumWeights::START
    }

    fn carried(&self) -> f64 {
        1.0
    }
}
