//! What a system is like along its solution.

use lsvi::{Jacobian, Mass, Structure};
use nalgebra::{DMatrix, DVector};

use super::worst;
use crate::measure::norm::{Extremes, distance, max_norm};
use crate::measure::stability::{numerical_abscissa, spectral_abscissa, spectral_radius};
use crate::method::Method;
use crate::problem::Problem;
use crate::run::{run, run_through_from};

/// Unknowns of the largest system that is looked at.
const LARGEST: usize = 200;
/// Instants at which it is looked at.
const INSTANTS: usize = 32;
/// Times at which two solutions are compared.
const SIXTEEN: u32 = 16;
/// Growth by which a solution that cannot be followed further has blown up.
const BLOWN: f64 = 1e6;
/// Relative size below which an entry is roundoff of derivatives.
const ROUNDOFF: f64 = 1e-9;

/// What a system is like along its solution.
#[derive(Debug, Clone, PartialEq)]
pub struct Character {
    /// Its unknowns.
    pub unknowns: usize,
    /// The rest, if its matrices were looked at.
    pub matrices: Option<Matrices>,
    /// How far two solutions part that start a millionth apart: the factor, largest at sixteen times.
    pub parting: f64,
    /// The largest component at the start, and on the way.
    pub sizes: (f64, f64),
    /// The time up to which the solution was followed.
    pub reached: f64,
}

/// What the Jacobians A = M⁻¹ ∂f/∂v along the solution say, in coordinates where M = I.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrices {
    /// The instants.
    pub instants: usize,
    /// Largest |λ|.
    pub fastest: f64,
    /// Largest Re λ.
    pub spectral: f64,
    /// Largest eigenvalue of (A + Aᵀ)/2.
    pub numerical: f64,
    /// Largest ‖A − Aᵀ‖ over ‖A‖, 0 for a symmetric system.
    pub asymmetry: f64,
    /// Linear invariants: w with wᵀM v constant.
    pub invariants: usize,
    /// A with the largest |λ| of the instants at which no perturbation grows.
    pub calm: Option<DMatrix<f64>>,
    /// Whether ΩA is symmetric at all instants, with momenta after coordinates, or each after its own.
    pub is_hamiltonian: bool,
}

impl Matrices {
    /// Whether no two solutions part, in the norm of M.
    pub fn is_dissipative(&self) -> bool {
        self.numerical <= ROUNDOFF * self.fastest
    }

    /// Whether solutions may grow although no eigenvalue says so.
    pub fn is_non_normal(&self) -> bool {
        self.numerical > ROUNDOFF * self.fastest && self.spectral <= ROUNDOFF * self.fastest
    }

    /// Whether A is symmetric.
    pub fn is_symmetric(&self) -> bool {
        self.asymmetry <= ROUNDOFF
    }
}

impl Character {
    /// Of a problem whose solution is not followed.
    pub(super) fn unseen(problem: &dyn Problem) -> Self {
        let unknowns = problem.field().dim();
        Self { unknowns, matrices: None, parting: f64::NAN, sizes: (f64::NAN, f64::NAN), reached: 0.0 }
    }

    /// Along the solution of `problem` by an adaptive method, as far as it goes; a second one, with errors far below a millionth,
    /// tells how far two solutions part.
    pub(super) fn of(problem: &dyn Problem, [method, accurate]: [&dyn Method; 2], horizon: f64) -> Self {
        let unknowns = problem.ode().dim();
        let mut states = Vec::new();
        // What was seen until a failure is what there is to look at.
        let h = problem.ode().longest_step(horizon).min(horizon / INSTANTS as f64);
        let _ = run(problem, method, h, horizon, |state| states.push((state.t, state.q.clone())));
        let size = |(_, state): &(f64, Vec<f64>)| max_norm(state);
        let sizes = (states.first().map_or(0.0, size), worst(states.iter().map(size)));
        let reached = states.last().map_or(0.0, |(t, _)| *t);
        let every = states.len().div_ceil(INSTANTS + 1).max(1);
        let states: Vec<_> = states.into_iter().step_by(every).collect();
        let parting = parting(problem, accurate, horizon);
        Self { unknowns, matrices: matrices(problem, &states), parting, sizes, reached }
    }

    /// Whether it has too many unknowns for its matrices to be looked at.
    pub fn is_large(&self) -> bool {
        self.unknowns > LARGEST
    }

    /// Whether the solution has grown beyond all measure where it was lost.
    pub fn blows_up(&self) -> bool {
        self.sizes.1 > BLOWN * self.sizes.0.max(1.0)
    }
}

/// The Jacobians of a small system at the states.
fn matrices(problem: &dyn Problem, states: &[(f64, Vec<f64>)]) -> Option<Matrices> {
    let field = problem.field();
    let n = field.dim();
    let structure = field.structure();
    if n > LARGEST || matches!(structure, Structure::MatrixFree) || states.iter().any(|(_, v)| v.len() != n) {
        return None;
    }
    let mass = match field.mass() {
        Mass::Identity => DMatrix::identity(n, n),
        Mass::Diagonal(entries) => DMatrix::from_diagonal(&DVector::from_vec(entries)),
        Mass::Matrix(matrix) => matrix.to_dense(),
        _ => return None,
    };
    let factor = mass.cholesky()?.l();
    let inverse = factor.clone().try_inverse()?;
    let mut found: Vec<DMatrix<f64>> = Vec::new();
    let mut columns = Vec::new();
    for (t, v) in states {
        let mut jacobian = Jacobian::with_structure(n, &structure);
        field.add_jacobian(*t, v, 1.0, &mut jacobian);
        let mut rate = vec![0.0; n];
        field.rhs(*t, v, &mut rate);
        let a = &inverse * jacobian.to_dense() * inverse.transpose();
        let scale = a.norm();
        if !scale.is_finite() {
            return None;
        }
        // An invariant is orthogonal to every column of A, and to the rate, by their own sizes.
        columns.extend(a.column_iter().map(|column| column / scale.max(f64::MIN_POSITIVE)));
        let rate = &inverse * DVector::from_vec(rate);
        columns.push(&rate / rate.norm().max(f64::MIN_POSITIVE));
        found.push(a);
    }
    let (t, _) = states.first()?;
    // A solution at rest sees the linear part of f alone: a state aside, where f is defined there.
    let size = Some(worst(states.iter().map(|(_, v)| max_norm(v)))).filter(|size| *size > 0.0).unwrap_or(1.0);
    let aside: Vec<f64> = (0..n).map(|i| size * (1.0 + 0.5 * ((i + 1) as f64).sin())).collect();
    let mut jacobian = Jacobian::with_structure(n, &structure);
    field.add_jacobian(*t, &aside, 1.0, &mut jacobian);
    let a = &inverse * jacobian.to_dense() * inverse.transpose();
    let scale = a.norm();
    if scale.is_finite() {
        columns.extend(a.column_iter().map(|column| column / scale.max(f64::MIN_POSITIVE)));
    }
    let all = DMatrix::from_columns(&columns);
    // Squares of singular values: what is orthogonal to seven digits counts.
    let sizes = (&all * all.transpose()).symmetric_eigenvalues();
    let least = 16.0 * all.ncols() as f64 * f64::EPSILON * sizes.max();
    let invariants = sizes.iter().filter(|size| **size <= least).count();
    let relative = |difference: DMatrix<f64>, a: &DMatrix<f64>| difference.norm() / a.norm().max(f64::MIN_POSITIVE);
    let hamiltonian = |partner: fn(usize, usize) -> (usize, f64)| {
        found.iter().all(|a| {
            let b = DMatrix::from_fn(n, n, |i, j| {
                let (partner, sign) = partner(n, i);
                sign * a[(partner, j)]
            });
            relative(&b - b.transpose(), a) <= ROUNDOFF
        })
    };
    let is_calm = |a: &&DMatrix<f64>| spectral_abscissa(a) <= ROUNDOFF * spectral_radius(a);
    let by_radius = |a: &&DMatrix<f64>, b: &&DMatrix<f64>| spectral_radius(a).total_cmp(&spectral_radius(b));
    Some(Matrices {
        calm: found.iter().filter(is_calm).max_by(by_radius).cloned(),
        instants: found.len(),
        fastest: found.iter().map(spectral_radius).largest(),
        spectral: found.iter().map(spectral_abscissa).largest(),
        numerical: found.iter().map(numerical_abscissa).largest(),
        asymmetry: worst(found.iter().map(|a| relative(a - a.transpose(), a))),
        invariants,
        is_hamiltonian: n.is_multiple_of(2) && (hamiltonian(halves) || hamiltonian(pairs)),
    })
}

/// The row of ΩA that is ± a row of A, for (q₁, q₂, …, p₁, p₂, …).
fn halves(n: usize, i: usize) -> (usize, f64) {
    if i < n / 2 { (i + n / 2, 1.0) } else { (i - n / 2, -1.0) }
}

/// The same for (q₁, p₁, q₂, p₂, …).
fn pairs(_: usize, i: usize) -> (usize, f64) {
    if i.is_multiple_of(2) { (i + 1, 1.0) } else { (i - 1, -1.0) }
}

/// How far two solutions part that start a millionth apart, at sixteen times, so that one that grows and falls again is seen;
/// infinite where one of them ends early.
fn parting(problem: &dyn Problem, method: &dyn Method, horizon: f64) -> f64 {
    let start = problem.initial();
    let size = 1e-6 * max_norm(&start).max(1.0);
    // All directions have a part in it, smooth ones too.
    let moved: Vec<f64> = start.iter().enumerate().map(|(i, x)| x + size * (1.0 + 0.5 * (i as f64).sin())).collect();
    let apart = distance(&start, &moved);
    let times: Vec<f64> = (1..=SIXTEEN).map(|k| horizon * f64::from(k) / f64::from(SIXTEEN)).collect();
    let follow = |start: Vec<f64>| run_through_from(problem, start, method, &times);
    let (Ok(one), Ok(other)) = (follow(start), follow(moved)) else { return f64::INFINITY };
    worst(one.iter().zip(&other).map(|(one, other)| distance(one, other) / apart))
}
