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
use crate::experiment::sensitivity::{Parting, Sensitivity};
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
    ("double-pendulum", 0.05, 50_000),
    ("spherical-pendulum", 0.1, 10_000),
];

/// The method whose runs tell how neighbouring motions part: it steps all of these problems, and is symplectic.
const TELLING: &str = "midpoint-vi";

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
    let partings = partings(context)?;
    let said: Vec<(&Drift, Said)> = drifts.iter().map(|drift| (&**drift, Said::of(drift, &partings))).collect();
    // What drifts the least beside what would be resolved.
    let rk4 = said.iter().filter(|(drift, said)| drift.method == "rk4" && *said == Said::Drifts);
    let rk4 = rk4.map(|(drift, _)| (drift.drift / drift.resolved(), drift.problem));
    let (least, on) = rk4.min_by(|a, b| a.0.total_cmp(&b.0)).ok_or("RK4 drifts on some of these problems")?;
    let lost: Vec<_> = partings.iter().filter(|(_, parting)| parting.lost().is_some()).collect();
    let kept = partings.iter().filter(|(_, parting)| parting.lost().is_none()).map(|(_, parting)| parting.growth);
    let names: Vec<_> = lost.iter().map(|(problem, _)| format!("`{problem}`")).collect();
    let dropped = said.iter().filter(|(_, said)| matches!(said, Said::Nothing(_))).count();
    let values = [
        ("least", digits(least, 3)),
        ("least_on", format!("`{on}`")),
        ("lost", if names.is_empty() { "none".into() } else { names.join(", ") }),
        ("kept", digits(kept.largest().exp(), 2)),
        ("telling", format!("`{TELLING}`")),
        ("dropped", dropped.to_string()),
        ("drifts", said.len().to_string()),
    ];
    let mut evidence = Evidence {
        checks: said.iter().flat_map(|(drift, said)| checks(drift, said)).collect(),
        notes: prose::fill(include_str!("long_runs.md"), &values)?,
        ..Evidence::default()
    };
    evidence.tables.push(drift_table(&drifts));
    evidence.tables.push(parting_table(&partings));
    evidence.tables.extend(dropped_table(&said));
    let windows = window_table(&drifts);
    evidence.figures.push(drift_figure(&windows));
    evidence.tables.push(windows);
    reversibility(&mut evidence, context)?;
    pendulum(&mut evidence, context, most.min(PENDULUM_STEPS))?;
    Ok(evidence)
}

/// How neighbouring motions part on each problem, over the time of its runs.
fn partings(context: &Context) -> Result<Vec<(&'static str, Parting)>, StudyError> {
    let of = |(problem, h, steps): (&'static str, f64, u64)| {
        let steps = (steps / PART).min(context.max_steps());
        Sensitivity { problem, method: TELLING, h, steps }
    };
    let found = context.get_each(SETTINGS.map(of).into())?;
    Ok(SETTINGS.iter().zip(found).map(|((problem, ..), parting)| (*problem, *parting)).collect())
}

/// What is said of the energy over a run.
#[derive(Debug, PartialEq)]
enum Said {
    Drifts,
    Keeps,
    /// For this reason.
    Nothing(String),
}

impl Said {
    fn of(drift: &Drift, partings: &[(&'static str, Parting)]) -> Self {
        let Drift { problem, kind, .. } = drift;
        let parting = partings.iter().find(|(name, _)| name == problem).map(|(_, parting)| parting);
        match (kind, parting.and_then(|parting| Some((parting.rate(), parting.lost()?)))) {
            (Kind::Symmetric | Kind::Dissipative, Some((rate, lost))) => {
                let why = match kind {
                    Kind::Symmetric => {
                        "it follows no orbit that a reversal of time maps to itself, which would protect the energy"
                    }
                    _ => "the energy falls by episodes, along no line",
                };
                let [rate, lost] = [rate, lost].map(|x| digits(x, 2));
                Self::Nothing(format!(
                    "neighbouring motions part at the rate {rate}, and by t = {lost} a rounding has grown to the size of the motion: {why}"
                ))
            }
            (Kind::Dissipative, None) => Self::Drifts,
            (Kind::Symmetric, None) if *problem == "asymmetric-pendulum" => Self::Drifts,
            _ if drift.resolved() >= drift.largest() => {
                let [resolved, largest] = [drift.resolved(), drift.largest()].map(|error| digits(error, 2));
                Self::Nothing(format!("a drift shows from {resolved} on, and the largest energy error is {largest}"))
            }
            _ => Self::Keeps,
        }
    }
}

/// The integrators for a problem, without those that restate another, as Bernstein's form of path fitting does Lagrange's.
fn distinct(problem: &str) -> Result<Vec<String>, NameError> {
    let mut names = integrators_for(problem)?;
    names.retain(|name| method::parse(name).is_ok_and(|method| method.traits().restates.is_none()));
    Ok(names)
}

/// Runs of a thousand steps of the [`distinct`] integrators where roundings do not decide where a long run goes.
pub(crate) fn short_runs(context: &Context) -> Result<Vec<EnergyDrift>, StudyError> {
    let mut runs = Vec::new();
    for ((problem, h, _), (_, parting)) in SETTINGS.into_iter().zip(partings(context)?) {
        if parting.lost().is_none() {
            runs.extend(distinct(problem)?.into_iter().map(|method| EnergyDrift { problem, method, h, steps: 1000 }));
        }
    }
    Ok(runs)
}

fn checks(drift: &Drift, said: &Said) -> Vec<Check> {
    let Drift { problem, method, kind, steps, .. } = drift;
    let mut checks = Vec::new();
    let id = format!("drift/{problem}/{method}");
    let reason = "ten standard errors, and the rounding of the steps";
    match said {
        Said::Drifts => {
            let statement = format!("The energy of {method} drifts on {problem} over {steps} steps");
            checks.push(Check::at_least(id, statement, drift.drift, drift.resolved(), reason));
        }
        Said::Keeps => {
            let statement = format!("The energy of {method} does not drift on {problem} over {steps} steps");
            checks.push(Check::at_most(id, statement, drift.drift, drift.resolved(), reason));
        }
        Said::Nothing(_) => {}
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

fn parting_table(partings: &[(&'static str, Parting)]) -> Table {
    let rows = partings.iter().map(|(problem, parting)| {
        row![*problem, parting.time, parting.growth / std::f64::consts::LN_10, parting.rate(), parting.lost()]
    });
    let caption = format!(
        "How two neighbouring runs of {TELLING} part: in which time, by which power of ten, at which rate; and when a rounding has grown to the \
         size of the motion, by {} powers of ten, where it does.",
        digits(Parting::of_roundings() / std::f64::consts::LN_10, 3)
    );
    Table::new("sensitivity", caption, ["problem", "time", "log10_growth", "rate", "lost"], rows.collect())
}

/// Runs of whose drift nothing is said, if there are any.
fn dropped_table(said: &[(&Drift, Said)]) -> Option<Table> {
    let rows: Vec<_> = said
        .iter()
        .filter_map(|(drift, said)| match said {
            Said::Nothing(reason) => Some(row![drift.problem, &drift.method, reason]),
            _ => None,
        })
        .collect();
    let caption = "Runs of whose drift nothing is said, and why.";
    (!rows.is_empty()).then(|| Table::new("drift-dropped", caption, ["problem", "method", "reason"], rows))
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
            let (drift, stderr, rounding) = (0.0, 1e-9, 1e-12);
            let drift = Drift { problem, method, kind, steps, windows, drift, stderr, rounding, momentum };
            let checks = checks(&drift, &Said::Keeps);
            checks.into_iter().find(|check| check.id.starts_with("momentum/")).expect("it has one").outcome
        };
        let (pass, fail) = (Outcome::Pass, Outcome::Fail);
        assert_eq!([0.9e-12, 1.1e-12, f64::NAN].map(|change| outcome(Kind::Symplectic, change)), [pass, fail, fail]);
        assert_eq!([1.1e-11, 0.9e-11, f64::NAN].map(|change| outcome(Kind::Dissipative, change)), [pass, fail, fail]);
    }

    fn drifting(problem: &'static str, kind: Kind, drift: f64) -> Drift {
        let windows = vec![Window { t: 1.0, mean: 0.0, largest: 1e-3 }];
        let (method, steps, stderr, rounding, momentum) = ("method".into(), 1000, 1e-9, 0.0, None);
        Drift { problem, method, kind, steps, windows, drift, stderr, rounding, momentum }
    }

    /// Where roundings do not grow to the size of the motion, and where they do of what is symplectic alone.
    #[test]
    fn the_drift_is_checked_on_every_problem() {
        let outcomes = |problem: &'static str, kind: Kind, growth: f64| {
            [0.9e-8, 1.1e-8].map(|size| {
                let drift = drifting(problem, kind, size);
                let said = Said::of(&drift, &[(problem, Parting { growth, time: 20.0 })]);
                let check =
                    checks(&drift, &said).into_iter().find(|check| check.id == format!("drift/{problem}/method"));
                check.map(|check| check.outcome)
            })
        };
        let [kept, lost] = [[Outcome::Pass, Outcome::Fail], [Outcome::Fail, Outcome::Pass]].map(|all| all.map(Some));
        for (problem, ..) in SETTINGS {
            for (growth, is_lost) in [(36.0, false), (36.1, true)] {
                let of = |kind| outcomes(problem, kind, growth);
                assert_eq!(of(Kind::Symplectic), kept, "{problem}");
                let symmetric = if problem == "asymmetric-pendulum" { lost } else { kept };
                assert_eq!(of(Kind::Symmetric), if is_lost { [None; 2] } else { symmetric }, "{problem}");
                assert_eq!(of(Kind::Dissipative), if is_lost { [None; 2] } else { lost }, "{problem}");
            }
        }
    }

    /// A build for development runs a fifth of them.
    #[test]
    fn rk4_drifts_over_the_whole_runs_wherever_that_is_said() {
        let context = Context::silent();
        for (problem, h, steps) in SETTINGS {
            let parting = *context.get(Sensitivity { problem, method: TELLING, h, steps }).expect("registered");
            let run = EnergyDrift { problem, method: "rk4".into(), h, steps };
            let drift = context.get(run).expect("registered");
            let said = Said::of(&drift, &[(problem, parting)]);
            let outcomes: Vec<_> = checks(&drift, &said).into_iter().map(|check| check.outcome).collect();
            assert!(outcomes.iter().all(|outcome| *outcome == Outcome::Pass), "{problem}: {said:?}, {drift:?}");
            assert_eq!(said == Said::Drifts, parting.lost().is_none(), "{problem}: {said:?}, {parting:?}");
        }
    }

    #[test]
    fn what_nothing_is_said_of_is_listed_with_the_reason() {
        let lost = [("kepler", Parting { growth: 40.0, time: 20.0 })];
        let said = |drift: &Drift, partings: &[(&'static str, Parting)]| {
            dropped_table(&[(drift, Said::of(drift, partings))]).map(|table| table.rows[0][2].to_string())
        };
        let symmetric = drifting("kepler", Kind::Symmetric, 0.0);
        assert!(said(&symmetric, &lost).is_some_and(|text| text.contains("at the rate 2, and by t = 20 a rounding")));
        let blurred = Drift { stderr: 1e-4, ..drifting("kepler", Kind::Symplectic, 0.0) };
        assert!(said(&blurred, &lost).is_some_and(|text| text.starts_with("a drift shows from 0.001 on")));
        // What is not a number is put to the test, and fails.
        let unknown = Drift { stderr: f64::NAN, ..drifting("kepler", Kind::Symplectic, 0.0) };
        assert_eq!(said(&unknown, &lost), None);
        assert_eq!(checks(&unknown, &Said::of(&unknown, &lost))[0].outcome, Outcome::Fail);
    }
}
