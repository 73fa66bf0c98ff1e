//! How close the one-shape-function ansatz can come to the start-up flow, whatever the time step.

use lsvi::quadrature::Quadrature;

use super::errors::HORIZON;
use super::{Context, Experiment, StudyError};
use crate::measure::norm::max_norm;
use crate::measure::search::minimum;
use crate::problem::poiseuille_series::{SLOWEST_DECAY_RATE, velocity};

/// The pressure gradient of the figures.
pub const GAMMA: f64 = 2.0;
/// Rate of the Galerkin equation, to which Method I converges.
pub const GALERKIN_RATE: f64 = 2.5;
/// Rate of the domain-averaged equation (41).
pub const AVERAGED_RATE: f64 = 3.0;

/// "Roughly one-quarter" of \[S24\], wherever it is judged: nearer to ¼ than to the next unit fractions, ⅓ and ⅕.
pub const A_QUARTER: [f64; 2] = [9.0 / 40.0, 7.0 / 24.0];

/// Largest distances of v(t) from the centre velocity on (0, 10], for several v(t).
#[derive(Debug)]
pub struct Floors;

/// The distances max |v(t) − u(0, t)|.
#[derive(Debug)]
pub struct Found {
    /// Of the Galerkin equation's solution.
    pub galerkin: f64,
    /// Of the averaged equation's.
    pub averaged: f64,
    /// Of the relaxation with the slowest rate of the flow.
    pub slowest: f64,
    /// Of the relaxation with the best rate.
    pub best: f64,
    /// That rate.
    pub best_rate: f64,
    /// Of the parabola fitted to the profile by least squares.
    pub projection: f64,
}

impl Found {
    /// The maximum over 20000 points misses at most ⅛ v″ δt² with δt < 1.5e-4 where the maxima lie, and v″ < 10.
    pub const SAMPLING: f64 = 1e-7;
}

impl Experiment for Floors {
    const ID: &'static str = "floors";
    type Found = Found;

    fn measure(&self, _: &Context) -> Result<Found, StudyError> {
        let flow = sampled(20_000, |t| Ok(velocity(GAMMA, 0.0, t)?))?;
        let of_rate = |rate: f64| max_norm(&flow.iter().map(|(t, u)| -(-rate * t).exp_m1() - u).collect::<Vec<_>>());
        // The distance as a function of the rate has one minimum between the two: too slow early, too fast late.
        let best_rate = minimum([1.5, AVERAGED_RATE], 0.0, of_rate);
        let rule = Quadrature::gauss(40)?;
        let projected = sampled(1000, |t| {
            // v = (15/8) ∫₀¹ u (1 − y²) dy makes ∫(u − v(1 − y²))² dy least.
            let mut v = 0.0;
            for (y, b) in rule.nodes().iter().zip(rule.weights()) {
                v += 1.875 * b * velocity(GAMMA, *y, t)? * (1.0 - y * y);
            }
            Ok((v - velocity(GAMMA, 0.0, t)?).abs())
        })?;
        Ok(Found {
            galerkin: of_rate(GALERKIN_RATE),
            averaged: of_rate(AVERAGED_RATE),
            slowest: of_rate(SLOWEST_DECAY_RATE),
            best: of_rate(best_rate),
            best_rate,
            projection: max_norm(&projected.into_iter().map(|(_, d)| d).collect::<Vec<_>>()),
        })
    }
}

/// A function of time at points of (0, 10] that crowd towards 0.
fn sampled(count: u32, f: impl Fn(f64) -> Result<f64, StudyError>) -> Result<Vec<(f64, f64)>, StudyError> {
    let at = |k: u32| {
        let t = HORIZON * (f64::from(k) / f64::from(count)).powi(2);
        Ok((t, f(t)?))
    };
    (1..=count).map(at).collect()
}
