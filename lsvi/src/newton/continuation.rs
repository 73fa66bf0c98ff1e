//! The branch followed from its start in pieces of a step, to its end or across a kink.

use super::{CLOSE, CONTRACTION, LOOKS, LimitAtZero, Newton, Root, SURE_CONTRACTION, System, difference, is_close};
use crate::error::SolveError;
use crate::linalg::{larger, max_norm};

/// Growth of the next piece of a continuation after one that succeeded.
const GROWTH: f64 = 1.5;
/// Shortest piece of a continuation relative to what it has reached: a fold is located to this precision.
const SHORTEST: f64 = 1e-10;
/// Parts of what a continuation has reached by which it goes on beyond its end, to look for the branch behind a kink: first so far that roundings hide nothing, and
/// differences of derivatives do not reach back across the kink; less where the branch does not go on straight for that long.
const ACROSS: [f64; 3] = [640_000.0 * SHORTEST, 6400.0 * SHORTEST, 64.0 * SHORTEST];
/// How straight the branch is on both sides of a kink. A continuation ends elsewhere as the derivative changes by [`SURE_CONTRACTION`] on its
/// shortest pieces.
const STRAIGHT: f64 = 1e-3;
/// How far behind a kink it may lead on the longest of these ways, relative to the whole: a hundred times as steeply, and on the shortest 10⁶ times.
const FARTHEST: f64 = 1e6 * 64.0 * SHORTEST;
/// Iterations to the branch behind a kink: each may change the side of the kink in one component.
const CROSSINGS: u32 = 20;
/// Attempts of a continuation from which on pieces on which F is affine are told by increments in proportion to them.
const SLOW: u32 = 40;
/// Attempts on the pieces of one continuation. A fold takes log₂(1/SHORTEST) halvings, and the branch before it few more;
/// more than that is the crawl of an equation whose derivative is wrong.
pub(super) const PIECES: u32 = 500;

impl Newton {
    /// Follows the branch from its origin in pieces of h, halved where they are not [sure](Self::advance).
    pub(super) fn follow_branch(
        &mut self,
        system: &mut dyn System,
        h: f64,
        x: &mut [f64],
        first: SolveError,
    ) -> Result<(), SolveError> {
        let is_known = system.limit() != LimitAtZero::Unknown && !self.limit.is_along_guess;
        self.point.copy_from_slice(&self.origin);
        let mut failure = first;
        let (mut reached, mut piece) = (0.0, 0.5 * h);
        for attempt in 0..PIECES {
            if reached >= h {
                return Ok(());
            }
            let target = if reached + piece >= h { h } else { reached + piece };
            let advanced = if is_known {
                self.advance(system, (reached, target), attempt >= SLOW, x)
            } else {
                self.advance_along_secant(system, target, target / h, x)
            };
            match advanced {
                Ok(()) => {
                    self.origin.copy_from_slice(x);
                    reached = target;
                    piece *= GROWTH;
                }
                Err(error) => {
                    failure = error;
                    piece *= 0.5;
                }
            }
            if reached == 0.0 && piece < f64::EPSILON * h {
                let is_lost = matches!(failure, SolveError::Diverged { .. } | SolveError::OtherBranch);
                // No step is short enough for a derivative that is regular in the limit only.
                let is_singular = is_lost && system.limit() == LimitAtZero::OfEachStep;
                return Err(if is_singular { SolveError::Singular } else { failure });
            }
            if piece < self.shortest_piece(system) * reached {
                let targets = ACROSS.map(|part| h.min(reached * (1.0 + part)));
                let crossed = targets.into_iter().find(|target| self.crosses_kink(system, (reached, *target), x));
                let Some(target) = crossed else { return Err(failure.beyond(reached)) };
                self.origin.copy_from_slice(x);
                (reached, piece) = (target, 0.5 * (h - target));
            }
        }
        Err(failure)
    }

    /// Sets `x` to the root at `target`, just beyond the end of a continuation at the origin, its point at `reached`, where F has a kink there: on
    /// either side of it the branch is straight, as it is beside no fold and no branch that comes near, and the determinants have one sign.
    pub(super) fn crosses_kink(
        &mut self,
        system: &mut dyn System,
        (reached, target): (f64, f64),
        x: &mut [f64],
    ) -> bool {
        x.copy_from_slice(&self.origin);
        if system.limit() != LimitAtZero::Kept || !self.is_straight(system, (reached, 2.0 * reached - target), x) {
            return false;
        }
        let mut is_found = false;
        for _ in 0..CROSSINGS {
            if is_found || self.set_increment(system, target, x).is_err() {
                break;
            }
            x.iter_mut().zip(&self.increment).for_each(|(x, d)| *x -= d);
            // Of what is far smaller than its terms the roundings are more than its own.
            let across = difference(x, 1.0, &self.origin);
            is_found = max_norm(&self.increment) <= STRAIGHT * STRAIGHT * across + self.roundoff();
        }
        let way = difference(&self.origin, 1.0, &self.start);
        is_found
            && difference(x, 1.0, &self.origin) <= FARTHEST * way
            && self.is_straight(system, (target, 0.5 * (reached + target)), x)
            && !self.is_turned()
    }

    /// Whether one increment leads from `x`, the root at step size `from`, to that at `to`, to a thousandth.
    fn is_straight(&mut self, system: &mut dyn System, (from, to): (f64, f64), x: &[f64]) -> bool {
        if self.set_increment(system, from, x).is_err() {
            return false;
        }
        system.residual(to, x, &mut self.part);
        self.lu.solve(&mut self.part);
        self.point.iter_mut().zip(x.iter().zip(&self.part)).for_each(|(point, (x, d))| *point = x - d);
        system.residual(to, &self.point, &mut self.increment);
        self.lu.solve(&mut self.increment);
        self.work.residuals += 2;
        max_norm(&self.increment) <= STRAIGHT * max_norm(&self.part) + self.roundoff()
    }

    /// The shortest piece of a continuation relative to what it has reached. Where the branch may cross others, x changes by more than
    /// roundings on it: among them the two cannot be told apart.
    fn shortest_piece(&self, system: &dyn System) -> f64 {
        if system.limit() != LimitAtZero::OfEachStep {
            return SHORTEST;
        }
        let way = self.origin.iter().zip(&self.point).fold(0.0, |most, (x, start)| larger(most, x - start));
        if way > 0.0 { SHORTEST.max(8.0 * self.roundoff() / way) } else { SHORTEST }
    }

    /// Sets `x` to the continuation of the branch from the origin, its point at `from`, to `target`.
    ///
    /// What a derivative makes of the residual at another step size may be far from what it makes of its own, as BᵀB of components in unlike units does.
    /// Where F is affine on the way to half of the digits, increments in proportion to the way tell as much; `tells_affine` asks for that.
    pub(super) fn advance(
        &mut self,
        system: &mut dyn System,
        (from, target): (f64, f64),
        tells_affine: bool,
        x: &mut [f64],
    ) -> Result<(), SolveError> {
        x.copy_from_slice(&self.origin);
        let middle = 0.5 * (from + target);
        self.set_increment(system, middle, x)?;
        self.whole.copy_from_slice(&self.increment);
        system.residual(target, x, &mut self.part);
        self.lu.solve(&mut self.part);
        let scale = system.scale(middle) / system.scale(target);
        self.part.iter_mut().for_each(|d| *d *= scale);
        let reference = (from == 0.0 && self.limit.is_regular).then(|| {
            system.residual(target, x, &mut self.reference);
            self.limit.solve(system, target, &mut self.reference);
            self.limit.scale / system.scale(target)
        });
        self.set_increment(system, target, x)?;
        let roundoff = self.roundoff();
        let mut same = is_close(&self.increment, 1.0, &self.part, roundoff);
        let close = (same || tells_affine && is_close(&self.increment, 2.0, &self.whole, roundoff))
            && reference.is_none_or(|scale| {
                self.whole.copy_from_slice(&self.increment);
                self.point.copy_from_slice(x);
                same &= is_close(&self.increment, scale, &self.reference, roundoff);
                (same || tells_affine)
                    && !self.is_back_at_origin(system, target)
                    && self.is_along_tangent(system, target, if same { 1.0 } else { 2.0 * CLOSE })
            });
        if !close {
            return Err(SolveError::Diverged { iterations: 1, increment: max_norm(&self.increment) });
        }
        let root = self.iterate(system, target, x, SURE_CONTRACTION)?;
        let is_borne_out = (same || matches!(root, Root::Only))
            && self.is_borne_out(system, (from, target), LOOKS[0], tells_affine, x);
        if is_borne_out { Ok(()) } else { Err(SolveError::OtherBranch) }
    }

    /// Whether on a part of the way from the origin, at step size `from`, to `x`, the root at `target`, the derivative makes of the first
    /// residual nearly the same increment as at the origin, and increments contract from the chord to a root. Where it `tells_affine`, as
    /// [`advance`](Self::advance) does, the residual there may take the place of the first one.
    pub(super) fn is_borne_out(
        &mut self,
        system: &mut dyn System,
        (from, target): (f64, f64),
        part: f64,
        tells_affine: bool,
        x: &[f64],
    ) -> bool {
        let between = from + part * (target - from);
        let mut on_chord = std::mem::take(&mut self.reference);
        let ends = self.origin.iter().zip(x);
        on_chord.iter_mut().zip(ends).for_each(|(between, (origin, x))| *between = origin + part * (x - origin));
        let found = self.set_increment(system, between, &on_chord);
        let bend = max_norm(&self.increment);
        on_chord.iter_mut().zip(&self.increment).for_each(|(x, d)| *x -= d);
        self.reference = on_chord;
        if found.is_err() || self.is_turned() {
            return false;
        }
        self.part.copy_from_slice(&self.first);
        self.lu.solve(&mut self.part);
        system.residual(between, &self.reference, &mut self.increment);
        self.work.residuals += 1;
        self.lu.solve(&mut self.increment);
        let contracts = |by: f64| max_norm(&self.increment) <= by * bend + self.roundoff();
        let (sure, affine) = (contracts(SURE_CONTRACTION), tells_affine && contracts(f64::EPSILON.sqrt()));
        let scale = system.scale(target) / system.scale(between);
        sure && (is_close(&self.part, scale, &self.whole, self.roundoff())
            || affine && {
                system.residual(between, &self.origin, &mut self.part);
                self.work.residuals += 1;
                self.lu.solve(&mut self.part);
                is_close(&self.whole, part.recip(), &self.part, self.roundoff())
            })
    }

    /// Sets `x` to a root at `target`, the part `way` of the step, to which the iteration contracts from the secant through the
    /// solution at h = 0, which is `point`, and the last one found, continued to h in `guess`.
    fn advance_along_secant(
        &mut self,
        system: &mut dyn System,
        target: f64,
        way: f64,
        x: &mut [f64],
    ) -> Result<(), SolveError> {
        let secant = self.point.iter().zip(&self.guess);
        x.iter_mut().zip(secant).for_each(|(x, (start, guess))| *x = start + way * (guess - start));
        self.iterate(system, target, x, CONTRACTION)?;
        let found = self.point.iter().zip(x.iter());
        self.guess.iter_mut().zip(found).for_each(|(guess, (start, x))| *guess = start + (x - start) / way);
        Ok(())
    }
}
