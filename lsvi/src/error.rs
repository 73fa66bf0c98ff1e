//! Typed errors: what was wrong with the input, or where and why a step failed.

mod input;
mod number;

use thiserror::Error;

use number::Number;

pub use input::{ClosureError, ConstraintError, NodeError, SettingError, SystemError, TimeError};

/// Input that no method can use.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum InputError {
    /// Step sizes, ends and times that no run can have.
    #[error(transparent)]
    Time(#[from] TimeError),
    /// A system, its matrices or its solver that do not fit together.
    #[error(transparent)]
    System(#[from] SystemError),
    /// A condition on the momenta that defines none.
    #[error(transparent)]
    Closure(#[from] ClosureError),
    /// Nodes and coefficients that make no method.
    #[error(transparent)]
    Nodes(#[from] NodeError),
    /// Constraints that cannot be kept, or are not.
    #[error(transparent)]
    Constraint(#[from] ConstraintError),
    /// Tolerances and settings outside of their range.
    #[error(transparent)]
    Setting(#[from] SettingError),
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
    /// No velocity was found that belongs to the momentum: p is none of the values of ∂L/∂v, or out of reach from v = 0.
    #[error("no velocity belongs to the momentum: p - dL/dv is still {difference:.1e} where its iteration ended")]
    NoVelocity {
        /// Max norm of p − ∂L/∂v at the last velocity.
        difference: f64,
    },
    /// The solution that is continuous in the step size ends in a fold before the step is complete, or meets another; with a
    /// derivative that is wrong it cannot be followed.
    #[error(
        "the branch of solutions that starts at the present state ends at a step of {reached:.4e}, unless a derivative is wrong"
    )]
    BranchLost {
        /// Longest step for which the branch was found.
        reached: f64,
    },
    /// Newton's iteration did not converge: the step is too long, a derivative is wrong
    /// ([`check_derivatives`](crate::check_derivatives)), least squares weigh components in unlike units, the equations are differential and
    /// algebraic ones of an index above one, or constraints have no independent gradients close by.
    #[error("Newton's iteration did not converge: last increment {increment:.1e} after {}", counted(*iterations))]
    Diverged {
        /// Iterations spent.
        iterations: u32,
        /// Max norm of the last increment.
        increment: f64,
    },
    /// Newton's iteration converged, but to a root that is not known to be continuous in the step size from the present state. Where a shorter
    /// step does not help, the reasons may be those of [`Diverged`](Self::Diverged).
    #[error(
        "Newton's iteration converged to a root of another branch than the one that starts at the present state, unless a derivative is wrong"
    )]
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
        /// Its change since the first step.
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
    /// A Lagrangian that declares L = ½ vᵀMv − V(t, q) and has a term that is linear in v.
    #[error(
        "the Lagrangian is declared separable and is not: component {row} of ∂L/∂v differs from that of M v by \
         {difference:.1e}"
    )]
    LinearInVelocity {
        /// Component of ∂L/∂v.
        row: usize,
        /// Its value less that of M v.
        difference: f64,
    },
    /// The equations produced NaN or infinity however short the step.
    #[error("the equations of the step are not finite: f, L or a derivative of theirs is NaN or infinite")]
    NonFinite,
    /// The equations produced NaN or infinity for all but the shorter steps.
    #[error(
        "the equations are not finite beyond a step of {reached:.4e}: f, L or a derivative of theirs is NaN or infinite"
    )]
    NonFiniteBeyond {
        /// Longest step that was solved.
        reached: f64,
    },
    /// The derivative of an equation of the step is NaN or infinite.
    #[error("the derivative of equation {row} of the step by unknown {column} is not finite")]
    NonFiniteDerivative {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
    },
    /// A matrix is needed that the field does not assemble.
    #[error("the field is matrix-free, and no matrix can be factored: give an iterative solver with a preconditioner")]
    NotAssembled,
    /// An iterative solution of a linear system did not reach its tolerance.
    #[error("the linear solver stopped after {} with a relative residual of {residual:.1e}", counted(*iterations))]
    Linear {
        /// Iterations spent.
        iterations: u32,
        /// Norm of the residual relative to that of the right-hand side.
        residual: f64,
    },
    /// Vectors or settings that a solver or a preconditioner of the user's was refused.
    #[error(transparent)]
    Input(#[from] InputError),
    /// Gauss–Newton iterations ran out, or came to rest where they need damping: away from a minimum of the action, or at one
    /// where the residual is large, which is no approximation of the solution. A shorter step has none of them.
    #[error("the step did not converge in {}: |g| = {gradient:.1e}, |f| = {rate:.1e}", counted(*iterations))]
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

impl SolveError {
    /// Why a branch was not followed beyond `reached`, where the last attempt failed for this reason.
    pub(crate) fn beyond(self, reached: f64) -> Self {
        match self {
            Self::NonFinite | Self::NonFiniteDerivative { .. } => Self::NonFiniteBeyond { reached },
            _ => Self::BranchLost { reached },
        }
    }

    /// Whether no root was found on the branch, or none was told to be: other equations of the same step may lead to it.
    pub(crate) fn is_lost(&self) -> bool {
        matches!(self, Self::BranchLost { .. } | Self::OtherBranch | Self::Diverged { .. })
    }
}

/// So many iterations, in words.
fn counted(iterations: u32) -> String {
    format!("{iterations} iteration{}", if iterations == 1 { "" } else { "s" })
}

/// Part of a step that is not printed.
const BESIDE: f64 = 1e-4;

/// Which step it is.
fn from(t: f64, h: f64) -> String {
    if h == 0.0 {
        format!("no step starts from the state at t = {}", Number(t))
    } else {
        format!("step from t = {} with h = {}", Number(t), Number(h))
    }
}

/// What is said of a step of `h`, at the end of which the branch may end too.
fn of_step(source: &SolveError, h: f64) -> String {
    match source {
        SolveError::BranchLost { reached } if h - reached <= BESIDE * h => {
            "the branch of solutions that starts at the present state ends just before the end of the step, unless a derivative is wrong".into()
        }
        _ => source.to_string(),
    }
}

/// A step that could not be taken.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum StepError {
    /// The arguments are unusable.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The step equation was not solved; the state is left as it was.
    #[error("{}: {}", from(*t, *h), of_step(source, *h))]
    Solve {
        /// Time at the beginning of the step.
        t: f64,
        /// Step size; 0 where the state itself is at fault, whatever the step.
        h: f64,
        /// Why.
        source: SolveError,
    },
    /// An adaptive method found no step size that meets its tolerance: the solution may end there, algebraic equations whose index is
    /// above 1 may have none, and with an absolute tolerance of 0 none has a component that leaves 0 at a time other than 0 like a power of
    /// time above the number of stages.
    #[error("the step size fell to h = {h:e} at t = {}: the tolerance cannot be met there", Number(*t))]
    StepUnderflow {
        /// Time at the beginning of the step.
        t: f64,
        /// Step size that was tried last.
        h: f64,
    },
    /// The tolerance calls for a step shorter than [`Options::h_min`](crate::adaptive::Options::h_min).
    #[error("at t = {} the tolerance calls for h = {h:e}, below the shortest step allowed, h_min = {h_min:e}", Number(*t))]
    BelowShortest {
        /// Time at the beginning of the step.
        t: f64,
        /// Step size that is called for.
        h: f64,
        /// The shortest allowed.
        h_min: f64,
    },
    /// An adaptive method used up the steps that it was allowed.
    #[error("at t = {} all of the {limit} steps that are allowed have been tried", Number(*t))]
    TooManySteps {
        /// Time that was reached.
        t: f64,
        /// The limit.
        limit: u64,
    },
}

/// Refuses a vector of the wrong length or with a non-finite component.
#[inline]
pub(crate) fn check_vector(what: &'static str, v: &[f64], dim: usize) -> Result<(), InputError> {
    check_length(what, v.len(), dim)?;
    // 0 x is 0 or NaN, which a sum finds without a branch; which one it is, is asked where there is one.
    if v.iter().fold(0.0, |sum, x| sum + 0.0 * x) == 0.0 { Ok(()) } else { Err(non_finite(what, v)) }
}

/// The first component that is not finite.
#[cold]
fn non_finite(what: &'static str, v: &[f64]) -> InputError {
    let index = v.iter().position(|x| !x.is_finite()).unwrap_or_default();
    InputError::System(SystemError::NonFinite { what, index, value: v[index] })
}

/// Refuses a slice of another length.
#[inline]
pub(crate) fn check_length(what: &'static str, found: usize, expected: usize) -> Result<(), InputError> {
    if found == expected { Ok(()) } else { Err(InputError::System(SystemError::Dimension { what, expected, found })) }
}

/// Refuses a system of no unknowns.
pub(crate) fn check_unknowns(n: usize) -> Result<(), InputError> {
    if n > 0 { Ok(()) } else { Err(InputError::System(SystemError::Empty)) }
}

/// Refuses a time that is not finite.
#[inline]
pub(crate) fn check_time(t: f64) -> Result<(), InputError> {
    if t.is_finite() { Ok(()) } else { Err(InputError::Time(TimeError::Time(t))) }
}

/// Refuses a step that starts at no time, or whose size is not positive and finite.
#[inline]
pub(crate) fn check_step_from(t: f64, h: f64) -> Result<(), InputError> {
    check_time(t)?;
    check_step(h)
}

/// Refuses a step size that is not positive and finite.
#[inline]
pub(crate) fn check_step(h: f64) -> Result<(), InputError> {
    if h.is_finite() && h > 0.0 { Ok(()) } else { Err(InputError::Time(TimeError::StepSize(h))) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// To the ten thousandth that is not printed, whatever the step.
    #[test]
    fn a_branch_that_ends_beside_the_end_of_a_step_ends_at_no_place_in_it() {
        for h in [0.01, 1.0, 100.0] {
            for (part, is_beside) in [(0.9e-4, true), (1.1e-4, false)] {
                let source = SolveError::BranchLost { reached: h * (1.0 - part) };
                assert_eq!(of_step(&source, h) != source.to_string(), is_beside, "h = {h}, {part}");
            }
        }
    }

    #[test]
    fn one_iteration_is_no_plural() {
        let told = |iterations: u32| SolveError::Diverged { iterations, increment: 0.5 }.to_string();
        assert!(told(1).ends_with("after 1 iteration") && told(2).ends_with("after 2 iterations"), "{}", told(1));
    }

    #[test]
    fn a_branch_that_ends_at_the_end_of_the_step_is_told_without_its_length() {
        let told =
            |reached: f64| StepError::Solve { t: 1.0, h: 0.5, source: SolveError::BranchLost { reached } }.to_string();
        assert!(
            told(0.5 - 1e-9).contains("h = 0.5: the branch of solutions")
                && told(0.5 - 1e-9).contains("ends just before the end")
        );
        assert!(
            told(0.499).contains("h = 0.5: the branch of solutions")
                && told(0.499).contains("ends at a step of 4.9900e-1")
        );
    }
}
