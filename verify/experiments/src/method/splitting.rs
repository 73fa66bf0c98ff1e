//! The explicit integrators of mechanics, which split a separable Lagrangian into kicks and drifts.

use lsvi::discrete::{BrokenLine, DiscreteLegendre};
use lsvi::{EulerLagrange, InputError, Integrator, position_momentum};

use super::mechanics::{PhaseSpace, mechanics_of, random_walk};
use super::{Build, BuildError, Method, Spec, Traits};
use crate::kinds::{Principle, Stability, Symplecticity};
use crate::problem::Problem;

pub(super) const BLANES_MOAN: Spec = Spec {
    form: "blanes-moan",
    summary: "broken line of eleven pieces, explicit, for L = ½ vᵀMv − V: order 6, symplectic",
    build: Build::Plain(|| Box::new(BlanesMoan)),
    examples: &["blanes-moan"],
};

/// Blanes and Moan's SRKN₁₁ᵇ.
#[derive(Debug)]
struct BlanesMoan;

impl Method for BlanesMoan {
    fn name(&self) -> String {
        "blanes-moan".into()
    }

    fn traits(&self) -> Traits {
        let traits = Traits::new(6, Principle::Hamilton, Stability::Conditional);
        Traits { symplectic: Symplecticity::ConstantMass, is_reversible: true, ..traits }
    }

    /// That of the straight path, although changes of q and p are added up apart from both.
    fn momentum_roundoff(&self, steps: f64) -> f64 {
        random_walk(1.0, steps)
    }

    fn discretise<'a>(
        &self,
        lagrangian: Box<dyn EulerLagrange + 'a>,
    ) -> Option<Result<Box<dyn DiscreteLegendre + 'a>, InputError>> {
        Some(BrokenLine::blanes_moan(lagrangian).map(|line| Box::new(line) as Box<dyn DiscreteLegendre>))
    }

    fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
        let system = mechanics_of(problem, self)?;
        if system.constraint.is_some() {
            let reason = "its explicit steps know no constraint".into();
            return Err(BuildError { method: self.name(), reason });
        }
        let line = BrokenLine::blanes_moan(system.lagrangian).map_err(BuildError::of(self))?;
        Ok(Box::new(PhaseSpace::new(position_momentum(line))))
    }
}
