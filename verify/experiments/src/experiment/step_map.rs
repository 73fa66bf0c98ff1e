//! Steps of a discretised Lagrangian with their derivatives, which trajectories do not show.

use lsvi::closure::PositionMomentum;
use lsvi::discrete::DiscreteLegendre;
use lsvi::{Constrained, Constraint, ConstraintError, InputError, Variational, position_momentum};
use nalgebra::DMatrix;

use super::StudyError;
use crate::method::Method;
use crate::problem::Problem;

/// A step of a named method, with its derivative.
pub(super) type Map<'a> = Variational<Box<dyn DiscreteLegendre + 'a>, PositionMomentum>;

/// The step of `method` on `problem`.
pub(super) fn map<'a>(method: &dyn Method, problem: &'a dyn Problem) -> Result<Map<'a>, StudyError> {
    Ok(position_momentum(discretise(method, problem)?))
}

/// The discretisation of `problem` by `method`.
pub(super) fn discretise<'a>(
    method: &dyn Method,
    problem: &'a dyn Problem,
) -> Result<Box<dyn DiscreteLegendre + 'a>, StudyError> {
    let system = problem.mechanics().ok_or("the problem has no Lagrangian of mechanics")?;
    Ok(method.discretise(system.lagrangian).ok_or("the method discretises no Lagrangian")??)
}

/// The derivative DΦ of one step of size `h` from the state (q, p).
pub(super) fn tangent(map: &mut Map, h: f64, state: &[f64]) -> Result<DMatrix<f64>, StudyError> {
    let (q, p) = state.split_at(state.len() / 2);
    Ok(map.step_with_tangent(0.0, h, &mut q.to_vec(), &mut p.to_vec())?)
}

/// The same restricted to the vectors tangent to the constraint, where `problem` has one, and the projector on these.
pub(super) fn restricted(
    method: &dyn Method,
    problem: &dyn Problem,
    h: f64,
    state: &[f64],
) -> Result<[DMatrix<f64>; 2], StudyError> {
    let (q, p) = state.split_at(state.len() / 2);
    let system = problem.mechanics().ok_or("the problem has no Lagrangian of mechanics")?;
    let same = problem.mechanics().and_then(|system| system.constraint);
    let (Some(constraint), Some(same)) = (system.constraint, same) else {
        return Ok([tangent(&mut map(method, problem)?, h, state)?, DMatrix::identity(state.len(), state.len())]);
    };
    let discrete = method.discretise_held(system.lagrangian).ok_or("the method can be held to no constraint")??;
    let mut map = Constrained::new(discrete, constraint)?;
    let projector = tangent_projector(&*same, q)?;
    Ok([map.step_with_tangent(0.0, h, &mut q.to_vec(), &mut p.to_vec())? * &projector, projector])
}

/// The orthogonal projector on the vectors (δq, δp) with G δq = 0 and G δp = 0 at `q`.
///
/// It takes the place of one on the cotangent bundle of the constraint, whose vectors differ from these by some Gᵀc in δp:
/// a step takes such a change of the momentum up into its multiplier, and Ω does not see it where G δq = 0.
fn tangent_projector(constraint: &dyn Constraint, q: &[f64]) -> Result<DMatrix<f64>, StudyError> {
    let (n, m) = (constraint.dim(), constraint.count());
    let mut gradient = DMatrix::zeros(m, n);
    constraint.jacobian(q, &mut gradient);
    let normal = (&gradient * gradient.transpose()).cholesky();
    let normal = normal.ok_or(InputError::Constraint(ConstraintError::RedundantConstraints { count: m, rank: 0 }))?;
    let along = DMatrix::identity(n, n) - gradient.transpose() * normal.solve(&gradient);
    let mut projector = DMatrix::zeros(2 * n, 2 * n);
    projector.view_mut((0, 0), (n, n)).copy_from(&along);
    projector.view_mut((n, n), (n, n)).copy_from(&along);
    Ok(projector)
}
