//! How fast neighbouring motions part, and when roundings decide where a run goes.

use std::ops::ControlFlow;

use super::{Context, Experiment, StudyError};
use crate::measure::norm::{distance, larger, max_norm};
use crate::method::{self, Method};
use crate::problem::{self, Problem};
use crate::run::run_from;

/// Steps between two looks at the distance.
const STEPS: u64 = 128;

/// The distance of two motions at first, and that beyond which one is brought back to the other, in parts of their size: far above what
/// rounding adds, and far below where they bend.
const NEAR: f64 = 1e-8;
const FAR: f64 = 1e-4;

/// Two runs on a problem of mechanics, side by side.
#[derive(Debug)]
pub struct Sensitivity {
    /// The problem.
    pub problem: &'static str,
    /// The method.
    pub method: &'static str,
    /// The step size.
    pub h: f64,
    /// Steps.
    pub steps: u64,
}

/// How far they part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parting {
    /// The logarithm of the factor by which their distance grows.
    pub growth: f64,
    /// In this time: that of the run, or earlier, when roundings have grown to the size of the motion.
    pub time: f64,
}

impl Parting {
    /// The logarithm of the growth that makes a motion of a rounding: of one part in 2⁵² all.
    pub fn of_roundings() -> f64 {
        -f64::EPSILON.ln()
    }

    /// The time at which roundings have grown to the size of the motion, if that is in the run.
    pub fn lost(&self) -> Option<f64> {
        (self.growth >= Self::of_roundings()).then_some(self.time)
    }

    /// The rate of growth: in chaos the largest Lyapunov exponent of the run.
    pub fn rate(&self) -> f64 {
        self.growth / self.time
    }
}

impl Experiment for Sensitivity {
    const ID: &'static str = "sensitivity";
    type Found = Parting;

    fn measure(&self, context: &Context) -> Result<Parting, StudyError> {
        context.announce(1);
        let (problem, method) = (problem::build_setting(self.problem)?, method::parse(self.method)?);
        let parting = parting(&*problem, &*method, self.h, self.steps)?;
        context.tick();
        Ok(parting)
    }
}

fn parting(problem: &dyn Problem, method: &dyn Method, h: f64, steps: u64) -> Result<Parting, StudyError> {
    let after = |start: &[f64], steps: u64| -> Result<Vec<f64>, StudyError> {
        let run = run_from(problem, start.to_vec(), method, h, h * steps as f64, |_, _| ControlFlow::Continue(()))?;
        Ok(run.end.q)
    };
    let stretch = STEPS.min(steps);
    // A motion may begin at rest, where a factor on the momenta, which keeps those of a constraint on it, changes nothing.
    let mut state = after(&problem.initial(), stretch)?;
    let mut size = max_norm(&state);
    let half = state.len() / 2;
    let mut beside = state.clone();
    beside[half..].iter_mut().for_each(|p| *p *= 1.0 + NEAR);
    let (mut near, mut growth, mut done) = (distance(&state, &beside), 0.0, 0);
    loop {
        let next = stretch.min(steps - done);
        (state, beside, done) = (after(&state, next)?, after(&beside, next)?, done + next);
        let apart = distance(&state, &beside);
        size = larger(size, max_norm(&state));
        let parting = Parting { growth: growth + (apart / near).ln(), time: h * done as f64 };
        if done == steps || parting.lost().is_some() || parting.growth.is_nan() {
            return Ok(parting);
        }
        if apart > FAR * size {
            growth = parting.growth;
            let part = NEAR * size / apart;
            beside.iter_mut().zip(&state).for_each(|(other, own)| *other = own + part * (*other - own));
            near = distance(&state, &beside);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(setting: &str, steps: u64) -> Parting {
        let problem = problem::build_setting(setting).expect("registered");
        parting(&*problem, &*method::parse("midpoint-vi").expect("registered"), 0.05, steps).expect("it runs")
    }

    /// Two orbits whose energies differ part in proportion to time, and at some phases by some ten times as far as at others.
    #[test]
    fn regular_motions_part_in_proportion_to_time() {
        let [short, long] = [2_000, 20_000].map(|steps| found("kepler", steps));
        assert!((long.growth - short.growth).exp() < 100.0, "{short:?}, {long:?}");
        assert_eq!((short.lost(), long.lost(), long.time), (None, None, 1000.0));
    }

    /// Beside a distance of 10⁻¹² that grows on its own by 10⁶; the other one is brought back on the way, from where motions begin to bend.
    #[test]
    fn growth_goes_on_where_motions_are_brought_together() {
        let problem = problem::build_setting("double-pendulum").expect("registered");
        let method = method::parse("midpoint-vi").expect("registered");
        let (h, steps) = (0.05, 14 * STEPS);
        let after = |start: &[f64]| {
            let go = |_: &_, _| ControlFlow::Continue(());
            run_from(&*problem, start.to_vec(), &*method, h, h * STEPS as f64, go).expect("it runs").end.q
        };
        let mut state = after(&problem.initial());
        let mut beside = state.clone();
        beside[state.len() / 2..].iter_mut().for_each(|p| *p *= 1.0 + 1e-12);
        let near = distance(&state, &beside);
        for _ in 0..14 {
            (state, beside) = (after(&state), after(&beside));
        }
        let alone = (distance(&state, &beside) / near).ln();
        let found = parting(&*problem, &*method, h, steps).expect("it runs").growth;
        assert!(alone > 13.0 && (found - alone).abs() < 0.2, "{found} with, {alone} without");
    }

    #[test]
    fn chaos_makes_a_motion_of_a_rounding_at_a_steady_rate() {
        let chaotic = found("double-pendulum", 20_000);
        let lost = chaotic.lost().expect("it is chaotic");
        assert!(lost < 500.0 && chaotic.rate() * lost >= Parting::of_roundings(), "{chaotic:?}");
        // By half of that time a rounding has grown to about the root of it.
        let half = found("double-pendulum", (0.5 * lost / 0.05) as u64);
        assert!((0.25..0.75).contains(&(half.growth / chaotic.growth)) && half.lost().is_none(), "{half:?}");
    }
}
