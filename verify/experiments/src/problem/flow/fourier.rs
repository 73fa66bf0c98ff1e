//! Transforms between the Fourier coefficients of real fields and their values on a periodic grid.

use std::f64::consts::{PI, SQRT_2};
use std::fmt;
use std::sync::Arc;

use nalgebra::Complex;
use rustfft::{Fft, FftPlanner};

/// A wave number k = (k_x, k_y).
pub(super) type Wave = [i32; 2];

/// Real fields on the square [0, 2π)² with wave numbers up to K in each direction, and without a mean.
///
/// A field is Σ_k √2 (c_k cos k·x + s_k sin k·x) over one wave number of each pair ±k, and its coefficients are
/// (c₁, s₁, c₂, s₂, …): an orthonormal basis, in which the sum of squares is the mean square. With K < n/3 products of two
/// fields on the grid of n² points have exact coefficients up to K (Orszag's rule).
pub(super) struct Modes {
    pub(super) points: usize,
    pub(super) waves: Vec<Wave>,
    /// Where the coefficients of k and −k are in a transposed array of n² of them.
    places: Vec<[usize; 2]>,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
}

impl fmt::Debug for Modes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Modes").field("points", &self.points).field("waves", &self.waves.len()).finish_non_exhaustive()
    }
}

/// Work space of the transforms: two arrays of n², and what a row needs.
#[derive(Debug)]
pub(super) struct Buffers {
    array: Vec<Complex<f64>>,
    transposed: Vec<Complex<f64>>,
    row: Vec<Complex<f64>>,
}

impl Modes {
    pub(super) fn new(points: usize) -> Self {
        let most = largest(points);
        let half = (0..=most).flat_map(|k| (-most..=most).map(move |l| [k, l]));
        let waves: Vec<Wave> = half.filter(|[k, l]| *k > 0 || *l > 0).collect();
        let index = |k: i32| k.rem_euclid(points as i32) as usize;
        let place = |[k, l]: Wave| index(k) * points + index(l);
        let mut planner = FftPlanner::new();
        Self {
            places: waves.iter().map(|&[k, l]| [place([k, l]), place([-k, -l])]).collect(),
            forward: planner.plan_fft_forward(points),
            inverse: planner.plan_fft_inverse(points),
            points,
            waves,
        }
    }

    /// Number of coefficients.
    pub(super) fn dim(&self) -> usize {
        2 * self.waves.len()
    }

    pub(super) fn buffers(&self) -> Buffers {
        let zero = Complex::new(0.0, 0.0);
        let row = self.forward.get_inplace_scratch_len().max(self.inverse.get_inplace_scratch_len());
        let array = vec![zero; self.points * self.points];
        Buffers { transposed: array.clone(), array, row: vec![zero; row] }
    }

    /// The grid points along a side.
    pub(super) fn coordinates(&self) -> impl Iterator<Item = f64> {
        let n = self.points;
        (0..n).map(move |i| 2.0 * PI * i as f64 / n as f64)
    }

    /// The rows of a transposed array in which there are wave numbers, two thirds of them.
    fn rows_with_modes<'b>(&self, array: &'b mut [Complex<f64>]) -> [&'b mut [Complex<f64>]; 2] {
        let most = largest(self.points) as usize;
        let (below, above) = array.split_at_mut((self.points - most) * self.points);
        [&mut below[..(most + 1) * self.points], above]
    }

    /// Writes the values of two fields, row by row in y, from functions of (k, coefficient pair) that give their complex
    /// coefficients at k.
    pub(super) fn values(
        &self,
        coefficients: impl Fn(usize, Wave) -> [Complex<f64>; 2],
        b: &mut Buffers,
        [first, second]: [&mut [f64]; 2],
    ) {
        b.array.fill(Complex::new(0.0, 0.0));
        for (m, (wave, [plus, minus])) in self.waves.iter().zip(&self.places).enumerate() {
            // One complex array holds both: the first as its real part, the second as its imaginary part.
            let [p, q] = coefficients(m, *wave);
            b.array[*plus] = p + q * Complex::i();
            b.array[*minus] = p.conj() + q.conj() * Complex::i();
        }
        self.rows_with_modes(&mut b.array)
            .into_iter()
            .for_each(|rows| self.inverse.process_with_scratch(rows, &mut b.row));
        transpose(self.points, &b.array, &mut b.transposed);
        self.inverse.process_with_scratch(&mut b.transposed, &mut b.row);
        for ((z, first), second) in b.transposed.iter().zip(first).zip(second) {
            (*first, *second) = (z.re, z.im);
        }
    }

    /// Shows (m, k, coefficients at k) of two fields, from their values, to `visit`.
    pub(super) fn coefficients(
        &self,
        values: impl Iterator<Item = [f64; 2]>,
        b: &mut Buffers,
        mut visit: impl FnMut(usize, Wave, [Complex<f64>; 2]),
    ) {
        for (z, [first, second]) in b.array.iter_mut().zip(values) {
            *z = Complex::new(first, second);
        }
        self.forward.process_with_scratch(&mut b.array, &mut b.row);
        transpose(self.points, &b.array, &mut b.transposed);
        let rows = self.rows_with_modes(&mut b.transposed);
        rows.into_iter().for_each(|rows| self.forward.process_with_scratch(rows, &mut b.row));
        let scale = 1.0 / (self.points * self.points) as f64;
        for (m, (wave, [plus, minus])) in self.waves.iter().zip(&self.places).enumerate() {
            let (p, q) = (b.transposed[*plus] * scale, b.transposed[*minus].conj() * scale);
            visit(m, *wave, [(p + q) * 0.5, (p - q) * Complex::new(0.0, -0.5)]);
        }
    }
}

/// K for `points` grid points along a side.
fn largest(points: usize) -> i32 {
    (points as i32 - 1) / 3
}

/// The complex coefficient of e^{ik·x} of mode m.
pub(super) fn complex(v: &[f64], m: usize) -> Complex<f64> {
    Complex::new(v[2 * m], -v[2 * m + 1]) / SQRT_2
}

/// Adds a complex coefficient to mode m.
pub(super) fn add(v: &mut [f64], m: usize, z: Complex<f64>) {
    v[2 * m] += SQRT_2 * z.re;
    v[2 * m + 1] -= SQRT_2 * z.im;
}

fn transpose(n: usize, from: &[Complex<f64>], to: &mut [Complex<f64>]) {
    const BLOCK: usize = 16;
    for rows in (0..n).step_by(BLOCK) {
        for columns in (0..n).step_by(BLOCK) {
            for i in rows..(rows + BLOCK).min(n) {
                for j in columns..(columns + BLOCK).min(n) {
                    to[j * n + i] = from[i * n + j];
                }
            }
        }
    }
}
