//! Tables for people, 80 columns wide, and one for programs.

use std::io::{self, Write};
use std::path::Path;

use crate::contest::{Contest, Set};
use crate::measure::{Cell, Cost, Found, TARGETS};

/// What stands where a solver fails.
const NOTHING: &str = "–";

/// The table of a set: each problem at each error, and the geometric mean of the ratios.
pub(crate) fn set(out: &mut impl Write, set: Set, found: &[(&Contest, Found)]) -> io::Result<()> {
    writeln!(out, "{}", set.title())?;
    let [peer, time] = match set {
        Set::ByHand => ["by hand", "hand_us"],
        Set::Stiff | Set::Mechanics => ["best peer", "peer_us"],
    };
    writeln!(
        out,
        "{:<12}{:>6}{:>9}  {:<18}{peer:<18}{time:>9}{:>6}",
        "problem", "error", "ours_us", "method", "ratio"
    )?;
    let cells: Vec<(&str, &Cell)> =
        found.iter().flat_map(|(contest, found)| found.cells.iter().map(|cell| (contest.problem, cell))).collect();
    for (problem, cell) in &cells {
        let name = |cost: &Option<Cost>| cost.as_ref().map_or(NOTHING.into(), |cost| cost.solver.clone());
        let time = |cost: &Option<Cost>| microseconds(cost.as_ref().map(|cost| cost.seconds));
        let ratio = cell.ratio().map_or(NOTHING.into(), |ratio| format!("{ratio:.2}"));
        let Cell { error, ours, peer } = cell;
        let (ours_us, method, best, peer_us) = (time(ours), name(ours), name(peer), time(peer));
        writeln!(out, "{problem:<12}{error:>6.0e}{ours_us:>9}  {method:<18}{best:<18}{peer_us:>9}{ratio:>6}")?;
    }
    let ratios: Vec<f64> = cells.iter().filter_map(|(_, cell)| cell.ratio()).collect();
    let (count, all, aim) = (ratios.len(), cells.len(), set.aim());
    let mean = geometric_mean(&ratios).map_or(NOTHING.into(), |mean| format!("{mean:.2}"));
    writeln!(out, "geometric mean of the ratio, {count} of {all} cells: {mean} (aim: at most {aim})\n")
}

/// Every solver's time at each error, from its sweep alone.
pub(crate) fn solvers(out: &mut impl Write, problem: &str, found: &Found) -> io::Result<()> {
    let errors = TARGETS.map(|error| format!("{:>12}", format!("{error:.0e}"))).concat();
    writeln!(out, "{:<24}{errors}", format!("{problem}, us at"))?;
    for row in &found.rows {
        let times = row.seconds.map(|seconds| format!("{:>12}", microseconds(seconds))).concat();
        writeln!(out, "{:<24}{times}", row.solver)?;
    }
    writeln!(out)
}

/// Writes the cells as comma-separated values; a field is empty where a solver fails.
///
/// # Errors
/// If the file cannot be written.
pub(crate) fn csv(path: &Path, found: &[(&Contest, Found)]) -> Result<(), csv::Error> {
    let mut table = csv::Writer::from_path(path)?;
    table.write_record(["set", "case", "error", "ours", "ours_us", "peer", "peer_us", "ratio"])?;
    for (contest, found) in found {
        for cell in &found.cells {
            let fields = |cost: &Option<Cost>| {
                let cost = cost.as_ref();
                let (name, time) = cost.map(|c| (c.solver.clone(), (1e6 * c.seconds).to_string())).unwrap_or_default();
                [name, time]
            };
            let [[ours, ours_us], [peer, peer_us]] = [fields(&cell.ours), fields(&cell.peer)];
            let ratio = cell.ratio().map(|ratio| ratio.to_string()).unwrap_or_default();
            let error = format!("{:e}", cell.error);
            let [set, problem] = [contest.set.title(), contest.problem];
            table.write_record([set, problem, &error, &ours, &ours_us, &peer, &peer_us, &ratio])?;
        }
    }
    Ok(table.flush()?)
}

/// The exponential of the mean logarithm; nothing of none.
fn geometric_mean(ratios: &[f64]) -> Option<f64> {
    let logarithms = ratios.iter().map(|ratio| ratio.ln()).sum::<f64>();
    (!ratios.is_empty()).then(|| (logarithms / ratios.len() as f64).exp())
}

/// Three digits or all before the point.
fn microseconds(seconds: Option<f64>) -> String {
    match seconds.map(|seconds| 1e6 * seconds) {
        None => NOTHING.into(),
        Some(us) if us < 9.995 => format!("{us:.2}"),
        Some(us) if us < 99.95 => format!("{us:.1}"),
        Some(us) => format!("{us:.0}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contest::ALL;

    fn cost(seconds: f64) -> Option<Cost> {
        Some(Cost { solver: "solver".into(), seconds })
    }

    #[test]
    fn a_failure_is_neither_a_win_nor_part_of_the_mean() {
        let cells = vec![
            Cell { error: 1e-3, ours: cost(2e-6), peer: cost(1e-6) },
            Cell { error: 1e-6, ours: None, peer: cost(1e-6) },
            Cell { error: 1e-9, ours: cost(1e-6), peer: None },
        ];
        assert_eq!(cells.iter().map(Cell::ratio).collect::<Vec<_>>(), [Some(2.0), None, None]);
        let mut out = Vec::new();
        set(&mut out, Set::Stiff, &[(&ALL[0], Found { cells, rows: Vec::new() })]).expect("it is memory");
        let text = String::from_utf8(out).expect("it is text");
        assert!(text.contains("1 of 3 cells: 2.00"), "{text}");
        let ends: Vec<&str> = text.lines().filter_map(|line| line.split_whitespace().last()).collect();
        assert_eq!(ends[2..5], ["2.00", NOTHING, NOTHING], "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    }

    #[test]
    fn the_mean_is_that_of_logarithms() {
        assert_eq!(geometric_mean(&[]), None);
        let mean = geometric_mean(&[0.5, 2.0, 8.0]).expect("there are some");
        assert!((mean - 2.0).abs() < 1e-14);
    }
}
