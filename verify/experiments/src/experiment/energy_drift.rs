//! What the energy and the angular momentum do over long runs.

use super::{Context, Experiment, StudyError};
use crate::measure::norm::{Extremes, larger, max_norm};
use crate::method::{self, Method};
use crate::problem::{self, Problem};
use crate::run::run;
use crate::theory::is_symplectic;

/// Windows of a run. Energy errors are averaged over each with the weight exp(−1/(s(1 − s))), 0 < s < 1: such averages
/// of a quasi-periodic function converge faster than any power of the window's length.
const WINDOWS: usize = 10;

/// A drift is one whose slope is at least this many of its standard errors: Student's t with 8 degrees of freedom is beyond
/// it with probability 10⁻⁵.
const SIGNIFICANT: f64 = 10.0;

/// A long run on a problem of mechanics.
#[derive(Debug)]
pub struct EnergyDrift {
    /// The problem.
    pub problem: &'static str,
    /// The method.
    pub method: String,
    /// The step size.
    pub h: f64,
    /// Steps; of a method that dissipates a tenth, as its error leaves the straight line before long.
    pub steps: u64,
}

/// The energy errors of a run.
#[derive(Debug)]
pub struct Drift {
    /// The problem.
    pub problem: &'static str,
    /// The method.
    pub method: String,
    /// What it conserves.
    pub kind: Kind,
    /// Steps taken.
    pub steps: u64,
    /// Its parts.
    pub windows: Vec<Window>,
    /// What the fitted slope adds up to over the run.
    pub drift: f64,
    /// Its standard error.
    pub stderr: f64,
    /// What rounding may do to the energy and to the angular momentum.
    pub rounding: f64,
    /// Change of the angular momentum, where it is conserved.
    pub momentum: Option<f64>,
}

/// What a method conserves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The symplectic form.
    Symplectic,
    /// Not that, but it is reversible.
    Symmetric,
    /// Neither.
    Dissipative,
}

/// The energy errors in a part of a run.
#[derive(Debug, Clone, Copy)]
pub struct Window {
    /// Its middle.
    pub t: f64,
    /// Their weighted mean.
    pub mean: f64,
    /// The largest of them.
    pub largest: f64,
}

impl Kind {
    fn of(problem: &dyn Problem, method: &dyn Method) -> Result<Self, StudyError> {
        let is_symplectic = is_symplectic(problem, method).ok_or("the problem has no Lagrangian of mechanics")?;
        Ok(match (is_symplectic, method.traits().is_reversible) {
            (true, _) => Self::Symplectic,
            (false, true) => Self::Symmetric,
            (false, false) => Self::Dissipative,
        })
    }
}

impl Drift {
    /// The least drift that is one.
    pub fn resolved(&self) -> f64 {
        SIGNIFICANT * self.stderr + self.rounding
    }

    /// The largest energy error.
    pub fn largest(&self) -> f64 {
        self.windows.iter().map(|window| window.largest).largest()
    }

    /// What the energy moves by from the first window to the last, where it goes one way through all of them, as by chance ten means in any order do
    /// with probability 6·10⁻⁷: a fast decay is no straight line.
    pub fn one_way(&self) -> Option<f64> {
        let steps = || self.windows.array_windows().map(|[a, b]| b.mean - a.mean);
        let is_one_way = self.windows.len() >= WINDOWS && (steps().all(|x| x >= 0.0) || steps().all(|x| x <= 0.0));
        let moved = steps().sum::<f64>().abs();
        (is_one_way && moved > self.rounding).then_some(moved)
    }
}

impl Experiment for EnergyDrift {
    const ID: &'static str = "energy-drift";
    type Found = Drift;

    fn measure(&self, context: &Context) -> Result<Drift, StudyError> {
        context.announce(1);
        let (problem, method) = (problem::build_setting(self.problem)?, method::parse(&self.method)?);
        let drift = Drift::of((self.problem, &*problem), &*method, self.h, self.steps)?;
        context.tick();
        Ok(drift)
    }
}

impl Drift {
    /// That of a method on a problem with its name, `steps` of `h`; of a method that dissipates a tenth of them.
    ///
    /// # Errors
    /// If the problem has no energy, or the run fails.
    pub fn of(
        (name, problem): (&'static str, &dyn Problem),
        method: &dyn Method,
        h: f64,
        steps: u64,
    ) -> Result<Self, StudyError> {
        let kind = Kind::of(problem, method)?;
        let steps = steps / if kind == Kind::Dissipative { 10 } else { 1 };
        let horizon = h * steps as f64;
        let invariants = problem.invariants();
        let energy = invariants.iter().find(|i| i.name == "energy").ok_or("the problem has no energy")?;
        let angular = invariants.iter().find(|i| i.name == "angular momentum");
        let start = problem.initial();
        let length = steps as f64 / WINDOWS as f64;
        let (mut sums, mut change) = (vec![(0.0, 0.0_f64, 0.0); WINDOWS], 0.0_f64);
        let (mut q, mut p, mut step) = (0.0_f64, 0.0_f64, 0.0_f64);
        run(problem, method, h, horizon, |state| {
            let error = energy.value(&state.q) - energy.value(&start);
            let place = (step + 0.5) / length;
            if let Some((sum, largest, weights)) = sums.get_mut(place as usize) {
                let weight = (-1.0 / (place.fract() * (1.0 - place.fract()))).exp();
                *sum += weight * error;
                *weights += weight;
                *largest = larger(*largest, error.abs());
            }
            let (place, momentum) = state.q.split_at(start.len() / 2);
            (q, p, step) = (larger(q, max_norm(place)), larger(p, max_norm(momentum)), step + 1.0);
            change = angular.map_or(0.0, |l| larger(change, (l.value(&state.q) - l.value(&start)).abs()));
        })?;
        let window = |(i, (sum, largest, weights)): (usize, &(f64, f64, f64))| Window {
            t: (i as f64 + 0.5) * length * h,
            mean: sum / weights,
            largest: *largest,
        };
        let windows: Vec<_> = sums.iter().enumerate().map(window).collect();
        let (slope, stderr) = line(&windows);
        // Each step rounds q, and so p by Λ ε |q|/h, at random: four standard deviations of the sum. The coefficients of the
        // method are rounded too, which changes p by up to Λ ε |p| in the same way in every step.
        let random = 4.0 * (steps as f64).sqrt() * q / h;
        let rounding = f64::EPSILON * (1.0 + method.momentum_roundoff(1.0)) * p * (random + steps as f64 * p);
        Ok(Self {
            problem: name,
            method: method.name(),
            kind,
            steps,
            windows,
            drift: (slope * horizon).abs(),
            stderr: stderr * horizon,
            rounding,
            momentum: angular.map(|_| change),
        })
    }
}

/// Slope and its standard error of the least-squares line through the means of the windows.
fn line(windows: &[Window]) -> (f64, f64) {
    let n = windows.len() as f64;
    let t = windows.iter().map(|w| w.t).sum::<f64>() / n;
    let mean = windows.iter().map(|w| w.mean).sum::<f64>() / n;
    let stt: f64 = windows.iter().map(|w| (w.t - t).powi(2)).sum();
    let slope = windows.iter().map(|w| (w.t - t) * (w.mean - mean)).sum::<f64>() / stt;
    let residual: f64 = windows.iter().map(|w| (w.mean - mean - slope * (w.t - t)).powi(2)).sum();
    (slope, (residual / (n - 2.0) / stt).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2t with residuals 1, −1, −1, 1 at t = 0, …, 3, which have neither a mean nor a slope: their squares add up to 4, those of the distances
    /// from the mean time to 5, and 4 − 2 degrees are left.
    #[test]
    fn the_standard_error_of_a_slope_leaves_out_the_two_degrees_of_its_line() {
        let windows = [1.0, 1.0, 3.0, 7.0].into_iter().zip(0..);
        let windows: Vec<_> = windows.map(|(mean, t)| Window { t: f64::from(t), mean, largest: 0.0 }).collect();
        let (slope, stderr) = line(&windows);
        approx::assert_relative_eq!(slope, 2.0, max_relative = 1e-14);
        approx::assert_relative_eq!(stderr, 0.4_f64.sqrt(), max_relative = 1e-14);
    }
}
