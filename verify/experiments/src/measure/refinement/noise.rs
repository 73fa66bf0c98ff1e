//! Noise on values, told from what they do under refinement.
//!
//! Values of an iteration that is stopped early, of a statistical method or of a measurement carry an error that does not fall
//! with h. On fine grids it is all that differs: differences that change sign, of one size, at random. They may grow from grid
//! to grid, as those of a diverging method do, but by no law.

use super::{settled, towards, triplets};
use crate::measure::norm::Extremes;

/// Differences that have to be left over for noise: one alone has no sign to change.
const FEWEST: usize = 2;

/// Half the size of the noise on the finest of `points`, from fine to coarse, where the coarser ones converge by a power law:
/// the median of the differences that are left over, which change sign and are below those of the power law.
pub(super) fn amplitude(points: &[(f64, f64)], resolution: f64, band: f64) -> Option<f64> {
    let differences: Vec<f64> = points.windows(2).map(|pair| pair[0].1 - pair[1].1).collect();
    let is_settled = |points: &[(f64, f64)]| {
        let triplets = triplets(points, resolution);
        settled(&triplets, towards(&triplets, points), band / 2.0) > 1
    };
    let first = (0..points.len().saturating_sub(3)).find(|&first| is_settled(&points[first..]))?;
    let (left, law) = (differences.get(..first)?, differences.get(first)?.abs());
    let changes_sign = left.iter().any(|d| *d > 0.0) && left.iter().any(|d| *d < 0.0);
    if first < FEWEST || !changes_sign || left.iter().any(|d| d.abs() > law) {
        return None;
    }
    let mut sizes: Vec<f64> = left.iter().map(|d| d.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    Some(0.5 * sizes[first / 2])
}

/// Whether differences of `points`, from fine to coarse, which grow at every refinement, do so as those of a diverging method:
/// with one sign, at rates that agree to within `spread`, or at three refinements; or whatever their signs beyond the values on
/// all coarser grids.
///
/// Of values at random the three finest differences grow in 18 % of all sets, and with one sign in 1.4 %; a law by this
/// definition has 0.10 % of sets of four values, and 0.15 % of larger ones.
pub(super) fn grow_by_a_law(points: &[(f64, f64)], spread: f64) -> bool {
    let differences: Vec<f64> = points.windows(2).map(|pair| pair[0].1 - pair[1].1).collect();
    let spacing = |pair: &[(f64, f64)]| (pair[0].0 * pair[1].0).sqrt();
    let spacings: Vec<f64> = points.windows(2).map(spacing).collect();
    let rates =
        differences.windows(2).zip(spacings.windows(2)).map(|(d, h)| (d[0] / d[1]).abs().ln() / (h[1] / h[0]).ln());
    let (low, high) = rates.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let keeps_sign = differences.iter().all(|d| *d > 0.0) || differences.iter().all(|d| *d < 0.0);
    let largest = points[1..].iter().map(|point| point.1.abs()).largest();
    (keeps_sign && (differences.len() > 3 || high - low <= spread)) || differences[0].abs() > largest
}
