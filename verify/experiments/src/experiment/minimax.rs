//! The constant with the least largest error of one step on v̇ = −v over a range of steps, beside others.

use lsvi::closure::{Linear, LinearClosure};

use super::one_step::OneStep;
use super::{Context, Experiment, StudyError};
use crate::measure::norm::{Extremes, larger};
use crate::measure::search::try_minimum;

/// Steps that are sampled; around the extreme ones a search goes on.
const SAMPLES: f64 = 300.0;

/// Steps from `from` to `to`.
#[derive(Debug)]
pub struct Minimax {
    /// The shortest.
    pub from: f64,
    /// The longest.
    pub to: f64,
}

/// Largest errors over the range, of live steps.
#[derive(Debug)]
pub struct Found {
    /// θ = −α/β of the best constant.
    pub theta: f64,
    /// Its extreme errors.
    pub extremes: [f64; 2],
    /// Of the better of two constants beside it.
    pub neighbour: f64,
    /// That of Method I.
    pub method_i: f64,
    /// That of Method II.
    pub method_ii: f64,
    /// That of implicit Euler.
    pub implicit_euler: f64,
}

impl Found {
    /// The largest error of the best constant.
    pub fn best(&self) -> f64 {
        modulus(self.extremes)
    }
}

fn modulus([low, high]: [f64; 2]) -> f64 {
    larger(high, -low)
}

/// θ = −α/β of the best constant for steps in a range.
pub fn theta(from: f64, to: f64) -> Result<f64, StudyError> {
    let weights = Linear::minimax(from, to)?.weights(1.0);
    Ok(-weights.alpha / weights.beta)
}

impl Experiment for Minimax {
    const ID: &'static str = "minimax";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        let Self { from, to } = *self;
        // Finer towards the lower end, where the error of a wide range has its maximum.
        let step = |k: u32| from + (to - from) * (f64::from(k) / SAMPLES).powi(2);
        let extremes = |method: &str| -> Result<[f64; 2], StudyError> {
            let error =
                |h: f64| -> Result<f64, StudyError> { Ok(OneStep::growth(method, h).measure(context)?? - (-h).exp()) };
            let errors = (1..=SAMPLES as u32).map(|k| error(step(k))).collect::<Result<Vec<_>, _>>()?;
            let extreme = |sign: f64| -> Result<f64, StudyError> {
                let signed = errors.iter().map(|error| sign * error);
                let largest = signed.clone().fold(0.0, larger);
                let Some(place) = signed.clone().position(|error| error == largest) else { return Ok(largest) };
                // Sample k stands at place k − 1.
                let around = [place as u32, (place as u32 + 2).min(SAMPLES as u32)].map(step);
                let at = try_minimum(around, 0.0, |h| Ok::<_, StudyError>(-sign * error(h)?))?;
                Ok(larger(largest, sign * error(at)?))
            };
            Ok([-extreme(-1.0)?, extreme(1.0)?])
        };
        let largest = |method: &str| Ok::<_, StudyError>(modulus(extremes(method)?));
        let theta = theta(from, to)?;
        let constant = |theta: f64| largest(&format!("linear({:?},1)", -theta));
        Ok(Found {
            theta,
            extremes: extremes(&format!("minimax({from},{to})"))?,
            // θ and 1 − θ changed by two parts in a hundred.
            neighbour: [constant(0.98 * theta)?, constant(1.0 - 0.98 * (1.0 - theta))?].into_iter().smallest(),
            method_i: largest("method-i")?,
            method_ii: largest("method-ii")?,
            implicit_euler: largest("implicit-euler")?,
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Complex;

    use super::*;
    use crate::measure::amplification::Amplification;

    #[test]
    fn largest_errors_are_those_of_the_closed_forms() {
        let found = Context::silent().get(Minimax { from: 0.0, to: 1.0 }).expect("linear");
        // Both errors grow with h up to h = 1, which is the last sample.
        let exact = (-1.0_f64).exp();
        assert!((found.implicit_euler - (0.5 - exact)).abs() < 1e-14 && (found.method_i - (0.4 - exact)).abs() < 1e-14);
        assert!((found.method_ii - (exact - 1.0 / 3.0)).abs() < 1e-14, "{found:?}");
        assert_eq!(found.best(), found.extremes[1].max(-found.extremes[0]));
        // A change of θ by two parts in a hundred is a small one.
        assert!(found.best() < found.neighbour && found.neighbour < 1.5 * found.best(), "{found:?}");
    }

    #[test]
    fn the_neighbour_of_the_best_constant_is_the_better_of_two() {
        let found = Context::silent().get(Minimax { from: 0.0, to: 1.0 }).expect("linear");
        let error = |theta: f64| {
            let closure = Amplification { alpha: -theta, beta: 1.0 };
            let of = |h: f64| (closure.factor(Complex::new(-h, 0.0)).re - (-h).exp()).abs();
            (1..=10_000).map(|k| of(1e-4 * f64::from(k))).largest()
        };
        let [one, other] = [0.98 * found.theta, 1.0 - 0.98 * (1.0 - found.theta)].map(error);
        // An extreme between two of so many steps is that of the nearest but for their distance squared.
        approx::assert_relative_eq!(found.neighbour, one.min(other), max_relative = 1e-6);
        assert!(one.max(other) > 1.001 * one.min(other), "they tell: {one} and {other}");
    }
}
