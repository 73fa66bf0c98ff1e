//! The studies, one file each: a question, the computation that answers it, and what it found.

mod advice;
mod answers;
mod channel_orders;
mod claims;
mod closed_forms;
pub(crate) mod constraints;
mod couette_large_steps;
pub mod cross_check;
mod error_control;
mod estimates;
pub(crate) mod figures;
mod flows;
mod high_order;
pub(crate) mod long_runs;
mod metrics;
pub mod model;
mod non_normal;
mod nonlinear_stability;
mod open_closures;
pub(crate) mod orders;
mod oscillator;
mod parts;
mod peers;
mod poiseuille_maps;
mod poiseuille_series;
mod prose;
mod published_values;
mod stability;
mod symplecticity;
mod work_precision;

use crate::evidence::Evidence;
pub use crate::experiment::{Context, StudyError};

/// An entry of the registry.
#[derive(Debug, Clone, Copy)]
pub struct Study {
    /// Stable identifier: file stem and anchor.
    pub id: &'static str,
    /// Title of its chapter.
    pub title: &'static str,
    /// The question it answers.
    pub question: &'static str,
    /// The statements it tests: equations, sections, claims.
    pub source: &'static str,
    /// The computation.
    pub run: fn(&Context) -> Result<Evidence, StudyError>,
}

/// All studies, in the order of the report.
pub const ALL: &[Study] = &[
    answers::STUDY,
    claims::STUDY,
    closed_forms::STUDY,
    orders::STUDY,
    cross_check::STUDY,
    figures::LINEAR_DRAG,
    figures::QUADRATIC_DRAG,
    poiseuille_series::STUDY,
    poiseuille_maps::STUDY,
    figures::POISEUILLE,
    stability::STUDY,
    channel_orders::STUDY,
    couette_large_steps::STUDY,
    flows::STUDY,
    non_normal::STUDY,
    nonlinear_stability::STUDY,
    metrics::STUDY,
    open_closures::STUDY,
    high_order::STUDY,
    error_control::STUDY,
    estimates::STUDY,
    published_values::STUDY,
    peers::STUDY,
    oscillator::STUDY,
    symplecticity::STUDY,
    long_runs::STUDY,
    constraints::STUDY,
    work_precision::STUDY,
    advice::STUDY,
];

/// Studies that take long, each with the one of [`ALL`] in the place of which `report --full` carries it out.
pub const LONG: &[(&str, Study)] = &[(flows::STUDY.id, flows::FULL)];

#[cfg(test)]
mod tests {
    use crate::{method, reference};

    /// A figure passes over a name that it has no series of, as without CVODE.
    #[test]
    fn figures_tell_methods_and_references_apart_by_their_names() {
        let told = [
            super::long_runs::TOLD.as_slice(),
            &super::symplecticity::TOLD,
            &super::work_precision::TOLD,
            &super::oscillator::TOLD,
            &super::peers::TOLD,
            &super::orders::TOLD,
        ];
        let is_known = |name: &str| match method::parse(name) {
            Ok(method) => method.name() == name,
            Err(_) => reference::all().iter().any(|reference| reference.name() == name),
        };
        for name in told.concat() {
            assert!(is_known(name), "{name}");
        }
    }
}
