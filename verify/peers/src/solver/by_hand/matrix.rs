//! Factors of s − J for one structure of J each, of real and of complex s.

use lsvi::nalgebra::ComplexField;

/// An entry of a factor.
pub(crate) trait Entry: ComplexField<RealField = f64> + Copy {}
impl<T: ComplexField<RealField = f64> + Copy> Entry for T {}

/// A matrix of N rows.
pub(crate) trait Matrix<const N: usize> {
    /// All entries zero.
    const ZERO: Self;

    /// What solves systems with s − J.
    type Factors<T: Entry>;

    /// Factors of nothing yet.
    fn no_factors<T: Entry>() -> Self::Factors<T>;

    /// Adds to an entry.
    fn add(&mut self, i: usize, j: usize, x: f64);

    /// Factors `shift` − J; false where it is singular.
    fn factor<T: Entry>(&self, shift: T, out: &mut Self::Factors<T>) -> bool;

    /// Overwrites a right-hand side by the solution.
    fn solve<T: Entry>(factors: &Self::Factors<T>, x: &mut [T; N]);
}

/// All entries, with partial pivoting.
#[derive(Debug)]
pub(crate) struct Dense<const N: usize>([[f64; N]; N]);

impl<const N: usize> Matrix<N> for Dense<N> {
    const ZERO: Self = Self([[0.0; N]; N]);

    /// L below the reciprocal pivots and U, and the row that was exchanged with each.
    type Factors<T: Entry> = ([[T; N]; N], [usize; N]);

    fn no_factors<T: Entry>() -> Self::Factors<T> {
        ([[T::zero(); N]; N], [0; N])
    }

    fn add(&mut self, i: usize, j: usize, x: f64) {
        self.0[i][j] += x;
    }

    fn factor<T: Entry>(&self, shift: T, (a, exchanges): &mut Self::Factors<T>) -> bool {
        for i in 0..N {
            for j in 0..N {
                a[i][j] = T::from_real(-self.0[i][j]);
            }
            a[i][i] += shift;
        }
        for k in 0..N {
            let mut pivot = k;
            for i in k + 1..N {
                if a[i][k].norm1() > a[pivot][k].norm1() {
                    pivot = i;
                }
            }
            exchanges[k] = pivot;
            a.swap(k, pivot);
            if a[k][k] == T::zero() {
                return false;
            }
            a[k][k] = a[k][k].recip();
            for i in k + 1..N {
                let factor = a[i][k] * a[k][k];
                a[i][k] = factor;
                if factor != T::zero() {
                    for j in k + 1..N {
                        let above = a[k][j];
                        a[i][j] -= factor * above;
                    }
                }
            }
        }
        true
    }

    fn solve<T: Entry>((a, exchanges): &Self::Factors<T>, x: &mut [T; N]) {
        for k in 0..N {
            x.swap(k, exchanges[k]);
        }
        for i in 0..N {
            let mut sum = x[i];
            for j in 0..i {
                sum -= a[i][j] * x[j];
            }
            x[i] = sum;
        }
        for i in (0..N).rev() {
            let mut sum = x[i];
            for j in i + 1..N {
                sum -= a[i][j] * x[j];
            }
            x[i] = sum * a[i][i];
        }
    }
}

/// Three diagonals without pivoting, for J of which s − J is dominated by its diagonal.
#[derive(Debug)]
pub(crate) struct Tridiagonal<const N: usize> {
    /// J_{i, i−1}, J_{i, i} and J_{i, i+1}.
    diagonals: [[f64; N]; 3],
}

impl<const N: usize> Matrix<N> for Tridiagonal<N> {
    const ZERO: Self = Self { diagonals: [[0.0; N]; 3] };

    /// The multiplier of the row above, the reciprocal pivot and the entry above the next one.
    type Factors<T: Entry> = [[T; 3]; N];

    fn no_factors<T: Entry>() -> Self::Factors<T> {
        [[T::zero(); 3]; N]
    }

    fn add(&mut self, i: usize, j: usize, x: f64) {
        self.diagonals[j + 1 - i][i] += x;
    }

    fn factor<T: Entry>(&self, shift: T, out: &mut Self::Factors<T>) -> bool {
        let [lower, main, upper] = &self.diagonals;
        let (mut inverse, mut above) = (T::zero(), T::zero());
        for (i, out) in out.iter_mut().enumerate() {
            let multiplier = inverse * T::from_real(-lower[i]);
            let pivot = shift - T::from_real(main[i]) - multiplier * above;
            if pivot == T::zero() {
                return false;
            }
            (inverse, above) = (pivot.recip(), T::from_real(-upper[i]));
            *out = [multiplier, inverse, above];
        }
        true
    }

    fn solve<T: Entry>(factors: &Self::Factors<T>, x: &mut [T; N]) {
        let mut before = T::zero();
        for (x, [multiplier, ..]) in x.iter_mut().zip(factors) {
            *x -= *multiplier * before;
            before = *x;
        }
        let mut after = T::zero();
        for (x, [_, inverse, above]) in x.iter_mut().zip(factors).rev() {
            after = (*x - *above * after) * *inverse;
            *x = after;
        }
    }
}
