//! Energy, enstrophy and error of flows on the periodic square, in both metrics.

use lsvi::Mass;
use rayon::prelude::*;

use super::{named, rms, setting};
use crate::experiment::{Context, Experiment, StudyError};
use crate::problem::Problem;
use crate::run::run;

/// Methods with the metric of the flow that they step.
pub(crate) const METHODS: [(&str, &str); 7] = [
    ("method-i", "velocity"),
    ("method-i", "vorticity"),
    ("trapezoidal", "velocity"),
    ("implicit-midpoint", "velocity"),
    ("tr-bdf2", "velocity"),
    ("implicit-euler", "velocity"),
    ("rk4", "velocity"),
];
/// Step sizes, halved; RK4 of half the last is the reference.
pub(crate) const STEPS: [f64; 3] = [0.05, 0.025, 0.0125];
/// The end of the runs.
pub(crate) const END: f64 = 1.0;

/// Runs of all methods on a flow.
#[derive(Debug)]
pub(crate) struct PeriodicErrors {
    /// The flow.
    pub(crate) flow: &'static str,
    /// Grid points along a side.
    pub(crate) points: usize,
}

/// What is measured of a run, against the reference.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    pub(crate) method: &'static str,
    pub(crate) metric: &'static str,
    pub(crate) h: f64,
    /// Of the vorticity at the end, root mean square, relative.
    pub(crate) error: f64,
    /// Relative error of ½ mean |u|².
    pub(crate) energy: f64,
    /// Relative error of ½ mean ω².
    pub(crate) enstrophy: f64,
}

/// All runs, and the vorticity of the reference.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) rows: Vec<Row>,
    pub(crate) reference: Vec<f64>,
    /// An estimate of the error of the reference: what RK4 with twice its step differs by, a fifteenth.
    pub(crate) reference_error: f64,
}

/// ½ vᵀMv in the velocity metric, ½ vᵀv.
fn energy_and_enstrophy(mass: &[f64], v: &[f64]) -> [f64; 2] {
    [mass.iter().zip(v).map(|(m, v)| 0.5 * m * v * v).sum(), v.iter().map(|v| 0.5 * v * v).sum()]
}

/// M of a flow in the velocity metric.
fn mass(problem: &dyn Problem) -> Result<Vec<f64>, StudyError> {
    match problem.field().mass() {
        Mass::Diagonal(mass) => Ok(mass),
        other => Err(format!("a diagonal mass in Fourier space, not {other:?}").into()),
    }
}

impl Experiment for PeriodicErrors {
    const ID: &'static str = "periodic-errors";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        let cases: Vec<_> = METHODS.iter().flat_map(|case| STEPS.map(|h| (*case, h))).collect();
        context.announce(cases.len() + 2);
        let of = |metric: &str| setting(&format!("{} cells={} metric={metric}", self.flow, self.points));
        let velocity = of("velocity")?;
        let weights = mass(&*velocity)?;
        let end = |problem: &dyn Problem, method: &str, h: f64| -> Result<Vec<f64>, StudyError> {
            let end = run(problem, &*named(method)?, h, END, |_| {})?.end.q;
            context.tick();
            Ok(end)
        };
        let [.., finest] = STEPS;
        let state = end(&*velocity, "rk4", 0.5 * finest)?;
        let truth = energy_and_enstrophy(&weights, &state);
        let reference = velocity.observe(END, &state);
        let size = rms(&reference, &vec![0.0; reference.len()]);
        let rows: Vec<Row> = cases
            .par_iter()
            .map(|((method, metric), h)| {
                let problem = of(metric)?;
                let state = end(&*problem, method, *h)?;
                let [energy, enstrophy] = energy_and_enstrophy(&weights, &state);
                let error = rms(&problem.observe(END, &state), &reference) / size;
                let (energy, enstrophy) = (energy / truth[0] - 1.0, enstrophy / truth[1] - 1.0);
                Ok(Row { method, metric, h: *h, error, energy, enstrophy })
            })
            .collect::<Result<_, StudyError>>()?;
        context.tick();
        let coarser = rows.iter().find(|row| row.method == "rk4" && row.h == finest);
        let reference_error = coarser.map_or(f64::NAN, |row| row.error / 15.0);
        Ok(Found { rows, reference, reference_error })
    }
}

/// The shear layer without viscosity, by all methods with one step size.
#[derive(Debug)]
pub(crate) struct WithoutViscosity {
    /// Grid points along a side.
    pub(crate) points: usize,
}

impl WithoutViscosity {
    /// The step size.
    pub(crate) const H: f64 = 0.1;
}

/// Relative changes in a run.
#[derive(Debug, Clone)]
pub(crate) struct Change {
    pub(crate) method: &'static str,
    pub(crate) metric: &'static str,
    pub(crate) energy: f64,
    pub(crate) enstrophy: f64,
}

impl Experiment for WithoutViscosity {
    const ID: &'static str = "without-viscosity";
    type Found = Vec<Change>;

    fn measure(&self, context: &Context) -> Result<Vec<Change>, StudyError> {
        context.announce(METHODS.len());
        let of = |metric: &str| setting(&format!("shear-layer cells={} re=1e12 metric={metric}", self.points));
        let weights = mass(&*of("velocity")?)?;
        METHODS
            .par_iter()
            .map(|(method, metric)| {
                let problem = of(metric)?;
                let before = energy_and_enstrophy(&weights, &problem.initial());
                let end = run(&*problem, &*named(method)?, Self::H, END, |_| {})?.end.q;
                let after = energy_and_enstrophy(&weights, &end);
                context.tick();
                let (energy, enstrophy) = (after[0] / before[0] - 1.0, after[1] / before[1] - 1.0);
                Ok(Change { method, metric, energy, enstrophy })
            })
            .collect()
    }
}
