//! High order: Galerkin least-squares variational integrators of every family, degree and closure.

use lsvi::closure::Linear;
use lsvi::discrete::Galerkin;
use lsvi::quadrature::{LagrangeBasis, Quadrature};
use lsvi::{
    AutoField, FieldFn, InputError, Jacobian, LeastSquares, OneStep, Scalar, StepError, Variational, VectorField,
};
use nalgebra::{Complex, DMatrix, DVector};
use rayon::prelude::*;

use super::{Context, Study, StudyError};
use crate::evidence::{Cell, Check, Evidence, Requirement, Table};
use crate::measure::norm::{distance, larger};
use crate::measure::order::Verdict;
use crate::method::Method;
use crate::method::high_order::{Family, LsGalerkin};
use crate::order::{Source, measure};
use crate::problem;
use crate::theory::breakdown;

pub(super) const STUDY: Study = Study {
    id: "high-order",
    title: "More sophisticated integrators",
    question: "What do paths of higher degree and better quadrature make of the closures?",
    source: "[S24] Section 6, future work; [HW96] IV.3, IV.5",
    run,
};

/// Highest degree in the tables.
const DEGREES: usize = 4;

/// Highest order that is measured on van der Pol's oscillator: above, errors sink to roundoff before they settle.
const MEASURABLE: u32 = 6;

/// (α, β) of Methods I and II.
const CLOSURES: [(f64, f64); 2] = [(0.0, 1.0), (-1.0, 1.0)];

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let methods = methods();
    context.announce(methods.len());
    let rows: Vec<(Linearised, Option<Nonlinear>)> = methods
        .into_par_iter()
        .map(|method| {
            let row = (Linearised::of(method)?, Nonlinear::of(method)?);
            context.tick();
            Ok(row)
        })
        .collect::<Result<_, StudyError>>()?;
    let mut checks: Vec<Check> = rows.iter().flat_map(|(linear, _)| linear.checks()).collect();
    checks.extend(rows.iter().filter_map(|(linear, nonlinear)| nonlinear.as_ref().map(|n| n.check(linear.method))));
    for family in Family::ALL {
        for degree in 1..=DEGREES {
            if family.rule(degree).is_ok() {
                checks.push(collocates(family, degree)?);
            }
        }
    }
    Ok(Evidence {
        checks,
        tables: vec![table(&rows)],
        notes: vec![
            "With as many nodes as degrees the residual vanishes at every node, whatever the closure: Gauss, Radau IIA and \
             Lobatto IIIA collocation. One node more makes true least squares. Method I under Lobatto's rule is then \
             L-stable of order 2s; under Gauss' and Radau's rules R(∞) = (−1)ˢ/(s + 1). On `v̇ = λv` with normal Jacobian \
             those two gain an order for odd s with Method I and two orders for even s with Method II; nonlinear \
             systems have order 2s in all cases."
                .into(),
            "Stability is sampled on the imaginary axis and in the left half-plane by live steps, which decides it to \
             roundoff at the samples and no further."
                .into(),
        ],
        ..Evidence::default()
    })
}

/// Method I throughout, and Method II where it differs.
fn methods() -> Vec<LsGalerkin> {
    let mut methods = Vec::new();
    for family in Family::ALL {
        for degree in 1..=DEGREES {
            for nodes in [degree, degree + 1] {
                for (alpha, beta) in CLOSURES {
                    let repeated = nodes == degree && alpha != 0.0;
                    if family.rule(nodes).is_ok() && !repeated {
                        methods.push(LsGalerkin { degree, family, nodes, alpha, beta });
                    }
                }
            }
        }
    }
    methods
}

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

/// What a step does on v̇ = λ v.
struct Linearised {
    method: LsGalerkin,
    /// The measured order p on v̇ = λv, and the nearest whole number.
    slope: f64,
    order: u32,
    /// C in R(z) − eᶻ = C z^{p+1} + …, and a bound on its error.
    constant: f64,
    constant_bound: f64,
    /// R at z = −[`FAR`].
    infinity: f64,
    /// The largest |R(z)| over samples with Re z ≤ 0.
    largest: f64,
}

/// Where R(∞) is read off: the squared condition |z|² leaves more digits than 1/|z| takes.
const FAR: f64 = 1e5;

/// Growth that roundoff of a live step can feign: a few hundred roundings of terms of the size of s⁴.
const ROUNDOFF: f64 = 1e-11;

/// Errors below this are too near to roundoff to give an order.
const RESOLVED: f64 = 2e-13;

impl Linearised {
    fn of(method: LsGalerkin) -> Result<Self, StepError> {
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
        // The mean over ±h leaves even powers of h, of which one is extrapolated away.
        let constant = |h: f64| {
            let power = |z: f64| z.powi(order as i32 + 1);
            Ok::<f64, StepError>(0.5 * (error(h)? / power(h) + error(-h)? / power(-h)))
        };
        let (coarse, fine) = (constant(h)?, constant(0.5 * h)?);
        let extrapolated = (4.0 * fine - coarse) / 3.0;
        let rounding = ROUNDOFF * 1e-3 / (0.5 * h).powi(order as i32 + 1);
        let mut largest = 0.0_f64;
        for k in 0..=36 {
            let y = 10_f64.powf(f64::from(k) / 6.0 - 2.0);
            for ratio in [0.0, 0.1, 1.0, 10.0] {
                largest = larger(largest, factor(method, Complex::new(-ratio * y, y))?.norm());
            }
        }
        Ok(Self {
            method,
            order,
            slope,
            constant: extrapolated,
            constant_bound: (extrapolated - fine).abs() + rounding,
            infinity: factor(method, Complex::new(-FAR, 0.0))?.re,
            largest,
        })
    }

    fn is_a_stable(&self) -> bool {
        self.largest <= 1.0 + ROUNDOFF
    }

    fn is_l_stable(&self) -> bool {
        self.is_a_stable() && self.infinity.abs() <= self.far_tolerance()
    }

    /// FAR · |R(−FAR) − R(∞)| is largest for the diagonal Padé approximation of degree k: 2k(k + 1), and k ≤ s + 1.
    fn far_tolerance(&self) -> f64 {
        let s = self.method.degree as f64;
        2.0 * (s + 1.0) * (s + 2.0) / FAR
    }

    /// The order on normal linear systems; collocation has a Padé approximation.
    fn expected_order(&self) -> u32 {
        let (s, LsGalerkin { family, .. }) = (self.method.degree as u32, self.method);
        let lobatto = family == Family::Lobatto;
        let conserved = self.method.alpha != 0.0;
        match self.method.order() {
            order if self.method.is_collocation() || lobatto => order,
            order if conserved && s.is_multiple_of(2) => order + 2,
            order if !conserved && !s.is_multiple_of(2) => order + 1,
            order => order,
        }
    }

    fn expected_infinity(&self) -> f64 {
        let s = self.method.degree as i32;
        let alternating = |k: i32| if k % 2 == 0 { 1.0 } else { -1.0 };
        match (self.method.family, self.method.is_collocation(), self.method.alpha == 0.0) {
            (Family::Radau, true, _) | (Family::Lobatto, false, true) => 0.0,
            (Family::Gauss, true, _) => alternating(s),
            (Family::Lobatto, true, _) => alternating(s - 1),
            (_, false, true) => alternating(s) / f64::from(s + 1),
            (_, false, false) => -1.0,
        }
    }

    /// The error constant of the (j, k) Padé approximation, −(−1)ᵏ j! k!/((j + k)! (j + k + 1)!), of collocation.
    fn pade_constant(&self) -> Option<f64> {
        let s = self.method.degree as u32;
        let (j, k) = match self.method.family {
            _ if !self.method.is_collocation() => return None,
            Family::Gauss => (s, s),
            Family::Radau => (s - 1, s),
            Family::Lobatto => (s - 1, s - 1),
        };
        let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        Some(-sign * factorial(j) * factorial(k) / (factorial(j + k) * factorial(j + k + 1)))
    }

    fn checks(&self) -> Vec<Check> {
        let name = self.method.name();
        let check = |what: &str, statement: String, measured: f64, required| {
            Check::new(format!("{what}/{name}"), statement, measured, required, "one step of the integrator on v̇ = λv")
        };
        let (order, infinity) = (self.expected_order(), self.expected_infinity());
        let mut checks = vec![
            check(
                "linear-order",
                format!("{name} has order {order} on v̇ = λv"),
                self.slope,
                Requirement::Near(f64::from(order), 0.5),
            ),
            check(
                "infinity",
                format!("R(∞) of {name} is {infinity:.4}"),
                self.infinity,
                Requirement::Near(infinity, self.far_tolerance()),
            ),
            check(
                "a-stability",
                format!("|R| ≤ 1 at all samples of the left half-plane for {name}"),
                self.largest,
                Requirement::AtMost(1.0 + ROUNDOFF),
            ),
        ];
        if let Some(pade) = self.pade_constant() {
            checks.push(check(
                "error-constant",
                format!("the error constant of {name} is that of its Padé approximation"),
                self.constant,
                Requirement::Near(pade, self.constant_bound),
            ));
        }
        checks
    }
}

/// The order on van der Pol's oscillator.
struct Nonlinear {
    slope: Option<f64>,
    verdict: Verdict,
    reason: String,
}

impl Nonlinear {
    fn of(method: LsGalerkin) -> Result<Option<Self>, StudyError> {
        let problem = problem::build("van-der-pol", &[])?;
        if method.order() > MEASURABLE || breakdown(&*problem, &method).is_some() {
            return Ok(None);
        }
        let truth = Source::default_for(&*problem, &method).truth(&*problem, &method);
        let fit = measure(&*problem, &method, truth)?;
        Ok(Some(Self { slope: fit.line.map(|line| line.slope), verdict: fit.verdict, reason: fit.reason }))
    }

    fn check(&self, method: LsGalerkin) -> Check {
        Check {
            id: format!("order/{}", method.name()),
            statement: format!("{} has order {} on van-der-pol", method.name(), method.order()),
            outcome: self.verdict.into(),
            measured: self.slope,
            required: Some(Requirement::Near(f64::from(method.order()), 0.1)),
            reason: self.reason.clone(),
        }
    }
}

fn table(rows: &[(Linearised, Option<Nonlinear>)]) -> Table {
    let verdict = |yes: bool| Cell::Text(if yes { "yes" } else { "no" }.into());
    let rows = rows.iter().map(|(linear, nonlinear)| {
        vec![
            Cell::Text(linear.method.name()),
            Cell::Integer(i64::from(linear.method.order())),
            nonlinear.as_ref().and_then(|n| n.slope).map_or(Cell::Empty, Cell::Number),
            Cell::Integer(i64::from(linear.order)),
            Cell::Number(linear.constant),
            Cell::Number(linear.infinity),
            Cell::Number(linear.largest - 1.0),
            verdict(linear.is_a_stable()),
            verdict(linear.is_l_stable()),
        ]
    });
    Table {
        id: "high-order".into(),
        caption:
            "Galerkin least-squares integrators of degree s = 1 … 4: order by theory and on van der Pol's oscillator, \
                  and on v̇ = λv the order p, the constant of R(z) − eᶻ = C z^(p+1), R(−10⁵), and the excess of the \
                  largest |R| sampled in the left half-plane over 1."
                .into(),
        columns: [
            "method",
            "order",
            "measured",
            "linear_order",
            "error_constant",
            "r_infinity",
            "excess",
            "a_stable",
            "l_stable",
        ]
        .map(Into::into)
        .to_vec(),
        rows: rows.collect(),
        shown: true,
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

/// One step of a method with r = s against the Runge–Kutta method of its nodes.
fn collocates(family: Family, degree: usize) -> Result<Check, StudyError> {
    let method = LsGalerkin { degree, family, nodes: degree, alpha: 0.0, beta: 1.0 };
    let (h, start) = (0.2, [1.0, 0.5]);
    let (mut v, mut p) = (start, [0.0; 2]);
    integrator(method, AutoField::new(VanDerPol))?.step(0.0, h, &mut v, &mut p)?;
    let difference = distance(&v, &collocation_step(&family.rule(degree)?, h, &start)?);
    // The least-squares equations have the square of the condition of collocation, s⁴, and a few roundings per node.
    let tolerance = 32.0 * (degree as f64).powi(4) * f64::EPSILON;
    Ok(Check::at_most(
        format!("collocation/{}", method.name()),
        format!("{} is the collocation method of its nodes", method.name()),
        difference,
        tolerance,
        "a step on van der Pol's oscillator against the Runge–Kutta method with a_ij = ∫₀^{c_i} l_j",
    ))
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
