//! Columns of a table that follow from others of it.

use verify::evidence::{Cell, Evidence, Panel, Table};
use verify::measure::norm::{Extremes, max_norm};

const STIFF: &str = "prothero-robinson";

/// What a row of a table says of itself that is not so.
pub(super) fn contradictions(evidence: &Evidence) -> Vec<String> {
    let of = |table: &Table| match &*table.id {
        "drift" => disagreeing(table, ["drift", "stderr", "significance"], |[drift, stderr, significance]| {
            (significance * stderr / drift - 1.0).abs() <= 1e-12 || drift == 0.0
        }),
        // The scatter of n points about a line is |slope| √((1/r² − 1)/(n − 2)), and their own errors come on top.
        "orders" => {
            disagreeing(table, ["order", "stderr", "r_squared", "points"], |[order, stderr, r_squared, points]| {
                let scatter = order.abs() * ((1.0 / r_squared - 1.0).max(0.0) / (points - 2.0)).sqrt();
                1.0 - r_squared < 1e-9 || points <= 2.0 || stderr >= 0.99 * scatter
            })
        }
        // A step evaluates its equations, and no matrix is factored without an evaluation.
        "work-precision" => {
            disagreeing(table, ["steps", "residuals", "factorizations"], |[steps, residuals, factorizations]| {
                residuals >= factorizations && residuals >= steps
            })
            .into_iter()
            .chain(disagreeing(&chosen(table, "method", "rk4"), ["factorizations"], |[factorizations]| {
                factorizations == 0.0
            }))
            .collect()
        }
        // Of systems whose symmetric part is negative semidefinite.
        "non-normal-norms" => disagreeing(table, ["largest_symmetric"], |[largest]| largest <= 1e-12),
        "peers" | "peers-everywhere" => {
            disagreeing(table, ["evaluations", "factorizations"], |[evaluations, factorizations]| {
                evaluations >= factorizations
            })
        }
        "tolerances" => {
            disagreeing(table, ["steps", "evaluations", "factorizations"], |[steps, evaluations, factorizations]| {
                evaluations > factorizations && evaluations >= steps
            })
        }
        "order-points" => {
            let by_use = [("kept", false), ("pre-asymptotic", false), ("at the floor", true)];
            let of = |(what, is_floored)| {
                let rows = chosen(table, "use", what);
                disagreeing(&rows, ["error", "floor"], move |[error, floor]| (error <= 10.0 * floor) == is_floored)
            };
            by_use.into_iter().flat_map(of).collect()
        }
        "stability-axes" => amplified(table),
        _ => Vec::new(),
    };
    let marks = evidence.figures.iter().filter(|figure| figure.id == "stability-regions").flat_map(|figure| {
        let table = evidence.tables.iter().find(|table| table.id == figure.data).expect("its table");
        figure.panels.iter().flat_map(|panel| misplaced(table, panel))
    });
    evidence
        .tables
        .iter()
        .flat_map(of)
        .chain(marks)
        .chain(misjudged(evidence))
        .chain(unfounded(evidence))
        .chain(unlisted(evidence))
        .collect()
}

/// The orders that are not a mean of slopes between pairs of the points they rest on, as the slope of a line through points is, however these are
/// weighted.
fn unfounded(evidence: &Evidence) -> Vec<String> {
    let [orders, points] = ["orders", "order-points"].map(|id| evidence.tables.iter().find(|table| table.id == id));
    let (Some(orders), Some(points)) = (orders, points) else { return Vec::new() };
    let is_founded = |row: &Vec<Cell>| {
        let of = |name: &str| &row[orders.column(name).expect("a column")];
        let Some(order) = of("order").number() else { return true };
        let [problem, method] = ["problem", "method"].map(|name| of(name).to_string());
        let all = chosen(&chosen(points, "problem", &problem), "method", &method);
        let kept: Vec<[f64; 2]> =
            numbers(&chosen(&all, "use", "kept"), ["h", "error"]).map(|row| row.map(f64::ln)).collect();
        let pairs =
            kept.iter().enumerate().flat_map(|(i, a)| kept[..i].iter().map(move |b| (a[1] - b[1]) / (a[0] - b[0])));
        let (least, largest) = (pairs.clone().smallest(), pairs.largest());
        let counts = [kept.len(), all.rows.len()].map(|count| Some(count as f64));
        let slack = 1e-9 * order.abs();
        (least - slack..=largest + slack).contains(&order) && [of("points").number(), of("of").number()] == counts
    };
    let rows = orders.rows.iter().filter(|row| !is_founded(row));
    rows.map(|row| format!("`{}` has a row that its points do not bear: {row:?}", orders.id)).collect()
}

/// The runs of the table of rises that are none of the grid that they are taken from.
fn unlisted(evidence: &Evidence) -> Vec<String> {
    let [grid, rises] =
        ["tolerance-grid", "tolerance-rises"].map(|id| evidence.tables.iter().find(|table| table.id == id));
    let (Some(grid), Some(rises)) = (grid, rises) else { return Vec::new() };
    let runs: Vec<[f64; 3]> = numbers(grid, ["rtol", "atol", "largest"]).collect();
    let named = ["from", "to"].into_iter().flat_map(|end| {
        let names = ["rtol", "atol", "error"].map(|name| format!("{end} {name}"));
        numbers(rises, names.each_ref().map(String::as_str)).collect::<Vec<_>>()
    });
    named.filter(|run| !runs.contains(run)).map(|run| format!("`{}` has no run {run:?}", grid.id)).collect()
}

/// The rows with this text in a column.
fn chosen(table: &Table, column: &str, text: &str) -> Table {
    let k = table.column(column).expect("a column");
    let rows = table.rows.iter().filter(|row| row[k].to_string() == text).cloned().collect();
    Table { rows, ..table.clone() }
}

/// The extremes that checks are about, of all the rows that they are about, in the words of this list and not in those of the chapter.
fn misjudged(evidence: &Evidence) -> Vec<String> {
    let mut found = Vec::new();
    let mut require = |check: &str, expected: f64| {
        let check = evidence.checks.iter().find(|c| c.id == check).unwrap_or_else(|| panic!("{check}"));
        let measured = check.measured.unwrap_or(f64::NAN);
        if (measured - expected).abs() > 1e-12 * expected.abs() || measured.is_nan() {
            found.push(format!("`{}` has {measured}, and its table {expected}", check.id));
        }
    };
    for table in &evidence.tables {
        if table.id == "constraints" {
            let of = |row: &[Cell], name: &str| row[table.column(name).expect("a column")].clone();
            for row in &table.rows {
                let [problem, method] = ["problem", "method"].map(|name| of(row, name).to_string());
                for what in ["position", "hidden", "momentum"] {
                    let measured = of(row, what).number().unwrap_or(f64::NAN);
                    require(&format!("{what}/{problem}/{method}"), measured);
                }
            }
        }
        let rows = |names: &[&str], keys: &[&str]| -> Vec<Vec<f64>> {
            let text = |row: &Vec<Cell>, k: usize| matches!(&row[k], Cell::Text(text) if text.as_str() == keys[k]);
            let columns: Vec<usize> = names.iter().map(|name| table.column(name).expect("a column")).collect();
            let kept = table.rows.iter().filter(|row| (0..keys.len()).all(|k| text(row, k)));
            kept.filter_map(|row| columns.iter().map(|&k| row[k].number()).collect()).collect()
        };
        let largest = |values: Vec<f64>| values.into_iter().largest();
        match &*table.id {
            "closure-errors" => {
                require("fitted/exact", largest(rows(&["error"], &["fitted(1)"]).concat()));
            }
            "minimax-constants" => {
                let of = rows(&["least_error", "largest_error", "neighbour", "method_i", "method_ii"], &[]);
                let over = |rival: fn(&[f64]) -> f64| {
                    largest(of.iter().map(|row| row[0].abs().max(row[1].abs()) / rival(row)).collect())
                };
                require("minimax/best", over(|row| row[2]));
                require("minimax/rivals", over(|row| row[3].min(row[4])));
            }
            "closures-beyond" => {
                let over = |method: &str| {
                    let of = rows(&[method, "trapezoidal", "implicit-midpoint"], &[]);
                    largest(of.iter().map(|row| row[0] / row[1].min(row[2])).collect())
                };
                require(
                    "fitted/no-cure",
                    ["fitted(1)", "fitted(4)", "fitted-pade(4)"].map(over).into_iter().smallest(),
                );
            }
            "tolerances" => {
                for (problem, power) in
                    [("logistic", 1.0), ("damped-pendulum", 1.0), ("van-der-pol", 1.0), (STIFF, 2.0 / 3.0)]
                {
                    let of = rows(&["tolerance", "error"], &[problem]);
                    let over = |power: f64| largest(of.iter().map(|row| row[1] / row[0].powf(power)).collect());
                    require(&format!("tolerance/{problem}"), over(power));
                }
            }
            "tolerance-grid" => {
                for problem in ["logistic", "damped-pendulum", "van-der-pol", STIFF] {
                    let of = rows(&["rtol", "atol", "bound", "largest", "accepted"], &[problem]);
                    require(&format!("grid/{problem}/error"), largest(of.iter().map(|row| row[3] / row[2]).collect()));
                    // Of all pairs with tolerances smaller by this factor, and not the same ones.
                    let over = |factor: f64, column: usize| {
                        let is_smaller = |a: &[f64], b: &[f64]| {
                            a[..2] != b[..2] && (0..2).all(|k| b[k] * factor <= a[k] * (1.0 + 1e-9))
                        };
                        let pairs = of.iter().flat_map(|a| of.iter().map(move |b| (a, b)));
                        let pairs = pairs.filter(|(a, b)| is_smaller(a, b));
                        pairs.map(|(a, b)| [b[column] / a[column], a[column] / b[column]]).collect::<Vec<_>>()
                    };
                    require(&format!("grid/{problem}/falls"), largest(over(100.0, 3).iter().map(|it| it[0]).collect()));
                    require(&format!("grid/{problem}/work"), largest(over(100.0, 4).iter().map(|it| it[1]).collect()));
                }
            }
            "action-indicator" => {
                for problem in ["logistic", "quadratic-drag", "damped-pendulum", "van-der-pol"] {
                    let start = max_norm(&verify::problem::build(problem, &[]).expect("registered").initial());
                    for degree in [1.0, 2.0, 3.0] {
                        let of = rows(&["degree", "indicator", "error"], &[problem])
                            .into_iter()
                            .filter(|row| row[0] == degree);
                        // Errors at roundoff may be anything.
                        let above = of.filter(|row| row[2] > 160.0 * start * f64::EPSILON);
                        require(
                            &format!("action/{problem}/{degree}/bound"),
                            above.map(|row| row[1] / row[2]).smallest(),
                        );
                    }
                }
            }
            "metric-drift" => {
                for (metric, check) in [("balanced", "invariant/balanced"), ("euclidean", "invariant/euclidean")] {
                    require(check, largest(rows(&["drift"], &[metric]).concat()));
                }
            }
            _ => {}
        }
    }
    found
}

/// A panel of the map of stability whose marks are not the points at which its table has no factor.
fn misplaced(table: &Table, panel: &Panel) -> Option<String> {
    let [re, im, growth] = ["re", "im", &panel.title].map(|name| table.column(name).expect("a column"));
    let number = |row: &Vec<Cell>, k: usize| row[k].number().filter(|x| x.is_finite());
    let place = |row: &Vec<Cell>| Some((number(row, re)?, number(row, im)?));
    let without = table.rows.iter().filter(|row| number(row, growth).is_none()).filter_map(place);
    let marks = panel.series.iter().filter(|series| series.label == "no R").flat_map(|series| series.points.clone());
    // Either goes through the points in one order.
    let [without, marks]: [Vec<(f64, f64)>; 2] = [without.collect(), marks.collect()];
    (without != marks).then(|| format!("`{}`: {} has marks {marks:?} for {without:?}", table.id, panel.title))
}

/// The numbers of rows that have one in each of these columns.
fn numbers<const N: usize>(table: &Table, columns: [&str; N]) -> impl Iterator<Item = [f64; N]> {
    let columns = columns.map(|name| table.column(name).expect("a column"));
    table.rows.iter().filter_map(move |row| {
        let numbers: Option<Vec<f64>> = columns.iter().map(|&k| row[k].number()).collect();
        numbers?.try_into().ok()
    })
}

/// The rows in which numbers of these columns do not `agree`; rows without one of them say nothing.
fn disagreeing<const N: usize>(table: &Table, columns: [&str; N], agree: impl Fn([f64; N]) -> bool) -> Vec<String> {
    let rows = numbers(table, columns).filter(|row| !agree(*row));
    rows.map(|row| format!("`{}` has a row with {row:?}", table.id)).collect()
}

/// RK4 amplifies beyond hλ = −2.785 and 2.828 i, and both are drawn.
fn amplified(table: &Table) -> Vec<String> {
    let axes = [("negative real axis", 2.7853), ("imaginary axis", 2.8285)];
    let is_shown = |(axis, limit): &(&str, f64)| {
        let points = super::curves::points(table, axis, "rk4", "radius", "growth");
        points.iter().any(|(r, growth)| r > limit && *growth > 1.0)
            && points
                .iter()
                .all(|(r, growth)| (*growth > 1.0 + 1e-9) == (r > limit) || (r - limit).abs() < 1e-3 || *r < 0.05)
    };
    axes.iter().filter(|axis| !is_shown(axis)).map(|(axis, _)| format!("`{}`: RK4 on the {axis}", table.id)).collect()
}
