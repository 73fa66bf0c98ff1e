//! Whether a matrix is singular to the roundings of its entries.

use super::{FactorError, Jacobian, Lu, Structure, inverse_norm};

/// Roundings in an entry, which may be a sum of terms that cancel.
pub(crate) const ROUNDINGS: f64 = 256.0;

/// Work space for matrices of one order and structure.
#[derive(Debug)]
pub(crate) struct NumericalRank {
    scaled: Jacobian,
    lu: Lu,
    rows: Vec<f64>,
    columns: Vec<f64>,
    work: [Vec<f64>; 2],
}

impl NumericalRank {
    pub(crate) fn new(dim: usize, structure: &Structure) -> Self {
        let scaled = Jacobian::with_structure(dim, structure);
        let zeros = || vec![0.0; dim];
        Self { lu: Lu::of(&scaled), scaled, rows: zeros(), columns: zeros(), work: [zeros(), zeros()] }
    }

    /// Whether `matrix` is singular to the roundings of entries of these `sizes`, whatever the units of unknowns and equations: with rows
    /// and columns of size 1.
    pub(crate) fn is_deficient(&mut self, matrix: &Jacobian, sizes: &Jacobian) -> bool {
        let Self { scaled, lu, rows, columns, work } = self;
        rows.fill(0.0);
        sizes.for_each(|i, _, x| rows[i] = rows[i].max(x.abs()));
        columns.fill(0.0);
        sizes.for_each(|i, j, x| columns[j] = columns[j].max(x.abs() / rows[i]));
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
