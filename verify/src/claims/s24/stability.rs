//! Stability on linear problems: the conventional map, Methods I and II.

use lsvi::closure::Linear;
use lsvi::discrete::Trapezoidal;
use lsvi::{Jacobian, OneStep, VectorField, least_squares, position_momentum};
use nalgebra::Matrix3;

use crate::claims::measure::{growth, problem, text, threshold};
use crate::claims::{Case, Claim, Finding};
use crate::studies::StudyError;

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "S24-a",
        source: "[S24] Section 3, after Eq. (20)",
        statement: "Stepped in the conventional way, with pₙ carried along, the trapezoidal least-squares Lagrangian is unstable.",
        criterion: "On v̇ = −v the spectral radius of the live map (vₙ, pₙ) → (vₙ₊₁, pₙ₊₁) exceeds 1 for every h from 0.001 to 1000.",
        decide: conventional_map,
    },
    Claim {
        id: "S24-b-1",
        source: "[S24] Section 3, Eq. (23)",
        statement: "Method I is unconditionally stable, for dissipative systems too.",
        criterion: "Live steps contract on v̇ = −v and on every damped plane rotation, and the spectral radius of a live step \
                    is at most 1 for every stable 3 × 3 matrix of a search, for all h tried.",
        decide: method_i_is_stable,
    },
    Claim {
        id: "S24-b-2",
        source: "[S24] Section 3, after Eq. (23)",
        statement: "As h → ∞ Method I gives the right steady state of the test problem in one step.",
        criterion: "On v̇ = −v, |v₁| of one live step is below 10/h² for every h from 10 to 10⁶.",
        decide: method_i_finds_the_steady_state,
    },
    Claim {
        id: "S24-c-1",
        source: "[S24] Section 3, Eq. (25)",
        statement: "Method II is unconditionally stable on the test problem.",
        criterion: "Live steps contract on v̇ = −v and on every damped plane rotation, and the spectral radius of a live step \
                    is at most 1 for every stable 3 × 3 matrix of the search of S24-b-1.",
        decide: method_ii_is_stable,
    },
    Claim {
        id: "S24-c-2",
        source: "[S24] Section 3, after Eq. (25)",
        statement: "Method II oscillates about the steady state at finite h, and vₙ₊₁ → −vₙ as h → ∞.",
        criterion: "One live step on v̇ = −v changes the sign of v for every h from 0.01 to 10⁶, and v₁/v₀ is within 5/h of −1 \
                    for h ≥ 100.",
        decide: method_ii_oscillates,
    },
];

/// Step sizes over six decades and more.
const STEPS: [f64; 10] = [1e-3, 1e-2, 0.1, 0.5, 1.0, 2.0, 5.0, 10.0, 100.0, 1e3];

fn conventional_map() -> Result<Finding, StudyError> {
    let drag = problem("linear-drag", &[])?;
    let mut method = position_momentum(Trapezoidal::new(drag.lagrangian()));
    let (mut cases, mut deviation) = (Vec::new(), 0.0_f64);
    for h in STEPS {
        let map = method.step_with_tangent(0.0, h, &mut [1.0], &mut [0.0])?;
        let (trace, determinant) = (map.trace(), map.determinant());
        let discriminant = 0.25 * trace * trace - determinant;
        let radius = if discriminant < 0.0 { determinant.sqrt() } else { 0.5 * trace.abs() + discriminant.sqrt() };
        let closed = (2.0 * (0.5 * h).asinh()).exp();
        deviation = deviation.max((radius / closed - 1.0).abs());
        cases.push(Case::above(format!("spectral radius, h = {h}"), radius, 1.0));
    }
    let (least, most) = (cases[0].measured, cases[STEPS.len() - 1].measured);
    let evidence = format!(
        "The spectral radius of a step grows from 1 + {} at h = 0.001 to {} at h = 1000.",
        text(least - 1.0),
        text(most)
    );
    Ok(Finding::on(cases, evidence).because(format!(
        "The map is symplectic, so that its two multipliers are reciprocal: exp(±2 asinh(h/2)), met to {} by the live \
         steps. The second-order equation v̈ = v has the solution exp(t) beside exp(−t), and rounding is enough to excite it.",
        text(deviation)
    )))
}

fn method_i_is_stable() -> Result<Finding, StudyError> {
    let (cases, found) = stability_cases("method-i", || Linear::METHOD_I)?;
    let Some(worst) = found.worst else {
        return Ok(Finding::on(cases, format!("No counterexample among {} matrices.", found.tried)));
    };
    let first = threshold("the radius of the counterexample crosses 1", 1e-3, worst.h, |h| {
        Ok(radius(&worst.a, h, Linear::METHOD_I)? - 1.0)
    })?;
    let row = |i: usize| format!("({}, {}, {})", text(worst.a[(i, 0)]), text(worst.a[(i, 1)]), text(worst.a[(i, 2)]));
    let evidence = format!(
        "Scalars and rotations contract at every h. Of {} stable 3 × 3 matrices, {} are amplified at some h; the worst has \
         spectral radius {} at h = {}.",
        found.tried,
        found.amplified,
        text(worst.radius),
        text(worst.h)
    );
    Ok(Finding::on(cases, evidence)
        .holds_where(
            "On scalars, on systems with a normal matrix, and on dissipative linear systems, those whose matrix has a \
             negative semidefinite symmetric part: there it is a theorem.",
        )
        .because(format!(
            "For v̇ = Av one step is (I − hS + ½h²AᵀA)⁻¹(I + hK) with the symmetric and skew parts S and K: stability \
             rests on S, not on the eigenvalues of A. The matrix with rows {}, {}, {} has no eigenvalue right of {}, but \
             S has the eigenvalue {}; it is amplified from h = {} on.",
            row(0),
            row(1),
            row(2),
            text(-MARGIN),
            text(worst.symmetric),
            text(first)
        )))
}

fn method_ii_is_stable() -> Result<Finding, StudyError> {
    let (cases, found) = stability_cases("method-ii", || Linear::METHOD_II)?;
    let evidence = format!(
        "All steps on v̇ = −v and on rotations contract; of {} stable 3 × 3 matrices {} are amplified.",
        found.tried, found.amplified
    );
    Ok(Finding::on(cases, evidence).because(
        "On linear problems with an invertible matrix Method II is the trapezoidal rule, which is stable wherever the \
         solutions do not grow. On nonlinear problems it is not that rule: see S24-h-2.",
    ))
}

fn method_i_finds_the_steady_state() -> Result<Finding, StudyError> {
    let (mut cases, mut last) = (Vec::new(), 0.0);
    for h in [10.0, 100.0, 1e3, 1e4, 1e5, 1e6] {
        last = growth("method-i", h)?;
        cases.push(Case::below(format!("|v₁|, h = {h}"), last.abs(), 10.0 / (h * h)));
    }
    let evidence = format!("One step of h = 10⁶ leaves {} of v₀, that is {}/h².", text(last), text(last * 1e12));
    Ok(Finding::on(cases, evidence).because(
        "R = 1/(1 + h + h²/2) → 0: pₙ₊₁ = 0 includes the residual at the end of the step, in which f dominates. On \
         nonlinear problems the fixed points are those of (2I − hJᵀ) f = 0, of which the steady states are not all.",
    ))
}

fn method_ii_oscillates() -> Result<Finding, StudyError> {
    let mut cases = Vec::new();
    for h in [0.01, 0.1, 1.0, 1.9, 2.1, 5.0, 10.0, 100.0, 1e4, 1e6] {
        let r = growth("method-ii", h)?;
        cases.push(Case::below(format!("v₁/v₀, h = {h}"), r, 0.0));
        if h >= 100.0 {
            cases.push(Case::below(format!("|v₁/v₀ + 1|, h = {h}"), (r + 1.0).abs(), 5.0 / h));
        }
    }
    let start = threshold("v₁/v₀ of Method II", 0.1, 10.0, |h| growth("method-ii", h))?;
    let evidence = format!("v₁/v₀ changes sign at h = {}; at h = 10⁶ it is −1 + {}.", text(start), {
        text(growth("method-ii", 1e6)? + 1.0)
    });
    Ok(Finding::on(cases, evidence)
        .holds_where(format!("The solution oscillates for h > {} and decays monotonically below.", text(start)))
        .because("R = (1 − h/2)/(1 + h/2), the trapezoidal rule's: its zero is at h = 2, and |R| → 1 as h → ∞."))
}

/// What the search found.
struct Search {
    tried: usize,
    amplified: usize,
    worst: Option<Amplified>,
}

/// A stable matrix that a method amplifies.
struct Amplified {
    a: Matrix3<f64>,
    h: f64,
    radius: f64,
    symmetric: f64,
}

/// Roundings of a 3 × 3 step whose matrix has a condition number up to a few thousand.
const ROUNDOFF: f64 = 1e-12;

fn stability_cases(method: &str, closure: fn() -> Linear) -> Result<(Vec<Case>, Search), StudyError> {
    let mut cases = Vec::new();
    for h in STEPS {
        cases.push(Case::below(format!("|v₁/v₀| on v̇ = −v, h = {h}"), growth(method, h)?.abs(), 1.0));
    }
    for (damping, turning) in [(1.0, 1.0), (1.0, 10.0), (0.01, 1.0), (1e-3, 100.0)] {
        for h in [0.01, 0.1, 1.0, 10.0, 1e3] {
            let radius = radius(&rotation(damping, turning), h, closure())?;
            cases.push(Case::below(format!("spectral radius, rotation −{damping} ± {turning}i, h = {h}"), radius, 1.0));
        }
    }
    let search = search(closure)?;
    let worst = search.worst.as_ref().map_or(1.0, |worst| worst.radius);
    cases.push(Case::below("largest spectral radius over the stable 3 × 3 matrices", worst, 1.0 + ROUNDOFF));
    Ok((cases, search))
}

/// v̇ = (−damping ± i turning) v in the plane, and a third component that decays alone.
fn rotation(damping: f64, turning: f64) -> Matrix3<f64> {
    Matrix3::new(-damping, -turning, 0.0, turning, -damping, 0.0, 0.0, 0.0, -1.0)
}

/// Matrices in the search.
const TRIED: usize = 400;
/// Their eigenvalues are left of minus this.
const MARGIN: f64 = 0.1;

/// Steps of three sizes on matrices with entries uniform in (−10, 10), shifted to the left.
fn search(closure: fn() -> Linear) -> Result<Search, StudyError> {
    let mut seed = 1_u64;
    // Knuth's linear congruential generator; its upper bits are good enough to spread matrices about.
    let mut uniform = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        20.0 * ((seed >> 11) as f64 / (1_u64 << 53) as f64) - 10.0
    };
    let mut found = Search { tried: TRIED, amplified: 0, worst: None };
    for _ in 0..TRIED {
        let random = Matrix3::from_fn(|_, _| uniform());
        let abscissa = random.complex_eigenvalues().iter().map(|z| z.re).fold(f64::NEG_INFINITY, f64::max);
        let a = random - Matrix3::identity() * (abscissa + MARGIN);
        let mut here: Option<(f64, f64)> = None;
        for h in [0.05, 0.1, 0.2] {
            let radius = radius(&a, h, closure())?;
            if radius > here.map_or(1.0 + ROUNDOFF, |(_, r)| r) {
                here = Some((h, radius));
            }
        }
        let Some((h, radius)) = here else { continue };
        found.amplified += 1;
        if found.worst.as_ref().is_none_or(|worst| radius > worst.radius) {
            let symmetric = (0.5 * (a + a.transpose())).symmetric_eigenvalues().max();
            found.worst = Some(Amplified { a, h, radius, symmetric });
        }
    }
    Ok(found)
}

/// Spectral radius of one live step on v̇ = Av.
fn radius(a: &Matrix3<f64>, h: f64, closure: Linear) -> Result<f64, StudyError> {
    let mut method = least_squares(LinearSystem(*a), closure);
    let mut map = Matrix3::identity();
    for mut column in map.column_iter_mut() {
        let mut v = [column[0], column[1], column[2]];
        method.step(0.0, h, &mut v, &mut [0.0; 3])?;
        column.copy_from_slice(&v);
    }
    Ok(map.complex_eigenvalues().iter().map(|z| z.norm()).fold(0.0, f64::max))
}

/// v̇ = Av.
struct LinearSystem(Matrix3<f64>);

impl VectorField for LinearSystem {
    fn dim(&self) -> usize {
        3
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        for (i, dv) in dv.iter_mut().enumerate() {
            *dv = (0..3).map(|j| self.0[(i, j)] * v[j]).sum();
        }
    }
    fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
        for i in 0..3 {
            (0..3).for_each(|j| out.add(i, j, scale * self.0[(i, j)]));
        }
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
}
