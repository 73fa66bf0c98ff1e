//! Verification of `lsvi`: problems, references, measures, studies and the report.
#![warn(missing_docs)]

pub mod evidence;
pub mod golden;
pub mod measure;
pub mod problems;
pub mod references;
