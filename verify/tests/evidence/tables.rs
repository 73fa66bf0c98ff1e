//! Columns of a table that follow from others of it.

use verify::evidence::{Evidence, Table};

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
        "stability-axes" => amplified(table),
        _ => Vec::new(),
    };
    evidence.tables.iter().flat_map(of).collect()
}

/// The rows in which numbers of these columns do not `agree`; rows without one of them say nothing.
fn disagreeing<const N: usize>(table: &Table, columns: [&str; N], agree: impl Fn([f64; N]) -> bool) -> Vec<String> {
    let columns = columns.map(|name| table.column(name).expect("a column"));
    let numbers = |row: &Vec<_>| -> Option<[f64; N]> {
        let numbers: Option<Vec<f64>> = columns.iter().map(|&k| verify::evidence::Cell::number(&row[k])).collect();
        numbers?.try_into().ok()
    };
    let rows = table.rows.iter().filter_map(numbers);
    rows.filter(|row| !agree(*row)).map(|row| format!("`{}` has a row with {row:?}", table.id)).collect()
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
