//! Divergence-free velocities on a staggered (marker-and-cell) grid, spanned by a stream function at the corners.
//!
//! With u = (ψ(i, j+1) − ψ(i, j))/Δy on the vertical faces and v = −(ψ(i+1, j) − ψ(i, j))/Δx on the horizontal ones, the flux
//! out of every cell vanishes identically, and the pressure, whose gradient is orthogonal to all such velocities, drops out.

use lsvi::{Jacobian, Structure};

/// What a corner of the grid is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Corner {
    Unknown(usize),
    Boundary(usize),
}

/// How a rectangle is closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Closed {
    /// The velocity is given on all four sides.
    Sides,
    /// Periodic in x between two walls; the flow rate, ψ on the upper wall, is the last unknown.
    Walls,
}

/// A rectangle of equal cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rectangle {
    /// The lower left corner.
    pub(super) origin: [f64; 2],
    /// Lengths of the sides.
    pub(super) size: [f64; 2],
    /// Numbers of cells along them.
    pub(super) cells: [usize; 2],
    pub(super) closed: Closed,
}

impl Rectangle {
    pub(super) fn spacing(&self) -> [f64; 2] {
        [self.size[0] / self.cells[0] as f64, self.size[1] / self.cells[1] as f64]
    }

    /// The point that lies (i, j) cells from the lower left corner.
    pub(super) fn point(&self, i: f64, j: f64) -> [f64; 2] {
        // Exact on all sides: N · (1/N) is not 1 for some N.
        let along = |k: usize, at: f64| self.origin[k] + self.size[k] * (at / self.cells[k] as f64);
        [along(0, i), along(1, j)]
    }
}

/// Which of the two components of the velocity, and the direction that it has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Component {
    U,
    V,
}

/// A face where a velocity is an unknown of the flow, and has an equation of motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Face {
    pub(super) component: Component,
    /// Its place among the padded velocities.
    pub(super) at: usize,
    /// Its middle.
    pub(super) point: [f64; 2],
}

/// A tangential velocity that the boundary gives.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wall {
    pub(super) component: Component,
    pub(super) point: [f64; 2],
}

/// The space of discretely divergence-free velocities.
///
/// Velocities are kept with a rim of cells round the rectangle, so that every interior face has all its neighbours. They are
/// an affine function w = E (ψ; d) of the unknowns ψ and of the boundary's data d: the stream function on the boundary,
/// then the tangential velocities there. Across a wall, a velocity is continued to 2 u_wall − u.
#[derive(Debug)]
pub(super) struct Space {
    pub(super) rectangle: Rectangle,
    /// Padded velocities from one row of the grid to the next.
    pub(super) stride: usize,
    /// Padded velocities of one component.
    pub(super) padded: usize,
    pub(super) dim: usize,
    /// Where the unknowns are; the flow rate is on the upper wall.
    pub(super) corners: Vec<[f64; 2]>,
    pub(super) faces: Vec<Face>,
    /// Corners at which the boundary gives the stream function.
    pub(super) boundary: Vec<[f64; 2]>,
    pub(super) walls: Vec<Wall>,
    /// Of each of the `faces`.
    stencils: Stencils,
    /// Row p of E occupies `starts[p]..starts[p + 1]` of `entries`.
    starts: Vec<usize>,
    entries: Vec<(usize, f64)>,
    pub(super) structure: Structure,
}

impl Space {
    pub(super) fn new(rectangle: Rectangle) -> Self {
        let [nx, ny] = rectangle.cells;
        let stride = nx + 3;
        let padded = stride * (ny + 3);
        let mut builder = Builder::new(rectangle, stride, padded);
        builder.add_velocities();
        let (mut starts, mut entries) = (vec![0], Vec::new());
        for row in &builder.rows {
            entries.extend_from_slice(row);
            starts.push(entries.len());
        }
        let mut unknowns = vec![[0.0; 2]; builder.dim];
        for (c, corner) in builder.corners.iter().enumerate() {
            if let Corner::Unknown(k) = corner {
                unknowns[*k] = rectangle.point((c % (nx + 1)) as f64, (c / (nx + 1)) as f64);
            }
        }
        let Builder { dim, faces, boundary, walls, .. } = builder;
        let mut space = Self {
            rectangle,
            stride,
            padded,
            dim,
            corners: unknowns,
            faces,
            boundary,
            walls,
            stencils: Stencils::default(),
            starts,
            entries,
            structure: Structure::Dense,
        };
        space.stencils = space.stencils();
        space.structure = space.pattern();
        space
    }

    /// Area of a cell.
    pub(super) fn area(&self) -> f64 {
        let [dx, dy] = self.rectangle.spacing();
        dx * dy
    }

    /// Number of data of the boundary.
    pub(super) fn data(&self) -> usize {
        self.boundary.len() + self.walls.len()
    }

    fn row(&self, p: usize) -> &[(usize, f64)] {
        &self.entries[self.starts[p]..self.starts[p + 1]]
    }

    /// The entries of row `p` of E that belong to unknowns.
    pub(super) fn unknowns(&self, p: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.row(p).iter().copied().filter(|(k, _)| *k < self.dim)
    }

    /// Sets w = E (ψ; d); without data, w = E (ψ; 0).
    pub(super) fn velocities(&self, psi: &[f64], data: Option<&[f64]>, w: &mut [f64]) {
        for (w, ends) in w.iter_mut().zip(self.starts.windows(2)) {
            *w = self.entries[ends[0]..ends[1]]
                .iter()
                .map(|&(k, e)| e * if k < self.dim { psi[k] } else { data.map_or(0.0, |d| d[k - self.dim]) })
                .sum();
        }
    }

    /// The part of the velocity at `face` that the boundary's data contribute.
    pub(super) fn lifted(&self, face: &Face, data: &[f64]) -> f64 {
        self.row(face.at).iter().filter(|(k, _)| *k >= self.dim).map(|&(k, e)| e * data[k - self.dim]).sum()
    }

    /// Adds Eᵀ w to `out`, without the data.
    pub(super) fn add_transpose(&self, w: &[f64], out: &mut [f64]) {
        for (p, w) in w.iter().enumerate().filter(|(_, w)| **w != 0.0) {
            self.unknowns(p).for_each(|(k, e)| out[k] += e * w);
        }
    }

    /// Adds Σ Δx Δy a over the `faces`, tested by each basis function: the discrete form of ∫ a · curl ψ.
    pub(super) fn test(&self, accelerations: impl Iterator<Item = f64>, out: &mut [f64]) {
        let area = self.area();
        for (face, a) in self.faces.iter().zip(accelerations) {
            self.unknowns(face.at).for_each(|(k, e)| out[k] += area * e * a);
        }
    }

    /// The mass matrix M = Σ Δx Δy over the faces, so that ½ ψᵀMψ is the kinetic energy.
    pub(super) fn mass(&self) -> Jacobian {
        let mut mass = Jacobian::with_structure(self.dim, &self.structure);
        let area = self.area();
        for face in &self.faces {
            for (k, a) in self.unknowns(face.at) {
                self.unknowns(face.at).for_each(|(l, b)| mass.add(k, l, area * a * b));
            }
        }
        mass
    }

    /// The spacings along the direction of a component and across it.
    pub(super) fn step(&self, component: Component) -> [f64; 2] {
        let [dx, dy] = self.rectangle.spacing();
        if component == Component::U { [dx, dy] } else { [dy, dx] }
    }

    /// Where the nine velocities are on which the acceleration of `face` depends, in the order of
    /// [`acceleration`](super::momentum::acceleration).
    pub(super) fn neighbours(&self, face: &Face) -> [usize; 9] {
        let (along, across, own, other) = match face.component {
            Component::U => (1, self.stride, 0, self.padded),
            Component::V => (self.stride, 1, self.padded, 0),
        };
        let (p, q) = (face.at, face.at - own + other);
        [p, p + along, p - along, p + across, p - across, q - along + across, q + across, q - along, q]
    }

    /// Each face with the unknowns that its acceleration depends on, and how its nine velocities do.
    pub(super) fn with_stencils(&self) -> impl Iterator<Item = (&Face, &[usize], &[Term])> {
        let Stencils { ends, unknowns, terms } = &self.stencils;
        let starts = std::iter::once(&[0; 2]).chain(ends);
        self.faces
            .iter()
            .zip(starts.zip(ends))
            .map(|(face, (start, end))| (face, &unknowns[start[0]..end[0]], &terms[start[1]..end[1]]))
    }

    fn stencils(&self) -> Stencils {
        let mut stencils = Stencils::default();
        let Stencils { ends, unknowns, terms } = &mut stencils;
        for face in &self.faces {
            let first = unknowns.len();
            for (neighbour, q) in self.neighbours(face).into_iter().enumerate() {
                for (l, entry) in self.unknowns(q) {
                    let known = unknowns[first..].iter().position(|unknown| *unknown == l);
                    let unknown = known.unwrap_or(unknowns.len() - first);
                    if known.is_none() {
                        unknowns.push(l);
                    }
                    terms.push(Term { neighbour, unknown, entry });
                }
            }
            ends.push([unknowns.len(), terms.len()]);
        }
        stencils
    }

    fn pattern(&self) -> Structure {
        let mut positions = Vec::new();
        for (face, unknowns, _) in self.with_stencils() {
            self.unknowns(face.at).for_each(|(k, _)| positions.extend(unknowns.iter().map(|&l| (k, l))));
        }
        positions.sort_unstable();
        positions.dedup();
        // Every position belongs to two unknowns.
        Structure::sparse(self.dim, positions).unwrap_or_default()
    }
}

/// The unknowns on which accelerations depend, one face after the other.
#[derive(Debug, Default)]
struct Stencils {
    /// Where those of a face end, and its terms.
    ends: Vec<[usize; 2]>,
    unknowns: Vec<usize>,
    terms: Vec<Term>,
}

/// An entry of E in the row of a velocity round a face.
#[derive(Debug, Clone, Copy)]
pub(super) struct Term {
    /// Which of the nine velocities it is.
    pub(super) neighbour: usize,
    /// The place of the unknown among those of the face.
    pub(super) unknown: usize,
    pub(super) entry: f64,
}

/// Where the velocity of cell face (i, j) is kept: u at (i, j + ½), v at (i + ½, j).
pub(super) fn place(stride: usize, padded: usize, component: Component, i: isize, j: isize) -> usize {
    let own = if component == Component::U { 0 } else { padded };
    own + (j + 1) as usize * stride + (i + 1) as usize
}

struct Builder {
    rectangle: Rectangle,
    stride: usize,
    padded: usize,
    dim: usize,
    /// Row by row.
    corners: Vec<Corner>,
    boundary: Vec<[f64; 2]>,
    walls: Vec<Wall>,
    faces: Vec<Face>,
    rows: Vec<Vec<(usize, f64)>>,
}

impl Builder {
    fn new(rectangle: Rectangle, stride: usize, padded: usize) -> Self {
        let [nx, ny] = rectangle.cells;
        let mut boundary = Vec::new();
        let mut corners = Vec::with_capacity((nx + 1) * (ny + 1));
        let mut given = |i: usize, j: usize| {
            boundary.push(rectangle.point(i as f64, j as f64));
            Corner::Boundary(boundary.len() - 1)
        };
        let flow_rate = nx * (ny - 1);
        for j in 0..=ny {
            for i in 0..=nx {
                corners.push(match rectangle.closed {
                    Closed::Sides if i == 0 || i == nx || j == 0 || j == ny => given(i, j),
                    Closed::Sides => Corner::Unknown((j - 1) * (nx - 1) + i - 1),
                    Closed::Walls if j == 0 => given(i, j),
                    Closed::Walls if j == ny => Corner::Unknown(flow_rate),
                    Closed::Walls => Corner::Unknown((j - 1) * nx + i % nx),
                });
            }
        }
        let dim = match rectangle.closed {
            Closed::Sides => (nx - 1) * (ny - 1),
            Closed::Walls => flow_rate + 1,
        };
        Self {
            rectangle,
            stride,
            padded,
            dim,
            corners,
            boundary,
            walls: Vec::new(),
            faces: Vec::new(),
            rows: vec![Vec::new(); 2 * padded],
        }
    }

    fn corner(&self, i: usize, j: usize) -> usize {
        match self.corners[j * (self.rectangle.cells[0] + 1) + i] {
            Corner::Unknown(k) => k,
            Corner::Boundary(k) => self.dim + k,
        }
    }

    fn add_velocities(&mut self) {
        let [nx, ny] = self.rectangle.cells;
        let periodic = self.rectangle.closed == Closed::Walls;
        let [dx, dy] = self.rectangle.spacing();
        for j in 0..ny {
            for i in 0..=nx {
                let row = vec![(self.corner(i, j + 1), 1.0 / dy), (self.corner(i, j), -1.0 / dy)];
                self.set(Component::U, i as isize, j as isize, row);
                if if periodic { i < nx } else { i > 0 && i < nx } {
                    self.add_face(Component::U, i, j);
                }
            }
        }
        for j in 0..=ny {
            for i in 0..nx {
                let row = vec![(self.corner(i + 1, j), -1.0 / dx), (self.corner(i, j), 1.0 / dx)];
                self.set(Component::V, i as isize, j as isize, row);
                if j > 0 && j < ny {
                    self.add_face(Component::V, i, j);
                }
            }
        }
        let (right, top) = (nx as isize, ny as isize);
        for i in 0..=right {
            self.reflect(Component::U, (i, 0), (i, -1), [i as f64, 0.0]);
            self.reflect(Component::U, (i, top - 1), (i, top), [i as f64, ny as f64]);
        }
        if periodic {
            for j in -1..=top {
                self.copy(Component::U, (right - 1, j), (-1, j));
                self.copy(Component::U, (0, j), (right, j));
            }
            for j in 0..=top {
                self.copy(Component::V, (right - 1, j), (-1, j));
                self.copy(Component::V, (0, j), (right, j));
            }
        } else {
            for j in 0..=top {
                self.reflect(Component::V, (0, j), (-1, j), [0.0, j as f64]);
                self.reflect(Component::V, (right - 1, j), (right, j), [nx as f64, j as f64]);
            }
        }
    }

    fn add_face(&mut self, component: Component, i: usize, j: usize) {
        let at = place(self.stride, self.padded, component, i as isize, j as isize);
        let (x, y) = (i as f64, j as f64);
        let point = match component {
            Component::U => self.rectangle.point(x, y + 0.5),
            Component::V => self.rectangle.point(x + 0.5, y),
        };
        self.faces.push(Face { component, at, point });
    }

    fn set(&mut self, component: Component, i: isize, j: isize, row: Vec<(usize, f64)>) {
        let p = place(self.stride, self.padded, component, i, j);
        self.rows[p] = row;
    }

    fn copy(&mut self, component: Component, from: (isize, isize), to: (isize, isize)) {
        let row = self.rows[place(self.stride, self.padded, component, from.0, from.1)].clone();
        self.set(component, to.0, to.1, row);
    }

    /// Continues a velocity across the wall whose point lies `wall` cells from the lower left corner.
    fn reflect(&mut self, component: Component, from: (isize, isize), to: (isize, isize), wall: [f64; 2]) {
        let inside = &self.rows[place(self.stride, self.padded, component, from.0, from.1)];
        let mut row: Vec<_> = inside.iter().map(|&(k, e)| (k, -e)).collect();
        row.push((self.dim + self.boundary.len() + self.walls.len(), 2.0));
        self.walls.push(Wall { component, point: self.rectangle.point(wall[0], wall[1]) });
        self.set(component, to.0, to.1, row);
    }
}
