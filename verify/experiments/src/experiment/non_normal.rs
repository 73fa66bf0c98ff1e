//! Linear systems whose matrix is not normal: stable ones that a method amplifies, and dissipative ones.

use lsvi::OneStep;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::propagator::{ProbeError, propagator};
use super::{Context, Experiment, StudyError};
use crate::measure::norm::larger;
use crate::measure::search::try_root;
use crate::measure::stability::{Uniform, numerical_abscissa, spectral_abscissa, spectral_norm, spectral_radius};
use crate::method::{self, Method};

/// The spectral radius and norm of a propagator of order n ≤ 5 are exact to some n² roundings, times the condition of its
/// matrix, which is below 1e4 for the entries below that the search allows.
pub const ROUNDOFF: f64 = 1e-10;
/// All eigenvalues of a matrix of the search lie left of minus this.
pub const MARGIN: f64 = 0.05;
/// Largest entry.
pub const LARGEST: f64 = 10.0;
/// Ascents for each order.
pub const ASCENTS: usize = 40;
/// Random matrices at the start of each ascent.
pub const RANDOM: usize = 20;
/// Changes tried in each ascent.
pub const CHANGES: usize = 200;
/// How many of the ascents go on, and by how many changes.
pub const HIGHEST: usize = 3;
/// Changes tried in each of these.
pub const MORE_CHANGES: usize = 4000;
/// Number of the sequence of random numbers.
pub const SEED: u64 = 1;

/// A search for the Hurwitz matrix hA of an order that a method amplifies most in a step.
#[derive(Debug)]
pub struct Amplified {
    /// The method.
    pub method: &'static str,
    /// Number of unknowns.
    pub order: usize,
}

/// The matrix that a search ended with.
#[derive(Debug)]
pub struct Found {
    /// Number of unknowns.
    pub order: usize,
    /// hA, with entries of two decimals.
    pub matrix: DMatrix<f64>,
    /// Spectral radius of a live step.
    pub radius: f64,
}

impl Experiment for Amplified {
    const ID: &'static str = "amplified";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        context.announce(1);
        let Self { method, order } = *self;
        let fewer = if order > 3 { Some(context.get(Amplified { method, order: order - 1 })?) } else { None };
        let found = search(&*method::parse(method)?, order, fewer.as_deref())?;
        context.tick();
        Ok(found)
    }
}

/// The step size from which on a method amplifies the matrix of a search, whose own is 1.
#[derive(Debug)]
pub struct AmplifiedFrom(pub Amplified);

impl Experiment for AmplifiedFrom {
    const ID: &'static str = "amplified-from";
    type Found = Option<f64>;

    fn measure(&self, context: &Context) -> Result<Option<f64>, StudyError> {
        let Amplified { method, order } = self.0;
        let found = context.get(Amplified { method, order })?;
        let method = method::parse(method)?;
        try_root([1e-3, 1.0], |h| Ok(spectral_radius(&propagator(&*method, &(h * &found.matrix))?) - 1.0))
    }
}

/// Spectral radii of a step of several methods on the matrices that Method I amplifies most, all orders.
#[derive(Debug)]
pub struct Rivals(pub &'static [&'static str]);

impl Experiment for Rivals {
    const ID: &'static str = "rivals-on-non-normal";
    type Found = Vec<f64>;

    fn measure(&self, context: &Context) -> Result<Vec<f64>, StudyError> {
        let mut radii = Vec::new();
        for order in ORDERS {
            let found = context.get(Amplified { method: "method-i", order })?;
            for name in self.0 {
                radii.push(spectral_radius(&propagator(&*method::parse(name)?, &found.matrix)?));
            }
        }
        Ok(radii)
    }
}

/// Orders of the searches.
pub const ORDERS: [usize; 4] = [2, 3, 4, 5];

/// Random systems whose symmetric part is negative semidefinite, so that |v| never grows.
#[derive(Debug)]
pub struct Dissipative;

/// Those of one order.
#[derive(Debug)]
pub struct OfOrder {
    /// Number of unknowns.
    pub order: usize,
    /// Largest spectral radius of a step of Method I.
    pub radius: f64,
    /// Largest norm of a step of the trapezoidal rule.
    pub rule_norm: f64,
    /// Of the system that a step of Method I lengthens most: the largest eigenvalue of the symmetric part, the spectral radius
    /// and the norm of the step, and the norm of the trapezoidal rule's.
    pub most_lengthened: [f64; 4],
}

/// Matrices tried of each order.
pub const TRIED: usize = 300;

impl Experiment for Dissipative {
    const ID: &'static str = "dissipative";
    type Found = Vec<OfOrder>;

    fn measure(&self, context: &Context) -> Result<Vec<OfOrder>, StudyError> {
        context.announce(1);
        let (method_i, rule) = (method::parse("method-i")?, method::parse("trapezoidal")?);
        let of_order = |order: usize| -> Result<OfOrder, StudyError> {
            let mut found = OfOrder { order, radius: 0.0, rule_norm: 0.0, most_lengthened: [0.0; 4] };
            for a in dissipative(order, TRIED) {
                let (step, by_rule) = (propagator(&*method_i, &a)?, propagator(&*rule, &a)?);
                let [radius, norm, rule_norm] = [spectral_radius(&step), spectral_norm(&step), spectral_norm(&by_rule)];
                found.radius = larger(found.radius, radius);
                found.rule_norm = larger(found.rule_norm, rule_norm);
                if larger(found.most_lengthened[2], norm) != found.most_lengthened[2] {
                    found.most_lengthened = [numerical_abscissa(&a), radius, norm, rule_norm];
                }
            }
            Ok(found)
        };
        let found = [2, 3, 4].into_par_iter().map(of_order).collect();
        context.tick();
        found
    }
}

/// The stable 3 × 3 system that Method I amplifies most: a run of every method, and the spectral radius of a step over its size.
#[derive(Debug)]
pub struct Example(pub &'static [&'static str]);

/// One point of a curve.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    /// Whether it is of a run, |v| by the number of steps, or a spectral radius by the step size.
    pub is_of_run: bool,
    /// The method, or `exact`.
    pub method: &'static str,
    /// Number of steps, or step size.
    pub x: f64,
    /// |v|, or spectral radius.
    pub value: f64,
}

impl Example {
    /// Steps of a run.
    pub const STEPS: usize = 60;
}

impl Experiment for Example {
    const ID: &'static str = "non-normal-example";
    type Found = Vec<Point>;

    fn measure(&self, context: &Context) -> Result<Vec<Point>, StudyError> {
        let found = context.get(Amplified { method: "method-i", order: 3 })?;
        let a = &found.matrix;
        let steps = self.0.iter().map(|name| Ok((*name, propagator(&*method::parse(name)?, a)?)));
        let steps = steps.chain([Ok(("exact", a.exp()))]).collect::<Result<Vec<_>, StudyError>>()?;
        let mut points = Vec::new();
        for (method, step) in steps {
            let mut v = DMatrix::from_element(a.nrows(), 1, 1.0);
            for n in 0..=Self::STEPS {
                points.push(Point { is_of_run: true, method, x: n as f64, value: v.norm() });
                v = &step * v;
            }
        }
        for name in self.0 {
            let method = method::parse(name)?;
            for k in -30..=30 {
                let h = 10_f64.powf(f64::from(k) / 15.0);
                let value = spectral_radius(&propagator(&*method, &(h * a))?);
                points.push(Point { is_of_run: false, method: name, x: h, value });
            }
        }
        Ok(points)
    }
}

/// The largest spectral radius of a live step of `method` that is found among Hurwitz matrices of the given order: the best
/// of many ascents, each from the best of a few random matrices of all sizes, of which the highest few go on for longer, and of one from the
/// matrix found for one unknown fewer beside an unknown that decays by itself.
fn search(method: &dyn Method, order: usize, fewer: Option<&Found>) -> Result<Found, StudyError> {
    let mut random = Uniform::new(SEED + order as u64);
    let mut uniform = move || random.next().unwrap_or_default();
    // The search takes what is larger, and would never take NaN.
    let radius = |matrix: &DMatrix<f64>| {
        let radius = spectral_radius(&propagator(method, matrix)?);
        if radius.is_nan() { Err(StudyError::from("a step has no spectral radius")) } else { Ok(radius) }
    };
    let mut climb = |start: Summit, changes: usize, shrink: f64| -> Result<Summit, StudyError> {
        let (mut here, mut change) = (start, 1.0);
        for _ in 0..changes {
            let step = DMatrix::from_fn(order, order, |_, _| change * uniform());
            let Some(matrix) = stable(&(&here.matrix + step)) else { continue };
            let radius = radius(&matrix)?;
            if radius > here.radius {
                here = Summit { matrix, radius };
                change *= 2.0;
            } else {
                change *= shrink;
            }
        }
        Ok(here)
    };
    let mut start = Uniform::new(SEED + 10 * order as u64);
    let mut uniform = move || start.next().unwrap_or_default();
    let mut summits = Vec::new();
    for _ in 0..ASCENTS {
        let mut start = Summit { matrix: DMatrix::zeros(order, order), radius: 0.0 };
        for _ in 0..RANDOM {
            let size = LARGEST * 10_f64.powf(uniform() - 1.0);
            let Some(matrix) = stable(&DMatrix::from_fn(order, order, |_, _| size * uniform())) else { continue };
            let radius = radius(&matrix)?;
            if radius > start.radius {
                start = Summit { matrix, radius };
            }
        }
        summits.push(climb(start, CHANGES, 0.95)?);
    }
    summits.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    summits.truncate(HIGHEST);
    summits.extend(fewer.map(|found| {
        let mut matrix = found.matrix.clone().resize(order, order, 0.0);
        matrix[(order - 1, order - 1)] = -1.0;
        Summit { matrix, radius: found.radius }
    }));
    let mut best = Found { order, matrix: -DMatrix::identity(order, order), radius: 0.0 };
    for summit in summits {
        let Summit { matrix, radius } = climb(summit, MORE_CHANGES, 0.99)?;
        if radius > best.radius {
            best = Found { order, matrix, radius };
        }
    }
    Ok(best)
}

/// A matrix, and the spectral radius of a step on it.
struct Summit {
    matrix: DMatrix<f64>,
    radius: f64,
}

/// The matrix shifted to have its eigenvalues left of −[`MARGIN`], with entries of two decimals that can be printed; `None`
/// if they are too large.
fn stable(candidate: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let order = candidate.nrows();
    // Rounding the entries moves the eigenvalues a little, and makes −0 of some, which is 0.
    let shift = spectral_abscissa(candidate) + 1.2 * MARGIN;
    let matrix = (candidate - shift * DMatrix::identity(order, order)).map(|x| (100.0 * x).round() / 100.0 + 0.0);
    (matrix.amax() <= LARGEST && spectral_abscissa(&matrix) <= -MARGIN).then_some(matrix)
}

/// Random matrices with a negative semidefinite symmetric part of any rank.
fn dissipative(order: usize, count: usize) -> Vec<DMatrix<f64>> {
    let mut random = Uniform::new(SEED);
    let mut uniform = move || random.next().unwrap_or_default();
    let mut matrix = |k: usize| {
        let (damping, turning) = (4.0 * uniform().abs(), 8.0 * uniform().abs());
        let b = DMatrix::from_fn(1 + k % order, order, |_, _| damping * uniform());
        let c = DMatrix::from_fn(order, order, |_, _| turning * uniform());
        0.5 * (&c - c.transpose()) - b.transpose() * b
    };
    (0..count).map(&mut matrix).collect()
}

/// Damped plane rotations by a method.
#[derive(Debug)]
pub struct Rotations(pub &'static str);

/// A step on v̇ = Av with A = ((−damping, −turning), (turning, −damping)).
#[derive(Debug, Clone, Copy)]
pub struct Rotation {
    /// Minus the real part of the eigenvalues.
    pub damping: f64,
    /// Their imaginary part.
    pub turning: f64,
    /// Step size.
    pub h: f64,
    /// Spectral radius of a live step.
    pub radius: f64,
}

impl Experiment for Rotations {
    const ID: &'static str = "rotations";
    type Found = Vec<Rotation>;

    fn measure(&self, _: &Context) -> Result<Vec<Rotation>, StudyError> {
        let method = method::parse(self.0)?;
        let mut found = Vec::new();
        for (damping, turning) in [(1.0, 1.0), (1.0, 10.0), (0.01, 1.0), (1e-3, 100.0)] {
            let a = DMatrix::from_row_slice(2, 2, &[-damping, -turning, turning, -damping]);
            for h in [0.01, 0.1, 1.0, 10.0, 1e3] {
                let radius = spectral_radius(&propagator(&*method, &(h * &a))?);
                found.push(Rotation { damping, turning, h, radius });
            }
        }
        Ok(found)
    }
}

/// A step of Method I with h = 1 from t = 0 on v̇ = −10(1 − t) v, which decays until t = 1.
#[derive(Debug)]
pub struct Fading;

impl Experiment for Fading {
    const ID: &'static str = "fading";
    /// What the step multiplies v by.
    type Found = f64;

    fn measure(&self, _: &Context) -> Result<f64, StudyError> {
        let fading = lsvi::field!(1, |t, v, dv| dv[0] = v[0] * (10.0 * (t - 1.0)));
        let mut v = [1.0];
        let mut method = lsvi::method_i(fading).map_err(|error| error.to_string())?;
        OneStep::step(&mut method, 0.0, 1.0, &mut v, &mut [0.0]).map_err(|error| error.to_string())?;
        Ok(v[0])
    }
}

/// A step of h = 1 on v̇₁ = −v₁, v̇₂ = 0: ½|v|² is lost wherever v₁ ≠ 0, and the matrix is singular.
#[derive(Debug)]
pub struct SingularlyDamped(pub &'static str);

impl Experiment for SingularlyDamped {
    const ID: &'static str = "singularly-damped";
    /// The spectral radius of the step; where there is no step, [`RunError::in_place_of_a_number`](crate::run::RunError::in_place_of_a_number).
    type Found = f64;

    fn measure(&self, _: &Context) -> Result<f64, StudyError> {
        let a = DMatrix::from_diagonal(&DVector::from_vec(vec![-1.0, 0.0]));
        match propagator(&*method::parse(self.0)?, &a) {
            Ok(step) => Ok(spectral_radius(&step)),
            Err(ProbeError::Run(error)) => Ok(error.in_place_of_a_number()),
            Err(error) => Err(error.into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_system_that_is_lengthened_most_has_the_numbers_of_its_own_steps() {
        let [method_i, rule] = ["method-i", "trapezoidal"].map(|name| method::parse(name).expect("known"));
        for found in Dissipative.measure(&Context::silent()).expect("linear") {
            let of = |a: &DMatrix<f64>| {
                let [step, by_rule] = [&method_i, &rule].map(|method| propagator(&**method, a).expect("linear"));
                [numerical_abscissa(a), spectral_radius(&step), spectral_norm(&step), spectral_norm(&by_rule)]
            };
            let all: Vec<[f64; 4]> = dissipative(found.order, TRIED).iter().map(of).collect();
            let most = all.iter().max_by(|one, other| one[2].total_cmp(&other[2])).expect("some were tried");
            assert_eq!(found.most_lengthened, *most, "order {}", found.order);
        }
    }
}
