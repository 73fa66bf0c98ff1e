//! The flows in a rectangle once more, for the references: ψ̇ = M⁻¹ f by loops over the corners.

use std::ops::RangeInclusive;
use std::sync::OnceLock;

use faer::linalg::solvers::SolveCore;
use faer::sparse::linalg::solvers::Llt;
use faer::sparse::{SparseColMat, Triplet};
use faer::{ColMut, Conj, Side};

use super::confined::Given;
use super::staggered::{Closed, Rectangle};
use crate::measure::norm::max_norm;
use crate::reference::Ode;

/// Cholesky factors.
pub(super) type Factors = Llt<usize, f64>;

/// The system written out: velocities from differences of ψ, the momentum equation in fluxes through the sides of the cell
/// round each face, and its circulation round every corner.
#[derive(Debug)]
pub(super) struct ByHand<'a> {
    pub(super) rectangle: Rectangle,
    pub(super) nu: f64,
    pub(super) given: &'a dyn Given,
    /// Of M, found when they are asked for.
    pub(super) factors: &'a OnceLock<Option<Factors>>,
}

/// Values at (i, j), each found once: on walls they are dear.
struct Grid {
    first: [isize; 2],
    columns: usize,
    values: Vec<f64>,
}

impl Grid {
    fn of(i: RangeInclusive<isize>, j: RangeInclusive<isize>, value: impl Fn(isize, isize) -> f64) -> Self {
        let (first, columns) = ([*i.start(), *j.start()], i.clone().count());
        let values = j.flat_map(|j| i.clone().map(move |i| (i, j))).map(|(i, j)| value(i, j)).collect();
        Self { first, columns, values }
    }

    fn at(&self, i: isize, j: isize) -> f64 {
        let [i, j] = [i - self.first[0], j - self.first[1]].map(|k| k as usize);
        self.values[j * self.columns + i]
    }
}

impl ByHand<'_> {
    fn periodic(&self) -> bool {
        self.rectangle.closed == Closed::Walls
    }

    /// Unknown corners along x.
    fn columns(&self) -> usize {
        self.rectangle.cells[0] - usize::from(!self.periodic())
    }

    /// The unknown at corner (i, j), where there is one.
    fn unknown(&self, i: isize, j: isize) -> Option<usize> {
        let [nx, ny] = self.rectangle.cells.map(|n| n as isize);
        if self.periodic() {
            return match j {
                0 => None,
                j if j == ny => Some((nx * (ny - 1)) as usize),
                j => Some(((j - 1) * nx + i.rem_euclid(nx)) as usize),
            };
        }
        let inside = i > 0 && i < nx && j > 0 && j < ny;
        inside.then(|| ((j - 1) * (nx - 1) + i - 1) as usize)
    }

    fn corner(&self, i: isize, j: isize) -> [f64; 2] {
        self.rectangle.point(i as f64, j as f64)
    }

    /// ψ at a corner, and what its rate is without the unknowns.
    fn psi(&self, t: f64, v: &[f64], i: isize, j: isize) -> f64 {
        self.unknown(i, j).map_or_else(|| self.given.stream(self.corner(i, j), t), |k| v[k])
    }

    fn psi_rate(&self, t: f64, i: isize, j: isize) -> f64 {
        self.unknown(i, j).map_or_else(|| self.given.stream_rate(self.corner(i, j), t), |_| 0.0)
    }

    /// u at (i, j + ½), continued beyond the walls.
    fn u(&self, t: f64, psi: &Grid, i: isize, j: isize) -> f64 {
        let ny = self.rectangle.cells[1] as isize;
        if j < 0 || j >= ny {
            let (inside, wall) = if j < 0 { (0, 0) } else { (ny - 1, ny) };
            return 2.0 * self.given.velocity(self.corner(i, wall), t)[0] - self.u(t, psi, i, inside);
        }
        (psi.at(i, j + 1) - psi.at(i, j)) / self.rectangle.spacing()[1]
    }

    /// v at (i + ½, j).
    fn v(&self, t: f64, psi: &Grid, i: isize, j: isize) -> f64 {
        let nx = self.rectangle.cells[0] as isize;
        if !self.periodic() && (i < 0 || i >= nx) {
            let (inside, wall) = if i < 0 { (0, 0) } else { (nx - 1, nx) };
            return 2.0 * self.given.velocity(self.corner(wall, j), t)[1] - self.v(t, psi, inside, j);
        }
        (psi.at(i, j) - psi.at(i + 1, j)) / self.rectangle.spacing()[0]
    }

    /// u and v on all faces that fluxes are made of.
    fn velocities(&self, t: f64, v: &[f64]) -> [Grid; 2] {
        let [nx, ny] = self.rectangle.cells.map(|n| n as isize);
        let beyond = isize::from(self.periodic());
        let psi = Grid::of(-beyond..=nx + beyond, 0..=ny, |i, j| self.psi(t, v, i, j));
        [
            Grid::of(-beyond..=nx, -1..=ny, |i, j| self.u(t, &psi, i, j)),
            Grid::of(-1..=nx, 0..=ny, |i, j| self.v(t, &psi, i, j)),
        ]
    }

    fn force(&self, t: f64, i: f64, j: f64) -> [f64; 2] {
        self.given.force(self.rectangle.point(i, j), t).unwrap_or([0.0; 2])
    }

    /// u_t at (i, j + ½) but for the pressure.
    fn u_rate(&self, t: f64, [u, v]: &[Grid; 2], i: isize, j: isize) -> f64 {
        let [dx, dy] = self.rectangle.spacing();
        let flux_x = |i: isize| {
            let (a, b) = (u.at(i, j), u.at(i + 1, j));
            0.25 * (a + b) * (a + b) - self.nu * (b - a) / dx
        };
        let flux_y = |j: isize| {
            let (a, b) = (u.at(i, j - 1), u.at(i, j));
            0.25 * (a + b) * (v.at(i - 1, j) + v.at(i, j)) - self.nu * (b - a) / dy
        };
        let [force, _] = self.force(t, i as f64, j as f64 + 0.5);
        let given = (self.psi_rate(t, i, j + 1) - self.psi_rate(t, i, j)) / dy;
        (flux_x(i - 1) - flux_x(i)) / dx + (flux_y(j) - flux_y(j + 1)) / dy + force - given
    }

    /// v_t at (i + ½, j) but for the pressure.
    fn v_rate(&self, t: f64, [u, v]: &[Grid; 2], i: isize, j: isize) -> f64 {
        let [dx, dy] = self.rectangle.spacing();
        let flux_x = |i: isize| {
            let (a, b) = (v.at(i - 1, j), v.at(i, j));
            0.25 * (a + b) * (u.at(i, j - 1) + u.at(i, j)) - self.nu * (b - a) / dx
        };
        let flux_y = |j: isize| {
            let (a, b) = (v.at(i, j), v.at(i, j + 1));
            0.25 * (a + b) * (a + b) - self.nu * (b - a) / dy
        };
        let [_, force] = self.force(t, i as f64 + 0.5, j as f64);
        let given = (self.psi_rate(t, i, j) - self.psi_rate(t, i + 1, j)) / dx;
        (flux_x(i) - flux_x(i + 1)) / dx + (flux_y(j - 1) - flux_y(j)) / dy + force - given
    }

    /// f: the circulation of the accelerations round each corner, in the area of a cell.
    fn circulations(&self, t: f64, v: &[f64]) -> Vec<f64> {
        let ([dx, dy], [nx, ny]) = (self.rectangle.spacing(), self.rectangle.cells);
        let (columns, first) = (self.columns(), isize::from(!self.periodic()));
        let velocities = &self.velocities(t, v);
        let along: Vec<Vec<f64>> = (0..ny as isize)
            .map(|j| (first..first + columns as isize).map(|i| self.u_rate(t, velocities, i, j)).collect())
            .collect();
        let across: Vec<Vec<f64>> =
            (1..ny as isize).map(|j| (0..nx as isize).map(|i| self.v_rate(t, velocities, i, j)).collect()).collect();
        let mut f = Vec::with_capacity(self.dim());
        for (pair, across) in along.windows(2).zip(&across) {
            f.extend((0..columns).map(|i| {
                let (right, left) = if self.periodic() { (i, (i + nx - 1) % nx) } else { (i + 1, i) };
                dx * (pair[0][i] - pair[1][i]) + dy * (across[right] - across[left])
            }));
        }
        if self.periodic() {
            f.push(dx * along[ny - 1].iter().sum::<f64>());
        }
        f
    }

    /// M⁻¹ by the factors of M: the five-point formula, and on the upper wall of a channel the sum over its corners, times the
    /// area of a cell.
    fn solve(&self, f: &mut [f64]) {
        let factors = self.factors.get_or_init(|| {
            let [dx, dy] = self.rectangle.spacing();
            let n = self.dim();
            let mut m = Vec::new();
            for j in 1..self.rectangle.cells[1] as isize {
                for i in 0..=self.columns() as isize {
                    let Some(k) = self.unknown(i, j).filter(|_| i < self.rectangle.cells[0] as isize) else { continue };
                    m.push(Triplet::new(k, k, 2.0 * (dy / dx + dx / dy)));
                    for (i, j, weight) in
                        [(i - 1, j, dy / dx), (i + 1, j, dy / dx), (i, j - 1, dx / dy), (i, j + 1, dx / dy)]
                    {
                        let Some(l) = self.unknown(i, j) else { continue };
                        m.push(Triplet::new(k, l, -weight));
                        if self.periodic() && j == self.rectangle.cells[1] as isize {
                            m.extend([Triplet::new(l, k, -weight), Triplet::new(l, l, weight)]);
                        }
                    }
                }
            }
            // Diagonally dominant with a boundary where ψ is given: positive definite.
            SparseColMat::try_new_from_triplets(n, n, &m).ok()?.sp_cholesky(Side::Lower).ok()
        });
        match factors {
            Some(factors) => factors.solve_in_place_with_conj(Conj::No, ColMut::from_slice_mut(f).as_mat_mut()),
            None => f.fill(f64::NAN),
        }
    }
}

impl Ode for ByHand<'_> {
    fn dim(&self) -> usize {
        let [nx, ny] = self.rectangle.cells;
        if self.periodic() { nx * (ny - 1) + 1 } else { (nx - 1) * (ny - 1) }
    }

    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        dv.copy_from_slice(&self.circulations(t, v));
        self.solve(dv);
    }

    /// By columns.
    fn jacobian(&self, t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        let (mut unit, mut column) = (vec![0.0; v.len()], vec![0.0; v.len()]);
        for k in 0..v.len() {
            unit[k] = 1.0;
            self.product(t, v, &unit, &mut column);
            column.iter().enumerate().for_each(|(i, x)| add(i, k, *x));
            unit[k] = 0.0;
        }
    }

    /// f is quadratic, so that its central difference with any step is its derivative; with one of the size of v least is
    /// rounded off.
    fn product(&self, t: f64, v: &[f64], x: &[f64], out: &mut [f64]) {
        let size = max_norm(x);
        out.fill(0.0);
        if size == 0.0 {
            return;
        }
        let step = max_norm(v).max(1e-3) / size;
        let at = |s: f64| self.circulations(t, &v.iter().zip(x).map(|(v, x)| v + s * x).collect::<Vec<_>>());
        let (above, below) = (at(step), at(-step));
        for (out, (a, b)) in out.iter_mut().zip(above.iter().zip(&below)) {
            *out = (a - b) / (2.0 * step);
        }
        self.solve(out);
    }

    fn is_matrix_free(&self) -> bool {
        true
    }
}
