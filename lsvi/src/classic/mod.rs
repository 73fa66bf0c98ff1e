//! Classical integrators of v̇ = f(t, v): the baseline methods.

mod bdf2;
mod runge_kutta;
mod stage;

pub use bdf2::Bdf2;
pub use runge_kutta::{RungeKutta, Tableau};
