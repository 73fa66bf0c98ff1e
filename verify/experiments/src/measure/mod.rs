//! Pure functions from numbers to verdicts; no solver is called here.

pub mod amplification;
mod blocks;
pub mod decimal;
pub mod extrapolation;
pub mod norm;
pub mod order;
pub mod refinement;
pub mod search;
mod separated;
pub mod stability;
pub mod typeset;

pub(crate) use separated::fault;
pub use separated::line_of;
