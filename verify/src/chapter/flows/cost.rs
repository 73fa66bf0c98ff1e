//! What a step costs by the size of the grid, and why it does.

use super::{Context, Scale, StudyError, about, brief, prose, short};
use crate::evidence::{Cell, Evidence, Table};
use crate::experiment::flow::cost::{Found, StepCost};
use crate::row;

/// The step size for so many cells, or points, along a side.
type StepSize = fn(usize) -> f64;

const FLOWS: [(&str, StepSize); 3] = [
    ("cavity re=1000", |_| 0.05),
    ("turbulence-2d re=1000", |_| 0.01),
    ("turbulence-2d re=1000", |points| 0.64 / points as f64),
];

/// Seconds a step of Method I takes by the size of the grid, beside the entries of the factors that it solves with.
pub(super) fn study(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    let mut rows = Vec::new();
    let mut costs = Vec::new();
    for ((flow, h), cells) in FLOWS.into_iter().zip(scale.costs) {
        let mut of_flow = Vec::new();
        for &cells in cells {
            let cost = context.get(StepCost { flow, cells, h: h(cells) })?;
            let PerCell { microseconds, inner, fill } = PerCell::new(cells, &cost);
            let counts = [cost.first, cost.next, cost.iterations, inner].map(Cell::from);
            let each = [Cell::from(microseconds), fill.map_or(Cell::Empty, Cell::from), (microseconds / inner).into()];
            let row = row![flow, cells, cost.unknowns, h(cells)].into_iter().chain(counts).chain(each).collect();
            // The two series of turbulence meet on a grid.
            if !rows.contains(&row) {
                rows.push(row);
            }
            of_flow.push((cells, PerCell { microseconds, inner, fill }));
        }
        costs.push(of_flow);
    }
    let [cavity, same, proportional] = costs.as_slice() else { return Err("three flows".into()) };
    let ([(coarse, first), .., (fine, last)], [(_, same_first), .., (points, same_last)]) = (&**cavity, &**same) else {
        return Err("two grids".into());
    };
    let [(_, small), .., (_, large)] = proportional.as_slice() else { return Err("two grids".into()) };
    // One measurement has one digit.
    let rough = |value: f64| about(value, value);
    let fills = [first, last].map(|cost| cost.fill.unwrap_or(f64::NAN));
    let values = [
        ("coarse", coarse.to_string()),
        ("fine", fine.to_string()),
        ("first", rough(first.microseconds)),
        ("last", rough(last.microseconds)),
        ("iterations", brief(last.inner / first.inner)),
        ("fill_first", short(fills[0])),
        ("fill_last", short(fills[1])),
        ("fill", brief(fills[1] / fills[0])),
        ("points", points.to_string()),
        ("same", about(same_first.microseconds, same_last.microseconds)),
        ("inner_first", brief(same_first.inner)),
        ("inner_last", brief(same_last.inner)),
        ("proportional", about(small.microseconds, large.microseconds)),
    ];
    evidence.notes.extend(prose::fill(include_str!("cost.md"), &values)?);
    let caption = "Steps of Method I, one after another on the machine that made this page: CPU seconds of the first, with what is \
                   set up for all, and of each of the next. Iterations: Gauss–Newton iterations of a step; inner, iterations of conjugate \
                   gradients in all of them. Microseconds a cell are those of a step, and of an iteration of conjugate gradients, which \
                   solves twice with the LU factors of B, with its share of all else. Fill: entries of these factors per unknown, none \
                   in Fourier space.";
    let columns = [
        "flow",
        "cells",
        "unknowns",
        "h",
        "first",
        "next",
        "iterations",
        "inner",
        "microseconds_a_cell",
        "fill",
        "microseconds_a_cell_and_inner",
    ];
    evidence.tables.push(Table::new("flow-costs", caption, columns, rows));
    Ok(())
}

/// What a step costs a cell.
struct PerCell {
    microseconds: f64,
    /// Iterations of conjugate gradients, of all cells together.
    inner: f64,
    /// Entries of the LU factors of B an unknown.
    fill: Option<f64>,
}

impl PerCell {
    fn new(cells: usize, cost: &Found) -> Self {
        Self {
            microseconds: 1e6 * cost.next / (cells * cells) as f64,
            inner: cost.iterations * cost.inner,
            fill: cost.factor_entries.map(|entries| entries as f64 / cost.unknowns as f64),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::SMALL;
    use super::*;

    #[test]
    fn a_step_costs_its_seconds_over_the_cells() {
        let mut evidence = Evidence::default();
        let costs: [&[usize]; 3] = [&[3, 4], &[6, 8], &[6, 8]];
        study(&Context::quick(), &mut evidence, &Scale { costs, ..SMALL }).expect("they run");
        let table = &evidence.tables[0];
        let number =
            |row: &[Cell], column: &str| match row[table.columns.iter().position(|c| c == column).expect("there")] {
                Cell::Number(x) => x,
                Cell::Integer(x) => x as f64,
                _ => panic!("{column}"),
            };
        assert_eq!(table.rows.len(), 6);
        // Four unknowns, each a neighbour of the others.
        assert_eq!(number(&table.rows[0], "fill"), 4.0);
        for row in &table.rows {
            let cells = number(row, "cells").powi(2);
            let each = number(row, "microseconds_a_cell") * cells;
            assert!((each - 1e6 * number(row, "next")).abs() <= 1e-9 * each.abs(), "{row:?}");
            let inner = number(row, "microseconds_a_cell_and_inner") * number(row, "inner") * cells;
            assert!((inner - each).abs() <= 1e-9 * each.abs(), "{row:?}");
        }
    }
}
