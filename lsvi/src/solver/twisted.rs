//! The normal equations of a band matrix by LDLᵀ from both ends at once.

use super::{Augmented, StepSolver};
use crate::error::{InputError, SolveError, SystemError};
use crate::linalg::{FactorError, Jacobian, Structure, inverse_norm};
use crate::mass::Mass;
use crate::operator::StepOperator;

/// Values at the same distance from the two ends.
type Lanes = [f64; 2];

/// LDLᵀ factors of the band matrix (1 + μ) M + BᵀM⁻¹B of the normal equations, for banded f_v and diagonal M; LU factors of B
/// for implicit stages.
///
/// The cheapest solver, with the condition number of B squared: for symmetric dissipative systems.
#[derive(Debug, Default)]
pub struct Twisted {
    factors: Option<Factors>,
    /// The damping of the factors, if they are those of the present B.
    damping: Option<f64>,
    /// M⁻¹a.
    scaled: Vec<f64>,
    stages: Augmented,
}

impl Twisted {
    /// Factors are set up in the first step.
    pub fn new() -> Self {
        Self::default()
    }

    fn factor(&mut self, b: &StepOperator<'_>, damping: f64) -> Result<&mut Factors, SolveError> {
        let (matrix, mass) = (b.assembled().ok_or(SolveError::NotAssembled)?, b.mass());
        if self.factors.is_none() {
            let (Structure::Banded { lower, upper }, Mass::Identity | Mass::Diagonal(_)) = (matrix.structure(), mass)
            else {
                return Err(SolveError::NotAssembled);
            };
            self.factors = Some(Factors::new(matrix.dim(), lower + upper, upper));
            self.scaled = vec![0.0; matrix.dim()];
        }
        let factors = self.factors.as_mut().ok_or(SolveError::NotAssembled)?;
        if self.damping != Some(damping) {
            self.damping = None;
            factors.factor(mass, matrix, damping).map_err(|error| matrix.blame(error))?;
            self.damping = Some(damping);
        }
        Ok(factors)
    }

    /// An estimate of the condition number of M + BᵀM⁻¹B in the 1-norm; infinite if it has no factors.
    pub(crate) fn condition(&mut self, b: &StepOperator<'_>, work: &mut [Vec<f64>; 2]) -> f64 {
        let Ok(factors) = self.factor(b, 0.0) else { return f64::INFINITY };
        let inverse = inverse_norm(|x| factors.solve(x), work);
        b.assembled().map_or(f64::INFINITY, |matrix| inverse * normal_norm(b.mass(), matrix, work))
    }
}

/// A right-hand side whose solutions are surely finite.
const LARGEST: f64 = 1e150;

impl Twisted {
    /// Replaces `v` by the solution of (M + BᵀM⁻¹B) y = 2 M v + g, with the factors that were [prepared](Self::condition), in
    /// one pass from both ends to the middle and back; false, and `v` as it is, unless v and g are finite.
    pub(crate) fn march(&mut self, mass: &Mass, g: &[f64], v: &mut [f64]) -> bool {
        let Some(factors) = &mut self.factors else { return false };
        let n = factors.dim;
        let (g, start) = (&g[..n], &v[..n]);
        let sum = match mass {
            Mass::Diagonal(m) => factors.forward(|i| 2.0 * m[i] * start[i] + g[i]),
            _ => factors.forward(|i| 2.0 * start[i] + g[i]),
        };
        let is_finite = sum < LARGEST;
        if is_finite {
            factors.backward(v);
        }
        is_finite
    }
}

impl StepSolver for Twisted {
    fn check(&self, structure: &Structure, mass: &Mass) -> Result<(), InputError> {
        match (structure, mass) {
            (Structure::Banded { .. }, Mass::Identity | Mass::Diagonal(_)) => Ok(()),
            (Structure::Banded { .. }, _) => {
                Err(InputError::System(SystemError::Solver("twisted elimination needs a diagonal mass matrix")))
            }
            _ => Err(InputError::System(SystemError::Solver("twisted elimination needs a banded structure"))),
        }
    }

    fn prepare(&mut self, b: &StepOperator<'_>) -> Result<(), SolveError> {
        self.damping = None;
        self.stages.prepare(b)
    }

    fn solve_stage(&mut self, b: &StepOperator<'_>, x: &mut [f64], tolerance: f64) -> Result<u64, SolveError> {
        self.stages.solve_stage(b, x, tolerance)
    }

    fn solve_normal(
        &mut self,
        b: &StepOperator<'_>,
        damping: f64,
        a: Option<&[f64]>,
        x: &mut [f64],
        _tolerance: f64,
    ) -> Result<u64, SolveError> {
        self.factor(b, damping)?;
        if let (Some(a), Some(matrix)) = (a, b.assembled()) {
            self.scaled.copy_from_slice(a);
            b.mass().for_each(a.len(), |i, _, m| self.scaled[i] /= m);
            matrix.mul_transpose_add(1.0, &self.scaled, x);
        }
        self.factor(b, damping)?.solve(x);
        Ok(0)
    }
}

/// A bound of ‖M + BᵀM⁻¹B‖₁ for a diagonal M: the column sums of M + |B|ᵀM⁻¹|B|.
fn normal_norm(mass: &Mass, b: &Jacobian, work: &mut [Vec<f64>; 2]) -> f64 {
    let [rows, columns] = work;
    rows.fill(0.0);
    columns.fill(0.0);
    b.for_each(|i, _, x| rows[i] += x.abs());
    mass.for_each(b.dim(), |i, _, m| {
        rows[i] /= m;
        columns[i] += m;
    });
    b.for_each(|i, j, x| columns[j] += x.abs() * rows[i]);
    columns.iter().fold(0.0, |largest, x| largest.max(*x))
}

/// The factors of (1 + μ) M + BᵀM⁻¹B, eliminated from both ends towards the middle.
///
/// Elimination of a narrow band waits for each pivot in turn; two independent eliminations hide half of that. Lane 0 runs
/// down from the first unknown and lane 1 up from the last; they meet in a block of `width` or `width` + 1 unknowns, which is
/// factored by itself.
#[derive(Debug)]
struct Factors {
    dim: usize,
    width: usize,
    /// Upper bandwidth of B.
    upper: usize,
    /// Unknowns eliminated in each lane.
    half: usize,
    /// Column k of each lane at k (width + 1): the diagonal, then the entries below; once factored 1/d_k and the multipliers.
    columns: Vec<Lanes>,
    /// The middle block, symmetric, by columns.
    middle: Vec<f64>,
    /// The right-hand side by lanes, and in the middle.
    lanes: Vec<Lanes>,
    center: Vec<f64>,
    diagonal: Vec<f64>,
}

impl Factors {
    /// For products of order `dim` of half bandwidth `width`, of a B of the given upper bandwidth.
    fn new(dim: usize, width: usize, upper: usize) -> Self {
        let width = width.min(dim.saturating_sub(1));
        let half = (dim - width.min(dim)) / 2;
        let middle = dim - 2 * half;
        Self {
            dim,
            width,
            upper,
            half,
            columns: vec![[0.0; 2]; (half + width) * (width + 1)],
            middle: vec![0.0; middle * middle],
            lanes: vec![[0.0; 2]; half + width],
            center: vec![0.0; middle],
            diagonal: vec![0.0; dim],
        }
    }

    /// Adds `x` to entries (i, j) and (j, i) of the matrix, i ≥ j.
    #[inline]
    fn add(&mut self, i: usize, j: usize, x: f64) {
        let (half, stride) = (self.half, self.width + 1);
        if j < half {
            self.columns[j * stride + i - j][0] += x;
        } else if i >= self.dim - half {
            self.columns[(self.dim - 1 - i) * stride + i - j][1] += x;
        } else {
            let size = self.dim - 2 * half;
            self.middle[(j - half) * size + i - half] += x;
        }
    }

    fn factor(&mut self, mass: &Mass, b: &Jacobian, damping: f64) -> Result<(), FactorError> {
        self.columns.fill([0.0; 2]);
        self.middle.fill(0.0);
        self.diagonal.fill(1.0);
        if let Mass::Diagonal(m) = mass {
            self.diagonal.copy_from_slice(m);
        }
        for i in 0..self.dim {
            self.add(i, i, (1.0 + damping) * self.diagonal[i]);
        }
        // Row i of B contributes its products to the columns it meets.
        b.for_each(|row, j, x| {
            for i in j..(row + self.upper + 1).min(self.dim) {
                let product = x * b.get(row, i) / self.diagonal[row];
                self.add(i, j, product);
            }
        });
        match self.width {
            2 => eliminate::<2>(2, self.half, &mut self.columns),
            4 => eliminate::<4>(4, self.half, &mut self.columns),
            width => eliminate::<0>(width, self.half, &mut self.columns),
        }
        self.factor_middle();
        let pivots = self.columns.chunks_exact(self.width + 1).take(self.half).flat_map(|column| column[0]);
        let size = self.dim - 2 * self.half;
        let usable = pivots
            .chain((0..size).map(|k| self.middle[k * size + k]))
            .all(|inverse| inverse > 0.0 && inverse < LARGEST);
        if usable { Ok(()) } else { Err(FactorError::Singular) }
    }

    /// Adds what the lanes leave to the middle block and factors it.
    fn factor_middle(&mut self) {
        let (half, width, size) = (self.half, self.width, self.dim - 2 * self.half);
        for j in 0..width {
            for d in 0..width - j {
                let [down, up] = self.columns[(half + j) * (width + 1) + d];
                self.middle[j * size + j + d] += down;
                let mirrored = size - 1 - j - d;
                self.middle[mirrored * size + mirrored + d] += up;
            }
        }
        for k in 0..size {
            let (done, rest) = self.middle.split_at_mut((k + 1) * size);
            let column = &mut done[k * size + k..];
            let inverse = column[0].recip();
            for (a, target) in rest.chunks_exact_mut(size).enumerate() {
                let multiplier = column[a + 1] * inverse;
                for (x, c) in target[k + 1 + a..].iter_mut().zip(&column[a + 1..]) {
                    *x -= multiplier * c;
                }
            }
            column[0] = inverse;
            column[1..].iter_mut().for_each(|x| *x *= inverse);
        }
    }

    /// Overwrites `b` with the solution.
    fn solve(&mut self, b: &mut [f64]) {
        self.forward(|i| b[i]);
        self.backward(b);
    }

    /// Eliminates the right-hand side with the given components; returns the sum of the sizes of what is left, which is not
    /// finite if one of them is not.
    fn forward(&mut self, right: impl Fn(usize) -> f64) -> f64 {
        let (half, end, columns, lanes) = (self.half, self.dim - 1, &self.columns, &mut self.lanes);
        let pair = |k: usize| [right(k), right(end - k)];
        let sum = match self.width {
            2 => forward::<2>(2, half, columns, lanes, pair),
            4 => forward::<4>(4, half, columns, lanes, pair),
            width => forward::<0>(width, half, columns, lanes, pair),
        };
        let size = self.center.len();
        self.center.iter_mut().enumerate().for_each(|(j, x)| *x = right(half + j));
        for (j, [down, up]) in lanes[half..].iter().enumerate() {
            self.center[j] += down;
            self.center[size - 1 - j] += up;
        }
        sum + self.center.iter().map(|x| x.abs()).sum::<f64>()
    }

    /// Writes the solution for the right-hand side that was eliminated.
    fn backward(&mut self, out: &mut [f64]) {
        let (half, size, x) = (self.half, self.center.len(), &mut self.center);
        for k in 0..size {
            for i in k + 1..size {
                x[i] -= self.middle[k * size + i] * x[k];
            }
        }
        for k in (0..size).rev() {
            let known: f64 = (k + 1..size).map(|i| self.middle[k * size + i] * x[i]).sum();
            x[k] = x[k] * self.middle[k * size + k] - known;
        }
        out[half..half + size].copy_from_slice(x);
        let columns = &self.columns[..half * (self.width + 1)];
        match self.width {
            2 => backward::<2>(2, half, columns, &self.lanes, out),
            4 => backward::<4>(4, half, columns, &self.lanes, out),
            width => backward::<0>(width, half, columns, &self.lanes, out),
        }
    }
}

/// The bandwidth, known at compile time unless WIDTH is 0.
#[inline(always)]
fn bandwidth<const WIDTH: usize>(width: usize) -> usize {
    if WIDTH == 0 { width } else { WIDTH }
}

fn eliminate<const WIDTH: usize>(width: usize, half: usize, columns: &mut [Lanes]) {
    let width = bandwidth::<WIDTH>(width);
    let stride = width + 1;
    for k in 0..half {
        let (done, rest) = columns.split_at_mut((k + 1) * stride);
        let column = &mut done[k * stride..];
        let inverse = column[0].map(f64::recip);
        for a in 1..=width {
            let multiplier = [column[a][0] * inverse[0], column[a][1] * inverse[1]];
            let target = &mut rest[(a - 1) * stride..a * stride];
            for (x, c) in target.iter_mut().zip(&column[a..=width]) {
                x[0] -= multiplier[0] * c[0];
                x[1] -= multiplier[1] * c[1];
            }
        }
        column[0] = inverse;
        for x in &mut column[1..=width] {
            *x = [x[0] * inverse[0], x[1] * inverse[1]];
        }
    }
}

/// Sets the first `half` lanes to L⁻¹ of the right-hand side and the others to what these take from the middle; returns the sum
/// of their sizes, which is not finite if one of them is not.
fn forward<const WIDTH: usize>(
    width: usize,
    half: usize,
    columns: &[Lanes],
    lanes: &mut [Lanes],
    right: impl Fn(usize) -> Lanes,
) -> f64 {
    let width = bandwidth::<WIDTH>(width);
    let stride = width + 1;
    let (mut sum, mut last) = ([0.0; 2], [0.0; 2]);
    for k in 0..half {
        let mut x = right(k);
        // The value before comes last: it is what everything waits for.
        for a in (2..=width.min(k)).rev() {
            x = less(x, columns[(k - a) * stride + a], lanes[k - a]);
        }
        if width > 0 && k > 0 {
            x = less(x, columns[(k - 1) * stride + 1], last);
        }
        lanes[k] = x;
        last = x;
        sum = [sum[0] + x[0].abs(), sum[1] + x[1].abs()];
    }
    for k in half..half + width {
        lanes[k] = [0.0; 2];
        for a in k - half + 1..=width.min(k) {
            lanes[k] = less(lanes[k], columns[(k - a) * stride + a], lanes[k - a]);
        }
    }
    sum[0] + sum[1]
}

/// Writes L⁻ᵀD⁻¹ of the first `half` lanes, from the middle outwards.
fn backward<const WIDTH: usize>(width: usize, half: usize, columns: &[Lanes], lanes: &[Lanes], out: &mut [f64]) {
    let width = bandwidth::<WIDTH>(width);
    let end = out.len() - 1;
    let mut last = [out[half.min(end)], out[end - half.min(end)]];
    for (k, (column, lanes)) in columns.chunks_exact(width + 1).zip(&lanes[..half]).enumerate().rev() {
        let mut x = [lanes[0] * column[0][0], lanes[1] * column[0][1]];
        for a in (2..=width).rev() {
            x = less(x, column[a], [out[k + a], out[end - k - a]]);
        }
        if width > 0 {
            x = less(x, column[1], last);
        }
        (out[k], out[end - k]) = (x[0], x[1]);
        last = x;
    }
}

#[inline(always)]
fn less(x: Lanes, l: Lanes, y: Lanes) -> Lanes {
    [x[0] - l[0] * y[0], x[1] - l[1] * y[1]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::autodiff::{AutoField, FieldFn, Scalar};

    /// f = (−v₀, −9 v₁), declared banded.
    struct Decays;

    impl FieldFn for Decays {
        fn dim(&self) -> usize {
            2
        }
        fn structure(&self) -> Structure {
            Structure::Banded { lower: 0, upper: 0 }
        }
        fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
            (dv[0], dv[1]) = (-v[0], v[1] * -9.0);
        }
    }

    /// M + BᵀM⁻¹B is diag(1 + 2², 1 + 10²), and with M = diag(2, 5) diag(2 + 2²/2, 5 + 10²/5).
    #[test]
    fn the_condition_number_of_a_diagonal_matrix_is_that_of_its_entries() {
        let (field, v) = (AutoField::new(Decays), [1.0; 2]);
        let mut matrix = Jacobian::with_structure(2, &Structure::Banded { lower: 0, upper: 0 });
        matrix.add(0, 0, 2.0);
        matrix.add(1, 1, 10.0);
        for (mass, expected) in [(Mass::Identity, 101.0 / 5.0), (Mass::Diagonal(vec![2.0, 5.0]), 25.0 / 4.0)] {
            let b = StepOperator::new(&field, &mass, (0.0, &v), 1.0, Some(&matrix));
            let condition = Twisted::new().condition(&b, &mut [vec![0.0; 2], vec![0.0; 2]]);
            assert!((condition - expected).abs() < 1e-12, "{mass:?}: {condition}");
        }
    }
}
