//! Verification of `lsvi`: problems, references, measures, studies and the report.
//!
//! Data flow one way: problem → method → trajectory → measure → evidence → report.
#![warn(missing_docs)]
#![deny(unsafe_code)]

pub mod advise;
pub mod bench;
pub mod chapter;
pub mod claim;
pub mod compare;
pub mod estimate;
pub mod evidence;
pub mod experiment;
pub mod golden;
pub mod judge;
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
pub mod report;
pub mod run;
pub mod theory;
