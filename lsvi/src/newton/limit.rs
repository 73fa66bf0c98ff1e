//! ∂F/∂x for h → 0, and what it tells of a root: whether it is on the branch that starts at the present state.

use super::{CLOSE, LimitAtZero, MOST_NOISE, Newton, SURE_CONTRACTION, System, difference, is_close};
use crate::linalg::{Lu, larger, max_norm};

/// Ratio of the first two increments up to which the derivative changes by twice that at most on the way, 2⁻⁷, so that no way is too long.
const UNCHANGED: f64 = 1.0 / 256.0;
/// Radius of the disk round ⅝ for the ratio of increments by the derivatives at h and h/2; ⅜ belongs to modes that do not grow.
const DECAYING: f64 = 0.4;
/// Part of the tangent, or of the way to the root, at which an equation is asked whether it is affine: at all of it there may be that root,
/// and at a simple part another one.
const ASIDE: f64 = 0.618;
/// Halvings of a step at which first increments are compared; stiffness of 2 to this power is beyond double precision.
const HALVINGS: u32 = 60;
/// A part of the step at which ∂F/∂x is what it is for h → 0: no rate of a problem reaches it.
const SHORT: f64 = 1e-18;
/// The same where α + β → 0 with h, which has to be told from 0 to half of the digits.
const SHORT_OF_STEP: f64 = 1e-8;
/// The same along a first guess x₀ + h v, where v is to survive the rounding of x₀ + s v.
const SHORT_ALONG_GUESS: f64 = 1e-4;

/// ∂F/∂x at the origin for h → 0.
#[derive(Debug)]
pub(super) struct Limit {
    /// Factors at the step size [`SHORT`] h.
    pub(super) lu: Lu,
    /// That step size.
    pub(super) h: f64,
    pub(super) is_regular: bool,
    /// [`System::scale`] there.
    pub(super) scale: f64,
    /// Whether the branch leaves its origin along the first guess, and not along the increment from there: F is nonlinear in
    /// (x − x₀)/h.
    pub(super) is_along_guess: bool,
    /// Sign of the determinant, NaN where it is not known; `None` before the first solution.
    pub(super) orientation: Option<f64>,
}

impl Limit {
    /// Replaces a residual at step size `h` by the increment that the limit makes of it, up to its scale.
    pub(super) fn solve(&mut self, system: &dyn System, h: f64, residual: &mut [f64]) {
        for &row in system.algebraic() {
            residual[row] *= self.h / h;
        }
        self.lu.solve(residual);
    }
}

impl Newton {
    /// The limit of another system is not known.
    pub(super) fn forget_limit(&mut self) {
        self.limit.orientation = None;
        self.affine = None;
    }

    /// Factors ∂F/∂x at the origin for a part of `h` that is next to nothing.
    pub(super) fn set_limit(&mut self, system: &mut dyn System, h: f64) {
        self.limit.is_along_guess = false;
        self.part.copy_from_slice(&self.origin);
        let short = h * Self::short(system);
        self.factor_limit(system, short);
    }

    /// Factors ∂F/∂x on the way to the first guess for a part of `h` that is little.
    pub(super) fn set_limit_along_guess(&mut self, system: &mut dyn System, h: f64) {
        self.limit.is_along_guess = true;
        for (x, (origin, guess)) in self.part.iter_mut().zip(self.origin.iter().zip(&self.guess)) {
            *x = origin + SHORT_ALONG_GUESS * (guess - origin);
        }
        self.factor_limit(system, h * SHORT_ALONG_GUESS);
    }

    /// Factors ∂F/∂x at (h, `part`).
    fn factor_limit(&mut self, system: &mut dyn System, h: f64) {
        system.residual(h, &self.part, &mut self.increment);
        self.jacobian.clear();
        system.derivative(h, &self.part, &mut self.jacobian);
        let limit = &mut self.limit;
        limit.is_regular = limit.lu.factor(&self.jacobian).is_ok();
        limit.orientation = Some(if limit.is_regular { limit.lu.sign() } else { f64::NAN });
        limit.scale = system.scale(h);
        limit.h = h;
    }

    /// Whether the first guess is where the increment from the origin leads for h → 0, as it is where F is linear in
    /// (x − x₀)/h, to what an ill-conditioned derivative leaves of it.
    pub(super) fn guess_is_increment(&mut self, system: &mut dyn System, h: f64) -> bool {
        if !self.limit.is_regular {
            return false;
        }
        let scale = self.set_tangent(system, h);
        let (mut apart, mut way) = (0.0, 0.0);
        for (tangent, (guess, origin)) in self.part.iter().zip(self.guess.iter().zip(&self.origin)) {
            apart = larger(apart, guess - origin + scale * tangent);
            way = larger(way, guess - origin);
        }
        apart <= f64::EPSILON.sqrt() * way + self.roundoff()
    }

    /// Sets `part` to the tangent of the branch at the origin for a step of size `h`, by a factor that is returned and subtracted.
    fn set_tangent(&mut self, system: &mut dyn System, h: f64) -> f64 {
        if self.limit.is_along_guess {
            let ends = self.guess.iter().zip(&self.origin);
            self.part.iter_mut().zip(ends).for_each(|(x, (guess, origin))| *x = origin - guess);
            return h / self.whole_h;
        }
        let short = Self::short(system);
        system.residual(short * h, &self.origin, &mut self.part);
        self.work.residuals += 1;
        self.limit.lu.solve(&mut self.part);
        self.limit.scale / (short * system.scale(short * h))
    }

    /// Whether the derivative may be taken to be on a way of this length from the origin what it is at its ends.
    pub(super) fn is_in_reach(&self, way: f64, contraction: f64) -> bool {
        contraction <= UNCHANGED || way <= CLOSE * max_norm(&self.origin)
    }

    /// Whether increments contract from the first guesses for h/2, h/4, … too, as far as these leave the origin behind: far from it the equation may
    /// be simple again, on the other side of a fold.
    pub(super) fn contracts_on_way_to_guess(&mut self, system: &mut dyn System, h: f64) -> bool {
        let far = difference(&self.guess, 1.0, &self.origin);
        let mut part = 1.0;
        for _ in 0..HALVINGS {
            if part * far <= max_norm(&self.origin) {
                return true;
            }
            part *= 0.5;
            let ends = self.origin.iter().zip(&self.guess);
            self.point.iter_mut().zip(ends).for_each(|(x, (origin, guess))| *x = origin + part * (guess - origin));
            if !self.set_increment_at_point(system, part * h) {
                return false;
            }
            let size = max_norm(&self.increment);
            self.point.iter_mut().zip(&self.increment).for_each(|(x, d)| *x -= d);
            system.residual(part * h, &self.point, &mut self.increment);
            self.work.residuals += 1;
            self.lu.solve(&mut self.increment);
            let next = max_norm(&self.increment);
            if next.is_nan() || next > SURE_CONTRACTION * size + self.roundoff() {
                return false;
            }
        }
        true
    }

    /// Whether a way of this length from the origin is none to half of the digits, of equations of which that tells; where roundings were
    /// measured, to the digits that they may take.
    pub(super) fn is_next_to_origin(&self, system: &dyn System, way: f64) -> bool {
        let is_told = self.limit.is_regular && system.algebraic().is_empty();
        let part = if self.noise > 0.0 { MOST_NOISE } else { f64::EPSILON.sqrt() };
        is_told && way <= part * max_norm(&self.origin)
    }

    /// Whether the tangent of the branch leads no further than that, as far as it is known. Beside a spurious steady state a root is
    /// near that the branch does not come to.
    pub(super) fn has_short_tangent(&mut self, system: &mut dyn System, h: f64) -> bool {
        if !self.limit.is_regular || !system.algebraic().is_empty() {
            return true;
        }
        let scale = self.set_tangent(system, h);
        scale.abs() * max_norm(&self.part) <= CLOSE * max_norm(&self.origin)
    }

    /// Whether ∂F/∂x is regular at the first guess for all steps up to `h`; `contraction` is the ratio of the second increment
    /// to the first, which is `whole`.
    pub(super) fn is_regular(&mut self, system: &mut dyn System, h: f64, mut contraction: f64) -> bool {
        let mut s = h;
        for _ in 0..HALVINGS {
            if self.is_near_branch(system, s, contraction) {
                return true;
            }
            if self.is_back_at_origin(system, s) {
                return false;
            }
            let near_limit = self.is_near_limit(system, s) && self.is_along_tangent(system, s, 1.0);
            let way = 0.5 * s / h;
            let ends = self.origin.iter().zip(&self.guess);
            self.point.iter_mut().zip(ends).for_each(|(x, (origin, guess))| *x = origin + way * (guess - origin));
            if !self.set_increment_at_point(system, 0.5 * s) {
                return false;
            }
            // The same residual with the derivative for half the step.
            self.part.copy_from_slice(&self.first);
            self.lu.solve(&mut self.part);
            let scale = system.scale(0.5 * s) / system.scale(s);
            self.part.iter_mut().for_each(|d| *d *= scale);
            let (bend, size) = (difference(&self.part, 1.0, &self.whole), max_norm(&self.whole));
            let close = bend <= CLOSE * size + self.roundoff();
            if close && near_limit {
                return true;
            }
            // The increment for the whole step in terms of that for the half: ¼ to 1 where nothing grows.
            let decays = difference(&self.whole, 0.625, &self.part) <= DECAYING * max_norm(&self.part);
            if !decays || contraction.is_nan() || contraction > SURE_CONTRACTION {
                return false;
            }
            s *= 0.5;
            self.whole.copy_from_slice(&self.increment);
            self.first.copy_from_slice(&self.residual);
            for (x, d) in self.point.iter_mut().zip(&self.increment) {
                *x -= d;
            }
            // The derivative of the first increment does for the second, of which only the size counts.
            system.residual(s, &self.point, &mut self.increment);
            self.work.residuals += 1;
            self.lu.solve(&mut self.increment);
            contraction = max_norm(&self.increment) / max_norm(&self.whole);
            for (x, d) in self.point.iter_mut().zip(&self.whole) {
                *x += d;
            }
        }
        false
    }

    /// Whether the derivative has hardly changed from its limit for h → 0, and the increment `whole` from (h, point), of which the
    /// second is the part `contraction`, leads along the branch.
    pub(super) fn is_near_branch(&mut self, system: &mut dyn System, h: f64, contraction: f64) -> bool {
        contraction <= SURE_CONTRACTION
            && self.is_near_limit(system, h)
            && self.is_along_tangent(system, h, 2.0 * CLOSE)
    }

    /// Whether the limit of the derivative for h → 0 makes of the residual `first` at (h, point) the same increment as `whole`.
    fn is_near_limit(&mut self, system: &dyn System, h: f64) -> bool {
        if !self.limit.is_regular {
            return false;
        }
        self.part.copy_from_slice(&self.first);
        self.limit.solve(system, h, &mut self.part);
        is_close(&self.whole, self.limit.scale / system.scale(h), &self.part, self.roundoff())
    }

    fn short(system: &dyn System) -> f64 {
        if system.limit() == LimitAtZero::OfEachStep { SHORT_OF_STEP } else { SHORT }
    }

    /// Whether the increment `whole` from (h, point) leads along the tangent of the branch at the origin, to within `allowed` of
    /// the longer of the two. With 1 they may not be opposite, but one of them may vanish, as for a start from rest.
    pub(super) fn is_along_tangent(&mut self, system: &mut dyn System, h: f64, allowed: f64) -> bool {
        if !system.algebraic().is_empty() {
            return true;
        }
        let scale = self.set_tangent(system, h);
        let way = |i: usize| self.point[i] - self.whole[i] - self.origin[i];
        let (mut largest, mut along, mut apart) = (0.0_f64, 0.0_f64, 0.0_f64);
        for (i, tangent) in self.part.iter().enumerate() {
            largest = largest.max(way(i).abs());
            apart = apart.max((way(i) + scale * tangent).abs());
            along = along.max((scale * tangent).abs());
        }
        apart <= allowed * largest.max(along)
    }

    /// Whether the increment `whole` from (h, point) leads back to the origin, which the branch has left along its tangent: the origin is a root of
    /// another branch there, and increments are roundings, in proportion to anything.
    pub(super) fn is_back_at_origin(&mut self, system: &mut dyn System, h: f64) -> bool {
        let ends = self.point.iter().zip(&self.whole).map(|(x, d)| x - d).zip(&self.origin);
        let moved = ends.fold(0.0, |most, (end, origin)| larger(most, end - origin));
        if CLOSE * moved > self.roundoff() || !self.limit.is_regular || !system.algebraic().is_empty() {
            return false;
        }
        let scale = self.set_tangent(system, h);
        CLOSE * CLOSE * scale.abs() * max_norm(&self.part) > self.roundoff()
    }

    /// Whether an equation that two increments tell to be affine is so elsewhere too, to half of the digits: on the tangent of the
    /// branch, or on the way to the root where that lies much further away. Beside a root that the branch may leave on the way to h,
    /// increments are next to nothing. What was found holds for the steps that go on from it, as long as these are alike.
    pub(super) fn is_affine(&mut self, system: &mut dyn System, h: f64) -> bool {
        if !self.limit.is_regular || !system.algebraic().is_empty() {
            return true;
        }
        let ends = self.point.iter().zip(&self.whole).map(|(x, d)| x - d).zip(&self.origin);
        let moved = ends.fold(0.0, |most, (end, origin)| larger(most, end - origin));
        if let Some((size, last)) = self.affine {
            let apart = difference(&self.origin, 1.0, &self.affine_from);
            if size == h && 0.5 * last <= moved && moved <= 2.0 * last && apart <= 4.0 * last {
                self.affine_from.copy_from_slice(&self.origin);
                return true;
            }
        }
        let mut scale = self.set_tangent(system, h);
        if scale.abs() * max_norm(&self.part) < CLOSE * moved {
            scale = 1.0;
            self.part.copy_from_slice(&self.whole);
        }
        scale *= ASIDE;
        for (x, (point, d)) in self.reference.iter_mut().zip(self.point.iter().zip(&self.part)) {
            *x = point - scale * d;
        }
        system.residual(h, &self.reference, &mut self.increment);
        self.work.residuals += 1;
        self.increment.iter_mut().zip(&self.first).for_each(|(f, first)| *f -= first);
        self.lu.solve(&mut self.increment);
        let way = scale.abs() * max_norm(&self.part);
        let apart = difference(&self.increment, -scale, &self.part);
        if apart.is_nan() || apart > larger(f64::EPSILON.sqrt() * way, self.roundoff()) {
            return false;
        }
        self.affine = Some((h, moved));
        self.affine_from.copy_from_slice(&self.origin);
        true
    }
}
