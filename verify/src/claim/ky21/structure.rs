//! What the path-fitted integrators conserve.

use lsvi::discrete::{Constrainable, Galerkin, PathFitted};
use lsvi::position_momentum;
use lsvi::quadrature::NodeFamily;
use nalgebra::{DMatrix, DVector};

use crate::claim::measure::{problem, table, text, trajectory};
use crate::claim::{Case, Claim, Finding, Quantifier};
use crate::experiment::{Context, StudyError};
use crate::measure::norm::Extremes;
use crate::problem::{Mechanics, Problem};

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "KY21-e-1",
        source: "[KY21] Introduction, Section 1",
        statement: "Path-fitted integrators are symplectic by construction.",
        quantifier: Quantifier::Universal,
        criterion: "For degrees 2, 3 and 4 the derivative DΦ of a live step has ‖DΦᵀΩDΦ − Ω‖ at rounding, on the \
                    Hénon–Heiles problem (separable), a charged particle (magnetic field) and the double pendulum (mass \
                    matrix depends on q).",
        decide: symplecticity,
    },
    Claim {
        id: "KY21-e-2",
        source: "[KY21] Section 1",
        statement: "Path-fitted integrators conserve momentum maps.",
        quantifier: Quantifier::Universal,
        criterion: "For degrees 2, 3 and 4 the angular momentum of Kepler's problem stays at rounding over two periods.",
        decide: momentum,
    },
    Claim {
        id: "KY21-f",
        source: "[KY21] Section 3.1, Figure 2; Section 3.2, Figure 3",
        statement: "The energy errors stay within bounds.",
        quantifier: Quantifier::General,
        criterion: "For degrees 2, 3 and 4 the largest energy error on the last tenth of 500 time units is at most twice that \
                    on the first, on the oscillator and the pendulum; and on a pendulum without symmetry that rotates, the drift \
                    over 1000 time units, by the slope in either half, is below a thousandth of the energy error.",
        decide: energy,
    },
];

const DEGREES: [usize; 3] = [2, 3, 4];

type Discretise = fn(Mechanics<'_>, usize) -> Result<Box<dyn Constrainable + '_>, StudyError>;

const FAMILIES: [(&str, Discretise); 3] = [
    ("path-fitted", |system, m| Ok(Box::new(PathFitted::on(system.lagrangian, NodeFamily::Equispaced, m)?))),
    ("path-fitted on Gauss nodes", |system, m| Ok(Box::new(PathFitted::on(system.lagrangian, NodeFamily::Gauss, m)?))),
    ("Galerkin, Gauss", |system, m| Ok(Box::new(Galerkin::gauss(system.lagrangian, m - 1)?))),
];

/// ‖DΦᵀΩDΦ − Ω‖ of one step from the problem's initial state, by implicit differentiation.
fn defect(problem: &dyn Problem, discretise: Discretise, m: usize, h: f64) -> Result<f64, StudyError> {
    let system = problem.mechanics().ok_or("not a mechanical problem")?;
    let mut method = position_momentum(discretise(system, m)?);
    let mut q = problem.initial();
    let n = q.len() / 2;
    let mut p = q.split_off(n);
    let tangent = method.step_with_tangent(0.0, h, &mut q, &mut p)?;
    let mut omega = DMatrix::zeros(2 * n, 2 * n);
    for i in 0..n {
        omega[(i, n + i)] = 1.0;
        omega[(n + i, i)] = -1.0;
    }
    Ok((tangent.transpose() * &omega * &tangent - &omega).amax())
}

/// Rounding of a tangent: differentiation m²/τ ≤ 80 against entries of order 1, both ways.
const ROUNDOFF: f64 = 1e4 * f64::EPSILON;

fn symplecticity(_context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut rows) = (Vec::new(), Vec::new());
    let tau = 0.2;
    let systems: [(&str, &[(&str, &str)]); 3] = [
        // Away from the symmetry axes, on which a defect may vanish.
        ("henon-heiles", &[("x0", "0.1"), ("y0", "-0.2"), ("px0", "0.4"), ("py0", "0.3")]),
        ("charged-particle", &[("y0", "-0.3")]),
        ("double-pendulum", &[("p10", "0.3"), ("p20", "-0.2")]),
    ];
    for (name, set) in systems {
        let system = problem(name, set)?;
        for (family, discretise) in FAMILIES {
            for m in DEGREES {
                let (coarse, fine) =
                    (defect(&*system, discretise, m, 2.0 * tau)?, defect(&*system, discretise, m, tau)?);
                if family == FAMILIES[0].0 {
                    cases.push(Case::below(format!("defect, degree {m}, {name}, τ = {tau}"), fine, ROUNDOFF));
                }
                let exponent = if fine > 100.0 * ROUNDOFF { (coarse / fine).log2() } else { f64::NAN };
                let label = if family == FAMILIES[2].0 { m - 1 } else { m };
                rows.push((vec![name.into(), family.into(), label.to_string()], vec![fine, exponent]));
            }
        }
    }
    let of = |case: usize| text(cases[case].measured);
    let evidence = format!(
        "The defects of degrees 2, 3 and 4 are {}, {} and {} on Hénon–Heiles, {}, {} and {} for the charged particle, {}, {} and \
         {} for the double pendulum.",
        of(0),
        of(1),
        of(2),
        of(3),
        of(4),
        of(5),
        of(6),
        of(7),
        of(8)
    );
    let caption = format!(
        "Defect of symplecticity of one step, τ = {tau}, and the power of τ with which it falls where it is above rounding. The \
         equispaced nodes are the paper's; Galerkin integrators of the same number of stages are symplectic everywhere."
    );
    let defects =
        table("claims-symplecticity", &caption, &["problem", "integrator", "degree", "defect", "exponent"], rows);
    Ok(Finding::on(cases, evidence)
        .holds_where(
            "For degree 2 and, with Gauss nodes in place of equispaced ones, every degree, where L = ½ẋᵀMẋ − V(x) with \
             constant M. On linear problems the defect hides: KY21-a.",
        )
        .because(
            "Taking the Euler–Lagrange equation to hold at the nodes replaces an integral by zero in the derivative of L_d; \
             for that derivative to be one of some L_d the nodes have to be Gauss's and the mass constant.",
        )
        .with_table(defects))
}

/// Largest change of an invariant over a run; infinite if it breaks off.
fn drift(
    problem: &dyn Problem,
    method: &str,
    tau: f64,
    horizon: f64,
    invariant: &str,
) -> Result<Vec<(f64, f64)>, StudyError> {
    let invariants = problem.invariants();
    let invariant = invariants.iter().find(|i| i.name == invariant).ok_or("no such invariant")?;
    let start = invariant.value(&problem.initial());
    let states = trajectory(problem, method, tau, horizon)?;
    if states.last().is_none_or(|(t, _)| *t < horizon) {
        return Ok(vec![(horizon, f64::INFINITY)]);
    }
    Ok(states.iter().map(|(t, y)| (*t, invariant.value(y) - start)).collect())
}

fn worst(changes: &[(f64, f64)], from: f64, to: f64) -> f64 {
    changes.iter().filter(|(t, _)| (from..=to).contains(t)).map(|(_, x)| x.abs()).largest()
}

fn momentum(_context: &Context) -> Result<Finding, StudyError> {
    let kepler = problem("kepler", &[])?;
    let (tau, horizon) = (0.05, 12.5);
    let change = |method: &str| -> Result<f64, StudyError> {
        Ok(worst(&drift(&*kepler, method, tau, horizon, "angular momentum")?, 0.0, horizon))
    };
    let mut cases = Vec::new();
    for m in DEGREES {
        // 250 steps of rounding, magnified by m²/τ in the momentum.
        let bound = 250.0 * (m * m) as f64 / tau * f64::EPSILON;
        cases.push(Case::below(format!("change, degree {m}"), change(&format!("path-fitted({m})"))?, bound));
    }
    let gauss = change("path-fitted(4,gauss)")?;
    let galerkin = change("galerkin-gauss(3)")?;
    let evidence = format!(
        "The angular momentum of 0.8 changes by {}, {} and {} with degrees 2, 3 and 4; by {} with degree 4 on Gauss nodes.",
        text(cases[0].measured),
        text(cases[1].measured),
        text(cases[2].measured),
        text(gauss)
    );
    Ok(Finding::on(cases, evidence).holds_where("For degree 2 and for Gauss nodes.").because(format!(
        "Noether's theorem needs a discrete Lagrangian, and on equispaced nodes there is none from degree 3 on. The \
             Galerkin integrator of degree 3, which has one, changes it by {}.",
        text(galerkin)
    )))
}

/// Drifts of the energy in the two halves of a rotation, per unit of time: the coefficient of t in a least-squares fit of the
/// energy error by 1, t and functions of period 2π in the angle, which take up its oscillation.
fn drifts(system: &dyn Problem, method: &str, tau: f64, horizon: f64) -> Result<([f64; 2], f64), StudyError> {
    const HARMONICS: usize = 10;
    let invariants = system.invariants();
    let energy = invariants.iter().find(|i| i.name == "energy").ok_or("no energy")?;
    let start = energy.value(&system.initial());
    let states = trajectory(system, method, tau, horizon)?;
    if states.last().is_none_or(|(t, _)| *t < horizon) {
        return Err(format!("{method} broke off").into());
    }
    let error = |y: &[f64]| energy.value(y) - start;
    let slope = |states: &[(f64, Vec<f64>)]| -> Result<f64, StudyError> {
        let functions = DMatrix::from_fn(states.len(), 2 + 2 * HARMONICS, |i, j| {
            let (t, angle) = (states[i].0, states[i].1[0]);
            match j {
                0 => 1.0,
                1 => t / horizon - 0.5,
                j if j % 2 == 0 => ((j / 2) as f64 * angle).cos(),
                j => ((j / 2) as f64 * angle).sin(),
            }
        });
        let errors = DVector::from_iterator(states.len(), states.iter().map(|(_, y)| error(y)));
        let normal = (functions.transpose() * &functions).cholesky().ok_or("the fit is degenerate")?;
        Ok(normal.solve(&(functions.transpose() * errors))[1] / horizon)
    };
    let amplitude = states.iter().map(|(_, y)| error(y).abs()).largest();
    let (first, second) = states.split_at(states.len() / 2);
    Ok(([slope(first)?, slope(second)?], amplitude))
}

/// What the drift adds up to over the whole run relative to the energy error, by the half in which it is the larger: where a
/// slow oscillation hides a drift, or looks like one, this is what can be said of it.
fn steady(([first, second], amplitude): ([f64; 2], f64), horizon: f64) -> f64 {
    if first.abs() > second.abs() { first.abs() * horizon / amplitude } else { second.abs() * horizon / amplitude }
}

fn energy(_context: &Context) -> Result<Finding, StudyError> {
    let (tau, horizon) = (0.2, 1000.0);
    let mut cases = Vec::new();
    for name in ["harmonic-oscillator", "pendulum"] {
        let system = problem(name, &[])?;
        for m in DEGREES {
            let changes = drift(&*system, &format!("path-fitted({m})"), tau, 500.0, "energy")?;
            let (early, late) = (worst(&changes, 0.0, 50.0), worst(&changes, 450.0, 500.0));
            cases
                .push(Case::below(format!("late over early error, degree {m}, {name}"), late / early, 2.0).under(true));
        }
    }
    let rotation = problem("asymmetric-pendulum", &[])?;
    let mut rows = Vec::new();
    for method in ["path-fitted(2)", "path-fitted(3)", "path-fitted(4)", "path-fitted(4,gauss)"] {
        let found = drifts(&*rotation, method, tau, horizon)?;
        let ([first, second], amplitude) = found;
        let steady = steady(found, horizon);
        if method != "path-fitted(4,gauss)" {
            let case = Case::below(format!("drift of {method}, asymmetric-pendulum"), steady, 1e-3);
            cases.push(case.under(method == "path-fitted(2)"));
        }
        rows.push((vec![method.into()], vec![amplitude, first, second, steady]));
    }
    let halved = drifts(&*rotation, "path-fitted(3)", 0.5 * tau, 0.5 * horizon)?.0[1];
    let [_, (_, third), ..] = &rows[..] else { return Err("no drifts".into()) };
    let evidence = format!(
        "On a pendulum without symmetry that rotates, the energy of degree 3 drifts by {} and {} per unit of time in the two \
         halves of the run, steadily, and by {} at half the step.",
        text(third[1]),
        text(third[2]),
        text(halved)
    );
    let finding = Finding::on(cases, evidence)
        .holds_where(
            "For degree 2, and for all degrees on the oscillator and the librating pendulum, where every orbit is symmetric in time.",
        )
        .because(format!(
            "The nodes are symmetric, so that the schemes are reversible, and that alone bounds the error on orbits that the \
             reversal maps to themselves. Elsewhere it takes symplecticity, which equispaced nodes lose from degree 3 on \
             (KY21-e-1). The drift of degree 3 falls like τ to the power {}; at τ = {tau} it takes a time of {} to grow as large \
             as the error itself.",
            text((third[2] / halved).log2()),
            text(third[0] / third[2].abs())
        ));
    Ok(finding.with_table(table(
        "claims-energy",
        &format!(
            "Energy error of the rotation with τ = {tau}: its size, its drift per unit of time in the two halves of t ≤ {horizon}, \
             and over the whole run relative to the size, by the larger of the two. Gauss nodes for comparison."
        ),
        &["method", "size", "drift_first_half", "drift_second_half", "relative"],
        rows,
    )))
}
