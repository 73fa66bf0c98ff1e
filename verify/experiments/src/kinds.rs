//! Kinds of methods and of systems, as data: what problems, methods and theory speak of in common.

/// What a method steps: it decides what the method converges to where the residual of a Lagrangian cannot vanish.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Principle {
    /// The differential equation itself.
    Equation,
    /// The Lagrangian with a momentum set to zero: p → 0.
    MomentumZero,
    /// The Lagrangian with the mean of a step's momenta set to zero: p → 0, to second order.
    MomentumMeanZero,
    /// The Lagrangian with a momentum that is conserved: ṗ → 0.
    MomentumConserved,
    /// The Lagrangian with a momentum that decays at a rate of the method's own.
    MomentumDecaying,
    /// The Lagrangian with p = 0 at the start only.
    EulerLagrange,
    /// The Lagrangian of mechanics from a given (q, p): Hamilton's principle, or Lagrange–d'Alembert's.
    Hamilton,
}

impl Principle {
    /// That of the closure α p₀ + β p₁ = 0.
    pub(crate) fn of_linear_closure(alpha: f64, beta: f64) -> Self {
        if alpha + beta == 0.0 {
            Self::MomentumConserved
        } else if alpha == beta {
            Self::MomentumMeanZero
        } else {
            Self::MomentumZero
        }
    }

    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Equation,
        Self::MomentumZero,
        Self::MomentumMeanZero,
        Self::MomentumConserved,
        Self::MomentumDecaying,
        Self::EulerLagrange,
        Self::Hamilton,
    ];
}

/// What limits the step size of a method on a stiff decaying problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stability {
    /// Nothing, and stiff components are damped: R(∞) = 0.
    Damping,
    /// Nothing, but stiff components are not damped to zero: 0 < |R(∞)| ≤ 1.
    Neutral,
    /// h|λ| must stay of order 1.
    Conditional,
    /// No step size: solutions grow where those of the problem decay.
    Unstable,
}

/// On which mechanical systems the step of a method preserves the symplectic form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Symplecticity {
    /// On all: the step has a discrete Lagrangian, or is Gauss collocation.
    Always,
    /// On those with L = ½ vᵀMv − V(q) and constant M.
    ConstantMass,
    /// On none but by accident.
    Never,
}

/// A class of mechanical systems, by what it takes to be symplectic on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum System {
    /// L = ½ vᵀMv − V(q) with constant M, constrained or not.
    ConstantMass,
    /// A magnetic field, or a mass that depends on q.
    General,
    /// Free motion round a circle. A step that commutes with rotations takes (θ, l) to (θ + φ(l), g(l)); where it is
    /// reversible and commutes with reflections too, g(g(l)) = l, and g, being near the identity, is the identity. Such a map
    /// keeps the area and l whatever its φ.
    Circular,
    /// A force that does work: the motion itself preserves no form.
    Forced,
}
