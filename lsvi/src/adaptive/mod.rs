//! Adaptive integration: collocation with an estimate of its error, and a step size that follows from it.

mod coefficients;
mod controller;
mod radau;

pub use controller::Tolerances;
pub use radau::Radau;
