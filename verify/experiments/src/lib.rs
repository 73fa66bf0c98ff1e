//! What `verify` judges: problems, methods, references, and the experiments that measure them.
//!
//! Data flow one way: problem → method → trajectory → measure → experiment.
#![warn(missing_docs)]
#![deny(unsafe_code)]

pub mod bench;
pub mod compare;
pub mod estimate;
pub mod experiment;
pub mod kinds;
pub mod measure;
pub mod method;
pub mod names;
pub mod order;
mod panics;
pub mod problem;
pub mod program;
pub mod reference;
pub mod replacement;
pub mod run;
pub mod theory;
