//! The mean energy error over a long run.

use super::{Context, Experiment, StudyError};
use crate::method;
use crate::problem;
use crate::run::run;

/// A run of a mechanical problem from its initial state.
#[derive(Debug, Clone)]
pub struct EnergyCourse {
    /// The problem.
    pub problem: &'static str,
    /// The method.
    pub method: &'static str,
    /// The step size.
    pub h: f64,
    /// The number of steps.
    pub steps: u32,
}

/// Windows of equal length.
const WINDOWS: u32 = 20;

impl Experiment for EnergyCourse {
    const ID: &'static str = "energy-course";
    /// (middle, mean of E − E₀) of each window, with the weight exp(−1/(s(1 − s))), 0 < s < 1, under which the oscillations of a
    /// quasi-periodic motion average out.
    type Found = Vec<(f64, f64)>;

    fn measure(&self, context: &Context) -> Result<Self::Found, StudyError> {
        context.announce(1);
        let Self { problem, method, h, steps } = *self;
        let problem = problem::build_setting(problem)?;
        let invariants = problem.invariants();
        let energy = invariants.iter().find(|i| i.name == "energy").ok_or("the problem has no energy")?;
        let start = energy.value(&problem.initial());
        let length = f64::from(steps) * h / f64::from(WINDOWS);
        let mut sums = vec![(0.0, 0.0); WINDOWS as usize];
        run(&*problem, &*method::parse(method)?, h, f64::from(steps) * h, |state| {
            let place = (state.t + 0.5 * h) / length;
            if let Some((sum, weights)) = sums.get_mut(place as usize) {
                let weight = (-1.0 / (place.fract() * (1.0 - place.fract()))).exp();
                *sum += weight * (energy.value(&state.q) - start);
                *weights += weight;
            }
        })?;
        context.tick();
        let middles = (0..WINDOWS).map(|k| (f64::from(k) + 0.5) * length);
        Ok(middles.zip(sums).map(|(t, (sum, weights))| (t, sum / weights)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_stands_at_the_middle_of_its_window() {
        let course = EnergyCourse { problem: "harmonic-oscillator", method: "stormer-verlet", h: 0.1, steps: 400 };
        let found = Context::new(&|_| {}, &|| {}, 1).get(course).expect("it runs");
        assert_eq!(found.len(), 20);
        for (k, (t, _)) in found.iter().enumerate() {
            assert!((t - (2.0 * k as f64 + 1.0)).abs() < 1e-12, "{t}");
        }
    }
}
