//! The data behind the paper's Figures 1–4, 6 and 7: every method at the paper's step sizes up to t = 10.

mod linear_drag;
mod maps;
mod poiseuille;
mod quadratic_drag;

pub(super) use linear_drag::STUDY as LINEAR_DRAG;
pub(super) use poiseuille::STUDY as POISEUILLE;
pub(super) use quadratic_drag::STUDY as QUADRATIC_DRAG;

use rayon::prelude::*;

use super::{Context, StudyError};
use crate::evidence::{Axis, Cell, Check, Figure, Mark, Panel, Series, Table};
use crate::golden::{Row, Tolerance, Truth};
use crate::measure::norm::larger;
use crate::method;
use crate::problem::{self, Problem};
use crate::run::{RunError, run};

/// The methods in the paper's figures.
const PAPERS: [&str; 4] = ["method-i", "method-ii", "implicit-euler", "rk4"];

/// These, and what else is of the same kind: the third closure of the paper and the two rules of second order.
const METHODS: [&str; 7] =
    ["method-i", "method-ii", "implicit-euler", "rk4", "explicit-momentum", "trapezoidal", "implicit-midpoint"];

/// The paper's horizon.
const HORIZON: f64 = 10.0;

/// What a pair of figures shows.
struct Plan {
    /// Each problem with its methods.
    cases: &'static [(&'static str, &'static [&'static str])],
    /// Step sizes of the panels (a)–(f).
    steps: [f64; 6],
    /// Number of the figure with the time series; the next one has the maxima.
    figure: u32,
    /// v_{n+1} of a problem's method from v_n in closed form.
    map: fn(problem: &str, method: &str, h: f64, v: f64) -> Option<f64>,
}

/// One run.
#[derive(Debug)]
struct Run {
    problem: &'static str,
    method: &'static str,
    h: f64,
    /// Largest error, or why the run failed part-way.
    largest: Result<Largest, RunError>,
    /// The largest error of the run by the closed form.
    predicted: Option<f64>,
    /// (t, error), thinned where there are many.
    errors: Vec<(f64, f64)>,
}

/// Largest error over the grid points t = nh, n ≥ 1.
#[derive(Debug, Clone, Copy, Default)]
struct Largest {
    error: f64,
    t: f64,
    /// Largest error in the second half of the horizon.
    late: f64,
}

impl Largest {
    fn see(&mut self, t: f64, error: f64) {
        if error > self.error || error.is_nan() {
            (self.error, self.t) = (error, t);
        }
        if t > 0.5 * HORIZON {
            self.late = larger(self.late, error);
        }
    }
}

/// All runs of a plan.
struct Sweep {
    plan: &'static Plan,
    runs: Vec<Run>,
}

/// Number of grid points t = nh ≤ 10, n ≥ 1, where h as a decimal fraction may divide 10.
fn points(h: f64) -> usize {
    (HORIZON / h * (1.0 + 4.0 * f64::EPSILON)).floor() as usize
}

/// The indices of the grid points that the time series keep: all of up to a thousand, else 200 evenly and 200
/// logarithmically spaced in t.
fn kept(count: usize) -> Vec<usize> {
    const EACH: u32 = 200;
    if count <= 1000 {
        return (1..=count).collect();
    }
    let of = |k: u32| f64::from(k) / f64::from(EACH);
    let even = (1..=EACH).map(|k| (count as f64 * of(k)).round() as usize);
    let logarithmic = (0..=EACH).map(|k| (count as f64).powf(of(k)).round() as usize);
    let mut all: Vec<usize> = even.chain(logarithmic).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The exact solution at t = nh, n = 1 ….
fn exact(problem: &dyn Problem, h: f64) -> Result<Vec<f64>, StudyError> {
    let at = |n: usize| {
        let t = n as f64 * h;
        problem.exact(t).map(|v| v[0]).ok_or_else(|| format!("no exact solution at t = {t}").into())
    };
    (1..=points(h)).into_par_iter().map(at).collect()
}

impl Sweep {
    /// Carries out the runs of `plan` that are not too long.
    fn run(plan: &'static Plan, context: &Context) -> Result<Self, StudyError> {
        let steps: Vec<f64> = plan.steps.into_iter().filter(|h| points(*h) as u64 <= context.max_steps).collect();
        let per_step: usize = plan.cases.iter().map(|(_, methods)| methods.len()).sum();
        (context.announce)((steps.len() * per_step) as u64);
        let runs: Result<Vec<Vec<Run>>, StudyError> = steps
            .into_par_iter()
            .map(|h| {
                // All cases of a plan have the same exact solution.
                let exact = exact(&*problem::build(plan.cases[0].0, &[])?, h)?;
                let pairs: Vec<_> =
                    plan.cases.iter().flat_map(|(problem, all)| all.iter().map(|method| (*problem, *method))).collect();
                pairs
                    .into_par_iter()
                    .map(|(problem, method)| {
                        let run = one_run(plan, problem, method, h, &exact);
                        (context.tick)();
                        run
                    })
                    .collect()
            })
            .collect();
        Ok(Self { plan, runs: runs?.into_iter().flatten().collect() })
    }

    /// The step sizes that were run, coarse to fine.
    fn steps(&self) -> impl Iterator<Item = f64> {
        self.plan.steps.into_iter().filter(|h| self.runs.iter().any(|run| run.h == *h))
    }

    fn find(&self, problem: &str, method: &str, h: f64) -> Option<&Run> {
        self.runs.iter().find(|run| run.problem == problem && run.method == method && run.h == h)
    }

    /// The largest error of a run; NaN, which no check accepts, if there is no such run or it failed.
    fn error(&self, problem: &str, method: &str, h: f64) -> f64 {
        let largest = self.find(problem, method, h).and_then(|run| run.largest.as_ref().ok());
        largest.map_or(f64::NAN, |largest| largest.error)
    }

    /// Ratio of the largest errors of two methods.
    fn ratio(&self, problem: &str, (a, b): (&str, &str), h: f64) -> f64 {
        self.error(problem, a, h) / self.error(problem, b, h)
    }

    /// Every run against the recursion of its method in closed form.
    fn follows_the_closed_forms(&self) -> Check {
        let compared = self.runs.iter().filter_map(|run| {
            let (Ok(largest), Some(predicted)) = (&run.largest, run.predicted) else { return None };
            Some((run, (largest.error - predicted).abs() / roundoff(run.h, predicted)))
        });
        let worst = compared.clone().max_by(|a, b| a.1.total_cmp(&b.1));
        let reason = worst.map_or_else(String::new, |(run, _)| {
            format!(
                "In units of 8ε(1 + 1/h)(1 + error), the roundoff that a decaying run gathers; the largest of {} runs is {} \
                 on {}, h = {}.",
                compared.count(),
                run.method,
                run.problem,
                run.h
            )
        });
        Check::at_most(
            "closed-forms",
            "the largest error of every run is that of its method's closed form repeated",
            worst.map_or(f64::NAN, |(_, ratio)| ratio),
            1.0,
            reason,
        )
    }

    /// "In all cases, the error decays to zero as t → ∞", for the paper's four methods where they reach the horizon.
    fn errors_decay(&self) -> Check {
        let ratios = self.runs.iter().filter(|run| PAPERS.contains(&run.method)).filter_map(|run| {
            let Largest { error, late, .. } = run.largest.as_ref().ok()?;
            Some((run, late / error))
        });
        let worst = ratios.max_by(|a, b| a.1.total_cmp(&b.1));
        Check::at_most(
            "errors-decay",
            "the errors of the paper's four methods decay: they are smaller for t > 5 than before",
            worst.map_or(f64::NAN, |(_, ratio)| ratio),
            0.999,
            worst.map_or_else(String::new, |(run, _)| {
                format!("Largest ratio of the maxima, that of {} on {} at h = {}.", run.method, run.problem, run.h)
            }),
        )
    }

    fn maxima_id(&self) -> String {
        format!("figure-{}", self.plan.figure + 1)
    }

    fn series_id(&self) -> String {
        format!("figure-{}", self.plan.figure)
    }

    fn maxima_table(&self, caption: &str) -> Table {
        let rows = self.runs.iter().map(|run| {
            let (error, t, status) = match &run.largest {
                Ok(largest) => (Cell::Number(largest.error), Cell::Number(largest.t), "ok".into()),
                Err(error) => (Cell::Empty, Cell::Empty, error.to_string()),
            };
            vec![
                Cell::Text(run.problem.into()),
                Cell::Number(run.h),
                Cell::Text(run.method.into()),
                error,
                t,
                Cell::Text(status),
            ]
        });
        Table {
            id: self.maxima_id(),
            caption: caption.into(),
            columns: ["problem", "h", "method", "max_error", "t_at_max", "status"].map(Into::into).to_vec(),
            rows: rows.collect(),
            shown: true,
        }
    }

    fn series_table(&self) -> Table {
        let rows = self.runs.iter().flat_map(|run| {
            let (problem, method) = (Cell::Text(run.problem.into()), Cell::Text(run.method.into()));
            run.errors.iter().map(move |(t, error)| {
                vec![problem.clone(), Cell::Number(run.h), method.clone(), Cell::Number(*t), Cell::Number(*error)]
            })
        });
        Table {
            id: self.series_id(),
            caption: "Errors at the grid points t = nh; of runs longer than a thousand steps, 200 evenly and 200 \
                      logarithmically spaced in t."
                .into(),
            columns: ["problem", "h", "method", "t", "error"].map(Into::into).to_vec(),
            rows: rows.collect(),
            shown: false,
        }
    }

    /// Errors against time in the paper's panels (a)–(f), for one problem's methods.
    fn series_figure(&self, id: String, caption: String, problem: &str, methods: &[&'static str]) -> Figure {
        let panels = self.steps().zip('a'..).map(|(h, letter)| {
            let series = methods.iter().filter_map(|method| {
                let run = self.find(problem, method, h)?;
                Some(Series { label: (*method).into(), points: run.errors.clone(), mark: Mark::Line })
            });
            Panel {
                title: format!("({letter}) h = {h}"),
                x: Axis { label: "t".into(), log: false, limits: Some((0.0, HORIZON)) },
                y: Axis { label: "error".into(), log: true, limits: None },
                series: series.collect(),
                ..Panel::default()
            }
        });
        Figure { id, caption, data: self.series_id(), panels: panels.collect(), columns: 3 }
    }

    /// Largest errors against 1/h.
    fn maxima_panel(&self, title: &str, curves: &[(&'static str, &'static str)]) -> Panel {
        let series = curves.iter().map(|(problem, method)| {
            let points = self.steps().map(|h| (h.recip(), self.error(problem, method, h)));
            let points = points.filter(|(_, error)| error.is_finite()).collect();
            Series { label: (*method).into(), points, mark: Mark::LineMarkers }
        });
        Panel {
            title: title.into(),
            x: Axis { label: "1/h".into(), log: true, limits: None },
            y: Axis { label: "largest error".into(), log: true, limits: None },
            series: series.collect(),
            ..Panel::default()
        }
    }
}

/// What the roundoff of a run can do to its largest error: each step errs by a few ε, and earlier errors decay like e^{−t}
/// or faster.
fn roundoff(h: f64, error: f64) -> f64 {
    8.0 * f64::EPSILON * (1.0 + h.recip()) * (1.0 + error)
}

fn one_run(plan: &Plan, name: &'static str, method: &'static str, h: f64, exact: &[f64]) -> Result<Run, StudyError> {
    let problem = problem::build(name, &[])?;
    let parsed = method::parse(method)?;
    let mut largest = Largest::default();
    let mut errors = Vec::new();
    let mut keep = kept(exact.len()).into_iter().peekable();
    let mut n = 0_usize;
    let outcome = run(&*problem, &*parsed, h, exact.len() as f64 * h, |state| {
        if let Some(exact) = n.checked_sub(1).and_then(|n| exact.get(n)) {
            let error = (state.q[0] - exact).abs();
            largest.see(state.t, error);
            if keep.next_if_eq(&n).is_some() {
                errors.push((state.t, error));
            }
        }
        n += 1;
    });
    let mut v = problem.initial()[0];
    let mut predicted = Largest::default();
    let by_map = exact.iter().all(|exact| match (plan.map)(name, method, h, v) {
        Some(next) => {
            v = next;
            predicted.see(0.0, (v - exact).abs());
            true
        }
        None => false,
    });
    Ok(Run {
        problem: name,
        method,
        h,
        largest: outcome.map(|_| largest),
        predicted: by_map.then_some(predicted.error),
        errors,
    })
}

/// The largest errors of a plan's shorter runs for the golden files, with those of the closed forms as the truth.
fn golden_rows(plan: &'static Plan) -> Result<Vec<Row>, StudyError> {
    let sweep = Sweep::run(plan, &Context::QUICK)?;
    let rows = sweep.runs.iter().map(|run| {
        let key = format!("{} h={} {}", run.problem, run.h, run.method);
        let error = match &run.largest {
            Ok(largest) => largest.error,
            // Why is a matter of digits; that it fails is not.
            Err(_) => return Row::text(key, "fails"),
        };
        let tolerance = Tolerance::absolute(roundoff(run.h, 0.0), "roundoff of the run, 8ε(1 + 1/h)");
        let row = Row::number(key, error, tolerance);
        match run.predicted {
            Some(value) => {
                let allowance = roundoff(run.h, value);
                row.with_truth(Truth { value, allowance, source: "the method's map in closed form, repeated".into() })
            }
            None => row,
        }
    });
    Ok(rows.collect())
}

/// Rows of the golden `figure-2`.
pub(crate) fn figure_2() -> Result<Vec<Row>, StudyError> {
    golden_rows(&linear_drag::PLAN)
}

/// Rows of the golden `figure-4`.
pub(crate) fn figure_4() -> Result<Vec<Row>, StudyError> {
    golden_rows(&quadratic_drag::PLAN)
}

/// Rows of the golden `figure-7`.
pub(crate) fn figure_7() -> Result<Vec<Row>, StudyError> {
    golden_rows(&poiseuille::PLAN)
}
