//! The coefficients of the linear closure with the smallest largest one-step error on v̇ = −v.

use super::one_step::OneStep;
use super::{Context, Experiment, StudyError};
use crate::measure::norm::{Extremes, larger};
use crate::measure::search::{logarithmic, try_minimum};

/// For step sizes up to a bound.
#[derive(Debug)]
pub struct BestTheta {
    /// The bound.
    pub range: f64,
}

/// The best constant θ = −α/β, and the largest errors.
#[derive(Debug)]
pub struct Found {
    /// The best θ in [0, 1], to seven digits: the largest error grows beside it by half of what θ is off.
    pub theta: f64,
    /// The largest error with it.
    pub best: f64,
    /// That of Method I, θ = 0.
    pub method_i: f64,
    /// That of Method II, θ = 1.
    pub method_ii: f64,
    /// That of the closure made for it, by another computation.
    pub minimax: f64,
    /// Largest errors by θ.
    pub curve: Vec<(f64, f64)>,
}

impl Experiment for BestTheta {
    const ID: &'static str = "best-theta";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        context.announce(1);
        let range = self.range;
        let of_theta = |theta: f64| worst(context, &format!("linear({:?},1.0)", -theta), range);
        let theta = try_minimum([0.0, 1.0], 1e-7, of_theta)?;
        let points = (0..=100).map(|i| 0.01 * f64::from(i)).map(|theta| Ok((theta, of_theta(theta)?)));
        let found = Found {
            theta,
            best: of_theta(theta)?,
            method_i: of_theta(0.0)?,
            method_ii: of_theta(1.0)?,
            minimax: worst(context, &format!("minimax(0,{range})"), range)?,
            curve: points.collect::<Result<_, StudyError>>()?,
        };
        context.tick();
        Ok(found)
    }
}

/// Largest one-step error on v̇ = −v over step sizes up to `range`.
fn worst(context: &Context, method: &str, range: f64) -> Result<f64, StudyError> {
    let error = |h: f64| -> Result<f64, StudyError> {
        let factor = OneStep::growth(method, h).measure(context)?.unwrap_or(f64::INFINITY);
        Ok((factor - (-h).exp()).abs())
    };
    // Down to 10⁻³ of the range, below which all errors are small; the largest between points lies beside those at its sides.
    let points = logarithmic([1e-3 * range, range], 20);
    let errors = points.iter().map(|h| error(*h)).collect::<Result<Vec<_>, _>>()?;
    let mut worst = errors.iter().copied().largest();
    for (h, errors) in points.windows(3).zip(errors.windows(3)) {
        if errors[1] >= errors[0] && errors[1] >= errors[2] {
            let at = try_minimum([h[0], h[2]], 1e-4 * h[1], |h| error(h).map(|error| -error))?;
            worst = larger(worst, error(at)?);
        }
    }
    Ok(worst)
}
