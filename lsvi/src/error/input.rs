//! Input that no method can use, an error for each kind.

use thiserror::Error;

use super::number::Number;

/// Step sizes, ends and times that no run can have.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum TimeError {
    /// The step size is not a positive finite number.
    #[error("step size h = {} must be positive and finite", Number(*_0))]
    StepSize(f64),
    /// A time that is not a finite number.
    #[error("time t = {0} must be finite")]
    Time(f64),
    /// The end time is not a finite number at or after the start.
    #[error("end time {} must be finite and not before the start t = {}; to go back, integrate -f(-t, v) forwards", Number(*t_end), Number(*t0))]
    EndTime {
        /// Start of the integration.
        t0: f64,
        /// The offending end.
        t_end: f64,
    },
    /// Steps so small that t + h keeps few digits of h, |t|/h above 2⁴⁷, or more of them than can be counted.
    #[error(
        "step size h = {} cannot resolve the interval [{}, {}] in double precision",
        Number(*h), Number(*t0), Number(*t_end)
    )]
    Unresolvable {
        /// Start of the integration.
        t0: f64,
        /// End of the integration.
        t_end: f64,
        /// The offending step.
        h: f64,
    },
    /// A time within a step, before any step was taken.
    #[error("no step has been taken that could contain t = {}", Number(*t))]
    NoStep {
        /// The time that was asked for.
        t: f64,
    },
    /// Times to be shown that are not sorted, or not within the run.
    #[error(
        "time {index}, t = {}, is not between {} and {}: times are sorted and within the run",
        Number(*t), Number(*from), Number(*to)
    )]
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
    #[error("t = {} is not in the last step, from {} to {}", Number(*t), Number(*from), Number(*to))]
    Outside {
        /// The offending time.
        t: f64,
        /// Start of the last step.
        from: f64,
        /// Its end.
        to: f64,
    },
}

/// A system, its matrices or its solver that do not fit together.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SystemError {
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
    /// A system of no unknowns.
    #[error("the system has no unknowns: there is nothing to integrate")]
    Empty,
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
    /// An entry of a matrix that is NaN or infinite.
    #[error("entry ({row}, {column}) of the {what} is not finite")]
    NonFiniteEntry {
        /// Which matrix.
        what: &'static str,
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
    },
    /// A sparsity pattern of a matrix of another order than the system has unknowns.
    #[error("the sparsity pattern is that of a matrix of order {found}, and there are {expected} unknowns")]
    Pattern {
        /// Unknowns of the system.
        expected: usize,
        /// Order of the pattern.
        found: usize,
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
    /// A matrix with an entry where its declared structure has none.
    #[error("entry ({row}, {column}) lies outside the declared structure of the mass matrix")]
    OutsideStructure {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
    },
    /// A metric that is not symmetric positive definite.
    #[error("the metric, or the mass matrix that it is the inverse of, is not symmetric positive definite: {0}")]
    Metric(String),
    /// A mass matrix without an inverse, for a method with explicit stages or a new value that is not its last stage.
    #[error(
        "the mass matrix is singular, and explicit stages, or a new value that is not the last stage, need its inverse: use a \
         stiffly accurate method with implicit stages only, such as implicit Euler or SDIRK2"
    )]
    SingularMass,
    /// A start that violates an equation without a derivative, whose row of M is zero.
    #[error(
        "the start violates equation {row}, which is algebraic: f[{row}] = {}, where {} is allowed; start from values that \
         satisfy it",
        Number(*value), Number(*allowed)
    )]
    InconsistentStart {
        /// Which equation.
        row: usize,
        /// f of that equation at the start.
        value: f64,
        /// What changes of v within the tolerances make of it: Σ_j |∂f_row/∂v_j| (atol_j + rtol |v_j|). Of a method without
        /// tolerances, what changes of t and v by √ε of themselves, or of what the step changes, make of it.
        allowed: f64,
    },
    /// A Lagrangian that does not say that it is separable, for a method that splits it.
    #[error(
        "the Lagrangian does not say that it is separable, L = ½ vᵀMv − V(t, q) with a constant M: override \
         is_separable where it is, or take Galerkin::gauss"
    )]
    NotSeparable,
    /// A linear solver that does not fit the system.
    #[error("{0}")]
    Solver(&'static str),
    /// A field or a mass without entries, for a method that factors matrices.
    #[error(
        "the field is matrix-free, and the method factors matrices: give it an iterative solver with a preconditioner"
    )]
    NotAssembled,
}

/// A condition on the momenta that defines none.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ClosureError {
    /// Closure coefficients that define no condition.
    #[error("closure coefficients (alpha, beta) = ({}, {}) define no condition", Number(*alpha), Number(*beta))]
    Closure {
        /// Coefficient of p_n.
        alpha: f64,
        /// Coefficient of p_{n+1}.
        beta: f64,
    },
    /// Closure coefficients that define no condition in the limit of short steps.
    #[error(
        "closure coefficients (alpha, beta) = ({}, {}) at h = 0 are no limit for h -> 0, by which branches of solutions are told",
        Number(*alpha), Number(*beta)
    )]
    Limit {
        /// Coefficient of p_n at h = 0.
        alpha: f64,
        /// Coefficient of p_{n+1} at h = 0.
        beta: f64,
    },
    /// A rate to fit that is not positive and finite.
    #[error("the decay rate {} must be positive and finite", Number(*_0))]
    Rate(f64),
    /// A range of steps that is empty, negative or unbounded.
    #[error("[{}, {}] is no range of positive step sizes", Number(*from), Number(*to))]
    StepRange {
        /// Its lower end.
        from: f64,
        /// Its upper end.
        to: f64,
    },
    /// A homogeneous function of the momenta that vanishes on no line.
    #[error("the homogeneous closure F(p_n, p_{{n+1}}) changes sign on no line through the origin")]
    NoLine,
}

/// Nodes and coefficients that make no method.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum NodeError {
    /// A coefficient that couples a stage to a later one.
    #[error("the entry ({row}, {column}) of the tableau stands above its diagonal")]
    AboveDiagonal {
        /// Row of the entry, from 0.
        row: usize,
        /// Column of the entry, from 0.
        column: usize,
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
    #[error("node {index} = {} is not in the unit interval", Number(*value))]
    NodeRange {
        /// Which node.
        index: usize,
        /// The offending value.
        value: f64,
    },
    /// Two nodes that agree to within rounding.
    #[error("nodes {first} and {second} coincide at {}", Number(*value))]
    CoincidentNodes {
        /// One node.
        first: usize,
        /// The other.
        second: usize,
        /// Where they are; the ends of a step count as nodes.
        value: f64,
    },
    /// Weights that do not integrate a constant.
    #[error("the weights sum to {} and not to 1, so that no step has the length h", Number(*sum))]
    WeightSum {
        /// Their sum.
        sum: f64,
    },
}

/// Constraints that cannot be kept, or are not.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ConstraintError {
    /// A configuration that violates a holonomic constraint.
    #[error("the configuration violates the constraint: f[{index}] = {}", Number(*value))]
    OffConstraint {
        /// Which component of f.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A momentum whose velocity leaves the constraint.
    #[error(
        "the momentum violates the hidden constraint: its velocity leaves f = 0, and component {index} has {} too much",
        Number(*value)
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
}

/// Tolerances and settings outside of their range.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SettingError {
    /// A relative tolerance of an iterative solver outside of (0, 1).
    #[error("the tolerance {} of an iterative solver must be above 0 and below 1", Number(*_0))]
    SolverTolerance(f64),
    /// A tolerance that is not a positive finite number.
    #[error("tolerance {} must be positive and finite", Number(*_0))]
    Tolerance(f64),
    /// A relative tolerance that no arithmetic in double precision can keep, or no number at all.
    #[error("relative tolerance {} must be between {least:.1e}, ten roundings of double precision, and 1", Number(*rtol))]
    RelativeTolerance {
        /// The offending tolerance.
        rtol: f64,
        /// The least that can be kept.
        least: f64,
    },
    /// An absolute tolerance that is negative or not finite.
    #[error("absolute tolerance {} of component {index} must be finite and not negative", Number(*atol))]
    AbsoluteTolerance {
        /// Which component.
        index: usize,
        /// The offending tolerance.
        atol: f64,
    },
    /// A setting of an adaptive method outside its range.
    #[error("{what} = {} must be {range}", Number(*value))]
    Setting {
        /// Which setting.
        what: &'static str,
        /// The offending value.
        value: f64,
        /// What it must be.
        range: &'static str,
    },
    /// A shortest step that is longer than the longest.
    #[error("the shortest step h_min = {} must not exceed the longest, h_max = {}", Number(*h_min), Number(*h_max))]
    StepBounds {
        /// The shortest step.
        h_min: f64,
        /// The longest step.
        h_max: f64,
    },
    /// Numbers of stages that the adaptive method does not have.
    #[error("stages from {fewest} to {most}: the method has 3, 5 or 7")]
    Stages {
        /// The least number that was asked for.
        fewest: usize,
        /// The largest.
        most: usize,
    },
}
