//! Stability on linear problems: the conventional map, Methods I and II.

use std::sync::Arc;

use crate::claim::measure::{at_most, beside_one, text};
use crate::claim::{Case, Claim, Finding, Quantifier};
use crate::experiment::momentum_map::{Closed, MomentumMap};
use crate::experiment::non_normal::{
    self, Amplified, AmplifiedFrom, Dissipative, Fading, MARGIN, ROUNDOFF, Rotation, Rotations, SingularlyDamped,
};
use crate::experiment::one_step::{LeavesAt, OneStep};
use crate::experiment::step_equation::{self, StepEquation};
use crate::experiment::{Context, StudyError};
use crate::measure::norm::{Extremes, max_norm};
use crate::measure::stability::numerical_abscissa;

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "S24-a",
        source: "[S24] Section 3, after Eq. (20)",
        statement: "On the test problem, stepped in the conventional way, with pₙ carried along, the trapezoidal least-squares \
                    Lagrangian is unstable.",
        quantifier: Quantifier::Universal,
        criterion: "On v̇ = −v the spectral radius of the live map (vₙ, pₙ) → (vₙ₊₁, pₙ₊₁) exceeds 1 at every h tested from 0.001 to 1000.",
        decide: conventional_map,
    },
    Claim {
        id: "S24-b-1",
        source: "[S24] Section 3, Eq. (23)",
        statement: "Method I is stable at every step size on the test problem, and on dissipative systems if they are linear with constant \
                    coefficients (our restriction).",
        quantifier: Quantifier::Universal,
        criterion: "Live steps contract on v̇ = −v and on every damped plane rotation, and the spectral radius of a live step \
                    is at most 1 on random systems whose matrix has a negative semidefinite symmetric part.",
        decide: method_i_on_dissipative_systems,
    },
    Claim {
        id: "S24-b-2",
        source: "[S24] Section 3, after Eq. (23)",
        statement: "As h → ∞ Method I gives the right steady state of the test problem in one step.",
        quantifier: Quantifier::Universal,
        criterion: "On v̇ = −v, |v₁| of one live step is below 10/h² at every h tested from 10 to 10⁶.",
        decide: method_i_finds_the_steady_state,
    },
    Claim {
        id: "S24-b-3",
        source: "[S24] Section 3, after Eq. (27)",
        statement: "Method I is unconditionally stable: no step size lets grow without bound what stays bounded, whether it is dissipative or not. Our wider \
                    reading: the abstract has “for dissipative systems”, and the text after Eq. (23) “even for dissipative systems”.",
        quantifier: Quantifier::Wider,
        criterion: "The spectral radius of a live step is at most 1 on v̇ = −v, on damped plane rotations, on v̇₁ = −v₁, v̇₂ = 0, and on the \
                    stable linear system of 3 unknowns that a search finds to be amplified most.",
        decide: method_i_on_stable_systems,
    },
    Claim {
        id: "S24-c-1",
        source: "[S24] Section 3, Eq. (25)",
        statement: "Method II is stable at every step size on the test problem, and on stable systems that are linear with a constant and \
                    invertible matrix (our restriction).",
        quantifier: Quantifier::Universal,
        criterion: "Live steps contract on v̇ = −v and on every damped plane rotation, and the spectral radius of a live step \
                    is at most 1 on the stable system of 3 unknowns that the search of S24-b-3, made for Method II, finds to be amplified most.",
        decide: method_ii_is_stable,
    },
    Claim {
        id: "S24-c-2",
        source: "[S24] Section 3, after Eq. (25)",
        statement: "With Method II vₙ₊₁ → −vₙ as h → ∞.",
        quantifier: Quantifier::Universal,
        criterion: "|v₁/v₀ + 1| of one live step on v̇ = −v is below 5/h at every h tested from 10 to 10⁶.",
        decide: method_ii_at_infinity,
    },
    Claim {
        id: "S24-c-3",
        source: "[S24] Section 3, after Eq. (25)",
        statement: "At finite h Method II oscillates about the steady state.",
        quantifier: Quantifier::General,
        criterion: "One live step on v̇ = −v changes the sign of v at every h tested from 0.01 to 10⁶.",
        decide: method_ii_oscillates,
    },
    Claim {
        id: "S24-c-4",
        source: "[S24] Section 3, after Eq. (27)",
        statement: "Method II is unconditionally stable: no step size lets grow without bound what stays bounded. The abstract has “for dissipative systems”, \
                    and v̇₁ = −v₁, v̇₂ = 0, which loses ½|v|² wherever v₁ ≠ 0, is one.",
        quantifier: Quantifier::Universal,
        criterion: "As for S24-b-3. A step that is not determined counts as not bounded: every v₂, however large, is one of its solutions.",
        decide: method_ii_on_stable_systems,
    },
];

/// Step sizes over six decades and more.
const STEPS: [f64; 10] = [1e-3, 1e-2, 0.1, 0.5, 1.0, 2.0, 5.0, 10.0, 100.0, 1e3];

fn conventional_map(context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut deviations) = (Vec::new(), Vec::new());
    for h in STEPS {
        let map = context.get(MomentumMap { problem: "linear-drag", closure: Closed::Conventional, h })?;
        let closed = (2.0 * (0.5 * h).asinh()).exp();
        deviations.push(map.radius / closed - 1.0);
        cases.push(Case::above(format!("spectral radius, h = {h}"), map.radius, 1.0));
    }
    let deviation = max_norm(&deviations);
    let (least, most) = (cases[0].measured, cases[STEPS.len() - 1].measured);
    let evidence = format!(
        "The spectral radius of a step grows from 1 + {} at h = 0.001 to {} at h = 1000.",
        text(least - 1.0),
        text(most)
    );
    Ok(Finding::on(cases, evidence).because(format!(
        "The map is symplectic, so that its two multipliers are reciprocal: exp(±2 asinh(h/2)), met to {} by the live \
         steps. The second-order equation v̈ = v has the solution exp(t) beside exp(−t), and rounding is enough to excite it.",
        at_most(deviation)
    )))
}

fn method_i_on_dissipative_systems(context: &Context) -> Result<Finding, StudyError> {
    let mut cases = on_normal_systems(context, "method-i")?;
    let found = context.get(Dissipative)?;
    for found in found.iter() {
        let what = format!("largest spectral radius, dissipative systems of {} unknowns", found.order);
        cases.push(Case::at_most(what, found.radius, 1.0 + ROUNDOFF));
    }
    let largest = cases[cases.len() - found.len()..].iter().map(|case| case.measured).largest();
    let evidence = format!(
        "Linear scalars, rotations and linear dissipative systems with constant coefficients are stable at every step size; the largest spectral radius of the last \
         is {}.",
        beside_one(largest, ROUNDOFF)
    );
    let fading = *context.get(Fading)?;
    Ok(Finding::on(cases, evidence).because(format!(
        "For v̇ = Av one step is (I − hS + ½h²AᵀA)⁻¹(I + hK) with the symmetric and skew parts S and K of A. For a unit eigenvector v \
         with factor λ, (1 − h v*Sv + ½h²|Av|²) λ = 1 + h v*Kv. Where S is negative semidefinite, v*Kv = iκ and |Av|² ≥ κ² give \
         |λ|² ≤ (1 + h²κ²)/(1 + ½h²κ²)² ≤ 1. The eigenvalues of a step are bounded so, its norm is not. That the eigenvalues of A \
         do not lie in the right half-plane is not enough (S24-b-3), and neither is dissipation where the problem is not linear \
         (S24-h-1) or A depends on time: on v̇ = a(t) v a step is (2 + ha₀ − ha₁)/(1 + (1 − ha₁)²), without a bound on a₀ < 0. On v̇ = −10(1 − t) v, from t = 0 \
         with h = 1, it multiplies v by {}.",
        text(fading)
    )))
}

/// Steps on normal systems, on one whose matrix is singular, and on the stable system that is amplified most, which is returned too.
fn on_stable_systems(
    context: &Context,
    method: &'static str,
) -> Result<(Vec<Case>, Arc<non_normal::Found>), StudyError> {
    let mut cases = on_normal_systems(context, method)?;
    let singular = *context.get(SingularlyDamped(method))?;
    let singular = Case::at_most("spectral radius on v̇₁ = −v₁, v̇₂ = 0, h = 1", singular, 1.0 + ROUNDOFF);
    cases.push(singular.or_else("step not determined"));
    let worst = context.get(Amplified { method, order: 3 })?;
    cases.push(Case::at_most("largest spectral radius, stable systems of 3 unknowns", worst.radius, 1.0 + ROUNDOFF));
    Ok((cases, worst))
}

/// v̇ = 0.
const AT_REST: &str = "linear-drag lambda=0";

fn method_ii_on_stable_systems(context: &Context) -> Result<Finding, StudyError> {
    let (cases, worst) = on_stable_systems(context, "method-ii")?;
    let equation = StepEquation { problem: AT_REST, weights: StepEquation::METHOD_II, h: 1.0 };
    if *context.get(equation)? != step_equation::Found::Every {
        return Err("a step of Method II on v̇ = 0 is determined".into());
    }
    let evidence = format!(
        "A step on v̇₁ = −v₁, v̇₂ = 0 is not determined: with h = 1 every v₂ meets p₁ = p₀, as on v̇ = 0, so that no solution is \
         distinguished from the others. The search among stable systems of 3 unknowns, whose matrices are invertible, reaches a spectral radius of {}.",
        text(worst.radius)
    );
    Ok(Finding::on(cases, evidence)
        .holds_where("On stable linear systems with a constant and invertible matrix (S24-c-1).")
        .because(
            "L_d = (v₁ − v₀)²/(2h) on v̇ = 0 has p₁ = p₀ whatever v₁ is. In general Jᵀ(r₀ + r₁) = 0 leaves the residual free along the null vectors of Jᵀ, so that a step is not determined where the matrix is \
             singular. Method I, whose step is determined there, amplifies other systems (S24-b-3).",
        ))
}

fn method_i_on_stable_systems(context: &Context) -> Result<Finding, StudyError> {
    let (cases, worst) = on_stable_systems(context, "method-i")?;
    let search = Amplified { method: "method-i", order: 3 };
    let first = context.get(AmplifiedFrom(search))?.ok_or("the radius of the counterexample does not pass 1")?;
    let a = &worst.matrix;
    let row = |i: usize| format!("({}, {}, {})", text(a[(i, 0)]), text(a[(i, 1)]), text(a[(i, 2)]));
    let evidence = format!(
        "A search among stable systems of 3 unknowns finds one that a step of h = 1 multiplies by {}.",
        text(worst.radius)
    );
    Ok(Finding::on(cases, evidence)
        .holds_where("Where the coefficients are constant: on stable linear scalars, on stable systems with a normal matrix, and on linear dissipative systems (S24-b-1).")
        .because(format!(
            "Stability of a step is guaranteed by a negative semidefinite symmetric part S, not by the eigenvalues of the matrix. The matrix with rows {}, {}, \
             {} has no eigenvalue right of {}, but S has the eigenvalue {}, so that the system is not dissipative; the \
             smallest step that amplifies it is h = {}.",
            row(0),
            row(1),
            row(2),
            text(-MARGIN),
            text(numerical_abscissa(a)),
            text(first)
        )))
}

fn method_ii_is_stable(context: &Context) -> Result<Finding, StudyError> {
    let mut cases = on_normal_systems(context, "method-ii")?;
    let worst = context.get(Amplified { method: "method-ii", order: 3 })?;
    cases.push(Case::at_most("largest spectral radius, stable systems of 3 unknowns", worst.radius, 1.0 + ROUNDOFF));
    let evidence = format!(
        "All steps on v̇ = −v and on rotations contract; the search among stable systems of 3 unknowns reaches a spectral \
         radius of {}.",
        text(worst.radius)
    );
    Ok(Finding::on(cases, evidence).because(
        "On linear problems with an invertible matrix Method II is the trapezoidal rule, which is stable wherever the \
         solutions do not grow. Where the matrix is singular a step determines nothing, and on nonlinear problems it is not \
         that rule: the unrestricted sentence of the abstract is S24-h-2.",
    ))
}

fn method_i_finds_the_steady_state(context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut last) = (Vec::new(), 0.0);
    for h in [10.0, 100.0, 1e3, 1e4, 1e5, 1e6] {
        last = OneStep::growth("method-i", h).or_infinity(context)?;
        // R = 2/(h² + 2h + 2), below 2/h² by 2/h of itself; the roundings of the step are hε of it.
        cases.push(Case::below(format!("|v₁|, h = {h}"), last.abs(), 2.0 / (h * h)));
    }
    let evidence = format!("One step of h = 10⁶ leaves {} of v₀, that is {}/h².", text(last), text(last * 1e12));
    Ok(Finding::on(cases, evidence).beside("v₁/v₀, h = 10⁶", "→ 0", last).because(
        "R = 1/(1 + h + h²/2) → 0: pₙ₊₁ = 0 includes the residual at the end of the step, in which f dominates. On \
         nonlinear problems the fixed points are those of (2I − hJᵀ) f = 0, of which the steady states are not all.",
    ))
}

fn method_ii_at_infinity(context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut last) = (Vec::new(), 0.0);
    for h in [10.0, 100.0, 1e3, 1e4, 1e5, 1e6] {
        last = (OneStep::growth("method-ii", h).or_infinity(context)? + 1.0).abs();
        // R + 1 = 4/(h + 2), below 4/h by 2/h of itself; a rounding of R is hε of it.
        cases.push(Case::below(format!("|v₁/v₀ + 1|, h = {h}"), last, 4.0 / h));
    }
    let evidence = format!("At h = 10⁶ the ratio v₁/v₀ is −1 to {}.", text(last));
    Ok(Finding::on(cases, evidence).beside("v₁/v₀, h = 10⁶", "→ −1", last - 1.0).because(
        "R = (1 − h/2)/(1 + h/2), as for the trapezoidal rule: A-stable, but stiff components are not damped.",
    ))
}

fn method_ii_oscillates(context: &Context) -> Result<Finding, StudyError> {
    let mut cases = Vec::new();
    for h in [0.01, 0.1, 1.0, 1.9, 2.1, 5.0, 10.0, 100.0, 1e4, 1e6] {
        cases.push(
            Case::below(format!("v₁/v₀, h = {h}"), OneStep::growth("method-ii", h).or_infinity(context)?, 0.0)
                .under(h > 2.0),
        );
    }
    let start = *context.get(LeavesAt {
        step: OneStep::growth("method-ii", 1.0),
        least: 0.0,
        most: 1.0,
        low: 0.01,
        high: 1e6,
    })?;
    Ok(Finding::on(cases, format!("v₁/v₀ changes sign at h = {}.", text(start)))
        .holds_where(format!("The solution oscillates for h > {} and decays monotonically below.", text(start)))
        .because("R = (1 − h/2)/(1 + h/2) has its zero at h = 2."))
}

/// Steps on v̇ = −v and on damped rotations, whose matrices are normal.
fn on_normal_systems(context: &Context, name: &'static str) -> Result<Vec<Case>, StudyError> {
    let mut cases = Vec::new();
    for h in STEPS {
        let factor = OneStep::growth(name, h).or_infinity(context)?;
        cases.push(Case::below(format!("|v₁/v₀| on v̇ = −v, h = {h}"), factor.abs(), 1.0));
    }
    for Rotation { damping, turning, h, radius } in context.get(Rotations(name))?.iter().copied() {
        let what = format!("spectral radius, rotation −{damping} ± {turning}i, h = {h}");
        cases.push(Case::below(what, radius, 1.0));
    }
    Ok(cases)
}
