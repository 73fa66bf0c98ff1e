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
/// "A third" likewise: nearer to ⅓ than to ¼ and to ½.
pub const A_THIRD: [f64; 2] = [7.0 / 24.0, 5.0 / 12.0];
/// "As close as the shape function allows": within a hundredth of the least.
pub const CLOSE: f64 = 1.01;

/// Largest distances of v(t) (1 − y²) from the flow on (0, 10], for several v(t).
#[derive(Debug)]
pub struct Floors;

/// The distances at the centre, max |v(t) − u(0, t)|, and those of the profile.
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
    /// Of the profiles.
    pub profile: Profile,
}

/// The distances max_t √(∫₀¹ (v(t)(1 − y²) − u(y, t))² dy): root mean squares over the channel.
#[derive(Debug)]
pub struct Profile {
    /// Of the Galerkin equation's solution.
    pub galerkin: f64,
    /// Of the averaged equation's.
    pub averaged: f64,
    /// Of the relaxation with the slowest rate of the flow.
    pub slowest: f64,
    /// Of the relaxation with the rate that is best at the centre.
    pub best_at_the_centre: f64,
    /// Of the relaxation with the best rate.
    pub best: f64,
    /// That rate.
    pub best_rate: f64,
    /// Of the least-squares fit at each time, the least that any v(t) has.
    pub projection: f64,
    /// Of v(t) = u(0, t), which has no error at the centre.
    pub exact_at_the_centre: f64,
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
        let profiles = sampled(PROFILES, |t| Moments::of(&rule, t))?;
        let from_centre = |(t, moments): &(f64, Moments)| Ok(moments.fitted() - velocity(GAMMA, 0.0, *t)?);
        let projected = profiles.iter().map(from_centre).collect::<Result<Vec<_>, StudyError>>()?;
        Ok(Found {
            galerkin: of_rate(GALERKIN_RATE),
            averaged: of_rate(AVERAGED_RATE),
            slowest: of_rate(SLOWEST_DECAY_RATE),
            best: of_rate(best_rate),
            best_rate,
            projection: max_norm(&projected),
            profile: Profile::of(&profiles, best_rate)?,
        })
    }
}

impl Profile {
    fn of(profiles: &[(f64, Moments)], best_at_the_centre: f64) -> Result<Self, StudyError> {
        let largest = |v: &dyn Fn(f64, &Moments) -> f64| {
            max_norm(&profiles.iter().map(|(t, moments)| moments.distance(v(*t, moments))).collect::<Vec<_>>())
        };
        let of_rate = |rate: f64| largest(&|t, _| -(-rate * t).exp_m1());
        let best_rate = minimum([1.5, AVERAGED_RATE], 0.0, of_rate);
        let exact = profiles.iter().map(|(t, moments)| Ok(moments.distance(velocity(GAMMA, 0.0, *t)?)));
        Ok(Self {
            galerkin: of_rate(GALERKIN_RATE),
            averaged: of_rate(AVERAGED_RATE),
            slowest: of_rate(SLOWEST_DECAY_RATE),
            best_at_the_centre: of_rate(best_at_the_centre),
            best: of_rate(best_rate),
            best_rate,
            projection: largest(&|_, moments| moments.fitted()),
            exact_at_the_centre: max_norm(&exact.collect::<Result<Vec<_>, StudyError>>()?),
        })
    }
}

/// Times at which profiles are compared: with δt < 2e-3 where the maxima lie the largest distance misses at most ⅛ · 10 δt², 5e-6.
const PROFILES: u32 = 4000;

/// ∫₀¹ u² dy and ∫₀¹ u (1 − y²) dy at one time, which give the distance of every parabola.
struct Moments([f64; 2]);

impl Moments {
    /// ∫₀¹ (1 − y²)² dy.
    const PARABOLA: f64 = 8.0 / 15.0;

    fn of(rule: &Quadrature, t: f64) -> Result<Self, StudyError> {
        let mut moments = [0.0; 2];
        for (y, b) in rule.nodes().iter().zip(rule.weights()) {
            let u = velocity(GAMMA, *y, t)?;
            moments[0] += b * u * u;
            moments[1] += b * u * (1.0 - y * y);
        }
        Ok(Self(moments))
    }

    /// The v that makes ∫(u − v(1 − y²))² dy least.
    fn fitted(&self) -> f64 {
        self.0[1] / Self::PARABOLA
    }

    /// The root mean square of u − v(1 − y²).
    fn distance(&self, v: f64) -> f64 {
        let [square, product] = self.0;
        (square - 2.0 * v * product + v * v * Self::PARABOLA).abs().sqrt()
    }
}

/// A function of time at points of (0, 10] that crowd towards 0.
fn sampled<T>(count: u32, f: impl Fn(f64) -> Result<T, StudyError>) -> Result<Vec<(f64, T)>, StudyError> {
    let at = |k: u32| {
        let t = HORIZON * (f64::from(k) / f64::from(count)).powi(2);
        Ok((t, f(t)?))
    };
    (1..=count).map(at).collect()
}
