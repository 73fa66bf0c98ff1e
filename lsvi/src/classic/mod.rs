//! Classical integrators of v̇ = f(t, v): the baseline methods.

mod bdf2;
mod coupled;
mod linear;
mod runge_kutta;
mod stage;
mod start;

pub use bdf2::Bdf2;
pub use coupled::CoupledRungeKutta;
pub use runge_kutta::{RungeKutta, Tableau};
