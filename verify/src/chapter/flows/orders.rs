//! Orders in time on a fixed grid, and in time and space together.

use std::sync::Arc;

use super::{Context, Scale, StudyError, prose, short};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Outcome, Panel, Requirement, Series, Table};
use crate::experiment::flow::order::{CAVITY, CELLS, END, FlowOrder, Found, STEPS};
use crate::experiment::flow::refinement::{Found as Refined, Refinement};
use crate::experiment::flow::{PROJECTION, rms};
use crate::measure::norm::Extremes;
use crate::row;

/// Flows on coarse grids.
pub(super) const FLOWS: [&str; 4] =
    [CAVITY, "kovasznay cells=6", "channel-2d cells=6 length=4", "taylor-green cells=8"];
const METHODS: [&str; 9] = [
    "method-i",
    "method-ii",
    "linear(-0.5,1)",
    "trapezoidal",
    "implicit-midpoint",
    "tr-bdf2",
    "bdf2",
    "implicit-euler",
    "rk4",
];
/// Where matrices are assembled.
const GALERKIN: &str = "ls-galerkin(2,radau,2)";

fn name(flow: &str) -> &str {
    flow.split(' ').next().unwrap_or(flow)
}

pub(super) fn in_time(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    let mut cases: Vec<(&str, &str)> = Vec::new();
    for flow in scale.flows {
        cases.extend(METHODS.map(|method| (*flow, method)));
    }
    cases.extend([(CAVITY, GALERKIN), (CAVITY, PROJECTION)]);
    let found = context.get_each(cases.iter().map(|(flow, method)| FlowOrder { flow, method }).collect())?;
    let mut rows = Vec::new();
    let orders = cases.iter().zip(&found).map(|((flow, method), found)| order(flow, method, found));
    let orders: Vec<Check> = orders.collect();
    let kept = orders.iter().filter(|check| check.outcome == Outcome::Pass).count();
    evidence.checks.extend(orders);
    for ((flow, method), found) in cases.iter().zip(&found) {
        let setting = [Cell::Text((*flow).into()), Cell::Text((*method).into())];
        let numbers = found.differences.iter().copied().chain([found.order]).map(Cell::found);
        // Kept factors are fewer than the systems that are solved by them.
        let solves = if *method == GALERKIN { Cell::Empty } else { found.cost.solves.into() };
        let counts = [solves, found.cost.inner.into()];
        rows.push(setting.into_iter().chain(numbers).chain(counts).collect());
        evidence.timings.push((format!("{flow}, {method}, {} steps", STEPS[3]), found.cost.seconds));
    }
    let of = |method: &str| cases.iter().zip(&found).find(|(case, _)| **case == (CAVITY, method)).map(|(_, f)| f);
    if let (Some(scheme), Some(rule)) = (of(PROJECTION), of("tr-bdf2")) {
        evidence.checks.push(same_limit(scheme, rule));
    }
    let solves = |method| of(method).map_or_else(String::new, |found| found.cost.solves.to_string());
    let difference = |method| of(method).map_or_else(String::new, |found| short(found.differences[2]));
    let values = [
        ("kept", kept.to_string()),
        ("runs", cases.len().to_string()),
        ("cells", CELLS.to_string()),
        ("coarser", STEPS[2].to_string()),
        ("finest", STEPS[3].to_string()),
        ("method_i", difference("method-i")),
        ("method_ii", difference("method-ii")),
        ("tr_bdf2", difference("tr-bdf2")),
        ("galerkin", difference(GALERKIN)),
        ("projection", difference(PROJECTION)),
        ("method_i_solves", solves("method-i")),
        ("tr_bdf2_solves", solves("tr-bdf2")),
        ("projection_solves", solves(PROJECTION)),
    ];
    evidence.notes.extend(prose::fill(include_str!("orders.md"), &values)?);
    let caption = format!(
        "Root mean square of the difference between runs with h and h/2 at t = {END}, on a fixed grid, by h. The order is the one that the last \
         two give. Of the run with h = 1/{} `solves` counts the linear systems, and `inner` the iterations of conjugate \
         gradients in them, or of GMRES in methods with implicit stages: none where factors solve. The Galerkin integrator keeps \
         its factors from step to step; it made {} of them, and the systems that these solved are not counted.",
        f64::from(STEPS[3]) / END,
        solves(GALERKIN)
    );
    let columns = ["flow", "method", "h_1_128", "h_1_256", "h_1_512", "order", "solves", "inner"];
    evidence.tables.push(Table::new("flow-orders", caption, columns, rows));
    Ok(())
}

/// The order in time of a method on a flow.
fn order(flow: &str, method: &str, found: &Found) -> Check {
    let id = format!("order/{}/{method}", name(flow));
    let statement = format!("{method} converges in h on {} with its order, the grid fixed", name(flow));
    match order_in_time(found) {
        Some(bounds) => Check::within(
            id,
            statement,
            found.order,
            bounds,
            "from what differences over hᵖ change on the coarser steps: of that the finer ones have a part of 1/√2 at most, if what follows the order p is \
             of half an order more or of a higher one; and from the roundings of all steps",
        ),
        None => Check::undecided(
            id,
            statement,
            Outcome::Inconclusive,
            format!(
                "the order is {}, and differences over hᵖ have not settled for p = {}",
                short(found.order),
                found.nominal
            ),
        ),
    }
}

/// Between what the order may lie that the last two of three differences give. Each is of two runs, whose steps round by half an ε at random.
fn order_in_time(found: &Found) -> Option<[f64; 2]> {
    let differences = <[f64; 3]>::try_from(&found.differences[..]).ok()?;
    let size = rms(&found.end, &vec![0.0; found.end.len()]);
    let rounding = |k: usize| {
        let steps = f64::from(STEPS[k] + STEPS[k + 1]);
        0.5 * f64::EPSILON * steps.sqrt() * size / differences[k]
    };
    settled(differences, found.nominal, rounding(1) + rounding(2))
}

/// Another discretisation in time of the same equations, with a pressure and solved by other means.
fn same_limit(scheme: &Found, rule: &Found) -> Check {
    // Of second order: a third of the last difference each.
    let expected = (scheme.differences[2] + rule.differences[2]) / 3.0;
    Check::new(
        "projection/same-limit",
        "Pressure correction and TR-BDF2 tend to the same velocities: their difference over what they expect of their errors",
        rms(&scheme.end, &rule.end) / expected,
        Requirement::AtMost(1.25),
        "the space without divergence and the pressure that keeps to it are one discretisation; a quarter for the terms beyond the \
         second order",
    )
}

/// Against the exact flows, with h in proportion to Δx.
pub(super) fn in_time_and_space(context: &Context, evidence: &mut Evidence, scale: &Scale) -> Result<(), StudyError> {
    const METHODS: [&str; 3] = ["method-i", "tr-bdf2", EULER];
    const FLOWS: [&str; 3] = ["cavity-manufactured", KOVASZNAY, "channel-2d length=4"];
    let mut rows = Vec::new();
    let (mut euler, mut over, mut on_kovasznay) = (Vec::new(), Vec::new(), String::new());
    let mut panels = Vec::new();
    let cells = scale.refinement;
    for flow in FLOWS {
        let mut curves = Vec::new();
        let found = context.get_each(METHODS.map(|method| Refinement { flow, method, cells }).into())?;
        if flow == KOVASZNAY {
            on_kovasznay = short(found[2].errors[2] / found[0].errors[2]);
        }
        over.push(short(found[0].errors[2] / found[1].errors[2]));
        for (method, found) in METHODS.into_iter().zip(&found) {
            if method == "method-i" {
                evidence.checks.extend(together(flow, found, cells[2]));
            }
            if method == EULER {
                euler.push(Arc::clone(found));
            }
            let points = cells.iter().zip(&found.errors).map(|(n, error)| (1.0 / *n as f64, *error)).collect();
            curves.push(Series::new(method, points, Mark::LineMarkers));
            let ([coarse, middle, fine], [first, last]) = (found.errors, found.orders);
            rows.push(row![name(flow), method, coarse, middle, fine, first, last]);
        }
        panels.push(Panel::new(Axis::log("Δx"), Axis::log("error, r.m.s."), curves).titled(name(flow)));
    }
    let [manufactured, kovasznay, channel] = &euler[..] else { return Err("three flows".into()) };
    let values = [
        ("coarse", cells[0].to_string()),
        ("middle", cells[1].to_string()),
        ("fine", cells[2].to_string()),
        ("kovasznay", short(kovasznay.orders[1])),
        ("verdict", as_good_as_second(kovasznay).into()),
        ("euler_over", on_kovasznay),
        ("manufactured", short(manufactured.orders[1])),
        ("channel", short(channel.orders[1])),
        ("over_manufactured", over[0].clone()),
        ("over_kovasznay", over[1].clone()),
        ("over_channel", over[2].clone()),
    ];
    evidence.notes.extend(prose::fill(include_str!("space_time.md"), &values)?);
    let caption = format!(
        "Root mean square of the error of the velocities at t = 1 against the exact flows, on {}, {} and {} cells across with h = 1/N, and the orders of \
         each two grids.",
        cells[0], cells[1], cells[2]
    );
    let columns = ["flow", "method", "coarse", "middle", "fine", "first_order", "order"];
    let (table, figure) = ("flow-space-time", "flow-convergence");
    evidence.tables.push(Table::new(table, caption.clone(), columns, rows));
    evidence.figures.push(Figure::new(figure, caption, table, panels).in_columns(3));
    Ok(())
}

const EULER: &str = "implicit-euler";
/// It moves along x with the frame, and its errors are nearly all the grid's.
const KOVASZNAY: &str = "kovasznay";

/// Between what the order p on the finer two of three grids may lie, each of steps half as long as those of the one before, if errors or differences
/// are of order p and what follows it is of half an order more at least: over hᵖ they then change on the finer pair by a part of 1/√2 at most of what
/// they change on the coarser one, and by so much of `noise` besides. Nothing is known where that is no small part of them.
fn settled([first, second, third]: [f64; 3], order: f64, noise: f64) -> Option<[f64; 2]> {
    const SMALL: f64 = 0.25;
    let ratio = order.exp2();
    let change = (ratio * second - first).abs() / (ratio * ratio * third) * std::f64::consts::FRAC_1_SQRT_2;
    let may_change = change + noise;
    (may_change <= SMALL).then(|| [1.0 - may_change, 1.0 + may_change].map(|part| order + part.log2()))
}

/// The same of errors of second order on grids of twice the cells each.
fn second_order(errors: [f64; 3]) -> Option<[f64; 2]> {
    settled(errors, 2.0, 0.0)
}

/// What errors of implicit Euler say of a flow on which the grid makes nearly all of them.
fn as_good_as_second(found: &Refined) -> &'static str {
    match second_order(found.errors) {
        Some([low, high]) if low <= found.orders[1] && found.orders[1] <= high => "which would pass for second order",
        _ => "which would not pass for second order",
    }
}

/// The order of Method I in h and Δx together and, of a channel so many cells wide, that nothing changes along it.
fn together(flow: &str, found: &Refined, cells: usize) -> Vec<Check> {
    let (id, [first, last]) = (format!("space-time/{}", name(flow)), found.orders);
    let statement = format!("Method I converges on {} in h and Δx together with second order", name(flow));
    let mut checks = vec![match second_order(found.errors) {
        Some(bounds) => Check::within(
            id,
            statement,
            last,
            bounds,
            "from what errors over Δx² change on the two coarser grids: of that the finer two have a part of 1/√2 at most, if what follows the second order is of \
             half an order more or of a higher one",
        ),
        None => Check::undecided(
            id,
            statement,
            Outcome::Inconclusive,
            format!(
                "the order is {} on the coarser two grids and {} on the finer two, and errors over Δx² have not settled",
                short(first),
                short(last)
            ),
        ),
    }];
    if name(flow) == "channel-2d" {
        checks.push(Check::new(
            "channel/streamwise",
            "Start-up of the flow in a channel stays the same along it: the largest difference in u, and the largest v",
            streamwise(&found.end, cells),
            Requirement::Below(1e-10),
            "nothing but rounding and the tolerance of the solver can make it differ",
        ));
    }
    checks
}

/// The largest difference along the channel of u, and the largest v; u row by row, four to a row, then v.
fn streamwise(velocities: &[f64], cells: usize) -> f64 {
    const LENGTH: usize = 4;
    let (u, v) = velocities.split_at(LENGTH * cells);
    let along = u.chunks(LENGTH).map(|row| row.iter().copied().largest() - row.iter().copied().smallest());
    along.chain(v.iter().map(|v| v.abs())).largest()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::flow::Cost;

    fn found(differences: [f64; 3], nominal: f64, end: Vec<f64>) -> Found {
        let order = (differences[1] / differences[2]).log2();
        Found { differences: differences.to_vec(), order, nominal, cost: Cost::default(), end }
    }

    #[test]
    fn orders_are_held_to_what_differences_change_from_step_size_to_step_size() {
        let outcome = |differences: [f64; 3], nominal: f64, size: f64| {
            order(CAVITY, "method-i", &found(differences, nominal, vec![size; 4])).outcome
        };
        let differences = |of: &dyn Fn(f64) -> f64| [128.0, 256.0, 512.0].map(of);
        // With a next term of either sign, one or two orders beyond.
        for (p, next, c) in
            [(1, 2, 9.0), (1, 2, -9.0), (2, 3, 9.0), (2, 3, -9.0), (2, 4, 200.0), (2, 4, -200.0), (4, 5, 9.0)]
        {
            let right = differences(&|n| n.powi(-p) + c * n.powi(-next));
            assert_eq!(outcome(right, f64::from(p), 0.0), Outcome::Pass, "{p} {next} {c}");
            // Such differences are not those of another order.
            for other in [p - 1, p + 1] {
                assert_ne!(outcome(right, f64::from(other), 0.0), Outcome::Pass, "{p} {next} {c}, not {other}");
            }
        }
        // Nearly of second order, with a part of first order, and no number.
        let nearly = |order: f64| differences(&move |n| n.powf(-order));
        let mixed = differences(&|n| n.powi(-2) + 1e-5 / n);
        for wrong in [nearly(1.99), nearly(2.01), nearly(1.95), nearly(2.05), mixed] {
            assert_eq!(outcome(wrong, 2.0, 0.0), Outcome::Fail, "{wrong:?}");
        }
        assert_eq!(outcome([1.0, 0.25, f64::NAN], 2.0, 0.0), Outcome::Inconclusive);
        assert_eq!(outcome(nearly(2.0), 2.0, f64::NAN), Outcome::Inconclusive);
        // The last of these is off by a rounding of half an ε in each of 384 steps, at random; of twice as much it is not.
        let rounded = |of: f64| {
            let [first, second, third] = nearly(4.0).map(|d| 1e-3 * d);
            [first, second, third + of * 0.5 * f64::EPSILON * 384.0_f64.sqrt()]
        };
        assert_eq!([0.99, 2.0].map(|of| outcome(rounded(of), 4.0, 1.0)), [Outcome::Pass, Outcome::Fail]);
        assert_eq!(outcome(rounded(0.99), 4.0, 0.0), Outcome::Fail);
    }

    /// Each of the two expects an error of a third of 3e-5.
    #[test]
    fn two_schemes_have_the_same_limit_if_they_differ_by_what_they_expect() {
        let outcome = |apart: f64| {
            let [a, b] =
                [vec![1.0, 1.0], vec![1.0 + apart, 1.0 - apart]].map(|end| found([4e-4, 2e-4, 3e-5], 2.0, end));
            same_limit(&a, &b).outcome
        };
        assert_eq!(outcome(2.4e-5), Outcome::Pass);
        assert_eq!(outcome(2.6e-5), Outcome::Fail);
        assert_ne!(outcome(f64::NAN), Outcome::Pass);
    }

    fn refined(errors: [f64; 3], end: &[f64]) -> Refined {
        let [a, b, c] = errors;
        Refined { errors, orders: [(a / b).log2(), (b / c).log2()], end: end.to_vec() }
    }

    #[test]
    fn orders_in_space_and_time_are_held_to_what_errors_change_from_grid_to_grid() {
        let refused = |flow: &str, errors: [f64; 3], end: &[f64]| -> Vec<String> {
            let checks = together(flow, &refined(errors, end), 2);
            checks.into_iter().filter(|check| check.outcome != Outcome::Pass).map(|check| check.id).collect()
        };
        // Two cells across and four along, and one row of v between them.
        let even = [[0.5; 4], [0.7; 4], [0.0; 4]].concat();
        let errors = |of: &dyn Fn(f64) -> f64| [12.0, 24.0, 48.0].map(of);
        // Second order with a next term of third or of fourth order, of either sign.
        for (power, c) in [(3, 2.0), (3, -2.0), (4, 20.0), (4, -20.0)] {
            let second = errors(&|n| n.powi(-2) + c * n.powi(-power));
            assert_eq!(refused(KOVASZNAY, second, &even), [""; 0], "{power} {c}");
        }
        // With a part of first order, of other orders, before errors settle, and no number.
        let nearly = |order: f64| errors(&move |n| n.powf(-order));
        let mixed = errors(&|n| n.powi(-2) + 1e-3 / n);
        let unsettled = errors(&|n| n.powi(-2) + 20.0 * n.powi(-3));
        for wrong in [mixed, nearly(1.95), nearly(2.05), nearly(1.0), nearly(3.0), unsettled, [1.0, 0.25, f64::NAN]] {
            assert_eq!(refused(KOVASZNAY, wrong, &even), [format!("space-time/{KOVASZNAY}")], "{wrong:?}");
            assert!(as_good_as_second(&refined(wrong, &even)).contains("not pass"), "{wrong:?}");
        }
        let second = errors(&|n| n.powi(-2) + n.powi(-3));
        assert!(as_good_as_second(&refined(second, &even)).contains("would pass"));
        for place in [1, 7, 9] {
            let mut uneven = even.clone();
            uneven[place] += 2e-10;
            assert_eq!(refused("channel-2d", second, &uneven), ["channel/streamwise"], "{place}");
            assert_eq!(refused(KOVASZNAY, second, &uneven), [""; 0], "{place}");
        }
    }
}
