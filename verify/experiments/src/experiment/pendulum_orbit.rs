//! The pendulum of \[KY21\] over many steps.

use std::f64::consts::TAU;

use super::{Context, Experiment, StudyError};
use crate::measure::norm::{Extremes, larger};
use crate::method;
use crate::problem;
use crate::run::run;

/// A long run on an orbit of the pendulum.
#[derive(Debug)]
pub struct PendulumOrbit {
    /// The method.
    pub method: &'static str,
    /// The angle in which it begins.
    pub q0: f64,
    /// The momentum.
    pub p0: f64,
    /// The step size.
    pub h: f64,
    /// Steps.
    pub steps: u64,
}

impl PendulumOrbit {
    /// One state in so many is kept.
    pub const KEPT: usize = 997;
    /// Parts of a run in which its largest energy error is looked for.
    pub const PARTS: usize = 100;
    /// The largest energy error late in a run over that early in it, if it is bounded: it has the same maximum, which n phases of the motion meet to
    /// (2π/n)², a hundredth for the 63 or more of every run that is judged by it.
    pub const BOUNDED: f64 = 1.01;
}

/// What is kept of it.
#[derive(Debug)]
pub struct Orbit {
    /// Times, angles in one turn, and momenta.
    pub states: Vec<(f64, f64, f64)>,
    /// Middles of the parts of the run, and the largest energy errors in them.
    pub energy_errors: Vec<(f64, f64)>,
}

impl Orbit {
    /// The largest energy error in the last tenth of the run over that in the first.
    pub fn late_over_early(&self) -> f64 {
        let tenth = self.energy_errors.len() / 10;
        let most = |part: &[(f64, f64)]| part.iter().map(|(_, error)| *error).largest();
        most(&self.energy_errors[self.energy_errors.len() - tenth..]) / most(&self.energy_errors[..tenth])
    }
}

impl Experiment for PendulumOrbit {
    const ID: &'static str = "pendulum-orbit";
    type Found = Orbit;

    fn measure(&self, context: &Context) -> Result<Orbit, StudyError> {
        context.announce(1);
        let problem = problem::build_setting(&format!("pendulum q0={} p0={}", self.q0, self.p0))?;
        let invariants = problem.invariants();
        let energy = invariants.first().ok_or("the pendulum has no energy")?;
        let start = energy.value(&problem.initial());
        let (parts, horizon) = (Self::PARTS, self.steps as f64 * self.h);
        let (mut states, mut largest, mut step) = (Vec::new(), vec![0.0_f64; parts], 0_usize);
        run(&*problem, &*method::parse(self.method)?, self.h, horizon, |state| {
            let part = ((state.t / horizon * parts as f64) as usize).min(parts - 1);
            largest[part] = larger(largest[part], (energy.value(&state.q) - start).abs());
            if step.is_multiple_of(Self::KEPT) {
                // A rotation is drawn in one turn.
                let angle = state.q[0] - TAU * (state.q[0] / TAU).round();
                states.push((state.t, angle, state.q[1]));
            }
            step += 1;
        })?;
        let middle = |i: usize| (i as f64 + 0.5) * horizon / parts as f64;
        let energy_errors = largest.into_iter().enumerate().map(|(i, error)| (middle(i), error)).collect();
        context.tick();
        Ok(Orbit { states, energy_errors })
    }
}
