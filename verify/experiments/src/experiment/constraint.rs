//! What runs under a constraint keep, and what the scheme (23) of \[KY21\] does.

use std::ops::ControlFlow;

use super::{Context, Experiment, StudyError};
use crate::measure::norm::larger;
use crate::method;
use crate::names::NameError;
use crate::problem;
use crate::run::{run, run_while};
use crate::theory::{integrators_for, is_symplectic};

/// A run on the circle or the sphere |q| = 1.
#[derive(Debug)]
pub struct Held {
    /// The problem.
    pub problem: &'static str,
    /// The method.
    pub method: String,
}

/// What a run leaves of |q|² = 1, of its derivative and of the angular momentum.
#[derive(Debug)]
pub struct Kept {
    /// The problem.
    pub problem: &'static str,
    /// The method.
    pub method: String,
    /// Largest ||q|² − 1|.
    pub position: f64,
    /// Largest |q · p|.
    pub hidden: f64,
    /// Largest change of the angular momentum.
    pub momentum: f64,
    /// Largest change of the energy.
    pub energy: f64,
    /// Whether the angular momentum is kept, as by every symplectic method.
    pub is_symplectic: bool,
    /// Rounding of the momentum over the run.
    pub rounding: f64,
}

impl Held {
    /// The step of all runs.
    pub const H: f64 = 0.1;
    /// Their end.
    pub const HORIZON: f64 = 20.0;
    /// |q|² − 1 of a q that is known to a few ε: what Newton's iteration leaves and the rounding of q itself.
    pub const PLACE: f64 = 64.0 * f64::EPSILON;
    /// The problems.
    pub const PROBLEMS: [&str; 2] = ["circle", "spherical-pendulum"];

    /// Every integrator that knows constraints, on both problems.
    ///
    /// # Errors
    /// [`NameError`] for an unknown problem.
    pub fn all() -> Result<Vec<Self>, NameError> {
        let mut all = Vec::new();
        for problem in Self::PROBLEMS {
            all.extend(integrators_for(problem)?.into_iter().map(|method| Self { problem, method }));
        }
        Ok(all)
    }
}

impl Experiment for Held {
    const ID: &'static str = "held";
    type Found = Kept;

    fn measure(&self, context: &Context) -> Result<Kept, StudyError> {
        context.announce(1);
        let (problem, method) = (problem::build_setting(self.problem)?, method::parse(&self.method)?);
        let start = problem.initial();
        let invariants = problem.invariants();
        let change = |which: &str, state: &[f64]| {
            let invariant = invariants.iter().find(|i| i.name == which);
            invariant.map_or(f64::NAN, |i| (i.value(state) - i.value(&start)).abs())
        };
        let is_symplectic = is_symplectic(&*problem, &*method).ok_or("the problem has no Lagrangian of mechanics")?;
        let steps = Self::HORIZON / Self::H;
        let mut kept = Kept {
            problem: self.problem,
            method: self.method.clone(),
            position: 0.0,
            hidden: 0.0,
            momentum: 0.0,
            energy: 0.0,
            is_symplectic,
            rounding: 4.0 * steps.sqrt() * (1.0 + method.momentum_roundoff(1.0)) * f64::EPSILON / Self::H,
        };
        run(&*problem, &*method, Self::H, Self::HORIZON, |state| {
            let (q, p) = state.q.split_at(start.len() / 2);
            kept.position = larger(kept.position, (q.iter().map(|x| x * x).sum::<f64>() - 1.0).abs());
            kept.hidden = larger(kept.hidden, q.iter().zip(p).map(|(q, p)| q * p).sum::<f64>().abs());
            kept.momentum = larger(kept.momentum, change("angular momentum", &state.q));
            kept.energy = larger(kept.energy, change("energy", &state.q));
        })?;
        context.tick();
        Ok(kept)
    }
}

/// Uniform motion on the circle by (23), its square roots supplied, up to 40 steps or until it is far from the circle, where the step equations
/// need not be solvable.
#[derive(Debug)]
pub struct Radius {
    /// The step size.
    pub tau: f64,
}

/// Its radial errors.
#[derive(Debug)]
pub struct Radii {
    /// |q| − 1 after each step, the initial 0 first.
    pub errors: Vec<f64>,
    /// The first over −τ⁴/32.
    pub first: f64,
    /// The ratio of the last two below [`Radius::VISIBLE`], from the third on: the first step starts the growth, and the second and third
    /// ratios from it are 4 and 6¼.
    pub ratio: f64,
    /// The step at which |q| is off by more than [`Radius::VISIBLE`].
    pub visible: Option<usize>,
    /// The step at which it is off by more than [`Radius::FAR`], the last one.
    pub far: Option<usize>,
}

impl Radius {
    /// A radial error that is seen.
    pub const VISIBLE: f64 = 1e-2;
    /// One beyond which the run ends.
    pub const FAR: f64 = 0.3;

    /// The factor of a radial error per step in the limit of small steps, −(3 + 2√2).
    pub fn growth() -> f64 {
        -(3.0 + 8.0_f64.sqrt())
    }
}

impl Experiment for Radius {
    const ID: &'static str = "radius";
    type Found = Radii;

    fn measure(&self, _: &Context) -> Result<Radii, StudyError> {
        let (circle, method) = (problem::build_setting("circle")?, method::parse("kong-yang-circle")?);
        let tau = self.tau;
        let mut errors: Vec<f64> = Vec::new();
        run_while(&*circle, &*method, tau, 40.0 * tau, |state| {
            let error = state.q[0].hypot(state.q[1]) - 1.0;
            errors.push(error);
            if error.abs() > Self::FAR { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })?;
        let small = errors.windows(2).skip(3).rev().find(|pair| pair[1].abs() < Self::VISIBLE);
        Ok(Radii {
            first: errors.get(1).map_or(f64::NAN, |error| error / -(tau.powi(4) / 32.0)),
            ratio: small.map_or(f64::NAN, |pair| pair[1] / pair[0]),
            visible: errors.iter().position(|error| error.abs() > Self::VISIBLE),
            far: errors.iter().position(|error| error.abs() > Self::FAR),
            errors,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From −τ⁴/32 the first ratios are 4 and 6¼ and the next are near 3 + 2√2, so that the fourth error is 4.5 τ⁴ or so.
    #[test]
    fn the_growth_of_a_radius_is_not_told_by_its_first_ratios() {
        let found = |tau: f64| Radius { tau }.measure(&Context::silent()).expect("it runs");
        let [long, short] = [0.3, 0.05].map(found);
        assert!(long.visible == Some(4) && long.ratio.is_nan(), "{long:?}");
        approx::assert_relative_eq!(short.ratio, Radius::growth(), max_relative = 0.05);
    }
}
