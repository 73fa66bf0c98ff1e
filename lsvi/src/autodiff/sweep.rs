//! Derivatives of f by sweeps of dual numbers, one direction after the other.

use num_dual::{Dual64, HyperDual64};

use super::Scalar;
use crate::coloring::Coloring;
use crate::linalg::{Jacobian, Structure};
use crate::pool::Pool;

/// Unknowns of a dense system at most whose numbers are on the stack.
const FEW: usize = 4;

/// f at dual numbers. Behind a pointer, so that the loops around it are compiled once and not for every f.
type Rhs<'a, T> = &'a dyn Fn(&[T], &mut [T]);

/// Calls `f` with each variable j in turn made the one to differentiate by, at `x`, with all numbers on the stack.
///
/// The sweeps do not depend on each other, so that their divisions and roots overlap: faster than one sweep with all directions.
#[inline(always)]
pub(super) fn each<const N: usize>(x: &[f64], mut f: impl FnMut(usize, &[Dual64; N])) {
    let mut x = constants::<Dual64, N>(x);
    for j in 0..N {
        x[j].eps = 1.0;
        f(j, &x);
        x[j].eps = 0.0;
    }
}

/// The first N of `x` as numbers by which nothing is differentiated.
#[inline(always)]
pub(super) fn constants<T: Scalar, const N: usize>(x: &[f64]) -> [T; N] {
    let mut constants = [T::from(0.0); N];
    for (constant, x) in constants.iter_mut().zip(&x[..N]) {
        *constant = T::from(*x);
    }
    constants
}

/// Adds `scale` times a matrix to `out`, whose entry (i, j) is the derivative of number i of column j.
#[inline(always)]
pub(super) fn add_columns<const N: usize>(columns: &[[Dual64; N]; N], scale: f64, out: &mut Jacobian) {
    match out.dense_mut() {
        Some(out) if out.len() == N * N => {
            for (out, f) in out.iter_mut().zip(columns.as_flattened()) {
                *out += scale * f.eps;
            }
        }
        _ => {
            for (j, column) in columns.iter().enumerate() {
                column.iter().enumerate().for_each(|(i, f)| out.add(i, j, scale * f.eps));
            }
        }
    }
}

/// Writes the values without their derivatives.
#[inline(always)]
pub(super) fn write_values(from: &[Dual64], out: &mut [f64]) {
    for (out, f) in out.iter_mut().zip(from) {
        *out = f.re;
    }
}

/// Derivatives of systems of any size and structure, in groups of columns that share no row.
#[derive(Debug)]
pub(super) struct Sweeps {
    dim: usize,
    structure: Structure,
    coloring: Coloring,
    /// Along which the structure is checked, if the field declares one.
    directions: Vec<f64>,
    first: Pool<Sweep<Dual64>>,
    second: Pool<Sweep<HyperDual64>>,
    row_check: Pool<Vec<RowCheck>>,
}

#[derive(Debug)]
struct Sweep<T> {
    v: Vec<T>,
    dv: Vec<T>,
}

impl<T: Scalar> Sweep<T> {
    fn new(dim: usize) -> Pool<Self> {
        Pool::new(move || Self { v: vec![T::from(0.0); dim], dv: vec![T::from(0.0); dim] })
    }

    fn seed(&mut self, v: &[f64]) {
        for (dual, &x) in self.v.iter_mut().zip(v) {
            *dual = T::from(x);
        }
    }
}

/// Σ_j J_ij s_j and Σ_j |J_ij s_j| of the entries found in row i.
#[derive(Debug, Clone, Copy, Default)]
struct RowCheck {
    sum: f64,
    size: f64,
}

impl RowCheck {
    /// Whether the sweep along s gives the same row sum but for the rounding of two evaluations.
    fn agrees(self, sweep: f64) -> bool {
        // Intermediate terms of f may exceed the entries; a structural entry shows far above this.
        const RELATIVE: f64 = 1e-8;
        sweep.is_nan() || (sweep - self.sum).abs() <= RELATIVE * self.size.max(sweep.abs() * f64::EPSILON.sqrt())
    }
}

/// Directions without small integer relations between their components, so that entries do not cancel.
fn direction(j: usize) -> f64 {
    1.0 + 0.5 * ((j + 1) as f64).sin()
}

impl Sweeps {
    pub(super) fn new(dim: usize, structure: Structure) -> Self {
        Self {
            dim,
            first: Sweep::new(dim),
            second: Sweep::new(dim),
            row_check: Pool::new(move || vec![RowCheck::default(); dim]),
            coloring: Coloring::new(dim, &structure),
            directions: if structure == Structure::Dense { Vec::new() } else { (0..dim).map(direction).collect() },
            structure,
        }
    }

    pub(super) fn structure(&self) -> &Structure {
        &self.structure
    }

    pub(super) fn is_dense(&self) -> bool {
        self.structure == Structure::Dense
    }

    /// Adds `scale` · J to `out`.
    pub(super) fn add_jacobian(&self, rhs: Rhs<Dual64>, v: &[f64], scale: f64, out: &mut Jacobian) {
        if let Some((mut v, mut dv)) = self.few(v) {
            return add_dense(rhs, &mut v[..self.dim], &mut dv[..self.dim], scale, out);
        }
        self.first.with(|sweep| {
            sweep.seed(v);
            if self.is_dense() {
                return add_dense(rhs, &mut sweep.v, &mut sweep.dv, scale, out);
            }
            self.row_check.with(|rows| self.add_groups(rhs, sweep, rows, scale, out));
        });
    }

    /// Numbers on the stack for a dense system of few unknowns at v.
    fn few<T: Scalar>(&self, v: &[f64]) -> Option<([T; FEW], [T; FEW])> {
        if !self.is_dense() || self.dim > FEW {
            return None;
        }
        let mut few = [T::from(0.0); FEW];
        few.iter_mut().zip(v).for_each(|(dual, x)| *dual = T::from(*x));
        Some((few, [T::from(0.0); FEW]))
    }

    fn add_groups(
        &self,
        rhs: Rhs<Dual64>,
        sweep: &mut Sweep<Dual64>,
        row_check: &mut [RowCheck],
        scale: f64,
        out: &mut Jacobian,
    ) {
        row_check.fill(RowCheck::default());
        for c in 0..self.coloring.groups() {
            self.coloring.columns(c).for_each(|j| sweep.v[j].eps = 1.0);
            rhs(&sweep.v, &mut sweep.dv);
            self.coloring.columns(c).for_each(|j| sweep.v[j].eps = 0.0);
            for (i, j) in self.coloring.entries(c) {
                let entry = sweep.dv[i].eps;
                if entry != 0.0 {
                    out.add(i, j, scale * entry);
                    let along = entry * self.directions[j];
                    row_check[i].sum += along;
                    row_check[i].size += along.abs();
                }
            }
        }
        if self.has_declared_structure(rhs, sweep, row_check) {
            return;
        }
        let n = sweep.v.len();
        columns(rhs, &mut sweep.v, &mut sweep.dv, |i, j, entry| {
            if self.structure.rows(n, j).all(|row| row != i) {
                out.add(i, j, scale * entry);
            }
        });
    }

    /// Whether the derivative along [`direction`] is that of the entries in `row_check`.
    fn has_declared_structure(&self, rhs: Rhs<Dual64>, sweep: &mut Sweep<Dual64>, row_check: &[RowCheck]) -> bool {
        sweep.v.iter_mut().zip(&self.directions).for_each(|(x, direction)| x.eps = *direction);
        rhs(&sweep.v, &mut sweep.dv);
        sweep.v.iter_mut().for_each(|x| x.eps = 0.0);
        row_check.iter().zip(&sweep.dv).all(|(row, f)| row.agrees(f.eps))
    }

    /// Writes J x.
    pub(super) fn apply_jacobian(&self, rhs: Rhs<Dual64>, v: &[f64], x: &[f64], out: &mut [f64]) {
        self.first.with(|sweep| {
            sweep.seed(v);
            sweep.v.iter_mut().zip(x).for_each(|(dual, x)| dual.eps = *x);
            rhs(&sweep.v, &mut sweep.dv);
            out.iter_mut().zip(&sweep.dv).for_each(|(o, f)| *o = f.eps);
        });
    }

    /// Adds `scale` · Σ_i w_i ∂²f_i to `out`.
    pub(super) fn add_curvature(&self, rhs: Rhs<HyperDual64>, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        if let Some((mut v, mut dv)) = self.few(v) {
            return pairs(rhs, &mut v[..self.dim], &mut dv[..self.dim], w, scale, out);
        }
        self.second.with(|sweep| {
            sweep.seed(v);
            if self.is_dense() {
                return pairs(rhs, &mut sweep.v, &mut sweep.dv, w, scale, out);
            }
            for c in 0..self.coloring.groups() {
                self.coloring.columns(c).for_each(|j| sweep.v[j].eps1 = 1.0);
                for d in 0..=c {
                    self.coloring.columns(d).for_each(|k| sweep.v[k].eps2 = 1.0);
                    rhs(&sweep.v, &mut sweep.dv);
                    self.coloring.columns(d).for_each(|k| sweep.v[k].eps2 = 0.0);
                    for (i, j) in self.coloring.entries(c) {
                        let (Some(k), entry) = (self.coloring.column(d, i), scale * w[i] * sweep.dv[i].eps1eps2) else {
                            continue;
                        };
                        if entry != 0.0 {
                            out.add(j, k, entry);
                            if c != d {
                                out.add(k, j, entry);
                            }
                        }
                    }
                }
                self.coloring.columns(c).for_each(|j| sweep.v[j].eps1 = 0.0);
            }
        });
    }
}

/// Adds `scale` · J of a dense system at `v` to `out`; `dv` is work space.
fn add_dense(rhs: Rhs<Dual64>, v: &mut [Dual64], dv: &mut [Dual64], scale: f64, out: &mut Jacobian) {
    columns(rhs, v, dv, |i, j, entry| {
        if entry != 0.0 {
            out.add(i, j, scale * entry);
        }
    });
}

/// The entries of the Jacobian at `v`, column by column, as (i, j, entry); `dv` is work space.
fn columns(rhs: Rhs<Dual64>, v: &mut [Dual64], dv: &mut [Dual64], mut entry: impl FnMut(usize, usize, f64)) {
    for j in 0..v.len() {
        v[j].eps = 1.0;
        rhs(v, dv);
        v[j].eps = 0.0;
        dv.iter().enumerate().for_each(|(i, f)| entry(i, j, f.eps));
    }
}

/// Adds `scale` · Σ_i w_i ∂²f_i of a dense system at `v` to `out`; `dv` is work space.
fn pairs(
    rhs: Rhs<HyperDual64>,
    v: &mut [HyperDual64],
    dv: &mut [HyperDual64],
    w: &[f64],
    scale: f64,
    out: &mut Jacobian,
) {
    for j in 0..v.len() {
        v[j].eps1 = 1.0;
        for k in 0..=j {
            v[k].eps2 = 1.0;
            rhs(v, dv);
            v[k].eps2 = 0.0;
            add_symmetric(out, (j, k), scale * weighted(w, dv));
        }
        v[j].eps1 = 0.0;
    }
}

#[inline]
fn weighted(w: &[f64], f: &[HyperDual64]) -> f64 {
    w.iter().zip(f).map(|(w, f)| w * f.eps1eps2).sum()
}

#[inline]
fn add_symmetric(out: &mut Jacobian, (j, k): (usize, usize), entry: f64) {
    if entry != 0.0 {
        out.add(j, k, entry);
        if j != k {
            out.add(k, j, entry);
        }
    }
}
