//! Two computable measures of the error of a step: the estimate of adaptive Radau IIA, and the least-squares action.

use lsvi::adaptive::{Options, Radau, Tolerances};
use lsvi::closure::Linear;
use lsvi::discrete::{DiscreteLagrangian, Galerkin, Interval};
use lsvi::quadrature::Quadrature;
use lsvi::{Integrator, OneStep, State, Trajectory, Variational, Work};

use nalgebra::{DMatrix, DVector};

use super::{Context, Experiment, StudyError};
use crate::measure::norm::{Extremes, distance, larger, max_norm};
use crate::method;
use crate::problem::{self, Problem};
use crate::run::{run, run_through, step_from};

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
    /// The largest error at the end of a step: one that changes its sign is small at some.
    pub largest: f64,
    /// The largest component of the solution.
    pub size: f64,
    /// The work.
    pub work: Work,
}

impl Experiment for Tolerated {
    const ID: &'static str = "tolerated";
    type Found = Controlled;

    fn measure(&self, _: &Context) -> Result<Controlled, StudyError> {
        let (problem, horizon) = (problem::build_setting(self.problem)?, self.horizon);
        let tolerances = Tolerances::new(self.rtol, self.atol)?;
        let method = method::parse("radau-adaptive")?.with_tolerances(tolerances).ok_or("it is adaptive")?;
        let mut steps = Vec::new();
        let run = run(&*problem, &*method, horizon, horizon, |state| steps.push(state.clone()))?;
        let times: Vec<f64> = steps[1..].iter().map(|state| state.t).collect();
        let truth = course(&*problem, horizon, &times)?;
        let end = problem.exact(horizon).or_else(|| problem.tabulated(horizon)).ok_or("no truth is known")?;
        let largest = steps[1..].iter().zip(&truth).map(|(state, v)| distance(&state.q, v)).largest();
        let size = truth.iter().map(|v| max_norm(v)).largest();
        Ok(Controlled { error: distance(&run.end.q, &end), largest, size, work: run.work })
    }
}

/// Pieces of a run that are short for paths of degree six.
const PIECES: u32 = 64;

/// The times at which the pieces of a run end.
fn pieces(horizon: f64) -> impl Iterator<Item = f64> {
    (1..=PIECES).map(move |k| horizon * f64::from(k) / f64::from(PIECES))
}

/// The solution at these times: exact, or by collocation of order twelve from each to the next, and from piece to piece.
fn course(problem: &dyn Problem, horizon: f64, times: &[f64]) -> Result<Vec<Vec<f64>>, StudyError> {
    if let Some(exact) = times.iter().map(|t| problem.exact(*t)).collect() {
        return Ok(exact);
    }
    let mut stops: Vec<f64> = times.iter().copied().chain(pieces(horizon)).collect();
    stops.sort_by(f64::total_cmp);
    stops.dedup_by(|later, earlier| *later - *earlier <= 8.0 * f64::EPSILON * horizon);
    let found = run_through(problem, &*method::parse("ls-galerkin(6,gauss,6)")?, &stops)?;
    // Of two stops that are one the earlier is kept.
    let at = |t: &f64| found[stops.partition_point(|stop| *stop <= *t) - 1].clone();
    Ok(times.iter().map(at).collect())
}

/// The largest factor by which neighbours of a solution part between any two times of a run, of an f whose derivative does not depend
/// on time: the largest ‖∂v(t)/∂v(s)‖∞, at least 1.
#[derive(Debug)]
pub struct Growth {
    /// The problem.
    pub problem: &'static str,
    /// The end.
    pub horizon: f64,
}

impl Experiment for Growth {
    const ID: &'static str = "growth";
    type Found = f64;

    fn measure(&self, _: &Context) -> Result<f64, StudyError> {
        /// Of a central difference, whose error is of order h² beside a rounding over h.
        const APART: f64 = 1e-5;
        let (problem, collocation) = (problem::build_setting(self.problem)?, method::parse("ls-galerkin(6,gauss,6)")?);
        let (times, start) = (pieces(self.horizon).collect::<Vec<_>>(), problem.initial());
        let course = course(&*problem, self.horizon, &times)?;
        let n = start.len();
        let step = |v: &[f64]| step_from(&*problem, v.to_vec(), &*collocation, self.horizon / f64::from(PIECES));
        // From the start of each piece that has been so far to the present time.
        let (mut maps, mut largest) = (Vec::<DMatrix<f64>>::new(), 1.0);
        for v in std::iter::once(&start).chain(&course[..course.len() - 1]) {
            let mut piece = DMatrix::zeros(n, n);
            for j in 0..n {
                let beside = |sign: f64| {
                    let mut v = v.clone();
                    v[j] += sign * APART;
                    step(&v)
                };
                let (after, before) = (beside(1.0)?, beside(-1.0)?);
                piece.set_column(j, &DVector::from_fn(n, |i, _| (after[i] - before[i]) / (2.0 * APART)));
            }
            maps.iter_mut().for_each(|map| *map = &piece * &*map);
            maps.push(piece);
            let norm =
                |map: &DMatrix<f64>| map.row_iter().map(|row| row.iter().map(|x| x.abs()).sum::<f64>()).largest();
            largest = larger(largest, maps.iter().map(norm).largest());
        }
        Ok(largest)
    }
}

/// The same run with three stages alone.
#[derive(Debug)]
pub struct OfOrder5(pub Tolerated);

/// The steps of a run.
#[derive(Debug)]
pub struct Steps {
    /// Those that it consists of.
    pub accepted: u64,
    /// Those that were too long.
    pub rejected: u64,
}

impl Experiment for OfOrder5 {
    const ID: &'static str = "steps-of-order-5";
    type Found = Steps;

    fn measure(&self, _: &Context) -> Result<Steps, StudyError> {
        let Tolerated { problem, horizon, rtol, atol } = self.0;
        let problem = problem::build_setting(problem)?;
        let options = Options::new(Tolerances::new(rtol, atol)?).stages(3, 3)?;
        let mut fixed = Radau::new(problem.field(), options)?;
        Trajectory::new(&mut fixed, State::new(0.0, problem.initial()), horizon, horizon)?.observe(|_| ())?;
        Ok(Steps { accepted: fixed.work().steps, rejected: fixed.rejected() })
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Of v̇ = v (1 − v) from 0.1 neighbours part by up to (v(t)(1 − v(t)))/(v(s)(1 − v(s))), and v(2) is next to ½; those of v̇ = −1000 (v − cos t) meet.
    #[test]
    fn growth_is_that_of_neighbours() {
        let growth = |problem, horizon| Growth { problem, horizon }.measure(&Context::silent()).expect("it runs");
        let v = 1.0 / (1.0 + 9.0 * (-2.0_f64).exp());
        approx::assert_relative_eq!(growth("logistic", 2.0), v * (1.0 - v) / 0.09, max_relative = 1e-8);
        assert_eq!(growth("prothero-robinson", 10.0), 1.0);
    }

    /// At times between the ends of pieces, two of them next to each other, and at one that is tabulated.
    #[test]
    fn a_course_is_the_solution_at_each_time() {
        let problem = problem::build("van-der-pol", &[]).expect("known");
        let found = course(&*problem, 2.0, &[0.1, 1.0, 1.0 + 1e-9, 2.0]).expect("it runs");
        let end = problem.tabulated(2.0).expect("tabulated");
        // Each piece leaves four roundings of 2, as far as v comes.
        let rounding = f64::from(PIECES + 2) * 4.0 * f64::EPSILON * 2.0;
        assert!(distance(&found[3], &end) < rounding && distance(&found[1], &found[2]) < 1e-8, "{found:?}");
        assert!(distance(&found[1], &found[2]) > 1e-10 && found.len() == 4);
    }
}
