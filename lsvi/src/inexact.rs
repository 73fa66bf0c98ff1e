//! Newton's method with iteratively solved linear systems (inexact Newton).
//!
//! No determinant is known here, so that a root counts as on the branch of the present state for one reason alone: the
//! increments contract from the first one on. Where they do not, the branch is followed in pieces of the step that are so short
//! that they do. See [`crate::newton`] for what factors tell besides.

use crate::error::SolveError;
use crate::linalg::max_norm;
use crate::newton::{Rounding, SAMPLES, Work};

/// Required ratio of successive increments.
const CONTRACTION: f64 = 0.5;
/// Iterations of one attempt: linear contraction by the least accurate inner solution reaches rounding in as many.
const ITERATIONS: u32 = 40;
/// Shortest piece of a continuation relative to what it has reached.
const SHORTEST: f64 = 1e-6;
/// Attempts on the pieces of one continuation.
const PIECES: u32 = 200;

/// The relative error of an inner solution that the outer iteration can use, where its residual has last fallen by `ratio`
/// (S. Eisenstat, H. Walker, SIAM J. Sci. Comput. 17, 1996, choice 2); never so large that it spoils contraction.
pub(crate) fn forcing(ratio: f64) -> f64 {
    const LARGEST: f64 = 1e-2;
    if ratio.is_finite() { (0.9 * ratio * ratio).clamp(f64::EPSILON, LARGEST) } else { LARGEST }
}

/// Refuses an increment of size `delta`, for a residual of size `residual`, that is not finite or no solution of anything.
pub(crate) fn check_increment(delta: f64, residual: f64, iterations: u64) -> Result<(), SolveError> {
    if !delta.is_finite() {
        return Err(SolveError::NonFinite);
    }
    // Below, the quotient of a residual and a matrix may be zero.
    let is_normal = residual >= f64::MIN_POSITIVE / f64::EPSILON;
    if delta == 0.0 && is_normal {
        return Err(SolveError::Linear { iterations: u32::try_from(iterations).unwrap_or(u32::MAX), residual: 1.0 });
    }
    Ok(())
}

/// A square system F(h, x) = 0 with its own way of solving with ∂F/∂x.
pub(crate) trait InexactSystem {
    /// Writes F(h, x).
    fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]);

    /// Overwrites `b` with the solution y of ∂F/∂x y = b at the (h, x) of the last residual, to a relative error of
    /// `tolerance`, and returns the number of inner iterations.
    fn solve(&mut self, h: f64, x: &[f64], b: &mut [f64], tolerance: f64) -> Result<u64, SolveError>;

    /// Whether what the solution `y` leaves of the last system, ρ = ∂F/∂x y − F, is that of errors of up to `error`, each told by its own
    /// equation. It costs about an inner iteration. Where there are no entries to tell it by, it holds.
    fn is_solved_to(&mut self, error: f64, at: (f64, &[f64]), y: &[f64], residual: &[f64]) -> bool;

    /// The error of the solution relative to its largest component that is good enough.
    fn tolerance(&self) -> f64;
}

/// Work space and counters; nothing is allocated after `new`.
#[derive(Debug)]
pub(crate) struct InexactNewton {
    increment: Vec<f64>,
    residual: Vec<f64>,
    origin: Vec<f64>,
    rounding: Rounding,
    pub(crate) work: Work,
}

impl InexactNewton {
    pub(crate) fn new(dim: usize) -> Self {
        let zeros = vec![0.0; dim];
        Self {
            increment: zeros.clone(),
            residual: zeros.clone(),
            origin: zeros,
            rounding: Rounding::default(),
            work: Work::default(),
        }
    }

    /// Replaces `x`, the solution at h = 0, by that at `h`.
    pub(crate) fn solve(&mut self, system: &mut dyn InexactSystem, h: f64, x: &mut [f64]) -> Result<(), SolveError> {
        self.origin.copy_from_slice(x);
        let Err(mut failure) = self.attempt(system, h, x) else { return Ok(()) };
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
            if piece < SHORTEST * h {
                return Err(if reached > 0.0 { failure.beyond(reached) } else { failure });
            }
        }
        Err(failure)
    }

    fn attempt(&mut self, system: &mut dyn InexactSystem, h: f64, x: &mut [f64]) -> Result<(), SolveError> {
        let (mut delta, mut last, mut before) = (f64::NAN, f64::INFINITY, f64::NAN);
        let least = f64::EPSILON.max(system.tolerance());
        let mut most = 1.0_f64;
        for iterations in 1..=ITERATIONS {
            system.residual(h, x, &mut self.residual);
            self.work.residuals += 1;
            let size = self.residual.iter().map(|x| x * x).sum::<f64>().sqrt();
            if !size.is_finite() {
                return Err(SolveError::NonFinite);
            }
            if size == 0.0 {
                return Ok(());
            }
            self.work.factorizations += 1;
            self.increment.copy_from_slice(&self.residual);
            let tolerance = forcing(size / before).min(most);
            let inner = system.solve(h, x, &mut self.increment, tolerance)?;
            self.work.inner += inner;
            before = size;
            delta = max_norm(&self.increment);
            check_increment(delta, size, inner)?;
            let largest = max_norm(x).max(max_norm(&self.origin));
            let (roundoff, enough) = (f64::EPSILON * largest, least * largest);
            let theta = if last.is_finite() { delta / last } else { 1.0 };
            let converged = delta <= 4.0 * roundoff || (theta < CONTRACTION && theta * delta <= (1.0 - theta) * enough);
            let grows = last.is_finite() && theta > CONTRACTION;
            let allowed = if converged { enough } else { enough.max(f64::EPSILON.sqrt() * largest) };
            let most_of_two = last.max(delta);
            let stagnates =
                grows && most_of_two <= allowed && (most_of_two <= enough || self.is_at_rounding(system, h, x, last));
            if grows && !converged && !stagnates {
                if most <= least {
                    return Err(SolveError::Diverged { iterations, increment: delta });
                }
                // With a weak preconditioner the increments of Newton's iteration contract where those of loose solutions do not.
                x.copy_from_slice(&self.origin);
                (most, last, before) = (least, f64::INFINITY, f64::NAN);
                continue;
            }
            let is_last = converged || stagnates;
            let error = allowed.max(4.0 * roundoff);
            let is_solved = is_last && system.is_solved_to(error, (h, x), &self.increment, &self.residual);
            x.iter_mut().zip(&self.increment).for_each(|(x, d)| *x -= d);
            if is_solved {
                return Ok(());
            }
            // The norm of the preconditioner passed over what is left, of which increments so far say nothing.
            (most, last) = if is_last { (least, f64::INFINITY) } else { (most, delta) };
        }
        Err(SolveError::Diverged { iterations: ITERATIONS, increment: delta })
    }

    fn is_at_rounding(&mut self, system: &mut dyn InexactSystem, h: f64, x: &[f64], last: f64) -> bool {
        self.work.residuals += SAMPLES + 1;
        let is_rounding = self.rounding.explains(&mut |x, out| system.residual(h, x, out), x, &self.increment, last);
        // What is multiplied with is of the last residual.
        system.residual(h, x, &mut self.residual);
        is_rounding
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x² − 2x + h = 0, whose branch x = 1 − √(1 − h) folds at h = 1, with exact inner solutions.
    struct Fold;

    impl InexactSystem for Fold {
        fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
            out[0] = x[0] * x[0] - 2.0 * x[0] + h;
        }
        fn solve(&mut self, _h: f64, x: &[f64], b: &mut [f64], _tolerance: f64) -> Result<u64, SolveError> {
            b[0] /= 2.0 * x[0] - 2.0;
            Ok(1)
        }
        fn is_solved_to(&mut self, _error: f64, _at: (f64, &[f64]), _y: &[f64], _residual: &[f64]) -> bool {
            true
        }
        fn tolerance(&self) -> f64 {
            0.0
        }
    }

    #[test]
    fn a_branch_is_followed_up_to_its_fold() {
        for h in [0.9, 0.9999] {
            let mut x = [0.0];
            InexactNewton::new(1).solve(&mut Fold, h, &mut x).expect("on the branch");
            // The root's condition number is 1/(2√(1 − h)) ≤ 50.
            approx::assert_abs_diff_eq!(x[0], 1.0 - (1.0 - h).sqrt(), epsilon = 50.0 * 4.0 * f64::EPSILON);
        }
        for h in [1.1, 3.0] {
            match InexactNewton::new(1).solve(&mut Fold, h, &mut [0.0]) {
                // Pieces that contract are a part of what is left to the fold, down to 1e-6 h.
                Err(SolveError::BranchLost { reached }) => {
                    approx::assert_abs_diff_eq!(reached, 1.0, epsilon = 2e-5);
                }
                other => panic!("h = {h}: {other:?}"),
            }
        }
    }

    /// x − h = 0 with residuals that are off by a part `noise` of h to either side in turn, and inner solutions that are a fifth too short.
    struct Noisy {
        noise: f64,
    }

    impl InexactSystem for Noisy {
        fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
            self.noise = -self.noise;
            out[0] = x[0] - h * (1.0 + self.noise);
        }
        fn solve(&mut self, _h: f64, _x: &[f64], b: &mut [f64], _tolerance: f64) -> Result<u64, SolveError> {
            b[0] *= 0.8;
            Ok(1)
        }
        fn is_solved_to(&mut self, _error: f64, _at: (f64, &[f64]), _y: &[f64], _residual: &[f64]) -> bool {
            true
        }
        fn tolerance(&self) -> f64 {
            0.0
        }
    }

    #[test]
    fn increments_may_stagnate_below_half_of_the_digits_alone() {
        let solve = |noise: f64| {
            let mut x = [0.0];
            InexactNewton::new(1).solve(&mut Noisy { noise }, 1.0, &mut x).map(|()| x[0])
        };
        let x = solve(1e-9).expect("half of the digits");
        // An increment leaves a fifth of the error before it, which is of the noise by then, and brings in four fifths of the noise.
        approx::assert_abs_diff_eq!(x, 1.0, epsilon = 2e-9);
        for noise in [1e-6, 1e-5] {
            let found = solve(noise);
            assert!(matches!(found, Err(SolveError::Diverged { .. })), "{noise:e}: {found:?}");
        }
    }

    /// What a system is asked for: how often for its residual, and for what errors whether it is solved to them.
    struct Asked<S> {
        system: S,
        residuals: u64,
        errors: Vec<f64>,
    }

    impl<S> Asked<S> {
        fn of(system: S) -> Self {
            Self { system, residuals: 0, errors: Vec::new() }
        }
    }

    impl<S: InexactSystem> InexactSystem for Asked<S> {
        fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
            self.residuals += 1;
            self.system.residual(h, x, out);
        }
        fn solve(&mut self, h: f64, x: &[f64], b: &mut [f64], tolerance: f64) -> Result<u64, SolveError> {
            self.system.solve(h, x, b, tolerance)
        }
        fn is_solved_to(&mut self, error: f64, at: (f64, &[f64]), y: &[f64], residual: &[f64]) -> bool {
            self.errors.push(error);
            self.system.is_solved_to(error, at, y, residual)
        }
        fn tolerance(&self) -> f64 {
            self.system.tolerance()
        }
    }

    /// Beside its origin, 8, which is larger: where increments contract four of its roundings, and where they stagnate half of its digits.
    #[test]
    fn a_solution_is_held_to_a_few_roundings_or_to_half_of_the_digits() {
        for (noise, expected) in [(0.0, 4.0 * f64::EPSILON * 8.0), (1e-9, f64::EPSILON.sqrt() * 8.0)] {
            let mut asked = Asked::of(Noisy { noise });
            InexactNewton::new(1).solve(&mut asked, 1.0, &mut [8.0]).expect("contracts");
            assert_eq!(asked.errors, [expected], "{noise:e}");
        }
    }

    #[test]
    fn evaluations_that_tell_roundings_are_counted() {
        let (mut newton, mut asked) = (InexactNewton::new(1), Asked::of(Noisy { noise: 1e-9 }));
        newton.solve(&mut asked, 1.0, &mut [0.0]).expect("half of the digits");
        assert!(asked.residuals > SAMPLES, "{}", asked.residuals);
        assert_eq!(newton.work.residuals, asked.residuals);
    }
}
