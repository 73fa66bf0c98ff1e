//! The zeros of a function along a trajectory.

use super::Trajectory;
use crate::error::{InputError, StepError, SystemError};
use crate::integrator::{Integrator, State};
use crate::linalg::larger;

/// Which zeros of a function count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Crossing {
    /// From negative values to positive ones.
    Rising,
    /// From positive values to negative ones.
    Falling,
    /// Both.
    Any,
}

impl Crossing {
    /// Whether it counts that g changes from `left` to `right`.
    fn counts(self, left: f64, right: f64) -> bool {
        let (rises, falls) = (left < 0.0 && right >= 0.0, left > 0.0 && right <= 0.0);
        match self {
            Self::Rising => rises,
            Self::Falling => falls,
            Self::Any => rises || falls,
        }
    }
}

/// How far [`Trajectory::until`] has looked on the dense output, and the event that it found last, with its time, or the start of the run.
#[derive(Debug)]
pub(super) struct Search {
    reached: f64,
    last: f64,
    event: State,
}

impl Search {
    pub(super) fn new(initial: &State) -> Self {
        Self { reached: initial.t, last: initial.t, event: initial.clone() }
    }
}

/// Parts of a step between which a change of sign is looked for.
const PARTS: u32 = 4;
/// Halvings of the first part of a search: down to √ε of it, where g is above its rounding again.
const HALVINGS: i32 = 26;
/// Shorter steps to the zero, each of which squares or so what is left.
const CORRECTIONS: u32 = 8;
/// A correction of so many roundings of the time at most is none, where it makes g no smaller.
const ROUNDINGS: f64 = 64.0;
/// Halvings of the step at which the nearest places are looked at for a change of sign.
const NEAREST: i32 = 6;

/// How many times larger than around it g is beside a pole, and how many times smaller beside a zero.
const POLE: f64 = 1e3;

/// What g does where its sign changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Change {
    Zero,
    Jump,
    Pole,
}

impl<I: Integrator> Trajectory<I> {
    /// Runs until g(t, q) crosses zero, and lends the state there; `None` if it does not before t_end. The next call goes on
    /// from there, so that all crossings of a run can be visited, or a terminal one be the last.
    ///
    /// # Accuracy
    /// The state of a one-step method, variational or not, is that of a shorter step from the start of the step that contains
    /// the crossing, t such that g is zero for it: t, q and p have the order of the method, and constraints hold. A few such
    /// steps are taken, which its [`work`](Self::work) counts; more of them where the dense output is far off. Events follow each other in time. [`Radau`](crate::adaptive::Radau),
    /// [`Bdf2`](crate::classic::Bdf2) and [`Window`](crate::Window), whose steps depend on more than a state, give the dense
    /// output, and momenta linear between the ends of the step: the adaptive method does **not** hold its tolerance
    /// there (see [`sample`](Self::sample)). An error of the path is one of t divided by |dg/dt|.
    ///
    /// # What is not seen
    /// A change of sign is looked for on the dense output between the quarters of a step, from the start of each call between
    /// points that are twice as far away each time: two crossings within one of these parts are not seen. The dense output is a cubic, off by up to (hω)⁴/384 of
    /// an oscillation of frequency ω: in steps of half a turn two crossings that are nearly two parts apart may not be seen either, and in longer ones any
    /// two; of an odd number in a step, one at least is. A zero where a call
    /// starts, or within 2⁻²⁶ of a quarter step from there, does not count, nor one at the end of the run, beyond which g has no sign; one that follows does,
    /// unless it is within 64 roundings of t, 1.4·10⁻¹⁴ |t|, of the one before. A jump of g from one sign to the
    /// other counts, a pole between the points that are looked at does not. Where g only touches zero, as at the start on a section that the path is tangent to, rounding
    /// decides.
    ///
    /// Of several positive functions the first that falls to zero is that whose zero their minimum has; one call after the other would pass over
    /// simultaneous ones. A ball that loses half of its speed bounces without end in a finite time: flights that no step resolves have no zero.
    ///
    /// # A ball that bounces
    /// ```
    /// use lsvi::{AutoLagrangian, Crossing, LagrangianFn, Scalar, State, Trajectory};
    /// use lsvi::{discrete::Trapezoidal, position_momentum};
    ///
    /// /// L = ½ q̇² − 9.81 q.
    /// struct Ball;
    /// impl LagrangianFn for Ball {
    ///     fn dim(&self) -> usize { 1 }
    ///     fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T { v[0] * v[0] * 0.5 - q[0] * 9.81 }
    /// }
    /// let mut method = position_momentum(Trapezoidal::new(AutoLagrangian::new(Ball)));
    /// let mut state = State::new(0.0, vec![1.0]);
    /// for _impact in 0..5 {
    ///     let mut flight = Trajectory::new(&mut method, state, 0.1, 10.0)?;
    ///     state = flight.until(|_, q| q[0], Crossing::Falling)?.expect("it lands").clone();
    ///     state.p[0] *= -0.5;
    /// }
    /// // A flight takes 2 |p|/9.81, half of the one before.
    /// let fall = (2.0 / 9.81_f64).sqrt();
    /// assert!((state.t - fall * (1.0 + 1.0 + 0.5 + 0.25 + 0.125)).abs() < 1e-12);
    /// # Ok::<(), lsvi::StepError>(())
    /// ```
    ///
    /// # A Poincaré section
    /// ```
    /// use lsvi::{AutoLagrangian, Crossing, LagrangianFn, Scalar, State, Trajectory};
    /// use lsvi::{discrete::Galerkin, position_momentum};
    ///
    /// /// The Hénon–Heiles system.
    /// struct Stars;
    /// impl LagrangianFn for Stars {
    ///     fn dim(&self) -> usize { 2 }
    ///     fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
    ///         let [x, y] = [q[0], q[1]];
    ///         (v[0] * v[0] + v[1] * v[1] - x * x - y * y) * 0.5 - x * x * y + y * y * y / 3.0
    ///     }
    /// }
    /// let method = position_momentum(Galerkin::gauss(AutoLagrangian::new(Stars), 4)?);
    /// let start = State::new(0.0, vec![0.0, 0.1]).with_momentum(vec![0.4, 0.1]);
    /// let mut run = Trajectory::new(method, start, 0.25, 100.0)?;
    /// let mut section = Vec::new();
    /// while let Some(point) = run.until(|_, q| q[0], Crossing::Rising)? {
    ///     section.push((point.q[1], point.p[1]));
    /// }
    /// assert!(section.len() > 10);
    /// # Ok::<(), lsvi::StepError>(())
    /// ```
    ///
    /// # Errors
    /// [`StepError`] as for [`step`](Self::step) and [`interpolate`](Self::interpolate); [`SystemError::NonFinite`] if g is
    /// not finite.
    pub fn until(
        &mut self,
        mut g: impl FnMut(f64, &[f64]) -> f64,
        crossing: Crossing,
    ) -> Result<Option<&State>, StepError> {
        let mut is_start = true;
        loop {
            while self.search.reached >= self.state.t {
                if self.step()?.is_none() {
                    return Ok(None);
                }
            }
            let start = self.search.reached.max(self.before.t);
            let length = self.state.t - start;
            let mut left = (start, self.value(start, &mut g)?);
            let halvings = if is_start { HALVINGS } else { 0 };
            let near = (1..=halvings).rev().map(|k| 0.5_f64.powi(k) / f64::from(PARTS));
            for part in near.chain((1..=PARTS).map(|k| f64::from(k) / f64::from(PARTS))) {
                let t = if part == 1.0 { self.state.t } else { start + length * part };
                let right = (t, self.value(t, &mut g)?);
                // What g has at the start itself may be rounding.
                if !std::mem::take(&mut is_start) && crossing.counts(left.1, right.1) {
                    let (t, change) = self.bisect(left, right, &mut g)?;
                    if change == Change::Pole {
                        left = right;
                        continue;
                    }
                    let lower = start.max(self.search.last);
                    if self.settle(t, change, (lower, left.1.signum()), &mut g)? {
                        // Beyond the zero, where g has its new sign.
                        self.search.reached = t.next_up();
                        self.search.last = self.search.event.t;
                        return Ok(Some(&self.search.event));
                    }
                }
                left = right;
            }
            self.search.reached = self.state.t;
        }
    }

    /// g at a time of the last step, and the path there in `point`.
    fn value(&mut self, t: f64, g: &mut impl FnMut(f64, &[f64]) -> f64) -> Result<f64, StepError> {
        check_value(self.unchecked(t, g)?)
    }

    /// The same, finite or not.
    fn unchecked(&mut self, t: f64, g: &mut impl FnMut(f64, &[f64]) -> f64) -> Result<f64, StepError> {
        let mut point = std::mem::take(&mut self.point);
        let written = self.interpolate(t, &mut point);
        self.point = point;
        written?;
        Ok(g(t, &self.point))
    }

    /// The first time in (left, right] where g no longer has the sign that it has at the left, by bisection to the spacing of
    /// numbers: some 50 evaluations of a cubic, whatever g is. With what
    /// happens there, by the size of g on both sides beside that at the ends.
    fn bisect(
        &mut self,
        mut left: (f64, f64),
        mut right: (f64, f64),
        g: &mut impl FnMut(f64, &[f64]) -> f64,
    ) -> Result<(f64, Change), StepError> {
        let (sign, largest) = (left.1.signum(), larger(left.1.abs(), right.1));
        loop {
            let middle = left.0 + 0.5 * (right.0 - left.0);
            if middle <= left.0 || middle >= right.0 {
                let [less, more] =
                    [left.1.abs().min(right.1.abs()), larger(left.1.abs(), right.1)].map(|g| g / largest);
                let change = match () {
                    () if less > POLE => Change::Pole,
                    () if more > POLE.recip() => Change::Jump,
                    () => Change::Zero,
                };
                return Ok((right.0, change));
            }
            let value = self.unchecked(middle, g)?;
            if value.is_infinite() {
                return Ok((middle, Change::Pole));
            }
            let value = check_value(value)?;
            *(if value * sign > 0.0 { &mut left } else { &mut right }) = (middle, value);
        }
    }

    /// Sets the event to the state near `t`, a zero of g on the dense output before which g has this sign: where the method takes shorter steps, to
    /// the one beyond `lower` for which g is zero, or at a jump to the one at `t`. False where these know of no such zero in the step.
    fn settle(
        &mut self,
        t: f64,
        change: Change,
        (lower, sign): (f64, f64),
        g: &mut impl FnMut(f64, &[f64]) -> f64,
    ) -> Result<bool, StepError> {
        let (from, to) = (self.before.t, self.state.t);
        let Some(error) = self.shorter_step(t, g)? else {
            let end = self.value(t, g).map(|_| (t - from) / (to - from))?;
            let Self { search: Search { event, .. }, before, state, point, .. } = self;
            event.t = t;
            event.q.copy_from_slice(point);
            for ((p, before), after) in event.p.iter_mut().zip(&before.p).zip(&state.p) {
                *p = before + end * (after - before);
            }
            return Ok(true);
        };
        Ok(change == Change::Jump
            || self.settle_by_secants((t, error), (lower, sign), g)?
            || self.settle_between(t.max(lower), (lower, sign), g)?)
    }

    /// By the secant method from a slope of the dense output; false where that does not converge, or to no crossing like the one asked for.
    fn settle_by_secants(
        &mut self,
        (mut now, mut error): (f64, f64),
        (lower, sign): (f64, f64),
        g: &mut impl FnMut(f64, &[f64]) -> f64,
    ) -> Result<bool, StepError> {
        let (from, to) = (self.before.t, self.state.t);
        let reach = 1e-3 * (to - from);
        let (low, high) = ((now - reach).max(from), (now + reach).min(to));
        let mut slope = (self.value(high, g)? - self.value(low, g)?) / (high - low);
        let mut correction = f64::INFINITY;
        for _ in 0..CORRECTIONS {
            correction = error / slope;
            let next = (now - correction).clamp(from, to);
            let moved = next - now;
            if error == 0.0 || moved.is_nan() || moved.abs() <= 2.0 * f64::EPSILON * now.abs() {
                break;
            }
            let Some(other) = self.shorter_step(next, g)? else { break };
            if other.abs() >= error.abs() {
                // Rounding, or a g that is not smooth: the one before was better.
                self.shorter_step(now, g)?;
                break;
            }
            (slope, now, error) = ((other - error) / moved, next, other);
        }
        let is_found = error == 0.0 || correction.abs() <= ROUNDINGS * f64::EPSILON * now.abs();
        Ok(is_found && slope * sign <= 0.0 && self.is_beyond(lower, now))
    }

    /// Between the nearest places, beyond `lower`, where g has one sign and the other.
    fn settle_between(
        &mut self,
        t: f64,
        (lower, sign): (f64, f64),
        g: &mut impl FnMut(f64, &[f64]) -> f64,
    ) -> Result<bool, StepError> {
        let (from, to) = (self.before.t, self.state.t);
        let Some(here) = self.shorter_step(t, g)? else { return Ok(false) };
        // At the event before g is zero but for roundings.
        let is_before = here * sign > 0.0 || !self.is_beyond(lower, t);
        let (mut near, mut far) = ((t, here), None);
        for k in (0..=NEAREST).rev() {
            let way = (to - from) * 0.5_f64.powi(k);
            let next = if is_before { (t + way).min(to) } else { (t - way).max(lower) };
            if next == near.0 || !self.is_beyond(lower, next) {
                break;
            }
            let Some(there) = self.shorter_step(next, g)? else { return Ok(false) };
            if (there * sign > 0.0) != is_before {
                far = Some((next, there));
                break;
            }
            near = (next, there);
        }
        let Some(mut far) = far else { return Ok(false) };
        // Bisection to a rounding of the end of the step.
        let rounding = f64::EPSILON * from.abs().max(to.abs());
        while (far.0 - near.0).abs() > rounding {
            let middle = near.0 + 0.5 * (far.0 - near.0);
            if middle == near.0 || middle == far.0 {
                break;
            }
            let Some(there) = self.shorter_step(middle, g)? else { return Ok(false) };
            *(if (there * sign > 0.0) == is_before { &mut near } else { &mut far }) = (middle, there);
        }
        let best = if near.1.abs() < far.1.abs() { near.0 } else { far.0 };
        Ok(self.is_beyond(lower, best) && self.shorter_step(best, g)?.is_some())
    }

    /// Whether `t` is another time than `lower` if that is the event before, or the start of the run.
    fn is_beyond(&self, lower: f64, t: f64) -> bool {
        lower != self.search.last || t - lower > ROUNDINGS * f64::EPSILON * t.abs()
    }

    /// Sets the event to the state that a shorter step leads to, and returns g there; `None` if the method takes none.
    fn shorter_step(&mut self, t: f64, g: &mut impl FnMut(f64, &[f64]) -> f64) -> Result<Option<f64>, StepError> {
        let Self { integrator, before, state, search: Search { event, .. }, .. } = self;
        // A step of a few roundings has no digits.
        let least = 8.0 * f64::EPSILON * before.t.abs().max(state.t.abs());
        if t == state.t {
            event.clone_from(state);
        } else if t - before.t <= least {
            event.clone_from(before);
        } else {
            match integrator.shorter_step(before, t, event) {
                None => return Ok(None),
                Some(taken) => taken?,
            }
        }
        check_value(g(event.t, &event.q)).map(Some)
    }
}

fn check_value(value: f64) -> Result<f64, StepError> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(InputError::System(SystemError::NonFinite { what: "g", index: 0, value }).into())
    }
}
