//! The normal equations of a band matrix by LDLᵀ from both ends at once.

use super::{Augmented, StepSolver};
use crate::error::{InputError, SolveError};
use crate::linalg::{Jacobian, Structure, inverse_norm};
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
            self.factors = Some(Factors::new(matrix.dim(), lower + upper));
            self.scaled = vec![0.0; matrix.dim()];
        }
        let factors = self.factors.as_mut().ok_or(SolveError::NotAssembled)?;
        if self.damping != Some(damping) {
            self.damping = None;
            factors.factor(mass, matrix, damping)?;
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

impl StepSolver for Twisted {
    fn check(&self, structure: &Structure, mass: &Mass) -> Result<(), InputError> {
        match (structure, mass) {
            (Structure::Banded { .. }, Mass::Identity | Mass::Diagonal(_)) => Ok(()),
            (Structure::Banded { .. }, _) => {
                Err(InputError::Solver("twisted elimination needs a diagonal mass matrix"))
            }
            _ => Err(InputError::Solver("twisted elimination needs a banded structure")),
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
    /// Unknowns eliminated in each lane.
    half: usize,
    /// Column k of each lane at k (width + 1): the diagonal, then the entries below; once factored 1/d_k and the multipliers.
    columns: Vec<Lanes>,
    /// The middle block, symmetric, by columns.
    middle: Vec<f64>,
    /// The right-hand side by lanes.
    lanes: Vec<Lanes>,
    diagonal: Vec<f64>,
}

impl Factors {
    /// For products of order `dim` of half bandwidth `width`.
    fn new(dim: usize, width: usize) -> Self {
        let width = width.min(dim.saturating_sub(1));
        let half = (dim - width.min(dim)) / 2;
        let middle = dim - 2 * half;
        Self {
            dim,
            width,
            half,
            columns: vec![[0.0; 2]; (half + width) * (width + 1)],
            middle: vec![0.0; middle * middle],
            lanes: vec![[0.0; 2]; half + width],
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

    fn factor(&mut self, mass: &Mass, b: &Jacobian, damping: f64) -> Result<(), SolveError> {
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
            for i in j..(j + self.width + 1).min(self.dim) {
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
            .all(|inverse| inverse > 0.0 && inverse.is_finite());
        if usable { Ok(()) } else { Err(SolveError::Singular) }
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
        let (half, width, size) = (self.half, self.width, self.dim - 2 * self.half);
        let last = self.dim - 1;
        for (k, lanes) in self.lanes.iter_mut().enumerate() {
            *lanes = if k < half { [b[k], b[last - k]] } else { [0.0; 2] };
        }
        match width {
            2 => forward::<2>(2, half, &self.columns, &mut self.lanes),
            4 => forward::<4>(4, half, &self.columns, &mut self.lanes),
            _ => forward::<0>(width, half, &self.columns, &mut self.lanes),
        }
        let middle = &mut b[half..half + size];
        for (j, [down, up]) in self.lanes[half..].iter().enumerate() {
            middle[j] += down;
            middle[size - 1 - j] += up;
        }
        for k in 0..size {
            for i in k + 1..size {
                middle[i] -= self.middle[k * size + i] * middle[k];
            }
        }
        for k in (0..size).rev() {
            let known: f64 = (k + 1..size).map(|i| self.middle[k * size + i] * middle[i]).sum();
            middle[k] = middle[k] * self.middle[k * size + k] - known;
        }
        for (j, lanes) in self.lanes[half..].iter_mut().enumerate() {
            *lanes = [middle[j], middle[size - 1 - j]];
        }
        match width {
            2 => backward::<2>(2, half, &self.columns, &mut self.lanes),
            4 => backward::<4>(4, half, &self.columns, &mut self.lanes),
            _ => backward::<0>(width, half, &self.columns, &mut self.lanes),
        }
        for (k, [down, up]) in self.lanes[..half].iter().enumerate() {
            b[k] = *down;
            b[last - k] = *up;
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

fn forward<const WIDTH: usize>(width: usize, half: usize, columns: &[Lanes], lanes: &mut [Lanes]) {
    let width = bandwidth::<WIDTH>(width);
    for (k, column) in columns.chunks_exact(width + 1).take(half).enumerate() {
        let (done, rest) = lanes.split_at_mut(k + 1);
        let pivot = done[k];
        for (x, l) in rest[..width].iter_mut().zip(&column[1..]) {
            x[0] -= l[0] * pivot[0];
            x[1] -= l[1] * pivot[1];
        }
    }
}

fn backward<const WIDTH: usize>(width: usize, half: usize, columns: &[Lanes], lanes: &mut [Lanes]) {
    let width = bandwidth::<WIDTH>(width);
    for (k, column) in columns.chunks_exact(width + 1).take(half).enumerate().rev() {
        let (done, rest) = lanes.split_at_mut(k + 1);
        let mut x = [done[k][0] * column[0][0], done[k][1] * column[0][1]];
        for (y, l) in rest[..width].iter().zip(&column[1..]).rev() {
            x[0] -= l[0] * y[0];
            x[1] -= l[1] * y[1];
        }
        done[k] = x;
    }
}
