//! The augmented formulation: twice the unknowns, the condition number of B.

use super::{StepSolver, check_assembled};
use crate::error::{InputError, SolveError};
use crate::linalg::{Jacobian, Lu, Structure};
use crate::mass::Mass;
use crate::operator::StepOperator;

/// Positions of the two unknowns (y_i, x_i) of a component, and of its equations: the transposed one, Bᵀ y − M x, first,
/// so that B is on the diagonal and the bandwidth of a banded B doubles, no more.
pub(crate) fn first(i: usize) -> usize {
    2 * i
}
pub(crate) fn second(i: usize) -> usize {
    2 * i + 1
}

/// The structure of [[M, B], [Bᵀ, −M − C]] with B and M of the given structure and C, if any, of the structure `curvature` with what the transpose of B
/// has besides: closures other than Method I have the matrix of their start there.
pub(crate) fn structure_of(dim: usize, structure: &Structure, mass: &Mass, curvature: Option<&Structure>) -> Structure {
    let width = |structure: &Structure| match structure {
        Structure::Banded { lower, upper } => (*lower.max(upper)).min(dim),
        _ => 0,
    };
    match structure {
        Structure::Dense | Structure::MatrixFree => structure.clone(),
        Structure::Banded { .. } => {
            let of_mass = if matches!(mass, Mass::Matrix(_)) { width(structure) } else { 0 };
            let block = of_mass.max(curvature.map_or(0, |curvature| width(curvature).max(width(structure))));
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
            if let Some(curvature) = curvature {
                positions.extend(entries(curvature).into_iter().map(|(j, k)| (first(j), second(k))));
                positions.extend(entries(structure).into_iter().map(|(i, j)| (first(j), second(i))));
            }
            Structure::sparse(2 * dim, positions).expect("all positions are below twice the order")
        }
    }
}

/// Adds B, and Bᵀ in its place.
fn add_b(b: &Jacobian, out: &mut Jacobian) {
    b.for_each(|i, j, x| {
        out.add(second(i), second(j), x);
        out.add(first(j), first(i), x);
    });
}

/// LU factors: of B for implicit stages, of [[M, B], [Bᵀ, −(1 + μ) M]] for the normal equations, the two unknowns of a component
/// next to each other. That matrix is as well conditioned as B itself.
#[derive(Debug, Default)]
pub struct Augmented {
    stage: Option<Lu>,
    stage_is_current: bool,
    normal: Option<Normal>,
}

#[derive(Debug)]
struct Normal {
    matrix: Jacobian,
    lu: Lu,
    /// The damping of the factors, if they are those of the present B.
    damping: Option<f64>,
    unknowns: Vec<f64>,
}

impl Augmented {
    /// Factors are set up in the first step.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Normal {
    fn new(b: &Jacobian, mass: &Mass) -> Self {
        let dim = b.dim();
        let matrix = Jacobian::with_structure(2 * dim, &structure_of(dim, &b.structure(), mass, None));
        Self { lu: Lu::of(&matrix), matrix, damping: None, unknowns: vec![0.0; 2 * dim] }
    }

    fn factor(&mut self, mass: &Mass, b: &Jacobian, damping: f64) -> Result<(), SolveError> {
        if self.damping == Some(damping) {
            return Ok(());
        }
        self.damping = None;
        self.matrix.clear();
        add_b(b, &mut self.matrix);
        mass.for_each(b.dim(), |i, j, m| {
            self.matrix.add(second(i), first(j), m);
            self.matrix.add(first(i), second(j), -(1.0 + damping) * m);
        });
        self.lu.factor(&self.matrix)?;
        self.damping = Some(damping);
        Ok(())
    }

    /// Overwrites `b` with x of M y + B x = a, Bᵀ y − (1 + μ) M x = −b.
    fn solve(&mut self, a: Option<&[f64]>, b: &mut [f64]) {
        for (i, (pair, b)) in self.unknowns.chunks_exact_mut(2).zip(b.iter()).enumerate() {
            pair.copy_from_slice(&[-b, a.map_or(0.0, |a| a[i])]);
        }
        self.lu.solve(&mut self.unknowns);
        for (b, pair) in b.iter_mut().zip(self.unknowns.chunks_exact(2)) {
            *b = pair[1];
        }
    }
}

impl StepSolver for Augmented {
    fn check(&self, structure: &Structure, mass: &Mass) -> Result<(), InputError> {
        check_assembled(structure, mass)
    }

    fn prepare(&mut self, b: &StepOperator<'_>) -> Result<(), SolveError> {
        b.assembled().ok_or(SolveError::NotAssembled)?.check_structure()?;
        self.stage_is_current = false;
        if let Some(normal) = &mut self.normal {
            normal.damping = None;
        }
        Ok(())
    }

    fn solve_stage(&mut self, b: &StepOperator<'_>, x: &mut [f64], _tolerance: f64) -> Result<u64, SolveError> {
        let b = b.assembled().ok_or(SolveError::NotAssembled)?;
        let lu = self.stage.get_or_insert_with(|| Lu::of(b));
        if !self.stage_is_current {
            lu.factor(b)?;
            self.stage_is_current = true;
        }
        lu.solve(x);
        Ok(0)
    }

    fn solve_normal(
        &mut self,
        b: &StepOperator<'_>,
        damping: f64,
        a: Option<&[f64]>,
        x: &mut [f64],
        _tolerance: f64,
    ) -> Result<u64, SolveError> {
        let (matrix, mass) = (b.assembled().ok_or(SolveError::NotAssembled)?, b.mass());
        let normal = self.normal.get_or_insert_with(|| Normal::new(matrix, mass));
        normal.factor(mass, matrix, damping)?;
        normal.solve(a, x);
        Ok(0)
    }
}
