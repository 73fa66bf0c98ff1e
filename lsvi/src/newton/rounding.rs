//! Whether a residual that no iteration makes smaller is one of roundings.

use super::{ROUNDS, roundings};
use crate::linalg::{larger, max_norm};

/// Points to either side of x at which a residual is looked at in a row, and how many of their distances an increment has.
const POINTS: u32 = 4;
const PARTS: f64 = 8.0;
/// What F may be beside what roundings of x change it by, and beside what a row is off a line.
const BESIDE: [f64; 2] = [64.0, 16.0];
/// Evaluations that it takes.
pub(crate) const SAMPLES: u64 = (ROUNDS + 2 * POINTS + 2) as u64;

/// Tells roundings from a residual: an increment that is small beside the largest unknown may be large beside another.
///
/// F is 0 but for rounding where roundings of x change it by as much, in its max norm, or where it leaves the line through two of several points in a
/// row by as much at the next: roundings of a large term stay what they are until a small x has changed it by one. Where increments grow by curvature a
/// part 1/8 of them makes F leave that line by 2/8² of its value, and sixteen times that is no more than half of it.
#[derive(Debug, Default)]
pub(crate) struct Rounding {
    value: Vec<f64>,
    /// F at the last three points.
    row: [Vec<f64>; 3],
    point: Vec<f64>,
}

impl Rounding {
    /// Whether what `f` writes at `x` are roundings, after increments of which the last one, along `way`, is no shorter than the one before, of
    /// size `last`.
    #[cold]
    pub(crate) fn explains(
        &mut self,
        f: &mut dyn FnMut(&[f64], &mut [f64]),
        x: &[f64],
        way: &[f64],
        last: f64,
    ) -> bool {
        let n = x.len();
        let Self { value, row, point } = self;
        [&mut *value, &mut *point].into_iter().chain(&mut *row).for_each(|v| v.resize(n, 0.0));
        f(x, value);
        let (mut noise, mut bend) = (0.0, 0.0);
        for round in 0..ROUNDS {
            point.iter_mut().zip(x).enumerate().for_each(|(i, (p, x))| *p = x * (1.0 + roundings(i, round)));
            f(point, &mut row[0]);
            noise = row[0].iter().zip(&*value).fold(noise, |noise, (beside, value)| larger(noise, beside - value));
        }
        let part = last / max_norm(way) / PARTS;
        for k in 0..=2 * POINTS {
            row.rotate_left(1);
            let at = part * (f64::from(k) - f64::from(POINTS));
            point.iter_mut().zip(x.iter().zip(way)).for_each(|(p, (x, d))| *p = x + at * d);
            f(point, &mut row[2]);
            if k >= 2 {
                bend = (0..n).fold(bend, |bend, i| larger(bend, row[0][i] - 2.0 * row[1][i] + row[2][i]));
            }
        }
        max_norm(value) <= larger(BESIDE[0] * noise, BESIDE[1] * bend)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn explains(f: impl Fn(f64) -> f64, x: f64, way: f64, last: f64) -> bool {
        Rounding::default().explains(&mut |x, out| out[0] = f(x[0]), &[x], &[way], last)
    }

    /// What is left of 3x = 1 in double precision; and of 1 + x² − 1 − 10⁻¹⁶, which an x of 10⁻⁴ changes in steps.
    #[test]
    fn what_rounding_leaves_is_told_by_the_points_beside() {
        assert!(explains(|x| 3.0 * x - 1.0 + f64::EPSILON, 1.0 / 3.0, 1e-16, 1e-16));
        let stepped = |x: f64| (1.0 + x * x) - (1.0 + 1e-8) - 1e-16;
        assert!(stepped(1e-4).abs() >= 1e-16 && explains(stepped, 1e-4, 4e-12, 4e-12));
    }

    /// Of a last increment of 4 an eighth is ½.
    #[test]
    fn a_residual_is_looked_at_to_either_side_by_eighths_of_the_last_increment() {
        let mut points = Vec::new();
        let mut f = |x: &[f64], out: &mut [f64]| {
            points.push(x[0]);
            out[0] = x[0];
        };
        Rounding::default().explains(&mut f, &[10.0], &[0.25], 4.0);
        assert_eq!(points.len() as u64, SAMPLES);
        let mut row = points.split_off(1 + ROUNDS as usize);
        row.sort_by(f64::total_cmp);
        assert_eq!(row, [8.0, 8.5, 9.0, 9.5, 10.0, 10.5, 11.0, 11.5, 12.0]);
        assert!(points.iter().all(|x| (x - 10.0).abs() <= 41.0 * f64::EPSILON), "{points:?}");
    }

    /// x/(x + 1) = 2, of which the increment from −5 is 12 long; and 1 + x² = 0, in which the increment from 0.3 is 1.8 and from there −0.4: in any unit.
    #[test]
    fn increments_that_grow_by_curvature_are_no_roundings() {
        for scale in [1.0, 1e-8] {
            let f = |x: f64| x / (x + scale) - 2.0;
            assert!(!explains(f, -5.0 * scale, 12.0 * scale, 2.0 * scale), "{scale}");
            let f = |x: f64| 1.0 + (x / scale).powi(2);
            assert!(!explains(f, 0.3 * scale, 1.8 * scale, 0.4 * scale), "{scale}");
        }
    }
}
