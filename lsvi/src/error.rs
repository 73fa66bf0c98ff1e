//! Typed errors: what was wrong with the input, or where and why a step failed.

use thiserror::Error;

/// Input that no method can use.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum InputError {
    /// The step size is not a positive finite number.
    #[error("step size h = {0} must be positive and finite")]
    StepSize(f64),
    /// The end time is not a finite number at or after the start.
    #[error("end time {t_end} must be finite and not before the start t = {t0}")]
    EndTime {
        /// Start of the integration.
        t0: f64,
        /// The offending end.
        t_end: f64,
    },
    /// Steps so small that t + h = t in floating point, or more of them than can be counted.
    #[error("step size h = {h} cannot resolve the interval [{t0}, {t_end}] in double precision")]
    Unresolvable {
        /// Start of the integration.
        t0: f64,
        /// End of the integration.
        t_end: f64,
        /// The offending step.
        h: f64,
    },
    /// A vector or matrix has the wrong size.
    #[error("{what} has length {found}, expected {expected}")]
    Dimension {
        /// Which argument.
        what: &'static str,
        /// Size that the system has.
        expected: usize,
        /// Size that was given.
        found: usize,
    },
    /// A component is NaN or infinite.
    #[error("{what}[{index}] = {value} is not finite")]
    NonFinite {
        /// Which argument.
        what: &'static str,
        /// Which component.
        index: usize,
        /// The offending value.
        value: f64,
    },
    /// A position outside the matrix that a sparsity pattern describes.
    #[error("entry ({row}, {column}) lies outside a matrix of order {dim}")]
    Position {
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
        /// Order of the matrix.
        dim: usize,
    },
    /// A coefficient that couples a stage to a later one.
    #[error("the entry ({row}, {column}) of the tableau stands above its diagonal")]
    AboveDiagonal {
        /// Row of the entry, from 0.
        row: usize,
        /// Column of the entry, from 0.
        column: usize,
    },
    /// A matrix with an entry where its declared structure has none.
    #[error("entry ({row}, {column}) lies outside the declared structure of the mass matrix")]
    OutsideStructure {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
    },
    /// A metric that is not symmetric positive definite.
    #[error("the metric is not symmetric positive definite: {0}")]
    Metric(String),
    /// A mass matrix without an inverse, for a method with explicit stages.
    #[error(
        "the mass matrix is singular, and explicit stages need its inverse: use a method with implicit stages only"
    )]
    SingularMass,
    /// Closure coefficients that define no condition.
    #[error("closure coefficients (alpha, beta) = ({alpha}, {beta}) define no condition")]
    Closure {
        /// Coefficient of p_n.
        alpha: f64,
        /// Coefficient of p_{n+1}.
        beta: f64,
    },
    /// A rate to fit that is not positive and finite.
    #[error("the decay rate {0} must be positive and finite")]
    Rate(f64),
    /// A range of steps that is empty, negative or unbounded.
    #[error("[{from}, {to}] is no range of positive step sizes")]
    StepRange {
        /// Its lower end.
        from: f64,
        /// Its upper end.
        to: f64,
    },
    /// Fewer nodes, or a lower degree, than a method needs.
    #[error("{what}: {found} is fewer than {least}")]
    TooFew {
        /// What is counted.
        what: &'static str,
        /// Least usable number.
        least: usize,
        /// Number that was given.
        found: usize,
    },
    /// A node outside the step.
    #[error("node {index} = {value} is not in the unit interval")]
    NodeRange {
        /// Which node.
        index: usize,
        /// The offending value.
        value: f64,
    },
    /// Two nodes that agree to within rounding.
    #[error("nodes {first} and {second} coincide at {value}")]
    CoincidentNodes {
        /// One node.
        first: usize,
        /// The other.
        second: usize,
        /// Where they are; the ends of a step count as nodes.
        value: f64,
    },
    /// A configuration that violates a holonomic constraint.
    #[error("the configuration violates the constraint: f[{index}] = {value:e}")]
    OffConstraint {
        /// Which component of f.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A momentum whose velocity leaves the constraint.
    #[error(
        "the momentum violates the hidden constraint: its velocity leaves f = 0, and component {index} has {value:e} too much"
    )]
    OffHiddenConstraint {
        /// Component of the momentum that differs most from its projection.
        index: usize,
        /// By how much.
        value: f64,
    },
    /// Constraints whose gradients are linearly dependent.
    #[error("{count} constraints have gradients of rank {rank}")]
    RedundantConstraints {
        /// Number of constraints.
        count: usize,
        /// Rank of their gradients.
        rank: usize,
    },
    /// A tolerance that is not a positive finite number.
    #[error("tolerance {0} must be positive and finite")]
    Tolerance(f64),
    /// A relative tolerance that no arithmetic in double precision can keep, or no number at all.
    #[error("relative tolerance {rtol:e} must be between {least:.1e}, ten roundings of double precision, and 1")]
    RelativeTolerance {
        /// The offending tolerance.
        rtol: f64,
        /// The least that can be kept.
        least: f64,
    },
    /// An absolute tolerance that is negative or not finite.
    #[error("absolute tolerance {atol:e} of component {index} must be finite and not negative")]
    AbsoluteTolerance {
        /// Which component.
        index: usize,
        /// The offending tolerance.
        atol: f64,
    },
    /// A setting of an adaptive method outside its range.
    #[error("{what} = {value} must be {range}")]
    Setting {
        /// Which setting.
        what: &'static str,
        /// The offending value.
        value: f64,
        /// What it must be.
        range: &'static str,
    },
    /// Numbers of stages that the adaptive method does not have.
    #[error("stages from {fewest} to {most}: the method has 3, 5 or 7")]
    Stages {
        /// The least number that was asked for.
        fewest: usize,
        /// The largest.
        most: usize,
    },
    /// A time within a step, before any step was taken.
    #[error("no step has been taken that could contain t = {t}")]
    NoStep {
        /// The time that was asked for.
        t: f64,
    },
    /// Times to be shown that are not sorted, or not within the run.
    #[error("time {index}, t = {t}, is not between {from} and {to}: times are sorted and within the run")]
    SaveTime {
        /// Which time.
        index: usize,
        /// The offending time.
        t: f64,
        /// The time before it, or the start.
        from: f64,
        /// The end of the run.
        to: f64,
    },
    /// A dense output of a method that knows no rate.
    #[error("the method gives no rate of the configuration, and has no solution between its steps")]
    NoRate,
    /// A time outside the last step.
    #[error("t = {t} is not in the last step, from {from} to {to}")]
    Outside {
        /// The offending time.
        t: f64,
        /// Start of the last step.
        from: f64,
        /// Its end.
        to: f64,
    },
    /// A linear solver that does not fit the system.
    #[error("{0}")]
    Solver(&'static str),
    /// A field or a mass without entries, for a method that factors matrices.
    #[error(
        "the field is matrix-free, and the method factors matrices: give it an iterative solver with a preconditioner"
    )]
    NotAssembled,
    /// A homogeneous function of the momenta that vanishes on no line.
    #[error("the homogeneous closure F(p_n, p_{{n+1}}) changes sign on no line through the origin")]
    NoLine,
}

/// Why a nonlinear step equation was not solved.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SolveError {
    /// The derivative of the step equation is singular however short the step: it determines nothing.
    #[error("the equation of the step determines no next state: its derivative is singular however short the step")]
    Singular,
    /// The mass matrix ∂²L/∂v² is singular: the momentum determines no velocity.
    #[error("the mass matrix, the second derivative of L in the velocity, is singular at the present state")]
    SingularMass,
    /// The solution that is continuous in the step size ends in a fold before the step is complete.
    #[error("the branch of solutions that starts at the present state ends at a step of {reached:.4e}")]
    BranchLost {
        /// Longest step for which the branch was found.
        reached: f64,
    },
    /// Newton's iteration did not converge.
    #[error("Newton's iteration did not converge: last increment {increment:.1e} after {iterations} iterations")]
    Diverged {
        /// Iterations spent.
        iterations: u32,
        /// Max norm of the last increment.
        increment: f64,
    },
    /// Newton's iteration converged, but to a root that is not continuous in the step size from the present state.
    #[error("Newton's iteration converged to a root of another branch than the one that starts at the present state")]
    OtherBranch,
    /// A derivative where the declared structure has none.
    #[error("the derivative of component {row} by component {column} lies outside the declared structure")]
    OutsideStructure {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
    },
    /// A field that declares f(t, v) = A v + g(t) and is not.
    #[error(
        "component {row} of the field is declared linear and is not: it differs from A v + g(t) by {difference:.1e}"
    )]
    NotLinear {
        /// Component of f.
        row: usize,
        /// Its value less that of A v + g(t).
        difference: f64,
    },
    /// A field that declares that it does not depend on t and does.
    #[error("component {row} of the field is declared independent of time and is not: it changes by {difference:.1e}")]
    NotAutonomous {
        /// Component of f.
        row: usize,
        /// Its change over the step.
        difference: f64,
    },
    /// A Lagrangian that declares L = ½ vᵀMv − V(t, q) and is not.
    #[error("the Lagrangian is declared separable and is not: its second derivatives at ({row}, {column}) say so")]
    NotSeparable {
        /// Row of ∂²L/∂v² or ∂²L/∂q∂v.
        row: usize,
        /// Its column.
        column: usize,
    },
    /// The equations produced NaN or infinity.
    #[error("the equations are not finite at the present state")]
    NonFinite,
    /// A matrix is needed that the field does not assemble.
    #[error("the field is matrix-free, and no matrix can be factored: give an iterative solver with a preconditioner")]
    NotAssembled,
    /// An iterative solution of a linear system did not reach its tolerance.
    #[error("the linear solver stopped after {iterations} iterations with a relative residual of {residual:.1e}")]
    Linear {
        /// Iterations spent.
        iterations: u32,
        /// Norm of the residual relative to that of the right-hand side.
        residual: f64,
    },
    /// Gauss–Newton iterations ran out, or came to rest where they need damping: away from a minimum of the action, or at one
    /// where the residual is large, which is no approximation of the solution. A shorter step has none of them.
    #[error("the step came to rest after {iterations} iterations with |g| = {gradient:.1e}, |f| = {rate:.1e}")]
    Stalled {
        /// Iterations spent.
        iterations: u32,
        /// Norm of the gradient of the action relative to that at the present state.
        gradient: f64,
        /// Max norm of f at the last iterate.
        rate: f64,
        /// The last iterate.
        v: Box<[f64]>,
    },
}

/// A step that could not be taken.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum StepError {
    /// The arguments are unusable.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The step equation was not solved; the state is left as it was.
    #[error("step from t = {t} with h = {h}: {source}")]
    Solve {
        /// Time at the beginning of the step.
        t: f64,
        /// Step size.
        h: f64,
        /// Why.
        source: SolveError,
    },
    /// An adaptive method found no step size that meets its tolerance.
    #[error("the step size fell to h = {h:e} at t = {t}: the tolerance cannot be met there")]
    StepUnderflow {
        /// Time at the beginning of the step.
        t: f64,
        /// Step size that was tried last.
        h: f64,
    },
    /// An adaptive method used up the steps that it was allowed.
    #[error("at t = {t} all of the {limit} steps that are allowed have been tried")]
    TooManySteps {
        /// Time that was reached.
        t: f64,
        /// The limit.
        limit: u64,
    },
}

/// Refuses a vector of the wrong length or with a non-finite component.
pub(crate) fn check_vector(what: &'static str, v: &[f64], dim: usize) -> Result<(), InputError> {
    if v.len() != dim {
        return Err(InputError::Dimension { what, expected: dim, found: v.len() });
    }
    match v.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(InputError::NonFinite { what, index, value: v[index] }),
        None => Ok(()),
    }
}

/// Refuses a step size that is not positive and finite.
pub(crate) fn check_step(h: f64) -> Result<(), InputError> {
    if h.is_finite() && h > 0.0 { Ok(()) } else { Err(InputError::StepSize(h)) }
}
