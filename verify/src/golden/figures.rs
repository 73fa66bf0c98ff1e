//! The maxima of the figures of \[S24\].

use super::{Row, Tolerance, Truth};
use crate::chapter::figures::{Plan, Sweep};
use crate::experiment::errors::roundoff;
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
