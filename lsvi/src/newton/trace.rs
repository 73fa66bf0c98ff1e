//! A root followed back to where a step begins, of equations that determine no branch for h → 0.

use super::{Newton, SURE_CONTRACTION, System, difference};
use crate::error::SolveError;

/// The next step size beside the last one.
const SHORTER: f64 = 0.5;
/// How far a root may be from where the line through the last two leads, in terms of how far it is from the origin: another branch is further away.
const BESIDE: f64 = 0.1;
/// How near to the origin the line leads, in the same terms.
const NEAR: f64 = 0.02;
/// The least that the next one may be shorter by.
const LEAST: f64 = 1e-6;
/// Roots that are looked for on the way back, those that are too far off included: a branch of rate λ begins after log₂(hλ) of them.
const ROOTS: u32 = 200;

impl Newton {
    /// Replaces `x`, a first guess, by a root at `h` on a branch that begins at the origin: the one that Newton's iteration finds, or else the one that
    /// pieces of h lead to.
    pub(crate) fn solve_traced(&mut self, system: &mut dyn System, h: f64, x: &mut [f64]) -> Result<(), SolveError> {
        self.solve(system, h, x)?;
        if self.comes_from_origin(system, h, x) {
            return Ok(());
        }
        // The first guess.
        x.copy_from_slice(&self.start);
        self.guess.copy_from_slice(&self.start);
        self.origin.copy_from_slice(&self.start);
        system.origin(&mut self.origin);
        self.follow_branch(system, h, x, SolveError::OtherBranch)?;
        if self.comes_from_origin(system, h, x) { Ok(()) } else { Err(SolveError::OtherBranch) }
    }

    /// Whether the branch on which `x`, a root at step size `h`, lies begins at the origin: whether x goes there in proportion to h, as far as two
    /// lines through neighbours tell. The determinant keeps its sign on a branch without a fold.
    fn comes_from_origin(&mut self, system: &mut dyn System, h: f64, x: &[f64]) -> bool {
        self.origin.copy_from_slice(x);
        system.origin(&mut self.origin);
        if self.set_increment(system, h, x).is_err() {
            return false;
        }
        let sign = self.lu.sign();
        let [mut later, mut now, mut next] = std::mem::take(&mut self.traced);
        for point in [&mut later, &mut now, &mut next] {
            point.clear();
            point.extend_from_slice(x);
        }
        let comes = self.follow_back(system, h, sign, [&mut later, &mut now, &mut next]);
        self.traced = [later, now, next];
        comes
    }

    /// The same for three copies of the root, and the sign of the determinant there.
    fn follow_back(
        &mut self,
        system: &mut dyn System,
        h: f64,
        sign: f64,
        [mut later, mut now, mut next]: [&mut Vec<f64>; 3],
    ) -> bool {
        // Step sizes of `later` and `now`.
        let (mut after, mut at, mut part) = (f64::INFINITY, h, SHORTER);
        let mut leads = 0;
        for _ in 0..ROOTS {
            if difference(now, 1.0, &self.origin) <= self.roundoff() {
                return true;
            }
            let target = part * at;
            // The line through the last two.
            let slope = if after.is_finite() { (at - target) / (after - at) } else { 0.0 };
            next.iter_mut()
                .zip(now.iter().zip(&*later))
                .for_each(|(next, (now, later))| *next = now + slope * (now - later));
            self.reference.copy_from_slice(next);
            let found = self.iterate(system, target, next, SURE_CONTRACTION);
            let way = difference(next, 1.0, &self.origin);
            let is_beside = difference(next, 1.0, &self.reference) <= BESIDE * way + self.roundoff();
            let keeps = found.is_ok()
                && is_beside
                && self.set_increment(system, target, next).is_ok()
                && self.lu.sign() == sign;
            if !keeps {
                part = part.sqrt();
                if 1.0 - part < LEAST {
                    return false;
                }
                continue;
            }
            (after, at, part) = (at, target, part.powi(2).max(SHORTER));
            std::mem::swap(&mut later, &mut now);
            std::mem::swap(&mut now, &mut next);
            // Where the line leads for h = 0.
            let slope = at / (after - at);
            let ends = now.iter().zip(&*later).map(|(now, later)| now + slope * (now - later));
            next.iter_mut().zip(ends).for_each(|(next, end)| *next = end);
            leads = if difference(next, 1.0, &self.origin) <= NEAR * way { leads + 1 } else { 0 };
            if leads == 2 {
                return true;
            }
        }
        false
    }
}
