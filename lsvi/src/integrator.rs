//! Stepping: states, the time grid and integrators.

use auto_impl::auto_impl;

use crate::error::{InputError, StepError, TimeError, check_step, check_time, check_vector};
pub use crate::newton::Work;

/// A point of a trajectory.
///
/// In the least-squares formulation the unknown v of v̇ = f(t, v) is the configuration `q`. Integrators that are not
/// variational leave `p` as it is.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct State {
    /// Time.
    pub t: f64,
    /// Configuration q, length n.
    pub q: Vec<f64>,
    /// Conjugate discrete momentum p, length n.
    pub p: Vec<f64>,
}

impl State {
    /// The configuration `q` at time `t` with zero momentum.
    pub fn new(t: f64, q: Vec<f64>) -> Self {
        let p = vec![0.0; q.len()];
        Self { t, q, p }
    }

    /// The same with momentum `p`.
    #[must_use]
    pub fn with_momentum(self, p: Vec<f64>) -> Self {
        Self { p, ..self }
    }

    pub(crate) fn check(&self, dim: usize) -> Result<(), InputError> {
        check_vector("q", &self.q, dim)?;
        check_vector("p", &self.p, dim)?;
        check_time(self.t)
    }
}

/// Time differences on a grid are exact to a few ulp of the largest time.
const SLACK: f64 = 8.0 * f64::EPSILON;

/// The times t₀ + n h, the last moved to `t_end` where h does not divide the interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    t0: f64,
    h: f64,
    t_end: f64,
}

/// One step of a [`Grid`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridStep {
    /// Size of the step.
    pub h: f64,
    /// Time at its end, without the roundoff of a running sum.
    pub end: f64,
}

impl Grid {
    /// Steps of size `h` from `t0` to `t_end`.
    ///
    /// # Errors
    /// [`InputError`] unless h > 0, t_end ≥ t0, all are finite, and h is resolved: |t|/h at most 2⁴⁷.
    pub fn new(t0: f64, h: f64, t_end: f64) -> Result<Self, InputError> {
        check_step(h)?;
        check_time(t0)?;
        if !(t_end.is_finite() && t_end >= t0) {
            return Err(InputError::Time(TimeError::EndTime { t0, t_end }));
        }
        // Four times what two times of one grid point may differ by.
        if t_end > t0 && h < 4.0 * SLACK * t0.abs().max(t_end.abs()) {
            return Err(InputError::Time(TimeError::Unresolvable { t0, t_end, h }));
        }
        Ok(Self { t0, h, t_end })
    }

    /// The nominal step size.
    pub fn h(&self) -> f64 {
        self.h
    }

    /// The last time.
    pub fn t_end(&self) -> f64 {
        self.t_end
    }

    /// The step that starts at `t`, which need not be a grid point; `None` at the end.
    pub fn next(&self, t: f64) -> Option<GridStep> {
        let slack = SLACK * self.t0.abs().max(self.t_end.abs());
        if t >= self.t_end - slack {
            return None;
        }
        let n = ((t - self.t0 + slack) / self.h).floor();
        let on_grid = (self.t0 + n * self.h - t).abs() <= slack;
        let target = self.t0 + (n + 1.0) * self.h;
        let step = if on_grid { self.h } else { target - t };
        if target < self.t_end - slack {
            Some(GridStep { h: step, end: target })
        } else if target <= self.t_end + slack {
            Some(GridStep { h: step, end: self.t_end })
        } else {
            Some(GridStep { h: self.t_end - t, end: self.t_end })
        }
    }
}

/// A method that advances a state along a grid, one row of output at a time.
///
/// Fixed-step methods take one grid step per call. An adaptive method may stop short of the next grid point, and a method
/// that finds several steps at once hands them out one by one.
#[auto_impl(&mut, Box)]
pub trait Integrator {
    /// Degrees of freedom n.
    fn dim(&self) -> usize;

    /// Advances `state` by one row; does nothing at the end of the grid.
    ///
    /// # Errors
    /// [`StepError`]; the state is then as it was before the call.
    fn advance(&mut self, state: &mut State, grid: &Grid) -> Result<(), StepError>;

    /// Work done so far.
    fn work(&self) -> Work;

    /// Writes q̇ at `state`, from the equation of motion or the momentum: what the dense output of a
    /// [`Trajectory`](crate::Trajectory) is made of; NaN for a component that a singular M leaves without a rate. It may
    /// allocate.
    ///
    /// # Errors
    /// [`StepError`] if f is not finite or the mass matrix of L has no inverse there; [`TimeError::NoRate`] by default.
    fn rate(&mut self, _state: &State, _out: &mut [f64]) -> Result<(), StepError> {
        Err(InputError::Time(TimeError::NoRate).into())
    }

    /// Writes q at a time within the last step, if the method has a dense output of its own.
    fn path(&self, _t: f64, _out: &mut [f64]) -> Option<Result<(), InputError>> {
        None
    }

    /// Writes the state at a time within the step that starts at `from`, (q, p) to the order of the method, by a shorter step
    /// from there. `None`, the default, of a method whose steps depend on more than the state they start from.
    fn shorter_step(&mut self, _from: &State, _t: f64, _to: &mut State) -> Option<Result<(), StepError>> {
        None
    }
}

/// A method whose step depends on nothing but the state it starts from.
#[auto_impl(&mut, Box)]
pub trait OneStep: Integrator {
    /// Replaces (q, p) at time `t` by their values at `t + h`.
    ///
    /// # Errors
    /// [`StepError`]; q and p are then as they were before the call.
    fn step(&mut self, t: f64, h: f64, q: &mut [f64], p: &mut [f64]) -> Result<(), StepError>;
}

/// [`Integrator::advance`] of a one-step method: one grid step.
pub(crate) fn advance_one_step(method: &mut impl OneStep, state: &mut State, grid: &Grid) -> Result<(), StepError> {
    if let Some(step) = grid.next(state.t) {
        method.step(state.t, step.h, &mut state.q, &mut state.p)?;
        state.t = step.end;
    }
    Ok(())
}

/// [`Integrator::shorter_step`] of a one-step method, of a length above rounding.
pub(crate) fn shorter_step(
    method: &mut impl OneStep,
    from: &State,
    t: f64,
    to: &mut State,
) -> Option<Result<(), StepError>> {
    to.clone_from(from);
    to.t = t;
    Some(method.step(from.t, t - from.t, &mut to.q, &mut to.p))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_a_grid_start_anywhere_and_end_on_it() {
        let grid = Grid::new(1.0, 0.25, 2.125).expect("resolved");
        let next = |t: f64| grid.next(t).map(|step| (step.h, step.end));
        assert_eq!(next(1.0), Some((0.25, 1.25)));
        assert_eq!(next(1.5), Some((0.25, 1.75)));
        assert_eq!(next(1.5_f64.next_up()), Some((0.25, 1.75)), "a grid point with the rounding of a sum");
        assert_eq!(next(1.375), Some((0.125, 1.5)), "from between two points to the next one");
        assert_eq!(next(2.0), Some((0.125, 2.125)), "the last step is shorter");
        assert_eq!(next(2.0625), Some((0.0625, 2.125)));
        assert_eq!(next(2.125), None);
        assert_eq!(next(2.125_f64.next_down()), None);
    }

    /// Steps below the slack of times would be taken for two at a time.
    #[test]
    fn a_grid_has_as_many_steps_as_fit_or_is_refused() {
        for t0 in [0.0, 1.0, 1.7e9, -1e6] {
            let (ulp, mut is_resolved) = (f64::EPSILON * 1.7e9_f64.max(f64::abs(t0)), false);
            for k in 1..200 {
                let (h, steps) = (f64::from(k) * ulp, 10);
                let Ok(grid) = Grid::new(t0, h, t0 + f64::from(steps) * h + if t0 == 0.0 { 1.7e9 } else { 0.0 }) else {
                    continue;
                };
                is_resolved = true;
                let mut t = t0;
                for n in 1..=steps {
                    let step = grid.next(t).expect("not the end");
                    assert!((step.h - h).abs() <= 8.0 * ulp && step.h > 0.5 * h, "{t0}, {h}, step {n}: {step:?}");
                    t = step.end;
                }
                assert!((t - (t0 + f64::from(steps) * h)).abs() <= 8.0 * ulp, "{t0}, {h}: {t}");
            }
            assert!(is_resolved, "{t0}");
        }
    }

    #[test]
    fn the_last_of_equal_steps_has_their_length_and_ends_where_it_was_said() {
        // 3 × 0.1 is above 0.3, 49 × 1/49 below 1.
        for (h, steps, end) in [(0.1, 3, 0.3), (1.0 / 49.0, 49, 1.0)] {
            assert_ne!(f64::from(steps) * h, end);
            let grid = Grid::new(0.0, h, end).expect("resolved");
            assert_eq!(grid.next(f64::from(steps - 1) * h), Some(GridStep { h, end }));
        }
    }
}
