//! A model of the reader's own: every first-order method on it, and against CVODE and diffsol.

use rayon::prelude::*;

use super::{Context, orders};
use crate::compare::cross_check;
use crate::evidence::Evidence;
use crate::problem::model::{CAVEAT, Model};
use crate::theory::methods_for;

/// Anchor of the chapter.
pub const ID: &str = "model";

/// The question of the chapter.
pub const QUESTION: &str = "Does every method converge with its order on this model, and agree with CVODE and diffsol?";

/// What is to be said on `model`: orders of accuracy and cross-checks.
pub fn examine(model: &Model, context: &Context) -> Evidence {
    let methods = methods_for(model);
    context.announce(methods.len() + 1);
    let measured: Vec<_> = methods
        .into_par_iter()
        .map(|method| {
            let measured = orders::measure_one(model.name(), model, &*method);
            context.tick();
            measured
        })
        .collect();
    let mut evidence = orders::report(&measured);
    evidence.figures.push(orders::figure(&measured, [model.name()].into_iter()));
    let crossed = cross_check(model.name(), model);
    context.tick();
    evidence.checks.extend(crossed.checks);
    evidence.tables.extend(crossed.tables);
    for table in &mut evidence.tables {
        table.id = format!("{ID}-{}", table.id);
    }
    for figure in &mut evidence.figures {
        figure.id = format!("{ID}-{}", figure.id);
        figure.data = format!("{ID}-{}", figure.data);
    }
    evidence.notes.push(CAVEAT.into());
    evidence.notes.push(
        "DiffSL has no second derivatives. The iterations of the least-squares methods are Gauss and Newton's here, which \
         changes their work and not their results; methods that need the curvature of f to keep to their branch are not \
         run, nor those of mechanics."
            .into(),
    );
    evidence
}
