//! The data behind the paper's Figures 1–4, 6 and 7: every method at the paper's step sizes up to t = 10.

mod linear_drag;
mod poiseuille;
mod quadratic_drag;

pub(crate) use linear_drag::PLAN as FIGURE_2;
pub(super) use linear_drag::STUDY as LINEAR_DRAG;
pub(crate) use poiseuille::PLAN as FIGURE_7;
pub(super) use poiseuille::STUDY as POISEUILLE;
pub(crate) use quadratic_drag::PLAN as FIGURE_4;
pub(super) use quadratic_drag::STUDY as QUADRATIC_DRAG;

use std::sync::Arc;

use super::{Context, StudyError, prose};
use crate::evidence::{Axis, Check, Figure, Mark, Panel, Series, Table};
use crate::experiment::errors::{Decay, Errors, HORIZON, Run, points, roundoff};
use crate::row;

/// The methods in the paper's figures.
const PAPERS: [&str; 4] = ["method-i", "method-ii", "implicit-euler", "rk4"];

/// These, and what else is of the same kind: the third closure of the paper and the two rules of second order.
const METHODS: [&str; 7] =
    ["method-i", "method-ii", "implicit-euler", "rk4", "explicit-momentum", "trapezoidal", "implicit-midpoint"];

/// What a pair of figures shows.
pub(crate) struct Plan {
    /// Each problem with its methods.
    cases: &'static [(&'static str, &'static [&'static str])],
    /// Step sizes of the panels (a)–(f).
    steps: [f64; 6],
    /// Number of the figure with the time series; the next one has the maxima.
    figure: u32,
}

/// All runs of a plan.
pub(crate) struct Sweep {
    plan: &'static Plan,
    /// The runs, coarse to fine.
    pub(crate) runs: Vec<Arc<Run>>,
}

impl Sweep {
    /// The runs of `plan` that are not too long.
    pub(crate) fn run(plan: &'static Plan, context: &Context) -> Result<Self, StudyError> {
        let steps = plan.steps.into_iter().filter(|h| points(*h) as u64 <= context.max_steps());
        let pairs = plan.cases.iter().flat_map(|(problem, all)| all.iter().map(|method| (*problem, *method)));
        let settings = steps.flat_map(|h| pairs.clone().map(move |(problem, method)| Errors::of(problem, method, h)));
        Ok(Self { plan, runs: context.get_each(settings.collect())? })
    }

    /// The step sizes that were run, coarse to fine.
    fn steps(&self) -> impl Iterator<Item = f64> {
        self.plan.steps.into_iter().filter(|h| self.runs.iter().any(|run| run.of.h == *h))
    }

    fn find(&self, problem: &'static str, method: &'static str, h: f64) -> Option<&Run> {
        let of = Errors::of(problem, method, h);
        self.runs.iter().map(|run| &**run).find(|run| run.of == of)
    }

    /// The largest error of a run; NaN, which no check accepts, if there is no such run or it failed.
    fn error(&self, problem: &'static str, method: &'static str, h: f64) -> f64 {
        let largest = self.find(problem, method, h).and_then(|run| run.largest.as_ref().ok());
        largest.map_or(f64::NAN, |largest| largest.error)
    }

    /// Ratio of the largest errors of two methods.
    fn ratio(&self, problem: &'static str, (a, b): (&'static str, &'static str), h: f64) -> f64 {
        self.error(problem, a, h) / self.error(problem, b, h)
    }

    /// Every run against the recursion of its method in closed form.
    fn follows_the_closed_forms(&self) -> Check {
        let compared = self.runs.iter().filter_map(|run| {
            let (Ok(largest), Some(predicted)) = (&run.largest, run.predicted) else { return None };
            Some((run, (largest.error - predicted).abs() / roundoff(run.of.h, predicted)))
        });
        let worst = compared.clone().max_by(|a, b| a.1.total_cmp(&b.1));
        let reason = worst.map_or_else(String::new, |(run, _)| {
            format!(
                "In units of 8ε(1 + 1/h)(1 + error), the roundoff that a decaying run gathers; the largest of {} runs is {} \
                 on {}, h = {}.",
                compared.count(),
                run.of.method,
                run.of.problem,
                run.of.h
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
    fn errors_decay(&self, context: &Context) -> Result<Check, StudyError> {
        let reaches = |run: &&Arc<Run>| PAPERS.contains(&run.of.method) && run.largest.is_ok();
        let is_short = |run: &&Arc<Run>| Decay::END / run.of.h <= context.max_steps() as f64 && run.of.h >= 1e-3;
        let runs = self.runs.iter().filter(reaches).filter(is_short).map(|run| run.of);
        let decays = runs.clone().map(|Errors { problem, method, h, .. }| Decay { problem, method, h });
        let ratios = context.get_each(decays.collect())?;
        // Errors that are roundoff all the way say nothing.
        let decays: Vec<_> = runs.zip(&ratios).filter_map(|(run, ratio)| Some((run, (**ratio)?))).collect();
        let worst = decays.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        Ok(Check::at_most(
            "errors-decay",
            "the errors of the paper's four methods decay: on (t, 2t] they are at most half as large as on (t/2, t]",
            worst.map_or(f64::NAN, |(_, ratio)| *ratio),
            Decay::MOST,
            worst.map_or_else(String::new, |(Errors { problem, method, h, .. }, _)| {
                format!(
                    "Largest ratio of the maxima of {} runs, that of {method} on {problem} at h = {h}; what halves as t \
                     doubles falls at least like 1/t. Of t = 20, 10, 5, … it is the last at which the earlier errors are above \
                     ten times 8ε(1 + 1/h)(1 + |v|), roundoff, which need not fall.",
                    decays.len()
                )
            }),
        ))
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
                Ok(largest) => (Some(largest.error), Some(largest.t), "ok".into()),
                Err(error) => (None, None, error.to_string()),
            };
            row![run.of.problem, run.of.h, run.of.method, error, t, status]
        });
        let columns = ["problem", "h", "method", "max_error", "t_at_max", "status"];
        Table::new(self.maxima_id(), caption, columns, rows.collect())
    }

    fn series_table(&self) -> Table {
        let rows = self.runs.iter().flat_map(|run| {
            let Errors { problem, h, method, .. } = run.of;
            run.errors.iter().map(move |(t, error)| row![problem, h, method, *t, *error])
        });
        let caption = "Errors at the grid points t = nh; of runs longer than a thousand steps, 200 evenly and 200 \
                       logarithmically spaced in t.";
        Table::data(self.series_id(), caption, ["problem", "h", "method", "t", "error"], rows.collect())
    }

    /// Errors against time in the paper's panels (a)–(f), for one problem's methods.
    fn series_figure(&self, id: String, caption: String, problem: &'static str, methods: &[&'static str]) -> Figure {
        let panels = self.steps().zip('a'..).map(|(h, letter)| {
            let series = methods.iter().filter_map(|method| {
                let run = self.find(problem, method, h)?;
                Some(Series::new(*method, run.errors.clone(), Mark::Line))
            });
            let panel = Panel::new(Axis::linear("t").between(0.0, HORIZON), Axis::log("error"), series.collect());
            panel.titled(format!("({letter}) h = {h}"))
        });
        Figure::new(id, caption, self.series_id(), panels).in_columns(3)
    }

    /// Largest errors against 1/h.
    fn maxima_panel(&self, title: &str, curves: &[(&'static str, &'static str)]) -> Panel {
        let series = curves.iter().map(|(problem, method)| {
            let points = self.steps().map(|h| (h.recip(), self.error(problem, method, h)));
            let points = points.filter(|(_, error)| error.is_finite()).collect();
            Series::new(*method, points, Mark::LineMarkers)
        });
        Panel::new(Axis::log("1/h"), Axis::log("largest error"), series.collect()).titled(title)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;
    use crate::experiment::errors::Largest;

    /// Runs with these largest errors, and what closed forms have of them.
    pub(super) fn sweep(plan: &'static Plan, of: impl Fn(&str, f64) -> (f64, Option<f64>)) -> Sweep {
        let mut runs = Vec::new();
        for h in plan.steps {
            for (problem, methods) in plan.cases {
                runs.extend(methods.iter().map(|method| {
                    let (error, predicted) = of(method, h);
                    let largest = Ok(Largest { error, t: 1.0 });
                    Arc::new(Run { of: Errors::of(problem, method, h), largest, predicted, errors: Vec::new() })
                }));
            }
        }
        Sweep { plan, runs }
    }

    #[test]
    fn every_run_is_held_against_its_closed_form() {
        for off in FIGURE_2.steps {
            let outcome = |part: f64| {
                let of = |_: &str, h: f64| (1.0 + if h == off { part * roundoff(h, 1.0) } else { 0.0 }, Some(1.0));
                sweep(&FIGURE_2, of).follows_the_closed_forms().outcome
            };
            assert_eq!([0.9, -0.9, 1.2, -1.2].map(|part| outcome(part) == Outcome::Pass), [true, true, false, false]);
        }
    }

    #[test]
    fn largest_errors_are_drawn_over_the_number_of_steps_in_a_unit_of_time() {
        let panel = sweep(&FIGURE_2, |_, h| (h * h, None)).maxima_panel("", &[("linear-drag", "rk4")]);
        assert_eq!(panel.x.label, "1/h");
        assert_eq!(panel.series[0].points, FIGURE_2.steps.map(|h| (1.0 / h, h * h)));
    }
}
