//! Whether errors that seem to have another order are those of the expected one, before its leading term stands alone.
//!
//! e = C hᵖ(1 + a h + b h² + …) has local slopes that may stand still for a while, where two terms balance. A window that ends
//! at a floor may show no more than that. The expected order p with two terms, ln e = c + p ln h + α h + β h², is compared with
//! any order q with one, ln e = c + q ln h + α h: three parameters each.

use nalgebra::{DMatrix, DVector};

use super::{LogPoint, weights};

/// A wrong order leaves residuals at least this many times as large as the right one: either has terms that are left out, and
/// those of one of them are not the larger by chance alone.
const WORSE: f64 = 2.0;

/// Whether the expected `order` explains the points: to within their floors, or no worse than another order does.
pub(super) fn explains(order: f64, points: &[LogPoint], settle: f64) -> bool {
    let weight = weights(points, settle);
    let expected = residuals(points, &weight, |h, _| [1.0, h, h * h], |p| p.y - order * p.x);
    let within = points.iter().zip(&expected).all(|(p, residual)| residual.abs() <= p.u);
    let size = |residuals: &[f64]| {
        points.iter().zip(residuals).map(|(p, residual)| weight(p) * residual * residual).sum::<f64>().sqrt()
    };
    let other = residuals(points, &weight, |h, x| [1.0, x, h], |p| p.y);
    within || size(&expected) <= WORSE * size(&other)
}

/// What the weighted least-squares fit of three `columns` of (h, ln h) leaves of `value`. Steps count in units of the coarsest.
fn residuals(
    points: &[LogPoint],
    weight: &impl Fn(&LogPoint) -> f64,
    columns: impl Fn(f64, f64) -> [f64; 3],
    value: impl Fn(&LogPoint) -> f64,
) -> Vec<f64> {
    let row = |p: &LogPoint| columns((p.x - points[0].x).exp(), p.x - points[0].x);
    let matrix = DMatrix::from_fn(points.len(), 3, |i, j| row(&points[i])[j]);
    let values = DVector::from_iterator(points.len(), points.iter().map(value));
    let roots = DVector::from_iterator(points.len(), points.iter().map(|p| weight(p).sqrt()));
    let weighted = DMatrix::from_fn(points.len(), 3, |i, j| roots[i] * matrix[(i, j)]);
    // Rank is never lost to zero tolerance: a column that says nothing gets no weight in the residual either.
    let Ok(solution) = weighted.svd(true, true).solve(&values.component_mul(&roots), 0.0) else {
        return vec![f64::NAN; points.len()];
    };
    (values - matrix * solution).iter().copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points whose residuals with the order expected are `ratio` times those with another one: the part of ln h that no even remainder
    /// explains, and a part that neither explains.
    fn points(order: f64, ratio: f64) -> Vec<LogPoint> {
        let h: Vec<f64> = (0..7).map(|k| 0.7_f64.powi(k)).collect();
        let columns = |of: &[fn(f64) -> f64]| {
            DMatrix::from_fn(h.len(), of.len(), |i, j| of[j](h[i])).svd(true, false).u.expect("asked for")
        };
        type Column = fn(f64) -> f64;
        let [one, x, square]: [Column; 3] = [|_| 1.0, f64::ln, |h| h * h];
        let log = DVector::from_iterator(h.len(), h.iter().map(|h| h.ln()));
        let without = |basis: &DMatrix<f64>, y: &DVector<f64>| y - basis * (basis.transpose() * y);
        let of_expected = without(&columns(&[one, |h| h, square]), &log);
        let irregular = DVector::from_fn(h.len(), |i, _| if i % 2 == 0 { 1.0 } else { -1.0 });
        let of_neither = without(&columns(&[one, |h| h, square, x]), &irregular).normalize();
        let part = (ratio * ratio - 1.0).sqrt() / of_expected.norm();
        let y = |i: usize| (order + 1e-3 * part) * log[i] + 1e-3 * of_neither[i];
        (0..h.len()).map(|i| LogPoint { x: log[i], y: y(i), u: 1e-9 }).collect()
    }

    #[test]
    fn an_order_explains_what_no_other_explains_twice_as_well() {
        for order in [1.0, 2.0, 4.0] {
            assert!(explains(order, &points(order, 1.9), 0.1), "order {order}");
            assert!(!explains(order, &points(order, 2.1), 0.1), "order {order}");
        }
    }
}
