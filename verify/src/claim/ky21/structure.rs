//! What the path-fitted integrators conserve.

use std::sync::Arc;

use crate::claim::measure::{at_most, text};
use crate::claim::{Case, Claim, Finding, Quantifier};
use crate::evidence::Table;
use crate::experiment::energy_drift::{Drift, EnergyDrift};
use crate::experiment::motion::Motion;
use crate::experiment::pendulum_orbit::PendulumOrbit;
use crate::experiment::symplectic_defect::Defects;
use crate::experiment::{Context, StudyError};
use crate::measure::norm::Extremes;
use crate::row;

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "KY21-e-1",
        source: "[KY21] Abstract, Introduction, Section 1, of variational integrators, among which it counts its own",
        statement: "Path-fitted integrators are symplectic by construction.",
        quantifier: Quantifier::Universal,
        criterion: "For degrees 2, 3 and 4 the derivative DΦ of a live step has ‖DΦᵀΩDΦ − Ω‖ at its rounding at all of 21 step \
                    sizes, on the Hénon–Heiles problem (separable), a charged particle (magnetic field) and the double \
                    pendulum (mass matrix depends on q).",
        decide: symplecticity,
    },
    Claim {
        id: "KY21-e-2",
        source: "[KY21] Section 1, of variational integrators, among which it counts its own",
        statement: "Where the discrete Lagrangian is invariant under a group, path-fitted integrators conserve its momentum map.",
        quantifier: Quantifier::Universal,
        criterion: "For degrees 2, 3 and 4 the angular momentum of Kepler's problem, whose fitted paths turn with their ends, stays at rounding over two periods.",
        decide: momentum,
    },
    Claim {
        id: "KY21-f-1",
        source: "[KY21] Section 3.1, Figure 2; Section 3.2, Figure 3",
        statement: "The energy errors of (16) on the oscillator, and of (21) and (22) on the pendulum, stay within bounds.",
        quantifier: Quantifier::Universal,
        criterion: "For degree 2 the largest energy error on the last tenth of 500 time units is at most 1.01 times that on the first.",
        decide: shown_energy,
    },
    Claim {
        id: "KY21-f-2",
        source: "[KY21] Abstract, Section 4",
        statement: "Path fitting inherits the bounded energy errors of variational integrators.",
        quantifier: Quantifier::Universal,
        criterion: "For degrees 2, 3 and 4 the largest energy error on the last tenth of 500 time units is at most 1.01 times that on the first, \
                    on the oscillator and the pendulum; and on a pendulum without symmetry that rotates, the drift \
                    of the mean energy error over 20 000 steps of 0.5 is within ten of its standard errors and the rounding of \
                    the steps. So it is, as a control, with degree 4 on Gauss nodes.",
        decide: energy,
    },
];

const DEGREES: [usize; 3] = [2, 3, 4];

/// The step of the runs whose energy is looked at.
const TAU: f64 = 0.2;

/// Path fitting on the paper's equispaced nodes and on Gauss nodes, and Galerkin integrators with as many stages, by degree.
const FAMILIES: [[&str; 3]; 3] = [
    ["path-fitted(2)", "path-fitted(3)", "path-fitted(4)"],
    ["path-fitted(2,gauss)", "path-fitted(3,gauss)", "path-fitted(4,gauss)"],
    ["galerkin-gauss(1)", "galerkin-gauss(2)", "galerkin-gauss(3)"],
];

fn symplecticity(context: &Context) -> Result<Finding, StudyError> {
    let (mut cases, mut shown, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    for problem in ["henon-heiles", "charged-particle", "double-pendulum"] {
        for family in FAMILIES {
            for method in family {
                let found = context.get(Defects { problem, method: method.into() })?;
                let point = found.shown();
                if family == FAMILIES[0] {
                    let what = format!("largest defect over its rounding, {method}, {problem}");
                    cases.push(Case::at_most(what, found.excess(), 1.0));
                    shown.push((text(point.defect), point.h));
                }
                let exponent = found.fit.as_ref().and_then(|fit| fit.line).map(|line| line.slope);
                rows.push(row![problem, method, point.h, point.defect, exponent]);
            }
        }
    }
    let of = |name: &str, shown: &[(String, f64)]| {
        let h = shown[0].1;
        let defects: Vec<&str> = shown.iter().map(|(defect, _)| defect.as_str()).collect();
        let is_one = shown.iter().all(|(_, other)| *other == h);
        is_one.then(|| format!("{} {name} (h = {h})", defects.join(", "))).ok_or("not one step size")
    };
    let names = ["on Hénon–Heiles", "for the charged particle", "for the double pendulum"];
    let parts = names.iter().zip(shown.chunks(3)).map(|(name, shown)| of(name, shown));
    let parts = parts.collect::<Result<Vec<_>, _>>()?;
    let evidence = format!("The defects of degrees 2, 3 and 4 are {}.", parts.join(", "));
    let caption = "Defect of symplecticity of one step of h, and the power of h with which it falls where it is above rounding. The \
                   equispaced nodes are the paper's; Galerkin integrators of the same number of stages are symplectic everywhere.";
    let defects =
        Table::new("claims-symplecticity", caption, ["problem", "integrator", "h", "defect", "exponent"], rows);
    Ok(Finding::on(cases, evidence)
        .holds_where(
            "For degree 2 and, with Gauss nodes in place of equispaced ones, every degree, where L = ½ẋᵀMẋ − V(x) with \
             constant M. On linear problems the defect hides: KY21-a.",
        )
        .because(
            "Taking the Euler–Lagrange equation to hold at the nodes replaces an integral by zero in the derivative of L_d; \
             that derivative is one of some L_d where the nodes are Gauss's and L = ½ẋᵀMẋ − V(x) with constant M, and in general not \
             elsewhere, nor with a term that is linear in ẋ.",
        )
        .with_table(defects))
}

fn momentum(context: &Context) -> Result<Finding, StudyError> {
    let (tau, horizon) = (0.05, 12.5);
    let change = |method: &str| -> Result<f64, StudyError> {
        let run = Motion { problem: "kepler", method: method.into(), h: tau, t_end: horizon };
        Ok(context.get(run)?.largest_change("angular momentum", 0.0, horizon))
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
    Ok(Finding::on(cases, evidence).holds_where("For degree 2 and for Gauss nodes, where L = ½ẋᵀMẋ − V(x) with constant M.").because(format!(
        "The condition holds: the action (2) of a fitted path does not change when its ends are turned. But the momenta of the \
             scheme are not the derivatives of that action; on equispaced nodes they are those of no discrete Lagrangian from \
             degree 3 on, and Noether's theorem needs one. The Galerkin integrator of degree 3, which has one, changes it by {}.",
        text(galerkin)
    )))
}

/// The largest energy error of a degree late in a run over that early in it, on orbits that a reversal of time maps to themselves.
fn late_over_early(context: &Context, degree: usize) -> Result<Vec<Case>, StudyError> {
    let of = |problem: &'static str| -> Result<Case, StudyError> {
        let method = format!("path-fitted({degree})");
        let run = context.get(Motion { problem, method, h: TAU, t_end: 500.0 })?;
        let [early, late] = [[0.0, 50.0], [450.0, 500.0]].map(|[from, to]| run.largest_change("energy", from, to));
        let what = format!("late over early error, degree {degree}, {problem}");
        Ok(Case::at_most(what, late / early, PendulumOrbit::BOUNDED))
    };
    ["harmonic-oscillator", "pendulum"].into_iter().map(of).collect()
}

fn shown_energy(context: &Context) -> Result<Finding, StudyError> {
    let cases = late_over_early(context, 2)?;
    let worst = at_most(cases.iter().map(|case| case.measured).largest());
    Ok(Finding::on(cases, format!("The late energy error over the early one is {worst} at most.")).because(
        "On the oscillator a step of (16) that is stable is a rotation in other coordinates, with another period, so that its energy error is bounded \
         for all time. The pendulum's orbits are symmetric and the schemes reversible, see KY21-f-2.",
    ))
}

fn energy(context: &Context) -> Result<Finding, StudyError> {
    const H: f64 = 0.5;
    let mut cases = Vec::new();
    for m in DEGREES {
        cases.extend(late_over_early(context, m)?);
    }
    let rotation = |method: &str, h: f64| -> Result<Arc<Drift>, StudyError> {
        Ok(context.get(EnergyDrift { problem: "asymmetric-pendulum", method: method.into(), h, steps: 20_000 })?)
    };
    let per_time = |found: &Drift, h: f64| found.drift / (h * found.steps as f64);
    let mut rows = Vec::new();
    for method in ["path-fitted(2)", "path-fitted(3)", "path-fitted(4)", "path-fitted(4,gauss)"] {
        let found = rotation(method, H)?;
        let what = format!("drift of {method}, asymmetric-pendulum");
        cases.push(Case::at_most(what, found.drift, found.resolved()));
        rows.push(row![method, found.largest(), found.drift, found.resolved(), per_time(&found, H)]);
    }
    let [third, halved] = [rotation("path-fitted(3)", H)?, rotation("path-fitted(3)", 0.5 * H)?];
    let evidence = format!(
        "On a pendulum without symmetry that rotates, the mean energy of degree 3 drifts by {} over {} steps of {H}, where {} \
         would be resolved.",
        text(third.drift),
        third.steps,
        text(third.resolved()),
    );
    let finding = Finding::on(cases, evidence)
        .holds_where(
            "Where L = ½ẋᵀMẋ − V(x) with constant M: for degree 2, and with Gauss nodes in place of equispaced ones for every \
             degree; for degrees 3 and 4 on the oscillator and the librating pendulum, where every orbit is symmetric in time.",
        )
        .because(format!(
            "The nodes are symmetric, so that the schemes are reversible, and that alone bounds the error on orbits that the \
             reversal maps to themselves. Elsewhere it takes symplecticity, which equispaced nodes lose from degree 3 on \
             (KY21-e-1). The drift of degree 3 in a unit of time falls like τ to the power {} from τ = {H}, where it takes a time \
             of {} to grow as large as the error itself.",
            text((per_time(&third, H) / per_time(&halved, 0.5 * H)).log2()),
            text(third.largest() / per_time(&third, H))
        ));
    let caption = format!(
        "Energy error of the rotation over 20 000 steps of {H}: its size, what its mean drifts by, the least drift that would be \
         resolved, and the drift in a unit of time. Gauss nodes for comparison."
    );
    let columns = ["method", "size", "drift", "resolved", "per_time"];
    Ok(finding.with_table(Table::new("claims-energy", caption, columns, rows)))
}
