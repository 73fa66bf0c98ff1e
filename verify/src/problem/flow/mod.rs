//! Two-dimensional flows of a viscous incompressible fluid, u_t + (u·∇)u + ∇p = ν Δu + f, ∇·u = 0.
//!
//! Between walls the velocities are those of a stream function on a [`staggered`] grid.

mod by_hand;
mod cavity;
mod channel;
mod confined;
mod kovasznay;
mod momentum;
mod problem;
mod staggered;
#[cfg(test)]
mod tests;

pub(super) use cavity::{CAVITY, MANUFACTURED};
pub(super) use channel::SPEC as CHANNEL;
pub(super) use kovasznay::SPEC as KOVASZNAY;

/// Their names.
pub(super) const NAMES: &[&str] = &[CAVITY.name, MANUFACTURED.name, CHANNEL.name, KOVASZNAY.name];
