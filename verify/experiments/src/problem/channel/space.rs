//! Discretisations in space of u_t = γ(t) + ν u_yy, u(−1) = 0, u(1) = w(t).
//!
//! With u(y, t) ≈ Σ c_i(t) φ_i(y) + w(t) ψ(y), where ψ is 1 at y = 1 and the φ_i vanish at both walls, all of them are
//! M ċ = −ν K c + γ b − w ν k − ẇ m.

use lsvi::quadrature::Quadrature;

use super::band::Band;

/// How the space is discretised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scheme {
    /// Central differences at the interior grid points.
    Differences,
    /// Balances of cells, fluxes by differences of the values at their centres; half a cell from the wall.
    Volumes,
    /// Galerkin's method with cubic Hermite elements: values and slopes at the grid points.
    Hermite,
    /// Galerkin's method with φ_k = (L_k − L_{k+2})/√(4k + 6), k < N (J. Shen, SIAM J. Sci. Comput. 15 (1994) 1489–1505).
    Legendre,
    /// Least squares of the residual u_t − γ − ν u_yy over piecewise linear elements, inside of which u_yy = 0: the viscosity
    /// drops out, and so does the diffusion. It is here to be seen failing.
    StrongLinear,
}

/// A discretisation with N cells.
#[derive(Debug)]
pub(super) struct Space {
    pub(super) scheme: Scheme,
    pub(super) cells: usize,
    /// M.
    pub(super) mass: Band,
    /// K.
    pub(super) stiffness: Band,
    /// b.
    pub(super) source: Vec<f64>,
    /// k.
    pub(super) wall_stiffness: Vec<f64>,
    /// m.
    pub(super) wall_mass: Vec<f64>,
}

/// The basis at a point.
#[derive(Debug)]
pub(super) struct Shapes {
    /// The φ_i that do not vanish there, with i.
    pub(super) basis: Vec<(usize, f64)>,
    /// ψ.
    pub(super) wall: f64,
}

/// Matrices of the cubic Hermite element of length 1 for values and slopes at its ends (Strang and Fix, *An Analysis of the
/// Finite Element Method*, 1973, Section 1.7): mass times 420, stiffness times 30, load times 12.
const HERMITE_MASS: [[f64; 4]; 4] =
    [[156.0, 22.0, 54.0, -13.0], [22.0, 4.0, 13.0, -3.0], [54.0, 13.0, 156.0, -22.0], [-13.0, -3.0, -22.0, 4.0]];
const HERMITE_STIFFNESS: [[f64; 4]; 4] =
    [[36.0, 3.0, -36.0, 3.0], [3.0, 4.0, -3.0, -1.0], [-36.0, -3.0, 36.0, -3.0], [3.0, -1.0, -3.0, 4.0]];
const HERMITE_LOAD: [f64; 4] = [6.0, 1.0, 6.0, -1.0];

impl Space {
    pub(super) fn new(scheme: Scheme, cells: usize) -> Self {
        match scheme {
            Scheme::Differences => Self::differences(cells),
            Scheme::Volumes => Self::volumes(cells),
            Scheme::Hermite => Self::hermite(cells),
            Scheme::Legendre => Self::legendre(cells),
            Scheme::StrongLinear => Self::strong_linear(cells),
        }
    }

    fn empty(scheme: Scheme, cells: usize, dim: usize, mass: Band, width: usize) -> Self {
        let zeros = || vec![0.0; dim];
        let stiffness = Band::zeros(dim, width.min(dim - 1));
        Self { scheme, cells, mass, stiffness, source: zeros(), wall_stiffness: zeros(), wall_mass: zeros() }
    }

    fn differences(cells: usize) -> Self {
        let (dim, scale) = (cells - 1, (0.5 * cells as f64).powi(2));
        let mut space = Self::empty(Scheme::Differences, cells, dim, Band::identity(dim), 1);
        space.source.fill(1.0);
        for i in 0..dim {
            space.stiffness.add(i, i, 2.0 * scale);
            if i > 0 {
                space.stiffness.add(i, i - 1, -scale);
            }
        }
        space.wall_stiffness[dim - 1] = -scale;
        space
    }

    fn volumes(cells: usize) -> Self {
        let length = 2.0 / cells as f64;
        let mut mass = Band::zeros(cells, 0);
        (0..cells).for_each(|i| mass.add(i, i, length));
        let mut space = Self::empty(Scheme::Volumes, cells, cells, mass, 1);
        space.source.fill(length);
        for face in 1..cells {
            space.stiffness.add(face, face, 1.0 / length);
            space.stiffness.add(face - 1, face - 1, 1.0 / length);
            space.stiffness.add(face, face - 1, -1.0 / length);
        }
        space.stiffness.add(0, 0, 2.0 / length);
        space.stiffness.add(cells - 1, cells - 1, 2.0 / length);
        space.wall_stiffness[cells - 1] = -2.0 / length;
        space
    }

    /// Slopes are multiplied by the length of an element.
    fn hermite(cells: usize) -> Self {
        let (dim, length) = (2 * cells, 2.0 / cells as f64);
        let mut space = Self::empty(Scheme::Hermite, cells, dim, Band::zeros(dim, 3.min(dim - 1)), 3);
        for element in 0..cells {
            let unknowns = hermite_unknowns(cells, element);
            for a in 0..4 {
                let Some(i) = unknowns[a] else { continue };
                space.source[i] += length / 12.0 * HERMITE_LOAD[a];
                for b in 0..4 {
                    let (m, k) = (length / 420.0 * HERMITE_MASS[a][b], HERMITE_STIFFNESS[a][b] / (30.0 * length));
                    match unknowns[b] {
                        Some(j) if j <= i => {
                            space.mass.add(i, j, m);
                            space.stiffness.add(i, j, k);
                        }
                        Some(_) => {}
                        None if element + 1 == cells && b == 2 => {
                            space.wall_mass[i] = m;
                            space.wall_stiffness[i] = k;
                        }
                        None => {}
                    }
                }
            }
        }
        space
    }

    /// ψ = (1 + y)/2. The slopes φ_k′ = −√(k + 3/2) L_{k+1} are orthonormal, so that K = I.
    fn legendre(cells: usize) -> Self {
        let mut mass = Band::zeros(cells, 2.min(cells - 1));
        let norm = |k: usize| 1.0 / (4.0 * k as f64 + 6.0).sqrt();
        for k in 0..cells {
            let square = |l: usize| 2.0 / (2.0 * l as f64 + 1.0);
            mass.add(k, k, (square(k) + square(k + 2)) * norm(k).powi(2));
            if k > 1 {
                mass.add(k, k - 2, -square(k) * norm(k) * norm(k - 2));
            }
        }
        let mut space = Self::empty(Scheme::Legendre, cells, cells, mass, 0);
        (0..cells).for_each(|k| space.stiffness.add(k, k, 1.0));
        space.source[0] = 2.0 * norm(0);
        space.wall_mass[0] = norm(0);
        space.wall_mass[1] = norm(1) / 3.0;
        space
    }

    fn strong_linear(cells: usize) -> Self {
        let (dim, length) = (cells - 1, 2.0 / cells as f64);
        let mut mass = Band::zeros(dim, 1.min(dim - 1));
        for i in 0..dim {
            mass.add(i, i, 2.0 / 3.0 * length);
            if i > 0 {
                mass.add(i, i - 1, length / 6.0);
            }
        }
        let mut space = Self::empty(Scheme::StrongLinear, cells, dim, mass, 0);
        space.source.fill(length);
        space.wall_mass[dim - 1] = length / 6.0;
        space
    }

    /// The points at which the flow is observed: the centres of volumes, else the interior grid points.
    pub(super) fn points(&self) -> Vec<f64> {
        let (n, cells) = (self.cells, self.cells as f64);
        match self.scheme {
            Scheme::Volumes => (0..n).map(|i| (2.0 * i as f64 + 1.0) / cells - 1.0).collect(),
            _ => (1..n).map(|i| 2.0 * i as f64 / cells - 1.0).collect(),
        }
    }

    /// The basis at y. The unknowns of differences and volumes are values at points, and y is taken for the nearest of them.
    pub(super) fn shapes(&self, y: f64) -> Shapes {
        let place = 0.5 * (1.0 + y) * self.cells as f64;
        let element = (place.floor() as usize).min(self.cells - 1);
        let x = place - element as f64;
        match self.scheme {
            Scheme::Differences => Shapes { basis: vec![(place.round() as usize - 1, 1.0)], wall: 0.0 },
            Scheme::Volumes => Shapes { basis: vec![(element, 1.0)], wall: 0.0 },
            Scheme::Hermite => {
                let cubics = [
                    (1.0 + 2.0 * x) * (1.0 - x).powi(2),
                    x * (1.0 - x).powi(2),
                    x * x * (3.0 - 2.0 * x),
                    x * x * (x - 1.0),
                ];
                let unknowns = hermite_unknowns(self.cells, element).into_iter().zip(cubics);
                let wall = if element + 1 == self.cells { cubics[2] } else { 0.0 };
                Shapes { basis: unknowns.filter_map(|(i, value)| Some((i?, value))).collect(), wall }
            }
            Scheme::Legendre => {
                let mut l = vec![1.0, y];
                for k in 2..self.cells + 2 {
                    let degree = k as f64;
                    l.push(((2.0 * degree - 1.0) * y * l[k - 1] - (degree - 1.0) * l[k - 2]) / degree);
                }
                let basis = (0..self.cells).map(|k| (k, (l[k] - l[k + 2]) / (4.0 * k as f64 + 6.0).sqrt())).collect();
                Shapes { basis, wall: 0.5 * (1.0 + y) }
            }
            Scheme::StrongLinear => {
                let hats = [(element.checked_sub(1), 1.0 - x), ((element + 1 < self.cells).then_some(element), x)];
                let wall = if element + 1 == self.cells { x } else { 0.0 };
                Shapes { basis: hats.into_iter().filter_map(|(i, value)| Some((i?, value))).collect(), wall }
            }
        }
    }

    /// The coefficients of `u`, which is 0 at y = −1 and `wall` at y = 1: its values at the points of differences and
    /// volumes, else its projection in the mean square.
    pub(super) fn project(&self, u: impl Fn(f64) -> f64, wall: f64) -> Vec<f64> {
        if matches!(self.scheme, Scheme::Differences | Scheme::Volumes) {
            return self.points().into_iter().map(u).collect();
        }
        let mut moments: Vec<f64> = self.wall_mass.iter().map(|m| -wall * m).collect();
        // One node is never refused. Sixteen integrate a product of cubics, and resolve φ_N where it oscillates fastest.
        let Ok(rule) = Quadrature::gauss(16) else { return moments };
        for cell in 0..self.cells {
            for (x, weight) in rule.nodes().iter().zip(rule.weights()) {
                let y = 2.0 * (cell as f64 + x) / self.cells as f64 - 1.0;
                let value = u(y) * weight * 2.0 / self.cells as f64;
                if value != 0.0 {
                    self.shapes(y).basis.into_iter().for_each(|(i, phi)| moments[i] += value * phi);
                }
            }
        }
        self.mass.cholesky().solve(&mut moments);
        moments
    }
}

/// The unknowns of an element: value and slope at its left end, value and slope at its right; no values at the walls.
fn hermite_unknowns(cells: usize, element: usize) -> [Option<usize>; 4] {
    let value = |node: usize| (node > 0 && node < cells).then(|| 2 * node - 1);
    let slope = |node: usize| Some(if node < cells { 2 * node } else { 2 * cells - 1 });
    [value(element), slope(element), value(element + 1), slope(element + 1)]
}
