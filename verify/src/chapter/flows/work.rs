//! What an error in time costs: two cavities, in steps, linear systems and CPU time.

use std::sync::Arc;

use super::{Context, Scale, StudyError, brief, measured, prose, short};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Requirement, Series, Table};
use crate::experiment::flow::precision::{Flow, FlowPrecision, Found, Point};
use crate::experiment::flow::{PROJECTION, Seconds};
use crate::measure::norm::Extremes;
use crate::row;

pub(super) const METHODS: [&str; 8] =
    ["method-i", "method-ii", "trapezoidal", "tr-bdf2", "bdf2", "implicit-euler", "rk4", PROJECTION];
/// The place among the step sizes of the one whose error, by Method I, all methods are asked for.
const ASKED: usize = 2;

/// Runs of all methods in a cavity.
pub(super) struct Runs {
    flow: Flow,
    found: Vec<Arc<Found>>,
}

impl Runs {
    pub(super) fn new(context: &Context, flow: Flow, cells: usize) -> Result<Self, StudyError> {
        let found = context.get_each(METHODS.map(|method| FlowPrecision { flow, method, cells }).into())?;
        Ok(Self { flow, found })
    }

    fn of(&self, method: &str) -> Result<&Found, StudyError> {
        let found = METHODS.into_iter().zip(&self.found).find(|(name, _)| *name == method);
        found.map(|(_, found)| &**found).ok_or_else(|| "no such method".into())
    }

    /// With the finest steps.
    fn last(&self, method: &str) -> Result<&Point, StudyError> {
        self.of(method)?.points.last().ok_or_else(|| "no run".into())
    }

    /// The error of Method I with the finest steps over that of another.
    pub(super) fn over(&self, method: &str) -> Result<f64, StudyError> {
        let error = |method| Ok::<_, StudyError>(self.last(method)?.error.unwrap_or(f64::NAN));
        Ok(error("method-i")? / error(method)?)
    }

    /// The error that all are asked for.
    fn asked(&self) -> Result<f64, StudyError> {
        Ok(self.of("method-i")?.points[ASKED].error.unwrap_or(f64::NAN))
    }

    /// CPU seconds for that error.
    pub(super) fn seconds(&self, method: &str) -> Result<Option<Seconds>, StudyError> {
        Ok(self.of(method)?.seconds_for(self.asked()?))
    }

    /// The error of the best run of `method` that takes no more CPU time than Method I with its longest steps, as far as the times of repeated
    /// runs tell, over the error of these; `None` where no run is as cheap.
    pub(super) fn at_the_time_of_the_longest_steps(&self, method: &str) -> Result<Option<f64>, StudyError> {
        let own = self.of("method-i")?.points.first().ok_or("no run")?;
        let cheap = self.of(method)?.points.iter().filter(|point| point.seconds.least <= own.seconds.most);
        let errors: Vec<f64> = cheap.filter_map(|point| point.error).collect();
        Ok(own.error.filter(|_| !errors.is_empty()).map(|error| errors.into_iter().smallest() / error))
    }

    /// The error of the longest steps that hold, where these are more accurate than asked, and their seconds are taken.
    pub(super) fn held(&self, method: &str) -> Result<Option<f64>, StudyError> {
        let asked = self.asked()?;
        Ok(self.of(method)?.points.iter().find_map(|point| point.error).filter(|error| *error < asked))
    }

    fn name(&self) -> &'static str {
        match self.flow {
            Flow::Manufactured => "cavity-manufactured",
            Flow::Started => "cavity",
        }
    }

    /// What the runs are held against is better than the best of them.
    fn reference(&self) -> Check {
        let errors = self.found.iter().flat_map(|found| found.points.iter().filter_map(|p| p.error));
        // Its runs with different steps differ by roundings at least: those that do not are one, and tell no error.
        let told = |found: &Arc<Found>| if found.reference_error > 0.0 { found.reference_error } else { f64::NAN };
        Check::new(
            format!("work/{}/reference", self.name()),
            format!(
                "RK4 with small steps is a reference for errors in time of {}: its error over the smallest",
                self.name()
            ),
            self.found.iter().map(told).largest() / errors.smallest(),
            Requirement::AtMost(0.1),
            "a tenth of an error changes no ratio stated here by more than that",
        )
    }

    /// Errors of all methods against something.
    fn panel(&self, label: &str, of: fn(&Point) -> f64) -> Panel {
        let curves = METHODS.into_iter().zip(&self.found).map(|(method, found)| {
            let curve = found.points.iter().filter_map(|p| Some((of(p), p.error?))).filter(|(x, _)| *x > 0.0);
            Series::new(method, curve.collect(), Mark::LineMarkers)
        });
        let curves = curves.filter(|curve| !curve.points.is_empty()).collect();
        Panel::new(Axis::log(label), Axis::log("error, r.m.s."), curves).titled(self.name())
    }
}

/// Of two columns.
fn cells(Seconds { least, most }: Seconds) -> [Cell; 2] {
    [least, most].map(Cell::found)
}

/// How a run ended.
fn outcome(Point { error, failure, .. }: &Point) -> &str {
    match (error, failure) {
        (_, Some(failure)) => failure,
        (Some(_), None) => "arrives",
        (None, None) => "loses the flow",
    }
}

pub(super) fn study(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    let runs =
        [Runs::new(context, Flow::Manufactured, scale.precision)?, Runs::new(context, Flow::Started, scale.lid)?];
    let [smooth, started] = &runs;
    let [.., finest] = FlowPrecision::STEPS;
    evidence.checks.extend(runs.iter().map(Runs::reference));
    words(evidence, scale, &runs)?;
    let mut rows = Vec::new();
    for runs in &runs {
        for method in METHODS {
            let point = runs.last(method)?;
            let Point { h, error, cost, .. } = point;
            let over = Cell::found(1.0 / runs.over(method)?);
            let mut row = row![runs.name(), method, *h, *error, over, cost.solves, cost.inner];
            row.extend(cells(point.seconds).into_iter().chain(cells(runs.seconds(method)?.unwrap_or(Seconds::NONE))));
            row.push(outcome(point).into());
            rows.push(row);
        }
    }
    let caption = format!(
        "Cost per error of {finest} steps: the manufactured cavity at Re = {} on {} cells a side, t = {}, which is smooth, and that whose \
         lid starts at once, Re = {} on {} cells, t = {}. The error in time is the root mean square of that of the velocities, against RK4 with \
         small steps on the same grid; beside it, over Method I's. `solves` are linear systems, and `inner` iterations of conjugate gradients, or of GMRES, \
         in them, none where factors solve. CPU seconds are the least and the most of up to three such runs, on one thread. Those for an error \
         are for one of {} and of {}, which Method I has with {} steps, log-log between runs. Where the longest steps that hold are more accurate than that, their time; where no run is as accurate, none.",
        smooth.flow.re(),
        scale.precision,
        smooth.flow.end(),
        started.flow.re(),
        scale.lid,
        started.flow.end(),
        short(smooth.asked()?),
        short(started.asked()?),
        FlowPrecision::STEPS[ASKED],
    );
    let columns = [
        "flow",
        "method",
        "h",
        "error",
        "over_method_i",
        "solves",
        "inner",
        "least_seconds",
        "most_seconds",
        "least_for_equal_error",
        "most_for_equal_error",
        "outcome",
    ];
    evidence.tables.push(Table::new("flow-cost-per-error", caption, columns, rows));
    let id = "flow-precision";
    let caption = format!(
        "The runs behind the table of costs, with {} to {finest} steps: error in time of the velocities, root mean square. Where it is above that of the \
         flow itself, {} and {}, the run has lost the flow: it and runs with longer steps have no error and no point. The systems of \
         pressure correction have constant matrices and are separable, those of the other implicit methods are not, and RK4 has none of \
         the size of the flow but those of M.",
        FlowPrecision::STEPS[0],
        brief(smooth.found[0].size),
        brief(started.found[0].size)
    );
    let mut rows = Vec::new();
    for runs in &runs {
        for (method, found) in METHODS.into_iter().zip(&runs.found) {
            rows.extend(found.points.iter().map(|Point { h, error, cost, seconds, .. }| {
                let mut row = row![runs.name(), method, *h, *error, cost.solves, cost.inner];
                row.extend(cells(*seconds));
                row
            }));
        }
    }
    let columns = ["flow", "method", "h", "error", "solves", "inner", "least_seconds", "most_seconds"];
    evidence.tables.push(Table::data(id, caption.clone(), columns, rows));
    let panels: Vec<Panel> = runs
        .iter()
        .flat_map(|runs| {
            [
                runs.panel("h", |p| p.h),
                runs.panel("linear systems solved", |p| p.cost.solves as f64),
                runs.panel("CPU seconds", |p| p.seconds.least),
            ]
        })
        .collect();
    evidence.figures.push(Figure::new(id, caption, id, panels).in_columns(3));
    Ok(())
}

/// The same in words.
fn words(evidence: &mut Evidence, scale: &Scale, [smooth, started]: &[Runs; 2]) -> Result<(), StudyError> {
    let [.., finest] = FlowPrecision::STEPS;
    let [own, rule, tr_bdf2, scheme] =
        [smooth.of("method-i")?, smooth.of("trapezoidal")?, smooth.of("tr-bdf2")?, smooth.of(PROJECTION)?];
    let last = |method| {
        let Point { error, cost, .. } = smooth.last(method)?;
        Ok::<_, StudyError>((error.unwrap_or(f64::NAN), cost.solves))
    };
    let [own_last, rule_last, tr_bdf2_last] = [last("method-i")?, last("trapezoidal")?, last("tr-bdf2")?];
    let (projection, projection_solves) = last(PROJECTION)?;
    // So many that each of the three has runs on both sides.
    let finest_runs = [("Method I", own_last), ("the trapezoidal rule", rule_last), ("TR-BDF2", tr_bdf2_last)];
    let (fewest, (_, work)) = finest_runs.into_iter().min_by_key(|(_, (_, solves))| *solves).ok_or("no run")?;
    let work = work as f64;
    let over = |found: &Found| Some(own.error_with(work)? / found.error_with(work)?);
    let ratio = |found: &Found| brief(over(found).unwrap_or(f64::NAN));
    let (longest, error) = scheme.points.iter().find_map(|p| Some((p.h, p.error?))).unwrap_or((f64::NAN, f64::NAN));
    let seconds = |runs: &Runs, method| {
        Ok::<_, StudyError>(match (runs.seconds(method)?, runs.held(method)?, &runs.last(method)?.failure) {
            (Some(seconds), None, _) => format!("{} s", measured(seconds)),
            (Some(seconds), Some(error), _) => {
                format!("{} s (with its longest steps that hold, whose error is {})", measured(seconds), brief(error))
            }
            (None, _, Some(_)) => "has no run".into(),
            (None, _, None) => "more than with its finest steps".into(),
        })
    };
    let values = [
        ("re", short(smooth.flow.re())),
        ("cells", scale.precision.to_string()),
        ("steps", finest.to_string()),
        ("method_i", short(own_last.0)),
        ("method_i_solves", own_last.1.to_string()),
        ("tr_bdf2", short(tr_bdf2_last.0)),
        ("tr_bdf2_solves", tr_bdf2_last.1.to_string()),
        ("projection", short(projection)),
        ("projection_solves", projection_solves.to_string()),
        ("work", short(work)),
        ("fewest", fewest.into()),
        ("tr_bdf2_ratio", ratio(tr_bdf2)),
        ("rule_ratio", ratio(rule)),
        ("longest", short(longest)),
        ("courant", brief(longest * scale.precision as f64 * scheme.speed)),
        ("size", brief(scheme.size)),
        ("share", brief(error / scheme.size)),
        ("asked", short(smooth.asked()?)),
        ("asked_steps", FlowPrecision::STEPS[ASKED].to_string()),
        ("own_seconds", seconds(smooth, "method-i")?),
        ("method_ii_seconds", seconds(smooth, "method-ii")?),
        ("rule_seconds", seconds(smooth, "trapezoidal")?),
        ("tr_bdf2_seconds", seconds(smooth, "tr-bdf2")?),
        ("bdf2_seconds", seconds(smooth, "bdf2")?),
        ("rk4_seconds", seconds(smooth, "rk4")?),
        ("projection_seconds", seconds(smooth, PROJECTION)?),
        ("lid_re", short(started.flow.re())),
        ("lid_cells", scale.lid.to_string()),
        ("lid_end", short(started.flow.end())),
        ("lid_asked", short(started.asked()?)),
        ("lid_own_seconds", seconds(started, "method-i")?),
        ("lid_method_ii_seconds", seconds(started, "method-ii")?),
        ("lid_rule_seconds", seconds(started, "trapezoidal")?),
        ("lid_tr_bdf2_seconds", seconds(started, "tr-bdf2")?),
        ("lid_bdf2_seconds", seconds(started, "bdf2")?),
        ("lid_rk4_seconds", seconds(started, "rk4")?),
        ("lid_projection_seconds", seconds(started, PROJECTION)?),
    ];
    evidence.notes.extend(prose::fill(include_str!("work.md"), &values)?);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;
    use crate::experiment::flow::Cost;

    #[test]
    fn the_worst_reference_is_held_against_the_best_run_that_has_an_error() {
        let outcome = |reference_errors: [f64; 2], error: f64| {
            let point = |error| Point { h: 1.0, error, failure: None, cost: Cost::default(), seconds: Seconds::NONE };
            let found = reference_errors.map(|reference_error| {
                let points = vec![point(None), point(Some(1.0)), point(Some(error))];
                Arc::new(Found { points, size: 1.0, speed: 1.0, reference_error })
            });
            Runs { flow: Flow::Started, found: found.into() }.reference().outcome
        };
        assert_eq!(outcome([9e-6, 1e-9], 1e-4), Outcome::Pass);
        assert_eq!(outcome([1e-9, 1.1e-5], 1e-4), Outcome::Fail);
        assert_ne!(outcome([1e-9, f64::NAN], 1e-4), Outcome::Pass);
        assert_ne!(outcome([1e-9, 0.0], 1e-4), Outcome::Pass, "a reference that is compared with itself");
    }
}
