//! What a closure asks of the end of one step, looked at without solving it.

use lsvi::discrete::{DiscreteLegendre, Interval, MomentumWeights, Trapezoidal};

use super::{Context, Experiment, StudyError};
use crate::measure::search::root;
use crate::problem::{self, Problem};

/// The equation α p₀ + β p₁ = 0 of one step from the initial state, with the trapezoidal least-squares Lagrangian.
#[derive(Debug)]
pub struct StepEquation {
    /// A problem with one component.
    pub problem: &'static str,
    /// The weights α and β of the momenta.
    pub weights: [f64; 2],
    /// Step size.
    pub h: f64,
}

/// Which v₁ meet it.
#[derive(Debug, PartialEq)]
pub enum Found {
    /// Every one: the step is not determined.
    Every,
    /// These, between −2 v₀ and 2 v₀, in their order.
    Roots(Vec<f64>),
}

impl StepEquation {
    /// Of Method I, p₁ = 0.
    pub const METHOD_I: [f64; 2] = [0.0, 1.0];
    /// Of Method II, p₁ − p₀ = 0.
    pub const METHOD_II: [f64; 2] = [-1.0, 1.0];
}

/// Intervals of which each is taken to have one root at most; an odd number, so that no v₁ that is looked at is a simple
/// multiple of v₀.
const INTERVALS: usize = 4001;

impl Experiment for StepEquation {
    const ID: &'static str = "step-equation";
    type Found = Found;

    fn measure(&self, _: &Context) -> Result<Found, StudyError> {
        let problem = problem::build_setting(self.problem)?;
        let &[start] = &*problem.initial() else { return Err("the problem has several components".into()) };
        solutions(&*problem, self.weights, self.h, start)
    }
}

/// The ends of a step of h from `start`.
fn solutions(problem: &dyn Problem, [alpha, beta]: [f64; 2], h: f64, start: f64) -> Result<Found, StudyError> {
    let mut discrete = Trapezoidal::new(problem.lagrangian()?);
    let mut equation = |end: f64| {
        let mut out = [f64::NAN];
        let at = Interval { start: 0.0, h };
        discrete.momentum(at, &[start], &[end], MomentumWeights { alpha, beta }, &mut out);
        out[0]
    };
    let at = |k: usize| start.abs() * (4.0 * k as f64 / INTERVALS as f64 - 2.0);
    let ends: Vec<f64> = (0..=INTERVALS).map(at).collect();
    if ends.iter().all(|end| equation(*end) == 0.0) {
        return Ok(Found::Every);
    }
    Ok(Found::Roots(ends.windows(2).filter_map(|pair| root([pair[0], pair[1]], &mut equation)).collect()))
}

/// A run on an autonomous problem that takes at every step the only solution that there is, on the branch of its state or not.
#[derive(Debug)]
pub struct OnlySolutions {
    /// The equation of the first step.
    pub first: StepEquation,
    /// Steps to take.
    pub steps: u32,
}

impl Experiment for OnlySolutions {
    const ID: &'static str = "only-solutions";
    /// The states, the initial one first.
    type Found = Vec<f64>;

    fn measure(&self, _: &Context) -> Result<Vec<f64>, StudyError> {
        let StepEquation { problem, weights, h } = self.first;
        let problem = problem::build_setting(problem)?;
        let &[mut v] = &*problem.initial() else { return Err("the problem has several components".into()) };
        let mut states = vec![v];
        for step in 0..self.steps {
            v = match solutions(&*problem, weights, h, v)? {
                Found::Roots(roots) if roots.len() == 1 => roots[0],
                found => return Err(format!("step {step} has not one solution but {found:?}").into()),
            };
            states.push(v);
        }
        Ok(states)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(problem: &'static str, weights: [f64; 2], h: f64) -> Found {
        StepEquation { problem, weights, h }.measure(&Context::silent()).expect("one component")
    }

    #[test]
    fn on_a_linear_problem_the_root_is_the_growth_factor() {
        for (weights, factor) in [(StepEquation::METHOD_I, 1.0 / 1.625), (StepEquation::METHOD_II, 0.75 / 1.25)] {
            let Found::Roots(roots) = found("linear-drag", weights, 0.5) else { panic!("a step is determined") };
            assert!(roots.len() == 1 && (roots[0] - factor).abs() < 8.0 * f64::EPSILON, "{roots:?}");
        }
    }

    #[test]
    fn without_forces_method_ii_leaves_the_end_of_a_step_open_and_method_i_does_not() {
        assert_eq!(found("linear-drag lambda=0", StepEquation::METHOD_II, 1.0), Found::Every);
        let Found::Roots(roots) = found("linear-drag lambda=0", StepEquation::METHOD_I, 1.0) else { panic!() };
        assert!(roots.len() == 1 && (roots[0] - 1.0).abs() < 8.0 * f64::EPSILON, "{roots:?}");
    }

    #[test]
    fn the_only_solutions_of_method_i_lead_to_a_spurious_steady_state_and_those_of_method_ii_never_decay() {
        let end = |weights| {
            let first = StepEquation { problem: "quadratic-drag", weights, h: 3.0 };
            let states = OnlySolutions { first, steps: 100 }.measure(&Context::silent()).expect("one at every step");
            [states[99], states[100]]
        };
        let near = |found: [f64; 2], known: [f64; 2]| found.iter().zip(known).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(near(end(StepEquation::METHOD_I), [-1.0 / 3.0; 2]), "{:?}", end(StepEquation::METHOD_I));
        assert!(near(end(StepEquation::METHOD_II), [-1.0, 1.0]), "{:?}", end(StepEquation::METHOD_II));
    }

    #[test]
    fn beyond_the_fold_one_root_is_left_and_it_is_negative() {
        for (weights, before, beyond) in [(StepEquation::METHOD_I, 2.1, 3.0), (StepEquation::METHOD_II, 0.9, 1.1)] {
            let at = |h| match found("quadratic-drag", weights, h) {
                Found::Roots(roots) => roots,
                Found::Every => panic!("a step is determined"),
            };
            assert_eq!(at(before).len(), 3);
            assert!(matches!(at(beyond)[..], [left] if left < 0.0), "{:?}", at(beyond));
        }
    }
}
