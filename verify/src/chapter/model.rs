//! A model of the reader's own: its solution, which method to take, and every first-order method on it beside CVODE and diffsol.

use rayon::prelude::*;

use super::{Context, StudyError, cross_check, orders, prose};
use crate::evidence::number::brief;
use crate::evidence::{Axis, Cell, Evidence, Figure, Mark, Panel, Section, Series, Table};
use crate::experiment::cross_check::compare;
use crate::experiment::orders::{LOST, measure_one};
use crate::experiment::work_error::{self, Found, Plan, Point};
use crate::measure::norm::max_norm;
use crate::problem::Problem;
use crate::problem::component_names;
use crate::problem::model::{CAVEAT, Model};
use crate::row;
use crate::theory::methods_for;

/// Anchor of the chapter.
pub const ID: &str = "model";

/// The question of the chapter.
pub const QUESTION: &str =
    "Which method should I use on this model? And does each converge with its order, and agree with CVODE and diffsol?";

/// What is run for the recommendation.
const PLAN: Plan = Plan {
    methods: &["method-i", "trapezoidal", "tr-bdf2", "rk4", "ls-galerkin(2,radau,2)", "ls-galerkin(3,gauss,3)"],
    steps: &[8, 16, 32, 64, 128, 256, 512],
    halves: &[4, 6, 8, 10, 12, 14, 16, 18],
};

/// The accuracy that the recommendation is for, over the largest component of the solution at the end or 1.
const TARGET: f64 = 1e-5;

/// Components that are drawn.
const DRAWN: usize = 8;

/// What is to be said on `model`: its solution, a recommendation, orders of accuracy and cross-checks.
///
/// # Errors
/// If the names of the plan are not those of methods.
pub fn examine(model: &Model, context: &Context) -> Result<Evidence, StudyError> {
    let methods = methods_for(model);
    context.announce(methods.len() + 2);
    let measured: Vec<_> = methods
        .into_par_iter()
        .map(|method| {
            let measured = measure_one(model.name(), model, &*method);
            context.tick();
            measured
        })
        .collect();
    let mut evidence = orders::report(&measured);
    evidence.figures.extend(orders::figures(&measured));
    let crossed = cross_check::evidence(&compare(model.name(), model, Vec::new(), &[]));
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
    recommend(model, &mut evidence)?;
    context.tick();
    evidence.notes.push(CAVEAT.into());
    Ok(evidence)
}

/// The solution, work against error, and what to take.
fn recommend(model: &Model, evidence: &mut Evidence) -> Result<(), StudyError> {
    let horizon = model.horizon();
    let course = work_error::course(model, horizon)?;
    let names: Vec<String> = component_names(model).into_iter().take(DRAWN).collect();
    let components = names.iter().enumerate().map(|(i, name)| {
        Series::new(name.clone(), course.iter().map(|(t, state)| (*t, state[i])).collect(), Mark::Line)
    });
    let panel = Panel::new(Axis::linear("t"), Axis::linear("solution"), components.collect()).titled(model.name());
    let rows = course
        .iter()
        .map(|(t, state)| [*t].into_iter().chain(state.iter().take(DRAWN).copied()).map(Cell::found).collect());
    let columns: Vec<String> = ["t".to_owned()].into_iter().chain(names.iter().cloned()).collect();
    let caption =
        "The solution, by radau-adaptive with a tolerance of 1e-6; of a model with many components the first ones.";
    evidence.tables.push(Table::data("model-solution", caption, columns, rows.collect()));
    let solution = Figure::new("model-solution", caption, "model-solution", [panel]);

    let found = work_error::measure(model, horizon, PLAN)?;
    let last = course.last().map_or(1.0, |(_, state)| max_norm(state).max(1.0));
    let most = LOST * last;
    let text = advice(model, &found, TARGET * last)?;
    let told = told(&found, TARGET * last);
    let rows = found
        .points
        .iter()
        .filter(|p| p.error.is_finite())
        .map(|p| row![&p.solver, p.setting, p.error, p.steps, p.evaluations, p.factorizations]);
    let caption = format!(
        "Error at the end against evaluations of f, in step equations as many as there are stages, and against factorizations: fixed steps from 8 to \
         512 in a run, and tolerances from 1e-2 to 1e-9. Errors above {} are left out.",
        brief(most)
    );
    let columns = ["solver", "h_or_tolerance", "error", "steps", "evaluations", "factorizations"];
    evidence.tables.push(Table::data("model-work", caption.clone(), columns, rows.collect()));
    let panel = |label: &str, work: fn(&Point) -> u64| {
        let curves = found.by_solver().map(|run| {
            let points = run
                .iter()
                .filter(|p| work(p) > 0 && p.error > 0.0 && p.error <= most)
                .map(|p| (work(p) as f64, p.error))
                .collect();
            Series::new(run[0].solver.clone(), points, Mark::LineMarkers)
        });
        let curves = curves.filter(|series| !series.points.is_empty()).collect();
        Panel::new(Axis::log(label), Axis::log("error at the end"), curves)
    };
    let panels = [panel("evaluations", |p| p.evaluations), panel("factorizations", |p| p.factorizations)];
    let work = Figure::new("model-work", caption, "model-work", panels).in_columns(2);
    let work = work.telling(&told.iter().map(String::as_str).collect::<Vec<_>>());
    evidence.sections.push(Section {
        id: "model-recommendation".into(),
        title: "Which method to use".into(),
        paragraphs: ["Answer", "Why", "Beware"].map(str::to_owned).into_iter().zip(text).collect(),
        figures: vec![solution.id.clone(), work.id.clone()],
        ..Section::default()
    });
    evidence.figures.extend([solution, work]);
    Ok(())
}

/// Whom the advice may name: the cheapest to reach `target` by either count, and the cheapest of the references.
fn told(found: &Found, target: f64) -> Vec<String> {
    let by_evaluations = found.ranked(false, target, |p| p.evaluations);
    let by_factorizations = found.ranked(false, target, |p| p.factorizations);
    let references = found.ranked(true, target, |p| p.evaluations);
    let implicit = by_factorizations.iter().filter(|point| point.factorizations > 0);
    let mut told: Vec<String> = by_evaluations
        .iter()
        .take(3)
        .chain(implicit.take(2))
        .chain(references.first())
        .map(|point| point.solver.clone())
        .collect();
    told.sort();
    told.dedup();
    told
}

/// Which method to take for an error of `target`.
fn advice(model: &Model, found: &Found, target: f64) -> Result<Vec<String>, StudyError> {
    let ours = found.ranked(false, target, |p| p.evaluations);
    let Some(best) = ours.first() else {
        let shortest = format!(
            "No run reaches an error of {} at t = {}: the steps are too long for this model, or its solution grows. Take a \
             shorter `--t-end`.",
            brief(target),
            model.horizon()
        );
        return Ok(vec![shortest]);
    };
    let is_adaptive = best.solver == "radau-adaptive";
    let needs = |point: &&Point| format!("`{}` needs {}", point.solver, point.evaluations);
    let next = ours.get(1).map_or_else(|| "no other method reaches it".into(), needs);
    let peer = found.ranked(true, target, |p| p.evaluations).first().map_or_else(
        || "No reference reaches it.".into(),
        |point| format!("Of the references {} evaluations of f.", needs(point)),
    );
    // An explicit method factors nothing.
    let thrifty = found.ranked(false, target, |p| p.factorizations);
    let thrifty = thrifty.iter().find(|point| point.factorizations > 0).unwrap_or(best);
    let values = [
        ("best", format!("`{}`", best.solver)),
        ("setting", format!("{} {}", if is_adaptive { "a tolerance of" } else { "h =" }, brief(best.setting))),
        ("target", brief(target)),
        ("horizon", model.horizon().to_string()),
        ("evaluations", best.evaluations.to_string()),
        ("next", next),
        ("peer", peer),
        ("thrifty", format!("`{}`", thrifty.solver)),
        ("factorizations", thrifty.factorizations.to_string()),
    ];
    prose::fill(include_str!("model.md"), &values)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An explicit method that evaluates least and factors nothing, and two that factor.
    #[test]
    fn each_method_is_advised_with_its_own_counts() {
        let point = |solver: &str, evaluations: u64, factorizations: u64| Point {
            solver: solver.into(),
            is_reference: false,
            setting: 0.1,
            steps: 10,
            evaluations,
            factorizations,
            error: 1e-6,
            seconds: 0.0,
        };
        let points = vec![point("rk4", 40, 0), point("method-i", 50, 7), point("sdirk2", 60, 3)];
        let model = Model::of_text("u_i { x = 1 } F_i { -x }", &[], Some(1.0)).expect("a model");
        let text = advice(&model, &Found { points, ..Found::default() }, 1e-5).expect("filled").join(" ");
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.starts_with("Take `rk4`.") && text.contains("with 40 evaluations of f"), "{text}");
        assert!(text.contains("`method-i` needs 50") && text.contains("`sdirk2` is the best with 3."), "{text}");
    }
}
