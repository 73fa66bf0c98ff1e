//! The experiments, one file each: a pure function from a setting to typed rows, and the only module that runs methods and
//! references.
//!
//! Chapters, claims and goldens do not compute; they read. [`Context::get`] carries an experiment out the first time that it
//! is asked for with a setting and hands the same rows to everybody after that, so that two readers cannot disagree.

pub mod ansatz_step;
pub mod best_theta;
pub mod channel;
pub mod constraint;
mod context;
pub mod controls;
pub mod course;
pub mod cross_check;
pub mod end_errors;
pub mod ends;
pub mod energy_course;
pub mod energy_drift;
pub mod error_control;
pub mod errors;
pub mod estimates;
pub mod fates;
pub mod floors;
pub mod flow;
pub mod high_order;
pub mod homogeneous;
pub mod kepler_period;
pub mod live_steps;
pub mod maps;
pub mod metric;
pub mod minimax;
pub mod momentum_map;
pub mod motion;
pub mod non_normal;
pub mod one_step;
pub mod orders;
pub mod oscillator;
pub mod pendulum_orbit;
mod propagator;
pub use propagator::{ProbeError, SCALED, exponential, growth, propagator, step_error};
pub mod published_values;
pub mod reversal;
pub mod sensitivity;
pub mod stability;
pub mod step_equation;
mod step_map;
pub mod symplectic_defect;
pub mod work_error;

pub use context::{Context, side_by_side};

use std::error::Error;
use std::fmt::Debug;
use std::sync::Arc;

/// What stopped a computation.
pub type StudyError = Box<dyn Error + Send + Sync>;

/// An experiment that could not be carried out; all who ask for it get the same.
#[derive(Debug, Clone, thiserror::Error)]
#[error("experiment `{id}`: {source}")]
pub struct ExperimentError {
    id: &'static str,
    source: Arc<dyn Error + Send + Sync>,
}

/// A question to solvers. The value that implements it is the setting.
///
/// What is found depends on the setting and on [`Context::max_steps`] alone. Experiments may read each other, without a circle.
///
/// ```
/// use experiments::experiment::{Context, Experiment, StudyError};
///
/// /// h² of a step size.
/// #[derive(Debug)]
/// struct Square {
///     h: f64,
/// }
///
/// impl Experiment for Square {
///     const ID: &'static str = "square";
///     type Found = f64;
///     fn measure(&self, _: &Context) -> Result<f64, StudyError> {
///         Ok(self.h * self.h)
///     }
/// }
///
/// let context = Context::silent();
/// assert_eq!(*context.get(Square { h: 0.5 })?, 0.25);
/// # Ok::<(), experiments::experiment::ExperimentError>(())
/// ```
pub trait Experiment: Debug + Send + Sync + 'static {
    /// Stable identifier: the file stem. With the setting's `Debug` text, which keeps every digit, it names what was found.
    const ID: &'static str;

    /// What is found: rows, mostly.
    type Found: Send + Sync + 'static;

    /// Carries it out.
    ///
    /// # Errors
    /// Whatever stops the computation as a whole. What a single run cannot do belongs into its row.
    fn measure(&self, context: &Context) -> Result<Self::Found, StudyError>;
}
