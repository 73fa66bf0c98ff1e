//! The defect of symplecticity of one step.

use nalgebra::DMatrix;

use super::step_map::restricted;
use super::{Context, Experiment, StudyError};
use crate::measure::norm::{Extremes, larger};
use crate::measure::order::{Expectation, OrderFit, Sample, fit};
use crate::method::{self, Method};
use crate::names::NameError;
use crate::problem::{self, Problem};
use crate::run::run;
use crate::theory::{integrators_for, is_symplectic};

/// A problem of mechanics, and the coarsest step on it.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    /// Its name.
    pub problem: &'static str,
    /// The same with parameters: away from symmetries, where a defect may vanish.
    pub setting: &'static str,
    coarsest: f64,
}

/// The problems on which defects are measured.
pub const SETTINGS: [Setting; 7] = [
    on("asymmetric-pendulum", "asymmetric-pendulum", 0.2),
    on("henon-heiles", "henon-heiles y0=-0.2 px0=0.3", 0.8),
    on("kepler", "kepler", 0.2),
    on("charged-particle", "charged-particle y0=-0.3 vx0=0.2", 0.4),
    on("double-pendulum", "double-pendulum p10=0.3 p20=-0.2", 0.4),
    on("circle", "circle", 0.4),
    on("spherical-pendulum", "spherical-pendulum dtheta0=0.3", 0.4),
];

const fn on(problem: &'static str, setting: &'static str, coarsest: f64) -> Setting {
    Setting { problem, setting, coarsest }
}

impl Setting {
    /// That of a problem.
    pub fn of(problem: &str) -> Option<&'static Self> {
        SETTINGS.iter().find(|setting| setting.problem == problem)
    }
}

/// The methods are symmetric, so that their defects have odd powers of h only and the next orders are two away: a tenth of
/// that distance.
const BAND: f64 = 0.2;

/// Number of step sizes, each 2^{−1/4} of the one before.
pub const STEPS: usize = 21;

/// Number of states on the motion, and the time between them. The defect is their root mean square: at a single state a
/// leading coefficient may all but vanish.
const STATES: usize = 8;
const APART: f64 = 0.8;

/// The defects of a method on one of [`SETTINGS`], ‖DΦᵀΩDΦ − Ω‖ of one step at several step sizes.
#[derive(Debug)]
pub struct Defects {
    /// The problem.
    pub problem: &'static str,
    /// The method.
    pub method: String,
}

/// Those of one method on one problem.
#[derive(Debug)]
pub struct Found {
    /// The problem.
    pub problem: &'static str,
    /// The method.
    pub method: String,
    /// Coarse to fine.
    pub points: Vec<Point>,
    /// The power of h with which they fall, where the method is not expected to be symplectic.
    pub fit: Option<OrderFit>,
}

/// The defect at one step size.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    /// The step size.
    pub h: f64,
    /// The defect.
    pub defect: f64,
    /// A bound on its rounding.
    pub rounding: f64,
}

impl Found {
    /// The largest defect in units of its rounding.
    pub fn excess(&self) -> f64 {
        self.points.iter().map(|point| point.defect / point.rounding).largest()
    }

    /// That at a quarter of the coarsest step, which stands for all.
    pub fn shown(&self) -> Point {
        self.points[8]
    }

    /// The defect at the step size `h`; NaN where none was measured.
    pub fn at(&self, h: f64) -> f64 {
        self.points.iter().find(|point| point.h == h).map_or(f64::NAN, |point| point.defect)
    }
}

impl Defects {
    /// Every integrator on all problems that it steps.
    ///
    /// # Errors
    /// [`NameError`] for an unknown problem.
    pub fn all() -> Result<Vec<Self>, NameError> {
        let mut all = Vec::new();
        for Setting { problem, .. } in SETTINGS {
            all.extend(integrators_for(problem)?.into_iter().map(|method| Self { problem, method }));
        }
        Ok(all)
    }
}

impl Experiment for Defects {
    const ID: &'static str = "symplectic-defect";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        context.announce(1);
        let Setting { problem, setting, coarsest } =
            *Setting::of(self.problem).ok_or("there is no setting for the problem")?;
        let (system, method) = (problem::build_setting(setting)?, method::parse(&self.method)?);
        let is_symplectic = is_symplectic(&*system, &*method).ok_or("the problem has no Lagrangian of mechanics")?;
        let states = states(&*system)?;
        let at = |k: usize| defect(&*system, &*method, coarsest * (-0.25 * k as f64).exp2(), &states);
        let points = (0..STEPS).map(at).collect::<Result<Vec<_>, _>>()?;
        let fit = (!is_symplectic).then(|| {
            let samples: Vec<_> = points.iter().map(|p| Sample::new(p.h, p.defect, p.rounding)).collect();
            fit(&samples, &Expectation::new(f64::from(method.order() + 1), BAND))
        });
        context.tick();
        Ok(Found { problem, method: self.method.clone(), points, fit })
    }
}

/// [`STATES`] states on the motion of `problem`.
fn states(problem: &dyn Problem) -> Result<Vec<Vec<f64>>, StudyError> {
    let method = method::parse("galerkin-gauss(3)")?;
    let mut states = Vec::new();
    run(problem, &*method, APART / 8.0, APART * STATES as f64, |state| states.push(state.q.clone()))?;
    Ok(states.into_iter().skip(4).step_by(8).collect())
}

/// ‖DΦᵀΩDΦ − Ω‖ of one step, the root mean square over `states`, and a bound on its rounding.
///
/// Under constraints both forms are restricted to the tangent space of their cotangent bundle.
fn defect(problem: &dyn Problem, method: &dyn Method, h: f64, states: &[Vec<f64>]) -> Result<Point, StudyError> {
    let n = problem.initial().len() / 2;
    let mut omega = DMatrix::zeros(2 * n, 2 * n);
    for i in 0..n {
        omega[(i, n + i)] = 1.0;
        omega[(n + i, i)] = -1.0;
    }
    let (mut defects, mut size) = (0.0, 0.0_f64);
    for state in states {
        let [tangent, projector] = restricted(method, problem, h, state)?;
        let difference = tangent.transpose() * &omega * &tangent - projector.transpose() * &omega * &projector;
        defects += difference.norm_squared() / states.len() as f64;
        size = larger(size, tangent.norm());
    }
    // The derivatives of the path, of order 1 and known to a few ε, enter ∂p₁/∂q₀ with coefficients Λ/h, Λ² the sum of
    // their squares; the product then multiplies by DΦ.
    let slopes = method.momentum_roundoff(1.0);
    let rounding = 4.0 * f64::EPSILON * (1.0 + slopes) / h * size;
    Ok(Point { h, defect: defects.sqrt(), rounding })
}
