//! Classical integrators of v̇ = f(t, v): the yardsticks.

mod bdf2;
mod runge_kutta;

pub use bdf2::Bdf2;
pub use runge_kutta::{RungeKutta, Tableau};
