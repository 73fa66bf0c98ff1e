//! What a user may choose about adaptive steps.

use super::tolerances::Tolerances;
use crate::error::{InputError, SettingError};

/// Tolerances and bounds of adaptive steps; each setting checks what it is given.
///
/// ```
/// # use lsvi::adaptive::{Options, Tolerances};
/// let options = Options::new(Tolerances::new(1e-8, 1e-10)?)
///     .h0(1e-3)?
///     .h_max(0.5)?
///     .max_steps(10_000)?
///     .stages(3, 5)?;
/// assert!(options.clone().safety(1.5).is_err());
/// assert!(options.h_max(0.0).is_err());
/// # Ok::<(), lsvi::InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct Options {
    pub(super) tolerances: Tolerances,
    pub(super) h0: Option<f64>,
    pub(super) h_min: f64,
    pub(super) h_max: f64,
    pub(super) safety: f64,
    pub(super) max_steps: u64,
    pub(super) fewest: usize,
    pub(super) most: usize,
}

impl From<Tolerances> for Options {
    fn from(tolerances: Tolerances) -> Self {
        Self::new(tolerances)
    }
}

impl Options {
    /// Steps of any size and number, three to seven stages, a safety factor of 0.9.
    pub fn new(tolerances: Tolerances) -> Self {
        Self {
            tolerances,
            h0: None,
            h_min: 0.0,
            h_max: f64::INFINITY,
            safety: 0.9,
            max_steps: u64::MAX,
            fewest: 3,
            most: 7,
        }
    }

    /// The first step to be tried, unless it is longer or shorter than a step may be; without it, one that changes v by about a
    /// hundredth.
    ///
    /// # Errors
    /// [`SettingError::Setting`] unless positive and finite.
    pub fn h0(self, h: f64) -> Result<Self, InputError> {
        let positive = h.is_finite() && h > 0.0;
        checked("h0", h, "positive and finite", positive).map(|h| Self { h0: Some(h), ..self })
    }

    /// The longest step, besides that of the grid.
    ///
    /// # Errors
    /// [`SettingError::Setting`] unless positive, [`SettingError::StepBounds`] below the shortest.
    pub fn h_max(self, h: f64) -> Result<Self, InputError> {
        checked("h_max", h, "positive", h > 0.0).and_then(|h_max| Self { h_max, ..self }.bounded())
    }

    /// The shortest step that may be tried, unless less is left of the interval; a tolerance that is not met by it fails with
    /// [`StepError::BelowShortest`](crate::StepError::BelowShortest).
    ///
    /// # Errors
    /// [`SettingError::Setting`] unless finite and not negative, [`SettingError::StepBounds`] above the longest.
    pub fn h_min(self, h: f64) -> Result<Self, InputError> {
        checked("h_min", h, "finite and not negative", h.is_finite() && h >= 0.0)
            .and_then(|h_min| Self { h_min, ..self }.bounded())
    }

    fn bounded(self) -> Result<Self, InputError> {
        let Self { h_min, h_max, .. } = self;
        if h_min <= h_max { Ok(self) } else { Err(InputError::Setting(SettingError::StepBounds { h_min, h_max })) }
    }

    /// The part of the step size that the estimate would allow which is tried.
    ///
    /// # Errors
    /// [`SettingError::Setting`] unless in (0, 1).
    pub fn safety(self, factor: f64) -> Result<Self, InputError> {
        checked("safety", factor, "between 0 and 1", factor > 0.0 && factor < 1.0).map(|safety| Self { safety, ..self })
    }

    /// How many steps may be tried in one run, rejected ones included, before
    /// [`StepError::TooManySteps`](crate::StepError::TooManySteps); a run that is [resumed](crate::Trajectory::resume) has as many again. Any
    /// number by default, in which a run that slides along a jump of f, as by dry friction, may go on for very long.
    ///
    /// # Errors
    /// [`SettingError::Setting`] for none.
    pub fn max_steps(self, limit: u64) -> Result<Self, InputError> {
        checked("max_steps", limit as f64, "at least 1", limit > 0)?;
        Ok(Self { max_steps: limit, ..self })
    }

    /// The numbers of stages s that may be chosen from: 3, 5, 7, of order 2s − 1 = 5, 9, 13.
    ///
    /// # Errors
    /// [`SettingError::Stages`] unless both are among them and in order.
    pub fn stages(self, fewest: usize, most: usize) -> Result<Self, InputError> {
        if [fewest, most].iter().all(|s| [3, 5, 7].contains(s)) && fewest <= most {
            Ok(Self { fewest, most, ..self })
        } else {
            Err(InputError::Setting(SettingError::Stages { fewest, most }))
        }
    }
}

fn checked(what: &'static str, value: f64, range: &'static str, holds: bool) -> Result<f64, InputError> {
    if holds { Ok(value) } else { Err(InputError::Setting(SettingError::Setting { what, value, range })) }
}
