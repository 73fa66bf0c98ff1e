//! Stability on linear problems: the conventional map, Methods I and II.

use lsvi::discrete::Trapezoidal;
use lsvi::position_momentum;
use nalgebra::DMatrix;

use crate::chapter::StudyError;
use crate::claim::measure::{growth, problem, text, threshold};
use crate::claim::{Case, Claim, Finding};
use crate::measure::norm::larger;
use crate::measure::stability::{Uniform, numerical_abscissa, spectral_abscissa, spectral_radius};
use crate::method::{self, Method};
use crate::propagator::propagator;

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
        statement: "With Method II vₙ₊₁ → −vₙ as h → ∞.",
        criterion: "|v₁/v₀ + 1| of one live step on v̇ = −v is below 5/h for every h from 10 to 10⁶.",
        decide: method_ii_at_infinity,
    },
    Claim {
        id: "S24-c-3",
        source: "[S24] Section 3, after Eq. (25)",
        statement: "At finite h Method II oscillates about the steady state.",
        criterion: "One live step on v̇ = −v changes the sign of v for every h from 0.01 to 10⁶.",
        decide: method_ii_oscillates,
    },
];

/// Step sizes over six decades and more.
const STEPS: [f64; 10] = [1e-3, 1e-2, 0.1, 0.5, 1.0, 2.0, 5.0, 10.0, 100.0, 1e3];

fn conventional_map() -> Result<Finding, StudyError> {
    let drag = problem("linear-drag", &[])?;
    let mut method = position_momentum(Trapezoidal::new(drag.lagrangian()?));
    let (mut cases, mut deviation) = (Vec::new(), 0.0_f64);
    for h in STEPS {
        let map = method.step_with_tangent(0.0, h, &mut [1.0], &mut [0.0])?;
        let (trace, determinant) = (map.trace(), map.determinant());
        let discriminant = 0.25 * trace * trace - determinant;
        let radius = if discriminant < 0.0 { determinant.sqrt() } else { 0.5 * trace.abs() + discriminant.sqrt() };
        let closed = (2.0 * (0.5 * h).asinh()).exp();
        deviation = larger(deviation, (radius / closed - 1.0).abs());
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
    let (cases, found) = stability_cases("method-i")?;
    let Some(worst) = found.worst else {
        return Ok(Finding::on(cases, format!("No counterexample among {} matrices.", TRIED)));
    };
    let method = method::parse("method-i")?;
    let first = threshold("the radius of the counterexample crosses 1", 1e-3, worst.h, |h| {
        Ok(radius(&worst.a, h, &*method)? - 1.0)
    })?;
    let row = |i: usize| format!("({}, {}, {})", text(worst.a[(i, 0)]), text(worst.a[(i, 1)]), text(worst.a[(i, 2)]));
    let evidence = format!(
        "Scalars and rotations contract at every h. Of {} stable 3 × 3 matrices, {} are amplified at some h; the worst has \
         spectral radius {} at h = {}.",
        TRIED,
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
            text(numerical_abscissa(&worst.a)),
            text(first)
        )))
}

fn method_ii_is_stable() -> Result<Finding, StudyError> {
    let (cases, found) = stability_cases("method-ii")?;
    let evidence = format!(
        "All steps on v̇ = −v and on rotations contract; of {} stable 3 × 3 matrices {} are amplified.",
        TRIED, found.amplified
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

fn method_ii_at_infinity() -> Result<Finding, StudyError> {
    let (mut cases, mut last) = (Vec::new(), 0.0);
    for h in [10.0, 100.0, 1e3, 1e4, 1e5, 1e6] {
        last = (growth("method-ii", h)? + 1.0).abs();
        cases.push(Case::below(format!("|v₁/v₀ + 1|, h = {h}"), last, 5.0 / h));
    }
    let evidence = format!("At h = 10⁶ the ratio v₁/v₀ is −1 to {}.", text(last));
    Ok(Finding::on(cases, evidence)
        .because("R = (1 − h/2)/(1 + h/2), as for the trapezoidal rule: stable, but what is stiff is not damped."))
}

fn method_ii_oscillates() -> Result<Finding, StudyError> {
    let mut cases = Vec::new();
    for h in [0.01, 0.1, 1.0, 1.9, 2.1, 5.0, 10.0, 100.0, 1e4, 1e6] {
        cases.push(Case::below(format!("v₁/v₀, h = {h}"), growth("method-ii", h)?, 0.0));
    }
    let start = threshold("v₁/v₀ of Method II", 0.1, 10.0, |h| growth("method-ii", h))?;
    Ok(Finding::on(cases, format!("v₁/v₀ changes sign at h = {}.", text(start)))
        .holds_where(format!("The solution oscillates for h > {} and decays monotonically below.", text(start)))
        .because("R = (1 − h/2)/(1 + h/2) has its zero at h = 2."))
}

/// What the search found.
struct Search {
    amplified: usize,
    worst: Option<Amplified>,
}

/// A stable matrix that a method amplifies.
struct Amplified {
    a: DMatrix<f64>,
    h: f64,
    radius: f64,
}

/// Roundings of a 3 × 3 step whose matrix has a condition number up to a few thousand.
const ROUNDOFF: f64 = 1e-12;
/// Matrices in the search; the study of non-normal systems looks harder.
const TRIED: usize = 400;
/// Their eigenvalues are left of minus this.
const MARGIN: f64 = 0.1;

fn stability_cases(name: &str) -> Result<(Vec<Case>, Search), StudyError> {
    let method = method::parse(name)?;
    let mut cases = Vec::new();
    for h in STEPS {
        cases.push(Case::below(format!("|v₁/v₀| on v̇ = −v, h = {h}"), growth(name, h)?.abs(), 1.0));
    }
    for (damping, turning) in [(1.0, 1.0), (1.0, 10.0), (0.01, 1.0), (1e-3, 100.0)] {
        let rotation = DMatrix::from_row_slice(2, 2, &[-damping, -turning, turning, -damping]);
        for h in [0.01, 0.1, 1.0, 10.0, 1e3] {
            let radius = radius(&rotation, h, &*method)?;
            cases.push(Case::below(format!("spectral radius, rotation −{damping} ± {turning}i, h = {h}"), radius, 1.0));
        }
    }
    let search = search(&*method)?;
    let worst = search.worst.as_ref().map_or(1.0, |worst| worst.radius);
    cases.push(Case::below("largest spectral radius over the stable 3 × 3 matrices", worst, 1.0 + ROUNDOFF));
    Ok((cases, search))
}

/// Steps of three sizes on matrices with entries uniform in (−10, 10), shifted to the left.
fn search(method: &dyn Method) -> Result<Search, StudyError> {
    let mut random = Uniform::new(1);
    let mut found = Search { amplified: 0, worst: None };
    for _ in 0..TRIED {
        let random = DMatrix::from_fn(3, 3, |_, _| 10.0 * random.next().unwrap_or_default());
        let a = &random - DMatrix::identity(3, 3) * (spectral_abscissa(&random) + MARGIN);
        let mut here: Option<Amplified> = None;
        for h in [0.05, 0.1, 0.2] {
            let radius = radius(&a, h, method)?;
            if radius > here.as_ref().map_or(1.0 + ROUNDOFF, |here| here.radius) {
                here = Some(Amplified { a: a.clone(), h, radius });
            }
        }
        let Some(here) = here else { continue };
        found.amplified += 1;
        if found.worst.as_ref().is_none_or(|worst| here.radius > worst.radius) {
            found.worst = Some(here);
        }
    }
    Ok(found)
}

/// Spectral radius of one live step on v̇ = Av.
fn radius(a: &DMatrix<f64>, h: f64, method: &dyn Method) -> Result<f64, StudyError> {
    Ok(spectral_radius(&propagator(method, &(h * a))?))
}
