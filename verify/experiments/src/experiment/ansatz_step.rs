//! Steps of the Lagrangian (37) of the one-shape-function Poiseuille flow.

use lsvi::closure::Linear;
use lsvi::discrete::Trapezoidal;
use lsvi::{OneStep, Variational};

use super::{Context, Experiment, StudyError};
use crate::problem::{PoiseuilleAnsatz, Problem};

/// One live step.
#[derive(Debug, Clone, Copy)]
pub struct AnsatzStep {
    /// How it is closed.
    pub closure: Closed,
    /// The pressure gradient γ.
    pub gamma: f64,
    /// v_n.
    pub v: f64,
    /// The step size.
    pub h: f64,
}

/// The closure.
#[derive(Debug, Clone, Copy)]
pub enum Closed {
    /// p_{n+1} = 0.
    MethodI,
    /// p_{n+1} = p_n.
    MethodII,
}

impl Experiment for AnsatzStep {
    const ID: &'static str = "ansatz-step";
    /// v_{n+1}.
    type Found = f64;

    fn measure(&self, _: &Context) -> Result<f64, StudyError> {
        let closure = match self.closure {
            Closed::MethodI => Linear::METHOD_I,
            Closed::MethodII => Linear::METHOD_II,
        };
        let problem = PoiseuilleAnsatz::from_rest(self.gamma);
        let (mut q, mut p) = ([self.v], [0.0]);
        Variational::new(Trapezoidal::new(problem.lagrangian()?), closure).step(0.0, self.h, &mut q, &mut p)?;
        Ok(q[0])
    }
}
