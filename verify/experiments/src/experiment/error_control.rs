//! Two computable measures of the error of a step: the estimate of adaptive Radau IIA, and the least-squares action.

use lsvi::adaptive::{Options, Radau, Tolerances};
use lsvi::closure::Linear;
use lsvi::discrete::{DiscreteLagrangian, Galerkin, Interval};
use lsvi::quadrature::Quadrature;
use lsvi::{Integrator, OneStep, State, Trajectory, Variational, Work};

use super::{Context, Experiment, StudyError};
use crate::measure::norm::{distance, max_norm};
use crate::method;
use crate::problem;
use crate::run::run;

/// A run of `radau-adaptive`.
#[derive(Debug, Clone, Copy)]
pub struct Tolerated {
    /// The problem.
    pub problem: &'static str,
    /// The end.
    pub horizon: f64,
    /// The relative tolerance.
    pub rtol: f64,
    /// The absolute tolerance.
    pub atol: f64,
}

/// What is found of it.
#[derive(Debug)]
pub struct Controlled {
    /// The error at the end.
    pub error: f64,
    /// The largest component of the solution there.
    pub size: f64,
    /// The work.
    pub work: Work,
}

impl Experiment for Tolerated {
    const ID: &'static str = "tolerated";
    type Found = Controlled;

    fn measure(&self, _: &Context) -> Result<Controlled, StudyError> {
        let (problem, horizon) = (problem::build_setting(self.problem)?, self.horizon);
        let truth = problem.exact(horizon).or_else(|| problem.tabulated(horizon)).ok_or("no truth is known")?;
        let tolerances = Tolerances::new(self.rtol, self.atol)?;
        let method = method::parse("radau-adaptive")?.with_tolerances(tolerances).ok_or("it is adaptive")?;
        let run = run(&*problem, &*method, horizon, horizon, |_| {})?;
        Ok(Controlled { error: distance(&run.end.q, &truth), size: max_norm(&truth), work: run.work })
    }
}

/// The steps of the same run with three stages alone, rejected ones among them.
#[derive(Debug)]
pub struct StepsOfOrder5(pub Tolerated);

impl Experiment for StepsOfOrder5 {
    const ID: &'static str = "steps-of-order-5";
    type Found = u64;

    fn measure(&self, _: &Context) -> Result<u64, StudyError> {
        let Tolerated { problem, horizon, rtol, atol } = self.0;
        let problem = problem::build_setting(problem)?;
        let options = Options::new(Tolerances::new(rtol, atol)?).stages(3, 3)?;
        let mut fixed = Radau::new(problem.field(), options)?;
        Trajectory::new(&mut fixed, State::new(0.0, problem.initial()), horizon, horizon)?.observe(|_| ())?;
        Ok(fixed.work().steps + fixed.rejected())
    }
}

/// The first step of paths of a degree on Lobatto's nodes, closed by Method I.
#[derive(Debug)]
pub struct ActionStep {
    /// The problem.
    pub problem: &'static str,
    /// The degree of the paths.
    pub degree: u32,
    /// The number of nodes.
    pub nodes: u32,
    /// The step size.
    pub h: f64,
}

/// What the action says of a step, and the truth.
#[derive(Debug)]
pub struct Action {
    /// √(2 h L_d).
    pub indicator: f64,
    /// The error of the step.
    pub error: f64,
}

impl Experiment for ActionStep {
    const ID: &'static str = "action-step";
    type Found = Action;

    fn measure(&self, _: &Context) -> Result<Action, StudyError> {
        let Self { problem, degree, nodes, h } = *self;
        let problem = problem::build_setting(problem)?;
        let q0 = problem.initial();
        let rule = Quadrature::lobatto(nodes as usize)?;
        let discrete = Galerkin::new(problem.lagrangian()?, degree as usize, &rule)?;
        let mut method = Variational::new(discrete, Linear::METHOD_I);
        let (mut q, mut p) = (q0.clone(), vec![0.0; q0.len()]);
        method.step(0.0, h, &mut q, &mut p)?;
        let unknowns = method.unknowns().to_vec();
        let action = method.discrete_mut().action(Interval { start: 0.0, h }, &q0, &unknowns);
        // Collocation of order 12 on eight pieces of the step: far below the error of a step of order seven.
        let truth = run(&*problem, &*method::parse("ls-galerkin(6,gauss,6)")?, h / 8.0, h, |_| {})?.end.q;
        Ok(Action { indicator: (2.0 * h * action).sqrt(), error: distance(&q, &truth) })
    }
}
