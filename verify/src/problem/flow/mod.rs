//! Two-dimensional flows of a viscous incompressible fluid, u_t + (u·∇)u + ∇p = ν Δu + f, ∇·u = 0.
//!
//! Between walls the velocities are those of a stream function on a [`staggered`] grid.

mod confined;
mod momentum;
mod staggered;
#[cfg(test)]
mod tests;
