//! What becomes of runs on nonlinear problems, by step size and initial value.

use std::ops::ControlFlow;

use lsvi::{SolveError, StepError};
use rayon::prelude::*;

use super::{Context, Experiment, StudyError};
use crate::method;
use crate::problem::{self, Problem};
use crate::run::{RunError, run, run_while};

/// What becomes of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// It approaches the steady state of the problem that attracts the solution.
    Right,
    /// It settles where f ≠ 0, or at a steady state that repels the solution.
    Wrong,
    /// A step equation has no solution on the branch that starts at the present state.
    NoStep,
    /// It has settled nowhere within [`STEPS`], or is not finite.
    Unsettled,
}

/// Steps of a run at most.
pub const STEPS: u32 = 2000;
/// Values of each of h and v₀.
pub const GRID: u32 = 32;

/// Where the values of a grid lie: in the middle of equal intervals.
#[derive(Debug, Clone, Copy)]
pub enum Spacing {
    /// From 0 to this.
    Linear(f64),
    /// From the first to the second, their logarithms.
    Log(f64, f64),
}

impl Spacing {
    /// The values, in order.
    pub fn values(self) -> Vec<f64> {
        self.middles(GRID)
    }

    /// The middles of so many equal parts.
    fn middles(self, parts: u32) -> Vec<f64> {
        let at = |s: f64| match self {
            Self::Linear(to) => to * s,
            Self::Log(from, to) => from * (to / from).powf(s),
        };
        (0..parts).map(|i| at((f64::from(i) + 0.5) / f64::from(parts))).collect()
    }
}

/// A problem with a steady state that attracts all solutions from v₀ > 0, and the (h, v₀) to start from.
#[derive(Debug, Clone, Copy)]
pub struct Arena {
    /// Name of the problem.
    pub problem: &'static str,
    /// The attracting steady state.
    pub(crate) right: f64,
    /// The repelling one that runs may end at.
    pub(crate) wrong: Option<f64>,
    /// How near to it a run counts as there, as a part of the initial distance.
    pub(crate) near: f64,
    /// Whether it attracts from below as well.
    pub(crate) both_sides: bool,
    /// Step size.
    pub h: Spacing,
    /// Starting values.
    pub v0: Spacing,
}

/// v̇ = −v², from positive starts.
pub const QUADRATIC_DRAG: Arena = Arena {
    problem: "quadratic-drag",
    right: 0.0,
    wrong: None,
    // The solution decays like 1/t: a tenth is reached in 9/(h v₀) steps.
    near: 0.1,
    // From below zero solutions run away.
    both_sides: false,
    h: Spacing::Log(0.1, 10.0),
    v0: Spacing::Log(0.1, 10.0),
};

/// v̇ = v(1 − v).
pub const LOGISTIC: Arena = Arena {
    problem: "logistic",
    right: 1.0,
    wrong: Some(0.0),
    near: 1e-6,
    both_sides: true,
    h: Spacing::Linear(6.0),
    v0: Spacing::Log(0.01, 3.0),
};

impl Arena {
    fn start(&self, v0: f64) -> Result<Box<dyn Problem>, StudyError> {
        Ok(problem::build(self.problem, &[("v0".into(), v0.to_string())])?)
    }

    /// Whether a run from v₀ that came from `last` to `v` is decided, and how.
    fn decided(&self, v0: f64, last: f64, v: f64) -> Option<Fate> {
        let distance = if self.both_sides || v >= self.right { (v - self.right).abs() } else { f64::INFINITY };
        if distance <= self.near * (v0 - self.right).abs() || distance < 1e-9 {
            Some(Fate::Right)
        } else if (v - last).abs() <= 1e-12 * v.abs() || self.wrong.is_some_and(|wrong| (v - wrong).abs() < 1e-9) {
            Some(Fate::Wrong)
        } else {
            None
        }
    }
}

/// Runs of a method from every pair of an arena.
#[derive(Debug)]
pub struct Fates {
    /// Problem, step sizes and starts.
    pub arena: Arena,
    /// Name of the method.
    pub method: &'static str,
}

/// `fates[j][i]` at `(h[i], v0[j])`.
#[derive(Debug)]
pub struct Map {
    /// Name of the method.
    pub method: &'static str,
    /// By starting value, and by step size.
    pub fates: Vec<Vec<Fate>>,
}

impl Map {
    /// The part of the starts with this fate.
    pub fn share(&self, fate: Fate) -> f64 {
        let all = self.fates.iter().flatten();
        all.clone().filter(|f| **f == fate).count() as f64 / all.count() as f64
    }
}

impl Experiment for Fates {
    const ID: &'static str = "fates";
    type Found = Map;

    fn measure(&self, context: &Context) -> Result<Map, StudyError> {
        context.announce(1);
        let (arena, method) = (self.arena, method::parse(self.method)?);
        let fate = |h: f64, v0: f64| -> Result<Fate, StudyError> {
            let (mut fate, mut last) = (None, f64::NAN);
            let result = run_while(&*arena.start(v0)?, &*method, h, f64::from(STEPS) * h, |state| {
                fate = arena.decided(v0, last, state.q[0]);
                last = state.q[0];
                if fate.is_none() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            });
            match result {
                Ok(_) => Ok(fate.unwrap_or(Fate::Unsettled)),
                Err(RunError::Step(StepError::Solve { .. })) => Ok(Fate::NoStep),
                Err(RunError::NonFinite(_)) => Ok(Fate::Unsettled),
                Err(error) => Err(error.into()),
            }
        };
        let h = arena.h.values();
        let row = |v0: f64| h.iter().map(|h| fate(*h, v0)).collect();
        let fates = arena.v0.values().into_par_iter().map(row).collect::<Result<_, StudyError>>()?;
        context.tick();
        Ok(Map { method: self.method, fates })
    }
}

/// Step sizes for one of the grid, along a fold.
const FINER: u32 = 2;
/// Halvings that locate one, of a factor of some hundreds in v₀.
const HALVINGS: u32 = 40;

/// The v₀ from which on the first step of Method I loses its branch, for step sizes of an arena.
#[derive(Debug)]
pub struct Folds {
    /// Problem, step sizes and starts, of which the curve goes on beyond the largest by a factor of two.
    pub arena: Arena,
}

impl Experiment for Folds {
    const ID: &'static str = "folds";
    /// (h, v₀).
    type Found = Vec<(f64, f64)>;

    fn measure(&self, _: &Context) -> Result<Self::Found, StudyError> {
        let method = method::parse("method-i")?;
        let is_lost = |h: f64, v0: f64| match run(&*self.arena.start(v0)?, &*method, h, h, |_| {}) {
            Err(RunError::Step(StepError::Solve { source: SolveError::BranchLost { .. }, .. })) => Ok(true),
            Ok(_) => Ok(false),
            Err(error) => Err(StudyError::from(error)),
        };
        let starts = self.arena.v0.values();
        let mut folds = Vec::new();
        for h in self.arena.h.middles(FINER * GRID) {
            let (mut below, mut above) = (starts[0], 2.0 * starts[starts.len() - 1]);
            if is_lost(h, below)? || !is_lost(h, above)? {
                continue;
            }
            for _ in 0..HALVINGS {
                let middle = (below * above).sqrt();
                *if is_lost(h, middle)? { &mut above } else { &mut below } = middle;
            }
            folds.push((h, below));
        }
        Ok(folds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_decided_where_it_arrives_or_stands_still() {
        let decided = |last, v| LOGISTIC.decided(0.5, last, v);
        assert_eq!(decided(0.99, 1.0 - 4e-7), Some(Fate::Right));
        assert_eq!(decided(0.99, 1.0 - 6e-7), None);
        assert_eq!(decided(0.1, 1e-10), Some(Fate::Wrong), "at the repelling state");
        assert_eq!(decided(0.3, 0.3), Some(Fate::Wrong), "where f is not zero");
        assert_eq!(decided(f64::NAN, 0.3), None);
    }

    #[test]
    fn what_has_passed_a_state_that_repels_on_that_side_has_not_arrived() {
        assert_eq!(QUADRATIC_DRAG.decided(1.0, 0.2, 0.05), Some(Fate::Right));
        assert_eq!(QUADRATIC_DRAG.decided(1.0, 0.2, -0.05), None);
    }

    #[test]
    fn values_lie_in_the_middle_of_equal_intervals() {
        let values = Spacing::Linear(1.0).values();
        assert_eq!([values[0], values[values.len() - 1]], [0.5 / f64::from(GRID), 1.0 - 0.5 / f64::from(GRID)]);
    }

    #[test]
    fn folds_of_quadratic_drag_lie_on_a_hyperbola() {
        let folds = Folds { arena: QUADRATIC_DRAG }.measure(&Context::silent()).expect("it runs");
        // W = h v₀ at the fold is 2.1..: all h but those below 0.115 have it.
        assert_eq!(folds.len() + 2, (FINER * GRID) as usize);
        let w: Vec<f64> = folds.iter().map(|(h, v0)| h * v0).collect();
        assert!(w.iter().all(|x| (x / w[0] - 1.0).abs() < 1e-8), "{w:?}");
    }
}
