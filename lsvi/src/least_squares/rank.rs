//! Whether the condition of a step determines the residual, of closures whose α + β vanishes as h → 0.
//!
//! As h → 0 their condition is KᵀM⁻¹(r₀ + r₁) = 0 with K = 2(α + β)/h M + (α − β) J, for Method II −2J. Along a left null vector of K the
//! residual is free, and with it the step: v₁ is what the curvature of f and roundings make of it.

use crate::discrete::MomentumWeights;
use crate::linalg::{Jacobian, NumericalRank, ROUNDINGS, Structure};
use crate::mass::Mass;

/// Whether each component of f is the rounding of its own terms, those of J v, as in a state of rest, whatever the units; into `terms`, the
/// size of these.
pub(super) fn is_at_rest(f: &[f64], jacobian: &Jacobian, v: &[f64], terms: &mut [f64]) -> bool {
    terms.fill(0.0);
    jacobian.for_each(|i, j, x| terms[i] += (x * v[j]).abs());
    f.iter().zip(terms).all(|(f, terms)| f.abs() <= ROUNDINGS * f64::EPSILON * *terms)
}

/// K with its work space.
#[derive(Debug)]
pub(super) struct Rank {
    matrix: Jacobian,
    rank: NumericalRank,
}

impl Rank {
    pub(super) fn new(dim: usize, structure: &Structure) -> Self {
        Self { matrix: Jacobian::with_structure(dim, structure), rank: NumericalRank::new(dim, structure) }
    }

    /// Whether K is singular to the roundings of its entries.
    pub(super) fn is_deficient(&mut self, mass: &Mass, weights: MomentumWeights, h: f64, jacobian: &Jacobian) -> bool {
        let Self { matrix, rank } = self;
        matrix.clear();
        mass.add_to(2.0 * (weights.alpha + weights.beta) / h, matrix);
        jacobian.for_each(|i, j, x| matrix.add(i, j, (weights.alpha - weights.beta) * x));
        rank.is_deficient(matrix, matrix)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn diagonal(entries: &[f64]) -> Jacobian {
        let mut matrix = Jacobian::zeros(entries.len());
        entries.iter().enumerate().for_each(|(i, x)| matrix.add(i, i, *x));
        matrix
    }

    /// K = 2(α + β)/h M + (α − β) J, with a second component in a unit of its own.
    #[test]
    fn the_condition_is_open_where_its_limit_is_singular() {
        let deficient = |alpha: f64, beta: f64, h: f64, own: f64| {
            let mass = Mass::Diagonal(vec![2.0, 1e-200]);
            Rank::new(2, &Structure::Dense).is_deficient(
                &mass,
                MomentumWeights { alpha, beta },
                h,
                &diagonal(&[own, -1e-200]),
            )
        };
        // −2J of Method II.
        assert_eq!([0.0, 1e-9, 1.0].map(|own| deficient(-1.0, 1.0, 0.1, own)), [true, false, false]);
        // 8 − 2J.
        assert_eq!([0.0, 4.0, 4.0 + 1e-9].map(|own| deficient(-0.5, 1.5, 0.5, own)), [false, true, false]);
    }

    /// The inverse of (1 1; 1 1 + d) is 2/d to the size of d, and so it is where the second component has a unit of its own.
    #[test]
    fn rows_that_are_alike_to_roundings_are_not_two_conditions() {
        let deficient = |d: f64, unit: f64| {
            let mut jacobian = Jacobian::zeros(2);
            let entries = [(0, 0, 1.0), (0, 1, unit), (1, 0, 1.0), (1, 1, (1.0 + d) * unit)];
            entries.into_iter().for_each(|(i, j, x)| jacobian.add(i, j, x));
            let weights = MomentumWeights { alpha: -1.0, beta: 1.0 };
            Rank::new(2, &Structure::Dense).is_deficient(&Mass::Identity, weights, 0.1, &jacobian)
        };
        for unit in [1.0, 1e20, 1e-20] {
            assert_eq!([0.0, 1e-14, 1e-12, 1.0].map(|d| deficient(d, unit)), [true, true, false, false], "{unit}");
        }
    }

    /// Each component beside its own terms, and not beside another's.
    #[test]
    fn rest_is_a_matter_of_each_component() {
        let (jacobian, mut terms) = (diagonal(&[1.0, 1.0]), [0.0; 2]);
        let mut rests = |f: [f64; 2]| is_at_rest(&f, &jacobian, &[1e10, 1.0], &mut terms);
        assert!(rests([1e10 * f64::EPSILON, f64::EPSILON]));
        assert!(!rests([0.0, 1e3 * f64::EPSILON]) && !rests([f64::NAN, 0.0]));
    }
}
