//! Energy, enstrophy and error of flows on the periodic square, in both metrics.

use lsvi::Mass;
use rayon::prelude::*;

use super::{Cost, named, rms, setting};
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
/// The end of the shorter runs.
pub(crate) const END: f64 = 1.0;
/// The Reynolds number, 1/ν.
pub(crate) const RE: f64 = 200.0;

/// Runs of all methods on a flow.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PeriodicErrors {
    /// The flow with its parameters.
    pub(crate) flow: &'static str,
    /// Grid points along a side.
    pub(crate) points: usize,
    /// The end of the runs.
    pub(crate) end: f64,
    /// The longest steps, which are halved twice; RK4 of half the last is the reference.
    pub(crate) longest: f64,
}

impl PeriodicErrors {
    /// Step sizes.
    pub(crate) fn steps(&self) -> [f64; 3] {
        [1.0, 0.5, 0.25].map(|part| part * self.longest)
    }
}

/// What is measured of a run, against the reference; not a number where a step failed, as steps of RK4 that are too long do.
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
    /// What the run leaves of Ė = −2νZ and of Ż = −2νP, in units of E and of Z at the start.
    pub(crate) balance: [f64; 2],
    /// Evaluations of f and products with its Jacobian or the transpose: the transforms of all of them are alike. Conjugate gradients on
    /// normal equations take two in an iteration, and their right-hand side one; GMRES takes one.
    pub(crate) evaluations: u64,
    pub(crate) cost: Cost,
}

/// All runs, and the vorticity of the reference.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) rows: Vec<Row>,
    pub(crate) reference: Vec<f64>,
    /// An estimate of the error of the reference: what RK4 with twice its step differs by, a fifteenth.
    pub(crate) reference_error: f64,
    /// As in [`Row`].
    pub(crate) reference_balance: [f64; 2],
}

/// Energy E = ½ vᵀMv in the velocity metric, enstrophy Z = ½ vᵀv, palinstrophy P = ½ vᵀM⁻¹v.
fn moments(mass: &[f64], v: &[f64]) -> [f64; 3] {
    [-1, 0, 1].map(|power| mass.iter().zip(v).map(|(m, v)| 0.5 * m.powi(-power) * v * v).sum())
}

/// As in [`Row`].
fn evaluations(method: &str, cost: &Cost) -> u64 {
    let Cost { solves, inner, residuals, .. } = *cost;
    if method == "method-i" { residuals + solves + 2 * inner } else { residuals + inner }
}

/// What the grid leaves of the vorticity: RK4 on twice as many points, root mean square, relative.
#[derive(Debug)]
pub(crate) struct GridError {
    pub(crate) of: PeriodicErrors,
}

impl Experiment for GridError {
    const ID: &'static str = "periodic-grid-error";
    type Found = f64;

    fn measure(&self, context: &Context) -> Result<f64, StudyError> {
        context.announce(1);
        let PeriodicErrors { flow, points, end, .. } = self.of;
        let [.., finest] = self.of.steps();
        let coarse = &context.get(self.of)?.reference;
        let problem = setting(&format!("{flow} cells={} re={RE}", 2 * points))?;
        let fine = problem.observe(end, &run(&*problem, &*named("rk4")?, finest, end, |_| {})?.end.q);
        let shared: Vec<f64> =
            fine.chunks(2 * points).step_by(2).flat_map(|row| row.iter().step_by(2).copied()).collect();
        context.tick();
        Ok(rms(coarse, &shared) / rms(&shared, &vec![0.0; shared.len()]))
    }
}

/// A run with its moments.
struct Course {
    end: Vec<f64>,
    cost: Cost,
    moments: [f64; 3],
    balance: [f64; 2],
}

impl Course {
    /// `mass` is that of the velocity metric, and the number of steps even.
    fn new(problem: &dyn Problem, method: &str, (h, end): (f64, f64), mass: &[f64]) -> Result<Self, StudyError> {
        let mut seen = Vec::new();
        let run = run(problem, &*named(method)?, h, end, |state| seen.push(moments(mass, &state.q)))?;
        let (cost, end) = (Cost::of(&run), run.end.q);
        let [Some(first), Some(last)] = [seen.first(), seen.last()] else { return Err("no steps".into()) };
        // Simpson's rule.
        let intervals = seen.len() - 1;
        let weight = |n: usize| match n {
            n if n == 0 || n == intervals => h / 3.0,
            n if n % 2 == 1 => 4.0 * h / 3.0,
            _ => 2.0 * h / 3.0,
        };
        let integral = |of: usize| seen.iter().enumerate().map(|(n, m)| weight(n) * m[of]).sum::<f64>();
        let balance = [0, 1].map(|of| (last[of] - first[of] + 2.0 / RE * integral(of + 1)) / first[of]);
        Ok(Self { end, cost, moments: *last, balance })
    }
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
        let cases: Vec<_> = METHODS.iter().flat_map(|case| self.steps().map(|h| (*case, h))).collect();
        context.announce(cases.len() + 2);
        let of = |metric: &str| setting(&format!("{} cells={} re={RE} metric={metric}", self.flow, self.points));
        let velocity = of("velocity")?;
        let weights = mass(&*velocity)?;
        let course = |problem: &dyn Problem, method: &str, h: f64| {
            let course = Course::new(problem, method, (h, self.end), &weights)?;
            context.tick();
            Ok::<_, StudyError>(course)
        };
        let [.., finest] = self.steps();
        let truth = course(&*velocity, "rk4", 0.5 * finest)?;
        let reference = velocity.observe(self.end, &truth.end);
        let size = rms(&reference, &vec![0.0; reference.len()]);
        let rows: Vec<Row> = cases
            .par_iter()
            .map(|((method, metric), h)| {
                let problem = of(metric)?;
                let row = |error, [energy, enstrophy]: [f64; 2], balance, cost| {
                    let evaluations = evaluations(method, &cost);
                    Ok(Row { method, metric, h: *h, error, energy, enstrophy, balance, evaluations, cost })
                };
                let Ok(Course { end, cost, moments, balance }) = course(&*problem, method, *h) else {
                    return row(f64::NAN, [f64::NAN; 2], [f64::NAN; 2], Cost::default());
                };
                let error = rms(&problem.observe(self.end, &end), &reference) / size;
                row(error, [0, 1].map(|of| moments[of] / truth.moments[of] - 1.0), balance, cost)
            })
            .collect::<Result<_, StudyError>>()?;
        context.tick();
        let coarser = rows.iter().find(|row| row.method == "rk4" && row.h == finest);
        let reference_error = coarser.map_or(f64::NAN, |row| row.error / 15.0);
        Ok(Found { rows, reference, reference_error, reference_balance: truth.balance })
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
                let before = moments(&weights, &problem.initial());
                let end = run(&*problem, &*named(method)?, Self::H, END, |_| {})?.end.q;
                let after = moments(&weights, &end);
                context.tick();
                let (energy, enstrophy) = (after[0] / before[0] - 1.0, after[1] / before[1] - 1.0);
                Ok(Change { method, metric, energy, enstrophy })
            })
            .collect()
    }
}
