//! The augmented formulation: twice the unknowns, the condition number of B.

use crate::error::SolveError;
use crate::linalg::{Jacobian, Lu, Structure};
use crate::mass::Mass;

/// Positions of the two unknowns (y_i, x_i) of a component, and of its equations: the transposed one, Bᵀ y − M x, first,
/// so that B is on the diagonal and the bandwidth of a banded B doubles, no more.
pub(super) fn first(i: usize) -> usize {
    2 * i
}
pub(super) fn second(i: usize) -> usize {
    2 * i + 1
}

/// The structure of [[M, B], [Bᵀ, −M − C]] with B and M of the given structure and C of the structure `curvature`, if any.
pub(super) fn structure_of(dim: usize, structure: &Structure, mass: &Mass, curvature: Option<&Structure>) -> Structure {
    let width = |structure: &Structure| match structure {
        Structure::Banded { lower, upper } => (*lower.max(upper)).min(dim),
        _ => 0,
    };
    match structure {
        Structure::Dense | Structure::MatrixFree => structure.clone(),
        Structure::Banded { .. } => {
            let of_mass = if matches!(mass, Mass::Matrix(_)) { width(structure) } else { 0 };
            let block = of_mass.max(curvature.map_or(0, width));
            let half = (2 * width(structure)).max(2 * block + 1);
            Structure::Banded { lower: half, upper: half }
        }
        Structure::Sparse(_) => {
            let entries =
                |of: &Structure| (0..dim).flat_map(|j| of.rows(dim, j).map(move |i| (i, j))).collect::<Vec<_>>();
            let mut positions = Vec::new();
            for (i, j) in entries(structure) {
                positions.extend([(second(i), second(j)), (first(j), first(i))]);
                positions.extend([(second(i), first(j)), (first(i), second(j))]);
            }
            positions
                .extend(curvature.map(entries).unwrap_or_default().into_iter().map(|(j, k)| (first(j), second(k))));
            Structure::sparse(2 * dim, positions).expect("all positions are below twice the order")
        }
    }
}

/// Adds B, and Bᵀ in its place.
pub(super) fn add_b(b: &Jacobian, out: &mut Jacobian) {
    b.for_each(|i, j, x| {
        out.add(second(i), second(j), x);
        out.add(first(j), first(i), x);
    });
}

/// LU factors of [[M, B], [Bᵀ, −(1 + μ) M]].
#[derive(Debug)]
pub(super) struct Augmented {
    matrix: Jacobian,
    lu: Lu,
    unknowns: Vec<f64>,
}

impl Augmented {
    pub(super) fn new(dim: usize, structure: &Structure, mass: &Mass) -> Self {
        let matrix = Jacobian::with_structure(2 * dim, &structure_of(dim, structure, mass, None));
        Self { lu: Lu::of(&matrix), matrix, unknowns: vec![0.0; 2 * dim] }
    }

    pub(super) fn factor(&mut self, mass: &Mass, b: &Jacobian, damping: f64) -> Result<(), SolveError> {
        self.matrix.clear();
        add_b(b, &mut self.matrix);
        mass.for_each(b.dim(), |i, j, m| {
            self.matrix.add(second(i), first(j), m);
            self.matrix.add(first(i), second(j), -(1.0 + damping) * m);
        });
        Ok(self.lu.factor(&self.matrix)?)
    }

    /// Overwrites `b` with x of M y + B x = a, Bᵀ y − (1 + μ) M x = −b.
    pub(super) fn solve(&mut self, a: &[f64], b: &mut [f64]) {
        for ((pair, a), b) in self.unknowns.chunks_exact_mut(2).zip(a).zip(b.iter()) {
            pair.copy_from_slice(&[-b, *a]);
        }
        self.lu.solve(&mut self.unknowns);
        for (b, pair) in b.iter_mut().zip(self.unknowns.chunks_exact(2)) {
            *b = pair[1];
        }
    }
}
