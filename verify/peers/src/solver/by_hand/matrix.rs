//! Factors of s − J for one structure of J each, of real and of complex s.

use lsvi::nalgebra::{Complex, ComplexField};

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

    /// Factors for a real and a complex shift.
    fn factor_both(
        &self,
        (shift, out): (f64, &mut Self::Factors<f64>),
        (complex, complex_out): (Complex<f64>, &mut Self::Factors<Complex<f64>>),
    ) -> bool {
        self.factor(shift, out) && self.factor(complex, complex_out)
    }

    /// Overwrites a right-hand side by the solution.
    fn solve<T: Entry>(factors: &Self::Factors<T>, x: &mut [T; N]);

    /// Solves with the factors of both.
    fn solve_both(
        (real, x): (&Self::Factors<f64>, &mut [f64; N]),
        (complex, y): (&Self::Factors<Complex<f64>>, &mut [Complex<f64>; N]),
    ) {
        Self::solve(real, x);
        Self::solve(complex, y);
    }
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
        let mut last = Eliminated::nothing();
        (0..N).all(|i| last.step(self, i, shift, &mut out[i]))
    }

    /// Side by side: a row waits for the one before, and less for that of the other matrix.
    fn factor_both(
        &self,
        (shift, out): (f64, &mut Self::Factors<f64>),
        (complex, complex_out): (Complex<f64>, &mut Self::Factors<Complex<f64>>),
    ) -> bool {
        let (mut first, mut second) = (Eliminated::nothing(), Eliminated::nothing());
        (0..N).all(|i| first.step(self, i, shift, &mut out[i]) && second.step(self, i, complex, &mut complex_out[i]))
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

    fn solve_both(
        (real, x): (&Self::Factors<f64>, &mut [f64; N]),
        (complex, y): (&Self::Factors<Complex<f64>>, &mut [Complex<f64>; N]),
    ) {
        let (mut a, mut b) = (0.0, Complex::new(0.0, 0.0));
        for i in 0..N {
            a = x[i] - real[i][0] * a;
            b = y[i] - complex[i][0] * b;
            (x[i], y[i]) = (a, b);
        }
        let (mut a, mut b) = (0.0, Complex::new(0.0, 0.0));
        for i in (0..N).rev() {
            a = (x[i] - real[i][2] * a) * real[i][1];
            // What is above the diagonal is real.
            b = (y[i] - b * complex[i][2].re) * complex[i][1];
            (x[i], y[i]) = (a, b);
        }
    }
}

/// The last row of an elimination: one over its pivot, and the entry right of that.
struct Eliminated<T> {
    inverse: T,
    above: f64,
}

impl<T: Entry> Eliminated<T> {
    fn nothing() -> Self {
        Self { inverse: T::zero(), above: 0.0 }
    }

    #[inline(always)]
    fn step<const N: usize>(&mut self, a: &Tridiagonal<N>, i: usize, shift: T, out: &mut [T; 3]) -> bool {
        let [lower, main, upper] = &a.diagonals;
        let multiplier = self.inverse * T::from_real(-lower[i]);
        let pivot = shift - T::from_real(main[i]) - multiplier * T::from_real(self.above);
        if pivot == T::zero() {
            return false;
        }
        (self.inverse, self.above) = (pivot.recip(), -upper[i]);
        *out = [multiplier, self.inverse, T::from_real(self.above)];
        true
    }
}
