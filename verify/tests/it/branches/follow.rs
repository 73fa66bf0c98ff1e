//! The branch of roots that starts at the present state, proved piece by piece: on each piece of s Krawczyk's operator maps a box into
//! itself, so that for every s there the box holds one root and no other, and the box of the next piece holds that of the last s.

use nalgebra::DMatrix;
use verify::judge::real::Real;
use verify::measure::norm::larger;

use super::action::{Equations, inverse};

/// Where the branch leads for a given step size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Followed {
    /// To this value at the end, which rounding in double precision may miss by this much.
    To(f64, f64),
    /// It ends in a fold, meets another branch, or leaves for infinity at this smaller step size.
    Lost(f64),
    /// It ends within a millionth of the step size, or could be followed to this smaller one only.
    Undecided(f64),
}

/// Relative length of a piece that is taken for the end of the branch. A fold is approached in pieces in proportion to the distance,
/// so that its distance is far below the millionth that is left undecided.
const SHORTEST: f64 = 1e-10;
/// Relative size of the last increment of Newton's iteration, whose error is of the size of its square.
const SETTLED: f64 = 1e-9;

/// Pieces after which a path is given up; one to a fold and beyond takes some hundred.
const MOST_PIECES: usize = 1000;

/// Follows the branch to each of the step sizes, which increase.
pub(crate) fn follow(equations: &Equations, sizes: &[f64]) -> Vec<Followed> {
    let scale = equations.start.abs();
    let (mut s, mut at) = (0.0, equations.origin());
    let mut piece = 1e-3 * sizes[0];
    let mut found = Vec::new();
    let mut pieces = 0;
    while let Some(&wanted) = sizes.get(found.len()) {
        pieces += 1;
        if pieces > MOST_PIECES {
            found.resize(sizes.len(), Followed::Undecided(s));
            break;
        }
        let target = wanted.min(s + piece);
        match advance(equations, s, target, &at) {
            Some(next) => {
                (s, at) = (target, next);
                piece *= 1.5;
            }
            None => piece = 0.5 * piece.min(target - s),
        }
        if s == wanted {
            found.push(result(equations, s, &at));
        }
        let end = at.last().map_or(f64::NAN, |x| x.to_f64().abs());
        if piece < SHORTEST * s.max(1e-3 * sizes[0]) || end > 1e12 * scale {
            let rest = sizes[found.len()..].iter();
            found.extend(
                rest.map(|size| if *size > (1.0 + 1e-6) * s { Followed::Lost(s) } else { Followed::Undecided(s) }),
            );
        }
    }
    found
}

/// The enclosure of the root at `target`, proved to be on the branch of the one `at` s.
fn advance(equations: &Equations, s: f64, target: f64, at: &[Real]) -> Option<Vec<Real>> {
    let n = at.len();
    let middle = Real::double(0.5 * (s + target));
    let (centre, y) = newton(equations, &middle, at)?;
    // The whole piece, the rounding of its middle included.
    let piece = middle.widened(0.5 * (target - s) * (1.0 + 1e-9) + 1e-15 * target);
    let g = equations.at(&piece, &centre).0;
    let reach = |i: usize, from: &Real| {
        let step: f64 = (0..n).map(|j| y[(i, j)].abs() * largest(&g[j])).sum();
        1.5 * step.max(largest(&(from - &centre[i])))
    };
    let whole = Cell { radii: at.iter().enumerate().map(|(i, from)| reach(i, from)).collect(), centre };
    let image = whole.image(equations, &piece, &g, &y);
    let end = Real::double(target);
    let (next, y) = newton(equations, &end, &whole.centre)?;
    let size = next.iter().map(largest).fold(equations.start.abs(), larger);
    let tiny = Cell { radii: vec![10.0 * SETTLED * size; n], centre: next };
    let enclosure = tiny.image(equations, &end, &equations.at(&end, &tiny.centre).0, &y);
    let is_proved = whole.holds(&image) && whole.holds(at) && tiny.holds(&enclosure) && whole.holds(&enclosure);
    is_proved.then_some(enclosure)
}

/// The largest modulus of a number in a ball.
fn largest(ball: &Real) -> f64 {
    ball.to_f64().abs() + ball.radius()
}

/// A box of unknowns.
struct Cell {
    centre: Vec<Real>,
    radii: Vec<f64>,
}

impl Cell {
    /// Whether all of `inner` lies inside.
    fn holds(&self, inner: &[Real]) -> bool {
        let boxes = self.centre.iter().zip(&self.radii);
        inner.iter().zip(boxes).all(|(inner, (centre, radius))| largest(&(inner - centre)) < *radius)
    }

    /// Krawczyk's m − Y g(m) + (1 − Y g′(X)) (X − m) for this box X round m, where `g` is g(m).
    fn image(&self, equations: &Equations, s: &Real, g: &[Real], y: &DMatrix<f64>) -> Vec<Real> {
        let n = g.len();
        let wide: Vec<Real> = self.centre.iter().zip(&self.radii).map(|(m, r)| m.widened(*r)).collect();
        let jacobian = equations.at(s, &wide).1;
        let y = |i: usize, j: usize| Real::double(y[(i, j)]);
        let image = (0..n).map(|i| {
            let step: Real = (0..n).map(|j| &y(i, j) * &g[j]).sum();
            let rest = (0..n).map(|k| {
                let product: Real = (0..n).map(|j| &y(i, j) * &jacobian[j][k]).sum();
                &(&Real::from(i64::from(i == k)) - &product) * &Real::zero().widened(self.radii[k])
            });
            &(&self.centre[i] - &step) + &rest.sum()
        });
        image.collect()
    }
}

/// Newton's iteration from near by, without uncertainty, with the inverse of its last derivative; what it finds is proved by others.
fn newton(equations: &Equations, s: &Real, from: &[Real]) -> Option<(Vec<Real>, DMatrix<f64>)> {
    let mut x: Vec<Real> = from.iter().map(Real::centre).collect();
    for _ in 0..12 {
        let (g, jacobian, _) = equations.at(s, &x);
        let y = inverse(&jacobian)?;
        let step = |i: usize| (0..x.len()).map(|j| &Real::double(y[(i, j)]) * &g[j]).sum::<Real>();
        let steps: Vec<Real> = (0..x.len()).map(step).collect();
        x = x.iter().zip(&steps).map(|(x, d)| (x - d).centre()).collect();
        let size = x.iter().map(largest).fold(equations.start.abs(), larger);
        let moved = steps.iter().map(largest).fold(0.0, larger);
        if moved.is_nan() || moved > 10.0 * size {
            return None;
        }
        if moved < SETTLED * size {
            return Some((x, y));
        }
    }
    None
}

/// What a step in double precision may find: each sum over the nodes has a few dozen roundings of its terms, and an error of the
/// equations moves the end by the last row of the inverse.
fn result(equations: &Equations, s: f64, at: &[Real]) -> Followed {
    const ROUNDINGS: f64 = 64.0;
    let (_, jacobian, moduli) = equations.at(&Real::double(s), at);
    let (Some(y), Some(end)) = (inverse(&jacobian), at.last()) else { return Followed::Undecided(s) };
    let last = at.len() - 1;
    let error = (0..at.len()).map(|j| y[(last, j)].abs() * moduli[j]).sum::<f64>() + end.to_f64().abs();
    Followed::To(end.to_f64(), ROUNDINGS * f64::EPSILON * error + end.radius())
}

/// The only root of affine equations, where f is linear.
pub(crate) fn only_root(equations: &Equations, s: f64) -> Followed {
    let size = Real::double(s);
    newton(equations, &size, &equations.origin())
        .map_or(Followed::Undecided(s), |(root, _)| result(equations, s, &root))
}
