//! Galerkin least-squares integrators: what a step does on v̇ = λv, their orders, and the collocation methods among them.

use lsvi::closure::Linear;
use lsvi::discrete::Galerkin;
use lsvi::quadrature::{LagrangeBasis, Quadrature};
use lsvi::{
    AutoField, FieldFn, InputError, Jacobian, LeastSquares, OneStep, Scalar, StepError, Variational, VectorField,
};
use nalgebra::{Complex, DMatrix, DVector};

use super::{Context, Experiment, StudyError};
use crate::measure::extrapolation::{Bounded, even_limit};
use crate::measure::norm::{distance, larger};
use crate::measure::order::OrderFit;
use crate::method::Method;
use crate::method::high_order::LsGalerkin;
use crate::order::{Source, measure};
use crate::problem;
use crate::theory::breakdown;

/// v̇ = λ v for complex λ as a real system.
struct Rotation(Complex<f64>);

impl FieldFn for Rotation {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        let Complex { re, im } = self.0;
        dv[0] = v[0] * re - v[1] * im;
        dv[1] = v[0] * im + v[1] * re;
    }
}

fn integrator<F: VectorField>(
    method: LsGalerkin,
    field: F,
) -> Result<Variational<Galerkin<LeastSquares<F>>, Linear>, InputError> {
    let rule = method.family.rule(method.nodes)?;
    let discrete = Galerkin::new(LeastSquares::new(field)?, method.degree, &rule)?;
    Ok(Variational::new(discrete, Linear::new(method.alpha, method.beta)?))
}

/// R(z), by one step of the integrator.
fn factor(method: LsGalerkin, z: Complex<f64>) -> Result<Complex<f64>, StepError> {
    let (mut v, mut p) = ([1.0, 0.0], [0.0; 2]);
    integrator(method, AutoField::new(Rotation(z)))?.step(0.0, 1.0, &mut v, &mut p)?;
    Ok(Complex::new(v[0], v[1]))
}

/// What a step of a method does on v̇ = λ v.
#[derive(Debug)]
pub struct OnLinear(pub LsGalerkin);

/// What is found of it.
#[derive(Debug)]
pub struct Linearised {
    /// The method.
    pub method: LsGalerkin,
    /// The measured order p on v̇ = λv.
    pub slope: f64,
    /// The nearest whole number.
    pub order: u32,
    /// C in R(z) − eᶻ = C z^{p+1} + ….
    pub constant: Bounded,
    /// R at z = −[`FAR`].
    pub infinity: f64,
    /// The largest |R(z)| over samples with Re z ≤ 0.
    pub largest: f64,
}

/// Where R(∞) is read off: the squared condition |z|² leaves more digits than 1/|z| takes.
pub const FAR: f64 = 1e5;

/// Growth that roundoff of a live step can feign: a few hundred roundings of terms of the size of s⁴.
pub const ROUNDOFF: f64 = 1e-11;

/// The longest step of those from which the error constant is extrapolated, how many there are, each four fifths of the one before, and the roundings of
/// eᶻ that a step of s = 4 commits. At the longest the error of order 10 is far above them.
const LONGEST: f64 = 3.0;
const LADDER: i32 = 17;
const ROUNDINGS: f64 = 64.0;

/// Errors below this are too near to roundoff to give an order.
const RESOLVED: f64 = 2e-13;

impl Experiment for OnLinear {
    const ID: &'static str = "on-linear";
    type Found = Linearised;

    fn measure(&self, context: &Context) -> Result<Linearised, StudyError> {
        context.announce(1);
        let found = linearised(self.0);
        context.tick();
        Ok(found?)
    }
}

fn linearised(method: LsGalerkin) -> Result<Linearised, StepError> {
    let error = |z: f64| Ok::<f64, StepError>(factor(method, Complex::new(z, 0.0))?.re - z.exp());
    // The geometric mean over ±h, whose relative error is even in h.
    let size = |h: f64| Ok::<f64, StepError>((error(h)? * error(-h)?).abs().sqrt());
    // The finest step of the sequence 1, ½, … at which the error and that of its half are resolved.
    let mut h = 1.0;
    while size(0.25 * h)? > RESOLVED && h > 1e-3 {
        h *= 0.5;
    }
    let slope = (size(h)? / size(0.5 * h)?).log2() - 1.0;
    let order = slope.round().max(0.0) as u32;
    // The mean over ±h leaves even powers of h.
    let constant = |h: f64| {
        let power = |z: f64| z.powi(order as i32 + 1);
        let value = 0.5 * (error(h)? / power(h) + error(-h)? / power(-h));
        Ok::<_, StepError>((h, Bounded { value, bound: ROUNDINGS * f64::EPSILON * h.exp() / power(h) }))
    };
    let steps = (0..LADDER).map(|k| constant(LONGEST * 0.8_f64.powi(k))).collect::<Result<Vec<_>, _>>()?;
    let mut largest = 0.0_f64;
    for k in 0..=36 {
        let y = 10_f64.powf(f64::from(k) / 6.0 - 2.0);
        for ratio in [0.0, 0.1, 1.0, 10.0] {
            largest = larger(largest, factor(method, Complex::new(-ratio * y, y))?.norm());
        }
    }
    Ok(Linearised {
        method,
        order,
        slope,
        constant: even_limit(&steps),
        infinity: factor(method, Complex::new(-FAR, 0.0))?.re,
        largest,
    })
}

/// The order on van der Pol's oscillator.
#[derive(Debug)]
pub struct OnVanDerPol(pub LsGalerkin);

/// Highest order that is measured there: above, errors sink to roundoff before they settle.
const MEASURABLE: u32 = 6;

impl Experiment for OnVanDerPol {
    const ID: &'static str = "on-van-der-pol";
    /// Nothing where the order is too high to be measured, or the method breaks down.
    type Found = Option<OrderFit>;

    fn measure(&self, _: &Context) -> Result<Option<OrderFit>, StudyError> {
        let (problem, method) = (problem::build("van-der-pol", &[])?, self.0);
        if method.order() > MEASURABLE || breakdown(&*problem, &method, problem.horizon()).is_some() {
            return Ok(None);
        }
        let truth = Source::default_for(&*problem, &method).truth(&*problem, &method);
        Ok(Some(measure(&*problem, &method, truth)?))
    }
}

/// One step on van der Pol's oscillator of a method with as many nodes as degrees against the Runge–Kutta method of its nodes,
/// a_ij = ∫₀^{c_i} l_j.
#[derive(Debug)]
pub struct Collocates(pub LsGalerkin);

impl Experiment for Collocates {
    const ID: &'static str = "collocates";
    /// The distance of the two.
    type Found = f64;

    fn measure(&self, _: &Context) -> Result<f64, StudyError> {
        let (h, start) = (0.2, [1.0, 0.5]);
        let (mut v, mut p) = (start, [0.0; 2]);
        integrator(self.0, AutoField::new(VanDerPol))?.step(0.0, h, &mut v, &mut p)?;
        Ok(distance(&v, &collocation_step(&self.0.family.rule(self.0.nodes)?, h, &start)?))
    }
}

struct VanDerPol;

impl FieldFn for VanDerPol {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[1];
        dv[1] = (-v[0] * v[0] + 1.0) * v[1] - v[0];
    }
}

/// A step of the collocation Runge–Kutta method with the nodes of `rule`: Newton's iteration on all stages at once.
fn collocation_step(rule: &Quadrature, h: f64, start: &[f64]) -> Result<Vec<f64>, StudyError> {
    let field = AutoField::new(VanDerPol);
    let (s, n) = (rule.nodes().len(), start.len());
    let basis = LagrangeBasis::new(rule.nodes())?;
    let inner = Quadrature::gauss(s)?;
    let mut a = DMatrix::<f64>::zeros(s, s);
    for (i, c) in rule.nodes().iter().enumerate() {
        for (x, w) in inner.nodes().iter().zip(inner.weights()) {
            for (j, l) in basis.values(c * x).into_iter().enumerate() {
                a[(i, j)] += c * w * l;
            }
        }
    }
    let mut slopes = DVector::<f64>::zeros(s * n);
    // Quadratic convergence from the slopes' own size to roundoff takes five iterations at this step size.
    for _ in 0..8 {
        let mut residual = slopes.clone();
        let mut derivative = DMatrix::<f64>::identity(s * n, s * n);
        for i in 0..s {
            let stage: Vec<f64> =
                (0..n).map(|k| start[k] + h * (0..s).map(|j| a[(i, j)] * slopes[j * n + k]).sum::<f64>()).collect();
            let mut f = vec![0.0; n];
            field.rhs(0.0, &stage, &mut f);
            let mut jacobian = Jacobian::zeros(n);
            field.add_jacobian(0.0, &stage, 1.0, &mut jacobian);
            for k in 0..n {
                residual[i * n + k] -= f[k];
                for j in 0..s {
                    for l in 0..n {
                        derivative[(i * n + k, j * n + l)] -= h * a[(i, j)] * jacobian.get(k, l);
                    }
                }
            }
        }
        slopes -= derivative.lu().solve(&residual).ok_or("the collocation equations are singular")?;
    }
    let slope = |k: usize| rule.weights().iter().enumerate().map(|(i, b)| b * slopes[i * n + k]).sum::<f64>();
    Ok((0..n).map(|k| start[k] + h * slope(k)).collect())
}
