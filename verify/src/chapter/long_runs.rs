//! What the integrators keep over long runs: energy, angular momentum, reversibility.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::mechanics::{integrators, problem, text};

use super::{Context, Study, StudyError};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Series, Table};
use crate::golden::{Row, Tolerance, Truth};
use crate::measure::norm::{Extremes, distance, larger, max_norm};
use crate::method::{self, Method};
use crate::run::{run as integrate, step_from};
use crate::theory::is_symplectic;

pub(super) const STUDY: Study = Study {
    id: "long-runs",
    title: "Energy, momentum and reversibility over long runs",
    question: "Does the energy drift, are momentum maps kept, and is each method reversible?",
    source: "[KY21] Section 3, Figs 1–3, (21), (22); [HLW06] IX–XI",
    run,
};

/// A run: problem, step and number of steps.
struct Setting {
    name: &'static str,
    h: f64,
    steps: u64,
}

/// A constrained step costs as much as some ten of the others.
const SETTINGS: [Setting; 6] = [
    Setting { name: "asymmetric-pendulum", h: 0.5, steps: 100_000 },
    Setting { name: "henon-heiles", h: 0.25, steps: 100_000 },
    Setting { name: "kepler", h: 0.05, steps: 100_000 },
    Setting { name: "charged-particle", h: 0.2, steps: 20_000 },
    // With h = 0.1 the shortest times of this motion are not resolved, and degree 3 drifts by as much as can be seen.
    Setting { name: CHAOTIC, h: 0.05, steps: 50_000 },
    Setting { name: "spherical-pendulum", h: 0.1, steps: 10_000 },
];

/// Its motion from (1, 2) rad is chaotic: reversibility protects no energy there, and roundings grow exponentially.
const CHAOTIC: &str = "double-pendulum";

/// A build for development takes a fifth of the steps, which are as much slower.
const PART: u64 = if cfg!(debug_assertions) { 5 } else { 1 };

/// Windows of a run. Energy errors are averaged over each with the weight exp(−1/(s(1 − s))), 0 < s < 1: such averages
/// of a quasi-periodic function converge faster than any power of the window's length.
const WINDOWS: usize = 10;

/// A drift is one whose slope is at least this many of its standard errors: Student's t with 8 degrees of freedom is beyond
/// it with probability 10⁻⁵.
const SIGNIFICANT: f64 = 10.0;

/// Methods that are neither symplectic nor reversible, which have to fail.
const DISSIPATIVE: [&str; 3] = ["rk4", "implicit-euler", "sdirk2"];

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let mut pairs = Vec::new();
    for setting in &SETTINGS {
        let mut all = distinct()?;
        all.push(method::parse("rk4")?);
        pairs.extend(all.into_iter().map(|method| (setting, method)));
    }
    context.announce(pairs.len());
    let drifts: Vec<Drift> = pairs
        .into_par_iter()
        .map(|(setting, method)| {
            let drift = Drift::measure(setting, &*method, context.max_steps());
            context.tick();
            drift
        })
        .collect::<Result<_, StudyError>>()?;
    let mut evidence = Evidence {
        checks: drifts.iter().flat_map(Drift::checks).collect(),
        notes: vec![
            "Energy errors are averaged over ten windows with a smooth weight, under which oscillations average out, and a \
             straight line is fitted to the means. What it adds up to over the run is compared with ten of its standard \
             errors and the rounding of the steps. The symplectic integrators do not drift by more. The others do on the \
             rotating pendulum without symmetry. On Kepler's problem, Hénon and Heiles's, the charged particle and the spherical \
             pendulum they do not: these orbits are mapped to themselves by a reversal of time, which the methods share. \
             On the chaotic double pendulum there is no such protection, and no straight line to expect."
                .into(),
            "Every variational integrator here is symmetric, and so reversible to rounding; the Runge–Kutta methods in the same table \
             are not, which shows that the test can fail. Angular momentum, as every quadratic invariant, is kept by path \
             fitting on Gauss nodes, with a constraint or without; on equispaced ones of degree 3 or more it is not. In a magnetic \
             field no path-fitted integrator keeps it, and the Galerkin integrators do."
                .into(),
            "The Lagrange and Bernstein forms of path fitting, (21) and (22) for the pendulum, are one method in two \
             coordinates: their trajectories agree to accumulated rounding."
                .into(),
        ],
        ..Evidence::default()
    };
    evidence.tables.push(drift_table(&drifts));
    evidence.tables.push(window_table(&drifts));
    evidence.figures.push(drift_figure(&drifts));
    reversibility(&mut evidence)?;
    pendulum(&mut evidence, context.max_steps().min(PENDULUM_STEPS))?;
    Ok(evidence)
}

/// The integrators, without those that restate another, as Bernstein's form of path fitting does Lagrange's.
fn distinct() -> Result<Vec<Box<dyn Method>>, StudyError> {
    let mut all = integrators()?;
    all.retain(|method| method.traits().restates.is_none());
    Ok(all)
}

/// The energy errors of a run.
struct Drift {
    problem: &'static str,
    method: String,
    kind: Kind,
    steps: u64,
    /// (middle, weighted mean, largest magnitude) of each window.
    windows: Vec<(f64, f64, f64)>,
    /// What the fitted slope adds up to over the run, and its standard error.
    drift: f64,
    stderr: f64,
    /// What rounding may do to the energy and to the angular momentum.
    rounding: f64,
    /// Change of the angular momentum.
    momentum: Option<f64>,
}

/// What a method conserves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Symplectic,
    Symmetric,
    Dissipative,
}

impl Drift {
    fn measure(setting: &Setting, method: &dyn Method, max_steps: u64) -> Result<Self, StudyError> {
        let problem = problem(setting.name, &[])?;
        let name = method.name();
        let symplectic = is_symplectic(&*problem, method).ok_or("the problem has no Lagrangian of mechanics")?;
        let kind = match (symplectic, method.traits().is_reversible) {
            (true, _) => Kind::Symplectic,
            (false, true) => Kind::Symmetric,
            (false, false) => Kind::Dissipative,
        };
        // What dissipates leaves the straight line before long.
        let steps = (setting.steps / PART).min(max_steps) / if kind == Kind::Dissipative { 10 } else { 1 };
        let invariants = problem.invariants();
        let energy = invariants.iter().find(|i| i.name == "energy").ok_or("the problem has no energy")?;
        let angular = invariants.iter().find(|i| i.name == "angular momentum");
        let start = problem.initial();
        let length = steps as f64 / WINDOWS as f64;
        let (mut sums, mut change) = (vec![(0.0, 0.0_f64, 0.0); WINDOWS], 0.0_f64);
        let (mut q, mut p, mut step) = (0.0_f64, 0.0_f64, 0.0_f64);
        integrate(&*problem, method, setting.h, setting.h * steps as f64, |state| {
            let error = energy.value(&state.q) - energy.value(&start);
            let place = (step + 0.5) / length;
            if let Some((sum, largest, weights)) = sums.get_mut(place as usize) {
                let weight = (-1.0 / (place.fract() * (1.0 - place.fract()))).exp();
                *sum += weight * error;
                *weights += weight;
                *largest = larger(*largest, error.abs());
            }
            let (place, momentum) = state.q.split_at(start.len() / 2);
            (q, p, step) = (larger(q, max_norm(place)), larger(p, max_norm(momentum)), step + 1.0);
            change = angular.map_or(0.0, |l| larger(change, (l.value(&state.q) - l.value(&start)).abs()));
        })?;
        let middle = |i: usize| (i as f64 + 0.5) * length * setting.h;
        let windows: Vec<_> = sums.iter().enumerate().map(|(i, (sum, most, w))| (middle(i), sum / w, *most)).collect();
        let (slope, stderr) = line(&windows);
        // Each step rounds q, and so p by Λ ε |q|/h, at random: four standard deviations of the sum. The coefficients of the
        // method are rounded too, which changes p by up to Λ ε |p| in the same way in every step.
        let random = 4.0 * (steps as f64).sqrt() * q / setting.h;
        let rounding = f64::EPSILON * (1.0 + method.momentum_roundoff(1.0)) * p * (random + steps as f64 * p);
        let horizon = setting.h * steps as f64;
        Ok(Self {
            problem: setting.name,
            method: name,
            kind,
            steps,
            windows,
            drift: (slope * horizon).abs(),
            stderr: stderr * horizon,
            rounding,
            momentum: angular.map(|_| change),
        })
    }

    /// The least drift that is one.
    fn resolved(&self) -> f64 {
        SIGNIFICANT * self.stderr + self.rounding
    }

    fn checks(&self) -> Vec<Check> {
        let Self { problem, method, kind, .. } = self;
        let mut checks = Vec::new();
        let id = format!("drift/{problem}/{method}");
        let reason = "ten standard errors, and the rounding of the steps";
        // Nor does what dissipates drift along a line in chaos: by episodes.
        let drifts = (*kind == Kind::Dissipative && *problem != CHAOTIC)
            || (*kind == Kind::Symmetric && *problem == "asymmetric-pendulum");
        if drifts {
            let statement = format!("The energy of {method} drifts on {problem} over {} steps", self.steps);
            checks.push(Check::at_least(id, statement, self.drift, self.resolved(), reason));
        } else if *kind == Kind::Symplectic || *problem != CHAOTIC {
            let statement = format!("The energy of {method} does not drift on {problem} over {} steps", self.steps);
            checks.push(Check::at_most(id, statement, self.drift, self.resolved(), reason));
        }
        if let Some(change) = self.momentum {
            let (id, l) = (format!("momentum/{problem}/{method}"), "angular momentum");
            checks.push(if *kind == Kind::Symplectic {
                let statement = format!("{method} keeps the {l} of {problem}");
                Check::at_most(id, statement, change, self.rounding, "the rounding of the steps")
            } else {
                let statement = format!("{method} does not keep the {l} of {problem}");
                Check::at_least(id, statement, change, 10.0 * self.rounding, "ten times the rounding")
            });
        }
        checks
    }
}

/// Slope and its standard error of the least-squares line through the means of the windows.
fn line(windows: &[(f64, f64, f64)]) -> (f64, f64) {
    let n = windows.len() as f64;
    let x = windows.iter().map(|w| w.0).sum::<f64>() / n;
    let y = windows.iter().map(|w| w.1).sum::<f64>() / n;
    let sxx: f64 = windows.iter().map(|w| (w.0 - x).powi(2)).sum();
    let slope = windows.iter().map(|w| (w.0 - x) * (w.1 - y)).sum::<f64>() / sxx;
    let residual: f64 = windows.iter().map(|w| (w.1 - y - slope * (w.0 - x)).powi(2)).sum();
    (slope, (residual / (n - 2.0) / sxx).sqrt())
}

fn drift_table(drifts: &[Drift]) -> crate::evidence::Table {
    let rows = drifts.iter().map(|d| {
        let largest = d.windows.iter().map(|w| w.2).largest();
        let mut row = vec![text(d.problem), text(d.method.as_str()), Cell::Integer(d.steps as i64)];
        row.extend([largest, d.drift, d.stderr, d.drift / d.stderr, d.rounding].map(Cell::Number));
        row.push(d.momentum.map_or(Cell::Empty, Cell::Number));
        row
    });
    Table::new(
        "drift",
        "Energy error over a run: its largest value, what the slope of the fitted line adds up to with its standard error and \
         significance, and what rounding may add; and the change of the angular momentum.",
        &["problem", "method", "steps", "largest", "drift", "stderr", "significance", "rounding", "momentum"],
        rows.collect(),
    )
}

fn window_table(drifts: &[Drift]) -> crate::evidence::Table {
    let rows = drifts.iter().flat_map(|d| {
        d.windows.iter().map(|(t, mean, largest)| {
            let numbers = [*t, *mean, *largest].map(Cell::Number);
            [text(d.problem), text(d.method.as_str())].into_iter().chain(numbers).collect()
        })
    });
    let columns = ["problem", "method", "t", "mean", "largest"];
    Table::data("drift-windows", "Weighted mean and largest energy error in each window.", &columns, rows.collect())
}

fn drift_figure(drifts: &[Drift]) -> Figure {
    let panels = SETTINGS.iter().map(|setting| Panel {
        title: setting.name.into(),
        x: Axis { label: "t".into(), ..Axis::default() },
        y: Axis { label: "largest energy error".into(), log: true, limits: None },
        series: drifts
            .iter()
            .filter(|d| d.problem == setting.name)
            .map(|d| Series {
                label: d.method.clone(),
                points: d.windows.iter().map(|w| (w.0, w.2)).collect(),
                mark: Mark::Line,
            })
            .collect(),
        field: None,
    });
    Figure {
        id: "drift".into(),
        caption: "Largest energy error in each window of time: level where it stays bounded, rising where it drifts."
            .into(),
        data: "drift-windows".into(),
        panels: panels.collect(),
        columns: 2,
    }
}

/// ρ Φ ρ Φ = id, where ρ turns the momentum round.
fn reversibility(evidence: &mut Evidence) -> Result<(), StudyError> {
    let turn = |state: &mut [f64]| {
        let n = state.len() / 2;
        state[n..].iter_mut().for_each(|p| *p = -*p);
    };
    let h = 0.25;
    let mut rows = Vec::new();
    for name in ["henon-heiles", "double-pendulum", "circle", "spherical-pendulum"] {
        let problem = problem(name, &[])?;
        let mut all = integrators()?;
        for name in DISSIPATIVE {
            all.push(method::parse(name)?);
        }
        for method in all {
            let label = method.name();
            let mut state = step_from(&*problem, problem.initial(), &*method, h)?;
            turn(&mut state);
            let mut back = step_from(&*problem, state, &*method, h)?;
            turn(&mut back);
            let defect = distance(&back, &problem.initial());
            // Two steps, each with roundings of a state of order 1 magnified by Λ/h in the momentum.
            let rounding = 16.0 * f64::EPSILON * (1.0 + method.momentum_roundoff(1.0)) / h;
            let id = format!("reversible/{name}/{label}");
            evidence.checks.push(if !method.traits().is_reversible {
                let statement = format!("{label} is not reversible on {name}");
                Check::at_least(id, statement, defect, 1e3 * rounding, "a thousand roundings")
            } else {
                Check::at_most(
                    id,
                    format!("{label} is reversible on {name}"),
                    defect,
                    rounding,
                    "rounding of two steps",
                )
            });
            rows.push(vec![text(name), text(label), Cell::Number(h), Cell::Number(defect), Cell::Number(rounding)]);
        }
    }
    let caption =
        "Distance from where it started after a step, a reversal of the momentum, another step and another reversal.";
    let columns = ["problem", "method", "h", "defect", "rounding"];
    evidence.tables.push(Table::new("reversibility", caption, &columns, rows));
    Ok(())
}

/// Steps of the runs on the pendulum.
const PENDULUM_STEPS: u64 = 100_000;

/// (q₀, p₀) of their orbits: two librations and a rotation.
const STARTS: [(&str, &str); 3] = [("1", "0"), ("2", "0"), ("-3", "1")];

/// Of these runs, one state in so many is drawn.
const DRAWN: usize = 997;

/// The pendulum of [KY21]: (21) against (22), portraits and energies over many steps.
fn pendulum(evidence: &mut Evidence, steps: u64) -> Result<(), StudyError> {
    let tau = 0.1;
    let libration = problem("pendulum", &[])?;
    for degree in [3, 4] {
        let (one, other) = (format!("path-fitted({degree})"), format!("path-fitted-bernstein({degree})"));
        let mut states = Vec::new();
        integrate(&*libration, &*method::parse(&one)?, tau, 1000.0 * tau, |state| states.push(state.q.clone()))?;
        let mut differences = Differences::from(states);
        let bernstein = method::parse(&other)?;
        integrate(&*libration, &*bernstein, tau, 1000.0 * tau, |state| differences.compare(&state.q))?;
        evidence.checks.push(differences.check(degree, 1000)?);
    }

    // Solutions, portraits and energies, as Figs 1–3 of the paper.
    let schemes = [("(21)", method::parse("path-fitted(2)")?), ("(22)", method::parse("path-fitted-bernstein(2)")?)];
    let (mut solution, mut exact) = (Vec::new(), Vec::new());
    integrate(&*libration, &*schemes[0].1, tau, 30.0, |state| {
        solution.push((state.t, state.q[0]));
        exact.extend(libration.exact(state.t).map(|q| (state.t, q[0])));
    })?;
    let (parts, horizon) = (100_usize, steps as f64 * tau);
    let middle = |i: usize| (i as f64 + 0.5) * horizon / parts as f64;
    let most = |part: &[f64]| part.iter().copied().largest();
    let (mut rows, mut portraits) = (Vec::new(), Vec::new());
    let (mut curves, mut energies, mut highest) = (Vec::new(), Vec::new(), 0.0_f64);
    let mut differences = Differences::default();
    for (scheme, method) in &schemes {
        let mut portrait = Vec::new();
        for (q0, p0) in STARTS {
            let orbit = problem("pendulum", &[("q0", q0), ("p0", p0)])?;
            let invariants = orbit.invariants();
            let energy = invariants.first().ok_or("the pendulum has no energy")?;
            let start = energy.value(&orbit.initial());
            let (mut points, mut largest, mut step) = (Vec::new(), vec![0.0_f64; parts], 0_usize);
            integrate(&*orbit, &**method, tau, horizon, |state| {
                let part = ((state.t / horizon * parts as f64) as usize).min(parts - 1);
                largest[part] = larger(largest[part], (energy.value(&state.q) - start).abs());
                if step.is_multiple_of(DRAWN) {
                    // A rotation is drawn in one turn.
                    let angle = state.q[0] - TAU * (state.q[0] / TAU).round();
                    points.push((angle, state.q[1]));
                    let orbit = format!("q₀ = {q0}, p₀ = {p0}");
                    let numbers = [state.t, angle, state.q[1]].map(Cell::Number);
                    rows.push([text(*scheme), text(orbit)].into_iter().chain(numbers).collect());
                }
                step += 1;
                match *scheme {
                    "(21)" if q0 == "2" => differences.states.push(state.q.clone()),
                    _ if q0 == "2" => differences.compare(&state.q),
                    _ => (),
                }
            })?;
            evidence.checks.push(Check::at_most(
                format!("pendulum/energy-{scheme}-{q0}-{p0}"),
                format!(
                    "The energy error of {scheme} from ({q0}, {p0}) over the last tenth of {steps} steps is that over the first"
                ),
                most(&largest[parts - parts / 10..]) / most(&largest[..parts / 10]),
                1.01,
                "a bounded error has the same maximum; at a thousand phases of the motion or more it is met to (2π/1000)²",
            ));
            portrait.push(Series { label: format!("from ({q0}, {p0})"), points, mark: Mark::Markers });
            if p0 == "0" {
                highest = larger(highest, most(&largest));
                let label = format!("{scheme} from {q0} rad");
                energies.extend(
                    largest
                        .iter()
                        .enumerate()
                        .map(|(i, e)| vec![text(label.as_str()), Cell::Number(middle(i)), Cell::Number(*e)]),
                );
                let points = largest.iter().enumerate().map(|(i, e)| (middle(i), *e)).collect();
                curves.push(Series { label, points, mark: Mark::Line });
            }
        }
        portrait.extend(level_curves()?);
        portraits.push(portrait);
    }
    evidence.checks.push(differences.check(2, steps)?);
    let caption = format!("One in {DRAWN} states of orbits of the pendulum over {steps} steps.");
    evidence.tables.push(Table::data("pendulum-orbits", caption, &["scheme", "orbit", "t", "q", "p"], rows));
    let caption = format!("Largest energy error on the pendulum in each hundredth of {steps} steps.");
    evidence.tables.push(Table::data("pendulum-energy", caption, &["scheme", "t", "largest"], energies));
    let plain = |label: &str| Axis { label: label.into(), ..Axis::default() };
    let panel =
        |title: &str, x: &str, y: Axis, series| Panel { title: title.into(), x: plain(x), y, series, field: None };
    let from_zero = Axis { limits: Some((0.0, 1.5 * highest)), ..plain("largest energy error") };
    let curve = |label: &str, points, mark| Series { label: label.into(), points, mark };
    let mut panels = vec![
        panel(
            "Solution",
            "t",
            plain("q"),
            vec![curve("(21)", solution, Mark::Line), curve("exact", exact, Mark::Guide)],
        ),
        panel("Energy", "t", from_zero, curves),
    ];
    for ((scheme, _), portrait) in schemes.iter().zip(portraits) {
        panels.push(panel(&format!("Phase portrait, {scheme}"), "q", plain("p"), portrait));
    }
    evidence.figures.push(Figure {
        id: "pendulum".into(),
        caption: format!(
            "The pendulum by path fitting of degree 2 in its two forms (21) and (22), τ = {tau}: the solution, the energy error \
             over {steps} steps, and one in {DRAWN} states of as long runs on the exact orbits (Fig. 3 of [KY21])."
        ),
        data: "pendulum-orbits".into(),
        panels,
        columns: 2,
    });
    Ok(())
}

/// The states of one trajectory, and the largest distance of those of another.
#[derive(Default)]
struct Differences {
    states: Vec<Vec<f64>>,
    compared: usize,
    largest: f64,
}

impl Differences {
    fn from(states: Vec<Vec<f64>>) -> Self {
        Self { states, ..Self::default() }
    }

    fn compare(&mut self, state: &[f64]) {
        let other = self.states.get(self.compared);
        self.largest = larger(self.largest, other.map_or(f64::INFINITY, |other| distance(state, other)));
        self.compared += 1;
    }

    /// Lagrange's and Bernstein's form are one method, on the pendulum from 2 rad.
    fn check(&self, degree: usize, steps: u64) -> Result<Check, StudyError> {
        let mut roundoff = 0.0;
        for form in ["path-fitted", "path-fitted-bernstein"] {
            roundoff += method::parse(&format!("{form}({degree})"))?.momentum_roundoff(steps as f64);
        }
        let complete = self.compared == self.states.len() && self.compared as u64 == steps + 1;
        Ok(Check::at_most(
            format!("pendulum/bernstein-{degree}"),
            format!(
                "Path fitting of degree {degree} is the same in Lagrange's and in Bernstein's form over {steps} steps"
            ),
            if complete { self.largest } else { f64::NAN },
            f64::EPSILON * roundoff * 2.0,
            "independent roundings of q ≤ 2 in each step, four deviations of what they add up to",
        ))
    }
}

/// The exact orbits p = ± √(2 (E + cos q)).
fn level_curves() -> Result<Vec<Series>, StudyError> {
    let mut curves = Vec::new();
    for (q0, p0) in STARTS {
        let (q0, p0): (f64, f64) = (q0.parse()?, p0.parse()?);
        let energy = 0.5 * p0 * p0 - q0.cos();
        // Between the turning points, or all round.
        let reach = if energy < 1.0 { (-energy).acos() } else { 0.5 * TAU };
        let half = |sign: f64| {
            let angle = move |i: i32| reach * (f64::from(i) / 100.0 * 0.25 * TAU).sin();
            (-100..=100).map(angle).map(|q| (q, sign * (2.0 * (energy + q.cos())).max(0.0).sqrt())).collect::<Vec<_>>()
        };
        let points =
            if energy < 1.0 { [half(1.0), half(-1.0).into_iter().rev().collect()].concat() } else { half(p0.signum()) };
        curves.push(Series { label: "exact".into(), points, mark: Mark::Guide });
    }
    Ok(curves)
}

/// Rows of the golden `long-runs`: the largest energy errors in 1000 steps, and the change of angular momenta.
pub(crate) fn golden(_: &Context) -> Result<Vec<Row>, StudyError> {
    let mut rows = Vec::new();
    for setting in SETTINGS.iter().filter(|setting| setting.name != CHAOTIC) {
        for method in distinct()? {
            let drift = Drift::measure(setting, &*method, 1000)?;
            let key = |what: &str| format!("{} {} {what}", drift.problem, drift.method);
            let tolerance = || Tolerance::absolute(drift.rounding, "the rounding of the steps");
            let largest = drift.windows.iter().map(|w| w.2).largest();
            rows.push(Row::number(key("energy error"), largest, tolerance()));
            let Some(change) = drift.momentum else { continue };
            let row = Row::number(key("change of the angular momentum"), change, tolerance());
            rows.push(if drift.kind == Kind::Symplectic {
                row.with_truth(Truth { value: 0.0, allowance: drift.rounding, source: "Noether's theorem".into() })
            } else {
                row
            });
        }
    }
    Ok(rows)
}
