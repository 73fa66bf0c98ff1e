//! Where the linear solver of Method II stops on a periodic flow.

use std::ops::ControlFlow;

use lsvi::{SolveError, StepError};

use super::super::{Context, Experiment, StudyError};
use crate::{method, problem, run};

/// A step of Method II from the start of a flow.
#[derive(Debug, Clone, Copy)]
pub struct Stops {
    /// The flow with its parameters.
    pub flow: &'static str,
    /// The step size.
    pub h: f64,
}

impl Experiment for Stops {
    const ID: &'static str = "method-ii-stops";
    /// The relative residual that the solver is left with; nothing where the step is taken.
    type Found = Option<f64>;

    fn measure(&self, context: &Context) -> Result<Option<f64>, StudyError> {
        context.announce(1);
        let (flow, method) = (problem::build_setting(self.flow)?, method::parse("method-ii")?);
        let outcome = run::run_while(&*flow, &*method, self.h, self.h, |_| ControlFlow::Continue(()));
        context.tick();
        match outcome {
            Ok(_) => Ok(None),
            Err(run::RunError::Step(StepError::Solve { source: SolveError::Linear { residual, .. }, .. })) => {
                Ok(Some(residual))
            }
            Err(other) => Err(other.into()),
        }
    }
}
