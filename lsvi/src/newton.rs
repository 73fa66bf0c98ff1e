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

mod continuation;
mod kept;
mod limit;
mod rounding;
#[cfg(test)]
mod tests;
mod trace;
mod units;

use std::ops::Add;

use auto_impl::auto_impl;
use kept::Kept;
use limit::Limit;
pub(crate) use rounding::{Rounding, SAMPLES};
use units::Balanced;
pub(crate) use units::are_unlike;

use crate::error::SolveError;
use crate::linalg::{Jacobian, Lu, Structure, larger, max_norm};

/// Required ratio of successive increments: Newton–Kantorovich gives uniqueness for quadratic contraction from ½.
const CONTRACTION: f64 = 0.5;
/// Ratio of the first two increments up to which the derivative, with quadratic contraction, changes by no more than a quarter
/// on the way, so that no second root is as near as the first.
pub(crate) const SURE_CONTRACTION: f64 = 0.125;
/// Iterations of one attempt: as many as linear contraction by [`CONTRACTION`] needs to reach roundoff.
const ITERATIONS: u32 = 60;
/// Largest relative difference of two increments by derivatives that count as close.
pub(crate) const CLOSE: f64 = 0.25;
/// Parts of a long way at which the branch is looked at; what is found at the first says little of a fold near the root.
const LOOKS: [f64; 2] = [0.5, 0.75];
/// The least size of a state whose roundings are a part ε of it: doubles below [`f64::MIN_POSITIVE`] lose their digits.
const SMALLEST: f64 = f64::MIN_POSITIVE / f64::EPSILON;
/// Roundings of F are measured so many times. They may be this part of the state at most: where an ill-conditioned derivative makes more of
/// them, as beside a fold, its least singular value is ε over that, and two roots there are as far apart, ten digits.
const ROUNDS: u32 = 4;
const MOST_NOISE: f64 = 1e-5;
/// The second increment of an affine equation is so many roundings at most, of the largest state so far.
const ROUNDINGS: f64 = 8.0;

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

/// Work space and counters of the iteration; nothing is allocated after `new` but what increments that do not vanish take once.
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
    rounding: Rounding,
    /// Three points of a branch that is followed back.
    traced: [Vec<f64>; 3],
    pub(crate) work: Work,
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
            rounding: Rounding::default(),
            traced: Default::default(),
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
                *x = origin * (1.0 + roundings(i, round));
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
            let is_at_rounding = is_small && theta >= 1.0;
            if is_at_rounding && !converged {
                self.work.residuals += SAMPLES;
                if !self.rounding.explains(&mut |x, out| system.residual(h, x, out), x, &self.increment, last) {
                    return Err(SolveError::Diverged { iterations, increment: delta });
                }
            }
            if converged || is_at_rounding {
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

/// From −4 to 4 roundings, others for each component in each round.
fn roundings(component: usize, round: u32) -> f64 {
    f64::EPSILON * (f64::from((7 * component as u32 + 5 * round) % 9) - 4.0)
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
