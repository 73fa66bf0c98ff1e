//! The defect of symplecticity of one step.

use std::sync::Arc;

use super::parts::order_check;
use super::{Context, Study, StudyError, prose};
use crate::evidence::{Axis, Check, Evidence, Figure, Mark, Panel, Table};
use crate::experiment::symplectic_defect::{Defects, Found, SETTINGS, STEPS};
use crate::row;

pub(super) const STUDY: Study = Study {
    id: "symplecticity",
    title: "Symplecticity",
    question: "Which integrators are symplectic, on which systems, and by how much do the others fail to be?",
    source: "[KY21] Section 1; [MW01]",
    run,
};

/// Of each kind that the text tells apart one.
pub(super) const TOLD: [&str; 6] =
    ["midpoint-vi", "stormer-verlet", "galerkin-gauss(3)", "path-fitted(2)", "path-fitted(4,gauss)", "path-fitted(4)"];

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let found = context.get_each(Defects::all()?)?;
    let points = points(&found);
    Ok(Evidence {
        checks: found.iter().map(|found| check(found)).collect(),
        figures: vec![figure(&points)],
        tables: vec![summary(&found), points],
        notes: prose::fill(include_str!("symplecticity.md"), &[])?,
        ..Evidence::default()
    })
}

fn check(found: &Found) -> Check {
    let Found { problem, method, fit, .. } = found;
    let id = format!("{problem}/{method}");
    match fit {
        None => {
            let statement = format!("{method} is symplectic on {problem}");
            let reason = format!("largest defect over its rounding, of {STEPS} step sizes");
            Check::at_most(id, statement, found.excess(), 1.0, reason)
        }
        Some(fit) => {
            let power = fit.expected.order;
            let statement = format!("{method} is not symplectic on {problem}, with a defect of h to the power {power}");
            order_check(id, statement, fit)
        }
    }
}

fn summary(found: &[Arc<Found>]) -> Table {
    let rows = found.iter().map(|found| {
        let slope = found.fit.as_ref().and_then(|fit| fit.line).map(|line| line.slope);
        let point = found.shown();
        let kind = if found.fit.is_none() { "symplectic" } else { "not symplectic" };
        row![found.problem, &found.method, point.h, point.defect, point.rounding, slope, kind]
    });
    Table::new(
        "symplecticity",
        "Defect of symplecticity of one step of size h, the rounding of its computation, and the power of h with which it falls.",
        ["problem", "method", "h", "defect", "rounding", "power", "kind"],
        rows.collect(),
    )
}

fn points(found: &[Arc<Found>]) -> Table {
    let rows = found.iter().flat_map(|found| {
        found.points.iter().map(|point| row![found.problem, &found.method, point.h, point.defect, point.rounding])
    });
    let columns = ["problem", "method", "h", "defect", "rounding"];
    Table::data("symplecticity-points", "Defects at all step sizes.", columns, rows.collect())
}

fn figure(points: &Table) -> Figure {
    let panels = SETTINGS.iter().map(|setting| {
        let of_problem = points.where_text("problem", setting.problem);
        let y = Axis::log("defect").between(1e-17, 1.0);
        Panel::new(Axis::log("h"), y, of_problem.curves("method", "h", "defect", Mark::LineMarkers))
            .titled(setting.problem)
    });
    let caption = "Defect of symplecticity of one step. Symplectic methods lie at rounding, at the bottom; an exact zero is \
                   left out.";
    Figure::new("symplecticity", caption, points.id.clone(), panels).in_columns(2).telling(&TOLD)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;
    use crate::experiment::symplectic_defect::Point;

    #[test]
    fn one_defect_that_is_no_number_fails_the_check() {
        let found = |defect| {
            let point = |defect| Point { h: 0.1, defect, rounding: 1e-16 };
            let points = vec![point(1e-17), point(defect), point(1e-17)];
            Found { problem: "kepler", method: "midpoint-vi".into(), points, fit: None }
        };
        assert_eq!(check(&found(1e-17)).outcome, Outcome::Pass);
        assert_eq!(check(&found(f64::NAN)).outcome, Outcome::Fail);
        // More than its rounding.
        assert_eq!(check(&found(1.5e-16)).outcome, Outcome::Fail);
    }

    #[test]
    fn a_defect_and_its_rounding_stand_under_their_names() {
        let points = (0..STEPS).map(|k| Point { h: 0.5_f64.powi(k as i32), defect: 1e-3, rounding: 1e-16 }).collect();
        let found = [Arc::new(Found { problem: "kepler", method: "midpoint-vi".into(), points, fit: None })];
        let shown = found[0].shown();
        for table in [summary(&found), self::points(&found)] {
            let of = |name: &str| table.column(name).expect("a column");
            let row = table.rows.iter().find(|row| row[of("h")].number() == Some(shown.h)).expect("a row");
            assert_eq!(["defect", "rounding"].map(|name| row[of(name)].number()), [Some(1e-3), Some(1e-16)]);
        }
    }
}
