//! What ought to happen when a method meets a problem: the only module that knows both.
//!
//! A problem states [`Facts`](crate::problem::Facts), a method its [`Traits`](crate::method::Traits); what follows from the
//! two for their pair is derived here, one kind of expectation a file. A problem or a method that behaves as usual needs no
//! line here.

mod breakdown;
mod order;
pub mod oscillator;
mod structure;
mod suited;

pub use breakdown::{Breakdown, breakdown};
pub use order::{OrderPlan, order_plan};
pub use structure::is_symplectic;
pub use suited::{integrators_for, is_cheap, methods_for};

#[cfg(test)]
mod tests;
