//! \[S24\]: the maxima of its figures, and steps in closed form.

use super::{Row, Tolerance, Truth};
use crate::chapter::figures::{Plan, Sweep};
use crate::experiment::errors::roundoff;
use crate::experiment::live_steps::LiveFactor;
use crate::experiment::maps::{PRINTED, Printed};
use crate::experiment::{Context, StudyError};

/// The largest errors of a plan's shorter runs for the golden files, with those of the closed forms as the truth.
pub(super) fn maxima(plan: &'static Plan, context: &Context) -> Result<Vec<Row>, StudyError> {
    let sweep = Sweep::run(plan, context)?;
    let rows = sweep.runs.iter().map(|run| {
        let key = format!("{} h={} {}", run.of.problem, run.of.h, run.of.method);
        let error = match &run.largest {
            Ok(largest) => largest.error,
            // Why is a matter of digits; that it fails is not.
            Err(_) => return Row::text(key, "fails"),
        };
        let tolerance = Tolerance::absolute(roundoff(run.of.h, 0.0), "roundoff of the run, 8ε(1 + 1/h)");
        let truth = run.predicted.map(|value| {
            let allowance = roundoff(run.of.h, value);
            Truth { value, allowance, source: "the method's map in closed form, repeated".into() }
        });
        Row::number(key, error, tolerance).with_truth(truth)
    });
    Ok(rows.collect())
}

/// A live factor in every other decade of h.
pub(super) fn closed_forms(context: &Context) -> Result<Vec<Row>, StudyError> {
    let mut rows = Vec::new();
    for Printed { name: closure, equation, factor, .. } in PRINTED {
        for h in (-3..=3).map(|k| 100_f64.powi(k)) {
            let [live, roundoff] = *context.get(LiveFactor { closure, h })?;
            let tolerance = Tolerance::absolute(roundoff, "roundoff bound of a live step");
            let truth = Truth { value: factor(h), allowance: roundoff, source: format!("Eq. {equation}") };
            rows.push(Row::number(format!("{closure} h={h:?}"), live, tolerance).with_truth(truth));
        }
    }
    Ok(rows)
}
