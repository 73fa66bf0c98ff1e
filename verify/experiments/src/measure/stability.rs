//! Growth factors of linear maps and recurrences, from their numbers.

use faer::Mat;
use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{Complex, DMatrix, Schur};

use crate::measure::blocks::irreducible_blocks;
use crate::measure::norm::Extremes;

/// Relative size of w₁² − w₀w₂ below which four terms are a geometric sequence: roundoff of steps, whose matrices have
/// condition numbers up to the square of 1e3 on the maps drawn here.
const GEOMETRIC: f64 = 1e-9;

/// The largest |ζ| such that ζⁿ is a solution of the shortest linear recurrence, of one or two terms, that gives w₀, …, w₃;
/// infinite where the terms overflow.
///
/// A one-step method gives wₙ = Rⁿ w₀. Two-step methods, and methods that carry a momentum, give wₙ₊₂ = a wₙ₊₁ + b wₙ with
/// two roots, of which a run may show only one for a long time: stability asks for both.
pub fn growth(w: [Complex<f64>; 4]) -> f64 {
    if w.iter().any(|w| !w.is_finite()) {
        return f64::INFINITY;
    }
    let determinant = w[1] * w[1] - w[0] * w[2];
    if determinant.norm() <= GEOMETRIC * (w[1].norm_sqr() + (w[0] * w[2]).norm()) {
        return w[1].norm() / w[0].norm();
    }
    let a = (w[1] * w[2] - w[0] * w[3]) / determinant;
    let b = (w[1] * w[3] - w[2] * w[2]) / determinant;
    let root = (a * a + 4.0 * b).sqrt();
    // Twice the root, without cancellation in the larger one.
    0.5 * (a + root).norm().max((a - root).norm())
}

/// QR iterations for each eigenvalue; one or two do.
const ITERATIONS: usize = 100;

/// The eigenvalues of a square matrix, pairs beside each other; all NaN where they are not found, as beside entries that are not finite.
///
/// They are those of its irreducible blocks. Of n equal rates in a chain, which is a triangular matrix, roundings ε move the eigenvalues by ε^(1/n) of
/// what couples them; its diagonal, the blocks, has them without roundings.
pub fn eigenvalues(a: &DMatrix<f64>) -> Vec<Complex<f64>> {
    let is_finite = a.iter().all(|x| x.is_finite());
    let of_blocks = || irreducible_blocks(a).into_iter().map(of_block).collect::<Option<Vec<_>>>();
    let found = is_finite.then(of_blocks).flatten();
    found.map_or_else(|| vec![Complex::from(f64::NAN); a.nrows()], |found| found.concat())
}

/// The eigenvalues of an irreducible matrix, if they are found.
fn of_block(mut block: DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    let n = block.nrows();
    if n == 1 {
        return Some(vec![block[(0, 0)].into()]);
    }
    // Unknowns in unlike units make entries of unlike sizes. Balancing squares them; a power of two takes no digits. The diagonal has no units.
    let unit = block.amax().log2().floor().clamp(-1000.0, 1000.0).exp2();
    block /= unit;
    let diagonal = block.diagonal();
    block.fill_diagonal(0.0);
    balance_parlett_reinsch(&mut block);
    block.set_diagonal(&diagonal);
    // An entry is zero beside those of the diagonal: beside zeros there none is, and the iteration has no end.
    let found = [0.0, block.amax()].into_iter().find_map(|shift| {
        let shifted = &block + DMatrix::from_diagonal_element(n, n, shift);
        let schur = Schur::try_new(shifted, f64::EPSILON, ITERATIONS * n)?;
        Some(schur.complex_eigenvalues().iter().map(|z| z - shift).collect::<Vec<_>>())
    });
    // It goes round in a circle, too, where that of faer takes exceptional shifts.
    let found = found.or_else(|| Mat::from_fn(n, n, |i, j| block[(i, j)]).eigenvalues().ok());
    found.map(|found| found.into_iter().map(|z| z * unit).collect())
}

/// The eigenvalues of a square matrix, found once.
#[derive(Debug)]
pub struct Spectrum(Vec<Complex<f64>>);

impl Spectrum {
    /// Those of `a`; all NaN where they are not found.
    pub fn of(a: &DMatrix<f64>) -> Self {
        Self(eigenvalues(a))
    }

    /// All of them.
    pub fn values(&self) -> &[Complex<f64>] {
        &self.0
    }

    /// Largest modulus; NaN where they are not found.
    pub fn radius(&self) -> f64 {
        self.0.iter().map(|z| z.norm()).largest()
    }

    /// Largest real part, negative for a Hurwitz matrix; NaN where they are not found.
    pub fn abscissa(&self) -> f64 {
        self.0.iter().map(|z| z.re).largest()
    }
}

/// [`Spectrum::radius`] of a matrix.
pub fn spectral_radius(a: &DMatrix<f64>) -> f64 {
    Spectrum::of(a).radius()
}

/// [`Spectrum::abscissa`] of a matrix.
pub fn spectral_abscissa(a: &DMatrix<f64>) -> f64 {
    Spectrum::of(a).abscissa()
}

/// How far from 0 in this direction, of modulus 1 in the left half-plane, RK4 damps: |1 + z + z²/2 + z³/6 + z⁴/24| ≤ 1.
pub fn reach_of_rk4(direction: Complex<f64>) -> f64 {
    /// No direction reaches so far, and each leaves the region once.
    const BEYOND: f64 = 3.5;
    const HALVINGS: i32 = 56;
    let damps = |r: f64| {
        let z = direction * r;
        let factor = 1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)));
        factor.norm_sqr() <= 1.0 + 8.0 * f64::EPSILON
    };
    let bisect = |(low, high): (f64, f64), _| {
        let middle = 0.5 * (low + high);
        if damps(middle) { (middle, high) } else { (low, middle) }
    };
    (0..HALVINGS).fold((0.0, BEYOND), bisect).0
}

/// Largest eigenvalue of the symmetric part: solutions of v̇ = Av grow no faster, at first and ever.
pub fn numerical_abscissa(a: &DMatrix<f64>) -> f64 {
    (0.5 * (a + a.transpose())).symmetric_eigenvalues().max()
}

/// Largest factor by which the matrix stretches a vector.
pub fn spectral_norm(a: &DMatrix<f64>) -> f64 {
    a.singular_values().max()
}

/// A generator of numbers uniform in (−1, 1), the same on every machine.
///
/// Knuth's 64-bit linear congruential generator; its upper bits are good enough to spread matrices about.
#[derive(Debug, Clone)]
pub struct Uniform(u64);

impl Uniform {
    /// The sequence number `seed`.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }
}

impl Iterator for Uniform {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        Some((self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sequence(terms: &[(Complex<f64>, Complex<f64>)]) -> [Complex<f64>; 4] {
        [0, 1, 2, 3].map(|n| terms.iter().map(|(c, root)| c * root.powi(n)).sum())
    }

    #[test]
    fn growth_sees_every_root_of_a_recurrence() {
        let (small, large) = (Complex::new(0.3, 0.2), Complex::new(-1.1, 0.4));
        let one = Complex::new(1.0, 0.0);
        approx::assert_relative_eq!(growth(sequence(&[(one, large)])), large.norm(), max_relative = 1e-14);
        // A large root that has hardly been excited.
        let hidden = sequence(&[(one, small), (Complex::new(1e-3, 0.0), large)]);
        approx::assert_relative_eq!(growth(hidden), large.norm(), max_relative = 1e-11);
        assert_eq!(growth([one, one * f64::INFINITY, one, one]), f64::INFINITY);
        // Whatever a run starts from.
        let start = Complex::new(30.0, -40.0);
        approx::assert_relative_eq!(growth(sequence(&[(start, large)])), large.norm(), max_relative = 1e-14);
        // Whatever its units: what is geometric but for rounding, and what is not.
        for unit in [1e-9, 1e-5, 1e5, 1e9] {
            let unit = Complex::new(unit, 0.0);
            approx::assert_relative_eq!(growth(sequence(&[(unit, large)])), large.norm(), max_relative = 1e-14);
            let both = sequence(&[(unit, small), (unit, large)]);
            approx::assert_relative_eq!(growth(both), large.norm(), max_relative = 1e-13);
        }
    }

    #[test]
    fn rk4_reaches_the_border_of_its_region() {
        for (degrees, expected) in [(180.0, 2.785_293_563), (90.0, 8_f64.sqrt())] {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            approx::assert_abs_diff_eq!(reach_of_rk4(Complex::new(cos.min(0.0), sin)), expected, epsilon = 1e-8);
        }
        // On the border |R| is 1, on either side of the real axis.
        for degrees in [91.0, 100.0, 120.0, 150.0, 240.0] {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            let direction = Complex::new(cos, sin);
            let z = direction * reach_of_rk4(direction);
            let factor = 1.0 + z + z * z / 2.0 + z * z * z / 6.0 + z * z * z * z / 24.0;
            approx::assert_abs_diff_eq!(factor.norm(), 1.0, epsilon = 1e-12);
            assert!(z.norm() > 2.6, "{z}");
        }
        // It damps all the way to there, and not beyond.
        for k in 0..=180 {
            let (sin, cos) = f64::to_radians(90.0 + 0.5 * f64::from(k)).sin_cos();
            let direction = Complex::new(cos.min(0.0), sin);
            let reach = reach_of_rk4(direction);
            for r in (1..=70).map(|part| 0.05 * f64::from(part)).filter(|r| (r - reach).abs() > 1e-6) {
                let z = direction * r;
                let factor = 1.0 + z + z * z / 2.0 + z * z * z / 6.0 + z * z * z * z / 24.0;
                assert_eq!(factor.norm() <= 1.0 + 1e-15, r < reach, "{z}");
            }
        }
    }

    #[test]
    fn abscissas_radii_and_norms_are_those_of_a_known_matrix() {
        // Eigenvalues −1, −2; symmetric part with eigenvalues (−3 ± √101)/2; norm² the larger root of x² − 105x + 4.
        let a = DMatrix::from_row_slice(2, 2, &[-1.0, 10.0, 0.0, -2.0]);
        approx::assert_relative_eq!(spectral_abscissa(&a), -1.0, max_relative = 1e-14);
        approx::assert_relative_eq!(spectral_radius(&a), 2.0, max_relative = 1e-14);
        approx::assert_relative_eq!(numerical_abscissa(&a), 0.5 * (101.0_f64.sqrt() - 3.0), max_relative = 1e-13);
        let square = 0.5 * (105.0 + (105.0_f64 * 105.0 - 16.0).sqrt());
        approx::assert_relative_eq!(spectral_norm(&a), square.sqrt(), max_relative = 1e-13);
    }

    /// A matrix with its rows and columns in another order.
    fn shuffled(a: &DMatrix<f64>, uniform: &mut Uniform) -> DMatrix<f64> {
        let mut keys: Vec<(f64, usize)> = uniform.take(a.nrows()).zip(0..).collect();
        keys.sort_by(|a, b| a.0.total_cmp(&b.0));
        DMatrix::from_fn(a.nrows(), a.nrows(), |i, j| a[(keys[i].1, keys[j].1)])
    }

    /// Random ones, and chains of equal rates, whose eigenvalues are all one.
    #[test]
    fn triangular_matrices_have_the_eigenvalues_on_their_diagonal_in_whatever_order_their_unknowns_are() {
        let mut uniform = Uniform::new(1);
        for n in [1, 2, 3, 5, 10, 30, 50, 64] {
            let random =
                DMatrix::from_fn(n, n, |i, j| if i >= j { 50.0 * uniform.next().expect("no end") } else { 0.0 });
            let chain =
                DMatrix::from_fn(n, n, |i, j| if i == j { -50.0 } else { f64::from(u8::from(i == j + 1)) * 50.0 });
            for a in [random.clone(), random.transpose(), chain.clone(), chain.transpose()] {
                for a in [shuffled(&a, &mut uniform), a] {
                    let sorted = |mut values: Vec<f64>| {
                        values.sort_by(f64::total_cmp);
                        values
                    };
                    let found = eigenvalues(&a);
                    assert!(found.iter().all(|z| z.im == 0.0), "{n}: {found:?}");
                    assert_eq!(
                        sorted(found.iter().map(|z| z.re).collect()),
                        sorted(a.diagonal().iter().copied().collect())
                    );
                }
            }
        }
    }

    /// Thirty oscillators, each of which drives the next: pairs −1 ± 2i.
    #[test]
    fn blocks_have_the_eigenvalues_that_they_have_alone() {
        let mut uniform = Uniform::new(2);
        let chain = DMatrix::from_fn(60, 60, |i, j| match (i, j) {
            _ if i == j => -1.0,
            _ if i / 2 == j / 2 => 2.0 * if i > j { 1.0 } else { -1.0 },
            _ if i == j + 2 => 30.0,
            _ => 0.0,
        });
        for a in [shuffled(&chain, &mut uniform), chain] {
            let found = eigenvalues(&a);
            assert!(
                found.len() == 60 && found.iter().all(|z| (z - Complex::new(-1.0, 2.0 * z.im.signum())).norm() < 1e-14),
                "{found:?}"
            );
            assert!(found.chunks(2).all(|pair| pair[0] == pair[1].conj()), "{found:?}");
        }
    }

    /// Of a matrix of second differences, 2 − 2 cos(kπ/(n+1)), with components in units from 1 to 2⁷⁶, and however large or small as a whole.
    /// Balancing is done when units of neighbours differ by √2, and makes up to √2 ^ (n − 1) of roundings n ε of the norm, 4.
    #[test]
    fn eigenvalues_do_not_depend_on_units() {
        const N: usize = 20;
        let units = DMatrix::from_fn(N, N, |i, j| 2.0_f64.powi(4 * ((7 * i % N) as i32 - (7 * j % N) as i32)));
        let differences = DMatrix::from_fn(N, N, |i, j| match i.abs_diff(j) {
            0 => 2.0,
            1 => -1.0,
            _ => 0.0,
        });
        let roundings = 2.0_f64.powf(0.5 * (N - 1) as f64) * N as f64 * f64::EPSILON * 4.0;
        for whole in [1.0, 1e-200, 1e200] {
            let mut found = eigenvalues(&(whole * differences.component_mul(&units)));
            found.sort_by(|a, b| a.re.total_cmp(&b.re));
            for (k, z) in (1..).zip(found) {
                let exact = 2.0 - 2.0 * (f64::from(k) * std::f64::consts::PI / (N + 1) as f64).cos();
                assert!((z / whole - exact).norm() < roundings, "{whole}: {z} for {exact}");
            }
        }
    }

    /// Two species that react and diffuse on 40 cells: the iteration goes round in a circle on this matrix.
    #[test]
    fn eigenvalues_of_a_reaction_with_diffusion_are_found() {
        const CELLS: usize = 40;
        const DIFFUSION: f64 = 33.62;
        let laplacian = DMatrix::from_fn(CELLS, CELLS, |i, j| match i.abs_diff(j) {
            0 => -2.0,
            1 => 1.0,
            _ => 0.0,
        });
        let mut a = DMatrix::from_diagonal_element(2 * CELLS, 2 * CELLS, -1.0);
        for (row, coupling) in [(0, 4.0), (CELLS, -1.0)] {
            let mut diagonal = a.view_mut((row, row), (CELLS, CELLS));
            diagonal += &laplacian * DIFFUSION;
            a.view_mut((row, CELLS - row), (CELLS, CELLS)).fill_diagonal(coupling);
        }
        let mut found = eigenvalues(&a);
        found.sort_by(|a, b| (b.re, b.im).partial_cmp(&(a.re, a.im)).expect("numbers"));
        let mode = |k: usize| (k as f64 * std::f64::consts::PI / (CELLS as f64 + 1.0)).cos();
        let exact = (1..=CELLS).flat_map(|k| {
            let re = -1.0 + DIFFUSION * (2.0 * mode(k) - 2.0);
            [Complex::new(re, 2.0), Complex::new(re, -2.0)]
        });
        let off =
            found.iter().zip(exact).map(|(z, exact)| (z.re - exact.re).abs().max((z.im.abs() - 2.0).abs())).largest();
        // A rounding of the norm for each unknown; and twice as much of the eigenvalues, of a matrix that is normal where one species is doubled.
        let norm = 1.0 + 4.0 * DIFFUSION + 4.0;
        let bound = 2.0 * 2.0 * CELLS as f64 * f64::EPSILON * norm;
        assert!(off < bound, "{off:e}, {bound:e}: {found:?}");
    }

    /// A ring of ones: the QR iteration is at rest on it, as its columns are orthonormal. NaN has no eigenvalues.
    #[test]
    fn the_search_for_eigenvalues_has_an_end() {
        let ring = DMatrix::from_fn(64, 64, |i, j| if (i + 1) % 64 == j { 1.0 } else { 0.0 });
        let found = eigenvalues(&ring);
        assert!(found.len() == 64 && found.iter().all(|z| (z.norm() - 1.0).abs() < 1e-10), "{found:?}");
        let found = eigenvalues(&(ring * 1024.0));
        assert!(found.iter().all(|z| (z.norm() / 1024.0 - 1.0).abs() < 1e-10), "{found:?}");
        let nilpotent = DMatrix::from_fn(5, 5, |i, j| if i + 1 == j { 1e3 } else { 0.0 });
        assert_eq!(eigenvalues(&nilpotent), [Complex::from(0.0); 5]);
        let unknown = DMatrix::from_element(3, 3, f64::NAN);
        assert!(spectral_radius(&unknown).is_nan() && spectral_abscissa(&unknown).is_nan());
        assert!(eigenvalues(&DMatrix::zeros(0, 0)).is_empty());
        // An entry that is none spoils all of them, be it in a block of its own.
        let apart = DMatrix::from_diagonal(&nalgebra::dvector![1.0, f64::INFINITY]);
        assert!(eigenvalues(&apart).iter().all(|z| z.re.is_nan()));
    }
}
