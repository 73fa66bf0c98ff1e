//! An integration under way, and the solution between its steps.

mod event;

pub use event::Crossing;

use event::Search;

use crate::error::{InputError, StepError, SystemError, TimeError};
use crate::integrator::{Grid, Integrator, State};
use crate::newton::Work;

/// An integration under way; each [`step`](Self::step) lends the next state, without allocation.
///
/// ```
/// # use lsvi::{AutoField, FieldFn, Scalar, State, Trajectory, method_i};
/// # struct Decay;
/// # impl FieldFn for Decay {
/// #     fn dim(&self) -> usize { 1 }
/// #     fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) { dv[0] = -v[0]; }
/// # }
/// let mut method = method_i(AutoField::new(Decay))?;
/// let mut trajectory = Trajectory::new(&mut method, State::new(0.0, vec![1.0]), 0.1, 1.0)?;
/// while let Some(state) = trajectory.step()? {
///     println!("{:.1} {:.6}", state.t, state.q[0]);
/// }
/// # Ok::<(), lsvi::StepError>(())
/// ```
///
/// # Between the steps
/// Every method of the library has a dense output on its last step. [`adaptive::Radau`](crate::adaptive::Radau) has one of
/// its own, the collocation polynomial, of order s + 1. Otherwise it is the cubic q(t) with the values and the rates q̇ of
/// both ends: its own error is of order 4 in h, and that of the states comes on top, so that a method of order p gives order
/// min(p, 4). A component without a rate, where M is singular, is linear between the ends, of order min(p, 2).
///
/// [`interpolate`](Self::interpolate) evaluates it, [`sample`](Self::sample) runs along a list of times, and
/// [`until`](Self::until) to the zero of a function, where there is a momentum too. No step is shortened for any of them.
#[derive(Debug)]
#[must_use = "a trajectory does nothing until it is stepped"]
pub struct Trajectory<I> {
    integrator: I,
    state: State,
    grid: Grid,
    /// The start of the last step, if there was one.
    before: State,
    has_step: bool,
    /// q̇ at both ends of the last step, if they were asked for.
    rates: [Vec<f64>; 2],
    has_rates: bool,
    /// A point of the path.
    point: Vec<f64>,
    search: Search,
}

impl<I: Integrator> Trajectory<I> {
    /// Integrates from `initial` to `t_end` with step size `h`, the last step shortened where h does not divide. Time runs
    /// forward: for a motion backward in time integrate −f(−t, v).
    ///
    /// # Errors
    /// [`InputError`] if h, the times or the state are not finite, t_end lies before the start, or the dimensions do not fit.
    pub fn new(integrator: I, initial: State, h: f64, t_end: f64) -> Result<Self, InputError> {
        initial.check(integrator.dim())?;
        let grid = Grid::new(initial.t, h, t_end)?;
        let zeros = vec![0.0; initial.q.len()];
        Ok(Self {
            integrator,
            grid,
            before: initial.clone(),
            has_step: false,
            rates: [zeros.clone(), zeros.clone()],
            has_rates: false,
            search: Search::new(&initial),
            point: zeros,
            state: initial,
        })
    }

    /// The present state.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Work done so far.
    pub fn work(&self) -> Work {
        self.integrator.work()
    }

    /// The integrator, for what it alone can tell.
    pub fn integrator(&self) -> &I {
        &self.integrator
    }

    /// The integrator, to be given other settings.
    pub fn integrator_mut(&mut self) -> &mut I {
        &mut self.integrator
    }

    /// Goes on from the present state to another end, with another step size: after the end was reached, or after an error.
    ///
    /// ```
    /// # use lsvi::{State, StepError, Trajectory, classic::{RungeKutta, Tableau}, field};
    /// // Implicit Euler on v̇ = v² has no next state for steps longer than 1/4v.
    /// let method = RungeKutta::new(field!(1, |_t, v, dv| dv[0] = v[0] * v[0]), Tableau::implicit_euler())?;
    /// let mut run = Trajectory::new(method, State::new(0.0, vec![1.0]), 0.2, 0.5)?;
    /// while run.state().t < 0.5 {
    ///     if let Err(StepError::Solve { h, .. }) = run.step() {
    ///         run.resume(0.5 * h, 0.5)?;
    ///     }
    /// }
    /// # Ok::<(), StepError>(())
    /// ```
    ///
    /// # Errors
    /// [`InputError`] as for [`new`](Self::new); the trajectory is then as it was.
    pub fn resume(&mut self, h: f64, t_end: f64) -> Result<(), InputError> {
        self.grid = Grid::new(self.state.t, h, t_end)?;
        Ok(())
    }

    /// The integrator and the present state, from which [`new`](Self::new) goes on with another integrator.
    ///
    /// ```
    /// # use lsvi::{State, Trajectory, adaptive::{Radau, Tolerances}, classic::{RungeKutta, Tableau}, field};
    /// # let relaxation = || field!(1, |t, v, dv| dv[0] = (-v[0] + t.cos()) * 100.0);
    /// // The initial layer in short steps, the rest with a tolerance.
    /// let method = RungeKutta::new(relaxation(), Tableau::rk4())?;
    /// let mut layer = Trajectory::new(method, State::new(0.0, vec![0.0]), 1e-3, 0.1)?;
    /// while layer.step()?.is_some() {}
    /// let (_, state) = layer.into_parts();
    /// let method = Radau::new(relaxation(), Tolerances::new(1e-6, 1e-6)?)?;
    /// let end = Trajectory::new(method, state, 1.0, 1.0)?.observe(|_| {})?;
    /// assert!((end.q[0] - 1_f64.cos()).abs() < 0.01);
    /// # Ok::<(), lsvi::StepError>(())
    /// ```
    pub fn into_parts(self) -> (I, State) {
        (self.integrator, self.state)
    }

    /// Takes one step and lends the state at its end; `None` once t_end is reached.
    ///
    /// # Errors
    /// [`StepError`] with the time and the reason; the state stays at the last good one.
    pub fn step(&mut self) -> Result<Option<&State>, StepError> {
        if self.grid.next(self.state.t).is_none() {
            return Ok(None);
        }
        self.before.t = self.state.t;
        self.before.q.copy_from_slice(&self.state.q);
        self.before.p.copy_from_slice(&self.state.p);
        (self.has_step, self.has_rates) = (false, false);
        self.integrator.advance(&mut self.state, &self.grid)?;
        self.has_step = true;
        Ok(Some(&self.state))
    }

    /// Shows the present state to `observe`, then that at the end of every remaining step, and returns the last.
    ///
    /// # Errors
    /// [`StepError`] as for [`step`](Self::step).
    pub fn observe(mut self, mut observe: impl FnMut(&State)) -> Result<State, StepError> {
        observe(&self.state);
        while let Some(state) = self.step()? {
            observe(state);
        }
        Ok(self.state)
    }

    /// The states at the ends of the remaining steps, without the present one, each a copy, up to the first error.
    ///
    /// ```
    /// # use lsvi::{AutoField, FieldFn, Scalar, State, Trajectory, method_i};
    /// # struct Decay;
    /// # impl FieldFn for Decay {
    /// #     fn dim(&self) -> usize { 1 }
    /// #     fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) { dv[0] = -v[0]; }
    /// # }
    /// let trajectory = Trajectory::new(method_i(AutoField::new(Decay))?, State::new(0.0, vec![1.0]), 0.1, 1.0)?;
    /// let states = trajectory.states().collect::<Result<Vec<State>, _>>()?;
    /// assert_eq!(states.len(), 10);
    /// # Ok::<(), lsvi::StepError>(())
    /// ```
    pub fn states(mut self) -> impl Iterator<Item = Result<State, StepError>> {
        let mut failed = false;
        std::iter::from_fn(move || {
            if failed {
                return None;
            }
            let next = self.step().map(|state| state.cloned()).transpose();
            failed = matches!(next, Some(Err(_)));
            next
        })
    }

    /// Writes q at a time within the last step.
    ///
    /// # Errors
    /// [`TimeError::NoStep`] before the first step, [`TimeError::Outside`] if the last one does not contain `t`,
    /// [`SystemError::Dimension`] if `out` has the wrong length, or the reason why the method knows no rate q̇ at one of its ends.
    pub fn interpolate(&mut self, t: f64, out: &mut [f64]) -> Result<(), StepError> {
        let (from, to) = (self.before.t, self.state.t);
        if out.len() != self.state.q.len() {
            return Err(InputError::System(SystemError::Dimension {
                what: "out",
                expected: self.state.q.len(),
                found: out.len(),
            })
            .into());
        }
        if !self.has_step {
            return Err(InputError::Time(TimeError::NoStep { t }).into());
        }
        if !(from..=to).contains(&t) {
            return Err(InputError::Time(TimeError::Outside { t, from, to }).into());
        }
        // The ends are what they are, without rounding.
        if t == from || t == to {
            out.copy_from_slice(if t == to { &self.state.q } else { &self.before.q });
            return Ok(());
        }
        if let Some(written) = self.integrator.path(t, out) {
            return Ok(written?);
        }
        if !self.has_rates {
            let [start, end] = &mut self.rates;
            self.integrator.rate(&self.before, start)?;
            self.integrator.rate(&self.state, end)?;
            self.has_rates = true;
        }
        let (h, c) = (to - from, (t - from) / (to - from));
        // q₀ + c Δ + c (1 − c) [(1 − c)(h q̇₀ − Δ) − c (h q̇₁ − Δ)], Δ = q₁ − q₀: no cancellation beyond that of Δ.
        for (i, o) in out.iter_mut().enumerate() {
            let difference = self.state.q[i] - self.before.q[i];
            let [start, end] = [0, 1].map(|end| h * self.rates[end][i] - difference);
            let curved = c * (1.0 - c) * ((1.0 - c) * start - c * end);
            // Without a rate at either end it is linear.
            *o = self.before.q[i] + c * difference + if curved.is_nan() { 0.0 } else { curved };
        }
        Ok(())
    }

    /// Shows q at each of `times`, sorted and between the present time and t_end, to `observe`: the state itself where a step
    /// ends there, the dense output elsewhere. The trajectory is left at the end of the step that contains the last of them.
    ///
    /// # What a tolerance holds
    /// The adaptive method holds its tolerance at the ends of its steps, where it is of order 2s − 1; between them its dense
    /// output is of order s + 1 and loses digits, the more the tighter the tolerance is, and in the long steps of a stiff problem all of
    /// them: v that follows a slow motion is right at the ends of steps which a polynomial does not follow. Where they matter let steps end at the
    /// times, or be no longer than the motion allows ([`h_max`](crate::adaptive::Options::h_max)), by [`stop_at`](crate::adaptive::Radau::stop_at):
    ///
    /// ```
    /// use lsvi::{State, Trajectory, adaptive::{Radau, Tolerances}, field};
    ///
    /// let times: Vec<f64> = (1..100).map(|k| 0.1 * f64::from(k)).collect();
    /// let largest_error = |stops: &[f64]| -> Result<f64, lsvi::StepError> {
    ///     let circle = field!(2, |_t, v, dv| { dv[0] = v[1]; dv[1] = -v[0]; });
    ///     let mut method = Radau::new(circle, Tolerances::new(1e-12, 1e-12)?)?;
    ///     method.stop_at(stops)?;
    ///     let mut run = Trajectory::new(method, State::new(0.0, vec![1.0, 0.0]), 10.0, 10.0)?;
    ///     let mut largest = 0.0_f64;
    ///     run.sample(&times, |t, v| largest = largest.max((v[0] - t.cos()).abs()))?;
    ///     Ok(largest)
    /// };
    /// assert!(largest_error(&[])? > 1e-10);
    /// assert!(largest_error(&times)? < 1e-11);
    /// # Ok::<(), lsvi::StepError>(())
    /// ```
    ///
    /// # Example
    /// ```
    /// # use lsvi::{AutoField, FieldFn, Scalar, State, Trajectory, adaptive::{Radau, Tolerances}};
    /// # struct Decay;
    /// # impl FieldFn for Decay {
    /// #     fn dim(&self) -> usize { 1 }
    /// #     fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) { dv[0] = -v[0]; }
    /// # }
    /// let method = Radau::new(AutoField::new(Decay), Tolerances::new(1e-8, 1e-8)?)?;
    /// let mut trajectory = Trajectory::new(method, State::new(0.0, vec![1.0]), 5.0, 5.0)?;
    /// trajectory.sample(&[0.5, 1.0, 4.0], |t, v| assert!((v[0] - f64::exp(-t)).abs() < 1e-5))?;
    /// # Ok::<(), lsvi::StepError>(())
    /// ```
    ///
    /// # Errors
    /// [`TimeError::SaveTime`] for a time out of order or outside the interval, before any step is taken; [`StepError`] as for
    /// [`step`](Self::step) and [`interpolate`](Self::interpolate).
    pub fn sample(&mut self, times: &[f64], mut observe: impl FnMut(f64, &[f64])) -> Result<(), StepError> {
        let mut last = if self.has_step { self.before.t } else { self.state.t };
        for (index, &t) in times.iter().enumerate() {
            let inside = t >= last && t <= self.grid.t_end();
            if !inside {
                return Err(
                    InputError::Time(TimeError::SaveTime { index, t, from: last, to: self.grid.t_end() }).into()
                );
            }
            last = t;
        }
        for &t in times {
            while t > self.state.t && self.step()?.is_some() {}
            if t >= self.state.t {
                observe(t, &self.state.q);
                continue;
            }
            let mut point = std::mem::take(&mut self.point);
            let written = self.interpolate(t, &mut point);
            self.point = point;
            written?;
            observe(t, &self.point);
        }
        Ok(())
    }
}
