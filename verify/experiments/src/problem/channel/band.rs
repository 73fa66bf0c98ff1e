//! Symmetric banded matrices.

/// A symmetric matrix of order n with `width` diagonals below the main one.
#[derive(Debug, Clone)]
pub(super) struct Band {
    width: usize,
    /// Row i holds the entries (i, i − width) to (i, i).
    rows: Vec<f64>,
}

impl Band {
    pub(super) fn zeros(dim: usize, width: usize) -> Self {
        Self { width, rows: vec![0.0; dim * (width + 1)] }
    }

    pub(super) fn identity(dim: usize) -> Self {
        Self { width: 0, rows: vec![1.0; dim] }
    }

    pub(super) fn dim(&self) -> usize {
        self.rows.len() / (self.width + 1)
    }

    pub(super) fn width(&self) -> usize {
        self.width
    }

    /// Entry (i, j) of the lower triangle, i − width ≤ j ≤ i.
    fn at(&self, i: usize, j: usize) -> usize {
        (i + 1) * (self.width + 1) - 1 - (i - j)
    }

    /// Adds `x` to the entries (i, j) and (j, i), once if i = j.
    pub(super) fn add(&mut self, i: usize, j: usize, x: f64) {
        let k = self.at(i.max(j), i.min(j));
        self.rows[k] += x;
    }

    /// Shows every entry within the band to `visit`.
    pub(super) fn for_each(&self, mut visit: impl FnMut(usize, usize, f64)) {
        for i in 0..self.dim() {
            for j in i.saturating_sub(self.width)..=i {
                let x = self.rows[self.at(i, j)];
                visit(i, j, x);
                if i != j {
                    visit(j, i, x);
                }
            }
        }
    }

    /// Adds `scale` A x to `out`.
    pub(super) fn mul_add(&self, scale: f64, x: &[f64], out: &mut [f64]) {
        self.for_each(|i, j, a| out[i] += scale * a * x[j]);
    }

    /// The factor L of A = L Lᵀ, for a positive definite matrix.
    pub(super) fn cholesky(&self) -> Cholesky {
        let mut l = self.clone();
        for i in 0..l.dim() {
            let first = i.saturating_sub(l.width);
            for j in first..=i {
                let from = first.max(j.saturating_sub(l.width));
                let sum: f64 = (from..j).map(|k| l.rows[l.at(i, k)] * l.rows[l.at(j, k)]).sum();
                let (entry, pivot) = (l.at(i, j), l.at(j, j));
                let rest = l.rows[entry] - sum;
                l.rows[entry] = if i == j { rest.sqrt() } else { rest / l.rows[pivot] };
            }
        }
        Cholesky(l)
    }
}

/// A triangular factor L with A = L Lᵀ.
#[derive(Debug, Clone)]
pub(super) struct Cholesky(Band);

impl Cholesky {
    /// Overwrites `b` with L⁻¹ b.
    pub(super) fn solve_lower(&self, b: &mut [f64]) {
        let l = &self.0;
        for i in 0..b.len() {
            let sum: f64 = (i.saturating_sub(l.width)..i).map(|j| l.rows[l.at(i, j)] * b[j]).sum();
            b[i] = (b[i] - sum) / l.rows[l.at(i, i)];
        }
    }

    /// Overwrites `b` with L⁻ᵀ b.
    pub(super) fn solve_upper(&self, b: &mut [f64]) {
        let l = &self.0;
        for i in (0..b.len()).rev() {
            let sum: f64 = (i + 1..b.len().min(i + l.width + 1)).map(|j| l.rows[l.at(j, i)] * b[j]).sum();
            b[i] = (b[i] - sum) / l.rows[l.at(i, i)];
        }
    }

    /// Overwrites `b` with A⁻¹ b.
    pub(super) fn solve(&self, b: &mut [f64]) {
        self.solve_lower(b);
        self.solve_upper(b);
    }
}
