//! Two-dimensional flows of a viscous incompressible fluid, u_t + (u·∇)u + ∇p = ν Δu + f, ∇·u = 0.
//!
//! Between walls the velocities are those of a stream function on a [`staggered`] grid; on the periodic square the vorticity is
//! a [Fourier sum](fourier). Both are `VectorField`s with a mass matrix that measures the residual by its kinetic energy.

mod by_hand;
mod cavity;
mod channel;
mod confined;
mod convolution;
mod fourier;
mod kovasznay;
mod momentum;
mod periodic;
mod problem;
mod staggered;
#[cfg(test)]
mod tests;
mod vortices;

pub(super) use cavity::{CAVITY, MANUFACTURED};
pub(crate) use cavity::{lid, manufactured};
pub(super) use channel::SPEC as CHANNEL;
pub(crate) use confined::Given;
pub(super) use kovasznay::SPEC as KOVASZNAY;
pub(crate) use momentum::acceleration;
pub(super) use vortices::{SHEAR_LAYER, TAYLOR_GREEN, TURBULENCE};

/// Their names.
pub(super) const NAMES: &[&str] = &[
    CAVITY.name,
    MANUFACTURED.name,
    CHANNEL.name,
    KOVASZNAY.name,
    TAYLOR_GREEN.name,
    SHEAR_LAYER.name,
    TURBULENCE.name,
];
