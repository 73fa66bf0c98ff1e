//! Energy, enstrophy and error of flows on the periodic square, in both metrics.

use lsvi::Mass;
use rayon::prelude::*;

use super::{Cost, named, rms, setting, timed};
use crate::experiment::{Context, Experiment, StudyError};
use crate::problem::Problem;
use crate::run::run;

/// Methods with the metric of the flow that they step.
pub const METHODS: [(&str, &str); 7] = [
    ("method-i", "velocity"),
    ("method-i", "vorticity"),
    ("trapezoidal", "velocity"),
    ("implicit-midpoint", "velocity"),
    ("tr-bdf2", "velocity"),
    ("implicit-euler", "velocity"),
    ("rk4", "velocity"),
];
/// The end of the shorter runs.
pub const END: f64 = 1.0;
/// The Reynolds number, 1/ν.
pub const RE: f64 = 200.0;

/// Runs of all methods on a flow.
#[derive(Debug, Clone, Copy)]
pub struct PeriodicErrors {
    /// The flow with its parameters.
    pub flow: &'static str,
    /// Grid points along a side.
    pub points: usize,
    /// The end of the runs.
    pub end: f64,
    /// The longest steps, which are halved twice; RK4 of half the last is the reference.
    pub longest: f64,
}

impl PeriodicErrors {
    /// Step sizes.
    pub fn steps(&self) -> [f64; 3] {
        [1.0, 0.5, 0.25].map(|part| part * self.longest)
    }
}

/// What is measured of a run, against the reference; not a number where a step failed, as steps of RK4 that are too long do.
#[derive(Debug, Clone)]
pub struct Row {
    /// Name of the method.
    pub method: &'static str,
    /// Name of the metric.
    pub metric: &'static str,
    /// Step size.
    pub h: f64,
    /// Of the vorticity at the end, root mean square, relative.
    pub error: f64,
    /// Relative error of ½ mean |u|².
    pub energy: f64,
    /// Relative error of ½ mean ω².
    pub enstrophy: f64,
    /// What the run leaves of Ė = −2νZ and of Ż = −2νP, in units of E and of Z at the start.
    pub balance: [f64; 2],
    /// Evaluations of f and products with its Jacobian or the transpose: the transforms of all of them are alike. Conjugate gradients on
    /// normal equations take two in an iteration, and their right-hand side one; GMRES takes one.
    pub evaluations: u64,
    /// What the run cost.
    pub cost: Cost,
}

/// All runs, and the vorticity of the reference.
#[derive(Debug)]
pub struct Found {
    /// A row for each run.
    pub rows: Vec<Row>,
    /// State at the end to compare with.
    pub reference: Vec<f64>,
    /// An estimate of the error of the reference: what RK4 with twice its step differs by, a fifteenth.
    pub reference_error: f64,
    /// As in [`Row`].
    pub reference_balance: [f64; 2],
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
pub struct GridError {
    /// Setting of the runs.
    pub of: PeriodicErrors,
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
        let method = named(method)?;
        let (run, seconds) = timed(|| run(problem, &*method, h, end, |state| seen.push(moments(mass, &state.q))));
        let run = run?;
        let (cost, end) = (Cost::of(&run, seconds), run.end.q);
        let [Some(first), Some(last)] = [seen.first(), seen.last()] else { return Err("no steps".into()) };
        let integral = |of: usize| simpson(h, &seen.iter().map(|m| m[of]).collect::<Vec<_>>());
        let balance = [0, 1].map(|of| (last[of] - first[of] + 2.0 / RE * integral(of + 1)) / first[of]);
        Ok(Self { end, cost, moments: *last, balance })
    }
}

/// Simpson's rule for values at equal distances h, an odd number of them.
fn simpson(h: f64, values: &[f64]) -> f64 {
    let weight = |n: usize| match n {
        n if n == 0 || n == values.len() - 1 => h / 3.0,
        n if n % 2 == 1 => 4.0 * h / 3.0,
        _ => 2.0 * h / 3.0,
    };
    values.iter().enumerate().map(|(n, value)| weight(n) * value).sum()
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
pub struct WithoutViscosity {
    /// Grid points along a side.
    pub points: usize,
}

impl WithoutViscosity {
    /// The step size.
    pub const H: f64 = 0.1;
}

/// Relative changes in a run.
#[derive(Debug, Clone)]
pub struct Change {
    /// Name of the method.
    pub method: &'static str,
    /// Name of the metric.
    pub metric: &'static str,
    /// Relative change of the energy.
    pub energy: f64,
    /// Relative change of the enstrophy.
    pub enstrophy: f64,
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

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: PeriodicErrors = PeriodicErrors { flow: "turbulence-2d", points: 12, end: 0.4, longest: 0.2 };

    fn small(metric: &str) -> Box<dyn Problem> {
        setting(&format!("turbulence-2d cells=12 re={RE} metric={metric}")).expect("known")
    }

    fn end(problem: &dyn Problem, method: &str, h: f64, end: f64) -> Vec<f64> {
        run(problem, &*named(method).expect("known"), h, end, |_| {}).expect("it runs").end.q
    }

    /// The relative change of the enstrophy, by Parseval from the vorticity on the grid.
    fn grown(to: &[f64], from: &[f64]) -> f64 {
        to.iter().map(|w| w * w).sum::<f64>() / from.iter().map(|w| w * w).sum::<f64>() - 1.0
    }

    #[test]
    fn moments_are_energy_enstrophy_and_palinstrophy() {
        assert_eq!(moments(&[2.0, 4.0], &[1.0, 3.0]), [19.0, 5.0, 1.375]);
    }

    #[test]
    fn normal_equations_take_two_products_an_iteration_and_one_for_their_right_hand_side() {
        let cost = Cost { solves: 3, inner: 5, residuals: 7, seconds: 0.0 };
        assert_eq!(["method-i", "tr-bdf2"].map(|method| evaluations(method, &cost)), [7 + 3 + 2 * 5, 7 + 5]);
    }

    #[test]
    fn the_integral_is_exact_for_cubics() {
        let values: Vec<f64> = (0..=6).map(|n| (0.5 * f64::from(n)).powi(3)).collect();
        approx::assert_relative_eq!(simpson(0.5, &values), 3.0_f64.powi(4) / 4.0, max_relative = 1e-14);
    }

    /// Of fourth order, as RK4 and Simpson's rule are: h⁴ = 1.6e-7.
    #[test]
    fn small_steps_of_rk4_leave_nothing_of_the_balances() {
        let problem = small("velocity");
        let mass = mass(&*problem).expect("diagonal");
        let course = Course::new(&*problem, "rk4", (0.02, 0.4), &mass).expect("it runs");
        assert!(course.balance.iter().all(|left| left.abs() < 1e-7), "{:?}", course.balance);
        // Viscosity takes much more.
        let before = moments(&mass, &problem.initial());
        assert!([0, 1].iter().all(|of| course.moments[*of] < (1.0 - 1e-3) * before[*of]), "{:?}", course.moments);
    }

    #[test]
    fn errors_are_against_the_reference_and_its_own_is_that_of_half_the_step() {
        let found = SMALL.measure(&Context::quick()).expect("it runs");
        let problem = small("velocity");
        let weights = mass(&*problem).expect("diagonal");
        let truth = end(&*problem, "rk4", 0.025, SMALL.end);
        assert_eq!(found.reference, problem.observe(SMALL.end, &truth));
        // The balances of the reference are those of its own run: E − E₀ + 2ν∫Z, and Z − Z₀ + 2ν∫P, by Simpson's rule.
        let mut seen = Vec::new();
        run(&*problem, &*named("rk4").expect("known"), 0.025, SMALL.end, |state| {
            seen.push(moments(&weights, &state.q))
        })
        .expect("it runs");
        for of in [0, 1] {
            let inner: f64 = (1..16).map(|n| if n % 2 == 1 { 4.0 } else { 2.0 } * seen[n][of + 1]).sum();
            let integral = 0.025 / 3.0 * (seen[0][of + 1] + inner + seen[16][of + 1]);
            let left = (seen[16][of] - seen[0][of] + 2.0 * integral / RE) / seen[0][of];
            approx::assert_abs_diff_eq!(found.reference_balance[of], left, epsilon = 1e-14);
            assert!(left.abs() > 1e-12, "{left}");
        }
        for row in &found.rows {
            let problem = small(row.metric);
            let end = end(&*problem, row.method, row.h, SMALL.end);
            let [energy, enstrophy] =
                [0, 1].map(|of| moments(&weights, &end)[of] / moments(&weights, &truth)[of] - 1.0);
            assert_eq!((row.energy, row.enstrophy), (energy, enstrophy), "{row:?}");
            let end = problem.observe(SMALL.end, &end);
            approx::assert_abs_diff_eq!(enstrophy, grown(&end, &found.reference), epsilon = 1e-12);
            let none = vec![0.0; end.len()];
            assert_eq!(row.error, rms(&end, &found.reference) / rms(&found.reference, &none), "{row:?}");
        }
        // The next term of the error is of relative size h.
        let finer = problem.observe(SMALL.end, &super::tests::end(&*problem, "rk4", 0.025 / 8.0, SMALL.end));
        let own = rms(&found.reference, &finer) / rms(&finer, &vec![0.0; finer.len()]);
        approx::assert_relative_eq!(found.reference_error, own, max_relative = 0.1);
    }

    #[test]
    fn what_the_grid_leaves_is_seen_at_the_points_that_a_finer_one_shares() {
        let context = Context::quick();
        let found = GridError { of: SMALL }.measure(&context).expect("it runs");
        let problem = setting(&format!("turbulence-2d cells=24 re={RE}")).expect("known");
        let fine = problem.observe(SMALL.end, &end(&*problem, "rk4", 0.05, SMALL.end));
        let coarse = &context.get(SMALL).expect("it runs").reference;
        let (mut apart, mut size) = (0.0, 0.0);
        for (k, coarse) in coarse.iter().enumerate() {
            let fine = fine[2 * (k / 12) * 24 + 2 * (k % 12)];
            apart += (coarse - fine).powi(2);
            size += fine.powi(2);
        }
        approx::assert_relative_eq!(found, (apart / size).sqrt(), max_relative = 1e-12);
    }

    #[test]
    fn without_viscosity_changes_of_energy_and_of_enstrophy_are_told_apart() {
        let found = WithoutViscosity { points: 16 }.measure(&Context::quick()).expect("it runs");
        assert_eq!(found.len(), METHODS.len());
        for change in &found {
            let problem = setting(&format!("shear-layer cells=16 re=1e12 metric={}", change.metric)).expect("known");
            let [start, end] = [problem.initial(), end(&*problem, change.method, WithoutViscosity::H, END)];
            let enstrophy = grown(&problem.observe(END, &end), &problem.observe(0.0, &start));
            approx::assert_abs_diff_eq!(change.enstrophy, enstrophy, epsilon = 1e-12);
        }
        let euler = found.iter().find(|change| change.method == "implicit-euler").expect("a row");
        assert!(euler.enstrophy < euler.energy && euler.energy < 0.0, "{euler:?}");
    }
}
