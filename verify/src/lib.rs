//! Verification of `lsvi`: studies, claims, goldens, judgements and the report.
//!
//! Data flow one way: experiment → evidence → report. What is measured, and with what, is the crate `experiments`, whose
//! modules are those of this crate too, as are the crates `evidence` and `judge`.
#![warn(missing_docs)]
#![deny(unsafe_code)]

pub mod advise;
pub mod chapter;
pub mod claim;
pub mod golden;
pub mod report;

pub use experiments::{
    bench, compare, estimate, experiment, kinds, measure, method, names, order, problem, program, reference,
    replacement, run, theory,
};
pub use {evidence, evidence::row, judge};
