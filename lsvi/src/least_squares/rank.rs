//! Whether the condition of a step determines the residual, of closures whose α + β vanishes as h → 0.
//!
//! As h → 0 their condition is Kᵀ(r₀ + r₁) = 0 with K = 2(α + β)/h M + (α − β) J, for Method II −2J. Along a left null vector of K the
//! residual is free, and with it the step: v₁ is what the curvature of f and roundings make of it.

use crate::discrete::MomentumWeights;
use crate::linalg::{FactorError, Jacobian, Lu, Structure, inverse_norm};
use crate::mass::Mass;

/// Roundings in an entry of J, which may be a sum of terms that cancel.
const ROUNDINGS: f64 = 256.0;

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
    scaled: Jacobian,
    lu: Lu,
    rows: Vec<f64>,
    columns: Vec<f64>,
    work: [Vec<f64>; 2],
}

impl Rank {
    pub(super) fn new(dim: usize, structure: &Structure) -> Self {
        let matrix = Jacobian::with_structure(dim, structure);
        let zeros = || vec![0.0; dim];
        Self {
            scaled: matrix.clone(),
            lu: Lu::of(&matrix),
            matrix,
            rows: zeros(),
            columns: zeros(),
            work: [zeros(), zeros()],
        }
    }

    /// Whether K is singular to the roundings of its entries, whatever the units of components and equations: with rows and columns of
    /// size 1.
    pub(super) fn is_deficient(&mut self, mass: &Mass, weights: MomentumWeights, h: f64, jacobian: &Jacobian) -> bool {
        let Self { matrix, scaled, lu, rows, columns, work } = self;
        matrix.clear();
        mass.add_to(2.0 * (weights.alpha + weights.beta) / h, matrix);
        jacobian.for_each(|i, j, x| matrix.add(i, j, (weights.alpha - weights.beta) * x));
        rows.fill(0.0);
        matrix.for_each(|i, _, x| rows[i] = rows[i].max(x.abs()));
        columns.fill(0.0);
        matrix.for_each(|i, j, x| columns[j] = columns[j].max(x.abs() / rows[i]));
        if rows.iter().chain(columns.iter()).any(|size| *size == 0.0) {
            return true;
        }
        scaled.clear();
        matrix.for_each(|i, j, x| scaled.add(i, j, x / (rows[i] * columns[j])));
        match lu.factor(scaled) {
            Ok(()) => {}
            Err(error) => return error == FactorError::Singular,
        }
        // ‖(K Kᵀ)⁻¹‖, of which the root is that of K⁻¹.
        let solve = |x: &mut [f64]| {
            lu.solve(x);
            lu.solve_transpose(x);
        };
        let inverse = inverse_norm(solve, work).sqrt();
        inverse * f64::EPSILON * ROUNDINGS >= 1.0
    }
}
