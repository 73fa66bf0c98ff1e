//! What the integrators keep over long runs: energy, angular momentum, reversibility.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::{Context, Study, StudyError, prose};
use crate::evidence::number::digits;
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Series, Table};
use crate::experiment::energy_drift::{Drift, EnergyDrift, Kind};
use crate::experiment::motion::{Difference, Motion};
use crate::experiment::pendulum_orbit::PendulumOrbit;
use crate::experiment::reversal::Reversal;
use crate::measure::norm::Extremes;
use crate::method;
use crate::names::NameError;
use crate::problem;
use crate::row;
use crate::theory::integrators_for;

pub(super) const STUDY: Study = Study {
    id: "long-runs",
    title: "Energy, momentum and reversibility over long runs",
    question: "Does the energy drift, are momentum maps kept, and is each method reversible?",
    source: "[KY21] Section 3, Figs 1–3, (21), (22); [HLW06] IX–XI",
    run,
};

/// Problem, step and number of steps of each run. A constrained step costs as much as some ten of the others.
const SETTINGS: [(&str, f64, u64); 6] = [
    ("asymmetric-pendulum", 0.5, 100_000),
    ("henon-heiles", 0.25, 100_000),
    ("kepler", 0.05, 100_000),
    ("charged-particle", 0.2, 20_000),
    // With h = 0.1 the shortest times of this motion are not resolved, and degree 3 drifts by as much as can be seen.
    (CHAOTIC, 0.05, 50_000),
    ("spherical-pendulum", 0.1, 10_000),
];

/// Its motion from (1, 2) rad is chaotic: reversibility protects no energy there, and roundings grow exponentially.
const CHAOTIC: &str = "double-pendulum";

/// Of each kind that the text tells apart one: symplectic ones, path fitting on nodes of either sort, and what keeps nothing.
pub(super) const TOLD: [&str; 5] =
    ["midpoint-vi", "galerkin-gauss(3)", "path-fitted(4,gauss)", "path-fitted(4)", "rk4"];

/// A build for development takes a fifth of the steps, which are as much slower.
const PART: u64 = if cfg!(debug_assertions) { 5 } else { 1 };

/// Methods that are neither symplectic nor reversible, which have to fail.
const DISSIPATIVE: [&str; 3] = ["rk4", "implicit-euler", "sdirk2"];

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let most = context.max_steps();
    let mut runs = Vec::new();
    for (problem, h, steps) in SETTINGS {
        let names = distinct(problem)?.into_iter().chain(["rk4".to_owned()]);
        runs.extend(names.map(|method| EnergyDrift { problem, method, h, steps: (steps / PART).min(most) }));
    }
    let drifts = context.get_each(runs)?;
    // What drifts the least beside what would be resolved.
    let rk4 = drifts.iter().filter(|drift| drift.method == "rk4" && drift.problem != CHAOTIC);
    let rk4 = rk4.map(|drift| (drift.drift / drift.resolved(), drift.problem));
    let (least, on) = rk4.min_by(|a, b| a.0.total_cmp(&b.0)).ok_or("RK4 runs on these problems")?;
    let values = [("least", digits(least, 3)), ("least_on", format!("`{on}`"))];
    let mut evidence = Evidence {
        checks: drifts.iter().flat_map(|drift| checks(drift)).collect(),
        notes: prose::fill(include_str!("long_runs.md"), &values)?,
        ..Evidence::default()
    };
    evidence.tables.push(drift_table(&drifts));
    let windows = window_table(&drifts);
    evidence.figures.push(drift_figure(&windows));
    evidence.tables.push(windows);
    reversibility(&mut evidence, context)?;
    pendulum(&mut evidence, context, most.min(PENDULUM_STEPS))?;
    Ok(evidence)
}

/// The integrators for a problem, without those that restate another, as Bernstein's form of path fitting does Lagrange's.
fn distinct(problem: &str) -> Result<Vec<String>, NameError> {
    let mut names = integrators_for(problem)?;
    names.retain(|name| method::parse(name).is_ok_and(|method| method.traits().restates.is_none()));
    Ok(names)
}

/// Runs of a thousand steps of the [`distinct`] integrators on what is not chaotic.
pub(crate) fn short_runs() -> Result<Vec<EnergyDrift>, NameError> {
    let mut runs = Vec::new();
    for (problem, h, _) in SETTINGS.into_iter().filter(|setting| setting.0 != CHAOTIC) {
        runs.extend(distinct(problem)?.into_iter().map(|method| EnergyDrift { problem, method, h, steps: 1000 }));
    }
    Ok(runs)
}

fn checks(drift: &Drift) -> Vec<Check> {
    let Drift { problem, method, kind, steps, .. } = drift;
    let mut checks = Vec::new();
    let id = format!("drift/{problem}/{method}");
    let reason = "ten standard errors, and the rounding of the steps";
    // In chaos the energy of what dissipates falls by episodes, along no line.
    let drifts = (*kind == Kind::Dissipative && *problem != CHAOTIC)
        || (*kind == Kind::Symmetric && *problem == "asymmetric-pendulum");
    if drifts {
        let statement = format!("The energy of {method} drifts on {problem} over {steps} steps");
        checks.push(Check::at_least(id, statement, drift.drift, drift.resolved(), reason));
    } else if (*kind == Kind::Symplectic || *problem != CHAOTIC) && drift.resolved() < drift.largest() {
        // Where more than the largest energy error would have to be seen, nothing could be.
        let statement = format!("The energy of {method} does not drift on {problem} over {steps} steps");
        checks.push(Check::at_most(id, statement, drift.drift, drift.resolved(), reason));
    }
    let momentum = format!("momentum/{problem}/{method}");
    checks.extend(drift.momentum.map(|change| match kind {
        Kind::Symplectic => {
            let statement = format!("{method} keeps the angular momentum of {problem}");
            Check::at_most(momentum, statement, change, drift.rounding, "the rounding of the steps")
        }
        _ => {
            let statement = format!("{method} does not keep the angular momentum of {problem}");
            Check::at_least(momentum, statement, change, 10.0 * drift.rounding, "ten times the rounding")
        }
    }));
    checks
}

fn drift_table(drifts: &[Arc<Drift>]) -> Table {
    let rows = drifts.iter().map(|d| {
        let significance = d.drift / d.stderr;
        row![d.problem, &d.method, d.steps, d.largest(), d.drift, d.stderr, significance, d.rounding, d.momentum]
    });
    Table::new(
        "drift",
        "Energy error over a run: its largest value, what the slope of the fitted line adds up to with its standard error and \
         significance, and what rounding may add; and the change of the angular momentum, where the problem has one that is kept.",
        ["problem", "method", "steps", "largest", "drift", "stderr", "significance", "rounding", "momentum"],
        rows.collect(),
    )
}

fn window_table(drifts: &[Arc<Drift>]) -> Table {
    let rows = drifts
        .iter()
        .flat_map(|d| d.windows.iter().map(|window| row![d.problem, &d.method, window.t, window.mean, window.largest]));
    let columns = ["problem", "method", "t", "mean", "largest"];
    Table::data("drift-windows", "Weighted mean and largest energy error in each window.", columns, rows.collect())
}

fn drift_figure(windows: &Table) -> Figure {
    let panels = SETTINGS.iter().map(|(problem, ..)| {
        let curves = windows.where_text("problem", problem).curves("method", "t", "largest", Mark::Line);
        Panel::new(Axis::linear("t"), Axis::log("largest energy error"), curves).titled(*problem)
    });
    let caption = "Largest energy error in each window of time. A drift shows here once it is as large as the error that oscillates; the \
                   table has drifts far smaller.";
    Figure::new("drift", caption, windows.id.clone(), panels).in_columns(2).telling(&TOLD)
}

/// ρ Φ ρ Φ = id, where ρ turns the momentum round.
fn reversibility(evidence: &mut Evidence, context: &Context) -> Result<(), StudyError> {
    const H: f64 = 0.25;
    let mut rows = Vec::new();
    for problem in ["henon-heiles", "double-pendulum", "circle", "spherical-pendulum"] {
        for name in integrators_for(problem)?.into_iter().chain(DISSIPATIVE.map(str::to_owned)) {
            let method = method::parse(&name)?;
            let found = context.get(Reversal { problem, method: name.clone(), h: H })?;
            evidence.checks.push(reversal(
                problem,
                &name,
                method.traits().is_reversible,
                [found.defect, found.rounding],
            ));
            rows.push(row![problem, name, H, found.defect, found.rounding]);
        }
    }
    let caption =
        "Distance from where it started after a step, a reversal of the momentum, another step and another reversal.";
    let columns = ["problem", "method", "h", "defect", "rounding"];
    evidence.tables.push(Table::new("reversibility", caption, columns, rows));
    Ok(())
}

/// That a method is reversible or that it is not, as it says of itself.
fn reversal(problem: &str, name: &str, is_reversible: bool, [defect, rounding]: [f64; 2]) -> Check {
    let id = format!("reversible/{problem}/{name}");
    if is_reversible {
        let statement = format!("{name} is reversible on {problem}");
        Check::at_most(id, statement, defect, rounding, "rounding of two steps")
    } else {
        let statement = format!("{name} is not reversible on {problem}");
        Check::at_least(id, statement, defect, 1e3 * rounding, "a thousand roundings")
    }
}

/// Steps of the runs on the pendulum.
const PENDULUM_STEPS: u64 = 100_000;

/// The step of [KY21].
const H: f64 = 0.1;

/// (q₀, p₀) of their orbits: two librations and a rotation.
const STARTS: [(f64, f64); 3] = [(1.0, 0.0), (2.0, 0.0), (-3.0, 1.0)];

/// The schemes of [KY21] for the pendulum.
const SCHEMES: [(&str, &str); 2] = [("(21)", "path-fitted(2)"), ("(22)", "path-fitted-bernstein(2)")];

/// The pendulum of [KY21]: (21) against (22), portraits and energies over many steps.
fn pendulum(evidence: &mut Evidence, context: &Context, steps: u64) -> Result<(), StudyError> {
    for (degree, steps) in [(3, 1000), (4, 1000), (2, steps)] {
        let (one, other) = (format!("path-fitted({degree})"), format!("path-fitted-bernstein({degree})"));
        // From 2 rad.
        let found = context.get(Difference { problem: "pendulum", one, other, h: H, steps })?;
        evidence.checks.push(Check::at_most(
            format!("pendulum/bernstein-{degree}"),
            format!(
                "Path fitting of degree {degree} is the same in Lagrange's and in Bernstein's form over {steps} steps"
            ),
            found.largest,
            found.rounding,
            "independent roundings of q ≤ 2 in each step, four deviations of what they add up to",
        ));
    }
    let (mut states, mut energies, mut portraits) = (Vec::new(), Vec::new(), Vec::new());
    for (scheme, method) in SCHEMES {
        for (q0, p0) in STARTS {
            let orbit = context.get(PendulumOrbit { method, q0, p0, h: H, steps })?;
            evidence.checks.push(Check::at_most(
                format!("pendulum/energy-{scheme}-{q0}-{p0}"),
                format!(
                    "The energy error of {scheme} from ({q0}, {p0}) over the last tenth of {steps} steps is that over the first"
                ),
                orbit.late_over_early(),
                PendulumOrbit::BOUNDED,
                "a bounded error has the same maximum; at 63 phases of the motion or more it is met to (2π/63)²",
            ));
            let start = format!("from ({q0}, {p0})");
            states.extend(orbit.states.iter().map(|(t, q, p)| row![scheme, &start, *t, *q, *p]));
            if p0 == 0.0 {
                let label = format!("{scheme} from {q0} rad");
                energies.extend(orbit.energy_errors.iter().map(|(t, error)| row![&label, *t, *error]));
            }
        }
    }
    let caption = format!("One in {} states of orbits of the pendulum over {steps} steps.", PendulumOrbit::KEPT);
    let mut orbits = Table::data("pendulum-orbits", caption, ["scheme", "orbit", "t", "q", "p"], states);
    let caption = format!("Largest energy error on the pendulum in each hundredth of {steps} steps.");
    let energies = Table::data("pendulum-energy", caption, ["scheme", "t", "largest"], energies);
    let curves = energies.curves("scheme", "t", "largest", Mark::Line);
    let highest = curves.iter().flat_map(|curve| &curve.points).map(|(_, error)| *error).largest();
    let from_zero = Axis::linear("largest energy error").between(0.0, 1.5 * highest);
    for (scheme, _) in SCHEMES {
        let mut portrait = orbits.where_text("scheme", scheme).curves("orbit", "q", "p", Mark::Markers);
        portrait.extend(STARTS.map(|(q0, p0)| level_curve(q0, p0)));
        let panel = Panel::new(Axis::linear("q"), Axis::linear("p"), portrait);
        portraits.push(panel.titled(format!("Phase portrait, {scheme}")));
    }
    let (solution, rows) = solution(context)?;
    orbits.rows.extend(rows);
    let panels = [
        Panel::new(Axis::linear("t"), Axis::linear("q"), solution).titled("Solution"),
        Panel::new(Axis::linear("t"), from_zero, curves).titled("Energy"),
    ];
    let caption = format!(
        "The pendulum by path fitting of degree 2 in its two forms (21) and (22), τ = {H}: the solution, the energy error \
         over {steps} steps, and one in {} states of as long runs on the exact orbits (Fig. 3 of [KY21]).",
        PendulumOrbit::KEPT
    );
    let figure = Figure::new("pendulum", caption, orbits.id.clone(), panels.into_iter().chain(portraits));
    evidence.figures.push(figure.in_columns(2));
    evidence.tables.extend([orbits, energies]);
    Ok(())
}

/// A libration by (21), and the exact one; and the rows of its data.
fn solution(context: &Context) -> Result<(Vec<Series>, Vec<Vec<Cell>>), StudyError> {
    let (scheme, method) = SCHEMES[0];
    let run = context.get(Motion { problem: "pendulum", method: method.into(), h: H, t_end: 30.0 })?;
    let pendulum = problem::build_setting("pendulum")?;
    let exact = run.states.iter().filter_map(|(t, _)| Some((*t, pendulum.exact(*t)?[0])));
    let (exact, live) = (exact.collect(), run.states.iter().map(|(t, q)| (*t, q[0])).collect());
    let rows = run.states.iter().map(|(t, q)| row![scheme, "solution", *t, q[0], q[1]]).collect();
    Ok((vec![Series::new(scheme, live, Mark::Line), Series::new("exact", exact, Mark::Guide)], rows))
}

/// The exact orbit p = ± √(2 (E + cos q)).
fn level_curve(q0: f64, p0: f64) -> Series {
    let energy = 0.5 * p0 * p0 - q0.cos();
    // Between the turning points, or all round.
    let reach = if energy < 1.0 { (-energy).acos() } else { 0.5 * TAU };
    let half = |sign: f64| {
        let angle = move |i: i32| reach * (f64::from(i) / 100.0 * 0.25 * TAU).sin();
        (-100..=100).map(angle).map(|q| (q, sign * (2.0 * (energy + q.cos())).max(0.0).sqrt())).collect::<Vec<_>>()
    };
    let points =
        if energy < 1.0 { [half(1.0), half(-1.0).into_iter().rev().collect()].concat() } else { half(p0.signum()) };
    Series::new("exact", points, Mark::Guide)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;
    use crate::experiment::energy_drift::Window;

    #[test]
    fn reversibility_is_held_to_the_rounding_and_its_absence_to_a_thousand() {
        let outcome = |is_reversible, defect| reversal("circle", "method", is_reversible, [defect, 1e-16]).outcome;
        assert_eq!(
            [0.9e-16, 1.1e-16, f64::NAN].map(|defect| outcome(true, defect)),
            [Outcome::Pass, Outcome::Fail, Outcome::Fail]
        );
        assert_eq!(
            [1.1e-13, 0.9e-13, f64::NAN].map(|defect| outcome(false, defect)),
            [Outcome::Pass, Outcome::Fail, Outcome::Fail]
        );
    }

    #[test]
    fn momentum_is_kept_to_the_rounding_and_its_loss_is_ten_times_that() {
        let outcome = |kind: Kind, change: f64| {
            let windows = vec![Window { t: 1.0, mean: 0.0, largest: 1e-3 }];
            let (problem, method, steps, momentum) = ("kepler", "method".into(), 1000, Some(change));
            let drift =
                Drift { problem, method, kind, steps, windows, drift: 0.0, stderr: 1e-9, rounding: 1e-12, momentum };
            let checks = checks(&drift);
            checks.into_iter().find(|check| check.id.starts_with("momentum/")).expect("it has one").outcome
        };
        let (pass, fail) = (Outcome::Pass, Outcome::Fail);
        assert_eq!([0.9e-12, 1.1e-12, f64::NAN].map(|change| outcome(Kind::Symplectic, change)), [pass, fail, fail]);
        assert_eq!([1.1e-11, 0.9e-11, f64::NAN].map(|change| outcome(Kind::Dissipative, change)), [pass, fail, fail]);
    }

    /// In chaos of what is symplectic alone.
    #[test]
    fn the_drift_is_checked_on_every_problem() {
        let outcomes = |problem: &'static str, kind: Kind| {
            [0.9e-8, 1.1e-8].map(|drift| {
                let windows = vec![Window { t: 1.0, mean: 0.0, largest: 1e-3 }];
                let (method, steps, stderr, rounding, momentum) = ("method".into(), 1000, 1e-9, 0.0, None);
                let drift = Drift { problem, method, kind, steps, windows, drift, stderr, rounding, momentum };
                let check = checks(&drift).into_iter().find(|check| check.id == format!("drift/{problem}/method"));
                check.map(|check| check.outcome)
            })
        };
        let [kept, lost] = [[Outcome::Pass, Outcome::Fail], [Outcome::Fail, Outcome::Pass]].map(|all| all.map(Some));
        for (problem, ..) in SETTINGS {
            let is_chaotic = problem == CHAOTIC;
            assert_eq!(outcomes(problem, Kind::Symplectic), kept, "{problem}");
            let symmetric = if problem == "asymmetric-pendulum" { lost } else { kept };
            assert_eq!(outcomes(problem, Kind::Symmetric), if is_chaotic { [None; 2] } else { symmetric }, "{problem}");
            assert_eq!(outcomes(problem, Kind::Dissipative), if is_chaotic { [None; 2] } else { lost }, "{problem}");
        }
    }
}
