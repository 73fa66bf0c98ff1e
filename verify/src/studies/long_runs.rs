//! What the integrators keep over long runs: energy, angular momentum, reversibility.

use std::f64::consts::TAU;

use lsvi::{State, Trajectory};
use rayon::prelude::*;

use super::mechanics::{integrators, problem, text};
use super::parts::{data, table};
use super::symplecticity::{Kind, is_symplectic};
use super::{Context, Study, StudyError};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Series};
use crate::methods::{self, Method};
use crate::problems::Problem;
use crate::run::{distance, run as integrate};

pub(super) const STUDY: Study = Study {
    id: "long-runs",
    title: "Energy, momentum and reversibility over long runs",
    question: "Does the energy drift, are momentum maps kept, and is each method reversible?",
    source: "[KY21] Section 3, Figs 1–3, (21), (22); [HLW06] IX–XI",
    run,
};

/// A run: problem, step, number of windows over which errors are averaged, and their length.
struct Setting {
    name: &'static str,
    h: f64,
    windows: usize,
    window: f64,
}

const SETTINGS: [Setting; 3] = [
    Setting { name: "asymmetric-pendulum", h: 0.5, windows: 30, window: 50.0 },
    Setting { name: "henon-heiles", h: 0.25, windows: 20, window: 12.5 },
    Setting { name: "kepler", h: TAU / 128.0, windows: 10, window: TAU },
];

/// A drift is one whose slope is at least this many of its standard errors.
const SIGNIFICANT: f64 = 5.0;

/// Methods that are neither symplectic nor reversible, which have to fail.
const DISSIPATIVE: [&str; 3] = ["rk4", "implicit-euler", "sdirk2"];

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let mut pairs = Vec::new();
    for setting in &SETTINGS {
        let mut all = integrators()?;
        all.push(methods::parse("rk4")?);
        pairs.extend(all.into_iter().map(|method| (setting, method)));
    }
    (context.announce)(pairs.len() as u64);
    let drifts: Vec<Drift> = pairs
        .into_par_iter()
        .map(|(setting, method)| {
            let drift = Drift::measure(setting, &*method);
            (context.tick)();
            drift
        })
        .collect::<Result<_, StudyError>>()?;
    let mut evidence = Evidence {
        checks: drifts.iter().flat_map(Drift::checks).collect(),
        notes: vec![
            "Energy errors are averaged over windows of equal length, periods for Kepler's problem, and a straight line is \
             fitted to the means. Its slope is significant from five of its standard errors on. With the symplectic integrators \
             it is not, or adds up over the run to next to nothing of the oscillation. The reversibility of the problem protects \
             the other path-fitted ones on Kepler's problem and on Hénon and Heiles's. On the rotating pendulum without \
             symmetry it does not, and there their energy drifts, by so little that it takes steps as large as 0.5 to see it."
                .into(),
            "Every variational integrator here is symmetric, and so reversible to rounding; the Runge–Kutta methods in the same table \
             are not, which shows that the test can fail. Angular momentum, as every quadratic invariant, is kept by path \
             fitting on Gauss nodes, but on equispaced ones of degree 3 or more it is not."
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
    pendulum(&mut evidence)?;
    Ok(evidence)
}

/// The energy errors of a run.
struct Drift {
    problem: &'static str,
    method: String,
    symplectic: bool,
    /// (middle, mean, largest magnitude) of each window.
    windows: Vec<(f64, f64, f64)>,
    slope: f64,
    stderr: f64,
    /// Slope times length of the run, over the range of the energy errors.
    relative: f64,
    /// Change of the angular momentum, and its rounding.
    momentum: Option<(f64, f64)>,
}

impl Drift {
    fn measure(setting: &Setting, method: &dyn Method) -> Result<Self, StudyError> {
        let problem = problem(setting.name, &[])?;
        let invariants = problem.invariants();
        let energy = invariants.iter().find(|i| i.name == "energy").ok_or("the problem has no energy")?;
        let angular = invariants.iter().find(|i| i.name == "angular momentum");
        let start = problem.initial();
        let (mut sums, mut change) = (vec![(0.0, 0.0_f64, 0.0); setting.windows], 0.0_f64);
        let (mut low, mut high, mut steps) = (0.0_f64, 0.0_f64, 0.0_f64);
        let horizon = setting.windows as f64 * setting.window;
        integrate(&*problem, method, setting.h, horizon, |state| {
            if state.t == 0.0 {
                return;
            }
            let error = energy.value(&state.q) - energy.value(&start);
            // A state at the end of a window belongs to it.
            let index = ((state.t / setting.window * (1.0 - 1e-9)) as usize).min(setting.windows - 1);
            let (sum, largest, count) = &mut sums[index];
            *sum += error;
            *largest = largest.max(error.abs());
            *count += 1.0;
            (low, high, steps) = (low.min(error), high.max(error), steps + 1.0);
            change = angular.map_or(0.0, |l| change.max((l.value(&state.q) - l.value(&start)).abs()));
        })?;
        let middle = |i: usize| (i as f64 + 0.5) * setting.window;
        let windows: Vec<_> = sums.iter().enumerate().map(|(i, (sum, most, n))| (middle(i), sum / n, *most)).collect();
        let (slope, stderr) = line(&windows);
        // Each step rounds p by Λ ε/h; the roundings are independent, and the bound four standard deviations of their sum.
        let slopes = 1.0 + method.momentum_roundoff(1.0);
        let rounding = 4.0 * steps.sqrt() * slopes * f64::EPSILON / setting.h;
        Ok(Self {
            problem: setting.name,
            symplectic: is_symplectic(&method.name(), Kind::Separable) && method.name() != "rk4",
            method: method.name(),
            windows,
            slope,
            stderr,
            relative: (slope * horizon / (high - low)).abs(),
            momentum: angular.map(|_| (change, rounding)),
        })
    }

    fn significance(&self) -> f64 {
        (self.slope / self.stderr).abs()
    }

    fn checks(&self) -> Vec<Check> {
        let Self { problem, method, .. } = self;
        let mut checks = Vec::new();
        let significance = self.significance();
        if self.symplectic {
            let drifting = if significance < SIGNIFICANT { 0.0 } else { self.relative };
            checks.push(Check::at_most(
                format!("drift/{problem}/{method}"),
                format!("The energy of {method} does not drift on {problem}"),
                drifting,
                0.05,
                "drift over the run in units of the oscillation, 0 where it is not significant; an irregular phase of the \
                 last oscillations leaves some of it",
            ));
        } else if *problem == "asymmetric-pendulum" || method == "rk4" {
            checks.push(Check::within(
                format!("drift/{problem}/{method}"),
                format!("The energy of {method} drifts on {problem}"),
                significance,
                [SIGNIFICANT, f64::INFINITY],
                "slope over its standard error",
            ));
        }
        if let Some((change, rounding)) = self.momentum {
            let (id, l) = (format!("momentum/{problem}/{method}"), "angular momentum");
            checks.push(if self.symplectic {
                let statement = format!("{method} keeps the {l} of {problem}");
                Check::at_most(
                    id,
                    statement,
                    change,
                    rounding,
                    "independent roundings of the momentum, four deviations",
                )
            } else {
                let statement = format!("{method} does not keep the {l} of {problem}");
                Check::within(id, statement, change, [10.0 * rounding, f64::INFINITY], "ten times the rounding")
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
        let (change, rounding) =
            d.momentum.map_or((Cell::Empty, Cell::Empty), |m| (Cell::Number(m.0), Cell::Number(m.1)));
        let largest = d.windows.iter().map(|w| w.2).fold(0.0, f64::max);
        let numbers = [largest, d.slope, d.stderr, d.significance(), d.relative].map(Cell::Number);
        let mut row = vec![text(d.problem), text(d.method.as_str())];
        row.extend(numbers);
        row.extend([change, rounding]);
        row
    });
    table(
        "drift",
        "Energy error over a run: its largest value, the slope of the fitted line with its standard error and significance, what \
         the slope adds up to in units of the oscillation; and the change of the angular momentum with its rounding.",
        &["problem", "method", "largest", "slope", "stderr", "significance", "relative", "momentum", "rounding"],
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
    data("drift-windows", "Mean and largest energy error in each window.", &columns, rows.collect())
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

/// One step of size `h` from `state`.
fn step(problem: &dyn Problem, method: &dyn Method, h: f64, state: Vec<f64>) -> Result<Vec<f64>, StudyError> {
    Ok(Trajectory::new(method.build(problem)?, State::new(0.0, state), h, h)?.observe(|_| ())?.q)
}

/// ρ Φ ρ Φ = id, where ρ turns the momentum round.
fn reversibility(evidence: &mut Evidence) -> Result<(), StudyError> {
    let turn = |state: &mut [f64]| {
        let n = state.len() / 2;
        state[n..].iter_mut().for_each(|p| *p = -*p);
    };
    let h = 0.25;
    let mut rows = Vec::new();
    for name in ["henon-heiles", "double-pendulum"] {
        let problem = problem(name, &[])?;
        let mut all = integrators()?;
        for name in DISSIPATIVE {
            all.push(methods::parse(name)?);
        }
        for method in all {
            let label = method.name();
            let mut state = step(&*problem, &*method, h, problem.initial())?;
            turn(&mut state);
            let mut back = step(&*problem, &*method, h, state)?;
            turn(&mut back);
            let defect = distance(&back, &problem.initial());
            // Two steps, each with roundings of a state of order 1 magnified by Λ/h in the momentum.
            let rounding = 16.0 * f64::EPSILON * (1.0 + method.momentum_roundoff(1.0)) / h;
            let id = format!("reversible/{name}/{label}");
            evidence.checks.push(if DISSIPATIVE.contains(&label.as_str()) {
                let statement = format!("{label} is not reversible on {name}");
                Check::within(id, statement, defect, [1e3 * rounding, f64::INFINITY], "a thousand roundings")
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
    evidence.tables.push(table("reversibility", caption, &columns, rows));
    Ok(())
}

/// The pendulum of [KY21]: (21) against (22), a portrait, and the energy over 10⁵ steps.
fn pendulum(evidence: &mut Evidence) -> Result<(), StudyError> {
    let tau = 0.1;
    let libration = problem("pendulum", &[])?;
    let steps = 1000.0;
    for degree in [2, 3, 4] {
        let (lagrange, bernstein) = (
            methods::parse(&format!("path-fitted({degree})"))?,
            methods::parse(&format!("path-fitted-bernstein({degree})"))?,
        );
        let mut one = Vec::new();
        integrate(&*libration, &*lagrange, tau, steps * tau, |state| one.push(state.q.clone()))?;
        let mut states = one.iter();
        let mut worst = 0.0_f64;
        integrate(&*libration, &*bernstein, tau, steps * tau, |state| {
            worst = worst.max(states.next().map_or(f64::NAN, |other| distance(&state.q, other)));
        })?;
        let roundoff = lagrange.momentum_roundoff(steps) + bernstein.momentum_roundoff(steps);
        evidence.checks.push(Check::at_most(
            format!("pendulum/bernstein-{degree}"),
            format!(
                "Path fitting of degree {degree} is the same in Lagrange's and in Bernstein's form over {steps} steps"
            ),
            worst,
            f64::EPSILON * roundoff * 2.0,
            "independent roundings of q ≤ 2 in each step, four deviations of what they add up to",
        ));
    }

    // Solutions, portrait and energy, as Figs 1–3 of the paper.
    let method = methods::parse("path-fitted(2)")?;
    let (mut solution, mut exact, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    integrate(&*libration, &*method, tau, 30.0, |state| {
        solution.push((state.t, state.q[0]));
        exact.extend(libration.exact(state.t).map(|q| (state.t, q[0])));
        rows.push(vec![
            text("libration from 2 rad"),
            Cell::Number(state.t),
            Cell::Number(state.q[0]),
            Cell::Number(state.q[1]),
        ]);
    })?;
    let mut portrait = Vec::new();
    for (q0, p0) in [("0.5", "0"), ("1", "0"), ("2", "0"), ("3", "0"), ("-3.1", "1"), ("3.1", "-1")] {
        let orbit = problem("pendulum", &[("q0", q0), ("p0", p0)])?;
        let mut points = Vec::new();
        integrate(&*orbit, &*method, tau, 30.0, |state| {
            // A rotation leaves the portrait after one turn.
            if state.q[0].abs() <= 0.5 * TAU {
                points.push((state.q[0], state.q[1]));
                let numbers = [state.t, state.q[0], state.q[1]].map(Cell::Number);
                rows.push([text(format!("q₀ = {q0}, p₀ = {p0}"))].into_iter().chain(numbers).collect());
            }
        })?;
        portrait.push(Series { label: format!("from ({q0}, {p0})"), points, mark: Mark::Line });
    }
    let invariants = libration.invariants();
    let energy = invariants.first().ok_or("the pendulum has no energy")?;
    let start = energy.value(&libration.initial());
    let (parts, horizon) = (100_usize, 1e5 * tau);
    let mut largest = vec![0.0_f64; parts];
    integrate(&*libration, &*method, tau, horizon, |state| {
        let part = ((state.t / horizon * parts as f64) as usize).min(parts - 1);
        largest[part] = largest[part].max((energy.value(&state.q) - start).abs());
    })?;
    let most = |part: &[f64]| part.iter().copied().fold(0.0, f64::max);
    evidence.checks.push(Check::at_most(
        "pendulum/energy",
        "The energy error of (21) over the last tenth of 10⁵ steps is that over the first tenth",
        most(&largest[parts - parts / 10..]) / most(&largest[..parts / 10]),
        1.01,
        "a bounded error has the same maximum; in 1600 periods sampled at 84 phases each it is met to better than a hundredth",
    ));
    let points: Vec<(f64, f64)> =
        largest.iter().enumerate().map(|(i, e)| ((i as f64 + 0.5) * horizon / parts as f64, *e)).collect();
    let energies = points.iter().map(|(t, e)| vec![Cell::Number(*t), Cell::Number(*e)]).collect();
    evidence.tables.push(data("pendulum-orbits", "Orbits of the pendulum by (21).", &["orbit", "t", "q", "p"], rows));
    let caption = "Largest energy error of (21) on the pendulum in each hundredth of 10⁵ steps.";
    evidence.tables.push(data("pendulum-energy", caption, &["t", "largest"], energies));
    let plain = |label: &str| Axis { label: label.into(), ..Axis::default() };
    let panel =
        |title: &str, x: &str, y: Axis, series| Panel { title: title.into(), x: plain(x), y, series, field: None };
    let from_zero = Axis { limits: Some((0.0, 1.5 * most(&largest))), ..plain("largest energy error") };
    let curve = |label: &str, points, mark| Series { label: label.into(), points, mark };
    evidence.figures.push(Figure {
        id: "pendulum".into(),
        caption: format!("The pendulum by path fitting of degree 2, (21) or (22), with τ = {tau}: the solution, orbits in phase space, and the energy error over 10⁵ steps."),
        data: "pendulum-orbits".into(),
        panels: vec![
            panel("Solution", "t", plain("q"), vec![curve("(21)", solution, Mark::Line), curve("exact", exact, Mark::Guide)]),
            panel("Phase portrait", "q", plain("p"), portrait),
            panel("Energy", "t", from_zero, vec![curve("(21)", points, Mark::Line)]),
        ],
        columns: 2,
    });
    Ok(())
}
