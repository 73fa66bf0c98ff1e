//! LU factors of tridiagonal matrices with partial pivoting.

use super::banded::Band;
use super::entry::Entry;
use super::{FactorError, is_usable, row_scale};

/// What is known of a row: before elimination its entries left of, on and right of the diagonal, after it the factors of its column.
#[derive(Debug, Clone, Copy)]
struct Row<T> {
    /// Left of the diagonal; then the multiplier of the row below.
    lower: T,
    /// On the diagonal; then one over the pivot.
    pivot: T,
    /// Right of the diagonal, and the fill of an exchange beyond; then both over the pivot.
    upper: [T; 2],
    /// The power of two by which the row is scaled.
    scale: f64,
    /// Whether the pivot was found in the row below.
    is_exchanged: bool,
}

/// P S A = L D U of a tridiagonal matrix, S the row scaling, with ones on the diagonals of L and of U.
#[derive(Debug)]
pub(crate) struct TridiagonalLu<T> {
    rows: Vec<Row<T>>,
    exchanges: usize,
}

impl<T: Entry> TridiagonalLu<T> {
    /// For matrices of two rows at least.
    pub(super) fn new(dim: usize) -> Self {
        let zero = T::from(0.0);
        Self {
            rows: vec![Row { lower: zero, pivot: zero, upper: [zero; 2], scale: 1.0, is_exchanged: false }; dim],
            exchanges: 0,
        }
    }

    /// The matrix of the images of the entries of `a`, to be factored.
    pub(super) fn assign(&mut self, a: &Band, image: impl Fn(f64) -> T) {
        // By columns of what is above, on and below the diagonal, with zeros outside of the matrix.
        let columns = a.values().as_chunks::<3>().0;
        let left = std::iter::once(0.0).chain(columns.iter().map(|column| column[2]));
        let right = columns.iter().skip(1).map(|column| column[0]).chain([0.0]);
        for (((row, column), left), right) in self.rows.iter_mut().zip(columns).zip(left).zip(right) {
            *row = Row {
                lower: image(left),
                pivot: image(column[1]),
                upper: [image(right), T::from(0.0)],
                scale: 1.0,
                is_exchanged: false,
            };
        }
    }

    #[inline]
    pub(super) fn entry(&mut self, i: usize, j: usize) -> Option<&mut T> {
        let dim = self.rows.len();
        let row = self.rows.get_mut(i)?;
        match (i, j) {
            _ if i == j => Some(&mut row.pivot),
            _ if i == j + 1 => Some(&mut row.lower),
            _ if i + 1 == j && j < dim => Some(&mut row.upper[0]),
            _ => None,
        }
    }

    /// Entries of L and of U, the diagonal counted once, with room for the fill of exchanges.
    pub(super) fn entries(&self) -> usize {
        let dim = self.rows.len();
        (0..dim).map(|j| j.min(2) + 1 + (dim - 1 - j).min(1)).sum()
    }

    /// Adds `x` to the diagonal of a matrix that was assigned.
    pub(super) fn shift(&mut self, x: T) {
        self.rows.iter_mut().for_each(|row| row.pivot += x);
    }

    /// Factors the matrix in place.
    pub(super) fn decompose(&mut self) -> Result<(), FactorError> {
        let mut elimination = Elimination::new(self)?;
        (0..self.rows.len()).try_for_each(|j| elimination.step(self, j))
    }

    /// Factors two matrices of one order side by side: each row waits for the one before, and less for the other matrix's.
    pub(super) fn decompose_both<U: Entry>(&mut self, other: &mut TridiagonalLu<U>) -> Result<(), FactorError> {
        let (mut first, mut second) = (Elimination::new(self)?, Elimination::new(other)?);
        for j in 0..self.rows.len() {
            first.step(self, j)?;
            second.step(other, j)?;
        }
        Ok(())
    }

    pub(super) fn solve(&self, b: &mut [T]) {
        let (mut forward, mut backward) = (Forward::new(&self.rows, b), Backward::new());
        (0..self.rows.len()).for_each(|j| forward.step(&self.rows, j, b));
        (0..self.rows.len()).rev().for_each(|j| backward.step(&self.rows, j, b));
    }

    /// Solves with two matrices of one order side by side, as [`decompose_both`](Self::decompose_both) factors them.
    pub(super) fn solve_both<U: Entry>(&self, b: &mut [T], other: &TridiagonalLu<U>, c: &mut [U]) {
        let n = self.rows.len();
        // With lengths that the compiler sees to be the same.
        let (one, two, b, c) = (&self.rows[..n], &other.rows[..n], &mut b[..n], &mut c[..n]);
        let (mut first, mut second) = (Forward::new(one, b), Forward::new(two, c));
        for j in 0..n {
            first.step(one, j, b);
            second.step(two, j, c);
        }
        let (mut first, mut second) = (Backward::new(), Backward::new());
        for j in (0..n).rev() {
            first.step(one, j, b);
            second.step(two, j, c);
        }
    }

    pub(super) fn solve_transpose(&self, b: &mut [T]) {
        let n = self.rows.len();
        for j in 0..n {
            let x = b[j];
            for (b, u) in b[j + 1..].iter_mut().zip(self.rows[j].upper) {
                *b -= u * x;
            }
        }
        for (j, row) in self.rows.iter().enumerate().rev() {
            b[j] *= row.pivot;
            if j + 1 < n {
                let below = b[j + 1];
                b[j] -= row.lower * below;
            }
            if row.is_exchanged {
                b.swap(j, j + 1);
            }
        }
        b.iter_mut().zip(&self.rows).for_each(|(x, row)| *x = x.scaled(row.scale));
    }
}

impl TridiagonalLu<f64> {
    pub(super) fn sign(&self) -> f64 {
        // One over a pivot has its sign.
        super::sign(self.rows.iter().map(|row| row.pivot), self.exchanges)
    }
}

/// An elimination that has come to a row.
struct Elimination<T> {
    /// The row in which the next pivot is looked for, from the column of that on.
    row: [T; 3],
    /// The entries of U above that pivot, and the one above the next.
    above: [T; 2],
    beyond: T,
}

impl<T: Entry> Elimination<T> {
    fn new(lu: &mut TridiagonalLu<T>) -> Result<Self, FactorError> {
        let zero = T::from(0.0);
        lu.exchanges = 0;
        let [_, pivot, upper] = scaled(&mut lu.rows[0])?;
        Ok(Self { row: [pivot, upper, zero], above: [zero; 2], beyond: zero })
    }

    #[inline(always)]
    fn step(&mut self, lu: &mut TridiagonalLu<T>, j: usize) -> Result<(), FactorError> {
        let zero = T::from(0.0);
        let mut below = lu.rows.get_mut(j + 1).map_or(Ok([zero; 3]), scaled)?;
        let is_exchanged = below[0].magnitude() > self.row[0].magnitude();
        if is_exchanged {
            lu.exchanges += 1;
            std::mem::swap(&mut self.row, &mut below);
        }
        let [pivot, first, second] = self.row;
        if !is_usable(&[self.above[0], self.above[1], pivot], 3) {
            return Err(FactorError::Singular);
        }
        let inverse = T::from(1.0) / pivot;
        let lower = below[0] * inverse;
        let row = &mut lu.rows[j];
        (row.lower, row.pivot, row.upper) = (lower, inverse, [first * inverse, second * inverse]);
        row.is_exchanged = is_exchanged;
        (self.above, self.beyond) = ([self.beyond, first], second);
        self.row = [below[1] - lower * first, below[2] - lower * second, zero];
        Ok(())
    }
}

/// A solution with L and D that has come to a row.
struct Forward<T>(T);

impl<T: Entry> Forward<T> {
    fn new(rows: &[Row<T>], b: &[T]) -> Self {
        Self(b[0].scaled(rows[0].scale))
    }

    #[inline(always)]
    fn step(&mut self, rows: &[Row<T>], j: usize, b: &mut [T]) {
        let (row, mut x) = (&rows[j], self.0);
        let mut next = match (rows.get(j + 1), b.get(j + 1)) {
            (Some(row), Some(b)) => b.scaled(row.scale),
            _ => T::from(0.0),
        };
        if row.is_exchanged {
            std::mem::swap(&mut x, &mut next);
        }
        b[j] = x * row.pivot;
        self.0 = next - row.lower * x;
    }
}

/// A solution with U that has come to a row: the two below.
struct Backward<T>([T; 2]);

impl<T: Entry> Backward<T> {
    fn new() -> Self {
        Self([T::from(0.0); 2])
    }

    #[inline(always)]
    fn step(&mut self, rows: &[Row<T>], j: usize, b: &mut [T]) {
        let [first, second] = rows[j].upper;
        let Self([below, beyond]) = *self;
        // The first of the two is known last.
        let x = b[j] - second * beyond - first * below;
        b[j] = x;
        *self = Self([x, below]);
    }
}

/// The entries of a row, scaled to a sum of magnitudes in [1, 2).
#[inline]
fn scaled<T: Entry>(row: &mut Row<T>) -> Result<[T; 3], FactorError> {
    let entries = [row.lower, row.pivot, row.upper[0]];
    let [a, b, c] = entries.map(T::magnitude);
    row.scale = row_scale(a + b + c)?;
    Ok(entries.map(|x| x.scaled(row.scale)))
}
