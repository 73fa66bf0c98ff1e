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
        // Solutions that overflow are those of a singular matrix.
        inverse.is_nan() || inverse * f64::EPSILON * ROUNDINGS >= 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(entries: [[f64; 2]; 2]) -> Jacobian {
        let mut matrix = Jacobian::zeros(2);
        (0..2).for_each(|i| (0..2).for_each(|j| matrix.add(i, j, entries[i][j])));
        matrix
    }

    /// What is left of terms that cancel counts beside these, row by row and column by column.
    #[test]
    fn entries_count_beside_what_cancelled_in_them() {
        let is_deficient = |entries: [[f64; 2]; 2], sizes: [[f64; 2]; 2]| {
            NumericalRank::new(2, &Structure::Dense).is_deficient(&matrix(entries), &matrix(sizes))
        };
        let roundings = ROUNDINGS * f64::EPSILON;
        for (left, expected) in [(0.5, true), (1.0, true), (1.5, false)] {
            let left = left * roundings;
            // (left, 0; 0, 1), its first term out of ones; then in units of which a row, or a column, has others.
            assert_eq!(is_deficient([[left, 0.0], [0.0, 1.0]], [[1.0, 0.0], [0.0, 1.0]]), expected);
            assert_eq!(is_deficient([[left * 1e200, 0.0], [0.0, 1.0]], [[1e200, 0.0], [0.0, -1.0]]), expected);
            assert_eq!(is_deficient([[left * 1e-200, 0.0], [0.0, 1.0]], [[1e-200, 1.0], [0.0, 1.0]]), expected);
            assert!(!is_deficient([[left, 0.0], [0.0, 1.0]], [[left, 0.0], [0.0, 1.0]]));
        }
        // The inverse has 1e200 left, and its square no number.
        assert!(is_deficient([[1e-200, 1.0], [0.0, 1.0]], [[1.0, 1.0], [0.0, 1.0]]));
        // A component that no condition has, and a condition without components.
        assert!(is_deficient([[1.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [1.0, 0.0]]));
        assert!(is_deficient([[1.0, 1.0], [0.0, 0.0]], [[1.0, 1.0], [0.0, 0.0]]));
        // What is not finite is no rank.
        assert!(!is_deficient([[f64::NAN, 0.0], [0.0, 1.0]], [[1.0, 0.0], [0.0, 1.0]]));
    }
}
