//! Verification of `lsvi`: problems, references, measures, studies and the report.
//!
//! Data flow one way: problem → method → trajectory → measure → evidence → report.
#![warn(missing_docs)]
#![deny(unsafe_code)]

pub mod claims;
pub mod compare;
pub mod evidence;
pub mod golden;
pub mod measure;
pub mod methods;
pub mod names;
pub mod order;
pub mod problems;
mod propagator;
pub mod references;
pub mod report;
pub mod run;
pub mod studies;
