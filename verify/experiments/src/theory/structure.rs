//! What a method preserves.

use crate::kinds::{Principle, Symplecticity, System};
use crate::method::Method;
use crate::problem::Problem;

/// Whether the step of `method` preserves the symplectic form of `problem`; `None` where it has no Lagrangian of mechanics.
pub fn is_symplectic(problem: &dyn Problem, method: &dyn Method) -> Option<bool> {
    let system = problem.mechanics()?.system;
    let traits = method.traits();
    Some(match (traits.symplectic, system) {
        (_, System::Forced) => false,
        (Symplecticity::Always, _) | (Symplecticity::ConstantMass, System::ConstantMass) => true,
        // A step of a discretised Lagrangian commutes with rotations and reflections.
        (_, System::Circular) => traits.is_reversible && traits.principle == Principle::Hamilton,
        _ => false,
    })
}
