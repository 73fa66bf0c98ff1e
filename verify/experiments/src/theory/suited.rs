//! Which methods say something about a problem.

use crate::kinds::Principle;
use crate::method::{self, Method};
use crate::names::NameError;
use crate::problem::{self, Problem};

/// Largest order of a matrix that is filled in the studies of every pair of method and problem, for the sake of time.
const CHEAP: usize = 24;

/// Whether a step of `method` on `problem` fills no large matrix.
pub fn is_cheap(problem: &dyn Problem, method: &dyn Method) -> bool {
    method.filled(problem) <= CHEAP
}

/// The names of the variational integrators of mechanics that step the problem of this setting.
///
/// # Errors
/// [`NameError`] for an unknown problem.
pub fn integrators_for(setting: &str) -> Result<Vec<String>, NameError> {
    let problem = problem::build_setting(setting)?;
    let all = method::integrators().into_iter().filter(|method| method.build(&*problem).is_ok());
    Ok(all.map(|method| method.name()).collect())
}

/// The examples of methods that say something about `problem`: those that can be built and fill no large matrices; and
/// least-squares closures only where the motion has no invariant, since those are made for systems that dissipate.
pub fn methods_for(problem: &dyn Problem) -> Vec<Box<dyn Method>> {
    let conservative = !problem.invariants().is_empty();
    let suits = |method: &dyn Method| {
        (!conservative || matches!(method.principle(), Principle::Equation | Principle::Hamilton))
            && is_cheap(problem, method)
            && method.build(problem).is_ok()
    };
    method::examples().into_iter().filter(|method| suits(&**method)).collect()
}
