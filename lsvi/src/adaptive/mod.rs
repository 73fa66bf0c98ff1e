//! Adaptive integration: collocation with an estimate of its error, and a step size and an order that follow from it.

mod coefficients;
mod controller;
mod history;
mod options;
mod radau;
mod stages;
mod tolerances;

pub use options::Options;
pub use radau::Radau;
pub use tolerances::Tolerances;
