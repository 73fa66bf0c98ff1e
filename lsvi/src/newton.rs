//! Newton's method for step equations, held to the branch that starts at the present state.
//!
//! A step equation F(h, x) = 0 can have several roots, and more than one can be an attractor of Newton's iteration. The
//! right one is continuous in h from x = x₀ at h = 0. With A(s) = ∂F/∂x(s, x₀), it is found in one go where
//!
//! - the increments contract by [`CONTRACTION`] from the first one on: in that ball (Newton–Kantorovich) the root is unique;
//! - det A has the sign that it has for s → 0, before and after: on the branch it cannot change;
//! - neither the way to the root nor the tangent of the branch is long beside x₀, so that A is on it what it is at its ends; else
//!   A(s) has to act on the residual as A(h) does, and increments have to contract, at two places of that way;
//! - A stays regular on the way from 0 to h. It does where A(h) acts on the residual as its limit for s → 0 does, to within
//!   [`CLOSE`]. Where it does not, first increments at h/2, h/4, … tell until two of them are in proportion: in a mode of
//!   rate λ their ratio is (1 − z)/(2 − z), z = hλ, in the disk of diameter [½, 1] where Re z ≤ 0, and leaves it where A is
//!   singular in between;
//! - where a first guess leads further away than x₀ is large, increments contract from those for h/2, h/4, … too.
//!
//! A root that is found next to x₀, to half of the digits, is the branch's where F is affine along its tangent: beside a rest increments
//! are roundings, in no proportion to each other.
//!
//! Otherwise the root is followed in pieces of h, on each of which the branch hardly bends, as half-way tells. Its end, a fold,
//! is an error; a kink of F, on both sides of which the branch is straight, is none. Only an affine equation keeps its one root
//! beyond a pole, where the determinant changes its sign: it is told by a second increment of less than √ε of the first, which
//! leaves room for an ill-conditioned derivative, and by its change on the tangent of the branch or, where the root lies much
//! further away, on the way to that. A nonlinear equation whose state is as small as √ε of its nonlinear scale is taken for one,
//! as it behaves like one.

mod kept;
mod units;

use std::ops::Add;

use auto_impl::auto_impl;
use kept::Kept;
use units::Balanced;
pub(crate) use units::are_unlike;

use crate::error::SolveError;
use crate::linalg::{Jacobian, Lu, Structure, larger, max_norm};

/// Required ratio of successive increments: Newton–Kantorovich gives uniqueness for quadratic contraction from ½.
const CONTRACTION: f64 = 0.5;
/// Ratio of the first two increments up to which the derivative, with quadratic contraction, changes by no more than a quarter
/// on the way, so that no second root is as near as the first.
pub(crate) const SURE_CONTRACTION: f64 = 0.125;
/// The ratio up to which it changes by twice that at most, 2⁻⁷, so that no way is too long.
const UNCHANGED: f64 = 1.0 / 256.0;
/// Iterations of one attempt: as many as linear contraction by [`CONTRACTION`] needs to reach roundoff.
const ITERATIONS: u32 = 60;
/// Largest relative difference of two increments by derivatives that count as close.
pub(crate) const CLOSE: f64 = 0.25;
/// Radius of the disk round ⅝ for the ratio of increments by the derivatives at h and h/2; ⅜ belongs to modes that do not grow.
const DECAYING: f64 = 0.4;
/// Parts of a long way at which the branch is looked at; what is found at the first says little of a fold near the root.
const LOOKS: [f64; 2] = [0.5, 0.75];
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
/// The least size of a state whose roundings are a part ε of it: doubles below [`f64::MIN_POSITIVE`] lose their digits.
const SMALLEST: f64 = f64::MIN_POSITIVE / f64::EPSILON;
/// Roundings of F are measured so many times. They may be this part of the state at most: where an ill-conditioned derivative makes more of
/// them, as beside a fold, its least singular value is ε over that, and two roots there are as far apart, ten digits.
const ROUNDS: u32 = 4;
const MOST_NOISE: f64 = 1e-5;
/// The second increment of an affine equation is so many roundings at most, of the largest state so far.
const ROUNDINGS: f64 = 8.0;
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
const PIECES: u32 = 500;

/// A square system F(h, x) = 0 that depends on the step size h.
#[auto_impl(&mut)]
pub(crate) trait System {
    fn dim(&self) -> usize;
    fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]);
    /// The same of a system of N unknowns, of any number for N = 0; no derivative is asked for where it was evaluated.
    #[inline]
    #[auto_impl(keep_default_for(&mut))]
    fn residual_sized<const N: usize>(&mut self, h: f64, x: &[f64], out: &mut [f64])
    where
        Self: Sized,
    {
        self.residual(h, x, out);
    }
    /// Adds ∂F/∂x to the zero matrix `out`, at the (h, x) where the residual was evaluated last.
    fn derivative(&mut self, h: f64, x: &[f64], out: &mut Jacobian);
    /// Replaces a first guess by the solution at h = 0, where the branch starts; unless they are the same.
    fn origin(&self, _x: &mut [f64]) {}
    fn limit(&self) -> LimitAtZero {
        LimitAtZero::Unknown
    }
    /// Whether the first guess for h leads along the tangent of the branch at h = 0, known better than by one increment from there.
    fn guesses_along_tangent(&self) -> bool {
        false
    }
    /// The equations that are in proportion to h for h → 0, algebraic ones times h. A residual of theirs at the origin is what
    /// rounding left there, from which no tangent follows.
    fn algebraic(&self) -> &[usize] {
        &[]
    }
    /// Whether F is affine in x, as its field declares.
    fn is_affine(&self) -> bool {
        false
    }
    /// What ∂F/∂x is in proportion to for h → 0.
    fn scale(&self, _h: f64) -> f64 {
        1.0
    }
}

/// What is known of ∂F/∂x for h → 0, after division by its [`System::scale`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LimitAtZero {
    /// The sign of its determinant, and in most systems all of it, is the same for every step.
    Kept,
    /// It is regular, but depends on the state.
    OfEachStep,
    /// Nothing, so that no branch can be told from another: a root is one to which the iteration contracts.
    Unknown,
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
    /// First guess, and that of the whole step.
    guess: Vec<f64>,
    start: Vec<f64>,
    /// The point of the branch from which an attempt starts: the solution at h = 0, in a continuation the last one found.
    origin: Vec<f64>,
    /// The residual that was evaluated last for an increment.
    residual: Vec<f64>,
    /// The first increment of an attempt with its residual, and others to compare with.
    whole: Vec<f64>,
    first: Vec<f64>,
    part: Vec<f64>,
    reference: Vec<f64>,
    point: Vec<f64>,
    /// Step size of the first guess.
    whole_h: f64,
    /// What the roundings of F make of increments, where they were measured to be more than a few of the state.
    noise: f64,
    /// The largest component of the roots of affine equations, and of where they started, so far.
    largest: f64,
    limit: Limit,
    /// Size of the last step, and how far it led, if its equation was found to be [affine](Newton::is_affine); where it started.
    affine: Option<(f64, f64)>,
    affine_from: Vec<f64>,
    kept: Option<Box<Kept>>,
    balanced: Option<Box<Balanced>>,
    pub(crate) work: Work,
}

/// ∂F/∂x at the origin for h → 0.
#[derive(Debug)]
struct Limit {
    /// Factors at the step size [`SHORT`] h.
    lu: Lu,
    /// That step size.
    h: f64,
    is_regular: bool,
    /// [`System::scale`] there.
    scale: f64,
    /// Whether the branch leaves its origin along the first guess, and not along the increment from there: F is nonlinear in
    /// (x − x₀)/h.
    is_along_guess: bool,
    /// Sign of the determinant, NaN where it is not known; `None` before the first solution.
    orientation: Option<f64>,
}

impl Limit {
    /// Replaces a residual at step size `h` by the increment that the limit makes of it, up to its scale.
    fn solve(&mut self, system: &dyn System, h: f64, residual: &mut [f64]) {
        for &row in system.algebraic() {
            residual[row] *= self.h / h;
        }
        self.lu.solve(residual);
    }
}

impl Newton {
    pub(crate) fn new(dim: usize) -> Self {
        Self::with_structure(dim, &Structure::Dense)
    }

    /// For systems whose derivative has the given structure.
    pub(crate) fn with_structure(dim: usize, structure: &Structure) -> Self {
        let jacobian = Jacobian::with_structure(dim, structure);
        let zeros = vec![0.0; dim];
        Self {
            lu: Lu::of(&jacobian),
            limit: Limit {
                lu: Lu::of(&jacobian),
                h: f64::NAN,
                is_regular: false,
                scale: 1.0,
                is_along_guess: false,
                orientation: None,
            },
            whole_h: f64::NAN,
            noise: 0.0,
            largest: 0.0,
            affine: None,
            affine_from: zeros.clone(),
            kept: None,
            balanced: None,
            jacobian,
            increment: zeros.clone(),
            guess: zeros.clone(),
            start: zeros.clone(),
            origin: zeros.clone(),
            residual: zeros.clone(),
            whole: zeros.clone(),
            first: zeros.clone(),
            part: zeros.clone(),
            reference: zeros.clone(),
            point: zeros,
            work: Work::default(),
        }
    }

    /// Replaces `x`, a first guess, by the continuation of the branch from h = 0 to step size `h`. Where none is found it is looked for in
    /// [other units](units) of the unknowns.
    pub(crate) fn solve(&mut self, system: &mut dyn System, h: f64, x: &mut [f64]) -> Result<(), SolveError> {
        if self.is_balanced() && matches!(self.solve_balanced(system, h, x, false), Some(Ok(()))) {
            return Ok(());
        }
        let found = self.solve_in_these_units(system, h, x);
        if !found.as_ref().is_err_and(SolveError::is_lost) {
            return found;
        }
        x.copy_from_slice(&self.start);
        match self.solve_balanced(system, h, x, true) {
            Some(Ok(())) => Ok(()),
            _ => found,
        }
    }

    /// The same in the units that the unknowns have. Where no root is found the roundings of F are measured, and what is below them says
    /// nothing: of components in unlike units they are not those of the largest.
    fn solve_in_these_units(&mut self, system: &mut dyn System, h: f64, x: &mut [f64]) -> Result<(), SolveError> {
        self.noise = 0.0;
        self.start.copy_from_slice(x);
        let found = self.solve_above_noise(system, h, x);
        if found.is_ok() && system.is_affine() {
            self.largest = self.largest.max(max_norm(&self.start)).max(max_norm(x));
        }
        if !found.as_ref().is_err_and(SolveError::is_lost) {
            return found;
        }
        x.copy_from_slice(&self.start);
        if system.is_affine() && self.solve_affine(system, h, x) {
            return Ok(());
        }
        let noise = self.measured_noise(system, h, x);
        if !(self.roundoff()..=MOST_NOISE * max_norm(x)).contains(&noise) {
            return found;
        }
        self.noise = noise;
        self.solve_above_noise(system, h, x)
    }

    /// The limit of another system is not known.
    fn forget_limit(&mut self) {
        self.limit.orientation = None;
        self.affine = None;
    }

    /// Replaces `x` by the one root of an affine equation to the roundings of the largest state so far: terms of F that cancel may be as large
    /// still when the solution has decayed, and no iteration contracts below those. False, and `x` as it was, where a second increment is more.
    #[cold]
    fn solve_affine(&mut self, system: &mut dyn System, h: f64, x: &mut [f64]) -> bool {
        let mut size = f64::NAN;
        for _ in 0..2 {
            size = if self.set_increment(system, h, x).is_ok() { max_norm(&self.increment) } else { f64::NAN };
            x.iter_mut().zip(&self.increment).for_each(|(x, increment)| *x -= increment);
        }
        let is_found = size <= ROUNDINGS * f64::EPSILON * self.largest;
        if !is_found {
            x.copy_from_slice(&self.start);
        }
        is_found
    }

    /// The largest of what increments from beside the origin of the branch, a few roundings away, differ by from what they are but for
    /// roundings, several times.
    fn measured_noise(&mut self, system: &mut dyn System, h: f64, x: &[f64]) -> f64 {
        self.origin.copy_from_slice(x);
        system.origin(&mut self.origin);
        let origin = std::mem::take(&mut self.origin);
        let found = self.set_increment(system, h, &origin);
        self.whole.copy_from_slice(&self.increment);
        // Of a singular matrix nothing is told.
        let (mut noise, rounds) = if found.is_ok() { (0.0, ROUNDS) } else { (f64::NAN, 0) };
        for round in 0..rounds {
            for (i, (x, origin)) in self.point.iter_mut().zip(&origin).enumerate() {
                *x = origin * (1.0 + f64::EPSILON * f64::from((7 * i as u32 + 5 * round) % 9) - 4.0 * f64::EPSILON);
            }
            system.residual(h, &self.point, &mut self.part);
            self.work.residuals += 1;
            self.lu.solve(&mut self.part);
            for (((part, whole), x), origin) in self.part.iter().zip(&self.whole).zip(&self.point).zip(&origin) {
                noise = larger(noise, part - whole - (x - origin));
            }
        }
        self.origin = origin;
        f64::from(ROUNDS) * noise
    }

    fn solve_above_noise(&mut self, system: &mut dyn System, h: f64, x: &mut [f64]) -> Result<(), SolveError> {
        debug_assert_eq!(x.len(), system.dim());
        self.guess.copy_from_slice(x);
        self.origin.copy_from_slice(x);
        self.whole_h = h;
        system.origin(&mut self.origin);
        let kind = system.limit();
        let is_fresh =
            kind == LimitAtZero::OfEachStep || (kind == LimitAtZero::Kept && self.limit.orientation.is_none());
        if is_fresh {
            self.set_limit(system, h);
        }
        self.point.copy_from_slice(x);
        let found = match self.iterate(system, h, x, CONTRACTION) {
            Ok(Root::Only) if kind == LimitAtZero::Unknown || self.is_affine(system, h) => return Ok(()),
            found => {
                self.affine = None;
                match found {
                    Ok(Root::Only) if self.guess == self.origin => Err(SolveError::OtherBranch),
                    // A first guess that was the root says nothing of how increments contract.
                    Ok(Root::Only) => Ok(Root::Found { contraction: SURE_CONTRACTION }),
                    found => found,
                }
            }
        };
        let way = difference(x, 1.0, &self.origin);
        match found {
            Ok(Root::Found { .. }) if kind == LimitAtZero::Unknown => return Ok(()),
            Ok(Root::Found { contraction })
                if self.is_in_reach(way, contraction)
                    && self.is_near_branch(system, h, contraction)
                    && self.contracts_on_way_to_guess(system, h) =>
            {
                return Ok(());
            }
            // Beside a rest increments are roundings, which are in no proportion to each other.
            Ok(Root::Found { .. }) if self.is_next_to_origin(system, way) && self.is_affine(system, h) => {
                self.affine = None;
                return Ok(());
            }
            // A matrix that is not what it was declared to be is none for a shorter step either.
            Err(error @ (SolveError::OutsideStructure { .. } | SolveError::NotAssembled)) => return Err(error),
            _ => {}
        }
        if kind == LimitAtZero::Kept && !is_fresh {
            self.set_limit(system, h);
            self.work.factorizations += 1;
        }
        if kind == LimitAtZero::Kept && system.guesses_along_tangent() && !self.guess_is_increment(system, h) {
            self.set_limit_along_guess(system, h);
            self.work.factorizations += 1;
        }
        let first = match found {
            Ok(Root::Found { contraction })
                if (self.is_in_reach(way, contraction) && self.has_short_tangent(system, h)
                    || LOOKS.iter().all(|part| self.is_borne_out(system, (0.0, h), *part, false, x)))
                    && self.is_regular(system, h, contraction)
                    && self.contracts_on_way_to_guess(system, h) =>
            {
                return Ok(());
            }
            Ok(_) => SolveError::OtherBranch,
            Err(error) => error,
        };
        self.follow_branch(system, h, x, first)
    }

    /// Factors ∂F/∂x at the origin for a part of `h` that is next to nothing.
    fn set_limit(&mut self, system: &mut dyn System, h: f64) {
        self.limit.is_along_guess = false;
        self.part.copy_from_slice(&self.origin);
        let short = h * Self::short(system);
        self.factor_limit(system, short);
    }

    /// Factors ∂F/∂x on the way to the first guess for a part of `h` that is little.
    fn set_limit_along_guess(&mut self, system: &mut dyn System, h: f64) {
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
    fn guess_is_increment(&mut self, system: &mut dyn System, h: f64) -> bool {
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
    fn is_in_reach(&self, way: f64, contraction: f64) -> bool {
        contraction <= UNCHANGED || way <= CLOSE * max_norm(&self.origin)
    }

    /// Whether increments contract from the first guesses for h/2, h/4, … too, as far as these leave the origin behind: far from it the equation may
    /// be simple again, on the other side of a fold.
    fn contracts_on_way_to_guess(&mut self, system: &mut dyn System, h: f64) -> bool {
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
    fn is_next_to_origin(&self, system: &dyn System, way: f64) -> bool {
        let is_told = self.limit.is_regular && system.algebraic().is_empty();
        let part = if self.noise > 0.0 { MOST_NOISE } else { f64::EPSILON.sqrt() };
        is_told && way <= part * max_norm(&self.origin)
    }

    /// Whether the tangent of the branch leads no further than that, as far as it is known. Beside a spurious steady state a root is
    /// near that the branch does not come to.
    fn has_short_tangent(&mut self, system: &mut dyn System, h: f64) -> bool {
        if !self.limit.is_regular || !system.algebraic().is_empty() {
            return true;
        }
        let scale = self.set_tangent(system, h);
        scale.abs() * max_norm(&self.part) <= CLOSE * max_norm(&self.origin)
    }

    /// Whether ∂F/∂x is regular at the first guess for all steps up to `h`; `contraction` is the ratio of the second increment
    /// to the first, which is `whole`.
    fn is_regular(&mut self, system: &mut dyn System, h: f64, mut contraction: f64) -> bool {
        let mut s = h;
        for _ in 0..HALVINGS {
            if self.is_near_branch(system, s, contraction) {
                return true;
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
    fn is_near_branch(&mut self, system: &mut dyn System, h: f64, contraction: f64) -> bool {
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
    fn is_along_tangent(&mut self, system: &mut dyn System, h: f64, allowed: f64) -> bool {
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

    /// Whether an equation that two increments tell to be affine is so elsewhere too, to half of the digits: on the tangent of the
    /// branch, or on the way to the root where that lies much further away. Beside a root that the branch may leave on the way to h,
    /// increments are next to nothing. What was found holds for the steps that go on from it, as long as these are alike.
    fn is_affine(&mut self, system: &mut dyn System, h: f64) -> bool {
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
        let size = (scale.abs() * max_norm(&self.part)).max(max_norm(&self.origin)).max(SMALLEST);
        let apart = difference(&self.increment, -scale, &self.part);
        if apart.is_nan() || apart > larger(f64::EPSILON.sqrt() * size, self.noise) {
            return false;
        }
        self.affine = Some((h, moved));
        self.affine_from.copy_from_slice(&self.origin);
        true
    }

    /// Sets the increment at (h, point); false where the derivative is singular, or its determinant has changed its sign.
    fn set_increment_at_point(&mut self, system: &mut dyn System, h: f64) -> bool {
        let point = std::mem::take(&mut self.point);
        let found = self.set_increment(system, h, &point);
        self.point = point;
        found.is_ok() && !self.is_turned()
    }

    /// A few roundings of the present state.
    fn roundoff(&self) -> f64 {
        larger(8.0 * f64::EPSILON * max_norm(&self.origin).max(SMALLEST), self.noise)
    }

    /// Whether the determinant of the matrix that was factored last is known to differ in sign from its limit.
    fn is_turned(&self) -> bool {
        self.limit.orientation == Some(-self.lu.sign())
    }

    /// Follows the branch from its origin in pieces of h, halved where they are not [sure](Self::advance).
    fn follow_branch(
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
    fn crosses_kink(&mut self, system: &mut dyn System, (reached, target): (f64, f64), x: &mut [f64]) -> bool {
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
    fn advance(
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
                (same || tells_affine) && self.is_along_tangent(system, target, if same { 1.0 } else { 2.0 * CLOSE })
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
    fn is_borne_out(
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

    /// Sets the increment of Newton's iteration at (h, x); the derivative there is factored.
    fn set_increment(&mut self, system: &mut dyn System, h: f64, x: &[f64]) -> Result<(), SolveError> {
        self.set_residual(system, h, x);
        self.jacobian.clear();
        system.derivative(h, x, &mut self.jacobian);
        // It may be why the residual is none.
        self.jacobian.check_structure()?;
        if !max_norm(&self.increment).is_finite() {
            return Err(SolveError::NonFinite);
        }
        self.work.factorizations += 1;
        self.lu.factor(&self.jacobian)?;
        self.solve_for_increment()
    }

    fn set_residual(&mut self, system: &mut dyn System, h: f64, x: &[f64]) {
        system.residual(h, x, &mut self.increment);
        self.work.residuals += 1;
        self.residual.copy_from_slice(&self.increment);
    }

    /// Replaces the residual in `increment` by the increment that the matrix factored last makes of it.
    fn solve_for_increment(&mut self) -> Result<(), SolveError> {
        self.lu.solve(&mut self.increment);
        if max_norm(&self.increment).is_finite() { Ok(()) } else { Err(SolveError::NonFinite) }
    }

    /// Newton's iteration from `x`, which must contract from the start.
    pub(crate) fn attempt(&mut self, system: &mut dyn System, h: f64, x: &mut [f64]) -> Result<(), SolveError> {
        self.iterate(system, h, x, CONTRACTION).map(drop)
    }

    /// Newton's iteration from `x`, whose second increment must be at most `first` of the one before, and each further one
    /// at most [`CONTRACTION`]; leaves in `whole` and `first` the first one and its residual.
    ///
    /// It stops on the increment: a residual cancels like ε |q| / h and has no threshold of its own. With the ratio θ of the
    /// last two increments δ, the error left after an increment is at most θ/(1 − θ) δ. Ill-conditioned equations stagnate
    /// above ε |x|, after contraction has reached √ε |x|.
    ///
    /// Where increments contract by θ ≤ [`SURE_CONTRACTION`], the derivative that gave the last one is right to θ² at the next, which is
    /// as good as one by a derivative of its own.
    fn iterate(&mut self, system: &mut dyn System, h: f64, x: &mut [f64], first: f64) -> Result<Root, SolveError> {
        let (mut last, mut ratio, mut turned, mut keeps) = (f64::INFINITY, f64::NAN, false, false);
        for iterations in 1..=ITERATIONS {
            if keeps {
                self.set_residual(system, h, x);
                self.solve_for_increment()?;
            } else {
                self.set_increment(system, h, x)?;
            }
            let delta = max_norm(&self.increment);
            for (x, d) in x.iter_mut().zip(&self.increment) {
                *x -= d;
            }
            if iterations == 1 {
                turned = self.is_turned();
                self.whole.copy_from_slice(&self.increment);
                self.first.copy_from_slice(&self.residual);
            }
            let size = max_norm(x).max(max_norm(&self.origin)).max(SMALLEST);
            let roundoff = larger(f64::EPSILON * size, self.noise);
            let theta = if last.is_finite() { delta / last } else { 1.0 };
            let contraction = if iterations == 2 { first } else { CONTRACTION };
            if iterations == 2 {
                ratio = theta;
            }
            let converged =
                delta <= 4.0 * roundoff || (theta < contraction && theta * delta <= (1.0 - theta) * roundoff);
            // A piece of a continuation may be short because two branches cross there.
            let may_cross = iterations == 2 && first < CONTRACTION;
            let is_small = last <= f64::EPSILON.sqrt() * size && !may_cross;
            if converged || (is_small && theta >= 1.0) {
                let only = iterations == 1 || (iterations == 2 && theta <= f64::EPSILON.sqrt());
                if !only && (turned || self.is_turned()) {
                    return Err(SolveError::OtherBranch);
                }
                return Ok(if only { Root::Only } else { Root::Found { contraction: ratio } });
            }
            if last.is_finite() && theta > contraction && !is_small {
                return Err(SolveError::Diverged { iterations, increment: delta });
            }
            keeps = theta <= SURE_CONTRACTION;
            last = delta;
        }
        Err(SolveError::Diverged { iterations: ITERATIONS, increment: last })
    }
}

/// Whether `b` times `factor` is `a` to within [`CLOSE`], or to within rounding.
fn is_close(a: &[f64], factor: f64, b: &[f64], roundoff: f64) -> bool {
    difference(a, factor, b) <= CLOSE * max_norm(a) + roundoff
}

/// Largest component of `a` − `factor` `b`; NaN if any is NaN.
fn difference(a: &[f64], factor: f64, b: &[f64]) -> f64 {
    let components = a.iter().zip(b).map(|(a, b)| (a - factor * b).abs());
    components.fold(0.0, |m: f64, x| if x > m || x.is_nan() { x } else { m })
}

/// What Newton's iteration converged to.
enum Root {
    /// The start itself, or the one root of an affine equation.
    Only,
    /// A root, with the ratio of the first two increments; the derivative did not change its orientation on the way there.
    Found { contraction: f64 },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_adds_up_count_by_count() {
        let work = |by: u64| Work { steps: by, residuals: 2 * by, factorizations: 3 * by, inner: 4 * by };
        assert_eq!(work(10) + work(3), work(13));
    }

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

    /// At h = 0.1 the second increment is a fortieth of the first. At h = 0.9 the ratios are 0.41, 0.25 and 0.07.
    #[test]
    fn factors_are_kept_once_increments_contract_by_an_eighth() {
        for (h, factorizations) in [(0.1, 2), (0.9, 4)] {
            let mut newton = Newton::new(1);
            newton.solve(&mut Fold, h, &mut [0.0]).expect("on the branch");
            assert_eq!(newton.work.factorizations, factorizations, "h = {h}: {:?}", newton.work);
            assert!(newton.work.residuals > factorizations, "h = {h}: {:?}", newton.work);
        }
    }

    /// Each step is held to its own roundings: one in which none were measured is next to its origin to half of the digits only.
    #[test]
    fn roundings_are_those_of_one_step() {
        let mut newton = Newton::new(1);
        newton.noise = 1e-6;
        newton.solve(&mut Fold, 0.5, &mut [0.0]).expect("on the branch");
        assert_eq!(newton.noise, 0.0);
        (newton.origin[0], newton.limit.is_regular) = (1e3, true);
        let mut near = |noise: f64, way: f64| {
            newton.noise = noise;
            newton.is_next_to_origin(&Fold, way)
        };
        assert_eq!([near(0.0, 1e-5), near(0.0, 1e-4), near(1e-6, 9e-3), near(1e-6, 2e-2)], [true, false, true, false]);
    }

    /// x₀ − 1 − s = 0 and, algebraic, s (x₁ − x₀²) = 0.
    struct OnParabola;

    impl System for OnParabola {
        fn dim(&self) -> usize {
            2
        }
        fn residual(&mut self, s: f64, x: &[f64], out: &mut [f64]) {
            out.copy_from_slice(&[x[0] - 1.0 - s, s * (x[1] - x[0] * x[0])]);
        }
        fn derivative(&mut self, s: f64, x: &[f64], out: &mut Jacobian) {
            [(0, 0, 1.0), (1, 0, -2.0 * s * x[0]), (1, 1, s)].into_iter().for_each(|(i, j, x)| out.add(i, j, x));
        }
        fn limit(&self) -> LimitAtZero {
            LimitAtZero::Kept
        }
        fn algebraic(&self) -> &[usize] {
            &[1]
        }
    }

    /// From (1, 1.5) the increments are h and 1 + 2h − 1.5 for every h, and to the limit as well.
    #[test]
    fn the_limit_makes_the_increments_of_algebraic_equations_that_a_step_makes() {
        let (mut newton, h, start) = (Newton::new(2), 0.125, [1.0, 1.5]);
        newton.origin.copy_from_slice(&start);
        newton.set_limit(&mut OnParabola, h);
        let mut residual = [0.0; 2];
        OnParabola.residual(h, &start, &mut residual);
        newton.limit.solve(&OnParabola, h, &mut residual);
        approx::assert_relative_eq!(residual[..], [-h, 0.5 - 2.0 * h][..], max_relative = 1e-12);
    }

    /// Where the limit is singular no tangent is known, and none where residuals at the origin are roundings.
    #[test]
    fn nothing_is_asked_of_a_tangent_that_is_not_known() {
        fn answers(system: &mut dyn System, start: &[f64], is_regular: bool) -> [bool; 3] {
            let (mut newton, mut x, h) = (Newton::new(start.len()), start.to_vec(), 0.125);
            newton.origin.copy_from_slice(start);
            newton.point.copy_from_slice(start);
            newton.set_limit(system, h);
            newton.iterate(system, h, &mut x, CONTRACTION).map(drop).expect("a root");
            newton.limit.is_regular = is_regular;
            let is_next = newton.is_next_to_origin(system, 0.0);
            [newton.is_affine(system, h), newton.has_short_tangent(system, h), is_next]
        }
        assert_eq!(answers(&mut OnParabola, &[1.0, 1.5], true), [true, true, false]);
        assert_eq!(answers(&mut Fold, &[0.0], false), [true, true, false]);
        assert_eq!(answers(&mut Fold, &[0.0], true), [false, false, true]);
    }

    /// A step of implicit Euler of a damped circuit, q̇ = i/u and i̇ = −1000 (u (q − 5) + i/20), from the charge and the current that it holds.
    struct Circuit {
        unit: f64,
        from: [f64; 2],
    }

    impl System for Circuit {
        fn dim(&self) -> usize {
            2
        }
        fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
            out[0] = x[0] - self.from[0] - h * x[1] / self.unit;
            out[1] = x[1] - self.from[1] + h * 1000.0 * self.unit * (x[0] - 5.0 + x[1] * (0.05 / self.unit));
        }
        fn derivative(&mut self, h: f64, _: &[f64], out: &mut Jacobian) {
            let (charge, current) = (h * 1000.0 * self.unit, 1.0 + h * 50.0);
            [(0, 0, 1.0), (0, 1, -h / self.unit), (1, 0, charge), (1, 1, current)]
                .into_iter()
                .for_each(|(i, j, x)| out.add(i, j, x));
        }
        fn limit(&self) -> LimitAtZero {
            LimitAtZero::Kept
        }
    }

    /// Increments are roundings there, in no proportion to each other: no piece of the step is sure, and hundreds of factorizations tell nothing.
    #[test]
    fn steps_beside_a_rest_are_not_continued_in_pieces() {
        let mut dear = Vec::new();
        for exponent in -8..=8 {
            for h in [0.01, 0.033, 0.2] {
                let unit = 10_f64.powi(exponent);
                let (mut newton, mut circuit) = (Newton::new(2), Circuit { unit, from: [5.0 + 1e-9, 0.0] });
                let mut most = 0;
                for _ in 0..300 {
                    let (before, mut x) = (newton.work.factorizations, circuit.from);
                    newton.solve(&mut circuit, h, &mut x).expect("affine");
                    circuit.from = x;
                    most = most.max(newton.work.factorizations - before);
                }
                if most > 4 {
                    dear.push((exponent, h, most));
                }
            }
        }
        assert!(dear.is_empty(), "{dear:?}");
    }

    /// x − (1 − h) size = 0, of which what increments are off by is `off` on every other call.
    struct Noisy {
        size: f64,
        off: f64,
        is_next: bool,
    }

    impl Noisy {
        /// Off by 1e-9 of 1 on the second call.
        const LITTLE: Self = Self { size: 1.0, off: 1e-9, is_next: false };
    }

    impl System for Noisy {
        fn dim(&self) -> usize {
            1
        }
        fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
            out[0] = x[0] - (1.0 - h) * self.size + if self.is_next { self.off } else { 0.0 };
            self.is_next ^= true;
        }
        fn derivative(&mut self, _: f64, _: &[f64], out: &mut Jacobian) {
            out.add(0, 0, 1.0);
        }
        fn is_affine(&self) -> bool {
            true
        }
    }

    /// The second increment takes back what the first was off by, 2⁻³⁰ of the state. In a piece of a continuation that may be another branch.
    #[test]
    fn increments_below_half_of_the_digits_stagnate_on_roundings_but_in_a_continuation() {
        for size in [1.0, 1048576.0] {
            let stagnates = [CONTRACTION, SURE_CONTRACTION].map(|first| {
                let mut noisy = Noisy { size, off: size / f64::from(1 << 30), is_next: true };
                Newton::new(1).iterate(&mut noisy, 0.5, &mut [0.5 * size], first).is_ok()
            });
            assert_eq!(stagnates, [true, false], "{size}");
        }
    }

    /// They are 2⁻²³ of the state, so that no iteration contracts below half of the digits.
    #[test]
    fn roundings_of_a_few_digits_are_allowed_for_whatever_the_size_of_the_state() {
        for size in [1.0, 1048576.0] {
            let off = size / f64::from(1 << 23);
            let (mut newton, mut x) = (Newton::new(1), [0.5 * size]);
            let found = newton.solve(&mut Noisy { size, off, is_next: true }, 0.5, &mut x);
            assert!(found.is_ok() && newton.noise > 0.0, "{size}: {found:?}");
            approx::assert_abs_diff_eq!(x[0], 0.5 * size, epsilon = off);
        }
    }

    #[test]
    fn a_step_that_failed_says_nothing_of_the_size_of_states() {
        let mut newton = Newton::new(1);
        newton.largest = 0.25;
        let found = newton.solve(&mut Noisy { size: 1.0, off: 1e6, is_next: true }, 0.5, &mut [0.5]);
        assert!(found.is_err() && newton.largest == 0.25, "{found:?}: {}", newton.largest);
        newton.solve(&mut Noisy { size: 1.0, off: 0.0, is_next: true }, 0.5, &mut [0.75]).expect("affine");
        assert_eq!(newton.largest, 0.75);
    }

    /// Four of them add up where an increment has some of each.
    #[test]
    fn roundings_are_measured_with_room_for_several() {
        let noise = Newton::new(1).measured_noise(&mut { Noisy::LITTLE }, 0.5, &[1.0]);
        approx::assert_relative_eq!(noise, 4e-9, max_relative = 1e-6);
    }

    /// Beside 1, and not where x² − h has another slope.
    #[test]
    fn roundings_are_measured_a_few_roundings_away() {
        let mut square = Noted { f: |h: f64, x: f64| (x * x - h, 2.0 * x), notes: Vec::new() };
        let noise = Newton::new(1).measured_noise(&mut square, 0.5, &[1.0]);
        assert!(noise <= f64::from(ROUNDS) * 4.0 * f64::EPSILON, "{noise:e}");
    }

    /// F and its slope, with notes of where F is asked for.
    struct Noted<F> {
        f: F,
        notes: Vec<(f64, f64)>,
    }

    impl<F: Fn(f64, f64) -> (f64, f64)> System for Noted<F> {
        fn dim(&self) -> usize {
            1
        }
        fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
            self.notes.push((h, x[0]));
            out[0] = (self.f)(h, x[0]).0;
        }
        fn derivative(&mut self, h: f64, x: &[f64], out: &mut Jacobian) {
            out.add(0, 0, (self.f)(h, x[0]).1);
        }
        fn limit(&self) -> LimitAtZero {
            LimitAtZero::Kept
        }
    }

    /// Whether increments contract on the way from `origin` to `guess`, a guess for h = 2, where F was asked for, and how often.
    fn on_way(f: impl Fn(f64, f64) -> (f64, f64), (origin, guess): (f64, f64)) -> (bool, Vec<(f64, f64)>, u64) {
        let (mut newton, mut system) = (Newton::new(1), Noted { f, notes: Vec::new() });
        (newton.origin[0], newton.guess[0]) = (origin, guess);
        let contracts = newton.contracts_on_way_to_guess(&mut system, 2.0);
        (contracts, system.notes, newton.work.residuals)
    }

    #[test]
    fn the_way_to_a_guess_is_looked_at_as_far_as_it_leaves_the_origin_behind() {
        // x = 3 + 5h is 8 half-way, where the guess 15 leads to 9, and 5.5 at a quarter, where it leads to 6.
        let line = |h: f64, x: f64| (x - 3.0 - 5.0 * h, 1.0);
        let places = vec![(1.0, 9.0), (1.0, 8.0), (0.5, 6.0), (0.5, 5.5)];
        assert_eq!(on_way(line, (3.0, 15.0)), (true, places, 4));
        assert_eq!(on_way(line, (3.0, 6.0)), (true, vec![], 0));
        // On the branch increments are none.
        assert!(on_way(line, (3.0, 13.0)).0);
    }

    /// From u the increments of u + u² by one derivative are in the ratio u (1 + u²/(1 + 2u))/((1 + 2u)(1 + u)): 0.1224 at u = 0.2, 0.1260 at 0.21.
    #[test]
    fn increments_on_the_way_to_a_guess_contract_by_an_eighth() {
        let square = |_: f64, x: f64| (x + x * x, 1.0 + 2.0 * x);
        assert_eq!([0.4, 0.42].map(|guess| on_way(square, (0.0, guess)).0), [true, false]);
        // The first increment leads to where there is no logarithm.
        assert!(!on_way(|_, x| ((x / 3.0).ln(), x.recip()), (3.0, 15.0)).0);
        // A derivative that vanishes gives none.
        assert!(!on_way(|_, x| (x, 0.0), (3.0, 15.0)).0);
    }

    /// x = 100 + h to eight digits of the way, not of x.
    #[test]
    fn a_guess_is_the_increment_to_half_of_its_own_digits() {
        let near = |off: f64| {
            let (mut newton, h) = (Newton::new(1), 1.0);
            let mut line = Noted { f: |h: f64, x: f64| (x - 100.0 - h, 1.0), notes: Vec::new() };
            (newton.origin[0], newton.guess[0]) = (100.0, 100.0 + h + off);
            newton.set_limit(&mut line, h);
            newton.guess_is_increment(&mut line, h)
        };
        assert_eq!([0.0, 1e-9, -1e-9, 1e-6, -1e-6].map(near), [true, true, true, false, false]);
    }

    /// Whether F is found to be affine at h = 1, from `origin`, where the first guess is the origin.
    fn is_affine_from(origin: f64, f: impl Fn(f64, f64) -> (f64, f64)) -> bool {
        let (mut newton, mut system, mut x) = (Newton::new(1), Noted { f, notes: Vec::new() }, [origin]);
        (newton.origin[0], newton.point[0]) = (origin, origin);
        newton.set_limit(&mut system, 1.0);
        newton.iterate(&mut system, 1.0, &mut x, CONTRACTION).map(drop).expect("a root");
        newton.is_affine(&mut system, 1.0)
    }

    /// y − h + max(y − k h, 0) = 0 for y = x − 10. Beyond the root at y = h nobody comes.
    #[test]
    fn an_equation_is_asked_whether_it_is_affine_on_the_way_to_its_root() {
        let kinked = |k: f64| {
            is_affine_from(10.0, |h, x| {
                let over = x - 10.0 - k * h;
                (x - 10.0 - h + over.max(0.0), if over > 0.0 { 2.0 } else { 1.0 })
            })
        };
        assert_eq!([1.3, 0.3].map(kinked), [true, false]);
    }

    /// y − h + c y² = 0 for y = x − 1000. By the derivative at the root, 1 + 2c, the increment to 0.618 is off by c (2 · 0.618 − 0.618²) = 0.854 c;
    /// √ε of the state is 1.5e-5.
    #[test]
    fn an_equation_is_affine_to_half_of_the_digits_of_the_state() {
        let bent = |c: f64| {
            is_affine_from(1e3, |h, x| {
                let y = x - 1e3;
                (y - h + c * y * y, 1.0 + 2.0 * c * y)
            })
        };
        assert_eq!([1.5e-5, 2e-5].map(bent), [true, false]);
    }

    /// A(s) (x − 1) = b s with A = 1 − 3.2 s (1 − s) (3 − 4s), which is 1 at s = 0 and at s = 1, but 0.2 half-way and −0.2 at 0.3. What of the
    /// increments is lost in roundings of x tells nothing.
    #[test]
    fn a_derivative_that_changes_half_way_is_not_regular_for_being_small() {
        let is_regular = |b: f64| {
            let a = |s: f64| 1.0 - 3.2 * s * (1.0 - s) * (3.0 - 4.0 * s);
            let mut system = Noted { f: |s: f64, x: f64| (a(s) * (x - 1.0) - b * s, a(s)), notes: Vec::new() };
            let (mut newton, mut x) = (Newton::new(1), [1.0]);
            (newton.origin[0], newton.point[0], newton.guess[0]) = (1.0, 1.0, 1.0);
            newton.set_limit(&mut system, 1.0);
            newton.iterate(&mut system, 1.0, &mut x, CONTRACTION).map(drop).expect("affine");
            newton.is_regular(&mut system, 1.0, 2.0 * SURE_CONTRACTION)
        };
        assert_eq!([0.05, f64::EPSILON].map(is_regular), [false, true]);
    }

    /// (1 + 4s) (x − s) = 0 from s = ¼ on, and before x − b s = 0.
    fn from_a_quarter_on(b: f64) -> Noted<impl Fn(f64, f64) -> (f64, f64)> {
        let f =
            move |s: f64, x: f64| if s < 0.25 { (x - b * s, 1.0) } else { ((1.0 + 4.0 * s) * (x - s), 1.0 + 4.0 * s) };
        Noted { f, notes: Vec::new() }
    }

    #[test]
    fn increments_in_proportion_to_the_way_tell_where_the_branch_starts_along_them() {
        let is_told = [1.2, -1.0].map(|b| {
            let (mut newton, mut system) = (Newton::new(1), from_a_quarter_on(b));
            newton.set_limit(&mut system, 1.0);
            newton.advance(&mut system, (0.0, 1.0), true, &mut [0.0]).is_ok()
        });
        assert_eq!(is_told, [true, false]);
    }

    #[test]
    fn every_evaluation_of_a_look_is_counted() {
        let (mut newton, mut system, mut x) = (Newton::new(1), from_a_quarter_on(1.0), [0.0]);
        newton.iterate(&mut system, 1.0, &mut x, SURE_CONTRACTION).map(drop).expect("affine");
        let before = (newton.work.residuals, system.notes.len());
        assert!(newton.is_borne_out(&mut system, (0.0, 1.0), LOOKS[0], true, &x));
        assert_eq!(newton.work.residuals - before.0, (system.notes.len() - before.1) as u64);
    }

    #[test]
    fn an_increment_is_one_where_the_derivative_is_regular_and_has_kept_its_sign() {
        let is_one = |slope: f64| {
            let mut newton = Newton::new(1);
            newton.limit.orientation = Some(1.0);
            newton.set_increment_at_point(&mut Noted { f: |_, x| (x, slope), notes: Vec::new() }, 1.0)
        };
        assert_eq!([2.0, 0.0, -2.0].map(is_one), [true, false, false]);
    }

    /// Whether the branch x = s − ½ from s = 0 is found to go on behind a kink at s = ½, where kx + cx² = s − ½; the root, and the one by the formula.
    fn behind_kink(k: f64, c: f64) -> (bool, f64, f64) {
        behind_kink_at(0.0, k, c)
    }

    /// The same of x − `offset`.
    fn behind_kink_at(offset: f64, k: f64, c: f64) -> (bool, f64, f64) {
        let f = |s: f64, x: f64| {
            let x = x - offset;
            if x < 0.0 { (x - (s - 0.5), 1.0) } else { ((k + c * x) * x - (s - 0.5), k + 2.0 * c * x) }
        };
        let (mut newton, mut x) = (Newton::new(1), [f64::NAN]);
        let (reached, target) = (0.5 * (1.0 - 1e-9), 0.5 * (1.0 + 5e-9));
        (newton.start[0], newton.origin[0]) = (offset - 0.5, offset + reached - 0.5);
        let crosses = newton.crosses_kink(&mut Noted { f, notes: Vec::new() }, (reached, target), &mut x);
        let beyond = target - 0.5;
        (crosses, x[0] - offset, 2.0 * beyond / (k + (k * k + 4.0 * c * beyond).sqrt()))
    }

    /// Behind the kink the branch has 1/k times the slope; for k < 0 it turns back. A way of 6e-3 of the branch is too far for what is 6e-9 of the step.
    #[test]
    fn a_kink_is_crossed_to_the_root_behind_it_where_the_branch_is_straight() {
        // What the branch bends by on that way is c (s − ½)/k² of it: 1e-3 of it do where 1e-2 do not.
        for (k, c, expected) in [
            (8.0, 0.0, true),
            (0.125, 0.0, true),
            (0.125, 3e3, true),
            (0.125, 3e4, false),
            (2e-6, 0.0, true),
            (4e-7, 0.0, false),
            (-2.0, 0.0, false),
        ] {
            let (crosses, found, root) = behind_kink(k, c);
            assert_eq!(crosses, expected, "{k}, {c}: {found:e} for {root:e}");
            assert!(!crosses || (found - root).abs() <= 1e-12 * root, "{k}, {c}: {found:e} for {root:e}");
        }
    }

    /// A rounding of 2¹⁷ is a hundredth of the way across.
    #[test]
    fn a_kink_is_crossed_where_the_branch_is_straight_but_for_roundings() {
        let (offset, k) = (131072.0, 0.125);
        let (crosses, found, root) = behind_kink_at(offset, k, 0.0);
        assert!(crosses && (found - root).abs() <= 2.0 * f64::EPSILON * offset, "{found:e} for {root:e}");
    }

    /// The second increments of a noisy equation are 1e-9, eight roundings of 6e5.
    #[test]
    fn an_affine_equation_is_solved_to_the_roundings_of_the_largest_state() {
        for (largest, expected) in [(1.0, false), (5e5, false), (6e5, true)] {
            let (mut newton, mut x) = (Newton::new(1), [0.25]);
            (newton.start[0], newton.largest) = (0.25, largest);
            assert_eq!(newton.solve_affine(&mut { Noisy::LITTLE }, 0.5, &mut x), expected, "{largest}");
            approx::assert_abs_diff_eq!(x[0], if expected { 0.5 } else { 0.25 }, epsilon = 2e-9);
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
        assert!(newton.work.residuals <= u64::from(PIECES * (ITERATIONS + 2)));
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

    /// A(s) x − s (1 − 2s) − x²/10 = 0, A = 1 − 8 s (1 − s): singular at s = 0.146, and at s = 1 what it is at 0. The branch, which
    /// starts in the direction of growing x, folds on the way; Newton's iteration at s = 1 finds a root at x < 0.
    struct Turning;

    impl System for Turning {
        fn dim(&self) -> usize {
            1
        }
        fn residual(&mut self, s: f64, x: &[f64], out: &mut [f64]) {
            out[0] = (1.0 - 8.0 * s * (1.0 - s)) * x[0] - s * (1.0 - 2.0 * s) - 0.1 * x[0] * x[0];
        }
        fn derivative(&mut self, s: f64, x: &[f64], out: &mut Jacobian) {
            out.add(0, 0, 1.0 - 8.0 * s * (1.0 - s) - 0.2 * x[0]);
        }
        fn limit(&self) -> LimitAtZero {
            LimitAtZero::Kept
        }
    }

    #[test]
    fn a_root_away_from_the_tangent_is_not_on_the_branch_although_the_derivative_is_near_its_limit() {
        let mut x = [0.0];
        let found = Newton::new(1).solve(&mut Turning, 1.0, &mut x);
        let is_refused = matches!(found, Err(SolveError::OtherBranch | SolveError::BranchLost { .. }));
        assert!(is_refused, "{found:?} at {x:?}");
    }

    /// x − s² + 20 s x² (x − 1) = 0: the branch leaves x = 0 without a slope and folds at s = 0.2423743. At s = 1 the first increment leads
    /// to the root x = 1, and the second is zero, as those of an affine equation are.
    struct Coincidence;

    impl System for Coincidence {
        fn dim(&self) -> usize {
            1
        }
        fn residual(&mut self, s: f64, x: &[f64], out: &mut [f64]) {
            out[0] = x[0] - s * s + 20.0 * s * x[0] * x[0] * (x[0] - 1.0);
        }
        fn derivative(&mut self, s: f64, x: &[f64], out: &mut Jacobian) {
            out.add(0, 0, 1.0 + 20.0 * s * x[0] * (3.0 * x[0] - 2.0));
        }
        fn limit(&self) -> LimitAtZero {
            LimitAtZero::Kept
        }
    }

    #[test]
    fn an_equation_is_not_affine_for_a_second_increment_that_vanishes() {
        let mut x = [0.0];
        let found = Newton::new(1).solve(&mut Coincidence, 1.0, &mut x);
        let is_lost = matches!(found, Err(SolveError::BranchLost { reached }) if (reached - 0.242_374_3).abs() < 1e-6);
        assert!(is_lost, "{found:?} at {x:?}");
    }

    /// y − s (3 − s)/2 + 100 s y² (y − 1) = 0 for y = x − 10: the branch folds at s = 0.0442686, and the root y = 1 at s = 1, to which the
    /// first increment leads, lies within a tenth of the state and a third of the tangent.
    struct NearCoincidence;

    impl System for NearCoincidence {
        fn dim(&self) -> usize {
            1
        }
        fn residual(&mut self, s: f64, x: &[f64], out: &mut [f64]) {
            let y = x[0] - 10.0;
            out[0] = y - 0.5 * s * (3.0 - s) + 100.0 * s * y * y * (y - 1.0);
        }
        fn derivative(&mut self, s: f64, x: &[f64], out: &mut Jacobian) {
            let y = x[0] - 10.0;
            out.add(0, 0, 1.0 + 100.0 * s * y * (3.0 * y - 2.0));
        }
        fn limit(&self) -> LimitAtZero {
            LimitAtZero::Kept
        }
    }

    #[test]
    fn a_root_close_to_the_state_is_not_taken_for_a_second_increment_that_vanishes() {
        let mut x = [10.0];
        let found = Newton::new(1).solve(&mut NearCoincidence, 1.0, &mut x);
        let is_lost = matches!(found, Err(SolveError::BranchLost { reached }) if (reached - 0.044_268_6).abs() < 1e-6);
        assert!(is_lost, "{found:?} at {x:?}");
    }

    /// y − s (1 + 100 y² (y − 1)²) = 0, as implicit Euler steps on v̇ = 1 + 100 v² (v − 1)² from 0: the tangent of the branch leads to the root
    /// y = 1 at s = 1 as well, where the derivative is the same, and the branch folds at s = 0.0571571.
    struct TangentCoincidence;

    impl System for TangentCoincidence {
        fn dim(&self) -> usize {
            1
        }
        fn residual(&mut self, s: f64, y: &[f64], out: &mut [f64]) {
            out[0] = y[0] - s * (1.0 + 100.0 * (y[0] * (y[0] - 1.0)).powi(2));
        }
        fn derivative(&mut self, s: f64, y: &[f64], out: &mut Jacobian) {
            out.add(0, 0, 1.0 - 200.0 * s * y[0] * (y[0] - 1.0) * (2.0 * y[0] - 1.0));
        }
        fn limit(&self) -> LimitAtZero {
            LimitAtZero::Kept
        }
    }

    #[test]
    fn a_root_to_which_the_tangent_leads_is_not_on_the_branch_for_that() {
        let mut y = [0.0];
        let found = Newton::new(1).solve(&mut TangentCoincidence, 1.0, &mut y);
        assert!(
            matches!(found, Err(SolveError::BranchLost { reached }) if (reached - 0.057_157_1).abs() < 1e-6),
            "{found:?} at {y:?}"
        );
    }

    /// x − s − x²/100 = 0 and (1 − 8 s (1 − s)) y = 0: at s = 1 the derivative is nearly what it is at 0, along x on the whole way, but round
    /// s = ½ its determinant is negative; where that vanishes every y is a root.
    struct Crossed;

    impl System for Crossed {
        fn dim(&self) -> usize {
            2
        }
        fn residual(&mut self, s: f64, x: &[f64], out: &mut [f64]) {
            out[0] = x[0] - s - 0.01 * x[0] * x[0];
            out[1] = (1.0 - 8.0 * s * (1.0 - s)) * x[1];
        }
        fn derivative(&mut self, s: f64, x: &[f64], out: &mut Jacobian) {
            out.add(0, 0, 1.0 - 0.02 * x[0]);
            out.add(1, 1, 1.0 - 8.0 * s * (1.0 - s));
        }
        fn limit(&self) -> LimitAtZero {
            LimitAtZero::Kept
        }
    }

    #[test]
    fn a_determinant_that_is_negative_half_way_across_the_tangent_is_not_passed_over() {
        let mut x = [0.0; 2];
        let found = Newton::new(2).solve(&mut Crossed, 1.0, &mut x);
        assert!(matches!(found, Err(SolveError::BranchLost { .. } | SolveError::OtherBranch)), "{found:?} at {x:?}");
    }
}
