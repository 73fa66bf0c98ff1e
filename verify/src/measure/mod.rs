//! Pure functions from numbers to verdicts; no solver is called here.

pub mod order;
pub mod richardson;
