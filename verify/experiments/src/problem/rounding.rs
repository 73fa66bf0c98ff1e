//! What roundings are to f, whose terms may cancel.

use super::changes::GOLDEN;
use crate::measure::norm::larger;

/// Roundings by which the components of a state are changed, up or down.
const ROUNDINGS: f64 = 8.0;
/// Choices of who goes up and who down.
const CHOICES: usize = 4;

/// What each component of f changes by where those of the state change by a few roundings each: of a component that vanishes by symmetry all that
/// there is of it.
pub fn rounding(mut f: impl FnMut(&[f64], &mut [f64]), v: &[f64], n: usize) -> Vec<f64> {
    let (mut here, mut there, mut most) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    f(v, &mut here);
    for choice in 1..=CHOICES {
        // Irregular, lest a symmetry is kept.
        let is_up = |k: usize| ((k + 1) as f64 * choice as f64 * GOLDEN).fract() < 0.5;
        let part = |k: usize| if is_up(k) { ROUNDINGS } else { -ROUNDINGS } * f64::EPSILON;
        let beside: Vec<f64> = v.iter().enumerate().map(|(k, x)| x + part(k) * x).collect();
        f(&beside, &mut there);
        most.iter_mut().zip(here.iter().zip(&there)).for_each(|(most, (a, b))| *most = larger(*most, (b - a).abs()));
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x − y vanishes where x = y = 1, to 8 + 8 roundings where one goes up and the other down; 3 z has 24 of its own.
    #[test]
    fn what_cancels_has_the_roundings_of_its_terms() {
        let found = rounding(|v, f| f.copy_from_slice(&[v[0] - v[1], 3.0 * v[2]]), &[1.0, 1.0, 1e-9], 2);
        assert_eq!(found[0], 16.0 * f64::EPSILON);
        assert!((found[1] / (24e-9 * f64::EPSILON) - 1.0).abs() < 0.1, "{found:?}");
    }

    /// Of any three components two go the same way in one choice.
    #[test]
    fn what_one_choice_leaves_cancelled_another_shows() {
        for [i, j] in [[0, 1], [0, 2], [1, 2]] {
            assert_eq!(rounding(|v, f| f[0] = v[i] - v[j], &[1.0; 3], 1), [16.0 * f64::EPSILON], "{i} {j}");
        }
    }
}
