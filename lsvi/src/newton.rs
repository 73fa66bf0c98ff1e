//! Newton's method for step equations, held to the branch that starts at the present state.
//!
//! A step equation F(h, x) = 0 can have several roots, and more than one can be an attractor of Newton's iteration. The
//! right one is continuous in h from x = x₀ at h = 0. A start from x₀ whose increments contract from the first one on by
//! [`CONTRACTION`] finds it: in that ball (Newton–Kantorovich) the root is unique. Where they do not contract, the root is
//! followed in h from a step so short that they do, and the end of the branch, a fold, is an error.
//!
//! Contraction at h alone is not enough: where ∂F/∂x at x₀ is singular for some shorter step, the root nearest to x₀ may be
//! another one. On the branch det ∂F/∂x cannot change its sign, so that a root where the sign is not the one that it has for
//! h → 0 is refused, and so is one found from a start where it is not. Only an affine equation keeps its one root beyond a
//! pole, where the determinant changes its sign: it is told by a second increment of less than √ε of the first, which leaves
//! room for an ill-conditioned derivative. A nonlinear equation whose state is as small as √ε of its nonlinear scale is taken
//! for one, as it behaves like one.

use std::ops::Add;

use crate::error::SolveError;
use crate::linalg::{Jacobian, Lu, Structure, max_norm};

/// Required ratio of successive increments: Newton–Kantorovich gives uniqueness for quadratic contraction from ½.
const CONTRACTION: f64 = 0.5;
/// Iterations of one attempt; quadratic contraction from ½ needs at most seven to reach roundoff.
const ITERATIONS: u32 = 12;
/// A part of the step at which det ∂F/∂x has the sign it has for h → 0: no rate of a problem reaches it.
const SHORT: f64 = 1e-18;
/// Shortest piece of a continuation relative to what it has reached: a fold is located to this precision.
const SHORTEST: f64 = 1e-10;
/// Attempts on the pieces of one continuation. A fold takes log₂(1/SHORTEST) halvings, and the branch before it few more;
/// more than that is the crawl of an equation whose derivative is wrong.
const PIECES: u32 = 500;

/// A square system F(h, x) = 0 that depends on the step size h.
pub(crate) trait System {
    fn dim(&self) -> usize;
    fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]);
    /// Adds ∂F/∂x to the zero matrix `out`, at the (h, x) where the residual was evaluated last.
    fn derivative(&mut self, h: f64, x: &[f64], out: &mut Jacobian);
    /// Replaces a first guess by the solution at h = 0, where the branch starts; unless they are the same.
    fn origin(&self, _x: &mut [f64]) {}
    /// Whether the sign of det ∂F/∂x for h → 0 is the same for every step.
    fn keeps_orientation(&self) -> bool {
        false
    }
}

/// Counts of the work done in steps.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Work {
    /// Steps taken.
    pub steps: u64,
    /// Evaluations of a step equation, or of f in an explicit stage.
    pub residuals: u64,
    /// Derivative matrices built, factored and solved with; linearisations where nothing is factored.
    pub factorizations: u64,
    /// Inner iterations of iterative linear solvers.
    pub inner: u64,
}

impl Add for Work {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            steps: self.steps + other.steps,
            residuals: self.residuals + other.residuals,
            factorizations: self.factorizations + other.factorizations,
            inner: self.inner + other.inner,
        }
    }
}

/// Work space and counters of the iteration; nothing is allocated after `new`.
#[derive(Debug)]
pub(crate) struct Newton {
    jacobian: Jacobian,
    lu: Lu,
    increment: Vec<f64>,
    /// Start, and in a continuation the last point on the branch.
    origin: Vec<f64>,
    /// Sign of det ∂F/∂x for h → 0, found at the first solution; NaN where it is not the same for every step, or not known.
    orientation: Option<f64>,
    pub(crate) work: Work,
}

impl Newton {
    pub(crate) fn new(dim: usize) -> Self {
        Self::with_structure(dim, &Structure::Dense)
    }

    /// For systems whose derivative has the given structure.
    pub(crate) fn with_structure(dim: usize, structure: &Structure) -> Self {
        let jacobian = Jacobian::with_structure(dim, structure);
        Self {
            lu: Lu::of(&jacobian),
            jacobian,
            increment: vec![0.0; dim],
            origin: vec![0.0; dim],
            orientation: None,
            work: Work::default(),
        }
    }

    /// Replaces `x`, a first guess, by the continuation of the branch from h = 0 to step size `h`.
    pub(crate) fn solve(&mut self, system: &mut impl System, h: f64, x: &mut [f64]) -> Result<(), SolveError> {
        debug_assert_eq!(x.len(), system.dim());
        self.origin.copy_from_slice(x);
        if self.orientation.is_none() {
            system.origin(&mut self.origin);
            self.orientation = Some(self.orientation_at(system, SHORT * h));
            self.origin.copy_from_slice(x);
        }
        match self.attempt(system, h, x) {
            Ok(()) => Ok(()),
            Err(first) => {
                system.origin(&mut self.origin);
                self.follow_branch(system, h, x, first)
            }
        }
    }

    /// The sign of det ∂F/∂x at (h, origin); NaN if it varies, or cannot be known.
    fn orientation_at(&mut self, system: &mut impl System, h: f64) -> f64 {
        if !system.keeps_orientation() {
            return f64::NAN;
        }
        system.residual(h, &self.origin, &mut self.increment);
        self.jacobian.clear();
        system.derivative(h, &self.origin, &mut self.jacobian);
        self.lu.factor(&self.jacobian).map_or(f64::NAN, |()| self.lu.sign())
    }

    /// Follows the branch from its origin in pieces of h, halved where Newton's iteration does not contract.
    fn follow_branch(
        &mut self,
        system: &mut impl System,
        h: f64,
        x: &mut [f64],
        first: SolveError,
    ) -> Result<(), SolveError> {
        let mut failure = first;
        let (mut reached, mut piece) = (0.0, 0.5 * h);
        for _ in 0..PIECES {
            if reached >= h {
                return Ok(());
            }
            let target = if reached + piece >= h { h } else { reached + piece };
            x.copy_from_slice(&self.origin);
            match self.attempt(system, target, x) {
                Ok(()) => {
                    self.origin.copy_from_slice(x);
                    reached = target;
                    piece *= 2.0;
                }
                Err(error) => {
                    failure = error;
                    piece *= 0.5;
                }
            }
            if reached == 0.0 && piece < f64::EPSILON * h {
                return Err(failure);
            }
            if piece < SHORTEST * reached {
                return Err(SolveError::BranchLost { reached });
            }
        }
        Err(failure)
    }

    /// Newton's iteration from `x`, which must contract from the start.
    ///
    /// It stops on the increment: a residual cancels like ε |q| / h and has no threshold of its own. With the ratio θ of the
    /// last two increments δ, the error left after an increment is at most θ/(1 − θ) δ.
    pub(crate) fn attempt(&mut self, system: &mut impl System, h: f64, x: &mut [f64]) -> Result<(), SolveError> {
        let (mut last, mut start) = (f64::INFINITY, f64::NAN);
        for iterations in 1..=ITERATIONS {
            system.residual(h, x, &mut self.increment);
            self.work.residuals += 1;
            if !max_norm(&self.increment).is_finite() {
                return Err(SolveError::NonFinite);
            }
            self.jacobian.clear();
            system.derivative(h, x, &mut self.jacobian);
            self.work.factorizations += 1;
            self.lu.factor(&self.jacobian)?;
            if iterations == 1 {
                start = self.lu.sign();
            }
            self.lu.solve(&mut self.increment);
            let delta = max_norm(&self.increment);
            if !delta.is_finite() {
                return Err(SolveError::NonFinite);
            }
            for (x, d) in x.iter_mut().zip(&self.increment) {
                *x -= d;
            }
            let roundoff = f64::EPSILON * max_norm(x).max(max_norm(&self.origin));
            let theta = if last.is_finite() { delta / last } else { 1.0 };
            if delta <= 4.0 * roundoff || (theta < CONTRACTION && theta * delta <= roundoff) {
                return self.accept(start, iterations, theta, delta);
            }
            if last.is_finite() && theta > CONTRACTION {
                // Ill-conditioned equations stagnate above ε |x|, after contraction has reached √ε |x|.
                let stagnates = last <= f64::EPSILON.sqrt() * max_norm(x).max(max_norm(&self.origin));
                let diverged = Err(SolveError::Diverged { iterations, increment: delta });
                return if stagnates { self.accept(start, iterations, theta, delta) } else { diverged };
            }
            last = delta;
        }
        Err(SolveError::Diverged { iterations: ITERATIONS, increment: last })
    }

    /// Accepts the root that the last increments `delta`, in the ratio `theta`, have led to, unless it is on another branch
    /// or ∂F/∂x, whose determinant had the sign `start` at first, was singular on the way there.
    fn accept(&self, start: f64, iterations: u32, theta: f64, increment: f64) -> Result<(), SolveError> {
        let at_rest = iterations == 1;
        let affine = iterations == 2 && theta <= f64::EPSILON.sqrt();
        if !at_rest && !affine && [start, self.lu.sign()].iter().any(|sign| self.orientation == Some(-sign)) {
            return Err(SolveError::Diverged { iterations, increment });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x² − 2x + h = 0: the branch x = 1 − √(1 − h) starts at 0 and folds at h = 1.
    struct Fold;

    impl System for Fold {
        fn dim(&self) -> usize {
            1
        }
        fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
            out[0] = x[0] * x[0] - 2.0 * x[0] + h;
        }
        fn derivative(&mut self, _: f64, x: &[f64], out: &mut Jacobian) {
            out.add(0, 0, 2.0 * x[0] - 2.0);
        }
    }

    #[test]
    fn stays_on_the_branch_up_to_the_fold() {
        for h in [1e-3, 0.5, 0.9, 0.999, 0.999_999] {
            let mut x = [0.0];
            Newton::new(1).solve(&mut Fold, h, &mut x).expect("on the branch");
            // The root's condition number is 1/(2√(1 − h)) ≤ 500.
            approx::assert_abs_diff_eq!(x[0], 1.0 - (1.0 - h).sqrt(), epsilon = 500.0 * 4.0 * f64::EPSILON);
        }
    }

    /// x² − 2x + h = 0 with a derivative that says nothing.
    struct Wrong;

    impl System for Wrong {
        fn dim(&self) -> usize {
            1
        }
        fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
            Fold.residual(h, x, out);
        }
        fn derivative(&mut self, _: f64, _: &[f64], out: &mut Jacobian) {
            out.add(0, 0, 0.9);
        }
    }

    #[test]
    fn gives_up_on_a_wrong_derivative() {
        let mut newton = Newton::new(1);
        assert!(newton.solve(&mut Wrong, 0.5, &mut [0.0]).is_err());
        assert!(newton.work.residuals <= u64::from(PIECES * ITERATIONS));
    }

    #[test]
    fn names_the_fold() {
        for h in [1.1, 3.0, 1e6] {
            let mut x = [0.0];
            match Newton::new(1).solve(&mut Fold, h, &mut x) {
                Err(SolveError::BranchLost { reached }) => {
                    approx::assert_abs_diff_eq!(reached, 1.0, epsilon = 1e-6);
                }
                other => panic!("h = {h}: {other:?} at x = {x:?}"),
            }
        }
    }
}
