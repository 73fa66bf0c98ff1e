//! Closures: the condition on the discrete momenta that makes one step a solvable system.

mod fitted;
mod homogeneous;
mod linear;
mod position_momentum;

pub use linear::Linear;
pub use position_momentum::PositionMomentum;

use crate::discrete::MomentumWeights;

/// The condition α p₀ + β p₁ = σ p on the momenta at the two ends of a step: n equations for q₁.
pub trait Closure {
    /// The weights (α, β) at step size `h`.
    fn weights(&self, h: f64) -> MomentumWeights;

    /// σ, the weight of the momentum p that the state carries; 0 for closures that need no history.
    fn carried(&self) -> f64 {
        0.0
    }
}
