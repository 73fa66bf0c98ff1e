//! What the studies of mechanics share.

use lsvi::closure::PositionMomentum;
use lsvi::discrete::Constrainable;
use lsvi::{Constrained, Constraint, InputError, Variational, position_momentum};
use nalgebra::DMatrix;

use super::StudyError;
use crate::evidence::Cell;
use crate::kinds::Principle;
use crate::method::{self, Method};
use crate::problem::{self, Problem};

/// A step of a named method, with its derivative.
pub(super) type Map<'a> = Variational<Box<dyn Constrainable + 'a>, PositionMomentum>;

/// Path fitting of degree 2 and the examples of every variational integrator of mechanics.
pub(super) fn integrators() -> Result<Vec<Box<dyn Method>>, StudyError> {
    let mut all = vec![method::parse("path-fitted(2)")?];
    all.extend(method::examples().into_iter().filter(|method| method.principle() == Principle::Hamilton));
    Ok(all)
}

/// The problem `name` with some parameters set.
pub(super) fn problem(name: &str, set: &[(&str, &str)]) -> Result<Box<dyn Problem>, StudyError> {
    let set: Vec<(String, String)> = set.iter().map(|(name, value)| ((*name).into(), (*value).into())).collect();
    Ok(problem::build(name, &set)?)
}

/// The discretisation of `problem` by `method`.
pub(super) fn discretise<'a>(
    method: &dyn Method,
    problem: &'a dyn Problem,
) -> Result<Box<dyn Constrainable + 'a>, StudyError> {
    let system = problem.mechanics().ok_or("the problem has no Lagrangian of mechanics")?;
    Ok(method.discretise(system.lagrangian).ok_or("the method discretises no Lagrangian")??)
}

/// The derivative DΦ of one step of size `h` from the state (q, p).
pub(super) fn tangent(map: &mut Map, h: f64, state: &[f64]) -> Result<DMatrix<f64>, StudyError> {
    let (mut q, mut p) = (state.to_vec(), state[state.len() / 2..].to_vec());
    q.truncate(p.len());
    Ok(map.step_with_tangent(0.0, h, &mut q, &mut p)?)
}

/// The step of `method` on `problem`.
pub(super) fn map<'a>(method: &dyn Method, problem: &'a dyn Problem) -> Result<Map<'a>, StudyError> {
    Ok(position_momentum(discretise(method, problem)?))
}

/// A step of a named method under the constraints of its problem, with its derivative.
pub(super) type HeldMap<'a> = Constrained<Box<dyn Constrainable + 'a>, Box<dyn Constraint + 'a>>;

/// The step of `method` on `problem`, if it has constraints.
pub(super) fn held_map<'a>(method: &dyn Method, problem: &'a dyn Problem) -> Option<Result<HeldMap<'a>, StudyError>> {
    let constraint = problem.mechanics()?.constraint?;
    Some(discretise(method, problem).and_then(|discrete| Ok(Constrained::new(discrete, constraint)?)))
}

/// The orthogonal projector on the vectors (δq, δp) with G δq = 0 and G δp = 0 at `q`.
///
/// It takes the place of one on the cotangent bundle of the constraint, whose vectors differ from these by some Gᵀc in δp:
/// a step takes such a change of the momentum up into its multiplier, and Ω does not see it where G δq = 0.
pub(super) fn tangent_projector(constraint: &dyn Constraint, q: &[f64]) -> Result<DMatrix<f64>, StudyError> {
    let (n, m) = (constraint.dim(), constraint.count());
    let mut gradient = DMatrix::zeros(m, n);
    constraint.jacobian(q, &mut gradient);
    let normal = (&gradient * gradient.transpose()).cholesky();
    let normal = normal.ok_or(InputError::RedundantConstraints { count: m, rank: 0 })?;
    let along = DMatrix::identity(n, n) - gradient.transpose() * normal.solve(&gradient);
    let mut projector = DMatrix::zeros(2 * n, 2 * n);
    projector.view_mut((0, 0), (n, n)).copy_from(&along);
    projector.view_mut((n, n), (n, n)).copy_from(&along);
    Ok(projector)
}

pub(super) fn text(text: impl Into<String>) -> Cell {
    Cell::Text(text.into())
}
